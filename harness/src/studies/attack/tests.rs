//! That planted faults are found and made small, that searches repeat, and that a longer one begins with the shorter one.

use std::sync::{Arc, LazyLock};

use rayon::ThreadPoolBuilder;
use serde_json::json;
use tracebench_api::{
    Counter, Geometry, Hit, HitBuffer, MemoryReport, Parameters, PhaseClock, Preset, Status, Structure, TraceJob,
    TraceTo, Tracer, TracerDescription, TracerError, Update, Viewpoint,
};

use super::shrink::minimal;
use super::*;
use crate::files::OutputFolder;
use crate::judge::WRONG_RAYS_PER_CAUSE;
use crate::machine;
use crate::measure::Journal;
use crate::measure::controls::Control;
use crate::plan::SceneSource;
use crate::progress::Progress;
use crate::rays::sampling::Stream;
use crate::rays::{HOSTILE, RAY_SETS, default_parameters};
use crate::registrations::{Create, Registration, Told};
use crate::registry::Device;
use crate::report;
use crate::results::Row;
use crate::truth::{Answer, Cache, MOVES, Ray64, TrueHit, Truth, nearest_point};
use crate::viewpoint::Pose;

/// What a tracer does that answers the truth else.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    /// Nothing.
    None,
    /// It loses the triangle with [`LOST`]'s corners.
    Lost,
    /// Its hits in the last tenth of the bounds along x are a tenth too far.
    Far,
    /// It refuses all rays.
    Refusing,
}

/// Corners of a triangle of the small room: 99 of 100 are smaller.
static LOST: LazyLock<[[f32; 3]; 3]> = LazyLock::new(|| {
    let mesh = tracebench_scenes::procedural("room", 0.05).unwrap().mesh;
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = corners(&mesh.positions, triangle).map(glam::Vec3::from);
        (b - a).cross(c - a).length()
    };
    let mut triangles = mesh.triangles.clone();
    triangles.sort_by(|one, other| area(one).total_cmp(&area(other)));
    corners(&mesh.positions, &triangles[triangles.len() * 99 / 100])
});

/// The corners of a triangle.
fn corners(positions: &[[f32; 3]], triangle: &[u32; 3]) -> [[f32; 3]; 3] {
    triangle.map(|vertex| positions[vertex as usize])
}

/// The x from which on hits are too far.
fn border(geometry: &Geometry) -> f64 {
    let (low, high) = (geometry.bounds_min.x, geometry.bounds_max.x);
    f64::from(low) + 0.9 * f64::from(high - low)
}

struct Planted {
    fault: Fault,
    truth: Option<Truth>,
}

impl Tracer for Planted {
    fn build(
        &self,
        geometry: &Geometry,
        _: &Viewpoint,
        _: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        clock.host_phase("nothing", || ());
        let is_lost = |one: &[u32; 3]| self.fault == Fault::Lost && corners(&geometry.positions, one) == *LOST;
        let triangles = geometry.triangles.iter().filter(|triangle| !is_lost(triangle)).copied().collect();
        let kept = Geometry::new(geometry.positions.to_vec(), triangles, None)?;
        Ok(Box::new(Self { fault: self.fault, truth: Some(Truth::new(&kept, "planted")) }))
    }
}

impl Structure for Planted {
    fn update(
        &mut self,
        _: Update,
        _: &Geometry,
        _: &Viewpoint,
        _: &Parameters,
        _: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        Ok(())
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        if self.fault == Fault::Refusing {
            return Err(TracerError::Unsupported("rays of any kind".to_owned()));
        }
        let truth = self.truth.as_ref().unwrap();
        let border = border(truth.geometry());
        let answer = |ray: &tracebench_api::Ray| {
            let ray = Ray64::from(ray);
            let Some(hit) = truth.closest(&ray) else { return Hit::miss(Status::Miss) };
            let is_far = self.fault == Fault::Far && ray.at(hit.t).x > border;
            let t = if is_far { 1.1 * hit.t } else { hit.t } as f32;
            Hit { t, primitive: hit.primitive, u: 0.0, v: 0.0, status: Status::Hit as u32 }
        };
        let hits = hits.host_mut(job.rays.host.len())?;
        clock.host_phase("answer", || {
            hits.iter_mut().zip(job.rays.host.iter()).for_each(|(hit, ray)| *hit = answer(ray));
        });
        Ok(())
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.trace(job, hits, &mut PhaseClock::new(None))?;
        Ok(Vec::new())
    }

    fn memory(&self) -> MemoryReport {
        MemoryReport::default()
    }

