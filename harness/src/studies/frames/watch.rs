//! What is traced in every frame, judged and kept.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use tracebench_api::{Geometry, Hit, Query, Ray, Timing, TraceTo, TracerError, Viewpoint};
use tracebench_scenes::Material;

use super::images::{self, Answering, Reference, Rendered, Studio};
use super::points::Points;
use super::{FramesRequest, SceneMeasured};
use crate::judge::{Judge, Rule};
use crate::machine;
use crate::measure::controls::{Control, checked};
use crate::measure::session::{PreparedRays, RayRequest, Session, SessionError};
use crate::measure::{self, Context, FrameWork, MovingFrames, RunError, Traced, Turn, Updated, records};
use crate::plan::{Plan, TracerRequest};
use crate::rays::RaySet;
use crate::render::{Exposure, Image8, Stage, image_flicker, motion};
use crate::results::{
    AnswersRow, FrameRow, FrameSeries, InterleavedSetRecord, MovingScene, ROUNDED_ORACLE, Skipped, TracerRecord,
    WaveRow, WorkRow,
};
use crate::truth::{Answer, Truth};

/// Rays that all are judged by.
pub(super) struct Asked<'a> {
    pub truth: &'a Truth,
    /// Footprints are those of a camera there.
    pub eye: DVec3,
    pub name: &'a str,
    pub query: Query,
    pub rays: &'a [Ray],
    pub answers: &'a [Answer],
}

/// What the judge says of answers: of every ray under `footprint`, `None` of one that cannot be wrong; and how many are right by each rule.
pub(super) struct Verdicts {
    pub judged: u64,
    pub right: [u64; 3],
    pub rays: Vec<Option<bool>>,
}

impl<'a> Asked<'a> {
    fn judge(&self) -> Judge<'a> {
        Judge {
            truth: self.truth,
            eye: Some(self.eye),
            rays: self.rays,
            answers: self.answers,
            query: self.query,
            samplings: &[],
            voxels: None,
            names_primitives: false,
            wrong_rays_per_cause: 0,
        }
    }

    /// What a tracer's answers are. Answers that are none end the run: they must pass for nothing.
    pub(super) fn verdicts(&self, tracer: &str, hits: &[Hit]) -> Result<Verdicts, RunError> {
        let classes = |rule| -> Result<Vec<Option<bool>>, RunError> {
            let classes = self.judge().classes(rule, hits);
            let classes =
                classes.map_err(|error| SessionError::Judge(tracer.to_owned(), self.name.to_owned(), error))?;
            Ok(classes.into_iter().map(|class| class.map(|class| class.is_right())).collect())
        };
        let count = |rays: &[Option<bool>]| rays.iter().filter(|right| **right == Some(true)).count() as u64;
        let rays = classes(Rule::Footprint)?;
        let judged = rays.iter().flatten().count() as u64;
        let right = match self.query {
            Query::Any => [count(&rays); 3],
            Query::Closest => [count(&classes(Rule::HitMiss)?), count(&classes(Rule::Tight)?), count(&rays)],
        };
        Ok(Verdicts { judged, right, rays })
    }

    /// That all are answers.
    pub(super) fn are_answers(&self, tracer: &str, hits: &[Hit]) -> Result<(), RunError> {
        let checked = Judge::are_answers(self.rays.len(), hits);
        checked.map_err(|error| SessionError::Judge(tracer.to_owned(), self.name.to_owned(), error).into())
    }

    /// A control's answers, which must score what they must.
    fn control(&self, control: Control) -> Result<Vec<Hit>, RunError> {
        let hits = control.hits(self.rays, self.answers, self.truth.diagonal());
        let name = control.description().name.to_owned();
        let judged =
            self.judge().judge(&hits).map_err(|error| SessionError::Judge(name, self.name.to_owned(), error))?;
        checked(control, &judged, self.answers).map_err(RunError::Control)?;
        Ok(hits)
    }
}

