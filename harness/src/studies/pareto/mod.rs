//! Fronts of speed, bytes and build against error over every method's parameters: the same number of points for every tracer, all over
//! the same rays. What follows from the rows, fronts, operating points and break-even, is derived and not kept.
//!
//! In every scene all points are measured from its viewpoint. Points that are an operating point there are judged again, untimed,
//! from another viewpoint with rays of another seed and image; traced with fewer rays, for what a ray takes beside what a trace does; and
//! refitted.

mod break_even;
mod design;
mod field;
mod front;
mod noise;
mod operating;
pub(super) mod pictures;
#[cfg(test)]
mod tests;
mod verdicts;

use std::collections::BTreeSet;

use itertools::Itertools as _;
use serde_json::Value;
use tracebench_api::Update;
use tracebench_scenes::Scene;

pub use break_even::{BEYOND, BreakEven, Fit, FrameCost, Motion, Stretch, break_even, stretches};
pub use design::{Axis, Designed, axes, order, points};
pub use field::{Amount, By, Cost, Entry, Field, Wrong, bytes, fields, on_host};
pub use front::{CostAndError, FrontStatus, front, front_statuses};
pub use operating::{Aim, Check, LEVELS, best, check, chosen, farthest};
pub use verdicts::{Class, ClassCost, SceneFronts, classes, contested, scene_fronts};

use crate::measure::session::{PreparedRays, Session};
use crate::measure::{self, AnimationFrames, Context, MeasureOptions, Measured, Observations, Request, RunError};
use crate::plan::{Plan, RunPreset, ViewRequest};
use crate::rays::between_samples;
use crate::results::{
    FrontScene, HeldOutRecord, ParetoRecord, Record, Row, STILL_REFIT, SetPictures, Skipped, UpdateModeRecord,
    ViewpointRecord,
};
use crate::studies::sweep::SweepError;

/// Points that a tracer is given where nothing is said.
pub const DEFAULT_POINTS: usize = 8;

/// The most points that a tracer may be given.
pub const MAX_POINTS: usize = 256;

/// Rays a pixel of which the time of a frame is told where nothing is said.
pub const RAYS_PER_PIXEL: [f64; 2] = [1.0, 16.0];

/// Parts of the edges of the ray image at which chosen points are traced besides: a quarter and a sixteenth of the rays.
const SMALLER_IMAGES: [u32; 2] = [2, 4];

/// The part of the edges of the ray image at which chosen points are checked: other places in their pixels.
const CHECKED_PART: [u32; 2] = [7, 8];

/// By how much the seed of rays differs by which chosen points are checked: seeds that differ in their lowest bit alone draw the same
/// numbers.
pub(crate) const FURTHER_SEED: u64 = 2;

/// Places that a scene may have: all points, the check, the smaller ray images, refits, pictures.
const PLACES: usize = 4 + SMALLER_IMAGES.len();

/// How much of a front there is to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// The most points of a tracer.
    pub max_points: usize,
    /// Rays a pixel of which the time of a frame is told.
    pub rays_per_pixel: Vec<f64>,
}

impl Default for Extent {
    fn default() -> Self {
        Self { max_points: DEFAULT_POINTS, rays_per_pixel: RAYS_PER_PIXEL.to_vec() }
    }
}

/// Fronts that are ready to be measured.
pub struct Pareto {
    plan: Plan,
    points: Vec<Designed>,
    section: ParetoRecord,
}

impl Pareto {
    /// Lays out the points of a plan's tracers.
    ///
    /// # Errors
    /// [`SweepError`] for a value that a parameter does not take.
    pub fn new(plan: &Plan, extent: &Extent) -> Result<Self, SweepError> {
        let points = points(&plan.tracers, plan.preset, extent.max_points)?;
        let section = ParetoRecord {
            max_points: extent.max_points as u32,
            rays_per_pixel: extent.rays_per_pixel.clone(),
            points: points.iter().map(|each| each.point.clone()).collect(),
            scenes: Vec::new(),
        };
        Ok(Self { plan: plan.clone(), points, section })
    }

