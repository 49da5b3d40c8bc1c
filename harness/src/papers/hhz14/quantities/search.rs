//! Figures 6 and 7: searches, and the time of a ray.

use super::{COMPARISONS, VOXELS};
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{ABUFFER, row};
use crate::papers::quantity::{IN_A_MILLION, Quantity, greatest, least, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, agreement, beyond, footprint, integer, passed, per_ray, trace};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("min_footprint_agreement", "", min_footprint_agreement),
    of_scene("three_step_agreement_change", "", three_step_agreement_change),
    of_scene("one_step_ao_change", "", one_step_ao_change),
    of_scene("one_step_passed_beyond", IN_A_MILLION, one_step_passed_beyond),
    timed_of_scene("min_gain_of_fewer_steps", "", min_gain_of_fewer_steps),
    of_scene("voxels_visited_over_grid", "", voxels_visited_over_grid),
    timed_of_scene("time_over_rays_exponent", "", time_over_rays_exponent),
    timed_of_scene("step_search_time_over_abuffer", "", step_search_time_over_abuffer),
    of_scene("dda_comparisons_over_abuffer", "", dda_comparisons_over_abuffer),
    of_scene("coarse_abuffer_passed_beyond", IN_A_MILLION, coarse_abuffer_passed_beyond),
];

fn with<'a>(scene: &SceneRows<'a>, search: &str) -> Option<&'a Row> {
    row(scene, &[("search", search)])
}

/// The least footprint agreement of the search in every texel over closest-hit sets.
fn min_footprint_agreement(scene: &SceneRows<'_>) -> Option<f64> {
    least(with(scene, "dda2d")?.traces.iter().filter_map(footprint))
}

/// Footprint agreement in three steps less that in every texel, of the closest-hit set that loses most.
fn three_step_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    let (three, all) = (with(scene, "three-step")?, with(scene, "dda2d")?);
    least(all.traces.iter().filter_map(|own| Some(footprint(trace(three, &own.rays)?)? - footprint(own)?)))
}

/// Balanced accuracy of ambient occlusion in one step less that in every texel.
fn one_step_ao_change(scene: &SceneRows<'_>) -> Option<f64> {
    let [one, all] = ["one-step", "dda2d"].map(|search| agreement(trace(with(scene, search)?, "ao")?));
    Some(one? - all?)
}

/// Rays in a million that pass their true hit in one step beyond those that do in every texel.
fn one_step_passed_beyond(scene: &SceneRows<'_>) -> Option<f64> {
    beyond(with(scene, "one-step")?, with(scene, "dda2d")?, passed)
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

/// Voxels that a ray goes through over those along the grid's edge, of the ray set with the most.
fn voxels_visited_over_grid(scene: &SceneRows<'_>) -> Option<f64> {
    let row = with(scene, "dda2d")?;
    let edge = integer(row, "grid")? as f64;
    greatest(row.traces.iter().map(|trace| per_ray(trace, VOXELS)).collect::<Option<Vec<_>>>()?).map(|most| most / edge)
}

/// The exponent by which time grows with the number of rays, from the fewest to the most.
fn time_over_rays_exponent(scene: &SceneRows<'_>) -> Option<Estimate> {
    let all = scene.by_resolution();
    let [few, many] = [all.first()?, all.last()?].map(|at| at.of_tracer(ABUFFER).next());
    let (few, many) = (few?, many?);
    let rays = trace(many, "ao")?.count as f64 / trace(few, "ao")?.count as f64;
    (rays > 1.0).then(|| Some(scene.trace_ratio(many, few, "ao")?.rising(f64::ln) / rays.ln()))?
}

const FINE: &str = "2048";
const COARSE: &str = "512";

fn finer_over_coarser<'a>(scene: &SceneRows<'a>, search: &str) -> Option<[&'a Row; 2]> {
    let [fine, coarse] = [FINE, COARSE].map(|edge| row(scene, &[("abuffer", edge), ("search", search)]));
    Some([fine?, coarse?])
}

/// Time of diffuse rays in A-buffers of 2048 over that in those of 512, the larger of three steps and of one.
fn step_search_time_over_abuffer(scene: &SceneRows<'_>) -> Option<Estimate> {
    let ratio = |search: &str| {
        let [fine, coarse] = finer_over_coarser(scene, search)?;
        scene.trace_ratio(fine, coarse, "diffuse")
    };
    Estimate::greatest(["three-step", "one-step"].map(ratio).into_iter().collect::<Option<Vec<_>>>()?)
}

/// Depths that a diffuse ray compares in A-buffers of 2048 over those in 512, where it does so in every texel on its way.
fn dda_comparisons_over_abuffer(scene: &SceneRows<'_>) -> Option<f64> {
    let [fine, coarse] = finer_over_coarser(scene, "dda2d")?.map(|row| per_ray(trace(row, "diffuse")?, COMPARISONS));
    coarse.filter(|comparisons| *comparisons > 0.0).and_then(|coarse| Some(fine? / coarse))
}

/// Rays in a million that pass their true hit in A-buffers of 512 beyond those that do in 2048.
fn coarse_abuffer_passed_beyond(scene: &SceneRows<'_>) -> Option<f64> {
    let [fine, coarse] = finer_over_coarser(scene, "dda2d")?;
    beyond(coarse, fine, passed)
}
