//! Table 1: construction.

use std::collections::BTreeMap;

use crate::papers::estimate::Estimate;
use crate::papers::quantity::{Quantity, farthest_from_one, of_scene, timed_of_scene, timed_of_scenes};
use crate::papers::rows::{SceneRows, statistic};
use crate::papers::times::{rank_correlation, ratio};
use crate::papers::wkp15::{QUADTREE, one_and_two, row};
use crate::results::{PhaseRecord, Timed, TracerRun};

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scenes("tree_time_of_most_triangles_over_fewest", "", of_most_triangles_over_fewest),
    timed_of_scene("tree_time_of_two_layers_over_one", "", two_layers_over_one),
    timed_of_scene("drawing_two_layers_over_one", "", drawing_two_layers_over_one),
    timed_of_scene("rank_of_tree_time_by_nodes", "", rank_by_nodes),
    of_scene("bytes_a_node", "bytes", bytes_a_node),
];

/// What the phases of the trees begin with.
const OF_TREES: [&str; 2] = ["bottom level", "merge level"];
/// What those begin with that draw the layers and look up what shading needs; what is left copies for searches.
const OF_LAYERS: [&str; 3] = ["draw layers", "name triangles", "normals and materials"];
/// What the ledger calls the trees.
const TREES: &str = "quad-tree nodes";
/// Bytes of a node by Figure 3.
const NODE_BYTES: f64 = 8.0;

/// Those phases of a row's build whose names begin so.
fn phases<'a>(run: &'a TracerRun, begins: &'static [&'static str]) -> impl Iterator<Item = &'a PhaseRecord> {
    let phases = run.build.times.phases.iter();
    phases.filter(move |phase| begins.iter().any(|begin| phase.name.starts_with(begin)))
}

fn timed<'a>(run: &'a TracerRun, begins: &'static [&'static str]) -> Option<Timed<'a>> {
    phases(run, begins).map(|phase| Timed::build_phase(run, &phase.name)).reduce(Timed::and)
}

/// The construction as the paper times it.
fn trees(run: &TracerRun) -> Option<Timed<'_>> {
    timed(run, &OF_TREES)
}

/// Drawing the layers.
fn drawing(run: &TracerRun) -> Option<Timed<'_>> {
    timed(run, &OF_LAYERS)
}

/// Median milliseconds of the construction and of drawing.
pub(in crate::papers::wkp15) fn phase_ms(run: &TracerRun) -> [f64; 2] {
    let sum = |begins: &'static [&'static str]| phases(run, begins).map(|phase| phase.median_ms).sum::<f64>();
    [sum(&OF_TREES), sum(&OF_LAYERS)]
}

/// Time of the trees of one layer with the most triangles over that with the fewest, of the scene where it is farthest from 1.
fn of_most_triangles_over_fewest(scenes: &[SceneRows<'_>]) -> Option<Estimate> {
    let mut by_name: BTreeMap<&str, Vec<&TracerRun>> = BTreeMap::new();
    for scene in scenes {
        let run = row(scene, &[("layers", "1")])?;
        by_name.entry(&run.scene.name).or_default().push(run);
    }
    let run = scenes.first()?.run;
    let of_scene = |runs: &Vec<&TracerRun>| {
        let triangles = |run: &&&TracerRun| run.scene.triangles;
        let (fewest, most) = (runs.iter().min_by_key(triangles)?, runs.iter().max_by_key(triangles)?);
        (fewest.scene.triangles < most.scene.triangles).then(|| ratio(run, &trees(most)?, &trees(fewest)?))?
    };
    let all: Vec<Estimate> = by_name.values().filter_map(of_scene).collect();
    let [least, greatest] = [Estimate::least(all.clone())?, Estimate::greatest(all)?];
    Some(if least.value * greatest.value < 1.0 { least } else { greatest })
}

/// Time of the trees of two layers over that of one.
fn two_layers_over_one(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [one, two] = one_and_two(scene, QUADTREE)?;
    ratio(scene.run, &trees(two)?, &trees(one)?)
}

/// Time of drawing two layers over that of one.
fn drawing_two_layers_over_one(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [one, two] = one_and_two(scene, QUADTREE)?;
    ratio(scene.run, &drawing(two)?, &drawing(one)?)
}

/// Nodes that a search can reach: leaves and boxes above them.
pub(in crate::papers::wkp15) fn reachable(run: &TracerRun) -> Option<f64> {
    ["plane_leaves", "boxes", "empty_nodes"].iter().map(|name| statistic(run, name)).sum()
}

/// How the time of the trees is ranked by the nodes that are left of them over the rows of a scene.
fn rank_by_nodes(scene: &SceneRows<'_>) -> Option<Estimate> {
    let points = scene.of_tracer(QUADTREE).filter_map(|run| Some((reachable(run)?, trees(run)?)));
    rank_correlation(scene.run, &points.collect::<Vec<_>>())
}

/// Bytes of the trees by the ledger over the nodes of their levels, reached or not, of all rows that which is farthest from the paper's.
fn bytes_a_node(scene: &SceneRows<'_>) -> Option<f64> {
    let bytes = |run: &TracerRun| {
        let trees = run.memory.structure.iter().find(|part| part.name == TREES)?;
        Some(trees.used_bytes as f64 / statistic(run, "nodes")?)
    };
    let all = scene.of_tracer(QUADTREE).filter_map(bytes).map(|bytes| bytes / NODE_BYTES);
    farthest_from_one(all).map(|ratio| ratio * NODE_BYTES)
}
