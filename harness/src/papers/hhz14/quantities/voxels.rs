//! Figure 9: voxels alone.

use itertools::Itertools as _;

use super::{VOXELS, by_start};
use crate::papers::Scope;
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{ABUFFER, PAPER, row};
use crate::papers::quantity::{Quantity, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, agreement, per_ray, trace};
use crate::results::{Judgement, Row};

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("voxels_alone_ao_change", "", voxels_alone_ao_change),
    of_scene("voxels_alone_ao_change_but_starts", "", voxels_alone_ao_change_but_starts),
    of_scene("voxels_alone_bytes_over_abuffers", "", voxels_alone_bytes_over_abuffers),
    of_scene("abuffer_samples_over_voxels_alone", "", |scene| abuffer_samples(scene, false)),
    of_scene("abuffer_samples_over_voxels_but_starts", "", |scene| abuffer_samples(scene, true)),
    of_scene("abuffer_position_error_over_voxels", "", abuffer_position_error_over_voxels),
    timed_of_scene("voxel_walk_exponents", "", voxel_walk_exponents),
];

fn voxels<'a>(scene: &SceneRows<'a>, grid: &str) -> Option<&'a Row> {
    scene.find(ABUFFER, &[("structure", "voxels-only"), ("grid", grid)])
}

/// Balanced accuracy of ambient occlusion in a grid of 512 alone less that with A-buffers.
fn voxels_alone_ao_change(scene: &SceneRows<'_>) -> Option<f64> {
    let [alone, both] = [voxels(scene, "512")?, row(scene, &[])?].map(|row| agreement(trace(row, "ao")?));
    Some(alone? - both?)
}

/// Rays of ambient occlusion: how many are truly occluded and free, and of these how many are found so.
struct Occluded {
    occluded: f64,
    free: f64,
    found_occluded: f64,
    found_free: f64,
}

impl Occluded {
    /// Were those found, where that is wanted, that pass what is near their start.
    fn of(row: &Row, but_starts: bool) -> Option<Self> {
        let trace = trace(row, "ao")?;
        let Judgement::Any(any) = &trace.judgement else { return None };
        let told = &any.occlusion;
        let aside = if but_starts { by_start(trace).min(told.false_free) } else { 0 };
        let [occluded, free, found_occluded, found_free] = [
            told.true_occluded + told.false_free,
            told.true_free + told.false_occluded,
            told.true_occluded + aside,
            told.true_free,
        ]
        .map(|rays| rays as f64);
        (occluded > 0.0 && free > 0.0).then_some(Self { occluded, free, found_occluded, found_free })
    }

    /// The share that is told to be occluded beyond the one that is.
    fn bias(&self) -> f64 {
        (self.free - self.found_free + self.found_occluded - self.occluded) / (self.free + self.occluded)
    }
}

/// The same, were no ray of voxels alone wrong for its start.
fn voxels_alone_ao_change_but_starts(scene: &SceneRows<'_>) -> Option<f64> {
    let alone = Occluded::of(voxels(scene, "512")?, true)?;
    let accuracy = f64::midpoint(alone.found_occluded / alone.occluded, alone.found_free / alone.free);
    Some(accuracy - agreement(trace(row(scene, &[])?, "ao")?)?)
}

/// Bytes of a grid alone of 1280 along an edge, by its cube from those of one of 1024, over those of grid and A-buffers.
fn voxels_alone_bytes_over_abuffers(scene: &SceneRows<'_>) -> Option<f64> {
    let [alone, both] = [voxels(scene, "1024")?, row(scene, &[])?].map(|row| PAPER.bytes(row, Scope::Structure));
    Some(alone? * (1280.0_f64 / 1024.0).powi(3) / both?)
}

/// The paper's samples a fragment.
const SAMPLES: f64 = 64.0;

/// Samples that A-buffers take, 64, over those that a grid of 64 alone takes to be off by as much in the mean over the pixels: the bias,
/// squared, and the variance of as many samples. Not above 0 where no number of them will do.
fn abuffer_samples(scene: &SceneRows<'_>, but_starts: bool) -> Option<f64> {
    let (alone, both) = (Occluded::of(voxels(scene, "64")?, but_starts)?, Occluded::of(row(scene, &[])?, false)?);
    let share = both.occluded / (both.occluded + both.free);
    Some(1.0 + SAMPLES * (both.bias().powi(2) - alone.bias().powi(2)) / (share * (1.0 - share)))
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
    Estimate::spanning(exponents)
}
