//! Tools and vessels, each around its frame's origin.

use super::*;

/// Hangs down from the origin: a handle of `long` metres and an iron head.
pub(super) fn hammer(builder: &mut MeshBuilder, long: f64) {
    let handle = |t: f64| DVec3::Y * (-long * t);
    builder.tube(WOOD, [8, 6, 2], handle, |t| 0.014 + 0.006 * sin(3.0 * t));
    let head = |t: f64| dvec3(mix(-0.09, 0.09, t), -long + 0.03, 0.0);
    let size = |t: f64| DVec2::splat(0.03 + 0.012 * (2.0 * t - 1.0) * (2.0 * t - 1.0));
    builder.ribbon(IRON, [12, 6, 2], Some(DVec3::Z), head, size);
}

/// Hangs from the origin: two bent legs riveted together, with jaws.
pub(super) fn tongs(builder: &mut MeshBuilder, long: f64) {
    for face in [-1.0, 1.0] {
        let knots = [
            dvec3(0.045 * face, 0.0, 0.008 * face),
            dvec3(0.06 * face, -0.3 * long, 0.008 * face),
            dvec3(0.02 * face, -0.66 * long, 0.009 * face),
            dvec3(-0.035 * face, -0.8 * long, 0.009 * face),
            dvec3(-0.04 * face, -0.92 * long, 0.006 * face),
            dvec3(-0.006 * face, -long, 0.004 * face),
        ];
        builder.tube(IRON, [6, 16, 6], |t| curve(&knots, t), |t| 0.009 - 0.003 * t);
    }
    let rivet = dvec3(0.0, -0.71 * long, 0.0);
    builder.rod(STEEL, [8, 2], [rivet - DVec3::Z * 0.025, rivet + DVec3::Z * 0.025], 0.012);
}

/// A horseshoe in the plane z = 0, its bow at the origin, open downwards.
pub(super) fn horseshoe(builder: &mut MeshBuilder) {
    let path = |t: f64| {
        let angle = TURN * mix(-0.14, 0.64, t);
        dvec3(0.06 * cos(angle), -0.07 + 0.075 * sin(angle), 0.0)
    };
    builder.ribbon(STEEL, [6, 16, 6], Some(DVec3::Z), path, |_| dvec2(0.005, 0.013));
}

/// A sword that points down from its pommel at the origin.
pub(super) fn sword(builder: &mut MeshBuilder, long: f64) {
    let around = [8, 6, 2];
    builder.tube(LEATHER, around, |t| DVec3::Y * mix(0.0, -0.168, t), |t| 0.013 + 0.01 * t * (1.0 - t));
    builder.tube(STEEL, around, |t| dvec3(mix(-0.1, 0.1, t), -0.165, 0.0), |_| 0.012);
    let blade = |t: f64| DVec3::Y * mix(-0.162, -long, t);
    builder.ribbon(POLISHED, [8, 12, 3], Some(DVec3::X), blade, |t| {
        dvec2(mix(0.028, 0.02, t) * sqrt(1.0 - 0.97 * t * t * t * t * t * t), 0.005)
    });
    builder.torus(STEEL, [6, 12, 3], DVec3::Y * 0.02, [0.014, 0.009]);
}

/// A thin-walled pot of height and radius 1 times `size`, standing on the origin.
pub(super) fn pot(builder: &mut MeshBuilder, material: MaterialId, size: DVec2) {
    let knots =
        knots([0.0, 0.75, 1.0, 0.7, 0.79, 0.66, 0.93, 0.68, 0.0], [0.0, 0.01, 0.5, 0.93, 1.0, 0.94, 0.5, 0.07, 0.05]);
    let profile: Vec<DVec2> = smooth_profile(&knots, builder.divide(16, 8)).iter().map(|&point| point * size).collect();
    builder.revolve(material, 12, &profile);
}

/// An open bucket with a bail, standing on the origin.
pub(super) fn bucket(builder: &mut MeshBuilder, size: f64) {
    let knots = knots([0.0, 0.7, 0.78, 1.0, 0.97, 0.93, 0.72, 0.0], [0.0, 0.004, 0.1, 1.0, 1.01, 0.98, 0.1, 0.06]);
    let profile = smooth_profile(&knots, builder.divide(14, 7));
    let profile: Vec<DVec2> = profile.iter().map(|&point| point * dvec2(0.16, 0.3) * size).collect();
    builder.revolve(WOOD, 16, &profile);
    for (up, radius) in [(0.06, 0.128), (0.24, 0.151)] {
        builder.torus(IRON, [6, 16, 3], DVec3::Y * (up * size), [radius * size, 0.007 * size]);
    }
    let bail = |t: f64| {
        let angle = TURN / 2.0 * t;
        dvec3(-0.162 * cos(angle), 0.27 + 0.17 * sin(angle), 0.03 * sin(angle)) * size
    };
    builder.tube(IRON, [6, 12, 4], bail, |_| 0.006 * size);
}

