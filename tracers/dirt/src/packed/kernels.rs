//! The pipelines of the packed forms, each made when it is first needed.

use std::sync::Arc;

use tracebench_api::wgpu::ComputePipeline;
use tracebench_api::{Gpu, TracerError};
use tracebench_kit::{OnDemand, PrefixSum, RadixSort, SearchPipelines, compute_pipeline};
use tracebench_shaders::dirt::{PartLists, PartTrees};

use super::buffers::Sorting;
use crate::description::Lists;

/// Those of a build.
#[derive(Clone, Debug)]
pub(crate) struct BuildKernels {
    pub measure: ComputePipeline,
    pub scale: ComputePipeline,
    pub count: ComputePipeline,
    pub count_several: ComputePipeline,
    pub count_large: ComputePipeline,
    pub store: ComputePipeline,
    pub store_several: ComputePipeline,
    pub store_large: ComputePipeline,
    pub bound: ComputePipeline,
    pub size: ComputePipeline,
    pub leaves: ComputePipeline,
    pub join: ComputePipeline,
    pub list: ComputePipeline,
    pub join_masks: ComputePipeline,
}

/// Prefix sums and the sort.
#[derive(Debug)]
pub(crate) struct SortKernels {
    sums: PrefixSum,
    sort: RadixSort,
}

impl SortKernels {
    pub(super) fn sorting(&self) -> Sorting<'_> {
        Sorting { sums: &self.sums, sort: &self.sort }
    }
}

/// Every pipeline.
#[derive(Default)]
pub(crate) struct PackedKernels {
    build: OnDemand<bool, BuildKernels>,
    sort: OnDemand<(), Arc<SortKernels>>,
    pub(super) trace: SearchPipelines,
}

impl PackedKernels {
    pub(super) fn build(&self, gpu: &Gpu, lists: Lists) -> Result<BuildKernels, TracerError> {
        let slices = lists == Lists::Slices;
        let listing = |entry_point| compute_pipeline(gpu, PartLists { slices }, entry_point);
        let growing = |entry_point| compute_pipeline(gpu, PartTrees { slices }, entry_point);
        self.build.of(slices, || {
            Ok(BuildKernels {
                measure: listing("measure")?,
                scale: listing("scale")?,
                count: listing("count")?,
                count_several: listing("count_several")?,
                count_large: listing("count_large")?,
                store: listing("store")?,
                store_several: listing("store_several")?,
                store_large: listing("store_large")?,
                bound: growing("bound")?,
                size: growing("size")?,
                leaves: growing("leaves")?,
                join: growing("join")?,
                list: growing("list")?,
                join_masks: growing("join_masks")?,
            })
        })
    }

    pub(super) fn sort(&self, gpu: &Gpu) -> Result<Arc<SortKernels>, TracerError> {
        self.sort.of((), || Ok(Arc::new(SortKernels { sums: PrefixSum::new(gpu)?, sort: RadixSort::new(gpu)? })))
    }
}
