//! Quantities of DIRT are what they say.

mod families;
mod pages;

use std::collections::BTreeMap;

use serde_json::{Value, json};
use tracebench_api::{ClockKind, MemoryEntry, Query};

use crate::papers::DIRT as PAPER;
use crate::papers::Scope;
use crate::papers::fixture::{
    self, all_rounds, close, config, frames_of, in_a_million, run_of, set_build, set_bytes, set_classes, set_time,
};
use crate::papers::{Verdict, judge_all};
use crate::results::{CounterRecord, Judgement, Record, Row, Times, WaveRow, WorkRow, common_clock};

/// The ray sets of configurations.
const SETS: [(&str, Query); 3] =
    [("diffuse", Query::Closest), ("specular", Query::Closest), ("glossy", Query::Closest)];

/// DIRT.
pub(in crate::papers) fn dirt(scene: &str, parameters: Value, statistics: &[(&str, f64)]) -> Row {
    config("dirt", scene, parameters, statistics, &SETS)
}

/// The fragment A-buffer, of the same rays.
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
    assert_eq!(
        fixture::lost(&PAPER),
        ["dirt-figure2", "dirt-figure7", "dirt-figure8", "dirt-figure10", "dirt-figure11"]
    );
}

/// Figures that claims and tables share are the same in both: what claims say of the paper's own tables is computed from them.
#[test]
fn claims_agree_with_tables_where_they_say_so() {
    let tables = &PAPER.published.tables;
    let table = |id: &str| tables.iter().find(|table| table.id == id).unwrap();
    let of = |scene: &str, method: &str, column: &str| {
        table("dirt-table2").value(&[("scene", scene), ("method", method)], column).unwrap()
    };
    let percent = |column: &str| {
        let change = |scene| 100.0 * (of(scene, "DIRT", column) / of(scene, "VVP16", column) - 1.0);
        ["Bunny", "Hangar", "Candy"].map(|scene| format!("{:.1}", change(scene).abs())).join(", ")
    };
    let all = &PAPER.claims;
    let claim = |id: &str| all.iter().find(|claim| claim.id == id).unwrap();
    let own = |id: &str| claim(id).own_figures.clone().unwrap();
    for (id, column) in
        [("dirt-memory-vs-fragments", "Memory"), ("dirt-fragment-growth", "Fragments"), ("dirt-build-drop", "Build")]
    {
        assert!(own(id).contains(&percent(column)), "{id}: {} of {}", percent(column), own(id));
    }
    let visibility = ["Cloth", "Bunny", "Hangar", "Candy"].map(|scene| {
        let of = |column| table("dirt-table1").value(&[("scene", scene)], column).unwrap();
        of("Visibility") / of("Specular")
    });
    assert!(own("dirt-visibility-fastest").contains(&visibility.map(|each| format!("{each:.2}")).join(", ")));
    let ends = [f64::min, f64::max].map(|pick| visibility.into_iter().reduce(pick).unwrap());
    let published = claim("dirt-visibility-fastest").published.clone().unwrap();
    assert!(published.iter().zip(ends).all(|(stated, found)| (stated - found).abs() < 0.01));
}

/// A frame without pixels, so that the structure alone counts.
fn without_own_buffers(row: &mut Row) {
    row.viewpoint.frame = [0, 0];
}

/// Over B and tile size of one scene, bytes and references given.
pub(in crate::papers) fn over_buckets(scene: &str, of: impl Fn(u64, u64) -> (u64, f64)) -> Vec<Row> {
    let mut rows = Vec::new();
    for tile_size in [1, 2, 4] {
        for buckets in [8, 16, 24, 32, 40] {
            let (bytes, references) = of(tile_size, buckets);
            let parameters = json!({ "tile_size": tile_size.to_string(), "buckets": buckets });
            let mut record = dirt(scene, parameters, &[("references", references), ("parts", references.sqrt())]);
            set_bytes(&mut record, &[("id buffer: nodes", bytes), ("vertex buffer", 1_000_000)]);
            without_own_buffers(&mut record);
            rows.push(record);
        }
    }
    rows
}

