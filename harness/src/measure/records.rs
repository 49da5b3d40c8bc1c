//! From samples, counters and answers to the records of `run.json`.

use std::collections::BTreeMap;

use itertools::Itertools as _;
use tracebench_api::{
    ClockKind, Counter, Hit, HitBuffer, MemoryEntry, Parameters, Status, Timing, TraceTo, Value, Viewpoint,
};
use tracebench_scenes::{Origin, Scene};

use super::controls::Control;
use super::session::PreparedRays;
use crate::plan::TracerRequest;
use crate::results::{
    CounterRecord, Judgement, PhaseRecord, SceneRecord, SurfaceJudgement, Times, TraceRecord, TracerRecord,
    ViewpointRecord, gathered, whole_ns,
};
use crate::statistics::{median, median_interval};

/// A clock's resolution, milliseconds: a shorter time is not told from it, and no speed is infinite.
const MIN_MS: f64 = 1e-6;

/// What a configuration answered to one ray set: its times, the answers that were judged, the counts, the trace's own buffers, how far it
/// went, and the verdicts on hits and surfaces.
pub(crate) fn trace_record(
    rays: &PreparedRays,
    times: Times,
    hits: &[Hit],
    counters: &[Counter],
    trace_memory: Vec<MemoryEntry>,
    trace_to: TraceTo,
    (judgement, surfaces): (Judgement, Option<SurfaceJudgement>),
) -> TraceRecord {
    let status = |hit: &Hit| Status::from_code(hit.status).unwrap_or(Status::Unwritten).name().to_owned();
    let statuses = hits.iter().counts_by(status).into_iter().map(|(name, rays)| (name, rays as u64)).collect();
    let counter = |&Counter { name, total, max_per_ray }: &Counter| {
        let per_ray = total as f64 / hits.len().max(1) as f64;
        (name.to_owned(), CounterRecord { total, per_ray, max_per_ray })
    };
    let per_trace = by_name(HitBuffer::memory(trace_to, hits.len()).into_iter().chain(trace_memory));
    TraceRecord {
        rays: rays.set.name.to_owned(),
        rays_sha256: rays.sha256.clone(),
        query: rays.set.query,
        count: hits.len() as u64,
        trace_to,
        per_trace_bytes: per_trace.iter().map(|entry| entry.allocated_bytes).sum(),
        per_trace,
        mrays_per_s: if times.samples_ms.is_empty() {
            0.0
        } else {
            hits.len() as f64 / times.median_ms.max(MIN_MS) / 1e3
        },
        times,
        hits_sha256: crate::hash::sha256_of(hits),
        same_as_first: None,
        counters: counters.iter().map(counter).collect(),
        statuses,
        judgement,
        surfaces,
        self_reported: None,
    }
}

/// Parts of the same name as one, in the order of their first.
fn by_name(parts: impl Iterator<Item = MemoryEntry>) -> Vec<MemoryEntry> {
    let joined = |(name, parts): (String, Vec<MemoryEntry>)| MemoryEntry {
        name,
        allocated_bytes: parts.iter().map(|part| part.allocated_bytes).sum(),
        used_bytes: parts.iter().map(|part| part.used_bytes).sum(),
    };
    gathered(parts.map(|part| (part.name.clone(), part))).into_iter().map(joined).collect()
}

/// Milliseconds by the host below which a lot's timestamps say nothing of others': submission is too large a part of it.
const TELLING_MS: f64 = 1.0;

/// Whether the timestamps of an interleaved set are believed: those of every lot that is long enough to tell. Where one's are not, nobody's
/// are: times of one interleaved set are by one clock.
pub(crate) fn are_believed<'a>(timed_samples: impl IntoIterator<Item = &'a [Timing]>) -> bool {
    let tells = |samples: &&[Timing]| {
        let waited: Vec<f64> = samples.iter().filter_map(|timing| timing.submit_to_done_ms).collect();
        !waited.is_empty() && median(&waited) >= TELLING_MS
    };
    timed_samples.into_iter().filter(tells).all(Timing::plausible)
}

/// Samples by their own clock, or of work on the device by the host's where their timestamps or those of their interleaved set are not
/// believed.
pub(crate) fn times(timings: &[Timing], interleaved_set_is_believed: bool) -> Times {
    let on_device = timings.iter().any(|timing| timing.submit_to_done_ms.is_some());
    let believed = !on_device || (interleaved_set_is_believed && Timing::plausible(timings));
    let submissions: Vec<_> = timings.iter().filter_map(|timing| timing.submit_to_done_ms.map(whole_ns)).collect();
    let by_submission: Vec<Timing>;
    let timings = if believed {
        timings
    } else {
        by_submission = timings.iter().map(Timing::by_submission).collect();
        &by_submission
    };
    let samples_ms: Vec<f64> = timings.iter().map(|timing| whole_ns(timing.total_ms)).collect();
    let phases: Vec<_> = timings.iter().map(|timing| timing.phases.clone()).collect();
    let (interval_ms, interval_coverage) = median_interval(&samples_ms);
    Times {
        clock: timings.first().map_or(ClockKind::Host, |timing| timing.clock),
        median_ms: median(&samples_ms),
        samples_ms,
        interval_ms,
        interval_coverage,
        phases: PhaseRecord::collect(&phases),
        submit_to_done_median_ms: (!submissions.is_empty()).then(|| median(&submissions)),
        submit_to_done_samples_ms: submissions,
        timestamps_refused: !believed,
        grown_samples: timings.iter().filter(|timing| timing.grown).count() as u64,
        interleaved_set: None,
        invalid: None,
        anchor_scale: None,
    }
}

