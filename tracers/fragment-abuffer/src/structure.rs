//! The structure of one scene from one viewpoint.

use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, Layers, Ledger, MemoryEntry, MemoryReport, Parameters, PhaseClock, Projection,
    Sampling, Structure, TraceJob, Tracer, TracerError, Update, View, Viewpoint,
};
use tracebench_kit::{Reads, check_limits, grow};
use tracebench_shaders::fragment_abuffer::Trace;

use crate::arrays::Arrays;
use crate::build::{Pipelines, build_bytes};
use crate::description::{FragmentParameters, NO_REFIT};
use crate::layout::{Layout, MOST_VIEWS, Storage, TracedView};
use crate::objects::Objects;
use crate::parts::{Parts, Taken};
use crate::trace::MarchSettings;

/// The tracer.
pub struct FragmentAbuffer {
    pipelines: Arc<Pipelines>,
}

/// The fragments of all views.
pub(crate) struct FragmentStructure {
    pub pipelines: Arc<Pipelines>,
    pub layout: Layout,
    pub parts: Parts,
    pub arrays: Arrays,
    /// Of the scene's bounds, scene units.
    pub diagonal: f64,
    triangle_count: u32,
    objects: Option<Objects>,
}

impl FragmentAbuffer {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self { pipelines: Arc::new(Pipelines::new(gpu)?) })
    }

    /// The fragments of every view: counted by passes that store none, by no phase of the build.
    fn count(&self, geometry: &Geometry, layout: &Layout) -> Result<Vec<u32>, TracerError> {
        if !layout.one_layer {
            return self.pipelines.tally(layout, geometry);
        }
        // Which fragments are the nearest the depth bounds must tell first.
        let gpu = &*self.pipelines.gpu;
        let parts = Parts::new(gpu, &self.pipelines.sums, layout, true)?;
        let mut clock = PhaseClock::new(Some(gpu));
        self.pipelines.fill(layout, &parts, geometry, None, &mut clock)?;
        clock.finish()?;
        Ok(parts.taken(gpu)?.into_iter().map(|taken| taken.fragments).collect())
    }

    /// Buffers with room for the fragments of every view, one of a kind or one a view.
    fn parts_for(&self, layout: &Layout, counts: &[u32], by_view: bool) -> Result<Parts, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let mut parts = Parts::new(gpu, &self.pipelines.sums, layout, by_view)?;
        let whole = counts.iter().fold(0, |sum: u32, count| sum.saturating_add(*count));
        parts.set_capacities(gpu, layout, if by_view { counts } else { std::slice::from_ref(&whole) })?;
        Ok(parts)
    }

    /// Whether the device can bind a buffer of a kind for every view at once.
    fn binds_every_view(&self, layout: &Layout) -> bool {
        let (contiguous, planes) = (layout.kind.is_contiguous(), layout.planes);
        let least = Trace::Split { contiguous, planes, surfaces: false, counters: false };
        check_limits(&self.pipelines.gpu, least.into()).is_ok()
    }

    pub(crate) fn build_structure(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<FragmentStructure, TracerError> {
        let parameters = FragmentParameters::try_from(parameters)?;
        let layout = Layout::new(viewpoint, &parameters);
        let objects = objects_for(&self.pipelines.gpu, &layout, geometry, None)?;
        // One buffer of a kind where the device can bind it, else one a view if it can bind all of these at once or reads from textures.
        let counts = self.count(geometry, &layout)?;
        let parts = match self.parts_for(&layout, &counts, false) {
            Err(TracerError::TooLarge { .. })
                if layout.views.len() > 1 && (parameters.reads == Reads::Texture || self.binds_every_view(&layout)) =>
            {
                self.parts_for(&layout, &counts, true)?
            }
            made => made?,
        };
        let arrays = Arrays::new(&self.pipelines.gpu, parameters.reads, &parts, None)?;
        self.pipelines.fill(&layout, &parts, geometry, objects.as_ref(), clock)?;
        arrays.record_copies(clock)?;
        Ok(FragmentStructure {
            pipelines: Arc::clone(&self.pipelines),
            layout,
            parts,
            arrays,
            diagonal: geometry.diagonal(),
            triangle_count: geometry.triangles.len() as u32,
            objects,
        })
    }
}

