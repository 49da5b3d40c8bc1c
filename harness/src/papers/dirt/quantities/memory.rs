//! Bytes, references and other counts.

use tracebench_api::Status;

use crate::papers::Scope;
use crate::papers::dirt::PAPER;
use crate::papers::quantity::{PERCENT, Quantity, greatest, least, mean, of_scene, of_scenes};
use crate::papers::rows::{SceneRows, has, integer, per_ray, statistic, trace};
use crate::results::{Row, TraceRecord};

pub(super) const QUANTITIES: &[Quantity] = &[
    of_scene("samples_saved_1_to_2", PERCENT, |scene| saved(scene, ["1", "2"], parts)),
    of_scene("samples_saved_2_to_4", PERCENT, |scene| saved(scene, ["2", "4"], parts)),
    of_scene("references_saved_1_to_2", PERCENT, |scene| saved(scene, ["1", "2"], references)),
    of_scene("references_saved_2_to_4", PERCENT, |scene| saved(scene, ["2", "4"], references)),
    of_scene("memory_saved_1_to_2", PERCENT, |scene| saved(scene, ["1", "2"], bytes)),
    of_scene("memory_saved_2_to_4", PERCENT, |scene| saved(scene, ["2", "4"], bytes)),
    of_scene("memory_growth_per_8_buckets_1", PERCENT, |scene| growth_per_8_buckets(scene, "1")),
    of_scene("memory_growth_per_8_buckets_2", PERCENT, |scene| growth_per_8_buckets(scene, "2")),
    of_scene("memory_growth_per_8_buckets_4", PERCENT, |scene| growth_per_8_buckets(scene, "4")),
    of_scenes("memory_saving_spread", PERCENT, saving_spread),
    of_scenes("memory_exponent_over_references", "", exponent_over_references),
    of_scenes("bytes_a_reference", "bytes", bytes_a_reference),
    of_scene("mipmap_factor", "", mipmap_factor),
    of_scene("max_references_ratio_of_tiles", "", max_references_ratio_of_tiles),
    of_scene("copies_at_most_buckets_over_8", "", copies_at_most_buckets_over_8),
    of_scene("pyramid_steps_4_over_1", "", pyramid_steps_4_over_1),
    of_scene("equation_1b_beyond_last_bucket", "buckets", equation_1b_beyond_last_bucket),
    of_scene("validated_share", "", validated_share),
    of_scene("surfaces_fetched_over_hits", "", surfaces_fetched_over_hits),
    of_scenes("trace_bytes_over_scenes", "", trace_bytes_over_scenes),
];

/// What the ledger calls the depth bounds.
const DEPTH_BOUNDS: &str = "depth bounds texture";
/// Bytes of a pair of depth bounds.
const BOUNDS_BYTES: f64 = 8.0;
/// The paper's "practical minimum" is above this many buckets (section 5.3).
const FEW_BUCKETS: u64 = 8;

/// References stored, copies in several buckets counted.
pub(super) fn references(row: &Row) -> Option<f64> {
    statistic(row, "references")
}

/// Clipped primitives, each once a tile: n_p of Table 3.
fn parts(row: &Row) -> Option<f64> {
    statistic(row, "parts")
}

/// Bytes as the paper counts them: the structure and its own buffers.
fn bytes(row: &Row) -> Option<f64> {
    PAPER.bytes(row, Scope::OfPaper)
}

/// DIRT with a tile size, by rising B.
pub(super) fn over_buckets<'a>(scene: &SceneRows<'a>, tile_size: &str) -> Vec<(u64, &'a Row)> {
    let rows = scene.of_tracer("dirt").filter(|row| has(row, "tile_size", tile_size));
    let mut found: Vec<_> = rows.filter_map(|row| Some((integer(row, "buckets")?, row))).collect();
    found.sort_by_key(|(buckets, _)| *buckets);
    found
}

