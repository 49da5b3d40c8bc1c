//! `table` over the papers' tables and figures, and over their claims.

use std::collections::BTreeMap;

use super::*;

/// A table that takes seconds: one triangle, few rays.
const SMALL: [&str; 9] = ["--quiet", "--scene", "one.glb", "--preset", "smoke", "--size", "16x8", "--samples", "2"];

fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), glb(&TRIANGLE)).unwrap();
    bench
}

fn table(bench: &Bench, name: &str, out: &str, arguments: &[&str]) -> Outcome {
    let outcome = bench.call(&[&["table", name][..], &SMALL, &["--out", out], arguments].concat());
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    outcome
}

/// Proves that a table of frames is written with its claims, that it is measured over in its own folder and by its own verb alone, and that
/// options of rounds are refused.
#[test]
fn a_table_of_frames() {
    let bench = Bench::new();
    let words =
        ["table", "dirt-reuse", "--quiet", "--scene", "cloth", "--preset", "smoke", "--size", "16x8", "--out", "out"];
    for _ in 0..2 {
        let outcome = bench.call(&words);
        assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
        assert!(
            outcome.page.contains("| views of frame |") && outcome.page.contains("dirt-static-reuse"),
            "{outcome:?}"
        );
    }
    let run = bench.result("out");
    assert_eq!((run["table"].as_str(), run["frames"]["rows"].as_array().map(Vec::len)), (Some("dirt-reuse"), Some(5)));
    let frames = ["frames", "--quiet", "--tracer", "bvh-cpu", "--preset", "smoke", "--out", "out"];
    bench.fails(&frames, 2, &["what `table` measured"]);
    for more in [&["--tuned", "out"][..], &["--estimate", "out"], &["--samples", "3"], &["--time-limit", "1"]] {
        bench.fails(&[&words[..words.len() - 2], more].concat(), 2, &[more[0], "dirt-reuse is of frames"]);
    }
}

/// Proves that a sweep has a row for every combination, that page, chart and verdicts are written, tell published values and
/// every claim of the table, and that `report` and `--from` make the same files from run.json alone.
#[test]
fn a_figure_over_parameters() {
    let bench = bench();
    let outcome = table(&bench, "dirt-figure10", "out", &[]);
    for part in
        ["## Published", "GTX 980 Ti", "| 1x1 to 2x2 | 56 | 50 |", "not available", "## Claims", "stands for none"]
    {
        assert!(outcome.page.contains(part), "no '{part}' in {}", outcome.page);
    }
    let run = bench.result("out");
    assert_eq!(run["table"], "dirt-figure10");
    let rows = run["rows"].as_array().unwrap();
    let labels: BTreeSet<String> = rows.iter().map(|one| one["tracer"]["parameters"].to_string()).collect();
    assert_eq!((rows.len(), labels.len()), (15, 15));
    let verdicts = "out/verdicts_dirt_figure10.json";
    let judged: Value = serde_json::from_slice(&std::fs::read(bench.path(verdicts)).unwrap()).unwrap();
    for each in judged.as_array().unwrap() {
        assert!(outcome.page.contains(each["claim"]["id"].as_str().unwrap()), "{each}");
        assert_eq!(each["measured_by"]["table"], "dirt-figure10");
    }
    let references = |tile_size: &str, buckets: u64| {
        let is_row = |one: &&Value| {
            let parameters = &one["tracer"]["parameters"];
            parameters["tile_size"] == tile_size && parameters["buckets"] == buckets
        };
        rows.iter().find(is_row).unwrap()["structure_statistics"]["references"].as_f64().unwrap()
    };
    let saved = [16, 24, 32, 40].map(|buckets| 100.0 * (1.0 - references("2", buckets) / references("1", buckets)));
    let found = judged.as_array().unwrap().iter().find(|each| each["claim"]["id"] == "dirt-samples-2x2").unwrap();
    let found = found["values"][0]["value"].as_f64().unwrap();
    assert!((found - saved.iter().sum::<f64>() / 4.0).abs() < 1e-9, "{found} of {saved:?}");
    let files = [
        "out/table_dirt_figure10.md",
        verdicts,
        "out/figure_dirt_figure10_one.svg",
        "out/figure_dirt_figure10_one.png",
    ];
    let files = files.map(|name| bench.path(name));
    let before = files.clone().map(|file| std::fs::read(file).unwrap());
    for again in [vec!["report", "out"], vec!["table", "dirt-figure10", "--from", "out"]] {
        files.iter().for_each(|file| std::fs::remove_file(file).unwrap());
        assert_eq!(bench.call(&[&["--quiet"][..], &again].concat()).status, 0);
        assert!(files.clone().map(|file| std::fs::read(file).unwrap()) == before, "{again:?}");
    }
}

