//! Times of rows as estimates: how many times as long one takes as another, by the record's own rule of how sure that is
//! ([`Record::paired`]).

use super::estimate::Estimate;
use super::rows::{SceneRows, trace};
use crate::results::{Record, Row, Timed, TraceRecord, at_launch_settings, differ_in_launch, host_ms};

/// What there is to doubt where rows did the same by every counter and yet took different times: something else than the method is
/// told.
const SAME_WORK: &str = "equal counters, different times";

/// How many times as long one takes as the other; none without times by one clock.
pub(super) fn ratio(record: &Record, one: &Timed<'_>, other: &Timed<'_>) -> Option<Estimate> {
    let found = record.paired(one, other);
    found.ratio.map(|ratio| Estimate::timed(ratio.value, ratio.interval, found.caveat.map(|caveat| caveat.to_string())))
}

/// A trace of a row.
pub(super) fn traced<'a>(row: &'a Row, rays: &str) -> Option<Timed<'a>> {
    Some(Timed::trace(row, trace(row, rays)?))
}

/// Traces of a row, one set after the other.
fn traced_together<'a>(row: &'a Row, sets: &[&str]) -> Option<Timed<'a>> {
    sets.iter().map(|rays| traced(row, rays)).reduce(|sum, next| Some(sum?.and(next?)))?
}

/// What there is to doubt where a method was measured at one of its launch settings alone.
const ONE_MEANS: &str = "not measured at other launch settings";

/// Whether two traces did the same, by everything that is counted.
fn same_work(one: &TraceRecord, other: &TraceRecord) -> bool {
    let totals = |trace: &TraceRecord| -> Vec<(String, u64)> {
        trace.counters.iter().map(|(name, count)| (name.clone(), count.total)).collect()
    };
    !one.counters.is_empty() && totals(one) == totals(other)
}

