//! Quantities of the fragment A-buffer are what they say.

mod pages;

use std::collections::BTreeMap;

use serde_json::{Value, json};
use tracebench_api::Query;

use crate::papers::Rows;
use crate::papers::VVP16 as PAPER;
use crate::papers::fixture::{
    self, close, config, count, in_a_million, run_of, set_build, set_bytes, set_classes, set_phase, set_time, trace_of,
};
use crate::papers::rows::has;
use crate::results::{Judgement, Record, Row};

const SETS: [(&str, Query); 6] = [
    ("diffuse", Query::Closest),
    ("bounce2", Query::Closest),
    ("ao", Query::Any),
    ("specular", Query::Closest),
    ("refraction", Query::Closest),
    ("pixel-random", Query::Closest),
];

fn abuffer(scene: &str, parameters: Value, statistics: &[(&str, f64)]) -> Row {
    config("fragment-abuffer", scene, parameters, statistics, &SETS)
}

fn values(name: &str, record: &Record) -> BTreeMap<String, f64> {
    fixture::values(&PAPER, name, record)
}

fn value(name: &str, record: &Record) -> f64 {
    fixture::value(&PAPER, name, record)
}

/// Tables whose figures stood in a picture alone have none.
#[test]
fn lost_figures_are_named() {
    assert_eq!(fixture::lost(&PAPER), ["vvp16-figure12"]);
}

/// A row is found by the values that it is about, whatever is set for all rows alike; what another value differs in is another
/// row, and so is another resolution. Numbers are compared as numbers.
#[test]
fn rows_differ_in_what_they_are_about_alone() {
    let with = |views: &str, layers: &str| {
        abuffer("a", json!({ "views": views, "layers": layers, "thickness": 0.0, "view_steps": 100 }), &[])
    };
    let mut coarse = with("seven", "one");
    coarse.viewpoint.face = 7;
    let record =
        run_of(vec![with("seven", "all"), coarse, with("six", "one"), with("seven", "one"), with("six", "all")]);
    let rows = Rows::of(&record);
    let of = |values: &[(&str, &str)]| {
        let found = fixture::like_first(&rows.scenes[0], "fragment-abuffer", values)?;
        Some(
            [&found.tracer.parameters["views"], &found.tracer.parameters["layers"]]
                .map(|value| value.as_str().unwrap()),
        )
    };
    assert_eq!(of(&[]), Some(["seven", "all"]));
    assert_eq!(of(&[("views", "six")]), Some(["six", "all"]));
    assert_eq!(of(&[("layers", "one")]), Some(["seven", "one"]));
    let one = fixture::like_first(&rows.scenes[0], "fragment-abuffer", &[("layers", "one")]).unwrap();
    assert_eq!(one.viewpoint.face, 256);
    assert_eq!(
        (of(&[("views", "frame")]), of(&[("thickness", "0"), ("view_steps", "100")])),
        (None, Some(["seven", "all"]))
    );
    assert!(has(one, "thickness", "0") && !has(one, "thickness", "0.5") && !has(one, "view_steps", "10"));
    assert_eq!(rows.scenes[0].by_resolution().len(), 2);
}

/// Bytes a pixel and a fragment of every storage, as Table 2 has them.
fn table_2(storage: &str, buckets: u64) -> [u64; 2] {
    match storage {
        "s-buffer" => [8, 8],
        "ll" => [4, 8],
        "dll" => [8, 12],
        "llb" => [8 + 4 * buckets, 8],
        _ => [8 + 8 * buckets, 12],
    }
}

/// What a ledger calls the words of pixels.
fn pixels_name(storage: &str) -> &'static str {
    match storage {
        "s-buffer" => "begins and counts",
        "ll" => "heads",
        "dll" => "heads and tails",
        "llb" => "depth bounds and heads",
        _ => "depth bounds, heads and tails",
    }
}

