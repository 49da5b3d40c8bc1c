//! Negative controls: what is wrong is noticed, in both directions.

use super::faults::Fault;
use super::*;
use tracebench_harness::cases::find;
use tracebench_harness::measure::TracerConfig;
use tracebench_harness::measure::controls::Control;
use tracebench_harness::measure::session::Session;
use tracebench_harness::registry;
use tracebench_harness::results::CaseTracer;
use tracebench_harness::studies::stability::{Candidate, CaseMatrix, measure, prepare};

/// An expectation as registrations tell it.
fn expectation(told: &'static str) -> Expectation {
    serde_json::from_str(told).unwrap()
}

/// A tracer with one expectation, and shares of wrong rays as a file has them.
fn candidate(registration: Registration, case: &Case, expected: &Expectation, shares: &str) -> Candidate {
    let text = format!("tracer,case,software\nsubject,{},{shares}\n", case.name);
    let shares = Arc::new(ExpectedShares::parse(&text).unwrap());
    let request = TracerRequest::of(&registration, Preset::Published);
    Candidate { request, expected: vec![(case.name, expected.clone())], column: "subject".to_owned(), shares }
}

fn bvh_cpu() -> Registration {
    *registry::find("bvh-cpu").unwrap()
}

/// Runs candidates without a device.
fn run_of(cases: &[&Case], candidates: &[Candidate]) -> Record {
    let device = Err(tracebench_api::TracerError::Unavailable("no device is needed".to_owned()));
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    measure(cases, candidates, &Context::new(&device, &cache, &quiet, &journal)).unwrap()
}

fn measured(case: &Case, candidates: &[Candidate]) -> CaseMatrix {
    Stability::of(&run_of(&[case], candidates)).unwrap().cases.remove(0)
}

fn verdict(case: &Case, candidate: Candidate) -> (Verdict, String) {
    let CaseMatrix { case, cells } = measured(case, &[candidate]);
    assert_eq!(case.invalid, None);
    (cells[0].verdict, cells[0].text.clone())
}

/// `bvh-cpu` built over a session's scene.
fn built(session: &Session) -> TracerConfig {
    let registration = bvh_cpu();
    let description = registration.describe();
    let parameters = Parameters::preset(&description.parameters, Preset::Published);
    let device = Err(tracebench_api::TracerError::Unavailable("no device is needed".to_owned()));
    let mut config = TracerConfig::ready(description, parameters, registration.create(&device).unwrap());
    session.sample_build(&mut config).unwrap();
    config
}

/// Cells that a tracer with a fault passes, by fault and case, and why it cannot be told there.
const NOT_TOLD: &[(&str, &str, &[&str], &str)] = &[
    (
        "always-miss",
        "plane-through-eye",
        &["screen-dda", "screen-dda:improved", "height-field", "height-field:improved"],
        "onto a plane that is a line in their one view nearly every hit is lost or misplaced, at every strength",
    ),
    (
        "always-miss",
        "secondary-depth-ratio",
        &["screen-dda", "height-field", "height-field:improved"],
        "nearly every ray hits, and these hit it where it starts: nearly all are wrong",
    ),
    (
        "always-miss",
        "towards-camera",
        &["screen-dda", "screen-dda:improved", "height-field", "height-field:improved"],
        "they place no hit on the surface, so that all rays that hit are wrong and all that miss are right",
    ),
    (
        "always-hit",
        "secondary-depth-ratio",
        &["screen-dda", "height-field", "height-field:improved"],
        "nearly every ray hits, and these hit it where it starts: nearly all are wrong",
    ),
    (
        "always-hit",
        "crowded-pixel",
        &[
            "fragment-abuffer",
            "fragment-abuffer:improved",
            "height-field",
            "height-field:improved",
            "hybrid",
            "quadtree:improved",
            "screen-dda",
            "screen-dda:improved",
            "voxel-abuffer",
            "voxel-octree",
        ],
        "any hit in a crowd that is wider by a pixel or voxel: nearly every ray that misses hits them",
    ),
    (
        "always-hit",
        "behind-foreground",
        &["height-field", "height-field:improved"],
        "all behind the foreground is solid: every ray hits",
    ),
    (
        "every-tenth",
        "cube-borders",
        &["voxel-abuffer"],
        "at every strength 7 to 11 % of its rays are wrong, and a tenth is no more than a third away from that",
    ),
];

