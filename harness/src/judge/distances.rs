//! How far told hits are from the piece of mesh that is truly hit: grazing rays stretch t, and not this.

use rayon::prelude::*;
use tracebench_api::{Hit, Projection};

use super::Judge;
use crate::results::{Percentiles, PieceDistance, SurfaceDistance};
use crate::truth::Ray64;

/// Texels of the common size along the longest edge of the scene's bounds.
pub const COMMON_TEXELS: f64 = 1280.0;

/// Pieces that are distinguished, those with the most rays.
pub const MAX_PIECES: usize = 16;

/// A ray with a true hit: the piece that it lies on, and how far from it the told one is; `None` for a miss.
type Measured = (u32, Option<f64>);

impl Judge<'_> {
    pub(super) fn surface_distance(&self, hits: &[Hit]) -> SurfaceDistance {
        let measured: Vec<Measured> =
            self.unambiguous().filter_map(|index| self.measured(index, &hits[index])).collect();
        let geometry = self.truth.geometry();
        let extent = (geometry.bounds_max - geometry.bounds_min).as_dvec3();
        let common_texel = extent.max_element() / COMMON_TEXELS;
        let own_texel = self.own_texel();
        let within = |texel: f64| {
            let right =
                measured.iter().filter(|(_, distance)| distance.is_some_and(|distance| distance <= texel)).count();
            (!measured.is_empty()).then(|| right as f64 / measured.len() as f64)
        };
        let told: Vec<f64> = measured.iter().filter_map(|(_, distance)| *distance).collect();
        SurfaceDistance {
            rays: measured.len() as u64,
            common_texel,
            within_common_texel: within(common_texel),
            own_texel,
            within_own_texel: own_texel.and_then(within),
            distance: Percentiles::of(&told),
            pieces: self.by_piece(&measured, common_texel, own_texel),
        }
    }

    fn measured(&self, index: usize, hit: &Hit) -> Option<Measured> {
        let truth = self.answers[index].hit?;
        let piece = self.truth.pieces().of_triangle(truth.primitive);
        let distance = hit.is_hit().then(|| {
            let ray = Ray64::from(&self.rays[index]);
            let told = ray.at(f64::from(hit.t));
            // The true hit lies on the piece, so nothing farther need be looked at.
            let to_truth = told.distance(ray.at(truth.t));
            self.truth.nearest_of_piece(told, to_truth, piece).map_or(to_truth, |nearest| nearest.distance)
        });
        Some((piece, distance))
    }

    /// The greatest edge of a texel of the images along axes, where the method has such.
    fn own_texel(&self) -> Option<f64> {
        let edges = self.samplings.iter().filter_map(|sampling| match sampling.projection {
            Projection::Orthographic(image) => Some(image.texel.max_element()),
            Projection::Perspective(_) => None,
        });
        edges.max_by(f64::total_cmp)
    }

    fn by_piece(&self, measured: &[Measured], common_texel: f64, own_texel: Option<f64>) -> Vec<PieceDistance> {
        let pieces = self.truth.pieces().all();
        let row = |(number, piece): (usize, &crate::truth::Piece)| PieceDistance {
            piece: number as u32,
            first_triangle: piece.first_triangle,
            triangles: piece.triangles,
            open: piece.open,
            mean_thickness: piece.mean_thickness(),
            rays: 0,
            within_common_texel_rays: 0,
            within_own_texel_rays: own_texel.map(|_| 0),
        };
        let mut rows: Vec<PieceDistance> = pieces.iter().enumerate().map(row).collect();
        for (piece, distance) in measured {
            let row = &mut rows[*piece as usize];
            let within = |texel: f64| u64::from(distance.is_some_and(|distance| distance <= texel));
            row.rays += 1;
            row.within_common_texel_rays += within(common_texel);
            row.within_own_texel_rays =
                row.within_own_texel_rays.zip(own_texel).map(|(rays, texel)| rays + within(texel));
        }
        rows.retain(|row| row.rays > 0);
        rows.sort_by_key(|row| (std::cmp::Reverse(row.rays), row.piece));
        rows.truncate(MAX_PIECES);
        rows
    }
}
