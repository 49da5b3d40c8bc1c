//! Random directions and points, by additions, multiplications, divisions and square roots alone (IEEE 754 defines them
//! exactly), so that rays are the same on every machine.

use glam::DVec3;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Numbers for one ray.
pub(crate) struct Stream(Pcg64Mcg);

impl Stream {
    /// A generator of its own for each ray, so that rays do not depend on the number of cores or on other rays. `tag`
    /// tells the sets apart, below 2^15; `index` is below 2^48.
    pub(crate) fn new(seed: u64, tag: u64, index: u64) -> Self {
        let mut state = [0; 16];
        state[..8].copy_from_slice(&seed.to_le_bytes());
        // The generator's lowest bit is always on, so that the seed's own is told elsewhere.
        let even = u64::from(seed.is_multiple_of(2)) << 63;
        state[8..].copy_from_slice(&(even ^ (tag << 48) ^ index).to_le_bytes());
        let mut generator = Pcg64Mcg::from_seed(state);
        // Neighbouring states give alike first outputs: the second generator starts from a well-mixed one.
        for _ in 0..4 {
            generator.next_u64();
        }
        Self(Pcg64Mcg::seed_from_u64(generator.next_u64()))
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In [-1, 1).
    fn signed(&mut self) -> f64 {
        self.unit() * 2.0 - 1.0
    }

    /// A point of the unit disk, evenly spread, with its squared radius. Rejection needs no sine.
    pub(crate) fn disk(&mut self) -> (f64, f64, f64) {
        loop {
            let (x, y) = (self.signed(), self.signed());
            let radius2 = x * x + y * y;
            if radius2 < 1.0 {
                return (x, y, radius2);
            }
        }
    }

    /// A unit vector with density cos(angle to `normal`) / pi: a point of the unit disk, lifted to the hemisphere
    /// (Malley's method).
    pub(crate) fn cosine(&mut self, normal: DVec3) -> DVec3 {
        let (x, y, radius2) = self.disk();
        let (across, along) = normal.any_orthonormal_pair();
        (across * x + along * y + normal * (1.0 - radius2).sqrt()).normalize()
    }

    /// A unit vector, evenly spread over the sphere.
    pub(crate) fn sphere(&mut self) -> DVec3 {
        loop {
            let point = DVec3::new(self.signed(), self.signed(), self.signed());
            let length2 = point.length_squared();
            if length2 < 1.0 && length2 > 1e-6 {
                return point / length2.sqrt();
            }
        }
    }

    /// A unit vector, evenly spread over the hemisphere about `normal`.
    pub(crate) fn hemisphere(&mut self, normal: DVec3) -> DVec3 {
        let direction = self.sphere();
        if direction.dot(normal) < 0.0 { -direction } else { direction }
    }

    /// A microfacet's normal about `normal` with the GGX distribution of width `alpha` (Walter, Marschner, Li, Torrance,
    /// *Microfacet Models for Refraction through Rough Surfaces*, EGSR 2007, eq. 35).
    pub(crate) fn ggx(&mut self, normal: DVec3, alpha: f64) -> DVec3 {
        let share = self.unit();
        let cosine2 = (1.0 - share) / (1.0 + (alpha * alpha - 1.0) * share);
        let (x, y, radius2) = loop {
            let found = self.disk();
            if found.2 > 1e-12 {
                break found;
            }
        };
        let sine = (1.0 - cosine2).max(0.0).sqrt() / radius2.sqrt();
        let (across, along) = normal.any_orthonormal_pair();
        (across * (x * sine) + along * (y * sine) + normal * cosine2.sqrt()).normalize()
    }
}

/// A direction mirrored at a plane.
pub(crate) fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction - normal * (2.0 * direction.dot(normal))).normalize()
}

