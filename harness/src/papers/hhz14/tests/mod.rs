//! Quantities of grid and A-buffers are what they say.

mod pages;

use std::collections::BTreeMap;

use serde_json::{Value, json};
use tracebench_api::Query;

use crate::papers::HHZ14 as PAPER;
use crate::papers::fixture::{
    self, close, config, count, in_a_million, run_of, set_build, set_bytes, set_classes, set_time, trace_of,
};
use crate::papers::{Rows, SceneValue, Verdict, judge};
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

/// Says why rays of a set are wrong, under `footprint` or of any-hit rays.
fn set_causes(row: &mut Row, rays: &str, causes: &[(&str, u64)]) {
    let causes = causes.iter().map(|(cause, rays)| ((*cause).to_owned(), *rays)).collect();
    match &mut trace_of(row, rays).judgement {
        Judgement::Closest(closest) => closest.causes.insert("footprint".to_owned(), causes),
        Judgement::Any(any) => any.causes.insert("occlusion".to_owned(), causes),
    };
}

/// Table 1 of a scene: A-buffers by two searches, the octree by both of its walks, two methods over depth images.
fn table_1(scene: &str) -> Vec<Row> {
    let timed = |mut row: Row, [specular, refraction, visibility]: [f64; 3], build: f64, footprint: f64| {
        for (rays, ms) in [("specular", specular), ("refraction", refraction), ("visibility", visibility)] {
            set_time(&mut row, rays, ms);
        }
        set_build(&mut row, build);
        set_classes(&mut row, "specular", [0, 0], footprint);
        set_classes(&mut row, "refraction", [0, 0], footprint - 0.02);
        set_accuracy(&mut row, "visibility", 0.9);
        row
    };
    let own = |search: &str| abuffer(scene, json!({ "abuffer": 1024, "grid": 64, "search": search }));
    let octree = |walk: &str| config("voxel-octree", scene, json!({ "traversal": walk, "hit": "entry" }), &[], &SETS);
    let images = |tracer: &str| config(tracer, scene, json!({}), &[], &SETS);
    vec![
        timed(own("dda2d"), [2.0, 3.0, 5.0], 14.0, 0.97),
        timed(own("three-step"), [1.0, 2.0, 2.0], 14.0, 0.96),
        timed(octree("restart"), [20.0, 40.0, 30.0], 42.0, 0.3),
        timed(octree("stack"), [16.0, 32.0, 24.0], 42.0, 0.3),
        timed(images("screen-dda"), [3.0, 3.0, 4.0], 1.0, 0.5),
        timed(images("height-field"), [2.0, 1.0, 1.0], 1.0, 0.48),
    ]
}

/// The octree stands beside the A-buffers by all rays of a frame together and by the quicker of its walks, for either search; without
/// one of the sets, or without either method, there is no ratio.
#[test]
fn the_octree_stands_beside() {
    let record = run_of(table_1("a"));
    close(value("octree_build_over_abuffer", &record), 3.0);
    close(value("octree_trace_over_abuffer", &record), 7.2);
    close(value("octree_trace_over_three_step", &record), 14.4);
    // By the first walk, which is the row's own.
    close(value("octree_total_over_abuffer", &record), (42.0 + 90.0) / 24.0);
    close(value("octree_total_over_three_step", &record), (42.0 + 90.0) / 19.0);
    let mut slower = record.clone();
    set_time(&mut slower.rows[3], "visibility", 240.0);
    close(value("octree_trace_over_abuffer", &slower), 9.0);
    let mut lacking = record.clone();
    lacking.rows[0].traces.retain(|trace| trace.rays != "visibility");
    for name in ["octree_trace_over_abuffer", "octree_total_over_abuffer"] {
        assert!(values(name, &lacking).is_empty(), "{name}");
    }
    let alone = run_of(record.rows[..1].to_vec());
    for name in ["octree_build_over_abuffer", "octree_trace_over_three_step", "octree_total_over_three_step"] {
        assert!(values(name, &alone).is_empty(), "{name}");
    }
}

