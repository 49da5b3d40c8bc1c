//! What tracers say that they hold on the device, against what the device's own allocator says (gpu-allocator's report of
//! live allocations: label, offset in their block, size).
//!
//! The rule of sizes. An allocation begins where another ended, and its size has in it what aligns its start: the size of
//! a resource, rounded up to the driver's step, plus the way from its offset to the next multiple of the driver's
//! alignment. Step and alignment are found from buffers of known sizes. What a driver sizes by itself (textures,
//! acceleration structures) ledgers tell as the allocator does, with what aligns it.

use std::io::Write as _;
use std::rc::Rc;
use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::wgpu::BufferUsages;
use tracebench_api::{
    Geometry, Gpu, HitBuffer, MemoryEntry, MemoryReport, ParameterScope, Parameters, PhaseClock, Query, RayBuffer,
    Residency, Structure, TraceJob, TraceTo, Tracer, TracerError, Update, Viewpoint,
};
use tracebench_harness::registry::TRACERS;
use tracebench_scenes::procedural;
use tracebench_tests::{available, gpu, presets, ray, rectangle, soup, viewpoint};

/// One live allocation.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Allocation {
    name: String,
    offset: u64,
    size: u64,
}

/// What wgpu takes for itself to hand data over, until the submission is done.
const STAGING: &str = "(wgpu internal) Staging";

/// In a ledger, what lies in host memory.
const ON_HOST: &str = "host copy";

/// Every live allocation; with what is submitted done and what is dropped freed, if `settled`.
fn allocations(gpu: &Gpu, settled: bool) -> Vec<Allocation> {
    if settled {
        gpu.queue.submit([]);
        gpu.wait().unwrap();
    }
    let report = gpu.device.generate_allocator_report().unwrap();
    let each = report.allocations.into_iter();
    let mut all: Vec<_> =
        each.map(|each| Allocation { name: each.name, offset: each.offset, size: each.size }).collect();
    assert_eq!(all.iter().map(|each| each.size).sum::<u64>(), report.total_allocated_bytes);
    all.sort();
    all
}

/// What is there now and was not before. Nothing that was there may be gone.
fn added(before: &[Allocation], after: Vec<Allocation>) -> Vec<Allocation> {
    let mut left = after;
    for known in before {
        let index = left.iter().position(|each| each == known).unwrap_or_else(|| panic!("{known:?} is gone"));
        left.remove(index);
    }
    left.retain(|each| each.name != STAGING);
    left
}

/// A driver's step and alignment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Rule {
    step: u64,
    alignment: u64,
}

impl Rule {
    fn holds(&self, bytes: u64, allocation: &Allocation) -> bool {
        let padding = allocation.offset.next_multiple_of(self.alignment) - allocation.offset;
        allocation.size == bytes.next_multiple_of(self.step) + padding
    }

    /// The finest rule that holds for buffers of a use, of sizes that are known.
    fn probe(gpu: &Gpu, usage: BufferUsages) -> Self {
        let before = allocations(gpu, true);
        let sizes: Vec<u64> = vec![4, 8, 20, 36, 68, 100, 132, 260, 516, 1000, 1028, 2052, 4100, 8196];
        let _buffers: Vec<_> =
            sizes.iter().map(|size| gpu.buffer(&size.to_string(), *size, usage, "nothing").unwrap()).collect();
        let probes = added(&before, allocations(gpu, true));
        let powers = || (0..=16).map(|power| 1_u64 << power);
        let mut rules = powers().flat_map(|step| powers().map(move |alignment| Rule { step, alignment }));
        let holds = |rule: &Rule| probes.iter().all(|probe| rule.holds(probe.name.parse().unwrap(), probe));
        rules.find(holds).unwrap_or_else(|| panic!("no rule holds for {probes:?}"))
    }

    /// Those of every use that tracers make of buffers.
    fn all(gpu: &Gpu) -> Vec<Self> {
        let copied = BufferUsages::COPY_DST;
        let mut uses = vec![BufferUsages::STORAGE | BufferUsages::COPY_SRC | copied, BufferUsages::UNIFORM | copied];
        if gpu.has_ray_queries() {
            uses.push(BufferUsages::BLAS_INPUT | copied);
        }
        uses.into_iter().map(|usage| Self::probe(gpu, usage)).collect()
    }
}

/// Gives an allocation a part of a ledger that may stand for it, where others can give theirs up for another one (Kuhn's matching).
fn match_one(allocation: usize, fits: &[Vec<usize>], owners: &mut [Option<usize>], asked: &mut [bool]) -> bool {
    fits[allocation].iter().any(|part| {
        if std::mem::replace(&mut asked[*part], true) {
            return false;
        }
        let free = owners[*part].is_none_or(|owner| match_one(owner, fits, owners, asked));
        if free {
            owners[*part] = Some(allocation);
        }
        free
    })
}

