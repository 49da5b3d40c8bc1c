//! The race: contenders and controls of one window in one place, sampled in turn.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use tracebench_api::{Geometry, Hit, HitBuffer, Timing, TracerError, Update, Viewpoint};

use super::controls::Control;
use super::place::{Effort, Film, Refusal, Request};
use super::records::{self, Traced};
use super::session::{PreparedRays, Session, SessionError};
use super::{Contender, RunError};
use crate::plan::{Resolution, TracerRequest};
use crate::progress::Progress;
use crate::results::{BuildRecord, MemoryRecord, TraceRecord};

/// A validation that takes longer is told of, where bars do not show: it is the only work that grows with what is stored.
const LONG_VALIDATION: Duration = Duration::from_secs(2);

/// A structure with the contender that builds it. Several lanes trace it where they differ in trace parameters alone.
struct Stall {
    contender: Contender,
    /// What it builds from: the session's viewpoint, at a resolution of its own if it has one.
    viewpoint: Viewpoint,
    /// How it follows an animation, if it does.
    follows: Option<Update>,
    /// Counted samples of its builds, or of its updates.
    builds: Vec<Timing>,
    statistics: BTreeMap<String, f64>,
}

/// One who traces: a control, or a contender that was asked for.
struct Lane {
    /// None of a control.
    request: Option<TracerRequest>,
    control: Option<Control>,
    stall: usize,
    /// What took it out of the race.
    out: Option<Refusal>,
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

/// What the race of a ray set gave.
pub(crate) struct Answered {
    pub outcomes: Vec<Outcome<TraceRecord>>,
    /// Every lane's answers.
    pub hits: Vec<Option<Vec<Hit>>>,
    /// What a control scored wrongly.
    pub void: Option<String>,
}

/// One window in one place.
pub(crate) struct Race<'a> {
    session: &'a Session,
    film: Option<&'a Film>,
    effort: Effort,
    progress: &'a Progress,
    stalls: Vec<Stall>,
    lanes: Vec<Lane>,
}

impl<'a> Race<'a> {
    /// A race with the controls in its first lanes.
    pub fn new(session: &'a Session, film: Option<&'a Film>, effort: Effort, progress: &'a Progress) -> Self {
        let mut race = Self { session, film, effort, progress, stalls: Vec::new(), lanes: Vec::new() };
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
        self.stalls.push(Stall { contender, viewpoint, follows, builds: Vec::new(), statistics: BTreeMap::new() });
        self.join(request.map(|request| &request.tracer), control);
    }

