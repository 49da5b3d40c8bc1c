//! Why an answer is wrong. The judge finds out by itself: it projects the true and the answered hit into the images that
//! the tracer samples the scene by, here called views, and asks the f64 truth what these show. Of the tracer it takes only
//! the status.

use glam::DVec3;
use tracebench_api::{Hit, Layers, LineOfSight, Projected, Projection, Sampling, Status};

use super::march::{Look, Passage, Sure};
use super::voxels::Voxels;
use super::{Class, Judge, Rule};
use crate::results::UNEXPLAINED;
use crate::truth::{Ray64, TrueHit, tight_tolerance};

/// Pixels of a view within which two points count as the same sample of it.
const VIEW_PIXELS: f64 = 2.0;

/// Pixels of a view by which a rasterizer may move an edge: twice the 1/256 that Vulkan asks for at least, four times
/// over for the two vertices of an edge.
pub(super) const RASTER_SNAP_PIXELS: f64 = 1.0 / 64.0;

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
/// A view would show the true hit, and what it keeps leaves it out: it faces away, or lies close behind what is kept.
pub const LEFT_OUT: &str = "left_out";
/// A view shows the true hit, but the centre of its pixel (to a rasterizer's precision) shows something else; or the
/// answer is off by no more than two pixels of the view; or a surface that the pixel's centre shows was hit beside it.
pub const BETWEEN_SAMPLES: &str = "between_samples";
/// A view shows the true hit within two of its pixels from the ray's start, where sampled methods do not look so as not
/// to find the surface that the ray starts on; or it lies in what a ray through voxels leaves out of its way.
pub const NEAR_START: &str = "near_start";
/// The surface that the ray starts on was hit.
pub const SELF_HIT: &str = "self_hit";
/// The answered hit lies behind what the view shows there: a surface was taken to be thick.
pub const ASSUMED_THICKNESS: &str = "assumed_thickness";
/// The true hit's surface is stored at its pixel of a view, and the ray was let through: it passed between that fragment and the
/// next one, or between the pixels that were looked at. Of methods that know surfaces by samples alone; of those that keep no more
/// than the nearest, only where the ray is outside of the pixel when it is as deep as the pixel's centre.
pub const SLIPPED_THROUGH: &str = "slipped_through";
/// The tracer's step limit.
pub const STEP_CAP: &str = "step_cap";
/// The tracer passed behind a surface by more than its thickness.
pub const THICKNESS_REJECTED: &str = "thickness_rejected";
/// The tracer passed through space that its last layer hides.
pub const OCCLUDED: &str = "occluded";
/// The tracer made the hit up where its layers hide something.
pub const INPAINTED: &str = "inpainted";

