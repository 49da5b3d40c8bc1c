//! How rays are answered by packed structures: every form alike, and as where all triangles are tried.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{Counter, Gpu, Hit, Query, Ray, Status, TraceTo};
use tracebench_kit::Built;
use tracebench_tests::{Numbers, answers, counted, gpu, ray, soup, total};

use super::PackedStructure;
use super::tests::{FORMS, built, built_at, moved, triangles};
use crate::tests::{parameters, viewpoint};

/// Hits and counters, by variants that must agree.
fn answer(
    gpu: &Arc<Gpu>,
    structure: &Built<PackedStructure>,
    rays: &[Ray],
    query: Query,
    settings: &[(&str, &str)],
) -> (Vec<Hit>, Vec<Counter>) {
    let parameters = parameters(settings);
    let (plain, _) = answers(gpu, structure, rays, query, &parameters, TraceTo::Hit);
    let (hits, _, counters) = counted(gpu, structure, rays, query, &parameters, TraceTo::Hit);
    assert_eq!(plain, hits, "{settings:?}: counting changes hits");
    (plain, counters)
}

/// With the preset of the exact forms.
fn exact<'a>(settings: &[(&'a str, &'a str)]) -> Vec<(&'a str, &'a str)> {
    [&[("accept", "distance"), ("searched", "all"), ("centre_rays", "split")][..], settings].concat()
}

/// Triangles of a size round places.
fn strewn(numbers: &mut Numbers, count: usize, size: f64, at: impl Fn(&mut Numbers) -> DVec3) -> Vec<[[f32; 3]; 3]> {
    let triangle = |_| {
        let at = at(numbers);
        [0; 3].map(|_| (at + numbers.point() * size).as_vec3().to_array())
    };
    (0..count).map(triangle).collect()
}

/// Rays that are hard for images: from the eye and round it at every distance, through it, along axes, faces' diagonals, the planes
/// between faces and the borders of tiles, from within triangles' planes, from far away, that end early and begin late.
pub(super) fn hostile_rays(count: usize, scale: f64, eye: DVec3) -> Vec<Ray> {
    let mut numbers = Numbers::new(97);
    let mut of = |index: usize| -> Ray {
        let (from, aim) = (numbers.point(), numbers.direction());
        let near = 10.0_f64.powf(-8.0 * numbers.unit());
        let whole = |at: f64| (at * 32.0).round() / 32.0;
        let at = |point: DVec3, direction: DVec3| ray(eye + point * scale, direction);
        match index % 16 {
            0 => at(DVec3::ZERO, aim),
            1 => at(from * near, aim),
            2 => at(from * 5.0, -from + aim * near),
            3 => at(from * 5.0, -from),
            4 => at(from * 5.0, [DVec3::X, DVec3::NEG_Y, DVec3::Z][index / 16 % 3]),
            5 => at(DVec3::new(from.x, from.x, from.z) * 4.0, DVec3::new(aim.x, aim.x, aim.z)),
            6 => at(DVec3::new(from.x, -from.x, from.x) * 4.0, DVec3::new(1.0, -1.0, 1.0) * aim.x.signum()),
            // Along borders between tiles of 64.
            7 => {
                let line = |depth: f64, along: f64| DVec3::new(whole(from.x), along, -1.0) * depth;
                let (begin, end) = (line(0.3, from.y * 0.5), line(4.0, from.z * 0.5));
                at(begin, end - begin)
            }
            8 => {
                let line = |depth: f64| DVec3::new(whole(from.x), whole(from.y), 1.0) * depth;
                at(line(0.1 + numbers.unit()), line(1.0))
            }
            9 => at(from * 1e3, -from + aim * 1e-3),
            10 => at(from * 1e5, -from + aim * 1e-5),
            11 => Ray { t_max: (scale * numbers.unit() * 3.0) as f32, ..at(from * 3.0, aim) },
            12 => Ray { t_min: (scale * numbers.unit() * 3.0) as f32, ..at(from * 3.0, aim) },
            13 => at(from * near, -from),
            14 => at(DVec3::new(from.x, from.y, 0.0) * 3.0, DVec3::new(aim.x, aim.y, 0.0)),
            _ => at(from * 5.0, aim),
        }
    };
    (0..count).map(&mut of).collect()
}

