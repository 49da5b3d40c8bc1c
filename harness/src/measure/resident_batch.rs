//! One place measured: its configurations in resident batches, each interleaved set kept as it ends.

use itertools::Itertools as _;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tracebench_api::TracerError;

use super::controls::Control;
use super::interleaved_set::{Built, InterleavedSet, Setting, Structures};
use super::run::Context;
use super::tracing::Answered;
use super::workload::{Hook, MeasureOptions, Measured, Observations, Prepare, PreparedWorkload, Refusal, Workload};
use super::{RunError, records};
use crate::machine;
use crate::plan::{Resolution, TracerRequest};
use crate::results::{InterleavedSetRecord, Row, SceneRecord, Skipped, TraceRecord, ViewpointRecord};

/// Structures of configurations that are there at a time.
pub const MAX_RESIDENT: usize = 32;

/// What is known of a place from its preparation on.
#[derive(Serialize, Deserialize)]
struct Head {
    scene: SceneRecord,
    viewpoint: ViewpointRecord,
    difficulty_level: Option<f64>,
    sets: Vec<String>,
    skipped: Vec<Skipped>,
}

/// The interleaved set of a ray set, as it is kept.
#[derive(Serialize, Deserialize)]
struct RaysMeasured {
    outcomes: Vec<Result<TraceRecord, Refusal>>,
    invalid: Option<String>,
    hooked: Value,
    interleaved_set: Option<InterleavedSetRecord>,
}

/// A place while it is measured.
struct Here<'a> {
    index: usize,
    requests: &'a [TracerRequest],
    options: MeasureOptions,
    hook: Option<Hook<'a>>,
    context: &'a Context<'a>,
    /// Until the place is prepared.
    prepare: Option<Prepare<'a>>,
    placed: Option<PreparedWorkload>,
    difficulty_level: Option<f64>,
    sets: Vec<String>,
    found: Measured,
}

/// Measures a place, but for the interleaved sets that the journal has.
///
/// # Errors
/// [`RunError`] as its variants say; the interleaved sets that ended are kept.
pub(crate) fn measure(place: Workload<'_>, context: &Context<'_>) -> Result<Measured, RunError> {
    let mut here = Here::enter(place, context)?;
    // Requests by structure, in the order of the first of each.
    let mut slots: Vec<Vec<usize>> = Vec::new();
    for (index, request) in here.requests.iter().enumerate() {
        match slots.iter_mut().find(|slot| here.requests[slot[0]].shares_structure_with(request)) {
            Some(slot) => slot.push(index),
            None => slots.push(vec![index]),
        }
    }
    // A resident batch's structures with their requests, and whether the first is there as the anchor: by the first request alone.
    let (first, further) = slots.split_at(slots.len().min(MAX_RESIDENT));
    let anchored = |slots: &[Vec<usize>]| ([&[vec![0]][..], slots].concat(), true);
    let mut windows: Vec<(Vec<Vec<usize>>, bool)> = vec![(first.to_vec(), false)];
    windows.extend(further.chunks(MAX_RESIDENT - 1).map(anchored));
    let mut number = 0;
    while number < windows.len() {
        let (members, has_anchor) = windows[number].clone();
        let mut batch = here.resident_batch(number, &members)?.into_iter();
        let controls = here.controls(batch.by_ref().take(Control::ALL.len()))?;
        if number == 0 {
            here.found.controls = controls;
        }
        let mut left: Vec<&Vec<usize>> = Vec::new();
        for (at, (request, row)) in members.concat().into_iter().zip(batch).enumerate() {
            if has_anchor && at == 0 {
                here.found.anchors.extend(row.ok());
                continue;
            }
            // Alone with the anchor, then alone: that others took the room is no reason to go without a row. What a study
            // looks at across rows hangs together.
            let again = members.len() > 1 && !here.options.lenient && here.hook.is_none();
            if again && row.as_ref().is_err_and(|refusal| refusal.for_room) {
                left.extend(slots.iter().find(|slot| slot.contains(&request)));
            }
            here.found.rows[request] = row;
        }
        let with_anchor = |slot: &[usize]| members.len() > 2 && slot[0] > 0;
        windows.extend(left.into_iter().unique().map(|slot| match with_anchor(slot) {
            true => anchored(std::slice::from_ref(slot)),
            false => (vec![slot.clone()], false),
        }));
        number += 1;
    }
    Ok(here.found)
}

