//! What is nearest at every pixel of one view, by the hardware rasterizer; depths by the triangles' planes.

use tracebench_api::wgpu::{self, BindGroup, BindingResource, Buffer, RenderPipeline, TextureFormat, TextureView};
use tracebench_api::{DeviceGeometry, Gpu, TracerError, View};
use tracebench_shaders::shared::NearestRaster as Variant;

use crate::{RasterTargets, ViewUniform, bind_group, raster_pipeline, uniform_buffer, view_uniform};
pub use tracebench_shaders::shared::Passing;

/// What depth is tested in.
pub const DEPTH_TEST_FORMAT: TextureFormat = TextureFormat::Depth32Float;

const VIEW: &str = "drawn view";
const PASSING: &str = "passed layer";

/// What lies farther behind a layer than that.
pub fn behind(separation: f32) -> Passing {
    Passing { separation, backs_only: 0, padding: [0; 2] }
}

/// Backs of faces behind a layer, however near.
pub fn backs() -> Passing {
    Passing { separation: 0.0, backs_only: 1, padding: [0; 2] }
}

/// A pipeline that draws what is nearest.
#[derive(Debug)]
pub(crate) struct NearestRaster {
    pipeline: RenderPipeline,
}

impl NearestRaster {
    /// Creates the pipeline of a variant, which writes a colour of that format.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub(crate) fn new(gpu: &Gpu, variant: Variant, format: TextureFormat) -> Result<Self, TracerError> {
        let targets = RasterTargets {
            colours: &[Some(format.into())],
            // Reversed depth: near is 1, far is 0. Of equal depths the first triangle drawn stays.
            depth: Some((DEPTH_TEST_FORMAT, true, wgpu::CompareFunction::Greater)),
            ..Default::default()
        };
        Ok(Self { pipeline: raster_pipeline(gpu, variant, &targets)? })
    }

    /// Name and bytes of what drawing takes while it runs, beside its targets.
    pub(crate) const UNIFORM: (&str, u64) = (VIEW, size_of::<ViewUniform>() as u64);

    /// The same of drawing what lies behind a layer.
    pub(crate) const PASSING_UNIFORM: (&str, u64) = (PASSING, size_of::<Passing>() as u64);

    /// Prepares one view; of a variant that draws what lies behind a layer with that layer's depths.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene.
    pub(crate) fn bind(
        &self,
        gpu: &Gpu,
        view: &View,
        geometry: &DeviceGeometry,
        passed: Option<(&TextureView, Passing)>,
    ) -> Result<BindGroup, TracerError> {
        for (name, buffer) in [("vertex positions", &geometry.positions), ("vertex indices", &geometry.indices)] {
            gpu.check_storage_binding(name, buffer.size(), "the scene's triangle count")?;
        }
        let uniform = view_uniform(view);
        let uniform =
            gpu.buffer_with(VIEW, bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM, "the number of views")?;
        let mut resources: Vec<BindingResource<'_>> =
            [&uniform, &geometry.positions, &geometry.indices].map(Buffer::as_entire_binding).to_vec();
        let passing = passed.map(|(_, passing)| uniform_buffer(gpu, PASSING, &passing)).transpose()?;
        if let Some(((depths, _), passing)) = passed.zip(passing.as_ref()) {
            resources.extend([passing.as_entire_binding(), BindingResource::TextureView(depths)]);
        }
        Ok(bind_group(gpu, &self.pipeline.get_bind_group_layout(0), &resources))
    }

    /// Records the pass that draws all triangles, with a depth test in a texture of the same size; `nothing` is left where there
    /// is none.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &BindGroup,
        triangle_count: u32,
        nothing: f64,
        [target, depth_test]: [&TextureView; 2],
    ) {
        let clear = wgpu::Color { r: nothing, g: 0.0, b: 0.0, a: 0.0 };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("nearest"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth_test,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, bindings, &[]);
        pass.draw(0..triangle_count * 3, 0..1);
    }
}
