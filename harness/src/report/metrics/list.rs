//! The figures: a new one is a constant and its place in [`METRICS`], which makes it a column of `rows.csv`.

use tracebench_api::Query;

use super::Better::{Higher, Lower, Neither};
use super::{
    Metric, any, closest, distance, metric, per_triangle, plain, right_of, speed, speed_interval, structure,
    structure_alone, timed, used_bytes, wrong_tight,
};
use crate::report::sheet::Cell;
use crate::results::{Judgement, PerRule, SurfaceJudgement, TraceRecord, host_ms};

/// Rays asked.
pub(crate) const COUNT: Metric = plain("count_rays", |trace| Some(trace.count.into()));
/// Traces a second.
pub(crate) const SPEED: Metric = metric("mrays_per_s", "speed", "Mrays/s", Higher, |trace| {
    Some(Cell::Measured(speed(trace)?, speed_interval(trace), 4))
});
/// Time of a trace.
pub(crate) const TRACE_TIME: Metric =
    metric("median_ms", "median time", "ms", Lower, |trace| timed(trace, (&trace.times).into()));
/// Time of a trace as a program that is no tracer of this suite tells of itself.
pub(crate) const SELF_REPORTED: Metric =
    metric("self_reported_trace_ms", "self-reported time", "ms", Neither, |trace| {
        Some(trace.self_reported.as_ref()?.trace_ms?.into())
    });
/// Time of the phases of a build, which records of before rules version 3 have alone.
pub(crate) const BUILD_TIME: Metric = structure("build_median_ms", "build time", "ms", Lower, |row| {
    Some(if row.build.steady.is_none() { (&row.build.times).into() } else { Cell::Absent })
});
/// Time of a first build, host clock.
pub(crate) const FIRST_BUILD: Metric = structure("first_build_median_ms", "first build", "ms", Lower, |row| {
    Some(row.build.first.as_deref().map_or(Cell::Absent, Cell::from))
});
/// Time of a steady build, host clock.
pub(crate) const STEADY_BUILD: Metric = structure("steady_build_median_ms", "steady build", "ms", Lower, |row| {
    Some(row.build.steady.as_deref().map_or(Cell::Absent, Cell::from))
});
/// Millions of triangles a second of a first build.
pub(crate) const BUILD_RATE: Metric =
    structure("build_mtriangles_per_s", "build rate", "Mtriangles/s", Higher, |row| {
        let times = row.build.first();
        let rate = |ms: f64| row.scene.triangles as f64 / (ms * 1e3);
        let [fast, slow] = times.interval_ms;
        (!times.samples_ms.is_empty() && fast > 0.0)
            .then(|| Cell::Measured(rate(times.median_ms), Some([rate(slow), rate(fast)]), 4))
    });
/// Right about hit or miss.
pub(crate) const HIT_MISS: Metric =
    metric("agreement_hit_miss_share", "agreement hit_miss", "", Higher, |trace| right(trace, Query::Closest, 0));
/// Right by the analytic rule.
pub(crate) const TIGHT: Metric =
    metric("agreement_tight_share", "agreement tight", "", Higher, |trace| right(trace, Query::Closest, 1));
/// Right within a pixel.
pub(crate) const FOOTPRINT: Metric =
    metric("agreement_footprint_share", "agreement footprint", "", Higher, |trace| right(trace, Query::Closest, 2));
/// How far hits are off.
pub(crate) const POSITION: Metric =
    metric("position_error_scene_units", "position error p50 / p95 / p99", "scene units", Lower, |trace| {
        Some(closest(trace)?.position_error.into())
    });
/// Told hits near the piece of mesh that is truly hit.
pub(crate) const WITHIN_TEXEL: Metric =
    metric("within_common_texel_share", "within a common texel", "", Higher, |trace| {
        let told = distance(trace)?;
        Some(Cell::Share(told.within_common_texel?, None, told.rays))
    });
/// The same by the tracer's own texel.
pub(crate) const WITHIN_OWN_TEXEL: Metric =
    metric("within_own_texel_share", "within a texel of its own", "", Higher, |trace| {
        let told = distance(trace)?;
        Some(Cell::Share(told.within_own_texel?, None, told.rays))
    });
/// How far told hits are from it.
pub(crate) const SURFACE_DISTANCE: Metric =
    metric("surface_distance_scene_units", "distance p50 / p95 / p99", "scene units", Lower, |trace| {
        Some(distance(trace)?.distance.into())
    });