impl<'a> Here<'a> {
    fn enter(place: Workload<'a>, context: &'a Context<'a>) -> Result<Self, RunError> {
        let Workload { index, scene_sha256, prepare, requests, options, hook } = place;
        let name = format!("{index:03}-place");
        let (head, placed, prepare) = match context.journal.read::<Head>(&name)? {
            Some(head) if scene_sha256.is_none_or(|known| known == head.scene.sha256) => (head, None, Some(prepare)),
            Some(head) => return Err(context.journal.other_scene(&head.scene.name).into()),
            None => {
                let placed = prepare()?;
                let head = Head {
                    scene: placed.scene.clone(),
                    viewpoint: placed.viewpoint.clone(),
                    difficulty_level: placed.difficulty_level,
                    sets: placed.session.rays.iter().map(|rays| rays.set.name.to_owned()).collect(),
                    skipped: placed.session.skipped.clone(),
                };
                context.journal.keep(&name, &head)?;
                (head, Some(placed), None)
            }
        };
        let Head { scene, viewpoint, difficulty_level, sets, skipped } = head;
        let rows = requests.iter().map(|_| Err(Refusal::not_measured())).collect();
        let found = Measured { scene, viewpoint, skipped, rows, ..Measured::default() };
        Ok(Self { index, requests, options, hook, context, prepare, placed, difficulty_level, sets, found })
    }

    /// Runs the interleaved sets of a resident batch, or takes them from the journal: the controls' rows, then those of its requests in
    /// order. `slots`: requests by structure.
    fn resident_batch(&mut self, number: usize, slots: &[Vec<usize>]) -> Result<Vec<Result<Row, Refusal>>, RunError> {
        let name = format!("{:03}-{number:02}", self.index);
        let builds = format!("{name}-builds");
        let names: Vec<String> = (0..self.sets.len()).map(|set| format!("{name}-rays-{set:02}")).collect();
        let journal = self.context.journal;
        let mut kept_builds: Option<Structures> = journal.read(&builds)?;
        let mut kept: Vec<Option<RaysMeasured>> =
            names.iter().map(|name| journal.read(name)).collect::<Result<_, _>>()?;
        let is_done = kept_builds.is_some() && kept.iter().all(Option::is_some);
        if let Some(prepare) = self.prepare.take_if(|_| !is_done) {
            self.placed = Some(prepare()?);
        }
        if let Some(placed) = self.placed.as_ref().filter(|_| !is_done) {
            let mut interleaved_set = self.interleaved_set(number, placed, slots)?;
            match &kept_builds {
                None => {
                    let built = interleaved_set.build()?;
                    self.context.check_device()?;
                    journal.keep(&builds, &built)?;
                    kept_builds = Some(built);
                }
                Some(built) => {
                    take_out(&mut interleaved_set, &built.outcomes, |_| true);
                    interleaved_set.restore()?;
                }
            }
            for ((rays, name), kept) in placed.session.rays.iter().zip(&names).zip(&mut kept) {
                if let Some(ended) = kept {
                    // Who does not serve some rays stays in for others.
                    take_out(&mut interleaved_set, &ended.outcomes, |refusal| !refusal.unserved);
                    continue;
                }
                let Answered { outcomes, told, invalid, interleaved_set } = interleaved_set.trace(rays)?;
                self.context.check_device()?;
                if let Some(what) = invalid.as_ref().filter(|_| !self.options.lenient) {
                    return Err(RunError::Control(what.clone()));
                }
                let hooked = match self.hook {
                    Some(hook) => hook(&placed.session, rays, &self.by_request(slots, told))?,
                    None => Value::Null,
                };
                let ended = RaysMeasured { outcomes, invalid, hooked, interleaved_set };
                journal.keep(name, &ended)?;
                *kept = Some(ended);
            }
        }
        let builds = kept_builds.unwrap_or_default();
        Ok(self.rows(number, &slots.concat(), builds, kept.into_iter().flatten().collect()))
    }

