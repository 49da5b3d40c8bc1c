//! On which side of the surfaces a point lies, as images along the axes tell it: by the surfaces that are there, and by the layers
//! that are stored at the centres of texels.

use std::collections::HashMap;
use std::sync::{PoisonError, RwLock};

use glam::DVec3;
use tracebench_api::{ImageChoice, LineOfSight, Orthographic, Projection, SampledImage, VoxelGrid};

use crate::truth::{Ray64, Truth, area_in_box};

/// Axes, and images.
const AXES: usize = 3;

/// Share of a texel within which a point on a border counts to either side of it.
const ON_BORDER: f64 = 1e-3;

/// Texels by which lines are moved aside, unlike in both directions: a line within the plane of a face, or through an edge, goes
/// neither through what begins there nor past it, and counting its crossings would tell no side.
const ASIDE: [f64; 2] = [1.7e-6, 2.9e-6];

/// Texels within which a surface may count to the voxels on either side of a border, by rounding in f32.
const BORDER_TEXELS: f64 = 1e-2;

/// Images along the axes, and the voxels that choose among them.
pub(super) struct Sides<'a> {
    truth: &'a Truth,
    pub grid: VoxelGrid,
    choice: ImageChoice,
    images: [Orthographic; AXES],
    /// The greatest edge of a texel, scene units.
    pub texel: f64,
    chosen: RwLock<HashMap<[u32; 3], Chosen>>,
}

/// What a voxel chooses.
#[derive(Clone, Copy)]
struct Chosen {
    /// Whether it has anything.
    occupied: bool,
    /// The axis of the average normal; none where normals cancel, or there are none.
    axis: Option<usize>,
}

/// Fragments below which a voxel's average hangs on where texels' centres lie.
const FEW_FRAGMENTS: f64 = 64.0;

/// Of the normals in a voxel.
#[derive(Default)]
struct Average {
    sum: DVec3,
    /// Fragments that feed it.
    fed: f64,
    /// Whether the voxel has anything at all.
    any: bool,
}

/// Where a ray's side was told before it comes to a place, and by which image.
pub(super) struct SideDecision {
    pub t: f64,
    pub axis: usize,
    /// Whether that is where the ray starts.
    pub at_start: bool,
}

impl<'a> Sides<'a> {
    /// `None` of methods that do not tell sides, or do not have an image along every axis.
    pub(super) fn new(truth: &'a Truth, grid: VoxelGrid, samplings: &[SampledImage]) -> Option<Self> {
        let along = |axis: usize| {
            samplings.iter().find_map(|sampling| match sampling.projection {
                Projection::Orthographic(image) if image.axis.abs().max_position() == axis => Some(image),
                _ => None,
            })
        };
        let images = [along(0)?, along(1)?, along(2)?];
        let texel = images.iter().map(|image| image.texel.max_element()).fold(0.0, f64::max);
        Some(Self { truth, grid, choice: grid.images?, images, texel, chosen: RwLock::default() })
    }

    /// How voxels are looked into.
    pub(super) fn choice(&self) -> &ImageChoice {
        &self.choice
    }

    /// The axis of the image by which a ray that goes this way is told sides at a point.
    pub(super) fn axis_at(&self, point: DVec3, direction: DVec3) -> usize {
        let going = || (direction / self.grid.voxel).abs().max_position();
        self.grid.voxel_of(point).and_then(|voxel| self.chosen_by(voxel).axis).unwrap_or_else(going)
    }

    /// What a voxel's average normal chooses, as fragments feed it: all of them, by the area that the images have of it, or, where
    /// these are so few that it hangs on where centres lie, the very ones.
    fn chosen_by(&self, voxel: [u32; 3]) -> Chosen {
        if let Some(known) = self.chosen.read().unwrap_or_else(PoisonError::into_inner).get(&voxel) {
            return *known;
        }
        let bounds = self.grid.bounds_of(voxel);
        let mut average = self.average_of_areas(bounds);
        if average.fed < FEW_FRAGMENTS {
            average = self.average_of_samples(bounds);
        }
        let says = average.fed > 0.0 && average.sum.length() > self.choice.cancelled_below * average.fed;
        let chosen = Chosen { occupied: average.any, axis: says.then(|| average.sum.abs().max_position()) };
        self.chosen.write().unwrap_or_else(PoisonError::into_inner).insert(voxel, chosen);
        chosen
    }

