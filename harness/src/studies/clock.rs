//! Whether the clock tells the same from the slower: a tracer raced against itself, and against itself with more to do.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::machine;
use crate::measure::{self, Context, RunError, Trial};
use crate::plan::Plan;
use crate::rays::sampling::Stream;
use crate::results::{Answer, Paired, Provenance};

/// Traces of a sample, so that what is slower by a few percent is a whole number of them.
pub const REPEATS: usize = 20;

/// Within this share two are said to be the same.
const MARGIN: f64 = 0.05;

/// What is tried.
#[derive(Clone, Copy, Debug)]
pub struct ClockTrial {
    /// Interleaved sets.
    pub interleaved_sets: usize,
    /// Traces that the slowed one does for every twenty of the others.
    pub slowed: usize,
    /// Threads of another job beside.
    pub load: usize,
}

/// What is in `clock.json`.
#[derive(Debug, Serialize)]
pub struct ClockRecord {
    /// Where, by which program, when.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// The tracer.
    pub tracer: String,
    /// What it was made by, as a row's.
    pub fingerprint: Option<&'static str>,
    /// The scene.
    pub scene: String,
    /// The ray set.
    pub rays: String,
    /// The run preset, which sets rays and resolutions.
    pub preset: String,
    /// What came of it.
    #[serde(flatten)]
    pub found: ClockFound,
}

/// What came of it.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ClockFound {
    /// Of interleaved sets against itself.
    InterleavedSets {
        /// Interleaved sets.
        count: usize,
        /// Rounds of the shortest and of the longest interleaved set.
        rounds: [usize; 2],
        /// Threads of another job beside.
        load_threads: usize,
        /// How much more the slowed one has to do, percent.
        slowed_by_percent: f64,
        /// What was said of the equal ones.
        equal: Tally,
        /// What was said of the slowed one beside the first.
        slowed: Tally,
    },
    /// Of fresh rays beside repeated ones.
    FreshRays {
        /// Seeds that took turns.
        seeds: u64,
        /// Rounds.
        rounds: usize,
        /// How many times as long fresh rays take, with the interval that covers it.
        fresh_over_repeated: Option<f64>,
        /// Its interval.
        interval: Option<[f64; 2]>,
        /// What is said of it.
        said: String,
    },
}

/// How often what was said.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// The first takes longer.
    pub longer: usize,
    /// It takes shorter.
    pub shorter: usize,
    /// They are the same.
    pub same: usize,
    /// Nobody can tell.
    pub undecided: usize,
    /// Why, and how often that was said.
    pub reasons: Vec<(String, usize)>,
}

impl Tally {
    fn add(mut self, answer: Answer) -> Self {
        match answer {
            Answer::Longer => self.longer += 1,
            Answer::Shorter => self.shorter += 1,
            Answer::Same => self.same += 1,
            Answer::Undecided(caveat) => {
                let reason = caveat.to_string();
                self.undecided += 1;
                match self.reasons.iter_mut().find(|(known, _)| *known == reason) {
                    Some((_, count)) => *count += 1,
                    None => self.reasons.push((reason, 1)),
                }
            }
        }
        self
    }

    fn describe(&self) -> String {
        let Self { longer, shorter, same, undecided, reasons } = self;
        let reasons: Vec<String> = reasons.iter().map(|(reason, count)| format!("{count}: {reason}")).collect();
        let why = if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join("; ")) };
        format!("longer {longer}, shorter {shorter}, the same {same}, undecided {undecided}{why}")
    }
}

/// Runs the interleaved sets; the slowed one stands last.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn execute(plan: &Plan, tried: ClockTrial, context: &Context<'_>) -> Result<ClockFound, RunError> {
    let repeats = [REPEATS, REPEATS, tried.slowed];
    let trials =
        beside(tried.load, plan.seed, || measure::against_itself(plan, &repeats, tried.interleaved_sets, context))?;
    // Of the equal ones, and of the slowed one beside the first.
    let [equal, slowed] = [1, 2].map(|lane| {
        let answer = |trial: &Trial| {
            let drift = trial.interleaved_set.drift.then(|| trial.interleaved_set.work.clone());
            let [one, other] = [lane, 0].map(|lane| &trial.traces[lane].times);
            let invalid = other.invalid.clone();
            Paired::in_interleaved_set(&one.samples_ms, &other.samples_ms, drift, invalid).answer(MARGIN)
        };
        trials.iter().map(answer).fold(Tally::default(), Tally::add)
    });
    let rounds = |pick: fn(usize, usize) -> usize| {
        trials.iter().map(|trial| trial.interleaved_set.orders.len()).reduce(pick).unwrap_or(0)
    };
    Ok(ClockFound::InterleavedSets {
        count: trials.len(),
        rounds: [rounds(usize::min), rounds(usize::max)],
        load_threads: tried.load,
        slowed_by_percent: (tried.slowed as f64 / REPEATS as f64 - 1.0) * 100.0,
        equal,
        slowed,
    })
}

