//! Sweets that lie about: wrapped ones, rings, gumdrops, beans, dragees.

use super::sticks::rounded;
use super::*;

pub(super) fn build(builder: &mut MeshBuilder, layout: &mut Layout) {
    doughnuts(builder, layout);
    ring_stacks(builder, layout);
    wrapped(builder, layout);
    gumdrops(builder, layout);
    beans(builder, layout);
    dragees(builder, layout);
}

/// A ring of dough, another of icing on it, and sprinkles.
fn doughnuts(builder: &mut MeshBuilder, layout: &mut Layout) {
    for number in 0..5 {
        let large = 0.26 + 0.04 * f64::from(number % 3);
        let small = 0.42 * large;
        let at = layout.spot(large + small, [1.2, 4.6]);
        // Some lean on edge.
        let upright = number % 2 == 1;
        place(builder, "doughnut", at, 1.3 * f64::from(number));
        let up = if upright { large + small } else { small };
        builder.frame = builder.frame.shift(DVec3::Y * (up - 0.02));
        if upright {
            builder.frame = builder.frame.pitch(TURN / 4.0 - 0.12);
        }
        let divisions = [24, 54, 8];
        builder.torus(DOUGH, divisions, DVec3::ZERO, [large, small]);
        let icing = if number % 2 == 0 { PINK } else { CHOCOLATE };
        builder.torus(icing, divisions, DVec3::Y * (0.13 * small), [large, 0.93 * small]);
        for sprinkle in 0..36 {
            let share = f64::from(sprinkle) / 36.0;
            let (angle, about) = (TURN * share, 0.09 * TURN * f64::from(sprinkle % 5 - 2));
            let flat = large + 0.93 * small * sin(about);
            let center = dvec3(flat * cos(angle), small * (0.13 + 0.93 * cos(about)), flat * sin(angle));
            let half = dvec3(0.022, 0.007, 0.007);
            let frame = builder.frame.shift(center).yaw(2.4 * f64::from(sprinkle));
            builder.within(frame, |here| here.ellipsoid(sweet(sprinkle as usize), DVec3::ZERO, half, 8));
        }
    }
}

/// Ring sweets on a stick, with a ball on top.
fn ring_stacks(builder: &mut MeshBuilder, layout: &mut Layout) {
    for number in 0..6 {
        let at = layout.spot(0.28, [1.1, 4.4]);
        place(builder, "ring stack", at, 0.0);
        let count = 4 + number % 3;
        let (large, small) = (0.17, 0.07);
        let top = f64::from(count) * 2.05 * small + 0.1;
        builder.rod(WHITE, [12, 16], [DVec3::Y * -0.05, DVec3::Y * top], 0.045);
        builder.ball(GOLD, DVec3::Y * top, 0.075, 24);
        for ring in 0..count {
            let center = DVec3::Y * (small - 0.01 + f64::from(ring) * 2.05 * small);
            let material = sweet((number * 3 + ring) as usize);
            builder.torus(material, [18, 40, 6], center, [large, small]);
        }
    }
}

/// Sweets in paper or foil, twisted at both ends.
fn wrapped(builder: &mut MeshBuilder, layout: &mut Layout) {
    for number in 0..18 {
        let at = layout.spot(0.26, if number < 7 { [0.9, 2.2] } else { [1.5, 4.8] });
        place(builder, "wrapped", at, layout.between(0.0, TURN));
        let (half, radius) = (0.3, 0.12 + 0.01 * (number % 3) as f64);
        builder.frame = builder.frame.shift(DVec3::Y * (radius - 0.01)).roll(TURN / 4.0);
        let rows = builder.divide(34, 6);
        let colours = match number % 4 {
            0 => [GOLD; 2],
            1 => [SILVER; 2],
            _ => [sweet(number), WHITE],
        };
        // The ends are hollow: their middles lie in where the fans are wide.
        let ends = Ends::Closed(DVec3::Y * (-0.8 * half), DVec3::Y * (0.8 * half));
        let stripe = |ring: usize, _: usize| colours[8 * ring / rows % 2];
        builder.turned(stripe, [rows, rows], ends, |ring, angle| {
            let along = 2.0 * ring as f64 / (rows - 1) as f64 - 1.0;
            let out = along.abs();
            let body = (1.0 - (out / 0.58) * (out / 0.58)).max(0.0).sqrt();
            let fan = smoothstep(0.55, 1.0, out);
            let pleat = 1.0 + 0.22 * fan * cos(10.0 * angle);
            let size = radius * (body.max(0.2) + 0.75 * fan) * pleat;
            dvec3(size * cos(angle), half * along, -size * sin(angle))
        });
    }
}

fn gumdrops(builder: &mut MeshBuilder, layout: &mut Layout) {
    const DROP: [[f64; 2]; 7] =
        [[0.0, 0.0], [0.85, 0.0], [1.0, 0.12], [0.92, 0.55], [0.72, 1.0], [0.4, 1.28], [0.0, 1.38]];
    for number in 0..34 {
        let size = layout.between(0.09, 0.17);
        let at = layout.spot(size, if number < 14 { [0.7, 2.2] } else { [1.4, 5.2] });
        place(builder, "gumdrop", at, 0.0);
        builder.frame = builder.frame.shift(DVec3::Y * -0.012);
        let knots = DROP.map(|knot| knot.map(|value| value * size));
        builder.revolve_smooth(sweet(number), [24, 18, 6], &knots);
    }
}

/// Bent beans with round ends.
fn beans(builder: &mut MeshBuilder, layout: &mut Layout) {
    for number in 0..70 {
        let at = layout.spot(0.075, if number < 30 { [0.6, 2.3] } else { [1.2, 5.2] });
        place(builder, "bean", at, layout.between(0.0, TURN));
        let thick = 0.038 + 0.002 * (number % 6) as f64;
        builder.frame = builder.frame.shift(DVec3::Y * (thick - 0.006)).roll(0.1 * (number % 5) as f64 - 0.2);
        let (bend, wide) = (0.09, 1.5);
        let path = |t: f64| {
            let angle = wide * (t - 0.5);
            dvec3(bend * sin(angle), 0.0, bend * (cos(angle) - 0.9))
        };
        let radius = |t: f64| rounded(thick, t.min(1.0 - t) * bend * wide);
        builder.tube(sweet(number * 2 + 1), [14, 14, 4], path, radius);
    }
}

/// Balls of sugar and silver.
fn dragees(builder: &mut MeshBuilder, layout: &mut Layout) {
    for number in 0..46 {
        let radius = layout.between(0.03, 0.075);
        let at = layout.spot(radius, if number < 20 { [0.6, 2.0] } else { [1.2, 5.2] });
        place(builder, "dragee", at, 0.0);
        let material = if number % 2 == 0 { SILVER } else { sweet(number) };
        builder.ellipsoid(material, DVec3::Y * (radius - 0.005), DVec3::splat(radius), 16);
    }
}