impl SceneRows<'_> {
    /// How many times as long ray sets together take in one row as in another; of two methods at the rows' launch settings, at every launch
    /// setting that both were measured at, and at each one's best.
    pub(in crate::papers) fn traces_ratio(&self, one: &Row, other: &Row, sets: &[&str]) -> Option<Estimate> {
        let found = self.together(one, other, sets)?;
        if one.tracer.name != other.tracer.name {
            return self.at_launch_settings(found, one, other, sets);
        }
        let [low, high] = found.interval;
        let same = |rays: &&str| Some(same_work(trace(one, rays)?, trace(other, rays)?));
        let unexplained = (low > 1.0 || high < 1.0) && sets.iter().all(|rays| same(rays) == Some(true));
        Some(if unexplained { found.doubted(SAME_WORK.to_owned()) } else { found })
    }

    /// How many times as long some ray sets together take in one row as in another, at the rows' launch settings.
    fn together(&self, one: &Row, other: &Row, sets: &[&str]) -> Option<Estimate> {
        ratio(self.record, &traced_together(one, sets)?, &traced_together(other, sets)?)
    }

    /// A ratio of two methods with those at other launch settings.
    fn at_launch_settings(&self, found: Estimate, one: &Row, other: &Row, sets: &[&str]) -> Option<Estimate> {
        let all = |row: &Row| self.rows.iter().copied().filter(|each| differ_in_launch(row, each)).collect::<Vec<_>>();
        let (ones, others) = (all(one), all(other));
        if [(one, &ones), (other, &others)].iter().any(|(row, all)| row.tracer.launch().is_some() && all.len() < 2) {
            return Some(found.doubted(ONE_MEANS.to_owned()));
        }
        if [one, other].iter().all(|row| row.tracer.launch().is_none()) {
            return Some(found);
        }
        let time = |row: &Row| sets.iter().map(|rays| host_ms(&trace(row, rays)?.times)).sum::<Option<f64>>();
        Some(found.spread_over(at_launch_settings(&ones, &others, time, |one, other| self.together(one, other, sets))))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use tracebench_api::Query;

    use super::*;
    use crate::papers::Rows;
    use crate::papers::fixture::{config, count, in_interleaved_sets, run_of, set_time};

    /// Rows "a" and "b" of a scene, `b` taking longer by a factor and some noise that both share.
    fn pair(rounds: usize, factor: f64) -> Record {
        let rows = ["a", "b"].map(|name| {
            let mut row = config("dirt", "room", json!({ "name": name }), &[], &[("diffuse", Query::Closest)]);
            set_time(&mut row, "diffuse", 10.0);
            count(&mut row, "diffuse", "triangle_tests", name.len() as u64 + u64::from(name == "b"));
            let times = &mut row.traces[0].times;
            let slower = if name == "b" { factor } else { 1.0 };
            let noise = |round: usize| 10.0 * (1.0 + 0.3 * (round as f64 * 2.4).sin());
            times.samples_ms = (0..rounds).map(|round| slower * noise(round) * (1.0 + 1e-3 * round as f64)).collect();
            row
        });
        in_interleaved_sets(run_of(rows.to_vec()))
    }

    fn found(record: &Record) -> Estimate {
        let rows = Rows::of(record);
        rows.scenes[0].traces_ratio(&record.rows[1], &record.rows[0], &["diffuse"]).unwrap()
    }

    /// A ratio is sure where it is of as many paired rounds as a verdict takes; what slows a round for both widens nothing, and fewer
    /// rounds are a doubt.
    #[test]
    fn ratios_are_of_paired_rounds() {
        let sure = found(&pair(12, 1.2));
        assert!(sure.timed && sure.doubts.is_empty() && (sure.value - 1.2).abs() < 1e-9, "{sure:?}");
        assert!(sure.interval.iter().all(|end| (end - 1.2).abs() < 1e-9), "{sure:?}");
        let few = found(&pair(11, 1.2));
        assert!(few.doubts.iter().any(|caveat| caveat.contains("11 rounds")), "{few:?}");
    }

    /// Two methods compare at equal launch settings and at each one's best: what differs there widens where the ratio lies; one that was
    /// measured at a single choice of its launch settings is doubted, and one that has no choice stands beside every other.
    #[test]
    fn methods_are_compared_at_equal_and_best_launch_settings() {
        let row = |tracer: &str, reads: &str, ms: f64| {
            let parameters = if reads.is_empty() {
                json!({})
            } else {
                json!({ "memory_access": reads, "rays_per_lane": 1, "buckets": 4 })
            };
            let mut row = config(tracer, "room", parameters, &[], &[("diffuse", Query::Closest)]);
            set_time(&mut row, "diffuse", ms);
            row
        };
        let ratio = |rows: &[Row], other: usize| {
            let record = in_interleaved_sets(run_of(rows.to_vec()));
            let rows = Rows::of(&record);
            rows.scenes[0].traces_ratio(&record.rows[0], &record.rows[other], &["diffuse"]).unwrap()
        };
        // 2 by buffers, 4.8 by textures, 4 at each one's best.
        let rows =
            [row("a", "buffer", 20.0), row("a", "texture", 24.0), row("b", "buffer", 10.0), row("b", "texture", 5.0)];
        let found = ratio(&rows, 2);
        assert_eq!((found.value, found.interval, found.doubts.len()), (2.0, [2.0, 4.8], 0));
        assert!(found.at_launch_settings);
        assert!(ratio(&rows[..3], 2).doubts.contains(ONE_MEANS));
        let beside = [rows[0].clone(), rows[1].clone(), row("c", "", 10.0)];
        assert_eq!(ratio(&beside, 2).interval, [2.0, 2.4]);
        let plain = ratio(&[row("c", "", 30.0), row("d", "", 10.0)], 1);
        assert_eq!((plain.interval, plain.at_launch_settings), ([3.0; 2], false));
    }

    /// Rows that did the same by their counters and took different times are doubted; a counter more or equal times and they are not.
    #[test]
    fn equal_work_in_different_times_is_doubted() {
        let with = |factor: f64, tests: [u64; 2]| {
            let mut record = pair(12, factor);
            record.rows.iter_mut().zip(tests).for_each(|(row, tests)| count(row, "diffuse", "triangle_tests", tests));
            found(&record).doubts.contains(SAME_WORK)
        };
        assert!(with(1.2, [70, 70]) && !with(1.0, [70, 70]) && !with(1.2, [70, 71]));
    }
}
