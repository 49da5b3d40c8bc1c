//! Runs that are broken off and gone on with, runs that are spread and joined, and runs that wait for one another.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use super::*;

/// A sweep over two scenes with two ray sets: twelve interleaved sets or so, of points that share structures and points that do not.
const SWEEP: [&str; 19] = [
    "sweep",
    "--quiet",
    "--preset",
    "smoke",
    "--size",
    "16x8",
    "--face-size",
    "32",
    "--samples",
    "1",
    "--scene",
    "room,candy",
    "--tracer",
    "screen-dda",
    "--over",
    "layers=1,2",
    "--over",
    "stride=1,4",
    "--rays",
];

fn sweep<'a>(adaptive: &[&'a str]) -> Vec<&'a str> {
    [&SWEEP[..], &["diffuse,ao"], adaptive].concat()
}

/// What does not depend on time, by key: hits' hashes, counters, bytes, judgements.
fn content(run: &Value) -> BTreeMap<String, String> {
    let row = |row: &Value| {
        let trace = |trace: &Value| {
            ["rays", "rays_sha256", "hits_sha256", "counters", "per_trace_bytes", "statuses", "judgement"]
                .map(|name| trace[name].clone())
        };
        let traces: Vec<_> = row["traces"].as_array().unwrap().iter().map(trace).collect();
        let used: Vec<_> =
            row["memory"]["structure"].as_array().unwrap().iter().map(|part| &part["used_bytes"]).collect();
        let key = format!("{} {} {}", row["scene"]["name"], row["viewpoint"]["name"], row["tracer"]);
        (key, format!("{traces:?} {used:?} {:?}", row["structure_statistics"]))
    };
    let rows = ["rows", "controls"].into_iter().flat_map(|list| run[list].as_array().unwrap());
    rows.map(row).collect()
}

/// The interleaved sets that have ended in a folder, with their contents.
pub(super) fn interleaved_sets(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let is_race = |name: &String| ["-rays-", "-builds", "-frames-"].iter().any(|part| name.contains(part));
    let folder = folder.join("interleaved_sets");
    names(&folder)
        .into_iter()
        .filter(is_race)
        .map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap()))
        .collect()
}

/// Proves that a sweep which is killed at five points of time and gone on with has the keys, answers, counts and bytes of one
/// that ran through, that finished interleaved sets stay as they were, and that the record says when it was gone on with.
#[test]
fn what_has_ended_survives_being_killed() {
    let bench = Bench::new();
    assert_eq!(bench.call(&sweep(&["--out", "through"])).status, 0);
    let through = content(&bench.result("through"));
    let out = bench.path("out");
    let mut kills = 0;
    let mut adaptive: &[&str] = &["--out", "out"];
    for wanted in 1..=4 {
        let before = interleaved_sets(&out);
        let mut child = bench.command(&sweep(adaptive)).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // Killed (SIGKILL) as soon as another interleaved set has ended.
        while interleaved_sets(&out).len() <= before.len() && child.try_wait().unwrap().is_none() {
            sleep(Duration::from_millis(2));
        }
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was killed for the {wanted}th time");
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        let after = interleaved_sets(&out);
        for (name, contents) in &before {
            assert!(after.get(name) == Some(contents), "{name} is another one");
        }
        adaptive = &["--out", "out", "--resume"];
    }
    // A file that was changed since is named, and stays; without it its interleaved set runs again.
    let kept: Vec<String> = interleaved_sets(&out).into_keys().collect();
    let last = kept.last().unwrap();
    std::fs::write(out.join("interleaved_sets").join(last), "{\"lanes\":[").unwrap();
    let rays: Vec<&String> = kept.iter().filter(|name| name.contains("-rays-") && *name != last).collect();
    let [one, other, ..] = rays.as_slice() else { panic!("{kept:?}") };
    std::fs::copy(out.join("interleaved_sets").join(one), out.join("interleaved_sets").join(other)).unwrap();
    let changed = [last, *other].map(|name| format!("interleaved_sets/{name} (changed since it was written)"));
    bench.fails(&sweep(adaptive), 1, &[&changed[0], &changed[1]]);
    assert_eq!(interleaved_sets(&out)[last], b"{\"lanes\":[");
    [last, *other].iter().for_each(|name| std::fs::remove_file(out.join("interleaved_sets").join(name)).unwrap());
    let outcome = bench.call(&sweep(adaptive));
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    let found = bench.result("out");
    assert!(!out.join("interleaved_sets").exists(), "the journal stays behind");
    assert_eq!(found["resumed"].as_array().unwrap().len(), kills);
    assert_eq!(content(&found), through);
    // The comparison can fail.
    let mut other = found.clone();
    other["rows"][0]["traces"][0]["hits_sha256"] = json!("");
    assert_ne!(content(&other), through);
}

