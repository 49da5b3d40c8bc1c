//! Causes of methods that see the scene along an axis, each from the smallest scene that shows it.

use super::*;
use glam::DVec2;
use tracebench_api::Orthographic;

/// Looks down from z = 2 at |x|, |y| < 2, of 64 x 64 pixels, 1/16 wide, as deep as z = -2.
fn image() -> Orthographic {
    Orthographic {
        origin: DVec3::new(-2.0, 2.0, 2.0),
        right: DVec3::X,
        up: DVec3::Y,
        axis: DVec3::NEG_Z,
        texel: DVec2::splat(1.0 / 16.0),
        far: 4.0,
        size: [64, 64],
    }
}

fn seen_by(image: Orthographic, layers: Layers, triangles: Vec<[[f32; 3]; 3]>, ray: Ray) -> Case {
    let mut case = Case::new(framed(triangles), vec![ray], Query::Closest);
    assert!(!case.answers[0].is_ambiguous());
    case.samplings = vec![SampledImage::new(Projection::Orthographic(image), layers)];
    case
}

fn seen(layers: Layers, triangles: Vec<[[f32; 3]; 3]>, ray: Ray) -> Case {
    seen_by(image(), layers, triangles, ray)
}

/// Plates of side 2 at heights, the first on top.
fn plates(heights: &[f32]) -> Vec<[[f32; 3]; 3]> {
    heights.iter().flat_map(|z| rectangle([-1.0, -1.0, *z], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])).collect()
}

/// Proves `off_view`: what was missed lies beside the image, before it, or deeper than it reaches; as a negative control,
/// not once the image is as wide, high or deep.
#[test]
fn off_view_is_outside_of_the_image() {
    let beside = rectangle([3.0, -1.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]).to_vec();
    let wide = Orthographic { origin: DVec3::new(-4.0, 4.0, 2.0), size: [128, 128], ..image() };
    let high = Orthographic { origin: DVec3::new(-2.0, 2.0, 4.0), far: 6.0, ..image() };
    let deep = Orthographic { far: 6.0, ..image() };
    for (triangles, ray, larger) in [
        (beside, ray([0.0, 0.25, 0.0], [1.0, 0.0, 0.0]), wide),
        (plates(&[3.0]), ray([0.22, 0.1, 1.0], [0.0, 0.0, 1.0]), high),
        (plates(&[-3.0]), ray([0.22, 0.1, 1.0], [0.0, 0.0, -1.0]), deep),
    ] {
        let case = seen(Layers::All, triangles.clone(), ray);
        assert!(case.answers[0].hit.is_some());
        assert_eq!(case.cause("tight", &[miss()]), "off_view");
        assert_ne!(seen_by(larger, Layers::All, triangles, ray).cause("tight", &[miss()]), "off_view");
    }
}

/// Proves `hidden_layer`: as many layers as an image keeps hide what lies behind them, and none fewer; a surface in the
/// image's own plane is a layer, too. That what is kept was not found has no such cause, whether triangles are named or not.
#[test]
fn hidden_layers_are_those_beyond_the_kept() {
    let ray = ray([-0.4, 0.1, -0.5], [0.6, 0.0, -0.8]);
    for (heights, before) in [(&[-1.5][..], 0), (&[0.5, -1.5], 1), (&[1.0, 0.5, -1.5], 2), (&[2.0, 0.5, -1.5], 2)] {
        for (layers, kept) in
            [(Layers::Nearest, 1), (Layers::AtMost(1), 1), (Layers::AtMost(2), 2), (Layers::AtMost(3), 3)]
        {
            let case = seen(layers, plates(heights), ray);
            let expected = if kept > before { "unexplained" } else { "hidden_layer" };
            assert_eq!(case.cause("tight", &[miss()]), expected, "{layers:?} of {heights:?}");
        }
        assert_eq!(seen(Layers::All, plates(heights), ray).cause("tight", &[miss()]), "unexplained", "{heights:?}");
    }
    let case = seen(Layers::AtMost(2), plates(&[0.5, -1.5]), ray);
    let nameless = Judge { names_primitives: false, ..case.judge() };
    match nameless.judge(&[miss()]).unwrap() {
        Judgement::Closest(judged) => {
            assert_eq!(judged.causes["tight"].keys().collect::<Vec<_>>(), ["unexplained"]);
        }
        Judgement::Any(_) => panic!("closest was asked"),
    }
}

