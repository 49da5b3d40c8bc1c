//! What a run and a report leave.

use super::*;

/// Proves that lists are JSON arrays of objects with a name each, that what they name is what there is, and that the
/// same lists are there for people.
#[test]
fn lists() {
    let bench = Bench::new();
    let json = |arguments: &[&str]| -> Vec<String> {
        let outcome = bench.call(arguments);
        assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{arguments:?}");
        let value: Value = serde_json::from_str(&outcome.stdout).unwrap();
        let items = value.as_array().unwrap().iter();
        items.map(|item| item["name"].as_str().unwrap_or_else(|| panic!("{item}")).to_owned()).collect()
    };
    for (kind, expected) in [
        ("tracers", vec!["bvh-cpu", "bvh-gpu", "ploc-gpu", "dirt", "screen-dda", "height-field"]),
        ("scenes", vec!["room", "solids", "cloth", "hangar", "candy", "atrium", "foliage", "smithy"]),
        (
            "rays",
            vec![
                "primary",
                "diffuse",
                "ao",
                "visibility",
                "specular",
                "glossy",
                "glossy2",
                "glossy3",
                "bounce2",
                "refraction",
                "random",
                "pixel-random",
                "stereo",
                "temporal",
                "lens",
                "light-field",
            ],
        ),
    ] {
        let found = json(&["list", kind, "--json"]);
        assert!(expected.iter().all(|name| found.iter().any(|found| found == name)), "{found:?}");
        let text = bench.call(&["list", kind]);
        assert_eq!(text.status, 0);
        assert!(found.iter().all(|name| text.stdout.contains(name)), "{text:?}");
    }
    let machine: Value = serde_json::from_str(&bench.call(&["doctor", "--json"]).stdout).unwrap();
    let adapters = machine["adapters"].as_array().unwrap();
    assert!(!adapters.is_empty(), "there is no adapter; setup.sh installs one");
    let chosen = &adapters[machine["chosen"].as_u64().unwrap() as usize];
    assert_eq!(machine["machine"]["adapter"]["name"], chosen["name"]);
    assert!(
        chosen["max_buffer_bytes"].as_u64().unwrap() > 0 && machine["machine"]["threads"].as_u64().unwrap() > 0,
        "{machine}"
    );
    let text = bench.call(&["doctor"]).stdout;
    assert!(text.contains(chosen["name"].as_str().unwrap()) && text.contains("\nchosen: 0; buffers of "), "{text}");
    let missing = machine["missing"].as_array().unwrap();
    assert!(
        missing.iter().all(|each| text.contains(&format!("missing: {}", each["what"].as_str().unwrap()))),
        "{text}"
    );
    assert_eq!(
        missing.iter().any(|each| each["what"].as_str().unwrap().contains("software")),
        chosen["kind"] == "software"
    );
    for help in [vec!["--help"], vec!["--version"], vec!["run", "--help"]] {
        let outcome = bench.call(&help);
        assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""));
        assert!(outcome.stdout.contains("tracebench"));
    }
}

/// Every path to a value that scripts may rely on, from a run, a trace and a verdict.
const RUN_FIELDS: [&str; 32] = [
    "/fingerprint",
    "/scene/name",
    "/scene/sha256",
    "/scene/triangles",
    "/scene/diagonal",
    "/viewpoint/eye",
    "/tracer/name",
    "/tracer/preset",
    "/tracer/parameters",
    "/memory/structure",
    "/memory/structure_bytes",
    "/memory/geometry_bytes",
    "/memory/build_peak_bytes",
    "/build/clock",
    "/build/samples_ms",
    "/build/median_ms",
    "/build/interval_ms/1",
    "/build/phases",
    "/build/first/samples_ms",
    "/build/first/median_ms",
    "/build/steady/samples_ms",
    "/build/steady/interval_ms/1",
    "/build/setup_ms",
    "/traces/0/rays",
    "/traces/0/query",
    "/traces/0/count",
    "/traces/0/trace_to",
    "/traces/0/clock",
    "/traces/0/samples_ms",
    "/traces/0/median_ms",
    "/traces/0/interval_ms/1",
    "/traces/0/judgement",
];
const TRACE_FIELDS: [&str; 5] =
    ["/mrays_per_s", "/per_trace_bytes", "/hits_sha256", "/counters", "/judgement/ambiguous_rays"];
