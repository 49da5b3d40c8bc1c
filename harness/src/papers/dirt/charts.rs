//! Charts of DIRT's figures.

use std::collections::BTreeSet;

use super::PAPER;
use super::quantities::time::{MIXES, total_ms};
use crate::papers::page::Page;
use crate::papers::page::charts::{stem, subtitle};
use crate::papers::rows::{agreement, integer, statistic};
use crate::papers::vvp16::ABUFFER;
use crate::papers::{Experiment, SceneRows, Scope};
use crate::report::chart::series::{Series, SeriesChart, SeriesPanel};
use crate::results::Row;
use crate::results::host_ms;
use itertools::Itertools as _;

const MIB: f64 = (1 << 20) as f64;

fn sorted(mut values: Vec<u64>) -> Vec<u64> {
    values.sort_unstable();
    values.dedup();
    values
}

/// Memory, references, build, trace and tests over B, a line a tile size; a chart a scene.
pub(super) fn over_buckets(page: &Page<'_>) -> Vec<SeriesChart> {
    page.rows.scenes.iter().map(|scene| over_buckets_of(page.experiment, scene)).collect()
}

fn over_buckets_of(experiment: &Experiment, scene: &SceneRows<'_>) -> SeriesChart {
    let values = |name: &str| sorted(scene.rows.iter().filter_map(|row| integer(row, name)).collect());
    let (tile_sizes, buckets) = (values("tile_size"), values("buckets"));
    type Of<'a> = &'a dyn Fn(&Row) -> Option<f64>;
    let panel = |title: &str, quantity: &str, of: Of<'_>| {
        let series = tile_sizes.iter().map(|tile_size| {
            let is_row = |row: &&&Row, number: u64| {
                integer(row, "tile_size") == Some(*tile_size) && integer(row, "buckets") == Some(number)
            };
            let value = |number: &u64| scene.rows.iter().find(|row| is_row(row, *number)).and_then(|row| of(row));
            Series {
                label: format!("tiles of {tile_size}x{tile_size}"),
                values: buckets.iter().map(value).collect(),
                dashed: false,
            }
        });
        SeriesPanel {
            of: None,
            title: title.to_owned(),
            setting: "B (buckets)".to_owned(),
            steps: buckets.iter().map(u64::to_string).collect(),
            quantity: quantity.to_owned(),
            series: series.collect(),
        }
    };
    let diffuse = |row: &Row| row.traces.iter().find(|trace| trace.rays == "diffuse").cloned();
    let counter = |row: &Row, name: &str| Some(diffuse(row)?.counters.get(name)?.per_ray);
    SeriesChart {
        stem: stem(experiment, &format!("_{}", scene.label)),
        title: "DIRT over buckets and tile size".to_owned(),
        subtitle: subtitle(scene),
        key: None,
        panels: vec![
            panel("Structure", "bytes used (MiB)", &|row| Some(PAPER.bytes(row, Scope::Structure)? / MIB)),
            panel("With the paper's own buffers", "bytes, computed (MiB)", &|row| {
                Some(PAPER.bytes(row, Scope::OfPaper)? / MIB)
            }),
            panel("References stored", "references (millions)", &|row| Some(statistic(row, "references")? / 1e6)),
            panel("Build", "build (ms)", &|row| Some(row.build.steady().median_ms)),
            panel("Diffuse rays", "trace (ms)", &|row| Some(diffuse(row)?.times.median_ms)),
            panel("Tests", "triangle tests per diffuse ray", &|row| counter(row, "triangle_tests")),
            panel("Wrong rays", "wrong under tight (%)", &|row| {
                let agreement = agreement(&diffuse(row)?)?;
                Some((1.0 - agreement) * 100.0)
            }),
        ],
    }
}

