//! How builds and traces are timed: the harness hands a clock in, the tracer marks its phases with it.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::{Gpu, TracerError};

/// Which clock took a time. Host and device times are never added up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClockKind {
    /// Host clock, from the start of the first phase to the end of the last.
    Host,
    /// Timestamps written on the device, from before the first phase to after the last.
    DeviceTimestamps,
    /// Host clock, from before submission until the device is done: adapters without timestamps between passes.
    SubmitToDone,
}

/// One phase of a sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseSample {
    /// The phase's name, as the method's paper calls it.
    pub name: String,
    /// Its duration, milliseconds.
    pub duration_ms: f64,
}

/// One sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// The clock that took it.
    pub clock: ClockKind,
    /// The whole, milliseconds.
    pub total_ms: f64,
    /// The phases in order; empty where the clock cannot see them.
    pub phases: Vec<PhaseSample>,
}

/// Times one build or trace. All work in scope goes through [`PhaseClock::host_phase`] or
/// [`PhaseClock::device_phase`], never a mixture of the two.
pub struct PhaseClock<'gpu> {
    gpu: Option<&'gpu Gpu>,
    encoder: Option<wgpu::CommandEncoder>,
    device_phases: Vec<String>,
    host_phases: Vec<PhaseSample>,
    host_span: Option<(Instant, Instant)>,
}

impl<'gpu> PhaseClock<'gpu> {
    /// A fresh clock; `gpu` is needed for device phases.
    pub fn new(gpu: Option<&'gpu Gpu>) -> Self {
        Self { gpu, encoder: None, device_phases: Vec::new(), host_phases: Vec::new(), host_span: None }
    }

    /// Runs and times work on the host.
    pub fn host_phase<R>(&mut self, name: &str, work: impl FnOnce() -> R) -> R {
        let begin = Instant::now();
        let result = work();
        let end = Instant::now();
        self.host_phases.push(PhaseSample { name: name.to_owned(), duration_ms: (end - begin).as_secs_f64() * 1e3 });
        self.host_span = Some((self.host_span.map_or(begin, |(first, _)| first), end));
        result
    }

    /// Records work for the device; it is submitted, and the phase timed, when the clock is finished.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] without a device, [`TracerError::Failed`] beyond 32 phases.
    pub fn device_phase(
        &mut self,
        name: &str,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<(), TracerError> {
        let gpu = self.gpu.ok_or_else(|| TracerError::Unavailable("this phase runs on a device".to_owned()))?;
        if self.device_phases.len() >= Stamps::MOST_PHASES {
            return Err(TracerError::Failed(format!("more than {} phases", Stamps::MOST_PHASES)));
        }
        let encoder = self.encoder.get_or_insert_with(|| gpu.device.create_command_encoder(&Default::default()));
        if let (Some(stamps), true) = (&gpu.stamps, self.device_phases.is_empty()) {
            encoder.write_timestamp(&stamps.queries, 0);
        }
        record(encoder);
        self.device_phases.push(name.to_owned());
        if let Some(stamps) = &gpu.stamps {
            encoder.write_timestamp(&stamps.queries, self.device_phases.len() as u32);
        }
        Ok(())
    }

    /// Submits what was recorded, waits, and gives the sample.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if nothing was timed, host and device phases were mixed, or the device failed.
    pub fn finish(mut self) -> Result<Timing, TracerError> {
        match (self.encoder.take(), self.host_span) {
            (Some(_), Some(_)) => Err(TracerError::Failed("host and device phases in one sample".to_owned())),
            (None, None) => Err(TracerError::Failed("nothing was timed".to_owned())),
            (None, Some((begin, end))) => Ok(Timing {
                clock: ClockKind::Host,
                total_ms: (end - begin).as_secs_f64() * 1e3,
                phases: self.host_phases,
            }),
            (Some(encoder), None) => {
                let gpu = self.gpu.ok_or_else(|| TracerError::Failed("a device phase without a device".to_owned()))?;
                finish_on_device(gpu, encoder, &self.device_phases)
            }
        }
    }
}

fn finish_on_device(gpu: &Gpu, mut encoder: wgpu::CommandEncoder, phases: &[String]) -> Result<Timing, TracerError> {
    let Some(stamps) = &gpu.stamps else {
        let commands = encoder.finish();
        let begin = Instant::now();
        gpu.queue.submit([commands]);
        gpu.wait()?;
        let total_ms = begin.elapsed().as_secs_f64() * 1e3;
        return Ok(Timing { clock: ClockKind::SubmitToDone, total_ms, phases: Vec::new() });
    };
    let count = phases.len() as u32 + 1;
    let bytes = u64::from(count) * 8;
    encoder.resolve_query_set(&stamps.queries, 0..count, &stamps.resolved, 0);
    encoder.copy_buffer_to_buffer(&stamps.resolved, 0, &stamps.readback, 0, bytes);
    gpu.queue.submit([encoder.finish()]);
    let read = gpu.read_mapped(&stamps.readback, bytes)?;
    let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&read);
    let to_ms = |from: u64, to: u64| to.saturating_sub(from) as f64 * stamps.period_ns * 1e-6;
    let phases = phases.iter().zip(ticks.windows(2));
    Ok(Timing {
        clock: ClockKind::DeviceTimestamps,
        total_ms: to_ms(ticks[0], ticks[ticks.len() - 1]),
        phases: phases
            .map(|(name, pair)| PhaseSample { name: name.clone(), duration_ms: to_ms(pair[0], pair[1]) })
            .collect(),
    })
}

/// A query set for the phases of one sample, kept with the device.
#[derive(Debug)]
pub(crate) struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    period_ns: f64,
}

impl Stamps {
    const MOST_PHASES: usize = 32;

    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let count = Self::MOST_PHASES as u32 + 1;
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: u64::from(count) * 8,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("phase timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: buffer(
                "phase timestamps resolved",
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            ),
            readback: buffer("phase timestamps read back", wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
            period_ns: f64::from(queue.get_timestamp_period()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Host phases are named in order and their sum does not exceed the whole.
    #[test]
    fn host_phases_add_up() {
        let mut clock = PhaseClock::new(None);
        clock.host_phase("first", || std::thread::sleep(std::time::Duration::from_millis(3)));
        clock.host_phase("second", || ());
        let timing = clock.finish().unwrap();
        assert_eq!(timing.clock, ClockKind::Host);
        assert_eq!(timing.phases.iter().map(|phase| phase.name.as_str()).collect::<Vec<_>>(), ["first", "second"]);
        assert!(timing.total_ms >= 3.0);
        assert!(timing.phases.iter().map(|phase| phase.duration_ms).sum::<f64>() <= timing.total_ms);
    }

    /// A sample in which nothing was marked is an error, not a time of zero.
    #[test]
    fn an_empty_sample_is_an_error() {
        assert!(PhaseClock::new(None).finish().is_err());
    }
}
