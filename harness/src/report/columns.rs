//! Columns that several tables have: what was measured, by which clock, and how right it is.

use serde::Serialize;
use tracebench_api::Query;

use super::format::{clock_code, clock_of, significant};
use super::metrics::{self, BUILD_TIME, FIRST_BUILD, Metric, STEADY_BUILD};
use super::sheet::{Cell, Column, Sheet};
use crate::results::{Judgement, PhaseRecord, Row, Times, TraceRecord};

impl<'a, R> Sheet<'a, R> {
    /// With something as JSON.
    pub(super) fn json<T: Serialize + 'a>(self, name: &str, of: impl Fn(&R) -> &T + 'a) -> Self {
        self.csv_column(name, move |row| serde_json::to_string(of(row)).unwrap_or_default())
    }

    /// With the clock of times.
    pub(crate) fn clock(self, name: &str, of: impl Fn(&R) -> Option<&Times> + 'a) -> Self {
        self.clock_called(&name.replace('_', " "), name, of)
    }

    /// With the clock of times, called otherwise on pages.
    pub(crate) fn clock_called(self, heading: &str, name: &str, of: impl Fn(&R) -> Option<&Times> + 'a) -> Self {
        let named = |times: &Times| Cell::Named(clock_code(times.clock), clock_of(times));
        self.and(Column::csv(name, move |row| of(row).map(named)).headed(heading))
    }

    /// With the phases of times by their medians.
    pub(crate) fn phases(self, heading: &str, between: &'static str, of: impl Fn(&R) -> Option<&Times> + 'a) -> Self {
        let phase = |phase: &PhaseRecord| format!("{} {}", phase.name, significant(phase.median_ms, 3));
        let told = move |times: &Times| times.phases.iter().map(phase).collect::<Vec<_>>().join(between);
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

    /// With a figure of traces.
    pub(crate) fn trace(self, metric: Metric, of: impl Fn(&R) -> Option<&TraceRecord> + 'a) -> Self {
        self.and(metric.of_trace(of))
    }

    /// With a figure of whatever tells it.
    pub(super) fn metric(self, metric: Metric, cell: impl Fn(&R) -> Option<Cell> + 'a) -> Self {
        self.and(metric.shown(cell))
    }

    /// With what tells how often answers to a query are right, of a judgement on so many rays that count.
    pub(super) fn accuracies_of(self, query: Query, of: impl Fn(&R) -> Option<(&Judgement, u64)> + Copy + 'a) -> Self {
        let column = |(place, metric): (usize, &Metric)| {
            let right = move |row: &R| {
                let (judgement, trials) = of(row)?;
                let of_query = matches!(judgement, Judgement::Closest(_)) == (query == Query::Closest);
                judgement.accuracies(trials).get(place).filter(|_| of_query).copied().map(Cell::Accuracy)
            };
            metric.shown(right)
        };
        self.with(metrics::accuracies(query).iter().enumerate().map(column).collect())
    }

    /// With what tells how often answers to a query are right.
    pub(crate) fn accuracies(self, query: Query, of: impl Fn(&R) -> Option<&TraceRecord> + Copy + 'a) -> Self {
        self.with(metrics::accuracies(query).iter().map(|metric| metric.of_trace(of)).collect())
    }
}
