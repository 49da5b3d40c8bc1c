//! Pipelines, each made when it is first needed.

use std::sync::Arc;

use tracebench_api::wgpu::{ComputePipeline, RenderPipeline};
use tracebench_api::{Gpu, TracerError};
use tracebench_kit::{EmptyTarget, Gather, OnDemand, PipelinesOnDemand, PrefixSum, check_limits, compute_pipeline};
use tracebench_shaders::dirt::{Fill, MIPMAP, SETUP, Trace};

use crate::fetch::Fetch;
use crate::setup::SetupPipelines;
use crate::visibility::Visibility;

/// Every pipeline.
pub(crate) struct Pipelines {
    pub gpu: Arc<Gpu>,
    setup: OnDemand<(), SetupPipelines>,
    prefix_sum: OnDemand<(), Arc<PrefixSum>>,
    fill: OnDemand<Fill, RenderPipeline>,
    mipmap: OnDemand<(), ComputePipeline>,
    trace: PipelinesOnDemand<Trace>,
    gather: OnDemand<(), Arc<Gather>>,
    pub fetch: Fetch,
    visibility: OnDemand<(), Arc<Visibility>>,
}

impl Pipelines {
    /// None yet. What every build and trace needs is asked of the device's limits.
    pub(crate) fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        for shader in [
            SETUP,
            Fill::Primitives { conservative: true, split: false }.into(),
            Trace { split: false, centres: false, counters: true }.into(),
        ] {
            check_limits(&gpu, shader)?;
        }
        Ok(Self {
            gpu,
            setup: OnDemand::default(),
            prefix_sum: OnDemand::default(),
            fill: OnDemand::default(),
            mipmap: OnDemand::default(),
            trace: PipelinesOnDemand::new("trace"),
            gather: OnDemand::default(),
            fetch: Fetch::default(),
            visibility: OnDemand::default(),
        })
    }

    /// Whether the device binds the buffers that nodes, depth bounds and heads are split into where one binding does not
    /// hold them.
    pub(crate) fn can_split(gpu: &Gpu) -> bool {
        let traced = Trace { split: true, centres: false, counters: true }.into();
        let filled = Fill::Primitives { conservative: true, split: true }.into();
        check_limits(gpu, traced).and_then(|()| check_limits(gpu, filled)).is_ok()
    }

    pub(crate) fn setup(&self) -> Result<SetupPipelines, TracerError> {
        let pipeline = |entry_point| compute_pipeline(&self.gpu, SETUP, entry_point);
        self.setup.of((), || Ok(SetupPipelines { see: pipeline("see")?, list: pipeline("list")? }))
    }

    pub(crate) fn prefix_sum(&self) -> Result<Arc<PrefixSum>, TracerError> {
        self.prefix_sum.of((), || PrefixSum::new(&self.gpu).map(Arc::new))
    }

    pub(crate) fn fill(&self, variant: Fill) -> Result<RenderPipeline, TracerError> {
        self.fill.of(variant, || EmptyTarget::pipeline(&self.gpu, variant))
    }

    pub(crate) fn mipmap(&self) -> Result<ComputePipeline, TracerError> {
        self.mipmap.of((), || compute_pipeline(&self.gpu, MIPMAP, "mipmap"))
    }

    pub(crate) fn trace(&self, variant: Trace) -> Result<ComputePipeline, TracerError> {
        self.trace.of(&self.gpu, variant)
    }

    pub(crate) fn gather(&self) -> Result<Arc<Gather>, TracerError> {
        self.gather.of((), || Gather::new(&self.gpu).map(Arc::new))
    }

    pub(crate) fn visibility(&self) -> Result<Arc<Visibility>, TracerError> {
        self.visibility.of((), || Visibility::new(&self.gpu).map(Arc::new))
    }
}
