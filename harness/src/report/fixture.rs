//! Runs made up for tests, with the figures that real ones have.

mod fronts;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use tracebench_api::{AdapterInfo, ClockKind, DeviceLimits, HitBuffer, MemoryEntry, Query, Rasterizer, TraceTo};

pub(crate) use fronts::{FrontQuality, fronts};

use crate::files::OutputFolder;
use crate::machine::Machine;
use crate::report::{self, Report, ReportError, Tables};
use crate::results::{
    AnyJudgement, BuildRecord, ByRule, Classes, ClosestJudgement, CounterRecord, InterleavedSetRecord, Judgement,
    MemoryRecord, Occlusion, PerRule, Percentiles, PhaseRecord, PieceDistance, Provenance, Record, Row, Rule, SCHEMA,
    SampleSchedule, SceneRecord, Skipped, StatusCounts, StopReason, SurfaceDistance, Times, TraceRecord, TracerRecord,
    TrueCounts, ViewpointRecord, WrongRay,
};
use crate::statistics::{median, median_interval, wilson};

/// Writes a record and what derives from it into a folder that is opened for this.
pub(crate) fn write_run(record: &Record, folder: &Path, tables: Tables) -> Result<Vec<PathBuf>, ReportError> {
    report::write_run(record, &OutputFolder::open(folder)?, tables)
}

/// Writes what derives from a record into a folder that is opened for this.
pub(crate) fn write_derived(record: &Record, folder: &Path, tables: Tables) -> Result<Vec<PathBuf>, ReportError> {
    report::write_derived(record, &OutputFolder::open(folder)?, tables)
}

/// Rows of a table by their columns.
pub(crate) fn rows(folder: &Path, name: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(folder.join(name)).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| header.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    reader.records().map(|record| row(record.unwrap())).collect()
}

/// Those of configurations.
pub(crate) fn configs(folder: &Path) -> Vec<BTreeMap<String, String>> {
    rows(folder, "rows.csv").into_iter().filter(|row| row["role"] == "tracer").collect()
}

/// Rays of every set.
pub(crate) const COUNT: u64 = 131_072;
const TIES: u64 = 12;
/// Rays whose truth is a hit.
const HITS: u64 = 117_000;

/// The ray sets that exist.
pub(crate) const SETS: [(&str, Query); 3] =
    [("primary", Query::Closest), ("diffuse", Query::Closest), ("ao", Query::Any)];

/// How good and how fast a made-up tracer is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quality {
    /// Share of the rays that truly hit and that it misses.
    pub missed: f64,
    /// Typical error of t, in scene diagonals.
    pub blur: f64,
    /// Million rays a second.
    pub speed: f64,
    /// Its clock.
    pub clock: ClockKind,
}

/// An analytic and a sampled tracer, the controls, three ray sets.
pub(crate) fn typical() -> Record {
    let exact = Quality { missed: 0.0, blur: 1e-9, speed: 3.1, clock: ClockKind::Host };
    let sampled = Quality { missed: 0.11, blur: 2e-4, speed: 11.0, clock: ClockKind::SubmitToDone };
    run(&[("bvh-cpu", exact), ("screen-dda", sampled)], &SETS)
}

/// Twelve tracers, some with long names, over five decades of speed, one without a wrong ray.
pub(crate) fn crowded() -> Record {
    let names = [
        "bvh-cpu",
        "bvh-gpu",
        "bvh-ray-query",
        "screen-dda",
        "screen-dda:improved",
        "height-field",
        "dirt",
        "dirt:improved",
        "fragment-abuffer",
        "voxel-abuffer",
        "quadtree with a most particular and very long name",
        "quadtree:improved",
    ];
    let clocks = [ClockKind::Host, ClockKind::DeviceTimestamps, ClockKind::DeviceTimestamps];
    let quality = |index: usize| Quality {
        missed: if index == 0 { 0.0 } else { 0.4 * 0.45_f64.powi(index as i32 % 7) },
        blur: [1e-9, 1e-7, 1e-5, 1e-4, 1e-3][index % 5],
        speed: 0.02 * 10_f64.powf(5.0 * index as f64 / 11.0),
        clock: clocks[index % 3],
    };
    let named: Vec<_> = names.iter().enumerate().map(|(index, name)| (*name, quality(index))).collect();
    run(&named, &SETS)
}

