//! What is traced in every frame, judged and kept.

use std::collections::BTreeMap;
use std::sync::Arc;

use tracebench_api::{Geometry, Hit, Query, Timing, TraceTo, TracerError, Viewpoint};

use super::images::{self, Answering, Reference, Rendered, Studio};
use super::points::Points;
use super::{FramesRequest, SceneMeasured, is_exact_as_asked};
use crate::judge::{Judge, Rule};
use crate::machine;
use crate::measure::controls::{Control, checked};
use crate::measure::session::{PreparedRays, Session, SessionError, no_answers};
use crate::measure::{
    self, Context, DoubledWork, Followed, FrameWork, MovingFrames, RunError, Traced, TracerConfig, records,
};
use crate::plan::{Plan, TracerRequest};
use crate::rays::{RayParameters, RayScene, RaySet};
use crate::render::{Effect, Exposure, Image8, Stage, image_flicker, motion};
use crate::results::{
    AnswersRow, FrameRow, FrameSeries, ImageRow, InterleavedSetRecord, MovingScene, ROUNDED_ORACLE, Skipped,
    TracerRecord, WaveRow, WorkRow,
};
use crate::truth::Truth;

/// What the judge says of answers: of every ray under `footprint`, `None` of one that cannot be wrong; and how many are right by each rule.
pub(super) struct Verdicts {
    pub judged: u64,
    pub right: [u64; 3],
    pub rays: Vec<Option<bool>>,
}

impl Verdicts {
    /// Of a tracer's answers to rays of a name. Answers that are none end the run: they must pass for nothing.
    pub(super) fn of(judge: &Judge<'_>, (tracer, rays): (&str, &str), hits: &[Hit]) -> Result<Self, RunError> {
        let classes = |rule| -> Result<Vec<Option<bool>>, RunError> {
            let classes = judge.classes(rule, hits).map_err(|error| no_answers(tracer, rays, error))?;
            Ok(classes.into_iter().map(|class| class.map(|class| class.is_right())).collect())
        };
        let count = |rays: &[Option<bool>]| rays.iter().filter(|right| **right == Some(true)).count() as u64;
        let rays = classes(Rule::Footprint)?;
        let judged = rays.iter().flatten().count() as u64;
        let right = match judge.query {
            Query::Any => [count(&rays); 3],
            Query::Closest => [count(&classes(Rule::HitMiss)?), count(&classes(Rule::Tight)?), count(&rays)],
        };
        Ok(Self { judged, right, rays })
    }

    /// The row of so many rays, of which these are or of some of which.
    pub(super) fn wave(&self, name: String, rays: usize) -> WaveRow {
        let Self { judged, right, .. } = *self;
        WaveRow { name, rays: rays as u64, trace_ms: None, judged, right, answers: None }
    }
}

/// A control's answers, which must score what they must.
fn answers_of(control: Control, judge: &Judge<'_>, rays: &str) -> Result<Vec<Hit>, RunError> {
    let hits = control.hits(judge.rays, judge.answers, judge.truth.diagonal());
    let judged = judge.judge(&hits).map_err(|error| no_answers(control.description().name, rays, error))?;
    checked(control, &judged, judge.answers).map_err(RunError::Control)?;
    Ok(hits)
}

/// The frame at hand.
pub(super) struct Here {
    number: usize,
    session: Session,
    /// Places of the points that are seen, with their rays.
    points: (Vec<usize>, PreparedRays),
    /// Of the effect, if one is rendered.
    reference: Option<Reference>,
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
    /// Frame, work, wave and time of every trace, by the host's clock: a frame has updates in it, which no other clock takes.
    timings: Vec<(usize, String, usize, Timing)>,
    /// Works that it does not serve.
    unserved: Vec<String>,
    /// Of an effect the errors of the last frame, and the images with the pictures of their errors.
    errors: Option<Vec<[f32; 3]>>,
    images: [Vec<Image8>; 2],
}