/// Depth images stand beside three steps: the most accurate of them set by set, the quickest by all rays of a frame; the octree is none
/// of them, and without them, or without three steps, there is nothing.
#[test]
fn depth_images_stand_beside() {
    let record = run_of(table_1("a"));
    // 0.9 of 0.9 for shadow rays.
    close(value("accuracy_over_depth_images", &record), 1.0);
    close(value("speed_over_depth_images", &record), 0.8);
    let mut better = record.clone();
    set_accuracy(&mut better.rows[1], "visibility", 0.99);
    // 0.96 of 0.5 and 0.94 of 0.48 are more than 0.99 of 0.9.
    close(value("accuracy_over_depth_images", &better), 1.1);
    set_classes(&mut better.rows[5], "refraction", [0, 0], 0.98);
    close(value("accuracy_over_depth_images", &better), 0.94 / 0.98);
    for rows in [&record.rows[..4], &record.rows[2..]] {
        for name in ["accuracy_over_depth_images", "speed_over_depth_images"] {
            assert!(values(name, &run_of(rows.to_vec())).is_empty(), "{name}");
        }
    }
}

/// The published forms of depth images stand aside for those with a cap and for the improved ones, and starts along the ray for lifted ones,
/// where that is asked for; without such rows there is nothing.
#[test]
fn forms_and_starts_stand_beside() {
    let changed = |place: usize, parameters: &[(&str, Value)], ms: f64, accuracy: f64| {
        let mut row = table_1("a").swap_remove(place);
        row.tracer.parameters.extend(parameters.iter().map(|(name, value)| ((*name).to_owned(), value.clone())));
        ["specular", "refraction", "visibility"].iter().for_each(|rays| set_time(&mut row, rays, ms));
        set_accuracy(&mut row, "visibility", accuracy);
        row
    };
    let others = [
        changed(4, &[("max_steps", json!(200))], 0.5, 0.6),
        changed(4, &[("march", json!("cells"))], 1.0, 0.95),
        changed(5, &[("search", json!("closed"))], 5.0, 0.96),
        changed(1, &[("start_along", json!("normal"))], 0.4, 0.92),
    ];
    let record = run_of([&table_1("a")[..], &others[..]].concat());
    for (name, expected) in [
        // Of 5 ms.
        ("accuracy_over_depth_images", 1.0),
        ("speed_over_depth_images", 0.8),
        // The height field is the more accurate, DDA the quicker.
        ("accuracy_over_capped_images", 1.0),
        ("speed_over_capped_images", 0.3),
        ("accuracy_over_improved_images", 0.9 / 0.96),
        ("speed_over_improved_images", 0.6),
        ("lifted_accuracy_over_depth_images", 0.92 / 0.9),
        ("lifted_speed_over_depth_images", 4.0 / 1.2),
    ] {
        close(value(name, &record), expected);
    }
    let without = run_of(table_1("a"));
    for name in ["speed_over_capped_images", "accuracy_over_improved_images", "lifted_speed_over_depth_images"] {
        assert!(values(name, &without).is_empty(), "{name}");
    }
}

/// What three steps lose of refracted rays decides about massive and about thin glass apart.
#[test]
fn thin_glass_is_a_claim_of_its_own() {
    let of = |scene: &str, lost: f64| {
        let mut rows = figure_6(scene, [9.0, 6.0, 5.0]);
        set_classes(&mut rows[1], "refraction", [0, 0], 0.97 - lost);
        rows
    };
    let record = run_of([of("solids", 0.2), of("room", 0.01), of("candy", 0.0)].concat());
    for (id, verdict, scenes) in [
        ("hhz14-three-step-refraction", Verdict::Holds, [2, 2]),
        ("hhz14-three-step-thin-glass", Verdict::DoesNotHold, [1, 1]),
    ] {
        let claim = PAPER.claims.iter().find(|claim| claim.id == id).unwrap();
        let judged = judge(&PAPER, claim, &Rows::of(&record));
        assert_eq!((judged.verdict, judged.scenes), (verdict, scenes), "{id}: {:?}", judged.values);
    }
}

