//! The structure of one scene from one viewpoint.

use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, Layers, Ledger, MemoryEntry, MemoryReport, Parameters, PhaseClock, Projection,
    Sampling, Structure, TraceJob, Tracer, TracerError, Update, View, Viewpoint,
};
use tracebench_kit::{LastCount, SurfaceGeometry, ViewUniform, grow};

use crate::build::{Buffers, DEPTH_BOUNDS, Filling, HEADS, NODE_BYTES, NODE_COUNT, Pipelines, nodes_name};
use crate::description::{Clip, Coverage, DirtParameters, NO_REFIT};
use crate::fetch::MaskMemory;
use crate::layout::{Layout, MOST_VIEWS, TileGrid, TraceSettings};
use crate::visibility::Frame;

/// The tracer.
pub struct Dirt {
    pipelines: Arc<Pipelines>,
    /// How many nodes the last scene needed that was counted.
    counted: LastCount<(Layout, Filling), u32>,
}

/// What of the scene a structure needs to trace.
pub(crate) struct Resident {
    pub surfaces: SurfaceGeometry,
    pub triangle_count: u32,
    pub bytes: u64,
}

impl Resident {
    fn of(geometry: &Geometry) -> Result<Self, TracerError> {
        Ok(Self {
            surfaces: SurfaceGeometry::of(geometry)?,
            triangle_count: geometry.triangles.len() as u32,
            bytes: geometry.bytes(),
        })
    }
}

/// Depth bounds and lists.
pub(crate) struct DirtStructure {
    pub pipelines: Arc<Pipelines>,
    pub layout: Layout,
    pub filling: Filling,
    pub buffers: Buffers,
    pub geometry: Resident,
    pub mask_memory: MaskMemory,
    /// What the camera's frame shows, if that was asked for.
    pub frame: Option<Frame>,
}

impl Dirt {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self { pipelines: Arc::new(Pipelines::new(gpu)?), counted: LastCount::default() })
    }

    /// Makes room for the nodes that a build will take: counted by one without room, outside of any time.
    fn make_room_for(
        &self,
        buffers: &mut Buffers,
        geometry: &Geometry,
        layout: &Layout,
        filling: Filling,
    ) -> Result<(), TracerError> {
        let gpu = &*self.pipelines.gpu;
        let nodes = self.counted.of(geometry, (layout.clone(), filling), || {
            let mut clock = PhaseClock::new(Some(gpu));
            self.pipelines.fill(layout, buffers, geometry, filling, &mut clock)?;
            clock.finish()?;
            Ok(taken(gpu, buffers)?[0])
        })?;
        buffers.set_capacity(gpu, nodes)
    }
}

/// Nodes asked for and parts of triangles, of the last build.
pub(crate) fn taken(gpu: &Gpu, buffers: &Buffers) -> Result<[u32; 2], TracerError> {
    let read = gpu.read(&buffers.taken, 8)?;
    Ok(bytemuck::pod_collect_to_vec::<u8, [u32; 2]>(&read)[0])
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
        let gpu = &*self.pipelines.gpu;
        let parameters = &DirtParameters::try_from(parameters)?;
        let (layout, filling) = (Layout::new(viewpoint, parameters), filling(parameters));
        let resident = Resident::of(geometry)?;
        let mut buffers = Buffers::new(gpu, &layout, 0)?;
        self.make_room_for(&mut buffers, geometry, &layout, filling)?;
        self.pipelines.fill(&layout, &buffers, geometry, filling, clock)?;
        let frame = self.pipelines.show(viewpoint, parameters, &resident, None, clock)?;
        let pipelines = Arc::clone(&self.pipelines);
        Ok(DirtStructure {
            pipelines,
            layout,
            filling,
            buffers,
            geometry: resident,
            mask_memory: MaskMemory::default(),
            frame,
        })
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
        Ok(Box::new(self.build_structure(geometry, viewpoint, parameters, clock)?))
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
                    && layout.views.len() == self.layout.views.len();
                if same_size {
                    self.pipelines.fill(&layout, &self.buffers, geometry, self.filling, clock)?;
                } else {
                    let buffers = Buffers::new(&self.pipelines.gpu, &layout, self.buffers.node_capacity)?;
                    self.pipelines.fill(&layout, &buffers, geometry, self.filling, clock)?;
                    self.buffers = buffers;
                }
                self.frame = self.pipelines.show(viewpoint, parameters, &resident, self.frame.as_ref(), clock)?;
                (self.layout, self.geometry) = (layout, resident);
                Ok(())
            }
            Update::Refit => Err(TracerError::Unsupported(NO_REFIT.to_owned())),
            Update::Reuse => Ok(()),
        }
    }

    fn make_room(&mut self) -> Result<bool, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let [nodes, _] = taken(gpu, &self.buffers)?;
        if nodes <= self.buffers.node_capacity {
            return Ok(false);
        }
        grow(&[nodes], |room| self.buffers.set_capacity(gpu, room[0]))?;
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
        let used = taken(&self.pipelines.gpu, buffers).map_or(0, |[nodes, _]| nodes).min(buffers.node_capacity);
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
        buffers.attachment.enter(&mut ledger);
        ledger.borrow_transient(self.layout.build_uniform_bytes());
        if let Some(frame) = &self.frame {
            frame.enter(&mut ledger);
        }
        ledger.report(self.geometry.bytes).with_surface_geometry(self.geometry.surfaces.bytes)
    }

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let parameters = DirtParameters::try_from(job.parameters)?;
        let uniforms = [
            ("grid", size_of::<TileGrid>()),
            ("search", size_of::<TraceSettings>()),
            ("views", MOST_VIEWS * size_of::<ViewUniform>()),
        ];
        let mut parts = uniforms.map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).to_vec();
        parts.extend(self.surface_memory(&job, parameters.fetch));
        Ok(parts)
    }

    fn samplings(&self) -> Vec<Sampling> {
        let of = |view: &View| Sampling { projection: Projection::Perspective(*view), layers: Layers::All };
        self.layout.views.iter().map(of).collect()
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.check(geometry)
    }
}
