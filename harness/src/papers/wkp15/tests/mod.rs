//! Quantities of the quadtree are what they say.

mod pages;
mod rays;

use std::collections::BTreeMap;

use serde_json::{Value, json};
use tracebench_api::Query;

use crate::papers::WKP15 as PAPER;
use crate::papers::fixture::{
    self, COUNT, close, config, count, frames_of, in_a_million, page_of, run_of, set_classes, set_time, trace_of,
};
use crate::papers::{PublishedTable, Verdict, judge_all};
use crate::results::{ImageRow, Judgement, PhaseRecord, Record, Row, WorkRow};

const SETS: [(&str, Query); 8] = [
    ("stereo", Query::Closest),
    ("temporal", Query::Closest),
    ("lens", Query::Closest),
    ("glossy", Query::Closest),
    ("glossy2", Query::Closest),
    ("glossy3", Query::Closest),
    ("specular", Query::Closest),
    ("light-field", Query::Closest),
];

fn contends(tracer: &str, scene: &str, parameters: Value) -> Row {
    config(tracer, scene, parameters, &[], &SETS)
}

/// The tracer with its values as published but for those given.
fn quadtree(scene: &str, parameters: Value) -> Row {
    let mut all = json!({
        "layers": 1, "views": "frame", "normals": "depth", "levels": 9, "gamma_norm": 3.0, "gamma_dist": 1e-5, "gamma_growth": 0.0,
        "dilated": "continuous", "traversal": "xor", "next_layer": "volumes", "inpainting": "one_layer", "secondary_samples": 0,
        "minimum_separation": 0.0, "back_faces": "kept",
    });
    for (name, value) in parameters.as_object().unwrap() {
        assert!(all.get(name).is_some(), "{name}");
        all[name] = value.clone();
    }
    contends("quadtree", scene, all)
}

fn values(name: &str, record: &Record) -> BTreeMap<String, f64> {
    fixture::values(&PAPER, name, record)
}

fn value(name: &str, record: &Record) -> f64 {
    fixture::value(&PAPER, name, record)
}

/// Says something of a row's rays otherwise than of the run's.
fn say(row: &mut Row, said: &[(&str, f64)]) {
    row.viewpoint.ray_parameters = said.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
}

/// Takes as long for every one of these sets.
fn timed(mut row: Row, sets: &[(&str, f64)]) -> Row {
    sets.iter().for_each(|(rays, ms)| set_time(&mut row, rays, *ms));
    row
}

/// Tables whose figures stood in a picture alone have none.
#[test]
fn lost_figures_are_named() {
    assert_eq!(fixture::lost(&PAPER), ["wkp15-figure14", "wkp15-figure15"]);
}

/// What the page of Figure 14 says of corners is what half a pixel's edge times the tangent of the usual angle is.
#[test]
fn angles_are_refused_by_distances_first() {
    let figure = PAPER.experiment("wkp15-figure14").unwrap();
    let said = figure.notes.iter().find(|note| note.contains("gamma_norm decides nothing")).unwrap();
    for edge in [512.0, 1600.0] {
        let corner = 0.5 / edge * 3.0_f64.to_radians().tan();
        assert!(corner > 1e-5 && said.contains(&format!("{corner:.1e}")), "{corner:.1e}: {said}");
    }
}

const SCENES: [&str; 3] = ["SPONZA", "LIVINGROOM", "SANMIGUEL"];

/// A column of a method's rows over that of another's, by scene.
fn ratios(table: &PublishedTable, column: &str, one: [&str; 2], other: [&str; 2]) -> String {
    let of = |scene: &str, [method, layers]: [&str; 2]| {
        table.value(&[("scene", scene), ("method", method), ("layers", layers)], column).unwrap()
    };
    SCENES.map(|scene| format!("{:.2}", of(scene, one) / of(scene, other))).join(", ")
}

