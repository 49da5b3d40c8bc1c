//! Ground truth: every ray answered in f64.
//!
//! obvhs gives the hierarchy over the triangles' boxes; traversal (boxes padded) and the watertight triangle test run in
//! f64. A sample of the rays is audited by brute force over all triangles.

mod cache;
mod crossings;
mod hierarchy;
mod nearest;
mod pieces;
mod triangle;

use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use tracebench_api::{Geometry, Query, Ray};

pub use cache::Cache;
pub use crossings::Crossing;
pub use hierarchy::Hierarchy;
pub use nearest::{Nearest, area_in_box, nearest_point};
pub use pieces::{Piece, Pieces};
pub use triangle::{RayFrame, intersect};

use crate::progress::Progress;

/// `tight`: relative part of the tolerance on t.
pub const TIGHT_RELATIVE: f64 = 1e-4;
/// `tight`: absolute part of the tolerance on t, in scene diagonals.
pub const TIGHT_ABSOLUTE: f64 = 1e-6;

/// Ulps by which a ray's origin and the ends of its span are moved to see whether it is ambiguous.
const MOVED_ULPS: f64 = 4.0;

/// Rays that an ambiguous ray is moved to: its origin four times, then each end of its span up and down.
pub const MOVES: usize = 8;

/// The least coordinate, in scene diagonals, whose ulps count: next to the coordinates' origin the ulps of an origin's
/// own coordinates shrink below what even f64 tells. No larger than that needs, so that fine things in large scenes keep
/// their edges.
const MIN_COORDINATE_DIAGONALS: f64 = 1e-4;

/// Rays of each set that are audited by brute force, at most; fewer in large scenes, but never fewer than four.
const AUDITED_RAYS: usize = 32;
const MIN_AUDITED_RAYS: usize = 4;
/// Triangle tests that an audit may cost.
const AUDIT_TESTS: usize = 20_000_000;

/// A hit in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueHit {
    /// Ray parameter.
    pub t: f64,
    /// Triangle; of several at equal t the lowest.
    pub primitive: u32,
}

/// What is true of one ray.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// The nearest hit within the ray's span, of any-hit rays too.
    pub hit: Option<TrueHit>,
    /// The nearest hits of the moved rays, where one of them changes the answer; `None` of a ray that is not ambiguous. The origin moves
    /// by 4 ulp of its largest coordinate (or of 1e-4 scene diagonals, if that is more) in four directions square to the ray; then
    /// `t_min`, then `t_max` moves up and down by 4 ulp of the larger of itself and that coordinate. An infinite end stays. A property
    /// of ray and scene, never of a candidate.
    pub perturbed: Option<Box<[Option<TrueHit>; MOVES]>>,
}

impl Answer {
    /// Whether the answer depends on rounding.
    pub fn is_ambiguous(&self) -> bool {
        self.perturbed.is_some()
    }

    /// Every right answer: the ray's own, and of an ambiguous ray those of the moved rays.
    pub fn all(&self) -> impl Iterator<Item = Option<TrueHit>> {
        std::iter::once(self.hit).chain(self.perturbed.iter().flat_map(|hits| hits.iter().copied()))
    }

    /// Whether `t` lies between those of two right answers that hit the same triangle.
    pub fn has_between(&self, t: f64) -> bool {
        let mut before = self.all().flatten().filter(|hit| hit.t <= t);
        before.any(|one| self.all().flatten().any(|other| other.primitive == one.primitive && other.t >= t))
    }
}

/// A ray in f64.
#[derive(Clone, Copy, Debug)]
pub struct Ray64 {
    /// Origin.
    pub origin: DVec3,
    /// Direction, as given (unit to f32 rounding).
    pub direction: DVec3,
    /// Least t.
    pub t_min: f64,
    /// Greatest t.
    pub t_max: f64,
}

impl From<&Ray> for Ray64 {
    fn from(ray: &Ray) -> Self {
        Self {
            origin: DVec3::from(ray.origin.map(f64::from)),
            direction: DVec3::from(ray.direction.map(f64::from)),
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        }
    }
}

impl Ray64 {
    /// The point at t.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// The tolerance of the `tight` rule for a true hit at `t`.
pub fn tight_tolerance(t: f64, diagonal: f64) -> f64 {
    TIGHT_RELATIVE * t + TIGHT_ABSOLUTE * diagonal
}

/// What can go wrong with the truth itself.
#[derive(Debug, thiserror::Error)]
pub enum TruthError {
    /// Hierarchy and brute force disagree: the truth cannot be trusted.
    #[error(
        "ground truth failed its audit: ray {ray} gives {by_hierarchy:?} by the hierarchy and {by_brute_force:?} by \
         brute force over all triangles; delete the cache folder {cache} and run again"
    )]
    Audit {
        /// Index of the ray.
        ray: usize,
        /// Answer by the hierarchy.
        by_hierarchy: Option<TrueHit>,
        /// Answer by brute force.
        by_brute_force: Option<TrueHit>,
        /// Where cached answers lie.
        cache: String,
    },
}

