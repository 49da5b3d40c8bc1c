//! Quantities over steps that are about rays: the camera's way, rays through a lens, cameras, displacement.

use serde_json::json;

use super::{contends, quadtree, say, set_cause, set_causes, timed, value, values};
use crate::papers::Rows;
use crate::papers::fixture::{
    COUNT, close, count, in_a_million, like_first, run_of, set_build, set_classes, set_time, trace_of,
};
use crate::results::{Judgement, Record, Row};

/// One layer and two of both marching methods, and the height field, in a part of Table 3.
fn part_of_table_3(scene: &str, shift: f64, own: [f64; 2], temporal: [f64; 2]) -> Vec<Row> {
    let mut rows = Vec::new();
    for (layers, own, temporal) in [(1, own[0], temporal[0]), (2, own[1], temporal[1])] {
        rows.push(timed(quadtree(scene, json!({ "layers": layers })), &[("stereo", 10.0), ("temporal", own)]));
        let peer = contends("screen-dda", scene, json!({ "layers": layers, "max_steps": 500 }));
        rows.push(timed(peer, &[("stereo", 50.0), ("temporal", temporal)]));
    }
    rows.push(contends("height-field", scene, json!({})));
    // Without a cap temporal rays take twice as long as stereo rays, with a low one as long.
    for (layers, cap, temporal) in [(1, 4096, 100.0), (2, 4096, 100.0), (1, 160, 50.0), (2, 160, 50.0)] {
        let peer = contends("screen-dda", scene, json!({ "layers": layers, "max_steps": cap }));
        rows.push(timed(peer, &[("stereo", 50.0), ("temporal", temporal)]));
    }
    rows.iter_mut().for_each(|row| say(row, &[("temporal_shift_s", shift)]));
    rows
}

/// Leads are taken part by part and then their mean; a second layer of the detailed scene is compared with the costliest of the others.
#[test]
fn leads_are_of_every_view() {
    let scene = |name: &str, second: f64| {
        let near = part_of_table_3(name, 0.01, [10.0, 10.0 * second], [20.0, 20.0 * second]);
        [near, part_of_table_3(name, 0.02, [10.0, 10.0 * second], [40.0, 40.0 * second])].concat()
    };
    let record = run_of(scene("a", 1.2));
    // 2 and 4 over 5.
    close(value("dda_lead_in_temporal_over_stereo", &record), 0.6);
    // 10 over 5 of one layer, 10 / 1.2 over 5 of two.
    close(value("uncapped_dda_lead_in_temporal_over_stereo", &record), (10.0 + 10.0 / 1.2) / 10.0);
    close(value("scaled_cap_dda_lead_in_temporal_over_stereo", &record), (5.0 + 5.0 / 1.2) / 10.0);
    let all = run_of([scene("atrium", 1.2), scene("foliage", 1.8), scene("room", 1.1)].concat());
    close(value("second_layer_time_where_detailed", &all), 1.5);
    assert!(values("second_layer_time_where_detailed", &record).is_empty());
    let mut hidden = record.clone();
    let is_field = |one: &&mut Row| one.tracer.name == "height-field";
    for (one, wrong) in hidden.rows.iter_mut().filter(is_field).zip([7, 9]) {
        set_cause(one, "temporal", "hidden_layer", wrong);
    }
    close(value("height_field_hidden_rays", &hidden), in_a_million(9));
}

/// A row of Table 4: so many rays a pixel and samples beside a ray, at a size of the image.
fn through_lens(tracer: &str, layers: u64, rays: u64, samples: u64, size: [u32; 2], ms: f64) -> Row {
    let mut row = match tracer {
        "quadtree" => quadtree("a", json!({ "layers": layers, "secondary_samples": samples })),
        _ => contends(tracer, "a", json!({ "layers": layers, "max_steps": 25 })),
    };
    row.viewpoint.ray_image = size;
    say(&mut row, &[("lens_count", rays as f64)]);
    set_time(&mut row, "lens", ms);
    set_time(&mut row, "stereo", if tracer == "quadtree" { 1.0 } else { 10.0 });
    set_build(&mut row, if tracer == "quadtree" { 30.0 } else { 20.0 });
    row
}