/// Figure 6 of a scene: a search in every texel, in three steps, in one.
fn figure_6(scene: &str, ms: [f64; 3]) -> Vec<Row> {
    let searches =
        [("dda2d", 100, 0.99, 0.98, 64), ("three-step", 300, 0.98, 0.975, 16), ("one-step", 1100, 0.95, 0.96, 8)];
    let make = |((search, missed, footprint, accuracy, compared), ms): ((&str, u64, f64, f64, u64), f64)| {
        let mut row = abuffer(scene, json!({ "abuffer": 1024, "grid": "64", "search": search }));
        row.traces.retain(|trace| ["specular", "refraction", "ao", "visibility"].contains(&trace.rays.as_str()));
        for (rays, steps) in [("specular", 32), ("refraction", 16), ("ao", 8), ("visibility", 8)] {
            set_time(&mut row, rays, ms);
            count(&mut row, rays, "voxels_stepped", steps * fixture::COUNT);
            count(&mut row, rays, "depth_comparisons", compared * fixture::COUNT);
            count(&mut row, rays, "searches", 4 * fixture::COUNT);
            count(&mut row, rays, "voxels_opened", 5 * fixture::COUNT);
            trace_of(&mut row, rays).statuses = BTreeMap::from([("hit".to_owned(), fixture::COUNT)]);
        }
        set_classes(&mut row, "specular", [missed, 0], footprint);
        set_classes(&mut row, "refraction", [2 * missed, 0], footprint - 0.02);
        set_accuracy(&mut row, "ao", accuracy);
        set_accuracy(&mut row, "visibility", accuracy - 0.01);
        row
    };
    searches.into_iter().zip(ms).map(make).collect()
}

/// Searches are compared with that in every texel, set by set; gains are of neighbours, the less counts; rows that are not there leave
/// nothing.
#[test]
fn searches_are_compared() {
    let record = run_of(figure_6("a", [9.0, 6.0, 5.0]));
    close(value("min_footprint_agreement", &record), 0.97);
    close(value("refraction_agreement_less_specular", &record), -0.02);
    for (rays, expected) in [("specular", -0.01), ("refraction", -0.01), ("visibility", -0.005), ("ao", -0.005)] {
        close(value(&format!("three_step_{rays}_change"), &record), expected);
    }
    close(value("one_step_ao_change", &record), -0.02);
    close(value("min_gain_of_fewer_steps", &record), 1.2);
    close(value("min_gain_of_fewer_steps", &run_of(figure_6("a", [9.0, 10.0, 5.0]))), 0.9);
    let mut worse = record.clone();
    set_classes(&mut worse.rows[1], "specular", [0, 0], 0.9);
    close(value("three_step_specular_change", &worse), -0.09);
    close(value("three_step_refraction_change", &worse), -0.01);
    let mut starts = record.clone();
    for (row, few) in starts.rows.iter_mut().zip([10, 50, 30]) {
        for rays in ["specular", "refraction", "ao"] {
            set_causes(row, rays, &[("near_start", few)]);
        }
        // Half of 1000 rays are occluded.
        set_occlusion(row, [420, 0, 500, 80]);
    }
    for rays in ["specular", "refraction"] {
        close(value(&format!("three_step_{rays}_but_starts"), &starts), in_a_million(40) / 1e6 - 0.01);
    }
    close(value("three_step_ao_but_starts", &starts), 0.04);
    close(value("one_step_ao_but_starts", &starts), 0.02);
    let alone = run_of(record.rows[..1].to_vec());
    for name in [
        "three_step_specular_change",
        "three_step_visibility_but_starts",
        "three_step_ao_change",
        "one_step_ao_change",
        "one_step_passed_voxels",
        "min_gain_of_fewer_steps",
        "comparisons_saved_by_three_step",
        "steps_over_three_step_comparisons",
    ] {
        assert!(values(name, &alone).is_empty(), "{name}");
    }
}

/// Comparisons are set beside one another, beside an image's edge and beside the voxels that a ray goes through, of the set with the most.
#[test]
fn comparisons_are_counted() {
    let record = run_of(figure_6("a", [9.0, 6.0, 5.0]));
    close(value("comparisons_saved_by_three_step", &record), 4.0);
    // 64 in 4 searches.
    close(value("comparisons_a_search_over_edge", &record), 16.0 / 1024.0);
    close(value("steps_over_comparisons", &record), 0.5);
    close(value("steps_over_three_step_comparisons", &record), 2.0);
    let mut more = record.clone();
    count(&mut more.rows[0], "ao", "depth_comparisons", 4 * fixture::COUNT);
    close(value("steps_over_comparisons", &more), 2.0);
    // 3 * 64 + 4 over 4 * 16.
    close(value("comparisons_saved_by_three_step", &more), 196.0 / 64.0);
    more.rows[0].traces[0].counters.remove("depth_comparisons").unwrap();
    for name in ["comparisons_saved_by_three_step", "comparisons_a_search_over_edge", "steps_over_comparisons"] {
        assert!(values(name, &more).is_empty(), "{name}");
    }
}

