//! Wrong rays made small: few rays and few triangles, in the bounds of the whole scene, with truth computed anew, that are wrong for the same
//! cause.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use tracebench_api::{Geometry, Ray};
use tracebench_scenes::Mesh;

use super::search::answers;
use crate::judge::Rule;
use crate::measure::session::{PreparedRays, Session};
use crate::measure::{Observations, RunError, TracerConfig};
use crate::progress::Progress;
use crate::rays::RaySet;
use crate::truth::{Answer, Ray64, Truth};

/// Scenes and rays that are tried, at most.
const MAX_TESTS: u64 = 3000;

/// Triangles that keep the bounds: one in the least corner, one in the greatest.
pub(super) const MARKERS: u64 = 2;
/// Their edges, in scene diagonals; longer where coordinates cannot tell that.
const MARKER_DIAGONALS: f64 = 1e-6;

/// What is left.
pub(super) struct Shrunk {
    pub mesh: Mesh,
    pub rays: Vec<Ray>,
    pub answers: Vec<Answer>,
    pub cause: String,
}

/// A wrong set that is made small.
pub(super) struct Shrinker<'a> {
    pub session: &'a Session,
    pub set: RaySet,
    pub rule: Rule,
    pub config: TracerConfig,
    pub mesh: &'a Mesh,
    pub progress: &'a Progress,
}

