//! The report against made-up runs.

use std::collections::BTreeMap;

use tempfile::TempDir;
use tracebench_api::{ClockKind, Query};

use super::fixture::{write_derived, write_run};
use super::*;
use crate::files::FileError;
use crate::measure::controls::Control;
use crate::results::{Classes, ClosestJudgement, CounterRecord, Judgement, PhaseRecord, StatusCounts, TraceRecord};

fn write(record: &Record) -> (TempDir, BTreeMap<String, Vec<u8>>) {
    let folder = TempDir::new().unwrap();
    let paths = write_run(record, &folder.path().join("a/b"), fixture::tables).unwrap();
    assert_eq!(paths[0].file_name().unwrap(), RUN_FILE);
    let name = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
    let files: BTreeMap<_, _> = paths.iter().map(|path| (name(path), fs::read(path).unwrap())).collect();
    // Nothing is left behind but the list, nothing is hidden.
    assert_eq!(fs::read_dir(folder.path().join("a/b")).unwrap().count(), files.len() + 1);
    (folder, files)
}

fn text(files: &BTreeMap<String, Vec<u8>>, name: &str) -> String {
    String::from_utf8(files[name].clone()).unwrap()
}

/// Header and rows; the reader refuses rows of another length.
fn table(files: &BTreeMap<String, Vec<u8>>, name: &str) -> (Vec<String>, Vec<BTreeMap<String, String>>) {
    let mut reader = csv::Reader::from_reader(files[name].as_slice());
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| header.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    let rows = reader.records().map(|record| row(record.unwrap())).collect();
    (header, rows)
}

/// What was written reads back, and makes the same files again, to the byte.
#[test]
fn derived_files_can_be_made_again() {
    let record = fixture::typical();
    let (folder, files) = write(&record);
    let directory = folder.path().join("a/b");
    let again = read_run(&directory).unwrap();
    assert_eq!(again, record);
    assert_eq!(read_run(&directory.join(RUN_FILE)).unwrap(), record);
    let elsewhere = TempDir::new().unwrap();
    let paths = write_derived(&again, elsewhere.path(), fixture::tables).unwrap();
    assert_eq!(paths.len() + 1, files.len());
    for path in paths {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(fs::read(&path).unwrap() == files[name], "{name} differs");
    }
}

/// The summary names the machine, the commit and every tracer, and says what its figures are worth.
#[test]
fn the_summary_is_complete() {
    let record = fixture::crowded();
    let summary = summary::summary(&record, &group::groups(&record)).markdown();
    for wanted in [
        record.provenance.machine.label(),
        record.provenance.commit.clone(),
        record.provenance.started.clone(),
        record.seed.to_string(),
    ] {
        assert!(summary.contains(&wanted), "{wanted}");
    }
    for tracer in record.rows.iter().chain(&record.controls) {
        assert!(summary.contains(&tracer.tracer.label()));
    }
    for wanted in
        ["uncommitted changes", "adapter is software", "host clock", "off_view", "## Skipped", "queries \\| none"]
    {
        assert!(summary.contains(wanted), "{wanted}");
    }
    // What is said of several viewpoints stands once.
    let twice = [record.skipped.clone(), record.skipped.clone()].concat();
    assert!(!record.skipped.is_empty());
    assert_eq!(summary::skipped(&twice).markdown(), summary::skipped(&record.skipped).markdown());
    assert!(!summary.contains("smoke"));
    let smoke = Record { preset: "smoke".to_owned(), ..record };
    assert!(summary::summary(&smoke, &[]).markdown().contains("figures only show that things work"));
}

/// Rows that other sources made are named, and no others.
#[test]
fn rows_of_older_versions_are_named() {
    let mut record = fixture::crowded();
    let told = "Measured by an older version of what makes a row";
    let notes = |record: &Record| summary::notes(record).markdown();
    assert!(!notes(&record).contains(told));
    record.rows[1].fingerprint = Some("0".to_owned());
    let line = notes(&record).lines().find(|line| line.contains(told)).unwrap().to_owned();
    assert!(line.ends_with(&format!(": {}.", record.rows[1].tracer.label())), "{line}");
}

