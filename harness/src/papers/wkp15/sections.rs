//! What pages of WKP15's tables and figures show before their rows.

use super::quantities::reflections::BOUNCES;
use super::quantities::{
    BOXES, CELLS, HIDDEN_LAYER, LEFT_OUT, NODES, OFF_VIEW, SAMPLES, light_field, share_asking_second,
    share_behind_first, share_missed, share_of_cause, tree,
};
use super::{DDA, FIELD, QUADTREE, SAMPLES_A_RAY};
use crate::papers::SceneRows;
use crate::papers::page::Page;
use crate::papers::page::measured::{self, Accurate, TIMES, ms_of, over, time_of};
use crate::papers::rows::{footprint, integer, per_ray, trace};
use crate::report::document::Document;
use crate::report::sheet::{Cell, Column, Sheet};
use crate::results::{Judgement, TraceRecord, TracerRun, host_ms};

/// A tracer's rays in a place.
struct Row<'a> {
    at: SceneRows<'a>,
    /// The first row of the tracer there.
    first: &'a TracerRun,
    run: &'a TracerRun,
    rays: &'a str,
}

impl<'a> Row<'a> {
    fn trace(&self) -> Option<&'a TraceRecord> {
        trace(self.run, self.rays)
    }

    fn time(&self) -> Option<Accurate> {
        time_of(self.run, &[self.rays])
    }

    /// Milliseconds over those of the first row.
    fn over_first(&self) -> Cell {
        let [own, first] = [self.run, self.first].map(|run| ms_of(run, &[self.rays]));
        over(own, first)
    }

    fn number(&self, of: impl Fn(&TraceRecord) -> Option<f64>) -> Option<f64> {
        of(self.trace()?)
    }

    fn percent(&self, of: impl Fn(&TraceRecord) -> Option<f64>) -> Cell {
        Cell::number(self.number(of).map(|share| 100.0 * share), 3)
    }
}

/// Rows of the ray sets of every place of every scene.
fn rows<'a>(page: &Page<'a>, sets: impl Fn(&SceneRows<'a>) -> Vec<&'a str>) -> Vec<Row<'a>> {
    let mut rows = Vec::new();
    for at in page.rows.scenes.iter().flat_map(SceneRows::by_resolution) {
        let Some(first) = at.like_first(QUADTREE, &[]) else { continue };
        let row = |(rays, run)| Row { at: at.clone(), first, run, rays };
        rows.extend(sets(&at).into_iter().flat_map(|rays| at.runs.iter().map(move |run| (rays, *run))).map(row));
    }
    rows
}

/// Those that were traced.
fn traced<'a>(page: &Page<'a>, sets: impl Fn(&SceneRows<'a>) -> Vec<&'a str>) -> Vec<Row<'a>> {
    let mut rows = rows(page, sets);
    rows.retain(|row| row.trace().is_some());
    rows
}

/// A table that begins with the scene, with what was said of its rays, and the tracer.
fn sheet<'a>() -> Sheet<'a, Row<'a>> {
    let scene = |row: &Row<'_>| {
        let said = row.at.runs.first().map_or_else(String::new, |run| run.viewpoint.said_of_rays());
        format!("{}{said}", row.at.label)
    };
    Sheet::new().told("scene", scene).told("tracer", |row| row.run.label())
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
fn published_over(page: &Page<'_>, run: &TracerRun, column: &str) -> Cell {
    let of = |[method, layers]: [&str; 2]| page.printed_of(run, &[("method", method), ("layers", layers)], column);
    let own = printed_as(run).and_then(|own| of(own.each_ref().map(String::as_str)));
    over(own, of(["quad-tree", "1"]))
}

