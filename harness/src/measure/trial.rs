//! Interleaved sets of a configuration against itself: beside one that is the same, and one that does more of the same work.

use itertools::Itertools as _;

use super::controls::Control;
use super::interleaved_set::{InterleavedSet, Setting};
use super::run::{Context, placed};
use super::tracing::Answered;
use super::workload::{MeasureOptions, PreparedWorkload};
use super::{RunError, load, records};
use crate::plan::{Plan, TracerRequest};
use crate::results::{InterleavedSetRecord, TraceRecord};

/// One interleaved set.
pub(crate) struct Trial {
    /// Of every one who took part.
    pub traces: Vec<TraceRecord>,
    pub interleaved_set: InterleavedSetRecord,
}

/// Measures the plan's first tracer on its first ray set in its first scene in so many interleaved sets against itself: `repeats` says how
/// often each one who takes part traces in a sample.
pub(crate) fn against_itself(
    plan: &Plan,
    repeats: &[usize],
    interleaved_sets: usize,
    context: &Context<'_>,
) -> Result<Vec<Trial>, RunError> {
    let (request, placed) = first(plan, context)?;
    let rays = placed.session.rays.first().ok_or_else(|| nothing("the ray set is empty here"))?;
    let (scene, viewpoint) = (placed.scene.name.clone(), placed.viewpoint.name.clone());
    let setting = Setting { scene, viewpoint, resident_batch: 0, kernels: Some(context.kernels()?), turn: 0 };
    let mut interleaved_set =
        InterleavedSet::new(&placed.session, MeasureOptions::timed(plan), context.progress, setting);
    let failed = |error| RunError::Tracer(request.name().to_owned(), error);
    interleaved_set.enter(context.config(request).map_err(failed)?, Some(request), None);
    for _ in repeats.iter().skip(1) {
        interleaved_set.join(Some(request), None);
    }
    for (participant, repeats) in interleaved_set.participants.iter_mut().skip(Control::ALL.len()).zip(repeats) {
        participant.repeats = *repeats;
    }
    interleaved_set.restore()?;
    let mut trials = Vec::new();
    for turn in 0..interleaved_sets {
        interleaved_set.setting.turn = turn;
        let Answered { outcomes, invalid, interleaved_set: record, .. } = interleaved_set.trace(rays)?;
        if let Some(what) = invalid {
            return Err(RunError::Control(what));
        }
        let traces = outcomes.into_iter().skip(Control::ALL.len()).collect::<Result<Vec<_>, _>>();
        let traces = traces.map_err(|refusal| nothing(&format!("{}: {}", request.name(), refusal.reason)))?;
        let interleaved_set = record.ok_or_else(|| nothing("nothing was timed"))?;
        let rounds = interleaved_set.orders.len();
        context.progress.say(&format!("  interleaved set {} of {interleaved_sets}: {rounds} rounds", turn + 1));
        trials.push(Trial { traces, interleaved_set });
    }
    Ok(trials)
}

/// A plan's first tracer, with its first scene ready to be measured.
fn first<'p>(plan: &'p Plan, context: &Context<'_>) -> Result<(&'p TracerRequest, PreparedWorkload), RunError> {
    let request = plan.tracers.first().ok_or_else(|| nothing("no tracer was asked for"))?;
    let scene = load(plan, context.progress)?.into_iter().next().ok_or_else(|| nothing("no scene was asked for"))?;
    Ok((request, placed(plan, scene, context)?))
}

fn nothing(what: &str) -> RunError {
    RunError::Nothing(what.to_owned())
}

/// The plan's first tracer on rays of so many seeds in turn: in every round fresh ones, which were not traced for as many rounds as there
/// are seeds, then at once the same again. Times of both by round, milliseconds.
pub(crate) fn fresh_and_repeated(plan: &Plan, seeds: u64, context: &Context<'_>) -> Result<[Vec<f64>; 2], RunError> {
    let of_seed = |seed: u64| Ok(first(&Plan { seed: plan.seed + seed, ..plan.clone() }, context)?.1.session);
    let sets = (0..seeds.max(1)).map(of_seed).collect::<Result<Vec<_>, RunError>>()?;
    let hashes = sets.iter().flat_map(|session| &session.rays).map(|rays| rays.sha256.as_str());
    if hashes.clone().count() != sets.len() || !hashes.clone().all_unique() {
        return Err(nothing(
            "the ray set is empty here, or has nothing random, so that no seed makes other rays of it",
        ));
    }
    let mut config = context.config(&plan.tracers[0])?;
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
