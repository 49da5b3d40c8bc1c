//! Why an answer is wrong. The judge finds out by itself: it projects the true and the answered hit into the tracer's
//! views and asks the f64 truth what those views show. Of the tracer it takes only the status.

use glam::DVec3;
use tracebench_api::{Hit, Projected, Status, View};

use super::{Class, Judge, Rule};
use crate::truth::{Ray64, TrueHit, tight_tolerance};

/// Pixels of a view within which two points count as the same sample of it.
const VIEW_PIXELS: f64 = 2.0;

/// Pixels of a view by which a rasterizer may move an edge: twice the 1/256 that Vulkan asks for at least, four times
/// over for the two vertices of an edge.
const RASTER_SNAP_PIXELS: f64 = 1.0 / 64.0;

/// Relative distance of layers that are told apart, and how many of a pixel are looked through.
const LAYER_STEP: f64 = 1e-9;
const MOST_LAYERS: usize = 256;

/// Reference pixels within which a wrong hit counts as one with the surface that the ray starts on.
const SELF_HIT_PIXELS: f64 = 4.0;

/// The right surface, off by less than a reference pixel: wrong under `tight` only.
pub const WITHIN_FOOTPRINT: &str = "within_footprint";
/// The true hit lies in none of the tracer's views (aside, before near or behind the eye).
pub const OFF_VIEW: &str = "off_view";
/// The true hit lies behind another surface in every view that contains it.
pub const HIDDEN_LAYER: &str = "hidden_layer";
/// A view shows the true hit, but the centre of its pixel (to a rasterizer's precision) shows something else; or the
/// answer is off by no more than two pixels of the view; or a surface that the pixel's centre shows was hit beside it.
pub const BETWEEN_SAMPLES: &str = "between_samples";
/// A view shows the true hit within two of its pixels from the ray's start, where sampled methods do not look so as not
/// to find the surface that the ray starts on.
pub const NEAR_START: &str = "near_start";
/// The surface that the ray starts on was hit.
pub const SELF_HIT: &str = "self_hit";
/// The answered hit lies behind what the view shows there: a surface was taken to be thick.
pub const ASSUMED_THICKNESS: &str = "assumed_thickness";
/// The true hit's surface is stored at its pixel of a view, and the ray was let through: it passed between that fragment and the
/// next one, or between the pixels that were looked at. Of methods that know surfaces by samples alone and keep every layer.
pub const SLIPPED_THROUGH: &str = "slipped_through";
/// The tracer's step limit.
pub const STEP_CAP: &str = "step_cap";
/// The tracer passed behind a surface by more than its thickness.
pub const THICKNESS_REJECTED: &str = "thickness_rejected";
/// None of these.
pub const UNEXPLAINED: &str = "unexplained";

