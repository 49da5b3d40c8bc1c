//! Every figure of a trace that tables and charts show: its names, unit, which way is better, and where it is found.

mod list;

use tracebench_api::Query;

pub(crate) use list::*;

use super::sheet::{Cell, Column};
use crate::results::{Accuracy, AnyJudgement, ClosestJudgement, Judgement, Record, Row, SurfaceDistance, TraceRecord};

/// Which way is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Better {
    Higher,
    Lower,
    /// Neither: it describes.
    Neither,
}

/// A tracer's run with one of its traces.
pub(crate) type Traced<'a> = (&'a Row, &'a TraceRecord);

/// How a figure is told of something.
type Of<T> = fn(&T) -> Option<Cell>;

/// Where a figure is found.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// With the structure, whatever it traces.
    Structure(Of<Row>),
    /// With a trace.
    Trace(Of<TraceRecord>),
}

/// A figure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Metric {
    /// Its name in tables for programs, with the unit at its end.
    pub name: &'static str,
    /// Name for people; empty where only programs read it.
    pub label: &'static str,
    /// Unit; empty for shares.
    pub unit: &'static str,
    pub better: Better,
    source: Source,
}

impl Metric {
    /// Label with unit, and an arrow the way that is better: a table's heading.
    pub(crate) fn heading(&self) -> String {
        headed(&self.axis(), self.better)
    }

    /// Label with unit: an axis's name.
    pub(super) fn axis(&self) -> String {
        if self.unit.is_empty() { self.label.to_owned() } else { format!("{} ({})", self.label, self.unit) }
    }

    /// The same under another name.
    pub(crate) fn called(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    fn cell(&self, row: Option<&Row>, trace: Option<&TraceRecord>) -> Option<Cell> {
        match self.source {
            Source::Structure(of) => of(row?),
            Source::Trace(of) => of(trace?),
        }
    }

    /// Its value as a column.
    pub(crate) fn column<'a, R>(self, of: impl Fn(&R) -> Option<Traced<'_>> + 'a) -> Column<'a, R> {
        self.shown(move |row| of(row).and_then(|(row, trace)| self.cell(Some(row), Some(trace))))
    }

    /// As a column of structures.
    pub(crate) fn of_structure<'a, R>(self, of: impl Fn(&R) -> Option<&Row> + 'a) -> Column<'a, R> {
        self.shown(move |row| self.cell(of(row), None))
    }

    /// As a column of traces.
    pub(crate) fn of_trace<'a, R>(self, of: impl Fn(&R) -> Option<&TraceRecord> + 'a) -> Column<'a, R> {
        self.shown(move |row| self.cell(None, of(row)))
    }

    /// As a column of whatever tells it.
    pub(crate) fn shown<'a, R>(&self, cell: impl Fn(&R) -> Option<Cell> + 'a) -> Column<'a, R> {
        Column::csv(self.name, cell).headed(self.heading())
    }
}

/// A name with an arrow the way that is better.
pub(crate) fn headed(name: &str, better: Better) -> String {
    let arrow = match better {
        Better::Higher => " ↑",
        Better::Lower => " ↓",
        Better::Neither => "",
    };
    format!("{name}{arrow}")
}

/// One of traces: its name for programs, its label and its unit.
const fn metric([name, label, unit]: [&'static str; 3], better: Better, of: Of<TraceRecord>) -> Metric {
    Metric { name, label, unit, better, source: Source::Trace(of) }
}

/// One of structures.
const fn structure([name, label, unit]: [&'static str; 3], better: Better, of: Of<Row>) -> Metric {
    Metric { name, label, unit, better, source: Source::Structure(of) }
}

/// One that only programs read.
const fn plain(name: &'static str, of: Of<TraceRecord>) -> Metric {
    metric([name, "", ""], Better::Neither, of)
}

/// The same of structures.
const fn structure_alone(name: &'static str, of: Of<Row>) -> Metric {
    structure([name, "", ""], Better::Neither, of)
}

/// What tells how often answers to a query are right, always together.
pub(crate) fn accuracies(query: Query) -> &'static [Metric] {
    match query {
        Query::Closest => &[HIT_MISS, TIGHT, FOOTPRINT],
        Query::Any => &[BALANCED],
    }
}

/// The names of the rules by which answers to a query are right, in the order of [`accuracies`].
pub(crate) fn rules(query: Query) -> &'static [&'static str] {
    match query {
        Query::Closest => &["hit_miss", "tight", "footprint"],
        Query::Any => &[BALANCED.label],
    }
}