/// Which answers differ, of hits in t and triangle.
fn differing(one: &[Hit], other: &[Hit]) -> Vec<usize> {
    (0..one.len()).filter(|index| one[*index] != other[*index]).collect()
}

/// Whether a hit lies where its triangle is: in a plane that holds the ray rounding alone decides what the test of triangles finds, which
/// may be nowhere near it.
fn lies_on_its_triangle(ray: &Ray, hit: &Hit, triangles: &[[[f32; 3]; 3]]) -> bool {
    if !hit.is_hit() {
        return true;
    }
    let [a, b, c] = triangles[hit.primitive as usize].map(|corner| Vec3::from(corner).as_dvec3());
    let (u, v) = (f64::from(hit.u), f64::from(hit.v));
    let on_triangle = a + (b - a) * u + (c - a) * v;
    let on_ray = Vec3::from(ray.origin).as_dvec3() + Vec3::from(ray.direction).as_dvec3() * f64::from(hit.t);
    (on_triangle - on_ray).length() <= 1e-2 * (on_triangle.length() + 1e-2 * Vec3::from(ray.origin).as_dvec3().length())
}

/// Proves that every form finds what is found where a face is one tile and all of its triangles are tried, bit for bit, over hostile
/// triangles and rays; and, as a negative control, that a triangle less is noticed.
#[test]
fn every_form_finds_what_trying_all_finds() {
    let gpu = gpu();
    let geometry = soup(&triangles(), Some(&gpu));
    let rays = hostile_rays(4800, 1.0, viewpoint().eye.as_dvec3());
    let whole = exact(&[("lists", "packed"), ("face_tiles", "1"), ("slices", "1")]);
    let (expected, _) = answer(&gpu, &built(&gpu, &geometry, &whole), &rays, Query::Closest, &whole);
    assert!(expected.iter().filter(|hit| hit.is_hit()).count() > 1500);
    let corners = triangles();
    let unsound = (0..rays.len()).filter(|index| !lies_on_its_triangle(&rays[*index], &expected[*index], &corners));
    assert!(unsound.count() < 10);
    for form in FORMS {
        let structure = built(&gpu, &geometry, form);
        for more in [&[][..], &[("order", "stored"), ("march", "tiles")], &[("rays_per_lane", "16")]] {
            let settings = exact(&[form, more].concat());
            let (found, _) = answer(&gpu, &structure, &rays, Query::Closest, &settings);
            let mut differ = differing(&expected, &found);
            differ.retain(|index| lies_on_its_triangle(&rays[*index], &expected[*index], &corners));
            let first = differ.first().map(|index| (rays[*index], expected[*index], found[*index]));
            let capped = differ.iter().filter(|index| found[**index].status == Status::StepCap as u32).count();
            assert!(differ.is_empty(), "{settings:?}: {} differ, {capped} given up, {first:?}", differ.len());
            let (any, _) = answer(&gpu, &structure, &rays, Query::Any, &settings);
            let occluded = |hits: &[Hit]| hits.iter().map(Hit::is_hit).collect::<Vec<_>>();
            assert_eq!(occluded(&any), occluded(&found), "{settings:?}");
        }
    }
    let hit = expected.iter().find(|hit| hit.is_hit()).unwrap().primitive as usize;
    let mut fewer = triangles();
    fewer[hit] = [fewer[hit][0]; 3];
    let without = built(&gpu, &soup(&fewer, Some(&gpu)), &whole);
    assert!(!differing(&expected, &answer(&gpu, &without, &rays, Query::Closest, &whole).0).is_empty());
}

