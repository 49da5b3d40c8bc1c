//! `attack`: what is refused, and that nothing that has ended is lost.

use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use super::*;

/// A search of the smallest size.
fn attack<'a>(further: &[&'a str]) -> Vec<&'a str> {
    let smoke =
        ["attack", "--quiet", "--preset", "smoke", "--size", "16x8", "--frame-size", "64x32", "--face-size", "32"];
    [&smoke[..], further].concat()
}

/// How many trials of a search are on the disk.
fn trials(folder: &Path) -> usize {
    let kept = std::fs::read(folder.join("interleaved_sets/001-trials.json")).ok();
    let kept: Option<Value> = kept.and_then(|text| serde_json::from_slice(&text).ok());
    kept.map_or(0, |kept| kept["ended"]["searched"].as_array().map_or(0, Vec::len))
}

/// Proves that a search which is killed loses no trial that has ended, and that gone on with it finds what one finds that ran through.
#[test]
fn trials_survive_being_killed() {
    let bench = Bench::new();
    let search = ["--tracer", "bvh-cpu", "--rays", "hostile", "--rule", "tight", "--trials", "60", "--brief", "--out"];
    assert_eq!(bench.call(&attack(&[&search[..], &["through"]].concat())).status, 0);
    let out = bench.path("out");
    let mut child = bench.command(&attack(&[&search[..], &["out"]].concat()));
    let mut child = child.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    while trials(&out) < 5 && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = trials(&out);
    assert!((5..60).contains(&kept), "{kept}");
    let outcome = bench.call(&attack(&[&search[..], &["out", "--resume"]].concat()));
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let [through, found] = ["through", "out"].map(|folder| bench.result(folder)["attack"].clone());
    assert_eq!(found["searches"][0]["trials"], 60);
    assert_eq!(found, through);
    assert!(bench.path("out/attack.md").exists() && !bench.path("out/interleaved_sets").exists());
    // What derives from the record is made again from it alone.
    let page = std::fs::read(bench.path("out/attack.md")).unwrap();
    std::fs::remove_file(bench.path("out/attack.md")).unwrap();
    assert_eq!(bench.call(&["report", "out"]).status, 0);
    assert_eq!(std::fs::read(bench.path("out/attack.md")).unwrap(), page);
}

/// Proves that what was made small is traced by the command that is told, from the folder of the record, and is wrong there for the same cause.
#[test]
fn what_was_made_small_is_wrong_by_its_command() {
    let bench = Bench::new();
    let search = ["--tracer", "bvh-cpu", "--rays", "hostile", "--rule", "tight", "--trials", "2", "--out", "found"];
    assert_eq!(bench.call(&attack(&search)).status, 0);
    let record = bench.result("found");
    let all = record["attack"]["searches"][0]["found"].as_array().unwrap();
    let small: Vec<&Value> = all.iter().map(|pose| &pose["shrunk"]).filter(|small| !small.is_null()).collect();
    assert!(!small.is_empty(), "{record}");
    for (place, small) in small.into_iter().enumerate() {
        let command = small["command"].as_str().unwrap();
        let words: Vec<String> =
            command.split(' ').skip(1).map(|word| word.replace("attack/", "found/attack/")).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let out = format!("again{place}");
        let outcome = bench.call(&[&words[..], &["--quiet", "--out", &out]].concat());
        assert_eq!(outcome.status, 0, "{command}: {outcome:?}");
        let row = bench.result(&out)["rows"][0].clone();
        let (trace, cause) = (&row["traces"][0], small["cause"].as_str().unwrap());
        assert!(trace["judgement"]["causes"]["tight"][cause].as_u64() >= Some(1), "{cause}: {trace}");
        assert_eq!(trace["count"], small["rays"]);
        let triangles = small["triangles"].as_u64().unwrap() + small["markers"].as_u64().unwrap();
        assert_eq!(row["scene"]["triangles"], triangles);
    }
}

/// Proves that no trials, another rule, times, a scene without a pose and a tracer that refuses are said clearly.
#[test]
fn what_cannot_be_searched_is_refused() {
    let bench = Bench::new();
    let of = |further: &[&'static str]| attack(&[&["--tracer", "bvh-cpu", "--out", "out"][..], further].concat());
    bench.fails(&of(&["--trials", "0"]), 2, &["--trials", "1..="]);
    bench.fails(&of(&["--rule", "near"]), 2, &["hit_miss or tight or footprint"]);
    bench.fails(&of(&["--samples", "3"]), 2, &["takes no times"]);
    bench.fails(&attack(&["--out", "out"]), 2, &["--tracer"]);
    // All of its bounds lie in one plane, on its triangle or beside it.
    std::fs::write(bench.path("flat.glb"), glb(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])).unwrap();
    bench.fails(&of(&["--scene", "flat.glb", "--trials", "1"]), 1, &["no admissible pose", "take other rays"]);
    let refusing = attack(&["--tracer", "mesh-warp", "--rays", "diffuse", "--trials", "2", "--out", "refusing"]);
    bench.fails(&refusing, 1, &["mesh-warp", "not supported"]);
}
