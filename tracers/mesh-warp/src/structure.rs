//! The tracer and its structure.

use std::cell::RefCell;
use std::sync::Arc;

use tracebench_api::wgpu::ComputePipeline;
use tracebench_api::{
    Geometry, Gpu, ImageMarch, Layers, Ledger, MarchSteps, MemoryEntry, MemoryReport, Parameters, Projection,
    SampledImage, TraceJob, TracerError, View,
};
use tracebench_kit::{
    BuildJob, DevicePipelines, DeviceStructure, DeviceTracer, EyeDepthTarget, LayerTarget, NearestLayers, NearestOf,
    NearestScene, PipelinesOnDemand, RasterBackend, SurfaceGeometry, VisibilityPass, compute_pipeline,
};
use tracebench_shaders::mesh_warp::MESH;

use crate::description::{NO_REFIT, WarpParameters};
use crate::mesh::{Mesh, MeshShape};

/// The tracer.
pub type MeshWarp = DeviceTracer<WarpStructure>;

/// The pipelines.
pub struct Pipelines {
    pub(crate) gpu: Arc<Gpu>,
    depths: NearestLayers,
    mesh: ComputePipeline,
    /// Draws the mesh.
    pub(crate) warp: NearestLayers,
    pub(crate) search: PipelinesOnDemand,
    /// The triangles at the view's pixels.
    pub(crate) seen: VisibilityPass,
}

impl DevicePipelines for Pipelines {
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self {
            depths: NearestLayers::of_depths(&gpu)?,
            mesh: compute_pipeline(&gpu, MESH, "mesh")?,
            warp: NearestLayers::of_primitives(&gpu)?,
            search: PipelinesOnDemand::new("trace"),
            seen: VisibilityPass::new(&gpu)?,
            gpu,
        })
    }
}

/// The mesh of one view.
pub struct WarpStructure {
    pub(crate) pipelines: Arc<Pipelines>,
    /// The view whose depths it is made of.
    pub(crate) view: View,
    pub(crate) shape: MeshShape,
    pub(crate) raster_backend: RasterBackend,
    pub(crate) depths: EyeDepthTarget,
    pub(crate) mesh: Mesh,
    pub(crate) geometry: SurfaceGeometry,
    /// The scene's.
    pub(crate) triangle_count: u32,
    /// What the last textures of traces took: of the mesh's triangles, and of the scene's.
    pub(crate) last_textures: RefCell<[Option<MemoryEntry>; 2]>,
}

impl DeviceStructure for WarpStructure {
    type Pipelines = Pipelines;

    const NO_REFIT: &'static str = NO_REFIT;

    fn build(pipelines: &Arc<Pipelines>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, viewpoint, parameters, before, clock } = job;
        let gpu = &*pipelines.gpu;
        let parameters = WarpParameters::try_from(parameters)?;
        let view = viewpoint.frame_view();
        let (shape, raster_backend) = (MeshShape::new(&view, &parameters), parameters.build);
        let surfaces = SurfaceGeometry::of(geometry)?;
        let depths = match before {
            Some(before) if before.view.size == view.size => before.depths.clone(),
            _ => EyeDepthTarget::new(gpu, view.size)?,
        };
        let mesh = Mesh::new(gpu, &shape, before.map(|before| &before.mesh))?;
        let triangle_count = geometry.triangles.len() as u32;
        let scene = NearestScene { raster_backend, view: &view, geometry: &surfaces.device, triangle_count };
        let nearest = pipelines.depths.prepare(gpu, scene, None)?;
        let make = mesh.prepare(gpu, &pipelines.mesh, &view, &shape, &depths)?;
        clock.device_phase("rasterize depth buffer", |encoder| {
            let target = LayerTarget { image: &depths.eye_depth, layer: 0, test: &depths.test };
            pipelines.depths.record(encoder, &nearest, target);
        })?;
        clock.device_phase("mesh", make)?;
        Ok(Self {
            pipelines: Arc::clone(pipelines),
            view,
            shape,
            raster_backend,
            depths,
            mesh,
            geometry: surfaces,
            triangle_count,
            last_textures: before.map_or_else(RefCell::default, |before| before.last_textures.clone()),
        })
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        self.depths.enter(&mut ledger);
        self.mesh.enter(&mut ledger);
        let drawing =
            NearestLayers::memory(NearestOf::Depths, self.raster_backend, self.view.size, self.triangle_count, 1);
        let drawing: u64 = drawing.iter().map(|entry| entry.allocated_bytes).sum();
        ledger.borrow_transient(drawing + Mesh::build_bytes());
        ledger.report(0).with_surface_geometry(self.geometry.bytes)
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        Ok(self.memory_of_trace(job))
    }

    fn samplings(&self, _parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        // A mesh without holes is a height field: whoever comes behind it has hit it, on the square between samples.
        let march = (!self.shape.cuts).then_some(ImageMarch {
            steps: MarchSteps::EveryPixel,
            start_bias: 0.0,
            thickness: f64::INFINITY,
            thickness_in_pixels: 0.0,
            to_back_faces: false,
            from_before: false,
            anywhere: true,
        });
        Ok(vec![SampledImage { march, ..SampledImage::new(Projection::Perspective(self.view), Layers::Nearest) }])
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let gpu = &self.pipelines.gpu;
        let [covered, triangles] = self.mesh.validate(gpu, &self.view, &self.shape, &self.depths.read(gpu)?)?;
        let counts = [
            ("vertices", self.shape.vertices() as usize),
            ("covered_pixels", covered),
            ("triangles", triangles),
            ("triangles_left_out", self.shape.triangles() as usize - triangles),
        ];
        Ok(counts.map(|(name, count)| (name, count as f64)).to_vec())
    }
}
