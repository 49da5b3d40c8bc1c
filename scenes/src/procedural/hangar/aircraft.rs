//! Two propeller aircraft: a polished transport with a hollow, seated fuselage, and a biplane.
//!
//! In an aircraft's frame x points forward, y up and z to its right; the origin is on the floor below its middle.

use glam::{DVec3, dvec2, dvec3};

use super::{Motion, Palette, SUNK};
use crate::procedural::builder::{Ends, MaterialId, MeshBuilder};
use crate::procedural::math::{Frame, TURN, cos, mix, sin, spline};
use crate::procedural::shapes::steps;

pub(super) fn build(builder: &mut MeshBuilder, palette: &Palette, motion: &Motion) {
    transport(builder, palette, motion, Frame::at(dvec3(-2.5, 0.0, -1.5)).yaw(0.42));
    biplane(builder, palette, motion, Frame::at(dvec3(18.0, 0.0, 9.5)).yaw(2.5));
}

/// A fuselage along x: knots (share from nose to tail, half width, half height, height of the middle).
struct Hull<'a> {
    nose: f64,
    tail: f64,
    knots: &'a [[f64; 4]],
}

impl Hull<'_> {
    /// Middle, half width and half height at a share from nose to tail.
    fn at(&self, t: f64) -> (DVec3, f64, f64) {
        let column = |column: usize| {
            let knots: Vec<(f64, f64)> = self.knots.iter().map(|knot| (knot[0], knot[column])).collect();
            spline(&knots, t)
        };
        (dvec3(mix(self.nose, self.tail, t), column(3), 0.0), column(1), column(2))
    }

    /// The skin between two shares, `inset` metres within; seen from inside if `inward`.
    fn skin(
        &self,
        builder: &mut MeshBuilder,
        material: MaterialId,
        [around, along]: [usize; 2],
        [from, to]: [f64; 2],
        inset: f64,
        inward: bool,
    ) {
        let sections: Vec<_> = steps(from, to, along).into_iter().map(|t| self.at(t)).collect();
        let ends = Ends::Closed(sections[0].0, sections[along].0);
        builder.rings(material, along + 1, around, &ends, |ring, at| {
            let angle = TURN * at as f64 / around as f64 * if inward { -1.0 } else { 1.0 };
            let (middle, wide, high) = sections[ring];
            let (wide, high) = ((wide - inset).max(0.02), (high - inset).max(0.02));
            // Counter-clockwise about -x.
            middle + dvec3(0.0, high * sin(angle), wide * cos(angle))
        });
    }
}

/// A wing or fin between two points, with an elliptic section that runs out at the tip.
fn wing(
    builder: &mut MeshBuilder,
    material: MaterialId,
    divisions: [usize; 2],
    [root, tip]: [DVec3; 2],
    [chord, tip_chord]: [f64; 2],
    thick: f64,
) {
    let path = |t: f64| root + (tip - root) * t;
    builder.ribbon(material, divisions, Some(DVec3::X), path, |t| {
        let t2 = t * t;
        let out = libm::sqrt((1.0 - 0.97 * t2 * t2 * t2 * t2).max(0.0));
        dvec2(mix(chord, tip_chord, t) * 0.5 * out, thick * mix(1.0, 0.5, t) * out)
    });
}

/// Spinner and blades before an engine, at the frame's origin, turned by `turn`.
fn propeller(builder: &mut MeshBuilder, palette: &Palette, blades: usize, radius: f64, turn: f64) {
    let here = builder.frame;
    builder.frame = here.pitch(turn).roll(-TURN / 4.0);
    let spinner = [[0.0, -0.12], [0.2, -0.1], [0.21, 0.05], [0.13, 0.28], [0.0, 0.4]];
    builder.revolve_smooth(palette.polished, builder.bent(24, [14, 5]), &spinner);
    builder.frame = here.pitch(turn);
    for blade in 0..blades {
        let angle = TURN * blade as f64 / blades as f64;
        let out = dvec3(0.0, cos(angle), sin(angle));
        let across = dvec3(0.55, -sin(angle) * 0.8, cos(angle) * 0.8);
        let path = |t: f64| out * mix(0.1, radius, t);
        builder.ribbon(palette.black, builder.bent(12, [24, 6]), Some(across), path, |t| {
            let width = spline(&[(0.0, 0.05), (0.25, 0.11), (0.6, 0.14), (0.9, 0.1), (1.0, 0.03)], t);
            dvec2(width, mix(0.045, 0.012, t))
        });
    }
    builder.frame = here;
}