    /// The number of points.
    pub fn size(&self) -> usize {
        self.points.len()
    }

    /// Measures every point in every scene; what could not be is skipped with the reason.
    ///
    /// # Errors
    /// As [`measure::execute`].
    pub fn execute(mut self, required: bool, context: &Context<'_>) -> Result<Record, RunError> {
        // What is wrong with the last scene is said before the first is measured.
        drop(measure::load(&self.plan, context.progress)?);
        context.check_rays(&self.plan, required)?;
        let mut record = measure::begin(std::slice::from_ref(&self.plan), context);
        for (index, source) in self.plan.scenes.clone().into_iter().enumerate() {
            if context.takes(index) {
                let plan = Plan { scenes: vec![source], ..self.plan.clone() };
                self.scene(PLACES * index, &plan, &mut record, context)?;
            }
        }
        record.skipped.extend(left_out(&self.section));
        if record.rows.is_empty() && context.shard.is_none() {
            return Err(measure::nothing(&record));
        }
        record.pareto = Some(self.section);
        Ok(record)
    }

    /// One scene, in all of its places from an index on.
    fn scene(&mut self, index: usize, plan: &Plan, record: &mut Record, context: &Context<'_>) -> Result<(), RunError> {
        let all: Vec<usize> = (0..self.points.len()).collect();
        let Some(found) = self.place(index, plan, &all, MeasureOptions::timed(plan), context)? else { return Ok(()) };
        let (scene, viewpoint) = (found.scene.clone(), found.viewpoint.clone());
        record.skipped.extend(blind(&found, &viewpoint));
        self.add(record, &all, found, &scene.name);
        self.section.scenes.push(FrontScene { scene, viewpoint, ..FrontScene::default() });
        let chosen: Vec<usize> = self.chosen(record).into_iter().collect();
        if chosen.is_empty() {
            return Ok(());
        }
        context.progress.say(&format!("{} of {} points are chosen", chosen.len(), self.points.len()));
        let name = self.told(|scene| scene.scene.name.clone());
        match self.elsewhere(index + 1, plan, &chosen, context) {
            Ok(Some((found, held_out))) => {
                self.add(record, &chosen, found, &format!("{name} from {}", held_out.viewpoint.name));
                self.tell(|scene| scene.held_out = Some(held_out));
            }
            Ok(None) => {}
            Err(error @ RunError::NoOtherView(..)) => {
                let reason = error.to_string();
                record.skipped.push(Skipped { tracer: None, scene: name.clone(), rays: None, reason: reason.clone() });
                self.tell(|scene| scene.held_out_skipped = Some(reason));
            }
            Err(error) => return Err(error),
        }
        for (place, part) in SMALLER_IMAGES.into_iter().enumerate() {
            let ray_image = plan.preset.ray_image.map(|edge| (edge / part).max(1));
            let smaller = Plan { preset: RunPreset { ray_image, ..plan.preset }, ..plan.clone() };
            // Its builds are those of before.
            let options = MeasureOptions { builds_timed: false, validated: false, ..MeasureOptions::timed(&smaller) };
            let Some(found) = self.place(index + 2 + place, &smaller, &chosen, options, context)? else { continue };
            let ray_image = found.viewpoint.ray_image;
            self.add(record, &chosen, found, &format!("{name} with {}×{} pixels", ray_image[0], ray_image[1]));
            self.tell(|scene| scene.ray_images.push(ray_image));
        }
        self.refits(index + 2 + SMALLER_IMAGES.len(), plan, &chosen, record, context)?;
        self.pictures(index + 3 + SMALLER_IMAGES.len(), plan, record, context)
    }

    /// The scene that is measured.
    fn told<T>(&self, of: impl FnOnce(&FrontScene) -> T) -> T
    where
        T: Default,
    {
        self.section.scenes.last().map(of).unwrap_or_default()
    }

