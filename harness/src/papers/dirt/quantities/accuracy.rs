//! Agreement with the truth, and rays that are lost.

use crate::papers::quantity::{IN_A_MILLION, Quantity, greatest, least, of_scene};
use crate::papers::rows::{MILLION, SceneRows, agreement, beyond, false_misses, trace, wrong};
use crate::results::Judgement;

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("min_tight_agreement", "", min_tight_agreement),
    of_scene("standard_false_misses_beyond", IN_A_MILLION, standard_false_misses_beyond),
    of_scene("coarse_tiles_agreement_change", IN_A_MILLION, coarse_tiles_agreement_change),
    of_scene("early_stop_wrong_rays", IN_A_MILLION, early_stop_wrong_rays),
    of_scene("tile_acceptance_false_misses", IN_A_MILLION, tile_acceptance_false_misses),
    of_scene("one_view_agreement_change", "", one_view_agreement_change),
];

/// Ray sets that start on surfaces.
const SECONDARY: [&str; 5] = ["specular", "glossy", "diffuse", "bounce2", "refraction"];

/// The least agreement over DIRT's rows and closest-hit sets.
fn min_tight_agreement(scene: &SceneRows<'_>) -> Option<f64> {
    let traces = scene.of_tracer("dirt").flat_map(|row| &row.traces);
    least(traces.filter(|trace| matches!(trace.judgement, Judgement::Closest(_))).filter_map(agreement))
}

const AS_PUBLISHED: [(&str, &str); 3] = [("coverage", "conservative"), ("searched", "until_hit"), ("accept", "tile")];

/// DIRT's values as published but for those given.
pub(super) fn as_published<'a>(values: &[(&'a str, &'a str)]) -> Vec<(&'a str, &'a str)> {
    let other = |(name, _): &&(&str, &str)| values.iter().all(|(own, _)| own != name);
    AS_PUBLISHED.iter().filter(other).chain(values).copied().collect()
}

/// False misses with coverage by sample beyond those with conservative coverage, tiles of one pixel.
fn standard_false_misses_beyond(scene: &SceneRows<'_>) -> Option<f64> {
    let standard = scene.find("dirt", &as_published(&[("tile_size", "1"), ("coverage", "standard")]))?;
    let conservative = scene.find("dirt", &as_published(&[("tile_size", "1")]))?;
    beyond(standard, conservative, false_misses)
}

/// The largest difference of agreement of a coarser tile from tiles of one pixel, either way, over tiles and ray sets.
fn coarse_tiles_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
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
fn early_stop_wrong_rays(scene: &SceneRows<'_>) -> Option<f64> {
    let published = scene.find("dirt", &as_published(&[("tile_size", "2")]))?;
    let all = scene.find("dirt", &as_published(&[("tile_size", "2"), ("searched", "all")]))?;
    beyond(published, all, wrong)
}

/// False misses when hits must lie in their tile beyond those when they count by distance; every bucket searched.
fn tile_acceptance_false_misses(scene: &SceneRows<'_>) -> Option<f64> {
    let tile = scene.find("dirt", &as_published(&[("tile_size", "2"), ("searched", "all")]))?;
    let distance =
        scene.find("dirt", &as_published(&[("tile_size", "2"), ("searched", "all"), ("accept", "distance")]))?;
    beyond(tile, distance, false_misses)
}

/// Agreement of one view less that of six, of the secondary set that loses least.
fn one_view_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    let [one, six] = ["frame", "six"].map(|views| scene.find("dirt", &[("views", views), ("shadow_map", "off")]));
    let (one, six) = (one?, six?);
    let of_set = |rays: &&str| Some(agreement(trace(one, rays)?)? - agreement(trace(six, rays)?)?);
    greatest(SECONDARY.iter().filter_map(of_set))
}
