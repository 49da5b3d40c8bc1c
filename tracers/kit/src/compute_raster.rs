//! Triangles rasterized in compute (shaders/shared/coverage.wgsl and raster_work.wgsl): by a rule of coverage that is the same on every
//! device, on all of its cores, where graphics stages run on a part of some.

use std::sync::Arc;

use tracebench_api::wgpu::{BindGroup, Buffer, BufferUsages, CommandEncoder, ComputePipeline};
use tracebench_api::{DeviceGeometry, Gpu, MemoryEntry, Parameter, ParameterScope, Rasterizer, TracerError, choice};
use tracebench_shaders::shared::RasterSetup;

use crate::{
    OnDemand, PipelinesOnDemand, PrefixSum, PrefixSumPlan, UnitSpace, ViewUniform, bind_group, bind_group_at,
    dispatch_linear, rasterizer, storage_buffer, undecided_border, uniform_buffer, view_uniform,
};
pub use tracebench_shaders::shared::{RasterAxis, RasterPass};

/// `RASTER_LANES` of shaders/shared/raster_work.wgsl, and `WORKGROUP_SIZE` of raster_setup.wgsl.
const LANES: u32 = 64;

/// `BLOCK_EDGE` there; a block's place has 10 bits along each axis.
const BLOCK_EDGE: u32 = 32;
const MAX_BLOCKS: u32 = 1024;

/// Pixels of its rectangle up to which a lane draws a triangle by itself. Cores in software lose little by it; Mesa's driver ends the loops
/// of eight lanes after 65,535 rounds in all, which eight such triangles and their rows stay far below.
const SMALL_ON_CPU: u32 = 512;
const SMALL_ON_GPU: u32 = 128;

/// Half a step of the grid that corners are rounded to: `SUBPIXELS` of shaders/shared/coverage.wgsl.
const SNAP_PIXELS: f64 = 1.0 / 512.0;

const WORK: &str = "raster: blocks of triangles";
const GROUPS: &str = "raster: workgroups";
const PASS: &str = "raster: pass";
const IMAGE: &str = "raster: image";
const TRIANGLES: &str = "the scene's triangle count";

choice! {
    /// What rasterizes triangles.
    pub enum RasterBackend { Raster = "raster", Compute = "compute" }
}

impl RasterBackend {
    /// By how much a border between two corners that are snapped is off, at most, pixels.
    ///
    /// # Errors
    /// As [`rasterizer`].
    pub fn border_pixels(self, gpu: &Gpu) -> Result<f64, TracerError> {
        self.rasterizer(gpu).map(|found| found.border_pixels())
    }

    /// Within which distance of a triangle's border it may decide either way, pixels.
    ///
    /// # Errors
    /// As [`rasterizer`].
    pub fn undecided_border(self, gpu: &Gpu) -> Result<f64, TracerError> {
        self.rasterizer(gpu).map(|found| undecided_border(&found))
    }

    fn rasterizer(self, gpu: &Gpu) -> Result<Rasterizer, TracerError> {
        match self {
            Self::Raster => rasterizer(gpu),
            // By the rule itself; depths are the planes' either way.
            Self::Compute => Ok(Rasterizer {
                snap_pixels: SNAP_PIXELS,
                depth_error: 0.0,
                depth_error_beyond_view: 0.0,
                reach: f64::INFINITY,
            }),
        }
    }
}

/// The parameter `build`, the same for every tracer that rasterizes.
pub fn build_parameter() -> Parameter<RasterBackend> {
    let effect = "what rasterizes triangles: the device's own rasterizer, which on data-centre GPUs is a small part of the chip, or \
                  compute shaders, by a rule of coverage that is the same on every device";
    Parameter::choice(ParameterScope::Build, RasterBackend::Raster).effect(effect)
}

/// An image that triangles are drawn into.
#[derive(Clone, Copy, Debug)]
pub enum RasterImage {
    /// A perspective view.
    View {
        /// The view; its size counts what is drawn, pixels or tiles, of which the last may be cut off.
        view: ViewUniform,
        /// Pixels, or tiles.
        size: [u32; 2],
        /// Whether all that a triangle touches counts, not only what it covers the centre of.
        touched: bool,
    },
    /// The orthographic image along an axis of the unit cube, whose edge it has.
    Axis {
        /// The cube.
        space: UnitSpace,
        /// 0, 1 or 2.
        axis: u32,
        /// As of a view; what is touched is grown by a 16th of a pixel.
        touched: bool,
    },
}