/// Proves that one command serves every time: where there is nothing it begins, what was broken off it goes on with, and what is complete
/// it leaves as it is and says so; that another plan is refused with what differs, complete or not, that a run which was broken off is not
/// overwritten, and that it is there to be gone on with after all of this.
#[test]
fn only_the_same_run_is_gone_on_with() {
    let bench = Bench::new();
    bench.fails(&sweep(&["--resume"]), 2, &["--out"]);
    let mut child = bench
        .command(&sweep(&["--out", "out", "--resume"]))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let out = bench.path("out");
    while interleaved_sets(&out).is_empty() && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    bench.fails(&sweep(&["--out", "out"]), 1, &["broken off", "--resume"]);
    bench.fails(&sweep(&["--out", "out", "--resume", "--seed", "7"]), 1, &["another plan", "seed was 1, is 7"]);
    let plan = out.join("interleaved_sets/plan.json");
    let text = std::fs::read_to_string(&plan).unwrap();
    let mut begun: Value = serde_json::from_str(&text).unwrap();
    for (field, value, part) in
        [("machine", json!("Another"), "another machine"), ("program_sha256", json!("00"), "another program")]
    {
        if field == "machine" {
            begun["machine"]["cpu"] = value;
        } else {
            begun[field] = value;
        }
        write_as_the_program(&out, "interleaved_sets/plan.json", &begun.to_string());
        bench.fails(&sweep(&["--out", "out", "--resume"]), 1, &[part]);
        begun = serde_json::from_str(&text).unwrap();
    }
    write_as_the_program(&out, "interleaved_sets/plan.json", "xx");
    bench.fails(&sweep(&["--out", "out", "--resume"]), 1, &["cannot be read", "plan.json", "remove"]);
    std::fs::write(&plan, &text).unwrap();
    bench.fails(
        &["sweep", "--choose", "footprint", "--quiet", "--preset", "smoke", "--out", "out", "--resume"],
        1,
        &["verb was \"sweep\", is \"sweep --choose\""],
    );
    // Another process is at it.
    let held = File::options().append(true).open(out.join("tracebench.sha256")).unwrap();
    held.lock().unwrap();
    bench.fails(&sweep(&["--out", "out", "--resume"]), 1, &["another process writes into out"]);
    drop(held);
    // What is left of interleaved sets without a plan, as where a process is killed that takes them away, is of use to nobody.
    std::fs::create_dir_all(bench.path("left/interleaved_sets")).unwrap();
    std::fs::copy(out.join("tracebench.sha256"), bench.path("left/tracebench.sha256")).unwrap();
    for (name, contents) in &interleaved_sets(&out) {
        std::fs::write(bench.path("left/interleaved_sets").join(name), contents).unwrap();
    }
    assert_eq!(bench.call(&sweep(&["--out", "left", "--seed", "7", "--resume"])).status, 0);
    assert!(!bench.path("left/interleaved_sets").exists());
    assert_eq!(bench.call(&sweep(&["--out", "seventh", "--seed", "7"])).status, 0);
    assert_eq!(content(&bench.result("left")), content(&bench.result("seventh")));
    assert_eq!(bench.call(&sweep(&["--out", "out", "--resume"])).status, 0);
    let whole = std::fs::read(out.join("run.json")).unwrap();
    let again = bench.call(&sweep(&["--out", "out", "--resume"]));
    assert_eq!(again.status, 0, "{again:?}");
    assert!(
        again.stderr.contains("the record in out is complete") && again.stdout.ends_with("out/sweep.md\n"),
        "{again:?}"
    );
    for other in [&["--seed", "7"][..], &["--shard", "1/1"]] {
        let words = [&["--out", "out", "--resume"], other].concat();
        bench.fails(&sweep(&words), 2, &["out holds a complete record of another plan", "leave --resume out"]);
    }
    assert!(std::fs::read(out.join("run.json")).unwrap() == whole && !out.join("interleaved_sets").exists());
    // Another file under the same name is another plan, too.
    let file = |top: f32| {
        std::fs::write(bench.path("one.glb"), glb(&[[-1.0, -1.0, -3.0], [1.0, -1.0, -3.0], [0.0, top, -3.0]])).unwrap();
    };
    let words = [
        "run",
        "--quiet",
        "--preset",
        "smoke",
        "--size",
        "16x8",
        "--samples",
        "1",
        "--scene",
        "one.glb",
        "--tracer",
        "bvh-cpu",
        "--out",
        "file",
    ];
    let resumed = [&words[..], &["--resume"]].concat();
    file(1.0);
    assert_eq!((bench.call(&words).status, bench.call(&resumed).status), (0, 0));
    file(0.9);
    bench.fails(&resumed, 2, &["file holds a complete record of another plan"]);
}

