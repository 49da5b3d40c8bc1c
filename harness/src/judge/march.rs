//! Where a ray looks at a method's images on its way, as the method declares it, and whether what it meets there is a sample that
//! the scene truly has. Nothing here is asked of the method's structure, which may be what is wrong.

use glam::{DVec2, DVec3};
use tracebench_api::{ImageMarch, LineOfSight, MarchSteps, Projection, Ray, SampleShape, Sampling, View};

use super::Judge;
use super::causes::RASTER_SNAP_PIXELS;
use crate::truth::{Ray64, TrueHit, nearest_point, tight_tolerance};

/// Relative size of what a trace in f32 may be off in depth.
const DEPTH_ROUNDING: f64 = 1e-5;

/// The same of what the judge tells of a parameter.
const T_ROUNDING: f64 = 1e-9;

/// The part of a ray in one image: a line there, along which positions, 1 / depth and t / depth are linear. Places on it run from 0 to 1.
pub(super) struct Passage<'a> {
    pub sampling: &'a Sampling,
    pub view: &'a View,
    march: ImageMarch,
    /// Where a ray looks in steps of its own, a share.
    share: f64,
    span: [f64; 2],
    from: DVec2,
    across: DVec2,
    inverse_depths: [f64; 2],
    ts_over_depth: [f64; 2],
    /// Where the search begins.
    first: f64,
}

/// A look at one pixel, for a part of the ray.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub pixel: DVec2,
    pub span: [f64; 2],
}

impl Look {
    /// Whether it is for a part of the ray that has a parameter, which may be off by so much.
    pub(super) fn has(&self, t: f64, off: f64) -> bool {
        let off = off + T_ROUNDING * t;
        (self.span[0] - off..=self.span[1] + off).contains(&t)
    }
}

/// How sure it must be that a look meets a sample, whatever a rasterizer's and f32's rounding do.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Sure {
    Surely,
    Perhaps,
}

fn lerp([begin, end]: [f64; 2], share: f64) -> f64 {
    begin * (1.0 - share) + end * share
}

/// The part of a span in which a ray lies in a view.
fn span_in_view(view: &View, ray: &Ray64, span: [f64; 2]) -> [f64; 2] {
    let seen = |vector: DVec3| [view.right, view.up, view.forward].map(|axis| vector.dot(axis));
    let ([x, y, z], [dx, dy, dz]) = (seen(ray.origin - view.eye), seen(ray.direction));
    let (width, height) = (view.tan_half_width, view.tan_half_height);
    let sides = [
        (z - view.near, dz),
        (view.far - z, -dz),
        (z * width - x, dz * width - dx),
        (z * width + x, dz * width + dx),
        (z * height - y, dz * height - dy),
        (z * height + y, dz * height + dy),
    ];
    sides.into_iter().fold(span, |[begin, end], (value, slope)| {
        let at = -value / slope;
        match slope {
            0.0 => [begin, if value < 0.0 { f64::NEG_INFINITY } else { end }],
            _ if slope > 0.0 => [begin.max(at), end],
            _ => [begin, end.min(at)],
        }
    })
}

impl<'a> Passage<'a> {
    /// `None` of an image over which no march is declared.
    fn new(sampling: &'a Sampling, (original, ray): (&Ray, &Ray64), span: [f64; 2], starts: bool) -> Option<Self> {
        let (Projection::Perspective(view), Some(march)) = (&sampling.projection, sampling.march) else { return None };
        let [begin, end] = [view.project(ray.at(span[0]))?, view.project(ray.at(span[1]))?];
        let from = DVec2::new(begin.x, begin.y);
        let across = DVec2::new(end.x, end.y) - from;
        let inverse_depths = [1.0 / begin.depth, 1.0 / end.depth];
        let skipped = march.start_bias / across.abs().max_element().max(1e-6);
        Some(Self {
            sampling,
            view,
            march,
            share: if let MarchSteps::Equal { looks_at, .. } = march.steps { looks_at(original) } else { 0.0 },
            span,
            from,
            across,
            inverse_depths,
            ts_over_depth: [span[0] * inverse_depths[0], span[1] * inverse_depths[1]],
            first: if starts { skipped.min(1.0) } else { 0.0 },
        })
    }

    /// Whether a ray is in the image at t.
    pub(super) fn has(&self, t: f64) -> bool {
        let off = T_ROUNDING * t;
        (self.span[0] - off..=self.span[1] + off).contains(&t)
    }

    fn t_at(&self, place: f64) -> f64 {
        lerp(self.ts_over_depth, place) / lerp(self.inverse_depths, place)
    }

    /// Whether samples are points, so that a hit may be anywhere on the part of the ray that is looked at.
    pub(super) fn is_of_points(&self) -> bool {
        matches!(self.march.samples, SampleShape::Point { .. })
    }

