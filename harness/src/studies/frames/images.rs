//! Effects: images of a frame, wave by wave, beside the one that the truth gives by the same random numbers.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;
use tracebench_api::{Hit, RayBuffer, Surface, Timing};

use super::watch::Verdicts;
use super::{FramesRequest, PathsOf};
use crate::judge::Judge;
use crate::measure::controls::Control;
use crate::measure::session::{Session, SessionError, no_answers};
use crate::measure::{self, Context, RunError, Traced, TracerConfig};
use crate::plan::Plan;
use crate::render::{self, Effect, Exposure, Image8, Paths, Stage, Wave, animation, error_picture, likeness, strip};
use crate::results::{FramePictures, ImageRow, WaveRow};
use crate::studies::keep_picture;
use crate::truth::{Answer, Ray64, Truth};

/// On a tracer's own paths one of so many rays behind the first wave is judged: the truth of each is told anew.
const JUDGED_ONE_OF: u32 = 8;

/// Frames in a row of a sheet.
const SHEET_COLUMNS: usize = 8;

/// What is rendered from.
pub(super) struct Studio<'a> {
    pub plan: &'a Plan,
    pub request: &'a FramesRequest,
    pub context: &'a Context<'a>,
    pub stage: &'a Arc<Stage>,
    pub session: &'a Session,
}

/// A wave of the truth's.
pub(super) struct TrueWave {
    pub wave: Wave,
    pub buffer: RayBuffer,
    /// With ambiguity, where all are judged by it.
    answers: Vec<Answer>,
    /// The paths behind it, where others go on with these.
    after: Option<Paths>,
}

/// The truth's image.
pub(super) struct Reference {
    effect: Effect,
    pub exposure: Exposure,
    pub waves: Vec<TrueWave>,
    paths: Paths,
    pub image: Image8,
}

/// Who answers.
#[derive(Clone, Copy)]
pub(super) enum Answering<'a> {
    /// A tracer.
    Tracer(&'a TracerConfig),
    /// A control; the oracle by f64.
    Control(Control),
    /// The oracle with t in f32.
    Rounded,
}

/// What one rendered.
pub(super) struct Rendered {
    pub waves: Vec<(WaveRow, Option<Timing>)>,
    /// None where it only warmed up.
    pub image: Option<Beside>,
}

/// What an image is like beside the reference, itself, its error as a picture and by pixel.
type Beside = (ImageRow, Image8, Image8, Vec<[f32; 3]>);

/// A picture could not be made.
fn failed(error: render::ImageError) -> RunError {
    RunError::Picture(error.to_string())
}

/// Nearest hits, without ambiguity.
fn nearest(truth: &Truth, wave: &Wave) -> Vec<Answer> {
    let answer = |ray| Answer { hit: truth.closest(&Ray64::from(ray)), perturbed: None };
    wave.rays.par_iter().map(answer).collect()
}

