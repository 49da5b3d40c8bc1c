//! What pages of WKP15's tables and figures show before their rows.

use super::quantities::reflections::BOUNCES;
use super::quantities::{
    BOXES, CELLS, HIDDEN_LAYER, LEFT_OUT, NODES, OFF_VIEW, SAMPLES, light_field, share_asking_second,
    share_behind_first, share_missed, share_of_cause, tree,
};
use super::{DDA, FIELD, QUADTREE, SAMPLES_A_RAY};
use crate::papers::page::Page;
use crate::papers::page::measured::{TIMES, strings, time_with_accuracy};
use crate::papers::rows::{footprint, integer, per_ray, trace};
use crate::papers::{PublishedTable, SceneRows};
use crate::report::format::{NONE, optional, statistic, thousands};
use crate::report::markdown::{Table, inline};
use crate::results::{Judgement, TraceRecord, TracerRun, host_ms};

/// Every place of every scene with the first row of the tracer there.
fn places<'a>(page: &Page<'a>) -> Vec<(SceneRows<'a>, &'a TracerRun)> {
    let all = page.rows.scenes.iter().flat_map(SceneRows::by_resolution);
    all.filter_map(|at| Some((at.clone(), at.like_first(QUADTREE, &[])?))).collect()
}

/// Time and accuracy of a ray set in a cell, and the time.
fn timed(run: &TracerRun, sets: &[&str]) -> (String, Option<f64>) {
    let traces: Option<Vec<&TraceRecord>> = sets.iter().map(|rays| trace(run, rays)).collect();
    match traces.and_then(|traces| time_with_accuracy(&traces)) {
        Some((ms, text)) => (text, Some(ms)),
        None => (NONE.to_owned(), None),
    }
}

fn over(own: Option<f64>, first: Option<f64>) -> String {
    optional(own.zip(first).map(|(own, first)| own / first), 3)
}

fn percent(share: Option<f64>) -> String {
    optional(share.map(|share| 100.0 * share), 3)
}

/// What is said of a place's rays, with its scene.
fn named(at: &SceneRows<'_>) -> String {
    let said = at.runs.first().map_or_else(String::new, |run| run.viewpoint.said_of_rays());
    inline(&format!("{}{said}", at.label))
}

/// How the paper calls a row's method, and its layers.
fn printed_as(run: &TracerRun) -> Option<[String; 2]> {
    let layers = integer(run, "layers").unwrap_or(1).to_string();
    let method = match run.tracer.name.as_str() {
        QUADTREE => "quad-tree",
        DDA => "DDA",
        FIELD => "height field",
        _ => return None,
    };
    Some([method.to_owned(), layers])
}

/// A value of the published row of a method in a scene over that of the quadtree's single layer.
fn published_over(table: Option<&PublishedTable>, page: &Page<'_>, run: &TracerRun, column: &str) -> Option<f64> {
    let scene = page.experiment.stands_for(&run.scene)?;
    let [method, layers] = printed_as(run)?;
    let of =
        |method: &str, layers: &str| table?.value(&[("scene", scene), ("method", method), ("layers", layers)], column);
    Some(of(&method, &layers)? / of("quad-tree", "1")?)
}

/// Table 1: construction and drawing by triangles, beside the published construction.
pub(super) fn construction(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&[
        "scene",
        "triangles",
        "tracer",
        "nodes that are left",
        "trees (ms) ↓",
        "drawing the layers (ms) ↓",
        "published: thousand triangles",
        "published: trees (ms)",
    ]));
    for (scene, run) in page.rows.scenes.iter().flat_map(|scene| scene.of_tracer(QUADTREE).map(move |run| (scene, run)))
    {
        let [trees, drawing] = tree::phase_ms(run);
        let printed =
            |column: &str| page.printed()?.value(&[("scene", page.experiment.stands_for(&run.scene)?)], column);
        table.row(&[
            inline(&scene.label),
            thousands(run.scene.triangles),
            run.label(),
            tree::reachable(run).map_or_else(|| NONE.to_owned(), statistic),
            optional(Some(trees), 4),
            optional(Some(drawing), 4),
            optional(printed("Triangle count"), 4),
            optional(printed("Average construction time"), 3),
        ]);
    }
    format!(
        "\nMedians of phases by the clock of the builds; the accuracy of the rays that were traced stands with each row below.\n\n{}",
        table.text
    )
}

