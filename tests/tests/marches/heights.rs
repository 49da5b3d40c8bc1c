//! `height-field` against brute force in f64, its pyramids against each other.

use super::*;
use tracebench_api::Status;

fn both(geometry: &Geometry, viewpoint: &Viewpoint) -> [Built; 2] {
    let tracer = tracer("height-field");
    ["min-max", "max"]
        .map(|pyramid| Built::new(&*tracer, parameters("height-field", &[("pyramid", pyramid)]), geometry, viewpoint))
}

/// Proves that hits are those of brute force in f64 over the same depths, of rays from anywhere in two scenes; that both pyramids
/// give the same bits, the one with far depths by fewer visits; and, as negative controls, that hits moved to the next ray, or a
/// depth buffer a thousandth farther, are noticed.
#[test]
fn hits_are_those_of_brute_force() {
    let (room, view_of_room) = room();
    for (geometry, viewpoint, reach) in [(scene(), camera(), 9.0), (room, view_of_room, 3.0)] {
        let view = viewpoint.frame_view();
        let depths = draw(&geometry, &view, 1, 0.0, false);
        let rays = rays(&view, 1500, reach, 81);
        let [min_max, max] = both(&geometry, &viewpoint).map(|built| built.hits_with(&built.parameters, &rays));
        let hits = min_max.0;
        assert!(hits == max.0, "the pyramids answer otherwise");
        let visited = [&min_max.1, &max.1].map(|counters| total(counters, "cells_visited"));
        assert!(visited[0] < visited[1], "{visited:?}");
        let reference = |ray: &Ray, shift| depths.height_field(ray, shift);
        let (compared, wrong) = compare(&rays, &hits, reference);
        assert!(compared > 900, "{compared}");
        assert_eq!(wrong, Vec::<String>::new(), "{} of {compared}", wrong.len());
        let found = hits.iter().filter(|hit| hit.is_hit()).count();
        assert!(found > 300 && found < 1450, "{found}");
        let mut moved = hits.clone();
        moved.rotate_left(1);
        assert!(compare(&rays, &moved, reference).1.len() > 100);
        let farther = Depths { images: vec![depths.images[0].iter().map(|depth| depth * 1.001).collect()], ..depths };
        assert!(compare(&rays, &hits, |ray, shift| farther.height_field(ray, shift)).1.len() > 100);
    }
}

