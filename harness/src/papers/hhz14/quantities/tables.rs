//! Figures 7 and 11 and the text: numbers of rays, resolutions of images and grid.

use super::COMPARISONS;
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{ABUFFER, SAMPLES, row};
use crate::papers::quantity::{IN_A_MILLION, Quantity, greatest, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, beyond, of_cause, per_ray, trace};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("time_over_rays_exponent", "", |scene| time_over_rays_exponent(scene, "dda2d")),
    timed_of_scene("three_step_time_over_rays_exponent", "", |scene| time_over_rays_exponent(scene, "three-step")),
    timed_of_scene("step_search_time_over_abuffer", "", step_search_time_over_abuffer),
    of_scene("step_search_comparisons_over_abuffer", "", |scene| {
        greatest([comparisons_over_abuffer(scene, "three-step")?, comparisons_over_abuffer(scene, "one-step")?])
    }),
    of_scene("dda_comparisons_over_abuffer", "", |scene| comparisons_over_abuffer(scene, "dda2d")),
    of_scene("coarse_abuffer_thin_misses", IN_A_MILLION, coarse_abuffer_thin_misses),
    timed_of_scene("grid_by_rule_build_over_best", "", |scene| {
        by_rule_over_best(scene, "dda2d", |scene, one, other| scene.build_ratio(one, other))
    }),
    timed_of_scene("grid_by_rule_trace_over_best", "", |scene| by_rule_over_best(scene, "dda2d", diffuse_ratio)),
    timed_of_scene("grid_by_rule_three_step_over_best", "", |scene| {
        by_rule_over_best(scene, "three-step", diffuse_ratio)
    }),
    timed_of_scene("large_grid_trace_over_usual", "", |scene| large_grid_over_usual(scene, "dda2d")),
    timed_of_scene("large_grid_three_step_over_usual", "", |scene| large_grid_over_usual(scene, "three-step")),
];

/// The exponent by which time grows with the samples of a pixel, from the fewest to the most, in one grid and its images.
fn time_over_rays_exponent(scene: &SceneRows<'_>, search: &str) -> Option<Estimate> {
    let all = scene.by_resolution();
    let [few, many] = [all.first()?, all.last()?].map(|at| at.find(ABUFFER, &[("search", search)]));
    let (few, many) = (few?, many?);
    let rays = trace(many, SAMPLES)?.count as f64 / trace(few, SAMPLES)?.count as f64;
    let same = few.viewpoint.face == many.viewpoint.face && rays > 1.0;
    same.then(|| Some(scene.trace_ratio(many, few, SAMPLES)?.rising(f64::ln) / rays.ln()))?
}

fn finer_over_coarser<'a>(scene: &SceneRows<'a>, search: &str) -> Option<[&'a Row; 2]> {
    let [fine, coarse] = ["2048", "512"].map(|edge| row(scene, &[("abuffer", edge), ("search", search)]));
    Some([fine?, coarse?])
}

/// Time of diffuse rays in A-buffers of 2048 over that in those of 512, the larger of three steps and of one.
fn step_search_time_over_abuffer(scene: &SceneRows<'_>) -> Option<Estimate> {
    let ratio = |search: &str| {
        let [fine, coarse] = finer_over_coarser(scene, search)?;
        diffuse_ratio(scene, fine, coarse)
    };
    Estimate::greatest(["three-step", "one-step"].map(ratio).into_iter().collect::<Option<Vec<_>>>()?)
}

/// Depths that a diffuse ray compares in A-buffers of 2048 over those in 512.
fn comparisons_over_abuffer(scene: &SceneRows<'_>, search: &str) -> Option<f64> {
    let [fine, coarse] = finer_over_coarser(scene, search)?.map(|row| per_ray(trace(row, "diffuse")?, COMPARISONS));
    coarse.filter(|comparisons| *comparisons > 0.0).and_then(|coarse| Some(fine? / coarse))
}

/// Rays in a million that miss what no texel shows, being thinner, in A-buffers of 512 beyond those that do in 1024.
fn coarse_abuffer_thin_misses(scene: &SceneRows<'_>) -> Option<f64> {
    let coarse = row(scene, &[("abuffer", "512")])?;
    beyond(coarse, row(scene, &[])?, |trace| of_cause(trace, "footprint", "thinner_than_texel"))
}

fn diffuse_ratio(scene: &SceneRows<'_>, one: &Row, other: &Row) -> Option<Estimate> {
    scene.trace_ratio(one, other, "diffuse")
}

/// How a row of a scene compares with another.
type Compared = fn(&SceneRows<'_>, &Row, &Row) -> Option<Estimate>;

/// What takes its time with the grid by the paper's own rule, 0, over the least with other grids, in A-buffers of the published preset.
fn by_rule_over_best(scene: &SceneRows<'_>, search: &str, compared: Compared) -> Option<Estimate> {
    let gridded = |grid: &str| scene.find(ABUFFER, &[("abuffer", "0"), ("grid", grid), ("search", search)]);
    let by_rule = gridded("0")?;
    let over = |grid: &str| compared(scene, by_rule, gridded(grid)?);
    Estimate::greatest(["32", "128", "256"].map(over).into_iter().collect::<Option<Vec<_>>>()?)
}

/// Time of both bounces with a grid of 256 over that with one of 64, mean of the two.
fn large_grid_over_usual(scene: &SceneRows<'_>, search: &str) -> Option<Estimate> {
    let [large, usual] = ["256", "64"].map(|grid| row(scene, &[("grid", grid), ("search", search)]));
    let (large, usual) = (large?, usual?);
    let ratios = ["diffuse", "bounce2"].map(|rays| scene.trace_ratio(large, usual, rays));
    Estimate::mean(ratios.into_iter().collect::<Option<Vec<_>>>()?)
}
