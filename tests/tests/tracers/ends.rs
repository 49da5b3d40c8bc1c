//! Hits at the ends of a ray: they count, near the origin and far from it.

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{Hit, Preset, Query, Ray};
use tracebench_harness::truth::{Ray64, Truth};
use tracebench_tests::{gpu, ray, rectangle, soup, viewpoint};

use super::hostile::subjects;

/// Proves that truth and every method that names triangles count a hit at either end of a ray, and none that lies four ulps of the
/// coordinates beyond one, over plates on which every number is exact in f32, up to a million units from the origin; and that no method
/// answers beyond the ends, or otherwise for any hit than for the closest. Of `bvh-cpu` as published obvhs's boxes begin a little after
/// the origin: what a flat box holds there is lost.
#[test]
fn hits_at_the_ends_count() {
    let subjects = subjects();
    for (far, tilt) in [0.0, 1024.0, 1_048_576.0].into_iter().flat_map(|far| [(far, 0.0), (far, 1.0_f32)]) {
        let plate = rectangle([far - 2.0, far - 2.0, far], [4.0, 0.0, 0.0], [0.0, 4.0, tilt]);
        let geometry = soup(&plate, Some(&gpu()));
        let truth = Truth::new(&geometry, "plate");
        let view = viewpoint(Vec3::splat(far) + Vec3::new(0.25, 0.5, 8.0), Vec3::splat(far), 0.01, 64.0, [48, 32]);
        let down = |height: f32| Ray {
            origin: [far + 0.5, far + 1.0, far + 0.75 * tilt + height],
            ..ray(DVec3::ZERO, DVec3::NEG_Z)
        };
        let most = far.max(2.0);
        let step = 4.0 * (most.next_up() - most);
        let (above, on) = (down(2.0), down(0.0));
        let rays = [
            (Some(2.0), above),
            (Some(2.0), Ray { t_min: 2.0, ..above }),
            (None, Ray { t_min: 2.0 + step, ..above }),
            (Some(2.0), Ray { t_max: 2.0, ..above }),
            (None, Ray { t_max: 2.0 - step, ..above }),
            (Some(2.0), Ray { t_min: 2.0, t_max: 2.0, ..above }),
            (Some(0.0), on),
            (Some(0.0), Ray { t_max: 0.0, ..on }),
            (None, Ray { t_min: step, ..on }),
        ];
        for (expected, ray) in &rays {
            assert_eq!(truth.closest(&Ray64::from(ray)).map(|hit| hit.t as f32), *expected, "{far} {tilt} {ray:?}");
        }
        let asked = rays.map(|(_, ray)| ray);
        for subject in &subjects {
            let structure = subject.build(&geometry, &view);
            let [closest, any] = Query::ALL.map(|query| subject.trace(&*structure, &subject.rays(&asked, query)));
            for ((expected, ray), hits) in rays.iter().zip(closest.iter().zip(&any)) {
                let context = format!("{} {:?}, {far} {tilt} {ray:?}: {hits:?}", subject.name, subject.preset);
                let answer = |hit: &Hit| hit.is_hit().then_some(hit.t);
                assert_eq!(hits.0.is_hit(), hits.1.is_hit(), "{context}");
                assert!(answer(hits.0).is_none_or(|t| (ray.t_min..=ray.t_max).contains(&t)), "{context}");
                let loses = (subject.name, subject.preset) == ("bvh-cpu", Preset::Published) && *expected == Some(0.0);
                assert!(answer(hits.0) == *expected || loses || !subject.names_primitives, "{context}");
            }
        }
    }
}
