//! Section 5.3: light fields.

use crate::papers::estimate::Estimate;
use crate::papers::quantity::{Quantity, timed_of_scene};
use crate::papers::rows::{SceneRows, trace};
use crate::papers::times::{ratio, traced};
use crate::papers::wkp15::row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("hierarchy_time_over_quadtree", "", hierarchy_time),
    timed_of_scene("many_cameras_time_over_few", "", many_cameras_over_few),
];

pub(in crate::papers::wkp15) const RAYS: &str = "light-field";
const HIERARCHIES: [&str; 3] = ["ploc-gpu", "bvh-gpu", "ray-query"];

/// The rows with so many cameras a side.
fn of_cameras<'a>(scene: &SceneRows<'a>, cameras: &str) -> SceneRows<'a> {
    scene.of_rays(&[("light_field_cameras", cameras)])
}

/// Time of a light field's rays in the fastest hierarchy over that in one layer.
fn hierarchy_time(scene: &SceneRows<'_>) -> Option<Estimate> {
    let scene = of_cameras(scene, "4");
    let own = row(&scene, &[("layers", "1")])?;
    let of = |hierarchy: &&str| scene.trace_ratio(scene.like_first(hierarchy, &[])?, own, RAYS);
    Estimate::least(HIERARCHIES.iter().filter_map(of))
}

/// Time with 256 cameras over that with 16, of one layer; as many rays.
fn many_cameras_over_few(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [many, few] = ["16", "4"].map(|cameras| row(&of_cameras(scene, cameras), &[("layers", "1")]));
    let (many, few) = (many?, few?);
    let same = trace(many, RAYS)?.count == trace(few, RAYS)?.count;
    same.then(|| ratio(scene.record, &traced(many, RAYS)?, &traced(few, RAYS)?))?
}
