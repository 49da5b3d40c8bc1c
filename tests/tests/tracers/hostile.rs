//! Every tracer of the registry with its presets, and tiny hostile scenes with rays that suit them.

use std::rc::Rc;
use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Geometry, Gpu, Hit, HitBuffer, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Residency, Structure,
    TraceJob, TraceTo, Tracer, TracerError, Viewpoint,
};
use tracebench_harness::registry::{Registration, TRACERS};
use tracebench_tests::{Numbers, available, from_one_point, gpu, presets, ray, rectangle, soup, viewpoint};

/// A tracer under test.
pub struct Subject {
    pub name: &'static str,
    pub residency: Residency,
    pub names_primitives: bool,
    /// Whether some hits may name a triangle though others do not.
    pub has_parts: bool,
    /// Whether it serves rays from one point alone.
    pub one_origin: bool,
    pub preset: Preset,
    pub parameters: Parameters,
    pub tracer: Rc<dyn Tracer>,
    pub gpu: Arc<Gpu>,
    /// How far its traces go.
    pub trace_to: TraceTo,
}

impl Subject {
    /// A tracer with each of its presets; nothing where the adapter cannot run it.
    fn of(registration: &Registration) -> Vec<Self> {
        let description = registration.describe();
        let gpu = gpu();
        // One for all presets: drivers compile each of its pipelines once.
        let created = registration.create(&Ok(Arc::clone(&gpu)));
        let tracer = available(description.name, created, &gpu).map(Rc::<dyn Tracer>::from);
        let subject = |(preset, parameters, tracer)| Self {
            name: description.name,
            residency: description.residency,
            names_primitives: description.names_primitives,
            has_parts: registration.parts.is_some(),
            one_origin: registration.one_origin(),
            preset,
            parameters,
            tracer,
            gpu: Arc::clone(&gpu),
            trace_to: TraceTo::Hit,
        };
        let presets = presets(&description.parameters).into_iter();
        presets.filter_map(|(preset, parameters)| Some((preset, parameters, tracer.clone()?))).map(subject).collect()
    }

    pub fn build(&self, geometry: &Geometry, viewpoint: &Viewpoint) -> Box<dyn Structure> {
        let mut clock = PhaseClock::new(Some(&self.gpu));
        let built = self.tracer.build(geometry, viewpoint, &self.parameters, &mut clock);
        let structure = built.unwrap_or_else(|error| panic!("{}: {error}", self.name));
        let timing = clock.finish().unwrap_or_else(|error| panic!("{}: {error}", self.name));
        assert!(timing.total_ms >= 0.0 && timing.total_ms.is_finite());
        structure
    }

    /// Rays as the tracer serves them: as they are, or all from where the first starts.
    pub fn rays(&self, rays: &[Ray], query: Query) -> RayBuffer {
        let served = match rays.first() {
            Some(first) if self.one_origin => from_one_point(rays, first.origin),
            _ => rays.to_vec(),
        };
        RayBuffer::new(Arc::new(served), query, Some(&self.gpu))
    }

    pub fn poisoned(&self, count: usize) -> HitBuffer {
        let mut hits = HitBuffer::tracing_to(self.trace_to, count, self.residency, Some(&self.gpu)).unwrap();
        hits.poison(Some(&self.gpu)).unwrap();
        hits
    }

    pub fn job<'a>(&'a self, rays: &'a RayBuffer) -> TraceJob<'a> {
        TraceJob { rays, trace_to: self.trace_to, parameters: &self.parameters }
    }

    pub fn try_trace(
        &self,
        structure: &dyn Structure,
        rays: &RayBuffer,
        hits: &mut HitBuffer,
    ) -> Result<(), TracerError> {
        let mut clock = PhaseClock::new(Some(&self.gpu));
        structure.trace(self.job(rays), hits, &mut clock)?;
        clock.finish().map(|_| ())
    }

    pub fn trace(&self, structure: &dyn Structure, rays: &RayBuffer) -> Vec<Hit> {
        let mut hits = self.poisoned(rays.host.len());
        self.try_trace(structure, rays, &mut hits).unwrap_or_else(|error| panic!("{}: {error}", self.name));
        hits.read(Some(&self.gpu)).unwrap()
    }
}

/// Every tracer with every preset, but for those that the adapter cannot run, which are named on standard error.
pub fn subjects() -> Vec<Subject> {
    TRACERS.iter().flat_map(Subject::of).collect()
}

