//! The interleaved set against configurations that cheat or waver, which the registry has none of.

use std::cell::Cell;
use std::sync::{Arc, LazyLock, OnceLock};
use std::time::{Duration, Instant};

use tracebench_api::{
    Counter, Geometry, HitBuffer, MemoryReport, Parameters, PhaseClock, Preset, Ray, Structure, TraceJob, Tracer,
    TracerDescription, Update, Viewpoint, tick_ms,
};
use tracebench_tests::{Fake, Manner};

use super::interleaved_set::{Built, InterleavedSet, Setting};
use super::kernels::Kernels;
use super::session::Session;
use super::*;
use crate::measure::controls::Control;
use crate::progress::Progress;
use crate::rays::{RAY_SETS, RayParameters, RayScene, default_parameters};
use crate::results::{ClockTicks, InterleavedSetRecord, SampleSchedule, Times, TraceRecord};
use crate::truth::{Cache, Truth};
use crate::viewpoint::Pose;

/// A triangle that fills half of the image.
fn session() -> Session {
    let corners = vec![[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [0.0, 0.5, 0.0]];
    let geometry = Geometry::new(corners, vec![[0, 1, 2]], None).unwrap();
    let truth = Arc::new(Truth::new(&geometry, "fake"));
    let viewpoint = Pose::parse("0,0,3:0,0,0").unwrap().viewpoint(&geometry, [8, 8], 8);
    let parameters = RayParameters::try_from(&default_parameters()).unwrap();
    let (path, mirrors, image, seed) = (None, &[][..], [8, 8], 1);
    let scene = RayScene { truth: &truth, viewpoint: &viewpoint, path, mirrors, image, seed, parameters: &parameters };
    let quiet = Progress::new(true);
    Session::new("fake", Arc::clone(&truth), &RAY_SETS[..1], &scene, None, &Cache::none(), &quiet).unwrap()
}

/// What came of one configuration.
struct Came {
    built: Result<Built, Refusal>,
    traced: Result<TraceRecord, Refusal>,
    /// What a control scored wrongly.
    invalid: Option<String>,
    interleaved_set: Option<InterleavedSetRecord>,
}

impl Came {
    /// Why it was taken out; empty if it was not.
    fn failure(&self) -> String {
        match (&self.built, &self.traced) {
            (Err(refusal), _) | (_, Err(refusal)) => refusal.reason.clone(),
            _ => String::new(),
        }
    }

    fn trace(&self) -> Option<&TraceRecord> {
        self.traced.as_ref().ok()
    }
}

/// Builds and traces one configuration as every interleaved set does.
fn interleaved_set(tracer: Box<dyn Tracer>, control: Option<Control>) -> Came {
    raced(2, tracer, control)
}

/// The same with so many rounds.
fn interleaved_set_of(rounds: u32, tracer: Box<dyn Tracer>) -> Came {
    raced(rounds, tracer, None)
}

fn raced(rounds: u32, tracer: Box<dyn Tracer>, control: Option<Control>) -> Came {
    raced_by(session(), None, Instant::now, rounds, tracer, control)
}

fn raced_by(
    session: Session,
    kernels: Option<&Kernels>,
    now: fn() -> Instant,
    rounds: u32,
    tracer: Box<dyn Tracer>,
    control: Option<Control>,
) -> Came {
    let description = TracerDescription { name: "fake", ..Control::AlwaysMiss.description() };
    let parameters = Parameters::preset(&[], Preset::Published);
    let quiet = Progress::new(true);
    let options = MeasureOptions { sampling: Some(SampleSchedule::rounds(rounds)), ..MeasureOptions::untimed() };
    let setting =
        Setting { scene: "fake".to_owned(), viewpoint: "given".to_owned(), resident_batch: 0, kernels, turn: 0 };
    let mut interleaved_set = InterleavedSet::new(&session, options, &quiet, setting);
    let mut config = TracerConfig::ready(description, parameters, tracer);
    config.now = now;
    interleaved_set.enter(config, None, control);
    let built = interleaved_set.build().unwrap().outcomes.pop().unwrap();
    let mut answered = interleaved_set.trace(&session.rays[0]).unwrap();
    Came {
        built,
        traced: answered.outcomes.pop().unwrap(),
        invalid: answered.invalid,
        interleaved_set: answered.interleaved_set,
    }
}

/// Proves that the buffer is poisoned before every sample: a configuration that answers once and rests on that is refused;
/// one that answers every time is taken, with a record of each.
#[test]
fn answers_of_an_earlier_sample_do_not_count() {
    let honest = interleaved_set(Box::new(Fake(Manner::Honest)), None);
    assert_eq!(honest.failure(), "");
    let Ok(Built { build, .. }) = &honest.built else { panic!("not built") };
    let samples = honest.trace().unwrap().times.samples_ms.len();
    assert_eq!((build.times.samples_ms.len(), samples), (2, 2));
    // Its counted answers are written, its last timed ones are poison.
    let idle = interleaved_set(Box::new(Fake(Manner::Idle)), None);
    assert!(!idle.failure().is_empty() && idle.trace().is_none());
}

/// Proves that the first trace warms up and is not among the samples.
#[test]
fn warming_up_is_not_counted() {
    let slow = interleaved_set(Box::new(Fake(Manner::Slow)), None);
    let samples = &slow.trace().unwrap().times.samples_ms;
    assert!(samples.len() == 2 && samples.iter().all(|sample| *sample < 200.0), "{samples:?}");
}

/// Proves that hits which differ between the timed and the counting variant take a configuration out of the interleaved set.
#[test]
fn hits_must_not_depend_on_counting() {
    let wavering = interleaved_set(Box::new(Fake(Manner::Wavering)), None);
    let failure = wavering.failure();
    assert!(failure.contains("other hits") && wavering.trace().is_none(), "{failure}");
}

/// Proves that a configuration which takes no longer for its work twice than for once is noticed by the control of the clock: the
/// interleaved set is run once more, then its times are invalid, while answers and counters stand. Honest ones that are too quick are not
/// judged.
#[test]
fn a_clock_that_does_not_see_double_work_is_invalid() {
    let lazy = interleaved_set_of(12, Box::new(Fake(Manner::Lazy)));
    let trace = lazy.trace().unwrap();
    let why = trace.times.invalid.as_ref().unwrap();
    assert!(why.contains("done twice takes") && trace.times.samples_ms.len() == 12, "{why}");
    let record = lazy.interleaved_set.as_ref().unwrap();
    assert!(record.repeated_because.is_some() && !record.doubled_work[0].passed);
    assert_eq!((record.orders.len(), record.participants.len()), (12, Control::ALL.len() + 2));
    assert!(lazy.invalid.is_none() && !trace.statuses.is_empty());
    for (manner, rounds) in [(Manner::Honest, 12), (Manner::Lazy, 11)] {
        let quick = interleaved_set_of(rounds, Box::new(Fake(manner)));
        let record = quick.interleaved_set.as_ref().unwrap();
        assert!(quick.trace().unwrap().times.invalid.is_none() && record.repeated_because.is_none());
        assert!(record.doubled_work[0].not_judged.is_some());
    }
}

/// Reads the system's clock in steps of 10 ms.
fn coarse() -> Instant {
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    let begin = *BEGIN.get_or_init(Instant::now);
    begin + Duration::from_millis(begin.elapsed().as_millis() as u64 / 10 * 10)
}

/// Proves that the tick of a clock is found, of one whose ticks are longer than a thousand readings too, and that times below twenty ticks
/// are invalid with the reason, in the record of an interleaved set whose clock goes in steps of 10 ms: no speed is made of a time of
/// nothing. By the system's clock the same interleaved set has times and speeds (the negative control).
#[test]
fn times_below_twenty_ticks_are_invalid() {
    let tick = tick_ms(coarse).unwrap();
    // On a busy machine a step may be several.
    assert!(tick > 9.9 && (tick / 10.0 - (tick / 10.0).round()).abs() < 1e-9, "{tick}");
    let mut by_steps = Kernels::new(None).unwrap();
    let fine = by_steps.ticks.host_ms.unwrap();
    assert!(fine > 0.0 && fine < 1.0, "{fine}");
    by_steps.ticks.host_ms = Some(tick);
    let came = raced_by(
        Session { now: coarse, ..session() },
        Some(&by_steps),
        Instant::now,
        3,
        Box::new(Fake(Manner::Honest)),
        None,
    );
    let trace = came.trace().unwrap();
    let why = trace.times.invalid.as_ref().unwrap();
    assert!(why.contains("below 20 ticks") && why.contains(&format!("{tick} ms")), "{why}");
    assert_eq!((trace.mrays_per_s, trace.times.samples_ms.len()), (0.0, 3));
    assert_eq!(came.interleaved_set.as_ref().unwrap().clock_ticks, Some(by_steps.ticks));
    let Ok(Built { build, .. }) = &came.built else { panic!("not built") };
    assert!(build.times.invalid.is_some(), "builds are too short, too");
    // Of clocks that do not move nothing is known; of long times all is well.
    let of = |median_ms: f64, host_ms: Option<f64>| {
        let times = Times { samples_ms: vec![median_ms; 3], median_ms, ..trace.times.clone() };
        ClockTicks { host_ms, device_ms: None }.too_coarse(&times)
    };
    assert!(of(200.0, Some(10.0)).is_none() && of(199.9, Some(10.0)).is_some() && of(1e9, None).is_some());
    let sound = raced_by(session(), None, Instant::now, 3, Box::new(Fake(Manner::Honest)), None);
    assert!(sound.trace().unwrap().times.invalid.is_none() && sound.trace().unwrap().mrays_per_s > 0.0);
}

/// Proves that the tick of a device's timestamps is found where it has some, and is shorter than what it times.
#[test]
fn ticks_of_a_device_are_probed() {
    let gpu = tracebench_tests::gpu();
    let ticks = Kernels::new(Some(&gpu)).unwrap().ticks;
    assert_eq!(ticks.device_ms.is_some(), gpu.listing.timestamps);
    assert!(ticks.device_ms.is_none_or(|tick| tick > 0.0 && tick < 1.0), "{ticks:?}");
}

/// Proves that a control which does not score what it must is noticed: one that always misses in the oracle's place is, in its
/// own place it is not.
#[test]
fn a_failing_control_is_noticed() {
    assert_eq!(interleaved_set(Box::new(Fake(Manner::Honest)), Some(Control::AlwaysMiss)).invalid, None);
    for place in [Control::Oracle, Control::AlwaysHit, Control::Corrupted] {
        let invalid = interleaved_set(Box::new(Fake(Manner::Honest)), Some(place)).invalid.unwrap();
        assert!(invalid.contains(place.description().name), "{invalid}");
        assert!(RunError::Control(invalid).to_string().contains("invalid"));
    }
}

/// Proves that rays reach the tracer as they were made: through the pixel centres, from the eye.
#[test]
fn primary_rays_start_at_the_eye() {
    let session = session();
    let rays: &[Ray] = &session.rays[0].buffer.host;
    assert!(rays.len() == 64 && rays.iter().all(|ray| ray.origin == [0.0, 0.0, 3.0]));
}

/// Proves that what a structure says of itself is kept, and that one which is unsound, or says what is no number, is out of
/// the interleaved set before it is traced.
#[test]
fn structures_must_be_sound() {
    let honest = interleaved_set(Box::new(Fake(Manner::Honest)), None);
    let Ok(Built { structure_statistics, .. }) = honest.built else { panic!("not built") };
    assert_eq!(structure_statistics.into_iter().collect::<Vec<_>>(), [("nodes".to_owned(), 1.0)]);
    for (manner, part) in [(Manner::Unsound, "where it should be"), (Manner::Numberless, "cost is NaN")] {
        let came = interleaved_set(Box::new(Fake(manner)), None);
        assert!(came.failure().contains(part) && came.trace().is_none(), "{}", came.failure());
        let Err(refusal) = came.built else { panic!("it was not taken out") };
        assert!(!refusal.for_room && came.traced.is_err_and(|absent| absent == refusal));
    }
}

/// Proves that a configuration which does not serve a ray set is kept out of that one alone, with the reason, and asked again in the next.
#[test]
fn unserved_rays_take_nobody_out() {
    let session = session();
    let quiet = Progress::new(true);
    let options = MeasureOptions { sampling: Some(SampleSchedule::rounds(2)), ..MeasureOptions::untimed() };
    let (scene, viewpoint) = ("fake".to_owned(), "given".to_owned());
    let setting = Setting { scene, viewpoint, resident_batch: 0, kernels: None, turn: 0 };
    let mut interleaved_set = InterleavedSet::new(&session, options, &quiet, setting);
    let description = TracerDescription { name: "fake", ..Control::AlwaysMiss.description() };
    for manner in [Manner::Unserving, Manner::Honest] {
        let parameters = Parameters::preset(&[], Preset::Published);
        interleaved_set.enter(TracerConfig::ready(description.clone(), parameters, Box::new(Fake(manner))), None, None);
    }
    assert!(interleaved_set.build().unwrap().outcomes.iter().all(Result::is_ok));
    for _ in 0..2 {
        let outcomes = interleaved_set.trace(&session.rays[0]).unwrap().outcomes;
        let [.., Err(refusal), Ok(_)] = &outcomes[..] else { panic!("not as they serve") };
        assert!(refusal.unserved && !refusal.for_room && refusal.reason.contains("rays of any kind"), "{refusal:?}");
    }
}

thread_local! {
    static WORKED: Cell<Duration> = const { Cell::new(Duration::ZERO) };
}

/// A clock that goes on by what [`Hidden`] does alone.
fn worked() -> Instant {
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    *BEGIN + WORKED.get()
}

fn work(ms: u64) {
    WORKED.set(WORKED.get() + Duration::from_millis(ms));
}

/// Works outside of its phases, each part of a build for a time of its own: 1 s once, to make its pipelines, 100 ms for a build, 10 ms
/// for a rebuild, 3 ms to look for room, 2000 ms to drop a structure.
#[derive(Clone, Default)]
struct Hidden {
    /// Whether what is built first runs out of room.
    grows: bool,
    /// Whether a later first build rests on what the one before has found.
    remembers: bool,
    built: Cell<bool>,
}

struct HiddenStructure {
    inner: Box<dyn Structure>,
    out_of_room: bool,
}

impl Drop for HiddenStructure {
    fn drop(&mut self) {
        work(2000);
    }
}

impl Tracer for Hidden {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        let before = self.built.replace(true);
        work(if before { 0 } else { 1000 });
        work(if before && self.remembers { 1 } else { 100 });
        let inner = Fake(Manner::Honest).build(geometry, viewpoint, parameters, clock)?;
        Ok(Box::new(HiddenStructure { inner, out_of_room: self.grows }))
    }
}

