//! What was measured of all points over one ray set in one place: costs, errors, and how surely they differ.

use itertools::Itertools as _;
use tracebench_api::{ClockKind, Query};

use super::front::{CostAndError, FrontStatus, front_statuses};
use crate::results::{
    Accuracy, FrontPoint, FrontScene, Judgement, ParetoRecord, Record, Row, Rule, Timed, Times, TraceRecord,
    ViewpointRecord, gathered, same_rays,
};
use crate::statistics::{median, median_interval, rule_of_three};
use crate::studies::tune;

/// A figure with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amount {
    /// The figure.
    pub value: f64,
    /// Its interval.
    pub interval: [f64; 2],
}

impl Amount {
    /// One that is known exactly.
    pub fn exact(value: f64) -> Self {
        Self { value, interval: [value; 2] }
    }

    /// So many times as much.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        let [low, high] = self.interval.map(|end| end * factor);
        Self { value: self.value * factor, interval: if factor < 0.0 { [high, low] } else { [low, high] } }
    }

    /// What is left to a share that this is.
    #[must_use]
    pub fn rest(self) -> Self {
        let [low, high] = self.interval;
        Self { value: (1.0 - self.value).max(0.0), interval: [high, low].map(|end| (1.0 - end).max(0.0)) }
    }

    /// Whether it is a number with an interval of numbers.
    pub fn is_finite(&self) -> bool {
        self.value.is_finite() && self.interval.iter().all(|end| end.is_finite())
    }

    /// Both together, from the least of both to the greatest of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let ([low, high], [other_low, other_high]) = (self.interval, other.interval);
        Self { value: self.value + other.value, interval: [low + other_low, high + other_high] }
    }
}

impl Accuracy {
    /// How often answers are wrong.
    pub(crate) fn wrong_share(&self) -> Option<Amount> {
        let value = self.share?;
        Some(Amount { value, interval: self.interval.unwrap_or([value; 2]) }.rest())
    }
}

/// A time by the host's clock, which every method has: of work on a device from submission until done, milliseconds; `None` where
/// nothing was timed, or times are invalid.
pub fn on_host(times: &Times) -> Option<Amount> {
    let samples = match times.clock {
        ClockKind::Host => &times.samples_ms,
        ClockKind::DeviceTimestamps | ClockKind::SubmitToDone => &times.submit_to_done_samples_ms,
    };
    let value = median(samples);
    let sound = times.invalid.is_none() && value.is_finite() && value > 0.0;
    sound.then(|| Amount { value, interval: median_interval(samples).0 })
}

/// What a point costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cost {
    /// Time of the trace.
    Trace,
    /// Time of the first build.
    Build,
    /// Bytes of the structure, and of the geometry that must stay to trace.
    Bytes,
    /// Time of a frame: the build and so many rays a pixel of the ray image.
    Frame(f64),
}

impl Cost {
    /// Every cost, with a frame for each number of rays a pixel.
    pub fn all(rays_per_pixel: &[f64]) -> Vec<Self> {
        let frames = rays_per_pixel.iter().map(|rays| Self::Frame(*rays));
        [Self::Trace, Self::Build, Self::Bytes].into_iter().chain(frames).collect()
    }

    /// The name in tables for programs.
    pub fn code(self) -> String {
        match self {
            Self::Trace => "speed".to_owned(),
            Self::Build => "build".to_owned(),
            Self::Bytes => "bytes".to_owned(),
            Self::Frame(rays) => format!("frame_at_{rays}_rays_per_pixel"),
        }
    }
}

/// How an answer is right: of closest hits by a rule, of any hit by the balanced accuracy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// By a rule.
    Rule(Rule),
    /// The mean of the shares of right answers among occluded and among free rays.
    BalancedAccuracy,
}

impl By {
    /// All by which answers to a query are judged.
    pub fn all(query: Query) -> &'static [Self] {
        match query {
            Query::Closest => &[Self::Rule(Rule::HitMiss), Self::Rule(Rule::Tight), Self::Rule(Rule::Footprint)],
            Query::Any => &[Self::BalancedAccuracy],
        }
    }

    /// The name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rule(rule) => rule.name(),
            Self::BalancedAccuracy => "balanced_accuracy",
        }
    }

    fn rule(self) -> Rule {
        match self {
            Self::Rule(rule) => rule,
            // Of any-hit sets it is the balanced accuracy, whatever the rule.
            Self::BalancedAccuracy => Rule::HitMiss,
        }
    }
}

