//! Tunings made up for tests, and what is made of them.

use std::collections::BTreeMap;

use tempfile::TempDir;
use tracebench_api::{ClockKind, Query};

use crate::files::OutputFolder;
use crate::judge::Rule;
use crate::measure::controls::Control;
use crate::report::fixture::{self, Quality, configs, write_derived, write_run};
use crate::report::read_run;
use crate::results::{
    AxisRecord, Judgement, PointRecord, Record, Row, Skipped, SweepRecord, TunedScene, TuningRecord, place_name,
};
use crate::studies::tune::{Judged, Label, SceneTuned, SetTuned, Tuning, ValueTuned, ViewTuned, choose};

pub(in crate::report) const SETS: [(&str, Query); 2] = [("diffuse", Query::Closest), ("ao", Query::Any)];
pub(in crate::report) const VALUES: [&str; 5] = ["0", "0.001", "0.01", "0.02", "0.1"];

/// A tuning of a made-up tracer in scenes of given names, from so many viewpoints: from each the best value is another one, the
/// third, the fourth, and so on, by whatever rule.
pub(in crate::report) fn tuning(values: &[&str], scenes: &[&str], views: usize, sets: &[(&str, Query)]) -> Tuning {
    let run_of = |missed: f64| {
        let quality = Quality { missed, blur: 1e-4, speed: 1.0, clock: ClockKind::Host };
        fixture::run(&[("screen-dda", quality)], sets)
    };
    let sample = run_of(0.1);
    let axis = AxisRecord {
        name: "thickness".to_owned(),
        unit: "scene diagonals".to_owned(),
        effect: "what thickness does".to_owned(),
        own: values[1.min(values.len() - 1)].to_owned(),
        values: values.iter().map(|value| (*value).to_owned()).collect(),
    };
    let mut made: Vec<SceneTuned> = Vec::new();
    for (number, name) in scenes.iter().enumerate() {
        let view = |view: usize| {
            let best = (2 + view + number) % values.len();
            let set = |(place, (rays, query)): (usize, &(&str, Query))| SetTuned {
                rays: (*rays).to_owned(),
                rays_sha256: sample.rows[0].traces[place].rays_sha256.clone(),
                query: *query,
                count: fixture::COUNT,
                values: (0..values.len())
                    .map(|index| {
                        let trace =
                            run_of(0.01 + 0.05 * index.abs_diff(best) as f64).rows.remove(0).traces.remove(place);
                        let statuses = BTreeMap::from([("hit".to_owned(), fixture::COUNT)]);
                        let judged = Judged { hits_sha256: format!("{index:064x}"), statuses, ..trace };
                        ValueTuned { value: values[index].to_owned(), judged: Some(judged), skipped: None }
                    })
                    .collect(),
                choices: Vec::new(),
            };
            let mut viewpoint = sample.rows[0].viewpoint.clone();
            viewpoint.name = ["door", "window", "roof"][view].to_owned();
            ViewTuned { viewpoint, sets: sets.iter().enumerate().map(set).collect(), controls: sample.controls.clone() }
        };
        let views = (0..views).map(view).collect();
        let mut scene = sample.rows[0].scene.clone();
        scene.name = (*name).to_owned();
        made.push(SceneTuned { scene, views });
    }
    choose(&mut made, &axis.own, Rule::Footprint);
    Tuning {
        provenance: fixture::provenance(),
        control_names: Control::names(),
        seed: 1,
        preset: "quick".to_owned(),
        tracer: sample.rows[0].tracer.clone(),
        axis,
        rule: Rule::Footprint,
        scenes: made,
        skipped: vec![Skipped { tracer: None, scene: "hall".to_owned(), rays: None, reason: "no | place".to_owned() }],
    }
}

