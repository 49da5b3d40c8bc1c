//! What the text states: layers, traversal, normals, cracks, displacement.

use super::{HIDDEN_LAYER, LEFT_OUT, SAMPLES, missed, share_asking_second};
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{
    IN_A_MILLION, PERCENT, Quantity, least, of_named_scene, of_scene, timed_of_scene, timed_of_scenes,
};
use crate::papers::rows::{MILLION, SceneRows, answered_as_first, footprint, has, of_cause, per_ray, trace};
use crate::papers::times::{rank_correlation, ratio, traced};
use crate::papers::wkp15::{DDA, FIELD, QUADTREE, experiments, row};
use crate::results::{Judgement, Row, Timed, TraceRecord};
use crate::statistics::wilson;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("traversal_without_stack_saves", PERCENT, without_stack_saves),
    of_scene("answered_as_through_all_layers", "", answered_as_through_all_layers),
    of_scene("rays_given_up", IN_A_MILLION, rays_given_up),
    of_scene("dda_hit_miss_change", "", dda_hit_miss_change),
    of_scene("height_field_early_share", "", height_field_early_share),
    timed_of_scene("all_layers_time_over_cascade", "", all_layers_time_over_cascade),
    timed_of_scene("four_layers_time_over_three", "", four_layers_over_three),
    timed_of_scene("build_of_four_layers_over_eyes", "", build_of_four_layers_over_eyes),
    of_named_scene("recovered_by_second_layer", "", recovered_by_second_layer),
    of_scene("geometry_normals_agreement_change", "", geometry_normals_agreement_change),
    of_scene("lossless_error_in_tolerances", "", lossless_error_in_tolerances),
    timed_of_scene("undilated_false_misses_beyond", IN_A_MILLION, |scene| {
        undilated_false_misses_beyond(scene, "continuous")
    }),
    timed_of_scene("undilated_false_misses_beyond_flagged", IN_A_MILLION, |scene| {
        undilated_false_misses_beyond(scene, "flagged")
    }),
    timed_of_scene("dda_time_exponent_over_samples", "", dda_time_exponent),
    timed_of_scene("displaced_time_over_near", "", displaced_over_near),
    timed_of_scenes("rank_of_time_by_second_layer", "", rank_of_time_by_second_layer),
];

/// A ray is traced through all layers, whatever the first leaves open.
const EVERY_LAYER: (&str, &str) = ("next_layer", "always");
/// Statuses of rays that were left before they were answered.
const GIVEN_UP: [&str; 2] = ["step_cap", "unwritten"];
/// Part of t that counts as exact, that of `tight`.
const TIGHT: f64 = 1e-4;

/// The first part: rays near the view that the trees are of.
fn near<'a>(scene: &SceneRows<'a>) -> SceneRows<'a> {
    scene.of_rays(experiments::NEAR)
}

/// Both ray sets.
const SETS: [&str; 2] = ["stereo", "temporal"];

/// Something of both ray sets, the mean.
fn of_both_sets(of: impl Fn(&str) -> Option<Estimate>) -> Option<Estimate> {
    Estimate::mean(SETS.iter().map(|rays| of(rays)).collect::<Option<Vec<_>>>()?)
}

/// By how much less time rays take without a stack than with one, percent.
fn without_stack_saves(scene: &SceneRows<'_>) -> Option<Estimate> {
    let scene = near(scene);
    let [bits, stack] = ["xor", "stack"].map(|traversal| row(&scene, &[("traversal", traversal)]));
    let (bits, stack) = (bits?, stack?);
    of_both_sets(|rays| scene.layout_ratio(bits, stack, rays)).map(Estimate::percent_below)
}

/// The share of rays that have the same answer where every layer is asked, of the ray set with the least.
fn answered_as_through_all_layers(scene: &SceneRows<'_>) -> Option<f64> {
    answered_as_first(row(&near(scene), &[EVERY_LAYER])?)
}

