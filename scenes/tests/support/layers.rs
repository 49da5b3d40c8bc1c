//! Depth layers: how many surfaces lie behind each pixel, as a fragment A-buffer would store them.
//!
//! The fragment A-buffer (VVP16) holds every fragment of a scene in seven views: the camera's and the six faces of a
//! cube around the eye. Its cost follows the number of fragments a pixel, and the paper's Table 1 names its scenes by
//! their average and greatest number: 2/17, 3/30, 4/20 and 6/49.
//!
//! The table does not say whether pixels without a fragment count. The seven views, 720 x 480 and six of 480 x 480,
//! have 1,728,000 pixels; divided by that, the fragments it gives (2.4, 4.9, 6.6 and 9.4 million) are 1.39, 2.84, 3.82
//! and 5.44. These are the table's averages if they were rounded up, so [`LayerCount::average_of_all`] fits without
//! further assumptions. Averages over covered pixels ([`LayerCount::average_of_covered`]), rounded to the nearest, fit
//! too, if 56 to 93, 81 to 100, 85 to 100 and 84 to 99 % of the pixels were covered. Fragments a pixel are what a scene
//! can be held against in either case. The paper pulls the faces back by the near distance; here they share the eye.

use std::iter::Sum;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use tracebench_scenes::{Camera, Scene};

/// The layers of one view, or of several together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayerCount {
    /// Pixels of the view.
    pub pixels: u64,
    /// Pixels with at least one fragment.
    pub covered: u64,
    /// Fragments: pairs of a pixel and a triangle that covers its centre.
    pub fragments: u64,
    /// Most fragments of a pixel.
    pub max: u32,
}

impl LayerCount {
    /// Fragments a covered pixel, at least 1; 0 if no pixel is covered.
    pub fn average_of_covered(&self) -> f64 {
        if self.covered == 0 { 0.0 } else { self.fragments as f64 / self.covered as f64 }
    }

    /// Fragments a pixel, covered or not; 0 without pixels.
    pub fn average_of_all(&self) -> f64 {
        if self.pixels == 0 { 0.0 } else { self.fragments as f64 / self.pixels as f64 }
    }

    /// Of the fragments of each pixel.
    pub fn of(counts: &[u32]) -> Self {
        Self {
            pixels: counts.len() as u64,
            covered: counts.iter().filter(|&&count| count > 0).count() as u64,
            fragments: counts.iter().map(|&count| u64::from(count)).sum(),
            max: counts.iter().copied().max().unwrap_or(0),
        }
    }
}

impl Sum for LayerCount {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), |sum, count| Self {
            pixels: sum.pixels + count.pixels,
            covered: sum.covered + count.covered,
            fragments: sum.fragments + count.fragments,
            max: sum.max.max(count.max),
        })
    }
}

/// The layers of a scene from one viewpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layers {
    /// The camera's view.
    pub view: LayerCount,
    /// The cube's faces in the order +x, -x, +y, -y, +z, -z; empty if they were not asked for.
    pub faces: Vec<LayerCount>,
}

impl Layers {
    /// All views together.
    pub fn total(&self) -> LayerCount {
        std::iter::once(self.view).chain(self.faces.iter().copied()).sum()
    }
}

/// Counts the layers of `scene` as `camera` sees it in `size` pixels (width, height) and, if `face` is given, in six
/// square cube faces of that many pixels a side, axis-aligned around the eye, with 90 degrees of view each.
///
/// Triangles count from both sides, where they cover the centre of a pixel (on an edge, by a top-left rule) at a depth
/// of at least a thousandth of the scene's diagonal. The far plane lies behind everything. All in f64; the same on
/// every machine.
pub fn count_layers(scene: &Scene, camera: &Camera, size: [u32; 2], face: Option<u32>) -> Layers {
    let near = 1e-3 * scene.diagonal();
    let count = |view: &View| LayerCount::of(&rasterize(scene, view, near));
    let faces = face.map_or(Vec::new(), |side| View::cube(camera, side).iter().map(count).collect());
    Layers { view: count(&View::of(camera, size)), faces }
}

/// A perspective view: pixel centres are directions from the eye.
pub struct View {
    /// Where it is seen from.
    pub eye: DVec3,
    /// Right, up and forward.
    pub axes: [DVec3; 3],
    /// Half the extent of the image plane at distance 1.
    pub half: [f64; 2],
    /// Pixels, along the width and down the height.
    pub size: [u32; 2],
}

impl View {
    /// What a camera sees.
    pub fn of(camera: &Camera, size: [u32; 2]) -> Self {
        let [eye, target, up] = [camera.eye, camera.target, camera.up].map(to_f64);
        let forward = (target - eye).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(up).normalize_or(DVec3::X);
        let half = libm::tan(f64::from(camera.vertical_fov_radians) / 2.0);
        let aspect = f64::from(size[0]) / f64::from(size[1].max(1));
        Self { eye, axes: [right, right.cross(forward), forward], half: [half * aspect, half], size }
    }