/// All storages as Table 2 has them, with as many pixels and fragments.
fn storages(pixels: u64, fragments: u64) -> Vec<Row> {
    let kinds = [("s-buffer", 4), ("ll", 4), ("dll", 4), ("llb", 4), ("llb", 8), ("dllb", 4), ("dllb", 8)];
    let make = |(storage, buckets): (&str, u64)| {
        let parameters = json!({ "storage": storage, "buckets": buckets, "decoupled": "on" });
        let mut record = abuffer("a", parameters, &[("pixels", pixels as f64), ("fragments", fragments as f64)]);
        let [of_pixel, of_fragment] = table_2(storage, buckets);
        set_bytes(
            &mut record,
            &[
                (pixels_name(storage), of_pixel * pixels),
                ("id buffer, view 1", of_fragment * (fragments / 2)),
                ("id buffer, view 2", of_fragment * (fragments - fragments / 2)),
                ("data buffer", 16 * fragments),
                ("depth pyramid", 12_345),
            ],
        );
        record
    };
    kinds.map(make).to_vec()
}

/// The ledger is compared with Table 2 part by part, what it does not count left out, views added up; more or fewer bytes of any
/// part show, and bytes of nodes that hold the data are no case of the table.
#[test]
fn bytes_are_those_of_table_2() {
    let record = run_of(storages(1000, 2500));
    close(value("abuffer_bytes_over_formula", &record), 1.0);
    close(value("dllb_beyond_llb_over_links", &record), 1.0);
    close(value("dllb_pixel_bytes_over_textures", &record), 1.0);
    close(value("dllb_id_node_bytes", &record), 12.0);
    // dll with 8 + 12 n against llb with 24 + 8 n, the data's 16 n and 12,345 on both sides.
    let expected = (8.0 + 28.0 * 2.5 + 12.345) / (24.0 + 24.0 * 2.5 + 12.345);
    close(value("largest_without_buckets_over_least_with", &record), expected);
    for (row, part, name) in [
        (0, 1, "abuffer_bytes_over_formula"),
        (5, 0, "dllb_pixel_bytes_over_textures"),
        (5, 2, "dllb_id_node_bytes"),
        (3, 1, "dllb_beyond_llb_over_links"),
        (2, 3, "largest_without_buckets_over_least_with"),
    ] {
        let mut wrong = record.clone();
        wrong.rows[row].memory.structure[part].used_bytes += 5000;
        assert!((value(name, &wrong) - value(name, &record)).abs() > 1e-3, "{name}");
    }
    let mut coupled = record.clone();
    for row in &mut coupled.rows {
        row.tracer.parameters.insert("decoupled".to_owned(), json!("off"));
    }
    assert!(values("abuffer_bytes_over_formula", &coupled).is_empty());
}

/// Table 1 of a scene: with and without skipping, 8 and 12 buckets.
fn table_1(scene: &str, fragments: f64, ms: f64) -> Vec<Row> {
    let make = |(skipping, buckets, factor): (&str, u64, f64)| {
        let parameters = json!({ "skip_bounds": skipping, "skip_buckets": skipping, "buckets": buckets });
        let mut row = abuffer(scene, parameters, &[("fragments", fragments), ("average_layers", 6.0)]);
        row.traces.truncate(3);
        set_time(&mut row, "diffuse", ms * factor);
        set_time(&mut row, "bounce2", 1.5 * ms * factor);
        set_build(&mut row, fragments / 1e4);
        set_phase(&mut row, "reorder", factor.recip());
        set_bytes(&mut row, &[("depth bounds, heads and tails", 8 + 8 * buckets)]);
        for (rays, visited, opened, tested) in
            [("diffuse", 1000, 50, 100), ("bounce2", 3000, 150, 450), ("ao", 10, 1, 1)]
        {
            count(&mut row, rays, "pixels_visited", visited);
            count(&mut row, rays, "pixels_opened", opened);
            count(&mut row, rays, "fragments_tested", tested);
            count(&mut row, rays, "views_entered", 20_000);
        }
        count(&mut row, "diffuse", "payloads_touched", fragments as u64 / 4);
        row
    };
    [("on", 4, 1.0), ("off", 4, 3.0), ("on", 8, 0.8), ("on", 12, 0.9)].map(make).to_vec()
}