impl Judge<'_> {
    /// The cause of a wrong answer; `voxels`: what explains those through voxels.
    pub(super) fn cause(&self, index: usize, hit: &Hit, class: Class, voxels: Option<&Voxels<'_>>) -> &'static str {
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
        let marched = self.samplings.iter().any(|view| view.march.is_some());
        match (class, self.truth_for(index, hit)) {
            (Class::FalseMiss | Class::Late, Some(truth)) if marched => {
                self.loss_by_march(&self.passages(index), &ray, truth, hit)
            }
            (Class::FalseMiss | Class::Late, Some(truth)) => self.cause_of_loss(&ray, truth, hit),
            _ => self.cause_of_invention(index, &ray, hit),
        }
    }

    /// Why the true hit was not found where it is declared how rays are traced over the images: by the samples that the ray meets, or passes,
    /// where it looks about there.
    fn loss_by_march(&self, passages: &[Passage<'_>], ray: &Ray64, truth: TrueHit, hit: &Hit) -> &'static str {
        let (point, told) = (ray.at(truth.t), hit.is_hit().then(|| f64::from(hit.t)));
        let Some(passage) = passages.iter().find(|passage| passage.has(truth.t)) else { return OFF_VIEW };
        let looks = passage.looks_about(truth.t);
        let meets = |look: &&Look| self.meets(passage, ray, look, truth.t, Sure::Surely).is_some();
        let met: Vec<&Look> = looks.iter().filter(meets).collect();
        if !met.is_empty() {
            let is_there = told.is_some_and(|told| met.iter().any(|look| look.has(told, 0.0)));
            return if is_there && passage.is_of_points() { BETWEEN_SAMPLES } else { UNEXPLAINED };
        }
        if !self.shows(passage.sampling, point) {
            return if self.leaves_out(passage.sampling, point) { LEFT_OUT } else { HIDDEN_LAYER };
        }
        if passage.leaves_out(truth.t) {
            return NEAR_START;
        }
        let near = |told: f64| {
            within_pixels(passage.sampling, ray.at(told), point) && self.met_at(passage, ray, told).is_some()
        };
        let keeps = |look: &Look| self.keeps(passage.sampling, look, point, truth.primitive);
        if told.is_some_and(near) || !looks.iter().any(keeps) {
            return BETWEEN_SAMPLES;
        }
        match Status::from_code(hit.status) {
            Some(Status::StepCap) => STEP_CAP,
            Some(Status::ThicknessRejected) => THICKNESS_REJECTED,
            _ => SLIPPED_THROUGH,
        }
    }

    /// How deep a sample lies that a ray may have met at t, where it looks about there.
    fn met_at(&self, passage: &Passage<'_>, ray: &Ray64, t: f64) -> Option<f64> {
        let off = tight_tolerance(t, self.truth.diagonal());
        let looks = passage.looks_about(t).into_iter().filter(|look| look.has(t, off));
        looks.into_iter().find_map(|look| self.meets(passage, ray, &look, t, Sure::Perhaps))
    }

    /// Why the true hit was not found.
    fn cause_of_loss(&self, ray: &Ray64, truth: TrueHit, hit: &Hit) -> &'static str {
        let capped = hit.status == Status::StepCap as u32;
        if self.samplings.is_empty() {
            return if capped { STEP_CAP } else { UNEXPLAINED };
        }
        let point = ray.at(truth.t);
        let contains = |view: &&Sampling| view.projection.project_inside(point).is_some();
        let containing: Vec<&Sampling> = self.samplings.iter().filter(contains).collect();
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
            || hit.is_hit() && showing.iter().any(|view| within_pixels(view, ray.at(f64::from(hit.t)), point))
        {
            return BETWEEN_SAMPLES;
        }
        if showing.iter().all(|view| within_pixels(view, ray.origin, point)) {
            return NEAR_START;
        }
        match Status::from_code(hit.status) {
            Some(Status::ThicknessRejected) => THICKNESS_REJECTED,
            Some(Status::Occluded) => OCCLUDED,
            _ if !self.names_primitives
                && (showing.iter().any(|view| view.layers != Layers::Nearest)
                    || showing.iter().all(|view| self.passes_beside(&view.projection, ray, truth.t))) =>
            {
                SLIPPED_THROUGH
            }
            _ => UNEXPLAINED,
        }
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
        let behind = |stored: f64, depth: f64| match depth > stored + self.footprint(point) {
            true => ASSUMED_THICKNESS,
            false => BETWEEN_SAMPLES,
        };
        if self.samplings.iter().any(|view| view.march.is_some()) {
            let met = self.passages(index).into_iter().find_map(|passage| {
                let depth = passage.view.project(point)?.depth;
                self.met_at(&passage, ray, t).map(|stored| behind(stored, depth))
            });
            return met.unwrap_or(UNEXPLAINED);
        }
        // What is told where a ray enters or leaves a view may lie outside of it by rounding.
        let pixels = VIEW_PIXELS * self.footprint(point) / ray.direction.length();
        let inside = |projection: &Projection| {
            let points = [t, t + pixels, t - pixels].map(|near| ray.at(near));
            points.into_iter().find_map(|near| projection.project_inside(near).map(|at| (near, at.depth)))
        };
        let containing = self.samplings.iter().filter_map(|view| Some((view, inside(&view.projection)?)));
        for (view, (point, depth)) in containing.clone() {
            let Some(stored) = self.centre_depth(&view.projection, point) else { continue };
            return behind(stored, depth);
        }
        // Nothing is shown there: a surface that a pixel beside it shows was met at its own depth.
        if containing.into_iter().any(|(view, (point, _))| self.is_shown_beside(view, point)) {
            return BETWEEN_SAMPLES;
        }
        UNEXPLAINED
    }

    /// Whether a ray that hits the surface of a pixel at `t` is outside of that pixel where it is as deep as the surface at the
    /// pixel's centre: one that takes each pixel for a plane at the depth of its centre passes before it or behind.
    fn passes_beside(&self, projection: &Projection, ray: &Ray64, t: f64) -> bool {
        let point = ray.at(t);
        let Some((at, stored)) = projection.project(point).zip(self.centre_depth(projection, point)) else {
            return false;
        };
        // Depth is linear along a ray.
        let step = self.footprint(point) / ray.direction.length();
        let Some(ahead) = projection.project(ray.at(t + step)) else { return false };
        let meets = t + (stored - at.depth) / (ahead.depth - at.depth) * step;
        let outside =
            |met: f64, pixel: f64| !(pixel - RASTER_SNAP_PIXELS..=pixel + 1.0 + RASTER_SNAP_PIXELS).contains(&met);
        !meets.is_finite()
            || projection
                .project(ray.at(meets))
                .is_none_or(|met| outside(met.x, at.x.floor()) || outside(met.y, at.y.floor()))
    }

    /// Whether a pixel next to the one that a point falls on shows a surface at the point's depth, to a few footprints.
    fn is_shown_beside(&self, view: &Sampling, point: DVec3) -> bool {
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

    /// Whether a view keeps what lies at a point: more layers than lie before it, and nothing leaves it out.
    fn shows(&self, view: &Sampling, point: DVec3) -> bool {
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
    fn leaves_out(&self, view: &Sampling, point: DVec3) -> bool {
        let reach = self.footprint(point);
        let before = self.kept_along(view, point).filter(|(depth, found)| found.t < depth - reach).count();
        matches!(view.layers, Layers::Chosen { .. }) && before < view.layers.most()
    }

    /// What a view keeps along the line of sight through a point, each beside the point's own depth.
    fn kept_along(&self, view: &Sampling, point: DVec3) -> impl Iterator<Item = (f64, TrueHit)> {
        let at = view.projection.project(point);
        at.into_iter().flat_map(|at| {
            self.kept(view.projection.line_through(at.x, at.y), view.layers).map(move |found| (at.depth, found))
        })
    }

    /// Whether the centre of the pixel that a point falls on, moved by a rasterizer's rounding in any direction, shows
    /// the same triangle or one within a footprint in depth, in any layer where all are kept; on a border between pixels, the centres of all of them.
    fn samples(&self, view: &Sampling, point: DVec3, primitive: u32) -> bool {
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

    /// Whether an image keeps, at the pixel of a look, the surface of a point: its triangle, or one as deep within a footprint.
    fn keeps(&self, view: &Sampling, look: &Look, point: DVec3, primitive: u32) -> bool {
        let Some(at) = view.projection.project(point) else { return false };
        let line = view.projection.line_through(look.pixel.x + 0.5, look.pixel.y + 0.5);
        let reach = self.footprint(point);
        self.kept(line, view.layers).any(|found| found.primitive == primitive || (found.t - at.depth).abs() <= reach)
    }

    /// The depth at the centre of the pixel that a point falls on; on a border between pixels, to a rasterizer's
    /// precision, of a neighbour if its own centre shows nothing.
    fn centre_depth(&self, projection: &Projection, point: DVec3) -> Option<f64> {
        let at = projection.project_inside(point)?;
        let shown = |(x, y)| self.along(projection.line_through(x, y)).next();
        centres(&at).into_iter().find_map(shown).map(|found| found.t)
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
        std::iter::successors(from(near), next).take(MOST_LAYERS)
    }
}

/// Whether two points count as the same sample of a view.
fn within_pixels(view: &Sampling, from: DVec3, to: DVec3) -> bool {
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
