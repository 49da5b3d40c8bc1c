//! Page, table and chart of needs over planted counts.

use std::collections::BTreeMap;

use tempfile::TempDir;
use tracebench_api::{ClockKind, Query};

use crate::report::chart::{check_png, check_svg};
use crate::report::fixture::{self, Quality, write_run};
use crate::results::{ChangedRays, CounterRecord, NeedCurve, NeedPoint, NeedRecord, Record, Rule};

/// A tracer from two viewpoints: fewer buckets lose so many of 100,000 rays.
fn planted() -> Record {
    let quality = Quality { missed: 0.0, blur: 1e-9, speed: 4.0, clock: ClockKind::Host };
    let buckets = ["24", "8", "4"];
    let named = buckets.map(|_| ("dirt", quality));
    let mut record = fixture::run(&[], &[]);
    record.skipped.clear();
    let mut curves = Vec::new();
    for (view, (name, lost)) in [("door", [0_u64, 30, 900]), ("window", [0, 700, 900])].into_iter().enumerate() {
        let mut made = fixture::run(&named, &[("diffuse", Query::Closest)]);
        let mut points = Vec::new();
        for (place, row) in made.rows.iter_mut().enumerate() {
            row.viewpoint.name = name.to_owned();
            row.tracer.parameters.insert("buckets".to_owned(), buckets[place].into());
            row.memory.structure[0].name = "nodes (texture)".to_owned();
            row.memory.structure_bytes = 32 << (20 - place);
            row.structure_statistics.insert("references".to_owned(), 1000.0);
            let counter = CounterRecord { total: 250, per_ray: 0.0, max_per_ray: None };
            row.traces[0].counters.insert("references_touched".to_owned(), counter);
            let shrunk = (place > 0).then(|| ("buckets".to_owned(), buckets[place].to_owned()));
            let changed = ChangedRays { rays: 100_000, newly_wrong: lost[place], newly_right: 0 };
            points.push(NeedPoint {
                shrunk: shrunk.into_iter().collect(),
                parameters: row.tracer.parameters.clone(),
                frame: row.viewpoint.frame,
                face: row.viewpoint.face,
                skipped: None,
                changed: BTreeMap::from([("diffuse".to_owned(), changed)]),
            });
        }
        curves.push(NeedCurve {
            scene: made.rows[0].scene.name.clone(),
            scene_sha256: made.rows[0].scene.sha256.clone(),
            viewpoint: name.to_owned(),
            view: view as u32,
            tracer: "dirt".to_owned(),
            preset: "published".to_owned(),
            rule: Rule::Tight,
            points,
        });
        record.rows.extend(made.rows);
    }
    record.need = Some(NeedRecord { max_lost_share: 0.001, max_slowdown: 1.25, curves });
    record
}

/// Proves that the page says what is needed, stored and touched; that the table has a row a
/// structure with the counts; and that the chart is whole.
#[test]
fn needs_have_their_files() {
    let folder = TempDir::new().unwrap();
    let written = write_run(&planted(), folder.path(), fixture::tables).unwrap();
    let page = std::fs::read_to_string(folder.path().join("need.md")).unwrap();
    // A quarter of the 6 MiB of the part that holds references.
    let first = "| dirt | door | tight | 99.9977 % [99.99327, 99.99922] | 32.00 | 1.500 | 16.00 | buckets=8 | 16.00 | buckets=8 | buckets: 8, 4 is too small |";
    assert!(page.contains(first), "{page}");
    assert!(page.contains("buckets: not at all, 8 is too small"), "{page}");
    assert!(page.contains("a rule needs two scenes"), "{page}");
    let told: Vec<String> = fixture::configs(folder.path()).iter().map(|row| row["newly_wrong_rays"].clone()).collect();
    assert_eq!(told, ["", "30", "900", "", "700", "900"]);
    let chart = |end: &str| written.iter().find(|path| path.ends_with(format!("need_room.{end}"))).unwrap();
    let svg = std::fs::read_to_string(chart("svg")).unwrap();
    check_svg("need", &svg);
    for panel in ["needed (MiB)", "needed in time (MiB)", "touched (MiB)"] {
        assert!(svg.contains(&format!("diffuse: {panel}")), "{panel}");
    }
    // A marker a viewpoint: so many as the panels without viewpoints have none of.
    let markers = |record: &Record| {
        let folder = TempDir::new().unwrap();
        write_run(record, folder.path(), fixture::tables).unwrap();
        std::fs::read_to_string(folder.path().join("need_room.svg")).unwrap().matches("<use ").count()
    };
    let (both, mut one) = (planted(), planted());
    one.need.as_mut().unwrap().curves.truncate(1);
    assert_eq!(markers(&both), markers(&one) + 3);
    check_png("need", &std::fs::read(chart("png")).unwrap());
}

