//! What differs between two runs: the same tracers on the same rays, row by row.
//!
//! Rows match by content: the scene's hash, the viewpoint, the tracer with its parameters, the rays' hash. What has moved
//! beyond noise is distinguished from what has changed exactly (answers, counters, bytes, statistics of structures).

mod accuracy;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde::Serialize;
use tracebench_api::ClockKind;

pub use accuracy::{Accuracy, Shift};

use crate::results::{
    COVERAGE, Caveat, MIN_ROUNDS, Movement, Ratio, Record, Row, Times, TraceRecord, kernels_changed, same_rays,
    same_work,
};

/// The schema of a comparison as JSON.
pub const SCHEMA: u32 = 1;

/// How much slower (a share) something must be to count, where nothing else is said.
pub const DEFAULT_THRESHOLD: f64 = 0.05;

/// Two runs compared with each other.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The first run.
    pub a: Side,
    /// The second run.
    pub b: Side,
    /// How much slower (a share) something must be to count.
    pub threshold: f64,
    /// What differs between the runs as wholes: machine, commit, preset.
    pub differences: Vec<String>,
    /// Builds and structures of both.
    pub builds: Vec<BuildRow>,
    /// Traces of both.
    pub traces: Vec<TraceRow>,
    /// What only the first run has.
    pub only_in_a: Vec<Key>,
    /// What only the second run has.
    pub only_in_b: Vec<Key>,
}

/// A run by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Side {
    /// What the user called it.
    pub path: String,
    /// Commit of the program.
    pub commit: String,
    /// Whether its tree was changed.
    pub dirty: Option<bool>,
    /// When it began.
    pub started: String,
    /// The machine in one line.
    pub machine: String,
}

/// What a row is about.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Key {
    /// Scene.
    pub scene: String,
    /// Hash of the scene.
    pub scene_sha256: String,
    /// Viewpoint.
    pub viewpoint: String,
    /// Tracer as it is labelled.
    pub tracer: String,
    /// Ray set; `None` for the tracer with all it did.
    pub rays: Option<String>,
    /// Hash of the rays.
    pub rays_sha256: Option<String>,
}

/// A time in both runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Speed {
    /// Median of the first, milliseconds; `None` where nothing was timed.
    pub a_ms: Option<f64>,
    /// Median of the second, milliseconds.
    pub b_ms: Option<f64>,
    /// Clock of the first.
    pub a_clock: ClockKind,
    /// Clock of the second.
    pub b_clock: ClockKind,
    /// Speed of the second over that of the first; `None` if their clocks differ or one was not timed.
    pub ratio: Option<Ratio>,
    /// What is to be said of it; `None` without a ratio.
    pub movement: Option<Movement>,
    /// Why nothing can be said, where that is so.
    pub undecided_because: Option<String>,
}

/// Something that must be the same and is not: its value in the first run and in the second, `None` where one has it not.
pub type Changes = BTreeMap<String, [Option<f64>; 2]>;

/// A tracer's build and structure in both runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BuildRow {
    /// Which.
    pub key: Key,
    /// Speed of the first builds.
    pub speed: Speed,
    /// Speed of the steady builds; none of records that do not tell them apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steady_speed: Option<Speed>,
    /// Bytes that changed.
    pub bytes: Changes,
    /// What the structure says of itself, where that changed.
    pub statistics: Changes,
}

/// A tracer's answers to a ray set in both runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TraceRow {
    /// Which.
    pub key: Key,
    /// Speed of the traces.
    pub speed: Speed,
    /// Accuracy by every rule.
    pub accuracy: Vec<Accuracy>,
    /// Whether the answers are the same bit for bit.
    pub same_hits: bool,
    /// Bytes that changed.
    pub bytes: Changes,
    /// Counters that changed, totals.
    pub counters: Changes,
}

impl BuildRow {
    /// Each of its speeds with what it is of.
    pub fn speeds(&self) -> impl Iterator<Item = (&'static str, &Speed)> {
        let steady = self.steady_speed.as_ref().map(|speed| ("steady build", speed));
        [("build", &self.speed)].into_iter().chain(steady)
    }
}

impl Comparison {
    /// What got slower or less accurate beyond noise, a sentence each.
    pub fn regressions(&self) -> Vec<String> {
        let slower = |(_, speed): &(&str, &Speed)| speed.movement == Some(Movement::Slower);
        let builds = self.builds.iter().flat_map(|row| {
            let slower = row.speeds().filter(slower);
            slower.map(|(what, _)| format!("{}: {what} slower", row.key.sentence())).collect::<Vec<_>>()
        });
        let traces = self.traces.iter().flat_map(|row| {
            let slower = (row.speed.movement == Some(Movement::Slower)).then(|| "slower".to_owned());
            let worse = row.accuracy.iter().filter(|accuracy| accuracy.shift == Shift::Worse);
            let worse = worse.map(|accuracy| format!("less accurate by {}", accuracy.rule));
            slower.into_iter().chain(worse).map(|what| format!("{}: {what}", row.key.sentence())).collect::<Vec<_>>()
        });
        builds.chain(traces).collect()
    }