    fn validate(&self, _: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        Ok(Vec::new())
    }
}

fn planted(fault: Fault) -> TracerRequest {
    fn tracer(fault: Fault) -> Result<Box<dyn Tracer>, TracerError> {
        Ok(Box::new(Planted { fault, truth: None }))
    }
    fn described(name: &'static str) -> TracerDescription {
        TracerDescription { name, ..Control::AlwaysMiss.description() }
    }
    static TOLD: LazyLock<Told> = LazyLock::new(|| serde_json::from_str(r#"{"family": "bvh"}"#).unwrap());
    let (description, create): (fn() -> TracerDescription, Create) = match fault {
        Fault::None => (|| described("sound"), |_| tracer(Fault::None)),
        Fault::Lost => (|| described("losing"), |_| tracer(Fault::Lost)),
        Fault::Far => (|| described("far"), |_| tracer(Fault::Far)),
        Fault::Refusing => (|| described("refusing"), |_| tracer(Fault::Refusing)),
    };
    let registration = Registration { description, create, parts: None, told: &TOLD };
    TracerRequest::of(&registration, Preset::Published)
}

fn plan(tracers: &[TracerRequest], rays: RaySet) -> Plan {
    let preset = RunPreset { ray_image: [32, 16], ..RunPreset::named("smoke").unwrap() };
    Plan {
        scenes: vec![SceneSource::Catalogue("room".to_owned())],
        tracers: tracers.to_vec(),
        ray_sets: vec![rays],
        ray_parameters: default_parameters(),
        preset,
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        trace_to: TraceTo::Hit,
        builds_timed: true,
        wrong_rays_per_cause: WRONG_RAYS_PER_CAUSE,
        table: None,
    }
}

fn named(name: &str) -> RaySet {
    *RAY_SETS.iter().find(|set| set.name == name).unwrap()
}

fn diffuse() -> RaySet {
    named("diffuse")
}

fn options(trials: u32) -> AttackOptions {
    AttackOptions { rule: Rule::Tight, trials, budget: None, is_brief: false }
}

fn search(plan: &Plan, options: &AttackOptions, journal: &Journal) -> Result<Record, RunError> {
    let device: Device = Err(TracerError::Unavailable("none is needed".to_owned()));
    let (cache, quiet) = (Cache::none(), Progress::new(true));
    execute(plan, options, &Context::new(&device, &cache, &quiet, journal))
}

/// A journal in a new folder.
fn begun(folder: &std::path::Path) -> Journal {
    let results = Arc::new(OutputFolder::open(&folder.join("out")).unwrap());
    Journal::begin(&results, &Value::Null, &machine::this_machine(None), None).unwrap()
}

/// Proves that a tracer which loses one triangle of the room and one which is wrong in a tenth of its bounds are found out: from the pose that
/// is found fresh rays are wrong more often than from the scene's own viewpoint, and than from the worst of as many random poses. One ray and
/// at most eight triangles are left of what is wrong, the planted fault among them. A sound tracer has nothing to find. Rows from the poses
/// say the same.
#[test]
fn planted_faults_are_found_and_made_small() {
    let tracers = [Fault::Lost, Fault::Far, Fault::None].map(planted);
    let folder = tempfile::tempdir().unwrap();
    let journal = begun(folder.path());
    let record = search(&plan(&tracers, diffuse()), &options(128), &journal).unwrap();
    let attack = record.attack.as_ref().unwrap();
    let [lost, far, sound] = &attack.searches[..] else { panic!("{attack:?}") };
    // The interval of right answers to fresh rays.
    let right = |found: &SearchRecord, viewpoint: &str| {
        let trace = found.trace(&record, viewpoint).unwrap();
        attack.accuracy(trace).unwrap().interval.unwrap()
    };
    for found in [lost, far] {
        let worst = &found.found[0];
        assert!(worst.wrong > 0, "{found:?}");
        let of_found = right(found, &worst.viewpoint);
        for viewpoint in [attack.viewpoint_of(&found.scene), &found.random.viewpoint] {
            let there = right(found, viewpoint);
            assert!(of_found[1] < there[0], "{viewpoint}: {of_found:?} {there:?}");
        }
        assert!(found.found.iter().all(|pose| pose.shrunk.is_some() == (pose.wrong > 0)), "{found:?}");
        for pose in found.found.iter().chain([&found.random]) {
            let picture = folder.path().join("out/pictures").join(pose.picture.as_ref().unwrap());
            assert!(picture.is_file(), "{}", picture.display());
        }
        let small = worst.shrunk.as_ref().unwrap();
        assert!(small.rays == 1 && small.triangles <= 8, "{small:?}");
        // What was written is what the command reads, and its truth is that of the small scene.
        let name = format!("room_{}_diffuse_{}", found.tracer.name, worst.trial);
        let written = folder.path().join("out/attack").join(name);
        let set = exchange::read(&written).unwrap();
        let scene = exchange::scene(&written, &set.manifest).unwrap();
        assert_eq!(scene.mesh.triangles.len() as u64, small.triangles + small.markers);
        let answers = exchange::read_truth(&written, &set.manifest).unwrap();
        let truth = Truth::new(&Geometry::new(scene.mesh.positions, scene.mesh.triangles, None).unwrap(), "small");
        exchange::check_truth(&written, &truth, &set, &answers, 1).unwrap();
        // The fault is in what is left.
        let (geometry, hit) = (truth.geometry(), answers[0].hit.unwrap());
        match found.tracer.name == lost.tracer.name {
            true => assert_eq!(corners(&geometry.positions, &geometry.triangles[hit.primitive as usize]), *LOST),
            false => assert!(Ray64::from(&set.rays[0]).at(hit.t).x > border(geometry), "{hit:?}"),
        }
        let row = record.rows.iter().find(|row| row.tracer == found.tracer && row.viewpoint.name == worst.viewpoint);
        let seen = Pose::parse(&worst.view).unwrap().viewpoint(geometry, [8, 8], 8);
        let viewpoint = &row.unwrap().viewpoint;
        assert_eq!((seen.near, seen.far), (viewpoint.near, viewpoint.far));
        assert!(small.command.contains("--rays file:attack/room_") && small.command.contains(&worst.view));
    }
    assert!(sound.found.iter().all(|pose| pose.wrong == 0 && pose.shrunk.is_none()), "{sound:?}");
    let files = report::contents(&record, |_| Ok(report::Report::default())).unwrap();
    let page = String::from_utf8(files.into_iter().find(|(name, _)| name == "attack.md").unwrap().1).unwrap();
    for (tracer, worse) in [("losing", "yes"), ("far", "yes"), ("sound", "undecided")] {
        let row = page.lines().find(|line| line.contains(&format!("| {tracer} | 128 |")));
        assert!(row.unwrap_or_else(|| panic!("{page}")).contains(&format!("| {worse} |")), "{tracer}: {row:?}");
    }
    // What is wrong along x is much of what one sees.
    let share = far.found[0].wrong as f64 / far.found[0].judged as f64;
    assert!(share > 0.1, "{share}");
    let text = serde_json::to_vec(&record).unwrap();
    assert_eq!(Record::read(&text).unwrap(), record);
}

/// Proves that forty trials are the same on one thread and on two, with all answers and verdicts from the poses, and that a longer search
/// begins with the shorter one; another seed has others. One that was killed goes on with the trials that it kept, and finds the others.
#[test]
fn searches_repeat_whatever_the_threads() {
    let plan = plan(&[planted(Fault::Far)], diffuse());
    let brief = |trials: u32| AttackOptions { is_brief: true, ..options(trials) };
    let of = |threads: usize, seed: u64, trials: u32| {
        let plan = Plan { seed, ..plan.clone() };
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let record = pool.install(|| search(&plan, &brief(trials), &Journal::none())).unwrap();
        let told = |row: &Row| {
            let trace = &row.traces[0];
            (row.viewpoint.clone(), trace.rays_sha256.clone(), trace.hits_sha256.clone(), trace.judgement.clone())
        };
        (record.rows.iter().map(told).collect::<Vec<_>>(), record.attack.unwrap())
    };
    let (rows, attack) = of(1, 1, 40);
    assert_eq!(of(2, 1, 40), (rows, attack.clone()));
    assert_ne!(of(2, 2, 40).1.searches[0].trials_sha256, attack.searches[0].trials_sha256);
    let name = "001-trials";
    let trials = |trials: u32, kept: Option<&Trials>| {
        let folder = tempfile::tempdir().unwrap();
        // What is on the disk is what a process that goes on reads.
        let gone_on = || {
            let results = Arc::new(OutputFolder::open(&folder.path().join("out")).unwrap());
            Journal::resume(&results, &Value::Null, &machine::this_machine(None)).unwrap()
        };
        let mut journal = begun(folder.path());
        if let Some(kept) = kept {
            journal.keep(name, kept).unwrap();
            drop(journal);
            journal = gone_on();
        }
        search(&plan, &brief(trials), &journal).unwrap();
        drop(journal);
        let journal = gone_on();
        journal.read::<Trials>(name).unwrap().unwrap()
    };
    let (short, long) = (trials(10, None), trials(30, None));
    assert!(
        short.searched.len() == 10
            && long.searched[..10] == short.searched[..]
            && long.random[..10] == short.random[..]
    );
    // A kept trial that no pose can have tells that it was taken as it is.
    let (searched, mut random) = (long.searched[..7].to_vec(), long.random[..6].to_vec());
    random[0].wrong = random[0].judged;
    let whole = trials(30, Some(&Trials { searched, random: random.clone(), is_done: false }));
    assert_eq!(whole.searched, long.searched);
    assert_eq!((&whole.random[..6], &whole.random[6..]), (&random[..], &long.random[6..]));
}

/// Proves that the page has a table a ray set, in which every tracer has its agreement at the scene's own viewpoint, at the worst random pose
/// and at the worst pose found, each with its interval.
#[test]
fn the_page_has_every_tracer_at_three_viewpoints() {
    let sets = ["diffuse", "primary"];
    let ray_sets = sets.map(named).to_vec();
    let plan = Plan { ray_sets, ..plan(&[Fault::Far, Fault::None].map(planted), diffuse()) };
    let brief = AttackOptions { is_brief: true, ..options(2) };
    let record = search(&plan, &brief, &Journal::none()).unwrap();
    let files = report::contents(&record, |_| Ok(report::Report::default())).unwrap();
    let (_, page) = files.iter().find(|(name, _)| name == "attack.md").unwrap();
    let page = String::from_utf8(page.clone()).unwrap();
    for set in sets {
        let (_, below) = page.split_once(&format!("\n## {set}\n\n")).unwrap();
        let table: Vec<Vec<&str>> = below
            .lines()
            .take_while(|line| line.starts_with('|'))
            .map(|line| line.split('|').map(str::trim).collect())
            .collect();
        let place = |heading: &str| table[0].iter().position(|cell| *cell == heading).unwrap();
        let headings = [
            "tracer",
            "right at the scene's viewpoint",
            "at the worst of as many random poses",
            "at the worst pose found",
        ];
        let [tracer, shares @ ..] = headings.map(place);
        assert_eq!(table[2..].iter().map(|row| row[tracer]).collect::<Vec<_>>(), ["far", "sound"]);
        for row in &table[2..] {
            assert!(shares.iter().all(|share| row[*share].contains(" % [")), "{row:?}");
        }
    }
}

/// Proves that a search which its budget ended keeps its trials beside the record, and that gone on with it finds what one finds that ran through.
#[test]
fn a_budget_only_stops() {
    let plan = plan(&[planted(Fault::Far)], diffuse());
    let of = |trials: u32, budget: Option<Duration>| AttackOptions { is_brief: true, budget, ..options(trials) };
    // As long as it takes until a trial fits.
    let budgets = (0..8).map(|power| Duration::from_millis(200 << power));
    let stopped = |budget: Duration| {
        let folder = tempfile::tempdir().unwrap();
        let journal = begun(folder.path());
        let record = search(&plan, &of(100_000, Some(budget)), &journal).ok()?;
        assert!(journal.recorded() && Journal::is_in(&folder.path().join("out")));
        Some((folder, record.attack.unwrap().searches.remove(0).trials as u32))
    };
    let (folder, count) = budgets.map(stopped).find_map(|stopped| stopped).unwrap();
    assert!((1..100_000).contains(&count), "{count}");
    let results = Arc::new(OutputFolder::open(&folder.path().join("out")).unwrap());
    let journal = Journal::resume(&results, &Value::Null, &machine::this_machine(None)).unwrap();
    let kept = journal.read::<Trials>("001-trials").unwrap().unwrap();
    assert_eq!((kept.searched.len(), kept.random.len()), (count as usize, count as usize));
    let gone_on = search(&plan, &of(count + 3, None), &journal).unwrap();
    let through = search(&plan, &of(count + 3, None), &Journal::none()).unwrap();
    assert_eq!(gone_on.attack, through.attack);
    assert!(!journal.recorded() && !Journal::is_in(results.path()));
}

/// Proves that poses are admissible just where the eye is in the bounds and a hundredth of a diagonal clear of every triangle, and that of rays
/// a twentieth must start and hit and at most six of a hundred be ambiguous.
#[test]
fn poses_are_admissible_by_their_rules() {
    let plan = plan(&[planted(Fault::None)], diffuse());
    let device: Device = Err(TracerError::Unavailable("none is needed".to_owned()));
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    let context = Context::new(&device, &cache, &quiet, &journal);
    let poses = Poses::new(&plan, &plan.scenes[0], &context).unwrap();
    let mut stream = Stream::new(1, 99, 0);
    let mut counts = [0; 2];
    for _ in 0..300 {
        let candidate = poses.any(&mut stream).unwrap();
        let scene = poses.truth(&candidate).unwrap();
        let geometry = scene.truth.geometry();
        let eye = Pose::parse(&candidate.view()).unwrap().eye.as_dvec3();
        let triangles = (0..geometry.triangles.len() as u32).map(|of| geometry.corners(of).map(glam::Vec3::as_dvec3));
        let distances = triangles.map(|corners| (nearest_point(eye, corners) - eye).length());
        let clear = distances.fold(f64::INFINITY, f64::min) / scene.truth.diagonal();
        if (clear - 0.01).abs() > 1e-6 {
            assert_eq!(poses.admissible(&candidate).unwrap().is_some(), clear > 0.01, "{clear}");
            counts[usize::from(clear > 0.01)] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 10), "{counts:?}");
    let outside = json!({ "eye": [1e3, 0.0, 0.0], "target": [0.0, 0.0, 0.0], "time": 0, "scale": 0 });
    assert!(poses.admissible(&serde_json::from_value(outside).unwrap()).unwrap().is_none());
    // Of 512 pixels a twentieth are 25.6.
    let has_enough = |set: RaySet, count: usize, hits: usize, ambiguous: usize| {
        let hit = Some(TrueHit { t: 1.0, primitive: 0 });
        let answer = |place: usize| Answer {
            hit: hit.filter(|_| place < hits),
            perturbed: (place < ambiguous).then(|| Box::new([None; MOVES])),
        };
        let ray = tracebench_api::Ray { origin: [0.0; 3], t_min: 0.0, direction: [1.0, 0.0, 0.0], t_max: 1e30 };
        let rays = Arc::new(vec![ray; count]);
        poses.has_enough(&PreparedRays::new(set, (rays, Arc::new((0..count).map(answer).collect())), None, None))
    };
    assert!(has_enough(diffuse(), 26, 26, 0) && !has_enough(diffuse(), 25, 25, 0));
    assert!(has_enough(diffuse(), 100, 5, 0) && !has_enough(diffuse(), 100, 4, 0));
    assert!(
        has_enough(diffuse(), 100, 100, 6) && !has_enough(diffuse(), 100, 100, 7) && has_enough(HOSTILE, 100, 100, 90)
    );
}

/// Proves that hostile rays are searched though many are ambiguous, that a tracer which refuses is told of with its reason while others are
/// searched, and that refusals alone are an error, as is a budget of nothing.
#[test]
fn what_cannot_be_searched_is_said() {
    let tracers = [Fault::Refusing, Fault::None].map(planted);
    let record = search(&plan(&tracers, HOSTILE), &options(2), &Journal::none()).unwrap();
    assert_eq!(record.attack.unwrap().searches.len(), 1);
    assert!(
        record
            .skipped
            .iter()
            .any(|one| one.tracer.as_deref() == Some("refusing") && one.reason.contains("not supported"))
    );
    let refused = search(&plan(&tracers[..1], diffuse()), &options(2), &Journal::none()).unwrap_err();
    assert!(refused.to_string().contains("not supported"), "{refused}");
    let none = AttackOptions { budget: Some(Duration::ZERO), ..options(2) };
    let none = search(&plan(&tracers[1..], diffuse()), &none, &Journal::none()).unwrap_err();
    assert!(none.to_string().contains("budget"), "{none}");
}

/// Proves that delta debugging leaves just what must be there together, wherever it is, and one item where any one will do.
#[test]
fn delta_debugging_leaves_what_fails() {
    let all: Vec<u32> = (0..1000).collect();
    for wanted in [vec![0], vec![999], vec![17, 18], vec![3, 500, 501, 998]] {
        let mut tests = 0;
        let found = minimal(all.clone(), |part| {
            tests += 1;
            Ok(wanted.iter().all(|item| part.contains(item)))
        });
        assert_eq!(found.unwrap(), wanted);
        assert!(tests < 100, "{tests}");
    }
    assert_eq!(minimal(all.clone(), |part| Ok(!part.is_empty())).unwrap().len(), 1);
    assert_eq!(minimal(all.clone(), |_| Ok(false)).unwrap(), all);
}
