//! Whether surfaces are closed.
//!
//! By sorted lists: at ten million triangles, hash maps of vertices and edges take about eight times as long.

use tracebench_scenes::Mesh;

/// Whether every edge is walked as often in one direction as in the other, vertices at equal positions being one. Edges
/// of no length do not count.
pub fn is_watertight(mesh: &Mesh) -> bool {
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