    /// A triangle's normal as it is averaged: in the cube, by its winding or as a line.
    fn averaged_normal(&self, primitive: u32) -> DVec3 {
        let normal = (self.truth.normal(primitive) * self.grid.voxel).normalize_or_zero();
        let turned = self.choice.as_lines && normal[normal.abs().max_position()] < 0.0;
        if turned { -normal } else { normal }
    }

    fn feeds(&self, axis: usize, normal: DVec3) -> bool {
        !self.choice.by_dominant_axis || normal.abs().max_position() == axis
    }

    /// As many fragments as there is area.
    fn average_of_areas(&self, [low, high]: [DVec3; 2]) -> Average {
        let mut average = Average::default();
        self.truth.in_box(low, high, |primitive| {
            let corners = self.truth.geometry().corners(primitive).map(|corner| corner.as_dvec3());
            let (normal, facing) = (self.averaged_normal(primitive), self.truth.normal(primitive).abs());
            let area = area_in_box(corners, low, high);
            average.any |= area > 0.0;
            for (axis, image) in self.images.iter().enumerate().filter(|(axis, _)| self.feeds(*axis, normal)) {
                let fragments = area * facing[axis] / image.texel.element_product();
                average.sum += fragments * normal;
                average.fed += fragments;
            }
        });
        average
    }

    fn average_of_samples(&self, bounds: [DVec3; 2]) -> Average {
        let mut average = Average::default();
        for (axis, primitive) in self.samples(bounds) {
            let normal = self.averaged_normal(primitive);
            average.any = true;
            if self.feeds(axis, normal) {
                average.sum += normal;
                average.fed += 1.0;
            }
        }
        average
    }

    /// What texels' centres show in a box: the axis of the image, and the triangle.
    fn samples(&self, [low, high]: [DVec3; 2]) -> impl Iterator<Item = (usize, u32)> {
        self.images.iter().enumerate().flat_map(move |(axis, image)| {
            let projection = Projection::Orthographic(*image);
            let [one, other] = [low, high].map(|end| image.project(end));
            let centres = |a: f64, b: f64| (a.min(b) - 0.5).ceil() as i64..=(a.max(b) - 0.5).floor() as i64;
            let [t_min, t_max] = [one.depth.min(other.depth), one.depth.max(other.depth)];
            let rows = centres(one.y, other.y);
            let texels = centres(one.x, other.x).flat_map(move |column| rows.clone().map(move |row| (column, row)));
            texels.flat_map(move |(column, row)| {
                let line = projection.line_through(column as f64 + 0.5, row as f64 + 0.5);
                let crossings =
                    self.truth.crossings(&Ray64 { origin: line.origin, direction: line.direction, t_min, t_max });
                crossings.into_iter().map(move |crossing| (axis, crossing.primitive))
            })
        })
    }

    /// Where a ray's search begins: past what it leaves out, or where it comes into the grid.
    pub(super) fn begins(&self, ray: &Ray64) -> f64 {
        match self.grid.voxel_of(ray.at(ray.t_min)) {
            Some(_) => ray.t_min + self.choice.start_texels * self.texel / ray.direction.length(),
            None => self.span_in_grid(ray)[0].max(ray.t_min),
        }
    }

    /// Where the side was told that ends a ray at t.
    pub(super) fn told_before(&self, ray: &Ray64, t: f64) -> SideDecision {
        let start = self.begins(ray);
        let step = BORDER_TEXELS * self.texel / ray.direction.length();
        if self.choice.from_start {
            return SideDecision { t: start, axis: self.axis_at(ray.at(start + step), ray.direction), at_start: true };
        }
        // Back through the voxels that are searched by the same image.
        let axis = self.axis_at(ray.at(t), ray.direction);
        let mut at = t;
        while at > start {
            let Some(voxel) = self.grid.voxel_of(ray.at(at)) else { break };
            let chosen = self.chosen_by(voxel);
            if at < t && !(chosen.occupied && self.axis_at(ray.at(at), ray.direction) == axis) {
                break;
            }
            at = span_in(ray, self.grid.bounds_of(voxel))[0].min(at) - step;
            if !chosen.occupied {
                break;
            }
        }
        let told = (at + step - self.texel / ray.direction.length()).max(start);
        SideDecision { t: told, axis, at_start: told <= start }
    }

