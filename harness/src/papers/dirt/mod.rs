//! Vardis, Vasilakis, Papaioannou: *DIRT: Deferred Image-based Ray Tracing*, HPG 2016.

#[cfg(test)]
pub(super) mod tests;

use tracebench_api::MemoryEntry;

use super::rows::{has, parameter};
use super::{Paper, paper, vvp16};
use crate::results::Row;

/// The paper.
pub(super) static PAPER: Paper = paper!(
    "dirt",
    &[("tiles", tiles), ("formula_bytes", vvp16::formula_bytes), ("ledger_bytes", vvp16::by_formula)],
    by_formula
);

/// What the ledger calls the parts of the structure that Table 3 counts. It leaves the vertex buffer out, which rasterization has,
/// and knows neither triangle setup nor copies in textures.
const IN_TABLE_3: [&str; 2] = ["depth bounds texture", "id buffer"];
/// Bytes of Table 3 a pixel of the frame: head and node of the hit buffer, three shading points, the mask.
const OF_A_PIXEL: [f64; 4] = [4.0, 32.0, 3.0 * 32.0, 2.0];

/// What Table 3 counts: depth bounds and lists as they are; a ray starts from every pixel of the frame (R_h), and each has its hit and
/// three points. Of the A-buffer what its own paper counts.
fn by_formula(row: &Row) -> Option<f64> {
    if row.tracer.name != "dirt" {
        return vvp16::by_formula(row);
    }
    let counted = |part: &&MemoryEntry| IN_TABLE_3.iter().any(|name| part.name.starts_with(name));
    let structure: u64 = row.memory.structure.iter().filter(counted).map(|part| part.used_bytes).sum();
    let pixels: f64 = row.viewpoint.frame.map(f64::from).iter().product();
    Some(structure as f64 + pixels * OF_A_PIXEL.iter().sum::<f64>())
}

/// Tiles of all views, from the viewpoint alone.
fn tiles(row: &Row) -> Option<f64> {
    let tile_size = parameter(row, "tile_size")?;
    let (views, edges) =
        if has(row, "views", "frame") { (1.0, row.viewpoint.frame) } else { (6.0, [row.viewpoint.face; 2]) };
    let of_view: f64 = edges.iter().map(|edge| (f64::from(*edge) / tile_size).ceil()).product();
    Some(views * of_view)
}
