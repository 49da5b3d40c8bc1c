//! Rows for notebooks, and what is asked of a record that is handed in.

use super::*;

/// The rows of a table by column.
fn table(path: &Path) -> Vec<std::collections::BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

/// Proves that the table of several records has every row of each record's own `rows.csv` with the same fields, after the record's name and
/// study, that rows are empty where theirs has no such column, that cases have their difficulty level, that a record's numbers are in it, and
/// that it replaces nothing that is not its own. The negative control is a record that is another one.
#[test]
fn rows_of_records_are_one_table() {
    let bench = Bench::new();
    let run = bench.run(&["--tracer", "bvh-cpu", "--rays", "primary,ao"], "one");
    bench.run(&["--tracer", "screen-dda", "--rays", "primary", "--seed", "2"], "two");
    let cases = bench.text("cases");
    let stability = ["stability", "--case", "leaves", "--tracer", "bvh-cpu", "--out", cases.as_str()];
    assert_eq!(bench.call(&stability).status, 0);
    let outcome = bench.call(&["report", "one", "two/run.json", "cases", "--csv", "all.csv"]);
    assert_eq!((outcome.status, outcome.stdout.as_str()), (0, "all.csv\n"), "{outcome:?}");
    let all = table(&bench.path("all.csv"));
    let of = |record: &str| all.iter().filter(|row| row["record"] == record).collect::<Vec<_>>();
    for (name, other) in [("one", "two"), ("two", "one")] {
        let own = table(&bench.path(name).join("rows.csv"));
        let differs = |rows: &[&std::collections::BTreeMap<String, String>]| {
            rows.len() != own.len()
                || own.iter().zip(rows).any(|(own, row)| own.iter().any(|(column, field)| row[column] != *field))
        };
        assert!(own.len() > 4 && !differs(&of(name)), "{name}");
        assert!(differs(&of(other)), "{name}");
        let added = |row: &&std::collections::BTreeMap<String, String>, column: &str| {
            !own[0].contains_key(column) && !["record", "study"].contains(&column) && !row[column].is_empty()
        };
        assert!(of(name).iter().all(|row| row["study"] == "run" && row.keys().all(|column| !added(row, column))));
    }
    let row = |role: &str| of("one").into_iter().find(|row| row["role"] == role && row["rays"] == "primary").unwrap();
    let trace = &run["rows"][0]["traces"][0];
    assert_eq!(row("tracer")["median_ms"].parse::<f64>().unwrap(), trace["median_ms"]);
    assert_eq!(row("tracer")["structure_bytes"].parse::<f64>().unwrap(), run["rows"][0]["memory"]["structure_bytes"]);
    let levels: BTreeSet<&str> = of("cases").iter().map(|row| row["difficulty_level"].as_str()).collect();
    assert_eq!(levels, ["0.1", "0.5", "1", "16", "4"].into());
    assert!(of("cases").iter().all(|row| row["study"] == "stability" && row["scene"] == "leaves"));
    assert_eq!(bench.call(&["report", "one", "--csv", "all.csv"]).status, 0);
    assert_eq!(table(&bench.path("all.csv")).len(), of("one").len());
    std::fs::write(bench.path("mine.csv"), "mine").unwrap();
    bench.fails(&["report", "one", "--csv", "mine.csv"], 1, &["mine.csv"]);
    bench.fails(&["report", "nowhere", "--csv", "x.csv"], 1, &["there is no", "nowhere"]);
    assert_eq!(std::fs::read_to_string(bench.path("mine.csv")).unwrap(), "mine");
}

