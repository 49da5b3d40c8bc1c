//! The paths of one image, a wave of rays after the other.

use std::collections::VecDeque;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use tracebench_api::{Query, Ray, TraceTo, Viewpoint};

use super::shading::{IN_PIXEL, Numbers, Step};
use super::{Answer, Effect, LinearImage, Stage, Wave};
use crate::rays::{image_view, ray_through};
use crate::truth::{Ray64, tight_tolerance};

/// One path, which begins in a pixel.
#[derive(Clone, Copy)]
struct Path {
    /// The share of the next ray's light that reaches the eye.
    share: Vec3,
    /// Light that reaches the eye if nothing stops the next shadow ray.
    direct: Vec3,
    /// What has reached the eye.
    light: Vec3,
}

/// The paths of one image. They go on from the answers that they are given: a tracer's own, or the truth's.
#[derive(Clone)]
pub struct Paths {
    stage: Arc<Stage>,
    effect: Effect,
    forward: DVec3,
    size: [u32; 2],
    /// Samples of a pixel: path `p` belongs to pixel `p / spp`, in scanline order.
    spp: u32,
    seed: u64,
    paths: Vec<Path>,
    pending: VecDeque<Wave>,
    /// By wave: each path with its ray's t, infinite for a miss and 0 for an any-hit ray that is stopped.
    outcomes: Vec<(usize, Arc<Vec<u32>>, Vec<f32>)>,
}

impl Paths {
    /// Most samples of a pixel.
    pub const MOST_SAMPLES: u32 = 1 << 16;

    /// Of every pixel `spp` paths, at least one. The first goes through the pixel's centre, as the ray set `primary` does, the others
    /// anywhere through the pixel. Random numbers depend on seed, pixel, sample, bounce and dimension alone.
    pub fn new(stage: Arc<Stage>, effect: Effect, viewpoint: &Viewpoint, size: [u32; 2], spp: u32, seed: u64) -> Self {
        let spp = spp.clamp(1, Self::MOST_SAMPLES);
        let view = image_view(viewpoint, size);
        let count = size[0] * size[1] * spp;
        let ray = |path: u32| {
            let (pixel, sample) = (path / spp, path % spp);
            let mut stream = Numbers { seed, pixel, sample, bounce: 0 }.stream(IN_PIXEL);
            let [x, y] = if sample == 0 { [0.5; 2] } else { [stream.unit(), stream.unit()] };
            ray_through(viewpoint, &view, [f64::from(pixel % size[0]) + x, f64::from(pixel / size[0]) + y])
        };
        let rays: Vec<Ray> = (0..count).into_par_iter().map(ray).collect();
        let eye = Wave {
            number: 0,
            rays: Arc::new(rays),
            paths: Arc::new((0..count).collect()),
            query: Query::Closest,
            end: effect.end(),
        };
        let path = Path { share: Vec3::ONE, direct: Vec3::ZERO, light: Vec3::ZERO };
        Self {
            stage,
            effect,
            forward: view.forward,
            size,
            spp,
            seed,
            paths: vec![path; count as usize],
            pending: VecDeque::from([eye]),
            outcomes: Vec::new(),
        }
    }

    /// The next wave; it is to be answered before the next is asked for. `None` at the end.
    pub fn next_wave(&mut self) -> Option<Wave> {
        self.pending.pop_front()
    }

