//! Linear eye depth of one view, by the hardware rasterizer.

use tracebench_api::wgpu::{self, TextureFormat, TextureUsages};
use tracebench_api::{DeviceGeometry, Gpu, Ledger, TracerError, View};
use tracebench_shaders::shared::NearestRaster as Variant;

use crate::create_texture;
use crate::nearest_raster::NearestRaster;

/// The eye depth stored where no surface covers a pixel's centre: beyond every surface.
pub const NO_SURFACE: f32 = 1e30;

const DEPTH_FORMAT: TextureFormat = TextureFormat::R32Float;
const EYE_DEPTH: &str = "eye depth buffer";
const DEPTH_TEST: &str = "depth test buffer";

/// The pipeline that rasterizes eye depth.
#[derive(Debug)]
pub struct EyeDepthRaster {
    raster: NearestRaster,
}

/// The textures of one view.
#[derive(Debug)]
pub struct EyeDepthTarget {
    /// One f32 a pixel: linear eye depth at the pixel's centre, or [`NO_SURFACE`].
    pub eye_depth: wgpu::TextureView,
    /// The depth test's own buffer, which holds nothing between passes.
    pub test: wgpu::TextureView,
    /// Pixels.
    pixels: u64,
    /// Bytes allocated for the eye depth and for the depth test.
    allocated: [u64; 2],
}

impl EyeDepthTarget {
    /// Creates the textures.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if an edge exceeds the device's limit.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, TracerError> {
        let limit = gpu.limits.max_texture_dimension_2d;
        if let Some(edge) = size.into_iter().find(|edge| *edge > limit) {
            return Err(TracerError::Failed(format!(
                "the eye depth buffer has an edge of {edge} pixels, the device allows {limit}: turn down --frame"
            )));
        }
        let texture =
            |label, format, usage| create_texture(gpu, label, size, format, usage).create_view(&Default::default());
        let before = gpu.allocations();
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let mut target = Self {
            eye_depth: texture(
                EYE_DEPTH,
                DEPTH_FORMAT,
                TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
            ),
            test: texture(DEPTH_TEST, crate::DEPTH_TEST_FORMAT, TextureUsages::RENDER_ATTACHMENT),
            pixels,
            allocated: [pixels * 4; 2],
        };
        gpu.check()?;
        // Drivers pad textures as they like.
        let after = gpu.allocations();
        for (allocated, name) in target.allocated.iter_mut().zip([EYE_DEPTH, DEPTH_TEST]) {
            *allocated = after.added_since(&before, name).unwrap_or(*allocated);
        }
        Ok(target)
    }

    /// Enters both textures. What is allocated is what the device's allocator says, and where it says nothing, what is
    /// used; the depth test's is kept so that the next build need not create it.
    pub fn enter(&self, ledger: &mut Ledger) {
        for (name, allocated) in [EYE_DEPTH, DEPTH_TEST].into_iter().zip(self.allocated) {
            ledger.keep(name, allocated, self.pixels * 4);
        }
    }

    /// Reads the eye depths back, row by row from the top.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, TracerError> {
        let texture = self.eye_depth.texture();
        let (width, height) = (texture.width(), texture.height());
        let row_bytes = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(row_bytes) * u64::from(height);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let staging = gpu.buffer("eye depth read back", bytes, usage, "--frame")?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None },
            },
            texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let padded = gpu.read(&staging, bytes)?;
        let rows = padded.chunks_exact(row_bytes as usize);
        Ok(rows.flat_map(|row| bytemuck::pod_collect_to_vec::<u8, f32>(&row[..width as usize * 4])).collect())
    }
}

impl EyeDepthRaster {
    /// Creates the pipeline.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        Ok(Self { raster: NearestRaster::new(gpu, Variant { primitives: false }, DEPTH_FORMAT)? })
    }

    /// Prepares one view.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene.
    pub fn bind(&self, gpu: &Gpu, view: &View, geometry: &DeviceGeometry) -> Result<wgpu::BindGroup, TracerError> {
        self.raster.bind(gpu, view, geometry)
    }

    /// Records the pass that draws all triangles.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &wgpu::BindGroup,
        triangle_count: u32,
        target: &EyeDepthTarget,
    ) {
        let targets = [&target.eye_depth, &target.test];
        self.raster.record(encoder, bindings, triangle_count, f64::from(NO_SURFACE), targets);
    }
}
