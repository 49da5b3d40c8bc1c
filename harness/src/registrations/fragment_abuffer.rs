//! The registration of `fragment-abuffer`: fragments at pixels' centres, every layer, seven views, no thickness; improved, fragments that
//! are planes, in every pixel that a triangle touches.
//! Its ablation: each of the two switches that change what is stored alone, and both; then the improved form, and its switches taken back
//! one by one.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("fragment_abuffer.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_fragment_abuffer::description,
    create: |gpu| Ok(Box::new(tracebench_fragment_abuffer::FragmentAbuffer::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
