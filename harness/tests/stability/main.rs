//! The cases: that each shows its difficulty, and that every tracer does on them what is stated of it, neither worse nor
//! better.

mod negative;

use std::sync::Arc;

use tracebench_api::Gpu;
use tracebench_api::{Parameters, Preset};
use tracebench_harness::cases::{CASES, Case, MOST_TIES};
use tracebench_harness::contenders::{Column, Expectation, Rule};
use tracebench_harness::measure::{Context, Journal};
use tracebench_harness::plan::TracerRequest;
use tracebench_harness::progress::Progress;
use tracebench_harness::registry::{Registration, TRACERS};
use tracebench_harness::results::{CaseRecord, MOST_UNEXPLAINED, Run, TracerRun};
use tracebench_harness::studies::stability::{self, CaseMatrix, Stability, Verdict};
use tracebench_harness::truth::Cache;
use tracebench_tests::{adapter_has_ray_queries, available};

fn gpu() -> Arc<Gpu> {
    tracebench_tests::gpu()
}

/// Every registered tracer with its published preset, then with its improved one where something is stated of that; those that the adapter
/// cannot run, as if by `all`.
fn requests() -> Vec<TracerRequest> {
    let requests = |each: &'static Registration| {
        let required = available((each.describe)().name, each.create(&Ok(gpu())), &gpu()).is_some();
        let improved = each.improved.map(|_| Preset::Improved);
        let request = move |preset| TracerRequest { required, ..TracerRequest::of(each, preset) };
        [Preset::Published].into_iter().chain(improved).map(request)
    };
    TRACERS.iter().flat_map(requests).collect()
}

/// What the column of a request is called.
fn column_of(request: &TracerRequest) -> String {
    match request.preset {
        Preset::Published => request.name().to_owned(),
        Preset::Improved => format!("{}:{}", request.name(), request.preset.name()),
    }
}

fn run_cases(cases: &[&Case]) -> Run {
    let (device, cache, quiet, journal) = (Ok(gpu()), Cache::none(), Progress::new(true), Journal::none());
    stability::run(cases, &requests(), &Context::new(&device, &cache, &quiet, &journal)).unwrap()
}

/// What is wrong with a case itself, whatever tracers do.
fn flaws(case: &Case, record: &CaseRecord) -> Vec<String> {
    let mut flaws: Vec<String> = record.void.iter().cloned().collect();
    let mut check = |right: bool, what: String| {
        if !right {
            flaws.push(format!("{}: {what}", case.name));
        }
    };
    for strength in &record.strengths {
        let count = strength.rays as f64;
        check((500..=5000).contains(&strength.rays), format!("{} rays at {}", strength.rays, strength.strength));
        for (of, least) in [(strength.true_hits, 0.05), (strength.true_misses, 0.05)] {
            check(of as f64 >= least * count, format!("only {of} of {count} at {}", strength.strength));
        }
        let ties = strength.ties as f64 / count;
        check(ties <= MOST_TIES, format!("{ties} ties at {}", strength.strength));
    }
    let featured = record.strengths.last().unwrap().featured;
    check(featured >= case.feature.least, format!("only {featured} {}", case.feature.what));
    flaws
}

/// Holds what was found of cases against what is stated.
fn check(cases: &[&Case], run: &Run) {
    let found = Stability::of(run).unwrap();
    assert_eq!(cases.len(), found.cases.len());
    for (case, record) in cases.iter().zip(&found.cases) {
        assert_eq!(flaws(case, &record.case), Vec::<String>::new());
        let columns: Vec<String> = record.cells.iter().map(|cell| cell.tracer.clone()).collect();
        assert_eq!(columns, requests().iter().map(column_of).collect::<Vec<_>>());
        for cell in &record.cells {
            println!("{} {}: {}", case.name, cell.tracer, cell.text);
            let runs = cell.tracer != "ray-query" || adapter_has_ray_queries(&gpu());
            assert_eq!((cell.verdict == Verdict::Unavailable, cell.measured.is_empty()), (!runs, !runs), "{cell:?}");
        }
    }
    assert_eq!(found.surprises(), Vec::<String>::new());
    assert_eq!(beyond_rounding(&found), Vec::<String>::new());
}

/// Cells with more unexplained answers than is allowed, but for what f32 alone decides: needles by a hierarchy, and DIRT's rays
/// along borders of its cells; and for planes in texels of a scene that is a million times as large as what is looked at.
fn beyond_rounding(found: &Stability) -> Vec<String> {
    let mut cells = unexplained(found, "");
    let known = ["needles, bvh-", "face-cell-borders, dirt", "secondary-depth-ratio, voxel-abuffer:improved"];
    cells.retain(|cell| !known.iter().any(|known| cell.starts_with(known)));
    cells
}

/// Cells of tracers whose names begin so where more wrong answers have no cause than is allowed.
fn unexplained(found: &Stability, tracers: &str) -> Vec<String> {
    let mut cells = Vec::new();
    for CaseMatrix { case, cells: of_case } in &found.cases {
        for cell in of_case.iter().filter(|cell| cell.tracer.starts_with(tracers)) {
            let most = cell.measured.iter().map(|each| each.unexplained).fold(0.0, f64::max);
            assert_eq!(most > MOST_UNEXPLAINED, cell.text.contains("the cause is not known"), "{cell:?}");
            if most > MOST_UNEXPLAINED {
                cells.push(format!("{}, {}: {most}", case.name, cell.tracer));
            }
        }
    }
    cells
}

