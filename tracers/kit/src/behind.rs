//! What lies behind a layer of one view: depth peeling by the hardware rasterizer.

use tracebench_api::wgpu::{BindGroup, CommandEncoder, TextureFormat, TextureView};
use tracebench_api::{DeviceGeometry, Gpu, MemoryEntry, NO_PRIMITIVE, TracerError, View};
use tracebench_shaders::shared::NearestRaster as Variant;

use crate::eye_depth::{DEPTH_FORMAT, NO_SURFACE};
use crate::nearest_raster::{NearestRaster, Passing};
use crate::primitive_raster::PRIMITIVE_FORMAT;

/// A pipeline that rasterizes what is nearest behind a layer.
#[derive(Debug)]
pub struct BehindRaster {
    raster: NearestRaster,
    nothing: f64,
}

impl BehindRaster {
    /// One that writes eye depths, [`NO_SURFACE`] where there is nothing.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn of_depths(gpu: &Gpu) -> Result<Self, TracerError> {
        Self::new(gpu, false, DEPTH_FORMAT, f64::from(NO_SURFACE))
    }

    /// One that writes triangles' numbers, [`NO_PRIMITIVE`] where there is nothing.
    ///
    /// # Errors
    /// As [`BehindRaster::of_depths`].
    pub fn of_primitives(gpu: &Gpu) -> Result<Self, TracerError> {
        Self::new(gpu, true, PRIMITIVE_FORMAT, f64::from(NO_PRIMITIVE))
    }

    fn new(gpu: &Gpu, primitives: bool, format: TextureFormat, nothing: f64) -> Result<Self, TracerError> {
        Ok(Self { raster: NearestRaster::new(gpu, Variant { primitives, behind: true }, format)?, nothing })
    }

    /// What a pass takes while it runs, beside its targets.
    pub fn memory() -> [MemoryEntry; 2] {
        [NearestRaster::UNIFORM, NearestRaster::PASSING_UNIFORM].map(|(name, bytes)| MemoryEntry::whole(name, bytes))
    }

    /// Prepares one view behind the layer with these eye depths.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene.
    pub fn bind(
        &self,
        gpu: &Gpu,
        view: &View,
        geometry: &DeviceGeometry,
        passed: &TextureView,
        passing: Passing,
    ) -> Result<BindGroup, TracerError> {
        self.raster.bind(gpu, view, geometry, Some((passed, passing)))
    }

    /// Records the pass that draws all triangles, with a depth test in a texture of the same size.
    pub fn record(
        &self,
        encoder: &mut CommandEncoder,
        bindings: &BindGroup,
        triangle_count: u32,
        target: &TextureView,
        depth_test: &TextureView,
    ) {
        self.raster.record(encoder, bindings, triangle_count, self.nothing, [target, depth_test]);
    }
}