/// Where a tracer has texels of its own the summary says how far told hits are from the mesh, of all pieces together and of each; where
/// none has, and of records from before it was told, it says nothing of it.
#[test]
fn distances_are_told_by_texels() {
    let record = fixture::crowded();
    let heading = "Told hits by their distance from the connected piece of mesh";
    let summary_of = |record: &Record| summary::summary(record, &group::groups(record)).markdown();
    let told = summary_of(&record);
    assert!(told.contains(heading) && told.contains("The pieces of mesh that most rays truly hit"));
    let changed = |change: fn(&mut ClosestJudgement)| {
        let mut record = record.clone();
        for trace in record.rows.iter_mut().flat_map(|each| &mut each.traces) {
            if let Judgement::Closest(judgement) = &mut trace.judgement {
                change(judgement);
            }
        }
        summary_of(&record)
    };
    assert!(!changed(|judgement| judgement.surface_distance = None).contains(heading));
    let without = changed(|judgement| {
        if let Some(distance) = &mut judgement.surface_distance {
            distance.own_texel = None;
        }
    });
    assert!(!without.contains(heading));
}

/// Every row of a table with speeds has its accuracy, with an interval; rows have as many cells as their heading.
#[test]
fn no_speed_without_accuracy() {
    let record = fixture::crowded();
    let summary = summary::summary(&record, &group::groups(&record)).markdown();
    let cells = |line: &str| line.replace("\\|", "").split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let mut heading: Vec<String> = Vec::new();
    let mut speeds = 0;
    for line in summary.lines() {
        let cells = cells(line);
        if cells.len() < 3 {
            heading.clear();
        } else if heading.is_empty() {
            heading = cells;
        } else {
            assert_eq!(cells.len(), heading.len(), "{line}");
            let Some(speed) = heading.iter().position(|cell| cell.contains("Mrays/s")) else { continue };
            if cells[speed].starts_with(|c: char| c.is_ascii_digit()) {
                speeds += 1;
                let accuracy = |(name, _): &(&String, &String)| name.contains("agreement") || name.contains("accuracy");
                let accuracies: Vec<_> = heading.iter().zip(&cells).filter(accuracy).collect();
                assert!(accuracies.len() == 3 || accuracies.len() == 1);
                assert!(accuracies.iter().all(|(_, cell)| cell.contains("% [") && cell.contains("wrong of")), "{line}");
            }
        }
    }
    assert_eq!(speeds, 12 * 3);
    // A set of nothing but ambiguous rays has no accuracy, so no speed either.
    let mut record = fixture::typical();
    for trace in record.rows.iter_mut().flat_map(|one| &mut one.traces) {
        if let Judgement::Closest(judgement) = &mut trace.judgement {
            (judgement.agreement, judgement.interval) = Default::default();
        }
    }
    let summary = summary::summary(&record, &group::groups(&record)).markdown();
    let row = summary.lines().find(|line| line.contains("| bvh-cpu |") && line.contains("ambiguous")).unwrap();
    assert!(!row.contains("17."), "{row}");
}

