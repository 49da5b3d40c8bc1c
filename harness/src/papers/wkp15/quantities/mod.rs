//! What decides WKP15's claims.

mod lens;
pub(super) mod light_field;
mod peers;
pub(super) mod reflections;
mod text;
pub(super) mod thresholds;
pub(super) mod tree;

use super::one_and_two;
use crate::papers::Quantity;
use crate::papers::estimate::Estimate;
use crate::papers::rows::{SceneRows, counted, of_cause, per_ray};
use crate::results::{Row, TraceRecord};

/// All of them.
pub(super) const QUANTITIES: &[&[Quantity]] = &[
    tree::QUANTITIES,
    peers::QUANTITIES,
    lens::QUANTITIES,
    reflections::QUANTITIES,
    thresholds::QUANTITIES,
    light_field::QUANTITIES,
    text::QUANTITIES,
];

/// What its tracer counts of nodes that a ray is tested against, in all trees.
pub(super) const NODES: &str = "nodes_visited";
/// What it counts of them that are boxes.
pub(super) const BOXES: &str = "box_tests";
/// What it counts of rays that go on to a second layer, and of those that end behind the first.
const ASKING_SECOND: &str = "rays_asking_layer_2";
const BEHIND_FIRST: &str = "hits_behind_layer_1";
/// What the height field counts of cells of its pyramid that a ray visits.
pub(super) const CELLS: &str = "cells_visited";
/// What the marching peer counts of depths that it looks at.
pub(super) const SAMPLES: &str = "depth_samples";
/// What the judge says of rays whose true hit lies behind what the views keep.
pub(super) const HIDDEN_LAYER: &str = "hidden_layer";
pub(super) const LEFT_OUT: &str = "left_out";
/// What it says of those whose true hit no view holds.
pub(super) const OFF_VIEW: &str = "off_view";

/// What makes a second layer show something else than the back of what the first shows: a separation, or front faces alone.
const OTHER_LAYERS: [(&str, &str); 2] = [("minimum_separation", "0.02"), ("back_faces", "culled")];
/// DDA without a cap of steps that a frame could reach.
const UNCAPPED: &[(&str, &str)] = &[("max_steps", super::experiments::NO_CAP)];

/// The share of a trace's rays that go on to a second layer.
pub(super) fn share_asking_second(trace: &TraceRecord) -> Option<f64> {
    per_ray(trace, ASKING_SECOND)
}

/// The share of a trace's rays that end in a layer behind the first.
pub(super) fn share_behind_first(trace: &TraceRecord) -> Option<f64> {
    per_ray(trace, BEHIND_FIRST)
}

/// The share of a trace's rays that are wrong for a cause under `footprint`; of closest-hit sets alone.
pub(super) fn share_of_cause(trace: &TraceRecord, cause: &str) -> Option<f64> {
    share(of_cause(trace, "footprint", cause)?)
}

/// Rays that count, and of them those wrongly missed, under `footprint`; of closest-hit sets alone.
fn missed(trace: &TraceRecord) -> Option<[u64; 2]> {
    counted(trace, |closest| Some(closest.classes.footprint.false_miss))
}

/// The same as a share of the rays of one trace.
pub(super) fn share_missed(trace: &TraceRecord) -> Option<f64> {
    share(missed(trace)?)
}

fn share([rays, of_kind]: [u64; 2]) -> Option<f64> {
    (rays > 0).then(|| of_kind as f64 / rays as f64)
}

/// How many times as long some rays take in two layers, of other surfaces if that is said, as in one.
fn second_layer(scene: &SceneRows<'_>, rays: &str, other: &[(&str, &str)]) -> Option<Estimate> {
    let [one, _] = one_and_two(scene, super::QUADTREE, &[])?;
    let two = super::row(scene, &[&[("layers", "2")], other].concat())?;
    scene.trace_ratio(two, one, rays)
}

/// By how much less time one row takes than another, percent of the other's.
fn saved(scene: &SceneRows<'_>, one: &Row, other: &Row, rays: &str) -> Option<Estimate> {
    scene.trace_ratio(one, other, rays).map(Estimate::percent_below)
}
