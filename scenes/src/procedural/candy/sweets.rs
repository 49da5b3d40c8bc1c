//! Sweets that lie about: wrapped ones, rings, gumdrops, beans, dragees.

use glam::{DVec2, DVec3, dvec3};

use super::Candy;
use super::sticks::rounded;
use crate::procedural::builder::Ends;
use crate::procedural::math::{TURN, cos, sin, smoothstep};

pub(super) fn build(candy: &mut Candy) {
    doughnuts(candy);
    ring_stacks(candy);
    wrapped(candy);
    gumdrops(candy);
    beans(candy);
    dragees(candy);
}

/// A ring of dough, another of icing on it, and sprinkles.
fn doughnuts(candy: &mut Candy) {
    for number in 0..5 {
        let large = 0.26 + 0.04 * f64::from(number % 3);
        let small = 0.42 * large;
        let at = candy.layout.spot(large + small, [1.2, 4.6]);
        // Some lean on edge.
        let upright = number % 2 == 1;
        candy.place("doughnut", at, 1.3 * f64::from(number));
        let Candy { builder, palette, .. } = candy;
        let up = if upright { large + small } else { small };
        builder.frame = builder.frame.shift(DVec3::Y * (up - 0.02));
        if upright {
            builder.frame = builder.frame.pitch(TURN / 4.0 - 0.12);
        }
        let divisions = builder.bent(24, [54, 8]);
        builder.torus(palette.dough, divisions, DVec3::ZERO, [large, small]);
        let icing = if number % 2 == 0 { palette.pink } else { palette.chocolate };
        builder.torus(icing, divisions, DVec3::Y * (0.13 * small), [large, 0.93 * small]);
        for sprinkle in 0..36 {
            let share = f64::from(sprinkle) / 36.0;
            let (angle, about) = (TURN * share, 0.09 * TURN * f64::from(sprinkle % 5 - 2));
            let flat = large + 0.93 * small * sin(about);
            let center = dvec3(flat * cos(angle), small * (0.13 + 0.93 * cos(about)), flat * sin(angle));
            let half = dvec3(0.022, 0.007, 0.007);
            let frame = builder.frame;
            builder.frame = frame.shift(center).yaw(2.4 * f64::from(sprinkle));
            builder.ellipsoid(palette.sweet(sprinkle as usize), DVec3::ZERO, half, builder.divide(8, 3));
            builder.frame = frame;
        }
    }
}

/// Ring sweets on a stick, with a ball on top.
fn ring_stacks(candy: &mut Candy) {
    for number in 0..6 {
        let at = candy.layout.spot(0.28, [1.1, 4.4]);
        candy.place("ring stack", at, 0.0);
        let Candy { builder, palette, .. } = candy;
        let count = 4 + number % 3;
        let (large, small) = (0.17, 0.07);
        let top = f64::from(count) * 2.05 * small + 0.1;
        let stick = builder.round(12, 16);
        builder.rod(palette.white, stick, [dvec3(0.0, -0.05, 0.0), dvec3(0.0, top, 0.0)], 0.045);
        builder.ball(palette.gold, DVec3::Y * top, 0.075, builder.around(24));
        for ring in 0..count {
            let center = DVec3::Y * (small - 0.01 + f64::from(ring) * 2.05 * small);
            let material = palette.sweet((number * 3 + ring) as usize);
            builder.torus(material, builder.bent(18, [40, 6]), center, [large, small]);
        }
    }
}

