//! What no measurement can have come to, whoever wrote it into a record.

use super::{Judgement, Run, Times, TracerRun};

impl Run {
    /// Why the record is none of a run, if it is none: without rows, with a share outside of 0 to 1 or of its interval, or with a time below zero.
    pub fn fault(&self) -> Option<String> {
        // Of a shard another one may have all rows; where cases were asked, a tracer may have been there for none.
        if self.runs.is_empty() && self.provenance.shard.is_none() && self.cases.is_none() {
            return Some("it has no rows (`runs` is empty)".to_owned());
        }
        [&self.runs, &self.controls, &self.anchors].into_iter().flatten().find_map(of_row)
    }
}

/// What ends of intervals may be off by.
const ROUNDING: f64 = 1e-9;

fn of_row(row: &TracerRun) -> Option<String> {
    let place = format!("{} in {}", row.tracer.name, row.scene.name);
    if let Some(time) = below_zero(&row.build.times).or(Some(row.build.setup_ms).filter(|time| !is_time(*time))) {
        return Some(format!("{place}: a build took {time} ms"));
    }
    row.traces.iter().find_map(|trace| {
        let place = format!("{place}, {}", trace.rays);
        if let Some(time) = below_zero(&trace.times) {
            return Some(format!("{place}: a trace took {time} ms"));
        }
        let shares = shares(&trace.judgement);
        if let Some((share, _)) = shares.iter().find(|(share, _)| !(0.0..=1.0).contains(share)) {
            return Some(format!("{place}: {share} is a share of right answers, and no number from 0 to 1"));
        }
        let is_off = |(share, [low, high]): &&(f64, [f64; 2])| !(low - ROUNDING..=high + ROUNDING).contains(share);
        let (share, [low, high]) = shares.iter().find(is_off)?;
        Some(format!("{place}: {share} is a share of right answers, and not in its interval from {low} to {high}"))
    })
}

fn is_time(time: f64) -> bool {
    time >= 0.0
}

fn below_zero(times: &Times) -> Option<f64> {
    let Times { samples_ms, median_ms, submit_to_done_samples_ms, .. } = times;
    let all = samples_ms.iter().chain([median_ms]).chain(submit_to_done_samples_ms);
    all.copied().find(|time| !is_time(*time))
}

/// Shares of right answers with their intervals. An interval that is not there holds every share.
fn shares(judgement: &Judgement) -> Vec<(f64, [f64; 2])> {
    let all = match judgement {
        Judgement::Closest(closest) => {
            let (share, interval) = (&closest.agreement, &closest.interval);
            let without = closest.agreement_without_ambiguous.clone().unwrap_or_default();
            vec![
                (share.hit_miss, interval.hit_miss),
                (share.tight, interval.tight),
                (share.footprint, interval.footprint),
                (without.hit_miss, None),
                (without.tight, None),
                (without.footprint, None),
            ]
        }
        Judgement::Any(any) => vec![(any.occlusion.balanced_accuracy, any.occlusion.balanced_accuracy_interval)],
    };
    all.into_iter().filter_map(|(share, interval)| Some((share?, interval.unwrap_or([0.0, 1.0])))).collect()
}
