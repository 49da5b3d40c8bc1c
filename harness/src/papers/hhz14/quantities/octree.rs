//! Table 1: beside the sparse voxel octree, and beside methods over depth images.

use super::search::accuracy;
use crate::papers::estimate::Estimate;
use crate::papers::hhz14::{ABUFFER, DEPTH_IMAGES, OCTREE};
use crate::papers::quantity::{Quantity, least, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, trace};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("octree_build_over_abuffer", "", build),
    timed_of_scene("octree_trace_over_abuffer", "", |scene| traced(scene, "dda2d")),
    timed_of_scene("octree_trace_over_three_step", "", |scene| traced(scene, "three-step")),
    timed_of_scene("octree_total_over_abuffer", "", |scene| total(scene, "dda2d")),
    timed_of_scene("octree_total_over_three_step", "", |scene| total(scene, "three-step")),
    of_scene("accuracy_over_depth_images", "", accuracy_over_depth_images),
    timed_of_scene("speed_over_depth_images", "", speed_over_depth_images),
];

/// The rays of a frame.
pub(in crate::papers::hhz14) const FRAME: [&str; 3] = ["specular", "refraction", "visibility"];

/// The first row of either, that of the A-buffers by a search.
pub(in crate::papers::hhz14) fn pair<'a>(scene: &SceneRows<'a>, search: &str) -> Option<[&'a Row; 2]> {
    Some([scene.like_first(OCTREE, &[])?, scene.like_first(ABUFFER, &[("search", search)])?])
}

/// How many times as long the octree's build takes.
fn build(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [octree, abuffer] = pair(scene, "dda2d")?;
    scene.build_ratio(octree, abuffer)
}

/// How many times as long all rays of a frame take in the octree, by the quicker of its walks.
fn traced(scene: &SceneRows<'_>, search: &str) -> Option<Estimate> {
    let [_, abuffer] = pair(scene, search)?;
    let walks = ["restart", "stack"].map(|walk| scene.like_first(OCTREE, &[("traversal", walk)]));
    Estimate::least(walks.into_iter().flatten().filter_map(|octree| scene.traces_ratio(octree, abuffer, &FRAME)))
}

/// The same with the build.
fn total(scene: &SceneRows<'_>, search: &str) -> Option<Estimate> {
    let [octree, abuffer] = pair(scene, search)?;
    scene.total_ratio(octree, abuffer, &FRAME.map(|rays| (rays, 1.0)))
}

/// Of every method over depth images how the A-buffers in three steps compare with it.
fn beside_depth_images<T>(scene: &SceneRows<'_>, compared: impl Fn(&Row, &Row) -> Option<T>) -> Option<[T; 2]> {
    let abuffer = scene.like_first(ABUFFER, &[("search", "three-step")])?;
    let [one, other] = DEPTH_IMAGES.map(|tracer| compared(abuffer, scene.like_first(tracer, &[])?));
    Some([one?, other?])
}

/// Accuracy over the best of depth images, of the ray set where that is least.
fn accuracy_over_depth_images(scene: &SceneRows<'_>) -> Option<f64> {
    let over = |abuffer: &Row, images: &Row| {
        least(FRAME.iter().filter_map(|rays| Some(accuracy(trace(abuffer, rays)?)? / accuracy(trace(images, rays)?)?)))
    };
    least(beside_depth_images(scene, over)?)
}

/// Time of all rays of a frame in the quickest of depth images over that in the A-buffers.
fn speed_over_depth_images(scene: &SceneRows<'_>) -> Option<Estimate> {
    Estimate::least(beside_depth_images(scene, |abuffer, images| scene.traces_ratio(images, abuffer, &FRAME))?)
}
