//! `sweep`.

use super::*;

const SMALL: [&str; 8] = ["sweep", "--quiet", "--preset", "smoke", "--size", "16x8", "--samples", "1"];

fn sweep(bench: &Bench, arguments: &[&str]) -> Outcome {
    bench.call(&[&SMALL, arguments].concat())
}

/// Proves that a sweep's points are what `run` measures with the same values: the same answers and counts, bit for bit;
/// that points are measured once however many axes they are on; and that `report` makes the same files.
#[test]
fn points_are_those_of_runs() {
    let bench = Bench::new();
    let over = ["--over", "layers=1,2", "--over", "resolution=1/2,stride=4", "--rays", "diffuse,ao", "--out", "out"];
    let outcome = sweep(&bench, &[&["--tracer", "screen-dda"], &over[..]].concat());
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    assert!(outcome.page.contains("| 1 * |") && outcome.page.contains("| 1/2 | 64×32, 32 |"), "{}", outcome.page);
    assert!(outcome.page.contains("all score what they must"), "{}", outcome.page);
    let found = bench.result("out");
    let rows = found["rows"].as_array().unwrap();
    assert_eq!((rows.len(), found["sweep"]["points"].as_array().unwrap().len()), (4, 4));
    let named = "screen-dda,screen-dda@layers=2,screen-dda@stride=4";
    bench.run(&["--tracer", named, "--rays", "diffuse,ao"], "plain");
    bench
        .run(&["--tracer", "screen-dda", "--rays", "diffuse,ao", "--frame-size", "64x32", "--face-size", "32"], "half");
    let mut plain = bench.result("plain")["rows"].as_array().unwrap().clone();
    plain.extend(bench.result("half")["rows"].as_array().unwrap().clone());
    let key = |one: &Value| (one["tracer"]["parameters"].clone(), one["viewpoint"]["face"].clone());
    let answers = |one: &Value| {
        let trace = |trace: &Value| ["rays_sha256", "hits_sha256", "counters"].map(|name| trace[name].clone());
        one["traces"].as_array().unwrap().iter().map(trace).collect::<Vec<_>>()
    };
    for one in &plain {
        let point = rows.iter().find(|point| key(point) == key(one)).unwrap();
        assert!(answers(one).len() == 2 && answers(one) == answers(point), "{}", one["tracer"]);
    }
    // They are not all the same, so the comparison above could have failed.
    assert!(answers(&plain[0]) != answers(&plain[1]) && answers(&plain[0]) != answers(&plain[3]));
    let before = names(&bench.path("out"));
    for wanted in
        ["rows.csv", "sweep.md", "sweep_room_layers_diffuse.svg", "sweep_room_resolution_ao.png", "summary.md"]
    {
        assert!(before.contains(wanted), "{before:?}");
    }
    let read = |name: &String| std::fs::read(bench.path("out").join(name)).unwrap();
    let contents: Vec<_> = before.iter().map(read).collect();
    assert_eq!(bench.call(&["--quiet", "report", "out"]).status, 0);
    assert!(names(&bench.path("out")) == before && before.iter().map(read).collect::<Vec<_>>() == contents);
}

/// Proves that a point which the device cannot hold is skipped with the reason, and the others are measured.
#[test]
fn what_is_too_large_is_skipped() {
    let bench = Bench::new();
    let outcome = sweep(&bench, &["--tracer", "screen-dda", "--grid", "resolution=64,layers=4", "--out", "out"]);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let found = bench.result("out");
    let (rows, points) = (found["rows"].as_array().unwrap(), found["sweep"]["points"].as_array().unwrap());
    let skipped: Vec<_> = points.iter().filter(|point| point["skipped"]["room"].is_string()).collect();
    assert!(points.len() == 4 && rows.len() + skipped.len() == 4, "{found}");
    assert_eq!((&skipped[0]["values"]["resolution"], &skipped[0]["values"]["layers"]), (&json!("64"), &json!("4")));
    let reasons = found["skipped"].as_array().unwrap();
    assert_eq!(reasons.len(), skipped.len());
    assert!(reasons[0]["reason"].as_str().unwrap().starts_with("resolution=64 layers=4: "), "{reasons:?}");
    assert!(outcome.page.contains("skipped, see below"));
}

/// Proves that the host's tracer is swept without an adapter.
#[test]
fn host_tracers_need_no_adapter() {
    let bench = Bench::new();
    let arguments = ["--tracer", "bvh-cpu", "--over", "build=fastest", "--rays", "primary", "--out", "out"];
    let outcome = bench.call_without_adapter(&[&SMALL[..], &arguments].concat());
    assert_eq!(outcome.status, 0, "{outcome:?}");
    assert_eq!(bench.result("out")["rows"].as_array().unwrap().len(), 2);
    let outcome = bench.call_without_adapter(&[&SMALL[..], &["--out", "none"]].concat());
    assert_eq!((outcome.status, bench.path("none").exists()), (1, false), "{outcome:?}");
}

/// Proves that wrong arguments end with status 2 and say what is wrong, and touch no file.
#[test]
fn wrong_arguments() {
    let bench = Bench::new();
    for (arguments, parts) in [
        (vec!["--tracer", "dirrt"], vec!["'dirt'"]),
        (vec!["--tracer", "all"], vec!["one tracer"]),
        (vec!["--tracer", "dirt,bvh-cpu"], vec!["one tracer"]),
        (vec!["--over", "bucket"], vec!["parameter of dirt", "'buckets'"]),
        (vec!["--over", ""], vec!["empty"]),
        (vec!["--over", "buckets="], vec!["buckets= has no values"]),
        (vec!["--over", "buckets=0"], vec!["1 to 256"]),
        (vec!["--over", "buckets=99999999999999999999"], vec!["1 to 256"]),
        (vec!["--over", "buckets", "--over", "buckets=4"], vec!["twice"]),
        (vec!["--over", "resolution=1/3"], vec!["128x64", "--face-size"]),
        (vec!["--over", "resolution=-1"], vec!["1/N"]),
        (vec!["--over", "resolution=1/4", "--face-size", "2"], vec!["faces of 2"]),
        (vec!["--grid", "buckets"], vec!["takes two"]),
        (vec!["--grid", "buckets,clip,coverage"], vec!["takes two"]),
        (vec!["--grid", "buckets,clip", "--over", "views"], vec!["--over"]),
        (
            vec!["--grid", "buckets=1,2,3,4,5,6,7,8,9,10,11,12,max_steps=1,2,3,4,5,6,7,8,9,10,11"],
            vec!["128 are the most"],
        ),
        (vec!["--tracer", "screen-dda", "--over", "buckets"], vec!["parameter of screen-dda"]),
        (vec!["--set", "dirt.bucket=4"], vec!["'buckets'"]),
        (vec!["--rays", "difuse"], vec!["'diffuse'"]),
    ] {
        bench.fails(&[&SMALL[..], &arguments, &["--out", "out"]].concat(), 2, &parts);
    }
    assert!(names(bench.folder.path()).is_empty(), "{:?}", names(bench.folder.path()));
}
