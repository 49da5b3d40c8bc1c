//! What is read: records with the points that fronts are made of, and the names by which parts of the page are left out.

use std::borrow::Cow;
use std::collections::BTreeMap;

use itertools::Itertools as _;

use super::pieces::Tags;
use crate::report::{RUN_FILE, group};
use crate::results::{FrontPoint, FrontScene, ParetoRecord, Record, Row, said};
use crate::studies::pareto::{Field, RAYS_PER_PIXEL, fields};

/// A record.
#[derive(Debug)]
pub(super) struct Read<'a> {
    /// Where it was read from.
    pub path: &'a str,
    /// What the page calls it.
    pub name: String,
    /// It, as tables show it.
    pub record: Cow<'a, Record>,
    /// Its points, if fronts are made of them: those of a study of fronts; of a plain run every row.
    pub points: Option<ParetoRecord>,
    /// Which machine it is from, from 1.
    pub machine: usize,
}

impl Read<'_> {
    /// Its machine.
    pub(super) fn label(&self) -> String {
        self.record.provenance.machine.label()
    }

    /// Every ray set that fronts are made of.
    pub(super) fn fields(&self) -> Vec<Field<'_>> {
        let scenes = self.points.iter().flat_map(|points| points.scenes.iter().map(move |scene| (points, scene)));
        scenes.flat_map(|(points, scene)| fields(&self.record, points, scene)).collect()
    }
}

/// What the page is made of.
#[derive(Debug)]
pub(super) struct Records<'a> {
    /// Records, each once.
    pub all: Vec<Read<'a>>,
    pub machines: Vec<String>,
    /// Names of records that are the same as another one, with that one's.
    pub copies: Vec<[String; 2]>,
}

/// Reads records, and lists their machines. What is given twice, or lies elsewhere as the same, is one.
pub(super) fn read(records: &[(String, Record)]) -> Records<'_> {
    let machines = records.iter().map(|(_, record)| record.provenance.machine.label()).unique().collect_vec();
    let number = |record: &Record| {
        let label = record.provenance.machine.label();
        1 + machines.iter().position(|machine| *machine == label).unwrap_or(0)
    };
    let names = called(&records.iter().map(|(path, _)| path.as_str()).collect::<Vec<_>>());
    let (mut all, mut copies) = (Vec::new(), Vec::new());
    for (place, ((path, record), name)) in records.iter().zip(&names).enumerate() {
        if let Some(first) = records[..place].iter().position(|(_, known)| known == record) {
            copies.push([name.clone(), names[first].clone()]);
            continue;
        }
        let record = record.aligned();
        all.push(Read { path, name: name.clone(), points: points(&record), machine: number(&record), record });
    }
    Records { all, machines, copies }
}

/// What records are called: the folder of each, with as many of those around it as tell it from the others'.
pub(in crate::report) fn called(paths: &[&str]) -> Vec<String> {
    let folders: Vec<Vec<&str>> = paths.iter().map(|path| folder(path)).collect();
    let tail = |parts: &[&str], count: usize| parts[parts.len().saturating_sub(count)..].join("/");
    let name = |(path, own): (&&str, &Vec<&str>)| {
        let others = || folders.iter().filter(|other| *other != own);
        let is_own = |count: &usize| others().all(|other| tail(other, *count) != tail(own, *count));
        let name = tail(own, (1..own.len()).find(is_own).unwrap_or(own.len()));
        if name.is_empty() { (*path).to_owned() } else { name }
    };
    paths.iter().zip(&folders).map(name).collect()
}

/// The names on the way to the folder of a record.
fn folder(path: &str) -> Vec<&str> {
    let mut parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
    if parts.len() > 1 && parts.last().is_some_and(|last| last.starts_with(RUN_FILE)) {
        parts.pop();
    }
    parts
}

/// The points of a study of fronts; of a plain run every row. Rows of other studies and of tables are not there to be chosen.
fn points(record: &Record) -> Option<ParetoRecord> {
    if record.pareto.is_some() {
        return record.pareto.clone();
    }
    (record.verb() == "run").then(|| {
        let mut points: Vec<FrontPoint> = Vec::new();
        for row in &record.rows {
            let order = points.iter().filter(|point| point.tracer == row.tracer.name).count() as u32;
            let point = point(row, order);
            if points.iter().all(|known| FrontPoint { order, ..known.clone() } != point) {
                points.push(point);
            }
        }
        let scene = |group: group::Group<'_>| FrontScene {
            scene: group.scene.clone(),
            viewpoint: group.viewpoint.clone(),
            held_out_skipped: Some("it is of a plain run".to_owned()),
            ..FrontScene::default()
        };
        let scenes = group::groups(record).into_iter().filter(|group| !group.configs.is_empty()).map(scene).collect();
        ParetoRecord { max_points: points.len() as u32, rays_per_pixel: RAYS_PER_PIXEL.to_vec(), points, scenes }
    })
}

fn point(row: &Row, order: u32) -> FrontPoint {
    let changed = row.tracer.changed.iter();
    let values = changed.filter_map(|name| Some((name.clone(), said(row.tracer.parameters.get(name)?))));
    FrontPoint {
        tracer: row.tracer.name.clone(),
        preset: row.tracer.preset.clone(),
        order,
        values: values.collect(),
        parameters: row.tracer.parameters.clone(),
        frame: row.viewpoint.frame,
        face: row.viewpoint.face,
        skipped: BTreeMap::new(),
    }
}

/// Names of scenes, ray sets and tracers of all records, each once.
#[derive(Debug, Default)]
pub(super) struct Names {
    pub scenes: Vec<String>,
    pub rays: Vec<String>,
    pub tracers: Vec<String>,
}

impl Names {
    /// Of records. Cases are scenes of their own, which the matrix alone shows.
    pub(super) fn of(records: &[Read<'_>]) -> Self {
        let rows = || records.iter().flat_map(|read| &read.record.rows);
        let of_scenes = || records.iter().filter(|read| read.record.cases.is_none()).flat_map(|read| &read.record.rows);
        let rays = of_scenes().flat_map(|row| &row.traces).map(|trace| trace.rays.clone());
        Self {
            scenes: of_scenes().map(|row| row.scene.name.clone()).unique().collect(),
            rays: rays.unique().collect(),
            tracers: rows().map(|row| row.tracer.name.clone()).unique().collect(),
        }
    }

    /// The tracer of a label, which may say more of it.
    pub(super) fn tracer(&self, label: &str) -> Option<&str> {
        let is_of = |name: &&String| {
            let rest = label.strip_prefix(name.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with([' ', ':', '@', ';', ',']))
        };
        self.tracers.iter().filter(is_of).max_by_key(|name| name.len()).map(String::as_str)
    }

    /// What a row is about, by the headings of its columns.
    pub(super) fn of_row(&self, headings: &[&str], cells: &[&str]) -> Tags<'_> {
        fn known<'a>(all: &'a [String], name: &str) -> Option<&'a str> {
            all.iter().find(|known| *known == name).map(String::as_str)
        }
        let mut tags = Tags::default();
        for (heading, cell) in headings.iter().zip(cells) {
            match *heading {
                "scene" => tags.scene = tags.scene.or_else(|| known(&self.scenes, cell)),
                "rays" => tags.rays = tags.rays.or_else(|| known(&self.rays, cell)),
                "tracer" | "point" | "of" | "take" => tags.tracer = tags.tracer.or_else(|| self.tracer(cell)),
                _ => {}
            }
        }
        tags
    }
}
