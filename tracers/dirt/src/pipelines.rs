//! Pipelines, each made when it is first needed.

use std::sync::Arc;

use tracebench_api::wgpu::ComputePipeline;
use tracebench_api::{Gpu, TracerError};
use tracebench_kit::{
    ComputeRaster, DevicePipelines, Gather, OnDemand, PrefixSum, SearchPipelines, TrianglePipelines, check_limits,
    compute_pipeline,
};
use tracebench_shaders::dirt::{Fill, MIPMAP, SETUP, Trace};

use crate::fetch::Fetch;
use crate::packed::kernels::PackedKernels;
use crate::setup::SetupPipelines;
use crate::shadow_map::ShadowMapPipelines;
use crate::visibility::Visibility;

/// Tiles of a rectangle up to which a lane draws a triangle by itself. A tile is more work than a pixel, and more rounds of loops, up to
/// one a bucket: eight lanes together have 65,535 with Mesa's software driver.
const SMALL_TILES: u32 = 32;

/// Every pipeline.
pub(crate) struct Pipelines {
    pub gpu: Arc<Gpu>,
    setup: OnDemand<(), SetupPipelines>,
    prefix_sum: OnDemand<(), Arc<PrefixSum>>,
    pub raster: ComputeRaster,
    pub fill: TrianglePipelines,
    mipmap: OnDemand<(), ComputePipeline>,
    pub trace: SearchPipelines,
    gather: OnDemand<(), Arc<Gather>>,
    pub fetch: Fetch,
    visibility: OnDemand<(), Arc<Visibility>>,
    shadow_map: OnDemand<(), Arc<ShadowMapPipelines>>,
    pub packed: PackedKernels,
}

impl DevicePipelines for Pipelines {
    // None yet. What every build and trace needs is asked of the device's limits.
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        let filled = Fill::Primitives { conservative: true, split: false };
        let traced = Trace::Plain { textures: false, centres: false, counters: true };
        check_limits(&gpu, SETUP, &["see", "list"])?;
        check_limits(&gpu, filled.into(), &["vertex", "fragment"])?;
        check_limits(&gpu, traced.into(), &["trace"])?;
        Ok(Self {
            gpu,
            setup: OnDemand::default(),
            prefix_sum: OnDemand::default(),
            raster: ComputeRaster::of_small(SMALL_TILES),
            fill: TrianglePipelines::new(),
            mipmap: OnDemand::default(),
            trace: SearchPipelines::default(),
            gather: OnDemand::default(),
            fetch: Fetch::default(),
            visibility: OnDemand::default(),
            shadow_map: OnDemand::default(),
            packed: PackedKernels::default(),
        })
    }
}

impl Pipelines {
    /// Whether the device binds the buffers that nodes, depth bounds and heads are split into where one binding does not
    /// hold them.
    pub(crate) fn can_split(gpu: &Gpu) -> bool {
        let traced = Trace::Split { centres: false, counters: true }.into();
        let filled = Fill::Primitives { conservative: true, split: true }.into();
        let fills = || check_limits(gpu, filled, &["vertex", "fragment"]);
        check_limits(gpu, traced, &["trace"]).and_then(|()| fills()).is_ok()
    }

    pub(crate) fn setup(&self) -> Result<SetupPipelines, TracerError> {
        let pipeline = |entry_point| compute_pipeline(&self.gpu, SETUP, entry_point);
        self.setup.of((), || Ok(SetupPipelines { see: pipeline("see")?, list: pipeline("list")? }))
    }

    pub(crate) fn prefix_sum(&self) -> Result<Arc<PrefixSum>, TracerError> {
        self.prefix_sum.of((), || PrefixSum::new(&self.gpu).map(Arc::new))
    }

    pub(crate) fn mipmap(&self) -> Result<ComputePipeline, TracerError> {
        self.mipmap.of((), || compute_pipeline(&self.gpu, MIPMAP, "mipmap"))
    }

    pub(crate) fn gather(&self) -> Result<Arc<Gather>, TracerError> {
        self.gather.of((), || Gather::new(&self.gpu).map(Arc::new))
    }

    pub(crate) fn visibility(&self) -> Result<Arc<Visibility>, TracerError> {
        self.visibility.of((), || Visibility::new(&self.gpu).map(Arc::new))
    }

    pub(crate) fn shadow_map(&self) -> Result<Arc<ShadowMapPipelines>, TracerError> {
        self.shadow_map.of((), || ShadowMapPipelines::new(&self.gpu).map(Arc::new))
    }
}