/// The accuracies of a trace.
pub(crate) fn right_of(trace: &TraceRecord) -> Vec<Accuracy> {
    trace.judgement.accuracies(trials(trace))
}

/// Whether anything could be judged: no speed stands without its accuracy.
pub(crate) fn judged(trace: &TraceRecord) -> bool {
    // Rays without an eye have no footprint, the last of three rules.
    right_of(trace).iter().take(2).all(|accuracy| accuracy.share.is_some())
}

/// The verdict, if it is one on a closest-hit set.
pub(crate) fn closest(trace: &TraceRecord) -> Option<&ClosestJudgement> {
    if let Judgement::Closest(judgement) = &trace.judgement { Some(judgement) } else { None }
}

/// How far told hits are from the mesh; of any-hit sets, and of records from before it was told, nothing.
pub(super) fn distance(trace: &TraceRecord) -> Option<&SurfaceDistance> {
    closest(trace)?.surface_distance.as_ref()
}

/// The verdict, if it is one on an any-hit set.
pub(super) fn any(trace: &TraceRecord) -> Option<&AnyJudgement> {
    if let Judgement::Any(judgement) = &trace.judgement { Some(judgement) } else { None }
}

/// What stands beside agreements that ambiguous rays are in.
pub(super) fn with_ambiguous<'a>(mut traces: impl Iterator<Item = &'a TraceRecord>) -> Option<Metric> {
    traces.any(|trace| trace.judgement.has_ambiguous()).then_some(WITHOUT_AMBIGUOUS)
}

/// What pages say of ambiguous rays.
pub(super) fn of_ambiguous(record: &Record) -> &'static str {
    let mut judged = record.rows.iter().flat_map(|row| &row.traces).map(|trace| &trace.judgement);
    if record.frames.is_some() || judged.any(Judgement::has_ambiguous) {
        "Ambiguous rays, whose truth depends on rounding, have several right answers; those of any-hit sets, where both are right, \
         are left out of every share."
    } else {
        "Ties, rays whose truth hangs on rounding, are left out of every share."
    }
}

/// Rays that count.
pub(crate) fn trials(trace: &TraceRecord) -> u64 {
    trace.count.saturating_sub(trace.judgement.left_out())
}

/// Bytes of the structure that are used.
pub(super) fn used_bytes(row: &Row) -> u64 {
    row.memory.structure.iter().map(|part| part.used_bytes).sum()
}

/// Million rays a second, where something was timed.
pub(crate) fn speed(trace: &TraceRecord) -> Option<f64> {
    timed(trace, trace.mrays_per_s).filter(|speed| speed.is_finite() && *speed > 0.0)
}

/// The interval of the speed: of the median time, turned over.
pub(super) fn speed_interval(trace: &TraceRecord) -> Option<[f64; 2]> {
    let of = |ms: f64| trace.count as f64 / (ms * 1e3);
    let [fast, slow] = trace.times.interval_ms;
    let interval = [of(slow), of(fast)];
    let whole = speed(trace).is_some() && interval.iter().all(|end| end.is_finite() && *end > 0.0);
    whole.then_some(interval)
}

/// Bytes of the structure a triangle: allocated, and used of them.
pub(super) fn per_triangle(row: &Row) -> [f64; 2] {
    [row.memory.structure_bytes, used_bytes(row)].map(|bytes| bytes as f64 / row.scene.triangles.max(1) as f64)
}

/// Wrong rays under `tight`. Ambiguous rays of closest hits are among them where they are wrong; of any hit they are in no class, since
/// either answer is right.
pub(crate) fn wrong_tight(judgement: &Judgement) -> u64 {
    match judgement {
        Judgement::Closest(closest) => closest.classes.tight.wrong(),
        Judgement::Any(any) => any.occlusion.false_occluded + any.occlusion.false_free,
    }
}

fn timed<T>(trace: &TraceRecord, value: T) -> Option<T> {
    (!trace.times.samples_ms.is_empty() && trace.times.invalid.is_none()).then_some(value)
}
