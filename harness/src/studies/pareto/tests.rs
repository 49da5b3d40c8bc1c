//! Fronts over planted points, and a small study that is really measured.

use std::collections::BTreeSet;
use std::sync::Arc;

use tracebench_api::{ClockKind, Preset, Query, TraceTo, TracerError};

use super::*;
use crate::files::OutputFolder;
use crate::judge::WRONG_RAYS_PER_CAUSE;
use crate::measure::Journal;
use crate::plan::{SceneSource, TracerRequest};
use crate::progress::Progress;
use crate::rays::{RAY_SETS, default_parameters};
use crate::registry::{Registration, TRACERS};
use crate::report::fixture::{self, FrontQuality, Quality};
use crate::results::SampleSchedule;
use crate::truth::Cache;

const SETS: [(&str, Query); 2] = [("diffuse", Query::Closest), ("ao", Query::Any)];

fn planted(name: &str, missed: f64, speed: f64, mib: u64, build: f64) -> FrontQuality<'_> {
    let quality = Quality { missed, blur: 1e-4 * missed, speed, clock: ClockKind::DeviceTimestamps };
    FrontQuality { name, quality, mib, build }
}

/// Points of four tracers, some of them better in nothing.
fn several() -> Vec<FrontQuality<'static>> {
    vec![
        planted("a", 0.0, 1.0, 40, 4.0),
        planted("a:improved", 0.0, 2.0, 50, 5.0),
        planted("b", 0.2, 9.0, 8, 1.0),
        planted("b", 0.05, 7.0, 12, 1.5),
        planted("b", 0.3, 5.0, 20, 3.0),
        planted("c", 0.0004, 4.0, 30, 0.5),
        planted("d", 0.5, 0.5, 90, 9.0),
    ]
}

/// Every field, cost and rule of a run.
fn each(record: &Record, look: &mut dyn FnMut(&Field<'_>, Cost, By)) {
    let section = record.pareto.as_ref().unwrap();
    for field in section.scenes.iter().flat_map(|scene| fields(record, section, scene)) {
        for cost in Cost::all(&section.rays_per_pixel) {
            By::all(field.query).iter().for_each(|by| look(&field, cost, *by));
        }
    }
}

/// Proves that no point of any front is dominated by a measured one, of all tracers or its own, by costs and errors that are read from
/// the rows again; that every tracer has a front of its own; and that points elsewhere, of other images and of controls are in none.
#[test]
fn no_point_of_a_front_is_dominated() {
    // What is stored of a build before rules version 3 is the time from submission until done, whatever is asked.
    fronts_hold(&fixture::fronts(&several(), &SETS, 1.0), |row| [row.build.times.submit_to_done_median_ms.unwrap(); 2]);
}

/// The same where first builds are told from steady ones: what is built once pays the first, a frame the steady one.
#[test]
fn fronts_pay_for_the_right_build() {
    let record = fixture::with_whole_builds(fixture::fronts(&several(), &SETS, 1.0));
    fronts_hold(&record, |row| [&row.build.first, &row.build.steady].map(|times| times.as_ref().unwrap().median_ms));
}

fn fronts_hold(record: &Record, build_ms: fn(&Row) -> [f64; 2]) {
    let (mut looked, mut beaten) = (0, 0);
    each(record, &mut |field, cost, by| {
        assert_eq!(field.entries.len(), several().len());
        assert_eq!(field.tracers(), ["a", "b", "c", "d"]);
        let again = |entry: &Entry<'_>| {
            let row = entry.row;
            let trace_ms = entry.trace.times.submit_to_done_median_ms.unwrap();
            let [first_ms, steady_ms] = build_ms(row);
            let paid = match cost {
                Cost::Trace => trace_ms,
                Cost::Build => first_ms,
                Cost::Bytes => (row.memory.structure_bytes + row.memory.geometry_bytes) as f64,
                // The image has a pixel a ray.
                Cost::Frame(rays) => steady_ms + rays * trace_ms,
            };
            (paid, Wrong::of(entry.trace, by).unwrap().drawn())
        };
        let mut groups = vec![field.entries.clone()];
        groups.extend(field.tracers().into_iter().map(|tracer| field.of_tracer(tracer)));
        for entries in groups {
            let front_statuses = field.front_statuses(&entries, cost, by);
            let on = front_statuses.iter().filter(|(.., front_status)| *front_status == FrontStatus::OnFront);
            let on: Vec<_> = on.map(|(entry, ..)| *entry).collect();
            assert!(!on.is_empty());
            let is_beaten = |entry: &Entry<'_>| {
                let (paid, wrong) = again(entry);
                entries.iter().any(|other| {
                    let (theirs, errs) = again(other);
                    let cheaper = theirs <= paid * (1.0 - 1e-9) && errs <= wrong;
                    cheaper || (theirs <= paid && errs < wrong * (1.0 - 1e-9))
                })
            };
            for entry in &on {
                assert!(!is_beaten(entry), "{} by {by:?} and {cost:?}", entry.point.label());
            }
            // The check notices what is not on the front.
            beaten += entries.iter().filter(|entry| is_beaten(entry)).count();
            looked += on.len();
        }
        assert!(!field.controls.is_empty());
    });
    assert!(looked > 50 && beaten > 50, "{looked} {beaten}");
}

