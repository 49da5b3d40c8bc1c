//! What scenes are like: closed or open, large, deep.

use super::{COMPARISONS, by_start};
use crate::papers::Scope;
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{PAPER, row};
use crate::papers::quantity::{IN_A_MILLION, Quantity, of_scene, rank_chance, rank_correlation, timed_of_scenes};
use crate::papers::rows::{MILLION, SceneRows, counted, of_cause, share_of_all, statistic, trace};
use crate::papers::times::{self, traced};

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("wrong_axis_rays", IN_A_MILLION, wrong_axis_rays),
    of_scene("wrong_rays", "", |scene| wrong(scene, false)),
    of_scene("wrong_rays_but_starts", "", |scene| wrong(scene, true)),
    timed_of_scenes("rank_of_bytes_by_triangles", "", rank_of_bytes_by_triangles),
    timed_of_scenes("rank_of_comparison_time_by_layers", "", rank_of_comparison_time_by_layers),
];

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

/// A rank over scenes with how often chance makes one as strong, which is doubted where that is more than one in twenty; none of too few
/// scenes, of which hardly any order is more than chance.
fn ranked(scenes: usize, rank: Option<Estimate>) -> Option<Estimate> {
    let rank = rank.filter(|_| scenes >= 6)?;
    let chance = rank_chance(scenes, rank.value);
    let note = format!("exact p {chance:.4} over {scenes} scenes");
    let rank = if chance > 0.05 { rank.doubted("it may be chance".to_owned()) } else { rank };
    Some(Estimate { note: Some(note), ..rank })
}

/// How bytes are ranked by the triangles over the scenes.
fn rank_of_bytes_by_triangles(scenes: &[SceneRows<'_>]) -> Option<Estimate> {
    let point = |scene: &SceneRows<'_>| {
        let row = row(scene, &[])?;
        Some([row.scene.triangles as f64, PAPER.bytes(row, Scope::Structure)?])
    };
    let points: Vec<_> = scenes.iter().filter_map(point).collect();
    ranked(points.len(), rank_correlation(&points).map(Estimate::from))
}

/// How the time of a comparison of diffuse rays is ranked by the layers of a covered texel over the scenes.
fn rank_of_comparison_time_by_layers<'a>(scenes: &[SceneRows<'a>]) -> Option<Estimate> {
    let point = |scene: &SceneRows<'a>| {
        let row = row(scene, &[])?;
        let comparisons = trace(row, "diffuse")?.counters.get(COMPARISONS)?.total as f64;
        Some((statistic(row, "average_layers")?, traced(row, "diffuse")?.times(1.0 / comparisons)))
    };
    let points: Vec<_> = scenes.iter().filter_map(point).collect();
    ranked(points.len(), times::rank_correlation(scenes.first()?.record, &points))
}
