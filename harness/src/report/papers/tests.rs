//! Pages of experiments: what stands on them, and that no speed stands there without its accuracy.

use std::collections::BTreeMap;

use serde_json::json;
use tracebench_api::{ClockKind, Query};

use super::files;
use crate::papers::find;
use crate::report::chart::series::{Panel, Series, SeriesChart, series_chart};
use crate::report::fixture::{self, Quality};
use crate::results::{Judgement, Run};

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
    for trace in run.runs.iter_mut().flat_map(|one| &mut one.traces) {
        match &mut trace.judgement {
            Judgement::Closest(closest) => (closest.agreement, closest.interval) = Default::default(),
            Judgement::Any(any) => any.occlusion.balanced_accuracy = None,
        }
    }
    let silent = measured(&run);
    assert!(!rates.iter().any(|rate| silent.contains(rate)), "{silent}");
    assert!(silent.contains("– here, 3.47 published"), "{silent}");
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