/// Configurations of given qualities on given ray sets, with the controls.
pub(crate) fn run(configs: &[(&str, Quality)], sets: &[(&str, Query)]) -> Record {
    let controls = [("oracle", 0.0, 0.0), ("always-miss", 1.0, 0.0), ("always-hit", 0.0, 0.3), ("corrupted", 0.0, 0.0)];
    Record {
        schema: SCHEMA,
        provenance: provenance(),
        seed: 20_260_101,
        preset: "quick".to_owned(),
        table: None,
        sweep: None,
        tuning: None,
        frames: None,
        cases: None,
        explanation: None,
        pareto: None,
        need: None,
        attack: None,
        judged: None,
        ray_parameters: BTreeMap::new(),
        control_names: crate::results::CONTROL_NAMES.map(str::to_owned).into(),
        controls: controls.iter().map(|(name, missed, blur)| control(name, *missed, *blur, sets)).collect(),
        rows: configs.iter().map(|(name, quality)| config(name, *quality, sets)).collect(),
        anchors: Vec::new(),
        interleaved_sets: std::iter::once("builds")
            .chain(sets.iter().map(|(rays, _)| *rays))
            .map(interleaved_set)
            .collect(),
        skipped: vec![Skipped {
            tracer: Some("bvh-ray-query".to_owned()),
            scene: "room".to_owned(),
            rays: None,
            reason: "not available on this machine: the adapter has no ray queries | none".to_owned(),
        }],
    }
}

/// Lets ambiguous rays count, of which each may hit and may miss.
pub(crate) fn judge_ambiguous(record: &mut Record) {
    for trace in record.rows.iter_mut().chain(&mut record.controls).flat_map(|one| &mut one.traces) {
        let Judgement::Closest(closest) = &mut trace.judgement else { continue };
        closest.agreement_without_ambiguous = Some(closest.agreement);
        closest.truth = Some(TrueCounts {
            hits: HITS,
            misses: COUNT - TIES - HITS,
            ambiguous_hits: TIES,
            ambiguous_misses: 0,
            ambiguous_may_miss: TIES,
        });
        for classes in [&mut closest.classes.tight, &mut closest.classes.footprint] {
            let hits = classes.true_hit + classes.early + classes.late;
            *(if hits > 0 { &mut classes.true_hit } else { &mut classes.true_miss }) += TIES;
        }
        score(closest);
    }
}

/// An interleaved set in which nothing drifts.
pub(crate) fn interleaved_set(work: &str) -> InterleavedSetRecord {
    InterleavedSetRecord {
        scene: "room".to_owned(),
        viewpoint: "door".to_owned(),
        resident_batch: 0,
        work: work.to_owned(),
        participants: Vec::new(),
        order_seed: 1,
        orders: Vec::new(),
        each_round: "the same rays".to_owned(),
        warm_up_rounds: 1,
        sampling: SampleSchedule::rounds(20),
        stop_reason: StopReason::Rounds,
        sampled_s: 1.0,
        widest_interval: None,
        clock_ticks: None,
        kernels: Vec::new(),
        drift: false,
        doubled_work: Vec::new(),
        repeated_because: None,
    }
}

/// Where nothing was measured.
pub(crate) fn provenance() -> Provenance {
    Provenance {
        machine: machine(),
        commit: "0123456789abcdef0123456789abcdef01234567".to_owned(),
        dirty: Some(true),
        launch: None,
        started: "2031-05-06T07:08:09Z".to_owned(),
        rules_version: 2,
        resumed: Vec::new(),
        plan_sha256: None,
        shard: None,
        further_machines: Vec::new(),
        converted_from: None,
    }
}