    fn tell(&mut self, what: impl FnOnce(&mut FrontScene)) {
        if let Some(scene) = self.section.scenes.last_mut() {
            what(scene);
        }
    }

    /// Points that are chosen by what was measured in the last scene, as its page will say.
    fn chosen(&self, record: &Record) -> BTreeSet<usize> {
        let Some(scene) = self.section.scenes.last() else { return BTreeSet::new() };
        let aligned = record.aligned();
        chosen(&fields(&aligned, &self.section, scene, &scene.viewpoint))
    }

    /// Some points in a plan's only scene.
    fn place(
        &self,
        index: usize,
        plan: &Plan,
        points: &[usize],
        options: MeasureOptions,
        context: &Context<'_>,
    ) -> Result<Option<Measured>, RunError> {
        let Some(scene) = measure::load(plan, context.progress)?.pop() else { return Ok(None) };
        let requests: Vec<Request> = points.iter().map(|point| Request::of(&self.points[*point].request)).collect();
        measure::measure_scene(index, plan, (scene, None), &requests, options, None, context).map(Some)
    }

    /// Some points from another viewpoint, with rays of another seed and from other places in their pixels; nothing is timed there.
    fn elsewhere(
        &self,
        index: usize,
        plan: &Plan,
        points: &[usize],
        context: &Context<'_>,
    ) -> Result<Option<(Measured, HeldOutRecord)>, RunError> {
        let seed = plan.seed.wrapping_add(FURTHER_SEED);
        let ray_image = between_samples(plan.preset.ray_image, plan.preset.frame, CHECKED_PART);
        let preset = RunPreset { ray_image, ..plan.preset };
        let plan = Plan { preset, view: ViewRequest::Other(Box::new(plan.view.clone())), seed, ..plan.clone() };
        let Some(found) = self.place(index, &plan, points, MeasureOptions::untimed(), context)? else {
            return Ok(None);
        };
        let viewpoint: ViewpointRecord = found.viewpoint.clone();
        Ok(Some((found, HeldOutRecord { seed, viewpoint })))
    }

    /// Refits of those points that can be refitted, to vertices that stand still: what a refit does is the same however far they moved.
    fn refits(
        &mut self,
        index: usize,
        plan: &Plan,
        points: &[usize],
        record: &mut Record,
        context: &Context<'_>,
    ) -> Result<(), RunError> {
        let can = |point: &usize| {
            let registration = self.points[*point].request.registration;
            registration.describe().serves(Update::Refit).is_ok()
        };
        let points: Vec<usize> = points.iter().copied().filter(can).collect();
        if points.is_empty() {
            return Ok(());
        }
        let plan = Plan { ray_sets: Vec::new(), ..plan.clone() };
        let Some(scene) = measure::load(&plan, context.progress)?.pop() else { return Ok(()) };
        let refit =
            |point: &usize| Request { follows: Some(Update::Refit), ..Request::of(&self.points[*point].request) };
        let requests: Vec<Request> = points.iter().map(refit).collect();
        let (name, film) = (scene.name.clone(), still(&scene, plan.preset.sampling.min_rounds));
        let (frame, options) = ((scene, Some(film)), MeasureOptions::timed(&plan));
        let mut found = measure::measure_scene(index, &plan, frame, &requests, options, None, context)?;
        for row in found.rows.iter_mut().flatten() {
            row.update_mode = Some(UpdateModeRecord { name: STILL_REFIT.to_owned(), parameters: Default::default() });
        }
        self.add(record, &points, found, &format!("{name}, refits"));
        Ok(())
    }

