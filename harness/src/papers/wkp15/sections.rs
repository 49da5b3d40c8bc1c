//! What pages of WKP15's tables and figures show before their rows.

use super::quantities::reflections::BOUNCES;
use super::quantities::{
    BOXES, CELLS, HIDDEN_LAYER, LEFT_OUT, NODES, OFF_VIEW, SAMPLES, light_field, share_asking_second,
    share_behind_first, share_missed, share_of_cause, tree,
};
use super::{DDA, FIELD, MESH, QUADTREE, SAMPLES_A_RAY};
use crate::papers::SceneRows;
use crate::papers::page::Page;
use crate::papers::page::measured::{self, Accurate, TIMES, ms_of, over, time_of};
use crate::papers::rows::{footprint, integer, per_ray, trace};
use crate::report::document::Document;
use crate::report::sheet::{Cell, Column, Sheet};
use crate::results::{Judgement, Row, TraceRecord, host_ms};

/// A tracer's rays in a place.
struct TableRow<'a> {
    at: SceneRows<'a>,
    /// The first row of the tracer there.
    first: &'a Row,
    row: &'a Row,
    rays: &'a str,
}

impl<'a> TableRow<'a> {
    fn trace(&self) -> Option<&'a TraceRecord> {
        trace(self.row, self.rays)
    }

    fn time(&self) -> Option<Accurate> {
        time_of(self.row, &[self.rays])
    }

    /// Milliseconds over those of the first row.
    fn over_first(&self) -> Cell {
        let [own, first] = [self.row, self.first].map(|row| ms_of(row, &[self.rays]));
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
fn rows<'a>(page: &Page<'a>, sets: impl Fn(&SceneRows<'a>) -> Vec<&'a str>) -> Vec<TableRow<'a>> {
    let mut rows = Vec::new();
    for at in page.rows.scenes.iter().flat_map(SceneRows::by_resolution) {
        let Some(first) = at.like_first(QUADTREE, &[]) else { continue };
        let row = |(rays, row)| TableRow { at: at.clone(), first, row, rays };
        rows.extend(sets(&at).into_iter().flat_map(|rays| at.rows.iter().map(move |row| (rays, *row))).map(row));
    }
    rows
}

/// Those that were traced.
fn traced<'a>(page: &Page<'a>, sets: impl Fn(&SceneRows<'a>) -> Vec<&'a str>) -> Vec<TableRow<'a>> {
    let mut rows = rows(page, sets);
    rows.retain(|row| row.trace().is_some());
    rows
}

/// A table that begins with the scene, with what was said of its rays, and the tracer.
fn sheet<'a>() -> Sheet<'a, TableRow<'a>> {
    let scene = |row: &TableRow<'_>| {
        let said = row.at.rows.first().map_or_else(String::new, |row| row.viewpoint.ray_overrides());
        format!("{}{said}", row.at.label)
    };
    Sheet::new().column("scene", scene).column("tracer", |row| row.row.label())
}

/// How the paper calls a row's method, and its layers.
fn printed_as(row: &Row) -> Option<[String; 2]> {
    let layers = integer(row, "layers").unwrap_or(1).to_string();
    let method = match row.tracer.name.as_str() {
        QUADTREE => "quad-tree",
        DDA => "DDA",
        FIELD => "height field",
        MESH => "mesh warping",
        _ => return None,
    };
    Some([method.to_owned(), layers])
}

/// A value of the published row of a method in a scene over that of the quadtree's single layer.
fn published_over(page: &Page<'_>, row: &Row, column: &str) -> Cell {
    let of = |[method, layers]: [&str; 2]| page.printed_of(row, &[("method", method), ("layers", layers)], column);
    let own = printed_as(row).and_then(|own| of(own.each_ref().map(String::as_str)));
    over(own, of(["quad-tree", "1"]))
}

