//! Where things stand: scattered, but apart from each other and from the viewpoints.

use super::*;
use crate::catalogue::Pose;

/// Circles on the ground that are taken.
pub(super) struct Layout {
    taken: Vec<([f64; 2], f64)>,
    random: Random,
}

impl Layout {
    /// With free space around the eyes of viewpoints, and little things only right before them.
    pub(super) fn around(viewpoints: &[Pose]) -> Self {
        let mut taken = Vec::new();
        for viewpoint in viewpoints {
            let [eye, target] = [viewpoint.eye, viewpoint.target].map(|point| point.map(f64::from));
            for (share, radius) in [(0.0, 0.35), (0.2, 0.22)] {
                let at = [0, 2].map(|axis| eye[axis] + (target[axis] - eye[axis]) * share);
                taken.push((at, radius));
            }
        }
        Self { taken, random: Random(20_160_227) }
    }

    /// Keeps a circle free of what is scattered later.
    pub(super) fn take(&mut self, at: [f64; 2], radius: f64) {
        self.taken.push((at, radius));
    }

    /// A free place for a circle, at distances of the middle within a range, in metres.
    pub(super) fn spot(&mut self, radius: f64, [from, to]: [f64; 2]) -> [f64; 2] {
        let to = to.min(GROUND_RADIUS - 0.3 - radius);
        let mut at = [0.0; 2];
        // Where everything is full, the last try stands: things may then overlap.
        for _ in 0..400 {
            at = [0; 2].map(|_| self.random.between(-to, to));
            let from_middle = (at[0] * at[0] + at[1] * at[1]).sqrt();
            let free = self.taken.iter().all(|(other, other_radius)| {
                let (x, z) = (at[0] - other[0], at[1] - other[1]);
                let apart = radius + other_radius;
                x * x + z * z > apart * apart
            });
            if free && (from..to).contains(&from_middle) {
                break;
            }
        }
        self.take(at, radius);
        at
    }

    /// A number of the same random sequence.
    pub(super) fn between(&mut self, from: f64, to: f64) -> f64 {
        self.random.between(from, to)
    }
}
