//! Whether the clock tells the same from the slower: a tracer raced against itself, and against itself with more to do.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::measure::{self, Context, RunError, Trial};
use crate::plan::Plan;
use crate::rays::sampling::Stream;
use crate::results::{Answer, Doubt, Paired};

/// Traces of a sample, so that what is slower by a few percent is a whole number of them.
pub const REPEATS: usize = 20;

/// Within this share two are said to be the same.
const MARGIN: f64 = 0.05;

/// What is tried.
#[derive(Clone, Copy, Debug)]
pub struct ClockTrial {
    /// Races.
    pub races: usize,
    /// Traces that the slowed one does for every twenty of the others.
    pub slowed: usize,
    /// Threads of another job beside.
    pub load: usize,
}

/// What came of it.
pub struct ClockFound {
    tried: ClockTrial,
    tracer: String,
    trials: Vec<Trial>,
}

/// How often what was said.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// The first takes longer.
    pub longer: usize,
    /// It takes shorter.
    pub shorter: usize,
    /// They are the same.
    pub same: usize,
    /// Nobody can tell, and why.
    pub undecided: Vec<Doubt>,
}

impl Tally {
    fn add(mut self, answer: Answer) -> Self {
        match answer {
            Answer::Longer => self.longer += 1,
            Answer::Shorter => self.shorter += 1,
            Answer::Same => self.same += 1,
            Answer::Undecided(doubt) => self.undecided.push(doubt),
        }
        self
    }

    fn words(&self) -> String {
        let mut reasons: Vec<(String, usize)> = Vec::new();
        for reason in self.undecided.iter().map(Doubt::to_string) {
            match reasons.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, count)) => *count += 1,
                None => reasons.push((reason, 1)),
            }
        }
        let reasons: Vec<String> = reasons.iter().map(|(reason, count)| format!("{count}: {reason}")).collect();
        let why = if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join("; ")) };
        let Self { longer, shorter, same, undecided } = self;
        format!("longer {longer}, shorter {shorter}, the same {same}, undecided {}{why}", undecided.len())
    }
}

/// Runs the races; the slowed one stands last.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn execute(plan: &Plan, tried: ClockTrial, context: &Context<'_>) -> Result<ClockFound, RunError> {
    let repeats = [REPEATS, REPEATS, tried.slowed];
    let trials = beside(tried.load, plan.seed, || measure::against_itself(plan, &repeats, tried.races, context))?;
    let tracer = plan.tracers.first().map_or("", |request| request.name()).to_owned();
    Ok(ClockFound { tried, tracer, trials })
}

/// The times of contenders that are all the same, one line a round, in the order in which they were sampled.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn record(plan: &Plan, kind: &str, load: usize, context: &Context<'_>) -> Result<String, RunError> {
    let trials = beside(load, plan.seed, || measure::against_itself(plan, &[1; RECORDED], 1, context))?;
    let mut text = String::new();
    for trial in &trials {
        let first = trial.race.lanes.len() - RECORDED - trial.race.twice.len();
        let kernel = trial.race.kernels.first().map_or(&[][..], |kernel| &kernel.samples_ms);
        for (round, order) in trial.race.orders.iter().enumerate() {
            let _ = write!(text, "{kind},{:.4}", kernel.get(round).copied().unwrap_or_default());
            let slots = order.iter().filter_map(|lane| trial.samples_ms.get((*lane as usize).checked_sub(first)?));
            for samples in slots {
                let _ = write!(text, ",{:.4}", samples[round]);
            }
            text.push('\n');
        }
    }
    Ok(text)
}

/// How many times as long fresh rays take as the same ones at once again, in words.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn repeats(plan: &Plan, seeds: u64, context: &Context<'_>) -> Result<String, RunError> {
    let [fresh, repeated] = measure::fresh_and_repeated(plan, seeds, context)?;
    let found = Paired::in_race(&fresh, &repeated, None, None);
    let said = match found.answer(MARGIN) {
        Answer::Longer => "fresh rays take longer".to_owned(),
        Answer::Shorter => "fresh rays take shorter".to_owned(),
        Answer::Same => "the same".to_owned(),
        Answer::Undecided(doubt) => format!("undecided: {doubt}"),
    };
    let ratio = found.ratio.map_or_else(String::new, |ratio| {
        let [low, high] = ratio.interval;
        format!("{:.3} times as long [{low:.3}, {high:.3}], ", ratio.value)
    });
    let name = plan.tracers.first().map_or("", |request| request.name());
    let set = plan.ray_sets.first().map_or("", |set| set.name);
    let rounds = fresh.len();
    Ok(format!(
        "{name}, {set}: rays of {seeds} seeds in turn over the same rays again, {rounds} rounds: {ratio}{said}\n"
    ))
}

/// Contenders of a recording.
const RECORDED: usize = 4;

impl ClockFound {
    /// What was said of the equal ones, and of the slowed one beside the first.
    pub fn tallies(&self) -> [Tally; 2] {
        let said = |lane: usize| {
            let answer = |trial: &Trial| {
                let drift = trial.race.drift.then(|| trial.race.work.clone());
                let (one, other) = (&trial.samples_ms[lane], &trial.samples_ms[0]);
                Paired::in_race(one, other, drift, trial.void.clone()).answer(MARGIN)
            };
            self.trials.iter().map(answer).fold(Tally::default(), Tally::add)
        };
        [said(1), said(2)]
    }

    /// In words.
    pub fn text(&self) -> String {
        let [equal, slowed] = self.tallies();
        let rounds = |pick: fn(usize, usize) -> usize| {
            let all = self.trials.iter().map(|trial| trial.race.orders.len());
            all.reduce(pick).unwrap_or(0)
        };
        let share = (self.tried.slowed as f64 / REPEATS as f64 - 1.0) * 100.0;
        format!(
            "{}: {} races of {} to {} rounds, {} threads of another job beside\n  equal: {}\n  slowed by {share:.1} %: {}\n",
            self.tracer,
            self.trials.len(),
            rounds(usize::min),
            rounds(usize::max),
            self.tried.load,
            equal.words(),
            slowed.words(),
        )
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
