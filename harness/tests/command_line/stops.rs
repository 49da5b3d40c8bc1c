//! Work that is stopped from outside: what it leaves, what it says, and that it goes on from there.
#![cfg(unix)]

use std::fs::{File, TryLockError};
use std::io::{BufRead as _, BufReader};
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::resume::interleaved_sets;
use super::*;

/// As one that takes long would be begun.
fn begin(bench: &Bench, words: &[&str]) -> Child {
    bench.command(words).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits for what comes sooner or later.
fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(120), "{what}: not within two minutes");
        sleep(Duration::from_millis(2));
    }
}

fn send(signal: &str, to: &Child) {
    assert!(Command::new("kill").args([signal, &to.id().to_string()]).status().unwrap().success());
}

/// The number of the signal that ended it, and what it said.
fn ended(child: Child) -> (Option<i32>, String) {
    let output = child.wait_with_output().unwrap();
    (output.status.signal(), String::from_utf8(output.stderr).unwrap())
}

/// Whether a process measures into a folder.
fn is_busy(folder: &Path) -> bool {
    let file = File::options().append(true).open(folder.join("tracebench.sha256"));
    file.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}

fn told(bench: &Bench) -> Value {
    serde_json::from_slice(&std::fs::read(bench.path("all/reproduce.json")).unwrap()).unwrap()
}

/// Proves that a step ends when its reproduction is killed or stopped; that one which is stopped waits for it, writes its page and says how
/// to go on; and that a step goes on from its interleaved sets, is measured once, and is waited for where another process is at it.
#[test]
#[ignore = "wider set: a reproduction is killed, stopped and resumed, half a minute"]
fn a_step_ends_with_its_reproduction() {
    let bench = Bench::new();
    let front = bench.path("all/front");
    let words = ["--quiet", "reproduce", "--preset", "smoke", "--budget", "1h", "--out", "all"];
    let on = [&words[..], &["--resume"]].concat();
    let mut first = begin(&bench, &words);
    until("a race", || !interleaved_sets(&front).is_empty());
    first.kill().unwrap();
    first.wait().unwrap();
    let killed = Instant::now();
    until("the end of the step", || !is_busy(&front));
    assert!(killed.elapsed() < Duration::from_secs(10), "the step went on alone");
    assert!(!bench.path("all/reproduce.md").exists());

    let kept = interleaved_sets(&front);
    let second = begin(&bench, &on);
    until("another interleaved set", || interleaved_sets(&front).len() > kept.len());
    send("-TERM", &second);
    let (signal, said) = ended(second);
    assert_eq!((signal, said.as_str()), (Some(15), "stopped; what was measured is kept in all: go on with --resume\n"));
    assert!(!is_busy(&front), "it did not wait for the step");
    assert!(bench.path("all/reproduce.md").exists());
    assert_eq!(told(&bench)["steps"][0]["state"], "broken_off");
    let more = interleaved_sets(&front);
    assert!(
        kept.iter().all(|(name, contents)| more.get(name) == Some(contents)),
        "an interleaved set was measured twice"
    );

    // Of a step that has ended the record tells, whatever the list says; another process's is left to it.
    std::fs::remove_dir_all(front.join("interleaved_sets")).unwrap();
    let small = ["--scene", "room", "--tracer", "bvh-cpu", "--points", "1", "--rays", "diffuse", "--samples", "1"];
    let small =
        [&["--quiet", "pareto", "--preset", "smoke", "--size", "16x8", "--out", "all/front"][..], &small].concat();
    assert_eq!(bench.call(&small).status, 0);
    let record = std::fs::read(front.join("run.json")).unwrap();
    let mut list = told(&bench);
    list["steps"][0]["state"] = json!("left_out");
    write_as_the_program(&bench.path("all"), "reproduce.json", &list.to_string());
    let next = bench.path("all").join(list["steps"][1]["name"].as_str().unwrap());
    std::fs::create_dir_all(&next).unwrap();
    let held = File::create(next.join("tracebench.sha256")).unwrap();
    held.lock().unwrap();
    let outcome = bench.call(&["reproduce", "--preset", "smoke", "--budget", "3s", "--out", "all", "--resume"]);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    assert!(outcome.stderr.contains("waiting: another process measures into all/"), "{outcome:?}");
    assert_eq!(told(&bench)["steps"][0]["state"], "done");
    assert_eq!(told(&bench)["steps"][1]["state"], list["steps"][1]["state"]);
    assert_eq!(std::fs::read(front.join("run.json")).unwrap(), record, "it was measured anew");
}