/// Proves what is solid: behind a plate rays stop where they come behind its border, those that start there at their start, those
/// that enter the view there where they enter it; before it and beside it they pass, with a status that says why they end.
#[test]
fn all_behind_is_solid() {
    let plate = tracebench_tests::rectangle([-1.0, -1.0, -4.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let viewpoint = Viewpoint { vertical_fov: std::f32::consts::FRAC_PI_2, frame: [64, 64], ..camera() };
    let [min_max, max] = both(&soup(&plate, Some(&gpu())), &viewpoint);
    let of = |origin: [f64; 3], direction: [f64; 3]| ray(DVec3::from(origin), DVec3::from(direction));
    // A pixel at depth 5 is 5/32 wide; the plate hides |x| < 5/4 there.
    for (ray, expected) in [
        (of([-3.0, 0.1, -5.0], [1.0, 0.0, 0.0]), 1.75),
        (of([-3.0, 0.1, -40.0], [0.0, 0.0, 1.0]), 0.0),
        (of([0.1, 0.1, -5.0], [1.0, 0.2, 0.1]), 0.0),
        (of([0.5, 0.4, -1.0], [0.1, 0.0, -1.0]), 3.0 * 1.01_f64.sqrt()),
    ] {
        for built in [&min_max, &max] {
            let hit = built.hits(&[ray])[0];
            assert!(hit.is_hit() && (f64::from(hit.t) - expected).abs() < 5.0 / 32.0, "{ray:?}: {hit:?}");
        }
    }
    // What starts in solid starts exactly there.
    assert_eq!(min_max.hits(&[of([0.1, 0.1, -5.0], [1.0, 0.2, 0.1])])[0].t, 0.0);
    for (ray, expected) in [
        (of([-3.0, 0.1, -3.5], [1.0, 0.0, 0.0]), Status::LeftViews),
        (Ray { t_max: 0.5, ..of([0.1, 0.1, -3.0], [1.0, 0.0, -0.2]) }, Status::Miss),
        (of([0.1, 0.1, 3.0], [0.0, 0.0, 1.0]), Status::LeftViews),
    ] {
        let hit = min_max.hits(&[ray])[0];
        assert_eq!(Status::from_code(hit.status), Some(expected), "{ray:?}");
    }
    // With a bias of a few pixels it is looked for elsewhere: along the plate's border the start is let off.
    let beside = of([1.24, 0.1, -5.0], [1.0, 0.0, 0.0]);
    let biased = parameters("height-field", &[("start_bias", "2")]);
    assert!(min_max.hits(&[beside])[0].is_hit() && !min_max.hits_with(&biased, &[beside]).0[0].is_hit());
}

/// Proves that hits of the improved form, at once and by rays cut before the nearest depth, are those of halvings: the same rays hit,
/// where halvings would end, and those of brute force in f64; and, as a negative control, that fewer halvings are noticed.
#[test]
fn hits_at_once_are_those_of_halvings() {
    const CLOSED: [(&str, &str); 1] = [("search", "closed")];
    let tracer = tracer("height-field");
    let (room, view_of_room) = room();
    for (geometry, viewpoint, reach) in [(scene(), camera(), 9.0), (room, view_of_room, 3.0)] {
        let view = viewpoint.frame_view();
        let depths = draw(&geometry, &view, 1, 0.0, false);
        let rays = rays(&view, 1500, reach, 90);
        let built = Built::new(&*tracer, parameters("height-field", &[]), &geometry, &viewpoint);
        let of = |settings: &[(&str, &str)]| built.hits_with(&parameters("height-field", settings), &rays).0;
        let off = |ours: &[Hit], others: &[Hit]| {
            let same = |(one, other): &(&Hit, &Hit)| {
                one.status == other.status && (one.t - other.t).abs() <= 2e-6 * (view.far as f32 + one.t)
            };
            ours.iter().zip(others).filter(|pair| !same(pair)).count()
        };
        let (closed, halved) = (of(&CLOSED), of(&[]));
        assert_eq!(off(&closed, &halved), 0);
        assert!(off(&closed, &of(&[("refinement", "6")])) > 100);
        for clip in ["off", "on"] {
            let hits = of(&[CLOSED[0], ("depth_clip", clip)]);
            let (compared, wrong) = compare(&rays, &hits, |ray, shift| depths.height_field(ray, shift));
            assert!(compared > 900 && hits.iter().filter(|hit| hit.is_hit()).count() > 300, "{compared}");
            assert_eq!(wrong, Vec::<String>::new(), "{} of {compared}", wrong.len());
        }
    }
}

/// Proves that every halving brings hits nearer to the stored depth, from behind, and the last ones as near as f32 tells; without any a
/// ray is placed where its part in the pixel ends.
#[test]
fn halvings_bring_hits_nearer() {
    let plate = tracebench_tests::rectangle([-9.0, -9.0, -4.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    let tracer = tracer("height-field");
    let built = Built::new(&*tracer, parameters("height-field", &[]), &soup(&plate, Some(&gpu())), &camera());
    let rays: Vec<Ray> = {
        let mut numbers = Numbers::new(82);
        let from = |numbers: &mut Numbers| DVec3::new(numbers.signed() * 0.2, numbers.signed() * 0.2, -0.5);
        (0..200).map(|_| ray(from(&mut numbers), numbers.point() * 0.3 - DVec3::Z)).collect()
    };
    let error = |halvings: &str| {
        let told = parameters("height-field", &[("refinement", halvings)]);
        let hits = built.hits_with(&told, &rays).0;
        let behind = rays.iter().zip(&hits).map(|(ray, hit)| {
            assert!(hit.is_hit(), "{ray:?}");
            f64::from(hit.t) - (-4.0 - f64::from(ray.origin[2])) / f64::from(ray.direction[2])
        });
        behind.fold([f64::INFINITY, 0.0], |[least, most], each| [f64::min(least, each), f64::max(most, each)])
    };
    let errors = ["0", "2", "4", "8", "24"].map(error);
    assert!(errors.iter().all(|[least, _]| *least > -1e-5), "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1][1] < 0.5 * pair[0][1]), "{errors:?}");
    assert!(errors[4][1] < 1e-5, "{errors:?}");
}
