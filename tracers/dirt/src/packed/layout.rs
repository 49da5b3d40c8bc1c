//! How the packed forms are laid out, and the uniforms that tell shaders of it.

use tracebench_api::Viewpoint;
use tracebench_kit::Pyramid;

use crate::description::{DirtParameters, Lists, Spacing};
pub(crate) use tracebench_shaders::dirt::{PackedGrid, PackedSearch};

/// Views: faces of a cube round the eye.
pub(super) const FACES: u32 = 6;
/// Words of the references before the triangles that are listed: `FIRST_NEAR` of shaders/dirt/packed_grid.wgsl.
pub(super) const FIRST_NEAR: u32 = 9;
/// `MISPLACED` there.
pub(super) const MISPLACED: u32 = 6;
/// Bits of a slice's number.
const SLICE_BITS: u32 = 6;
/// Bits of a part's place along a tile's curve, where there is room for all.
const ORDER_BITS: u32 = 17;

/// What is stored and how.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PackedLayout {
    /// Where it is seen from.
    pub viewpoint: Viewpoint,
    pub lists: Lists,
    pub tiles: u32,
    pub slices: u32,
    pub spacing: Spacing,
}

impl PackedLayout {
    pub(crate) fn new(viewpoint: &Viewpoint, parameters: &DirtParameters) -> Self {
        Self {
            viewpoint: *viewpoint,
            lists: parameters.lists,
            tiles: parameters.face_tiles,
            slices: parameters.slices,
            spacing: parameters.spacing,
        }
    }

    /// Whether buffers of the other one have the same shape.
    pub(super) fn is_shaped_like(&self, other: &Self) -> bool {
        (self.lists, self.tiles) == (other.lists, other.tiles)
    }

    fn pyramid(&self) -> Pyramid {
        Pyramid { size: [self.tiles; 2] }
    }

    /// Levels of the pyramid, down from one tile a face.
    pub(super) fn levels(&self) -> usize {
        self.pyramid().levels()
    }

    /// Cells of a level of a face.
    pub(super) fn cells_of_level(&self, level: usize) -> u32 {
        self.pyramid().cells(level) as u32
    }

    /// Cells of a level along an edge.
    pub(super) fn level_edge(&self, level: usize) -> u32 {
        self.pyramid().level_size(level)[0]
    }

    /// Cells of a face, all levels.
    pub(super) fn cells(&self) -> u32 {
        self.pyramid().offsets(0, 0).1 as u32
    }

    /// Where a level begins among the cells of a face.
    pub(super) fn level_offset(&self, level: usize) -> u32 {
        self.pyramid().offsets(0, 0).0[level]
    }

    /// Tiles of all faces.
    pub(super) fn tile_count(&self) -> u32 {
        FACES * self.tiles * self.tiles
    }

    /// Bits that one more than the greatest number of a tile takes: 0 is the key of nothing.
    fn tile_bits(&self) -> u32 {
        u32::BITS - self.tile_count().leading_zeros()
    }

    /// Bits of a key below its tile.
    pub(super) fn order_bits(&self) -> u32 {
        match self.lists {
            Lists::Slices => SLICE_BITS,
            Lists::Linked | Lists::Packed | Lists::Trees => ORDER_BITS.min(u32::BITS - self.tile_bits()),
        }
    }

    /// Bits of a key.
    pub(super) fn key_bits(&self) -> u32 {
        self.tile_bits() + self.order_bits()
    }

    /// The uniform for so many triangles, parts and nodes.
    pub(super) fn grid(&self, triangle_count: u32, [part_capacity, node_capacity]: [u32; 2]) -> PackedGrid {
        let (level_offsets, _) = self.pyramid().offsets(0, 0);
        PackedGrid {
            eye: self.viewpoint.eye.into(),
            tiles: self.tiles,
            triangle_count,
            part_capacity,
            node_capacity,
            levels: self.levels() as u32,
            cells: self.cells(),
            slices: self.slices,
            order_bits: self.order_bits(),
            fixed_slices: u32::from(self.spacing == Spacing::NearFar),
            fixed_far: (1.0 / self.viewpoint.far).to_bits(),
            fixed_near: (1.0 / self.viewpoint.near).to_bits(),
            padding: [0; 2],
            level_offsets,
        }
    }
}

/// As `first_leaf_of` in shaders/dirt/packed_grid.wgsl: the first node of the last level of a tile's tree.
pub(super) fn first_leaf(parts: u32) -> u32 {
    let mut first = 0;
    while parts > 8 * (7 * first + 1) {
        first = 8 * first + 1;
    }
    first
}

/// As `node_count_of` there.
pub(super) fn node_count(parts: u32) -> u32 {
    if parts == 0 { 0 } else { first_leaf(parts) + parts.div_ceil(8) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every tile's tree has a place for all of its parts below its first leaf, in no more levels than they need, and every node but
    /// the root a parent that comes before it.
    #[test]
    fn trees_hold_their_parts() {
        assert_eq!([0, 1, 8, 9, 64, 65, 512, 513].map(first_leaf), [0, 0, 0, 1, 1, 9, 9, 73]);
        for parts in [1, 7, 8, 9, 64, 65, 500, 512, 513, 4096, 4097, 32_768, 32_769, 262_144, 262_145] {
            let (first, count) = (first_leaf(parts), node_count(parts));
            assert!(count - first == parts.div_ceil(8) && 8 * (count - first) >= parts);
            let depth = |node: u32| {
                let (mut node, mut depth) = (node, 0);
                while node > 0 {
                    (node, depth) = ((node - 1) / 8, depth + 1);
                }
                depth
            };
            assert_eq!(depth(first), depth(count - 1), "{parts}: leaves of two levels");
            assert!(8_u64.pow(depth(first)) * 8 >= u64::from(parts));
            assert!(depth(first) == 0 || u64::from(parts) > 8_u64.pow(depth(first)), "{parts}: a level too many");
        }
    }

    /// Keys tell every tile from nothing, whatever the number of tiles, and fit into 32 bits.
    #[test]
    fn keys_fit() {
        use crate::tests::{parameters, viewpoint};
        for lists in ["packed", "sliced", "trees"] {
            for tiles in [1_u32, 2, 3, 32, 64, 100, 128, 256] {
                let parameters = parameters(&[("lists", lists), ("face_tiles", &tiles.to_string())]);
                let parameters = DirtParameters::try_from(&parameters).unwrap();
                let layout = PackedLayout::new(&viewpoint(), &parameters);
                assert!(layout.key_bits() <= u32::BITS, "{lists} {tiles}");
                let greatest = u64::from(layout.tile_count()) << layout.order_bits();
                assert!(greatest < 1 << layout.key_bits(), "{lists} {tiles}");
            }
        }
    }
}
