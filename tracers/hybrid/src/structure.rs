//! The structures of both parts, and traces through them.

use std::rc::Rc;
use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, MemoryEntry, MemoryReport, Parameters, PhaseClock, SampledImage, Structure,
    TraceJob, Tracer, TracerError, Update, View, Viewpoint, VoxelGrid,
};
use tracebench_kit::untimed;

use crate::description::{HybridParameters, PARTS, Part, interned};
use crate::handover::{self, Handover};

/// `hybrid`, of two tracers on the same device.
pub struct Hybrid {
    tracers: [Box<dyn Tracer>; 2],
    shared: Rc<Shared>,
}

/// What its structures have of it.
struct Shared {
    parts: [Part; 2],
    handover: Handover,
}

struct HybridStructure {
    shared: Rc<Shared>,
    structures: [Box<dyn Structure>; 2],
    /// That of the viewpoint.
    frame: View,
}

/// An error of a part; where the device has no room for it, it says for which.
fn of_part(part: &Part, error: TracerError) -> TracerError {
    let told = |reason: String| format!("{} in a hybrid: {reason}", part.name);
    match error {
        TracerError::Unavailable(reason) => TracerError::Unavailable(told(reason)),
        TracerError::TooLarge { name, bytes, limit, hint } => {
            TracerError::TooLarge { name: told(name), bytes, limit, hint }
        }
        other => other,
    }
}

fn prefixed(place: usize, entries: Vec<MemoryEntry>) -> impl Iterator<Item = MemoryEntry> {
    entries.into_iter().map(move |entry| MemoryEntry { name: format!("{}: {}", PARTS[place], entry.name), ..entry })
}

impl Hybrid {
    /// Of two tracers as parts describe them.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] if the device's limits forbid it, [`TracerError::Failed`] if it refuses a pipeline.
    pub fn new(gpu: Arc<Gpu>, parts: [Part; 2], tracers: [Box<dyn Tracer>; 2]) -> Result<Self, TracerError> {
        Ok(Self { tracers, shared: Rc::new(Shared { parts, handover: Handover::new(gpu)? }) })
    }
}

impl Shared {
    /// Does something to a part, whose phases and errors tell that they are its.
    fn with_part<R>(
        &self,
        place: usize,
        clock: &mut PhaseClock<'_>,
        work: impl FnOnce(&mut PhaseClock<'_>) -> Result<R, TracerError>,
    ) -> Result<R, TracerError> {
        clock.within(PARTS[place], work).map_err(|error| of_part(&self.parts[place], error))
    }
}

impl Tracer for Hybrid {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        HybridParameters::of(parameters)?;
        let mut build = |place: usize| {
            let told = self.shared.parts[place].parameters(place, parameters)?;
            let work = |clock: &mut PhaseClock<'_>| self.tracers[place].build(geometry, viewpoint, &told, clock);
            self.shared.with_part(place, clock, work)
        };
        let structures = [build(0)?, build(1)?];
        let shared = Rc::clone(&self.shared);
        Ok(Box::new(HybridStructure { shared, structures, frame: viewpoint.frame_view() }))
    }
}

impl HybridStructure {
    /// The part that is asked how it sees the scene: the first, unless it holds the scene itself.
    fn seeing(&self, parameters: &Parameters) -> Result<(&dyn Structure, Parameters), TracerError> {
        let (first, told) = (&*self.structures[0], self.shared.parts[0].parameters(0, parameters)?);
        if first.samplings(&told)?.is_empty() && first.voxels(&told)?.is_none() {
            return Ok((&*self.structures[1], self.shared.parts[1].parameters(1, parameters)?));
        }
        Ok((first, told))
    }
}

