//! Why answers through voxels are wrong. A method that tells inside from outside by images along the axes is followed to where its
//! answer and the truth part: at a wrong hit, and at a true one that it passed, the judge tells the ray's side by the surfaces
//! that are there and by what the texels' centres show, as the method says that it asks.

use glam::DVec3;
use tracebench_api::{Hit, VoxelGrid};

use super::causes::{BETWEEN_SAMPLES, NEAR_START, SELF_HIT};
use super::sides::{Sides, is_occupied, span_in};
use super::{Class, Judge};
use crate::results::UNEXPLAINED;
use crate::truth::{Ray64, TrueHit};

/// Inside and outside contradict each other: a ray's side changes where it goes through no surface, or does not where it goes
/// through one, by the scene's surfaces themselves. Closed meshes have no such place.
pub const OPEN_MESH: &str = "open_mesh";
/// The layers stored at the texel where the side of the ray's start is told put it on the other side than it is.
pub const WRONG_SIDE_AT_START: &str = "wrong_side_at_start";
/// The true hit's surface is not seen in the image that its voxel's average normal chooses, and would be in the one along the axis of
/// its own normal.
pub const WRONG_AXIS: &str = "wrong_axis";
/// What the ray enters at the true hit is thinner there than a texel.
pub const THINNER_THAN_TEXEL: &str = "thinner_than_texel";
/// The ray comes out again in the same voxel, before its side is asked.
pub const SEVERAL_SURFACES: &str = "several_surfaces";

/// Points of a stretch that are looked at.
const LOOKED_AT: u32 = 8;

/// Texels by which a point lies before or behind a surface that the ray goes through there.
const BESIDE_TEXELS: f64 = 1e-3;

/// What explains answers through voxels.
pub(super) enum Voxels<'a> {
    /// By images that tell sides.
    Sides(Box<Sides<'a>>),
    /// By what voxels have.
    Alone(VoxelGrid),
}

impl<'a> Voxels<'a> {
    pub(super) fn new(judge: &Judge<'a>) -> Option<Self> {
        let grid = judge.voxels?;
        match grid.images {
            None => Some(Self::Alone(grid)),
            Some(_) => Sides::new(judge.truth, grid, judge.samplings).map(|sides| Self::Sides(Box::new(sides))),
        }
    }
}

