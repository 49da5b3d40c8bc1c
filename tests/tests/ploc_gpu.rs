//! `ploc-gpu` by both kinds of node and of tree against `bvh-gpu`, whose hierarchies obvhs builds: a hit depends on the triangles alone,
//! so sound hierarchies over the same triangles give the same hits, bit for bit.

use crate::subject;

use std::sync::Arc;

use tracebench_api::glam::DVec3;
use tracebench_api::{AdapterChoice, Geometry, Gpu, PhaseClock, Query, Ray, Structure, TracerError, Update};
use tracebench_scenes::procedural;
use tracebench_tests::{Numbers, gpu, ray, rectangle, soup};

use subject::{Subject, room, total, view};

/// Both kinds of node over both kinds of tree.
const FORMS: [[(&str, &str); 2]; 4] = [
    [("node", "cwbvh"), ("tree", "ploc")],
    [("node", "bvh2"), ("tree", "ploc")],
    [("node", "cwbvh"), ("tree", "lbvh")],
    [("node", "bvh2"), ("tree", "lbvh")],
];

fn statistic(structure: &dyn Structure, geometry: &Geometry, name: &str) -> f64 {
    let statistics = structure.validate(geometry).unwrap();
    statistics.iter().find(|(found, _)| *found == name).map(|(_, value)| *value).unwrap()
}

/// Proves that both kinds of node give the hits of `bvh-gpu` for every search radius and for a radix tree, that any hit agrees
/// with the closest, and that the search visits no more than 1.4 times the nodes of obvhs's hierarchy with reinsertion (2 times
/// by a radix tree) and tests no more than 1.2 (1.5) times the triangles: children are ordered and leaves are cut as they
/// should be.
#[test]
fn hits_are_those_of_another_hierarchy() {
    let gpu = gpu();
    let (geometry, rays) = room(&gpu);
    for form in FORMS {
        let clustered = form[1].1 == "ploc";
        let other = Subject::new("bvh-gpu", &form[..1], &gpu);
        let (expected, expected_work) = other.answer(&*other.try_build(&geometry).unwrap(), &rays, Query::Closest);
        for radius in ["8", "1", "16"].into_iter().take(if clustered { 3 } else { 1 }) {
            let subject = Subject::new("ploc-gpu", &[form[0], form[1], ("search_radius", radius)], &gpu);
            let structure = subject.try_build(&geometry).unwrap();
            assert_eq!(statistic(&*structure, &geometry, "cluster_iterations") > 10.0, clustered);
            let (hits, work) = subject.answer(&*structure, &rays, Query::Closest);
            assert_eq!(hits, expected, "{form:?} {radius}");
            let any = subject.answer(&*structure, &rays, Query::Any).0;
            assert!(any.iter().zip(&hits).all(|(any, closest)| any.is_hit() == closest.is_hit()), "{form:?} {radius}");
            if radius == "8" {
                let [nodes, tests] = if clustered { [1.4, 1.2] } else { [2.0, 1.5] };
                for (name, most) in [("nodes_visited", nodes), ("triangle_tests", tests)] {
                    let ratio = total(&work, name) / total(&expected_work, name);
                    assert!(ratio < most, "{form:?} {name}: {ratio}");
                }
            }
        }
    }
}

type Triangle = [[f32; 3]; 3];

fn at_random(count: usize, seed: u64, place: impl Fn(DVec3) -> DVec3) -> Vec<Triangle> {
    let mut numbers = Numbers::new(seed);
    let mut triangle = || {
        let centre = place(numbers.point());
        std::array::from_fn(|_| (centre + numbers.point() * 0.05).as_vec3().to_array())
    };
    (0..count).map(|_| triangle()).collect()
}

/// Scenes that are hard on codes, clusters or depths.
fn hard_scenes() -> Vec<(&'static str, Vec<Triangle>)> {
    let plate = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])[0];
    let mut equal = vec![plate; 5000];
    equal.extend(rectangle([-1.0, -1.0, -0.5], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]));
    // Each is nearest to the one before, so that a search merges a single pair.
    let growing = |count: usize, factor: f64| -> Vec<Triangle> {
        let size = |index: usize| factor.powi(index as i32 - count as i32) as f32;
        (0..count).map(|index| plate.map(|corner| corner.map(|value| value * 2.0 * size(index)))).collect()
    };
    vec![
        ("one", at_random(1, 80, |point| point * 0.1)),
        ("two", at_random(2, 81, |point| point)),
        ("three", at_random(3, 82, |point| point)),
        ("four", at_random(4, 83, |point| point)),
        ("nine", at_random(9, 84, |point| point)),
        ("equal", equal),
        ("one cell", at_random(3000, 85, |point| point * 1e-5)),
        ("a line", at_random(3000, 86, |point| DVec3::X * point.x)),
        ("a plane", rectangles(40)),
        ("clumps", at_random(5000, 87, |point| point.round() + point * 1e-4)),
        ("growing", growing(400, 1.2)),
        ("slowly growing", growing(5000, 1.004)),
    ]
}

