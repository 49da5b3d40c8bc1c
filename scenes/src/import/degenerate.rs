//! The rule for degenerate and duplicate triangles.
//!
//! A triangle of exactly zero area cannot be hit and is dropped; a duplicate is kept. Both are counted.

use glam::DVec3;

/// Whether the cross product of two edges, in f64 from f32 positions, is exactly zero: two corners coincide, or all
/// three lie on one line. Differences and products of f32 of like magnitude are exact in f64, so nothing thin is lost.
pub(crate) fn has_zero_area(points: &[[f32; 3]; 3]) -> bool {
    let [a, b, c] = points.map(|point| DVec3::from_array(point.map(f64::from)));
    (b - a).cross(c - a) == DVec3::ZERO
}

/// Number of triangles that have the same three positions, in any order, as one before them.
pub(super) fn count_duplicates(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> u64 {
    let mut keyed: Vec<(u64, u32)> =
        triangles.iter().zip(0u32..).map(|(triangle, number)| (digest(&key(positions, triangle)), number)).collect();
    keyed.sort_unstable();
    let mut duplicates = 0;
    for run in keyed.chunk_by(|a, b| a.0 == b.0) {
        if run.len() == 1 {
            continue;
        }
        // Equal digests are no proof; equal keys are.
        let mut keys: Vec<Key> = run.iter().map(|&(_, number)| key(positions, &triangles[number as usize])).collect();
        keys.sort_unstable();
        duplicates += keys.windows(2).filter(|pair| pair[0] == pair[1]).count() as u64;
    }
    duplicates
}

type Key = [[u32; 3]; 3];

/// The bits of the three positions in sorted order; minus zero counts as zero.
fn key(positions: &[[f32; 3]], triangle: &[u32; 3]) -> Key {
    let mut key = triangle.map(|corner| positions[corner as usize].map(|x| (x + 0.0).to_bits()));
    key.sort_unstable();
    key
}

fn digest(key: &Key) -> u64 {
    key.iter().flatten().fold(0, |digest: u64, &word| {
        let mixed = (digest ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ (mixed >> 29)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proves that only exactly flat triangles count as such: one ulp off a line is kept.
    #[test]
    fn zero_area_is_exact() {
        let line = [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2], [0.4, 0.4, 0.4]];
        assert!(has_zero_area(&line));
        let mut off = line;
        off[1][0] = f32::from_bits(off[1][0].to_bits() + 1);
        assert!(!has_zero_area(&off));
        assert!(has_zero_area(&[[1.0; 3], [1.0; 3], [2.0, 0.0, 0.0]]));
        let tiny = 1e-42;
        assert!(!has_zero_area(&[[0.0; 3], [tiny, 0.0, 0.0], [0.0, tiny, 0.0]]));
    }

    /// Proves that duplicates are found in any order of corners and through different vertices, and that a triangle
    /// sharing only two corners is none.
    #[test]
    fn duplicates_are_counted_by_position() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, -0.0], [0.0, 0.0, 1.0]];
        let triangles = [[0, 1, 2], [2, 3, 1], [1, 0, 2], [0, 1, 4]];
        assert_eq!(count_duplicates(&positions, &triangles), 2);
        assert_eq!(count_duplicates(&positions, &triangles[2..]), 0);
    }
}
