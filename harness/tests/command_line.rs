//! The program as scripts use it: exit statuses, messages, files.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};
use tempfile::TempDir;

/// What a run of the program left.
#[derive(Debug)]
struct Outcome {
    status: i32,
    stdout: String,
    stderr: String,
}

/// A folder to work in, with a cache of its own.
struct Bench {
    folder: TempDir,
}

/// A run that takes a second: few rays, the small room.
const SMOKE: [&str; 5] = ["run", "--preset", "smoke", "--size", "16x8"];

impl Bench {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    fn command<A: AsRef<OsStr>>(&self, arguments: &[A]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tracebench"));
        command.args(arguments).current_dir(self.folder.path()).env("TRACEBENCH_CACHE", self.path("cache"));
        // Mesa's device selection speaks on stderr where there is no desktop.
        command.env("NODEVICE_SELECT", "1");
        command
    }

    fn finish(command: &mut Command) -> Outcome {
        let output = command.output().unwrap();
        let outcome = Outcome {
            status: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        };
        assert!(!outcome.stderr.contains("panicked"), "{outcome:?}");
        outcome
    }

    fn call<A: AsRef<OsStr>>(&self, arguments: &[A]) -> Outcome {
        Self::finish(&mut self.command(arguments))
    }

    /// As on a machine where no driver is installed.
    fn call_without_adapter<A: AsRef<OsStr>>(&self, arguments: &[A]) -> Outcome {
        let nowhere = self.path("no-such-driver.json");
        let mut command = self.command(arguments);
        command.env("VK_DRIVER_FILES", &nowhere).env("VK_ICD_FILENAMES", &nowhere).env("WGPU_BACKEND", "vulkan");
        Self::finish(&mut command)
    }

    /// A failure: its status, nothing on stdout, and every part of the message on stderr.
    fn fails<A: AsRef<OsStr> + std::fmt::Debug>(&self, arguments: &[A], status: i32, parts: &[&str]) {
        let outcome = self.call(arguments);
        assert_eq!(outcome.status, status, "{arguments:?}: {outcome:?}");
        assert!(outcome.stdout.is_empty(), "{arguments:?}: {outcome:?}");
        assert!(outcome.stderr.contains("error"), "{arguments:?}: {outcome:?}");
        for part in parts {
            assert!(outcome.stderr.contains(part), "{arguments:?}: no '{part}' in {}", outcome.stderr);
        }
    }

    /// A run that must succeed, into a folder of the bench.
    fn run(&self, arguments: &[&str], out: &str) -> Value {
        let folder = self.text(out);
        let outcome = self.call(&[&SMOKE, arguments, &["--out", &folder]].concat());
        assert_eq!(outcome.status, 0, "{arguments:?}: {outcome:?}");
        self.result(out)
    }

    fn result(&self, out: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(out).join("run.json")).unwrap()).unwrap()
    }
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).map(|entries| entries.map(|entry| entry.unwrap().file_name()));
    entries.map(|names| names.map(|name| name.into_string().unwrap()).collect()).unwrap_or_default()
}

/// A .glb with these positions as triangles, three vertices each.
fn glb(positions: &[[f32; 3]]) -> Vec<u8> {
    let bin: Vec<u8> = positions.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let mut json = gltf(positions.len(), bin.len(), None).to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let body = [chunk(b"JSON", &json), chunk(b"BIN\0", &bin)].concat();
    [b"glTF", &2_u32.to_le_bytes()[..], &(body.len() as u32 + 12).to_le_bytes(), &body].concat()
}

fn gltf(count: usize, bytes: usize, uri: Option<&str>) -> Value {
    let mut buffer = json!({"byteLength": bytes});
    if let Some(uri) = uri {
        buffer["uri"] = json!(uri);
    }
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": count}],
        "bufferViews": [{"buffer": 0, "byteLength": bytes}],
        "buffers": [buffer],
    })
}

const TRIANGLE: [[f32; 3]; 3] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];

