//! Configurations that never hit, and some that cheat or waver on top, which the registry has none of.

use std::cell::Cell;

use tracebench_api::{
    Counter, Geometry, Hit, HitBuffer, MemoryReport, Parameters, PhaseClock, Status, Structure, TraceJob, Tracer,
    TracerError, Update, Viewpoint,
};

/// How a config behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Manner {
    /// Misses every ray, whenever it is asked.
    Honest,
    /// Answers the first trace and leaves what is in the buffer at every later one.
    Idle,
    /// Takes its time at the first trace of a structure, and misses every ray.
    Slow,
    /// Writes other hits when it counts than when it is timed.
    Wavering,
    /// Finds its structure unsound.
    Unsound,
    /// Says of its structure what is no number.
    Numberless,
    /// Does not serve rays, whichever they are.
    Unserving,
    /// Takes its time for a buffer without answers, and none for one that has some; misses every ray.
    Lazy,
}

/// A host tracer that never hits, in a manner of its own.
#[derive(Clone, Copy, Debug)]
pub struct Fake(pub Manner);

struct FakeStructure {
    manner: Manner,
    traced: Cell<usize>,
}

impl Tracer for Fake {
    fn build(
        &self,
        _geometry: &Geometry,
        _viewpoint: &Viewpoint,
        _parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        clock.host_phase("nothing", || ());
        Ok(Box::new(FakeStructure { manner: self.0, traced: Cell::new(0) }))
    }
}

impl Structure for FakeStructure {
    fn update(
        &mut self,
        _update: Update,
        _geometry: &Geometry,
        _viewpoint: &Viewpoint,
        _parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        clock.host_phase("nothing", || ());
        Ok(())
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        if self.manner == Manner::Unserving {
            return Err(TracerError::Unsupported("rays of any kind".to_owned()));
        }
        let hits = hits.host_mut(job.rays.host.len())?;
        clock.host_phase("answer", || {
            if self.manner == Manner::Lazy && hits.iter().all(|hit| hit.status != Status::Miss as u32) {
                std::thread::sleep(std::time::Duration::from_millis(8));
            }
            if self.manner != Manner::Idle || self.traced.get() == 0 {
                hits.fill(Hit::miss(Status::Miss));
            }
            if self.manner == Manner::Slow && self.traced.get() == 0 {
                std::thread::sleep(std::time::Duration::from_millis(200));
            }
        });
        self.traced.set(self.traced.get() + 1);
        Ok(())
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let status = if self.manner == Manner::Wavering { Status::StepCap } else { Status::Miss };
        hits.host_mut(job.rays.host.len())?.fill(Hit::miss(status));
        Ok(Vec::new())
    }

    fn memory(&self) -> MemoryReport {
        MemoryReport::default()
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        match self.manner {
            Manner::Unsound => Err(TracerError::Failed("nothing is where it should be".to_owned())),
            Manner::Numberless => Ok(vec![("nodes", 1.0), ("cost", f64::NAN)]),
            _ => Ok(vec![("nodes", 1.0)]),
        }
    }
}
