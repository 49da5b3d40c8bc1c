//! Runs cases: every tracer at every difficulty level, judged against the truth and against what is expected of it.

mod expected;
mod matrix;
mod verdict;

use std::sync::Arc;

use tracebench_api::{Geometry, Gpu, Rasterizer};

use crate::cases::{CASES, Case, Probe, Setup};
use crate::hash;
use crate::judge::true_counts;
use crate::measure::session::{PreparedRays, Session};
use crate::measure::{
    self, Context, MeasureOptions, Observations, PreparedWorkload, Refusal, RunError, Workload, records,
};
use crate::plan::TracerRequest;
use crate::rays::RaySet;
use crate::registrations::Expectation;
use crate::results::{
    CaseRecord, CaseTracer, CasesRecord, DifficultyLevel, ExpectationRecord, NoAnswer, Record, SceneRecord, Skipped,
    TrueCounts,
};
use crate::truth::{Answer, Truth};

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
        let expected_of = |case: &Case| request.registration.expected_of(request.preset, case.name);
        let expected_on = |case: &Case| Some((case.name, expected_of(case)?.clone()));
        let expected = CASES.iter().filter_map(expected_on).collect();
        let column = request.registration.column(request.preset);
        Self { request: request.clone(), expected, column, shares: Arc::clone(shares) }
    }

    /// What is expected on a case, on an adapter of a kind with such a rasterizer.
    pub fn record(&self, case: &Case, kind: &str, rasterizer: Option<&Rasterizer>) -> Option<ExpectationRecord> {
        let (_, expected) = self.expected.iter().find(|(name, _)| *name == case.name)?;
        let record = expected.record(case.name, &case.difficulty_parameter.values, rasterizer);
        if !record.kind.has_shares() {
            return Some(record);
        }
        let wrong_shares = self.shares.of(&self.column, case.name, kind, &case.difficulty_parameter.values);
        Some(ExpectationRecord { wrong_shares, ..record })
    }
}

/// Runs cases with the tracers that were asked for.
///
/// # Errors
/// [`RunError`] if a tracer that was asked for by name cannot run, none can, or the device fails.
pub fn run(cases: &[&Case], requests: &[TracerRequest], context: &Context<'_>) -> Result<Record, RunError> {
    let shares = ExpectedShares::stated().map_err(|error| RunError::Nothing(error.to_string()))?;
    let shares = Arc::new(shares);
    let candidates: Vec<Candidate> = requests.iter().map(|request| Candidate::of(request, &shares)).collect();
    let record = measure(cases, &candidates, context)?;
    if record.skipped.len() == candidates.len() {
        return Err(measure::nothing(&record));
    }
    Ok(record)
}

/// Runs cases with candidates. What a tracer or a control does wrong is in the record.
///
/// # Errors
/// [`RunError`] if a tracer that was asked for by name cannot run, a case cannot be made, or the device fails.
pub fn measure(cases: &[&Case], candidates: &[Candidate], context: &Context<'_>) -> Result<Record, RunError> {
    let mut record = measure::empty(candidates.iter().map(|candidate| &candidate.request), context);
    let mut absent = vec![false; candidates.len()];
    for (candidate, absent) in candidates.iter().zip(&mut absent) {
        let tracer = candidate.request.name().to_owned();
        let Err(error) = context.config(&candidate.request) else { continue };
        if candidate.request.required {
            return Err(RunError::Tracer(tracer, error));
        }
        *absent = true;
        context.progress.say(&format!("skipped {tracer}: {error}"));
        let (scene, reason) = ("cases".to_owned(), error.to_string());
        record.skipped.push(Skipped { tracer: Some(tracer), scene, rays: None, reason });
    }
    let mut records = Vec::new();
    let mut index = 0;
    for (place, case) in cases.iter().enumerate() {
        if context.takes(place) {
            context.progress.say(&format!("case {}", case.name));
            records.push(measure_case(index, case, candidates, &absent, &mut record, context)?);
        }
        index += case.difficulty_parameter.values.len();
    }
    record.cases = Some(CasesRecord { cases: records });
    Ok(record)
}

