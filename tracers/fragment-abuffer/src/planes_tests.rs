//! Fragments that are planes: what is stored of them, and that rays slip through nowhere, by f64.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{Hit, Ray, Surface, TraceTo};
use tracebench_kit::Built;
use tracebench_tests::{Numbers, gpu, gpu_that_binds, ray, soup};

use super::structure::{FragmentAbuffer, FragmentStructure, check_order};
use super::tests::{SKIPS, STORAGES, answer, built, built_by, hostile, rays, rectangle, viewpoint};

const PLANES: [(&str, &str); 2] = [("fragments", "planes"), ("coverage", "conservative")];

/// As the preset `improved` has it.
const IMPROVED: [(&str, &str); 8] = [
    PLANES[0],
    PLANES[1],
    ("outline", "masked"),
    ("storage", "s-buffer"),
    ("decoupled", "off"),
    ("march", "hi-z"),
    ("start_bias", "0"),
    ("build", "compute"),
];

fn with<'a>(first: &[(&'a str, &'a str)], more: &[(&'a str, &'a str)]) -> Vec<(&'a str, &'a str)> {
    [first, more].concat()
}

/// What is stored of hostile triangles that are clipped to pixels is what f64 clips: their planes, the depths between which they lie there,
/// and which pixels have them, for every storage, drawn by the device's rasterizer or in compute, by either coverage, points or planes.
fn stored_is_what_f64_clips(all: &[Vec<(&str, &str)>]) {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = FragmentAbuffer::new(Arc::clone(&gpu)).unwrap();
    for settings in all {
        let statistics = built_by(&tracer, &gpu, &geometry, settings).check(&geometry);
        let statistics = statistics.unwrap_or_else(|error| panic!("{settings:?}: {error}"));
        let of = |name: &str| statistics.iter().find(|(each, _)| *each == name).unwrap().1;
        let least = if settings.contains(&("layers", "one")) { 1.0 } else { 5.0 };
        assert!(of("maximum_layers") >= least && of("fragments") > 1000.0, "{settings:?}: {statistics:?}");
    }
}

/// See [`stored_is_what_f64_clips`].
#[test]
fn what_is_stored_is_what_f64_clips() {
    stored_is_what_f64_clips(&[
        with(&PLANES, &[("storage", STORAGES[0])]),
        IMPROVED.to_vec(),
        with(&PLANES, &[("decoupled", "off"), ("buckets", "13"), ("bounds", "boxes"), ("build", "compute")]),
        vec![("fragments", "planes"), ("outline", "masked")],
        vec![("coverage", "conservative")],
    ]);
}

/// The same by every storage and combination.
#[test]
#[ignore = "wider set: every storage of planes against f64, a quarter of a minute"]
fn what_is_stored_in_every_way_is_what_f64_clips() {
    let mut all: Vec<Vec<(&str, &str)>> = STORAGES.map(|storage| with(&PLANES, &[("storage", storage)])).to_vec();
    all.extend([
        with(&IMPROVED, &[("build", "raster")]),
        with(&PLANES, &[("storage", "ll"), ("march", "hi-z"), ("bounds", "boxes")]),
        with(&PLANES, &[("storage", "dll"), ("layers", "one"), ("views", "six"), ("build", "compute")]),
        with(&PLANES, &[("outline", "masked"), ("build", "compute")]),
        vec![("fragments", "planes"), ("build", "compute"), ("storage", "s-buffer")],
        vec![("coverage", "conservative"), ("build", "compute"), ("storage", "s-buffer"), ("march", "hi-z")],
    ]);
    stored_is_what_f64_clips(&all);
}

/// A plane that is moved or turned, one that begins or ends elsewhere, and one whose data is another's, are noticed; so is another scene.
#[test]
fn a_spoilt_plane_is_noticed() {
    let gpu = gpu();
    // Few: every check clips them all anew.
    let few: Vec<_> = hostile().into_iter().step_by(7).collect();
    let geometry = soup(&few, Some(&gpu));
    let aside = few.iter().map(|corners| corners.map(|[x, y, z]| [x + 0.1, y, z])).collect::<Vec<_>>();
    let other = soup(&aside, Some(&gpu));
    let tracer = FragmentAbuffer::new(Arc::clone(&gpu)).unwrap();
    // Every node's words: depth, greatest depth, distance from the eye, outline, normal, material; depth, data's index and the same.
    for (decoupled, node_words, plane) in [("off", 8, 1), ("on", 8, 2)] {
        let structure = built_by(&tracer, &gpu, &geometry, &with(&IMPROVED, &[("decoupled", decoupled)]));
        assert_eq!(structure.layout.node_words(), node_words as u32);
        structure.check(&geometry).unwrap();
        assert!(structure.check(&other).is_err(), "another scene is not noticed");
        let part = &structure.parts.parts[0];
        let stored: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&part.ids, part.ids.size()).unwrap());
        for (what, word, factor) in [
            ("a beginning", 0, 0.9),
            ("an end", plane, 1.1),
            ("a distance", plane + 1, 1.001),
            ("an outline", plane + 2, 0.0),
            ("a normal", plane + 5, 1.001),
        ] {
            let mut words = stored.clone();
            for node in words.chunks_exact_mut(node_words) {
                node[word] = (f32::from_bits(node[word]) * factor).to_bits();
            }
            gpu.queue.write_buffer(&part.ids, 0, bytemuck::cast_slice(&words));
            assert!(structure.check(&geometry).is_err(), "{what} is not noticed, decoupled {decoupled}");
        }
        gpu.queue.write_buffer(&part.ids, 0, bytemuck::cast_slice(&stored));
        structure.check(&geometry).unwrap();
    }
}