/// Table 1: construction and drawing by triangles, beside the published construction.
pub(super) fn construction(page: &Page<'_>) -> Document {
    let printed = |heading: &str, column: &'static str, digits| {
        Column::new(heading, move |(_, row): &measured::TableRow<'_>| {
            Cell::number(page.printed_of(row, &[], column), digits)
        })
    };
    let sheet = Sheet::<measured::TableRow<'_>>::new()
        .column("scene", |(scene, _)| Cell::Name(scene.label.clone()))
        .column("triangles", |(_, row)| row.scene.triangles)
        .column("tracer", |(_, row)| row.label())
        .column("nodes that are left", |(_, row)| tree::reachable(row).map(Cell::Statistic))
        .column("trees (ms) ↓", |(_, row)| tree::phase_ms(row)[0])
        .column("drawing the layers (ms) ↓", |(_, row)| tree::phase_ms(row)[1])
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
    let frame_ms = |row: &Row| Some(host_ms(row.build.steady())? + warps * ms_of(row, &[rays])?);
    let printed = |column: &'static str| {
        Column::new(format!("published: {column} ×"), move |row: &TableRow<'_>| published_over(page, row.row, column))
    };
    let sheet = sheet()
        .column("a view (ms) ↓", TableRow::time)
        .column("× one layer", TableRow::over_first)
        .and(printed(one))
        .column("frame with build (ms) ↓", |row| frame_ms(row.row))
        .column("× one layer", |row| over(frame_ms(row.row), frame_ms(row.first)))
        .and(printed(frame))
        .column(VISITS, |row| row.number(visits))
        .column("boxes a ray ↓", |row| row.number(|trace| per_ray(trace, BOXES)))
        .column("depths a ray ↓", |row| row.number(|trace| per_ray(trace, SAMPLES)))
        .column("asking layer 2 (%)", |row| row.percent(share_asking_second));
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
    let counts = |row: &TableRow<'_>| -> Option<[String; 2]> {
        let pixels: f64 = row.row.viewpoint.ray_image.map(f64::from).iter().product();
        let primary = (row.trace()?.count as f64 / pixels).round();
        // The ray itself is one.
        Some([primary.to_string(), (1 + integer(row.row, SAMPLES_A_RAY).unwrap_or(0)).to_string()])
    };
    let printed = |[method, layers]: [&str; 2], [primary, samples]: [&str; 2]| {
        let labels = [("method", method), ("layers", layers), ("N_pri", primary), ("N_sec", samples)];
        page.printed()?.value(&labels, "T_dof")
    };
    let own = |row: &TableRow<'_>| {
        let [method, counts] = [printed_as(row.row)?, counts(row)?];
        printed(method.each_ref().map(String::as_str), counts.each_ref().map(String::as_str))
    };
    let of_one = |row: &TableRow<'_>| printed(["quad-tree", "1"], [&counts(row)?[0], "1"]);
    let sheet = sheet()
        .column("rays", |row| row.trace().map(|trace| trace.count))
        .column("trace (ms) ↓", TableRow::time)
        .column("× first row", TableRow::over_first)
        .column("build and trace (ms) ↓", |row| Some(host_ms(row.row.build.steady())? + row.time()?.value))
        .column("asking layer 2 (%)", |row| row.percent(share_asking_second))
        .column("ending there (%)", |row| row.percent(share_behind_first))
        .column("published: N_pri/N_sec", |row| own(row).and_then(|_| Some(counts(row)?.join("/"))))
        .column("T_dof × one layer's N_pri/1", |row| over(own(row), of_one(row)));
    let rows = traced(page, |_| vec!["lens"]);
    Document::of(format!("{TIMES} Ratios are to the first row of a part.")).table(sheet.table(&rows))
}

