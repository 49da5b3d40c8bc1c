//! A cause from the smallest scene that shows it.

use super::*;

/// A ray with a number that devices may take for 0 is told apart where the answer is that of the ray with 0 in its place; without such a
/// number, or with another answer, it is not.
#[test]
fn cause_flushed_denormals() {
    let mut case = Case::new(framed(plate()), vec![Ray { t_min: 1e-40, ..down(0.2, 0.3, 1.0) }], Query::Closest);
    // As if the hit were before `t_min`.
    case.answers = vec![Answer { hit: None, perturbed: None }];
    assert_eq!(case.cause("tight", &[hit(1.0)]), "flushed_denormals");
    assert_ne!(case.cause("tight", &[hit(0.5)]), "flushed_denormals");
    case.rays = Arc::new(vec![down(0.2, 0.3, 1.0)]);
    assert_ne!(case.cause("tight", &[hit(1.0)]), "flushed_denormals");
}

/// A ray in the plane of the plate that is answered is told apart; one a little beside the plane, or with another angle, is not.
#[test]
fn cause_edge_on() {
    let cause = |z: f32, tilt: f32| {
        let direction = Vec3::new(1.0, 0.0, tilt).normalize();
        let case = Case::new(framed(plate()), vec![ray([-3.0, 0.3, z], direction.into())], Query::Closest);
        case.cause("tight", &[hit(2.5)])
    };
    assert_eq!(cause(0.0, 0.0), "edge_on");
    assert_eq!([cause(1e-3, 0.0), cause(-1e-2, 1e-3)], ["unexplained"; 2]);
}

/// A view from z = 2 down onto the plane z = 0, of 64 x 64 pixels and 90 degrees: it shows |x|, |y| < 2 there, a pixel
/// is 1/16 wide.
fn view() -> View {
    Viewpoint {
        eye: Vec3::new(0.0, 0.0, 2.0),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: std::f32::consts::FRAC_PI_2,
        near: 0.5,
        far: 50.0,
        frame: [64, 64],
        face: 64,
    }
    .frame_view()
}

fn seen(triangles: Vec<[[f32; 3]; 3]>, ray: Ray) -> Case {
    let mut case = Case::new(framed(triangles), vec![ray], Query::Closest);
    assert!(!case.answers[0].is_ambiguous());
    case.samplings = vec![SampledImage::new(Projection::Perspective(view()), Layers::Nearest)];
    case
}

fn status(status: Status) -> Hit {
    Hit::miss(status)
}

/// A plate of side `2 * half` at a height.
fn plate_at(z: f32, half: f32) -> Vec<[[f32; 3]; 3]> {
    rectangle([-half, -half, z], [2.0 * half, 0.0, 0.0], [0.0, 2.0 * half, 0.0]).to_vec()
}

/// Proves `within_footprint`: the right surface, off by less than a reference pixel, is wrong under `tight` only.
#[test]
fn cause_within_footprint() {
    let case = seen(plate(), down(0.25, 0.5, 1.0));
    assert_eq!(case.cause("tight", &[hit(1.002)]), "within_footprint");
    assert!(case.closest(&[hit(1.002)]).causes["footprint"].is_empty());
    assert_ne!(case.cause("tight", &[hit(1.2)]), "within_footprint");
}

/// Proves `off_view`: what was missed lies beside the view, behind its eye, or before its near plane.
#[test]
fn cause_off_view() {
    let beside = rectangle([3.0, -1.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]).to_vec();
    let rays = [
        (beside, ray([0.0, 0.25, 0.0], [1.0, 0.0, 0.0])),
        (plate_at(3.0, 1.0), ray([0.25, 0.125, 1.0], [0.0, 0.0, 1.0])),
        (plate_at(1.75, 1.0), ray([0.1, 0.05, 0.5], [0.0, 0.0, 1.0])),
    ];
    for (triangles, ray) in rays {
        let case = seen(triangles, ray);
        assert!(case.answers[0].hit.is_some());
        // The cause is the judge's own finding: no status of the tracer's changes it.
        for said in [Status::LeftViews, Status::Miss, Status::StepCap, Status::ThicknessRejected] {
            assert_eq!(case.cause("tight", &[status(said)]), "off_view");
        }
    }
}

/// Proves `hidden_layer`: what was missed lies behind another surface, and is none once that surface is gone.
#[test]
fn cause_hidden_layer() {
    let mut triangles = plate_at(-1.0, 1.0);
    triangles.extend(plate_at(0.5, 1.0));
    let ray = ray([0.25, 0.125, 0.0], [0.0, 0.0, -1.0]);
    let case = seen(triangles, ray);
    assert_eq!(case.cause("tight", &[status(Status::ThicknessRejected)]), "hidden_layer");
    assert_ne!(seen(plate_at(-1.0, 1.0), ray).cause("tight", &[miss()]), "hidden_layer");
}

