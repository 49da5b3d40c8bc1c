//! Why rays through the fragment A-buffer are wrong, as the judge finds it: layers that are kept, and what lies between samples.

use std::sync::Arc;

use tracebench_api::glam::DVec3;
use tracebench_api::{Geometry, Hit, Layers, Projection, Query, Ray, SampledImage, Status, Viewpoint};
use tracebench_harness::judge::{Judge, WRONG_RAYS_PER_CAUSE};
use tracebench_harness::progress::Progress;
use tracebench_harness::results::Judgement;
use tracebench_harness::truth::{Cache, Truth};
use tracebench_tests::{ray, rectangle, soup};

/// Looks along -z from the origin.
fn viewpoint() -> Viewpoint {
    let eye = tracebench_api::glam::Vec3::ZERO;
    Viewpoint { ..tracebench_tests::viewpoint(eye, eye - DVec3::Z.as_vec3(), 0.1, 50.0, [64, 64]) }
}

/// The causes of misses of every ray, by a tracer that keeps some layers.
fn causes(geometry: &Geometry, rays: &[Ray], layers: Layers, names_primitives: bool) -> Vec<(String, u64)> {
    let truth = Truth::new(geometry, "causes");
    let rays_of = Arc::new(rays.to_vec());
    let answers = truth.answer(&rays_of, Query::Closest, &Cache::none(), &Progress::new(true)).unwrap();
    let samplings = [SampledImage::new(Projection::Perspective(viewpoint().frame_view()), layers)];
    let judge = Judge {
        truth: &truth,
        eye: Some(DVec3::ZERO),
        rays,
        answers: &answers,
        query: Query::Closest,
        samplings: &samplings,
        voxels: None,
        names_primitives,
        wrong_rays_per_cause: WRONG_RAYS_PER_CAUSE,
    };
    let misses = vec![Hit::miss(Status::Miss); rays.len()];
    match judge.judge(&misses).unwrap() {
        Judgement::Closest(judgement) => judgement.causes["footprint"].clone().into_iter().collect(),
        Judgement::Any(_) => panic!("closest was asked"),
    }
}

/// A wall behind another one, hit from between: a hidden layer for what keeps one layer; stored for what
/// keeps all, so that its loss is unexplained: seen head-on, no ray passes between its samples. A thin strip that covers no pixel's centre
/// lies between samples for all of them.
#[test]
fn what_is_kept_was_not_hidden() {
    let walls = [-3.0, -6.0].into_iter().flat_map(|z| rectangle([-8.0, -8.0, z], [16.0, 0.0, 0.0], [0.0, 16.0, 0.0]));
    let walls: Vec<[[f32; 3]; 3]> = walls.collect();
    let geometry = soup(&walls, None);
    let rays: Vec<Ray> = (0..50)
        .map(|step| ray(DVec3::new(0.02 * f64::from(step) - 0.513, 0.317, -4.0), DVec3::new(0.3, 0.2, -1.0)))
        .collect();
    let all = |cause: &str| vec![(cause.to_owned(), 50)];
    assert_eq!(causes(&geometry, &rays, Layers::Nearest, false), all("hidden_layer"));
    assert_eq!(causes(&geometry, &rays, Layers::All, false), all("unexplained"));
    assert_eq!(causes(&geometry, &rays, Layers::All, true), all("unexplained"));
    // A strip 0.004 wide at depth 6, where a pixel is 0.1 or more wide, beside the pixels' centres.
    let strip = rectangle([-2.0, 0.02, -6.0], [4.0, 0.0, 0.0], [0.0, 0.004, 0.0]);
    let geometry = soup(&strip, None);
    let rays: Vec<Ray> =
        (0..50).map(|step| ray(DVec3::new(0.02 * f64::from(step) - 0.513, 0.022, -4.0), DVec3::NEG_Z)).collect();
    for layers in [Layers::Nearest, Layers::All] {
        assert_eq!(causes(&geometry, &rays, layers, false), all("between_samples"));
    }
}
