//! Collects the triangles of a procedural scene: flat sheets, and stacks of rings, of which everything round is made.

use glam::DVec3;

use super::math::Frame;
use crate::scene::{Material, Mesh};

/// A material of the scene under construction.
#[derive(Clone, Copy, Debug)]
pub(super) struct MaterialId(u32);

/// Declares the `Palette` of a scene, what things are made of: names with base colours, and metallic and roughness where these are not matt;
/// under a name with a number stand as many colours.
macro_rules! palette {
    (@type) => { MaterialId };
    (@type $count:literal) => { [MaterialId; $count] };
    (@finish) => { [0.0, 0.9] };
    (@finish $metallic:literal, $roughness:literal) => { [$metallic, $roughness] };
    (@make $builder:ident, $color:expr, $finish:expr) => { $builder.material($color, $finish[0], $finish[1]) };
    (@make $builder:ident, $colors:expr, $finish:expr, $count:literal) => {
        $colors.map(|color| palette!(@make $builder, color, $finish))
    };
    ($($name:ident $([$count:literal])?: $color:expr $(, $metallic:literal, $roughness:literal)?;)+) => {
        /// What things are made of.
        struct Palette { $($name: palette!(@type $($count)?)),+ }

        impl Palette {
            fn new(builder: &mut MeshBuilder) -> Self {
                Self { $($name: palette!(@make builder, $color, palette!(@finish $($metallic, $roughness)?) $(, $count)?)),+ }
            }
        }
    };
}
pub(super) use palette;

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
    pub(super) fn new(scale: f64) -> Self {
        Self {
            mesh: Mesh {
                positions: Vec::new(),
                triangles: Vec::new(),
                triangle_materials: Vec::new(),
                materials: Vec::new(),
                triangle_objects: Vec::new(),
                objects: Vec::new(),
            },
            fineness: scale.sqrt(),
            frame: Frame::WORLD,
        }
    }

    /// Begins an object, in world space: triangles that follow belong to it.
    pub(super) fn object(&mut self, name: impl Into<String>) {
        self.object_here(name);
        self.frame = Frame::WORLD;
    }

    /// Begins an object where the one before was placed.
    pub(super) fn object_here(&mut self, name: impl Into<String>) {
        self.mesh.objects.push(name.into());
    }

    /// What was collected.
    pub(super) fn finish(self) -> Mesh {
        self.mesh
    }

    /// A new material.
    pub(super) fn material(&mut self, base_color: [f32; 3], metallic: f32, roughness: f32) -> MaterialId {
        self.mesh.materials.push(Material { base_color, metallic, roughness, refractive_index: None });
        MaterialId(self.mesh.materials.len() as u32 - 1)
    }

    /// A surface over the products of `us` and `vs`, seen from the side to which du x dv points.
    ///
    /// Cells (by their position in `us` and `vs`) for which `hole` answers true are left out.
    pub(super) fn sheet(
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
                if hole(column - 1, row - 1) {
                    continue;
                }
                let [a, b, c, d] = [(column - 1, row - 1), (column, row - 1), (column - 1, row), (column, row)]
                    .map(|(i, j)| *made[j * width + i].get_or_insert_with(|| self.vertex(point(us[i], vs[j]))));
                self.triangle(material, [a, b, d]);
                self.triangle(material, [a, d, c]);
            }
        }
    }

    /// A stack of `count` rings of `around` points each; `point` takes the number of the ring and of the point.
    ///
    /// It is seen from outside if the points of a ring run counter-clockwise about the direction of the stack.
    pub(super) fn rings(
        &mut self,
        material: MaterialId,
        count: usize,
        around: usize,
        ends: &Ends,
        point: impl Fn(usize, usize) -> DVec3,
    ) {
        self.striped_rings(|_, _| material, count, around, ends, point);
    }

    /// As [`Self::rings`], with the material of the cell that begins at a ring and a point.
    pub(super) fn striped_rings(
        &mut self,
        material: impl Fn(usize, usize) -> MaterialId,
        count: usize,
        around: usize,
        ends: &Ends,
        point: impl Fn(usize, usize) -> DVec3,
    ) {
        let first = self.mesh.positions.len() as u32;
        for ring in 0..count {
            for at in 0..around {
                self.vertex(point(ring, at));
            }
        }
        let index = |ring: usize, at: usize| first + (ring % count * around + at % around) as u32;
        let joints = match ends {
            Ends::Closed(..) | Ends::Pressed => count - 1,
            Ends::Looped => count,
        };
        for ring in 0..joints {
            for at in 0..around {
                let (a, b) = (index(ring, at), index(ring, at + 1));
                let (c, d) = (index(ring + 1, at), index(ring + 1, at + 1));
                self.triangle(material(ring, at), [a, b, d]);
                self.triangle(material(ring, at), [a, d, c]);
            }
        }
        if let Ends::Pressed = ends {
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
                        self.triangle(material(ring, at), halves[0]);
                    }
                    if at != 0 {
                        self.triangle(material(ring, at), halves[1]);
                    }
                }
            }
        }
        if let Ends::Closed(start, end) = *ends {
            let (start, end) = (self.vertex(start), self.vertex(end));
            for at in 0..around {
                self.triangle(material(0, at), [start, index(0, at + 1), index(0, at)]);
                self.triangle(material(count - 1, at), [end, index(count - 1, at), index(count - 1, at + 1)]);
            }
        }
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

    fn triangle(&mut self, material: MaterialId, corners: [u32; 3]) {
        self.mesh.triangles.push(corners);
        self.mesh.triangle_materials.push(material.0);
        if self.mesh.objects.is_empty() {
            self.object_here("scene");
        }
        self.mesh.triangle_objects.push(self.mesh.objects.len() as u32 - 1);
    }
}

/// How finely curved and large surfaces are divided.
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

    /// Divisions along something: at least one.
    pub(super) fn along(&self, base: usize) -> usize {
        self.divide(base, 1)
    }

    /// Divisions along several sides.
    pub(super) fn sides<const N: usize>(&self, base: [usize; N]) -> [usize; N] {
        base.map(|base| self.along(base))
    }

    /// Divisions around something round and along it.
    pub(super) fn round(&self, around: usize, along: usize) -> [usize; 2] {
        [self.around(around), self.along(along)]
    }

    /// Divisions around something round that is bent: along it never fewer than `least`.
    pub(super) fn bent(&self, around: usize, [along, least]: [usize; 2]) -> [usize; 2] {
        [self.around(around), self.divide(along, least)]
    }

    /// Divisions around the tube of a ring and around the ring.
    pub(super) fn ring(&self, tube: usize, around: usize) -> [usize; 2] {
        [self.around(tube), self.around(around)]
    }
}