/// What a table of peers is about: ray set, warps of a frame, published columns of a warp and of a frame.
struct Warp {
    rays: &'static str,
    warps: f64,
    published: [&'static str; 2],
}

/// What a hierarchy over pixels visits of itself.
const VISITS: &str = "nodes or cells a ray ↓";

/// Nodes of a tree, or cells of a pyramid, a ray.
fn visits(traced: &TraceRecord) -> Option<f64> {
    per_ray(traced, NODES).or_else(|| per_ray(traced, CELLS))
}

/// A table of peers: traces and frames over those of the single layer, beside the same of the paper, with what they visit.
fn beside_peers(page: &Page<'_>, warp: &Warp) -> String {
    let [one, frame] = warp.published;
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "a view (ms) ↓",
        "× one layer",
        &format!("published: {one} ×"),
        "frame with build (ms) ↓",
        "× one layer",
        &format!("published: {frame} ×"),
        VISITS,
        "boxes a ray ↓",
        "depths a ray ↓",
        "asking layer 2 (%)",
    ]));
    for (at, first) in places(page) {
        let frame_ms = |run: &TracerRun, trace: Option<f64>| Some(host_ms(&run.build.times)? + warp.warps * trace?);
        let (_, first_ms) = timed(first, &[warp.rays]);
        for run in &at.runs {
            let Some(traced) = trace(run, warp.rays) else { continue };
            let (cell, ms) = timed(run, &[warp.rays]);
            let count = |name: &str| optional(per_ray(traced, name), 4);
            let second = share_asking_second(traced);
            let printed = |column: &str| optional(published_over(page.printed(), page, run, column), 3);
            table.row(&[
                named(&at),
                run.label(),
                cell,
                over(ms, first_ms),
                printed(one),
                optional(frame_ms(run, ms), 4),
                over(frame_ms(run, ms), frame_ms(first, first_ms)),
                printed(frame),
                optional(visits(traced), 4),
                count(BOXES),
                count(SAMPLES),
                percent(second),
            ]);
        }
    }
    format!("\n{TIMES} Ratios are to the first row of a part.\n\n{}", table.text)
}

/// Table 2: an eye and a frame of two.
pub(super) fn stereo(page: &Page<'_>) -> String {
    beside_peers(page, &Warp { rays: "stereo", warps: 2.0, published: ["T_eye", "T_total"] })
}

/// Table 3: a view, and the build with the three views that it serves.
pub(super) fn temporal(page: &Page<'_>) -> String {
    beside_peers(page, &Warp { rays: "temporal", warps: 3.0, published: ["T_syn", "T_amt"] })
}

/// Table 4: rays a pixel and samples a ray, beside the published times.
pub(super) fn lens(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "rays",
        "trace (ms) ↓",
        "× first row",
        "build and trace (ms) ↓",
        "asking layer 2 (%)",
        "ending there (%)",
        "published: N_pri/N_sec",
        "T_dof × one layer's N_pri/1",
    ]));
    for (at, first) in places(page) {
        let (_, first_ms) = timed(first, &["lens"]);
        for run in &at.runs {
            let Some(traced) = trace(run, "lens") else { continue };
            let (cell, ms) = timed(run, &["lens"]);
            let pixels: f64 = run.viewpoint.ray_image.map(f64::from).iter().product();
            let primary = (traced.count as f64 / pixels).round().to_string();
            // The ray itself is one.
            let samples = (1 + integer(run, SAMPLES_A_RAY).unwrap_or(0)).to_string();
            let of = |method: &str, layers: &str, samples: &str| {
                let labels = [("method", method), ("layers", layers), ("N_pri", &*primary), ("N_sec", samples)];
                page.printed()?.value(&labels, "T_dof")
            };
            let own = printed_as(run).and_then(|[method, layers]| of(&method, &layers, &samples));
            let both = host_ms(&run.build.times).zip(ms).map(|(build, trace)| build + trace);
            let second = share_asking_second(traced);
            table.row(&[
                named(&at),
                run.label(),
                thousands(traced.count),
                cell,
                over(ms, first_ms),
                optional(both, 4),
                percent(second),
                percent(share_behind_first(traced)),
                if own.is_some() { format!("{primary}/{samples}") } else { NONE.to_owned() },
                over(own, of("quad-tree", "1", "1")),
            ]);
        }
    }
    format!("\n{TIMES} Ratios are to the first row of a part.\n\n{}", table.text)
}

