//! Pages of experiments: what stands on them, and that no speed stands there without its accuracy.

use std::collections::BTreeMap;

use serde_json::json;
use tracebench_api::{ClockKind, Query};

use super::files;
use crate::papers::find;
use crate::report::chart::series::{Panel, Series, SeriesChart, series_chart};
use crate::report::fixture::{self, Quality};
use crate::results::{CounterRecord, Judgement, Run};

const SETS: [(&str, Query); 4] =
    [("visibility", Query::Any), ("specular", Query::Closest), ("glossy", Query::Closest), ("diffuse", Query::Closest)];

/// A run of Table 1 with both tile sizes.
fn throughput() -> Run {
    let quality = Quality { missed: 0.01, blur: 1e-9, speed: 4.0, clock: ClockKind::DeviceTimestamps };
    let mut run = fixture::run(&[("dirt", quality), ("dirt", quality), ("bvh-cpu", quality)], &SETS);
    for (one, tile_size) in run.runs.iter_mut().zip(["1", "2", "0"]) {
        one.tracer.parameters = BTreeMap::from([("tile_size".to_owned(), json!(tile_size))]);
        one.tracer.changed = vec!["tile_size".to_owned()];
    }
    run
}

fn page(run: &Run) -> String {
    let files = files(find("dirt-table1").unwrap(), run).unwrap();
    let page = files.into_iter().find(|(name, _)| name == "table_dirt_table1.md").unwrap();
    String::from_utf8(page.1).unwrap()
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
    other.runs.iter_mut().for_each(|one| "barn".clone_into(&mut one.scene.name));
    let text = self::page(&other);
    assert!(text.contains("2.80 here, – published") && text.contains("barn stands for none"), "{text}");
}

/// Where nothing could be judged, no rate stands on the page.
#[test]
fn a_page_tells_no_speed_without_accuracy() {
    let mut run = throughput();
    // The medians of the sets, in both kinds of table.
    let rates = ["4.040 [", "2.525 [", "1.837 [", "1.443 [", "4.040 at ", "2.525 at ", "1.837 at ", "1.443 at "];
    let measured = |run: &Run| page(run).split("## Here").nth(1).unwrap().to_owned();
    let judged = measured(&run);
    assert!(rates.iter().all(|rate| judged.contains(rate)) && !judged.contains("– here"), "{judged}");
    take_judgements(&mut run);
    let silent = measured(&run);
    assert!(!rates.iter().any(|rate| silent.contains(rate)), "{silent}");
    assert!(silent.contains("– here, 3.47 published"), "{silent}");
}

/// A run of VVP16's tracer: rows with values, on the fixture's room.
fn abuffer(rows: &[&[(&str, &str)]], sets: &[(&str, Query)]) -> Run {
    let quality = Quality { missed: 0.01, blur: 1e-9, speed: 4.0, clock: ClockKind::DeviceTimestamps };
    let mut run = fixture::run(&vec![("fragment-abuffer", quality); rows.len()], sets);
    for (one, values) in run.runs.iter_mut().zip(rows) {
        one.tracer.parameters = values.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
        one.tracer.changed = values.iter().map(|(name, _)| (*name).to_owned()).collect();
        let counts = [("fragments", 3.0), ("pixels", 2.0), ("average_layers", 3.0), ("maximum_layers", 17.0)];
        one.structure_statistics = counts.iter().map(|(name, count)| ((*name).to_owned(), count * 1e6)).collect();
    }
    run
}

fn page_of(name: &str, run: &Run) -> String {
    let files = files(find(name).unwrap(), run).unwrap();
    let page = files.into_iter().find(|(file, _)| file.ends_with(".md")).unwrap();
    String::from_utf8(page.1).unwrap()
}

fn take_judgements(run: &mut Run) {
    for trace in run.runs.iter_mut().flat_map(|one| &mut one.traces) {
        match &mut trace.judgement {
            Judgement::Closest(closest) => (closest.agreement, closest.interval) = Default::default(),
            Judgement::Any(any) => any.occlusion.balanced_accuracy = None,
        }
    }
}

/// Table 1 of VVP16 sets what skipping gains beside the published gain of the same scene and bounces, two bounces added up, and
/// its counters; the scenes that stand for none have no published value.
#[test]
fn table_1_of_vvp16_stands_beside_its_scene() {
    let sets = [("diffuse", Query::Closest), ("bounce2", Query::Closest), ("ao", Query::Any)];
    let mut run = abuffer(&[&[("skipping", "on")], &[("skipping", "off")]], &sets);
    for (one, factor) in run.runs.iter_mut().zip([1.0, 3.0]) {
        for (trace, ms) in one.traces.iter_mut().zip([10.0, 30.0, 5.0]) {
            trace.times.submit_to_done_median_ms = Some(ms * factor);
            for (name, total) in [("pixels_visited", 800), ("pixels_opened", 200), ("fragments_tested", 900)] {
                let counter = trace.counters["nodes"].clone();
                trace.counters.insert(name.to_owned(), CounterRecord { total, ..counter });
            }
        }
    }
    let page = page_of("vvp16-table1", &run);
    // 284 over 54 ms printed for two bounces in Bunny, 121 over 21 for one.
    for part in
        ["40.00 at ", "120.0 at ", "| 4.50 | – | 75.0 |", "| 3.00 |", "| 5.26 |", "| 5.76 |", "| 128.0 | 2.400 |"]
    {
        assert!(page.contains(part), "no '{part}' in {page}");
    }
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| room | ao |")).collect();
    assert!(rows.len() == 1 && rows[0].ends_with("| – / – | – | – |"), "Bunny has no AO: {rows:?}");
    run.runs.iter_mut().for_each(|one| "barn".clone_into(&mut one.scene.name));
    assert!(!page_of("vvp16-table1", &run).contains("| 5.76 |"));
}

