//! The registration of `bvh-gpu`: an analytic method with a watertight triangle test that sees every triangle and no view.

use super::{Family, OF_HIERARCHIES, Registration};

pub(crate) const REGISTRATION: Registration = Registration {
    touches: OF_HIERARCHIES,
    ..Registration::analytic(tracebench_bvh::gpu_description, Family::Bvh, |gpu| {
        Ok(Box::new(tracebench_bvh::BvhGpu::new(gpu?)?))
    })
};