/// The frame at hand.
struct Here {
    number: usize,
    session: Session,
    /// Places of the points that are seen, with their rays.
    points: (Vec<usize>, PreparedRays),
    /// By effect.
    references: Vec<Reference>,
    /// From the last frame; none at a cut.
    motion: Option<Vec<Option<u32>>>,
}

/// How the answers of one changed so far.
#[derive(Default)]
struct Told {
    /// By point, whether it was right in the last frame; `None` where it was not seen, or cannot be wrong.
    points: Option<Vec<Option<bool>>>,
    /// Of fixed rays, by set: in the last frame.
    rays: BTreeMap<String, Vec<Option<bool>>>,
    /// By set and ray, whether it was ever right, and ever wrong.
    ever: BTreeMap<String, Vec<[bool; 2]>>,
}

/// One whose frames are kept: a control, or a tracer.
#[derive(Default)]
struct Series {
    frames: Vec<FrameRow>,
    told: Told,
    /// Frame, work, wave and time of every trace.
    timings: Vec<(usize, String, usize, Timing)>,
    /// By frame.
    updates: Vec<Option<Timing>>,
    /// Works that it does not serve.
    unserved: Vec<String>,
    /// By effect the errors of the last frame, and the images with the pictures of their errors.
    errors: BTreeMap<String, Vec<[f32; 3]>>,
    images: BTreeMap<String, [Vec<Image8>; 2]>,
}

impl Series {
    /// What an effect came to in a frame, with the flicker since the last.
    fn rendered(&mut self, frame: usize, effect: &str, rendered: Rendered, motion: Option<&[Option<u32>]>) -> WorkRow {
        let Rendered { waves, image } = rendered;
        let mut rows = Vec::new();
        for (place, (wave, timing)) in waves.into_iter().enumerate() {
            rows.push(wave);
            self.timings.extend(timing.map(|timing| (frame, effect.to_owned(), place, timing)));
        }
        let image = image.map(|(mut row, image, error, errors)| {
            let before = self.errors.get(effect);
            row.flicker = before.zip(motion).and_then(|(before, motion)| image_flicker(before, &errors, motion));
            self.errors.insert(effect.to_owned(), errors);
            let kept = self.images.entry(effect.to_owned()).or_default();
            kept[0].push(image);
            kept[1].push(error);
            row
        });
        WorkRow { waves: rows, image }
    }
}

/// What is traced in every frame.
pub(super) struct Watch<'a> {
    plan: &'a Plan,
    request: &'a FramesRequest,
    context: &'a Context<'a>,
    scene: MovingScene,
    /// Those that can follow as it is asked.
    tracers: Vec<TracerRequest>,
    points: Points,
    /// The eye of the first frame, from which points and fixed rays are judged.
    first_eye: DVec3,
    here: Option<Here>,
    /// By effect; those of the first frame.
    exposures: Vec<Exposure>,
    /// The last frame's truth and viewpoint.
    before: Option<Session>,
    stage: Option<Arc<Stage>>,
    /// By effect the truth's images.
    truths: BTreeMap<String, Vec<Image8>>,
    /// None is the oracle with t in f32.
    controls: Vec<Option<Control>>,
    /// The rays of the first frame, where all frames have these.
    fixed: Vec<PreparedRays>,
    /// Controls first.
    series: Vec<Series>,
    pub(super) skipped: Vec<Skipped>,
}

/// Pairs that were judged both times, and those of them that turned.
fn turned(before: &[Option<bool>], now: &[Option<bool>]) -> [u64; 2] {
    let pairs = || before.iter().zip(now).filter_map(|(before, now)| Some((before.as_ref()?, now.as_ref()?)));
    [pairs().count() as u64, pairs().filter(|(before, now)| before != now).count() as u64]
}