fn machine() -> Machine {
    Machine {
        cpu: "Example Processor Model 9000 @ 2.60GHz".to_owned(),
        threads: 2,
        memory_bytes: Some(16 << 30),
        os: "Linux 6.1".to_owned(),
        rustc: "rustc 1.88.0".to_owned(),
        adapter: Some(AdapterInfo {
            name: "llvmpipe (LLVM 15.0.6, 256 bits)".to_owned(),
            backend: "vulkan".to_owned(),
            kind: "software".to_owned(),
            driver: "llvmpipe".to_owned(),
            driver_version: "Mesa 22.3.6".to_owned(),
            max_storage_binding_bytes: 128 << 20,
            max_buffer_bytes: 1 << 30,
            max_texture_edge: 8192,
            max_storage_buffers_per_stage: 16,
            timestamps: true,
            limits: DeviceLimits::Adapter,
        }),
        rasterizer: Some(Rasterizer {
            snap_pixels: 0.002,
            depth_error: 1e-6,
            depth_error_beyond_view: 1e-5,
            reach: 1e5,
        }),
    }
}

fn scene() -> SceneRecord {
    SceneRecord {
        name: "room".to_owned(),
        sha256: "5e884898da28047151d0e56f8dc6292773603d0d6aabbdd62a11ef721d1542d8".to_owned(),
        triangles: 156_034,
        diagonal: 9.81,
        scale: Some(1.0),
        zero_area_triangles_dropped: 3,
        duplicate_triangles_kept: 1,
        warnings: vec!["alpha masks are ignored".to_owned()],
    }
}

fn viewpoint() -> ViewpointRecord {
    ViewpointRecord {
        name: "door".to_owned(),
        eye: [0.5, 1.6, -2.0],
        forward: [0.0, 0.0, 1.0],
        up: [0.0, 1.0, 0.0],
        vertical_fov_degrees: 60.0,
        near: 0.05,
        far: 50.0,
        frame: [512, 256],
        face: 256,
        ray_image: [512, 256],
        time_s: 0.0,
        ray_parameters: BTreeMap::new(),
    }
}

/// A run with first and steady builds, of 8 and 2 times as long as the phases by the host's clock.
pub(crate) fn with_whole_builds(mut record: Record) -> Record {
    for build in record.rows.iter_mut().chain(&mut record.anchors).map(|row| &mut row.build) {
        let samples = build.times.submit_to_done_samples_ms.iter().chain(&build.times.samples_ms);
        let samples: Vec<f64> = samples.take(build.times.samples_ms.len()).copied().collect();
        let quality = Quality { missed: 0.0, blur: 0.0, speed: 1.0, clock: ClockKind::Host };
        let whole = |factor: f64| {
            let samples: Vec<f64> = samples.iter().map(|ms| factor * ms).collect();
            Some(Box::new(times(quality, &samples, Vec::new(), 0)))
        };
        (build.first, build.steady) = (whole(8.0), whole(2.0));
    }
    record
}

fn control(name: &str, missed: f64, blur: f64, sets: &[(&str, Query)]) -> Row {
    let quality = Quality { missed, blur, speed: 1.0, clock: ClockKind::Host };
    let mut row = config(name, quality, sets);
    row.tracer.preset = "control".to_owned();
    row.build.times.samples_ms.clear();
    row.build.times.phases.clear();
    for trace in &mut row.traces {
        trace.times.samples_ms.clear();
        trace.counters.clear();
        if name == "always-hit" {
            answer_hit(&mut trace.judgement);
        }
        if name == "corrupted" {
            corrupt(&mut trace.judgement);
        }
    }
    row
}

/// Makes a verdict that of a tracer which never says miss.
fn answer_hit(judgement: &mut Judgement) {
    match judgement {
        Judgement::Closest(judgement) => {
            let misses = judgement.classes.tight.true_miss;
            for classes in [&mut judgement.classes.tight, &mut judgement.classes.footprint] {
                (classes.true_miss, classes.false_hit) = (0, misses);
                (classes.early, classes.true_hit) = (classes.early + classes.true_hit, 0);
            }
            score(judgement);
            judgement.curve.iter_mut().for_each(|point| point[1] = (point[0] * 2.0).min(1.0) * 0.6);
        }
        Judgement::Any(judgement) => {
            let occlusion = &mut judgement.occlusion;
            (occlusion.true_free, occlusion.false_occluded) = (0, occlusion.true_free);
            (occlusion.balanced_accuracy, occlusion.balanced_accuracy_interval) = (Some(0.5), Some([0.5, 0.5]));
        }
    }
}

