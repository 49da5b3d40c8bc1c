//! Device parts that several tracers share: structures that are rebuilt, a view's depths as one, views as uniforms, pipelines
//! and dispatches, buffers that are kept and grow, pyramids' levels, prefix sums and sorts, rasterized eye depth and triangles,
//! layer behind layer, pyramids over eye depth, triangles rasterized in compute, surfaces of hits, counts of rays, bits for
//! what is touched, the unit cube of methods that sample along axes, how searches read and are launched, work that is the same
//! every time; and clipping, coverage and drawing on the host, which what they rasterize is held against.

mod brute_force;
mod clip;
mod compute;
mod compute_raster;
mod counts;
mod coverage;
mod depth_pyramid;
mod device_tracer;
mod empty_target;
mod eye_depth;
mod fixed_work;
mod gather;
mod growable_buffer;
mod image_method;
mod lanes;
mod launch_probe;
mod memory_access;
mod nearest_compute;
mod nearest_layers;
mod nearest_raster;
mod on_demand;
mod prefix_sum;
mod primitive_texture;
mod pyramid;
mod radix_sort;
mod raster;
mod raster_probe;
mod texture;
mod touched;
mod triangle_pass;
mod unit_space;
mod view_images;
mod view_uniform;
mod visibility;

pub use brute_force::{Allowed, AllowedFragments, Fragment, allowed_fragments, undecided_border};
pub use clip::{TileBounds, clipped_depths, clipped_polygon, eye_space, touched_tiles};
pub use compute::{
    PipelinesOnDemand, bind_group, bind_group_at, check_limits, compute_pipeline, dispatch_linear,
    dispatch_linear_groups, every_variant, untimed,
};
pub use compute_raster::{ComputeRaster, RasterBackend, RasterImage, RasterWork, build_parameter};
pub use counts::{RayCounts, TraceCounts};
pub use coverage::{SUBPIXELS, covers_centre};
pub use depth_pyramid::{CellDepths, DepthPyramid, PyramidBuilder, PyramidLayout, PyramidShape};
pub use device_tracer::{BuildJob, Built, DevicePipelines, DeviceStructure, DeviceTracer, Search, SearchJob};
pub use empty_target::EmptyTarget;
pub use eye_depth::{DepthCopy, EyeDepthTarget, NO_SURFACE};
pub use fixed_work::{FixedWork, FixedWorkPlan, fixed_task};
pub use gather::{Gather, SurfaceGeometry};
pub use growable_buffer::{GrowableBuffer, grow, storage_buffer, uniform_buffer};
pub use image_method::{ImageMethod, ImageMethodPipelines, ImageStructure};
pub use lanes::{
    LANES_OF_WORKGROUP, Left, MAX_RAYS_PER_LANE, SearchPipelines, SearchedRays, dispatch_indirect, dispatch_rays,
    rays_per_lane_parameter, rays_within_rounds,
};
pub use launch_probe::{MANY_RAYS, ProbeTimes, probe_launch};
pub use memory_access::{
    MemoryAccess, READS_GROUP, ROW_BITS, ReadSlot, Readable, bind_arrays, memory_access_parameter, record_copies,
};
pub use nearest_compute::NearestOf;
pub use nearest_layers::{LayerTarget, NearestLayers, NearestPass, NearestScene};
pub use nearest_raster::{DEPTH_TEST_FORMAT, Passing, backs, behind};
pub use on_demand::OnDemand;
pub use prefix_sum::{PrefixSum, PrefixSumPlan};
pub use primitive_texture::PrimitiveTexture;
pub use pyramid::{MAX_LEVELS, Pyramid};
pub use radix_sort::{RadixSort, RadixSortPlan};
pub use raster::{RasterTargets, raster_pipeline};
pub use raster_probe::rasterizer;
pub use texture::create_texture;
pub use touched::{TouchedBits, bits_on};
pub use triangle_pass::{Canvas, TrianglePass, TrianglePipelines};
pub use unit_space::{
    Fit, UnitSpace, across_and_down, samplings_along_axes, to_scene, to_unit, unit_space, voxel_grid,
};
pub use view_images::{ImagePipelines, ImageSearch, ImageShape, Images, RasterizedView};
pub use view_uniform::{ViewUniform, view_uniform, view_uniforms};
pub use visibility::{VisibilityBuffer, VisibilityPass, VisibilityView};