/// Layers are those of pixels that are opened and two bounces are both sets together; skipping is compared with the row that
/// differs in it alone; a changed hit, another ray set and a missing counter show.
#[test]
fn table_1_is_made_of_counters_and_ratios() {
    let record = run_of(table_1("a", 4e6, 10.0));
    close(value("skipping_gain", &record), 3.0);
    close(value("two_bounces_over_one", &record), 2.5);
    close(value("layers_of_two_bounces_over_one", &record), (550.0 / 200.0) / 2.0);
    close(value("views_of_two_bounces_over_one", &record), 1.0);
    close(value("data_nodes_read", &record), 0.25);
    close(value("more_buckets_trace_where_deep", &record), 0.8);
    // 104 bytes over 40 with twelve buckets, 72 over 40 with eight; sorting 1 / 0.9 and 1 / 0.8.
    close(value("more_buckets_cost", &record), 1.0 / 0.9);
    close(value("same_hits_without_skipping", &record), 1.0);
    let mut other = record.clone();
    trace_of(&mut other.rows[1], "ao").hits_sha256 = "0".to_owned();
    close(value("same_hits_without_skipping", &other), 2.0 / 3.0);
    trace_of(&mut other.rows[1], "ao").rays_sha256 = "0".to_owned();
    close(value("same_hits_without_skipping", &other), 1.0);
    let mut uncounted = record.clone();
    trace_of(&mut uncounted.rows[0], "bounce2").counters.clear();
    assert!(values("layers_of_two_bounces_over_one", &uncounted).is_empty());
    assert!(values("views_of_two_bounces_over_one", &uncounted).is_empty());
    let mut shallow = record.clone();
    for record in &mut shallow.rows {
        record.structure_statistics.insert("average_layers".to_owned(), 4.0);
    }
    assert!(values("more_buckets_trace_where_deep", &shallow).is_empty());
    assert!(values("skipping_gain", &run_of(vec![record.rows[0].clone()])).is_empty());
}

/// Ranks are over scenes, three at least: 1 in order, -1 against it, a third of the pairs swapped a third.
#[test]
fn scenes_are_ranked() {
    let scenes = |ms: [f64; 3], opened: [u64; 3]| {
        let mut all = Vec::new();
        for (index, name) in ["a", "b", "c"].iter().enumerate() {
            let mut rows = table_1(name, 1e6 * (index + 1) as f64, ms[index]);
            count(&mut rows[0], "diffuse", "pixels_opened", opened[index]);
            all.extend(rows);
        }
        run_of(all)
    };
    close(value("rank_of_time_by_efficiency", &scenes([1.0, 2.0, 3.0], [10, 20, 30])), -1.0);
    close(value("rank_of_time_by_efficiency", &scenes([3.0, 2.0, 1.0], [10, 20, 30])), 1.0);
    close(value("rank_of_time_by_efficiency", &scenes([1.0, 3.0, 2.0], [10, 20, 30])), -1.0 / 3.0);
    let mut record = scenes([1.0, 2.0, 3.0], [10, 20, 30]);
    close(value("rank_of_build_by_fragments", &record), 1.0);
    for one in record.rows.iter_mut().filter(|row| row.scene.name == "c") {
        set_build(one, 1.0);
    }
    close(value("rank_of_build_by_fragments", &record), -1.0 / 3.0);
    record.rows.retain(|row| row.scene.name != "c");
    assert!(values("rank_of_build_by_fragments", &record).is_empty());
}

/// Beside hierarchies ratios are by the host's clock, the better hierarchy counts, and what repays nothing is no break-even.
#[test]
fn hierarchies_stand_beside() {
    let row = |tracer: &str, build: f64, ms: f64, footprint: f64| {
        let mut record = config(tracer, "a", json!({}), &[], &SETS);
        set_build(&mut record, build);
        set_time(&mut record, "diffuse", ms);
        set_classes(&mut record, "diffuse", [0, 0], footprint);
        record
    };
    let abuffer = || row("fragment-abuffer", 10.0, 36.0, 0.9);
    let record = run_of(vec![abuffer(), row("ploc-gpu", 148.0, 18.0, 1.0), row("bvh-gpu", 2183.0, 16.0, 1.0)]);
    close(value("device_bvh_build_over_abuffer", &record), 14.8);
    close(value("bvh_build_over_abuffer", &record), 218.3);
    close(value("abuffer_trace_over_device_bvh", &record), 2.0);
    close(value("abuffer_trace_over_bvh", &record), 2.25);
    close(value("min_bvh_total_over_abuffer", &record), 166.0 / 46.0);
    close(value("break_even_samples", &record), 138.0 / 18.0);
    let mut thick = abuffer();
    set_classes(&mut thick, "diffuse", [0, 0], 0.97);
    thick.tracer.parameters.insert("thickness".to_owned(), json!(1.0));
    close(value("abuffer_footprint_agreement", &record), 0.9);
    close(value("abuffer_footprint_agreement", &run_of([record.rows, vec![thick]].concat())), 0.97);
    for (build, ms) in [(5.0, 18.0), (148.0, 40.0), (5.0, 40.0)] {
        close(value("break_even_samples", &run_of(vec![abuffer(), row("ploc-gpu", build, ms, 1.0)])), 0.0);
    }
    assert!(values("device_bvh_build_over_abuffer", &run_of(vec![abuffer()])).is_empty());
}