/// Table 3 counts depth bounds and lists, of nodes every part; what else a structure takes, copies for searches too, it has not.
#[test]
fn table_3_leaves_out_what_it_has_not() {
    let own = [
        ("depth bounds texture", 1000),
        ("id buffer: heads", 200),
        ("id buffer: nodes", 30),
        ("id buffer: nodes, part 2", 4),
    ];
    let bytes = |others: &[(&str, u64)]| {
        let mut record = dirt("a", json!({ "tile_size": "2", "buckets": 24 }), &[]);
        set_bytes(&mut record, &[&own[..], others].concat());
        without_own_buffers(&mut record);
        PAPER.bytes(&record, Scope::OfPaper).unwrap()
    };
    close(bytes(&[]), 1234.0);
    let not_counted = [
        "node count",
        "attachment that nothing is written to",
        "vertex buffer",
        "triangle setup: views' bits",
        "triangle setup: counts of blocks",
        "triangle setup: views' triangles",
        "sums of blocks",
        "prefix sum: count of level 1",
        "vertices (texture)",
        "nodes (texture)",
        "heads (texture)",
        "depth bounds (texture)",
    ];
    for name in not_counted {
        assert!((bytes(&[(name, 1 << 20)]) - 1234.0).abs() < 1e-9, "{name}");
    }
    // The negative control: what it has is counted.
    assert!(own.iter().all(|(name, _)| bytes(&[(name, 1 << 20)]) > 1e6));
}

/// Savings are means over B > 8, growth is a mean over the steps, both per scene; the spread is over scenes and needs two.
#[test]
fn memory_is_compared_as_the_text_does() {
    // At B = 8 other figures, which must not count.
    let odd = |buckets: u64, value: f64| if buckets == 8 { 7.0 * value } else { value };
    let of = |tile_size: u64, buckets: u64| {
        let references = odd(buckets, [0.0, 1000.0, 440.0, 0.0, 220.0][tile_size as usize]);
        ((1000 + 10 * buckets) / tile_size, references)
    };
    let record = run_of(over_buckets("a", of));
    assert!((value("references_saved_1_to_2", &record) - 56.0).abs() < 1e-9);
    assert!((value("references_saved_2_to_4", &record) - 50.0).abs() < 1e-9);
    let parts = 100.0 * (1.0 - 0.44_f64.sqrt());
    assert!((value("samples_saved_1_to_2", &record) - parts).abs() < 1e-9);
    assert!((value("samples_saved_2_to_4", &record) - 100.0 * (1.0 - 0.5_f64.sqrt())).abs() < 1e-9);
    assert!((value("memory_saved_1_to_2", &record) - 50.0).abs() < 0.1);
    let steps = [8.0, 16.0, 24.0, 32.0].map(|buckets| 100.0 * (80.0 / (1000.0 + 10.0 * buckets)));
    assert!((value("memory_growth_per_8_buckets_1", &record) - steps.iter().sum::<f64>() / 4.0).abs() < 1e-9);
    assert!((value("max_references_ratio_of_tiles", &record) - 0.5).abs() < 1e-9);
    assert!(values("memory_saving_spread", &record).is_empty());
    let mut two = run_of(over_buckets("a", of));
    two.rows.extend(over_buckets("b", |tile_size, buckets| {
        let (bytes, references) = of(tile_size, buckets);
        (if tile_size == 2 { bytes * 4 / 5 } else { bytes }, references)
    }));
    assert!((value("memory_saving_spread", &two) - 10.0).abs() < 0.3);
}

