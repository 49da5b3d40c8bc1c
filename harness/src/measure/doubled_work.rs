//! The control of the clock: one configuration a clock that does its work twice in one sample, and must take twice as long.

use tracebench_api::{ClockKind, HitBuffer, Residency, Timing, TracerError};

use super::interleaved_set::{InterleavedSet, Participant};
use super::records;
use super::session::PreparedRays;
use crate::results::{DoubledWorkRecord, MIN_ROUNDS};
use crate::statistics::{median, percentile};

/// How many times as long double work must take, at least and at most. By submission until done a sample also has what is paid once:
/// submitting, waking up, and caches that other configurations have emptied.
pub(crate) const fn takes(clock: ClockKind) -> [f64; 2] {
    match clock {
        ClockKind::Host => [1.85, 2.4],
        ClockKind::DeviceTimestamps => [1.8, 2.3],
        ClockKind::SubmitToDone => [1.75, 2.2],
    }
}

/// Milliseconds below which it is not judged: what every sample costs once, whatever its work, is too large a part.
pub(crate) const MIN_JUDGED_MS: f64 = 5.0;

/// One that does its work twice.
#[derive(Default)]
pub(crate) struct DoubledWork {
    /// The participant whose work it does.
    pub participant: usize,
    pub timings: Vec<Timing>,
    /// Its buffer, where one is kept from round to round.
    pub(super) hits: Option<HitBuffer>,
    /// Why it is not judged, as far as that is known.
    pub not_judged: Option<String>,
}

/// Of configurations in the plan's order the first on each clock; one that may refuse rays where there is no other. Told of each are its place,
/// where it lives, and whether it may refuse rays.
pub(super) fn firsts(all: &[(usize, Residency, bool)]) -> impl Iterator<Item = usize> {
    [Residency::Host, Residency::Device].into_iter().filter_map(move |side| {
        let on_side = all.iter().filter(|(_, residency, _)| *residency == side);
        on_side.min_by_key(|(.., may_refuse)| *may_refuse).map(|(place, ..)| *place)
    })
}

impl InterleavedSet<'_> {
    /// The first configuration on each clock, ready to do its work twice.
    pub(super) fn doubles(&mut self, rays: &PreparedRays) -> Vec<DoubledWork> {
        let mut able = Vec::new();
        for place in 0..self.participants.len() {
            let Participant { request, control, out, .. } = &self.participants[place];
            if control.is_none() && out.is_none() {
                let may_refuse = request.as_ref().is_some_and(|request| request.registration.one_origin());
                able.push((place, self.config(place).description.residency, may_refuse));
            }
        }
        let session = self.session;
        let double = |participant: usize| {
            let hits = session.hit_buffer(self.config(participant), rays);
            let not_judged = hits.as_ref().err().map(TracerError::to_string);
            DoubledWork { participant, hits: hits.ok(), not_judged, ..DoubledWork::default() }
        };
        firsts(&able).map(double).collect()
    }

    /// Lets one do its work twice. What goes wrong takes nobody out: the same work done once tells of it.
    pub(super) fn double(&mut self, rays: &PreparedRays, double: &mut DoubledWork, counts: bool) {
        let (session, participant) = (self.session, double.participant);
        if !self.participants[participant].is_in() {
            double.not_judged.get_or_insert_with(|| "the tracer was taken out".to_owned());
        }
        let Some(hits) = double.hits.as_mut().filter(|_| double.not_judged.is_none()) else { return };
        let repeats = 2 * self.participants[participant].repeats;
        let sample = session.sample_trace(self.config(participant), rays, hits, repeats);
        double.keep(sample, counts);
    }
}

impl DoubledWork {
    /// Keeps a sample that counts; one that failed is the reason why nothing is judged.
    pub(super) fn keep(&mut self, sample: Result<Timing, TracerError>, counts: bool) {
        match sample {
            Ok(timing) => self.timings.extend(Some(timing).filter(|_| counts)),
            Err(error) => self.not_judged = Some(error.to_string()),
        }
    }

    /// What is said of it beside the same work done once, by timestamps where those of the interleaved set are believed.
    pub fn record(&self, tracer: String, once: &[Timing], believed: bool) -> DoubledWorkRecord {
        let [single, double] = [once, &self.timings].map(|samples| records::times(samples, believed));
        judged(tracer, single.clock, &single.samples_ms, double.samples_ms, self.not_judged.clone())
    }
}

