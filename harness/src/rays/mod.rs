//! Ray sets: made from the viewpoint and from ground-truth hits, seeded, on all cores, the same on every machine.

mod centres;
mod eye;
mod hostile;
mod order;
mod parameters;
pub(crate) mod sampling;
mod saved;
mod surface;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::DVec3;
use tracebench_api::{Geometry, Query, Ray, Viewpoint};
use tracebench_scenes::CameraPath;

pub use centres::{BETWEEN_SAMPLES, between_samples, shared_centres};
pub use eye::primary_rays;
pub(crate) use eye::{image_view, ray_through};
pub use order::TILE;
pub use parameters::{Order, RayParameters, Target, check_ray_parameters, default_parameters, ray_parameters};
pub use saved::KnownRays;

use crate::truth::{Answer, Truth, TruthError};

/// Part of the scene's diagonal by which an origin is lifted off its surface, along the geometric normal, to the side on
/// which the ray leaves.
pub const ORIGIN_OFFSET_DIAGONALS: f64 = 1e-5;

/// Ulps of the hit's largest coordinate that are added to the offset, so that f32 rounding of the origin cannot undo it
/// in scenes far from the coordinates' origin.
pub const ORIGIN_OFFSET_ULPS: f64 = 16.0;

/// Length of `ao` rays, in scene diagonals.
pub const AO_LENGTH_DIAGONALS: f64 = 0.1;

/// Most rays of one set: some 200 bytes of memory each.
pub const MAX_RAYS: u64 = 1 << 24;

/// The kinds of ray sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Primary,
    Diffuse,
    AmbientOcclusion,
    Visibility,
    Specular,
    Glossy,
    /// So many bounces, from 2 on.
    GlossyBounces(u32),
    SecondBounce,
    Refraction,
    Random,
    PixelRandom,
    Stereo,
    Temporal,
    Lens,
    LightField,
    Hostile,
    Given,
    /// By their place among those that were kept.
    Saved(usize),
}

/// A ray set as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RaySet {
    /// Stable name.
    pub name: &'static str,
    /// What is asked of its rays.
    pub query: Query,
    /// What it is, in one line.
    pub summary: &'static str,
    /// Its parameters beside `order`, by name.
    pub parameters: &'static [&'static str],
    kind: Kind,
}

const fn set(name: &'static str, kind: Kind, parameters: &'static [&'static str], summary: &'static str) -> RaySet {
    let query = if matches!(kind, Kind::AmbientOcclusion | Kind::Visibility) { Query::Any } else { Query::Closest };
    RaySet { name, query, summary, parameters, kind }
}

impl RaySet {
    /// Rays that were not made here.
    pub const fn given(name: &'static str, query: Query) -> Self {
        Self { name, query, summary: "given", parameters: &[], kind: Kind::Given }
    }

    /// Whether its rays are made to be ambiguous.
    pub fn is_hostile(&self) -> bool {
        self.kind == Kind::Hostile
    }
}

/// Rays at which tests break: asked for by name alone, as many of them are ambiguous.
pub const HOSTILE: RaySet = set(
    "hostile",
    Kind::Hostile,
    &[],
    "through vertices and borders, along edges and axes, with -0.0 and denormals, of no length, from far away and on surfaces",
);

/// Every ray set.
pub const RAY_SETS: &[RaySet] = &[
    set("primary", Kind::Primary, &[], "from the eye through the centre of every pixel"),
    set(
        "diffuse",
        Kind::Diffuse,
        &[],
        "from every primary hit, cosine-distributed about the geometric normal, unbounded",
    ),
    set(
        "ao",
        Kind::AmbientOcclusion,
        &[],
        "from every primary hit, cosine-distributed about the geometric normal, a tenth of the scene's diagonal long",
    ),
    set(
        "visibility",
        Kind::Visibility,
        &["visibility_target"],
        "from every primary hit to a point outside of the scene's bounds and to one inside",
    ),
    set(
        "specular",
        Kind::Specular,
        &[],
        "mirrored from every primary hit on a mirror, or from all in a scene without mirrors",
    ),
    set("glossy", Kind::Glossy, &["glossy_roughness"], "from every primary hit, mirrored at GGX microfacets"),
    set(
        "glossy2",
        Kind::GlossyBounces(2),
        &["glossy_roughness"],
        "second bounces: from every hit of glossy, mirrored at GGX microfacets",
    ),
    set(
        "glossy3",
        Kind::GlossyBounces(3),
        &["glossy_roughness"],
        "third bounces: from every hit of glossy2, mirrored at GGX microfacets",
    ),
    set("bounce2", Kind::SecondBounce, &[], "from every hit of diffuse, cosine-distributed about the geometric normal"),
    set(
        "refraction",
        Kind::Refraction,
        &["refractive_index"],
        "bent into the solid at every primary hit, where the way on leads out of one",
    ),
    set("random", Kind::Random, &[], "from anywhere in the scene's bounds in any direction, as many as pixels"),
    set(
        "pixel-random",
        Kind::PixelRandom,
        &["pixel_random_count"],
        "several from every primary hit, evenly spread over the hemisphere (20, as in VVP16's Figure 12)",
    ),
    set("stereo", Kind::Stereo, &["stereo_offset"], "primary rays of an eye to the right of the viewpoint's"),
    set("temporal", Kind::Temporal, &["temporal_shift_s"], "primary rays of the camera a little later on its path"),
    set(
        "lens",
        Kind::Lens,
        &["lens_count", "lens_aperture", "lens_focus"],
        "from all over a thin lens through the points in focus that the pixels show, one a pixel or several",
    ),
    set(
        "light-field",
        Kind::LightField,
        &["light_field_cameras", "light_field_width"],
        "primary rays of a square of parallel cameras, each with its part of the image",
    ),
];

/// The pixel that a ray started from, in scanline order.
pub type Pixel = u32;

/// What rays are made from.
#[derive(Clone, Copy)]
pub struct RayScene<'a> {
    /// The scene.
    pub truth: &'a Truth,
    /// The viewpoint.
    pub viewpoint: &'a Viewpoint,
    /// The walk through the scene, if there is one.
    pub path: Option<&'a CameraPath>,
    /// For every triangle whether it is a mirror.
    pub mirrors: &'a [bool],
    /// Width and height of the image from whose pixels rays start.
    pub image: [u32; 2],
    /// Seed.
    pub seed: u64,
    /// What is said about the sets.
    pub parameters: &'a RayParameters,
}