/// All storages, with data in nodes or beside them, with or without each kind of skipping, drawn by the rasterizer or in compute, over one
/// buffer of a kind or one a view, or textures, with a ray a lane or several, by every pixel or by the pyramid, give the same bits.
fn variants_give_the_same_bits(whole: bool) {
    let (gpu, small) = (gpu(), gpu_that_binds(1_600_000));
    let rays = rays(1500);
    let geometries = [&gpu, &small].map(|gpu| soup(&hostile(), Some(gpu)));
    let tracers = [&gpu, &small].map(|gpu| FragmentAbuffer::new(Arc::clone(gpu)).unwrap());
    let mut expected: Option<(Vec<Hit>, Vec<Surface>)> = None;
    for (number, storage) in STORAGES.into_iter().enumerate() {
        let variants = [
            (0, "on", "geometry", "buffer", "1", "pixels", "raster"),
            (0, "off", "boxes", "texture", "7", "hi-z", "compute"),
            (1, "off", "geometry", "buffer", "3", "hi-z", "compute"),
        ];
        let some = variants.into_iter().enumerate().filter(|(variant, _)| whole || *variant == number % 3);
        for (_, (device, decoupled, bounds, memory_access, rays_per_lane, march, build)) in some {
            let gpu = [&gpu, &small][device];
            let shape = with(
                &PLANES,
                &[
                    ("storage", storage),
                    ("decoupled", decoupled),
                    ("bounds", bounds),
                    ("outline", "masked"),
                    ("march", march),
                    ("memory_access", memory_access),
                    ("rays_per_lane", rays_per_lane),
                    ("build", build),
                    ("start_bias", "0"),
                ],
            );
            let structure = built_by(&tracers[device], gpu, &geometries[device], &shape);
            assert_eq!(structure.parts.is_by_view(), device == 1, "{shape:?}");
            let skipping = if decoupled == "on" { ["on on on", "off off off"] } else { ["on off on", "off on off"] };
            for switches in skipping {
                let skips: Vec<(&str, &str)> = SKIPS.into_iter().zip(switches.split(' ')).collect();
                let settings = with(&shape, &skips);
                let found = answer(gpu, &structure, &rays, &settings, TraceTo::Surface);
                let to_hits = answer(gpu, &structure, &rays, &settings, TraceTo::Hit).0;
                assert_eq!(to_hits, found.0, "{settings:?}");
                let expected = expected.get_or_insert_with(|| found.clone());
                let off = found.0.iter().zip(&expected.0).filter(|(a, b)| a != b).count();
                assert_eq!(off, 0, "{settings:?}");
                assert!(found.1 == expected.1, "{settings:?}");
            }
        }
    }
    let hits = expected.unwrap().0.iter().filter(|hit| hit.is_hit()).count();
    assert!(hits > 1000, "{hits}");
}

/// See [`variants_give_the_same_bits`]: every storage by one of the variants.
#[test]
fn every_storage_gives_the_same_bits() {
    variants_give_the_same_bits(false);
}

/// See [`variants_give_the_same_bits`]: every storage by all of them.
#[test]
#[ignore = "wider set: every storage of planes by every variant, a quarter of a minute"]
fn every_variant_gives_the_same_bits() {
    variants_give_the_same_bits(true);
}

/// The parameter at which a ray first meets any of the triangles, in f64.
fn first_met(triangles: &[[[f32; 3]; 3]], ray: &Ray) -> Option<f64> {
    let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
    let met = triangles.iter().filter_map(|triangle| {
        let [a, b, c] = triangle.map(|corner| Vec3::from(corner).as_dvec3() - origin);
        let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|side| side.dot(direction));
        let inside = sides.iter().all(|side| *side >= -1e-12) || sides.iter().all(|side| *side <= 1e-12);
        let normal = (b - a).cross(c - a);
        let t = normal.dot(a) / normal.dot(direction);
        (inside && t >= f64::from(ray.t_min) && t <= f64::from(ray.t_max)).then_some(t)
    });
    met.min_by(f64::total_cmp)
}

