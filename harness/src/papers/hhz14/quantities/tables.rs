//! Figures 7 and 11 and the text: numbers of rays, resolutions of images and grid.

use super::COMPARISONS;
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{ABUFFER, SAMPLES, row};
use crate::papers::quantity::{IN_A_MILLION, Quantity, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, beyond, of_cause, per_ray, trace};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("time_over_rays_exponent", "", |scene| time_over_rays_exponent(scene, "dda2d")),
    timed_of_scene("three_step_time_over_rays_exponent", "", |scene| time_over_rays_exponent(scene, "three-step")),
    timed_of_scene("step_search_time_over_abuffer", "", |scene| over_abuffer(scene, FEW_STEPS, by_time)),
    timed_of_scene("step_search_comparisons_over_abuffer", "", |scene| over_abuffer(scene, FEW_STEPS, by_comparisons)),
    timed_of_scene("dda_comparisons_over_abuffer", "", |scene| over_abuffer(scene, &["dda2d"], by_comparisons)),
    of_scene("coarse_abuffer_thin_misses", IN_A_MILLION, coarse_abuffer_thin_misses),
    timed_of_scene("grid_by_rule_build_over_best", "", |scene| {
        by_rule_over_best(scene, "dda2d", |scene, one, other| scene.build_ratio(one, other))
    }),
    timed_of_scene("grid_by_rule_trace_over_best", "", |scene| by_rule_over_best(scene, "dda2d", by_time)),
    timed_of_scene("grid_by_rule_three_step_over_best", "", |scene| by_rule_over_best(scene, "three-step", by_time)),
    timed_of_scene("large_grid_trace_over_usual", "", |scene| large_grid_over_usual(scene, "dda2d")),
    timed_of_scene("large_grid_three_step_over_usual", "", |scene| large_grid_over_usual(scene, "three-step")),
];

const FEW_STEPS: &[&str] = &["three-step", "one-step"];

/// The exponent by which time grows with the samples of a pixel, from the fewest to the most, in one grid and its images.
fn time_over_rays_exponent(scene: &SceneRows<'_>, search: &str) -> Option<Estimate> {
    let all = scene.by_resolution();
    let [few, many] = [all.first()?, all.last()?].map(|at| at.find(ABUFFER, &[("search", search)]));
    let (few, many) = (few?, many?);
    let rays = trace(many, SAMPLES)?.count as f64 / trace(few, SAMPLES)?.count as f64;
    let same = few.viewpoint.face == many.viewpoint.face && rays > 1.0;
    same.then(|| Some(scene.trace_ratio(many, few, SAMPLES)?.rising(f64::ln) / rays.ln()))?
}

/// How a row of a scene compares with another.
type Compared = fn(&SceneRows<'_>, &Row, &Row) -> Option<Estimate>;

/// By the time of diffuse rays.
fn by_time(scene: &SceneRows<'_>, one: &Row, other: &Row) -> Option<Estimate> {
    scene.trace_ratio(one, other, "diffuse")
}

/// By the depths that a diffuse ray compares.
fn by_comparisons(_: &SceneRows<'_>, one: &Row, other: &Row) -> Option<Estimate> {
    let [one, other] = [one, other].map(|row| per_ray(trace(row, "diffuse")?, COMPARISONS));
    Some((one? / other?).into())
}

/// A-buffers of 2048 over those of 512, the larger of several searches.
fn over_abuffer(scene: &SceneRows<'_>, searches: &[&str], compared: Compared) -> Option<Estimate> {
    let ratio = |search: &&str| {
        let [fine, coarse] = ["2048", "512"].map(|edge| row(scene, &[("abuffer", edge), ("search", search)]));
        compared(scene, fine?, coarse?)
    };
    Estimate::greatest(searches.iter().map(ratio).collect::<Option<Vec<_>>>()?)
}

/// Rays in a million that miss what no texel shows, being thinner, in A-buffers of 512 beyond those that do in 1024.
fn coarse_abuffer_thin_misses(scene: &SceneRows<'_>) -> Option<f64> {
    let coarse = row(scene, &[("abuffer", "512")])?;
    beyond(coarse, row(scene, &[])?, |trace| of_cause(trace, "footprint", "thinner_than_texel"))
}

/// What takes its time with the grid by the paper's own rule, 0, over the least with other grids, in A-buffers of the published preset.
fn by_rule_over_best(scene: &SceneRows<'_>, search: &str, compared: Compared) -> Option<Estimate> {
    let gridded = |grid: &str| scene.find(ABUFFER, &[("abuffer", "0"), ("grid", grid), ("search", search)]);
    let over = |grid: &str| compared(scene, gridded("0")?, gridded(grid)?);
    Estimate::greatest(["32", "128", "256"].map(over).into_iter().collect::<Option<Vec<_>>>()?)
}

/// Time of both bounces with a grid of 256 over that with one of 64, mean of the two.
fn large_grid_over_usual(scene: &SceneRows<'_>, search: &str) -> Option<Estimate> {
    let [large, usual] = ["256", "64"].map(|grid| row(scene, &[("grid", grid), ("search", search)]));
    let ratios = ["diffuse", "bounce2"].map(|rays| scene.trace_ratio(large?, usual?, rays));
    Estimate::mean(ratios.into_iter().collect::<Option<Vec<_>>>()?)
}
