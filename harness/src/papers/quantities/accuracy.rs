//! Agreement with the truth, and rays that are lost.

use super::{greatest, least};
use crate::papers::rows::{SceneRows, agreement, false_misses, footprint, trace, wrong};
use crate::results::{Judgement, TraceRecord, TracerRun};

/// Rays in a million, of a share.
pub(super) const MILLION: f64 = 1e6;

/// Ray sets that start on surfaces.
const SECONDARY: [&str; 5] = ["specular", "glossy", "diffuse", "bounce2", "refraction"];

/// The least agreement over DIRT's rows and closest-hit sets.
pub(super) fn least_tight_agreement(scene: &SceneRows<'_>) -> Option<f64> {
    let traces = scene.of_tracer("dirt").flat_map(|run| &run.traces);
    least(traces.filter(|trace| matches!(trace.judgement, Judgement::Closest(_))).filter_map(agreement))
}

/// What is counted of a trace: rays that count, and of them those of a kind.
type Count = fn(&TraceRecord) -> Option<[u64; 2]>;

/// Rays in a million over all closest-hit sets that two rows have, in one beyond the other.
pub(super) fn beyond(one: &TracerRun, other: &TracerRun, count: Count) -> Option<f64> {
    beyond_of(one, other, |_| true, count)
}

/// The same over some of the sets.
pub(super) fn beyond_of(
    one: &TracerRun,
    other: &TracerRun,
    wanted: impl Fn(&TraceRecord) -> bool,
    count: Count,
) -> Option<f64> {
    let mut sums = [0_u64; 3];
    for own in one.traces.iter().filter(|trace| wanted(trace)) {
        let same = trace(other, &own.rays).filter(|each| each.rays_sha256 == own.rays_sha256);
        let Some((here, there)) = count(own).zip(same.and_then(count)) else { continue };
        sums = [sums[0] + here[0], sums[1] + here[1], sums[2] + there[1]];
    }
    let [rays, here, there] = sums.map(|sum| sum as f64);
    (rays > 0.0).then(|| (here - there) / rays * MILLION)
}

const AS_PUBLISHED: [(&str, &str); 3] = [("coverage", "conservative"), ("searched", "until_hit"), ("accept", "tile")];

/// DIRT's values as published but for those given.
pub(super) fn as_published<'a>(values: &[(&'a str, &'a str)]) -> Vec<(&'a str, &'a str)> {
    let other = |(name, _): &&(&str, &str)| values.iter().all(|(own, _)| own != name);
    AS_PUBLISHED.iter().filter(other).chain(values).copied().collect()
}

/// False misses with coverage by sample beyond those with conservative coverage, tiles of one pixel.
pub(super) fn standard_false_misses_beyond(scene: &SceneRows<'_>) -> Option<f64> {
    let standard = scene.find("dirt", &as_published(&[("tile_size", "1"), ("coverage", "standard")]))?;
    let conservative = scene.find("dirt", &as_published(&[("tile_size", "1")]))?;
    beyond(standard, conservative, false_misses)
}

/// The largest difference of agreement of a coarser tile from tiles of one pixel, either way, over tiles and ray sets.
pub(super) fn coarse_tiles_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    let fine = scene.find("dirt", &as_published(&[("tile_size", "1")]))?;
    let mut changes = Vec::new();
    for tile_size in ["2", "4", "8"] {
        let coarse = scene.find("dirt", &as_published(&[("tile_size", tile_size)]))?;
        for own in &fine.traces {
            let change = agreement(trace(coarse, &own.rays)?)? - agreement(own)?;
            changes.push(change.abs() * MILLION);
        }
    }
    greatest(changes)
}

/// Rays that are wrong as published beyond those wrong when every bucket is searched, tiles of 2x2.
pub(super) fn early_stop_wrong_rays(scene: &SceneRows<'_>) -> Option<f64> {
    let published = scene.find("dirt", &as_published(&[("tile_size", "2")]))?;
    let all = scene.find("dirt", &as_published(&[("tile_size", "2"), ("searched", "all")]))?;
    beyond(published, all, wrong)
}

/// False misses when hits must lie in their tile beyond those when they count by distance; every bucket searched.
pub(super) fn tile_acceptance_false_misses(scene: &SceneRows<'_>) -> Option<f64> {
    let tile = scene.find("dirt", &as_published(&[("tile_size", "2"), ("searched", "all")]))?;
    let distance =
        scene.find("dirt", &as_published(&[("tile_size", "2"), ("searched", "all"), ("accept", "distance")]))?;
    beyond(tile, distance, false_misses)
}

/// Agreement of one row less another's, of the secondary set where that is greatest.
fn greatest_difference(one: &TracerRun, other: &TracerRun, of: fn(&TraceRecord) -> Option<f64>) -> Option<f64> {
    let of_set = |rays: &&str| Some(of(trace(one, rays)?)? - of(trace(other, rays)?)?);
    greatest(SECONDARY.iter().filter_map(of_set))
}

/// Agreement of one view less that of six, of the secondary set that loses least.
pub(super) fn one_view_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    let [one, six] = ["frame", "six"].map(|views| scene.find("dirt", &[("views", views)]));
    greatest_difference(one?, six?, agreement)
}

/// Footprint agreement of one layer in screen space less DIRT's as published, of the secondary set that loses least.
pub(super) fn one_layer_agreement_less_dirt(scene: &SceneRows<'_>) -> Option<f64> {
    let layer = scene.find("screen-dda", &[])?;
    let dirt = scene.find("dirt", &as_published(&[("tile_size", "2")]))?;
    greatest_difference(layer, dirt, footprint)
}
