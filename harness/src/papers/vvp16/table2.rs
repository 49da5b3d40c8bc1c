//! Bytes by Table 2, beside those of the ledger.

use crate::papers::rows::{has, integer, statistic};
use crate::results::Row;

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
pub(super) fn formula(row: &Row) -> Option<[f64; 3]> {
    let buckets = integer(row, "buckets")? as f64;
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
pub(super) fn ledger(row: &Row) -> [f64; 3] {
    PARTS.map(|names| {
        let is_of = |rest: &str| rest.is_empty() || rest.starts_with(", view");
        let own = |part: &str| names.iter().any(|name| part.strip_prefix(name).is_some_and(is_of));
        row.memory.structure.iter().filter(|part| own(&part.name)).map(|part| part.used_bytes as f64).sum()
    })
}
