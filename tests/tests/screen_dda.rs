//! `screen-dda` and its depth buffer against f64: what is rasterized, where a ray is walked, why it ends.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Geometry, Gpu, Hit, HitBuffer, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Residency, Status, Structure,
    TraceJob, TraceTo, Tracer, View, Viewpoint,
};
use tracebench_harness::judge::{Judge, WRONG_RAYS_PER_CAUSE};
use tracebench_harness::progress::Progress;
use tracebench_harness::rays::primary_rays;
use tracebench_harness::results::Judgement;
use tracebench_harness::truth::{Cache, Ray64, Truth};
use tracebench_kit::{EyeDepthTarget, LayerTarget, NO_SURFACE, NearestLayers, NearestScene, RasterBackend};
use tracebench_screen_dda::{ScreenDda, description};
use tracebench_tests::{Numbers, gpu, ray, rectangle, soup};

/// A camera in the origin that looks along -z: 90 degrees over 64 x 64 pixels, so that a pixel at depth d is d / 32
/// wide.
fn camera() -> Viewpoint {
    Viewpoint {
        eye: Vec3::ZERO,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: std::f32::consts::FRAC_PI_2,
        near: 0.1,
        far: 100.0,
        frame: [64, 64],
        face: 64,
    }
}

/// A structure over a scene with everything that is needed to ask it.
struct Scene {
    gpu: Arc<Gpu>,
    geometry: Geometry,
    structure: Box<dyn Structure>,
}

impl Scene {
    fn new(geometry: Geometry, viewpoint: &Viewpoint) -> Self {
        let gpu = gpu();
        let tracer = ScreenDda::new(Arc::clone(&gpu)).unwrap();
        let mut clock = PhaseClock::new(Some(&gpu));
        let structure = tracer.build(&geometry, viewpoint, &parameters(&[]), &mut clock).unwrap();
        clock.finish().unwrap();
        Self { gpu, geometry, structure }
    }

    fn of(triangles: &[[[f32; 3]; 3]]) -> Self {
        Self::new(soup(triangles, Some(&gpu())), &camera())
    }

    fn trace(&self, rays: &[Ray], query: Query, parameters: &Parameters) -> Vec<Hit> {
        let rays = RayBuffer::new(Arc::new(rays.to_vec()), query, Some(&self.gpu));
        let mut hits = HitBuffer::new(rays.host.len(), Residency::Device, Some(&self.gpu)).unwrap();
        hits.poison(Some(&self.gpu)).unwrap();
        let mut clock = PhaseClock::new(Some(&self.gpu));
        let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters };
        self.structure.trace(job, &mut hits, &mut clock).unwrap();
        clock.finish().unwrap();
        hits.read(Some(&self.gpu)).unwrap()
    }

    fn one(&self, ray: Ray, settings: &[(&str, &str)]) -> Hit {
        self.trace(&[ray], Query::Closest, &parameters(settings))[0]
    }

    /// A thickness in scene units as the parameter takes it.
    fn thickness(&self, scene_units: f64) -> String {
        (scene_units / self.geometry.diagonal()).to_string()
    }
}

/// The published parameters with changes.
fn parameters(settings: &[(&str, &str)]) -> Parameters {
    let descriptions = description().parameters;
    let mut parameters = Parameters::preset(&descriptions, Preset::Published);
    for (name, value) in settings {
        parameters.set(&descriptions, name, value).unwrap();
    }
    parameters
}

fn status(hit: &Hit) -> Status {
    Status::from_code(hit.status).unwrap()
}

/// A plate of side 2 at depth 4, and two specks that make the scene wide without being seen.
fn plate() -> Scene {
    let mut triangles = rectangle([-1.0, -1.0, -4.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]).to_vec();
    triangles.push([[30.0, 0.0, 30.0], [30.1, 0.0, 30.0], [30.0, 0.1, 30.0]]);
    Scene::of(&triangles)
}

