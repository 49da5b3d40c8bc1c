//! Negative controls: what is wrong is noticed, in both directions.

use super::*;
use tracebench_harness::cases::find;
use tracebench_harness::contenders::Family;
use tracebench_harness::measure::Contender;
use tracebench_harness::measure::controls::Control;
use tracebench_harness::measure::session::Session;
use tracebench_harness::registry;
use tracebench_harness::studies::stability::{Candidate, CaseMatrix, measure, prepare};
use tracebench_tests::{Fake, Manner};

/// A tracer with one expectation.
fn candidate(registration: Registration, case: &Case, expected: Expectation) -> Candidate {
    let request = TracerRequest::of(&registration, Preset::Published);
    Candidate { request, expected: vec![(case.name, expected)] }
}

fn bvh_cpu() -> Registration {
    *registry::find("bvh-cpu").unwrap()
}

/// One that always misses.
fn blind() -> Registration {
    let describe = || Control::AlwaysMiss.description();
    Registration::sampled(describe, Family::Image, |_| Ok(Box::new(Fake(Manner::Honest))))
}

fn measured(case: &Case, candidates: &[Candidate]) -> CaseMatrix {
    let device = Err(tracebench_api::TracerError::Unavailable("no device is needed".to_owned()));
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    let run = measure(&[case], candidates, &Context::new(&device, &cache, &quiet, &journal)).unwrap();
    Stability::of(&run).unwrap().cases.remove(0)
}

fn verdict(case: &Case, candidate: Candidate) -> (Verdict, String) {
    let CaseMatrix { case, cells } = measured(case, &[candidate]);
    assert_eq!(case.void, None);
    (cells[0].verdict, cells[0].text.clone())
}

/// `bvh-cpu` built over a session's scene.
fn built(session: &Session) -> Contender {
    let registration = bvh_cpu();
    let description = (registration.describe)();
    let parameters = Parameters::preset(&description.parameters, Preset::Published);
    let device = Err(tracebench_api::TracerError::Unavailable("no device is needed".to_owned()));
    let mut contender = Contender::create(description, parameters, || registration.create(&device)).unwrap();
    session.sample_build(&mut contender).unwrap();
    contender
}

/// Proves that a tracer which never hits is an unexpected failure on every case where exactness is expected.
#[test]
fn a_blind_tracer_fails_everything_exact() {
    for case in CASES {
        let (verdict, text) = verdict(case, candidate(blind(), case, Expectation::Exact));
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
        let (verdict, text) = verdict(case, candidate(bvh_cpu(), case, failure(from, 0.0)));
        assert_eq!(verdict, Verdict::UnexpectedSuccess, "{text}");
        assert!(text.contains("89.98") && text.contains("20 %"), "{text}");
    }
    // What fails, said to be exact, bounded, or to fail later.
    let needles = find("needles").unwrap();
    let bounded = Expectation::Bounded { rule: Rule::HitMiss, most_wrong: 0.01, reason: "none" };
    for expected in [Expectation::Exact, bounded, failure(8192.0, 0.01)] {
        let (verdict, text) = verdict(needles, candidate(bvh_cpu(), needles, expected));
        assert_eq!(verdict, Verdict::UnexpectedFailure, "{text}");
    }
    // What is true passes; what is not stated is shown as such.
    assert_eq!(verdict(case, candidate(bvh_cpu(), case, Expectation::Exact)).0, Verdict::Exact);
    let nothing = Candidate { expected: Vec::new(), ..candidate(bvh_cpu(), case, Expectation::Exact) };
    let (verdict, text) = verdict(case, nothing);
    assert!(verdict == Verdict::Unstated && text.contains("unstated"), "{text}");
}

/// Proves that a tracer which refuses or fails is an unexpected failure with its reason.
#[test]
fn no_answers_are_a_failure() {
    let case = find("edge-on").unwrap();
    // An oracle that knows no rays.
    let expected = Expectation::Bounded { rule: Rule::HitMiss, most_wrong: 0.99, reason: "none" };
    let oracle = Registration::sampled(
        || Control::Oracle.description(),
        Family::Image,
        |_| Ok(Control::Oracle.tracer(Vec::new(), 1.0)),
    );
    let (verdict, text) = verdict(case, candidate(oracle, case, expected));
    assert_eq!(verdict, Verdict::UnexpectedFailure);
    assert!(text.contains("rays that it does not know"), "{text}");
}

/// Proves that a case without its difficulty is noticed: the harmless end in the place of the hard one.
#[test]
fn a_case_that_shows_nothing_is_noticed() {
    for case in CASES {
        let mut record = measured(case, &[]).case;
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
    let contender = built(&session);
    let rays = &session.rays[0];
    let mut hits = session.hit_buffer(&contender, rays).unwrap();
    session.sample_trace(&contender, rays, &mut hits, 1).unwrap();
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
    let contender = built(&session);
    let statistics = contender.structure().unwrap().validate(session.geometry()).unwrap();
    let depth = statistics.iter().find(|(name, _)| *name == "depth").unwrap().1;
    assert!(depth > 32.0, "{depth}");
}
