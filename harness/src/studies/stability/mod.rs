//! Runs cases: every tracer at every strength, judged against the truth and against what is expected of it.

mod expected;
mod matrix;
mod verdict;

use std::sync::Arc;

use tracebench_api::{Geometry, Gpu, Rasterizer};

use crate::cases::{CASES, Case, Probe, Setup};
use crate::contenders::Expectation;
use crate::hash;
use crate::judge::true_counts;
use crate::measure::session::Session;
use crate::measure::{self, Context, Effort, Place, Placed, Refusal, Request, RunError, records};
use crate::plan::TracerRequest;
use crate::rays::RaySet;
use crate::results::{
    CaseRecord, CaseTracer, CasesRecord, EXACT, ExpectationRecord, KnobRecord, NoAnswer, Run, SceneRecord, Skipped,
    Strength, TrueCounts,
};
use crate::truth::Truth;

pub use expected::{ExpectedError, ExpectedShares};
pub use matrix::{CaseMatrix, Cell, Measured, Stability};
pub use verdict::Verdict;
pub(crate) use verdict::percent;

/// A tracer with what is expected of it.
pub struct Candidate {
    /// The tracer.
    pub request: TracerRequest,
    /// What is expected of it, by case.
    pub expected: Vec<(&'static str, Expectation)>,
    /// Under which name its shares of wrong rays stand.
    pub column: String,
    /// Where they stand.
    pub shares: Arc<ExpectedShares>,
}

impl Candidate {
    /// A requested tracer. Expectations hold for its preset; parameters that were changed are set against them all the same.
    pub fn of(request: &TracerRequest, shares: &Arc<ExpectedShares>) -> Self {
        let expected_on = |case: &Case| Some((case.name, request.registration.expected_of(request.preset, case.name)?));
        let expected = CASES.iter().filter_map(expected_on).collect();
        let column = request.registration.column(request.preset);
        Self { request: request.clone(), expected, column, shares: Arc::clone(shares) }
    }

