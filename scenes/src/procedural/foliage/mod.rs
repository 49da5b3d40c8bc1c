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

use super::prelude::*;

/// Length of the animation in seconds.
pub(crate) const DURATION_S: f64 = 4.0;

/// Half the ground's extent along x and z, in metres.
const HALF: f64 = 12.0;
/// Middle of the pool and its radius.
const POOL: (DVec3, f64) = (dvec3(1.2, -0.12, 1.0), 1.9);

palette! {
    EARTH: [0.24, 0.22, 0.12];
    STONE: [0.45, 0.45, 0.43];
    OAK_BARK: [0.3, 0.22, 0.15];
    BIRCH_BARK: [0.62, 0.6, 0.55];
    OAK_LEAF: [0.13, 0.33, 0.09];
    BUSH_LEAF: [0.22, 0.42, 0.1];
    BIRCH_LEAF: [0.34, 0.45, 0.12];
    AUTUMN_LEAF: [0.5, 0.38, 0.1];
    GRASS: [0.25, 0.45, 0.12];
    DRY_GRASS: [0.4, 0.48, 0.18];
    WATER: [0.5, 0.56, 0.6], 1.0, 0.0;
}

/// The scene's scale and the time.
#[derive(Clone, Copy)]
struct Setting {
    scale: f64,
    time_s: f64,
}

impl Setting {
    /// Number of leaves or blades of which there are `base` at scale 1.
    fn count(self, base: usize) -> usize {
        (libm::round(base as f64 * self.scale) as usize).max(3)
    }

    /// Factor on their size: as many square metres at any scale, unless they became absurdly large.
    fn size(self) -> f64 {
        (1.0 / self.scale.sqrt()).min(2.5)
    }

    /// A swing of a whole number of cycles over the animation: zero at rest and at its end.
    fn swing(self, cycles: f64, phase: f64) -> f64 {
        sin(TURN * cycles * self.time_s / DURATION_S + phase) - sin(phase)
    }

    /// Where a point of a plant is in the wind: `up` is its height over the root as a share of the plant's, `reach` how far in
    /// metres the top is bent.
    fn bend(self, point: DVec3, up: f64, reach: f64, phase: f64) -> DVec3 {
        let by = reach * up.max(0.0) * up.max(0.0);
        let along = self.swing(1.0, phase) + 0.35 * self.swing(3.0, 0.9 * point.x + 0.6 * point.z + phase);
        let across = 0.5 * self.swing(2.0, 0.7 * point.z + phase);
        point + dvec3(0.9 * along + 0.3 * across, -0.15 * (along * along), 0.9 * across - 0.3 * along) * by
    }
}

/// Builds the glade with about `scale` times its triangles at scale 1 as it stands at `time_s`.
pub(crate) fn build(scale: f64, time_s: f64) -> Mesh {
    let mut builder = MeshBuilder::new(scale, PALETTE);
    let setting = Setting { scale, time_s };
    ground::build(&mut builder);
    plants::build(&mut builder, setting);
    ground::grass(&mut builder, setting);
    builder.finish()
}
