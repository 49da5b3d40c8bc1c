//! Where one image is asked after another, where layers coincide, and which layer's surface a hit has.

use super::true_hits::true_hit;
use super::*;

/// A sphere of radius 1 whose normals point outwards.
fn sphere(rings: usize) -> Vec<[[f32; 3]; 3]> {
    let at = |ring: usize, step: usize| -> [f32; 3] {
        let (down, turn) = (ring as f64 / rings as f64, (step % (2 * rings)) as f64 / rings as f64);
        let [down, turn] = [down, turn].map(|share| share * std::f64::consts::PI);
        DVec3::new(down.sin() * turn.cos(), down.sin() * turn.sin(), down.cos()).as_vec3().into()
    };
    let facet = |(ring, step): (usize, usize)| {
        let [a, b, c, d] = [at(ring, step), at(ring + 1, step), at(ring + 1, step + 1), at(ring, step + 1)];
        [[a, b, c], [a, c, d]]
    };
    (0..rings).flat_map(|ring| (0..2 * rings).map(move |step| (ring, step))).flat_map(facet).collect()
}

/// Rays from outside that meet a sphere are not let through where voxels choose another image, or where the corner that a surface cuts
/// off a voxel holds no sample: none ends more than four texels behind where it meets it in f64.
#[test]
fn spheres_let_no_ray_through() {
    let gpu = gpu();
    let triangles = sphere(24);
    let geometry = soup(&triangles, Some(&gpu));
    let mut numbers = Numbers::new(53);
    let onto = |_| {
        let from = numbers.direction() * 3.0;
        let ray = ray(from, (numbers.direction() * numbers.signed().abs() * 0.9 - from).normalize());
        true_hit(&triangles, &ray).map(|t| (ray, t))
    };
    let (rays, truth): (Vec<Ray>, Vec<f64>) = (0..6000).filter_map(onto).unzip();
    let mut all = Vec::new();
    for grid in ["8", "16", "20", "32"] {
        let texel = 2.0 / 62.0;
        for depths in ["centre", "plane"] {
            let settings = [("abuffer", "64"), ("grid", grid), ("depths", depths)];
            let structure = built(&gpu, &geometry, &settings);
            let hits = closest(&gpu, &structure, &rays, &settings);
            let off = |(hit, t): (&Hit, &f64)| if hit.is_hit() { f64::from(hit.t) - t } else { f64::INFINITY };
            let late = hits.iter().zip(&truth).map(off).filter(|off| *off > 4.0 * texel).count();
            let early = hits.iter().zip(&truth).map(off).filter(|off| *off < -4.0 * texel).count();
            all.push((grid, depths, late, early));
        }
    }
    assert!(all.iter().all(|(.., late, early)| late + early == 0), "{} rays: {all:?}", rays.len());
}

/// By nesting each of two solids counts, though their lower walls lie in one plane: within one alone a ray starts inside, and rays from there
/// end at its wall.
#[test]
fn coplanar_walls_of_two_solids_are_two() {
    let gpu = gpu();
    let mut triangles = solid(DVec3::splat(-2.0), DVec3::splat(1.0));
    triangles.extend(solid(DVec3::new(-1.5, -1.5, -2.0), DVec3::new(1.5, 1.5, 2.0)));
    let geometry = soup(&triangles, Some(&gpu));
    let mut numbers = Numbers::new(59);
    let each = |_| ray(DVec3::new(numbers.signed(), numbers.signed(), 1.5), numbers.direction());
    let rays: Vec<Ray> = (0..200).map(each).collect();
    for crossing in ["change", "state"] {
        let settings = [("abuffer", "128"), ("inside", "nesting"), ("crossing", crossing), ("depths", "plane")];
        let structure = built(&gpu, &geometry, &settings);
        structure.validate_against(&geometry).unwrap();
        let (hits, counters) = counted(&gpu, &structure, &rays, Query::Closest, &settings);
        let right = |(hit, ray): &(&Hit, &Ray)| {
            let truth = true_hit(&triangles, ray).unwrap();
            hit.is_hit() && (f64::from(hit.t) - truth).abs() < 0.1
        };
        let right = hits.iter().zip(&rays).filter(right).count();
        assert!(
            (total(&counters, "starts_inside"), right) == (200, 200),
            "{crossing} {} {right}",
            total(&counters, "starts_inside")
        );
    }
}