/// The factor by mipmaps is taken from the viewpoint's tiles; a reference's bytes are the slope over scenes, and the exponent
/// is 1 of bytes that are linear in references and 0 of constant ones.
#[test]
fn bytes_follow_counts() {
    let with = |scene: &str, references: f64, fixed: u64, bounds: u64| {
        let parameters = json!({ "tile_size": "2", "buckets": 24, "views": "six" });
        let mut row = dirt(scene, parameters, &[("references", references)]);
        let part = row.memory.structure[0].clone();
        let bytes = [("depth bounds texture", bounds), ("id buffer: nodes", fixed + 8 * references as u64)];
        row.memory.structure =
            bytes.map(|(name, used_bytes)| MemoryEntry { name: name.to_owned(), used_bytes, ..part.clone() }).to_vec();
        without_own_buffers(&mut row);
        row
    };
    // Six faces of 128x128 tiles, eight bytes each, and mipmaps.
    let level_zero = 6 * 128 * 128 * 8;
    let record = run_of(vec![with("a", 1e5, 0, level_zero * 4 / 3), with("b", 3e5, 0, level_zero * 4 / 3)]);
    assert!(values("mipmap_factor", &record).values().all(|factor| (factor - 4.0 / 3.0).abs() < 1e-5));
    assert!((value("bytes_a_reference", &record) - 8.0).abs() < 1e-9);
    let linear = run_of(vec![with("a", 1e5, 0, 0), with("b", 3e5, 0, 0)]);
    assert!((value("memory_exponent_over_references", &linear) - 1.0).abs() < 1e-9);
    let constant = run_of(vec![with("a", 1e5, 10_000_000_000_000, 0), with("b", 3e5, 10_000_000_000_000, 0)]);
    assert!(value("memory_exponent_over_references", &constant) < 1e-6);
    // One scene has no slope, and other parameters are no other scene.
    assert!(values("bytes_a_reference", &run_of(vec![with("a", 1e5, 0, 0)])).is_empty());
    let mut other = with("b", 3e5, 0, 0);
    other.tracer.parameters.insert("buckets".to_owned(), json!(4));
    assert!(values("bytes_a_reference", &run_of(vec![with("a", 1e5, 0, 0), other])).is_empty());
    assert_eq!(values("equation_1b_beyond_last_bucket", &record).into_values().collect::<Vec<_>>(), [1.0, 1.0]);
}

fn set_wrong(row: &mut Row, false_miss: u64, late: u64) {
    for trace in &mut row.traces {
        let Judgement::Closest(closest) = &mut trace.judgement else { continue };
        let classes = &mut closest.classes.tight;
        (classes.false_miss, classes.late, classes.early, classes.false_hit) = (false_miss, late, 0, 0);
        let trials = trace.count - closest.left_out();
        closest.agreement.tight = Some(1.0 - (false_miss + late) as f64 / trials as f64);
    }
}

/// Lost and misplaced rays are counted against the row that differs in one parameter alone, over the same rays alone.
#[test]
fn losses_are_counted_against_their_counterpart() {
    let row = |searched: &str, accept: &str, wrong: [u64; 2]| {
        let parameters = json!({
            "tile_size": "2", "coverage": "conservative", "searched": searched, "accept": accept,
        });
        let mut row = dirt("a", parameters, &[]);
        set_wrong(&mut row, wrong[0], wrong[1]);
        row
    };
    let rows = [row("until_hit", "tile", [5, 40]), row("all", "tile", [5, 0]), row("all", "distance", [0, 0])];
    let record = run_of(rows.to_vec());
    let per_million = 1e6 / (fixture::COUNT - 12) as f64;
    assert!((value("early_stop_wrong_rays", &record) - 40.0 * per_million).abs() < 1e-6);
    assert!((value("tile_acceptance_false_misses", &record) - 5.0 * per_million).abs() < 1e-6);
    // Without the counterpart, or with other rays there, there is no figure.
    assert!(values("early_stop_wrong_rays", &run_of(vec![rows[0].clone()])).is_empty());
    let mut other = rows[1].clone();
    other.traces.iter_mut().for_each(|trace| trace.rays_sha256 += "0");
    assert!(values("early_stop_wrong_rays", &run_of(vec![rows[0].clone(), other])).is_empty());
    // A coarser tile may be better or worse: both are a change.
    let tile = |tile_size: &str, late: u64| {
        let mut row = row("until_hit", "tile", [0, late]);
        row.tracer.parameters.insert("tile_size".to_owned(), json!(tile_size));
        row
    };
    let record = run_of(vec![tile("1", 10), tile("2", 10), tile("4", 7), tile("8", 12)]);
    assert!((value("coarse_tiles_agreement_change", &record) - 3.0 * per_million).abs() < 1e-3);
}

