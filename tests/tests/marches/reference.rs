//! Marches over images of eye depth in f64, on the host.

use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::{Ray, View};
use tracebench_kit::{NO_SURFACE, eye_space};

/// Images of eye depth of one view, row by row.
pub struct Depths {
    pub view: View,
    pub images: Vec<Vec<f32>>,
}

/// What `screen-dda` is told.
#[derive(Clone, Copy, Debug)]
pub struct Dda {
    pub stride: f64,
    pub max_steps: usize,
    /// Scene units, and a share of the stored depth.
    pub thickness: f64,
    pub thickness_per_depth: f64,
    pub start_bias: f64,
    pub layers: usize,
    /// Whether images of backs follow the layers.
    pub backs: bool,
}

/// A ray in eye space.
#[derive(Clone, Copy)]
struct EyeRay {
    origin: DVec3,
    direction: DVec3,
    t_min: f64,
    t_max: f64,
}

impl EyeRay {
    fn of(view: &View, ray: &Ray, shift: DVec3) -> Self {
        let origin = Vec3::from(ray.origin).as_dvec3();
        let direction = Vec3::from(ray.direction).as_dvec3();
        Self {
            origin: eye_space(view, origin) + shift,
            direction: eye_space(view, view.eye + direction),
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        }
    }

    fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// The part within the view's frustum.
    fn in_view(&self, view: &View) -> Option<[f64; 2]> {
        let (across, upward) = (view.tan_half_width, view.tan_half_height);
        let planes = [
            (DVec3::Z, -view.near),
            (DVec3::NEG_Z, view.far),
            (DVec3::new(1.0, 0.0, across), 0.0),
            (DVec3::new(-1.0, 0.0, across), 0.0),
            (DVec3::new(0.0, 1.0, upward), 0.0),
            (DVec3::new(0.0, -1.0, upward), 0.0),
        ];
        let mut span = [self.t_min, self.t_max];
        for (normal, offset) in planes {
            let (value, slope) = (normal.dot(self.origin) + offset, normal.dot(self.direction));
            match slope {
                0.0 if value < 0.0 => return None,
                0.0 => {}
                _ if slope > 0.0 => span[0] = span[0].max(-value / slope),
                _ => span[1] = span[1].min(-value / slope),
            }
        }
        (span[0] < span[1]).then_some(span)
    }
}

impl Depths {
    fn place(&self, point: DVec3) -> DVec2 {
        let size = DVec2::new(f64::from(self.view.size[0]), f64::from(self.view.size[1]));
        let at = DVec2::new(point.x / self.view.tan_half_width, -point.y / self.view.tan_half_height) / point.z;
        (at + 1.0) * 0.5 * size
    }

    fn stored(&self, image: usize, at: DVec2) -> f32 {
        let [width, height] = self.view.size;
        let index = |at: f64, count: u32| at.floor().clamp(0.0, f64::from(count - 1)) as usize;
        self.images[image][index(at.y, height) * width as usize + index(at.x, width)]
    }

    /// The parts of a ray in the pixels that it crosses, by brute force: it is cut at every line between columns and rows.
    fn parts(&self, ray: &EyeRay, [begin, end]: [f64; 2]) -> Vec<[f64; 2]> {
        let mut cuts = vec![begin, end];
        for (axis, tangent) in [self.view.tan_half_width, self.view.tan_half_height].into_iter().enumerate() {
            let count = self.view.size[axis];
            for line in 0..=count {
                let line = (2.0 * f64::from(line) / f64::from(count) - 1.0) * tangent;
                let t = (line * ray.origin.z - ray.origin[axis]) / (ray.direction[axis] - line * ray.direction.z);
                if begin < t && t < end {
                    cuts.push(t);
                }
            }
        }
        cuts.sort_by(f64::total_cmp);
        cuts.windows(2).map(|part| [part[0], part[1]]).collect()
    }

