//! Ratios within a run: of paired rounds, with what may be made of them.
//!
//! In every round of an interleaved set all configurations are sampled once, in an order shuffled. So the ratio of two configurations is
//! that of their times in the same round: what slows the machine for a while slows both. Where both are alike the lot alone decides who
//! comes out slower in a round, with a chance of one half and anew in every round, however times scatter, drift or hang together. That is
//! all that order statistics of the paired ratios take for granted ([`median_interval_of`]); outliers do not widen them.
//!
//! Rows of different resident batches are paired each with the anchor of its resident batch. What was timed in different interleaved sets
//! cannot be paired: there the interval is that of two lots, [`Ratio::of_times`], and the fixed kernels of both must have taken the same
//! time.

use itertools::Itertools as _;
use tracebench_api::ClockKind;

use super::{
    BuildRecord, InterleavedSetRecord, MIN_ROUNDS, Ratio, Record, Row, Times, TraceRecord, host_ms, same_place,
    same_rays,
};
use crate::statistics::{median, median_interval_of};

/// What the interval of a verdict covers.
pub const COVERAGE: f64 = 0.999;

/// By how much the fixed kernel's time may differ between interleaved sets whose times are set against one another, a share.
pub const MAX_CHANGE: f64 = 0.1;

/// Something that was timed, of one row: a build, a phase of it, a trace, or several of them one after the other.
#[derive(Clone, Debug)]
pub struct Timed<'a> {
    row: &'a Row,
    parts: Vec<Part<'a>>,
}

#[derive(Clone, Copy, Debug)]
struct Part<'a> {
    times: &'a Times,
    work: Work<'a>,
    phase: Option<&'a str>,
    factor: f64,
}

/// What a row did.
#[derive(Clone, Copy, Debug)]
enum Work<'a> {
    Build(fn(&BuildRecord) -> &Times),
    Trace(&'a TraceRecord),
}

impl<'a> Timed<'a> {
    /// The first build of a row, as [`BuildRecord::first`](super::BuildRecord::first).
    pub fn first_build(row: &'a Row) -> Self {
        Self::build(row, BuildRecord::first)
    }

    /// The steady build of a row, as [`BuildRecord::steady`](super::BuildRecord::steady).
    pub fn steady_build(row: &'a Row) -> Self {
        Self::build(row, BuildRecord::steady)
    }

    /// A phase of a row's build.
    pub fn build_phase(row: &'a Row, name: &'a str) -> Self {
        Self::build(row, |build| &build.times).phase(name)
    }

    /// One of the row's traces.
    pub fn trace(row: &'a Row, trace: &'a TraceRecord) -> Self {
        Self::work(row, Work::Trace(trace), &trace.times)
    }

    fn build(row: &'a Row, times: fn(&BuildRecord) -> &Times) -> Self {
        Self::work(row, Work::Build(times), times(&row.build))
    }

    fn work(row: &'a Row, work: Work<'a>, times: &'a Times) -> Self {
        Self { row, parts: vec![Part { times, work, phase: None, factor: 1.0 }] }
    }

    /// A phase alone.
    #[must_use]
    pub fn phase(mut self, name: &'a str) -> Self {
        self.parts.iter_mut().for_each(|part| part.phase = Some(name));
        self
    }

    /// What takes so many times as long: the factor is 1 over the number of rays for the time of a ray.
    #[must_use]
    pub fn times(mut self, factor: f64) -> Self {
        self.parts.iter_mut().for_each(|part| part.factor *= factor);
        self
    }