/// Proves of the committed matrix that it has every case by every tracer, and that wrong answers have causes. As a negative
/// control, those of a hierarchy in f32 do not, on needles.
#[test]
fn the_committed_matrix_has_causes() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../results/software-stability/run.json.gz");
    let found = Stability::of(&tracebench_harness::report::read_run(path.as_ref()).unwrap()).unwrap();
    let cases: Vec<&str> = found.cases.iter().map(|each| each.case.name.as_str()).collect();
    assert!(CASES.iter().map(|case| case.name).eq(cases), "`tracebench stability` was run before a case came");
    assert_eq!(beyond_rounding(&found), Vec::<String>::new());
    assert!(unexplained(&found, "bvh-cpu").iter().any(|cell| cell.starts_with("needles")));
}

/// Proves for every case that at every strength some rays hit, some miss and few are ties, that at the hardest enough
/// show the difficulty, that the controls score what they must; and for every tracer that it is as wrong as stated, or
/// shown as unavailable where the adapter cannot run it.
#[test]
#[ignore = "wider set: every case by every tracer, as `tracebench stability` runs them too"]
fn every_tracer_is_as_expected() {
    let cases: Vec<&Case> = CASES.iter().collect();
    check(&cases, &run_cases(&cases));
}

/// What was found, as text that is the same for the same: answers and judgements, no times.
fn figures(run: &Run) -> Vec<String> {
    let row = |row: &TracerRun| {
        let traces: Vec<_> = row.traces.iter().map(|trace| (&trace.hits_sha256, &trace.judgement)).collect();
        format!("{} {:?} {} {traces:?}", row.scene.name, row.strength, row.tracer.label())
    };
    run.controls.iter().chain(&run.runs).map(row).collect()
}

/// Proves the same of every ninth case, and of one of them that rays, truth and answers are the same on every run.
#[test]
fn a_part_of_the_matrix_is_as_expected_and_repeatable() {
    let cases: Vec<&Case> = CASES.iter().skip(1).step_by(9).collect();
    let found = run_cases(&cases);
    check(&cases, &found);
    let again = figures(&run_cases(&cases[3..]));
    assert!(again.len() > 30);
    let known = figures(&found);
    assert!(again.iter().all(|row| known.contains(row)), "an answer is another one");
}

/// Proves of more cases that rays, truth and answers are the same on every run.
#[test]
#[ignore = "wider set: every fifth case by every tracer, twice"]
fn the_matrix_is_repeatable() {
    let cases: Vec<&Case> = CASES.iter().step_by(5).collect();
    assert_eq!(figures(&run_cases(&cases)), figures(&run_cases(&cases)));
}

/// Proves that names are unique and fit for a command line, that knobs go one way, and that `from` is one of a knob's
/// values.
#[test]
fn the_registry_is_sane() {
    let mut names: Vec<_> = CASES.iter().map(|case| case.name).collect();
    assert!(names.iter().all(|name| name.chars().all(|c| c.is_ascii_lowercase() || c == '-')), "{names:?}");
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), CASES.len());
    for case in CASES {
        let values = case.knob.values;
        assert!((4..=6).contains(&values.len()), "{}", case.name);
        let rising = values.windows(2).all(|pair| pair[0] < pair[1]);
        let falling = values.windows(2).all(|pair| pair[0] > pair[1]);
        assert!(rising || falling, "{}: {values:?}", case.name);
        assert!(!case.summary.contains('\n') && !case.summary.ends_with('.'), "{}", case.name);
    }
    for registration in TRACERS {
        let improved = registration.improved.map_or(&[][..], |improved| improved.expectations);
        let tracer = registration.name();
        let numbered = |column: Column| column.iter().enumerate().map(move |(index, each)| (column, index, each));
        for (column, index, (name, expected)) in [registration.expectations, improved].into_iter().flat_map(numbered) {
            let case = tracebench_harness::cases::find(name).unwrap_or_else(|| panic!("{tracer}: no case {name}"));
            assert!(column[..index].iter().all(|(other, _)| other != name), "{tracer}: {name} twice");
            let expected = match expected {
                Expectation::Refusable { from, otherwise } => {
                    assert!(case.knob.values[1..].contains(from), "{tracer}, {name}: {from}");
                    otherwise
                }
                Expectation::Rasterized { wrong_by_snapping, reason, otherwise, .. } => {
                    assert!(*wrong_by_snapping >= 0.0 && !reason.is_empty(), "{tracer}, {name}");
                    otherwise
                }
                expected => expected,
            };
            if let Expectation::KnownFailure { from, below, least_wrong, reason, source, .. } = expected {
                assert!(case.knob.values.contains(from), "{tracer}, {name}: {from}");
                assert!(below <= least_wrong && !reason.is_empty() && !source.is_empty(), "{tracer}, {name}");
            }
            if let Expectation::Bounded { most_wrong, reason, .. } = expected {
                assert!((0.0..1.0).contains(most_wrong) && !reason.is_empty(), "{tracer}, {name}");
            }
        }
    }
}

/// Proves that something is stated for every tracer on every case.
#[test]
fn every_case_is_stated() {
    for tracer in TRACERS {
        for case in CASES {
            assert!(tracer.expected_on(case.name).is_some(), "{}: {} is unstated", tracer.name(), case.name);
            let improved = tracer.improved.is_none() || tracer.expected_of(Preset::Improved, case.name).is_some();
            assert!(improved, "{}: {} is unstated of the improved form", tracer.name(), case.name);
        }
    }
}