/// Proves that a configuration which is perfect and free has every front of all tracers to itself, whatever the cost and the rule, and that
/// one which is a control is in none of them.
#[test]
fn perfect_and_free_owns_every_front() {
    let mut points = several();
    points.push(planted("free", 0.0, 1e6, 0, 1e-3));
    let mut record = fixture::fronts(&points, &SETS, 1.0);
    // Its bytes are nothing at all.
    for row in record.rows.iter_mut().filter(|row| row.tracer.name == "free") {
        row.memory.geometry_bytes = 0;
        // What the fixture adds round a submission would be the greatest part of it.
        let times = row.traces.iter_mut().map(|trace| &mut trace.times).chain([&mut row.build.times]);
        for times in times {
            times.submit_to_done_samples_ms.clone_from(&times.samples_ms);
            times.submit_to_done_median_ms = Some(times.median_ms);
        }
    }
    let owners = |record: &Record| {
        let mut owners = BTreeSet::new();
        each(record, &mut |field, cost, by| {
            let all = field.front_statuses(&field.entries, cost, by);
            let on = all.iter().filter(|(.., front_status)| *front_status == FrontStatus::OnFront);
            owners.extend(on.map(|(entry, ..)| entry.point.tracer.clone()));
        });
        owners
    };
    assert_eq!(owners(&record).into_iter().collect::<Vec<_>>(), ["free"]);
    // Without it others are there; as a control it is no configuration.
    let free = record.rows.iter().filter(|row| row.tracer.name == "free").cloned().collect::<Vec<_>>();
    record.rows.retain(|row| row.tracer.name != "free");
    record.controls.extend(free);
    assert!(owners(&record).len() > 1 && !owners(&record).contains("free"));
}

/// Proves that an operating point is the cheapest of those that are right so often, by hand; that how far one gets is told where none
/// is; and that a check elsewhere tells what holds from what does not.
#[test]
fn operating_points_are_the_cheapest() {
    let record = fixture::fronts(&several(), &SETS, 1.0);
    let section = record.pareto.as_ref().unwrap();
    let all = fields(&record, section, &section.scenes[0]);
    let field = all.iter().find(|field| field.rays == "diffuse").unwrap();
    let by = By::Rule(crate::results::Rule::HitMiss);
    let of = |level: f64, aim: Aim| best(field, &field.entries, by, level, aim).map(|found| found.point.label());
    assert_eq!(of(0.99, Aim::Fastest).as_deref(), Some("c stride=6"));
    assert_eq!(of(0.99, Aim::Smallest).as_deref(), Some("c stride=6"));
    assert_eq!(of(0.9999, Aim::Fastest).as_deref(), Some("a:improved stride=2"));
    assert_eq!(of(0.9999, Aim::Smallest).as_deref(), Some("a stride=1"));
    assert_eq!(of(0.5, Aim::Smallest).as_deref(), Some("b stride=3"));
    let own = field.of_tracer("b");
    assert!(Aim::ALL.iter().all(|aim| best(field, &own, by, 0.99, *aim).is_none()));
    assert_eq!(farthest(field, &own, by).unwrap().point.label(), "b stride=4");
    let all = chosen(&all);
    // Whatever is best of its tracer, and how far d gets, which is never good enough.
    assert!(
        all.contains(&0) && all.contains(&1) && all.contains(&5) && all.contains(&6) && !all.contains(&4),
        "{all:?}"
    );
    let held_out = |worse: f64| {
        let record = fixture::fronts(&several(), &SETS, worse);
        let section = record.pareto.as_ref().unwrap();
        let fields = fields(&record, section, &section.scenes[0]);
        check(&fields[0], &section.points[5], by, 0.999)
    };
    assert!(matches!(held_out(1.0), Check::Holds(_)), "{:?}", held_out(1.0));
    // As many as were asked for are wrong: so many rays cannot tell.
    assert!(matches!(held_out(2.5), Check::WithinNoise(_)), "{:?}", held_out(2.5));
    let Check::Misses(wrong, missed) = held_out(40.0) else { panic!("{:?}", held_out(40.0)) };
    assert!((missed - (wrong.share.value - 0.001)).abs() < 1e-12 && missed > 0.01);
    let alone = Field { elsewhere: None, ..field.clone() };
    assert_eq!(check(&alone, &section.points[5], by, 0.999), Check::NotMeasured);
}