    /// Pictures of what points on fronts answer, beside the record where there is a folder for it.
    fn pictures(&mut self, index: usize, plan: &Plan, record: &Record, context: &Context<'_>) -> Result<(), RunError> {
        let (Some(results), Some(scene)) = (context.journal.results(), self.section.scenes.last()) else {
            return Ok(());
        };
        let costs = Cost::all(&self.section.rays_per_pixel);
        let points = pictures::shown(&fields(&record.aligned(), &self.section, scene, &scene.viewpoint), &costs);
        let Some(scene) = measure::load(plan, context.progress)?.pop().filter(|_| !points.is_empty()) else {
            return Ok(());
        };
        context.progress.say(&format!("pictures of {} points on fronts", points.len()));
        let names: Vec<String> = points.iter().map(|point| self.points[*point].request.name().to_owned()).collect();
        let requests: Vec<Request> = points.iter().map(|point| Request::of(&self.points[*point].request)).collect();
        let hook = |session: &Session, rays: &PreparedRays, told: &[Option<Observations>]| {
            pictures::paint(session, plan.preset.ray_image, rays, told, (&points, &names), results)
        };
        let options = MeasureOptions { validated: false, counted: false, ..MeasureOptions::untimed() };
        let found = measure::measure_scene(index, plan, (scene, None), &requests, options, Some(&hook), context)?;
        let told = |value: Value| serde_json::from_value(value).map_err(|error| RunError::Picture(error.to_string()));
        let painted = found.hooked.into_iter().map(told).collect::<Result<Vec<SetPictures>, _>>()?;
        self.tell(|scene| scene.pictures = painted);
        Ok(())
    }

    /// Adds what was measured of some points, and notes those that could not be.
    fn add(&mut self, record: &mut Record, points: &[usize], found: Measured, place: &str) {
        for (request, (_, refusal)) in measure::add(record, found) {
            self.section.points[points[request]].skipped.insert(place.to_owned(), refusal.reason);
        }
    }
}

/// Ray sets that hit nothing from a viewpoint: there is no front over them.
fn blind(found: &Measured, viewpoint: &ViewpointRecord) -> Vec<Skipped> {
    let traces = found.rows.iter().flatten().flat_map(|row| row.traces.iter().map(move |trace| (row, trace)));
    let blind = traces.filter(|(_, trace)| field::sees_nothing(trace)).map(|(row, trace)| {
        let reason = format!(
            "no ray of it hits anything from viewpoint {}: nothing can be told by it; choose another one by --view",
            viewpoint.name
        );
        Skipped { tracer: None, scene: row.scene.name.clone(), rays: Some(trace.rays.clone()), reason }
    });
    blind.unique().collect()
}

/// Points that could not be measured, by place and reason; all of a tracer's as one.
fn left_out(section: &ParetoRecord) -> Vec<Skipped> {
    let all = section.points.iter().flat_map(|point| point.skipped.iter().map(move |skipped| (point, skipped)));
    let found = all.map(|(point, (scene, reason))| {
        let mut own = section.points.iter().filter(|other| other.tracer == point.tracer);
        let is_alike = own.all(|other| other.skipped.get(scene) == Some(reason));
        let tracer = Some(if is_alike { point.tracer.clone() } else { point.label() });
        Skipped { tracer, scene: scene.clone(), rays: None, reason: reason.clone() }
    });
    found.unique().collect()
}

/// Frames over which nothing moves, with a counted refit in each pass.
fn still(scene: &Scene, passes: u32) -> AnimationFrames {
    let positions = vec![scene.mesh.positions.clone(); 2];
    AnimationFrames::new(scene, positions, passes)
}

/// The refit of a point in a scene, if it was measured.
pub fn refit<'a>(record: &'a Record, scene: &FrontScene, entry: &Entry<'_>) -> Option<&'a Row> {
    let is_refit = |row: &&Row| row.update_mode.as_ref().is_some_and(|update_mode| update_mode.name == STILL_REFIT);
    let here = |row: &&Row| entry.point.is_of(row) && field::is_at(row, scene, &scene.viewpoint);
    record.rows.iter().filter(is_refit).find(here)
}