/// What claims say of the paper's own tables is computed from these.
#[test]
fn claims_agree_with_tables_where_they_say_so() {
    let tables = &PAPER.published.tables;
    let table = |id: &str| tables.iter().find(|table| table.id == id).unwrap();
    let all = &PAPER.claims;
    let own = |id: &str| all.iter().find(|claim| claim.id == id).unwrap().own_figures.clone().unwrap();
    let says = |id: &str, figures: String| assert!(own(id).contains(&figures), "{id}: {figures} of {}", own(id));
    let (stereo, temporal) = (table("wkp15-table2"), table("wkp15-table3"));
    let [tree, two, dda, dda_two, field] =
        [["quad-tree", "1"], ["quad-tree", "2"], ["DDA", "1"], ["DDA", "2"], ["height field", "1"]];
    for (one, other) in [(dda, tree), (dda_two, two)] {
        says("wkp15-dda-stereo-ratio", ratios(stereo, "T_eye", one, other));
        says("wkp15-dda-stereo-ratio", ratios(stereo, "T_total", one, other));
        says("wkp15-dda-temporal-closer", ratios(stereo, "T_eye", one, other));
        says("wkp15-dda-temporal-closer", ratios(temporal, "T_syn", one, other));
    }
    says("wkp15-heightfield-ratio", ratios(stereo, "T_eye", field, tree));
    says("wkp15-heightfield-ratio", ratios(temporal, "T_syn", field, tree));
    says("wkp15-second-layer-cheap", ratios(stereo, "T_eye", two, tree));
    says("wkp15-sanmiguel-second-layer", ratios(temporal, "T_syn", two, tree));
    says("wkp15-inpaint-faster", ratios(stereo, "T_eye", tree, two));
    says("wkp15-second-layer-render", ratios(stereo, "T_ref", two, tree));
    let amortized = temporal.rows.iter().flatten().map(|row| {
        let of = |index: usize| row.values[index].unwrap();
        ((of(0) + 3.0 * of(1)) / 4.0 - of(3)).abs()
    });
    assert!(amortized.fold(0.0, f64::max) < 0.0101);
    let frames = |method: &str, layers: &str| {
        let rows = table("wkp15-table4").rows.iter().flatten();
        let own = rows.filter(|row| row.labels["method"] == method && row.labels["layers"] == layers);
        own.map(|row| {
            let of = |index: usize| row.values[index].unwrap();
            format!("{:.2}", 1000.0 / of(3) - of(0) - of(1))
        })
        .collect::<Vec<_>>()
        .join(", ")
    };
    ["1", "2"].iter().for_each(|layers| says("wkp15-fps-includes-build", frames("quad-tree", layers)));
    let reflections = table("wkp15-table5");
    let traced = |layers: &str, bounces: &str| {
        reflections.value(&[("layers", layers), ("N_p", "3"), ("N_s", "8"), ("N_b", bounces)], "T_rr").unwrap()
    };
    for layers in ["1", "2"] {
        says("wkp15-bounces-cost", format!("{:.2}", traced(layers, "3") / traced(layers, "1")));
        let of_samples = |samples: &str| {
            let labels = [("layers", layers), ("N_p", "3"), ("N_s", samples), ("N_b", "3")];
            reflections.value(&labels, "T_rr").unwrap()
        };
        says("wkp15-eight-samples-cost", format!("{:.2}", of_samples("8") / of_samples("4")));
    }
    says("wkp15-dda-two-layers", ratios(stereo, "T_eye", dda_two, dda));
}

/// Every claim is there, and those about the paper's own arithmetic are measured by nothing.
#[test]
fn all_claims_are_there() {
    let claims = &PAPER.claims;
    assert_eq!(claims.len(), 76);
    let unmeasured = |id: &str| claims.iter().find(|claim| claim.id == id).unwrap().table().is_none();
    for id in
        ["wkp15-level-cap", "wkp15-gpu-bvh-90", "wkp15-exact-on-planes", "wkp15-total-includes-build", "wkp15-dof-rate"]
    {
        assert!(unmeasured(id), "{id}");
    }
    assert!(!unmeasured("wkp15-dda-stereo-ratio"));
}

/// Table 1: a scene at a scale, one layer and two; milliseconds of the trees, of drawing, of copies.
fn table_1(scene: &str, scale: f64, ms: [f64; 3]) -> Vec<Row> {
    let make = |layers: u64| {
        let mut row = quadtree(scene, json!({ "layers": layers }));
        (row.scene.scale, row.scene.triangles) = (Some(scale), (1000.0 * scale) as u64);
        row.scene.sha256 = format!("{scene} {scale}");
        let nodes = [("nodes", 1000), ("plane_leaves", 300), ("boxes", 80), ("empty_nodes", 20)];
        row.structure_statistics =
            nodes.iter().map(|(name, count)| ((*name).to_owned(), (count * layers) as f64)).collect();
        let [trees, drawing, copies] = ms;
        set_phases(
            &mut row,
            &[
                ("draw layers", 0.75 * drawing),
                ("name triangles", 0.25 * drawing * layers as f64),
                ("bottom level", 0.5 * trees * layers as f64),
                ("merge level 1", 0.5 * trees * layers as f64),
                ("copies", copies),
            ],
        );
        row
    };
    vec![make(1), make(2)]
}

