//! Every verb that judges, over an oracle and tracers with planted faults.

use std::path::Path;

use super::faults::Fault;
use super::*;
use tracebench_api::{TraceTo, TracerError};
use tracebench_harness::cases::find;
use tracebench_harness::files::OutputFolder;
use tracebench_harness::judge::WRONG_RAYS_PER_CAUSE;
use tracebench_harness::measure::execute_all;
use tracebench_harness::plan::{Plan, RunPreset, SceneSource, ViewRequest};
use tracebench_harness::rays::{RAY_SETS, default_parameters};
use tracebench_harness::report::{MAX_BYTES, Makers, html_page, write_derived};
use tracebench_harness::results::{AxisRecord, Judgement, SampleSchedule, TraceRecord};
use tracebench_harness::studies::explain;
use tracebench_harness::studies::need;
use tracebench_harness::studies::pareto::{Extent, Pareto};
use tracebench_harness::studies::stability::{Candidate, measure};
use tracebench_harness::studies::sweep::{Sweep, parameter_axis};
use tracebench_harness::{papers, tables};

/// A few rays in a small scene.
fn plan(scene: &str, tracers: &[TracerRequest]) -> Plan {
    let preset = RunPreset::named("smoke").unwrap();
    let sampling = SampleSchedule::rounds(1);
    Plan {
        scenes: vec![SceneSource::Catalogue(scene.to_owned())],
        tracers: tracers.to_vec(),
        ray_sets: RAY_SETS.iter().filter(|set| ["diffuse", "ao"].contains(&set.name)).copied().collect(),
        ray_parameters: default_parameters(),
        preset: RunPreset { ray_image: [24, 16], frame: [24, 16], face: 8, sampling, scene_scale: 0.02, ..preset },
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        trace_to: TraceTo::Hit,
        builds_timed: true,
        wrong_rays_per_cause: WRONG_RAYS_PER_CAUSE,
        table: None,
    }
}

fn axis(request: &TracerRequest) -> AxisRecord {
    parameter_axis(request, &request.registration.describe().parameters[0], None).unwrap()
}

