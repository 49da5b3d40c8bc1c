//! Figure 9: voxels alone.

use super::VOXELS;
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{ABUFFER, row};
use crate::papers::quantity::{Quantity, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, agreement, per_ray, trace};
use crate::results::{Judgement, Row};

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("voxels_alone_ao_change", "", voxels_alone_ao_change),
    of_scene("abuffer_position_error_over_voxels", "", abuffer_position_error_over_voxels),
    timed_of_scene("voxel_walk_exponent", "", voxel_walk_exponent),
];

fn voxels<'a>(scene: &SceneRows<'a>, grid: &str) -> Option<&'a Row> {
    scene.find(ABUFFER, &[("structure", "voxels-only"), ("grid", grid)])
}

/// Balanced accuracy of ambient occlusion in a grid of 512 alone less that with A-buffers.
fn voxels_alone_ao_change(scene: &SceneRows<'_>) -> Option<f64> {
    let [alone, both] = [voxels(scene, "512")?, row(scene, &[])?].map(|row| agreement(trace(row, "ao")?));
    Some(alone? - both?)
}

/// The median error of t of diffuse rays that hit.
fn position_error(row: &Row) -> Option<f64> {
    match &trace(row, "diffuse")?.judgement {
        Judgement::Closest(closest) => closest.position_error.p50.filter(|error| *error > 0.0),
        Judgement::Any(_) => None,
    }
}

/// The median error of t with A-buffers of 1024 over that with a grid of 1024 alone.
fn abuffer_position_error_over_voxels(scene: &SceneRows<'_>) -> Option<f64> {
    let both = scene.find(ABUFFER, &[("structure", "two-level"), ("abuffer", "1024")])?;
    Some(position_error(both)? / position_error(voxels(scene, "1024")?)?)
}

/// The exponent by which the time of ambient occlusion in voxels alone grows with the voxels that a ray goes through, from a grid of 64
/// to one of 512.
fn voxel_walk_exponent(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [low, high] = ["64", "512"].map(|grid| voxels(scene, grid));
    let (low, high) = (low?, high?);
    let [few, many] = [low, high].map(|row| per_ray(trace(row, "ao")?, VOXELS));
    let growth = many? / few?;
    (growth > 1.0).then(|| Some(scene.trace_ratio(high, low, "ao")?.rising(f64::ln) / growth.ln()))?
}
