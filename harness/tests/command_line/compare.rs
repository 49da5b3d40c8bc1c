//! `compare`.

use super::*;

impl Bench {
    /// A run whose times are made even, but for a scatter of 2 %, so that what is planted is all that moves.
    fn even_run(&self, out: &str) -> Value {
        let mut run =
            self.run(&["--tracer", "bvh-cpu,bvh-cpu@build=fastest", "--rays", "primary,ao", "--samples", "20"], out);
        for one in run["rows"].as_array_mut().unwrap() {
            set_times(&mut one["build"], 20.0);
            ["first", "steady"].into_iter().for_each(|whole| set_times(&mut one["build"][whole], 20.0));
            for trace in one["traces"].as_array_mut().unwrap() {
                set_times(trace, 5.0);
            }
        }
        // Its times are made up, so the machine's own drift is not theirs.
        for set in run["interleaved_sets"].as_array_mut().unwrap() {
            set["drift"] = json!(false);
        }
        self.write_run(&run, out);
        run
    }

    fn write_run(&self, run: &Value, out: &str) {
        std::fs::create_dir_all(self.path(out)).unwrap();
        std::fs::write(self.path(out).join("run.json"), run.to_string()).unwrap();
    }
}

fn set_times(times: &mut Value, median_ms: f64) {
    times["samples_ms"] = (0..20).map(|index| json!(median_ms * (0.98 + 0.002 * f64::from(index)))).collect();
    times["median_ms"] = json!(median_ms * 0.999);
    times["interval_ms"] = json!([median_ms * 0.99, median_ms * 1.01]);
    if let Some(count) = times["count"].as_f64() {
        times["mrays_per_s"] = json!(count / (median_ms * 0.999) / 1e3);
    }
}

/// Proves that a run is the same as itself, as text and as JSON, and that this is no regression.
#[test]
fn a_run_is_the_same_as_itself() {
    let bench = Bench::new();
    bench.run(&["--tracer", "bvh-cpu,bvh-gpu,screen-dda", "--rays", "primary,ao", "--samples", "5"], "out");
    let outcome = bench.call(&["compare", "out", "out/run.json", "--fail-on-regression", "--threshold", "0"]);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    assert!(
        outcome.stdout.contains("## Moved beyond noise\n\nNothing.") && !outcome.stdout.contains("differs"),
        "{outcome:?}"
    );
    let json: Value = serde_json::from_str(&bench.call(&["compare", "out", "out", "--json"]).stdout).unwrap();
    assert_eq!(json["schema"], 1);
    assert_eq!(json["traces"].as_array().unwrap().len(), 2 * json["builds"].as_array().unwrap().len());
    for row in json["traces"].as_array().unwrap() {
        let movement = row["speed"]["movement"].as_str();
        assert_eq!((row["same_hits"].as_bool(), movement), (Some(true), Some("undecided")), "{row}");
        // What takes less than twenty ticks of the clock has no times.
        let because = row["speed"]["undecided_because"].as_str().unwrap();
        assert!(because == "5 rounds, fewer than 12" || because.contains("below 20 ticks"), "{row}");
    }
    assert!(json["only_in_a"].as_array().unwrap().is_empty() && json["differences"].as_array().unwrap().is_empty());
    // With samples enough it can be told.
    bench.even_run("even");
    let json: Value = serde_json::from_str(&bench.call(&["compare", "even", "even", "--json"]).stdout).unwrap();
    for row in json["traces"].as_array().unwrap() {
        assert_eq!(row["speed"]["movement"], "within");
    }
}

/// Proves that two runs of the same work have every row in common and the same answers, whatever their times.
#[test]
fn two_runs_have_the_same_answers() {
    let bench = Bench::new();
    for out in ["first", "second"] {
        bench.run(&["--tracer", "bvh-cpu,bvh-gpu", "--rays", "diffuse"], out);
    }
    let json: Value = serde_json::from_str(&bench.call(&["compare", "first", "second", "--json"]).stdout).unwrap();
    let rows = json["traces"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert!(row["same_hits"] == true && row["counters"] == json!({}), "{row}");
        // Three samples say nothing of times.
        // On a busy machine timestamps of one run may not be believed: then there is nothing to say at all.
        let movement = &row["speed"]["movement"];
        assert!(*movement == "undecided" || row["speed"]["a_clock"] != row["speed"]["b_clock"], "{row}");
    }
}

