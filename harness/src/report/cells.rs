//! Columns that several tables have: what was measured, by which clock, and how right it is; never a speed without its accuracy.

use std::collections::BTreeMap;

use itertools::Itertools as _;
use serde::Serialize;
use tracebench_api::Query;

use super::format::{clock_of, code, significant, statistic, thousands};
use super::group::Role;
use super::metrics::{self, BUILD_TIME, Better, FIRST_BUILD, Metric, STEADY_BUILD, headed, judged};
use super::sheet::{Cell, Column, Sheet};
use crate::results::{CounterRecord, PhaseRecord, Row, Times, TraceRecord};

/// A trace with its place in the table.
pub(crate) type TableRow<'a> = (Role, &'a Row, &'a TraceRecord);

/// A row of a table that tells of a trace, if it does.
pub(crate) trait Told {
    /// The trace with its place.
    fn told(&self) -> Option<TableRow<'_>>;
}

impl Told for TableRow<'_> {
    fn told(&self) -> Option<TableRow<'_>> {
        Some(*self)
    }
}

impl<R: Told, T> Told for (R, T) {
    fn told(&self) -> Option<TableRow<'_>> {
        self.0.told()
    }
}

impl<'a, R> Sheet<'a, R> {
    /// With something as JSON.
    pub(super) fn json<T: Serialize + 'a>(self, name: &str, of: impl Fn(&R) -> &T + 'a) -> Self {
        self.csv_column(name, move |row| serde_json::to_string(of(row)).unwrap_or_default())
    }

    /// With the clock of times.
    pub(crate) fn clock(self, name: &str, of: impl Fn(&R) -> Option<&Times> + 'a) -> Self {
        let named = |times: &Times| Cell::Named(code(times.clock), clock_of(times));
        self.and(Column::csv(name, move |row| of(row).map(named)).headed(name.replace('_', " ")))
    }

    /// With the phases of times by their medians.
    pub(crate) fn phases(self, heading: &str, between: &'static str, of: impl Fn(&R) -> Option<&Times> + 'a) -> Self {
        let phase = |phase: &PhaseRecord| format!("{} {}", phase.name, significant(phase.median_ms, 3));
        let told = move |times: &Times| times.phases.iter().map(phase).join(between);
        self.column(heading, move |row| of(row).map(told))
    }

    /// With the times of first and steady builds or, of records of before these were told, with that of builds under a name.
    pub(crate) fn builds(self, called: &'static str, of: impl Fn(&R) -> Option<&Row> + Copy + 'a) -> Self {
        let metrics = [BUILD_TIME.called(called), FIRST_BUILD, STEADY_BUILD];
        self.with(metrics.map(|metric| metric.of_structure(of)).into())
    }

    /// With the phases of builds and, where what stands beside them is by the host's clock, theirs.
    pub(crate) fn build_phases(
        self,
        heading: &str,
        between: &'static str,
        of: impl Fn(&R) -> &Row + Copy + 'a,
    ) -> Self {
        let clock = move |row: &R| {
            let build = &of(row).build;
            build.steady.as_ref().map_or(Cell::Absent, |_| clock_of(&build.times).into())
        };
        self.column("clock of phases", clock).phases(heading, between, move |row| Some(&of(row).build.times))
    }

    /// With a figure of structures.
    pub(crate) fn structure(self, metric: Metric, of: impl Fn(&R) -> Option<&Row> + 'a) -> Self {
        self.and(metric.of_structure(of))
    }
}

impl<'a, R: Told> Sheet<'a, R> {
    /// With the tracer's label.
    pub(crate) fn name(self) -> Self {
        self.column("tracer", |row| row.told().map(|(role, row, _)| label(role, row)))
    }

    /// With the clock of traces; controls trace nothing.
    pub(crate) fn own_clock(self) -> Self {
        self.clock("clock", |row| row.told().filter(contends).map(|(.., trace)| &trace.times))
    }

    /// With figures of traces.
    pub(crate) fn figures(self, metrics: impl IntoIterator<Item = Metric>) -> Self {
        let column = |metric: Metric| metric.of_trace(|row: &R| row.told().map(|(.., trace)| trace));
        self.with(metrics.into_iter().map(column).collect())
    }

    /// With what traces take, only beside an accuracy, and never of controls.
    pub(crate) fn taken(self, metric: Metric) -> Self {
        let of = |row: &TableRow<'_>| contends(row) && judged(row.2);
        self.and(metric.of_trace(move |row: &R| row.told().filter(of).map(|(.., trace)| trace)))
    }

    /// With what tells how often answers to a query are right.
    pub(crate) fn right(self, query: Query) -> Self {
        self.figures(metrics::accuracies(query).iter().copied())
    }

