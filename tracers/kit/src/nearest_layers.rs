//! Layer behind layer of one view, by the device's rasterizer or in compute.

use std::sync::Arc;

use tracebench_api::wgpu::{BindGroup, CommandEncoder, TextureView};
use tracebench_api::{DeviceGeometry, Gpu, MemoryEntry, NO_PRIMITIVE, TracerError, View};
use tracebench_shaders::shared::NearestRaster as Variant;

use crate::eye_depth::{DEPTH_FORMAT, NO_SURFACE};
use crate::nearest_compute::{ComputedPass, NearestCompute};
use crate::nearest_raster::{NearestRaster, Passing};
use crate::primitive_texture::PRIMITIVE_FORMAT;
use crate::{NearestOf, OnDemand, RasterBackend};

/// The pipelines; what lies behind a layer, and what is drawn in compute, has them when it is first drawn.
#[derive(Debug)]
pub struct NearestLayers {
    what: NearestOf,
    nearest: NearestRaster,
    behind: OnDemand<(), Arc<NearestRaster>>,
    compute: NearestCompute,
}

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct NearestScene<'a> {
    /// What draws.
    pub raster_backend: RasterBackend,
    /// The view.
    pub view: &'a View,
    /// The scene.
    pub geometry: &'a DeviceGeometry,
    /// Its triangles.
    pub triangle_count: u32,
}

/// One layer, ready to be recorded.
#[derive(Debug)]
pub struct NearestPass(Pass);

#[derive(Debug)]
enum Pass {
    Raster { raster: Arc<NearestRaster>, bindings: BindGroup, triangle_count: u32 },
    First { bindings: BindGroup, triangle_count: u32 },
    Computed(Box<ComputedPass>),
}

/// Where a layer is drawn.
#[derive(Clone, Copy, Debug)]
pub struct LayerTarget<'a> {
    /// The layer alone.
    pub image: &'a TextureView,
    /// Its number in its texture.
    pub layer: u32,
    /// A depth test's texture of the same size.
    pub test: &'a TextureView,
}

impl NearestLayers {
    /// Of eye depths.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses a pipeline.
    pub fn of_depths(gpu: &Gpu) -> Result<Self, TracerError> {
        Self::new(gpu, NearestOf::Depths)
    }

    /// Of triangles' numbers.
    ///
    /// # Errors
    /// As [`NearestLayers::of_depths`].
    pub fn of_primitives(gpu: &Gpu) -> Result<Self, TracerError> {
        Self::new(gpu, NearestOf::Primitives)
    }

    fn new(gpu: &Gpu, what: NearestOf) -> Result<Self, TracerError> {
        Ok(Self {
            what,
            nearest: raster(gpu, what, false)?,
            behind: OnDemand::default(),
            compute: NearestCompute::new(gpu),
        })
    }

    /// Prepares a layer: the nearest, or what is nearest behind that with these eye depths.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene or the image.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        scene: NearestScene<'_>,
        passed: Option<(&TextureView, Passing)>,
    ) -> Result<NearestPass, TracerError> {
        let NearestScene { raster_backend, view, geometry, triangle_count } = scene;
        Ok(NearestPass(match (raster_backend, passed) {
            (RasterBackend::Compute, _) => {
                let pass = self.compute.prepare(gpu, self.what, view, geometry, triangle_count, passed)?;
                Pass::Computed(Box::new(pass))
            }
            (RasterBackend::Raster, None) => {
                Pass::First { bindings: self.nearest.bind(gpu, view, geometry, None)?, triangle_count }
            }
            (RasterBackend::Raster, Some(_)) => {
                let raster = self.behind.of((), || raster(gpu, self.what, true).map(Arc::new))?;
                Pass::Raster { bindings: raster.bind(gpu, view, geometry, passed)?, raster, triangle_count }
            }
        }))
    }

    /// Records a layer.
    pub fn record(&self, encoder: &mut CommandEncoder, pass: &NearestPass, target: LayerTarget<'_>) {
        let targets = [target.image, target.test];
        let nothing = match self.what {
            NearestOf::Depths => f64::from(NO_SURFACE),
            NearestOf::Primitives => f64::from(NO_PRIMITIVE),
        };
        match &pass.0 {
            Pass::First { bindings, triangle_count } => {
                self.nearest.record(encoder, bindings, *triangle_count, nothing, targets);
            }
            Pass::Raster { raster, bindings, triangle_count } => {
                raster.record(encoder, bindings, *triangle_count, nothing, targets);
            }
            Pass::Computed(pass) => pass.record(encoder, target.image.texture(), target.layer),
        }
    }

    /// What so many layers take while they are drawn, beside their textures.
    pub fn memory(
        what: NearestOf,
        raster_backend: RasterBackend,
        size: [u32; 2],
        triangle_count: u32,
        layers: u32,
    ) -> Vec<MemoryEntry> {
        let layer = |number: u32| match raster_backend {
            RasterBackend::Compute => NearestCompute::memory(what, size, triangle_count, number > 0),
            RasterBackend::Raster => {
                let parts = std::iter::once(NearestRaster::UNIFORM)
                    .chain((number > 0).then_some(NearestRaster::PASSING_UNIFORM));
                parts.map(|(name, bytes)| MemoryEntry::whole(name, bytes)).collect()
            }
        };
        (0..layers).flat_map(layer).collect()
    }
}

fn raster(gpu: &Gpu, what: NearestOf, behind: bool) -> Result<NearestRaster, TracerError> {
    let (primitives, format) = match what {
        NearestOf::Depths => (false, DEPTH_FORMAT),
        NearestOf::Primitives => (true, PRIMITIVE_FORMAT),
    };
    NearestRaster::new(gpu, Variant { primitives, behind }, format)
}
