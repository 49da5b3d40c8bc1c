//! How times are taken, and `doctor --clock`.

use super::*;

/// Proves that a run tells of its interleaved sets: an order a round in which every lane stands once, no two rounds alike by rule, as many
/// samples of every row as counted rounds, a fixed kernel on every clock, double work on every clock, and what sampling went by.
#[test]
fn races_are_recorded() {
    let bench = Bench::new();
    let run = bench.run(&["--tracer", "bvh-cpu,screen-dda", "--rays", "primary,diffuse", "--samples", "13"], "out");
    let interleaved_sets = run["interleaved_sets"].as_array().unwrap();
    let works: Vec<&str> =
        interleaved_sets.iter().map(|interleaved_set| interleaved_set["work"].as_str().unwrap()).collect();
    assert_eq!(works, ["builds", "primary", "diffuse"]);
    for interleaved_set in interleaved_sets {
        let participants = interleaved_set["participants"].as_array().unwrap().len() as u64;
        let orders: Vec<Vec<u64>> = serde_json::from_value(interleaved_set["orders"].clone()).unwrap();
        assert_eq!(orders.len(), 13);
        for order in &orders {
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..participants).collect::<Vec<_>>());
        }
        assert!(orders.windows(2).any(|pair| pair[0] != pair[1]));
        let kernels = interleaved_set["kernels"].as_array().unwrap();
        assert_eq!(kernels.len(), 2);
        assert!(kernels.iter().all(|kernel| kernel["samples_ms"].as_array().unwrap().len() == 13));
        let doubled_work = interleaved_set["doubled_work"].as_array().unwrap().len();
        assert_eq!(doubled_work, if interleaved_set["work"] == "builds" { 0 } else { 2 });
        assert_eq!(
            (&interleaved_set["stop_reason"], &interleaved_set["sampling"]["min_rounds"]),
            (&json!("rounds"), &json!(13))
        );
        assert!(
            interleaved_set["widest_interval"].as_f64().is_some() && interleaved_set["order_seed"].as_u64().is_some()
        );
    }
    for row in run["rows"].as_array().unwrap() {
        assert_eq!((&row["build"]["interleaved_set"], &row["traces"][1]["interleaved_set"]), (&json!(0), &json!(2)));
        assert_eq!(row["traces"][0]["samples_ms"].as_array().unwrap().len(), 13);
        let by_host = row["traces"][0]["submit_to_done_samples_ms"].as_array();
        assert_eq!(by_host.map_or(0, Vec::len), if row["tracer"]["name"] == "bvh-cpu" { 0 } else { 13 });
    }
    // Other seeds draw other orders.
    let other = bench.run(&["--tracer", "bvh-cpu", "--rays", "primary", "--seed", "2"], "other");
    let same = bench.run(&["--tracer", "bvh-cpu", "--rays", "primary", "--seed", "2"], "same");
    assert_eq!(other["interleaved_sets"][1]["orders"], same["interleaved_sets"][1]["orders"]);
    assert_ne!(other["interleaved_sets"][0]["order_seed"], interleaved_sets[0]["order_seed"]);
    assert!(std::fs::read_to_string(bench.path("same/summary.md")).unwrap().contains("fewer than 12 decide nothing"));
}

/// Proves that sampling goes on until its time is up, and tells so.
#[test]
fn sampling_goes_on_until_the_time_is_up() {
    let bench = Bench::new();
    let limits = ["--ratio-precision", "0.1", "--time-limit", "0.2"];
    let run = bench.run(&[&["--tracer", "bvh-cpu,screen-dda", "--rays", "primary"][..], &limits].concat(), "out");
    for interleaved_set in run["interleaved_sets"].as_array().unwrap() {
        let ended = interleaved_set["stop_reason"].as_str().unwrap();
        assert!(["time_limit", "max_rounds"].contains(&ended), "{ended}");
        assert!(
            interleaved_set["orders"].as_array().unwrap().len() >= 12
                && interleaved_set["widest_interval"].as_f64().unwrap() > 0.001
        );
        assert_eq!(interleaved_set["sampling"]["adaptive"], json!({ "ratio_precision": 0.001, "time_limit_s": 0.2 }));
    }
    bench.fails(&["run", "--samples", "3", "--ratio-precision", "5"], 2, &["--ratio-precision"]);
    bench.fails(&["run", "--time-limit", "x"], 2, &["--time-limit", "seconds"]);
}

/// Proves that the clock is tried by interleaved sets of one tracer, that noise is recorded as it is replayed, that what repeating rays is
/// worth is told, and that what cannot be is refused.
#[test]
fn the_clock_is_tried() {
    let bench = Bench::new();
    let smoke = ["doctor", "--clock", "--tracer", "bvh-cpu", "--preset", "smoke"];
    let call = |adaptive: &[&str]| bench.call(&[&smoke[..], adaptive].concat());
    let outcome = call(&["--interleaved-sets", "2", "--samples", "12", "--load", "1", "--out", "interleaved_sets"]);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    for part in ["2 interleaved sets of 12 to 12 rounds, 1 threads", "equal: ", "slowed by 15.0 %: "] {
        assert!(outcome.stdout.contains(part), "{outcome:?}");
    }
    let record: Value =
        serde_json::from_slice(&std::fs::read(bench.path("interleaved_sets/clock.json")).unwrap()).unwrap();
    let found = &record["interleaved_sets"];
    assert_eq!(
        (&record["tracer"], &found["count"], &found["rounds"]),
        (&json!("bvh-cpu"), &json!(2), &json!([12, 12]))
    );
    for tally in ["equal", "slowed"] {
        let said = ["longer", "shorter", "same", "undecided"].map(|answer| found[tally][answer].as_u64().unwrap());
        assert_eq!(said.iter().sum::<u64>(), 2, "{record}");
    }
    let outcome = call(&["--record", "noise.csv", "--kind", "made", "--samples", "5"]);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let noise = std::fs::read_to_string(bench.path("noise.csv")).unwrap();
    assert_eq!(noise.lines().filter(|line| line.starts_with("made,") && line.split(',').count() == 6).count(), 5);
    let outcome = call(&["--rays", "diffuse", "--fresh-rays", "3", "--samples", "12", "--out", "fresh"]);
    assert!(outcome.status == 0 && outcome.stdout.contains("rays of 3 seeds in turn"), "{outcome:?}");
    let record: Value = serde_json::from_slice(&std::fs::read(bench.path("fresh/clock.json")).unwrap()).unwrap();
    assert!(
        record["fresh_rays"]["fresh_over_repeated"].as_f64().unwrap() > 0.0 && record["machine"].is_object(),
        "{record}"
    );
    bench.fails(&[&smoke[..], &["--fresh-rays", "3"]].concat(), 1, &["nothing random"]);
    bench.fails(&["doctor", "--clock", "--tracer", "all"], 2, &["one tracer"]);
    bench.fails(&["doctor", "--clock"], 2, &["--tracer"]);
    bench.fails(&["doctor", "--interleaved-sets", "2"], 2, &["--clock"]);
    bench.fails(&["doctor", "--scale", "0.5"], 2, &["--clock"]);
    bench.fails(&["doctor", "--clock", "--tracer", "bvh-cpu", "--json"], 2, &["--json"]);
    bench.fails(&[&smoke[..], &["--rays", "all"]].concat(), 2, &["one ray set"]);
    bench.fails(&[&smoke[..], &["--slowdown", "7"]].concat(), 2, &["multiple of 5"]);
    bench.fails(&[&smoke[..], &["--record", "noise.csv"]].concat(), 2, &["--kind"]);
}