const CLOSEST_FIELDS: [&str; 11] = [
    "/classes/tight/true_hit",
    "/classes/footprint/late",
    "/agreement/hit_miss",
    "/agreement/tight",
    "/agreement/footprint",
    "/interval/hit_miss/1",
    "/curve/0/1",
    "/position_error/p50",
    "/position_error/p95",
    "/position_error/p99",
    "/causes",
];
const ANY_FIELDS: [&str; 6] = [
    "/occlusion/true_occluded",
    "/occlusion/true_free",
    "/occlusion/false_occluded",
    "/occlusion/false_free",
    "/occlusion/balanced_accuracy",
    "/causes",
];

/// The fields of a run.json that are missing or null.
fn missing(run: &Value) -> Vec<String> {
    let mut missing = Vec::new();
    let mut look = |value: &Value, within: &str, fields: &[&str]| {
        let absent = fields.iter().filter(|field| value.pointer(field).is_none_or(Value::is_null));
        missing.extend(absent.map(|field| format!("{within}{field}")));
    };
    look(run, "", &["/schema", "/machine/cpu", "/commit", "/seed", "/preset", "/controls/0", "/rows/0", "/skipped"]);
    for list in ["controls", "rows"] {
        for (index, each) in run[list].as_array().into_iter().flatten().enumerate() {
            let within = format!("{list}/{index}");
            look(each, &within, &RUN_FIELDS);
            for (number, trace) in each["traces"].as_array().into_iter().flatten().enumerate() {
                let within = format!("{within}/traces/{number}");
                look(trace, &within, &TRACE_FIELDS);
                let fields: &[&str] = if trace["query"] == "any" { &ANY_FIELDS } else { &CLOSEST_FIELDS };
                // Errors of position exist where something is hit; a control that never hits has none.
                let fields: Vec<&str> = fields
                    .iter()
                    .copied()
                    .filter(|field| each["tracer"]["name"] != "always-miss" || !field.contains("position_error"))
                    .collect();
                look(&trace["judgement"], &format!("{within}/judgement"), &fields);
            }
            for (number, part) in each["memory"]["structure"].as_array().into_iter().flatten().enumerate() {
                let within = format!("{within}/memory/{number}");
                look(part, &within, &["/name", "/allocated_bytes", "/used_bytes"]);
            }
        }
    }
    missing
}

/// Proves that drivers say nothing on stderr on a machine without a display.
#[test]
fn drivers_are_quiet_without_a_display() {
    let bench = Bench::new();
    let mut command = bench.command(&["doctor"]);
    for name in ["NODEVICE_SELECT", "XDG_RUNTIME_DIR", "WAYLAND_DISPLAY", "DISPLAY"] {
        command.env_remove(name);
    }
    let outcome = Bench::finish(&mut command);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
}

