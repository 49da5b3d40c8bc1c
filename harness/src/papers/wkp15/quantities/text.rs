//! What the text states: layers, traversal, normals, cracks, displacement.

use super::{NODES, SAMPLES, missed, share_asking_second};
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{IN_A_MILLION, PERCENT, Quantity, least, of_scene, timed_of_scene, timed_of_scenes};
use crate::papers::rows::{self, SceneRows, beyond, footprint, has, per_ray, trace};
use crate::papers::times::{rank_correlation, ratio, traced};
use crate::papers::wkp15::{DDA, QUADTREE, experiments, row};
use crate::results::{Judgement, Row, Timed};

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("traversal_without_stack_saves", PERCENT, without_stack_saves),
    of_scene("same_hits_with_stack", "", |scene| same_hits(scene, ("traversal", "stack"))),
    of_scene("same_hits_through_all_layers", "", |scene| same_hits(scene, EVERY_LAYER)),
    timed_of_scene("all_layers_time_over_cascade", "", all_layers_time_over_cascade),
    timed_of_scene("four_layers_time_over_three", "", four_layers_over_three),
    timed_of_scene("build_of_four_layers_over_eyes", "", build_of_four_layers_over_eyes),
    of_scene("recovered_by_second_layer", "", recovered_by_second_layer),
    of_scene("geometry_normals_agreement_change", "", geometry_normals_agreement_change),
    of_scene("lossless_error_in_tolerances", "", lossless_error_in_tolerances),
    of_scene("undilated_false_misses_beyond", IN_A_MILLION, undilated_false_misses_beyond),
    timed_of_scene("two_levels_fewer_time_over_most", "", two_levels_fewer),
    timed_of_scene("dda_time_exponent_over_samples", "", dda_time_exponent),
    of_scene("nodes_growth_over_samples", "", nodes_growth_over_samples),
    timed_of_scene("displaced_time_over_near", "", displaced_over_near),
    timed_of_scenes("rank_of_time_by_second_layer", "", rank_of_time_by_second_layer),
];

/// A ray is traced through all layers, whatever the first leaves open.
const EVERY_LAYER: (&str, &str) = ("next_layer", "always");
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

/// The share of ray sets that have the same hits with another value of a parameter.
fn same_hits(scene: &SceneRows<'_>, other: (&str, &str)) -> Option<f64> {
    let scene = near(scene);
    rows::same_hits(row(&scene, &[])?, row(&scene, &[other])?)
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

/// The share of temporal rays that one layer misses wrongly and two do not, where the camera has moved farthest; nothing is inpainted.
/// Of all second layers, by separation and back faces, the best.
fn recovered_by_second_layer(scene: &SceneRows<'_>) -> Option<f64> {
    let scene = scene.of_rays(experiments::FARTHEST);
    let misses = |row: &Row| missed(trace(row, "temporal")?).map(|[_, missed]| missed as f64);
    let one = misses(row(&scene, &[("layers", "1"), ("inpainting", "never")])?).filter(|missed| *missed > 0.0)?;
    let two = scene.of_tracer(QUADTREE).filter(|row| has(row, "layers", "2")).filter_map(misses);
    least(two).map(|two| (one - two) / one)
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

/// Rays in a million missed without dilation beyond those missed with it.
fn undilated_false_misses_beyond(scene: &SceneRows<'_>) -> Option<f64> {
    let scene = near(scene);
    beyond(row(&scene, &[("dilated", "none")])?, row(&scene, &[])?, missed)
}

/// Time with two levels fewer than the paper's most over that with these.
fn two_levels_fewer(scene: &SceneRows<'_>) -> Option<Estimate> {
    let scene = near(scene);
    let [fewer, most] = ["7", "9"].map(|levels| row(&scene, &[("levels", levels)]));
    let (fewer, most) = (fewer?, most?);
    of_both_sets(|rays| scene.trace_ratio(fewer, most, rays))
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

fn nodes(scene: &SceneRows<'_>) -> Option<f64> {
    per_ray(trace(row(scene, &[("layers", "1")])?, "stereo")?, NODES)
}

/// The exponent by which DDA's time of stereo rays grows with the depths that it looks at, from near to far.
fn dda_time_exponent(scene: &SceneRows<'_>) -> Option<Estimate> {
    let more = growth(scene, samples)?;
    let [near, far] = ends(scene).map(|part| part.like_first(DDA, &[]));
    let slower = ratio(scene.record, &traced(far?, "stereo")?, &traced(near?, "stereo")?)?;
    (more > 1.0).then(|| slower.rising(f64::ln) / more.ln())
}

/// By how many times the nodes that a stereo ray visits in one layer grow from near to far, over the growth of DDA's samples.
fn nodes_growth_over_samples(scene: &SceneRows<'_>) -> Option<f64> {
    Some(growth(scene, nodes)? / growth(scene, samples)?)
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
