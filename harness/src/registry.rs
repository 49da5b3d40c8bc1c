//! Every tracer, a line each.

use std::sync::Arc;

use tracebench_api::{Description, Gpu, Residency, Tracer, TracerError};

/// The device, or why there is none: what a tracer that needs one is skipped for.
pub type Device = Result<Arc<Gpu>, TracerError>;

/// How a tracer is created.
pub type Create = fn(Device) -> Result<Box<dyn Tracer>, TracerError>;

/// What kind of structure a tracer searches. Tracers of one family are peers: they stand in one table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// A hierarchy of bounding volumes.
    Bvh,
    /// What views show of the scene.
    Image,
}

/// A tracer in the registry.
#[derive(Clone, Copy)]
pub struct Registration {
    /// What it is and takes.
    pub describe: fn() -> Description,
    /// Its peers.
    pub family: Family,
    /// Creates it; the device is there for tracers that live on one.
    pub(crate) create: Create,
}

/// Every tracer, in the order of tables.
pub const TRACERS: &[Registration] = &[
    Registration {
        describe: tracebench_bvh::description,
        family: Family::Bvh,
        create: |_| Ok(Box::new(tracebench_bvh::BvhCpu)),
    },
    Registration {
        describe: tracebench_bvh::gpu_description,
        family: Family::Bvh,
        create: |gpu| Ok(Box::new(tracebench_bvh::BvhGpu::new(gpu?)?)),
    },
    Registration {
        describe: tracebench_bvh::lbvh_description,
        family: Family::Bvh,
        create: |gpu| Ok(Box::new(tracebench_bvh::LbvhGpu::new(gpu?)?)),
    },
    Registration {
        describe: tracebench_bvh::ray_query_description,
        family: Family::Bvh,
        create: |gpu| Ok(Box::new(tracebench_bvh::RayQuery::new(gpu?)?)),
    },
    Registration {
        describe: tracebench_dirt::description,
        family: Family::Image,
        create: |gpu| Ok(Box::new(tracebench_dirt::Dirt::new(gpu?)?)),
    },
    Registration {
        describe: tracebench_fragment_abuffer::description,
        family: Family::Image,
        create: |gpu| Ok(Box::new(tracebench_fragment_abuffer::FragmentAbuffer::new(gpu?)?)),
    },
    Registration {
        describe: tracebench_screen_dda::description,
        family: Family::Image,
        create: |gpu| Ok(Box::new(tracebench_screen_dda::ScreenDda::new(gpu?)?)),
    },
];

impl Registration {
    /// A tracer that is in no registry, as tests have them.
    pub fn given(describe: fn() -> Description, family: Family, create: Create) -> Self {
        Self { describe, family, create }
    }

    /// Creates the tracer with its pipelines.
    ///
    /// # Errors
    /// Why there is no device, if it needs one; [`TracerError::Unavailable`] if this machine cannot run it.
    pub fn create(&self, device: &Device) -> Result<Box<dyn Tracer>, TracerError> {
        (self.create)(device.clone())
    }

    /// Whether it needs a device.
    pub fn needs_device(&self) -> bool {
        (self.describe)().residency == Residency::Device
    }
}

/// Finds a tracer by name.
pub fn find(name: &str) -> Option<&'static Registration> {
    TRACERS.iter().find(|registration| (registration.describe)().name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names are unique, and every preset value lies within its own range.
    #[test]
    fn descriptions_are_consistent() {
        let mut names: Vec<_> = TRACERS.iter().map(|registration| (registration.describe)().name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), TRACERS.len());
        for registration in TRACERS {
            for parameter in (registration.describe)().parameters {
                let values = [&parameter.published, &parameter.improved].into_iter().chain(&parameter.sweep);
                for value in values {
                    assert_eq!(parameter.parse(&value.to_string()).as_ref(), Ok(value), "{}", parameter.name);
                }
            }
        }
    }
}