/// Where ambiguous rays are judged, every ray counts, and beside the shares stand those without them; older records say that theirs leave
/// them out, and have no such column. Controls are held to ambiguous rays as well: one that is wrong with one more voids the run.
#[test]
fn ambiguous_rays_count() {
    let mut record = fixture::typical();
    let page = |record: &Record| summary::summary(record, &group::groups(record)).markdown();
    let (beside, column) =
        ("without ambiguous rays: hit_miss / tight / footprint ↑", "agreement_without_ambiguous_share_tight");
    let older = page(&record);
    assert!(older.contains("are left out of every share") && older.contains("wrong of 131,060"), "{older}");
    assert!(!older.contains(beside) && !older.contains("wrong of 131,072"));
    let (_folder, files) = write(&record);
    assert!(!table(&files, "rows.csv").0.contains(&column.to_owned()));
    let Judgement::Closest(before) = record.rows[1].traces[0].judgement.clone() else {
        panic!("primary is closest-hit")
    };
    fixture::judge_ambiguous(&mut record);
    assert!(verdict::controls(&record).is_empty());
    let page = page(&record);
    assert!(page.contains("Ambiguous rays") && page.contains(beside), "{page}");
    assert!(page.contains("wrong of 131,072"));
    let (_folder, files) = write(&record);
    let rows = table(&files, "rows.csv").1;
    let row = rows.iter().find(|row| row["tracer"] == record.rows[1].tracer.name && row["rays"] == "primary").unwrap();
    assert_eq!(row[column].parse::<f64>().unwrap(), before.agreement.tight.unwrap());
    assert_ne!(row["agreement_tight_share"], row[column]);
    for control in 0..Control::ALL.len() {
        let mut bad = record.clone();
        let Judgement::Closest(closest) = &mut bad.controls[control].traces[0].judgement else { panic!("closest-hit") };
        for classes in [&mut closest.classes.tight, &mut closest.classes.footprint] {
            let right = if classes.true_miss > 0 { &mut classes.true_miss } else { &mut classes.early };
            *right -= 1;
            classes.false_miss += 1;
        }
        assert_eq!(verdict::controls(&bad).len(), 1, "{control}");
    }
}

/// A control that fails is said to invalid the run.
#[test]
fn failing_controls_are_told() {
    let mut record = fixture::typical();
    assert!(verdict::controls(&record).is_empty());
    for control in 0..Control::ALL.len() {
        let mut bad = record.clone();
        // Each control with the verdict of a configuration that is wrong now and then.
        bad.controls[control].traces.clone_from(&record.rows[1].traces);
        assert_eq!(verdict::controls(&bad).len(), 3);
    }
    // A control that is missing, whole or from one ray set, vouches for nothing either.
    let sets = record.rows[0].traces.len();
    for control in 0..Control::ALL.len() {
        let mut bad = record.clone();
        bad.controls.remove(control);
        assert_eq!(verdict::controls(&bad).len(), sets);
        let mut bad = record.clone();
        bad.controls[control].traces.pop();
        let told = verdict::sentence(&verdict::controls(&bad));
        assert!(told.contains("is missing on") && told.contains("invalid"), "{told}");
        // A chart of such a run says so, one of a sound run does not.
        let said = |record: &Record| {
            let charts = chart::files(summary::summary(record, &group::groups(record)).charts()).unwrap();
            let svgs = charts.iter().filter(|(name, _)| name.ends_with(".svg"));
            svgs.map(|(_, svg)| String::from_utf8(svg.clone()).unwrap().contains("VOID")).collect::<Vec<_>>()
        };
        assert!(said(&bad).iter().all(|said| *said) && said(&record).iter().all(|said| !said));
    }
    record.controls.clear();
    assert_eq!(verdict::controls(&record).len(), Control::ALL.len() * sets);
}

/// One row for each trace, one for each wrong ray, and the figures are those of the run.
#[test]
fn tables_hold_the_run() {
    let record = fixture::typical();
    let (_folder, files) = write(&record);
    let (header, rows) = table(&files, "rows.csv");
    assert_eq!(rows.len(), (2 + Control::ALL.len()) * 3);
    let unique: BTreeSet<_> = header.iter().collect();
    assert_eq!(unique.len(), header.len());
    let row = rows.iter().find(|row| row["tracer"] == "screen-dda" && row["rays"] == "diffuse").unwrap();
    let trace = &record.rows[1].traces[1];
    let Judgement::Closest(judgement) = &trace.judgement else { panic!("diffuse is a closest-hit set") };
    assert_eq!(row["mrays_per_s"].parse::<f64>().unwrap(), trace.mrays_per_s);
    assert_eq!(row["agreement_tight_share"].parse::<f64>().unwrap(), judgement.agreement.tight.unwrap());
    assert_eq!(row["tight_false_miss_rays"], judgement.classes.tight.false_miss.to_string());
    assert_eq!(row["cause_tight_off_view_rays"], judgement.causes["tight"]["off_view"].to_string());
    assert_eq!(row["counter_nodes_per_ray"], "37");
    assert_eq!(row["clock"], "submit_to_done");
    assert_eq!(row["balanced_accuracy_share"], "");
    let (_, rows) = table(&files, "wrong_rays.csv");
    let wrong = |trace: &TraceRecord| match &trace.judgement {
        Judgement::Closest(judgement) => judgement.wrong_rays.len(),
        Judgement::Any(judgement) => judgement.wrong_rays.len(),
    };
    let all = record.rows.iter().chain(&record.controls).flat_map(|one| &one.traces).map(wrong).sum::<usize>();
    assert_eq!(rows.len(), all);
    assert!(rows.iter().all(|row| row["cause"] == "hidden, \"layer\"" && row["t_max_scene_units"] == "1e30"));
}

