//! The need curve: how far structures may shrink before answers get worse.
//!
//! Of every tracer the structure is measured as asked for, beside others that have less of one thing: of resolution, layers, buckets, a
//! grid. All answer the same rays, so that every ray is its own control: what counts are rays that the first answers rightly and the
//! smaller one wrongly, less those that it is the other way round with. Then all axes at once as far as each may shrink alone. All of
//! that from the scene's viewpoint and from another one. What is needed follows from it.

mod curves;
mod rules;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use itertools::Itertools as _;

pub use curves::{Axis, Curve, Step, curves};
pub use rules::{OfTracer, Outcome, Thumb, Tried, rules};

use crate::judge::Rule;
use crate::measure::session::{PreparedRays, Session};
use crate::measure::{self, Context, MAX_RESIDENT, MeasureOptions, Measured, Observations, RunError, records};
use crate::plan::{Plan, Resolution, RunPreset, TracerRequest, ViewRequest};
use crate::registrations::Shrink;
use crate::results::{ChangedRays, NeedCurve, NeedPoint, NeedRecord, Record, Skipped};
use crate::studies::sweep::{RESOLUTION, with_values};

/// A structure is too small when the upper end of the interval of newly wrong less newly right rays is beyond this share.
pub const MAX_LOST_SHARE: f64 = 0.001;

/// By the second measure also when its traces take more times as long.
pub const MAX_SLOWDOWN: f64 = 1.25;

/// Places of a tracer in a scene: two viewpoints, and of each the single steps and then several at once.
const PLACES: usize = 4;

/// A structure that is to be measured.
#[derive(Clone)]
pub struct Shrunk {
    /// What is smaller than of the tracer as it was asked for, by axis.
    pub values: BTreeMap<String, String>,
    /// The tracer with that.
    pub request: TracerRequest,
}

/// The values of an axis that are smaller than the tracer's own, from the largest on; all where that cannot be told, since the own one
/// is worked out by the tracer itself.
fn smaller(request: &TracerRequest, shrink: &Shrink) -> Vec<&'static str> {
    if shrink.axis == RESOLUTION {
        return shrink.steps.to_vec();
    }
    let Some(own) = request.parameters.value(shrink.axis).map(ToString::to_string) else { return Vec::new() };
    if let Some(place) = shrink.steps.iter().position(|step| *step == own) {
        return shrink.steps[place + 1..].to_vec();
    }
    let number = |text: &str| text.parse::<f64>().ok();
    let numbers: Option<Vec<f64>> = shrink.steps.iter().map(|step| number(step)).collect();
    match (number(&own).filter(|own| *own > 0.0), numbers.as_deref()) {
        (Some(own), Some([first, .., last])) => {
            let falling = first > last;
            let less = |step: &&&str| number(step).is_some_and(|step| if falling { step < own } else { step > own });
            shrink.steps.iter().filter(less).copied().collect()
        }
        _ => shrink.steps.to_vec(),
    }
}

/// A tracer with less of something; `None` where it does not take a value, or edges would be no whole pixels.
fn shrunk(request: &TracerRequest, preset: RunPreset, values: BTreeMap<String, String>) -> Option<Shrunk> {
    let (request, _) = with_values(request, preset, &values).ok()?;
    Some(Shrunk { values, request })
}

/// The tracer as it was asked for, then every step of every axis. All are there at a time, so that every ray is answered by all.
pub fn steps(request: &TracerRequest, preset: RunPreset) -> Vec<Shrunk> {
    let single = |shrink: &Shrink, value: &str| {
        shrunk(request, preset, BTreeMap::from([(shrink.axis.to_owned(), value.to_owned())]))
    };
    let mut all: Vec<Shrunk> = shrunk(request, preset, BTreeMap::new()).into_iter().collect();
    let matters = |shrink: &&Shrink| request.registration.can_matter(shrink.axis, &request.parameters);
    for shrink in request.registration.shrinks.iter().filter(matters) {
        all.extend(smaller(request, shrink).into_iter().filter_map(|value| single(shrink, value)));
    }
    all.truncate(MAX_RESIDENT);
    all
}

