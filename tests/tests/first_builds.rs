//! First builds, one after the other: a later one rests on nothing that an earlier one has found. A program of its own, since host memory
//! is counted for a whole process.

use std::cell::RefCell;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use peak_alloc::PeakAlloc;
use tracebench_api::glam::Vec3;
use tracebench_api::{
    Geometry, Gpu, MemoryReport, Parameters, PhaseClock, Structure, Tracer, TracerError, Update, Viewpoint,
};
use tracebench_harness::registry::{Registration, TRACERS};
use tracebench_scenes::{Scene, procedural};
use tracebench_tests::{Fake, Manner, available, gpu, parameters, presets, viewpoint};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// One at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Host memory by which two builds of the same may differ, bytes: what wgpu keeps of its own resources.
const OWN_BYTES: usize = 1 << 15;

/// What a build did.
#[derive(Debug)]
struct Work {
    submissions: u64,
    phases: Vec<String>,
    /// The most host memory beside what there was before.
    host_bytes: usize,
    memory: MemoryReport,
}

impl Work {
    fn is_that_of(&self, other: &Self) -> bool {
        (self.submissions, &self.phases, &self.memory) == (other.submissions, &other.phases, &other.memory)
            && self.host_bytes.abs_diff(other.host_bytes) <= OWN_BYTES
    }
}

/// Submissions up to now.
fn submissions(gpu: &Gpu) -> u64 {
    let index = format!("{:?}", gpu.queue.submit([]));
    gpu.wait().unwrap();
    index.chars().filter(char::is_ascii_digit).collect::<String>().parse().unwrap()
}

fn worked(
    gpu: &Gpu,
    build: impl FnOnce(&mut PhaseClock<'_>) -> Result<Box<dyn Structure>, TracerError>,
) -> (Work, Box<dyn Structure>) {
    let (before, held) = (submissions(gpu), ALLOCATOR.current_usage());
    ALLOCATOR.reset_peak_usage();
    let mut clock = PhaseClock::new(Some(gpu));
    let mut structure = build(&mut clock).unwrap();
    let phases = clock.finish().unwrap().phases.into_iter().map(|phase| phase.name).collect();
    assert!(!structure.grow_on_overflow().unwrap());
    let host_bytes = ALLOCATOR.peak_usage().saturating_sub(held);
    // The one that asks is none of the build.
    let submissions = submissions(gpu) - before - 1;
    (Work { submissions, phases, host_bytes, memory: structure.memory() }, structure)
}

fn seen(name: &str, scale: f64, gpu: &Gpu) -> (Geometry, Viewpoint) {
    let Scene { mesh, cameras, .. } = procedural(name, scale).unwrap();
    let [eye, target] = [cameras[0].eye, cameras[0].target].map(Vec3::from);
    (Geometry::new(mesh.positions, mesh.triangles, Some(gpu)).unwrap(), viewpoint(eye, target, 0.05, 50.0, [96, 64]))
}

/// The first first build of a scene by a tracer that has built another one, then the second; and a rebuild behind it.
fn builds(gpu: &Gpu, tracer: &dyn Tracer, parameters: &Parameters) -> [Work; 3] {
    let (other, from) = seen("hangar", 0.02, gpu);
    drop(worked(gpu, |clock| tracer.build(&other, &from, parameters, clock)));
    let (geometry, from) = seen("room", 0.1, gpu);
    let (first, structure) = worked(gpu, |clock| tracer.build(&geometry, &from, parameters, clock));
    drop(structure);
    let (second, mut structure) = worked(gpu, |clock| tracer.build(&geometry, &from, parameters, clock));
    let (steady, _structure) = worked(gpu, |clock| {
        structure.update(Update::Rebuild, &geometry, &from, parameters, clock)?;
        Ok(structure)
    });
    [first, second, steady]
}

/// What `Remembering` does once a scene.
#[derive(Clone, Copy)]
enum Once {
    Submit,
    Allocate,
}

/// Rests on what it has found of the last scene.
struct Remembering(Once, Arc<Gpu>, RefCell<Weak<Vec<[f32; 3]>>>);

impl Tracer for Remembering {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        let Self(once, gpu, last) = self;
        if !Weak::ptr_eq(&last.replace(Arc::downgrade(&geometry.positions)), &Arc::downgrade(&geometry.positions)) {
            match once {
                Once::Submit => drop(gpu.queue.submit([])),
                Once::Allocate => drop(std::hint::black_box(vec![0_u32; 2 * OWN_BYTES])),
            }
        }
        Fake(Manner::Honest).build(geometry, viewpoint, parameters, clock)
    }
}

/// Asks every tracer and preset that the second first build over a scene submits as much, has the same phases, needs as much host memory
/// and holds the same memory as the first; and that a rebuild behind it submits no more and holds the same: sizes live in the structure
/// alone.
fn rest_on_nothing(registrations: &[Registration]) {
    let (_alone, gpu) = (alone(), gpu());
    let mut asked = 0;
    for registration in registrations {
        let description = registration.describe();
        let created = registration.create(&Ok(Arc::clone(&gpu)));
        let Some(tracer) = available(description.name, created, &gpu) else { continue };
        let presets = presets(&description.parameters).into_iter();
        let mut subjects: Vec<_> = presets.map(|(preset, parameters)| (preset.name(), parameters)).collect();
        // Its objects are found on the host, by no preset.
        if description.name == "fragment-abuffer" {
            subjects.push(("bounds=boxes", parameters(&description.parameters, &[("bounds", "boxes")])));
        }
        for (preset, parameters) in subjects {
            let [first, second, steady] = builds(&gpu, &*tracer, &parameters);
            let name = format!("{}:{preset}", description.name);
            assert!(second.is_that_of(&first), "{name}: {first:?} {second:?}");
            assert!(steady.submissions <= first.submissions && steady.memory == first.memory, "{name}: {steady:?}");
            asked += 1;
        }
    }
    assert!(asked > 3, "{asked}");
}

/// Proves [`rest_on_nothing`] of the first half of the registry: drivers compile for seconds what all have.
#[test]
fn first_builds_rest_on_nothing() {
    rest_on_nothing(TRACERS.split_at(TRACERS.len() / 2).0);
}

/// The same of the second half.
#[test]
fn first_builds_of_the_others_rest_on_nothing() {
    rest_on_nothing(TRACERS.split_at(TRACERS.len() / 2).1);
}

/// The negative control: tracers that remember are told, by what they spare the device and by what they spare the host.
#[test]
fn what_remembers_is_told() {
    let (_alone, gpu) = (alone(), gpu());
    for once in [Once::Submit, Once::Allocate] {
        let tracer = Remembering(once, Arc::clone(&gpu), RefCell::default());
        let [first, second, _] = builds(&gpu, &tracer, &Parameters::preset(&[], tracebench_api::Preset::Published));
        assert!(!second.is_that_of(&first), "{first:?} {second:?}");
    }
}