/// Times are ratios of the same clock, else of the host's; the coherence order takes the worst step of every row.
#[test]
fn times_are_ratios_within_a_run() {
    let mut fast = dirt("a", json!({ "tile_size": "1" }), &[]);
    for (rays, ms) in [("specular", 10.0), ("glossy", 20.0), ("diffuse", 25.0)] {
        set_time(&mut fast, rays, ms);
    }
    let mut slow = fast.clone();
    set_time(&mut slow, "diffuse", 16.0);
    assert!((value("max_step_to_less_coherent", &run_of(vec![fast.clone()])) - 0.8).abs() < 1e-9);
    let both = run_of(vec![fast.clone(), slow.clone()]);
    assert!((value("max_step_to_less_coherent", &both) - 1.25).abs() < 1e-9);
    let (one, other) = (&fast.traces[0].times, &slow.traces[0].times);
    let time_ratio = |one: &Times, other: &Times| common_clock(one, other).map(|[one, other]| one / other);
    assert!((time_ratio(one, other).unwrap() - 25.0 / 16.0).abs() < 1e-9);
    let mut on_host = other.clone();
    (on_host.clock, on_host.median_ms) = (ClockKind::Host, 50.0);
    assert!((time_ratio(one, &on_host).unwrap() - 0.5).abs() < 1e-9);
    let mut untimed = other.clone();
    untimed.samples_ms.clear();
    assert_eq!(time_ratio(one, &untimed), None);
}

/// Beside a hierarchy over two resolutions: slopes are per ray added, totals count shadow rays twice.
#[test]
fn resolutions_are_told_apart() {
    let row = |tracer: &str, image: u32, build: f64, times: [f64; 3]| {
        let mut record = dirt("a", json!({}), &[]);
        record.tracer.name = tracer.to_owned();
        record.viewpoint.ray_image = [image, image];
        set_build(&mut record, build);
        for (trace, (rays, ms)) in record.traces.iter_mut().zip(["diffuse", "primary", "visibility"].iter().zip(times))
        {
            trace.rays = (*rays).to_owned();
            all_rounds(&mut trace.times, ms);
            trace.count = u64::from(image * image);
        }
        record
    };
    let record = run_of(vec![
        row("dirt", 10, 5.0, [4.0, 1.0, 1.0]),
        row("ploc-gpu", 10, 20.0, [2.0, 1.0, 0.5]),
        row("ploc-gpu", 20, 18.0, [8.0, 2.0, 1.0]),
        row("dirt", 20, 6.0, [34.0, 3.0, 2.0]),
    ]);
    assert!((value("diffuse_slope_over_bvh", &record) - 5.0).abs() < 1e-9);
    assert!((value("min_bvh_build_over_dirt", &record) - 3.0).abs() < 1e-9);
    assert!((value("min_diffuse_time_over_bvh", &record) - 2.0).abs() < 1e-9);
    let gains = [24.0 / 12.0, 30.0 / 47.0];
    assert!((value("total_gain_last_over_first", &record) - gains[1] / gains[0]).abs() < 1e-9);
    let lowest = run_of(record.rows[..2].to_vec());
    assert!(values("diffuse_slope_over_bvh", &lowest).is_empty());
    assert!(values("total_gain_last_over_first", &lowest).is_empty());
}

