//! Tracers that take part, and what they have built.

use std::rc::Rc;
use std::time::Instant;

use tracebench_api::{
    ClockKind, Geometry, Gpu, Parameters, PhaseClock, Residency, Structure, Timing, Tracer, TracerDescription,
    TracerError, Update, Viewpoint,
};

use crate::plan::TracerRequest;
use crate::registry::Device;

/// A build or an update, timed twice over.
#[derive(Clone, Debug)]
pub struct BuildSample {
    /// The phases that the tracer marks; where memory had been too small, those of the rebuild.
    pub phases: Timing,
    /// All of it by the host's clock, from the call until the device is idle, with growth and the rebuild that follows it.
    pub whole: Timing,
}

/// A tracer that takes part, with what it has built last.
pub struct TracerConfig {
    /// What it is.
    pub description: TracerDescription,
    /// With which parameters.
    pub parameters: Parameters,
    /// Time to create it, milliseconds.
    pub setup_ms: f64,
    /// The host's clock, by which builds as a whole are timed.
    pub now: fn() -> Instant,
    tracer: Rc<dyn Tracer>,
    structure: Option<Box<dyn Structure>>,
}

impl TracerConfig {
    /// Takes a tracer that needs no creating.
    pub fn ready(description: TracerDescription, parameters: Parameters, tracer: Box<dyn Tracer>) -> Self {
        let tracer = Rc::from(tracer);
        Self { description, parameters, setup_ms: 0.0, now: Instant::now, tracer, structure: None }
    }

    /// The same tracer without a structure.
    fn afresh(&self) -> Self {
        let (description, parameters) = (self.description.clone(), self.parameters.clone());
        Self { description, parameters, tracer: Rc::clone(&self.tracer), structure: None, ..*self }
    }

    /// Builds over triangles and gives the times: a first build. The structure replaces the last one, which is dropped before, outside
    /// of the times.
    ///
    /// # Errors
    /// What the tracer says.
    pub fn build(
        &mut self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        gpu: Option<&Gpu>,
    ) -> Result<BuildSample, TracerError> {
        self.structure = None;
        let begin = self.idle(gpu)?;
        let mut clock = PhaseClock::new(gpu);
        let mut structure = self.tracer.build(geometry, viewpoint, &self.parameters, &mut clock)?;
        let phases = clock.finish()?;
        let phases = grown(&mut *structure, geometry, viewpoint, &self.parameters, gpu)?.unwrap_or(phases);
        self.structure = Some(structure);
        Ok(BuildSample { whole: self.whole(begin, phases.grown, gpu)?, phases })
    }

    /// Lets the last structure follow triangles or an eye that moved and gives the times; none of a reuse, which does nothing. A rebuild
    /// over the same triangles is a steady build.
    ///
    /// # Errors
    /// [`TracerError::Failed`] before the first build, or what the tracer says.
    pub fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        gpu: Option<&Gpu>,
    ) -> Result<Option<BuildSample>, TracerError> {
        let begin = self.idle(gpu)?;
        let Some(structure) = &mut self.structure else {
            return Err(TracerError::Failed("updated before it was built".to_owned()));
        };
        let mut clock = PhaseClock::new(gpu);
        structure.update(update, geometry, viewpoint, &self.parameters, &mut clock)?;
        if update == Update::Reuse {
            return Ok(None);
        }
        let phases = clock.finish()?;
        let phases = grown(&mut **structure, geometry, viewpoint, &self.parameters, gpu)?.unwrap_or(phases);
        Ok(Some(BuildSample { whole: self.whole(begin, phases.grown, gpu)?, phases }))
    }

    /// The time by the host's clock once the device has nothing left to do, not even to give memory back. Of a tracer on the host it is
    /// not asked.
    fn idle(&self, gpu: Option<&Gpu>) -> Result<Instant, TracerError> {
        if let Some(gpu) = gpu.filter(|_| self.description.residency == Residency::Device) {
            gpu.queue.submit([]);
            gpu.wait()?;
        }
        Ok((self.now)())
    }

    /// The time from a beginning until the device is idle.
    fn whole(&self, begin: Instant, grown: bool, gpu: Option<&Gpu>) -> Result<Timing, TracerError> {
        let total_ms = (self.idle(gpu)? - begin).as_secs_f64() * 1e3;
        Ok(Timing { clock: ClockKind::Host, total_ms, phases: Vec::new(), submit_to_done_ms: None, grown })
    }

    /// What it built last.
    ///
    /// # Errors
    /// [`TracerError::Failed`] before the first build.
    pub fn structure(&self) -> Result<&dyn Structure, TracerError> {
        self.structure.as_deref().ok_or_else(|| TracerError::Failed("traced before it was built".to_owned()))
    }
}

/// If a structure ran out of room, the time of a rebuild in the room that it has made.
fn grown(
    structure: &mut dyn Structure,
    geometry: &Geometry,
    viewpoint: &Viewpoint,
    parameters: &Parameters,
    gpu: Option<&Gpu>,
) -> Result<Option<Timing>, TracerError> {
    if !structure.grow_on_overflow()? {
        return Ok(None);
    }
    let mut clock = PhaseClock::new(gpu);
    structure.update(Update::Rebuild, geometry, viewpoint, parameters, &mut clock)?;
    Ok(Some(Timing { grown: true, ..clock.finish()? }))
}

/// The tracers of requests, each created once and kept from place to place.
#[derive(Default)]
pub struct TracerCache {
    created: Vec<TracerConfig>,
}

impl TracerCache {
    /// A configuration without a structure, by a tracer that is created with the first request of its kind.
    ///
    /// # Errors
    /// What the tracer says.
    pub fn config(&mut self, request: &TracerRequest, device: &Device) -> Result<TracerConfig, TracerError> {
        let (description, parameters) = (request.registration.describe(), request.parameters.clone());
        let same =
            |known: &&TracerConfig| (known.description.name, &known.parameters) == (description.name, &parameters);
        if let Some(known) = self.created.iter().find(same) {
            return Ok(known.afresh());
        }
        let begin = Instant::now();
        let tracer = request.registration.create(device)?;
        let setup_ms = begin.elapsed().as_secs_f64() * 1e3;
        let config = TracerConfig { setup_ms, ..TracerConfig::ready(description, parameters, tracer) };
        self.created.push(config.afresh());
        Ok(config)
    }
}
