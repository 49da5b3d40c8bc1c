//! `sweep --choose`.

use super::*;

use tracebench_harness::report;
use tracebench_harness::results::{Judgement, Record};
use tracebench_harness::studies::tune::{Label, Tuning};

const SMALL: [&str; 8] = ["sweep", "--choose", "footprint", "--quiet", "--preset", "smoke", "--size", "16x8"];
const DDA: [&str; 2] = ["--tracer", "screen-dda"];

fn tune(bench: &Bench, arguments: &[&str]) -> Outcome {
    bench.call(&[&SMALL[..], &DDA, arguments].concat())
}

fn read(bench: &Bench, out: &str) -> Record {
    report::read_run(&bench.path(out)).unwrap()
}

/// Proves that what is tuned is what `run` measures with the same values from the same viewpoints, bit for bit: the own one,
/// and the next that the scene lists; that the best value is the one with the greatest agreement; and that `report` makes the same files.
#[test]
fn values_are_those_of_runs() {
    let bench = Bench::new();
    let outcome = tune(&bench, &["--scene", "room", "--over", "thickness=0,0.02", "--rays", "diffuse", "--out", "out"]);
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    assert!(outcome.page.contains("all score what they must") && outcome.page.contains("tuned elsewhere"));
    let record = read(&bench, "out");
    let found = Tuning::of(&record).unwrap();
    let named: Vec<&str> = found.sets.iter().map(|set| set.viewpoint.name.as_str()).collect();
    assert_eq!(named, ["entrance", "corner"]);
    let named = "screen-dda,screen-dda@thickness=0,screen-dda@thickness=0.02";
    for (set, name) in found.sets.iter().zip(["entrance", "corner"]) {
        bench.run(&["--tracer", named, "--rays", "diffuse", "--view", name], name);
        let rows = read(&bench, name).rows;
        let mut agreements = Vec::new();
        for (value, judged) in &set.values {
            let thickness: f64 = value.parse().unwrap();
            let run = rows.iter().find(|run| run.tracer.parameters["thickness"] == thickness).unwrap();
            let (trace, judged) = (&run.traces[0], judged.unwrap());
            assert_eq!((&trace.rays_sha256, &trace.hits_sha256), (&set.rays.rays_sha256, &judged.hits_sha256));
            let [Judgement::Closest(one), Judgement::Closest(other)] = [&trace.judgement, &judged.judgement] else {
                panic!("another query")
            };
            assert_eq!(one.agreement, other.agreement);
            agreements.push((one.agreement.footprint.unwrap(), *value));
        }
        assert_eq!(agreements.len(), 3);
        let greatest = agreements.iter().map(|(share, _)| *share).fold(0.0, f64::max);
        let best = agreements.iter().find(|(share, _)| *share == greatest).unwrap().1;
        assert_eq!([Label::Default, Label::TunedHere].map(|label| set.chosen(label)), [Some("0.005"), Some(best)]);
        // They differ, so that another could have been taken for the best.
        assert!(agreements.iter().any(|(share, _)| *share < greatest), "{agreements:?}");
    }
    assert_eq!(found.sets[0].chosen(Label::TunedElsewhere), found.sets[1].chosen(Label::TunedHere));
    for label in Label::ALL {
        let from_own = |scene, rays| found.value_from_own_viewpoint(scene, rays, label);
        assert_eq!(from_own("room", "diffuse"), found.sets[0].chosen(label));
        assert_eq!((from_own("room", "ao"), from_own("candy", "diffuse")), (None, None));
    }
    let before = names(&bench.path("out"));
    let (charts, others): (Vec<&String>, Vec<&String>) = before.iter().partition(|name| name.starts_with("sweep_"));
    assert_eq!(others, ["report.html", "rows.csv", "run.json", "sweep.md", "wrong_rays.csv"]);
    let of = |view: &str, end: &str| charts.iter().filter(|name| name.contains(view) && name.ends_with(end)).count();
    assert_eq!([of("entrance", "svg"), of("corner", "svg"), charts.len()], [1, 1, 4], "{charts:?}");
    let bytes = |name: &String| std::fs::read(bench.path("out").join(name)).unwrap();
    let contents: Vec<_> = before.iter().map(bytes).collect();
    assert_eq!(bench.call(&["--quiet", "report", "out"]).status, 0);
    assert!(names(&bench.path("out")) == before && before.iter().map(bytes).collect::<Vec<_>>() == contents);
}

/// Proves that a scene which is seen from nowhere else is tuned from its own viewpoint, with a note, and that a tuning of
/// nothing is an error which leaves no folder.
#[test]
fn no_other_viewpoint() {
    let bench = Bench::new();
    std::fs::write(bench.path("one.glb"), glb(&TRIANGLE)).unwrap();
    let scene = ["--scene", "one.glb", "--rays", "primary", "--view", "0.25,0.25,40:0.25,0.25,0"];
    let outcome = tune(&bench, &[&scene[..], &["--out", "out"]].concat());
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let record = read(&bench, "out");
    let found = Tuning::of(&record).unwrap();
    let reason = &record.skipped[0].reason;
    assert!(reason.contains("has no other viewpoint than 'given'"), "{reason}");
    assert_eq!((found.sets.len(), found.sets[0].chosen(Label::TunedElsewhere)), (1, None));
    assert!(std::fs::read_to_string(bench.path("out/sweep.md")).unwrap().contains("nothing to choose by"));
}

/// Proves that wrong arguments end with status 2 and say what is wrong, and touch no file.
#[test]
fn wrong_arguments() {
    let bench = Bench::new();
    for (arguments, parts) in [
        (vec!["--tracer", "screen"], vec!["'screen-dda'"]),
        (vec!["--tracer", "all"], vec!["one tracer"]),
        (vec!["--over", "thickness,start_bias"], vec!["one parameter"]),
        (vec!["--over", "thick"], vec!["'thickness'"]),
        (vec!["--over", "resolution"], vec!["leave --choose out"]),
        (vec!["--over", "thickness=-1e5"], vec!["a number from -10000"]),
        (vec!["--tracer", "screen-dda", "--set", "screen-dda.thickness=0.1"], vec!["set already"]),
        (vec!["--grid", "thickness,start_bias"], vec!["--choose"]),
        (vec!["--rays", "difuse"], vec!["'diffuse'"]),
        (vec!["--samples", "3"], vec!["--choose"]),
        (vec!["--scene", "room,candy", "--view", "entrance"], vec!["candy has no viewpoint 'entrance'"]),
    ] {
        bench.fails(&[&SMALL[..], &arguments, &["--out", "out"]].concat(), 2, &parts);
    }
    bench.fails(&["sweep", "--choose", "loose"], 2, &["footprint"]);
    assert!(names(bench.folder.path()).iter().all(|name| name == "cache"), "{:?}", names(bench.folder.path()));
}
