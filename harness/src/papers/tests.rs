//! The data is whole, experiments name what exists, quantities are what they say, verdicts follow from them.

use serde_json::json;

use super::fixture::{in_interleaved_sets, run_of, set_build};
use super::*;
use crate::plan::{RUN_PRESETS, TracerRequest};
use crate::rays::RAY_SETS;
use crate::results::Record;
use of_dirt::{dirt, over_buckets};
use of_vvp16::variants;

#[path = "dirt/tests/mod.rs"]
mod of_dirt;
#[path = "hhz14/tests/mod.rs"]
mod of_hhz14;
#[path = "vvp16/tests/mod.rs"]
mod of_vvp16;
#[path = "wkp15/tests/mod.rs"]
mod of_wkp15;
#[path = "told_tests.rs"]
mod told;

/// What every paper printed.
fn published() -> Vec<(&'static Paper, Published)> {
    PAPERS.iter().map(|paper| (*paper, paper.published.clone())).collect()
}

fn tables() -> Vec<PublishedTable> {
    published().into_iter().flat_map(|(_, published)| published.tables).collect()
}

/// Every claim of every paper.
fn claims() -> Vec<(&'static Paper, Claim)> {
    PAPERS.iter().flat_map(|paper| paper.claims.iter().map(|claim| (*paper, claim.clone()))).collect()
}

/// Every published table has unique name, a paper, as many values a row as columns, and lost figures are `null`.
#[test]
fn published_data_is_whole() {
    let (papers, tables) = (published(), tables());
    for (index, table) in tables.iter().enumerate() {
        assert!(tables[..index].iter().all(|other| other.id != table.id), "{}", table.id);
        assert!(!table.what.is_empty() && !table.place.is_empty());
        for row in table.rows.iter().flatten() {
            assert_eq!(row.values.len(), table.columns.len(), "{}", table.id);
        }
        assert!(table.rows.as_ref().is_none_or(|rows| !rows.is_empty()), "{}: an empty table is a lost one", table.id);
    }
    for (index, (paper, Published { paper: publication, tables })) in papers.iter().enumerate() {
        assert!(papers[..index].iter().all(|(other, _)| other.name != paper.name), "{}", paper.name);
        assert!(tables.iter().all(|table| table.paper == paper.name), "{}", paper.name);
        assert!(!publication.hardware.is_empty());
        for setting in &publication.setup {
            assert!(
                setting.keys().all(|key| ["name", "value", "section", "note"].contains(&key.as_str())),
                "{setting:?}"
            );
            let is_there = |key| setting.get(key).is_some_and(Option::is_some);
            let says = |key| setting.get(key).is_some_and(|text| text.as_ref().is_some_and(|text| !text.is_empty()));
            assert!(is_there("name") && is_there("note") && says("section"), "{setting:?}");
        }
    }
}

/// Every claim has a unique name and is decided by a quantity and a table of this paper, or says why not; every quantity decides
/// a claim; ranges are ranges, and those of percentages that the paper states are the ones that the pages announce.
#[test]
fn claims_can_be_decided() {
    let claims = claims();
    let mut used = Vec::new();
    for (index, (paper, claim)) in claims.iter().enumerate() {
        assert!(claims[..index].iter().all(|(_, other)| other.id != claim.id), "{}", claim.id);
        assert!(claim.paper == paper.name && !claim.statement.is_empty() && !claim.section.is_empty());
        assert!(["text", "table", "derived"].contains(&claim.source.as_str()), "{}", claim.source);
        match &claim.test {
            Test::NotMeasurable { not_measurable } => assert!(!not_measurable.is_empty(), "{}", claim.id),
            Test::Measured { table, quantity: name, either, scenes, rule } => {
                let experiment = paper.experiment(table).unwrap_or_else(|| panic!("{}: no table {table}", claim.id));
                let stands = |name: &String| experiment.scenes.iter().any(|scene| scene.published == name);
                assert!(scenes.iter().all(stands), "{}: {scenes:?}", claim.id);
                let quantity = paper.quantity(name).unwrap_or_else(|| panic!("{}: no quantity {name}", claim.id));
                used.push((paper.name, &*quantity.name));
                for either in either {
                    let other = paper.quantity(either).unwrap_or_else(|| panic!("{}: no quantity {either}", claim.id));
                    assert!(other.unit == quantity.unit && other.name != quantity.name, "{}", claim.id);
                    used.push((paper.name, &*other.name));
                }
                assert!(rule.least.is_some() || rule.most.is_some(), "{}", claim.id);
                assert!(rule.least.zip(rule.most).is_none_or(|(least, most)| least <= most), "{}", claim.id);
                if let (Some([stated]), "%") = (claim.published.as_deref(), claim.unit.as_str()) {
                    let room = (stated / 2.0).min(10.0);
                    assert_eq!((rule.least, rule.most), (Some(stated - room), Some(stated + room)), "{}", claim.id);
                    assert_eq!((&*quantity.unit, rule.over), ("%", Over::Median), "{}", claim.id);
                }
            }
        }
    }
    for paper in PAPERS {
        let own: Vec<&str> = paper.told.quantities.iter().map(|quantity| quantity.name.as_str()).collect();
        for (index, name) in own.iter().enumerate() {
            assert!(!own[..index].contains(name), "{name} twice");
            assert!(used.contains(&(paper.name, *name)), "{name} decides nothing of {}", paper.name);
        }
    }
}

