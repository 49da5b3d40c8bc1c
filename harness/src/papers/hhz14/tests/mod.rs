//! Quantities of grid and A-buffers are what they say.

mod pages;

use std::collections::BTreeMap;

use serde_json::{Value, json};
use tracebench_api::Query;

use super::PAPER;
use crate::papers::fixture::{
    self, close, config, count, in_a_million, run_of, set_build, set_bytes, set_classes, set_time, trace_of,
};
use crate::results::{Judgement, Record, Row};

const SETS: [(&str, Query); 6] = [
    ("specular", Query::Closest),
    ("refraction", Query::Closest),
    ("diffuse", Query::Closest),
    ("bounce2", Query::Closest),
    ("visibility", Query::Any),
    ("ao", Query::Any),
];

fn abuffer(scene: &str, parameters: Value) -> Row {
    config("voxel-abuffer", scene, parameters, &[], &SETS)
}

fn values(name: &str, record: &Record) -> BTreeMap<String, f64> {
    fixture::values(&PAPER, name, record)
}

fn value(name: &str, record: &Record) -> f64 {
    fixture::value(&PAPER, name, record)
}

/// The balanced accuracy of an any-hit set.
fn set_accuracy(row: &mut Row, rays: &str, share: f64) {
    let Judgement::Any(any) = &mut trace_of(row, rays).judgement else { panic!("{rays} is closest-hit") };
    any.occlusion.balanced_accuracy = Some(share);
}

/// Tables whose figures stood in a picture alone have none.
#[test]
fn lost_figures_are_named() {
    assert_eq!(fixture::lost(&PAPER), ["hhz14-figure6", "hhz14-figure9"]);
}

/// Table 1 of a scene: A-buffers, and the octree by both of its walks.
fn table_1(scene: &str) -> Vec<Row> {
    let mut own = abuffer(scene, json!({ "abuffer": 1024, "grid": 64 }));
    let walk = |(traversal, factor): (&str, f64)| {
        let mut record = config("voxel-octree", scene, json!({ "traversal": traversal, "hit": "entry" }), &[], &SETS);
        for (rays, ms) in [("specular", 20.0), ("refraction", 40.0), ("visibility", 30.0)] {
            set_time(&mut record, rays, ms * factor);
        }
        set_build(&mut record, 42.0);
        record
    };
    for (rays, ms) in [("specular", 2.0), ("refraction", 3.0), ("visibility", 5.0)] {
        set_time(&mut own, rays, ms);
    }
    set_build(&mut own, 14.0);
    set_classes(&mut own, "specular", [0, 0], 0.97);
    set_classes(&mut own, "refraction", [0, 0], 0.96);
    vec![own, walk(("restart", 1.0)), walk(("stack", 0.8))]
}

/// The octree stands beside the A-buffers by all rays of a frame together and by the quicker of its walks; without one of the sets,
/// or without either method, there is no ratio.
#[test]
fn the_octree_stands_beside() {
    let record = run_of(table_1("a"));
    close(value("octree_build_over_abuffer", &record), 3.0);
    close(value("octree_trace_over_abuffer", &record), 7.2);
    // By the first walk, which is the row's own.
    close(value("octree_total_over_abuffer", &record), (42.0 + 90.0) / 24.0);
    close(value("refraction_agreement_less_specular", &record), -0.01);
    let mut slower = record.clone();
    set_time(&mut slower.rows[2], "visibility", 240.0);
    close(value("octree_trace_over_abuffer", &slower), 9.0);
    let mut lacking = record.clone();
    lacking.rows[0].traces.retain(|trace| trace.rays != "visibility");
    for name in ["octree_trace_over_abuffer", "octree_total_over_abuffer"] {
        assert!(values(name, &lacking).is_empty(), "{name}");
    }
    assert!(values("octree_build_over_abuffer", &run_of(record.rows[..1].to_vec())).is_empty());
    assert!(values("refraction_agreement_less_specular", &run_of(record.rows[1..].to_vec())).is_empty());
}

/// Figure 6 of a scene: a search in every texel, in three steps, in one.
fn figure_6(scene: &str, ms: [f64; 3]) -> Vec<Row> {
    let searches = [("dda2d", 100, 0.99, 0.98), ("three-step", 300, 0.98, 0.975), ("one-step", 1100, 0.95, 0.96)];
    let make = |((search, missed, footprint, accuracy), ms): ((&str, u64, f64, f64), f64)| {
        let mut row = abuffer(scene, json!({ "abuffer": 1024, "grid": "64", "search": search }));
        row.traces.retain(|trace| ["specular", "refraction", "ao"].contains(&trace.rays.as_str()));
        for rays in ["specular", "refraction", "ao"] {
            set_time(&mut row, rays, ms);
        }
        set_classes(&mut row, "specular", [missed, 0], footprint);
        set_classes(&mut row, "refraction", [2 * missed, 0], footprint - 0.02);
        set_accuracy(&mut row, "ao", accuracy);
        count(&mut row, "specular", "voxels_stepped", 32 * fixture::COUNT);
        count(&mut row, "refraction", "voxels_stepped", 16 * fixture::COUNT);
        count(&mut row, "ao", "voxels_stepped", 8 * fixture::COUNT);
        row
    };
    searches.into_iter().zip(ms).map(make).collect()
}