/// A verb at its smallest, once over all tracers or once for each.
type Verb = fn(&[TracerRequest], &Context<'_>) -> Vec<Record>;

const VERBS: &[(&str, Verb)] = &[
    ("run", |tracers, context| vec![execute_all(&[plan("candy", tracers)], context).unwrap()]),
    ("sweep", |tracers, context| {
        let sweep = |request: &TracerRequest| {
            let plan = plan("candy", std::slice::from_ref(request));
            Sweep::new(&plan, vec![axis(request)], false).unwrap().execute(context).unwrap()
        };
        tracers.iter().map(sweep).collect()
    }),
    ("pareto", |tracers, context| {
        let extent = Extent { max_points: 2, rays_per_pixel: vec![1.0] };
        vec![Pareto::new(&plan("candy", tracers), &extent).unwrap().execute(context).unwrap()]
    }),
    ("need", |tracers, context| vec![need::execute(&plan("candy", tracers), context).unwrap()]),
    ("sweep --choose", |tracers, context| {
        let sweep = |request: &TracerRequest| {
            let plan = plan("candy", std::slice::from_ref(request));
            let sweep = Sweep::new(&plan, vec![axis(request)], false).unwrap();
            sweep.choosing(Rule::Tight).execute(context).unwrap()
        };
        tracers.iter().map(sweep).collect()
    }),
    ("explain", |tracers, context| {
        let explain = |request: &TracerRequest| {
            let plan = plan("candy", std::slice::from_ref(request));
            explain::execute(&plan, request, &request.registration.remedies, context).unwrap()
        };
        tracers.iter().map(explain).collect()
    }),
    ("stability", |tracers, context| {
        let case = find("leaves").unwrap();
        let candidate = |request: &TracerRequest| Candidate {
            request: request.clone(),
            expected: vec![(case.name, serde_json::from_str(r#"{"kind": "exact", "rule": "tight"}"#).unwrap())],
            column: String::new(),
            shares: Arc::default(),
        };
        vec![measure(&[case], &tracers.iter().map(candidate).collect::<Vec<_>>(), context).unwrap()]
    }),
    ("table bvh", |tracers, context| {
        vec![execute_all(&[Plan { table: Some("bvh"), ..plan("candy", tracers) }], context).unwrap()]
    }),
];

/// The share of rays that are right under `tight`, or of any-hit ones by all.
fn right(trace: &TraceRecord) -> f64 {
    match &trace.judgement {
        Judgement::Closest(closest) => closest.agreement.tight.unwrap(),
        Judgement::Any(any) => {
            let of = &any.occlusion;
            let right = of.true_occluded + of.true_free;
            right as f64 / (right + of.false_occluded + of.false_free) as f64
        }
    }
}

/// How the pages of a verb write how many rays are right, or wrong.
fn shown(verb: &str, trace: &TraceRecord) -> Vec<String> {
    let (shares, wrong) = match &trace.judgement {
        Judgement::Closest(closest) => {
            let (of, classes) = (&closest.agreement, &closest.classes.tight);
            let wrong = classes.false_hit + classes.false_miss + classes.early + classes.late;
            ([of.tight, of.footprint, of.hit_miss].into_iter().flatten().collect(), wrong)
        }
        Judgement::Any(any) => {
            let of = &any.occlusion;
            (vec![of.balanced_accuracy.unwrap()], of.false_occluded + of.false_free)
        }
    };
    match verb {
        "explain" => vec![format!("| {wrong} |")],
        "stability" => shares.iter().map(|share| format!(" {:.0} %", 100.0 - 100.0 * share)).collect(),
        _ => {
            shares.iter().flat_map(|share| [*share, 1.0 - share]).map(|share| format!("{:.2}", 100.0 * share)).collect()
        }
    }
}

/// The pages of a record.
fn pages(run: &Record, folder: &Path) -> String {
    let paths = write_derived(run, &OutputFolder::open(folder).unwrap(), tables::of_run).unwrap();
    let pages = paths.iter().filter(|path| path.extension().is_some_and(|end| end == "md"));
    pages.map(|path| std::fs::read_to_string(path).unwrap()).collect()
}

/// Proves that every verb that judges, and the page that `reproduce` makes of their records, shows an oracle as right in every row, and as
/// less right, by a share between none and all, a tracer that is blind, one that errs on every tenth ray, and one whose structure lacks
/// every third triangle.
#[test]
fn every_verb_shows_planted_faults() {
    let device = Err(TracerError::Unavailable("no device is needed".to_owned()));
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    let context = Context::new(&device, &cache, &quiet, &journal);
    let request = |fault: Fault| TracerRequest::of(&fault.registration(), Preset::Published);
    let tracers = Fault::ALL.map(request);
    let folder = tempfile::TempDir::new().unwrap();
    let mut records = Vec::new();
    let mut missing = Vec::new();
    for (verb, measure) in VERBS {
        for run in measure(&tracers, &context) {
            let page = pages(&run, folder.path());
            for fault in Fault::ALL {
                let rows = || run.rows.iter().filter(|row| row.tracer.name == fault.name());
                for trace in rows().flat_map(|row| &row.traces) {
                    let right = right(trace);
                    // A handful of rays may all be right, or all wrong, by chance.
                    let fits = match fault {
                        Fault::None => right == 1.0,
                        _ => trace.count < 100 || (right > 0.0 && right < 1.0),
                    };
                    if !fits {
                        missing.push(format!("{verb}, {fault:?}, {}: {right} of {}", trace.rays, trace.count));
                    }
                }
                let said: Vec<String> =
                    rows().flat_map(|row| &row.traces).flat_map(|trace| shown(verb, trace)).collect();
                if fault != Fault::None && !said.is_empty() && !said.iter().any(|share| page.contains(share)) {
                    missing.push(format!("{verb}, {fault:?}: none of {said:?} in\n{page}"));
                }
            }
            records.push((verb.to_string(), run));
        }
        let of_verb = records.iter().filter(|(name, _)| name == verb);
        let names: Vec<&str> = of_verb.flat_map(|(_, run)| &run.rows).map(|row| row.tracer.name.as_str()).collect();
        assert!(Fault::ALL.iter().all(|fault| names.contains(&fault.name())), "{verb}: {names:?}");
    }
    let makers: Makers = (tables::of_run, papers::claims_of);
    let html = html_page(&records, &[], makers, "tracebench report", MAX_BYTES).unwrap().html;
    for (verb, run) in &records {
        let faulty = run.rows.iter().filter(|row| row.tracer.name != Fault::None.name());
        let said: Vec<String> = faulty.flat_map(|row| &row.traces).flat_map(|trace| shown(verb, trace)).collect();
        let cell = |text: &String| text.replace("| ", ">").replace(" |", "<");
        if !said.is_empty() && !said.iter().any(|share| html.contains(&cell(share))) {
            missing.push(format!("the page of all, {verb}: none of {said:?}"));
        }
    }
    assert_eq!(missing, Vec::<String>::new(), "{}", missing.join("\n"));
}