impl RasterImage {
    /// A view by samples.
    pub fn of_view(view: &tracebench_api::View) -> Self {
        Self::View { view: view_uniform(view), size: view.size, touched: false }
    }

    fn size(&self) -> [u32; 2] {
        match self {
            Self::View { size, .. } => *size,
            Self::Axis { space, .. } => [space.image; 2],
        }
    }
}

/// The pipelines that deal out triangles, each made when it is first needed.
#[derive(Debug)]
pub struct ComputeRaster {
    find: PipelinesOnDemand,
    deal: PipelinesOnDemand,
    sums: OnDemand<(), Arc<PrefixSum>>,
    small_pixels: u32,
}

/// The triangles of one image, dealt out: serves any number of passes over them.
#[derive(Debug)]
pub struct RasterWork {
    pass: Buffer,
    work: Buffer,
    groups: Buffer,
    find: (ComputePipeline, BindGroup),
    deal: (ComputePipeline, BindGroup),
    sums: (Arc<PrefixSum>, PrefixSumPlan),
    triangle_count: u32,
}

impl ComputeRaster {
    /// None yet.
    pub fn new(gpu: &Gpu) -> Self {
        Self::of_small(if gpu.is_software() { SMALL_ON_CPU } else { SMALL_ON_GPU })
    }

    /// One that takes triangles in rectangles of up to so many pixels to be small: what is drawn is the same.
    pub fn of_small(small_pixels: u32) -> Self {
        Self {
            find: PipelinesOnDemand::new("find"),
            deal: PipelinesOnDemand::new("deal"),
            sums: OnDemand::default(),
            small_pixels: small_pixels.min(SMALL_ON_CPU),
        }
    }

    /// Prepares the passes over an image; see [`RasterWork::record`].
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene or what is found of it, [`TracerError::Failed`] for an image with an
    /// edge of more than 32,768 pixels.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        image: RasterImage,
        geometry: &DeviceGeometry,
        triangle_count: u32,
    ) -> Result<RasterWork, TracerError> {
        let size = image.size();
        let most = BLOCK_EDGE * MAX_BLOCKS;
        if let Some(edge) = size.into_iter().find(|edge| *edge > most) {
            return Err(TracerError::Failed(format!(
                "an image that is rasterized in compute has an edge of {edge} pixels, and {most} are the most: turn down --frame-size or \
                 --face-size, or choose build=raster"
            )));
        }
        for (name, buffer) in [("vertex positions", &geometry.positions), ("vertex indices", &geometry.indices)] {
            gpu.check_storage_binding(name, buffer.size(), TRIANGLES)?;
        }
        let (RasterImage::View { touched, .. } | RasterImage::Axis { touched, .. }) = image;
        let pass = RasterPass {
            size,
            triangle_count,
            lane_groups: triangle_count.div_ceil(LANES),
            small_pixels: self.small_pixels,
            touched: u32::from(touched),
            padding: [0; 2],
        };
        let pass = uniform_buffer(gpu, PASS, &pass)?;
        let (axis, image) = match image {
            RasterImage::View { view, .. } => (false, uniform_buffer(gpu, IMAGE, &view)?),
            RasterImage::Axis { space, axis, .. } => {
                let drawn = RasterAxis { space, axis, padding_a: 0, padding_b: 0, padding_c: 0 };
                (true, uniform_buffer(gpu, IMAGE, &drawn)?)
            }
        };
        let work = storage_buffer(gpu, WORK, work_bytes(triangle_count), TRIANGLES)?;
        let groups = gpu.buffer(GROUPS, GROUP_BYTES, BufferUsages::STORAGE | BufferUsages::INDIRECT, "nothing")?;
        let variant = RasterSetup { axis };
        let (find, deal) = (self.find.of(gpu, variant)?, self.deal.of(gpu, variant)?);
        let found = [&image, &geometry.positions, &geometry.indices, &pass, &work].map(Buffer::as_entire_binding);
        let found = bind_group(gpu, &find.get_bind_group_layout(0), &found);
        let dealt = [(3, &pass), (4, &work), (5, &groups)].map(|(place, buffer)| (place, buffer.as_entire_binding()));
        let dealt = bind_group_at(gpu, &deal.get_bind_group_layout(0), &dealt);
        let sums = self.sums.of((), || PrefixSum::new(gpu).map(Arc::new))?;
        let plan = sums.plan(gpu, &work, triangle_count + 1, None)?;
        Ok(RasterWork {
            pass,
            work,
            groups,
            find: (find, found),
            deal: (deal, dealt),
            sums: (sums, plan),
            triangle_count,
        })
    }
}

