//! One place measured: its configurations in resident batches, each interleaved set kept as it ends.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use tracebench_api::TracerError;

use super::controls::Control;
use super::interleaved_set::{Built, InterleavedSet, Setting, Structures};
use super::run::Context;
use super::tracing::Answered;
use super::workload::{Measured, Observations, PreparedWorkload, Refusal, Workload};
use super::{RunError, records};
use crate::machine;
use crate::plan::Resolution;
use crate::results::{InterleavedSetRecord, Row, SceneRecord, Skipped, TraceRecord, ViewpointRecord};

/// Structures of configurations that are there at a time.
pub const MAX_RESIDENT: usize = 32;

/// What is known of a place from its preparation on.
#[derive(Clone, Serialize, Deserialize)]
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
    place: &'a Workload<'a>,
    context: &'a Context<'a>,
    placed: Option<PreparedWorkload>,
    head: Head,
    invalid: Option<String>,
    hooked: Vec<Value>,
    interleaved_sets: Vec<InterleavedSetRecord>,
    /// Ray sets that one configuration does not serve.
    unserved: Vec<Skipped>,
}

/// Measures a place, but for the interleaved sets that the journal has.
///
/// # Errors
/// [`RunError`] as its variants say; the interleaved sets that ended are kept.
pub(crate) fn measure(place: &Workload<'_>, context: &Context<'_>) -> Result<Measured, RunError> {
    let mut here = Here::enter(place, context)?;
    // Requests by structure, in the order of the first of each.
    let mut slots: Vec<Vec<usize>> = Vec::new();
    for (index, request) in place.requests.iter().enumerate() {
        match slots.iter_mut().find(|slot| place.requests[slot[0]].shares_structure_with(request)) {
            Some(slot) => slot.push(index),
            None => slots.push(vec![index]),
        }
    }
    let mut found = Measured {
        scene: here.head.scene.clone(),
        viewpoint: here.head.viewpoint.clone(),
        skipped: here.head.skipped.clone(),
        ..Measured::default()
    };
    let mut rows: Vec<Option<Result<Row, Refusal>>> = place.requests.iter().map(|_| None).collect();
    // A resident batch's stalls, and whether the first of them is there as the anchor.
    let first = slots.len().min(MAX_RESIDENT);
    let mut windows: Vec<(Vec<usize>, bool)> = vec![((0..first).collect(), false)];
    let further: Vec<usize> = (first..slots.len()).collect();
    windows.extend(further.chunks(MAX_RESIDENT - 1).map(|chunk| ([&[0], chunk].concat(), true)));
    let mut number = 0;
    while number < windows.len() {
        let (members, anchored) = windows[number].clone();
        let requests: Vec<&[usize]> = members
            .iter()
            .enumerate()
            .map(|(at, slot)| if at == 0 && anchored { &slots[*slot][..1] } else { &slots[*slot][..] })
            .collect();
        let mut batch = here.resident_batch(number, &requests)?.into_iter();
        let controls = here.controls(batch.by_ref().take(Control::ALL.len()))?;
        if number == 0 {
            found.controls = controls;
        }
        let mut left = Vec::new();
        for (at, (request, row)) in requests.concat().into_iter().zip(batch).enumerate() {
            if anchored && at == 0 {
                found.anchors.extend(row.ok());
                continue;
            }
            // Alone with the anchor, then alone: that others took the room is no reason to go without a row. What a study
            // looks at across rows hangs together.
            let again = members.len() > 1 && !place.options.lenient && place.hook.is_none();
            if again && row.as_ref().is_err_and(|refusal| refusal.for_room) {
                let slot = slots.iter().position(|slot| slot.contains(&request)).unwrap_or_default();
                if !left.contains(&slot) {
                    left.push(slot);
                }
            }
            rows[request] = Some(row);
        }
        let with_anchor = members.len() > 2;
        windows.extend(left.into_iter().map(|slot| match slot {
            0 => (vec![0], false),
            slot if with_anchor => (vec![0, slot], true),
            slot => (vec![slot], false),
        }));
        number += 1;
    }
    found.rows = rows.into_iter().map(|row| row.unwrap_or_else(|| Err(Refusal::not_measured()))).collect();
    found.skipped.extend(here.unserved);
    (found.hooked, found.invalid, found.interleaved_sets) = (here.hooked, here.invalid, here.interleaved_sets);
    Ok(found)
}

