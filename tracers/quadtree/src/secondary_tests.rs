//! Secondary samples (WKP15, section 5.2).

use std::sync::Arc;

use tracebench_api::{Hit, HitBuffer, PhaseClock, Query, Ray, RayBuffer, Residency, TraceJob, TraceTo};
use tracebench_kit::Built;
use tracebench_tests::{gpu, soup};

use super::reference::{Reference, Samples};
use super::structure::{Quadtree, QuadtreeStructure};
use super::tests::{LOSSLESS, built_by, hostile, parameters};
use super::trace_tests::{PUBLISHED, Stage, rays};

/// Hits and, with samples, their weights; that a trace says what it takes for them.
fn weighed(
    structure: &Built<QuadtreeStructure>,
    rays: &[Ray],
    settings: &[(&str, &str)],
) -> (Vec<Hit>, Option<Vec<f32>>) {
    let gpu = structure.gpu();
    let rays = RayBuffer::new(Arc::new(rays.to_vec()), Query::Closest, Some(gpu));
    let hits = HitBuffer::new(rays.host.len(), Residency::Device, Some(gpu)).unwrap();
    let parameters = parameters(settings);
    let mut clock = PhaseClock::new(Some(gpu));
    let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters: &parameters };
    let written = structure.record_weighing(&job, &hits, None, &mut clock).unwrap();
    clock.finish().unwrap();
    let told = structure.memory_of_trace(&job).unwrap();
    let entry = told.iter().find(|entry| entry.name == "weights of secondary samples");
    let bytes = 4 * rays.host.len() as u64;
    assert_eq!(entry.map(|entry| entry.used_bytes), written.as_ref().map(|_| bytes));
    let weights = written.map(|buffer| bytemuck::pod_collect_to_vec(&gpu.read(&buffer, bytes).unwrap()));
    (hits.read(Some(gpu)).unwrap(), weights)
}

/// Proves what the weights of secondary samples are: of a wall square to the view all samples count whole; at a plate's rim those
/// that fall on the wall behind do not; a ray that hits nothing has none; more samples weigh more, and hits stay the same.
#[test]
fn secondary_samples_are_weighed_by_the_depth_buffer() {
    let stage = Stage::new(false);
    let structure = stage.built(&[]);
    let weights = |rays: &[Ray], settings: &[(&str, &str)]| weighed(&structure, rays, settings);
    let ahead = |x: f64| stage.ray([0.0, 0.0, 0.0], [x, 0.02, 1.0]);
    // On the wall, on the plate, at its rim, beside the wall into the sky behind the eye.
    let rays = [ahead(0.9), ahead(0.1), ahead(0.497), stage.ray([0.0, 0.0, 0.0], [0.0, 0.0, -1.0])];
    let (hits, none) = weights(&rays, &[]);
    assert!(none.is_none());
    for (samples, count) in [("3", 3.0), ("8", 8.0)] {
        let (same, weights) = weights(&rays, &[("secondary_samples", samples), ("secondary_jitter", "2")]);
        assert_eq!(same, hits);
        let weights = weights.unwrap();
        assert!((weights[0] - count).abs() < 0.01 && (weights[1] - count).abs() < 0.01, "{weights:?}");
        assert!(weights[2] < count - 0.5 && weights[2] > 0.5, "{weights:?}");
        assert_eq!(weights[3], 0.0);
    }
    // A sigma as large as the cube weighs all alike.
    let (_, all) = weights(&rays, &[("secondary_samples", "8"), ("secondary_jitter", "2"), ("secondary_sigma", "1")]);
    assert!((all.unwrap()[2] - 8.0).abs() < 0.1);
}

/// Proves that weights are f64's over hostile triangles, of both layers, where rounding decides nothing. Negative control: another
/// jitter and another sigma are noticed.
#[test]
fn weights_are_those_of_f64() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let settings =
        [&LOSSLESS[..], &[("secondary_samples", "5"), ("secondary_jitter", "1.5"), ("secondary_sigma", "0.01")]]
            .concat();
    let structure = built_by(&Quadtree::new(Arc::clone(&gpu)).unwrap(), &gpu, &geometry, &settings);
    let reference = Reference::new(&structure);
    let rays = rays(800);
    let (_, weights) = weighed(&structure, &rays, &settings);
    let weights = weights.unwrap();
    let off = |samples: Samples| {
        let (mut wrong, mut decided) = (0, 0);
        for (ray, weight) in rays.iter().zip(&weights) {
            let answered = reference.answer(ray, &PUBLISHED);
            let (expected, sure) = reference.weight(ray, &answered, samples);
            if answered.decided && sure {
                decided += 1;
                wrong += usize::from((f64::from(*weight) - expected).abs() > 2e-3);
            }
        }
        (wrong, decided)
    };
    let samples = Samples { count: 5, jitter: 1.5, sigma: 0.01 };
    let (wrong, decided) = off(samples);
    assert_eq!(wrong, 0, "of {decided}");
    assert!(
        decided > 400 && weights.iter().filter(|weight| **weight > 0.5 && **weight < 4.9).count() > 20,
        "{decided}"
    );
    assert!(off(Samples { jitter: 6.0, ..samples }).0 > 30);
    assert!(off(Samples { sigma: 0.001, ..samples }).0 > 20);
}
