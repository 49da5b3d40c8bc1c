//! Pairs of tracers as one: every answer is one of theirs, to the bit.

use std::rc::Rc;
use std::sync::Arc;

use tracebench_api::glam::DVec3;
use tracebench_api::{
    Counter, Geometry, Gpu, Hit, HitBuffer, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Residency, Status,
    Structure, Surface, TraceJob, TraceTo, Tracer, TracerError, Viewpoint,
};
use tracebench_harness::plan::TracerRequest;
use tracebench_harness::registry::{self, Registration, TRACERS};
use tracebench_harness::truth::{Ray64, Truth, tight_tolerance};
use tracebench_hybrid::{Hybrid, Part, description};
use tracebench_tests::{available, from_one_point, gpu, gpu_that_binds};

use super::hostile::{Hostile, small_scenes};

/// A tracer that several pairs have.
#[derive(Clone)]
struct Shared(Rc<dyn Tracer>);

impl Tracer for Shared {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        self.0.build(geometry, viewpoint, parameters, clock)
    }
}

/// Something that pairs are made of, with what it answers alone.
struct Alone {
    part: Part,
    one_origin: bool,
    tracer: Shared,
}

/// Every tracer of the device by its improved preset.
fn parts(gpu: &Arc<Gpu>) -> Vec<Alone> {
    let on_device = TRACERS.iter().filter(|each| each.needs_device() && each.parts.is_none());
    let of = |registration: &Registration| {
        let description = registration.describe();
        let tracer = available(description.name, registration.create(&Ok(Arc::clone(gpu))), gpu)?;
        let part = Part { name: description.name, description, preset: Preset::Improved };
        Some(Alone { part, one_origin: registration.one_origin(), tracer: Shared(Rc::from(tracer)) })
    };
    on_device.filter_map(of).collect()
}

/// A structure that is asked.
struct Asked {
    gpu: Arc<Gpu>,
    structure: Box<dyn Structure>,
    parameters: Parameters,
}

type Answers = (Vec<Hit>, Vec<Surface>);

impl Asked {
    fn new(gpu: &Arc<Gpu>, tracer: &dyn Tracer, parameters: Parameters, scene: &Hostile) -> Self {
        let mut clock = PhaseClock::new(Some(gpu));
        let structure = tracer.build(&scene.geometry, &scene.viewpoints[0], &parameters, &mut clock).unwrap();
        clock.finish().unwrap();
        Self { gpu: Arc::clone(gpu), structure, parameters }
    }

    /// Answers, and by how much submissions were numbered on while a trace was recorded and when it was finished.
    fn trace(&self, rays: &RayBuffer, trace_to: TraceTo) -> (Answers, [u64; 2]) {
        let gpu = &*self.gpu;
        let mut hits = HitBuffer::tracing_to(trace_to, rays.host.len(), Residency::Device, Some(gpu)).unwrap();
        hits.poison(Some(gpu)).unwrap();
        let begin = submissions(gpu);
        let mut clock = PhaseClock::new(Some(gpu));
        let job = TraceJob { rays, trace_to, parameters: &self.parameters };
        self.structure.trace(job, &mut hits, &mut clock).unwrap();
        let recorded = submissions(gpu);
        clock.finish().unwrap();
        let counts = [recorded - begin, submissions(gpu) - recorded];
        ((hits.read(Some(gpu)).unwrap(), hits.read_surfaces(Some(gpu)).unwrap()), counts)
    }

    fn count(&self, rays: &RayBuffer) -> Vec<Counter> {
        let mut hits = HitBuffer::new(rays.host.len(), Residency::Device, Some(&self.gpu)).unwrap();
        let job = TraceJob { rays, trace_to: TraceTo::Hit, parameters: &self.parameters };
        self.structure.trace_counted(job, &mut hits).unwrap()
    }
}

/// The number of a submission of nothing: submissions are numbered one after the other, with what mapping makes wgpu write.
fn submissions(gpu: &Gpu) -> u64 {
    let told = format!("{:?}", gpu.queue.submit([]));
    told.chars().filter(char::is_ascii_digit).collect::<String>().parse().unwrap()
}

/// The bytes of an answer.
fn answer((hits, surfaces): &Answers, index: usize) -> Vec<u8> {
    let surface = surfaces.get(index).map_or(&[][..], |surface| bytemuck::bytes_of(surface));
    [bytemuck::bytes_of(&hits[index]), surface].concat()
}

/// Whether an answer is trusted, told once more.
fn trusts(trust: &str, hit: &Hit) -> bool {
    match trust {
        "none" => false,
        "hit" => hit.status == Status::Hit as u32,
        "hit+miss" => hit.status == Status::Hit as u32 || hit.status == Status::Miss as u32,
        _ => true,
    }
}

/// Answers that are not the first's where it is trusted, else the second's.
fn wrong(trust: &str, joined: &Answers, [first, then]: [&Answers; 2]) -> usize {
    let of = |index: usize| if trusts(trust, &first.0[index]) { first } else { then };
    (0..joined.0.len()).filter(|index| answer(joined, *index) != answer(of(*index), *index)).count()
}

