//! Pictures from rays: wavefronts of paths, shading on the host, what images are like, and how points move between frames.

mod encode;
mod image;
mod motion;
pub(crate) mod painted;
mod paths;
mod shading;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use tracebench_api::{Geometry, Hit, Query, Ray, Surface, SurfaceStatus, TraceTo, named};
use tracebench_scenes::Material;

pub(crate) use encode::encoded;
pub use encode::{animation, cut, strip};
pub use image::{
    Exposure, Image, Image8, ImageError, LinearImage, PIXELS_PER_DEGREE, beyond, error_picture, errors, likeness,
};
pub use motion::{image_flicker, motion};
pub use paths::Paths;

use crate::rays::inner_light;
use crate::truth::{Ray64, TrueHit, Truth};

/// Red, green and blue, 8 bits each.
pub type Rgb = [u8; 3];

named! {
    /// What a picture shows. `primary`, `ao` and `diffuse` take every surface for a diffuse one; `mirror` and `path` follow mirrors and
    /// what refracts.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Effect {
        /// Eye depth, near is bright: a half diagonal of the scene is half as bright as the eye's own place, a miss is black.
        Depth = "depth",
        /// Geometric normals on the side of the eye, -1 to 1 as 0 to 1 in each channel; a miss is black.
        Normals = "normals",
        /// Direct light of the point light, with its shadows.
        Primary = "primary",
        /// The share of the cosine-distributed rays of a tenth of the scene's diagonal that nothing stops.
        Ao = "ao",
        /// Direct light, seen through up to [`MOST_BOUNCES`] mirrors. In a scene without mirrors what the eye sees first is one.
        Mirror = "mirror",
        /// Direct light and that of one diffuse bounce.
        Diffuse = "diffuse",
        /// Light of up to [`MOST_BOUNCES`] bounces, with next event estimation.
        Path = "path",
    }
}

/// Most bounces of `mirror` and `path`.
pub const MOST_BOUNCES: u32 = 4;

impl Effect {
    /// Where its closest-hit waves end.
    pub fn end(self) -> TraceTo {
        if self == Self::Depth { TraceTo::Hit } else { TraceTo::Surface }
    }

    /// Whether any-hit rays are among its rays: its images then show light, which FLIP compares; depths and normals are none.
    pub fn asks_any(self) -> bool {
        !matches!(self, Self::Depth | Self::Normals)
    }

    /// Bounces after what the eye sees.
    fn bounces(self) -> u32 {
        match self {
            Self::Mirror | Self::Path => MOST_BOUNCES,
            Self::Diffuse => 1,
            _ => 0,
        }
    }
}

/// How a surface sends light on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Evenly to all sides.
    Lambert,
    /// A perfect mirror.
    Mirror,
    /// Bent by Snell's law with this refractive index behind its front, nothing mirrored; mirrored where nothing can leave.
    Refracting(f64),
}

/// A material as it is shaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finish {
    /// How.
    pub kind: Kind,
    /// The share of light that it sends on, by channel.
    pub colour: Vec3,
}

/// What all frames have in common. Made of the first one, so that nothing but what moves changes.
#[derive(Clone, Debug)]
pub struct Stage {
    /// By material.
    pub finishes: Vec<Finish>,
    /// Where the point light is: the inside target of the ray set `visibility`.
    pub light: DVec3,
    /// Radiant intensity of the point light, the same in all channels: a white surface square to it has a radiance of 1 at a quarter
    /// of the diagonal.
    pub intensity: f64,
    /// Radiance of the sky, wherever a ray of light leaves the scene. In `ao` it counts as 1.
    pub sky: Vec3,
    /// The diagonal of the first frame's bounds, scene units: what the rays' offsets are shares of.
    pub diagonal: f64,
    /// Whether what the eye sees first is a mirror in `mirror`: there is none.
    pub mirror_first: bool,
    /// What shading ignores or assumes, a sentence each; to be said once.
    pub notes: Vec<String>,
}

/// Radiance of the sky.
const SKY: Vec3 = Vec3::new(0.30, 0.36, 0.48);
/// Diagonals at which the light gives a white surface a radiance of 1.
const LIT_DIAGONALS: f64 = 0.25;