/// Rays with their truth, from whose hits other rays start.
#[derive(Clone)]
pub struct Starts {
    /// The rays, in scanline order.
    pub rays: Arc<Vec<Ray>>,
    /// Their truth.
    pub answers: Arc<Vec<Answer>>,
    /// The pixels that they started from; `None` for one ray a pixel.
    pixels: Option<Vec<Pixel>>,
}

impl Starts {
    /// The primary rays of an image with their truth.
    pub fn primary(rays: Arc<Vec<Ray>>, answers: Arc<Vec<Answer>>) -> Self {
        Self { rays, answers, pixels: None }
    }

    fn pixel(&self, index: usize) -> Pixel {
        self.pixels.as_ref().map_or(index as Pixel, |pixels| pixels[index])
    }
}

/// Rays of a set, with the pixels that they started from.
#[derive(Clone, Debug)]
pub struct GeneratedRays {
    /// The rays.
    pub rays: Arc<Vec<Ray>>,
    /// Of every ray the pixel in scanline order; several rays may have one.
    pub pixels: Arc<Vec<Pixel>>,
}

/// Why there are no rays.
#[derive(Debug, thiserror::Error)]
pub enum RayError {
    /// Rays that were read are of another scene.
    #[error("{0}")]
    OtherScene(String),
    /// No ray starts from this viewpoint.
    #[error("the ray set is empty: {0}")]
    Empty(&'static str),
    /// More rays than can be held.
    #[error(
        "the ray set would have {rays} rays, and at most {MAX_RAYS} are supported: turn down --size or --set {parameter}"
    )]
    TooMany {
        /// How many.
        rays: u64,
        /// What makes them many.
        parameter: &'static str,
    },
    /// The truth that rays start from failed.
    #[error(transparent)]
    Truth(#[from] TruthError),
}

