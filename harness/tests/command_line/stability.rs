//! `stability` and `list cases`.

use super::*;

use tracebench_tests::{adapter_has_ray_queries, gpu};

const FEW: [&str; 5] = ["stability", "--quiet", "--case", "edge-on,needles", "--tracer"];

/// Proves that the matrix is printed, all files are written and agree with it, and that what is expected ends with 0.
#[test]
fn a_matrix_and_its_files() {
    let bench = Bench::new();
    let outcome = bench.call(&["stability", "--quiet", "--case", "edge-on", "--tracer", "all", "--out", "out"]);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    let expected = ["error_vs_difficulty.png", "error_vs_difficulty.svg", "report.html", "run.json", "stability.md"];
    assert_eq!(names(&bench.path("out")), expected.map(str::to_owned).into());
    assert!(
        outcome.stdout.starts_with(
            "All as expected.\n| case | bvh-cpu | bvh-gpu | ploc-gpu | ray-query | dirt | fragment-abuffer | voxel-abuffer | voxel-octree | quadtree | screen-dda | height-field | mesh-warp | hybrid |\n"
        ),
        "{}",
        outcome.stdout
    );
    let with_ray_queries = adapter_has_ray_queries(&gpu());
    let ray_query = if with_ray_queries { "exact" } else { "unavailable" };
    let row = format!("| edge-on | exact | exact | exact | {ray_query} | exact | known failure ");
    assert!(outcome.page.contains(&row), "{}", outcome.page);
    assert!(outcome.page.contains("| not served: its rays start in several points |"), "{}", outcome.page);
    assert_eq!(outcome.page.contains("Skipped ray-query: "), !with_ray_queries, "{}", outcome.page);
    let page = std::fs::read_to_string(bench.path("out/stability.md")).unwrap();
    assert!(page.contains(&row), "{page}");
    let found: Value = serde_json::from_slice(&std::fs::read(bench.path("out/run.json")).unwrap()).unwrap();
    assert_eq!(found["schema"], 3);
    assert!(found["machine"]["adapter"]["name"].is_string());
    let case = &found["cases"]["cases"][0];
    assert_eq!(
        (case["name"].as_str(), case["difficulty_parameter"]["unit"].as_str()),
        (Some("edge-on"), Some("degrees"))
    );
    assert!(case["difficulty_levels"][0]["rays"].as_u64().unwrap() >= 500);
    let cell = &case["tracers"][3];
    assert_eq!(
        (cell["tracer"]["name"].as_str(), cell["unavailable"].as_bool()),
        (Some("ray-query"), Some(!with_ray_queries))
    );
    let cell = case["tracers"].as_array().unwrap().iter().find(|cell| cell["tracer"]["name"] == "screen-dda").unwrap();
    for field in ["kind", "rule", "wrong_shares", "rasterizer_tolerance", "reason", "source"] {
        assert!(!cell["expectation"][field].is_null(), "{field}: {cell}");
    }
    assert_eq!(
        cell["expectation"]["wrong_shares"].as_array().map(Vec::len),
        case["difficulty_parameter"]["values"].as_array().map(Vec::len)
    );
    let rows: Vec<&Value> = found["rows"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| row["scene"]["name"] == "edge-on" && row["tracer"] == cell["tracer"])
        .collect();
    assert_eq!(rows.len(), case["difficulty_parameter"]["values"].as_array().unwrap().len());
    for (row, difficulty_level) in rows.iter().zip(case["difficulty_parameter"]["values"].as_array().unwrap()) {
        assert_eq!(row["difficulty_level"], *difficulty_level);
        // Nothing was timed.
        let trace = &row["traces"][0];
        assert_eq!((&trace["samples_ms"], &row["build"]["samples_ms"]), (&json!([]), &json!([])));
        let judgement = &trace["judgement"];
        let classes = judgement["classes"]["tight"].as_object().unwrap().values().map(|count| count.as_u64().unwrap());
        assert_eq!(classes.sum::<u64>(), trace["count"].as_u64().unwrap());
        for rule in ["hit_miss", "tight", "footprint"] {
            assert!(judgement["agreement"][rule].is_number(), "{judgement}");
        }
        assert!(judgement["causes"]["tight"].is_object());
    }
    let before = std::fs::read(bench.path("out/stability.md")).unwrap();
    std::fs::remove_file(bench.path("out/stability.md")).unwrap();
    assert_eq!(bench.call(&["--quiet", "report", "out"]).status, 0);
    assert!(std::fs::read(bench.path("out/stability.md")).unwrap() == before);
    // Held against itself nothing differs, and no times are missed where none were taken.
    let outcome = bench.call(&["compare", "--fail-on-regression", "out", "out"]);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    // Beside the default place too, as `run` does.
    let default = bench.call(&["stability", "--quiet", "--case", "edge-on", "--tracer", "bvh-cpu"]);
    assert_eq!(default.status, 0, "{default:?}");
    assert_eq!(names(&bench.path("tracebench-out")).len(), 1);
}

