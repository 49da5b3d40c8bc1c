//! What the judge says of surfaces, and what it must notice.

use tracebench_api::{Surface, SurfaceStatus};
use tracebench_harness::results::SurfaceJudgement;

use super::*;

/// The surfaces of right answers: of the plate in z = 0, whose normal is +z and whose material 0.
fn right_surfaces(case: &Case) -> Vec<Surface> {
    let surface = |(ray, answer): (&Ray, &Answer)| match answer.hit {
        None => Surface::none(SurfaceStatus::NoHit),
        Some(_) => Surface {
            position: [ray.origin[0], ray.origin[1], 0.0],
            material: 0,
            normal: [0.0, 0.0, 1.0],
            status: SurfaceStatus::Written as u32,
        },
    };
    case.rays.iter().zip(&case.answers).map(surface).collect()
}

fn judged(case: &Case, surfaces: &[Surface]) -> SurfaceJudgement {
    case.judge().judge_surfaces(&case.right(), surfaces).unwrap()
}

/// Proves that right surfaces score 1 and have no errors, for both queries.
#[test]
fn right_surfaces_score_one() {
    for query in [Query::Closest, Query::Any] {
        let case = hundred(query);
        let found = judged(&case, &right_surfaces(&case));
        assert_eq!((found.judged, found.lost), (60, 0));
        assert_eq!([found.agreement, found.material, found.normal, found.position], [Some(1.0); 4]);
        assert_eq!((found.normal_error_degrees.p99, found.position_error.p99), (Some(0.0), Some(0.0)));
        assert!(found.interval.is_some_and(|[low, high]| low > 0.9 && high == 1.0));
    }
}

/// Negative control: one wrong normal, material or position among sixty, or one that is lost, is noticed where it belongs and
/// nowhere else; a normal that is off by half a degree and a position by half a pixel are right.
#[test]
fn one_wrong_surface_is_noticed() {
    for query in [Query::Closest, Query::Any] {
        let case = hundred(query);
        let right = right_surfaces(&case);
        let with = |change: &dyn Fn(&mut Surface)| {
            let mut changed = right.clone();
            change(&mut changed[17]);
            judged(&case, &changed)
        };
        let one_less = Some(59.0 / 60.0);
        let turned = |degrees: f32| [degrees.to_radians().sin(), 0.0, degrees.to_radians().cos()];
        // The eye is 2 away: a pixel of 90 degrees over 1024 there is 4 / 1024.
        let moved = |pixels: f32| move |surface: &mut Surface| surface.position[1] += pixels * 4.0 / 1024.0;
        let normal = with(&|surface| surface.normal = turned(1.5));
        assert_eq!([normal.agreement, normal.normal], [one_less; 2]);
        assert_eq!([normal.material, normal.position], [Some(1.0); 2]);
        let material = with(&|surface| surface.material = 1);
        assert_eq!([material.agreement, material.material], [one_less; 2]);
        assert_eq!([material.normal, material.position], [Some(1.0); 2]);
        let position = with(&moved(1.2));
        assert_eq!([position.agreement, position.position], [one_less; 2]);
        assert_eq!([position.normal, position.material], [Some(1.0); 2]);
        let lost = with(&|surface| *surface = Surface::none(SurfaceStatus::Lost));
        assert_eq!((lost.agreement, lost.lost, lost.judged), (one_less, 1, 60));
        assert_eq!([lost.material, lost.normal, lost.position], [Some(1.0); 3]);
        for allowed in [with(&|surface| surface.normal = turned(0.5)), with(&moved(0.5))] {
            assert_eq!(allowed.agreement, Some(1.0));
        }
    }
}

/// Proves that angles are measured: a flipped normal is off by 180 degrees, half of all normals turned by 40 show in p95.
#[test]
fn angles_are_measured() {
    let case = hundred(Query::Closest);
    let mut surfaces = right_surfaces(&case);
    for surface in &mut surfaces[..30] {
        surface.normal = [40.0_f32.to_radians().sin(), 0.0, 40.0_f32.to_radians().cos()];
    }
    let found = judged(&case, &surfaces).normal_error_degrees;
    assert!(found.p95.is_some_and(|angle| (angle - 40.0).abs() < 1e-4), "{found:?}");
    surfaces[..60].iter_mut().for_each(|surface| surface.normal = [0.0, 0.0, -1.0]);
    assert_eq!(judged(&case, &surfaces).normal_error_degrees.p50, Some(180.0));
}

