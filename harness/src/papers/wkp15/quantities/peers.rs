//! Tables 2 and 3: beside DDA and the height field.

use super::tree::reachable;
use super::{CELLS, HIDDEN_LAYER, NODES, OTHER_LAYERS, UNCAPPED, second_layer, share_asking_second, share_of_cause};
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{IN_A_MILLION, Quantity, greatest, of_scene, timed_of_scene, timed_of_scenes};
use crate::papers::rows::{MILLION, SceneRows, per_ray, trace};
use crate::papers::times::{rank_correlation, traced};
use crate::papers::wkp15::experiments::{DETAILED, SIMPLE};
use crate::papers::wkp15::{DDA, FIELD, MESH, QUADTREE, one_and_two, row};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("height_field_time_over_quadtree", "", height_field_time),
    timed_of_scene("dda_time_over_quadtree", "", |scene| dda_time(scene, "stereo", &[])),
    timed_of_scene("uncapped_dda_time_over_quadtree", "", |scene| dda_time(scene, "stereo", UNCAPPED)),
    timed_of_scene("dda_lead_in_temporal_over_stereo", "", |scene| lead_in_temporal_over_stereo(scene, &[])),
    timed_of_scene("uncapped_dda_lead_in_temporal_over_stereo", "", |scene| {
        lead_in_temporal_over_stereo(scene, UNCAPPED)
    }),
    timed_of_scene("dda_second_layer_time", "", |scene| dda_second_layer(scene, &[])),
    timed_of_scene("uncapped_dda_second_layer_time", "", |scene| dda_second_layer(scene, UNCAPPED)),
    timed_of_scene("second_layer_time_in_stereo", "", |scene| second_layer(scene, "stereo", &[])),
    timed_of_scene("separated_layer_time_in_stereo", "", |scene| second_layer(scene, "stereo", &[OTHER_LAYERS[0]])),
    timed_of_scene("front_face_layer_time_in_stereo", "", |scene| second_layer(scene, "stereo", &[OTHER_LAYERS[1]])),
    timed_of_scene("one_layer_time_over_two", "", one_layer_time_over_two),
    timed_of_scene("mesh_time_over_quadtree", "", mesh_time),
    timed_of_scenes("mesh_lead_where_detailed", "", mesh_lead_where_detailed),
    timed_of_scenes("second_layer_time_where_detailed", "", second_layer_time_where_detailed),
    timed_of_scenes("rank_of_time_by_nodes", "", rank_of_time_by_nodes),
    of_scene("nodes_visited_over_height_field", "", |scene| nodes_over_height_field(scene, &[])),
    of_scene("lossless_nodes_visited_over_height_field", "", |scene| {
        nodes_over_height_field(scene, &[("gamma_norm", "0"), ("gamma_dist", "0")])
    }),
    of_scene("rays_asking_second_layer", "", rays_asking_second_layer),
    of_scene("height_field_hidden_rays", IN_A_MILLION, height_field_hidden_rays),
];

/// Time of stereo rays in the height field over that in one layer.
fn height_field_time(scene: &SceneRows<'_>) -> Option<Estimate> {
    scene.trace_ratio(scene.like_first(FIELD, &[])?, row(scene, &[("layers", "1")])?, "stereo")
}

/// Time by DDA, with a cap of steps if one is said, over that in the trees, mean of one and two layers each.
pub(super) fn dda_time(scene: &SceneRows<'_>, rays: &str, steps: &[(&str, &str)]) -> Option<Estimate> {
    let (own, peers) = (one_and_two(scene, QUADTREE, &[])?, one_and_two(scene, DDA, steps)?);
    let ratios = own.iter().zip(peers).map(|(own, peer)| scene.trace_ratio(peer, own, rays));
    Estimate::mean(ratios.collect::<Option<Vec<_>>>()?)
}

/// The same of temporal rays over that of stereo rays, mean over the views that are made.
fn lead_in_temporal_over_stereo(scene: &SceneRows<'_>, steps: &[(&str, &str)]) -> Option<Estimate> {
    let lead = |at: SceneRows<'_>| Some(dda_time(&at, "temporal", steps)? / dda_time(&at, "stereo", steps)?);
    Estimate::mean(scene.by_resolution().into_iter().map(lead).collect::<Option<Vec<_>>>()?)
}