/// Proves the same of 65,536 hostile rays.
#[test]
#[ignore = "wider set: 65,536 hostile rays, of which each tries every triangle"]
fn no_hostile_ray_loses_a_hit() {
    let gpu = gpu();
    let geometry = soup(&triangles(), Some(&gpu));
    let rays = hostile_rays(1 << 16, 1.0, viewpoint().eye.as_dvec3());
    let whole = exact(&[("lists", "packed"), ("face_tiles", "1"), ("slices", "1")]);
    let (expected, _) = answer(&gpu, &built(&gpu, &geometry, &whole), &rays, Query::Closest, &whole);
    let corners = triangles();
    for form in FORMS {
        let settings = exact(form);
        let (found, _) = answer(&gpu, &built(&gpu, &geometry, form), &rays, Query::Closest, &settings);
        let mut differ = differing(&expected, &found);
        differ.retain(|index| lies_on_its_triangle(&rays[*index], &expected[*index], &corners));
        let first = differ.first().map(|index| (rays[*index], expected[*index], found[*index]));
        assert!(differ.is_empty(), "{settings:?}: {} differ, {first:?}", differ.len());
    }
}

/// Proves the same of worlds a million times larger and smaller, and far from the origin.
#[test]
fn scale_and_place_lose_no_hit() {
    let gpu = gpu();
    for (scale, by) in [(1e6, 0.0), (1e-6, 0.0), (1.0, 3e4)] {
        let (triangles, view) = moved(scale, by);
        let geometry = soup(&triangles, Some(&gpu));
        let rays = hostile_rays(1600, f64::from(scale), view.eye.as_dvec3());
        let whole = exact(&[("lists", "packed"), ("face_tiles", "1"), ("slices", "1")]);
        let answered = |settings: &[(&str, &str)]| {
            let structure = built_at(&gpu, &geometry, &view, settings).unwrap();
            answer(&gpu, &structure, &rays, Query::Closest, settings).0
        };
        let expected = answered(&whole);
        assert!(expected.iter().filter(|hit| hit.is_hit()).count() > 300, "{scale} {by}");
        for form in [FORMS[0], FORMS[3]] {
            let found = answered(&exact(form));
            let mut differ = differing(&expected, &found);
            differ.retain(|index| lies_on_its_triangle(&rays[*index], &expected[*index], &triangles));
            let first = differ.first().map(|index| (rays[*index], expected[*index]));
            let capped = differ.iter().filter(|index| found[**index].status == Status::StepCap as u32).count();
            assert!(differ.is_empty(), "{scale} {by} {form:?}: {} differ, {capped} given up, {first:?}", differ.len());
        }
    }
}

/// Minimal case: a wall behind the eye of rays that pass the eye by less than what their images are good for. Split, none is lost; walked
/// like others, some are.
#[test]
fn rays_past_the_eye_need_their_own_search() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let mut numbers = Numbers::new(5);
    // Small triangles close round the eye, which images far from it do not tell.
    let close = strewn(&mut numbers, 200, 0.0002, |numbers| eye + numbers.direction() * 0.004);
    let geometry = soup(&close, Some(&gpu));
    let rays: Vec<Ray> = (0..4000)
        .map(|index| {
            let from = numbers.direction() * 3e3;
            let through = DVec3::from(close[index % 200][index % 3].map(f64::from)) - eye;
            ray(eye + from, through - from)
        })
        .collect();
    let whole = exact(&[("lists", "packed"), ("face_tiles", "1"), ("slices", "1")]);
    let lost = |settings: &[(&str, &str)]| {
        let (expected, _) = answer(&gpu, &built(&gpu, &geometry, &whole), &rays, Query::Closest, &whole);
        let (found, _) = answer(&gpu, &built(&gpu, &geometry, settings), &rays, Query::Closest, settings);
        differing(&expected, &found).len()
    };
    assert_eq!(lost(&exact(&[("lists", "trees")])), 0);
    assert!(lost(&[("lists", "trees")]) > 0, "nothing shows that rays need to be split");
}

