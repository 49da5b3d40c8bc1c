//! Records that nothing can have measured.

use super::*;

/// Proves that a record which no run can have come to is refused, wherever records are read, and one that is cut short with what to do.
#[test]
fn records_that_nothing_measured() {
    let bench = Bench::new();
    let run = bench.run(&["--tracer", "bvh-cpu", "--rays", "primary", "--samples", "1"], "out");
    let change = |path: &str, value: Value| {
        let mut run = run.clone();
        *run.pointer_mut(path).unwrap() = value;
        std::fs::write(bench.path("changed.json"), run.to_string()).unwrap();
    };
    change("/seed", json!(2));
    assert_eq!(bench.call(&["report", "changed.json"]).status, 0, "the change of nothing that matters");
    let agreement = "/rows/0/traces/0/judgement/agreement/footprint";
    for (path, value, part) in [
        ("/rows", json!([]), "no rows"),
        (agreement, json!(1.5), "`rows[0].traces[0].judgement.agreement.footprint` is 1.5 and must be a share"),
        (agreement, json!(-0.1), "is -0.1 and must be a share"),
        (agreement, json!(0.5), "`rows[0].traces[0].judgement.agreement.footprint` must be in its interval"),
        ("/rows/0/traces/0/judgement/interval/tight", json!([1.0, 0.0]), "must be in its interval"),
        ("/rows/0/traces/0/median_ms", json!(-3.0), "`rows[0].traces[0].median_ms` is -3.0 and must be 0 or more"),
        ("/rows/0/build/samples_ms/0", json!(-3.0), "`rows[0].build.samples_ms[0]` is -3.0"),
        ("/rows/0/traces/0/count", json!(-3), "`rows[0].traces[0].count` is -3"),
        ("/control_names", json!([]), "`control_names` is empty and must be filled"),
        ("/rows/0/build/steady/samples_ms/0", json!(-3.0), "`rows[0].build.steady.samples_ms[0]` is -3.0"),
    ] {
        change(path, value);
        for words in [&["report", "changed.json"][..], &["compare", "out", "changed.json"]] {
            bench.fails(words, 1, &["changed.json is no record of a run", part, "run again"]);
        }
    }
    let mut packer = liblzma::write::XzEncoder::new(Vec::new(), 0);
    std::io::Write::write_all(&mut packer, run.to_string().as_bytes()).unwrap();
    let packed = packer.finish().unwrap();
    std::fs::create_dir(bench.path("cut")).unwrap();
    std::fs::write(bench.path("cut/run.json.xz"), &packed[..packed.len() / 2]).unwrap();
    bench.fails(&["report", "cut"], 1, &["cannot unpack cut/run.json.xz", "run again"]);
}

/// Proves that half a MiB which would unpack to more than any record is refused, and how much is read is said.
#[test]
fn small_files_that_unpack_to_large_ones() {
    let bench = Bench::new();
    let part = vec![b' '; 64 << 20];
    let mut packer = liblzma::write::XzEncoder::new(Vec::new(), 0);
    std::io::Write::write_all(&mut packer, &part).unwrap();
    // Files that are joined unpack to what they do each, joined.
    let packed = packer.finish().unwrap().repeat(9);
    assert!(packed.len() < 4 << 20);
    std::fs::write(bench.path("bomb.json.xz"), packed).unwrap();
    bench.fails(
        &["report", "bomb.json.xz"],
        1,
        &["bomb.json.xz holds more than 512 MiB", "give what a run was written to"],
    );
}

/// Proves that a folder with another verb's record is refused before anything is measured, and left as it is; the same verb writes over its
/// own.
#[test]
fn records_of_other_verbs_are_kept() {
    let bench = Bench::new();
    let run = ["--tracer", "bvh-cpu", "--rays", "primary", "--samples", "1"];
    bench.run(&run, "out");
    let record = || std::fs::read(bench.path("out/run.json")).unwrap();
    let before = record();
    let need = [&["need", "--preset", "smoke", "--out", "out"][..], &run].concat();
    bench.fails(&need, 2, &["out holds what `run` measured", "another folder with --out"]);
    assert_eq!(record(), before);
    bench.run(&run, "out");
    assert_ne!(record(), before);
}
