//! Why a method's rays are wrong, shown by taking its known weaknesses away, one after the other, until none is left: what
//! is right from a rung of this ladder on was wrong for the weakness that the rung took away.

mod record;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use tracebench_api::{Hit, Status, TracerError};

pub use record::{Explained, Explanation, RemedyRecord, SCHEMA, SceneExplained};

use crate::contenders::Remedy;
use crate::judge::{Class, Rule};
use crate::plan::{Plan, TracerRequest};
use crate::progress::Progress;
use crate::records;
use crate::registry::Device;
use crate::runner::{self, RunError};
use crate::session::{Contender, PreparedRays, Session};
use crate::truth::Cache;

/// What is wrong on the last rung because its search was given up, as the ray's status says: steps or a driver's limit of
/// loops.
pub const GIVEN_UP: &str = "step_cap";

/// What no rung takes away.
pub const UNEXPLAINED: &str = "unexplained";

/// The cause of a ray's error from whether it was wrong on each rung: the remedy after the last rung on which it was; none
/// for a ray that is right as the tracer was asked for and stays so. `given_up`: its search was, on the last rung.
fn cause(ladder: &[Remedy], wrong: &[bool], given_up: bool) -> Option<&'static str> {
    let last = wrong.iter().rposition(|wrong| *wrong)?;
    let beyond = if given_up { GIVEN_UP } else { UNEXPLAINED };
    Some(ladder.get(last).map_or(beyond, |remedy| remedy.cause))
}

/// What was found of a ray set, on the rungs so far.
#[derive(Default)]
struct Found {
    /// By rung, whether each ray is wrong.
    wrong: Vec<Vec<bool>>,
    /// The rays' classes on the first rung.
    classes: Vec<Class>,
    /// Whether each ray's search was given up on the rung that was last traced.
    given_up: Vec<bool>,
}

/// Explains every wrong ray of the plan's tracer.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn execute(
    plan: &Plan,
    request: &TracerRequest,
    ladder: &[Remedy],
    device: &Device,
    cache: &Cache,
    progress: &Progress,
) -> Result<Explanation, RunError> {
    let fail = |error: TracerError| RunError::Tracer { tracer: request.name().to_owned(), error };
    let rungs = rungs(request, ladder).map_err(fail)?;
    let description = (request.registration.describe)();
    let mut contender =
        Contender::create(description, request.parameters.clone(), || request.registration.create(device))
            .map_err(fail)?;
    let mut found = Explanation::begin(plan, request, ladder, device);
    for scene in runner::load(plan, progress)? {
        let loaded = runner::prepare(plan, scene, device, cache, progress)?;
        let session = &loaded.session;
        found.skipped.extend(session.skipped.iter().cloned());
        check_controls(session)?;
        let mut sets: Vec<Found> = session.rays.iter().map(|_| Found::default()).collect();
        let bar = progress.bar("rungs", (rungs.len() * session.rays.len()) as u64);
        for (rung, parameters) in rungs.iter().enumerate() {
            // A rung that changes nothing, as one of six views does where there are six, is what the one before was.
            let same = rung > 0 && rungs[rung - 1] == *parameters;
            if !same {
                contender.parameters = parameters.clone();
                session.sample_build(&mut contender).map_err(fail)?;
            }
            for (rays, found) in session.rays.iter().zip(&mut sets) {
                match found.wrong.last().filter(|_| same).cloned() {
                    Some(before) => found.wrong.push(before),
                    None => trace(session, &contender, rays, found)?,
                }
                bar.inc(1);
            }
        }
        bar.finish_and_clear();
        found.scenes.push(SceneExplained {
            scene: loaded.record.clone(),
            viewpoint: records::viewpoint_record(plan, &loaded.pose, session),
            sets: session.rays.iter().zip(&sets).map(|(rays, set)| explained(ladder, rays, set)).collect(),
        });
    }
    Ok(found)
}

/// The parameters of every rung, the first as asked for.
fn rungs(request: &TracerRequest, ladder: &[Remedy]) -> Result<Vec<tracebench_api::Parameters>, TracerError> {
    let mut request = request.clone();
    let mut rungs = vec![request.parameters.clone()];
    for remedy in ladder {
        request
            .set(remedy.parameter, remedy.value)
            .map_err(|error| TracerError::Failed(format!("{}: {error}", remedy.cause)))?;
        rungs.push(request.parameters.clone());
    }
    Ok(rungs)
}

/// Traces a ray set on one more rung and notes what is wrong under `tight`; ties never are.
fn trace(session: &Session, contender: &Contender, rays: &PreparedRays, found: &mut Found) -> Result<(), RunError> {
    let fail = |error: TracerError| RunError::Tracer { tracer: contender.description.name.to_owned(), error };
    let mut hits = session.hit_buffer(contender, rays).map_err(fail)?;
    session.sample_trace(contender, rays, &mut hits).map_err(fail)?;
    let hits: Vec<Hit> = hits.read(session.gpu()).map_err(fail)?;
    let classes = session.classes(contender, rays, Rule::Tight, &hits)?;
    found.wrong.push(classes.iter().map(|class| class.is_some_and(|class| !class.is_right())).collect());
    found.given_up = hits.iter().map(|hit| hit.status == Status::StepCap as u32).collect();
    if found.classes.is_empty() {
        found.classes = classes.into_iter().map(|class| class.unwrap_or(Class::TrueMiss)).collect();
    }
    Ok(())
}

/// The controls score what they must with these rays and this truth.
fn check_controls(session: &Session) -> Result<(), RunError> {
    for (control, mut contender) in session.controls() {
        session.sample_build(&mut contender)?;
        for rays in &session.rays {
            let mut hits = session.hit_buffer(&contender, rays)?;
            session.sample_trace(&contender, rays, &mut hits)?;
            let hits = hits.read(session.gpu())?;
            let judgement = session.judge(&contender, rays, &hits)?;
            let (occluded, free) = rays.hits_and_misses();
            control.check(&judgement, occluded, free).map_err(RunError::Control)?;
        }
    }
    Ok(())
}

fn explained(ladder: &[Remedy], rays: &PreparedRays, found: &Found) -> Explained {
    let mut causes: BTreeMap<String, BTreeMap<String, u64>> = BTreeMap::new();
    let (mut of_rung, mut on_the_way, mut unexplained) = (vec![0_u64; found.wrong.len()], 0, 0);
    for (ray, class) in found.classes.iter().enumerate() {
        let of_ray: Vec<bool> = found.wrong.iter().map(|rung| rung[ray]).collect();
        for (count, wrong) in of_rung.iter_mut().zip(&of_ray) {
            *count += u64::from(*wrong);
        }
        let Some(cause) = cause(ladder, &of_ray, found.given_up[ray]) else { continue };
        unexplained += u64::from(cause == UNEXPLAINED);
        if of_ray[0] {
            let class = class.name(rays.set.query).to_owned();
            *causes.entry(class).or_default().entry(cause.to_owned()).or_default() += 1;
        } else {
            on_the_way += 1;
        }
    }
    Explained {
        rays: rays.set.name.to_owned(),
        rays_sha256: rays.sha256.clone(),
        query: rays.set.query,
        count: found.classes.len() as u64,
        ties: rays.answers.iter().filter(|answer| answer.tie).count() as u64,
        wrong_by_rung: of_rung,
        wrong_on_the_way: on_the_way,
        unexplained,
        causes,
    }
}
