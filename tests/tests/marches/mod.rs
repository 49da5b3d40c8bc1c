//! The tracers over the depths of one view, `screen-dda` with all that it can be told, `height-field` and `mesh-warp`, against f64 and
//! against themselves.

mod heights;
mod mesh;
mod reference;
mod screen;

use std::sync::Arc;

use reference::Depths;
use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Counter, Geometry, Gpu, Hit, HitBuffer, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Residency,
    Structure, TraceJob, TraceTo, Tracer, View, Viewpoint,
};
use tracebench_harness::registry::find;
use tracebench_harness::viewpoint::Pose;
use tracebench_kit::{EyeDepthTarget, LayerTarget, NearestLayers, NearestScene, RasterBackend};
use tracebench_tests::{Numbers, gpu, ray, soup};

/// From the origin along -z: 90 degrees across, over odd numbers of pixels.
fn camera() -> Viewpoint {
    Viewpoint {
        eye: Vec3::ZERO,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: 1.2,
        near: 0.1,
        far: 50.0,
        frame: [63, 41],
        face: 16,
    }
}

/// A closed block, its fronts outward, round its centre by three half edges that are right-handed.
fn block(centre: DVec3, [x, y, z]: [DVec3; 3]) -> Vec<[[f32; 3]; 3]> {
    let mut triangles = Vec::new();
    for (normal, along, upward) in [(x, y, z), (y, z, x), (z, x, y)] {
        for side in [1.0, -1.0] {
            let corner =
                |a: f64, b: f64| (centre + normal * side + along * (a * side) + upward * b).as_vec3().to_array();
            let [first, second, third, fourth] =
                [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| corner(a, b));
            triangles.extend([[first, second, third], [first, third, fourth]]);
        }
    }
    triangles
}

/// Closed blocks in all poses all over the view, one behind another.
fn blocks() -> Vec<[[f32; 3]; 3]> {
    let mut numbers = Numbers::new(71);
    let mut triangles = Vec::new();
    for _ in 0..40 {
        let depth = 2.0 + 8.0 * numbers.unit();
        let centre = DVec3::new(numbers.signed() * depth, 0.7 * numbers.signed() * depth, -depth);
        let (x, y) = numbers.direction().any_orthonormal_pair();
        let sizes = [0.15, 0.1, 0.2].map(|size| size * depth * (0.5 + numbers.unit()));
        triangles.extend(block(centre, [x * sizes[0], y * sizes[1], x.cross(y) * sizes[2]]));
    }
    triangles
}

fn room() -> (Geometry, Viewpoint) {
    let scene = tracebench_scenes::procedural("room", 0.02).unwrap();
    let geometry = Geometry::new(scene.mesh.positions, scene.mesh.triangles, Some(&gpu())).unwrap();
    let viewpoint = Pose::from(&scene.cameras[0]).viewpoint(&geometry, [95, 61], 16);
    (geometry, viewpoint)
}

/// Rays from the eye, from all over the view in any direction, bounded and not, along axes, along lines between pixels, towards the
/// eye and away from it.
fn rays(view: &View, count: usize, reach: f64, seed: u64) -> Vec<Ray> {
    let mut numbers = Numbers::new(seed);
    let size = view.size.map(f64::from);
    let place = |numbers: &mut Numbers, exact: bool| {
        let [x, y] = size.map(|edge| numbers.unit() * edge);
        let (x, y) = if exact { (x.round(), y.round()) } else { (x, y) };
        view.eye + view.direction_through(x, y) * (reach * (0.1 + 0.9 * numbers.unit()))
    };
    (0..count)
        .map(|index| {
            let (from, to) = (place(&mut numbers, index % 7 == 0), place(&mut numbers, index % 7 == 0));
            let made = match index % 6 {
                0 => ray(view.eye, to - view.eye),
                1 => ray(from, numbers.direction()),
                2 => ray(
                    from,
                    [view.right, view.up, view.forward][index / 6 % 3] * if index % 4 < 2 { 1.0 } else { -1.0 },
                ),
                3 => ray(from, view.eye - from + numbers.point() * (0.02 * reach)),
                _ => ray(from, to - from),
            };
            let t_max = if index % 5 == 0 { (reach * numbers.unit()) as f32 } else { made.t_max };
            Ray { t_max, ..made }
        })
        .collect()
}

/// A tracer with parameters, built over a scene.
struct Built {
    gpu: Arc<Gpu>,
    parameters: Parameters,
    structure: Box<dyn Structure>,
}

fn parameters(name: &str, settings: &[(&str, &str)]) -> Parameters {
    let described = find(name).unwrap().describe().parameters;
    let mut parameters = Parameters::preset(&described, Preset::Published);
    for (parameter, value) in settings {
        parameters.set(&described, parameter, value).unwrap();
    }
    parameters
}

fn tracer(name: &str) -> Box<dyn Tracer> {
    find(name).unwrap().create(&Ok(gpu())).unwrap()
}