/// A closed surface round the eye, of triangles of many slants whose corners are shared.
fn shell() -> Vec<[[f32; 3]; 3]> {
    let eye = viewpoint().eye.as_dvec3();
    let (rows, columns) = (20, 40);
    let mut numbers = Numbers::new(77);
    let reach: Vec<f64> = (0..=rows * columns + 1).map(|_| 2.0 + 0.5 * numbers.signed()).collect();
    let corner = |row: i32, column: i32| -> [f32; 3] {
        let (down, round) = (
            std::f64::consts::PI * f64::from(row) / f64::from(rows),
            2.0 * std::f64::consts::PI * f64::from(column % columns) / f64::from(columns),
        );
        let number = if row == 0 || row == rows {
            rows * columns + i32::from(row == 0)
        } else {
            row * columns + column % columns
        };
        let at = DVec3::new(down.sin() * round.cos(), down.cos(), down.sin() * round.sin());
        (eye + at * reach[number as usize]).as_vec3().into()
    };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [corner(row, column), corner(row, column + 1)];
            let [c, d] = [corner(row + 1, column), corner(row + 1, column + 1)];
            if row > 0 {
                triangles.push([a, b, d]);
            }
            if row + 1 < rows {
                triangles.push([a, d, c]);
            }
        }
    }
    triangles
}

/// The share of rays whose hits lie where f64 has them; none may be lost.
fn share_right(
    structure: &Built<FragmentStructure>,
    triangles: &[[[f32; 3]; 3]],
    rays: &[Ray],
    settings: &[(&str, &str)],
) -> f64 {
    let (hits, surfaces) = answer(&structure.pipelines.gpu, structure, rays, settings, TraceTo::Surface);
    let mut right = 0;
    for (index, ((hit, surface), ray)) in hits.iter().zip(&surfaces).zip(rays).enumerate() {
        let truth = first_met(triangles, ray).unwrap();
        assert!(hit.is_hit(), "ray {index} {ray:?} slips through at {truth}: {settings:?}");
        let at = Vec3::from(ray.origin) + Vec3::from(ray.direction) * hit.t;
        assert!((Vec3::from(surface.position) - at).length() < 1e-4, "{index}");
        right += usize::from((f64::from(hit.t) - truth).abs() < 1e-4 * (1.0 + truth));
    }
    right as f64 / rays.len() as f64
}

/// Out of a closed surface of slanted triangles no ray slips, from wherever in it and whichever way it starts, along axes and through the
/// eye too; and most hits are the triangles' own, more of them where planes keep their outlines. Negative control: of points some are lost.
#[test]
fn no_ray_leaves_a_closed_surface() {
    let gpu = gpu();
    let triangles = shell();
    let geometry = soup(&triangles, Some(&gpu));
    let eye = viewpoint().eye.as_dvec3();
    let mut numbers = Numbers::new(5);
    let rays: Vec<Ray> = (0..6000)
        .map(|index| match index % 6 {
            0 => ray(eye, numbers.direction()),
            1 => ray(
                eye + numbers.point() * 0.7,
                [DVec3::X, DVec3::Y, DVec3::Z][index / 6 % 3] * numbers.signed().signum(),
            ),
            2 => {
                let from = eye + numbers.direction() * 0.7;
                ray(from, eye - from)
            }
            _ => ray(eye + numbers.point() * 0.7, numbers.direction()),
        })
        .collect();
    let structure = built(&gpu, &geometry, &IMPROVED);
    for march in ["hi-z", "pixels"] {
        let settings = with(&IMPROVED, &[("march", march)]);
        let share = share_right(&structure, &triangles, &rays, &settings);
        assert!(share > 0.85, "{march}: {share}");
    }
    let points = with(&IMPROVED, &[("fragments", "points"), ("coverage", "sample")]);
    let (hits, _) = answer(&gpu, &built(&gpu, &geometry, &points), &rays, &points, TraceTo::Hit);
    assert!(hits.iter().any(|hit| !hit.is_hit()), "nothing slips past points");
    let filled = with(&IMPROVED, &[("outline", "filled")]);
    let [kept, filled] = [&IMPROVED[..], &filled[..]].map(|settings| {
        let structure = built(&gpu, &geometry, settings);
        share_right(&structure, &triangles, &rays, settings)
    });
    assert!(filled < kept, "{filled} {kept}");
}

