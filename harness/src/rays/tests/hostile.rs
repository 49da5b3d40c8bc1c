//! Hostile rays are what their kinds say, and of each kind some have one answer.

use super::*;
use crate::rays::hostile::KINDS;

fn hostile_kind(pixel: Pixel) -> &'static str {
    KINDS[pixel as usize % KINDS.len()].0
}

/// Proves that in the room and round a solid a quarter of each kind at least is unambiguous, and that of all rays some are ambiguous;
/// that directions have unit length, and that they repeat.
#[test]
fn a_quarter_of_each_kind_has_one_answer() {
    for (name, scene) in [("room", TestScene::room()), ("solid", TestScene::solid())] {
        let made = scene.made(&HOSTILE, [80, 60]);
        assert!(made.rays.iter().all(|ray| (direction(ray).length() - 1.0).abs() < 1e-6 && origin(ray).is_finite()));
        assert_eq!(bits(&made.rays), bits(&scene.made(&HOSTILE, [80, 60]).rays));
        let ambiguous: Vec<bool> = scene.tell(&made.rays).iter().map(Answer::is_ambiguous).collect();
        assert!(ambiguous.contains(&true), "{name}");
        for (kind, _) in KINDS {
            let of_kind = made.pixels.iter().zip(&ambiguous).filter(|(pixel, _)| hostile_kind(**pixel) == kind);
            let (all, sure) = of_kind.fold((0, 0), |(all, sure), (_, is)| (all + 1, sure + usize::from(!is)));
            assert!(all > 400 && 4 * sure >= all, "{name}, {kind}: {sure} of {all}");
        }
    }
}

/// Proves that kinds are what they say: zeros with a sign, numbers below the least normal one, spans of a point, origins far away.
#[test]
fn kinds_are_what_they_say() {
    let scene = TestScene::solid();
    let made = scene.made(&HOSTILE, [80, 60]);
    let of = |kind: &str| -> Vec<Ray> {
        let of_kind = made.pixels.iter().zip(made.rays.iter()).filter(|(pixel, _)| hostile_kind(**pixel) == kind);
        of_kind.map(|(_, ray)| *ray).collect()
    };
    let is_negative_zero = |part: &f32| part.to_bits() == (-0.0_f32).to_bits();
    assert!(of("with -0.0").iter().all(|ray| ray.direction.iter().any(is_negative_zero)));
    assert!(of("with denormals").iter().all(|ray| ray.direction.iter().any(|part| part.is_subnormal())));
    assert!(of("of no length").iter().all(|ray| ray.t_min == ray.t_max));
    assert!(of("along axes").iter().all(|ray| ray.direction.iter().filter(|part| **part == 0.0).count() == 2));
    assert!(of("from far away").iter().all(|ray| origin(ray).length() > 30.0));
    // A kind is none of the others.
    assert!(!of("through vertices").iter().any(|ray| ray.direction.iter().any(is_negative_zero)));
}
