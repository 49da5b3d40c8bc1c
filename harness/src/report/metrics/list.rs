//! The figures: a new one stands where its column in `rows.csv` is to be.

use tracebench_api::Query::{self, Any, Closest};

use super::Better::{Higher, Lower, Neither};
use super::{
    Metric, any, closest, distance, metric, per_triangle, plain, right_of, speed, speed_interval, structure,
    structure_alone, timed, used_bytes, wrong_tight,
};
use crate::report::sheet::Cell;
use crate::results::{ByRule, Classes, Judgement, Occlusion, PerRule, SurfaceJudgement, Times, TraceRecord, host_ms};

/// Declares figures as constants, and all of them as the columns of a table.
macro_rules! figures {
    ($($(#[$doc:meta])* $name:ident = $metric:expr;)+) => {
        $($(#[$doc])* pub(crate) const $name: Metric = $metric;)+

        /// Every figure of a trace, in the order of the table's columns. Shares are 0 to 1.
        pub(crate) const METRICS: &[Metric] = &[$($name),+];
    };
}

figures! {
    COUNT = plain("count_rays", |trace| Some(trace.count.into()));
    AMBIGUOUS = metric(["ambiguous_rays", "ambiguous", "rays"], Neither, |trace| {
        Some(trace.judgement.ambiguous().into())
    });
    /// Traces a second.
    SPEED = metric(["mrays_per_s", "speed", "Mrays/s"], Higher, |trace| {
        Some(Cell::Measured(speed(trace)?, speed_interval(trace), 4))
    });
    TRACE_TIME = metric(["median_ms", "median time", "ms"], Lower, |trace| timed(trace, (&trace.times).into()));
    INTERVAL_COVERAGE = plain("interval_coverage_share", |trace| timed(trace, trace.times.interval_coverage.into()));
    TRACE_HOST = plain("trace_host_ms", |trace| Some(host_ms(&trace.times).into()));
    SAMPLES = plain("samples", |trace| Some((trace.times.samples_ms.len() as u64).into()));
    PER_TRACE = plain("per_trace_bytes", |trace| Some(trace.per_trace_bytes.into()));
    /// Time of a trace as a program that is no tracer of this suite tells of itself.
    SELF_REPORTED = metric(["self_reported_trace_ms", "self-reported time", "ms"], Neither, |trace| {
        Some(trace.self_reported.as_ref()?.trace_ms?.into())
    });
    SELF_REPORTED_BUILD = plain("self_reported_build_ms", |trace| Some(trace.self_reported.as_ref()?.build_ms?.into()));
    /// Time of the phases of a build, which records of before rules version 3 have alone.
    BUILD_TIME = structure(["build_median_ms", "build time", "ms"], Lower, |row| {
        Some(if row.build.steady.is_none() { (&row.build.times).into() } else { Cell::Absent })
    });
    /// Time of a first build, host clock.
    FIRST_BUILD = structure(["first_build_median_ms", "first build", "ms"], Lower, |row| built(&row.build.first));
    /// Time of a steady build, host clock.
    STEADY_BUILD = structure(["steady_build_median_ms", "steady build", "ms"], Lower, |row| built(&row.build.steady));
    /// Millions of triangles a second of a first build.
    BUILD_RATE = structure(["build_mtriangles_per_s", "build rate", "Mtriangles/s"], Higher, |row| {
        let times = row.build.first();
        let rate = |ms: f64| row.scene.triangles as f64 / (ms * 1e3);
        let [fast, slow] = times.interval_ms;
        (!times.samples_ms.is_empty() && fast > 0.0)
            .then(|| Cell::Measured(rate(times.median_ms), Some([rate(slow), rate(fast)]), 4))
    });
    BUILD_HOST = structure_alone("build_host_ms", |row| Some(host_ms(row.build.first()).into()));
    SETUP = structure_alone("setup_ms", |row| Some(row.build.setup_ms.into()));
    /// Allocated bytes of the structure.
    STRUCTURE = structure(["structure_bytes", "structure", "MiB"], Lower, |row| bytes(row.memory.structure_bytes));
    USED = structure(["structure_used_bytes", "used", "MiB"], Lower, |row| bytes(used_bytes(row)));
    BYTES_PER_TRIANGLE = structure_alone("bytes_per_triangle", |row| Some(per_triangle(row)[0].into()));
    USED_BYTES_PER_TRIANGLE = structure_alone("used_bytes_per_triangle", |row| Some(per_triangle(row)[1].into()));
    GEOMETRY = structure(["geometry_bytes", "geometry", "MiB"], Lower, |row| bytes(row.memory.geometry_bytes));
    BUILD_PEAK = structure(["build_peak_bytes", "build peak", "MiB"], Lower, |row| bytes(row.memory.build_peak_bytes));
    HIT_MISS = metric(["agreement_hit_miss_share", "agreement hit_miss", ""], Higher, |trace| right(trace, Closest, 0));
    /// Right by the analytic rule.
    TIGHT = metric(["agreement_tight_share", "agreement tight", ""], Higher, |trace| right(trace, Closest, 1));
    /// Right within a pixel.
    FOOTPRINT = metric(["agreement_footprint_share", "agreement footprint", ""], Higher, |trace| {
        right(trace, Closest, 2)
    });
    POSITION = metric(["position_error_scene_units", "position error p50 / p95 / p99", "scene units"], Lower, |trace| {
        Some(closest(trace)?.position_error.into())
    });
    /// Told hits near the piece of mesh that is truly hit.
    WITHIN_TEXEL = metric(["within_common_texel_share", "within a common texel", ""], Higher, |trace| {
        let told = distance(trace)?;
        Some(Cell::Share(told.within_common_texel?, None, told.rays))
    });
    /// The same by the tracer's own texel.
    WITHIN_OWN_TEXEL = metric(["within_own_texel_share", "within a texel of its own", ""], Higher, |trace| {
        let told = distance(trace)?;
        Some(Cell::Share(told.within_own_texel?, None, told.rays))
    });
    /// How far told hits are from it.
    SURFACE_DISTANCE =
        metric(["surface_distance_scene_units", "distance p50 / p95 / p99", "scene units"], Lower, |trace| {
            Some(distance(trace)?.distance.into())
        });
    IDENTITY = metric(["identity_share", "identity", ""], Higher, |trace| {
        let judgement = closest(trace)?;
        Some(Cell::Share(judgement.identity?, None, judgement.classes.tight.true_hit))
    });
    WRONG_TIGHT = plain("wrong_tight_rays", |trace| Some(wrong_tight(&trace.judgement).into()));
    TIGHT_TRUE_HIT = plain("tight_true_hit_rays", |trace| in_class(trace, |of| of.tight.true_hit));
    TIGHT_TRUE_MISS = plain("tight_true_miss_rays", |trace| in_class(trace, |of| of.tight.true_miss));
    TIGHT_FALSE_HIT = plain("tight_false_hit_rays", |trace| in_class(trace, |of| of.tight.false_hit));
    TIGHT_FALSE_MISS = plain("tight_false_miss_rays", |trace| in_class(trace, |of| of.tight.false_miss));
    TIGHT_EARLY = plain("tight_early_rays", |trace| in_class(trace, |of| of.tight.early));
    TIGHT_LATE = plain("tight_late_rays", |trace| in_class(trace, |of| of.tight.late));
    FOOTPRINT_TRUE_HIT = plain("footprint_true_hit_rays", |trace| in_class(trace, |of| of.footprint.true_hit));
    FOOTPRINT_TRUE_MISS = plain("footprint_true_miss_rays", |trace| in_class(trace, |of| of.footprint.true_miss));
    FOOTPRINT_FALSE_HIT = plain("footprint_false_hit_rays", |trace| in_class(trace, |of| of.footprint.false_hit));
    FOOTPRINT_FALSE_MISS = plain("footprint_false_miss_rays", |trace| in_class(trace, |of| of.footprint.false_miss));
    FOOTPRINT_EARLY = plain("footprint_early_rays", |trace| in_class(trace, |of| of.footprint.early));
    FOOTPRINT_LATE = plain("footprint_late_rays", |trace| in_class(trace, |of| of.footprint.late));
    BALANCED = metric(["balanced_accuracy_share", "balanced accuracy", ""], Higher, |trace| right(trace, Any, 0));
    TRUE_OCCLUDED = metric(["true_occluded_rays", "rightly occluded", ""], Neither, |trace| {
        of_any(trace, |of| of.true_occluded)
    });
    TRUE_FREE = metric(["true_free_rays", "rightly free", ""], Neither, |trace| of_any(trace, |of| of.true_free));
    FALSE_OCCLUDED = metric(["false_occluded_rays", "wrongly occluded", ""], Lower, |trace| {
        of_any(trace, |of| of.false_occluded)
    });
    FALSE_FREE = metric(["false_free_rays", "wrongly free", ""], Lower, |trace| of_any(trace, |of| of.false_free));
    SURFACES = metric(["surface_agreement_share", "surfaces", ""], Higher, |trace| {
        let judged = trace.surfaces.as_ref()?;
        Some(Cell::Share(judged.agreement?, judged.interval, judged.judged))
    });
    SURFACE_JUDGED = plain("surface_judged_rays", |trace| Some(trace.surfaces.as_ref()?.judged.into()));
    LOST = metric(["surface_lost_rays", "lost", "rays"], Lower, |trace| Some(trace.surfaces.as_ref()?.lost.into()));
    MATERIAL = metric(["surface_material_share", "material", ""], Higher, |trace| surfaces(trace, |of| of.material));
    NORMAL = metric(["surface_normal_share", "normal", ""], Higher, |trace| surfaces(trace, |of| of.normal));
    POSITION_OF_SURFACE = metric(["surface_position_share", "position", ""], Higher, |trace| {
        surfaces(trace, |of| of.position)
    });
    NORMAL_ERROR = metric(["surface_normal_error_degrees", "normal error p50 / p95 / p99", "degrees"], Lower, |trace| {
        Some(trace.surfaces.as_ref()?.normal_error_degrees.into())
    });
    POSITION_ERROR_OF_SURFACE =
        metric(["surface_position_error_scene_units", "position error p50 / p95 / p99", "scene units"], Lower, |trace| {
            Some(trace.surfaces.as_ref()?.position_error.into())
        });
}

/// The agreements without them, by rule.
pub(crate) const WITHOUT_AMBIGUOUS: Metric = metric(
    ["agreement_without_ambiguous_share", "without ambiguous rays: hit_miss / tight / footprint", ""],
    Higher,
    |trace| {
        if trace.judgement.one_sided().is_some() {
            return None;
        }
        let PerRule { hit_miss, tight, footprint } = closest(trace)?.agreement_without_ambiguous?;
        Some(Cell::Shares([hit_miss, tight, footprint], trace.count.saturating_sub(trace.judgement.ambiguous())))
    },
);

/// Times of builds, which not every record tells.
fn built(times: &Option<Box<Times>>) -> Option<Cell> {
    Some(times.as_deref().map_or(Cell::Absent, Cell::from))
}

fn bytes(count: u64) -> Option<Cell> {
    Some(Cell::Bytes(count as f64))
}

/// Rays of a class, of closest hits.
fn in_class(trace: &TraceRecord, of: fn(&ByRule<Classes>) -> u64) -> Option<Cell> {
    Some(of(&closest(trace)?.classes).into())
}

/// Rays of any hits.
fn of_any(trace: &TraceRecord, of: fn(&Occlusion) -> u64) -> Option<Cell> {
    Some(of(&any(trace)?.occlusion).into())
}

/// One of the accuracies of a trace of a query.
fn right(trace: &TraceRecord, query: Query, place: usize) -> Option<Cell> {
    let of_query = matches!(trace.judgement, Judgement::Closest(_)) == (query == Closest);
    let found = right_of(trace).get(place).copied().filter(|_| of_query);
    found.map(Cell::Accuracy)
}

/// A share of surfaces that were judged.
fn surfaces(trace: &TraceRecord, of: fn(&SurfaceJudgement) -> Option<f64>) -> Option<Cell> {
    let judged = trace.surfaces.as_ref()?;
    Some(Cell::Share(of(judged)?, None, judged.judged))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    /// Every file of a folder with its text, without tests.
    fn sources(folder: &Path, found: &mut Vec<(String, String)>) {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.to_string_lossy().replace('\\', "/");
            // There fields of the record are named as they are in it.
            if name.ends_with("/results/fault.rs") {
                continue;
            }
            if path.is_dir() && !name.ends_with("/tests") {
                sources(&path, found);
            } else if name.ends_with(".rs") && !name.ends_with("/tests.rs") && !name.ends_with("/metrics/list.rs") {
                let text = fs::read_to_string(&path).unwrap();
                found.push((name, text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default().to_owned()));
            }
        }
    }

    /// A figure's heading, the name of its axis and its columns for programs are spelled here alone, but for plain words.
    #[test]
    fn figures_are_named_once() {
        let mut found = Vec::new();
        sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
        let figures = || METRICS.iter().chain([&WITHOUT_AMBIGUOUS]);
        let columns = figures().map(|each| each.name).filter(|name| name.contains('_'));
        let mut names: Vec<String> = columns.map(|name| (*name).to_owned()).collect();
        let told = figures().filter(|each| !each.label.is_empty());
        names.extend(told.clone().map(Metric::heading).filter(|heading| heading.ends_with(['↑', '↓'])));
        names.extend(told.filter(|each| !each.unit.is_empty()).map(Metric::axis));
        for name in &names {
            let spelled = |(_, text): &&(String, String)| text.contains(&format!("\"{name}\""));
            let places: Vec<&String> = found.iter().filter(spelled).map(|(path, _)| path).collect();
            assert!(places.is_empty(), "{name} stands in {places:?}");
        }
    }
}
