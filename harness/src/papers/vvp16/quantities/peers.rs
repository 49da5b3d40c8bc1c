//! Figure 11: beside hierarchies.

use crate::papers::quantity::{Quantity, greatest, least, of_scene};
use crate::papers::rows::{SceneRows, footprint, trace};
use crate::papers::vvp16::{ABUFFER, row};
use crate::results::TracerRun;
use crate::results::host_ms;
use crate::results::time_ratio;

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("lbvh_build_over_abuffer", "", lbvh_build_over_abuffer),
    of_scene("bvh_build_over_abuffer", "", bvh_build_over_abuffer),
    of_scene("abuffer_trace_over_lbvh", "", trace_over_lbvh),
    of_scene("abuffer_trace_over_bvh", "", trace_over_bvh),
    of_scene("least_bvh_total_over_abuffer", "", least_bvh_total_over_abuffer),
    of_scene("break_even_samples", "samples", break_even_samples),
    of_scene("abuffer_footprint_agreement", "", footprint_agreement),
];

/// The hierarchy built on the device, in place of TRBVH.
const TRBVH: &str = "lbvh-gpu";
/// The hierarchy built on the host, in place of SBVH.
const SBVH: &str = "bvh-gpu";

fn beside<'a>(scene: &SceneRows<'a>, hierarchy: &str) -> Option<[&'a TracerRun; 2]> {
    Some([row(scene, &[])?, scene.find(hierarchy, &[])?])
}

/// Build of a hierarchy over that of the A-buffer, by the host's clock.
fn build_over_abuffer(scene: &SceneRows<'_>, hierarchy: &str) -> Option<f64> {
    let [abuffer, bvh] = beside(scene, hierarchy)?;
    Some(host_ms(&bvh.build.times)? / host_ms(&abuffer.build.times)?)
}

fn lbvh_build_over_abuffer(scene: &SceneRows<'_>) -> Option<f64> {
    build_over_abuffer(scene, TRBVH)
}

fn bvh_build_over_abuffer(scene: &SceneRows<'_>) -> Option<f64> {
    build_over_abuffer(scene, SBVH)
}

/// Time of diffuse rays in the A-buffer over that in a hierarchy.
fn trace_over(scene: &SceneRows<'_>, hierarchy: &str) -> Option<f64> {
    let [abuffer, bvh] = beside(scene, hierarchy)?;
    time_ratio(&trace(abuffer, "diffuse")?.times, &trace(bvh, "diffuse")?.times)
}

fn trace_over_lbvh(scene: &SceneRows<'_>) -> Option<f64> {
    trace_over(scene, TRBVH)
}

fn trace_over_bvh(scene: &SceneRows<'_>) -> Option<f64> {
    trace_over(scene, SBVH)
}

/// Build and a trace of diffuse rays, ms by the host's clock.
fn times(run: &TracerRun) -> Option<[f64; 2]> {
    Some([host_ms(&run.build.times)?, host_ms(&trace(run, "diffuse")?.times)?])
}

/// Build and trace of the better hierarchy over those of the A-buffer.
fn least_bvh_total_over_abuffer(scene: &SceneRows<'_>) -> Option<f64> {
    let ratio = |hierarchy: &&str| {
        let [abuffer, bvh] = beside(scene, hierarchy)?;
        Some(times(bvh)?.iter().sum::<f64>() / times(abuffer)?.iter().sum::<f64>())
    };
    least([TRBVH, SBVH].iter().filter_map(ratio))
}

/// Traces a frame from which on the hierarchy that gets there first takes no longer for build and traces; 0 where it builds no
/// slower or traces no faster, so that there is nothing to repay or nothing to repay it with.
fn break_even_samples(scene: &SceneRows<'_>) -> Option<f64> {
    let samples = |hierarchy: &&str| {
        let [abuffer, bvh] = beside(scene, hierarchy)?;
        let ([own_build, own_trace], [build, trace]) = (times(abuffer)?, times(bvh)?);
        let repaid = build > own_build && trace < own_trace;
        Some(if repaid { (build - own_build) / (own_trace - trace) } else { 0.0 })
    };
    least([TRBVH, SBVH].iter().filter_map(samples))
}

/// Footprint agreement of diffuse rays, the best over the rows.
fn footprint_agreement(scene: &SceneRows<'_>) -> Option<f64> {
    greatest(scene.of_tracer(ABUFFER).filter_map(|run| footprint(trace(run, "diffuse")?)))
}