impl Judge<'_> {
    /// The cause of a wrong answer through voxels.
    pub(super) fn cause_by_voxels(
        &self,
        voxels: &Voxels<'_>,
        ray: &Ray64,
        index: usize,
        hit: &Hit,
        class: Class,
    ) -> &'static str {
        let lost = match (class, self.truth_for(index, hit)) {
            (Class::FalseMiss | Class::Late, Some(truth)) => Some(truth),
            _ => None,
        };
        let told = hit.is_hit().then(|| f64::from(hit.t));
        let found = match (voxels, lost) {
            (Voxels::Sides(sides), Some(truth)) => self.loss_by_sides(sides, ray, truth, told),
            (Voxels::Sides(sides), None) => invention_by_sides(sides, ray, f64::from(hit.t)),
            (Voxels::Alone(grid), Some(truth)) => self.loss_by_voxels(grid, ray, truth, told),
            (Voxels::Alone(grid), None) => self.invention_by_voxels(grid, ray, f64::from(hit.t)),
        };
        match found {
            UNEXPLAINED if lost.is_none() && self.is_near_start(ray, f64::from(hit.t)) => SELF_HIT,
            found => found,
        }
    }

    /// Why the true hit was passed.
    fn loss_by_sides(&self, sides: &Sides<'_>, ray: &Ray64, truth: TrueHit, told: Option<f64>) -> &'static str {
        let step = BESIDE_TEXELS * sides.texel / ray.direction.length();
        let point = ray.at(truth.t);
        let behind = truth.t + step;
        let axis = sides.axis_at(ray.at(behind), ray.direction);
        if truth.t < sides.begins(ray) {
            return NEAR_START;
        }
        let start = Reference::of(sides, ray, behind);
        // Behind the surface the side must be another one than at the start, or nobody could tell that it was passed.
        let next = self.truth.closest(&Ray64 { t_min: behind.next_up(), ..*ray }).map(|next| next.t);
        let enters_anything = next.is_none_or(|next| next > behind);
        if enters_anything && sides.inside(axis, ray.at(behind)) == start.inside {
            return OPEN_MESH;
        }
        if let Some(cause) = start.cause() {
            return cause;
        }
        // The stretch on which it could have been seen: up to the answer, or to where the ray comes out.
        let comes_out = next.unwrap_or(f64::INFINITY).min(sides.leaves(ray));
        let end = told.unwrap_or(f64::INFINITY).min(comes_out);
        // What is not shown where it is asked has no sample.
        let shown = |axis: usize| is_shown(sides, axis, ray, [behind, end], !start.inside);
        if told.is_some_and(|told| told <= comes_out + step) {
            let explained = stays_within_texel(sides, ray, [behind, end]) || !shown(axis);
            return if explained { BETWEEN_SAMPLES } else { UNEXPLAINED };
        }
        let normal = self.truth.normal(truth.primitive);
        let own_axis = (normal * sides.grid.voxel).abs().max_position();
        if own_axis != axis && !shown(axis) && shown(own_axis) {
            return WRONG_AXIS;
        }
        if self.thickness(sides, ray, point, normal).min((comes_out - truth.t) * ray.direction.length()) <= sides.texel
        {
            return THINNER_THAN_TEXEL;
        }
        if !has_asked(sides, axis, ray, behind, end) {
            return SEVERAL_SURFACES;
        }
        match stays_within_texel(sides, ray, [behind, end]) {
            true => BETWEEN_SAMPLES,
            false if contradicts(sides, ray, [behind, end], !start.inside) => OPEN_MESH,
            // The voxel behind the surface is where its side would be asked, and has no sample of it.
            false if sides.has_on_border_alone(ray.at(behind)) => BETWEEN_SAMPLES,
            false if !sides.is_sampled(ray.at(behind)) || !shown(axis) => BETWEEN_SAMPLES,
            false => UNEXPLAINED,
        }
    }

    /// How thick, along its normal, is what a ray enters; infinite for what nothing bounds.
    fn thickness(&self, sides: &Sides<'_>, ray: &Ray64, point: DVec3, normal: DVec3) -> f64 {
        let inwards = if normal.dot(ray.direction) > 0.0 { normal } else { -normal };
        let step = BESIDE_TEXELS * sides.texel;
        let through = Ray64 { origin: point, direction: inwards, t_min: step, t_max: f64::INFINITY };
        self.truth.closest(&through).map_or(f64::INFINITY, |back| back.t)
    }

    /// Why the true hit was passed by a method that knows voxels alone.
    fn loss_by_voxels(&self, grid: &VoxelGrid, ray: &Ray64, truth: TrueHit, told: Option<f64>) -> &'static str {
        let point = ray.at(truth.t);
        let Some(voxel) = grid.voxel_of(point) else { return UNEXPLAINED };
        let leaves = span_in(ray, grid.bounds_of(voxel))[1] + BESIDE_TEXELS * grid.voxel.min_element();
        if !self.is_sampled(grid, voxel) || told.is_some_and(|told| told <= leaves) {
            return BETWEEN_SAMPLES;
        }
        let is_within = |told: f64| (told - truth.t) * ray.direction.length() <= grid.voxel.length();
        match self.is_full_up_to(grid, ray, truth.t) {
            true if told.is_some_and(is_within) => BETWEEN_SAMPLES,
            true => NEAR_START,
            false => UNEXPLAINED,
        }
    }

    /// Whether a line through the middle of a voxel along any axis meets something in it, as rasterizers sample.
    fn is_sampled(&self, grid: &VoxelGrid, voxel: [u32; 3]) -> bool {
        let [low, high] = grid.bounds_of(voxel);
        let middle = (low + high) / 2.0;
        DVec3::AXES.into_iter().any(|axis| {
            let half = axis.dot(high - low) / 2.0;
            let line = Ray64 { origin: middle - axis * half, direction: axis, t_min: 0.0, t_max: 2.0 * half };
            self.truth.closest(&line).is_some()
        })
    }

    /// Whether every voxel from a ray's start to t has something: who leaves out the voxels that hold the start looks at none.
    fn is_full_up_to(&self, grid: &VoxelGrid, ray: &Ray64, t: f64) -> bool {
        let step = BESIDE_TEXELS * grid.voxel.min_element() / ray.direction.length();
        let mut at = ray.t_min;
        while at < t {
            let Some(voxel) = grid.voxel_of(ray.at(at)) else { return false };
            if !is_occupied(self.truth, grid, voxel) {
                return false;
            }
            at = span_in(ray, grid.bounds_of(voxel))[1].max(at) + step;
        }
        true
    }

    /// Why something was hit that is not there, by a method that knows voxels alone.
    fn invention_by_voxels(&self, grid: &VoxelGrid, ray: &Ray64, told: f64) -> &'static str {
        let (step, point) = (BESIDE_TEXELS * grid.voxel.min_element(), ray.at(told));
        // Of all voxels that meet near there: a ray may go along the side by which it enters one.
        let corner_of =
            |corner: u32| DVec3::from([0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -step } else { step }));
        let full = (0..8).any(|corner| {
            grid.voxel_of(point + corner_of(corner)).is_some_and(|voxel| is_occupied(self.truth, grid, voxel))
        });
        if full { BETWEEN_SAMPLES } else { UNEXPLAINED }
    }
}

/// The side by which a ray is held to have met something at a place.
struct Reference {
    /// By the surfaces that are there.
    inside: bool,
    /// By what is stored.
    told_inside: bool,
    at_start: bool,
}