impl Studio<'_> {
    fn paths(&self, effect: Effect) -> Paths {
        let (size, seed) = (self.plan.preset.ray_image, self.plan.seed);
        Paths::new(Arc::clone(self.stage), effect, &self.session.viewpoint, size, self.request.spp, seed)
    }

    /// The truth's image, exposed as that of the first frame was.
    pub(super) fn reference(&self, effect: Effect, exposure: Option<Exposure>) -> Result<Reference, RunError> {
        let (truth, follows) = (&*self.session.truth, self.request.paths == PathsOf::Truth);
        let (mut paths, mut waves) = (self.paths(effect), Vec::new());
        while let Some(wave) = paths.next_wave() {
            let answers = if wave.number == 0 || follows {
                let told = truth.answer(&wave.rays, wave.query, self.context.cache, self.context.progress);
                told.map_err(SessionError::from)?
            } else {
                nearest(truth, &wave)
            };
            paths.answer(&wave, &wave.answers_of_hits(truth, |ray| answers[ray].hit));
            let buffer = RayBuffer::new(Arc::clone(&wave.rays), wave.query, self.session.gpu());
            waves.push(TrueWave { wave, buffer, answers, after: follows.then(|| paths.clone()) });
        }
        let linear = paths.image();
        let exposure = exposure.unwrap_or_else(|| Exposure::of(effect, &linear));
        Ok(Reference { effect, exposure, waves, image: linear.developed(exposure), paths })
    }

    /// What one answers to an effect. [`RunError::Device`] is the tracer's.
    pub(super) fn rendered(
        &self,
        reference: &Reference,
        answering: &Answering<'_>,
        name: &str,
        counts: bool,
    ) -> Result<Rendered, RunError> {
        let (truth, gpu, effect) = (&*self.session.truth, self.session.gpu(), reference.effect);
        let follows = self.request.paths == PathsOf::Truth;
        let (mut paths, mut waves) = (self.paths(effect), Vec::new());
        while let Some(wave) = paths.next_wave() {
            let known = reference.waves.iter().find(|known| known.wave.number == wave.number);
            // The same rays as the truth's.
            let shared = known.filter(|_| wave.number == 0 || follows);
            let mut truths = shared.map(|known| Cow::Borrowed(&known.answers[..]));
            let (answers, hits, timing) = match answering {
                Answering::Tracer(config) => {
                    let own = || RayBuffer::new(Arc::clone(&wave.rays), wave.query, gpu);
                    let buffer = shared.map_or_else(own, |known| known.buffer.clone());
                    let Traced { timing, hits, surfaces } = measure::trace_sample(config, &buffer, wave.end, gpu, 1)?;
                    (shading(&wave, &hits, &surfaces, name)?, hits, Some(timing))
                }
                Answering::Control(_) | Answering::Rounded => {
                    let of = truths.get_or_insert_with(|| Cow::Owned(nearest(truth, &wave)));
                    let control = if let Answering::Control(control) = answering { *control } else { Control::Oracle };
                    let (hits, surfaces) = control.answered(truth.geometry(), &wave.rays, of);
                    let answers = match answering {
                        Answering::Control(Control::Oracle) => wave.answers_of_hits(truth, |ray| of[ray].hit),
                        _ => shading(&wave, &hits, &surfaces, name)?,
                    };
                    (answers, hits, None)
                }
            };
            if counts {
                let verdicts = self.verdicts(effect, &wave, &hits, truths.as_deref(), name)?;
                waves.push((verdicts.wave(Wave::name_of(wave.number), hits.len()), timing));
            }
            paths.answer(&wave, &answers);
            if let Some(leader) = shared.and_then(|known| known.after.as_ref()) {
                paths.follow(leader);
            }
        }
        let image = if counts { Some(self.beside(reference, &paths)?) } else { None };
        Ok(Rendered { waves, image })
    }

    /// What the judge says of a wave: of all rays by a truth that is known, else of one of so many.
    fn verdicts(
        &self,
        effect: Effect,
        wave: &Wave,
        hits: &[Hit],
        truths: Option<&[Answer]>,
        name: &str,
    ) -> Result<Verdicts, RunError> {
        let of = (name, effect.name());
        let judge = |rays, answers| Judge {
            truth: &self.session.truth,
            eye: Some(self.session.viewpoint.eye.as_dvec3()),
            rays,
            answers,
            query: wave.query,
            samplings: &[],
            voxels: None,
            names_primitives: false,
            wrong_rays_per_cause: 0,
        };
        if let Some(truths) = truths {
            return Verdicts::of(&judge(&wave.rays, truths), of, hits);
        }
        // What is no answer is none, judged or not.
        Judge::are_answers(wave.rays.len(), hits).map_err(|error| no_answers(name, effect.name(), error))?;
        let chosen: Vec<usize> = (0..hits.len()).filter(|ray| wave.paths[*ray].is_multiple_of(JUDGED_ONE_OF)).collect();
        let rays: Vec<_> = chosen.iter().map(|ray| wave.rays[*ray]).collect();
        let hits: Vec<_> = chosen.iter().map(|ray| hits[*ray]).collect();
        let answer = |ray| self.session.truth.answer_one(&Ray64::from(ray), wave.query);
        let answers: Vec<Answer> = rays.par_iter().map(answer).collect();
        Verdicts::of(&judge(&rays, &answers), of, &hits)
    }

    /// An image beside the reference.
    fn beside(&self, reference: &Reference, paths: &Paths) -> Result<Beside, RunError> {
        let (effect, truth) = (reference.effect, &reference.image);
        let image = paths.image().developed(reference.exposure);
        let mut row = likeness(effect, truth, &image).map_err(failed)?;
        if row.beyond > 0 {
            let first = reference.paths.first_difference(paths);
            let beyond = render::beyond(truth, &image).map_err(failed)?;
            for wave in first.iter().zip(beyond).filter(|(_, beyond)| *beyond).map(|(wave, _)| wave) {
                *row.beyond_by_wave.entry(wave.map_or_else(|| "none".to_owned(), Wave::name_of)).or_default() += 1;
            }
        }
        let errors = render::errors(truth, &image).map_err(failed)?;
        let error = error_picture(effect, truth, &image).map_err(failed)?;
        Ok((row, image, error, errors))
    }
}

/// A tracer's answers as they are shaded.
fn shading(wave: &Wave, hits: &[Hit], surfaces: &[Surface], name: &str) -> Result<Vec<render::Answer>, RunError> {
    let answers = wave.answers_of_tracer(hits, (!surfaces.is_empty()).then_some(surfaces));
    let why = || format!("{name} has not one answer for each ray of wave {}", Wave::name_of(wave.number));
    answers.ok_or_else(|| RunError::Picture(why()))
}

/// Writes the frames of an effect into the folder of results, if there is one: a sheet with the pictures of errors, and a moving one.
pub(super) fn keep(
    effect: &str,
    [images, errors]: [&[Image8]; 2],
    fps: f64,
    context: &Context<'_>,
) -> Result<BTreeMap<String, FramePictures>, RunError> {
    let Some(folder) = context.journal.results().filter(|_| !images.is_empty()) else { return Ok(BTreeMap::new()) };
    let mut rows = Vec::new();
    for start in (0..images.len()).step_by(SHEET_COLUMNS) {
        let part = |all: &[Image8]| all.iter().skip(start).take(SHEET_COLUMNS).cloned().collect::<Vec<_>>();
        rows.push(part(images));
        rows.extend((!errors.is_empty()).then(|| part(errors)));
    }
    let sheet = strip(&rows).and_then(|sheet| animation(&[sheet], 1.0)).map_err(failed)?;
    let moving = animation(images, fps).map_err(failed)?;
    let columns = images.len().min(SHEET_COLUMNS) as u32;
    let (sheet, animation) = (keep_picture(&sheet, folder)?, keep_picture(&moving, folder)?);
    Ok([(effect.to_owned(), FramePictures { sheet, columns, animation })].into())
}