/// The nearest hit in f64: t and triangle.
fn nearest_by_f64(ray: &Ray, triangles: &[[[f32; 3]; 3]]) -> Option<(f64, u32)> {
    let [origin, direction] = [ray.origin, ray.direction].map(|vector| Vec3::from(vector).as_dvec3());
    let within = f64::from(ray.t_min)..f64::from(ray.t_max);
    let hits = triangles.iter().zip(0..).filter_map(|(corners, triangle)| {
        let [a, b, c] = corners.map(|corner| Vec3::from(corner).as_dvec3());
        let (first, second, to_ray) = (b - a, c - a, origin - a);
        let (across, turned) = (direction.cross(second), to_ray.cross(first));
        let weights = [to_ray.dot(across), direction.dot(turned)].map(|weight| weight / first.dot(across));
        let t = second.dot(turned) / first.dot(across);
        (weights[0].min(weights[1]) >= 0.0 && weights[0] + weights[1] <= 1.0 && within.contains(&t))
            .then_some((t, triangle))
    });
    hits.min_by(|one, other| one.0.total_cmp(&other.0))
}

/// Proves that rays from far away are answered as f64 does and try few triangles, also along axes, with -0.0 and denormals, and where
/// they begin and end; and, as a negative control, that walked like others they are not.
#[test]
fn far_rays_are_answered_as_by_f64() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let mut numbers = Numbers::new(31);
    let strewn = strewn(&mut numbers, 400, 1.0, |numbers| eye + numbers.point() * 6.0);
    let geometry = soup(&strewn, Some(&gpu));
    for away in [10.0, 100.0, 1e4, 1e6] {
        let mut of = |index: usize| {
            let axis = [DVec3::new(1.0, -0.0, 1e-40), DVec3::new(1e-40, -1.0, -0.0), DVec3::NEG_Z][index / 4 % 3];
            let along = if index % 4 == 1 { axis } else { numbers.direction() };
            let far = ray(eye + numbers.point() * 6.0 - along * away * geometry.diagonal(), along);
            let t = nearest_by_f64(&far, &strewn).map_or(1.0, |hit| hit.0);
            match index % 4 {
                2 => Ray { t_min: (t + 0.01) as f32, ..far },
                3 => Ray { t_max: (t + numbers.signed()) as f32, ..far },
                _ => far,
            }
        };
        let rays: Vec<Ray> = (0..1200).map(&mut of).collect();
        let truth: Vec<_> = rays.iter().map(|ray| nearest_by_f64(ray, &strewn)).collect();
        assert!(truth.iter().flatten().count() > 300, "{away}");
        let wrong = |settings: &[(&str, &str)]| {
            let (found, counters) = answer(&gpu, &built(&gpu, &geometry, settings), &rays, Query::Closest, settings);
            let is_right = |hit: &Hit, truth: &Option<(f64, u32)>| match truth {
                Some((t, primitive)) => hit.primitive == *primitive && (f64::from(hit.t) - t).abs() <= 2e-7 * t,
                None => hit.status == Status::Miss as u32,
            };
            let right = found.iter().zip(&truth).filter(|(hit, truth)| is_right(hit, truth)).count();
            (rays.len() - right, total(&counters, "triangle_tests"))
        };
        for form in [FORMS[0], FORMS[3], FORMS[5]] {
            let (wrong, tests) = wrong(&exact(form));
            assert_eq!(wrong, 0, "{away} {form:?}");
            assert!(tests < 100 * rays.len() as u64, "{away} {form:?}: {tests}");
        }
        assert!(away < 1e4 || wrong(FORMS[0]).0 > 0, "nothing shows that rays from {away} away begin anew");
    }
}

