//! What tracers leave at the end point `surface`: one body for every tracer in the registry, over tiny hostile scenes.

use super::hostile::{Subject, small_scenes, subjects};
use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Geometry, Hit, HitBuffer, Projection, Query, Ray, RayBuffer, Structure, Surface, SurfaceStatus, TraceTo,
};

/// Tolerance of positions in units of f32's precision at the scene's and the ray's coordinates: sums of a few products.
const POSITION_ROUNDINGS: f64 = 16.0;

/// Tolerance of an average of normals, which is in few bits, and of its length.
const AVERAGE_TOLERANCE: f64 = 3e-4;

/// Tolerance of the normal of a plane that is stored as two slopes of sixteen bits over an image, in a cube whose edges may be stretched.
const SLOPES_TOLERANCE: f64 = 2e-4;

/// Tolerance of a normal's direction, over the sine of the angle between the edges that it comes from.
const NORMAL_TOLERANCE: f64 = 4e-6;

fn bytes<T: bytemuck::Pod>(records: &[T]) -> &[u8] {
    bytemuck::cast_slice(records)
}

fn corners(geometry: &Geometry, primitive: u32) -> [DVec3; 3] {
    geometry.corners(primitive).map(Vec3::as_dvec3)
}

/// Whether a direction is an average of others, each counted as often as may be: the rest of it that none of them explains vanishes.
fn is_average(normal: DVec3, others: &[DVec3], tolerance: f64) -> bool {
    let (mut weights, mut rest) = (vec![0.0; others.len()], normal);
    for _ in 0..2000 {
        for (weight, other) in weights.iter_mut().zip(others) {
            let step = f64::max(rest.dot(*other), -*weight);
            *weight += step;
            rest -= *other * step;
        }
        if rest.length() < tolerance {
            break;
        }
    }
    rest.length() < tolerance && (normal.length() - 1.0).abs() < AVERAGE_TOLERANCE
}

/// What is wrong with a surface, by f64 and the hit alone. A hit that names no triangle is compared with the ray's own point,
/// and its normal against all normals that the scene has, or against averages of those nearby where the structure keeps such.
fn wrong(
    subject: &Subject,
    structure: &dyn Structure,
    geometry: &Geometry,
    ray: &Ray,
    hit: &Hit,
    surface: &Surface,
) -> Option<String> {
    let expected = if hit.is_hit() { SurfaceStatus::Written } else { SurfaceStatus::NoHit };
    match SurfaceStatus::from_code(surface.status) {
        Some(SurfaceStatus::Lost) if hit.is_hit() && subject.may_lose() => return None,
        status if status == Some(expected) => {}
        status => return Some(format!("status {status:?} instead of {expected:?}")),
    }
    if !hit.is_hit() {
        return (*surface != Surface::none(SurfaceStatus::NoHit)).then(|| "a surface without a hit".to_owned());
    }
    let on_ray = Vec3::from(ray.origin).as_dvec3() + Vec3::from(ray.direction).as_dvec3() * f64::from(hit.t);
    let candidates: Vec<u32> = match subject.names_primitives {
        true => vec![hit.primitive],
        false => (0..geometry.triangles.len() as u32).collect(),
    };
    let position = Vec3::from(surface.position).as_dvec3();
    let reach = candidates.iter().flat_map(|each| corners(geometry, *each)).map(|corner| corner.abs().max_element());
    let reach = reach.fold(on_ray.abs().max_element(), f64::max).max(f64::from(hit.t));
    let right_point = match subject.names_primitives {
        true => {
            let [a, b, c] = corners(geometry, hit.primitive);
            a + (b - a) * f64::from(hit.u) + (c - a) * f64::from(hit.v)
        }
        false => on_ray,
    };
    if (position - right_point).length() > POSITION_ROUNDINGS * f64::from(f32::EPSILON) * reach {
        return Some(format!("at {position} instead of {right_point}"));
    }
    let fits = |primitive: &u32| {
        let [a, b, c] = corners(geometry, *primitive);
        let (first, second) = ((b - a).normalize_or_zero(), (c - a).normalize_or_zero());
        let across = first.cross(second);
        let normal = Vec3::from(surface.normal).as_dvec3();
        // Edges are differences of coordinates in f32, exact here; what is left is the cross product's rounding.
        let off = (normal - across.normalize_or_zero()).length();
        let stored = if subject.stores_slopes() { SLOPES_TOLERANCE } else { 0.0 };
        let right_normal = off <= stored + NORMAL_TOLERANCE / across.length().max(1e-30)
            || (across.length() < 1e-6 && normal == DVec3::ZERO);
        right_normal && surface.material == geometry.triangle_materials[*primitive as usize]
    };
    if let Some(reach) = subject.averages_within(structure) {
        let is_near = |primitive: &&u32| {
            let [a, b, c] = corners(geometry, **primitive);
            let (low, high) = (a.min(b).min(c) - reach, a.max(b).max(c) + reach);
            position.clamp(low, high) == position
        };
        let near: Vec<u32> = candidates.iter().filter(is_near).copied().collect();
        let across = |primitive: &u32| {
            let [a, b, c] = corners(geometry, *primitive);
            (b - a).normalize_or_zero().cross((c - a).normalize_or_zero())
        };
        let across: Vec<DVec3> = near.iter().map(across).collect();
        let normals: Vec<DVec3> = across.iter().map(|across| across.normalize_or_zero()).collect();
        // Of the thinnest, which may have been all that counted.
        let noise = across.iter().map(|across| NORMAL_TOLERANCE / across.length().max(1e-30)).fold(0.0, f64::max);
        let is_material = near.iter().any(|each| geometry.triangle_materials[*each as usize] == surface.material);
        let right =
            is_material && is_average(Vec3::from(surface.normal).as_dvec3(), &normals, AVERAGE_TOLERANCE + noise);
        return (!right).then(|| format!("no triangles nearby average to that: {surface:?}"));
    }
    (!candidates.iter().any(fits)).then(|| format!("no triangle has that normal and material: {surface:?}"))
}