fn from(origin: [f64; 3], direction: [f64; 3]) -> Ray {
    ray(DVec3::from(origin), DVec3::from(direction))
}

fn rasterize(gpu: &Gpu, geometry: &Geometry, view: &View) -> Vec<f32> {
    let layers = NearestLayers::of_depths(gpu).unwrap();
    let target = EyeDepthTarget::new(gpu, view.size).unwrap();
    let (geometry, triangle_count) = (geometry.on_device().unwrap(), geometry.triangles.len() as u32);
    let scene = NearestScene { raster_backend: RasterBackend::Raster, view, geometry, triangle_count };
    let pass = layers.prepare(gpu, scene, None).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    layers.record(&mut encoder, &pass, LayerTarget { image: &target.eye_depth, layer: 0, test: &target.test });
    gpu.queue.submit([encoder.finish()]);
    target.read(gpu).unwrap()
}

/// This far round a centre the same triangle must be seen for the pixel to be compared: by so much the device snaps borders, and
/// positions of corners are f32.
fn snap_pixels() -> f64 {
    1.0 / 64.0 + tracebench_kit::rasterizer(&gpu()).unwrap().border_pixels()
}

/// Planes in f32 of corners that may lie far outside of the frame: share of the depth.
const INTERPOLATION: f64 = 2e-5;

/// Pixels compared, and how many of them are off. Not compared are those where within `snap_pixels` of the centre
/// another triangle, or none, is seen; the tolerance is the range of depths seen there, widened by `INTERPOLATION`.
fn compare_depths(truth: &Truth, view: &View, depths: &[f32]) -> (usize, usize) {
    let shown = |x: f64, y: f64| {
        let direction = view.direction_through(x, y);
        truth.closest(&Ray64 { origin: view.eye, direction, t_min: view.near, t_max: view.far })
    };
    let snap = snap_pixels();
    let (mut compared, mut off) = (0, 0);
    for (pixel, depth) in depths.iter().enumerate() {
        let (column, row) = (pixel as u32 % view.size[0], pixel as u32 / view.size[0]);
        let (x, y) = (f64::from(column) + 0.5, f64::from(row) + 0.5);
        let around = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (0.0, 0.0)]
            .map(|(across, down)| shown(x + across * snap, y + down * snap));
        let primitives = around.map(|hit| hit.map(|hit| hit.primitive));
        if primitives.iter().any(|primitive| *primitive != primitives[0]) {
            continue;
        }
        compared += 1;
        let seen: Vec<f64> = around.iter().flatten().map(|hit| hit.t).collect();
        let right = if seen.is_empty() {
            *depth == NO_SURFACE
        } else {
            let (least, most) =
                (seen.iter().copied().fold(f64::INFINITY, f64::min), seen.iter().copied().fold(0.0, f64::max));
            (least * (1.0 - INTERPOLATION)..=most * (1.0 + INTERPOLATION)).contains(&f64::from(*depth))
        };
        off += usize::from(!right);
    }
    (compared, off)
}

fn room(scale: f64, frame: [u32; 2]) -> (Geometry, Viewpoint) {
    let scene = tracebench_scenes::procedural("room", scale).unwrap();
    let geometry = Geometry::new(scene.mesh.positions, scene.mesh.triangles, Some(&gpu())).unwrap();
    let viewpoint = tracebench_harness::viewpoint::Pose::from(&scene.cameras[0]).viewpoint(&geometry, frame, 16);
    (geometry, viewpoint)
}

/// Triangles all round the camera, many of which cross its near plane or lie behind it.
fn around_the_eye() -> Vec<[[f32; 3]; 3]> {
    let mut numbers = Numbers::new(51);
    (0..80).map(|_| std::array::from_fn(|_| (numbers.point() * 8.0).as_vec3().into())).collect()
}

