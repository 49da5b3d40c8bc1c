//! Which points beat others, and which of them by noise alone.

use super::field::{By, Cost, Entry, Field};

/// A point with those that beat it by no more than noise, all by their places among the record's points.
pub type UnsurelyBeaten = (usize, Vec<usize>);

impl<'a> Field<'a> {
    /// Of every entry of a choice those that beat it, in cost and in error, but in neither by more than noise.
    pub fn unsurely_beaten(&self, entries: &[Entry<'a>], cost: Cost, by: By) -> Vec<UnsurelyBeaten> {
        let all = self.spots(entries, cost, by);
        let of = |(entry, spot): &(Entry<'a>, _)| {
            let beats = all
                .iter()
                .filter(|(other, beside)| beside.dominates(spot) && !self.surely_better(other, entry, cost, by));
            (entry.index, beats.map(|(other, _)| other.index).collect())
        };
        all.iter().map(of).collect()
    }
}