impl Subject {
    /// Hits with their surfaces.
    fn surfaces(&self, structure: &dyn Structure, rays: &RayBuffer) -> (Vec<Hit>, Vec<Surface>) {
        let mut hits = self.poisoned(rays.host.len());
        self.try_trace(structure, rays, &mut hits).unwrap_or_else(|error| panic!("{}: {error}", self.name));
        (hits.read(Some(&self.gpu)).unwrap(), hits.read_surfaces(Some(&self.gpu)).unwrap())
    }

    /// How far the triangles reach of which a surface is the average: twice the edge of a voxel, of a structure that keeps such.
    fn averages_within(&self, structure: &dyn Structure) -> Option<f64> {
        let has_voxels = self.parameters.iter().any(|(name, _)| name == "levels");
        let edge =
            structure.samplings(&self.parameters).unwrap().iter().find_map(|sampling| match sampling.projection {
                Projection::Orthographic(image) => Some(image.texel.max_element()),
                Projection::Perspective(_) => None,
            });
        edge.filter(|_| has_voxels).map(|edge| 2.0 * edge)
    }

    /// Whether its fragments are planes over orthographic images, whose normals are two slopes.
    fn stores_slopes(&self) -> bool {
        let is = |name: &str, wanted: &str| {
            self.parameters
                .iter()
                .any(|(each, value)| each == name && (wanted.is_empty() || value.to_string() == wanted))
        };
        !self.names_primitives && is("grid", "") && is("fragments", "planes")
    }

    /// Whether its way of fetching surfaces is one that may lose some.
    fn may_lose(&self) -> bool {
        self.parameters.iter().any(|(name, value)| name == "fetch" && value.to_string() == "raster")
    }
}