/// Rays in a million that a walk through the trees did not end, of every row.
fn rays_given_up(scene: &SceneRows<'_>) -> Option<f64> {
    let traces: Vec<&TraceRecord> = scene.of_tracer(QUADTREE).flat_map(|row| &row.traces).collect();
    let rays: u64 = traces.iter().map(|trace| trace.count).sum();
    let of_status =
        |trace: &&TraceRecord| GIVEN_UP.iter().filter_map(|status| trace.statuses.get(*status)).sum::<u64>();
    let given_up: u64 = traces.iter().map(of_status).sum();
    (rays > 0).then(|| MILLION * given_up as f64 / rays as f64)
}

/// By how much more rays DDA finds rightly to hit or miss than one layer of the trees, of all ray sets the farthest from nothing.
fn dda_hit_miss_change(scene: &SceneRows<'_>) -> Option<f64> {
    let scene = near(scene);
    let (own, peer) = (row(&scene, &[("layers", "1")])?, scene.like_first(DDA, &[])?);
    let hit_miss = |trace: &TraceRecord| match &trace.judgement {
        Judgement::Closest(closest) => closest.agreement.hit_miss,
        Judgement::Any(_) => None,
    };
    let changes = own.traces.iter().filter_map(|own| Some(hit_miss(trace(peer, &own.rays)?)? - hit_miss(own)?));
    changes.max_by(|one, other| one.abs().total_cmp(&other.abs()))
}

/// Of temporal rays that the height field answers by a surface in front of the true one or behind it, the share in front, where the camera
/// has moved farthest.
fn height_field_early_share(scene: &SceneRows<'_>) -> Option<f64> {
    let field = scene.of_rays(experiments::FARTHEST).like_first(FIELD, &[])?;
    let Judgement::Closest(closest) = &trace(field, "temporal")?.judgement else { return None };
    let classes = &closest.classes.footprint;
    let wrong = classes.early + classes.late;
    (wrong > 0).then(|| classes.early as f64 / wrong as f64)
}

/// Time through every layer over that where the first tells whether to go on, two layers.
fn all_layers_time_over_cascade(scene: &SceneRows<'_>) -> Option<Estimate> {
    let scene = near(scene);
    let (cascade, all) = (row(&scene, &[])?, row(&scene, &[EVERY_LAYER])?);
    of_both_sets(|rays| scene.trace_ratio(all, cascade, rays))
}

/// Time in four layers over that in three.
fn four_layers_over_three(scene: &SceneRows<'_>) -> Option<Estimate> {
    let scene = near(scene);
    let [three, four] = ["3", "4"].map(|layers| row(&scene, &[("layers", layers)]));
    of_both_sets(|rays| scene.trace_ratio(four?, three?, rays))
}

/// Time of drawing and building four layers over that of the rays of both eyes.
fn build_of_four_layers_over_eyes(scene: &SceneRows<'_>) -> Option<Estimate> {
    let row = row(&near(scene), &[("layers", "4")])?;
    ratio(scene.record, &Timed::steady_build(row), &traced(row, "stereo")?.times(2.0))
}

/// Of temporal rays that are wrong in one layer since it does not hold what they hit, though the view shows it, the share that a second
/// holds, where the camera has moved farthest; nothing is inpainted. Of all second layers the best, by its separation and back faces.
fn recovered_by_second_layer(scene: &SceneRows<'_>) -> Option<(String, f64)> {
    let scene = scene.of_rays(experiments::FARTHEST);
    let lost = |row: &Row| {
        let trace = trace(row, "temporal")?;
        let of = |cause: &&str| of_cause(trace, "footprint", cause).map(|[_, rays]| rays as f64);
        [HIDDEN_LAYER, LEFT_OUT, "behind_last_layer"].iter().map(of).sum::<Option<f64>>()
    };
    let one = lost(row(&scene, &[("layers", "1"), ("inpainting", "never")])?).filter(|lost| *lost > 0.0)?;
    let of = |row: &&Row| has(row, "layers", "2");
    let two = scene.of_tracer(QUADTREE).filter(of).filter_map(|row| Some((row.label(), (one - lost(row)?) / one)));
    two.max_by(|(_, one), (_, other)| one.total_cmp(other))
}