    /// With the counters of some rows that are wanted, by whether they are counted over a set: means per ray, but of what is counted over a
    /// set how much of it.
    pub(crate) fn counted(self, rows: &[TableRow<'a>], is_wanted: fn(bool) -> bool) -> Self {
        let mut counted: BTreeMap<&'a String, bool> = BTreeMap::new();
        for (name, counter) in rows.iter().flat_map(|(.., trace)| &trace.counters) {
            *counted.entry(name).or_default() |= counter.max_per_ray.is_none();
        }
        let counter = |(name, of_set): (&'a String, bool)| {
            let heading = if of_set { name.clone() } else { format!("{name} per ray") };
            Column::new(headed(&heading, Better::Lower), move |row: &R| {
                let (_, row, trace) = row.told()?;
                let counter = trace.counters.get(name)?;
                Some(touched(row, name, counter).map_or(Cell::Number(counter.per_ray, 4), Cell::Text))
            })
        };
        self.with(counted.into_iter().filter(|(_, of_set)| is_wanted(*of_set)).map(counter).collect())
    }
}

pub(super) fn contends((role, ..): &TableRow<'_>) -> bool {
    *role == Role::Tracer
}

/// The intervals' coverage, which few samples cannot bring to 95 %.
pub(crate) fn coverage(rows: &[TableRow<'_>]) -> String {
    let timed =
        || rows.iter().filter(|row| contends(row) && !row.2.times.samples_ms.is_empty()).map(|row| &row.2.times);
    let coverages = timed().map(|times| times.interval_coverage);
    let Some((low, high)) = coverages.minmax().into_option() else { return String::new() };
    let samples = timed().map(|times| times.samples_ms.len()).min().unwrap_or(0);
    let share = |share: f64| format!("{:.1} %", share * 100.0);
    let range = if low == high { share(low) } else { format!("{} to {}", share(low), share(high)) };
    format!("At least {samples} samples a row; the intervals of times cover the median with {range}.")
}

/// How much of what a structure stores a set of rays touched: the count, and the share where the structure says how many of
/// the same it has. `None` for what is counted ray by ray.
pub(super) fn touched(row: &Row, name: &str, counter: &CounterRecord) -> Option<String> {
    if counter.max_per_ray.is_some() {
        return None;
    }
    let stored =
        name.strip_suffix("_touched").and_then(|of| row.structure_statistics.get(of)).filter(|all| **all > 0.0);
    Some(match stored {
        Some(stored) => {
            let share = significant(counter.total as f64 / stored * 100.0, 3);
            format!("{} ({share} % of {})", thousands(counter.total), statistic(*stored))
        }
        None => thousands(counter.total),
    })
}

/// The tracer's label, marked if it is a control's.
pub(super) fn label(role: Role, row: &Row) -> String {
    match role {
        Role::Control => format!("{} (control)", row.label()),
        Role::Tracer => row.label(),
    }
}

#[cfg(test)]
mod tests {
    use tracebench_api::Query;

    use super::*;
    use crate::report::fixture::{self, Quality};

    /// What a set touched stands beside what the structure says it stores, by name; without such a name the count stands
    /// alone, and what is counted ray by ray is none of it.
    #[test]
    fn touched_beside_stored() {
        let quality =
            Quality { missed: 0.0, blur: 0.0, speed: 1.0, clock: tracebench_api::ClockKind::DeviceTimestamps };
        let record = fixture::run(&[("bvh-gpu", quality)], &[("diffuse", Query::Closest)]).rows.remove(0);
        let of_set = CounterRecord { total: 1234, per_ray: 0.01, max_per_ray: None };
        // The structure of the fixture has 4321 nodes.
        let cell = |name: &str, counter: &CounterRecord| touched(&record, name, counter);
        assert_eq!(cell("nodes_touched", &of_set).as_deref(), Some("1,234 (28.6 % of 4,321)"));
        assert_eq!(cell("pixels_touched", &of_set).as_deref(), Some("1,234"));
        assert_eq!(cell("nodes", &of_set).as_deref(), Some("1,234"));
        let none = CounterRecord { total: 0, ..of_set.clone() };
        assert_eq!(cell("nodes_touched", &none).as_deref(), Some("0 (0 % of 4,321)"));
        assert_eq!(cell("nodes_touched", &CounterRecord { max_per_ray: Some(3), ..of_set }), None);
    }

    /// The summary, the table of peers and the page of a sweep show it, and none of them as a mean per ray.
    #[test]
    fn every_table_shows_what_was_touched() {
        let mut record = crate::report::sweep::tests::sweep_run(
            &[("node", "cwbvh", &["cwbvh", "bvh2"])],
            &[("diffuse", Query::Closest)],
            false,
        );
        for one in &mut record.rows {
            one.tracer.name = "bvh-gpu".to_owned();
            let counter = CounterRecord { total: 1234, per_ray: 0.015_625, max_per_ray: None };
            one.traces[0].counters.insert("nodes_touched".to_owned(), counter);
        }
        record.sweep.as_mut().unwrap().tracer = "bvh-gpu".to_owned();
        record.table = Some("bvh".to_owned());
        let folder = tempfile::TempDir::new().unwrap();
        fixture::write_derived(&record, folder.path(), fixture::tables).unwrap();
        for (name, rows) in [("summary.md", 2), ("table_bvh.md", 2), ("sweep.md", 2)] {
            let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
            assert_eq!(text.matches("1,234 (28.6 % of 4,321)").count(), rows, "{name}: {text}");
            assert!(!text.contains("0.0156") && !text.contains("nodes_touched per ray"), "{name}");
            assert_eq!(text.contains("37.00"), name != "sweep.md", "{name}: means of what is counted ray by ray");
        }
    }
}
