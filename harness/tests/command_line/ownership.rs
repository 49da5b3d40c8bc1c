//! Files that are not the program's: whatever their names, and wherever links lead, no verb touches them.

use std::collections::BTreeMap;

use super::*;

const LIST: &str = "tracebench.sha256";

/// Every file, link and empty folder below a folder with what it holds; a link holds where it leads.
fn tree(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fn walk(folder: &Path, before: &str, found: &mut BTreeMap<String, Vec<u8>>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let entry = entry.unwrap();
            let (path, name) = (entry.path(), format!("{before}{}", entry.file_name().to_str().unwrap()));
            if path.is_symlink() {
                found.insert(name, std::fs::read_link(path).unwrap().into_os_string().into_encoded_bytes());
            } else if path.is_dir() {
                walk(&path, &format!("{name}/"), found);
                found.insert(name + "/", Vec::new());
            } else {
                found.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    let mut found = BTreeMap::new();
    walk(folder, "", &mut found);
    found
}

fn plant(folder: &Path, name: &str) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, format!("mine: {name}")).unwrap();
}

const SMALL: [&str; 6] = ["--preset", "smoke", "--size", "16x8", "--scene", "one.glb"];

fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), glb(&TRIANGLE)).unwrap();
    bench
}

/// Proves of a verb that every name which it writes is refused where the user's file has it: all at once and one after the other, as files,
/// as links to files, and as folders that are links; that it says so, and that what is there stays to the byte, with nothing beside it; and
/// that over its own files it goes well (the negative control). `adaptive` names come and go while it works.
fn spares(bench: &Bench, words: &[&str], adaptive: &[&str]) {
    let call = |out: &str| bench.call(&[&["--quiet"], words, &["--out", out]].concat());
    for _ in 0..2 {
        let outcome = call("own");
        assert_eq!(outcome.status, 0, "{words:?}: {outcome:?}");
    }
    let own = tree(&bench.path("own"));
    let written: Vec<&str> =
        own.keys().map(String::as_str).filter(|name| !name.ends_with('/') && *name != LIST).collect();
    let all: Vec<&str> = written.iter().chain(adaptive).copied().collect();
    let refused = |out: &str, names: &[&str], what: &str| {
        let before = tree(&bench.path(out));
        let outcome = call(out);
        assert_ne!(outcome.status, 0, "{words:?}, {what} {names:?}: {outcome:?}");
        let is_told = |name: &&str| outcome.stderr.contains(name.split('/').next().unwrap());
        assert!(names.iter().take(12).any(is_told), "{words:?}, {what} {names:?}: {outcome:?}");
        let after = tree(&bench.path(out));
        let stays = before.iter().all(|(name, contents)| after.get(name) == Some(contents));
        // What needs no measuring is made where nothing is in the way.
        assert!(
            stays && (words.contains(&"dirt-claims") || after.len() == before.len()),
            "{words:?}, {what} {names:?}"
        );
    };
    // One after the other where no device is opened each time.
    let is_quick = ["bvh-cpu", "dirt-claims", "merge"].iter().any(|word| words.contains(word));
    let each = all.iter().filter(|_| is_quick).map(|name| vec![*name]);
    let of_each: Vec<Vec<&str>> = std::iter::once(all.clone()).chain(each).collect();
    for (index, names) in of_each.iter().enumerate() {
        let out = format!("planted-{index}");
        names.iter().for_each(|name| plant(&bench.path(&out), name));
        plant(&bench.path(&out), "notes.txt");
        refused(&out, names, "files");
    }
    plant(&bench.path("listed"), LIST);
    refused("listed", &[LIST], "a list");
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        let links = bench.path("links");
        std::fs::create_dir(&links).unwrap();
        for name in &all {
            plant(&bench.path("targets"), name);
            let first = links.join(name.split('/').next().unwrap());
            let _ = symlink(Path::new("../targets").join(name.split('/').next().unwrap()), first);
        }
        let targets = tree(&bench.path("targets"));
        refused("links", &all, "links");
        std::fs::create_dir(bench.path("dangling")).unwrap();
        symlink("../nowhere", bench.path("dangling").join(written[0])).unwrap();
        refused("dangling", &written[..1], "a dangling link");
        assert!(tree(&bench.path("targets")) == targets && !bench.path("nowhere").exists());
    }
    let listed = std::fs::read_to_string(bench.path("own").join(LIST)).unwrap();
    assert!(!written.is_empty() && written.iter().all(|name| listed.contains(&format!("  {name}\n"))), "{listed}");
    // What was changed by hand is the user's from then on.
    std::fs::write(bench.path("own").join(written[0]), "changed").unwrap();
    let outcome = call("own");
    assert!(outcome.status != 0 && outcome.stderr.contains(written[0]), "{words:?}: {outcome:?}");
    assert_eq!(std::fs::read_to_string(bench.path("own").join(written[0])).unwrap(), "changed");
}