/// Proves that only points of one class are set against one another, that a class has the lines of its points, and that the break-even
/// is where the medians say: between the quick build and the quick trace.
#[test]
fn classes_are_of_points_that_are_right_as_often() {
    let points = [
        planted("slow build", 0.0001, 40.0, 40, 4.0),
        planted("slow trace", 0.0001, 4.0, 50, 0.01),
        planted("often wrong", 0.4, 400.0, 50, 0.01),
    ];
    let record = fixture::with_whole_builds(fixture::fronts(&points, &SETS[..1], 1.0));
    let section = record.pareto.as_ref().unwrap();
    let field = &fields(&record, section, &section.scenes[0])[0];
    let by = By::Rule(crate::results::Rule::HitMiss);
    for class in classes(field, by, 0.99) {
        assert_eq!(class.tracers(), ["slow build", "slow trace"]);
        let who: Vec<usize> = class.stretches.iter().map(|stretch| stretch.who).collect();
        match class.motion {
            // Without a build the quick trace is always ahead.
            Motion::Static => assert_eq!(who, [0]),
            Motion::Refitted | Motion::Rebuilt => assert_eq!(who, [1, 0]),
        }
        let [one, other] = &class.costs[..] else { panic!("two") };
        let at = |cost: &ClassCost<'_>, rays: f64| cost.cost.at(rays).value;
        let expected = |cost: &ClassCost<'_>| {
            let once = if class.motion == Motion::Static {
                0.0
            } else {
                cost.entry.row.build.steady.as_ref().unwrap().median_ms
            };
            once + on_host(&cost.entry.trace.times).unwrap().value
        };
        for cost in [one, other] {
            let (found, expected) = (at(cost, field.count as f64), expected(cost));
            assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
            assert!(!cost.refitted && cost.cost.caveat.is_none(), "{:?}", cost.cost.caveat);
        }
    }
    assert!(classes(field, by, 0.99999).iter().all(|class| class.costs.is_empty()));
    // Fewer rounds than a verdict needs decide nothing.
    let mut few = record.clone();
    for row in &mut few.rows {
        row.build.all_mut().for_each(|times| times.samples_ms.truncate(5));
    }
    let section = few.pareto.as_ref().unwrap();
    let fields = fields(&few, section, &section.scenes[0]);
    let found = classes(&fields[0], by, 0.99);
    let undecided = |stretch: &Stretch| matches!(stretch.overtakes, Some(BreakEven::Undecided(_)));
    assert!(found.iter().any(|class| class.stretches.iter().any(undecided)));
}

fn plan() -> Plan {
    let host = |registration: &&Registration| !registration.needs_device();
    let both = |registration: &'static Registration| {
        Preset::ALL.into_iter().map(move |preset| TracerRequest::of(registration, preset))
    };
    let smoke = RunPreset::named("smoke").unwrap();
    Plan {
        scenes: vec![SceneSource::Catalogue("room".to_owned())],
        tracers: TRACERS.iter().filter(host).flat_map(both).collect(),
        ray_sets: RAY_SETS.iter().filter(|set| ["diffuse", "ao"].contains(&set.name)).copied().collect(),
        ray_parameters: default_parameters(),
        preset: RunPreset { ray_image: [16, 8], sampling: SampleSchedule::rounds(2), ..smoke },
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 7,
        trace_to: TraceTo::Hit,
        builds_timed: true,
        wrong_rays_per_cause: WRONG_RAYS_PER_CAUSE,
        table: None,
    }
}