/// Proves that tracers which always miss, always hit, or err on every tenth ray are unexpected in every cell of the matrix, published and
/// improved, but for those that are listed with a reason. An oracle is unexpected wherever rays must be wrong or refused, and nowhere else.
#[test]
fn tracers_with_faults_are_unexpected_in_all_cells_but_those_listed() {
    let nothing = |fault: Fault| {
        let request = TracerRequest::of(&fault.registration(), Preset::Published);
        Candidate { request, expected: Vec::new(), column: String::new(), shares: Arc::default() }
    };
    let cases: Vec<&Case> = CASES.iter().collect();
    let mut run = run_of(&cases, &[nothing(Fault::EveryTenth)]);
    run.rows.append(&mut run.controls);
    let tracer = |name: &str| run.rows.iter().find(|row| row.tracer.name == name).unwrap().tracer.clone();
    let tenth = ("every-tenth", tracer(Fault::EveryTenth.name()));
    let [miss, hit, oracle] = ["always-miss", "always-hit", "oracle"].map(|name| (name, tracer(name)));
    let subjects = [miss, hit, tenth, oracle];
    let shares = Arc::new(ExpectedShares::stated().unwrap());
    let columns: Vec<Candidate> = requests().iter().map(|request| Candidate::of(request, &shares)).collect();
    for (case, record) in CASES.iter().zip(&mut run.cases.as_mut().unwrap().cases) {
        assert_eq!(record.invalid, None);
        record.tracers.clear();
        for (column, (_, tracer)) in columns.iter().flat_map(|column| subjects.iter().map(move |each| (column, each))) {
            let expectation = column.record(case, "software", None);
            assert!(expectation.is_some());
            let (tracer, no_answers) = (tracer.clone(), Vec::new());
            record.tracers.push(CaseTracer { tracer, expectation, unavailable: false, no_answers });
        }
    }
    let mut passed = Vec::new();
    let mut right_unexpected = 0;
    for CaseMatrix { case, cells } in Stability::of(&run).unwrap().cases {
        assert_eq!(cells.len(), columns.len() * subjects.len());
        let subjects = columns.iter().flat_map(|column| subjects.iter().map(move |(name, _)| (column, *name)));
        for (cell, (column, subject)) in cells.iter().zip(subjects) {
            let expectation = cell.expectation.as_ref().unwrap();
            if subject == "oracle" {
                let must_err = |index| expectation.expected_share(index).is_some_and(|share| share > 0.01);
                let must_refuse = expectation.kind == ExpectationKind::Unserved;
                let expected = must_refuse || (0..case.difficulty_parameter.values.len()).any(must_err);
                assert_eq!(cell.verdict.is_unexpected(), expected, "{}, {}: {}", case.name, column.column, cell.text);
                right_unexpected += usize::from(expected);
            } else if !cell.verdict.is_unexpected() {
                passed.push((subject.to_owned(), case.name.clone(), column.column.clone()));
            }
        }
    }
    let listed = |(fault, case, columns, _): &(&str, &str, &[&str], &str)| {
        let [fault, case] = [*fault, *case].map(str::to_owned);
        columns.iter().map(move |column| (fault.clone(), case.clone(), (*column).to_owned())).collect::<Vec<_>>()
    };
    let mut listed: Vec<_> = NOT_TOLD.iter().flat_map(listed).collect();
    listed.sort();
    passed.sort();
    assert_eq!(passed, listed);
    assert!(right_unexpected > 100, "{right_unexpected}");
}