    /// Whether a ray passes a layer that is stored in the image along an axis, between two parameters.
    pub(super) fn passes_layer(&self, axis: usize, ray: &Ray64, begin: f64, end: f64) -> bool {
        let image = Projection::Orthographic(self.images[axis]);
        let at = |t: f64| image.project(ray.at(t));
        let (Some(from), Some(middle), Some(to)) = (at(begin), at((begin + end) / 2.0), at(end)) else { return false };
        let line = image.line_through(middle.x.floor() + 0.5, middle.y.floor() + 0.5);
        let (near, far) = (from.depth.min(to.depth), from.depth.max(to.depth));
        !self
            .truth
            .crossings(&Ray64 { origin: line.origin, direction: line.direction, t_min: near, t_max: far })
            .is_empty()
    }

    /// Whether a point is inside by the surfaces before it along an axis: there are an odd number.
    pub(super) fn inside(&self, axis: usize, point: DVec3) -> bool {
        self.is_odd(axis, Projection::Orthographic(self.images[axis]).line_to(point))
    }

    /// The same by the layers that are stored where a ray is as it comes to t: those at the centre of its texel there.
    pub(super) fn stored_inside(&self, axis: usize, ray: &Ray64, t: f64) -> bool {
        self.stored_inside_at(axis, ray, t, t - ON_BORDER * self.texel / ray.direction.length())
    }

    /// Whether the layers that are stored where a ray comes to t put it on another side than it should be: where layers are seen in every
    /// texel, those of the texel that it enters there are asked, too.
    pub(super) fn is_stored_otherwise(&self, axis: usize, ray: &Ray64, t: f64, should_be: bool) -> bool {
        let just_behind = t + ON_BORDER * self.texel / ray.direction.length();
        self.stored_inside(axis, ray, t) != should_be
            || self.choice.layers_passed && self.stored_inside_at(axis, ray, t, just_behind) != should_be
    }

    /// By the layers of the texel where the ray is at a second parameter.
    fn stored_inside_at(&self, axis: usize, ray: &Ray64, t: f64, in_texel_at: f64) -> bool {
        let image = Projection::Orthographic(self.images[axis]);
        let Some(at) = image.project(ray.at(in_texel_at)) else { return false };
        let Some(depth) = image.project(ray.at(t)).map(|at| at.depth) else { return false };
        let line = image.line_through(at.x.floor() + 0.5, at.y.floor() + 0.5);
        self.is_odd(axis, LineOfSight { far: depth, ..line })
    }

    fn is_odd(&self, axis: usize, line: LineOfSight) -> bool {
        let LineOfSight { origin, direction, near, far } = line;
        let image = &self.images[axis];
        let origin = origin + image.right * (ASIDE[0] * image.texel.x) + image.up * (ASIDE[1] * image.texel.y);
        self.truth.crossings(&Ray64 { origin, direction, t_min: near, t_max: far }).len() % 2 == 1
    }

