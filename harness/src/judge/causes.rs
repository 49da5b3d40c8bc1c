//! Why an answer is wrong. The judge finds out by itself: it projects the true and the answered hit into the images that
//! the tracer samples the scene by, here called views, and asks the f64 truth what these show. Of the tracer it takes only
//! what it declares and the status. A cause needs evidence; what has none is unexplained.

use glam::DVec3;
use tracebench_api::{Hit, Layers, LineOfSight, Projected, Query, Ray, SampledImage, Status};

use super::march::{Look, Passage};
use super::voxels::{Voxels, between};
use super::{Class, Judge, Rule};
use crate::results::UNEXPLAINED;
use crate::truth::{Ray64, TrueHit, tight_tolerance};

/// Pixels of a view within which two points count as the same sample of it.
const VIEW_PIXELS: f64 = 2.0;

/// Pixels of a view by which a rasterizer may move an edge: twice the 1/256 that Vulkan asks for at least, four times
/// over for the two vertices of an edge.
pub(super) const RASTER_SNAP_PIXELS: f64 = 1.0 / 64.0;

/// Relative distance of layers that are distinguished, and how many of a pixel are looked through.
const LAYER_STEP: f64 = 1e-9;
const MAX_LAYERS: usize = 256;

/// Reference pixels within which a wrong hit counts as one with the surface that the ray starts on.
const SELF_HIT_PIXELS: f64 = 4.0;

/// The right surface, off by less than a reference pixel: wrong under `tight` only.
pub const WITHIN_FOOTPRINT: &str = "within_footprint";
/// The true hit lies in none of the tracer's views (aside, before near or behind the eye).
pub const OFF_VIEW: &str = "off_view";
/// The true hit lies behind another surface in every view that contains it.
pub const HIDDEN_LAYER: &str = "hidden_layer";
/// A view would show the true hit, and what it keeps leaves it out: it faces away, or lies close behind what is kept.
pub const LEFT_OUT: &str = "left_out";
/// A view shows the true hit, but the centre of its pixel (to a rasterizer's precision) shows something else; or the
/// answer is off by no more than two pixels of the view; or a sample that is kept there was met beside its surface.
pub const BETWEEN_SAMPLES: &str = "between_samples";
/// A view shows the true hit within two of its pixels from the ray's start, where sampled methods do not look so as not
/// to find the surface that the ray starts on; or it lies in what a ray through voxels leaves out of its way.
pub const NEAR_START: &str = "near_start";
/// The surface that the ray starts on was hit: one lies there, and the answer as near.
pub const SELF_HIT: &str = "self_hit";
/// The answered hit lies behind a sample, within the thickness that the method declares.
pub const ASSUMED_THICKNESS: &str = "assumed_thickness";
/// The true hit's surface is stored at a pixel that the ray looks at, and the ray passes that sample before or behind by more than its
/// thickness. Of methods that know surfaces by samples alone.
pub const SLIPPED_THROUGH: &str = "slipped_through";
/// The ray goes through an edge or a vertex that triangles share, to rounding: each triangle's test may leave it to the other. Of methods
/// that hold the scene itself.
pub const SHARED_EDGE: &str = "shared_edge";
/// The ray lies in the plane of the triangle that is answered or truly hit, to rounding: it meets that anywhere or not at all. Of methods that
/// hold the scene itself.
pub const EDGE_ON: &str = "edge_on";
/// The sine of the angle with a plane in which rays lie, at most, and their distance from it, in scene diagonals.
const EDGE_ON_SINE: f64 = 1e-5;
const EDGE_ON_DIAGONALS: f64 = 1e-6;
/// The tracer's step limit.
pub const STEP_CAP: &str = "step_cap";
/// As `SLIPPED_THROUGH`, where the tracer says that it passed behind a surface by more than its thickness.
pub const THICKNESS_REJECTED: &str = "thickness_rejected";
/// The tracer passed through space that its last layer hides: it says so, and the ray went behind a surface that a view shows.
pub const BEHIND_LAST_LAYER: &str = "behind_last_layer";
/// The answer is right of the ray in which all numbers below the least normal one are 0: devices may take them for that.
pub const FLUSHED_DENORMALS: &str = "flushed_denormals";
/// The tracer made the hit up where its layers hide something.
pub const INPAINTED: &str = "inpainted";

