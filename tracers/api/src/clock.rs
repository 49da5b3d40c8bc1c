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
    /// The same work by the host's clock, from before submission until the device is done; none for work on the host.
    pub submit_to_done_ms: Option<f64>,
    /// Whether the work was done a second time, into memory that had been too small at first: the time is the second's.
    pub grown: bool,
}

impl Timing {
    /// What submission and waking up may cost beyond the work, milliseconds.
    const OVERHEAD_MS: f64 = 0.25;

    /// Whether the timestamps of samples of the same work can be true: at least one sample spends no more than half its
    /// time, or a quarter of a millisecond, outside of them, none lasts longer on the device than the host waited for it, and they are
    /// not late now and then. A stamp that the driver takes too late, or a wrong period, would show as a speed that
    /// nothing has.
    pub fn plausible(samples: &[Timing]) -> bool {
        let pairs: Vec<_> =
            samples.iter().filter_map(|sample| Some((sample.total_ms, sample.submit_to_done_ms?))).collect();
        let covered = |&(device, host): &(f64, f64)| host - device <= f64::max(device, Self::OVERHEAD_MS);
        let within = |&(device, host): &(f64, f64)| device <= host + Self::OVERHEAD_MS;
        pairs.is_empty() || (pairs.iter().any(covered) && pairs.iter().all(within) && !Self::are_late(&pairs))
    }

    /// Whether first stamps were taken late in some samples, of times on the device and by the host. Mesa's software driver has a thread
    /// of its own take them, which waits for a core while the work has them all: such a sample lasts as long as ever by the host, and
    /// next to nothing on the device. So two samples at least, and more than one in ten, have more than a quarter of their time
    /// outside of the stamps though the host waited no longer than it does; and what the device says scatters more than what the host
    /// says. On a busy machine the host has to wait now and then, and scatters more.
    fn are_late(pairs: &[(f64, f64)]) -> bool {
        let sorted = |of: fn(&(f64, f64)) -> f64| {
            let mut times: Vec<f64> = pairs.iter().map(of).collect();
            times.sort_by(f64::total_cmp);
            times
        };
        let (device, host) = (sorted(|pair| pair.0), sorted(|pair| pair.1));
        let usual = 1.05 * host[host.len() / 2];
        let is_late = |&&(device, host): &&(f64, f64)| host <= usual && host - device > Self::OVERHEAD_MS + 0.25 * host;
        let late = pairs.iter().filter(is_late).count();
        // From a tenth to nine tenths of the samples.
        let spread = |times: &[f64]| times[times.len() * 9 / 10] - times[times.len() / 10];
        late >= 2 && 10 * late > pairs.len() && spread(&device) > spread(&host)
    }

    /// The sample by the host's clock round the submission, where there is one; phases cannot be seen by it.
    #[must_use]
    pub fn by_submission(&self) -> Self {
        match self.submit_to_done_ms {
            Some(total_ms) => Self {
                clock: ClockKind::SubmitToDone,
                total_ms,
                phases: Vec::new(),
                submit_to_done_ms: Some(total_ms),
                grown: self.grown,
            },
            None => self.clone(),
        }
    }
}

/// Times one build or trace. All work in scope goes through [`PhaseClock::host_phase`] or
/// [`PhaseClock::device_phase`], never a mixture of the two.
pub struct PhaseClock<'gpu> {
    gpu: Option<&'gpu Gpu>,
    now: fn() -> Instant,
    encoder: Option<wgpu::CommandEncoder>,
    /// What stands before the names of phases.
    part: String,
    has_parts: bool,
    device_phases: Vec<String>,
    host_phases: Vec<PhaseSample>,
    host_span: Option<(Instant, Instant)>,
}

impl<'gpu> PhaseClock<'gpu> {
    /// A fresh clock; `gpu` is needed for device phases.
    pub fn new(gpu: Option<&'gpu Gpu>) -> Self {
        Self::read_by(gpu, Instant::now)
    }

