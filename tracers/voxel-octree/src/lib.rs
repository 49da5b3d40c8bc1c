//! `voxel-octree`: ray tracing through a sparse voxel octree, what Hu, Huang, Zhang, Yuan, Li (*Ray tracing via GPU rasterization*, The
//! Visual Computer 2014, Table 1) set their method beside.
//!
//! Crassin, Neyret, Sainz, Green, Eisemann, *Interactive Indirect Illumination Using Voxel Cone Tracing*, Computer Graphics Forum 30(7),
//! 2011, without the cones: rays end at leaves, exactly. Every triangle is cut into the voxels that it touches, those are sorted along
//! Morton's curve and made unique, and the levels of the tree are built on them from below. A leaf has a normal and a material, so that an
//! answer is as precise as a voxel. Nothing of it hangs on a viewpoint but the number of levels, where that is left to it.

mod build;
mod counts;
mod description;
mod kernels;
mod layout;
mod reference;
mod scratch;
mod structure;
#[cfg(test)]
mod tests;
mod trace;
mod validate;

pub use description::description;
pub use structure::VoxelOctree;