/// Proves `step_cap`: what was missed is in plain sight, and the tracer gave up before.
#[test]
fn cause_step_cap() {
    let case = seen(plate_at(0.0, 1.0), ray([-0.75, 0.1, 0.5], [0.8, 0.0, -0.6]));
    assert_eq!(case.cause("tight", &[status(Status::StepCap)]), "step_cap");
    // The same without any view, for methods that have steps and no views.
    let mut case = case;
    case.samplings.clear();
    assert_eq!(case.cause("tight", &[status(Status::StepCap)]), "step_cap");
    assert_eq!(case.cause("tight", &[miss()]), "unexplained");
}

/// Proves `occluded` and `unexplained`: what was missed is in plain sight, on a pixel's centre, far from the ray's start, and a status
/// gives a reason only where the judge finds it: the ray goes behind another plate before.
#[test]
fn cause_occluded_or_unexplained() {
    let before = ray([-0.75, 0.1, 0.5], [0.8, 0.0, -0.6]);
    let mut behind = plate_at(0.0, 1.0);
    behind.extend(rectangle([-0.6, -0.5, 1.0], [0.2, 0.0, 0.0], [0.0, 1.0, 0.0]));
    for (triangles, occluded) in [(plate_at(0.0, 1.0), "unexplained"), (behind, "behind_last_layer")] {
        let case = seen(triangles, before);
        assert_eq!(case.cause("tight", &[status(Status::BehindLastLayer)]), occluded);
        for said in [Status::Miss, Status::LeftViews, Status::ThicknessRejected] {
            assert_eq!(case.cause("tight", &[status(said)]), "unexplained");
        }
    }
}

/// A case whose rays look at every pixel on their way, and take its sample for so thick.
fn marched(triangles: Vec<[[f32; 3]; 3]>, ray: Ray, thickness: f64) -> Case {
    let mut case = seen(triangles, ray);
    case.samplings[0].march = Some(ImageMarch {
        steps: MarchSteps::EveryPixel,
        start_bias: 0.0,
        thickness,
        thickness_in_pixels: 0.0,
        to_back_faces: false,
        from_before: false,
        anywhere: false,
    });
    case
}

/// Proves that where a march is declared a loss is explained only by a sample that the ray passes: of a steep surface it passes the
/// sample before or behind, as it says or not. As a negative control, once samples count from so far before them that they are met, the
/// loss is unexplained, and a bug that drops a plate in plain sight is, whatever is said.
#[test]
fn cause_thickness_rejected_or_slipped_through() {
    let level = |thickness| marched(steep(), ray([1.2, -0.2, 0.8], [-1.0, 0.0, 0.0]), thickness);
    assert_eq!(level(0.01).cause("tight", &[status(Status::ThicknessRejected)]), "thickness_rejected");
    assert_eq!(level(0.01).cause("tight", &[status(Status::LeftViews)]), "slipped_through");
    for said in [Status::ThicknessRejected, Status::LeftViews] {
        assert_eq!(level(-2.0).cause("tight", &[status(said)]), "unexplained");
        let plain = marched(plate_at(0.0, 1.0), ray([-0.75, 0.1, 0.5], [0.8, 0.0, -0.6]), 0.01);
        assert_eq!(plain.cause("tight", &[status(said)]), "unexplained");
    }
}

/// Proves that where rays hit only what they come to from before, one that comes to a plate from behind may pass it, and one from before may
/// not; where they hit both, neither may.
#[test]
fn cause_of_rays_from_behind() {
    let [before, behind] = [(0.5, -0.6), (-0.5, 0.6)].map(|(z, down)| ray([-0.75, 0.1, z], [0.8, 0.0, down]));
    for (ray, from_before, cause) in [
        (before, false, "unexplained"),
        (before, true, "unexplained"),
        (behind, false, "unexplained"),
        (behind, true, "thickness_rejected"),
    ] {
        let mut case = marched(plate_at(0.0, 1.0), ray, 0.01);
        case.samplings[0].march.as_mut().unwrap().from_before = from_before;
        assert_eq!(case.cause("tight", &[status(Status::ThicknessRejected)]), cause, "{ray:?} {from_before}");
    }
}

