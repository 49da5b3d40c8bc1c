//! Closed parts that several scenes are built from, all seen from outside: beams, lattices, chains, barrels, crates.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::builder::{Ends, MaterialId, MeshBuilder};
use super::math::{TURN, cos, sin};

impl MeshBuilder {
    /// A straight beam of rectangular section; `half` is half its size on the side of `side` and square to it.
    pub(super) fn beam(
        &mut self,
        material: MaterialId,
        [across, along]: [usize; 2],
        [from, to]: [DVec3; 2],
        half: [f64; 2],
        side: DVec3,
    ) {
        let frame = self.frame;
        self.frame = frame.span(from, to, side);
        let length = (to - from).length();
        self.cuboid(material, dvec3(-half[0], 0.0, -half[1]), dvec3(half[0], length, half[1]), [across, along, across]);
        self.frame = frame;
    }

    /// Oblique rods that run to and fro between two lines, `panels` times there and back.
    pub(super) fn zigzag(
        &mut self,
        material: MaterialId,
        divisions: [usize; 2],
        [first, second]: [[DVec3; 2]; 2],
        panels: usize,
        radius: f64,
    ) {
        let on = |line: [DVec3; 2], t: f64| line[0] + (line[1] - line[0]) * t;
        for at in 0..2 * panels {
            let [t0, t1] = [at, at + 1].map(|end| end as f64 / (2 * panels) as f64);
            let ends = if at % 2 == 0 { [on(first, t0), on(second, t1)] } else { [on(second, t0), on(first, t1)] };
            self.rod(material, divisions, ends, radius);
        }
    }