/// Proves a whole smoke run: every file is there and none but those, run.json has every promised field, the controls
/// score what they must, the host tracer is right; and quiet means that stderr is empty.
#[test]
fn a_smoke_run() {
    let bench = Bench::new();
    let out = bench.text("out");
    let outcome = bench.call(&[&SMOKE[..], &["--quiet", "--tracer", "all", "--rays", "all", "--out", &out]].concat());
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    assert!(outcome.stdout.contains("bvh-cpu") && outcome.stdout.contains("summary.md"), "{outcome:?}");
    assert!(outcome.stdout.starts_with("room, viewpoint ") && outcome.stdout.contains("footprint"), "{outcome:?}");
    let files = names(&bench.path("out"));
    for file in ["run.json", "summary.md", "rows.csv", "wrong_rays.csv"] {
        assert!(files.contains(file), "{files:?}");
    }
    for end in [".svg", ".png"] {
        assert!(files.iter().filter(|file| file.ends_with(end)).count() >= 2, "{files:?}");
    }
    let known = [".json", ".md", ".csv", ".svg", ".png", ".html"];
    assert!(
        files.iter().all(|file| known.iter().any(|end| file.ends_with(end)) && !file.starts_with('.')),
        "{files:?}"
    );
    let run = bench.result("out");
    assert_eq!(missing(&run), Vec::<String>::new());
    assert_eq!(
        (run["schema"].as_u64(), run["preset"].as_str(), run["seed"].as_u64()),
        (Some(3), Some("smoke"), Some(1))
    );
    assert!(run["dirty"].is_boolean() || run["dirty"].is_null());
    let by_name = |list: &str, name: &str| -> Value {
        let all = run[list].as_array().unwrap().iter();
        all.clone().find(|each| each["tracer"]["name"] == name).unwrap_or_else(|| panic!("no {name}")).clone()
    };
    let sets: Value = serde_json::from_str(&bench.call(&["list", "rays", "--json"]).stdout).unwrap();
    // Hostile rays are asked for by name alone.
    let sets = sets.as_array().unwrap().iter().filter(|set| set["name"] != "hostile").count();
    for name in ["oracle", "always-miss", "always-hit", "corrupted"] {
        assert_eq!(by_name("controls", name)["traces"].as_array().unwrap().len(), sets);
    }
    let oracle = by_name("controls", "oracle");
    assert_eq!(oracle["traces"][0]["judgement"]["agreement"]["tight"], 1.0);
    for name in ["bvh-cpu", "bvh-gpu", "ploc-gpu", "dirt", "screen-dda", "height-field"] {
        let run = by_name("rows", name);
        assert_eq!(run["traces"][0]["count"], 128);
        assert_eq!(run["traces"][0]["samples_ms"].as_array().unwrap().len(), 3);
        assert_eq!(run["traces"][2]["query"], "any");
    }
    // What a tracer does not serve is skipped for it alone, and the rest of it is there.
    let is_named = |name: &str| {
        let skipped = run["skipped"].as_array().unwrap().iter();
        skipped
            .filter(|each| each["tracer"] == name)
            .map(|each| each["rays"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    let served = by_name("rows", "mesh-warp")["traces"].as_array().unwrap().len();
    let skipped = is_named("mesh-warp");
    assert!(served >= 3 && skipped.contains(&"diffuse".to_owned()), "{skipped:?}");
    let made_for_all = by_name("rows", "bvh-cpu")["traces"].as_array().unwrap().len();
    assert_eq!((served + skipped.len(), is_named("bvh-cpu").len()), (made_for_all, 0));
    let judgement = &by_name("rows", "bvh-cpu")["traces"][0]["judgement"];
    assert!(judgement["agreement"]["tight"].as_f64().unwrap() >= 0.98, "{judgement}");
    assert!(judgement["identity"].is_number());
    // Negative control of the field check.
    let mut less = run;
    less["rows"][0]["traces"][0].as_object_mut().unwrap().remove("hits_sha256");
    less["rows"][1]["build"]["setup_ms"] = Value::Null;
    assert_eq!(missing(&less), ["rows/0/traces/0/hits_sha256", "rows/1/build/setup_ms"]);
}

fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    names(folder).into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap())).collect()
}

