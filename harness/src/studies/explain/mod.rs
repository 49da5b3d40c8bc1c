//! Why a method's rays are wrong, shown by taking its known weaknesses away, one after the other, until none is left: what
//! is right from a rung of this ladder on was wrong for the weakness that the rung took away. A method that samples has one
//! that no parameter takes away, as nothing is fine enough for the strictest rule: of what is wrong on the last rung of such
//! a one, the judge tells the causes.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde_json::Value;
use tracebench_api::{Status, TracerError};

use crate::contenders::Remedy;
use crate::judge::{Class, Rule};
use crate::measure::session::{PreparedRays, Session};
use crate::measure::{self, Context, Effort, Request, RunError, Told, records};
use crate::plan::{Plan, TracerRequest};
use crate::results::{Explained, ExplanationRecord, GIVEN_UP, RemedyRecord, Run, SceneExplained, UNEXPLAINED};

/// Why a ray is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    /// What a rung takes away, or that its search was given up on the last one.
    Known(&'static str),
    /// No rung takes it away.
    Left,
}

/// The cause of a ray's error from whether it was wrong on each rung: the remedy after the last rung on which it was; none
/// for a ray that is right as the tracer was asked for and stays so. `given_up`: its search was, on the last rung.
fn cause(ladder: &[Remedy], wrong: &[bool], given_up: bool) -> Option<Cause> {
    let last = wrong.iter().rposition(|wrong| *wrong)?;
    Some(match ladder.get(last) {
        Some(remedy) => Cause::Known(remedy.cause),
        None if given_up => Cause::Known(GIVEN_UP),
        None => Cause::Left,
    })
}

/// What was found of a ray set, by rung.
struct Found {
    /// Whether each ray is wrong.
    wrong: Vec<Vec<bool>>,
    /// The rays' classes on the first rung.
    classes: Vec<Class>,
    /// Whether each ray's search was given up on the last rung.
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
    context: &Context<'_>,
) -> Result<Run, RunError> {
    let fail = |error: TracerError| RunError::Tracer { tracer: request.name().to_owned(), error };
    let rungs = rungs(request, ladder).map_err(fail)?;
    let judged = request.registration.otherwise.is_none();
    // A rung that changes nothing, as one of six views does where there are six, is what the one before was.
    let mut places: Vec<usize> = Vec::new();
    let mut requests: Vec<Request> = Vec::new();
    for rung in &rungs {
        if requests.last().is_none_or(|last| last.tracer.parameters != rung.parameters) {
            requests.push(Request::of(rung));
        }
        places.push(requests.len() - 1);
    }
    let mut run = measure::begin(std::slice::from_ref(plan), context);
    let mut scenes = Vec::new();
    for (index, scene) in measure::load(plan, context.progress)?.into_iter().enumerate() {
        if !context.takes(index) {
            continue;
        }
        let hook = |session: &Session, rays: &PreparedRays, told: &[Option<Told>]| {
            // A rung that cannot be measured here changes nothing; why it cannot is told below.
            let mut rungs: Vec<&Told> = Vec::new();
            for place in &places {
                match told.get(*place).and_then(Option::as_ref).or(rungs.last().copied()) {
                    Some(told) => rungs.push(told),
                    None => return Ok(Value::Null),
                }
            }
            let found = look(session, request.name(), rays, &rungs)?;
            let judge = |of: &[usize]| match (judged, rungs.last()) {
                (true, Some(last)) => session.causes(request.name(), rays, Rule::Tight, last, of),
                _ => Ok([(UNEXPLAINED.to_owned(), of.len() as u64)].into()),
            };
            Ok(serde_json::to_value(explained(ladder, rays, &found, judge)?).unwrap_or_default())
        };
        let effort = Effort { validated: false, counted: false, ..Effort::untimed() };
        let mut found = measure::measure_scene(index, plan, scene, &requests, effort, Some(&hook), context)?;
        let mut left_out = BTreeMap::new();
        for (place, row) in found.rows.iter().enumerate() {
            match (row, place.checked_sub(1).and_then(|_| places.iter().position(|of| *of == place))) {
                (Ok(_), _) => {}
                // What a larger device holds.
                (Err(refusal), Some(rung)) if refusal.too_large => {
                    let Remedy { parameter, value, .. } = ladder[rung - 1];
                    left_out.insert(format!("{parameter}={value}"), refusal.reason.clone());
                }
                (Err(refusal), _) => {
                    let tracer = records::request_record(&requests[place].tracer).label();
                    return Err(RunError::Tracer { tracer, error: TracerError::Failed(refusal.reason.clone()) });
                }
            }
        }
        let of_set = |told: Value| {
            serde_json::from_value::<Explained>(told).map_err(|error| RunError::Nothing(error.to_string()))
        };
        let sets = std::mem::take(&mut found.hooked).into_iter().map(of_set).collect::<Result<Vec<_>, _>>()?;
        scenes.push(SceneExplained { scene: found.scene.clone(), viewpoint: found.viewpoint.clone(), left_out, sets });
        measure::add(&mut run, found);
    }
    let rung = |remedy: &Remedy| RemedyRecord {
        cause: remedy.cause.to_owned(),
        parameter: remedy.parameter.to_owned(),
        value: remedy.value.to_owned(),
        source: remedy.source.to_owned(),
    };
    let ladder = ladder.iter().map(rung).collect();
    run.explanation = Some(ExplanationRecord { tracer: records::request_record(request), ladder, judged, scenes });
    Ok(run)
}

