//! Figure 12: five storages, plain, decoupled, and decoupled with skipping.

use crate::papers::quantity::{PERCENT, Quantity, greatest, least, mean, of_scene, of_scenes};
use crate::papers::rows::{SceneRows, statistic, trace};
use crate::papers::vvp16::{self, row};
use crate::results::time_ratio;
use crate::results::{Times, TracerRun};

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("decoupling_gain", PERCENT, decoupling_gain),
    of_scene("skipping_gain_of_variants", PERCENT, skipping_gain),
    of_scenes("skipping_speedup_evenness", "", skipping_speedup_evenness),
    of_scene("decoupling_build_gain", PERCENT, decoupling_build_gain),
    of_scene("slowest_build_over_fastest", "", slowest_build_over_fastest),
    of_scene("bucketed_over_others", "", bucketed_over_others),
    of_scene("dllb_over_fastest_other", "", dllb_over_fastest_other),
    of_scene("covered_pixels_share", "", covered_pixels_share),
];

/// The storages of the figure.
pub(in crate::papers::vvp16) const STORAGES: [&str; 5] = ["s-buffer", "ll", "dll", "llb", "dllb"];
const RAYS: &str = "pixel-random";
/// Data in the nodes, no skipping.
const PLAIN: [&str; 2] = ["off", "off"];
const DECOUPLED: [&str; 2] = ["on", "off"];
const SKIPPING: [&str; 2] = ["on", "on"];
/// The figure's ways to keep data and to search: heading, values of decoupled and skipping.
pub(in crate::papers::vvp16) const WAYS: [(&str, [&str; 2]); 3] =
    [("default", PLAIN), ("decoupled", DECOUPLED), ("empty space skipping", SKIPPING)];

pub(in crate::papers::vvp16) fn with<'a>(
    scene: &SceneRows<'a>,
    storage: &str,
    [decoupled, skipping]: [&str; 2],
) -> Option<&'a TracerRun> {
    row(scene, &[&[("storage", storage), ("decoupled", decoupled)][..], &vvp16::skipping(skipping)].concat())
}

fn traced(run: &TracerRun) -> Option<&Times> {
    Some(&trace(run, RAYS)?.times)
}

/// How many times as fast the second way is as the first, a storage each.
fn speedups(scene: &SceneRows<'_>, ways: [[&str; 2]; 2]) -> Option<Vec<f64>> {
    let of = |storage: &&str| {
        let [from, to] = ways.map(|way| with(scene, storage, way));
        time_ratio(traced(from?)?, traced(to?)?)
    };
    STORAGES.iter().map(of).collect()
}

/// By how much data apart makes traces faster, percent, mean over the storages.
fn decoupling_gain(scene: &SceneRows<'_>) -> Option<f64> {
    Some(100.0 * (mean(&speedups(scene, [PLAIN, DECOUPLED])?)? - 1.0))
}

/// By how much skipping makes traces faster, percent, mean over the storages.
fn skipping_gain(scene: &SceneRows<'_>) -> Option<f64> {
    Some(100.0 * (mean(&speedups(scene, [DECOUPLED, SKIPPING])?)? - 1.0))
}

/// How evenly the logarithm of the speed-up by skipping grows with the fragments, from scene to scene: the least growth a
/// fragment over the greatest, 1 where the speed-up is exponential, 0 where it never grows.
fn skipping_speedup_evenness(scenes: &[SceneRows<'_>]) -> Option<f64> {
    let point = |scene: &SceneRows<'_>| {
        let speedup = mean(&speedups(scene, [DECOUPLED, SKIPPING])?)?;
        Some([statistic(with(scene, "dllb", SKIPPING)?, "fragments")?, speedup.ln()])
    };
    let mut points: Vec<[f64; 2]> = scenes.iter().filter_map(point).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let growth = || points.windows(2).map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]));
    let (slowest, fastest) = (least(growth())?, greatest(growth())?);
    (points.len() > 2).then_some(if fastest > 0.0 { slowest / fastest } else { 0.0 })
}

/// What data apart saves of the build's time, percent, mean over the storages.
fn decoupling_build_gain(scene: &SceneRows<'_>) -> Option<f64> {
    let saved = |storage: &&str| {
        let [plain, decoupled] = [PLAIN, DECOUPLED].map(|way| with(scene, storage, way));
        Some(100.0 * (1.0 - time_ratio(&decoupled?.build.times, &plain?.build.times)?))
    };
    mean(&STORAGES.iter().map(saved).collect::<Option<Vec<f64>>>()?)
}

/// Build of the slowest storage over that of the fastest, decoupled.
fn slowest_build_over_fastest(scene: &SceneRows<'_>) -> Option<f64> {
    let first = with(scene, STORAGES[0], DECOUPLED)?;
    let of = |storage: &&str| time_ratio(&with(scene, storage, DECOUPLED)?.build.times, &first.build.times);
    let all = STORAGES.iter().map(of).collect::<Option<Vec<f64>>>()?;
    Some(greatest(all.iter().copied())? / least(all)?)
}

/// Times with skipping over that of dllb, a storage each.
fn over_dllb(scene: &SceneRows<'_>, storages: &[&str]) -> Option<Vec<f64>> {
    let dllb = with(scene, "dllb", SKIPPING)?;
    storages.iter().map(|storage| time_ratio(traced(with(scene, storage, SKIPPING)?)?, traced(dllb)?)).collect()
}

/// Mean time of storages in buckets over that of others, with skipping.
fn bucketed_over_others(scene: &SceneRows<'_>) -> Option<f64> {
    Some(mean(&over_dllb(scene, &["llb", "dllb"])?)? / mean(&over_dllb(scene, &["s-buffer", "ll", "dll"])?)?)
}

/// Time of dllb over that of the fastest other storage, with skipping.
fn dllb_over_fastest_other(scene: &SceneRows<'_>) -> Option<f64> {
    Some(1.0 / least(over_dllb(scene, &["s-buffer", "ll", "dll", "llb"])?)?)
}

/// Pixels with fragments over all pixels.
fn covered_pixels_share(scene: &SceneRows<'_>) -> Option<f64> {
    let run = row(scene, &[])?;
    Some(statistic(run, "covered_pixels")? / statistic(run, "pixels")?)
}