/// Proves that `report` makes every derived file again, byte for byte, from the folder, from the file, and from the file
/// in the folder one is in.
#[test]
fn reports_are_reproducible() {
    let bench = Bench::new();
    bench.run(&["--tracer", "bvh-cpu", "--rays", "all"], "out");
    let folder = bench.path("out");
    let before = contents(&folder);
    assert!(before.len() >= 8);
    let remake = |arguments: &[&str], directory: &Path| {
        // The page is made by `report --html` alone.
        for name in names(&folder).into_iter().filter(|name| !["run.json", "report.html"].contains(&name.as_str())) {
            std::fs::remove_file(folder.join(name)).unwrap();
        }
        let outcome = Bench::finish(bench.command(arguments).current_dir(directory));
        assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
        assert_eq!(names(&folder), before.iter().map(|(name, _)| name.clone()).collect());
        let after = contents(&folder);
        let changed: Vec<_> =
            before.iter().zip(&after).filter(|(old, new)| old != new).map(|(old, _)| &old.0).collect();
        assert!(changed.is_empty(), "{changed:?}");
    };
    let out = bench.text("out");
    remake(&["report", "--quiet", &out], bench.folder.path());
    remake(&["--quiet", "report", &bench.text("out/run.json")], bench.folder.path());
    remake(&["report", "--quiet", "run.json"], &folder);
    remake(&["report", "--quiet", "."], &folder);
    // Negative control: another figure in run.json makes other files.
    let mut run = bench.result("out");
    run["commit"] = json!("f".repeat(40));
    std::fs::write(folder.join("run.json"), serde_json::to_vec_pretty(&run).unwrap()).unwrap();
    // A chart that an older run left would pass for this one's; other people's files are theirs, whatever their names.
    write_as_the_program(&folder, "error_vs_speed_attic.svg", "old");
    let theirs =
        ["agreement_over_tolerance_cellar.png", "error_vs_speed_.txt", "error_vs_speed_cellar.svg", "mine.svg"];
    for name in theirs {
        std::fs::write(folder.join(name), b"old").unwrap();
    }
    assert_eq!(bench.call(&["report", &out]).status, 0);
    assert_ne!(contents(&folder), before);
    let left: Vec<String> =
        names(&folder).into_iter().filter(|name| before.iter().all(|(known, _)| known != name)).collect();
    assert_eq!(left, theirs);
}

/// What of a run must not change from one run to the next: hashes, counters, verdicts.
fn verdicts(run: &Value) -> Vec<Value> {
    let lists = ["controls", "rows"].into_iter().flat_map(|list| run[list].as_array().unwrap().iter());
    let traces = lists.flat_map(|each| each["traces"].as_array().unwrap().iter());
    traces
        .map(|trace| json!([trace["hits_sha256"], trace["rays_sha256"], trace["counters"], trace["judgement"]]))
        .collect()
}

/// Proves that two runs give the same hits and verdicts, with a warm cache, a cold one and none, and that another seed
/// does not.
#[test]
fn two_runs_agree() {
    let bench = Bench::new();
    // That every tracer repeats its answers is proved where structures are asked for them.
    let tracers = ["--tracer", "bvh-gpu,screen-dda"];
    let run = |adaptive: &[&str], out: &str| verdicts(&bench.run(&[&tracers[..], adaptive].concat(), out));
    let first = run(&["--rays", "all"], "first");
    assert!(first.len() >= 12);
    assert_eq!(run(&["--rays", "all"], "second"), first);
    let out = bench.text("third");
    let mut command = bench.command(&[&SMOKE[..], &tracers, &["--out", &out]].concat());
    assert_eq!(Bench::finish(command.env("TRACEBENCH_CACHE", "")).status, 0);
    assert_eq!(verdicts(&bench.result("third")), first);
    assert_ne!(run(&["--seed", "2"], "fourth"), first);
}

