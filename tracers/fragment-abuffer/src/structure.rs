//! The structure of one scene from one viewpoint.

use std::sync::Arc;

use tracebench_api::{
    Geometry, Layers, Ledger, MemoryEntry, MemoryReport, Parameters, Projection, SampledImage, TraceJob, TracerError,
    View,
};
use tracebench_kit::{BuildJob, DeviceStructure, DeviceTracer, MemoryAccess, check_limits, grow, untimed};
use tracebench_shaders::fragment_abuffer::Trace;

use crate::arrays::Arrays;
use crate::build::{Pipelines, build_bytes};
use crate::description::{FragmentParameters, NO_REFIT};
use crate::layout::{Layout, MAX_VIEWS, Storage, TracedView};
use crate::objects::Objects;
use crate::parts::{Parts, Taken};
use crate::trace::MarchSettings;

/// The tracer.
pub type FragmentAbuffer = DeviceTracer<FragmentStructure>;

/// The fragments of all views.
pub struct FragmentStructure {
    pub(crate) pipelines: Arc<Pipelines>,
    pub(crate) layout: Layout,
    pub(crate) parts: Parts,
    pub(crate) arrays: Arrays,
    /// Of the scene's bounds, scene units.
    pub(crate) diagonal: f64,
    triangle_count: u32,
    objects: Option<Objects>,
}

impl Pipelines {
    /// The fragments of every view: counted by passes that store none, by no phase of the build.
    fn count(&self, geometry: &Geometry, layout: &Layout) -> Result<Vec<u32>, TracerError> {
        if !layout.one_layer {
            return self.tally(layout, geometry);
        }
        // Which fragments are the nearest the depth bounds must tell first.
        let gpu = &*self.gpu;
        let parts = Parts::new(gpu, &self.sums, layout, true)?;
        untimed(gpu, |clock| self.fill(layout, &parts, geometry, None, clock))?;
        Ok(parts.taken(gpu)?.into_iter().map(|taken| taken.fragments).collect())
    }

    /// Buffers with room for so many fragments, one of a kind or one a view.
    fn parts(&self, layout: &Layout, counts: &[u32], by_view: bool) -> Result<Parts, TracerError> {
        let mut parts = Parts::new(&self.gpu, &self.sums, layout, by_view)?;
        parts.set_capacities(&self.gpu, layout, counts)?;
        Ok(parts)
    }

    /// Buffers with room for the fragments of every view: one of a kind where the device can bind it, else one a view if it can bind all
    /// of these at once or reads from textures.
    fn counted_parts(
        &self,
        layout: &Layout,
        geometry: &Geometry,
        memory_access: MemoryAccess,
    ) -> Result<Parts, TracerError> {
        let counts = self.count(geometry, layout)?;
        let whole = counts.iter().fold(0, |sum: u32, count| sum.saturating_add(*count));
        match self.parts(layout, &[whole], false) {
            Err(TracerError::TooLarge { .. })
                if layout.views.len() > 1
                    && (memory_access == MemoryAccess::Texture || self.binds_every_view(layout)) =>
            {
                self.parts(layout, &counts, true)
            }
            made => made,
        }
    }

    /// Whether the device can bind a buffer of a kind for every view at once.
    fn binds_every_view(&self, layout: &Layout) -> bool {
        let (contiguous, planes) = (layout.kind.is_contiguous(), layout.planes);
        let least = Trace::Split { contiguous, planes, surfaces: false, counters: false };
        check_limits(&self.gpu, least.into(), &["trace"]).is_ok()
    }
}

impl DeviceStructure for FragmentStructure {
    type Pipelines = Pipelines;

    const NO_REFIT: &'static str = NO_REFIT;

    fn build(pipelines: &Arc<Pipelines>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, viewpoint, parameters, before, clock } = job;
        let gpu = &*pipelines.gpu;
        let parameters = FragmentParameters::try_from(parameters)?;
        let layout = Layout::new(viewpoint, &parameters);
        let there = before.and_then(|before| before.objects.as_ref());
        let has_objects = layout.by_boxes && layout.has_bounds();
        let objects = has_objects.then(|| Objects::new(gpu, geometry, there)).transpose()?;
        let sizes =
            |layout: &Layout| (layout.raster_backend, layout.views.iter().map(|view| view.size).collect::<Vec<_>>());
        let parts = match before {
            Some(before) if sizes(&layout) == sizes(&before.layout) => before.parts.clone(),
            Some(Self { parts: Parts { parts, .. }, .. }) => {
                let capacities: Vec<u32> = parts.iter().map(|part| part.capacity).collect();
                pipelines.parts(&layout, &capacities, parts.len() > 1)?
            }
            None => pipelines.counted_parts(&layout, geometry, parameters.memory_access)?,
        };
        let arrays = Arrays::new(gpu, parameters.memory_access, &parts, before.map(|before| &before.arrays))?;
        pipelines.fill(&layout, &parts, geometry, objects.as_ref(), clock)?;
        arrays.record_copies(clock)?;
        let (diagonal, triangle_count) = (geometry.diagonal(), geometry.triangles.len() as u32);
        Ok(Self { pipelines: Arc::clone(pipelines), layout, parts, arrays, diagonal, triangle_count, objects })
    }

    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let taken = self.parts.taken(gpu)?;
        let fits = self.parts.parts.iter().zip(&taken).all(|(part, taken)| taken.fragments <= part.capacity);
        if fits {
            return check_order(&taken).map(|()| false);
        }
        let needed: Vec<u32> = taken.iter().map(|taken| taken.fragments).collect();
        grow(&needed, |room| {
            self.parts.set_capacities(gpu, &self.layout, room)?;
            self.arrays = Arrays::new(gpu, self.arrays.memory_access(), &self.parts, Some(&self.arrays))?;
            Ok(())
        })?;
        Ok(true)
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        // Of a lost device nothing is known to be used.
        let nothing = || vec![Taken { fragments: 0, unordered: 0 }; self.parts.parts.len()];
        let taken = self.parts.taken(&self.pipelines.gpu).unwrap_or_else(|_| nothing());
        self.parts.enter(&self.layout, &taken, &mut ledger);
        self.arrays.enter(&mut ledger);
        if let Some(objects) = &self.objects {
            objects.enter(&mut ledger);
        }
        ledger.borrow_transient(build_bytes(&self.layout, &self.parts, self.triangle_count));
        // Fragments have all that hits and surfaces need.
        ledger.report(0)
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        FragmentParameters::try_from(job.parameters)?;
        let uniforms = [
            ("storage", size_of::<Storage>()),
            ("search", size_of::<MarchSettings>()),
            ("views", MAX_VIEWS * size_of::<TracedView>()),
        ];
        Ok(uniforms.map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).to_vec())
    }

    fn samplings(&self, parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        let layers = if self.layout.one_layer { Layers::Nearest } else { Layers::All };
        let march = FragmentParameters::try_from(parameters)?.image_march(self.diagonal);
        let of = |view: &View| SampledImage { march, ..SampledImage::new(Projection::Perspective(*view), layers) };
        Ok(self.layout.views.iter().map(of).collect())
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.check(geometry)
    }
}

/// Whether the driver let every list be ordered.
pub(crate) fn check_order(taken: &[Taken]) -> Result<(), TracerError> {
    match taken.iter().map(|taken| u64::from(taken.unordered)).sum::<u64>() {
        0 => Ok(()),
        lists => Err(TracerError::Failed(format!(
            "{lists} lists have more fragments than this driver's limit of loops lets be ordered: turn up \
             fragment-abuffer.buckets, or choose fragment-abuffer.storage=dllb or layers=one"
        ))),
    }
}