/// The scene in the form that truth is told from.
pub struct Truth {
    geometry: Geometry,
    scene_sha256: String,
    hierarchy: Hierarchy,
    diagonal: f64,
    pieces: OnceLock<Pieces>,
    /// How many rays of each set are audited, at most.
    audited_rays: usize,
}

impl Truth {
    /// Builds the hierarchy.
    pub fn new(geometry: &Geometry, scene_sha256: &str) -> Self {
        Self {
            geometry: geometry.clone(),
            scene_sha256: scene_sha256.to_owned(),
            hierarchy: Hierarchy::new(geometry),
            diagonal: geometry.diagonal(),
            pieces: OnceLock::new(),
            audited_rays: AUDITED_RAYS,
        }
    }

    /// The same that audits the fewest rays of each set: for sets of many trials, of which what counts is told and audited anew.
    #[must_use]
    pub fn lightly_audited(self) -> Self {
        Self { audited_rays: MIN_AUDITED_RAYS, ..self }
    }

    /// The scene's triangles.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The scene's hash.
    pub fn scene_sha256(&self) -> &str {
        &self.scene_sha256
    }

    /// The scene's diagonal.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// The nearest hit of one ray.
    pub fn closest(&self, ray: &Ray64) -> Option<TrueHit> {
        self.hierarchy.closest(&self.geometry, ray)
    }

    /// Every surface along a ray, the nearest first.
    pub fn crossings(&self, ray: &Ray64) -> Vec<Crossing> {
        self.hierarchy.crossings(&self.geometry, ray, self.diagonal)
    }

    /// The connected pieces of the mesh; found out when they are first asked for.
    pub fn pieces(&self) -> &Pieces {
        self.pieces.get_or_init(|| Pieces::new(&self.geometry, &self.hierarchy))
    }

    /// The triangle nearest to a point, if one is within a distance.
    pub fn nearest(&self, point: DVec3, within: f64) -> Option<Nearest> {
        self.hierarchy.nearest(&self.geometry, point, within, None)
    }

    /// The same of one piece's triangles alone.
    pub fn nearest_of_piece(&self, point: DVec3, within: f64, piece: u32) -> Option<Nearest> {
        self.hierarchy.nearest(&self.geometry, point, within, Some((self.pieces(), piece)))
    }

    /// Shows every triangle whose bounds overlap a box.
    pub fn in_box(&self, low: DVec3, high: DVec3, show: impl FnMut(u32)) {
        self.hierarchy.in_box(&self.geometry, low, high, show);
    }

    /// The nearest hit of one ray by trying every triangle.
    pub fn closest_by_brute_force(&self, ray: &Ray64) -> Option<TrueHit> {
        let frame = RayFrame::new(ray)?;
        let mut best: Option<TrueHit> = None;
        for primitive in 0..self.geometry.triangles.len() as u32 {
            let Some(t) = intersect(&frame, ray, self.geometry.corners(primitive)) else { continue };
            if best.is_none_or(|best| t < best.t) {
                best = Some(TrueHit { t, primitive });
            }
        }
        best
    }

