//! Poses, times and scales among which the worst is searched.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::rc::Rc;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use tracebench_scenes::{SCALE_MIN, Scene};

use crate::measure::session::PreparedRays;
use crate::measure::{Context, RunError, SceneTruth, load_scene};
use crate::plan::{Plan, SceneSource};
use crate::rays::sampling::Stream;
use crate::results::PoseRecord;
use crate::truth::{Answer, Truth};
use crate::viewpoint::{Pose, PoseError};

/// The least distance of an eye from surfaces, in scene diagonals.
const CLEARANCE_DIAGONALS: f64 = 0.01;
/// The least share of an image's pixels that rays start from, and of rays that hit something.
const HIT_SHARE: f64 = 0.05;
/// The greatest share of ambiguous rays, of sets that are not made to be ambiguous.
const AMBIGUOUS_SHARE: f64 = 0.06;

/// Times of an animation beside the own one, and parts of the own scale.
const TIMES: u32 = 16;
const SCALES: [f64; 3] = [1.0, 0.5, 0.25];

/// The target's distance from the eye, and the longest way that an eye moves, in scene diagonals.
const TARGET_DIAGONALS: f64 = 0.1;
const MOVE_DIAGONALS: f64 = 0.25;
/// How often time and scale change with a pose.
const CHANGE_SHARE: f64 = 0.125;

/// Scenes that are held at a time.
const HELD: usize = 4;

/// A pose with the places of its time and scale among those that there are; the first are the plan's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Candidate {
    eye: [f32; 3],
    target: [f32; 3],
    time: usize,
    scale: usize,
}

impl Candidate {
    /// The pose as `--view` takes it.
    pub(super) fn view(&self) -> String {
        let ([x, y, z], [to_x, to_y, to_z]) = (self.eye, self.target);
        format!("{x},{y},{z}:{to_x},{to_y},{to_z}")
    }

    /// The pose that `--view` makes of it.
    pub(super) fn pose(&self, name: &str) -> Result<Pose, PoseError> {
        Ok(Pose { name: name.to_owned(), ..Pose::parse(&self.view())? })
    }
}

/// The poses of a scene.
pub(super) struct Poses<'a> {
    plan: &'a Plan,
    source: &'a SceneSource,
    context: &'a Context<'a>,
    times: Vec<f64>,
    scales: Vec<f64>,
    loaded: RefCell<BTreeMap<usize, Scene>>,
    held: RefCell<Vec<([usize; 2], Rc<SceneTruth>)>>,
}

impl<'a> Poses<'a> {
    pub(super) fn new(plan: &'a Plan, source: &'a SceneSource, context: &'a Context<'a>) -> Result<Self, RunError> {
        let own = plan.preset.scene_scale;
        let scene = load_scene(source, own)?;
        let end = scene.animation.as_ref().map(|animation| animation.duration_s);
        let grid = |end: f64| (0..=TIMES).map(move |step| end * f64::from(step) / f64::from(TIMES));
        // Rays that are there are of the scene as it is.
        let is_fixed = plan.ray_sets.iter().any(|set| set.saved().is_some());
        let moving = end.into_iter().filter(|_| !is_fixed).flat_map(grid);
        let times = std::iter::once(plan.time_s).chain(moving).collect();
        let is_listed = matches!(source, SceneSource::Catalogue(_)) && !is_fixed;
        let scales =
            SCALES.map(|part| own * part).into_iter().filter(|scale| *scale == own || is_listed && *scale >= SCALE_MIN);
        let (loaded, held) = (RefCell::new([(0, scene)].into()), RefCell::default());
        Ok(Self { plan, source, context, times, scales: scales.collect(), loaded, held })
    }

    /// The scene's name.
    pub(super) fn name(&self) -> &str {
        self.source.name()
    }

    /// The scene at a candidate's time and scale.
    pub(super) fn scene(&self, of: &Candidate) -> Result<Scene, RunError> {
        let mut scene = match self.loaded.borrow_mut().entry(of.scale) {
            Entry::Occupied(loaded) => loaded.get().clone(),
            Entry::Vacant(place) => place.insert(load_scene(self.source, self.scales[of.scale])?).clone(),
        };
        scene.drop_zero_area(&[self.times[of.time]])?;
        Ok(scene)
    }

