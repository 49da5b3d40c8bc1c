//! Collects the triangles of a procedural scene: flat sheets, and stacks of rings, of which everything round is made.

use glam::DVec3;

use super::math::{Frame, TURN};
use crate::scene::{Material, Mesh};

/// A material of the scene under construction: its number in the palette.
#[derive(Clone, Copy, Debug)]
pub(super) struct MaterialId(pub(super) u32);

/// Declares what the things of a scene are made of, a constant each and all of them as `PALETTE`: base colour, and metallic and roughness of what
/// is not matt.
macro_rules! palette {
    ($($name:ident: $color:expr $(, $metallic:literal, $roughness:literal)?;)+) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Order { $($name),+ }
        $(const $name: MaterialId = MaterialId(Order::$name as u32);)+
        const PALETTE: &[Material] = &[$(Material { $(metallic: $metallic, roughness: $roughness,)? ..matt($color) }),+];
    };
}
pub(super) use palette;

/// A rough dielectric.
pub(super) const fn matt(base_color: [f32; 3]) -> Material {
    Material { base_color, metallic: 0.0, roughness: 0.9, refractive_index: None }
}

/// What a surface is made of: one material, or that of the cell that begins at a ring and a point.
pub(super) trait Paint {
    fn of(&self, ring: usize, at: usize) -> MaterialId;
}

impl Paint for MaterialId {
    fn of(&self, _: usize, _: usize) -> MaterialId {
        *self
    }
}

impl<F: Fn(usize, usize) -> MaterialId> Paint for F {
    fn of(&self, ring: usize, at: usize) -> MaterialId {
        self(ring, at)
    }
}

/// How a stack of rings ends.
pub(super) enum Ends {
    /// With a fan around a point before the first ring and one after the last.
    Closed(DVec3, DVec3),
    /// With a strip that joins the points of a ring pairwise, the first half running forward, the second back: for
    /// flat rings, where a fan would fold over itself.
    Pressed,
    /// The last ring is joined to the first.
    Looped,
}

/// The triangles so far.
pub(super) struct MeshBuilder {
    mesh: Mesh,
    /// Factor on the divisions in either direction of a surface.
    fineness: f64,
    /// Where what follows is placed.
    pub(super) frame: Frame,
}

impl MeshBuilder {
    /// Nothing yet, in world space; divisions are those for `scale` times the triangles.
    pub(super) fn new(scale: f64, palette: &[Material]) -> Self {
        Self {
            mesh: Mesh {
                positions: Vec::new(),
                triangles: Vec::new(),
                triangle_materials: Vec::new(),
                materials: palette.to_vec(),
                triangle_objects: Vec::new(),
                objects: Vec::new(),
            },
            fineness: scale.sqrt(),
            frame: Frame::WORLD,
        }
    }

    /// Begins an object, in world space: triangles that follow belong to it.
    pub(super) fn object(&mut self, name: impl Into<String>) {
        self.object_at(name, Frame::WORLD);
    }

    /// Begins an object in a frame.
    pub(super) fn object_at(&mut self, name: impl Into<String>, frame: Frame) {
        self.mesh.objects.push(name.into());
        self.frame = frame;
    }

    /// Begins an object where the one before was placed.
    pub(super) fn object_here(&mut self, name: impl Into<String>) {
        self.object_at(name, self.frame);
    }

    /// An object in a frame, as `build` makes it.
    pub(super) fn part(&mut self, name: impl Into<String>, frame: Frame, build: impl FnOnce(&mut Self)) {
        self.object_at(name, frame);
        build(self);
    }

    /// Builds something in another frame.
    pub(super) fn within(&mut self, frame: Frame, build: impl FnOnce(&mut Self)) {
        let here = std::mem::replace(&mut self.frame, frame);
        build(self);
        self.frame = here;
    }

    /// What was collected.
    pub(super) fn finish(self) -> Mesh {
        self.mesh
    }

    /// A surface over the products of `us` and `vs`, seen from the side to which du x dv points.
    pub(super) fn sheet(&mut self, material: MaterialId, us: &[f64], vs: &[f64], point: impl Fn(f64, f64) -> DVec3) {
        self.sheet_with_holes(material, us, vs, point, |_, _| false);
    }

    /// As [`Self::sheet`], without the cells (by their position in `us` and `vs`) for which `hole` answers true.
    pub(super) fn sheet_with_holes(
        &mut self,
        material: MaterialId,
        us: &[f64],
        vs: &[f64],
        point: impl Fn(f64, f64) -> DVec3,
        hole: impl Fn(usize, usize) -> bool,
    ) {
        let width = us.len();
        // Made when a cell needs them, so that a hole leaves no vertex without a triangle.
        let mut made: Vec<Option<u32>> = vec![None; width * vs.len()];
        for row in 1..vs.len() {
            for column in 1..width {
                if !hole(column - 1, row - 1) {
                    let corners = [(column - 1, row - 1), (column, row - 1), (column - 1, row), (column, row)]
                        .map(|(i, j)| *made[j * width + i].get_or_insert_with(|| self.vertex(point(us[i], vs[j]))));
                    self.cell(material, corners);
                }
            }
        }
    }