impl<'a> Watch<'a> {
    pub(super) fn new(
        plan: &'a Plan,
        request: &'a FramesRequest,
        film: &MovingFrames,
        path: String,
        context: &'a Context<'a>,
    ) -> Result<Self, RunError> {
        let seen_at = |frame: usize| -> Result<(Truth, Viewpoint), RunError> {
            let mut scene = film.scene.clone();
            scene.set_time(film.times_s[frame])?;
            let geometry = Geometry::new(scene.mesh.positions, scene.mesh.triangles, None)?;
            let viewpoint = film.poses[frame].viewpoint(&geometry, plan.preset.ray_image, plan.preset.face);
            Ok((Truth::new(&geometry, &scene.sha256), viewpoint))
        };
        let ends = [seen_at(0)?, seen_at(film.times_s.len() - 1)?];
        let points = Points::new(&ends.each_ref().map(|(truth, viewpoint)| (truth, viewpoint)), plan.seed);
        let mut skipped = Vec::new();
        let mut tracers = Vec::new();
        let mut unserved: Vec<Vec<String>> = Vec::new();
        for tracer in &plan.tracers {
            let label = records::request_record(tracer).label();
            let skip = |rays: Option<&str>, reason| Skipped {
                tracer: Some(label.clone()),
                scene: film.scene.name.clone(),
                rays: rays.map(str::to_owned),
                reason,
            };
            if let Some(reason) = request.unserved(tracer, None) {
                skipped.push(skip(None, reason));
                continue;
            }
            tracers.push(tracer.clone());
            let mut own = Vec::new();
            for effect in &request.effects {
                if let Some(reason) = request.unserved(tracer, Some(*effect)) {
                    skipped.push(skip(Some(effect.name()), reason));
                    own.push(effect.name().to_owned());
                }
            }
            unserved.push(own);
        }
        let rounded = (!request.effects.is_empty()).then_some(None);
        let controls: Vec<Option<Control>> = Control::ALL.into_iter().map(Some).chain(rounded).collect();
        let of_controls = controls.iter().map(|_| Vec::new());
        let series = of_controls.chain(unserved).map(|unserved| Series { unserved, ..Series::default() }).collect();
        Ok(Self {
            plan,
            request,
            context,
            scene: MovingScene { path, points: points.len() as u64, ..MovingScene::default() },
            first_eye: film.poses[0].eye.as_dvec3(),
            points,
            here: None,
            fixed: Vec::new(),
            exposures: Vec::new(),
            before: None,
            stage: None,
            truths: BTreeMap::new(),
            controls,
            series,
            tracers,
            skipped,
        })
    }

    /// Those that follow.
    pub(super) fn followers(&self) -> Vec<TracerRequest> {
        self.tracers.clone()
    }

