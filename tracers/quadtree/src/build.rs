//! The build's stages on the device (WKP15, section 3): layers, what shading needs of them, the bottom level, the levels above.

use std::sync::Arc;

use tracebench_api::wgpu::{BindGroup, Buffer, ComputePipeline};
use tracebench_api::{Geometry, Gpu, PhaseClock, TracerError};
use tracebench_kit::{
    DevicePipelines, SearchPipelines, ViewUniform, bind_group, compute_pipeline, dispatch_linear, uniform_buffer,
};
use tracebench_shaders::quadtree::{BOTTOM, MERGE, SURFACES};

use crate::images::Images;
use crate::layers::{LayerPipelines, capture_bytes};
use crate::layout::{Forest, MAX_VIEWS, Shape};

/// As `WORKGROUP_SIZE` in the shaders of shaders/quadtree.
pub(crate) const WORKGROUP_SIZE: u32 = 64;

/// Every pipeline; those of traces are made when they are first asked for.
pub struct Pipelines {
    pub(crate) gpu: Arc<Gpu>,
    layers: LayerPipelines,
    surfaces: ComputePipeline,
    bottom: ComputePipeline,
    merge: ComputePipeline,
    pub(crate) traces: SearchPipelines,
}

impl DevicePipelines for Pipelines {
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self {
            layers: LayerPipelines::new(&gpu)?,
            surfaces: compute_pipeline(&gpu, SURFACES, "surfaces")?,
            bottom: compute_pipeline(&gpu, BOTTOM, "bottom")?,
            merge: compute_pipeline(&gpu, MERGE, "merge")?,
            traces: SearchPipelines::default(),
            gpu,
        })
    }
}

impl Pipelines {
    fn bind(&self, pipeline: &ComputePipeline, buffers: &[&Buffer]) -> BindGroup {
        let resources: Vec<_> = buffers.iter().map(|buffer| buffer.as_entire_binding()).collect();
        bind_group(&self.gpu, &pipeline.get_bind_group_layout(0), &resources)
    }

    /// Records the whole build.
    pub(crate) fn fill(
        &self,
        shape: &Shape,
        images: &Images,
        geometry: &Geometry,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &*self.gpu;
        let device = geometry.on_device()?;
        gpu.check_storage_binding("triangle materials", device.materials.size(), "the scene's triangle count")?;
        let work = self.layers.deal_out(gpu, shape, geometry)?;
        let capturing = self.layers.prepare(gpu, shape, images, geometry, &work)?;
        let forest = uniform_buffer(gpu, "forest", &shape.forest())?;
        let views = uniform_buffer(gpu, "views", &shape.view_uniforms())?;
        let [odd, even] = images.payload_buffers();
        let surfaces = self.bind(
            &self.surfaces,
            &[&forest, &device.positions, &device.indices, &device.materials, &images.names.buffer, odd, even],
        );
        let bottom = self.bind(&self.bottom, &[&forest, &views, &images.codes.buffer, odd, even, &images.nodes.buffer]);
        let mut levels = Vec::new();
        for level in 1..=shape.top {
            let number = uniform_buffer(gpu, "level", &[level, 0, 0, 0])?;
            let cells = shape.level_size(level).map(u64::from).iter().product::<u64>() * shape.images();
            levels.push((self.bind(&self.merge, &[&forest, &number, &images.nodes.buffer]), cells as u32));
        }
        self.layers.record(shape, images, &capturing, clock)?;
        let pixels = (shape.pixels() * shape.images()) as u32;
        clock.device_phase("normals and materials", |encoder| {
            dispatch_linear(encoder, &self.surfaces, &surfaces, pixels, WORKGROUP_SIZE);
        })?;
        clock.device_phase("bottom level", |encoder| {
            dispatch_linear(encoder, &self.bottom, &bottom, pixels, WORKGROUP_SIZE);
        })?;
        for (level, (bindings, cells)) in (1..).zip(&levels) {
            clock.device_phase(&format!("merge level {level}"), |encoder| {
                dispatch_linear(encoder, &self.merge, bindings, *cells, WORKGROUP_SIZE);
            })?;
        }
        images.record_copies(clock)
    }
}

/// Bytes of what a build keeps until it is done.
pub(crate) fn build_bytes(shape: &Shape, triangles: u32) -> u64 {
    let own = size_of::<Forest>() + MAX_VIEWS * size_of::<ViewUniform>() + 16 * shape.top as usize;
    capture_bytes(shape, triangles) + own as u64
}