/// Figure 12 of a scene: plain 6 ms, decoupled as given first, with skipping as given second, times a factor a storage.
pub(in crate::papers) fn variants(scene: &str, [decoupled, skipping]: [f64; 2]) -> Vec<Row> {
    let mut all = Vec::new();
    for (storage, factor) in [("s-buffer", 1.0), ("ll", 2.0), ("dll", 1.5), ("llb", 0.9), ("dllb", 0.5)] {
        for (values, ms) in [(["off", "off"], 6.0), (["on", "off"], decoupled), (["on", "on"], skipping)] {
            let [decoupled, skipping] = values;
            let parameters = json!({
                "storage": storage, "decoupled": decoupled, "skip_bounds": skipping, "skip_buckets": skipping,
            });
            let counts = [("fragments", 1e6), ("pixels", 100.0), ("covered_pixels", 80.0)];
            let mut record = abuffer(scene, parameters, &counts);
            set_time(&mut record, "pixel-random", ms * factor);
            set_build(&mut record, if values[0] == "on" { 8.5 * (1.0 + factor) } else { 10.0 * (1.0 + factor) });
            all.push(record);
        }
    }
    all
}

/// Gains are of speed and means over storages, each against the row that differs in one step; a missing storage is no figure.
#[test]
fn variants_are_compared_step_by_step() {
    let record = run_of(variants("a", [4.0, 1.0]));
    close(value("decoupling_gain", &record), 50.0);
    close(value("skipping_gain_of_variants", &record), 300.0);
    close(value("decoupling_build_gain", &record), 15.0);
    close(value("slowest_build_over_fastest", &record), 3.0 / 1.5);
    close(value("bucketed_over_others", &record), 0.7 / 1.5);
    close(value("dllb_over_fastest_other", &record), 0.5 / 0.9);
    close(value("covered_pixels_share", &record), 0.8);
    let mut slower = record.clone();
    // dll with skipping alone.
    set_time(&mut slower.rows[8], "pixel-random", 6.0);
    close(value("decoupling_gain", &slower), 50.0);
    close(value("skipping_gain_of_variants", &slower), 100.0 * ((4.0 * 4.0 + 1.0) / 5.0 - 1.0));
    let lacking = run_of(record.rows[..12].to_vec());
    for name in ["decoupling_gain", "skipping_gain_of_variants", "bucketed_over_others", "dllb_over_fastest_other"] {
        assert!(values(name, &lacking).is_empty(), "{name}");
    }
}

/// A speed-up is exponential if its logarithm grows evenly with the fragments; one that bends, falls or has two scenes is told.
#[test]
fn exponential_gains_are_told() {
    let scenes = |speedups: &[f64]| {
        let mut all = Vec::new();
        for (index, speedup) in speedups.iter().enumerate() {
            let mut own = variants(&format!("scene {index}"), [1.0, 1.0 / speedup]);
            for row in &mut own {
                row.structure_statistics.insert("fragments".to_owned(), 1e6 * (index + 1) as f64);
            }
            all.extend(own);
        }
        run_of(all)
    };
    close(value("skipping_speedup_evenness", &scenes(&[2.0, 4.0, 8.0])), 1.0);
    close(value("skipping_speedup_evenness", &scenes(&[2.0, 4.0, 64.0])), 0.25);
    close(value("skipping_speedup_evenness", &scenes(&[2.0, 4.0, 2.0])), -1.0);
    close(value("skipping_speedup_evenness", &scenes(&[8.0, 4.0, 2.0])), 0.0);
    assert!(values("skipping_speedup_evenness", &scenes(&[2.0, 4.0])).is_empty());
}