/// Of one step the rays are counted that pass their hit beyond those in every texel, late or into nothing, over the voxels with anything
/// that ended no ray.
#[test]
fn voxels_that_are_passed_are_counted() {
    let record = run_of(figure_6("a", [9.0, 6.0, 5.0]));
    // Of two closest-hit sets 1000 and 2000 rays; of five voxels a ray one ended it.
    let left = (2 * 4 * fixture::COUNT) as f64;
    close(value("one_step_passed_voxels", &record), 3000.0 / left);
    let mut late = record.clone();
    let Judgement::Closest(closest) = &mut trace_of(&mut late.rows[2], "specular").judgement else { panic!() };
    closest.classes.footprint.late += 40;
    close(value("one_step_passed_voxels", &late), 3040.0 / left);
    // Where no ray is ended every voxel was left.
    for rays in ["specular", "refraction"] {
        trace_of(&mut late.rows[2], rays).statuses.clear();
    }
    close(value("one_step_passed_voxels", &late), 3040.0 / (left * 1.25));
}

/// Rays that are wrong for their start are right in the other reading, whichever way they went wrong, and no others are.
#[test]
fn starts_are_set_aside() {
    let mut record = run_of(figure_6("a", [9.0, 6.0, 5.0]));
    let rays = (fixture::COUNT - 12) as f64;
    for name in ["min_footprint_agreement", "min_agreement_but_starts"] {
        close(value(name, &record), 0.97);
    }
    let causes = [("near_start", 100), ("wrong_side_at_start", 31), ("between_samples", 999)];
    set_causes(&mut record.rows[0], "refraction", &causes);
    close(value("min_footprint_agreement", &record), 0.97);
    close(value("min_agreement_but_starts", &record), 0.97 + 131.0 / rays);
    close(value("refraction_agreement_less_specular", &record), -0.02);
    close(value("refraction_less_specular_but_starts", &record), -0.02 + 131.0 / rays);
    record.rows.remove(0);
    assert!(values("min_agreement_but_starts", &run_of(record.rows)).is_empty());
}

/// The exponent of time over rays is 1 where a ray takes as long at every number of samples, and 0 where the time is the same; another
/// search, other images and rays of another kind are not it.
#[test]
fn a_ray_takes_its_time() {
    let at = |samples: u64, ms: f64, search: &str| {
        let mut row = config(
            "voxel-abuffer",
            "a",
            json!({ "search": search }),
            &[],
            &[("pixel-random", Query::Closest), ("diffuse", Query::Closest)],
        );
        row.viewpoint.ray_parameters.insert("pixel_random_count".to_owned(), json!(samples));
        trace_of(&mut row, "pixel-random").count *= samples;
        set_time(&mut row, "pixel-random", ms);
        row
    };
    let rows = [(1, 2.0, 1.0), (4, 8.0, 2.0), (16, 32.0, 4.0)]
        .into_iter()
        .flat_map(|(samples, all, three)| [at(samples, all, "dda2d"), at(samples, three, "three-step")]);
    let record = run_of(rows.collect());
    close(value("time_over_rays_exponent", &record), 1.0);
    close(value("three_step_time_over_rays_exponent", &record), 0.5);
    close(value("time_over_rays_exponent", &run_of(vec![at(1, 2.0, "dda2d"), at(16, 2.0, "dda2d")])), 0.0);
    let mut finer = record.clone();
    finer.rows[4].viewpoint.face *= 2;
    assert!(values("time_over_rays_exponent", &finer).is_empty());
    assert!(values("time_over_rays_exponent", &run_of(record.rows[..2].to_vec())).is_empty());
    let mut other = record;
    other.rows.iter_mut().for_each(|row| row.traces.retain(|trace| trace.rays == "diffuse"));
    assert!(values("time_over_rays_exponent", &other).is_empty());
}