impl Judge<'_> {
    /// The cause of a wrong answer.
    pub(super) fn cause(&self, index: usize, hit: &Hit, class: Class) -> &'static str {
        let ray = Ray64::from(&self.rays[index]);
        if matches!(class, Class::Early | Class::Late) && self.class(Rule::Footprint, index, hit) == Class::TrueHit {
            return WITHIN_FOOTPRINT;
        }
        match (class, self.answers[index].hit) {
            (Class::FalseMiss | Class::Late, Some(truth)) => self.cause_of_loss(&ray, truth, hit),
            _ => self.cause_of_invention(&ray, hit),
        }
    }

    /// Why the true hit was not found.
    fn cause_of_loss(&self, ray: &Ray64, truth: TrueHit, hit: &Hit) -> &'static str {
        let capped = hit.status == Status::StepCap as u32;
        if self.views.is_empty() {
            return if capped { STEP_CAP } else { UNEXPLAINED };
        }
        let point = ray.at(truth.t);
        let containing: Vec<&View> = self.views.iter().filter(|view| view.project_inside(point).is_some()).collect();
        if containing.is_empty() {
            return OFF_VIEW;
        }
        // Where every layer is kept, views show what lies behind others, too.
        let shows = |view: &&View| self.keeps_hidden_layers || self.shows(view, point);
        let showing: Vec<&View> = containing.into_iter().filter(shows).collect();
        if showing.is_empty() {
            return HIDDEN_LAYER;
        }
        if capped {
            return STEP_CAP;
        }
        let within_pixels = |view: &&View, from: DVec3, to: DVec3| {
            let (from, to) = (view.project(from), view.project(to));
            from.zip(to).is_some_and(|(from, to)| (from.x - to.x).abs().max((from.y - to.y).abs()) <= VIEW_PIXELS)
        };
        if !showing.iter().any(|view| self.samples(view, point, truth.primitive))
            || hit.is_hit() && showing.iter().any(|view| within_pixels(view, ray.at(f64::from(hit.t)), point))
        {
            return BETWEEN_SAMPLES;
        }
        if showing.iter().all(|view| within_pixels(view, ray.origin, point)) {
            return NEAR_START;
        }
        match hit.status == Status::ThicknessRejected as u32 {
            true => THICKNESS_REJECTED,
            false if self.keeps_hidden_layers && !self.names_primitives => SLIPPED_THROUGH,
            false => UNEXPLAINED,
        }
    }

    /// Why something was hit that is not there.
    fn cause_of_invention(&self, ray: &Ray64, hit: &Hit) -> &'static str {
        let t = f64::from(hit.t);
        let point = ray.at(t);
        let starts_on_surface = SELF_HIT_PIXELS * self.footprint(ray.origin);
        if t * ray.direction.length() <= starts_on_surface.max(tight_tolerance(0.0, self.truth.diagonal())) {
            return SELF_HIT;
        }
        let containing = self.views.iter().filter_map(|view| view.project_inside(point).map(|at| (view, at.depth)));
        for (view, depth) in containing {
            let Some(stored) = self.centre_depth(view, point) else { continue };
            return if depth > stored + self.footprint(point) { ASSUMED_THICKNESS } else { BETWEEN_SAMPLES };
        }
        UNEXPLAINED
    }

    /// Whether nothing lies between a view's eye and a point.
    fn shows(&self, view: &View, point: DVec3) -> bool {
        let offset = point - view.eye;
        let distance = offset.length();
        // Near is an eye depth; along this line of sight it lies farther.
        let near = (view.near * distance / offset.dot(view.forward)).min(distance);
        let sight = Ray64 {
            origin: view.eye,
            direction: offset / distance,
            t_min: near,
            t_max: (distance - self.footprint(point)).max(near),
        };
        self.truth.closest(&sight).is_none()
    }

    /// Whether the centre of the pixel that a point falls on, moved by a rasterizer's rounding in any direction, shows
    /// the same triangle or one within a footprint in depth, in any layer where all are kept; on a border between pixels, the centres of all of them.
    fn samples(&self, view: &View, point: DVec3, primitive: u32) -> bool {
        let Some(at) = view.project_inside(point) else { return false };
        let moves = [(0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        centres(&at).into_iter().all(|centre| {
            moves.into_iter().all(|(across, down)| {
                let (x, y) = (centre.0 + across * RASTER_SNAP_PIXELS, centre.1 + down * RASTER_SNAP_PIXELS);
                let is_it = |found: &TrueHit| {
                    found.primitive == primitive || (found.t - at.depth).abs() <= self.footprint(point)
                };
                self.layers(view, x, y).any(|found| is_it(&found))
            })
        })
    }

    /// The eye depth at the centre of the pixel that a point falls on; on a border between pixels, to a rasterizer's
    /// precision, of a neighbour if its own centre shows nothing.
    fn centre_depth(&self, view: &View, point: DVec3) -> Option<f64> {
        let at = view.project_inside(point)?;
        centres(&at).into_iter().find_map(|(x, y)| self.shown(view, x, y)).map(|found| found.t)
    }

    /// What a view shows at a position in pixels; t is the eye depth.
    fn shown(&self, view: &View, x: f64, y: f64) -> Option<TrueHit> {
        self.beyond(view, x, y, view.near)
    }

    /// The first surface at a position in pixels that is not nearer than an eye depth.
    fn beyond(&self, view: &View, x: f64, y: f64, depth: f64) -> Option<TrueHit> {
        let direction = view.direction_through(x, y);
        self.truth.closest(&Ray64 { origin: view.eye, direction, t_min: depth, t_max: view.far })
    }

    /// What a view keeps at a position in pixels: what it shows and, where it keeps hidden layers, what lies behind.
    fn layers<'b>(&'b self, view: &'b View, x: f64, y: f64) -> impl Iterator<Item = TrueHit> + 'b {
        let next = move |found: &TrueHit| self.beyond(view, x, y, found.t * (1.0 + LAYER_STEP));
        let most = if self.keeps_hidden_layers { MOST_LAYERS } else { 1 };
        std::iter::successors(self.shown(view, x, y), next).take(most)
    }
}

/// The centres of the pixels that a position falls on to a rasterizer's precision, its own first: two or four of them
/// where it lies on a border.
fn centres(at: &Projected) -> Vec<(f64, f64)> {
    let along = |position: f64| {
        let mut found = vec![position.floor() + 0.5];
        for moved in [position - RASTER_SNAP_PIXELS, position + RASTER_SNAP_PIXELS] {
            let centre = moved.floor() + 0.5;
            if !found.contains(&centre) {
                found.push(centre);
            }
        }
        found
    };
    let (columns, rows) = (along(at.x), along(at.y));
    rows.iter().flat_map(|y| columns.iter().map(move |x| (*x, *y))).collect()
}
