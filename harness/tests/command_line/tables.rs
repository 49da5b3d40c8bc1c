//! `table` and `list tables`.

use super::*;

/// A table that takes a second.
const SMALL: [&str; 7] = ["--quiet", "--preset", "smoke", "--size", "16x8", "--samples", "2"];

fn table(bench: &Bench, name: &str, arguments: &[&str]) -> Outcome {
    bench.call(&[&["table", name][..], &SMALL, arguments].concat())
}

/// Rows of configurations by column.
fn rows(folder: &Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(folder.join("rows.csv")).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| header.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    let rows = reader.records().map(|record| row(record.unwrap()));
    rows.filter(|row: &std::collections::BTreeMap<_, _>| row["role"] == "tracer").collect()
}

/// Proves that the table has a row for every peer and variant in a catalogue scene and a file, that its figures are those of
/// run.json, that the record says what structures say of themselves, and that `report` and `--from` make the same files.
#[test]
fn a_table_of_hierarchies() {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), glb(&TRIANGLE)).unwrap();
    let scenes = ["--scene", "room,one.glb", "--rays", "diffuse,ao", "--out", "out"];
    let outcome = table(&bench, "bvh", &scenes);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    assert!(outcome.page.contains("| bvh-cpu build=fastest | host clock |"), "{}", outcome.page);
    let run = bench.result("out");
    assert_eq!((run["table"].as_str(), run["schema"].as_u64()), (Some("bvh"), Some(3)));
    let listed: Value = serde_json::from_str(&bench.call(&["list", "tables", "--json"]).stdout).unwrap();
    // What this machine cannot run is said for every scene.
    let skipped = run["skipped"].as_array().unwrap().iter().filter(|each| each["scene"] == "room").count();
    let wanted = listed[0]["tracers"].as_array().unwrap().len() - skipped;
    let all = run["rows"].as_array().unwrap();
    assert!(wanted >= 8 && all.len() == 2 * wanted, "{} of {wanted}", all.len());
    let found = rows(&bench.path("out"));
    let number = |text: &str| text.parse::<f64>().unwrap();
    for row in found.iter().filter(|row| row["rays"] == "diffuse") {
        let parameters: Value = serde_json::from_str(&row["parameters_json"]).unwrap();
        let is_row = |one: &&Value| {
            one["scene"]["name"] == row["scene"]
                && one["tracer"]["name"] == row["tracer_name"]
                && one["tracer"]["parameters"] == parameters
        };
        let one = all.iter().find(is_row).unwrap();
        for (name, value) in one["structure_statistics"].as_object().unwrap() {
            assert_eq!(number(&row[&format!("structure_{name}")]), value.as_f64().unwrap(), "{name}");
        }
        // Of what the device itself builds nobody tells the nodes.
        if one["tracer"]["name"] != "ray-query" {
            assert!(number(&row["structure_sah_cost"]) >= 1.0 && number(&row["structure_nodes"]) >= 1.0);
            assert!(number(&row["counter_nodes_visited_per_ray"]) > 0.0);
        }
        let seconds = one["build"]["first"]["median_ms"].as_f64().unwrap() / 1e3;
        let rate = one["scene"]["triangles"].as_f64().unwrap() / seconds / 1e6;
        assert!((number(&row["build_mtriangles_per_s"]) / rate - 1.0).abs() < 1e-9);
        assert!(number(&row["agreement_tight_share"]) > 0.9);
    }
    assert_eq!(found.iter().filter(|row| row["rays"] == "diffuse" && row["scene"] == "room").count(), wanted);
    assert_eq!(found.iter().filter(|row| row["tracer"] == "bvh-cpu").count(), 4);
    let files = ["out/table_bvh.md", "out/rows.csv"].map(|name| bench.path(name));
    let before = files.clone().map(|file| std::fs::read(file).unwrap());
    for again in [vec!["report", "out"], vec!["table", "bvh", "--from", "out"]] {
        files.iter().for_each(|file| std::fs::remove_file(file).unwrap());
        assert_eq!(bench.call(&[&["--quiet"][..], &again].concat()).status, 0);
        assert!(files.clone().map(|file| std::fs::read(file).unwrap()) == before, "{again:?}");
    }
    // A run that was made for no table has none, until one asks for it.
    bench.run(&["--tracer", "bvh-cpu,screen-dda", "--rays", "primary"], "plain");
    assert!(!bench.path("plain/table_bvh.md").exists());
    let outcome = bench.call(&["table", "bvh", "--from", "plain/run.json", "--out", "elsewhere"]);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    assert!(outcome.page.contains("| bvh-cpu |") && !outcome.page.contains("| screen-dda |"));
    assert_eq!(
        names(&bench.path("elsewhere")),
        ["rows.csv", "table_bvh.md", "wrong_rays.csv"].map(str::to_owned).into()
    );
}

