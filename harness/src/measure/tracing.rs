//! The interleaved set of a ray set: configurations and controls traced in rounds, then judged.

use tracebench_api::{Hit, HitBuffer, Query, Timing};

use super::RunError;
use super::controls::checked;
use super::doubled_work::{DoubledWork, invalid_reason};
use super::interleaved_set::{InterleavedSet, Participant};
use super::records;
use super::session::PreparedRays;
use super::workload::{Observations, Refusal};
use crate::judge::true_counts;
use crate::results::{InterleavedSetRecord, TraceRecord};
use crate::truth::tight_tolerance;

/// Tries at an interleaved set: one whose clock fails its control is run again once.
const ATTEMPTS: usize = 2;

/// What the interleaved set of a ray set gave.
pub(crate) struct Answered {
    /// By participant, or why it was taken out or does not serve these rays.
    pub outcomes: Vec<Result<TraceRecord, Refusal>>,
    /// Every participant's answers.
    pub told: Vec<Option<Observations>>,
    /// What a control scored wrongly.
    pub invalid: Option<String>,
    /// How it was timed; none where it was not.
    pub interleaved_set: Option<InterleavedSetRecord>,
}

/// What sampling gave.
struct Sampled {
    buffers: Vec<Option<HitBuffer>>,
    timings: Vec<Vec<Timing>>,
    /// Whether timestamps are, in all of the interleaved set.
    believed: bool,
    interleaved_set: Option<InterleavedSetRecord>,
}

