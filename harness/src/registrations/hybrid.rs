//! The registration of `hybrid`, a tracer of two others, which its parameters `first` and `then` name.

use std::sync::LazyLock;

use tracebench_api::{Preset, Tracer, TracerDescription, TracerError};
use tracebench_hybrid::{Hybrid, Part as Described, description};

use super::{Device, Part, Registration, TRACERS, Told, embedded, ploc_gpu, screen_dda};

static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("hybrid.json")));

pub(crate) static REGISTRATION: Registration = Registration {
    description: || describe(DEFAULT),
    create: |device| create(DEFAULT, device),
    parts: Some(*DEFAULT),
    told: &TOLD,
};

/// The parameters that name the parts; before a full stop they stand in the names of the parts' own.
pub(super) const PARAMETERS: [&str; 2] = ["first", "then"];

/// A march in screen space, and where it found nothing the scene itself.
static DEFAULT: &[Part; 2] = &[
    Part { registration: &screen_dda::REGISTRATION, preset: Preset::Improved, name: "screen-dda:improved" },
    Part { registration: &ploc_gpu::REGISTRATION, preset: Preset::Published, name: "ploc-gpu:published" },
];

/// What a hybrid can be made of: every tracer on the device.
fn all() -> impl Iterator<Item = &'static Registration> {
    TRACERS.iter().filter(|each| each.parts.is_none() && each.needs_device())
}

/// Their names, alone and with each preset.
static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| {
    let of = |each: &Registration| ["", ":published", ":improved"].map(|end| &*format!("{}{end}", each.name()).leak());
    all().flat_map(of).collect()
});

/// The part of a value of theirs.
pub(super) fn find(name: &str) -> Option<Part> {
    let name = *NAMES.iter().find(|known| **known == name)?;
    let (tracer, preset) = name.split_once(':').unwrap_or((name, Preset::Published.name()));
    let registration = all().find(|each| each.name() == tracer)?;
    let preset = Preset::ALL.into_iter().find(|each| each.name() == preset)?;
    Some(Part { registration, preset, name })
}

fn described(&Part { registration, preset, name }: &Part) -> Described {
    Described { description: registration.describe(), preset, name }
}

pub(super) fn describe(parts: &[Part; 2]) -> TracerDescription {
    description(&parts.each_ref().map(described), &NAMES)
}

pub(super) fn create(parts: &[Part; 2], device: Device) -> Result<Box<dyn Tracer>, TracerError> {
    let [first, then] = parts.each_ref().map(|part| part.registration.create(&device));
    Ok(Box::new(Hybrid::new(device?, parts.each_ref().map(described), [first?, then?])?))
}