/// What is wrong with a ledger: allocations that no part tells, and parts that no allocation stands behind.
fn wrong(rules: &[Rule], ledger: &MemoryReport, allocated: &[Allocation]) -> Vec<String> {
    let parts: Vec<_> = ledger.structure.iter().filter(|entry| !entry.name.starts_with(ON_HOST)).collect();
    let may_be = |each: &Allocation, part: &MemoryEntry| {
        // What one of two tracers holds stands behind the name of its place.
        let named = ["", "first: ", "then: "].iter().any(|of| part.name.strip_prefix(of) == Some(&each.name));
        let bytes = part.allocated_bytes;
        named && (bytes == each.size || rules.iter().any(|rule| rule.holds(bytes, each)))
    };
    let fitting = |each: &Allocation| (0..parts.len()).filter(|part| may_be(each, parts[*part])).collect();
    let fits: Vec<Vec<usize>> = allocated.iter().map(fitting).collect();
    let mut owners = vec![None; parts.len()];
    let mut is_open = |index: &usize| !match_one(*index, &fits, &mut owners, &mut vec![false; parts.len()]);
    let open: Vec<usize> = (0..allocated.len()).filter(|index| is_open(index)).collect();
    let mut wrong: Vec<_> = open.iter().map(|index| format!("nothing tells {:?}", allocated[*index])).collect();
    let empty = parts.iter().zip(&owners).filter(|(_, owner)| owner.is_none());
    wrong.extend(empty.map(|(part, _)| format!("nothing is allocated for {part:?}")));
    wrong
}

/// A tracer of the device with parameters.
struct Subject {
    name: String,
    tracer: Rc<dyn Tracer>,
    parameters: Parameters,
    is_preset: bool,
    gpu: Arc<Gpu>,
}

/// Every device tracer by every value of every parameter that shapes what it builds, and by every preset.
fn subjects(gpu: &Arc<Gpu>) -> Vec<Subject> {
    let mut subjects = Vec::new();
    for registration in TRACERS.iter().filter(|each| each.needs_device()) {
        let description = registration.describe();
        let mut settings: Vec<Parameters> =
            presets(&description.parameters).into_iter().map(|(_, parameters)| parameters).collect();
        let presets = settings.len();
        for described in description.parameters.iter().filter(|each| each.scope == ParameterScope::Build) {
            for value in &described.sweep {
                let mut parameters = settings[0].clone();
                parameters.set(&description.parameters, described.name, &value.to_string()).unwrap();
                if !settings.contains(&parameters) {
                    settings.push(parameters);
                }
            }
        }
        // One for all: drivers compile each of its pipelines once.
        let created = registration.create(&Ok(Arc::clone(gpu)));
        let Some(tracer) = available(description.name, created, gpu).map(Rc::<dyn Tracer>::from) else { continue };
        for (index, parameters) in settings.into_iter().enumerate() {
            let name = format!("{} {parameters:?}", description.name);
            let is_preset = index < presets;
            subjects.push(Subject { name, tracer: Rc::clone(&tracer), parameters, is_preset, gpu: Arc::clone(gpu) });
        }
    }
    subjects
}

impl Subject {
    /// Builds, and gives what was allocated when the work had been recorded.
    fn build(&self, geometry: &Geometry, view: &Viewpoint) -> (Box<dyn Structure>, Vec<Allocation>) {
        self.try_build(geometry, view).unwrap()
    }

    fn try_build(
        &self,
        geometry: &Geometry,
        view: &Viewpoint,
    ) -> Result<(Box<dyn Structure>, Vec<Allocation>), TracerError> {
        let mut clock = PhaseClock::new(Some(&self.gpu));
        let structure = self.tracer.build(geometry, view, &self.parameters, &mut clock)?;
        let recorded = allocations(&self.gpu, false);
        clock.finish()?;
        Ok((structure, recorded))
    }

    /// Traces that many rays, and gives what was allocated for it when the work had been recorded, and what the structure
    /// says that it takes; nothing for an end that it does not serve by these parameters.
    fn trace(
        &self,
        structure: &dyn Structure,
        count: usize,
        trace_to: TraceTo,
    ) -> Option<(Vec<Allocation>, Vec<MemoryEntry>)> {
        // They meet nothing: what is traced does not matter here.
        let rays = vec![ray(DVec3::new(0.1, 0.2, 500.0), DVec3::Z); count];
        let rays = RayBuffer::new(Arc::new(rays), Query::Closest, Some(&self.gpu));
        let mut hits = HitBuffer::tracing_to(trace_to, count, Residency::Device, Some(&self.gpu)).unwrap();
        hits.poison(Some(&self.gpu)).unwrap();
        let before = allocations(&self.gpu, true);
        let mut clock = PhaseClock::new(Some(&self.gpu));
        let job = TraceJob { rays: &rays, trace_to, parameters: &self.parameters };
        match structure.trace(job, &mut hits, &mut clock) {
            Err(TracerError::Unsupported(_)) if trace_to == TraceTo::Surface && !self.is_preset => return None,
            served => served.unwrap_or_else(|error| panic!("{}: {error}", self.name)),
        }
        let recorded = allocations(&self.gpu, false);
        clock.finish().unwrap();
        assert_eq!(allocations(&self.gpu, true), before, "{}: a trace leaves something", self.name);
        Some((added(&before, recorded), structure.trace_memory(job).unwrap()))
    }
}