    /// Shades the answers to a wave, one of each ray, and makes the rays that go on from them.
    pub fn answer(&mut self, wave: &Wave, answers: &[Answer]) {
        let t = |answer: &Answer| match answer {
            Answer::Miss => f32::INFINITY,
            Answer::Occluded => 0.0,
            Answer::Hit { t, .. } | Answer::Lost { t } => *t as f32,
        };
        self.outcomes.push((wave.number, Arc::clone(&wave.paths), answers.iter().map(t).collect()));
        if wave.query == Query::Any {
            for (path, answer) in wave.paths.iter().zip(answers) {
                let path = &mut self.paths[*path as usize];
                if *answer == Answer::Miss {
                    path.light += path.direct;
                }
                path.direct = Vec3::ZERO;
            }
            return;
        }
        let bounce = (wave.number / 2) as u32;
        let step = |((path, ray), answer): ((&u32, &Ray), &Answer)| {
            let numbers = Numbers { seed: self.seed, pixel: path / self.spp, sample: path % self.spp, bounce };
            self.stage.step(self.effect, &Ray64::from(ray), answer, self.forward, numbers)
        };
        let steps: Vec<Step> = (wave.paths.par_iter().zip(wave.rays.par_iter()).zip(answers)).map(step).collect();
        let (mut shadows, mut onwards) = ((Vec::new(), Vec::new()), (Vec::new(), Vec::new()));
        for (index, step) in wave.paths.iter().zip(steps) {
            let path = &mut self.paths[*index as usize];
            path.light += path.share * step.light;
            path.direct = Vec3::ZERO;
            if let Some((ray, light)) = step.shadow {
                path.direct = path.share * light;
                shadows.0.push(ray);
                shadows.1.push(*index);
            }
            let next = step.next.map(|(ray, share)| (ray, path.share * share));
            path.share = next.map_or(Vec3::ZERO, |(_, share)| share);
            // What is black stays black.
            if let Some((ray, _)) = next.filter(|(_, share)| *share != Vec3::ZERO) {
                onwards.0.push(ray);
                onwards.1.push(*index);
            }
        }
        let mut push = |number, (rays, paths): (Vec<Ray>, Vec<u32>), query, end| {
            if !rays.is_empty() {
                let (rays, paths) = (Arc::new(rays), Arc::new(paths));
                self.pending.push_back(Wave { number, rays, paths, query, end });
            }
        };
        push(wave.number + 1, shadows, Query::Any, TraceTo::Hit);
        push(wave.number + 2, onwards, Query::Closest, self.effect.end());
    }

    /// Goes on with another's rays, whose answers shade that one's paths, instead of its own: both have just answered the same wave.
    /// What only an own ray would have told stays dark.
    pub fn follow(&mut self, leader: &Self) {
        self.pending.clone_from(&leader.pending);
    }

    /// The linear image of what has been answered, the mean of the samples.
    pub fn image(&self) -> LinearImage {
        let pixel = |paths: &[Path]| {
            let sum: DVec3 = paths.iter().map(|path| path.light.as_dvec3()).sum();
            (sum / f64::from(self.spp)).as_vec3().into()
        };
        LinearImage { size: self.size, pixels: self.paths.par_chunks(self.spp as usize).map(pixel).collect() }
    }

    /// Of every pixel the number of the first wave that was answered differently: with a hit or none, at another t beyond the rule
    /// `tight`, or with a ray of only one of the two. `None` where none was.
    pub fn first_difference(&self, other: &Self) -> Vec<Option<usize>> {
        let tolerance = |t: f32| tight_tolerance(f64::from(t), self.stage.diagonal) as f32;
        let same = |one: f32, other: f32| one == other || (one - other).abs() <= tolerance(one.min(other));
        let mut first: Vec<Option<usize>> = vec![None; self.paths.len() / self.spp as usize];
        let last = self.outcomes.iter().chain(&other.outcomes).map(|(number, ..)| *number).max();
        for number in 0..=last.unwrap_or(0) {
            let outcomes = |paths: &Self| {
                let mut by_path = vec![f32::NAN; paths.paths.len()];
                let wave = paths.outcomes.iter().find(|(of, ..)| *of == number);
                for (path, t) in wave.iter().flat_map(|(_, paths, t)| paths.iter().zip(t)) {
                    by_path[*path as usize] = *t;
                }
                by_path
            };
            for (path, (one, other)) in outcomes(self).into_iter().zip(outcomes(other)).enumerate() {
                let both_none = one.is_nan() && other.is_nan();
                if !(same(one, other) || both_none) {
                    first[path / self.spp as usize].get_or_insert(number);
                }
            }
        }
        first
    }
}