/// Same names do not share files, in whatever way they differ; the same rays share charts in spite of other frames.
#[test]
fn names_of_files_do_not_collide() {
    let mut record = fixture::typical();
    record.controls.clear();
    let mut other = record.rows[0].clone();
    other.scene.name = "ROOM".to_owned();
    other.scene.sha256 = "ff00ff00ff".to_owned();
    record.rows.push(other.clone());
    for (name, x) in [("a/b", 1.0), ("a/b", 2.0), ("..", 3.0)] {
        other.viewpoint.name = name.to_owned();
        other.viewpoint.eye[0] = x;
        record.rows.push(other.clone());
    }
    record.rows[1].viewpoint.frame = [9, 9];
    let groups = group::groups(&record);
    let stems: Vec<_> = groups.iter().map(|group| group.stem.as_str()).collect();
    assert_eq!(
        stems,
        ["room-5e884898", "ROOM-ff00ff00-door", "ROOM-ff00ff00-a_b", "ROOM-ff00ff00-a_b-2", "ROOM-ff00ff00-__"]
    );
    assert_eq!(groups[0].configs.len(), 2);
}

/// Sets of the same name with other rays stand apart.
#[test]
fn other_rays_are_another_set() {
    let mut record = fixture::typical();
    record.rows[1].traces[0].rays_sha256 = "beef".to_owned();
    let groups = group::groups(&record);
    let titles: Vec<_> = groups[0].ray_sets.iter().map(|set| set.title.as_str()).collect();
    assert_eq!(titles, ["primary 00000000", "diffuse", "ao", "primary beef"]);
}

/// A run without a single trace still has its files, without charts.
#[test]
fn an_empty_run_is_reported() {
    let record = Record { rows: Vec::new(), controls: Vec::new(), ..fixture::typical() };
    let (_folder, files) = write(&record);
    assert_eq!(files.keys().collect::<Vec<_>>(), ["rows.csv", "run.json", "summary.md", "wrong_rays.csv"]);
    assert!(text(&files, "summary.md").contains("Nothing ran."));
    let any = fixture::run(&[], &[("ao", Query::Any)]);
    let (_folder, files) = write(&any);
    assert!(files.contains_key("error_vs_speed_room.png") && !files.contains_key("agreement_over_tolerance_room.png"));
}

/// What cannot be written or read is said with the file's name, and nothing is left half-written.
#[test]
fn errors_are_clear() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let fails = |path: &Path, wanted: &str| {
        let message = read_run(path).unwrap_err().to_string();
        assert!(message.contains(wanted) && message.contains(folder.path().to_str().unwrap()), "{message}");
    };
    let record = fixture::run(&[], &[]);
    fs::write(at("file"), "x").unwrap();
    assert!(matches!(write_run(&record, &at("file"), fixture::tables), Err(ReportError::File(FileError::Folder(..)))));
    assert!(matches!(
        write_run(&record, &at("file/below"), fixture::tables),
        Err(ReportError::File(FileError::Folder(..)))
    ));
    fs::create_dir_all(at("taken/run.json")).unwrap();
    assert!(matches!(
        write_run(&record, &at("taken"), fixture::tables),
        Err(ReportError::File(FileError::InTheWay(..)))
    ));
    assert_eq!(fs::read_dir(at("taken")).unwrap().count(), 1);

    fails(&at("nowhere"), "there is no");
    fails(folder.path(), "run.json");
    fails(&at("file"), "not a whole JSON document");
    let json = serde_json::to_string(&record).unwrap();
    fs::write(at("cut"), &json[..json.len() / 2]).unwrap();
    fails(&at("cut"), "truncated");
    fs::write(at("other"), json.replacen(&format!("\"schema\":{SCHEMA}"), "\"schema\":999", 1)).unwrap();
    fails(&at("other"), "schema 999");
    // The schema is looked at first: the fields of another schema are nothing to complain about.
    fs::write(at("other"), "{\"schema\": 77}").unwrap();
    fails(&at("other"), "schema 77");
    fs::write(at("plain"), "{\"asset\": {}}").unwrap();
    fails(&at("plain"), "no \"schema\"");
    fs::write(at("thin"), format!("{{\"schema\": {SCHEMA}}}")).unwrap();
    fails(&at("thin"), "missing field");
}

