//! The registration of `quadtree`: two depth layers of the frame, each pixel a small plane, merged by thresholds in the unit cube.
//! Its ablation: from row to row one thing more (normals of triangles, thresholds in pixels, the flag from smaller steps, planes that end
//! at each other); then the improved form, and single switches of it taken back or turned.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("quadtree.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_quadtree::description,
    create: |gpu| Ok(Box::new(tracebench_quadtree::Quadtree::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
