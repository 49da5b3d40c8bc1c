//! Operating points: of the points that are right often enough the fastest, the smallest and the quickest to build; and what becomes of
//! them on rays and from a viewpoint by which they were not chosen.

use std::collections::BTreeSet;

use itertools::Itertools as _;
use tracebench_api::named;

use super::field::{By, Cost, Entry, Field, Wrong};
use crate::results::FrontPoint;

/// Agreements that are asked for.
pub const LEVELS: [f64; 3] = [0.99, 0.999, 0.9999];

named! {
    /// What an operating point is chosen for.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Aim {
        /// The shortest trace.
        Fastest = "fastest",
        /// The fewest bytes.
        Smallest = "smallest",
        /// The shortest build.
        QuickestBuilt = "quickest to build",
    }
}

impl Aim {
    /// What it makes least.
    pub fn cost(self) -> Cost {
        match self {
            Self::Fastest => Cost::Trace,
            Self::Smallest => Cost::Bytes,
            Self::QuickestBuilt => Cost::Build,
        }
    }
}

/// Of some entries that which costs least of those that agree as often as is asked for; of equal ones the first.
pub fn best<'a>(field: &Field<'a>, entries: &[Entry<'a>], by: By, level: f64, aim: Aim) -> Option<Entry<'a>> {
    let told = |entry: &Entry<'a>| {
        let wrong = Wrong::of(entry.trace, by)?.share.value;
        let cost = field.cost(entry, aim.cost())?.value;
        meets(1.0 - wrong, level).then_some((cost, *entry))
    };
    let all = entries.iter().filter_map(told);
    all.min_by(|(one, _), (other, _)| one.total_cmp(other)).map(|(_, entry)| entry)
}

/// Whether a share of right answers is as great as asked for; a share of whole rays that is just so counts.
fn meets(right: f64, level: f64) -> bool {
    right >= level - 1e-12
}

/// How far entries get: that with the fewest wrong rays, of equal ones the fastest.
pub fn farthest<'a>(field: &Field<'a>, entries: &[Entry<'a>], by: By) -> Option<Entry<'a>> {
    let told = |entry: &Entry<'a>| {
        let cost = field.cost(entry, Cost::Trace).map_or(f64::INFINITY, |cost| cost.value);
        Some(((Wrong::of(entry.trace, by)?.share.value, cost), *entry))
    };
    let all = entries.iter().filter_map(told);
    all.min_by(|(one, _), (other, _)| one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1))).map(|(_, entry)| entry)
}

/// Places of all points that are an operating point of their tracer in any of the fields, or the farthest that it gets.
pub fn chosen(fields: &[Field<'_>]) -> BTreeSet<usize> {
    let mut chosen = BTreeSet::new();
    for field in fields {
        for (by, tracer) in By::all(field.query).iter().cartesian_product(field.tracers()) {
            let own = field.of_tracer(tracer);
            let aims = LEVELS.into_iter().cartesian_product(Aim::ALL);
            let best = aims.filter_map(|(level, aim)| best(field, &own, *by, level, aim));
            chosen.extend(best.chain(farthest(field, &own, *by)).map(|entry| entry.index));
        }
    }
    chosen
}

/// What became of a chosen point elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Check {
    /// It agrees there as often as it was chosen for: the whole interval does.
    Holds(Wrong),
    /// The interval of what it does there contains what was asked for: so many rays cannot tell.
    WithinNoise(Wrong),
    /// It does not, by so many shares: not even the upper end of the interval does.
    Misses(Wrong, f64),
    /// It was not measured there.
    NotMeasured,
}

/// Holds a chosen point against the same ray set elsewhere.
pub fn check(field: &Field<'_>, point: &FrontPoint, by: By, level: f64) -> Check {
    let entry = field.elsewhere.iter().flat_map(|there| &there.entries).find(|entry| entry.point == point);
    let Some(wrong) = entry.and_then(|entry| Wrong::of(entry.trace, by)) else { return Check::NotMeasured };
    let [least, most] = [wrong.share.interval[1], wrong.share.interval[0]].map(|wrong| 1.0 - wrong);
    if meets(least, level) {
        Check::Holds(wrong)
    } else if meets(most, level) {
        Check::WithinNoise(wrong)
    } else {
        Check::Misses(wrong, level - (1.0 - wrong.share.value))
    }
}