/// Makes a verdict of an oracle that of one which is wrong with one ray of eight.
fn corrupt(judgement: &mut Judgement) {
    match judgement {
        Judgement::Closest(judgement) => {
            let misses = COUNT - TIES - HITS;
            let (missed, invented) = (HITS.div_ceil(8), misses.div_ceil(8));
            for classes in [&mut judgement.classes.tight, &mut judgement.classes.footprint] {
                (classes.true_hit, classes.false_miss) = (HITS - missed, missed);
                (classes.true_miss, classes.false_hit) = (misses - invented, invented);
            }
            score(judgement);
        }
        Judgement::Any(judgement) => {
            let table = &mut judgement.occlusion;
            let (occluded, free) = (table.true_occluded, table.true_free);
            let (missed, invented) = (occluded.div_ceil(8), free.div_ceil(8));
            (table.true_occluded, table.false_free) = (occluded - missed, missed);
            (table.true_free, table.false_occluded) = (free - invented, invented);
            (table.balanced_accuracy, table.balanced_accuracy_interval) =
                balanced([(occluded - missed, occluded), (free - invented, free)]);
        }
    }
}

fn config(name: &str, quality: Quality, sets: &[(&str, Query)]) -> Row {
    let (name, preset) = name.split_once(':').unwrap_or((name, "published"));
    let samples: Vec<f64> = (0..20).map(|index| 40.0 + f64::from(index * 7 % 10)).collect();
    let phase = |name: &str| PhaseRecord {
        name: name.to_owned(),
        median_ms: median(&samples) / 2.0,
        samples_ms: samples.iter().map(|sample| sample / 2.0).collect(),
    };
    Row {
        fingerprint: crate::machine::fingerprint(name).map(str::to_owned),
        scene: scene(),
        viewpoint: viewpoint(),
        tracer: TracerRecord {
            name: name.to_owned(),
            preset: preset.to_owned(),
            parameters: BTreeMap::from([("stride".to_owned(), serde_json::json!(1))]),
            changed: Vec::new(),
            residency: if quality.clock == ClockKind::Host { "host" } else { "device" }.to_owned(),
        },
        update_mode: None,
        difficulty_level: None,
        resident_batch: 0,
        machine: 0,
        memory: MemoryRecord {
            structure: vec![MemoryEntry { name: "nodes".to_owned(), allocated_bytes: 7 << 20, used_bytes: 6 << 20 }],
            structure_bytes: 7 << 20,
            geometry_bytes: 3_500_000,
            build_peak_bytes: 11 << 20,
        },
        structure_statistics: BTreeMap::from([("nodes".to_owned(), 4321.0), ("sah_cost".to_owned(), 57.25)]),
        build: BuildRecord {
            times: times(quality, &samples, vec![phase("sort"), phase("collapse")], 0),
            first: None,
            steady: None,
            setup_ms: 12.5,
        },
        traces: sets.iter().enumerate().map(|(index, (rays, query))| trace(rays, *query, index, quality)).collect(),
    }
}

fn times(quality: Quality, samples: &[f64], phases: Vec<PhaseRecord>, interleaved_set: u32) -> Times {
    let (interval_ms, interval_coverage) = median_interval(samples);
    Times {
        clock: quality.clock,
        samples_ms: samples.to_vec(),
        median_ms: median(samples),
        interval_ms,
        interval_coverage,
        phases,
        submit_to_done_median_ms: (quality.clock != ClockKind::Host).then(|| median(samples) + 0.3),
        timestamps_refused: false,
        grown_samples: 0,
        submit_to_done_samples_ms: match quality.clock {
            ClockKind::Host => Vec::new(),
            _ => samples.iter().map(|sample| sample + 0.3).collect(),
        },
        interleaved_set: Some(interleaved_set),
        invalid: None,
        anchor_scale: None,
    }
}

