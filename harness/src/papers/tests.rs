//! The data is whole, experiments name what exists, quantities are what they say, verdicts follow from them.

use std::collections::BTreeMap;

use serde_json::json;
use tracebench_api::{ClockKind, Query};

use super::*;
use crate::plan::{RUN_PRESETS, TracerRequest};
use crate::rays::RAY_SETS;
use crate::report::fixture::{self, Quality};
use crate::results::{CounterRecord, Judgement, Run, TracerRun};
use crate::tables::Table;

/// A contender of a scene: its parameters and what its structure says of itself.
fn dirt(scene: &str, parameters: serde_json::Value, statistics: &[(&str, f64)]) -> TracerRun {
    let quality = Quality { missed: 0.0, blur: 0.0, speed: 2.0, clock: ClockKind::DeviceTimestamps };
    let sets = [("diffuse", Query::Closest), ("specular", Query::Closest), ("glossy", Query::Closest)];
    let mut run = fixture::run(&[("dirt", quality)], &sets).runs.remove(0);
    run.scene.name = scene.to_owned();
    run.scene.sha256 = scene.to_owned();
    run.tracer.parameters = serde_json::from_value(parameters).unwrap();
    run.structure_statistics = statistics.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    run
}

fn run_of(runs: Vec<TracerRun>) -> Run {
    let mut run = fixture::run(&[], &[]);
    (run.runs, run.skipped) = (runs, Vec::new());
    run
}

fn values(name: &str, run: &Run) -> BTreeMap<String, f64> {
    let found = quantity(name).unwrap().values(&Rows::of(run));
    found.into_iter().map(|each| (each.scene, each.value)).collect()
}

fn value(name: &str, run: &Run) -> f64 {
    let all = values(name, run);
    assert_eq!(all.len(), 1, "{name}: {all:?}");
    all.into_values().next().unwrap()
}

fn set_time(run: &mut TracerRun, rays: &str, ms: f64) {
    let trace = run.traces.iter_mut().find(|trace| trace.rays == rays).unwrap();
    (trace.times.median_ms, trace.times.submit_to_done_median_ms) = (ms, Some(ms));
}

/// Every published table has unique name, a paper, as many values a row as columns, and lost figures are `null` and say so.
#[test]
fn published_data_is_whole() {
    let (papers, tables) = (papers().unwrap(), tables().unwrap());
    for (index, table) in tables.iter().enumerate() {
        assert!(tables[..index].iter().all(|other| other.id != table.id), "{}", table.id);
        assert!(papers.contains_key(&table.paper) && !table.what.is_empty() && !table.place.is_empty());
        for row in table.rows.iter().flatten() {
            assert_eq!(row.values.len(), table.columns.len(), "{}", table.id);
        }
        assert!(table.rows.as_ref().is_none_or(|rows| !rows.is_empty()), "{}: an empty table is a lost one", table.id);
    }
    let lost: Vec<&str> = tables.iter().filter(|table| table.rows.is_none()).map(|table| table.id.as_str()).collect();
    assert_eq!(lost, ["dirt-figure2", "dirt-figure8", "dirt-figure10", "dirt-figure11"]);
    for paper in papers.values() {
        assert!(!paper.hardware.is_empty() && paper.setup.iter().all(|each| !each.section.is_empty()));
    }
}

