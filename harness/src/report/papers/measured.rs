//! What was measured: structures and traces of every scene and resolution, and what a paper's own table shows of them.

use std::collections::BTreeSet;

use tracebench_api::Query;

use crate::papers::{self, Experiment, MIXES, PublishedTable, Rows, SceneRows, Shown, total_ms};
use crate::report::cells;
use crate::report::format::{self, NONE, clock_of, mib, optional, significant, statistic, thousands, with_interval};
use crate::report::group::Role;
use crate::report::markdown::{Table, inline};
use crate::report::metrics;
use crate::results::{TraceRecord, TracerRun};

/// Counts that structures of the paper say of themselves, with their headings.
const COUNTS: [(&str, &str); 5] = [
    ("references", "references"),
    ("parts", "parts of triangles"),
    ("occupied_tiles", "occupied tiles"),
    ("mean_list_length", "mean list"),
    ("longest_list", "longest list"),
];
/// Kinds of rays in the order of DIRT's Table 1: ray set, published column.
const KINDS: [(&str, &str); 4] =
    [("visibility", "Visibility"), ("specular", "Specular"), ("glossy", "Glossy"), ("diffuse", "Diffuse")];
/// Bytes of the formula of DIRT's Table 3: a tile's depth bounds, a list's head, a node.
const FORMULA: [f64; 3] = [8.0, 4.0, 8.0];
/// The factors by mipmaps that the paper gives: Table 3, section 4.1.1.
const MIPMAPS: [f64; 2] = [1.33, 1.5];

fn strings(headings: &[&str]) -> Vec<String> {
    headings.iter().map(|heading| (*heading).to_owned()).collect()
}

/// Every section of an experiment.
pub(super) fn sections(experiment: &Experiment, rows: &Rows<'_>, published: &[PublishedTable]) -> String {
    let mut text = String::from("\n## Here\n");
    for shown in experiment.shown {
        text += &match shown {
            Shown::Throughput => throughput(experiment, rows, published),
            Shown::Formula => formula(rows),
            Shown::Mixes => mixes(rows),
            // Charts, made elsewhere.
            Shown::OverBuckets | Shown::MemoryOverResolution => String::new(),
        };
    }
    for scene in &rows.scenes {
        for at in scene.by_resolution() {
            text += &at_resolution(&at);
        }
    }
    text
}

fn at_resolution(scene: &SceneRows<'_>) -> String {
    let Some(first) = scene.runs.first() else { return String::new() };
    let viewpoint = &first.viewpoint;
    let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
    let mut text = format!(
        "\n### {} ({} triangles), rays from {}, frame {}, faces {}\n\n",
        inline(&scene.label),
        thousands(first.scene.triangles),
        size(viewpoint.ray_image),
        size(viewpoint.frame),
        viewpoint.face
    );
    text += &structures(scene);
    let mut sets: Vec<&str> = Vec::new();
    for trace in scene.runs.iter().flat_map(|run| &run.traces) {
        if !sets.contains(&trace.rays.as_str()) {
            sets.push(&trace.rays);
        }
    }
    for set in sets {
        text += &traces(scene, set);
    }
    text
}

/// Counts, bytes and builds; times only in runs that tell accuracies too.
fn structures(scene: &SceneRows<'_>) -> String {
    let timed = scene.runs.iter().any(|run| !run.traces.is_empty());
    let known = |name: &str| scene.runs.iter().any(|run| run.structure_statistics.contains_key(name));
    let counts: Vec<_> = COUNTS.into_iter().filter(|(name, _)| known(name)).collect();
    let mut headings = strings(&["tracer"]);
    headings.extend(counts.iter().map(|(_, heading)| (*heading).to_owned()));
    headings.extend(strings(&["structure, used (MiB) ↓", "allocated (MiB) ↓"]));
    if timed {
        headings.extend([strings(&["build clock"]), vec![metrics::BUILD_TIME.heading()]].concat());
        headings.push("phases (ms)".to_owned());
    }
    let mut table = Table::new(&headings);
    for run in &scene.runs {
        let count = |name: &str| papers::statistic(run, name).map_or_else(|| NONE.to_owned(), statistic);
        let mut cells = vec![run.tracer.label()];
        cells.extend(counts.iter().map(|(name, _)| count(name)));
        cells.push(mib(papers::stored_bytes(run) as u64));
        cells.push(mib(run.memory.structure_bytes));
        if timed {
            let times = &run.build.times;
            cells.push(clock_of(times));
            cells.push(if times.samples_ms.is_empty() {
                NONE.to_owned()
            } else {
                with_interval(times.median_ms, times.interval_ms, 4)
            });
            let phases = times.phases.iter().map(|each| format!("{} {}", each.name, significant(each.median_ms, 3)));
            cells.push(phases.collect::<Vec<_>>().join("; "));
        }
        table.row(&cells);
    }
    table.text
}

