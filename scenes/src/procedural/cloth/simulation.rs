//! The motion of the cloth: position-based dynamics (Müller et al. 2007) with compliance (Macklin et al. 2016), one
//! pass over the constraints in each of many small steps.
//!
//! Everything is done in one fixed order from time zero, so that a time has one state. Only additions, multiplications,
//! divisions and square roots are used.

use super::*;

/// Points a side of the simulated grid.
pub(super) const SIDE: usize = 41;
/// Radius of the ball in metres.
pub(super) const RADIUS: f64 = 0.55;
/// Middle of the ball, which rests on the floor (y = 0).
pub(super) const BALL: DVec3 = dvec3(0.0, RADIUS, 0.0);
/// How far points keep from ball and floor, in metres; folds of the cloth keep three times as far from each other.
pub(super) const THICKNESS: f64 = 0.012;

/// Side of the cloth in metres.
const LENGTH: f64 = 2.6;
/// Steps a second.
const RATE: f64 = 300.0;
/// Steps between two times that folds are kept apart.
const APART_EVERY: u64 = 4;
/// Metres a second squared.
const GRAVITY: f64 = 9.81;
/// Share of the speed that air takes each second.
const DRAG: f64 = 0.9;
/// Coulomb friction on ball and floor.
const FRICTION: f64 = 0.5;
/// Seconds at which the ball begins and ends to speed up.
const SPIN_FROM_TO: [f64; 2] = [1.1, 1.7];
/// Radians a second that the ball turns in the end.
const SPIN: f64 = 2.6;

/// Pairs of points at a rest distance.
struct Springs {
    pairs: Vec<[u32; 2]>,
    rest: f64,
    /// Compliance divided by the square of the step: 0 is stiff.
    soft: f64,
}

/// The cloth at one time.
pub(super) struct Cloth {
    /// Row by row.
    pub(super) positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
}

/// Angle by which the ball has turned, in radians.
pub(super) fn ball_turn(time_s: f64) -> f64 {
    // The integral of a speed that rises in a straight line.
    let [from, to] = SPIN_FROM_TO;
    let rising = (time_s - from).clamp(0.0, to - from);
    SPIN * (0.5 * rising * rising / (to - from) + (time_s - to).max(0.0))
}

impl Cloth {
    /// The cloth at a time in seconds, from 0.
    pub(super) fn at(time_s: f64) -> Self {
        let mut cloth = Self::start();
        let springs = springs();
        let steps = (time_s * RATE) as u64;
        for step in 0..steps {
            cloth.step(&springs, step);
        }
        let rest = time_s - steps as f64 / RATE;
        for (position, velocity) in cloth.positions.iter_mut().zip(&cloth.velocities) {
            *position += *velocity * rest;
        }
        cloth
    }

    /// Spread out above the ball, a little aside and not quite flat, so that it falls askew.
    fn start() -> Self {
        let mut positions = Vec::with_capacity(SIDE * SIDE);
        for row in 0..SIDE {
            for column in 0..SIDE {
                let [x, z] = [column, row].map(|at| (at as f64 / (SIDE - 1) as f64 - 0.5) * LENGTH);
                let wave = 0.012 * sin(3.1 * x + 1.0) * sin(2.3 * z + 0.4) + 0.006 * sin(7.0 * x - 5.0 * z);
                positions.push(dvec3(x + 0.08, 2.0 * RADIUS + 0.2 + wave, z - 0.05));
            }
        }
        Self { velocities: vec![DVec3::ZERO; positions.len()], positions }
    }

    fn step(&mut self, springs: &[Springs], step: u64) {
        let h = 1.0 / RATE;
        let before = self.positions.clone();
        for (position, velocity) in self.positions.iter_mut().zip(&mut self.velocities) {
            velocity.y -= GRAVITY * h;
            *position += *velocity * h;
        }
        for springs in springs {
            self.pull(springs);
        }
        let turn = ball_turn((step + 1) as f64 * h) - ball_turn(step as f64 * h);
        for (position, before) in self.positions.iter_mut().zip(&before) {
            *position = collide(*position, *before, turn);
        }
        let kept = 1.0 - DRAG * h;
        for ((position, velocity), before) in self.positions.iter().zip(&mut self.velocities).zip(&before) {
            *velocity = (*position - *before) * (RATE * kept);
        }
        if step.is_multiple_of(APART_EVERY) {
            self.keep_apart();
        }
    }

