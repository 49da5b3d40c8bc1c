//! That a bug gets no benign name: rays that a tracer answers rightly, and wrongly once a fault is planted, are unexplained; and that
//! causes are what a simulation of the method on the host knows them to be.

use std::collections::BTreeMap;
use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Geometry, Gpu, Hit, Parameters, PhaseClock, Preset, Query, Structure, Tracer, TracerError, Viewpoint,
};
use tracebench_harness::judge::{Class, Judge, Rule};
use tracebench_harness::measure::Contender;
use tracebench_harness::measure::session::{PreparedRays, RayRequest, Session};
use tracebench_harness::progress::Progress;
use tracebench_harness::rays::{RAY_SETS, RaySet, default_parameters};
use tracebench_harness::registry::find;
use tracebench_harness::results::{Judgement, UNEXPLAINED};
use tracebench_harness::truth::{Cache, Truth};
use tracebench_harness::viewpoint::Pose;
use tracebench_scenes::procedural;
use tracebench_tests::gpu;

/// What is wrong with the geometry that a tracer is handed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    /// Nothing.
    None,
    /// Every third triangle has no area.
    EveryThirdTriangle,
    /// What lies within a slab is moved to the right by eight pixels of the frame.
    MovedSlab,
}

impl Fault {
    fn spoil(self, geometry: &Geometry, viewpoint: &Viewpoint, gpu: Option<&Gpu>) -> Geometry {
        let (low, high) = bounds(geometry);
        let view = viewpoint.frame_view();
        let corners = |primitive: usize| geometry.corners(primitive as u32);
        let triangles = (0..geometry.triangles.len()).map(|primitive| {
            let [a, b, c] = corners(primitive);
            let middle = (a + b + c) / 3.0;
            let place = (middle.x - low.x) / (high.x - low.x);
            match self {
                Self::EveryThirdTriangle if primitive % 3 == 0 => [a; 3],
                Self::MovedSlab if (0.4..0.6).contains(&place) => {
                    let depth = (middle.as_dvec3() - view.eye).dot(view.forward).abs();
                    let pixel = 2.0 * depth * view.tan_half_width / f64::from(view.size[0]);
                    [a, b, c].map(|corner| (corner.as_dvec3() + view.right * 8.0 * pixel).as_vec3())
                }
                _ => [a, b, c],
            }
        });
        let positions: Vec<[f32; 3]> = triangles.flatten().map(Vec3::into).collect();
        let indices = (0..positions.len() as u32 / 3).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]);
        Geometry::new(positions, indices.collect(), gpu).unwrap()
    }
}

fn bounds(geometry: &Geometry) -> (Vec3, Vec3) {
    let all = || geometry.positions.iter().copied().map(Vec3::from);
    (all().reduce(Vec3::min).unwrap(), all().reduce(Vec3::max).unwrap())
}

/// A tracer that is handed spoilt geometry.
struct Planted {
    tracer: Box<dyn Tracer>,
    fault: Fault,
    gpu: Arc<Gpu>,
}

impl Tracer for Planted {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        let spoilt = self.fault.spoil(geometry, viewpoint, Some(&self.gpu));
        self.tracer.build(&spoilt, viewpoint, parameters, clock)
    }
}

fn rays_of(names: &[&str]) -> Vec<RaySet> {
    RAY_SETS.iter().filter(|set| names.contains(&set.name)).copied().collect()
}

/// A small scene of the catalogue from its first camera, with rays and truth.
fn session(gpu: &Arc<Gpu>, scene: &str, sets: &[&str]) -> Session {
    let scene = procedural(scene, 0.05).unwrap();
    let pose = Pose::from(&scene.cameras[0]);
    let path = scene.camera_path.clone();
    let geometry = Geometry::new(scene.mesh.positions, scene.mesh.triangles, Some(gpu)).unwrap();
    let truth = Truth::new(&geometry, &scene.sha256);
    let viewpoint = pose.viewpoint(&geometry, [256, 128], 128);
    let parameters = default_parameters();
    let sets = rays_of(sets);
    let request = RayRequest {
        sets: &sets,
        image: [96, 48],
        seed: 1,
        parameters: &parameters,
        path: path.as_ref(),
        mirrors: &[],
    };
    let quiet = Progress::new(true);
    Session::new(&scene.name, truth, viewpoint, request, Some(Arc::clone(gpu)), &Cache::none(), &quiet).unwrap()
}