/// A wheel on an axle along z.
fn landing_wheel(builder: &mut MeshBuilder, palette: &Palette, middle: DVec3, radius: f64) {
    let here = builder.frame;
    builder.frame = here.shift(middle).pitch(TURN / 4.0);
    let small = radius * 0.32;
    builder.torus(palette.rubber, builder.ring(10, 24), DVec3::ZERO, [radius - small, small]);
    let hub = [[0.0, -0.5 * small], [radius * 0.7, -0.4 * small], [radius * 0.7, 0.4 * small], [0.0, 0.5 * small]];
    builder.revolve_smooth(palette.steel, builder.bent(24, [8, 4]), &hub);
    builder.frame = here;
}

fn transport(builder: &mut MeshBuilder, palette: &Palette, motion: &Motion, here: Frame) {
    builder.object("transport aircraft");
    builder.frame = here;
    let knots = [
        [0.0, 0.12, 0.12, 2.75],
        [0.03, 0.5, 0.5, 2.75],
        [0.1, 0.95, 0.98, 2.8],
        [0.2, 1.22, 1.3, 2.9],
        [0.5, 1.25, 1.35, 2.95],
        [0.75, 0.9, 1.0, 3.05],
        [0.93, 0.35, 0.5, 3.2],
        [1.0, 0.06, 0.14, 3.25],
    ];
    let hull = Hull { nose: 9.2, tail: -9.6, knots: &knots };
    hull.skin(builder, palette.polished, builder.bent(52, [80, 12]), [0.0, 1.0], 0.0, false);
    hull.skin(builder, palette.white, builder.bent(44, [54, 9]), [0.12, 0.8], 0.09, true);
    cabin(builder, palette);
    let blade = builder.bent(28, [30, 6]);
    let fin = builder.bent(28, [28, 5]);
    for face in [-1.0, 1.0] {
        let tip = dvec3(0.4, 3.0, face * 13.0);
        wing(builder, palette.polished, blade, [dvec3(1.6, 2.15, face * 0.3), tip], [4.4, 1.5], 0.28);
        let tip = dvec3(-9.0, 3.45, face * 3.9);
        wing(builder, palette.polished, fin, [dvec3(-8.2, 3.3, 0.0), tip], [2.2, 1.0], 0.1);
        // Engine, propeller and landing gear.
        let engine = dvec3(2.6, 2.55, face * 3.9);
        let nacelle = [
            [0.0, -2.4],
            [0.12, -2.3],
            [0.45, -1.2],
            [0.66, 0.4],
            [0.72, 1.3],
            [0.55, 1.62],
            [0.42, 1.6],
            [0.4, 1.2],
            [0.0, 1.15],
        ];
        builder.frame = here.shift(engine).roll(-TURN / 4.0);
        builder.revolve_smooth(palette.polished, builder.bent(36, [28, 10]), &nacelle);
        builder.frame = here.shift(engine);
        for cylinder in 0..9 {
            let angle = TURN * f64::from(cylinder) / 9.0;
            let out = dvec3(0.0, cos(angle), sin(angle));
            let at = DVec3::X * 1.34;
            builder.rod(palette.steel, builder.round(10, 4), [at + out * 0.1, at + out * 0.41], 0.1);
        }
        let shaft = [DVec3::X * 1.1, DVec3::X * 1.85];
        builder.rod(palette.steel, builder.round(12, 4), shaft, 0.12);
        builder.object(format!("transport propeller {}", if face < 0.0 { "left" } else { "right" }));
        builder.frame = here.shift(engine + DVec3::X * 1.85);
        propeller(builder, palette, 3, 1.75, face * motion.propeller);
        builder.object("transport landing gear");
        builder.frame = here;
        let axle = dvec3(3.0, 0.6 - SUNK, face * 3.9);
        landing_wheel(builder, palette, axle, 0.6);
        for side in [-0.32, 0.32] {
            let low = axle + DVec3::Z * side;
            let leg = builder.round(10, 8);
            builder.rod(palette.steel, leg, [low, low + dvec3(-0.3, 1.75, 0.0)], 0.06);
            builder.rod(palette.steel, leg, [low, low + dvec3(-1.5, 1.7, 0.0)], 0.04);
        }
        builder.rod(palette.steel, builder.round(8, 4), [axle - DVec3::Z * 0.4, axle + DVec3::Z * 0.4], 0.07);
    }
    builder.object_here("transport tail");
    let fin_tip = dvec3(-9.3, 5.9, 0.0);
    wing(builder, palette.polished, fin, [dvec3(-7.9, 3.2, 0.0), fin_tip], [2.9, 1.2], 0.12);
    landing_wheel(builder, palette, dvec3(-7.6, 0.3 - SUNK, 0.0), 0.3);
    let leg = [dvec3(-7.6, 0.3, 0.14), dvec3(-7.2, 2.9, 0.1)];
    builder.rod(palette.steel, builder.round(10, 8), leg, 0.06);
}

