//! Sweeps made up for tests, and what is made of them.

use std::collections::BTreeMap;

use tempfile::TempDir;
use tracebench_api::{ClockKind, Query};

use crate::judge::Rule;
use crate::report::fixture::{self, Quality, configs, write_derived, write_run};
use crate::report::format::percent_with_interval;
use crate::report::read_run;
use crate::results::{
    AxisRecord, Judgement, PointRecord, Record, Row, Skipped, SweepRecord, TunedScene, TuningRecord, ViewpointRecord,
};
use crate::statistics::wilson;
use crate::studies::sweep::RESOLUTION;

/// An axis: name, own value, values.
pub(in crate::report) type Swept<'a> = (&'a str, &'a str, &'a [&'a str]);

const BUCKETS: Swept<'_> = ("buckets", "24", &["1", "24", "40"]);
const RESOLUTIONS: Swept<'_> = (RESOLUTION, "1", &["1/2", "1"]);
const SETS: [(&str, Query); 2] = [("diffuse", Query::Closest), ("ao", Query::Any)];

/// A sweep of a made-up tracer, each point with bytes, times and errors of its own.
pub(in crate::report) fn sweep_run(axes: &[Swept<'_>], sets: &[(&str, Query)], grid: bool) -> Record {
    let own: BTreeMap<String, String> =
        axes.iter().map(|(name, own, _)| ((*name).to_owned(), (*own).to_owned())).collect();
    let mut wanted = vec![own.clone()];
    for (name, _, values) in axes {
        let from = if grid { wanted.clone() } else { vec![own.clone()] };
        for values in from.iter().flat_map(|point| {
            let with = |value: &&str| [((*name).to_owned(), (*value).to_owned())];
            values.iter().map(move |value| point.clone().into_iter().chain(with(value)).collect::<BTreeMap<_, _>>())
        }) {
            if !wanted.contains(&values) {
                wanted.push(values);
            }
        }
    }
    let names: Vec<String> = wanted.iter().map(|_| "dirt".to_owned()).collect();
    let quality = |index: usize| Quality {
        missed: 0.002 * index as f64,
        blur: 1e-5 * (index + 1) as f64,
        speed: 3.0 + index as f64,
        clock: ClockKind::DeviceTimestamps,
    };
    let named: Vec<_> = names.iter().enumerate().map(|(index, name)| (name.as_str(), quality(index))).collect();
    let mut record = fixture::run(&named, sets);
    record.skipped.clear();
    let mut points = Vec::new();
    for (index, (values, one)) in wanted.into_iter().zip(&mut record.rows).enumerate() {
        for (name, value) in values.iter().filter(|(name, _)| *name != RESOLUTION) {
            one.tracer.parameters.insert(name.clone(), serde_json::Value::from(value.clone()));
            if *value != own[name] {
                one.tracer.changed.push(name.clone());
            }
        }
        let place = axes.iter().find(|(name, ..)| *name == RESOLUTION);
        let place = place.and_then(|(name, _, all)| all.iter().position(|value| *value == values[*name]));
        one.viewpoint.face = 64 << place.unwrap_or(0);
        one.memory.structure_bytes = (index as u64 + 1) << 20;
        one.memory.structure[0].allocated_bytes = one.memory.structure_bytes;
        points.push(PointRecord {
            values,
            parameters: one.tracer.parameters.clone(),
            frame: one.viewpoint.frame,
            face: one.viewpoint.face,
            skipped: BTreeMap::new(),
        });
    }
    let axis = |(name, own, values): &Swept<'_>| AxisRecord {
        name: (*name).to_owned(),
        unit: String::new(),
        effect: format!("what {name} does"),
        own: (*own).to_owned(),
        values: values.iter().map(|value| (*value).to_owned()).collect(),
    };
    let axes = axes.iter().map(axis).collect();
    record.sweep = Some(SweepRecord { tracer: "dirt".to_owned(), grid, axes, points });
    record
}

/// A sweep by which a thickness is chosen, in scenes of given names, from so many viewpoints: from each the best value is another one, the
/// third, the fourth, and so on, by whatever rule. The default is the second.
pub(in crate::report) fn tuned_run(values: &[&str], scenes: &[&str], views: usize, sets: &[(&str, Query)]) -> Record {
    let mut record = sweep_run(&[("thickness", values[1], values)], sets, false);
    let (rows, controls) = (std::mem::take(&mut record.rows), std::mem::take(&mut record.controls));
    let mut tuned = Vec::new();
    for (number, name) in scenes.iter().enumerate() {
        let mut scene = rows[0].scene.clone();
        scene.name = (*name).to_owned();
        let view = |view: usize| {
            let name = ["door", "window", "roof"][view].to_owned();
            ViewpointRecord { name, ..rows[0].viewpoint.clone() }
        };
        let viewpoints: Vec<ViewpointRecord> = (0..views).map(view).collect();
        for (view, viewpoint) in viewpoints.iter().enumerate() {
            let best = (2 + view + number) % values.len();
            let here = |row: &Row| Row { scene: scene.clone(), viewpoint: viewpoint.clone(), ..row.clone() };
            record.controls.extend(controls.iter().map(here));
            for row in &rows {
                let value = &row.tracer.parameters["thickness"];
                let place = values.iter().position(|each| value == *each).unwrap();
                let missed = 0.01 + 0.05 * place.abs_diff(best) as f64;
                let quality = Quality { missed, blur: 1e-4, speed: 1.0, clock: ClockKind::Host };
                let traces = fixture::run(&[("dirt", quality)], sets).rows.remove(0).traces;
                record.rows.push(Row { traces, ..here(row) });
            }
        }
        tuned.push(TunedScene { scene, viewpoints });
    }
    record.skipped =
        vec![Skipped { tracer: None, scene: "hall".to_owned(), rays: None, reason: "no | place".to_owned() }];
    let tracer = rows[0].tracer.clone();
    record.tuning = Some(TuningRecord { tracer, rule: Rule::Footprint, scenes: tuned });
    record
}

/// Proves that every row has the figures of its own point: bytes that only that point has; that the own value stands on
/// every axis with the same figures; that a run which is no point of the sweep has no values, and is not on its page; that what is skipped
/// is said there.
#[test]
fn rows_are_those_of_their_points() {
    let mut record = sweep_run(&[BUCKETS, RESOLUTIONS], &SETS, false);
    let mut other = record.rows[0].clone();
    other.memory.structure_bytes = 77;
    other.memory.structure[0].allocated_bytes = 77;
    other.tracer.parameters.insert("stride".to_owned(), 2.into());
    record.rows.insert(0, other);
    let gone = record.rows.iter().position(|one| one.tracer.parameters["buckets"] == "40").unwrap();
    let gone = record.rows.remove(gone);
    let points = &mut record.sweep.as_mut().unwrap().points;
    points
        .iter_mut()
        .find(|point| point.is_of(&gone))
        .unwrap()
        .skipped
        .insert("room".to_owned(), "too large".to_owned());
    let folder = TempDir::new().unwrap();
    write_run(&record, folder.path(), fixture::tables).unwrap();
    let rows = configs(folder.path());
    let found: Vec<_> = rows
        .iter()
        .filter(|row| row["rays"] == "diffuse")
        .map(|row| (row["values_json"].as_str(), row["structure_bytes"].as_str()))
        .collect();
    let [first, second, fourth] = [1, 2, 4].map(|mib: u64| (mib << 20).to_string());
    assert_eq!(
        found,
        [
            ("", "77"),
            (r#"{"buckets":"24","resolution":"1"}"#, &first),
            (r#"{"buckets":"1","resolution":"1"}"#, &second),
            (r#"{"buckets":"24","resolution":"1/2"}"#, &fourth),
        ]
    );
    assert!(rows.iter().filter(|row| row["rays"] == "ao").count() == 4);
    let page = std::fs::read_to_string(folder.path().join("sweep.md")).unwrap();
    assert!(page.contains("| 40 | skipped, see below |") && page.contains("| 24 * | 1.000 |"), "{page}");
    assert!(!page.contains(&crate::report::format::mib(77)));
}

/// Proves that a sweep read back makes the same files, that other files tell its resolutions apart, and have every control
/// once unless it scored differently.
#[test]
fn files_can_be_made_again() {
    let mut record = sweep_run(&[BUCKETS, RESOLUTIONS], &SETS, false);
    record.controls = [record.controls.clone(), record.controls.clone()].concat();
    let (folder, elsewhere) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    write_run(&record, folder.path(), fixture::tables).unwrap();
    let again = read_run(folder.path()).unwrap();
    assert_eq!(again, record);
    let paths = write_derived(&again, elsewhere.path(), fixture::tables).unwrap();
    // Two axes, two ray sets, two formats.
    assert_eq!(paths.iter().filter(|path| path.to_string_lossy().contains("sweep_room_")).count(), 8);
    for path in paths {
        let name = path.file_name().unwrap();
        assert!(std::fs::read(&path).unwrap() == std::fs::read(folder.path().join(name)).unwrap(), "{name:?} differs");
    }
    let summary = |record: &Record| {
        write_derived(record, elsewhere.path(), fixture::tables).unwrap();
        std::fs::read_to_string(elsewhere.path().join("summary.md")).unwrap()
    };
    let text = summary(&record);
    assert!(text.contains("| dirt resolution=1/2 |") && text.contains("| dirt buckets=40 |"));
    // Controls stand at the first resolution and count at every one.
    assert!(text.contains("Controls: all score what they must"), "{text}");
    let oracles = |text: &str| text.matches("oracle (control)").count();
    let once = oracles(&text);
    let second = record.controls.len() / 2;
    if let Judgement::Closest(judgement) = &mut record.controls[second].traces[0].judgement {
        judgement.ambiguous_rays += 1;
    }
    assert_eq!(oracles(&summary(&record)), 2 * once);
    // Without a sweep nothing of one is left.
    record.sweep = None;
    let paths = write_derived(&record, elsewhere.path(), fixture::tables).unwrap();
    assert!(paths.iter().all(|path| !path.to_string_lossy().contains("sweep")));
    assert!(!elsewhere.path().join("sweep_room_buckets_diffuse.svg").exists());
}

/// Proves that every agreement stands with its Wilson interval, on the page and in the table: the one that shares and rays give,
/// so that a reader sees whether it changes along the axis.
#[test]
fn agreements_have_their_intervals() {
    let record = sweep_run(&[RESOLUTIONS], &SETS[..1], false);
    let folder = TempDir::new().unwrap();
    write_run(&record, folder.path(), fixture::tables).unwrap();
    let page = std::fs::read_to_string(folder.path().join("sweep.md")).unwrap();
    let rows = configs(folder.path());
    assert_eq!(rows.len(), 2);
    for row in &rows {
        for rule in ["hit_miss", "tight", "footprint"] {
            let number = |name: String| row[&name].parse::<f64>().unwrap();
            let share = number(format!("agreement_{rule}_share"));
            let trials = number("count_rays".to_owned()) - number("ambiguous_rays".to_owned());
            let expected = wilson((share * trials).round() as u64, trials as u64).unwrap();
            let ends = ["low", "high"].map(|end| number(format!("agreement_{rule}_share_{end}")));
            assert_eq!(ends, expected, "{rule}");
            let text = percent_with_interval(share, Some(expected), trials as u64);
            let values: BTreeMap<String, String> = serde_json::from_str(&row["values_json"]).unwrap();
            let line = format!("| {}", values[RESOLUTION]);
            assert!(page.lines().any(|each| each.starts_with(&line) && each.contains(&text)), "{text}: {page}");
        }
    }
    let tight = |row: usize| rows[row]["agreement_tight_share_low"].clone();
    assert!(tight(0) != tight(1), "the points differ");
}

/// Proves that of rays that are all ambiguous rays no speed is told.
#[test]
fn no_speed_without_accuracy() {
    let mut record = sweep_run(&[BUCKETS], &SETS[..1], false);
    let page = |record: &Record| {
        let groups = crate::report::group::groups(record);
        let sweep = record.sweep.as_ref().unwrap();
        super::page(record, sweep, &super::views(sweep, &groups, None), None).markdown()
    };
    let speeds = |page: &str| page.lines().filter(|line| line.starts_with("| 1 |") && line.contains("| 4.0")).count();
    assert_eq!(speeds(&page(&record)), 1, "{}", page(&record));
    for trace in record.rows.iter_mut().flat_map(|one| &mut one.traces) {
        if let Judgement::Closest(judgement) = &mut trace.judgement {
            (judgement.agreement, judgement.interval) = Default::default();
        }
    }
    assert_eq!(speeds(&page(&record)), 0);
}
