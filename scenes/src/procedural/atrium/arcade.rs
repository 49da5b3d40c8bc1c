//! The colonnades: fluted columns with bases and capitals, piers and arches above them, balustrades upstairs.

use super::*;

/// Height of a column, of the arch above it over its feet, and of the pier, for either storey.
struct Storey {
    floor: f64,
    column: f64,
    rise: f64,
    top: f64,
    radius: f64,
}

const STOREYS: [Storey; 2] = [
    Storey { floor: FLOORS[0], column: 3.05, rise: 1.15, top: 4.6, radius: 0.27 },
    Storey { floor: FLOORS[1], column: 2.35, rise: 1.0, top: 3.75, radius: 0.21 },
];

pub(super) fn build(builder: &mut MeshBuilder) {
    for (level, storey) in STOREYS.iter().enumerate() {
        for (number, side) in Side::all().iter().enumerate() {
            let here = side.frame.shift(DVec3::Y * storey.floor);
            for bay in 0..side.bays {
                let x = side.column(bay);
                builder.object_at(format!("column {level}.{number}.{bay}"), here.shift(DVec3::X * x));
                column(builder, storey);
                let half = side.half / side.bays as f64;
                builder.object_at(format!("arch {level}.{number}.{bay}"), here.shift(DVec3::X * (x + half)));
                arch(builder, storey, half);
                if level == 1 {
                    builder.object_here(format!("balustrade {number}.{bay}"));
                    balustrade(builder, half);
                }
            }
        }
    }
}

/// Plinth, base, shaft with twelve flutes, capital, and the pier above.
fn column(builder: &mut MeshBuilder, storey: &Storey) {
    let r = storey.radius;
    let square = |half: f64, y: f64| dvec3(half, y, half);
    builder.cuboid(STONE, square(-1.55 * r, -SUNK), square(1.55 * r, 0.16), [2, 2, 2]);
    let base = knots(
        [0.0, 1.4 * r, 1.5 * r, 1.38 * r, 1.18 * r, 1.2 * r, 1.3 * r, 1.1 * r, 0.0],
        [0.15, 0.152, 0.2, 0.25, 0.28, 0.31, 0.34, 0.39, 0.4],
    );
    builder.revolve_smooth(STONE, [18, 12, 8], &base);
    let (bottom, top) = (0.38, storey.column - 0.4);
    let (around, rows) = (builder.around(48), builder.divide(8, 2));
    let ends = Ends::Closed(DVec3::Y * bottom, DVec3::Y * top);
    builder.turned(MARBLE, [rows + 1, around], ends, |ring, angle| {
        let up = ring as f64 / rows as f64;
        // The shaft swells a little and narrows towards the top.
        let body = r * (1.0 + 0.03 * sin(TURN / 2.0 * up) - 0.16 * up);
        let flute = 1.0 - 0.07 * (0.5 + 0.5 * cos(12.0 * angle));
        dvec3(body * flute * cos(angle), mix(bottom, top, up), -body * flute * sin(angle))
    });
    let y = storey.column;
    let capital = knots(
        [0.0, 0.95 * r, 1.02 * r, 0.93 * r, 0.95 * r, 1.25 * r, 1.5 * r, 1.4 * r, 0.0],
        [y - 0.42, y - 0.415, y - 0.38, y - 0.34, y - 0.24, y - 0.1, y - 0.07, y - 0.03, y - 0.025],
    );
    builder.revolve_smooth(MARBLE, [18, 14, 8], &capital);
    for (x, z) in CORNERS {
        // A volute at each corner.
        let at = dvec3(x * 1.12 * r, y - 0.12, z * 1.12 * r);
        builder.ball(MARBLE, at, 0.3 * r, 8);
    }
    builder.cuboid(STONE, square(-1.5 * r, y - 0.06), square(1.5 * r, y + 0.05), [2, 2, 2]);
    let pier = square(1.05 * r, storey.top + 0.015);
    builder.cuboid(STONE, dvec3(-pier.x, y, -pier.z), pier, [2, 6, 2]);
}

/// The wall above an arch, from its curve to a level top, and a moulding along the curve; x = 0 is its middle.
fn arch(builder: &mut MeshBuilder, storey: &Storey, half: f64) {
    let reach = half - 0.92 * storey.radius;
    let along = builder.divide(20, 4);
    // Arches that meet at a corner differ in height, so that their feet do not lie in one plane.
    let foot = storey.column + if half > 1.6 { 0.027 } else { 0.02 };
    let curve = |t: f64, out: f64| {
        let angle = TURN / 2.0 * t;
        dvec2(-(reach + out) * cos(angle), foot + (storey.rise + out) * sin(angle))
    };
    let shares = steps(0.0, 1.0, along);
    // From the curve (x = 0) to the top (x = 1), and from back to front.
    let wall = builder.outline(&[[0.0, -0.17], [1.0, -0.17], [1.0, 0.17], [0.0, 0.17]], &[4, 2]);
    let point = |t: f64, at: DVec2| {
        let low = curve(t, 0.0);
        dvec3(low.x, mix(low.y, storey.top, at.x), at.y)
    };
    let middle = dvec2(0.5, 0.0);
    let ends = Ends::Closed(point(0.0, middle), point(1.0, middle));
    builder.rings(WALL, [along + 1, wall.len()], ends, |ring, at| point(shares[ring], wall[at]));
    let moulding = builder.outline(&[[-0.03, -0.21], [0.14, -0.21], [0.14, 0.21], [-0.03, 0.21]], &[1, 2]);
    let point = |t: f64, at: DVec2| curve(t, at.x).extend(at.y);
    let ends = Ends::Closed(point(0.0, dvec2(0.05, 0.0)), point(1.0, dvec2(0.05, 0.0)));
    builder.rings(STONE, [along + 1, moulding.len()], ends, |ring, at| point(shares[ring], moulding[at]));
}

/// A rail, a sill, and turned balusters between two columns.
fn balustrade(builder: &mut MeshBuilder, half: f64) {
    let here = builder.frame;
    let reach = half - 0.15;
    for (y0, y1, deep) in [(-0.5 * SUNK, 0.12, 0.12), (0.92, 1.04, 0.13)] {
        builder.cuboid(STONE, dvec3(-reach, y0, -deep), dvec3(reach, y1, deep), [12, 1, 2]);
    }
    let profile = knots(
        [0.0, 0.06, 0.062, 0.035, 0.075, 0.06, 0.03, 0.032, 0.055, 0.058, 0.0],
        [0.11, 0.112, 0.16, 0.2, 0.36, 0.46, 0.62, 0.78, 0.84, 0.925, 0.93],
    );
    let count = 7;
    for number in 0..count {
        let x = (half - 0.42) * (2.0 * f64::from(number) / f64::from(count - 1) - 1.0);
        builder.frame = here.shift(DVec3::X * x);
        builder.revolve_smooth(MARBLE, [10, 12, 10], &profile);
    }
}
