//! The registration of `voxel-abuffer`: layers at texels' centres along three axes of the scene's bounds, inside told from outside;
//! improved, planes that are clipped to texels, each a part of the surface itself.
//! Its ablation: from row to row one thing more, up to the best that is known of points and the same with starts lifted off their surface;
//! then the improved form, and single switches of it turned.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("voxel_abuffer.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_voxel_abuffer::description,
    create: |gpu| Ok(Box::new(tracebench_voxel_abuffer::VoxelAbuffer::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
