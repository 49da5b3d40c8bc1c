//! The registration of `ray-query`, whose triangle test is the driver's own: Vulkan asks drivers for a watertight one
//! (VK_KHR_ray_query, "Watertightness"), and Mesa's software driver (25.0) has one. Another driver that does worse comes out as
//! unexpected, which is what its column is for.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("ray_query.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_bvh::ray_query_description,
    create: |gpu| Ok(Box::new(tracebench_bvh::RayQuery::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
