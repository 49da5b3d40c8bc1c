//! The interleaved set: configurations and controls of one resident batch in one place, sampled in rounds; here what they build.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use tracebench_api::{Residency, Timing, TracerError, Update, Viewpoint};

use super::controls::Control;
use super::kernels::Kernels;
use super::records;
use super::rounds::Rounds;
use super::session::Session;
use super::workload::{MeasureOptions, Refusal};
use super::{RunError, TracerConfig, sound};
use crate::plan::{Resolution, TracerRequest};
use crate::progress::Progress;
use crate::results::{
    BuildRecord, ClockTicks, InterleavedSetRecord, KernelRecord, MemoryRecord, SampleSchedule, StopReason,
};

/// A validation that takes longer is told of, where bars do not show: it is the only work that grows with what is stored.
const LONG_VALIDATION: Duration = Duration::from_secs(2);

/// The interleaved sets of structures that are built, that are refitted, and that follow a moving scene.
const BUILDS: &str = "builds";
const UPDATES: &str = "updates";
pub(super) const FRAMES: &str = "frames";

/// A structure with the configuration that builds it. Several participants trace it where they differ in trace parameters alone.
pub(super) struct StructureSlot {
    pub config: TracerConfig,
    /// What it builds from: the session's viewpoint, at a resolution of its own if it has one.
    pub viewpoint: Viewpoint,
    /// Counted samples of its builds, or of its refits.
    pub builds: BuildSamples,
    statistics: BTreeMap<String, f64>,
}

/// Counted samples of what a structure takes, by round.
#[derive(Default)]
pub(super) struct BuildSamples {
    /// Phases of first builds, or of refits.
    pub phases: Vec<Timing>,
    /// First builds; none of what is refitted.
    pub first: Vec<Timing>,
    /// Steady builds, or refits.
    pub steady: Vec<Timing>,
}

/// One who traces: a control, or a configuration that was asked for.
pub(super) struct Participant {
    /// None of a control.
    pub request: Option<TracerRequest>,
    pub control: Option<Control>,
    pub(super) slot: usize,
    /// How often it traces in one sample.
    pub repeats: usize,
    /// What took it out of the interleaved set.
    pub out: Option<Refusal>,
    /// Why it does not serve the ray set in turn.
    pub unserved: Option<Refusal>,
}

impl Participant {
    /// Whether it traces the ray set in turn, as far as that is known.
    pub fn is_in(&self) -> bool {
        self.out.is_none() && self.unserved.is_none()
    }

    /// Why it did not trace the ray set in turn.
    pub fn refusal(&self) -> Refusal {
        let known = self.out.as_ref().or(self.unserved.as_ref()).cloned();
        known.unwrap_or_else(Refusal::not_measured)
    }

    /// Its name in records.
    pub fn label(&self) -> String {
        match (&self.request, self.control) {
            (Some(request), _) => records::request_record(request).label(),
            (None, Some(control)) => control.description().name.to_owned(),
            (None, None) => String::new(),
        }
    }
}

/// What was found out about a structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Built {
    pub memory: MemoryRecord,
    pub structure_statistics: BTreeMap<String, f64>,
    pub build: BuildRecord,
}

/// What the interleaved set of the structures gave.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Structures {
    /// By participant, or why it was taken out; times name their interleaved set by its place here.
    pub outcomes: Vec<Result<Built, Refusal>>,
    pub interleaved_sets: Vec<InterleavedSetRecord>,
}

/// Where an interleaved set is run.
#[derive(Clone)]
pub(crate) struct Setting<'a> {
    pub scene: String,
    pub viewpoint: String,
    pub resident_batch: u32,
    /// None where nothing is timed.
    pub kernels: Option<&'a Kernels>,
    /// Tells interleaved sets of the same from one another.
    pub turn: usize,
}

/// One resident batch in one place.
pub(crate) struct InterleavedSet<'a> {
    pub(super) session: &'a Session,
    pub(super) options: MeasureOptions,
    pub(super) progress: &'a Progress,
    pub(super) setting: Setting<'a>,
    pub(super) slots: Vec<StructureSlot>,
    pub(super) participants: Vec<Participant>,
}