    /// Moves each pair towards its rest distance.
    fn pull(&mut self, springs: &Springs) {
        for &[a, b] in &springs.pairs {
            let (a, b) = (a as usize, b as usize);
            let apart = self.positions[b] - self.positions[a];
            let length = apart.length();
            if length > 0.0 {
                let move_by = apart * ((length - springs.rest) / (length * (2.0 + springs.soft)));
                self.positions[a] += move_by;
                self.positions[b] -= move_by;
            }
        }
    }

    /// Pushes points apart that came close without being neighbours, without giving them speed.
    fn keep_apart(&mut self) {
        let least = 3.0 * THICKNESS;
        let mut order: Vec<usize> = (0..self.positions.len()).collect();
        order.sort_by(|&a, &b| self.positions[a].x.total_cmp(&self.positions[b].x).then(a.cmp(&b)));
        let at: Vec<DVec3> = order.iter().map(|&index| self.positions[index]).collect();
        for (first, from) in at.iter().enumerate() {
            for (second, to) in at.iter().enumerate().skip(first + 1) {
                if to.x - from.x >= least {
                    break;
                }
                let apart = *to - *from;
                let squared = apart.length_squared();
                if squared >= least * least || squared == 0.0 {
                    continue;
                }
                let (a, b) = (order[first], order[second]);
                if (a / SIDE).abs_diff(b / SIDE) <= 1 && (a % SIDE).abs_diff(b % SIDE) <= 1 {
                    continue;
                }
                let distance = squared.sqrt();
                let push = apart * (0.25 * (least - distance) / distance);
                self.positions[a] -= push;
                self.positions[b] += push;
                // They go on together.
                let lag = (self.velocities[b] - self.velocities[a]) * 0.1;
                self.velocities[a] += lag;
                self.velocities[b] -= lag;
            }
        }
    }
}

/// The position moved out of ball and floor; friction takes from its way since `before`. The ball turned by `turn`.
fn collide(position: DVec3, before: DVec3, turn: f64) -> DVec3 {
    let mut position = position;
    let from_ball = position - BALL;
    let distance = from_ball.length();
    let depth = RADIUS + THICKNESS - distance;
    if depth > 0.0 && distance > 0.0 {
        let normal = from_ball / distance;
        position += normal * depth;
        let carried = dvec3(from_ball.z, 0.0, -from_ball.x) * turn;
        position = rub(position, before + carried, normal, depth);
    }
    let depth = THICKNESS - position.y;
    if depth > 0.0 {
        position.y = THICKNESS;
        position = rub(position, before, DVec3::Y, depth);
    }
    position
}

/// Takes from the way along the surface since `before` as much as friction can at this depth.
fn rub(position: DVec3, before: DVec3, normal: DVec3, depth: f64) -> DVec3 {
    let way = position - before;
    let along = way - normal * way.dot(normal);
    let length = along.length();
    if length == 0.0 { position } else { position - along * (FRICTION * depth / length).min(1.0) }
}

/// Threads, diagonals, and pairs two apart, which resist bending.
fn springs() -> Vec<Springs> {
    let cell = LENGTH / (SIDE - 1) as f64;
    let squared = RATE * RATE;
    let diagonal = cell * std::f64::consts::SQRT_2;
    let mut all = Vec::new();
    for (offsets, rest, compliance) in
        [([(1, 0), (0, 1)], cell, 0.0), ([(1, 1), (1, -1)], diagonal, 2e-6), ([(2, 0), (0, 2)], 2.0 * cell, 6e-5)]
    {
        for (right, down) in offsets {
            let mut pairs = Vec::new();
            for row in 0..SIDE as isize {
                for column in 0..SIDE as isize {
                    let (to_column, to_row) = (column + right, row + down);
                    let side = 0..SIDE as isize;
                    if side.contains(&to_column) && side.contains(&to_row) {
                        let index = |column: isize, row: isize| (row * SIDE as isize + column) as u32;
                        pairs.push([index(column, row), index(to_column, to_row)]);
                    }
                }
            }
            all.push(Springs { pairs, rest, soft: compliance * squared });
        }
    }
    all
}