/// Searches are compared with that in every texel, the worst closest-hit set of each; gains are of neighbours, the less counts; rows
/// that are not there leave nothing.
#[test]
fn searches_are_compared() {
    let record = run_of(figure_6("a", [9.0, 6.0, 5.0]));
    close(value("min_footprint_agreement", &record), 0.97);
    close(value("three_step_agreement_change", &record), -0.01);
    close(value("one_step_ao_change", &record), -0.02);
    close(value("one_step_passed_beyond", &record), in_a_million(3 * 1000) / 2.0);
    close(value("min_gain_of_fewer_steps", &record), 1.2);
    close(value("min_gain_of_fewer_steps", &run_of(figure_6("a", [9.0, 10.0, 5.0]))), 0.9);
    close(value("voxels_visited_over_grid", &record), 0.5);
    let mut worse = record.clone();
    set_classes(&mut worse.rows[1], "specular", [0, 0], 0.9);
    close(value("three_step_agreement_change", &worse), -0.09);
    // What is found late was passed, too.
    let mut late = record.clone();
    for rays in ["specular", "refraction"] {
        let Judgement::Closest(closest) = &mut trace_of(&mut late.rows[2], rays).judgement else { panic!() };
        closest.classes.footprint.late += 40;
    }
    close(value("one_step_passed_beyond", &late), in_a_million(3 * 1000 + 2 * 40) / 2.0);
    let alone = run_of(record.rows[..1].to_vec());
    for name in
        ["three_step_agreement_change", "one_step_ao_change", "one_step_passed_beyond", "min_gain_of_fewer_steps"]
    {
        assert!(values(name, &alone).is_empty(), "{name}");
    }
}

/// The exponent of time over rays is 1 where a ray takes as long at every number of rays, and 0 where the time is the same.
#[test]
fn a_ray_takes_its_time() {
    let at = |factor: u64, ms: f64| {
        let mut row = abuffer("a", json!({ "search": "dda2d" }));
        row.viewpoint.ray_image = row.viewpoint.ray_image.map(|edge| edge * factor as u32);
        trace_of(&mut row, "ao").count *= factor * factor;
        set_time(&mut row, "ao", ms);
        row
    };
    close(value("time_over_rays_exponent", &run_of(vec![at(1, 2.0), at(2, 8.0), at(4, 32.0)])), 1.0);
    close(value("time_over_rays_exponent", &run_of(vec![at(1, 2.0), at(4, 2.0)])), 0.0);
    assert!(values("time_over_rays_exponent", &run_of(vec![at(1, 2.0)])).is_empty());
}

/// Resolutions of a scene: three searches in A-buffers of 1024, 512 and 2048, and four grids.
fn text(scene: &str, triangles: u64, wrong: u64) -> Vec<Row> {
    let mut rows = Vec::new();
    for (edge, factor, missed) in [(1024, 1.0, 40), (512, 0.9, 90), (2048, 1.08, 20)] {
        for (search, ms) in [("dda2d", 10.0), ("three-step", 5.0), ("one-step", 4.0)] {
            let mut row = abuffer(scene, json!({ "abuffer": edge, "grid": 64, "search": search }));
            row.traces.retain(|trace| trace.rays == "diffuse");
            set_time(&mut row, "diffuse", ms * factor);
            set_classes(&mut row, "diffuse", [missed, wrong], 0.9);
            count(&mut row, "diffuse", "depth_comparisons", edge * fixture::COUNT);
            let Judgement::Closest(closest) = &mut trace_of(&mut row, "diffuse").judgement else { panic!() };
            closest.causes.insert("footprint".to_owned(), BTreeMap::from([("wrong_axis".to_owned(), 7)]));
            set_bytes(&mut row, &[("grid", triangles)]);
            row.scene.triangles = triangles;
            rows.push(row);
        }
    }
    for (grid, ms) in [(0, 11.0), (32, 30.0), (128, 10.0), (256, 20.0)] {
        let mut row = abuffer(scene, json!({ "abuffer": 0, "grid": grid, "search": "dda2d" }));
        set_time(&mut row, "diffuse", ms);
        set_build(&mut row, 1.0);
        rows.push(row);
    }
    rows
}