    /// This and then another of the same row.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.parts.extend(other.parts);
        self
    }

    /// Of what was timed as a whole its time by the host's clock, milliseconds.
    pub fn host_ms(&self) -> Option<f64> {
        self.parts.iter().map(|part| Some(part.factor * host_ms(part.times)?)).sum()
    }

    fn interleaved_sets(&self) -> Vec<Option<u32>> {
        self.parts.iter().map(|part| part.times.interleaved_set).collect()
    }

    fn clocks(&self) -> impl Iterator<Item = ClockKind> + '_ {
        self.parts.iter().map(|part| part.times.clock)
    }

    /// The same of the row of another tracer in the same place, whole where this is a phase.
    fn of<'b>(&self, row: &'b Row) -> Option<Timed<'b>> {
        let part = |part: &Part<'_>| {
            let timed = match part.work {
                Work::Trace(own) => Timed::trace(row, row.traces.iter().find(|other| same_rays(own, other))?),
                Work::Build(times) => Timed::build(row, times),
            };
            timed.times(part.factor).parts.pop()
        };
        Some(Timed { row, parts: self.parts.iter().map(part).collect::<Option<_>>()? })
    }

    /// The time of every round, milliseconds; `None` where a part has none by the clock.
    fn rounds(&self, by_host: bool) -> Option<Vec<f64>> {
        let mut sums: Option<Vec<f64>> = None;
        for part in &self.parts {
            let times = part.times;
            let samples = match (part.phase, by_host && times.clock != ClockKind::Host) {
                (None, false) => &times.samples_ms,
                (None, true) => &times.submit_to_done_samples_ms,
                (Some(_), true) => return None,
                (Some(name), false) => &times.phases.iter().find(|phase| phase.name == name)?.samples_ms,
            };
            // A phase that only some rounds have belongs to no round.
            let whole = !samples.is_empty() && (part.phase.is_none() || samples.len() == times.samples_ms.len());
            let scale = part.factor / times.anchor_scale.unwrap_or(1.0);
            let scaled = whole.then(|| samples.iter().map(|ms| ms * scale));
            sums = Some(match sums {
                None => scaled?.collect(),
                Some(sums) => sums.iter().zip(scaled?).map(|(sum, ms)| sum + ms).collect(),
            });
        }
        sums.filter(|rounds| rounds.iter().all(|ms| ms.is_finite() && *ms > 0.0))
    }
}

/// How two times came to be set against one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pairing {
    /// Round by round of the same interleaved set.
    Rounds,
    /// Each round by round with the anchor of its resident batch.
    ThroughAnchor,
    /// They were timed in different interleaved sets.
    Unpaired,
}

/// How many times as long one took as another.
#[derive(Clone, Debug, PartialEq)]
pub struct Paired {
    /// The ratio with an interval that covers with [`COVERAGE`] where there are enough rounds; `None` without times by one clock.
    pub ratio: Option<Ratio>,
    /// How it was had.
    pub pairing: Pairing,
    /// Why no verdict rests on it, if none does.
    pub caveat: Option<Caveat>,
}

/// Why a time decides nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Caveat {
    /// One of both was not timed, or not by a clock that the other has.
    #[error("there are no times by one clock")]
    NoTimes,
    /// Times are invalid.
    #[error("times are invalid: {0}")]
    Void(String),
    /// The record does not tell of its interleaved sets.
    #[error("the record does not tell of its interleaved sets")]
    Unrecorded,
    /// So many rounds are too few.
    #[error("{0} rounds, fewer than {MIN_ROUNDS}")]
    FewRounds(usize),
    /// The machine's speed drifted in an interleaved set, or changed between interleaved sets.
    #[error("drift: {0}")]
    Drift(String),
    /// The interval does not separate.
    #[error("the interval does not separate")]
    Interval,
}

/// What is to be said of how long one takes beside another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Longer.
    Longer,
    /// Shorter.
    Shorter,
    /// The same, but for a margin.
    Same,
    /// Nobody can tell, and why.
    Undecided(Caveat),
}

impl Paired {
    /// The ratio, if verdicts may rest on it.
    ///
    /// # Errors
    /// Why none may.
    pub fn sure(&self) -> Result<Ratio, Caveat> {
        match (&self.caveat, self.ratio) {
            (Some(caveat), _) => Err(caveat.clone()),
            (None, None) => Err(Caveat::NoTimes),
            (None, Some(ratio)) => Ok(ratio),
        }
    }

