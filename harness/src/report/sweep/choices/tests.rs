//! What is made of sweeps by which a value is chosen.

use std::collections::BTreeMap;

use tempfile::TempDir;
use tracebench_api::Query;

use crate::files::OutputFolder;
use crate::report::fixture::{self, configs, write_derived, write_run};
use crate::report::read_run;
use crate::report::sweep::tests::tuned_run;
use crate::report::sweep::untimed;
use crate::results::{Judgement, Record, Row, TraceRecord};
use crate::studies::tune::{Label, Tuning};

const SETS: [(&str, Query); 2] = [("diffuse", Query::Closest), ("ao", Query::Any)];
const VALUES: [&str; 5] = ["0", "0.001", "0.01", "0.02", "0.1"];

fn typical() -> Record {
    tuned_run(&VALUES, &["room", "hall"], 2, &SETS)
}

fn page(record: &Record) -> String {
    untimed(record).unwrap().pages[0].1.markdown()
}

/// Proves that a record read back is the same and makes the same files, a page, tables and a chart a viewpoint and ray set; that charts of
/// an earlier one go while others, and the user's, stay.
#[test]
fn files_can_be_made_again() {
    let (folder, elsewhere) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let earlier = OutputFolder::open(folder.path()).unwrap();
    earlier.write_all([("sweep_gone.svg", &b"old"[..]), ("figure_stays.svg", b"old")]).unwrap();
    drop(earlier);
    std::fs::write(folder.path().join("sweep_mine.svg"), "mine").unwrap();
    let paths = write_run(&typical(), folder.path(), fixture::tables).unwrap();
    let names: Vec<_> = paths.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names[..4], ["run.json", "sweep.md", "rows.csv", "wrong_rays.csv"]);
    let charts = |begin: &str| names.iter().filter(|name| name.starts_with(begin)).count();
    // Two viewpoints, two ray sets, two formats.
    assert_eq!((charts("sweep_room-"), charts("sweep_hall-"), names.len()), (8, 8, 4 + 8 + 8), "{names:?}");
    let stands = |name: &str| folder.path().join(name).exists();
    assert_eq!(["sweep_gone.svg", "figure_stays.svg", "sweep_mine.svg"].map(stands), [false, true, true]);
    let again = read_run(folder.path()).unwrap();
    assert_eq!(again, typical());
    for path in write_derived(&again, elsewhere.path(), fixture::tables).unwrap() {
        let name = path.file_name().unwrap();
        assert!(std::fs::read(&path).unwrap() == std::fs::read(folder.path().join(name)).unwrap(), "{name:?} differs");
    }
    // A record that lost its section is one of a sweep.
    assert!(Tuning::of(&Record { tuning: None, ..again }).is_none());
    let text = std::fs::read_to_string(folder.path().join("run.json")).unwrap();
    assert!(text.contains("\"rule\":\"footprint\"") && !text.contains("tuned"), "{text:.300}");
}