/// Floor, seats, and windows that stand out of the skin a little.
fn cabin(builder: &mut MeshBuilder, palette: &Palette) {
    let fine = builder.along(2);
    let floor = dvec3(-4.0, 2.22, -0.8);
    builder.cuboid(palette.dark_wood, floor, dvec3(5.6, 2.28, 0.8), [builder.along(12), fine, builder.along(4)]);
    for row in 0..7 {
        let x = -3.3 + 1.15 * f64::from(row);
        for z in [-0.52, 0.52] {
            let seat = builder.bent(16, [5, 2]);
            builder.slab(palette.blue, seat, dvec3(x, 2.62, z), dvec3(0.24, 0.07, 0.23), 5.0);
            let back = [dvec3(x - 0.2, 2.55, z), dvec3(x - 0.32, 3.25, z)];
            builder.ribbon(
                palette.blue,
                builder.bent(16, [8, 2]),
                Some(DVec3::Z),
                |t| back[0] + (back[1] - back[0]) * t,
                |_| dvec2(0.22, 0.06),
            );
            builder.rod(palette.steel, [builder.around(8), fine], [dvec3(x, 2.26, z), dvec3(x, 2.6, z)], 0.05);
        }
        for (face, z) in [(-1.0, -1.2), (1.0, 1.2)] {
            let at = dvec3(x + 0.2, 3.2, z - 0.08 * face);
            builder.ball(palette.glass, at, 0.17, builder.around(16));
        }
    }
}

fn biplane(builder: &mut MeshBuilder, palette: &Palette, motion: &Motion, here: Frame) {
    builder.object("biplane");
    builder.frame = here;
    let knots = [
        [0.0, 0.3, 0.3, 1.6],
        [0.06, 0.5, 0.52, 1.6],
        [0.3, 0.5, 0.6, 1.6],
        [0.6, 0.33, 0.42, 1.62],
        [1.0, 0.04, 0.16, 1.65],
    ];
    let hull = Hull { nose: 2.7, tail: -4.2, knots: &knots };
    hull.skin(builder, palette.yellow, builder.bent(32, [44, 10]), [0.0, 1.0], 0.0, false);
    let blade = builder.bent(20, [24, 6]);
    let fin = builder.bent(20, [20, 5]);
    let strut = builder.round(8, 8);
    for face in [-1.0, 1.0] {
        wing(
            builder,
            palette.blue,
            blade,
            [dvec3(0.9, 1.2, face * 0.2), dvec3(0.6, 1.45, face * 4.6)],
            [1.5, 1.2],
            0.09,
        );
        wing(builder, palette.blue, blade, [dvec3(1.4, 2.78, 0.0), dvec3(1.2, 2.95, face * 5.0)], [1.5, 1.3], 0.09);
        wing(builder, palette.blue, fin, [dvec3(-3.7, 1.7, 0.0), dvec3(-4.1, 1.72, face * 1.6)], [1.1, 0.6], 0.05);
        for z in [1.4, 3.4] {
            let [z, out] = [face * z, face * 0.05];
            for (low, high) in [(0.4, 0.95), (1.15, 1.7)] {
                builder.rod(palette.dark_wood, strut, [dvec3(low, 1.3, z), dvec3(high, 2.85, z + out)], 0.03);
            }
            for (a, b) in [(1.3, 2.85), (2.85, 1.3)] {
                let ends = [dvec3(0.8, a, z + face * 0.06), dvec3(0.85, b, z - face * 1.15)];
                builder.rod(palette.steel, builder.round(6, 6), ends, 0.012);
            }
        }
        landing_wheel(builder, palette, dvec3(1.5, 0.38 - SUNK, face * 0.85), 0.38);
        for x in [1.0, 1.9] {
            let ends = [dvec3(1.5, 0.38, face * 0.72), dvec3(x, 1.25, face * 0.3)];
            builder.rod(palette.steel, strut, ends, 0.035);
        }
    }
    let axle = [dvec3(1.5, 0.37, -0.95), dvec3(1.5, 0.37, 0.95)];
    builder.rod(palette.steel, strut, axle, 0.04);
    wing(builder, palette.blue, fin, [dvec3(-3.6, 1.6, 0.0), dvec3(-4.1, 2.75, 0.0)], [1.2, 0.7], 0.05);
    builder.rod(palette.steel, strut, [dvec3(-4.0, 1.6, 0.0), dvec3(-4.2, -SUNK, 0.0)], 0.04);
    builder.object("biplane propeller");
    builder.frame = here.shift(dvec3(2.75, 1.6, 0.0));
    propeller(builder, palette, 2, 1.1, -motion.propeller);
}
