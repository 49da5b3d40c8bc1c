//! `pareto` and `need`.

use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use super::*;

const SMALL: [&str; 9] = [
    "--quiet",
    "--preset",
    "smoke",
    "--size",
    "16x8",
    "--samples",
    "1",
    "--tracer",
    "bvh-cpu,bvh-cpu:improved,screen-dda",
];

fn fronts<'a>(adaptive: &[&'a str]) -> Vec<&'a str> {
    [&["pareto"][..], &SMALL, &["--points", "3", "--rays", "diffuse"], adaptive].concat()
}

/// Every row's tracer, viewpoint and answers.
fn answers(run: &Value) -> BTreeSet<String> {
    let row = |row: &Value| {
        let traces: Vec<&Value> = row["traces"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|trace| [&trace["rays_sha256"], &trace["hits_sha256"]])
            .collect();
        format!("{} {} {} {} {traces:?}", row["scene"]["name"], row["viewpoint"], row["tracer"], row["update_mode"])
    };
    run["rows"].as_array().unwrap().iter().map(row).collect()
}

/// How the points were laid out: of the record what no time has a part in.
fn points(run: &Value) -> Vec<String> {
    let of = |point: &Value| {
        ["tracer", "preset", "order", "values", "parameters", "face"].map(|name| point[name].to_string()).join(" ")
    };
    run["pareto"]["points"].as_array().unwrap().iter().map(of).collect()
}

/// The files of the pictures that a record names; there are some, of every point on a front and of the truth.
fn named_pictures(run: &Value) -> BTreeSet<String> {
    let sets =
        run["pareto"]["scenes"].as_array().unwrap().iter().flat_map(|scene| scene["pictures"].as_array().unwrap());
    let of_set = |set: &Value| {
        let points = set["points"].as_array().unwrap();
        assert!(!points.is_empty());
        let of_point =
            |point: &Value| ["answer", "class", "error"].map(|what| point[what].as_str().unwrap().to_owned());
        let all: Vec<String> =
            points.iter().flat_map(of_point).chain([set["truth"].as_str().unwrap().to_owned()]).collect();
        all
    };
    let all: BTreeSet<String> = sets.flat_map(of_set).collect();
    assert!(!all.is_empty());
    all
}

/// Proves that fronts over a file of the user's own are measured, though broken off and gone on with on the way: every tracer has as many
/// points as were asked for, all answer the same rays as in a run that went through; that the page answers which to choose; and that
/// `report` makes the same files.
#[test]
fn fronts_of_a_file_survive_being_killed() {
    let bench = Bench::new();
    // A tent over a floor.
    let corners = [
        [[-2.0, 0.0, -2.0], [2.0, 0.0, -2.0], [2.0, 0.0, 2.0]],
        [[-2.0, 0.0, -2.0], [2.0, 0.0, 2.0], [-2.0, 0.0, 2.0]],
        [[-1.0, 0.1, -1.0], [1.0, 0.1, -1.0], [0.0, 1.5, 0.0]],
        [[-1.0, 0.1, 1.0], [1.0, 0.1, 1.0], [0.0, 1.5, 0.0]],
    ];
    std::fs::write(bench.path("tent.glb"), glb(&corners.concat())).unwrap();
    let scene = ["--scene", "tent.glb"];
    let through = bench.call(&fronts(&[&scene[..], &["--out", "through"]].concat()));
    assert_eq!((through.status, through.stderr.as_str()), (0, ""), "{through:?}");
    for wanted in ["# Fronts", "Operating points", "How far each tracer gets", "Break-even"] {
        assert!(through.page.contains(wanted), "{wanted}: {}", through.page);
    }
    let whole = bench.result("through");
    let of = |tracer: &str| {
        let all = whole["pareto"]["points"].as_array().unwrap();
        all.iter().filter(|point| point["tracer"] == tracer).count()
    };
    assert_eq!((of("bvh-cpu"), of("screen-dda")), (3, 3));
    let out = bench.path("out");
    let arguments = fronts(&[&scene[..], &["--out", "out"]].concat());
    let mut child = bench.command(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let ended = || names(&out.join("interleaved_sets")).iter().filter(|name| name.contains("-rays-")).count();
    while ended() == 0 && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(2));
    }
    assert!(child.try_wait().unwrap().is_none(), "it ended before it was killed");
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!out.join("pareto.md").exists());
    let resumed = bench.call(&fronts(&[&scene[..], &["--out", "out", "--resume"]].concat()));
    assert_eq!(resumed.status, 0, "{resumed:?}");
    let found = bench.result("out");
    assert_eq!(points(&found), points(&whole));
    // What is chosen hangs on times; what was measured from the viewpoint does not.
    let own = |run: &Value| {
        let viewpoint = run["pareto"]["scenes"][0]["viewpoint"]["eye"].clone();
        let image = run["pareto"]["scenes"][0]["viewpoint"]["ray_image"].clone();
        let mut run = run.clone();
        let is_own = |row: &Value| {
            row["viewpoint"]["eye"] == viewpoint
                && row["viewpoint"]["ray_image"] == image
                && row["update_mode"].is_null()
        };
        run["rows"].as_array_mut().unwrap().retain(is_own);
        answers(&run)
    };
    assert_eq!((own(&found).len(), own(&found)), (6, own(&whole)));
    let before: BTreeSet<String> = names(&out).into_iter().filter(|name| out.join(name).is_file()).collect();
    assert_eq!(named_pictures(&found), names(&out.join("pictures")));
    assert!(
        before.contains("pareto_tent_diffuse_footprint.svg") && before.contains("operating_points.csv"),
        "{before:?}"
    );
    let read = |name: &String| std::fs::read(out.join(name)).unwrap();
    let contents: Vec<_> = before.iter().map(read).collect();
    assert_eq!(bench.call(&["--quiet", "report", "out"]).status, 0);
    assert!(before.iter().map(read).collect::<Vec<_>>() == contents);
    bench.fails(&["pareto", "--points", "0"], 2, &["1..=256"]);
    bench.fails(&["pareto", "--tracer", "no-such"], 2, &["no tracer"]);
}