/// How many times as long work takes twice as once: the ratio of the lower quartiles. What interrupts a sample only ever lengthens it,
/// and threads that begin on one core do so for every third sample; a quarter of the samples knows neither.
pub(super) fn times_as_long(once_ms: &[f64], doubled_work_ms: &[f64]) -> Option<f64> {
    let ratio = percentile(doubled_work_ms, 25.0)? / percentile(once_ms, 25.0)?;
    ratio.is_finite().then_some(ratio)
}

/// What is said of double work beside single work.
pub(crate) fn judged(
    tracer: String,
    clock: ClockKind,
    once_ms: &[f64],
    doubled_work_ms: Vec<f64>,
    not_judged: Option<String>,
) -> DoubledWorkRecord {
    let rounds = doubled_work_ms.len().min(once_ms.len());
    let (ratio, once) = (times_as_long(&once_ms[..rounds], &doubled_work_ms[..rounds]), median(once_ms));
    let too_little = || match () {
        () if rounds < MIN_ROUNDS as usize => Some(format!("{rounds} rounds, fewer than {MIN_ROUNDS}")),
        () if once < MIN_JUDGED_MS => Some(format!("it takes less than {MIN_JUDGED_MS} ms")),
        () => None,
    };
    let not_judged = not_judged.or_else(too_little);
    let [least, most] = takes(clock);
    let passed = not_judged.is_some() || ratio.is_some_and(|ratio| (least..=most).contains(&ratio));
    DoubledWorkRecord { tracer, clock, samples_ms: doubled_work_ms, ratio, not_judged, passed }
}

/// Why times are invalid, if one fails.
pub(crate) fn invalid_reason(doubled_work: &[DoubledWorkRecord]) -> Option<String> {
    let failed = doubled_work.iter().find(|each| !each.passed)?;
    let ratio = failed.ratio.map_or_else(|| "no time".to_owned(), |ratio| format!("{ratio:.2} times as long"));
    let [least, most] = takes(failed.clock);
    Some(format!("{} done twice takes {ratio}, not {least} to {most}", failed.tracer))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(once_ms: f64, factor: f64, rounds: usize) -> DoubledWorkRecord {
        by(ClockKind::Host, once_ms, factor, rounds)
    }

    fn by(clock: ClockKind, once_ms: f64, factor: f64, rounds: usize) -> DoubledWorkRecord {
        let once: Vec<f64> = (0..rounds).map(|round| once_ms * (1.0 + 0.02 * (round % 5) as f64)).collect();
        let doubled_work = once.iter().map(|ms| ms * factor).collect();
        judged("one".to_owned(), clock, &once, doubled_work, None)
    }

    /// Double work must take twice as long: a clock that misses the second half, or counts something thrice, voids times.
    #[test]
    fn double_work_takes_twice_as_long() {
        for factor in [1.86, 2.0, 2.39] {
            let found = said(6.0, factor, 12);
            assert!(found.passed && found.not_judged.is_none() && invalid_reason(&[found]).is_none());
        }
        for factor in [1.0, 1.5, 1.84, 2.41, 3.0] {
            let found = said(6.0, factor, 12);
            assert!(!found.passed, "{factor}");
            assert!(invalid_reason(&[found]).unwrap().contains("times as long"));
        }
        let by_submission = |factor| by(ClockKind::SubmitToDone, 6.0, factor, 12).passed;
        assert_eq!([1.0, 1.74, 1.76, 2.0, 2.19, 2.21].map(by_submission), [false, false, true, true, true, false]);
    }

    /// Proves that samples which the system interrupted do not decide, and that a clock cannot hide behind some that it did not.
    #[test]
    fn interruptions_do_not_decide() {
        let samples =
            |ms: f64, late: usize| -> Vec<f64> { (0..12).map(|at| ms + if at < late { 5.0 } else { 0.0 }).collect() };
        for (once, doubled_work, passes) in [
            (samples(10.0, 7), samples(20.0, 0), true),
            (samples(10.0, 0), samples(20.0, 7), true),
            (samples(10.0, 7), samples(15.0, 0), false),
        ] {
            assert_eq!(judged("one".to_owned(), ClockKind::Host, &once, doubled_work, None).passed, passes);
        }
    }

    /// What is too short, or sampled too seldom, is not judged, whatever it takes; nor is what could not be done.
    #[test]
    fn little_is_not_judged() {
        for found in [said(4.7, 1.0, 12), said(6.0, 1.0, 11)] {
            assert!(found.passed && found.not_judged.is_some());
        }
        let refused = judged("one".to_owned(), ClockKind::Host, &[6.0; 12], Vec::new(), Some("no room".to_owned()));
        assert!(refused.passed && refused.ratio.is_none());
    }
}
