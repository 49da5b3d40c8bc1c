//! Tests across crates. One program, which is linked once, and whose cores are busy while one of them waits for a long test.

mod bvh_gpu;
mod cause_evidence;
mod coverage;
mod dirt_exact;
mod dirt_surfaces;
mod empty_slots;
mod fragment_causes;
mod layouts;
mod marches;
mod ploc_gpu;
mod quadtree;
mod ray_query;
mod sah;
mod screen_dda;
mod shaders;
mod sorting;
mod subject;
mod touched;
mod tracers;
mod triangles;
mod walks;