/// Measures one case: every candidate at every difficulty level. `index` is the first difficulty level's place in the plan.
fn measure_case(
    index: usize,
    case: &Case,
    candidates: &[Candidate],
    absent: &[bool],
    record: &mut Record,
    context: &Context<'_>,
) -> Result<CaseRecord, RunError> {
    let machine = &record.provenance.machine;
    let (kind, rasterizer) = (expected::kind_of(machine), machine.rasterizer.as_ref());
    let tracer = |(candidate, absent): (&Candidate, &bool)| {
        let expectation = candidate.record(case, kind, rasterizer);
        let tracer = records::request_record(&candidate.request);
        CaseTracer { tracer, expectation, unavailable: *absent, no_answers: Vec::new() }
    };
    let mut tracers: Vec<CaseTracer> = candidates.iter().zip(absent).map(tracer).collect();
    let running: Vec<usize> = (0..candidates.len()).filter(|place| !absent[*place]).collect();
    let requests: Vec<TracerRequest> = running.iter().map(|place| candidates[*place].request.clone()).collect();
    let (mut difficulty_levels, mut invalid) = (Vec::new(), None);
    for (turn, &difficulty_level) in case.difficulty_parameter.values.iter().enumerate() {
        let gpu = context.device.as_ref().ok();
        let hook = |session: &Session, rays: &PreparedRays, _: &[Option<Observations>]| {
            measure::told(&describe(case, difficulty_level, &session.truth, &rays.answers))
        };
        let place = Workload {
            index: index + turn,
            scene_sha256: None,
            prepare: Box::new(|| placed(case, difficulty_level, gpu)),
            requests: &requests,
            options: MeasureOptions { validated: false, lenient: true, ..MeasureOptions::untimed() },
            hook: Some(&hook),
        };
        let mut found = measure::measure(place, context)?;
        difficulty_levels.extend(found.take_hooked::<DifficultyLevel>()?);
        if let Some(reason) = found.invalid.take() {
            invalid.get_or_insert_with(|| format!("at {difficulty_level}: {reason}"));
        }
        for (request, refusal) in measure::add(record, found) {
            let Refusal { reason: error, too_large: refused, unavailable, unserved, .. } = refusal;
            let no_answer = NoAnswer { difficulty_level, error, refused, unavailable, unserved };
            tracers[running[request]].no_answers.push(no_answer);
        }
    }
    Ok(CaseRecord {
        name: case.name.to_owned(),
        summary: case.summary.to_owned(),
        difficulty_parameter: case.difficulty_parameter.clone(),
        feature: case.feature.to_owned(),
        min_featured: case.min_featured,
        difficulty_levels,
        invalid,
        tracers,
    })
}

/// A case at one difficulty level, ready to be measured.
fn placed(case: &Case, difficulty_level: f64, gpu: Option<&Arc<Gpu>>) -> Result<PreparedWorkload, RunError> {
    let setup = case.setup(difficulty_level);
    let session = prepare(case, &setup, gpu)?;
    let Geometry { positions, triangles, .. } = &setup.geometry;
    let parts = [hash::sha256_of(positions), hash::sha256_of(triangles)].concat();
    let scene = SceneRecord {
        name: case.name.to_owned(),
        sha256: hash::sha256_of(parts.as_bytes()),
        triangles: triangles.len() as u64,
        diagonal: session.truth.diagonal(),
        ..SceneRecord::default()
    };
    let rays = [setup.rays.len() as u32, 1];
    let viewpoint = records::viewpoint_of("given", &setup.viewpoint, rays, 0.0);
    Ok(PreparedWorkload { scene, viewpoint, difficulty_level: Some(difficulty_level), session })
}

/// A case at one difficulty level with its truth, on the device as well if there is one.
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

/// What the truth says of a case at one difficulty level.
fn describe(case: &Case, difficulty_level: f64, truth: &Truth, answers: &[Answer]) -> DifficultyLevel {
    let setup = case.setup(difficulty_level);
    let TrueCounts { hits: true_hits, misses: true_misses, .. } = true_counts(answers);
    let probe = Probe { setup: &setup, truth, answers };
    let featured = (0..setup.rays.len()).filter(|index| case.shows(&probe, *index)).count();
    let count = setup.rays.len() as u64;
    DifficultyLevel {
        difficulty_level,
        triangles: setup.geometry.triangles.len() as u64,
        query: setup.query,
        frame: setup.viewpoint.frame,
        rays: count,
        true_hits,
        true_misses,
        ambiguous_rays: count - true_hits - true_misses,
        featured: featured as f64 / count.max(1) as f64,
    }
}