/// Resolutions of a scene: three searches in A-buffers of 1024, 512 and 2048, and four grids by two searches.
fn text(scene: &str, missed: u64, wrong: u64) -> Vec<Row> {
    let mut rows = Vec::new();
    for (edge, factor, thin) in [(1024, 1.0, 20), (512, 0.9, 90), (2048, 1.08, 10)] {
        for (search, ms, compared) in
            [("dda2d", 10.0, edge), ("three-step", 5.0, 30 + edge / 512), ("one-step", 4.0, 20)]
        {
            let mut row = abuffer(scene, json!({ "abuffer": edge, "grid": 64, "search": search }));
            row.traces.retain(|trace| trace.rays == "diffuse");
            set_time(&mut row, "diffuse", ms * factor);
            set_classes(&mut row, "diffuse", [missed, wrong], 0.9);
            count(&mut row, "diffuse", "depth_comparisons", compared * fixture::COUNT);
            let causes =
                [("wrong_axis", 7), ("thinner_than_texel", thin), ("near_start", 5), ("between_samples", edge)];
            set_causes(&mut row, "diffuse", &causes);
            rows.push(row);
        }
    }
    for (grid, ms, build) in [(0, 11.0, 3.0), (32, 30.0, 2.0), (128, 10.0, 4.0), (256, 20.0, 5.0)] {
        for (search, factor) in [("dda2d", 1.0), ("three-step", 1.0 + f64::from(grid))] {
            let mut row = abuffer(scene, json!({ "abuffer": 0, "grid": grid, "search": search }));
            set_time(&mut row, "diffuse", ms * factor);
            set_build(&mut row, build);
            rows.push(row);
        }
    }
    rows
}

/// Resolutions are compared with one another at one grid, by time and by comparisons, and grids against the one by the rule, build and
/// trace apart.
#[test]
fn resolutions_and_grids_are_compared() {
    let record = run_of(text("room", 40, 10));
    close(value("step_search_time_over_abuffer", &record), 1.2);
    close(value("step_search_comparisons_over_abuffer", &record), 34.0 / 31.0);
    close(value("dda_comparisons_over_abuffer", &record), 4.0);
    // Hits that are off by texels are more by far in the finer ones, and are not counted.
    close(value("coarse_abuffer_thin_misses", &record), in_a_million(70));
    close(value("grid_by_rule_build_over_best", &record), 1.5);
    close(value("grid_by_rule_trace_over_best", &record), 1.1);
    close(value("grid_by_rule_three_step_over_best", &record), 11.0 / 990.0);
    let mut sets = run_of(figure_6("room", [9.0, 6.0, 5.0]));
    set_causes(&mut sets.rows[0], "specular", &[("wrong_axis", 4)]);
    set_causes(&mut sets.rows[0], "refraction", &[("wrong_axis", 9)]);
    close(value("fewest_wrong_axis_rays", &sets), in_a_million(4));
    close(value("most_wrong_axis_rays", &sets), in_a_million(9));
    let mut slower = record.clone();
    // One step in A-buffers of 2048.
    set_time(&mut slower.rows[8], "diffuse", 36.0);
    count(&mut slower.rows[8], "diffuse", "depth_comparisons", 40 * fixture::COUNT);
    close(value("step_search_time_over_abuffer", &slower), 10.0);
    close(value("step_search_comparisons_over_abuffer", &slower), 2.0);
    let coarse = run_of(record.rows[..6].to_vec());
    for name in [
        "step_search_time_over_abuffer",
        "step_search_comparisons_over_abuffer",
        "dda_comparisons_over_abuffer",
        "grid_by_rule_trace_over_best",
    ] {
        assert!(values(name, &coarse).is_empty(), "{name}");
    }
}

/// Wrong rays are a share of all that count, of each scene; those for their start aside in the other reading.
#[test]
fn wrong_rays_are_told_by_scene() {
    let record = run_of([text("room", 40, 60), text("cloth", 40, 260)].concat());
    let rays = (fixture::COUNT - 12) as f64;
    let (all, aside) = (values("wrong_rays", &record), values("wrong_rays_but_starts", &record));
    for (scene, wrong) in [("room", 100.0), ("cloth", 300.0)] {
        close(all[scene], wrong / rays);
        close(aside[scene], (wrong - 5.0) / rays);
    }
}

/// Scenes of so many triangles, layers of a covered texel, comparisons a ray and milliseconds.
fn scenes(of: &[(u64, f64, u64, f64)]) -> Record {
    let row = |(index, (triangles, layers, compared, ms)): (usize, &(u64, f64, u64, f64))| {
        let scene = format!("scene {index}");
        let mut row = config("voxel-abuffer", &scene, json!({}), &[("average_layers", *layers)], &SETS);
        set_bytes(&mut row, &[("grid", *triangles)]);
        row.scene.triangles = *triangles;
        count(&mut row, "diffuse", "depth_comparisons", compared * fixture::COUNT);
        set_time(&mut row, "diffuse", *ms);
        row
    };
    run_of(of.iter().enumerate().map(row).collect())
}

