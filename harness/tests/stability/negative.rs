//! Negative controls: what is wrong is noticed, in both directions.

use super::*;
use tracebench_harness::cases::find;
use tracebench_harness::controls::Control;
use tracebench_harness::registry;
use tracebench_harness::session::Contender;
use tracebench_harness::stability::{Candidate, measure, prepare};
use tracebench_tests::{Fake, Manner};

/// `bvh-cpu` or a control in its place, with one expectation.
fn candidate(tracer: Option<Control>, case: &Case, expected: Expectation) -> Candidate {
    let contender = match tracer {
        Some(control) => {
            let parameters = Parameters::preset(&[], Preset::Published);
            Contender::ready(control.description(), parameters, control.tracer(Vec::new(), 1.0))
        }
        None => {
            let registration = registry::find("bvh-cpu").unwrap();
            let description = (registration.describe)();
            let parameters = Parameters::preset(&description.parameters, Preset::Published);
            let device = Err(tracebench_api::TracerError::Unavailable("no device is needed".to_owned()));
            Contender::create(description, parameters, || registration.create(&device)).unwrap()
        }
    };
    Candidate { label: "candidate".to_owned(), contender, expected: vec![(case.name, expected)] }
}

fn verdict(case: &Case, mut candidate: Candidate) -> (Verdict, String) {
    let record = measure(case, std::slice::from_mut(&mut candidate), None).unwrap();
    assert_eq!(record.void, None);
    let cell = &record.tracers[0];
    (cell.verdict, cell.text.clone())
}

/// Proves that a tracer which never hits is an unexpected failure on every case where exactness is expected.
#[test]
fn a_blind_tracer_fails_everything_exact() {
    for case in CASES {
        let parameters = Parameters::preset(&[], Preset::Published);
        let contender = Contender::ready(Control::AlwaysMiss.description(), parameters, Box::new(Fake(Manner::Honest)));
        let expected = vec![(case.name, Expectation::Exact)];
        let (verdict, text) = verdict(case, Candidate { label: "blind".to_owned(), contender, expected });
        assert_eq!(verdict, Verdict::UnexpectedFailure, "{}: {text}", case.name);
        assert!(text.contains(&format!("{}", case.knob.values[0])), "{text}");
    }
}

/// Proves that a falsified expectation fails in either direction, and names what was measured.
#[test]
fn falsified_expectations_fail() {
    let case = find("edge-on").unwrap();
    let failure = |from, below| Expectation::KnownFailure {
        rule: Rule::Tight,
        from,
        below,
        least_wrong: 0.2,
        reason: "none",
        source: "none",
    };
    // What never fails, said to fail.
    for from in [45.0, 89.98] {
        let (verdict, text) = verdict(case, candidate(None, case, failure(from, 0.0)));
        assert_eq!(verdict, Verdict::UnexpectedSuccess, "{text}");
        assert!(text.contains("89.98") && text.contains("20 %"), "{text}");
    }
    // What fails, said to be exact, bounded, or to fail later.
    let needles = find("needles").unwrap();
    let bounded = Expectation::Bounded { rule: Rule::HitMiss, most_wrong: 0.01, reason: "none" };
    for expected in [Expectation::Exact, bounded, failure(8192.0, 0.01)] {
        let (verdict, text) = verdict(needles, candidate(None, needles, expected));
        assert_eq!(verdict, Verdict::UnexpectedFailure, "{text}");
    }
    // What is true passes; what is not stated is shown as such.
    assert_eq!(verdict(case, candidate(None, case, Expectation::Exact)).0, Verdict::Exact);
    let nothing = Candidate { expected: Vec::new(), ..candidate(None, case, Expectation::Exact) };
    let (verdict, text) = verdict(case, nothing);
    assert!(verdict == Verdict::Unstated && text.contains("unstated"), "{text}");
}

/// Proves that a tracer which refuses or fails is an unexpected failure with its reason.
#[test]
fn no_answers_are_a_failure() {
    let case = find("edge-on").unwrap();
    // An oracle that knows no rays.
    let expected = Expectation::Bounded { rule: Rule::HitMiss, most_wrong: 0.99, reason: "none" };
    let (verdict, text) = verdict(case, candidate(Some(Control::Oracle), case, expected));
    assert_eq!(verdict, Verdict::UnexpectedFailure);
    assert!(text.contains("rays that it does not know"), "{text}");
}

/// Proves that a case without its difficulty is noticed: the harmless end in the place of the hard one.
#[test]
fn a_case_that_shows_nothing_is_noticed() {
    for case in CASES {
        let mut record = measure(case, &mut [], None).unwrap();
        assert_eq!(flaws(case, &record), Vec::<String>::new());
        record.strengths.truncate(1);
        assert_eq!(flaws(case, &record).len(), 1, "{}", case.name);
    }
}

/// Proves the reason given for `needles`: `bvh-cpu` loses rays onto shared edges (the even ones) and no others.
#[test]
fn needles_are_lost_on_edges() {
    let case = find("needles").unwrap();
    let setup = (case.make)(8192.0).unwrap();
    let session = prepare(case, &setup, None).unwrap();
    let mut contender = candidate(None, case, Expectation::Exact).contender;
    session.sample_build(&mut contender).unwrap();
    let rays = &session.rays[0];
    let mut hits = session.hit_buffer(&contender, rays).unwrap();
    session.sample_trace(&contender, rays, &mut hits).unwrap();
    let mut judgement = session.judge(&contender, rays, &hits.read(None).unwrap()).unwrap();
    let wrong = judgement.wrong_rays_mut();
    assert!(wrong.len() > 50 && wrong.iter().all(|ray| ray.index % 2 == 0 && ray.class == "false_miss"));
}

/// Proves that `equal-triangles` overflows what it is for: `bvh-cpu`'s hierarchy is deeper than its fixed stack of 32.
#[test]
fn equal_triangles_make_hierarchies_deep() {
    let case = find("equal-triangles").unwrap();
    let setup = (case.make)(*case.knob.values.last().unwrap()).unwrap();
    let session = prepare(case, &setup, None).unwrap();
    let mut contender = candidate(None, case, Expectation::Exact).contender;
    session.sample_build(&mut contender).unwrap();
    let statistics = contender.structure().unwrap().validate(session.geometry()).unwrap();
    let depth = statistics.iter().find(|(name, _)| *name == "depth").unwrap().1;
    assert!(depth > 32.0, "{depth}");
}