    /// Looks at a frame: its rays and its truth.
    fn look(&mut self, number: usize, film: &MovingFrames, geometry: &Geometry) -> Result<Here, RunError> {
        let (plan, context, scene) = (self.plan, self.context, &film.scene);
        let gpu = context.device.as_ref().ok().cloned();
        let pose = &film.poses[number];
        let truth = Truth::new(geometry, &scene.sha256);
        let viewpoint = pose.viewpoint(geometry, plan.preset.frame, plan.preset.face);
        if self.scene.viewpoints.is_empty() {
            self.scene.scene = records::scene_record(scene);
        }
        self.scene.scene_sha256.push(scene.sha256.clone());
        self.scene.viewpoints.push(records::viewpoint_of(
            &pose.name,
            &viewpoint,
            plan.preset.ray_image,
            film.times_s[number],
        ));
        let pixels = Viewpoint { frame: plan.preset.ray_image, ..viewpoint };
        let (places, rays) = self.points.rays(&truth, &pixels);
        let answers = truth.answer(&rays, Query::Closest, context.cache, context.progress);
        let answers = Arc::new(answers.map_err(SessionError::from)?);
        let points =
            (places, PreparedRays::new(RaySet::given("points", Query::Closest), (rays, answers), None, gpu.as_deref()));
        let mirrors: Vec<bool> = scene.mesh.materials.iter().map(Material::is_mirror).collect();
        let mirrors: Vec<bool> =
            scene.mesh.triangle_materials.iter().map(|material| mirrors[*material as usize]).collect();
        let is_rendered = !self.request.effects.is_empty();
        let has_own = !is_rendered && (number == 0 || !self.request.fixed_rays);
        let before = self.before.take();
        let moved = before.filter(|_| is_rendered && self.request.cut != Some(number as u32));
        let motion = moved.map(|before| {
            let before = (before.truth(), &Viewpoint { frame: plan.preset.ray_image, ..*before.viewpoint() });
            motion(before, (&truth, &pixels), plan.preset.ray_image)
        });
        let request = RayRequest {
            sets: if has_own { &plan.ray_sets } else { &[] },
            image: plan.preset.ray_image,
            seed: plan.seed,
            parameters: &plan.ray_parameters,
            path: scene.camera_path.as_ref(),
            mirrors: &mirrors,
        };
        let mut session = if has_own {
            Session::new(&scene.name, truth, viewpoint, request, gpu.clone(), context.cache, context.progress)?
        } else {
            Session::with(Arc::new(truth), viewpoint, gpu.clone(), Vec::new(), Vec::new())
        }
        .tracing_to(plan.trace_to);
        for skipped in session.skipped.drain(..) {
            let reason = format!("frame {number}: {}", skipped.reason);
            self.skipped.push(Skipped { reason, ..skipped });
        }
        if self.request.fixed_rays && number == 0 {
            self.fixed = std::mem::take(&mut session.rays);
        }
        let mut references = Vec::new();
        if is_rendered {
            let materials = &scene.mesh.materials;
            let stage = self.stage.get_or_insert_with(|| Arc::new(Stage::new(materials, geometry)));
            self.scene.notes = stage.notes().to_vec();
            let studio = studio(plan, self.request, stage, &session);
            for (place, effect) in self.request.effects.iter().enumerate() {
                let reference = studio.reference(*effect, self.exposures.get(place).copied(), context)?;
                if place == self.exposures.len() {
                    self.exposures.push(reference.exposure);
                }
                self.truths.entry(effect.name().to_owned()).or_default().push(reference.image.clone());
                references.push(reference);
            }
        }
        Ok(Here { number, session, points, references, motion })
    }

    fn is_fixed(&self) -> bool {
        self.request.fixed_rays
    }

    /// The eye by which the rays of a frame are judged.
    fn eye(&self, here: &Here) -> DVec3 {
        if self.is_fixed() { self.first_eye } else { here.session.viewpoint().eye.as_dvec3() }
    }
}

/// A frame as effects are rendered in it.
fn studio<'s>(plan: &'s Plan, request: &'s FramesRequest, stage: &Arc<Stage>, session: &'s Session) -> Studio<'s> {
    let (truth, viewpoint, gpu) = (session.truth(), session.viewpoint(), session.gpu());
    Studio { plan, request, stage: Arc::clone(stage), truth, viewpoint, gpu }
}

/// Rays with their truth, as all are judged by them.
fn asked<'r>(here: &'r Here, rays: &'r PreparedRays, eye: DVec3) -> Asked<'r> {
    Asked {
        truth: here.session.truth(),
        eye,
        name: rays.set.name,
        query: rays.set.query,
        rays: &rays.buffer.host,
        answers: &rays.answers,
    }
}

impl Told {
    /// What turned among points since the last frame.
    fn points(&mut self, all: usize, places: &[usize], verdicts: &Verdicts) -> Option<[u64; 2]> {
        let mut now = vec![None; all];
        for (place, right) in places.iter().zip(&verdicts.rays) {
            now[*place] = *right;
        }
        let found = self.points.as_ref().map(|before| turned(before, &now));
        self.points = Some(now);
        found
    }

