//! Contenders side by side: sampled in turn, validated, judged.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use tracebench_api::{Geometry, HitBuffer, Timing, TracerError, Viewpoint};

use super::RunError;
use crate::controls::Control;
use crate::plan::{Resolution, TracerRequest};
use crate::progress::Progress;
use crate::records::{self, Traced};
use crate::results::{TraceRecord, TracerRecord};
use crate::session::{Contender, PreparedRays, Session};

/// A validation that takes longer is told where no bar can be shown.
const LONG_VALIDATION: Duration = Duration::from_secs(2);

/// A contender with what has been measured of it.
pub(crate) struct Entry {
    /// As it was asked for; a control was not.
    pub(crate) request: Option<TracerRequest>,
    /// Which control it is, if it is one.
    pub(crate) control: Option<Control>,
    /// The tracer with what it has built last.
    pub(crate) contender: Contender,
    /// Counted samples of its builds, or of its updates.
    pub(crate) builds: Vec<Timing>,
    /// What it said of its structure.
    pub(crate) statistics: BTreeMap<String, f64>,
    /// Its traces.
    pub(crate) traces: Vec<TraceRecord>,
    /// What took it out of the race.
    pub(crate) failure: Option<TracerError>,
}

impl Entry {
    pub(crate) fn new(contender: Contender, request: Option<TracerRequest>, control: Option<Control>) -> Self {
        Self {
            request,
            control,
            contender,
            builds: Vec::new(),
            statistics: BTreeMap::new(),
            traces: Vec::new(),
            failure: None,
        }
    }

    pub(crate) fn label(&self) -> String {
        self.record().label()
    }

    /// What it builds from: the session's viewpoint, at a resolution of its own if it has one.
    pub(crate) fn viewpoint(&self, session: &Session) -> Viewpoint {
        match self.request.as_ref().and_then(|request| request.resolution) {
            Some(Resolution { frame, face }) => Viewpoint { frame, face, ..*session.viewpoint() },
            None => *session.viewpoint(),
        }
    }

    pub(crate) fn record(&self) -> TracerRecord {
        records::tracer_record(&self.contender, self.request.as_ref())
    }

    /// Does something unless the entry has failed before; a failure takes it out of the race.
    pub(crate) fn attempt<R>(&mut self, work: impl FnOnce(&mut Self) -> Result<R, TracerError>) -> Option<R> {
        if self.failure.is_some() {
            return None;
        }
        work(self).map_err(|error| self.failure = Some(error)).ok()
    }
}

/// One build each to warm up, then rounds over all contenders.
pub(crate) fn sample_builds(session: &Session, entries: &mut [Entry], samples: usize, progress: &Progress) {
    let bar = progress.bar("builds", (samples as u64 + 1) * entries.len() as u64);
    for round in 0..=samples {
        for entry in entries.iter_mut() {
            let viewpoint = entry.viewpoint(session);
            let build = |entry: &mut Entry| entry.contender.build(session.geometry(), &viewpoint, session.gpu());
            let timing = entry.attempt(build);
            if let Some(timing) = timing.filter(|_| round > 0) {
                entry.builds.push(timing);
            }
            bar.inc(1);
        }
    }
}

/// Lets every contender read its structure back and check it against the scene that it was last built over, outside of any
/// time. What is unsound, or says of itself what is no number, takes the contender out of the race.
pub(crate) fn validate(geometry: &Geometry, entries: &mut [Entry], progress: &Progress) {
    let bar = progress.bar("validate", entries.len() as u64);
    for entry in entries.iter_mut() {
        let begin = Instant::now();
        let statistics = entry.attempt(|entry| {
            let found = entry.contender.structure()?.validate(geometry)?;
            match found.iter().find(|(_, value)| !value.is_finite()) {
                Some((name, value)) => Err(TracerError::Failed(format!("its structure says that {name} is {value}"))),
                None => Ok(found.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()),
            }
        });
        entry.statistics = statistics.unwrap_or_default();
        bar.inc(1);
        if begin.elapsed() > LONG_VALIDATION {
            progress.say(&format!("  validated {} in {:.0} s", entry.label(), begin.elapsed().as_secs_f64()));
        }
    }
}

/// What the rounds over one ray set gave for one contender.
struct Sampled {
    hits: HitBuffer,
    timings: Vec<Timing>,
}

/// One trace each to warm up, then rounds over all contenders; the last timed output is judged.
pub(crate) fn sample_traces(
    session: &Session,
    rays: &PreparedRays,
    entries: &mut [Entry],
    samples: usize,
    progress: &Progress,
) -> Result<(), RunError> {
    let bar = progress.bar(&format!("trace {}", rays.set.name), (samples as u64 + 1) * entries.len() as u64);
    let mut sampled: Vec<Option<Sampled>> = Vec::new();
    for entry in entries.iter_mut() {
        let hits = entry.attempt(|entry| session.hit_buffer(&entry.contender, rays));
        sampled.push(hits.map(|hits| Sampled { hits, timings: Vec::new() }));
    }
    for round in 0..=samples {
        for (entry, sampled) in entries.iter_mut().zip(&mut sampled) {
            bar.inc(1);
            let Some(sampled) = sampled else { continue };
            let timing = entry.attempt(|entry| session.sample_trace(&entry.contender, rays, &mut sampled.hits));
            if let Some(timing) = timing.filter(|_| round > 0) {
                sampled.timings.push(timing);
            }
        }
    }
    bar.finish_and_clear();
    // Finding the causes of many wrong rays takes as long as telling the truth of as many.
    let bar = progress.bar(&format!("judge {}", rays.set.name), entries.len() as u64);
    for (entry, sampled) in entries.iter_mut().zip(sampled) {
        bar.inc(1);
        let Some(Sampled { hits, timings }) = sampled else { continue };
        let answered = entry.attempt(|entry| {
            let (hits, surfaces) = (hits.read(session.gpu())?, hits.read_surfaces(session.gpu())?);
            let counters = session.count(&entry.contender, rays, &hits, &surfaces)?;
            Ok((hits, surfaces, counters))
        });
        let Some((hits, surfaces, counters)) = answered else { continue };
        let mut judgement = session.judge(&entry.contender, rays, &hits)?;
        let surfaces = session.judge_surfaces(&entry.contender, rays, &hits, &surfaces)?;
        if let Some(control) = entry.control {
            let (occluded, free) = rays.hits_and_misses();
            control.check(&judgement, occluded, free).map_err(RunError::Control)?;
            if let Some(surfaces) = &surfaces {
                control.check_surfaces(surfaces, occluded, free).map_err(RunError::Control)?;
            }
            // What a control gets wrong it gets wrong by design.
            judgement.wrong_rays_mut().clear();
        } else {
            progress.say(&format!("  {}: {} done", rays.set.name, entry.label()));
        }
        let trace_memory = session.trace_memory(&entry.contender, rays)?;
        let end = session.end();
        let (timings, hits, counters) = (&timings[..], &hits[..], &counters[..]);
        let traced = Traced { rays, timings, hits, counters, trace_memory, end, judgement, surfaces };
        entry.traces.push(records::trace_record(traced));
    }
    Ok(())
}