fn trace(rays: &str, query: Query, index: usize, quality: Quality) -> TraceRecord {
    let speed = quality.speed / (1.0 + 0.6 * index as f64);
    let jitter = |sample: i32| 1.0 + 0.02 * f64::from(sample * 3 % 10 - 5);
    let samples: Vec<f64> = (0..20).map(|sample| COUNT as f64 / (speed * 1e3) * jitter(sample)).collect();
    let counter = CounterRecord { total: COUNT * 37, per_ray: 37.0, max_per_ray: Some(412) };
    TraceRecord {
        rays: rays.to_owned(),
        rays_sha256: format!("{index:064x}"),
        query,
        count: COUNT,
        trace_to: TraceTo::Hit,
        times: times(quality, &samples, Vec::new(), index as u32 + 1),
        mrays_per_s: COUNT as f64 / (median(&samples) * 1e3),
        per_trace_bytes: COUNT * 52,
        per_trace: HitBuffer::memory(TraceTo::Hit, COUNT as usize),
        hits_sha256: format!("{:064x}", index + 7),
        same_as_first: None,
        counters: BTreeMap::from([("nodes".to_owned(), counter)]),
        statuses: BTreeMap::from([("hit".to_owned(), HITS), ("miss".to_owned(), COUNT - HITS)]),
        judgement: match query {
            Query::Closest => Judgement::Closest(closest(quality)),
            Query::Any => Judgement::Any(any(quality)),
        },
        surfaces: None,
        self_reported: None,
    }
}

/// Share of hits nearer than a tolerance, for a typical error.
fn within(tolerance: f64, blur: f64) -> f64 {
    if blur == 0.0 { 1.0 } else { tolerance / (tolerance + 0.3 * blur) }
}

fn closest(quality: Quality) -> ClosestJudgement {
    let misses = COUNT - TIES - HITS;
    let classes = |tolerance: f64| {
        let false_miss = (HITS as f64 * quality.missed) as u64;
        let off = ((HITS - false_miss) as f64 * (1.0 - within(tolerance, quality.blur))) as u64;
        Classes {
            true_hit: HITS - false_miss - off,
            true_miss: misses,
            false_hit: 0,
            false_miss,
            early: off / 3,
            late: off - off / 3,
        }
    };
    let hit = (1.0 - quality.missed) * HITS as f64;
    let curve = (0..=28).map(|step| 10_f64.powf(-7.0 + 0.25 * f64::from(step)));
    let agreement = |tolerance: f64| (hit * within(tolerance, quality.blur) + misses as f64) / (COUNT - TIES) as f64;
    let mut judgement = ClosestJudgement {
        classes: ByRule { tight: classes(1e-5), footprint: classes(1e-3) },
        ambiguous_rays: TIES,
        many_ambiguous_rays: false,
        agreement: PerRule::default(),
        agreement_without_ambiguous: None,
        truth: None,
        interval: PerRule::default(),
        curve: curve.map(|tolerance| [tolerance, agreement(tolerance)]).collect(),
        position_error: Percentiles {
            p50: Some(quality.blur),
            p95: Some(quality.blur * 5.0),
            p99: Some(quality.blur * 12.0),
        },
        surface_distance: Some(surface_distance(quality)),
        identity: (quality.blur < 1e-6).then_some(1.0),
        by_status: BTreeMap::new(),
        causes: BTreeMap::new(),
        wrong_rays: wrong_rays(quality),
    };
    score(&mut judgement);
    let Classes { true_hit, true_miss, false_miss, early, late, .. } = judgement.classes.tight;
    judgement.by_status = BTreeMap::from([
        ("hit".to_owned(), status(true_hit + early + late, true_hit)),
        ("miss".to_owned(), status(true_miss + false_miss, true_miss)),
    ]);
    let counts = |wrong: u64| {
        let shares = [("hidden_layer", 2), ("off_view", 3), ("between_samples", 5), ("self_hit", 9)];
        shares.iter().map(|(cause, part)| ((*cause).to_owned(), wrong / part)).collect::<BTreeMap<_, _>>()
    };
    let rules = [("tight", &judgement.classes.tight), ("footprint", &judgement.classes.footprint)];
    judgement.causes = rules.map(|(rule, classes)| (rule.to_owned(), counts(classes.false_miss + classes.late))).into();
    judgement
}

/// Of so many rays so many are right, by `tight`; by the other rules as many.
fn status(rays: u64, right: u64) -> StatusCounts {
    StatusCounts { rays, right: Rule::ALL.iter().map(|rule| (rule.name().to_owned(), right)).collect() }
}