/// The times of configurations that are all the same, one line a round, in the order in which they were sampled.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn record(plan: &Plan, kind: &str, load: usize, context: &Context<'_>) -> Result<String, RunError> {
    let trials = beside(load, plan.seed, || measure::against_itself(plan, &[1; RECORDED], 1, context))?;
    let mut text = String::new();
    for trial in &trials {
        let first = trial.interleaved_set.participants.len() - RECORDED - trial.interleaved_set.doubled_work.len();
        let kernel = trial.interleaved_set.kernels.first().map_or(&[][..], |kernel| &kernel.samples_ms);
        for (round, order) in trial.interleaved_set.orders.iter().enumerate() {
            let _ = write!(text, "{kind},{:.4}", kernel.get(round).copied().unwrap_or_default());
            let slots = order.iter().filter_map(|lane| trial.traces.get((*lane as usize).checked_sub(first)?));
            for trace in slots {
                let _ = write!(text, ",{:.4}", trace.times.samples_ms[round]);
            }
            text.push('\n');
        }
    }
    Ok(text)
}

/// How many times as long fresh rays take as the same ones at once again.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn repeats(plan: &Plan, seeds: u64, context: &Context<'_>) -> Result<ClockFound, RunError> {
    let [fresh, repeated] = measure::fresh_and_repeated(plan, seeds, context)?;
    let found = Paired::in_interleaved_set(&fresh, &repeated, None, None);
    let said = match found.answer(MARGIN) {
        Answer::Longer => "fresh rays take longer".to_owned(),
        Answer::Shorter => "fresh rays take shorter".to_owned(),
        Answer::Same => "the same".to_owned(),
        Answer::Undecided(caveat) => format!("undecided: {caveat}"),
    };
    let (rounds, fresh_over_repeated) = (fresh.len(), found.ratio.as_ref().map(|ratio| ratio.value));
    let interval = found.ratio.map(|ratio| ratio.interval);
    Ok(ClockFound::FreshRays { seeds, rounds, fresh_over_repeated, interval, said })
}

/// Configurations of a recording.
const RECORDED: usize = 4;

impl ClockRecord {
    /// Of a plan's first tracer, scene and ray set.
    pub fn new(provenance: Provenance, plan: &Plan, found: ClockFound) -> Self {
        let named = |name: Option<&str>| name.unwrap_or_default().to_owned();
        let tracer = named(plan.tracers.first().map(|request| request.name()));
        Self {
            provenance,
            fingerprint: machine::fingerprint(&tracer),
            tracer,
            scene: plan.scenes.first().map(ToString::to_string).unwrap_or_default(),
            rays: named(plan.ray_sets.first().map(|set| set.name)),
            preset: plan.preset.name.to_owned(),
            found,
        }
    }

    /// In words.
    pub fn text(&self) -> String {
        let (tracer, rays) = (&self.tracer, &self.rays);
        match &self.found {
            ClockFound::InterleavedSets { count, rounds, load_threads, slowed_by_percent, equal, slowed } => {
                let ([least, most], [equal, slowed]) = (rounds, [equal, slowed].map(Tally::describe));
                format!(
                    "{tracer}: {count} interleaved sets of {least} to {most} rounds, {load_threads} threads of another job beside\n  \
                     equal: {equal}\n  slowed by {slowed_by_percent:.1} %: {slowed}\n"
                )
            }
            ClockFound::FreshRays { seeds, rounds, fresh_over_repeated, interval, said } => {
                let ratio = fresh_over_repeated.zip(*interval).map_or_else(String::new, |(value, [low, high])| {
                    format!("{value:.3} times as long [{low:.3}, {high:.3}], ")
                });
                format!(
                    "{tracer}, {rays}: rays of {seeds} seeds in turn over the same rays again, {rounds} rounds: {ratio}{said}\n"
                )
            }
        }
    }
}

/// Does something while threads of another job come and go: each works and rests for up to 200 ms in turn.
fn beside<R>(threads: usize, seed: u64, work: impl FnOnce() -> R) -> R {
    const LONGEST_MS: f64 = 200.0;
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let ended = &ended;
            scope.spawn(move || {
                let mut stream = Stream::new(seed, 0x10ad, thread as u64);
                while !ended.load(Ordering::Relaxed) {
                    let span = |stream: &mut Stream| Duration::from_secs_f64(stream.unit() * LONGEST_MS / 1e3);
                    let (until, rest) = (Instant::now() + span(&mut stream), span(&mut stream));
                    while Instant::now() < until {
                        std::hint::black_box(tracebench_kit::fixed_task(thread as u32));
                    }
                    std::thread::sleep(rest);
                }
            });
        }
        let done = work();
        ended.store(true, Ordering::Relaxed);
        done
    })
}