/// The tracer on every rung, first as asked for.
fn rungs(request: &TracerRequest, ladder: &[Remedy]) -> Result<Vec<TracerRequest>, TracerError> {
    // Who cannot be measured is told by the rung.
    let mut request = TracerRequest { required: false, ..request.clone() };
    let mut rungs = vec![request.clone()];
    for remedy in ladder {
        request
            .set(remedy.parameter, remedy.value)
            .map_err(|error| TracerError::Failed(format!("{}: {error}", remedy.cause)))?;
        rungs.push(request.clone());
    }
    Ok(rungs)
}

/// Notes what is wrong under `tight` on every rung.
fn look(session: &Session, tracer: &str, rays: &PreparedRays, rungs: &[&Told]) -> Result<Found, RunError> {
    let mut found = Found { wrong: Vec::new(), classes: Vec::new(), given_up: Vec::new() };
    for Told { hits, .. } in rungs {
        let classes = session.classes(tracer, rays, Rule::Tight, hits)?;
        found.wrong.push(classes.iter().map(|class| class.is_some_and(|class| !class.is_right())).collect());
        found.given_up = hits.iter().map(|hit| hit.status == Status::StepCap as u32).collect();
        if found.classes.is_empty() {
            found.classes = classes.into_iter().map(|class| class.unwrap_or(Class::TrueMiss)).collect();
        }
    }
    Ok(found)
}

/// Counts what was found; `judge` tells the causes of rays that no rung explains.
fn explained<E>(
    ladder: &[Remedy],
    rays: &PreparedRays,
    found: &Found,
    judge: impl Fn(&[usize]) -> Result<BTreeMap<String, u64>, E>,
) -> Result<Explained, E> {
    let mut causes: BTreeMap<String, BTreeMap<String, u64>> = BTreeMap::new();
    let (mut of_rung, mut on_the_way, mut unexplained) = (vec![0_u64; found.wrong.len()], 0, 0);
    // By whether they were wrong at first, then class.
    let mut left: BTreeMap<(bool, Class), Vec<usize>> = BTreeMap::new();
    for (ray, class) in found.classes.iter().enumerate() {
        let of_ray: Vec<bool> = found.wrong.iter().map(|rung| rung[ray]).collect();
        for (count, wrong) in of_rung.iter_mut().zip(&of_ray) {
            *count += u64::from(*wrong);
        }
        let Some(cause) = cause(ladder, &of_ray, found.given_up[ray]) else { continue };
        on_the_way += u64::from(!of_ray[0]);
        match cause {
            Cause::Left => left.entry((of_ray[0], *class)).or_default().push(ray),
            Cause::Known(cause) if of_ray[0] => {
                let class = class.name(rays.set.query).to_owned();
                *causes.entry(class).or_default().entry(cause.to_owned()).or_default() += 1;
            }
            Cause::Known(_) => {}
        }
    }
    for ((at_first, class), of) in left {
        let judged = judge(&of)?;
        unexplained += judged.get(UNEXPLAINED).copied().unwrap_or(0);
        if at_first {
            causes.entry(class.name(rays.set.query).to_owned()).or_default().extend(judged);
        }
    }
    Ok(Explained {
        rays: rays.set.name.to_owned(),
        rays_sha256: rays.sha256.clone(),
        query: rays.set.query,
        count: found.classes.len() as u64,
        ties: rays.answers.iter().filter(|answer| answer.is_ambiguous()).count() as u64,
        wrong_by_rung: of_rung,
        wrong_on_the_way: on_the_way,
        unexplained,
        causes,
    })
}