/// The right triangle.
pub(crate) const IDENTITY: Metric = metric("identity_share", "identity", "", Higher, |trace| {
    let judgement = closest(trace)?;
    Some(Cell::Share(judgement.identity?, None, judgement.classes.tight.true_hit))
});
/// Ambiguous rays.
pub(crate) const AMBIGUOUS: Metric =
    metric("ambiguous_rays", "ambiguous", "rays", Neither, |trace| Some(trace.judgement.ambiguous().into()));
/// The agreements without them, by rule.
pub(crate) const WITHOUT_AMBIGUOUS: Metric = metric(
    "agreement_without_ambiguous_share",
    "without ambiguous rays: hit_miss / tight / footprint",
    "",
    Higher,
    |trace| {
        if trace.judgement.one_sided().is_some() {
            return None;
        }
        let PerRule { hit_miss, tight, footprint } = closest(trace)?.agreement_without_ambiguous?;
        Some(Cell::Shares([hit_miss, tight, footprint], trace.count.saturating_sub(trace.judgement.ambiguous())))
    },
);
/// Right about occlusion.
pub(crate) const BALANCED: Metric =
    metric("balanced_accuracy_share", "balanced accuracy", "", Higher, |trace| right(trace, Query::Any, 0));
/// Rays rightly said to be occluded.
pub(crate) const TRUE_OCCLUDED: Metric = metric("true_occluded_rays", "rightly occluded", "", Neither, |trace| {
    Some(any(trace)?.occlusion.true_occluded.into())
});
/// Rays rightly said to be free.
pub(crate) const TRUE_FREE: Metric =
    metric("true_free_rays", "rightly free", "", Neither, |trace| Some(any(trace)?.occlusion.true_free.into()));
/// Rays wrongly said to be occluded.
pub(crate) const FALSE_OCCLUDED: Metric = metric("false_occluded_rays", "wrongly occluded", "", Lower, |trace| {
    Some(any(trace)?.occlusion.false_occluded.into())
});
/// Rays wrongly said to be free.
pub(crate) const FALSE_FREE: Metric =
    metric("false_free_rays", "wrongly free", "", Lower, |trace| Some(any(trace)?.occlusion.false_free.into()));
/// Surfaces that are right.
pub(crate) const SURFACES: Metric = metric("surface_agreement_share", "surfaces", "", Higher, |trace| {
    let judged = trace.surfaces.as_ref()?;
    Some(Cell::Share(judged.agreement?, judged.interval, judged.judged))
});
/// Surfaces that were not found.
pub(crate) const LOST: Metric =
    metric("surface_lost_rays", "lost", "rays", Lower, |trace| Some(trace.surfaces.as_ref()?.lost.into()));
/// Surfaces of the right material.
pub(crate) const MATERIAL: Metric =
    metric("surface_material_share", "material", "", Higher, |trace| of_surfaces(trace, |judged| judged.material));
/// Surfaces with the right normal.
pub(crate) const NORMAL: Metric =
    metric("surface_normal_share", "normal", "", Higher, |trace| of_surfaces(trace, |judged| judged.normal));
/// Surfaces in the right place.
pub(crate) const POSITION_OF_SURFACE: Metric =
    metric("surface_position_share", "position", "", Higher, |trace| of_surfaces(trace, |judged| judged.position));
/// How far normals are off.
pub(crate) const NORMAL_ERROR: Metric =
    metric("surface_normal_error_degrees", "normal error p50 / p95 / p99", "degrees", Lower, |trace| {
        Some(trace.surfaces.as_ref()?.normal_error_degrees.into())
    });
/// How far surfaces are off.
pub(crate) const POSITION_ERROR_OF_SURFACE: Metric =
    metric("surface_position_error_scene_units", "position error p50 / p95 / p99", "scene units", Lower, |trace| {
        Some(trace.surfaces.as_ref()?.position_error.into())
    });
/// Allocated bytes of the structure.
pub(crate) const STRUCTURE: Metric =
    structure("structure_bytes", "structure", "MiB", Lower, |row| Some(Cell::Bytes(row.memory.structure_bytes as f64)));
/// What of them is used.
pub(crate) const USED: Metric =
    structure("structure_used_bytes", "used", "MiB", Lower, |row| Some(Cell::Bytes(used_bytes(row) as f64)));
