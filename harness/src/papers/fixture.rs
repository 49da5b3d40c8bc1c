//! Runs for tests of papers: configurations with parameters and figures as given.

use std::collections::BTreeMap;

use tracebench_api::{ClockKind, MemoryEntry, Query};

use super::rows::has;
use super::{Paper, Rows, SceneRows, SceneValue, find, report};
pub(super) use crate::report::fixture::{COUNT, Quality, interleaved_set, run};
use crate::results::{
    CounterRecord, FrameRow, FrameSeries, FramesRecord, Judgement, MovingScene, PhaseRecord, Record, Row, Times,
    TraceRecord, WorkRow,
};

/// A configuration of a scene: its parameters, what its structure says of itself, its ray sets.
pub(super) fn config(
    tracer: &str,
    scene: &str,
    parameters: serde_json::Value,
    statistics: &[(&str, f64)],
    sets: &[(&str, Query)],
) -> Row {
    let quality = Quality { missed: 0.0, blur: 0.0, speed: 2.0, clock: ClockKind::DeviceTimestamps };
    let mut row = run(&[(tracer, quality)], sets).rows.remove(0);
    row.scene.name = scene.to_owned();
    row.scene.sha256 = scene.to_owned();
    row.tracer.parameters = serde_json::from_value(parameters).unwrap();
    row.structure_statistics = statistics.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    row
}

/// Sets a counter of a ray set, over all rays.
pub(super) fn count(row: &mut Row, rays: &str, counter: &str, total: u64) {
    let trace = row.traces.iter_mut().find(|trace| trace.rays == rays).unwrap();
    let per_ray = total as f64 / trace.count as f64;
    trace.counters.insert(counter.to_owned(), CounterRecord { total, per_ray, max_per_ray: None });
}

pub(super) fn run_of(rows: Vec<Row>) -> Record {
    let mut record = run(&[], &[]);
    (record.rows, record.skipped) = (rows, Vec::new());
    record
}

/// The run of a tracer that has these values, and else those of the tracer's first run, its resolution and rays too.
pub(super) fn like_first<'a>(scene: &SceneRows<'a>, tracer: &str, values: &[(&str, &str)]) -> Option<&'a Row> {
    let names: Vec<&str> = values.iter().map(|(name, _)| *name).collect();
    scene.differing_in(tracer, &names).find(|row| values.iter().all(|(name, value)| has(row, name, value)))
}

/// A table of frames of configurations: what works come to in each of four.
pub(super) fn frames_of(
    table: &str,
    rows: Vec<Row>,
    works: &[&str],
    of: impl Fn(&Row, &str, usize) -> WorkRow,
) -> Record {
    let words = |word: &str| word.to_owned();
    let mut section = FramesRecord {
        frames: 4,
        fps: 1.0,
        size: [8, 8],
        spp: 1,
        moves: words("camera"),
        update: words("reuse"),
        paths: words("own"),
        cut: None,
        fixed_rays: false,
        works: works.iter().copied().map(words).collect(),
        effects: false,
        scenes: Vec::new(),
        rows: Vec::new(),
    };
    for row in rows {
        let known = section.scenes.iter().position(|moving| moving.scene == row.scene);
        let scene = known.unwrap_or(section.scenes.len()) as u32;
        if known.is_none() {
            let (scene, viewpoints) = (row.scene.clone(), vec![row.viewpoint.clone(); 4]);
            section.scenes.push(MovingScene { scene, viewpoints, ..MovingScene::default() });
        }
        section.rows.extend(works.iter().map(|&work| {
            FrameSeries {
                scene,
                frames: (0..4)
                    .map(|number| FrameRow {
                        works: [(words(work), of(&row, work, number))].into(),
                        ..FrameRow::default()
                    })
                    .collect(),
                tracer: row.tracer.clone(),
                fingerprint: None,
                machine: 0,
                interleaved_set: None,
                clock: None,
                invalid: None,
                floor_holds: None,
                pictures: BTreeMap::new(),
                changing: BTreeMap::new(),
            }
        }));
    }
    Record { table: Some(words(table)), frames: Some(section), ..run_of(Vec::new()) }
}

/// A quantity of a paper by scene, as pages name it.
pub(super) fn values(paper: &Paper, name: &str, record: &Record) -> BTreeMap<String, f64> {
    let found = paper.quantity(name).unwrap().values(paper, &Rows::of(record));
    found.iter().map(SceneValue::from).map(|each| (each.scene, each.value)).collect()
}