    /// A stack of `count` rings of `around` points each; `point` takes the number of the ring and of the point.
    ///
    /// It is seen from outside if the points of a ring run counter-clockwise about the direction of the stack.
    pub(super) fn rings(
        &mut self,
        paint: impl Paint,
        [count, around]: [usize; 2],
        ends: Ends,
        point: impl Fn(usize, usize) -> DVec3,
    ) {
        let first = self.mesh.positions.len() as u32;
        for ring in 0..count {
            for at in 0..around {
                self.vertex(point(ring, at));
            }
        }
        let index = |ring: usize, at: usize| first + (ring % count * around + at % around) as u32;
        let joints = if let Ends::Looped = ends { count } else { count - 1 };
        for ring in 0..joints {
            for at in 0..around {
                let next = ring + 1;
                let corners = [index(ring, at), index(ring, at + 1), index(next, at), index(next, at + 1)];
                self.cell(paint.of(ring, at), corners);
            }
        }
        match ends {
            Ends::Looped => {}
            Ends::Pressed => {
                for at in 0..around / 2 {
                    let back = around - at;
                    for (ring, flip) in [(0, true), (count - 1, false)] {
                        let mut halves = [
                            [index(ring, at), index(ring, at + 1), index(ring, back - 1)],
                            [index(ring, at), index(ring, back - 1), index(ring, back)],
                        ];
                        if flip {
                            halves.iter_mut().for_each(|half| half.swap(1, 2));
                        }
                        // At either tip the strip ends in one triangle.
                        if at + 1 != back - 1 {
                            self.triangle(paint.of(ring, at), halves[0]);
                        }
                        if at != 0 {
                            self.triangle(paint.of(ring, at), halves[1]);
                        }
                    }
                }
            }
            Ends::Closed(start, end) => {
                let (start, end) = (self.vertex(start), self.vertex(end));
                let last = count - 1;
                for at in 0..around {
                    self.triangle(paint.of(0, at), [start, index(0, at + 1), index(0, at)]);
                    self.triangle(paint.of(last, at), [end, index(last, at), index(last, at + 1)]);
                }
            }
        }
    }

    /// As [`Self::rings`], with the angle of a point in place of its number.
    pub(super) fn turned(
        &mut self,
        paint: impl Paint,
        [count, around]: [usize; 2],
        ends: Ends,
        point: impl Fn(usize, f64) -> DVec3,
    ) {
        self.rings(paint, [count, around], ends, |ring, at| point(ring, TURN * at as f64 / around as f64));
    }

    /// An open surface of a few points and the triangles between them, by their numbers.
    pub(super) fn patch(&mut self, material: MaterialId, points: &[DVec3], triangles: &[[u32; 3]]) {
        let first = self.mesh.positions.len() as u32;
        for &point in points {
            self.vertex(point);
        }
        for triangle in triangles {
            self.triangle(material, triangle.map(|number| first + number));
        }
    }

    fn vertex(&mut self, point: DVec3) -> u32 {
        let placed = self.frame.place(point);
        self.mesh.positions.push(placed.as_vec3().to_array());
        self.mesh.positions.len() as u32 - 1
    }

    fn cell(&mut self, material: MaterialId, [a, b, c, d]: [u32; 4]) {
        self.triangle(material, [a, b, d]);
        self.triangle(material, [a, d, c]);
    }

    fn triangle(&mut self, material: MaterialId, corners: [u32; 3]) {
        self.mesh.triangles.push(corners);
        self.mesh.triangle_materials.push(material.0);
        self.mesh.triangle_objects.push(self.mesh.objects.len() as u32 - 1);
    }
}

/// How finely curved and large surfaces are divided. Shapes take the divisions at scale 1.
impl MeshBuilder {
    /// `base` divisions at scale 1, never fewer than `least`.
    pub(super) fn divide(&self, base: usize, least: usize) -> usize {
        let scaled = libm::round(base as f64 * self.fineness);
        (scaled as usize).max(least)
    }

    /// Divisions around something round: at least a triangular prism.
    pub(super) fn around(&self, base: usize) -> usize {
        self.divide(base, 3)
    }

    /// Divisions along something: at least one, and one at every scale for a `base` of 0.
    pub(super) fn along(&self, base: usize) -> usize {
        self.divide(base, 1)
    }
}
