//! Figures 7 to 9 and the text: views, layers, marches, bounds, centres, halving.

use super::{counted, rays};
use crate::papers::Scope;
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{IN_A_MILLION, PERCENT, Quantity, of_scene, timed_of_scene};
use crate::papers::rows::{
    MILLION, SceneRows, beyond, beyond_of, false_misses, footprint, of_cause, share_of_all, statistic, trace,
};
use crate::papers::vvp16::{ABUFFER, PAPER, row};
use crate::papers::wkp15;
use crate::results::{Row, TraceRecord};

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("seven_views_over_one", "", seven_views_over_one),
    timed_of_scene("all_layers_over_one", "", all_layers_over_one),
    of_scene("one_view_false_misses_beyond", IN_A_MILLION, one_view_false_misses_beyond),
    of_scene("one_layer_false_misses_beyond", IN_A_MILLION, one_layer_false_misses_beyond),
    timed_of_scene("steps_over_hi_z", "", steps_over_hi_z),
    of_scene("sparse_steps_agreement_change", "", sparse_steps_agreement_change),
    of_scene("half_resolution_agreement_change", "", half_resolution_agreement_change),
    timed_of_scene("resolution_exponent", "", resolution_exponent),
    of_scene("off_view_rays_of_six_faces", IN_A_MILLION, off_view_rays_of_six_faces),
    of_scene("hidden_rays_of_two_layers", IN_A_MILLION, hidden_rays_of_two_layers),
    of_scene("fragments_beyond_centres_in_eye", PERCENT, fragments_beyond_centres_in_eye),
    timed_of_scene("bounds_of_boxes_over_geometry", "", bounds_of_boxes_over_geometry),
    of_scene("camera_view_agreement_change", "", camera_view_agreement_change),
    of_scene("camera_view_agreement_change_fine", "", camera_view_agreement_change_fine),
    of_scene("views_asked_for_at_a_switch", "views", views_asked_for_at_a_switch),
    timed_of_scene("halving_above_16_over_best", "", halving_above_16_over_best),
];

/// The ray sets of Figures 7 and 9.
const TIMED: [&str; 2] = ["diffuse", "ao"];
/// The ray sets of Figure 8.
const BENT: [&str; 2] = ["specular", "refraction"];
/// What the judge says of rays whose true hit no view holds.
const OFF_VIEW: &str = "off_view";
/// And of those whose true hit lies behind what the views keep.
const HIDDEN_LAYER: &str = "hidden_layer";

/// Time with seven views over that with the camera's alone, all layers, mean over the ray sets.
fn seven_views_over_one(scene: &SceneRows<'_>) -> Option<Estimate> {
    let (seven, one) = (row(scene, &[("views", "seven")])?, row(scene, &[("views", "frame")])?);
    Estimate::mean(TIMED.iter().map(|rays| scene.trace_ratio(seven, one, rays)).collect::<Option<Vec<Estimate>>>()?)
}

/// Time with all layers over that with the nearest, the least over seven views and one, and ray sets.
fn all_layers_over_one(scene: &SceneRows<'_>) -> Option<Estimate> {
    let mut ratios = Vec::new();
    for views in ["seven", "frame"] {
        let [all, one] = ["all", "one"].map(|layers| row(scene, &[("views", views), ("layers", layers)]));
        for rays in TIMED {
            ratios.push(scene.trace_ratio(all?, one?, rays)?);
        }
    }
    Estimate::least(ratios)
}

/// Rays in a million missed with the camera's view beyond those missed with seven.
fn one_view_false_misses_beyond(scene: &SceneRows<'_>) -> Option<f64> {
    beyond(row(scene, &[("views", "frame")])?, row(scene, &[("views", "seven")])?, false_misses)
}

/// Mirrored and refracted rays in a million missed with one layer beyond those missed with all.
fn one_layer_false_misses_beyond(scene: &SceneRows<'_>) -> Option<f64> {
    let [one, all] = ["one", "all"].map(|layers| row(scene, &[("layers", layers)]));
    beyond_of(one?, all?, |trace| BENT.contains(&trace.rays.as_str()), false_misses)
}

/// Time of diffuse rays in 100 steps over that by the pyramid.
fn steps_over_hi_z(scene: &SceneRows<'_>) -> Option<Estimate> {
    scene.trace_ratio(row(scene, &[("march", "steps")])?, row(scene, &[("march", "hi-z")])?, "diffuse")
}

/// Footprint agreement of diffuse rays.
fn agreement(row: Option<&Row>) -> Option<f64> {
    footprint(trace(row?, "diffuse")?)
}

/// Agreement in 25 steps less that over every pixel.
fn sparse_steps_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    Some(agreement(row(scene, &[("view_steps", "25")]))? - agreement(row(scene, &[("march", "pixels")]))?)
}

/// The rows at a lower resolution than the first row's.
fn coarser<'a>(scene: &SceneRows<'a>) -> Option<SceneRows<'a>> {
    let first = scene.of_tracer(ABUFFER).next()?;
    let of = |row: &Row| row.viewpoint.ray_image;
    scene.by_resolution().into_iter().find(|at| at.rows.iter().all(|row| of(row)[0] < of(first)[0]))
}

