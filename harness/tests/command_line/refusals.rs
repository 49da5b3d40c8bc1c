//! What is refused, and with which status.

use super::*;

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
        (vec!["--frame-size", "0x0"], vec!["--frame-size"]),
        (vec!["--frame-size", "100000x1"], vec!["--frame-size", "16384"]),
        (vec!["--face-size", "0"], vec!["--face-size"]),
        (vec!["--face-size", "1000000"], vec!["--face-size"]),
        (vec!["--scale", "0"], vec!["--scale", "0.001 to 64"]),
        (vec!["--scale", "NaN"], vec!["--scale"]),
        (vec!["--samples", "0"], vec!["--samples"]),
        (vec!["--samples", "-1"], vec![]),
        (vec!["--seed", "x"], vec!["--seed"]),
        (vec!["--animation-time", "NaN"], vec!["--animation-time"]),
        (vec!["--animation-time", "inf"], vec!["--animation-time"]),
        (vec!["--set", "screen-dda.stride=0"], vec!["stride", "1 to 256"]),
        (vec!["--set", "screen-dda.thickness=NaN"], vec!["thickness", "0 to 10"]),
        (vec!["--set", "screen-dda.thickness=-1"], vec!["thickness"]),
        (vec!["--set", "screen-dda.strid=1"], vec!["'stride'"]),
        (vec!["--set", "screendda.stride=1"], vec!["'screen-dda'"]),
        (vec!["--set", "bvh-cpu.build=quickly"], vec!["very_fast"]),
        (vec!["--set", "rays.order=spiral"], vec!["order", "scanline, tile, shuffled"]),
        (vec!["--set", "rays.lens_aperture=-1"], vec!["lens_aperture", "0 to 1"]),
        (vec!["--set", "rays.lens_count=0"], vec!["lens_count", "1 to 64"]),
        (vec!["--set", "screen-dda.layers=5"], vec!["layers", "1 to 4"]),
        (vec!["--set", "rays.lens_apperture=1"], vec!["'lens_aperture'"]),
        (vec!["--set", "stride=1"], vec!["tracer.parameter=value"]),
        (vec!["--tracer", "bvh-cpu", "--set", "screen-dda.stride=1"], vec!["not in --tracer"]),
        (vec!["--adapter", ""], vec!["--adapter"]),
        (vec!["--nonsense"], vec!["--nonsense"]),
    ] {
        bench.fails(&run(&arguments), 2, &parts);
    }
    bench.fails(&["repot"], 2, &["report"]);
    bench.fails(&["docs"], 2, &["cargo run --release --example figures"]);
    bench.fails(&["list", "tracer"], 2, &["tracers"]);
    bench.fails(&["picture"], 2, &["frames --frames 1"]);
    for (words, part) in [
        (&["--frames", "0"][..], "1..=240"),
        (&["--fps", "0"], "frames a second"),
        (&["--frames", "3", "--cut", "3"], "the last frame is 2"),
        (&["--effect", "shaded"], "no effect 'shaded'"),
        (&["--effect", "ao,ao"], "twice"),
        (&["--rays", "primary", "--fixed-rays"], "--move camera"),
        (&["--effect", "ao", "--rays", "primary"], "--rays"),
        (&["--samples", "12"], "a round is a frame"),
        (&["--move", "none"], "geometry"),
    ] {
        bench.fails(&[&["frames", "--scene", "room", "--tracer", "bvh-cpu"], words].concat(), 2, &[part]);
    }
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
    for pose in ["1,2,3", "1,2,3:1,2,3", "NaN,0,0:1,1,1"] {
        bench.fails(&[&SMOKE[..], &["--view", pose, "--out", &out]].concat(), 2, &["--view", pose, "a pose"]);
    }
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
        let frames = ["frames", "--scene", name, "--tracer", "bvh-cpu", "--size", "8x8", "--frames", "1", "--out", "p"];
        bench.fails(&frames, 1, &[part]);
        assert!(!bench.path("p").exists());
    }
    // A bad scene after a good one spoils the run, and leaves nothing of the good one either.
    std::fs::write(bench.path("good.glb"), &good).unwrap();
    let out = bench.text("out");
    let arguments = [&SMOKE[..], &["--tracer", "bvh-cpu", "--scene", "good.glb,cut.glb", "--out", &out]].concat();
    bench.fails(&arguments, 1, &["cut.glb"]);
    assert!(names(&bench.path("out")).is_empty());
    // Said before the good one is measured, and no folder made for the results is left.
    let arguments = [&SMOKE[..], &["--tracer", "bvh-cpu", "--scene", "good.glb,cut.glb", "--out", "a/b/c"]].concat();
    let outcome = bench.call(&arguments);
    assert!(outcome.status == 1 && !outcome.stderr.contains("primary"), "{outcome:?}");
    assert!(!bench.path("a").exists());
    let mut default = arguments[..arguments.len() - 2].to_vec();
    bench.fails(&default, 1, &["cut.glb"]);
    assert!(!bench.path("tracebench-out").exists());
    // Two runs in the same second keep apart.
    default[8] = "good.glb";
    for _ in 0..2 {
        assert_eq!(bench.call(&default).status, 0);
    }
    assert_eq!(names(&bench.path("tracebench-out")).len(), 2);
}

