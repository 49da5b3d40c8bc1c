//! Sweeps of a tracer that has room for few structures only.

use std::cell::Cell;
use std::sync::LazyLock;

use tracebench_api::{
    Counter, Geometry, HitBuffer, MemoryReport, Parameters, PhaseClock, Preset, Structure, TraceJob, Tracer,
    TracerDescription, TracerError, Update, Value, Viewpoint,
};
use tracebench_bvh::BvhCpu;

use super::*;
use crate::measure::Journal;
use crate::plan::{RunPreset, SceneSource, ViewRequest};
use crate::progress::Progress;
use crate::rays::{RAY_SETS, default_parameters};
use crate::registrations::{Registration, Told};
use crate::results::SampleSchedule;
use crate::truth::Cache;

/// Structures that there is room for at once.
const REGISTRATION: usize = 2;

thread_local! {
    static HELD: Cell<usize> = const { Cell::new(0) };
}

/// `bvh-cpu` in a small room; `build=slow` fits nowhere.
struct Roomless;

struct Held(Box<dyn Structure>);

impl Drop for Held {
    fn drop(&mut self) {
        HELD.set(HELD.get() - 1);
    }
}

fn too_large() -> TracerError {
    TracerError::Failed("there is no room".to_owned())
}

impl Tracer for Roomless {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        if HELD.get() == REGISTRATION || parameters.value("build") == Some(&Value::Choice("slow".to_owned())) {
            return Err(too_large());
        }
        let built = BvhCpu.build(geometry, viewpoint, parameters, clock)?;
        HELD.set(HELD.get() + 1);
        Ok(Box::new(Held(built)))
    }
}

impl Structure for Held {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        self.0.update(update, geometry, viewpoint, parameters, clock)
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        self.0.trace(job, hits, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.0.trace_counted(job, hits)
    }

    fn memory(&self) -> MemoryReport {
        self.0.memory()
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.0.validate(geometry)
    }
}

fn description() -> TracerDescription {
    TracerDescription { name: "roomless", ..tracebench_bvh::description() }
}

fn plan(own: &str) -> Plan {
    static TOLD: LazyLock<Told> = LazyLock::new(|| {
        serde_json::from_str(r#"{"family": "bvh", "expectations": [{"kind": "exact", "rule": "tight"}]}"#).unwrap()
    });
    let registration = Registration { description, create: |_| Ok(Box::new(Roomless)), parts: None, told: &TOLD };
    let mut request = TracerRequest::of(&registration, Preset::Published);
    request.set("build", own).unwrap();
    let smoke = RunPreset::named("smoke").unwrap();
    Plan {
        scenes: vec![SceneSource::Catalogue("room".to_owned()), SceneSource::Catalogue("solids".to_owned())],
        tracers: vec![TracerRequest { required: true, ..request }],
        ray_sets: RAY_SETS[..1].to_vec(),
        ray_parameters: default_parameters(),
        preset: RunPreset { ray_image: [8, 8], sampling: SampleSchedule::rounds(1), ..smoke },
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        trace_to: tracebench_api::TraceTo::Hit,
        builds_timed: true,
        wrong_rays_per_cause: crate::judge::WRONG_RAYS_PER_CAUSE,
        table: None,
    }
}

fn swept(own: &str, values: &[&str]) -> Result<Record, RunError> {
    let plan = plan(own);
    let values: Vec<String> = values.iter().map(|value| (*value).to_owned()).collect();
    let build = &description().parameters[0];
    let axes = vec![parameter_axis(&plan.tracers[0], build, Some(&values)).unwrap()];
    let none = Err(TracerError::Unavailable("none is needed".to_owned()));
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    Sweep::new(&plan, axes, false).unwrap().execute(&Context::new(&none, &cache, &quiet, &journal))
}

/// Proves that what found no room beside others is measured alone, in every scene, that what finds none then either is
/// skipped with the reason, once a scene and point, and that nothing is said of what was measured after all.
#[test]
fn what_fails_beside_others_is_tried_alone() {
    let record = swept("medium", &["fastest", "very_fast", "fast", "slow"]).unwrap();
    let sweep = record.sweep.as_ref().unwrap();
    assert_eq!((sweep.points.len(), record.rows.len()), (5, 2 * 4));
    for point in &sweep.points {
        let measured = record.rows.iter().filter(|one| point.is_of(one)).count();
        let skipped = point.skipped.keys().map(String::as_str).collect::<Vec<_>>();
        let expected = if point.values["build"] == "slow" { (0, vec!["room", "solids"]) } else { (2, Vec::new()) };
        assert_eq!((measured, skipped), expected, "{point:?}");
    }
    let said: Vec<_> = record.skipped.iter().map(|one| (one.scene.as_str(), one.reason.as_str())).collect();
    let reason = "build=slow: there is no room";
    let said_of: Vec<_> = said.iter().filter(|(_, said)| said.starts_with(reason)).map(|(scene, _)| *scene).collect();
    assert_eq!((said_of, said.len()), (vec!["room", "solids"], 2), "{said:?}");
}

/// Proves that own values which cannot be measured do not end a sweep, and that a sweep of nothing is an error which says
/// why once.
#[test]
fn own_values_may_fail() {
    let record = swept("slow", &["fast"]).unwrap();
    assert_eq!(record.rows.len(), 2);
    let error = swept("slow", &["slow"]).unwrap_err().to_string();
    assert_eq!(error.matches("there is no room").count(), 1, "{error}");
}