impl<'a> InterleavedSet<'a> {
    /// An interleaved set with the controls in its first participants.
    pub fn new(session: &'a Session, options: MeasureOptions, progress: &'a Progress, setting: Setting<'a>) -> Self {
        let mut interleaved_set =
            Self { session, options, progress, setting, slots: Vec::new(), participants: Vec::new() };
        for (control, config) in session.controls() {
            interleaved_set.enter(config, None, Some(control));
        }
        interleaved_set
    }

    /// Lets a configuration take part, in a stall of its own.
    pub fn enter(&mut self, config: TracerConfig, request: Option<&TracerRequest>, control: Option<Control>) {
        let viewpoint = match request.and_then(|request| request.resolution) {
            Some(Resolution { frame, face }) => Viewpoint { frame, face, ..self.session.viewpoint },
            None => self.session.viewpoint,
        };
        let (builds, statistics) = (BuildSamples::default(), BTreeMap::new());
        self.slots.push(StructureSlot { config, viewpoint, builds, statistics });
        self.join(request, control);
    }

    /// Lets another one trace the structure of the last stall.
    pub fn join(&mut self, request: Option<&TracerRequest>, control: Option<Control>) {
        let (request, slot) = (request.cloned(), self.slots.len() - 1);
        self.participants.push(Participant { request, control, slot, repeats: 1, out: None, unserved: None });
    }

    /// Takes a participant out.
    pub fn take_out(&mut self, participant: usize, refusal: Refusal) {
        self.participants[participant].out.get_or_insert(refusal);
    }

    /// Does something with a stall unless it has failed before; a failure takes its participants out. `for_room`: it may be for want of
    /// room beside others.
    fn attempt<R>(
        &mut self,
        slot: usize,
        for_room: bool,
        work: impl FnOnce(&mut StructureSlot) -> Result<R, TracerError>,
    ) -> Option<R> {
        if !self.participants.iter().any(|participant| participant.slot == slot && participant.out.is_none()) {
            return None;
        }
        let refusal = match work(&mut self.slots[slot]) {
            Ok(done) => return Some(done),
            Err(error) => Refusal::of(&error, for_room),
        };
        for participant in self.participants.iter_mut().filter(|participant| participant.slot == slot) {
            participant.out.get_or_insert_with(|| refusal.clone());
        }
        None
    }

