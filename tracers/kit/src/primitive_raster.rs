//! The nearest triangle at every pixel of one view, by the hardware rasterizer.

use tracebench_api::wgpu::{self, BindGroup, RenderPipeline, TextureFormat, TextureUsages, TextureView};
use tracebench_api::{DeviceGeometry, Gpu, MemoryEntry, TracerError, View};
use tracebench_shaders::shared::PRIMITIVE_RASTER;

use crate::{RasterTargets, ViewUniform, bind_group, raster_pipeline, shader_module};

const FORMAT: TextureFormat = TextureFormat::R32Uint;

/// What depth is tested in.
pub const DEPTH_TEST_FORMAT: TextureFormat = TextureFormat::Depth32Float;

const TEXTURE: &str = "primitive id texture";
const VIEW: &str = "drawn view";

/// The pipeline that rasterizes triangles' numbers.
#[derive(Debug)]
pub struct PrimitiveRaster {
    pipeline: RenderPipeline,
}

/// One u32 a pixel: the nearest triangle at the pixel's centre, or [`tracebench_api::NO_PRIMITIVE`].
#[derive(Clone, Debug)]
pub struct PrimitiveTexture {
    /// The texture.
    pub view: TextureView,
    /// What it takes: as the device's allocator says, or by its pixels where that says nothing.
    pub memory: MemoryEntry,
}

impl PrimitiveTexture {
    /// What a texture takes by its pixels.
    pub fn memory_of([width, height]: [u32; 2]) -> MemoryEntry {
        MemoryEntry::whole(TEXTURE, u64::from(width) * u64::from(height) * 4)
    }

    /// Creates the texture.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, TracerError> {
        let before = gpu.allocations();
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let texture = create_texture(gpu, TEXTURE, size, FORMAT, usage);
        gpu.check()?;
        let mut memory = Self::memory_of(size);
        memory.allocated_bytes = gpu.allocations().added_since(&before, TEXTURE).unwrap_or(memory.used_bytes);
        Ok(Self { view: texture.create_view(&Default::default()), memory })
    }
}

/// A texture of one level and one layer.
pub fn create_texture(
    gpu: &Gpu,
    name: &str,
    [width, height]: [u32; 2],
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

impl PrimitiveRaster {
    /// Creates the pipeline.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        let module = shader_module(gpu, PRIMITIVE_RASTER)?;
        let targets = RasterTargets {
            colours: &[Some(FORMAT.into())],
            // Reversed depth: near is 1, far is 0. Of equal depths the first triangle drawn stays.
            depth: Some((DEPTH_TEST_FORMAT, true, wgpu::CompareFunction::Greater)),
            ..Default::default()
        };
        Ok(Self { pipeline: raster_pipeline(gpu, PRIMITIVE_RASTER.name, &module, &targets)? })
    }

    /// What drawing takes while it runs, beside the texture.
    pub fn memory() -> MemoryEntry {
        MemoryEntry::whole(VIEW, size_of::<ViewUniform>() as u64)
    }

    /// Prepares one view.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene.
    pub fn bind(&self, gpu: &Gpu, view: &View, geometry: &DeviceGeometry) -> Result<BindGroup, TracerError> {
        for (name, buffer) in [("vertex positions", &geometry.positions), ("vertex indices", &geometry.indices)] {
            gpu.check_storage_binding(name, buffer.size(), "the scene's triangle count")?;
        }
        let uniform = ViewUniform::from(view);
        let uniform =
            gpu.buffer_with(VIEW, bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM, "the number of views")?;
        let resources = [&uniform, &geometry.positions, &geometry.indices].map(|buffer| buffer.as_entire_binding());
        Ok(bind_group(gpu, &self.pipeline.get_bind_group_layout(0), &resources))
    }

    /// Records the pass that draws all triangles, with a depth test in a texture of the same size.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &BindGroup,
        triangle_count: u32,
        target: &TextureView,
        depth_test: &TextureView,
    ) {
        let clear = wgpu::Color { r: f64::from(tracebench_api::NO_PRIMITIVE), g: 0.0, b: 0.0, a: 0.0 };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("primitives"),
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
