//! How rays are answered: what may change work alone, and where the published rules lose hits.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{Hit, HitBuffer, Query, Ray, RayBuffer, Residency, Status, Structure, TraceJob, TraceTo};
use tracebench_tests::{Numbers, gpu, ray, rectangle, soup};

use super::tests::{answer, answer_by, built, hostile, parameters, viewpoint};

/// From tile to tile rays find what they find up and down the pyramid, over hostile triangles and rays: in fewer steps where
/// every tile has triangles, in more where hardly any has.
#[test]
fn the_pyramid_changes_steps_alone() {
    let gpu = gpu();
    let mut numbers = Numbers::new(7);
    let rays: Vec<Ray> = (0..2000).map(|_| ray(numbers.point() * 5.0, numbers.direction())).collect();
    let answered = |triangles: &[[[f32; 3]; 3]], settings: &[(&str, &str)]| {
        let structure = built(&gpu, &soup(triangles, Some(&gpu)), &[]);
        let shared = RayBuffer::new(Arc::new(rays.clone()), Query::Closest, Some(&gpu));
        let mut counted = HitBuffer::new(rays.len(), Residency::Device, Some(&gpu)).unwrap();
        counted.poison(Some(&gpu)).unwrap();
        let parameters = parameters(settings);
        let job = TraceJob { rays: &shared, trace_to: TraceTo::Hit, parameters: &parameters };
        let counters = structure.trace_counted(job, &mut counted).unwrap();
        let hits = counted.read(Some(&gpu)).unwrap();
        assert_eq!(answer_by(&gpu, &structure, &rays, settings), hits, "{settings:?}");
        (hits, counters.iter().find(|counter| counter.name == "pyramid_steps").unwrap().total)
    };
    let by_tiles = [("march", "tiles")];
    let ((pyramid, pyramid_steps), (tiles, tile_steps)) = (answered(&hostile(), &[]), answered(&hostile(), &by_tiles));
    assert!(pyramid.iter().filter(|hit| hit.is_hit()).count() > 500);
    // Where a ray passes a corner of tiles, rounding may lead the two by different sides of it.
    let differ = pyramid.iter().zip(&tiles).filter(|(one, other)| one != other).count();
    assert!(differ <= 2, "{differ}");
    assert!(tile_steps < pyramid_steps, "{tile_steps} {pyramid_steps}");
    let one = &hostile()[..1];
    let ((pyramid, pyramid_steps), (tiles, tile_steps)) = (answered(one, &[]), answered(one, &by_tiles));
    assert_eq!(pyramid, tiles);
    assert!(tile_steps > 2 * pyramid_steps, "{tile_steps} {pyramid_steps}");
}

/// Lists so long that a lane does not get through those of all of its rays where a driver counts its loops: every ray is answered
/// as if it were its lane's only one, with the first of thousands of equal triangles, or given up where its own list is too long.
#[test]
fn lanes_of_many_rays_answer_as_those_of_one() {
    let gpu = gpu();
    let eye = viewpoint().eye;
    let at = |x: f32, y: f32| (eye + Vec3::new(x, y, -3.0)).to_array();
    for (triangles, ray_count, all_are_answered) in [(10_000, 700, true), (70_000, 100, false)] {
        let geometry = soup(&vec![[at(0.0, 0.0), at(0.2, 0.0), at(0.0, 0.2)]; triangles], Some(&gpu));
        let structure = built(&gpu, &geometry, &[("buckets", "1")]);
        let mut numbers = Numbers::new(31);
        // Every fifth hits nothing.
        let rays: Vec<Ray> = (0..ray_count)
            .map(|index| match index % 5 {
                0 => ray(eye.as_dvec3(), DVec3::Z + numbers.point() * 0.1),
                _ => {
                    let [x, y] = [numbers.signed(), numbers.signed()].map(|along| 0.03 + 0.02 * along);
                    ray(eye.as_dvec3(), DVec3::new(x, y, -3.0))
                }
            })
            .collect();
        let one = answer(&gpu, &structure, &rays);
        for rays_per_lane in ["2", "32", "256"] {
            let many = answer_by(&gpu, &structure, &rays, &[("rays_per_lane", rays_per_lane)]);
            assert!(one == many, "{triangles}, {rays_per_lane}");
        }
        for (index, hit) in one.iter().enumerate() {
            let first = hit.is_hit() && hit.primitive == 0;
            let given_up = !all_are_answered && hit.status == Status::StepCap as u32;
            assert!(if index % 5 == 0 { !hit.is_hit() } else { first || given_up }, "{index} {hit:?}");
        }
    }
}

