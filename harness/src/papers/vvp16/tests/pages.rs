//! Pages of VVP16's tables: what stands on them, and that no time stands there without its accuracy.

use serde_json::json;
use tracebench_api::{ClockKind, Query};

use crate::papers::fixture::{self, Quality, page_of, take_judgements};
use crate::papers::{find, report};
use crate::results::{CounterRecord, Record};

/// Empty-space skipping on or off.
fn skipping(switch: &str) -> [(&'static str, &str); 2] {
    ["skip_bounds", "skip_buckets"].map(|name| (name, switch))
}

/// A run of VVP16's tracer: rows with values, on the fixture's room.
fn abuffer(rows: &[&[(&str, &str)]], sets: &[(&str, Query)]) -> Record {
    let quality = Quality { missed: 0.01, blur: 1e-9, speed: 4.0, clock: ClockKind::DeviceTimestamps };
    let mut record = fixture::run(&vec![("fragment-abuffer", quality); rows.len()], sets);
    for (one, values) in record.rows.iter_mut().zip(rows) {
        one.tracer.parameters = values.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
        one.tracer.changed = values.iter().map(|(name, _)| (*name).to_owned()).collect();
        let counts = [("fragments", 3.0), ("pixels", 2.0), ("average_layers", 3.0), ("maximum_layers", 17.0)];
        one.structure_statistics = counts.iter().map(|(name, count)| ((*name).to_owned(), count * 1e6)).collect();
    }
    record
}

/// Table 1 of VVP16 sets what skipping gains beside the published gain of the same scene and bounces, two bounces added up, and
/// its counters; the scenes that stand for none have no published value.
#[test]
fn table_1_of_vvp16_stands_beside_its_scene() {
    let sets = [("diffuse", Query::Closest), ("bounce2", Query::Closest), ("ao", Query::Any)];
    let mut record = abuffer(&[&skipping("on"), &skipping("off")], &sets);
    for (one, factor) in record.rows.iter_mut().zip([1.0, 3.0]) {
        for (trace, ms) in one.traces.iter_mut().zip([10.0, 30.0, 5.0]) {
            trace.times.submit_to_done_median_ms = Some(ms * factor);
            for (name, total) in [("pixels_visited", 800), ("pixels_opened", 200), ("fragments_tested", 900)] {
                let counter = trace.counters["nodes"].clone();
                trace.counters.insert(name.to_owned(), CounterRecord { total, ..counter });
            }
        }
    }
    let page = page_of("vvp16-table1", &record);
    // 284 over 54 ms printed for two bounces in Bunny, 121 over 21 for one.
    for part in
        ["40.00 at ", "120.0 at ", "| 4.50 | – | 75.0 |", "| 3.00 |", "| 5.26 |", "| 5.76 |", "| 128.0 | 2.400 |"]
    {
        assert!(page.contains(part), "no '{part}' in {page}");
    }
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| room | ao |")).collect();
    assert!(rows.len() == 1 && rows[0].ends_with("| – / – | – | – |"), "Bunny has no AO: {rows:?}");
    record.rows.iter_mut().for_each(|one| "barn".clone_into(&mut one.scene.name));
    assert!(!page_of("vvp16-table1", &record).contains("| 5.76 |"));
}

/// No page of VVP16's tells a trace's time where the rays could not be judged, nor does its chart.
#[test]
fn pages_of_vvp16_tell_no_time_without_accuracy() {
    let closest = |rays| vec![(rays, Query::Closest)];
    let ways = [["off", "off"], ["on", "off"], ["on", "on"]];
    let variants = ways
        .map(|[decoupled, switch]| [&[("storage", "dllb"), ("decoupled", decoupled)][..], &skipping(switch)].concat());
    let variants: Vec<&[(&str, &str)]> = variants.iter().map(Vec::as_slice).collect();
    let skipping = ["on", "off"].map(skipping);
    let skipping = skipping.each_ref().map(|row| &row[..]);
    let views: [&[(&str, &str)]; 2] = [&[("views", "seven")], &[("views", "frame")]];
    let bounces = vec![("diffuse", Query::Closest), ("bounce2", Query::Closest)];
    for (name, rows, sets) in [
        ("vvp16-table1", &skipping[..], bounces),
        ("vvp16-figure11", &views[..1], closest("diffuse")),
        ("vvp16-figure12", &variants[..], closest("pixel-random")),
        ("vvp16-views", &views[..], closest("diffuse")),
        ("dirt-table2", &views[..1], closest("diffuse")),
    ] {
        let mut record = abuffer(rows, &sets);
        for trace in record.rows.iter_mut().flat_map(|one| &mut one.traces) {
            trace.times.submit_to_done_median_ms = Some(77.25);
        }
        let times = |page: &str| page.matches("77.25").count() + page.matches("154.5").count();
        assert!(times(&page_of(name, &record)) > 0, "{name}");
        take_judgements(&mut record);
        assert_eq!(times(&page_of(name, &record)), 0, "{name}");
        let chart = |record: &Record| {
            let (paper, experiment) = find(name).unwrap();
            let files = report(paper, experiment, record).unwrap().contents().unwrap();
            files.into_iter().find(|(file, _)| file.ends_with(".svg")).map(|(_, svg)| String::from_utf8(svg).unwrap())
        };
        if let Some(chart) = chart(&record) {
            assert!(name == "vvp16-figure12" && chart.contains("nothing was measured"), "{name}");
        }
    }
}
