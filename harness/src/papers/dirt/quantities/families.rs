//! Sections 2 and 5: the families of methods that came before.

use super::accuracy::as_published;
use crate::papers::Scope;
use crate::papers::dirt::{DIRT, PAPER};
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{Quantity, greatest, of_scene, rank_correlation, timed_of_scene};
use crate::papers::rows::{SceneRows, footprint, trace};
use crate::papers::times;
use crate::papers::{hhz14, vvp16, wkp15};
use crate::results::{Row, Timed};

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("min_trend_over_families", "", min_trend),
    of_scene("few_layers_agreement_less_dirt", "", few_layers_agreement_less_dirt),
    of_scene("families_below_abuffer", "", below_abuffer),
    of_scene("voxel_abuffer_bytes_over_abuffer", "", voxel_bytes_over_abuffer),
];

/// Ray sets of the families' table.
const RAYS: [&str; 2] = ["diffuse", "specular"];

/// One method a family, in the order of section 2: G-buffer, depth peeling, k-buffer, cube of G-buffers, three orthographic A-buffers, cube
/// of A-buffers.
fn families<'a>(scene: &SceneRows<'a>) -> Option<[&'a Row; 6]> {
    let layers = |tracer: &str, layers: &str| scene.find(tracer, &[("layers", layers)]);
    let trees = |layers: &str, views: &str| scene.find(wkp15::QUADTREE, &[("layers", layers), ("views", views)]);
    Some([
        layers(wkp15::DDA, "1")?,
        layers(wkp15::DDA, "2")?,
        trees("2", "frame")?,
        trees("1", "six")?,
        scene.find(hhz14::ABUFFER, &[])?,
        scene.find(vvp16::ABUFFER, &[])?,
    ])
}

/// Footprint agreement, mean of both ray sets.
fn agreement(row: &Row) -> Option<f64> {
    let both: Option<f64> = RAYS.iter().map(|rays| footprint(trace(row, rays)?)).sum();
    both.map(|sum| sum / RAYS.len() as f64)
}

fn bytes(row: &Row) -> Option<f64> {
    PAPER.bytes(row, Scope::Structure)
}

/// How build, memory and agreement are ranked in the order of the families: the least of the three.
fn min_trend(scene: &SceneRows<'_>) -> Option<Estimate> {
    let families = families(scene)?;
    let rank = |of: fn(&Row) -> Option<f64>| {
        let points = families.iter().enumerate().map(|(place, row)| Some([place as f64, of(row)?]));
        rank_correlation(&points.collect::<Option<Vec<_>>>()?).map(Estimate::from)
    };
    let builds = families.iter().enumerate().map(|(place, row)| (place as f64, Timed::steady_build(row)));
    let builds = times::rank_correlation(scene.record, &builds.collect::<Vec<_>>())?;
    Estimate::least([builds, rank(bytes)?, rank(agreement)?])
}

/// Footprint agreement of the best method of few layers less DIRT's.
fn few_layers_agreement_less_dirt(scene: &SceneRows<'_>) -> Option<f64> {
    let dirt = scene.find(DIRT, &as_published(&[("tile_size", "2")]))?;
    let best = greatest(families(scene)?[..4].iter().filter_map(|row| agreement(row)))?;
    Some(best - agreement(dirt)?)
}

/// The share of the families before the last that are both less accurate and smaller than it.
fn below_abuffer(scene: &SceneRows<'_>) -> Option<f64> {
    let [others @ .., abuffer] = families(scene)?;
    let of = |row: &Row| Some([agreement(row)?, bytes(row)?]);
    let [most_accurate, largest] = of(abuffer)?;
    let others = others.iter().map(|row| of(row)).collect::<Option<Vec<_>>>()?;
    let below = others.iter().filter(|[accuracy, bytes]| *accuracy < most_accurate && *bytes < largest).count();
    Some(below as f64 / others.len() as f64)
}

/// Bytes of three orthographic A-buffers with their grid over those of the cube of A-buffers.
fn voxel_bytes_over_abuffer(scene: &SceneRows<'_>) -> Option<f64> {
    let [.., voxels, abuffer] = families(scene)?;
    Some(bytes(voxels)? / bytes(abuffer)?)
}