/// A coil of rope lying on the origin.
pub(super) fn coil(builder: &mut MeshBuilder, radius: f64) {
    for turn in 0..4 {
        let at = dvec3(0.004 * f64::from(turn % 2), 0.02 + 0.033 * f64::from(turn), 0.003 * f64::from(turn));
        let wide = radius - 0.006 * f64::from(turn % 3);
        builder.torus(ROPE, [6, 20, 3], at, [wide, 0.019]);
    }
}

/// A round shield with its back on the plane z = 0 and a boss in front: a mirror.
pub(super) fn shield(builder: &mut MeshBuilder, r: f64) {
    builder.frame = builder.frame.pitch(TURN / 4.0);
    let profile = knots(
        [0.0, 0.6 * r, r, 1.01 * r, 0.94 * r, 0.55 * r, 0.28 * r, 0.2 * r, 0.0],
        [-0.04, -0.035, -0.008, 0.012, 0.018, 0.05, 0.065, 0.1, 0.125],
    );
    builder.revolve_smooth(POLISHED, [44, 20, 9], &profile);
    builder.torus(COPPER, [8, 44, 3], DVec3::Y * 0.008, [r, 0.016]);
}

/// A caged lantern hanging from the origin by its ring.
pub(super) fn lantern(builder: &mut MeshBuilder) {
    let ring = |t: f64| dvec3(0.035 * cos(TURN * t), -0.03 + 0.035 * sin(TURN * t), 0.0);
    builder.loop_tube(IRON, [6, 16, 3], ring, 0.005);
    builder.frame = builder.frame.shift(DVec3::Y * -0.4);
    let cap = [[0.0, 0.24], [0.11, 0.25], [0.07, 0.3], [0.02, 0.34], [0.0, 0.35]];
    builder.revolve_smooth(COPPER, [18, 10, 4], &cap);
    let dish = [[0.0, 0.0], [0.1, 0.004], [0.11, 0.03], [0.1, 0.035], [0.0, 0.02]];
    builder.revolve_smooth(COPPER, [18, 10, 4], &dish);
    let candle = [[0.0, 0.015], [0.025, 0.018], [0.024, 0.12], [0.008, 0.15], [0.0, 0.17]];
    builder.revolve_smooth(SACK, [12, 8, 4], &candle);
    for spoke in spokes(8) {
        let out = spoke * 0.1;
        builder.rod(IRON, [6, 4], [out + DVec3::Y * 0.02, out + DVec3::Y * 0.255], 0.004);
    }
    for up in [0.09, 0.17] {
        builder.torus(IRON, [6, 20, 3], DVec3::Y * up, [0.101, 0.0045]);
    }
}

/// A squashed sack lying on the origin.
pub(super) fn sack(builder: &mut MeshBuilder, size: f64) {
    let half = dvec3(0.36, 0.15, 0.24) * size;
    builder.slab(SACK, [26, 12, 3], DVec3::Y * (half.y - 0.01), half, 2.8);
    builder.rod(ROPE, [12, 4], [dvec3(0.3 * size, half.y, 0.0), dvec3(0.45 * size, half.y * 1.1, 0.0)], 0.045 * size);
}

/// An open box of five boards, standing on the origin.
pub(super) fn open_box(builder: &mut MeshBuilder, material: MaterialId, size: DVec3) {
    let half = size / 2.0;
    let thin = 0.012;
    let mut board = |min: DVec3, max: DVec3| builder.cuboid(material, min, max, [2, 2, 2]);
    board(dvec3(-half.x, 0.0, -half.z), dvec3(half.x, thin, half.z));
    for face in [-1.0, 1.0] {
        let (x, z) = (face * (half.x - thin), face * (half.z - 2.0 * thin));
        board(dvec3(x - thin, 0.004, -half.z + 0.002), dvec3(x + thin * 0.8, size.y, half.z - 0.002));
        board(dvec3(-half.x + 0.01, 0.003, z - thin), dvec3(half.x - 0.01, size.y - 0.004, z + thin));
    }
}