impl Series {
    /// What one answered to a work; none if it does not serve it, which is noted.
    fn served<T>(
        &mut self,
        work: &str,
        answered: Result<T, RunError>,
        skip: &mut impl FnMut(&str, String),
    ) -> Result<Option<T>, RunError> {
        match answered {
            Err(RunError::Device(TracerError::Unsupported(reason))) => {
                self.unserved.push(work.to_owned());
                skip(work, reason);
                Ok(None)
            }
            answered => answered.map(Some),
        }
    }

    /// What an effect came to in a frame, with the flicker since the last.
    fn rendered(&mut self, frame: usize, effect: &str, rendered: Rendered, motion: Option<&[Option<u32>]>) -> WorkRow {
        let Rendered { waves, image } = rendered;
        let mut rows = Vec::new();
        for (place, (wave, timing)) in waves.into_iter().enumerate() {
            rows.push(wave);
            self.timings.extend(timing.map(|timing| (frame, effect.to_owned(), place, timing.by_submission())));
        }
        let image = image.map(|(mut row, image, error, errors)| {
            let before = self.errors.as_ref().zip(motion);
            row.flicker = before.and_then(|(before, motion)| image_flicker(before, &errors, motion));
            self.errors = Some(errors);
            self.images[0].push(image);
            self.images[1].push(error);
            row
        });
        WorkRow { waves: rows, image }
    }
}

/// What is traced in every frame: of an effect, if the request has one, else of ray sets.
pub(super) struct Watch<'a> {
    plan: &'a Plan,
    request: &'a FramesRequest,
    context: &'a Context<'a>,
    scene: MovingScene,
    /// The effect, or the first ray set: the first of it is what the control of the clock does twice.
    first: &'static str,
    /// Those that can follow as it is asked.
    pub(super) tracers: Vec<TracerRequest>,
    points: Points,
    /// That of the first frame.
    exposure: Option<Exposure>,
    stage: Option<Arc<Stage>>,
    /// The truth's images.
    truths: Vec<Image8>,
    controls: Vec<Answering<'static>>,
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
        for tracer in &plan.tracers {
            let cannot = |effect: Option<Effect>| Some((effect, request.unserved(tracer, effect)?));
            match cannot(None).or_else(|| cannot(Some(request.effect()?))) {
                None => tracers.push(tracer.clone()),
                Some((effect, reason)) => skipped.push(Skipped {
                    tracer: Some(records::request_record(tracer).label()),
                    scene: film.scene.name.clone(),
                    rays: effect.map(|effect| effect.name().to_owned()),
                    reason,
                }),
            }
        }
        let rounded = request.effect().map(|_| Answering::Rounded);
        let controls: Vec<Answering<'_>> = Control::ALL.into_iter().map(Answering::Control).chain(rounded).collect();
        let series = (0..controls.len() + tracers.len()).map(|_| Series::default()).collect();
        Ok(Self {
            plan,
            request,
            context,
            scene: MovingScene { path, points: points.len() as u64, ..MovingScene::default() },
            points,
            first: request.effect().map_or(plan.ray_sets.first().map_or("", |set| set.name), Effect::name),
            fixed: Vec::new(),
            exposure: None,
            stage: None,
            truths: Vec::new(),
            controls,
            series,
            tracers,
            skipped,
        })
    }
}

