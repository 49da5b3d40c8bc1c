//! The registration of `hybrid`, a tracer of two others, which its parameters `first` and `then` name.

use std::sync::LazyLock;

use tracebench_api::{Preset, Tracer, TracerDescription, TracerError};
use tracebench_hybrid::{Hybrid, Part as Described, description};

use super::expectation::{fails, few, of_plates_along_rows};
use super::{
    Column, Device, Expectation, Family, Part, Parts, Registration, Rule, bvh_gpu, dirt, fragment_abuffer,
    height_field, mesh_warp, ploc_gpu, quadtree, ray_query, screen_dda, voxel_abuffer, voxel_octree,
};

pub(crate) const REGISTRATION: Registration = Registration {
    parts: Some(Parts { of: DEFAULT, names: &["first", "then"], find, describe, create }),
    expectations: &[EXPECTATIONS],
    forms: &[&[("first", "quadtree:improved")]],
    excluded_from_fronts: &["dispatch"],
    ..Registration::sampled(|| describe(&DEFAULT), Family::Image, |device| create(&DEFAULT, device))
};

const FIRST: &str = "where the first finds nothing the second is exact; hits of the first are kept, right or wrong";
const FIRST_SOURCE: &str =
    "AMD, Hybrid Reflections sample (GPUOpen): what the march hits is not asked of the scene again";
const FEW: Expectation = few(Rule::Footprint, FIRST);

const EXPECTATIONS: Column = &[
    (
        "edge-on leaves voxel-stack plane-through-eye before-near cube-borders coarse-frame surface-starts crowded-pixel behind-foreground \
         half-resolution",
        fails(Rule::Footprint, FIRST, FIRST_SOURCE),
    ),
    ("wide-frame", of_plates_along_rows(&FEW)),
    (
        "wires close-sheets open-mesh huge-triangle needles coplanar-copies eye-inside-object eye-on-surface eye-at-vertex depth-range \
         secondary-depth-ratio cell-borders face-cell-borders through-view-centre flat-tile equal-triangles stacked-layers",
        FEW,
    ),
    (
        "thin-walls long-scene towards-camera foreground-in-cell long-rays away-from-camera field-of-view off-origin",
        FEW,
    ),
];

/// A march in screen space, and where it found nothing the scene itself.
const DEFAULT: [Part; 2] = [
    Part { registration: &screen_dda::REGISTRATION, preset: Preset::Improved, name: "screen-dda:improved" },
    Part { registration: &ploc_gpu::REGISTRATION, preset: Preset::Published, name: "ploc-gpu:published" },
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
static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| {
    let of = |each: &&Registration| ["", ":published", ":improved"].map(|end| &*format!("{}{end}", each.name()).leak());
    ALL.iter().flat_map(of).collect()
});

fn find(name: &str) -> Option<Part> {
    let name = *NAMES.iter().find(|known| **known == name)?;
    let (tracer, preset) = name.split_once(':').unwrap_or((name, Preset::Published.name()));
    let registration = *ALL.iter().find(|each| each.name() == tracer)?;
    let preset = Preset::ALL.into_iter().find(|each| each.name() == preset)?;
    Some(Part { registration, preset, name })
}

fn described(&Part { registration, preset, name }: &Part) -> Described {
    Described { description: registration.describe(), preset, name }
}

fn describe(parts: &[Part; 2]) -> TracerDescription {
    description(&parts.each_ref().map(described), &NAMES)
}

fn create(parts: &[Part; 2], device: Device) -> Result<Box<dyn Tracer>, TracerError> {
    let [first, then] = parts.each_ref().map(|part| part.registration.create(&device));
    Ok(Box::new(Hybrid::new(device?, parts.each_ref().map(described), [first?, then?])?))
}