impl Structure for HiddenStructure {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        work(10);
        self.inner.update(update, geometry, viewpoint, parameters, clock)
    }

    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        work(3);
        Ok(std::mem::take(&mut self.out_of_room))
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        self.inner.trace(job, hits, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.inner.trace_counted(job, hits)
    }

    fn memory(&self) -> MemoryReport {
        self.inner.memory()
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.inner.validate(geometry)
    }
}

/// Proves that first and steady builds have all that a tracer does, though it marks nothing of it: growth and the rebuild behind it in the
/// first, neither the making of pipelines in the round that warms up nor the drop of the structure before in any; one sample of each a
/// round. The phases, and a tracer that does nothing outside of them, are the negative control.
#[test]
fn unmarked_work_is_in_whole_times() {
    let times = |tracer: Hidden| {
        let came = raced_by(session(), None, worked, 12, Box::new(tracer), None);
        let Ok(Built { build, .. }) = came.built else { panic!("not built") };
        let samples = |times: &Option<Box<Times>>| times.clone().unwrap();
        (build.times.clone(), samples(&build.first), samples(&build.steady))
    };
    for (grows, first_ms) in [(false, 103.0), (true, 113.0)] {
        let (phases, first, steady) = times(Hidden { grows, ..Hidden::default() });
        assert_eq!((&*first.samples_ms, &*steady.samples_ms), (&[first_ms; 12][..], &[13.0; 12][..]));
        assert_eq!((first.grown_samples, steady.grown_samples), (if grows { 12 } else { 0 }, 0));
        assert_eq!(
            (first.clock, first.interleaved_set, steady.interleaved_set),
            (tracebench_api::ClockKind::Host, Some(0), Some(0))
        );
        assert_eq!((first.median_ms, first.interval_ms), (first_ms, [first_ms; 2]));
        assert!(
            phases.samples_ms.len() == 12 && phases.interleaved_set == Some(0) && phases.median_ms < 1.0,
            "{phases:?}"
        );
    }
    let came = raced_by(session(), None, worked, 2, Box::new(Fake(Manner::Honest)), None);
    let Ok(Built { build, .. }) = came.built else { panic!("not built") };
    assert_eq!((build.first().samples_ms.clone(), build.steady().median_ms), (vec![0.0; 2], 0.0));
    // What is remembered shows: a first build is then not what it was.
    let (_, first, _) = times(Hidden { remembers: true, ..Hidden::default() });
    assert_eq!(first.samples_ms, [4.0; 12]);
}

/// Proves that what is not timed is built once, and has no whole times.
#[test]
fn untimed_builds_are_not_repeated() {
    let before = WORKED.get();
    let session = session();
    let setting =
        Setting { scene: "fake".to_owned(), viewpoint: "given".to_owned(), resident_batch: 0, kernels: None, turn: 0 };
    let quiet = Progress::new(true);
    let mut interleaved_set = InterleavedSet::new(&session, MeasureOptions::untimed(), &quiet, setting);
    let description = TracerDescription { name: "fake", ..Control::AlwaysMiss.description() };
    let parameters = Parameters::preset(&[], Preset::Published);
    let mut config = TracerConfig::ready(description, parameters, Box::new(Hidden::default()));
    config.now = worked;
    interleaved_set.enter(config, None, None);
    let Some(Ok(built)) = interleaved_set.build().unwrap().outcomes.pop() else { panic!("not built") };
    assert!(built.build.first.is_none() && built.build.steady.is_none());
    assert_eq!(WORKED.get() - before, Duration::from_millis(1103));
}
