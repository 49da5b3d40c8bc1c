//! The scene `foliage`: a glade of 24 x 24 metres with trees, bushes and grass that sway in the wind.
//!
//! A stand-in for the plants that papers on layered depth use as their deepest scenes: many small unconnected surfaces,
//! dozens of them behind a pixel. Leaves and blades are single surfaces without a back, so nothing has an inside. With
//! the scale their number grows and their size shrinks, so that as much of a view stays covered.
//!
//! Every vertex moves smoothly, more the higher it is above its plant's root; leaves flutter about their stalks. After
//! the animation's length all is back where it was.

mod ground;
mod plants;

use glam::{DVec3, dvec3};

use super::builder::{MaterialId, MeshBuilder, palette};
use super::math::{TURN, sin};
use super::{Built, NamedPose, cameras, path};

/// Triangles at scale 1, held by a test.
pub(crate) const TRIANGLES_AT_SCALE_1: u64 = 501_676;
/// Length of the animation in seconds.
pub(crate) const ANIMATION_S: f64 = 4.0;

/// Half the ground's extent along x and z, in metres.
const HALF: f64 = 12.0;
/// Middle of the pool and its radius.
const POOL: (DVec3, f64) = (dvec3(1.2, -0.12, 1.0), 1.9);

palette! {
    earth: [0.24, 0.22, 0.12];
    stone: [0.45, 0.45, 0.43];
    bark[2]: [[0.3, 0.22, 0.15], [0.62, 0.6, 0.55]];
    leaf[4]: [[0.13, 0.33, 0.09], [0.22, 0.42, 0.1], [0.34, 0.45, 0.12], [0.5, 0.38, 0.1]];
    grass[2]: [[0.25, 0.45, 0.12], [0.4, 0.48, 0.18]];
    water: [0.5, 0.56, 0.6], 1.0, 0.0;
}

/// How many leaves and blades there are, and how large.
#[derive(Clone, Copy)]
struct Density {
    scale: f64,
}

impl Density {
    /// Number of things of which there are `base` at scale 1.
    fn count(self, base: usize) -> usize {
        (libm::round(base as f64 * self.scale) as usize).max(3)
    }

    /// Factor on their size: as many square metres at any scale, unless they became absurdly large.
    fn size(self) -> f64 {
        (1.0 / self.scale.sqrt()).min(2.5)
    }
}

/// The wind at a time.
#[derive(Clone, Copy)]
struct Wind {
    time_s: f64,
}

impl Wind {
    /// A swing of a whole number of cycles over the animation: zero at rest and at its end.
    fn swing(self, cycles: f64, phase: f64) -> f64 {
        sin(TURN * cycles * self.time_s / ANIMATION_S + phase) - sin(phase)
    }

    /// Where a point of a plant is: `up` is its height over the root as a share of the plant's, `reach` how far in
    /// metres the top is bent.
    fn bend(self, point: DVec3, up: f64, reach: f64, phase: f64) -> DVec3 {
        let by = reach * up.max(0.0) * up.max(0.0);
        let along = self.swing(1.0, phase) + 0.35 * self.swing(3.0, 0.9 * point.x + 0.6 * point.z + phase);
        let across = 0.5 * self.swing(2.0, 0.7 * point.z + phase);
        point + dvec3(0.9 * along + 0.3 * across, -0.15 * (along * along), 0.9 * across - 0.3 * along) * by
    }
}

/// The glade under construction.
struct Glade {
    builder: MeshBuilder,
    palette: Palette,
    density: Density,
    wind: Wind,
}

/// Builds the glade with about `scale` times its triangles at scale 1 as it stands at `time_s`.
pub(crate) fn build(scale: f64, time_s: f64) -> Built {
    let mut builder = MeshBuilder::new(scale);
    let palette = Palette::new(&mut builder);
    let (density, wind) = (Density { scale }, Wind { time_s });
    let mut glade = Glade { builder, palette, density, wind };
    ground::build(&mut glade);
    plants::build(&mut glade);
    ground::grass(&mut glade);
    Built { mesh: glade.builder.finish(), cameras: cameras(&VIEWPOINTS), path: path(&PATH) }
}

const VIEWPOINTS: [NamedPose; 6] = [
    ("thicket", [-6.5, 3.0, 3.0], [2.0, 3.0, -4.0]),
    ("glade", [0.6, 2.0, 5.6], [-0.6, 2.7, -1.5]),
    ("path", [-8.5, 1.7, 7.5], [0.0, 1.8, -1.0]),
    ("crowns", [8.5, 6.5, 8.0], [-1.0, 3.0, -1.5]),
    ("grass", [3.6, 0.5, 4.63], [0.0, 0.6, 0.0]),
    ("pool", [3.2, 1.3, 3.4], [0.6, 0.2, 0.4]),
];

/// Round the pool.
const PATH: [([f32; 3], [f32; 3]); 5] = [
    ([-8.5, 1.7, 7.5], [0.0, 1.8, -1.0]),
    ([-4.0, 1.6, 7.0], [0.0, 1.6, 0.0]),
    ([1.5, 1.6, 6.5], [-0.5, 1.8, 0.0]),
    ([4.4, 1.5, 4.5], [0.0, 1.5, -0.5]),
    ([4.3, 1.6, 2.6], [-0.5, 1.5, -1.0]),
];
