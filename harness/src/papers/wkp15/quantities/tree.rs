//! Table 1: construction.

use std::collections::BTreeMap;

use crate::papers::estimate::Estimate;
use crate::papers::quantity::{Quantity, timed_of_scene, timed_of_scenes};
use crate::papers::rows::{SceneRows, statistic};
use crate::papers::times::{rank_correlation, ratio};
use crate::papers::wkp15::{QUADTREE, one_and_two, row};
use crate::results::{PhaseRecord, Row, Timed};

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scenes("tree_time_of_most_triangles_over_fewest", "", of_most_triangles_over_fewest),
    timed_of_scene("tree_time_of_two_layers_over_one", "", two_layers_over_one),
    timed_of_scene("drawing_two_layers_over_one", "", drawing_two_layers_over_one),
    timed_of_scene("rank_of_tree_time_by_nodes", "", rank_by_nodes),
];

/// What the phases of the trees begin with.
const OF_TREES: [&str; 2] = ["bottom level", "merge level"];
/// What those begin with that draw the layers and look up what shading needs; what is left copies for searches.
const OF_LAYERS: [&str; 3] = ["draw layers", "name triangles", "normals and materials"];

/// Those phases of a row's build whose names begin so.
fn phases<'a>(row: &'a Row, begins: &'static [&'static str]) -> impl Iterator<Item = &'a PhaseRecord> {
    let phases = row.build.times.phases.iter();
    phases.filter(move |phase| begins.iter().any(|begin| phase.name.starts_with(begin)))
}

fn timed<'a>(row: &'a Row, begins: &'static [&'static str]) -> Option<Timed<'a>> {
    phases(row, begins).map(|phase| Timed::build_phase(row, &phase.name)).reduce(Timed::and)
}

/// The construction as the paper times it.
fn trees(row: &Row) -> Option<Timed<'_>> {
    timed(row, &OF_TREES)
}

/// Drawing the layers.
fn drawing(row: &Row) -> Option<Timed<'_>> {
    timed(row, &OF_LAYERS)
}

/// Median milliseconds of the construction and of drawing.
pub(in crate::papers::wkp15) fn phase_ms(row: &Row) -> [f64; 2] {
    let sum = |begins: &'static [&'static str]| phases(row, begins).map(|phase| phase.median_ms).sum::<f64>();
    [sum(&OF_TREES), sum(&OF_LAYERS)]
}

/// Time of the trees of one layer with the most triangles over that with the fewest, of the scene where it is farthest from 1.
fn of_most_triangles_over_fewest(scenes: &[SceneRows<'_>]) -> Option<Estimate> {
    let mut by_name: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for scene in scenes {
        let row = row(scene, &[("layers", "1")])?;
        by_name.entry(&row.scene.name).or_default().push(row);
    }
    let row = scenes.first()?.record;
    let of_scene = |rows: &Vec<&Row>| {
        let triangles = |row: &&&Row| row.scene.triangles;
        let (fewest, most) = (rows.iter().min_by_key(triangles)?, rows.iter().max_by_key(triangles)?);
        (fewest.scene.triangles < most.scene.triangles).then(|| ratio(row, &trees(most)?, &trees(fewest)?))?
    };
    let all: Vec<Estimate> = by_name.values().filter_map(of_scene).collect();
    let [least, greatest] = [Estimate::least(all.clone())?, Estimate::greatest(all)?];
    Some(if least.value * greatest.value < 1.0 { least } else { greatest })
}

/// Time of the trees of two layers over that of one.
fn two_layers_over_one(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [one, two] = one_and_two(scene, QUADTREE, &[])?;
    ratio(scene.record, &trees(two)?, &trees(one)?)
}

/// Time of drawing two layers over that of one.
fn drawing_two_layers_over_one(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [one, two] = one_and_two(scene, QUADTREE, &[])?;
    ratio(scene.record, &drawing(two)?, &drawing(one)?)
}

/// Nodes that a search can reach: leaves and boxes above them.
pub(in crate::papers::wkp15) fn reachable(row: &Row) -> Option<f64> {
    ["plane_leaves", "boxes", "empty_nodes"].iter().map(|name| statistic(row, name)).sum()
}

/// How the time of the trees is ranked by the nodes that are left of them over the rows of a scene.
fn rank_by_nodes(scene: &SceneRows<'_>) -> Option<Estimate> {
    let points = scene.of_tracer(QUADTREE).filter_map(|row| Some((reachable(row)?, trees(row)?)));
    rank_correlation(scene.record, &points.collect::<Vec<_>>())
}
