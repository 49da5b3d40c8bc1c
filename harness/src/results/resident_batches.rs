//! Times of different resident batches, set against one another.
//!
//! Configurations are interleaved within a resident batch, so a machine that slows down slows all of them. Between resident batches nothing
//! says so but the anchor, the configuration that every resident batch of a place has: a time of a later resident batch stands to the
//! anchor's there as it would stand to the anchor's in the first. So ratios go through the anchor; rows that were set so are marked.

use std::borrow::Cow;

use super::{Record, Row, Times, common_clock, same_place, same_rays};

/// What marks a row whose times were set through the anchor.
pub const MARK: &str = " †";

impl Row {
    /// Its label in tables: the tracer's, marked where its times were set through an anchor.
    pub fn label(&self) -> String {
        let mark = if self.resident_batch > 0 { MARK } else { "" };
        format!("{}{mark}", self.tracer.label())
    }
}

impl Record {
    /// The record as tables show it: with the times of later resident batches as they would be in the first, and without those that are
    /// invalid, or whose anchor has none, so that nothing is made of them. The same where there is nothing of all that.
    pub fn aligned(&self) -> Cow<'_, Self> {
        let invalid = |row: &Row| {
            row.build.all().any(|times| times.invalid.is_some())
                || row.traces.iter().any(|trace| trace.times.invalid.is_some())
        };
        if self.rows.iter().all(|row| row.resident_batch == 0 && !invalid(row)) {
            return Cow::Borrowed(self);
        }
        let mut record = self.clone();
        for row in record.rows.iter_mut().filter(|row| row.resident_batch == 0) {
            let of_traces = row.traces.iter_mut().filter(|trace| trace.times.invalid.is_some());
            for trace in of_traces {
                trace.times.scale(None);
                trace.mrays_per_s = 0.0;
            }
            row.build.all_mut().filter(|times| times.invalid.is_some()).for_each(|times| times.scale(None));
        }
        for row in record.rows.iter_mut().filter(|row| row.resident_batch > 0) {
            let in_place = |one: &&Row| same_place(one, row);
            let there = self.anchors.iter().filter(in_place).find(|one| one.resident_batch == row.resident_batch);
            let here = there.and_then(|anchor| {
                let is_anchor = |one: &&Row| one.resident_batch == 0 && one.tracer == anchor.tracer;
                self.rows.iter().filter(in_place).find(is_anchor)
            });
            let both = here.zip(there);
            let factor = |own: &Times, of: &dyn Fn(&Row) -> Option<Times>| {
                let (first, later) = (of(both?.0)?, of(both?.1)?);
                // By the clock that the row depends on, where the anchor has it too.
                let same = first.clock == own.clock && later.clock == own.clock;
                let [first, later] =
                    if same { [first.median_ms, later.median_ms] } else { common_clock(&first, &later)? };
                (later > 0.0 && own.invalid.is_none()).then_some(first / later)
            };
            for (place, times) in row.build.all_mut().enumerate() {
                let by = factor(times, &|one| one.build.all().nth(place).cloned());
                times.scale(by);
            }
            for trace in &mut row.traces {
                let of_trace = |one: &Row| {
                    one.traces.iter().find(|other| same_rays(other, trace)).map(|other| other.times.clone())
                };
                let by = factor(&trace.times, &of_trace);
                trace.times.scale(by);
                trace.mrays_per_s = by.map_or(0.0, |by| trace.mrays_per_s / by);
            }
        }
        Cow::Owned(record)
    }
}

impl Times {
    /// Every time by a factor; nothing is left of them without one.
    fn scale(&mut self, factor: Option<f64>) {
        let Some(factor) = factor else {
            (self.samples_ms, self.phases, self.submit_to_done_median_ms) = (Vec::new(), Vec::new(), None);
            self.submit_to_done_samples_ms.clear();
            (self.median_ms, self.interval_ms, self.interval_coverage) = (0.0, [0.0; 2], 0.0);
            return;
        };
        self.anchor_scale = Some(factor);
        let by = |ms: &mut f64| *ms *= factor;
        self.submit_to_done_samples_ms.iter_mut().for_each(by);
        self.samples_ms.iter_mut().chain(&mut self.interval_ms).chain(&mut self.submit_to_done_median_ms).for_each(by);
        by(&mut self.median_ms);
        for phase in &mut self.phases {
            phase.samples_ms.iter_mut().for_each(by);
            by(&mut phase.median_ms);
        }
    }
}

#[cfg(test)]
mod tests {
    use tracebench_api::{ClockKind, Query};

    use super::*;
    use crate::report::fixture::{self, Quality};

    /// A row of a resident batch in which everything took twice as long is set back to half; one whose resident batch has no anchor has no
    /// times left; a record of one resident batch stays as it is, and rows of the first resident batch do in any.
    #[test]
    fn later_windows_go_through_the_anchor() {
        let quality = |speed| Quality { missed: 0.0, blur: 0.0, speed, clock: ClockKind::DeviceTimestamps };
        let sets = [("diffuse", Query::Closest)];
        let plain = fixture::run(&[("a", quality(1.0)), ("b", quality(2.0)), ("c", quality(4.0))], &sets);
        let plain = fixture::with_whole_builds(plain);
        assert!(matches!(plain.aligned(), Cow::Borrowed(_)));
        let mut record = plain.clone();
        let slow = |row: &mut Row, resident_batch: u32| {
            row.resident_batch = resident_batch;
            row.build.all_mut().for_each(|times| times.scale(Some(2.0)));
            row.traces[0].times.scale(Some(2.0));
            row.traces[0].mrays_per_s /= 2.0;
        };
        slow(&mut record.rows[1], 1);
        slow(&mut record.rows[2], 2);
        let mut anchor = plain.rows[0].clone();
        slow(&mut anchor, 1);
        record.anchors.push(anchor);
        let aligned = record.aligned();
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        let (own, set) = (&plain.rows[1].traces[0], &aligned.rows[1].traces[0]);
        assert!(near(set.times.median_ms, own.times.median_ms) && near(set.mrays_per_s, own.mrays_per_s));
        let (builds, own) = (&aligned.rows[1].build, &plain.rows[1].build);
        assert!(
            builds.all().count() == 3
                && builds.all().zip(own.all()).all(|(one, own)| near(one.median_ms, own.median_ms))
        );
        assert!(
            aligned.rows[2].traces[0].times.samples_ms.is_empty() && aligned.rows[2].build.times.samples_ms.is_empty()
        );
        assert_eq!(aligned.rows[0], plain.rows[0]);
        assert_eq!((aligned.rows[1].label().as_str(), aligned.rows[0].label().as_str()), ("b †", "a"));
        // Void times are left out, those beside them are not.
        let mut invalid = plain.clone();
        invalid.rows[1].traces[0].times.invalid = Some("why".to_owned());
        let shown = invalid.aligned();
        assert!(shown.rows[1].traces[0].times.samples_ms.is_empty() && shown.rows[1].traces[0].mrays_per_s == 0.0);
        assert_eq!(shown.rows[1].build.times.samples_ms, plain.rows[1].build.times.samples_ms);
        assert_eq!(shown.rows[0].traces[0].times.median_ms, plain.rows[0].traces[0].times.median_ms);
        // Without the anchor the ratio would be another one.
        assert!(!near(record.rows[1].traces[0].times.median_ms, own.times.median_ms));
    }
}