impl Judge<'_> {
    /// The cause of a wrong answer; `voxels`: what explains those through voxels.
    pub(super) fn cause(&self, index: usize, hit: &Hit, class: Class, voxels: Option<&Voxels<'_>>) -> &'static str {
        if self.is_right_without_denormals(index, hit) {
            return FLUSHED_DENORMALS;
        }
        let ray = Ray64::from(&self.rays[index]);
        if matches!(class, Class::Early | Class::Late) && self.class(Rule::Footprint, index, hit) == Class::TrueHit {
            return WITHIN_FOOTPRINT;
        }
        if hit.status == Status::StepCap as u32 && voxels.is_some() {
            return STEP_CAP;
        }
        if let Some(voxels) = voxels {
            return self.cause_by_voxels(voxels, &ray, index, hit, class);
        }
        let cause = match (class, self.truth_for(index, hit)) {
            (Class::FalseMiss | Class::Late, Some(truth)) if self.marches() => self.loss_by_march(index, truth, hit),
            (Class::FalseMiss | Class::Late, Some(truth)) => self.cause_of_loss(&ray, truth, hit),
            _ => self.cause_of_invention(index, &ray, hit),
        };
        let is_open = cause == UNEXPLAINED && self.samplings.is_empty();
        if is_open && self.is_edge_on(index, &ray, hit) { EDGE_ON } else { cause }
    }

    /// Whether a ray lies in the plane of the triangle that is answered or of the one that is truly hit.
    fn is_edge_on(&self, index: usize, ray: &Ray64, hit: &Hit) -> bool {
        let answered = hit.is_hit().then(|| TrueHit { t: f64::from(hit.t), primitive: hit.primitive });
        let known = |hit: &TrueHit| (hit.primitive as usize) < self.truth.geometry().triangles.len();
        let mut found = self.truth_for(index, hit).into_iter().chain(answered).filter(known);
        found.any(|TrueHit { t, primitive }| {
            let (normal, corner) = (self.truth.normal(primitive), self.truth.geometry().corners(primitive)[0]);
            let off = (ray.at(t) - corner.as_dvec3()).dot(normal).abs();
            normal.dot(ray.direction).abs() <= EDGE_ON_SINE && off <= EDGE_ON_DIAGONALS * self.truth.diagonal()
        })
    }

    /// Whether a ray has denormal numbers, and an answer is right of the one in which they are 0.
    fn is_right_without_denormals(&self, index: usize, hit: &Hit) -> bool {
        let Ray { origin, t_min, direction, t_max } = self.rays[index];
        let flushed = |part: f32| if part.is_subnormal() { 0.0 } else { part };
        let (origin, direction) = (origin.map(flushed), direction.map(flushed));
        let ray = Ray { origin, t_min: flushed(t_min), direction, t_max: flushed(t_max) };
        if ray == self.rays[index] {
            return false;
        }
        let answers = [self.truth.answer_one(&Ray64::from(&ray), self.query)];
        let rule = if self.query == Query::Any { Rule::HitMiss } else { Rule::Tight };
        Judge { rays: &[ray], answers: &answers, ..*self }.class(rule, 0, hit).is_right()
    }

    /// Whether it is declared how rays are traced over the images.
    fn marches(&self) -> bool {
        self.samplings.iter().any(|view| view.march.is_some())
    }

    /// Why the true hit was not found, by the samples that the ray meets, or passes, where it looks about there.
    fn loss_by_march(&self, index: usize, truth: TrueHit, hit: &Hit) -> &'static str {
        let ray = &Ray64::from(&self.rays[index]);
        let (point, told) = (ray.at(truth.t), hit.is_hit().then(|| f64::from(hit.t)));
        let Some(passage) = self.passage(index, truth.t) else { return OFF_VIEW };
        let view = passage.sampling;
        let is_met = |told: f64| self.met_at(&passage, ray, told).is_some();
        let met = self.met_about(&passage, ray, truth.t, true);
        // There the march ends at the latest.
        if let Some(end) = met.into_iter().map(|(_, told)| told[1]).min_by(f64::total_cmp) {
            let end = end + tight_tolerance(end, self.truth.diagonal());
            return if told.is_some_and(|told| told <= end && is_met(told)) { BETWEEN_SAMPLES } else { UNEXPLAINED };
        }
        if !self.shows(view, point) {
            return if self.leaves_out(view, point) { LEFT_OUT } else { HIDDEN_LAYER };
        }
        if passage.leaves_out(truth.t) {
            return NEAR_START;
        }
        let keeps = |look: Look| {
            let line = view.projection.line_through(look.pixel.x + 0.5, look.pixel.y + 0.5);
            self.kept(line, view.layers).any(|found| found.primitive == truth.primitive)
        };
        let is_near = |told: f64| within_pixels(view, ray.at(told), point) && is_met(told);
        if told.is_some_and(is_near) || !passage.looks_about(truth.t).into_iter().any(keeps) {
            return BETWEEN_SAMPLES;
        }
        match Status::from_code(hit.status) {
            Some(Status::StepCap) => STEP_CAP,
            Some(Status::ThicknessRejected) => THICKNESS_REJECTED,
            _ => SLIPPED_THROUGH,
        }
    }

    /// How deep a sample lies that a ray perhaps met at t.
    fn met_at(&self, passage: &Passage<'_>, ray: &Ray64, t: f64) -> Option<f64> {
        let off = tight_tolerance(t, self.truth.diagonal());
        let met = self.met_about(passage, ray, t, false);
        met.into_iter().find(|(_, [begin, end])| (begin - off..=end + off).contains(&t)).map(|(depth, _)| depth)
    }

    /// Why the true hit was not found.
    fn cause_of_loss(&self, ray: &Ray64, truth: TrueHit, hit: &Hit) -> &'static str {
        let capped = hit.status == Status::StepCap as u32;
        if self.samplings.is_empty() {
            return match capped {
                true => STEP_CAP,
                false if self.truth.is_on_shared_edge(ray, truth) => SHARED_EDGE,
                false => UNEXPLAINED,
            };
        }
        let point = ray.at(truth.t);
        let contains = |view: &&SampledImage| view.projection.project_inside(point).is_some();
        let containing: Vec<&SampledImage> = self.samplings.iter().filter(contains).collect();
        if containing.is_empty() {
            return OFF_VIEW;
        }
        let (showing, hiding): (Vec<_>, Vec<_>) = containing.into_iter().partition(|view| self.shows(view, point));
        if showing.is_empty() {
            return if hiding.iter().any(|view| self.leaves_out(view, point)) { LEFT_OUT } else { HIDDEN_LAYER };
        }
        if capped {
            return STEP_CAP;
        }
        if !showing.iter().any(|view| self.samples(view, point, truth.primitive))
            || hit.is_hit()
                && showing.iter().any(|view| self.is_off_by_pixels(view, ray.at(f64::from(hit.t)), point, truth))
        {
            return BETWEEN_SAMPLES;
        }
        if showing.iter().all(|view| within_pixels(view, ray.origin, point)) {
            return NEAR_START;
        }
        let occluded = hit.status == Status::BehindLastLayer as u32;
        let is_behind = || showing.iter().any(|view| self.goes_behind(view, ray, truth.t));
        if occluded && is_behind() { BEHIND_LAST_LAYER } else { UNEXPLAINED }
    }

    /// Whether a ray goes behind a surface that a view shows, before t.
    fn goes_behind(&self, view: &SampledImage, ray: &Ray64, t: f64) -> bool {
        between(ray.t_min, t).map(|t| ray.at(t)).any(|point| {
            let Some(at) = view.projection.project_inside(point) else { return false };
            let line = view.projection.line_through(at.x.floor() + 0.5, at.y.floor() + 0.5);
            let far = at.depth - SELF_HIT_PIXELS * self.footprint(point);
            self.along(LineOfSight { far, ..line }).next().is_some()
        })
    }

    /// Why something was hit that is not there.
    fn cause_of_invention(&self, index: usize, ray: &Ray64, hit: &Hit) -> &'static str {
        if hit.status == Status::Inpainted as u32 {
            return INPAINTED;
        }
        let t = f64::from(hit.t);
        let point = ray.at(t);
        if self.is_near_start(ray, t) {
            return SELF_HIT;
        }
        if self.marches() {
            // What is told where a ray enters or leaves a view may lie outside of it by rounding.
            let off = tight_tolerance(t, self.truth.diagonal());
            let passage = [t, t + off, t - off].into_iter().find_map(|near| self.passage(index, near));
            let met = passage.and_then(|passage| Some((self.met_at(&passage, ray, t)?, passage.view.project(point)?)));
            return match met {
                Some((stored, at)) if at.depth > stored + self.footprint(point) => ASSUMED_THICKNESS,
                Some(_) => BETWEEN_SAMPLES,
                None => UNEXPLAINED,
            };
        }
        // A surface that a pixel shows was met beside it: on its plane, or at the depth that the pixel's centre shows. What is told where
        // a ray enters or leaves a view may lie outside of it by rounding.
        let off = SELF_HIT_PIXELS * self.footprint(point) / ray.direction.length();
        let shows = |view: &SampledImage| {
            let mut points = [t, t + off, t - off].map(|near| ray.at(near)).into_iter();
            points.find_map(|near| Some((near, view.projection.project_inside(near)?))).is_some_and(|(near, at)| {
                let edge = view.projection.pixel_at(at.depth).length();
                self.is_on_plane_within(ray, t, edge, off) || self.is_shown_beside(view, near)
            })
        };
        if self.samplings.iter().any(shows) { BETWEEN_SAMPLES } else { UNEXPLAINED }
    }

    /// Whether a pixel next to the one that a point falls on shows a surface at the point's depth, to a few footprints.
    fn is_shown_beside(&self, view: &SampledImage, point: DVec3) -> bool {
        let Some(at) = view.projection.project_inside(point) else { return false };
        let near = SELF_HIT_PIXELS * self.footprint(point);
        let beside = [-1.0, 0.0, 1.0].map(|moved: f64| moved + 0.5);
        beside.into_iter().flat_map(|y| beside.map(|x| (at.x.floor() + x, at.y.floor() + y))).any(|(x, y)| {
            let line = view.projection.line_through(x, y);
            self.kept(line, view.layers).any(|found| (found.t - at.depth).abs() <= near)
        })
    }

    /// Whether a wrong hit counts as one with the surface that the ray starts on.
    pub(super) fn is_near_start(&self, ray: &Ray64, t: f64) -> bool {
        let near = (SELF_HIT_PIXELS * self.footprint(ray.origin)).max(tight_tolerance(0.0, self.truth.diagonal()));
        t * ray.direction.length() <= near && self.truth.nearest(ray.origin, near).is_some()
    }

    /// Whether an answer is off by pixels of a view alone: it falls on one nearby, and lies as near to the true hit's plane.
    fn is_off_by_pixels(&self, view: &SampledImage, answered: DVec3, point: DVec3, truth: TrueHit) -> bool {
        let edge = view.projection.project(point).map_or(0.0, |at| view.projection.pixel_at(at.depth).length());
        let off = self.truth.normal(truth.primitive).dot(answered - point).abs();
        within_pixels(view, answered, point) && off <= VIEW_PIXELS * edge
    }

    /// Whether a view keeps what lies at a point: more layers than lie before it, and nothing leaves it out.
    fn shows(&self, view: &SampledImage, point: DVec3) -> bool {
        if view.layers == Layers::All {
            return true;
        }
        if matches!(view.layers, Layers::Chosen { .. }) {
            let reach = self.footprint(point);
            return self.kept_along(view, point).any(|(depth, found)| (found.t - depth).abs() <= reach);
        }
        let line = view.projection.line_to(point);
        let before = LineOfSight { far: (line.far - self.footprint(point)).max(line.near), ..line };
        let most = view.layers.most();
        self.along(before).take(most).count() < most
    }

    /// Whether a view has a layer left for what lies at a point, which it does not keep.
    fn leaves_out(&self, view: &SampledImage, point: DVec3) -> bool {
        let reach = self.footprint(point);
        let before = self.kept_along(view, point).filter(|(depth, found)| found.t < depth - reach).count();
        matches!(view.layers, Layers::Chosen { .. }) && before < view.layers.most()
    }

    /// What a view keeps along the line of sight through a point, each beside the point's own depth.
    fn kept_along(&self, view: &SampledImage, point: DVec3) -> impl Iterator<Item = (f64, TrueHit)> {
        let at = view.projection.project(point);
        at.into_iter().flat_map(|at| {
            self.kept(view.projection.line_through(at.x, at.y), view.layers).map(move |found| (at.depth, found))
        })
    }

    /// Whether the centre of the pixel that a point falls on, moved by a rasterizer's rounding in any direction, shows
    /// the same triangle or one within a footprint in depth, in any layer where all are kept; on a border between pixels, the centres of
    /// all of them.
    fn samples(&self, view: &SampledImage, point: DVec3, primitive: u32) -> bool {
        let Some(at) = view.projection.project_inside(point) else { return false };
        let moves = [(0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        centres(&at).into_iter().all(|centre| {
            moves.into_iter().all(|(across, down)| {
                let (x, y) = (centre.0 + across * RASTER_SNAP_PIXELS, centre.1 + down * RASTER_SNAP_PIXELS);
                let is_it = |found: &TrueHit| {
                    found.primitive == primitive || (found.t - at.depth).abs() <= self.footprint(point)
                };
                let line = view.projection.line_through(x, y);
                self.kept(line, view.layers).any(|found| is_it(&found))
            })
        })
    }

    /// The surfaces along a line of sight that are kept; of lines whose lengths are depths.
    pub(super) fn kept(&self, line: LineOfSight, layers: Layers) -> impl Iterator<Item = TrueHit> {
        let (separation, back_faces) = match layers {
            Layers::Chosen { separation, back_faces, .. } => (separation, back_faces),
            _ => (0.0, true),
        };
        let direction = line.direction;
        let mut before = f64::NEG_INFINITY;
        let keeps = move |found: &TrueHit| {
            let faces = back_faces || self.truth.normal(found.primitive).dot(direction) < 0.0;
            let kept = faces && found.t - before > separation;
            before = if kept { found.t } else { before };
            kept
        };
        self.along(line).filter(keeps).take(layers.most())
    }

    /// The surfaces along a line of sight, the nearest first.
    pub(super) fn along(&self, line: LineOfSight) -> impl Iterator<Item = TrueHit> {
        let LineOfSight { origin, direction, near, far } = line;
        let from = move |t_min: f64| self.truth.closest(&Ray64 { origin, direction, t_min, t_max: far });
        // A surface at depth 0 is passed, too.
        let next = move |found: &TrueHit| from((found.t * (1.0 + LAYER_STEP)).max(found.t.next_up()));
        std::iter::successors(from(near), next).take(MAX_LAYERS)
    }
}

/// Whether two points count as the same sample of a view.
fn within_pixels(view: &SampledImage, from: DVec3, to: DVec3) -> bool {
    let (from, to) = (view.projection.project(from), view.projection.project(to));
    from.zip(to).is_some_and(|(from, to)| (from.x - to.x).abs().max((from.y - to.y).abs()) <= VIEW_PIXELS)
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
