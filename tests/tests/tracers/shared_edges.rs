//! Rays exactly through edges and vertices that triangles share: none is lost between them.

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{Preset, Query, Ray};
use tracebench_harness::registry::find;
use tracebench_tests::{Numbers, ray, soup, viewpoint};

use super::hostile::{Subject, subjects};

/// A mesh with rays that all hit it.
struct Mesh {
    name: &'static str,
    triangles: Vec<[[f32; 3]; 3]>,
    rays: Vec<Ray>,
    eye: Vec3,
}

/// The two triangles of a grid's cell.
fn halves(at: impl Fn(i32, i32) -> Vec3, x: i32, y: i32) -> [[[f32; 3]; 3]; 2] {
    let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)].map(<[f32; 3]>::from);
    [[a, b, c], [a, c, d]]
}

/// A bumpy grid, and rays through each of its 3,969 inner vertices, from one point and along an axis, by either zero.
fn grids() -> [Mesh; 2] {
    let at = |x: i32, y: i32| Vec3::new(x as f32, y as f32, 0.5 * (0.7 * x as f32).sin() * (0.9 * y as f32).cos());
    let triangles: Vec<_> = (0..64).flat_map(|y| (0..64).flat_map(move |x| halves(at, x, y))).collect();
    let eye = Vec3::new(32.2, 31.7, 90.3);
    let inner = || (1..64).flat_map(|y| (1..64).map(move |x| at(x, y)));
    let seen = inner().map(|vertex| ray(eye.as_dvec3(), (vertex - eye).as_dvec3())).collect();
    let down = |zero: f32| ray(DVec3::ZERO, DVec3::new(zero.into(), (-zero).into(), -1.0));
    let above = [0.0, -0.0]
        .into_iter()
        .flat_map(|zero| inner().map(move |vertex| Ray { origin: [vertex.x, vertex.y, 50.0], ..down(zero) }));
    let above = above.collect();
    [
        Mesh { name: "grid", triangles: triangles.clone(), rays: seen, eye },
        Mesh { name: "grid along an axis", triangles, rays: above, eye },
    ]
}

/// A closed surface round the origin of six square grids of so many cells an edge, and rays from within through all vertices and
/// places on all edges.
fn closed(name: &'static str, cells: i32, bumps: f64, seed: u64) -> Mesh {
    let bumped = |cube: DVec3| {
        let wave = (3.1 * cube.x).sin() + (4.7 * cube.y).cos() + (5.3 * cube.z).sin();
        (cube * (1.0 + bumps * wave)).as_vec3()
    };
    let place = |at: i32| f64::from(2 * at - cells) / f64::from(cells);
    let mut triangles = Vec::new();
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let at = |x: i32, y: i32| {
            let mut cube = DVec3::splat(side);
            (cube[(axis + 1) % 3], cube[(axis + 2) % 3]) = (place(x), place(y));
            bumped(cube)
        };
        triangles.extend((0..cells).flat_map(|y| (0..cells).flat_map(move |x| halves(at, x, y))));
    }
    let mut numbers = Numbers::new(seed);
    let mut rays = Vec::new();
    while rays.len() < 4096 {
        for [a, b, c] in &triangles {
            let [a, b, c] = [a, b, c].map(|corner| Vec3::from(*corner).as_dvec3());
            let from = (numbers.point() * 0.4).as_vec3().as_dvec3();
            let aims = [a, a.midpoint(b), a.lerp(b, numbers.unit()), c.lerp(a, numbers.unit())];
            rays.extend(aims.map(|aim| ray(from, aim - from)));
        }
    }
    Mesh { name, triangles, rays, eye: Vec3::new(0.1, -0.05, 0.2) }
}

/// Rays that miss.
fn lost(subject: &Subject, mesh: &Mesh) -> usize {
    let geometry = soup(&mesh.triangles, Some(&subject.gpu));
    let structure = subject.build(&geometry, &viewpoint(mesh.eye, Vec3::new(0.3, 0.1, 0.0), 1e-3, 1e3, [48, 32]));
    let hits = subject.trace(&*structure, &subject.rays(&mesh.rays, Query::Closest));
    hits.iter().filter(|hit| !hit.is_hit()).count()
}

/// Proves that of rays through a grid's vertices, and from within closed surfaces through all edges and vertices, no method that names
/// triangles loses any, by whatever build; but for `bvh-cpu` as published, whose test is obvhs's: the negative control.
#[test]
fn no_ray_is_lost_between_triangles() {
    let meshes = grids().into_iter().chain([closed("box", 1, 0.0, 61), closed("solid", 6, 0.1, 62)]);
    let meshes: Vec<Mesh> = meshes.collect();
    for mut subject in subjects().into_iter().filter(|subject| subject.names_primitives) {
        let described = find(subject.name).unwrap().describe().parameters;
        let builds = described.iter().find(|parameter| parameter.name == "build");
        let builds = builds.map_or_else(|| vec![None], |build| build.sweep.iter().map(Some).collect());
        for (build, mesh) in builds.into_iter().flat_map(|build| meshes.iter().map(move |mesh| (build, mesh))) {
            if let Some(build) = build {
                subject.parameters.set(&described, "build", &build.to_string()).unwrap();
            }
            let loses = (subject.name, subject.preset) == ("bvh-cpu", Preset::Published) && !mesh.name.contains("axis");
            let lost = lost(&subject, mesh);
            let context =
                format!("{} {:?} {}: {lost} of {}", subject.name, subject.parameters, mesh.name, mesh.rays.len());
            assert_eq!(lost > 0, loses, "{context}");
        }
    }
}
