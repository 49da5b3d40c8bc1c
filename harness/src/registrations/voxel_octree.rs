//! The registration of `voxel-octree`: every voxel that a triangle touches, and hits as precise as one.
//! Where a ray ends in a voxel is never right; what is expected is whether it ends at a surface. Its remedies take away a voxel's extent,
//! from its entry to its centre and then all of it.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("voxel_octree.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_voxel_octree::description,
    create: |gpu| Ok(Box::new(tracebench_voxel_octree::VoxelOctree::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
