//! That layers are the nearest surfaces of every pixel, however they are caught.

use std::sync::Arc;

use tracebench_api::glam::{DVec2, DVec3};
use tracebench_kit::{Built, Fragment, allowed_fragments, undecided_border};
use tracebench_tests::{gpu, soup};

use super::images::Images;
use super::nodes::Node;
use super::structure::{Quadtree, QuadtreeStructure};
use super::tests::{built_by, hostile, rectangle, viewpoint};
use super::validate::compare;

/// Complemented depths of all images.
fn codes(structure: &Built<QuadtreeStructure>) -> Vec<u32> {
    Images::read(structure.gpu(), &structure.images.codes).unwrap()
}

/// Proves that the k-buffer and peeling catch the same layers to the bit, of the frame and of faces, with back faces and without;
/// that fewer layers are the first of more; and, as a negative control, that back faces and a separation change them.
#[test]
fn both_captures_catch_the_same() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let caught = |settings: &[(&str, &str)]| codes(&built_by(&tracer, &gpu, &geometry, settings));
    for (views, faces) in [("frame", "kept"), ("frame", "culled"), ("six", "kept")] {
        let by =
            |capture: &str| caught(&[("views", views), ("back_faces", faces), ("layers", "4"), ("capture", capture)]);
        let found = by("k-buffer");
        assert!(found == by("peeling"), "{views}, {faces}");
        // All four layers have something.
        let filled = found.iter().rev().take(63 * 41).filter(|code| **code != 0).count();
        assert!(filled > 20, "{views}, {faces}: {filled}");
    }
    let pixels = 63 * 41;
    let four = caught(&[("layers", "4")]);
    let two = caught(&[]);
    assert!(two == four[..2 * pixels]);
    assert!(caught(&[("back_faces", "culled")]) != two);
    for capture in ["k-buffer", "peeling"] {
        let apart = caught(&[("minimum_separation", "0.01"), ("capture", capture)]);
        assert!(apart != two && apart[..pixels] == two[..pixels]);
    }
}

/// Proves that a separation skips what lies close behind: of four plates one behind the other, two close to each other, layers are
/// what brute force over the plates picks, by both captures; where the k-buffer's slots do not reach, it says less, and nothing wrong.
#[test]
fn separations_skip_what_is_close() {
    let gpu = gpu();
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let eye = viewpoint().eye.as_dvec3();
    let depths = [2.0, 2.1, 2.2, 2.3, 2.4, 5.0, 8.0];
    let plates = depths.map(|depth| rectangle(eye - DVec3::new(30.0, 30.0, depth), DVec3::X * 60.0, DVec3::Y * 60.0));
    let geometry = soup(plates.as_flattened(), Some(&gpu));
    let diagonal = geometry.diagonal();
    for (separation, by_peeling, by_buffer) in [
        (0.0, vec![2.0, 2.1], vec![2.0, 2.1]),
        (0.15, vec![2.0, 2.2], vec![2.0, 2.2]),
        (1.0, vec![2.0, 5.0], vec![2.0]),
        (4.0, vec![2.0, 8.0], vec![2.0]),
        (7.0, vec![2.0], vec![2.0]),
    ] {
        let share = (separation / diagonal).to_string();
        for (capture, expected) in [("peeling", &by_peeling), ("k-buffer", &by_buffer)] {
            let structure = built_by(&tracer, &gpu, &geometry, &[("minimum_separation", &share), ("capture", capture)]);
            structure.check(&geometry).unwrap();
            let codes = codes(&structure);
            let pixel = 20 * 63 + 31;
            let found = [codes[pixel], codes[63 * 41 + pixel]].into_iter().filter(|code| *code != 0);
            let found: Vec<f64> = found.map(|code| f64::from(f32::from_bits(!code))).collect();
            let near = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4);
            assert!(near, "{separation} by {capture}: {found:?}, not {expected:?}");
        }
    }
}

