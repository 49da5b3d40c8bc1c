//! Times, as samples and what is made of them.

use serde::{Deserialize, Serialize};
use tracebench_api::{ClockKind, PhaseSample};

/// Samples of one kind of work, and what is made of them; its fields stand among those of what was timed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Which clock.
    pub clock: ClockKind,
    /// Every counted sample, in order.
    pub samples_ms: Vec<f64>,
    /// Their median.
    pub median_ms: f64,
    /// Order-statistic interval of the median.
    pub interval_ms: [f64; 2],
    /// Probability that the interval covers the median of the distribution.
    pub interval_coverage: f64,
    /// Phases in order.
    pub phases: Vec<PhaseRecord>,
    /// The same samples by the host's clock round the submission, their median; of work on the host nothing.
    pub submit_to_done_median_ms: Option<f64>,
    /// These samples. Empty in files of before they were kept.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub submit_to_done_samples_ms: Vec<f64>,
    /// Whether the device's timestamps cannot be true, so that `clock` is `submit_to_done` instead.
    pub timestamps_refused: bool,
    /// Samples that were taken again because memory sized from counts had been too small; theirs is the second time. None
    /// in files of before there were such structures.
    #[serde(default)]
    pub grown_samples: u64,
    /// The interleaved set that they were taken in: its place in the record's. None where nothing was timed, and in files of before
    /// interleaved sets were told of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interleaved_set: Option<u32>,
    /// Why they may not be believed, whatever else of the row may.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub invalid: Option<String>,
    /// By what they were multiplied to be as in the first resident batch ([`Record::aligned`](super::Record::aligned)); never kept.
    #[serde(skip)]
    pub anchor_scale: Option<f64>,
}

/// Times of the builds, or of the updates of a row that follows an animation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BuildRecord {
    /// The phases that the tracer marks, of first builds or of updates.
    #[serde(flatten)]
    pub times: Times,
    /// First builds, from the call until the device is idle, host clock. None of updates, and in files of before rules version 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first: Option<Box<Times>>,
    /// Steady builds, each a rebuild in the memory of the first one before it, or updates; in the same scope by the same clock. None in
    /// files of before rules version 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steady: Option<Box<Times>>,
    /// Creating pipelines and everything else that is made once, host clock; without the warm-up.
    pub setup_ms: f64,
}

impl BuildRecord {
    /// What it takes to have the structure where there was none: the first build, of updates the update, and in files of before these
    /// were told the phases.
    pub fn first(&self) -> &Times {
        self.first.as_deref().unwrap_or_else(|| self.steady())
    }

    /// What it takes to have it once more: the steady build or the update, and in files of before these were told the phases.
    pub fn steady(&self) -> &Times {
        self.steady.as_deref().unwrap_or(&self.times)
    }

    /// All its times.
    pub fn all(&self) -> impl Iterator<Item = &Times> {
        [Some(&self.times), self.first.as_deref(), self.steady.as_deref()].into_iter().flatten()
    }

    /// All its times, to change.
    pub fn all_mut(&mut self) -> impl Iterator<Item = &mut Times> {
        [Some(&mut self.times), self.first.as_deref_mut(), self.steady.as_deref_mut()].into_iter().flatten()
    }
}

/// A phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseRecord {
    /// Name.
    pub name: String,
    /// Median over the samples.
    pub median_ms: f64,
    /// Every counted sample, in order.
    pub samples_ms: Vec<f64>,
}

/// A time as records keep it, to whole nanoseconds: no clock here tells less, and digits beyond are a tenth of a record.
pub(crate) fn whole_ns(ms: f64) -> f64 {
    (ms * 1e6).round() / 1e6
}

impl PhaseRecord {
    /// Collects the phases of several samples of the same work, in order of first appearance. A phase that only some
    /// samples have, as the first refit after a build may, has as many samples as had it.
    pub fn collect(samples: &[Vec<PhaseSample>]) -> Vec<Self> {
        let mut records: Vec<Self> = Vec::new();
        for phases in samples {
            for (place, phase) in phases.iter().enumerate() {
                // Of phases of the same name within a sample the first is told from the second.
                let before = phases[..place].iter().filter(|other| other.name == phase.name).count();
                match records.iter_mut().filter(|record| record.name == phase.name).nth(before) {
                    Some(record) => record.samples_ms.push(whole_ns(phase.duration_ms)),
                    None => {
                        let samples_ms = vec![whole_ns(phase.duration_ms)];
                        records.push(Self { name: phase.name.clone(), median_ms: 0.0, samples_ms });
                    }
                }
            }
        }
        for record in &mut records {
            record.median_ms = crate::statistics::median(&record.samples_ms);
        }
        records
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Phases are collected by name and not by place: one that only the first sample has does not shift the others, and two
    /// of one name within a sample are distinguished.
    #[test]
    fn phases_that_come_and_go_are_kept_apart() {
        let sample = |phases: &[(&str, f64)]| {
            let phase = |&(name, duration_ms): &(&str, f64)| PhaseSample { name: name.to_owned(), duration_ms };
            phases.iter().map(phase).collect::<Vec<_>>()
        };
        let samples = [
            sample(&[("read back", 9.0), ("fit", 1.0), ("fit", 5.0)]),
            sample(&[("fit", 2.0), ("fit", 6.0)]),
            sample(&[("fit", 3.0), ("fit", 7.0), ("build", 4.0)]),
        ];
        let found: Vec<_> = PhaseRecord::collect(&samples)
            .into_iter()
            .map(|phase| (phase.name, phase.median_ms, phase.samples_ms))
            .collect();
        let expected = [
            ("read back", 9.0, vec![9.0]),
            ("fit", 2.0, vec![1.0, 2.0, 3.0]),
            ("fit", 6.0, vec![5.0, 6.0, 7.0]),
            ("build", 4.0, vec![4.0]),
        ];
        assert_eq!(found, expected.map(|(name, median, samples)| (name.to_owned(), median, samples)));
        assert!(PhaseRecord::collect(&[]).is_empty());
    }
}