/// Proves that the table tells every value with its labels, its wrong rays by the rule, and what it loses: against the classes
/// of the record, counted here.
#[test]
fn the_table_tells_what_each_value_loses() {
    let made = typical();
    let tuning = Tuning::of(&made).unwrap();
    let folder = TempDir::new().unwrap();
    write_run(&made, folder.path(), fixture::tables).unwrap();
    let rows = configs(folder.path());
    assert_eq!(rows.len(), 2 * 2 * 2 * VALUES.len());
    let of = |scene: &str, view: &str, rays: &str| {
        let is_there = |row: &&BTreeMap<String, String>, value: &str| {
            [&row["scene"], &row["viewpoint"], &row["rays"]] == [scene, view, rays]
                && row["values_json"] == format!(r#"{{"thickness":"{value}"}}"#)
        };
        VALUES.map(|value| rows.iter().find(|row| is_there(row, value)).unwrap())
    };
    let labels = |row: &BTreeMap<String, String>| {
        let of = ["is_default", "is_tuned_here", "is_tuned_elsewhere", "is_tuned_on_the_other_scenes"];
        of.map(|name| row[name].parse::<bool>().unwrap())
    };
    // From the door the third value is best, from the window the fourth; in the hall each is one further.
    let none = [false; 4];
    assert_eq!(
        of("room", "door", "diffuse").map(labels),
        [none, [true, false, false, false], [false, true, false, false], [false, false, true, true], none]
    );
    let set = &tuning.sets[0];
    let judged = |value: &str| match &set.trace(value).unwrap().judgement {
        Judgement::Closest(closest) => closest,
        Judgement::Any(_) => panic!("another query"),
    };
    for (value, row) in VALUES.into_iter().zip(of("room", "door", "diffuse")) {
        let closest = judged(value);
        let classes = &closest.classes.footprint;
        let counted = ["false_miss", "false_hit", "early", "late"]
            .map(|class| row[&format!("footprint_{class}_rays")].parse::<u64>().unwrap());
        assert_eq!(counted, [classes.false_miss, classes.false_hit, classes.early, classes.late]);
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        let trials = (fixture::COUNT - closest.left_out()) as f64;
        let score = (classes.true_hit + classes.true_miss) as f64 / trials;
        assert_eq!(number("agreement_footprint_share"), score);
        let [low, high] = closest.interval.footprint.unwrap();
        assert_eq!((number("agreement_footprint_share_low"), number("agreement_footprint_share_high")), (low, high));
        assert_eq!(number("lost_to_tuned_here_share"), judged(VALUES[2]).agreement.footprint.unwrap() - score);
        assert!(row["balanced_accuracy_share"].is_empty());
    }
    for row in of("room", "window", "ao") {
        assert!(row["agreement_tight_share"].is_empty() && !row["balanced_accuracy_share"].is_empty(), "{row:?}");
        let best: f64 = row["lost_to_tuned_here_share"].parse().unwrap();
        assert_eq!(best == 0.0, row["is_tuned_here"] == "true", "{row:?}");
    }
}

/// Proves that the page names every label with its value and loss, and every value with its labels; sets losses in bold only where
/// intervals are apart; and says when a control fails or is missing.
#[test]
fn the_page_labels_values_honestly() {
    let made = typical();
    let told = page(&made);
    let line =
        |page: &str, begin: &str| page.lines().find(|line| line.starts_with(begin)).unwrap_or_default().to_owned();
    let overview = line(&told, "| room | door | ");
    let values: Vec<&str> =
        overview.split(" | ").skip(2).take(4).map(|cell| cell.split_once(": ").unwrap().0).collect();
    assert_eq!(values, ["0.001", "0.01", "0.02", "0.02"], "{told}");
    assert!(told.contains("tuned elsewhere: value, share ↑ |") && told.contains("### ao: "), "{told}");
    assert!(line(&told, "| 0.01 |").contains("| tuned here |"), "{told}");
    assert!(line(&told, "| 0.02 |").contains("| tuned elsewhere, tuned on the other scenes |"), "{told}");
    assert!(told.contains("## room (156,034 triangles) from window") && told.contains("Nothing was timed."), "{told}");
    assert!(told.contains("no \\| place") && told.contains("all score what they must"));
    // One value beside the best loses a twentieth of the hits, which is beyond any interval.
    assert!(told.contains("| **+4.3"), "{told}");
    let mut same = made.clone();
    let first = same.rows[0].traces.clone();
    same.rows.iter_mut().for_each(|row| row.traces.clone_from(&first));
    let told = page(&same);
    let here = line(&told, "| room | door | ").split(" | ").nth(3).unwrap_or_default().to_owned();
    assert!(!told.contains("**+") && !told.contains("**-") && here.starts_with("0: "), "{told}");
    let of = |name: &str, scene: &str, view: &str, record: &Record| {
        let is_it = |row: &Row| [&row.tracer.name, &row.scene.name, &row.viewpoint.name] == [name, scene, view];
        record.controls.iter().position(is_it).unwrap()
    };
    let mut invalid = made.clone();
    invalid.controls.remove(of("oracle", "hall", "window", &made));
    let told = page(&invalid);
    assert!(told.contains("**the record is invalid**: oracle is missing on diffuse of hall from window"), "{told}");
    let mut wrong = made.clone();
    wrong.controls[of("oracle", "room", "door", &made)].traces =
        made.controls[of("always-miss", "room", "door", &made)].traces.clone();
    assert!(page(&wrong).contains("oracle fails on diffuse of room from door"));
}

/// Proves that one viewpoint, one scene and nothing but ambiguous rays leave a page that says so.
#[test]
fn nothing_to_choose_by() {
    let mut made = tuned_run(&VALUES, &["room"], 1, &SETS[..1]);
    // Neither elsewhere nor on other scenes.
    let told = page(&made);
    assert_eq!(told.matches("nothing to choose by").count(), 2, "{told}");
    for trace in made.rows.iter_mut().flat_map(|row| &mut row.traces) {
        let TraceRecord { judgement: Judgement::Closest(judgement), .. } = trace else { panic!("another query") };
        (judgement.agreement, judgement.interval) = Default::default();
    }
    let told = page(&made);
    assert_eq!(told.matches("nothing to choose by").count(), 3, "{told}");
    // Of every value, by each of three rules.
    assert_eq!(told.matches("every ray is ambiguous").count(), 3 * VALUES.len(), "{told}");
    let tuning = Tuning::of(&made).unwrap();
    assert_eq!(tuning.sets[0].score(tuning.sets[0].chosen(Label::Default).unwrap()), None);
}
