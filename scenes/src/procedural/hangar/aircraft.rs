//! Two propeller aircraft: a polished transport with a hollow, seated fuselage, and a biplane.
//!
//! In an aircraft's frame x points forward, y up and z to its right; the origin is on the floor below its middle.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder, motion: &Motion) {
    transport(builder, motion, Frame::at(dvec3(-2.5, 0.0, -1.5)).yaw(0.42));
    biplane(builder, motion, Frame::at(dvec3(18.0, 0.0, 9.5)).yaw(2.5));
}

/// A fuselage along x, by shares of the way from nose to tail.
struct Hull<const N: usize> {
    nose: f64,
    tail: f64,
    shares: [f64; N],
    /// Half its width and half its height there, and the height of its middle.
    wide: [f64; N],
    high: [f64; N],
    middle: [f64; N],
}

impl<const N: usize> Hull<N> {
    /// Middle, half width and half height at a share.
    fn at(&self, t: f64) -> (DVec3, f64, f64) {
        let [wide, high, middle] = [self.wide, self.high, self.middle].map(|row| spline(&knots(self.shares, row), t));
        (dvec3(mix(self.nose, self.tail, t), middle, 0.0), wide, high)
    }

    /// The skin between two shares, `inset` metres within; seen from inside if `inward`.
    fn skin(
        &self,
        builder: &mut MeshBuilder,
        material: MaterialId,
        [around, along, least]: [usize; 3],
        [from, to]: [f64; 2],
        inset: f64,
        inward: bool,
    ) {
        let (around, along) = (builder.around(around), builder.divide(along, least));
        let sections: Vec<_> = steps(from, to, along).into_iter().map(|t| self.at(t)).collect();
        let ends = Ends::Closed(sections[0].0, sections[along].0);
        builder.turned(material, [along + 1, around], ends, |ring, angle| {
            let angle = if inward { -angle } else { angle };
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
    divisions: [usize; 3],
    ends: [DVec3; 2],
    [chord, tip_chord]: [f64; 2],
    thick: f64,
) {
    builder.ribbon(material, divisions, Some(DVec3::X), line(ends), |t| {
        let t2 = t * t;
        let out = sqrt((1.0 - 0.97 * t2 * t2 * t2 * t2).max(0.0));
        dvec2(mix(chord, tip_chord, t) * 0.5 * out, thick * mix(1.0, 0.5, t) * out)
    });
}

/// Spinner and blades before an engine, at the frame's origin, turned by `turn`.
fn propeller(builder: &mut MeshBuilder, blades: usize, radius: f64, turn: f64) {
    builder.frame = builder.frame.pitch(turn);
    let spinner = [[0.0, -0.12], [0.2, -0.1], [0.21, 0.05], [0.13, 0.28], [0.0, 0.4]];
    builder.within(builder.frame.roll(-TURN / 4.0), |here| here.revolve_smooth(POLISHED, [24, 14, 5], &spinner));
    for spoke in spokes(blades) {
        let (c, s) = (spoke.x, spoke.z);
        let path = |t: f64| dvec3(0.0, c, s) * mix(0.1, radius, t);
        builder.ribbon(BLACK, [12, 24, 6], Some(dvec3(0.55, -s * 0.8, c * 0.8)), path, |t| {
            let width = spline(&[[0.0, 0.05], [0.25, 0.11], [0.6, 0.14], [0.9, 0.1], [1.0, 0.03]], t);
            dvec2(width, mix(0.045, 0.012, t))
        });
    }
}

/// A wheel on an axle along z.
fn landing_wheel(builder: &mut MeshBuilder, middle: DVec3, radius: f64) {
    let small = radius * 0.32;
    let hub = [[0.0, -0.5 * small], [radius * 0.7, -0.4 * small], [radius * 0.7, 0.4 * small], [0.0, 0.5 * small]];
    builder.within(builder.frame.shift(middle).pitch(TURN / 4.0), |here| {
        here.torus(RUBBER, [10, 24, 3], DVec3::ZERO, [radius - small, small]);
        here.revolve_smooth(STEEL, [24, 8, 4], &hub);
    });
}

fn transport(builder: &mut MeshBuilder, motion: &Motion, here: Frame) {
    builder.object_at("transport aircraft", here);
    let hull = Hull {
        nose: 9.2,
        tail: -9.6,
        shares: [0.0, 0.03, 0.1, 0.2, 0.5, 0.75, 0.93, 1.0],
        wide: [0.12, 0.5, 0.95, 1.22, 1.25, 0.9, 0.35, 0.06],
        high: [0.12, 0.5, 0.98, 1.3, 1.35, 1.0, 0.5, 0.14],
        middle: [2.75, 2.75, 2.8, 2.9, 2.95, 3.05, 3.2, 3.25],
    };
    hull.skin(builder, POLISHED, [52, 80, 12], [0.0, 1.0], 0.0, false);
    hull.skin(builder, WHITE, [44, 54, 9], [0.12, 0.8], 0.09, true);
    cabin(builder);
    let blade = [28, 30, 6];
    let fin = [28, 28, 5];
    for face in [-1.0, 1.0] {
        let tip = dvec3(0.4, 3.0, face * 13.0);
        wing(builder, POLISHED, blade, [dvec3(1.6, 2.15, face * 0.3), tip], [4.4, 1.5], 0.28);
        let tip = dvec3(-9.0, 3.45, face * 3.9);
        wing(builder, POLISHED, fin, [dvec3(-8.2, 3.3, 0.0), tip], [2.2, 1.0], 0.1);
        // Engine, propeller and landing gear.
        let engine = dvec3(2.6, 2.55, face * 3.9);
        let nacelle = knots(
            [0.0, 0.12, 0.45, 0.66, 0.72, 0.55, 0.42, 0.4, 0.0],
            [-2.4, -2.3, -1.2, 0.4, 1.3, 1.62, 1.6, 1.2, 1.15],
        );
        builder.frame = here.shift(engine).roll(-TURN / 4.0);
        builder.revolve_smooth(POLISHED, [36, 28, 10], &nacelle);
        builder.frame = here.shift(engine);
        for spoke in spokes(9) {
            let (at, out) = (DVec3::X * 1.34, dvec3(0.0, spoke.x, spoke.z));
            builder.rod(STEEL, [10, 4], [at + out * 0.1, at + out * 0.41], 0.1);
        }
        builder.rod(STEEL, [12, 4], [DVec3::X * 1.1, DVec3::X * 1.85], 0.12);
        let side = if face < 0.0 { "left" } else { "right" };
        builder.object_at(format!("transport propeller {side}"), here.shift(engine + DVec3::X * 1.85));
        propeller(builder, 3, 1.75, face * motion.propeller);
        builder.object_at("transport landing gear", here);
        let axle = dvec3(3.0, 0.6 - SUNK, face * 3.9);
        landing_wheel(builder, axle, 0.6);
        for side in [-0.32, 0.32] {
            let low = axle + DVec3::Z * side;
            builder.rod(STEEL, [10, 8], [low, low + dvec3(-0.3, 1.75, 0.0)], 0.06);
            builder.rod(STEEL, [10, 8], [low, low + dvec3(-1.5, 1.7, 0.0)], 0.04);
        }
        builder.rod(STEEL, [8, 4], [axle - DVec3::Z * 0.4, axle + DVec3::Z * 0.4], 0.07);
    }
    builder.object_here("transport tail");
    wing(builder, POLISHED, fin, [dvec3(-7.9, 3.2, 0.0), dvec3(-9.3, 5.9, 0.0)], [2.9, 1.2], 0.12);
    landing_wheel(builder, dvec3(-7.6, 0.3 - SUNK, 0.0), 0.3);
    builder.rod(STEEL, [10, 8], [dvec3(-7.6, 0.3, 0.14), dvec3(-7.2, 2.9, 0.1)], 0.06);
}

/// Floor, seats, and windows that stand out of the skin a little.
fn cabin(builder: &mut MeshBuilder) {
    builder.cuboid(DARK_WOOD, dvec3(-4.0, 2.22, -0.8), dvec3(5.6, 2.28, 0.8), [12, 2, 4]);
    for row in 0..7 {
        let x = -3.3 + 1.15 * f64::from(row);
        for z in [-0.52, 0.52] {
            builder.slab(BLUE, [16, 5, 2], dvec3(x, 2.62, z), dvec3(0.24, 0.07, 0.23), 5.0);
            let back = line([dvec3(x - 0.2, 2.55, z), dvec3(x - 0.32, 3.25, z)]);
            builder.ribbon(BLUE, [16, 8, 2], Some(DVec3::Z), back, |_| dvec2(0.22, 0.06));
            builder.rod(STEEL, [8, 2], [dvec3(x, 2.26, z), dvec3(x, 2.6, z)], 0.05);
        }
        for (face, z) in [(-1.0, -1.2), (1.0, 1.2)] {
            builder.ball(GLASS, dvec3(x + 0.2, 3.2, z - 0.08 * face), 0.17, 16);
        }
    }
}

fn biplane(builder: &mut MeshBuilder, motion: &Motion, here: Frame) {
    builder.object_at("biplane", here);
    let hull = Hull {
        nose: 2.7,
        tail: -4.2,
        shares: [0.0, 0.06, 0.3, 0.6, 1.0],
        wide: [0.3, 0.5, 0.5, 0.33, 0.04],
        high: [0.3, 0.52, 0.6, 0.42, 0.16],
        middle: [1.6, 1.6, 1.6, 1.62, 1.65],
    };
    hull.skin(builder, YELLOW, [32, 44, 10], [0.0, 1.0], 0.0, false);
    let blade = [20, 24, 6];
    let fin = [20, 20, 5];
    let strut = [8, 8];
    for face in [-1.0, 1.0] {
        let ends = [dvec3(0.9, 1.2, face * 0.2), dvec3(0.6, 1.45, face * 4.6)];
        wing(builder, BLUE, blade, ends, [1.5, 1.2], 0.09);
        wing(builder, BLUE, blade, [dvec3(1.4, 2.78, 0.0), dvec3(1.2, 2.95, face * 5.0)], [1.5, 1.3], 0.09);
        wing(builder, BLUE, fin, [dvec3(-3.7, 1.7, 0.0), dvec3(-4.1, 1.72, face * 1.6)], [1.1, 0.6], 0.05);
        for z in [1.4, 3.4] {
            let [z, out] = [face * z, face * 0.05];
            for (low, high) in [(0.4, 0.95), (1.15, 1.7)] {
                builder.rod(DARK_WOOD, strut, [dvec3(low, 1.3, z), dvec3(high, 2.85, z + out)], 0.03);
            }
            for (a, b) in [(1.3, 2.85), (2.85, 1.3)] {
                builder.rod(STEEL, [6, 6], [dvec3(0.8, a, z + face * 0.06), dvec3(0.85, b, z - face * 1.15)], 0.012);
            }
        }
        landing_wheel(builder, dvec3(1.5, 0.38 - SUNK, face * 0.85), 0.38);
        for x in [1.0, 1.9] {
            builder.rod(STEEL, strut, [dvec3(1.5, 0.38, face * 0.72), dvec3(x, 1.25, face * 0.3)], 0.035);
        }
    }
    builder.rod(STEEL, strut, [dvec3(1.5, 0.37, -0.95), dvec3(1.5, 0.37, 0.95)], 0.04);
    wing(builder, BLUE, fin, [dvec3(-3.6, 1.6, 0.0), dvec3(-4.1, 2.75, 0.0)], [1.2, 0.7], 0.05);
    builder.rod(STEEL, strut, [dvec3(-4.0, 1.6, 0.0), dvec3(-4.2, -SUNK, 0.0)], 0.04);
    builder.object_at("biplane propeller", here.shift(dvec3(2.75, 1.6, 0.0)));
    propeller(builder, 2, 1.1, -motion.propeller);
}
