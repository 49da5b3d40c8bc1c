//! What pages of DIRT's tables and figures show before their rows.

use super::DIRT;
use super::quantities::memory::tiles;
use super::quantities::time::{MIXES, total_ms};
use crate::papers::page::Page;
use crate::papers::page::beside::beside;
use crate::papers::page::measured::{speed_with_accuracy, strings};
use crate::papers::rows::{integer, statistic, trace};
use crate::papers::vvp16::ABUFFER;
use crate::papers::wkp15::DDA;
use crate::report::format::{NONE, optional, significant, thousands};
use crate::report::markdown::Table;
use crate::results::TracerRun;
use crate::results::host_ms;

/// Kinds of rays in the order of DIRT's Table 1: ray set, published column.
const KINDS: [(&str, &str); 4] =
    [("visibility", "Visibility"), ("specular", "Specular"), ("glossy", "Glossy"), ("diffuse", "Diffuse")];
/// Bytes of the formula of DIRT's Table 3: a tile's depth bounds, a list's head, a node.
const FORMULA: [f64; 3] = [8.0, 4.0, 8.0];
/// The factors by mipmaps that the paper gives: Table 3, section 4.1.1.
const MIPMAPS: [f64; 2] = [1.33, 1.5];

/// Rays a second of each kind, and ratios to the last kind beside the published ones.
pub(super) fn throughput(page: &Page<'_>) -> String {
    let printed = page.printed();
    let kinds: Vec<&str> = KINDS.iter().map(|(rays, _)| *rays).collect();
    let mut speeds = Table::new(&[strings(&["scene", "tracer"]), strings(&kinds)].concat());
    let mut ratios = Table::new(&[strings(&["scene", "tracer"]), strings(&kinds[..3])].concat());
    for scene in &page.rows.scenes {
        for run in &scene.runs {
            let found = KINDS.map(|(rays, _)| trace(run, rays).and_then(speed_with_accuracy));
            let mut cells = vec![scene.label.clone(), run.label()];
            cells.extend(
                found.iter().map(|each| each.as_ref().map_or_else(|| NONE.to_owned(), |(_, text)| text.clone())),
            );
            speeds.row(&cells);
            let own = |index: usize| {
                let [one, last] = [index, KINDS.len() - 1].map(|at| found[at].as_ref().map(|(speed, _)| *speed));
                Some(one? / last?)
            };
            let theirs = |index: usize| {
                let name = page.experiment.stands_for(&run.scene)?;
                let of = |column: &str| printed?.value(&[("scene", name)], column);
                Some(of(KINDS[index].1)? / of(KINDS[KINDS.len() - 1].1)?)
            };
            let both =
                |index: usize| format!("{} here, {} published", optional(own(index), 3), optional(theirs(index), 3));
            let mut cells = vec![scene.label.clone(), run.label()];
            cells.extend((0..KINDS.len() - 1).map(both));
            ratios.row(&cells);
        }
    }
    format!(
        "\nMrays/s with the agreement under tight of the same rays (any hit: balanced accuracy):\n\n{}\nRatios to diffuse rays, \
         within one scene and tracer:\n\n{}",
        speeds.text, ratios.text
    )
}

/// The formula of Table 3 with the device's own counts, beside what the ledger says is used.
pub(super) fn formula(page: &Page<'_>) -> String {
    let part = |run: &TracerRun, of: &dyn Fn(&str) -> bool| {
        run.memory.structure.iter().filter(|part| of(&part.name)).map(|part| part.used_bytes as f64).sum::<f64>()
    };
    let is_bounds = |name: &str| name == "depth bounds texture";
    let is_list = |name: &str| name.starts_with("id buffer");
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "tiles of all views",
        "c n_p (references)",
        "id buffer, formula (bytes)",
        "id buffer, ledger over formula",
        "depth bounds without mipmaps (bytes)",
        "ledger over that",
        "formula at 1.33 over ledger",
        "at 1.5 over ledger",
        "in the ledger and not in Table 3 (bytes)",
    ]));
    for (scene, run) in page.rows.scenes.iter().flat_map(|scene| scene.runs.iter().map(move |run| (scene, *run))) {
        let found = tiles(run).zip(statistic(run, "references")).zip(integer(run, "buckets"));
        let Some(((tiles, references), buckets)) = found else { continue };
        let [bounds_bytes, head_bytes, node_bytes] = FORMULA;
        let lists = head_bytes * buckets as f64 * tiles + node_bytes * references;
        let bounds = bounds_bytes * tiles;
        let ledger = part(run, &is_bounds) + part(run, &is_list);
        let beside = |factor: f64| significant((bounds * factor + lists) / ledger, 5);
        table.row(&[
            scene.label.clone(),
            run.label(),
            thousands(tiles as u64),
            thousands(references as u64),
            thousands(lists as u64),
            significant(part(run, &is_list) / lists, 6),
            thousands(bounds as u64),
            significant(part(run, &is_bounds) / bounds, 5),
            beside(MIPMAPS[0]),
            beside(MIPMAPS[1]),
            thousands(part(run, &|name| !is_bounds(name) && !is_list(name)) as u64),
        ]);
    }
    format!("\nBytes used:\n\n{}", table.text)
}