/// What every verb that measures has for a while, or had in older forms.
const RACES: [&str; 4] =
    ["interleaved_sets/plan.json", "interleaved_sets/mine.txt", "pictures/mine.png", "run.json.xz"];

#[test]
fn run_spares() {
    let words = [&["run"], &SMALL[..], &["--tracer", "bvh-cpu", "--rays", "primary", "--samples", "1"]].concat();
    spares(&bench(), &words, &RACES);
}

#[test]
fn sweep_spares() {
    let words =
        [&["sweep"], &SMALL[..], &["--tracer", "bvh-cpu", "--over", "build", "--rays", "primary", "--samples", "1"]];
    spares(&bench(), &words.concat(), &RACES);
}

#[test]
fn pareto_spares() {
    let words =
        [&["pareto"], &SMALL[..], &["--tracer", "bvh-cpu", "--points", "1", "--rays", "diffuse", "--samples", "1"]];
    spares(&bench(), &words.concat(), &RACES);
}

#[test]
fn need_spares() {
    let words = [&["need"], &SMALL[..], &["--tracer", "bvh-cpu", "--rays", "diffuse", "--samples", "1"]].concat();
    spares(&bench(), &words, &RACES);
}

#[test]
fn tables_spare() {
    let words = [&["table", "bvh"], &SMALL[..], &["--rays", "primary", "--samples", "1"]].concat();
    spares(&bench(), &words, &RACES);
}

#[test]
fn tables_of_papers_spare() {
    let words = [&["table", "dirt-figure10"], &SMALL[..], &["--only", "dirt.buckets=8", "--samples", "1"]].concat();
    spares(&bench(), &words, &[]);
}

#[test]
fn tune_spares() {
    let words = [
        &["sweep", "--choose", "footprint"],
        &SMALL[..],
        &["--tracer", "bvh-cpu", "--over", "build", "--rays", "primary"],
    ]
    .concat();
    spares(&bench(), &words, &RACES);
}

#[test]
fn explain_spares() {
    let words = [&["explain"], &SMALL[..], &["--rays", "primary"]].concat();
    spares(&bench(), &words, &RACES);
}

#[test]
fn stability_spares() {
    spares(&bench(), &["stability", "--case", "edge-on", "--tracer", "bvh-cpu"], &RACES);
}

#[test]
fn clock_spares() {
    let words = [
        "doctor",
        "--clock",
        "--preset",
        "smoke",
        "--scene",
        "one.glb",
        "--tracer",
        "bvh-cpu",
        "--interleaved-sets",
        "1",
        "--samples",
        "1",
    ];
    spares(&bench(), &words, &[]);
}

#[test]
fn merge_and_claims_spare() {
    let bench = bench();
    let part = [&["table", "dirt-figure10"], &SMALL[..], &["--only", "dirt.buckets=8", "--samples", "1"]].concat();
    let outcome = bench.call(&[&part[..], &["--quiet", "--shard", "1/1", "--out", "shard"]].concat());
    assert_eq!(outcome.status, 0, "{outcome:?}");
    spares(&bench, &["table", "dirt-claims", "--from", "shard"], &[]);
    for folder in std::fs::read_dir(bench.folder.path()).unwrap() {
        let name = folder.unwrap().file_name().into_string().unwrap();
        if !["shard", "one.glb"].contains(&&*name) {
            std::fs::remove_dir_all(bench.path(&name)).unwrap();
        }
    }
    spares(&bench, &["merge", "shard"], &RACES);
}

/// Proves that a reproduction leaves files of its own names alone, and those in the folders of its steps.
#[test]
fn reproduce_spares() {
    let bench = Bench::new();
    let words = ["reproduce", "--quiet", "--preset", "smoke", "--budget", "1s", "--out"];
    for (name, part) in [
        ("reproduce.json", "holds what was measured before"),
        ("reproduce.md", "reproduce.md (not on the list"),
        ("report.html", "report.html (not on the list"),
        (LIST, "is no list"),
    ] {
        plant(&bench.path(name), name);
        let before = tree(&bench.path(name));
        bench.fails(&[&words[..], &[name]].concat(), 1, &[part]);
        assert!(tree(&bench.path(name)) == before, "{name}");
    }
    plant(&bench.path("steps/front"), "summary.md");
    let outcome = bench.call(&[&words[..], &["steps"]].concat());
    assert!(outcome.status == 1 && outcome.stderr.contains("summary.md (not on the list"), "{outcome:?}");
    assert_eq!(tree(&bench.path("steps/front")).len(), 1);
}

