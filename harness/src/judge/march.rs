//! Where a ray looks at a method's images on its way, as the method declares it, and what it meets there of the samples that the
//! scene has. Nothing is asked of the method's structure, which may be what is wrong.

use glam::DVec2;
use tracebench_api::{ImageMarch, LineOfSight, MarchSteps, Projection, SampledImage, View};

use super::Judge;
use super::causes::RASTER_SNAP_PIXELS;
use crate::truth::{Ray64, TrueHit, nearest_point};

/// What f32 may be off, relative: in depth, and of what is computed in f64 in both places, in t.
const DEPTH_ROUNDING: f64 = 1e-5;
const T_ROUNDING: f64 = 1e-9;

/// The part of a ray in one image: a line there, along which positions, 1 / depth and t / depth are linear. Places on it run from 0 to 1.
pub(super) struct Passage<'a> {
    pub sampling: &'a SampledImage,
    pub view: &'a View,
    march: ImageMarch,
    /// Where in equal steps the ray looks, a share.
    share: f64,
    from: DVec2,
    across: DVec2,
    inverse_depths: [f64; 2],
    ts_over_depth: [f64; 2],
    /// Where the search begins.
    first: f64,
}

/// A look at one pixel, for a part of the ray.
pub(super) struct Look {
    pub pixel: DVec2,
    span: [f64; 2],
}

fn lerp([begin, end]: [f64; 2], share: f64) -> f64 {
    begin * (1.0 - share) + end * share
}

/// The part of a span in which a ray lies in a view.
fn span_in_view(view: &View, ray: &Ray64, span: [f64; 2]) -> [f64; 2] {
    let (wide, high) = (view.forward * view.tan_half_width, view.forward * view.tan_half_height);
    let sides = [wide + view.right, wide - view.right, high + view.up, high - view.up].map(|side| (side, 0.0));
    let ends = [(view.forward, view.near), (-view.forward, -view.far)];
    sides.into_iter().chain(ends).fold(span, |[begin, end], (normal, least)| {
        let (value, slope) = (normal.dot(ray.origin - view.eye) - least, normal.dot(ray.direction));
        match -value / slope {
            at if slope > 0.0 => [begin.max(at), end],
            at if slope < 0.0 => [begin, end.min(at)],
            _ => [begin, if value < 0.0 { f64::NEG_INFINITY } else { end }],
        }
    })
}

impl Passage<'_> {
    fn t_at(&self, place: f64) -> f64 {
        lerp(self.ts_over_depth, place) / lerp(self.inverse_depths, place)
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

    /// Between which of two places the line is in a pixel.
    fn places_in(&self, pixel: DVec2, within: [f64; 2]) -> [f64; 2] {
        let [one, other] = [pixel, pixel + 1.0].map(|border| (border - self.from) / self.across);
        let crossed = [0, 1].into_iter().filter(|axis| self.across[*axis] != 0.0);
        crossed.fold(within, |[begin, end], axis| {
            [begin.max(one[axis].min(other[axis])), end.min(one[axis].max(other[axis]))]
        })
    }

    /// The look for the part of the ray that has a parameter, with those before and after it.
    pub(super) fn looks_about(&self, t: f64) -> Vec<Look> {
        let (at, major, first) = (self.place_of(t), self.across.abs().max_element().max(1e-6), self.first);
        let look = |pixel, [begin, end]: [f64; 2]| {
            (begin <= end).then(|| Look { pixel, span: [begin, end].map(|place| self.t_at(place)) })
        };
        let (begin, step, share) = match self.march.steps {
            MarchSteps::EveryPixel => {
                let here = self.places_in(self.pixel_at(at), [first, 1.0]);
                let places = [here[0] - 1e-6 / major, at, here[1] + 1e-6 / major];
                let mut pixels = places.map(|place| self.pixel_at(place)).to_vec();
                pixels.dedup();
                return pixels
                    .into_iter()
                    .filter_map(|pixel| look(pixel, self.places_in(pixel, [first, 1.0])))
                    .collect();
            }
            MarchSteps::Stride(stride) => {
                let step = (stride / major).min(1.0);
                (first - 0.5 * step, step, 0.5)
            }
            MarchSteps::Equal { most, .. } => {
                let count = (major * (1.0 - first)).ceil().clamp(1.0, f64::from(most));
                (first, (1.0 - first) / count, self.share)
            }
        };
        let within_pixel = matches!(self.march.steps, MarchSteps::Equal { within_pixel: true, .. });
        let number = ((at - begin) / step).floor();
        let numbers = [number - 1.0, number, number + 1.0].into_iter().filter(|number| *number >= 0.0);
        let looks = numbers.filter_map(|number| {
            let (low, place) = ((begin + number * step).max(first), begin + (number + share) * step);
            // The last takes what is left.
            let high = if place + step > 1.0 { 1.0 } else { begin + (number + 1.0) * step };
            let pixel = self.pixel_at(place.min(1.0));
            let places = if within_pixel { self.places_in(pixel, [low, high]) } else { [low, high] };
            look(pixel, places).filter(|_| low < 1.0 && (number == 0.0 || place <= 1.0))
        });
        looks.collect()
    }
}