/// DIRT with two tile sizes and the same B, by rising B.
pub(super) fn pairs<'a>(scene: &SceneRows<'a>, tile_sizes: [&str; 2]) -> Vec<(u64, [&'a Row; 2])> {
    let [from, to] = tile_sizes.map(|tile_size| over_buckets(scene, tile_size));
    let partner = |buckets: u64| to.iter().find(|(other, _)| *other == buckets).map(|(_, row)| *row);
    from.into_iter().filter_map(|(buckets, row)| Some((buckets, [row, partner(buckets)?]))).collect()
}

/// What a larger tile saves at B > 8, percent, mean over B.
fn saved(scene: &SceneRows<'_>, tile_sizes: [&str; 2], of: fn(&Row) -> Option<f64>) -> Option<f64> {
    let pairs = pairs(scene, tile_sizes);
    let saved = pairs.into_iter().filter(|(buckets, _)| *buckets > FEW_BUCKETS);
    let saved: Option<Vec<f64>> = saved.map(|(_, [from, to])| Some(100.0 * (1.0 - of(to)? / of(from)?))).collect();
    mean(&saved?)
}

/// How much memory a step of eight buckets adds, percent, mean over the steps from B = 8.
fn growth_per_8_buckets(scene: &SceneRows<'_>, tile_size: &str) -> Option<f64> {
    let rows = over_buckets(scene, tile_size);
    let steps = rows.windows(2).filter(|pair| pair[0].0 >= FEW_BUCKETS && pair[1].0 == pair[0].0 + 8);
    let growth: Option<Vec<f64>> =
        steps.map(|pair| Some(100.0 * (bytes(pair[1].1)? / bytes(pair[0].1)? - 1.0))).collect();
    mean(&growth?)
}

/// By how many percentage points the scenes differ in what tiles of 2x2 save of memory.
fn saving_spread(scenes: &[SceneRows<'_>]) -> Option<f64> {
    let savings: Vec<f64> = scenes.iter().filter_map(|scene| saved(scene, ["1", "2"], bytes)).collect();
    let several = savings.len() > 1;
    let ends = greatest(savings.iter().copied())? - least(savings.iter().copied())?;
    several.then_some(ends)
}

/// The scenes with the fewest and the most references at the highest resolution that all have, and the same parameters:
/// references and bytes of each.
fn extremes(scenes: &[SceneRows<'_>]) -> Option<[[f64; 2]; 2]> {
    let first = scenes.first()?.by_resolution().pop()?.of_tracer("dirt").next()?;
    let alike = |row: &&Row| {
        row.tracer.parameters == first.tracer.parameters
            && row.viewpoint.ray_image == first.viewpoint.ray_image
            && (row.viewpoint.frame, row.viewpoint.face) == (first.viewpoint.frame, first.viewpoint.face)
    };
    let of_scene = |scene: &SceneRows<'_>| {
        let row = scene.of_tracer("dirt").find(alike)?;
        Some([references(row)?, bytes(row)?])
    };
    let found: Vec<[f64; 2]> = scenes.iter().filter_map(of_scene).collect();
    let fewest = found.iter().copied().reduce(|a, b| if b[0] < a[0] { b } else { a })?;
    let most = found.iter().copied().reduce(|a, b| if b[0] > a[0] { b } else { a })?;
    (most[0] > fewest[0] && fewest[0] > 0.0).then_some([fewest, most])
}

/// The exponent of bytes over references from the scene with fewest to that with most: 0 if bytes are constant, 1 if linear.
fn exponent_over_references(scenes: &[SceneRows<'_>]) -> Option<f64> {
    let [fewest, most] = extremes(scenes)?;
    Some((most[1] / fewest[1]).ln() / (most[0] / fewest[0]).ln())
}

/// Bytes that a reference more takes, from the scene with fewest to that with most.
fn bytes_a_reference(scenes: &[SceneRows<'_>]) -> Option<f64> {
    let [fewest, most] = extremes(scenes)?;
    Some((most[1] - fewest[1]) / (most[0] - fewest[0]))
}

/// Tiles of all views, from the viewpoint alone.
pub(in crate::papers::dirt) fn tiles(row: &Row) -> Option<f64> {
    let tile_size = u32::try_from(integer(row, "tile_size")?).ok()?;
    let [views, edges] =
        if has(row, "views", "frame") { [[1, 1], row.viewpoint.frame] } else { [[6, 1], [row.viewpoint.face; 2]] };
    let of_view: f64 = edges.iter().map(|edge| f64::from(edge.div_ceil(tile_size))).product();
    Some(f64::from(views[0]) * of_view)
}

/// Bytes of the depth bounds with mipmaps over those of the lowest level alone: the ratio that lies farthest from 1.
fn mipmap_factor(scene: &SceneRows<'_>) -> Option<f64> {
    let factor = |row: &Row| {
        let bounds = row.memory.structure.iter().find(|part| part.name == DEPTH_BOUNDS)?;
        Some(bounds.used_bytes as f64 / (BOUNDS_BYTES * tiles(row)?))
    };
    greatest(scene.of_tracer("dirt").filter_map(factor))
}

/// Tile sizes, each twice the one before.
const TILE_SIZES: [&str; 4] = ["1", "2", "4", "8"];

/// The greatest ratio of references of a tile size to those of half of it.
fn max_references_ratio_of_tiles(scene: &SceneRows<'_>) -> Option<f64> {
    let steps = TILE_SIZES.windows(2).flat_map(|step| pairs(scene, [step[0], step[1]]));
    let ratios: Option<Vec<f64>> = steps.map(|(_, [from, to])| Some(references(to)? / references(from)?)).collect();
    greatest(ratios?)
}

/// References a part of a triangle in a tile, at the most buckets of the table over B = 8, tiles of one pixel.
fn copies_at_most_buckets_over_8(scene: &SceneRows<'_>) -> Option<f64> {
    let copies = |row: &Row| Some(references(row)? / statistic(row, "parts")?);
    let rows = over_buckets(scene, "1");
    let (few, (buckets, many)) = (rows.iter().find(|(buckets, _)| *buckets == FEW_BUCKETS)?, rows.last()?);
    (*buckets > FEW_BUCKETS).then(|| Some(copies(many)? / copies(few.1)?))?
}

/// Pyramid steps a diffuse ray, tiles of 4x4 over tiles of one pixel, at B = 24.
fn pyramid_steps_4_over_1(scene: &SceneRows<'_>) -> Option<f64> {
    let steps = |tile_size: &str| {
        let row = scene.find("dirt", &[("tile_size", tile_size), ("buckets", "24")])?;
        per_ray(trace(row, "diffuse")?, "pyramid_steps")
    };
    Some(steps("4")? / steps("1")?)
}

/// By how much the index of Equation 1b at the far end of a tile's range lies beyond the last bucket, the most over the B of
/// the table.
fn equation_1b_beyond_last_bucket(scene: &SceneRows<'_>) -> Option<f64> {
    // Any range: at its far end the fraction is exactly 1.
    let (near, far) = (1.0_f64, 3.0_f64);
    let index = |buckets: f64| (buckets * (far - near) / (far - near)).floor();
    let all = scene.of_tracer("dirt").filter_map(|row| integer(row, "buckets"));
    greatest(all.map(|buckets| index(buckets as f64) - (buckets as f64 - 1.0)))
}

/// The share of structures that were read back and compared with brute force. What is unsound is taken out of a run with the
/// reason, as is what cannot be built: both count here as not validated.
fn validated_share(scene: &SceneRows<'_>) -> Option<f64> {
    let all: Vec<&Row> = scene.of_tracer("dirt").collect();
    let validated = all.iter().filter(|row| !row.structure_statistics.is_empty()).count();
    let skipped = scene.skipped.iter().filter(|skipped| skipped.tracer.as_deref() == Some("dirt")).count();
    (!all.is_empty()).then(|| validated as f64 / (all.len() + skipped) as f64)
}

/// Surfaces that Fetch found over the hits that it looked for, the most over DIRT's rows and sets.
fn surfaces_fetched_over_hits(scene: &SceneRows<'_>) -> Option<f64> {
    let fetched = |trace: &TraceRecord| {
        let hits = trace.statuses.get(Status::Hit.name()).copied().filter(|hits| *hits > 0)? as f64;
        Some((hits - trace.counters.get("fetches_lost")?.total as f64) / hits)
    };
    greatest(scene.of_tracer("dirt").flat_map(|row| &row.traces).filter_map(fetched))
}

/// Bytes of a trace's own buffers in the scene where they are most over those in the scene where they are least, of resolutions and
/// numbers of rays that all scenes have that which differs most.
fn trace_bytes_over_scenes(scenes: &[SceneRows<'_>]) -> Option<f64> {
    let of_scene = |scene: &SceneRows<'_>| -> Vec<([u32; 2], u64, f64)> {
        let bytes = |row: &Row| Some(PAPER.bytes(row, Scope::WithTrace)? - PAPER.bytes(row, Scope::Structure)?);
        let rows = scene.of_tracer("dirt");
        rows.filter_map(|row| Some((row.viewpoint.frame, row.traces.first()?.count, bytes(row)?))).collect()
    };
    let all: Vec<_> = scenes.iter().map(of_scene).collect();
    let alike = |(frame, rays, _): &([u32; 2], u64, f64)| {
        let same = |rows: &Vec<([u32; 2], u64, f64)>| {
            rows.iter().find(|row| (row.0, row.1) == (*frame, *rays)).map(|row| row.2)
        };
        let bytes = all.iter().map(same).collect::<Option<Vec<f64>>>()?;
        Some(greatest(bytes.iter().copied())? / least(bytes)?)
    };
    (all.len() > 1).then(|| greatest(all.first()?.iter().filter_map(alike)))?
}