impl Built {
    fn new(tracer: &dyn Tracer, parameters: Parameters, geometry: &Geometry, viewpoint: &Viewpoint) -> Self {
        let gpu = gpu();
        let mut clock = PhaseClock::new(Some(&gpu));
        let structure = tracer.build(geometry, viewpoint, &parameters, &mut clock).unwrap();
        clock.finish().unwrap();
        structure.validate(geometry).unwrap();
        Self { gpu, parameters, structure }
    }

    /// The same structure asked with other parameters of traces.
    fn hits_with(&self, parameters: &Parameters, rays: &[Ray]) -> (Vec<Hit>, Vec<Counter>) {
        let rays = RayBuffer::new(Arc::new(rays.to_vec()), Query::Closest, Some(&self.gpu));
        let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters };
        let mut hits = HitBuffer::new(rays.host.len(), Residency::Device, Some(&self.gpu)).unwrap();
        hits.poison(Some(&self.gpu)).unwrap();
        let mut clock = PhaseClock::new(Some(&self.gpu));
        self.structure.trace(job, &mut hits, &mut clock).unwrap();
        clock.finish().unwrap();
        let timed = hits.read(Some(&self.gpu)).unwrap();
        let counters = self.structure.trace_counted(job, &mut hits).unwrap();
        assert!(timed == hits.read(Some(&self.gpu)).unwrap(), "the counting variant answers otherwise");
        (timed, counters)
    }

    fn hits(&self, rays: &[Ray]) -> Vec<Hit> {
        self.hits_with(&self.parameters, rays).0
    }
}

/// A counter's sum over all rays.
fn total(counters: &[Counter], name: &str) -> u64 {
    counters.iter().find(|counter| counter.name == name).unwrap_or_else(|| panic!("no {name}")).total
}

/// Depths drawn apart from any tracer: the nearest, so many layers behind it, and their backs.
fn draw(geometry: &Geometry, view: &View, layers: u32, separation: f32, backs: bool) -> Depths {
    draw_by(RasterBackend::Raster, geometry, view, layers, separation, backs)
}

/// The same by the rasterizer or in compute, which may give a border's pixel to another side.
fn draw_by(
    raster_backend: RasterBackend,
    geometry: &Geometry,
    view: &View,
    layers: u32,
    separation: f32,
    backs: bool,
) -> Depths {
    let gpu = gpu();
    let drawn = NearestLayers::of_depths(&gpu).unwrap();
    let images = if backs { 2 * layers } else { layers };
    let target = EyeDepthTarget::of_images(&gpu, view.size, images).unwrap();
    let (geometry, triangle_count) = (geometry.on_device().unwrap(), geometry.triangles.len() as u32);
    let scene = NearestScene { raster_backend, view, geometry, triangle_count };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    for layer in 0..images {
        let passed = match (layer, layer.checked_sub(layers)) {
            (0, _) => None,
            (_, Some(front)) => Some((&target.images[front as usize], tracebench_kit::backs())),
            (_, None) => Some((&target.images[layer as usize - 1], tracebench_kit::behind(separation))),
        };
        let pass = drawn.prepare(&gpu, scene, passed).unwrap();
        let image = &target.images[layer as usize];
        drawn.record(&mut encoder, &pass, LayerTarget { image, layer, test: &target.test });
    }
    gpu.queue.submit([encoder.finish()]);
    let images = (0..images).map(|image| target.read_image(&gpu, image).unwrap()).collect();
    Depths { view: *view, images }
}

/// How far eye space is shifted to find rays whose answer rounding may decide, scene units.
const SHIFT: f64 = 3e-5;

/// Holds hits against a reference in f64 that is also asked after shifts of the ray: where these answer otherwise, rounding may decide.
/// Gives how many rays were compared, and what is wrong.
fn compare(rays: &[Ray], hits: &[Hit], reference: impl Fn(&Ray, DVec3) -> Option<f64>) -> (usize, Vec<String>) {
    let (mut compared, mut wrong) = (0, Vec::new());
    for (ray, hit) in rays.iter().zip(hits) {
        let expected = reference(ray, DVec3::ZERO);
        let shifts = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let shifted = shifts.map(|shift| reference(ray, shift * SHIFT));
        let off = |other: &Option<f64>| match (expected, other) {
            (None, None) => 0.0,
            (Some(expected), Some(other)) => (expected - other).abs(),
            _ => f64::INFINITY,
        };
        let slack = shifted.iter().map(off).fold(0.0, f64::max);
        if slack > 0.02 {
            continue;
        }
        compared += 1;
        let right = match expected {
            None => !hit.is_hit(),
            Some(t) => hit.is_hit() && (f64::from(hit.t) - t).abs() <= 2.0 * slack + 1e-5 * (1.0 + t),
        };
        if !right {
            wrong.push(format!("{ray:?}: {hit:?} instead of {expected:?} within {slack}"));
        }
    }
    (compared, wrong)
}

/// The blocks on the device.
fn scene() -> Geometry {
    soup(&blocks(), Some(&gpu()))
}