impl InterleavedSet<'_> {
    /// One trace each to warm up, then rounds over all participants; the last timed output is judged. Where the control of a clock fails
    /// the interleaved set is run once more; where it fails again its times are invalid.
    pub fn trace(&mut self, rays: &PreparedRays) -> Result<Answered, RunError> {
        self.participants.iter_mut().for_each(|participant| participant.unserved = None);
        let mut failed: Option<String> = None;
        let Sampled { buffers, timings, believed, interleaved_set } = loop {
            let attempt = usize::from(failed.is_some());
            let mut sampled = self.sample(rays, attempt)?;
            let before = failed.take();
            if let Some(interleaved_set) = &mut sampled.interleaved_set {
                failed = invalid_reason(&interleaved_set.doubled_work);
                interleaved_set.repeated_because = before;
            }
            if failed.is_none() || attempt + 1 == ATTEMPTS {
                break sampled;
            }
            self.progress.say(&format!("  {}: once more, {}", rays.set.name, failed.as_deref().unwrap_or_default()));
        };
        // Finding the causes of many wrong rays takes as long as telling the truth of as many.
        let bar = self.progress.bar(&format!("judge {}", rays.set.name), self.participants.len() as u64);
        let mut answered = Answered { outcomes: Vec::new(), told: Vec::new(), invalid: None, interleaved_set };
        for (participant, (buffer, timings)) in buffers.into_iter().zip(timings).enumerate() {
            bar.inc(1);
            let judged = match buffer {
                Some(buffer) => self.judge(participant, rays, &buffer, &timings, believed)?,
                None => None,
            };
            let Some((mut record, told, invalid)) = judged else {
                answered.told.push(None);
                answered.outcomes.push(Err(self.participants[participant].refusal()));
                continue;
            };
            let too_coarse = self.ticks().and_then(|ticks| ticks.too_coarse(&record.times));
            // No speed is made of times that may not be believed.
            if let Some(why) = failed.clone().or(too_coarse) {
                (record.times.invalid, record.mrays_per_s) = (Some(why), 0.0);
            }
            let tolerance = |t| match rays.set.query {
                Query::Closest => tight_tolerance(t, self.session.geometry().diagonal()),
                Query::Any => f64::INFINITY,
            };
            let first = self.first_of_tracer(participant, &answered.told);
            record.same_as_first = first.map(|first| same_answers(first, &told.hits, tolerance));
            answered.told.push(Some(told));
            answered.invalid = answered.invalid.or(invalid);
            answered.outcomes.push(Ok(record));
        }
        Ok(answered)
    }

    /// What the first participant with the same tracer answered; none of that participant itself, and of controls.
    fn first_of_tracer<'a>(&self, participant: usize, told: &'a [Option<Observations>]) -> Option<&'a [Hit]> {
        let name = |place: usize| {
            let Participant { slot, control, .. } = &self.participants[place];
            control.is_none().then(|| self.slots[*slot].config.description.name)
        };
        let own = name(participant)?;
        let mut answered = told.iter().enumerate().filter_map(|(place, told)| Some((place, told.as_ref()?)));
        answered.find(|(place, _)| name(*place) == Some(own)).map(|(_, told)| told.hits.as_slice())
    }

    /// Traces in rounds, with those who do it twice behind all participants.
    fn sample(&mut self, rays: &PreparedRays, attempt: usize) -> Result<Sampled, RunError> {
        let count = self.participants.len();
        let mut buffers: Vec<Option<HitBuffer>> = Vec::new();
        for participant in 0..count {
            buffers.push(self.attempt_in(participant, |session, config| session.hit_buffer(config, rays)));
        }
        let sampling = self.options.sampling;
        let mut doubles = if sampling.is_some() { self.doubles(rays) } else { Vec::new() };
        let mut timings: Vec<Vec<Timing>> = vec![Vec::new(); count];
        let is_tracer = |participant: &&Participant| participant.control.is_none() && participant.out.is_none();
        let slots = self.participants.iter().filter(is_tracer).map(|participant| participant.slot);
        let mut rounds = self.rounds((rays.set.name, attempt), count + doubles.len(), slots, sampling);
        let name = format!("trace {}", rays.set.name);
        let bar = self.progress.bar(&name, (rounds.least() * (count + doubles.len())) as u64);
        loop {
            let configs = || {
                let participants =
                    self.participants.iter().zip(&timings).filter(|(participant, _)| participant.control.is_none());
                let doubled = doubles.iter().filter(|double| double.not_judged.is_none()).map(|each| &each.timings[..]);
                [participants.map(|(_, timings)| &timings[..]).chain(doubled).collect()]
            };
            let Some(round) = rounds.next(self.session.gpu(), configs)? else { break };
            for place in round.order {
                bar.inc(1);
                match place.checked_sub(count) {
                    Some(double) => self.double(rays, &mut doubles[double], round.counts),
                    None => {
                        let Some(hits) = &mut buffers[place] else { continue };
                        let repeats = self.participants[place].repeats;
                        let timing =
                            self.attempt_in(place, |session, one| session.sample_trace(one, rays, hits, repeats));
                        timings[place].extend(timing.filter(|_| round.counts));
                    }
                }
            }
        }
        bar.finish_and_clear();
        let timed_samples = timings.iter().chain(doubles.iter().map(|double| &double.timings));
        let believed = records::are_believed(timed_samples.map(Vec::as_slice));
        let labels = self.participants.iter().map(Participant::label);
        let doubled = doubles.iter().map(|double| format!("{} twice", self.participants[double.participant].label()));
        let interleaved_set = self.setting.record(rays.set.name, &rounds, labels.chain(doubled).collect());
        let told = |double: &DoubledWork| {
            double.record(self.participants[double.participant].label(), &timings[double.participant], believed)
        };
        let doubled_work = doubles.iter().map(told).collect();
        let interleaved_set = interleaved_set.map(|record| InterleavedSetRecord { doubled_work, ..record });
        Ok(Sampled { buffers, timings, believed, interleaved_set })
    }

    /// Judges a participant's last output; `None` if it was taken out. Beside the record the answers, and what it scored wrongly, if it is
    /// a control.
    fn judge(
        &mut self,
        participant: usize,
        rays: &PreparedRays,
        buffer: &HitBuffer,
        timings: &[Timing],
        believed: bool,
    ) -> Result<Option<(TraceRecord, Observations, Option<String>)>, RunError> {
        let counted = self.options.counted;
        let read = self.attempt_in(participant, |session, config| {
            let (hits, surfaces) = (buffer.read(session.gpu())?, buffer.read_surfaces(session.gpu())?);
            let counters = if counted { session.count(config, rays, &hits, &surfaces)? } else { Vec::new() };
            let trace_memory = session.trace_memory(config, rays)?;
            Ok((hits, surfaces, counters, trace_memory, session.sampling_model(config)?))
        });
        let Some((hits, surfaces, counters, trace_memory, sampling_model)) = read else { return Ok(None) };
        let session = self.session;
        let config = self.config(participant);
        let judged = session
            .judge(config, rays, &hits)
            .and_then(|judgement| Ok((judgement, session.judge_surfaces(config, rays, &hits, &surfaces)?)));
        let (mut judgement, surfaces) = match judged {
            Ok(judged) => judged,
            Err(error) if self.options.lenient => {
                self.take_out(participant, Refusal { reason: error.to_string(), ..Refusal::default() });
                return Ok(None);
            }
            Err(error) => return Err(error.into()),
        };
        let mut invalid = None;
        if let Some(control) = self.participants[participant].control {
            let counts = true_counts(&rays.answers);
            let of_hits = checked(control, &judgement, &rays.answers);
            let of_surfaces = surfaces.as_ref().map_or(Ok(()), |each| control.check_surfaces(each, &counts));
            invalid = of_hits.and(of_surfaces).err();
            // What a control gets wrong it gets wrong by design.
            judgement.wrong_rays_mut().clear();
        } else if let (Some(request), Some(_)) = (&self.participants[participant].request, self.options.sampling) {
            let label = records::request_record(request).label();
            // A study asks for one tracer at several.
            let at = request
                .resolution
                .map_or_else(String::new, |of| format!(" at frame {}x{}, faces {}", of.frame[0], of.frame[1], of.face));
            self.progress.say(&format!("  {}: {label}{at} done", rays.set.name));
        }
        let (times, trace_to) = (records::times(timings, believed), session.trace_to);
        let verdicts = (judgement, surfaces);
        let record = records::trace_record(rays, times, &hits, &counters, trace_memory, trace_to, verdicts);
        Ok(Some((record, Observations { hits, sampling_model }, invalid)))
    }
}

