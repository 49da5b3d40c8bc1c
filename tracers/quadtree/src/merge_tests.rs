//! How nodes are merged on the device, against f64.

use tracebench_api::glam::{DVec2, DVec3};
use tracebench_tests::{Numbers, gpu};

use crate::function_tests::{Call, SIZE, SLACK, call, forest};
use crate::layout::Forest;
use crate::nodes::{NOTHING, Node, Plane};

/// A node that stands for others, in f64: a plane or a box, and whether rounding may decide otherwise.
fn merged(forest: &Forest, children: &[Node; 4], there: u32, level: u32) -> (Node, bool) {
    let edge = f64::from(1_u32 << level);
    let from_middle = |child: usize| DVec2::new(child as f64 % 2.0 - 0.5, (child / 2) as f64 - 0.5) * edge;
    let exist: Vec<usize> = (0..4).filter(|child| there >> child & 1 == 1).collect();
    let planes: Vec<(usize, Plane)> = exist
        .iter()
        .filter_map(|child| if let Node::Plane(plane) = children[*child] { Some((*child, plane)) } else { None })
        .collect();
    let mut undecided = false;
    if planes.len() == exist.len() {
        let normal = planes.iter().map(|(_, plane)| plane.normal).sum::<DVec3>().normalize();
        let size = DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1]));
        let slope = -normal.truncate() / normal.z / size;
        // Least squares over all sixteen corners.
        let corners = |edge: f64| [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]].map(|at| DVec2::from(at) * edge);
        let at =
            |child: usize, plane: &Plane, corner: DVec2| plane.z_at(corner) - slope.dot(from_middle(child) + corner);
        let offsets: Vec<f64> =
            planes.iter().flat_map(|(child, plane)| corners(edge).map(|corner| at(*child, plane, corner))).collect();
        let z = offsets.iter().sum::<f64>() / offsets.len() as f64;
        let farthest = offsets.iter().map(|offset| (offset - z).abs() * normal.z).fold(0.0, f64::max);
        let turned = planes.iter().map(|(_, plane)| (plane.normal - normal).length()).fold(0.0, f64::max);
        let (angle, distance) = (f64::from(forest.gamma_norm), f64::from(forest.gamma_dist));
        // The device fits what half precision leaves of the normal.
        let half = 2_f64.powi(-11) / normal.z;
        let coarse = half * edge * 2.0 / normal.z.powi(2) / size.min_element() + SLACK;
        undecided =
            (turned - angle).abs() <= 2.0 * half || (farthest - distance).abs() <= coarse || !(0.0..=1.0).contains(&z);
        if turned < angle && farthest < distance {
            let flagged = planes.iter().any(|(_, plane)| plane.flagged);
            return (Node::Plane(Plane { z, normal, slope, flagged, end: None }), undecided);
        }
    }
    let (mut least, mut greatest, mut holes) = (1.0_f64, 0.0_f64, false);
    for child in exist {
        let range = match children[child] {
            Node::Empty => {
                holes = true;
                continue;
            }
            Node::Box { least, greatest, holes: other } => {
                holes |= other;
                [least, greatest]
            }
            Node::Plane(plane) => {
                plane.range(0.5 * edge + if plane.flagged { 0.0 } else { f64::from(forest.dilation) })
            }
        };
        (least, greatest) = (least.min(range[0]), greatest.max(range[1]));
    }
    if least > greatest { (Node::Empty, undecided) } else { (Node::Box { least, greatest, holes }, undecided) }
}

/// The nearest half to a number below 1 in size.
fn half_of(value: f64) -> u32 {
    let size = value.abs();
    let bits = if size < 2_f64.powi(-14) {
        (size * 2_f64.powi(24)).round() as u32
    } else {
        let exponent = size.log2().floor();
        // What rounds up to the next power of two carries into the exponent.
        ((exponent as i32 + 15) as u32) * 1024 + ((size / exponent.exp2() - 1.0) * 1024.0).round() as u32
    };
    bits | if value < 0.0 { 0x8000 } else { 0 }
}