/// Orders are of six scenes at least, and say how often chance makes one as strong; one that it makes often is doubted.
#[test]
fn scenes_are_ranked() {
    // Of scenes with more layers a ray takes less time, and a comparison more.
    let six: Vec<_> = (1..=6).map(|each| (1000 * each, each as f64, 70 - 10 * each, 7.0 - 0.5 * each as f64)).collect();
    let record = scenes(&six);
    for name in ["rank_of_bytes_by_triangles", "rank_of_comparison_time_by_layers"] {
        close(value(name, &record), 1.0);
        assert!(values(name, &scenes(&six[..5])).is_empty(), "{name}");
    }
    let mut three = record.clone();
    for row in &mut three.rows {
        row.tracer.parameters.insert("search".to_owned(), json!("three-step"));
    }
    close(value("rank_of_three_step_time_by_layers", &three), 1.0);
    let found = |record: &Record| {
        PAPER.quantity("rank_of_bytes_by_triangles").unwrap().values(&PAPER, &Rows::of(record)).remove(0).1
    };
    // Two of 720 orders: every pair in order, and none.
    assert_eq!(found(&record).note.as_deref(), Some("exact p 0.0028 over 6 scenes"));
    assert!(found(&record).doubts.is_empty());
    let mut mixed = record.clone();
    for (row, bytes) in mixed.rows.iter_mut().zip([3, 2, 1, 6, 5, 4]) {
        set_bytes(row, &[("grid", bytes)]);
    }
    // Nine pairs of fifteen in order, six not: most orders are as strong.
    close(value("rank_of_bytes_by_triangles", &mixed), 0.2);
    assert_eq!(found(&mixed).doubts.len(), 1);
    let shown =
        SceneValue::from(&PAPER.quantity("rank_of_bytes_by_triangles").unwrap().values(&PAPER, &Rows::of(&record))[0]);
    assert_eq!(shown.scene, "all scenes (exact p 0.0028 over 6 scenes)");
}

/// Figure 9 of a scene: A-buffers, and voxels alone.
fn figure_9(scene: &str) -> Vec<Row> {
    let make = |(structure, abuffer_edge, grid, error, ms): (&str, &str, u64, f64, f64)| {
        let mut record = abuffer(scene, json!({ "structure": structure, "abuffer": abuffer_edge, "grid": grid }));
        record.traces.retain(|trace| ["ao", "diffuse"].contains(&trace.rays.as_str()));
        for rays in ["ao", "diffuse"] {
            set_time(&mut record, rays, ms);
            count(&mut record, rays, "voxels_stepped", grid * fixture::COUNT);
        }
        set_bytes(&mut record, &[("grid", grid * grid * grid)]);
        let Judgement::Closest(closest) = &mut trace_of(&mut record, "diffuse").judgement else { panic!() };
        closest.position_error.p50 = Some(error);
        record
    };
    // A tenth of a millisecond, and a millisecond a voxel.
    let rows = [
        ("two-level", "0", 64, 0.1, 5.0),
        ("two-level", "1024", 64, 0.15, 5.0),
        ("voxels-only", "0", 64, 4.0, 64.1),
        ("voxels-only", "0", 128, 4.0, 128.1),
        ("voxels-only", "0", 256, 4.0, 256.1),
        ("voxels-only", "0", 512, 0.5, 512.1),
        ("voxels-only", "0", 1024, 0.25, 1024.1),
    ];
    rows.map(make).to_vec()
}

/// What is told of rays of ambient occlusion: truly and wrongly occluded, truly and wrongly free.
fn set_occlusion(row: &mut Row, [occluded, not, free, missed]: [u64; 4]) {
    let Judgement::Any(any) = &mut trace_of(row, "ao").judgement else { panic!() };
    let told = &mut any.occlusion;
    (told.true_occluded, told.false_occluded, told.true_free, told.false_free) = (occluded, not, free, missed);
}

