//! What a tracer answered to one ray set.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tracebench_api::{MemoryEntry, Query, TraceTo};

use super::{Judgement, SurfaceJudgement, Times};

/// One ray set traced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TraceRecord {
    /// Ray set.
    pub rays: String,
    /// Hash of the rays.
    pub rays_sha256: String,
    /// What was asked.
    pub query: Query,
    /// Number of rays.
    pub count: u64,
    /// How far it went.
    pub trace_to: TraceTo,
    /// Its times.
    #[serde(flatten)]
    pub times: Times,
    /// Million rays a second at the median; 0 where nothing was timed and where times are invalid.
    pub mrays_per_s: f64,
    /// Allocated bytes of all parts of `per_trace`.
    pub per_trace_bytes: u64,
    /// What a trace takes: rays, hits, surfaces, and the tracer's own buffers by the names of its paper. Empty in files of
    /// before it was told by parts.
    #[serde(default)]
    pub per_trace: Vec<MemoryEntry>,
    /// Hash of the judged hits.
    pub hits_sha256: String,
    /// Rays that were answered as by the first row of the same tracer in the interleaved set: both miss, or both hit at a t that `tight` takes
    /// for the same. None of that first row, and in files of before it was told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub same_as_first: Option<u64>,
    /// Counts, from a variant that is not timed.
    pub counters: BTreeMap<String, CounterRecord>,
    /// How many rays ended with which status.
    pub statuses: BTreeMap<String, u64>,
    /// The judge's verdict on the last timed output.
    pub judgement: Judgement,
    /// The verdict on its surfaces, where it has any.
    pub surfaces: Option<SurfaceJudgement>,
    /// Times that a program which is no tracer of this suite tells of itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub self_reported: Option<SelfReported>,
}

/// Times that a program tells of itself: a column beside what was judged, never a verdict.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelfReported {
    /// Building its structure, milliseconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub build_ms: Option<f64>,
    /// Tracing all rays, milliseconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trace_ms: Option<f64>,
}

impl TraceRecord {
    /// Says why its times may not be believed, if they may not: no speed is made of them.
    pub fn doubt_times(&mut self, why: Option<String>) {
        if why.is_some() {
            (self.times.invalid, self.mrays_per_s) = (why, 0.0);
        }
    }
}

/// A count over a ray set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CounterRecord {
    /// Over all rays.
    pub total: u64,
    /// Mean per ray.
    pub per_ray: f64,
    /// The largest of any one ray.
    pub max_per_ray: Option<u64>,
}
