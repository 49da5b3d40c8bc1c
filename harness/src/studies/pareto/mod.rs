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
mod operating;
pub(super) mod pictures;
#[cfg(test)]
mod tests;
mod verdicts;

use clap::Args;
use itertools::Itertools as _;
use serde::Serialize;
use tracebench_api::Update;

pub use break_even::{BEYOND, BreakEven, Fit, FrameCost, Motion, Stretch, break_even, stretches};
pub use design::{Axis, axes, order, points};
pub use field::{Amount, By, Cost, Entry, Field, Standing, Wrong, bytes, fields, on_host};
pub use front::{CostAndError, FrontStatus};
pub use operating::{Aim, Check, LEVELS, best, check, chosen, farthest};
pub use verdicts::{Class, ClassCost, classes, contested};

use crate::measure::session::{PreparedRays, Session};
use crate::measure::{self, Context, MeasureOptions, Measured, Observations, RunError};
use crate::plan::{Plan, RunPreset, TracerRequest, ViewRequest, within};
use crate::rays::between_samples;
use crate::results::{
    FrontScene, HeldOutRecord, ParetoRecord, Record, Row, STILL_REFIT, SetPictures, Skipped, UpdateModeRecord,
};
use crate::studies::sweep::SweepError;

/// Points that a tracer is given where nothing is said.
pub const DEFAULT_POINTS: u32 = 8;

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
#[derive(Clone, Debug, PartialEq, Args, Serialize)]
pub struct Extent {
    /// The most points of a tracer, over its parameters and resolutions; fewer are the first of more.
    #[arg(long = "points", value_name = "N", default_value_t = DEFAULT_POINTS, allow_negative_numbers = true,
          value_parser = clap::value_parser!(u32).range(1..=256))]
    pub max_points: u32,
    /// Rays a pixel of which the time of a frame is told, with the build; several with commas.
    #[arg(long, value_name = "K,K", value_delimiter = ',', default_values_t = RAYS_PER_PIXEL,
          value_parser = within(0.001..=1e6, "a number of rays from 0.001 to 1000000"))]
    pub rays_per_pixel: Vec<f64>,
}

/// Fronts that are ready to be measured.
pub struct Pareto {
    plan: Plan,
    /// A configuration for every point, in their order.
    requests: Vec<TracerRequest>,
    section: ParetoRecord,
}

impl Pareto {
    /// Lays out the points of a plan's tracers.
    ///
    /// # Errors
    /// [`SweepError`] for a value that a parameter does not take.
    pub fn new(plan: &Plan, extent: &Extent) -> Result<Self, SweepError> {
        let (points, requests) = points(&plan.tracers, plan.preset, extent.max_points as usize)?;
        let Extent { max_points, rays_per_pixel } = extent.clone();
        let section = ParetoRecord { max_points, rays_per_pixel, points, scenes: Vec::new() };
        Ok(Self { plan: plan.clone(), requests, section })
    }

    /// The number of points.
    pub fn size(&self) -> usize {
        self.requests.len()
    }

    /// Measures every point in every scene; what could not be is skipped with the reason.
    ///
    /// # Errors
    /// As [`measure::execute_all`].
    pub fn execute(self, context: &Context<'_>) -> Result<Record, RunError> {
        let Self { plan, requests, section } = self;
        // What is wrong with the last scene is said before the first is measured.
        drop(measure::load(&plan, context.progress)?);
        context.check_rays(&plan)?;
        let record = measure::begin(std::slice::from_ref(&plan), context);
        let mut measuring = Measuring { requests, section, record, context };
        for (index, source) in plan.scenes.iter().enumerate() {
            if context.takes(index) {
                let plan = Plan { scenes: vec![source.clone()], ..plan.clone() };
                let scene = measuring.scene(PLACES * index, &plan)?;
                measuring.section.scenes.push(scene);
            }
        }
        let Measuring { section, mut record, .. } = measuring;
        record.skipped.extend(left_out(&section));
        record.pareto = Some(section);
        measure::filled(record, context)
    }
}

/// Fronts that are being measured.
struct Measuring<'a> {
    requests: Vec<TracerRequest>,
    section: ParetoRecord,
    record: Record,
    context: &'a Context<'a>,
}

