//! Table 5: reflections in the cube.

use super::OFF_VIEW;
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{IN_A_MILLION, Quantity, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, beyond, of_cause};
use crate::papers::wkp15::{SAMPLES_A_RAY, row};

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("eight_samples_over_four", "", eight_samples_over_four),
    timed_of_scene("second_layer_time_of_reflections", "", second_layer_time),
    of_scene("one_view_off_view_beyond_cube", IN_A_MILLION, one_view_off_view_beyond_cube),
];

/// The bounces of a glossy path.
pub(in crate::papers::wkp15) const BOUNCES: [&str; 3] = ["glossy", "glossy2", "glossy3"];

/// Time of three bounces of two rows, the one over the other.
fn bounces_ratio(scene: &SceneRows<'_>, one: &[(&str, &str)], other: &[(&str, &str)]) -> Option<Estimate> {
    let (one, other) = (row(scene, one)?, row(scene, other)?);
    let ratios = BOUNCES.map(|rays| scene.trace_ratio(one, other, rays));
    Estimate::mean(ratios.into_iter().collect::<Option<Vec<_>>>()?)
}

/// Time of three bounces with eight samples beside a ray over that with four, mean of one layer and two.
fn eight_samples_over_four(scene: &SceneRows<'_>) -> Option<Estimate> {
    let of_layers = |layers| {
        let [eight, four] = ["8", "4"].map(|samples| [("layers", layers), (SAMPLES_A_RAY, samples)]);
        bounces_ratio(scene, &eight, &four)
    };
    Estimate::mean(["1", "2"].into_iter().map(of_layers).collect::<Option<Vec<_>>>()?)
}

/// Time of three bounces in two layers over that in one.
fn second_layer_time(scene: &SceneRows<'_>) -> Option<Estimate> {
    bounces_ratio(scene, &[("layers", "2")], &[("layers", "1")])
}

/// Rays in a million whose true hit no view holds with one view beyond those with six faces; two layers, all reflections.
fn one_view_off_view_beyond_cube(scene: &SceneRows<'_>) -> Option<f64> {
    let [one, six] = ["frame", "six"].map(|views| row(scene, &[("layers", "2"), ("views", views)]));
    beyond(one?, six?, |trace| of_cause(trace, "footprint", OFF_VIEW))
}
