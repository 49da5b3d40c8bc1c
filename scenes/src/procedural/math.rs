//! Portable mathematics for procedural scenes.

use glam::{DVec3, dvec3};

pub(super) use libm::{cos, sin, sqrt};

/// A full turn in radians.
pub(super) const TURN: f64 = std::f64::consts::TAU;

/// From `a` at 0 to `b` at 1.
pub(super) fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// 0 below `from`, 1 above `to`, smooth between.
pub(super) fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A bell of height 1 and width `width` around 0.
pub(super) fn bell(x: f64, width: f64) -> f64 {
    let t = x / width;
    libm::exp(-t * t)
}

/// A smooth curve through `knots` (abscissa increasing, ordinate); constant beyond the ends.
pub(super) fn spline(knots: &[[f64; 2]], x: f64) -> f64 {
    let last = knots.len() - 1;
    if x <= knots[0][0] {
        return knots[0][1];
    }
    if x >= knots[last][0] {
        return knots[last][1];
    }
    let right = knots.partition_point(|knot| knot[0] <= x).clamp(1, last);
    let left = right - 1;
    let slope = |at: usize| {
        let (a, b) = (knots[at.saturating_sub(1)], knots[(at + 1).min(last)]);
        (b[1] - a[1]) / (b[0] - a[0])
    };
    let width = knots[right][0] - knots[left][0];
    let t = (x - knots[left][0]) / width;
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * knots[left][1]
        + (t3 - 2.0 * t2 + t) * width * slope(left)
        + (3.0 * t2 - 2.0 * t3) * knots[right][1]
        + (t3 - t2) * width * slope(right)
}

/// A smooth curve through `points`, `t` in [0, 1] spread evenly over them.
pub(super) fn curve(points: &[DVec3], t: f64) -> DVec3 {
    let axis = |axis: usize| -> f64 {
        let step = 1.0 / (points.len() - 1) as f64;
        let knots: Vec<[f64; 2]> =
            points.iter().enumerate().map(|(number, point)| [number as f64 * step, point[axis]]).collect();
        spline(&knots, t)
    };
    dvec3(axis(0), axis(1), axis(2))
}

/// A frame in space: points given in it are rotated, then moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    origin: DVec3,
    axes: [DVec3; 3],
}

impl Frame {
    /// World space.
    pub(super) const WORLD: Self = Self::at(DVec3::ZERO);

    /// World axes, moved to `origin`.
    pub(super) const fn at(origin: DVec3) -> Self {
        Self { origin, axes: [DVec3::X, DVec3::Y, DVec3::Z] }
    }

    /// Turned about its own y axis, counter-clockwise seen from above.
    pub(super) fn yaw(self, radians: f64) -> Self {
        self.turned(2, 0, radians)
    }

    /// Turned about its own z axis.
    pub(super) fn roll(self, radians: f64) -> Self {
        self.turned(0, 1, radians)
    }

    /// Turned about its own x axis.
    pub(super) fn pitch(self, radians: f64) -> Self {
        self.turned(1, 2, radians)
    }

    /// Turned from one of its own axes towards another.
    fn turned(mut self, from: usize, to: usize, radians: f64) -> Self {
        let (s, c) = (sin(radians), cos(radians));
        let (first, second) = (self.axes[from], self.axes[to]);
        self.axes[from] = first * c + second * s;
        self.axes[to] = second * c - first * s;
        self
    }

    /// Moved to `from`, with the y axis towards `to` and the x axis on the side of `side`, all given in this frame.
    pub(super) fn span(self, from: DVec3, to: DVec3, side: DVec3) -> Self {
        let y = (to - from).normalize_or(DVec3::Y);
        let fallback = y.cross(dvec3(0.6, 0.0, 0.8)).normalize_or(DVec3::X);
        let x = (side - y * side.dot(y)).normalize_or(fallback);
        let turn = |local: DVec3| self.place(local) - self.origin;
        Self { origin: self.place(from), axes: [turn(x), turn(y), turn(x.cross(y))] }
    }

    /// Moved along its own axes.
    pub(super) fn shift(self, by: DVec3) -> Self {
        Self { origin: self.place(by), ..self }
    }

    /// The world position of `point`.
    pub(super) fn place(&self, point: DVec3) -> DVec3 {
        self.origin + self.axes[0] * point.x + self.axes[1] * point.y + self.axes[2] * point.z
    }
}

/// The horizontal directions of `count` spokes.
pub(super) fn spokes(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |at| TURN * at as f64 / count as f64).map(|angle| dvec3(cos(angle), 0.0, sin(angle)))
}

/// A small seeded generator (SplitMix64).
pub(super) struct Random(pub(super) u64);

impl Random {
    /// Uniform in [`from`, `to`).
    pub(super) fn between(&mut self, from: f64, to: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        let unit = (bits >> 11) as f64 / (1u64 << 53) as f64;
        mix(from, to, unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proves that the spline goes through its knots and does not jump between them.
    #[test]
    fn spline_interpolates() {
        let knots = [[0.0, 1.0], [0.5, 3.0], [0.7, 2.0], [1.0, 0.0]];
        for [x, y] in knots {
            assert!((spline(&knots, x) - y).abs() < 1e-12);
        }
        let mut last = spline(&knots, -1.0);
        for step in 0..=2000 {
            let now = spline(&knots, f64::from(step) / 1000.0 - 0.5);
            assert!((now - last).abs() < 0.02);
            last = now;
        }
    }

    /// Proves that frames rotate without scaling or mirroring.
    #[test]
    fn frames_are_rigid() {
        let frame = Frame::at(dvec3(1.0, 2.0, 3.0)).yaw(0.7).roll(-0.4).pitch(0.9);
        let frame = frame.span(DVec3::X, dvec3(2.0, -1.0, 0.5), DVec3::Z);
        let [x, y, z] = frame.axes;
        assert!((x.cross(y) - z).length() < 1e-12);
        assert!((x.length() - 1.0).abs() < 1e-12);
        assert!((Frame::WORLD.yaw(TURN / 4.0).place(DVec3::X) + DVec3::Z).length() < 1e-12);
        assert!((Frame::WORLD.pitch(TURN / 4.0).place(DVec3::Y) - DVec3::Z).length() < 1e-12);
    }
}
