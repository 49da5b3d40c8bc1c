//! The pipelines, and what they are told.

use std::sync::Arc;

use tracebench_api::wgpu::ComputePipeline;
use tracebench_api::{Geometry, Gpu, TracerError};
use tracebench_kit::{RadixSort, compute_pipeline};
pub(crate) use tracebench_shaders::bvh::{
    Blocks, BuildSettings, Iteration as ClusterIteration, Level as ConversionLevel, Stage as RefitStage,
};
use tracebench_shaders::bvh::{CONVERT, Cluster, LEAVES, RadixTree, Refit};

/// As `WORKGROUP_SIZE` in shaders/bvh.
pub(super) const WORKGROUP_SIZE: u32 = 64;

/// Bits of a Morton code.
pub(super) const CODE_BITS: u32 = 30;

/// Cells of the Morton grid along an axis.
const CELLS: f64 = 1024.0;

/// `RUN` of shaders/bvh/cluster.wgsl.
pub(super) const RUN: u32 = 16;

/// `SEARCHED` there.
pub(super) const SEARCHED: u32 = 8;

/// `RAISED` of shaders/bvh/radix_tree.wgsl.
pub(super) const RAISED: u32 = 4;

/// `FINISHED` of shaders/bvh/build.wgsl.
pub(super) const FINISHED: usize = 128;

/// `TAKEN_SLOTS` there.
pub(super) const TAKEN_SLOTS: usize = 256;

/// `CROWDED` there.
pub(super) const CROWDED: usize = 257;

/// `LEVELS` there.
pub(super) const LEVELS: usize = 258;

/// What builds are told of a scene.
pub(super) fn build_settings(geometry: &Geometry, scale: f32) -> BuildSettings {
    let extent = (geometry.bounds_max.as_dvec3() - geometry.bounds_min.as_dvec3()) * f64::from(scale);
    // More cells than f32 can tell apart, as for a scene that is flat but for rounding, are as good as none.
    let cells = |extent: f64| if extent > 1e-30 { (CELLS / extent) as f32 } else { 0.0 };
    BuildSettings {
        low: (geometry.bounds_min * scale).to_array(),
        triangle_count: geometry.triangles.len() as u32,
        cells_per_unit: extent.to_array().map(cells),
        scale,
    }
}

/// The kernels of clustering for one kind of node.
pub(super) struct ClusterKernels {
    pub(super) search: ComputePipeline,
    pub(super) tally: ComputePipeline,
    pub(super) add_up: ComputePipeline,
    pub(super) merge: ComputePipeline,
    pub(super) finish: ComputePipeline,
}

impl ClusterKernels {
    fn new(gpu: &Gpu, variant: Cluster) -> Result<Self, TracerError> {
        let pipeline = |entry_point| compute_pipeline(gpu, variant, entry_point);
        Ok(Self {
            search: pipeline("search")?,
            tally: pipeline("tally")?,
            add_up: pipeline("add_up")?,
            merge: pipeline("merge")?,
            finish: pipeline("finish")?,
        })
    }
}

/// Every pipeline of builds and refits.
pub(super) struct Kernels {
    pub(super) gpu: Arc<Gpu>,
    pub(super) sort: RadixSort,
    pub(super) encode: ComputePipeline,
    pub(super) place: ComputePipeline,
    pub(super) fill: ComputePipeline,
    pub(super) cluster_binary: ClusterKernels,
    pub(super) cluster_wide: ClusterKernels,
    pub(super) raise: ComputePipeline,
    pub(super) link_binary: ComputePipeline,
    pub(super) link_wide: ComputePipeline,
    pub(super) convert: ComputePipeline,
    pub(super) refit_binary: ComputePipeline,
    pub(super) refit_binary_last: ComputePipeline,
    pub(super) refit_wide: ComputePipeline,
}

impl Kernels {
    /// Compiles them.
    pub(super) fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        let leaves = |entry_point| compute_pipeline(&gpu, LEAVES, entry_point);
        Ok(Self {
            sort: RadixSort::new(&gpu)?,
            encode: leaves("encode")?,
            place: leaves("place")?,
            fill: leaves("fill")?,
            cluster_binary: ClusterKernels::new(&gpu, Cluster { wide: false })?,
            cluster_wide: ClusterKernels::new(&gpu, Cluster { wide: true })?,
            raise: compute_pipeline(&gpu, RadixTree { wide: false }, "raise")?,
            link_binary: compute_pipeline(&gpu, RadixTree { wide: false }, "link")?,
            link_wide: compute_pipeline(&gpu, RadixTree { wide: true }, "link")?,
            convert: compute_pipeline(&gpu, CONVERT, "convert")?,
            refit_binary: compute_pipeline(&gpu, Refit { wide: false }, "fit")?,
            refit_binary_last: compute_pipeline(&gpu, Refit { wide: false }, "fit_last")?,
            refit_wide: compute_pipeline(&gpu, Refit { wide: true }, "fit")?,
            gpu,
        })
    }
}