/// Time of stereo rays by DDA over two layers over that over one.
fn dda_second_layer(scene: &SceneRows<'_>, steps: &[(&str, &str)]) -> Option<Estimate> {
    let [one, two] = one_and_two(scene, DDA, steps)?;
    scene.trace_ratio(two, one, "stereo")
}

/// Time of stereo rays by mesh warping, drawing in it, over that in the trees, of one layer and two the less.
fn mesh_time(scene: &SceneRows<'_>) -> Option<Estimate> {
    let mesh = scene.like_first(MESH, &[])?;
    let ratios = one_and_two(scene, QUADTREE, &[])?.map(|own| scene.trace_ratio(mesh, own, "stereo"));
    Estimate::least(ratios.into_iter().collect::<Option<Vec<_>>>()?)
}

/// The scene of the paper that something stands for.
fn standing_for<'a, 'b>(scenes: &'b [SceneRows<'a>], name: &str) -> Option<&'b SceneRows<'a>> {
    scenes.iter().find(|scene| scene.rows.first().is_some_and(|row| row.scene.name == name))
}

/// Time by mesh warping over that in two layers, in the detailed scene over the same in the simple one.
fn mesh_lead_where_detailed(scenes: &[SceneRows<'_>]) -> Option<Estimate> {
    let lead = |name: &str| {
        let scene = standing_for(scenes, name)?;
        scene.trace_ratio(scene.like_first(MESH, &[])?, row(scene, &[("layers", "2")])?, "stereo")
    };
    Some(lead(DETAILED)? / lead(SIMPLE)?)
}

/// Time of stereo rays in one layer, inpainted, over that in two.
fn one_layer_time_over_two(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [one, two] = one_and_two(scene, QUADTREE, &[])?;
    scene.trace_ratio(one, two, "stereo")
}

/// Time of temporal rays in two layers over that in one: in the detailed scene over the greatest of the others, mean over the views.
fn second_layer_time_where_detailed(scenes: &[SceneRows<'_>]) -> Option<Estimate> {
    let of_scene = |scene: &SceneRows<'_>| {
        let views = scene.by_resolution().into_iter().map(|at| second_layer(&at, "temporal", &[]));
        Estimate::mean(views.collect::<Option<Vec<_>>>()?)
    };
    let detailed = standing_for(scenes, DETAILED)?;
    let others = scenes.iter().filter(|scene| scene.label != detailed.label).filter_map(of_scene);
    Some(of_scene(detailed)? / Estimate::greatest(others)?)
}

/// How the time of a stereo ray in one layer is ranked by the nodes of the tree over the scenes.
fn rank_of_time_by_nodes<'a>(scenes: &[SceneRows<'a>]) -> Option<Estimate> {
    let point = |scene: &SceneRows<'a>| {
        let row = row(scene, &[("layers", "1")])?;
        let rays = trace(row, "stereo")?.count as f64;
        Some((reachable(row)?, traced(row, "stereo")?.times(1.0 / rays)))
    };
    rank_correlation(scenes.first()?.record, &scenes.iter().filter_map(point).collect::<Vec<_>>())
}

/// What a stereo ray counts on the mean.
fn a_ray(row: Option<&Row>, counter: &str) -> Option<f64> {
    per_ray(trace(row?, "stereo")?, counter)
}

/// Nodes that a stereo ray visits in one layer, at thresholds if some are said, over the cells of the height field's pyramid.
fn nodes_over_height_field(scene: &SceneRows<'_>, thresholds: &[(&str, &str)]) -> Option<f64> {
    let field = a_ray(scene.like_first(FIELD, &[]), CELLS).filter(|cells| *cells > 0.0)?;
    let of_one_layer = [&[("layers", "1")], thresholds].concat();
    Some(a_ray(row(scene, &of_one_layer), NODES)? / field)
}

/// The share of stereo rays that go on to the second layer.
fn rays_asking_second_layer(scene: &SceneRows<'_>) -> Option<f64> {
    let [_, two] = one_and_two(scene, QUADTREE, &[])?;
    share_asking_second(trace(two, "stereo")?)
}

/// Temporal rays in a million whose true hit the height field does not keep, the most over the views.
fn height_field_hidden_rays(scene: &SceneRows<'_>) -> Option<f64> {
    let share = |row: &Row| Some(share_of_cause(trace(row, "temporal")?, HIDDEN_LAYER)? * MILLION);
    greatest(scene.of_tracer(FIELD).filter_map(share))
}
