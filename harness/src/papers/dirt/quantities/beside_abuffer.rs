//! DIRT's Table 2, Figure 11 and section 5.1: DIRT beside the A-buffer.

use super::accuracy::as_published;
use super::memory::references;
use crate::papers::Scope;
use crate::papers::dirt::PAPER;
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{IN_A_MILLION, PERCENT, Quantity, of_scene, of_scenes, rank_correlation, timed_of_scene};
use crate::papers::rows::{MILLION, SceneRows, beyond_of, counted, false_misses, footprint, statistic, trace};
use crate::papers::vvp16::{ABUFFER, bytes_over_formula, row};
use crate::results::{Classes, Row, TraceRecord};

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("memory_below_abuffer", PERCENT, memory_below),
    of_scene("references_beyond_fragments", PERCENT, references_beyond_fragments),
    timed_of_scene("build_below_abuffer", PERCENT, build_below),
    timed_of_scene("trace_below_abuffer", PERCENT, trace_below),
    timed_of_scene("dirt_trace_over_abuffer", "", trace_over),
    of_scenes("rank_of_saving_by_fragments", "", rank_of_saving_by_fragments),
    of_scenes("dirt_bytes_over_abuffer_where_fewest", "", bytes_over_abuffer_where_fewest),
    of_scene("abuffer_bytes_over_formula", "", bytes_over_formula),
    of_scene("fragments_false_misses_beyond_dirt", IN_A_MILLION, false_misses_beyond_dirt),
    of_scene("thickness_closes_and_invents", IN_A_MILLION, thickness_closes_and_invents),
    of_scene("froxels_gain_and_leave", IN_A_MILLION, froxels_gain_and_leave),
];

/// DIRT as Table 2 has it, and the A-buffer.
fn pair<'a>(scene: &SceneRows<'a>) -> Option<[&'a Row; 2]> {
    Some([scene.find("dirt", &[("tile_size", "1"), ("coverage", "standard")])?, row(scene, &[])?])
}

/// What DIRT with the paper's own buffers takes below what the A-buffer takes, percent.
fn memory_below(scene: &SceneRows<'_>) -> Option<f64> {
    let [dirt, abuffer] = pair(scene)?.map(|row| PAPER.bytes(row, Scope::OfPaper));
    Some(100.0 * (1.0 - dirt? / abuffer?))
}

/// Stored references beyond stored fragments, percent.
fn references_beyond_fragments(scene: &SceneRows<'_>) -> Option<f64> {
    let [dirt, abuffer] = pair(scene)?;
    Some(100.0 * (references(dirt)? / statistic(abuffer, "fragments")? - 1.0))
}

/// What DIRT's build takes less than the A-buffer's, percent.
fn build_below(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [dirt, abuffer] = pair(scene)?;
    scene.build_ratio(dirt, abuffer).map(Estimate::percent_below)
}

/// The same of diffuse rays.
fn trace_below(scene: &SceneRows<'_>) -> Option<Estimate> {
    trace_over(scene).map(Estimate::percent_below)
}

/// Time of diffuse rays in DIRT over that in the A-buffer.
fn trace_over(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [dirt, abuffer] = pair(scene)?;
    scene.trace_ratio(dirt, abuffer, "diffuse")
}

/// How DIRT's saving of memory is ranked by the fragments over the scenes.
fn rank_of_saving_by_fragments(scenes: &[SceneRows<'_>]) -> Option<f64> {
    let point = |scene: &SceneRows<'_>| {
        let [_, abuffer] = pair(scene)?;
        Some([statistic(abuffer, "fragments")?, memory_below(scene)?])
    };
    rank_correlation(&scenes.iter().filter_map(point).collect::<Vec<_>>())
}

/// Bytes of DIRT over those of the A-buffer, in the scene and at the resolution where a pixel has the fewest fragments.
fn bytes_over_abuffer_where_fewest(scenes: &[SceneRows<'_>]) -> Option<f64> {
    let point = |scene: SceneRows<'_>| {
        let (dirt, abuffer) = (scene.find("dirt", &[])?, row(&scene, &[])?);
        let layers = statistic(abuffer, "fragments")? / statistic(abuffer, "pixels")?;
        Some([layers, PAPER.bytes(dirt, Scope::OfPaper)? / PAPER.bytes(abuffer, Scope::OfPaper)?])
    };
    let all = scenes.iter().flat_map(SceneRows::by_resolution).filter_map(point);
    all.min_by(|a, b| a[0].total_cmp(&b[0])).map(|[_, ratio]| ratio)
}

fn is_mirrored(trace: &TraceRecord) -> bool {
    trace.rays == "specular"
}

/// Mirror rays in a million missed by fragments without thickness beyond those that DIRT misses.
fn false_misses_beyond_dirt(scene: &SceneRows<'_>) -> Option<f64> {
    let dirt = scene.find("dirt", &as_published(&[("tile_size", "1")]))?;
    beyond_of(row(scene, &[("thickness", "0")])?, dirt, is_mirrored, false_misses)
}

/// Rays in a million of a class of mirror rays under a rule.
fn share(row: &Row, of: impl Fn(&Classes) -> u64) -> Option<f64> {
    let [rays, found] = counted(trace(row, "specular")?, |closest| Some(of(&closest.classes.footprint)))?;
    (rays > 0).then(|| found as f64 / rays as f64 * MILLION)
}

fn thickness(row: &Row) -> Option<f64> {
    row.tracer.parameters.get("thickness")?.as_f64()
}

/// The rows of the A-buffer by rising thickness; none unless the first has none and another has some.
fn by_thickness<'a>(scene: &SceneRows<'a>) -> Option<Vec<&'a Row>> {
    let mut rows: Vec<(f64, &Row)> = scene.of_tracer(ABUFFER).filter_map(|row| Some((thickness(row)?, row))).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let usable = rows.first()?.0 == 0.0 && rows.last()?.0 > 0.0;
    usable.then(|| rows.into_iter().map(|(_, row)| row).collect())
}

/// From no thickness to the most: mirror rays in a million missed less, and those answered where nothing is or too near more; the
/// less of the two.
fn thickness_closes_and_invents(scene: &SceneRows<'_>) -> Option<f64> {
    let rows = by_thickness(scene)?;
    let (thin, thick) = (rows.first()?, rows.last()?);
    let missed = |row: &Row| share(row, |classes| classes.false_miss);
    let invented = |row: &Row| share(row, |classes| classes.false_hit + classes.early);
    Some((missed(thin)? - missed(thick)?).min(invented(thick)? - invented(thin)?))
}

/// With the thickness of the best footprint agreement: mirror rays in a million missed less than without, and those wrong all the
/// same; the less of the two.
fn froxels_gain_and_leave(scene: &SceneRows<'_>) -> Option<f64> {
    let rows = by_thickness(scene)?;
    let right = |row: &&Row| trace(row, "specular").and_then(footprint).unwrap_or(0.0);
    let best = rows.iter().copied().max_by(|a, b| right(a).total_cmp(&right(b)))?;
    let missed = |row: &Row| share(row, |classes| classes.false_miss);
    let wrong = share(best, Classes::wrong)?;
    Some((missed(rows.first()?)? - missed(best)?).min(wrong))
}