/// A direction bent by Snell's law where it enters matter `index` times as dense; `normal` is on the side that it
/// comes from. `None` where it is reflected instead, which happens on the way out only.
pub(crate) fn refract(direction: DVec3, normal: DVec3, index: f64) -> Option<DVec3> {
    let ratio = 1.0 / index;
    let cosine = -direction.dot(normal);
    let inner2 = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    (inner2 >= 0.0).then(|| (direction * ratio + normal * (ratio * cosine - inner2.sqrt())).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    const NORMAL: DVec3 = DVec3::new(1.0 / 3.0, 2.0 / 3.0, -2.0 / 3.0);
    const COUNT: u64 = 40_000;

    /// Mean and mean square of the cosine to the normal.
    fn moments(sample: impl Fn(&mut Stream) -> DVec3) -> (f64, f64) {
        let cosines: Vec<f64> = (0..COUNT).map(|index| sample(&mut Stream::new(1, 1, index)).dot(NORMAL)).collect();
        let mean = cosines.iter().sum::<f64>() / COUNT as f64;
        (mean, cosines.iter().map(|cosine| cosine * cosine).sum::<f64>() / COUNT as f64)
    }

    fn close(found: (f64, f64), expected: (f64, f64)) -> bool {
        (found.0 - expected.0).abs() < 0.006 && (found.1 - expected.1).abs() < 0.006
    }

    /// Neighbouring seeds, tags and rays have numbers of their own, and the same ones have the same.
    #[test]
    fn every_seed_tag_and_ray_has_its_own_numbers() {
        let first = |seed, tag, index| Stream::new(seed, tag, index).0.next_u64();
        let mut all: Vec<u64> = (0..4)
            .flat_map(|seed| (0..4).map(move |tag| (seed, tag)))
            .flat_map(|(seed, tag)| (0..4).map(move |index| first(seed, tag, index)))
            .collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 64);
        assert_eq!(first(2, 3, 4), first(2, 3, 4));
    }

    /// The first two moments of each distribution are those of its density, integrated by hand, and none is another's.
    #[test]
    fn distributions_have_their_moments() {
        let cosine = moments(|stream| stream.cosine(NORMAL));
        let sphere = moments(|stream| stream.sphere());
        let hemisphere = moments(|stream| stream.hemisphere(NORMAL));
        assert!(close(cosine, (2.0 / 3.0, 0.5)), "{cosine:?}");
        assert!(close(sphere, (0.0, 1.0 / 3.0)), "{sphere:?}");
        assert!(close(hemisphere, (0.5, 1.0 / 3.0)), "{hemisphere:?}");
        assert!(!close(cosine, hemisphere) && !close(sphere, hemisphere));
        // GGX of width 1 is the cosine's distribution; a narrower one's mean of cos^2, with a = alpha^2, is
        // (1 - a + a ln a) / (1 - a)^2.
        assert!(close(moments(|stream| stream.ggx(NORMAL, 1.0)), (2.0 / 3.0, 0.5)));
        let a: f64 = 0.25 * 0.25;
        let expected = (1.0 - a + a * a.ln()) / ((1.0 - a) * (1.0 - a));
        let narrow = moments(|stream| stream.ggx(NORMAL, 0.25));
        assert!((narrow.1 - expected).abs() < 0.006, "{narrow:?} {expected}");
    }

    /// Streams differ by seed, set and ray, and are the same when asked again.
    #[test]
    fn streams_differ() {
        let first = |seed, tag, index| Stream::new(seed, tag, index).cosine(NORMAL);
        assert_eq!(first(1, 1, 5), first(1, 1, 5));
        assert!([first(2, 1, 5), first(1, 2, 5), first(1, 1, 6)].iter().all(|other| *other != first(1, 1, 5)));
    }

    /// Reflection keeps the angle and turns the side; refraction obeys Snell's law and is none beyond the critical angle.
    #[test]
    fn bending_obeys_its_laws() {
        for index in 0..200 {
            let direction = -Stream::new(3, 1, index).hemisphere(NORMAL);
            let mirrored = reflect(direction, NORMAL);
            assert!((mirrored.dot(NORMAL) + direction.dot(NORMAL)).abs() < 1e-12);
            assert!((mirrored.cross(NORMAL) - direction.cross(NORMAL)).length() < 1e-12);
            let sine = |direction: DVec3| direction.cross(NORMAL).length();
            let bent = refract(direction, NORMAL, 1.5).unwrap();
            assert!((sine(bent) * 1.5 - sine(direction)).abs() < 1e-12 && bent.dot(NORMAL) < 0.0);
            assert!(bent.dot(direction.cross(NORMAL)).abs() < 1e-12, "in one plane");
            assert_eq!(refract(direction, NORMAL, 1.0 / 1.5).is_some(), sine(direction) <= 1.0 / 1.5);
        }
    }
}
