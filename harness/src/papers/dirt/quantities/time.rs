//! Times, always as ratios within one run.

use super::memory::{over_buckets, pairs};
use crate::papers::dirt::PAPER;
use crate::papers::quantity::{PERCENT, Quantity, greatest, least, mean, of_scene};
use crate::papers::rows::{SceneRows, agreement, has, statistic, trace, trace_ratio};
use crate::results::TracerRun;
use crate::results::host_ms;
use crate::results::time_ratio;

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("greatest_step_to_less_coherent", "", greatest_step_to_less_coherent),
    of_scene("visibility_over_fastest_other", "", visibility_over_fastest_other),
    of_scene("conservative_over_standard_trace", "", conservative_over_standard_trace),
    of_scene("build_growth_per_8_buckets", PERCENT, build_growth_per_8_buckets),
    of_scene("greatest_trace_ratio_of_8_buckets", "", greatest_trace_ratio_of_8_buckets),
    of_scene("coarse_tile_trace_ratio_where_low", "", coarse_tile_trace_ratio_where_low),
    of_scene("coarse_tile_gain_over_resolution_where_fine", "", coarse_tile_gain_over_resolution_where_fine),
    of_scene("trace_at_8_over_24_to_40", "", trace_at_8_over_24_to_40),
    of_scene("good_setting_over_best", "", good_setting_over_best),
    of_scene("second_event_over_first_closed", "", second_event_over_first_closed),
    of_scene("second_event_over_first_open", "", second_event_over_first_open),
    of_scene("least_bvh_build_over_dirt", "", least_bvh_build_over_dirt),
    of_scene("diffuse_slope_over_bvh", "", diffuse_slope_over_bvh),
    of_scene("total_gain_last_over_first", "", total_gain_last_over_first),
    of_scene("least_diffuse_time_over_bvh", "", least_diffuse_time_over_bvh),
    of_scene("one_view_time_over_six", "", one_view_time_over_six),
];

/// The hierarchy built on the device, in place of HLBVH and TRBVH.
const BVH: &str = "lbvh-gpu";
/// Triangles in an occupied tile of one pixel, on the mean, up to which tessellation counts as low or medium.
const MEDIUM_TESSELLATION: f64 = 4.0;
/// Part of a ray set's rays that may leave a closed scene: through cracks and by rounding.
const CLOSED: f64 = 0.01;

/// Rays a second of one set over those of another, in one row.
fn throughput_ratio(run: &TracerRun, one: &str, other: &str) -> Option<f64> {
    let [one, other] = [one, other].map(|rays| trace(run, rays));
    let (one, other) = (one?, other?);
    Some(one.count as f64 / other.count as f64 / time_ratio(&one.times, &other.times)?)
}

/// The greatest ratio of throughput to that of the next more coherent kind, of specular, glossy, diffuse, over DIRT's rows.
fn greatest_step_to_less_coherent(scene: &SceneRows<'_>) -> Option<f64> {
    let mut steps = Vec::new();
    for run in scene.of_tracer("dirt") {
        steps.push(throughput_ratio(run, "glossy", "specular")?);
        steps.push(throughput_ratio(run, "diffuse", "glossy")?);
    }
    greatest(steps)
}

/// Throughput of visibility rays over that of the fastest other kind, the least over DIRT's rows.
fn visibility_over_fastest_other(scene: &SceneRows<'_>) -> Option<f64> {
    let mut ratios = Vec::new();
    for run in scene.of_tracer("dirt") {
        for other in ["specular", "glossy", "diffuse"] {
            ratios.push(throughput_ratio(run, "visibility", other)?);
        }
    }
    least(ratios)
}

/// Time of diffuse rays with conservative coverage over that with coverage by sample, tiles of one pixel, the same B.
fn conservative_over_standard_trace(scene: &SceneRows<'_>) -> Option<f64> {
    let row = |coverage: &str| scene.find("dirt", &[("tile_size", "1"), ("coverage", coverage)]);
    let (conservative, standard) = (row("conservative")?, row("standard")?);
    let same = conservative.tracer.parameters.get("buckets") == standard.tracer.parameters.get("buckets");
    trace_ratio(conservative, standard, "diffuse").filter(|_| same)
}

/// Growth of the build by a step of eight buckets, percent, mean over steps and tile sizes.
fn build_growth_per_8_buckets(scene: &SceneRows<'_>) -> Option<f64> {
    let mut growth = Vec::new();
    for tile_size in ["1", "2", "4"] {
        for pair in steps_of_8(&over_buckets(scene, tile_size)) {
            growth.push(100.0 * (time_ratio(&pair[1].build.times, &pair[0].build.times)? - 1.0));
        }
    }
    mean(&growth)
}