/// Proves that steps over resolution are in one run, frame and faces growing along, traced to surfaces where memory is those'
/// too; that a table without traces tells no times; and that a paper's claims are set together from several runs, with every claim in the
/// text and in the files.
#[test]
fn a_figure_over_resolution_and_all_claims() {
    let bench = bench();
    let outcome = table(&bench, "dirt-figure11", "memory", &[]);
    assert!(outcome.page.contains("references"), "{outcome:?}");
    let run = bench.result("memory");
    let rows = run["rows"].as_array().unwrap();
    let sizes: Vec<Value> =
        rows.iter().map(|one| json!([one["viewpoint"]["ray_image"], one["viewpoint"]["face"]])).collect();
    // Both methods at every resolution.
    let expected = [json!([[4, 2], 16]), json!([[8, 4], 32]), json!([[16, 8], 64]), json!([[32, 16], 128])];
    assert_eq!(sizes, expected.iter().flat_map(|size| [size.clone(), size.clone()]).collect::<Vec<_>>());
    assert!(
        rows.iter()
            .all(|one| one["traces"].as_array().unwrap().len() == 1 && one["traces"][0]["trace_to"] == "surface")
    );
    // Without traces there is no accuracy, so no time either.
    let outcome = table(&bench, "dirt-table3", "bytes", &[]);
    assert!(!outcome.page.contains("build clock") && outcome.page.contains("references"), "{outcome:?}");
    let outcome = bench.call(&["table", "dirt-claims", "--from", "memory", "bytes/run.json", "--out", "claims"]);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    assert!(
        outcome.stdout.contains("\n- not measured: ") && outcome.stdout.ends_with("\nclaims/claims_dirt.md\n"),
        "{outcome:?}"
    );
    assert_eq!(names(&bench.path("claims")), ["claims_dirt.json", "claims_dirt.md"].map(str::to_owned).into());
    let judged = std::fs::read(bench.path("claims/claims_dirt.json")).unwrap();
    let judged: Value = serde_json::from_slice(&judged).unwrap();
    let judged = judged.as_array().unwrap();
    let verdict = |id: &str| {
        let found = judged.iter().find(|each| each["claim"]["id"] == id).unwrap_or_else(|| panic!("no {id}"));
        found["verdict"].as_str().unwrap().to_owned()
    };
    assert!(judged.len() > 60 && judged.iter().all(|each| each["verdict"].is_string()));
    // A file stands for none of the paper's scenes: it is shown and decides nothing.
    let value = |id: &str| {
        let found = judged.iter().find(|each| each["claim"]["id"] == id).unwrap();
        assert!(found["reason"].as_str().unwrap().contains("stands for"), "{found}");
        (verdict(id), found["values"][0]["value"].as_f64().unwrap())
    };
    let (said, factor) = value("dirt-mipmap-factor");
    assert!(said == "not measured" && (factor - 4.0 / 3.0).abs() < 0.02, "{factor}");
    assert_eq!(value("dirt-clipped-bounds"), ("not measured".to_owned(), 1.0));
    assert_eq!(verdict("dirt-cr-lists-oblique"), "not measurable here");
    assert_eq!(verdict("dirt-samples-2x2"), "not measured");
    for each in judged {
        let id = each["claim"]["id"].as_str().unwrap();
        assert!(outcome.page.contains(&format!("| `{id}`:")), "{id}");
    }
    assert!(outcome.page.contains("tracebench table dirt-figure10"), "{}", outcome.page);
}

