//! Table 1: what is traversed, what is skipped, what buckets cost.

use super::{counted, rays};
use crate::papers::Scope;
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{Quantity, of_scene, timed_of_scene, timed_of_scenes};
use crate::papers::rows::{SceneRows, same_hits, statistic, trace};
use crate::papers::times::{rank_correlation, traced as timed};
use crate::papers::vvp16::{self, PAPER, row};
use crate::results::{Row, Timed, TraceRecord};

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("skipping_gain", "", skipping_gain),
    of_scene("same_hits_without_skipping", "", same_hits_without_skipping),
    timed_of_scenes("rank_of_time_by_efficiency", "", rank_of_time_by_efficiency),
    timed_of_scenes("rank_of_build_by_fragments", "", rank_of_build_by_fragments),
    of_scene("layers_of_two_bounces_over_one", "", |scene| second_over_first(scene, layers)),
    of_scene("views_of_two_bounces_over_one", "", |scene| second_over_first(scene, views)),
    timed_of_scene("two_bounces_over_one", "", two_bounces_over_one),
    timed_of_scene("more_buckets_trace_where_deep", "", more_buckets_trace_where_deep),
    timed_of_scene("more_buckets_cost", "", more_buckets_cost),
    of_scene("data_nodes_read", "", data_nodes_read),
];

/// Layers of a covered pixel, on the mean, from which a scene counts as complex: Smithy's 6 does, Pool's 4 does not.
const COMPLEX_LAYERS: f64 = 5.0;

/// The traces of one bounce and of two.
pub(in crate::papers::vvp16) fn bounces(row: &Row) -> Option<[Vec<&TraceRecord>; 2]> {
    let first = trace(row, "diffuse")?;
    Some([vec![first], vec![first, trace(row, "bounce2")?]])
}

/// The share of the pixels or steps looked at of which no fragment was tested.
pub(in crate::papers::vvp16) fn efficiency(traces: &[&TraceRecord]) -> Option<f64> {
    Some(1.0 - counted(traces, "pixels_opened")? / counted(traces, "pixels_visited")?)
}

/// Fragments tested in a pixel of which at least one was.
pub(in crate::papers::vvp16) fn layers(traces: &[&TraceRecord]) -> Option<f64> {
    Some(counted(traces, "fragments_tested")? / counted(traces, "pixels_opened")?)
}

/// Views entered a ray.
pub(in crate::papers::vvp16) fn views(traces: &[&TraceRecord]) -> Option<f64> {
    Some(counted(traces, "views_entered")? / rays(traces))
}

/// With and without skipping.
fn skipping<'a>(scene: &SceneRows<'a>) -> Option<[&'a Row; 2]> {
    Some([row(scene, &vvp16::skipping("on"))?, row(scene, &vvp16::skipping("off"))?])
}

/// Time of diffuse rays without skipping over that with it.
fn skipping_gain(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [on, off] = skipping(scene)?;
    scene.trace_ratio(off, on, "diffuse")
}

/// The share of ray sets that have the same hits with and without skipping.
fn same_hits_without_skipping(scene: &SceneRows<'_>) -> Option<f64> {
    let [on, off] = skipping(scene)?;
    same_hits(on, off)
}

/// How the time of a diffuse ray is ranked by the efficiency of skipping over the scenes.
fn rank_of_time_by_efficiency<'a>(scenes: &[SceneRows<'a>]) -> Option<Estimate> {
    let point = |scene: &SceneRows<'a>| {
        let row = row(scene, &vvp16::skipping("on"))?;
        let traced = trace(row, "diffuse")?;
        Some((efficiency(&[traced])?, timed(row, "diffuse")?.times(1.0 / traced.count as f64)))
    };
    rank_correlation(scenes.first()?.record, &scenes.iter().filter_map(point).collect::<Vec<_>>())
}

/// How the build is ranked by the fragments over the scenes.
fn rank_of_build_by_fragments<'a>(scenes: &[SceneRows<'a>]) -> Option<Estimate> {
    let point = |scene: &SceneRows<'a>| {
        let row = row(scene, &[])?;
        Some((statistic(row, "fragments")?, Timed::steady_build(row)))
    };
    rank_correlation(scenes.first()?.record, &scenes.iter().filter_map(point).collect::<Vec<_>>())
}

/// What something is over the rays of two bounces, over what it is in the first.
fn second_over_first(scene: &SceneRows<'_>, of: fn(&[&TraceRecord]) -> Option<f64>) -> Option<f64> {
    let [one, two] = bounces(row(scene, &[])?)?;
    Some(of(&two)? / of(&one)?)
}

/// Time of both bounces over that of the first.
fn two_bounces_over_one(scene: &SceneRows<'_>) -> Option<Estimate> {
    Some(scene.set_ratio(row(scene, &[])?, "bounce2", "diffuse")? + 1.0)
}

/// More buckets than the first row has.
fn more_buckets<'a>(scene: &SceneRows<'a>) -> Option<[&'a Row; 2]> {
    Some([row(scene, &[("buckets", "8")])?, row(scene, &[("buckets", "12")])?])
}

/// Time of diffuse rays with the better of 8 and 12 buckets over that with 4; of complex scenes alone.
fn more_buckets_trace_where_deep(scene: &SceneRows<'_>) -> Option<Estimate> {
    let four = row(scene, &[("buckets", "4")])?;
    let ratios: Option<Vec<Estimate>> =
        more_buckets(scene)?.iter().map(|more| scene.trace_ratio(more, four, "diffuse")).collect();
    (statistic(four, "average_layers")? >= COMPLEX_LAYERS).then(|| Estimate::least(ratios?))?
}

/// The least of what 8 and 12 buckets take of bytes and of sorting, over what 4 take.
fn more_buckets_cost(scene: &SceneRows<'_>) -> Option<Estimate> {
    let four = row(scene, &[("buckets", "4")])?;
    let mut ratios = Vec::new();
    for more in more_buckets(scene)? {
        ratios.push((PAPER.bytes(more, Scope::Structure)? / PAPER.bytes(four, Scope::Structure)?).into());
        ratios.push(scene.phase_ratio(more, four, "reorder")?);
    }
    Estimate::least(ratios)
}

/// The share of the stored data nodes that any diffuse ray's hit reads.
fn data_nodes_read(scene: &SceneRows<'_>) -> Option<f64> {
    let row = row(scene, &[])?;
    Some(counted(&[trace(row, "diffuse")?], "payloads_touched")? / statistic(row, "fragments")?)
}