fn traces(scene: &SceneRows<'_>, set: &str) -> String {
    let all: Vec<(Role, &TracerRun, &TraceRecord)> =
        scene.runs.iter().filter_map(|run| Some((Role::Contender, *run, papers::trace(run, set)?))).collect();
    let Some((.., first)) = all.first() else { return String::new() };
    let counters: BTreeSet<&str> =
        all.iter().flat_map(|(.., trace)| trace.counters.keys().map(String::as_str)).collect();
    let accuracies: &[&str] = match first.query {
        Query::Closest => &["agreement hit_miss ↑", "agreement tight ↑", "agreement footprint ↑"],
        Query::Any => &["balanced accuracy ↑"],
    };
    let mut headings = strings(&["tracer", "clock"]);
    headings.extend([metrics::SPEED.heading(), metrics::TRACE_TIME.heading()]);
    headings.extend(strings(accuracies));
    headings.extend(counters.iter().map(|name| format!("{name} per ray ↓")));
    let mut table = Table::new(&headings);
    for (role, run, trace) in &all {
        let (judged, accuracies) = cells::accuracies(trace);
        let [label, clock, _, speed, time] = cells::speed_cells(*role, run, trace, judged);
        let mut row = vec![label, clock, speed, time];
        row.extend(accuracies);
        row.extend(counters.iter().map(|name| optional(trace.counters.get(*name).map(|each| each.per_ray), 4)));
        table.row(&row);
    }
    let title = format!("{}: {}, {} rays", inline(set), format::query(first.query), thousands(first.count));
    format!("\n**{title}**\n{}\n{}", cells::coverage(&all), table.text)
}

/// Speed and accuracy in one cell.
fn speed_with_accuracy(trace: &TraceRecord) -> Option<(f64, String)> {
    let accuracy = match &trace.judgement {
        crate::results::Judgement::Closest(closest) => closest.agreement.tight,
        crate::results::Judgement::Any(any) => any.occlusion.balanced_accuracy,
    };
    let (speed, accuracy) = metrics::speed(trace).zip(accuracy)?;
    let share = format::percent(accuracy, metrics::trials(trace));
    Some((speed, format!("{} at {share} %", significant(speed, 4))))
}

/// Rays a second of each kind, and ratios to the last kind beside the published ones.
fn throughput(experiment: &Experiment, rows: &Rows<'_>, published: &[PublishedTable]) -> String {
    let printed = published.iter().find(|table| experiment.published.contains(&table.id.as_str()));
    let kinds: Vec<&str> = KINDS.iter().map(|(rays, _)| *rays).collect();
    let mut speeds = Table::new(&[strings(&["scene", "tracer"]), strings(&kinds)].concat());
    let mut ratios = Table::new(&[strings(&["scene", "tracer"]), strings(&kinds[..3])].concat());
    for scene in &rows.scenes {
        for run in &scene.runs {
            let found = KINDS.map(|(rays, _)| papers::trace(run, rays).and_then(speed_with_accuracy));
            let mut cells = vec![scene.label.clone(), run.tracer.label()];
            cells.extend(
                found.iter().map(|each| each.as_ref().map_or_else(|| NONE.to_owned(), |(_, text)| text.clone())),
            );
            speeds.row(&cells);
            let own = |index: usize| {
                let [one, last] = [index, KINDS.len() - 1].map(|at| found[at].as_ref().map(|(speed, _)| *speed));
                Some(one? / last?)
            };
            let theirs = |index: usize| {
                let name = experiment.stands_for(&run.scene.name)?;
                let of = |column: &str| printed?.value(&[("scene", name)], column);
                Some(of(KINDS[index].1)? / of(KINDS[KINDS.len() - 1].1)?)
            };
            let both =
                |index: usize| format!("{} here, {} published", optional(own(index), 3), optional(theirs(index), 3));
            let mut cells = vec![scene.label.clone(), run.tracer.label()];
            cells.extend((0..KINDS.len() - 1).map(both));
            ratios.row(&cells);
        }
    }
    format!(
        "\nMrays/s with the agreement under tight of the same rays (any hit: balanced accuracy):\n\n{}\nRatios to diffuse rays, \
         within one scene and tracer:\n\n{}",
        speeds.text, ratios.text
    )
}

