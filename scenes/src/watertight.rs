//! Whether surfaces are closed.
//!
//! By sorted lists: at ten million triangles, hash maps of vertices and edges take about eight times as long.

use crate::scene::Mesh;

/// Whether every edge is walked as often in one direction as in the other, vertices at equal positions being one. Edges
/// of no length do not count.
pub(crate) fn is_watertight(mesh: &Mesh) -> bool {
    let welded = weld(&mesh.positions);
    let mut rising = Vec::with_capacity(mesh.triangles.len() * 3 / 2);
    let mut falling = Vec::with_capacity(mesh.triangles.len() * 3 / 2);
    for triangle in &mesh.triangles {
        let corners = triangle.map(|vertex| welded[vertex as usize]);
        for (from, to) in [(corners[0], corners[1]), (corners[1], corners[2]), (corners[2], corners[0])] {
            if from < to {
                rising.push(edge(from, to));
            } else if to < from {
                falling.push(edge(to, from));
            }
        }
    }
    if rising.len() != falling.len() {
        return false;
    }
    rising.sort_unstable();
    falling.sort_unstable();
    rising == falling
}

fn edge(low: u32, high: u32) -> u64 {
    (u64::from(low) << 32) | u64::from(high)
}

/// For each position the least index of one that equals it.
fn weld(positions: &[[f32; 3]]) -> Vec<u32> {
    let mut keyed: Vec<([u32; 3], u32)> = positions
        .iter()
        .zip(0u32..)
        // Adding zero makes -0 and 0 one.
        .map(|(position, index)| (position.map(|value| (value + 0.0).to_bits()), index))
        .collect();
    keyed.sort_unstable();
    let mut welded = vec![0; positions.len()];
    for run in keyed.chunk_by(|a, b| a.0 == b.0) {
        for (_, index) in run {
            welded[*index as usize] = run[0].1;
        }
    }
    welded
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron whose faces share no vertices, with its corners numbered 0 to 3 as given.
    fn soup(faces: &[[usize; 3]]) -> Mesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 1.0]];
        let positions: Vec<[f32; 3]> = faces.iter().flatten().map(|&corner| corners[corner]).collect();
        let triangles: Vec<[u32; 3]> =
            (0..faces.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        Mesh {
            positions,
            triangle_materials: vec![0; triangles.len()],
            triangle_objects: vec![0; triangles.len()],
            triangles,
            materials: Vec::new(),
            objects: Vec::new(),
        }
    }

    /// Proves that a closed surface counts as such through vertices of their own, also twice and with a triangle that
    /// has no width, and that a missing face, one that is turned over and one that is there twice are noticed.
    #[test]
    fn closed_and_open_surfaces() {
        let closed = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        assert!(is_watertight(&soup(&closed)));
        assert!(is_watertight(&soup(&[closed, closed].concat())));
        assert!(is_watertight(&soup(&[closed.as_slice(), &[[0, 0, 1]]].concat())));
        assert!(!is_watertight(&soup(&closed[1..])));
        assert!(!is_watertight(&soup(&[[0, 1, 2], [0, 1, 3], [0, 3, 2], [1, 2, 3]])));
        assert!(!is_watertight(&soup(&[closed.as_slice(), &closed[..1]].concat())));
    }
}
