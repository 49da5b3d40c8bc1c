//! The race: contenders and controls of one window in one place, sampled in rounds; here what they build.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use tracebench_api::{Residency, Timing, TracerError, Update, Viewpoint};

use super::controls::Control;
use super::following::UPDATES;
use super::kernels::{Kernels, Side};
use super::place::{Effort, Film, Refusal, Request};
use super::records;
use super::rounds::Rounds;
use super::session::{Session, SessionError};
use super::{BuildSample, Contender, RunError, sound};
use crate::plan::{Resolution, TracerRequest};
use crate::progress::Progress;
use crate::results::{BuildRecord, ClockTicks, MemoryRecord, RaceRecord, Sampling};

/// A validation that takes longer is told of, where bars do not show: it is the only work that grows with what is stored.
const LONG_VALIDATION: Duration = Duration::from_secs(2);

/// The race of structures that are built.
const BUILDS: &str = "builds";

/// A structure with the contender that builds it. Several lanes trace it where they differ in trace parameters alone.
pub(super) struct Stall {
    pub contender: Contender,
    /// What it builds from: the session's viewpoint, at a resolution of its own if it has one.
    pub viewpoint: Viewpoint,
    /// How it follows an animation, if it does.
    pub follows: Option<Update>,
    /// Counted samples of its builds, or of its updates.
    pub builds: BuildSamples,
    statistics: BTreeMap<String, f64>,
}

/// Counted samples of what a structure takes, by round.
#[derive(Default)]
pub(super) struct BuildSamples {
    /// Phases of first builds, or of updates.
    pub phases: Vec<Timing>,
    /// First builds; none of what follows an animation.
    pub first: Vec<Timing>,
    /// Steady builds, or updates.
    pub steady: Vec<Timing>,
}

impl BuildSamples {
    pub fn push_first(&mut self, sample: BuildSample) {
        self.phases.push(sample.phases);
        self.first.push(sample.whole);
    }

    pub fn push_update(&mut self, sample: BuildSample) {
        self.phases.push(sample.phases);
        self.steady.push(sample.whole);
    }
}

/// One who traces: a control, or a contender that was asked for.
pub(super) struct Lane {
    /// None of a control.
    pub request: Option<TracerRequest>,
    pub control: Option<Control>,
    stall: usize,
    /// How often it traces in one sample.
    pub repeats: usize,
    /// What took it out of the race.
    pub out: Option<Refusal>,
}

impl Lane {
    /// Its name in records.
    pub fn label(&self) -> String {
        match (&self.request, self.control) {
            (Some(request), _) => records::request_record(request).label(),
            (None, Some(control)) => control.description().name.to_owned(),
            (None, None) => String::new(),
        }
    }
}

/// What came of one lane in one race.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Outcome<T> {
    /// It was measured.
    Measured(T),
    /// It was taken out.
    Out(Refusal),
    /// It had been taken out before.
    Absent,
}

/// What was found out about a structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Built {
    pub memory: MemoryRecord,
    pub structure_statistics: BTreeMap<String, f64>,
    pub build: BuildRecord,
}

/// What the race of the structures gave.
pub(crate) struct Structures {
    /// By lane; times name their race by its place here.
    pub outcomes: Vec<Outcome<Built>>,
    pub races: Vec<RaceRecord>,
}

/// Where a race is run.
#[derive(Clone)]
pub(crate) struct Setting<'a> {
    pub scene: String,
    pub viewpoint: String,
    pub window: u32,
    /// None where nothing is timed.
    pub kernels: Option<&'a Kernels>,
    /// Tells races of the same from one another.
    pub turn: usize,
}

/// One window in one place.
pub(crate) struct Race<'a> {
    pub(super) session: &'a Session,
    pub(super) film: Option<&'a Film>,
    pub(super) effort: Effort,
    pub(super) progress: &'a Progress,
    pub(super) setting: Setting<'a>,
    pub(super) stalls: Vec<Stall>,
    pub(super) lanes: Vec<Lane>,
}

impl<'a> Race<'a> {
    /// A race with the controls in its first lanes.
    pub fn new(
        session: &'a Session,
        film: Option<&'a Film>,
        effort: Effort,
        progress: &'a Progress,
        setting: Setting<'a>,
    ) -> Self {
        let mut race = Self { session, film, effort, progress, setting, stalls: Vec::new(), lanes: Vec::new() };
        for (control, contender) in session.controls() {
            race.enter(contender, None, Some(control));
        }
        race
    }

