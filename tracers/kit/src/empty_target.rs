//! A colour attachment that nothing is written to: WebGPU wants a pass to have one, also where fragments write to buffers.

use tracebench_api::wgpu::{
    self, BindGroup, ColorTargetState, ColorWrites, CommandEncoder, RenderPipeline, TextureFormat, TextureUsages,
};
use tracebench_api::{Gpu, Ledger, TracerError};
use tracebench_shaders::Shader;

use crate::{RasterTargets, create_texture, raster_pipeline};

const FORMAT: TextureFormat = TextureFormat::R8Unorm;

/// The attachment of passes over an image of one size.
#[derive(Clone, Debug)]
pub struct EmptyTarget {
    name: String,
    texture: wgpu::Texture,
    pixels: u64,
    allocated_bytes: u64,
}

impl EmptyTarget {
    /// Creates the texture.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if an edge exceeds the device's limit.
    pub fn new(gpu: &Gpu, name: &str, size: [u32; 2]) -> Result<Self, TracerError> {
        let before = gpu.allocations();
        let texture = create_texture(gpu, name, size, FORMAT, TextureUsages::RENDER_ATTACHMENT);
        gpu.check()?;
        let pixels = size.map(u64::from).iter().product();
        // Drivers pad textures as they like.
        let allocated_bytes = gpu.allocations().added_since(&before, name).unwrap_or(pixels);
        Ok(Self { name: name.to_owned(), texture, pixels, allocated_bytes })
    }

    /// A pipeline that draws triangles from storage buffers into such a target.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn pipeline(gpu: &Gpu, shader: impl Into<Shader>) -> Result<RenderPipeline, TracerError> {
        let nothing = ColorTargetState { format: FORMAT, blend: None, write_mask: ColorWrites::empty() };
        let targets = RasterTargets { colours: &[Some(nothing)], ..Default::default() };
        raster_pipeline(gpu, shader, &targets)
    }

    /// Records a pass that draws so many vertices.
    pub fn draw(&self, encoder: &mut CommandEncoder, pipeline: &RenderPipeline, bindings: &BindGroup, vertices: u32) {
        let view = self.texture.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("fill"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Discard },
            })],
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, bindings, &[]);
        pass.draw(0..vertices, 0..1);
    }

    /// Enters the texture as a part that stays.
    pub fn enter(&self, ledger: &mut Ledger) {
        ledger.keep(&self.name, self.allocated_bytes, self.pixels);
    }
}
