//! Every figure of a trace that tables and charts show: its name, unit, which way is better, and where it is found.

use crate::results::{AnyJudgement, ClosestJudgement, Judgement, SurfaceDistance, TraceRecord, TracerRun};

/// Which way is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Better {
    /// More is better.
    Higher,
    /// Less is better.
    Lower,
    /// Neither: it describes.
    Neither,
}

/// A column of tables for programs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column {
    /// Its name, with the unit at its end.
    pub name: &'static str,
    /// Its value, `None` where the trace has none.
    pub value: fn(&TracerRun, &TraceRecord) -> Option<f64>,
}

/// A figure that people read too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Metric {
    /// Where it is found, and its name in tables for programs.
    pub column: Column,
    /// Name for people.
    pub label: &'static str,
    /// Unit; empty for shares.
    pub unit: &'static str,
    /// Which way is better.
    pub better: Better,
}

impl Metric {
    /// Label with unit, and an arrow the way that is better: a table's heading.
    pub(crate) fn heading(&self) -> String {
        let arrow = match self.better {
            Better::Higher => " ↑",
            Better::Lower => " ↓",
            Better::Neither => "",
        };
        format!("{}{arrow}", self.axis())
    }

    /// Label with unit: an axis's name.
    pub(super) fn axis(&self) -> String {
        if self.unit.is_empty() { self.label.to_owned() } else { format!("{} ({})", self.label, self.unit) }
    }
}

const fn metric(
    column: &'static str,
    label: &'static str,
    unit: &'static str,
    better: Better,
    value: fn(&TracerRun, &TraceRecord) -> Option<f64>,
) -> Metric {
    Metric { column: Column { name: column, value }, label, unit, better }
}

const fn column(name: &'static str, value: fn(&TracerRun, &TraceRecord) -> Option<f64>) -> Column {
    Column { name, value }
}

/// Traces a second.
pub(crate) const SPEED: Metric = metric("mrays_per_s", "speed", "Mrays/s", Better::Higher, |_, trace| speed(trace));
/// Time of a trace.
pub(crate) const TRACE_TIME: Metric =
    metric("median_ms", "median time", "ms", Better::Lower, |_, trace| timed(trace, trace.times.median_ms));
/// Time of a build.
pub(crate) const BUILD_TIME: Metric = metric("build_median_ms", "build time", "ms", Better::Lower, |run, _| {
    (!run.build.times.samples_ms.is_empty()).then_some(run.build.times.median_ms)
});
/// Right about hit or miss.
pub(super) const HIT_MISS: Metric =
    metric("agreement_hit_miss_share", "hit_miss", "", Better::Higher, |_, trace| closest(trace)?.agreement.hit_miss);
/// Right by the analytic rule.
pub(super) const TIGHT: Metric =
    metric("agreement_tight_share", "tight", "", Better::Higher, |_, trace| closest(trace)?.agreement.tight);
/// Right within a pixel.
pub(super) const FOOTPRINT: Metric =
    metric("agreement_footprint_share", "footprint", "", Better::Higher, |_, trace| {
        closest(trace)?.agreement.footprint
    });
/// How far hits are off.
pub(super) const POSITION_P50: Metric =
    metric("position_error_p50_scene_units", "position error p50", "scene units", Better::Lower, |_, trace| {
        closest(trace)?.position_error.p50
    });
/// Told hits near the piece of mesh that is truly hit.
pub(super) const WITHIN_TEXEL: Metric =
    metric("within_common_texel_share", "within a common texel", "", Better::Higher, |_, trace| {
        distance(trace)?.within_common_texel
    });
/// The same by the tracer's own texel.
pub(super) const WITHIN_OWN_TEXEL: Metric =
    metric("within_own_texel_share", "within a texel of its own", "", Better::Higher, |_, trace| {
        distance(trace)?.within_own_texel
    });
/// The right triangle.
pub(super) const IDENTITY: Metric =
    metric("identity_share", "identity", "", Better::Higher, |_, trace| closest(trace)?.identity);
/// Rays left out.
pub(super) const TIES: Metric =
    metric("ties_rays", "ties", "rays", Better::Neither, |_, trace| Some(ties(&trace.judgement) as f64));
/// Right about occlusion.
pub(super) const BALANCED: Metric =
    metric("balanced_accuracy_share", "balanced accuracy", "", Better::Higher, |_, trace| {
        any(trace)?.occlusion.balanced_accuracy
    });
/// Surfaces that are right.
pub(super) const SURFACES: Metric =
    metric("surface_agreement_share", "surfaces", "", Better::Higher, |_, trace| trace.surfaces.as_ref()?.agreement);