impl<'a> Here<'a> {
    fn enter(place: &'a Workload<'a>, context: &'a Context<'a>) -> Result<Self, RunError> {
        let name = format!("{:03}-place", place.index);
        let (head, placed) = match context.journal.read::<Head>(&name)? {
            Some(head) if place.scene_sha256.is_none_or(|known| known == head.scene.sha256) => (head, None),
            Some(head) => return Err(context.journal.other_scene(&head.scene.name).into()),
            None => {
                let placed = (place.prepare)()?;
                let head = Head {
                    scene: placed.scene.clone(),
                    viewpoint: placed.viewpoint.clone(),
                    difficulty_level: placed.difficulty_level,
                    sets: placed.session.rays.iter().map(|rays| rays.set.name.to_owned()).collect(),
                    skipped: placed.session.skipped.clone(),
                };
                context.journal.keep(&name, &head)?;
                (head, Some(placed))
            }
        };
        let (hooked, interleaved_sets, unserved) = (Vec::new(), Vec::new(), Vec::new());
        Ok(Self { place, context, placed, head, invalid: None, hooked, interleaved_sets, unserved })
    }

    /// Runs the interleaved sets of a resident batch, or takes them from the journal: the controls' rows, then those of its requests in
    /// order. `requests` by structure.
    fn resident_batch(&mut self, number: usize, requests: &[&[usize]]) -> Result<Vec<Result<Row, Refusal>>, RunError> {
        let index = self.place.index;
        let builds = format!("{index:03}-{number:02}-builds");
        let sets = self.head.sets.clone();
        let names: Vec<String> = (0..sets.len()).map(|set| format!("{index:03}-{number:02}-rays-{set:02}")).collect();
        let journal = self.context.journal;
        let mut kept_builds: Option<Structures> = journal.read(&builds)?;
        let mut kept: Vec<Option<RaysMeasured>> =
            names.iter().map(|name| journal.read(name)).collect::<Result<_, _>>()?;
        if (kept_builds.is_none() || kept.iter().any(Option::is_none)) && self.placed.is_none() {
            self.placed = Some((self.place.prepare)()?);
        }
        if let Some(placed) = self.placed.as_ref().filter(|_| kept_builds.is_none() || kept.iter().any(Option::is_none))
        {
            let mut interleaved_set = self.interleaved_set(number, placed, requests)?;
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
                let answered = interleaved_set.trace(rays)?;
                self.context.check_device()?;
                if let Some(what) = answered.invalid.as_ref().filter(|_| !self.place.options.lenient) {
                    return Err(RunError::Control(what.clone()));
                }
                let hooked = match self.place.hook {
                    Some(hook) => hook(&placed.session, rays, &by_request(requests, self.place, answered.told))?,
                    None => Value::Null,
                };
                let Answered { outcomes, invalid, interleaved_set: record, .. } = answered;
                let ended = RaysMeasured { outcomes, invalid, hooked, interleaved_set: record };
                journal.keep(name, &ended)?;
                *kept = Some(ended);
            }
        }
        let builds = kept_builds.unwrap_or_default();
        Ok(self.rows(number, requests, builds, kept.into_iter().flatten().collect()))
    }

    /// An interleaved set that everyone has entered who can be created.
    fn interleaved_set<'r>(
        &self,
        number: usize,
        placed: &'r PreparedWorkload,
        requests: &[&[usize]],
    ) -> Result<InterleavedSet<'r>, RunError>
    where
        'a: 'r,
    {
        let setting = Setting {
            scene: self.head.scene.name.clone(),
            viewpoint: self.head.viewpoint.name.clone(),
            resident_batch: number as u32,
            kernels: self.place.options.timed.then(|| self.context.kernels()).transpose()?,
            turn: 0,
        };
        let mut interleaved_set =
            InterleavedSet::new(&placed.session, self.place.options, self.context.progress, setting);
        for slot in requests {
            let first = &self.place.requests[slot[0]];
            let (config, refusal) = self.context.config_or_refusal(first, self.place.requests)?;
            interleaved_set.enter(config, Some(first), None);
            for further in &slot[1..] {
                interleaved_set.join(Some(&self.place.requests[*further]), None);
            }
            for participant in interleaved_set.participants.iter_mut().rev().take(slot.len()) {
                participant.out.clone_from(&refusal);
            }
        }
        Ok(interleaved_set)
    }

    /// Puts the outcomes of a resident batch's interleaved sets together, participant by participant.
    fn rows(
        &mut self,
        number: usize,
        requests: &[&[usize]],
        builds: Structures,
        interleaved_sets: Vec<RaysMeasured>,
    ) -> Vec<Result<Row, Refusal>> {
        let order: Vec<usize> = requests.concat();
        let of_builds = self.interleaved_sets.len() as u32;
        self.interleaved_sets.extend(builds.interleaved_sets);
        let builds = builds.outcomes;
        let mut participants: Vec<Vec<Result<TraceRecord, Refusal>>> = builds.iter().map(|_| Vec::new()).collect();
        for mut interleaved_set in interleaved_sets {
            if let Some(record) = interleaved_set.interleaved_set.take() {
                for trace in interleaved_set.outcomes.iter_mut().flatten() {
                    trace.times.interleaved_set = Some(self.interleaved_sets.len() as u32);
                }
                self.interleaved_sets.push(record);
            }
            self.invalid = self.invalid.take().or(interleaved_set.invalid);
            if number == 0 {
                self.hooked.push(interleaved_set.hooked);
            }
            for (participant, outcome) in participants.iter_mut().zip(interleaved_set.outcomes) {
                participant.push(outcome);
            }
        }
        let mut rows = Vec::new();
        for (participant, (mut built, traced)) in builds.into_iter().zip(participants).enumerate() {
            for times in built.iter_mut().flat_map(|built| built.build.all_mut()) {
                times.interleaved_set = times.interleaved_set.map(|interleaved_set| interleaved_set + of_builds);
            }
            let request = participant.checked_sub(Control::ALL.len()).map(|place| order[place]);
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
        for (rays, outcome) in self.head.sets.iter().zip(traced) {
            match outcome {
                Err(refusal) if refusal.unserved => unserved.push((rays.clone(), refusal)),
                outcome => traces.push(outcome?),
            }
        }
        // Who serves none of the rays has no row.
        if let Some((_, refusal)) = unserved.first().filter(|_| traces.is_empty()) {
            return Err(refusal.clone());
        }
        let mut viewpoint = self.head.viewpoint.clone();
        let tracer = match request.map(|request| &self.place.requests[request]) {
            None => records::control_record(Control::ALL[participant]),
            Some(request) => {
                if let Some(Resolution { frame, face }) = request.resolution {
                    (viewpoint.frame, viewpoint.face) = (frame, face);
                }
                records::request_record(request)
            }
        };
        for (rays, Refusal { reason, .. }) in unserved {
            let (tracer, scene) = (Some(tracer.label()), self.head.scene.name.clone());
            let skipped = Skipped { tracer, scene, rays: Some(rays), reason };
            // The anchor is in several batches.
            if !self.unserved.contains(&skipped) {
                self.unserved.push(skipped);
            }
        }
        let sources = if request.is_some() { tracer.name.as_str() } else { machine::CONTROLS };
        Ok(Row {
            fingerprint: machine::fingerprint(sources).map(str::to_owned),
            scene: self.head.scene.clone(),
            viewpoint,
            tracer,
            update_mode: None,
            difficulty_level: self.head.difficulty_level,
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
                Err(refusal) if self.place.options.lenient => {
                    self.invalid.get_or_insert(refusal.reason);
                }
                Err(refusal) => {
                    let name = control.description().name.to_owned();
                    return Err(RunError::Tracer(name, TracerError::Failed(refusal.reason)));
                }
            }
        }
        Ok(controls)
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

/// Answers in the order of the place's requests.
fn by_request(
    requests: &[&[usize]],
    place: &Workload<'_>,
    told: Vec<Option<Observations>>,
) -> Vec<Option<Observations>> {
    let mut sorted: Vec<Option<Observations>> = place.requests.iter().map(|_| None).collect();
    for (request, told) in requests.concat().into_iter().zip(told.into_iter().skip(Control::ALL.len())) {
        sorted[request] = told;
    }
    sorted
}