/// Proves that a place that cannot be written to is said before the work is done, with status 1.
#[test]
fn outputs_that_cannot_be_written() {
    let bench = Bench::new();
    std::fs::write(bench.path("file"), b"in the way").unwrap();
    for out in ["file", "file/below", "file/far/below"] {
        let arguments = [&SMOKE[..], &["--tracer", "bvh-cpu", "--out", out]].concat();
        bench.fails(&arguments, 1, &["file", "--out"]);
    }
    #[cfg(target_os = "linux")]
    bench.fails(&["run", "--scene", "/dev/zero", "--tracer", "bvh-cpu"], 1, &["/dev/zero", "no regular file"]);
    assert_eq!(std::fs::read(bench.path("file")).unwrap(), b"in the way");
    for (name, text, part) in [
        ("cut.json", "{\"schema\": 1, \"mach", "JSON"),
        ("other.json", "{\"schema\": 99}", "99"),
        ("none.json", "{}", "schema"),
        ("fields.json", "{\"schema\": 3}", "missing field"),
    ] {
        std::fs::write(bench.path(name), text).unwrap();
        bench.fails(&["report", name], 1, &[name, part]);
    }
    bench.fails(&["report", "nowhere"], 1, &["nowhere"]);
    assert!(!bench.path("summary.md").exists());
}

/// Proves that an adapter which does not exist is an error with those that do, whether the option or the environment
/// names it, and so is a backend that does not exist; empty variables are as good as none.
#[test]
fn unknown_adapters() {
    let bench = Bench::new();
    let out = bench.text("out");
    let arguments = [&SMOKE[..], &["--adapter", "Voodoo 2", "--out", &out]].concat();
    bench.fails(&arguments, 1, &["Voodoo 2", "there are"]);
    let run = [&SMOKE[..], &["--tracer", "screen-dda", "--rays", "primary", "--out", &out]].concat();
    for (variable, value, parts) in [
        ("WGPU_ADAPTER_NAME", "Voodoo 2", ["Voodoo 2", "there are"]),
        ("WGPU_BACKEND", "glide", ["WGPU_BACKEND=glide", "vulkan"]),
    ] {
        for verb in [&run[..], &["doctor"]] {
            let outcome = Bench::finish(bench.command(verb).env(variable, value));
            if variable == "WGPU_ADAPTER_NAME" && verb == ["doctor"] {
                let said = parts.iter().all(|part| outcome.stdout.contains(part));
                assert!(outcome.status == 0 && said, "{outcome:?}");
                continue;
            }
            assert_eq!((outcome.status, outcome.stdout.as_str()), (1, ""), "{outcome:?}");
            assert!(parts.iter().all(|part| outcome.stderr.contains(part)), "{outcome:?}");
        }
        assert!(!bench.path("out").exists());
        let host = [&SMOKE[..], &["--tracer", "bvh-cpu", "--rays", "primary", "--out", &out]].concat();
        let mut host = bench.command(&host);
        assert_eq!(Bench::finish(host.env(variable, value)).status, 0);
        std::fs::remove_dir_all(bench.path("out")).unwrap();
        assert_eq!(Bench::finish(bench.command(&run).env(variable, "")).status, 0);
        std::fs::remove_dir_all(bench.path("out")).unwrap();
    }
}

