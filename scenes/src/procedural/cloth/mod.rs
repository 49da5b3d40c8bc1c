//! The scene `cloth`: a square cloth falls over a ball onto a floor; then the ball turns and winds it up.
//!
//! A stand-in for the cloth animations that ray tracers of moving scenes are measured on (UNC's cloth over a ball has
//! 92 thousand triangles): one sheet that folds and moves everywhere at once, so that nothing of a structure can be
//! kept. The motion is simulated on a coarse grid, always from the start, and divided smoothly, so that every scale
//! moves alike.

mod simulation;

use glam::{DVec3, dvec3};

use self::simulation::{BALL, Cloth, RADIUS, SIDE, THICKNESS, ball_turn};
use super::builder::MeshBuilder;
use super::math::{Frame, TURN, cos, sin};
use super::shapes::steps;
use super::{Built, NamedPose, cameras, path};

/// Triangles at scale 1, held by a test.
pub(crate) const TRIANGLES_AT_SCALE_1: u64 = 92_608;
/// Length of the animation in seconds.
pub(crate) const DURATION_S: f64 = 3.0;

/// Half the side of the floor, in metres.
const FLOOR: f64 = 3.0;

/// Builds the scene with about `scale` times its triangles at scale 1, at a time in seconds.
pub(crate) fn build(scale: f64, time_s: f64) -> Built {
    let mut builder = MeshBuilder::new(scale);
    let floor = builder.material([0.42, 0.4, 0.38], 0.0, 0.8);
    let ball = builder.material([0.9, 0.88, 0.84], 1.0, 0.03);
    let cloth = builder.material([0.62, 0.12, 0.14], 0.0, 0.9);

    builder.object("floor");
    let lines = steps(-FLOOR, FLOOR, builder.along(98));
    // Swapped, so that the upper side is its front.
    builder.sheet(floor, &lines, &lines, |z, x| dvec3(x, 0.0, z), |_, _| false);

    builder.object("ball");
    builder.frame = Frame::at(BALL).yaw(ball_turn(time_s));
    let around = builder.around(108);
    let rows = (around / 2).max(2);
    let profile: Vec<[f64; 2]> = (0..=rows)
        .map(|row| {
            let angle = TURN / 2.0 * row as f64 / rows as f64;
            [if row % rows == 0 { 0.0 } else { RADIUS * sin(angle) }, -RADIUS * cos(angle)]
        })
        .collect();
    builder.revolve_straight(ball, [around, 1], &profile);

    builder.object("cloth");
    let state = Cloth::at(time_s);
    let shares = steps(0.0, 1.0, builder.along(176));
    builder.sheet(cloth, &shares, &shares, |v, u| outside(state.point(u, v)), |_, _| false);
    Built { mesh: builder.finish(), cameras: cameras(&VIEWPOINTS), path: path(&PATH) }
}

/// The point, moved out of the ball and the floor by the little that smoothing may have pushed it in.
fn outside(point: DVec3) -> DVec3 {
    let least = RADIUS + THICKNESS / 2.0;
    let from_ball = point - BALL;
    let distance = from_ball.length();
    let point = if distance < least { BALL + from_ball * (least / distance) } else { point };
    dvec3(point.x, point.y.max(THICKNESS / 2.0), point.z)
}

/// All stand where the cloth never comes.
const VIEWPOINTS: [NamedPose; 6] = [
    ("front", [0.5, 1.35, 2.3], [0.0, 0.65, 0.0]),
    ("low", [-1.9, 0.35, 1.2], [0.0, 0.5, 0.0]),
    ("above", [0.3, 2.9, 1.0], [0.0, 0.4, 0.0]),
    ("corner", [1.6, 0.5, 1.5], [0.3, 0.35, 0.3]),
    ("back", [-1.0, 0.9, -2.1], [0.0, 0.5, 0.0]),
    ("floor", [0.3, 0.12, 2.1], [-0.1, 0.45, 0.0]),
];

/// Half a circle around the ball, from the front to the back.
const PATH: [([f32; 3], [f32; 3]); 4] = [
    ([0.5, 1.35, 2.3], [0.0, 0.9, 0.0]),
    ([2.0, 1.2, 1.4], [0.0, 0.7, 0.0]),
    ([2.2, 1.0, -0.8], [0.0, 0.5, 0.0]),
    ([1.0, 0.9, -2.1], [0.0, 0.4, 0.0]),
];

impl Cloth {
    /// The point at shares (0 to 1) of the cloth's sides: a cubic B-spline over the grid, which keeps its borders.
    fn point(&self, u: f64, v: f64) -> DVec3 {
        let (column, across) = weights(u);
        let (row, along) = weights(v);
        let mut sum = DVec3::ZERO;
        for (j, weight_v) in along.into_iter().enumerate() {
            let mut line = DVec3::ZERO;
            for (i, weight_u) in across.into_iter().enumerate() {
                line += self.control(column + i as isize - 1, row + j as isize - 1) * weight_u;
            }
            sum += line * weight_v;
        }
        sum
    }

    /// A point of the grid; one step beyond the border the cloth goes on straight.
    fn control(&self, column: isize, row: isize) -> DVec3 {
        const LAST: isize = SIDE as isize - 1;
        let beyond = |at: isize| {
            if at < 0 {
                1
            } else if at > LAST {
                LAST - 1
            } else {
                at
            }
        };
        let at = |column: isize, row: isize| self.positions[row as usize * SIDE + column as usize];
        match ((0..=LAST).contains(&column), (0..=LAST).contains(&row)) {
            (true, true) => at(column, row),
            (false, _) => {
                let border = column.clamp(0, LAST);
                self.control(border, row) * 2.0 - self.control(beyond(column), row)
            }
            (true, false) => at(column, row.clamp(0, LAST)) * 2.0 - at(column, beyond(row)),
        }
    }
}

/// The grid cell at a share of a side, and the weights of the control points from one before it to two after.
fn weights(share: f64) -> (isize, [f64; 4]) {
    let at = share * (SIDE - 1) as f64;
    let cell = (at as usize).min(SIDE - 2);
    let t = at - cell as f64;
    let (t2, t3) = (t * t, t * t * t);
    let s = 1.0 - t;
    let weights = [s * s * s, 3.0 * t3 - 6.0 * t2 + 4.0, -3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0, t3];
    (cell as isize, weights.map(|weight| weight / 6.0))
}
