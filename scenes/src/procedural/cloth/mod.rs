//! The scene `cloth`: a square cloth falls over a ball onto a floor; then the ball turns and winds it up.
//!
//! A stand-in for the cloth animations that ray tracers of moving scenes are measured on (UNC's cloth over a ball has
//! 92 thousand triangles): one sheet that folds and moves everywhere at once, so that nothing of a structure can be
//! kept. The motion is simulated on a coarse grid, always from the start, and divided smoothly, so that every scale
//! moves alike. Viewpoints stand where the cloth never comes.

mod simulation;

use super::prelude::*;

use self::simulation::{BALL, Cloth, RADIUS, SIDE, THICKNESS, ball_turn};

/// Length of the animation in seconds.
pub(crate) const DURATION_S: f64 = 3.0;

palette! {
    FLOOR: [0.42, 0.4, 0.38], 0.0, 0.8;
    MIRROR: [0.9, 0.88, 0.84], 1.0, 0.03;
    CLOTH: [0.62, 0.12, 0.14], 0.0, 0.9;
}

/// Builds the scene with about `scale` times its triangles at scale 1, at a time in seconds.
pub(crate) fn build(scale: f64, time_s: f64) -> Mesh {
    let mut builder = MeshBuilder::new(scale, PALETTE);
    builder.object("floor");
    let lines = steps(-3.0, 3.0, builder.along(98));
    // Swapped, so that the upper side is its front.
    builder.sheet(FLOOR, &lines, &lines, |z, x| dvec3(x, 0.0, z));

    builder.object_at("ball", Frame::at(BALL).yaw(ball_turn(time_s)));
    let around = builder.around(108);
    let rows = (around / 2).max(2);
    let knots: Vec<[f64; 2]> = (0..=rows)
        .map(|row| {
            let angle = TURN / 2.0 * row as f64 / rows as f64;
            [if row % rows == 0 { 0.0 } else { RADIUS * sin(angle) }, -RADIUS * cos(angle)]
        })
        .collect();
    builder.lathe(MIRROR, around, &straight_profile(&knots, 1));

    builder.object("cloth");
    let state = Cloth::at(time_s);
    let shares = steps(0.0, 1.0, builder.along(176));
    builder.sheet(CLOTH, &shares, &shares, |v, u| outside(state.point(u, v)));
    builder.finish()
}

/// The point, moved out of the ball and the floor by the little that smoothing may have pushed it in.
fn outside(point: DVec3) -> DVec3 {
    let least = RADIUS + THICKNESS / 2.0;
    let from_ball = point - BALL;
    let distance = from_ball.length();
    let point = if distance < least { BALL + from_ball * (least / distance) } else { point };
    dvec3(point.x, point.y.max(THICKNESS / 2.0), point.z)
}

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