/// The record that a tuning is derived from: what [`Tuning::of`] takes apart.
fn record(tuning: &Tuning) -> Record {
    let sample = fixture::run(&[], &[]);
    let row =
        fixture::run(&[("screen-dda", Quality { missed: 0.1, blur: 1e-4, speed: 1.0, clock: ClockKind::Host })], &SETS);
    let name = &tuning.axis.name;
    let parameters = |value: &String| {
        let mut parameters = tuning.tracer.parameters.clone();
        parameters.insert(name.clone(), serde_json::Value::from(value.clone()));
        parameters
    };
    let point = |value: &String| PointRecord {
        values: BTreeMap::from([(name.clone(), value.clone())]),
        parameters: parameters(value),
        frame: row.rows[0].viewpoint.frame,
        face: row.rows[0].viewpoint.face,
        skipped: BTreeMap::new(),
    };
    let mut points: Vec<PointRecord> = tuning.axis.values.iter().map(point).collect();
    let (mut rows, mut controls) = (Vec::new(), Vec::new());
    for scene in &tuning.scenes {
        for (at, view) in scene.views.iter().enumerate() {
            controls.extend(view.controls.clone());
            for (index, point) in points.iter_mut().enumerate() {
                let mut one: Row = row.rows[0].clone();
                one.scene = scene.scene.clone();
                one.viewpoint = view.viewpoint.clone();
                one.tracer.parameters = point.parameters.clone();
                one.traces.clear();
                for set in &view.sets {
                    let value = &set.values[index];
                    if let Some(reason) = &value.skipped {
                        point.skipped.insert(place_name(&scene.scene, &view.viewpoint, at), reason.clone());
                    }
                    let Some(judged) = &value.judged else { continue };
                    one.traces.push(judged.clone());
                }
                rows.push(one);
            }
        }
    }
    let tuned = |scene: &SceneTuned| TunedScene {
        scene: scene.scene.clone(),
        viewpoints: scene.views.iter().map(|view| view.viewpoint.clone()).collect(),
    };
    let axes = vec![tuning.axis.clone()];
    Record {
        provenance: tuning.provenance.clone(),
        control_names: tuning.control_names.clone(),
        seed: tuning.seed,
        preset: tuning.preset.clone(),
        sweep: Some(SweepRecord { tracer: tuning.tracer.name.clone(), grid: false, axes, points }),
        tuning: Some(TuningRecord {
            tracer: tuning.tracer.clone(),
            rule: tuning.rule,
            scenes: tuning.scenes.iter().map(tuned).collect(),
        }),
        controls,
        rows,
        interleaved_sets: row.interleaved_sets,
        skipped: tuning.skipped.clone(),
        ..sample
    }
}

/// A tuning as it comes back from its record: controls stand on the viewpoints where they were traced.
fn placed(mut tuning: Tuning) -> Tuning {
    for scene in &mut tuning.scenes {
        for view in &mut scene.views {
            for control in &mut view.controls {
                (control.scene, control.viewpoint) = (scene.scene.clone(), view.viewpoint.clone());
            }
            for set in &mut view.sets {
                for value in &mut set.values {
                    if let Some(judged) = &mut value.judged {
                        judged.judgement.wrong_rays_mut().clear();
                    }
                }
            }
        }
    }
    tuning
}

fn typical() -> Tuning {
    tuning(&VALUES, &["room", "hall"], 2, &SETS)
}

/// Proves that a tuning read back is the same and makes the same files, that its JSON has the head of other records at its top,
/// that a file of another schema is refused, and that charts of an earlier tuning go while others, and the user's, stay.
#[test]
fn files_can_be_made_again() {
    let (folder, elsewhere) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let earlier = OutputFolder::open(folder.path()).unwrap();
    earlier.write_all([("tune_gone.svg", &b"old"[..]), ("sweep_stays.svg", b"old")]).unwrap();
    drop(earlier);
    std::fs::write(folder.path().join("tune_mine.svg"), "mine").unwrap();
    let paths = write_run(&record(&placed(typical())), folder.path(), fixture::tables).unwrap();
    let names: Vec<_> = paths.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
    let expected = [
        "run.json",
        "tune.md",
        "rows.csv",
        "wrong_rays.csv",
        "tune_room.svg",
        "tune_room.png",
        "tune_hall.svg",
        "tune_hall.png",
    ];
    assert_eq!(names, expected);
    let stands = |name: &str| folder.path().join(name).exists();
    assert_eq!(["tune_gone.svg", "sweep_stays.svg", "tune_mine.svg"].map(stands), [false, true, true]);
    let again = read_run(folder.path()).unwrap();
    assert_eq!(Tuning::of(&again).unwrap(), placed(typical()));
    for path in write_derived(&again, elsewhere.path(), fixture::tables).unwrap() {
        let name = path.file_name().unwrap();
        assert!(std::fs::read(&path).unwrap() == std::fs::read(folder.path().join(name)).unwrap(), "{name:?} differs");
    }
    // A record that lost its section is one of a sweep.
    assert!(Tuning::of(&Record { tuning: None, ..again }).is_none());
    let text = std::fs::read_to_string(folder.path().join("run.json")).unwrap();
    assert!(text.contains("\"rule\":\"footprint\"") && !text.contains("tuned"), "{text:.300}");
}