/// The resolutions of ray images, from the lowest.
fn resolutions(scenes: &[SceneRows<'_>]) -> Vec<[u32; 2]> {
    let images = scenes.iter().flat_map(|scene| &scene.rows).map(|row| row.viewpoint.ray_image);
    images.unique().sorted_by_key(|image| image.map(u64::from).iter().product::<u64>()).collect()
}

fn names(resolutions: &[[u32; 2]]) -> Vec<String> {
    resolutions.iter().map(|[width, height]| format!("{width}x{height}")).collect()
}

/// Traces of every mix solid and builds dashed over resolution, a line a tracer; a chart a scene.
pub(super) fn mixes(page: &Page<'_>) -> Vec<SeriesChart> {
    page.rows.scenes.iter().map(|scene| mixes_of(page.experiment, scene)).collect()
}

fn mixes_of(experiment: &Experiment, scene: &SceneRows<'_>) -> SeriesChart {
    let steps = resolutions(std::slice::from_ref(scene));
    // Of DIRT the tiles' size differs from step to step.
    let label = |row: &Row| if row.tracer.name == "dirt" { "dirt".to_owned() } else { row.tracer.label() };
    let tracers: Vec<String> = scene.rows.iter().map(|row| label(row)).unique().collect();
    let values = |tracer: &str, of: &dyn Fn(&Row) -> Option<f64>| {
        let at = |image: &[u32; 2]| {
            scene
                .rows
                .iter()
                .find(|row| label(row) == tracer && row.viewpoint.ray_image == *image)
                .and_then(|row| of(row))
        };
        steps.iter().map(at).collect::<Vec<_>>()
    };
    let panels = MIXES.iter().map(|(name, mix)| {
        let lines = tracers.iter().flat_map(|tracer| {
            let traced = |row: &Row| Some(total_ms(row, mix)? - host_ms(row.build.steady())?);
            let line = |values, dashed| Series { label: tracer.clone(), values, dashed };
            [line(values(tracer, &traced), false), line(values(tracer, &|row| host_ms(row.build.steady())), true)]
        });
        SeriesPanel {
            of: None,
            title: (*name).to_owned(),
            setting: "rays from the pixels of".to_owned(),
            steps: names(&steps),
            quantity: "time (ms, host clock)".to_owned(),
            series: lines.collect(),
        }
    });
    SeriesChart {
        stem: stem(experiment, &format!("_{}", scene.label)),
        title: "Traces and rebuilds over resolution, DIRT's tiles growing along".to_owned(),
        subtitle: subtitle(scene),
        key: Some(["traces of the mix", "build"]),
        panels: panels.collect(),
    }
}

/// Bytes and references or fragments over resolution, a line a tracer and scene.
pub(super) fn memory_over_resolution(page: &Page<'_>) -> Vec<SeriesChart> {
    let rows = page.rows;
    let steps = resolutions(&rows.scenes);
    let tracers: BTreeSet<&str> =
        rows.scenes.iter().flat_map(|scene| &scene.rows).map(|row| row.tracer.name.as_str()).collect();
    let panel = |title: &str, quantity: &str, of: &dyn Fn(&Row) -> Option<f64>| {
        let lines = rows.scenes.iter().flat_map(|scene| tracers.iter().map(move |tracer| (scene, *tracer)));
        let lines = lines.map(|(scene, tracer)| {
            let at =
                |image: &[u32; 2]| scene.of_tracer(tracer).find(|row| row.viewpoint.ray_image == *image).and_then(of);
            let values = steps.iter().map(at).collect();
            Series { label: scene.label.clone(), values, dashed: tracer == ABUFFER }
        });
        SeriesPanel {
            of: None,
            title: title.to_owned(),
            setting: "R_h = R_l".to_owned(),
            steps: names(&steps),
            quantity: quantity.to_owned(),
            series: lines.collect(),
        }
    };
    vec![SeriesChart {
        stem: stem(page.experiment, ""),
        title: "Structures over resolution".to_owned(),
        subtitle: "one bucket; of DIRT tiles of one pixel".to_owned(),
        key: tracers.contains(ABUFFER).then_some(["dirt", ABUFFER]),
        panels: vec![
            panel("Structure", "bytes used (MiB)", &|row| Some(PAPER.bytes(row, Scope::Structure)? / MIB)),
            panel("With the paper's own buffers", "bytes, computed (MiB)", &|row| {
                Some(PAPER.bytes(row, Scope::OfPaper)? / MIB)
            }),
            panel("References or fragments stored", "stored (millions)", &|row| {
                Some(statistic(row, "references").or_else(|| statistic(row, "fragments"))? / 1e6)
            }),
        ],
    }]
}
