//! Which runs stand side by side: those with the same scene, seen from the same viewpoint, with the same rays.

use std::collections::BTreeSet;

use itertools::Itertools as _;
use tracebench_api::{Query, named};

use super::document::{Document, set_heading};
use super::format;
use crate::results::{Paired, Record, Row, SceneRecord, Timed, TraceRecord, ViewpointRecord, same_place};

/// Runs that may be compared.
#[derive(Debug)]
pub(super) struct Group<'a> {
    /// The part of file names that distinguishes groups.
    pub stem: String,
    pub scene: &'a SceneRecord,
    /// The viewpoint; frame and face may differ between tracers.
    pub viewpoint: &'a ViewpointRecord,
    pub controls: Vec<&'a Row>,
    pub configs: Vec<&'a Row>,
    /// The ray sets that any of them traced, in order of first appearance.
    pub ray_sets: Vec<RaySet<'a>>,
}

/// A ray set of a group.
#[derive(Clone, Debug)]
pub(super) struct RaySet<'a> {
    /// Its name, with a hash if another set of the group has the same name.
    pub title: String,
    /// What is asked.
    pub query: Query,
    pub count: u64,
    /// The set's own name, which several may have.
    pub name: &'a str,
    sha256: &'a str,
}

named! {
    /// Whether a row is a control's or a configuration's.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(crate) enum Role {
        /// Its score is known beforehand.
        Control = "control",
        /// What is measured.
        Tracer = "tracer",
    }
}

impl<'a> Group<'a> {
    /// Every run with its role, controls first.
    pub(super) fn all(&self) -> impl Iterator<Item = (Role, &'a Row)> {
        let controls = self.controls.iter().map(|row| (Role::Control, *row));
        controls.chain(self.configs.iter().map(|row| (Role::Tracer, *row)))
    }

    /// Every trace of a ray set, controls last as in the tables.
    pub(super) fn traces(&self, set: &RaySet<'_>) -> Vec<(Role, &'a Row, &'a TraceRecord)> {
        let of_run = |(role, row): (Role, &'a Row)| {
            row.traces.iter().filter(|trace| set.holds(trace)).map(move |trace| (role, row, trace)).collect::<Vec<_>>()
        };
        let mut traces: Vec<_> = self.all().flat_map(of_run).collect();
        traces.sort_by_key(|(role, ..)| *role == Role::Control);
        traces
    }

    /// Whether a row was given the same rays; frame and face shape structures, not rays.
    fn takes(&self, row: &Row) -> bool {
        self.all().next().is_some_and(|(_, first)| same_place(first, row))
    }
}

impl RaySet<'_> {
    /// Below its heading, which says more.
    pub(super) fn headed(&self, level: usize, more: &str) -> Document {
        let heading = set_heading(&self.title, self.query, self.count);
        Document::default().rays(level, self.name, heading + more)
    }

    /// Whether a trace is of these rays.
    pub(super) fn holds(&self, trace: &TraceRecord) -> bool {
        self.name == trace.rays && self.sha256 == trace.rays_sha256 && self.query == trace.query
    }

    /// A row's trace of these rays.
    pub(super) fn trace_of<'a>(&self, row: &'a Row) -> Option<&'a TraceRecord> {
        row.traces.iter().find(|trace| self.holds(trace))
    }

    /// How many times as long one row took over these rays as another.
    pub(super) fn paired(&self, record: &Record, one: &Row, other: &Row) -> Option<Paired> {
        Some(record.paired(&Timed::trace(one, self.trace_of(one)?), &Timed::trace(other, self.trace_of(other)?)))
    }
}

/// Sorts a run into groups, in order of first appearance.
pub(super) fn groups<'a>(record: &'a Record) -> Vec<Group<'a>> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    for first in record.rows.iter().chain(&record.controls) {
        if groups.iter().any(|group| group.takes(first)) {
            continue;
        }
        let here = |row: &&Row| same_place(first, row);
        let configs = record.rows.iter().filter(here).collect_vec();
        let controls = record.controls.iter().filter(here).collect_vec();
        let traces = configs.iter().chain(&controls).flat_map(|row| &row.traces);
        let sets = traces.unique_by(|trace| (&trace.rays, &trace.rays_sha256, trace.query)).collect_vec();
        let ray_set = |trace: &&'a TraceRecord| {
            let TraceRecord { rays: name, rays_sha256: sha256, query, count, .. } = *trace;
            let is_alone = sets.iter().filter(|other| other.rays == *name).count() == 1;
            let title = if is_alone { name.clone() } else { format!("{name} {}", format::hash_prefix(sha256)) };
            RaySet { title, query: *query, count: *count, name, sha256 }
        };
        let (scene, viewpoint, ray_sets) = (&first.scene, &first.viewpoint, sets.iter().map(ray_set).collect());
        groups.push(Group { stem: String::new(), scene, viewpoint, controls, configs, ray_sets });
    }
    let told: Vec<_> =
        groups.iter().map(|each| [&*each.scene.name, &*each.scene.sha256, &*each.viewpoint.name]).collect();
    for (group, stem) in groups.iter_mut().zip(stems(&told)) {
        group.stem = stem;
    }
    groups
}

/// Parts of file names that tell scenes apart, of their names, hashes and viewpoints' names: the scene's name where that is
/// enough; else with the scene's hash, the viewpoint's name, at last a number.
pub(super) fn stems(of: &[[&str; 3]]) -> Vec<String> {
    let plain = |[name, ..]: &[&str; 3]| format::file_stem(name);
    let hashed = |of: &[&str; 3]| format!("{}-{}", plain(of), format::file_stem(&format::hash_prefix(of[1])));
    let whole = |of: &[&str; 3]| format!("{}-{}", hashed(of), format::file_stem(of[2]));
    let all: [Vec<String>; 3] =
        [of.iter().map(plain).collect(), of.iter().map(hashed).collect(), of.iter().map(whole).collect()];
    // Some file systems do not tell capitals from small letters.
    let shared = |names: &[String], name: &str| names.iter().filter(|other| other.eq_ignore_ascii_case(name)).count();
    let mut taken = BTreeSet::new();
    let stem = |index: usize| {
        let own = all.iter().find(|names| shared(names, &names[index]) == 1).unwrap_or(&all[2]);
        let wanted = &own[index];
        let numbered = (2..).map(|number| format!("{wanted}-{number}"));
        std::iter::once(wanted.clone()).chain(numbered).find(|stem| taken.insert(stem.to_ascii_lowercase()))
    };
    (0..of.len()).filter_map(stem).collect()
}
