//! Closed shapes that scenes are furnished with, all seen from outside.
//!
//! Their divisions are those at scale 1: around and along what is round or bent, with the least that may be left of the latter where it is
//! given; along x, y and z of a box.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::builder::{Ends, MaterialId, MeshBuilder, Paint};
use super::math::{TURN, cos, curve, mix, sin};

impl MeshBuilder {
    /// A box; divisions of 0 leave its sides whole at every scale.
    pub(super) fn cuboid(&mut self, material: MaterialId, min: DVec3, max: DVec3, divisions: [usize; 3]) {
        let axes = [0, 1, 2].map(|axis| steps(min[axis], max[axis], self.along(divisions[axis])));
        for axis in 0..3 {
            // (u, v, axis) is a right-handed cycle, so u x v points along +axis.
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let point = |at: f64| {
                move |on_u: f64, on_v: f64| {
                    let mut point = DVec3::ZERO;
                    point[u] = on_u;
                    point[v] = on_v;
                    point[axis] = at;
                    point
                }
            };
            self.sheet(material, &axes[u], &axes[v], point(max[axis]));
            let low = point(min[axis]);
            self.sheet(material, &axes[v], &axes[u], |on_v, on_u| low(on_u, on_v));
        }
    }

    /// A profile (radius, height) turned about the y axis. It starts and ends on the axis, which gives closed shapes; going up on the outside and down
    /// on the inside makes a vessel.
    pub(super) fn revolve(&mut self, material: MaterialId, around: usize, profile: &[DVec2]) {
        self.lathe(material, self.around(around), profile);
    }

    /// As [`Self::revolve`], in as many steps as it says.
    pub(super) fn lathe(&mut self, material: MaterialId, around: usize, profile: &[DVec2]) {
        let [first, rings @ .., last] = profile else {
            return;
        };
        let ends = Ends::Closed(first.y * DVec3::Y, last.y * DVec3::Y);
        self.turned(material, [rings.len(), around], ends, |ring, angle| {
            let DVec2 { x: radius, y } = rings[ring];
            dvec3(radius * cos(angle), y, -radius * sin(angle))
        });
    }

    /// [`Self::revolve`] of a [`smooth_profile`].
    pub(super) fn revolve_smooth(
        &mut self,
        material: MaterialId,
        [around, along, least]: [usize; 3],
        knots: &[[f64; 2]],
    ) {
        self.revolve(material, around, &smooth_profile(knots, self.divide(along, least)));
    }

    /// [`Self::revolve`] of a [`straight_profile`]; divisions are those along each line.
    pub(super) fn revolve_straight(&mut self, material: MaterialId, [around, along]: [usize; 2], knots: &[[f64; 2]]) {
        self.revolve(material, around, &straight_profile(knots, self.along(along)));
    }

    /// A ball around the frame's point `center`.
    pub(super) fn ball(&mut self, material: MaterialId, center: DVec3, radius: f64, around: usize) {
        let around = self.around(around);
        let profile = half_circle(radius, around);
        self.within(self.frame.shift(center), |here| here.lathe(material, around, &profile));
    }

    /// A ball that is seen from inside: the void in something hollow.
    pub(super) fn void(&mut self, material: MaterialId, center: DVec3, radius: f64, around: usize) {
        let around = self.around(around);
        let mut profile = half_circle(radius, around);
        profile.reverse();
        self.within(self.frame.shift(center), |here| here.lathe(material, around, &profile));
    }

    /// An ellipsoid around the frame's point `center`.
    pub(super) fn ellipsoid(&mut self, material: MaterialId, center: DVec3, half: DVec3, around: usize) {
        let around = self.around(around);
        let rows = (around / 2).max(2);
        let ends = Ends::Closed(center - DVec3::Y * half.y, center + DVec3::Y * half.y);
        self.turned(material, [rows - 1, around], ends, |ring, angle| {
            let up = TURN / 2.0 * (ring + 1) as f64 / rows as f64;
            center + half * dvec3(sin(up) * cos(angle), -cos(up), -sin(up) * sin(angle))
        });
    }