/// Right answers by hit or miss alone, and by t.
fn right(truth: &Truth, rays: &[Ray], hits: &[Hit]) -> [usize; 2] {
    let fine = |ray: &Ray, hit: &Hit| match (truth.closest(&Ray64::from(ray)), hit.is_hit()) {
        (None, false) => [1, 1],
        (Some(found), true) => {
            let off = (f64::from(hit.t) - found.t).abs();
            [1, usize::from(off <= tight_tolerance(found.t, truth.diagonal()))]
        }
        _ => [0, 0],
    };
    rays.iter().zip(hits).map(|(ray, hit)| fine(ray, hit)).fold([0, 0], |[a, b], [c, d]| [a + c, b + d])
}

/// Proves for pairs over a scene, by every trust, both ways to launch and both ends, that each answer is bit for bit the first's where that
/// is trusted and else what the second answers alone; that `none` hands all over and `all` nothing; that nothing is submitted, and so
/// nothing read back, while a trace is recorded, and as often as by one tracer in all, whatever is handed over; and that an exact second makes no more rays
/// wrong.
fn answers_are_of_one_or_the_other(wanted: impl Fn(&str, &str) -> bool) {
    let gpu = gpu();
    let scene = small_scenes().into_iter().find(|scene| scene.name == "room").unwrap();
    let truth = Truth::new(&scene.geometry, "room");
    let parts = parts(&gpu);
    let alone: Vec<Asked> = parts
        .iter()
        .map(|each| {
            let parameters = Parameters::preset(&each.part.description.parameters, Preset::Improved);
            Asked::new(&gpu, &each.tracer, parameters, &scene)
        })
        .collect();
    let idle = {
        let before = submissions(&gpu);
        submissions(&gpu) - before
    };
    let (mut handed_over, mut compared) = ([0; 4], 0);
    for (first, of_first) in parts.iter().zip(&alone) {
        for (then, of_then) in parts.iter().zip(&alone) {
            if !wanted(first.part.name, then.part.name) {
                continue;
            }
            let context = format!("{} then {}", first.part.name, then.part.name);
            let pair = [first.part.clone(), then.part.clone()];
            let described = description(&pair, &[]);
            let tracers: [Box<dyn Tracer>; 2] = [Box::new(first.tracer.clone()), Box::new(then.tracer.clone())];
            let hybrid = Hybrid::new(Arc::clone(&gpu), pair, tracers).unwrap();
            let parameters = Parameters::preset(&described.parameters, Preset::Published);
            let mut asked = Asked::new(&gpu, &hybrid, parameters, &scene);
            let one_origin = first.one_origin || then.one_origin;
            let host = if one_origin { from_one_point(&scene.rays, scene.rays[0].origin) } else { scene.rays.clone() };
            for (query, trace_to) in [(Query::Closest, *described.ends.last().unwrap()), (Query::Any, TraceTo::Hit)] {
                let rays = RayBuffer::new(Arc::new(host.clone()), query, Some(&gpu));
                let (one, of_one) = of_first.trace(&rays, trace_to);
                let (other, _) = of_then.trace(&rays, trace_to);
                let by_first = right(&truth, &host, &one.0);
                // Some ask the device once after a build, before the first trace.
                asked.trace(&rays, trace_to);
                for (place, trust) in ["none", "hit", "hit+miss", "all"].into_iter().enumerate() {
                    for dispatch in ["indirect", "full"] {
                        asked.parameters.set(&described.parameters, "trust", trust).unwrap();
                        asked.parameters.set(&described.parameters, "dispatch", dispatch).unwrap();
                        let (mut joined, submitted) = asked.trace(&rays, trace_to);
                        assert_eq!(submitted, [idle, of_one[1]], "{context}: {trust}");
                        assert_eq!(wrong(trust, &joined, [&one, &other]), 0, "{context}: {trust} {dispatch} {query:?}");
                        let better = right(&truth, &host, &joined.0);
                        let is_exact = query == Query::Closest && then.part.description.names_primitives;
                        assert!(!is_exact || (0..2).all(|rule| better[rule] >= by_first[rule]), "{context}: {trust}");
                        // The negative control: a bit is noticed.
                        joined.0[7].t = f32::from_bits(joined.0[7].t.to_bits() ^ 1);
                        assert_eq!(wrong(trust, &joined, [&one, &other]), 1);
                        compared += 1;
                    }
                    let told = asked.count(&rays).iter().find(|each| each.name == "rays_handed_over").unwrap().total;
                    let expected = one.0.iter().filter(|hit| !trusts(trust, hit)).count();
                    assert_eq!(told, expected as u64, "{context}: {trust}");
                    handed_over[place] += expected;
                }
            }
        }
    }
    let [none, hit, hit_miss, all] = handed_over;
    assert!(compared > 16 && all == 0 && hit_miss > 0 && hit_miss < hit && hit < none, "{handed_over:?}");
}

/// See [`answers_are_of_one_or_the_other`], of every tracer with the default other part.
#[test]
fn answers_are_of_one_or_the_other_by_default_parts() {
    answers_are_of_one_or_the_other(|first, then| first == "screen-dda" || then == "ploc-gpu");
}

