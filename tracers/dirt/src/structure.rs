//! The structure of one scene from one viewpoint.

use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, Layers, Ledger, MemoryEntry, MemoryReport, Parameters, PhaseClock, Projection,
    Sampling, Structure, TraceJob, Tracer, TracerError, Update, View, Viewpoint,
};
use tracebench_kit::{Readable, Reads, SurfaceGeometry, ViewUniform, grow, record_copies};

use crate::build::{Buffers, DEPTH_BOUNDS, Filling, HEADS, NODE_BYTES, NODE_COUNT, nodes_name};
use crate::description::{Clip, Coverage, DirtParameters, Lists, NO_REFIT};
use crate::fetch::MaskMemory;
use crate::layout::{Layout, MOST_VIEWS, TileGrid, TraceSettings};
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

    /// Makes room for the triangles that views will be drawn with and the nodes that a build will take: counted by builds without
    /// room, by no phase of the first build.
    fn make_room_for(
        &self,
        buffers: &mut Buffers,
        scene: &Resident,
        layout: &Layout,
        filling: Filling,
    ) -> Result<(), TracerError> {
        let gpu = &*self.pipelines.gpu;
        let mut clock = PhaseClock::new(Some(gpu));
        self.pipelines.set_up(layout, buffers, scene, &mut clock)?;
        clock.finish()?;
        let drawn = buffers.setup.counts(gpu)?;
        buffers.setup.make_room(gpu, &drawn)?;
        let nodes = self.pipelines.count_nodes(layout, buffers, scene, filling)?;
        buffers.set_capacity(gpu, nodes)
    }
}

impl Pipelines {
    /// The nodes that a build takes, by one that has no room for them.
    fn count_nodes(
        &self,
        layout: &Layout,
        buffers: &Buffers,
        scene: &Resident,
        filling: Filling,
    ) -> Result<u32, TracerError> {
        let mut clock = PhaseClock::new(Some(&*self.gpu));
        self.build(layout, buffers, scene, filling, &mut clock)?;
        clock.finish()?;
        taken(&self.gpu, buffers)
    }
}

/// Nodes asked for by the last build.
pub(crate) fn taken(gpu: &Gpu, buffers: &Buffers) -> Result<u32, TracerError> {
    let read = gpu.read(&buffers.taken, 4)?;
    Ok(bytemuck::pod_collect_to_vec::<u8, u32>(&read)[0])
}

fn filling(parameters: &DirtParameters) -> Filling {
    Filling { conservative: parameters.coverage == Coverage::Conservative, by_plane: parameters.clip == Clip::Plane }
}