/// Proves that the depth buffer holds the nearest surface's linear eye depth at every pixel's centre: in a room, among
/// triangles that cross the near plane, and on a slanted floor to the horizon.
#[test]
fn depth_buffer_is_that_of_f64() {
    let gpu = gpu();
    let floor = rectangle([-400.0, -0.5, 10.0], [800.0, 0.0, 0.0], [0.0, 0.0, -800.0]).to_vec();
    let mut scenes = vec![(room(0.02, [96, 64]), 0.9)];
    for (triangles, least) in [(around_the_eye(), 0.8), (floor, 0.9)] {
        scenes.push(((soup(&triangles, Some(&gpu)), camera()), least));
    }
    for ((geometry, viewpoint), least) in scenes {
        let view = viewpoint.frame_view();
        let truth = Truth::new(&geometry, "depth");
        let depths = rasterize(&gpu, &geometry, &view);
        let (compared, off) = compare_depths(&truth, &view, &depths);
        assert_eq!(off, 0, "of {compared}");
        assert!(compared as f64 > least * depths.len() as f64, "{compared} of {}", depths.len());
        let covered = depths.iter().filter(|depth| **depth != NO_SURFACE).count();
        assert!(covered > depths.len() / 4);
    }
}

/// Negative control: depths moved by one pixel, one thousandth farther, or of a camera that stands a hundredth aside are
/// noticed.
#[test]
fn other_depths_are_noticed() {
    let gpu = gpu();
    let (geometry, viewpoint) = room(0.02, [96, 64]);
    let view = viewpoint.frame_view();
    let truth = Truth::new(&geometry, "depth");
    let depths = rasterize(&gpu, &geometry, &view);
    let off = |depths: &[f32]| compare_depths(&truth, &view, depths).1;
    let mut moved = depths.clone();
    moved.rotate_right(1);
    assert!(off(&moved) > 100);
    let farther: Vec<f32> = depths.iter().map(|depth| depth * 1.001).collect();
    assert!(off(&farther) > 100);
    let aside = Viewpoint { eye: viewpoint.eye + viewpoint.forward.cross(viewpoint.up) * 0.01, ..viewpoint };
    assert!(off(&rasterize(&gpu, &geometry, &aside.frame_view())) > 100);
}

/// The share of primary rays that are right under the footprint rule when rays start from an image of a given size.
fn primary_agreement(image: [u32; 2]) -> f64 {
    let (geometry, viewpoint) = room(0.05, [128, 64]);
    let truth = Truth::new(&geometry, "primary");
    let rays = Arc::new(primary_rays(&viewpoint, image));
    let answers = truth.answer(&rays, Query::Closest, &Cache::none(), &Progress::new(true)).unwrap();
    let scene = Scene::new(geometry, &viewpoint);
    let hits = scene.trace(&rays, Query::Closest, &parameters(&[]));
    let samplings = scene.structure.samplings(&parameters(&[])).unwrap();
    let judge = Judge {
        truth: &truth,
        eye: Some(viewpoint.eye.as_dvec3()),
        rays: &rays,
        answers: &answers,
        query: Query::Closest,
        samplings: &samplings,
        voxels: None,
        names_primitives: false,
        wrong_rays_per_cause: WRONG_RAYS_PER_CAUSE,
    };
    match judge.judge(&hits).unwrap() {
        Judgement::Closest(judgement) => judgement.agreement.footprint.unwrap(),
        Judgement::Any(_) => panic!("closest was asked"),
    }
}

/// Proves that primary rays through the very pixels of the depth buffer are right to 99.9 % under the footprint rule,
/// and, as a negative control, that rays between its pixels are not.
#[test]
fn primary_rays_through_its_pixels_are_right() {
    let through_pixels = primary_agreement([128, 64]);
    assert!(through_pixels >= 0.999, "{through_pixels}");
    let between = primary_agreement([384, 192]);
    assert!(between < through_pixels, "{between}");
}