/// A record in which nothing shrinks, and one in which nothing was measured, have their pages.
#[test]
fn nothing_to_shrink_is_said() {
    let folder = TempDir::new().unwrap();
    let mut record = planted();
    for curve in &mut record.need.as_mut().unwrap().curves {
        curve.points.truncate(1);
    }
    write_run(&record, folder.path(), fixture::tables).unwrap();
    let page = std::fs::read_to_string(folder.path().join("need.md")).unwrap();
    assert!(page.contains("nothing shrinks") && page.contains("the whole"));
    record.rows.clear();
    let written = write_run(&record, folder.path(), fixture::tables).unwrap();
    assert!(written.iter().all(|path| path.extension().is_none_or(|end| end != "svg")));
}

/// Proves that of two scenes each has its chart; that the page counts the cases in which steps are enough; that a rule which loses rays in the
/// scene that it was not made of is shown to lose them there, from the worst viewpoint; and that without that viewpoint it holds.
#[test]
fn rules_that_lose_are_shown_to() {
    let mut record = planted();
    let mut other = planted();
    for row in &mut other.rows {
        "hall".clone_into(&mut row.scene.name);
        "hall".clone_into(&mut row.scene.sha256);
    }
    let mut curve = other.need.unwrap().curves.remove(0);
    (curve.scene, curve.scene_sha256) = ("hall".to_owned(), "hall".to_owned());
    record.need.as_mut().unwrap().curves.push(curve);
    record.rows.append(&mut other.rows);
    let page = |record: &Record| {
        let folder = TempDir::new().unwrap();
        write_run(record, folder.path(), fixture::tables).unwrap();
        for scene in ["room", "hall"] {
            assert!(folder.path().join(format!("need_{scene}.svg")).is_file());
        }
        std::fs::read_to_string(folder.path().join("need.md")).unwrap()
    };
    let both = page(&record);
    for wanted in [
        "| dirt | buckets=8 | 50.0 | 3 | 2 | 0 | 1 | 0 |",
        "| dirt | buckets=4 | 25.0 | 3 | 0 | 0 | 3 | 0 |",
        "| dirt | all scenes | the whole | 100.0 | – | – | – |",
        "| dirt | all but room | buckets=8 | 50.0 | 0.700 [0.648, 0.752] | 1.00 [1.00, 1.00] | not enough |",
        "| dirt | all but hall | the whole | 100.0 | – | – | – |",
        "0 of 1 that ask for less than the whole are enough there",
    ] {
        assert!(both.contains(wanted), "{wanted}: {both}");
    }
    record.need.as_mut().unwrap().curves.remove(1);
    let one = page(&record);
    assert!(
        one.contains("| dirt | all scenes | buckets=8 | 50.0 | 0.0300 [0.0191, 0.0409] | 1.00 [1.00, 1.00] | enough |"),
        "{one}"
    );
    assert!(
        one.contains("2 of 2 that ask for less than the whole are enough there") && !one.contains("| not enough |\n"),
        "{one}"
    );
}
