//! The registration of `mesh-warp`: one depth a pixel from one view as a mesh, drawn from where rays start.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("mesh_warp.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_mesh_warp::description,
    create: |gpu| Ok(Box::new(tracebench_mesh_warp::MeshWarp::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