/// Proves that wrong arguments end with status 2, name what is wrong and the nearest thing that is right, and touch no
/// file.
#[test]
fn wrong_arguments() {
    let bench = Bench::new();
    let out = bench.text("out");
    let run = |arguments: &[&str]| {
        [&["run", "--out", &out], arguments].concat().iter().map(|x| (*x).to_owned()).collect::<Vec<_>>()
    };
    for (arguments, parts) in [
        (vec!["--scene", "rooom"], vec!["rooom", "'room'"]),
        (vec!["--tracer", "bvh-cpo"], vec!["bvh-cpo", "'bvh-cpu'"]),
        (vec!["--tracer", "screendda"], vec!["'screen-dda'"]),
        (vec!["--tracer", "bvh-cpu:improvd"], vec!["'improved'"]),
        (vec!["--rays", "primry"], vec!["'primary'"]),
        (vec!["--rays", "primary,,ao"], vec!["empty name"]),
        (vec!["--preset", "quik"], vec!["quick"]),
        (vec!["--size", "0x0"], vec!["--size", "0x0"]),
        (vec!["--size", "0x16"], vec!["--size"]),
        (vec!["--size", "16"], vec!["--size"]),
        (vec!["--size", "-4x4"], vec![]),
        (vec!["--size", "99999999999x99999999999"], vec!["--size"]),
        (vec!["--size", "16384x16384"], vec!["--size", "the most"]),
        (vec!["--frame", "0x0"], vec!["--frame"]),
        (vec!["--frame", "100000x1"], vec!["--frame", "16384"]),
        (vec!["--face", "0"], vec!["--face"]),
        (vec!["--face", "1000000"], vec!["--face"]),
        (vec!["--samples", "0"], vec!["--samples"]),
        (vec!["--samples", "-1"], vec![]),
        (vec!["--seed", "x"], vec!["--seed"]),
        (vec!["--time", "NaN"], vec!["--time"]),
        (vec!["--time", "inf"], vec!["--time"]),
        (vec!["--view", "1,2,3"], vec!["--view"]),
        (vec!["--view", "1,2,3:1,2,3"], vec!["--view"]),
        (vec!["--view", "NaN,0,0:1,1,1"], vec!["--view"]),
        (vec!["--set", "screen-dda.stride=0"], vec!["stride", "1 to 256"]),
        (vec!["--set", "screen-dda.thickness=NaN"], vec!["thickness", "0 to 10"]),
        (vec!["--set", "screen-dda.thickness=-1"], vec!["thickness"]),
        (vec!["--set", "screen-dda.strid=1"], vec!["'stride'"]),
        (vec!["--set", "screendda.stride=1"], vec!["'screen-dda'"]),
        (vec!["--set", "bvh-cpu.build=quickly"], vec!["very_fast"]),
        (vec!["--set", "stride=1"], vec!["tracer.parameter=value"]),
        (vec!["--tracer", "bvh-cpu", "--set", "screen-dda.stride=1"], vec!["not in --tracer"]),
        (vec!["--nonsense"], vec!["--nonsense"]),
    ] {
        bench.fails(&run(&arguments), 2, &parts);
    }
    bench.fails(&["repot"], 2, &["report"]);
    bench.fails(&["list", "tracer"], 2, &["tracers"]);
    let picture = ["picture", "--scene", "room", "--tracer", "all", "--out", "p.png"];
    bench.fails(&picture, 2, &["one tracer"]);
    bench.fails(
        &["picture", "--scene", "room", "--tracer", "bvh-cpu", "--what", "shadd", "--out", "p.png"],
        2,
        &["shaded"],
    );
    assert!(names(bench.folder.path()).is_empty(), "{:?}", names(bench.folder.path()));
}

/// Proves that a viewpoint which the scene does not have is an argument's fault, with those that it has.
#[test]
fn unknown_viewpoints() {
    let bench = Bench::new();
    let out = bench.text("out");
    let arguments = [&SMOKE[..], &["--tracer", "bvh-cpu", "--view", "atic", "--out", &out]].concat();
    let known = bench.call(&["list", "scenes", "--json"]);
    let known: Value = serde_json::from_str(&known.stdout).unwrap();
    let first = known[0]["viewpoints"][0].as_str().unwrap().to_owned();
    bench.fails(&arguments, 2, &["atic", "room", &first]);
    assert!(names(&bench.path("out")).is_empty());
}