/// Proves that steps that are about rays have their own, as many as they say, and that rows and page tell what was said of them.
#[test]
fn steps_about_rays() {
    let bench = bench();
    let rows = [
        "quadtree.layers=1",
        "quadtree.secondary_samples=0",
        "quadtree.dilated=continuous",
        "quadtree.inpainting=one_layer",
        "quadtree.memory_access=buffer",
        "quadtree.rays_per_lane=1",
        "screen-dda.layers=1",
        "screen-dda.max_steps=25",
        "screen-dda.memory_access=buffer",
        "screen-dda.rays_per_lane=1",
    ];
    let only: Vec<&str> = rows.iter().flat_map(|row| ["--only", *row]).collect();
    let outcome = table(&bench, "wkp15-table4", "lens", &only);
    assert!(outcome.page.contains("count = 32") && outcome.page.contains("| 4/1 |"), "{}", outcome.page);
    let run = bench.result("lens");
    assert_eq!(run["ray_parameters"]["lens_count"], 4);
    let told = |one: &Value| {
        let said = &one["viewpoint"]["ray_parameters"];
        json!([one["viewpoint"]["ray_image"], said.get("lens_count"), one["traces"][0]["count"]])
    };
    let found: Vec<Value> = run["rows"].as_array().unwrap().iter().map(told).collect();
    let expected = [
        json!([[16, 8], null, 512]),
        json!([[16, 8], null, 512]),
        json!([[16, 8], 8, 1024]),
        json!([[16, 8], 8, 1024]),
        json!([[8, 4], 8, 256]),
        json!([[8, 4], 32, 1024]),
    ];
    assert_eq!(found, expected);
    // A file stands for none of the paper's scenes.
    assert!(outcome.page.contains("**not measured**"), "{}", outcome.page);
}

