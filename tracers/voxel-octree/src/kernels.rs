//! The pipelines of builds and traces.

use std::sync::Arc;

use tracebench_api::wgpu::ComputePipeline;
use tracebench_api::{Gpu, TracerError};
use tracebench_kit::{DevicePipelines, PipelinesOnDemand, PrefixSum, RadixSort, check_limits, compute_pipeline};
use tracebench_shaders::voxel_octree::{LEAVES, LEVELS, Trace, VOXELIZE};

/// As `WORKGROUP_SIZE` in shaders/voxel-octree/settings.wgsl.
pub(crate) const WORKGROUP_SIZE: u32 = 64;

/// Every pipeline; those of traces are made when they are first needed.
pub struct Kernels {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) sort: RadixSort,
    pub(crate) prefix_sum: PrefixSum,
    pub(crate) measure: ComputePipeline,
    pub(crate) count: ComputePipeline,
    pub(crate) emit: ComputePipeline,
    pub(crate) pad: ComputePipeline,
    pub(crate) mark_leaves: ComputePipeline,
    pub(crate) gather: ComputePipeline,
    pub(crate) sum: ComputePipeline,
    pub(crate) finish: ComputePipeline,
    pub(crate) mark_nodes: ComputePipeline,
    pub(crate) join: ComputePipeline,
    pub(crate) trace: PipelinesOnDemand,
}

impl DevicePipelines for Kernels {
    // Compiles those of builds.
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        for trace in <Trace as tracebench_shaders::Variant>::ALL {
            check_limits(&gpu, (*trace).into(), &["trace"])?;
        }
        let voxelize = |entry_point| compute_pipeline(&gpu, VOXELIZE, entry_point);
        let leaves = |entry_point| compute_pipeline(&gpu, LEAVES, entry_point);
        let levels = |entry_point| compute_pipeline(&gpu, LEVELS, entry_point);
        Ok(Self {
            sort: RadixSort::new(&gpu)?,
            prefix_sum: PrefixSum::new(&gpu)?,
            measure: voxelize("measure")?,
            count: voxelize("count")?,
            emit: voxelize("emit")?,
            pad: voxelize("pad")?,
            mark_leaves: leaves("mark")?,
            gather: leaves("gather")?,
            sum: leaves("sum")?,
            finish: leaves("finish")?,
            mark_nodes: levels("mark")?,
            join: levels("join")?,
            trace: PipelinesOnDemand::new("trace"),
            gpu,
        })
    }
}
