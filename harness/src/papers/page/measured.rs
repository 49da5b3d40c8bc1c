//! What was measured: a paper's own sections, then structures and traces of every scene and resolution.

use super::Page;
use super::told;
use crate::papers::rows::{right, statistic, trace};
use crate::papers::{SceneRows, Scope};
use crate::report::document::{Document, Of, set_heading};
use crate::report::format::{self, edges, significant, thousands};
use crate::report::group::Role;
use crate::report::markdown::literal;
use crate::report::metrics::{BUILD_TIME, SPEED, STRUCTURE, TRACE_TIME};
use crate::report::sheet::{Cell, Column, Sheet, Table};
use crate::report::{cells, metrics};
use crate::results::{Judgement, Row, TraceRecord};

/// What scopes of bytes are called.
const SCOPES: [&str; 3] = [
    "structure alone, used (MiB) ↓",
    "with the buffers of a trace, by the ledger (MiB) ↓",
    "with the paper's own buffers, computed, not allocated (MiB) ↓",
];

/// What was measured: the paper's own sections, then every scene and resolution; of frames, which have a page, the first alone.
pub(super) fn sections(page: &Page<'_>) -> Document {
    let runs = page.rows.scenes.iter().filter(|_| page.experiment.frames.is_none());
    let at = runs.flat_map(SceneRows::by_resolution);
    Document::default()
        .heading(2, "Here")
        .and(page.experiment.sections.iter().map(|name| section(page, name)))
        .and(at.filter_map(|at| at_resolution(page, &at)))
}

/// A section by name: a table of the paper's, or one that all have.
fn section(page: &Page<'_>, name: &str) -> Document {
    let (name, reference) = name.strip_prefix("beside ").map_or((name, ""), |reference| ("beside", reference));
    let told = page.paper.pages.tables.get(name).unwrap_or_else(|| &told::COMMON.tables[name]);
    told::section(page, told, reference)
}

fn at_resolution(page: &Page<'_>, scene: &SceneRows<'_>) -> Option<Document> {
    let first = scene.rows.first()?;
    let viewpoint = &first.viewpoint;
    let heading = format!(
        "{} ({} triangles), rays from {}, frame {}, faces {}{}",
        literal(&scene.label),
        thousands(first.scene.triangles),
        edges(viewpoint.ray_image),
        edges(viewpoint.frame),
        viewpoint.face,
        viewpoint.ray_overrides()
    );
    let sets = scene.ray_sets().into_iter().map(|set| traces(scene, set));
    let of = Of { scene: Some(first.scene.name.clone()), rays: None };
    Some(Document::default().headed(3, heading, of).table(structures(page, scene)).and(sets))
}

/// Counts, bytes and builds; times only where they were taken, in runs that tell accuracies too.
fn structures(page: &Page<'_>, scene: &SceneRows<'_>) -> Table {
    let timed = scene.rows.iter().any(|row| !row.traces.is_empty() && !row.build.times.samples_ms.is_empty());
    let known = |name: &str| scene.rows.iter().any(|row| row.structure_statistics.contains_key(name));
    let counts = page.paper.own.counts.iter().filter(|(name, _)| known(name));
    let count = |(name, heading): &(&'static str, &'static str)| {
        let name = *name;
        Column::new(*heading, move |row: &&Row| statistic(row, name).map(Cell::Statistic))
    };
    let in_scope = |(scope, heading): (Scope, &str)| {
        Column::new(heading, move |row: &&Row| page.paper.bytes(row, scope).map(Cell::Bytes))
    };
    let mut sheet = Sheet::<&Row>::new()
        .column("tracer", |row| row.label())
        .with(counts.map(count).collect())
        .with(Scope::ALL.into_iter().zip(SCOPES).map(in_scope).collect())
        .structure(STRUCTURE.called("structure alone, allocated"), |row| Some(row));
    if timed {
        sheet = sheet
            .clock("build_clock", |row| Some(row.build.first()))
            .builds(BUILD_TIME.label, |row| Some(row))
            .build_phases("phases (ms)", "; ", |row| row);
    }
    sheet.table(&scene.rows)
}

fn traces(scene: &SceneRows<'_>, set: &str) -> Document {
    let all: Vec<cells::TableRow<'_>> =
        scene.rows.iter().filter_map(|row| Some((Role::Tracer, *row, trace(row, set)?))).collect();
    let Some((.., first)) = all.first() else { return Document::default() };
    let mut sheet =
        Sheet::<cells::TableRow<'_>>::new().name().own_clock().taken(SPEED).taken(TRACE_TIME).right(first.query);
    if all.iter().any(|(.., trace)| trace.times.phases.len() > 1) {
        sheet = sheet.phases("phases (ms)", "; ", |(.., trace)| Some(&trace.times).filter(|_| metrics::judged(trace)));
    }
    let sheet = sheet.counted(&all, |_| true);
    let title = set_heading(set, first.query, first.count);
    Document::of(format!("**{title}**")).paragraph(cells::coverage(&all)).table(sheet.table(&all))
}

/// Million rays a second, or milliseconds, and how that is told, with the accuracy of the same rays.
type Accurate = (f64, Cell);

fn accurate(value: f64, accuracy: &str) -> Accurate {
    (value, Cell::Text(format!("{} at {accuracy}", significant(value, 4))))
}

/// Speed with agreement under `tight`, of any-hit sets with balanced accuracy.
pub(in crate::papers) fn speed_with_accuracy(trace: &TraceRecord) -> Option<Accurate> {
    let accuracy = right(trace, "tight").or_else(|| right(trace, "balanced"));
    let (value, accuracy) = metrics::speed(trace).zip(accuracy)?;
    Some(accurate(value, &format!("{} %", format::percent(accuracy, metrics::trials(trace)))))
}

/// Milliseconds of a row's ray sets by the host's clock with the accuracy of the same rays, the least of theirs: agreement under
/// `hit_miss` and `footprint`, of any-hit sets balanced accuracy. None where it lacks a set or one could not be judged, so that no time
/// stands without it.
pub(in crate::papers) fn time_of(row: &Row, sets: &[&str]) -> Option<Accurate> {
    let mut ms = 0.0;
    let mut least: Option<(f64, String)> = None;
    for rays in sets {
        let trace = trace(row, rays)?;
        let percent = |share: f64| format::percent(share, metrics::trials(trace));
        let (accuracy, text) = match &trace.judgement {
            Judgement::Closest(closest) => {
                let (hit_miss, footprint) = closest.agreement.hit_miss.zip(closest.agreement.footprint)?;
                (footprint, format!("{} / {} %", percent(hit_miss), percent(footprint)))
            }
            Judgement::Any(any) => {
                let balanced = any.occlusion.balanced_accuracy?;
                (balanced, format!("{} %", percent(balanced)))
            }
        };
        ms += crate::results::host_ms(&trace.times)?;
        if least.as_ref().is_none_or(|(least, _)| accuracy < *least) {
            least = Some((accuracy, text));
        }
    }
    least.map(|(_, accuracy)| accurate(ms, &accuracy))
}
