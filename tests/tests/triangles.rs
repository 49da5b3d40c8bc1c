//! The triangle test that shaders share, on the device: against f64, and for gaps between neighbours.

use tracebench_api::Ray;
use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::wgpu::BufferUsages;
use tracebench_kit::{bind_group, compute_pipeline, dispatch_linear};
use tracebench_shaders::test::TRIANGLE_FUNCTIONS;
use tracebench_tests::{Numbers, gpu, ray};

type Corners = [Vec3; 3];

/// t (negative for a miss), u and v of every pair.
fn cross_on_device(pairs: &[(Ray, Corners)]) -> Vec<[f32; 4]> {
    let gpu = gpu();
    let pipeline = compute_pipeline(&gpu, TRIANGLE_FUNCTIONS, "cross_pairs").unwrap();
    let rays: Vec<Ray> = pairs.iter().map(|(ray, _)| *ray).collect();
    let corners: Vec<[[f32; 4]; 3]> =
        pairs.iter().map(|(_, corners)| corners.map(|corner| corner.extend(0.0).into())).collect();
    let input =
        |name: &str, contents: &[u8]| gpu.buffer_with(name, contents, BufferUsages::STORAGE, "nothing").unwrap();
    let (rays, corners) =
        (input("rays", bytemuck::cast_slice(&rays)), input("triangles", bytemuck::cast_slice(&corners)));
    let bytes = (pairs.len() * 16) as u64;
    let output = gpu.buffer("crossings", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC, "nothing").unwrap();
    let bindings = bind_group(
        &gpu,
        &pipeline.get_bind_group_layout(0),
        &[rays.as_entire_binding(), corners.as_entire_binding(), output.as_entire_binding()],
    );
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    dispatch_linear(&mut encoder, &pipeline, &bindings, pairs.len() as u32, 64);
    gpu.queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&gpu.read(&output, bytes).unwrap())
}

/// Half ulps between a weight and f64's, with room for drivers that contract or reorder: the shear, its application and
/// the products of the edge functions, each over values of the corners' distance.
const ROUNDINGS: f64 = 96.0;

/// What f64 says of a pair: t and weights where the ray crosses the plane, and how far f32 may be from them.
struct Reference {
    t: f64,
    weights: [f64; 3],
    t_slack: f64,
    weight_slack: f64,
}

/// `None` for a triangle seen along its plane.
fn reference(ray: &Ray, corners: &Corners) -> Option<Reference> {
    let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
    let across = direction.any_orthonormal_vector();
    let aside = direction.cross(across).normalize();
    let local = corners.map(|corner| corner.as_dvec3() - origin);
    let flat = local.map(|corner| DVec2::new(corner.dot(across), corner.dot(aside)));
    let along = local.map(|corner| corner.dot(direction) / direction.length_squared());
    let edges = [flat[1].perp_dot(flat[2]), flat[2].perp_dot(flat[0]), flat[0].perp_dot(flat[1])];
    let determinant: f64 = edges.iter().sum();
    let weights = edges.map(|edge| edge / determinant);
    let far = local.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    let wide = flat.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    let deep = along.iter().fold(f64::MIN, |a, b| a.max(*b)) - along.iter().fold(f64::MAX, |a, b| a.min(*b));
    let half_ulp = f64::from(f32::EPSILON) / 2.0;
    let weight_slack = ROUNDINGS * half_ulp * far * (wide + half_ulp * far) / determinant.abs();
    let t = (0..3).map(|corner| weights[corner] * along[corner]).sum();
    let t_slack = weight_slack * (deep + far * ROUNDINGS * half_ulp) + ROUNDINGS * half_ulp * far;
    (determinant != 0.0 && weight_slack.is_finite()).then_some(Reference { t, weights, t_slack, weight_slack })
}

/// Pairs from scales at which products of three lengths vanish to those at which they overflow: aimed within, at edges, at corners and
/// past; large, small, thin and slanting triangles; rays along axes.
fn hostile_pairs() -> Vec<(Ray, Corners)> {
    let mut numbers = Numbers::new(51);
    let mut pairs = Vec::new();
    for scale in [1e-12, 1e-3, 1.0, 300.0, 1e4, 1e14] {
        for index in 0..4000 {
            let size = scale * [1.0, 1e-2, 30.0][index % 3];
            let place = numbers.point() * scale;
            let first = place + numbers.point() * size;
            let second = place + numbers.point() * size;
            let thin = if index % 7 == 0 { 1e-3 } else { 1.0 };
            let third = first.lerp(second, numbers.unit()) + numbers.point() * size * thin;
            let corners = [first, second, third].map(|corner| corner.as_vec3());
            let [a, b, c] = corners.map(|corner| corner.as_dvec3());
            let (u, v) = match index % 5 {
                0 => (numbers.unit(), 0.0),
                1 => (0.0, 0.0),
                2 => (numbers.signed() * 2.0, numbers.signed() * 2.0),
                _ => (numbers.unit() / 2.0, numbers.unit() / 2.0),
            };
            let target = a + (b - a) * u + (c - a) * v;
            let axis = [DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z][index / 11 % 3];
            let from = if index % 11 == 0 { target - axis * scale } else { numbers.point() * scale * 2.0 };
            pairs.push((ray(from, target - from), corners));
        }
    }
    pairs
}