/// Neighbours that are eight buckets apart.
fn steps_of_8<'a>(runs: &[(u64, &'a TracerRun)]) -> Vec<[&'a TracerRun; 2]> {
    runs.windows(2).filter(|pair| pair[1].0 == pair[0].0 + 8).map(|pair| [pair[0].1, pair[1].1]).collect()
}

/// The greatest ratio of the time of diffuse rays to that with eight buckets fewer, over tile sizes.
fn greatest_trace_ratio_of_8_buckets(scene: &SceneRows<'_>) -> Option<f64> {
    let mut ratios = Vec::new();
    for tile_size in ["1", "2", "4"] {
        for [fewer, more] in steps_of_8(&over_buckets(scene, tile_size)) {
            ratios.push(trace_ratio(more, fewer, "diffuse")?);
        }
    }
    greatest(ratios)
}

/// Time of diffuse rays with tiles of 4x4 over that with tiles of one pixel at B = 24; of scenes alone whose tiles of one pixel
/// hold few triangles.
fn coarse_tile_trace_ratio_where_low(scene: &SceneRows<'_>) -> Option<f64> {
    let all = pairs(scene, ["1", "4"]);
    let [fine, coarse] = all.into_iter().find(|(buckets, _)| *buckets == 24)?.1;
    (triangles_a_tile(fine)? <= MEDIUM_TESSELLATION).then(|| trace_ratio(coarse, fine, "diffuse"))?
}

/// Triangles in an occupied tile, on the mean.
fn triangles_a_tile(run: &TracerRun) -> Option<f64> {
    Some(statistic(run, "parts")? / statistic(run, "occupied_tiles")?)
}

/// By how many times tiles of 4x4 are as fast as tiles of one pixel, at the highest resolution over the lowest; of scenes alone
/// whose tiles of one pixel hold many triangles at the highest.
fn coarse_tile_gain_over_resolution_where_fine(scene: &SceneRows<'_>) -> Option<f64> {
    fn at<'a>(scene: &SceneRows<'a>) -> Option<(&'a TracerRun, f64)> {
        let row = |tile_size| {
            let published = [("tile_size", tile_size), ("coverage", "conservative"), ("searched", "until_hit")];
            scene.find("dirt", &published)
        };
        let (fine, coarse) = (row("1")?, row("4")?);
        Some((fine, trace_ratio(fine, coarse, "diffuse")?))
    }
    let all: Vec<_> = scene.by_resolution().iter().filter_map(at).collect();
    let (lowest, highest) = (all.first()?, all.last()?);
    let wanted = all.len() > 1 && triangles_a_tile(highest.0)? > MEDIUM_TESSELLATION;
    wanted.then(|| highest.1 / lowest.1)
}

/// Time of diffuse rays at B = 8 over the mean of B = 24 to 40, tiles of 2x2.
fn trace_at_8_over_24_to_40(scene: &SceneRows<'_>) -> Option<f64> {
    let runs = over_buckets(scene, "2");
    let few = runs.iter().find(|(buckets, _)| *buckets == 8)?.1;
    let many = runs.iter().filter(|(buckets, _)| (24..=40).contains(buckets));
    let shares: Option<Vec<f64>> = many.map(|(_, run)| trace_ratio(run, few, "diffuse")).collect();
    Some(1.0 / mean(&shares?)?)
}

/// Build and a trace of diffuse rays of the best setting with tiles of 2x2 and B of 20 to 40, over that of the best setting of
/// all that use no more bytes.
fn good_setting_over_best(scene: &SceneRows<'_>) -> Option<f64> {
    let total = |run: &TracerRun| Some(host_ms(&run.build.times)? + host_ms(&trace(run, "diffuse")?.times)?);
    let good = over_buckets(scene, "2").into_iter().filter(|(buckets, _)| (20..=40).contains(buckets));
    let good: Vec<(f64, &TracerRun)> = good.filter_map(|(_, run)| Some((total(run)?, run))).collect();
    let (own, run) = good.into_iter().reduce(|a, b| if b.0 < a.0 { b } else { a })?;
    let rivals = scene.of_tracer("dirt").filter(|other| PAPER.bytes(other) <= PAPER.bytes(run));
    Some(own / least(rivals.filter_map(total))?)
}

/// Time of the second event over the first, where the scene is closed or open: whether nearly all diffuse rays hit.
fn second_event_over_first(scene: &SceneRows<'_>, closed: bool) -> Option<f64> {
    let mut ratios = Vec::new();
    for run in scene.of_tracer("dirt").filter(|run| has(run, "searched", "until_hit") && has(run, "tile_size", "2")) {
        let (first, second) = (trace(run, "diffuse")?, trace(run, "bounce2")?);
        let stay = second.count as f64 / first.count as f64;
        if (stay >= 1.0 - CLOSED) != closed {
            return None;
        }
        ratios.push(time_ratio(&second.times, &first.times)?);
    }
    mean(&ratios)
}

