//! Figures 10 and 11: scenes that deform, and beside hierarchies.

use crate::papers::estimate::Estimate;
use crate::papers::quantity::{Quantity, greatest, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, footprint, trace};
use crate::papers::times::{ratio, traced};
use crate::papers::vvp16::{ABUFFER, TRBVH, row};
use crate::results::{Row, Timed};

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("device_bvh_build_over_abuffer", "", |scene| build_over_abuffer(scene, TRBVH)),
    timed_of_scene("bvh_build_over_abuffer", "", |scene| build_over_abuffer(scene, SBVH)),
    timed_of_scene("abuffer_trace_over_device_bvh", "", |scene| trace_over(scene, TRBVH)),
    timed_of_scene("abuffer_trace_over_bvh", "", |scene| trace_over(scene, SBVH)),
    timed_of_scene("min_bvh_total_over_abuffer", "", min_bvh_total_over_abuffer),
    timed_of_scene("break_even_samples", "samples", break_even_samples),
    timed_of_scene("four_samples_over_build", "", four_samples_over_build),
    of_scene("abuffer_footprint_agreement", "", footprint_agreement),
];

/// The hierarchy built on the host, in place of SBVH.
const SBVH: &str = "bvh-gpu";

/// The A-buffer beside these hierarchies, each by every tree that it has.
fn beside<'a>(scene: &SceneRows<'a>, hierarchies: &[&str]) -> impl Iterator<Item = [&'a Row; 2]> {
    let trees = hierarchies.iter().flat_map(|hierarchy| scene.differing_in(hierarchy, &["tree"]));
    trees.filter_map(|bvh| Some([row(scene, &[])?, bvh]))
}

/// Build of a hierarchy, by the quickest tree, over that of the A-buffer.
fn build_over_abuffer(scene: &SceneRows<'_>, hierarchy: &str) -> Option<Estimate> {
    Estimate::least(beside(scene, &[hierarchy]).filter_map(|[abuffer, bvh]| scene.build_ratio(bvh, abuffer)))
}

/// Time of diffuse rays in the A-buffer over that in a hierarchy, by the fastest tree.
fn trace_over(scene: &SceneRows<'_>, hierarchy: &str) -> Option<Estimate> {
    Estimate::greatest(
        beside(scene, &[hierarchy]).filter_map(|[abuffer, bvh]| scene.trace_ratio(abuffer, bvh, "diffuse")),
    )
}

/// Build and trace of the better hierarchy over those of the A-buffer.
fn min_bvh_total_over_abuffer(scene: &SceneRows<'_>) -> Option<Estimate> {
    let ratio = |[abuffer, bvh]: [&Row; 2]| scene.total_ratio(bvh, abuffer, &[("diffuse", 1.0)]);
    Estimate::least(beside(scene, &[TRBVH, SBVH]).filter_map(ratio))
}

/// Traces a frame from which on the hierarchy that gets there first takes no longer for build and traces; 0 where it builds no
/// slower or traces no faster, so that there is nothing to repay or nothing to repay it with.
fn break_even_samples(scene: &SceneRows<'_>) -> Option<Estimate> {
    let samples = |[abuffer, bvh]: [&Row; 2]| {
        // All in parts of a trace in the A-buffer.
        let trace = traced(abuffer, "diffuse")?;
        let part = |timed: &Timed<'_>| ratio(scene.record, timed, &trace);
        let owed = part(&Timed::steady_build(bvh))? - part(&Timed::steady_build(abuffer))?;
        let repaid = Estimate::from(1.0) - part(&traced(bvh, "diffuse")?)?;
        let nothing = owed.value <= 0.0 || repaid.value <= 0.0;
        let sure = [&owed, &repaid].iter().all(|each| each.interval[0] > 0.0);
        let surely_nothing = owed.interval[1] <= 0.0 || repaid.interval[1] <= 0.0;
        let found = owed / repaid;
        Some(match nothing {
            true if surely_nothing => Estimate { value: 0.0, interval: [0.0; 2], ..found },
            true => Estimate { value: 0.0, interval: [0.0, f64::INFINITY], ..found },
            false if sure => found,
            false => Estimate { interval: [0.0, f64::INFINITY], ..found },
        })
    };
    Estimate::least(beside(scene, &[TRBVH, SBVH]).filter_map(samples))
}

/// Footprint agreement of diffuse rays, the best over the rows.
fn footprint_agreement(scene: &SceneRows<'_>) -> Option<f64> {
    greatest(scene.of_tracer(ABUFFER).filter_map(|row| footprint(trace(row, "diffuse")?)))
}

/// Samples a pixel and frame of Figure 10.
pub(in crate::papers::vvp16) const SAMPLES: f64 = 4.0;

/// Time of a frame's samples over that of its build.
fn four_samples_over_build(scene: &SceneRows<'_>) -> Option<Estimate> {
    let row = row(scene, &[])?;
    ratio(scene.record, &traced(row, "diffuse")?.times(SAMPLES), &Timed::steady_build(row))
}