/// Table 1: construction and drawing by triangles, beside the published construction.
pub(super) fn construction(page: &Page<'_>) -> Document {
    let printed = |heading: &str, column: &'static str, digits| {
        Column::told(heading, move |(_, run): &measured::Row<'_>| {
            Cell::number(page.printed_of(run, &[], column), digits)
        })
    };
    let sheet = Sheet::<measured::Row<'_>>::new()
        .told("scene", |(scene, _)| Cell::Name(scene.label.clone()))
        .told("triangles", |(_, run)| run.scene.triangles)
        .told("tracer", |(_, run)| run.label())
        .told("nodes that are left", |(_, run)| tree::reachable(run).map(Cell::Statistic))
        .told("trees (ms) ↓", |(_, run)| tree::phase_ms(run)[0])
        .told("drawing the layers (ms) ↓", |(_, run)| tree::phase_ms(run)[1])
        .and(printed("published: thousand triangles", "Triangle count", 4))
        .and(printed("published: trees (ms)", "Average construction time", 3));
    Document::of("Medians of phases by the clock of the builds; the accuracy of the rays that were traced stands with each row below.").table(sheet.table(&page.of_tracer(QUADTREE).collect::<Vec<_>>()))
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
fn beside_peers(page: &Page<'_>, warp: &Warp) -> Document {
    let Warp { rays, warps, published: [one, frame] } = *warp;
    let frame_ms = |run: &TracerRun| Some(host_ms(run.build.steady())? + warps * ms_of(run, &[rays])?);
    let printed = |column: &'static str| {
        Column::told(format!("published: {column} ×"), move |row: &Row<'_>| published_over(page, row.run, column))
    };
    let sheet = sheet()
        .told("a view (ms) ↓", Row::time)
        .told("× one layer", Row::over_first)
        .and(printed(one))
        .told("frame with build (ms) ↓", |row| frame_ms(row.run))
        .told("× one layer", |row| over(frame_ms(row.run), frame_ms(row.first)))
        .and(printed(frame))
        .told(VISITS, |row| row.number(visits))
        .told("boxes a ray ↓", |row| row.number(|trace| per_ray(trace, BOXES)))
        .told("depths a ray ↓", |row| row.number(|trace| per_ray(trace, SAMPLES)))
        .told("asking layer 2 (%)", |row| row.percent(share_asking_second));
    let rows = traced(page, |_| vec![rays]);
    Document::of(format!("{TIMES} Ratios are to the first row of a part.")).table(sheet.table(&rows))
}

/// Table 2: an eye and a frame of two.
pub(super) fn stereo(page: &Page<'_>) -> Document {
    beside_peers(page, &Warp { rays: "stereo", warps: 2.0, published: ["T_eye", "T_total"] })
}

/// Table 3: a view, and the build with the three views that it serves.
pub(super) fn temporal(page: &Page<'_>) -> Document {
    beside_peers(page, &Warp { rays: "temporal", warps: 3.0, published: ["T_syn", "T_amt"] })
}

/// Table 4: rays a pixel and samples a ray, beside the published times.
pub(super) fn lens(page: &Page<'_>) -> Document {
    let counts = |row: &Row<'_>| -> Option<[String; 2]> {
        let pixels: f64 = row.run.viewpoint.ray_image.map(f64::from).iter().product();
        let primary = (row.trace()?.count as f64 / pixels).round();
        // The ray itself is one.
        Some([primary.to_string(), (1 + integer(row.run, SAMPLES_A_RAY).unwrap_or(0)).to_string()])
    };
    let printed = |[method, layers]: [&str; 2], [primary, samples]: [&str; 2]| {
        let labels = [("method", method), ("layers", layers), ("N_pri", primary), ("N_sec", samples)];
        page.printed()?.value(&labels, "T_dof")
    };
    let own = |row: &Row<'_>| {
        let [method, counts] = [printed_as(row.run)?, counts(row)?];
        printed(method.each_ref().map(String::as_str), counts.each_ref().map(String::as_str))
    };
    let of_one = |row: &Row<'_>| printed(["quad-tree", "1"], [&counts(row)?[0], "1"]);
    let sheet = sheet()
        .told("rays", |row| row.trace().map(|trace| trace.count))
        .told("trace (ms) ↓", Row::time)
        .told("× first row", Row::over_first)
        .told("build and trace (ms) ↓", |row| Some(host_ms(row.run.build.steady())? + row.time()?.value))
        .told("asking layer 2 (%)", |row| row.percent(share_asking_second))
        .told("ending there (%)", |row| row.percent(share_behind_first))
        .told("published: N_pri/N_sec", |row| own(row).and_then(|_| Some(counts(row)?.join("/"))))
        .told("T_dof × one layer's N_pri/1", |row| over(own(row), of_one(row)));
    let rows = traced(page, |_| vec!["lens"]);
    Document::of(format!("{TIMES} Ratios are to the first row of a part.")).table(sheet.table(&rows))
}

