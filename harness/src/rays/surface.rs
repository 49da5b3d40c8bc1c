//! Rays that start where other rays hit.

use glam::DVec3;
use rayon::prelude::*;
use tracebench_api::Ray;

use super::sampling::{Stream, reflect, refract};
use super::{AO_LENGTH_DIAGONALS, Pixel, RayScene, Starts, Target, inner_light, leave, towards, unbounded};
use crate::truth::Ray64;

/// Where a ray hit.
struct Surface {
    pixel: Pixel,
    /// The hit in f64.
    point: DVec3,
    /// Geometric normal on the side that the ray came from.
    normal: DVec3,
    /// Whether that is the triangle's front side.
    front: bool,
    /// Direction of the ray that came.
    arriving: DVec3,
    primitive: u32,
}

impl Surface {
    /// An endless ray that leaves on the side of its direction.
    fn leave(&self, scene: &RayScene<'_>, direction: DVec3) -> Ray {
        leave(self.point, self.normal, direction, scene.truth.diagonal())
    }
}

/// Looks at every hit, in order and on all cores; `make` gives as many rays as it likes.
fn each_hit<R: Send, I: IntoIterator<Item = R>>(
    scene: &RayScene<'_>,
    starts: &Starts,
    make: impl Fn(&Surface) -> I + Sync,
) -> Vec<R>
where
    I::IntoIter: Send,
{
    let surface = |index: usize| {
        let hit = starts.answers[index].hit?;
        let ray = Ray64::from(&starts.rays[index]);
        let normal = scene.truth.normal(hit.primitive);
        let front = normal.dot(ray.direction) <= 0.0;
        Some(Surface {
            pixel: starts.pixel(index),
            point: ray.at(hit.t),
            normal: if front { normal } else { -normal },
            front,
            arriving: ray.direction,
            primitive: hit.primitive,
        })
    };
    let indices = (0..starts.rays.len()).into_par_iter();
    indices.filter_map(surface).flat_map_iter(|surface| make(&surface)).collect()
}

/// Cosine-distributed, unbounded.
pub(super) fn diffuse(scene: &RayScene<'_>, starts: &Starts, tag: u64) -> Vec<(Pixel, Ray)> {
    each_hit(scene, starts, |surface| {
        let direction = Stream::new(scene.seed, tag, u64::from(surface.pixel)).cosine(surface.normal);
        [(surface.pixel, surface.leave(scene, direction))]
    })
}

/// Cosine-distributed, bounded.
pub(super) fn ambient_occlusion(scene: &RayScene<'_>, primary: &Starts) -> Vec<(Pixel, Ray)> {
    let t_max = (AO_LENGTH_DIAGONALS * scene.truth.diagonal()) as f32;
    let bounded = |(pixel, ray): (Pixel, Ray)| (pixel, Ray { t_max, ..ray });
    diffuse(scene, primary, 2).into_iter().map(bounded).collect()
}

/// To one point outside of the bounds (DIRT, section 5.2) and one inside: from a closed room nothing reaches the first.
/// Surfaces that face away from a point send no ray to it.
pub(super) fn visibility(scene: &RayScene<'_>, primary: &Starts) -> Vec<(Pixel, Ray)> {
    let geometry = scene.truth.geometry();
    let (outside, inside) = (geometry.outer_light(), inner_light(geometry));
    let targets = match scene.parameters.visibility_target {
        Target::Outside => vec![outside],
        Target::Inside => vec![inside],
        Target::Both => vec![outside, inside],
    };
    each_hit(scene, primary, |surface| {
        let ray = |target| towards(surface.point, surface.normal, target, scene.truth.diagonal());
        let rays = targets.iter().filter_map(|target| ray(*target));
        rays.map(|ray| (surface.pixel, ray)).collect::<Vec<_>>()
    })
}