    /// Lets a contender take part, in a stall of its own.
    pub fn enter(&mut self, contender: Contender, request: Option<&Request>, control: Option<Control>) {
        let viewpoint = match request.and_then(|request| request.tracer.resolution) {
            Some(Resolution { frame, face }) => Viewpoint { frame, face, ..*self.session.viewpoint() },
            None => *self.session.viewpoint(),
        };
        let follows = request.and_then(|request| request.follows);
        self.stalls.push(Stall {
            contender,
            viewpoint,
            follows,
            builds: BuildSamples::default(),
            statistics: BTreeMap::new(),
        });
        self.join(request.map(|request| &request.tracer), control);
    }

    /// Lets another one trace the structure of the last stall.
    pub fn join(&mut self, request: Option<&TracerRequest>, control: Option<Control>) {
        self.lanes.push(Lane {
            request: request.cloned(),
            control,
            stall: self.stalls.len() - 1,
            repeats: 1,
            out: None,
        });
    }

    /// Takes a lane out.
    pub fn take_out(&mut self, lane: usize, refusal: Refusal) {
        self.lanes[lane].out.get_or_insert(refusal);
    }

    /// Whether any lane of a stall is still in.
    fn is_in(&self, stall: usize) -> bool {
        self.lanes.iter().any(|lane| lane.stall == stall && lane.out.is_none())
    }

    /// Does something with a stall unless it has failed before; a failure takes its lanes out.
    pub(super) fn attempt<R>(
        &mut self,
        stall: usize,
        work: impl FnOnce(&mut Stall) -> Result<R, TracerError>,
    ) -> Option<R> {
        if !self.is_in(stall) {
            return None;
        }
        let refusal = match work(&mut self.stalls[stall]) {
            Ok(done) => return Some(done),
            Err(error) => Refusal::of(&error, true),
        };
        for lane in self.lanes.iter_mut().filter(|lane| lane.stall == stall) {
            lane.out.get_or_insert_with(|| refusal.clone());
        }
        None
    }

    /// What sampling goes by; none where nothing is timed.
    fn sampling(&self) -> Option<Sampling> {
        self.effort.timed.then_some(self.effort.sampling)
    }

    /// The seed of the orders of a race, a number that JSON holds exactly.
    pub(super) fn order_seed(&self, work: &str, attempt: usize) -> u64 {
        let Setting { scene, viewpoint, window, turn, .. } = &self.setting;
        let words = format!("{} {scene} {viewpoint} {window} {work} {turn} {attempt}", self.effort.seed);
        u64::from_str_radix(&crate::hash::sha256_of(words.as_bytes())[..13], 16).unwrap_or_default()
    }