    /// The six faces of a cube around its eye.
    pub fn cube(camera: &Camera, side: u32) -> [Self; 6] {
        let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        axes.map(|forward| {
            let right = DVec3::new(forward.y.abs() - forward.z, 0.0, forward.x);
            let axes = [right, right.cross(forward), forward];
            Self { eye: to_f64(camera.eye), axes, half: [1.0, 1.0], size: [side, side] }
        })
    }

    /// The point in this view's coordinates: right, up, depth.
    fn place(&self, point: [f32; 3]) -> DVec3 {
        let from_eye = to_f64(point) - self.eye;
        let [right, up, forward] = self.axes;
        DVec3::new(from_eye.dot(right), from_eye.dot(up), from_eye.dot(forward))
    }

    /// Where the centre of pixel `at` lies at depth 1, along the width (axis 0) or down the height (axis 1).
    fn center(&self, axis: usize, at: u32) -> f64 {
        let share = (f64::from(at) + 0.5) / f64::from(self.size[axis]) * 2.0 - 1.0;
        if axis == 0 { share * self.half[0] } else { -share * self.half[1] }
    }

    /// The pixels, first and one past the last, whose centres can lie in an interval at depth 1; a pixel too many on
    /// either side, for rounding.
    fn pixels(&self, axis: usize, [low, high]: [f64; 2]) -> std::ops::Range<u32> {
        let count = f64::from(self.size[axis]);
        let at = |x: f64| (x / self.half[axis] + 1.0) * 0.5 * count;
        let (from, to) = if axis == 0 { (at(low), at(high)) } else { (count - at(high), count - at(low)) };
        ((from - 1.5).clamp(0.0, count) as u32)..((to + 1.5).clamp(0.0, count) as u32)
    }
}

/// A point in f64.
pub fn to_f64(point: [f32; 3]) -> DVec3 {
    DVec3::from_array(point.map(f64::from))
}

/// The number of fragments of each pixel, row by row from the top left.
pub fn rasterize(scene: &Scene, view: &View, near: f64) -> Vec<u32> {
    let width = view.size[0] as usize;
    let counts: Vec<AtomicU32> = (0..width * view.size[1] as usize).map(|_| AtomicU32::new(0)).collect();
    scene.mesh.triangles.par_iter().for_each(|triangle| {
        let corners = triangle.map(|vertex| view.place(scene.mesh.positions[vertex as usize]));
        cover(view, corners, near, |x, y| {
            // Whole numbers are added up: their order does not matter.
            counts[y as usize * width + x as usize].fetch_add(1, Ordering::Relaxed);
        });
    });
    counts.into_iter().map(AtomicU32::into_inner).collect()
}

/// Calls `fragment` for each pixel whose centre a triangle covers at a depth of at least `near`.
///
/// Edges are planes through the eye (Olano and Greer 1997), so that corners behind it need no clipping. Swapping the
/// ends of an edge negates its plane exactly, so that of two triangles that share one and face the same way exactly
/// one covers a centre on it.
fn cover(view: &View, corners: [DVec3; 3], near: f64, mut fragment: impl FnMut(u32, u32)) {
    let [a, b, c] = corners;
    let mut edges = [a.cross(b), b.cross(c), c.cross(a)];
    let mut volume = edges[0].dot(c);
    if volume < 0.0 {
        edges = edges.map(|edge| -edge);
        volume = -volume;
    }
    let Some([columns, rows]) = extent(view, corners, near) else {
        return;
    };
    // Also where it is seen edge-on, or not a number.
    if volume.is_nan() || volume == 0.0 {
        return;
    }
    for row in rows {
        let y = view.center(1, row);
        for column in columns.clone() {
            let x = view.center(0, column);
            let mut sum = 0.0;
            let inside = edges.iter().all(|edge| {
                let value = edge.x * x + (edge.y * y + edge.z);
                sum += value;
                value > 0.0 || (value == 0.0 && (edge.x > 0.0 || (edge.x == 0.0 && edge.y < 0.0)))
            });
            if inside && volume >= near * sum {
                fragment(column, row);
            }
        }
    }
}

/// Columns and rows of pixels that a triangle can cover beyond `near`; `None` if it lies before it.
fn extent(view: &View, corners: [DVec3; 3], near: f64) -> Option<[std::ops::Range<u32>; 2]> {
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    let mut include = |point: DVec3| {
        for axis in 0..2 {
            let at = point[axis] / point.z;
            bounds[axis] = [bounds[axis][0].min(at), bounds[axis][1].max(at)];
        }
    };
    for at in 0..3 {
        let (from, to) = (corners[at], corners[(at + 1) % 3]);
        if from.z >= near {
            include(from);
        }
        if (from.z >= near) != (to.z >= near) {
            let cut = from + (to - from) * ((near - from.z) / (to.z - from.z));
            include(cut.with_z(near));
        }
    }
    (bounds[0][0] <= bounds[0][1]).then(|| [0, 1].map(|axis| view.pixels(axis, bounds[axis])))
}