/// A scene with two viewpoints and rays that suit it.
pub struct Hostile {
    pub name: &'static str,
    pub geometry: Geometry,
    pub viewpoints: [Viewpoint; 2],
    pub rays: Vec<Ray>,
}

fn hostile(name: &'static str, geometry: Geometry, eyes: [Vec3; 2], target: Vec3, seed: u64) -> Hostile {
    let diagonal = geometry.diagonal();
    let view = |eye: Vec3| viewpoint(eye, target, (1e-3 * diagonal) as f32, (4.0 * diagonal) as f32, [48, 32]);
    let mut numbers = Numbers::new(seed);
    let centre = target.as_dvec3();
    let mut rays = Vec::new();
    for index in 0..300 {
        let origin = eyes[index % 2].as_dvec3() + numbers.point() * (1e-3 * diagonal);
        let aim = centre + numbers.point() * (0.3 * diagonal);
        rays.push(ray(origin, if index % 3 == 0 { numbers.direction() } else { aim - origin }));
    }
    // Through the eye, along axes, from a surface, bounded, empty in span, and far from everything.
    rays.push(ray(eyes[0].as_dvec3(), centre - eyes[0].as_dvec3()));
    for axis in [DVec3::X, DVec3::NEG_Y, DVec3::Z] {
        rays.push(ray(centre, axis));
        rays.push(ray(centre + axis * diagonal, -axis));
    }
    rays.push(Ray { t_max: (0.01 * diagonal) as f32, ..rays[1] });
    rays.push(Ray { t_min: (0.4 * diagonal) as f32, ..rays[1] });
    rays.push(Ray { t_max: 0.0, ..rays[1] });
    rays.push(ray(centre + DVec3::splat(50.0 * diagonal), DVec3::ONE));
    Hostile { name, geometry, viewpoints: eyes.map(view), rays }
}

/// All of them; thousands of equal triangles among them, over which hierarchies grow deep and long lists are given up.
pub fn scenes() -> Vec<Hostile> {
    scenes_with(2000)
}

/// The same with few equal triangles, where nothing is asked of depths and long lists.
pub fn small_scenes() -> Vec<Hostile> {
    scenes_with(100)
}

fn scenes_with(equal_triangles: usize) -> Vec<Hostile> {
    let gpu = gpu();
    let make = |triangles: &[[[f32; 3]; 3]]| soup(triangles, Some(&gpu));
    let one = make(&[[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.25]]]);
    let two = make(&rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.5]));
    let mut numbers = Numbers::new(31);
    let needles: Vec<_> = (0..200)
        .map(|_| {
            let (start, along) = (numbers.point(), numbers.point());
            [start, start + along, start + along * 0.5 + numbers.direction() * 1e-5].map(|at| at.as_vec3().into())
        })
        .collect();
    let far = |scale: f32, shift: f32| -> Vec<[[f32; 3]; 3]> {
        let [first, second] = rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.5]);
        let third = [[-0.5, -0.5, 0.5], [0.5, -0.5, 0.5], [0.0, 0.5, 0.75]];
        [first, second, third].map(|triangle| triangle.map(|corner| corner.map(|x| x * scale + shift))).to_vec()
    };
    let room = tracebench_scenes::procedural("room", 0.02).unwrap();
    let camera = &room.cameras[0];
    let (eye, target) = (Vec3::from(camera.eye), Vec3::from(camera.target));
    let mesh = room.mesh;
    let room = Geometry::with_materials(mesh.positions, mesh.triangles, mesh.triangle_materials, Some(&gpu)).unwrap();
    let eyes = [Vec3::new(0.3, 0.2, 3.0), Vec3::new(-2.0, 1.0, 2.0)];
    vec![
        hostile("one triangle", one, eyes, Vec3::ZERO, 41),
        hostile("two triangles", two, eyes, Vec3::ZERO, 42),
        hostile("needles", make(&needles), eyes, Vec3::ZERO, 43),
        hostile("huge", make(&far(1e12, 0.0)), eyes.map(|eye| eye * 1e12), Vec3::ZERO, 44),
        hostile("tiny", make(&far(1e-6, 0.0)), eyes.map(|eye| eye * 1e-6), Vec3::ZERO, 45),
        hostile("far away", make(&far(8.0, 40_000.0)), eyes.map(|eye| eye * 8.0 + 40_000.0), Vec3::splat(40_000.0), 46),
        hostile("equal triangles", make(&vec![far(1.0, 0.0)[0]; equal_triangles]), eyes, Vec3::ZERO, 48),
        hostile("room", room, [eye, eye.lerp(target, 0.3)], target, 47),
    ]
}
