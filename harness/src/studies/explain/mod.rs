//! Why a method's rays are wrong, shown by taking its known weaknesses away, one after the other, until none is left: what
//! is right from a step of this remedy sequence on was wrong for the weakness that the step took away. A method that samples has one
//! that no parameter takes away, as nothing is fine enough for the strictest rule: of what is wrong on the last step of such
//! a one, the judge tells the causes.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde_json::Value;
use tracebench_api::{Status, TracerError};

use crate::judge::{Class, Rule};
use crate::measure::session::{PreparedRays, Session};
use crate::measure::{self, Context, MeasureOptions, Observations, RunError, records};
use crate::plan::{Plan, TracerRequest};
use crate::results::{Explained, ExplanationRecord, GIVEN_UP, Record, RemedyRecord, SceneExplained, UNEXPLAINED};

/// The cause of a ray's error from whether it was wrong on each step: the remedy after the last step on which it was; [`UNEXPLAINED`] if no
/// step takes it away, and none for a ray that is right as the tracer was asked for and stays so. `given_up`: its search was, on the last
/// step.
fn cause<'a>(remedies: &'a [RemedyRecord], wrong: &[bool], given_up: bool) -> Option<&'a str> {
    let last = wrong.iter().rposition(|wrong| *wrong)?;
    let left = if given_up { GIVEN_UP } else { UNEXPLAINED };
    Some(remedies.get(last).map_or(left, |remedy| remedy.cause.as_str()))
}

/// Explains every wrong ray of the plan's tracer.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn execute(
    plan: &Plan,
    request: &TracerRequest,
    remedies: &[RemedyRecord],
    context: &Context<'_>,
) -> Result<Record, RunError> {
    let fail = |error: TracerError| RunError::Tracer(request.name().to_owned(), error);
    let steps = steps(request, remedies).map_err(fail)?;
    let judged = !request.registration.is_analytic();
    // A step that changes nothing, as one of six views does where there are six, is what the one before was.
    let mut places: Vec<usize> = Vec::new();
    let mut requests: Vec<TracerRequest> = Vec::new();
    for step in &steps {
        if requests.last().is_none_or(|last| last.parameters != step.parameters) {
            requests.push(step.clone());
        }
        places.push(requests.len() - 1);
    }
    let mut record = measure::begin(std::slice::from_ref(plan), context);
    let mut scenes = Vec::new();
    for (index, scene) in measure::load(plan, context.progress)?.into_iter().enumerate() {
        if !context.takes(index) {
            continue;
        }
        let hook = |session: &Session, rays: &PreparedRays, told: &[Option<Observations>]| {
            // A step that cannot be measured here changes nothing; why it cannot is told below.
            let mut steps: Vec<&Observations> = Vec::new();
            for place in &places {
                match told.get(*place).and_then(Option::as_ref).or(steps.last().copied()) {
                    Some(told) => steps.push(told),
                    None => return Ok(Value::Null),
                }
            }
            measure::told(&explained(session, request.name(), (remedies, judged), rays, &steps)?)
        };
        let options = MeasureOptions { validated: false, counted: false, ..MeasureOptions::untimed() };
        let mut found = measure::measure_scene(index, plan, scene, &requests, options, Some(&hook), context)?;
        let mut left_out = BTreeMap::new();
        for (place, row) in found.rows.iter().enumerate() {
            match (row, place.checked_sub(1).and_then(|_| places.iter().position(|of| *of == place))) {
                (Ok(_), _) => {}
                // What a larger device holds.
                (Err(refusal), Some(step)) if refusal.too_large => {
                    let RemedyRecord { parameter, value, .. } = &remedies[step - 1];
                    left_out.insert(format!("{parameter}={value}"), refusal.reason.clone());
                }
                (Err(refusal), _) => {
                    let tracer = records::request_record(&requests[place]).label();
                    return Err(RunError::Tracer(tracer, TracerError::Failed(refusal.reason.clone())));
                }
            }
        }
        // Of rays that the tracer does not serve there is nothing to explain.
        let sets = found.take_hooked()?;
        scenes.push(SceneExplained { scene: found.scene.clone(), viewpoint: found.viewpoint.clone(), left_out, sets });
        measure::add(&mut record, found);
    }
    let remedies = remedies.to_vec();
    record.explanation = Some(ExplanationRecord { tracer: records::request_record(request), remedies, judged, scenes });
    Ok(record)
}

/// The tracer on every step, first as asked for.
fn steps(request: &TracerRequest, remedies: &[RemedyRecord]) -> Result<Vec<TracerRequest>, TracerError> {
    // Who cannot be measured is told by the step.
    let mut request = TracerRequest { required: false, ..request.clone() };
    let mut steps = vec![request.clone()];
    for remedy in remedies {
        request
            .set(&remedy.parameter, &remedy.value)
            .map_err(|error| TracerError::Failed(format!("{}: {error}", remedy.cause)))?;
        steps.push(request.clone());
    }
    Ok(steps)
}

/// Counts what is wrong under `tight` on every step. `judged`: of rays that no step explains the judge tells the causes.
fn explained(
    session: &Session,
    tracer: &str,
    (remedies, judged): (&[RemedyRecord], bool),
    rays: &PreparedRays,
    steps: &[&Observations],
) -> Result<Explained, RunError> {
    let classes = |told: &&Observations| session.classes(tracer, rays, Rule::Tight, &told.hits);
    let classes = steps.iter().map(classes).collect::<Result<Vec<_>, _>>()?;
    let is_wrong = |class: &Option<Class>| class.is_some_and(|class| !class.is_right());
    let (first, last) = (&classes[0], steps[steps.len() - 1]);
    let mut causes: BTreeMap<String, BTreeMap<String, u64>> = BTreeMap::new();
    let (mut on_the_way, mut unexplained) = (0, 0);
    // By whether they were wrong at first, then class.
    let mut left: BTreeMap<(bool, Class), Vec<usize>> = BTreeMap::new();
    for (ray, class) in first.iter().enumerate() {
        let wrong: Vec<bool> = classes.iter().map(|step| is_wrong(&step[ray])).collect();
        let given_up = last.hits[ray].status == Status::StepCap as u32;
        let Some(cause) = cause(remedies, &wrong, given_up) else { continue };
        let class = class.unwrap_or(Class::TrueMiss);
        on_the_way += u64::from(!wrong[0]);
        if cause == UNEXPLAINED {
            left.entry((wrong[0], class)).or_default().push(ray);
        } else if wrong[0] {
            let class = class.name(rays.set.query).to_owned();
            *causes.entry(class).or_default().entry(cause.to_owned()).or_default() += 1;
        }
    }
    for ((at_first, class), of) in left {
        let told = match judged {
            true => session.causes(tracer, rays, Rule::Tight, last, &of)?,
            false => [(UNEXPLAINED.to_owned(), of.len() as u64)].into(),
        };
        unexplained += told.get(UNEXPLAINED).copied().unwrap_or(0);
        if at_first {
            causes.entry(class.name(rays.set.query).to_owned()).or_default().extend(told);
        }
    }
    let count_wrong = |step: &Vec<Option<Class>>| step.iter().filter(|class| is_wrong(class)).count() as u64;
    Ok(Explained {
        rays: rays.set.name.to_owned(),
        rays_sha256: rays.sha256.clone(),
        query: rays.set.query,
        count: first.len() as u64,
        ambiguous_rays: rays.answers.iter().filter(|answer| answer.is_ambiguous()).count() as u64,
        wrong_by_remedy: classes.iter().map(count_wrong).collect(),
        wrong_on_the_way: on_the_way,
        unexplained,
        causes,
    })
}