/// Proves that VVP16's tables are made as DIRT's are: a row for every storage, its ledger the paper's formula on the counts in
/// run.json, a chart of Figure 12; and that all its claims are set together, those of a scene for which none stands not measured.
#[test]
fn storages_of_the_other_paper() {
    let bench = bench();
    let outcome = table(&bench, "vvp16-table2", "bytes", &[]);
    assert!(outcome.page.contains("GTX 780 Ti") && outcome.page.contains("ledger over formula"), "{outcome:?}");
    let rows = bench.result("bytes")["rows"].as_array().unwrap().clone();
    assert_eq!(rows.len(), 9);
    for run in &rows {
        let buckets = run["tracer"]["parameters"]["buckets"].as_f64().unwrap();
        let (words, [of_pixel, of_fragment]) = match run["tracer"]["parameters"]["storage"].as_str().unwrap() {
            "s-buffer" => ("begins and counts", [8.0, 8.0]),
            "ll" => ("heads", [4.0, 8.0]),
            "dll" => ("heads and tails", [8.0, 12.0]),
            "llb" => ("depth bounds and heads", [8.0 + 4.0 * buckets, 8.0]),
            "dllb" => ("depth bounds, heads and tails", [8.0 + 8.0 * buckets, 12.0]),
            other => panic!("{other}"),
        };
        let count = |name: &str| run["structure_statistics"][name].as_f64().unwrap();
        let used = |name: &str| {
            let parts = run["memory"]["structure"].as_array().unwrap().iter();
            let own = parts.filter(|part| part["name"].as_str().unwrap().starts_with(name));
            own.map(|part| part["used_bytes"].as_f64().unwrap()).sum::<f64>()
        };
        assert!(count("fragments") > 0.0);
        assert_eq!(used(words), count("pixels") * of_pixel, "{}", run["tracer"]);
        assert_eq!(used("id buffer"), count("fragments") * of_fragment, "{}", run["tracer"]);
        assert_eq!(used("data buffer"), count("fragments") * 16.0, "{}", run["tracer"]);
    }
    let set = ["--set", "rays.pixel_random_count=1"];
    let outcome = table(&bench, "vvp16-figure12", "variants", &set);
    assert!(outcome.page.contains("| one | dllb |") && outcome.page.contains("not available"), "{outcome:?}");
    assert_eq!(bench.result("variants")["rows"].as_array().unwrap().len(), 15);
    assert!(names(&bench.path("variants")).contains("figure_vvp16_figure12.svg"));
    let outcome = bench.call(&["table", "vvp16-claims", "--from", "bytes", "variants", "--out", "claims"]);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    let judged = std::fs::read(bench.path("claims/claims_vvp16.json")).unwrap();
    let judged: Value = serde_json::from_slice(&judged).unwrap();
    let judged = judged.as_array().unwrap();
    assert_eq!(judged.len(), 62);
    let found = |id: &str| judged.iter().find(|each| each["claim"]["id"] == id).unwrap();
    for (id, expected) in
        [("vvp16-memory-formula", 1.0), ("vvp16-dllb-overhead", 1.0), ("vvp16-textures", 1.0), ("vvp16-id-node", 12.0)]
    {
        // A file stands for none of the paper's scenes: it is shown and decides nothing.
        assert_eq!(
            (&found(id)["verdict"], &found(id)["values"][0]["value"]),
            (&json!("not measured"), &json!(expected))
        );
    }
    let ruins = found("vvp16-skipping-ruins");
    assert!(ruins["verdict"] == "not measured" && ruins["reason"].as_str().unwrap().contains("Ruins"), "{ruins}");
    // On a busy machine times may be invalid, or too short for the clock that two have in common: then nothing is said of them.
    let record = bench.result("variants");
    let rows = record["rows"].as_array().unwrap().iter();
    let traces: BTreeMap<&str, &Value> = rows
        .filter(|run| run["tracer"]["parameters"]["skip_bounds"] == "on")
        .map(|run| (run["tracer"]["parameters"]["storage"].as_str().unwrap(), &run["traces"][0]))
        .collect();
    let is_timed = |trace: &Value, by_host: bool| {
        let by_other_clock = by_host && trace["clock"] != "host";
        let samples = &trace[if by_other_clock { "submit_to_done_samples_ms" } else { "samples_ms" }];
        let samples = samples.as_array().unwrap();
        trace["invalid"].is_null() && !samples.is_empty() && samples.iter().all(|ms| ms.as_f64() > Some(0.0))
    };
    let dllb = traces["dllb"];
    let is_compared = |one: &&Value| [one, dllb].iter().all(|trace| is_timed(trace, one["clock"] != dllb["clock"]));
    assert_eq!(traces.len(), 5);
    let values = found("vvp16-bucketed-faster")["values"].as_array().unwrap().len();
    assert_eq!(values, usize::from(traces.values().all(is_compared)));
    assert_eq!(found("vvp16-linear-buckets")["verdict"], "not measurable here");
}

/// Proves that what an experiment says of its rays counts unless the command line says otherwise, and that `--set` reaches every
/// row but values that rows are about.
#[test]
fn settings_come_on_top() {
    let bench = bench();
    let target = |run: &Value| run["ray_parameters"]["visibility_target"].as_str().unwrap().to_owned();
    table(&bench, "dirt-table1", "plain", &["--rays", "diffuse"]);
    assert_eq!(target(&bench.result("plain")), "outside");
    let set = ["--rays", "diffuse", "--set", "rays.visibility_target=inside", "--set", "dirt.clip=plane"];
    table(&bench, "dirt-table1", "set", &[&set[..], &["--set", "dirt.tile_size=8"]].concat());
    let run = bench.result("set");
    assert_eq!(target(&run), "inside");
    let parameters: Vec<Value> =
        run["rows"].as_array().unwrap().iter().map(|one| one["tracer"]["parameters"].clone()).collect();
    assert!(parameters.iter().all(|each| each["clip"] == "plane"), "{parameters:?}");
    let sizes: Vec<&str> = parameters.iter().map(|each| each["tile_size"].as_str().unwrap()).collect();
    assert_eq!(sizes, ["1", "2"]);
}