/// A hit on a slanted wall, much thinner than its texels' steps, has the normal of the face that the ray goes through, from either side.
#[test]
fn thin_walls_have_the_normal_that_is_met() {
    let gpu = gpu();
    let turned = tracebench_api::glam::DQuat::from_rotation_y(0.6) * tracebench_api::glam::DQuat::from_rotation_x(0.4);
    let half = DVec3::new(2.0, 2.0, 0.02);
    let turn = |corner: [f32; 3]| (turned * Vec3::from(corner).as_dvec3()).as_vec3().into();
    let triangles: Vec<[[f32; 3]; 3]> = solid(-half, half).into_iter().map(|corners| corners.map(turn)).collect();
    let geometry = soup(&triangles, Some(&gpu));
    let mut numbers = Numbers::new(61);
    let each = |index: usize| {
        let at = DVec3::new(numbers.signed(), numbers.signed(), 0.0) * 1.5;
        let side = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let from = at + DVec3::new(numbers.signed(), numbers.signed(), side);
        (ray(turned * from, turned * (at - from)), turned * DVec3::Z * side)
    };
    let (rays, normals): (Vec<Ray>, Vec<DVec3>) = (0..600).map(each).unzip();
    let settings = [("abuffer", "64"), ("average", "lines")];
    let structure = built(&gpu, &geometry, &settings);
    let (hits, surfaces) = answer(&gpu, &structure, &rays, Query::Closest, &settings, TraceTo::Surface);
    let met = |hit: &&Hit| hit.is_hit() && (hit.t - 1.0).abs() < 0.3;
    let near = hits.iter().filter(met).count();
    let is_met = |((hit, surface), normal): &((&Hit, &Surface), &DVec3)| {
        met(hit) && (Vec3::from(surface.normal).as_dvec3() - **normal).length() < 1e-3
    };
    let right = hits.iter().zip(&surfaces).zip(&normals).filter(is_met).count();
    assert!(near > 300 && right + 3 >= near, "{near} {right}");
}

/// Rays that start on a slanted box leave it, or go through it to the wall opposite, as in f64: lifted along the normal nearly all do, along the
/// ray fewer, and with no part left out many do not.
#[test]
fn lifted_starts_leave_their_surface() {
    let gpu = gpu();
    let turned = tracebench_api::glam::DQuat::from_rotation_y(0.5) * tracebench_api::glam::DQuat::from_rotation_x(0.4);
    let half = DVec3::new(2.0, 1.5, 0.15);
    let turn = |corner: [f32; 3]| (turned * Vec3::from(corner).as_dvec3()).as_vec3().into();
    let triangles: Vec<[[f32; 3]; 3]> = solid(-half, half).into_iter().map(|corners| corners.map(turn)).collect();
    let geometry = soup(&triangles, Some(&gpu));
    let mut numbers = Numbers::new(67);
    let each = |_| {
        let at = DVec3::new(1.2 * numbers.signed(), 0.8 * numbers.signed(), 0.15);
        Ray { t_min: 1e-4, ..ray(turned * at, numbers.direction()) }
    };
    let rays: Vec<Ray> = (0..1000).map(each).collect();
    let truth: Vec<Option<f64>> = rays.iter().map(|ray| true_hit(&triangles, ray)).collect();
    let texel = 3.5 / 126.0;
    let wrong = |along: &str, bias: &str| {
        let settings = [("abuffer", "128"), ("average", "lines"), ("start_along", along), ("start_bias", bias)];
        let hits = closest(&gpu, &built(&gpu, &geometry, &settings), &rays, &settings);
        let is_wrong = |(hit, truth): &(&Hit, &Option<f64>)| match truth {
            Some(t) => !hit.is_hit() || (f64::from(hit.t) - t).abs() > 3.0 * texel,
            None => hit.is_hit(),
        };
        hits.iter().zip(&truth).filter(is_wrong).count()
    };
    let all = [("normal", "2"), ("normal", "1"), ("normal", "0.5"), ("ray", "2"), ("ray", "1"), ("ray", "0")]
        .map(|(along, bias)| wrong(along, bias));
    assert!(all[0] * 2 < all[3] && all[3] < all[5], "{all:?}");
}