fn objects_for(
    gpu: &Gpu,
    layout: &Layout,
    geometry: &Geometry,
    there: Option<&Objects>,
) -> Result<Option<Objects>, TracerError> {
    let wanted = layout.by_boxes && layout.has_bounds();
    if wanted { Objects::new(gpu, geometry, there).map(Some) } else { Ok(None) }
}

impl Tracer for FragmentAbuffer {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        Ok(Box::new(self.build_structure(geometry, viewpoint, parameters, clock)?))
    }
}

impl FragmentStructure {
    fn rebuild(&mut self, geometry: &Geometry, layout: Layout, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        let gpu = &*self.pipelines.gpu;
        let objects = objects_for(gpu, &layout, geometry, self.objects.as_ref())?;
        let sizes = |layout: &Layout| (layout.drawn_by, layout.views.iter().map(|view| view.size).collect::<Vec<_>>());
        let new_parts = match sizes(&layout) == sizes(&self.layout) {
            true => None,
            false => {
                let by_view = self.parts.is_by_view();
                let mut parts = Parts::new(gpu, &self.pipelines.sums, &layout, by_view)?;
                let capacities: Vec<u32> = self.parts.parts.iter().map(|part| part.capacity).collect();
                parts.set_capacities(gpu, &layout, &capacities)?;
                Some(parts)
            }
        };
        let parts = new_parts.as_ref().unwrap_or(&self.parts);
        let arrays = Arrays::new(gpu, self.arrays.reads(), parts, Some(&self.arrays))?;
        self.pipelines.fill(&layout, parts, geometry, objects.as_ref(), clock)?;
        arrays.record_copies(clock)?;
        self.arrays = arrays;
        if let Some(parts) = new_parts {
            self.parts = parts;
        }
        self.objects = objects;
        (self.layout, self.diagonal) = (layout, geometry.diagonal());
        self.triangle_count = geometry.triangles.len() as u32;
        Ok(())
    }
}

impl Structure for FragmentStructure {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        match update {
            Update::Rebuild => {
                let layout = Layout::new(viewpoint, &FragmentParameters::try_from(parameters)?);
                self.rebuild(geometry, layout, clock)
            }
            Update::Refit => Err(TracerError::Unsupported(NO_REFIT.to_owned())),
            Update::Reuse => Ok(()),
        }
    }

    fn make_room(&mut self) -> Result<bool, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let taken = self.parts.taken(gpu)?;
        let fits = self.parts.parts.iter().zip(&taken).all(|(part, taken)| taken.fragments <= part.capacity);
        if fits {
            return check_order(&taken).map(|()| false);
        }
        let needed: Vec<u32> = taken.iter().map(|taken| taken.fragments).collect();
        grow(&needed, |room| {
            self.parts.set_capacities(gpu, &self.layout, room)?;
            self.arrays = Arrays::new(gpu, self.arrays.reads(), &self.parts, Some(&self.arrays))?;
            Ok(())
        })?;
        Ok(true)
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        // Any hit is the same march: its first hit is its nearest.
        self.record(&job, hits, None, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.count(&job, hits)
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

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let FragmentParameters { rays_per_lane, .. } = FragmentParameters::try_from(job.parameters)?;
        // One more for the rays that lanes of several leave.
        let searches = if rays_per_lane > 1 { 2 } else { 1 };
        let uniforms = [
            ("storage", size_of::<Storage>()),
            ("search", searches * size_of::<MarchSettings>()),
            ("views", MOST_VIEWS * size_of::<TracedView>()),
        ];
        Ok(uniforms.map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).to_vec())
    }

    fn samplings(&self, parameters: &Parameters) -> Result<Vec<Sampling>, TracerError> {
        let layers = if self.layout.one_layer { Layers::Nearest } else { Layers::All };
        let march = FragmentParameters::try_from(parameters)?.image_march(self.diagonal);
        let of = |view: &View| Sampling { march, ..Sampling::new(Projection::Perspective(*view), layers) };
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