/// Proves that a record which was handed in without a list vouches for what derives from it: what is identical stays, what is missing is
/// made, what differs is named and stays, by `report` and by `table --from`; and that it is not measured over.
#[test]
fn a_record_vouches_for_what_derives_from_it() {
    let bench = bench();
    let measure =
        [&["--quiet", "table", "bvh"], &SMALL[..], &["--rays", "primary", "--samples", "1", "--out", "out"]].concat();
    assert_eq!(bench.call(&measure).status, 0);
    let out = bench.path("out");
    std::fs::remove_file(out.join(LIST)).unwrap();
    let handed_in = tree(&out);
    bench.fails(&measure, 1, &["run.json (not on the list", "table_bvh.md", "move it away"]);
    assert!(tree(&out) == handed_in);
    let whole = |verb: &[&str]| {
        let outcome = bench.call(&[&["--quiet"], verb].concat());
        assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{verb:?}: {outcome:?}");
        let mut found = tree(&out);
        assert!(found.remove(LIST).is_some());
        assert!(found == handed_in, "{verb:?}");
    };
    for (verb, page) in [(&["report", "out"][..], "summary.md"), (&["table", "bvh", "--from", "out"], "table_bvh.md")] {
        std::fs::remove_file(out.join(page)).unwrap();
        whole(verb);
        std::fs::remove_file(out.join(LIST)).unwrap();
        std::fs::remove_file(out.join("rows.csv")).unwrap();
        std::fs::write(out.join(page), "mine").unwrap();
        bench.fails(&[&["--quiet"], verb].concat(), 1, &[page, "not on the list"]);
        assert_eq!(std::fs::read_to_string(out.join(page)).unwrap(), "mine");
        std::fs::remove_file(out.join(page)).unwrap();
        whole(verb);
    }
    // Its own from then on: another form of the page takes its place.
    whole(&["report", "out"]);
    let mut record = bench.result("out");
    record["commit"] = json!("another");
    std::fs::write(out.join("run.json"), record.to_string()).unwrap();
    assert_eq!(bench.call(&["--quiet", "report", "out"]).status, 0);
    assert!(std::fs::read(out.join("summary.md")).unwrap() != handed_in["summary.md"]);
}

/// Proves that what derives from a record is not written beside another one, and that a folder into which a process measures is left alone.
#[test]
fn another_runs_folder_is_left_alone() {
    let bench = bench();
    let part =
        [&["--quiet", "table", "dirt-figure10"], &SMALL[..], &["--only", "dirt.buckets=8", "--samples", "1"]].concat();
    for (out, shard, seed) in [("whole", "", "1"), ("shard", "1/1", "1"), ("other", "", "2")] {
        let shard = if shard.is_empty() { vec![] } else { vec!["--shard", shard] };
        let outcome = bench.call(&[&part[..], &shard, &["--seed", seed, "--out", out]].concat());
        assert_eq!(outcome.status, 0, "{outcome:?}");
    }
    std::fs::copy(bench.path("whole/run.json"), bench.path("other/copy.json")).unwrap();
    let other = tree(&bench.path("other"));
    for words in [
        &["merge", "shard"][..],
        &["table", "dirt-claims", "--from", "whole"],
        &["table", "dirt-figure10", "--from", "whole"],
        &["run", "--tracer", "bvh-cpu"],
    ] {
        bench.fails(&[words, &["--out", "other"]].concat(), 2, &["other holds", "choose another folder"]);
    }
    bench.fails(&["report", "other/copy.json"], 2, &["other holds the record of another run"]);
    assert!(tree(&bench.path("other")) == other);
    // Of the same plan the whole is replaced, and beside their own record claims and tables are welcome.
    for words in [
        &["merge", "shard", "--out", "whole"][..],
        &["table", "dirt-claims", "--from", "whole", "--out", "whole"],
        &["table", "dirt-figure10", "--from", "whole/run.json"],
    ] {
        let outcome = bench.call(words);
        assert_eq!(outcome.status, 0, "{words:?}: {outcome:?}");
    }
    let held = std::fs::File::options().append(true).open(bench.path("whole").join(LIST)).unwrap();
    held.lock().unwrap();
    let whole = tree(&bench.path("whole"));
    for words in [
        &["merge", "shard", "--out", "whole"][..],
        &["table", "dirt-claims", "--from", "whole", "--out", "whole"],
        &["table", "dirt-figure10", "--from", "whole"],
        &["report", "whole"],
        &["report", "--html", "whole/page.html", "whole"],
        &[&part[..], &["--out", "whole", "--resume"]].concat(),
    ] {
        bench.fails(words, 1, &["another process writes into whole"]);
    }
    assert!(tree(&bench.path("whole")) == whole);
}