impl Shrinker<'_> {
    /// Makes the rays small that are wrong for the most frequent cause; `None` where nothing is wrong, or not by itself.
    pub(super) fn shrink(mut self, rays: &PreparedRays, told: &Observations) -> Result<Option<Shrunk>, RunError> {
        let wrong = self.wrong(self.session, rays, told)?;
        let causes = self.session.causes(self.config.description.name, rays, self.cause_rule(), told, &wrong)?;
        let Some((cause, _)) = causes.into_iter().rev().max_by_key(|(_, rays)| *rays) else { return Ok(None) };
        let bar = self.progress.bar("make small", MAX_TESTS);
        let whole = Arc::new(Truth::new(self.session.geometry(), "whole").lightly_audited());
        if self.session.sample_build(&mut self.config).is_err() {
            return Ok(None);
        }
        let wrong: Vec<Ray> = wrong.into_iter().map(|ray| rays.buffer.host[ray]).collect();
        if !self.fails(&whole, &wrong, &cause)? {
            return Ok(None);
        }
        let mut tests = 0;
        let mut test = |test: &mut dyn FnMut() -> Result<bool, RunError>| {
            tests += 1;
            bar.inc(1);
            if tests > MAX_TESTS { Ok(false) } else { test() }
        };
        let kept = minimal(wrong, |rays| test(&mut || self.fails(&whole, rays, &cause)))?;
        let all: Vec<u32> = (0..self.mesh.triangles.len() as u32).collect();
        let triangles = minimal(all, |triangles| test(&mut || self.fails_in(triangles, &kept, &cause)))?;
        // What was the scene as it is may not be wrong with markers in it.
        if !self.fails_in(&triangles, &kept, &cause)? {
            return Ok(None);
        }
        let mesh = self.cut(&triangles);
        let truth = Truth::new(&Geometry::new(mesh.positions.clone(), mesh.triangles.clone(), None)?, "part");
        let answers = kept.iter().map(|ray| truth.answer_one(&Ray64::from(ray), self.set.query)).collect();
        Ok(Some(Shrunk { mesh, rays: kept, answers, cause }))
    }

    /// The rule under which the judge tells causes.
    fn cause_rule(&self) -> Rule {
        if self.rule == Rule::HitMiss { Rule::Tight } else { self.rule }
    }

    fn wrong(&self, session: &Session, rays: &PreparedRays, told: &Observations) -> Result<Vec<usize>, RunError> {
        let classes = session.classes(self.config.description.name, rays, self.rule, &told.hits)?;
        let is_wrong = |index: &usize| classes[*index].is_some_and(|class| !class.is_right());
        Ok((0..classes.len()).filter(is_wrong).collect())
    }

    /// Whether any of some rays is wrong for a cause in the scene that the tracer has built last.
    fn fails(&self, truth: &Arc<Truth>, rays: &[Ray], cause: &str) -> Result<bool, RunError> {
        let set = RaySet::given(self.set.name, self.set.query);
        let Session { viewpoint, gpu, .. } = self.session;
        let session = Session::of_rays(Arc::clone(truth), *viewpoint, set, rays.to_vec(), gpu.clone())?;
        let rays = &session.rays[0];
        // A tracer that refuses a part of the scene is not wrong in it.
        let (Ok(hits), Ok(sampling_model)) =
            (answers(&session, &self.config, rays), session.sampling_model(&self.config))
        else {
            return Ok(false);
        };
        let told = Observations { hits, sampling_model };
        let Ok(wrong) = self.wrong(&session, rays, &told) else { return Ok(false) };
        Ok(session.causes(self.config.description.name, rays, self.cause_rule(), &told, &wrong)?.contains_key(cause))
    }

    /// The same in a scene of some triangles.
    fn fails_in(&mut self, triangles: &[u32], rays: &[Ray], cause: &str) -> Result<bool, RunError> {
        let Mesh { positions, triangles, triangle_materials, .. } = self.cut(triangles);
        let Session { viewpoint, gpu, .. } = self.session;
        let geometry = Geometry::with_materials(positions, triangles, triangle_materials, gpu.as_deref())?;
        if self.config.build(&geometry, viewpoint, gpu.as_deref()).is_err() {
            return Ok(false);
        }
        self.fails(&Arc::new(Truth::new(&geometry, "part").lightly_audited()), rays, cause)
    }

    /// Some triangles, with markers behind them that keep the bounds.
    fn cut(&self, kept: &[u32]) -> Mesh {
        let Mesh { positions, triangles, triangle_materials, materials, triangle_objects, objects } = self.mesh;
        let mut places = BTreeMap::new();
        let mut cut = Mesh {
            positions: Vec::new(),
            triangles: Vec::new(),
            triangle_materials: kept.iter().map(|triangle| triangle_materials[*triangle as usize]).collect(),
            materials: materials.clone(),
            triangle_objects: kept.iter().map(|triangle| triangle_objects[*triangle as usize]).collect(),
            objects: objects.clone(),
        };
        for triangle in kept {
            let place = |vertex: u32| {
                *places.entry(vertex).or_insert_with(|| {
                    cut.positions.push(positions[vertex as usize]);
                    cut.positions.len() as u32 - 1
                })
            };
            cut.triangles.push(triangles[*triangle as usize].map(place));
        }
        let geometry = self.session.geometry();
        for (corner, inward) in [(geometry.bounds_min, 1.0), (geometry.bounds_max, -1.0)] {
            let step = (MARKER_DIAGONALS * geometry.diagonal()) as f32;
            let edge = inward * step.max(8.0 * f32::EPSILON * corner.abs().max_element());
            let first = cut.positions.len() as u32;
            cut.positions.extend([corner, corner + Vec3::X * edge, corner + Vec3::Y * edge].map(<[f32; 3]>::from));
            cut.triangles.push([first, first + 1, first + 2]);
            cut.triangle_materials.push(0);
            cut.triangle_objects.push(0);
        }
        cut
    }
}

/// What is left of a list that fails, so that without any one item it does not: parts are taken away, from halves to single items (delta
/// debugging; Zeller and Hildebrandt, *Simplifying and Isolating Failure-Inducing Input*, TSE 2002). A part is not tried by itself, nor again
/// at its size because another has gone: where few items matter that takes far fewer tests.
pub(super) fn minimal<T: Clone>(
    mut items: Vec<T>,
    mut fails: impl FnMut(&[T]) -> Result<bool, RunError>,
) -> Result<Vec<T>, RunError> {
    let mut size = items.len();
    loop {
        size = size.div_ceil(2);
        let (before, mut begin) = (items.len(), 0);
        while begin < items.len() {
            let end = (begin + size).min(items.len());
            let without = [&items[..begin], &items[end..]].concat();
            match !without.is_empty() && fails(&without)? {
                true => items = without,
                false => begin = end,
            }
        }
        if size <= 1 && items.len() == before {
            return Ok(items);
        }
    }
}