    /// A lattice girder of square section `2 * half` between two points: four chords, oblique rods on its four faces.
    pub(super) fn girder(
        &mut self,
        material: MaterialId,
        divisions: [usize; 2],
        [from, to]: [DVec3; 2],
        half: f64,
        panels: usize,
    ) {
        let frame = self.frame;
        self.frame = frame.span(from, to, DVec3::Y);
        let length = (to - from).length();
        let corner = |x: f64, z: f64| [dvec3(x * half, 0.0, z * half), dvec3(x * half, length, z * half)];
        let around = [corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0), corner(-1.0, 1.0)];
        for at in 0..4 {
            self.rod(material, [divisions[0], divisions[1] * 2], around[at], half * 0.13);
            self.zigzag(material, divisions, [around[at], around[(at + 1) % 4]], panels, half * 0.07);
        }
        self.frame = frame;
    }

    /// A chain of oval links of the given pitch and wire radius between two points, sagging by `sag` in the middle.
    pub(super) fn chain(
        &mut self,
        material: MaterialId,
        divisions: [usize; 2],
        [from, to]: [DVec3; 2],
        sag: f64,
        [pitch, wire]: [f64; 2],
    ) {
        let path = |t: f64| from + (to - from) * t - DVec3::Y * (4.0 * sag * t * (1.0 - t));
        let length = (to - from).length() + 2.0 * sag * sag / (to - from).length();
        let links = (libm::round(length / pitch) as usize).max(1);
        let frame = self.frame;
        for link in 0..links {
            let [start, end] = [link, link + 1].map(|at| path(at as f64 / links as f64));
            let side = if link % 2 == 0 { dvec3(0.7, 0.0, 0.3) } else { dvec3(-0.3, 0.0, 0.7) };
            self.frame = frame.span(start, end, side);
            let half = (end - start).length() / 2.0;
            let oval = |t: f64| dvec3(2.6 * wire * cos(TURN * t), half + (half + wire) * sin(TURN * t), 0.0);
            self.loop_tube(material, divisions, oval, wire);
        }
        self.frame = frame;
    }

    /// A wooden barrel standing on the frame's origin, open at the top or with a lid, with iron hoops.
    pub(super) fn barrel(&mut self, [staves, iron]: [MaterialId; 2], [radius, height]: [f64; 2], open: bool) {
        let at = |up: f64| radius * (0.84 + 0.64 * up * (1.0 - up));
        let rows = 10;
        let mut knots = vec![[0.0, 0.0]];
        knots.extend((0..=rows).map(|row| f64::from(row) / f64::from(rows)).map(|up| [at(up), up * height]));
        if open {
            knots.push([at(1.0) - 0.08 * radius, height]);
            knots.push([at(0.5) - 0.08 * radius, 0.5 * height]);
            knots.push([at(0.05) - 0.08 * radius, 0.05 * height]);
            knots.push([0.0, 0.05 * height]);
        } else {
            knots.push([at(1.0) - 0.08 * radius, height]);
            knots.push([at(1.0) - 0.09 * radius, 0.96 * height]);
            knots.push([0.0, 0.96 * height]);
        }
        self.revolve_straight(staves, self.round(20, 1), &knots);
        for up in [0.08, 0.3, 0.7, 0.92] {
            let (low, high) = (up - 0.025, up + 0.025);
            let band = outline(
                &[
                    dvec2(at(low) - 0.03 * radius, low * height),
                    dvec2(at(low) + 0.02 * radius, low * height),
                    dvec2(at(high) + 0.02 * radius, high * height),
                    dvec2(at(high) - 0.03 * radius, high * height),
                ],
                &[self.along(1)],
            );
            self.hoop(iron, self.around(20), &band);
        }
    }

    /// A section (radius, height) that runs counter-clockwise, turned about the y axis without touching it.
    pub(super) fn hoop(&mut self, material: MaterialId, around: usize, section: &[DVec2]) {
        self.rings(material, around, section.len(), &Ends::Looped, |ring, at| {
            let angle = TURN * ring as f64 / around as f64;
            let DVec2 { x: radius, y } = section[section.len() - 1 - at];
            dvec3(radius * cos(angle), y, -radius * sin(angle))
        });
    }

    /// A ladder of two posts and rungs between two points at the middle of its ends; `side` is the direction of a rung.
    pub(super) fn ladder(&mut self, material: MaterialId, [from, to]: [DVec3; 2], side: DVec3, rungs: usize) {
        let radius = 0.035 * side.length() * 2.0;
        for face in [-1.0, 1.0] {
            self.rod(material, self.round(8, 10), [from + side * face, to + side * face], radius);
        }
        for rung in 0..rungs {
            let middle = from + (to - from) * ((rung as f64 + 0.5) / rungs as f64);
            self.rod(material, self.round(6, 4), [middle - side, middle + side], radius * 0.7);
        }
    }

    /// A crate of planks standing on the frame's origin: a core, and boards sunk into it along its edges and across.
    pub(super) fn plank_crate(&mut self, [core, board]: [MaterialId; 2], size: DVec3) {
        let half = size / 2.0;
        let thick = 0.03 * size.y;
        let wide = 0.07 * size.y;
        let [fine, along] = self.sides([1, 2]);
        let inset = dvec3(thick, 0.0, thick);
        self.cuboid(
            core,
            dvec3(-half.x, 0.002, -half.z) + inset,
            dvec3(half.x, size.y - thick, half.z) - inset,
            [along, along, along],
        );
        for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let middle = dvec3(x * (half.x - wide), 0.0, z * (half.z - wide));
            let reach = dvec3(wide, 0.0, wide);
            self.cuboid(board, middle - reach, middle + reach + DVec3::Y * size.y, [fine, along, fine]);
        }
        // The oblique boards are thinner, so that their faces do not lie in those of the others.
        let lean = 0.5 * size.y - 2.0 * wide;
        for face in [-1.0, 1.0] {
            let z = face * (half.z - 0.6 * thick);
            for (low, high, deep) in [
                (wide, wide, 0.5 * thick),
                (size.y - wide, size.y - wide, 0.5 * thick),
                (size.y / 2.0 - lean, size.y / 2.0 + lean, 0.42 * thick),
            ] {
                let ends = [dvec3(-half.x + wide, low, z), dvec3(half.x - wide, high, z)];
                self.beam(board, [fine, along], ends, [0.6 * wide, deep], DVec3::Y);
            }
            let x = face * (half.x - 0.6 * thick);
            let (low, high) = (size.y / 2.0 - lean, size.y / 2.0 + lean);
            let ends = [dvec3(x, high, -half.z + wide), dvec3(x, low, half.z - wide)];
            self.beam(board, [fine, along], ends, [0.6 * wide, 0.45 * thick], DVec3::Y);
        }
    }
}

/// The points of a closed outline through `corners`, the side after each divided as said.
pub(super) fn outline(corners: &[DVec2], divisions: &[usize]) -> Vec<DVec2> {
    let mut points = Vec::new();
    for (at, &from) in corners.iter().enumerate() {
        let to = corners[(at + 1) % corners.len()];
        let divisions = divisions[at % divisions.len()];
        points.extend((0..divisions).map(|step| from + (to - from) * (step as f64 / divisions as f64)));
    }
    points
}