impl Dirt {
    pub(crate) fn build_structure(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<DirtStructure, TracerError> {
        let parameters = &DirtParameters::try_from(parameters)?;
        let (layout, filling) = (Layout::new(viewpoint, parameters), filling(parameters));
        let resident = Resident::of(geometry)?;
        let mut buffers = Buffers::new(&self.pipelines, &layout, resident.triangle_count, 0, None)?;
        self.make_room_for(&mut buffers, &resident, &layout, filling)?;
        let arrays = buffers.arrays(&self.pipelines.gpu, parameters.reads, &[])?;
        self.pipelines.build(&layout, &buffers, &resident, filling, clock)?;
        record_copies(&arrays, clock)?;
        let frame = self.pipelines.show(viewpoint, parameters, &resident, None, clock)?;
        let shadow_map = self.pipelines.draw_shadow_map(geometry, viewpoint, parameters, &resident, None, clock)?;
        let pipelines = Arc::clone(&self.pipelines);
        Ok(DirtStructure {
            pipelines,
            layout,
            filling,
            buffers,
            arrays,
            geometry: resident,
            mask_memory: MaskMemory::default(),
            frame,
            shadow_map,
        })
    }
}

impl Dirt {
    pub(crate) fn build_packed(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<PackedStructure, TracerError> {
        let parameters = &DirtParameters::try_from(parameters)?;
        PackedStructure::build(&self.pipelines, geometry, viewpoint, parameters, clock)
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
            return Ok(Box::new(self.build_structure(geometry, viewpoint, parameters, clock)?));
        }
        Ok(Box::new(self.build_packed(geometry, viewpoint, parameters, clock)?))
    }
}

impl DirtStructure {
    /// What searches read from.
    pub(crate) fn reads(&self) -> Reads {
        self.arrays[0].reads()
    }
}

impl Structure for DirtStructure {
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
                let parameters = &DirtParameters::try_from(parameters)?;
                let layout = Layout::new(viewpoint, parameters);
                let resident = Resident::of(geometry)?;
                let same_size = layout.tiles == self.layout.tiles
                    && layout.buckets == self.layout.buckets
                    && layout.views.len() == self.layout.views.len()
                    && layout.drawn_by == self.layout.drawn_by;
                let (pipelines, triangles) = (&self.pipelines, resident.triangle_count);
                if !same_size {
                    let there = Some(&self.buffers.setup);
                    self.buffers = Buffers::new(pipelines, &layout, triangles, self.buffers.node_capacity, there)?;
                } else if !self.buffers.setup.serves(layout.views.len(), triangles) {
                    let there = Some(&self.buffers.setup);
                    let sums = pipelines.prefix_sum()?;
                    self.buffers.setup =
                        TriangleSetup::new(&pipelines.gpu, &sums, layout.views.len(), triangles, there)?;
                }
                self.arrays = self.buffers.arrays(&pipelines.gpu, parameters.reads, &self.arrays)?;
                self.pipelines.build(&layout, &self.buffers, &resident, self.filling, clock)?;
                record_copies(&self.arrays, clock)?;
                self.frame = self.pipelines.show(viewpoint, parameters, &resident, self.frame.as_ref(), clock)?;
                let drawn = self.shadow_map.take();
                self.shadow_map =
                    self.pipelines.draw_shadow_map(geometry, viewpoint, parameters, &resident, drawn, clock)?;
                (self.layout, self.geometry) = (layout, resident);
                Ok(())
            }
            Update::Refit => Err(TracerError::Unsupported(NO_REFIT.to_owned())),
            Update::Reuse => Ok(()),
        }
    }

    fn make_room(&mut self) -> Result<bool, TracerError> {
        let pipelines = Arc::clone(&self.pipelines);
        let gpu = &*pipelines.gpu;
        let drawn = self.buffers.setup.counts(gpu)?;
        let all_drawn = self.buffers.setup.holds(&drawn);
        let nodes = if all_drawn {
            taken(gpu, &self.buffers)?
        } else {
            // What was not drawn was not counted.
            self.buffers.setup.make_room(gpu, &drawn)?;
            pipelines.count_nodes(&self.layout, &self.buffers, &self.geometry, self.filling)?
        };
        if nodes <= self.buffers.node_capacity {
            return Ok(!all_drawn);
        }
        grow(&[nodes], |room| self.buffers.set_capacity(gpu, room[0]))?;
        self.arrays = self.buffers.arrays(gpu, self.reads(), &self.arrays)?;
        Ok(true)
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        self.trace_hits(&job, hits, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.count(&job, hits)
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

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let parameters = DirtParameters::try_from(job.parameters)?;
        if self.shadow_map.as_ref().is_some_and(|map| map.answers(&job)) {
            return Ok(lookup_memory());
        }
        let uniforms = [
            ("grid", size_of::<TileGrid>()),
            ("search", size_of::<TraceSettings>()),
            ("views", MOST_VIEWS * size_of::<ViewUniform>()),
        ];
        let mut parts = uniforms.map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).to_vec();
        parts.extend(self.surface_memory(&job, parameters.fetch));
        Ok(parts)
    }

    fn samplings(&self, _parameters: &Parameters) -> Result<Vec<Sampling>, TracerError> {
        let of = |view: &View| Sampling::new(Projection::Perspective(*view), Layers::All);
        Ok(self.layout.views.iter().map(of).collect())
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.check(geometry)
    }
}