impl Judge<'_> {
    /// The part of a ray in the image through which it is traced at t: the first that it is in there. `None` where no march is declared.
    pub(super) fn passage(&self, index: usize, t: f64) -> Option<Passage<'_>> {
        let ray = Ray64::from(&self.rays[index]);
        let off = T_ROUNDING * t;
        let mut whole = [ray.t_min, ray.t_max];
        let (sampling, view, march, span) = self.samplings.iter().find_map(|sampling| {
            let (Projection::Perspective(view), Some(march)) = (&sampling.projection, sampling.march) else {
                return None;
            };
            let span = span_in_view(view, &ray, whole);
            if span[0] - off <= t && t <= span[1] + off {
                return Some((sampling, view, march, span));
            }
            // Where it is in an image, another is left, or not entered yet.
            if span[0] < span[1] && t > span[1] {
                whole[0] = whole[0].max(span[1]);
            } else if span[0] < span[1] {
                whole[1] = whole[1].min(span[0]);
            }
            None
        })?;
        let [begin, end] = [view.project(ray.at(span[0]))?, view.project(ray.at(span[1]))?];
        let from = DVec2::new(begin.x, begin.y);
        let across = DVec2::new(end.x, end.y) - from;
        let inverse_depths = [1.0 / begin.depth, 1.0 / end.depth];
        let skipped = (march.start_bias / across.abs().max_element().max(1e-6)).min(1.0);
        let share =
            if let MarchSteps::Equal { looks_at, .. } = march.steps { looks_at(&self.rays[index]) } else { 0.0 };
        let ts_over_depth = [span[0] * inverse_depths[0], span[1] * inverse_depths[1]];
        let first = if span[0] <= ray.t_min { skipped } else { 0.0 };
        Some(Passage { sampling, view, march, share, from, across, inverse_depths, ts_over_depth, first })
    }

    /// The samples that a ray meets where it looks about t: how deep each is, and between which parameters a hit with it is told. Surely,
    /// or perhaps: wherever a rasterizer's rounding may have moved the sample, or in any such place.
    pub(super) fn met_about(&self, passage: &Passage<'_>, ray: &Ray64, t: f64, surely: bool) -> Vec<(f64, [f64; 2])> {
        let Passage { view, march, sampling, .. } = passage;
        let along = ray.direction.dot(view.forward);
        let one_step =
            matches!(march.steps, MarchSteps::Stride(stride) if stride >= passage.across.abs().max_element());
        let met = |Look { pixel, span }: Look| {
            let [begin, end] = span.map(|t| (ray.at(t) - view.eye).dot(view.forward));
            let (near, far) = (begin.min(end), begin.max(end));
            let pixels = sampling.projection.pixel_at(far).max_element();
            let thickness = march.thickness + march.thickness_in_pixels * pixels;
            let rounding = if surely { -DEPTH_ROUNDING * far } else { DEPTH_ROUNDING * far };
            let line = sampling.projection.line_through(pixel.x + 0.5, pixel.y + 0.5);
            let meets = move |found: TrueHit| {
                let depths = self.snapped_depths(view, pixel + 0.5, &found);
                let [least, most] = if surely { [depths[1], depths[0]] } else { depths };
                let back = if march.to_back_faces { self.back_behind(line, found.t) } else { None };
                let reaches = back.unwrap_or(most + thickness.max(0.0));
                let told = depths.map(|depth| ((depth - begin) / along + span[0]).clamp(span[0], span[1]));
                let told = match march.anywhere && !one_step || along == 0.0 {
                    true => span,
                    // Who comes from behind into what is solid is in it at once.
                    false if along < 0.0 && thickness.is_infinite() => [span[0]; 2],
                    false => [told[0].min(told[1]), told[0].max(told[1])],
                };
                // Surely from before, as the ray is there where it enters the pixel.
                let comes = !(surely && march.from_before) || begin < least + rounding;
                let met = comes && least + thickness.min(0.0) <= far + rounding && reaches >= near - rounding;
                met.then_some((found.t, told))
            };
            self.kept(line, sampling.layers).filter_map(meets).collect::<Vec<_>>()
        };
        passage.looks_about(t).into_iter().flat_map(met).collect()
    }

    /// Between which depths the sample of a surface at a pixel's centre is, for all that a rasterizer may move it.
    fn snapped_depths(&self, view: &View, centre: DVec2, found: &TrueHit) -> [f64; 2] {
        let normal = self.truth.normal(found.primitive);
        let off = normal.dot(self.truth.geometry().corners(found.primitive)[0].as_dvec3() - view.eye);
        let moves = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        let moved = moves.map(|(x, y)| centre + RASTER_SNAP_PIXELS * DVec2::new(x, y));
        let depths = moved.map(|at| off / normal.dot(view.direction_through(at.x, at.y)));
        depths.into_iter().fold([found.t; 2], |[least, most], depth| [least.min(depth), most.max(depth)])
    }

    /// How deep the next surface lies behind a depth that faces away.
    fn back_behind(&self, line: LineOfSight, depth: f64) -> Option<f64> {
        let mut behind = self.along(LineOfSight { near: depth.next_up(), ..line });
        behind.find(|found| self.truth.normal(found.primitive).dot(line.direction) > 0.0).map(|back| back.t)
    }

    /// Whether a ray is at t, which may be off by so much, on the plane of a triangle that is no farther than this.
    pub(super) fn is_on_plane_within(&self, ray: &Ray64, t: f64, reach: f64, may_be_off: f64) -> bool {
        let (point, mut found) = (ray.at(t), false);
        self.truth.in_box(point - reach, point + reach, |primitive| {
            let corners = self.truth.geometry().corners(primitive).map(|corner| corner.as_dvec3());
            let normal = self.truth.normal(primitive);
            let off = normal.dot(corners[0] - point) / normal.dot(ray.direction);
            found = found || off.abs() <= may_be_off && nearest_point(point, corners).distance(point) <= reach;
        });
        found
    }
}
