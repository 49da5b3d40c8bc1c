//! Closed parts that several scenes are built from, all seen from outside: beams, lattices, chains, barrels, crates, borders, hanging cloth.
//!
//! Divisions are those at scale 1, as of shapes.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::builder::{Ends, MaterialId, MeshBuilder};
use super::math::{TURN, cos, sin, spokes};
use super::shapes::line;

/// Signs of the corners of a square along x and z, once around.
pub(super) const CORNERS: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];

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
        let (min, max) = (dvec3(-half[0], 0.0, -half[1]), dvec3(half[0], (to - from).length(), half[1]));
        self.within(self.frame.span(from, to, side), |here| here.cuboid(material, min, max, [across, along, across]));
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
        for at in 0..2 * panels {
            let [t0, t1] = [at, at + 1].map(|end| end as f64 / (2 * panels) as f64);
            let (from, to) = if at % 2 == 0 { (first, second) } else { (second, first) };
            self.rod(material, divisions, [line(from)(t0), line(to)(t1)], radius);
        }
    }

    /// A lattice girder of square section `2 * half` between two points: four chords, oblique rods on its four faces.
    pub(super) fn girder(
        &mut self,
        material: MaterialId,
        [around, along]: [usize; 2],
        [from, to]: [DVec3; 2],
        half: f64,
        panels: usize,
    ) {
        let length = (to - from).length();
        let corner = |x: f64, z: f64| [dvec3(x * half, 0.0, z * half), dvec3(x * half, length, z * half)];
        let chords = [corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0), corner(-1.0, 1.0)];
        self.within(self.frame.span(from, to, DVec3::Y), |here| {
            let chord = [here.around(around), 2 * here.along(along)];
            for at in 0..4 {
                here.sweep(material, chord, None, line(chords[at]), |_| DVec2::splat(half * 0.13));
                here.zigzag(material, [around, along], [chords[at], chords[(at + 1) % 4]], panels, half * 0.07);
            }
        });
    }

    /// A chain of oval links of the given pitch and wire radius between two points, sagging by `sag` in the middle.
    pub(super) fn chain(
        &mut self,
        material: MaterialId,
        divisions: [usize; 3],
        [from, to]: [DVec3; 2],
        sag: f64,
        [pitch, wire]: [f64; 2],
    ) {
        let path = |t: f64| from + (to - from) * t - DVec3::Y * (4.0 * sag * t * (1.0 - t));
        let length = (to - from).length() + 2.0 * sag * sag / (to - from).length();
        let links = (libm::round(length / pitch) as usize).max(1);
        for link in 0..links {
            let [start, end] = [link, link + 1].map(|at| path(at as f64 / links as f64));
            let side = if link % 2 == 0 { dvec3(0.7, 0.0, 0.3) } else { dvec3(-0.3, 0.0, 0.7) };
            let half = (end - start).length() / 2.0;
            let oval = |t: f64| dvec3(2.6 * wire * cos(TURN * t), half + (half + wire) * sin(TURN * t), 0.0);
            self.within(self.frame.span(start, end, side), |here| here.loop_tube(material, divisions, oval, wire));
        }
    }

    /// A wooden barrel standing on the frame's origin, open at the top or with a lid, with iron hoops.
    pub(super) fn barrel(&mut self, [staves, iron]: [MaterialId; 2], [radius, height]: [f64; 2], open: bool) {
        let at = |up: f64| radius * (0.84 + 0.64 * up * (1.0 - up));
        let rows = 10;
        let mut knots = vec![[0.0, 0.0]];
        knots.extend((0..=rows).map(|row| f64::from(row) / f64::from(rows)).map(|up| [at(up), up * height]));
        knots.push([at(1.0) - 0.08 * radius, height]);
        if open {
            knots.extend([0.5, 0.05].map(|up| [at(up) - 0.08 * radius, up * height]));
            knots.push([0.0, 0.05 * height]);
        } else {
            knots.push([at(1.0) - 0.09 * radius, 0.96 * height]);
            knots.push([0.0, 0.96 * height]);
        }
        self.revolve_straight(staves, [20, 1], &knots);
        for up in [0.08, 0.3, 0.7, 0.92] {
            let (low, high) = (up - 0.025, up + 0.025);
            let edge = |up: f64, out: f64| [at(up) + out * radius, up * height];
            self.hoop(iron, 20, &[edge(low, -0.03), edge(low, 0.02), edge(high, 0.02), edge(high, -0.03)], &[1]);
        }
    }

    /// An outline (radius, height) that runs counter-clockwise, turned about the y axis without touching it.
    pub(super) fn hoop(&mut self, material: MaterialId, around: usize, corners: &[[f64; 2]], divisions: &[usize]) {
        let around = self.around(around);
        let mut section = self.outline(corners, divisions);
        section.reverse();
        self.rings(material, [around, section.len()], Ends::Looped, |ring, at| {
            let angle = TURN * ring as f64 / around as f64;
            dvec3(section[at].x * cos(angle), section[at].y, -section[at].x * sin(angle))
        });
    }

    /// A ladder of two posts and rungs between two points at the middle of its ends; `side` is the direction of a rung.
    pub(super) fn ladder(&mut self, material: MaterialId, [from, to]: [DVec3; 2], side: DVec3, rungs: usize) {
        let radius = 0.035 * side.length() * 2.0;
        for face in [-1.0, 1.0] {
            self.rod(material, [8, 10], [from + side * face, to + side * face], radius);
        }
        for rung in 0..rungs {
            let middle = line([from, to])((rung as f64 + 0.5) / rungs as f64);
            self.rod(material, [6, 4], [middle - side, middle + side], radius * 0.7);
        }
    }

    /// A crate of planks standing on the frame's origin: a core, and boards sunk into it along its edges and across.
    pub(super) fn plank_crate(&mut self, [core, board]: [MaterialId; 2], size: DVec3) {
        let half = size / 2.0;
        let thick = 0.03 * size.y;
        let wide = 0.07 * size.y;
        let inset = dvec3(thick, 0.0, thick);
        let (min, max) = (dvec3(-half.x, 0.002, -half.z), dvec3(half.x, size.y - thick, half.z));
        self.cuboid(core, min + inset, max - inset, [2, 2, 2]);
        for (x, z) in CORNERS {
            let middle = dvec3(x * (half.x - wide), 0.0, z * (half.z - wide));
            let reach = dvec3(wide, 0.0, wide);
            self.cuboid(board, middle - reach, middle + reach + DVec3::Y * size.y, [1, 2, 1]);
        }
        // The oblique boards are thinner, so that their faces do not lie in those of the others.
        let lean = 0.5 * size.y - 2.0 * wide;
        let (low, high) = (size.y / 2.0 - lean, size.y / 2.0 + lean);
        for face in [-1.0, 1.0] {
            let z = face * (half.z - 0.6 * thick);
            for (from, to, deep) in [(wide, wide, 0.5), (size.y - wide, size.y - wide, 0.5), (low, high, 0.42)] {
                let ends = [dvec3(-half.x + wide, from, z), dvec3(half.x - wide, to, z)];
                self.beam(board, [1, 2], ends, [0.6 * wide, deep * thick], DVec3::Y);
            }
            let x = face * (half.x - 0.6 * thick);
            let ends = [dvec3(x, high, -half.z + wide), dvec3(x, low, half.z - wide)];
            self.beam(board, [1, 2], ends, [0.6 * wide, 0.45 * thick], DVec3::Y);
        }
    }

    /// A frame of rectangular section around the y axis with mitred corners: half sizes along x and z of its inner and
    /// its outer outline, and its range of heights. `divisions` are those of a side, of its width and of its height.
    pub(super) fn border(
        &mut self,
        material: MaterialId,
        [side, width, height]: [usize; 3],
        [inner, outer]: [DVec2; 2],
        [bottom, top]: [f64; 2],
    ) {
        let side = self.along(side);
        let section = self.outline(&[[0.0, top], [1.0, top], [1.0, bottom], [0.0, bottom]], &[width, height]);
        self.rings(material, [4 * side, section.len()], Ends::Looped, |ring, at| {
            let corner = |number: usize| {
                let half = inner + (outer - inner) * section[at].x;
                [half, dvec2(half.x, -half.y), -half, dvec2(-half.x, half.y)][number % 4]
            };
            let (from, to) = (corner(ring / side), corner(ring / side + 1));
            let flat = from + (to - from) * ((ring % side) as f64 / side as f64);
            dvec3(flat.x, section[at].y, flat.y)
        });
    }

    /// A thin hanging cloth: each ring runs along its front and back along its back. `point` takes shares of the height and the width, and how far
    /// the face is off the middle, which is `thick` at most.
    pub(super) fn cloth(
        &mut self,
        material: MaterialId,
        [half, rows]: [[usize; 2]; 2],
        thick: f64,
        point: impl Fn(f64, f64, f64) -> DVec3,
    ) {
        let [half, rows] = [half, rows].map(|[base, least]| self.divide(base, least));
        self.rings(material, [rows + 1, 2 * half], Ends::Pressed, |row, at| {
            let share = at as f64 / half as f64;
            let (along, face) = if at <= half { (share, 1.0) } else { (2.0 - share, -1.0) };
            // Front and back meet at the tips.
            let off = thick * libm::sqrt((4.0 * along * (1.0 - along)).max(0.0)) * face;
            point(row as f64 / rows as f64, along, off)
        });
    }

    /// A spoked wheel around the frame's y axis: rim, spokes and hub.
    pub(super) fn wheel(&mut self, [rim, hub]: [MaterialId; 2], [radius, thick]: [f64; 2], spoke_count: usize) {
        self.torus(rim, [10, 36, 3], DVec3::ZERO, [radius - thick, thick]);
        let width = thick * 2.2;
        let profile =
            [[0.0, -width], [0.17 * radius, -width], [0.2 * radius, 0.0], [0.17 * radius, width], [0.0, width]];
        self.revolve_straight(hub, [16, 2], &profile);
        for out in spokes(spoke_count) {
            self.rod(rim, [8, 4], [out * (0.12 * radius), out * (radius - thick)], thick * 0.5);
        }
    }
}
