//! Runs to surfaces.

use super::*;

/// Proves a whole run to surfaces of every tracer that surfaces come from differently: records say where traces ended, the
/// controls have the surfaces that they must have, true hits have right ones, memory is told by parts whose sum is told, and
/// the summary and the table have all of it; hits are those of a run to hits.
#[test]
fn a_run_to_surfaces() {
    let bench = Bench::new();
    let arguments = |end: &'static str| {
        [
            "--scene",
            "room",
            "--tracer",
            "bvh-cpu,bvh-gpu,dirt,screen-dda",
            "--rays",
            "primary,visibility",
            "--trace-to",
            end,
        ]
    };
    let run = bench.run(&arguments("surface"), "surface");
    let to_hits = bench.run(&arguments("hit"), "hit");
    assert_eq!(run["rows"].as_array().unwrap().len(), 4);
    for list in ["controls", "rows"] {
        for (each, of_hits) in run[list].as_array().unwrap().iter().zip(to_hits[list].as_array().unwrap()) {
            let name = each["tracer"]["name"].as_str().unwrap();
            let traces = each["traces"].as_array().unwrap();
            assert_eq!(traces.len(), 2);
            for (trace, to_hits) in traces.iter().zip(of_hits["traces"].as_array().unwrap()) {
                assert_eq!((trace["trace_to"].as_str(), to_hits["trace_to"].as_str()), (Some("surface"), Some("hit")));
                assert_eq!(trace["hits_sha256"], to_hits["hits_sha256"], "{name}");
                assert!(to_hits["surfaces"].is_null() && !trace["surfaces"].is_null());
                let parts = trace["per_trace"].as_array().unwrap();
                let part = |name: &str| {
                    let bytes = parts.iter().find(|part| part["name"] == name).map(|part| &part["allocated_bytes"]);
                    bytes.and_then(Value::as_u64)
                };
                let sum: u64 = parts.iter().map(|part| part["allocated_bytes"].as_u64().unwrap()).sum();
                assert_eq!(trace["per_trace_bytes"], sum);
                assert!(to_hits["per_trace_bytes"].as_u64().unwrap() < sum);
                let rays = trace["count"].as_u64().unwrap();
                assert_eq!([part("rays"), part("hits"), part("shading buffer")], [32, 20, 32].map(|x| Some(x * rays)));
                assert_eq!(part("hit buffer: nodes"), (name == "dirt").then_some(32 * rays));
                let surfaces = &trace["surfaces"];
                let share = |field: &str| surfaces[field].as_f64();
                match name {
                    "always-miss" => assert_eq!((&surfaces["lost"], share("agreement")), (&0.into(), None)),
                    "always-hit" => assert!(surfaces["lost"].as_u64().unwrap() > 20),
                    "corrupted" => assert_eq!(share("agreement"), Some(1.0)),
                    // Hits within a pixel of the true one may be on its neighbour.
                    "dirt" | "screen-dda" => {
                        let least = if name == "dirt" { 0.95 } else { 0.1 };
                        assert!(share("agreement").is_some_and(|share| share >= least), "{name}: {surfaces}");
                    }
                    _ => {
                        assert_eq!(share("agreement"), Some(1.0), "{name}: {surfaces}");
                        assert_eq!((share("material"), share("normal")), (Some(1.0), Some(1.0)), "{name}");
                        assert!(surfaces["judged"].as_u64().unwrap() > 20, "{name}");
                        assert!(surfaces["normal_error_degrees"]["p99"].as_f64().unwrap() < 0.1, "{name}");
                    }
                }
            }
            let geometry = |run: &Value| run["memory"]["geometry_bytes"].as_u64().unwrap();
            assert!(list == "controls" || geometry(each) > geometry(of_hits), "{name}");
        }
    }
    let text = |file: &str| std::fs::read_to_string(bench.path(file)).unwrap();
    let summary = text("surface/summary.md");
    for part in ["traced to surfaces", "Surfaces of the hits", "final storage", "mask texture", "shading buffer"] {
        assert!(summary.contains(part), "{part}");
    }
    assert!(!text("hit/summary.md").contains("surfaces"));
    let table = text("surface/rows.csv");
    assert!(table.contains("surface_agreement_share") && table.contains(",surface,"));
    bench.fails(
        &["run", "--scene", "room", "--tracer", "dirt", "--rays", "primary", "--trace-to", "shade"],
        2,
        &["surface"],
    );
}
