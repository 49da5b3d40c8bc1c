//! Figures 10, 14 and 15: compression.

use super::saved;
use super::tree::reachable;
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{PERCENT, Quantity, least, of_scene, rank_correlation, timed_of_scene};
use crate::papers::rows::{SceneRows, footprint, trace};
use crate::papers::times::{self, traced};
use crate::papers::wkp15::row;
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("usual_thresholds_save", PERCENT, usual_thresholds_save),
    timed_of_scene("aggressive_thresholds_save", PERCENT, aggressive_thresholds_save),
    of_scene("aggressive_agreement_change", "", aggressive_agreement_change),
    timed_of_scene("min_trend_over_thresholds", "", min_trend_over_thresholds),
    timed_of_scene("growing_thresholds_save_in_views", PERCENT, growing_thresholds_save_in_views),
    timed_of_scene("growing_thresholds_save_in_lens", PERCENT, |scene| growing_thresholds_save(scene, "lens")),
    of_scene("growing_agreement_change", "", growing_agreement_change),
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

/// Fixed thresholds.
pub(in crate::papers::wkp15) const FIXED: &str = "0";
/// Thresholds that grow with depth: by how many times themselves from the eye to far.
pub(in crate::papers::wkp15) const GROWING: &str = "16";

/// The rows over distances and those over angles, as far as there are such.
pub(in crate::papers::wkp15) fn over<'a>(scene: &SceneRows<'a>) -> [Vec<Option<&'a Row>>; 2] {
    [
        DISTANCES.iter().map(|distance| with(scene, ANGLES[0], distance, FIXED)).collect(),
        ANGLES.iter().map(|angle| with(scene, angle, DISTANCES[0], FIXED)).collect(),
    ]
}

fn lossless<'a>(scene: &SceneRows<'a>) -> Option<&'a Row> {
    with(scene, "0", "0", FIXED)
}

/// By how much less time stereo rays take with the usual thresholds than with lossless ones, percent.
fn usual_thresholds_save(scene: &SceneRows<'_>) -> Option<Estimate> {
    saved(scene, with(scene, ANGLES[0], DISTANCES[0], FIXED)?, lossless(scene)?, "stereo")
}

/// The largest thresholds of both kinds.
fn aggressive<'a>(scene: &SceneRows<'a>) -> Option<&'a Row> {
    with(scene, ANGLES[4], DISTANCES[4], FIXED)
}

/// The same with the largest.
fn aggressive_thresholds_save(scene: &SceneRows<'_>) -> Option<Estimate> {
    saved(scene, aggressive(scene)?, lossless(scene)?, "stereo")
}

/// Footprint agreement of stereo rays with the largest thresholds less that with lossless ones.
fn aggressive_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    Some(footprint(trace(aggressive(scene)?, "stereo")?)? - footprint(trace(lossless(scene)?, "stereo")?)?)
}

/// How nodes fall, time falls and wrong rays rise over either threshold, by ranks: the least of them all.
fn min_trend_over_thresholds(scene: &SceneRows<'_>) -> Option<Estimate> {
    let mut trends = Vec::new();
    for rows in over(scene) {
        let rows: Vec<&Row> = rows.into_iter().collect::<Option<_>>()?;
        let rising = |of: &dyn Fn(&Row) -> Option<f64>| {
            let points = rows.iter().enumerate().map(|(step, row)| Some([step as f64, of(row)?]));
            rank_correlation(&points.collect::<Option<Vec<_>>>()?).map(Estimate::from)
        };
        trends.push(rising(&|row| reachable(row).map(|nodes| -nodes))?);
        trends.push(rising(&|row| footprint(trace(row, "stereo")?).map(|agreement| -agreement))?);
        let times = rows.iter().enumerate().map(|(step, row)| Some((-(step as f64), traced(row, "stereo")?)));
        trends.push(times::rank_correlation(scene.record, &times.collect::<Option<Vec<_>>>()?)?);
    }
    Estimate::least(trends)
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

/// Footprint agreement with thresholds that grow less that with fixed ones, of all thresholds and ray sets the one that loses most.
fn growing_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    let pairs = ANGLES.iter().zip(DISTANCES).filter_map(|(angle, distance)| {
        let [growing, fixed] = [GROWING, FIXED].map(|grows| with(scene, angle, distance, grows));
        growing.zip(fixed)
    });
    least(pairs.flat_map(|(growing, fixed)| {
        fixed.traces.iter().filter_map(move |own| Some(footprint(trace(growing, &own.rays)?)? - footprint(own)?))
    }))
}
