//! How right the quad-tree over depth layers is in rooms, of the rays that one view can answer at all.

use std::collections::BTreeMap;
use std::sync::Arc;

use tracebench_api::glam::DVec3;
use tracebench_api::{Geometry, Gpu, Hit, Parameters, Preset, Projection, Query, Viewpoint};
use tracebench_harness::judge::{Class, Judge, Rule, WRONG_RAYS_PER_CAUSE};
use tracebench_harness::measure::TracerConfig;
use tracebench_harness::measure::session::{PreparedRays, Session};
use tracebench_harness::progress::Progress;
use tracebench_harness::rays::{RAY_SETS, RayParameters, RayScene, RaySet, default_parameters};
use tracebench_harness::registry::find;
use tracebench_harness::results::Judgement;
use tracebench_harness::truth::{Cache, Ray64, Truth};
use tracebench_harness::viewpoint::Pose;
use tracebench_scenes::{catalogue, procedural};
use tracebench_tests::gpu;

const NAME: &str = "quadtree";
const LOSSLESS: [(&str, &str); 2] = [("gamma_norm", "0"), ("gamma_dist", "0")];

/// How much is asked.
#[derive(Clone, Copy)]
struct Size {
    scale: f64,
    frame: [u32; 2],
    rays: [u32; 2],
}

fn rays_of(names: &[&str]) -> Vec<RaySet> {
    RAY_SETS.iter().filter(|set| names.contains(&set.name)).copied().collect()
}

/// A scene of the catalogue from its first camera, with rays and truth.
fn session(gpu: &Arc<Gpu>, scene: &str, sets: &[&str], size: Size) -> Session {
    let scene = procedural(scene, size.scale).unwrap();
    let pose = Pose::from(&scene.cameras[0]);
    let path = scene.camera_path.clone();
    let geometry = Geometry::new(scene.mesh.positions, scene.mesh.triangles, Some(gpu)).unwrap();
    let truth = Arc::new(Truth::new(&geometry, &scene.sha256));
    let viewpoint = pose.viewpoint(&geometry, size.frame, 64);
    let seen = RayScene {
        truth: &truth,
        viewpoint: &viewpoint,
        path: path.as_ref(),
        mirrors: &[],
        image: size.rays,
        seed: 1,
        parameters: &RayParameters::try_from(&default_parameters()).unwrap(),
    };
    let (truth, gpu, quiet) = (Arc::clone(&truth), Some(Arc::clone(gpu)), Progress::new(true));
    Session::new(&scene.name, truth, &rays_of(sets), &seen, gpu, &Cache::none(), &quiet).unwrap()
}

/// The tracer with some settings over a preset, built over a session's scene.
fn built(session: &Session, preset: Preset, settings: &[(&str, &str)]) -> TracerConfig {
    let registration = find(NAME).unwrap();
    let description = registration.describe();
    let mut parameters = Parameters::preset(&description.parameters, preset);
    for (name, value) in settings {
        parameters.set(&description.parameters, name, value).unwrap();
    }
    let device = Ok(session.gpu.clone().unwrap());
    let mut config = TracerConfig::ready(description, parameters, registration.create(&device).unwrap());
    session.sample_build(&mut config).unwrap();
    config
}

fn hits(session: &Session, config: &TracerConfig, rays: &PreparedRays) -> Vec<Hit> {
    let mut hits = session.hit_buffer(config, rays).unwrap();
    session.sample_trace(config, rays, &mut hits, 1).unwrap();
    hits.read(session.gpu()).unwrap()
}

/// What the centre of a point's pixel shows.
#[derive(Clone, Copy, PartialEq)]
enum AtCentre {
    /// The point's own triangle.
    Triangle,
    /// Another, within a footprint in depth.
    Near,
    /// Something else, or nothing.
    Other,
}