    fn place_of(&self, t: f64) -> f64 {
        let ([over, over_end], [inverse, inverse_end]) = (self.ts_over_depth, self.inverse_depths);
        let place = (t * inverse - over) / (over_end - over - t * (inverse_end - inverse));
        if place.is_finite() { place.clamp(0.0, 1.0) } else { 0.0 }
    }

    fn pixel_at(&self, place: f64) -> DVec2 {
        let last = DVec2::from(self.view.size.map(f64::from)) - 1.0;
        (self.from + self.across * place).floor().clamp(DVec2::ZERO, last)
    }

    /// Whether what a ray meets at t lies before the search begins.
    pub(super) fn leaves_out(&self, t: f64) -> bool {
        self.place_of(t) < self.first
    }

    /// The places between which the line is in a pixel.
    fn places_in(&self, pixel: DVec2) -> [f64; 2] {
        let [one, other] = [pixel - self.from, pixel + 1.0 - self.from].map(|way| way / self.across);
        let (enters, leaves) = (one.min(other), one.max(other));
        let crossed = |axis: usize| self.across[axis] != 0.0;
        let ends = [0, 1].into_iter().filter(|axis| crossed(*axis)).map(|axis| [enters[axis], leaves[axis]]);
        ends.fold([self.first, 1.0], |[begin, end], [enters, leaves]| [begin.max(enters), end.min(leaves)])
    }

    /// The look for the part of the ray that has a parameter, with those before and after it.
    pub(super) fn looks_about(&self, t: f64) -> Vec<Look> {
        let (at, major) = (self.place_of(t), self.across.abs().max_element());
        let look = |pixel, [begin, end]: [f64; 2]| {
            (begin <= end).then(|| Look { pixel, span: [self.t_at(begin), self.t_at(end)] })
        };
        let about = |middle: f64, count: f64| {
            [-1.0, 0.0, 1.0].map(|moved| middle + moved).into_iter().filter(move |each| (0.0..count).contains(each))
        };
        match self.march.steps {
            MarchSteps::EveryPixel => {
                let here = self.places_in(self.pixel_at(at));
                let beside = 1e-6 / major.max(1e-6);
                let mut pixels = [here[0] - beside, at, here[1] + beside].map(|place| self.pixel_at(place)).to_vec();
                pixels.dedup();
                pixels.into_iter().filter_map(|pixel| look(pixel, self.places_in(pixel))).collect()
            }
            MarchSteps::Stride(stride) => {
                let step = (stride / major.max(1e-6)).min(1.0);
                let place = |sample: f64| (self.first + sample * step).min(1.0);
                let reach = |sample: f64| match place(sample) {
                    at if at + step > 1.0 || step == 1.0 => 1.0,
                    at => at + 0.5 * step,
                };
                let low = |sample: f64| if sample == 0.0 { self.first } else { reach(sample - 1.0) };
                let samples = about(((at - self.first) / step).round(), f64::INFINITY);
                let taken = samples.filter(|sample| low(*sample) < 1.0);
                taken.filter_map(|sample| look(self.pixel_at(place(sample)), [low(sample), reach(sample)])).collect()
            }
            MarchSteps::Equal { most, within_pixel, .. } => {
                let rest = 1.0 - self.first;
                let count = (major * rest).ceil().clamp(1.0, f64::from(most));
                let steps = about(((at - self.first) / rest * count).floor().min(count - 1.0), count);
                let looks = steps.filter_map(|step| {
                    let [low, high] = [step, step + 1.0].map(|step| self.first + rest * step / count);
                    let pixel = self.pixel_at(lerp([low, high], self.share));
                    let [enters, leaves] = if within_pixel { self.places_in(pixel) } else { [low, high] };
                    look(pixel, [low.max(enters), high.min(leaves)])
                });
                looks.collect()
            }
        }
    }
}

