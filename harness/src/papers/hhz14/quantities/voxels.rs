//! Figure 9: voxels alone.

use itertools::Itertools as _;

use super::{VOXELS, by_start};
use crate::papers::Scope;
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{ABUFFER, PAPER, row};
use crate::papers::quantity::{Quantity, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, per_ray, trace};
use crate::results::{Judgement, Row};

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("voxels_alone_ao_change", "", |scene| ao_change(scene, false)),
    of_scene("voxels_alone_ao_change_but_starts", "", |scene| ao_change(scene, true)),
    of_scene("voxels_alone_bytes_over_abuffers", "", |scene| bytes_over_abuffers(scene, 1.0)),
    of_scene("voxels_of_a_byte_over_abuffers", "", |scene| bytes_over_abuffers(scene, 8.0)),
    of_scene("abuffer_samples_over_voxels_alone", "", |scene| abuffer_samples(scene, false)),
    of_scene("abuffer_samples_over_voxels_but_starts", "", |scene| abuffer_samples(scene, true)),
    of_scene("abuffer_position_error_over_voxels", "", abuffer_position_error_over_voxels),
    timed_of_scene("voxel_walk_exponents", "", voxel_walk_exponents),
];

fn voxels<'a>(scene: &SceneRows<'a>, grid: &str) -> Option<&'a Row> {
    scene.find(ABUFFER, &[("structure", "voxels-only"), ("grid", grid)])
}

/// Of rays of ambient occlusion the shares that are occluded, that are wrongly told to be and that are wrongly told not to be; of these
/// those for their start aside, where that is wanted.
fn occlusion(row: &Row, but_starts: bool) -> Option<[f64; 3]> {
    let trace = trace(row, "ao")?;
    let Judgement::Any(any) = &trace.judgement else { return None };
    let told = &any.occlusion;
    let occluded = told.true_occluded + told.false_free;
    let lost = told.false_free.saturating_sub(if but_starts { by_start(trace) } else { 0 });
    let rays = (occluded + told.true_free + told.false_occluded) as f64;
    Some([occluded, told.false_occluded, lost].map(|count| count as f64 / rays))
}

/// Balanced accuracy of ambient occlusion in a grid of 512 alone less that with A-buffers.
fn ao_change(scene: &SceneRows<'_>, but_starts: bool) -> Option<f64> {
    let wrong = |[occluded, invented, lost]: [f64; 3]| f64::midpoint(lost / occluded, invented / (1.0 - occluded));
    Some(wrong(occlusion(row(scene, &[])?, false)?) - wrong(occlusion(voxels(scene, "512")?, but_starts)?))
}

/// Bytes of a grid alone of 1280 along an edge and so many bits, by its cube from those of one of 1024, over those of grid and A-buffers.
fn bytes_over_abuffers(scene: &SceneRows<'_>, bits: f64) -> Option<f64> {
    let [alone, both] = [voxels(scene, "1024")?, row(scene, &[])?].map(|row| PAPER.bytes(row, Scope::Structure));
    Some(bits * alone? * (1280.0_f64 / 1024.0).powi(3) / both?)
}

/// Samples that A-buffers take, the paper's 64, over those that a grid of 64 alone takes to be off by as much in the mean over the pixels:
/// the bias, squared, and the variance of as many samples. Not above 0 where no number of them will do.
fn abuffer_samples(scene: &SceneRows<'_>, but_starts: bool) -> Option<f64> {
    let [occluded, invented, lost] = occlusion(row(scene, &[])?, false)?;
    let [_, invented_alone, lost_alone] = occlusion(voxels(scene, "64")?, but_starts)?;
    let biases = (invented - lost).powi(2) - (invented_alone - lost_alone).powi(2);
    Some(1.0 + 64.0 * biases / (occluded * (1.0 - occluded)))
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

/// The exponents by which time grows with the voxels that a ray goes through, of every ray set and from every grid to the next, beyond
/// what a grid of 64 takes: what does not depend on the voxels is in that. The interval holds all of them, the value is their median.
fn voxel_walk_exponents(scene: &SceneRows<'_>) -> Option<Estimate> {
    let coarsest = voxels(scene, "64")?;
    let mut exponents = Vec::new();
    for rays in scene.ray_sets() {
        let beyond = |grid: &str| {
            let finer = voxels(scene, grid)?;
            let steps = per_ray(trace(finer, rays)?, VOXELS)? - per_ray(trace(coarsest, rays)?, VOXELS)?;
            let time = scene.trace_ratio(finer, coarsest, rays)? - 1.0;
            (steps > 0.0).then(|| (steps.ln(), time.rising(|time| time.max(0.0).ln())))
        };
        let all = ["128", "256", "512", "1024"].map(beyond).into_iter().collect::<Option<Vec<_>>>()?;
        exponents.extend(all.into_iter().tuple_windows().map(|(few, many)| (many.1 - few.1) / (many.0 - few.0)));
    }
    let values: Vec<f64> = exponents.iter().map(|each| each.value).filter(|value| value.is_finite()).collect();
    let (low, high) = (Estimate::least(exponents.clone())?, Estimate::greatest(exponents)?);
    Some(Estimate { value: crate::statistics::median(&values), interval: [low.interval[0], high.interval[1]], ..low })
}