fn table_4() -> Vec<Row> {
    let (whole, half) = ([512, 256], [256, 128]);
    let mut rows = Vec::new();
    for layers in [1, 2] {
        let own = |rays, samples, size, ms| through_lens("quadtree", layers, rays, samples, size, ms);
        rows.extend([own(4, 0, whole, 10.0), own(4, 3, whole, 12.0), own(4, 7, whole, 15.0)]);
        rows.push(through_lens("screen-dda", layers, 4, 0, whole, 30.0));
        rows.extend([own(8, 0, whole, 20.0), own(8, 3, whole, 24.0)]);
        rows.push(through_lens("screen-dda", layers, 8, 0, whole, 40.0));
        rows.extend([own(8, 0, half, 5.0), own(32, 0, half, 19.5)]);
        for (rays, cap, ms) in [(4, 4096, 60.0), (8, 4096, 60.0), (4, 8, 20.0), (8, 8, 20.0)] {
            let mut otherwise = through_lens("screen-dda", layers, rays, 0, whole, ms);
            otherwise.tracer.parameters.insert("max_steps".to_owned(), json!(cap));
            rows.push(otherwise);
        }
    }
    let mut holes = through_lens("quadtree", 1, 8, 0, whole, 16.0);
    holes.tracer.parameters.insert("inpainting".to_owned(), json!("never"));
    rows.push(holes);
    for (parameter, value) in [("minimum_separation", json!(0.02)), ("back_faces", json!("culled"))] {
        let mut other = through_lens("quadtree", 2, 8, 0, whole, 20.0);
        other.tracer.parameters.insert(parameter.to_owned(), value);
        rows.push(other);
    }
    rows
}

/// Rays a pixel are told by what was said of the rows' rays, many of them at half of each edge; builds eat what traces lead by.
#[test]
fn rays_through_a_lens_are_told_apart() {
    let mut record = run_of(table_4());
    close(value("three_more_samples_cost", &record), 20.0);
    close(value("half_the_rays_with_samples_save", &record), 25.0);
    close(value("rays_32_over_8", &record), 3.9);
    // With 4 rays 50 over 40 of 3, with 8 60 over 50 of 2.
    close(value("dda_lead_with_build_over_without", &record), (1.25 / 3.0 + 1.2 / 2.0) / 2.0);
    // 3 and 2 over 10, without a cap 6 and 3.
    close(value("dda_lead_in_lens_over_stereo", &record), 0.25);
    close(value("uncapped_dda_lead_in_lens_over_stereo", &record), 0.45);
    close(value("uncapped_dda_lead_with_build_over_without", &record), (80.0 / 40.0 / 6.0 + 80.0 / 50.0 / 3.0) / 2.0);
    // 2 and 1 over 10.
    close(value("scaled_cap_dda_lead_in_lens_over_stereo", &record), 0.15);
    close(value("scaled_cap_dda_lead_with_build_over_without", &record), f64::midpoint(40.0 / 40.0 / 2.0, 40.0 / 50.0));
    close(value("inpainted_lens_time_over_holes", &record), 1.25);
    for one in record.rows.iter_mut().filter(|one| one.tracer.parameters["layers"] == 2) {
        let most = one.viewpoint.ray_parameters["lens_count"] == 8.0;
        count(one, "lens", "hits_behind_layer_1", if most { COUNT / 8 } else { COUNT / 16 });
    }
    close(value("lens_rays_behind_first_layer", &record), 0.125);
    for (name, parameter, rays) in [
        ("lens_rays_behind_first_layer_separated", "minimum_separation", COUNT / 4),
        ("lens_rays_behind_first_layer_of_front_faces", "back_faces", COUNT / 2),
    ] {
        let plain = record.rows[0].tracer.parameters[parameter].clone();
        let other = record
            .rows
            .iter_mut()
            .find(|one| one.tracer.name == "quadtree" && one.tracer.parameters[parameter] != plain);
        count(other.unwrap(), "lens", "hits_behind_layer_1", rays);
        close(value(name, &record), rays as f64 / COUNT as f64);
    }
    let few =
        run_of(record.rows.iter().filter(|one| one.viewpoint.ray_parameters["lens_count"] == 4.0).cloned().collect());
    for name in ["three_more_samples_cost", "half_the_rays_with_samples_save", "rays_32_over_8"] {
        assert!(values(name, &few).is_empty(), "{name}");
    }
}