/// The table over views and layers: base first, at three resolutions.
fn views() -> Vec<Row> {
    let base = json!({
        "views": "seven", "layers": "all", "march": "steps", "view_steps": 100, "bounds": "geometry", "centre": "pulled_back",
        "storage": "dllb", "binary_search_above": 16, "thickness": 0.0, "thickness_in": "diagonals",
    });
    // What differs, times of diffuse and ao, footprint agreement, fragments, factors on ray image and faces.
    let rows = [
        (json!({}), [8.0, 12.0], 0.90, 1000.0, [1.0, 1.0]),
        (json!({ "layers": "one" }), [4.0, 8.0], 0.80, 300.0, [1.0, 1.0]),
        (json!({ "views": "six" }), [7.0, 11.0], 0.89, 1020.0, [1.0, 1.0]),
        (json!({ "views": "frame" }), [2.0, 4.0], 0.50, 200.0, [1.0, 1.0]),
        (json!({ "views": "frame", "layers": "one" }), [1.6, 2.0], 0.45, 60.0, [1.0, 1.0]),
        (json!({ "march": "pixels" }), [16.0, 1.0], 0.95, 1000.0, [1.0, 1.0]),
        (json!({ "march": "hi-z" }), [10.0, 1.0], 0.95, 1000.0, [1.0, 1.0]),
        (json!({ "view_steps": 25 }), [3.0, 1.0], 0.70, 1000.0, [1.0, 1.0]),
        (json!({ "bounds": "boxes" }), [8.0, 1.0], 0.90, 1000.0, [1.0, 1.0]),
        (json!({ "views": "six", "centre": "eye" }), [8.0, 1.0], 0.90, 1000.0, [1.0, 1.0]),
        (json!({ "storage": "s-buffer" }), [9.0, 1.0], 0.90, 1000.0, [1.0, 1.0]),
        (json!({ "storage": "s-buffer", "binary_search_above": 0 }), [12.0, 1.0], 0.90, 1000.0, [1.0, 1.0]),
        (json!({ "storage": "s-buffer", "binary_search_above": 64 }), [10.0, 1.0], 0.90, 1000.0, [1.0, 1.0]),
        (json!({ "storage": "s-buffer", "binary_search_above": 1_048_576 }), [11.0, 1.0], 0.90, 1000.0, [1.0, 1.0]),
        (json!({ "thickness": 1.0, "thickness_in": "pixels" }), [8.0, 1.0], 0.97, 1000.0, [1.0, 1.0]),
        (json!({}), [8.0, 1.0], 0.93, 4000.0, [1.0, 2.0]),
        (json!({ "views": "six" }), [8.0, 1.0], 0.935, 4000.0, [1.0, 2.0]),
        (json!({ "march": "pixels" }), [2.0, 1.0], 0.90, 250.0, [0.5, 0.5]),
        (json!({ "thickness": 1.0, "thickness_in": "pixels" }), [2.0, 1.0], 0.94, 250.0, [0.5, 0.5]),
    ];
    let make =
        |(changed, [diffuse, ao], footprint, fragments, [image, faces]): (Value, [f64; 2], f64, f64, [f64; 2])| {
            let mut parameters = base.clone();
            parameters.as_object_mut().unwrap().extend(changed.as_object().unwrap().clone());
            let mut row = abuffer("a", parameters, &[("fragments", fragments), ("pixels", fragments)]);
            set_time(&mut row, "diffuse", diffuse);
            set_time(&mut row, "ao", ao);
            set_classes(&mut row, "diffuse", [0, 0], footprint);
            set_bytes(&mut row, &[("id buffer", 12 * fragments as u64)]);
            set_phase(&mut row, "depth bounds", 4.0);
            row.viewpoint.ray_image = [512.0, 256.0].map(|edge| (edge * image) as u32);
            row.viewpoint.frame = row.viewpoint.ray_image;
            row.viewpoint.face = (256.0 * faces) as u32;
            row.traces.iter_mut().for_each(|trace| trace.count = (trace.count as f64 * image * image) as u64);
            row
        };
    rows.map(make).to_vec()
}

