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
