//! What scenes are like: closed or open, large, deep.

use super::{COMPARISONS, by_start};
use crate::papers::Scope;
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{PAPER, row};
use crate::papers::quantity::{IN_A_MILLION, Quantity, of_scene, rank_chance, rank_correlation, timed_of_scenes};
use crate::papers::rows::{MILLION, SceneRows, counted, of_cause, per_ray, share_of_all, statistic, trace};
use crate::papers::times::{self, traced};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("wrong_axis_rays", IN_A_MILLION, wrong_axis_rays),
    of_scene("wrong_rays", "", |scene| wrong(scene, false)),
    of_scene("wrong_rays_but_starts", "", |scene| wrong(scene, true)),
    timed_of_scenes(RANKS[0], "", rank_of_bytes_by_triangles),
    timed_of_scenes(RANKS[1], "", rank_of_layers_compared_by_depth),
    timed_of_scenes(RANKS[2], "", rank_of_comparison_time_by_depth),
];

/// Those that are orders of the scenes.
pub(in crate::papers::hhz14) const RANKS: [&str; 3] =
    ["rank_of_bytes_by_triangles", "rank_of_layers_compared_by_depth", "rank_of_comparison_time_by_depth"];

/// Rays in a million that are wrong because of the A-buffer that was searched, which does not resolve what they hit.
fn wrong_axis_rays(scene: &SceneRows<'_>) -> Option<f64> {
    Some(share_of_all(row(scene, &[])?, |trace| of_cause(trace, "footprint", "wrong_axis"))? * MILLION)
}

/// The share of all closest-hit rays that are wrong under `footprint`, those for their start aside where that is wanted.
fn wrong(scene: &SceneRows<'_>, but_starts: bool) -> Option<f64> {
    share_of_all(row(scene, &[])?, |trace| {
        let aside = if but_starts { by_start(trace) } else { 0 };
        counted(trace, |closest| Some(closest.classes.footprint.wrong().saturating_sub(aside)))
    })
}

/// Scenes that a rank takes: of fewer hardly any order is more than chance.
const SCENES: usize = 6;
/// The chance up to which an order says something.
const CHANCE: f64 = 0.05;

/// A rank over the scenes, doubted where as strong an order comes by chance; none of too few scenes.
fn ranked(scenes: usize, rank: Option<Estimate>) -> Option<Estimate> {
    let rank = rank.filter(|_| scenes >= SCENES)?;
    let chance = rank_chance(scenes, rank.value);
    Some(if chance > CHANCE { rank.doubted(format!("exact p {chance:.3} over {scenes} scenes")) } else { rank })
}

fn rank_of(scenes: &[SceneRows<'_>], point: fn(&Row) -> Option<[f64; 2]>) -> Option<Estimate> {
    let points: Vec<_> = scenes.iter().filter_map(|scene| point(row(scene, &[])?)).collect();
    ranked(points.len(), rank_correlation(&points).map(Estimate::from))
}

/// How bytes are ranked by the triangles over the scenes.
fn rank_of_bytes_by_triangles(scenes: &[SceneRows<'_>]) -> Option<Estimate> {
    rank_of(scenes, |row| Some([row.scene.triangles as f64, PAPER.bytes(row, Scope::Structure)?]))
}

/// The layers of a covered texel, mean.
fn depth(row: &Row) -> Option<f64> {
    statistic(row, "average_layers")
}

/// How the layers that a comparison of diffuse rays looks at are ranked by the layers of a covered texel over the scenes.
fn rank_of_layers_compared_by_depth(scenes: &[SceneRows<'_>]) -> Option<Estimate> {
    rank_of(scenes, |row| {
        let diffuse = trace(row, "diffuse")?;
        Some([depth(row)?, per_ray(diffuse, "layers_tested")? / per_ray(diffuse, COMPARISONS)?])
    })
}

/// The same of the time of a comparison.
fn rank_of_comparison_time_by_depth<'a>(scenes: &[SceneRows<'a>]) -> Option<Estimate> {
    let point = |scene: &SceneRows<'a>| {
        let row = row(scene, &[])?;
        let comparisons = trace(row, "diffuse")?.counters.get(COMPARISONS)?.total as f64;
        Some((depth(row)?, traced(row, "diffuse")?.times(1.0 / comparisons)))
    };
    let points: Vec<_> = scenes.iter().filter_map(point).collect();
    ranked(points.len(), times::rank_correlation(scenes.first()?.record, &points))
}