/// The part of a run whose rays were made by the run's own words is found by these, one with words of its own by its own.
#[test]
fn parts_are_told_by_their_rays() {
    let mut rows = vec![quadtree("a", json!({ "layers": 1 })), quadtree("a", json!({ "layers": 2 }))];
    say(&mut rows[1], &[("light_field_cameras", 16.0)]);
    let mut record = run_of(rows);
    record.ray_parameters.insert("light_field_cameras".to_owned(), json!(4));
    let rows = Rows::of(&record);
    let scene = &rows.scenes[0];
    assert_eq!(scene.by_resolution().len(), 2);
    let of = |cameras: &str| scene.of_rays(&[("light_field_cameras", cameras)]).rows.len();
    assert_eq!([of("4"), of("16"), of("8")], [1, 1, 0]);
    // A row is like the first of its own part alone.
    assert!(like_first(scene, "quadtree", &[("layers", "2")]).is_none());
}

/// A light field is compared with the fastest hierarchy, many cameras against few.
#[test]
fn light_fields_are_compared() {
    let row = |tracer: &str, cameras: f64, ms: f64| {
        let record = match tracer {
            "quadtree" => quadtree("a", json!({})),
            _ => contends(tracer, "a", json!({})),
        };
        let mut record = timed(record, &[("light-field", ms)]);
        say(&mut record, &[("light_field_cameras", cameras)]);
        record
    };
    let rows = vec![
        row("quadtree", 4.0, 10.0),
        row("ploc-gpu", 4.0, 40.0),
        row("bvh-gpu", 4.0, 36.0),
        row("quadtree", 16.0, 11.0),
        row("bvh-gpu", 16.0, 1.0),
    ];
    let mut record = run_of(rows);
    close(value("hierarchy_time_over_quadtree", &record), 3.6);
    close(value("many_cameras_time_over_few", &record), 1.1);
    trace_of(&mut record.rows[3], "light-field").count += 1;
    assert!(values("many_cameras_time_over_few", &record).is_empty());
}

/// Rows of a part of the text's table, all with both ray sets.
fn part_of_text(said: &[(&str, f64)], rows: Vec<Row>) -> Vec<Row> {
    let mut rows = rows;
    for row in &mut rows {
        row.traces.retain(|trace| ["stereo", "temporal"].contains(&trace.rays.as_str()));
        say(row, said);
    }
    rows
}

const NEAR: [(&str, f64); 2] = [("stereo_offset", 0.032), ("temporal_shift_s", 0.05)];
const FARTHEST: [(&str, f64); 2] = [("stereo_offset", 0.512), ("temporal_shift_s", 1.0)];

/// A row of it that takes as long for both sets.
fn of_text(parameters: serde_json::Value, ms: f64) -> Row {
    timed(quadtree("a", parameters), &[("stereo", ms), ("temporal", ms)])
}

/// The first part: every row beside two layers as published.
fn near() -> Vec<Row> {
    let with = |name: &str, value: serde_json::Value, ms: f64| {
        let mut parameters = json!({ "layers": 2 });
        parameters[name] = value;
        of_text(parameters, ms)
    };
    let mut rows = vec![
        of_text(json!({ "layers": 2 }), 10.0),
        of_text(json!({ "layers": 1 }), 8.0),
        of_text(json!({ "layers": 3 }), 12.0),
        of_text(json!({ "layers": 4 }), 12.6),
        with("traversal", json!("stack"), 12.5),
        with("normals", json!("geometry"), 10.0),
        with("dilated", json!("none"), 10.0),
        with("dilated", json!("flagged"), 10.0),
        with("next_layer", json!("always"), 15.0),
        timed(contends("screen-dda", "a", json!({ "layers": 1 })), &[("stereo", 20.0), ("temporal", 20.0)]),
    ];
    set_build(&mut rows[3], 63.0);
    rows.iter_mut().for_each(|row| set_classes(row, "temporal", [0, 0], 0.9));
    for (row, missed, footprint) in [(0, 10, 0.95), (5, 10, 0.96), (6, 60, 0.95), (7, 20, 0.95)] {
        set_classes(&mut rows[row], "stereo", [missed, 0], footprint);
    }
    count(&mut rows[1], "stereo", "nodes_visited", 10 * COUNT);
    count(&mut rows[9], "stereo", "depth_samples", 20 * COUNT);
    let Judgement::Closest(closest) = &mut trace_of(&mut rows[9], "temporal").judgement else { panic!() };
    closest.agreement.hit_miss = Some(closest.agreement.hit_miss.unwrap() - 0.03);
    part_of_text(&NEAR, rows)
}