    /// The same by another clock of the host than the system's.
    pub fn read_by(gpu: Option<&'gpu Gpu>, now: fn() -> Instant) -> Self {
        let (part, device_phases, host_phases) = Default::default();
        Self { gpu, now, encoder: None, part, has_parts: false, device_phases, host_phases, host_span: None }
    }

    /// Does the work of a part of a method, whose phases are told as `PART: PHASE`. Where one part works on the host and another on the
    /// device, all is timed by the host's clock.
    pub fn within<R>(&mut self, part: &str, work: impl FnOnce(&mut Self) -> R) -> R {
        let outer = self.part.len();
        self.has_parts = true;
        self.part += &format!("{part}: ");
        let result = work(self);
        self.part.truncate(outer);
        result
    }

    /// Runs and times work on the host.
    pub fn host_phase<R>(&mut self, name: &str, work: impl FnOnce() -> R) -> R {
        let begin = (self.now)();
        let result = work();
        let end = (self.now)();
        self.host_phases
            .push(PhaseSample { name: self.part.clone() + name, duration_ms: (end - begin).as_secs_f64() * 1e3 });
        self.host_span = Some((self.host_span.map_or(begin, |(first, _)| first), end));
        result
    }

    /// Records work for the device; it is submitted, and the phase timed, when the clock is finished.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] without a device, [`TracerError::Failed`] beyond 64 phases.
    pub fn device_phase(
        &mut self,
        name: &str,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<(), TracerError> {
        let gpu = self.gpu.ok_or_else(|| TracerError::Unavailable("this phase runs on a device".to_owned()))?;
        if self.device_phases.len() >= Stamps::MAX_PHASES {
            return Err(TracerError::Failed(format!("more than {} phases", Stamps::MAX_PHASES)));
        }
        let encoder = self.encoder.get_or_insert_with(|| gpu.device.create_command_encoder(&Default::default()));
        if let (Some(stamps), true) = (&gpu.stamps, self.device_phases.is_empty()) {
            stamps.write(encoder, 0);
        }
        record(encoder);
        self.device_phases.push(self.part.clone() + name);
        if let Some(stamps) = &gpu.stamps {
            stamps.write(encoder, self.device_phases.len() as u32);
        }
        Ok(())
    }

    /// Submits what was recorded, waits, and gives the sample.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if nothing was timed, host and device phases were mixed, or the device failed.
    pub fn finish(mut self) -> Result<Timing, TracerError> {
        match (self.encoder.take(), self.host_span) {
            (Some(encoder), Some((begin, _))) if self.has_parts => {
                let gpu = self.gpu.ok_or_else(|| TracerError::Failed("a device phase without a device".to_owned()))?;
                let on_device = finish_on_device(gpu, encoder, &self.device_phases, self.now)?;
                let duration_ms = on_device.submit_to_done_ms.unwrap_or(on_device.total_ms);
                self.host_phases.push(PhaseSample { name: "on the device".to_owned(), duration_ms });
                let (clock, total_ms) = (ClockKind::Host, ((self.now)() - begin).as_secs_f64() * 1e3);
                Ok(Timing { clock, total_ms, phases: self.host_phases, submit_to_done_ms: None, grown: false })
            }
            (Some(_), Some(_)) => Err(TracerError::Failed("host and device phases in one sample".to_owned())),
            (None, None) => Err(TracerError::Failed("nothing was timed".to_owned())),
            (None, Some((begin, end))) => Ok(Timing {
                clock: ClockKind::Host,
                total_ms: (end - begin).as_secs_f64() * 1e3,
                phases: self.host_phases,
                submit_to_done_ms: None,
                grown: false,
            }),
            (Some(encoder), None) => {
                let gpu = self.gpu.ok_or_else(|| TracerError::Failed("a device phase without a device".to_owned()))?;
                finish_on_device(gpu, encoder, &self.device_phases, self.now)
            }
        }
    }
}

fn finish_on_device(
    gpu: &Gpu,
    mut encoder: wgpu::CommandEncoder,
    phases: &[String],
    now: fn() -> Instant,
) -> Result<Timing, TracerError> {
    let bytes = Stamps::bytes(phases.len());
    if let Some(stamps) = &gpu.stamps {
        stamps.resolve(&mut encoder, bytes);
    }
    let commands = encoder.finish();
    let begin = now();
    gpu.queue.submit([commands]);
    gpu.wait()?;
    let submit_to_done_ms = (now() - begin).as_secs_f64() * 1e3;
    let by_host = Timing {
        clock: ClockKind::SubmitToDone,
        total_ms: submit_to_done_ms,
        phases: Vec::new(),
        submit_to_done_ms: Some(submit_to_done_ms),
        grown: false,
    };
    let Some(stamps) = &gpu.stamps else { return Ok(by_host) };
    let read = gpu.read_mapped(&stamps.readback, bytes)?;
    let ticks: Vec<u64> = bytemuck::pod_collect_to_vec::<u8, [u64; 2]>(&read).iter().map(|[tick, _]| *tick).collect();
    let to_ms = |from: u64, to: u64| to.saturating_sub(from) as f64 * stamps.period_ns * 1e-6;
    let phases = phases.iter().zip(ticks.windows(2));
    Ok(Timing {
        clock: ClockKind::DeviceTimestamps,
        total_ms: to_ms(ticks[0], ticks[ticks.len() - 1]),
        phases: phases
            .map(|(name, pair)| PhaseSample { name: name.clone(), duration_ms: to_ms(pair[0], pair[1]) })
            .collect(),
        ..by_host
    })
}

/// Readings of a probe of a clock's tick.
const PROBED: usize = 1000;

/// The tick of the host's clock: the smallest step other than zero between successive readings, milliseconds. A thousand are read, and
/// more until one differs from the last; `None` of a clock that stands still.
pub fn tick_ms(now: fn() -> Instant) -> Option<f64> {
    const MOST: usize = 100_000_000;
    let (mut last, mut least) = (now(), None::<f64>);
    for reading in 0..MOST {
        if reading >= PROBED && least.is_some() {
            break;
        }
        let next = now();
        if next > last {
            let step = (next - last).as_secs_f64() * 1e3;
            least = Some(least.map_or(step, |least| least.min(step)));
        }
        last = next;
    }
    least
}

impl Gpu {
    /// The tick of the device's timestamps: the smallest step other than zero between a thousand successive ones, milliseconds; `None`
    /// without timestamps, or where none differs from the last.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn tick_ms(&self) -> Result<Option<f64>, TracerError> {
        let Some(stamps) = &self.stamps else { return Ok(None) };
        let bytes = Stamps::bytes(Stamps::MAX_PHASES);
        let mut ticks: Vec<u64> = Vec::new();
        while ticks.len() < PROBED {
            let mut encoder = self.device.create_command_encoder(&Default::default());
            (0..=Stamps::MAX_PHASES as u32).for_each(|phases| stamps.write(&mut encoder, phases));
            stamps.resolve(&mut encoder, bytes);
            self.queue.submit([encoder.finish()]);
            self.wait()?;
            ticks.extend(bytemuck::pod_collect_to_vec::<u8, u64>(&self.read_mapped(&stamps.readback, bytes)?));
        }
        let steps = ticks.windows(2).filter_map(|pair| pair[1].checked_sub(pair[0]));
        Ok(steps.filter(|step| *step > 0).min().map(|step| step as f64 * stamps.period_ns * 1e-6))
    }
}