/// Proves that a study measures every point from the viewpoint, and those that are chosen elsewhere with other rays, from smaller images
/// and refitted; that what is gone on with is the same; and that a shard of other scenes measures nothing.
#[test]
fn chosen_points_are_measured_again() {
    let none = Err(TracerError::Unavailable("none is needed".to_owned()));
    let (cache, quiet) = (Cache::none(), Progress::new(true));
    let folder = tempfile::tempdir().unwrap();
    let results = Arc::new(OutputFolder::open(folder.path()).unwrap());
    let machine = crate::machine::this_machine(None);
    let extent = Extent { max_points: 3, rays_per_pixel: RAYS_PER_PIXEL.to_vec() };
    let words = serde_json::json!("the same");
    let measured = |journal: &Journal| {
        let context = Context::new(&none, &cache, &quiet, journal);
        Pareto::new(&plan(), &extent).unwrap().execute(&context).unwrap()
    };
    let journal = Journal::begin(&results, &words, &machine, None).unwrap();
    let record = measured(&journal);
    drop(journal);
    let section = record.pareto.as_ref().unwrap();
    assert_eq!((section.points.len(), section.scenes.len()), (3, 1));
    let scene = &section.scenes[0];
    let fields = fields(&record, section, scene);
    assert!(fields.len() == 2 && fields.iter().all(|field| field.entries.len() == 3));
    let chosen = chosen(&fields);
    assert!(!chosen.is_empty());
    let held_out = scene.held_out.as_ref().unwrap();
    assert!(held_out.seed == record.seed + FURTHER_SEED && held_out.viewpoint.eye != scene.viewpoint.eye);
    for here in &fields {
        let field = here.elsewhere.as_ref().unwrap();
        let there: BTreeSet<usize> = field.entries.iter().map(|entry| entry.index).collect();
        assert_eq!(there, chosen);
        assert!(here.entries[0].trace.rays_sha256 != field.entries[0].trace.rays_sha256);
    }
    // What is not asked of a place is not timed there: of smaller images builds, elsewhere anything.
    for row in record.rows.iter().filter(|row| row.update_mode.is_none()) {
        let [is_here, is_smaller] =
            [scene.viewpoint.ray_image == row.viewpoint.ray_image, scene.ray_images.contains(&row.viewpoint.ray_image)];
        assert_eq!(row.build.steady.is_some(), is_here);
        assert!(row.traces.iter().all(|trace| trace.times.samples_ms.is_empty() != (is_here || is_smaller)));
    }
    assert_eq!(scene.ray_images, [[8, 4], [4, 2]]);
    for entry in fields[0].entries.iter().filter(|entry| chosen.contains(&entry.index)) {
        let refitted = refit(&record, scene, entry).unwrap();
        assert!(refitted.traces.is_empty() && refitted.build.times.samples_ms.len() == 2);
    }
    // Two rounds decide nothing.
    let classes = classes(&fields[0], By::Rule(crate::results::Rule::Tight), 0.99);
    assert!(classes.iter().flat_map(|class| &class.costs).all(|cost| cost.cost.caveat.is_some()));
    let journal = Journal::resume(&results, &words, &machine).unwrap();
    let again = measured(&journal);
    assert_eq!(
        (&again.rows, &again.interleaved_sets, &again.pareto),
        (&record.rows, &record.interleaved_sets, &record.pareto)
    );
    let other = crate::results::ShardRecord::here(2, 2, String::new());
    let quiet_journal = Journal::none();
    let mut context = Context::new(&none, &cache, &quiet, &quiet_journal);
    context.shard = Some(other);
    let empty = Pareto::new(&plan(), &extent).unwrap().execute(&context).unwrap();
    assert!(empty.rows.is_empty() && empty.pareto.unwrap().scenes.is_empty());
}