fn at_centre(truth: &Truth, viewpoint: &Viewpoint, point: DVec3, primitive: u32) -> AtCentre {
    let view = viewpoint.frame_view();
    let projection = Projection::Perspective(view);
    let Some(at) = view.project_inside(point) else { return AtCentre::Other };
    let line = projection.line_through(at.x.floor() + 0.5, at.y.floor() + 0.5);
    let along = Ray64 { origin: line.origin, direction: line.direction, t_min: line.near, t_max: line.far };
    // A reference pixel: 1024 over a right angle.
    let footprint = 2.0 * point.distance(view.eye) / 1024.0;
    match truth.closest(&along) {
        Some(hit) if hit.primitive == primitive => AtCentre::Triangle,
        Some(hit) if (hit.t - at.depth).abs() <= footprint => AtCentre::Near,
        _ => AtCentre::Other,
    }
}

/// How far a rasterizer may move a centre, as the judge has it.
const SNAP_PIXELS: f64 = 1.0 / 64.0;

/// Whether the centres of all pixels that a point may fall on, as f32 rounds, show its own triangle: on a border between pixels, along
/// which a stereo eye's rays run, which of them a ray is in hangs on the last bit.
fn is_sure(truth: &Truth, viewpoint: &Viewpoint, point: DVec3, primitive: u32) -> bool {
    let view = viewpoint.frame_view();
    let Some(at) = view.project_inside(point) else { return false };
    let moves = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    moves.into_iter().all(|(across, down)| {
        let [x, y] = [at.x + across * SNAP_PIXELS, at.y + down * SNAP_PIXELS].map(|at| at.floor() + 0.5);
        let line = Projection::Perspective(view).line_through(x, y);
        let along = Ray64 { origin: line.origin, direction: line.direction, t_min: line.near, t_max: line.far };
        truth.closest(&along).is_some_and(|hit| hit.primitive == primitive)
    })
}

/// Rays, and right ones among them.
#[derive(Clone, Copy, Default, Debug)]
struct Share {
    right: u32,
    rays: u32,
}

impl Share {
    fn add(&mut self, right: bool) {
        self.rays += 1;
        self.right += u32::from(right);
    }

    fn wrong(self) -> u32 {
        self.rays - self.right
    }

    fn value(self) -> f64 {
        f64::from(self.right) / f64::from(self.rays.max(1))
    }
}

/// What came of a ray set: of all rays, of those whose true hit is the nearest in the view, of those whose pixel's centre shows it or a
/// triangle as near, of those whose pixel's centre shows the very triangle, of those whose pixels' centres surely do; and the causes of
/// wrong ones among those whose pixel's centre shows it or one as near.
struct Outcome {
    all: Share,
    visible: Share,
    at_centre: Share,
    same_triangle: Share,
    sure: Share,
    causes: BTreeMap<String, u64>,
}

fn outcome(session: &Session, config: &TracerConfig, rays: &PreparedRays) -> Outcome {
    let hits = hits(session, config, rays);
    let (truth, viewpoint) = (&session.truth, &session.viewpoint);
    let view = viewpoint.frame_view();
    let [mut all, mut visible, mut same_triangle, mut sure] = [Share::default(); 4];
    let mut shown = Vec::new();
    let classes = session.classes(NAME, rays, Rule::Footprint, &hits).unwrap();
    for (index, class) in classes.iter().enumerate() {
        let Some(right) = class.map(Class::is_right) else { continue };
        all.add(right);
        let Some(hit) = rays.answers[index].hit else { continue };
        let point = Ray64::from(&rays.buffer.host[index]).at(hit.t);
        let to_point = Ray64 { origin: view.eye, direction: point - view.eye, t_min: 0.0, t_max: 1.0 - 1e-6 };
        if view.project_inside(point).is_some() && truth.closest(&to_point).is_none() {
            visible.add(right);
        }
        let centre = at_centre(truth, viewpoint, point, hit.primitive);
        if centre == AtCentre::Triangle {
            same_triangle.add(right);
            if is_sure(truth, viewpoint, point, hit.primitive) {
                sure.add(right);
            }
        }
        if centre != AtCentre::Other {
            shown.push(index);
        }
    }
    fn of<T: Clone>(indices: &[usize], all: &[T]) -> Vec<T> {
        indices.iter().map(|index| all[*index].clone()).collect()
    }
    let (rays_of, answers, hits) = (of(&shown, &rays.buffer.host), of(&shown, &rays.answers), of(&shown, &hits));
    let judge = Judge {
        truth,
        eye: Some(view.eye),
        rays: &rays_of,
        answers: &answers,
        query: Query::Closest,
        samplings: &config.structure().unwrap().samplings(&config.parameters).unwrap(),
        voxels: None,
        names_primitives: false,
        wrong_rays_per_cause: WRONG_RAYS_PER_CAUSE,
    };
    let Judgement::Closest(judgement) = judge.judge(&hits).unwrap() else { panic!("closest was asked") };
    let causes = judgement.causes["footprint"].clone();
    let wrong: u64 = causes.values().sum();
    let at_centre = Share { right: (shown.len() as u64 - wrong) as u32, rays: shown.len() as u32 };
    Outcome { all, visible, at_centre, same_triangle, sure, causes }
}

