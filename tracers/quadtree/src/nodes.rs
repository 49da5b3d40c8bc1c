//! Nodes as the host reads them back, in f64 (shaders/quadtree/node.wgsl has the layout).

use tracebench_api::glam::{DVec2, DVec3};

const PLANE_BIT: u32 = 0x8000_0000;
const FLOAT_BITS: u32 = 0x3fff_ffff;
const NORMAL_BITS: u32 = 0xbfff_bfff;

/// The steps to the pixels beside one, by the number of the side that lies between.
pub(crate) const STEPS: [[i32; 2]; 4] = [[-1, 0], [1, 0], [0, -1], [0, 1]];

/// Of a pixel that shows nothing.
pub(crate) const NOTHING: [u32; 2] = [0x3f80_0000, 0x8000_0000];

/// A node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Node {
    /// Nothing is seen anywhere in it.
    Empty,
    /// Least and greatest z, and whether there are pixels that show nothing.
    Box { least: f64, greatest: f64, holes: bool },
    /// A plane.
    Plane(Plane),
}

/// A plane over a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    /// z at the node's middle.
    pub z: f64,
    /// In the unit cube.
    pub normal: DVec3,
    /// z a pixel.
    pub slope: DVec2,
    /// Near a discontinuity.
    pub flagged: bool,
    /// The side across which it ends at a neighbour's.
    pub end: Option<usize>,
}

/// A number in half precision.
pub(crate) fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff) / 1024.0);
    let size = if exponent == 0 { fraction * 2_f64.powi(-14) } else { (1.0 + fraction) * 2_f64.powi(exponent - 15) };
    if bits >> 15 == 1 { -size } else { size }
}

/// A z that is stored.
fn z_of(word: u32) -> f64 {
    f64::from(f32::from_bits(word & FLOAT_BITS))
}

impl Node {
    /// That of two words, of an image of so many pixels.
    pub(crate) fn of(words: [u32; 2], size: [u32; 2]) -> Self {
        if words == NOTHING {
            return Self::Empty;
        }
        if words[0] & PLANE_BIT == 0 {
            return Self::Box { least: z_of(words[0]), greatest: z_of(words[1]), holes: words[1] & PLANE_BIT != 0 };
        }
        let normal = words[1] & NORMAL_BITS;
        let across = DVec2::new(half(normal as u16), half((normal >> 16) as u16));
        let normal = across.extend((1.0 - across.length_squared()).max(5e-4).sqrt());
        let slope = -across / normal.z / DVec2::new(f64::from(size[0]), f64::from(size[1]));
        let mark = (words[0] >> 30 & 1) | (words[1] >> 14 & 1) << 1 | (words[1] >> 30 & 1) << 2;
        let end = mark.checked_sub(2).map(|side| side as usize);
        Self::Plane(Plane { z: z_of(words[0]), normal, slope, flagged: mark != 0, end })
    }
}

impl Plane {
    /// z so many pixels from the node's middle.
    pub(crate) fn z_at(&self, from_middle: DVec2) -> f64 {
        self.z + self.slope.dot(from_middle)
    }

    /// Least and greatest z within so many pixels of the node's middle, held in the cube.
    pub(crate) fn range(&self, reach: f64) -> [f64; 2] {
        let spread = self.slope.abs().element_sum() * reach;
        [self.z - spread, self.z + spread].map(|z| z.clamp(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAG_BIT: u32 = 0x4000_0000;

    /// Halves are those of IEEE 754: signs, the smallest, normal ones and the greatest below 1.
    #[test]
    fn halves_are_read() {
        for (bits, value) in [
            (0x0000, 0.0),
            (0x0001, 2_f64.powi(-24)),
            (0x0400, 2_f64.powi(-14)),
            (0x3800, 0.5),
            (0x3bff, 1.0 - 2_f64.powi(-11)),
            (0x3c00, 1.0),
            (0xbc00, -1.0),
            (0xb555, -0.333_251_953_125),
        ] {
            assert_eq!(half(bits), value, "{bits:x}");
        }
    }

    /// Kinds are told by the sign of the first word, marks and holes by the spare bits.
    #[test]
    fn kinds_are_told_apart() {
        let size = [64, 32];
        assert_eq!(Node::of(NOTHING, size), Node::Empty);
        let [quarter, half] = [0.25_f32.to_bits(), 0.5_f32.to_bits()];
        for (bit, holes) in [(0, false), (PLANE_BIT, true)] {
            assert_eq!(Node::of([quarter, half | bit], size), Node::Box { least: 0.25, greatest: 0.5, holes });
        }
        // The marks of a plane: none, flagged, and an end at each side.
        let marks =
            [0, FLAG_BIT, 0, FLAG_BIT, 0, FLAG_BIT].into_iter().zip([0, 0, 0x4000, 0x4000, 0x4000_0000, 0x4000_0000]);
        for (mark, (of_z, of_normal)) in marks.enumerate() {
            let words = [PLANE_BIT | of_z | quarter, 0xb800_3800 | of_normal];
            let Node::Plane(plane) = Node::of(words, size) else { panic!() };
            assert_eq!((plane.z, plane.flagged, plane.end), (0.25, mark > 0, mark.checked_sub(2)));
            assert_eq!((plane.normal.x, plane.normal.y), (0.5, -0.5));
            assert!((plane.normal.length() - 1.0).abs() < 1e-15);
            // Across the whole image the cube's slope, -normal.x / normal.z.
            assert!((plane.slope.x * 64.0 + 0.5_f64.sqrt()).abs() < 1e-12, "{plane:?}");
            assert!((plane.slope.y * 32.0 - 0.5_f64.sqrt()).abs() < 1e-12, "{plane:?}");
        }
    }
}
