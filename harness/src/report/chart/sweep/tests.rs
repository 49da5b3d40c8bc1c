//! Charts of sweeps that were made up.

use tracebench_api::{ClockKind, Query};

use super::super::panel::{Mark, Scale};
use super::super::tests::check_charts;
use super::*;
use crate::report::fixture::{self, Quality};
use crate::report::group::groups;
use crate::report::sweep::tests::{Swept, sweep_run, tuned_run};
use crate::report::sweep::views;
use crate::results::{Judgement, place_name};
use crate::studies::tune::Tuning;

/// Draws every chart of a sweep, looks at each, and gives their names and SVGs.
fn check(record: &Record) -> Vec<(String, String)> {
    let groups = groups(record);
    let section = record.sweep.as_ref().unwrap();
    let report = sweep::report(record, section, &groups);
    let charts = || report.pages[0].1.charts();
    charts().map(|(stem, _)| format!("{stem}.svg")).zip(check_charts(charts())).collect()
}

const SETS: [(&str, Query); 2] = [("diffuse", Query::Closest), ("ao", Query::Any)];
const BUCKETS: Swept = ("buckets", "24", &["1", "4", "8", "16", "24", "32", "40"]);
const RESOLUTIONS: Swept = (RESOLUTION, "1", &["1/4", "1/2", "1", "2"]);
const CLIPS: Swept = ("clip", "polygon", &["polygon", "plane"]);

/// A chart for every axis and ray set, with every value, the clocks, the machine, and each rule where they differ.
#[test]
fn ordinary_sweeps() {
    let record = sweep_run(&[BUCKETS, RESOLUTIONS, CLIPS], &SETS, false);
    let drawn = check(&record);
    assert_eq!(drawn.len(), 3 * 2);
    let svg = |name: &str| &drawn.iter().find(|(found, _)| found == name).unwrap().1;
    for wanted in ["hit_miss", "tight", "footprint", ">\n40\n", "device timestamps", "Example Processor", "always-hit"]
    {
        assert!(svg("sweep_room_buckets_diffuse.svg").contains(wanted), "{wanted}");
    }
    assert!(svg("sweep_room_clip_ao.svg").contains("balanced accuracy"));
    assert!(!svg("sweep_room_clip_ao.svg").contains("skipped"));
    // The tracer's own value is the one that is shaded, and no line joins names.
    let groups = groups(&record);
    for view in views(record.sweep.as_ref().unwrap(), &groups, None) {
        for panel in chart(&record, &view).panels {
            let Scale::Steps(names, Some(own)) = &panel.x.scale else { panic!("{panel:?}") };
            assert_eq!(names[*own], view.axis.own);
            assert_eq!(panel.marks.iter().any(|mark| matches!(mark, Mark::Line { .. })), view.axis.name != "clip");
        }
    }
}

/// What was skipped is said in its place; a sweep of which nothing is left is drawn all the same.
#[test]
fn skipped_points() {
    let mut record = sweep_run(&[BUCKETS], &SETS, false);
    let gone = record.rows.pop().unwrap();
    let sweep = record.sweep.as_mut().unwrap();
    let point = sweep.points.iter_mut().find(|point| point.is_of(&gone)).unwrap();
    point.skipped.insert(gone.scene.name.clone(), "too large".to_owned());
    let drawn = check(&record);
    // Once in each of four panels.
    assert!(drawn.iter().all(|(_, svg)| svg.matches("skipped").count() == 4));
    // One run stays, on a point that is not of the sweep: it is shown nowhere.
    record.rows.truncate(1);
    record.rows[0].viewpoint.face += 1;
    assert!(check(&record).iter().all(|(_, svg)| svg.matches("nothing was measured").count() == 4));
}

/// Combinations: a curve a value of the second parameter, a panel a rule.
#[test]
fn grids() {
    let drawn = check(&sweep_run(&[BUCKETS, RESOLUTIONS], &SETS, true));
    assert_eq!(drawn.len(), 2);
    for wanted in ["resolution=1/4", "resolution=1 (own)", "wrong rays: tight", "wrong rays: footprint"] {
        assert!(drawn[0].1.contains(wanted), "{wanted}");
    }
}

/// As many values as there may be, names longer than any page, a single value.
#[test]
fn long_names_and_many_values() {
    let many: Vec<String> = (0..16).map(|index| format!("{}", 1000 * index)).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let long = "a most particular and very long value of it ".repeat(4);
    let longer = long.clone() + "again";
    let name = "a parameter with a very long name ".repeat(5);
    let record = sweep_run(
        &[("buckets", "0", &many), (&name, &long, &[&long, &longer, "b"]), ("clip", "a", &["a"])],
        &SETS,
        false,
    );
    assert_eq!(check(&record).len(), 3 * 2);
    check(&sweep_run(&[("buckets", "0", &many), (&name, &long, &[&long, &longer])], &SETS, true));
}

/// Figures that no run should have, and a run of nothing but ambiguous rays, which shows no speed.
#[test]
fn odd_figures() {
    let mut record = sweep_run(&[BUCKETS], &SETS, false);
    let oddities = [f64::NAN, f64::INFINITY, 0.0, -1.0, 1e300];
    for (odd, one) in oddities.into_iter().zip(&mut record.rows) {
        one.build.times.median_ms = odd;
        one.build.times.interval_ms = [odd, odd];
        one.memory.structure_bytes = u64::MAX;
        for trace in &mut one.traces {
            trace.mrays_per_s = odd;
            trace.times.interval_ms = [odd, odd];
        }
    }
    check(&record);
    let mut ambiguous_rays = sweep_run(&[BUCKETS], &[("diffuse", Query::Closest)], false);
    for trace in ambiguous_rays.rows.iter_mut().flat_map(|one| &mut one.traces) {
        if let Judgement::Closest(judgement) = &mut trace.judgement {
            (judgement.agreement, judgement.interval) = Default::default();
        }
    }
    // Neither errors nor speeds; memory and build are there.
    assert_eq!(check(&ambiguous_rays)[0].1.matches("nothing was measured").count(), 2);
}

