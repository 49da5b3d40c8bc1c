//! The procedural scene `solids`: that "inside" has one meaning everywhere.
#![allow(missing_docs)]

use glam::DVec3;
use tracebench_scenes::{Scene, procedural};

struct Triangle {
    object: u32,
    corners: [DVec3; 3],
    min: DVec3,
    max: DVec3,
}

fn triangles(scene: &Scene) -> Vec<Triangle> {
    let mesh = &scene.mesh;
    let place = |vertex: u32| DVec3::from_array(mesh.positions[vertex as usize].map(f64::from));
    let each = mesh.triangles.iter().zip(&mesh.triangle_objects);
    let mut triangles: Vec<Triangle> = each
        .map(|(triangle, &object)| {
            let corners = triangle.map(place);
            let min = corners[0].min(corners[1]).min(corners[2]);
            Triangle { object, corners, min, max: corners[0].max(corners[1]).max(corners[2]) }
        })
        .collect();
    triangles.sort_by(|a, b| a.min.x.total_cmp(&b.min.x));
    triangles
}

/// Whether an edge of the one goes through the other.
fn cut(one: &Triangle, other: &Triangle) -> bool {
    let pierces = |corners: &[DVec3; 3], [a, b, c]: [DVec3; 3]| {
        (0..3).any(|at| {
            let (from, to) = (corners[at], corners[(at + 1) % 3]);
            let volume = |p: DVec3, q: DVec3, r: DVec3, s: DVec3| (q - p).dot((r - p).cross(s - p));
            let sides = volume(a, b, c, from) * volume(a, b, c, to);
            let around = [volume(from, to, a, b), volume(from, to, b, c), volume(from, to, c, a)];
            sides < 0.0 && (around.iter().all(|&x| x > 0.0) || around.iter().all(|&x| x < 0.0))
        })
    };
    pierces(&one.corners, other.corners) || pierces(&other.corners, one.corners)
}

/// Objects, by name and number, of which a triangle cuts one of another object.
fn cuts(scene: &Scene) -> Vec<String> {
    let triangles = triangles(scene);
    let mut found = Vec::new();
    for (at, one) in triangles.iter().enumerate() {
        for other in triangles[at + 1..].iter().take_while(|other| other.min.x <= one.max.x) {
            let apart = one.min.cmpgt(other.max) | other.min.cmpgt(one.max);
            if one.object != other.object && !apart.any() && cut(one, other) {
                let name = |object: u32| format!("{} {object}", scene.mesh.objects[object as usize]);
                found.push(format!(
                    "{} and {}",
                    name(one.object.min(other.object)),
                    name(one.object.max(other.object))
                ));
            }
        }
    }
    found.sort();
    found.dedup();
    found
}

/// Proves that no object cuts another. One that is moved to where another stands does.
#[test]
fn objects_stand_apart() {
    let mut scene = procedural("solids", 0.5).unwrap();
    assert_eq!(cuts(&scene), Vec::<String>::new());
    let knot = scene.mesh.objects.iter().position(|name| name == "knot").unwrap();
    let mesh = &mut scene.mesh;
    let mut vertices: Vec<u32> = Vec::new();
    for (triangle, &object) in mesh.triangles.iter().zip(&mesh.triangle_objects) {
        if object as usize == knot {
            vertices.extend(triangle);
        }
    }
    vertices.sort_unstable();
    vertices.dedup();
    for vertex in vertices {
        mesh.positions[vertex as usize][0] += 1.9;
    }
    assert!(!cuts(&scene).is_empty());
}