/// Surfaces of answers that are wrong are not judged: there is nothing that they should be.
#[test]
fn surfaces_of_wrong_hits_are_left_out() {
    let case = hundred(Query::Closest);
    let (mut hits, surfaces) = (case.right(), right_surfaces(&case));
    hits[5].t = 1.0;
    assert_eq!(case.judge().judge_surfaces(&hits, &surfaces).unwrap().judged, 59);
}

/// Surfaces that their rays' answers cannot have are no surfaces: unwritten ones, of a miss, none of a hit, such as are no
/// number, too few.
#[test]
fn malformed_surfaces_are_refused() {
    let case = hundred(Query::Closest);
    let right = right_surfaces(&case);
    let refused = |index: usize, surface: Surface| {
        let mut changed = right.clone();
        changed[index] = surface;
        match case.judge().judge_surfaces(&case.right(), &changed) {
            Err(JudgeError::Surface { count: 1, first, .. }) => assert_eq!(first, index),
            other => panic!("{other:?}"),
        }
    };
    refused(3, Surface::none(SurfaceStatus::Unwritten));
    refused(3, Surface::none(SurfaceStatus::NoHit));
    refused(3, Surface { position: [f32::NAN, 0.0, 0.0], ..right[3] });
    refused(3, Surface { normal: [0.0, f32::INFINITY, 0.0], ..right[3] });
    refused(3, Surface { status: 9, ..right[3] });
    refused(80, right[3]);
    refused(80, Surface::none(SurfaceStatus::Lost));
    let few = case.judge().judge_surfaces(&case.right(), &right[1..]);
    assert!(matches!(few, Err(JudgeError::Count { hits: 99, rays: 100 })));
}

/// Proves that controls pass on their own surfaces and fail on others.
#[test]
fn controls_check_surfaces() {
    for query in [Query::Closest, Query::Any] {
        let case = hundred(query);
        let known = TrueCounts { hits: 60, misses: 40, ..TrueCounts::default() };
        let oracle = judged(&case, &right_surfaces(&case));
        Control::Oracle.check_surfaces(&oracle, &known).unwrap();
        let lost = vec![Surface::none(SurfaceStatus::Lost); 100];
        let hits = vec![Hit { primitive: NO_PRIMITIVE, ..hit((DIAGONAL / 2.0) as f32) }; 100];
        let always_hit = case.judge().judge_surfaces(&hits, &lost).unwrap();
        Control::AlwaysHit.check_surfaces(&always_hit, &known).unwrap();
        let none = vec![Surface::none(SurfaceStatus::NoHit); 100];
        let always_miss = case.judge().judge_surfaces(&vec![miss(); 100], &none).unwrap();
        Control::AlwaysMiss.check_surfaces(&always_miss, &known).unwrap();
        let all = [(Control::Oracle, &oracle), (Control::AlwaysHit, &always_hit), (Control::AlwaysMiss, &always_miss)];
        for (control, _) in all {
            for (other, theirs) in all {
                assert_eq!(control.check_surfaces(theirs, &known).is_ok(), control == other, "{control:?} {other:?}");
            }
        }
        for spoil in [
            |surface: &mut Surface| surface.material = 2,
            |surface: &mut Surface| surface.normal = [1.0, 0.0, 0.0],
            |surface: &mut Surface| surface.position[0] += 0.1,
            |surface: &mut Surface| *surface = Surface::none(SurfaceStatus::Lost),
        ] {
            let mut spoilt = right_surfaces(&case);
            spoil(&mut spoilt[9]);
            assert!(Control::Oracle.check_surfaces(&judged(&case, &spoilt), &known).is_err());
        }
        assert!(Control::Oracle.check_surfaces(&oracle, &TrueCounts { hits: 61, ..known.clone() }).is_err());
    }
}
