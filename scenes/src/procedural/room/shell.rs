//! Floor, ceiling and walls with a window recess, watertight and seen from inside; skirting, door, window bars, picture.

use super::*;

/// The window in the back wall (least z): its x and y range.
const WINDOW: ([f64; 2], [f64; 2]) = ([-1.9, -0.1], [0.95, 2.35]);
/// How far the window lies behind the wall.
const RECESS: f64 = 0.28;

pub(super) fn build(builder: &mut MeshBuilder) {
    walls(builder);
    skirting(builder);
    window_bars(builder);
    door(builder);
    picture(builder);
}

/// The six sides share their lists of coordinates, and the recess those of its wall: every edge meets its equal.
fn walls(builder: &mut MeshBuilder) {
    let ([x0, x1], [y0, y1]) = WINDOW;
    let (xs, hole_x) = divided(builder, &[MIN.x, x0, x1, MAX.x]);
    let (ys, hole_y) = divided(builder, &[MIN.y, y0, y1, MAX.y]);
    let (zs, _) = divided(builder, &[MIN.z, 0.0, 0.0, MAX.z]);
    let x_side = |x: f64| move |u: f64, v: f64| dvec3(x, u, v);
    let y_side = |y: f64| move |u: f64, v: f64| dvec3(u, y, v);
    let z_side = |z: f64| move |u: f64, v: f64| dvec3(u, v, z);
    // du x dv points inwards: a side whose own cycle points outwards takes its two coordinates the other way round.
    builder.sheet(WALL, &ys, &zs, x_side(MIN.x));
    builder.sheet(WALL, &zs, &ys, |v, u| x_side(MAX.x)(u, v));
    builder.sheet(FLOOR, &zs, &xs, |v, u| y_side(MIN.y)(u, v));
    builder.sheet(CEILING, &xs, &zs, y_side(MAX.y));
    builder.sheet(WALL, &ys, &xs, |v, u| z_side(MAX.z)(u, v));
    let window = |column, row| hole_x.contains(&column) && hole_y.contains(&row);
    builder.sheet_with_holes(ACCENT, &xs, &ys, z_side(MIN.z), window);

    let inner_x = &xs[hole_x.start..=hole_x.end];
    let inner_y = &ys[hole_y.start..=hole_y.end];
    let depth = steps(MIN.z - RECESS, MIN.z, builder.along(1));
    builder.sheet(SKY, inner_x, inner_y, z_side(MIN.z - RECESS));
    builder.sheet(TRIM, inner_y, &depth, x_side(x0));
    builder.sheet(TRIM, &depth, inner_y, |v, u| x_side(x1)(u, v));
    builder.sheet(TRIM, &depth, inner_x, |v, u| y_side(y0)(u, v));
    builder.sheet(TRIM, inner_x, &depth, y_side(y1));
}

/// Coordinates from the first to the last of `stops`, with every stop among them, and the range of cells between the
/// two middle stops.
fn divided(builder: &MeshBuilder, stops: &[f64; 4]) -> (Vec<f64>, std::ops::Range<usize>) {
    let mut all = vec![stops[0]];
    let mut ends = [0; 3];
    for part in 0..3 {
        let (from, to) = (stops[part], stops[part + 1]);
        if to > from {
            // About 0.4 metres a cell at scale 1.
            let base = libm::ceil((to - from) / 0.4) as usize;
            all.extend_from_slice(&steps(from, to, builder.along(base))[1..]);
        }
        ends[part] = all.len() - 1;
    }
    (all, ends[0]..ends[1])
}

/// Boards along the walls. They differ in height and depth so that no faces coincide where two meet.
fn skirting(builder: &mut MeshBuilder) {
    let into = 0.02;
    for (side, height) in [(MIN.z, 0.09), (MAX.z, 0.091)] {
        let (near, far) = if side < 0.0 { (side - into, side + 0.014) } else { (side - 0.014, side + into) };
        builder.cuboid(TRIM, dvec3(MIN.x - into, -0.010, near), dvec3(MAX.x + into, height, far), [8, 0, 0]);
    }
    for (side, height) in [(MIN.x, 0.087), (MAX.x, 0.086)] {
        let (near, far) = if side < 0.0 { (side - 0.03, side + 0.013) } else { (side - 0.013, side + 0.03) };
        builder.cuboid(TRIM, dvec3(near, -0.012, MIN.z - 0.03), dvec3(far, height, MAX.z + 0.03), [0, 0, 8]);
    }
}