    /// Rounds of so many lanes, with the fixed kernels of the clocks that they are timed by.
    pub(super) fn rounds(
        &self,
        seed: u64,
        lanes: usize,
        stalls: impl Iterator<Item = usize> + Clone,
        sampling: Option<Sampling>,
    ) -> Rounds<'a> {
        let on = |stall: usize| match self.stalls[stall].contender.description.residency {
            Residency::Host => Side::Host,
            Residency::Device => Side::Device,
        };
        let kernels = self.setting.kernels.filter(|_| sampling.is_some());
        let sides =
            [Side::Host, Side::Device].into_iter().filter(|side| stalls.clone().any(|stall| on(stall) == *side));
        let kernels: Vec<(Side, &Kernels)> =
            sides.filter_map(|side| Some((side, kernels.filter(|kernels| kernels.have(side))?))).collect();
        Rounds::new(sampling, seed, lanes, &kernels)
    }

    /// The ticks of its clocks; none where nothing is timed.
    pub(super) fn ticks(&self) -> Option<ClockTicks> {
        self.setting.kernels.map(|kernels| kernels.ticks)
    }

    /// The record of a race; none where nothing was timed.
    pub(super) fn record(&self, work: &str, seed: u64, rounds: &Rounds<'_>, lanes: Vec<String>) -> Option<RaceRecord> {
        let Setting { scene, viewpoint, window, .. } = self.setting.clone();
        let kernels = rounds.kernels();
        Some(RaceRecord {
            scene,
            viewpoint,
            window,
            work: work.to_owned(),
            lanes,
            order_seed: seed,
            orders: rounds.orders.iter().map(|order| order.iter().map(|lane| *lane as u32).collect()).collect(),
            each_round: match work {
                BUILDS => "first builds, each with a rebuild behind it",
                UPDATES => "the next frame",
                _ => "the same rays",
            }
            .to_owned(),
            warm_up_rounds: 1,
            sampling: rounds.sampling?,
            ended_by: rounds.ended_by,
            sampled_s: rounds.sampled_s,
            widest_interval: rounds.widest_interval,
            drift: kernels.iter().any(|kernel| kernel.drifts),
            clock_ticks: self.ticks(),
            kernels,
            twice: Vec::new(),
            repeated_because: None,
        })
    }

    /// A stall in words: the first lane that traces it.
    pub(super) fn stall_label(&self, stall: usize) -> String {
        self.lanes.iter().find(|lane| lane.stall == stall).map_or_else(String::new, Lane::label)
    }

    /// Stalls of contenders: controls build nothing that is worth a look.
    fn is_contender(&self, stall: usize) -> bool {
        self.lanes.iter().any(|lane| lane.stall == stall && lane.control.is_none())
    }

    /// The stalls of contenders that are in, once for each who traces them.
    pub(super) fn contenders(&self) -> impl Iterator<Item = usize> + '_ {
        self.lanes.iter().filter(|lane| lane.control.is_none() && lane.out.is_none()).map(|lane| lane.stall)
    }

    /// Builds everything, or lets it follow the film, in rounds; then lets every structure be read back and checked.
    pub fn build(&mut self) -> Result<Structures, RunError> {
        let passes = self.film.map_or(0, |film| film.passes);
        let mut races: Vec<RaceRecord> = self.follow(passes)?.into_iter().collect();
        let of_updates = races.len();
        let still: Vec<usize> = (0..self.stalls.len()).filter(|stall| self.stalls[*stall].follows.is_none()).collect();
        let seed = self.order_seed(BUILDS, 0);
        let contenders: Vec<usize> = still.iter().copied().filter(|stall| self.is_contender(*stall)).collect();
        let mut rounds = self.rounds(seed, still.len(), contenders.iter().copied(), self.sampling());
        let bar = self.progress.bar(BUILDS, (rounds.least() * still.len()) as u64);
        let gpu = self.session.gpu();
        // Intervals are waited for of what is compared.
        while let Some(round) = rounds.next(gpu, || {
            let builds = contenders.iter().map(|stall| &self.stalls[*stall].builds);
            [
                builds.clone().map(|builds| &builds.first[..]).collect(),
                builds.map(|builds| &builds.steady[..]).collect(),
            ]
        })? {
            for place in round.order {
                self.build_once(still[place], round.counts);
                bar.inc(1);
            }
        }
        bar.finish_and_clear();
        races.extend(self.record(BUILDS, seed, &rounds, still.iter().map(|stall| self.stall_label(*stall)).collect()));
        if self.effort.validated {
            self.validate();
        }
        let end = self.session.end();
        // Structures that follow a film have a race of their own.
        let believed = [false, true].map(|follows| {
            let lots = self.stalls.iter().filter(|stall| stall.follows.is_some() == follows);
            records::are_believed(lots.map(|stall| &stall.builds.phases[..]))
        });
        let built = |stall: &Stall| {
            let believed = believed[usize::from(stall.follows.is_some())];
            let mut build = records::build_record(&stall.builds, believed, stall.contender.setup_ms);
            let race = if stall.follows.is_some() { 0 } else { of_updates };
            let race = (!stall.builds.phases.is_empty() && race < races.len()).then_some(race as u32);
            for times in build.all_mut() {
                times.void = self.ticks().and_then(|ticks| ticks.too_coarse(times));
                times.race = race;
            }
            Ok::<Built, TracerError>(Built {
                memory: records::memory_record(stall.contender.structure()?.memory(), end),
                structure_statistics: stall.statistics.clone(),
                build,
            })
        };
        let stalls = &self.stalls;
        let outcome = |lane: &Lane| match &lane.out {
            None => built(&stalls[lane.stall]).map(Outcome::Measured),
            Some(refusal) => Ok(Outcome::Out(refusal.clone())),
        };
        let outcomes = self.lanes.iter().map(outcome).collect::<Result<_, TracerError>>()?;
        Ok(Structures { outcomes, races })
    }

    /// Builds everything once more, as it was when the races before were run; nothing is timed.
    pub fn restore(&mut self) -> Result<(), RunError> {
        self.follow(0)?;
        for stall in 0..self.stalls.len() {
            if self.stalls[stall].follows.is_none() {
                self.build_once(stall, false);
            }
        }
        Ok(())
    }

    /// A first build and, where times are taken, a steady one behind it.
    fn build_once(&mut self, stall: usize, counts: bool) {
        let (session, timed) = (self.session, self.effort.timed);
        let built = self.attempt(stall, |one| {
            let first = one.contender.build(session.geometry(), &one.viewpoint, session.gpu())?;
            let mut again = || one.contender.update(Update::Rebuild, session.geometry(), &one.viewpoint, session.gpu());
            Ok((first, if timed { again()? } else { None }))
        });
        if let Some((first, steady)) = built.filter(|_| counts) {
            let builds = &mut self.stalls[stall].builds;
            builds.push_first(first);
            builds.steady.extend(steady.map(|steady| steady.whole));
        }
    }

    /// Lets every structure be read back and checked against the scene that it was last built over, outside of any time. What is
    /// unsound, or says of itself what is no number, is taken out. One that is reused was built over another one, where it is checked.
    fn validate(&mut self) {
        let bar = self.progress.bar("validate", self.stalls.len() as u64);
        let reused = |stall: &Stall| stall.follows == Some(Update::Reuse);
        for stall in (0..self.stalls.len()).filter(|stall| !reused(&self.stalls[*stall])).collect::<Vec<_>>() {
            let begin = Instant::now();
            let before: Vec<bool> = self.lanes.iter().map(|lane| lane.out.is_none()).collect();
            let session = self.session;
            let statistics = self.attempt(stall, |one| {
                let found = sound::statistics(one.contender.structure()?, session.geometry())?;
                Ok(found.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
            });
            self.stalls[stall].statistics = statistics.unwrap_or_default();
            // What is unsound is so with or without others beside it.
            for (lane, _) in self.lanes.iter_mut().zip(before).filter(|(_, was_in)| *was_in) {
                if let Some(refusal) = &mut lane.out {
                    refusal.for_room = false;
                }
            }
            bar.inc(1);
            if begin.elapsed() > LONG_VALIDATION {
                let name = self.stalls[stall].contender.description.name;
                self.progress.say(&format!("  validated {name} in {:.0} s", begin.elapsed().as_secs_f64()));
            }
        }
    }

    /// The contender that a lane traces by, told the lane's own parameters.
    pub(super) fn contender(&mut self, lane: usize) -> &Contender {
        let Lane { request, stall, .. } = &self.lanes[lane];
        let contender = &mut self.stalls[*stall].contender;
        if let Some(request) = request {
            contender.parameters.clone_from(&request.parameters);
        }
        contender
    }

    /// Does something in a lane unless it has failed before; a failure takes it out.
    pub(super) fn attempt_in<R>(
        &mut self,
        lane: usize,
        work: impl FnOnce(&Session, &Contender) -> Result<R, TracerError>,
    ) -> Option<R> {
        if self.lanes[lane].out.is_some() {
            return None;
        }
        let session = self.session;
        match work(session, self.contender(lane)) {
            Ok(done) => Some(done),
            Err(error) => {
                self.take_out(lane, Refusal::of(&error, true));
                None
            }
        }
    }
}

impl Refusal {
    /// Why a tracer was taken out. `for_room`: it may have been for want of room beside others.
    pub fn of(error: &TracerError, for_room: bool) -> Self {
        let too_large = matches!(error, TracerError::TooLarge { .. });
        let unavailable = matches!(error, TracerError::Unavailable(_));
        // Limits of a device are the same with or without others.
        let for_room = for_room && matches!(error, TracerError::Failed(_));
        Self { reason: error.to_string(), too_large, unavailable, for_room }
    }

    pub(super) fn of_session(error: &SessionError) -> Self {
        Self { reason: error.to_string(), too_large: false, unavailable: false, for_room: false }
    }
}
