//! Trials: which pose is tried next, and how many rays are wrong there. A trial depends on the seed and on earlier ones alone, so that a
//! longer search begins with the shorter one.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};
use tracebench_api::{Hit, TracerError};

use super::poses::Candidate;
use super::{Search, Stopped};
use crate::measure::session::{PreparedRays, Session, SessionError};
use crate::measure::{self, TracerConfig};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::rays::sampling::Stream;
use crate::truth::Cache;

/// Random poses from whose worst a climb begins.
const DRAWN: u32 = 12;
/// Each so manieth climb begins from the worst pose so far.
const FROM_WORST: usize = 3;
/// Steps of a climb: the first, and by how much they grow where it gets worse and shrink where it does not.
const FIRST_STEP: f64 = 0.5;
const LONGER: f64 = 1.5;
const SHORTER: f64 = 0.85;
/// A climb is over after so many steps without getting worse.
const PATIENCE: u32 = 20;

/// Poses near another one, and random ones, that are drawn before it is given up to find an admissible one.
const NEAR_DRAWS: u32 = 64;
const ANY_DRAWS: u32 = 1000;

/// Tags of the streams.
const SEARCH_TAG: u64 = 20;
const RANDOM_TAG: u64 = 21;

/// A pose that was tried.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Trial {
    pub candidate: Candidate,
    /// Wrong rays.
    pub wrong: u64,
    /// Rays that could be.
    pub judged: u64,
}

impl Trial {
    /// By the share of wrong rays.
    pub(super) fn compare(&self, other: &Self) -> Ordering {
        (self.wrong * other.judged).cmp(&(other.wrong * self.judged))
    }

    /// The worse of two, the first of equal ones.
    pub(super) fn worse(self, other: Self) -> Self {
        if other.compare(&self).is_gt() { other } else { self }
    }
}

/// What has been tried.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Trials {
    pub searched: Vec<Trial>,
    pub random: Vec<Trial>,
    /// Whether none follows.
    pub is_done: bool,
}

/// A climb from the worst of some random poses, step by step.
struct Climb {
    drawn: u32,
    worst: Option<Trial>,
    failed: u32,
    step: f64,
}

impl Climb {
    fn from(worst: Option<Trial>) -> Self {
        Self { drawn: if worst.is_some() { DRAWN } else { 0 }, worst, failed: 0, step: FIRST_STEP }
    }

    fn take(&mut self, trial: Trial) {
        let is_worse = self.worst.is_none_or(|worst| trial.compare(&worst).is_gt());
        self.worst = if is_worse { Some(trial) } else { self.worst };
        if self.drawn < DRAWN {
            self.drawn += 1;
        } else if is_worse {
            (self.failed, self.step) = (0, (self.step * LONGER).min(1.0));
        } else {
            (self.failed, self.step) = (self.failed + 1, self.step * SHORTER);
        }
    }
}

/// The climbs that trials make up; the last one goes on.
fn replayed(trials: &[Trial]) -> Vec<Climb> {
    let (mut all, mut climb, mut worst) = (Vec::new(), Climb::from(None), None::<Trial>);
    for trial in trials {
        worst = Some(worst.map_or(*trial, |worst| worst.worse(*trial)));
        climb.take(*trial);
        if climb.failed == PATIENCE {
            let next = (all.len() + 2).is_multiple_of(FROM_WORST);
            all.push(std::mem::replace(&mut climb, Climb::from(worst.filter(|_| next))));
        }
    }
    all.push(climb);
    all
}

/// The worst pose of every climb.
pub(super) fn climbs(trials: &[Trial]) -> Vec<Trial> {
    replayed(trials).into_iter().filter_map(|climb| climb.worst).collect()
}

impl Search<'_> {
    /// The trial that follows others.
    pub(super) fn next(&self, config: &mut TracerConfig, trials: &[Trial]) -> Result<Trial, Stopped> {
        let mut stream = Stream::new(self.plan.seed, SEARCH_TAG, trials.len() as u64);
        if let Some(Climb { drawn: DRAWN, worst: Some(worst), step, .. }) = replayed(trials).pop() {
            for _ in 0..NEAR_DRAWS {
                let candidate = self.poses.near(&worst.candidate, step, &mut stream)?;
                if let Some(trial) = self.attempt(config, candidate)? {
                    return Ok(trial);
                }
            }
        }
        self.any(config, stream)
    }

    /// The random trial of a number.
    pub(super) fn random(&self, config: &mut TracerConfig, number: usize) -> Result<Trial, Stopped> {
        self.any(config, Stream::new(self.plan.seed, RANDOM_TAG, number as u64))
    }

    fn any(&self, config: &mut TracerConfig, mut stream: Stream) -> Result<Trial, Stopped> {
        for _ in 0..ANY_DRAWS {
            let candidate = self.poses.any(&mut stream)?;
            if let Some(trial) = self.attempt(config, candidate)? {
                return Ok(trial);
            }
        }
        let reason = format!(
            "no admissible pose: {ANY_DRAWS} in the bounds are within 0.01 diagonals of a surface, or less than 5 % of rays hit from there, or \
             more than 6 % are ambiguous; take other rays or another scene"
        );
        Err(Stopped::Skipped(false, reason))
    }

    /// Traces from a pose, if it is admissible.
    fn attempt(&self, config: &mut TracerConfig, candidate: Candidate) -> Result<Option<Trial>, Stopped> {
        let Some(pose) = self.poses.admissible(&candidate)? else { return Ok(None) };
        let plan = Plan { ray_sets: vec![*self.set], ..self.poses.plan(&candidate, self.plan) };
        let seen = self.poses.truth(&candidate)?.seen_from(&plan, pose, &Cache::none(), &Progress::new(true))?;
        let session = &seen.session;
        let Some(rays) = session.rays.first().filter(|rays| self.poses.has_enough(rays)) else { return Ok(None) };
        let mut ask = || -> Result<_, SessionError> {
            session.sample_build(config)?;
            session.classes(config.description.name, rays, self.options.rule, &answers(session, config, rays)?)
        };
        let refused = |error: SessionError| Stopped::Skipped(true, format!("at --view {}: {error}", candidate.view()));
        let classes = ask().map_err(refused)?;
        let wrong = classes.iter().flatten().filter(|class| !class.is_right()).count() as u64;
        let judged = classes.iter().flatten().count() as u64;
        Ok(Some(Trial { candidate, wrong, judged }))
    }
}

/// What a structure answers.
pub(super) fn answers(session: &Session, config: &TracerConfig, rays: &PreparedRays) -> Result<Vec<Hit>, TracerError> {
    measure::trace_sample(config, &rays.buffer, session.trace_to, session.gpu(), 1).map(|traced| traced.hits)
}