/// Build and traces of every mix by the host's clock, with the ratio to the first tracer.
pub(super) fn mixes(page: &Page<'_>) -> String {
    let mut headings = strings(&["scene", "rays from", "tracer", "build (ms, host clock) ↓"]);
    headings.extend(MIXES.iter().map(|(name, _)| format!("{name}: build and traces (ms) ↓")));
    let mut table = Table::new(&headings);
    for scene in &page.rows.scenes {
        for at in scene.by_resolution() {
            for run in &at.runs {
                let [width, height] = run.viewpoint.ray_image;
                let mut cells = vec![scene.label.clone(), format!("{width}x{height}"), run.label()];
                cells.push(optional(host_ms(&run.build.times), 4));
                cells.extend(MIXES.iter().map(|(_, mix)| optional(total_ms(run, mix), 4)));
                table.row(&cells);
            }
        }
    }
    format!("\nThe accuracy of the same traces stands below, by scene and resolution.\n\n{}", table.text)
}

/// Methods of every family beside the first.
pub(super) fn families(page: &Page<'_>) -> String {
    beside(page, DDA)
}

/// DIRT beside the A-buffer.
pub(super) fn beside_abuffer(page: &Page<'_>) -> String {
    beside(page, ABUFFER)
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
pub(super) fn copies(page: &Page<'_>) -> String {
    let rows = page.rows.scenes.iter().flat_map(|scene| scene.of_tracer(DIRT).map(move |run| (scene, run)));
    let rows: Vec<_> = rows.filter(|(_, run)| statistic(run, "one_surface_tiles").is_some()).collect();
    if rows.is_empty() {
        return String::new();
    }
    let told = |name: &str| rows.iter().any(|(_, run)| statistic(run, name).is_some());
    let bins: Vec<_> = IN_BUCKETS.iter().filter(|(name, _)| told(name)).collect();
    let mut headings = strings(&["scene", "tracer", "copies a part"]);
    headings.extend(bins.iter().map(|(_, heading)| (*heading).to_owned()));
    headings.extend(strings(&["in every bucket (%)", "tiles of one surface (%)", "references in these (%)"]));
    let mut table = Table::new(&headings);
    for (scene, run) in rows {
        let share = |name: &str, of: &str| {
            let [part, whole] = [name, of].map(|name| statistic(run, name));
            optional(part.zip(whole).map(|(part, whole)| 100.0 * part / whole), 3)
        };
        let copies = statistic(run, "references").zip(statistic(run, "parts"));
        let mut cells = vec![scene.label.clone(), run.label()];
        cells.push(optional(copies.map(|(references, parts)| references / parts), 3));
        cells.extend(bins.iter().map(|(name, _)| share(name, "parts")));
        cells.push(share("parts_in_every_bucket", "parts"));
        cells.push(share("one_surface_tiles", "occupied_tiles"));
        cells.push(share("references_in_one_surface_tiles", "references"));
        table.row(&cells);
    }
    format!(
        "\nParts of triangles, one a tile that it touches, by the number of the tile's buckets that hold a copy. Equation 1 divides \
         the depths that a tile holds, whatever these are: where one surface, triangles that hang together by their corners, fills a \
         tile, it is spread over all buckets.\n\n{}",
        table.text
    )
}