fn second_event_over_first_closed(scene: &SceneRows<'_>) -> Option<f64> {
    second_event_over_first(scene, true)
}

fn second_event_over_first_open(scene: &SceneRows<'_>) -> Option<f64> {
    second_event_over_first(scene, false)
}

/// DIRT and the hierarchy at every resolution, from the lowest.
fn beside_bvh<'a>(scene: &SceneRows<'a>) -> Vec<[&'a TracerRun; 2]> {
    let at = |scene: SceneRows<'a>| Some([scene.find("dirt", &[])?, scene.find(BVH, &[])?]);
    scene.by_resolution().into_iter().filter_map(at).collect()
}

/// Build of the hierarchy over that of DIRT, the least over the resolutions.
fn least_bvh_build_over_dirt(scene: &SceneRows<'_>) -> Option<f64> {
    let all = beside_bvh(scene).into_iter();
    least(all.filter_map(|[dirt, bvh]| Some(host_ms(&bvh.build.times)? / host_ms(&dirt.build.times)?)))
}

/// Time of diffuse rays over the hierarchy's, the least over the resolutions.
fn least_diffuse_time_over_bvh(scene: &SceneRows<'_>) -> Option<f64> {
    let diffuse = |run: &TracerRun| host_ms(&trace(run, "diffuse")?.times);
    least(beside_bvh(scene).into_iter().filter_map(|[dirt, bvh]| Some(diffuse(dirt)? / diffuse(bvh)?)))
}

/// Time that a diffuse ray more takes from the lowest to the highest resolution, over the hierarchy's.
fn diffuse_slope_over_bvh(scene: &SceneRows<'_>) -> Option<f64> {
    let all = beside_bvh(scene);
    let (first, last) = (all.first()?, all.last()?);
    let slope = |index: usize| {
        let ends = [first, last].map(|pair| trace(pair[index], "diffuse"));
        let (low, high) = (ends[0]?, ends[1]?);
        let rays = high.count as f64 - low.count as f64;
        (rays > 0.0).then(|| Some((host_ms(&high.times)? - host_ms(&low.times)?) / rays))?
    };
    Some(slope(0)? / slope(1)?)
}

/// Ray sets of a mix, with how often each is traced.
pub(crate) type Mix = &'static [(&'static str, f64)];

/// One primary, one secondary, two shadow rays.
const FULL_MIX: Mix = &[("primary", 1.0), ("diffuse", 1.0), ("visibility", 2.0)];

/// The mixes of DIRT's Figure 8 by name, from left to right.
pub(crate) const MIXES: [(&str, Mix); 3] = [
    ("primary, shadow", &[("primary", 1.0), ("visibility", 1.0)]),
    ("primary, secondary", &[("primary", 1.0), ("diffuse", 1.0)]),
    ("primary, secondary, 2 shadow", FULL_MIX),
];

/// Build and traces of a mix, ms by the host's clock; none where one of them could not be judged.
pub(in crate::papers::dirt) fn total_ms(run: &TracerRun, mix: &[(&str, f64)]) -> Option<f64> {
    let judged = |rays: &str| trace(run, rays).filter(|trace| agreement(trace).is_some());
    let times = mix.iter().map(|(rays, often)| Some(often * host_ms(&judged(rays)?.times)?));
    Some(host_ms(&run.build.times)? + times.sum::<Option<f64>>()?)
}

/// What the hierarchy takes for build and traces over what DIRT takes, at the highest resolution over the lowest.
fn total_gain_last_over_first(scene: &SceneRows<'_>) -> Option<f64> {
    let all = beside_bvh(scene);
    let gain = |pair: &[&TracerRun; 2]| Some(total_ms(pair[1], FULL_MIX)? / total_ms(pair[0], FULL_MIX)?);
    let several = all.len() > 1;
    Some(gain(all.last()?)? / gain(all.first()?)?).filter(|_| several)
}

/// Build and traces of all sets with one view over those with six.
fn one_view_time_over_six(scene: &SceneRows<'_>) -> Option<f64> {
    let total = |views: &str| {
        let run = scene.find("dirt", &[("views", views)])?;
        let mix: Vec<(&str, f64)> = run.traces.iter().map(|trace| (trace.rays.as_str(), 1.0)).collect();
        total_ms(run, &mix)
    };
    Some(total("frame")? / total("six")?)
}
