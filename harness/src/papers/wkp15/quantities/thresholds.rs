//! Figures 10, 14 and 15: compression.

use super::saved;
use super::tree::reachable;
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{PERCENT, Quantity, of_scene, rank_correlation, timed_of_scene};
use crate::papers::rows::{SceneRows, footprint, trace};
use crate::papers::times::{self, traced};
use crate::papers::wkp15::row;
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("usual_thresholds_save", PERCENT, usual_thresholds_save),
    timed_of_scene("min_trend_over_distances", "", min_trend_over_distances),
    of_scene("node_trend_over_angles", "", node_trend_over_angles),
    timed_of_scene("growing_thresholds_save_in_views", PERCENT, growing_thresholds_save_in_views),
    timed_of_scene("growing_thresholds_save_in_lens", PERCENT, |scene| growing_thresholds_save(scene, "lens")),
];

/// Figure 14's distances at the usual angle, and angles at the usual distance; the same row is the first of both.
pub(in crate::papers::wkp15) const DISTANCES: [&str; 5] = ["1e-5", "1e-4", "1e-3", "1e-2", "1e-1"];
pub(in crate::papers::wkp15) const ANGLES: [&str; 5] = ["3", "8", "14", "20", "25"];

pub(in crate::papers::wkp15) fn with<'a>(
    scene: &SceneRows<'a>,
    angle: &str,
    distance: &str,
    grows: &str,
) -> Option<&'a Row> {
    row(scene, &[("gamma_norm", angle), ("gamma_dist", distance), ("gamma_growth", grows)])
}

/// A distance that every corner of a view in the unit cube keeps: the angle alone decides.
pub(in crate::papers::wkp15) const NO_DISTANCE: &str = "1";

/// Fixed thresholds.
pub(in crate::papers::wkp15) const FIXED: &str = "0";
/// Thresholds that grow with depth: by how many times themselves from the eye to far.
pub(in crate::papers::wkp15) const GROWING: &str = "16";

/// The rows over distances, those over angles, and those over angles alone, as far as there are such.
pub(in crate::papers::wkp15) fn over<'a>(scene: &SceneRows<'a>) -> [Vec<Option<&'a Row>>; 3] {
    let over_angles = |distance| ANGLES.iter().map(|angle| with(scene, angle, distance, FIXED)).collect();
    [
        DISTANCES.iter().map(|distance| with(scene, ANGLES[0], distance, FIXED)).collect(),
        over_angles(DISTANCES[0]),
        over_angles(NO_DISTANCE),
    ]
}

fn lossless<'a>(scene: &SceneRows<'a>) -> Option<&'a Row> {
    with(scene, "0", "0", FIXED)
}

/// By how much less time stereo rays take with the usual thresholds than with lossless ones, percent.
fn usual_thresholds_save(scene: &SceneRows<'_>) -> Option<Estimate> {
    saved(scene, with(scene, ANGLES[0], DISTANCES[0], FIXED)?, lossless(scene)?, "stereo")
}

/// How something rises over steps of a threshold, by ranks.
fn rising(rows: &[&Row], of: impl Fn(&Row) -> Option<f64>) -> Option<f64> {
    let points = rows.iter().enumerate().map(|(step, row)| Some([step as f64, of(row)?]));
    rank_correlation(&points.collect::<Option<Vec<_>>>()?)
}

/// Fewer nodes, by ranks.
fn falling_nodes(rows: &[&Row]) -> Option<f64> {
    rising(rows, |row| reachable(row).map(|nodes| -nodes))
}

/// How nodes fall, time falls and wrong rays rise over distances, by ranks: the least of them all.
fn min_trend_over_distances(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [rows, ..] = over(scene);
    let rows: Vec<&Row> = rows.into_iter().collect::<Option<_>>()?;
    let times = rows.iter().enumerate().map(|(step, row)| Some((-(step as f64), traced(row, "stereo")?)));
    let time = times::rank_correlation(scene.record, &times.collect::<Option<Vec<_>>>()?)?;
    let wrong = rising(&rows, |row| footprint(trace(row, "stereo")?).map(|agreement| -agreement))?;
    Estimate::least([falling_nodes(&rows)?.into(), wrong.into(), time])
}

/// How nodes fall over angles where no distance is asked for, by ranks.
fn node_trend_over_angles(scene: &SceneRows<'_>) -> Option<f64> {
    let [_, _, rows] = over(scene);
    falling_nodes(&rows.into_iter().collect::<Option<Vec<_>>>()?)
}

/// By how much less time some rays take with thresholds that grow than with fixed ones, percent, at the usual ones.
fn growing_thresholds_save(scene: &SceneRows<'_>, rays: &str) -> Option<Estimate> {
    let [growing, fixed] = [GROWING, FIXED].map(|grows| with(scene, ANGLES[0], DISTANCES[0], grows));
    saved(scene, growing?, fixed?, rays)
}

/// The same of stereo and temporal rays, mean of both.
fn growing_thresholds_save_in_views(scene: &SceneRows<'_>) -> Option<Estimate> {
    let both = ["stereo", "temporal"].map(|rays| growing_thresholds_save(scene, rays));
    Estimate::mean(both.into_iter().collect::<Option<Vec<_>>>()?)
}