/// Where any hit will do a search ends at the first that is accepted: the same rays are occluded as by closest hits, with fewer
/// tests.
#[test]
fn any_hit_ends_at_the_first_one() {
    let gpu = gpu();
    let structure = built(&gpu, &soup(&hostile(), Some(&gpu)), &[]);
    let mut numbers = Numbers::new(9);
    let rays: Vec<Ray> = (0..2000).map(|_| ray(numbers.point() * 5.0, numbers.direction())).collect();
    let [closest, any] = [Query::Closest, Query::Any].map(|query| {
        let shared = RayBuffer::new(Arc::new(rays.clone()), query, Some(&gpu));
        let mut hits = HitBuffer::new(rays.len(), Residency::Device, Some(&gpu)).unwrap();
        hits.poison(Some(&gpu)).unwrap();
        let parameters = parameters(&[]);
        let job = TraceJob { rays: &shared, trace_to: TraceTo::Hit, parameters: &parameters };
        let counters = structure.trace_counted(job, &mut hits).unwrap();
        let tests = counters.into_iter().find(|counter| counter.name == "triangle_tests").unwrap();
        (hits.read(Some(&gpu)).unwrap(), tests)
    });
    let occluded = |hits: &[Hit]| hits.iter().map(Hit::is_hit).collect::<Vec<_>>();
    assert_eq!(occluded(&closest.0), occluded(&any.0));
    // Of rays that hit nothing every triangle is tested all the same.
    assert!(any.1.total < closest.1.total, "{:?} {:?}", any.1.total, closest.1.total);
    let farther = closest.0.iter().zip(&any.0).filter(|(closest, any)| any.is_hit() && any.t > closest.t).count();
    assert!(farther > 0, "no search ended before the nearest hit");
}

/// Minimal case: rays whose image runs along a border between tiles. Accepted by their tile, some hits on a wall that
/// cannot be missed fall between two tiles and are lost: pin-holes. Accepted by distance none is, and a little off the
/// border none is either way.
#[test]
fn hits_on_tile_borders_are_lost_by_the_published_rule() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let wall = rectangle([-9.0, -9.0, eye.z as f32 - 3.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    let geometry = soup(&wall, Some(&gpu));
    let structure = built(&gpu, &geometry, &[]);
    let centre = eye + DVec3::Z * f64::from(viewpoint().near);
    let mut numbers = Numbers::new(8);
    let mut rays_off = |off: f64| -> Vec<Ray> {
        let mut ray_off = || {
            // 24 tiles across 90 degrees.
            let tangent = ((numbers.signed() * 9.0).round() + off) / 12.0;
            let at = |depth: f64, along: f64| centre + DVec3::new(tangent, along, -1.0) * depth;
            let (from, to) = (at(0.6, numbers.signed() * 0.6), at(3.1, numbers.signed() * 0.6));
            ray(from, to - from)
        };
        (0..4000).map(|_| ray_off()).collect()
    };
    let lost = |rays: &[Ray], settings: &[(&str, &str)]| {
        answer_by(&gpu, &structure, rays, settings).iter().filter(|hit| !hit.is_hit()).count()
    };
    let (on, off) = (rays_off(0.0), rays_off(0.01));
    let by_distance = [("accept", "distance")];
    assert!(lost(&on, &[]) > 20, "{}", lost(&on, &[]));
    assert_eq!([lost(&on, &by_distance), lost(&off, &[]), lost(&off, &by_distance)], [0, 0, 0]);
}

/// Minimal case: an oblique triangle stands in every bucket of a tile, and is found in the first one at a hit that lies
/// behind a plate in a later one. The published rule stops there and answers the hit behind; searching every bucket finds
/// the plate.
#[test]
fn the_first_bucket_with_a_hit_hides_later_ones() {
    let gpu = gpu();
    let eye = viewpoint().eye;
    let at = |x: f32, y: f32, depth: f32| (eye + Vec3::new(x, y, -depth)).to_array();
    // Seen along its length between tangents 0.1 and 0.25, which lie in one tile of 8 pixels.
    let oblique = [at(0.4, -0.1, 4.0), at(2.0, -0.1, 8.0), at(1.2, 1.6, 6.0)];
    let plate = rectangle(at(0.9, 0.1, 5.0), [0.2, 0.0, 0.0], [0.0, 0.3, 0.0]);
    let geometry = soup(&[oblique, plate[0], plate[1]], Some(&gpu));
    let structure = built(&gpu, &geometry, &[("tile_size", "8")]);
    let rays = [ray(eye.as_dvec3(), DVec3::new(0.2, 0.04, -1.0))];
    let hit = |settings| answer_by(&gpu, &structure, &rays, settings)[0];
    let (published, all) = (hit(&[]), hit(&[("searched", "all")]));
    assert!(published.primitive == 0 && all.primitive > 0 && all.t < published.t - 0.5, "{published:?} {all:?}");
}

/// A triangle whose plane holds the eye, and with it the centres of the faces that look along it, fills tiles from depth 0
/// on: no ray that crosses it is lost, wherever the eye lies in it.
#[test]
fn a_triangle_round_the_eye_is_found() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let mut numbers = Numbers::new(11);
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let (u, v) = (axis.any_orthonormal_vector(), axis.cross(axis.any_orthonormal_vector()));
        let corners = [eye - u - v, eye + u - v, eye + v * 1.5].map(|corner| corner.as_vec3().to_array());
        let structure = built(&gpu, &soup(&[corners], Some(&gpu)), &[]);
        let through = |numbers: &mut Numbers| {
            let target = eye + u * numbers.signed() * 0.2 + v * numbers.signed() * 0.5;
            let origin = target + axis * (0.3 + numbers.signed().abs()) + numbers.point() * 0.2;
            ray(origin, target - origin)
        };
        let rays: Vec<Ray> = (0..2000).map(|_| through(&mut numbers)).collect();
        let hits = answer_by(&gpu, &structure, &rays, &[("accept", "distance")]);
        assert_eq!(hits.iter().filter(|hit| !hit.is_hit()).count(), 0, "{axis}");
    }
}