/// Table 5: the first bounce and all three, with their ratio beside the published one.
pub(super) fn reflections(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "first bounce (ms) ↓",
        "three bounces (ms) ↓",
        "three over one",
        "mirrored (ms) ↓",
        "× first row, three bounces",
        "published: three over one",
    ]));
    for (at, first) in places(page) {
        let (_, first_ms) = timed(first, &BOUNCES);
        for run in &at.runs {
            let (one, one_ms) = timed(run, &BOUNCES[..1]);
            let (three, three_ms) = timed(run, &BOUNCES);
            let (mirrored, _) = timed(run, &["specular"]);
            let printed = |bounces: &str| {
                let [_, layers] = printed_as(run)?;
                let samples = integer(run, SAMPLES_A_RAY).unwrap_or(0).to_string();
                let labels = [("layers", &*layers), ("N_p", "3"), ("N_s", &*samples), ("N_b", bounces)];
                page.printed()?.value(&labels, "T_rr")
            };
            table.row(&[
                named(&at),
                run.label(),
                one,
                three,
                over(three_ms, one_ms),
                mirrored,
                over(three_ms, first_ms),
                over(printed("3"), printed("1")),
            ]);
        }
    }
    format!("\n{TIMES} Ratios are to the first row of a scene.\n\n{}", table.text)
}

/// Figures 14 and 15: nodes, time and error by threshold.
pub(super) fn thresholds(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "rays",
        "nodes that are left",
        "nodes a ray ↓",
        "time (ms) ↓",
        "× first row",
        "wrong under footprint (%) ↓",
        "median error of t (scene units) ↓",
    ]));
    for (at, first) in places(page) {
        for rays in at.ray_sets() {
            let (_, first_ms) = timed(first, &[rays]);
            for run in &at.runs {
                let Some(traced) = trace(run, rays) else { continue };
                let (cell, ms) = timed(run, &[rays]);
                let error = match &traced.judgement {
                    Judgement::Closest(closest) => closest.position_error.p50,
                    Judgement::Any(_) => None,
                };
                table.row(&[
                    named(&at),
                    run.label(),
                    rays.to_owned(),
                    tree::reachable(run).map_or_else(|| NONE.to_owned(), statistic),
                    optional(per_ray(traced, NODES), 4),
                    cell,
                    over(ms, first_ms),
                    optional(footprint(traced).map(|agreement| 100.0 * (1.0 - agreement)), 4),
                    optional(error, 3),
                ]);
            }
        }
    }
    format!("\n{TIMES} Ratios are to the first row of a scene.\n\n{}", table.text)
}

/// Section 5.3: a light field beside hierarchies.
pub(super) fn light_field(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&["scene", "tracer", "trace (ms) ↓", "× first row", "asking layer 2 (%)"]));
    for (at, first) in places(page) {
        let (_, first_ms) = timed(first, &[light_field::RAYS]);
        for run in &at.runs {
            let (cell, ms) = timed(run, &[light_field::RAYS]);
            let second = trace(run, light_field::RAYS).and_then(share_asking_second);
            table.row(&[named(&at), run.label(), cell, over(ms, first_ms), percent(second)]);
        }
    }
    format!("\n{TIMES} Ratios are to the first row of a part.\n\n{}", table.text)
}

/// The text: what rays cost, visit and lose as eye and camera move away, under `footprint`.
pub(super) fn displacement(page: &Page<'_>) -> String {
    let mut table = Table::new(&strings(&[
        "scene",
        "tracer",
        "rays",
        "time (ms) ↓",
        "× first row",
        VISITS,
        "depths a ray ↓",
        "asking layer 2 (%)",
        "missed (%) ↓",
        "found of what one layer misses (%) ↑",
        "wrong: hidden layer (%) ↓",
        "wrong: left out (%) ↓",
        "wrong: off view (%) ↓",
    ]));
    for (at, first) in places(page) {
        let alone = at.like_first(QUADTREE, &[("layers", "1"), ("inpainting", "never")]);
        for rays in at.ray_sets() {
            let (_, first_ms) = timed(first, &[rays]);
            let missed_alone =
                alone.and_then(|run| trace(run, rays)).and_then(share_missed).filter(|share| *share > 0.0);
            for run in &at.runs {
                let Some(traced) = trace(run, rays) else { continue };
                let deeper = run.tracer.name == QUADTREE && integer(run, "layers").is_some_and(|layers| layers > 1);
                let found = share_missed(traced)
                    .zip(missed_alone)
                    .filter(|_| deeper)
                    .map(|(missed, alone)| 1.0 - missed / alone);
                let (cell, ms) = timed(run, &[rays]);
                let second = share_asking_second(traced);
                table.row(&[
                    named(&at),
                    run.label(),
                    rays.to_owned(),
                    cell,
                    over(ms, first_ms),
                    optional(visits(traced), 4),
                    optional(per_ray(traced, SAMPLES), 4),
                    percent(second),
                    percent(share_missed(traced)),
                    percent(found),
                    percent(share_of_cause(traced, HIDDEN_LAYER)),
                    percent(share_of_cause(traced, LEFT_OUT)),
                    percent(share_of_cause(traced, OFF_VIEW)),
                ]);
            }
        }
    }
    format!("\n{TIMES} Ratios are to the first row of a part.\n\n{}", table.text)
}
