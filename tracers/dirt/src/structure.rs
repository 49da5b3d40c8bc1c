//! The structure of one scene from one viewpoint.

use std::sync::Arc;

use tracebench_api::{
    Geometry, Gpu, Layers, Ledger, MemoryEntry, MemoryReport, Parameters, PhaseClock, Projection, SampledImage,
    Structure, TraceJob, Tracer, TracerError, View, Viewpoint,
};
use tracebench_kit::{
    BuildJob, Built, DevicePipelines, DeviceStructure, MemoryAccess, Readable, SurfaceGeometry, ViewUniform, grow,
    record_copies, untimed,
};

use crate::build::{Buffers, DEPTH_BOUNDS, Filling, HEADS, NODE_BYTES, NODE_COUNT, nodes_name};
use crate::description::{Clip, Coverage, DirtParameters, Lists, NO_REFIT};
use crate::fetch::MaskMemory;
use crate::layout::{Layout, MAX_VIEWS, TileGrid, TraceSettings};
use crate::packed::PackedStructure;
use crate::pipelines::Pipelines;
use crate::setup::TriangleSetup;
use crate::shadow_map::{ShadowMap, lookup_memory};
use crate::visibility::Frame;

/// The tracer.
pub struct Dirt {
    pipelines: Arc<Pipelines>,
}

/// What of the scene a structure needs to trace.
pub(crate) struct Resident {
    pub surfaces: SurfaceGeometry,
    pub triangle_count: u32,
}

impl Resident {
    pub(crate) fn of(geometry: &Geometry) -> Result<Self, TracerError> {
        Ok(Self { surfaces: SurfaceGeometry::of(geometry)?, triangle_count: geometry.triangles.len() as u32 })
    }
}

/// Depth bounds and lists.
pub(crate) struct DirtStructure {
    pub pipelines: Arc<Pipelines>,
    pub layout: Layout,
    pub filling: Filling,
    pub buffers: Buffers,
    /// What searches read, in buffers or textures.
    pub arrays: Vec<Readable>,
    pub geometry: Resident,
    pub mask_memory: MaskMemory,
    /// What the camera's frame shows, if that was asked for.
    pub frame: Option<Frame>,
    /// What the light sees, if that was asked for.
    pub shadow_map: Option<ShadowMap>,
}

impl Dirt {
    /// Pipelines are created when they are first needed.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] if a stage of the device cannot bind what every build and trace binds.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self { pipelines: Arc::new(Pipelines::new(gpu)?) })
    }
}

impl Tracer for Dirt {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        if DirtParameters::try_from(parameters)?.lists == Lists::Linked {
            let job = BuildJob { geometry, viewpoint, parameters, before: None, clock };
            return Ok(Box::new(Built::<DirtStructure>::new(&self.pipelines, job)?));
        }
        let job = BuildJob { geometry, viewpoint, parameters, before: None, clock };
        Ok(Box::new(Built::<PackedStructure>::new(&self.pipelines, job)?))
    }
}

impl Pipelines {
    /// Buffers with room for the triangles that views will be drawn with and the nodes that a build will take: counted by builds without
    /// room, by no phase of the first build.
    fn counted_buffers(&self, layout: &Layout, scene: &Resident, filling: Filling) -> Result<Buffers, TracerError> {
        let gpu = &*self.gpu;
        let mut buffers = Buffers::new(self, layout, scene.triangle_count, 0, None)?;
        untimed(gpu, |clock| self.set_up(layout, &buffers, scene, clock))?;
        let drawn = buffers.setup.counts(gpu)?;
        buffers.setup.grow_on_overflow(gpu, &drawn)?;
        let nodes = self.count_nodes(layout, &buffers, scene, filling)?;
        buffers.set_capacity(gpu, nodes)?;
        Ok(buffers)
    }

    /// The nodes that a build takes, by one that has no room for them.
    fn count_nodes(
        &self,
        layout: &Layout,
        buffers: &Buffers,
        scene: &Resident,
        filling: Filling,
    ) -> Result<u32, TracerError> {
        untimed(&self.gpu, |clock| self.build(layout, buffers, scene, filling, clock))?;
        taken(&self.gpu, buffers)
    }
}

/// Nodes asked for by the last build.
pub(crate) fn taken(gpu: &Gpu, buffers: &Buffers) -> Result<u32, TracerError> {
    let read = gpu.read(&buffers.taken, 4)?;
    Ok(bytemuck::pod_collect_to_vec::<u8, u32>(&read)[0])
}

impl DirtStructure {
    /// What searches read from.
    pub(crate) fn memory_access(&self) -> MemoryAccess {
        self.arrays[0].memory_access()
    }
}

impl DeviceStructure for DirtStructure {
    type Pipelines = Pipelines;

    const NO_REFIT: &'static str = NO_REFIT;