/// No page of VVP16's tells a trace's time where the rays could not be judged, nor does its chart.
#[test]
fn pages_of_vvp16_tell_no_time_without_accuracy() {
    let closest = |rays| vec![(rays, Query::Closest)];
    let ways = [["off", "off"], ["on", "off"], ["on", "on"]];
    let variants = ways.map(|[decoupled, skipping]| {
        ["storage", "decoupled", "skipping"].into_iter().zip(["dllb", decoupled, skipping]).collect::<Vec<_>>()
    });
    let variants: Vec<&[(&str, &str)]> = variants.iter().map(Vec::as_slice).collect();
    let skipping: [&[(&str, &str)]; 2] = [&[("skipping", "on")], &[("skipping", "off")]];
    let views: [&[(&str, &str)]; 2] = [&[("views", "seven")], &[("views", "frame")]];
    let bounces = vec![("diffuse", Query::Closest), ("bounce2", Query::Closest)];
    for (name, rows, sets) in [
        ("vvp16-table1", &skipping[..], bounces),
        ("vvp16-figure11", &views[..1], closest("diffuse")),
        ("vvp16-figure12", &variants[..], closest("pixel-random")),
        ("vvp16-views", &views[..], closest("diffuse")),
        ("dirt-table2", &views[..1], closest("diffuse")),
    ] {
        let mut run = abuffer(rows, &sets);
        for trace in run.runs.iter_mut().flat_map(|one| &mut one.traces) {
            trace.times.submit_to_done_median_ms = Some(77.25);
        }
        let times = |page: &str| page.matches("77.25").count() + page.matches("154.5").count();
        assert!(times(&page_of(name, &run)) > 0, "{name}");
        take_judgements(&mut run);
        assert_eq!(times(&page_of(name, &run)), 0, "{name}");
        let chart = |run: &Run| {
            let files = files(find(name).unwrap(), run).unwrap();
            files.into_iter().find(|(file, _)| file.ends_with(".svg")).map(|(_, svg)| String::from_utf8(svg).unwrap())
        };
        if let Some(chart) = chart(&run) {
            assert!(name == "vvp16-figure12" && chart.contains("nothing was measured"), "{name}");
        }
    }
}

/// Charts of whole, of missing and of odd values are drawn, with every label and setting in them.
#[test]
fn series_are_drawn_whatever_they_hold() {
    let run = throughput();
    let panel = |values: Vec<Option<f64>>| Panel {
        title: "Bytes".to_owned(),
        setting: "B".to_owned(),
        steps: ["8", "16", "24"].map(str::to_owned).to_vec(),
        quantity: "bytes (MiB)".to_owned(),
        series: [false, true]
            .map(|dashed| Series { label: "tiles".to_owned(), values: values.clone(), dashed })
            .to_vec(),
    };
    let (nothing, zero) = ("nothing was measured", "0 throughout");
    for (values, notes) in [
        (vec![Some(1.0), Some(2.0), Some(30.0)], [false, false]),
        (vec![Some(1.0), None, Some(2.0)], [false, false]),
        (vec![Some(0.0), Some(2.0), Some(0.0)], [false, false]),
        (vec![Some(0.0), None, Some(0.0)], [false, true]),
        (vec![Some(f64::NAN), None, Some(-1.0)], [true, false]),
        (vec![], [true, false]),
    ] {
        let chart = SeriesChart {
            stem: "figure_x".to_owned(),
            title: "Title".to_owned(),
            subtitle: "subtitle".to_owned(),
            key: Some(["solid", "broken"]),
            panels: vec![panel(values.clone()), panel(values)],
        };
        let drawn = series_chart(&run, &chart).unwrap();
        assert_eq!(drawn.iter().map(|file| file.name.as_str()).collect::<Vec<_>>(), ["figure_x.svg", "figure_x.png"]);
        let svg = std::str::from_utf8(&drawn[0].contents).unwrap();
        assert!(["tiles", "solid", "broken (dashed)", "24", "bytes (MiB)"].iter().all(|text| svg.contains(text)));
        assert!(!svg.contains("NaN") && [nothing, zero].map(|note| svg.contains(note)) == notes, "{svg}");
    }
}
