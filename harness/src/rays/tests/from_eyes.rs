//! Rays that start at an eye, or at several.

use super::*;

/// Primary rays start at the eye and go through the centres of the pixels, from the top left on.
#[test]
fn primary_rays_go_through_pixel_centres() {
    let floor = TestScene::floor();
    let view = Viewpoint { frame: IMAGE, ..floor.viewpoint }.frame_view();
    for (pixel, ray) in floor.make("primary").iter().enumerate() {
        assert_eq!(Vec3::from(ray.origin), floor.viewpoint.eye);
        let at = view.project(view.eye + direction(ray)).unwrap();
        let expected = ((pixel % 24) as f64 + 0.5, (pixel / 24) as f64 + 0.5);
        assert!((at.x - expected.0).abs() < 1e-4 && (at.y - expected.1).abs() < 1e-4, "{pixel}");
    }
}

/// The second eye stands 3.2 cm to the right and looks the same way.
#[test]
fn stereo_moves_the_eye_to_the_right() {
    let floor = TestScene::floor();
    let right = floor.viewpoint.frame_view().right * 0.032;
    for (ray, first) in floor.make("stereo").iter().zip(floor.make("primary").iter()) {
        assert!((origin(ray) - origin(first) - right).length() < 1e-6 && ray.direction == first.direction);
    }
}

/// From the start of a camera path the later camera is the path's own; without a path it has moved ahead; no time later
/// nothing has moved.
#[test]
fn temporal_follows_the_camera_path() {
    let room = TestScene::room();
    let camera = room.path.as_ref().unwrap().at(0.5);
    let later = Pose::from(&camera).viewpoint(room.truth.geometry(), IMAGE, 1);
    let expected = primary_rays(&later, IMAGE);
    for (ray, expected) in room.make("temporal").iter().zip(&expected) {
        assert!(origin(ray).distance(origin(expected)) < 1e-5);
        assert!(direction(ray).distance(direction(expected)) < 1e-5);
    }
    let same = |a: &[Ray], b: &[Ray]| a.iter().zip(b).all(|(a, b)| direction(a).distance(direction(b)) < 1e-5);
    assert!(!same(&room.make("temporal"), &room.make("primary")));
    assert!(same(&TestScene::room().with("temporal_shift_s", "0").make("temporal"), &room.make("primary")));
    let floor = TestScene::floor();
    let moved = origin(&floor.make("temporal")[0]) - floor.viewpoint.eye.as_dvec3();
    assert!((moved - floor.viewpoint.forward.as_dvec3() * 0.5).length() < 1e-5);
}

/// Rays through the lens start within its rim and meet the primary ray of their pixel in the plane in focus: by default
/// that of what the centre shows. Without an aperture they are the primary rays.
#[test]
fn lens_rays_meet_in_focus() {
    let floor = TestScene::floor();
    let view = Viewpoint { frame: IMAGE, ..floor.viewpoint }.frame_view();
    let meet = |rays: &[Ray], focus: f64| {
        rays.iter().zip(floor.make("primary").iter()).all(|(ray, straight)| {
            let point = view.eye + direction(straight) * (focus / direction(straight).dot(view.forward));
            let t = (point - origin(ray)).dot(view.forward) / direction(ray).dot(view.forward);
            (Ray64::from(ray).at(t) - point).length() < 1e-4
        })
    };
    let centre = (IMAGE[1] / 2 * IMAGE[0] + IMAGE[0] / 2) as usize;
    let primary = floor.primary();
    let depth = primary.answers[centre].hit.unwrap().t * direction(&primary.rays[centre]).dot(view.forward);
    let rays = floor.make("lens");
    assert!(meet(&rays, depth) && !meet(&rays, depth * 1.2));
    assert!(meet(&TestScene::floor().with("lens_focus", "0.5").make("lens"), 25.0));
    let distances: Vec<f64> = rays.iter().map(|ray| origin(ray).distance(view.eye)).collect();
    assert!(distances.iter().all(|distance| *distance <= 0.25 + 1e-5) && distances.iter().any(|each| *each > 0.2));
    let closed = TestScene::floor().with("lens_aperture", "0").make("lens");
    assert!(closed.iter().zip(primary.rays.iter()).all(|(a, b)| direction(a).distance(direction(b)) < 1e-6));
}