/// Proves that a table of switches has a row for each of them beside a hierarchy, the improved form among them without a wrong ray; that
/// every row has its counters and none a speed over the first without its own accuracy; and that `report` and `--from` make the same.
#[test]
fn a_table_of_switches() {
    let bench = Bench::new();
    let listed: Value = serde_json::from_str(&bench.call(&["list", "tables", "--json"]).stdout).unwrap();
    let own = listed.as_array().unwrap().iter().find(|each| each["name"] == "ploc-gpu-ablation").unwrap();
    let wanted = own["tracers"].as_array().unwrap().len();
    let arguments = ["--scene", "room", "--rays", "diffuse", "--out", "out"];
    let outcome = table(&bench, "ploc-gpu-ablation", &arguments);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let run = bench.result("out");
    assert_eq!((run["table"].as_str(), run["rows"].as_array().unwrap().len()), (Some("ploc-gpu-ablation"), wanted));
    let found = rows(&bench.path("out"));
    assert_eq!(found.len(), wanted);
    for row in &found {
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        assert!(number("structure_nodes") > 0.0 && number("counter_triangle_tests_per_ray") > 0.0, "{row:?}");
        assert!(number("agreement_tight_share") > 0.9, "{row:?}");
    }
    let improved = found.iter().find(|row| row["tracer"] == "ploc-gpu:improved").unwrap();
    assert_eq!(improved["agreement_tight_share"].parse::<f64>().unwrap(), 1.0);
    assert!(outcome.page.contains("× bvh-gpu") && outcome.page.contains("| ploc-gpu:improved search_radius=4 |"));
    let files = ["out/table_ploc_gpu_ablation.md", "out/rows.csv"].map(|name| bench.path(name));
    let before = files.clone().map(|file| std::fs::read(file).unwrap());
    for again in [vec!["report", "out"], vec!["table", "ploc-gpu-ablation", "--from", "out"]] {
        files.iter().for_each(|file| std::fs::remove_file(file).unwrap());
        assert_eq!(bench.call(&[&["--quiet"][..], &again].concat()).status, 0);
        assert!(files.clone().map(|file| std::fs::read(file).unwrap()) == before, "{again:?}");
    }
}

/// Proves that wrong arguments end with status 2 and name what is right, that what cannot be measured or read ends with 1,
/// and that neither leaves a file.
#[test]
fn wrong_tables() {
    let bench = Bench::new();
    for (arguments, parts) in [
        (vec!["bvhs"], vec!["bvhs", "'bvh'"]),
        (vec![], vec!["<NAME>"]),
        (vec!["bvh-updates"], vec!["frames --rays SET --move geometry"]),
        (vec!["view-updates"], vec!["frames --rays SET --move camera"]),
        (vec!["bvh", "--scene", "rooom"], vec!["'room'"]),
        (vec!["bvh", "--rays", "diffus"], vec!["'diffuse'"]),
        (vec!["bvh", "--set", "screen-dda.stride=2"], vec!["not in"]),
        (vec!["bvh", "--set", "bvh-cpu.build=quick"], vec!["very_fast"]),
        (vec!["bvh", "--from", "x", "--scene", "room"], vec!["--from", "--scene"]),
        (vec!["bvh", "--tracer", "bvh-cpu"], vec!["--tracer"]),
    ] {
        bench.fails(&[&["table"][..], &arguments].concat(), 2, &parts);
    }
    bench.fails(&["table", "bvh", "--from", "nowhere"], 1, &["nowhere", "run.json"]);
    assert!(names(bench.folder.path()).iter().all(|name| name == "cache"), "{:?}", names(bench.folder.path()));
    let other = json!({ "schema": 99 }).to_string();
    std::fs::write(bench.path("run.json"), &other).unwrap();
    bench.fails(&["table", "bvh", "--from", "."], 1, &["schema 99", "reads schema 3"]);
    bench.fails(&["report", "run.json"], 1, &["schema 99"]);
    std::fs::write(bench.path("run.json"), "{\"schema\": 3}").unwrap();
    bench.fails(&["table", "bvh", "--from", "."], 1, &["run.json", "missing field"]);
    bench.run(&["--tracer", "screen-dda", "--rays", "primary"], "views");
    bench.fails(&["table", "bvh", "--from", "views"], 1, &["no tracer of this record belongs"]);
}

