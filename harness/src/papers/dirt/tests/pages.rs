//! Pages of DIRT's tables: what stands on them, and that no speed stands there without its accuracy.

use std::collections::BTreeMap;

use serde_json::json;
use tracebench_api::{ClockKind, Query};

use crate::papers::fixture::{self, Quality, page_of, take_judgements};
use crate::results::{CounterRecord, Record};

const SETS: [(&str, Query); 4] =
    [("visibility", Query::Any), ("specular", Query::Closest), ("glossy", Query::Closest), ("diffuse", Query::Closest)];

/// A run of Table 1 with both tile sizes.
fn throughput() -> Record {
    let quality = Quality { missed: 0.01, blur: 1e-9, speed: 4.0, clock: ClockKind::DeviceTimestamps };
    let mut record = fixture::run(&[("dirt", quality), ("dirt", quality), ("bvh-cpu", quality)], &SETS);
    for (one, tile_size) in record.rows.iter_mut().zip(["1", "2", "0"]) {
        one.tracer.parameters = BTreeMap::from([("tile_size".to_owned(), json!(tile_size))]);
        one.tracer.changed = vec!["tile_size".to_owned()];
    }
    record
}

fn page(record: &Record) -> String {
    page_of("dirt-table1", record)
}

/// The page has published values, rates with accuracy and ratios beside the published scene's, of the table's tracers alone.
#[test]
fn a_page_sets_ratios_beside_published_ones() {
    let page = page(&throughput());
    assert!(page.contains("| Bunny | 156 | 40.3 | 24.9 | 14.58 | 11.6 |"), "{page}");
    // The fixture's sets have speeds of 4 over 1, 1.6, 2.2, 2.8; the room stands for Bunny.
    assert!(page.contains("2.80 here, 3.47 published") && page.contains("1.27 here, 1.26 published"), "{page}");
    assert!(page.contains("dirt tile_size=2") && !page.contains("bvh-cpu"), "{page}");
    let mut other = throughput();
    other.rows.iter_mut().for_each(|one| "barn".clone_into(&mut one.scene.name));
    let text = self::page(&other);
    assert!(text.contains("2.80 here, – published") && text.contains("barn stands for none"), "{text}");
}

/// Where nothing could be judged, no rate stands on the page.
#[test]
fn a_page_tells_no_speed_without_accuracy() {
    let mut record = throughput();
    // The medians of the sets, in both kinds of table.
    let rates = ["4.040 [", "2.525 [", "1.837 [", "1.443 [", "4.040 at ", "2.525 at ", "1.837 at ", "1.443 at "];
    let measured = |record: &Record| page(record).split("## Here").nth(1).unwrap().to_owned();
    let judged = measured(&record);
    assert!(rates.iter().all(|rate| judged.contains(rate)) && !judged.contains("– here"), "{judged}");
    take_judgements(&mut record);
    let silent = measured(&record);
    assert!(!rates.iter().any(|rate| silent.contains(rate)), "{silent}");
    assert!(silent.contains("– here, 3.47 published"), "{silent}");
}

/// What is counted ray by ray stands as a mean; what is counted over a set as how much of what is stored it touched.
#[test]
fn a_page_shows_what_a_set_touched() {
    let mut record = throughput();
    for trace in record.rows.iter_mut().flat_map(|one| &mut one.traces) {
        let of_set = CounterRecord { total: 1234, per_ray: 0.015_625, max_per_ray: None };
        trace.counters.insert("nodes_touched".to_owned(), of_set);
    }
    let page = page(&record);
    // Two rows of four sets; the structure of the fixture has 4321 nodes.
    assert_eq!(page.matches("| 1,234 (28.6 % of 4,321) |").count(), 8, "{page}");
    assert!(page.contains("| nodes per ray ↓ | nodes_touched ↓ |") && page.contains("| 37.00 |"), "{page}");
    assert!(!page.contains("0.0156") && !page.contains("nodes_touched per ray"), "{page}");
}

/// Copies of parts stand as shares of all parts, tiles of one surface as shares of the tiles with lists; structures that do not tell have
/// no such table.
#[test]
fn a_page_shows_copies_of_parts() {
    let mut record = fixture::run_of(vec![super::dirt("room", json!({ "tile_size": "2" }), &[])]);
    assert!(!page_of("dirt-figure10", &record).contains("copies a part"));
    let counts = [
        ("references", 900.0),
        ("parts", 300.0),
        ("parts_in_1_bucket", 150.0),
        ("parts_in_3_to_4_buckets", 75.0),
        ("parts_in_every_bucket", 30.0),
        ("occupied_tiles", 50.0),
        ("one_surface_tiles", 20.0),
        ("references_in_one_surface_tiles", 90.0),
    ];
    record.rows[0].structure_statistics = counts.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect();
    let page = page_of("dirt-figure10", &record);
    assert!(page.contains("| copies a part | in 1 bucket (%) | 3 to 4 | in every bucket (%) |"), "{page}");
    assert!(page.contains("| 3.00 | 50.0 | 25.0 | 10.0 | 40.0 | 10.0 |"), "{page}");
}