    /// What turned among fixed rays.
    fn rays(&mut self, set: &str, verdicts: Verdicts) -> Option<[u64; 2]> {
        let ever = self.ever.entry(set.to_owned()).or_insert_with(|| vec![[false; 2]; verdicts.rays.len()]);
        for (ever, right) in ever.iter_mut().zip(&verdicts.rays) {
            if let Some(right) = right {
                ever[usize::from(*right)] = true;
            }
        }
        let before = self.rays.insert(set.to_owned(), verdicts.rays)?;
        Some(turned(&before, &self.rays[set]))
    }

    /// Fixed rays by set that were right in some frames and wrong in others.
    fn changing(&self) -> BTreeMap<String, u64> {
        let count = |ever: &Vec<[bool; 2]>| ever.iter().filter(|ever| **ever == [true; 2]).count() as u64;
        self.ever.iter().map(|(set, ever)| (set.clone(), count(ever))).collect()
    }
}

/// A row of what was done to a structure.
fn row_of(updated: &Updated) -> FrameRow {
    FrameRow {
        update: updated.update.to_owned(),
        stale_by: updated.stale_by.iter().map(|name| (*name).to_owned()).collect(),
        grown: updated.timing.as_ref().is_some_and(|timing| timing.grown),
        sah_cost: updated.sah_cost,
        structure_bytes: updated.structure_bytes,
        build_peak_bytes: updated.build_peak_bytes,
        ..FrameRow::default()
    }
}

impl FrameWork for Watch<'_> {
    fn begin(&mut self, frame: usize, film: &MovingFrames, geometry: &Geometry) -> Result<(), RunError> {
        if self.here.as_ref().is_none_or(|here| here.number != frame) {
            self.before = self.here.take().map(|here| here.session);
            self.here = Some(self.look(frame, film, geometry)?);
        }
        Ok(())
    }

    fn turn(&mut self, turn: Turn<'_>) -> Result<Result<(), TracerError>, RunError> {
        let Some(here) = self.here.take() else { return Ok(Ok(())) };
        let done = self.traced(&here, &turn);
        self.here = Some(here);
        done
    }

    fn end(&mut self, _frame: usize) -> Result<(), RunError> {
        let Some(here) = self.here.take() else { return Ok(()) };
        let done = self.controls(&here);
        self.here = Some(here);
        done
    }
}