/// Proves `left_out`: with a layer to spare a view keeps neither what faces away nor what lies close behind what it keeps, and does
/// not count it as a layer. As negative controls, it keeps both where it is told so, and what lies behind its last layer is hidden.
#[test]
fn what_is_left_out_is_no_layer() {
    let ray = ray([-0.4, 0.1, -0.5], [0.6, 0.0, -0.8]);
    let facing_away = |z: f32| rectangle([-1.0, -1.0, z], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]).to_vec();
    let chosen = |most, separation, back_faces| Layers::Chosen { most, separation, back_faces };
    let cause = |layers, triangles: &Vec<_>| seen(layers, triangles.clone(), ray).cause("tight", &[miss()]);
    let away = [plates(&[0.5]), facing_away(-1.5)].concat();
    assert_eq!(cause(chosen(2, 0.0, false), &away), "left_out");
    assert_eq!(cause(chosen(2, 0.0, true), &away), "unexplained");
    assert_eq!(cause(chosen(1, 0.0, false), &away), "hidden_layer");
    let close = plates(&[-1.3, -1.5]);
    let below = super::ray([-0.4, 0.1, -1.4], [0.6, 0.0, -0.08]);
    let cause_below = |separation| seen(chosen(2, separation, true), close.clone(), below).cause("tight", &[miss()]);
    assert_eq!(cause_below(0.25), "left_out");
    assert_eq!(cause_below(0.15), "unexplained");
    // What is left out takes no layer: the plate behind it is kept.
    let behind = [plates(&[0.5]), facing_away(0.0), plates(&[-1.5])].concat();
    assert_eq!(cause(chosen(2, 0.0, false), &behind), "unexplained");
    assert_eq!(cause(chosen(2, 0.0, true), &behind), "hidden_layer");
    let near = plates(&[0.5, 0.4, -1.5]);
    assert_eq!(cause(chosen(2, 0.2, true), &near), "unexplained");
    assert_eq!(cause(Layers::AtMost(2), &near), "hidden_layer");
}

/// Proves `between_samples`: a sliver that covers no pixel's centre is missed, on every depth alike; as a negative control,
/// not one that covers them. A hit two pixels beside the right place is off by the samples, one farther aside is not.
#[test]
fn between_samples_is_between_centres() {
    let sliver = |z: f32, x: f32| rectangle([x, -1.0, z], [0.02, 0.0, 0.0], [0.0, 2.0, 0.0]).to_vec();
    // Pixel centres lie at odd multiples of 1/32, at every depth.
    for z in [1.5, 0.0, -1.5] {
        let between = seen(Layers::All, sliver(z, 0.0625 + 0.01), down(0.0625 + 0.02, 0.3, z + 0.4));
        assert_eq!(between.cause("tight", &[miss()]), "between_samples", "{z}");
        let over = seen(Layers::All, sliver(z, 0.03125 - 0.01), ray([-0.26875, 0.3, z + 0.4], [0.6, 0.0, -0.8]));
        assert!(over.answers[0].hit.is_some());
        assert_ne!(over.cause("tight", &[miss()]), "between_samples", "{z}");
    }
    let case = seen(Layers::Nearest, plates(&[0.0]), ray([-0.75, 0.1, 0.5], [0.8, 0.0, -0.6]));
    let truth = case.answers[0].hit.unwrap().t as f32;
    assert_eq!(case.cause("tight", &[hit(truth + 0.1)]), "between_samples");
    assert_ne!(case.cause("tight", &[hit(truth + 0.5)]), "between_samples");
}

/// Proves `near_start`, `assumed_thickness` and `step_cap`, as of views.
#[test]
fn other_causes_are_those_of_views() {
    let near = seen(Layers::Nearest, plates(&[0.0]), ray([0.21, 0.1, 0.06], [0.8, 0.0, -0.6]));
    assert_eq!(near.cause("tight", &[miss()]), "near_start");
    let far = seen(Layers::Nearest, plates(&[0.0]), ray([-0.75, 0.1, 0.5], [0.8, 0.0, -0.6]));
    assert_eq!(far.cause("tight", &[Hit::miss(Status::StepCap)]), "step_cap");
    assert_ne!(far.cause("tight", &[miss()]), "near_start");
    let behind = seen(Layers::Nearest, plates(&[0.0]), ray([-1.5, 0.1, -0.25], [1.0, 0.0, 0.0]));
    assert_eq!(behind.cause("tight", &[hit(1.0)]), "unexplained");
    let before = seen(Layers::Nearest, plates(&[0.0]), ray([-1.5, 0.1, 0.25], [1.0, 0.0, 0.0]));
    assert_eq!(before.cause("tight", &[hit(1.5)]), "unexplained");
}
