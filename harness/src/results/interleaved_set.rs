//! What a record says of its interleaved sets: who was timed in which order, how long sampling went on, and whether its times may be
//! believed.

use serde::{Deserialize, Serialize};
use tracebench_api::ClockKind;

use super::Times;

/// Rounds below which no verdict rests on times.
pub const MIN_ROUNDS: u32 = 12;

records! {
    /// The builds, updates or traces of a ray set of one resident batch in one place, sampled in rounds: in each all configurations and
    /// controls once, in an order of its own. Sample i of every row of an interleaved set was taken in round i.
    pub struct InterleavedSetRecord {
        /// Scene.
        pub scene: String,
        /// Viewpoint.
        pub viewpoint: String,
        /// Window of the place.
        pub resident_batch: u32,
        /// Ray set; `builds` or `updates` for an interleaved set of structures.
        pub work: String,
        /// Those who were sampled, by number from 0: labels, controls first, and those who did their work twice last.
        pub participants: Vec<String>,
        /// Seed of the orders.
        pub order_seed: u64,
        /// The order of every counted round: numbers of participants.
        pub orders: Vec<Vec<u32>>,
        /// What every round does: traces the same rays again, builds afresh from the same triangles, or follows them a frame further.
        pub each_round: String,
        /// Rounds before the counted ones.
        pub warm_up_rounds: u32,
        /// How long sampling was to go on.
        pub sampling: SampleSchedule,
        /// What ended it.
        pub stop_reason: StopReason,
        /// Time that the counted rounds took altogether, seconds.
        pub sampled_s: f64,
        /// The widest interval that any two configurations' ratio has, in shares: its upper end over its lower one, less 1. None where
        /// there were no two, or too few rounds for an interval of [`COVERAGE`](super::COVERAGE).
        pub widest_interval: Option<f64>,
        /// The ticks of its clocks. None in files of before they were probed.
        pub clock_ticks: Option<ClockTicks> = default,
        /// The fixed kernel of every clock.
        pub kernels: Vec<KernelRecord>,
        /// Whether a kernel drifts: no verdict rests on the interleaved set's times.
        pub drift: bool,
        /// Those who did their work twice.
        pub doubled_work: Vec<DoubledWorkRecord>,
        /// Why an earlier try at the interleaved set was thrown away.
        pub repeated_because: Option<String> = default,
    }

    /// The same work in every round, by which a change of the machine's speed shows.
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

    /// The first configuration by the plan's order on a clock, doing its work twice in one sample.
    pub struct DoubledWorkRecord {
        /// The configuration.
        pub tracer: String,
        /// The clock.
        pub clock: ClockKind,
        /// Every counted sample of the double work.
        pub samples_ms: Vec<f64>,
        /// How many times as long as once it takes, by the lower quartiles; before rules version 3 the median of paired rounds.
        pub ratio: Option<f64>,
        /// Why it is not judged; it is, without.
        pub not_judged: Option<String>,
        /// Whether it takes what it must, or is not judged.
        pub passed: bool,
    }
}

/// The ticks of clocks: of each the smallest step other than zero between successive readings in a probe of 1,000; none of a clock that
/// is not there, or does not move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClockTicks {
    /// Of the host's clock.
    pub host_ms: Option<f64>,
    /// Of the device's timestamps.
    pub device_ms: Option<f64>,
}

/// Ticks that a time must have at least.
pub const MIN_TICKS: f64 = 20.0;

impl ClockTicks {
    fn of(&self, clock: ClockKind) -> Option<f64> {
        match clock {
            ClockKind::DeviceTimestamps => self.device_ms,
            ClockKind::Host | ClockKind::SubmitToDone => self.host_ms,
        }
    }

    /// Whether a time by a clock is too short for its ticks.
    pub fn is_too_coarse(&self, clock: ClockKind, ms: f64) -> bool {
        self.of(clock).is_none_or(|tick_ms| ms < MIN_TICKS * tick_ms)
    }

    /// Why times are invalid that are too short for their clock, if they are.
    pub fn too_coarse(&self, times: &Times) -> Option<String> {
        let is = !times.samples_ms.is_empty() && self.is_too_coarse(times.clock, times.median_ms);
        is.then(|| match self.of(times.clock) {
            Some(tick_ms) => format!("times below {MIN_TICKS} ticks of their clock, which are {tick_ms} ms each"),
            None => "their clock does not move".to_owned(),
        })
    }
}

/// How long sampling goes on, in whole rounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampleSchedule {
    /// Counted rounds, at least.
    pub min_rounds: u32,
    /// How long it goes on after these; not at all without.
    pub adaptive: Option<Adaptive>,
}

impl SampleSchedule {
    /// So many rounds, whatever comes of them.
    pub const fn rounds(rounds: u32) -> Self {
        Self { min_rounds: rounds, adaptive: None }
    }

    /// In words.
    pub fn describe(&self) -> String {
        match self.adaptive {
            None => format!("{} rounds", self.min_rounds),
            Some(Adaptive { ratio_precision, time_limit_s }) => format!(
                "{} rounds and on until ratios are known within {} % or {time_limit_s} s are over",
                self.min_rounds,
                ratio_precision * 100.0
            ),
        }
    }
}

/// When sampling beyond the least rounds ends, whatever comes first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adaptive {
    /// Every two configurations' ratio has an interval narrower than this share.
    pub ratio_precision: f64,
    /// The counted rounds have taken so long, seconds.
    pub time_limit_s: f64,
}

/// What ended the sampling of an interleaved set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// The rounds were a fixed number.
    Rounds,
    /// All intervals were narrow enough.
    Interval,
    /// The time was up.
    TimeLimit,
    /// There were as many rounds as there may be.
    MaxRounds,
}