/// Figures that claims and tables share are the same in both: what claims say of the paper's own tables is computed from them.
#[test]
fn claims_agree_with_tables_where_they_say_so() {
    let tables = tables().unwrap();
    let table = |id: &str| tables.iter().find(|table| table.id == id).unwrap();
    let of = |scene: &str, method: &str, column: &str| {
        table("dirt-table2").value(&[("scene", scene), ("method", method)], column).unwrap()
    };
    let percent = |column: &str| {
        let change = |scene| 100.0 * (of(scene, "DIRT", column) / of(scene, "VVP16", column) - 1.0);
        ["Bunny", "Hangar", "Candy"].map(|scene| format!("{:.1}", change(scene).abs())).join(", ")
    };
    let all = claims().unwrap();
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

/// Every claim has a unique name and is decided by a quantity and a table of this paper, or says why not; every quantity decides
/// a claim; ranges are ranges, and those of percentages that the paper states are the ones that the pages announce.
#[test]
fn claims_can_be_decided() {
    let claims = claims().unwrap();
    let papers = papers().unwrap();
    let mut used = Vec::new();
    for (index, claim) in claims.iter().enumerate() {
        assert!(claims[..index].iter().all(|other| other.id != claim.id), "{}", claim.id);
        assert!(papers.contains_key(&claim.paper) && !claim.statement.is_empty() && !claim.section.is_empty());
        assert!(["text", "table", "derived"].contains(&claim.source.as_str()), "{}", claim.source);
        match &claim.test {
            Test::NotMeasurable { not_measurable } => assert!(!not_measurable.is_empty(), "{}", claim.id),
            Test::Measured { table, quantity: name, rule } => {
                let experiment = find(table).unwrap_or_else(|| panic!("{}: no table {table}", claim.id));
                assert_eq!(experiment.paper, claim.paper);
                let quantity = quantity(name).unwrap_or_else(|| panic!("{}: no quantity {name}", claim.id));
                used.push(quantity.name);
                assert!(rule.least.is_some() || rule.most.is_some(), "{}", claim.id);
                assert!(rule.least.zip(rule.most).is_none_or(|(least, most)| least <= most), "{}", claim.id);
                if let (Some([stated]), "%") = (claim.published.as_deref(), claim.unit.as_str()) {
                    let room = (stated / 2.0).min(10.0);
                    assert_eq!((rule.least, rule.most), (Some(stated - room), Some(stated + room)), "{}", claim.id);
                    assert_eq!((quantity.unit, rule.over), ("%", Over::Median), "{}", claim.id);
                }
            }
        }
    }
    for (index, quantity) in QUANTITIES.iter().enumerate() {
        assert!(QUANTITIES[..index].iter().all(|other| other.name != quantity.name));
        assert!(used.contains(&quantity.name), "{} decides nothing", quantity.name);
    }
}

/// Experiments name scenes, ray sets, tracers, parameters, values and published tables that exist, no row twice in a step, and
/// no name is that of another table.
#[test]
fn experiments_name_what_exists() {
    let catalogue: Vec<&str> = tracebench_scenes::catalogue().iter().map(|entry| entry.name).collect();
    let published = tables().unwrap();
    let names: Vec<&str> = Table::all().map(Table::name).collect();
    for experiment in EXPERIMENTS {
        assert_eq!(names.iter().filter(|name| **name == experiment.name).count(), 1);
        assert!(papers().unwrap().contains_key(experiment.paper) && !experiment.scenes.is_empty());
        assert!(experiment.scenes.iter().all(|each| catalogue.contains(&each.scene)), "{}", experiment.name);
        let sets = experiment.rays.split(',').filter(|name| !name.is_empty());
        assert!(sets.into_iter().all(|name| RAY_SETS.iter().any(|set| set.name == name)), "{}", experiment.name);
        assert!(experiment.published.iter().all(|id| published.iter().any(|table| table.id == *id)));
        assert!(experiment.settings.iter().all(|setting| setting.starts_with("rays.")));
        for (step, requests) in experiment.steps.iter().zip(experiment.requests()) {
            let combinations = |row: &Row| row.values.iter().map(|(_, values)| values.len()).product::<usize>();
            assert_eq!(requests.len(), step.rows.iter().map(combinations).sum::<usize>(), "{}", experiment.name);
            for (index, request) in requests.iter().enumerate() {
                let same =
                    |other: &TracerRequest| other.name() == request.name() && other.parameters == request.parameters;
                assert!(!requests[..index].iter().any(same), "{} has {:?} twice", experiment.name, request.changed);
                assert!(!request.required && experiment.holds(request.name()));
            }
        }
        assert!(!experiment.holds("no-such"));
    }
    assert!(find("no-such").is_none() && Table::find("dirt-table1").is_some() && Table::find("bvh").is_some());
}

/// Steps scale ray image, frame and faces alike and never to nothing, and a step of too many rays is refused.
#[test]
fn steps_scale_the_resolution() {
    let experiment = find("dirt-figure8").unwrap();
    let plan = |size: [u32; 2]| crate::plan::Plan {
        scenes: Vec::new(),
        tracers: Vec::new(),
        ray_sets: Vec::new(),
        ray_parameters: crate::rays::default_parameters(),
        preset: crate::plan::RunPreset { ray_image: size, ..RUN_PRESETS[1] },
        view: crate::plan::ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        end: tracebench_api::EndPoint::Hit,
        table: None,
    };
    let steps = experiment.requests();
    let plans = experiment.plans(&plan([256, 128]), &steps).unwrap();
    let sizes: Vec<_> = plans.iter().map(|plan| (plan.preset.ray_image, plan.preset.frame, plan.preset.face)).collect();
    let at = |factor: u32| ([64 * factor, 32 * factor], [128 * factor, 64 * factor], 64 * factor);
    assert_eq!(sizes, [1, 2, 4, 8].map(at));
    assert!(plans.iter().all(|plan| plan.table == Some("dirt-figure8") && plan.tracers.len() == 3));
    assert_eq!(experiment.plans(&plan([1, 1]), &steps).unwrap()[0].preset.ray_image, [1, 1]);
    let refused = experiment.plans(&plan([4096, 4096]), &steps).err().unwrap();
    assert!(refused.to_string().contains("--size"), "{refused}");
}

/// Rules look at the values that they name: one scene beyond the range decides "every" alone.
#[test]
fn rules_hold_over_what_they_name() {
    let rule = |over| Rule { over, least: Some(1.0), most: Some(2.0) };
    let [median, every, most] = [Over::Median, Over::Every, Over::Most].map(rule);
    for (values, expected) in [
        (vec![1.0, 1.5, 2.0], [true, true, true]),
        (vec![1.0, 1.5, 9.0], [true, false, true]),
        (vec![1.5, 9.0], [false, false, false]),
        (vec![0.0, 1.0, 1.0, 9.0], [true, false, false]),
        (vec![3.0], [false, false, false]),
    ] {
        assert_eq!([median, every, most].map(|rule| rule.holds(&values)), expected, "{values:?}");
    }
    let open = Rule { over: Over::Every, least: None, most: Some(0.0) };
    assert!(open.holds(&[-5.0, 0.0]) && !open.holds(&[1e-9]));
    assert_eq!(open.words(), "every scene at most 0");
}

/// Over B and tile size of one scene, bytes and references given.
fn over_buckets(scene: &str, of: impl Fn(u64, u64) -> (u64, f64)) -> Vec<TracerRun> {
    let mut runs = Vec::new();
    for tile_size in [1, 2, 4] {
        for buckets in [8, 16, 24, 32, 40] {
            let (bytes, references) = of(tile_size, buckets);
            let parameters = json!({ "tile_size": tile_size.to_string(), "buckets": buckets });
            let mut run = dirt(scene, parameters, &[("references", references), ("parts", references.sqrt())]);
            run.memory.structure.truncate(1);
            run.memory.structure[0].used_bytes = bytes;
            runs.push(run);
        }
    }
    runs
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
    let run = run_of(over_buckets("a", of));
    assert!((value("references_saved_1_to_2", &run) - 56.0).abs() < 1e-9);
    assert!((value("references_saved_2_to_4", &run) - 50.0).abs() < 1e-9);
    let parts = 100.0 * (1.0 - 0.44_f64.sqrt());
    assert!((value("samples_saved_1_to_2", &run) - parts).abs() < 1e-9);
    assert!((value("samples_saved_2_to_4", &run) - 100.0 * (1.0 - 0.5_f64.sqrt())).abs() < 1e-9);
    assert!((value("memory_saved_1_to_2", &run) - 50.0).abs() < 0.1);
    let steps = [8.0, 16.0, 24.0, 32.0].map(|buckets| 100.0 * (80.0 / (1000.0 + 10.0 * buckets)));
    assert!((value("memory_growth_per_8_buckets_1", &run) - steps.iter().sum::<f64>() / 4.0).abs() < 1e-9);
    assert!((value("greatest_references_ratio_of_tiles", &run) - 0.5).abs() < 1e-9);
    assert!(values("memory_saving_spread", &run).is_empty());
    let mut two = run_of(over_buckets("a", of));
    two.runs.extend(over_buckets("b", |tile_size, buckets| {
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
        let mut run = dirt(scene, parameters, &[("references", references)]);
        let part = run.memory.structure[0].clone();
        let bytes = [("depth bounds texture", bounds), ("id buffer: nodes", fixed + 8 * references as u64)];
        run.memory.structure = bytes
            .map(|(name, used_bytes)| tracebench_api::MemoryEntry { name: name.to_owned(), used_bytes, ..part.clone() })
            .to_vec();
        run
    };
    // Six faces of 128x128 tiles, eight bytes each, and mipmaps.
    let level_zero = 6 * 128 * 128 * 8;
    let run = run_of(vec![with("a", 1e5, 0, level_zero * 4 / 3), with("b", 3e5, 0, level_zero * 4 / 3)]);
    assert!(values("mipmap_factor", &run).values().all(|factor| (factor - 4.0 / 3.0).abs() < 1e-5));
    assert!((value("bytes_a_reference", &run) - 8.0).abs() < 1e-9);
    let linear = run_of(vec![with("a", 1e5, 0, 0), with("b", 3e5, 0, 0)]);
    assert!((value("memory_exponent_over_references", &linear) - 1.0).abs() < 1e-9);
    let constant = run_of(vec![with("a", 1e5, 10_000_000_000_000, 0), with("b", 3e5, 10_000_000_000_000, 0)]);
    assert!(value("memory_exponent_over_references", &constant) < 1e-6);
    // One scene has no slope, and other parameters are no other scene.
    assert!(values("bytes_a_reference", &run_of(vec![with("a", 1e5, 0, 0)])).is_empty());
    let mut other = with("b", 3e5, 0, 0);
    other.tracer.parameters.insert("buckets".to_owned(), json!(4));
    assert!(values("bytes_a_reference", &run_of(vec![with("a", 1e5, 0, 0), other])).is_empty());
    assert_eq!(values("equation_1b_beyond_last_bucket", &run).into_values().collect::<Vec<_>>(), [1.0, 1.0]);
}

fn set_wrong(run: &mut TracerRun, false_miss: u64, late: u64) {
    for trace in &mut run.traces {
        let Judgement::Closest(closest) = &mut trace.judgement else { continue };
        let classes = &mut closest.classes.tight;
        (classes.false_miss, classes.late, classes.early, classes.false_hit) = (false_miss, late, 0, 0);
        let trials = trace.count - closest.ties;
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
        let mut run = dirt("a", parameters, &[]);
        set_wrong(&mut run, wrong[0], wrong[1]);
        run
    };
    let rows = [row("until_hit", "tile", [5, 40]), row("all", "tile", [5, 0]), row("all", "distance", [0, 0])];
    let run = run_of(rows.to_vec());
    let per_million = 1e6 / (fixture::COUNT - 12) as f64;
    assert!((value("early_stop_wrong_rays", &run) - 40.0 * per_million).abs() < 1e-6);
    assert!((value("tile_acceptance_false_misses", &run) - 5.0 * per_million).abs() < 1e-6);
    // Without the counterpart, or with other rays there, there is no figure.
    assert!(values("early_stop_wrong_rays", &run_of(vec![rows[0].clone()])).is_empty());
    let mut other = rows[1].clone();
    other.traces.iter_mut().for_each(|trace| trace.rays_sha256 += "0");
    assert!(values("early_stop_wrong_rays", &run_of(vec![rows[0].clone(), other])).is_empty());
    // A coarser tile may be better or worse: both are a change.
    let tile = |tile_size: &str, late: u64| {
        let mut run = row("until_hit", "tile", [0, late]);
        run.tracer.parameters.insert("tile_size".to_owned(), json!(tile_size));
        run
    };
    let run = run_of(vec![tile("1", 10), tile("2", 10), tile("4", 7), tile("8", 12)]);
    assert!((value("coarse_tiles_agreement_change", &run) - 3.0 * per_million).abs() < 1e-3);
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
    assert!((value("greatest_step_to_less_coherent", &run_of(vec![fast.clone()])) - 0.8).abs() < 1e-9);
    let both = run_of(vec![fast.clone(), slow.clone()]);
    assert!((value("greatest_step_to_less_coherent", &both) - 1.25).abs() < 1e-9);
    let (one, other) = (&fast.traces[0].times, &slow.traces[0].times);
    assert!((rows::time_ratio(one, other).unwrap() - 25.0 / 16.0).abs() < 1e-9);
    let mut on_host = other.clone();
    (on_host.clock, on_host.median_ms) = (ClockKind::Host, 50.0);
    assert!((rows::time_ratio(one, &on_host).unwrap() - 0.5).abs() < 1e-9);
    let mut untimed = other.clone();
    untimed.samples_ms.clear();
    assert_eq!(rows::time_ratio(one, &untimed), None);
}

/// Beside a hierarchy over two resolutions: slopes are per ray added, totals count shadow rays twice.
#[test]
fn resolutions_are_told_apart() {
    let row = |tracer: &str, image: u32, build: f64, times: [f64; 3]| {
        let mut run = dirt("a", json!({}), &[]);
        run.tracer.name = tracer.to_owned();
        run.viewpoint.ray_image = [image, image];
        run.build.times.submit_to_done_median_ms = Some(build);
        for (trace, (rays, ms)) in run.traces.iter_mut().zip(["diffuse", "primary", "visibility"].iter().zip(times)) {
            trace.rays = (*rays).to_owned();
            trace.times.submit_to_done_median_ms = Some(ms);
            trace.count = u64::from(image * image);
        }
        run
    };
    let run = run_of(vec![
        row("dirt", 10, 5.0, [4.0, 1.0, 1.0]),
        row("lbvh-gpu", 10, 20.0, [2.0, 1.0, 0.5]),
        row("lbvh-gpu", 20, 18.0, [8.0, 2.0, 1.0]),
        row("dirt", 20, 6.0, [34.0, 3.0, 2.0]),
    ]);
    assert!((value("diffuse_slope_over_bvh", &run) - 5.0).abs() < 1e-9);
    assert!((value("least_bvh_build_over_dirt", &run) - 3.0).abs() < 1e-9);
    assert!((value("least_diffuse_time_over_bvh", &run) - 2.0).abs() < 1e-9);
    let gains = [24.0 / 12.0, 30.0 / 47.0];
    assert!((value("total_gain_last_over_first", &run) - gains[1] / gains[0]).abs() < 1e-9);
    let lowest = run_of(run.runs[..2].to_vec());
    assert!(values("diffuse_slope_over_bvh", &lowest).is_empty());
    assert!(values("total_gain_last_over_first", &lowest).is_empty());
}

/// What a larger tile gains is compared over resolutions, of finely tessellated scenes alone.
#[test]
fn gains_of_tiles_are_compared_over_resolutions() {
    let row = |tile_size: &str, image: u32, parts: f64, ms: f64| {
        let parameters = json!({ "tile_size": tile_size, "coverage": "conservative", "searched": "until_hit" });
        let mut run = dirt("a", parameters, &[("parts", parts), ("occupied_tiles", 10.0)]);
        run.viewpoint.ray_image = [image, image];
        set_time(&mut run, "diffuse", ms);
        run
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

fn claim_of(id: &str) -> Claim {
    claims().unwrap().into_iter().find(|claim| claim.id == id).unwrap()
}

/// A run that has what is claimed holds, one that has not does not, one without the rows is not measured, and neither is one
/// of another table; values and table are kept.
#[test]
fn verdicts_follow_from_values() {
    let claim = claim_of("dirt-references-2x2");
    let run = |saved: f64| {
        let of = move |tile_size: u64, _| (1000, if tile_size == 1 { 1000.0 } else { 1000.0 * (1.0 - saved) });
        run_of([over_buckets("a", of), over_buckets("b", of)].concat())
    };
    let judged = |run: &Run| judge(&claim, "dirt-figure10", &Rows::of(run));
    let holds = judged(&run(0.56));
    assert_eq!((holds.verdict, holds.values.len(), holds.reason), (Verdict::Holds, 2, None));
    assert!((holds.median.unwrap() - 56.0).abs() < 1e-9);
    assert_eq!(holds.measured_by.unwrap().table, "dirt-figure10");
    let fails = judged(&run(0.2));
    assert!(fails.verdict == Verdict::DoesNotHold && (fails.values[0].value - 20.0).abs() < 1e-9);
    let lacking = judged(&run_of(vec![dirt("a", json!({ "tile_size": "1", "buckets": 24 }), &[("references", 5.0)])]));
    assert!(lacking.verdict == Verdict::NotMeasured && lacking.values.is_empty() && lacking.reason.is_some());
    assert_eq!(judge(&claim, "dirt-table1", &Rows::of(&run(0.56))).verdict, Verdict::NotMeasured);
    let never = claim_of("dirt-memory-vs-fragments");
    assert_eq!(judge(&never, "dirt-table2", &Rows::of(&run(0.56))).verdict, Verdict::NotMeasurable);
}

/// Claims about times of rasterization are decided on hardware alone; on a software adapter the values stand all the same.
#[test]
fn rasterization_is_timed_on_hardware_alone() {
    let claim = claim_of("dirt-buckets-build-linear");
    assert!(claim.needs_hardware_raster);
    let mut runs = over_buckets("a", |_, _| (1000, 1000.0));
    for run in &mut runs {
        let step = (run.tracer.parameters["buckets"].as_f64().unwrap() - 8.0) / 8.0;
        run.build.times.median_ms = 10.0 * 1.02_f64.powf(step);
    }
    let software = run_of(runs);
    let mut hardware = software.clone();
    hardware.machine.adapter.as_mut().unwrap().kind = "discrete".to_owned();
    let judged = |run: &Run| judge(&claim, "dirt-figure10", &Rows::of(run));
    let (here, there) = (judged(&software), judged(&hardware));
    assert_eq!((here.verdict, there.verdict), (Verdict::NotMeasurable, Verdict::Holds));
    assert!(here.values == there.values && (here.median.unwrap() - 2.0).abs() < 1e-9);
    hardware.runs.iter_mut().for_each(|run| run.build.times.median_ms = 10.0);
    assert_eq!(judged(&hardware).verdict, Verdict::DoesNotHold);
    hardware.machine.adapter = None;
    assert_eq!(judged(&hardware).verdict, Verdict::NotMeasurable);
}

/// All claims of a paper are set together, each once or once a run of its table; what no run measures names the table.
#[test]
fn claims_are_set_together() {
    let claims = claims().unwrap();
    let of = |tile_size: u64, _| (1000, 1000.0 / tile_size as f64);
    let run = Run { table: Some("dirt-figure10".to_owned()), ..run_of(over_buckets("a", of)) };
    let none = judge_all(&claims, "dirt", &[]);
    assert_eq!(none.len(), claims.len());
    assert!(none.iter().all(|each| matches!(each.verdict, Verdict::NotMeasured | Verdict::NotMeasurable)));
    let missing = none.iter().find(|each| each.claim.id == "dirt-samples-2x2").unwrap();
    assert!(missing.reason.as_ref().unwrap().contains("tracebench table dirt-figure10"));
    let twice = judge_all(&claims, "dirt", &[run.clone(), run]);
    let found: Vec<_> = twice.iter().filter(|each| each.claim.id == "dirt-references-2x2").collect();
    assert!(found.len() == 2 && found.iter().all(|each| each.verdict == Verdict::Holds));
    assert!(judge_all(&claims, "no-such", &[]).is_empty());
}

/// Scenes of the same name from other viewpoints are two, and say so; other resolutions are the same scene.
#[test]
fn rows_are_sorted_by_scene() {
    let one = dirt("a", json!({}), &[]);
    let (mut finer, mut elsewhere) = (one.clone(), one.clone());
    finer.viewpoint.ray_image = [1024, 512];
    elsewhere.viewpoint.eye = [9.0; 3];
    elsewhere.viewpoint.name = "yard".to_owned();
    let run = run_of(vec![one, finer, elsewhere]);
    let rows = Rows::of(&run);
    let labels: Vec<&str> = rows.scenes.iter().map(|scene| scene.label.as_str()).collect();
    assert_eq!(labels, ["a from door", "a from yard"]);
    assert_eq!(rows.scenes[0].by_resolution().len(), 2);
}

/// Steps of the pyramid are taken from the counters of the same rows, and what is not counted is no figure.
#[test]
fn counters_are_those_of_their_rows() {
    let row = |tile_size: &str, per_ray: f64| {
        let mut run = dirt("a", json!({ "tile_size": tile_size, "buckets": 24 }), &[]);
        let counter = CounterRecord { total: 1, per_ray, greatest_per_ray: None };
        run.traces[0].counters.insert("pyramid_steps".to_owned(), counter);
        run
    };
    let mut run = run_of(vec![row("1", 40.0), row("4", 10.0)]);
    assert!((value("pyramid_steps_4_over_1", &run) - 0.25).abs() < 1e-12);
    run.runs[1].traces[0].counters.clear();
    assert!(values("pyramid_steps_4_over_1", &run).is_empty());
}
