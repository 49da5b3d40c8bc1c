//! Times, always as ratios within one run.

use super::accuracy::as_published;
use super::memory::{over_buckets, pairs};
use crate::papers::Scope;
use crate::papers::dirt::{DIRT, PAPER};
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{PERCENT, Quantity, timed_of_scene};
use crate::papers::rows::{SceneRows, agreement, statistic, trace};
use crate::papers::times::{ratio, traced};
use crate::results::host_ms;
use crate::results::{Row, Timed};

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("max_step_to_less_coherent", "", max_step_to_less_coherent),
    timed_of_scene("visibility_over_fastest_other", "", visibility_over_fastest_other),
    timed_of_scene("conservative_over_standard_trace", "", conservative_over_standard_trace),
    timed_of_scene("build_growth_per_8_buckets", PERCENT, build_growth_per_8_buckets),
    timed_of_scene("max_trace_ratio_of_8_buckets", "", max_trace_ratio_of_8_buckets),
    timed_of_scene("coarse_tile_trace_ratio_where_low", "", coarse_tile_trace_ratio_where_low),
    timed_of_scene("coarse_tile_gain_over_resolution_where_fine", "", coarse_tile_gain_over_resolution_where_fine),
    timed_of_scene("trace_at_8_over_24_to_40", "", trace_at_8_over_24_to_40),
    timed_of_scene("good_setting_over_best", "", good_setting_over_best),
    timed_of_scene("second_event_over_first_closed", "", |scene| second_event_over_first(scene, true)),
    timed_of_scene("second_event_over_first_open", "", |scene| second_event_over_first(scene, false)),
    timed_of_scene("min_bvh_build_over_dirt", "", min_bvh_build_over_dirt),
    timed_of_scene("diffuse_slope_over_bvh", "", diffuse_slope_over_bvh),
    timed_of_scene("total_gain_last_over_first", "", total_gain_last_over_first),
    timed_of_scene("min_diffuse_time_over_bvh", "", min_diffuse_time_over_bvh),
    timed_of_scene("one_view_time_over_six", "", one_view_time_over_six),
    timed_of_scene("shadow_map_time_over_visibility", "", shadow_map_time_over_visibility),
    timed_of_scene("direct_visibility_over_diffuse", "", direct_visibility_over_diffuse),
    timed_of_scene("without_pyramid_over_with", "", without_pyramid_over_with),
    timed_of_scene("fetch_over_first_row", "", fetch_over_first_row),
    timed_of_scene("fetch_of_few_over_many", "", fetch_of_few_over_many),
];

/// The hierarchy built on the device, in place of HLBVH and TRBVH.
const BVH: &str = "ploc-gpu";
/// Triangles in an occupied tile of one pixel, on the mean, up to which tessellation counts as low or medium.
const MEDIUM_TESSELLATION: f64 = 4.0;
/// Part of a ray set's rays that may leave a closed scene: through cracks and by rounding.
const CLOSED: f64 = 0.01;

/// Rays a second of one set over those of another, in one row.
fn throughput_ratio(scene: &SceneRows<'_>, row: &Row, one: &str, other: &str) -> Option<Estimate> {
    let rays = |set: &str| Some(trace(row, set)?.count as f64);
    Some(scene.set_ratio(row, other, one)? * (rays(one)? / rays(other)?))
}

/// The greatest ratio of throughput to that of the next more coherent kind, of specular, glossy, diffuse, over DIRT's rows.
fn max_step_to_less_coherent(scene: &SceneRows<'_>) -> Option<Estimate> {
    let mut steps = Vec::new();
    for row in scene.of_tracer("dirt") {
        steps.push(throughput_ratio(scene, row, "glossy", "specular")?);
        steps.push(throughput_ratio(scene, row, "diffuse", "glossy")?);
    }
    Estimate::greatest(steps)
}

/// Throughput of visibility rays over that of the fastest other kind, the least over DIRT's rows.
fn visibility_over_fastest_other(scene: &SceneRows<'_>) -> Option<Estimate> {
    let mut ratios = Vec::new();
    for row in scene.of_tracer("dirt") {
        for other in ["specular", "glossy", "diffuse"] {
            ratios.push(throughput_ratio(scene, row, "visibility", other)?);
        }
    }
    Estimate::least(ratios)
}

