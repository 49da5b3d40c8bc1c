//! Runs cases: every tracer at every strength, judged against the truth and against what is expected of it.

mod record;
mod verdict;

use std::sync::Arc;

use tracebench_api::{Geometry, Gpu, TracerError};

use crate::cases::{CASES, Case, Probe, Setup};
use crate::contenders::Expectation;
use crate::plan::TracerRequest;
use crate::progress::Progress;
use crate::rays::RaySet;
use crate::records;
use crate::registry::Device;
use crate::results::{Judgement, Provenance, Skipped};
use crate::runner::RunError;
use crate::session::{Contender, PreparedRays, Session, SessionError};
use crate::truth::Truth;

pub use record::{CaseRecord, Cell, ExpectationRecord, KnobRecord, Measured, SCHEMA, Stability, Strength};
pub use verdict::Verdict;
pub(crate) use verdict::percent;

/// A tracer with what is expected of it.
pub struct Candidate {
    /// Its name in tables, with preset and changes.
    pub label: String,
    /// The tracer.
    pub contender: Contender,
    /// What is expected of it, by case.
    pub expected: Vec<(&'static str, Expectation)>,
}

impl Candidate {
    /// Creates a requested tracer. Expectations hold for the published preset; parameters that were changed are set
    /// against them all the same.
    fn create(request: &TracerRequest, device: &Device) -> Result<Self, TracerError> {
        let description = (request.registration.describe)();
        let contender =
            Contender::create(description, request.parameters.clone(), || request.registration.create(device))?;
        let label = records::tracer_record(&contender, Some(request)).label();
        Ok(Self { label, contender, expected: expected_of(request) })
    }
}

/// Runs cases with the tracers that were asked for.
///
/// # Errors
/// [`RunError`] if a tracer that was asked for by name cannot run, none can, or the device fails.
pub fn run(
    cases: &[&Case],
    requests: &[TracerRequest],
    device: &Device,
    progress: &Progress,
) -> Result<Stability, RunError> {
    let mut candidates = Vec::new();
    let (mut absent, mut skipped) = (Vec::new(), Vec::new());
    for (column, request) in requests.iter().enumerate() {
        let tracer = (request.registration.describe)().name.to_owned();
        match Candidate::create(request, device) {
            Ok(candidate) => candidates.push(candidate),
            Err(error) if request.required => return Err(RunError::Tracer { tracer, error }),
            Err(error) => {
                absent.push((column, request));
                progress.say(&format!("skipped {tracer}: {error}"));
                let scene = "cases".to_owned();
                skipped.push(Skipped { tracer: Some(tracer), scene, rays: None, reason: error.to_string() });
            }
        }
    }
    if candidates.is_empty() {
        let reasons: Vec<_> = skipped.iter().map(|skipped| skipped.reason.as_str()).collect();
        return Err(RunError::Nothing(reasons.join("; ")));
    }
    let gpu = device.as_ref().ok();
    let needs_adapter = requests.iter().any(|request| request.registration.needs_device());
    let mut stability = Stability {
        schema: SCHEMA,
        provenance: Provenance::now(gpu.filter(|_| needs_adapter).map(|gpu| gpu.listing.clone())),
        counts: requests.iter().all(|request| request.changed.is_empty()),
        cases: Vec::new(),
        skipped,
    };
    for case in cases {
        progress.say(&format!("case {}", case.name));
        let mut record = measure(case, &mut candidates, gpu)?;
        // From left to right, so that every one comes to stand in the column that it was asked for in.
        for (column, request) in &absent {
            record.tracers.insert(*column, absent_cell(case, request));
        }
        stability.cases.push(record);
    }
    Ok(stability)
}

fn absent_cell(case: &Case, request: &TracerRequest) -> Cell {
    let expected = expected_of(request);
    verdict::unavailable(&records::request_record(request).label(), expectation_on(&expected, case))
}

/// What is expected of a request, by case: something of the published preset alone.
fn expected_of(request: &TracerRequest) -> Vec<(&'static str, Expectation)> {
    let of_published = CASES.iter().filter(|_| request.preset == tracebench_api::Preset::Published);
    of_published.filter_map(|case| Some((case.name, request.registration.expected_on(case.name)?))).collect()
}

fn expectation_on<'a>(expected: &'a [(&'static str, Expectation)], case: &Case) -> Option<&'a Expectation> {
    expected.iter().find(|(name, _)| *name == case.name).map(|(_, expected)| expected)
}

/// Measures one case: every candidate at every strength.
///
/// # Errors
/// [`RunError`] if the case cannot be made or the device fails. What a tracer or a control does wrong is in the record.
pub fn measure(case: &Case, candidates: &mut [Candidate], gpu: Option<&Arc<Gpu>>) -> Result<CaseRecord, RunError> {
    let mut strengths = Vec::new();
    let mut measured: Vec<Vec<Measured>> = candidates.iter().map(|_| Vec::new()).collect();
    let mut void = None;
    for &strength in case.knob.values {
        let setup = (case.make)(strength)?;
        let session = prepare(case, &setup, gpu)?;
        let rays = &session.rays[0];
        strengths.push(describe(case, strength, &setup, &session));
        if let Err(reason) = check_controls(&session) {
            void.get_or_insert_with(|| format!("at {strength}: {reason}"));
        }
        for (candidate, measured) in candidates.iter_mut().zip(&mut measured) {
            let judged = answer(&session, rays, &mut candidate.contender);
            measured.push(Measured::new(strength, judged));
        }
    }
    let cells = candidates.iter().zip(measured).map(|(candidate, measured)| {
        verdict::cell(case, &candidate.label, expectation_on(&candidate.expected, case), measured)
    });
    Ok(CaseRecord {
        name: case.name.to_owned(),
        summary: case.summary.to_owned(),
        knob: KnobRecord::from(&case.knob),
        feature: case.feature.what.to_owned(),
        least_featured: case.feature.least,
        strengths,
        void,
        tracers: cells.collect(),
    })
}

/// A case at one strength with its truth, on the device as well if there is one.
///
/// # Errors
/// [`RunError`] if the truth fails its audit or the device fails.
pub fn prepare(case: &Case, setup: &Setup, gpu: Option<&Arc<Gpu>>) -> Result<Session, RunError> {
    let Geometry { positions, triangles, .. } = &setup.geometry;
    let geometry = Geometry::new(positions.to_vec(), triangles.to_vec(), gpu.map(AsRef::as_ref))?;
    let truth = Truth::new(&geometry, case.name);
    let set = RaySet::given(case.name, setup.query);
    Ok(Session::of_rays(truth, setup.viewpoint, set, setup.rays.clone(), gpu.cloned())?)
}

fn describe(case: &Case, strength: f64, setup: &Setup, session: &Session) -> Strength {
    let rays = &session.rays[0];
    let (true_hits, true_misses) = rays.hits_and_misses();
    let probe = Probe { setup, truth: session.truth(), answers: &rays.answers };
    let featured = (0..setup.rays.len()).filter(|index| (case.feature.has)(&probe, *index)).count();
    let count = setup.rays.len() as u64;
    Strength {
        strength,
        triangles: setup.geometry.triangles.len() as u64,
        query: setup.query,
        frame: setup.viewpoint.frame,
        rays: count,
        true_hits,
        true_misses,
        ties: count - true_hits - true_misses,
        featured: featured as f64 / count.max(1) as f64,
    }
}

/// The controls go the way of every contender.
fn check_controls(session: &Session) -> Result<(), String> {
    let rays = &session.rays[0];
    let (occluded, free) = rays.hits_and_misses();
    for (control, mut contender) in session.controls() {
        let judgement = answer(session, rays, &mut contender).map_err(|error| error.to_string())?;
        control.check(&judgement, occluded, free)?;
    }
    Ok(())
}

/// Builds, traces into poisoned hits, traces with counting, which must not change them, and judges.
fn answer(session: &Session, rays: &PreparedRays, contender: &mut Contender) -> Result<Judgement, SessionError> {
    session.sample_build(contender)?;
    let mut hits = session.hit_buffer(contender, rays)?;
    session.sample_trace(contender, rays, &mut hits)?;
    let hits = hits.read(session.gpu())?;
    session.count(contender, rays, &hits, &[])?;
    session.judge(contender, rays, &hits)
}
