//! Vardis, Vasilakis, Papaioannou: *A Multiview and Multilayer Approach for Interactive Ray Tracing*, I3D 2016.
//!
//! Papers that measured themselves beside its A-buffer take its formula from here.

mod table2;
#[cfg(test)]
pub(super) mod tests;

use std::sync::LazyLock;

use super::{Paper, embedded};
use crate::results::Row;

/// The paper.
pub(super) static PAPER: Paper = Paper {
    name: "vvp16",
    experiments: LazyLock::new(|| embedded(include_str!("experiments.json"))),
    few_rays: &["diffuse", "pixel-random"],
    pages: LazyLock::new(|| embedded(include_str!("pages.json"))),
    at_paper: None,
    published: include_str!("published.json"),
    claims_table: "vvp16-claims",
    claims: include_str!("claims.json"),
    told: LazyLock::new(|| embedded(include_str!("quantities.json"))),
    figures: &[
        ("formula_bytes", formula_bytes),
        ("ledger_bytes", by_formula),
        ("ledger_bytes_of_pixels", |row| Some(table2::ledger(row)[0])),
        ("ledger_bytes_of_ids", |row| Some(table2::ledger(row)[1])),
        ("ledger_bytes_of_data", |row| Some(table2::ledger(row)[2])),
        ("formula_bytes_of_pixels", |row| Some(table2::formula(row)?[0])),
        ("formula_bytes_of_ids", |row| Some(table2::formula(row)?[1])),
        ("formula_bytes_of_data", |row| Some(table2::formula(row)?[2])),
    ],
    counts: &[
        ("references", "references"),
        ("fragments", "fragments"),
        ("covered_pixels", "covered pixels"),
        ("average_layers", "layers of a covered pixel"),
        ("maximum_layers", "most layers"),
    ],
    // Its data are in the structure.
    of_a_trace: &[],
    by_formula,
};

/// What Table 2 counts: the words of pixels, the id buffer and the data buffer.
pub(super) fn by_formula(row: &Row) -> Option<f64> {
    (row.tracer.name == ABUFFER).then(|| table2::ledger(row).iter().sum())
}

/// The same by the formula, with the device's own counts.
pub(super) fn formula_bytes(row: &Row) -> Option<f64> {
    table2::formula(row).map(|parts| parts.iter().sum())
}

/// Its tracer.
pub(super) const ABUFFER: &str = "fragment-abuffer";
