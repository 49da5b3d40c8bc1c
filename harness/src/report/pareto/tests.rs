//! Pages, tables and charts of fronts over planted points.

use std::collections::{BTreeMap, BTreeSet};

use tempfile::TempDir;
use tracebench_api::{ClockKind, Query};

use crate::report::chart::front::Placed;
use crate::report::chart::{check_png, check_svg};
use crate::report::fixture::{self, FrontQuality, Quality, configs, rows, write_derived, write_run};
use crate::report::read_run;
use crate::results::{Judgement, Record};
use crate::studies::pareto::{By, Cost};

const SETS: [(&str, Query); 2] = [("diffuse", Query::Closest), ("ao", Query::Any)];

fn planted(name: &str, missed: f64, speed: f64, mib: u64, build: f64) -> FrontQuality<'_> {
    let quality = Quality { missed, blur: 1e-4 * missed, speed, clock: ClockKind::SubmitToDone };
    FrontQuality { name, quality, mib, build }
}

fn several() -> Record {
    let points = [
        planted("exact", 0.0, 1.0, 40, 4.0),
        planted("exact:improved", 0.0, 2.0, 50, 5.0),
        planted("rough", 0.2, 9.0, 8, 1.0),
        planted("rough", 0.3, 5.0, 20, 3.0),
        planted("fair", 0.0004, 4.0, 30, 0.5),
    ];
    fixture::fronts(&points, &SETS, 30.0)
}

/// Rows that are points of fronts.
fn points(folder: &TempDir) -> Vec<BTreeMap<String, String>> {
    configs(folder.path()).into_iter().filter(|row| !row["order"].is_empty()).collect()
}

/// Proves that a record of fronts has its page, tables and charts, that they are made again the same from what was written, and that
/// every chart is whole and names scene, rays and machine.
#[test]
fn fronts_have_their_files() {
    let folder = TempDir::new().unwrap();
    let record = several();
    let written = write_run(&record, folder.path(), fixture::tables).unwrap();
    let names: Vec<String> =
        written.iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect();
    for wanted in [
        "pareto.md",
        "operating_points.csv",
        "break_even.csv",
        "rows.csv",
        "pareto_room_diffuse_footprint.svg",
        "pareto_room_diffuse_footprint_costs.svg",
        "pareto_room_diffuse_tight.svg",
        "pareto_room_diffuse_footprint_matched.png",
        "pareto_room_diffuse_break_even.svg",
        "pareto_room_ao_balanced_accuracy.svg",
    ] {
        assert!(names.iter().any(|name| name == wanted), "{wanted}: {names:?}");
    }
    let read = || written.iter().map(|path| std::fs::read(path).unwrap()).collect::<Vec<_>>();
    let before = read();
    write_derived(&read_run(folder.path()).unwrap(), folder.path(), fixture::tables).unwrap();
    assert!(before == read());
    for (name, contents) in names.iter().zip(&before) {
        if name.ends_with(".svg") {
            let svg = std::str::from_utf8(contents).unwrap();
            check_svg(name, svg);
            for wanted in
                ["Example Processor", "room", "always-miss"].iter().take(if name.contains("break") { 2 } else { 3 })
            {
                assert!(svg.contains(wanted), "{name}: {wanted}");
            }
        } else if name.ends_with(".png") {
            check_png(name, contents);
        }
    }
}

