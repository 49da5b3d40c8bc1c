//! Looking rays up in the shadow map, against brute force in f64.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Geometry, Gpu, Hit, HitBuffer, PhaseClock, Query, Ray, RayBuffer, Residency, Structure, TraceJob, TraceTo, Update,
    View,
};
use tracebench_kit::Built;
use tracebench_tests::{Numbers, gpu, soup};

use super::shadow_map::light_view;
use super::structure::DirtStructure;
use super::tests::{built, parameters, viewpoint};
use super::visibility_tests::{aside, depth_of};

/// Depths this near each other, relative to the start's, are told apart by rounding.
const DEPTH_SLACK: f64 = 1e-4;
/// Starts this near a border between texels, in texels, may be looked up on either side.
const BORDER_SLACK: f64 = 1e-3;

/// The eye depths that a texel may hold: those of the nearest triangle at its centre and right next to it, infinite for none.
fn shown(view: &View, triangles: &[[DVec3; 3]], [x, y]: [f64; 2]) -> Vec<f64> {
    let by = aside();
    let places = [(0.0, 0.0), (by, by), (by, -by), (-by, by), (-by, -by)];
    let nearest = |(right, below)| {
        let direction = view.direction_through(x.floor() + 0.5 + right, y.floor() + 0.5 + below);
        let depths = triangles.iter().filter_map(|corners| depth_of(view.eye, direction, *corners));
        depths.filter(|depth| *depth > 0.0).fold(f64::INFINITY, f64::min)
    };
    places.map(nearest).to_vec()
}

/// Whether a point is in shadow by a map with a texel's depth taken from `place`; `None` where rounding decides.
fn in_shadow(
    view: &View,
    triangles: &[[DVec3; 3]],
    start: DVec3,
    bias: f64,
    place: fn(&View, [f64; 2]) -> [f64; 2],
) -> Option<bool> {
    let at = view.project(start)?;
    if [at.x, at.y].iter().any(|along| (along - along.round()).abs() < BORDER_SLACK) {
        return None;
    }
    let limit = at.depth - bias * 2.0 * view.tan_half_width * at.depth / f64::from(view.size[0]);
    let mut answers = shown(view, triangles, place(view, [at.x, at.y])).into_iter().map(|depth| {
        let gap = limit - depth;
        (gap.abs() > DEPTH_SLACK * at.depth).then_some(gap > 0.0)
    });
    let first = answers.next()??;
    answers.all(|answer| answer == Some(first)).then_some(first)
}

/// Scattered triangles before the eye, in f32 and as they are.
fn scene() -> (Vec<[[f32; 3]; 3]>, Vec<[DVec3; 3]>) {
    let mut numbers = Numbers::new(23);
    let mut scattered = || {
        let centre = viewpoint().eye.as_dvec3() + numbers.point() * 4.0;
        [0; 3].map(|_| (centre + numbers.point() * 0.8).as_vec3().to_array())
    };
    let corners: Vec<_> = (0..200).map(|_| scattered()).collect();
    let exact = corners.iter().map(|corners| corners.map(|at| Vec3::from(at).as_dvec3())).collect();
    (corners, exact)
}

/// Rays to the light from places on triangles, and from some off them.
fn to_light(geometry: &Geometry, triangles: &[[DVec3; 3]]) -> Vec<Ray> {
    let mut numbers = Numbers::new(29);
    let light = geometry.outer_light();
    let from = |index: usize| {
        let [a, b, c] = triangles[index % triangles.len()];
        let (u, v) = (numbers.unit(), numbers.unit());
        let on = a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v);
        let start = (on + numbers.point() * 0.05 * f64::from(index as u32 % 2)).as_vec3();
        let way = light - start.as_dvec3();
        Ray {
            origin: start.to_array(),
            t_min: 0.0,
            direction: way.normalize().as_vec3().to_array(),
            t_max: way.length() as f32,
        }
    };
    (0..4000).map(from).collect()
}

fn answer(gpu: &Arc<Gpu>, structure: &Built<DirtStructure>, rays: &[Ray], query: Query, bias: &str) -> Vec<Hit> {
    let rays = RayBuffer::new(Arc::new(rays.to_vec()), query, Some(gpu));
    let mut hits = HitBuffer::new(rays.host.len(), Residency::Device, Some(gpu)).unwrap();
    hits.poison(Some(gpu)).unwrap();
    let mut clock = PhaseClock::new(Some(gpu));
    let parameters = parameters(&[("shadow_bias", bias)]);
    let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters: &parameters };
    structure.trace(job, &mut hits, &mut clock).unwrap();
    clock.finish().unwrap();
    hits.read(Some(gpu)).unwrap()
}

