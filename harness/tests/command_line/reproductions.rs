//! `reproduce`: within its time, gone on with, and refused where that makes no sense.

use super::*;

/// What `reproduce` says of itself in a folder.
fn told(bench: &Bench, folder: &str) -> Value {
    serde_json::from_slice(&std::fs::read(bench.path(folder).join("reproduce.json")).unwrap()).unwrap()
}

fn states(told: &Value) -> Vec<String> {
    told["steps"].as_array().unwrap().iter().map(|step| step["state"].to_string()).collect()
}

/// Proves that a second is kept to: the first step is broken off, what there was no time for is left out and listed on the page that
/// the last line names; and that it goes on from there, where it says so alone.
#[test]
fn a_reproduction_keeps_its_time_and_goes_on() {
    let bench = Bench::new();
    let words = ["--quiet", "reproduce", "--preset", "smoke", "--budget", "1s", "--out", "all"];
    // Where nothing was begun it begins.
    let outcome = bench.call(&[&words[..], &["--resume"]].concat());
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let page = outcome.stdout.lines().last().unwrap();
    let text = std::fs::read_to_string(bench.path(page)).unwrap();
    assert!(
        text.contains("## Left out") && text.contains("`tracebench table dirt-table1 --few-rows --preset smoke`"),
        "{text}"
    );
    let first = told(&bench, "all");
    assert_eq!(states(&first)[0], "\"broken_off\"");
    assert!(states(&first)[1..].iter().all(|state| state == "\"left_out\""), "{first}");
    // Not over what is there.
    let again = bench.call(&words);
    assert_eq!(again.status, 1);
    assert!(again.stderr.contains("--resume"), "{again:?}");
    let on = bench.call(&[&words[..], &["--resume"]].concat());
    assert_eq!(on.status, 0, "{on:?}");
    let second = told(&bench, "all");
    assert_eq!(states(&second), states(&first));
    let took = |told: &Value| told["steps"][0]["took_s"].as_f64().unwrap();
    assert!(took(&second) > took(&first), "{first} {second}");
    // What is complete stays so.
    let mut all = second;
    all["steps"].as_array_mut().unwrap().iter_mut().for_each(|step| step["state"] = json!("done"));
    write_as_the_program(&bench.path("all"), "reproduce.json", &all.to_string());
    let complete = bench.call(&[&words[..], &["--resume"]].concat());
    assert_eq!(complete.status, 0, "{complete:?}");
    assert!(complete.stderr.contains("the reproduction in all is complete"), "{complete:?}");
    assert_eq!(told(&bench, "all"), all);
}

/// Proves that a time that is none, a folder without a name and a preset that is none are refused with what to do.
#[test]
fn what_cannot_be_reproduced_is_refused() {
    let bench = Bench::new();
    for (words, status, part) in [
        (&["--budget", "0s"][..], 2, "from one second on"),
        (&["--budget", "ten"], 2, "8m"),
        (&["--preset", "fast"], 2, "smoke"),
        (&["--resume"], 2, "--out"),
    ] {
        let outcome = bench.call(&[&["reproduce"][..], words].concat());
        assert_eq!(outcome.status, status, "{words:?}: {outcome:?}");
        assert!(outcome.stderr.contains(part), "{words:?}: {outcome:?}");
    }
    // A list that cannot be read, and what another verb measured.
    std::fs::create_dir(bench.path("broken")).unwrap();
    for text in ["{\"preset\":", "{\"preset\": null}"] {
        std::fs::write(bench.path("broken/reproduce.json"), text).unwrap();
        let words = ["reproduce", "--out", "broken", "--resume"];
        bench.fails(&words, 1, &["cannot read broken/reproduce.json", "remove it and leave --resume out"]);
    }
    bench.run(&["--tracer", "bvh-cpu", "--rays", "primary", "--samples", "1"], "run");
    let there = names(&bench.path("run"));
    bench.fails(&["reproduce", "--out", "run"], 2, &["run holds what `run` measured", "--out"]);
    assert_eq!(names(&bench.path("run")), there);
}
