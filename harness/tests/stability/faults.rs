//! Tracers that answer from the truth in f64, all but what a planted fault makes of it. Each has the name of a hierarchy, so that it stands
//! in the tables of these.

use std::sync::LazyLock;

use tracebench_api::{
    Counter, Domain, Geometry, Hit, HitBuffer, MemoryEntry, MemoryReport, NO_PRIMITIVE, ParameterDescription,
    ParameterScope, Parameters, PhaseClock, Residency, Status, Structure, TraceJob, TraceTo, Tracer, TracerDescription,
    TracerError, Update, Value, Viewpoint,
};
use tracebench_harness::measure::controls::Control;
use tracebench_harness::registrations::{Create, Registration, Told};
use tracebench_harness::truth::{Ray64, Truth};

/// What is wrong with a tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing: an oracle.
    None,
    /// It misses every ray.
    Blind,
    /// Of every ten rays it answers the last one wrongly: a hit by a miss, a miss by a hit.
    EveryTenth,
    /// Every third triangle is not in its structure.
    ThirdLeftOut,
}

impl Fault {
    /// Every one.
    pub const ALL: [Fault; 4] = [Self::None, Self::Blind, Self::EveryTenth, Self::ThirdLeftOut];

    /// The tracer's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "bvh-cpu",
            Self::Blind => "bvh-gpu",
            Self::EveryTenth => "ploc-gpu",
            Self::ThirdLeftOut => "ray-query",
        }
    }

    /// What it does wrong, as a tracer of a registry: one with a parameter to sweep, to tune, to shrink and to explain, which changes no
    /// answer.
    pub fn registration(self) -> Registration {
        static TOLD: LazyLock<Told> = LazyLock::new(|| {
            let told = r#"{
                "family": "bvh",
                "remedies": [{"cause": "leaves", "parameter": "leaf", "value": "1", "source": "none"}],
                "shrinks": [{"axis": "leaf", "steps": ["2", "1"]}],
                "sweep": ["leaf"],
                "tune": "leaf"
            }"#;
            serde_json::from_str(told).unwrap()
        });
        let (description, create): (fn() -> TracerDescription, Create) = match self {
            Self::None => (|| describe(Self::None), |_| Ok(Box::new(Self::None))),
            Self::Blind => (|| describe(Self::Blind), |_| Ok(Box::new(Self::Blind))),
            Self::EveryTenth => (|| describe(Self::EveryTenth), |_| Ok(Box::new(Self::EveryTenth))),
            Self::ThirdLeftOut => (|| describe(Self::ThirdLeftOut), |_| Ok(Box::new(Self::ThirdLeftOut))),
        };
        Registration { description, create, parts: None, told: &TOLD }
    }
}

fn describe(fault: Fault) -> TracerDescription {
    let leaf = ParameterDescription {
        name: "leaf",
        unit: "triangles",
        scope: ParameterScope::Build,
        domain: Domain::Integer { least: 1, greatest: 2 },
        published: Value::Integer(2),
        improved: Value::Integer(2),
        effect: "nothing",
        sweep: vec![Value::Integer(1), Value::Integer(2)],
    };
    TracerDescription {
        name: fault.name(),
        residency: Residency::Host,
        no_refit: Some("nothing is fitted"),
        ends: &[TraceTo::Hit],
        parameters: vec![leaf],
        ..Control::Oracle.description()
    }
}

struct Answering {
    fault: Fault,
    truth: Truth,
}

impl Answering {
    fn over(fault: Fault, geometry: &Geometry) -> Result<Self, TracerError> {
        let mut triangles = geometry.triangles.to_vec();
        if fault == Fault::ThirdLeftOut {
            // Its neighbour is in its place, so that all others keep their numbers.
            (2..triangles.len()).step_by(3).for_each(|left_out| triangles[left_out] = triangles[left_out - 1]);
        }
        let geometry = Geometry::new(geometry.positions.to_vec(), triangles, None)?;
        Ok(Self { fault, truth: Truth::new(&geometry, "planted") })
    }

    fn answer(&self, job: TraceJob<'_>, index: usize) -> Hit {
        let ray = &job.rays.host[index];
        let hit = |t: f32, primitive: u32| Hit { t, primitive, u: 0.0, v: 0.0, status: Status::Hit as u32 };
        let found = self.truth.closest(&Ray64::from(ray));
        let errs = self.fault == Fault::EveryTenth && index % 10 == 9;
        match found {
            None if errs => hit(ray.t_max.min((self.truth.diagonal() / 2.0) as f32), NO_PRIMITIVE),
            Some(found) if !errs && self.fault != Fault::Blind => hit(found.t as f32, found.primitive),
            _ => Hit::miss(Status::Miss),
        }
    }
}

impl Tracer for Fault {
    fn build(
        &self,
        geometry: &Geometry,
        _viewpoint: &Viewpoint,
        _parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        Ok(Box::new(clock.host_phase("build", || Answering::over(*self, geometry))?))
    }
}

impl Structure for Answering {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        _viewpoint: &Viewpoint,
        _parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        match update {
            Update::Reuse => {}
            Update::Rebuild => *self = clock.host_phase("build", || Self::over(self.fault, geometry))?,
            Update::Refit => describe(self.fault).serves(update)?,
        }
        Ok(())
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        let hits = hits.host_mut(job.rays.host.len())?;
        clock.host_phase("search", || {
            for (index, hit) in hits.iter_mut().enumerate() {
                *hit = self.answer(job, index);
            }
        });
        Ok(())
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.trace(job, hits, &mut PhaseClock::new(None))?;
        Ok(Vec::new())
    }

    fn memory(&self) -> MemoryReport {
        MemoryReport { structure: vec![MemoryEntry::whole("nodes", 1024)], ..MemoryReport::default() }
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        Ok(Vec::new())
    }
}