/// Proves that verdicts on changed parameters are shown but do not count, and that an improved preset that is the published one is judged
/// as that is.
#[test]
fn changed_parameters_do_not_count() {
    let bench = Bench::new();
    let changed = ["screen-dda", "--set", "screen-dda.max_steps=1", "--out", "out"];
    let arguments = ["stability", "--quiet", "--case", "through-view-centre", "--tracer"];
    let outcome = bench.call(&[&arguments[..], &changed].concat());
    assert_eq!(outcome.status, 0, "{outcome:?}");
    assert!(outcome.page.contains("do not count") && outcome.page.contains("UNEXPECTED"), "{outcome:?}");
    let improved = bench.call(&[&FEW[..], &["bvh-cpu:improved", "--out", "improved"]].concat());
    assert_eq!(improved.status, 0, "{improved:?}");
    assert!(improved.page.contains("| edge-on | exact |") && !improved.page.contains("UNEXPECTED"), "{improved:?}");
}

/// Proves that `--expect` makes a file of what records measured, by adapter, which it makes again of the same byte for byte; that it leaves
/// other lines as they are; and that it refuses what is no such file, what is no record of cases, and half of the arguments.
#[test]
fn expected_shares_are_made_of_records() {
    let bench = Bench::new();
    let run = bench.call(&[&FEW[..], &["bvh-cpu", "--out", "out"]].concat());
    assert_eq!(run.status, 0, "{run:?}");
    let made = bench.call(&["stability", "--expect", "expected.csv", "--from", "out"]);
    assert_eq!((made.status, made.stdout.as_str()), (0, "expected.csv\n"), "{made:?}");
    let text = std::fs::read_to_string(bench.path("expected.csv")).unwrap();
    let stated = include_str!("../../src/studies/stability/expected.csv");
    let line = stated.lines().find(|line| line.starts_with("bvh-cpu,needles,")).unwrap();
    assert_eq!(text, format!("tracer,case,software\n{line}\n"));
    let other = text.replace("bvh-cpu,needles,", "dirt,leaves,");
    std::fs::write(bench.path("expected.csv"), &other).unwrap();
    assert_eq!(bench.call(&["stability", "--expect", "expected.csv", "--from", "out/run.json"]).status, 0);
    let both = std::fs::read_to_string(bench.path("expected.csv")).unwrap();
    assert_eq!(both.lines().collect::<Vec<_>>(), ["tracer,case,software", line, other.lines().nth(1).unwrap()]);
    for mine in ["mine\n", "tracer,case\nmy,own\n"] {
        std::fs::write(bench.path("notes.txt"), mine).unwrap();
        bench.fails(&["stability", "--expect", "notes.txt", "--from", "out"], 1, &["notes.txt", "left as it is"]);
        assert_eq!(std::fs::read_to_string(bench.path("notes.txt")).unwrap(), mine);
    }
    bench.fails(&["stability", "--expect", "expected.csv", "--from", "none"], 1, &["none"]);
    bench.fails(&["stability", "--expect", "expected.csv"], 2, &["--from"]);
    bench.fails(&["stability", "--from", "out"], 2, &["--expect"]);
}

/// Proves that unknown names are refused with the nearest, before any file is touched.
#[test]
fn unknown_names() {
    let bench = Bench::new();
    for (arguments, parts) in [
        (vec!["--case", "edge-off"], vec!["edge-off", "'edge-on'"]),
        (vec!["--case", "wires,,leaves"], vec!["empty name"]),
        (vec!["--tracer", "bvh-cpo"], vec!["'bvh-cpu'"]),
        (vec!["--set", "screen-dda.strid=1"], vec!["'stride'"]),
        (vec!["--set", "rays.order=tile"], vec!["rays.order=tile", "own rays"]),
    ] {
        bench.fails(&[&["stability"][..], &arguments].concat(), 2, &parts);
    }
    bench.fails(&["stability", "--adapter", "Voodoo 2"], 1, &["Voodoo 2"]);
    assert!(names(bench.folder.path()).is_empty(), "{:?}", names(bench.folder.path()));
}

/// Proves that a tracer which the machine cannot run is skipped with the reason under `all`, and an error by name.
#[test]
fn cases_without_an_adapter() {
    let bench = Bench::new();
    let all = bench.call_without_adapter(&[&FEW[..], &["all", "--out", "all"]].concat());
    assert_eq!(all.status, 0, "{all:?}");
    assert!(all.page.contains("Skipped screen-dda") && all.page.contains("adapter"), "{all:?}");
    assert!(all.page.contains("| edge-on | exact | unavailable | unavailable | unavailable |"), "{all:?}");
    // Why it would fail where it runs is no reason for anything here, and it has no line in the chart.
    assert!(!all.page.contains("- screen-dda, "), "{all:?}");
    let chart = std::fs::read_to_string(bench.path("all/error_vs_difficulty.svg")).unwrap();
    assert!(chart.contains("bvh-cpu") && !chart.contains("screen-dda"));
    let named = bench.call_without_adapter(&[&FEW[..], &["screen-dda", "--out", "named"]].concat());
    assert_eq!((named.status, named.stdout.as_str()), (1, ""), "{named:?}");
    assert!(!bench.path("named").exists());
}

/// Proves that cases are listed for people and for scripts.
#[test]
fn cases_are_listed() {
    let bench = Bench::new();
    let outcome = bench.call(&["list", "cases", "--json"]);
    let value: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let text = bench.call(&["list", "cases"]).stdout;
    let cases = value.as_array().unwrap();
    assert!(cases.len() >= 20);
    for case in cases {
        assert!(
            text.contains(case["name"].as_str().unwrap()) && case["difficulty_parameter"]["values"].is_array(),
            "{case}"
        );
    }
}
