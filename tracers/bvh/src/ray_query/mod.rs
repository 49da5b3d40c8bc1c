//! `ray-query`: the acceleration structures of the device's own driver, searched by ray queries in a compute shader.
//!
//! How the driver builds, which nodes it has and by which test it meets triangles is its own: answers hold for the adapter
//! and driver that gave them. What this tracer sees to:
//! - Triangles are opaque and hit from both sides; nothing is culled.
//! - The scene is scaled by a power of two while the driver builds, as for the other hierarchies.
//! - Of hits at equal t the lower primitive is given. A ray query takes whichever it meets first, so the closest hit is
//!   followed by a second query over a narrow span round its t, in which every triangle is looked at. With
//!   `equal_t = first_met` it is not, and the primitive is the driver's choice.
//!
//! What the interface does not give: nodes visited (counted is how often a traversal must be told to proceed that stops
//! before every triangle it would take, and which triangles it
//! would so take), the nodes and triangles touched, the bytes that the driver needs while it builds, and a way to read a structure
//! back (every triangle is looked for by a ray instead).

mod acceleration;
mod description;
mod probes;
mod search;

use std::rc::Rc;
use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Hit, HitBuffer, MemoryEntry, MemoryReport, PhaseClock, Query, Ray, RayBuffer, Residency,
    TraceJob, TraceTo, TracerError,
};

use tracebench_kit::{
    BuildJob, DeviceStructure, DeviceTracer, Gather, RayCounts, Search, SearchJob, SurfaceGeometry, TouchedBits,
    untimed,
};

use acceleration::Acceleration;
pub use description::description;
use description::{EqualT, NO_REFIT, QueryParameters};
use search::{Queries, QuerySettings, Question};

/// The tracer.
pub type RayQuery = DeviceTracer<RayQueryStructure>;

/// Acceleration structures over one scene.
pub struct RayQueryStructure {
    queries: Arc<Queries>,
    acceleration: Rc<Acceleration>,
    triangle_count: usize,
    geometry: SurfaceGeometry,
}

impl RayQueryStructure {
    /// Surfaces, if the job goes that far.
    fn gather(&self, job: &TraceJob<'_>, hits: &HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        match job.trace_to {
            TraceTo::Hit => Ok(()),
            TraceTo::Surface => {
                self.queries.gather.record(&self.queries.gpu, &self.geometry, job.rays, hits, None, clock)
            }
        }
    }

    /// How many triangles were fat enough to be looked for, and that each of them is found. Of large scenes every n-th is
    /// looked at: where triangles overlap, a ray meets many.
    fn find_all(&self, scene: &Geometry) -> Result<usize, TracerError> {
        let gpu = &self.queries.gpu;
        let (rays, fat): (Vec<Ray>, Vec<bool>) =
            probes::probes(&scene.positions, &scene.triangles, MAX_PROBES).into_iter().unzip();
        let rays = RayBuffer::new(Arc::new(rays), Query::Closest, Some(gpu));
        let mut hits = HitBuffer::new(fat.len(), Residency::Device, Some(gpu))?;
        hits.poison(Some(gpu))?;
        let find = Question::FindOwnTriangle;
        untimed(gpu, |clock| self.queries.record(find, &self.acceleration, &rays, &hits, clock))?;
        let lost = |(index, (hit, fat)): (usize, (&Hit, &bool))| (*fat && !hit.is_hit()).then_some(index);
        match hits.read(Some(gpu))?.iter().zip(&fat).enumerate().find_map(lost) {
            Some(index) => {
                Err(TracerError::Failed(format!("triangle {index} is not found by a ray through its middle")))
            }
            None => Ok(fat.iter().filter(|fat| **fat).count()),
        }
    }
}

/// Triangles of a structure that are looked for, about.
const MAX_PROBES: usize = 4096;

/// Whether a job wants the lower primitive of equal hits.
fn wants_lowest(job: &TraceJob<'_>) -> Result<bool, TracerError> {
    Ok(QueryParameters::try_from(job.parameters)?.equal_t == EqualT::Lowest)
}

impl Search for RayQueryStructure {
    type Counting = (RayCounts, TouchedBits);

    fn record(&self, search: SearchJob<'_, '_, Self::Counting>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        let lowest_of_equal = wants_lowest(job)?;
        let question = match counting {
            None => Question::Trace { lowest_of_equal },
            Some((counts, offered)) => {
                Question::TraceCounted { lowest_of_equal, counts: counts.buffer(), offered: offered.buffer() }
            }
        };
        self.queries.record(question, &self.acceleration, job.rays, hits, clock)?;
        self.gather(job, hits, clock)
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &self.queries.gpu;
        let counts = RayCounts::new(gpu, &["proceed_calls"], job.rays.host.len())?;
        let triangles = self.triangle_count as u64;
        let offered = TouchedBits::new(gpu, "triangles offered", triangles, "the scene's triangle count")?;
        let counting = (counts, offered);
        untimed(gpu, |clock| self.record(SearchJob { job, hits, counting: Some(&counting), clock }))?;
        let mut counters = counting.0.counters(gpu)?;
        // Of the nodes and triangles that it touches the driver tells nothing.
        counters.push(Counter::of_set("triangles_offered", counting.1.count(gpu)?));
        Ok(counters)
    }
}

impl DeviceStructure for RayQueryStructure {
    type Pipelines = Queries;

    const NO_REFIT: &'static str = NO_REFIT;

    fn build(queries: &Arc<Queries>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, parameters, before, clock, .. } = job;
        let gpu = &queries.gpu;
        let surfaces = SurfaceGeometry::of(geometry)?;
        let QueryParameters { prefer, .. } = QueryParameters::try_from(parameters)?;
        let acceleration = match before {
            Some(before) if before.acceleration.fits(gpu, geometry, prefer)? => Rc::clone(&before.acceleration),
            _ => Rc::new(Acceleration::new(gpu, geometry, prefer)?),
        };
        acceleration.record_build(gpu, geometry, clock)?;
        let triangle_count = geometry.triangles.len();
        Ok(Self { queries: Arc::clone(queries), acceleration, triangle_count, geometry: surfaces })
    }

    fn memory(&self) -> MemoryReport {
        self.acceleration.memory().with_surface_geometry(self.geometry.bytes)
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let settings = MemoryEntry::whole("settings", size_of::<QuerySettings>() as u64);
        let gather = (job.trace_to == TraceTo::Surface).then(Gather::memory);
        Ok([settings].into_iter().chain(gather).collect())
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let found = self.find_all(geometry)?;
        Ok(vec![("triangles", self.triangle_count as f64), ("triangles_looked_for", found as f64)])
    }
}