impl Reference {
    fn of(sides: &Sides<'_>, ray: &Ray64, t: f64) -> Self {
        let told = sides.told_before(ray, t);
        // What a start leaves out is no fault of the side's.
        let true_at = if told.at_start { ray.t_min } else { told.t };
        Self {
            inside: sides.inside(told.axis, ray.at(true_at)),
            told_inside: sides.stored_inside(told.axis, ray, told.t),
            at_start: told.at_start,
        }
    }

    /// What it explains if it was told wrongly.
    fn cause(&self) -> Option<&'static str> {
        let cause = if self.at_start { WRONG_SIDE_AT_START } else { BETWEEN_SAMPLES };
        (self.told_inside != self.inside).then_some(cause)
    }
}

/// Why a ray ended where there is nothing.
fn invention_by_sides(sides: &Sides<'_>, ray: &Ray64, told: f64) -> &'static str {
    let start = Reference::of(sides, ray, told);
    let step = BESIDE_TEXELS * sides.texel / ray.direction.length();
    // On a border of voxels either may have been searched.
    let changes = [told - step, told + step].into_iter().map(|t| (t, sides.axis_at(ray.at(t), ray.direction)));
    let near_surface = sides.is_within_texel(ray.at(told));
    if !near_surface && changes.into_iter().any(|(t, axis)| sides.inside(axis, ray.at(t)) != start.inside) {
        return OPEN_MESH;
    }
    if let Some(cause) = start.cause() {
        return cause;
    }
    if near_surface {
        return BETWEEN_SAMPLES;
    }
    // Any hit ends where a search leaves what it looked into at once, at most the voxel.
    let looked_into = sides.enters_voxel(ray, told - step);
    if [told, looked_into].into_iter().any(|begin| contradicts(sides, ray, [begin, told], start.inside)) {
        return OPEN_MESH;
    }
    // A layer at the centre of its texel that the ray goes past.
    let axis = sides.axis_at(ray.at(told - step), ray.direction);
    match sees_layer(sides, axis, ray, told - step, [looked_into, told]) {
        true => BETWEEN_SAMPLES,
        false => UNEXPLAINED,
    }
}

/// Whether on a stretch of a ray any image has it on another side than it should be: by the surfaces themselves, or, where none is
/// within a texel, by what is stored.
fn contradicts(sides: &Sides<'_>, ray: &Ray64, [begin, end]: [f64; 2], should_be: bool) -> bool {
    between(begin, end).any(|t| {
        let far = !sides.is_within_texel(ray.at(t));
        far && (0..3).any(|axis| {
            sides.inside(axis, ray.at(t)) != should_be || sides.is_stored_otherwise(axis, ray, t, should_be)
        })
    })
}

/// Whether a ray is within a texel of a surface all the way.
fn stays_within_texel(sides: &Sides<'_>, ray: &Ray64, [begin, end]: [f64; 2]) -> bool {
    between(begin, end).all(|t| sides.is_within_texel(ray.at(t)))
}

/// Points evenly over a stretch, ends left out.
pub(super) fn between(begin: f64, end: f64) -> impl Iterator<Item = f64> {
    (1..=LOOKED_AT).map(move |point| begin + (end - begin) * f64::from(point) / f64::from(LOOKED_AT + 1))
}

/// Whether the ray's side is asked between two parameters, by the image along an axis, in the voxel of the first; where layers are seen in
/// every texel, it is wherever the ray goes.
fn has_asked(sides: &Sides<'_>, axis: usize, ray: &Ray64, begin: f64, end: f64) -> bool {
    sides.choice().layers_passed || sides.asked(axis, ray, begin).into_iter().any(|t| begin < t && t < end)
}

/// Whether what is stored in the image along an axis puts the ray on the side on which it is, at any place where that is asked, or
/// has a layer that it passes, where these are seen.
fn is_shown(sides: &Sides<'_>, axis: usize, ray: &Ray64, [begin, end]: [f64; 2], inside: bool) -> bool {
    let asked = [sides.enters_voxel(ray, begin)].into_iter().chain(sides.asked(axis, ray, begin));
    asked.into_iter().any(|t| begin < t && t < end && sides.stored_inside(axis, ray, t) == inside)
        || sees_layer(sides, axis, ray, begin, [begin, end])
}

/// Whether a method that sees layers in every texel passes one on a stretch of a ray, in the image along an axis and in the voxel where
/// the ray is at a parameter.
fn sees_layer(sides: &Sides<'_>, axis: usize, ray: &Ray64, in_voxel_at: f64, [begin, end]: [f64; 2]) -> bool {
    let mut asked = sides.asked(axis, ray, in_voxel_at);
    asked.insert(0, sides.enters_voxel(ray, in_voxel_at));
    let passes = |pair: &[f64]| pair[0] < end && pair[1] > begin && sides.passes_layer(axis, ray, pair[0], pair[1]);
    sides.choice().layers_passed && asked.windows(2).any(passes)
}