/// Mirrored, off mirrors alone; a scene without any is a mirror everywhere.
pub(super) fn specular(scene: &RayScene<'_>, primary: &Starts) -> Vec<(Pixel, Ray)> {
    let everywhere = !scene.mirrors.contains(&true);
    each_hit(scene, primary, |surface| {
        let mirrors = everywhere || scene.mirrors.get(surface.primitive as usize).is_some_and(|mirror| *mirror);
        mirrors.then(|| (surface.pixel, surface.leave(scene, reflect(surface.arriving, surface.normal))))
    })
}

/// Mirrored at microfacets.
pub(super) fn glossy(scene: &RayScene<'_>, starts: &Starts, tag: u64) -> Vec<(Pixel, Ray)> {
    let alpha = scene.parameters.glossy_roughness;
    each_hit(scene, starts, |surface| {
        let mut stream = Stream::new(scene.seed, tag, u64::from(surface.pixel));
        let mut facets = (0..GLOSSY_TRIES).map(|_| reflect(surface.arriving, stream.ggx(surface.normal, alpha)));
        // A facet may send the ray into the surface; seen at a grazing angle, many do.
        let direction = facets.find(|direction| direction.dot(surface.normal) > 1e-3);
        let direction = direction.unwrap_or_else(|| reflect(surface.arriving, surface.normal));
        [(surface.pixel, surface.leave(scene, direction))]
    })
}

/// Facets tried before a glossy ray is a mirrored one.
const GLOSSY_TRIES: usize = 16;

/// Bent into solids, where the front of a surface is seen. Whether there is a solid behind it, `tell` the truth: the next
/// surface must be seen from behind.
pub(super) fn refraction<E>(
    scene: &RayScene<'_>,
    primary: &Starts,
    tell: impl FnOnce(Vec<(Pixel, Ray)>) -> Result<Starts, E>,
) -> Result<Vec<(Pixel, Ray)>, E> {
    let index = scene.parameters.refractive_index;
    let entering = each_hit(scene, primary, |surface| {
        let direction = refract(surface.arriving, surface.normal, index).filter(|_| surface.front);
        direction.map(|direction| (surface.pixel, surface.leave(scene, direction)))
    });
    let told = tell(entering)?;
    let kept = each_hit(scene, &told, |surface| (!surface.front).then_some(surface.pixel));
    // At most one ray a pixel, both lists in the order of pixels.
    let mut kept = kept.into_iter().peekable();
    let rays = (0..told.rays.len()).map(|index| (told.pixel(index), told.rays[index]));
    Ok(rays.filter(|(pixel, _)| kept.next_if_eq(pixel).is_some()).collect())
}

/// Several a pixel, evenly spread over the hemisphere.
pub(super) fn pixel_random(scene: &RayScene<'_>, primary: &Starts) -> Vec<(Pixel, Ray)> {
    let count = u64::from(scene.parameters.pixel_random_count);
    each_hit(scene, primary, |surface| {
        let ray = |copy: u64| {
            let index = u64::from(surface.pixel) * count + copy;
            let direction = Stream::new(scene.seed, 4, index).hemisphere(surface.normal);
            (surface.pixel, surface.leave(scene, direction))
        };
        (0..count).map(ray).collect::<Vec<_>>()
    })
}

/// Anywhere in the bounds, in any direction: as many as the image has pixels.
pub(super) fn random(scene: &RayScene<'_>) -> Vec<(Pixel, Ray)> {
    let geometry = scene.truth.geometry();
    let (low, high) = (geometry.bounds_min.as_dvec3(), geometry.bounds_max.as_dvec3());
    let ray = |pixel: Pixel| {
        let mut stream = Stream::new(scene.seed, 5, u64::from(pixel));
        let place = DVec3::new(stream.unit(), stream.unit(), stream.unit());
        (pixel, unbounded(low + (high - low) * place, stream.sphere()))
    };
    (0..scene.image[0] * scene.image[1]).into_par_iter().map(ray).collect()
}