    /// Where the side of a ray is asked on its way through the voxel that it is in at t, by the image along an axis.
    pub(super) fn asked(&self, axis: usize, ray: &Ray64, t: f64) -> Vec<f64> {
        let Some(voxel) = self.grid.voxel_of(ray.at(t)) else { return Vec::new() };
        let [begin, end] = span_in(ray, self.grid.bounds_of(voxel));
        let [begin, end] = [begin.max(ray.t_min), end.min(ray.t_max)];
        if let Some(points) = self.choice.points {
            return (1..=points).map(|point| begin + (end - begin) * f64::from(point) / f64::from(points)).collect();
        }
        let image = &self.images[axis];
        let from = image.project(ray.origin);
        let (across, down) = (ray.direction.dot(image.right), -ray.direction.dot(image.up));
        let mut asked = vec![end];
        for (from, step) in [(from.x, across / image.texel.x), (from.y, down / image.texel.y)] {
            if step != 0.0 {
                let ends = [from + begin * step, from + end * step];
                let (first, last) = (ends[0].min(ends[1]).ceil() as i64, ends[0].max(ends[1]).floor() as i64);
                asked.extend((first..=last).map(|border| (border as f64 - from) / step));
            }
        }
        asked.retain(|t| (begin..=end).contains(t));
        asked.sort_by(f64::total_cmp);
        asked
    }

    /// Where a ray enters the voxel that it is in at t.
    pub(super) fn enters_voxel(&self, ray: &Ray64, t: f64) -> f64 {
        let entry = |voxel| span_in(ray, self.grid.bounds_of(voxel))[0].max(ray.t_min);
        self.grid.voxel_of(ray.at(t)).map_or(t, entry)
    }

    /// Whether all that the voxel of a point has may count to its neighbours: it lies on the voxel's border.
    pub(super) fn has_on_border_alone(&self, point: DVec3) -> bool {
        let Some(voxel) = self.grid.voxel_of(point) else { return true };
        let margin = BORDER_TEXELS * self.texel;
        let [low, high] = self.grid.bounds_of(voxel);
        !has_anything(self.truth, low + margin, high - margin)
    }

    /// Whether a texel's centre in any image surely shows anything in the voxel of a point, and not on its border, from where it may count
    /// to a neighbour: where none does the voxel is held to be empty.
    pub(super) fn is_sampled(&self, point: DVec3) -> bool {
        let Some(voxel) = self.grid.voxel_of(point) else { return false };
        let margin = BORDER_TEXELS * self.texel;
        let [low, high] = self.grid.bounds_of(voxel);
        self.samples([low + margin, high - margin]).next().is_some()
    }

    /// Where a ray leaves the grid.
    pub(super) fn leaves(&self, ray: &Ray64) -> f64 {
        self.span_in_grid(ray)[1].min(ray.t_max)
    }

    fn span_in_grid(&self, ray: &Ray64) -> [f64; 2] {
        span_in(ray, [self.grid.low, self.grid.low + self.grid.voxel * f64::from(self.grid.size)])
    }

    /// Whether a surface is within a texel's edge of a point.
    pub(super) fn is_within_texel(&self, point: DVec3) -> bool {
        self.truth.nearest(point, self.texel).is_some()
    }
}

/// Share of a voxel within which a surface counts to the voxels on either side of a border: methods widen voxels, or round.
const VOXEL_BORDER: f64 = 1.0 / 256.0;

/// Whether a voxel has anything of the scene.
pub(super) fn is_occupied(truth: &Truth, grid: &VoxelGrid, voxel: [u32; 3]) -> bool {
    let [low, high] = grid.bounds_of(voxel);
    has_anything(truth, low - VOXEL_BORDER * grid.voxel, high + VOXEL_BORDER * grid.voxel)
}

fn has_anything(truth: &Truth, low: DVec3, high: DVec3) -> bool {
    let mut any = false;
    truth.in_box(low, high, |primitive| {
        let corners = truth.geometry().corners(primitive).map(|corner| corner.as_dvec3());
        any = any || area_in_box(corners, low, high) > 0.0;
    });
    any
}

/// Where a ray is within a box.
pub(super) fn span_in(ray: &Ray64, [low, high]: [DVec3; 2]) -> [f64; 2] {
    let mut span = [f64::NEG_INFINITY, f64::INFINITY];
    for axis in 0..AXES {
        let along = ray.direction[axis];
        if along != 0.0 {
            let ends = [(low[axis] - ray.origin[axis]) / along, (high[axis] - ray.origin[axis]) / along];
            span = [span[0].max(ends[0].min(ends[1])), span[1].min(ends[0].max(ends[1]))];
        }
    }
    span
}
