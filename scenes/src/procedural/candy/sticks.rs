//! Sweets that stand upright: canes, and lollipops on sticks.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::Candy;
use crate::procedural::builder::Ends;
use crate::procedural::math::{TURN, cos, mix, sin};

pub(super) fn build(candy: &mut Candy) {
    canes(candy);
    coils(candy);
    swirls(candy);
}

/// Radius of a rounded end: `from_end` is the distance to it.
pub(super) fn rounded(radius: f64, from_end: f64) -> f64 {
    let inside = (1.0 - from_end / radius).clamp(0.0, 0.96);
    radius * (1.0 - inside * inside).sqrt()
}

/// Striped canes with a crook, stuck in the ground.
fn canes(candy: &mut Candy) {
    for number in 0..26 {
        let near = number < 10;
        let at = candy.layout.spot(0.13, if near { [1.3, 3.0] } else { [2.2, 5.4] });
        let tall = candy.layout.between(1.1, 2.5);
        // The near ones bow to the middle, as a roof.
        let yaw = if near { libm::atan2(at[1], -at[0]) } else { candy.layout.between(0.0, TURN) };
        let lean = candy.layout.between(-0.12, 0.12);
        candy.place("cane", at, yaw);
        let Candy { builder, palette, .. } = candy;
        builder.frame = builder.frame.roll(lean - if near { 0.12 } else { 0.0 });
        let thick = 0.045 + 0.016 * tall;
        let crook = 0.13 + 0.1 * tall;
        let (straight, arc) = (tall - crook + 0.1, TURN / 2.0 * crook);
        let length = straight + arc + 0.3 * crook;
        let path = |t: f64| {
            let way = t * length;
            if way < straight {
                dvec3(0.0, way - 0.1, 0.0)
            } else if way < straight + arc {
                let angle = (way - straight) / crook;
                dvec3(crook * (1.0 - cos(angle)), straight - 0.1 + crook * sin(angle), 0.0)
            } else {
                dvec3(2.0 * crook, straight - 0.1 - (way - straight - arc), 0.0)
            }
        };
        let [around, along] = builder.bent(16, [76, 6]);
        let colours = [palette.white, if number % 3 == 2 { palette.green } else { palette.red }];
        let turns = libm::round(5.0 * length);
        let stripe = |ring: usize, at: usize| {
            let wound = 2.0 * at as f64 / around as f64 + turns * ring as f64 / along as f64;
            colours[wound as usize % 2]
        };
        let size = |t: f64| DVec2::splat(rounded(thick, t.min(1.0 - t) * length));
        builder.striped_ribbon(stripe, [around, along], None, path, size);
    }
}

/// Lollipops wound from a rope.
fn coils(candy: &mut Candy) {
    for number in 0..10 {
        let near = number < 4;
        let at = candy.layout.spot(0.2, if near { [0.9, 2.4] } else { [1.8, 5.0] });
        let tall = candy.layout.between(0.8, 1.9);
        let yaw = candy.layout.between(0.0, TURN);
        candy.place("coil", at, yaw);
        let Candy { builder, palette, .. } = candy;
        let rope = 0.028 + 0.012 * tall;
        let turns = 4.5;
        let radius = rope * (1.05 + 2.06 * turns);
        let stick = builder.round(10, 12);
        builder.rod(palette.white, stick, [dvec3(0.0, -0.1, 0.0), dvec3(0.0, tall - 0.4 * radius, 0.0)], 0.022);
        builder.frame = builder.frame.shift(DVec3::Y * tall);
        let path = |t: f64| {
            // Between even in angle and even in length.
            let share = mix(t, t.sqrt(), 0.6);
            let angle = TURN * turns * share;
            let from_middle = rope * (1.05 + 2.06 * turns * share);
            dvec3(from_middle * cos(angle), from_middle * sin(angle), 0.0)
        };
        let [around, along] = builder.bent(12, [200, 8]);
        let colours = [palette.sweet(number), palette.white, palette.sweet(number + 3), palette.white];
        let stripe = |ring: usize, _: usize| colours[(32.0 * ring as f64 / along as f64) as usize % 4];
        let size = |t: f64| DVec2::splat(rounded(rope, t.min(1.0 - t) * 60.0 * rope));
        builder.striped_ribbon(stripe, [around, along], None, path, size);
    }
}

/// Lollipops like lenses, with a swirl.
fn swirls(candy: &mut Candy) {
    for number in 0..10 {
        let near = number < 4;
        let at = candy.layout.spot(0.2, if near { [1.0, 2.6] } else { [1.8, 5.0] });
        let tall = candy.layout.between(0.7, 1.7);
        let yaw = candy.layout.between(0.0, TURN);
        candy.place("swirl", at, yaw);
        let Candy { builder, palette, .. } = candy;
        let radius = 0.14 + 0.1 * tall;
        let stick = builder.round(10, 12);
        builder.rod(palette.white, stick, [dvec3(0.0, -0.1, 0.0), dvec3(0.0, tall - 0.8 * radius, 0.0)], 0.02);
        builder.frame = builder.frame.shift(DVec3::Y * tall).pitch(TURN / 4.0);
        let [around, rows] = [builder.divide(50, 8), builder.divide(20, 3)];
        let colours = [palette.sweet(number + 1), palette.white];
        let half = dvec2(radius, 0.3 * radius);
        builder.striped_rings(
            |ring, at| {
                let wound = 10.0 * at as f64 / around as f64 + 5.0 * ring as f64 / rows as f64;
                colours[wound as usize % 2]
            },
            rows,
            around,
            &Ends::Closed(DVec3::Y * -half.y, DVec3::Y * half.y),
            |ring, at| {
                let up = TURN / 2.0 * (ring + 1) as f64 / (rows + 1) as f64;
                let angle = TURN * at as f64 / around as f64;
                dvec3(half.x * sin(up) * cos(angle), -half.y * cos(up), -half.x * sin(up) * sin(angle))
            },
        );
    }
}
