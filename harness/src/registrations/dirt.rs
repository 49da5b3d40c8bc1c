//! The registration of `dirt`: analytic hits on every triangle that touches a tile of six views, found bucket by bucket; improved, by a
//! tree in every tile.
//! Its ablation: from row to row one thing more (hits by their distance, no near plane, rays split near the eye, drawn in compute); then
//! the improved form, and single switches of it taken back or turned.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("dirt.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_dirt::description,
    create: |gpu| Ok(Box::new(tracebench_dirt::Dirt::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