/// Experiments name scenes, ray sets, tracers, parameters, values and published tables that exist, no row twice in a step; they
/// are named after their paper.
#[test]
fn experiments_name_what_exists() {
    let catalogue: Vec<&str> = tracebench_scenes::catalogue().iter().map(|entry| entry.name).collect();
    for (paper, experiment) in PAPERS.iter().flat_map(|paper| paper.experiments.iter().map(move |each| (paper, each))) {
        let published = &paper.published.tables;
        assert!(experiment.name.strip_prefix(paper.name).is_some_and(|rest| rest.starts_with('-')));
        assert!(!experiment.scenes.is_empty());
        assert!(experiment.scenes.iter().all(|each| catalogue.contains(&each.scene)), "{}", experiment.name);
        let sets = experiment.rays.split(',').filter(|name| !name.is_empty());
        assert!(sets.into_iter().all(|name| RAY_SETS.iter().any(|set| set.name == name)), "{}", experiment.name);
        assert!(experiment.published.iter().all(|id| published.iter().any(|table| table.id == *id)));
        assert!(experiment.settings.iter().all(|setting| setting.starts_with("rays.")));
        let common = &page::told::COMMON.tables;
        let own = |name: &&str| common.contains_key(*name) || paper.pages.tables.contains_key(*name);
        let is_section =
            |name: &&str| name.strip_prefix("beside ").map_or_else(|| own(name), |it| experiment.holds(it));
        assert!(experiment.sections.iter().all(is_section), "{}", experiment.name);
        assert!(experiment.charts.iter().all(|name| paper.pages.charts.contains_key(*name)));
        let few = experiment.few_rows.iter().flatten();
        assert!(few.into_iter().all(|row| experiment.holds(row.tracer)), "{}", experiment.name);
        for step in &experiment.steps {
            let mut values = crate::rays::default_parameters();
            for (name, value) in &step.rays {
                values.set(&crate::rays::ray_parameters(), name, value).unwrap();
            }
            assert!((tracebench_scenes::SCALE_MIN..=tracebench_scenes::SCALE_MAX).contains(&step.scale));
        }
        for (step, requests) in experiment.steps.iter().zip(experiment.requests()) {
            let combinations = |row: &ExperimentRow| {
                let known = crate::registry::find(row.tracer).unwrap().describe().parameters;
                let has = |name: &str| experiment.launch && known.iter().any(|parameter| parameter.name == name);
                let launch = experiment::MEANS.iter().filter(|(name, _)| has(name));
                let own = row.values.iter().map(|(_, values)| values.len());
                own.chain(launch.map(|(_, values)| values.len())).product::<usize>()
            };
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
    assert!(find("no-such").is_none());
}

/// A plan of nothing yet, with rays from an image of this size.
fn plan(size: [u32; 2]) -> crate::plan::Plan {
    crate::plan::Plan {
        scenes: Vec::new(),
        tracers: Vec::new(),
        ray_sets: Vec::new(),
        ray_parameters: crate::rays::default_parameters(),
        preset: RunPreset { ray_image: size, ..RUN_PRESETS[1] },
        view: crate::plan::ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        trace_to: TraceTo::Hit,
        builds_timed: true,
        wrong_rays_per_cause: crate::judge::WRONG_RAYS_PER_CAUSE,
        table: None,
    }
}

/// Steps scale ray image, frame and faces alike and never to nothing, and a step of too many rays is refused.
#[test]
fn steps_scale_the_resolution() {
    let (_, experiment) = find("dirt-figure8").unwrap();
    let steps = experiment.requests();
    let plans = experiment.plans(&plan([256, 128]), &steps).unwrap();
    let sizes: Vec<_> = plans.iter().map(|plan| (plan.preset.ray_image, plan.preset.frame, plan.preset.face)).collect();
    let at = |factor: u32| ([64 * factor, 32 * factor], [128 * factor, 64 * factor], 64 * factor);
    assert_eq!(sizes, [1, 2, 4, 8].map(at));
    assert!(plans.iter().all(|plan| plan.table == Some("dirt-figure8") && plan.tracers.len() == steps[0].len()));
    assert_eq!(experiment.plans(&plan([1, 1]), &steps).unwrap()[0].preset.ray_image, [1, 1]);
    let refused = experiment.plans(&plan([4096, 4096]), &steps).err().unwrap();
    assert!(refused.to_string().contains("--size"), "{refused}");
}

/// Steps that are about rays or triangles say so in their plans, whatever the base says, and leave all else; the paper's scenes are stood
/// for at their own scale and at those of the steps alone.
#[test]
fn steps_have_their_own_rays_and_scales() {
    let base = |parameters| crate::plan::Plan { ray_parameters: parameters, ..plan([64, 32]) };
    let mut said = crate::rays::default_parameters();
    let known = crate::rays::ray_parameters();
    for (name, value) in [("lens_count", "2"), ("lens_aperture", "0.5")] {
        said.set(&known, name, value).unwrap();
    }
    let (_, lens) = find("wkp15-table4").unwrap();
    let plans = lens.plans(&base(said), &lens.requests()).unwrap();
    let of = |name: &str| -> Vec<String> {
        plans.iter().map(|plan| plan.ray_parameters.value(name).unwrap().to_string()).collect()
    };
    assert_eq!(of("lens_count"), ["4", "8", "8", "32"]);
    assert_eq!(of("lens_aperture"), ["0.5"; 4]);
    let (_, trees) = find("wkp15-table1").unwrap();
    let plans = trees.plans(&base(crate::rays::default_parameters()), &trees.requests()).unwrap();
    assert!(plans.iter().map(|plan| plan.preset.scene_scale).eq([1.0, 4.0, 15.5]));
    let at = |scale: f64, experiment: &Experiment| {
        let mut scene = dirt("candy", json!({}), &[]).scene;
        scene.scale = Some(scale);
        experiment.stands_for(&scene)
    };
    assert_eq!([1.0, 4.0, 15.5, 2.0].map(|scale| at(scale, trees).is_some()), [true, true, true, false]);
    let (_, other) = find("dirt-table1").unwrap();
    assert_eq!([1.0, 15.5].map(|scale| at(scale, other).is_some()), [true, false]);
}

/// At the run preset `paper` a paper has the resolutions that it states, at any other those of all.
#[test]
fn papers_have_their_resolutions() {
    let resolved = |name: &str, preset: &str| {
        let preset =
            PAPERS.iter().find(|paper| paper.name == name).unwrap().resolved(RunPreset::named(preset).unwrap());
        (preset.ray_image, preset.frame, preset.face)
    };
    assert_eq!(resolved("wkp15", "paper"), ([1600, 900], [1600, 900], 1024));
    assert_eq!(resolved("wkp15", "quick"), resolved("dirt", "quick"));
    assert_eq!(resolved("dirt", "paper"), ([1024, 512], [1024, 512], 512));
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
        let counted: Vec<Estimate> = values.iter().copied().map(Estimate::from).collect();
        let expected = expected.map(|holds| if holds { Verdict::Holds } else { Verdict::DoesNotHold });
        assert_eq!([median, every, most].map(|rule| rule.decide(&counted)), expected, "{values:?}");
    }
    let open = Rule { over: Over::Every, least: None, most: Some(0.0) };
    assert_eq!(open.decide(&[(-5.0).into(), 0.0.into()]), Verdict::Holds);
    assert_eq!(open.decide(&[1e-9.into()]), Verdict::DoesNotHold);
    assert_eq!(open.describe(), "every scene at most 0");
}

/// What is timed decides where its interval lies on one side of every end of the range, and where nothing hangs on those that do
/// not; what is doubted decides nothing, however clear its interval.
#[test]
fn open_intervals_decide_nothing() {
    let rule = |over| Rule { over, least: Some(1.0), most: Some(2.0) };
    let rules = [Over::Median, Over::Every, Over::Most].map(rule);
    let timed = |interval: [f64; 2]| Estimate::timed(f64::midpoint(interval[0], interval[1]), interval, []);
    let doubted = timed([1.4, 1.6]).doubted("drift".to_owned());
    let [inside, below, over_end] = [[1.2, 1.8], [0.1, 0.2], [1.5, 2.1]].map(timed);
    use Verdict::{DoesNotHold as Fails, Holds, Undecided as Open};
    for (found, expected) in [
        (vec![&inside], [Holds; 3]),
        (vec![&below], [Fails; 3]),
        (vec![&over_end], [Open; 3]),
        (vec![&doubted], [Open; 3]),
        (vec![&inside, &inside, &doubted], [Holds, Open, Holds]),
        (vec![&inside, &inside, &over_end], [Holds, Open, Holds]),
        (vec![&inside, &below, &over_end], [Holds, Fails, Open]),
        (vec![&below, &over_end], [Open, Fails, Fails]),
        (vec![&below, &below, &doubted], [Fails; 3]),
    ] {
        let found: Vec<Estimate> = found.into_iter().cloned().collect();
        assert_eq!(rules.map(|rule| rule.decide(&found)), expected, "{found:?}");
    }
}

fn claim_of(id: &str) -> (&'static Paper, Claim) {
    claims().into_iter().find(|(_, claim)| claim.id == id).unwrap()
}

/// A run that has what is claimed holds, one that has not does not, one without the rows is not measured, and neither is one
/// of another table; values and table are kept.
#[test]
fn verdicts_follow_from_values() {
    let (paper, claim) = claim_of("dirt-references-2x2");
    let record = |saved: f64| {
        let of = move |tile_size: u64, _| (1000, if tile_size == 1 { 1000.0 } else { 1000.0 * (1.0 - saved) });
        run_of([over_buckets("cloth", of), over_buckets("room", of)].concat())
    };
    let judged = |record: &Record| judge(paper, &claim, &Rows::of(record));
    let holds = judged(&record(0.56));
    assert_eq!((holds.verdict, holds.values.len(), holds.reason), (Verdict::Holds, 2, None));
    assert!((holds.median.unwrap() - 56.0).abs() < 1e-9);
    assert_eq!(holds.measured_by.unwrap().table, "dirt-figure10");
    let fails = judged(&record(0.2));
    assert!(fails.verdict == Verdict::DoesNotHold && (fails.values[0].value - 20.0).abs() < 1e-9);
    let lacking =
        judged(&run_of(vec![dirt("room", json!({ "tile_size": "1", "buckets": 24 }), &[("references", 5.0)])]));
    assert!(lacking.verdict == Verdict::NotMeasured && lacking.values.is_empty() && lacking.reason.is_some());
    assert_eq!((lacking.scenes, lacking.measured_by.unwrap().rows), ([1, 3], [1, 45]));
    // What stands for none of the paper's scenes decides nothing: another scene, a smaller one, a file of the same name.
    for (name, scale) in [("barn", Some(1.0)), ("cloth", Some(0.05)), ("cloth", None)] {
        let mut other = record(0.56);
        for one in &mut other.rows {
            (one.scene.name, one.scene.scale) = (name.to_owned(), scale);
        }
        let judged = judged(&other);
        assert_eq!((judged.verdict, judged.scenes), (Verdict::NotMeasured, [0, 3]), "{name} {scale:?}");
        assert!(!judged.values.is_empty());
    }
    let (_, never) = claim_of("dirt-cr-lists-oblique");
    assert_eq!(judge(paper, &never, &Rows::of(&record(0.56))).verdict, Verdict::NotMeasurable);
}

/// A claim with several readings holds, or does not, where all say so; it is undecided where they differ, and is not measured where one
/// of them is not. All their values are kept and shown.
#[test]
fn readings_must_agree() {
    let (paper, mut claim) = claim_of("dirt-references-2x2");
    let Test::Measured { either, rule, .. } = &mut claim.test else { panic!("it is measured") };
    *either = vec!["references_saved_2_to_4".to_owned()];
    rule.most = None;
    // References saved to tiles of 2x2, and further to 4x4; the claim asks for at least 46 percent.
    let judged = |[two, four]: [f64; 2]| {
        let of = move |tile_size: u64, _| {
            (1000, 1000.0 * if tile_size > 1 { 1.0 - two } else { 1.0 } * if tile_size > 2 { 1.0 - four } else { 1.0 })
        };
        judge(paper, &claim, &Rows::of(&run_of(over_buckets("room", of))))
    };
    let agreed = [judged([0.5, 0.6]), judged([0.2, 0.1])];
    assert_eq!([&agreed[0], &agreed[1]].map(|each| each.verdict), [Verdict::Holds, Verdict::DoesNotHold]);
    assert!(agreed.iter().all(|each| each.reason.is_none() && each.values.len() == 1 && each.either[0].len() == 1));
    assert!((agreed[0].values[0].value - 50.0).abs() < 1e-9 && (agreed[0].either[0][0].value - 60.0).abs() < 1e-9);
    let flips = [judged([0.5, 0.1]), judged([0.1, 0.5])];
    assert!(flips.iter().all(|each| each.verdict == Verdict::Undecided));
    let [first, second] = flips.map(|each| each.reason.unwrap());
    assert_eq!(first, "by references_saved_1_to_2 holds; by references_saved_2_to_4 does not hold here");
    assert_eq!(second, "by references_saved_1_to_2 does not hold here; by references_saved_2_to_4 holds");
    // Without the other reading's rows.
    let of = |tile_size: u64, _| (1000, 1000.0 / tile_size as f64);
    let mut rows = over_buckets("room", of);
    rows.retain(|row| row.tracer.parameters["tile_size"].as_str() != Some("4"));
    let lacking = judge(paper, &claim, &Rows::of(&run_of(rows)));
    assert!(lacking.verdict == Verdict::NotMeasured && lacking.values.len() == 1 && lacking.either[0].is_empty());
    assert!(lacking.reason.unwrap().contains("references_saved_2_to_4"));
}

/// Claims about times of rasterization are decided on hardware alone; on a software adapter the values stand all the same.
#[test]
fn rasterization_is_timed_on_hardware_alone() {
    let (paper, claim) = claim_of("dirt-buckets-build-linear");
    assert!(claim.needs_hardware_raster);
    let mut rows = over_buckets("room", |_, _| (1000, 1000.0));
    for row in &mut rows {
        let step = (row.tracer.parameters["buckets"].as_f64().unwrap() - 8.0) / 8.0;
        set_build(row, 10.0 * 1.02_f64.powf(step));
    }
    let software = in_interleaved_sets(run_of(rows));
    let mut hardware = software.clone();
    hardware.provenance.machine.adapter.as_mut().unwrap().kind = "discrete".to_owned();
    let judged = |record: &Record| judge(paper, &claim, &Rows::of(record));
    let (here, there) = (judged(&software), judged(&hardware));
    assert_eq!((here.verdict, there.verdict), (Verdict::NotMeasurable, Verdict::Holds));
    assert!(here.values == there.values && (here.median.unwrap() - 2.0).abs() < 1e-9);
    hardware.rows.iter_mut().for_each(|row| set_build(row, 10.0));
    assert_eq!(judged(&hardware).verdict, Verdict::DoesNotHold);
    hardware.provenance.machine.adapter = None;
    assert_eq!(judged(&hardware).verdict, Verdict::NotMeasurable);
}

/// All claims of a paper are set together, each once or once a run of its table; what no run measures names the table.
#[test]
fn claims_are_set_together() {
    let of = |tile_size: u64, _| (1000, 1000.0 / tile_size as f64);
    let record = Record { table: Some("dirt-figure10".to_owned()), ..run_of(over_buckets("room", of)) };
    let none = judge_all(&DIRT, &[]);
    let of_vvp16 = judge_all(&VVP16, &[]);
    assert_eq!([none.len(), of_vvp16.len()], [&DIRT, &VVP16].map(|paper| paper.claims.len()));
    assert_eq!(of_vvp16.len(), 62);
    assert!(none.iter().all(|each| matches!(each.verdict, Verdict::NotMeasured | Verdict::NotMeasurable)));
    let missing = none.iter().find(|each| each.claim.id == "dirt-samples-2x2").unwrap();
    assert!(missing.reason.as_ref().unwrap().contains("tracebench table dirt-figure10"));
    // A run of the same table without the rows adds nothing to one that has them.
    let without = Record { rows: Vec::new(), ..record.clone() };
    for rows in [[record.clone(), without.clone()], [without, record.clone()]] {
        let judged = judge_all(&DIRT, &rows);
        let found: Vec<_> = judged.iter().filter(|each| each.claim.id == "dirt-references-2x2").collect();
        assert!(found.len() == 1 && found[0].verdict == Verdict::Holds);
    }
    let twice = judge_all(&DIRT, &[record.clone(), record]);
    let found: Vec<_> = twice.iter().filter(|each| each.claim.id == "dirt-references-2x2").collect();
    assert!(found.len() == 2 && found.iter().all(|each| each.verdict == Verdict::Holds));
}

/// Scenes of the same name from other viewpoints are two, and say so; other resolutions are the same scene.
#[test]
fn rows_are_sorted_by_scene() {
    let one = dirt("a", json!({}), &[]);
    let (mut finer, mut elsewhere) = (one.clone(), one.clone());
    finer.viewpoint.ray_image = [1024, 512];
    elsewhere.viewpoint.eye = [9.0; 3];
    elsewhere.viewpoint.name = "yard".to_owned();
    let record = run_of(vec![one, finer, elsewhere]);
    let rows = Rows::of(&record);
    let labels: Vec<&str> = rows.scenes.iter().map(|scene| scene.label.as_str()).collect();
    assert_eq!(labels, ["a from door", "a from yard"]);
    assert_eq!(rows.scenes[0].by_resolution().len(), 2);
}

/// A claim about one of the paper's scenes is decided by its stand-in alone, and is not measured where nothing stands for it.
#[test]
fn claims_about_a_scene_look_at_its_stand_in() {
    let (paper, claim) = claim_of("vvp16-skipping-ruins");
    let Test::Measured { table, scenes, .. } = &claim.test else { panic!("it is measured") };
    let stand_in =
        paper.experiment(table).unwrap().scenes.iter().find(|each| *each.published == scenes[0]).unwrap().scene;
    let judged = |scene: &str| {
        let mut rows = variants(scene, [3.0, 1.0]);
        rows.extend(variants("elsewhere", [1.0, 1.0]));
        let record = in_interleaved_sets(run_of(rows));
        judge(paper, &claim, &Rows::of(&record))
    };
    let found = judged(stand_in);
    assert!(found.values.len() == 1 && found.values[0].scene == stand_in, "{:?}", found.values);
    assert!((found.median.unwrap() - 200.0).abs() < 1e-9 && found.verdict == Verdict::Holds);
    let none = judged("nowhere");
    assert!(none.verdict == Verdict::NotMeasured && none.reason.unwrap().contains("Ruins"));
}

/// Chances of orders are those of all orders written out.
#[test]
fn chances_of_orders_are_exact() {
    use itertools::Itertools as _;
    for count in [3, 4, 6] {
        let orders: Vec<Vec<usize>> = (0..count).permutations(count).collect();
        let rank = |order: &[usize]| {
            let pairs: Vec<_> = order.iter().enumerate().map(|(at, place)| (at as f64, *place as f64)).collect();
            let apart = |one: &f64, other: &f64| Some(quantity::sign(one - other).into());
            quantity::rank_correlation(&pairs, apart).unwrap().value
        };
        let ranks: Vec<f64> = orders.iter().map(|order| rank(order)).collect();
        for own in &ranks {
            let as_strong = ranks.iter().filter(|other| other.abs() >= own.abs() - 1e-9).count();
            let expected = as_strong as f64 / orders.len() as f64;
            assert!((quantity::rank_chance(count, *own) - expected).abs() < 1e-9, "{count} {own}");
        }
    }
    // Beyond what the count gives chance makes nothing.
    assert_eq!(quantity::rank_chance(4, 1.1), 0.0);
}
