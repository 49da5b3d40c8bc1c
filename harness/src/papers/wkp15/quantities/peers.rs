//! Tables 2 and 3: beside DDA and the height field.

use super::tree::reachable;
use super::{BOXES, CELLS, HIDDEN_LAYER, NODES, second_layer, share_asking_second, share_of_cause};
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{IN_A_MILLION, Quantity, greatest, of_scene, timed_of_scene, timed_of_scenes};
use crate::papers::rows::{MILLION, SceneRows, footprint, per_ray, trace};
use crate::papers::times::{rank_correlation, traced};
use crate::papers::wkp15::experiments::DETAILED;
use crate::papers::wkp15::{DDA, FIELD, QUADTREE, one_and_two, row};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("height_field_time_over_quadtree", "", height_field_time),
    timed_of_scene("dda_time_over_quadtree", "", |scene| dda_time(scene, "stereo")),
    timed_of_scene("dda_lead_in_temporal_over_stereo", "", lead_in_temporal_over_stereo),
    timed_of_scene("second_layer_time_in_stereo", "", |scene| second_layer(scene, "stereo")),
    timed_of_scene("one_layer_time_over_two", "", one_layer_time_over_two),
    timed_of_scenes("second_layer_time_where_detailed", "", second_layer_time_where_detailed),
    timed_of_scenes("rank_of_time_by_nodes", "", rank_of_time_by_nodes),
    of_scene("nodes_visited_over_height_field", "", nodes_over_height_field),
    of_scene("box_tests_a_ray", "", box_tests_a_ray),
    of_scene("rays_asking_second_layer", "", rays_asking_second_layer),
    of_scene("dda_agreement_change", "", dda_agreement_change),
    of_scene("height_field_hidden_rays", IN_A_MILLION, height_field_hidden_rays),
];

/// Time of stereo rays in the height field over that in one layer.
fn height_field_time(scene: &SceneRows<'_>) -> Option<Estimate> {
    scene.trace_ratio(scene.like_first(FIELD, &[])?, row(scene, &[("layers", "1")])?, "stereo")
}

/// Time by DDA over that in the trees, mean of one and two layers each.
fn dda_time(scene: &SceneRows<'_>, rays: &str) -> Option<Estimate> {
    let (own, peers) = (one_and_two(scene, QUADTREE)?, one_and_two(scene, DDA)?);
    let ratios = own.iter().zip(peers).map(|(own, peer)| scene.trace_ratio(peer, own, rays));
    Estimate::mean(ratios.collect::<Option<Vec<_>>>()?)
}

/// The same of temporal rays over that of stereo rays, mean over the views that are made.
fn lead_in_temporal_over_stereo(scene: &SceneRows<'_>) -> Option<Estimate> {
    let leads = scene.by_resolution().into_iter().map(|at| Some(dda_time(&at, "temporal")? / dda_time(&at, "stereo")?));
    Estimate::mean(leads.collect::<Option<Vec<_>>>()?)
}

/// Time of stereo rays in one layer, inpainted, over that in two.
fn one_layer_time_over_two(scene: &SceneRows<'_>) -> Option<Estimate> {
    let [one, two] = one_and_two(scene, QUADTREE)?;
    scene.trace_ratio(one, two, "stereo")
}

/// Time of temporal rays in two layers over that in one: in the detailed scene over the greatest of the others, mean over the views.
fn second_layer_time_where_detailed(scenes: &[SceneRows<'_>]) -> Option<Estimate> {
    let of_scene = |scene: &SceneRows<'_>| {
        let views = scene.by_resolution().into_iter().map(|at| second_layer(&at, "temporal"));
        Estimate::mean(views.collect::<Option<Vec<_>>>()?)
    };
    let is_detailed = |scene: &&SceneRows<'_>| scene.rows.first().is_some_and(|row| row.scene.name == DETAILED);
    let detailed = of_scene(scenes.iter().find(is_detailed)?)?;
    let others = scenes.iter().filter(|scene| !is_detailed(scene)).filter_map(of_scene);
    Some(detailed / Estimate::greatest(others)?)
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

/// Nodes that a stereo ray visits in one layer over the cells of the height field's pyramid.
fn nodes_over_height_field(scene: &SceneRows<'_>) -> Option<f64> {
    let field = a_ray(scene.like_first(FIELD, &[]), CELLS).filter(|cells| *cells > 0.0)?;
    Some(a_ray(row(scene, &[("layers", "1")]), NODES)? / field)
}

/// Boxes that a stereo ray is tested against on the mean, the more of one layer and of two.
fn box_tests_a_ray(scene: &SceneRows<'_>) -> Option<f64> {
    let rows = one_and_two(scene, QUADTREE)?.map(|row| a_ray(Some(row), BOXES));
    greatest(rows.into_iter().flatten())
}

/// The share of stereo rays that go on to the second layer.
fn rays_asking_second_layer(scene: &SceneRows<'_>) -> Option<f64> {
    let [_, two] = one_and_two(scene, QUADTREE)?;
    share_asking_second(trace(two, "stereo")?)
}

/// Footprint agreement of stereo rays by DDA less that in the trees, of one layer and of two that which is farther from nothing.
fn dda_agreement_change(scene: &SceneRows<'_>) -> Option<f64> {
    let agreements = |tracer: &str| Some(one_and_two(scene, tracer)?.map(|row| footprint(trace(row, "stereo")?)));
    let (own, peers) = (agreements(QUADTREE)?, agreements(DDA)?);
    let changes = own.into_iter().zip(peers).filter_map(|(own, peer)| Some(peer? - own?));
    changes.max_by(|one, other| one.abs().total_cmp(&other.abs()))
}

/// Temporal rays in a million whose true hit the height field does not keep, the most over the views.
fn height_field_hidden_rays(scene: &SceneRows<'_>) -> Option<f64> {
    let share = |row: &Row| Some(share_of_cause(trace(row, "temporal")?, HIDDEN_LAYER)? * MILLION);
    greatest(scene.of_tracer(FIELD).filter_map(share))
}