/// The table's run: its reference and two peers, one timed on the device.
fn of_peers() -> Record {
    let quality = |speed: f64, clock| fixture::Quality { missed: 0.001, blur: 1e-9, speed, clock };
    let peers = [
        ("bvh-cpu", quality(3.0, ClockKind::Host)),
        ("bvh-gpu", quality(9.0, ClockKind::DeviceTimestamps)),
        ("screen-dda", quality(20.0, ClockKind::Host)),
    ];
    Record { table: Some("bvh".to_owned()), ..fixture::run(&peers, &fixture::SETS) }
}

/// A table's rows are the tracers of its family, each with rate, size and cost; ratios are by the host's clock, which of
/// device work is not the clock of its speed; its files are made where the run was made for it, and only there.
#[test]
fn tables_set_peers_side_by_side() {
    let record = of_peers();
    let (_folder, files) = write(&record);
    let (header, rows) = table(&files, "rows.csv");
    let beside = |row: &&BTreeMap<String, String>| !row["speed_over_reference"].is_empty();
    assert_eq!(rows.iter().filter(beside).count(), 2 * fixture::SETS.len());
    assert!(rows.iter().filter(beside).all(|row| row["tracer_name"] != "screen-dda"));
    let value = |row: &BTreeMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
    for (one, trace) in record.rows[..2].iter().flat_map(|one| one.traces.iter().map(move |trace| (one, trace))) {
        let is_of = |row: &&BTreeMap<String, String>| row["tracer"] == one.tracer.name && row["rays"] == trace.rays;
        let row = rows.iter().find(is_of).unwrap();
        let close = |name: &str, expected: f64| assert!((value(row, name) / expected - 1.0).abs() < 1e-12, "{name}");
        close("build_mtriangles_per_s", 0.156034 / (one.build.times.median_ms / 1e3));
        close("bytes_per_triangle", f64::from(7 << 20) / 156_034.0);
        close("structure_sah_cost", 57.25);
        let host = |trace: &TraceRecord| trace.times.submit_to_done_median_ms.unwrap_or(trace.times.median_ms);
        let reference = record.rows[0].traces.iter().find(|other| other.rays == trace.rays).unwrap();
        close("speed_over_reference", host(reference) / host(trace));
        close("counter_nodes_per_ray", 37.0);
        let accuracy = if trace.query == Query::Any { "balanced_accuracy_share" } else { "agreement_tight_share" };
        assert!(value(row, accuracy) > 0.99);
    }
    // By the device's clock alone the second would be three times as fast.
    let device = rows.iter().find(|row| row["tracer"] == "bvh-gpu" && row["rays"] == "primary").unwrap();
    let by_speeds = record.rows[1].traces[0].mrays_per_s / record.rows[0].traces[0].mrays_per_s;
    assert!((by_speeds - 3.0).abs() < 1e-9 && value(device, "speed_over_reference") < 2.999);
    assert_eq!(header.iter().filter(|name| name.ends_with("_over_reference")).count(), 2);
    let page = text(&files, "table_bvh.md");
    assert!(
        page.contains("× bvh-cpu") && page.contains("device timestamps") && !page.contains("| screen-dda"),
        "{page}"
    );
    let plain = Record { table: None, ..record.clone() };
    assert!(write(&plain).1.keys().all(|name| !name.starts_with("table_")));
    let bvh = crate::peers::all().find(|table| table.name == "bvh").unwrap();
    for (name, contents) in peers::report(bvh, &plain).contents().unwrap() {
        assert!(contents == files[&name], "{name} differs");
    }
}