/// Allocated bytes of the structure.
pub(super) const STRUCTURE: Metric =
    metric("structure_bytes", "structure", "MiB", Better::Lower, |run, _| Some(run.memory.structure_bytes as f64));
/// Geometry needed beside the structure.
pub(super) const GEOMETRY: Metric =
    metric("geometry_bytes", "geometry", "MiB", Better::Lower, |run, _| Some(run.memory.geometry_bytes as f64));
/// The most held while building.
pub(super) const BUILD_PEAK: Metric =
    metric("build_peak_bytes", "build peak", "MiB", Better::Lower, |run, _| Some(run.memory.build_peak_bytes as f64));

/// Every scalar of a trace, in the order of the table's columns. Shares are 0 to 1.
pub(super) const COLUMNS: &[Column] = &[
    column("count_rays", |_, trace| Some(trace.count as f64)),
    TIES.column,
    SPEED.column,
    column("mrays_per_s_low", |_, trace| Some(speed_interval(trace)?[0])),
    column("mrays_per_s_high", |_, trace| Some(speed_interval(trace)?[1])),
    TRACE_TIME.column,
    column("median_low_ms", |_, trace| timed(trace, trace.times.interval_ms[0])),
    column("median_high_ms", |_, trace| timed(trace, trace.times.interval_ms[1])),
    column("interval_coverage_share", |_, trace| timed(trace, trace.times.interval_coverage)),
    column("samples", |_, trace| Some(trace.times.samples_ms.len() as f64)),
    column("per_trace_bytes", |_, trace| Some(trace.per_trace_bytes as f64)),
    BUILD_TIME.column,
    column("build_low_ms", |run, _| Some(built(run)?.times.interval_ms[0])),
    column("build_high_ms", |run, _| Some(built(run)?.times.interval_ms[1])),
    column("setup_ms", |run, _| Some(run.build.setup_ms)),
    STRUCTURE.column,
    GEOMETRY.column,
    BUILD_PEAK.column,
    HIT_MISS.column,
    column("agreement_hit_miss_low_share", |_, trace| Some(closest(trace)?.interval.hit_miss?[0])),
    column("agreement_hit_miss_high_share", |_, trace| Some(closest(trace)?.interval.hit_miss?[1])),
    TIGHT.column,
    column("agreement_tight_low_share", |_, trace| Some(closest(trace)?.interval.tight?[0])),
    column("agreement_tight_high_share", |_, trace| Some(closest(trace)?.interval.tight?[1])),
    FOOTPRINT.column,
    column("agreement_footprint_low_share", |_, trace| Some(closest(trace)?.interval.footprint?[0])),
    column("agreement_footprint_high_share", |_, trace| Some(closest(trace)?.interval.footprint?[1])),
    POSITION_P50.column,
    column("position_error_p95_scene_units", |_, trace| closest(trace)?.position_error.p95),
    column("position_error_p99_scene_units", |_, trace| closest(trace)?.position_error.p99),
    WITHIN_TEXEL.column,
    WITHIN_OWN_TEXEL.column,
    column("surface_distance_p50_scene_units", |_, trace| distance(trace)?.distance.p50),
    column("surface_distance_p95_scene_units", |_, trace| distance(trace)?.distance.p95),
    column("surface_distance_p99_scene_units", |_, trace| distance(trace)?.distance.p99),
    IDENTITY.column,
    column("tight_true_hit_rays", |_, trace| Some(closest(trace)?.classes.tight.true_hit as f64)),
    column("tight_true_miss_rays", |_, trace| Some(closest(trace)?.classes.tight.true_miss as f64)),
    column("tight_false_hit_rays", |_, trace| Some(closest(trace)?.classes.tight.false_hit as f64)),
    column("tight_false_miss_rays", |_, trace| Some(closest(trace)?.classes.tight.false_miss as f64)),
    column("tight_early_rays", |_, trace| Some(closest(trace)?.classes.tight.early as f64)),
    column("tight_late_rays", |_, trace| Some(closest(trace)?.classes.tight.late as f64)),
    column("footprint_true_hit_rays", |_, trace| Some(closest(trace)?.classes.footprint.true_hit as f64)),
    column("footprint_true_miss_rays", |_, trace| Some(closest(trace)?.classes.footprint.true_miss as f64)),
    column("footprint_false_hit_rays", |_, trace| Some(closest(trace)?.classes.footprint.false_hit as f64)),
    column("footprint_false_miss_rays", |_, trace| Some(closest(trace)?.classes.footprint.false_miss as f64)),
    column("footprint_early_rays", |_, trace| Some(closest(trace)?.classes.footprint.early as f64)),
    column("footprint_late_rays", |_, trace| Some(closest(trace)?.classes.footprint.late as f64)),
    BALANCED.column,
    column("balanced_accuracy_low_share", |_, trace| Some(any(trace)?.occlusion.balanced_accuracy_interval?[0])),
    column("balanced_accuracy_high_share", |_, trace| Some(any(trace)?.occlusion.balanced_accuracy_interval?[1])),
    column("true_occluded_rays", |_, trace| Some(any(trace)?.occlusion.true_occluded as f64)),
    column("true_free_rays", |_, trace| Some(any(trace)?.occlusion.true_free as f64)),
    column("false_occluded_rays", |_, trace| Some(any(trace)?.occlusion.false_occluded as f64)),
    column("false_free_rays", |_, trace| Some(any(trace)?.occlusion.false_free as f64)),
    SURFACES.column,
    column("surface_agreement_low_share", |_, trace| Some(trace.surfaces.as_ref()?.interval?[0])),
    column("surface_agreement_high_share", |_, trace| Some(trace.surfaces.as_ref()?.interval?[1])),
    column("surface_judged_rays", |_, trace| Some(trace.surfaces.as_ref()?.judged as f64)),
    column("surface_lost_rays", |_, trace| Some(trace.surfaces.as_ref()?.lost as f64)),
    column("surface_material_share", |_, trace| trace.surfaces.as_ref()?.material),
    column("surface_normal_share", |_, trace| trace.surfaces.as_ref()?.normal),
    column("surface_position_share", |_, trace| trace.surfaces.as_ref()?.position),
    column("surface_normal_error_p50_degrees", |_, trace| trace.surfaces.as_ref()?.normal_error_degrees.p50),
    column("surface_normal_error_p95_degrees", |_, trace| trace.surfaces.as_ref()?.normal_error_degrees.p95),
    column("surface_normal_error_p99_degrees", |_, trace| trace.surfaces.as_ref()?.normal_error_degrees.p99),
    column("surface_position_error_p50_scene_units", |_, trace| trace.surfaces.as_ref()?.position_error.p50),
    column("surface_position_error_p95_scene_units", |_, trace| trace.surfaces.as_ref()?.position_error.p95),
    column("surface_position_error_p99_scene_units", |_, trace| trace.surfaces.as_ref()?.position_error.p99),
];

