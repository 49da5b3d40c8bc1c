//! What the scripts in tests/ share that measure by the program.

use super::*;

/// Proves that a script keeps the records that its table is made of, packed, so that verbs read them, beside the table that OUT names; and
/// that it does not take records of before for its own, nor removes them.
#[cfg(unix)]
#[test]
fn scripts_keep_the_records_that_they_read() {
    let bench = Bench::new();
    bench.run(&["--tracer", "bvh-cpu", "--rays", "primary"], "run");
    // jq is asked for and not used here.
    std::fs::create_dir(bench.path("bin")).unwrap();
    std::os::unix::fs::symlink("/bin/true", bench.path("bin/jq")).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/study.sh");
    let text = format!(
        ". {script} none/none.csv; makes_records; keep run 01-room; echo a,b > \"$scratch/table.csv\"; finish \"$scratch/table.csv\""
    );
    let call = || {
        let path = format!("{}:{}", bench.text("bin"), std::env::var("PATH").unwrap());
        let mut command = Command::new("bash");
        command.args(["-c", &text, "script"]).current_dir(bench.folder.path()).env("PATH", path);
        Bench::finish(command.env("PROGRAM", "/bin/true").env("OUT", bench.path("made/table.csv")))
    };
    assert_eq!(call().status, 0);
    assert_eq!(std::fs::read_to_string(bench.path("made/table.csv")).unwrap(), "a,b\n");
    assert_eq!(bench.call(&["report", "made/table-records/01-room"]).status, 0);
    let again = call();
    assert!(again.status == 1 && again.stderr.contains("table-records is there: move it away"), "{again:?}");
    assert_eq!(names(&bench.path("made")), ["table-records", "table.csv"].map(str::to_owned).into());
}
