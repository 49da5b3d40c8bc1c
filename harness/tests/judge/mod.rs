//! The judge against hand-made cases: every class under every rule, just inside and just outside of each tolerance,
//! every cause from the smallest scene that shows it, and the controls.

mod ambiguous;
mod causes;
mod classes;
mod controls;
mod distances;
mod orthographic;
mod surfaces;
mod voxels;

use std::sync::Arc;

use glam::{DVec3, Vec3};
use tracebench_api::{
    Geometry, Hit, ImageMarch, Layers, MarchSteps, NO_PRIMITIVE, Projection, Query, Ray, SampledImage, Status, View,
    Viewpoint, VoxelGrid,
};
use tracebench_harness::judge::{CURVE_TOLERANCES, Class, Judge, JudgeError, Rule, WRONG_RAYS_PER_CAUSE, true_counts};
use tracebench_harness::measure::controls::{Control, corrupted};
use tracebench_harness::progress::Progress;
use tracebench_harness::results::{AnyJudgement, Classes, ClosestJudgement, Judgement, StatusCounts, TrueCounts};
use tracebench_harness::truth::{Answer, Cache, TrueHit, Truth};
use tracebench_tests::{rectangle, soup};

/// Two far corners make the diagonal exactly 12 (8, 8, 4); what the tests look at is a plate in between.
fn framed(mut triangles: Vec<[[f32; 3]; 3]>) -> Truth {
    triangles.push([[-4.0, -4.0, -2.0]; 3]);
    triangles.push([[4.0, 4.0, 2.0]; 3]);
    Truth::new(&soup(&triangles, None), "judge")
}

const DIAGONAL: f64 = 12.0;

/// A plate of side 2 in the plane z = 0.
fn plate() -> Vec<[[f32; 3]; 3]> {
    rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]).to_vec()
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: Ray::UNBOUNDED }
}

fn down(x: f32, y: f32, z: f32) -> Ray {
    ray([x, y, z], [0.0, 0.0, -1.0])
}

fn hit(t: f32) -> Hit {
    Hit { t, primitive: 0, u: 0.0, v: 0.0, status: Status::Hit as u32 }
}

fn miss() -> Hit {
    Hit::miss(Status::Miss)
}

/// Rays with their truth and a judge over them.
struct Case {
    truth: Truth,
    eye: DVec3,
    rays: Arc<Vec<Ray>>,
    answers: Vec<Answer>,
    query: Query,
    samplings: Vec<SampledImage>,
    voxels: Option<VoxelGrid>,
}

impl Case {
    fn new(truth: Truth, rays: Vec<Ray>, query: Query) -> Self {
        let rays = Arc::new(rays);
        let answers = truth.answer(&rays, query, &Cache::none(), &Progress::new(true)).unwrap();
        Self { truth, eye: DVec3::new(0.0, 0.0, 2.0), rays, answers, query, samplings: Vec::new(), voxels: None }
    }

    fn judge(&self) -> Judge<'_> {
        Judge {
            truth: &self.truth,
            eye: Some(self.eye),
            rays: &self.rays,
            answers: &self.answers,
            query: self.query,
            samplings: &self.samplings,
            voxels: self.voxels,
            names_primitives: true,
            wrong_rays_per_cause: usize::MAX,
        }
    }

    fn closest(&self, hits: &[Hit]) -> ClosestJudgement {
        match self.judge().judge(hits) {
            Ok(Judgement::Closest(judgement)) => judgement,
            other => panic!("{other:?}"),
        }
    }

    fn any(&self, hits: &[Hit]) -> AnyJudgement {
        match self.judge().judge(hits) {
            Ok(Judgement::Any(judgement)) => judgement,
            other => panic!("{other:?}"),
        }
    }

    /// What an oracle answers.
    fn right(&self) -> Vec<Hit> {
        let answer = |answer: &Answer| match answer.hit {
            Some(TrueHit { t, primitive }) => Hit { primitive, ..hit(t as f32) },
            None => miss(),
        };
        self.answers.iter().map(answer).collect()
    }

    /// The one cause of a single wrong ray under a rule.
    fn cause(&self, rule: &str, hits: &[Hit]) -> String {
        let causes = match self.judge().judge(hits).unwrap() {
            Judgement::Closest(judgement) => judgement.causes,
            Judgement::Any(judgement) => judgement.causes,
        };
        let causes = &causes[rule];
        assert_eq!((causes.len(), causes.values().sum::<u64>()), (1, 1), "{causes:?}");
        causes.keys().next().unwrap().clone()
    }
}

/// Makes a ray ambiguous: right is its own answer, and those given (t and triangle, or a miss) once it is moved; the rest stay as its own.
fn make_ambiguous(answer: &mut Answer, moved: &[Option<(f64, u32)>]) {
    let mut perturbed = Box::new([answer.hit; 8]);
    for (slot, hit) in perturbed.iter_mut().zip(moved) {
        *slot = hit.map(|(t, primitive)| TrueHit { t, primitive });
    }
    answer.perturbed = Some(perturbed);
}

/// One ray down onto the plate from z = 2: true t is 2, and the eye is where it starts.
fn one() -> Case {
    Case::new(framed(plate()), vec![down(0.25, 0.5, 2.0)], Query::Closest)
}

fn classes(case: &Case, hit: Hit) -> [Class; 3] {
    [Rule::HitMiss, Rule::Tight, Rule::Footprint].map(|rule| case.judge().class(rule, 0, &hit))
}

/// A hundred rays: sixty onto the plate, forty beside it.
fn hundred(query: Query) -> Case {
    let rays = (0..100).map(|index| {
        let along = index as f32 / 100.0;
        if index < 60 { down(along - 0.3, 0.31, 2.0) } else { down(2.0 + along, 0.31, 2.0) }
    });
    let case = Case::new(framed(plate()), rays.collect(), query);
    assert!(case.answers.iter().all(|answer| !answer.is_ambiguous()));
    assert_eq!(case.answers.iter().filter(|answer| answer.hit.is_some()).count(), 60);
    case
}