/// Without a wrong ray, and with nothing but wrong ones.
#[test]
fn no_errors_and_nothing_but_errors() {
    for missed in [0.0, 1.0] {
        let mut record = sweep_run(&[BUCKETS], &SETS, false);
        let quality = Quality { missed, blur: missed, speed: 3.0, clock: ClockKind::Host };
        let other = fixture::run(&[("dirt", quality)], &SETS).rows.remove(0);
        record.rows.iter_mut().for_each(|one| one.traces.clone_from(&other.traces));
        check(&record);
    }
}

const THICKNESSES: [&str; 5] = ["0", "0.001", "0.01", "0.02", "0.1"];

/// What an SVG says, on however many lines.
fn words(svg: &str) -> String {
    svg.split(['<', '>']).step_by(2).flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

/// A chart a viewpoint and ray set, without times; what would be chosen stands below, and is where the dashes are.
#[test]
fn chosen_values() {
    let record = tuned_run(&THICKNESSES, &["room", "hall"], 2, &SETS);
    let drawn = check(&record);
    assert_eq!(drawn.len(), 2 * 2 * 2);
    let told = words(&drawn[0].1);
    for wanted in [
        "dirt over thickness: room",
        "viewpoint door",
        "footprint",
        "oracle",
        "Example Processor",
        "Upright dashes: default 0.001, tuned here 0.01, tuned elsewhere 0.02, tuned on the other scenes 0.02.",
    ] {
        assert!(told.contains(wanted), "{wanted}: {told}");
    }
    assert!(!told.contains("Mrays/s") && !told.contains("VOID"));
    let (groups, tuning) = (groups(&record), Tuning::of(&record));
    for view in views(record.sweep.as_ref().unwrap(), &groups, tuning.as_ref()) {
        let places = chosen(&view).into_iter().map(|(_, value)| THICKNESSES.iter().position(|each| *each == value));
        let places: Vec<f64> = places.map(|place| place.unwrap() as f64).collect();
        assert_eq!(places.len(), 4);
        for panel in chart(&record, &view).panels {
            let rule = |mark: &Mark| if let Mark::Rule(place) = mark { Some(*place) } else { None };
            assert_eq!(panel.marks.iter().filter_map(rule).collect::<Vec<_>>(), places);
        }
    }
    let mut invalid = record.clone();
    invalid.controls.remove(0);
    assert!(check(&invalid)[0].1.contains("VOID"));
    let alone = check(&tuned_run(&THICKNESSES, &["room"], 1, &SETS[..1]));
    assert!(alone.len() == 1 && !alone[0].1.contains("tuned elsewhere"));
}

/// What was skipped is said, names and long names find room, settings are told, and a set that only one viewpoint has is drawn.
#[test]
fn odd_choices() {
    let mut record = tuned_run(&THICKNESSES, &["room"], 2, &SETS);
    let gone = |row: &Row| row.tracer.parameters["thickness"] == "0.02";
    let points = &mut record.sweep.as_mut().unwrap().points;
    let point = points.iter_mut().find(|point| point.values["thickness"] == "0.02").unwrap();
    for (view, row) in record.rows.iter().filter(|row| gone(row)).enumerate() {
        point.skipped.insert(place_name(&row.scene, &row.viewpoint, view), "too large".to_owned());
    }
    record.rows.retain(|row| !gone(row));
    // In both panels; and in the table of every viewpoint and ray set.
    assert!(check(&record).iter().all(|(_, svg)| svg.matches("skipped").count() == 2));
    let page = sweep::untimed(&record).unwrap().pages[0].1.markdown();
    assert_eq!(page.matches("| 0.02 | skipped, see below |").count(), 4, "{page}");
    record.rows.clear();
    assert!(check(&record).iter().all(|(_, svg)| svg.matches("nothing was measured").count() == 2));
    let long = "a most particular and very long value of it ".repeat(4);
    let longer = long.clone() + "again";
    let scene = "scene & <name> of some length ".repeat(9);
    let mut named = tuned_run(&[&long, &longer, "b"], &[&scene], 2, &SETS);
    let tuned = named.tuning.iter_mut().flat_map(|tuning| &mut tuning.scenes[0].viewpoints);
    let rows = named.rows.iter_mut().chain(&mut named.controls).map(|row| &mut row.viewpoint);
    for viewpoint in tuned.chain(rows).filter(|viewpoint| viewpoint.name == "door") {
        viewpoint.name = "a viewpoint with a very long name ".repeat(5);
    }
    let drawn = check(&named);
    // Other settings are told below.
    assert!(drawn.len() == 4 && drawn.iter().all(|(_, svg)| words(svg).contains("stride=1")));
    // A set that only one viewpoint has.
    let mut half = tuned_run(&THICKNESSES, &["room"], 2, &SETS);
    for row in half.rows.iter_mut().chain(&mut half.controls).filter(|row| row.viewpoint.name == "window") {
        row.traces.remove(0);
    }
    assert_eq!(check(&half).len(), 3);
}