/// Geometry needed beside the structure.
pub(crate) const GEOMETRY: Metric =
    structure("geometry_bytes", "geometry", "MiB", Lower, |row| Some(Cell::Bytes(row.memory.geometry_bytes as f64)));
/// The most held while building.
pub(crate) const BUILD_PEAK: Metric = structure("build_peak_bytes", "build peak", "MiB", Lower, |row| {
    Some(Cell::Bytes(row.memory.build_peak_bytes as f64))
});

/// Every figure of a trace, in the order of the table's columns. Shares are 0 to 1.
pub(crate) const METRICS: &[Metric] = &[
    COUNT,
    AMBIGUOUS,
    SPEED,
    TRACE_TIME,
    plain("interval_coverage_share", |trace| timed(trace, trace.times.interval_coverage.into())),
    plain("trace_host_ms", |trace| Some(host_ms(&trace.times).into())),
    plain("samples", |trace| Some((trace.times.samples_ms.len() as u64).into())),
    plain("per_trace_bytes", |trace| Some(trace.per_trace_bytes.into())),
    SELF_REPORTED,
    plain("self_reported_build_ms", |trace| Some(trace.self_reported.as_ref()?.build_ms?.into())),
    BUILD_TIME,
    FIRST_BUILD,
    STEADY_BUILD,
    BUILD_RATE,
    structure_alone("build_host_ms", |row| Some(host_ms(row.build.first()).into())),
    structure_alone("setup_ms", |row| Some(row.build.setup_ms.into())),
    STRUCTURE,
    USED,
    structure_alone("bytes_per_triangle", |row| Some(per_triangle(row)[0].into())),
    structure_alone("used_bytes_per_triangle", |row| Some(per_triangle(row)[1].into())),
    GEOMETRY,
    BUILD_PEAK,
    HIT_MISS,
    TIGHT,
    FOOTPRINT,
    POSITION,
    WITHIN_TEXEL,
    WITHIN_OWN_TEXEL,
    SURFACE_DISTANCE,
    IDENTITY,
    plain("wrong_tight_rays", |trace| Some(wrong_tight(&trace.judgement).into())),
    plain("tight_true_hit_rays", |trace| Some(closest(trace)?.classes.tight.true_hit.into())),
    plain("tight_true_miss_rays", |trace| Some(closest(trace)?.classes.tight.true_miss.into())),
    plain("tight_false_hit_rays", |trace| Some(closest(trace)?.classes.tight.false_hit.into())),
    plain("tight_false_miss_rays", |trace| Some(closest(trace)?.classes.tight.false_miss.into())),
    plain("tight_early_rays", |trace| Some(closest(trace)?.classes.tight.early.into())),
    plain("tight_late_rays", |trace| Some(closest(trace)?.classes.tight.late.into())),
    plain("footprint_true_hit_rays", |trace| Some(closest(trace)?.classes.footprint.true_hit.into())),
    plain("footprint_true_miss_rays", |trace| Some(closest(trace)?.classes.footprint.true_miss.into())),
    plain("footprint_false_hit_rays", |trace| Some(closest(trace)?.classes.footprint.false_hit.into())),
    plain("footprint_false_miss_rays", |trace| Some(closest(trace)?.classes.footprint.false_miss.into())),
    plain("footprint_early_rays", |trace| Some(closest(trace)?.classes.footprint.early.into())),
    plain("footprint_late_rays", |trace| Some(closest(trace)?.classes.footprint.late.into())),
    BALANCED,
    TRUE_OCCLUDED,
    TRUE_FREE,
    FALSE_OCCLUDED,
    FALSE_FREE,
    SURFACES,
    plain("surface_judged_rays", |trace| Some(trace.surfaces.as_ref()?.judged.into())),
    LOST,
    MATERIAL,
    NORMAL,
    POSITION_OF_SURFACE,
    NORMAL_ERROR,
    POSITION_ERROR_OF_SURFACE,
];

/// One of the accuracies of a trace of a query.
fn right(trace: &TraceRecord, query: Query, place: usize) -> Option<Cell> {
    let of_query = matches!(trace.judgement, Judgement::Closest(_)) == (query == Query::Closest);
    let found = right_of(trace).get(place).copied().filter(|_| of_query);
    found.map(Cell::Accuracy)
}

/// A share of surfaces that were judged.
fn of_surfaces(trace: &TraceRecord, of: fn(&SurfaceJudgement) -> Option<f64>) -> Option<Cell> {
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