    /// An interleaved set that everyone has entered who can be created.
    fn interleaved_set<'r>(
        &self,
        number: usize,
        placed: &'r PreparedWorkload,
        slots: &[Vec<usize>],
    ) -> Result<InterleavedSet<'r>, RunError>
    where
        'a: 'r,
    {
        let setting = Setting {
            scene: self.found.scene.name.clone(),
            viewpoint: self.found.viewpoint.name.clone(),
            resident_batch: number as u32,
            kernels: self.options.sampling.map(|_| self.context.kernels()).transpose()?,
            turn: 0,
        };
        let mut interleaved_set = InterleavedSet::new(&placed.session, self.options, self.context.progress, setting);
        for slot in slots {
            let first = &self.requests[slot[0]];
            let (config, refusal) = self.context.config_or_refusal(first, self.requests)?;
            interleaved_set.enter(config, Some(first), None);
            for further in &slot[1..] {
                interleaved_set.join(Some(&self.requests[*further]), None);
            }
            for participant in interleaved_set.participants.iter_mut().rev().take(slot.len()) {
                participant.out.clone_from(&refusal);
            }
        }
        Ok(interleaved_set)
    }

    /// Puts the outcomes of a resident batch's interleaved sets together, participant by participant; `requests` in order.
    fn rows(
        &mut self,
        number: usize,
        requests: &[usize],
        builds: Structures,
        interleaved_sets: Vec<RaysMeasured>,
    ) -> Vec<Result<Row, Refusal>> {
        let found = &mut self.found;
        let of_builds = found.interleaved_sets.len() as u32;
        found.interleaved_sets.extend(builds.interleaved_sets);
        let mut traced = Vec::new();
        for RaysMeasured { mut outcomes, invalid, hooked, interleaved_set } in interleaved_sets {
            if let Some(record) = interleaved_set {
                for trace in outcomes.iter_mut().flatten() {
                    trace.times.interleaved_set = Some(found.interleaved_sets.len() as u32);
                }
                found.interleaved_sets.push(record);
            }
            found.invalid = found.invalid.take().or(invalid);
            if number == 0 {
                found.hooked.push(hooked);
            }
            traced.push(outcomes.into_iter());
        }
        let mut rows = Vec::new();
        for (participant, mut built) in builds.outcomes.into_iter().enumerate() {
            for times in built.iter_mut().flat_map(|built| built.build.all_mut()) {
                times.interleaved_set = times.interleaved_set.map(|interleaved_set| interleaved_set + of_builds);
            }
            let request = participant.checked_sub(Control::ALL.len()).map(|place| requests[place]);
            let traced = traced.iter_mut().filter_map(Iterator::next).collect();
            rows.push(self.row(number, participant, request, built, traced));
        }
        rows
    }

    fn row(
        &mut self,
        number: usize,
        participant: usize,
        request: Option<usize>,
        built: Result<Built, Refusal>,
        traced: Vec<Result<TraceRecord, Refusal>>,
    ) -> Result<Row, Refusal> {
        let Built { memory, structure_statistics, build } = built?;
        let (mut traces, mut unserved) = (Vec::new(), Vec::new());
        for (rays, outcome) in self.sets.iter().zip(traced) {
            match outcome {
                Err(refusal) if refusal.unserved => unserved.push((rays.clone(), refusal)),
                outcome => traces.push(outcome?),
            }
        }
        // Who serves none of the rays has no row.
        if let Some((_, refusal)) = unserved.first().filter(|_| traces.is_empty()) {
            return Err(refusal.clone());
        }
        let mut viewpoint = self.found.viewpoint.clone();
        let tracer = match request.map(|request| &self.requests[request]) {
            None => records::control_record(Control::ALL[participant]),
            Some(request) => {
                if let Some(Resolution { frame, face }) = request.resolution {
                    (viewpoint.frame, viewpoint.face) = (frame, face);
                }
                records::request_record(request)
            }
        };
        for (rays, Refusal { reason, .. }) in unserved {
            let (tracer, scene) = (Some(tracer.label()), self.found.scene.name.clone());
            let skipped = Skipped { tracer, scene, rays: Some(rays), reason };
            // The anchor is in several batches.
            if !self.found.skipped.contains(&skipped) {
                self.found.skipped.push(skipped);
            }
        }
        let sources = if request.is_some() { tracer.name.as_str() } else { machine::CONTROLS };
        Ok(Row {
            fingerprint: machine::fingerprint(sources).map(str::to_owned),
            scene: self.found.scene.clone(),
            viewpoint,
            tracer,
            update_mode: None,
            difficulty_level: self.difficulty_level,
            resident_batch: number as u32,
            machine: 0,
            memory,
            structure_statistics,
            build,
            traces,
        })
    }

    /// Controls go the way of every configuration, and one that cannot voids what was measured.
    fn controls(&mut self, rows: impl Iterator<Item = Result<Row, Refusal>>) -> Result<Vec<Row>, RunError> {
        let mut controls = Vec::new();
        for (row, control) in rows.zip(Control::ALL) {
            match row {
                Ok(row) => controls.push(row),
                Err(refusal) if self.options.lenient => {
                    self.found.invalid.get_or_insert(refusal.reason);
                }
                Err(refusal) => {
                    let name = control.description().name.to_owned();
                    return Err(RunError::Tracer(name, TracerError::Failed(refusal.reason)));
                }
            }
        }
        Ok(controls)
    }

    /// Answers in the order of the place's requests.
    fn by_request(&self, slots: &[Vec<usize>], told: Vec<Option<Observations>>) -> Vec<Option<Observations>> {
        let mut sorted: Vec<Option<Observations>> = self.requests.iter().map(|_| None).collect();
        for (request, told) in slots.concat().into_iter().zip(told.into_iter().skip(Control::ALL.len())) {
            sorted[request] = told;
        }
        sorted
    }
}

/// Takes out of an interleaved set who was taken out of the one that is kept.
fn take_out<T>(
    interleaved_set: &mut InterleavedSet<'_>,
    outcomes: &[Result<T, Refusal>],
    is_out: impl Fn(&Refusal) -> bool,
) {
    for (participant, outcome) in outcomes.iter().enumerate() {
        if let Some(refusal) = outcome.as_ref().err().filter(|refusal| is_out(refusal)) {
            interleaved_set.take_out(participant, refusal.clone());
        }
    }
}