/// Pairs that the device answers otherwise than rounding explains, and the numbers of sure hits and sure misses.
fn strays(pairs: &[(Ray, Corners)], found: &[[f32; 4]]) -> (Vec<String>, usize, usize) {
    let (mut strays, mut hits, mut misses) = (Vec::new(), 0, 0);
    for ((ray, corners), [t, u, v, _]) in pairs.iter().zip(found) {
        let Some(expected) = reference(ray, corners) else { continue };
        let least = expected.weights.iter().copied().fold(f64::MAX, f64::min);
        let is_hit = *t >= 0.0;
        let mut right = true;
        if least > expected.weight_slack && expected.t > expected.t_slack {
            hits += 1;
            right = is_hit;
        } else if least < -expected.weight_slack || expected.t < -expected.t_slack {
            misses += 1;
            right = !is_hit;
        }
        if is_hit {
            right &= (f64::from(*t) - expected.t).abs() <= expected.t_slack;
            right &= (f64::from(*u) - expected.weights[1]).abs() <= expected.weight_slack;
            right &= (f64::from(*v) - expected.weights[2]).abs() <= expected.weight_slack;
        }
        if !right {
            strays.push(format!("{ray:?} {corners:?}: {t} {u} {v}, not {} {:?}", expected.t, expected.weights));
        }
    }
    (strays, hits, misses)
}

/// Proves that t and weights are f64's to within rounding, and that what is surely hit or missed is, over hostile pairs.
#[test]
fn crossings_are_those_of_f64() {
    let pairs = hostile_pairs();
    let (strays, hits, misses) = strays(&pairs, &cross_on_device(&pairs));
    assert!(strays.is_empty(), "{} of {}: {}", strays.len(), pairs.len(), strays[0]);
    assert!(hits > 3000 && misses > 1000, "{hits} {misses}");
}

/// Negative control: other corners, t off by a hundred-thousandth, and swapped weights are each noticed.
#[test]
fn another_crossing_is_noticed() {
    let pairs = hostile_pairs();
    let found = cross_on_device(&pairs);
    let wrong = |change: &dyn Fn([f32; 4]) -> [f32; 4]| {
        let changed: Vec<[f32; 4]> = found.iter().map(|each| change(*each)).collect();
        !strays(&pairs, &changed).0.is_empty()
    };
    assert!(!wrong(&|each| each));
    assert!(wrong(&|[t, u, v, w]| [t * 1.00001, u, v, w]));
    assert!(wrong(&|[t, u, v, w]| [t, v, u, w]));
    assert!(wrong(&|[_, u, v, w]| [-1.0, u, v, w]));
    let turned: Vec<(Ray, Corners)> = pairs.iter().map(|(ray, [a, b, c])| (*ray, [*b, *c, *a])).collect();
    assert!(!strays(&turned, &found).0.is_empty());
}

/// A closed surface round the origin: a bumpy octahedron, each face divided into 64.
fn closed_surface() -> Vec<Corners> {
    const STEPS: i32 = 8;
    let bump = |point: DVec3| {
        let wave = (3.1 * point.x).sin() + (4.7 * point.y).cos() + (5.3 * point.z).sin();
        (point.normalize() * (1.0 + 0.2 * wave)).as_vec3()
    };
    let mut faces = Vec::new();
    for octant in 0..8 {
        let sign = DVec3::new(
            if octant & 1 == 0 { 1.0 } else { -1.0 },
            if octant & 2 == 0 { 1.0 } else { -1.0 },
            if octant & 4 == 0 { 1.0 } else { -1.0 },
        );
        let at = |i: i32, j: i32| bump(DVec3::new(f64::from(i), f64::from(j), f64::from(STEPS - i - j)) * sign);
        for i in 0..STEPS {
            for j in 0..STEPS - i {
                faces.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 2 <= STEPS {
                    faces.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    faces
}

/// Proves that no ray gets out of a closed surface between its triangles: rays from inside at every corner, and at
/// places on every edge. Negative control: with one triangle taken away, some do.
#[test]
fn closed_surfaces_have_no_gaps() {
    let faces = closed_surface();
    let mut numbers = Numbers::new(52);
    let mut rays = Vec::new();
    for [a, b, _] in &faces {
        let from = numbers.point() * 0.2;
        rays.push(ray(from, a.as_dvec3() - from));
        rays.push(ray(from, a.as_dvec3().lerp(b.as_dvec3(), 0.5) - from));
        rays.push(ray(from, a.as_dvec3().lerp(b.as_dvec3(), numbers.unit()) - from));
    }
    let pairs: Vec<(Ray, Corners)> = rays.iter().flat_map(|ray| faces.iter().map(|corners| (*ray, *corners))).collect();
    let found = cross_on_device(&pairs);
    let escaped = |without: Option<usize>| {
        let stopped =
            |answers: &[[f32; 4]]| answers.iter().enumerate().any(|(face, [t, ..])| Some(face) != without && *t >= 0.0);
        found.chunks(faces.len()).filter(|answers| !stopped(answers)).count()
    };
    assert_eq!(escaped(None), 0, "of {} rays", rays.len());
    assert!(escaped(Some(17)) > 0);
}