/// Proves that without an adapter the peers on the host are in the table, and the others below it with the reason.
#[test]
fn tables_without_an_adapter() {
    let bench = Bench::new();
    let arguments = ["table", "bvh", "--scene", "cloth", "--rays", "ao", "--out", "out"];
    let outcome = bench.call_without_adapter(&[&arguments[..], &SMALL].concat());
    assert_eq!(outcome.status, 0, "{outcome:?}");
    assert!(outcome.page.contains("| bvh-cpu |") && outcome.page.contains("| bvh-gpu | cloth | all |"), "{outcome:?}");
}

/// Proves that tables are listed for people and for scripts, and that the rows of one are names that `--tracer` takes, each a
/// configuration of its own.
#[test]
fn tables_are_listed() {
    let bench = Bench::new();
    let listed: Value = serde_json::from_str(&bench.call(&["list", "tables", "--json"]).stdout).unwrap();
    let text = bench.call(&["list", "tables"]).stdout;
    for table in listed.as_array().unwrap() {
        assert!(text.contains(table["name"].as_str().unwrap()) && table["summary"].is_string(), "{table}");
    }
    let rows = listed[0]["tracers"].as_array().unwrap().iter().map(|row| row.as_str().unwrap());
    let with_ray_queries = tracebench_tests::adapter_has_ray_queries(&tracebench_tests::gpu());
    // Named, what this machine cannot run is an error.
    let rows: Vec<&str> = rows.filter(|row| !row.starts_with("ray-query") || with_ray_queries).collect();
    let run = bench.run(&["--tracer", &rows.join(","), "--rays", "primary", "--samples", "1"], "out");
    let labels: BTreeSet<String> =
        run["rows"].as_array().unwrap().iter().map(|one| one["tracer"].to_string()).collect();
    assert_eq!(labels.len(), rows.len());
}

/// Proves that the table of wrong rays has every ray set from five viewpoints of every scene, other eyes on the circle where a scene has no
/// further cameras; that it ends well where no ray is wrong, and with status 1 and their number where some are (the negative control), also
/// over what was measured before; and that other tables take no tracer, nor this one a viewpoint.
#[test]
fn a_table_of_wrong_rays() {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), glb(&TRIANGLE)).unwrap();
    let small = ["--scene", "one.glb,room", "--rays", "primary"];
    let exact = |tracer: &str, out: &str| {
        bench.call(
            &[
                &["table", "exact", "--quiet", "--preset", "smoke", "--size", "16x8", "--tracer", tracer, "--out", out],
                &small[..],
            ]
            .concat(),
        )
    };
    let outcome = exact("bvh-cpu", "right");
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    assert!(outcome.stdout.contains("\n**0 of ") && outcome.stdout.ends_with("right/table_exact.md\n"), "{outcome:?}");
    let found = rows(&bench.path("right"));
    assert_eq!(found.len(), 2 * 5);
    let views: BTreeSet<_> = found.iter().map(|row| (&row["scene"], &row["viewpoint"])).collect();
    assert_eq!(views.len(), 2 * 5);
    assert!(found.iter().all(|row| row["wrong_tight_rays"] == "0" && row["rays_sha256"].len() == 64), "{found:?}");
    let eyes: BTreeSet<String> = bench.result("right")["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["viewpoint"]["eye"].to_string())
        .collect();
    assert_eq!(eyes.len(), 2 * 5);
    let outcome = exact("screen-dda", "wrong");
    let wrong: u64 = rows(&bench.path("wrong")).iter().map(|row| row["wrong_tight_rays"].parse::<u64>().unwrap()).sum();
    assert!(wrong > 0 && outcome.page.contains("Sets with wrong rays:"), "{outcome:?}");
    let again = bench.call(&["table", "exact", "--from", "wrong"]);
    for outcome in [outcome, again] {
        assert_eq!(outcome.status, 1, "{outcome:?}");
        assert!(outcome.stderr.contains(&format!("error: {wrong} rays are wrong")), "{outcome:?}");
    }
    bench.fails(&["table", "bvh", "--tracer", "bvh-cpu"], 2, &["--tracer"]);
    bench.fails(&["table", "exact", "--view", "entrance"], 2, &["--view"]);
}
