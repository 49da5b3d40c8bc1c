//! The registration of `bvh-cpu`: an analytic method in f32 that sees every triangle and no view.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("bvh_cpu.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_bvh::description,
    create: |_| Ok(Box::new(tracebench_bvh::BvhCpu)),
    parts: None,
    told: &TOLD,
};