    /// Lets another one trace the structure of the last stall.
    pub fn join(&mut self, request: Option<&TracerRequest>, control: Option<Control>) {
        self.lanes.push(Lane { request: request.cloned(), control, stall: self.stalls.len() - 1, out: None });
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
    fn attempt<R>(&mut self, stall: usize, work: impl FnOnce(&mut Stall) -> Result<R, TracerError>) -> Option<R> {
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

    /// The rounds of a kind of work: one to warm up, then the counted ones; where nothing is timed a single one.
    fn rounds(&self) -> usize {
        if self.effort.timed { self.effort.samples + 1 } else { 1 }
    }

    /// Whether a round's times count.
    fn counts(&self, round: usize) -> bool {
        self.effort.timed && round > 0
    }

    /// Builds everything, or lets it follow the film, in turn; then lets every structure be read back and checked.
    pub fn build(&mut self) -> Result<Vec<Outcome<Built>>, RunError> {
        let passes = self.film.map_or(0, |film| film.passes);
        self.follow(passes)?;
        let still: Vec<usize> = (0..self.stalls.len()).filter(|stall| self.stalls[*stall].follows.is_none()).collect();
        let bar = self.progress.bar("builds", (self.rounds() * still.len()) as u64);
        for round in 0..self.rounds() {
            for stall in &still {
                self.build_once(*stall, self.counts(round));
                bar.inc(1);
            }
        }
        bar.finish_and_clear();
        if self.effort.validated {
            self.validate();
        }
        let end = self.session.end();
        let built = |stall: &Stall| {
            Ok::<Built, TracerError>(Built {
                memory: records::memory_record(stall.contender.structure()?.memory(), end),
                structure_statistics: stall.statistics.clone(),
                build: records::build_record(&stall.builds, stall.contender.setup_ms),
            })
        };
        let stalls = &self.stalls;
        let outcome = |lane: &Lane| match &lane.out {
            None => built(&stalls[lane.stall]).map(Outcome::Measured),
            Some(refusal) => Ok(Outcome::Out(refusal.clone())),
        };
        Ok(self.lanes.iter().map(outcome).collect::<Result<_, TracerError>>()?)
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

    fn build_once(&mut self, stall: usize, counts: bool) {
        let session = self.session;
        let built = self.attempt(stall, |one| one.contender.build(session.geometry(), &one.viewpoint, session.gpu()));
        if let Some(timing) = built.filter(|_| counts) {
            self.stalls[stall].builds.push(timing);
        }
    }

    /// Lets those follow the film who do: one pass to warm up, then the counted ones; every pass begins with fresh builds over
    /// the first frame, outside of the times.
    fn follow(&mut self, passes: u32) -> Result<(), RunError> {
        let Some(film) = self.film else { return Ok(()) };
        let followers: Vec<usize> =
            (0..self.stalls.len()).filter(|stall| self.stalls[*stall].follows.is_some()).collect();
        let gpu = self.session.gpu();
        let (triangles, materials) = (film.triangles.clone(), film.materials.clone());
        let mut geometry = Geometry::with_materials(film.positions[0].clone(), triangles, materials, gpu)?;
        let steps = film.positions.len() as u64 * followers.len() as u64;
        let bar = self.progress.bar("updates", steps * (u64::from(passes) + 1));
        for pass in 0..=passes {
            for (frame, positions) in film.positions.iter().enumerate() {
                geometry = geometry.moved_to(positions.clone(), gpu)?;
                for stall in &followers {
                    let timing = self.attempt(*stall, |one| match (frame, one.follows) {
                        (0, _) | (_, None) => one.contender.build(&geometry, &one.viewpoint, gpu),
                        (_, Some(update)) => one.contender.update(update, &geometry, &one.viewpoint, gpu),
                    });
                    if let Some(timing) = timing.filter(|_| pass > 0 && frame > 0) {
                        self.stalls[*stall].builds.push(timing);
                    }
                    bar.inc(1);
                }
            }
        }
        Ok(())
    }

    /// Lets every structure be read back and checked against the scene that it was last built over, outside of any time. What is unsound, or says of itself what is no
    /// number, is taken out.
    fn validate(&mut self) {
        let bar = self.progress.bar("validate", self.stalls.len() as u64);
        for stall in 0..self.stalls.len() {
            let begin = Instant::now();
            let before: Vec<bool> = self.lanes.iter().map(|lane| lane.out.is_none()).collect();
            let session = self.session;
            let statistics = self.attempt(stall, |one| {
                let found = one.contender.structure()?.validate(session.geometry())?;
                match found.iter().find(|(_, value)| !value.is_finite()) {
                    Some((name, value)) => {
                        Err(TracerError::Failed(format!("its structure says that {name} is {value}")))
                    }
                    None => Ok(found.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()),
                }
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
    fn contender(&mut self, lane: usize) -> &Contender {
        let Lane { request, stall, .. } = &self.lanes[lane];
        let contender = &mut self.stalls[*stall].contender;
        if let Some(request) = request {
            contender.parameters.clone_from(&request.parameters);
        }
        contender
    }

    /// Does something in a lane unless it has failed before; a failure takes it out.
    fn attempt_in<R>(
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

    /// One trace each to warm up, then rounds over all lanes; the last timed output is judged.
    pub fn trace(&mut self, rays: &PreparedRays) -> Result<Answered, RunError> {
        let was_in: Vec<bool> = self.lanes.iter().map(|lane| lane.out.is_none()).collect();
        let count = self.lanes.len();
        let bar = self.progress.bar(&format!("trace {}", rays.set.name), (self.rounds() * count) as u64);
        let mut buffers: Vec<Option<HitBuffer>> = Vec::new();
        for lane in 0..count {
            buffers.push(self.attempt_in(lane, |session, contender| session.hit_buffer(contender, rays)));
        }
        let mut timings: Vec<Vec<Timing>> = vec![Vec::new(); count];
        for round in 0..self.rounds() {
            for lane in 0..count {
                bar.inc(1);
                let Some(hits) = &mut buffers[lane] else { continue };
                let timing = self.attempt_in(lane, |session, contender| session.sample_trace(contender, rays, hits));
                timings[lane].extend(timing.filter(|_| self.counts(round)));
            }
        }
        bar.finish_and_clear();
        // Finding the causes of many wrong rays takes as long as telling the truth of as many.
        let bar = self.progress.bar(&format!("judge {}", rays.set.name), count as u64);
        let mut answered = Answered { outcomes: Vec::new(), hits: Vec::new(), void: None };
        for (lane, (buffer, timings)) in buffers.into_iter().zip(timings).enumerate() {
            bar.inc(1);
            let judged = buffer.and_then(|buffer| self.judge(lane, rays, &buffer, &timings).transpose()).transpose()?;
            let outcome = match (judged, &self.lanes[lane].out) {
                (Some((record, hits, void)), _) => {
                    answered.hits.push(Some(hits));
                    answered.void = answered.void.or(void);
                    answered.outcomes.push(Outcome::Measured(record));
                    continue;
                }
                (None, Some(refusal)) if was_in[lane] => Outcome::Out(refusal.clone()),
                (None, _) => Outcome::Absent,
            };
            answered.hits.push(None);
            answered.outcomes.push(outcome);
        }
        Ok(answered)
    }

    /// Judges a lane's last output; `None` if it was taken out. Beside the record the hits, and what it scored wrongly, if it is
    /// a control.
    #[expect(clippy::type_complexity, reason = "taken apart by its one caller")]
    fn judge(
        &mut self,
        lane: usize,
        rays: &PreparedRays,
        buffer: &HitBuffer,
        timings: &[Timing],
    ) -> Result<Option<(TraceRecord, Vec<Hit>, Option<String>)>, RunError> {
        let counted = self.effort.counted;
        let read = self.attempt_in(lane, |session, contender| {
            let (hits, surfaces) = (buffer.read(session.gpu())?, buffer.read_surfaces(session.gpu())?);
            let counters = if counted { session.count(contender, rays, &hits, &surfaces)? } else { Vec::new() };
            Ok((hits, surfaces, counters, session.trace_memory(contender, rays)?))
        });
        let Some((hits, surfaces, counters, trace_memory)) = read else { return Ok(None) };
        let session = self.session;
        let contender = self.contender(lane);
        let judged = session
            .judge(contender, rays, &hits)
            .and_then(|judgement| Ok((judgement, session.judge_surfaces(contender, rays, &hits, &surfaces)?)));
        let (mut judgement, surfaces) = match judged {
            Ok(judged) => judged,
            Err(error) if self.effort.lenient => {
                self.take_out(lane, Refusal::of_session(&error));
                return Ok(None);
            }
            Err(error) => return Err(error.into()),
        };
        let mut void = None;
        if let Some(control) = self.lanes[lane].control {
            let (occluded, free) = rays.hits_and_misses();
            let of_hits = control.check(&judgement, occluded, free);
            let of_surfaces = surfaces.as_ref().map_or(Ok(()), |each| control.check_surfaces(each, occluded, free));
            void = of_hits.and(of_surfaces).err();
            // What a control gets wrong it gets wrong by design.
            judgement.wrong_rays_mut().clear();
        } else if let Some(request) = self.lanes[lane].request.as_ref().filter(|_| self.effort.timed) {
            let label = records::request_record(request).label();
            self.progress.say(&format!("  {}: {label} done", rays.set.name));
        }
        let end = session.end();
        let record = records::trace_record(Traced {
            rays,
            timings,
            hits: &hits,
            counters: &counters,
            trace_memory,
            end,
            judgement,
            surfaces,
        });
        Ok(Some((record, hits, void)))
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

    fn of_session(error: &SessionError) -> Self {
        Self { reason: error.to_string(), too_large: false, unavailable: false, for_room: false }
    }
}
