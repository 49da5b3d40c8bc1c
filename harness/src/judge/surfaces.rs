//! Surfaces: what shading would be given, against the scene in f64.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use tracebench_api::{Hit, NO_PRIMITIVE, Query, Surface, SurfaceStatus};

use super::{Class, Judge, JudgeError, Rule};
use crate::results::{Percentiles, SurfaceJudgement};
use crate::statistics::wilson;
use crate::truth::Ray64;

/// Angle by which a normal may be off and still be right, degrees: far above f32's rounding, far below what is seen.
pub const NORMAL_TOLERANCE_DEGREES: f64 = 1.0;

/// What a surface should be.
struct Reference {
    position: DVec3,
    /// None where neither truth nor tracer says which triangle it is.
    primitive: Option<u32>,
}

/// How a surface that was written compares.
#[derive(Clone, Copy)]
struct Compared {
    /// Scene units.
    position_error: f64,
    position_right: bool,
    material_right: Option<bool>,
    /// Degrees.
    normal_error: Option<f64>,
}

impl Compared {
    fn normal_right(&self) -> Option<bool> {
        self.normal_error.map(|error| error <= NORMAL_TOLERANCE_DEGREES)
    }

    fn is_right(&self) -> bool {
        self.position_right && self.material_right != Some(false) && self.normal_right() != Some(false)
    }
}

impl Judge<'_> {
    /// Judges the surfaces of hits that have been judged: of a closest-hit set those of the true hits under `footprint`,
    /// against the true hit; of an any-hit set those of rightly occluded rays, each against the hit that was answered.
    ///
    /// # Errors
    /// [`JudgeError`] if there is not one of each ray, or one that its ray's answer cannot have.
    pub fn judge_surfaces(&self, hits: &[Hit], surfaces: &[Surface]) -> Result<SurfaceJudgement, JudgeError> {
        self.check_surfaces(hits, surfaces)?;
        let is_lost = |index: usize| surfaces[index].status == SurfaceStatus::Lost as u32;
        let lost = self.unambiguous().filter(|index| is_lost(*index)).count() as u64;
        let references: Vec<(usize, Reference)> =
            self.unambiguous().filter_map(|index| Some((index, self.reference(index, &hits[index])?))).collect();
        let compared: Vec<Compared> = references
            .par_iter()
            .filter(|(index, _)| !is_lost(*index))
            .map(|(index, reference)| self.compare(reference, &surfaces[*index]))
            .collect();
        let right = compared.iter().filter(|each| each.is_right()).count() as u64;
        let judged = references.len() as u64;
        let normal_errors: Vec<f64> = compared.iter().filter_map(|each| each.normal_error).collect();
        let position_errors: Vec<f64> = compared.iter().map(|each| each.position_error).collect();
        Ok(SurfaceJudgement {
            judged,
            lost,
            agreement: (judged > 0).then(|| right as f64 / judged as f64),
            interval: wilson(right, judged),
            material: share(compared.iter().filter_map(|each| each.material_right)),
            normal: share(compared.iter().filter_map(Compared::normal_right)),
            position: share(compared.iter().map(|each| each.position_right)),
            normal_error_degrees: Percentiles::of(&normal_errors),
            position_error: Percentiles::of(&position_errors),
        })
    }

    fn check_surfaces(&self, hits: &[Hit], surfaces: &[Surface]) -> Result<(), JudgeError> {
        if surfaces.len() != hits.len() {
            return Err(JudgeError::Count { hits: surfaces.len(), rays: hits.len() });
        }
        let malformed = |(hit, surface): (&Hit, &Surface)| match SurfaceStatus::from_code(surface.status) {
            Some(SurfaceStatus::Written) => {
                !hit.is_hit() || surface.position.iter().chain(&surface.normal).any(|part| !part.is_finite())
            }
            Some(SurfaceStatus::Lost) => !hit.is_hit(),
            Some(SurfaceStatus::NoHit) => hit.is_hit(),
            None | Some(SurfaceStatus::Unwritten) => true,
        };
        let pairs = || hits.iter().zip(surfaces);
        match pairs().position(malformed) {
            None => Ok(()),
            Some(first) => Err(JudgeError::Surface {
                count: pairs().filter(|pair| malformed(*pair)).count(),
                first,
                surface: surfaces[first],
            }),
        }
    }

    fn reference(&self, index: usize, hit: &Hit) -> Option<Reference> {
        let truth = self.answers[index].hit.filter(|_| hit.is_hit())?;
        let ray = Ray64::from(&self.rays[index]);
        match self.query {
            Query::Closest => {
                if self.class(Rule::Footprint, index, hit) != Class::TrueHit {
                    return None;
                }
                // Of triangles that overlap in a plane either is right, and then that one's material.
                let in_its_place = self.names_primitives && self.names(index, truth, hit.primitive);
                let primitive = if in_its_place { hit.primitive } else { truth.primitive };
                Some(Reference { position: ray.at(truth.t), primitive: Some(primitive) })
            }
            Query::Any => Some(Reference {
                position: ray.at(f64::from(hit.t)),
                primitive: (hit.primitive != NO_PRIMITIVE).then_some(hit.primitive),
            }),
        }
    }

    fn compare(&self, reference: &Reference, surface: &Surface) -> Compared {
        let position = Vec3::from(surface.position).as_dvec3();
        let position_error = position.distance(reference.position);
        // Close to the eye a pixel shrinks below what coordinates in f32 can tell.
        let rounding = 4.0 * f64::from(f32::EPSILON) * reference.position.abs().max_element();
        let geometry = self.truth.geometry();
        let known = reference.primitive.filter(|primitive| (*primitive as usize) < geometry.triangles.len());
        let normal_error = known.and_then(|primitive| {
            let [a, b, c] = geometry.corners(primitive).map(Vec3::as_dvec3);
            let right = (b - a).cross(c - a).try_normalize()?;
            let found = Vec3::from(surface.normal).as_dvec3();
            Some(right.cross(found).length().atan2(right.dot(found)).to_degrees())
        });
        Compared {
            position_error,
            position_right: position_error <= self.footprint(reference.position).max(rounding),
            material_right: known.map(|primitive| surface.material == geometry.triangle_materials[primitive as usize]),
            normal_error,
        }
    }
}

fn share(right: impl Iterator<Item = bool>) -> Option<f64> {
    let (all, right) = right.fold((0_u64, 0_u64), |(all, count), right| (all + 1, count + u64::from(right)));
    (all > 0).then(|| right as f64 / all as f64)
}