/// Proves what thickness does, on a ray that passes one unit behind a plate: it is rejected, with that status, until the
/// thickness reaches the ray, and then hits where the ray first falls behind the plate's edge.
#[test]
fn thickness_decides_about_rays_behind() {
    let scene = plate();
    // At depth 5, seen behind the plate where |x| < 5/4: from x = -3 after 1.75, to a pixel (5/32).
    let behind = from([-3.0, 0.1, -5.0], [1.0, 0.0, 0.0]);
    for thin in [0.0, 0.5, 0.98] {
        let hit = scene.one(behind, &[("thickness", &scene.thickness(thin))]);
        assert_eq!(status(&hit), Status::ThicknessRejected, "{thin}");
    }
    for thick in [1.02, 3.0] {
        let hit = scene.one(behind, &[("thickness", &scene.thickness(thick))]);
        assert_eq!(status(&hit), Status::Hit, "{thick}");
        assert!((hit.t - 1.75).abs() < 5.0 / 32.0, "{hit:?}");
    }
    // In front of the plate, thickness is nothing.
    let before = from([-3.0, 0.1, -3.5], [1.0, 0.0, 0.0]);
    for thickness in ["0", "10"] {
        assert!(!scene.one(before, &[("thickness", thickness)]).is_hit());
    }
}

/// Proves that a ray which crosses a surface from the front hits it whatever the thickness, at the surface's depth.
#[test]
fn crossings_need_no_thickness() {
    let scene = plate();
    for thickness in ["0", "0.005"] {
        for (origin, direction) in [
            ([-2.0, 0.1, -2.0], [1.0, 0.0, -1.0]),
            ([0.5, -1.5, -2.5], [-0.25, 0.75, -1.0]),
            ([0.3, 0.2, -1.0], [0.1, 0.05, -1.0]),
        ] {
            let ray = from(origin, direction);
            let hit = scene.one(ray, &[("thickness", thickness), ("hit_point", "depth")]);
            let expected = (-4.0 - f64::from(ray.origin[2])) / f64::from(ray.direction[2]);
            assert_eq!(status(&hit), Status::Hit, "{origin:?}");
            assert!((f64::from(hit.t) - expected).abs() < 1e-4, "{hit:?} {expected}");
        }
    }
}

fn random_rays(viewpoint: &Viewpoint, count: usize, spread: f64, seed: u64) -> Vec<Ray> {
    let mut numbers = Numbers::new(seed);
    let view = viewpoint.frame_view();
    let from_view = |_| {
        let (x, y) = (numbers.unit() * f64::from(view.size[0]), numbers.unit() * f64::from(view.size[1]));
        let origin = view.eye + view.direction_through(x, y) * (spread * (0.1 + numbers.unit()));
        ray(origin, numbers.direction())
    };
    (0..count).map(from_view).collect()
}

/// Proves over thousands of rays that more thickness only ever adds hits, and never makes a hit later.
#[test]
fn thickness_is_monotone() {
    let (geometry, viewpoint) = room(0.02, [96, 64]);
    let rays = random_rays(&viewpoint, 3000, 2.0, 52);
    let scene = Scene::new(geometry, &viewpoint);
    let traced = ["0", "0.002", "0.01", "0.1", "10"]
        .map(|thickness| scene.trace(&rays, Query::Closest, &parameters(&[("thickness", thickness)])));
    let mut gained = 0;
    for pair in traced.windows(2) {
        for (thin, thick) in pair[0].iter().zip(&pair[1]) {
            assert!(!thin.is_hit() || thick.is_hit() && thick.t <= thin.t * 1.000_01, "{thin:?} {thick:?}");
            gained += usize::from(thick.is_hit() && !thin.is_hit());
        }
    }
    assert!(gained > 100, "{gained}");
}

