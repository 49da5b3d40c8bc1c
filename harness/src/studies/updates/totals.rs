//! What comes of frames along the camera's path: every tracer's way through all of them, and the time of all together.

use tracebench_api::{ClockKind, Update};

use crate::results::{FRESH_BUILD, Record, Row, SceneFollowed, Times, TraceRecord, host_ms};

/// A tracer that goes one way through the frames of a scene, with the rays of one set.
#[derive(Clone, Debug)]
pub struct Walker<'a> {
    /// The way.
    pub update_mode: &'a str,
    /// What makes its structure stale at any frame.
    pub stale_by: Vec<&'a str>,
    /// By frame, the first a fresh build; `None` where it could not be measured.
    pub frames: Vec<Option<(&'a Row, &'a TraceRecord)>>,
}

/// The time of all frames together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Total {
    /// The clock that timed every part; that of the host round submissions, where they are not of one clock.
    pub clock: ClockKind,
    /// Milliseconds.
    pub ms: f64,
    /// The same by the host's clock, where every part has such a time.
    pub host_ms: Option<f64>,
}

/// Every tracer and way through a scene's frames with a set of rays, in the order of rows.
pub fn walkers<'a>(record: &'a Record, scene: &'a SceneFollowed, rays: &str) -> Vec<Walker<'a>> {
    let update_mode =
        |row: &'a Row| row.update_mode.as_ref().map_or(FRESH_BUILD, |update_mode| update_mode.name.as_str());
    let trace = |row: &'a Row| Some((row, row.traces.iter().find(|trace| trace.rays == rays)?));
    let at = |frame: usize| {
        let is_there = move |row: &&Row| {
            let there = row.update_mode.as_ref().and_then(|update_mode| update_mode.frame_index) == Some(frame as u32);
            there && row.scene.name == scene.scene && row.scene.sha256 == scene.frame_scene_sha256[frame]
        };
        record.rows.iter().filter(is_there)
    };
    let mut walkers: Vec<Walker<'a>> = Vec::new();
    for first in at(0) {
        for row in (1..scene.frame_scene_sha256.len()).flat_map(at).filter(|row| row.tracer == first.tracer) {
            let frame = row
                .update_mode
                .as_ref()
                .and_then(|update_mode| update_mode.frame_index)
                .map_or(0, |frame| frame as usize);
            let known = walkers.iter().position(|known| {
                let of = known.frames[0].map(|(first, _)| &first.tracer);
                of == Some(&first.tracer) && known.update_mode == update_mode(row)
            });
            let known = known.unwrap_or_else(|| {
                let mut frames = vec![None; scene.frame_scene_sha256.len()];
                frames[0] = trace(first);
                walkers.push(Walker { update_mode: update_mode(row), stale_by: Vec::new(), frames });
                walkers.len() - 1
            });
            let walker = &mut walkers[known];
            walker.frames[frame] = trace(row);
            for change in row.update_mode.iter().flat_map(|update_mode| &update_mode.stale_by) {
                if !walker.stale_by.contains(&change.as_str()) {
                    walker.stale_by.push(change);
                }
            }
        }
    }
    walkers
}

impl<'a> Walker<'a> {
    /// The time of the first build, of what brings the structure to every later frame, and of the traces of all; `None` where a
    /// part has none.
    pub fn total(&self) -> Option<Total> {
        let mut parts: Vec<&Times> = Vec::new();
        for (frame, there) in self.frames.iter().enumerate() {
            let (row, trace) = (*there)?;
            // What is reused has nothing done to it.
            let done = frame == 0 || self.update_mode != Update::Reuse.name();
            parts.extend(done.then(|| row.build.first()));
            parts.push(&trace.times);
        }
        Total::of(&parts)
    }

    /// The time of what brought the structure to a frame, at the first of a build; `None` where nothing was done or timed.
    pub fn update(&self, frame: usize) -> Option<&'a Times> {
        let (row, _) = self.frames.get(frame).copied().flatten()?;
        Some(row.build.first()).filter(|times| !times.samples_ms.is_empty())
    }
}

impl Total {
    /// All parts together; `None` if one has no time.
    fn of(parts: &[&Times]) -> Option<Self> {
        let clock = parts.first()?.clock;
        let own = |times: &Times| (!times.samples_ms.is_empty() && times.clock == clock).then_some(times.median_ms);
        let sum = |of: &dyn Fn(&Times) -> Option<f64>| parts.iter().map(|times| of(times)).sum::<Option<f64>>();
        let by_host = sum(&host_ms);
        match sum(&own) {
            Some(ms) => Some(Self { clock, ms, host_ms: by_host }),
            None => by_host.map(|ms| Self { clock: ClockKind::SubmitToDone, ms, host_ms: Some(ms) }),
        }
    }

    /// How many times as long as another one: by the clock of both, else by the host's.
    pub fn over(&self, other: &Self) -> Option<f64> {
        let [own, others] =
            if self.clock == other.clock { [self.ms, other.ms] } else { [self.host_ms?, other.host_ms?] };
        (others > 0.0).then_some(own / others)
    }
}