impl Structure for HybridStructure {
    /// The second goes first: a refit may be refused, and then nothing has changed. Where the first has no room the second has followed.
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let shared = Rc::clone(&self.shared);
        for place in [1, 0] {
            // A first without a refit is built anew beside a second that has one.
            let is_served = place == 1 || shared.parts[place].description.serves(update).is_ok();
            let own = if is_served { update } else { Update::Rebuild };
            let told = shared.parts[place].parameters(place, parameters)?;
            let structure = &mut self.structures[place];
            shared.with_part(place, clock, |clock| structure.update(own, geometry, viewpoint, &told, clock))?;
        }
        if update != Update::Reuse {
            self.frame = viewpoint.frame_view();
        }
        Ok(())
    }

    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        let [first, then] = &mut self.structures;
        Ok(first.grow_on_overflow()? | then.grow_on_overflow()?)
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        let (shared, handover) = (&*self.shared, &self.shared.handover);
        let own = HybridParameters::of(job.parameters)?;
        let [first, then] =
            [shared.parts[0].parameters(0, job.parameters)?, shared.parts[1].parameters(1, job.parameters)?];
        let asked = TraceJob { parameters: &first, ..job };
        shared.with_part(0, clock, |clock| self.structures[0].trace(asked, hits, clock))?;
        let mut handed = handover.record(&self.frame, &own, &job, hits, clock)?;
        let asked = TraceJob { parameters: &then, rays: &handed.rays, ..job };
        shared.with_part(1, clock, |clock| self.structures[1].trace(asked, &mut handed.hits, clock))?;
        handover.join(&handed, job.trace_to, hits, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let (shared, handover) = (&*self.shared, &self.shared.handover);
        let own = HybridParameters::of(job.parameters)?;
        let told = [shared.parts[0].parameters(0, job.parameters)?, shared.parts[1].parameters(1, job.parameters)?];
        let of = |place: usize, rays, hits: &mut HitBuffer| {
            let counted =
                self.structures[place].trace_counted(TraceJob { parameters: &told[place], rays, ..job }, hits);
            let counters = counted.map_err(|error| of_part(&shared.parts[place], error))?;
            let named = move |counter: Counter| Counter {
                name: interned(format!("{}.{}", PARTS[place], counter.name)),
                ..counter
            };
            Ok::<_, TracerError>(counters.into_iter().map(named))
        };
        let mut counters: Vec<Counter> = of(0, job.rays, hits)?.collect();
        let gpu = &handover.gpu;
        let mut handed = untimed(gpu, |clock| handover.record(&self.frame, &own, &job, hits, clock))?;
        counters.extend(of(1, &handed.rays, &mut handed.hits)?);
        untimed(gpu, |clock| handover.join(&handed, job.trace_to, hits, clock))?;
        counters.push(Counter::of_set("rays_handed_over", handover.count(&handed)?));
        Ok(counters)
    }

    /// Both read the same scene.
    fn memory(&self) -> MemoryReport {
        let [first, then] = [self.structures[0].memory(), self.structures[1].memory()];
        MemoryReport {
            geometry_bytes: first.geometry_bytes.max(then.geometry_bytes),
            surface_geometry_bytes: first.surface_geometry_bytes.max(then.surface_geometry_bytes),
            build_peak_bytes: first.build_peak_bytes + then.build_peak_bytes,
            structure: prefixed(0, first.structure).chain(prefixed(1, then.structure)).collect(),
        }
    }

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let mut entries = handover::memory(job.trace_to, job.rays.host.len());
        for place in [0, 1] {
            let told = self.shared.parts[place].parameters(place, job.parameters)?;
            entries
                .extend(prefixed(place, self.structures[place].trace_memory(TraceJob { parameters: &told, ..job })?));
        }
        Ok(entries)
    }

    fn samplings(&self, parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        let (structure, told) = self.seeing(parameters)?;
        structure.samplings(&told)
    }

    fn voxels(&self, parameters: &Parameters) -> Result<Option<VoxelGrid>, TracerError> {
        let (structure, told) = self.seeing(parameters)?;
        structure.voxels(&told)
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let mut found = Vec::new();
        for (place, structure) in self.structures.iter().enumerate() {
            let told = structure.validate(geometry).map_err(|error| of_part(&self.shared.parts[place], error))?;
            found.extend(told.into_iter().map(|(name, value)| (interned(format!("{}.{name}", PARTS[place])), value)));
        }
        Ok(found)
    }
}
