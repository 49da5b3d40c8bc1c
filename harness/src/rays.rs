//! Ray sets: made from ground-truth hits, seeded, in scanline order of the pixels that they start from.

use std::sync::Arc;

use glam::DVec3;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use tracebench_api::{Query, Ray, Viewpoint};

use crate::truth::{Answer, Ray64, Truth};

/// Part of the scene's diagonal by which an origin is lifted off its surface, along the geometric normal on the side
/// that the primary ray came from.
pub const ORIGIN_OFFSET_DIAGONALS: f64 = 1e-5;

/// Ulps of the hit's largest coordinate that are added to the offset, so that f32 rounding of the origin cannot undo it
/// in scenes far from the coordinates' origin.
pub const ORIGIN_OFFSET_ULPS: f64 = 16.0;

/// Length of `ao` rays, in scene diagonals.
pub const AO_LENGTH_DIAGONALS: f64 = 0.1;

/// The kinds of ray sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Primary,
    Diffuse,
    AmbientOcclusion,
}

/// A ray set as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RaySet {
    /// Stable name.
    pub name: &'static str,
    /// What is asked of its rays.
    pub query: Query,
    /// What it is, in one line.
    pub summary: &'static str,
    kind: Kind,
}

/// Every ray set.
pub const RAY_SETS: &[RaySet] = &[
    RaySet {
        name: "primary",
        query: Query::Closest,
        summary: "from the eye through the centre of every pixel",
        kind: Kind::Primary,
    },
    RaySet {
        name: "diffuse",
        query: Query::Closest,
        summary: "from every primary hit, cosine-distributed about the geometric normal, unbounded",
        kind: Kind::Diffuse,
    },
    RaySet {
        name: "ao",
        query: Query::Any,
        summary: "from every primary hit, cosine-distributed about the geometric normal, a tenth of the scene's \
                  diagonal long",
        kind: Kind::AmbientOcclusion,
    },
];

/// The primary rays of an image: through pixel centres, row by row from the top.
pub fn primary_rays(viewpoint: &Viewpoint, image: [u32; 2]) -> Vec<Ray> {
    let view = Viewpoint { frame: image, ..*viewpoint }.frame_view();
    let [width, height] = image;
    let ray = |pixel: u64| {
        let (x, y) = ((pixel % u64::from(width)) as f64, (pixel / u64::from(width)) as f64);
        let direction = view.direction_through(x + 0.5, y + 0.5).normalize();
        Ray { origin: viewpoint.eye.into(), t_min: 0.0, direction: direction.as_vec3().into(), t_max: Ray::UNBOUNDED }
    };
    (0..u64::from(width) * u64::from(height)).into_par_iter().map(ray).collect()
}

/// Makes one set. `primary` are the image's primary rays with their truth; pixels whose primary ray misses start no
/// secondary ray, so the set may be empty.
pub fn make(set: &RaySet, truth: &Truth, primary: &Arc<Vec<Ray>>, answers: &[Answer], seed: u64) -> Arc<Vec<Ray>> {
    let (tag, t_max) = match set.kind {
        Kind::Primary => return Arc::clone(primary),
        Kind::Diffuse => (1, Ray::UNBOUNDED),
        Kind::AmbientOcclusion => (2, (AO_LENGTH_DIAGONALS * truth.diagonal()) as f32),
    };
    let from_pixel = |pixel: usize| {
        let hit = answers[pixel].hit?;
        let arriving = Ray64::from(&primary[pixel]);
        let normal = truth.normal(hit.primitive);
        let normal = if normal.dot(arriving.direction) > 0.0 { -normal } else { normal };
        let direction = cosine_direction(normal, &mut stream(seed, tag, pixel as u64));
        let origin = lift(arriving.at(hit.t), normal, truth.diagonal());
        Some(Ray { origin: origin.as_vec3().into(), t_min: 0.0, direction: direction.as_vec3().into(), t_max })
    };
    Arc::new((0..primary.len()).into_par_iter().filter_map(from_pixel).collect())
}

fn lift(point: DVec3, normal: DVec3, diagonal: f64) -> DVec3 {
    let largest = point.abs().max_element() as f32;
    let ulp = f64::from(largest.next_up() - largest);
    point + normal * (ORIGIN_OFFSET_DIAGONALS * diagonal + ORIGIN_OFFSET_ULPS * ulp)
}

