//! What pages of VVP16's tables and figures show before their rows.

use super::quantities::peers::SAMPLES;
use super::quantities::variants::{STORAGES, UPDATE_MODES, with};
use super::quantities::{counted, memory, rays, search};
use super::{ABUFFER, PAPER, skipping};
use crate::papers::page::Page;
use crate::papers::page::measured::{TIMES, TableRow, ms_of, of_rows, over, over_first, time_of, time_with_accuracy};
use crate::papers::rows::{statistic, trace};
use crate::papers::{SceneRows, Scope};
use crate::report::document::Document;
use crate::report::markdown::literal;
use crate::report::sheet::{Cell, Column, Sheet};
use crate::results::{Row, TraceRecord, host_ms};

/// A part of Table 1.
struct Part<'a> {
    row: TableRow<'a>,
    /// What is traced.
    rays: &'static str,
    /// How the published columns of it end.
    columns: &'static str,
    /// The published row's effect.
    effect: &'static str,
    /// Traces with skipping, and without.
    traces: [Vec<&'a TraceRecord>; 2],
}

impl Part<'_> {
    fn ms(&self, skips: usize) -> Option<f64> {
        Some(time_with_accuracy(&self.traces[skips])?.value)
    }

    fn printed(&self, page: &Page<'_>, start: &str, end: &str) -> Option<f64> {
        let column = format!("{start}, {}{end}", self.columns);
        page.printed_of(self.row.1, &[("effect", self.effect)], &column)
    }
}

/// One and two bounces and ambient occlusion of a scene's row with skipping and of the same without.
fn parts((scene, on): TableRow<'_>) -> Vec<Part<'_>> {
    let Some(off) = scene.like_first(ABUFFER, &skipping("off")) else { return Vec::new() };
    let part = |rays, columns, effect, traces| Part { row: (scene, on), rays, columns, effect, traces };
    let mut parts = Vec::new();
    if let Some(([one, two], [one_off, two_off])) = search::bounces(on).zip(search::bounces(off)) {
        parts.push(part("1 bounce", "1 bounce", "path tracing", [one, one_off]));
        parts.push(part("2 bounces", "2 bounces", "path tracing", [two, two_off]));
    }
    if let Some((on, off)) = trace(on, "ao").zip(trace(off, "ao")) {
        // Printed in the columns of the first bounce.
        parts.push(part("ao", "1 bounce", "ambient occlusion, 3 m range", [vec![on], vec![off]]));
    }
    parts
}

/// Two figures in one cell.
fn both(one: Cell, other: Cell) -> String {
    format!("{} / {}", one.describe(), other.describe())
}

/// The first row of every scene.
fn first<'a>(page: &Page<'a>) -> Vec<TableRow<'a>> {
    page.rows.scenes.iter().filter_map(|scene| Some((scene, scene.like_first(ABUFFER, &[])?))).collect()
}

/// Table 1: layers, views, efficiency and times, with what skipping gains beside the published gain.
pub(super) fn bounces(page: &Page<'_>) -> Document {
    let rows = first(page);
    let own = |row: &Row, name: &str| Cell::from(statistic(row, name).map(Cell::Statistic));
    let printed = |row: &Row, column: &str, digits| Cell::number(page.printed_of(row, &[], column), digits);
    let structures = Sheet::<TableRow<'_>>::new()
        .column("scene", |(scene, _)| Cell::Name(scene.label.clone()))
        .column("memory (MiB) ↓", |(_, on)| PAPER.bytes(on, Scope::Structure).map(Cell::Bytes))
        .column("fragments", |(_, on)| own(on, "fragments"))
        .column("layers of a covered pixel / most", |(_, on)| {
            both(own(on, "average_layers"), own(on, "maximum_layers"))
        })
        .column("layers of a pixel", |(_, on)| over(statistic(on, "fragments"), statistic(on, "pixels")))
        .column("published: MB", |(_, on)| printed(on, "Memory", 4))
        .column("million fragments", |(_, on)| printed(on, "Fragments", 4))
        .column("avg / max layers", |(_, on)| both(printed(on, "Avg layers", 3), printed(on, "Max layers", 3)));
    let traces = Sheet::<Part<'_>>::new()
        .column("scene", |part| Cell::Name(part.row.0.label.clone()))
        .column("rays", |part| part.rays)
        .column("layers a ray", |Part { traces: [with, _], .. }| {
            over(counted(with, "fragments_tested"), Some(rays(with)))
        })
        .column("layers a pixel opened", |part| Cell::number(search::layers(&part.traces[0]), 3))
        .column("views a ray", |part| Cell::number(search::views(&part.traces[0]), 3))
        .column("efficiency of skipping (%)", |part| {
            Cell::number(search::efficiency(&part.traces[0]).map(|share| 100.0 * share), 3)
        })
        .column("with skipping (ms) ↓", |part| time_with_accuracy(&part.traces[0]))
        .column("without (ms) ↓", |part| time_with_accuracy(&part.traces[1]))
        .column("without over with", |part| over(part.ms(1), part.ms(0)))
        .column("published: layers / views", |part| {
            let [layers, views] = ["Avg layers", "Avg views"].map(|start| part.printed(page, start, ""));
            both(Cell::number(layers, 2), Cell::number(views, 2))
        })
        .column("efficiency (%)", |part| Cell::number(part.printed(page, "Empty space efficiency", ""), 3))
        .column("off over on", |part| {
            over(part.printed(page, "1spp", ", skipping off"), part.printed(page, "1spp", ""))
        });
    let parts: Vec<Part<'_>> = rows.iter().copied().flat_map(parts).collect();
    Document::default().table(structures.table(&rows)).paragraph(TIMES).table(traces.table(&parts))
}