/// What must be right, at least.
#[derive(Clone, Copy)]
struct Least {
    /// Of rays whose pixel's centre shows the triangle that they hit.
    same_triangle: f64,
    /// Of rays whose pixel's centre shows it or another as near.
    at_centre: f64,
}

const fn least(same_triangle: f64, at_centre: f64) -> Least {
    Least { same_triangle, at_centre }
}

/// What must be right of a scene's diffuse and stereo rays.
type LeastOf = (&'static str, [Least; 2]);

const SETS: [&str; 2] = ["diffuse", "stereo"];

fn check_lossless(size: Size, scenes: &[LeastOf]) {
    let gpu = gpu();
    for (scene, least) in scenes {
        let session = session(&gpu, scene, &SETS, size);
        let lossless = built(&session, Preset::Improved, &LOSSLESS);
        let published = built(&session, Preset::Published, &LOSSLESS);
        // Joined patches open merged planes where they matter.
        let merged = [("gamma_norm", "25"), ("gamma_dist", "64"), ("patches", "squares")];
        let merged = built(&session, Preset::Improved, &merged);
        assert_eq!(session.rays.iter().map(|rays| rays.set.name).collect::<Vec<_>>(), SETS);
        for (rays, least) in session.rays.iter().zip(least) {
            let name = rays.set.name;
            for (label, config) in [("lossless", &lossless), ("lossless, else published", &published)] {
                let found = outcome(&session, config, rays);
                println!(
                    "{scene} {name}, {label}: right {:.4} of {} whose triangle is surely at the pixel's centre, {:.4} of {} where it \
                     is, {:.4} of {} where one as near is, {:.4} of {} visible, {:.4} of {}; wrong at centres: {:?}",
                    found.sure.value(),
                    found.sure.rays,
                    found.same_triangle.value(),
                    found.same_triangle.rays,
                    found.at_centre.value(),
                    found.at_centre.rays,
                    found.visible.value(),
                    found.visible.rays,
                    found.all.value(),
                    found.all.rays,
                    found.causes
                );
                if label == "lossless" {
                    assert!(found.at_centre.rays > found.all.rays / 5, "{scene} {name}: {:?}", found.at_centre);
                    assert!(
                        found.same_triangle.value() >= least.same_triangle,
                        "{scene} {name}: {:?}",
                        found.same_triangle
                    );
                    assert!(found.at_centre.value() >= least.at_centre, "{scene} {name}: {:?}", found.at_centre);
                }
            }
            // Negative control: planes that stand for whatever lies within 64 pixels.
            let coarse = outcome(&session, &merged, rays);
            assert!(coarse.at_centre.value() < least.at_centre - 0.05, "{scene} {name}: {:?}", coarse.at_centre);
        }
    }
}

/// Proves of a small frame that lossless trees answer most rays whose true hit its pixel's centre shows. Negative control: merged by
/// large thresholds they do not.
#[test]
fn lossless_trees_find_what_pixels_show() {
    check_lossless(
        Size { scale: 0.1, frame: [512, 256], rays: [64, 32] },
        &[("room", [least(0.9, 0.9), least(0.97, 0.97)])],
    );
}

/// The same of a large one, where nearly all are right. Of diffuse rays in the atrium that hit beside the triangle that the centre shows,
/// many do so within two pixels of their start, where it is not looked, and many pass fluted columns that are seen from aside.
#[test]
#[ignore = "wider set: two scenes at full size, half a minute on a software adapter"]
fn lossless_trees_find_what_pixels_show_at_full_size() {
    let size = Size { scale: 1.0, frame: [1024, 512], rays: [128, 64] };
    let scenes = [("room", [least(0.95, 0.95), least(0.98, 0.98)]), ("atrium", [least(0.95, 0.93), least(0.98, 0.98)])];
    check_lossless(size, &scenes);
}

/// Proves that of the diffuse rays in the atrium whose pixel's centre shows the triangle that they hit, or one as near, merging costs the
/// improved form at most 1.5 points. Negative control: by the published threshold it costs more.
#[test]
fn improved_loses_little_to_its_lossless_tree() {
    const MOST_LOST: f64 = 0.015;
    let gpu = gpu();
    let size = Size { scale: 1.0, frame: [1024, 512], rays: [256, 128] };
    let session = session(&gpu, "atrium", &["diffuse"], size);
    let of = |settings: &[(&str, &str)]| {
        outcome(&session, &built(&session, Preset::Improved, settings), &session.rays[0]).at_centre
    };
    let [lossless, improved] = [of(&LOSSLESS), of(&[])];
    let coarse = of(&[("gamma_dist", "1e-5"), ("gamma_dist_in", "cube")]);
    println!("right: lossless {lossless:?}, merged {improved:?}, by the published threshold {coarse:?}");
    assert!(lossless.rays > 5000, "{lossless:?}");
    assert_eq!([improved.rays, coarse.rays], [lossless.rays; 2]);
    let lost = |share: Share| lossless.value() - share.value();
    assert!(lost(improved) <= MOST_LOST, "{lossless:?} {improved:?}");
    assert!(lost(coarse) > MOST_LOST, "{lossless:?} {coarse:?}");
}

/// Holds both presets, as they are, against each other on the rays whose triangle their pixels' centres surely show.
fn check_halved(size: Size, scenes: &[&str]) {
    // Of few wrong rays one more or less tells nothing.
    const SLACK: u32 = 5;
    let gpu = gpu();
    for scene in scenes {
        let session = session(&gpu, scene, &SETS, size);
        let mut tells = false;
        let [published, improved] = Preset::ALL.map(|preset| built(&session, preset, &[]));
        for rays in &session.rays {
            let [before, after] = [&published, &improved].map(|config| outcome(&session, config, rays));
            println!(
                "{scene} {}: of {} rays published gets {} wrong, improved {}; of all right {:.4} and {:.4}",
                rays.set.name,
                before.sure.rays,
                before.sure.wrong(),
                after.sure.wrong(),
                before.all.value(),
                after.all.value()
            );
            let halved = |wrong: u32| 2 * wrong <= before.sure.wrong() + SLACK;
            assert!(halved(after.sure.wrong()), "{scene} {}: {:?} {:?}", rays.set.name, before.sure, after.sure);
            assert!(after.all.right >= before.all.right, "{scene} {}: {:?} {:?}", rays.set.name, before.all, after.all);
            tells |= !halved(before.sure.wrong());
        }
        // Negative control: of some ray set the published form's own errors are too many to pass.
        assert!(tells, "{scene}: published gets too few rays wrong to tell");
    }
}

/// Proves of a small frame that the improved form gets at most half as many of the rays wrong whose hits its first layer surely holds.
#[test]
fn improved_halves_what_published_gets_wrong() {
    check_halved(Size { scale: 0.1, frame: [512, 256], rays: [64, 32] }, &["room"]);
}

/// The same of a large one and every scene.
#[test]
#[ignore = "wider set: all scenes at full size, minutes on a software adapter"]
fn improved_halves_what_published_gets_wrong_in_every_scene() {
    let scenes: Vec<&str> = catalogue().iter().map(|entry| entry.name).collect();
    check_halved(Size { scale: 1.0, frame: [1024, 512], rays: [128, 64] }, &scenes);
}