/// Time of diffuse rays with conservative coverage over that with coverage by sample, tiles of one pixel, the same B.
fn conservative_over_standard_trace(scene: &SceneRows<'_>) -> Option<Estimate> {
    let row = |coverage: &str| scene.find("dirt", &[("tile_size", "1"), ("coverage", coverage)]);
    let (conservative, standard) = (row("conservative")?, row("standard")?);
    let same = conservative.tracer.parameters.get("buckets") == standard.tracer.parameters.get("buckets");
    scene.trace_ratio(conservative, standard, "diffuse").filter(|_| same)
}

/// Growth of the build by a step of eight buckets, percent, mean over steps and tile sizes.
fn build_growth_per_8_buckets(scene: &SceneRows<'_>) -> Option<Estimate> {
    let mut growth = Vec::new();
    for tile_size in ["1", "2", "4"] {
        for pair in steps_of_8(&over_buckets(scene, tile_size)) {
            growth.push(scene.build_ratio(pair[1], pair[0])?.percent_beyond());
        }
    }
    Estimate::mean(growth)
}

/// Neighbours that are eight buckets apart.
fn steps_of_8<'a>(rows: &[(u64, &'a Row)]) -> Vec<[&'a Row; 2]> {
    rows.windows(2).filter(|pair| pair[1].0 == pair[0].0 + 8).map(|pair| [pair[0].1, pair[1].1]).collect()
}

/// The greatest ratio of the time of diffuse rays to that with eight buckets fewer, over tile sizes.
fn max_trace_ratio_of_8_buckets(scene: &SceneRows<'_>) -> Option<Estimate> {
    let mut ratios = Vec::new();
    for tile_size in ["1", "2", "4"] {
        for [fewer, more] in steps_of_8(&over_buckets(scene, tile_size)) {
            ratios.push(scene.trace_ratio(more, fewer, "diffuse")?);
        }
    }
    Estimate::greatest(ratios)
}

/// Time of diffuse rays with tiles of 4x4 over that with tiles of one pixel at B = 24; of scenes alone whose tiles of one pixel
/// hold few triangles.
fn coarse_tile_trace_ratio_where_low(scene: &SceneRows<'_>) -> Option<Estimate> {
    let all = pairs(scene, ["1", "4"]);
    let [fine, coarse] = all.into_iter().find(|(buckets, _)| *buckets == 24)?.1;
    (triangles_a_tile(fine)? <= MEDIUM_TESSELLATION).then(|| scene.trace_ratio(coarse, fine, "diffuse"))?
}

/// Triangles in an occupied tile, on the mean.
fn triangles_a_tile(row: &Row) -> Option<f64> {
    Some(statistic(row, "parts")? / statistic(row, "occupied_tiles")?)
}

/// By how many times tiles of 4x4 are as fast as tiles of one pixel, at the highest resolution over the lowest; of scenes alone
/// whose tiles of one pixel hold many triangles at the highest.
fn coarse_tile_gain_over_resolution_where_fine(scene: &SceneRows<'_>) -> Option<Estimate> {
    fn at<'a>(scene: &SceneRows<'a>) -> Option<(&'a Row, Estimate)> {
        let row = |tile_size| {
            let published = [("tile_size", tile_size), ("coverage", "conservative"), ("searched", "until_hit")];
            scene.find("dirt", &published)
        };
        let (fine, coarse) = (row("1")?, row("4")?);
        Some((fine, scene.trace_ratio(fine, coarse, "diffuse")?))
    }
    let all: Vec<_> = scene.by_resolution().iter().filter_map(at).collect();
    let (lowest, highest) = (all.first()?, all.last()?);
    let wanted = all.len() > 1 && triangles_a_tile(highest.0)? > MEDIUM_TESSELLATION;
    wanted.then(|| highest.1.clone() / lowest.1.clone())
}

/// Time of diffuse rays at B = 8 over the mean of B = 24 to 40, tiles of 2x2.
fn trace_at_8_over_24_to_40(scene: &SceneRows<'_>) -> Option<Estimate> {
    let rows = over_buckets(scene, "2");
    let few = rows.iter().find(|(buckets, _)| *buckets == 8)?.1;
    let many = rows.iter().filter(|(buckets, _)| (24..=40).contains(buckets));
    let shares: Option<Vec<Estimate>> = many.map(|(_, row)| scene.trace_ratio(row, few, "diffuse")).collect();
    Some(Estimate::from(1.0) / Estimate::mean(shares?)?)
}