/// Proves that of thirteen tracers in one place each is named, none on a marker: names that lie away have a line from their point.
#[test]
fn crowded_points_are_all_named() {
    let names: Vec<String> = (0..13).map(|index| format!("crowded-{index}:improved")).collect();
    let of = |(index, name)| planted(name, 0.1, 4.0 + 1e-3 * f64::from(index), 8, 1.0);
    let points: Vec<_> = (0_u32..).zip(names.iter().map(String::as_str)).map(of).collect();
    let record = fixture::fronts(&points, &SETS, 30.0);
    let section = record.pareto.as_ref().unwrap();
    let field = &crate::studies::pareto::fields(&record, section, &section.scenes[0])[0];
    let chart =
        crate::report::chart::front::fronts(field, *By::all(field.query).last().unwrap(), |cost| cost == Cost::Trace);
    let (_, layer) = chart.layers().next().unwrap();
    let named: BTreeSet<&str> = layer.names.iter().map(|name| &*name.point.tracer).collect();
    assert_eq!(named.len(), names.len(), "{named:?}");
    assert!(layer.names.iter().any(|name| name.leader.is_empty()));
    assert!(layer.names.iter().any(|name| name.leader.len() == 2));
    for name in &layer.names {
        let of = layer.points.iter().find(|placed| placed.point.index == name.point.index).unwrap();
        assert!(name.leader.first().is_none_or(|from| *from == of.place));
        let covered = |placed: &Placed<'_>| {
            let (x, y) = placed.place;
            (name.place.1 - y).abs() < 6.0 && x > name.place.0 && x < name.place.0 + 30.0
        };
        assert!(!layer.points.iter().any(covered), "{name:?}");
    }
}

/// Proves that a page tells which level so few rays cannot tell, and of no other level; of many rays it says so of none.
#[test]
fn levels_that_few_rays_cannot_tell_are_named() {
    let page_of = |count: u64| {
        let mut record = several();
        record.rows.iter_mut().flat_map(|row| &mut row.traces).for_each(|trace| trace.count = count);
        let folder = TempDir::new().unwrap();
        write_run(&record, folder.path(), fixture::tables).unwrap();
        std::fs::read_to_string(folder.path().join("pareto.md")).unwrap()
    };
    let page = page_of(29_999);
    assert!(page.contains("| diffuse | 99.99 % by footprint (**29,999 rays are too few to tell**) |"), "{page}");
    assert!(page.contains("| diffuse | 99.90 % by footprint |"), "{page}");
    assert!(!page_of(30_000).contains("too few to tell"));
}

/// Proves that tables tell the standings of the planted points: who is on the front, and what an operating point loses elsewhere; that
/// no control is among the points; and that the page says the same.
#[test]
fn tables_tell_standings() {
    let folder = TempDir::new().unwrap();
    write_run(&several(), folder.path(), fixture::tables).unwrap();
    let points = points(&folder);
    let diffuse: Vec<_> = points.iter().filter(|row| row["rays"] == "diffuse").collect();
    assert_eq!((points.len(), diffuse.len()), (10, 5));
    let column = |name: &str| diffuse.iter().map(|row| row[name].as_str()).collect::<Vec<_>>();
    assert_eq!(column("tracer_name"), ["exact", "exact", "rough", "rough", "fair"]);
    assert_eq!(column("front_hit_miss_speed"), ["behind", "front", "front", "behind", "front"]);
    assert_eq!(column("own_front_hit_miss_speed"), ["behind", "front", "front", "behind", "front"]);
    assert_eq!(column("front_hit_miss_bytes"), ["front", "behind", "front", "behind", "front"]);
    assert!(column("front_balanced_accuracy_speed").iter().all(|cell| cell.is_empty()));
    let operating = rows(folder.path(), "operating_points.csv");
    let of = |who: &str, level: &str| {
        let wanted = |row: &&BTreeMap<String, String>| {
            row["rays"] == "diffuse"
                && row["rule"] == "hit_miss"
                && (row["of"] == who && row["at_least_share"] == level && row["aim"] == "fastest")
        };
        operating.iter().find(wanted).map(|row| (row["tracer"].as_str(), row["held_out"].as_str()))
    };
    assert_eq!(of("all", "0.99"), Some(("fair", "misses")));
    assert_eq!(of("exact", "0.9999"), Some(("exact", "holds")));
    assert_eq!(of("rough", "0.99"), None);
    let page = std::fs::read_to_string(folder.path().join("pareto.md")).unwrap();
    assert!(
        page.contains(
            "| diffuse | 99.90 % by footprint | fair stride=5: 4.003; **misses there** | fair stride=5: 33.34;"
        ),
        "{page}"
    );
    assert!(
        page.contains("| diffuse | 99.99 % by footprint | exact:improved stride=2: 2.011 | exact stride=1: 43.34 |"),
        "{page}"
    );
    for wanted in ["misses by", "holds", "How far each tracer gets", "window", "● ", "| 99.99 % | exact |"] {
        assert!(page.contains(wanted), "{wanted}");
    }
    assert!(!page.contains("NaN") && !page.contains("oracle stride"));
}