/// Proves that the table tells every value with its labels, its wrong rays by the rule, and what it loses: against the classes
/// of the record, counted here.
#[test]
fn the_table_tells_what_each_value_loses() {
    let made = placed(typical());
    let folder = TempDir::new().unwrap();
    write_run(&record(&made), folder.path(), fixture::tables).unwrap();
    let rows = configs(folder.path());
    assert_eq!(rows.len(), 2 * 2 * 2 * VALUES.len());
    let of = |scene: &str, view: &str, rays: &str| {
        let all =
            rows.iter().filter(move |row| row["scene"] == scene && row["viewpoint"] == view && row["rays"] == rays);
        all.collect::<Vec<_>>()
    };
    let labels = |row: &BTreeMap<String, String>| {
        let of = ["is_default", "is_tuned_here", "is_tuned_elsewhere", "is_tuned_on_the_other_scenes"];
        of.map(|name| row[name].parse::<bool>().unwrap())
    };
    // From the door the third value is best, from the window the fourth; in the hall each is one further.
    let found: Vec<_> = of("room", "door", "diffuse").into_iter().map(labels).collect();
    let none = [false; 4];
    assert_eq!(
        found,
        [none, [true, false, false, false], [false, true, false, false], [false, false, true, true], none]
    );
    for (index, row) in of("room", "door", "diffuse").into_iter().enumerate() {
        let set = &made.scenes[0].views[0].sets[0];
        let Judgement::Closest(closest) = &set.values[index].judged.as_ref().unwrap().judgement else { panic!() };
        let classes = &closest.classes.footprint;
        let counted = ["false_miss", "false_hit", "early", "late"]
            .map(|class| row[&format!("footprint_{class}_rays")].parse::<u64>().unwrap());
        assert_eq!(counted, [classes.false_miss, classes.false_hit, classes.early, classes.late]);
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        let trials = (fixture::COUNT - closest.left_out()) as f64;
        let score = (classes.true_hit + classes.true_miss) as f64 / trials;
        assert_eq!(number("agreement_footprint_share"), score);
        let [low, high] = closest.interval.footprint.unwrap();
        assert_eq!((number("agreement_footprint_share_low"), number("agreement_footprint_share_high")), (low, high));
        let Judgement::Closest(best) = &set.values[2].judged.as_ref().unwrap().judgement else { panic!() };
        assert_eq!(number("lost_to_tuned_here_share"), best.agreement.footprint.unwrap() - score);
        assert!(row["balanced_accuracy_share"].is_empty());
    }
    for row in of("room", "window", "ao") {
        assert!(row["agreement_tight_share"].is_empty() && !row["balanced_accuracy_share"].is_empty(), "{row:?}");
        let best: f64 = row["lost_to_tuned_here_share"].parse().unwrap();
        assert_eq!(best == 0.0, row["is_tuned_here"] == "true", "{row:?}");
    }
}

/// Proves that the page names every label with its value and loss, sets losses in bold only where intervals are apart, and says
/// when a control fails or is missing.
#[test]
fn the_page_labels_values_honestly() {
    let made = typical();
    let page = super::page(&made).markdown();
    for wanted in
        ["| default | 0.001 |", "| tuned here | 0.01 |", "| tuned elsewhere | 0.02 |", "tuned on the other scenes"]
    {
        assert!(page.contains(wanted), "{wanted}: {page}");
    }
    assert!(page.contains("no \\| place") && page.contains("all score what they must"));
    // One value beside the best loses a twentieth of the hits, which is beyond any interval.
    assert!(page.contains("| **+4.3"), "{page}");
    let mut same = made.clone();
    for set in same.scenes.iter_mut().flat_map(|scene| &mut scene.views).flat_map(|view| &mut view.sets) {
        let first = set.values[0].judged.clone();
        set.values.iter_mut().for_each(|each| each.judged = first.clone());
    }
    choose(&mut same.scenes, "0.001", Rule::Footprint);
    let page = super::page(&same).markdown();
    assert!(!page.contains("**+") && !page.contains("**-") && page.contains("| tuned here | 0 |"), "{page}");
    let mut invalid = made.clone();
    invalid.scenes[1].views[1].controls.remove(0);
    let page = super::page(&invalid).markdown();
    assert!(
        page.contains("**the record is invalid**: oracle is missing on diffuse of hall, viewpoint window"),
        "{page}"
    );
    let mut wrong = made;
    wrong.scenes[0].views[0].controls[0].traces = wrong.scenes[0].views[0].controls[1].traces.clone();
    assert!(super::page(&wrong).markdown().contains("oracle fails on diffuse of room, viewpoint door"));
}

/// Proves that one viewpoint, one scene and nothing but ambiguous rays leave a page that says so.
#[test]
fn nothing_to_choose_by() {
    let mut made = tuning(&VALUES, &["room"], 1, &SETS[..1]);
    let page = super::page(&made).markdown();
    assert_eq!(page.matches("| tuned elsewhere | nothing to choose by |").count(), 1, "{page}");
    for value in &mut made.scenes[0].views[0].sets[0].values {
        if let Some(Judged { judgement: Judgement::Closest(judgement), .. }) = &mut value.judged {
            (judgement.agreement, judgement.interval) = Default::default();
        }
    }
    choose(&mut made.scenes, "0.001", Rule::Footprint);
    let page = super::page(&made).markdown();
    assert!(page.contains("| tuned here | nothing to choose by |"), "{page}");
    assert_eq!(page.matches("not judged: every ray is ambiguous").count(), VALUES.len());
    assert_eq!(made.scenes[0].views[0].sets[0].choice(Label::Default).unwrap().score, None);
}