/// A query set for the phases of one sample, kept with the device. Every stamp is written twice and the first is read:
/// after a render pass Mesa's software driver takes a stamp only when something later waits for it, as the next stamp
/// does; written once, the stamp before a compute pass would be taken after it.
#[derive(Debug)]
pub(crate) struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    period_ns: f64,
}

impl Stamps {
    const MAX_PHASES: usize = 64;

    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let size = Self::bytes(Self::MAX_PHASES);
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("phase timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: (size / 8) as u32,
            }),
            resolved: buffer(
                "phase timestamps resolved",
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            ),
            readback: buffer("phase timestamps read back", wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
            period_ns: f64::from(queue.get_timestamp_period()),
        }
    }

    /// Bytes of the stamps of so many phases.
    fn bytes(phases: usize) -> u64 {
        (phases as u64 + 1) * 16
    }

    /// Writes the stamp after so many phases.
    fn write(&self, encoder: &mut wgpu::CommandEncoder, phases: u32) {
        encoder.write_timestamp(&self.queries, phases * 2);
        encoder.write_timestamp(&self.queries, phases * 2 + 1);
    }

    /// Records that stamps are made readable.
    fn resolve(&self, encoder: &mut wgpu::CommandEncoder, bytes: u64) {
        encoder.resolve_query_set(&self.queries, 0..(bytes / 8) as u32, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readback, 0, bytes);
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
        clock.within("part", |clock| clock.host_phase("second", || ()));
        clock.host_phase("third", || ());
        let timing = clock.finish().unwrap();
        assert_eq!(timing.clock, ClockKind::Host);
        let names: Vec<&str> = timing.phases.iter().map(|phase| phase.name.as_str()).collect();
        assert_eq!(names, ["first", "part: second", "third"]);
        assert!(timing.total_ms >= 3.0);
        assert!(timing.phases.iter().map(|phase| phase.duration_ms).sum::<f64>() <= timing.total_ms);
    }

    /// Samples that cannot be true are told: stamps around nothing while the host waited, and stamps that last longer than
    /// the wait. A machine that was busy during some of the samples is not one of them, nor is a trace shorter than what
    /// its submission costs; without stamps there is nothing to doubt.
    #[test]
    fn impossible_timestamps_are_not_believed() {
        let sample = |device: f64, host: f64| Timing {
            clock: ClockKind::DeviceTimestamps,
            total_ms: device,
            phases: Vec::new(),
            submit_to_done_ms: Some(host),
            grown: false,
        };
        assert!(!Timing::plausible(&[sample(0.04, 13.4), sample(0.05, 22.0)]));
        assert!(!Timing::plausible(&[sample(20.0, 20.3), sample(40.0, 20.3)]));
        assert!(Timing::plausible(&[sample(20.0, 20.3), sample(20.0, 55.0)]));
        assert!(Timing::plausible(&[sample(0.02, 0.2)]));
        assert!(!Timing::plausible(&[sample(0.05, 0.9)]));
        assert!(Timing::plausible(&[]));
        // Late in one of three samples; in none; late in as many on a machine that lets the host wait by as much; late once.
        let told = |times: &[(f64, f64)]| {
            let times = times.iter().cycle().take(30);
            Timing::plausible(&times.map(|&(device, host)| sample(device, host)).collect::<Vec<_>>())
        };
        assert!(!told(&[(6.6, 6.8), (0.9, 6.4), (6.5, 6.7)]));
        assert!(told(&[(6.6, 6.8), (6.2, 6.4), (6.5, 6.7)]));
        assert!(told(&[(6.6, 6.8), (6.5, 9.7), (6.7, 13.0)]));
        let mut once = vec![sample(6.6, 6.8); 29];
        once.push(sample(0.9, 6.4));
        assert!(Timing::plausible(&once));
        let submitted = sample(0.04, 13.4).by_submission();
        assert_eq!((submitted.clock, submitted.total_ms), (ClockKind::SubmitToDone, 13.4));
    }

    /// A sample in which nothing was marked is an error, not a time of zero.
    #[test]
    fn an_empty_sample_is_an_error() {
        assert!(PhaseClock::new(None).finish().is_err());
    }
}
