//! The registration of `ray-query`, whose triangle test is the driver's own: Vulkan asks drivers for a watertight one
//! (VK_KHR_ray_query, "Watertightness"), and Mesa's software driver (25.0) has one. Another driver that does worse comes out as
//! unexpected, which is what its column is for.

use super::{Family, Registration};

pub(crate) const REGISTRATION: Registration =
    Registration::analytic(tracebench_bvh::ray_query_description, Family::Bvh, |gpu| {
        Ok(Box::new(tracebench_bvh::RayQuery::new(gpu?)?))
    });