    /// A tube along an open curve, closed by flat ends. `path` and `radius` take 0 to 1.
    pub(super) fn tube(
        &mut self,
        material: MaterialId,
        divisions: [usize; 3],
        path: impl Fn(f64) -> DVec3,
        radius: impl Fn(f64) -> f64,
    ) {
        self.ribbon(material, divisions, None, path, |t| DVec2::splat(radius(t)));
    }

    /// A straight rod.
    pub(super) fn rod(&mut self, material: MaterialId, [around, along]: [usize; 2], ends: [DVec3; 2], radius: f64) {
        self.tube(material, [around, along, 1], line(ends), |_| radius);
    }

    /// A tube with an elliptic cross-section: `size` gives the half axes, the first across the path on the side of
    /// `side` (any direction where that does not matter), the second square to it.
    pub(super) fn ribbon(
        &mut self,
        material: MaterialId,
        [around, along, least]: [usize; 3],
        side: Option<DVec3>,
        path: impl Fn(f64) -> DVec3,
        size: impl Fn(f64) -> DVec2,
    ) {
        self.sweep(material, [self.around(around), self.divide(along, least)], side, path, size);
    }

    /// As [`Self::ribbon`], in as many steps as it says.
    pub(super) fn sweep(
        &mut self,
        paint: impl Paint,
        [around, along]: [usize; 2],
        side: Option<DVec3>,
        path: impl Fn(f64) -> DVec3,
        size: impl Fn(f64) -> DVec2,
    ) {
        let points: Vec<DVec3> = steps(0.0, 1.0, along).into_iter().map(&path).collect();
        let frames = carry(&points, false, side);
        let ends = Ends::Closed(points[0], points[along]);
        self.turned(paint, [points.len(), around], ends, |ring, angle| {
            let half = size(ring as f64 / along as f64);
            let (across, square) = frames[ring];
            points[ring] + across * (half.x * cos(angle)) + square * (half.y * sin(angle))
        });
    }

    /// A tube of constant radius along a closed curve; `path` takes 0 to 1 and comes back to its start.
    pub(super) fn loop_tube(
        &mut self,
        material: MaterialId,
        [around, along, least]: [usize; 3],
        path: impl Fn(f64) -> DVec3,
        radius: f64,
    ) {
        let [around, along] = [self.around(around), self.divide(along, least)];
        let mut points: Vec<DVec3> = steps(0.0, 1.0, along).into_iter().map(&path).collect();
        points.pop();
        let frames = carry(&points, true, None);
        // Carried once around, the frame comes back turned: the difference is spread over the whole length.
        let tangent = (points[1] - points[along - 1]).normalize_or(DVec3::Y);
        let (across, square) = frames[along - 1];
        let back = (across - tangent * across.dot(tangent)).normalize_or(square);
        let turned = libm::atan2(back.dot(frames[0].1), back.dot(frames[0].0));
        self.turned(material, [along, around], Ends::Looped, |ring, angle| {
            let angle = angle - turned * (ring as f64 / along as f64);
            let (across, square) = frames[ring];
            points[ring] + (across * cos(angle) + square * sin(angle)) * radius
        });
    }

    /// A ring lying in the frame's xz plane.
    pub(super) fn torus(
        &mut self,
        material: MaterialId,
        divisions: [usize; 3],
        center: DVec3,
        [large, small]: [f64; 2],
    ) {
        let path = |t: f64| center + dvec3(large * cos(TURN * t), 0.0, -large * sin(TURN * t));
        self.loop_tube(material, divisions, path, small);
    }

    /// A slab with rounded corners and edges: `half` is half its size, `square` above 2 makes the outline squarer.
    pub(super) fn slab(
        &mut self,
        material: MaterialId,
        [around, edge, least]: [usize; 3],
        center: DVec3,
        half: DVec3,
        square: f64,
    ) {
        let [around, edge] = [self.around(around), self.divide(edge, least)];
        let bend = half.y.min(half.x).min(half.z);
        let power = |x: f64| libm::copysign(libm::pow(x.abs(), 2.0 / square), x);
        let ends = Ends::Closed(center - DVec3::Y * half.y, center + DVec3::Y * half.y);
        self.turned(material, [edge + 1, around], ends, |ring, angle| {
            let bow = TURN / 2.0 * (ring as f64 / edge as f64 - 0.5);
            let inset = bend * (1.0 - cos(bow));
            let (x, z) = ((half.x - inset) * power(cos(angle)), -(half.z - inset) * power(sin(angle)));
            center + dvec3(x, half.y * sin(bow), z)
        });
    }