/// Proves that scenes which are missing, cut off, no glTF, empty or not finite end with status 1, are named, and leave
/// no results behind.
#[test]
fn bad_scenes() {
    let bench = Bench::new();
    let good = glb(&TRIANGLE);
    let mut not_finite = TRIANGLE;
    not_finite[1][2] = f32::NAN;
    let with_buffer = gltf(3, 36, Some("gone.bin")).to_string().into_bytes();
    let mut extended = gltf(3, 36, Some("gone.bin"));
    extended["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    extended["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    let mut empty = gltf(3, 36, Some("gone.bin"));
    empty["nodes"] = json!([{}]);
    for (name, bytes, part) in [
        ("cut.glb", &good[..good.len() - 20], ""),
        ("head.glb", &good[..8], ""),
        ("nothing.glb", &[][..], ""),
        ("noise.glb", b"this is no model at all, not even JSON", ""),
        ("noise.gltf", b"{\"asset\": ", ""),
        ("array.gltf", b"[]", ""),
        ("buffer.gltf", &with_buffer, "gone.bin"),
        ("draco.gltf", extended.to_string().as_bytes(), "KHR_draco_mesh_compression"),
        ("empty.gltf", empty.to_string().as_bytes(), "no triangles"),
        ("nan.glb", &glb(&not_finite), "not finite"),
        ("flat.glb", &glb(&[[0.0; 3]; 3]), "zero area"),
        ("absent.glb", b"-", "absent.glb"),
        ("sub/absent.gltf", b"-", "absent.gltf"),
    ] {
        if bytes != b"-" {
            std::fs::write(bench.path(name), bytes).unwrap();
        }
        let out = bench.text("out");
        let arguments = [&SMOKE[..], &["--tracer", "bvh-cpu", "--scene", name, "--out", &out]].concat();
        bench.fails(&arguments, 1, &[part]);
        assert!(names(&bench.path("out")).is_empty(), "{name}: {:?}", names(&bench.path("out")));
        let picture = ["picture", "--scene", name, "--tracer", "bvh-cpu", "--size", "8x8", "--out", "p.png"];
        bench.fails(&picture, 1, &[part]);
        assert!(!bench.path("p.png").exists());
    }
    // A bad scene after a good one spoils the run, and leaves nothing of the good one either.
    std::fs::write(bench.path("good.glb"), &good).unwrap();
    let out = bench.text("out");
    let arguments = [&SMOKE[..], &["--tracer", "bvh-cpu", "--scene", "good.glb,cut.glb", "--out", &out]].concat();
    bench.fails(&arguments, 1, &["cut.glb"]);
    assert!(names(&bench.path("out")).is_empty());
}

/// Proves that a place that cannot be written to is said before the work is done, with status 1.
#[test]
fn outputs_that_cannot_be_written() {
    let bench = Bench::new();
    std::fs::write(bench.path("file"), b"in the way").unwrap();
    for out in ["file", "file/below"] {
        let arguments = [&SMOKE[..], &["--tracer", "bvh-cpu", "--out", out]].concat();
        bench.fails(&arguments, 1, &["file", "--out"]);
    }
    let picture = ["picture", "--scene", "room", "--tracer", "bvh-cpu", "--size", "8x8", "--out", "no/such/p.png"];
    bench.fails(&picture, 1, &["no/such/p.png"]);
    assert_eq!(std::fs::read(bench.path("file")).unwrap(), b"in the way");
    for (name, text, part) in [
        ("cut.json", "{\"schema\": 1, \"mach", "JSON"),
        ("other.json", "{\"schema\": 99}", "99"),
        ("none.json", "{}", "schema"),
        ("fields.json", "{\"schema\": 1}", "machine"),
    ] {
        std::fs::write(bench.path(name), text).unwrap();
        bench.fails(&["report", name], 1, &[name, part]);
    }
    bench.fails(&["report", "nowhere"], 1, &["nowhere"]);
    assert!(!bench.path("summary.md").exists());
}

/// Proves that an adapter which does not exist is an error with those that do.
#[test]
fn unknown_adapters() {
    let bench = Bench::new();
    let out = bench.text("out");
    let arguments = [&SMOKE[..], &["--adapter", "Voodoo 2", "--out", &out]].concat();
    bench.fails(&arguments, 1, &["Voodoo 2", "there are"]);
    assert!(names(&bench.path("out")).is_empty());
}

/// Proves a machine without an adapter: with `all`, device tracers are skipped with the reason; named, they are an
/// error; host tracers run; lists and `adapters` work.
#[test]
fn without_an_adapter() {
    let bench = Bench::new();
    let run = |tracer: &str, out: &str| {
        let out = bench.text(out);
        bench.call_without_adapter(&[&SMOKE[..], &["--rays", "primary", "--tracer", tracer, "--out", &out]].concat())
    };
    let all = run("all", "all");
    assert_eq!(all.status, 0, "{all:?}");
    let result = bench.result("all");
    assert_eq!(result["runs"].as_array().unwrap().len(), 1);
    assert_eq!(result["runs"][0]["tracer"]["name"], "bvh-cpu");
    assert_eq!(result["skipped"].as_array().unwrap().len(), 1);
    assert_eq!(result["skipped"][0]["tracer"], "screen-dda");
    assert!(result["skipped"][0]["reason"].as_str().unwrap().contains("adapter"));
    assert!(result["machine"]["adapter"].is_null());
    assert!(all.stderr.contains("skipped screen-dda"), "{all:?}");

    for tracer in ["screen-dda", "bvh-cpu,screen-dda", "all,screen-dda"] {
        let named = run(tracer, "named");
        assert_eq!((named.status, named.stdout.as_str()), (1, ""), "{named:?}");
        assert!(named.stderr.contains("adapter"), "{named:?}");
        assert!(names(&bench.path("named")).is_empty());
    }
    let host = run("bvh-cpu", "host");
    assert_eq!(host.status, 0, "{host:?}");
    assert!(bench.result("host")["skipped"].as_array().unwrap().is_empty());
    let list = bench.call_without_adapter(&["adapters", "--json"]);
    assert_eq!((list.status, list.stdout.trim()), (0, "[]"), "{list:?}");
    assert_eq!(bench.call_without_adapter(&["list", "tracers"]).status, 0);
}

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
        ("tracers", vec!["bvh-cpu", "screen-dda"]),
        ("scenes", vec!["room"]),
        ("rays", vec!["primary", "diffuse", "ao"]),
    ] {
        let found = json(&["list", kind, "--json"]);
        assert!(expected.iter().all(|name| found.iter().any(|found| found == name)), "{found:?}");
        let text = bench.call(&["list", kind]);
        assert_eq!(text.status, 0);
        assert!(found.iter().all(|name| text.stdout.contains(name)), "{text:?}");
    }
    assert!(!json(&["adapters", "--json"]).is_empty(), "there is no adapter; setup.sh installs one");
    for help in [vec!["--help"], vec!["--version"], vec!["run", "--help"]] {
        let outcome = bench.call(&help);
        assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""));
        assert!(outcome.stdout.contains("tracebench"));
    }
}

