//! Table 1: beside the sparse voxel octree.

use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{ABUFFER, OCTREE};
use crate::papers::quantity::{Quantity, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, footprint, trace};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("octree_build_over_abuffer", "", build),
    timed_of_scene("octree_trace_over_abuffer", "", traced),
    timed_of_scene("octree_total_over_abuffer", "", total),
    of_scene("refraction_agreement_less_specular", "", refraction_less_specular),
];

/// The rays of a frame.
pub(in crate::papers::hhz14) const FRAME: [&str; 3] = ["specular", "refraction", "visibility"];

/// The first row of either.
pub(in crate::papers::hhz14) fn pair<'a>(scene: &SceneRows<'a>) -> Option<[&'a Row; 2]> {
    Some([scene.like_first(OCTREE, &[])?, scene.like_first(ABUFFER, &[])?])
}

/// How many times as long the octree's build takes.
fn build(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [octree, abuffer] = pair(scene)?;
    scene.build_ratio(octree, abuffer)
}

/// How many times as long all rays of a frame take in the octree, by the quicker of its walks.
fn traced(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [_, abuffer] = pair(scene)?;
    let walks = ["restart", "stack"].map(|walk| scene.like_first(OCTREE, &[("traversal", walk)]));
    Estimate::least(walks.into_iter().flatten().filter_map(|octree| scene.traces_ratio(octree, abuffer, &FRAME)))
}

/// The same with the build.
fn total(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [octree, abuffer] = pair(scene)?;
    scene.total_ratio(octree, abuffer, &FRAME.map(|rays| (rays, 1.0)))
}

/// Footprint agreement of rays that start in solids less that of rays that start outside.
fn refraction_less_specular(scene: &SceneRows<'_>) -> Option<f64> {
    let [_, abuffer] = pair(scene)?;
    Some(footprint(trace(abuffer, "refraction")?)? - footprint(trace(abuffer, "specular")?)?)
}
