//! Columns of pages that tell of traces: never a speed without its accuracy.

use std::collections::BTreeMap;

use tracebench_api::Query;

use super::document::Document;
use super::format::{significant, statistic, thousands};
use super::group::{Group, RaySet, Role};
use super::metrics::{Better, Metric, SPEED, headed, judged};
use super::sheet::{Cell, Column, Sheet};
use crate::results::{CounterRecord, Row, TraceRecord};

/// A trace with its place in the table.
pub(crate) type TableRow<'a> = (Role, &'a Row, &'a TraceRecord);

/// The row of a table that has no others.
pub(crate) fn own<'a>(row: &'a TableRow<'_>) -> Option<TableRow<'a>> {
    Some(*row)
}

impl<'a, R> Sheet<'a, R> {
    /// With the tracer's label.
    pub(crate) fn name(self, of: impl Fn(&R) -> Option<TableRow<'_>> + 'a) -> Self {
        self.column("tracer", move |row| of(row).map(|(role, row, _)| label(role, row)))
    }

    /// With the clock of traces; controls trace nothing.
    pub(crate) fn own_clock(self, of: impl Fn(&R) -> Option<TableRow<'_>> + 'a) -> Self {
        self.clock("clock", move |row| of(row).filter(contends).map(|(.., trace)| &trace.times))
    }

    /// With what traces take, only beside an accuracy, and never of controls.
    pub(crate) fn taken(self, metric: Metric, of: impl Fn(&R) -> Option<TableRow<'_>> + 'a) -> Self {
        self.trace(metric, move |row| of(row).filter(|row| contends(row) && judged(row.2)).map(|(.., trace)| trace))
    }

    /// With what tells how often answers to a query are right.
    pub(crate) fn right(self, query: Query, of: impl Fn(&R) -> Option<TableRow<'_>> + Copy + 'a) -> Self {
        self.accuracies(query, move |row| of(row).map(|(.., trace)| trace))
    }

    /// With every counter of some rows: means per ray, but of what is counted over a set how much of it.
    pub(crate) fn counted(self, rows: &[TableRow<'a>], of: impl Fn(&R) -> Option<TableRow<'_>> + Copy + 'a) -> Self {
        self.with(counted(rows).into_iter().map(|(name, of_set)| counter(name, of_set, of)).collect())
    }

    /// With those that are counted over a set, or else those that are not.
    pub(crate) fn counted_that(
        self,
        are_of_set: bool,
        rows: &[TableRow<'a>],
        of: impl Fn(&R) -> Option<TableRow<'_>> + Copy + 'a,
    ) -> Self {
        let wanted = counted(rows).into_iter().filter(|(_, of_set)| *of_set == are_of_set);
        self.with(wanted.map(|(name, of_set)| counter(name, of_set, of)).collect())
    }
}

/// The traces of configurations over a ray set below its heading: tracer, clock, speed, what further columns tell, accuracy and counters.
pub(super) fn traces<'a>(
    group: &'a Group<'_>,
    set: &'a RaySet<'_>,
    adaptive: impl FnOnce(Sheet<'a, TableRow<'a>>) -> Sheet<'a, TableRow<'a>>,
) -> Document {
    let all = group.traces(set);
    let rows: Vec<TableRow<'_>> = all.iter().copied().filter(contends).collect();
    let sheet =
        adaptive(Sheet::new().name(own).own_clock(own).taken(SPEED, own)).right(set.query, own).counted(&rows, own);
    set.headed(3, "").paragraph(coverage(&all)).table(sheet.table(&rows))
}

fn contends((role, ..): &TableRow<'_>) -> bool {
    *role == Role::Tracer
}

/// The intervals' coverage, which few samples cannot bring to 95 %.
pub(crate) fn coverage(rows: &[TableRow<'_>]) -> String {
    let timed = rows.iter().filter(|(role, _, trace)| *role == Role::Tracer && !trace.times.samples_ms.is_empty());
    let (mut low, mut high, mut samples) = (f64::INFINITY, 0.0_f64, u64::MAX);
    for (_, _, trace) in timed {
        low = low.min(trace.times.interval_coverage);
        high = high.max(trace.times.interval_coverage);
        samples = samples.min(trace.times.samples_ms.len() as u64);
    }
    if !low.is_finite() {
        return String::new();
    }
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

/// The counters of some rows, and whether they are counted over a set.
fn counted<'a>(rows: &[TableRow<'a>]) -> BTreeMap<&'a String, bool> {
    let mut counted = BTreeMap::new();
    for (name, counter) in rows.iter().flat_map(|(.., trace)| &trace.counters) {
        *counted.entry(name).or_default() |= counter.max_per_ray.is_none();
    }
    counted
}

fn counter<'a, R>(name: &'a String, of_set: bool, of: impl Fn(&R) -> Option<TableRow<'_>> + 'a) -> Column<'a, R> {
    let heading = if of_set { name.clone() } else { format!("{name} per ray") };
    Column::new(headed(&heading, Better::Lower), move |row| {
        let (_, row, trace) = of(row)?;
        let counter = trace.counters.get(name)?;
        Some(touched(row, name, counter).map_or(Cell::Number(counter.per_ray, 4), Cell::Text))
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