/// Proves that the step limit ends a ray with its own status, and only a ray that needs more steps.
#[test]
fn the_step_limit_is_said() {
    let scene = plate();
    let far_across = from([-3.0, 1.5, -5.0], [1.0, 0.0, 0.0]);
    assert_eq!(status(&scene.one(far_across, &[("max_steps", "1")])), Status::StepCap);
    assert_eq!(status(&scene.one(far_across, &[("max_steps", "20")])), Status::StepCap);
    assert_eq!(status(&scene.one(far_across, &[])), Status::LeftViews);
    // With strides of 64 pixels the same way takes a step or two.
    assert_eq!(status(&scene.one(far_across, &[("max_steps", "4"), ("stride", "64")])), Status::LeftViews);
    let primary = from([0.0, 0.0, 0.0], [0.02, 0.03, -1.0]);
    assert_eq!(status(&scene.one(primary, &[("max_steps", "1")])), Status::Hit);
}

/// Proves the statuses of rays that find nothing: those that leave the view, never enter it, lie behind the camera, or
/// beyond far, have left it; one that is bounded and wholly in view has missed.
#[test]
fn rays_that_find_nothing_say_why() {
    let scene = plate();
    let bounded = |ray: Ray, t_max: f32| Ray { t_max, ..ray };
    let in_view = from([-2.0, 1.5, -5.0], [1.0, 0.0, 0.0]);
    for (ray, expected) in [
        (in_view, Status::LeftViews),
        (bounded(in_view, 2.0), Status::Miss),
        (from([0.0, 0.1, 3.0], [0.0, 0.0, 1.0]), Status::LeftViews),
        (from([0.0, 0.1, 3.0], [1.0, 0.0, 0.0]), Status::LeftViews),
        (from([9.0, 0.0, -2.0], [1.0, 0.0, 0.0]), Status::LeftViews),
        (from([9.0, 0.0, -2.0], [0.0, 1.0, 0.0]), Status::LeftViews),
        (from([0.0, 0.0, -200.0], [0.0, 0.0, -1.0]), Status::LeftViews),
        (from([3.0, 3.0, -6.0], [1.0, 0.0, 0.0]), Status::LeftViews),
        // Ends before it enters the view.
        (bounded(from([0.3, 0.1, 3.0], [0.0, 0.0, -1.0]), 2.0), Status::LeftViews),
        // From in the view to in it, along the line of sight, in front of the plate.
        (bounded(from([0.3, 0.1, -1.0], [0.0, 0.0, -1.0]), 1.5), Status::Miss),
    ] {
        assert_eq!(status(&scene.one(ray, &[])), expected, "{ray:?}");
    }
}

/// Proves rays in special positions: from the eye, along the axis of view, through the eye from behind it, from before
/// the near plane, towards the eye, and parallel to the image plane onto a surface that crosses it.
#[test]
fn rays_in_special_positions() {
    let scene = plate();
    for (origin, direction, expected) in [
        ([0.0, 0.0, 0.0], [0.0, 0.0, -1.0], 4.0),
        ([0.3, -0.2, 0.0], [0.0, 0.0, -1.0], 4.0),
        ([0.0, 0.0, 0.0], [0.2, 0.1, -1.0], 4.0 * 1.05_f64.sqrt()),
        ([0.0, 0.0, 5.0], [0.0, 0.0, -1.0], 9.0),
        ([-0.4, -0.2, 2.0], [0.2, 0.1, -1.0], 6.0 * 1.05_f64.sqrt()),
        ([0.1, 0.1, -0.01], [0.0, 0.0, -1.0], 3.99),
        ([0.1, 0.1, 0.05], [0.0, 0.0, -1.0], 4.05),
    ] {
        let hit = scene.one(from(origin, direction), &[("hit_point", "depth")]);
        assert_eq!(status(&hit), Status::Hit, "{origin:?} {direction:?}");
        assert!((f64::from(hit.t) - expected).abs() < 1e-4, "{origin:?} {direction:?}: {} not {expected}", hit.t);
    }
    for (origin, direction) in
        [([0.4, 0.2, -2.0], [-0.4, -0.2, 2.0]), ([0.0, 0.0, -2.0], [0.0, 0.0, 1.0]), ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0])]
    {
        assert_eq!(status(&scene.one(from(origin, direction), &[])), Status::LeftViews, "{origin:?}");
    }
    // A wall at x = 1 from depth 2 to 6: rays at constant depth 4 meet it at x = 1, to two pixels (4/32 each).
    let wall = Scene::of(&rectangle([1.0, -3.0, -2.0], [0.0, 6.0, 0.0], [0.0, 0.0, -4.0]));
    let thickness = wall.thickness(0.3);
    let hit = wall.one(from([-1.0, 0.2, -4.0], [1.0, 0.0, 0.0]), &[("thickness", &thickness)]);
    assert!(hit.is_hit() && (hit.t - 2.0).abs() < 0.25, "{hit:?}");
}

