//! The registration of `bvh-gpu`: an analytic method with a watertight triangle test that sees every triangle and no view.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("bvh_gpu.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_bvh::gpu_description,
    create: |gpu| Ok(Box::new(tracebench_bvh::BvhGpu::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