    /// Unit geometric normal of a triangle, by its winding; zero for a triangle without area.
    pub fn normal(&self, primitive: u32) -> DVec3 {
        let [a, b, c] = self.geometry.corners(primitive).map(|corner| corner.as_dvec3());
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Answers every ray, from the cache where it holds them, and audits a sample.
    ///
    /// # Errors
    /// [`TruthError::Audit`] if the hierarchy and brute force disagree.
    pub fn answer(
        &self,
        rays: &Arc<Vec<Ray>>,
        query: Query,
        cache: &Cache,
        progress: &Progress,
    ) -> Result<Vec<Answer>, TruthError> {
        let key = self.key(rays, query);
        let answers = match cache.load(&key, rays.len()) {
            Some(answers) => answers,
            None => {
                let answers = self.compute(rays, query, progress);
                cache.store(&key, &answers);
                answers
            }
        };
        self.audit(rays, &answers, cache)?;
        Ok(answers)
    }

    fn compute(&self, rays: &[Ray], query: Query, progress: &Progress) -> Vec<Answer> {
        let bar = progress.bar("ground truth", rays.len() as u64);
        let answer_chunk = |chunk: &[Ray]| {
            let answers: Vec<Answer> = chunk.iter().map(|ray| self.answer_one(&Ray64::from(ray), query)).collect();
            bar.inc(chunk.len() as u64);
            answers
        };
        rays.par_chunks(1024).flat_map_iter(answer_chunk).collect()
    }

    /// Answers one ray and finds whether it is ambiguous.
    pub fn answer_one(&self, ray: &Ray64, query: Query) -> Answer {
        let hit = self.closest(ray);
        let moved = self.moved(ray);
        let is_ambiguous = moved.iter().any(|moved| self.changes(ray, moved, hit, query));
        Answer { hit, perturbed: is_ambiguous.then(|| Box::new(moved.map(|moved| self.closest(&moved)))) }
    }

    /// The rays that rounding may make of a ray, in the order of [`Answer::perturbed`].
    fn moved(&self, ray: &Ray64) -> [Ray64; MOVES] {
        let step = |largest: f64| MOVED_ULPS * f64::from((largest as f32).next_up() - largest as f32);
        let largest = ray.origin.abs().max_element().max(MIN_COORDINATE_DIAGONALS * self.diagonal);
        let (across, upward) = ray.direction.normalize_or_zero().any_orthonormal_pair();
        let of_end = |end: f64| Some(step(end.abs().max(largest))).filter(|step| step.is_finite()).unwrap_or(0.0);
        let (near, far) = (of_end(ray.t_min), of_end(ray.t_max));
        let origin = |direction: DVec3| Ray64 { origin: ray.origin + direction * step(largest), ..*ray };
        let span = |near: f64, far: f64| Ray64 { t_min: ray.t_min + near, t_max: ray.t_max + far, ..*ray };
        let [right, left, up, down] = [across, -across, upward, -upward].map(origin);
        [right, left, up, down, span(near, 0.0), span(-near, 0.0), span(0.0, far), span(0.0, -far)]
    }

    /// Whether a ray goes through an edge or a vertex that the triangle which it hits shares with another one: one of its four moves hits
    /// another triangle at the same place.
    pub fn is_on_shared_edge(&self, ray: &Ray64, hit: TrueHit) -> bool {
        let is_same_place = |other: TrueHit| (other.t - hit.t).abs() <= tight_tolerance(hit.t, self.diagonal);
        let moved = self.moved(ray).into_iter().filter(|moved| moved.origin != ray.origin);
        moved
            .filter_map(|moved| self.closest(&moved))
            .any(|other| other.primitive != hit.primitive && is_same_place(other))
    }

    /// Whether a moved ray gets another answer than a ray's own.
    fn changes(&self, ray: &Ray64, moved: &Ray64, hit: Option<TrueHit>, query: Query) -> bool {
        let is_nearer = |other: &TrueHit| hit.is_none_or(|hit| other.t < hit.t - tight_tolerance(hit.t, self.diagonal));
        if moved.origin == ray.origin && hit.is_none_or(|hit| (moved.t_min..=moved.t_max).contains(&hit.t)) {
            // Where the span alone moves, only what it gains can change the answer.
            let gained = [Ray64 { t_max: ray.t_min, ..*moved }, Ray64 { t_min: ray.t_max, ..*moved }];
            let searched =
                gained.iter().filter(|span| span.t_min < span.t_max && (hit.is_none() || query == Query::Closest));
            return searched.into_iter().any(|span| self.closest(span).is_some_and(|other| is_nearer(&other)));
        }
        match (hit, query) {
            (None, _) => self.closest(moved).is_some(),
            (Some(_), Query::Any) => self.closest(moved).is_none(),
            (Some(hit), Query::Closest) => {
                // What lies beyond the tolerance need not be searched: finding nothing is a change as well.
                let most = hit.t + tight_tolerance(hit.t, self.diagonal);
                let other = self.closest(&Ray64 { t_max: moved.t_max.min(most), ..*moved });
                other.is_none_or(|other| is_nearer(&other))
            }
        }
    }

    fn audit(&self, rays: &[Ray], answers: &[Answer], cache: &Cache) -> Result<(), TruthError> {
        let wanted = (AUDIT_TESTS / self.geometry.triangles.len()).clamp(MIN_AUDITED_RAYS, self.audited_rays);
        let stride = rays.len().div_ceil(wanted).max(1);
        let audited: Vec<usize> = (0..rays.len()).step_by(stride).collect();
        let disagreement = audited.par_iter().find_map_first(|&ray| {
            let own = Ray64::from(&rays[ray]);
            // Of a ray that is not ambiguous there is one answer.
            let mut pairs = std::iter::once(own).chain(self.moved(&own)).zip(answers[ray].all());
            pairs.find_map(|(moved, by_hierarchy)| {
                let by_brute_force = self.closest_by_brute_force(&moved);
                let cache = cache.describe();
                (by_brute_force != by_hierarchy).then_some(TruthError::Audit {
                    ray,
                    by_hierarchy,
                    by_brute_force,
                    cache,
                })
            })
        });
        disagreement.map_or(Ok(()), Err)
    }

    fn key(&self, rays: &[Ray], query: Query) -> String {
        let mut hasher = Sha256::new();
        hasher.update(format!("tracebench truth {} {query:?} {}", cache::VERSION, self.scene_sha256));
        hasher.update(bytemuck::cast_slice::<Ray, u8>(rays));
        crate::hash::hex(&hasher.finalize())
    }
}