/// Proves that a ray set of which no ray hits anything has no front, and that the others keep theirs; and that a page warns where rays go
/// through the samples of structures, and nowhere else.
#[test]
fn rays_that_tell_nothing_are_told() {
    let page_of = |record: &Record| {
        let folder = TempDir::new().unwrap();
        write_run(record, folder.path(), fixture::tables).unwrap();
        (std::fs::read_to_string(folder.path().join("pareto.md")).unwrap(), points(&folder).len())
    };
    // The frames of the planted points are the ray image.
    let record = several();
    let (page, points) = page_of(&record);
    let [width, height] = record.pareto.as_ref().unwrap().scenes[0].viewpoint.ray_image;
    assert!(page.contains("### diffuse") && page.contains("### ao"), "{page}");
    assert!(page.contains(&format!("Rays from {width}x{height} pixels go through the samples")), "{page}");
    let mut apart = record.clone();
    apart.rows.iter_mut().for_each(|row| row.viewpoint.frame = [510, 254]);
    apart.pareto.as_mut().unwrap().points.iter_mut().for_each(|point| point.frame = [510, 254]);
    let (page, others) = page_of(&apart);
    assert!(!page.contains("go through the samples") && others == points, "{page}");
    let mut record = several();
    for trace in record.rows.iter_mut().flat_map(|row| &mut row.traces).filter(|trace| trace.rays == "diffuse") {
        let Judgement::Closest(closest) = &mut trace.judgement else { panic!("closest") };
        let classes = &mut closest.classes.tight;
        classes.true_miss += classes.true_hit + classes.false_miss + classes.early + classes.late;
        (classes.true_hit, classes.false_miss, classes.early, classes.late) = (0, 0, 0, 0);
    }
    let (page, fewer) = page_of(&record);
    assert!(!page.contains("### diffuse") && page.contains("### ao") && 2 * fewer == points, "{page}");
}

/// Without a check elsewhere it is said so; points that could not be timed or judged are in no front, and pages are drawn all the same.
#[test]
fn what_is_missing_is_said() {
    let mut record = several();
    let section = record.pareto.as_mut().unwrap();
    section.scenes[0].held_out = None;
    section.scenes[0].held_out_skipped = Some("nothing is seen from anywhere".to_owned());
    section.scenes[0].ray_images.clear();
    for row in &mut record.rows {
        row.build.times.invalid = Some("a clock that lies".to_owned());
    }
    let folder = TempDir::new().unwrap();
    write_run(&record, folder.path(), fixture::tables).unwrap();
    let page = std::fs::read_to_string(folder.path().join("pareto.md")).unwrap();
    assert!(page.contains("not checked elsewhere**: nothing is seen") && page.contains("there not checked"));
    let told = points(&folder);
    assert!(told.iter().all(|row| row["build_ms"].is_empty() && row["front_tight_build"].is_empty()));
    assert!(told.iter().any(|row| row["front_tight_speed"] == "front"));
    // Without a second number of rays there is no line.
    assert_eq!(rows(folder.path(), "break_even.csv").len(), 0);
    // A record in which nothing was measured.
    record.rows.clear();
    write_run(&record, folder.path(), fixture::tables).unwrap();
    assert_eq!(points(&folder).len(), 0);
}
