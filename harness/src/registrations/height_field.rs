//! The registration of `height-field`: one depth a pixel from one view, all behind it solid.

use std::sync::LazyLock;

use super::{Registration, Told, embedded};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("height_field.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: tracebench_height_field::description,
    create: |gpu| Ok(Box::new(tracebench_height_field::HeightField::new(gpu?)?)),
    parts: None,
    told: &TOLD,
};
