//! Vardis, Vasilakis, Papaioannou: *A Multiview and Multilayer Approach for Interactive Ray Tracing*, I3D 2016.
//!
//! Papers that measured themselves beside its A-buffer take its formula from here.

mod table2;
#[cfg(test)]
pub(super) mod tests;

use super::{Paper, paper};
use crate::results::Row;

/// The paper.
pub(super) static PAPER: Paper = paper!(
    "vvp16",
    &[
        ("formula_bytes", formula_bytes),
        ("ledger_bytes", by_formula),
        ("ledger_bytes_of_pixels", |row| Some(table2::ledger(row)[0])),
        ("ledger_bytes_of_ids", |row| Some(table2::ledger(row)[1])),
        ("ledger_bytes_of_data", |row| Some(table2::ledger(row)[2])),
        ("formula_bytes_of_pixels", |row| Some(table2::formula(row)?[0])),
        ("formula_bytes_of_ids", |row| Some(table2::formula(row)?[1])),
        ("formula_bytes_of_data", |row| Some(table2::formula(row)?[2])),
    ],
    by_formula
);

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