/// Footprint agreement with normals of the geometry less that with normals of depths, of the ray set that gains least.
fn geometry_normals_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    let scene = near(scene);
    let [geometry, depth] = ["geometry", "depth"].map(|normals| row(&scene, &[("normals", normals)]));
    let (geometry, depth) = (geometry?, depth?);
    least(depth.traces.iter().filter_map(|own| Some(footprint(trace(geometry, &own.rays)?)? - footprint(own)?)))
}

/// The median error of t of stereo rays with lossless thresholds, of depths' normals and of the geometry's the less, over what counts as
/// exact at a scene's diagonal.
fn lossless_error_in_tolerances(scene: &SceneRows<'_>) -> Option<f64> {
    let scene = near(scene);
    let error = |normals: &str| {
        let row = row(&scene, &[("gamma_norm", "0"), ("gamma_dist", "0"), ("normals", normals)])?;
        let Judgement::Closest(closest) = &trace(row, "stereo")?.judgement else { return None };
        Some(closest.position_error.p50? / (TIGHT * row.scene.diagonal))
    };
    least(["depth", "geometry"].into_iter().filter_map(error))
}

/// Stereo and temporal rays in a million missed without dilation beyond those missed with it, with the interval of both shares.
fn undilated_false_misses_beyond(scene: &SceneRows<'_>, dilated: &str) -> Option<Estimate> {
    let scene = near(scene);
    let share = |dilated: &str| {
        let row = row(&scene, &[("dilated", dilated)])?;
        let all = SETS.iter().map(|rays| missed(trace(row, rays)?)).collect::<Option<Vec<_>>>()?;
        let [rays, missed] = all.iter().fold([0, 0], |[rays, missed], one| [rays + one[0], missed + one[1]]);
        Some(Estimate::timed(missed as f64 / rays as f64, wilson(missed, rays)?, []) * MILLION)
    };
    Some(share("none")? - share(dilated)?)
}

/// The first part and that where eye and camera have moved farthest.
fn ends<'a>(scene: &SceneRows<'a>) -> [SceneRows<'a>; 2] {
    [near(scene), scene.of_rays(experiments::FARTHEST)]
}

/// By how many times a count a stereo ray grows from near to far.
fn growth(scene: &SceneRows<'_>, of: impl Fn(&SceneRows<'_>) -> Option<f64>) -> Option<f64> {
    let [near, far] = ends(scene).map(|part| of(&part));
    near.filter(|count| *count > 0.0).and_then(|near| Some(far? / near))
}

fn samples(scene: &SceneRows<'_>) -> Option<f64> {
    per_ray(trace(scene.like_first(DDA, &[])?, "stereo")?, SAMPLES)
}

/// The exponent by which DDA's time of stereo rays grows with the depths that it looks at, from near to far.
fn dda_time_exponent(scene: &SceneRows<'_>) -> Option<Estimate> {
    let more = growth(scene, samples)?;
    let [near, far] = ends(scene).map(|part| part.like_first(DDA, &[]));
    let slower = ratio(scene.record, &traced(far?, "stereo")?, &traced(near?, "stereo")?)?;
    (more > 1.0).then(|| slower.rising(f64::ln) / more.ln())
}

/// Time in two layers where eye and camera have moved farthest over that near, mean of both ray sets.
fn displaced_over_near(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [near, far] = ends(scene).map(|part| row(&part, &[("layers", "2")]));
    let (near, far) = (near?, far?);
    of_both_sets(|rays| ratio(scene.record, &traced(far, rays)?, &traced(near, rays)?))
}

/// How the time of a ray in two layers is ranked by the share of rays that go on to the second, over scenes, parts and ray sets.
fn rank_of_time_by_second_layer<'a>(scenes: &[SceneRows<'a>]) -> Option<Estimate> {
    let mut points = Vec::new();
    for part in scenes.iter().flat_map(|scene| scene.by_resolution()) {
        let Some(row) = row(&part, &[("layers", "2")]) else { continue };
        for rays in SETS {
            let traced_rays = trace(row, rays)?;
            points.push((share_asking_second(traced_rays)?, traced(row, rays)?.times(1.0 / traced_rays.count as f64)));
        }
    }
    rank_correlation(scenes.first()?.record, &points)
}
