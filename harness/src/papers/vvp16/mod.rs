//! Vardis, Vasilakis, Papaioannou: *A Multiview and Multilayer Approach for Interactive Ray Tracing*, I3D 2016.
//!
//! Papers that measured themselves beside its A-buffer take its formula from here.

#[cfg(test)]
pub(super) mod tests;

use super::rows::{has, parameter, statistic};
use super::{Paper, paper};
use crate::results::Row;

/// The paper.
pub(super) static PAPER: Paper = paper!(
    "vvp16",
    &[
        ("formula_bytes", formula_bytes),
        ("ledger_bytes", by_formula),
        ("ledger_bytes_of_pixels", |row| Some(ledger(row)[0])),
        ("ledger_bytes_of_ids", |row| Some(ledger(row)[1])),
        ("ledger_bytes_of_data", |row| Some(ledger(row)[2])),
        ("formula_bytes_of_pixels", |row| Some(formula(row)?[0])),
        ("formula_bytes_of_ids", |row| Some(formula(row)?[1])),
        ("formula_bytes_of_data", |row| Some(formula(row)?[2])),
    ],
    by_formula
);

/// What Table 2 counts: the words of pixels, the id buffer and the data buffer.
pub(super) fn by_formula(row: &Row) -> Option<f64> {
    (row.tracer.name == "fragment-abuffer").then(|| ledger(row).iter().sum())
}

/// The same by the formula, with the device's own counts.
pub(super) fn formula_bytes(row: &Row) -> Option<f64> {
    formula(row).map(|parts| parts.iter().sum())
}

/// Bytes of a fragment's data: normal and material.
const DATA_BYTES: f64 = 16.0;
/// What the ledger calls the parts of Table 2: m_p, m_f, data. Where one binding is too small each has a part a view.
const PARTS: [&[&str]; 3] = [
    &["depth bounds, heads and tails", "depth bounds and heads", "heads and tails", "heads", "begins and counts"],
    &["id buffer"],
    &["data buffer"],
];

/// Bytes of the pixels' words, the id buffer and the data buffer by Table 2 with the device's own counts: m_p a pixel, m_f and the
/// data a fragment; none where data is not apart, of which the table does not speak.
fn formula(row: &Row) -> Option<[f64; 3]> {
    let buckets = parameter(row, "buckets")?;
    let (of_pixel, of_fragment) = match row.tracer.parameters.get("storage")?.as_str()? {
        "s-buffer" => (8.0, 8.0),
        "ll" => (4.0, 8.0),
        "dll" => (8.0, 12.0),
        "llb" => (8.0 + 4.0 * buckets, 8.0),
        "dllb" => (8.0 + 8.0 * buckets, 12.0),
        _ => return None,
    };
    let (pixels, fragments) = (statistic(row, "pixels")?, statistic(row, "fragments")?);
    has(row, "decoupled", "on").then_some([pixels * of_pixel, fragments * of_fragment, fragments * DATA_BYTES])
}

/// Bytes used of the same parts by the ledger.
fn ledger(row: &Row) -> [f64; 3] {
    PARTS.map(|names| {
        let is_of = |rest: &str| rest.is_empty() || rest.starts_with(", view");
        let own = |part: &str| names.iter().any(|name| part.strip_prefix(name).is_some_and(is_of));
        row.memory.structure.iter().filter(|part| own(&part.name)).map(|part| part.used_bytes as f64).sum()
    })
}