/// Proves `between_samples`: a sliver that falls between pixel centres is missed; a hit a pixel beside the right place
/// is off; a surface that a pixel's centre shows is hit beside it.
#[test]
fn cause_between_samples() {
    // Pixel centres lie at odd multiples of 1/32 in the plane z = 0; this sliver lies between two of them.
    let sliver = rectangle([0.0625 + 0.01, -1.0, 0.0], [0.02, 0.0, 0.0], [0.0, 2.0, 0.0]).to_vec();
    let mut triangles = sliver;
    triangles.extend(plate_at(-1.5, 3.0));
    let case = seen(triangles, down(0.0625 + 0.02, 0.3, 1.0));
    assert_eq!(case.answers[0].hit.map(|hit| hit.t), Some(1.0));
    assert_eq!(case.cause("tight", &[status(Status::Miss)]), "between_samples");
    assert_eq!(case.cause("tight", &[hit(2.5)]), "between_samples");
    // A slanted ray over a plate: 0.1 too late along it is 0.08 aside, less than two pixels (0.125).
    let case = seen(plate_at(0.0, 1.0), ray([-0.75, 0.1, 0.5], [0.8, 0.0, -0.6]));
    let truth = case.answers[0].hit.unwrap().t as f32;
    assert_eq!(case.cause("tight", &[hit(truth + 0.1)]), "between_samples");
    assert_ne!(case.cause("tight", &[hit(truth + 0.5)]), "between_samples");
    // Beside the edge of a plate whose pixel's centre still shows the plate: a false hit at the plate's depth.
    let edge = 0.5 + 1.0 / 32.0 + 0.005;
    let case = seen(plate_at(0.0, edge), down(0.5 + 0.05, 0.1, 1.0));
    assert!(case.answers[0].hit.is_none());
    assert_eq!(case.cause("tight", &[hit(1.0)]), "between_samples");
}

/// Proves that a hit on the corner between four pixels is explained by any of them: at a plate's corner only one of the
/// four centres shows it. As a negative control, a hit that far from any such pixel is not.
#[test]
fn cause_between_samples_on_a_corner_of_pixels() {
    // Pixel borders lie at multiples of 1/16 in the plane z = 0; the plate ends just beyond a pixel's centre.
    let edge = 0.5 + 1.0 / 32.0 + 0.005;
    for (x, y) in [(0.5625, 0.5625), (-0.5625, 0.5625), (0.5625, -0.5625), (-0.5625, -0.5625)] {
        let case = seen(plate_at(0.0, edge), down(x, y, 1.0));
        assert!(case.answers[0].hit.is_none());
        assert_eq!(case.cause("tight", &[hit(1.0)]), "between_samples", "{x} {y}");
        // As a true hit on such a corner, the plate is between samples too: three of the four show something else.
        let on_plate = seen(plate_at(0.0, 0.5725), down(x, y, 1.0));
        assert_eq!(on_plate.cause("tight", &[status(Status::Miss)]), "between_samples", "{x} {y}");
        let aside = seen(plate_at(0.0, edge), down(x * 1.25, y, 1.0));
        assert_eq!(aside.cause("tight", &[hit(1.0)]), "unexplained", "{x} {y}");
    }
}

/// Proves `near_start`: what was missed lies within two pixels of the ray's start.
#[test]
fn cause_near_start() {
    let triangles = plate_at(0.0, 1.0);
    let near = seen(triangles.clone(), ray([0.21, 0.1, 0.06], [0.8, 0.0, -0.6]));
    assert_eq!(near.cause("tight", &[miss()]), "near_start");
    let far = seen(triangles, ray([0.21, 0.1, 0.3], [0.8, 0.0, -0.6]));
    assert_eq!(far.cause("tight", &[miss()]), "unexplained");
}

/// Proves `self_hit`: an invented hit within four reference pixels of the ray's start, and none farther along.
#[test]
fn cause_self_hit() {
    let case = seen(plate_at(0.0, 1.0), ray([0.25, 0.125, 0.001], [0.0, 0.0, 1.0]));
    assert!(case.answers[0].hit.is_none());
    // The start is 2 from the eye: a reference pixel there is 2 * 2 / 1024.
    assert_eq!(case.cause("tight", &[hit(0.015)]), "self_hit");
    assert_ne!(case.cause("tight", &[hit(0.1)]), "self_hit");
    // Any-hit sets have the same causes.
    let mut any = case;
    any.query = Query::Any;
    assert_eq!(any.cause("occlusion", &[hit(0.015)]), "self_hit");
}

