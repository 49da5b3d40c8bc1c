//! The room of `lbvh-gpu`, which has the searches of `bvh-gpu` over hierarchies built on the device.

use super::{Family, OF_HIERARCHIES, Registration};

pub(crate) const ROOM: Registration = Registration {
    touches: OF_HIERARCHIES,
    ..Registration::analytic(tracebench_bvh::lbvh_description, Family::Bvh, |gpu| {
        Ok(Box::new(tracebench_bvh::LbvhGpu::new(gpu?)?))
    })
};
