//! `sweep.md`.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::{Cell, View};
use crate::report::format::{self, NONE, clock_of, mib, thousands, with_interval};
use crate::report::group::Role;
use crate::report::markdown::{Table, inline};
use crate::report::{cells, metrics, summary};
use crate::results::SweepRecord;
use crate::results::{Judgement, Run, TraceRecord, TracerRun};
use crate::studies::sweep::RESOLUTION;

/// The whole page.
pub(super) fn page(run: &Run, sweep: &SweepRecord, views: &[View<'_>]) -> String {
    let mut text = summary::head(run, &format!("Sweep of {}", inline(&sweep.tracer)));
    let _ = writeln!(
        text,
        "\n{} points; {}. The tracer's own values, with an asterisk below: {}. All points were measured in turn, \
         sample by sample.",
        sweep.points.len(),
        if sweep.grid { "all combinations of two parameters" } else { "one parameter changed at a time" },
        sweep
            .axes
            .iter()
            .map(|axis| format!("{}={}", inline(&axis.name), inline(&axis.own)))
            .collect::<Vec<_>>()
            .join(", "),
    );
    let mut scene = "";
    let mut axis = "";
    for view in views {
        let here = view.group.stem.as_str();
        if here != scene {
            let name = inline(&view.group.scene.name);
            let _ = writeln!(text, "\n## {name} ({} triangles)", thousands(view.group.scene.triangles));
            (scene, axis) = (here, "");
        }
        if view.axis.name != axis {
            let _ = writeln!(text, "\n### {}\n\n{}.", inline(&view.axis.name), inline(&view.axis.effect));
            axis = &view.axis.name;
        }
        text += &section(view);
    }
    text + &summary::skipped(&run.skipped)
}

fn section(view: &View<'_>) -> String {
    let set = view.set;
    let title = format!("{}: {}, {} rays", inline(&set.title), format::query(set.query), thousands(set.count));
    let mut text =
        format!("\n#### {title}\n\n![{} over {}]({}.svg)\n", inline(&set.title), inline(&view.axis.name), view.stem());
    let all: Vec<_> = view.curves.iter().flat_map(|curve| &curve.cells).collect();
    let rows: Vec<_> =
        all.iter().filter_map(|cell| cell.measured).map(|(run, trace)| (Role::Contender, run, trace)).collect();
    text += &cells::coverage(&rows);
    let accuracies: &[&str] = match rows.first().map(|(_, _, trace)| &trace.judgement) {
        Some(Judgement::Any(_)) => &["balanced accuracy ↑"],
        _ => &["agreement hit_miss ↑", "agreement tight ↑", "agreement footprint ↑"],
    };
    let mut headings: Vec<String> = view.other.iter().map(|other| other.name.clone()).collect();
    headings.push(view.axis.name.clone());
    let sized = [Some(view.axis), view.other].iter().flatten().any(|axis| axis.name == RESOLUTION);
    if sized {
        headings.push("frame, faces (px)".to_owned());
    }
    headings.extend([metrics::STRUCTURE.heading(), "used (MiB) ↓".to_owned(), "build clock".to_owned()]);
    headings.extend([metrics::BUILD_TIME.heading(), "clock".to_owned(), metrics::SPEED.heading()]);
    headings.extend(accuracies.iter().map(|&name| name.to_owned()));
    let touched = touched_counters(&rows);
    headings.extend(touched.iter().map(|name| format!("{name} ↓")));
    let mut table = Table::new(&headings);
    for curve in &view.curves {
        for cell in &curve.cells {
            let mut row: Vec<String> = curve.other.iter().map(|value| (*value).to_owned()).collect();
            let own = if cell.value == view.axis.own { " *" } else { "" };
            row.push(format!("{}{own}", cell.value));
            if sized {
                let [width, height] = cell.point.frame;
                row.push(format!("{width}×{height}, {}", cell.point.face));
            }
            row.extend(measured(cell, &view.group.scene.name, accuracies.len()));
            let of = |(run, trace): (&TracerRun, &TraceRecord), name: &str| {
                cells::touched(run, name, trace.counters.get(name)?)
            };
            let of_cell =
                |name: &&String| cell.measured.and_then(|one| of(one, name)).unwrap_or_else(|| NONE.to_owned());
            row.extend(touched.iter().map(of_cell));
            table.row(&row);
        }
    }
    let _ = write!(text, "\n{}", table.text);
    text
}

/// The names of what is counted over a whole set: how much of what is stored it touched.
fn touched_counters<'a>(rows: &[cells::Row<'a>]) -> BTreeSet<&'a String> {
    let counters = rows.iter().flat_map(|(_, _, trace)| &trace.counters);
    counters.filter(|(_, counter)| counter.greatest_per_ray.is_none()).map(|(name, _)| name).collect()
}

fn measured(cell: &Cell<'_>, scene: &str, accuracy_count: usize) -> Vec<String> {
    let Some((run, trace)) = cell.measured else {
        let mut row = vec![NONE.to_owned(); 6 + accuracy_count];
        if cell.point.skipped.contains_key(scene) {
            row[0] = "skipped, see below".to_owned();
        }
        return row;
    };
    let (judged, accuracies) = cells::accuracies(trace);
    let [_, clock, _, speed, _] = cells::speed_cells(Role::Contender, run, trace, judged);
    let build = &run.build.times;
    let used: u64 = run.memory.structure.iter().map(|entry| entry.used_bytes).sum();
    let time = if build.samples_ms.is_empty() {
        NONE.to_owned()
    } else {
        with_interval(build.median_ms, build.interval_ms, 4)
    };
    let mut row = vec![mib(run.memory.structure_bytes), mib(used), clock_of(build), time, clock, speed];
    row.extend(accuracies);
    row
}
