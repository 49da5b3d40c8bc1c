//! Figure 6: searches, beside one another and beside triangles.

use super::{COMPARISONS, VOXELS, footprint_but_starts};
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::row;
use crate::papers::quantity::{Quantity, greatest, least, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, agreement, footprint, integer, passed, per_ray, trace};
use crate::results::{Row, TraceRecord};

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("min_footprint_agreement", "", |scene| min_agreement(scene, footprint)),
    of_scene("min_agreement_but_starts", "", |scene| min_agreement(scene, footprint_but_starts)),
    of_scene("refraction_agreement_less_specular", "", |scene| refraction_less_specular(scene, footprint)),
    of_scene("refraction_less_specular_but_starts", "", |scene| refraction_less_specular(scene, footprint_but_starts)),
    of_scene("three_step_specular_change", "", |scene| change(scene, "three-step", "specular")),
    of_scene("three_step_refraction_change", "", |scene| change(scene, "three-step", "refraction")),
    of_scene("three_step_visibility_change", "", |scene| change(scene, "three-step", "visibility")),
    of_scene("three_step_ao_change", "", |scene| change(scene, "three-step", "ao")),
    of_scene("one_step_ao_change", "", |scene| change(scene, "one-step", "ao")),
    of_scene("one_step_passed_voxels", "", one_step_passed_voxels),
    timed_of_scene("min_gain_of_fewer_steps", "", min_gain_of_fewer_steps),
    of_scene("comparisons_saved_by_three_step", "", comparisons_saved_by_three_step),
    of_scene("comparisons_a_search_over_edge", "", comparisons_a_search_over_edge),
    of_scene("steps_over_comparisons", "", |scene| steps_over_comparisons(scene, "dda2d")),
    of_scene("steps_over_three_step_comparisons", "", |scene| steps_over_comparisons(scene, "three-step")),
];

fn with<'a>(scene: &SceneRows<'a>, search: &str) -> Option<&'a Row> {
    row(scene, &[("search", search)])
}

/// Footprint agreement, of any-hit rays balanced accuracy.
pub(super) fn accuracy(trace: &TraceRecord) -> Option<f64> {
    footprint(trace).or_else(|| agreement(trace))
}

/// The least agreement of the search in every texel over closest-hit sets.
fn min_agreement(scene: &SceneRows<'_>, of: fn(&TraceRecord) -> Option<f64>) -> Option<f64> {
    least(with(scene, "dda2d")?.traces.iter().filter_map(of))
}

/// Agreement of rays that start in solids less that of mirrored rays, which mostly start outside.
fn refraction_less_specular(scene: &SceneRows<'_>, of: fn(&TraceRecord) -> Option<f64>) -> Option<f64> {
    let row = with(scene, "dda2d")?;
    Some(of(trace(row, "refraction")?)? - of(trace(row, "specular")?)?)
}

/// The accuracy of a search less that of the one in every texel.
fn change(scene: &SceneRows<'_>, search: &str, rays: &str) -> Option<f64> {
    let [own, all] = [search, "dda2d"].map(|search| accuracy(trace(with(scene, search)?, rays)?));
    Some(own? - all?)
}

fn total(trace: &TraceRecord, counter: &str) -> Option<f64> {
    Some(trace.counters.get(counter)?.total as f64)
}

/// Of the voxels with anything that rays leave on the side on which they entered, by one step, the share in which a ray passes its true
/// hit: rays that do so beyond those that do in every texel, over voxels that ended none.
fn one_step_passed_voxels(scene: &SceneRows<'_>) -> Option<f64> {
    let (one, all) = (with(scene, "one-step")?, with(scene, "dda2d")?);
    let mut sums = [0.0; 2];
    for own in &one.traces {
        let Some((here, there)) = passed(own).zip(trace(all, &own.rays).and_then(passed)) else { continue };
        let ended = own.statuses.get("hit").copied().unwrap_or(0) as f64;
        sums = [sums[0] + here[1] as f64 - there[1] as f64, sums[1] + total(own, "voxels_opened")? - ended];
    }
    (sums[1] > 0.0).then(|| sums[0] / sums[1])
}

/// Time in every texel over that in three steps, and in three over that in one, mean over the ray sets: the less of the two.
fn min_gain_of_fewer_steps(scene: &SceneRows<'_>) -> Option<Estimate> {
    let gain = |[more, fewer]: [&str; 2]| {
        let (more, fewer) = (with(scene, more)?, with(scene, fewer)?);
        let ratios = more.traces.iter().map(|own| scene.trace_ratio(more, fewer, &own.rays));
        Estimate::mean(ratios.collect::<Option<Vec<_>>>()?)
    };
    let gains = [["dda2d", "three-step"], ["three-step", "one-step"]].map(gain);
    Estimate::least(gains.into_iter().collect::<Option<Vec<_>>>()?)
}

/// Comparisons of all rays in every texel over those in three steps.
fn comparisons_saved_by_three_step(scene: &SceneRows<'_>) -> Option<f64> {
    let of =
        |search: &str| with(scene, search)?.traces.iter().map(|trace| total(trace, COMPARISONS)).sum::<Option<f64>>();
    Some(of("dda2d")? / of("three-step")?)
}

/// Comparisons of a search in every texel of its voxel over the texels along an image's edge, of the ray set with the most.
fn comparisons_a_search_over_edge(scene: &SceneRows<'_>) -> Option<f64> {
    let row = with(scene, "dda2d")?;
    let edge = integer(row, "abuffer")? as f64;
    let of = |trace| Some(per_ray(trace, COMPARISONS)? / per_ray(trace, "searches")? / edge);
    greatest(row.traces.iter().map(of).collect::<Option<Vec<_>>>()?)
}

/// Voxels that a ray goes through over its comparisons, of the ray set with the most.
fn steps_over_comparisons(scene: &SceneRows<'_>, search: &str) -> Option<f64> {
    let of = |trace| Some(per_ray(trace, VOXELS)? / per_ray(trace, COMPARISONS)?);
    greatest(with(scene, search)?.traces.iter().map(of).collect::<Option<Vec<_>>>()?)
}