/// Proves that a reader who goes away ends the program quietly, and that a full disk is an error that says so.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_takes_nothing() {
    let bench = Bench::new();
    for verb in [&["list", "tracers", "--json"][..], &["list", "scenes"], &["doctor"], &["--help"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let closed = Bench::finish(bench.command(verb).stdout(writer));
        assert_eq!((closed.status, closed.stderr.as_str()), (0, ""), "{verb:?}");
    }
    for verb in [&["list", "rays"][..], &["list", "tracers", "--json"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let full = Bench::finish(bench.command(verb).stdout(full));
        assert_eq!(full.status, 1, "{verb:?}: {full:?}");
        assert!(full.stderr.contains("standard output"), "{full:?}");
    }
}

/// Proves a machine without an adapter: with `all`, device tracers are skipped with the reason; named, they are an
/// error; host tracers run; lists work, and `doctor` says what to do.
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
    assert_eq!(result["rows"].as_array().unwrap().len(), 1);
    assert_eq!(result["rows"][0]["tracer"]["name"], "bvh-cpu");
    let skipped = result["skipped"].as_array().unwrap();
    let names_of_skipped: Vec<&str> = skipped.iter().map(|each| each["tracer"].as_str().unwrap()).collect();
    let of_device = [
        "bvh-gpu",
        "ploc-gpu",
        "ray-query",
        "dirt",
        "fragment-abuffer",
        "voxel-abuffer",
        "voxel-octree",
        "quadtree",
        "screen-dda",
        "height-field",
        "mesh-warp",
        "hybrid",
        "hybrid first=quadtree:improved",
    ];
    assert_eq!(names_of_skipped, of_device);
    assert!(skipped.iter().all(|each| each["reason"].as_str().unwrap().contains("adapter")));
    assert!(result["machine"]["adapter"].is_null());
    assert!(all.stderr.contains("no graphics adapter was found"), "{all:?}");

    for tracer in ["screen-dda", "bvh-cpu,screen-dda", "all,screen-dda"] {
        let named = run(tracer, "named");
        assert_eq!((named.status, named.stdout.as_str()), (1, ""), "{named:?}");
        assert!(named.stderr.contains("adapter"), "{named:?}");
        assert!(names(&bench.path("named")).is_empty());
    }
    let host = run("bvh-cpu", "host");
    assert_eq!(host.status, 0, "{host:?}");
    assert!(bench.result("host")["skipped"].as_array().unwrap().is_empty());
    let doctor = bench.call_without_adapter(&["doctor", "--json"]);
    let said: Value = serde_json::from_str(&doctor.stdout).unwrap();
    assert_eq!((doctor.status, &said["adapters"], &said["chosen"]), (0, &json!([]), &Value::Null), "{doctor:?}");
    assert!(said["missing"][0]["do"].as_str().unwrap().contains("setup.sh"), "{doctor:?}");
    assert_eq!(bench.call_without_adapter(&["list", "tracers"]).status, 0);
}