/// A ray is in shadow just where its start lies behind the nearest triangle on the line from the light through its texel's centre,
/// by more than the bias; and the check notices texels mixed up and another bias.
#[test]
fn rays_to_the_light_are_looked_up() {
    let gpu = gpu();
    let (corners, triangles) = scene();
    let geometry = soup(&corners, Some(&gpu));
    let structure = built(&gpu, &geometry, &[("shadow_map", "on")]);
    let view = light_view(&geometry, 63).unwrap();
    let seen = structure.shadow_map.as_ref().unwrap().read(&gpu).unwrap();
    assert_eq!((structure.shadow_map.as_ref().unwrap().view, seen.len()), (view, 63 * 63));
    let rays = to_light(&geometry, &triangles);
    let same = |_: &View, at| at;
    let mirrored = |view: &View, [x, y]: [f64; 2]| [f64::from(view.size[0]) - x, y];
    for (bias, text) in [(0.0, "0"), (1.0, "1"), (4.0, "4")] {
        let hits = answer(&gpu, &structure, &rays, Query::Any, text);
        let wrong = |bias: f64, place: fn(&View, [f64; 2]) -> [f64; 2]| {
            let start = |ray: &Ray| Vec3::from(ray.origin).as_dvec3();
            let told =
                |(ray, hit): (&Ray, &Hit)| Some(in_shadow(&view, &triangles, start(ray), bias, place)? != hit.is_hit());
            let judged: Vec<bool> = rays.iter().zip(&hits).filter_map(told).collect();
            (judged.iter().filter(|wrong| **wrong).count(), judged.len())
        };
        let (found, judged) = wrong(bias, same);
        assert!(found == 0 && judged > 2000, "bias {text}: {found} of {judged}");
        assert!(wrong(bias, mirrored).0 > judged / 20, "bias {text}: texels mixed up are not noticed");
        assert!(wrong(bias + 4.0, same).0 > 20, "bias {text}: another bias is not noticed");
    }
}

/// Sets that the map cannot answer are traced, hit for hit as without one: closest hits, and a set of which one ray ends
/// elsewhere. A rebuild over a scene that has moved draws the map again, from where the light is then.
#[test]
fn other_sets_are_traced() {
    let gpu = gpu();
    let (corners, triangles) = scene();
    let geometry = soup(&corners, Some(&gpu));
    let [with, without] = ["on", "off"].map(|map| built(&gpu, &geometry, &[("shadow_map", map)]));
    assert!(with.memory().structure_bytes() > without.memory().structure_bytes() && without.shadow_map.is_none());
    let rays = to_light(&geometry, &triangles);
    let mut bent = rays.clone();
    bent[7].t_max *= 0.9;
    for (rays, query) in [(&rays, Query::Closest), (&bent, Query::Any)] {
        let [one, other] = [&with, &without].map(|structure| answer(&gpu, structure, rays, query, "2"));
        assert!(one == other, "{query:?}");
    }
    let [looked_up, traced] = [&with, &without].map(|structure| answer(&gpu, structure, &rays, Query::Any, "2"));
    let agree = looked_up.iter().zip(&traced).filter(|(one, other)| one.is_hit() == other.is_hit()).count();
    assert!(looked_up != traced && agree > rays.len() / 2, "{agree} of {}", rays.len());
    let moved: Vec<_> = corners.iter().map(|corners| corners.map(|[x, y, z]| [1.5 * x + 2.0, y, z])).collect();
    let moved = soup(&moved, Some(&gpu));
    let (mut rebuilt, fresh) = (with, built(&gpu, &moved, &[("shadow_map", "on")]));
    let mut clock = PhaseClock::new(Some(&gpu));
    let on = parameters(&[("shadow_map", "on")]);
    rebuilt.update(Update::Rebuild, &moved, &viewpoint(), &on, &mut clock).unwrap();
    clock.finish().unwrap();
    let maps = [&rebuilt, &fresh].map(|structure| structure.shadow_map.as_ref().unwrap());
    assert!(maps[0].view == maps[1].view && maps[0].view != light_view(&geometry, 63).unwrap());
    assert!(maps[0].read(&gpu).unwrap() == maps[1].read(&gpu).unwrap());
}