/// Rays along the borders between pixels, and through pixels' corners, meet a slanted wall where f64 has it: of two pixels that share a
/// border at least one answers.
#[test]
fn rays_along_cell_borders_are_not_lost() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let wall = rectangle(eye + DVec3::new(-9.0, -9.0, -2.0), DVec3::new(18.0, 0.0, -3.0), DVec3::new(0.0, 18.0, -1.0));
    let geometry = soup(&wall, Some(&gpu));
    for views in ["frame", "seven"] {
        let settings = with(&IMPROVED, &[("views", views)]);
        let structure = built(&gpu, &geometry, &settings);
        let mut numbers = Numbers::new(6);
        let view = structure.layout.views.iter().find(|view| view.forward.z < -0.9).unwrap();
        let size = view.size.map(f64::from);
        let mut rays = Vec::new();
        for index in 0..3000 {
            let across = |numbers: &mut Numbers| (8.0 + numbers.unit() * (size[0] - 16.0)).floor();
            let down = |numbers: &mut Numbers| (8.0 + numbers.unit() * (size[1] - 16.0)).floor();
            let (column, row) = (across(&mut numbers), down(&mut numbers));
            // In the plane through the eye and a border: from one place on it to another.
            let [from, to] = match index % 3 {
                0 => [(column, down(&mut numbers) + 0.3), (column, row)],
                1 => [(across(&mut numbers) + 0.7, row), (column, row)],
                _ => [(column, row), (column, row)],
            };
            let [from, to] = [from, to].map(|(x, y)| view.direction_through(x, y));
            let near = view.eye + from * (0.3 + 0.5 * numbers.unit());
            rays.push(if index % 3 == 2 {
                ray(view.eye + from * 0.2, to)
            } else {
                ray(near, view.eye + to * 60.0 - near)
            });
        }
        let share = share_right(&structure, &wall, &rays, &settings);
        assert!(share > 0.999, "{views}: {share}");
    }
}

/// Equal triangles of several materials give the same surface in every build, however their fragments came: that of the least data.
#[test]
fn equal_triangles_give_one_surface() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let wall = rectangle(eye + DVec3::new(-3.0, -3.0, -2.0), DVec3::new(6.0, 0.0, -1.0), DVec3::new(0.0, 6.0, 0.0));
    let copies: Vec<[[f32; 3]; 3]> = (0..40).flat_map(|_| wall).collect();
    let corners = copies.as_flattened().to_vec();
    let indices = (0..copies.len() as u32).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect();
    let materials = (0..copies.len() as u32).map(|index| 7 + (index / 2 * 13) % 40).collect();
    let geometry = tracebench_api::Geometry::with_materials(corners, indices, materials, Some(&gpu)).unwrap();
    let mut numbers = Numbers::new(9);
    let rays: Vec<Ray> =
        (0..500).map(|_| ray(eye, DVec3::new(numbers.signed() * 0.5, numbers.signed() * 0.4, -1.0))).collect();
    for storage in ["s-buffer", "dllb"] {
        for decoupled in ["on", "off"] {
            let settings = with(&IMPROVED, &[("storage", storage), ("decoupled", decoupled)]);
            let structure = built(&gpu, &geometry, &settings);
            let (hits, surfaces) = answer(&gpu, &structure, &rays, &settings, TraceTo::Surface);
            assert_eq!(answer(&gpu, &structure, &rays, &settings, TraceTo::Hit).0, hits);
            assert!(hits.iter().all(Hit::is_hit), "{settings:?}");
            assert!(surfaces.iter().all(|surface| surface.material == 7), "{settings:?}");
        }
    }
}

/// Pieces of thousands of fragments, at equal depths or at depths in no order, are ordered as short ones are: of planes and of points, in
/// nodes with their data or without. An invocation alone would not get through them within a driver's limit of rounds.
#[test]
fn long_pieces_are_ordered() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let at = |depth: f64| rectangle(eye + DVec3::new(-0.1, -0.1, -depth), DVec3::X * 0.2, DVec3::Y * 0.2)[0];
    let mut numbers = Numbers::new(11);
    let shuffled: Vec<[[f32; 3]; 3]> = (0..3000).map(|_| at(2.0 + 0.5 * numbers.unit())).collect();
    let equal = vec![at(2.0); 2000];
    let frame = ("views", "frame");
    for crowd in [shuffled, equal] {
        let geometry = soup(&crowd, Some(&gpu));
        for changes in [[frame, ("decoupled", "on")], [frame, ("decoupled", "off")], [frame, ("fragments", "points")]] {
            let settings = with(&IMPROVED, &changes);
            let structure = built(&gpu, &geometry, &settings);
            let taken = structure.parts.taken(&gpu).unwrap();
            assert!(taken[0].fragments > 2 * crowd.len() as u32, "{settings:?}: {taken:?}");
            check_order(&taken).unwrap();
            // That depths stand in order, too.
            structure.check(&geometry).unwrap_or_else(|error| panic!("{settings:?}: {error}"));
        }
    }
}
