//! What was measured: a paper's own sections, then structures and traces of every scene and resolution.

use super::Page;
use super::beside::{beside, by_part};
use super::told;
use crate::papers::rows::{self, trace};
use crate::papers::{SceneRows, Scope};
use crate::report::document::{Document, Of, set_heading};
use crate::report::format::{self, significant, thousands};
use crate::report::group::Role;
use crate::report::markdown::literal;
use crate::report::metrics::{BUILD_TIME, SPEED, STRUCTURE, TRACE_TIME};
use crate::report::sheet::{Cell, Column, Sheet, Table};
use crate::report::{cells, metrics};
use crate::results::{Judgement, Row, TraceRecord};

/// What was measured: the paper's own sections, then every scene and resolution.
pub(super) fn sections(page: &Page<'_>) -> Document {
    let at = page.rows.scenes.iter().flat_map(SceneRows::by_resolution);
    Document::default()
        .heading(2, "Here")
        .and(page.experiment.sections.iter().map(|name| section(page, name)))
        .and(at.filter_map(|at| at_resolution(page, &at)))
}

/// A section by name.
fn section(page: &Page<'_>, name: &str) -> Document {
    match (name.strip_prefix("beside "), page.paper.pages.tables.get(name)) {
        (Some(reference), _) => beside(page, reference),
        (None, Some(told)) => told::section(page, told),
        (None, None) => by_part(page),
    }
}

fn at_resolution(page: &Page<'_>, scene: &SceneRows<'_>) -> Option<Document> {
    let first = scene.rows.first()?;
    let viewpoint = &first.viewpoint;
    let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
    let heading = format!(
        "{} ({} triangles), rays from {}, frame {}, faces {}{}",
        literal(&scene.label),
        thousands(first.scene.triangles),
        size(viewpoint.ray_image),
        size(viewpoint.frame),
        viewpoint.face,
        viewpoint.ray_overrides()
    );
    let sets = scene.ray_sets().into_iter().map(|set| traces(scene, set));
    let of = Of { scene: Some(first.scene.name.clone()), rays: None };
    Some(Document::default().headed(3, heading, of).table(structures(page, scene)).and(sets))
}

/// Counts, bytes and builds; times only in runs that tell accuracies too.
fn structures(page: &Page<'_>, scene: &SceneRows<'_>) -> Table {
    let timed = scene.rows.iter().any(|row| !row.traces.is_empty());
    let known = |name: &str| scene.rows.iter().any(|row| row.structure_statistics.contains_key(name));
    let counts = page.paper.own.counts.iter().filter(|(name, _)| known(name));
    let count = |(name, heading): &(&'static str, &'static str)| {
        let name = *name;
        Column::new(*heading, move |row: &&Row| rows::statistic(row, name).map(Cell::Statistic))
    };
    let in_scope = |(scope, heading): (Scope, &str)| {
        Column::new(heading, move |row: &&Row| page.paper.bytes(row, scope).map(Cell::Bytes))
    };
    let mut sheet = Sheet::<&Row>::new()
        .column("tracer", |row| row.label())
        .with(counts.map(count).collect())
        .with(Scope::ALL.map(in_scope).into())
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

/// One over another, where there are both.
fn over(own: Option<f64>, first: Option<f64>) -> Cell {
    Cell::number(own.zip(first).map(|(own, first)| own / first), 3)
}

/// A figure of rows over that of the first one.
pub(super) fn over_first<'a>(
    heading: &str,
    first: &'a Row,
    of: impl Fn(&Row) -> Option<f64> + 'a,
) -> Column<'a, &'a Row> {
    Column::new(heading, move |row: &&Row| over(of(row), of(first)))
}

/// A speed or a time with the accuracy of the same rays.
pub(in crate::papers) struct Accurate {
    /// Million rays a second, or milliseconds.
    pub value: f64,
    accuracy: String,
}

impl From<Accurate> for Cell {
    fn from(Accurate { value, accuracy }: Accurate) -> Self {
        Self::Text(format!("{} at {accuracy}", significant(value, 4)))
    }
}

/// Speed with agreement under `tight`, of any-hit sets with balanced accuracy.
pub(in crate::papers) fn speed_with_accuracy(trace: &TraceRecord) -> Option<Accurate> {
    let (value, accuracy) = metrics::speed(trace).zip(rows::agreement(trace))?;
    Some(Accurate { value, accuracy: format!("{} %", format::percent(accuracy, metrics::trials(trace))) })
}

/// What stands above tables of times by [`time_with_accuracy`].
pub(super) const TIMES: &str = "Times are medians by the host's clock with the accuracy of the same rays: agreement under hit_miss and footprint, of \
                     any-hit sets balanced accuracy, the worst where several sets are added up.";

/// Milliseconds of traces by the host's clock with the accuracy of the same rays, the least of theirs: agreement under `hit_miss`
/// and `footprint`, of any-hit sets balanced accuracy. None where one could not be judged, so that no time stands without it.
fn time_with_accuracy(traces: &[&TraceRecord]) -> Option<Accurate> {
    let mut ms = 0.0;
    let mut least: Option<(f64, String)> = None;
    for trace in traces {
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
    least.map(|(_, accuracy)| Accurate { value: ms, accuracy })
}

/// The same of a row's ray sets; none where it lacks one.
pub(in crate::papers) fn time_of(row: &Row, sets: &[&str]) -> Option<Accurate> {
    time_with_accuracy(&sets.iter().map(|rays| trace(row, rays)).collect::<Option<Vec<_>>>()?)
}

/// Its milliseconds alone, for ratios.
pub(super) fn ms_of(row: &Row, sets: &[&str]) -> Option<f64> {
    Some(time_of(row, sets)?.value)
}