/// Proves that a planted slowdown of 20 %, lost rays and changed bytes are said, with status 1 only where it is asked for and
/// only for what got worse.
#[test]
fn planted_changes_are_found() {
    let bench = Bench::new();
    let run = bench.even_run("a");
    let held = |change: &dyn Fn(&mut Value), arguments: &[&str]| {
        let mut changed = run.clone();
        change(&mut changed);
        bench.write_run(&changed, "b");
        bench.call(&[&["compare", "a", "b"][..], arguments].concat())
    };
    let slower = |run: &mut Value| set_times(&mut run["rows"][1]["traces"][0], 6.0);
    let outcome = held(&slower, &[]);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    assert!(outcome.stdout.contains("- room bvh-cpu build=fastest primary: **slower**, ratio 0.833 ["), "{outcome:?}");
    let outcome = held(&slower, &["--fail-on-regression"]);
    assert_eq!(outcome.status, 1, "{outcome:?}");
    assert!(outcome.stderr.contains("1 got worse: room bvh-cpu build=fastest primary: slower"), "{outcome:?}");
    assert_eq!(held(&slower, &["--fail-on-regression", "--threshold", "30"]).status, 0);
    let faster = |run: &mut Value| set_times(&mut run["rows"][0]["build"]["first"], 10.0);
    let outcome = held(&faster, &["--fail-on-regression"]);
    assert!(outcome.status == 0 && outcome.stdout.contains("bvh-cpu: build faster"), "{outcome:?}");
    let lost = |run: &mut Value| {
        let verdict = &mut run["rows"][0]["traces"][0]["judgement"];
        verdict["agreement"]["tight"] = json!(0.5);
        verdict["interval"]["tight"] = json!([0.45, 0.55]);
        let classes = &mut verdict["classes"]["tight"];
        let all = ["true_hit", "true_miss"].map(|name| classes[name].as_u64().unwrap()).iter().sum::<u64>();
        *classes = json!({ "true_hit": all / 2, "true_miss": 0, "false_hit": 0, "false_miss": 0, "early": all / 2, "late": 0 });
    };
    let outcome = held(&lost, &["--fail-on-regression"]);
    assert!(outcome.status == 1 && outcome.stderr.contains("less accurate by tight"), "{outcome:?}");
    let bytes = |run: &mut Value| {
        let memory = &mut run["rows"][0]["memory"];
        memory["structure"] = json!([{ "name": "nodes", "allocated_bytes": 12_345_678, "used_bytes": 1 }]);
        memory["structure_bytes"] = json!(12_345_678);
    };
    let outcome = held(&bytes, &["--fail-on-regression"]);
    assert!(outcome.status == 0 && outcome.stdout.contains("→ 12,345,678"), "{outcome:?}");
    let machine = |run: &mut Value| run["machine"]["cpu"] = json!("another one");
    assert!(held(&machine, &[]).stdout.contains("**differs**, processor: "));
    let scene = |run: &mut Value| {
        for one in run["rows"].as_array_mut().unwrap() {
            one["scene"]["sha256"] = json!("0".repeat(64));
        }
    };
    let outcome = held(&scene, &[]);
    assert!(outcome.status == 0 && outcome.stdout.contains("## Only in A") && outcome.stdout.contains("## Only in B"));
    let outcome = held(&scene, &["--fail-on-regression"]);
    assert!(outcome.status == 1 && outcome.stderr.contains("nothing stands in both runs"), "{outcome:?}");
}

/// Proves that what cannot be compared is refused: arguments with status 2, files with 1, each named.
#[test]
fn wrong_comparisons() {
    let bench = Bench::new();
    bench.run(&["--tracer", "bvh-cpu", "--rays", "primary"], "good");
    bench.fails(&["compare", "good"], 2, &["<B>"]);
    bench.fails(&["compare", "good", "good", "--threshold", "NaN"], 2, &["--threshold"]);
    bench.fails(&["compare", "good", "good", "--threshold", "-5"], 2, &["--threshold", "0 to 1000"]);
    bench.fails(&["compare", "good", "nowhere"], 1, &["nowhere", "run.json"]);
    bench.fails(&["compare", "nowhere/run.json", "good"], 1, &["nowhere"]);
    std::fs::write(bench.path("cut.json"), "{\"schema\": 3, ").unwrap();
    bench.fails(&["compare", "good", "cut.json"], 1, &["cut.json", "not a whole JSON"]);
    std::fs::write(bench.path("old.json"), "{\"schema\": 1}").unwrap();
    bench.fails(&["compare", "old.json", "good"], 1, &["old.json", "schema 1", "reads schema 3", "run again"]);
    std::fs::write(bench.path("other.json"), "{}").unwrap();
    bench.fails(&["compare", "good", "other.json"], 1, &["other.json", "no \"schema\""]);
    let mut earlier = bench.result("good");
    earlier["rules_version"] = json!(2);
    std::fs::write(bench.path("earlier.json"), earlier.to_string()).unwrap();
    bench.fails(
        &["compare", "good", "earlier.json"],
        1,
        &["good was measured by version 3", "earlier.json by version 2"],
    );
    // Times that cannot be, none at all, and a median that is not theirs.
    for (samples, median, part) in [
        (json!([]), 0.0, "no times"),
        (json!([1.0, 0.0]), 0.5, "no times"),
        (json!([2.0, -1.0]), 0.5, "`rows[0].traces[0].samples_ms[1]` is -1.0 and must be 0 or more"),
        (json!([2.0]), 3.0, "`rows[0].traces[0].median_ms` must be the median of `samples_ms`"),
    ] {
        let mut run = bench.result("good");
        let trace = &mut run["rows"][0]["traces"][0];
        (trace["samples_ms"], trace["phases"], trace["mrays_per_s"]) = (samples, json!([]), json!(0));
        (trace["median_ms"], trace["interval_ms"]) = (json!(median), json!([0.0, 3.0]));
        std::fs::write(bench.path("timeless.json"), run.to_string()).unwrap();
        bench.fails(&["compare", "good", "timeless.json"], 1, &["timeless.json", part]);
    }
}
