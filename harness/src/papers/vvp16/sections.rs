//! What pages of VVP16's tables and figures show before their rows.

use super::quantities::peers::SAMPLES;
use super::quantities::variants::{STORAGES, WAYS, with};
use super::quantities::{counted, memory, rays, search};
use super::{ABUFFER, PAPER, skipping};
use crate::papers::page::Page;
use crate::papers::page::beside::beside;
use crate::papers::page::measured::{TIMES, strings, time_with_accuracy};
use crate::papers::rows::{self, trace};
use crate::papers::{SceneRows, Scope};
use crate::report::format::{NONE, mib, optional, significant, statistic, thousands};
use crate::report::markdown::{Table, inline};
use crate::results::{TraceRecord, TracerRun, host_ms};

/// A part of Table 1: what is traced, how the published columns of it end, and the published row's effect.
type Part<'a> = (&'a str, &'a str, &'a str, Vec<&'a TraceRecord>, Vec<&'a TraceRecord>);

/// One and two bounces and ambient occlusion of a row with skipping and of the same without.
fn parts<'a>(on: &'a TracerRun, off: &'a TracerRun) -> Vec<Part<'a>> {
    let mut parts: Vec<Part<'a>> = Vec::new();
    if let Some((on, off)) = search::bounces(on).zip(search::bounces(off)) {
        let ([one, two], [one_off, two_off]) = (on, off);
        parts.push(("1 bounce", "1 bounce", "path tracing", one, one_off));
        parts.push(("2 bounces", "2 bounces", "path tracing", two, two_off));
    }
    if let Some((on, off)) = trace(on, "ao").zip(trace(off, "ao")) {
        // Printed in the columns of the first bounce.
        parts.push(("ao", "1 bounce", "ambient occlusion, 3 m range", vec![on], vec![off]));
    }
    parts
}

/// Table 1: layers, views, efficiency and times, with what skipping gains beside the published gain.
pub(super) fn bounces(page: &Page<'_>) -> String {
    let printed = page.printed();
    let mut structures = Table::new(&strings(&[
        "scene",
        "memory (MiB) ↓",
        "fragments",
        "layers of a covered pixel / most",
        "layers of a pixel",
        "published: MB",
        "million fragments",
        "avg / max layers",
    ]));
    let mut traces = Table::new(&strings(&[
        "scene",
        "rays",
        "layers a ray",
        "layers a pixel opened",
        "views a ray",
        "efficiency of skipping (%)",
        "with skipping (ms) ↓",
        "without (ms) ↓",
        "without over with",
        "published: layers / views",
        "efficiency (%)",
        "off over on",
    ]));
    for scene in &page.rows.scenes {
        let Some(on) = scene.like_first(ABUFFER, &[]) else { continue };
        let own = |name: &str| rows::statistic(on, name).map_or_else(|| NONE.to_owned(), statistic);
        let layers = rows::statistic(on, "fragments").zip(rows::statistic(on, "pixels"));
        let of = |effect: Option<&str>, column: &str| {
            let name = page.experiment.stands_for(&on.scene)?;
            let labels = [("scene", name), ("effect", effect.unwrap_or_default())];
            printed?.value(&labels[..1 + usize::from(effect.is_some())], column)
        };
        structures.row(&[
            scene.label.clone(),
            optional(PAPER.bytes(on, Scope::Structure).map(|bytes| bytes / f64::from(1 << 20)), 4),
            own("fragments"),
            format!("{} / {}", own("average_layers"), own("maximum_layers")),
            optional(layers.map(|(fragments, pixels)| fragments / pixels), 3),
            optional(of(None, "Memory"), 4),
            optional(of(None, "Fragments"), 4),
            format!("{} / {}", optional(of(None, "Avg layers"), 3), optional(of(None, "Max layers"), 3)),
        ]);
        let Some(off) = scene.like_first(ABUFFER, &skipping("off")) else { continue };
        for (name, column, effect, with, without) in parts(on, off) {
            let printed = |start: &str, end: &str| of(Some(effect), &format!("{start}, {column}{end}"));
            let [on, off] = [&with, &without].map(|traces| time_with_accuracy(traces));
            let gain = |on: Option<f64>, off: Option<f64>| Some(off? / on?);
            let cell =
                |time: &Option<(f64, String)>| time.as_ref().map_or_else(|| NONE.to_owned(), |(_, text)| text.clone());
            let tested = counted(&with, "fragments_tested").map(|tested| tested / rays(&with));
            traces.row(&[
                scene.label.clone(),
                name.to_owned(),
                optional(tested, 3),
                optional(search::layers(&with), 3),
                optional(search::views(&with), 3),
                optional(search::efficiency(&with).map(|share| 100.0 * share), 3),
                cell(&on),
                cell(&off),
                optional(gain(on.map(|(ms, _)| ms), off.map(|(ms, _)| ms)), 3),
                format!("{} / {}", optional(printed("Avg layers", ""), 2), optional(printed("Avg views", ""), 2)),
                optional(printed("Empty space efficiency", ""), 3),
                optional(gain(printed("1spp", ""), printed("1spp", ", skipping off")), 3),
            ]);
        }
    }
    format!("\n{}\n{TIMES}\n\n{}", structures.text, traces.text)
}