    /// What is to be said: the interval leaves out 1, or lies within a margin (a share) about it, or neither.
    pub fn answer(&self, margin: f64) -> Answer {
        match self.sure() {
            Err(caveat) => Answer::Undecided(caveat),
            Ok(Ratio { interval: [low, high], .. }) => match () {
                () if low > 1.0 => Answer::Longer,
                () if high < 1.0 => Answer::Shorter,
                () if high < 1.0 + margin && low > 1.0 / (1.0 + margin) => Answer::Same,
                () => Answer::Undecided(Caveat::Interval),
            },
        }
    }

    /// How many times as long one lot took as another of the same interleaved set, of which is known whether it drifts and why it is
    /// invalid.
    pub fn in_interleaved_set(ones: &[f64], others: &[f64], drift: Option<String>, invalid: Option<String>) -> Self {
        let ratio = of_rounds(ones, others, COVERAGE);
        let rounds = ones.len().min(others.len());
        let few = (rounds < MIN_ROUNDS as usize).then_some(Caveat::FewRounds(rounds));
        let caveat = invalid.map(Caveat::Void).or(few).or(drift.map(Caveat::Drift));
        Self { ratio, pairing: Pairing::Rounds, caveat: caveat.or(ratio.is_none().then_some(Caveat::NoTimes)) }
    }
}