/// Every path to a value that scripts may rely on, from a run, a trace and a verdict.
const RUN_FIELDS: [&str; 27] = [
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
    "/build/setup_ms",
    "/traces/0/rays",
    "/traces/0/query",
    "/traces/0/count",
    "/traces/0/end",
    "/traces/0/clock",
    "/traces/0/samples_ms",
    "/traces/0/median_ms",
    "/traces/0/interval_ms/1",
    "/traces/0/judgement",
];
const TRACE_FIELDS: [&str; 5] = ["/mrays_per_s", "/per_trace_bytes", "/hits_sha256", "/counters", "/judgement/ties"];
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
    look(run, "", &["/schema", "/machine/cpu", "/commit", "/seed", "/preset", "/controls/0", "/runs/0", "/skipped"]);
    for list in ["controls", "runs"] {
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

/// Proves a whole smoke run: every file is there and none but those, run.json has every promised field, the controls
/// score what they must, the host tracer is right; and quiet means that stderr is empty.
#[test]
fn a_smoke_run() {
    let bench = Bench::new();
    let out = bench.text("out");
    let outcome = bench.call(&[&SMOKE[..], &["--quiet", "--tracer", "all", "--rays", "all", "--out", &out]].concat());
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    assert!(outcome.stdout.contains("bvh-cpu") && outcome.stdout.contains("summary.md"), "{outcome:?}");
    let files = names(&bench.path("out"));
    for file in ["run.json", "summary.md", "traces.csv", "wrong_rays.csv"] {
        assert!(files.contains(file), "{files:?}");
    }
    for end in [".svg", ".png"] {
        assert!(files.iter().filter(|file| file.ends_with(end)).count() >= 2, "{files:?}");
    }
    let known = [".json", ".md", ".csv", ".svg", ".png"];
    assert!(
        files.iter().all(|file| known.iter().any(|end| file.ends_with(end)) && !file.starts_with('.')),
        "{files:?}"
    );
    let run = bench.result("out");
    assert_eq!(missing(&run), Vec::<String>::new());
    assert_eq!(
        (run["schema"].as_u64(), run["preset"].as_str(), run["seed"].as_u64()),
        (Some(1), Some("smoke"), Some(1))
    );
    assert!(run["dirty"].is_boolean() || run["dirty"].is_null());
    let by_name = |list: &str, name: &str| -> Value {
        let all = run[list].as_array().unwrap().iter();
        all.clone().find(|each| each["tracer"]["name"] == name).unwrap_or_else(|| panic!("no {name}")).clone()
    };
    for name in ["oracle", "always-miss", "always-hit"] {
        assert_eq!(by_name("controls", name)["traces"].as_array().unwrap().len(), 3);
    }
    let oracle = by_name("controls", "oracle");
    assert_eq!(oracle["traces"][0]["judgement"]["agreement"]["tight"], 1.0);
    for name in ["bvh-cpu", "screen-dda"] {
        let run = by_name("runs", name);
        assert_eq!(run["traces"][0]["count"], 128);
        assert_eq!(run["traces"][0]["samples_ms"].as_array().unwrap().len(), 3);
        assert_eq!(run["traces"][2]["query"], "any");
    }
    let judgement = &by_name("runs", "bvh-cpu")["traces"][0]["judgement"];
    assert!(judgement["agreement"]["tight"].as_f64().unwrap() >= 0.98, "{judgement}");
    assert!(judgement["identity"].is_number());
    // Negative control of the field check.
    let mut less = run;
    less["runs"][0]["traces"][0].as_object_mut().unwrap().remove("hits_sha256");
    less["runs"][1]["build"]["setup_ms"] = Value::Null;
    assert_eq!(missing(&less), ["runs/0/traces/0/hits_sha256", "runs/1/build/setup_ms"]);
}

fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    names(folder).into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap())).collect()
}