/// One triangle, a room, and many equal triangles, whose hierarchies grow too deep for private stacks.
fn scenes(gpu: &Gpu) -> Vec<Geometry> {
    let plate = rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])[0];
    let room = procedural("room", 0.02).unwrap().mesh;
    vec![
        soup(&[plate], Some(gpu)),
        Geometry::new(room.positions, room.triangles, Some(gpu)).unwrap(),
        soup(&vec![plate; 1200], Some(gpu)),
    ]
}

fn view(frame: [u32; 2]) -> Viewpoint {
    viewpoint(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.01, 10.0, frame)
}

/// A device whose allocator tells, or nothing, which is said.
fn telling() -> Option<Arc<Gpu>> {
    let gpu = gpu();
    if gpu.device.generate_allocator_report().is_none() {
        assert!(!["vulkan", "dx12"].contains(&gpu.listing.backend.as_str()), "{:?}", gpu.listing);
        let _ = writeln!(
            std::io::stderr(),
            "skipped: {} ({}) has no allocator report",
            gpu.listing.name,
            gpu.listing.backend
        );
        return None;
    }
    Some(gpu)
}

/// Proves for subjects over scenes that the ledger of a structure names every allocation that the device made for it with its
/// size, and no other, after its build and after updates of each kind; that a trace of each count of rays allocates what the
/// structure says for it and leaves nothing; that the build's peak is no less than what was seen of it; and that all is given
/// back when the structure is dropped. Gives how many structures were deep enough for stacks in memory.
fn hold(gpu: &Arc<Gpu>, subjects: &[Subject], scenes: &[Geometry], counts: &[usize]) -> usize {
    let rules = Rule::all(gpu);
    let mut with_stacks = 0;
    for subject in subjects {
        for geometry in scenes {
            let context = format!("{} over {} triangles", subject.name, geometry.triangles.len());
            // What is made once, with the first build and trace, is not the structure's.
            let structure = match subject.try_build(geometry, &view([48, 32])) {
                // A parameter may ask for more than the device holds of many equal triangles.
                Err(TracerError::TooLarge { .. }) if !subject.is_preset && geometry.triangles.len() > 1000 => continue,
                // Or bind more at once than the device's limits allow.
                Err(TracerError::Unavailable(_)) if !subject.is_preset => continue,
                built => built.unwrap().0,
            };
            for end in TraceTo::ALL {
                subject.trace(&*structure, 1, end);
            }
            drop(structure);
            let before = allocations(gpu, true);
            let (mut structure, recorded) = subject.build(geometry, &view([48, 32]));
            let check = |structure: &dyn Structure, after: &str| {
                let allocated = added(&before, allocations(gpu, true));
                assert!(!allocated.is_empty());
                assert_eq!(wrong(&rules, &structure.memory(), &allocated), Vec::<String>::new(), "{context}, {after}");
            };
            check(&*structure, "built");
            with_stacks +=
                usize::from(structure.memory().structure.iter().any(|entry| entry.name == "traversal stacks"));
            let held: u64 = added(&before, recorded).iter().map(|each| smallest(&rules, each)).sum();
            let peak = structure.memory().build_peak_bytes;
            assert!(peak >= held, "{context}: a peak of {peak}, {held} were held");
            for (count, end) in counts.iter().flat_map(|count| TraceTo::ALL.map(|end| (*count, end))) {
                let Some((traced, told)) = subject.trace(&*structure, count, end) else { continue };
                let told = MemoryReport { structure: told, ..Default::default() };
                assert_eq!(wrong(&rules, &told, &traced), Vec::<String>::new(), "{context}, {count} rays to {end:?}");
            }
            for update in Update::ALL {
                for frame in [[48, 32], [100, 37]] {
                    let mut clock = PhaseClock::new(Some(gpu));
                    match structure.update(update, geometry, &view(frame), &subject.parameters, &mut clock) {
                        Ok(()) if update == Update::Reuse => {}
                        Ok(()) => drop(clock.finish().unwrap()),
                        Err(TracerError::Unsupported(_)) => {}
                        Err(error) => panic!("{context}: {error}"),
                    }
                    check(&*structure, update.name());
                }
            }
            drop(structure);
            assert_eq!(allocations(gpu, true), before, "{context}: something is left");
        }
    }
    with_stacks
}