/// The share of wrong answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrong {
    /// The share with its 95 % interval.
    pub share: Amount,
    /// What so many rays do not tell from no wrong one: three of them.
    pub bound: f64,
}

impl Wrong {
    /// Of a trace; `None` if nothing could be judged.
    pub fn of(trace: &TraceRecord, by: By) -> Option<Self> {
        let share = tune::accuracy(&trace.judgement, by.rule())?.wrong_share()?;
        Some(Self { share, bound: bound(trace) })
    }

    /// The share as it is drawn and compared with others: not below what can be told from none.
    pub fn drawn(&self) -> f64 {
        self.share.value.max(self.bound)
    }

    /// Whether it is drawn at the bound, since the share lies below.
    pub fn at_bound(&self) -> bool {
        self.share.value < self.bound
    }
}

/// Three of the rays that count; of any hit the mean of three of the occluded and three of the free ones.
fn bound(trace: &TraceRecord) -> f64 {
    match &trace.judgement {
        Judgement::Closest(closest) => rule_of_three(trace.count.saturating_sub(closest.left_out())),
        Judgement::Any(_) => {
            let kinds = trace.judgement.true_hits_and_misses();
            let there: Vec<f64> = kinds.into_iter().filter(|rays| *rays > 0).map(rule_of_three).collect();
            there.iter().sum::<f64>() / (there.len() as f64).max(1.0)
        }
    }
}

/// A point with what was measured of it.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// Its place among the record's points.
    pub index: usize,
    /// The point.
    pub point: &'a FrontPoint,
    /// Its row.
    pub row: &'a Row,
    /// Its trace of the rays.
    pub trace: &'a TraceRecord,
}

/// A point in its place by cost and error, and how it stands to a front.
pub type Standing<'a> = (Entry<'a>, CostAndError, FrontStatus);

/// All points over one ray set in one place.
#[derive(Clone, Debug)]
pub struct Field<'a> {
    /// The record.
    pub record: &'a Record,
    /// Its points.
    pub section: &'a ParetoRecord,
    /// The scene.
    pub scene: &'a FrontScene,
    /// The viewpoint, by which frame and faces of rows do not count.
    pub viewpoint: &'a ViewpointRecord,
    /// The ray set.
    pub rays: &'a str,
    /// What was asked.
    pub query: Query,
    /// Its number of rays.
    pub count: u64,
    /// Points that were measured, in the order of the record.
    pub entries: Vec<Entry<'a>>,
    /// The controls on the same rays; they are part of no front.
    pub controls: Vec<(&'a Row, &'a TraceRecord)>,
    /// The same ray set where chosen points were measured again.
    pub elsewhere: Option<Box<Self>>,
}

/// Whether a row was measured from a viewpoint with its rays; frame and faces are the row's own.
pub(super) fn is_at(row: &Row, scene: &FrontScene, viewpoint: &ViewpointRecord) -> bool {
    let bare = |of: &ViewpointRecord| ViewpointRecord { frame: [0; 2], face: 0, ..of.clone() };
    row.scene.sha256 == scene.scene.sha256
        && row.scene.name == scene.scene.name
        && bare(&row.viewpoint) == bare(viewpoint)
}

/// Whether not one ray hits anything: whoever misses always is right then, and no point is better than another.
pub(super) fn sees_nothing(trace: &TraceRecord) -> bool {
    let [hits, _] = trace.judgement.true_hits_and_misses();
    match &trace.judgement {
        Judgement::Closest(closest) => {
            let hits = closest.truth.as_ref().map_or(hits, |truth| truth.hits + truth.ambiguous_hits);
            hits == 0 && closest.left_out() < trace.count
        }
        Judgement::Any(_) => hits == 0,
    }
}