/// Views, layers, marches, resolutions, centres and limits are each compared with the row that differs in it alone, at its own
/// resolution.
#[test]
fn views_and_layers_are_told_apart() {
    let mut record = run_of(views());
    for (name, expected) in [
        ("seven_views_over_one", f64::midpoint(4.0, 3.0)),
        ("all_layers_over_one", 1.25),
        ("steps_over_hi_z", 0.8),
        ("sparse_steps_agreement_change", 0.70 - 0.95),
        ("half_resolution_agreement_change", 0.94 - 0.97),
        ("fragments_beyond_centres_in_eye", 2.0),
        ("camera_view_agreement_change", -0.01),
        ("camera_view_agreement_change_fine", 0.005),
        ("halving_above_16_over_best", 0.9),
        // Bytes are linear in pixels; a ray takes twice the time at twice the edge: 16 ms of four times the rays of 2 ms.
        ("resolution_exponent", 1.0),
    ] {
        let found = value(name, &record);
        assert!((found - expected).abs() < 1e-9, "{name}: {found}, not {expected}");
    }
    set_phase(&mut record.rows[8], "depth bounds", 1.0);
    close(value("bounds_of_boxes_over_geometry", &record), 0.25);
    set_time(&mut record.rows[5], "diffuse", 8.0);
    close(value("resolution_exponent", &record), 0.0);
    let base = run_of(record.rows[..15].to_vec());
    for name in ["half_resolution_agreement_change", "camera_view_agreement_change_fine", "resolution_exponent"] {
        assert!(values(name, &base).is_empty(), "{name}");
    }
    let no_peers = run_of(record.rows[..1].to_vec());
    for name in ["seven_views_over_one", "all_layers_over_one", "fragments_beyond_centres_in_eye", "steps_over_hi_z"] {
        assert!(values(name, &no_peers).is_empty(), "{name}");
    }
}

/// Rays lost by fewer views or layers are counted over their own sets, those outside of the views by the judge's cause.
#[test]
fn losses_by_views_and_layers() {
    let mut record = run_of(views());
    set_classes(&mut record.rows[3], "diffuse", [700, 0], 0.5);
    close(value("one_view_false_misses_beyond", &record), in_a_million(700) / 5.0);
    // Mirrored and refracted rays alone count for layers.
    set_classes(&mut record.rows[1], "diffuse", [9000, 0], 0.5);
    close(value("one_layer_false_misses_beyond", &record), 0.0);
    set_classes(&mut record.rows[1], "refraction", [60, 0], 0.5);
    close(value("one_layer_false_misses_beyond", &record), in_a_million(60) / 2.0);
    close(value("off_view_rays_of_six_faces", &record), 0.0);
    let Judgement::Closest(closest) = &mut trace_of(&mut record.rows[2], "diffuse").judgement else { panic!() };
    closest.causes.get_mut("tight").unwrap().insert("off_view".to_owned(), 10);
    close(value("off_view_rays_of_six_faces", &record), in_a_million(10) / 5.0);
    let mut cube = record.rows[2].clone();
    "quadtree".clone_into(&mut cube.tracer.name);
    let Judgement::Closest(closest) = &mut trace_of(&mut cube, "diffuse").judgement else { panic!() };
    closest.causes.insert("tight".to_owned(), BTreeMap::from([("hidden_layer".to_owned(), 30)]));
    assert!(values("hidden_rays_of_two_layers", &record).is_empty());
    close(value("hidden_rays_of_two_layers", &run_of(vec![cube])), in_a_million(30) / 5.0);
    assert!(values("views_asked_for_at_a_switch", &record).is_empty());
    // The first of six faces is no switch: three views a ray are two switches, which ask for three.
    for (set, _) in SETS {
        count(&mut record.rows[2], set, "views_entered", 3 * fixture::COUNT);
        count(&mut record.rows[2], set, "views_tested", 9 * fixture::COUNT);
    }
    close(value("views_asked_for_at_a_switch", &record), 1.5);
}
