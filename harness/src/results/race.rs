//! What a record says of its races: who was timed in which order, how long sampling went on, and whether its times may be believed.

use serde::{Deserialize, Serialize};
use tracebench_api::ClockKind;

/// Rounds below which no verdict rests on times.
pub const LEAST_ROUNDS: u32 = 12;

/// The builds, updates or traces of a ray set of one window in one place, sampled in rounds: in each all contenders and controls
/// once, in an order of its own. Sample i of every row of a race was taken in round i.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RaceRecord {
    /// Scene.
    pub scene: String,
    /// Viewpoint.
    pub viewpoint: String,
    /// Window of the place.
    pub window: u32,
    /// Ray set; `builds` or `updates` for a race of structures.
    pub work: String,
    /// Those who were sampled, by number from 0: labels, controls first, and those who did their work twice last.
    pub lanes: Vec<String>,
    /// Seed of the orders.
    pub order_seed: u64,
    /// The order of every counted round: numbers of lanes.
    pub orders: Vec<Vec<u32>>,
    /// Rounds before the counted ones. In all rounds of a ray set the same rays are traced.
    pub warm_up_rounds: u32,
    /// How long sampling was to go on.
    pub sampling: Sampling,
    /// What ended it.
    pub ended_by: EndedBy,
    /// Time that the counted rounds took altogether, seconds.
    pub sampled_s: f64,
    /// The widest interval that any two contenders' ratio has, in shares: its upper end over its lower one, less 1. None where
    /// there were no two, or too few rounds for an interval of [`COVERAGE`](super::COVERAGE).
    pub widest_interval: Option<f64>,
    /// The fixed kernel of every clock.
    pub kernels: Vec<KernelRecord>,
    /// Whether a kernel drifts: no verdict rests on the race's times.
    pub drift: bool,
    /// Those who did their work twice.
    pub twice: Vec<TwiceRecord>,
    /// Why an earlier try at the race was thrown away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeated_because: Option<String>,
}

/// How long sampling goes on, in whole rounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sampling {
    /// Counted rounds, at least.
    pub least_rounds: u32,
    /// How long it goes on after these; not at all without.
    pub further: Option<Further>,
}

impl Sampling {
    /// So many rounds, whatever comes of them.
    pub const fn rounds(rounds: u32) -> Self {
        Self { least_rounds: rounds, further: None }
    }

    /// In words.
    pub fn words(&self) -> String {
        match self.further {
            None => format!("{} rounds", self.least_rounds),
            Some(Further { interval_share, time_limit_s }) => format!(
                "{} rounds and on until ratios are known within {} % or {time_limit_s} s are over",
                self.least_rounds,
                interval_share * 100.0
            ),
        }
    }
}

/// When sampling beyond the least rounds ends, whatever comes first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Further {
    /// Every two contenders' ratio has an interval narrower than this share.
    pub interval_share: f64,
    /// The counted rounds have taken so long, seconds.
    pub time_limit_s: f64,
}

/// What ended the sampling of a race.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndedBy {
    /// The rounds were a fixed number.
    Rounds,
    /// All intervals were narrow enough.
    Interval,
    /// The time was up.
    TimeLimit,
    /// There were as many rounds as there may be.
    MostRounds,
}

/// The same work in every round, by which a change of the machine's speed shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KernelRecord {
    /// Its clock.
    pub clock: ClockKind,
    /// How much work it is.
    pub tasks: u32,
    /// Its time in every counted round.
    pub samples_ms: Vec<f64>,
    /// How much longer it takes in the last round than in the first by its trend, a share.
    pub change: f64,
    /// How sure the trend is, standard deviations.
    pub deviations: f64,
    /// Whether that is a drift.
    pub drifts: bool,
}

/// The first contender by the plan's order on a clock, doing its work twice in one sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TwiceRecord {
    /// The contender.
    pub tracer: String,
    /// The clock.
    pub clock: ClockKind,
    /// Every counted sample of the double work.
    pub samples_ms: Vec<f64>,
    /// How many times as long as once it takes, median of paired rounds.
    pub ratio: Option<f64>,
    /// Why it is not judged; it is, without.
    pub not_judged: Option<String>,
    /// Whether it takes what it must, or is not judged.
    pub passed: bool,
}