fn set_phases(row: &mut Row, phases: &[(&str, f64)]) {
    let rounds = row.build.times.samples_ms.len();
    let phase = |(name, ms): &(&str, f64)| PhaseRecord {
        name: (*name).to_owned(),
        median_ms: *ms,
        samples_ms: vec![*ms; rounds],
    };
    row.build.times.phases = phases.iter().map(phase).collect();
}

/// The construction is the tree's phases alone, over the triangles of a scene by name and of the one where it changes most; drawing and
/// copies are none of it. Scenes of one size tell nothing.
#[test]
fn construction_is_held_against_triangles() {
    let all =
        [table_1("a", 1.0, [2.0, 9.0, 1.0]), table_1("a", 15.5, [2.2, 90.0, 5.0]), table_1("b", 1.0, [3.0, 9.0, 1.0])];
    let record = run_of(all.concat());
    close(value("tree_time_of_most_triangles_over_fewest", &record), 1.1);
    let faster = run_of([&record.rows[..], &table_1("b", 15.5, [1.5, 9.0, 1.0])].concat());
    close(value("tree_time_of_most_triangles_over_fewest", &faster), 0.5);
    assert!(values("tree_time_of_most_triangles_over_fewest", &run_of(table_1("a", 1.0, [2.0, 9.0, 1.0]))).is_empty());
    let one = run_of(table_1("a", 1.0, [2.0, 8.0, 1.0]));
    close(value("tree_time_of_two_layers_over_one", &one), 2.0);
    close(value("drawing_two_layers_over_one", &one), 1.25);
}

/// Table 2 of a scene.
fn table_2(scene: &str) -> Vec<Row> {
    let row = |tracer: &str, layers: u64, ms: f64, footprint: f64, counters: &[(&str, u64)]| {
        let mut record = match tracer {
            "quadtree" => quadtree(scene, json!({ "layers": layers })),
            "screen-dda" => contends(tracer, scene, json!({ "layers": layers, "max_steps": 200 })),
            _ => contends(tracer, scene, json!({ "pyramid": "min-max" })),
        };
        set_time(&mut record, "stereo", ms);
        set_classes(&mut record, "stereo", [0, 0], footprint);
        counters.iter().for_each(|(name, of_ray)| count(&mut record, "stereo", name, of_ray * COUNT));
        record
    };
    let mut rows = vec![
        row("quadtree", 1, 10.0, 0.95, &[("nodes_visited", 12)]),
        row("quadtree", 2, 12.0, 0.97, &[("nodes_visited", 15)]),
        row("screen-dda", 1, 40.0, 0.94, &[("depth_samples", 60)]),
        row("screen-dda", 2, 72.0, 0.99, &[("depth_samples", 60)]),
        row("height-field", 1, 25.0, 0.9, &[("cells_visited", 16)]),
    ];
    count(&mut rows[1], "stereo", "rays_asking_layer_2", COUNT / 4);
    for (layers, cap, ms) in [(1, 4096, 80.0), (2, 4096, 120.0), (1, 64, 20.0), (2, 64, 36.0)] {
        let otherwise = contends("screen-dda", scene, json!({ "layers": layers, "max_steps": cap }));
        rows.push(timed(otherwise, &[("stereo", ms)]));
    }
    for (other, value, ms) in [("minimum_separation", json!(0.02), 13.0), ("back_faces", json!("culled"), 14.0)] {
        let mut parameters = json!({ "layers": 2 });
        parameters[other] = value;
        rows.push(timed(quadtree(scene, parameters), &[("stereo", ms)]));
    }
    let mut lossless = timed(quadtree(scene, json!({ "gamma_norm": 0.0, "gamma_dist": 0.0 })), &[("stereo", 11.0)]);
    count(&mut lossless, "stereo", "nodes_visited", 20 * COUNT);
    rows.push(lossless);
    for (discontinuity, build, ms) in [("keep", "raster", 15.0), ("cut", "raster", 99.0), ("keep", "compute", 30.0)] {
        let mesh = contends("mesh-warp", scene, json!({ "discontinuity": discontinuity, "build": build }));
        rows.push(timed(mesh, &[("stereo", ms)]));
    }
    rows
}