/// Table 5: the first bounce and all three, with their ratio beside the published one.
pub(super) fn reflections(page: &Page<'_>) -> Document {
    let ms = |run: &TracerRun| ms_of(run, &BOUNCES);
    let printed = |row: &Row<'_>, bounces| {
        let [_, layers] = printed_as(row.run)?;
        let samples = integer(row.run, SAMPLES_A_RAY).unwrap_or(0).to_string();
        let labels = [("layers", &*layers), ("N_p", "3"), ("N_s", &*samples), ("N_b", bounces)];
        page.printed()?.value(&labels, "T_rr")
    };
    let sheet = sheet()
        .told("first bounce (ms) ↓", |row| time_of(row.run, &BOUNCES[..1]))
        .told("three bounces (ms) ↓", |row| time_of(row.run, &BOUNCES))
        .told("three over one", |row| over(ms(row.run), ms_of(row.run, &BOUNCES[..1])))
        .told("mirrored (ms) ↓", Row::time)
        .told("× first row, three bounces", |row| over(ms(row.run), ms(row.first)))
        .told("published: three over one", |row| over(printed(row, "3"), printed(row, "1")));
    let rows = rows(page, |_| vec!["specular"]);
    Document::of(format!("{TIMES} Ratios are to the first row of a scene.")).table(sheet.table(&rows))
}

/// Figures 14 and 15: nodes, time and error by threshold.
pub(super) fn thresholds(page: &Page<'_>) -> Document {
    let error = |trace: &TraceRecord| match &trace.judgement {
        Judgement::Closest(closest) => closest.position_error.p50,
        Judgement::Any(_) => None,
    };
    let sheet = sheet()
        .told("rays", |row| row.rays)
        .told("nodes that are left", |row| tree::reachable(row.run).map(Cell::Statistic))
        .told("nodes a ray ↓", |row| row.number(|trace| per_ray(trace, NODES)))
        .told("time (ms) ↓", Row::time)
        .told("× first row", Row::over_first)
        .told("wrong under footprint (%) ↓", |row| row.number(footprint).map(|agreement| 100.0 * (1.0 - agreement)))
        .told("median error of t (scene units) ↓", |row| Cell::number(row.number(error), 3));
    let rows = traced(page, SceneRows::ray_sets);
    Document::of(format!("{TIMES} Ratios are to the first row of a scene.")).table(sheet.table(&rows))
}

/// Section 5.3: a light field beside hierarchies.
pub(super) fn light_field(page: &Page<'_>) -> Document {
    let sheet = sheet()
        .told("trace (ms) ↓", Row::time)
        .told("× first row", Row::over_first)
        .told("asking layer 2 (%)", |row| row.percent(share_asking_second));
    let rows = rows(page, |_| vec![light_field::RAYS]);
    Document::of(format!("{TIMES} Ratios are to the first row of a part.")).table(sheet.table(&rows))
}

/// The text: what rays cost, visit and lose as eye and camera move away, under `footprint`.
pub(super) fn displacement(page: &Page<'_>) -> Document {
    let missed_alone = |row: &Row<'_>| {
        let alone = row.at.like_first(QUADTREE, &[("layers", "1"), ("inpainting", "never")])?;
        share_missed(trace(alone, row.rays)?).filter(|share| *share > 0.0)
    };
    let found = |row: &Row<'_>| {
        let deeper = row.run.tracer.name == QUADTREE && integer(row.run, "layers").is_some_and(|layers| layers > 1);
        row.percent(|trace| Some(1.0 - share_missed(trace)? / missed_alone(row)?).filter(|_| deeper))
    };
    let sheet = sheet()
        .told("rays", |row| row.rays)
        .told("time (ms) ↓", Row::time)
        .told("× first row", Row::over_first)
        .told(VISITS, |row| row.number(visits))
        .told("depths a ray ↓", |row| row.number(|trace| per_ray(trace, SAMPLES)))
        .told("asking layer 2 (%)", |row| row.percent(share_asking_second))
        .told("missed (%) ↓", |row| row.percent(share_missed))
        .told("found of what one layer misses (%) ↑", found)
        .told("wrong: hidden layer (%) ↓", |row| row.percent(|trace| share_of_cause(trace, HIDDEN_LAYER)))
        .told("wrong: left out (%) ↓", |row| row.percent(|trace| share_of_cause(trace, LEFT_OUT)))
        .told("wrong: off view (%) ↓", |row| row.percent(|trace| share_of_cause(trace, OFF_VIEW)));
    let rows = traced(page, SceneRows::ray_sets);
    Document::of(format!("{TIMES} Ratios are to the first row of a part.")).table(sheet.table(&rows))
}