/// Proves that a tracer which asks more of an adapter than it has is skipped with the reason: by `all` and nothing more, by name with an
/// error and status 1 beside the others' results, and alone without any; on an adapter that has it, it runs both ways.
#[test]
fn without_ray_queries() {
    let bench = Bench::new();
    let run = |tracer: &str, out: &str| {
        let out = bench.text(out);
        bench.call(&[&SMOKE[..], &["--rays", "primary", "--tracer", tracer, "--out", &out]].concat())
    };
    let (all, named) = (run("all", "all"), run("bvh-cpu,ray-query", "named"));
    assert_eq!(all.status, 0, "{all:?}");
    let result = bench.result("all");
    let skipped = result["skipped"].as_array().unwrap();
    if tracebench_tests::adapter_has_ray_queries(&tracebench_tests::gpu()) {
        assert!(skipped.is_empty() && named.status == 0, "{skipped:?} {named:?}");
        return;
    }
    assert_eq!((skipped.len(), skipped[0]["tracer"].as_str()), (1, Some("ray-query")));
    let reason = skipped[0]["reason"].as_str().unwrap();
    let adapter = result["machine"]["adapter"]["name"].as_str().unwrap();
    assert!(reason.contains(adapter) && reason.contains("EXPERIMENTAL_RAY_QUERY"), "{reason}");
    assert!(all.stderr.contains("skipped ray-query"), "{all:?}");
    let last = named.stderr.lines().last().unwrap();
    assert_eq!(named.status, 1, "{named:?}");
    assert!(last.contains("EXPERIMENTAL_RAY_QUERY") && last.contains("leave it out of --tracer"), "{named:?}");
    let record: Value = serde_json::from_slice(&std::fs::read(bench.path("named/run.json")).unwrap()).unwrap();
    let tracer = |part: &str, row: usize| record[part][row]["tracer"].clone();
    assert!(tracer("rows", 0)["name"] == "bvh-cpu" && tracer("skipped", 0) == "ray-query", "{record}");
    let alone = run("ray-query", "alone");
    assert_eq!((alone.status, alone.stdout.as_str()), (1, ""), "{alone:?}");
    assert!(alone.stderr.contains("ray-query") && alone.stderr.contains("EXPERIMENTAL_RAY_QUERY"), "{alone:?}");
    assert!(names(&bench.path("alone")).is_empty());
}

/// Proves that a tracer which refuses what it is asked for costs a run nothing but its own row: the others' are there, it is named
/// with its reason in the summary and on stderr, and the status is 1 where it was named. Where nothing is left there are no results.
#[test]
fn one_refusal_costs_one_row() {
    let bench = Bench::new();
    let refused = "voxel-abuffer abuffer=16384";
    let tracers = "bvh-cpu,voxel-abuffer@abuffer=16384,screen-dda";
    let run = |tracers: &str, out: &str| {
        bench.call(&[&SMOKE[..], &["--rays", "primary", "--tracer", tracers, "--out", &bench.text(out)]].concat())
    };
    let outcome = run(tracers, "some");
    assert_eq!(outcome.status, 1, "{outcome:?}");
    let last = outcome.stderr.lines().last().unwrap();
    assert!(last.starts_with("error: ") && last.contains(&format!("{refused} in room: ")), "{outcome:?}");
    assert!(last.contains("voxel-abuffer.abuffer"), "what to turn down: {last}");
    let record: Value = serde_json::from_slice(&std::fs::read(bench.path("some/run.json")).unwrap()).unwrap();
    let names_of: Vec<&str> =
        record["rows"].as_array().unwrap().iter().map(|row| row["tracer"]["name"].as_str().unwrap()).collect();
    assert_eq!(names_of, ["bvh-cpu", "screen-dda"]);
    let summary = std::fs::read_to_string(bench.path("some/summary.md")).unwrap();
    assert!(summary.contains(&format!("| {refused} | room | all | ")), "{summary}");
    assert!(!bench.path("some/races").exists() && outcome.stdout.contains("bvh-cpu"));
    let nothing = run("voxel-abuffer@abuffer=16384", "none");
    assert_eq!(nothing.status, 1);
    assert!(nothing.stderr.contains("no tracer could run") && nothing.stderr.contains(refused), "{nothing:?}");
    assert!(names(&bench.path("none")).is_empty());
}