    /// Where a ray hits the height field of the first image.
    pub fn height_field(&self, ray: &Ray, shift: DVec3) -> Option<f64> {
        let ray = EyeRay::of(&self.view, ray, shift);
        for part in self.parts(&ray, ray.in_view(&self.view)?) {
            let stored = self.stored(0, self.place(ray.at(part[0].midpoint(part[1]))));
            let top = f64::from(stored);
            if stored == NO_SURFACE {
                continue;
            }
            if ray.at(part[0]).z >= top {
                return Some(part[0]);
            }
            if ray.at(part[1]).z >= top {
                return Some((top - ray.origin.z) / ray.direction.z);
            }
        }
        None
    }

    /// What a ray that goes forwards or backwards meets first at a place, between two depths.
    fn met(&self, told: &Dda, at: DVec2, depths: [f64; 2], forwards: bool) -> Option<f64> {
        let (nearest, farthest) = (depths[0].min(depths[1]), depths[0].max(depths[1]));
        let meets = |layer: &usize| {
            let stored = f64::from(self.stored(*layer, at));
            let back = if told.backs { self.stored(told.layers + layer, at) } else { NO_SURFACE };
            let thick = stored + told.thickness + told.thickness_per_depth * stored;
            farthest >= stored && nearest <= if back < NO_SURFACE { f64::from(back) } else { thick }
        };
        let mut layers = (0..told.layers).filter(meets);
        let layer = if forwards { layers.next() } else { layers.next_back() };
        layer.map(|layer| f64::from(self.stored(layer, at)))
    }

    /// Where a ray hits in one of the pixels that it crosses after the bias, hits placed at the stored depth.
    pub fn cells(&self, ray: &Ray, told: &Dda, shift: DVec3) -> Option<f64> {
        let ray = EyeRay::of(&self.view, ray, shift);
        let [begin, end] = ray.in_view(&self.view)?;
        let (from, to) = (self.place(ray.at(begin)), self.place(ray.at(end)));
        let skipped = told.start_bias / (to - from).abs().max_element().max(1e-6);
        if begin <= ray.t_min && skipped >= 1.0 {
            return None;
        }
        let first = if begin <= ray.t_min { skipped } else { 0.0 };
        let over = [(1.0 - first) / ray.at(begin).z, first / ray.at(end).z];
        let start = (over[0] * begin + over[1] * end) / (over[0] + over[1]);
        self.parts(&ray, [start, end]).into_iter().find_map(|part| {
            let at = self.place(ray.at(part[0].midpoint(part[1])));
            let stored = self.met(told, at, part.map(|t| ray.at(t).z), ray.direction.z >= 0.0)?;
            Some(((stored - ray.origin.z) / ray.direction.z).clamp(part[0], part[1]))
        })
    }

    /// Where a ray hits by the DDA, hits placed at their steps.
    pub fn dda(&self, ray: &Ray, told: &Dda, shift: DVec3) -> Option<f64> {
        let ray = EyeRay::of(&self.view, ray, shift);
        let [begin, end] = ray.in_view(&self.view)?;
        let (near_end, far_end) = (ray.at(begin), ray.at(end));
        let (first_place, last_place) = (self.place(near_end), self.place(far_end));
        let inverse = |share: f64| (1.0 - share) / near_end.z + share / far_end.z;
        let t_at = |share: f64| ((1.0 - share) * begin / near_end.z + share * end / far_end.z) / inverse(share);
        let major = (last_place - first_place).abs().max_element().max(1e-6);
        let step = (told.stride / major).min(1.0);
        let first = if begin <= ray.t_min { (told.start_bias / major).min(1.0) } else { 0.0 };
        let mut low = first;
        for sample in 0..told.max_steps {
            if low >= 1.0 {
                return None;
            }
            let share = (first + sample as f64 * step).min(1.0);
            let high = if share + step > 1.0 || step == 1.0 { 1.0 } else { share + 0.5 * step };
            let at = first_place.lerp(last_place, share);
            let depths = [1.0 / inverse(low), 1.0 / inverse(high)];
            if let Some(stored) = self.met(told, at, depths, ray.direction.z >= 0.0) {
                let t = if step == 1.0 { (stored - ray.origin.z) / ray.direction.z } else { t_at(share) };
                return Some(t.clamp(t_at(low), t_at(high)));
            }
            low = high;
        }
        None
    }
}
