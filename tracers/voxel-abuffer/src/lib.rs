//! `voxel-abuffer`: ray tracing through voxels and three orthographic A-buffers.
//!
//! Hu, Huang, Zhang, Yuan, Li, *Ray tracing via GPU rasterization*, The Visual Computer 2014. The scene is rasterized along the three
//! axes, every fragment of every texel is kept in order of depth, and a uniform grid of averaged normals says where anything is and by
//! which of the three images to look at it. A ray goes from voxel to voxel; in one that has anything, points on it are told inside or
//! outside by the layers before them, and where that changes it has met a surface. Nothing of it hangs on a viewpoint.

mod arrays;
mod brute_force;
mod brute_planes;
mod buffers;
mod build;
mod description;
mod layout;
mod nodes;
mod planes;
mod search;
mod structure;
#[cfg(test)]
mod tests;
mod trace;
mod validate;

pub use description::description;
pub use structure::VoxelAbuffer;