/// Proves that fronts of two scenes that two machines have shared are joined into those of both.
#[test]
fn shards_of_fronts_are_joined() {
    let bench = Bench::new();
    let scenes = ["--scene", "room,candy", "--tracer", "bvh-cpu", "--points", "1"];
    let small = ["pareto", "--quiet", "--preset", "smoke", "--size", "16x8", "--samples", "1", "--rays", "diffuse"];
    for (shard, out) in [("1/2", "one"), ("2/2", "two")] {
        let outcome = bench.call(&[&small[..], &scenes, &["--shard", shard, "--out", out]].concat());
        assert_eq!(outcome.status, 0, "{outcome:?}");
    }
    let joined = bench.call(&["merge", "one", "two", "--out", "both"]);
    assert_eq!(joined.status, 0, "{joined:?}");
    let both = bench.result("both");
    let scenes: Vec<&Value> =
        both["pareto"]["scenes"].as_array().unwrap().iter().map(|scene| &scene["scene"]["name"]).collect();
    assert_eq!(scenes, ["room", "candy"]);
    let parts = ["one", "two"].map(|out| answers(&bench.result(out)));
    assert_eq!(answers(&both), parts.into_iter().flatten().collect());
    assert!(names(&bench.path("both")).contains("pareto_candy_diffuse_tight.svg"));
    assert_eq!(named_pictures(&both), names(&bench.path("both/pictures")));
    let page = bench.call(&["report", "--html", "page.html", "both"]);
    assert_eq!(page.status, 0, "{page:?}");
    // Of each scene truth, and answer, class and error of its point.
    let page = || std::fs::read_to_string(bench.path("page.html")).unwrap();
    assert_eq!(page().matches("<img ").count(), 8);
    // One that is another picture now is left out with its point, and named.
    let set = &both["pareto"]["scenes"][0]["pictures"][0];
    let [class, answer] = ["class", "answer"].map(|what| set["points"][0][what].as_str().unwrap());
    std::fs::copy(bench.path("both/pictures").join(answer), bench.path("both/pictures").join(class)).unwrap();
    let outcome = bench.call(&["report", "--html", "page.html", "both"]);
    assert!(outcome.status == 0 && outcome.stderr.contains(&format!("left out: {class} beside both")), "{outcome:?}");
    assert_eq!(page().matches("<img ").count(), 4);
    assert!(page().contains(&format!("not the pictures that the record names: <code>{class}</code>")));
}

/// Proves that needs are measured from both viewpoints, that the page and the table are there, and that `report` makes the same files.
#[test]
fn needs_are_told_from_both_viewpoints() {
    let bench = Bench::new();
    let arguments = [
        &["need", "--preset", "smoke", "--samples", "1", "--scene", "room"][..],
        &["--tracer", "bvh-cpu,screen-dda", "--rays", "diffuse", "--out", "out"],
    ];
    let outcome = bench.call(&arguments.concat());
    assert_eq!(outcome.status, 0, "{outcome:?}");
    // Every structure is distinguished by its resolution.
    let done: BTreeSet<&str> = outcome.stderr.lines().filter(|line| line.contains("screen-dda at frame ")).collect();
    assert!(done.len() > 2 && done.iter().all(|line| line.ends_with(" done")), "{outcome:?}");
    for wanted in ["# What structures need", "| screen-dda | entrance |", "| bvh-cpu | corner |", "nothing shrinks"] {
        assert!(outcome.page.contains(wanted), "{wanted}: {}", outcome.page);
    }
    let found = bench.result("out");
    let curves = found["need"]["curves"].as_array().unwrap();
    assert_eq!(curves.len(), 4);
    assert!(curves.iter().all(|curve| curve["points"][0]["shrunk"].as_object().unwrap().is_empty()));
    let out = bench.path("out");
    let before = names(&out);
    for wanted in ["need_room.svg", "rows.csv"] {
        assert!(before.contains(wanted), "{before:?}");
    }
    let read = |name: &String| std::fs::read(out.join(name)).unwrap();
    let contents: Vec<_> = before.iter().map(read).collect();
    assert_eq!(bench.call(&["--quiet", "report", "out"]).status, 0);
    assert!(names(&out) == before && before.iter().map(read).collect::<Vec<_>>() == contents);
}