    /// What is expected on a case, on an adapter of a kind with such a rasterizer.
    pub fn record(&self, case: &Case, kind: &str, rasterizer: Option<&Rasterizer>) -> Option<ExpectationRecord> {
        let (_, expected) = self.expected.iter().find(|(name, _)| *name == case.name)?;
        let record = expected.record(case.knob.values, rasterizer);
        if record.kind == EXACT {
            return Some(record);
        }
        let wrong_shares = self.shares.of(&self.column, case.name, kind, case.knob.values);
        Some(ExpectationRecord { wrong_shares, ..record })
    }
}

/// Runs cases with the tracers that were asked for.
///
/// # Errors
/// [`RunError`] if a tracer that was asked for by name cannot run, none can, or the device fails.
pub fn run(cases: &[&Case], requests: &[TracerRequest], context: &Context<'_>) -> Result<Run, RunError> {
    let shares = ExpectedShares::stated().map_err(|error| RunError::Nothing(error.to_string()))?;
    let shares = Arc::new(shares);
    let candidates: Vec<Candidate> = requests.iter().map(|request| Candidate::of(request, &shares)).collect();
    let run = measure(cases, &candidates, context)?;
    if run.skipped.len() == candidates.len() {
        return Err(measure::nothing(&run));
    }
    Ok(run)
}

/// Runs cases with candidates. What a tracer or a control does wrong is in the record.
///
/// # Errors
/// [`RunError`] if a tracer that was asked for by name cannot run, a case cannot be made, or the device fails.
pub fn measure(cases: &[&Case], candidates: &[Candidate], context: &Context<'_>) -> Result<Run, RunError> {
    let mut run = measure::empty(candidates.iter().map(|candidate| &candidate.request), context);
    let mut absent = vec![false; candidates.len()];
    for (candidate, absent) in candidates.iter().zip(&mut absent) {
        let tracer = candidate.request.name().to_owned();
        match context.create(&candidate.request) {
            Ok(()) => {}
            Err(error) if candidate.request.required => return Err(RunError::Tracer { tracer, error }),
            Err(error) => {
                *absent = true;
                context.progress.say(&format!("skipped {tracer}: {error}"));
                let (scene, reason) = ("cases".to_owned(), error.to_string());
                run.skipped.push(Skipped { tracer: Some(tracer), scene, rays: None, reason });
            }
        }
    }
    let mut records = Vec::new();
    let mut index = 0;
    for (place, case) in cases.iter().enumerate() {
        if context.takes(place) {
            context.progress.say(&format!("case {}", case.name));
            records.push(measure_case(index, case, candidates, &absent, &mut run, context)?);
        }
        index += case.knob.values.len();
    }
    run.cases = Some(CasesRecord { cases: records });
    Ok(run)
}

/// Measures one case: every candidate at every strength. `index` is the first strength's place in the plan.
fn measure_case(
    index: usize,
    case: &Case,
    candidates: &[Candidate],
    absent: &[bool],
    run: &mut Run,
    context: &Context<'_>,
) -> Result<CaseRecord, RunError> {
    let machine = &run.provenance.machine;
    let (kind, rasterizer) = (expected::kind_of(machine), machine.rasterizer.as_ref());
    let mut tracers: Vec<CaseTracer> = candidates
        .iter()
        .zip(absent)
        .map(|(candidate, absent)| CaseTracer {
            tracer: records::request_record(&candidate.request),
            expectation: candidate.record(case, kind, rasterizer),
            unavailable: *absent,
            no_answers: Vec::new(),
        })
        .collect();
    let running: Vec<usize> = (0..candidates.len()).filter(|place| !absent[*place]).collect();
    let requests: Vec<Request> = running.iter().map(|place| Request::of(&candidates[*place].request)).collect();
    let (mut strengths, mut void) = (Vec::new(), None);
    for (turn, &strength) in case.knob.values.iter().enumerate() {
        let gpu = context.device.as_ref().ok();
        let prepare = || placed(case, strength, gpu);
        let effort = Effort { validated: false, lenient: true, ..Effort::untimed() };
        let place = Place {
            index: index + turn,
            scene_sha256: None,
            prepare: &prepare,
            requests: &requests,
            effort,
            hook: None,
        };
        let mut found = measure::measure(&place, context)?;
        let told = std::mem::take(&mut found.told);
        strengths.push(serde_json::from_value::<Strength>(told).map_err(|error| RunError::Nothing(error.to_string()))?);
        if let Some(reason) = found.void.take() {
            void.get_or_insert_with(|| format!("at {strength}: {reason}"));
        }
        for (request, (_, refusal)) in measure::add(run, found) {
            let Refusal { reason: error, too_large: refused, unavailable, .. } = refusal;
            tracers[running[request]].no_answers.push(NoAnswer { strength, error, refused, unavailable });
        }
    }
    Ok(CaseRecord {
        name: case.name.to_owned(),
        summary: case.summary.to_owned(),
        knob: KnobRecord {
            name: case.knob.name.to_owned(),
            unit: case.knob.unit.to_owned(),
            values: case.knob.values.to_vec(),
        },
        feature: case.feature.what.to_owned(),
        least_featured: case.feature.least,
        strengths,
        void,
        tracers,
    })
}

/// A case at one strength, ready to be measured.
fn placed(case: &Case, strength: f64, gpu: Option<&Arc<Gpu>>) -> Result<Placed, RunError> {
    let setup = (case.make)(strength)?;
    let session = prepare(case, &setup, gpu)?;
    let told = describe(case, strength, &setup, &session);
    let Geometry { positions, triangles, .. } = &setup.geometry;
    let parts = [hash::sha256_of(positions), hash::sha256_of(triangles)].concat();
    let scene = SceneRecord {
        name: case.name.to_owned(),
        sha256: hash::sha256_of(parts.as_bytes()),
        triangles: triangles.len() as u64,
        diagonal: session.truth().diagonal(),
        scale: None,
        zero_area_triangles_dropped: 0,
        duplicate_triangles_kept: 0,
        warnings: Vec::new(),
    };
    let rays = [setup.rays.len() as u32, 1];
    let viewpoint = records::viewpoint_of("given", &setup.viewpoint, rays, 0.0);
    let told = serde_json::to_value(told).map_err(|error| RunError::Nothing(error.to_string()))?;
    Ok(Placed { scene, viewpoint, strength: Some(strength), session, film: None, told })
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
    let TrueCounts { hits: true_hits, misses: true_misses, .. } = true_counts(&rays.answers);
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