impl Measuring<'_> {
    /// One scene, in all of its places from an index on.
    fn scene(&mut self, index: usize, plan: &Plan) -> Result<FrontScene, RunError> {
        let all: Vec<usize> = (0..self.requests.len()).collect();
        let found = self.measure(index, plan, &all, MeasureOptions::timed(plan))?;
        let mut told =
            FrontScene { scene: found.scene.clone(), viewpoint: found.viewpoint.clone(), ..Default::default() };
        let name = found.scene.name.clone();
        self.record.skipped.extend(blind(&found));
        self.add(&all, found, &name);
        // By what was measured so far, as its page will say.
        let chosen: Vec<usize> = chosen(&fields(&self.record.aligned(), &self.section, &told)).into_iter().collect();
        if chosen.is_empty() {
            return Ok(told);
        }
        self.context.progress.say(&format!("{} of {} points are chosen", chosen.len(), all.len()));
        let checking = elsewhere(plan);
        match self.measure(index + 1, &checking, &chosen, MeasureOptions::untimed()) {
            Ok(found) => {
                let held_out = HeldOutRecord { seed: checking.seed, viewpoint: found.viewpoint.clone() };
                self.add(&chosen, found, &format!("{name} from {}", held_out.viewpoint.name));
                told.held_out = Some(held_out);
            }
            Err(error @ RunError::NoOtherView(..)) => {
                let (scene, reason) = (name.clone(), error.to_string());
                self.record.skipped.push(Skipped { tracer: None, scene, rays: None, reason: reason.clone() });
                told.held_out_skipped = Some(reason);
            }
            Err(error) => return Err(error),
        }
        for (place, part) in SMALLER_IMAGES.into_iter().enumerate() {
            let ray_image = plan.preset.ray_image.map(|edge| (edge / part).max(1));
            let smaller = Plan { preset: RunPreset { ray_image, ..plan.preset }, ..plan.clone() };
            // Its builds are those of before.
            let options = MeasureOptions { builds_timed: false, validated: false, ..MeasureOptions::timed(&smaller) };
            let found = self.measure(index + 2 + place, &smaller, &chosen, options)?;
            let [width, height] = found.viewpoint.ray_image;
            self.add(&chosen, found, &format!("{name} with {width}×{height} pixels"));
            told.ray_images.push([width, height]);
        }
        let index = index + 2 + SMALLER_IMAGES.len();
        self.refits(index, plan, &chosen)?;
        told.pictures = self.pictures(index + 1, plan, &told)?;
        Ok(told)
    }

    /// Some points as they are asked for.
    fn requests(&self, points: &[usize]) -> Vec<TracerRequest> {
        points.iter().map(|point| self.requests[*point].clone()).collect()
    }

    /// Some points in a plan's only scene.
    fn measure(&self, index: usize, plan: &Plan, points: &[usize], how: MeasureOptions) -> Result<Measured, RunError> {
        measure::measure_plan(index, plan, &self.requests(points), how, None, self.context)
    }

    /// Refits of those points that can be refitted.
    fn refits(&mut self, index: usize, plan: &Plan, points: &[usize]) -> Result<(), RunError> {
        let can = |point: &usize| self.requests[*point].registration.describe().serves(Update::Refit).is_ok();
        let points: Vec<usize> = points.iter().copied().filter(can).collect();
        if points.is_empty() {
            return Ok(());
        }
        let plan = Plan { ray_sets: Vec::new(), ..plan.clone() };
        let options = MeasureOptions { refitted: true, ..MeasureOptions::timed(&plan) };
        let mut found = self.measure(index, &plan, &points, options)?;
        for row in found.rows.iter_mut().flatten() {
            row.update_mode = Some(UpdateModeRecord { name: STILL_REFIT.to_owned(), parameters: Default::default() });
        }
        let place = format!("{}, refits", found.scene.name);
        self.add(&points, found, &place);
        Ok(())
    }

    /// Pictures of what points on fronts answer, beside the record where there is a folder for it.
    fn pictures(&self, index: usize, plan: &Plan, scene: &FrontScene) -> Result<Vec<SetPictures>, RunError> {
        let context = self.context;
        let Some(results) = context.journal.results() else { return Ok(Vec::new()) };
        let costs = Cost::all(&self.section.rays_per_pixel);
        let points = pictures::shown(&fields(&self.record.aligned(), &self.section, scene), &costs);
        if points.is_empty() {
            return Ok(Vec::new());
        }
        context.progress.say(&format!("pictures of {} points on fronts", points.len()));
        let requests = self.requests(&points);
        let names: Vec<&str> = requests.iter().map(TracerRequest::name).collect();
        let hook = |session: &Session, rays: &PreparedRays, told: &[Option<Observations>]| {
            pictures::paint(session, plan.preset.ray_image, rays, told, (&points, &names), results)
        };
        let options = MeasureOptions { validated: false, counted: false, ..MeasureOptions::untimed() };
        measure::measure_plan(index, plan, &requests, options, Some(&hook), context)?.take_hooked()
    }

    /// Adds what was measured of some points, and notes those that could not be.
    fn add(&mut self, points: &[usize], found: Measured, place: &str) {
        for (request, refusal) in measure::add(&mut self.record, found) {
            self.section.points[points[request]].skipped.insert(place.to_owned(), refusal.reason);
        }
    }
}

/// A plan from another viewpoint, with rays of another seed and from other places in their pixels.
fn elsewhere(plan: &Plan) -> Plan {
    let ray_image = between_samples(plan.preset.ray_image, plan.preset.frame, CHECKED_PART);
    let preset = RunPreset { ray_image, ..plan.preset };
    let (seed, view) = (plan.seed.wrapping_add(FURTHER_SEED), ViewRequest::Other(Box::new(plan.view.clone())));
    Plan { preset, view, seed, ..plan.clone() }
}

/// Ray sets that hit nothing from their viewpoint: there is no front over them.
fn blind(found: &Measured) -> Vec<Skipped> {
    let traces = found.rows.iter().flatten().flat_map(|row| row.traces.iter().map(move |trace| (row, trace)));
    let blind = traces.filter(|(_, trace)| field::sees_nothing(trace)).map(|(row, trace)| {
        let reason = format!(
            "no ray of it hits anything from viewpoint {}: nothing can be told by it; choose another one by --view",
            found.viewpoint.name
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

/// The refit of a point in a scene, if it was measured.
pub fn refit<'a>(record: &'a Record, scene: &FrontScene, entry: &Entry<'_>) -> Option<&'a Row> {
    let is_refit = |row: &&Row| row.update_mode.as_ref().is_some_and(|update_mode| update_mode.name == STILL_REFIT);
    let here = |row: &&Row| entry.point.is_of(row) && field::is_at(row, scene, &scene.viewpoint);
    record.rows.iter().filter(is_refit).find(here)
}
