//! Interleaved sets of a configuration against itself: beside one that is the same, and one that does more of the same work.

use super::controls::Control;
use super::interleaved_set::{InterleavedSet, Outcome, Setting};
use super::run::{Context, placed};
use super::workload::{MeasureOptions, Request};
use super::{RunError, load, records};
use crate::plan::Plan;
use crate::results::InterleavedSetRecord;

/// One interleaved set.
pub(crate) struct Trial {
    /// The samples of every one who took part, milliseconds.
    pub samples_ms: Vec<Vec<f64>>,
    /// Why they are invalid.
    pub invalid: Option<String>,
    pub interleaved_set: InterleavedSetRecord,
}

/// Interleaved sets the plan's first tracer on its first ray set in its first scene so many times against itself: `repeats` says how often
/// each one who takes part traces in a sample.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(crate) fn against_itself(
    plan: &Plan,
    repeats: &[usize],
    interleaved_sets: usize,
    context: &Context<'_>,
) -> Result<Vec<Trial>, RunError> {
    let nothing = |what: &str| RunError::Nothing(what.to_owned());
    let request = plan.tracers.first().map(Request::of).ok_or_else(|| nothing("no tracer was asked for"))?;
    let scene = load(plan, context.progress)?.into_iter().next().ok_or_else(|| nothing("no scene was asked for"))?;
    let placed = placed(plan, scene, context)?;
    let rays = placed.session.rays.first().ok_or_else(|| nothing("the ray set is empty here"))?;
    let setting = Setting {
        scene: placed.scene.name.clone(),
        viewpoint: placed.viewpoint.name.clone(),
        resident_batch: 0,
        kernels: Some(context.kernels()?),
        turn: 0,
    };
    let mut interleaved_set =
        InterleavedSet::new(&placed.session, None, MeasureOptions::timed(plan), context.progress, setting);
    let created = context.tracer_cache.borrow_mut().config(&request.tracer, context.device);
    let tracer = request.tracer.name().to_owned();
    interleaved_set.enter(created.map_err(|error| RunError::Tracer(tracer.clone(), error))?, Some(&request), None);
    for _ in repeats.iter().skip(1) {
        interleaved_set.join(Some(&request.tracer), None);
    }
    for (participant, repeats) in interleaved_set.participants.iter_mut().skip(Control::ALL.len()).zip(repeats) {
        participant.repeats = *repeats;
    }
    interleaved_set.restore()?;
    let mut trials = Vec::new();
    for turn in 0..interleaved_sets {
        interleaved_set.setting.turn = turn;
        let answered = interleaved_set.trace(rays)?;
        if let Some(what) = answered.invalid {
            return Err(RunError::Control(what));
        }
        let mut traces = Vec::new();
        for outcome in answered.outcomes.into_iter().skip(Control::ALL.len()) {
            match outcome {
                Outcome::Measured(trace) => traces.push(trace),
                Outcome::Out(refusal) | Outcome::Unserved(refusal) => {
                    return Err(RunError::Nothing(format!("{tracer}: {}", refusal.reason)));
                }
                Outcome::Absent => return Err(nothing("the tracer was taken out")),
            }
        }
        let (Some(first), Some(record)) = (traces.first(), answered.interleaved_set) else {
            return Err(nothing("nothing was timed"));
        };
        context.progress.say(&format!(
            "  interleaved set {} of {interleaved_sets}: {} rounds",
            turn + 1,
            record.orders.len()
        ));
        trials.push(Trial {
            invalid: first.times.invalid.clone(),
            samples_ms: traces.iter().map(|trace| trace.times.samples_ms.clone()).collect(),
            interleaved_set: record,
        });
    }
    Ok(trials)
}

/// The plan's first tracer on rays of so many seeds in turn: in every round fresh ones, which were not traced for as many rounds as there
/// are seeds, then at once the same again. Times of both by round, milliseconds.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(crate) fn fresh_and_repeated(plan: &Plan, seeds: u64, context: &Context<'_>) -> Result<[Vec<f64>; 2], RunError> {
    let nothing = |what: &str| RunError::Nothing(what.to_owned());
    let request = plan.tracers.first().ok_or_else(|| nothing("no tracer was asked for"))?;
    let mut sets = Vec::new();
    for seed in 0..seeds.max(1) {
        let plan = Plan { seed: plan.seed + seed, ..plan.clone() };
        let scene =
            load(&plan, context.progress)?.into_iter().next().ok_or_else(|| nothing("no scene was asked for"))?;
        sets.push(placed(&plan, scene, context)?.session);
    }
    let hashes: Vec<&str> = sets.iter().flat_map(|session| &session.rays).map(|rays| rays.sha256.as_str()).collect();
    if hashes.len() != sets.len() || hashes.iter().enumerate().any(|(place, hash)| hashes[..place].contains(hash)) {
        return Err(nothing(
            "the ray set is empty here, or has nothing random, so that no seed makes other rays of it",
        ));
    }
    let mut config = context.tracer_cache.borrow_mut().config(request, context.device)?;
    sets[0].sample_build(&mut config)?;
    let rounds = plan.preset.sampling.min_rounds as usize;
    let mut buffers =
        sets.iter().map(|session| session.hit_buffer(&config, &session.rays[0])).collect::<Result<Vec<_>, _>>()?;
    let mut timings = [Vec::new(), Vec::new()];
    for round in 0..sets.len() + rounds {
        let set = round % sets.len();
        let rays = &sets[set].rays[0];
        for samples in &mut timings {
            let timing = sets[set].sample_trace(&config, rays, &mut buffers[set], 1)?;
            // Until all rays were there once, all is new.
            samples.extend(Some(timing).filter(|_| round >= sets.len()));
        }
    }
    let believed = records::are_believed(timings.iter().map(Vec::as_slice));
    Ok(timings.map(|samples| records::times(&samples, believed).samples_ms))
}