/// By which rule closest hits of a tracer are right: by the one that its kind can meet.
pub fn rule_of(request: &TracerRequest) -> Rule {
    if request.registration.is_analytic() { Rule::Tight } else { Rule::Footprint }
}

/// What smaller structures do to the answers of the first, by request; `None` where one gave none.
fn changes(
    session: &Session,
    request: &TracerRequest,
    rays: &PreparedRays,
    told: &[Option<Observations>],
) -> Result<Vec<Option<ChangedRays>>, RunError> {
    let right = |Observations { hits, .. }: &Observations| -> Result<Vec<Option<bool>>, RunError> {
        let classes = session.classes(request.name(), rays, rule_of(request), hits)?;
        Ok(classes.into_iter().map(|class| class.map(|class| class.is_right())).collect())
    };
    let all = told.iter().map(|told| told.as_ref().map(right).transpose()).collect::<Result<Vec<_>, _>>()?;
    let Some(Some(first)) = all.first() else { return Ok(vec![None; told.len()]) };
    Ok(all.iter().map(|own| own.as_ref().map(|own| changed(first, own))).collect())
}

/// Counts rays by whether both were right; `None` for ambiguous any-hit rays, of which either answer is.
fn changed(first: &[Option<bool>], own: &[Option<bool>]) -> ChangedRays {
    let mut counts = ChangedRays::default();
    for (was, is) in first.iter().zip(own) {
        if let (Some(was), Some(is)) = (was, is) {
            counts.rays += 1;
            counts.newly_wrong += u64::from(*was && !*is);
            counts.newly_right += u64::from(!*was && *is);
        }
    }
    counts
}

/// Measures every tracer of a plan in every scene; what could not be is skipped with the reason.
///
/// # Errors
/// As [`measure::execute_all`].
pub fn execute(plan: &Plan, context: &Context<'_>) -> Result<Record, RunError> {
    // What is wrong with the last scene is said before the first is measured.
    drop(measure::load(plan, context.progress)?);
    context.check_rays(plan)?;
    let mut record = measure::begin(std::slice::from_ref(plan), context);
    let mut section = NeedRecord { max_lost_share: MAX_LOST_SHARE, max_slowdown: MAX_SLOWDOWN, curves: Vec::new() };
    for (index, source) in plan.scenes.iter().enumerate().filter(|(index, _)| context.takes(*index)) {
        let own = plan.view.clone();
        for (view, wanted) in [own.clone(), ViewRequest::Other(Box::new(own))].into_iter().enumerate() {
            let here = Plan { scenes: vec![source.clone()], view: wanted, ..plan.clone() };
            for (place, request) in plan.tracers.iter().enumerate() {
                let index = PLACES * (index * plan.tracers.len() + place) + 2 * view;
                match curve(index, &here, view as u32, (request, &section), &mut record, context) {
                    Ok(curve) => section.curves.push(curve),
                    Err(error @ RunError::NoOtherView(..)) => {
                        let (scene, reason) = (source.to_string(), error.to_string());
                        let known = Skipped { tracer: None, scene, rays: None, reason };
                        if !record.skipped.contains(&known) {
                            record.skipped.push(known);
                        }
                    }
                    Err(error) => return Err(error),
                }
            }
        }
    }
    let points = section.curves.iter().flat_map(|curve| curve.points.iter().map(move |point| (curve, point)));
    record.skipped.extend(points.filter_map(|(curve, point)| {
        let tracer = Some(format!("{} {}", curve.tracer, point.label()).trim_end().to_owned());
        Some(Skipped { tracer, scene: curve.scene.clone(), rays: None, reason: point.skipped.clone()? })
    }));
    record.need = Some(section);
    measure::filled(record, context)
}

