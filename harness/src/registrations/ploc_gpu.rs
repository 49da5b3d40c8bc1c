//! The registration of `ploc-gpu`, which has the searches of `bvh-gpu` over hierarchies built on the device.
//! Its ablation: fewer neighbours early, late and throughout, and none, of both kinds of nodes.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("ploc_gpu.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_bvh::ploc_description,
    create: |gpu| Ok(Box::new(tracebench_bvh::PlocGpu::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