/// A generator of its own for each ray, so that rays do not depend on the number of cores or on other rays.
fn stream(seed: u64, tag: u64, pixel: u64) -> Pcg64Mcg {
    let mut state = [0; 16];
    state[..8].copy_from_slice(&seed.to_le_bytes());
    state[8..].copy_from_slice(&((tag << 48) ^ pixel).to_le_bytes());
    let mut generator = Pcg64Mcg::from_seed(state);
    // Neighbouring states give alike first outputs: the second generator starts from a well-mixed one.
    for _ in 0..4 {
        generator.next_u64();
    }
    Pcg64Mcg::seed_from_u64(generator.next_u64())
}

/// A unit vector with density cos(angle to `normal`) / pi: a point of the unit disk, lifted to the hemisphere (Malley's
/// method). Rejection instead of polar coordinates keeps the result the same on every machine.
fn cosine_direction(normal: DVec3, generator: &mut Pcg64Mcg) -> DVec3 {
    let mut uniform = || (generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0;
    loop {
        let (x, y) = (uniform(), uniform());
        let radius2 = x * x + y * y;
        if radius2 < 1.0 {
            let (across, along) = normal.any_orthonormal_pair();
            return (across * x + along * y + normal * (1.0 - radius2).sqrt()).normalize();
        }
    }
}

#[cfg(test)]
mod tests {
    use tracebench_api::Geometry;

    use super::*;
    use crate::viewpoint::Pose;

    /// A tenth of the diagonal for `ao`, no end for the rest, and origins lifted by what the documentation says: given
    /// here as plain numbers, so that a changed constant is noticed.
    #[test]
    fn lengths_and_offsets_are_the_documented_ones() {
        // A floor of 30 x 40: its diagonal is 50.
        let corners = vec![[-15.0, 0.0, -20.0], [15.0, 0.0, -20.0], [15.0, 0.0, 20.0], [-15.0, 0.0, 20.0]];
        let floor = Geometry::new(corners, vec![[0, 2, 1], [0, 3, 2]], None).unwrap();
        let truth = Truth::new(&floor, "floor");
        let viewpoint = Pose::parse("1,8,1:1,0,0.5").unwrap().viewpoint(&floor, [4, 4], 4);
        assert!((f64::from(viewpoint.near) - 0.05).abs() < 1e-7);
        let primary = Arc::new(primary_rays(&viewpoint, [4, 4]));
        let answers: Vec<Answer> =
            primary.iter().map(|ray| truth.answer_one(&Ray64::from(ray), Query::Closest)).collect();
        for (set, t_max) in RAY_SETS.iter().zip([Ray::UNBOUNDED, Ray::UNBOUNDED, 5.0]) {
            let rays = make(set, &truth, &primary, &answers, 7);
            assert!(rays.iter().all(|ray| ray.t_max == t_max && ray.t_min == 0.0), "{}", set.name);
            let height = if set.name == "primary" { 8.0 } else { 5e-4 };
            assert!(rays.iter().all(|ray| (ray.origin[1] - height).abs() < 0.1 * height), "{}", set.name);
        }
    }

    /// The mean cosine of a cosine-distributed direction is 2/3, its mean square 1/2; streams differ.
    #[test]
    fn directions_are_cosine_distributed() {
        let normal = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let count = 40_000;
        let cosines: Vec<f64> =
            (0..count).map(|pixel| cosine_direction(normal, &mut stream(1, 1, pixel)).dot(normal)).collect();
        let mean = cosines.iter().sum::<f64>() / count as f64;
        let square = cosines.iter().map(|cosine| cosine * cosine).sum::<f64>() / count as f64;
        assert!((mean - 2.0 / 3.0).abs() < 0.005, "{mean}");
        assert!((square - 0.5).abs() < 0.006, "{square}");
        assert!(cosines.iter().all(|cosine| *cosine > 0.0));
        let first = |seed, tag, pixel| cosine_direction(normal, &mut stream(seed, tag, pixel));
        assert_eq!(first(1, 1, 5), first(1, 1, 5));
        assert_ne!(first(1, 1, 5), first(2, 1, 5));
        assert_ne!(first(1, 1, 5), first(1, 2, 5));
        assert_ne!(first(1, 1, 5), first(1, 1, 6));
    }
}