/// Table 5: the first bounce and all three, with their ratio beside the published one.
pub(super) fn reflections(page: &Page<'_>) -> Document {
    let ms = |row: &Row| ms_of(row, &BOUNCES);
    let printed = |row: &TableRow<'_>, bounces| {
        let [_, layers] = printed_as(row.row)?;
        let samples = integer(row.row, SAMPLES_A_RAY).unwrap_or(0).to_string();
        let labels = [("layers", &*layers), ("N_p", "3"), ("N_s", &*samples), ("N_b", bounces)];
        page.printed()?.value(&labels, "T_rr")
    };
    let sheet = sheet()
        .column("first bounce (ms) ↓", |row| time_of(row.row, &BOUNCES[..1]))
        .column("three bounces (ms) ↓", |row| time_of(row.row, &BOUNCES))
        .column("three over one", |row| over(ms(row.row), ms_of(row.row, &BOUNCES[..1])))
        .column("mirrored (ms) ↓", TableRow::time)
        .column("× first row, three bounces", |row| over(ms(row.row), ms(row.first)))
        .column("published: three over one", |row| over(printed(row, "3"), printed(row, "1")));
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
        .column("rays", |row| row.rays)
        .column("nodes that are left", |row| tree::reachable(row.row).map(Cell::Statistic))
        .column("nodes a ray ↓", |row| row.number(|trace| per_ray(trace, NODES)))
        .column("time (ms) ↓", TableRow::time)
        .column("× first row", TableRow::over_first)
        .column("wrong under footprint (%) ↓", |row| row.number(footprint).map(|agreement| 100.0 * (1.0 - agreement)))
        .column("median error of t (scene units) ↓", |row| Cell::number(row.number(error), 3));
    let rows = traced(page, SceneRows::ray_sets);
    Document::of(format!("{TIMES} Ratios are to the first row of a scene.")).table(sheet.table(&rows))
}

/// Section 5.3: a light field beside hierarchies.
pub(super) fn light_field(page: &Page<'_>) -> Document {
    let sheet = sheet()
        .column("trace (ms) ↓", TableRow::time)
        .column("× first row", TableRow::over_first)
        .column("asking layer 2 (%)", |row| row.percent(share_asking_second));
    let rows = rows(page, |_| vec![light_field::RAYS]);
    Document::of(format!("{TIMES} Ratios are to the first row of a part.")).table(sheet.table(&rows))
}

/// The text: what rays cost, visit and lose as eye and camera move away, under `footprint`.
pub(super) fn displacement(page: &Page<'_>) -> Document {
    let missed_alone = |row: &TableRow<'_>| {
        let alone = row.at.like_first(QUADTREE, &[("layers", "1"), ("inpainting", "never")])?;
        share_missed(trace(alone, row.rays)?).filter(|share| *share > 0.0)
    };
    let found = |row: &TableRow<'_>| {
        let deeper = row.row.tracer.name == QUADTREE && integer(row.row, "layers").is_some_and(|layers| layers > 1);
        row.percent(|trace| Some(1.0 - share_missed(trace)? / missed_alone(row)?).filter(|_| deeper))
    };
    let sheet = sheet()
        .column("rays", |row| row.rays)
        .column("time (ms) ↓", TableRow::time)
        .column("× first row", TableRow::over_first)
        .column(VISITS, |row| row.number(visits))
        .column("depths a ray ↓", |row| row.number(|trace| per_ray(trace, SAMPLES)))
        .column("asking layer 2 (%)", |row| row.percent(share_asking_second))
        .column("missed (%) ↓", |row| row.percent(share_missed))
        .column("found of what one layer misses (%) ↑", found)
        .column("wrong: hidden layer (%) ↓", |row| row.percent(|trace| share_of_cause(trace, HIDDEN_LAYER)))
        .column("wrong: left out (%) ↓", |row| row.percent(|trace| share_of_cause(trace, LEFT_OUT)))
        .column("wrong: off view (%) ↓", |row| row.percent(|trace| share_of_cause(trace, OFF_VIEW)));
    let rows = traced(page, SceneRows::ray_sets);
    Document::of(format!("{TIMES} Ratios are to the first row of a part.")).table(sheet.table(&rows))
}