/// Proves that `report` makes every derived file again, byte for byte, from the folder, from the file, and from the file
/// in the folder one stands in.
#[test]
fn reports_are_reproducible() {
    let bench = Bench::new();
    bench.run(&["--tracer", "bvh-cpu", "--rays", "all"], "out");
    let folder = bench.path("out");
    let before = contents(&folder);
    assert!(before.len() >= 8);
    let remake = |arguments: &[&str], directory: &Path| {
        for name in names(&folder).into_iter().filter(|name| name != "run.json") {
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
    run["runs"][0]["traces"][0]["mrays_per_s"] = json!(1234.5);
    std::fs::write(folder.join("run.json"), serde_json::to_vec_pretty(&run).unwrap()).unwrap();
    assert_eq!(bench.call(&["report", &out]).status, 0);
    assert_ne!(contents(&folder), before);
}

/// What of a run must not change from one run to the next: hashes, counters, verdicts.
fn verdicts(run: &Value) -> Vec<Value> {
    let lists = ["controls", "runs"].into_iter().flat_map(|list| run[list].as_array().unwrap().iter());
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
    let first = verdicts(&bench.run(&["--rays", "all"], "first"));
    assert!(first.len() >= 12);
    assert_eq!(verdicts(&bench.run(&["--rays", "all"], "second")), first);
    let out = bench.text("third");
    let mut command = bench.command(&[&SMOKE[..], &["--out", &out]].concat());
    assert_eq!(Bench::finish(command.env("TRACEBENCH_CACHE", "")).status, 0);
    assert_eq!(verdicts(&bench.result("third")), first);
    assert_ne!(verdicts(&bench.run(&["--seed", "2"], "fourth")), first);
}

/// Proves that a set without rays is skipped with its reason and the run goes well: a camera that looks away from the
/// scene has primary rays, which all miss, and no others.
#[test]
fn empty_ray_sets_are_skipped() {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), glb(&TRIANGLE)).unwrap();
    let away = ["--scene", "one.glb", "--tracer", "all", "--view", "0,0,5:0,0,9"];
    let run = bench.run(&[&away[..], &["--rays", "all"]].concat(), "all");
    let skipped = run["skipped"].as_array().unwrap();
    let sets: Vec<&str> = skipped.iter().map(|each| each["rays"].as_str().unwrap()).collect();
    assert_eq!(sets, ["diffuse", "ao"]);
    assert!(skipped.iter().all(|each| each["reason"].as_str().unwrap().contains("empty")));
    assert_eq!(run["runs"][0]["traces"].as_array().unwrap().len(), 1);
    assert_eq!(run["runs"][0]["traces"][0]["judgement"]["classes"]["tight"]["true_miss"], 128);
    let run = bench.run(&[&away[..], &["--rays", "ao"]].concat(), "none");
    assert!(run["runs"][0]["traces"].as_array().unwrap().is_empty());
    assert_eq!(run["skipped"].as_array().unwrap().len(), 1);
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
        "--frame",
        "40x30",
        "--face",
        "9",
        "--samples",
        "2",
        "--seed",
        "5",
    ];
    let run = bench.run(&arguments, "out");
    let tracer = |index: usize| &run["runs"][index]["tracer"];
    assert_eq!((&tracer(0)["preset"], &tracer(0)["parameters"]["build"]), (&json!("improved"), &json!("slow")));
    assert_eq!((&tracer(1)["preset"], &tracer(1)["parameters"]["stride"]), (&json!("published"), &json!(7)));
    assert_eq!(tracer(1)["changed"], json!(["stride"]));
    assert_eq!(run["runs"][1]["viewpoint"]["frame"], json!([40, 30]));
    assert_eq!((&run["runs"][1]["viewpoint"]["face"], &run["seed"]), (&json!(9), &json!(5)));
    assert_eq!(run["runs"][0]["build"]["samples_ms"].as_array().unwrap().len(), 2);
}

/// Proves that a picture of each kind is a PNG of the size asked for, that it shows something, and that nothing else is
/// left in its folder.
#[test]
fn pictures() {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), glb(&TRIANGLE)).unwrap();
    std::fs::create_dir(bench.path("pictures")).unwrap();
    for tracer in ["bvh-cpu", "screen-dda"] {
        for what in ["shaded", "depth", "error"] {
            let name = format!("pictures/{tracer}-{what}.png");
            let outcome = bench.call(&[
                "picture", "--quiet", "--scene", "one.glb", "--tracer", tracer, "--what", what, "--size", "37x21",
                "--out", &name,
            ]);
            assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
            let file = std::io::BufReader::new(std::fs::File::open(bench.path(&name)).unwrap());
            let mut reader = png::Decoder::new(file).read_info().unwrap();
            assert_eq!((reader.info().width, reader.info().height), (37, 21));
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            let colours: BTreeSet<&[u8]> = pixels.chunks(3).collect();
            assert!(colours.len() >= 2, "{name} is all one colour");
        }
    }
    assert_eq!(names(&bench.path("pictures")).len(), 6);
}