/// A flat grid.
fn rectangles(edge: usize) -> Vec<Triangle> {
    let step = 2.0 / edge as f32;
    let corner = |index: usize| [(index % edge) as f32 * step - 1.0, (index / edge) as f32 * step - 1.0, 0.25];
    (0..edge * edge).flat_map(|index| rectangle(corner(index), [step, 0.0, 0.0], [0.0, step, 0.0])).collect()
}

fn rays_through(seed: u64, scale: f64) -> Vec<Ray> {
    let mut numbers = Numbers::new(seed);
    (0..800)
        .map(|_| ray(numbers.direction() * (3.0 * scale), numbers.point() * scale - numbers.direction() * scale))
        .chain((0..800).map(|index| {
            let across = DVec3::new(f64::from(index % 29) / 15.0 - 0.95, f64::from(index / 29) / 15.0 - 0.93, 3.0);
            ray(across * scale, DVec3::NEG_Z)
        }))
        .collect()
}

/// Proves that single and few triangles, thousands of equal ones, many in one cell, lines, planes, and clusters of which a
/// search merges one pair at a time are built soundly and no deeper than private stacks serve, at sizes from 1e-12 to
/// 1e14, with the hits of obvhs's hierarchy.
#[test]
fn hard_scenes_are_built() {
    let gpu = gpu();
    for form in FORMS {
        let node = form[0].1;
        let subject = Subject::new("ploc-gpu", &form, &gpu);
        let other = Subject::new("bvh-gpu", &[form[0], ("build", "fastest"), ("rays_per_lane", "1")], &gpu);
        let most = if node == "cwbvh" { tracebench_bvh::WIDE_STACK } else { tracebench_bvh::BINARY_STACK };
        for (name, triangles) in hard_scenes() {
            for scale in [1.0_f32, 1e-12, 1e14] {
                let scaled: Vec<Triangle> =
                    triangles.iter().map(|corners| corners.map(|corner| corner.map(|value| value * scale))).collect();
                let geometry = soup(&scaled, Some(&gpu));
                let rays = rays_through(88, f64::from(scale));
                let structure = subject.try_build(&geometry).unwrap();
                let depth = statistic(&*structure, &geometry, "depth");
                assert!(depth <= most as f64, "{form:?} {name}: {depth} levels");
                // Equal clusters merge as a balanced tree.
                assert!(name != "equal" || depth <= 16.0, "{form:?} {name}: {depth} levels");
                let expected = other.answer(&*other.try_build(&geometry).unwrap(), &rays, Query::Closest).0;
                let hits = subject.answer(&*structure, &rays, Query::Closest).0;
                assert_eq!(hits, expected, "{form:?} {name} {scale}");
                let count = hits.iter().filter(|hit| hit.is_hit()).count();
                assert!(count > 0 || triangles.len() < 10, "{form:?} {name} {scale}: nothing is hit");
            }
        }
    }
}

/// Proves that searches alone would grow too deep: the slowly growing scene takes the limit on heights, and the pairing, to
/// stay within the stacks (the negative control of the bound).
#[test]
fn depths_reach_their_bound() {
    let gpu = gpu();
    let subject = Subject::new("ploc-gpu", &[("node", "bvh2")], &gpu);
    let scenes = hard_scenes();
    let (_, triangles) = scenes.iter().find(|(name, _)| *name == "growing").unwrap();
    let geometry = soup(triangles, Some(&gpu));
    let structure = subject.try_build(&geometry).unwrap();
    let depth = statistic(&*structure, &geometry, "depth");
    assert!((50.0..=tracebench_bvh::BINARY_STACK as f64).contains(&depth), "{depth} levels");
}

fn update(subject: &Subject, structure: &mut dyn Structure, update: Update, geometry: &Geometry) {
    let mut clock = PhaseClock::new(Some(&subject.gpu));
    structure.update(update, geometry, &view(), &subject.parameters, &mut clock).unwrap();
    clock.finish().unwrap();
    structure.validate(geometry).unwrap();
}