    /// Whether anything is in both runs.
    pub fn is_empty(&self) -> bool {
        self.builds.is_empty()
    }
}

impl Key {
    fn of(row: &Row, trace: Option<&TraceRecord>) -> Self {
        Self {
            scene: row.scene.name.clone(),
            scene_sha256: row.scene.sha256.clone(),
            viewpoint: row.viewpoint.name.clone(),
            tracer: row.tracer.label(),
            rays: trace.map(|trace| trace.rays.clone()),
            rays_sha256: trace.map(|trace| trace.rays_sha256.clone()),
        }
    }

    /// In words.
    pub fn sentence(&self) -> String {
        let rays = self.rays.as_ref().map_or_else(String::new, |rays| format!(" {rays}"));
        format!("{} {}{rays}", self.scene, self.tracer)
    }
}

/// Holds two runs, each with the path that it came from, against each other. `threshold` is a share: 0.05 for 5 %.
pub fn compare(a: (&str, &Record), b: (&str, &Record), threshold: f64) -> Comparison {
    let side = |(path, record): (&str, &Record)| Side {
        path: path.to_owned(),
        commit: record.provenance.commit.clone(),
        dirty: record.provenance.dirty,
        started: record.provenance.started.clone(),
        machine: record.provenance.machine.label(),
    };
    let mut comparison = Comparison {
        schema: SCHEMA,
        a: side(a),
        b: side(b),
        threshold,
        differences: differences(a.1, b.1),
        ..Comparison::default()
    };
    // Rows of joined shards keep their machines, and times of different machines say nothing of the work.
    let joined = [a.1, b.1].iter().any(|record| !record.provenance.further_machines.is_empty());
    let timed = |one: &Row, other: &Row| {
        !joined || a.1.provenance.machine_of(one.machine) == b.1.provenance.machine_of(other.machine)
    };
    let rows = [a.1, b.1];
    let (pairs, only_in_a, only_in_b) = pairs(&a.1.rows, &b.1.rows, same_work);
    comparison.only_in_a.extend(only_in_a.into_iter().map(|record| Key::of(record, None)));
    comparison.only_in_b.extend(only_in_b.into_iter().map(|record| Key::of(record, None)));
    for (a, b) in pairs {
        let speed = |one: &Times, other: &Times| speed((rows[0], one), (rows[1], other), threshold, timed(a, b));
        let told = a.build.steady.is_some() && b.build.steady.is_some();
        let steady = told.then(|| speed(a.build.steady(), b.build.steady()));
        // Of records that tell other times only phases are the same.
        let [first, other] =
            if told { [a, b].map(|row| row.build.first()) } else { [a, b].map(|row| &row.build.times) };
        comparison.builds.push(build_row(a, b, speed(first, other), steady));
        let (traces, only_in_a, only_in_b) = self::pairs(&a.traces, &b.traces, same_rays);
        comparison.only_in_a.extend(only_in_a.into_iter().map(|trace| Key::of(a, Some(trace))));
        comparison.only_in_b.extend(only_in_b.into_iter().map(|trace| Key::of(b, Some(trace))));
        for (one, other) in traces {
            comparison.traces.push(trace_row(a, one, other, speed(&one.times, &other.times)));
        }
    }
    comparison
}

/// Pairs of what is the same on both sides, each used once, in the order of the first; then what is left of either.
fn pairs<'a, T>(a: &'a [T], b: &'a [T], same: fn(&T, &T) -> bool) -> (Vec<(&'a T, &'a T)>, Vec<&'a T>, Vec<&'a T>) {
    let mut left: Vec<&T> = b.iter().collect();
    let (mut pairs, mut only_in_a) = (Vec::new(), Vec::new());
    for one in a {
        match left.iter().position(|other| same(one, other)) {
            Some(place) => pairs.push((one, left.remove(place))),
            None => only_in_a.push(one),
        }
    }
    (pairs, only_in_a, left)
}