    fn build(pipelines: &Arc<Pipelines>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, viewpoint, parameters, before, clock } = job;
        let parameters = &DirtParameters::try_from(parameters)?;
        let (layout, scene) = (Layout::new(viewpoint, parameters), Resident::of(geometry)?);
        let (views, triangles) = (layout.views.len(), scene.triangle_count);
        let filling = Filling {
            conservative: parameters.coverage == Coverage::Conservative,
            by_plane: parameters.clip == Clip::Plane,
        };
        let sizes = |layout: &Layout| (layout.tiles, layout.buckets, layout.views.len(), layout.raster_backend);
        let buffers = match before.map(|before| (&before.buffers, sizes(&before.layout) == sizes(&layout))) {
            None => pipelines.counted_buffers(&layout, &scene, filling)?,
            Some((there, false)) => {
                Buffers::new(pipelines, &layout, triangles, there.node_capacity, Some(&there.setup))?
            }
            Some((there, true)) if there.setup.serves(views, triangles) => there.clone(),
            Some((there, true)) => {
                let sums = pipelines.prefix_sum()?;
                let mut buffers = there.clone();
                buffers.setup = TriangleSetup::new(&pipelines.gpu, &sums, views, triangles, Some(&there.setup))?;
                buffers
            }
        };
        let there = before.map_or(&[][..], |before| &before.arrays);
        let arrays = buffers.arrays(&pipelines.gpu, parameters.memory_access, there)?;
        pipelines.build(&layout, &buffers, &scene, filling, clock)?;
        record_copies(&arrays, clock)?;
        let frame = before.and_then(|before| before.frame.as_ref());
        let frame = pipelines.show(viewpoint, parameters, &scene, frame, clock)?;
        let shadow_map = before.and_then(|before| before.shadow_map.as_ref());
        let shadow_map = pipelines.draw_shadow_map(geometry, viewpoint, parameters, &scene, shadow_map, clock)?;
        let mask_memory = before.map_or_else(MaskMemory::default, |before| before.mask_memory.clone());
        let (pipelines, geometry) = (Arc::clone(pipelines), scene);
        Ok(Self { pipelines, layout, filling, buffers, arrays, geometry, mask_memory, frame, shadow_map })
    }

    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        let pipelines = Arc::clone(&self.pipelines);
        let gpu = &*pipelines.gpu;
        let drawn = self.buffers.setup.counts(gpu)?;
        let all_drawn = self.buffers.setup.holds(&drawn);
        let nodes = if all_drawn {
            taken(gpu, &self.buffers)?
        } else {
            // What was not drawn was not counted.
            self.buffers.setup.grow_on_overflow(gpu, &drawn)?;
            pipelines.count_nodes(&self.layout, &self.buffers, &self.geometry, self.filling)?
        };
        if nodes <= self.buffers.node_capacity {
            return Ok(!all_drawn);
        }
        grow(&[nodes], |room| self.buffers.set_capacity(gpu, room[0]))?;
        self.arrays = self.buffers.arrays(gpu, self.memory_access(), &self.arrays)?;
        Ok(true)
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        let buffers = &self.buffers;
        let gpu = &*self.pipelines.gpu;
        let used = taken(gpu, buffers).unwrap_or(0).min(buffers.node_capacity);
        let mut used_bytes = u64::from(used) * NODE_BYTES;
        let ([_, bounds], [_, heads]) = (self.layout.bounds_bytes(), self.layout.heads_bytes());
        ledger.keep(DEPTH_BOUNDS, buffers.bounds.size(), bounds);
        ledger.keep(HEADS, buffers.heads.size(), heads);
        ledger.keep(NODE_COUNT, buffers.taken.size(), buffers.taken.size());
        for (part, buffer) in buffers.nodes.iter().enumerate() {
            let of_part = used_bytes.min(buffer.size());
            ledger.keep(&nodes_name(part), buffer.size(), of_part);
            used_bytes -= of_part;
        }
        buffers.setup.enter(&mut ledger, &buffers.setup.counts(gpu).unwrap_or_default());
        if let Some(attachment) = &buffers.attachment {
            attachment.enter(&mut ledger);
        }
        self.arrays.iter().for_each(|array| array.enter(&mut ledger));
        ledger.borrow_transient(self.layout.build_bytes(self.geometry.triangle_count));
        if let Some(frame) = &self.frame {
            frame.enter(&mut ledger);
        }
        if let Some(map) = &self.shadow_map {
            map.enter(&mut ledger);
        }
        ledger.report(0).with_surface_geometry(self.geometry.surfaces.bytes)
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let parameters = DirtParameters::try_from(job.parameters)?;
        if self.shadow_map.as_ref().is_some_and(|map| map.answers(job)) {
            return Ok(lookup_memory());
        }
        let uniforms = [
            ("grid", size_of::<TileGrid>()),
            ("search", size_of::<TraceSettings>()),
            ("views", MAX_VIEWS * size_of::<ViewUniform>()),
        ];
        let mut parts = uniforms.map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).to_vec();
        parts.extend(self.surface_memory(job, parameters.fetch));
        Ok(parts)
    }

    fn samplings(&self, _parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        let of = |view: &View| SampledImage::new(Projection::Perspective(*view), Layers::All);
        Ok(self.layout.views.iter().map(of).collect())
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.check(geometry)
    }
}
