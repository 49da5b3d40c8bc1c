//! `docs`.

use super::*;

/// Proves that what differs from its record is told and fails, that `--write` mends it, and that it is told no more then; that a folder
/// without documents and a marker without a record end with 1 and say what to do.
#[test]
fn documents_are_held_against_records() {
    let bench = Bench::new();
    bench.fails(&["docs"], 1, &["README.md", "--root"]);
    std::fs::create_dir(bench.path("docs")).unwrap();
    std::fs::write(bench.path("run.json"), r#"{ "share": 0.25 }"#).unwrap();
    let page = |says: &str| format!("It is <!-- value: run.json#share as 0% -->{says}<!-- /value -->.\n");
    std::fs::write(bench.path("README.md"), page("24 %")).unwrap();
    let outcome = bench.call(&["docs"]);
    assert!(outcome.status == 1 && outcome.stdout.contains("README.md, line 1: '24 %' is '25 %'"), "{outcome:?}");
    assert!(outcome.stderr.contains("docs --write"), "{outcome:?}");
    assert_eq!(bench.call(&["docs", "--write"]).status, 0);
    assert_eq!(std::fs::read_to_string(bench.path("README.md")).unwrap(), page("25 %"));
    let outcome = bench.call(&["docs", "--check"]);
    assert_eq!((outcome.status, outcome.stdout.as_str(), outcome.stderr.as_str()), (0, "", ""));
    std::fs::write(bench.path("docs/a.md"), page("25 %").replace("run.json", "gone.json")).unwrap();
    bench.fails(&["docs"], 1, &["a.md, line 1", "gone.json"]);
}