    /// The points of a closed outline through `corners`, the side after each divided as said, in turns.
    pub(super) fn outline(&self, corners: &[[f64; 2]], divisions: &[usize]) -> Vec<DVec2> {
        let mut points = Vec::new();
        for (at, &from) in corners.iter().enumerate() {
            let [from, to] = [from, corners[(at + 1) % corners.len()]].map(DVec2::from_array);
            let divisions = self.along(divisions[at % divisions.len()]);
            points.extend((0..divisions).map(|step| from + (to - from) * (step as f64 / divisions as f64)));
        }
        points
    }
}

/// A straight way between two points.
pub(super) fn line([from, to]: [DVec3; 2]) -> impl Fn(f64) -> DVec3 {
    move |t| from + (to - from) * t
}

/// `divisions + 1` numbers from `from` to `to`, evenly spread, both exact.
pub(super) fn steps(from: f64, to: f64, divisions: usize) -> Vec<f64> {
    (0..=divisions)
        .map(|step| if step == divisions { to } else { mix(from, to, step as f64 / divisions as f64) })
        .collect()
}

/// `count + 1` points of a smooth profile through `knots`; between the ends it keeps off the axis.
pub(super) fn smooth_profile(knots: &[[f64; 2]], count: usize) -> Vec<DVec2> {
    let points: Vec<DVec3> = knots.iter().map(|&[x, y]| dvec3(x, y, 0.0)).collect();
    (0..=count)
        .map(|at| {
            let point = curve(&points, at as f64 / count as f64).truncate();
            if at == 0 || at == count { point } else { dvec2(point.x.max(5e-4), point.y) }
        })
        .collect()
}

/// A profile of straight lines through `knots`, each divided into `divisions`.
pub(super) fn straight_profile(knots: &[[f64; 2]], divisions: usize) -> Vec<DVec2> {
    let mut points = vec![DVec2::from_array(knots[0])];
    for pair in knots.windows(2) {
        let (a, b) = (DVec2::from_array(pair[0]), DVec2::from_array(pair[1]));
        for step in 1..=divisions {
            points.push(a + (b - a) * (step as f64 / divisions as f64));
        }
    }
    points
}

/// The profile of a ball, from its lowest point to its highest.
fn half_circle(radius: f64, around: usize) -> Vec<DVec2> {
    let rows = (around / 2).max(2);
    (0..=rows)
        .map(|row| {
            let angle = TURN / 2.0 * row as f64 / rows as f64;
            dvec2(radius * sin(angle), -radius * cos(angle))
        })
        .collect()
}

/// Two directions square to the path and to each other at each point, carried along it with as little turning as can be.
fn carry(points: &[DVec3], looped: bool, side: Option<DVec3>) -> Vec<(DVec3, DVec3)> {
    let count = points.len();
    let mut across = side.unwrap_or(dvec3(0.36, 0.48, 0.8));
    let mut frames = Vec::with_capacity(count);
    for at in 0..count {
        let (before, after) = if looped {
            (points[(at + count - 1) % count], points[(at + 1) % count])
        } else {
            (points[at.saturating_sub(1)], points[(at + 1).min(count - 1)])
        };
        let tangent = (after - before).normalize_or(DVec3::Y);
        let fallback = tangent.cross(dvec3(0.6, 0.0, 0.8)).normalize_or(DVec3::X);
        across = (across - tangent * across.dot(tangent)).normalize_or(fallback);
        frames.push((across, tangent.cross(across)));
    }
    frames
}

/// Knots of a profile from its radii and heights, or of a spline from abscissae and ordinates.
pub(super) fn knots<const N: usize>(across: [f64; N], up: [f64; N]) -> [[f64; 2]; N] {
    std::array::from_fn(|at| [across[at], up[at]])
}
