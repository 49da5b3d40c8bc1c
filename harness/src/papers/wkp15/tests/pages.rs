//! Pages of WKP15's tables: what stands on them, and that no time stands there without its accuracy.

use serde_json::json;

use super::{figure_14, quadtree, table_1, table_2, table_5};
use crate::papers::fixture::{page_of, run_of, set_build, set_time, take_judgements};
use crate::papers::{find, report};
use crate::results::{Record, Row};

/// Table 2 sets peers beside one layer, traces and frames, and the same of the paper beside these, of scenes that stand for its own.
#[test]
fn table_2_stands_beside_the_papers() {
    let mut rows = table_2("atrium");
    rows.iter_mut().for_each(|row| set_build(row, 5.0));
    let mut record = run_of(rows);
    let page = page_of("wkp15-table2", &record);
    // DDA of one layer: 40 over 10 and 85 over 25 ms here, 6.06 over 1.1 and 12.71 over 3.43 printed.
    let own = |name: &str| page.lines().find(|line| line.contains(name)).unwrap().to_owned();
    let dda = own("| atrium | screen-dda");
    for part in ["40.00 at ", "| 4.00 | 5.51 |", "| 85.00 | 3.40 | 3.71 |", "| 60.00 |"] {
        assert!(dda.contains(part), "no '{part}' in {dda}");
    }
    assert!(own("| atrium | quadtree").contains("| 1.00 | 1.00 |") && page.contains("| 25.0 |"), "{page}");
    let mesh = own("| atrium | mesh-warp");
    // 15 over 10 here, 1.47 over 1.1 printed.
    assert!(mesh.contains("| 1.50 | 1.34 |"), "{mesh}");
    assert!(page.contains("atrium stands for the paper's SPONZA"), "{page}");
    record.rows.iter_mut().for_each(|one| "barn".clone_into(&mut one.scene.name));
    assert!(!page_of("wkp15-table2", &record).contains("| 4.00 | 5.51 |"));
}

/// Table 1 tells the phases of the trees apart from those that draw, a line a scale of a scene; scales that the table is about stand for
/// the paper's scenes, others do not.
#[test]
fn table_1_tells_phases_apart() {
    let mut record =
        run_of([table_1("candy", 1.0, [2.0, 9.0, 1.0]), table_1("candy", 15.5, [2.5, 90.0, 5.0])].concat());
    let page = page_of("wkp15-table1", &record);
    for part in ["| candy at scale 15.5 |", "| 2.500 | 90.00 | 6550 | 0.657 |", "stands for the paper's SANMIGUEL"] {
        assert!(page.contains(part), "no '{part}' in {page}");
    }
    assert!(page.contains("candy at scale 1 |"), "{page}");
    record.rows.iter_mut().for_each(|one| one.scene.scale = Some(2.0));
    assert!(!page_of("wkp15-table1", &record).contains("stands for the paper's SANMIGUEL"));
}

/// Table 5 has three bounces over one beside the published ratio of as many layers and as many samples, and of no others.
#[test]
fn table_5_stands_beside_the_papers() {
    let mut record = run_of(table_5());
    let without = page_of("wkp15-table5", &record);
    assert!(
        without.contains("19.00 at ") && !without.contains("| 1.78 |") && !without.contains("| 1.83 |"),
        "{without}"
    );
    for one in &mut record.rows {
        one.tracer.parameters.insert("secondary_samples".to_owned(), json!(8));
    }
    let page = page_of("wkp15-table5", &record);
    // 12.38 over 6.96 and 24.75 over 13.5 printed.
    for part in ["| 1.90 |", "| 2.00 |", "| 1.78 |", "| 1.83 |", "19.00 at ", "40.00 at "] {
        assert!(page.contains(part), "no '{part}' in {page}");
    }
}

/// Every set of a run takes as long by the host's clock.
fn in_time(mut record: Record) -> Record {
    for trace in record.rows.iter_mut().flat_map(|one| &mut one.traces) {
        trace.times.submit_to_done_median_ms = Some(77.25);
    }
    record
}

/// No page tells a trace's time where the rays could not be judged, nor does a chart.
#[test]
fn no_time_without_accuracy() {
    let one = || -> Vec<Row> { vec![quadtree("room", serde_json::json!({}))] };
    for (name, rows) in [
        ("wkp15-table1", one()),
        ("wkp15-table2", table_2("room")),
        ("wkp15-table3", table_2("room")),
        ("wkp15-table4", one()),
        ("wkp15-table5", table_5()),
        ("wkp15-figure14", figure_14()),
        ("wkp15-figure15", figure_14()),
        ("wkp15-lightfield", one()),
        ("wkp15-text", one()),
    ] {
        let mut record = in_time(run_of(rows));
        // Three bounces are 231.75.
        let times =
            |page: &str| ["77.25", "231.7", "231.8"].map(|time| page.matches(time).count()).iter().sum::<usize>();
        let charts = |record: &Record| -> Vec<String> {
            let (paper, experiment) = find(name).unwrap();
            let made = report(paper, experiment, record).unwrap().contents().unwrap();
            let svg = made.into_iter().filter(|(file, _)| file.ends_with(".svg"));
            svg.map(|(_, svg)| String::from_utf8(svg).unwrap()).collect()
        };
        assert!(name == "wkp15-table1" || times(&page_of(name, &record)) > 0, "{name}");
        assert!(charts(&record).iter().all(|chart| !chart.contains("nothing was measured")), "{name}");
        take_judgements(&mut record);
        assert_eq!(times(&page_of(name, &record)), 0, "{name}");
        assert!(charts(&record).iter().all(|chart| chart.contains("nothing was measured")), "{name}");
        assert_eq!(charts(&record).len(), usize::from(name.contains("figure")), "{name}");
    }
}

/// Every experiment's page is made of any run that holds one of its tracers, whatever rows there are.
#[test]
fn pages_are_made_of_any_run() {
    let mut rows = table_2("room");
    rows.iter_mut().for_each(|row| set_time(row, "lens", 1.0));
    let record = run_of(rows);
    for experiment in super::PAPER.experiments.iter() {
        let made = report(&super::PAPER, experiment, &record).unwrap().contents().unwrap();
        assert!(made.iter().any(|(file, _)| file.ends_with(".md")), "{}", experiment.name);
    }
}
