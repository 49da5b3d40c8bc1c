//! The registration of `screen-dda`: one depth a pixel, sampled at pixel centres, from one view.
//! Its ablation: each switch alone; then the improved form, and its switches taken back one by one.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("screen_dda.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_screen_dda::description,
    create: |gpu| Ok(Box::new(tracebench_screen_dda::ScreenDda::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