/// No row of a table tells a speed, or a ratio of speeds, without its accuracy.
#[test]
fn tables_tell_no_speed_without_accuracy() {
    let mut record = of_peers();
    let page = |record: &Record| text(&write(record).1, "table_bvh.md");
    let speeds = |page: &str| {
        let rows = page
            .lines()
            .filter(|line| line.starts_with("| bvh-") && line.contains(" clock |") | line.contains("timestamps |"));
        let cells = rows.map(|line| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>());
        // Builds have no accuracy; their rows end with a cost.
        let traces =
            cells.filter(|cells| cells.iter().any(|cell| cell.contains("wrong of") || cell.contains("is ambiguous")));
        traces.map(|cells| (cells[3].starts_with(|c: char| c.is_ascii_digit()), cells[4].clone())).collect::<Vec<_>>()
    };
    let found = speeds(&page(&record));
    assert!(found.len() == 6 && found.iter().all(|(speed, ratio)| *speed && ratio != format::NONE), "{found:?}");
    for trace in record.rows.iter_mut().flat_map(|one| &mut one.traces) {
        if let Judgement::Closest(judgement) = &mut trace.judgement {
            (judgement.agreement, judgement.interval) = Default::default();
        }
    }
    let found = speeds(&page(&record));
    let silent = found.iter().filter(|(speed, ratio)| !speed && ratio == format::NONE).count();
    assert_eq!((found.len(), silent), (6, 4), "{found:?}");
}

/// Builds say what structures say of themselves; the column is not there where nobody was asked.
#[test]
fn the_summary_tells_statistics() {
    let mut record = fixture::typical();
    let summary = |record: &Record| summary::summary(record, &group::groups(record)).markdown();
    assert!(summary(&record).contains("nodes 4,321; sah_cost 57.25"));
    for one in record.rows.iter_mut().chain(&mut record.controls) {
        one.structure_statistics.clear();
    }
    assert!(!summary(&record).contains("says of itself"));
}

/// Proves that pages say how wide pixels are beside those of the reference camera, whose 90 degrees have 1024: each resolution once, of many
/// the range, which claims of a paper have of the runs for its tables alone.
#[test]
fn pixels_stand_beside_the_footprints() {
    let mut record = of_peers();
    for row in &mut record.rows {
        (row.viewpoint.vertical_fov_degrees, row.viewpoint.frame, row.viewpoint.face) = (90.0, [512, 256], 512);
    }
    let said = |record: &Record| {
        let (_folder, files) = write(record);
        let page = String::from_utf8(files["summary.md"].clone()).unwrap();
        page.lines().find(|line| line.contains("Footprint: ")).map(str::to_owned)
    };
    let once = said(&record).unwrap();
    assert!(once.ends_with("at 512x256 a frame's is 4.0 times as wide, at 512x512 a face's 2.0 times."), "{once}");
    record.rows[0].viewpoint.vertical_fov_degrees = 60.0;
    assert!(said(&record).unwrap().contains("is 2.3 times as wide"));
    let many = summary::footprint_of_many(&record.rows).unwrap();
    assert!(many.ends_with("; a frame's is 2.3 to 4.0 times as wide, a face's 2.0 times."), "{many}");
    let of_claims = |table: &str| {
        let record = Record { table: Some(table.to_owned()), ..record.clone() };
        crate::papers::claims_of(&[record]).iter().map(|page| page.markdown().contains(&many)).collect::<Vec<_>>()
    };
    assert_eq!([of_claims("dirt-table1"), of_claims("bvh")], [vec![true], vec![]]);
    record.rows.clear();
    assert_eq!(said(&record), None);
    assert_eq!(summary::footprint_of_many(&record.rows), None);
}