/// Proves that a page replaces what the program wrote, and neither another file, nor one that was changed, nor a link.
#[test]
fn single_files_are_spared() {
    let bench = bench();
    bench.run(&["--tracer", "bvh-cpu", "--rays", "primary", "--samples", "1"], "record");
    let page = |records: &[&'static str], out: &'static str| [&["report", "--quiet", "--html", out], records].concat();
    let verbs: [(&str, [Vec<&str>; 2]); 1] =
        [("p.html", [page(&["record"], "p.html"), page(&["record", "record/run.json"], "p.html")])];
    for (file, [one, other]) in &verbs {
        let path = bench.path(file);
        let mut written = BTreeSet::new();
        for words in [one, other] {
            let outcome = bench.call(words);
            assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{words:?}: {outcome:?}");
            written.insert(std::fs::read(&path).unwrap());
        }
        assert_eq!(written.len(), 2, "{file}: both are the same");
        // A page of the user's begins like one.
        let mine = "<!DOCTYPE html>mine";
        std::fs::write(&path, mine).unwrap();
        bench.fails(one, 1, &[file, "changed since it was written"]);
        std::fs::remove_file(bench.path(LIST)).unwrap();
        bench.fails(one, 1, &[file, "not on the list"]);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), mine);
        #[cfg(unix)]
        {
            std::fs::rename(&path, bench.path("target")).unwrap();
            std::os::unix::fs::symlink("target", &path).unwrap();
            bench.fails(one, 1, &[file, "a link"]);
            assert!(path.is_symlink() && std::fs::read_to_string(bench.path("target")).unwrap() == mine);
            std::fs::remove_file(bench.path("target")).unwrap();
            bench.fails(one, 1, &[file, "a link"]);
            assert!(!bench.path("target").exists());
        }
        assert!(!bench.path(LIST).exists(), "a list of nothing");
    }
}

/// Proves that a folder that `results/pack.sh` has packed is reported on as before and measured over, and that the script removes nothing
/// that is not on the list as it is.
#[cfg(unix)]
#[test]
fn packed_results_stay_the_programs() {
    let bench = bench();
    let words = [
        &["--quiet", "table", "dirt-figure10"],
        &SMALL[..],
        &["--only", "dirt.buckets=8", "--samples", "1", "--out", "out"],
    ]
    .concat();
    assert_eq!(bench.call(&words).status, 0);
    let out = bench.path("out");
    let whole = tree(&out);
    let theirs = ["mine.png", "pictures/mine.png", "run.json", "summary.md"];
    std::fs::create_dir(bench.path("theirs")).unwrap();
    theirs.iter().for_each(|name| plant(&bench.path("theirs"), name));
    plant(&out, "mine.png");
    std::fs::write(out.join("rows.csv"), "mine").unwrap();
    let before = tree(&bench.path("theirs"));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../results/pack.sh");
    let packed = Command::new("bash").arg(&script).args([&out, &bench.path("theirs")]).output().unwrap();
    assert!(packed.status.success(), "{packed:?}");
    assert!(tree(&bench.path("theirs")) == before, "files without a list were touched");
    let found = tree(&out);
    assert!(found["mine.png"] == b"mine: mine.png" && found["rows.csv"] == b"mine");
    let left: Vec<&str> = found.keys().map(String::as_str).filter(|name| whole.contains_key(*name)).collect();
    assert_eq!(
        left,
        ["figure_dirt_figure10_one.svg", "rows.csv", "table_dirt_figure10.md", LIST, "verdicts_dirt_figure10.json"]
    );
    assert!(found.contains_key("run.json.xz"));
    std::fs::remove_file(out.join("rows.csv")).unwrap();
    std::fs::remove_file(out.join("mine.png")).unwrap();
    // What was left out is made again, to the byte; the page is made by `report --html` alone.
    let outcome = bench.call(&["--quiet", "report", "out"]);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    let again = tree(&out);
    let others = ["run.json", "report.html", LIST];
    let differs = |name: &&String| !others.contains(&name.as_str()) && again.get(*name) != whole.get(*name);
    assert_eq!(whole.keys().find(differs), None);
    assert_eq!(bench.call(&words).status, 0);
    assert!(out.join("run.json").exists() && !out.join("run.json.xz").exists());
}