fn window_bars(builder: &mut MeshBuilder) {
    let ([x0, x1], [y0, y1]) = WINDOW;
    let sunk = 0.01;
    let back = MIN.z - RECESS + 0.05;
    for (x, half, z) in [((x0 + x1) / 2.0, 0.02, 0.020), (x0 + 0.45, 0.009, 0.012), (x1 - 0.45, 0.009, 0.012)] {
        let (min, max) = (dvec3(x - half, y0 - sunk, back - z), dvec3(x + half, y1 + sunk, back + z));
        builder.cuboid(TRIM, min, max, [0, 4, 0]);
    }
    for y in [1.42, 1.88] {
        let (min, max) = (dvec3(x0 - sunk, y - 0.008, back - 0.010), dvec3(x1 + sunk, y + 0.008, back + 0.010));
        builder.cuboid(TRIM, min, max, [6, 0, 0]);
    }
    // The sill stands out into the room.
    let min = dvec3(x0 - 0.06, y0 - 0.03, MIN.z - RECESS - 0.02);
    builder.cuboid(WOOD, min, dvec3(x1 + 0.06, y0 + 0.006, MIN.z + 0.07), [6, 0, 0]);
}

/// In the left wall (least x), near the front. Parts that stand out further also reach deeper, so that their backs do not
/// coincide.
fn door(builder: &mut MeshBuilder) {
    let wall = MIN.x;
    let mut part = |material, [z0, z1]: [f64; 2], [y0, y1]: [f64; 2], out: f64| {
        builder.cuboid(material, dvec3(wall - 0.01 - out, y0, z0), dvec3(wall + out, y1, z1), [0; 3]);
    };
    part(WOOD, [0.35, 1.25], [-0.02, 2.06], 0.03);
    part(TRIM, [0.27, 0.36], [-0.03, 2.05], 0.042);
    part(TRIM, [1.24, 1.33], [-0.03, 2.055], 0.042);
    part(TRIM, [0.26, 1.34], [2.04, 2.14], 0.045);
    for [y0, y1] in [[0.2, 0.95], [1.1, 1.9]] {
        part(DARK_WOOD, [0.47, 0.74], [y0, y1], 0.036);
        part(DARK_WOOD, [0.86, 1.13], [y0, y1], 0.036);
    }
}

/// On the right wall (greatest x), in front of the shelf.
fn picture(builder: &mut MeshBuilder) {
    let wall = MAX.x;
    let mut part = |material, [z0, z1]: [f64; 2], [y0, y1]: [f64; 2], out: f64| {
        builder.cuboid(material, dvec3(wall - out, y0, z0), dvec3(wall + 0.01 + out, y1, z1), [0; 3]);
    };
    part(DARK_WOOD, [0.9, 2.1], [1.2, 2.1], 0.035);
    part(SKY, [0.96, 2.04], [1.26, 2.04], 0.038);
    part(TAN_BOOK, [0.955, 2.045], [1.255, 1.5], 0.040);
    part(GREEN_BOOK, [1.1, 1.45], [1.45, 1.72], 0.042);
    part(RED_BOOK, [1.55, 1.8], [1.44, 1.86], 0.043);
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    /// Proves that the shell alone is watertight: each directed edge has exactly one that runs the other way, by the
    /// bits of its positions, so no ray slips through between two of its triangles.
    #[test]
    fn every_edge_of_the_shell_has_its_equal() {
        for scale in [0.001, 0.05, 1.0, 7.3] {
            let mut builder = MeshBuilder::new(scale, PALETTE);
            builder.object("walls");
            walls(&mut builder);
            let mesh = builder.finish();
            let key = |index: u32| mesh.positions[index as usize].map(|value| (value + 0.0).to_bits());
            let mut edges: HashMap<_, i32> = HashMap::new();
            for [a, b, c] in &mesh.triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *edges.entry((key(*from), key(*to))).or_default() += 1;
                }
            }
            assert!(edges.len() > 80);
            for ((from, to), count) in &edges {
                assert_eq!(*count, 1, "scale {scale}");
                assert_eq!(edges.get(&(*to, *from)), Some(&1), "scale {scale}");
            }
        }
    }
}
