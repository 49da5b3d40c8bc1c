//! The race of a ray set: contenders and controls traced in rounds, then judged.

use tracebench_api::{HitBuffer, Timing};

use super::RunError;
use super::place::{Refusal, Told};
use super::race::{Outcome, Race};
use super::records::{self, Traced};
use super::rounds::Rounds;
use super::session::PreparedRays;
use super::twice::{Double, void_reason};
use crate::judge::true_counts;
use crate::results::{RaceRecord, TraceRecord};

/// Tries at a race: one whose clock fails its control is run again once.
const ATTEMPTS: usize = 2;

/// What the race of a ray set gave.
pub(crate) struct Answered {
    pub outcomes: Vec<Outcome<TraceRecord>>,
    /// Every lane's answers.
    pub told: Vec<Option<Told>>,
    /// What a control scored wrongly.
    pub void: Option<String>,
    /// How it was timed; none where it was not.
    pub race: Option<RaceRecord>,
}

/// What sampling gave.
struct Sampled {
    buffers: Vec<Option<HitBuffer>>,
    timings: Vec<Vec<Timing>>,
    /// Whether timestamps are, in all of the race.
    believed: bool,
    race: Option<RaceRecord>,
}

impl Race<'_> {
    /// One trace each to warm up, then rounds over all lanes; the last timed output is judged. Where the control of a clock fails
    /// the race is run once more; where it fails again its times are void.
    pub fn trace(&mut self, rays: &PreparedRays) -> Result<Answered, RunError> {
        let was_in: Vec<bool> = self.lanes.iter().map(|lane| lane.out.is_none()).collect();
        let mut failed: Option<String> = None;
        let Sampled { buffers, timings, believed, race } = loop {
            let attempt = usize::from(failed.is_some());
            let mut sampled = self.sample(rays, attempt)?;
            let fails = sampled.race.as_ref().and_then(|race| void_reason(&race.twice));
            if let (Some(race), Some(_)) = (&mut sampled.race, &failed) {
                race.repeated_because.clone_from(&failed);
            }
            failed = fails;
            let last = sampled.race.as_ref().is_none_or(|race| race.repeated_because.is_some());
            if failed.is_none() || last || attempt + 1 == ATTEMPTS {
                break sampled;
            }
            self.progress.say(&format!("  {}: once more, {}", rays.set.name, failed.as_deref().unwrap_or_default()));
        };
        // Finding the causes of many wrong rays takes as long as telling the truth of as many.
        let bar = self.progress.bar(&format!("judge {}", rays.set.name), self.lanes.len() as u64);
        let mut answered = Answered { outcomes: Vec::new(), told: Vec::new(), void: None, race };
        for (lane, (buffer, timings)) in buffers.into_iter().zip(timings).enumerate() {
            bar.inc(1);
            let judged = buffer
                .and_then(|buffer| self.judge(lane, rays, &buffer, &timings, believed).transpose())
                .transpose()?;
            let outcome = match (judged, &self.lanes[lane].out) {
                (Some((mut record, told, void)), _) => {
                    let too_coarse = self.ticks().and_then(|ticks| ticks.too_coarse(&record.times));
                    record.doubt_times(failed.clone().or(too_coarse));
                    answered.told.push(Some(told));
                    answered.void = answered.void.or(void);
                    answered.outcomes.push(Outcome::Measured(record));
                    continue;
                }
                (None, Some(refusal)) if was_in[lane] => Outcome::Out(refusal.clone()),
                (None, _) => Outcome::Absent,
            };
            answered.told.push(None);
            answered.outcomes.push(outcome);
        }
        Ok(answered)
    }

    /// Traces in rounds, with those who do it twice behind all lanes.
    fn sample(&mut self, rays: &PreparedRays, attempt: usize) -> Result<Sampled, RunError> {
        let count = self.lanes.len();
        let mut buffers: Vec<Option<HitBuffer>> = Vec::new();
        for lane in 0..count {
            buffers.push(self.attempt_in(lane, |session, contender| session.hit_buffer(contender, rays)));
        }
        let mut doubles = if self.effort.timed { self.doubles(rays) } else { Vec::new() };
        let mut timings: Vec<Vec<Timing>> = vec![Vec::new(); count];
        let seed = self.order_seed(rays.set.name, attempt);
        let sampling = self.effort.timed.then_some(self.effort.sampling);
        let stalls: Vec<usize> = self.contenders().collect();
        let mut rounds = self.rounds(seed, count + doubles.len(), stalls.iter().copied(), sampling);
        let name = format!("trace {}", rays.set.name);
        let bar = self.progress.bar(&name, (rounds.least() * (count + doubles.len())) as u64);
        loop {
            let contenders = || {
                let lanes = self.lanes.iter().zip(&timings).filter(|(lane, _)| lane.control.is_none());
                let doubled = doubles.iter().filter(|double| double.not_judged.is_none()).map(|each| &each.timings[..]);
                [lanes.map(|(_, timings)| &timings[..]).chain(doubled).collect()]
            };
            let Some(round) = rounds.next(self.session.gpu(), contenders)? else { break };
            for place in round.order {
                bar.inc(1);
                match place.checked_sub(count) {
                    Some(double) => self.double(rays, &mut doubles[double], round.counts),
                    None => {
                        let Some(hits) = &mut buffers[place] else { continue };
                        let repeats = self.lanes[place].repeats;
                        let timing =
                            self.attempt_in(place, |session, one| session.sample_trace(one, rays, hits, repeats));
                        timings[place].extend(timing.filter(|_| round.counts));
                    }
                }
            }
        }
        bar.finish_and_clear();
        let lots = timings.iter().chain(doubles.iter().map(|double| &double.timings));
        let believed = records::are_believed(lots.map(Vec::as_slice));
        let race = self.traced(rays, seed, &rounds, &doubles, &timings, believed);
        Ok(Sampled { buffers, timings, believed, race })
    }

    fn traced(
        &self,
        rays: &PreparedRays,
        seed: u64,
        rounds: &Rounds<'_>,
        doubles: &[Double],
        timings: &[Vec<Timing>],
        believed: bool,
    ) -> Option<RaceRecord> {
        let labels = self.lanes.iter().map(super::race::Lane::label);
        let doubled = doubles.iter().map(|double| format!("{} twice", self.lanes[double.lane].label()));
        let mut race = self.record(rays.set.name, seed, rounds, labels.chain(doubled).collect())?;
        let told = |double: &Double| double.record(self.lanes[double.lane].label(), &timings[double.lane], believed);
        race.twice = doubles.iter().map(told).collect();
        Some(race)
    }

    /// Judges a lane's last output; `None` if it was taken out. Beside the record the answers, and what it scored wrongly, if it is
    /// a control.
    fn judge(
        &mut self,
        lane: usize,
        rays: &PreparedRays,
        buffer: &HitBuffer,
        timings: &[Timing],
        believed: bool,
    ) -> Result<Option<(TraceRecord, Told, Option<String>)>, RunError> {
        let counted = self.effort.counted;
        let read = self.attempt_in(lane, |session, contender| {
            let (hits, surfaces) = (buffer.read(session.gpu())?, buffer.read_surfaces(session.gpu())?);
            let counters = if counted { session.count(contender, rays, &hits, &surfaces)? } else { Vec::new() };
            let trace_memory = session.trace_memory(contender, rays)?;
            Ok((hits, surfaces, counters, trace_memory, session.sight(contender)?))
        });
        let Some((hits, surfaces, counters, trace_memory, sight)) = read else { return Ok(None) };
        let session = self.session;
        let contender = self.contender(lane);
        let judged = session
            .judge(contender, rays, &hits)
            .and_then(|judgement| Ok((judgement, session.judge_surfaces(contender, rays, &hits, &surfaces)?)));
        let (mut judgement, surfaces) = match judged {
            Ok(judged) => judged,
            Err(error) if self.effort.lenient => {
                self.take_out(lane, Refusal::of_session(&error));
                return Ok(None);
            }
            Err(error) => return Err(error.into()),
        };
        let mut void = None;
        if let Some(control) = self.lanes[lane].control {
            let counts = true_counts(&rays.answers);
            let of_hits = control.check(&judgement, &counts);
            let of_surfaces = surfaces.as_ref().map_or(Ok(()), |each| control.check_surfaces(each, &counts));
            void = of_hits.and(of_surfaces).err();
            // What a control gets wrong it gets wrong by design.
            judgement.wrong_rays_mut().clear();
        } else if let Some(request) = self.lanes[lane].request.as_ref().filter(|_| self.effort.timed) {
            let label = records::request_record(request).label();
            // A study asks for one tracer at several.
            let at = request
                .resolution
                .map_or_else(String::new, |of| format!(" at frame {}x{}, faces {}", of.frame[0], of.frame[1], of.face));
            self.progress.say(&format!("  {}: {label}{at} done", rays.set.name));
        }
        let end = session.end();
        let record = records::trace_record(Traced {
            rays,
            timings,
            believed,
            hits: &hits,
            counters: &counters,
            trace_memory,
            end,
            judgement,
            surfaces,
        });
        Ok(Some((record, Told { hits, sight }, void)))
    }
}