/// Proves that a step which was stopped is gone on with to its end, and is measured once.
#[test]
#[ignore = "wider set: the first step takes half a minute"]
fn a_step_that_was_stopped_is_finished() {
    let bench = Bench::new();
    let front = bench.path("all/front");
    let words = ["--quiet", "reproduce", "--preset", "smoke", "--budget", "1h", "--out", "all"];
    let first = begin(&bench, &words);
    until("a race", || !interleaved_sets(&front).is_empty());
    send("-TERM", &first);
    assert_eq!(ended(first).0, Some(15));
    let second = begin(&bench, &[&words[..], &["--resume"]].concat());
    until("the end of the first step", || told(&bench)["steps"][0]["state"] == "done");
    send("-INT", &second);
    assert_eq!(ended(second).0, Some(2));
    assert_eq!(bench.result("all/front")["resumed"].as_array().unwrap().len(), 1);
    assert_eq!(told(&bench)["steps"][0]["state"], "done");
}

/// Proves that what is stopped says where its interleaved sets are kept and how to go on, that it does go on, and that before any
/// interleaved set has ended nothing is left and nothing is promised.
#[test]
fn what_is_stopped_says_how_to_go_on() {
    let bench = Bench::new();
    let scene = ["--quiet", "--preset", "smoke", "--size", "16x8", "--samples", "1", "--scene", "room", "--out"];
    for (verb, signal, number) in [("pareto", "-INT", 2), ("need", "-TERM", 15)] {
        let tracers: &[&str] = if verb == "pareto" {
            &["--points", "2", "--tracer", "screen-dda,bvh-cpu"]
        } else {
            &["--tracer", "screen-dda"]
        };
        let words = [&[verb], &scene[..], &[verb], tracers].concat();
        let child = begin(&bench, &words);
        until("a race", || !interleaved_sets(&bench.path(verb)).is_empty());
        send(signal, &child);
        let line = format!("stopped; what was measured is kept in {verb}: go on with --resume\n");
        assert_eq!(ended(child), (Some(number), line));
        let outcome = bench.call(&[&words[..], &["--resume"]].concat());
        assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
        assert_eq!(bench.result(verb)["resumed"].as_array().unwrap().len(), 1);
    }
    let lock = bench.path("lock");
    let held = File::create(&lock).unwrap();
    held.lock().unwrap();
    let words = [&["pareto"], &scene[..], &["early/one", "--tracer", "bvh-cpu"]].concat();
    let mut command = bench.command(&words);
    command.env("TRACEBENCH_LOCK", &lock);
    let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    until("the plan", || bench.path("early/one/interleaved_sets/plan.json").exists());
    send("-TERM", &child);
    let (signal, said) = ended(child);
    assert_eq!(signal, Some(15));
    assert!(said.contains("nothing is kept") && !said.contains("--resume"), "{said}");
    let waited = "stopped while it waited: another tracebench takes times on this machine";
    assert!(said.contains(waited), "{said}");
    assert!(!bench.path("early").exists());
    // It waits before there is a plan, too: for the probe of an adapter.
    let mut command = bench.command(&[&["run"], &scene[..], &["early/two", "--tracer", "ploc-gpu"]].concat());
    let command = command.env("TRACEBENCH_LOCK", &lock).env_remove("TRACEBENCH_LAUNCH");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
    let first = said.next().unwrap().unwrap();
    assert!(first.starts_with("waiting: "), "{first}");
    send("-INT", &child);
    let rest: Vec<String> = said.map(Result::unwrap).collect();
    assert!(rest[0].starts_with(waited), "{rest:?}");
    assert_eq!(child.wait().unwrap().signal(), Some(2));
    assert!(!bench.path("early").exists());
}