impl Watch<'_> {
    /// Traces and judges all that is asked of a tracer in a frame.
    fn traced(&mut self, here: &Here, turn: &Turn<'_>) -> Result<Result<(), TracerError>, RunError> {
        let (eye, place) = (self.eye(here), self.controls.len() + turn.follower);
        let name = records::request_record(&self.tracers[turn.follower]).label();
        let gpu = here.session.gpu();
        let mut row = row_of(&turn.updated);
        let sets = if self.is_fixed() { &self.fixed } else { &here.session.rays };
        let series = &mut self.series[place];
        for rays in sets {
            if series.unserved.iter().any(|work| work == rays.set.name) {
                continue;
            }
            let traced = match measure::trace_once(turn.config, &rays.buffer, self.plan.trace_to, gpu) {
                Ok(traced) => traced,
                Err(TracerError::Unsupported(reason)) => {
                    series.unserved.push(rays.set.name.to_owned());
                    let (tracer, scene) = (Some(name.clone()), self.scene.scene.name.clone());
                    self.skipped.push(Skipped { tracer, scene, rays: Some(rays.set.name.to_owned()), reason });
                    continue;
                }
                Err(error) => return Ok(Err(error)),
            };
            if !turn.counts {
                continue;
            }
            let Traced { timing, hits, surfaces } = traced;
            let counters = match here.session.count(turn.config, rays, &hits, &surfaces) {
                Ok(counters) => counters.into_iter().map(|counter| (counter.name.to_owned(), counter.total)).collect(),
                Err(error) => return Ok(Err(error)),
            };
            let verdicts = asked(here, rays, eye).verdicts(&name, &hits)?;
            let mut wave = wave_of(rays, &hits, &verdicts);
            if let Some(answers) = &mut wave.answers {
                answers.counters = counters;
                answers.turned = if self.request.fixed_rays { series.told.rays(rays.set.name, verdicts) } else { None };
            }
            series.timings.push((turn.frame, rays.set.name.to_owned(), 0, timing));
            row.works.insert(rays.set.name.to_owned(), WorkRow { waves: vec![wave], image: None });
        }
        for (effect, reference) in self.request.effects.iter().zip(&here.references) {
            let Some(stage) = self.stage.as_ref().filter(|_| !series.unserved.iter().any(|work| work == effect.name()))
            else {
                continue;
            };
            let studio = studio(self.plan, self.request, stage, &here.session);
            match studio.rendered(reference, &Answering::Tracer(turn.config), &name, turn.counts)? {
                Ok(rendered) if turn.counts => {
                    let work = series.rendered(turn.frame, effect.name(), rendered, here.motion.as_deref());
                    row.works.insert(effect.name().to_owned(), work);
                }
                Ok(_) => {}
                Err(TracerError::Unsupported(reason)) => {
                    series.unserved.push(effect.name().to_owned());
                    let (tracer, scene) = (Some(name.clone()), self.scene.scene.name.clone());
                    self.skipped.push(Skipped { tracer, scene, rays: Some(effect.name().to_owned()), reason });
                }
                Err(error) => return Ok(Err(error)),
            }
        }
        if turn.counts {
            let (places, points) = &here.points;
            match measure::trace_once(turn.config, &points.buffer, TraceTo::Hit, gpu) {
                Ok(traced) => {
                    let verdicts = asked(here, points, self.first_eye).verdicts(&name, &traced.hits)?;
                    row.turned = series.told.points(self.points.len(), places, &verdicts);
                }
                // Methods that refuse these rays have no flicker of answers.
                Err(TracerError::Unsupported(_)) => {}
                Err(error) => return Ok(Err(error)),
            }
            series.frames.push(row);
            series.updates.push(turn.updated.timing.clone());
        }
        Ok(Ok(()))
    }

    /// The controls in a frame.
    fn controls(&mut self, here: &Here) -> Result<(), RunError> {
        let eye = self.eye(here);
        let sets = if self.is_fixed() { &self.fixed } else { &here.session.rays };
        for (control, series) in self.controls.iter().zip(&mut self.series) {
            let name = control.map_or(ROUNDED_ORACLE, |control| control.description().name);
            let mut row = FrameRow::default();
            for (effect, reference) in self.request.effects.iter().zip(&here.references) {
                let Some(stage) = &self.stage else { continue };
                let answering = control.map_or(Answering::Rounded, Answering::Control);
                let rendered = studio(self.plan, self.request, stage, &here.session)
                    .rendered(reference, &answering, name, true)?
                    .map_err(|error| RunError::Tracer(name.to_owned(), error))?;
                let work = series.rendered(here.number, effect.name(), rendered, here.motion.as_deref());
                if *control == Some(Control::Oracle) && !is_perfect(&work) {
                    return Err(RunError::Control(format!(
                        "the oracle's image of {} is not the truth's",
                        effect.name()
                    )));
                }
                row.works.insert(effect.name().to_owned(), work);
            }
            let Some(control) = *control else {
                series.frames.push(row);
                continue;
            };
            for rays in sets {
                let asked = asked(here, rays, eye);
                let hits = asked.control(control)?;
                let verdicts = asked.verdicts(name, &hits)?;
                let mut wave = wave_of(rays, &hits, &verdicts);
                if let Some(answers) = wave.answers.as_mut().filter(|_| self.request.fixed_rays) {
                    answers.turned = series.told.rays(rays.set.name, verdicts);
                }
                row.works.insert(rays.set.name.to_owned(), WorkRow { waves: vec![wave], image: None });
            }
            let (places, points) = &here.points;
            let asked = asked(here, points, self.first_eye);
            let verdicts = asked.verdicts(name, &asked.control(control)?)?;
            row.turned = series.told.points(self.points.len(), places, &verdicts);
            series.frames.push(row);
        }
        Ok(())
    }

    /// What was measured of the scene.
    pub(super) fn finish(mut self, interleaved_set: Option<InterleavedSetRecord>) -> Result<SceneMeasured, RunError> {
        let timings = |series: &Series| series.timings.iter().map(|(.., timing)| timing.clone()).collect::<Vec<_>>();
        let all: Vec<Vec<Timing>> = self.series.iter().map(timings).collect();
        let believed = records::are_believed(all.iter().map(Vec::as_slice));
        let mut rows = Vec::new();
        let rounded = || TracerRecord { name: ROUNDED_ORACLE.to_owned(), ..records::control_record(Control::Oracle) };
        let record = |control: Option<Control>| control.map_or_else(rounded, records::control_record);
        let controls: Vec<TracerRecord> = self.controls.iter().map(|control| record(*control)).collect();
        let tracers = controls.into_iter().chain(self.tracers.iter().map(records::request_record));
        for (tracer, mut series) in tracers.zip(self.series.drain(..)) {
            if series.frames.is_empty() {
                continue;
            }
            let (clock, samples_ms) = records::samples(series.timings.iter().map(|(.., timing)| timing), believed);
            for ((frame, work, wave, _), ms) in series.timings.iter().zip(samples_ms) {
                let row = series.frames.get_mut(*frame).and_then(|row| row.works.get_mut(work));
                if let Some(wave) = row.and_then(|row| row.waves.get_mut(*wave)) {
                    wave.trace_ms = Some(ms);
                }
            }
            for (row, update) in series.frames.iter_mut().zip(&series.updates) {
                row.update_ms = Some(update.as_ref().map_or(0.0, |timing| timing.total_ms));
            }
            let is_control = tracer.preset == "control";
            let mut pictures = BTreeMap::new();
            for (effect, [images, errors]) in series.images.iter().filter(|_| !is_control) {
                let kept = images::keep(images, errors, self.request.fps, self.context)?;
                pictures.extend(kept.map(|kept| (effect.clone(), kept)));
            }
            let sources = if is_control { machine::CONTROLS } else { tracer.name.as_str() };
            rows.push(FrameSeries {
                scene: 0,
                fingerprint: machine::fingerprint(sources).map(str::to_owned),
                tracer,
                machine: 0,
                interleaved_set: interleaved_set.as_ref().filter(|_| !is_control).map(|_| 0),
                clock,
                changing: series.told.changing(),
                frames: series.frames,
                pictures,
            });
        }
        for (effect, images) in &self.truths {
            let kept = images::keep(images, &[], self.request.fps, self.context)?;
            self.scene.pictures.extend(kept.map(|kept| (effect.clone(), kept)));
        }
        Ok(SceneMeasured { scene: self.scene, rows, skipped: self.skipped, interleaved_set })
    }
}

/// Whether an image and all answers are the truth's, and nothing flickers.
fn is_perfect(work: &WorkRow) -> bool {
    let answers = work.waves.iter().all(|wave| wave.right == [wave.judged; 3]);
    answers
        && work.image.as_ref().is_some_and(|image| image.mse == 0.0 && image.flicker.is_none_or(|change| change == 0.0))
}

/// A set as the only wave.
fn wave_of(rays: &PreparedRays, hits: &[Hit], verdicts: &Verdicts) -> WaveRow {
    WaveRow {
        name: rays.set.name.to_owned(),
        rays: hits.len() as u64,
        trace_ms: None,
        judged: verdicts.judged,
        right: verdicts.right,
        answers: Some(AnswersRow {
            rays_sha256: rays.sha256.clone(),
            hits_sha256: crate::hash::sha256_of(hits),
            counters: BTreeMap::new(),
            turned: None,
        }),
    }
}