/// How many rays two answer alike: both miss, or both hit at a t within a tolerance.
fn same_answers(first: &[Hit], own: &[Hit], tolerance: impl Fn(f64) -> f64) -> u64 {
    let same = |first: &Hit, own: &Hit| {
        let [t, own_t] = [first.t, own.t].map(f64::from);
        let near = || (t - own_t).abs() <= tolerance(t);
        first.is_hit() == own.is_hit() && (!own.is_hit() || near())
    };
    first.iter().zip(own).filter(|(first, own)| same(first, own)).count() as u64
}

#[cfg(test)]
mod tests {
    use tracebench_api::{NO_PRIMITIVE, Status};

    use super::*;

    /// Proves that misses of any status are alike, hits within the tolerance, and a hit and a miss not.
    #[test]
    fn answers_are_alike_within_tight() {
        let hit = |t: f32| Hit { t, primitive: NO_PRIMITIVE, u: 0.0, v: 0.0, status: Status::Hit as u32 };
        let (miss, left) = (Hit::miss(Status::Miss), Hit::miss(Status::LeftViews));
        let first = [hit(10.0), hit(10.0), hit(10.0), miss, miss];
        let own = [hit(10.0005), hit(10.01), miss, hit(10.0), left];
        assert_eq!(same_answers(&first, &own, |t| tight_tolerance(t, 1.0)), 2);
        assert_eq!(same_answers(&first, &own, |_| f64::INFINITY), 3);
        assert_eq!(same_answers(&first, &first, |_| 0.0), 5);
    }
}