/// The committed records, in order.
fn committed(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let below = |path: PathBuf| match path.is_dir() {
        true => committed(&path),
        false if path.ends_with("run.json.xz") => vec![path],
        false => Vec::new(),
    };
    paths.into_iter().flat_map(below).collect()
}

/// Proves that committed records, those of every verb among them, still load from their folders though they are compressed,
/// and are written again with the head that they have: the same fields at the top, in the same order, none of them within
/// another; and that one without a commit is none.
#[test]
fn committed_records_keep_their_head() {
    let paths = committed(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../results"));
    let mut kinds = [false; 4];
    for path in &paths {
        let record = read_run(path.parent().unwrap()).unwrap();
        let found =
            [record.sweep.is_some(), record.tuning.is_some(), record.cases.is_some(), record.explanation.is_some()];
        kinds = [0, 1, 2, 3].map(|kind| kinds[kind] || found[kind]);
        let provenance = &record.provenance;
        assert!(!provenance.commit.is_empty() && provenance.started.ends_with('Z'), "{}", path.display());
        let mut text = String::new();
        let file = fs::File::open(path).unwrap();
        liblzma::read::XzDecoder::new(file).read_to_string(&mut text).unwrap();
        // Older files are indented.
        let head = |text: &str| {
            let text: String = text.split_whitespace().collect();
            text.split_once(",\"seed\":").map(|(head, _)| head.to_owned())
        };
        assert!(head(&text).is_some_and(|head| head.contains("\"started\":")), "{}", path.display());
        assert_eq!(head(&text), head(&serde_json::to_string(&record).unwrap()), "{}", path.display());
    }
    let mut without = serde_json::to_value(read_run(paths[0].parent().unwrap()).unwrap()).unwrap();
    assert!(serde_json::from_value::<Record>(without.clone()).is_ok());
    without.as_object_mut().unwrap().remove("commit");
    assert!(serde_json::from_value::<Record>(without).is_err());
    assert!(paths.len() > 15 && kinds == [true; 4], "{} {kinds:?}", paths.len());
}

/// First and steady builds are in pages and rows where a record tells them, with their own values and clock; one of before them has the
/// time of its phases there, and no columns for what it never knew.
#[test]
fn builds_are_shown_as_they_were_timed() {
    let before = of_peers();
    let record = fixture::with_whole_builds(before.clone());
    for (record, whole) in [(&record, true), (&before, false)] {
        let (_folder, files) = write(record);
        let (header, rows) = table(&files, "rows.csv");
        let has = |name: &str| header.iter().any(|column| column == name);
        assert_eq!(
            ["first_build_median_ms", "steady_build_median_ms", "build_median_ms"].map(has),
            [whole, whole, !whole]
        );
        let summary = text(&files, "summary.md");
        let shown = ["first build (ms) ↓ |", "steady build (ms) ↓ |", "| build time (ms) ↓"];
        assert_eq!(shown.map(|heading| summary.contains(heading)), [whole, whole, !whole], "{summary}");
        let row = rows.iter().find(|row| row["tracer"] == "bvh-gpu").unwrap();
        let one = &record.rows[1].build;
        if let (Some(first), Some(steady)) = (&one.first, &one.steady) {
            assert_eq!(row["first_build_median_ms"], first.median_ms.to_string());
            assert_eq!(
                (&*row["steady_build_median_ms_low"], &*row["build_clock"]),
                (&*steady.interval_ms[0].to_string(), "host")
            );
            assert!(
                summary.contains("| clock of phases |")
                    && summary.contains("| device timestamps | sort ")
                    && (first.median_ms / steady.median_ms - 4.0).abs() < 1e-9
            );
        }
        assert_eq!(summary.contains("clock of phases"), whole);
        let (header, rows) = table(&files, "rows.csv");
        assert_eq!(header.iter().any(|column| column == "steady_build_median_ms"), whole);
        let rate = 0.156034 / (one.first().median_ms / 1e3);
        let told: f64 =
            rows.iter().find(|row| row["tracer"] == "bvh-gpu").unwrap()["build_mtriangles_per_s"].parse().unwrap();
        assert!((told / rate - 1.0).abs() < 1e-12, "{told} {rate}");
    }
}

/// Proves from made-up counts how often answers of a status are right, which shares of wrong and of right rays are handed over by each trust,
/// what a ray that is handed over takes beside one of all, where the second tracer stands in the same run with the same parameters, and that
/// nothing is said of sets with one kind of ray alone.
#[test]
fn calibration_follows_from_counts() {
    let quality = fixture::Quality { missed: 0.5, blur: 1e-9, speed: 3.1, clock: ClockKind::Host };
    let mut record = fixture::run(&[("whole", quality), ("second", quality)], &[("diffuse", Query::Closest)]);
    let counts = |rays, right| StatusCounts { rays, right: BTreeMap::from([("tight".to_owned(), right)]) };
    let by_status = BTreeMap::from([("hit", (100, 80)), ("miss", (60, 10)), ("step_cap", (40, 0))]);
    for row in &mut record.rows {
        let Judgement::Closest(judged) = &mut row.traces[0].judgement else { panic!("no closest hits") };
        judged.by_status =
            by_status.iter().map(|(name, (rays, right))| ((*name).to_owned(), counts(*rays, *right))).collect();
    }
    let value = |text: &str| serde_json::Value::from(text);
    let [whole, second] = &mut record.rows[..] else { panic!("two rows") };
    second.tracer.parameters = BTreeMap::from([("depth".to_owned(), value("deep"))]);
    whole.tracer.parameters =
        [("then", "second:published"), ("then.depth", "deep")].map(|(name, of)| (name.to_owned(), value(of))).into();
    let trace = &mut whole.traces[0];
    let phase = |name: &str, ms: f64| PhaseRecord { name: name.to_owned(), median_ms: ms, samples_ms: Vec::new() };
    trace.times.phases = vec![phase("first: march", 4.0), phase("then: search", 2.0), phase("then: gather", 1.0)];
    let handed = CounterRecord { total: 1500, per_ray: 0.0, max_per_ray: None };
    trace.counters = BTreeMap::from([("rays_handed_over".to_owned(), handed)]);
    let alone = record.rows[1].traces[0].times.median_ms * 1e6 / fixture::COUNT as f64;
    let summary_of = |record: &Record| summary::summary(record, &group::groups(record)).markdown();
    let summary = summary_of(&record);
    let line = |start: &str| summary.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}"));
    let cells = |start: &str| line(start).split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let first_word = |cell: &String| cell.split(' ').next().unwrap_or_default().to_owned();
    let status = cells("| whole | miss | 60 |");
    assert_eq!(first_word(&status[5]), "16.67", "{status:?}");
    // Wrong are 20, 50 and 40 rays, right 80, 10 and none.
    let trusts: Vec<String> = cells("| whole | tight | 110 |").iter().skip(3).map(first_word).collect();
    assert_eq!(trusts[..6], ["110", "81.82", "36.36", "90", "11.11", "0"], "{trusts:?}");
    let cost = summary.lines().rfind(|line| line.starts_with("| whole ") && line.contains("then: search")).unwrap();
    let ends: Vec<f64> =
        cost.trim_end_matches(" |").rsplit('|').take(2).map(|cell| cell.trim().parse().unwrap()).collect();
    assert!((ends[1] - 2000.0).abs() < 1.0 && (ends[0] / alone - 1.0).abs() < 1e-3, "{cost} {alone}");
    // Another second, and a set in which no ray hits.
    record.rows[1].tracer.parameters = BTreeMap::from([("depth".to_owned(), value("flat"))]);
    let other = summary_of(&record);
    let cost = other.lines().rfind(|line| line.starts_with("| whole ") && line.contains("then: search")).unwrap();
    assert!(cost.ends_with("| – |"), "{cost}");
    for row in record.rows.iter_mut().chain(&mut record.controls) {
        let Judgement::Closest(judged) = &mut row.traces[0].judgement else { panic!("no closest hits") };
        judged.classes.tight = Classes { true_miss: fixture::COUNT, ..Default::default() };
    }
    assert!(!summary_of(&record).contains("Right answers by the status"));
}
