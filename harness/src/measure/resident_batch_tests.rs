//! What is built: one structure for all values of a trace parameter, and no more than a resident batch of structures at a time.

use std::cell::Cell;
use std::sync::LazyLock;

use tracebench_api::{
    Counter, Geometry, Hit, HitBuffer, MemoryReport, Parameter, ParameterScope, Parameters, PhaseClock, Preset, Status,
    Structure, TraceJob, Tracer, TracerDescription, TracerError, Update, Viewpoint, parameters,
};

use super::*;
use crate::judge::Rule;
use crate::plan::{Plan, RunPreset, SceneSource, TracerRequest, ViewRequest};
use crate::progress::Progress;
use crate::rays::{RAY_SETS, default_parameters};
use crate::registrations::{Registration, Told};
use crate::results::{Record, SampleSchedule};
use crate::studies::sweep::{Sweep, parameter_axis};
use crate::truth::Cache;

parameters! {
    /// What the counted tracer is told.
    struct CountedParameters {
        /// nothing
        shape: u32 = Parameter::integer(ParameterScope::Build, 1..=1000, 1).sweep([1, 2]),
        /// nothing
        search: u32 = Parameter::integer(ParameterScope::Trace, 1..=1000, 1).sweep([1, 2]),
    }
}

thread_local! {
    static BUILT: Cell<usize> = const { Cell::new(0) };
    static HELD: Cell<usize> = const { Cell::new(0) };
    static MAX_HELD: Cell<usize> = const { Cell::new(0) };
}

/// Misses every ray and counts what it builds.
struct Counted;

struct Held;

impl Drop for Held {
    fn drop(&mut self) {
        HELD.set(HELD.get() - 1);
    }
}

impl Tracer for Counted {
    fn build(
        &self,
        _geometry: &Geometry,
        _viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        let CountedParameters { shape, search } = CountedParameters::try_from(parameters)?;
        clock.host_phase("nothing", || ());
        assert!(shape > 0 && search > 0);
        BUILT.set(BUILT.get() + 1);
        HELD.set(HELD.get() + 1);
        MAX_HELD.set(MAX_HELD.get().max(HELD.get()));
        Ok(Box::new(Held))
    }
}

impl Structure for Held {
    fn update(
        &mut self,
        _update: Update,
        _geometry: &Geometry,
        _viewpoint: &Viewpoint,
        _parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        clock.host_phase("nothing", || ());
        Ok(())
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        let hits = hits.host_mut(job.rays.host.len())?;
        clock.host_phase("answer", || hits.fill(Hit::miss(Status::Miss)));
        Ok(())
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        hits.host_mut(job.rays.host.len())?.fill(Hit::miss(Status::Miss));
        Ok(Vec::new())
    }

    fn memory(&self) -> MemoryReport {
        MemoryReport::default()
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        Ok(Vec::new())
    }
}

fn description() -> TracerDescription {
    TracerDescription { name: "counted", parameters: CountedParameters::describe(), ..tracebench_bvh::description() }
}

fn request() -> TracerRequest {
    static TOLD: LazyLock<Told> = LazyLock::new(|| serde_json::from_str(r#"{"family": "image"}"#).unwrap());
    let registration = Registration { description, create: |_| Ok(Box::new(Counted)), parts: None, told: &TOLD };
    TracerRequest::of(&registration, Preset::Published)
}

fn plan() -> Plan {
    let smoke = RunPreset::named("smoke").unwrap();
    Plan {
        scenes: vec![SceneSource::Catalogue("room".to_owned())],
        tracers: vec![request()],
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

fn measured(work: impl FnOnce(&Context<'_>) -> Result<Record, RunError>) -> Record {
    BUILT.set(0);
    MAX_HELD.set(0);
    let device = Err(TracerError::Unavailable("none is needed".to_owned()));
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    work(&Context::new(&device, &cache, &quiet, &journal)).unwrap()
}

/// Proves that a tuning over so many values of a trace parameter builds one structure a viewpoint, and one of a build parameter
/// one a value.
#[test]
fn a_tuning_builds_one_structure() {
    let values: Vec<String> = (1..=9).map(|value| value.to_string()).collect();
    for (parameter, structures) in [("search", 1), ("shape", 9)] {
        let described = description().parameters.into_iter().find(|each| each.name == parameter).unwrap();
        let axis = parameter_axis(&request(), &described, Some(&values)).unwrap();
        let sweep = Sweep::new(&plan(), vec![axis], false).unwrap().choosing(Rule::Tight);
        let record = measured(|context| sweep.execute(context));
        // From two viewpoints.
        assert_eq!(
            (record.rows.len(), BUILT.get(), MAX_HELD.get()),
            (2 * 9, 2 * structures, structures),
            "{parameter}"
        );
    }
}

/// Proves that no more structures than a resident batch's are there at a time, that every resident batch after the first has the anchor,
/// which is the first configuration, and that everyone is measured once.
#[test]
fn a_window_of_structures_is_resident() {
    let most = MAX_RESIDENT + 8;
    for (parameter, windows) in [("shape", 2), ("search", 1)] {
        // An axis has room for fewer values than a resident batch has for structures, so the points are laid out here.
        let requests: Vec<TracerRequest> = (1..=most)
            .map(|value| {
                let mut request = request();
                request.set(parameter, &value.to_string()).unwrap();
                request
            })
            .collect();
        let plan = Plan { tracers: requests, ..plan() };
        let record = measured(|context| execute_all(std::slice::from_ref(&plan), context));
        assert_eq!(
            (record.rows.len(), record.anchors.len(), record.controls.len()),
            (most, windows - 1, controls::Control::ALL.len()),
            "{parameter}"
        );
        assert!(MAX_HELD.get() <= MAX_RESIDENT, "{} structures at a time", MAX_HELD.get());
        let last = record.rows.iter().map(|row| row.resident_batch).max();
        assert_eq!(last, Some(windows as u32 - 1));
        for anchor in &record.anchors {
            assert_eq!((&anchor.tracer, anchor.resident_batch), (&record.rows[0].tracer, 1));
        }
        let label = |row: &crate::results::Row| row.tracer.parameters[parameter].clone();
        let values: Vec<_> = record.rows.iter().map(label).collect();
        assert_eq!(values, (1..=most).map(serde_json::Value::from).collect::<Vec<_>>());
        assert_eq!(record.aligned().rows.iter().filter(|row| row.label().ends_with('†')).count(), 8 * (windows - 1));
    }
    // A sweep of the same tracer keeps its points.
    let described = description().parameters.remove(0);
    let axis = parameter_axis(&request(), &described, None).unwrap();
    let record = measured(|context| Sweep::new(&plan(), vec![axis], false).unwrap().execute(context));
    assert_eq!((record.rows.len(), record.sweep.map(|sweep| sweep.points.len())), (2, Some(2)));
}
