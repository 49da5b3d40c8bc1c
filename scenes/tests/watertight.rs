//! What tells whether surfaces are closed.
#![allow(missing_docs)]

use crate::support::watertight::is_watertight;
use tracebench_scenes::Mesh;

/// A tetrahedron whose faces share no vertices, with its corners numbered 0 to 3 as given.
fn soup(faces: &[[usize; 3]]) -> Mesh {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 1.0]];
    let positions: Vec<[f32; 3]> = faces.iter().flatten().map(|&corner| corners[corner]).collect();
    let triangles: Vec<[u32; 3]> = (0..faces.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
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
