//! What the lists of a structure are like: how many buckets hold a part of a triangle, and tiles that one surface fills.
//!
//! Equation 1 divides the depths that a tile holds, whatever these are: where one surface fills a tile, its own depths are all
//! there are, and it is spread over all buckets, though there is nothing in front of it or behind it to be told from.

use std::collections::HashMap;

use tracebench_api::Geometry;

/// Parts by the number of buckets that hold them, 1, 2, 3 to 4, 5 to 8, ...: names in the record.
const IN_BUCKETS: [&str; 9] = [
    "parts_in_1_bucket",
    "parts_in_2_buckets",
    "parts_in_3_to_4_buckets",
    "parts_in_5_to_8_buckets",
    "parts_in_9_to_16_buckets",
    "parts_in_17_to_32_buckets",
    "parts_in_33_to_64_buckets",
    "parts_in_65_to_128_buckets",
    "parts_in_129_to_256_buckets",
];

/// Counts over all tiles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct TileStatistics {
    /// Triangles in tiles, each once a tile.
    pub parts: u64,
    /// Parts by the number of buckets that hold them, as [`IN_BUCKETS`].
    in_buckets: [u64; IN_BUCKETS.len()],
    /// Parts that all buckets of their tile hold.
    in_every_bucket: u64,
    /// Tiles with parts.
    pub occupied_tiles: u64,
    /// Tiles whose triangles hang together by shared corners.
    one_surface_tiles: u64,
    /// Nodes in the lists of such tiles.
    one_surface_references: u64,
}

impl TileStatistics {
    /// Adds a tile by the primitives of all its lists' nodes, in any order.
    pub(crate) fn add_tile(&mut self, primitives: &mut Vec<u32>, geometry: &Geometry, buckets: u32) {
        let references = primitives.len() as u64;
        if references == 0 {
            return;
        }
        primitives.sort_unstable();
        for copies in primitives.chunk_by(|a, b| a == b).map(<[u32]>::len) {
            self.parts += 1;
            self.in_buckets[(copies.next_power_of_two().trailing_zeros() as usize).min(IN_BUCKETS.len() - 1)] += 1;
            self.in_every_bucket += u64::from(copies == buckets as usize);
        }
        primitives.dedup();
        self.occupied_tiles += 1;
        if hang_together(primitives, geometry) {
            self.one_surface_tiles += 1;
            self.one_surface_references += references;
        }
    }

    /// The counts by name, for lists of so many buckets.
    pub(crate) fn named(&self, buckets: u32) -> Vec<(&'static str, f64)> {
        let possible = (buckets.next_power_of_two().trailing_zeros() as usize + 1).min(IN_BUCKETS.len());
        let in_buckets = IN_BUCKETS.into_iter().zip(self.in_buckets).take(possible);
        [("parts", self.parts)]
            .into_iter()
            .chain(in_buckets)
            .chain([
                ("parts_in_every_bucket", self.in_every_bucket),
                ("occupied_tiles", self.occupied_tiles),
                ("one_surface_tiles", self.one_surface_tiles),
                ("references_in_one_surface_tiles", self.one_surface_references),
            ])
            .map(|(name, count)| (name, count as f64))
            .collect()
    }
}

/// Whether triangles are one surface: whether each is reached from each other one by corners that lie at the same place.
fn hang_together(primitives: &[u32], geometry: &Geometry) -> bool {
    // Each triangle is led to another one of its surface, or to itself.
    let mut leads_to: Vec<usize> = (0..primitives.len()).collect();
    fn last(leads_to: &mut [usize], from: usize) -> usize {
        let mut at = from;
        while leads_to[at] != at {
            leads_to[at] = leads_to[leads_to[at]];
            at = leads_to[at];
        }
        at
    }
    let mut surfaces = primitives.len();
    let mut seen: HashMap<[u32; 3], usize> = HashMap::with_capacity(primitives.len() * 3);
    for (index, primitive) in primitives.iter().enumerate() {
        for corner in geometry.corners(*primitive) {
            // Adding 0 makes one of both zeros.
            let place = corner.to_array().map(|coordinate| (coordinate + 0.0).to_bits());
            let other = *seen.entry(place).or_insert(index);
            let (one, other) = (last(&mut leads_to, index), last(&mut leads_to, other));
            if one != other {
                leads_to[one] = other;
                surfaces -= 1;
            }
        }
    }
    surfaces == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles along a strip that share corners by place alone, and one apart from them.
    fn geometry() -> Geometry {
        let strip = |index: u32| {
            let x = index as f32;
            [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, -0.0]]
        };
        let mut positions: Vec<[f32; 3]> = (0..4).flat_map(strip).collect();
        positions.extend([[0.0, 0.0, 9.0], [1.0, 0.0, 9.0], [0.0, 1.0, 9.0]]);
        let triangles = (0..5).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
        Geometry::new(positions, triangles, None).unwrap()
    }

    /// Parts are counted by their copies, and a tile is one surface's if its triangles hang together: those in the middle of a
    /// strip are missed if they are not there, and another surface behind it is noticed.
    #[test]
    fn copies_and_surfaces_are_counted() {
        let geometry = geometry();
        let mut all = TileStatistics::default();
        for (mut primitives, one_surface) in [
            (vec![], false),
            (vec![3, 0, 1, 2, 1, 1], true),
            (vec![0, 1, 3], false),
            (vec![2, 4, 2], false),
            (vec![4, 4, 4, 4, 4], true),
        ] {
            let before = all.clone();
            let references = primitives.len() as u64;
            all.add_tile(&mut primitives, &geometry, 5);
            assert_eq!(all.one_surface_tiles - before.one_surface_tiles, u64::from(one_surface), "{primitives:?}");
            let within = all.one_surface_references - before.one_surface_references;
            assert_eq!(within, if one_surface { references } else { 0 });
        }
        let named: Vec<(&str, u32)> = all.named(5).into_iter().map(|(name, value)| (name, value as u32)).collect();
        assert_eq!(
            named,
            [
                ("parts", 10),
                ("parts_in_1_bucket", 7),
                ("parts_in_2_buckets", 1),
                ("parts_in_3_to_4_buckets", 1),
                ("parts_in_5_to_8_buckets", 1),
                ("parts_in_every_bucket", 1),
                ("occupied_tiles", 4),
                ("one_surface_tiles", 2),
                ("references_in_one_surface_tiles", 11),
            ]
        );
        assert_eq!(all.named(256).len(), 14);
    }
}