/// Peers stand beside as many layers, by time and by what they visit; without one of them there is no ratio.
#[test]
fn peers_stand_beside_as_many_layers() {
    let record = run_of(table_2("a"));
    close(value("height_field_time_over_quadtree", &record), 2.5);
    close(value("dda_time_over_quadtree", &record), 5.0);
    // 8 of one layer and 10 of two.
    close(value("uncapped_dda_time_over_quadtree", &record), 9.0);
    // 2 of one layer and 3 of two.
    close(value("scaled_cap_dda_time_over_quadtree", &record), 2.5);
    close(value("dda_second_layer_time", &record), 1.8);
    close(value("uncapped_dda_second_layer_time", &record), 1.5);
    close(value("scaled_cap_dda_second_layer_time", &record), 1.8);
    close(value("second_layer_time_in_stereo", &record), 1.2);
    close(value("separated_layer_time_in_stereo", &record), 1.3);
    close(value("front_face_layer_time_in_stereo", &record), 1.4);
    close(value("one_layer_time_over_two", &record), 10.0 / 12.0);
    close(value("nodes_visited_over_height_field", &record), 0.75);
    close(value("lossless_nodes_visited_over_height_field", &record), 1.25);
    // Two layers are the slower, and the mesh counts that is drawn in compute.
    close(value("mesh_time_over_quadtree", &record), 2.5);
    assert!(values("mesh_lead_where_detailed", &record).is_empty());
    let mut both = [table_2("atrium"), table_2("foliage")].concat();
    both.iter_mut().filter(|row| row.scene.name == "foliage" && row.tracer.name == "mesh-warp").for_each(|row| {
        set_time(row, "stereo", 12.0);
    });
    close(value("mesh_lead_where_detailed", &run_of(both)), 0.4);
    close(value("rays_asking_second_layer", &record), 0.25);
    let own = run_of(record.rows[..2].to_vec());
    for name in [
        "height_field_time_over_quadtree",
        "dda_time_over_quadtree",
        "nodes_visited_over_height_field",
        "uncapped_dda_time_over_quadtree",
        "scaled_cap_dda_time_over_quadtree",
        "separated_layer_time_in_stereo",
    ] {
        assert!(values(name, &own).is_empty(), "{name}");
    }
}

/// Times are ranked by the nodes that a search can reach, of one layer, over three scenes at least.
#[test]
fn time_is_ranked_by_nodes() {
    let scene = |name: &str, ms: f64, planes: f64| {
        let mut record = timed(quadtree(name, json!({})), &[("stereo", ms)]);
        let all = [("nodes", 9e9), ("plane_leaves", planes), ("boxes", 1.0), ("empty_nodes", 1.0)];
        record.structure_statistics = all.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect();
        record
    };
    let record = run_of(vec![scene("a", 1.0, 10.0), scene("b", 3.0, 30.0), scene("c", 2.0, 20.0)]);
    close(value("rank_of_time_by_nodes", &record), 1.0);
    let mut against = record.clone();
    set_time(&mut against.rows[1], "stereo", 0.5);
    close(value("rank_of_time_by_nodes", &against), -1.0 / 3.0);
    assert!(values("rank_of_time_by_nodes", &run_of(record.rows[..2].to_vec())).is_empty());
}

/// Table 5 of a scene: six faces of one layer and two, and the camera's view alone.
fn table_5() -> Vec<Row> {
    let row = |views: &str, layers: u64, ms: [f64; 3], off_view: u64| {
        let mut record = quadtree("a", json!({ "views": views, "layers": layers }));
        for (rays, ms) in ["glossy", "glossy2", "glossy3"].into_iter().zip(ms) {
            set_time(&mut record, rays, ms);
        }
        set_cause(&mut record, "glossy", "off_view", off_view);
        record
    };
    vec![
        row("six", 1, [10.0, 5.0, 4.0], 1),
        row("six", 2, [20.0, 12.0, 8.0], 1),
        row("frame", 1, [1.0; 3], 90),
        row("frame", 2, [1.0; 3], 81),
    ]
}

