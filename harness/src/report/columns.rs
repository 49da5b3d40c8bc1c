//! Columns that several tables have: what was measured, where, with what, and how right it is.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use tracebench_api::Query;

use super::format::{self, clock_code, clock_of, significant};
use super::metrics::{self, AMBIGUOUS, BUILD_TIME, FIRST_BUILD, Metric, STEADY_BUILD, Traced};
use super::sheet::{Cell, Column, Sheet};
use crate::results::{
    CounterRecord, Judgement, PhaseRecord, Provenance, Run, SceneRecord, Times, TraceRecord, TracerRun, ViewpointRecord,
};

impl<'a, R> Sheet<'a, R> {
    /// With the scene's name and hash.
    pub(super) fn scene_of(self, of: impl Fn(&R) -> (&str, &str) + Copy + 'a) -> Self {
        self.column("scene", move |row| of(row).0.to_owned()).column("scene_sha256", move |row| of(row).1.to_owned())
    }

    /// With the scene.
    pub(super) fn scene(self, of: impl Fn(&R) -> &SceneRecord + Copy + 'a) -> Self {
        self.scene_of(move |row| (&*of(row).name, &*of(row).sha256)).column("triangles", move |row| of(row).triangles)
    }

    /// With the frame and the faces that structures take theirs from.
    pub(super) fn sizes(self, of: impl Fn(&R) -> ([u32; 2], u32) + Copy + 'a) -> Self {
        self.column("frame_px", move |row| size(of(row).0)).column("face_px", move |row| of(row).1)
    }

    /// With frame, faces, and the image from whose pixels rays start.
    pub(super) fn all_sizes(self, of: impl Fn(&R) -> &ViewpointRecord + Copy + 'a) -> Self {
        self.sizes(move |row| (of(row).frame, of(row).face)).column("ray_image_px", move |row| size(of(row).ray_image))
    }