/// Sweets in paper or foil, twisted at both ends.
fn wrapped(candy: &mut Candy) {
    for number in 0..18 {
        let near = number < 7;
        let at = candy.layout.spot(0.26, if near { [0.9, 2.2] } else { [1.5, 4.8] });
        let yaw = candy.layout.between(0.0, TURN);
        candy.place("wrapped", at, yaw);
        let Candy { builder, palette, .. } = candy;
        let (half, radius) = (0.3, 0.12 + 0.01 * (number % 3) as f64);
        builder.frame = builder.frame.shift(DVec3::Y * (radius - 0.01)).roll(TURN / 4.0);
        let [around, rows] = [builder.divide(34, 6), builder.divide(34, 6)];
        let colours = match number % 4 {
            0 => [palette.gold; 2],
            1 => [palette.silver; 2],
            _ => [palette.sweet(number), palette.white],
        };
        // The ends are hollow: their middles lie in where the fans are wide.
        let ends = Ends::Closed(DVec3::Y * (-0.8 * half), DVec3::Y * (0.8 * half));
        builder.striped_rings(
            |ring, _| colours[8 * ring / rows % 2],
            rows,
            around,
            &ends,
            |ring, at| {
                let along = 2.0 * ring as f64 / (rows - 1) as f64 - 1.0;
                let out = along.abs();
                let angle = TURN * at as f64 / around as f64;
                let body = (1.0 - (out / 0.58) * (out / 0.58)).max(0.0).sqrt();
                let fan = smoothstep(0.55, 1.0, out);
                let pleat = 1.0 + 0.22 * fan * cos(10.0 * angle);
                let size = radius * (body.max(0.2) + 0.75 * fan) * pleat;
                dvec3(size * cos(angle), half * along, -size * sin(angle))
            },
        );
    }
}

fn gumdrops(candy: &mut Candy) {
    const DROP: [[f64; 2]; 7] =
        [[0.0, 0.0], [0.85, 0.0], [1.0, 0.12], [0.92, 0.55], [0.72, 1.0], [0.4, 1.28], [0.0, 1.38]];
    for number in 0..34 {
        let near = number < 14;
        let size = candy.layout.between(0.09, 0.17);
        let at = candy.layout.spot(size, if near { [0.7, 2.2] } else { [1.4, 5.2] });
        candy.place("gumdrop", at, 0.0);
        let Candy { builder, palette, .. } = candy;
        builder.frame = builder.frame.shift(DVec3::Y * -0.012);
        let knots = DROP.map(|knot| knot.map(|value| value * size));
        builder.revolve_smooth(palette.sweet(number), builder.bent(24, [18, 6]), &knots);
    }
}

/// Bent beans with round ends.
fn beans(candy: &mut Candy) {
    for number in 0..70 {
        let near = number < 30;
        let at = candy.layout.spot(0.075, if near { [0.6, 2.3] } else { [1.2, 5.2] });
        let yaw = candy.layout.between(0.0, TURN);
        candy.place("bean", at, yaw);
        let Candy { builder, palette, .. } = candy;
        let thick = 0.038 + 0.002 * (number % 6) as f64;
        builder.frame = builder.frame.shift(DVec3::Y * (thick - 0.006)).roll(0.1 * (number % 5) as f64 - 0.2);
        let (bend, wide) = (0.09, 1.5);
        let path = |t: f64| {
            let angle = wide * (t - 0.5);
            dvec3(bend * sin(angle), 0.0, bend * (cos(angle) - 0.9))
        };
        let radius = |t: f64| rounded(thick, t.min(1.0 - t) * bend * wide);
        builder.tube(palette.sweet(number * 2 + 1), builder.bent(14, [14, 4]), path, radius);
    }
}

/// Balls of sugar and silver.
fn dragees(candy: &mut Candy) {
    for number in 0..46 {
        let near = number < 20;
        let radius = candy.layout.between(0.03, 0.075);
        let at = candy.layout.spot(radius, if near { [0.6, 2.0] } else { [1.2, 5.2] });
        candy.place("dragee", at, 0.0);
        let Candy { builder, palette, .. } = candy;
        let material = if number % 2 == 0 { palette.silver } else { palette.sweet(number) };
        builder.ellipsoid(
            material,
            DVec3::Y * (radius - 0.005),
            DVec2::splat(radius).extend(radius),
            builder.around(16),
        );
    }
}