impl Stage {
    /// Of a scene's materials and its first frame.
    pub fn new(materials: &[Material], first: &Geometry) -> Self {
        let finish = |material: &Material| {
            let kind = match material.refractive_index {
                Some(index) => Kind::Refracting(f64::from(index)),
                None if material.is_mirror() => Kind::Mirror,
                None => Kind::Lambert,
            };
            Finish { kind, colour: material.base_color.into() }
        };
        let finishes: Vec<Finish> = materials.iter().map(finish).collect();
        let diagonal = first.diagonal();
        let is_lambert = |finish: &Finish| finish.kind == Kind::Lambert;
        let mirror_first = finishes.iter().all(is_lambert);
        let glossy = |(finish, material): &(&Finish, &Material)| {
            is_lambert(finish) && (material.metallic > 0.0 || material.roughness < 1.0)
        };
        let mut notes = vec!["textures and emission are ignored, normals are flat".to_owned()];
        let count = finishes.iter().zip(materials).filter(glossy).count();
        if count > 0 {
            notes.push(format!("gloss is ignored: {count} materials that have some are shaded as diffuse ones"));
        }
        if mirror_first {
            notes.push("no material mirrors or refracts: in mirror what the eye sees first is one".to_owned());
        }
        Self {
            finishes,
            light: inner_light(first),
            intensity: std::f64::consts::PI * (LIT_DIAGONALS * diagonal).powi(2),
            sky: SKY,
            diagonal,
            mirror_first,
            notes,
        }
    }
}

/// What is known of one ray: by the truth, or by a tracer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// Nothing was hit, for whatever reason.
    Miss,
    /// Something is between the ends of an any-hit ray.
    Occluded,
    /// A hit.
    Hit {
        /// Ray parameter, scene units.
        t: f64,
        /// Where, scene units.
        position: DVec3,
        /// Unit geometric normal, of either side.
        normal: DVec3,
        /// Index of the material.
        material: u32,
    },
    /// A hit without a surface: of a wave that ends at hits, or one that the tracer lost. Where a surface is shaded it is black.
    Lost {
        /// Ray parameter, scene units.
        t: f64,
    },
}

/// Rays that are traced at once.
#[derive(Clone, Debug)]
pub struct Wave {
    /// The same for the same rays of all tracers, also where an earlier wave has none: twice the bounce, one more for any-hit rays.
    pub number: usize,
    /// The rays, in the order of their paths.
    pub rays: Arc<Vec<Ray>>,
    /// The path that each ray belongs to.
    pub paths: Arc<Vec<u32>>,
    /// What is asked.
    pub query: Query,
    /// How far they are traced.
    pub end: TraceTo,
}

impl Wave {
    /// What people call the wave with a number: `eye`, `bounce 1`, and after each `shadow 0`, `shadow 1`.
    pub fn name_of(number: usize) -> String {
        match (number, number / 2) {
            (0, _) => "eye".to_owned(),
            (odd, bounce) if odd % 2 == 1 => format!("shadow {bounce}"),
            (_, bounce) => format!("bounce {bounce}"),
        }
    }

    /// Answers from nearest hits that are known already, by ray.
    pub fn answers_of_hits(&self, truth: &Truth, hit: impl Fn(usize) -> Option<TrueHit> + Sync) -> Vec<Answer> {
        let answer = |ray: usize| match (hit(ray), self.query) {
            (None, _) => Answer::Miss,
            (Some(_), Query::Any) => Answer::Occluded,
            (Some(TrueHit { t, primitive }), Query::Closest) => Answer::Hit {
                t,
                position: Ray64::from(&self.rays[ray]).at(t),
                normal: truth.normal(primitive),
                material: truth.geometry().triangle_materials[primitive as usize],
            },
        };
        (0..self.rays.len()).into_par_iter().map(answer).collect()
    }

    /// A tracer's answers: its hits, and its surfaces where the wave ends there. `None` where there is not one of each ray.
    pub fn answers_of_tracer(&self, hits: &[Hit], surfaces: Option<&[Surface]>) -> Option<Vec<Answer>> {
        let all = surfaces.is_none_or(|surfaces| surfaces.len() == hits.len()) && hits.len() == self.rays.len();
        let answer = |(ray, hit): (usize, &Hit)| match (hit.is_hit(), self.query) {
            (false, _) => Answer::Miss,
            (true, Query::Any) => Answer::Occluded,
            (true, Query::Closest) => {
                let t = f64::from(hit.t);
                let written = SurfaceStatus::Written as u32;
                match surfaces.map(|surfaces| surfaces[ray]).filter(|surface| surface.status == written) {
                    None => Answer::Lost { t },
                    Some(surface) => Answer::Hit {
                        t,
                        position: Vec3::from(surface.position).as_dvec3(),
                        normal: Vec3::from(surface.normal).as_dvec3(),
                        material: surface.material,
                    },
                }
            }
        };
        all.then(|| hits.par_iter().enumerate().map(|(ray, hit)| answer((ray, hit))).collect())
    }
}