/// The last part: two layers by separation, one layer with its holes, DDA.
fn farthest() -> Vec<Row> {
    let mut rows = vec![
        of_text(json!({ "layers": 2 }), 25.0),
        of_text(json!({ "layers": 1 }), 12.0),
        of_text(json!({ "layers": 2, "minimum_separation": 0.02 }), 25.0),
        of_text(json!({ "layers": 1, "inpainting": "never" }), 12.0),
        timed(contends("screen-dda", "a", json!({ "layers": 1 })), &[("stereo", 80.0), ("temporal", 80.0)]),
        contends("height-field", "a", json!({})),
    ];
    // Rays that leave the view are none of those that a second layer could hold.
    for (row, hidden, left_out, off_view) in [(0, 50, 20, 7), (1, 1, 0, 7), (2, 10, 30, 900), (3, 100, 0, 7)] {
        let causes = [("hidden_layer", hidden), ("left_out", left_out), ("off_view", off_view)];
        set_causes(&mut rows[row], "temporal", &causes);
    }
    rows[2].tracer.changed = vec!["minimum_separation".to_owned()];
    let Judgement::Closest(closest) = &mut trace_of(&mut rows[5], "temporal").judgement else { panic!() };
    (closest.classes.footprint.early, closest.classes.footprint.late) = (30, 10);
    count(&mut rows[1], "stereo", "nodes_visited", 15 * COUNT);
    count(&mut rows[4], "stereo", "depth_samples", 80 * COUNT);
    part_of_text(&FARTHEST, rows)
}

fn text() -> Record {
    run_of([near(), farthest()].concat())
}

/// What the first part varies is compared with two layers as published.
#[test]
fn rows_are_held_against_two_layers() {
    let mut record = text();
    close(value("traversal_without_stack_saves", &record), 20.0);
    close(value("four_layers_time_over_three", &record), 1.05);
    close(value("all_layers_time_over_cascade", &record), 1.5);
    close(value("build_of_four_layers_over_eyes", &record), 2.5);
    close(value("geometry_normals_agreement_change", &record), 0.0);
    close(value("undilated_false_misses_beyond", &record), in_a_million(50) / 2.0);
    close(value("undilated_false_misses_beyond_flagged", &record), in_a_million(40) / 2.0);
    let beyond =
        super::PAPER.quantity("undilated_false_misses_beyond").unwrap().values(&super::PAPER, &Rows::of(&record));
    let [low, high] = beyond[0].1.interval;
    assert!(low < beyond[0].1.value && beyond[0].1.value < high, "{low} {high}");
    close(value("dda_hit_miss_change", &record), -0.03);
    close(value("rays_given_up", &record), 0.0);
    assert!(values("answered_as_through_all_layers", &record).is_empty());
    for (rays, same) in [("stereo", COUNT / 2), ("temporal", COUNT / 4)] {
        trace_of(&mut record.rows[8], rays).same_as_first = Some(same);
    }
    close(value("answered_as_through_all_layers", &record), 0.25);
    let statuses = &mut trace_of(&mut record.rows[1], "stereo").statuses;
    statuses.insert("step_cap".to_owned(), 3);
    statuses.insert("thickness_rejected".to_owned(), 5);
    let far = run_of(farthest());
    assert!(value("rays_given_up", &record) > 0.0);
    for name in ["traversal_without_stack_saves", "undilated_false_misses_beyond", "dda_hit_miss_change"] {
        assert!(values(name, &far).is_empty(), "{name}");
    }
}

/// What grows from near to far: the time of two layers; and of rays that one layer does not hold, though the
/// view shows them, the share that the best second layer holds, by its name.
#[test]
fn displacement_is_held_against_near() {
    let mut record = text();
    close(value("displaced_time_over_near", &record), 2.5);
    let found = values("recovered_by_second_layer", &record);
    let (name, share) = found.iter().next().unwrap();
    close(*share, 0.6);
    assert!(name.starts_with("a (") && name.contains("minimum_separation=0.02"), "{name}");
    close(value("height_field_early_share", &record), 0.75);
    let two = |one: &&mut Row| one.tracer.parameters.get("layers").is_some_and(|layers| *layers == 2);
    for one in record.rows.iter_mut().filter(two) {
        for rays in ["stereo", "temporal"] {
            let part = if one.viewpoint.ray_parameters["stereo_offset"] == 0.032 { 20 } else { 5 };
            count(one, rays, "rays_asking_layer_2", COUNT / part);
        }
    }
    // Of four points two and two are alike in both.
    close(value("rank_of_time_by_second_layer", &record), 4.0 / 6.0);
    let first = run_of(near());
    for name in ["displaced_time_over_near", "height_field_early_share", "recovered_by_second_layer"] {
        assert!(values(name, &first).is_empty(), "{name}");
    }
}
