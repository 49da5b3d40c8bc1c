//! The fixed kernels: the same arithmetic in every round, on each clock of an interleaved set, by which a change of the machine's speed
//! shows.

use std::hint::black_box;
use std::time::Instant;

use rayon::prelude::*;
use tracebench_api::{ClockKind, Gpu, PhaseClock, Residency, Timing, TracerError, tick_ms};
use tracebench_kit::{FixedWork, FixedWorkPlan, fixed_task};

use crate::results::{ClockTicks, KernelRecord, whole_ns};
use crate::statistics::trend;

/// A kernel has so much work that it takes at least this, milliseconds: far more than a clock's resolution, far less than a round.
pub(super) const MIN_MS: f64 = 1.0;
/// Work that it begins with, tasks; doubled until it is enough.
const FEWEST_TASKS: u32 = 1 << 9;
/// Work that is enough for any device.
const MAX_TASKS: u32 = 1 << 28;
/// Of so many tries the fastest tells whether work is enough.
const TRIES: usize = 3;

/// Standard deviations from which on a trend is none of chance: 99.9 %, two-sided.
const SURE: f64 = 3.29;

/// The kernels of a machine.
pub(crate) struct Kernels {
    host_tasks: u32,
    device: Option<(FixedWork, FixedWorkPlan, u32)>,
    /// The ticks of the clocks that time them.
    pub ticks: ClockTicks,
}

/// The work of the host's kernel: all cores, as host tracers take them.
pub(crate) fn on_host(clock: &mut PhaseClock<'_>, tasks: u32) {
    clock.host_phase("work", || black_box((0..tasks).into_par_iter().map(fixed_task).reduce(|| 0, |a, b| a ^ b)));
}

fn sample_host(tasks: u32) -> Result<Timing, TracerError> {
    let mut clock = PhaseClock::new(None);
    on_host(&mut clock, tasks);
    clock.finish()
}

impl Kernels {
    /// Finds out how much work takes long enough.
    ///
    /// # Errors
    /// What the device says.
    pub fn new(gpu: Option<&Gpu>) -> Result<Self, TracerError> {
        let host_tasks = enough(sample_host)?;
        let device = gpu.map(|gpu| -> Result<_, TracerError> {
            let work = FixedWork::new(gpu)?;
            let tasks = enough(|tasks| on_device(gpu, &work, &work.plan(gpu, tasks)?))?;
            let plan = work.plan(gpu, tasks)?;
            Ok((work, plan, tasks))
        });
        let device = device.transpose()?;
        let device_ms = gpu.map_or(Ok(None), Gpu::tick_ms)?;
        Ok(Self { host_tasks, device, ticks: ClockTicks { host_ms: tick_ms(Instant::now), device_ms } })
    }

    /// Whether there is one of a clock: none of the device's where nobody can run there.
    pub fn have(&self, on: Residency) -> bool {
        on == Residency::Host || self.device.is_some()
    }

    /// Runs that of a clock once.
    ///
    /// # Errors
    /// What the device says.
    pub fn sample(&self, on: Residency, gpu: Option<&Gpu>) -> Result<Timing, TracerError> {
        match (on, &self.device, gpu) {
            (Residency::Host, ..) => sample_host(self.host_tasks),
            (_, Some((work, plan, _)), Some(gpu)) => on_device(gpu, work, plan),
            _ => Err(TracerError::Unavailable("a fixed kernel on a device that is not there".to_owned())),
        }
    }

    /// What its times tell.
    pub fn record(&self, on: Residency, timings: &[Timing]) -> KernelRecord {
        let samples_ms: Vec<f64> = timings.iter().map(|timing| whole_ns(timing.total_ms)).collect();
        let (change, deviations) = drift(&samples_ms);
        let device_tasks = self.device.as_ref().filter(|_| on == Residency::Device).map(|(.., tasks)| *tasks);
        KernelRecord {
            clock: timings.first().map_or(ClockKind::Host, |timing| timing.clock),
            tasks: device_tasks.unwrap_or(self.host_tasks),
            drifts: drifts(change, deviations),
            samples_ms,
            change,
            deviations,
        }
    }
}

