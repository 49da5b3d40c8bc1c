//! Sweets that stand upright: canes, and lollipops on sticks.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder, layout: &mut Layout) {
    canes(builder, layout);
    coils(builder, layout);
    swirls(builder, layout);
}

/// Radius of a rounded end: `from_end` is the distance to it.
pub(super) fn rounded(radius: f64, from_end: f64) -> f64 {
    let inside = (1.0 - from_end / radius).clamp(0.0, 0.96);
    radius * (1.0 - inside * inside).sqrt()
}

/// Striped canes with a crook, stuck in the ground.
fn canes(builder: &mut MeshBuilder, layout: &mut Layout) {
    for number in 0..26 {
        let near = number < 10;
        let at = layout.spot(0.13, if near { [1.3, 3.0] } else { [2.2, 5.4] });
        let tall = layout.between(1.1, 2.5);
        // The near ones bow to the middle, as a roof.
        let yaw = if near { libm::atan2(at[1], -at[0]) } else { layout.between(0.0, TURN) };
        let lean = layout.between(-0.12, 0.12);
        place(builder, "cane", at, yaw);
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
        let [around, along] = [builder.around(16), builder.divide(76, 6)];
        let colours = [WHITE, if number % 3 == 2 { GREEN } else { RED }];
        let turns = libm::round(5.0 * length);
        let stripe = |ring: usize, at: usize| {
            let wound = 2.0 * at as f64 / around as f64 + turns * ring as f64 / along as f64;
            colours[wound as usize % 2]
        };
        let size = |t: f64| DVec2::splat(rounded(thick, t.min(1.0 - t) * length));
        builder.sweep(stripe, [around, along], None, path, size);
    }
}

/// Lollipops wound from a rope.
fn coils(builder: &mut MeshBuilder, layout: &mut Layout) {
    for number in 0..10 {
        let at = layout.spot(0.2, if number < 4 { [0.9, 2.4] } else { [1.8, 5.0] });
        let tall = layout.between(0.8, 1.9);
        place(builder, "coil", at, layout.between(0.0, TURN));
        let rope = 0.028 + 0.012 * tall;
        let turns = 4.5;
        let radius = rope * (1.05 + 2.06 * turns);
        builder.rod(WHITE, [10, 12], [DVec3::Y * -0.1, DVec3::Y * (tall - 0.4 * radius)], 0.022);
        builder.frame = builder.frame.shift(DVec3::Y * tall);
        let path = |t: f64| {
            // Between even in angle and even in length.
            let share = mix(t, t.sqrt(), 0.6);
            let angle = TURN * turns * share;
            let from_middle = rope * (1.05 + 2.06 * turns * share);
            dvec3(from_middle * cos(angle), from_middle * sin(angle), 0.0)
        };
        let along = builder.divide(200, 8);
        let colours = [sweet(number), WHITE, sweet(number + 3), WHITE];
        let stripe = |ring: usize, _: usize| colours[(32.0 * ring as f64 / along as f64) as usize % 4];
        let size = |t: f64| DVec2::splat(rounded(rope, t.min(1.0 - t) * 60.0 * rope));
        builder.sweep(stripe, [builder.around(12), along], None, path, size);
    }
}

/// Lollipops like lenses, with a swirl.
fn swirls(builder: &mut MeshBuilder, layout: &mut Layout) {
    for number in 0..10 {
        let at = layout.spot(0.2, if number < 4 { [1.0, 2.6] } else { [1.8, 5.0] });
        let tall = layout.between(0.7, 1.7);
        place(builder, "swirl", at, layout.between(0.0, TURN));
        let radius = 0.14 + 0.1 * tall;
        builder.rod(WHITE, [10, 12], [DVec3::Y * -0.1, DVec3::Y * (tall - 0.8 * radius)], 0.02);
        builder.frame = builder.frame.shift(DVec3::Y * tall).pitch(TURN / 4.0);
        let [around, rows] = [builder.divide(50, 8), builder.divide(20, 3)];
        let stripe = |ring: usize, at: usize| {
            let wound = 10.0 * at as f64 / around as f64 + 5.0 * ring as f64 / rows as f64;
            [sweet(number + 1), WHITE][wound as usize % 2]
        };
        let half = 0.3 * radius;
        let ends = Ends::Closed(DVec3::Y * -half, DVec3::Y * half);
        builder.turned(stripe, [rows, around], ends, |ring, angle| {
            let up = TURN / 2.0 * (ring + 1) as f64 / (rows + 1) as f64;
            dvec3(radius * sin(up) * cos(angle), -half * cos(up), -radius * sin(up) * sin(angle))
        });
    }
}