/// One tracer in one scene from one viewpoint.
fn curve(
    index: usize,
    plan: &Plan,
    view: u32,
    (request, section): (&TracerRequest, &NeedRecord),
    record: &mut Record,
    context: &Context<'_>,
) -> Result<NeedCurve, RunError> {
    let singles = steps(request, plan.preset);
    context.progress.say(&format!("{}: {} structures", request.name(), singles.len()));
    let (found, points) = place(index, plan, request, &singles, context)?;
    let mut curve = NeedCurve {
        scene: found.scene.name.clone(),
        scene_sha256: found.scene.sha256.clone(),
        viewpoint: found.viewpoint.name.clone(),
        view,
        tracer: request.name().to_owned(),
        preset: request.preset.name().to_owned(),
        rule: rule_of(request),
        points,
    };
    measure::add(record, found);
    // As far as each axis may shrink alone, all at once: by ray set, and by both measures.
    let together = joint(record, section, &curve);
    // What was found together elsewhere is tried here as well.
    let is_own = |curve: &&NeedCurve| curve.tracer == request.name() && curve.preset == request.preset.name();
    let elsewhere = section.curves.iter().filter(is_own).flat_map(|curve| &curve.points);
    let elsewhere = elsewhere.map(|point| point.shrunk.clone()).filter(|shrunk| shrunk.len() > 1);
    let together = together.into_iter().chain(elsewhere).unique();
    let mut joints: Vec<Shrunk> = singles.first().cloned().into_iter().collect();
    joints.extend(together.filter_map(|values| shrunk(request, plan.preset, values)));
    joints.truncate(MAX_RESIDENT);
    if joints.len() > 1 {
        let (found, points) = place(index + 1, plan, request, &joints, context)?;
        curve.points.extend(points.into_iter().skip(1));
        measure::add(record, found);
    }
    Ok(curve)
}

/// What several axes have at once, each as far as it may shrink alone; only where that is more than one.
fn joint(record: &Record, section: &NeedRecord, curve: &NeedCurve) -> Vec<BTreeMap<String, String>> {
    let aligned = record.aligned();
    let told = curves::of_record(&aligned, section, curve);
    let needs = told.iter().cartesian_product([false, true]).map(|(told, in_time)| -> BTreeMap<String, String> {
        let smallest = |axis: &Axis<'_>| Some((axis.name.to_owned(), axis.need(in_time)[0]?.to_owned()));
        told.axes.iter().filter_map(smallest).collect()
    });
    needs.filter(|needs| needs.len() > 1).unique().collect()
}

/// Some structures in a plan's only scene, with what became of the rays.
fn place(
    index: usize,
    plan: &Plan,
    request: &TracerRequest,
    structures: &[Shrunk],
    context: &Context<'_>,
) -> Result<(Measured, Vec<NeedPoint>), RunError> {
    let requests: Vec<TracerRequest> = structures.iter().map(|each| each.request.clone()).collect();
    let hook = |session: &Session, rays: &PreparedRays, told: &[Option<Observations>]| {
        measure::told(&(rays.set.name, changes(session, request, rays, told)?))
    };
    let options = MeasureOptions { builds_timed: false, ..MeasureOptions::timed(plan) };
    let mut found = measure::measure_plan(index, plan, &requests, options, Some(&hook), context)?;
    let sets: Vec<(String, Vec<Option<ChangedRays>>)> = found.take_hooked()?;
    let point = |(place, each): (usize, &Shrunk)| {
        let Shrunk { values, request } = each;
        let (shrunk, parameters) = (values.clone(), records::json_values(&request.parameters));
        let Resolution { frame, face } =
            request.resolution.unwrap_or(Resolution { frame: plan.preset.frame, face: plan.preset.face });
        let of = |(rays, all): &(String, Vec<Option<ChangedRays>>)| Some((rays.clone(), (*all.get(place)?)?));
        let changed: BTreeMap<String, ChangedRays> = sets.iter().filter_map(of).collect();
        let skipped = found.rows.get(place).and_then(|row| row.as_ref().err()).map(|refusal| refusal.reason.clone());
        NeedPoint { shrunk, parameters, frame, face, skipped, changed }
    };
    let points = structures.iter().enumerate().map(point).collect();
    Ok((found, points))
}