const GROUP_BYTES: u64 = 12;

fn work_bytes(triangle_count: u32) -> u64 {
    (2 * u64::from(triangle_count) + 1) * 4
}

impl RasterWork {
    /// What it takes of an image, a view or one along an axis.
    pub fn memory(triangle_count: u32, along_axis: bool) -> Vec<MemoryEntry> {
        let image = if along_axis { size_of::<RasterAxis>() } else { size_of::<ViewUniform>() };
        let own = [
            (WORK, work_bytes(triangle_count)),
            (GROUPS, GROUP_BYTES),
            (PASS, size_of::<RasterPass>() as u64),
            (IMAGE, image as u64),
        ];
        let own = own.into_iter().map(|(name, bytes)| MemoryEntry::whole(name, bytes));
        own.chain(PrefixSum::memory(triangle_count + 1)).collect()
    }

    /// Its bytes.
    pub fn bytes(triangle_count: u32, along_axis: bool) -> u64 {
        Self::memory(triangle_count, along_axis).iter().map(|entry| entry.allocated_bytes).sum()
    }

    /// Records what comes before the first pass.
    pub fn record(&self, encoder: &mut CommandEncoder) {
        let (find, bindings) = &self.find;
        dispatch_linear(encoder, find, bindings, self.triangle_count, LANES);
        let (sums, plan) = &self.sums;
        sums.record(encoder, plan);
        let (deal, bindings) = &self.deal;
        dispatch_linear(encoder, deal, bindings, 1, 1);
    }

    /// A pass of a pipeline whose shader draws by `tracebench::raster_work`; `own` is its group 0.
    pub(crate) fn pass(&self, gpu: &Gpu, pipeline: ComputePipeline, own: BindGroup) -> DealtPass {
        let resources = [&self.pass, &self.work].map(Buffer::as_entire_binding);
        let dealt = bind_group(gpu, &pipeline.get_bind_group_layout(1), &resources);
        DealtPass { pipeline, own, dealt, groups: self.groups.clone() }
    }
}

/// A pass over the triangles of an image as they are dealt out.
#[derive(Debug)]
pub(crate) struct DealtPass {
    pipeline: ComputePipeline,
    own: BindGroup,
    dealt: BindGroup,
    groups: Buffer,
}

impl DealtPass {
    /// Records it.
    pub(crate) fn record(&self, encoder: &mut CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.own, &[]);
        pass.set_bind_group(1, &self.dealt, &[]);
        pass.dispatch_workgroups_indirect(&self.groups, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sizes that the host knows are those of the shaders.
    #[test]
    fn sizes_are_those_of_the_shader() {
        let source = tracebench_shaders::Shader::from(RasterSetup { axis: false }).source;
        let value = |name: &str| {
            let declared = format!("const {name}");
            let line = source.lines().find(|line| line.starts_with(&declared))?;
            line.rsplit_once("= ").map(|(_, value)| value.trim_end_matches(';').trim_end_matches(['u', 'i']).to_owned())
        };
        assert_eq!(value("BLOCK_EDGE"), Some(BLOCK_EDGE.to_string()));
        assert_eq!(value("WORKGROUP_SIZE"), Some(LANES.to_string()));
        assert_eq!(value("SUBPIXELS"), Some((0.5 / SNAP_PIXELS).to_string()));
        assert_ne!(value("BLOCK_EDGE"), Some(LANES.to_string()));
    }
}
