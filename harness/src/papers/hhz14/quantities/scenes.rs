//! Figure 11 and the text: grids, and what scenes are like.

use crate::papers::Scope;
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{ABUFFER, PAPER, row};
use crate::papers::quantity::{IN_A_MILLION, Quantity, mean, of_scene, of_scenes, rank_correlation, timed_of_scene};
use crate::papers::rows::{MILLION, SceneRows, counted, of_cause, share_of_all};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("large_grid_trace_over_usual", "", large_grid_trace_over_usual),
    timed_of_scene("grid_by_rule_total_over_best", "", grid_by_rule_total_over_best),
    of_scene("wrong_axis_rays", IN_A_MILLION, wrong_axis_rays),
    of_scenes("open_wrong_over_closed", "", open_wrong_over_closed),
    of_scenes("rank_of_bytes_by_triangles", "", rank_of_bytes_by_triangles),
];

/// What the judge says of rays that were searched in the A-buffer of an axis that does not resolve what they hit.
const WRONG_AXIS: &str = "wrong_axis";

/// Time of both bounces with a grid of 256 over that with one of 64, mean of the two.
fn large_grid_trace_over_usual(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [large, usual] = ["256", "64"].map(|grid| row(scene, &[("grid", grid)]));
    let (large, usual) = (large?, usual?);
    let ratios = ["diffuse", "bounce2"].map(|rays| scene.trace_ratio(large, usual, rays));
    Estimate::mean(ratios.into_iter().collect::<Option<Vec<_>>>()?)
}

/// The value of `abuffer` and of `grid` that stands for the paper's own rule.
const BY_RULE: &str = "0";

/// A row with the A-buffers of the published preset.
fn gridded<'a>(scene: &SceneRows<'a>, grid: &str) -> Option<&'a Row> {
    scene.find(ABUFFER, &[("abuffer", BY_RULE), ("grid", grid)])
}

/// Time of the build and of a set of diffuse rays with the grid by the rule, over the least of other grids.
fn grid_by_rule_total_over_best(scene: &SceneRows<'_>) -> Option<Estimate> {
    let by_rule = gridded(scene, BY_RULE)?;
    let over = |grid: &str| scene.total_ratio(by_rule, gridded(scene, grid)?, &[("diffuse", 1.0)]);
    Estimate::greatest(["32", "128", "256"].map(over).into_iter().collect::<Option<Vec<_>>>()?)
}

/// The share of all closest-hit rays of a row that are wrong under `footprint`.
fn wrong(row: &Row) -> Option<f64> {
    share_of_all(row, |trace| counted(trace, |closest| Some(closest.classes.footprint.wrong())))
}

/// Rays in a million that are wrong because of the A-buffer that was searched.
fn wrong_axis_rays(scene: &SceneRows<'_>) -> Option<f64> {
    Some(share_of_all(row(scene, &[])?, |trace| of_cause(trace, "footprint", WRONG_AXIS))? * MILLION)
}

/// The mean share of wrong rays of the scenes whose surfaces are not all closed, over that of the others.
fn open_wrong_over_closed(scenes: &[SceneRows<'_>]) -> Option<f64> {
    let mut shares = [Vec::new(), Vec::new()];
    for scene in scenes {
        let row = row(scene, &[])?;
        let entry = tracebench_scenes::catalogue().iter().find(|entry| entry.name == row.scene.name)?;
        shares[usize::from(entry.watertight)].push(wrong(row)?);
    }
    let [open, closed] = shares.map(|shares| mean(&shares));
    closed.filter(|closed| *closed > 0.0).and_then(|closed| Some(open? / closed))
}

/// How bytes are ranked by the triangles over the scenes.
fn rank_of_bytes_by_triangles(scenes: &[SceneRows<'_>]) -> Option<f64> {
    let point = |scene: &SceneRows<'_>| {
        let row = row(scene, &[])?;
        Some([row.scene.triangles as f64, PAPER.bytes(row, Scope::Structure)?])
    };
    rank_correlation(&scenes.iter().filter_map(point).collect::<Vec<_>>())
}
