//! `report --html`.

use super::*;

/// Proves that several records become one page that fetches nothing, which holds what each is and the command that makes it again; that
/// the command makes the same bytes; and that nothing else is written.
#[test]
fn several_records_are_one_page() {
    let bench = Bench::new();
    bench.run(&["--tracer", "bvh-cpu", "--rays", "primary,ao"], "a run");
    let points = ["pareto", "--preset", "smoke", "--size", "16x8", "--samples", "1", "--tracer", "bvh-cpu"];
    assert_eq!(
        bench.call(&[&points[..], &["--points", "2", "--rays", "diffuse", "--out", "fronts"]].concat()).status,
        0
    );
    for name in names(&bench.path("fronts")).into_iter().filter(|name| name != "run.json") {
        let path = bench.path("fronts").join(name);
        let removed = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
        removed.unwrap();
    }
    let make = ["report", "--quiet", "--html", "page.html", "a run", "fronts/run.json"];
    let outcome = bench.call(&make);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    let page = std::fs::read_to_string(bench.path("page.html")).unwrap();
    for wanted in [
        "of the answers must be right, take",
        "id=\"runs\"",
        "id=\"fronts\"",
        "page.html &#39;a run&#39; fronts/run.json",
    ] {
        assert!(page.contains(wanted), "no '{wanted}'");
    }
    assert!(!page.contains(" src=") && !page.contains("https:"));
    assert_eq!(names(&bench.path("fronts")).len(), 1);
    assert_eq!(bench.call(&make).status, 0);
    assert_eq!(std::fs::read_to_string(bench.path("page.html")).unwrap(), page);
}

/// Proves that a record that is not there, is empty, or is broken is an error that names it, and that no page is written; and
/// that one which is given twice is counted once, which the page says.
#[test]
fn records_that_are_none() {
    let bench = Bench::new();
    bench.run(&["--tracer", "bvh-cpu", "--rays", "primary"], "good");
    for (folder, text) in [("empty", ""), ("cut", "{\"schema\": 3, \"mach")] {
        std::fs::create_dir(bench.path(folder)).unwrap();
        if !text.is_empty() {
            std::fs::write(bench.path(folder).join("run.json"), text).unwrap();
        }
    }
    std::fs::create_dir(bench.path("claims")).unwrap();
    std::fs::write(bench.path("claims/claims_dirt.json"), "[]").unwrap();
    let page = |records: &[&'static str]| [&["report", "--html", "page.html"], records].concat();
    bench.fails(&page(&["good", "gone"]), 1, &["gone", "run.json"]);
    bench.fails(&page(&["good", "empty"]), 1, &["empty", "run.json"]);
    bench.fails(&page(&["cut", "good"]), 1, &["cut", "not a whole JSON"]);
    bench.fails(&page(&["claims"]), 2, &["claims alone"]);
    bench.fails(&["report", "--html", "page.html"], 2, &["RECORD"]);
    bench.fails(&["report", "--html", "no/such/page.html", "good"], 1, &["no/such"]);
    assert!(!bench.path("page.html").exists());
    assert_eq!(bench.call(&page(&["good", "claims"])).status, 0);
    let html = || std::fs::read_to_string(bench.path("page.html")).unwrap();
    assert!(!html().contains("<li>good: the same as good</li>"));
    assert_eq!(bench.call(&page(&["good", "good/run.json"])).status, 0);
    assert!(html().contains("<li>good: the same as good</li>"));
}