/// Values as JSON has them.
pub(crate) fn json_values(parameters: &Parameters) -> BTreeMap<String, serde_json::Value> {
    let json = |value: &Value| serde_json::to_value(value).unwrap_or_default();
    parameters.iter().map(|(name, value)| (name.to_owned(), json(value))).collect()
}

/// A control as a tracer.
pub(crate) fn control_record(control: Control) -> TracerRecord {
    let [name, preset, residency] = [control.description().name, "control", "host"].map(str::to_owned);
    TracerRecord { name, preset, parameters: BTreeMap::new(), changed: Vec::new(), residency }
}

/// A tracer as it was asked for, whether it can run or not.
pub(crate) fn request_record(request: &TracerRequest) -> TracerRecord {
    let TracerRequest { registration, preset, parameters, changed, .. } = request;
    let residency = if registration.needs_device() { "device" } else { "host" };
    let [name, preset, residency] = [request.name(), preset.name(), residency].map(str::to_owned);
    TracerRecord { name, preset, parameters: json_values(parameters), changed: changed.clone(), residency }
}

pub(crate) fn scene_record(scene: &Scene) -> SceneRecord {
    SceneRecord {
        name: scene.name.clone(),
        sha256: scene.sha256.clone(),
        triangles: scene.mesh.triangles.len() as u64,
        diagonal: scene.diagonal(),
        scale: match scene.origin {
            Origin::Procedural { scale } => Some(scale),
            Origin::File { .. } => None,
        },
        zero_area_triangles_dropped: scene.notes.zero_area_triangles_dropped,
        duplicate_triangles_kept: scene.notes.duplicate_triangles_kept,
        warnings: scene.notes.warnings.clone(),
    }
}

/// A viewpoint under a name.
pub(crate) fn viewpoint_of(name: &str, viewpoint: &Viewpoint, ray_image: [u32; 2], time_s: f64) -> ViewpointRecord {
    ViewpointRecord {
        name: name.to_owned(),
        eye: viewpoint.eye.into(),
        forward: viewpoint.forward.into(),
        up: viewpoint.up.into(),
        vertical_fov_degrees: viewpoint.vertical_fov.to_degrees(),
        near: viewpoint.near,
        far: viewpoint.far,
        frame: viewpoint.frame,
        face: viewpoint.face,
        ray_image,
        time_s,
        ray_parameters: BTreeMap::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proves that timestamps which cover next to nothing of the submission are replaced by the host's clock, which the
    /// record says, and that others are kept; but where one lot of an interleaved set is not believed no other one is. Times of the host
    /// stay.
    #[test]
    fn timestamps_that_cannot_be_true_are_refused() {
        let sample = |device: f64| Timing {
            clock: ClockKind::DeviceTimestamps,
            total_ms: device,
            phases: Vec::new(),
            submit_to_done_ms: Some(20.0),
            grown: false,
        };
        let by_itself = |samples: &[Timing]| times(samples, are_believed([samples]));
        let (late, sound) = ([sample(0.03), sample(0.04)], [sample(18.0), sample(19.0)]);
        let refused = by_itself(&late);
        assert_eq!((refused.clock, refused.median_ms), (ClockKind::SubmitToDone, 20.0));
        assert!(refused.timestamps_refused && refused.submit_to_done_median_ms == Some(20.0));
        let kept = by_itself(&sound);
        assert_eq!((kept.clock, kept.median_ms), (ClockKind::DeviceTimestamps, 18.5));
        assert!(!kept.timestamps_refused && kept.submit_to_done_median_ms == Some(20.0));
        let beside = times(&sound, are_believed([&late[..], &sound[..]]));
        assert!(beside.timestamps_refused && beside.clock == ClockKind::SubmitToDone);
        // A lot of less than a millisecond is refused by itself.
        let short = Timing { submit_to_done_ms: Some(0.9), ..sample(0.05) };
        let interleaved_set = are_believed([&[short.clone()][..], &sound[..]]);
        assert!(
            interleaved_set
                && times(&[short], interleaved_set).timestamps_refused
                && !times(&sound, interleaved_set).timestamps_refused
        );
        let host = Timing { clock: ClockKind::Host, submit_to_done_ms: None, ..sample(7.0) };
        let of_host = times(&[host], false);
        assert_eq!((of_host.clock, of_host.median_ms, of_host.timestamps_refused), (ClockKind::Host, 7.0, false));
    }
}
