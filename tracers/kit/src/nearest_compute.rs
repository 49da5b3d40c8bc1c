//! What is nearest at every pixel of one view, in compute, and drawn into a texture as the rasterizer would.

use tracebench_api::wgpu::{
    self, BindGroup, BindingResource, Buffer, COPY_BYTES_PER_ROW_ALIGNMENT, CommandEncoder, ComputePipeline,
    TexelCopyBufferInfo, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureView,
};
use tracebench_api::{DeviceGeometry, Gpu, MemoryEntry, NO_PRIMITIVE, TracerError, View};
use tracebench_shaders::shared::{NEAREST_RESOLVE, NearestCompute as Variant};

use crate::compute_raster::DealtPass;
use crate::eye_depth::NO_SURFACE;
use crate::nearest_raster::{NearestRaster, Passing};
use crate::{
    ComputeRaster, OnDemand, PipelinesOnDemand, RasterImage, RasterWork, bind_group, bind_group_at, compute_pipeline,
    dispatch_linear, storage_buffer, uniform_buffer, view_uniform,
};
pub use tracebench_shaders::shared::{NearestImage, ResolvedImage};

/// As `WORKGROUP_SIZE` in shaders/shared/nearest_resolve.wgsl.
const WORKGROUP_SIZE: u32 = 64;

const IMAGE: &str = "drawn image";
const CODES: &str = "nearest depths in words";
const NAMES: &str = "nearest triangles in words";
const RESOLVED: &str = "resolved image";
const HINT: &str = "--frame-size";

/// What is drawn of the nearest triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NearestOf {
    /// Its eye depth, [`NO_SURFACE`] where there is none.
    Depths,
    /// Its number, [`NO_PRIMITIVE`] where there is none.
    Primitives,
}

/// The pipelines, each made when it is first needed.
#[derive(Debug)]
pub(crate) struct NearestCompute {
    raster: ComputeRaster,
    draw: PipelinesOnDemand,
    resolve: OnDemand<(), ComputePipeline>,
}

/// A pass over one view.
#[derive(Debug)]
pub(crate) struct ComputedPass {
    work: RasterWork,
    /// What is cleared before; the last has what is drawn.
    words: Vec<Buffer>,
    stages: Vec<DealtPass>,
    resolve: (ComputePipeline, BindGroup),
    size: [u32; 2],
}

/// Words of a row, which copies to textures ask to be long.
fn row_words(width: u32) -> u32 {
    width.next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT / 4)
}

fn image_words([width, height]: [u32; 2]) -> u32 {
    row_words(width) * height
}

impl NearestCompute {
    /// None yet.
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self { raster: ComputeRaster::new(gpu), draw: PipelinesOnDemand::new("draw"), resolve: OnDemand::default() }
    }

    /// Prepares one view, behind a layer with these eye depths where there is one.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene or the image.
    pub(crate) fn prepare(
        &self,
        gpu: &Gpu,
        what: NearestOf,
        view: &View,
        geometry: &DeviceGeometry,
        triangle_count: u32,
        passed: Option<(&TextureView, Passing)>,
    ) -> Result<ComputedPass, TracerError> {
        let work = self.raster.prepare(gpu, RasterImage::of_view(view), geometry, triangle_count)?;
        let primitives = what == NearestOf::Primitives;
        let words = image_words(view.size);
        let mut kept = vec![storage_buffer(gpu, CODES, u64::from(words) * 4, HINT)?];
        if primitives {
            kept.push(storage_buffer(gpu, NAMES, u64::from(words) * 4, HINT)?);
        }
        let uniform = uniform_buffer(gpu, NearestRaster::UNIFORM.0, &view_uniform(view))?;
        let passing = passed.map(|(_, passing)| uniform_buffer(gpu, NearestRaster::PASSING_UNIFORM.0, &passing));
        let passing = passing.transpose()?;
        let pipeline = self.draw.of(gpu, Variant { primitives, behind: passed.is_some() })?;
        let mut stages = Vec::new();
        for names in 0..kept.len() as u32 {
            let image = NearestImage { row_words: row_words(view.size[0]), names, padding: [0; 2] };
            let image = uniform_buffer(gpu, IMAGE, &image)?;
            let buffers = [(0, &uniform), (1, &geometry.positions), (2, &geometry.indices), (5, &image)];
            let buffers = buffers.into_iter().chain((6..).zip(&kept));
            let mut resources: Vec<(u32, BindingResource<'_>)> =
                buffers.map(|(binding, buffer)| (binding, buffer.as_entire_binding())).collect();
            if let Some(((depths, _), passing)) = passed.zip(passing.as_ref()) {
                resources.extend([(3, passing.as_entire_binding()), (4, BindingResource::TextureView(depths))]);
            }
            let own = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
            stages.push(work.pass(gpu, pipeline.clone(), own));
        }
        let nothing = if primitives { NO_PRIMITIVE } else { NO_SURFACE.to_bits() };
        let resolved = uniform_buffer(gpu, RESOLVED, &ResolvedImage { words, nothing, padding: [0; 2] })?;
        let resolve = self.resolve.of((), || compute_pipeline(gpu, NEAREST_RESOLVE, "resolve"))?;
        let drawn = &kept[kept.len() - 1];
        let resources = [&resolved, drawn].map(Buffer::as_entire_binding);
        let bindings = bind_group(gpu, &resolve.get_bind_group_layout(0), &resources);
        Ok(ComputedPass { work, words: kept, stages, resolve: (resolve, bindings), size: view.size })
    }

    /// What a pass takes while it runs, beside its texture.
    pub(crate) fn memory(what: NearestOf, size: [u32; 2], triangle_count: u32, behind: bool) -> Vec<MemoryEntry> {
        let words = u64::from(image_words(size)) * 4;
        let image = (IMAGE, size_of::<NearestImage>() as u64);
        let mut parts =
            vec![NearestRaster::UNIFORM, (CODES, words), image, (RESOLVED, size_of::<ResolvedImage>() as u64)];
        if what == NearestOf::Primitives {
            parts.extend([(NAMES, words), image]);
        }
        parts.extend(behind.then_some(NearestRaster::PASSING_UNIFORM));
        let parts = parts.into_iter().map(|(name, bytes)| MemoryEntry::whole(name, bytes));
        parts.chain(RasterWork::memory(triangle_count, false)).collect()
    }
}

impl ComputedPass {
    /// Records it, into a layer of a texture of the view's size.
    pub(crate) fn record(&self, encoder: &mut CommandEncoder, texture: &wgpu::Texture, layer: u32) {
        for words in &self.words {
            encoder.clear_buffer(words, 0, None);
        }
        self.work.record(encoder);
        self.stages.iter().for_each(|stage| stage.record(encoder));
        let (resolve, bindings) = &self.resolve;
        dispatch_linear(encoder, resolve, bindings, image_words(self.size), WORKGROUP_SIZE);
        let Some(drawn) = self.words.last() else { return };
        let [width, height] = self.size;
        let layout =
            TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_words(width) * 4), rows_per_image: None };
        let origin = wgpu::Origin3d { z: layer, ..Default::default() };
        encoder.copy_buffer_to_texture(
            TexelCopyBufferInfo { buffer: drawn, layout },
            TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
}