/// Voxels alone are compared with A-buffers of the same fineness, by accuracy, bytes and samples.
#[test]
fn voxels_alone_are_compared() {
    let mut record = run_of(figure_9("a"));
    close(value("abuffer_position_error_over_voxels", &record), 0.6);
    close(value("voxels_alone_bytes_over_abuffers", &record), 20.0_f64.powi(3));
    close(value("voxels_of_a_byte_over_abuffers", &record), 8.0 * 20.0_f64.powi(3));
    // Half of 1000 rays are occluded. Voxels alone find 400 of them and 450 of the others; 60 are lost for their start.
    for row in &mut record.rows[2..] {
        set_occlusion(row, [400, 50, 450, 100]);
        set_causes(row, "ao", &[("near_start", 60), ("between_samples", 90)]);
    }
    // A-buffers tell 40 too many: 0.04. Voxels alone tell 50 too few, or 10 too many.
    set_occlusion(&mut record.rows[0], [500, 40, 460, 0]);
    close(value("voxels_alone_ao_change", &record), (0.8 + 0.9) / 2.0 - 0.96);
    close(value("voxels_alone_ao_change_but_starts", &record), (0.92 + 0.9) / 2.0 - 0.96);
    let samples = |bias: f64| 1.0 + 64.0 * (0.04_f64.powi(2) - bias.powi(2)) / 0.25;
    close(value("abuffer_samples_over_voxels_alone", &record), samples(0.05));
    close(value("abuffer_samples_over_voxels_but_starts", &record), samples(0.01));
    let mut better = record.clone();
    set_occlusion(&mut better.rows[5], [490, 5, 495, 10]);
    close(value("voxels_alone_ao_change", &better), (0.98 + 0.99) / 2.0 - 0.96);
    // More than were missed cannot be found.
    close(value("voxels_alone_ao_change_but_starts", &better), (1.0 + 0.99) / 2.0 - 0.96);
    let few = run_of(record.rows[..2].to_vec());
    for name in [
        "voxels_alone_ao_change",
        "voxels_alone_ao_change_but_starts",
        "voxels_alone_bytes_over_abuffers",
        "voxels_of_a_byte_over_abuffers",
        "abuffer_samples_over_voxels_alone",
        "abuffer_position_error_over_voxels",
        "voxel_walk_exponents",
    ] {
        assert!(values(name, &few).is_empty(), "{name}");
    }
}

/// Exponents of the walk are 1 where every voxel takes as long, whatever a trace takes beside them; where one pair of grids says
/// something else, the interval reaches there.
#[test]
fn a_walk_is_linear_beyond_what_is_fixed() {
    let found =
        |record: &Record| PAPER.quantity("voxel_walk_exponents").unwrap().values(&PAPER, &Rows::of(record)).remove(0).1;
    let record = run_of(figure_9("a"));
    let linear = found(&record);
    close(linear.value, 1.0);
    assert!(linear.interval.iter().all(|end| (end - 1.0).abs() < 1e-9), "{linear:?}");
    let mut cached = record.clone();
    // Of the finest, ambient occlusion: 15 times as long as it should beyond the coarsest.
    set_time(&mut cached.rows[6], "ao", 64.1 + 15.0 * 960.0);
    let found_there = found(&cached);
    let steep = (15.0_f64 * 960.0 / 448.0).ln() / (960.0_f64 / 448.0).ln();
    close(found_there.value, 1.0);
    close(found_there.interval[1], steep);
    assert!(!found_there.at_launch_settings);
    // A finer grid that takes no longer has no exponent, and leaves it open.
    set_time(&mut cached.rows[3], "ao", 64.1);
    assert!(found(&cached).interval.iter().any(|end| end.is_infinite()));
}

/// A larger grid is compared with the usual one, mean of both bounces, by either search.
#[test]
fn a_large_grid_is_compared() {
    let with = |grid: u64, search: &str, ms: [f64; 2]| {
        let mut record = abuffer("atrium", json!({ "grid": grid, "search": search }));
        set_time(&mut record, "diffuse", ms[0]);
        set_time(&mut record, "bounce2", ms[1]);
        record
    };
    let record = run_of(vec![
        with(256, "dda2d", [30.0, 20.0]),
        with(256, "three-step", [10.0, 10.0]),
        with(64, "dda2d", [10.0, 20.0]),
        with(64, "three-step", [5.0, 2.5]),
    ]);
    close(value("large_grid_trace_over_usual", &record), 2.0);
    close(value("large_grid_three_step_over_usual", &record), 3.0);
    assert!(values("large_grid_trace_over_usual", &run_of(record.rows[..2].to_vec())).is_empty());
}
