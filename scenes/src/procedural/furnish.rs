//! Closed parts that furnish scenes, all seen from outside: mitred borders, hanging cloth, wheels.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::builder::{Ends, MaterialId, MeshBuilder};
use super::math::{TURN, cos, mix, sin};
use super::parts::outline;

/// How a cloth hangs: its size in metres and its folds.
pub(super) struct Drape {
    pub(super) width: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
    /// Number of folds over the width and how far they stand out.
    pub(super) folds: f64,
    pub(super) depth: f64,
    pub(super) phase: f64,
}

impl MeshBuilder {
    /// A frame of rectangular section around the y axis with mitred corners: half sizes along x and z of its inner and
    /// its outer outline, and its range of heights. `divisions` are those of a side, of its width and of its height.
    pub(super) fn border(
        &mut self,
        material: MaterialId,
        divisions: [usize; 3],
        [inner, outer]: [DVec2; 2],
        [bottom, top]: [f64; 2],
    ) {
        let [side, width, height] = divisions;
        let section = outline(
            &[dvec2(0.0, top), dvec2(1.0, top), dvec2(1.0, bottom), dvec2(0.0, bottom)],
            &[width, height, width, height],
        );
        self.rings(material, 4 * side, section.len(), &Ends::Looped, |ring, at| {
            let corner = |number: usize| {
                let half = inner + (outer - inner) * section[at].x;
                [half, dvec2(half.x, -half.y), -half, dvec2(-half.x, half.y)][number % 4]
            };
            let (from, to) = (corner(ring / side), corner(ring / side + 1));
            let flat = from + (to - from) * ((ring % side) as f64 / side as f64);
            dvec3(flat.x, section[at].y, flat.y)
        });
    }

    /// A thin folded cloth hanging along x in the plane z = 0: each ring runs along its front and back along its back.
    pub(super) fn drape(&mut self, material: MaterialId, [half, rows]: [usize; 2], cloth: &Drape) {
        let &Drape { width, top, bottom, folds, depth, phase } = cloth;
        self.rings(material, rows + 1, 2 * half, &Ends::Pressed, |row, at| {
            let up = row as f64 / rows as f64;
            let share = at as f64 / half as f64;
            let (along, face) = if at <= half { (share, 1.0) } else { (2.0 - share, -1.0) };
            // Rows differ in size and place only, so that every cell is flat: a bent one could reach through the cloth.
            let size = 1.0 - 0.12 * up + 0.04 * sin(3.0 * up + phase);
            let fold = sin(TURN * folds * along + phase) + 0.3 * sin(TURN * 2.3 * folds * along + 2.0 * phase);
            // Front and back meet at the tips.
            let thick = 0.0045 * libm::sqrt((4.0 * along * (1.0 - along)).max(0.0)) * face;
            let flat = dvec3((along - 0.5) * width, 0.0, depth * fold + thick) * size;
            dvec3(0.1 * depth * sin(2.5 * up + phase), mix(bottom, top, up), 0.0) + flat
        });
    }

    /// A spoked wheel around the frame's y axis: rim, spokes and hub.
    pub(super) fn wheel(&mut self, [rim, hub]: [MaterialId; 2], [radius, thick]: [f64; 2], spokes: usize) {
        self.torus(rim, self.ring(10, 36), DVec3::ZERO, [radius - thick, thick]);
        let width = thick * 2.2;
        let profile =
            [[0.0, -width], [0.17 * radius, -width], [0.2 * radius, 0.0], [0.17 * radius, width], [0.0, width]];
        self.revolve_straight(hub, self.round(16, 2), &profile);
        for spoke in 0..spokes {
            let angle = TURN * spoke as f64 / spokes as f64;
            let out = dvec3(cos(angle), 0.0, sin(angle));
            let ends = [out * (0.12 * radius), out * (radius - thick)];
            self.rod(rim, self.round(8, 4), ends, thick * 0.5);
        }
    }
}