/// What a larger tile gains is compared over resolutions, of finely tessellated scenes alone.
#[test]
fn gains_of_tiles_are_compared_over_resolutions() {
    let row = |tile_size: &str, image: u32, parts: f64, ms: f64| {
        let parameters = json!({ "tile_size": tile_size, "coverage": "conservative", "searched": "until_hit" });
        let mut row = dirt("a", parameters, &[("parts", parts), ("occupied_tiles", 10.0)]);
        row.viewpoint.ray_image = [image, image];
        set_time(&mut row, "diffuse", ms);
        row
    };
    let rows = |parts: f64| {
        let high = [row("1", 20, parts, 30.0), row("4", 20, parts, 10.0)];
        [high, [row("1", 10, parts, 6.0), row("4", 10, parts, 4.0)]].concat()
    };
    let name = "coarse_tile_gain_over_resolution_where_fine";
    assert!((value(name, &run_of(rows(50.0))) - 2.0).abs() < 1e-9);
    assert!(values(name, &run_of(rows(30.0))).is_empty());
    assert!(values(name, &run_of(rows(50.0)[..2].to_vec())).is_empty());
}

/// Steps of the pyramid are taken from the counters of the same rows, and what is not counted is no figure.
#[test]
fn counters_are_those_of_their_rows() {
    let row = |tile_size: &str, per_ray: f64| {
        let mut record = dirt("a", json!({ "tile_size": tile_size, "buckets": 24 }), &[]);
        let counter = CounterRecord { total: 1, per_ray, max_per_ray: None };
        record.traces[0].counters.insert("pyramid_steps".to_owned(), counter);
        record
    };
    let mut record = run_of(vec![row("1", 40.0), row("4", 10.0)]);
    assert!((value("pyramid_steps_4_over_1", &record) - 0.25).abs() < 1e-12);
    record.rows[1].traces[0].counters.clear();
    assert!(values("pyramid_steps_4_over_1", &record).is_empty());
}

/// Bytes of Table 3 a pixel of the frame: 4 + 32, three times 32, 2.
const OF_A_PIXEL: u64 = 134;

/// DIRT with coverage by sample beside the A-buffer: percentages of the A-buffer's figures, the buffers of Table 3 in DIRT's memory and
/// nobody else's. By the ledger a trace to surfaces has the buffers that DIRT's paper counts, of DIRT alone; without such a trace there
/// is no such figure.
#[test]
fn dirt_stands_beside_the_abuffer() {
    let scene = |name: &str, [dirt_bytes, bytes]: [u64; 2], fragments: f64| {
        let rows = [("standard", 1050.0), ("conservative", 5000.0)].map(|(coverage, references)| {
            let parameters = json!({ "tile_size": "1", "buckets": 4, "coverage": coverage });
            let mut record = dirt(name, parameters, &[("references", references)]);
            let alone = if coverage == "standard" { dirt_bytes - OF_A_PIXEL } else { 7 };
            set_bytes(&mut record, &[("id buffer: nodes", alone), ("vertex buffer", 9)]);
            record.viewpoint.frame = [1, 1];
            set_build(&mut record, 17.0);
            set_time(&mut record, "diffuse", 30.0);
            record
        });
        let mut other = abuffer(name, json!({ "buckets": 4 }), &[("fragments", fragments), ("pixels", 100.0)]);
        set_bytes(&mut other, &[("depth bounds, heads and tails", bytes)]);
        other.viewpoint.frame = [1, 1];
        set_build(&mut other, 20.0);
        set_time(&mut other, "diffuse", 24.0);
        [&rows[..], &[other]].concat()
    };
    let mut record = run_of(scene("a", [850, 1000], 1000.0));
    close(value("memory_below_abuffer", &record), 15.0);
    close(value("references_beyond_fragments", &record), 5.0);
    close(value("build_below_abuffer", &record), 15.0);
    close(value("trace_below_abuffer", &record), -25.0);
    close(value("dirt_trace_over_abuffer", &record), 1.25);
    close(value("dirt_bytes_over_abuffer_where_fewest", &record), 0.85);
    for trace in record.rows.iter_mut().flat_map(|row| &mut row.traces) {
        trace.trace_to = tracebench_api::TraceTo::Surface;
        trace.per_trace = vec![MemoryEntry::whole("shading buffer", 50), MemoryEntry::whole("rays", 9000)];
    }
    close(value("memory_below_abuffer", &record), 15.0);
    let bytes = |row: usize| Scope::ALL.map(|scope| PAPER.bytes(&record.rows[row], scope));
    assert_eq!(bytes(0), [Some(725.0), Some(775.0), Some(850.0)]);
    assert_eq!(bytes(2), [Some(1000.0); 3]);
    assert_eq!(PAPER.bytes(&scene("a", [850, 1000], 1.0)[0], Scope::WithTrace), None);
    let scenes = [scene("a", [850, 1000], 1000.0), scene("b", [990, 1000], 500.0), scene("c", [400, 1000], 3000.0)];
    let all = run_of(scenes.concat());
    close(value("rank_of_saving_by_fragments", &all), 1.0);
    close(value("dirt_bytes_over_abuffer_where_fewest", &all), 0.99);
    assert!(values("memory_below_abuffer", &run_of(all.rows[..2].to_vec())).is_empty());
}

