//! Figure 12: five storages, plain, decoupled, and decoupled with skipping.

use crate::papers::estimate::Estimate;
use crate::papers::quantity::{PERCENT, Quantity, of_scene, timed_of_scene, timed_of_scenes};
use crate::papers::rows::{SceneRows, statistic};
use crate::papers::vvp16::{self, row};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("decoupling_gain", PERCENT, decoupling_gain),
    timed_of_scene("skipping_gain_of_variants", PERCENT, skipping_gain),
    timed_of_scenes("skipping_speedup_evenness", "", skipping_speedup_evenness),
    timed_of_scene("decoupling_build_gain", PERCENT, decoupling_build_gain),
    timed_of_scene("slowest_build_over_fastest", "", slowest_build_over_fastest),
    timed_of_scene("bucketed_over_others", "", bucketed_over_others),
    timed_of_scene("dllb_over_fastest_other", "", dllb_over_fastest_other),
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
pub(in crate::papers::vvp16) const UPDATE_MODES: [(&str, [&str; 2]); 3] =
    [("default", PLAIN), ("decoupled", DECOUPLED), ("empty space skipping", SKIPPING)];

pub(in crate::papers::vvp16) fn with<'a>(
    scene: &SceneRows<'a>,
    storage: &str,
    [decoupled, skipping]: [&str; 2],
) -> Option<&'a Row> {
    row(scene, &[&[("storage", storage), ("decoupled", decoupled)][..], &vvp16::skipping(skipping)].concat())
}

/// How many times as fast the second way is as the first, a storage each.
fn speedups(scene: &SceneRows<'_>, ways: [[&str; 2]; 2]) -> Option<Vec<Estimate>> {
    let of = |storage: &&str| {
        let [from, to] = ways.map(|way| with(scene, storage, way));
        scene.layout_ratio(from?, to?, RAYS)
    };
    STORAGES.iter().map(of).collect()
}

/// By how much data apart makes traces faster, percent, mean over the storages.
fn decoupling_gain(scene: &SceneRows<'_>) -> Option<Estimate> {
    Estimate::mean(speedups(scene, [PLAIN, DECOUPLED])?).map(Estimate::percent_beyond)
}

/// By how much skipping makes traces faster, percent, mean over the storages.
fn skipping_gain(scene: &SceneRows<'_>) -> Option<Estimate> {
    Estimate::mean(speedups(scene, [DECOUPLED, SKIPPING])?).map(Estimate::percent_beyond)
}

/// How evenly the logarithm of the speed-up by skipping grows with the fragments, from scene to scene: the least growth a
/// fragment over the greatest, 1 where the speed-up is exponential, 0 where it never grows.
fn skipping_speedup_evenness(scenes: &[SceneRows<'_>]) -> Option<Estimate> {
    let point = |scene: &SceneRows<'_>| {
        let speedup = Estimate::mean(speedups(scene, [DECOUPLED, SKIPPING])?)?;
        Some((statistic(with(scene, "dllb", SKIPPING)?, "fragments")?, speedup.rising(f64::ln)))
    };
    let mut points: Vec<(f64, Estimate)> = scenes.iter().filter_map(point).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let growth = |pair: &[(f64, Estimate)]| (pair[1].1.clone() - pair[0].1.clone()) / (pair[1].0 - pair[0].0);
    let all = || points.windows(2).map(growth);
    let (slowest, fastest) = (Estimate::least(all())?, Estimate::greatest(all())?);
    let grows = fastest.value > 0.0;
    let evenness = slowest / fastest;
    (points.len() > 2).then_some(if grows { evenness } else { Estimate { value: 0.0, ..evenness } })
}

/// What data apart saves of the build's time, percent, mean over the storages.
fn decoupling_build_gain(scene: &SceneRows<'_>) -> Option<Estimate> {
    let saved = |storage: &&str| {
        let [plain, decoupled] = [PLAIN, DECOUPLED].map(|way| with(scene, storage, way));
        scene.build_ratio(decoupled?, plain?).map(Estimate::percent_below)
    };
    Estimate::mean(STORAGES.iter().map(saved).collect::<Option<Vec<Estimate>>>()?)
}

/// Build of the slowest storage over that of the fastest, decoupled.
fn slowest_build_over_fastest(scene: &SceneRows<'_>) -> Option<Estimate> {
    let builds = STORAGES.iter().map(|storage| with(scene, storage, DECOUPLED)).collect::<Option<Vec<_>>>()?;
    let pairs = builds.iter().flat_map(|one| builds.iter().map(|other| scene.build_ratio(one, other)));
    Estimate::greatest(pairs.collect::<Option<Vec<Estimate>>>()?)
}

/// Times with skipping over that of dllb, a storage each.
fn over_dllb(scene: &SceneRows<'_>, storages: &[&str]) -> Option<Vec<Estimate>> {
    let dllb = with(scene, "dllb", SKIPPING)?;
    storages.iter().map(|storage| scene.layout_ratio(with(scene, storage, SKIPPING)?, dllb, RAYS)).collect()
}

/// Mean time of storages in buckets over that of others, with skipping.
fn bucketed_over_others(scene: &SceneRows<'_>) -> Option<Estimate> {
    let mean = |storages: &[&str]| Estimate::mean(over_dllb(scene, storages)?);
    Some(mean(&["llb", "dllb"])? / mean(&["s-buffer", "ll", "dll"])?)
}

/// Time of dllb over that of the fastest other storage, with skipping.
fn dllb_over_fastest_other(scene: &SceneRows<'_>) -> Option<Estimate> {
    Some(Estimate::from(1.0) / Estimate::least(over_dllb(scene, &["s-buffer", "ll", "dll", "llb"])?)?)
}

/// Pixels with fragments over all pixels.
fn covered_pixels_share(scene: &SceneRows<'_>) -> Option<f64> {
    let row = row(scene, &[])?;
    Some(statistic(row, "covered_pixels")? / statistic(row, "pixels")?)
}
