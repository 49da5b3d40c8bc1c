//! What pages of DIRT's tables and figures show before their rows.

use super::DIRT;
use super::quantities::memory::tiles;
use super::quantities::time::{MIXES, total_ms};
use crate::papers::SceneRows;
use crate::papers::page::Page;
use crate::papers::page::measured::{TableRow, of_rows, over, speed_with_accuracy};
use crate::papers::rows::{integer, statistic, trace};
use crate::report::document::Document;
use crate::report::sheet::{Cell, Column, Sheet};
use crate::results::{Row, host_ms};

/// Kinds of rays in the order of DIRT's Table 1: ray set, published column.
const KINDS: [(&str, &str); 4] =
    [("visibility", "Visibility"), ("specular", "Specular"), ("glossy", "Glossy"), ("diffuse", "Diffuse")];
/// Bytes of the formula of DIRT's Table 3: a tile's depth bounds, a list's head, a node.
const FORMULA: [f64; 3] = [8.0, 4.0, 8.0];
/// The factors by mipmaps that the paper gives: Table 3, section 4.1.1.
const MIPMAPS: [f64; 2] = [1.33, 1.5];

/// Rays a second of each kind, and ratios to the last kind beside the published ones.
pub(super) fn throughput(page: &Page<'_>) -> Document {
    let rows: Vec<TableRow<'_>> = page.all().collect();
    let found = |row: &Row, rays| speed_with_accuracy(trace(row, rays)?);
    let speed = |(rays, _)| Column::new(rays, move |(_, row): &TableRow<'_>| found(row, rays));
    let [kinds @ .., last] = KINDS;
    let ratio = |kind: (&'static str, &'static str)| {
        Column::new(kind.0, move |(_, row): &TableRow<'_>| {
            let [own, base] = [kind, last].map(|(rays, _)| found(row, rays).map(|speed| speed.value));
            let [theirs, of] = [kind, last].map(|(_, column)| page.printed_of(row, &[], column));
            format!("{} here, {} published", over(own, base).describe(), over(theirs, of).describe())
        })
    };
    let sheet = || of_rows::<TableRow<'_>>(|row| *row);
    Document::of("Mrays/s with the agreement under tight of the same rays (any hit: balanced accuracy):")
        .table(sheet().with(KINDS.map(speed).into()).table(&rows))
        .paragraph("Ratios to diffuse rays, within one scene and tracer:")
        .table(sheet().with(kinds.map(ratio).into()).table(&rows))
}

/// Bytes by the formula of Table 3 with the device's own counts, and by the ledger.
struct Formula {
    tiles: f64,
    references: f64,
    lists: f64,
    bounds: f64,
    used_lists: f64,
    used_bounds: f64,
    used_else: f64,
}

impl Formula {
    fn of(row: &Row) -> Option<Self> {
        let (tiles, references, buckets) = (tiles(row)?, statistic(row, "references")?, integer(row, "buckets")?);
        let part = |of: &dyn Fn(&str) -> bool| {
            row.memory.structure.iter().filter(|part| of(&part.name)).map(|part| part.used_bytes as f64).sum::<f64>()
        };
        let is_bounds = |name: &str| name == "depth bounds texture";
        let is_list = |name: &str| name.starts_with("id buffer");
        let [bounds_bytes, head_bytes, node_bytes] = FORMULA;
        Some(Self {
            tiles,
            references,
            lists: head_bytes * buckets as f64 * tiles + node_bytes * references,
            bounds: bounds_bytes * tiles,
            used_lists: part(&is_list),
            used_bounds: part(&is_bounds),
            used_else: part(&|name| !is_bounds(name) && !is_list(name)),
        })
    }

    /// With mipmaps, over what the ledger says.
    fn over_ledger(&self, mipmaps: f64) -> Cell {
        Cell::Number((self.bounds * mipmaps + self.lists) / (self.used_bounds + self.used_lists), 5)
    }
}