/// Bytes of each part of Table 2 by its formula with the device's own counts, and by the ledger, with all that is used.
type Formula<'a> = (TableRow<'a>, [f64; 3], [f64; 3], f64);

/// The formula of Table 2 beside what the ledger says is used.
pub(super) fn formula(page: &Page<'_>) -> Document {
    let mut rows: Vec<Formula<'_>> = Vec::new();
    for row in page.of_tracer(ABUFFER) {
        let used = PAPER.bytes(row.1, Scope::Structure);
        rows.extend(
            memory::formula(row.1).zip(used).map(|(formula, used)| (row, formula, memory::ledger(row.1), used)),
        );
    }
    let count =
        |name| Column::new(name, move |((_, row), ..): &Formula<'_>| statistic(row, name).map(|count| count as u64));
    let all = |ledger: &[f64; 3]| ledger.iter().sum::<f64>();
    let mut sheet = of_rows::<Formula<'_>>(|(row, ..)| *row)
        .and(count("pixels").headed("pixels of all views"))
        .and(count("fragments"));
    for (part, name) in ["words of pixels", "id buffer", "data"].into_iter().enumerate() {
        sheet = sheet
            .column(format!("{name}: formula (bytes)"), move |(_, formula, ..)| formula[part] as u64)
            .column("ledger over formula", move |(_, formula, ledger, _)| {
                Cell::Number(ledger[part] / formula[part], 6)
            });
    }
    sheet = sheet
        .column("all three (MiB)", |(.., ledger, _)| Cell::Bytes(all(ledger)))
        .column("in the ledger and not in Table 2 (bytes)", |(.., ledger, used)| (used - all(ledger)) as u64);
    Document::of("Bytes used:").table(sheet.table(&rows))
}

/// Figure 12: times of every storage and way, with what each step gains in speed.
pub(super) fn variants(page: &Page<'_>) -> Document {
    let rows: Vec<_> = page.rows.scenes.iter().flat_map(|scene| STORAGES.map(|storage| (scene, storage))).collect();
    let time = |(scene, storage): &(&SceneRows<'_>, &str), way: usize| {
        time_of(with(scene, storage, UPDATE_MODES[way].1)?, &[page.experiment.rays])
    };
    let gain = |row: &(&SceneRows<'_>, &str), from: usize, to: usize| {
        let gained = |from: f64, to: f64| Cell::Number(100.0 * (from / to - 1.0), 3);
        Some(gained(time(row, from)?.value, time(row, to)?.value))
    };
    let sheet = Sheet::<(&SceneRows<'_>, &str)>::new()
        .column("scene", |(scene, _)| Cell::Name(scene.label.clone()))
        .column("storage", |(_, storage)| (*storage).to_owned())
        .column("default (ms) ↓", |row| time(row, 0))
        .column("decoupled (ms) ↓", |row| time(row, 1))
        .column("gain in speed (%)", |row| gain(row, 0, 1))
        .column("with skipping (ms) ↓", |row| time(row, 2))
        .column("further gain (%)", |row| gain(row, 1, 2));
    Document::of(TIMES).table(sheet.table(&rows))
}

/// Figures 7 to 9: times of every row, as ratios to the first of the same resolution.
pub(super) fn views_and_layers(page: &Page<'_>) -> Document {
    let mut section = Document::of(format!("{TIMES} Ratios are to the first row of a part."));
    for scene in page.rows.scenes.iter().flat_map(SceneRows::by_resolution) {
        let Some(first) = scene.rows.first().copied() else { continue };
        let mut sheet = Sheet::<&Row>::new().column("tracer", |row| row.label());
        for set in scene.ray_sets() {
            sheet = sheet.column(format!("{set} (ms) ↓"), move |row| time_of(row, &[set])).and(over_first(
                "ratio",
                first,
                move |row| ms_of(row, &[set]),
            ));
        }
        let name = page.experiment.stands_for(&first.scene).map_or_else(String::new, |name| format!(" for {name}"));
        let [[width, height], [columns, lines]] = [first.viewpoint.ray_image, first.viewpoint.frame];
        let (label, face) = (literal(&scene.label), first.viewpoint.face);
        section = section
            .paragraph(format!("**{label}**{name}, rays from {width}x{height}, frame {columns}x{lines}, faces {face}"))
            .table(sheet.table(&scene.rows));
    }
    section
}

/// Figure 10: build and samples of every frame, with their ratio beside the published one.
pub(super) fn frames(page: &Page<'_>) -> Document {
    let samples = |row: &Row| Some(SAMPLES * ms_of(row, &["diffuse"])?);
    let printed = |row: &Row| ["Construction", "Tracing"].map(|column| page.printed_of(row, &[], column));
    let sheet = Sheet::<TableRow<'_>>::new()
        .column("scene", |(_, row)| Cell::Name(row.scene.name.clone()))
        .column("frame at (s)", |(_, row)| row.viewpoint.time_s.to_string())
        .column("build (ms) ↓", |(_, row)| host_ms(row.build.steady()))
        .column("one sample a pixel (ms) ↓", |(_, row)| time_of(row, &["diffuse"]))
        .column("four samples over build", |(_, row)| over(samples(row), host_ms(row.build.steady())))
        .column("published: build / four samples (ms)", |(_, row)| {
            let [build, samples] = printed(row);
            both(Cell::number(build, 2), Cell::number(samples, 3))
        })
        .column("four samples over build", |(_, row)| {
            let [build, samples] = printed(row);
            over(samples, build)
        });
    Document::of(TIMES).table(sheet.table(&first(page)))
}