impl FrameWork for Watch<'_> {
    type Frame = Here;

    /// Its rays and its truth.
    fn look(
        &mut self,
        number: usize,
        film: &MovingFrames,
        geometry: &Geometry,
        before: Option<Here>,
    ) -> Result<Here, RunError> {
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
        // Points are judged from the first eye, whoever sees them now.
        let (set, first_eye) = (RaySet::given("points", Query::Closest), Some(film.poses[0].eye.as_dvec3()));
        let points = (places, PreparedRays::new(set, (rays, answers), first_eye, gpu.as_deref()));
        let is_rendered = self.request.effect().is_some();
        let has_own = !is_rendered && (number == 0 || !self.request.fixed_rays);
        let moved = before.filter(|_| is_rendered && self.request.cut != Some(number as u32));
        let motion = moved.map(|Here { session: before, .. }| {
            let before = (&*before.truth, &Viewpoint { frame: plan.preset.ray_image, ..before.viewpoint });
            motion(before, (&truth, &pixels), plan.preset.ray_image)
        });
        let truth = Arc::new(truth);
        let mut session = if has_own {
            let seen = RayScene {
                truth: &truth,
                viewpoint: &viewpoint,
                path: scene.camera_path.as_ref(),
                mirrors: &measure::mirrors(&scene.mesh),
                image: plan.preset.ray_image,
                seed: plan.seed,
                parameters: &RayParameters::try_from(&plan.ray_parameters).map_err(TracerError::from)?,
            };
            let (name, truth, gpu) = (&scene.name, Arc::clone(&truth), gpu.clone());
            Session::new(name, truth, &plan.ray_sets, &seen, gpu, context.cache, context.progress)?
        } else {
            Session::with(truth, viewpoint, gpu.clone(), Vec::new(), Vec::new())
        };
        (session.trace_to, session.wrong_rays_per_cause) = (plan.trace_to, 0);
        session.rays.iter_mut().for_each(|rays| rays.eye = Some(viewpoint.eye.as_dvec3()));
        for skipped in session.skipped.drain(..) {
            let reason = format!("frame {number}: {}", skipped.reason);
            self.skipped.push(Skipped { reason, ..skipped });
        }
        if self.request.fixed_rays && number == 0 {
            self.fixed = std::mem::take(&mut session.rays);
        }
        let mut reference = None;
        if let Some(effect) = self.request.effect() {
            let materials = &scene.mesh.materials;
            let stage = self.stage.get_or_insert_with(|| Arc::new(Stage::new(materials, geometry)));
            self.scene.notes = stage.notes.clone();
            let studio = Studio { plan, request: self.request, context, stage, session: &session };
            let found = studio.reference(effect, self.exposure)?;
            self.exposure = Some(found.exposure);
            self.truths.push(found.image.clone());
            reference = Some(found);
        }
        Ok(Here { number, session, points, reference, motion })
    }

    fn turn(&mut self, here: &Here, of: (usize, &TracerConfig, bool), row: FrameRow) -> Result<(), RunError> {
        let (place, config, counts) = of;
        let name = records::request_record(&self.tracers[place]).label();
        self.answered(here, (self.controls.len() + place, &name), &Answering::Tracer(config), row, counts)
    }

    fn twice(&mut self, here: &Here, config: &TracerConfig) -> Result<Timing, TracerError> {
        let waves = here.reference.iter().flat_map(|reference| &reference.waves);
        let sets = if self.request.fixed_rays { &self.fixed } else { &here.session.rays };
        let sets = sets.iter().filter(|rays| rays.set.name == self.first);
        let of_sets = sets.map(|rays| (&rays.buffer, self.plan.trace_to));
        let first = waves.map(|wave| (&wave.buffer, wave.wave.end)).chain(of_sets).next();
        let none = || TracerError::Unsupported(format!("frame {} has no {} rays", here.number, self.first));
        let (rays, end) = first.ok_or_else(none)?;
        measure::trace_sample(config, rays, end, here.session.gpu(), 2).map(|traced| traced.timing.by_submission())
    }

    /// The controls in a frame.
    fn end(&mut self, here: &Here) -> Result<(), RunError> {
        for (place, control) in self.controls.clone().into_iter().enumerate() {
            let name =
                if let Answering::Control(control) = control { control.description().name } else { ROUNDED_ORACLE };
            self.answered(here, (place, name), &control, FrameRow::default(), true)?;
        }
        Ok(())
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

/// The image of a frame.
fn image(row: &FrameRow) -> Option<&ImageRow> {
    row.works.values().next()?.image.as_ref()
}

impl Watch<'_> {
    /// Lets one answer all that is asked in a frame, judges it, and keeps it where it counts.
    fn answered(
        &mut self,
        here: &Here,
        (place, name): (usize, &str),
        answering: &Answering<'_>,
        mut row: FrameRow,
        counts: bool,
    ) -> Result<(), RunError> {
        let Self { plan, request, context, scene, points, stage, fixed, series, skipped, .. } = self;
        let (series, gpu) = (&mut series[place], here.session.gpu());
        let mut skip = |work: &str, reason: String| {
            let (tracer, scene) = (Some(name.to_owned()), scene.scene.name.clone());
            skipped.push(Skipped { tracer, scene, rays: Some(work.to_owned()), reason });
        };
        for rays in if request.fixed_rays { fixed.iter() } else { here.session.rays.iter() } {
            let (work, judge) = (rays.set.name, here.session.judge_of(rays, &[]));
            let (hits, counters) = match answering {
                Answering::Tracer(config) if !series.unserved.iter().any(|unserved| unserved == work) => {
                    let traced = measure::trace_sample(config, &rays.buffer, plan.trace_to, gpu, 1);
                    let traced = series.served(work, traced.map_err(RunError::from), &mut skip)?;
                    let Some(Traced { timing, hits, surfaces }) = traced.filter(|_| counts) else { continue };
                    let counters = here.session.count(config, rays, &hits, &surfaces)?;
                    series.timings.push((here.number, work.to_owned(), 0, timing.by_submission()));
                    (hits, counters.into_iter().map(|counter| (counter.name.to_owned(), counter.total)).collect())
                }
                Answering::Control(control) => (answers_of(*control, &judge, work)?, BTreeMap::new()),
                _ => continue,
            };
            let verdicts = Verdicts::of(&judge, (name, work), &hits)?;
            let mut wave = verdicts.wave(work.to_owned(), hits.len());
            let turned = if request.fixed_rays { series.told.rays(work, verdicts) } else { None };
            let (rays_sha256, hits_sha256) = (rays.sha256.clone(), crate::hash::sha256_of(&hits));
            wave.answers = Some(AnswersRow { rays_sha256, hits_sha256, counters, turned });
            row.works.insert(work.to_owned(), WorkRow { waves: vec![wave], image: None });
        }
        let rendered = here.reference.as_ref().zip(stage.as_ref()).filter(|_| series.unserved.is_empty());
        if let Some((effect, (reference, stage))) = request.effect().zip(rendered) {
            let work = effect.name();
            let studio = Studio { plan, request, context, stage, session: &here.session };
            let rendered = studio.rendered(reference, answering, name, counts);
            if let Some(rendered) = series.served(work, rendered, &mut skip)?.filter(|_| counts) {
                let rendered = series.rendered(here.number, work, rendered, here.motion.as_deref());
                // The oracle's image and all its answers are the truth's, and nothing flickers.
                let is_true = |image: &ImageRow| image.mse == 0.0 && image.flicker.is_none_or(|change| change == 0.0);
                let is_perfect = rendered.image.as_ref().is_some_and(is_true)
                    && rendered.waves.iter().all(|wave| wave.right == [wave.judged; 3]);
                if matches!(answering, Answering::Control(Control::Oracle)) && !is_perfect {
                    return Err(RunError::Control(format!("the oracle's image of {work} is not the truth's")));
                }
                row.works.insert(work.to_owned(), rendered);
            }
        }
        if !counts {
            return Ok(());
        }
        let (places, seen) = &here.points;
        let judge = here.session.judge_of(seen, &[]);
        let hits = match answering {
            Answering::Tracer(config) => match measure::trace_sample(config, &seen.buffer, TraceTo::Hit, gpu, 1) {
                // Methods that refuse these rays have no flicker of answers.
                Err(TracerError::Unsupported(_)) => None,
                traced => Some(traced?.hits),
            },
            Answering::Control(control) => Some(answers_of(*control, &judge, seen.set.name)?),
            Answering::Rounded => None,
        };
        if let Some(hits) = hits {
            let verdicts = Verdicts::of(&judge, (name, seen.set.name), &hits)?;
            row.turned = series.told.points(points.len(), places, &verdicts);
        }
        series.frames.push(row);
        Ok(())
    }

    /// What was measured of the scene. Where the control of a clock fails, no trace has a time.
    pub(super) fn finish(mut self, followed: Followed) -> Result<SceneMeasured, RunError> {
        let (first, size) = (self.first, self.plan.preset.ray_image);
        let doubled = |double: &DoubledWork| {
            let all = self.series[self.controls.len() + double.participant].timings.iter();
            let once = all.filter(|(_, work, wave, _)| work == first && *wave == 0);
            let once: Vec<Timing> = once.map(|(.., timing)| timing.clone()).collect();
            double.record(records::request_record(&self.tracers[double.participant]).label(), &once, true)
        };
        let doubled_work: Vec<_> = followed.doubles.iter().map(doubled).collect();
        let invalid = measure::invalid_reason(&doubled_work);
        let interleaved_set = followed.interleaved_set.map(|set| InterleavedSetRecord { doubled_work, ..set });
        let rounded = self.controls.iter().position(|control| matches!(control, Answering::Rounded));
        let floor: Vec<FrameRow> = rounded.map_or_else(Vec::new, |place| self.series[place].frames.clone());
        let mut rows = Vec::new();
        let record = |control: &Answering<'_>| match control {
            Answering::Control(control) => records::control_record(*control),
            _ => TracerRecord { name: ROUNDED_ORACLE.to_owned(), ..records::control_record(Control::Oracle) },
        };
        let controls: Vec<TracerRecord> = self.controls.iter().map(record).collect();
        let is_exact = std::iter::repeat_n(false, controls.len()).chain(self.tracers.iter().map(is_exact_as_asked));
        let tracers = controls.into_iter().chain(self.tracers.iter().map(records::request_record)).zip(is_exact);
        for ((tracer, is_exact), mut series) in tracers.zip(self.series.drain(..)) {
            if series.frames.is_empty() {
                continue;
            }
            let timings: Vec<Timing> = series.timings.iter().map(|(.., timing)| timing.clone()).collect();
            let samples_ms = records::times(&timings, true).samples_ms;
            for ((frame, work, wave, _), ms) in series.timings.iter().zip(samples_ms) {
                let row = series.frames.get_mut(*frame).and_then(|row| row.works.get_mut(work));
                if let Some(wave) = row.and_then(|row| row.waves.get_mut(*wave)) {
                    wave.trace_ms = Some(ms).filter(|_| invalid.is_none());
                }
            }
            let is_control = tracer.preset == "control";
            let pictures = series.images.each_ref().map(|all| if is_control { &all[..0] } else { &all[..] });
            let pictures = images::keep(first, pictures, self.request.fps, self.context)?;
            let kept_up = series.frames.iter().zip(&floor).filter(|(own, _)| is_exact && own.stale_by.is_empty());
            let near = kept_up.filter_map(|(own, floor)| Some(!image(own)?.is_beyond(image(floor)?, size)));
            let floor_holds = near.reduce(|all, near| all && near);
            let sources = if is_control { machine::CONTROLS } else { tracer.name.as_str() };
            rows.push(FrameSeries {
                scene: 0,
                fingerprint: machine::fingerprint(sources).map(str::to_owned),
                tracer,
                machine: 0,
                interleaved_set: interleaved_set.as_ref().filter(|_| !is_control).map(|_| 0),
                clock: timings.first().map(|timing| timing.clock),
                invalid: invalid.clone().filter(|_| !is_control),
                floor_holds,
                changing: series.told.changing(),
                frames: series.frames,
                pictures,
            });
        }
        self.scene.pictures = images::keep(first, [&self.truths, &[]], self.request.fps, self.context)?;
        Ok(SceneMeasured { scene: self.scene, rows, skipped: self.skipped, interleaved_set })
    }
}