/// A change from the first round to the last that counts as a drift, a share: less of it cancels in ratios of paired rounds.
const DRIFT: f64 = 0.25;

/// By which share times change over their rounds, and how sure that is.
pub(crate) fn drift(samples_ms: &[f64]) -> (f64, f64) {
    let logarithms: Vec<f64> = samples_ms.iter().map(|ms| ms.max(f64::MIN_POSITIVE).ln()).collect();
    trend(&logarithms).map_or((0.0, 0.0), |found| (found.change.exp_m1(), found.deviations))
}

/// Whether that is a drift.
pub(crate) fn drifts(change: f64, deviations: f64) -> bool {
    deviations.abs() > SURE && (1.0 + change).max(1.0 / (1.0 + change)) > 1.0 + DRIFT
}

fn on_device(gpu: &Gpu, work: &FixedWork, plan: &FixedWorkPlan) -> Result<Timing, TracerError> {
    let mut clock = PhaseClock::new(Some(gpu));
    clock.device_phase("work", |encoder| work.record(encoder, plan))?;
    clock.finish()
}

fn enough(sample: impl Fn(u32) -> Result<Timing, TracerError>) -> Result<u32, TracerError> {
    let mut tasks = FEWEST_TASKS;
    while tasks <= MAX_TASKS {
        let mut fastest = f64::INFINITY;
        for _ in 0..TRIES {
            fastest = fastest.min(sample(tasks)?.total_ms);
        }
        if fastest >= MIN_MS {
            return Ok(tasks);
        }
        tasks *= 2;
    }
    let what = "however much work there is, the clock says that it takes less than a millisecond: it does not wait until the work is done";
    Err(TracerError::Failed(what.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine that becomes a third slower is noticed through noise of a tenth, one that does not is not, and a stray sample
    /// is no drift.
    #[test]
    fn drift_is_noticed() {
        let noise = |round: u32| 1.0 + 0.1 * (f64::from(round * 7 % 11) / 10.0 - 0.5);
        let said = |speed: &dyn Fn(u32) -> f64| {
            let samples: Vec<f64> = (0..24).map(|round| noise(round) * speed(round)).collect();
            let (change, deviations) = drift(&samples);
            drifts(change, deviations)
        };
        assert!(!said(&|_| 1.0) && !said(&|round| if round == 20 { 9.0 } else { 1.0 }));
        assert!(said(&|round| 1.0 + 0.4 * f64::from(round) / 23.0) && said(&|round| 1.5 - 0.02 * f64::from(round)));
        // Sure or not, too little to matter.
        assert!(!said(&|round| 1.0 + 0.15 * f64::from(round) / 23.0));
    }

    /// A clock that does not wait is an error, for no work takes long enough by it; one that does finds enough work.
    #[test]
    fn a_clock_must_wait() {
        let takes = |ms: f64| Timing {
            clock: ClockKind::SubmitToDone,
            total_ms: ms,
            phases: Vec::new(),
            submit_to_done_ms: Some(ms),
            grown: false,
        };
        let error = enough(|tasks| Ok(takes(0.05 + 1e-10 * f64::from(tasks)))).unwrap_err().to_string();
        assert!(error.contains("does not wait"), "{error}");
        assert_eq!(enough(|tasks| Ok(takes(f64::from(tasks) / 1e4))).unwrap(), 1 << 14);
    }

    /// The kernel of the host takes as long as it should.
    #[test]
    fn kernels_have_work_enough() {
        let kernels = Kernels::new(None).unwrap();
        assert!(kernels.host_tasks >= FEWEST_TASKS && kernels.sample(Residency::Host, None).is_ok());
        assert!(!kernels.have(Residency::Device) && kernels.sample(Residency::Device, None).is_err());
        assert_eq!(
            kernels.record(Residency::Host, &[kernels.sample(Residency::Host, None).unwrap()]).tasks,
            kernels.host_tasks
        );
    }
}