/// What differs between the runs as wholes, a sentence each.
fn differences(a: &Record, b: &Record) -> Vec<String> {
    let told = |record: &Record| {
        let (machine, commit) = (&record.provenance.machine, &record.provenance.commit);
        let adapter = machine.adapter.as_ref();
        let adapter = adapter.map(|each| format!("{}, {} {}", each.name, each.driver, each.driver_version));
        let mark = if record.provenance.dirty == Some(true) { " with changes" } else { "" };
        [
            ("processor", machine.cpu.clone()),
            ("threads", machine.threads.to_string()),
            ("adapter", adapter.unwrap_or_else(|| "none".to_owned())),
            ("system", machine.os.clone()),
            ("compiler", machine.rustc.clone()),
            ("commit", format!("{commit}{mark}")),
            ("preset", record.preset.clone()),
            ("seed", record.seed.to_string()),
            ("ray parameters", serde_json::to_string(&record.ray_parameters).unwrap_or_default()),
        ]
    };
    let both = told(a).into_iter().zip(told(b)).filter(|(a, b)| a != b);
    both.map(|((what, a), (_, b))| format!("{what}: {a} against {b}")).collect()
}

/// Why times of two runs decide nothing, whatever their ratio is.
fn caveat(a: (&Record, &Times), b: (&Record, &Times)) -> Option<Caveat> {
    let invalid = [a.1, b.1].iter().find_map(|times| times.invalid.clone());
    let fewest = a.1.samples_ms.len().min(b.1.samples_ms.len());
    let interleaved_sets = [a, b].map(|(record, times)| record.interleaved_set(times));
    let [one, other] = interleaved_sets.map(Vec::from_iter);
    let few = (fewest < MIN_ROUNDS as usize).then_some(Caveat::FewRounds(fewest));
    let drifts = interleaved_sets.iter().flatten().any(|interleaved_set| interleaved_set.drift);
    let changed = kernels_changed(&one, &other).then_some("the fixed kernel took another time");
    let drift = drifts.then_some("within an interleaved set").or(changed);
    invalid.map(Caveat::Void).or(few).or(drift.map(|why| Caveat::Drift(why.to_owned())))
}

/// `comparable`: both were timed on the same machine, as far as that is known.
fn speed(a: (&Record, &Times), b: (&Record, &Times), threshold: f64, comparable: bool) -> Speed {
    let caveat = caveat(a, b);
    let (a, b) = (a.1, b.1);
    let timed = |times: &Times| (!times.samples_ms.is_empty()).then_some(times.median_ms);
    let ratio = Ratio::of_times(&a.samples_ms, &b.samples_ms, COVERAGE).filter(|_| comparable && a.clock == b.clock);
    let fewest = a.samples_ms.len().min(b.samples_ms.len());
    let movement =
        ratio.map(|ratio| if caveat.is_some() { Movement::Undecided } else { ratio.movement(fewest, threshold) });
    let because = caveat.unwrap_or(Caveat::Interval).to_string();
    Speed {
        a_ms: timed(a),
        b_ms: timed(b),
        a_clock: a.clock,
        b_clock: b.clock,
        ratio,
        movement,
        undecided_because: (movement == Some(Movement::Undecided)).then_some(because),
    }
}

fn build_row(a: &Row, b: &Row, speed: Speed, steady_speed: Option<Speed>) -> BuildRow {
    let bytes = |row: &Row| {
        BTreeMap::from([
            ("structure".to_owned(), row.memory.structure_bytes as f64),
            ("geometry".to_owned(), row.memory.geometry_bytes as f64),
            ("build peak".to_owned(), row.memory.build_peak_bytes as f64),
        ])
    };
    // A file of before structures were asked has nothing to compare.
    let asked = !a.structure_statistics.is_empty() && !b.structure_statistics.is_empty();
    BuildRow {
        key: Key::of(a, None),
        speed,
        steady_speed,
        bytes: changes(&bytes(a), &bytes(b)),
        statistics: if asked { changes(&a.structure_statistics, &b.structure_statistics) } else { Changes::new() },
    }
}

fn trace_row(row: &Row, a: &TraceRecord, b: &TraceRecord, speed: Speed) -> TraceRow {
    let counters = |trace: &TraceRecord| {
        trace.counters.iter().map(|(name, counter)| (name.clone(), counter.total as f64)).collect::<BTreeMap<_, _>>()
    };
    let bytes = |trace: &TraceRecord| BTreeMap::from([("a trace".to_owned(), trace.per_trace_bytes as f64)]);
    TraceRow {
        key: Key::of(row, Some(a)),
        speed,
        accuracy: Accuracy::of_both(&a.judgement, &b.judgement),
        same_hits: a.hits_sha256 == b.hits_sha256,
        bytes: changes(&bytes(a), &bytes(b)),
        counters: changes(&counters(a), &counters(b)),
    }
}

/// What is not the same on both sides.
fn changes(a: &BTreeMap<String, f64>, b: &BTreeMap<String, f64>) -> Changes {
    let names = a.keys().chain(b.keys().filter(|name| !a.contains_key(*name)));
    let both = names.map(|name| (name.clone(), [a.get(name).copied(), b.get(name).copied()]));
    both.filter(|(_, [a, b])| a != b).collect()
}