impl Judge<'_> {
    /// A ray's way through images over which a march is declared: through the first where it lies in that, else through the others,
    /// one after the other as it enters them.
    pub(super) fn passages(&self, index: usize) -> Vec<Passage<'_>> {
        let ray = Ray64::from(&self.rays[index]);
        let Some((first, others)) = self.samplings.split_first() else { return Vec::new() };
        let within = |sampling: &Sampling, span: [f64; 2]| match &sampling.projection {
            Projection::Perspective(view) if sampling.march.is_some() => span_in_view(view, &ray, span),
            _ => [f64::INFINITY, f64::NEG_INFINITY],
        };
        let whole = [ray.t_min, ray.t_max];
        let [enters, leaves] = within(first, whole);
        let seen = enters <= leaves;
        let stages = if seen { [[ray.t_min, enters], [leaves, ray.t_max]] } else { [whole, [0.0, -1.0]] };
        let mut found = Vec::new();
        for (stage, [mut now, limit]) in stages.into_iter().enumerate() {
            if stage == 1 && seen {
                found.push((first, [enters, leaves]));
            }
            let mut left: Vec<&Sampling> = others.iter().collect();
            while now < limit {
                let spans = left.iter().map(|sampling| within(sampling, [now, limit])).enumerate();
                let entered = spans.filter(|(_, [begin, end])| begin <= end).min_by(|a, b| a.1[0].total_cmp(&b.1[0]));
                let Some((place, span)) = entered else { break };
                found.push((left.remove(place), span));
                now = span[1];
            }
        }
        let both = (&self.rays[index], &ray);
        let starts = |number: usize, span: [f64; 2]| number == 0 && span[0] <= ray.t_min;
        let passages = found.into_iter().enumerate();
        passages.filter_map(|(number, (each, span))| Passage::new(each, both, span, starts(number, span))).collect()
    }

    /// Of what an image keeps at the pixel of a look, what the look meets at t, or, of points, anywhere: how deep the surface lies.
    pub(super) fn meets(&self, passage: &Passage<'_>, ray: &Ray64, look: &Look, t: f64, sure: Sure) -> Option<f64> {
        let view = passage.view;
        let depth_at = |t: f64| (ray.at(t) - view.eye).dot(view.forward);
        let pixel = 2.0 * DVec2::new(view.tan_half_width, view.tan_half_height) / DVec2::from(view.size.map(f64::from));
        let centre = look.pixel + 0.5;
        let line = passage.sampling.projection.line_through(centre.x, centre.y);
        let mut kept = self.kept(line, passage.sampling.layers);
        match passage.march.samples {
            SampleShape::Point { thickness, thickness_in_pixels, to_back_faces } => {
                let ends = look.span.map(depth_at);
                let (near, far) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                let thickness = thickness + far * pixel.max_element() * thickness_in_pixels;
                let rounding = DEPTH_ROUNDING * far * if sure == Sure::Surely { -1.0 } else { 1.0 };
                let is_met = |found: &TrueHit| {
                    let [least, most] = self.snapped_depths(passage, centre, found);
                    let [begin, end] = if sure == Sure::Surely { [most, least] } else { [least, most] };
                    let back = if to_back_faces { self.back_behind(line, found.t) } else { None };
                    let end = back.unwrap_or(end + thickness.max(0.0));
                    begin + thickness.min(0.0) <= far + rounding && end >= near - rounding
                };
                kept.find(is_met).map(|found| found.t)
            }
            SampleShape::Plane { outline, .. } if sure == Sure::Perhaps => {
                let part = pixel * depth_at(t) / DVec2::from(outline.map(f64::from));
                let reach = (1.0 + RASTER_SNAP_PIXELS) * part.length();
                self.is_on_plane_within(ray, t, reach).then(|| depth_at(t))
            }
            SampleShape::Plane { conservative, .. } => {
                let at = view.project(ray.at(t))?;
                let here = look.has(t, 0.0) && DVec2::new(at.x, at.y).floor() == look.pixel;
                let here_alone = Ray64 { t_min: t * (1.0 - T_ROUNDING), t_max: t * (1.0 + T_ROUNDING), ..*ray };
                let truth = self.truth.closest(&here_alone).filter(|_| here)?;
                let stored = conservative || kept.any(|kept| kept.primitive == truth.primitive);
                stored.then_some(at.depth)
            }
        }
    }

    /// Between which depths the sample of a surface at a pixel's centre is, for all that a rasterizer may move it.
    fn snapped_depths(&self, passage: &Passage<'_>, centre: DVec2, found: &TrueHit) -> [f64; 2] {
        let normal = self.truth.normal(found.primitive);
        let across = normal.dot(self.truth.geometry().corners(found.primitive)[0].as_dvec3() - passage.view.eye);
        let moves = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        let moved = moves.map(|(x, y)| centre + RASTER_SNAP_PIXELS * DVec2::new(x, y));
        let depths = moved.map(|at| across / normal.dot(passage.view.direction_through(at.x, at.y)));
        depths.into_iter().fold([found.t; 2], |[least, most], depth| [least.min(depth), most.max(depth)])
    }

    /// How deep the next surface lies behind a depth that faces away.
    fn back_behind(&self, line: LineOfSight, depth: f64) -> Option<f64> {
        let behind = LineOfSight { near: depth.next_up(), ..line };
        self.along(behind).find(|found| self.truth.normal(found.primitive).dot(line.direction) > 0.0).map(|back| back.t)
    }

    /// Whether a ray is at t on the plane of a triangle that is no farther than this.
    fn is_on_plane_within(&self, ray: &Ray64, t: f64, reach: f64) -> bool {
        let (point, tolerance) = (ray.at(t), 2.0 * tight_tolerance(t, self.truth.diagonal()));
        let mut found = false;
        self.truth.in_box(point - reach, point + reach, |primitive| {
            let corners = self.truth.geometry().corners(primitive).map(|corner| corner.as_dvec3());
            let normal = self.truth.normal(primitive);
            let off = normal.dot(corners[0] - point) / normal.dot(ray.direction);
            found = found || off.abs() <= tolerance && nearest_point(point, corners).distance(point) <= reach;
        });
        found
    }
}