/// A quantity of a paper in a run of one scene, or over all scenes.
pub(super) fn value(paper: &Paper, name: &str, record: &Record) -> f64 {
    let all = values(paper, name, record);
    assert_eq!(all.len(), 1, "{name}: {all:?}");
    all.into_values().next().unwrap()
}

pub(super) fn set_time(row: &mut Row, rays: &str, ms: f64) {
    let trace = row.traces.iter_mut().find(|trace| trace.rays == rays).unwrap();
    all_rounds(&mut trace.times, ms);
}

/// As many rounds as a verdict takes, all alike.
pub(super) fn all_rounds(times: &mut Times, ms: f64) {
    (times.samples_ms, times.interval_ms) = (vec![ms; 12], [ms; 2]);
    (times.median_ms, times.submit_to_done_median_ms) = (ms, Some(ms));
    times.submit_to_done_samples_ms = vec![ms; 12];
}

/// The run with every time in an interleaved set: the builds in one, each ray set in one of its own.
pub(super) fn in_interleaved_sets(mut record: Record) -> Record {
    let mut works = vec!["builds".to_owned()];
    for row in &mut record.rows {
        row.build.times.interleaved_set = Some(0);
        for trace in &mut row.traces {
            let known = works.iter().position(|work| *work == trace.rays);
            trace.times.interleaved_set = Some(known.unwrap_or(works.len()) as u32);
            works.extend(known.is_none().then(|| trace.rays.clone()));
        }
    }
    record.interleaved_sets = works.iter().map(|work| interleaved_set(work)).collect();
    record
}

pub(super) fn set_phase(row: &mut Row, name: &str, ms: f64) {
    let rounds = row.build.times.samples_ms.len();
    row.build.times.phases = vec![PhaseRecord { name: name.to_owned(), median_ms: ms, samples_ms: vec![ms; rounds] }];
}

pub(super) fn set_build(row: &mut Row, ms: f64) {
    all_rounds(&mut row.build.times, ms);
}

pub(super) fn set_bytes(row: &mut Row, parts: &[(&str, u64)]) {
    let entry = |(name, bytes): &(&str, u64)| MemoryEntry::whole(name, *bytes);
    row.memory.structure = parts.iter().map(entry).collect();
}

pub(super) fn trace_of<'a>(row: &'a mut Row, rays: &str) -> &'a mut TraceRecord {
    row.traces.iter_mut().find(|trace| trace.rays == rays).unwrap()
}

/// Misses, inventions and footprint agreement of a closest-hit set, under both rules.
pub(super) fn set_classes(row: &mut Row, rays: &str, [missed, invented]: [u64; 2], footprint: f64) {
    let Judgement::Closest(closest) = &mut trace_of(row, rays).judgement else { panic!("{rays} is any-hit") };
    for classes in [&mut closest.classes.tight, &mut closest.classes.footprint] {
        (classes.false_miss, classes.false_hit, classes.early, classes.late) = (missed, invented, 0, 0);
    }
    closest.agreement.footprint = Some(footprint);
}

/// Rays in a million.
pub(super) fn in_a_million(rays: u64) -> f64 {
    rays as f64 / (COUNT - 12) as f64 * 1e6
}

pub(super) fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{found}, not {expected}");
}

/// The page of an experiment over a run.
pub(super) fn page_of(name: &str, record: &Record) -> String {
    let (paper, experiment) = find(name).unwrap();
    let files = report(paper, experiment, record).unwrap().contents().unwrap();
    let own = format!("table_{}.md", name.replace('-', "_"));
    let page = files.into_iter().find(|(file, _)| *file == own).unwrap();
    String::from_utf8(page.1).unwrap()
}

/// Leaves nothing that could be judged.
pub(super) fn take_judgements(record: &mut Record) {
    for trace in record.rows.iter_mut().flat_map(|one| &mut one.traces) {
        match &mut trace.judgement {
            Judgement::Closest(closest) => (closest.agreement, closest.interval) = Default::default(),
            Judgement::Any(any) => any.occlusion.balanced_accuracy = None,
        }
    }
}

/// Published tables without figures.
pub(super) fn lost(paper: &Paper) -> Vec<String> {
    paper.published.tables.iter().filter(|table| table.rows.is_none()).map(|table| table.id.clone()).collect()
}