/// Build and a trace of diffuse rays of the best setting with tiles of 2x2 and B of 20 to 40, over that of the best setting of
/// all that use no more bytes.
fn good_setting_over_best(scene: &SceneRows<'_>) -> Option<Estimate> {
    const MIX: RayMix = &[("diffuse", 1.0)];
    let good = over_buckets(scene, "2").into_iter().filter(|(buckets, _)| (20..=40).contains(buckets));
    let good: Vec<(f64, &Row)> = good.filter_map(|(_, row)| Some((total_ms(row, MIX)?, row))).collect();
    let (_, row) = good.into_iter().reduce(|a, b| if b.0 < a.0 { b } else { a })?;
    let bytes = |row: &Row| PAPER.bytes(row, Scope::OfPaper);
    let rivals = scene.of_tracer("dirt").filter(|other| bytes(other) <= bytes(row));
    Estimate::greatest(rivals.filter_map(|rival| scene.total_ratio(row, rival, MIX)))
}

/// Time of the second event over the first, where the scene is closed or open: whether nearly all diffuse rays hit.
fn second_event_over_first(scene: &SceneRows<'_>, closed: bool) -> Option<Estimate> {
    let row = scene.find("dirt", &as_published(&[("tile_size", "2")]))?;
    let (first, second) = (trace(row, "diffuse")?, trace(row, "bounce2")?);
    let stay = second.count as f64 / first.count as f64;
    ((stay >= 1.0 - CLOSED) == closed).then(|| scene.set_ratio(row, "bounce2", "diffuse"))?
}

/// DIRT and the hierarchy, by the tree that takes least, at every resolution, from the lowest.
fn beside_bvh<'a>(scene: &SceneRows<'a>, took_ms: impl Fn(&Row) -> Option<f64>) -> Vec<[&'a Row; 2]> {
    let at = |scene: SceneRows<'a>| {
        let trees = scene.differing_in(BVH, &["tree"]).filter_map(|row| Some((took_ms(row)?, row)));
        let (_, bvh) = trees.min_by(|(one, _), (other, _)| one.total_cmp(other))?;
        Some([scene.find("dirt", &[])?, bvh])
    };
    scene.by_resolution().into_iter().filter_map(at).collect()
}

/// Build of the hierarchy over that of DIRT, the least over the resolutions.
fn min_bvh_build_over_dirt(scene: &SceneRows<'_>) -> Option<Estimate> {
    let all = beside_bvh(scene, |row| host_ms(row.build.steady()));
    Estimate::least(all.into_iter().filter_map(|[dirt, bvh]| scene.build_ratio(bvh, dirt)))
}

fn diffuse_ms(row: &Row) -> Option<f64> {
    host_ms(&trace(row, "diffuse")?.times)
}

/// Time of diffuse rays over the hierarchy's, the least over the resolutions.
fn min_diffuse_time_over_bvh(scene: &SceneRows<'_>) -> Option<Estimate> {
    let all = beside_bvh(scene, diffuse_ms);
    Estimate::least(all.into_iter().filter_map(|[dirt, bvh]| scene.trace_ratio(dirt, bvh, "diffuse")))
}

/// Time that a diffuse ray more takes from the lowest to the highest resolution, over the hierarchy's.
fn diffuse_slope_over_bvh(scene: &SceneRows<'_>) -> Option<Estimate> {
    let all = beside_bvh(scene, diffuse_ms);
    let (first, last) = (all.first()?, all.last()?);
    // The rays that are added are the same for both. All in parts of the hierarchy's highest.
    let rays = |pair: &[&Row; 2]| Some(trace(pair[0], "diffuse")?.count);
    let part = |row: &Row| ratio(scene.record, &traced(row, "diffuse")?, &traced(last[1], "diffuse")?);
    let slope = (part(last[0])? - part(first[0])?) / (Estimate::from(1.0) - part(first[1])?);
    (rays(last)? > rays(first)?).then_some(slope)
}

/// Ray sets of a mix, with how often each is traced.
pub(crate) type RayMix = &'static [(&'static str, f64)];

/// One primary, one secondary, two shadow rays.
const FULL_MIX: RayMix = &[("primary", 1.0), ("diffuse", 1.0), ("visibility", 2.0)];