/// Thickness is compared with none: what it closes and what it invents, the less of the two, and what the best leaves wrong.
#[test]
fn thickness_is_a_trade() {
    let row = |thickness: f64, classes: [u64; 2], footprint: f64| {
        let mut record = abuffer("a", json!({ "thickness": thickness }), &[]);
        set_classes(&mut record, "specular", classes, footprint);
        record
    };
    let parameters = json!({ "tile_size": "1", "coverage": "conservative", "searched": "until_hit", "accept": "tile" });
    let exact = dirt("a", parameters, &[]);
    let rows = [row(0.0, [900, 10], 0.90), row(1.0, [300, 40], 0.96), row(16.0, [100, 700], 0.93)];
    let record = run_of([&rows[..], std::slice::from_ref(&exact)].concat());
    close(value("fragments_false_misses_beyond_dirt", &record), in_a_million(900));
    close(value("thickness_closes_and_invents", &record), in_a_million(690));
    // The best leaves 340 wrong and misses 600 less.
    close(value("froxels_gain_and_leave", &record), in_a_million(340));
    let thin_best = run_of(vec![row(0.0, [900, 10], 0.99), row(1.0, [300, 40], 0.96)]);
    close(value("froxels_gain_and_leave", &thin_best), 0.0);
    let nothing = run_of(vec![row(0.0, [0, 0], 1.0), exact]);
    assert!(values("thickness_closes_and_invents", &nothing).is_empty());
    close(value("fragments_false_misses_beyond_dirt", &nothing), 0.0);
}

/// What the same rays lose in views from elsewhere is told of frames with fixed rays, by the set and the view that lose most.
#[test]
fn views_from_elsewhere_are_held_against_own_ones() {
    let judged = |lost: u64| {
        let rows = vec![dirt("room", json!({}), &[])];
        let record = frames_of("dirt-reuse", rows, &["primary", "diffuse"], |_, work, frame| {
            let wrong = if frame == 2 && work == "diffuse" { lost } else { frame as u64 };
            let wave = WaveRow { rays: 1000, judged: 1000, right: [990 - wrong; 3], ..WaveRow::default() };
            WorkRow { waves: vec![wave], image: None }
        });
        let mut found = judge_all(&PAPER, &[record]).into_iter();
        let found = found.find(|each| each.claim.id == "dirt-static-reuse").unwrap();
        (found.verdict, found.median.unwrap())
    };
    for (lost, verdict) in [(5, Verdict::Holds), (20, Verdict::DoesNotHold)] {
        let (found, value) = judged(lost);
        assert_eq!(found, verdict);
        close(value, lost as f64 / 1000.0);
    }
}