/// The formula of Table 2 with the device's own counts, beside what the ledger says is used.
pub(super) fn formula(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "pixels of all views",
        "fragments",
        "words of pixels: formula (bytes)",
        "ledger over formula",
        "id buffer: formula (bytes)",
        "ledger over formula",
        "data: formula (bytes)",
        "ledger over formula",
        "all three (MiB)",
        "in the ledger and not in Table 2 (bytes)",
    ]));
    for (scene, run) in page.rows.scenes.iter().flat_map(|scene| scene.of_tracer(ABUFFER).map(move |run| (scene, run)))
    {
        let counts = ["pixels", "fragments"].map(|name| rows::statistic(run, name));
        let ([Some(pixels), Some(fragments)], Some(formula)) = (counts, memory::formula(run)) else { continue };
        let ledger = memory::ledger(run);
        let all: f64 = ledger.iter().sum();
        let mut cells = vec![scene.label.clone(), run.label(), thousands(pixels as u64)];
        cells.push(thousands(fragments as u64));
        for (formula, ledger) in formula.iter().zip(ledger) {
            cells.extend([thousands(*formula as u64), significant(ledger / formula, 6)]);
        }
        let Some(used) = PAPER.bytes(run, Scope::Structure) else { continue };
        cells.extend([mib(all as u64), thousands((used - all) as u64)]);
        table.row(&cells);
    }
    format!("\nBytes used:\n\n{}", table.text)
}

/// The A-buffer beside hierarchies.
pub(super) fn peers(page: &Page<'_>) -> String {
    beside(page, ABUFFER)
}

/// Figure 12: times of every storage and way, with what each step gains in speed.
pub(super) fn variants(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&[
        "scene",
        "storage",
        "default (ms) ↓",
        "decoupled (ms) ↓",
        "gain in speed (%)",
        "with skipping (ms) ↓",
        "further gain (%)",
    ]));
    for (scene, storage) in page.rows.scenes.iter().flat_map(|scene| STORAGES.map(|storage| (scene, storage))) {
        let times = WAYS.map(|(_, way)| {
            let run = with(scene, storage, way)?;
            time_with_accuracy(&[trace(run, page.experiment.rays)?])
        });
        let cell = |index: usize| times[index].as_ref().map_or_else(|| NONE.to_owned(), |(_, text)| text.clone());
        let gain = |from: usize, to: usize| {
            let [from, to] = [from, to].map(|index| times[index].as_ref().map(|(ms, _)| *ms));
            optional(from.zip(to).map(|(from, to)| 100.0 * (from / to - 1.0)), 3)
        };
        let cells = [cell(0), cell(1), gain(0, 1), cell(2), gain(1, 2)];
        table.row(&[vec![scene.label.clone(), storage.to_owned()], cells.to_vec()].concat());
    }
    format!("\n{TIMES}\n\n{}", table.text)
}

/// Figures 7 to 9: times of every row, as ratios to the first of the same resolution.
pub(super) fn views_and_layers(page: &Page<'_>) -> String {
    let mut text = format!("\n{TIMES} Ratios are to the first row of a part.\n");
    for scene in page.rows.scenes.iter().flat_map(SceneRows::by_resolution) {
        let Some(first) = scene.runs.first().copied() else { continue };
        let sets = scene.ray_sets();
        let mut headings = strings(&["tracer"]);
        headings.extend(sets.iter().flat_map(|set| [format!("{set} (ms) ↓"), "ratio".to_owned()]));
        let mut table = Table::new(&headings);
        for run in &scene.runs {
            let mut cells = vec![run.label()];
            for set in &sets {
                let [own, base] = [run, first].map(|run| time_with_accuracy(&[trace(run, set)?]));
                cells.push(own.as_ref().map_or_else(|| NONE.to_owned(), |(_, text)| text.clone()));
                cells.push(optional(own.zip(base).map(|((own, _), (base, _))| own / base), 3));
            }
            table.row(&cells);
        }
        let name = page.experiment.stands_for(&first.scene).map_or_else(String::new, |name| format!(" for {name}"));
        let [[width, height], [columns, lines]] = [first.viewpoint.ray_image, first.viewpoint.frame];
        text += &format!(
            "\n**{}**{name}, rays from {width}x{height}, frame {columns}x{lines}, faces {}\n\n{}",
            inline(&scene.label),
            first.viewpoint.face,
            table.text
        );
    }
    text
}

/// Figure 10: build and samples of every frame, with their ratio beside the published one.
pub(super) fn frames(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&[
        "scene",
        "frame at (s)",
        "build (ms) ↓",
        "one sample a pixel (ms) ↓",
        "four samples over build",
        "published: build / four samples (ms)",
        "four samples over build",
    ]));
    for run in page.rows.scenes.iter().filter_map(|scene| scene.like_first(ABUFFER, &[])) {
        let published =
            |column: &str| page.printed()?.value(&[("scene", page.experiment.stands_for(&run.scene)?)], column);
        let time = time_with_accuracy(&trace(run, "diffuse").into_iter().collect::<Vec<_>>());
        let build = host_ms(&run.build.times);
        let ratio = time.as_ref().zip(build).map(|((ms, _), build)| SAMPLES * ms / build);
        let [construction, tracing] = ["Construction", "Tracing"].map(published);
        table.row(&[
            inline(&run.scene.name),
            run.viewpoint.time_s.to_string(),
            optional(build, 4),
            time.map_or_else(|| NONE.to_owned(), |(_, text)| text),
            optional(ratio, 3),
            format!("{} / {}", optional(construction, 2), optional(tracing, 3)),
            optional(tracing.zip(construction).map(|(tracing, construction)| tracing / construction), 3),
        ]);
    }
    format!("\n{TIMES}\n\n{}", table.text)
}