fn surface_distance(quality: Quality) -> SurfaceDistance {
    let told = (1.0 - quality.missed) * within(1e-3, quality.blur);
    // What samples has texels.
    let own_texel = (quality.blur > 1e-6).then_some(2e-3);
    SurfaceDistance {
        rays: HITS,
        common_texel: 1e-3,
        within_common_texel: Some(told),
        own_texel,
        within_own_texel: own_texel.map(|texel| (1.0 - quality.missed) * within(texel, quality.blur)),
        distance: Percentiles {
            p50: Some(quality.blur / 2.0),
            p95: Some(quality.blur * 2.0),
            p99: Some(quality.blur * 6.0),
        },
        pieces: vec![PieceDistance {
            piece: 0,
            first_triangle: 0,
            triangles: 12,
            open: false,
            mean_thickness: Some(0.25),
            rays: HITS,
            within_common_texel_rays: (told * HITS as f64) as u64,
            within_own_texel_rays: own_texel
                .map(|texel| ((1.0 - quality.missed) * within(texel, quality.blur) * HITS as f64) as u64),
        }],
    }
}

/// Fills in shares and intervals from the classes.
fn score(judgement: &mut ClosestJudgement) {
    let trials = COUNT - judgement.left_out();
    let tight = judgement.classes.tight.true_hit + judgement.classes.tight.true_miss;
    let footprint = judgement.classes.footprint.true_hit + judgement.classes.footprint.true_miss;
    let hit_miss = trials - judgement.classes.tight.false_hit - judgement.classes.tight.false_miss;
    let share = |right: u64| Some(right as f64 / trials as f64);
    judgement.agreement = PerRule { hit_miss: share(hit_miss), tight: share(tight), footprint: share(footprint) };
    judgement.interval = PerRule {
        hit_miss: wilson(hit_miss, trials),
        tight: wilson(tight, trials),
        footprint: wilson(footprint, trials),
    };
}

/// The balanced accuracy with its interval, of the right answers among all, of either kind.
fn balanced(right: [(u64, u64); 2]) -> (Option<f64>, Option<[f64; 2]>) {
    let share = right.iter().map(|(right, all)| *right as f64 / *all as f64).sum::<f64>() / 2.0;
    let [one, other] = right.map(|(right, all)| wilson(right, all).unwrap());
    (Some(share), Some([f64::midpoint(one[0], other[0]), f64::midpoint(one[1], other[1])]))
}

fn any(quality: Quality) -> AnyJudgement {
    let occluded = 40_000;
    let free = COUNT - TIES - occluded;
    let false_free = (occluded as f64 * quality.missed) as u64;
    let (balanced_accuracy, balanced_accuracy_interval) = balanced([(occluded - false_free, occluded), (free, free)]);
    AnyJudgement {
        occlusion: Occlusion {
            true_occluded: occluded - false_free,
            true_free: free,
            false_occluded: 0,
            false_free,
            balanced_accuracy,
            balanced_accuracy_interval,
        },
        ambiguous_rays: TIES,
        many_ambiguous_rays: false,
        by_status: BTreeMap::new(),
        causes: BTreeMap::from([("occlusion".to_owned(), BTreeMap::from([("off_view".to_owned(), false_free)]))]),
        wrong_rays: wrong_rays(quality),
    }
}

fn wrong_rays(quality: Quality) -> Vec<WrongRay> {
    let ray = |index: u64| WrongRay {
        index,
        origin: [0.1, 0.2, 0.3],
        direction: [0.0, 0.0, 1.0],
        t_min: 0.0,
        t_max: 1e30,
        true_t: Some(1.25),
        true_primitive: Some(7),
        answered_t: index.is_multiple_of(2).then_some(1.5),
        answered_primitive: None,
        status: "miss".to_owned(),
        class: "false_miss".to_owned(),
        cause: "hidden, \"layer\"".to_owned(),
        ambiguous: false,
    };
    if quality.missed > 0.0 { (0..5).map(ray).collect() } else { Vec::new() }
}

/// The table of peers that a run was made for.
pub(crate) fn tables(record: &Record) -> Result<Report, ReportError> {
    let table = record.table.as_deref().and_then(|name| crate::peers::all().find(|table| table.name == name));
    Ok(table.map(|table| super::peers::report(table, record)).unwrap_or_default())
}