/// The formula of Table 3 with the device's own counts, beside what the ledger says is used.
fn formula(rows: &Rows<'_>) -> String {
    let part = |run: &TracerRun, of: &dyn Fn(&str) -> bool| {
        run.memory.structure.iter().filter(|part| of(&part.name)).map(|part| part.used_bytes as f64).sum::<f64>()
    };
    let is_bounds = |name: &str| name == "depth bounds texture";
    let is_list = |name: &str| name.starts_with("id buffer");
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "tiles of all views",
        "c n_p (references)",
        "id buffer, formula (bytes)",
        "id buffer, ledger over formula",
        "depth bounds without mipmaps (bytes)",
        "ledger over that",
        "formula at 1.33 over ledger",
        "at 1.5 over ledger",
        "in the ledger and not in Table 3 (bytes)",
    ]));
    for (scene, run) in rows.scenes.iter().flat_map(|scene| scene.runs.iter().map(move |run| (scene, *run))) {
        let found = papers::tiles(run).zip(papers::statistic(run, "references")).zip(papers::integer(run, "buckets"));
        let Some(((tiles, references), buckets)) = found else { continue };
        let [bounds_bytes, head_bytes, node_bytes] = FORMULA;
        let lists = head_bytes * buckets as f64 * tiles + node_bytes * references;
        let bounds = bounds_bytes * tiles;
        let ledger = part(run, &is_bounds) + part(run, &is_list);
        let beside = |factor: f64| significant((bounds * factor + lists) / ledger, 5);
        table.row(&[
            scene.label.clone(),
            run.tracer.label(),
            thousands(tiles as u64),
            thousands(references as u64),
            thousands(lists as u64),
            significant(part(run, &is_list) / lists, 6),
            thousands(bounds as u64),
            significant(part(run, &is_bounds) / bounds, 5),
            beside(MIPMAPS[0]),
            beside(MIPMAPS[1]),
            thousands(part(run, &|name| !is_bounds(name) && !is_list(name)) as u64),
        ]);
    }
    format!("\nBytes used:\n\n{}", table.text)
}

/// Build and traces of every mix by the host's clock, with the ratio to the first tracer.
fn mixes(rows: &Rows<'_>) -> String {
    let mut headings = strings(&["scene", "rays from", "tracer", "build (ms, host clock) ↓"]);
    headings.extend(MIXES.iter().map(|(name, _)| format!("{name}: build and traces (ms) ↓")));
    let mut table = Table::new(&headings);
    for scene in &rows.scenes {
        for at in scene.by_resolution() {
            for run in &at.runs {
                let [width, height] = run.viewpoint.ray_image;
                let mut cells = vec![scene.label.clone(), format!("{width}x{height}"), run.tracer.label()];
                cells.push(optional(papers::host_ms(&run.build.times), 4));
                cells.extend(MIXES.iter().map(|(_, mix)| optional(total_ms(run, mix), 4)));
                table.row(&cells);
            }
        }
    }
    format!("\nThe accuracy of the same traces stands below, by scene and resolution.\n\n{}", table.text)
}