/// Proves that `--only` leaves the rows that it names, which the page says, and that `--estimate` tells by them how long all would take
/// and measures nothing.
#[test]
fn fewer_rows_and_how_long_all_take() {
    let bench = bench();
    let outcome = table(&bench, "dirt-figure10", "few", &["--only", "dirt.buckets=8", "--only", "dirt.tile_size=1,4"]);
    assert!(outcome.page.contains("0 of 45 rows"), "{outcome:?}");
    let run = bench.result("few");
    let told = |one: &Value| {
        let parameters = &one["tracer"]["parameters"];
        (parameters["tile_size"].as_str().unwrap().to_owned(), parameters["buckets"].as_u64().unwrap())
    };
    let rows: Vec<_> = run["rows"].as_array().unwrap().iter().map(told).collect();
    assert_eq!(rows, [("1".to_owned(), 8), ("4".to_owned(), 8)]);
    let before = names(bench.folder.path());
    let arguments = ["table", "dirt-figure10", "--scene", "room", "--preset", "paper", "--estimate", "few"];
    let outcome = bench.call(&arguments);
    assert!(outcome.status == 0 && outcome.stdout.contains("none of the 15 rows"), "{outcome:?}");
    assert_eq!(names(bench.folder.path()), before);
}

/// Proves that wrong arguments end with status 2 and name what is right, that what cannot be read or run ends with 1, and that
/// nothing is left behind.
#[test]
fn wrong_papers() {
    let bench = bench();
    for (arguments, parts) in [
        (vec!["table", "dirt-table9"], vec!["dirt-table9", "did you mean 'dirt-table"]),
        (vec!["table", "dirt-table1", "--set", "bvh-cpu.build=fast"], vec!["not in"]),
        (vec!["table", "dirt-table1", "--set", "dirt.tile_size=3"], vec!["1, 2, 4, 8"]),
        (vec!["table", "dirt-table1", "--set", "rays.visibility_target=up"], vec!["outside"]),
        (vec!["table", "dirt-figure10", "--only", "dirt.buckets=8,9"], vec!["no row has 9", "16"]),
        (vec!["table", "dirt-figure10", "--only", "bvh-cpu.build=fast"], vec!["no row has fast"]),
        (vec!["table", "bvh", "--only", "bvh-cpu.build=fast"], vec!["no paper's"]),
        (vec!["table", "dirt-figure11", "--preset", "smoke", "--size", "4096x4096"], vec!["--size", "2 times"]),
        (vec!["table", "dart-claims"], vec!["'dirt-claims'"]),
        (vec!["table", "dirt-claims", "--from", "nowhere", "nowhere"], vec!["twice"]),
        (vec!["table", "dirt-claims", "--from", "one.glb", "--scene", "room"], vec!["--scene"]),
        (vec!["table", "dirt-table1", "--from", "one.glb", "two.glb"], vec!["one record"]),
    ] {
        bench.fails(&arguments, 2, &parts);
    }
    bench.fails(&["table", "dirt-claims", "--from", "nowhere"], 1, &["nowhere", "run.json"]);
    bench.fails(&["table", "dirt-table1", "--from", "nowhere"], 1, &["nowhere", "run.json"]);
    bench.run(&["--tracer", "bvh-cpu", "--rays", "primary"], "others");
    bench.fails(&["table", "dirt-table1", "--from", "others"], 1, &["no tracer of this record belongs"]);
    let nothing = bench.call_without_adapter(&[&["table", "dirt-table3", "--out", "out"][..], &SMALL].concat());
    assert!(nothing.status == 1 && nothing.stderr.contains("no tracer could run"), "{nothing:?}");
    assert_eq!(names(bench.folder.path()), ["cache", "one.glb", "others"].map(str::to_owned).into());
}
