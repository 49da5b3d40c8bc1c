//! What pages of HHZ14's tables and figures show before their rows.

use super::quantities::octree::{FRAME, pair};
use super::{ABUFFER, OCTREE};
use crate::papers::page::Page;
use crate::papers::page::beside::beside;
use crate::papers::page::measured::{TIMES, strings, time_with_accuracy};
use crate::papers::rows::trace;
use crate::report::format::{NONE, optional, thousands};
use crate::report::markdown::{Table, inline};
use crate::results::{TraceRecord, TracerRun, host_ms};

/// Rows of the tracer, with ratios to the first.
pub(super) fn rows(page: &Page<'_>) -> String {
    beside(page, ABUFFER)
}

/// All rays of a frame.
fn frame(run: &TracerRun) -> Option<Vec<&TraceRecord>> {
    FRAME.iter().map(|rays| trace(run, rays)).collect()
}

/// Table 1: what the octree takes over what the A-buffers take, beside the same of the paper.
pub(super) fn octree(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "build (ms) ↓",
        "× A-buffers",
        "traces of a frame (ms) ↓",
        "× A-buffers",
        "both (ms) ↓",
        "× A-buffers",
        "published: build × A-buffers",
        "traces ×",
        "all ×",
    ]));
    for scene in &page.rows.scenes {
        let Some([_, first]) = pair(scene) else { continue };
        let printed = |column: &str| {
            let name = page.experiment.stands_for(&first.scene)?;
            let of = |method: &str| page.printed()?.value(&[("scene", name), ("method", method)], column);
            Some(of("SVO")? / of("HHZ14")?)
        };
        let times = |run: &TracerRun| -> (Option<f64>, Option<(f64, String)>) {
            let traced = frame(run).and_then(|traces| time_with_accuracy(&traces));
            (host_ms(&run.build.times), traced)
        };
        let (first_build, first_traces) = times(first);
        let first_traces = first_traces.map(|(ms, _)| ms);
        for run in &scene.runs {
            let (build, traces) = times(run);
            let over =
                |own: Option<f64>, first: Option<f64>| optional(own.zip(first).map(|(own, first)| own / first), 3);
            let traces_ms = traces.as_ref().map(|(ms, _)| *ms);
            // Without an accuracy there is no time of a frame.
            let [both, first_both] = [(build, traces_ms), (first_build, first_traces)]
                .map(|(build, traces)| build.zip(traces).map(|(build, traces)| build + traces));
            let is_peer = run.tracer.name == OCTREE;
            let of_paper = |column: &str| optional(printed(column).filter(|_| is_peer), 3);
            table.row(&[
                inline(&scene.label),
                run.label(),
                optional(build, 4),
                over(build, first_build),
                traces.map_or_else(|| NONE.to_owned(), |(_, text)| text),
                over(traces_ms, first_traces),
                optional(both, 4),
                over(both, first_both),
                of_paper("Construction"),
                of_paper("Tracing Rays"),
                of_paper("Total"),
            ]);
        }
    }
    format!("\n{TIMES} A frame is mirrored, refracted and shadow rays once each.\n\n{}", table.text)
}

/// Figure 7: the time of a ray a pixel, over the number of rays.
pub(super) fn a_ray(page: &Page<'_>) -> String {
    let printed = page.printed().and_then(|table| table.rows.as_ref()?.first()?.values.first().copied()?);
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "rays",
        "all rays (ms) ↓",
        "a million rays (ms) ↓",
        "a ray a pixel of 800x600 (ms) ↓",
        "published (ms)",
    ]));
    for run in page.rows.scenes.iter().flat_map(|scene| scene.by_resolution()).flat_map(|scene| scene.runs) {
        let Some(traced) = trace(run, "ao") else { continue };
        let time = time_with_accuracy(&[traced]);
        let of_a_ray = time.as_ref().map(|(ms, _)| ms / traced.count.max(1) as f64);
        table.row(&[
            inline(&run.scene.name),
            run.label(),
            thousands(traced.count),
            time.map_or_else(|| NONE.to_owned(), |(_, text)| text),
            optional(of_a_ray.map(|ms| ms * 1e6), 4),
            optional(of_a_ray.map(|ms| ms * 800.0 * 600.0), 4),
            optional(printed, 3),
        ]);
    }
    format!("\n{TIMES} The published time is of its own hardware and stands beside no time here.\n\n{}", table.text)
}