/// Proves that refits follow moving vertices by both nodes, there and back, as do rebuilds, and that neither takes more
/// memory than the first build.
#[test]
fn refits_follow_by_both_nodes() {
    let gpu = gpu();
    let [start, later] = [0.0, 0.9].map(|time_s| {
        let mut scene = procedural("cloth", 0.05).unwrap();
        scene.set_time(time_s).unwrap();
        scene
    });
    let rays = room(&gpu).1;
    for form in FORMS {
        let subject = Subject::new("ploc-gpu", &form, &gpu);
        let mesh = start.mesh.clone();
        let mut geometry = Geometry::new(mesh.positions, mesh.triangles, Some(&gpu)).unwrap();
        let mut structure = subject.try_build(&geometry).unwrap();
        let before = subject.answer(&*structure, &rays, Query::Closest).0;
        let bytes = structure.memory().structure_bytes();
        let mut moved_by = |positions: &[[f32; 3]], way: Update| {
            geometry = geometry.clone().with_positions(positions.to_vec(), Some(&gpu)).unwrap();
            update(&subject, &mut *structure, way, &geometry);
            assert_eq!(structure.memory().structure_bytes(), bytes);
            subject.answer(&*structure, &rays, Query::Closest).0
        };
        let moved = moved_by(&later.mesh.positions, Update::Refit);
        assert_ne!(moved, before);
        assert_eq!(moved_by(&start.mesh.positions, Update::Refit), before, "{form:?}");
        assert_eq!(moved_by(&later.mesh.positions, Update::Rebuild), moved, "{form:?}");
        assert_eq!(moved_by(&start.mesh.positions, Update::Refit), before, "{form:?}");
    }
}

/// Proves that a single triangle and a few are refitted, which have no iterations before the last ones.
#[test]
fn few_triangles_are_refitted() {
    let gpu = gpu();
    for form in FORMS {
        let subject = Subject::new("ploc-gpu", &form, &gpu);
        for count in [1, 2, 3, 5] {
            let [from, to] = [90, 91].map(|seed| soup(&at_random(count, seed, |point| point), Some(&gpu)));
            let mut structure = subject.try_build(&from).unwrap();
            update(&subject, &mut *structure, Update::Refit, &to);
            let rays = rays_through(92, 1.0);
            let expected = subject.answer(&*subject.try_build(&to).unwrap(), &rays, Query::Closest).0;
            assert_eq!(subject.answer(&*structure, &rays, Query::Closest).0, expected, "{form:?} {count}");
        }
    }
}

/// Proves that a rebuild takes more and fewer triangles than before, in the memory that is there where it serves.
#[test]
fn rebuilds_take_other_triangles() {
    let gpu = gpu();
    let rays = rays_through(93, 1.0);
    for form in FORMS {
        let subject = Subject::new("ploc-gpu", &form, &gpu);
        let mut structure = subject.try_build(&soup(&rectangles(20), Some(&gpu))).unwrap();
        let mut most = 0;
        for (name, triangles) in hard_scenes() {
            let geometry = soup(&triangles, Some(&gpu));
            update(&subject, &mut *structure, Update::Rebuild, &geometry);
            let fresh = subject.try_build(&geometry).unwrap();
            let expected = subject.answer(&*fresh, &rays, Query::Closest).0;
            assert_eq!(subject.answer(&*structure, &rays, Query::Closest).0, expected, "{form:?} {name}");
            let held = structure.memory().structure_bytes();
            assert!(held >= most && held >= fresh.memory().structure_bytes(), "{form:?} {name}");
            most = held;
        }
    }
}

/// Proves that what the device cannot bind is an error that names the part, its bytes and what to turn down.
#[test]
fn too_large_is_said() {
    let mut small = Gpu::open(&AdapterChoice::default()).unwrap();
    small.limits.max_storage_buffer_binding_size = 60_000;
    let small = Arc::new(small);
    let (geometry, _) = room(&small);
    for form in FORMS {
        let subject = Subject::new("ploc-gpu", &form, &small);
        let Err(error) = subject.try_build(&geometry) else { panic!("{form:?} was built") };
        let TracerError::TooLarge { name, bytes, limit, hint } = &error else { panic!("{error}") };
        assert!(!name.is_empty() && *bytes > 60_000 && *limit == 60_000, "{error}");
        assert!(hint.contains("triangle"), "{error}");
    }
}
