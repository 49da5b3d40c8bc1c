//! Trees and bushes: tapering tubes for wood, kites of four triangles for leaves.

use super::*;

/// A curved piece of wood.
struct Branch {
    from: DVec3,
    to: DVec3,
    /// How far its middle is off the straight line.
    bow: DVec3,
    /// Radii at either end in metres.
    radius: [f64; 2],
}

impl Branch {
    fn at(&self, t: f64) -> DVec3 {
        self.from + (self.to - self.from) * t + self.bow * (4.0 * t * (1.0 - t))
    }
}

/// What a kind of plant looks like.
struct Kind {
    bark: MaterialId,
    leaf: MaterialId,
    /// Length of a leaf in metres at scale 1; its width is a share of that.
    length: f64,
    width: f64,
    /// Leaves at scale 1.
    leaves: usize,
    /// How far the wind bends the top, as a share of the height.
    limp: f64,
}

/// A plant: what grows where, how tall it is, and the phase of its swing.
struct Plant<'a> {
    kind: &'a Kind,
    seed: u64,
    root: DVec3,
    height: f64,
    phase: f64,
    /// The branches that leaves grow on.
    twigs: Vec<Branch>,
}

pub(super) fn build(builder: &mut MeshBuilder, setting: Setting) {
    let oak = Kind { bark: OAK_BARK, leaf: OAK_LEAF, length: 0.43, width: 0.66, leaves: 5800, limp: 0.05 };
    let birch = Kind { bark: BIRCH_BARK, leaf: BIRCH_LEAF, length: 0.36, width: 0.68, leaves: 5800, limp: 0.08 };
    let bush = Kind { bark: OAK_BARK, leaf: BUSH_LEAF, length: 0.24, width: 0.56, leaves: 2200, limp: 0.1 };
    let trees = [
        (&oak, -2.4, -1.6, 6.4),
        (&birch, 2.3, -2.4, 6.8),
        (&oak, 5.4, -1.2, 6.0),
        (&birch, -5.4, -0.6, 6.2),
        (&oak, 0.2, -5.2, 7.2),
        (&birch, -3.8, -5.0, 7.0),
        (&oak, 4.2, -5.6, 7.2),
        (&birch, -7.8, -4.4, 6.6),
        (&birch, 8.4, 3.2, 6.0),
        (&oak, -1.6, -8.6, 7.4),
    ];
    for (number, &(kind, x, z, height)) in trees.iter().enumerate() {
        builder.object(format!("tree {number}"));
        let plant = tree(builder, setting, kind, number as u64, [x, z, height]);
        leaves(builder, setting, &plant);
    }
    let bushes = [
        (-2.2, 1.4, 1.5),
        (-0.9, -1.9, 1.3),
        (-4.6, -0.6, 1.8),
        (3.9, -0.8, 1.5),
        (4.6, 2.2, 1.2),
        (0.6, -4.6, 1.9),
        (-4.4, 3.6, 1.4),
        (5.6, -4.6, 1.8),
        (-5.0, -4.4, 2.0),
        (-9.0, 3.4, 1.7),
    ];
    for (number, &(x, z, height)) in bushes.iter().enumerate() {
        builder.object(format!("bush {number}"));
        let plant = shrub(builder, setting, &bush, 100 + number as u64, [x, z, height]);
        leaves(builder, setting, &plant);
    }
}

/// A direction with the given heading and rise, both in radians.
fn direction(heading: f64, rise: f64) -> DVec3 {
    dvec3(cos(heading) * cos(rise), sin(rise), sin(heading) * cos(rise))
}

/// The wood of a tree: a trunk, limbs around it, twigs on these.
fn tree<'a>(
    builder: &mut MeshBuilder,
    setting: Setting,
    kind: &'a Kind,
    seed: u64,
    [x, z, height]: [f64; 3],
) -> Plant<'a> {
    let mut random = Random(9000 + seed);
    let root = dvec3(x, ground::height(x, z) - 0.15, z);
    let mut plant = Plant { kind, seed, root, height, phase: random.between(0.0, TURN), twigs: Vec::new() };
    let lean = dvec3(random.between(-0.4, 0.4), height * 0.93, random.between(-0.4, 0.4));
    let bow = dvec3(random.between(-0.25, 0.25), 0.0, random.between(-0.25, 0.25));
    let trunk = Branch { from: root, to: root + lean, bow, radius: [height * 0.026, 0.02] };
    wood(builder, setting, &plant, [12, 16, 3], &trunk);
    for limb in 0..15 {
        let up = mix(0.16, 0.96, (f64::from(limb) + random.between(-0.2, 0.2)) / 14.0).clamp(0.14, 0.97);
        let heading = TURN * 0.382 * f64::from(limb) + random.between(-0.3, 0.3);
        let long = height * mix(0.5, 0.2, up) * random.between(0.85, 1.15);
        let from = trunk.at(up);
        let to = from + direction(heading, random.between(0.15, 0.65)) * long;
        let thick = mix(0.055, 0.02, up);
        let limb = Branch { from, to, bow: DVec3::Y * (-0.06 * long), radius: [thick, 0.012] };
        wood(builder, setting, &plant, [7, 8, 2], &limb);
        for twig in 0..5 {
            let at = mix(0.35, 0.95, f64::from(twig) / 4.0);
            let side = if twig % 2 == 0 { 0.8 } else { -0.8 };
            let from = limb.at(at);
            let long = long * random.between(0.28, 0.42);
            let to = from + direction(heading + side + random.between(-0.3, 0.3), random.between(-0.2, 0.6)) * long;
            let twig = Branch { from, to, bow: DVec3::Y * (0.08 * long), radius: [0.012, 0.004] };
            wood(builder, setting, &plant, [5, 5, 1], &twig);
            plant.twigs.push(twig);
        }
    }
    plant
}