/// Proves that a set without rays is skipped with its reason and the run goes well: a camera that looks away from the
/// scene has primary rays, which all miss, and no others.
#[test]
fn empty_ray_sets_are_skipped() {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), glb(&TRIANGLE)).unwrap();
    let away = ["--scene", "one.glb", "--tracer", "all", "--view", "0,0,5:0,0,9"];
    let run = bench.run(&[&away[..], &["--rays", "all"]].concat(), "all");
    // What a tracer lacks on this adapter is skipped for all sets, and rays that it does not serve for it alone.
    let of_sets = |run: &Value| -> Vec<Value> {
        let of_all = |each: &&Value| !each["rays"].is_null() && each["tracer"].is_null();
        run["skipped"].as_array().unwrap().iter().filter(of_all).cloned().collect()
    };
    let skipped = of_sets(&run);
    let sets: Vec<&str> = skipped.iter().map(|each| each["rays"].as_str().unwrap()).collect();
    let from_hits = ["diffuse", "ao", "visibility", "specular", "glossy", "glossy2", "glossy3", "bounce2"];
    assert_eq!(sets, [&from_hits[..], &["refraction", "pixel-random"]].concat());
    assert!(skipped.iter().all(|each| each["reason"].as_str().unwrap().contains("empty")));
    assert_eq!(run["rows"][0]["traces"].as_array().unwrap().len(), 6);
    assert_eq!(run["rows"][0]["traces"][0]["judgement"]["classes"]["tight"]["true_miss"], 128);
    let run = bench.run(&[&away[..], &["--rays", "ao"]].concat(), "none");
    assert!(run["rows"][0]["traces"].as_array().unwrap().is_empty());
    assert_eq!(of_sets(&run).len(), 1);
}

/// Proves that settings reach the tracer and the record, that a preset by name is in it, and that frames are the
/// viewpoint's.
#[test]
fn settings_are_recorded() {
    let bench = Bench::new();
    let arguments = [
        "--tracer",
        "bvh-cpu:improved,screen-dda",
        "--rays",
        "primary",
        "--set",
        "screen-dda.stride=7",
        "--frame-size",
        "40x30",
        "--face-size",
        "9",
        "--samples",
        "2",
        "--seed",
        "5",
    ];
    let run = bench.run(&arguments, "out");
    let tracer = |index: usize| &run["rows"][index]["tracer"];
    assert_eq!((&tracer(0)["preset"], &tracer(0)["parameters"]["build"]), (&json!("improved"), &json!("slow")));
    assert_eq!((&tracer(1)["preset"], &tracer(1)["parameters"]["stride"]), (&json!("published"), &json!(7)));
    assert_eq!(tracer(1)["changed"], json!(["stride"]));
    assert_eq!(run["rows"][1]["viewpoint"]["frame"], json!([40, 30]));
    assert_eq!((&run["rows"][1]["viewpoint"]["face"], &run["seed"]), (&json!(9), &json!(5)));
    assert_eq!(run["rows"][0]["build"]["samples_ms"].as_array().unwrap().len(), 2);
}

/// Proves that a time moves a scene that has an animation, later than its end no further, and leaves others alone.
#[test]
fn times_move_scenes() {
    let bench = Bench::new();
    let hash = |scene: &str, time: &str| {
        let run =
            bench.run(&["--scene", scene, "--animation-time", time, "--tracer", "bvh-cpu", "--rays", "primary"], "out");
        let found = run["rows"][0]["scene"]["sha256"].as_str().unwrap().to_owned();
        (found, run["rows"][0]["traces"][0]["judgement"]["agreement"]["tight"].as_f64().unwrap())
    };
    let (start, later, end) = (hash("cloth", "0"), hash("cloth", "1"), hash("cloth", "1000"));
    assert!(start.0 != later.0 && later.0 != end.0 && start.0 != end.0);
    assert!([&start, &later, &end].iter().all(|(_, agreement)| *agreement > 0.98));
    assert_eq!(hash("room", "0").0, hash("room", "1").0);
    assert_eq!(hash("cloth", "-5").0, start.0);
    let triangles = |scale: &str| {
        let run = bench.run(&["--scale", scale, "--tracer", "bvh-cpu", "--rays", "primary"], "out");
        assert_eq!(run["rows"][0]["scene"]["scale"].as_f64().unwrap().to_string(), scale);
        run["rows"][0]["scene"]["triangles"].as_u64().unwrap()
    };
    assert!(triangles("0.2") < triangles("0.5"));
}