/// The verdict, if it is one on a closest-hit set.
pub(super) fn closest(trace: &TraceRecord) -> Option<&ClosestJudgement> {
    match &trace.judgement {
        Judgement::Closest(judgement) => Some(judgement),
        Judgement::Any(_) => None,
    }
}

/// How far told hits are from the mesh; of any-hit sets, and of records from before it was told, nothing.
pub(super) fn distance(trace: &TraceRecord) -> Option<&SurfaceDistance> {
    closest(trace)?.surface_distance.as_ref()
}

/// The verdict, if it is one on an any-hit set.
pub(super) fn any(trace: &TraceRecord) -> Option<&AnyJudgement> {
    match &trace.judgement {
        Judgement::Any(judgement) => Some(judgement),
        Judgement::Closest(_) => None,
    }
}

/// Rays whose truth hangs on rounding.
pub(super) fn ties(judgement: &Judgement) -> u64 {
    match judgement {
        Judgement::Closest(judgement) => judgement.ties,
        Judgement::Any(judgement) => judgement.ties,
    }
}

/// Rays that count.
pub(crate) fn trials(trace: &TraceRecord) -> u64 {
    trace.count.saturating_sub(ties(&trace.judgement))
}

/// Million rays a second, where something was timed.
pub(crate) fn speed(trace: &TraceRecord) -> Option<f64> {
    timed(trace, trace.mrays_per_s).filter(|speed| speed.is_finite() && *speed > 0.0)
}

/// The interval of the speed: of the median time, turned over.
pub(super) fn speed_interval(trace: &TraceRecord) -> Option<[f64; 2]> {
    let of = |ms: f64| trace.count as f64 / (ms * 1e3);
    let [fast, slow] = trace.times.interval_ms;
    let interval = [of(slow), of(fast)];
    let whole = speed(trace).is_some() && interval.iter().all(|end| end.is_finite() && *end > 0.0);
    whole.then_some(interval)
}

fn timed(trace: &TraceRecord, value: f64) -> Option<f64> {
    (!trace.times.samples_ms.is_empty() && trace.times.void.is_none()).then_some(value)
}

fn built(run: &TracerRun) -> Option<&crate::results::BuildRecord> {
    (!run.build.times.samples_ms.is_empty()).then_some(&run.build)
}