/// The wood of a bush: stems from one root that lean outwards.
fn shrub<'a>(
    builder: &mut MeshBuilder,
    setting: Setting,
    kind: &'a Kind,
    seed: u64,
    [x, z, height]: [f64; 3],
) -> Plant<'a> {
    let mut random = Random(9000 + seed);
    let root = dvec3(x, ground::height(x, z) - 0.06, z);
    let mut plant = Plant { kind, seed, root, height, phase: random.between(0.0, TURN), twigs: Vec::new() };
    for stem in 0..14 {
        let heading = TURN * 0.382 * f64::from(stem) + random.between(-0.2, 0.2);
        let long = height * random.between(0.7, 1.05);
        let from = root + direction(heading, 0.0) * random.between(0.02, 0.1);
        let to = from + direction(heading, random.between(0.55, 1.4)) * long;
        let bow = direction(heading, 0.0) * (0.1 * long);
        let stem = Branch { from, to, bow, radius: [0.014, 0.004] };
        wood(builder, setting, &plant, [5, 8, 2], &stem);
        plant.twigs.push(stem);
    }
    plant
}

fn wood(builder: &mut MeshBuilder, setting: Setting, plant: &Plant<'_>, divisions: [usize; 3], branch: &Branch) {
    let path = |t: f64| plant.blown(setting, branch.at(t));
    builder.tube(plant.kind.bark, divisions, path, |t| mix(branch.radius[0], branch.radius[1], t));
}

impl Plant<'_> {
    /// Where a point of the plant is in the wind.
    fn blown(&self, setting: Setting, point: DVec3) -> DVec3 {
        setting.bend(point, (point.y - self.root.y) / self.height, self.kind.limp * self.height, self.phase)
    }
}

/// Leaves on the outer parts of the twigs: base, two sides, tip, and a middle that folds them along their length.
fn leaves(builder: &mut MeshBuilder, setting: Setting, plant: &Plant<'_>) {
    let kind = plant.kind;
    for number in 0..setting.count(kind.leaves) {
        let mut random = Random((plant.seed << 32) + number as u64 * 0x9e37_79b9);
        let twig = &plant.twigs[random.between(0.0, plant.twigs.len() as f64) as usize % plant.twigs.len()];
        let base = twig.at(random.between(0.15, 1.0));
        let heading = random.between(0.0, TURN);
        let out = direction(heading, random.between(-0.9, 0.7));
        let flat = out.cross(direction(random.between(0.0, TURN), random.between(0.2, 1.2))).normalize_or(DVec3::X);
        let normal = flat.cross(out);
        let size = kind.length * random.between(0.7, 1.2) * setting.size();
        let half = flat * (0.5 * size * kind.width);
        let turn = random.between(0.0, TURN);
        let cycles = if random.between(0.0, 1.0) < 0.5 { 4.0 } else { 5.0 };
        let material = if random.between(0.0, 1.0) < 0.12 { AUTUMN_LEAF } else { kind.leaf };
        let base = plant.blown(setting, base);
        // The stalk holds the leaf off the wood.
        let stalk = base + out * (0.12 * size);
        let flutter = 0.16 * size * setting.swing(cycles, turn);
        let fold = 0.1 * size;
        let points = [
            stalk,
            stalk + out * (0.45 * size) - half + normal * (fold + 0.6 * flutter),
            stalk + out * (0.45 * size) + half + normal * (fold + 0.35 * flutter),
            stalk + out * (0.5 * size) + normal * (0.3 * fold + 0.45 * flutter),
            stalk + out * size + normal * flutter - DVec3::Y * (0.08 * size),
        ];
        builder.patch(material, &points, &[[0, 3, 1], [0, 2, 3], [1, 3, 4], [3, 2, 4]]);
    }
}
