//! The registration of `hybrid`, a tracer of two others, which its parameters `first` and `then` name.

use std::sync::LazyLock;

use tracebench_api::{Preset, Tracer, TracerDescription, TracerError};
use tracebench_hybrid::{Hybrid, Part as Described, description};

use super::{Device, Family, Part, Parts, Registration};
use super::{
    bvh_gpu, dirt, fragment_abuffer, height_field, mesh_warp, ploc_gpu, quadtree, ray_query, screen_dda, voxel_abuffer,
    voxel_octree,
};

pub(crate) const REGISTRATION: Registration = Registration {
    parts: Some(Parts { of: DEFAULT, names: &["first", "then"], find, describe, create }),
    forms: &[&[("first", "quadtree:improved")]],
    excluded_from_fronts: &["dispatch"],
    ..Registration::sampled(|| describe(&DEFAULT), Family::Image, |device| create(&DEFAULT, device))
};

/// A march in screen space, and where it found nothing the scene itself.
const DEFAULT: [Part; 2] = [
    Part { registration: &screen_dda::REGISTRATION, preset: Preset::Improved },
    Part { registration: &ploc_gpu::REGISTRATION, preset: Preset::Published },
];

/// What a hybrid can be made of: every tracer on the device.
const ALL: &[&Registration] = &[
    &bvh_gpu::REGISTRATION,
    &ploc_gpu::REGISTRATION,
    &ray_query::REGISTRATION,
    &dirt::REGISTRATION,
    &fragment_abuffer::REGISTRATION,
    &voxel_abuffer::REGISTRATION,
    &voxel_octree::REGISTRATION,
    &quadtree::REGISTRATION,
    &screen_dda::REGISTRATION,
    &height_field::REGISTRATION,
    &mesh_warp::REGISTRATION,
];

/// Their names, alone and with each preset.
static NAMES: LazyLock<Vec<(&str, Part)>> = LazyLock::new(|| {
    let of = |registration: &'static Registration| {
        let name = registration.name();
        let preset = |preset: Preset| (&*format!("{name}:{}", preset.name()).leak(), Part { registration, preset });
        let plain = (name, Part { registration, preset: Preset::Published });
        std::iter::once(plain).chain(Preset::ALL.map(preset))
    };
    ALL.iter().flat_map(|registration| of(registration)).collect()
});

static LIST: LazyLock<Vec<&str>> = LazyLock::new(|| NAMES.iter().map(|(name, _)| *name).collect());

fn find(name: &str) -> Option<Part> {
    NAMES.iter().find(|(known, _)| *known == name).map(|(_, part)| *part)
}

fn described(part: &Part) -> Described {
    let same = |(_, other): &&(&str, Part)| {
        other.preset == part.preset && other.registration.name() == part.registration.name()
    };
    let name = NAMES.iter().find(same).map_or("", |(name, _)| name);
    Described { description: part.registration.describe(), preset: part.preset, name }
}

fn describe(parts: &[Part; 2]) -> TracerDescription {
    description(&parts.each_ref().map(described), &LIST)
}

fn create(parts: &[Part; 2], device: Device) -> Result<Box<dyn Tracer>, TracerError> {
    let [first, then] = parts.each_ref().map(|part| part.registration.create(&device));
    Ok(Box::new(Hybrid::new(device?, parts.each_ref().map(described), [first?, then?])?))
}