/// See [`answers_are_of_one_or_the_other`], of every pair.
#[test]
#[ignore = "wider set: every pair of tracers, a minute on a software adapter"]
fn answers_are_of_one_or_the_other_by_every_pair() {
    answers_are_of_one_or_the_other(|_, _| true);
}

/// A hybrid by its default parts with settings.
fn default_of(gpu: &Arc<Gpu>, settings: &[(&str, &str)], scene: &Hostile) -> Asked {
    let mut request = TracerRequest::of(registry::find("hybrid").unwrap(), Preset::Published);
    settings.iter().for_each(|(name, value)| request.set(name, value).unwrap());
    let tracer = request.registration.create(&Ok(Arc::clone(gpu))).unwrap();
    Asked::new(gpu, &*tracer, request.parameters, scene)
}

/// Proves that of a first's hits just those are handed over that project within so many pixels of the frame's border, by f64; those that lie
/// on the limit may go either way.
#[test]
fn hits_near_the_border_are_handed_over() {
    let gpu = gpu();
    let scene = small_scenes().into_iter().find(|scene| scene.name == "room").unwrap();
    let rays = RayBuffer::new(Arc::new(scene.rays.clone()), Query::Closest, Some(&gpu));
    let frame = scene.viewpoints[0].frame_view();
    let [all, none] =
        ["all", "none"].map(|trust| default_of(&gpu, &[("trust", trust)], &scene).trace(&rays, TraceTo::Hit).0);
    let near = default_of(&gpu, &[("trust", "all"), ("border_pixels", "4")], &scene);
    let joined = near.trace(&rays, TraceTo::Hit).0;
    let off = |index: usize| {
        let (ray, hit) = (&scene.rays[index], &all.0[index]);
        let [origin, direction] = [ray.origin, ray.direction].map(|each| DVec3::from(each.map(f64::from)));
        let at = frame.project(origin + direction * f64::from(hit.t)).filter(|_| hit.is_hit())?;
        let [width, height] = frame.size.map(f64::from);
        let inside = [at.x, at.y, width - at.x, height - at.y].into_iter().fold(f64::INFINITY, f64::min);
        let beyond = |at: f64, edge: f64| (-at).max(at - edge).max(0.0);
        Some(if inside >= 0.0 { inside } else { beyond(at.x, width).hypot(beyond(at.y, height)) })
    };
    let mut counts = [0; 2];
    for index in 0..scene.rays.len() {
        let off = off(index);
        if off.is_some_and(|off| (off - 4.0).abs() < 1e-2) {
            continue;
        }
        let is_near = off.is_some_and(|off| off < 4.0);
        let expected = if is_near { &none } else { &all };
        assert_eq!(answer(&joined, index), answer(expected, index), "ray {index}: {off:?}");
        counts[usize::from(is_near)] += usize::from(answer(&none, index) != answer(&all, index));
    }
    assert!(counts[0] > 20 && counts[1] > 0, "{counts:?}");
}

/// Proves that the phases of a trace are told apart, that what both structures hold is in one ledger under both names, and that parts that
/// need more than the device binds say which part it is.
#[test]
fn parts_are_told_apart() {
    let gpu = gpu();
    let scene = small_scenes().into_iter().find(|scene| scene.name == "room").unwrap();
    let asked = default_of(&gpu, &[], &scene);
    let names = asked.structure.memory().structure.into_iter().map(|entry| entry.name).collect::<Vec<_>>();
    assert!(
        ["first: eye depth buffer", "then: CWBVH nodes"].iter().all(|name| names.contains(&(*name).to_owned())),
        "{names:?}"
    );
    let rays = RayBuffer::new(Arc::new(scene.rays.clone()), Query::Closest, Some(&gpu));
    let mut hits = HitBuffer::new(scene.rays.len(), Residency::Device, Some(&gpu)).unwrap();
    hits.poison(Some(&gpu)).unwrap();
    let mut clock = PhaseClock::new(Some(&gpu));
    let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters: &asked.parameters };
    asked.structure.trace(job, &mut hits, &mut clock).unwrap();
    let phases = clock.finish().unwrap().phases.into_iter().map(|phase| phase.name).collect::<Vec<_>>();
    assert!(phases.is_empty() || phases == ["first: march", "hand over", "then: traverse", "join"], "{phases:?}");
    let small = gpu_that_binds(4096);
    let tracer = registry::find("hybrid").unwrap().create(&Ok(Arc::clone(&small))).unwrap();
    let room = tracebench_scenes::procedural("room", 0.05).unwrap().mesh;
    let geometry = Geometry::new(room.positions, room.triangles, Some(&small)).unwrap();
    let mut clock = PhaseClock::new(Some(&small));
    let built = tracer.build(&geometry, &scene.viewpoints[0], &asked.parameters, &mut clock);
    let error = built.err().unwrap().to_string();
    assert!(error.contains(" in a hybrid: ") && error.contains("turn down"), "{error}");
}