/// Whether the same fixed kernel took another time in some interleaved sets than in others.
pub(crate) fn kernels_changed(ones: &[&InterleavedSetRecord], others: &[&InterleavedSetRecord]) -> bool {
    let kernels =
        |sets: &[&'_ InterleavedSetRecord]| sets.iter().flat_map(|set| set.kernels.clone()).collect::<Vec<_>>();
    let (ones, others) = (kernels(ones), kernels(others));
    let same = ones.iter().cartesian_product(&others).filter(|(a, b)| (a.clock, a.tasks) == (b.clock, b.tasks));
    let mut changes = same.map(|(one, other)| median(&one.samples_ms) / median(&other.samples_ms));
    changes.any(|change| change.max(1.0 / change) > 1.0 + MAX_CHANGE)
}

/// The ratio of times in the same rounds; `None` for no rounds.
pub fn of_rounds(one: &[f64], other: &[f64], coverage: f64) -> Option<Ratio> {
    let ratios: Vec<f64> = one.iter().zip(other).map(|(one, other)| one / other).collect();
    let (interval, covered) = median_interval_of(&ratios, coverage);
    let sound = !ratios.is_empty() && ratios.iter().all(|ratio| ratio.is_finite() && *ratio > 0.0);
    sound.then(|| Ratio { value: median(&ratios), interval, coverage: covered })
}

impl Record {
    /// How many times as long one takes as the other, rows of this record both.
    pub fn paired(&self, one: &Timed<'_>, other: &Timed<'_>) -> Paired {
        self.paired_by(one, other, !one.clocks().chain(other.clocks()).all_equal())
    }

    /// The same by the host's clock, whatever timed them: work on a device from submission until done.
    pub fn paired_on_host(&self, one: &Timed<'_>, other: &Timed<'_>) -> Paired {
        self.paired_by(one, other, true)
    }

    fn paired_by(&self, one: &Timed<'_>, other: &Timed<'_>, by_host: bool) -> Paired {
        let both = || one.parts.iter().chain(&other.parts);
        let (ratio, pairing) = self.ratio(one, other, by_host);
        let lots = [one, other].map(|timed| timed.rounds(by_host));
        let fewest = lots.iter().flatten().map(Vec::len).min().unwrap_or(0);
        let invalid = both().find_map(|part| part.times.invalid.clone());
        let known = both().all(|part| self.interleaved_set(part.times).is_some());
        let untimed = (lots.contains(&None) || ratio.is_none()).then_some(Caveat::NoTimes);
        let unrecorded = (!known).then_some(Caveat::Unrecorded);
        let few = (fewest < MIN_ROUNDS as usize).then_some(Caveat::FewRounds(fewest));
        let drift = || self.drift(one, other, pairing).map(Caveat::Drift);
        let caveat = invalid.map(Caveat::Void).or(untimed).or(unrecorded).or(few).or_else(drift);
        Paired { ratio, pairing, caveat }
    }

    /// The interleaved set that times were taken in.
    pub fn interleaved_set(&self, times: &Times) -> Option<&InterleavedSetRecord> {
        self.interleaved_sets.get(times.interleaved_set? as usize)
    }

    fn ratio(&self, one: &Timed<'_>, other: &Timed<'_>, by_host: bool) -> (Option<Ratio>, Pairing) {
        let known = one.interleaved_sets().iter().all(Option::is_some);
        if known && one.interleaved_sets() == other.interleaved_sets() {
            let both = one.rounds(by_host).zip(other.rounds(by_host));
            return (both.and_then(|(one, other)| of_rounds(&one, &other, COVERAGE)), Pairing::Rounds);
        }
        // Both lots must cover for the whole to cover.
        let each = COVERAGE.sqrt();
        let anchored = |timed: &Timed<'_>| {
            let anchor = timed.of(self.anchor(timed.row)?)?;
            let paired = anchor.interleaved_sets() == timed.interleaved_sets()
                && anchor.interleaved_sets().iter().all(Option::is_some);
            let by_host = by_host || !anchor.clocks().eq(timed.clocks());
            let both = timed.rounds(by_host).zip(anchor.rounds(by_host)).filter(|_| paired);
            both.and_then(|(own, anchor)| of_rounds(&own, &anchor, each))
        };
        let same_work = other.of(one.row).is_some_and(|work| work.interleaved_sets() == one.interleaved_sets());
        let apart = one.row.resident_batch != other.row.resident_batch && same_work && same_place(one.row, other.row);
        if let Some((one, other)) = anchored(one).zip(anchored(other)).filter(|_| apart) {
            return (Some(one.over(&other)), Pairing::ThroughAnchor);
        }
        let lots = one.rounds(by_host).zip(other.rounds(by_host));
        (lots.and_then(|(one, other)| Ratio::of_times(&one, &other, COVERAGE)), Pairing::Unpaired)
    }

    /// The configuration that is in every resident batch of a row's place, as it was measured in the row's.
    fn anchor(&self, row: &Row) -> Option<&Row> {
        let here = |one: &&Row| one.machine == row.machine && same_place(one, row);
        if row.resident_batch > 0 {
            return self.anchors.iter().filter(here).find(|one| one.resident_batch == row.resident_batch);
        }
        let anchor = self.anchors.iter().find(here)?;
        self.rows.iter().filter(here).find(|one| one.resident_batch == 0 && one.tracer == anchor.tracer)
    }

    /// What the fixed kernels say against a ratio.
    fn drift(&self, one: &Timed<'_>, other: &Timed<'_>, pairing: Pairing) -> Option<String> {
        let interleaved_sets = |timed: &Timed<'_>| {
            timed.parts.iter().filter_map(|part| self.interleaved_set(part.times)).collect::<Vec<_>>()
        };
        let (ours, theirs) = (interleaved_sets(one), interleaved_sets(other));
        if let Some(interleaved_set) = ours.iter().chain(&theirs).find(|interleaved_set| interleaved_set.drift) {
            return Some(format!("{} of {}", interleaved_set.work, interleaved_set.scene));
        }
        if pairing != Pairing::Unpaired {
            return None;
        }
        if one.row.machine != other.row.machine {
            return Some("other machines".to_owned());
        }
        let changed = kernels_changed(&ours, &theirs);
        changed.then(|| "the machine was faster in one interleaved set than in the other".to_owned())
    }
}

#[cfg(test)]
mod tests;