/// Proves that two shards, run in turn and joined, have the keys, answers, counts and bytes of the whole, that no scene is in
/// both, and that shards which do not belong together are refused.
#[test]
fn shards_are_joined() {
    let bench = Bench::new();
    assert_eq!(bench.call(&sweep(&["--out", "through"])).status, 0);
    for shard in ["1", "2"] {
        let of = format!("{shard}/2");
        let outcome = bench.call(&sweep(&["--out", shard, "--shard", &of]));
        assert_eq!(outcome.status, 0, "{outcome:?}");
    }
    let [one, two] = ["1", "2"].map(|shard| content(&bench.result(shard)));
    assert!(!one.is_empty() && !two.is_empty() && one.keys().all(|key| !two.contains_key(key)));
    let outcome = bench.call(&["merge", "1", "2", "--out", "whole"]);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let whole = bench.result("whole");
    assert_eq!(content(&whole), content(&bench.result("through")));
    assert!(whole["shard"].is_null() && bench.path("whole/sweep.md").exists());
    bench.fails(&["merge", "1", "--out", "half"], 1, &["shard 2 of 2 is missing"]);
    bench.fails(&["merge", "1", "2", "--out", "1"], 2, &["would be overwritten"]);
    bench.fails(&["merge", "1", "1", "2", "--out", "half"], 1, &["there twice"]);
    bench.fails(&["merge", "through", "--out", "half"], 1, &["no shard"]);
    bench.fails(&sweep(&["--shard", "3/2", "--out", "half"]), 2, &["--shard", "I/N"]);
    assert!(!bench.path("half").exists());
}

/// Proves that what takes times waits, and says so, while another process takes times, and that what takes none does not.
#[test]
fn one_timed_process_a_machine() {
    let bench = Bench::new();
    let lock = bench.path("lock");
    let held = File::create(&lock).unwrap();
    held.lock().unwrap();
    let with_lock = |arguments: &[&str]| {
        let mut command = bench.command(arguments);
        command.env("TRACEBENCH_LOCK", &lock);
        command
    };
    let untimed = ["stability", "--quiet", "--case", "edge-on", "--tracer", "bvh-cpu", "--out", "untimed"];
    let outcome = Bench::finish(&mut with_lock(&untimed));
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    let timed = [&SMOKE[..], &["--quiet", "--tracer", "bvh-cpu", "--rays", "primary", "--out", "timed"]].concat();
    let mut child = with_lock(&timed).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
    // It comes to its first word as late as the machine lets it.
    let first = said.next().unwrap().unwrap();
    sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "it did not wait: {first}");
    drop(held);
    let rest: Vec<String> = said.map(Result::unwrap).collect();
    let said = [vec![first], rest].concat().join("\n");
    let output = child.wait().unwrap();
    assert!(output.success() && said.contains("waiting: another tracebench takes times"), "{said}");
}

/// Proves that a run which is gone on with reads and launches its searches as it began, whatever the adapter is told to be by then, and
/// says so; that others are refused (the negative control); and that without any that are given a probe tells them, with its times.
#[test]
fn means_are_those_of_the_plan() {
    let bench = Bench::new();
    let run = |adaptive: &[&'static str]| -> Vec<&'static str> {
        let run = ["run", "--quiet", "--preset", "smoke", "--size", "16x8", "--samples", "1", "--scene", "room,candy"];
        [&run[..], &["--tracer", "ploc-gpu,bvh-cpu", "--rays", "diffuse,ao", "--out", "out"], adaptive].concat()
    };
    // No probe gives these.
    let mut begun = bench.command(&run(&["--launch", "texture,4"]));
    let mut child = begun.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let out = bench.path("out");
    while interleaved_sets(&out).is_empty() && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(2));
    }
    assert!(child.try_wait().unwrap().is_none(), "it ended before it was killed");
    child.kill().unwrap();
    child.wait().unwrap();
    bench.fails(&run(&["--resume", "--launch", "buffer,1"]), 1, &["another plan"]);
    let without = |arguments: &[&str]| {
        let mut command = bench.command(arguments);
        command.env_remove("TRACEBENCH_LAUNCH").stdout(Stdio::null()).status().unwrap().success()
    };
    assert!(without(&run(&["--resume"])));
    let found = bench.result("out");
    let launch_of = |row: &Value| {
        (row["tracer"]["parameters"]["memory_access"].clone(), row["tracer"]["parameters"]["rays_per_lane"].clone())
    };
    let rows = found["rows"].as_array().unwrap();
    for row in rows {
        let is_host = row["tracer"]["name"] == "bvh-cpu";
        assert_eq!(launch_of(row), if is_host { (Value::Null, Value::Null) } else { (json!("texture"), json!(4)) });
        assert_eq!(row["tracer"]["changed"], json!([]));
    }
    assert_eq!(found["launch"], json!({ "memory_access": "texture", "rays_per_lane": 4 }));

    let probed = ["run", "--quiet", "--preset", "smoke", "--size", "16x8", "--samples", "1", "--tracer", "ploc-gpu"];
    let probed = [&probed[..], &["--set", "ploc-gpu.rays_per_lane=7", "--rays", "diffuse", "--out", "probed"]].concat();
    assert!(without(&probed));
    let found = bench.result("probed");
    assert_eq!(found["launch"]["probe"]["gather_buffer_ms"].as_array().unwrap().len(), 15);
    // What is set stays.
    assert_eq!(launch_of(&found["rows"][0]), (found["launch"]["memory_access"].clone(), json!(7)));
}