/// The formula of Table 3 beside what the ledger says is used.
pub(super) fn formula(page: &Page<'_>) -> Document {
    let rows: Vec<_> = page.all().filter_map(|row| Some((row, Formula::of(row.1)?))).collect();
    let sheet = of_rows::<(TableRow<'_>, Formula)>(|(row, _)| *row)
        .column("tiles of all views", |(_, of)| of.tiles as u64)
        .column("c n_p (references)", |(_, of)| of.references as u64)
        .column("id buffer, formula (bytes)", |(_, of)| of.lists as u64)
        .column("id buffer, ledger over formula", |(_, of)| Cell::Number(of.used_lists / of.lists, 6))
        .column("depth bounds without mipmaps (bytes)", |(_, of)| of.bounds as u64)
        .column("ledger over that", |(_, of)| Cell::Number(of.used_bounds / of.bounds, 5))
        .column("formula at 1.33 over ledger", |(_, of)| of.over_ledger(MIPMAPS[0]))
        .column("at 1.5 over ledger", |(_, of)| of.over_ledger(MIPMAPS[1]))
        .column("in the ledger and not in Table 3 (bytes)", |(_, of)| of.used_else as u64);
    Document::of("Bytes used:").table(sheet.table(&rows))
}

/// Build and traces of every mix by the host's clock.
pub(super) fn mixes(page: &Page<'_>) -> Document {
    let at = |(name, mix)| {
        Column::new(format!("{name}: build and traces (ms) ↓"), move |(_, row): &TableRow<'_>| total_ms(row, mix))
    };
    let sheet = Sheet::<TableRow<'_>>::new()
        .column("scene", |(scene, _)| Cell::Name(scene.label.clone()))
        .column("rays from", |(_, row)| row.viewpoint.ray_image.map(|side| side.to_string()).join("x"))
        .column("tracer", |(_, row)| row.label())
        .column("build (ms, host clock) ↓", |(_, row)| host_ms(row.build.steady()))
        .with(MIXES.map(at).into());
    let of_scene =
        |scene| SceneRows::by_resolution(scene).into_iter().flat_map(|at| at.rows).map(move |row| (scene, row));
    let rows: Vec<TableRow<'_>> = page.rows.scenes.iter().flat_map(of_scene).collect();
    Document::of("The accuracy of the same traces stands below, by scene and resolution.").table(sheet.table(&rows))
}

/// Parts of triangles by the number of buckets that hold them, as structures tell them: statistic, heading.
const IN_BUCKETS: [(&str, &str); 9] = [
    ("parts_in_1_bucket", "in 1 bucket (%)"),
    ("parts_in_2_buckets", "2"),
    ("parts_in_3_to_4_buckets", "3 to 4"),
    ("parts_in_5_to_8_buckets", "5 to 8"),
    ("parts_in_9_to_16_buckets", "9 to 16"),
    ("parts_in_17_to_32_buckets", "17 to 32"),
    ("parts_in_33_to_64_buckets", "33 to 64"),
    ("parts_in_65_to_128_buckets", "65 to 128"),
    ("parts_in_129_to_256_buckets", "129 to 256"),
];

/// Copies of a part in several buckets as a histogram, and tiles that one surface fills; nothing of structures that do not tell.
pub(super) fn copies(page: &Page<'_>) -> Document {
    let tells = |name: &str, (_, row): &TableRow<'_>| statistic(row, name).is_some();
    let rows: Vec<TableRow<'_>> = page.of_tracer(DIRT).filter(|row| tells("one_surface_tiles", row)).collect();
    let over = |(_, row): &TableRow<'_>, part: &str, whole: &str| Some(statistic(row, part)? / statistic(row, whole)?);
    let share = |heading: &'static str, part: &'static str, whole: &'static str| {
        Column::new(heading, move |row: &TableRow<'_>| {
            Cell::number(over(row, part, whole).map(|share| 100.0 * share), 3)
        })
    };
    let bins = IN_BUCKETS.iter().filter(|(name, _)| rows.iter().any(|row| tells(name, row)));
    let sheet = of_rows::<TableRow<'_>>(|row| *row)
        .column("copies a part", |row| Cell::number(over(row, "references", "parts"), 3))
        .with(bins.map(|&(name, heading)| share(heading, name, "parts")).collect())
        .and(share("in every bucket (%)", "parts_in_every_bucket", "parts"))
        .and(share("tiles of one surface (%)", "one_surface_tiles", "occupied_tiles"))
        .and(share("references in these (%)", "references_in_one_surface_tiles", "references"));
    let words = "Parts of triangles, one a tile that it touches, by the number of the tile's buckets that hold a copy. Equation 1 divides \
         the depths that a tile holds, whatever these are: where one surface, triangles that hang together by their corners, fills a \
         tile, it is spread over all buckets.";
    Document::default().below(words, sheet.table(&rows))
}