    /// Rounds of some work and so many participants, with the fixed kernels of the clocks by which some slots are timed.
    pub(super) fn rounds(
        &self,
        (work, attempt): (&str, usize),
        participants: usize,
        slots: impl IntoIterator<Item = usize>,
        sampling: Option<SampleSchedule>,
    ) -> Rounds<'a> {
        let sides = slots.into_iter().map(|slot| self.slots[slot].config.description.residency).collect::<Vec<_>>();
        let seed = self.setting.order_seed(self.options.seed, work, attempt);
        self.setting.rounds(seed, participants, &sides, sampling)
    }

    /// The ticks of its clocks; none where nothing is timed.
    pub(super) fn ticks(&self) -> Option<ClockTicks> {
        self.setting.kernels.map(|kernels| kernels.ticks)
    }

    /// A stall in words: the first participant that traces it.
    pub(super) fn slot_label(&self, slot: usize) -> String {
        let tracing = self.participants.iter().find(|participant| participant.slot == slot);
        tracing.map_or_else(String::new, Participant::label)
    }

    /// Stalls of configurations: controls build nothing that is worth a look.
    fn is_tracer(&self, slot: usize) -> bool {
        self.participants.iter().any(|participant| participant.slot == slot && participant.control.is_none())
    }

    /// The slots that are refitted, or those that are not: controls have nothing to refit.
    fn refitted(&self, is_refitted: bool) -> Vec<usize> {
        let is = |slot: &usize| (self.options.refitted && self.is_tracer(*slot)) == is_refitted;
        (0..self.slots.len()).filter(is).collect()
    }

    /// Builds everything, or refits it, in rounds; then lets every structure be read back and checked.
    pub fn build(&mut self) -> Result<Structures, RunError> {
        let counted = self.options.sampling.map_or(0, |sampling| sampling.min_rounds);
        let mut interleaved_sets: Vec<InterleavedSetRecord> = self.refit(counted)?.into_iter().collect();
        let built = self.refitted(false);
        let configs: Vec<usize> = built.iter().copied().filter(|slot| self.is_tracer(*slot)).collect();
        let sampling = self.options.sampling.filter(|_| self.options.builds_timed);
        let mut rounds = self.rounds((BUILDS, 0), built.len(), configs.iter().copied(), sampling);
        let bar = self.progress.bar(BUILDS, (rounds.least() * built.len()) as u64);
        let gpu = self.session.gpu();
        // Intervals are waited for of what is compared.
        while let Some(round) = rounds.next(gpu, || {
            let builds = configs.iter().map(|slot| &self.slots[*slot].builds);
            [
                builds.clone().map(|builds| &builds.first[..]).collect(),
                builds.map(|builds| &builds.steady[..]).collect(),
            ]
        })? {
            for place in round.order {
                self.build_once(built[place], round.counts);
                bar.inc(1);
            }
        }
        bar.finish_and_clear();
        let participants = built.iter().map(|slot| self.slot_label(*slot)).collect();
        interleaved_sets.extend(self.setting.record(BUILDS, &rounds, participants));
        if self.options.validated {
            self.validate();
        }
        let believed = records::are_believed(self.slots.iter().map(|slot| &slot.builds.phases[..]));
        let told = |slot: usize| {
            // Behind that of the refits is that of the controls, which are built.
            let place = usize::from(self.options.refitted && !self.is_tracer(slot));
            let StructureSlot { config, builds, statistics, .. } = &self.slots[slot];
            let BuildSamples { phases, first, steady } = builds;
            // What was not timed has no whole times.
            let whole = |samples: &[Timing]| (!samples.is_empty()).then(|| Box::new(records::times(samples, true)));
            let (times, setup_ms) = (records::times(phases, believed), config.setup_ms);
            let mut build = BuildRecord { times, first: whole(first), steady: whole(steady), setup_ms };
            let is_timed = !phases.is_empty() && place < interleaved_sets.len();
            let interleaved_set = is_timed.then_some(place as u32);
            for times in build.all_mut() {
                times.invalid = self.ticks().and_then(|ticks| ticks.too_coarse(times));
                times.interleaved_set = interleaved_set;
            }
            let memory = config.structure()?.memory();
            let memory = MemoryRecord {
                structure_bytes: memory.structure_bytes(),
                geometry_bytes: memory.geometry_bytes_to(self.session.trace_to),
                structure: memory.structure,
                build_peak_bytes: memory.build_peak_bytes,
            };
            Ok::<Built, TracerError>(Built { memory, structure_statistics: statistics.clone(), build })
        };
        let outcome = |participant: &Participant| match &participant.out {
            None => told(participant.slot).map(Ok),
            Some(refusal) => Ok(Err(refusal.clone())),
        };
        let outcomes = self.participants.iter().map(outcome).collect::<Result<_, TracerError>>()?;
        Ok(Structures { outcomes, interleaved_sets })
    }

    /// Builds everything once more, as it was when the interleaved sets before were run; nothing is timed.
    pub fn restore(&mut self) -> Result<(), RunError> {
        self.refit(0)?;
        self.refitted(false).into_iter().for_each(|slot| self.build_once(slot, false));
        Ok(())
    }

    /// Refits what is to be refitted, so often that it counts: a refit is of a fresh build, which is in no time. First both warm up.
    fn refit(&mut self, counted: u32) -> Result<Option<InterleavedSetRecord>, RunError> {
        let slots = self.refitted(true);
        if slots.is_empty() {
            return Ok(None);
        }
        let (geometry, gpu) = (self.session.geometry(), self.session.gpu());
        let sampling = (counted > 0).then_some(SampleSchedule::rounds(counted));
        let mut rounds = self.rounds((UPDATES, 0), slots.len(), slots.iter().copied(), sampling);
        let bar = self.progress.bar(UPDATES, 2 * slots.len() as u64 * (u64::from(counted) + 1));
        for pass in 0..=counted {
            for is_refit in [false, true] {
                let counts = pass > 0 && is_refit;
                let is_round = counts || (pass == 0 && !is_refit);
                let round = if is_round { rounds.next(gpu, || [Vec::new()])? } else { None };
                for place in round.map_or_else(|| (0..slots.len()).collect(), |round| round.order) {
                    let sample = self.attempt(slots[place], true, |one| match is_refit {
                        true => one.config.update(Update::Refit, geometry, &one.viewpoint, gpu),
                        false => one.config.build(geometry, &one.viewpoint, gpu).map(Some),
                    });
                    if let Some(sample) = sample.flatten().filter(|_| counts) {
                        let samples = &mut self.slots[slots[place]].builds;
                        samples.phases.push(sample.phases);
                        samples.steady.push(sample.whole);
                    }
                    bar.inc(1);
                }
            }
        }
        rounds.next(gpu, || [slots.iter().map(|slot| &self.slots[*slot].builds.steady[..]).collect()])?;
        let participants = slots.iter().map(|slot| self.slot_label(*slot)).collect();
        Ok(self.setting.record(UPDATES, &rounds, participants))
    }

    /// A first build and, where times are taken, a steady one behind it.
    fn build_once(&mut self, slot: usize, counts: bool) {
        let (session, timed) = (self.session, self.options.sampling.is_some() && self.options.builds_timed);
        let built = self.attempt(slot, true, |one| {
            let first = one.config.build(session.geometry(), &one.viewpoint, session.gpu())?;
            let mut again = || one.config.update(Update::Rebuild, session.geometry(), &one.viewpoint, session.gpu());
            Ok((first, if timed { again()? } else { None }))
        });
        if let Some((first, steady)) = built.filter(|_| counts) {
            let builds = &mut self.slots[slot].builds;
            builds.phases.push(first.phases);
            builds.first.push(first.whole);
            builds.steady.extend(steady.map(|steady| steady.whole));
        }
    }

    /// Lets every structure be read back and checked, outside of any time. What is unsound, or says of itself what is no number, is taken
    /// out.
    fn validate(&mut self) {
        let bar = self.progress.bar("validate", self.slots.len() as u64);
        for slot in 0..self.slots.len() {
            let begin = Instant::now();
            let session = self.session;
            // What is unsound is so with or without others beside it.
            let statistics = self.attempt(slot, false, |one| {
                let found = sound::statistics(one.config.structure()?, session.geometry())?;
                Ok(found.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
            });
            self.slots[slot].statistics = statistics.unwrap_or_default();
            bar.inc(1);
            if begin.elapsed() > LONG_VALIDATION {
                let name = self.slots[slot].config.description.name;
                self.progress.say(&format!("  validated {name} in {:.0} s", begin.elapsed().as_secs_f64()));
            }
        }
    }

    /// The configuration that a participant traces by, told the participant's own parameters.
    pub(super) fn config(&mut self, participant: usize) -> &TracerConfig {
        let Participant { request, slot, .. } = &self.participants[participant];
        let config = &mut self.slots[*slot].config;
        if let Some(request) = request {
            config.parameters.clone_from(&request.parameters);
        }
        config
    }

    /// Does something in a participant unless it has failed before; a failure takes it out, and rays that it does not serve keep it from
    /// their own interleaved set alone.
    pub(super) fn attempt_in<R>(
        &mut self,
        participant: usize,
        work: impl FnOnce(&Session, &TracerConfig) -> Result<R, TracerError>,
    ) -> Option<R> {
        if !self.participants[participant].is_in() {
            return None;
        }
        let session = self.session;
        match work(session, self.config(participant)) {
            Ok(done) => return Some(done),
            Err(error @ TracerError::Unsupported(_)) => {
                self.participants[participant].unserved = Some(Refusal::of(&error, false));
            }
            Err(error) => self.take_out(participant, Refusal::of(&error, true)),
        }
        None
    }
}