/// Words of a plane.
fn words_of(z: f64, slope: DVec2, flagged: bool) -> [u32; 2] {
    let normal = (-slope).extend(1.0).normalize();
    let flag = if flagged { 0x4000_0000 } else { 0 };
    [0x8000_0000 | flag | (z as f32).to_bits(), half_of(normal.y) << 16 | half_of(normal.x)]
}

/// Proves that four nodes are merged as f64 merges them: planes that nearly lie in one and others, with children that do not exist,
/// with boxes and nothing among them; only where a threshold is met to within rounding either answer will do. Negative control:
/// other thresholds give others.
#[test]
fn children_are_merged_as_by_f64() {
    let gpu = gpu();
    let mut numbers = Numbers::new(152);
    let forest = forest();
    let mut words = Vec::new();
    for index in 0..600 {
        let level = index % 5;
        let edge = f64::from(1_u32 << level);
        let (z, slope) = (0.2 + 0.5 * numbers.unit(), DVec2::new(numbers.signed(), numbers.signed()) * 0.4);
        // From the same plane to unrelated ones.
        let off = [0.0, 1e-5, 1e-4, 1e-3, 0.1][index / 5 % 5];
        let mut children = [NOTHING; 4];
        for (child, node) in children.iter_mut().enumerate() {
            let from_middle = DVec2::new(child as f64 % 2.0 - 0.5, (child / 2) as f64 - 0.5) * edge;
            let change = slope.dot(from_middle / DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1])));
            let other = slope + DVec2::new(numbers.signed(), numbers.signed()) * off;
            *node = words_of(z + change + numbers.signed() * off, other, numbers.unit() < 0.1);
        }
        match index % 11 {
            3 => children[2] = NOTHING,
            5 => children[1] = [0.125_f32.to_bits(), 0.75_f32.to_bits()],
            7 => children = [NOTHING; 4],
            9 => children[0] = [0.125_f32.to_bits(), 0.75_f32.to_bits() | 0x8000_0000],
            _ => {}
        }
        let there = [0b1111, 0b0101, 0b0011, 0b0001][if index % 3 == 0 { index / 3 % 4 } else { 0 }];
        words.extend(children);
        words.push([there, level as u32]);
    }
    let count = words.len() / 5;
    let asked = Call {
        entry_point: "merge_children",
        forest,
        given: &[],
        words: &words,
        invocations: count,
        results: 0,
        nodes: count,
    };
    let (_, nodes) = call(&gpu, &asked);
    let compare = |forest: &Forest| {
        let (mut wrong, mut undecided, mut planes) = (0, 0, 0);
        for (given, found) in words.chunks(5).zip(&nodes) {
            let children = [0, 1, 2, 3].map(|child| Node::of(given[child], SIZE));
            let (expected, either) = merged(forest, &children, given[4][0], given[4][1]);
            let is_right = match (expected, Node::of(*found, SIZE)) {
                (Node::Plane(expected), Node::Plane(found)) => {
                    planes += 1;
                    let half = 2_f64.powi(-11) * (1.0 + 1.0 / expected.normal.z);
                    (found.normal - expected.normal).length() <= half
                        && (found.z - expected.z).abs() <= SLACK + 1e-6
                        && found.flagged == expected.flagged
                }
                (Node::Box { least, greatest, holes }, Node::Box { least: a, greatest: b, holes: others }) => {
                    (least - a).abs() <= 1e-6 && (greatest - b).abs() <= 1e-6 && holes == others
                }
                (expected, found) => expected == found,
            };
            undecided += usize::from(either && !is_right);
            wrong += usize::from(!either && !is_right);
        }
        (wrong, undecided, planes)
    };
    let (wrong, undecided, planes) = compare(&forest);
    assert_eq!(wrong, 0);
    assert!(undecided < 30 && planes > 100, "{undecided} undecided, {planes} planes");
    assert!(compare(&Forest { gamma_dist: 1e-2, ..forest }).0 > 30);
    assert!(compare(&Forest { dilation: 2.0, ..forest }).0 > 30);
}