/// Several rays a pixel stay together, each from a place of its own on the lens through its pixel's point in focus; more
/// than can be held are refused by the parameter's name.
#[test]
fn lenses_start_several_rays_a_pixel() {
    let floor = TestScene::floor().with("lens_count", "4").with("lens_focus", "0.5");
    let view = Viewpoint { frame: IMAGE, ..floor.viewpoint }.frame_view();
    let (rays, straight) = (floor.make("lens"), floor.make("primary"));
    assert_eq!((rays.len(), bits(&rays).len()), (4 * straight.len(), 4 * straight.len()));
    for (four, straight) in rays.chunks(4).zip(&straight) {
        let point = view.eye + direction(straight) * (25.0 / direction(straight).dot(view.forward));
        for ray in four {
            let t = (point - origin(ray)).dot(view.forward) / direction(ray).dot(view.forward);
            assert!((Ray64::from(ray).at(t) - point).length() < 1e-4 && origin(ray).distance(view.eye) <= 0.25 + 1e-5);
        }
    }
    let origins: BTreeSet<[u32; 3]> = rays.iter().map(|ray| ray.origin.map(f32::to_bits)).collect();
    assert_eq!(origins.len(), rays.len());
    let parameters = TestScene::floor().with("lens_count", "64").parameters;
    let scene = RayScene {
        truth: &floor.truth,
        viewpoint: &floor.viewpoint,
        path: None,
        mirrors: &[],
        image: [1000, 1000],
        seed: 1,
        parameters: &RayParameters::try_from(&parameters).unwrap(),
    };
    let many = Starts::primary(
        Arc::new(vec![straight[0]; 1_000_000]),
        Arc::new(vec![Answer { hit: None, perturbed: None }; 1_000_000]),
    );
    let set = RAY_SETS.iter().find(|set| set.name == "lens").unwrap();
    let error = make(set, &scene, &many, |_| Ok(Vec::new())).unwrap_err().to_string();
    assert!(error.contains("64000000") && error.contains("lens_count"), "{error}");
}

/// Sixteen eyes in a square of the stated width, each with its part of the image and the whole field of view; one camera
/// is the viewpoint's.
#[test]
fn light_fields_are_squares_of_cameras() {
    let floor = TestScene::floor();
    let rays = floor.make("light-field");
    let mut eyes: Vec<DVec3> = Vec::new();
    for ray in &rays {
        if eyes.iter().all(|eye| eye.distance(origin(ray)) > 1e-4) {
            eyes.push(origin(ray));
        }
    }
    let view = floor.viewpoint.frame_view();
    assert_eq!(eyes.len(), 16);
    let across = eyes.iter().map(|eye| (*eye - view.eye).dot(view.right));
    assert!((across.clone().fold(f64::MIN, f64::max) - 1.25).abs() < 1e-4);
    assert!((across.fold(f64::MAX, f64::min) + 1.25).abs() < 1e-4);
    // The image's first pixel is the left upper camera's; its neighbour there looks four pixels to the right.
    assert!((origin(&rays[0]) - view.eye - (view.up - view.right) * 1.25).length() < 1e-4);
    assert!(rays[5].origin == rays[0].origin && rays[6].origin != rays[0].origin);
    let one = TestScene::floor().with("light_field_cameras", "1").make("light-field");
    let primary = floor.make("primary");
    assert!(one.iter().zip(&primary).all(|(a, b)| direction(a).distance(direction(b)) < 1e-6 && a.origin == b.origin));
}