fn set_cause(row: &mut Row, rays: &str, cause: &str, wrong: u64) {
    set_causes(row, rays, &[(cause, wrong)]);
}

fn set_causes(row: &mut Row, rays: &str, causes: &[(&str, u64)]) {
    let Judgement::Closest(closest) = &mut trace_of(row, rays).judgement else { panic!("{rays} is any-hit") };
    let causes = causes.iter().map(|(cause, wrong)| ((*cause).to_owned(), *wrong)).collect();
    closest.causes.insert("footprint".to_owned(), causes);
}

/// Bounces add up, in as many layers; what one view does not hold is counted beyond what six faces do not.
#[test]
fn bounces_add_up() {
    let mut record = run_of(table_5());
    // 2, 2.4, 2.
    close(value("second_layer_time_of_reflections", &record), (2.0 + 2.4 + 2.0) / 3.0);
    record.rows.iter_mut().for_each(|one| one.traces.retain(|trace| trace.rays == "glossy"));
    close(value("one_view_off_view_beyond_cube", &record), in_a_million(80));
    assert!(values("second_layer_time_of_reflections", &record).is_empty());
}

/// Rows of Figures 14 and 15: angle, distance, growth, milliseconds of every set, reachable nodes, footprint agreement.
fn at_threshold(angle: f64, distance: f64, growth: f64, ms: f64, nodes: f64, footprint: f64) -> Row {
    let parameters = json!({ "gamma_norm": angle, "gamma_dist": distance, "gamma_growth": growth });
    let mut row = quadtree("a", parameters);
    row.traces.retain(|trace| ["stereo", "temporal", "lens"].contains(&trace.rays.as_str()));
    for rays in ["stereo", "temporal", "lens"] {
        set_time(&mut row, rays, ms);
        set_classes(&mut row, rays, [0, 0], footprint);
    }
    set_phases(&mut row, &[("bottom level", 1.0), ("merge level 1", nodes)]);
    let all = [("nodes", 9e9), ("plane_leaves", nodes), ("boxes", 0.0), ("empty_nodes", 0.0)];
    row.structure_statistics = all.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect();
    row
}

const DISTANCES: [f64; 5] = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1];
const ANGLES: [f64; 5] = [3.0, 8.0, 14.0, 20.0, 25.0];

fn figure_14() -> Vec<Row> {
    let step = |step: usize| (10.0 - step as f64, 900.0 - 100.0 * step as f64, 0.95 - 0.01 * step as f64);
    let over = |place: usize, angle: f64, distance: f64| {
        let (ms, nodes, footprint) = step(place);
        at_threshold(angle, distance, 0.0, ms, nodes, footprint)
    };
    let distances = DISTANCES.iter().enumerate().map(|(place, distance)| over(place, 3.0, *distance));
    let angles = ANGLES.iter().enumerate().skip(1).map(|(place, angle)| over(place, *angle, 1e-5));
    distances.chain(angles).chain([at_threshold(0.0, 0.0, 0.0, 12.5, 1000.0, 0.96)]).collect()
}

/// What larger distances do is ranked, the least of what falls and what rises; gains are of time, over lossless thresholds. Nodes are ranked
/// over angles where no distance is asked for.
#[test]
fn tolerances_are_traded() {
    let record = run_of(figure_14());
    close(value("min_trend_over_distances", &record), 1.0);
    close(value("usual_thresholds_save", &record), 20.0);
    close(value("rank_of_tree_time_by_nodes", &record), 41.0 / 45.0);
    let mut slower = record.clone();
    set_time(&mut slower.rows[1], "stereo", 11.0);
    close(value("min_trend_over_distances", &slower), 0.8);
    // Angles at the usual distance are no part of it.
    set_time(&mut slower.rows[5], "stereo", 99.0);
    close(value("min_trend_over_distances", &slower), 0.8);
    let few = run_of(record.rows[..4].to_vec());
    for name in ["min_trend_over_distances", "usual_thresholds_save", "node_trend_over_angles"] {
        assert!(values(name, &few).is_empty(), "{name}");
    }
    let over_angles = |nodes: [f64; 5]| {
        let alone = ANGLES.iter().zip(nodes).map(|(angle, nodes)| at_threshold(*angle, 1.0, 0.0, 1.0, nodes, 0.9));
        run_of(record.rows.iter().cloned().chain(alone).collect())
    };
    close(value("node_trend_over_angles", &over_angles([5.0, 4.0, 3.0, 2.0, 1.0])), 1.0);
    close(value("node_trend_over_angles", &over_angles([5.0; 5])), 0.0);
}

