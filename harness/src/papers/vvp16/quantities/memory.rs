//! Bytes by Table 2, beside those of the ledger.

use crate::papers::Scope;
use crate::papers::quantity::{Quantity, farthest_from_one, of_scene};
use crate::papers::rows::{SceneRows, has, integer, statistic};
use crate::papers::vvp16::{ABUFFER, PAPER, row};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("abuffer_bytes_over_formula", "", bytes_over_formula),
    of_scene("largest_without_buckets_over_least_with", "", largest_without_buckets_over_least_with),
    of_scene("dllb_beyond_llb_over_links", "", dllb_beyond_llb_over_links),
    of_scene("dllb_pixel_bytes_over_textures", "", dllb_pixel_bytes_over_textures),
    of_scene("dllb_id_node_bytes", "bytes", dllb_id_node_bytes),
];

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
pub(in crate::papers::vvp16) fn formula(row: &Row) -> Option<[f64; 3]> {
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
pub(in crate::papers::vvp16) fn ledger(row: &Row) -> [f64; 3] {
    PARTS.map(|names| {
        let is_of = |rest: &str| rest.is_empty() || rest.starts_with(", view");
        let own = |part: &str| names.iter().any(|name| part.strip_prefix(name).is_some_and(is_of));
        row.memory.structure.iter().filter(|part| own(&part.name)).map(|part| part.used_bytes as f64).sum()
    })
}

/// Bytes of all three parts.
fn parts(row: &Row) -> f64 {
    ledger(row).iter().sum()
}

/// Bytes of the ledger over those of the formula, of all rows that which lies farthest from 1.
pub(in crate::papers) fn bytes_over_formula(scene: &SceneRows<'_>) -> Option<f64> {
    let ratio = |row: &Row| Some(parts(row) / formula(row)?.iter().sum::<f64>());
    farthest_from_one(scene.of_tracer(ABUFFER).filter_map(ratio))
}

fn with<'a>(scene: &SceneRows<'a>, storage: &str, buckets: &str) -> Option<&'a Row> {
    row(scene, &[("storage", storage), ("buckets", buckets)])
}

/// Bytes of the largest storage without buckets over those of the smallest with them, at B = 4.
fn largest_without_buckets_over_least_with(scene: &SceneRows<'_>) -> Option<f64> {
    let bytes = |storage: &str| PAPER.bytes(with(scene, storage, "4")?, Scope::Structure);
    let without = bytes("s-buffer")?.max(bytes("ll")?).max(bytes("dll")?);
    Some(without / bytes("llb")?.min(bytes("dllb")?))
}

/// What dllb takes beyond llb, over a link of 4 bytes a bucket and a fragment, at B = 4.
fn dllb_beyond_llb_over_links(scene: &SceneRows<'_>) -> Option<f64> {
    let (one_way, both) = (with(scene, "llb", "4")?, with(scene, "dllb", "4")?);
    let links = 4.0 * statistic(both, "pixels")? + statistic(both, "fragments")?;
    Some((parts(both) - parts(one_way)) / (4.0 * links))
}

/// dllb at every B.
fn dllb<'a>(scene: &SceneRows<'a>) -> impl Iterator<Item = &'a Row> {
    scene.of_tracer(ABUFFER).filter(|row| has(row, "storage", "dllb"))
}

/// Bytes a pixel of dllb's depth bounds, heads and tails over 2 + 2B textures of 32 bits, over B that which lies farthest from 1.
fn dllb_pixel_bytes_over_textures(scene: &SceneRows<'_>) -> Option<f64> {
    let ratio = |row: &Row| {
        let textures = 2.0 + 2.0 * integer(row, "buckets")? as f64;
        Some(ledger(row)[0] / statistic(row, "pixels")? / (4.0 * textures))
    };
    farthest_from_one(dllb(scene).filter_map(ratio))
}

/// Bytes a fragment of dllb's id buffer, at B = 4.
fn dllb_id_node_bytes(scene: &SceneRows<'_>) -> Option<f64> {
    let row = with(scene, "dllb", "4")?;
    Some(ledger(row)[1] / statistic(row, "fragments")?)
}