    /// With something as JSON.
    pub(super) fn json<T: Serialize + 'a>(self, name: &str, of: impl Fn(&R) -> &T + 'a) -> Self {
        self.column(name, move |row| serde_json::to_string(of(row)).unwrap_or_default())
    }

    /// With the tracer and everything that it was asked for.
    pub(super) fn tracer(self, of: impl Fn(&R) -> &TracerRun + Copy + 'a) -> Self {
        self.column("tracer", move |row| of(row).label())
            .column("tracer_name", move |row| of(row).tracer.name.clone())
            .json("parameters_json", move |row| &of(row).tracer.parameters)
    }

    /// With the rays' name and hash.
    pub(super) fn rays(self, of: impl Fn(&R) -> Option<&TraceRecord> + Copy + 'a) -> Self {
        self.column("rays", move |row| of(row).map(|trace| trace.rays.clone()))
            .column("rays_sha256", move |row| of(row).map(|trace| trace.rays_sha256.clone()))
    }

    /// With what is asked of rays.
    pub(super) fn query(self, of: impl Fn(&R) -> Option<Query> + 'a) -> Self {
        let code = |query| match query {
            Query::Closest => "closest",
            Query::Any => "any",
        };
        let named = move |query| Cell::Named(code(query), format::query(query).to_owned());
        self.and(Column::new("query", move |row| of(row).map(named)).headed("query"))
    }

    /// With the hash of a trace's answers.
    pub(super) fn hits(self, of: impl Fn(&R) -> Option<&TraceRecord> + 'a) -> Self {
        self.column("hits_sha256", move |row| of(row).map(|trace| trace.hits_sha256.clone()))
    }

    /// With the clock of times.
    pub(crate) fn clock(self, name: &str, of: impl Fn(&R) -> Option<&Times> + 'a) -> Self {
        self.clock_called(&name.replace('_', " "), name, of)
    }

    /// With the clock of times, called otherwise on pages.
    pub(crate) fn clock_called(self, heading: &str, name: &str, of: impl Fn(&R) -> Option<&Times> + 'a) -> Self {
        let named = |times: &Times| Cell::Named(clock_code(times.clock), clock_of(times));
        self.and(Column::new(name, move |row| of(row).map(named)).headed(heading))
    }

    /// With the phases of times by their medians.
    pub(crate) fn phases(self, heading: &str, between: &'static str, of: impl Fn(&R) -> Option<&Times> + 'a) -> Self {
        let phase = |phase: &PhaseRecord| format!("{} {}", phase.name, significant(phase.median_ms, 3));
        let told = move |times: &Times| times.phases.iter().map(phase).collect::<Vec<_>>().join(between);
        self.told(heading, move |row| of(row).map(told))
    }

    /// With the times of first and steady builds or, of records of before these were told, with that of builds under a name.
    pub(crate) fn builds(self, called: &'static str, of: impl Fn(&R) -> Option<&TracerRun> + Copy + 'a) -> Self {
        let metrics = [BUILD_TIME.called(called), FIRST_BUILD, STEADY_BUILD];
        self.with(metrics.map(|metric| metric.of_structure(of)).into())
    }

    /// With the phases of builds and, where what stands beside them is by the host's clock, theirs.
    pub(crate) fn build_phases(
        self,
        heading: &str,
        between: &'static str,
        of: impl Fn(&R) -> &TracerRun + Copy + 'a,
    ) -> Self {
        let clock = move |row: &R| {
            let build = &of(row).build;
            build.steady.as_ref().map_or(Cell::Absent, |_| clock_of(&build.times).into())
        };
        self.told("clock of phases", clock).phases(heading, between, move |row| Some(&of(row).build.times))
    }

    /// With a figure of structures.
    pub(crate) fn structure(self, metric: Metric, of: impl Fn(&R) -> Option<&TracerRun> + 'a) -> Self {
        self.and(metric.of_structure(of))
    }

    /// With a figure of traces.
    pub(crate) fn trace(self, metric: Metric, of: impl Fn(&R) -> Option<&TraceRecord> + 'a) -> Self {
        self.and(metric.of_trace(of))
    }

    /// With a figure of traces and what else its cells have.
    pub(super) fn whole_trace(self, metric: Metric, of: impl Fn(&R) -> Option<&TraceRecord> + 'a) -> Self {
        self.and(metric.of_trace(of).whole(metric))
    }

    /// With a figure of whatever tells it.
    pub(super) fn metric(self, metric: Metric, cell: impl Fn(&R) -> Option<Cell> + 'a) -> Self {
        self.and(metric.shown(cell))
    }

    /// With every figure of a trace; what older records have none of is not there.
    pub(super) fn metrics(self, runs: &[TracerRun], of: impl Fn(&R) -> Option<Traced<'_>> + Copy + 'a) -> Self {
        let beside = metrics::with_ambiguous(runs.iter().flat_map(|run| &run.traces));
        let all = metrics::METRICS.iter().chain(&beside);
        self.with(all.map(|metric| metric.column(of).whole(*metric)).collect())
    }

    /// With what tells how often answers to a query are right, of a judgement on so many rays that count.
    pub(super) fn accuracies_of(self, query: Query, of: impl Fn(&R) -> Option<(&Judgement, u64)> + Copy + 'a) -> Self {
        let column = |(place, metric): (usize, &Metric)| {
            let right = move |row: &R| {
                let (judgement, trials) = of(row)?;
                let of_query = matches!(judgement, Judgement::Closest(_)) == (query == Query::Closest);
                metrics::accuracies_of(judgement, trials).get(place).filter(|_| of_query).copied().map(Cell::Accuracy)
            };
            metric.shown(right).whole(*metric)
        };
        self.with(metrics::accuracies(query).iter().enumerate().map(column).collect())
    }

    /// With what tells how often answers to a query are right.
    pub(crate) fn accuracies(self, query: Query, of: impl Fn(&R) -> Option<&TraceRecord> + Copy + 'a) -> Self {
        self.with(metrics::accuracies(query).iter().map(|metric| metric.of_trace(of)).collect())
    }

    /// With what tells how often answers are right, whatever was asked, and the ambiguous rays.
    pub(super) fn accuracy(self, of: impl Fn(&R) -> Option<&TraceRecord> + Copy + 'a) -> Self {
        self.accuracies(Query::Closest, of).accuracies(Query::Any, of).trace(AMBIGUOUS, of)
    }

    /// With a column of each counter that some runs have, its mean per ray.
    pub(super) fn counters(
        self,
        runs: &'a [TracerRun],
        of: impl Fn(&R) -> Option<&BTreeMap<String, CounterRecord>> + Copy + 'a,
    ) -> Self {
        let traces = runs.iter().flat_map(|run| &run.traces);
        let names: BTreeSet<&'a String> = traces.flat_map(|trace| trace.counters.keys()).collect();
        let column = |name: &'a String| {
            let mean = move |row: &R| of(row)?.get(name).map(|counter| counter.per_ray);
            Column::new(format!("counter_{name}_per_ray"), mean)
        };
        self.with(names.into_iter().map(column).collect())
    }

    /// With the same in every row.
    pub(super) fn constant(self, name: &str, value: impl Into<Cell>) -> Self {
        let value = value.into();
        self.column(name, move |_| value.clone())
    }

    /// With the commit.
    pub(super) fn commit(self, from: &Provenance) -> Self {
        self.constant("commit", from.commit.clone())
    }

    /// With of what, how and where a table was measured.
    pub(super) fn provenance(self, from: &Provenance, preset: &str) -> Self {
        self.commit(from).constant("run_preset", preset).constant("machine", from.machine.label())
    }

    /// The same with whether the tree was changed, and what rays come from.
    pub(super) fn whole_provenance(self, run: &Run) -> Self {
        let Run { provenance, preset, seed, .. } = run;
        let sheet = self.commit(provenance).constant("dirty", provenance.dirty).constant("run_preset", &**preset);
        sheet.constant("seed", *seed).constant("machine", provenance.machine.label())
    }

    /// With the machine of each row, where a record has several.
    pub(super) fn machine_of(self, from: &'a Provenance, of: impl Fn(&R) -> &TracerRun + 'a) -> Self {
        self.column("machine", move |row| from.machine_of(of(row).machine).label())
    }
}

fn size([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}