/// Proves that a falsified expectation fails in either direction, and names what was measured.
#[test]
fn falsified_expectations_fail() {
    let [failure, bounded, exact] = [
        r#"{"kind": "known_failure", "rule": "hit_miss", "reason": "none", "source": "none"}"#,
        r#"{"kind": "bounded", "rule": "hit_miss", "reason": "none"}"#,
        r#"{"kind": "exact", "rule": "tight"}"#,
    ]
    .map(expectation);
    let case = find("edge-on").unwrap();
    // What never fails, said to fail at the hardest difficulty level, or before it.
    for shares in ["45:0 80:0 87:0 89:0 89.8:0 89.98:20", "45:0 80:20 87:0 89:0 89.8:0 89.98:0"] {
        let (verdict, text) = verdict(case, candidate(bvh_cpu(), case, &failure, shares));
        assert_eq!(verdict, Verdict::UnexpectedSuccess, "{text}");
        assert!(text.contains("13 %"), "{text}");
    }
    // What fails, said to be exact, or to fail less or more; what is true passes.
    let needles = find("needles").unwrap();
    let stated =
        ExpectedShares::stated().unwrap().of("bvh-cpu", needles.name, "software", &needles.difficulty_parameter.values);
    let times = |factor: f64| {
        let at = |(value, share): (&f64, &Option<f64>)| format!("{value}:{}", factor * 100.0 * share.unwrap());
        needles.difficulty_parameter.values.iter().zip(&stated).map(at).collect::<Vec<_>>().join(" ")
    };
    for (expected, factor, wanted) in [
        (&exact, 1.0, Verdict::UnexpectedFailure),
        (&bounded, 0.5, Verdict::UnexpectedFailure),
        (&failure, 0.5, Verdict::UnexpectedFailure),
        (&bounded, 2.0, Verdict::UnexpectedSuccess),
        (&failure, 2.0, Verdict::UnexpectedSuccess),
        (&bounded, 1.0, Verdict::Bounded),
        (&failure, 1.0, Verdict::KnownFailure),
    ] {
        let (verdict, text) = verdict(needles, candidate(bvh_cpu(), needles, expected, &times(factor)));
        assert_eq!(verdict, wanted, "{text}");
    }
    assert_eq!(verdict(case, candidate(bvh_cpu(), case, &exact, "")).0, Verdict::Exact);
    // What is not stated is shown as such: no expectation, or no share; and where a difficulty level has none it is said.
    let nothing = Candidate { expected: Vec::new(), ..candidate(bvh_cpu(), case, &exact, "") };
    for unstated in [nothing, candidate(bvh_cpu(), case, &failure, "")] {
        let (verdict, text) = verdict(case, unstated);
        assert!(verdict == Verdict::Unstated && text.contains("unstated"), "{text}");
    }
    let (verdict, text) = verdict(case, candidate(bvh_cpu(), case, &bounded, "45:0 80:0 87:0 89:0 89.8:0 89.98:-"));
    assert_eq!(verdict, Verdict::Bounded, "{text}");
    assert!(text.contains("not judged from 89.98 degrees on: no share is stated"), "{text}");
}

/// Proves that a tracer which refuses or fails is an unexpected failure with its reason.
#[test]
fn no_answers_are_a_failure() {
    let case = find("edge-on").unwrap();
    // An oracle that knows no rays.
    let expected = expectation(r#"{"kind": "bounded", "rule": "hit_miss", "reason": "none"}"#);
    let oracle = Registration {
        description: || Control::Oracle.description(),
        create: |_| Ok(Control::Oracle.tracer(Vec::new(), 1.0)),
        ..bvh_cpu()
    };
    let (verdict, text) = verdict(case, candidate(oracle, case, &expected, "45:0"));
    assert_eq!(verdict, Verdict::UnexpectedFailure);
    assert!(text.contains("rays that it does not know"), "{text}");
}

/// Proves that a case without its difficulty is noticed: the harmless end in the place of the hard one.
#[test]
fn a_case_that_shows_nothing_is_noticed() {
    for case in CASES.iter() {
        let mut record = measured(case, &[]).case;
        assert_eq!(flaws(case, &record), Vec::<String>::new());
        record.difficulty_levels.truncate(1);
        assert_eq!(flaws(case, &record).len(), 1, "{}", case.name);
    }
}

/// Proves the reason given for `needles`: `bvh-cpu` loses rays onto shared edges (the even ones) and no others.
#[test]
fn needles_are_lost_on_edges() {
    let case = find("needles").unwrap();
    let setup = case.setup(8192.0);
    let session = Session { wrong_rays_per_cause: usize::MAX, ..prepare(case, &setup, None).unwrap() };
    let config = built(&session);
    let rays = &session.rays[0];
    let mut hits = session.hit_buffer(&config, rays).unwrap();
    session.sample_trace(&config, rays, &mut hits, 1).unwrap();
    let mut judgement = session.judge(&config, rays, &hits.read(None).unwrap()).unwrap();
    let wrong = judgement.wrong_rays_mut();
    assert!(wrong.len() > 50 && wrong.iter().all(|ray| ray.index % 2 == 0 && ray.class == "false_miss"));
}

/// Proves that `equal-triangles` overflows what it is for: `bvh-cpu`'s hierarchy is deeper than its fixed stack of 32.
#[test]
fn equal_triangles_make_hierarchies_deep() {
    let case = find("equal-triangles").unwrap();
    let setup = case.setup(*case.difficulty_parameter.values.last().unwrap());
    let session = prepare(case, &setup, None).unwrap();
    let config = built(&session);
    let statistics = config.structure().unwrap().validate(session.geometry()).unwrap();
    let depth = statistics.iter().find(|(name, _)| *name == "depth").unwrap().1;
    assert!(depth > 32.0, "{depth}");
}