/// Every ray set that was traced from a scene's viewpoint and hit anything, in the order of first appearance.
pub fn fields<'a>(record: &'a Record, section: &'a ParetoRecord, scene: &'a FrontScene) -> Vec<Field<'a>> {
    let from = |viewpoint: &'a ViewpointRecord| {
        let here = |row: &&Row| is_at(row, scene, viewpoint);
        let rows: Vec<&Row> = record.rows.iter().filter(|row| row.update_mode.is_none()).filter(here).collect();
        let controls = |trace: &TraceRecord| {
            let beside = |row: &'a Row| Some((row, row.traces.iter().find(|other| same_rays(other, trace))?));
            // Points that were tried alone have controls of their own; they score the same.
            let traced = record.controls.iter().filter(here).filter_map(beside);
            traced.unique_by(|(row, _)| row.tracer.name.clone()).collect()
        };
        let entries = section.points.iter().enumerate().filter_map(|(index, point)| {
            let row = rows.iter().copied().find(|row| point.is_of(row))?;
            let seen = row.traces.iter().filter(|trace| !sees_nothing(trace));
            Some(seen.map(move |trace| (trace.rays.as_str(), Entry { index, point, row, trace })))
        });
        let field = |(rays, entries): (&'a str, Vec<Entry<'a>>)| {
            let TraceRecord { query, count, .. } = *entries[0].trace;
            let controls = controls(entries[0].trace);
            Field { record, section, scene, viewpoint, rays, query, count, entries, controls, elsewhere: None }
        };
        gathered(entries.flatten()).into_iter().map(field).collect::<Vec<_>>()
    };
    let mut fields = from(&scene.viewpoint);
    for there in scene.held_out.iter().flat_map(|there| from(&there.viewpoint)) {
        if let Some(here) = fields.iter_mut().find(|here| here.rays == there.rays) {
            here.elsewhere = Some(Box::new(there));
        }
    }
    fields
}

impl<'a> Field<'a> {
    /// Names of the tracers, each once, in the order of their points.
    pub fn tracers(&self) -> Vec<&'a str> {
        self.entries.iter().map(|entry| entry.point.tracer.as_str()).unique().collect()
    }

    /// Rays of a frame with so many of them a pixel of the ray image.
    pub fn rays_of_frame(&self, rays_per_pixel: f64) -> f64 {
        let [width, height] = self.viewpoint.ray_image.map(f64::from);
        rays_per_pixel * width * height
    }

    /// What an entry costs; `None` where it was not timed.
    pub fn cost(&self, entry: &Entry<'_>, cost: Cost) -> Option<Amount> {
        match cost {
            Cost::Trace => on_host(&entry.trace.times),
            Cost::Build => on_host(entry.row.build.first()),
            Cost::Bytes => Some(Amount::exact(bytes(entry.row) as f64)),
            Cost::Frame(rays_per_pixel) => {
                let times = self.rays_of_frame(rays_per_pixel) / self.count.max(1) as f64;
                Some(on_host(entry.row.build.steady())?.and(on_host(&entry.trace.times)?.times(times)))
            }
        }
    }

    /// Whether one costs less than another beyond noise: by every byte, of times by the rounds in which both were timed.
    pub fn surely_cheaper(&self, one: &Entry<'a>, other: &Entry<'a>, cost: Cost) -> bool {
        let timed = |entry: &Entry<'a>| match cost {
            Cost::Trace => Some(Timed::trace(entry.row, entry.trace)),
            Cost::Build => Some(Timed::first_build(entry.row)),
            Cost::Bytes => None,
            Cost::Frame(rays_per_pixel) => {
                let times = self.rays_of_frame(rays_per_pixel) / self.count.max(1) as f64;
                Some(Timed::steady_build(entry.row).and(Timed::trace(entry.row, entry.trace).times(times)))
            }
        };
        match (timed(one), timed(other)) {
            (Some(one), Some(other)) => {
                let ratio = self.record.paired_on_host(&one, &other).sure();
                ratio.is_ok_and(|ratio| ratio.interval[1] < 1.0)
            }
            _ => bytes(one.row) < bytes(other.row),
        }
    }

    /// Whether one costs less, or is wrong less often, beyond noise.
    fn surely_better(&self, one: &Entry<'a>, other: &Entry<'a>, cost: Cost, by: By) -> bool {
        let wrong = |entry: &Entry<'_>| Wrong::of(entry.trace, by).map(|wrong| wrong.share.interval);
        let fewer = wrong(one).zip(wrong(other)).is_some_and(|(one, other)| one[1] < other[0]);
        fewer || self.surely_cheaper(one, other, cost)
    }

    /// Entries with their places, those that lack cost or error left out.
    fn spots(&self, entries: &[Entry<'a>], cost: Cost, by: By) -> Vec<(Entry<'a>, CostAndError)> {
        let spot = |entry: &Entry<'a>| {
            let spot = CostAndError { cost: self.cost(entry, cost)?.value, error: Wrong::of(entry.trace, by)?.drawn() };
            Some((*entry, spot))
        };
        entries.iter().filter_map(spot).collect()
    }

    /// How the entries of a choice stand to their own front; entries that lack cost or error are in no choice.
    pub fn front_statuses(&self, entries: &[Entry<'a>], cost: Cost, by: By) -> Vec<Standing<'a>> {
        let all = self.spots(entries, cost, by);
        let spots: Vec<CostAndError> = all.iter().map(|(_, spot)| *spot).collect();
        let surely = |one: usize, other: usize| self.surely_better(&all[one].0, &all[other].0, cost, by);
        let front_statuses = front_statuses(&spots, surely);
        all.into_iter().zip(front_statuses).map(|((entry, spot), front_status)| (entry, spot, front_status)).collect()
    }

    /// Of every entry of a choice those that beat it, in cost and in error, but in neither by more than noise: by their places among the
    /// record's points.
    pub fn unsurely_beaten(&self, entries: &[Entry<'a>], cost: Cost, by: By) -> Vec<(usize, Vec<usize>)> {
        let all = self.spots(entries, cost, by);
        let of = |(entry, spot): &(Entry<'a>, CostAndError)| {
            let is = |(other, beside): &&(Entry<'a>, CostAndError)| {
                beside.dominates(spot) && !self.surely_better(other, entry, cost, by)
            };
            (entry.index, all.iter().filter(is).map(|(other, _)| other.index).collect())
        };
        all.iter().map(of).collect()
    }

    /// The entries of one tracer, published and improved.
    pub fn of_tracer(&self, tracer: &str) -> Vec<Entry<'a>> {
        self.entries.iter().copied().filter(|entry| entry.point.tracer == tracer).collect()
    }

    /// Entries that cost no more than so much.
    pub fn within(&self, cost: Cost, most: f64) -> Vec<Entry<'a>> {
        let is_within = |entry: &Entry<'a>| self.cost(entry, cost).is_some_and(|cost| cost.value <= most);
        self.entries.iter().copied().filter(is_within).collect()
    }

    /// Budgets at which methods are matched: within each a third, two thirds, all of the tracers have a point.
    pub fn budgets(&self, cost: Cost) -> Vec<f64> {
        let least = |tracer: &str| {
            let entries = self.of_tracer(tracer);
            entries.iter().filter_map(|entry| Some(self.cost(entry, cost)?.value)).min_by(f64::total_cmp)
        };
        let leasts: Vec<f64> = self.tracers().into_iter().filter_map(least).sorted_by(f64::total_cmp).collect();
        let place = |part: usize| (leasts.len() * part).div_ceil(3).checked_sub(1);
        (1..=3).filter_map(|part| Some(rounded_up(leasts[place(part)?]))).dedup().collect()
    }
}