/// Makes one set in the order that the parameters ask for. `primary` are the image's primary rays with their truth; `tell`
/// tells the truth of rays that others start from.
///
/// # Errors
/// [`RayError`] as its variants say.
pub fn make(
    set: &RaySet,
    scene: &RayScene<'_>,
    primary: &Starts,
    tell: impl Fn(&Arc<Vec<Ray>>) -> Result<Vec<Answer>, TruthError>,
) -> Result<GeneratedRays, RayError> {
    if let Some(saved) = set.saved() {
        return saved.of_scene(scene.truth);
    }
    let order = scene.parameters.order;
    if set.kind == Kind::Primary && order == Order::Scanline {
        let pixels = Arc::new((0..primary.rays.len() as Pixel).collect());
        return Ok(GeneratedRays { rays: Arc::clone(&primary.rays), pixels });
    }
    let several = match set.kind {
        Kind::PixelRandom => Some((scene.parameters.pixel_random_count, "rays.pixel_random_count")),
        Kind::Lens => Some((scene.parameters.lens_count, "rays.lens_count")),
        _ => None,
    };
    if let Some((count, parameter)) = several {
        let rays = primary.rays.len() as u64 * u64::from(count);
        if rays > MAX_RAYS {
            return Err(RayError::TooMany { rays, parameter });
        }
    }
    let told = |made: Vec<(Pixel, Ray)>| -> Result<Starts, TruthError> {
        let (pixels, rays): (Vec<Pixel>, Vec<Ray>) = made.into_iter().unzip();
        let rays = Arc::new(rays);
        let answers = Arc::new(tell(&rays)?);
        Ok(Starts { rays, answers, pixels: Some(pixels) })
    };
    let made = match set.kind {
        Kind::Primary => eye::primary(scene),
        Kind::Diffuse => surface::diffuse(scene, primary, 1),
        Kind::AmbientOcclusion => surface::ambient_occlusion(scene, primary),
        Kind::Visibility => surface::visibility(scene, primary),
        Kind::Specular => surface::specular(scene, primary),
        Kind::Glossy => surface::glossy(scene, primary, GLOSSY_TAGS[0]),
        Kind::GlossyBounces(bounces) => {
            let mut made = surface::glossy(scene, primary, GLOSSY_TAGS[0]);
            for tag in &GLOSSY_TAGS[1..bounces as usize] {
                made = surface::glossy(scene, &told(made)?, *tag);
            }
            made
        }
        Kind::SecondBounce => surface::diffuse(scene, &told(surface::diffuse(scene, primary, 1))?, 6),
        Kind::Refraction => surface::refraction(scene, primary, told)?,
        Kind::Random => surface::random(scene),
        Kind::PixelRandom => surface::pixel_random(scene, primary),
        Kind::Stereo => eye::stereo(scene),
        Kind::Temporal => eye::temporal(scene),
        Kind::Lens => eye::lens(scene, primary),
        Kind::LightField => eye::light_field(scene),
        Kind::Hostile => hostile::hostile(scene),
        // Their owner has them.
        Kind::Given | Kind::Saved(_) => Vec::new(),
    };
    if made.is_empty() {
        return Err(RayError::Empty(why_empty(set.kind, primary)));
    }
    let (pixels, rays) = order::arrange(order, scene.image, scene.seed, made);
    Ok(GeneratedRays { rays: Arc::new(rays), pixels: Arc::new(pixels) })
}

/// Tags of the streams of glossy rays, bounce by bounce.
const GLOSSY_TAGS: [u64; 3] = [3, 11, 12];

fn why_empty(kind: Kind, primary: &Starts) -> &'static str {
    if primary.answers.iter().all(|answer| answer.hit.is_none()) {
        return "no primary ray hits the scene from this viewpoint";
    }
    match kind {
        Kind::Visibility => "every surface in sight faces away from the target",
        Kind::Specular => "no primary ray hits a mirror from this viewpoint",
        Kind::SecondBounce => "no diffuse ray hits the scene from this viewpoint",
        Kind::GlossyBounces(_) => "no glossy ray of the bounce before hits the scene from this viewpoint",
        Kind::Refraction => "no primary ray enters a solid, a closed surface seen from outside, from this viewpoint",
        _ => "nothing starts a ray",
    }
}

/// An endless ray that leaves a surface on the side of its direction.
pub(crate) fn leave(point: DVec3, normal: DVec3, direction: DVec3, diagonal: f64) -> Ray {
    let side = if direction.dot(normal) < 0.0 { -normal } else { normal };
    unbounded(lift(point, side, diagonal), direction)
}

/// A ray that leaves a surface on the side of its normal and ends at a target; `None` where the surface faces away from it.
pub(crate) fn towards(point: DVec3, normal: DVec3, target: DVec3, diagonal: f64) -> Option<Ray> {
    let ray = leave(point, normal, normal, diagonal);
    let way = target - DVec3::from(ray.origin.map(f64::from));
    let direction = way.try_normalize().filter(|direction| direction.dot(normal) > 0.0)?;
    Some(Ray { direction: direction.as_vec3().into(), t_max: way.length() as f32, ..ray })
}

/// The inner target of `visibility`: in the middle of the bounds, high up.
pub(crate) fn inner_light(geometry: &Geometry) -> DVec3 {
    let (low, high) = (geometry.bounds_min.as_dvec3(), geometry.bounds_max.as_dvec3());
    low + (high - low) * DVec3::new(0.5, 0.8, 0.5)
}

/// A ray without an end.
pub(crate) fn unbounded(origin: DVec3, direction: DVec3) -> Ray {
    Ray { origin: origin.as_vec3().into(), t_min: 0.0, direction: direction.as_vec3().into(), t_max: Ray::UNBOUNDED }
}

/// Lifts a point off its surface.
pub(crate) fn lift(point: DVec3, side: DVec3, diagonal: f64) -> DVec3 {
    let largest = point.abs().max_element() as f32;
    let ulp = f64::from(largest.next_up() - largest);
    point + side * (ORIGIN_OFFSET_DIAGONALS * diagonal + ORIGIN_OFFSET_ULPS * ulp)
}