/// Proves `assumed_thickness`: a hit was invented behind what the view shows there.
#[test]
fn cause_assumed_thickness() {
    // Behind the plate's edge the ray comes with its pixel's border at x = -1.125, where it is 2.25 deep.
    let aside = ray([-1.5, 0.1, -0.25], [1.0, 0.0, 0.0]);
    let case = marched(plate_at(0.0, 1.0), aside, 0.5);
    assert!(case.answers[0].hit.is_none());
    assert_eq!(case.cause("tight", &[hit(0.375)]), "assumed_thickness");
    // Nor farther in, where it is behind the plate all along, nor with less thickness, nor where none is declared.
    let thin = marched(plate_at(0.0, 1.0), aside, 0.2);
    for case in [&thin, &seen(plate_at(0.0, 1.0), aside)] {
        assert_eq!(case.cause("tight", &[hit(0.375)]), "unexplained");
    }
    // Off the view no view explains it.
    assert_eq!(case.cause("tight", &[hit(100.0)]), "unexplained");
    // What was made up says so, wherever it lies.
    for t in [1.0, 100.0] {
        assert_eq!(case.cause("tight", &[Hit { status: Status::Inpainted as u32, ..hit(t) }]), "inpainted");
    }
    // In front of everything it is no thickness.
    let before = marched(plate_at(0.0, 1.0), ray([-1.5, 0.1, 0.25], [1.0, 0.0, 0.0]), 0.5);
    assert_ne!(before.cause("tight", &[hit(1.5)]), "assumed_thickness");
}

/// A plate that is steep in the view: across pixel 41, at eye depths from 1.14 to 1.9, of which the centre shows 1.426.
fn steep() -> Vec<[[f32; 3]; 3]> {
    rectangle([0.27, -4.0, 1.0], [0.0, 8.0, 0.0], [0.72, 0.0, -2.0]).to_vec()
}

/// Proves `shared_edge`, of methods without images: what lies exactly on an edge between two triangles was lost, or what lies behind it was
/// hit. As negative controls, the same within a triangle, something that is not there, and a method with images.
#[test]
fn cause_shared_edge() {
    let two = [plate(), plate_at(-1.0, 1.0)].concat();
    let bare = |ray| Case { samplings: Vec::new(), ..seen(two.clone(), ray) };
    let [on_edge, within] = [down(0.0, 0.0, 1.0), down(0.5, 0.125, 1.0)];
    for lost in [status(Status::Miss), hit(2.0)] {
        assert_eq!(bare(on_edge).cause("tight", &[lost]), "shared_edge");
        assert_eq!(bare(within).cause("tight", &[lost]), "unexplained");
        assert_ne!(seen(two.clone(), on_edge).cause("tight", &[lost]), "shared_edge");
    }
    assert_eq!(bare(on_edge).cause("tight", &[hit(0.5)]), "unexplained");
}

/// Proves `slipped_through` where points without thickness are declared: the ray is never as deep as the pixel's centre, or only beside
/// the pixel. As negative controls, one that is so within the pixel, and a method that declares nothing.
#[test]
fn cause_slipped_through_a_steep_surface() {
    for slips in [ray([1.2, -0.2, 0.8], [-1.0, 0.0, 0.0]), ray([1.142, -0.2, 1.2], [-0.9, 0.0, -0.45])] {
        let case = marched(steep(), slips, 0.0);
        assert!(case.answers[0].hit.is_some());
        assert_eq!(case.cause("tight", &[status(Status::LeftViews)]), "slipped_through");
        assert_eq!(seen(steep(), slips).cause("tight", &[status(Status::LeftViews)]), "unexplained");
    }
    let within = marched(steep(), ray([0.9212, -0.2, 1.08], [-0.5, 0.0, -0.5]), 0.0);
    assert!(within.answers[0].hit.is_some());
    assert_eq!(within.cause("tight", &[status(Status::LeftViews)]), "unexplained");
}

/// Proves `between_samples` of a hit at a pixel that shows nothing, at the depth of what the pixel beside it shows. As negative
/// controls, one at another depth, and one two pixels aside.
#[test]
fn cause_between_samples_beside_what_is_shown() {
    let edge = 0.5 + 1.0 / 32.0 + 0.005;
    let beside = |x: f32| seen(plate_at(0.0, edge), down(x, 0.1, 1.0));
    assert_eq!(beside(0.58).cause("tight", &[hit(1.0)]), "between_samples");
    assert_eq!(beside(0.58).cause("tight", &[hit(0.5)]), "unexplained");
    assert_eq!(beside(0.64).cause("tight", &[hit(1.0)]), "unexplained");
}

/// Proves that a hit told where the ray enters the view is explained, though by rounding it lies outside. As a negative
/// control, one far outside is not.
#[test]
fn cause_of_a_hit_on_the_border_of_a_view() {
    let mut triangles = plate_at(0.0, 3.0);
    triangles.extend(rectangle([1.3, -1.0, 0.5], [0.4, 0.0, 0.0], [0.0, 2.0, 0.0]));
    // It enters at t = 0.5, below the higher plate.
    let case = marched(triangles, ray([2.2, 0.1, 0.5], [-0.8, 0.0, -0.6]), f64::INFINITY);
    assert_eq!(case.cause("tight", &[hit(0.49997)]), "assumed_thickness");
    assert_eq!(case.cause("tight", &[hit(0.3)]), "unexplained");
}