/// Proves that trees and their order save tests, and pyramids steps, over triangles strewn about: counted, with the same hits.
#[test]
fn what_each_part_saves_is_counted() {
    let gpu = gpu();
    let mut numbers = Numbers::new(12);
    let eye = viewpoint().eye.as_dvec3();
    let strewn = strewn(&mut numbers, 3000, 0.1, |numbers| eye + numbers.point() * 6.0);
    let geometry = soup(&strewn, Some(&gpu));
    let rays: Vec<Ray> = (0..1000).map(|_| ray(eye + numbers.point() * 5.0, numbers.direction())).collect();
    let count = |form: &[(&str, &str)], wanted: &str| {
        let settings = exact(form);
        let (hits, counters) = answer(&gpu, &built(&gpu, &geometry, &settings), &rays, Query::Closest, &settings);
        (hits, total(&counters, wanted))
    };
    let (packed, of_packed) = count(&[("lists", "packed"), ("face_tiles", "8")], "triangle_tests");
    let (slices, of_slices) = count(&[("lists", "sliced"), ("face_tiles", "8")], "triangle_tests");
    let (trees, of_trees) = count(&[("lists", "trees"), ("face_tiles", "8")], "triangle_tests");
    let (stored, of_stored) = count(&[("lists", "trees"), ("face_tiles", "8"), ("order", "stored")], "triangle_tests");
    assert!(packed == slices && slices == trees && trees == stored);
    assert!(
        of_trees <= of_stored && of_stored < of_slices && of_slices < of_packed,
        "{of_trees} {of_stored} {of_slices} {of_packed}"
    );
    let (_, by_pyramid) = count(&[("lists", "trees")], "pyramid_steps");
    let (_, by_tiles) = count(&[("lists", "trees"), ("march", "tiles")], "pyramid_steps");
    assert!(by_pyramid < by_tiles, "{by_pyramid} {by_tiles}");
    let (_, one_slice) = count(&[("lists", "trees"), ("slices", "1")], "nodes_visited");
    let (_, all_slices) = count(&[("lists", "trees")], "nodes_visited");
    assert!(all_slices < one_slice, "{all_slices} {one_slice}");
}

/// Proves that a search that runs out of steps says so and gives no hit, and that what is read from textures is what buffers hold.
#[test]
fn steps_run_out_and_textures_hold_the_same() {
    let gpu = gpu();
    let geometry = soup(&triangles(), Some(&gpu));
    let rays = hostile_rays(800, 1.0, viewpoint().eye.as_dvec3());
    for form in [FORMS[0], FORMS[3], FORMS[5]] {
        let settings = exact(form);
        let structure = built(&gpu, &geometry, &settings);
        let (expected, _) = answer(&gpu, &structure, &rays, Query::Closest, &settings);
        let few = exact(&[form, &[("max_steps", "2")]].concat());
        let (capped, _) = answer(&gpu, &structure, &rays, Query::Closest, &few);
        let given_up = capped.iter().filter(|hit| hit.status == Status::StepCap as u32).count();
        assert!(given_up > 50 && given_up < rays.len(), "{form:?}: {given_up}");
        let cut_off = expected.iter().filter(|hit| hit.status == Status::StepCap as u32).count();
        assert_eq!(cut_off, 0, "{form:?}");
        let textures = exact(&[form, &[("memory_access", "texture")]].concat());
        let (found, _) = answer(&gpu, &built(&gpu, &geometry, &textures), &rays, Query::Closest, &textures);
        assert_eq!(found, expected, "{form:?}");
    }
}

/// Minimal case: plates in view. A primary ray is in one face and one tile, and meets the boxes of one node.
#[test]
fn a_primary_ray_takes_one_step() {
    let gpu = gpu();
    let eye = viewpoint().eye;
    let plate = |depth: f32| {
        let at = |x: f32, y: f32| (eye + Vec3::new(x, y, -depth)).to_array();
        [at(-9.0, -9.0), at(9.0, -9.0), at(0.0, 18.0)]
    };
    let geometry = soup(&[plate(2.0), plate(3.0), plate(4.0)], Some(&gpu));
    let settings = exact(&[("lists", "trees")]);
    let rays: Vec<Ray> =
        (0..32).map(|index| ray(eye.as_dvec3(), DVec3::new(f64::from(index) * 0.01 + 0.003, 0.013, -1.0))).collect();
    let (hits, counters) = answer(&gpu, &built(&gpu, &geometry, &settings), &rays, Query::Closest, &settings);
    assert!(hits.iter().all(|hit| hit.is_hit() && hit.primitive == 0), "{hits:?}");
    let of = |wanted: &str| total(&counters, wanted);
    assert_eq!((of("pyramid_steps"), of("nodes_visited"), of("triangle_tests"), of("views_entered")), (32, 32, 96, 32));
}