/// Proves that a record with all that RULES.md asks passes, packed too, that each thing that is asked for fails alone where it is not so, with
/// what to do, and that nothing is written.
#[test]
fn what_is_handed_in_is_checked() {
    let bench = Bench::new();
    let mut sound = bench.run(&["--tracer", "bvh-cpu", "--rays", "primary"], "results/box-run");
    (sound["commit"], sound["dirty"], sound["preset"]) = (json!("a".repeat(40)), json!(false), json!("quick"));
    let folder = bench.path("results/box-run");
    let write = |record: &Value| {
        for name in names(&folder) {
            std::fs::remove_file(folder.join(name)).unwrap();
        }
        write_as_the_program(&folder, "run.json", &record.to_string());
        assert_eq!(bench.call(&["report", "results/box-run"]).status, 0);
    };
    let manifest = |folder: &str, command: &str| {
        let text = json!([{ "folder": folder, "command": command, "minutes": 0.1 }]).to_string();
        std::fs::write(bench.path("results/manifest.json"), text).unwrap();
    };
    let command = "run --preset quick --tracer bvh-cpu --rays primary";
    let check = || Bench::finish(bench.command(&["report", "--check", "results/box-run"]).env("USER", "ada"));
    let passes = || {
        let outcome = check();
        assert!(outcome.status == 0 && outcome.stdout.starts_with("as RULES.md asks"), "{outcome:?}");
    };
    let fails = |parts: &[&str]| {
        let outcome = check();
        assert_eq!((outcome.status, outcome.stderr.matches("error: ").count()), (1, 1), "{parts:?}: {outcome:?}");
        assert!(outcome.stdout.is_empty() && parts.iter().all(|part| outcome.stderr.contains(part)), "{outcome:?}");
    };
    write(&sound);
    fails(&["no manifest.json is in a folder above it", "results/MACHINE-WHAT"]);
    for (entry, of, parts) in [
        ("other", command, ["does not tell its command", "add its \"folder\""]),
        ("box-run", "run --no-such", ["unexpected argument", "write the command that did"]),
        ("box-run", "pareto --preset quick", ["the record is of `run`", "write the command that did"]),
    ] {
        manifest(entry, of);
        fails(&parts);
    }
    manifest("box-run", command);
    passes();
    // Of the record itself.
    let changed = |pointer: &str, value: Value| {
        let mut record = sound.clone();
        *record.pointer_mut(pointer).unwrap() = value;
        record
    };
    let mut without = sound.clone();
    without["controls"].as_array_mut().unwrap().remove(0);
    for (record, parts) in [
        (changed("/commit", json!("unknown")), ["no clean commit", "build in a git clone"]),
        (changed("/dirty", json!(true)), ["no clean commit", "measure again"]),
        (changed("/dirty", Value::Null), ["no clean commit", "measure again"]),
        (changed("/preset", json!("smoke")), ["preset smoke", "quick or paper"]),
        (without, ["a control fails: oracle is missing on primary", "open an issue"]),
    ] {
        write(&record);
        fails(&parts);
    }
    for (os, part) in [("of /srv/x/y", "/srv/x/y"), ("the box of ada", "ada")] {
        write(&changed("/machine/os", json!(os)));
        fails(&[&format!("it has \"{part}\", a path or a user's name"), "relative paths"]);
    }
    // Of what lies beside it: its page may, as verbs that measure leave it.
    write(&sound);
    let page = ["report", "--quiet", "results/box-run", "--html", "results/box-run/report.html"];
    assert_eq!(bench.call(&page).status, 0);
    passes();
    let summary = std::fs::read_to_string(folder.join("summary.md")).unwrap();
    std::fs::write(folder.join("summary.md"), summary.replacen("bvh-cpu", "bvh-gpu", 1)).unwrap();
    fails(&["summary.md is not what is made of the record", "take it out"]);
    std::fs::remove_file(folder.join("summary.md")).unwrap();
    passes();
    std::fs::write(folder.join("notes.txt"), "mine").unwrap();
    fails(&["notes.txt is not what is made of the record", "take it out"]);
    std::fs::remove_file(folder.join("notes.txt")).unwrap();
    std::fs::create_dir(folder.join("mine")).unwrap();
    fails(&["mine is not what is made of the record"]);
    std::fs::remove_dir(folder.join("mine")).unwrap();
    std::fs::write(folder.join("run.json"), sound.to_string() + "\n").unwrap();
    fails(&["tracebench.sha256 does not list the record as it is", "hand in both as written"]);
    let list = std::fs::read(folder.join("tracebench.sha256")).unwrap();
    // Without a list its derived files are compared all the same.
    std::fs::remove_file(folder.join("tracebench.sha256")).unwrap();
    passes();
    std::fs::write(folder.join("summary.md"), "mine").unwrap();
    fails(&["summary.md is not what is made of the record", "take it out"]);
    std::fs::remove_file(folder.join("summary.md")).unwrap();
    std::fs::write(folder.join("tracebench.sha256"), list).unwrap();
    write(&sound);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../results/pack.sh");
    assert!(Command::new("bash").arg(script).arg(&folder).status().unwrap().success());
    assert!(folder.join("run.json.xz").is_file());
    let before = names(&folder);
    passes();
    assert_eq!(names(&folder), before);
    let by_file = ["report", "--check", "run.json.xz"];
    assert_eq!(Bench::finish(bench.command(&by_file).current_dir(&folder).env("USER", "ada")).status, 0);
    bench.fails(&["report", "--check", "nowhere"], 1, &["there is no", "nowhere"]);
}