    /// The same with its truth.
    pub(super) fn truth(&self, of: &Candidate) -> Result<Rc<SceneTruth>, RunError> {
        let key = [of.time, of.scale];
        let mut held = self.held.borrow_mut();
        let found = match held.iter().position(|(other, _)| *other == key) {
            Some(place) => held.remove(place).1,
            None => Rc::new(SceneTruth::new(self.scene(of)?, self.context.device, Truth::lightly_audited)?),
        };
        held.truncate(HELD - 1);
        held.insert(0, (key, Rc::clone(&found)));
        Ok(found)
    }

    /// The plan at a candidate's time and scale.
    pub(super) fn plan(&self, of: &Candidate, plan: &Plan) -> Plan {
        let mut plan = Plan { scenes: vec![self.source.clone()], time_s: self.times[of.time], ..plan.clone() };
        plan.preset.scene_scale = self.scales[of.scale];
        plan
    }

    /// A trial's pose as records have it, without what it gave.
    pub(super) fn record(&self, of: &Candidate) -> PoseRecord {
        let scale = matches!(self.source, SceneSource::Catalogue(_)).then(|| self.scales[of.scale]);
        PoseRecord { view: of.view(), time_s: self.times[of.time], scale, ..PoseRecord::default() }
    }

    /// Any pose whose eye is in the bounds.
    pub(super) fn any(&self, stream: &mut Stream) -> Result<Candidate, RunError> {
        let place = |stream: &mut Stream, of: usize| (stream.unit() * of as f64) as usize;
        let of = Candidate {
            time: place(stream, self.times.len()),
            scale: place(stream, self.scales.len()),
            ..Candidate::default()
        };
        let scene = self.truth(&of)?;
        let geometry = scene.truth.geometry();
        let (low, high) = (geometry.bounds_min.as_dvec3(), geometry.bounds_max.as_dvec3());
        let eye = low + (high - low) * DVec3::new(stream.unit(), stream.unit(), stream.unit());
        Ok(looking(of, eye, stream.sphere(), scene.truth.diagonal()))
    }

    /// A pose near another one: `step` is 1 for the longest way and the widest turn.
    pub(super) fn near(&self, from: &Candidate, step: f64, stream: &mut Stream) -> Result<Candidate, RunError> {
        let mut beside = |place: usize, of: usize| match stream.unit() < CHANGE_SHARE {
            true => (place + if stream.unit() < 0.5 { 1 } else { of - 1 }) % of,
            false => place,
        };
        let of = Candidate {
            time: beside(from.time, self.times.len()),
            scale: beside(from.scale, self.scales.len()),
            ..*from
        };
        let diagonal = self.truth(&of)?.truth.diagonal();
        let [eye, target] = [from.eye, from.target].map(|point| Vec3::from(point).as_dvec3());
        let way = stream.sphere() * (stream.unit() * step * MOVE_DIAGONALS * diagonal);
        let turned = (target - eye).normalize_or(DVec3::X) + stream.sphere() * (stream.unit() * step);
        Ok(looking(of, eye + way, turned.normalize_or(DVec3::X), diagonal))
    }

    /// The pose, if its eye is in the bounds and clear of surfaces.
    pub(super) fn admissible(&self, of: &Candidate) -> Result<Option<Pose>, RunError> {
        let scene = self.truth(of)?;
        let (geometry, eye) = (scene.truth.geometry(), Vec3::from(of.eye));
        let inside = eye.cmpge(geometry.bounds_min).all() && eye.cmple(geometry.bounds_max).all();
        let within = CLEARANCE_DIAGONALS * scene.truth.diagonal();
        let is_clear = inside && scene.truth.nearest(eye.as_dvec3(), within).is_none();
        Ok(of.pose("tried").ok().filter(|_| is_clear))
    }

    /// Whether enough rays start and hit, and few are ambiguous.
    pub(super) fn has_enough(&self, PreparedRays { set, answers, .. }: &PreparedRays) -> bool {
        let pixels = self.plan.preset.ray_image.map(f64::from);
        let share =
            |is: fn(&Answer) -> bool| answers.iter().filter(|answer| is(answer)).count() as f64 / answers.len() as f64;
        (set.saved().is_some() || answers.len() as f64 >= HIT_SHARE * pixels[0] * pixels[1])
            && share(|answer| answer.hit.is_some()) >= HIT_SHARE
            && (set.is_hostile() || share(Answer::is_ambiguous) <= AMBIGUOUS_SHARE)
    }
}

fn looking(of: Candidate, eye: DVec3, direction: DVec3, diagonal: f64) -> Candidate {
    let target = eye + direction * (TARGET_DIAGONALS * diagonal);
    Candidate { eye: eye.as_vec3().into(), target: target.as_vec3().into(), ..of }
}