/// Proves that t never leaves the ray's span: t_min beyond the surface, t_max before it, spans within a pixel.
#[test]
fn hits_stay_within_the_span() {
    let (geometry, viewpoint) = room(0.02, [96, 64]);
    let mut numbers = Numbers::new(53);
    let rays: Vec<Ray> = random_rays(&viewpoint, 3000, 2.0, 54)
        .into_iter()
        .map(|ray| {
            let t_min = (numbers.unit() * 0.5) as f32;
            Ray { t_min, t_max: t_min + (numbers.unit() * numbers.unit() * 6.0) as f32, ..ray }
        })
        .collect();
    let scene = Scene::new(geometry, &viewpoint);
    for hit_point in ["depth", "step"] {
        let hits = scene.trace(&rays, Query::Closest, &parameters(&[("hit_point", hit_point), ("thickness", "0.1")]));
        assert!(hits.iter().filter(|hit| hit.is_hit()).count() > 100);
        for (ray, hit) in rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
            assert!((ray.t_min..=ray.t_max).contains(&hit.t), "{ray:?} {hit:?}");
        }
    }
}

/// Proves that any hit is found where and only where the nearest is.
#[test]
fn any_hit_is_the_nearest() {
    let (geometry, viewpoint) = room(0.02, [96, 64]);
    let rays = random_rays(&viewpoint, 2000, 2.0, 55);
    let scene = Scene::new(geometry, &viewpoint);
    let [closest, any] = [Query::Closest, Query::Any].map(|query| scene.trace(&rays, query, &parameters(&[])));
    let found = closest.iter().filter(|hit| hit.is_hit()).count();
    assert!(found > 100 && found < 2000);
    assert!(closest.iter().zip(&any).all(|(closest, any)| closest.is_hit() == any.is_hit()));
}

/// Proves that more rays than one row of workgroups holds (65,535 of 64) are all answered: each of 4,194,304 rays as the
/// same ray in a small set.
#[test]
fn more_rays_than_a_row_of_workgroups() {
    let scene = plate();
    let mut numbers = Numbers::new(56);
    let few: Vec<Ray> = (0..4096).map(|_| ray(DVec3::ZERO, numbers.point() - DVec3::Z * 2.0)).collect();
    let count = 65_536 * 64;
    let limit = scene.gpu.limits.max_storage_buffer_binding_size;
    assert!((count * size_of::<Ray>()) as u64 <= limit, "this device binds {limit} bytes only");
    let expected = scene.trace(&few, Query::Closest, &parameters(&[]));
    assert!(expected.iter().any(Hit::is_hit) && expected.iter().any(|hit| !hit.is_hit()));
    let many: Vec<Ray> = few.iter().copied().cycle().take(count).collect();
    let hits = scene.trace(&many, Query::Closest, &parameters(&[]));
    assert!(hits.chunks(few.len()).all(|chunk| chunk == expected));
}

/// Proves that a frame that the device cannot hold is an error that names the option to turn down.
#[test]
fn a_frame_too_large_is_an_error() {
    let gpu = gpu();
    let edge = gpu.limits.max_texture_dimension_2d + 1;
    let error = EyeDepthTarget::new(&gpu, [edge, 1]).unwrap_err().to_string();
    assert!(error.contains("--frame-size") && error.contains(&edge.to_string()), "{error}");
}
