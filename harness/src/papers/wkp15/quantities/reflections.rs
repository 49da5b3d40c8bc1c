//! Table 5: reflections in the cube.

use super::OFF_VIEW;
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{IN_A_MILLION, Quantity, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, beyond, of_cause};
use crate::papers::wkp15::row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("three_bounces_over_one", "", three_bounces_over_one),
    timed_of_scene("second_layer_time_of_reflections", "", second_layer_time),
    of_scene("one_view_off_view_beyond_cube", IN_A_MILLION, one_view_off_view_beyond_cube),
];

/// The bounces of a glossy path.
pub(in crate::papers::wkp15) const BOUNCES: [&str; 3] = ["glossy", "glossy2", "glossy3"];

/// Time of three bounces over that of the first, mean of one layer and two.
fn three_bounces_over_one(scene: &SceneRows<'_>) -> Option<Estimate> {
    let of_layers = |layers: &str| {
        let row = row(scene, &[("layers", layers)])?;
        let [_, second, third] = BOUNCES.map(|rays| scene.set_ratio(row, rays, BOUNCES[0]));
        Some(second? + third? + 1.0)
    };
    Estimate::mean(["1", "2"].into_iter().map(of_layers).collect::<Option<Vec<_>>>()?)
}

/// Time of three bounces in two layers over that in one.
fn second_layer_time(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [one, two] = ["1", "2"].map(|layers| row(scene, &[("layers", layers)]));
    let (one, two) = (one?, two?);
    let ratios = BOUNCES.map(|rays| scene.trace_ratio(two, one, rays));
    Estimate::mean(ratios.into_iter().collect::<Option<Vec<_>>>()?)
}

/// Rays in a million whose true hit no view holds with one view beyond those with six faces; two layers, all reflections.
fn one_view_off_view_beyond_cube(scene: &SceneRows<'_>) -> Option<f64> {
    let [one, six] = ["frame", "six"].map(|views| row(scene, &[("layers", "2"), ("views", views)]));
    beyond(one?, six?, |trace| of_cause(trace, "footprint", OFF_VIEW))
}