/// The mixes of DIRT's Figure 8 by name, from left to right.
pub(crate) const MIXES: [(&str, RayMix); 3] = [
    ("primary, shadow", &[("primary", 1.0), ("visibility", 1.0)]),
    ("primary, secondary", &[("primary", 1.0), ("diffuse", 1.0)]),
    ("primary, secondary, 2 shadow", FULL_MIX),
];

/// Build and traces of a mix, ms by the host's clock; none where one of them could not be judged.
pub(in crate::papers::dirt) fn total_ms(row: &Row, mix: &[(&str, f64)]) -> Option<f64> {
    let judged = |rays: &str| trace(row, rays).filter(|trace| agreement(trace).is_some());
    let times = mix.iter().map(|(rays, often)| Some(often * host_ms(&judged(rays)?.times)?));
    Some(host_ms(row.build.steady())? + times.sum::<Option<f64>>()?)
}

/// What the hierarchy takes for build and traces over what DIRT takes, at the highest resolution over the lowest.
fn total_gain_last_over_first(scene: &SceneRows<'_>) -> Option<Estimate> {
    let all = beside_bvh(scene, |row| total_ms(row, FULL_MIX));
    let gain = |pair: &[&Row; 2]| scene.total_ratio(pair[1], pair[0], FULL_MIX);
    let several = all.len() > 1;
    several.then(|| Some(gain(all.last()?)? / gain(all.first()?)?))?
}

/// Build and traces of all sets with one view over those with six.
fn one_view_time_over_six(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [one, six] = ["frame", "six"].map(|views| scene.find("dirt", &[("views", views), ("shadow_map", "off")]));
    let (one, six) = (one?, six?);
    let mix: Vec<(&str, f64)> = six.traces.iter().map(|trace| (trace.rays.as_str(), 1.0)).collect();
    scene.total_ratio(one, six, &mix)
}

/// Time of visibility rays that a shadow map answers over that of those traced in the same view.
fn shadow_map_time_over_visibility(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [map, traced] = ["on", "off"].map(|map| scene.find("dirt", &[("views", "frame"), ("shadow_map", map)]));
    scene.trace_ratio(map?, traced?, "visibility")
}

/// Time of the build's phase direct visibility over that of diffuse rays.
fn direct_visibility_over_diffuse(scene: &SceneRows<'_>) -> Option<Estimate> {
    let row = scene.find("dirt", &as_published(&[("tile_size", "2"), ("direct_visibility", "on")]))?;
    ratio(scene.record, &Timed::build_phase(row, "direct visibility"), &traced(row, "diffuse")?)
}

/// Time of diffuse rays' phase fetch over that of the first row, of all rows that which lies farthest from 1.
fn fetch_over_first_row(scene: &SceneRows<'_>) -> Option<Estimate> {
    let fetch = |row| Some(traced(row, "diffuse")?.phase("fetch"));
    let first = fetch(scene.of_tracer("dirt").next()?)?;
    let all = scene.of_tracer("dirt").skip(1).map(|row| ratio(scene.record, &fetch(row)?, &first));
    let all = all.collect::<Option<Vec<Estimate>>>()?;
    let [least, greatest] = [Estimate::least(all.clone())?, Estimate::greatest(all)?];
    Some(if least.value * greatest.value < 1.0 { least } else { greatest })
}

/// Time of the phases mask and fetch of mirror rays over those of diffuse rays, where these are at least twice as many; conservative
/// coverage, tiles of one pixel.
fn fetch_of_few_over_many(scene: &SceneRows<'_>) -> Option<Estimate> {
    let row = scene.find("dirt", &as_published(&[("tile_size", "1")]))?;
    let fetched = |rays: &str| Some(traced(row, rays)?.phase("mask").and(traced(row, rays)?.phase("fetch")));
    let few = trace(row, "specular")?.count * 2 <= trace(row, "diffuse")?.count;
    few.then(|| ratio(scene.record, &fetched("specular")?, &fetched("diffuse")?))?
}

/// Time of diffuse rays from tile to tile over that by the pyramid, tiles of 2x2.
fn without_pyramid_over_with(scene: &SceneRows<'_>) -> Option<Estimate> {
    let row = |march: &str| scene.find(DIRT, &as_published(&[("tile_size", "2"), ("march", march)]));
    scene.trace_ratio(row("tiles")?, row("hi-z")?, "diffuse")
}