/// Proves [`hold`] of every device tracer by every build parameter, over one triangle, of one ray and a thousand.
#[test]
fn ledgers_are_the_devices_by_every_parameter() {
    let Some(gpu) = telling() else { return };
    hold(&gpu, &subjects(&gpu), &scenes(&gpu)[..1], &[1, 1000]);
}

/// Proves [`hold`] of every device tracer by every build parameter over every scene, of one ray and of many.
#[test]
#[ignore = "wider set: every parameter over every scene, a minute and more on a software adapter"]
fn ledgers_are_the_devices() {
    let Some(gpu) = telling() else { return };
    let with_stacks = hold(&gpu, &subjects(&gpu), &scenes(&gpu), &[1, 1000, 70_000]);
    assert!(with_stacks > 0, "no hierarchy was deep");
}

/// The size of a resource of which an allocation is known, without what aligns it; sizes are multiples of 4.
fn smallest(rules: &[Rule], allocation: &Allocation) -> u64 {
    let sizes = (0..=allocation.size).rev().take(1 << 12);
    let explained = |bytes: &u64| bytes.is_multiple_of(4) && rules.iter().any(|rule| rule.holds(*bytes, allocation));
    sizes.filter(explained).min().unwrap_or(allocation.size)
}

/// Negative control: a ledger that lacks a buffer, tells it smaller or larger than it is, tells one that is not there, or
/// another's name is noticed for every part of every tracer by its presets; and a buffer that outlives its structure is.
#[test]
fn wrong_ledgers_are_noticed() {
    let Some(gpu) = telling() else { return };
    let rules = Rule::all(&gpu);
    let geometry = &scenes(&gpu)[1];
    for subject in subjects(&gpu).into_iter().filter(|subject| subject.is_preset) {
        match subject.try_build(geometry, &view([48, 32])) {
            Err(TracerError::Unavailable(_)) if !subject.is_preset => continue,
            built => drop(built.unwrap()),
        }
        let before = allocations(&gpu, true);
        let (structure, _) = subject.build(geometry, &view([48, 32]));
        let allocated = added(&before, allocations(&gpu, true));
        let sound = structure.memory();
        assert_eq!(wrong(&rules, &sound, &allocated), Vec::<String>::new());
        for index in 0..sound.structure.len() {
            let noticed = |spoil: &dyn Fn(&mut MemoryReport)| {
                let mut spoilt = sound.clone();
                spoil(&mut spoilt);
                !wrong(&rules, &spoilt, &allocated).is_empty()
            };
            assert!(noticed(&|ledger| drop(ledger.structure.remove(index))), "{}", subject.name);
            // An allocation's size has what aligns its start, and a part that tells just that size passes, as textures do whose bytes
            // are known from there: 4 bytes too many are, where a buffer begins 4 bytes before an aligned place. 8 are then not.
            let told = |more: u64| noticed(&|ledger| ledger.structure[index].allocated_bytes += more);
            assert!(told(4) || told(8), "{} {:?}", subject.name, sound.structure[index]);
            assert!(noticed(&|ledger| ledger.structure[index].allocated_bytes -= 4), "{}", subject.name);
            assert!(noticed(&|ledger| ledger.structure[index].name.push('s')), "{}", subject.name);
            assert!(noticed(&|ledger| ledger.structure.push(ledger.structure[index].clone())), "{}", subject.name);
        }
        let left = gpu.buffer("left over", 64, BufferUsages::STORAGE, "nothing").unwrap();
        drop(structure);
        assert_ne!(allocations(&gpu, true), before);
        drop(left);
        assert_eq!(allocations(&gpu, true), before);
    }
}

/// Proves the rule on buffers that it was not found from, and that it takes no size for another.
#[test]
fn the_rule_tells_sizes_apart() {
    let Some(gpu) = telling() else { return };
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    let rule = Rule::probe(&gpu, usage);
    for size in [12, 24, 28, 44, 92, 5000, 70_000, 1_000_004] {
        let before = allocations(&gpu, true);
        let _buffer = gpu.buffer("known", size, usage, "nothing").unwrap();
        let [allocation] = &added(&before, allocations(&gpu, true))[..] else { panic!("one allocation") };
        assert!(rule.holds(size, allocation), "{rule:?} {size} {allocation:?}");
        assert!(
            !rule.holds(size + rule.step.max(4), allocation) && !rule.holds(size - rule.step.min(size), allocation)
        );
    }
}