/// Negative control of the comparison with the host's rasterizer: a layer that is left out, one that no triangle gives and one
/// behind another that is missing are noticed, in most pixels that have two.
#[test]
fn wrong_layers_are_noticed() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let structure = built_by(&Quadtree::new(Arc::clone(&gpu)).unwrap(), &gpu, &geometry, &[]);
    let shape = &structure.shape;
    let border = undecided_border(&tracebench_kit::rasterizer(&gpu).unwrap());
    let allowed = allowed_fragments(&shape.views[0], &geometry, 1, border);
    let codes = codes(&structure);
    let payloads = Images::read(&gpu, &structure.images.payloads[0]).unwrap();
    let behind = Images::read(&gpu, &structure.images.payloads[1]).unwrap();
    let (mut pairs, mut noticed) = (0, [0; 3]);
    for (y, x) in (0..41_u32).flat_map(|y| (0..63_u32).map(move |x| (y, x))) {
        let pixel = (y * 63 + x) as usize;
        if codes[63 * 41 + pixel] == 0 {
            continue;
        }
        let fragment = |code: u32, words: &[u32]| Fragment {
            depth: f32::from_bits(!code),
            normal: [0, 1, 2].map(|axis| f32::from_bits(words[4 * pixel + axis])).into(),
            material: words[4 * pixel + 3],
        };
        let (first, second) = (fragment(codes[pixel], &payloads), fragment(codes[63 * 41 + pixel], &behind));
        let here = allowed.of([x, y]);
        compare(&[first, second], here, shape).unwrap();
        pairs += 1;
        let wrong = [vec![first], vec![second], vec![first, Fragment { depth: second.depth * 1.1, ..second }]];
        for (count, layers) in noticed.iter_mut().zip(wrong) {
            *count += usize::from(compare(&layers, here, shape).is_err());
        }
    }
    assert!(pairs > 200 && noticed.iter().all(|count| 10 * count > 7 * pairs), "{noticed:?} of {pairs}");
}

/// Proves that the bottom level's planes are those of the surface, from depth and from geometry: of slanted walls z and slopes are
/// f64's to within half precision, and no pixel that sees one wall alone is flagged; at the wall's end pixels are. Negative control:
/// another wall is noticed.
#[test]
fn bottom_planes_are_those_of_the_surface() {
    let gpu = gpu();
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let view = viewpoint().frame_view();
    let walls = [DVec3::new(0.3, 0.2, 1.0), DVec3::new(-0.8, 0.1, 1.0), DVec3::new(0.1, 1.0, 0.4)];
    for normals in ["depth", "geometry"] {
        for across in walls.map(DVec3::normalize) {
            let first = across.any_orthonormal_vector();
            let second = across.cross(first);
            let middle = view.eye + DVec3::new(0.1, -0.3, -3.0);
            let wall = rectangle(middle - (first + second) * 1.2, first * 2.4, second * 2.4);
            let structure = built_by(&tracer, &gpu, &soup(&wall, Some(&gpu)), &[("normals", normals), ("layers", "1")]);
            let nodes: Vec<[u32; 2]> =
                bytemuck::cast_slice(&Images::read(&gpu, &structure.images.nodes).unwrap()).to_vec();
            let is_of = |plane_at: DVec3, pixel: usize| {
                let Node::Plane(plane) = Node::of(nodes[pixel], [63, 41]) else { return false };
                let z = |x: f64, y: f64| {
                    let sight = view.direction_through(x, y);
                    let inverse = across.dot(sight) / across.dot(plane_at - view.eye);
                    (view.near * view.far * inverse - view.near) / (view.far - view.near)
                };
                let at = DVec2::new((pixel % 63) as f64 + 0.5, (pixel / 63) as f64 + 0.5);
                let slope = DVec2::new(z(at.x + 1.0, at.y) - z(at.x, at.y), z(at.x, at.y + 1.0) - z(at.x, at.y));
                (plane.z - z(at.x, at.y)).abs() < 1e-6 && (plane.slope - slope).length() < 2e-3 * slope.length() + 2e-6
            };
            let shown: Vec<usize> = (0..63 * 41).filter(|pixel| nodes[*pixel][0] >> 31 == 1).collect();
            let right = shown.iter().filter(|pixel| is_of(middle, **pixel)).count();
            // A rim that is a pixel wide has no neighbour to tell its slope by.
            let least = if normals == "geometry" { shown.len() } else { shown.len() - 20 };
            assert!(shown.len() > 100 && right >= least, "{normals} {across}: {right} of {}", shown.len());
            assert_eq!(shown.iter().filter(|pixel| is_of(middle + across * 0.05, **pixel)).count(), 0);
            let flagged = |pixel: &&usize| nodes[**pixel][0] & 0x4000_0000 != 0;
            let inner = |pixel: &&usize| {
                [1, 63].iter().all(|step| {
                    **pixel >= *step && nodes[**pixel - step][0] >> 31 == 1 && nodes[**pixel + step][0] >> 31 == 1
                })
            };
            assert_eq!(shown.iter().filter(inner).filter(flagged).count(), 0);
            assert!(shown.iter().filter(flagged).count() > 10);
        }
    }
}