/// Resolutions are compared with one another at one grid, grids against the one by the rule with the build in it.
#[test]
fn resolutions_and_grids_are_compared() {
    let record = run_of(text("room", 1000, 10));
    close(value("step_search_time_over_abuffer", &record), 1.2);
    close(value("dda_comparisons_over_abuffer", &record), 4.0);
    close(value("coarse_abuffer_passed_beyond", &record), in_a_million(70));
    close(value("grid_by_rule_total_over_best", &record), 12.0 / 11.0);
    close(value("wrong_axis_rays", &record), in_a_million(7));
    let mut slower = record.clone();
    // One step in A-buffers of 2048.
    set_time(&mut slower.rows[8], "diffuse", 36.0);
    close(value("step_search_time_over_abuffer", &slower), 10.0);
    let coarse = run_of(record.rows[..6].to_vec());
    for name in ["step_search_time_over_abuffer", "dda_comparisons_over_abuffer", "grid_by_rule_total_over_best"] {
        assert!(values(name, &coarse).is_empty(), "{name}");
    }
}

/// Scenes that are not closed are told from the others by the catalogue, and ranks are over three scenes at least; without one of the
/// kinds, or of a scene that nobody knows, there is no ratio.
#[test]
fn scenes_are_told_apart() {
    let of = |scenes: [(&str, u64, u64); 3]| {
        run_of(scenes.iter().flat_map(|(scene, triangles, wrong)| text(scene, *triangles, *wrong)).collect())
    };
    let record = of([("room", 1000, 60), ("solids", 2000, 160), ("cloth", 3000, 260)]);
    // With 40 rays missed in each: 300 over the mean of 100 and 200.
    close(value("open_wrong_over_closed", &record), 2.0);
    close(value("rank_of_bytes_by_triangles", &record), 1.0);
    for scenes in [
        [("room", 1000, 60), ("solids", 2000, 160), ("candy", 3000, 260)],
        [("room", 1000, 60), ("nobody's", 2000, 160), ("cloth", 3000, 260)],
    ] {
        assert!(values("open_wrong_over_closed", &of(scenes)).is_empty());
    }
    let mut against = record.clone();
    against.rows.iter_mut().filter(|one| one.scene.name == "cloth").for_each(|one| set_bytes(one, &[("grid", 1)]));
    close(value("rank_of_bytes_by_triangles", &against), -1.0 / 3.0);
}

/// Figure 9 of a scene: A-buffers, and voxels alone.
fn figure_9(scene: &str) -> Vec<Row> {
    let make = |(structure, abuffer_edge, grid, accuracy, error, ms): (&str, &str, u64, f64, f64, f64)| {
        let mut record = abuffer(scene, json!({ "structure": structure, "abuffer": abuffer_edge, "grid": grid }));
        set_accuracy(&mut record, "ao", accuracy);
        set_time(&mut record, "ao", ms);
        count(&mut record, "ao", "voxels_stepped", grid * fixture::COUNT);
        let Judgement::Closest(closest) = &mut trace_of(&mut record, "diffuse").judgement else { panic!() };
        closest.position_error.p50 = Some(error);
        record
    };
    let rows = [
        ("two-level", "0", 64, 0.98, 0.1, 5.0),
        ("two-level", "1024", 64, 0.975, 0.15, 5.0),
        ("voxels-only", "0", 64, 0.8, 4.0, 2.0),
        ("voxels-only", "0", 512, 0.95, 0.5, 16.0),
        ("voxels-only", "0", 1024, 0.97, 0.25, 33.0),
    ];
    rows.map(make).to_vec()
}

/// Voxels alone are compared with A-buffers of the same fineness, and their walk against the voxels that it visits.
#[test]
fn voxels_alone_are_compared() {
    let record = run_of(figure_9("a"));
    close(value("voxels_alone_ao_change", &record), -0.03);
    close(value("abuffer_position_error_over_voxels", &record), 0.6);
    close(value("voxel_walk_exponent", &record), 1.0);
    let mut better = record.clone();
    set_accuracy(&mut better.rows[3], "ao", 0.99);
    close(value("voxels_alone_ao_change", &better), 0.01);
    let few = run_of(record.rows[..3].to_vec());
    for name in ["voxels_alone_ao_change", "abuffer_position_error_over_voxels", "voxel_walk_exponent"] {
        assert!(values(name, &few).is_empty(), "{name}");
    }
}

/// A larger grid is compared with the usual one, mean of both bounces.
#[test]
fn a_large_grid_is_compared() {
    let with = |grid: u64, ms: [f64; 2]| {
        let mut record = abuffer("atrium", json!({ "grid": grid }));
        set_time(&mut record, "diffuse", ms[0]);
        set_time(&mut record, "bounce2", ms[1]);
        record
    };
    let record = run_of(vec![with(256, [30.0, 20.0]), with(64, [10.0, 20.0])]);
    close(value("large_grid_trace_over_usual", &record), 2.0);
    assert!(values("large_grid_trace_over_usual", &run_of(record.rows[..1].to_vec())).is_empty());
}
