//! Passes over all triangles of an image whose fragments write to buffers alone, by the device's rasterizer or in compute.

use tracebench_api::wgpu::{BindGroup, BindGroupLayout, BindingResource, CommandEncoder, RenderPipeline};
use tracebench_api::{DeviceGeometry, Gpu, PhaseClock, TracerError};
use tracebench_shaders::{Shader, ShaderKey};

use crate::compute_raster::DealtPass;
use crate::{
    ComputeRaster, EmptyTarget, OnDemand, PipelinesOnDemand, RasterBackend, RasterImage, RasterWork, bind_group_at,
};

/// Pipelines of a shader for the rasterizer, and in compute (its entry point `draw`). Each is made when it is first needed.
#[derive(Debug)]
pub struct TrianglePipelines {
    raster: OnDemand<ShaderKey, RenderPipeline>,
    compute: PipelinesOnDemand,
}

/// What a pass draws into.
#[derive(Clone, Copy, Debug)]
pub enum Canvas<'a> {
    /// The attachment of the rasterizer, by so many vertices.
    Attachment(&'a EmptyTarget, u32),
    /// Whatever the shader writes to, triangles as they are dealt out.
    Dealt(&'a RasterWork),
}

/// A pass, ready to be recorded.
#[derive(Debug)]
pub struct TrianglePass<'a>(Pass<'a>);

#[derive(Debug)]
enum Pass<'a> {
    Raster { target: &'a EmptyTarget, pipeline: RenderPipeline, bindings: BindGroup, vertices: u32 },
    Dealt(DealtPass),
}

impl<'a> Canvas<'a> {
    /// The dealt triangles where there are any, else the attachment.
    ///
    /// # Errors
    /// [`TracerError::Failed`] where there is neither.
    pub fn of(
        work: Option<&'a RasterWork>,
        target: Option<&'a EmptyTarget>,
        vertices: u32,
    ) -> Result<Self, TracerError> {
        match (work, target) {
            (Some(work), _) => Ok(Self::Dealt(work)),
            (None, Some(target)) => Ok(Self::Attachment(target, vertices)),
            (None, None) => {
                Err(TracerError::Failed("a build has neither triangles dealt out nor an attachment".to_owned()))
            }
        }
    }
}

impl TrianglePipelines {
    /// None yet.
    pub fn new() -> Self {
        Self { raster: OnDemand::default(), compute: PipelinesOnDemand::new("draw") }
    }

    /// The rasterizer's of a variant.
    ///
    /// # Errors
    /// As [`EmptyTarget::pipeline`].
    pub fn raster(&self, gpu: &Gpu, variant: impl Into<Shader>) -> Result<RenderPipeline, TracerError> {
        let shader = variant.into();
        self.raster.of(shader.key(), || EmptyTarget::pipeline(gpu, shader))
    }

    /// A pass of a variant, with these resources in group 0.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] if the device's limits forbid it, [`TracerError::Failed`] if it refuses it.
    pub fn pass<'a>(
        &self,
        gpu: &Gpu,
        variant: impl Into<Shader>,
        resources: &[(u32, BindingResource<'_>)],
        canvas: Canvas<'a>,
    ) -> Result<TrianglePass<'a>, TracerError> {
        let bind = |layout: &BindGroupLayout| bind_group_at(gpu, layout, resources);
        Ok(TrianglePass(match canvas {
            Canvas::Attachment(target, vertices) => {
                let pipeline = self.raster(gpu, variant)?;
                let bindings = bind(&pipeline.get_bind_group_layout(0));
                Pass::Raster { target, pipeline, bindings, vertices }
            }
            Canvas::Dealt(work) => {
                let pipeline = self.compute.of(gpu, variant)?;
                let bindings = bind(&pipeline.get_bind_group_layout(0));
                Pass::Dealt(work.pass(gpu, pipeline, bindings))
            }
        }))
    }
}

impl Default for TrianglePipelines {
    fn default() -> Self {
        Self::new()
    }
}

impl TrianglePass<'_> {
    /// Records it.
    pub fn record(&self, encoder: &mut CommandEncoder) {
        match &self.0 {
            Pass::Raster { target, pipeline, bindings, vertices } => {
                target.draw(encoder, pipeline, bindings, *vertices);
            }
            Pass::Dealt(pass) => pass.record(encoder),
        }
    }
}

impl ComputeRaster {
    /// The triangles of every image dealt out where a build is in compute, else nothing.
    ///
    /// # Errors
    /// As [`ComputeRaster::prepare`].
    pub fn prepare_all(
        &self,
        gpu: &Gpu,
        raster_backend: RasterBackend,
        images: impl IntoIterator<Item = RasterImage>,
        geometry: &DeviceGeometry,
        triangle_count: u32,
    ) -> Result<Vec<RasterWork>, TracerError> {
        match raster_backend {
            RasterBackend::Raster => Ok(Vec::new()),
            RasterBackend::Compute => {
                images.into_iter().map(|image| self.prepare(gpu, image, geometry, triangle_count)).collect()
            }
        }
    }
}

impl RasterWork {
    /// Records the phase "deal out triangles" before the first passes, where there is anything to deal out.
    ///
    /// # Errors
    /// As [`PhaseClock::device_phase`].
    pub fn record_all(all: &[Self], clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        if all.is_empty() {
            return Ok(());
        }
        clock.device_phase("deal out triangles", |encoder| all.iter().for_each(|work| work.record(encoder)))
    }
}