impl<'a> Setting<'a> {
    /// The seed of the orders of some work here, a number that JSON holds exactly.
    pub(super) fn order_seed(&self, seed: u64, work: &str, attempt: usize) -> u64 {
        let Setting { scene, viewpoint, resident_batch, turn, .. } = self;
        let words = format!("{seed} {scene} {viewpoint} {resident_batch} {work} {turn} {attempt}");
        u64::from_str_radix(&crate::hash::sha256_of(words.as_bytes())[..13], 16).unwrap_or_default()
    }

    /// Rounds of so many participants, with the fixed kernels of the clocks that work where it is done is timed by.
    pub(super) fn rounds(
        &self,
        order_seed: u64,
        participants: usize,
        done_on: &[Residency],
        sampling: Option<SampleSchedule>,
    ) -> Rounds<'a> {
        let sides = [Residency::Host, Residency::Device].into_iter().filter(|side| done_on.contains(side));
        let kernels = self.kernels.filter(|_| sampling.is_some());
        let timed = |side| kernels.filter(|kernels| kernels.have(side)).map(|kernels| (side, kernels, Vec::new()));
        Rounds { sampling, order_seed, participants, kernels: sides.filter_map(timed).collect(), ..Rounds::default() }
    }

    /// The record of an interleaved set; none where nothing was timed.
    pub(super) fn record(
        &self,
        work: &str,
        rounds: &Rounds<'_>,
        participants: Vec<String>,
    ) -> Option<InterleavedSetRecord> {
        let Setting { scene, viewpoint, resident_batch, .. } = self.clone();
        let kernel = |(side, kernels, timings): &(Residency, &Kernels, Vec<Timing>)| kernels.record(*side, timings);
        let kernels: Vec<KernelRecord> = rounds.kernels.iter().map(kernel).collect();
        let each_round = match work {
            BUILDS => "first builds, each with a rebuild behind it",
            UPDATES | FRAMES => "the next frame",
            _ => "the same rays",
        };
        let in_u32 = |order: &Vec<usize>| order.iter().map(|participant| *participant as u32).collect();
        Some(InterleavedSetRecord {
            scene,
            viewpoint,
            resident_batch,
            work: work.to_owned(),
            participants,
            order_seed: rounds.order_seed,
            orders: rounds.orders.iter().map(in_u32).collect(),
            each_round: each_round.to_owned(),
            warm_up_rounds: 1,
            sampling: rounds.sampling?,
            stop_reason: rounds.stop_reason.unwrap_or(StopReason::Rounds),
            sampled_s: rounds.sampled_s,
            widest_interval: rounds.widest_interval,
            drift: kernels.iter().any(|kernel| kernel.drifts),
            clock_ticks: self.kernels.map(|kernels| kernels.ticks),
            kernels,
            doubled_work: Vec::new(),
            repeated_because: None,
        })
    }
}

impl Refusal {
    /// Why a tracer was taken out. `for_room`: it may have been for want of room beside others.
    pub fn of(error: &TracerError, for_room: bool) -> Self {
        let too_large = matches!(error, TracerError::TooLarge { .. });
        let unavailable = matches!(error, TracerError::Unavailable(_));
        // Limits of a device are the same with or without others.
        let for_room = for_room && matches!(error, TracerError::Failed(_));
        let unserved = matches!(error, TracerError::Unsupported(_));
        Self { reason: error.to_string(), too_large, unavailable, unserved, for_room }
    }

    /// Of what nothing is known.
    pub(super) fn not_measured() -> Self {
        Self { reason: "not measured".to_owned(), ..Self::default() }
    }
}