/// The next number with two digits that is no less.
fn rounded_up(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return value;
    }
    let unit = 10.0_f64.powf(value.log10().floor() - 1.0);
    let rounded = (value / unit - 1e-9).ceil() * unit;
    rounded.max(value)
}

/// Bytes that must be there to trace.
pub fn bytes(row: &Row) -> u64 {
    row.memory.structure_bytes + row.memory.geometry_bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Budgets are rounded up to two digits, and never to less than what they must hold.
    #[test]
    fn budgets_are_round() {
        for (value, expected) in [(1234.0, 1300.0), (0.0123, 0.013), (10.0, 10.0), (99.5, 100.0), (1.0, 1.0)] {
            assert!((rounded_up(value) / expected - 1.0).abs() < 1e-9, "{value}: {}", rounded_up(value));
        }
        assert!((1..500).all(|step| rounded_up(1.37_f64.powi(step - 250)) >= 1.37_f64.powi(step - 250)));
        assert_eq!(rounded_up(0.0), 0.0);
    }

    /// Intervals of sums and multiples enclose what their parts enclose.
    #[test]
    fn amounts_add_up() {
        let one = Amount { value: 2.0, interval: [1.0, 4.0] };
        assert_eq!(one.and(Amount::exact(3.0)), Amount { value: 5.0, interval: [4.0, 7.0] });
        assert_eq!(one.times(-2.0), Amount { value: -4.0, interval: [-8.0, -2.0] });
    }
}