/// Thresholds that grow are compared with fixed ones of the same size, and the largest against lossless ones.
#[test]
fn growing_thresholds_are_held_against_fixed_ones() {
    let mut rows = Vec::new();
    for (place, (angle, distance)) in ANGLES.into_iter().zip(DISTANCES).enumerate() {
        let (ms, footprint) = (10.0 - place as f64, 0.95 - 0.02 * place as f64);
        rows.push(at_threshold(angle, distance, 0.0, ms, 1.0, footprint));
        rows.push(at_threshold(angle, distance, 16.0, 0.9 * ms, 1.0, footprint - 0.001 * place as f64));
    }
    rows.push(at_threshold(0.0, 0.0, 0.0, 12.0, 1.0, 0.96));
    let mut record = run_of(rows);
    set_time(&mut record.rows[1], "lens", 8.5);
    close(value("growing_thresholds_save_in_views", &record), 10.0);
    close(value("growing_thresholds_save_in_lens", &record), 15.0);
    // Another view, of which temporal rays alone count.
    let view = [(0.0, 10.0), (16.0, 7.0)].map(|(growth, ms)| at_threshold(3.0, 1e-5, growth, ms, 1.0, 0.9));
    let mut more = record.clone();
    more.rows.extend(view.map(|mut row| {
        say(&mut row, &[("temporal_shift_s", 0.0166667)]);
        row
    }));
    // 10 of stereo rays, 10 and 30 of temporal ones.
    close(value("growing_thresholds_save_in_views", &more), 15.0);
    close(value("growing_thresholds_save_in_lens", &more), 15.0);
    let fixed = run_of(record.rows.iter().step_by(2).cloned().collect());
    assert!(values("growing_thresholds_save_in_views", &fixed).is_empty());
}

/// PSNR is read from frames behind the first, of every effect: it falls over distances or it does not, and growing thresholds cost some or
/// much; where effects differ nothing is decided.
#[test]
fn images_are_read_from_frames() {
    let judged = |[normals, lit]: [f64; 2], lost: f64| {
        let at = |angle: f64, distance: f64, growth: f64| {
            quadtree("atrium", json!({ "gamma_norm": angle, "gamma_dist": distance, "gamma_growth": growth }))
        };
        let pairs = ANGLES.into_iter().zip(DISTANCES);
        let pairs = pairs.flat_map(|(angle, distance)| [0.0, 16.0].map(|growth| at(angle, distance, growth)));
        let rows = pairs.chain(DISTANCES[1..].iter().map(|distance| at(3.0, *distance, 0.0))).collect();
        let record = frames_of("wkp15-images", rows, &["normals", "primary"], |row, work, frame| {
            let fall = if work == "normals" { normals } else { lit };
            let value = |name: &str| row.tracer.parameters[name].as_f64().unwrap();
            let psnr = 30.0 - fall * value("gamma_dist").log10() - if value("gamma_growth") > 0.0 { lost } else { 0.0 };
            let psnr_db = Some(if frame == 0 { 90.0 } else { psnr });
            WorkRow { image: Some(ImageRow { psnr_db, ..ImageRow::default() }), ..WorkRow::default() }
        });
        let found = judge_all(&PAPER, std::slice::from_ref(&record));
        let of = |id: &str| found.iter().find(|each| each.claim.id == id).unwrap().clone();
        (of("wkp15-thresholds-psnr"), of("wkp15-adaptive-psnr"), page_of("wkp15-images", &record))
    };
    let (trend, growing, page) = judged([1.0; 2], 0.5);
    assert_eq!((trend.verdict, trend.median, growing.verdict), (Verdict::Holds, Some(1.0), Verdict::Holds));
    close(growing.median.unwrap(), 0.5);
    assert!(page.contains("| 35.00 | 35.00 |") && page.contains("| 34.50 | 34.50 |"), "{page}");
    let (trend, growing, _) = judged([-1.0; 2], 2.0);
    assert_eq!((trend.verdict, growing.verdict), (Verdict::DoesNotHold, Verdict::DoesNotHold));
    assert_eq!(judged([-1.0, 1.0], 0.5).0.verdict, Verdict::Undecided);
}