/// A tracer with a fault planted, built over a session's scene.
fn built(session: &Session, name: &str, preset: Preset, fault: Fault) -> Contender {
    let registration = find(name).unwrap();
    let description = (registration.describe)();
    let parameters = Parameters::preset(&description.parameters, preset);
    let gpu = session.gpu_handle().unwrap();
    let create = || {
        let tracer = registration.create(&Ok(Arc::clone(&gpu)))?;
        Ok(Box::new(Planted { tracer, fault, gpu: Arc::clone(&gpu) }) as Box<dyn Tracer>)
    };
    let mut contender = Contender::create(description, parameters, create).unwrap();
    session.sample_build(&mut contender).unwrap();
    contender
}

fn hits(session: &Session, contender: &Contender, rays: &PreparedRays) -> Vec<Hit> {
    let mut hits = session.hit_buffer(contender, rays).unwrap();
    session.sample_trace(contender, rays, &mut hits, 1).unwrap();
    hits.read(session.gpu()).unwrap()
}

/// The causes of some rays' wrong answers.
fn causes(
    session: &Session,
    contender: &Contender,
    rays: &PreparedRays,
    hits: &[Hit],
    of: &[usize],
) -> BTreeMap<String, u64> {
    fn some<T: Copy>(indices: &[usize], all: &[T]) -> Vec<T> {
        indices.iter().map(|index| all[*index]).collect()
    }
    let (rays_of, answers, hits) = (some(of, &rays.buffer.host), some(of, &rays.answers), some(of, hits));
    let sight = session.sight(contender).unwrap();
    let judge = Judge {
        truth: session.truth(),
        eye: session.viewpoint().eye.as_dvec3(),
        rays: &rays_of,
        answers: &answers,
        query: Query::Closest,
        samplings: &sight.samplings,
        voxels: sight.voxels,
        names_primitives: contender.description.names_primitives,
    };
    let Judgement::Closest(judgement) = judge.judge(&hits).unwrap() else { panic!("closest was asked") };
    judgement.causes["footprint"].clone()
}

/// Of rays that a tracer answers rightly and wrongly with a fault: how many, and the causes.
fn of_fault(session: &Session, name: &str, preset: Preset, fault: Fault) -> BTreeMap<String, u64> {
    let [sound, faulty] = [Fault::None, fault].map(|fault| built(session, name, preset, fault));
    let mut all = BTreeMap::new();
    for rays in &session.rays {
        let [before, after] = [&sound, &faulty].map(|contender| hits(session, contender, rays));
        let [right, wrong] = [&before, &after].map(|hits| session.classes(name, rays, Rule::Footprint, hits).unwrap());
        let spoilt = right.iter().zip(&wrong).enumerate();
        let spoilt = spoilt.filter(|(_, (right, wrong))| {
            right.is_some_and(Class::is_right) && wrong.is_some_and(|wrong| !wrong.is_right())
        });
        let spoilt: Vec<usize> = spoilt.map(|(index, _)| index).collect();
        for (cause, count) in causes(session, &faulty, rays, &after, &spoilt) {
            *all.entry(cause).or_insert(0) += count;
        }
    }
    all
}

fn check(name: &str) {
    let gpu = gpu();
    for scene in ["room", "atrium"] {
        let session = session(&gpu, scene, &["stereo", "diffuse"]);
        for preset in [Preset::Published, Preset::Improved] {
            for fault in [Fault::EveryThirdTriangle, Fault::MovedSlab] {
                let causes = of_fault(&session, name, preset, fault);
                let all: u64 = causes.values().sum();
                let unexplained = causes.get(UNEXPLAINED).copied().unwrap_or(0);
                println!(
                    "{name} {preset:?} {scene} {fault:?}: {:.3} of {all} unexplained; {causes:?}",
                    unexplained as f64 / all.max(1) as f64
                );
            }
        }
    }
}

#[test]
fn screen_dda() {
    check("screen-dda");
}

#[test]
fn fragment_abuffer() {
    check("fragment-abuffer");
}

#[test]
fn height_field() {
    check("height-field");
}

#[test]
fn quadtree() {
    check("quadtree");
}

#[test]
fn voxel_abuffer() {
    check("voxel-abuffer");
}

#[test]
fn voxel_octree() {
    check("voxel-octree");
}