/// Proves for every tracer, preset, scene and query: hits are those of the end point `hit`, bit for bit; every hit has the
/// surface of its triangle, every miss none; a second trace and the counting variant give the same bits.
#[test]
fn surfaces_are_those_of_the_hits() {
    let mut fetched = 0;
    for mut subject in subjects() {
        for scene in small_scenes() {
            let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
            for query in [Query::Closest, Query::Any] {
                let context = format!("{} {:?} on {}, {query:?}", subject.name, subject.parameters, scene.name);
                let rays = subject.rays(&scene.rays, query);
                subject.trace_to = TraceTo::Hit;
                let hits = subject.trace(&*structure, &rays);
                subject.trace_to = TraceTo::Surface;
                let (same, surfaces) = subject.surfaces(&*structure, &rays);
                assert_eq!(bytes(&same), bytes(&hits), "{context}");
                assert_eq!(surfaces.len(), hits.len(), "{context}");
                for (index, (hit, surface)) in hits.iter().zip(&surfaces).enumerate() {
                    let wrong = wrong(&subject, &*structure, &scene.geometry, &rays.host[index], hit, surface);
                    assert_eq!(wrong, None, "{context}: ray {index} {hit:?}");
                    fetched += usize::from(surface.status == SurfaceStatus::Written as u32);
                }
                let lost = surfaces.iter().filter(|each| each.status == SurfaceStatus::Lost as u32).count();
                let found = hits.iter().filter(|hit| hit.is_hit()).count();
                assert!(lost * 10 <= found, "{context}: {lost} of {found} surfaces lost");
                let (_, again) = subject.surfaces(&*structure, &rays);
                assert_eq!(bytes(&again), bytes(&surfaces), "{context}: second trace");
                let mut counted = subject.poisoned(hits.len());
                structure.trace_counted(subject.job(&rays), &mut counted).unwrap();
                assert_eq!(bytes(&counted.read(Some(&subject.gpu)).unwrap()), bytes(&hits), "{context}: counted");
                let of_counted = counted.read_surfaces(Some(&subject.gpu)).unwrap();
                assert_eq!(bytes(&of_counted), bytes(&surfaces), "{context}: counted");
            }
        }
    }
    assert!(fetched > 10_000, "{fetched}");
}

/// Negative control: a surface that is elsewhere, turned, of another material or status is noticed, for every tracer.
#[test]
fn wrong_surfaces_are_noticed() {
    for mut subject in subjects() {
        subject.trace_to = TraceTo::Surface;
        let scene = small_scenes().remove(1);
        let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
        let rays = subject.rays(&scene.rays, Query::Closest);
        let (hits, surfaces) = subject.surfaces(&*structure, &rays);
        let written = |index: &usize| surfaces[*index].status == SurfaceStatus::Written as u32;
        let index = (0..hits.len()).find(written).unwrap();
        let noticed = |surface: Surface| {
            wrong(&subject, &*structure, &scene.geometry, &rays.host[index], &hits[index], &surface).is_some()
        };
        let right = surfaces[index];
        let [x, y, z] = right.position;
        let [nx, ny, nz] = right.normal;
        assert!(!noticed(right));
        assert!(noticed(Surface { position: [x + 1e-3, y, z], ..right }), "{}", subject.name);
        assert!(noticed(Surface { normal: [-nx, -ny, -nz], ..right }), "{}", subject.name);
        assert!(noticed(Surface { normal: [nx, ny + 1e-3, nz], ..right }), "{}", subject.name);
        assert!(noticed(Surface { material: right.material + 1, ..right }), "{}", subject.name);
        assert!(noticed(Surface::none(SurfaceStatus::NoHit)), "{}", subject.name);
        assert!(noticed(Surface::none(SurfaceStatus::Unwritten)), "{}", subject.name);
        assert!(noticed(Surface::none(SurfaceStatus::Lost)) != subject.may_lose(), "{}", subject.name);
    }
}

/// Proves that surfaces without room for them are an error that says so, for every tracer, and that no rays at all do not
/// panic.
#[test]
fn no_room_for_surfaces_is_an_error() {
    for mut subject in subjects() {
        subject.trace_to = TraceTo::Surface;
        let scene = small_scenes().remove(1);
        let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
        let rays = subject.rays(&scene.rays, Query::Closest);
        let mut hits = HitBuffer::new(scene.rays.len(), subject.residency, Some(&subject.gpu)).unwrap();
        let error = subject.try_trace(&*structure, &rays, &mut hits).unwrap_err();
        assert!(error.to_string().contains("surfaces"), "{}: {error}", subject.name);
        let none = subject.rays(&[], Query::Closest);
        let mut hits = subject.poisoned(0);
        if subject.try_trace(&*structure, &none, &mut hits).is_ok() {
            assert!(hits.read_surfaces(Some(&subject.gpu)).is_ok_and(|surfaces| surfaces.is_empty()));
        }
        assert_eq!(subject.surfaces(&*structure, &rays).1.len(), scene.rays.len());
    }
}
