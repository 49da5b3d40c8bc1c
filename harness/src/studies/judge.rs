//! Answers of a program that is no tracer of this suite: judged as every tracer's are, beside the same controls.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use tracebench_api::{TraceTo, Viewpoint};

use crate::exchange::answers::Answers;
use crate::exchange::{SavedRays, TRUTHS_CHECKED};
use crate::judge::Judge;
use crate::measure::session::{PreparedRays, Session};
use crate::measure::{self, Context, MeasureOptions, Observations, PreparedWorkload, RunError, Workload, records};
use crate::rays::RaySet;
use crate::results::{JudgedRecord, Record, Row, SceneRecord, TraceRecord, TracerRecord, ViewpointRecord};
use crate::truth::{Answer, Truth};

/// Judges what a program of some name answered into a record. `wrong_rays`: how many of each cause are kept.
///
/// # Errors
/// [`RunError`] if the answers are none, or a control fails.
pub(crate) fn execute(
    (set, answers, truth): (SavedRays, Vec<Answer>, Truth),
    told: &Answers,
    name: &str,
    wrong_rays: usize,
    context: &Context<'_>,
) -> Result<Record, RunError> {
    let SavedRays { manifest, rays } = set;
    let none = || ViewpointRecord { name: "none".to_owned(), ..ViewpointRecord::default() };
    let (eye, viewpoint) = (manifest.eye(), manifest.viewpoint.unwrap_or_else(none));
    let scene = SceneRecord { diagonal: truth.diagonal(), ..manifest.scene };
    let set = RaySet::given(manifest.name.leak(), manifest.query);
    // Nobody builds from there.
    let (forward, up) = (Vec3::NEG_Z, Vec3::Y);
    let nowhere =
        Viewpoint { eye: Vec3::ZERO, forward, up, vertical_fov: 1.0, near: 0.1, far: 1.0, frame: [1; 2], face: 1 };
    let rays = vec![PreparedRays::new(set, (rays, Arc::new(answers)), eye, None)];
    let session = Session::with(Arc::new(truth), nowhere, None, rays, Vec::new());
    let session = Session { wrong_rays_per_cause: wrong_rays, ..session };
    let placed = PreparedWorkload { scene, viewpoint, difficulty_level: None, session };
    let prepare = Box::new(|| Ok::<_, RunError>(placed));
    let hook = |session: &Session, rays: &PreparedRays, _: &[Option<Observations>]| {
        let judge = Judge { names_primitives: told.names_triangles, ..session.judge_of(rays, &[]) };
        let judgement = judge.judge(&told.hits).map_err(|error| RunError::Nothing(error.to_string()))?;
        let times = records::times(&[], true);
        let trace = records::trace_record(rays, times, &told.hits, &[], Vec::new(), TraceTo::Hit, (judgement, None));
        let self_reported = told.self_reported.clone();
        measure::told(&TraceRecord { self_reported, ..trace })
    };
    let options = MeasureOptions::untimed();
    let place = Workload { index: 0, scene_sha256: None, prepare, requests: &[], options, hook: Some(&hook) };
    let mut found = measure::measure(place, context)?;
    let traces = found.take_hooked()?;
    let oracle = found.controls.first().cloned().ok_or_else(|| RunError::Nothing("no control was there".to_owned()))?;
    let (name, preset, residency) = (name.to_owned(), "published".to_owned(), "host".to_owned());
    let tracer = TracerRecord { name, preset, parameters: BTreeMap::new(), changed: Vec::new(), residency };
    let judged = Some(JudgedRecord { truths_checked: TRUTHS_CHECKED as u64 });
    let (seed, ray_parameters) = (manifest.seed, manifest.ray_parameters);
    let mut record = Record { seed, ray_parameters, judged, ..measure::empty([], context) };
    measure::add(&mut record, found);
    record.rows.push(Row { tracer, fingerprint: None, traces, ..oracle });
    Ok(record)
}
