//! The families of methods that came before, a method each.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use tracebench_api::Query;

use super::{close, value, values};
use crate::papers::fixture::{config, run_of, set_build, set_bytes, set_classes};
use crate::results::{Record, Row};

/// A method with milliseconds of its build, bytes, and footprint agreement of diffuse and mirror rays.
fn method(tracer: &str, parameters: Value, ms: f64, bytes: u64, footprint: [f64; 2]) -> Row {
    let mut record = config(tracer, "a", parameters, &[], &[("diffuse", Query::Closest), ("specular", Query::Closest)]);
    set_build(&mut record, ms);
    set_bytes(&mut record, &[("all", bytes)]);
    for (rays, footprint) in ["diffuse", "specular"].into_iter().zip(footprint) {
        set_classes(&mut record, rays, [0, 0], footprint);
    }
    record
}

/// The families in the order of the paper, and DIRT.
fn families() -> Record {
    let dirt = json!({ "tile_size": "2", "coverage": "conservative", "searched": "until_hit", "accept": "tile", "buckets": 24 });
    run_of(vec![
        method("screen-dda", json!({ "layers": 1 }), 1.0, 10, [0.3, 0.5]),
        method("screen-dda", json!({ "layers": 2 }), 2.0, 20, [0.4, 0.5]),
        method("quadtree", json!({ "layers": 2, "views": "frame" }), 3.0, 30, [0.5, 0.5]),
        method("quadtree", json!({ "layers": 1, "views": "six" }), 4.0, 40, [0.7, 0.5]),
        method("voxel-abuffer", json!({}), 5.0, 80, [0.8, 0.5]),
        method("fragment-abuffer", json!({}), 6.0, 100, [0.9, 0.5]),
        method("dirt", dirt, 9.0, 70, [0.99, 0.97]),
    ])
}

/// Families are held in the paper's order, by all that rises; the last against all others; few layers against DIRT. Without one of them
/// nothing is said.
#[test]
fn families_are_held_in_order() {
    let record = families();
    close(value("min_trend_over_families", &record), 1.0);
    close(value("families_below_abuffer", &record), 1.0);
    close(value("voxel_abuffer_bytes_over_abuffer", &record), 0.8);
    // The cube of one layer is the best of few.
    close(value("few_layers_agreement_less_dirt", &record), 0.6 - 0.98);
    let mut smaller = record.clone();
    set_bytes(&mut smaller.rows[5], &[("all", 35)]);
    // It comes before two of five.
    close(value("min_trend_over_families", &smaller), 11.0 / 15.0);
    close(value("families_below_abuffer", &smaller), 0.6);
    let lacking: BTreeMap<&str, Record> =
        [("min_trend_over_families", 4), ("few_layers_agreement_less_dirt", 6), ("families_below_abuffer", 0)]
            .into_iter()
            .map(|(name, row)| {
                let mut record = record.clone();
                record.rows.remove(row);
                (name, record)
            })
            .collect();
    assert!(lacking.iter().all(|(name, row)| values(name, row).is_empty()));
}