/// The rows with finer faces than the first row's, all else alike.
fn finer_faces<'a>(scene: &SceneRows<'a>) -> Option<SceneRows<'a>> {
    let first = &scene.of_tracer(ABUFFER).next()?.viewpoint;
    let finer = |row: &&Row| {
        let own = &row.viewpoint;
        (own.ray_image, own.frame) == (first.ray_image, first.frame) && own.face > first.face
    };
    scene.by_resolution().into_iter().find(|at| at.rows.iter().all(&finer))
}

const A_PIXEL_THICK: [(&str, &str); 3] = [("thickness_in", "pixels"), ("thickness", "1"), ("march", "steps")];

/// Agreement at the lower resolution less that at the first row's, with a thickness of a pixel.
fn half_resolution_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    let low = coarser(scene)?;
    Some(agreement(row(&low, &A_PIXEL_THICK))? - agreement(row(scene, &A_PIXEL_THICK))?)
}

/// Every pixel visited: the exponent of bytes over pixels, and that of the time of a diffuse ray over the edge; the one farther
/// from 1.
fn resolution_exponent(scene: &SceneRows<'_>) -> Option<Estimate> {
    let pixels = [("march", "pixels")];
    let (low, high) = (row(&coarser(scene)?, &pixels)?, row(scene, &pixels)?);
    let growth = statistic(high, "pixels")? / statistic(low, "pixels")?;
    let rays = trace(high, "diffuse")?.count as f64 / trace(low, "diffuse")?.count as f64;
    let grown = PAPER.bytes(high, Scope::Structure)? / PAPER.bytes(low, Scope::Structure)?;
    let bytes = Estimate::from(grown.ln() / growth.ln());
    let time = (scene.trace_ratio(high, low, "diffuse")? / rays).rising(f64::ln) / growth.sqrt().ln();
    let farther = if (bytes.value - 1.0).abs() > (time.value - 1.0).abs() { bytes.value } else { time.value };
    let interval = [bytes.value.min(time.interval[0]), bytes.value.max(time.interval[1])];
    Some(Estimate { value: farther, interval, ..time })
}

/// Rays in a million of all closest-hit sets of a row that are wrong for a cause.
fn rays_of_cause(row: &Row, cause: &str) -> Option<f64> {
    share_of_all(row, |trace| of_cause(trace, "tight", cause)).map(|share| share * MILLION)
}

/// Of rays whose true hit lies in none of six faces.
fn off_view_rays_of_six_faces(scene: &SceneRows<'_>) -> Option<f64> {
    rays_of_cause(row(scene, &[("views", "six")])?, OFF_VIEW)
}

/// Of rays whose true hit lies behind both layers of the quadtree's six faces.
fn hidden_rays_of_two_layers(scene: &SceneRows<'_>) -> Option<f64> {
    rays_of_cause(scene.like_first(wkp15::QUADTREE, &[])?, HIDDEN_LAYER)
}

/// Fragments of six faces with centres pulled back beyond those with centres in the eye, percent.
fn fragments_beyond_centres_in_eye(scene: &SceneRows<'_>) -> Option<f64> {
    let fragments = |centre: &str| statistic(row(scene, &[("views", "six"), ("centre", centre)])?, "fragments");
    Some(100.0 * (fragments("pulled_back")? / fragments("eye")? - 1.0))
}

/// Time of the depth bounds of bounding boxes over that of the geometry's.
fn bounds_of_boxes_over_geometry(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [boxes, geometry] = ["boxes", "geometry"].map(|of| row(scene, &[("bounds", of)]));
    scene.phase_ratio(boxes?, geometry?, "depth bounds")
}

/// Agreement without the camera's view less that with it.
fn camera_view_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    Some(agreement(row(scene, &[("views", "six")]))? - agreement(row(scene, &[("views", "seven")]))?)
}

/// The same where faces are finer, either way.
fn camera_view_agreement_change_fine(scene: &SceneRows<'_>) -> Option<f64> {
    camera_view_agreement_change(&finer_faces(scene)?).map(f64::abs)
}

/// Time of diffuse rays in the S-buffer with halving above 16 fragments, over the least of other limits.
fn halving_above_16_over_best(scene: &SceneRows<'_>) -> Option<Estimate> {
    let with = |limit: &str| row(scene, &[("storage", "s-buffer"), ("binary_search_above", limit)]);
    let sixteen = with("16")?;
    let others = ["0", "64", "1048576"].iter().map(|limit| scene.trace_ratio(sixteen, with(limit)?, "diffuse"));
    Estimate::greatest(others.collect::<Option<Vec<Estimate>>>()?)
}

/// Views asked for at a switch from one of six faces to the next. A ray's first face is found by asking all six.
fn views_asked_for_at_a_switch(scene: &SceneRows<'_>) -> Option<f64> {
    let traces: Vec<&TraceRecord> = row(scene, &[("views", "six")])?.traces.iter().collect();
    let switches = counted(&traces, "views_entered")? - rays(&traces);
    (switches > 0.0).then(|| Some((counted(&traces, "views_tested")? - 6.0 * rays(&traces)) / switches))?
}
