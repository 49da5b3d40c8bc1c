//! The tables of fronts: what is told of points, a row an operating point, a row a pair of methods.

use std::collections::BTreeMap;
use std::ptr;

use itertools::Itertools as _;
use tracebench_api::Query;

use crate::report::metrics::{self, COUNT};
use crate::report::sheet::{Cell, Column, Columns, Sheet, Table};
use crate::results::{ParetoRecord, TraceRecord};
use crate::studies::pareto::{
    Aim, Amount, BreakEven, By, Check, Class, ClassCost, Cost, Entry, Field, LEVELS, Wrong, best, break_even, check,
    classes,
};

/// The rules and costs by which a point stands to a front, in the order of columns.
fn kinds(section: &ParetoRecord) -> Vec<(By, Cost)> {
    let rules = [By::all(Query::Closest), By::all(Query::Any)].concat();
    rules.into_iter().cartesian_product(Cost::all(&section.rays_per_pixel)).collect()
}

/// The front of all, and that of a point's own tracer, as columns name them.
const FRONTS: [&str; 2] = ["front", "own_front"];

/// How a column of standings is called.
fn standing(front: &str, (by, cost): (By, Cost)) -> String {
    format!("{front}_{}_{}", by.name(), cost.code())
}

/// How entries stand to fronts, by their places and the names of columns.
type Standings = BTreeMap<(usize, String), &'static str>;

/// How the entries of a field do.
pub(super) fn standings<'a>(field: &Field<'a>) -> Standings {
    let mut all = Standings::new();
    let mut add = |front: &str, entries: &[Entry<'a>], (by, cost): (By, Cost)| {
        for (entry, _, status) in field.front_statuses(entries, cost, by) {
            all.insert((entry.index, standing(front, (by, cost))), status.name());
        }
    };
    for kind in kinds(field.section).into_iter().filter(|(by, _)| By::all(field.query).contains(by)) {
        add(FRONTS[0], &field.entries, kind);
        field.tracers().into_iter().for_each(|tracer| add(FRONTS[1], &field.of_tracer(tracer), kind));
    }
    all
}

/// A point on a ray set.
pub(super) struct Point<'a> {
    field: &'a Field<'a>,
    entry: &'a Entry<'a>,
    standings: &'a Standings,
}

/// The point of a row.
pub(super) fn point<'a>(fields: &'a [(&'a Field<'a>, Standings)], trace: &TraceRecord) -> Option<Point<'a>> {
    fields.iter().find_map(|(field, standings)| {
        let entry = field.entries.iter().find(|entry| ptr::eq(entry.trace, trace))?;
        Some(Point { field, entry, standings })
    })
}

/// What is told of points: what they have on their axes, what they cost, and how they stand to fronts.
pub(super) fn points<'a>(section: &ParetoRecord) -> Sheet<'a, Point<'a>> {
    let fronts = kinds(section).into_iter().cartesian_product(FRONTS).map(|(kind, front)| {
        let name = standing(front, kind);
        Column::csv(name.clone(), move |row: &Point<'a>| row.standings.get(&(row.entry.index, name.clone())).copied())
    });
    Sheet::<Point<'_>>::new()
        .csv_column("order", |row| row.entry.point.order)
        .json("values_json", |row| &row.entry.point.values)
        .with(Cost::all(&section.rays_per_pixel).into_iter().map(cost).collect())
        .with(fronts.collect())
}

/// What a point costs.
fn cost<'a>(cost: Cost) -> Column<'a, Point<'a>> {
    let name = match cost {
        Cost::Trace => "trace_ms".to_owned(),
        Cost::Build => "build_ms".to_owned(),
        Cost::Bytes => "bytes".to_owned(),
        Cost::Frame(_) => format!("{}_ms", cost.code()),
    };
    Column::csv(name, move |row: &Point<'a>| row.field.cost(row.entry, cost))
}

/// An operating point: by rule, level, tracer or all of them, and aim.
pub(super) struct Operating<'a> {
    pub field: &'a Field<'a>,
    pub by: By,
    pub level: f64,
    pub of: &'a str,
    aim: Aim,
    pub found: Entry<'a>,
}

impl Operating<'_> {
    /// What became of it elsewhere.
    pub(super) fn check(&self) -> Check {
        check(self.field, self.found.point, self.by, self.level)
    }

    fn value(&self, cost: Cost) -> Option<f64> {
        Some(self.field.cost(&self.found, cost)?.value)
    }

    /// The same for programs, with how often it is right there.
    fn held_out(&self) -> (&'static str, Option<Amount>) {
        let (what, wrong) = match self.check() {
            Check::Holds(wrong) => ("holds", wrong),
            Check::WithinNoise(wrong) => ("within_noise", wrong),
            Check::Misses(wrong, _) => ("misses", wrong),
            Check::NotMeasured => return ("not_measured", None),
        };
        (what, Some(wrong.share.times(-1.0).and(Amount::exact(1.0))))
    }
}

/// Every operating point.
pub(super) fn operating_points<'a>(fields: impl Iterator<Item = &'a Field<'a>>) -> Vec<Operating<'a>> {
    let mut rows = Vec::new();
    for (field, by, level) in asked(fields) {
        let all = std::iter::once(("all", field.entries.clone()));
        let each = field.tracers().into_iter().map(|tracer| (tracer, field.of_tracer(tracer)));
        for ((of, entries), aim) in all.chain(each).cartesian_product(Aim::ALL) {
            let found = best(field, &entries, by, level, aim);
            rows.extend(found.map(|found| Operating { field, by, level, of, aim, found }));
        }
    }
    rows
}

/// Every ray set with the rules by which its answers are right, and how often they are to be.
fn asked<'a>(fields: impl Iterator<Item = &'a Field<'a>>) -> impl Iterator<Item = (&'a Field<'a>, By, f64)> {
    fields.flat_map(|field| {
        By::all(field.query).iter().cartesian_product(LEVELS).map(move |(by, level)| (field, *by, level))
    })
}

/// A row a scene, ray set, rule, level, tracer and aim.
pub(super) fn operating<'a>(fields: impl Iterator<Item = &'a Field<'a>>) -> Table {
    let sheet = Sheet::<Operating<'_>>::new()
        .csv_column("scene", |row| row.field.scene.scene.name.clone())
        .csv_column("rays", |row| row.field.rays.to_owned())
        .csv_column("rule", |row| row.by.name())
        .csv_column("at_least_share", |row| row.level)
        .csv_column("of", |row| row.of.to_owned())
        .csv_column("aim", |row| row.aim.name())
        .csv_column("tracer", |row| row.found.point.tracer.clone())
        .csv_column("preset", |row| row.found.point.preset.clone())
        .json("values_json", |row| &row.found.point.values)
        .csv_column("trace_ms", |row| row.value(Cost::Trace))
        .csv_column("build_ms", |row| row.value(Cost::Build))
        .csv_column("bytes", |row| row.value(Cost::Bytes))
        .csv_column(COUNT.name, |row| metrics::trials(row.found.trace))
        .csv_column("agreement_share", |row| Wrong::of(row.found.trace, row.by).map(|wrong| 1.0 - wrong.share.value))
        .csv_column("checked_from", |row| Some(row.field.scene.held_out.as_ref()?.viewpoint.name.clone()))
        .csv_column("checked_seed", |row| Some(row.field.scene.held_out.as_ref()?.seed))
        .csv_column("held_out", |row| row.held_out().0)
        .csv_column("checked_agreement_share", |row| row.held_out().1);
    sheet.table(&operating_points(fields))
}

/// Two points of different tracers that are right as often.
struct Pair<'a> {
    class: &'a Class<'a>,
    both: [&'a ClassCost<'a>; 2],
    found: BreakEven,
}

impl Pair<'_> {
    /// What is found, and the cheaper one: always, or below a number of rays.
    fn verdict(&self) -> (&'static str, Option<String>) {
        let (what, who) = match self.found {
            BreakEven::Always(who) => ("always", who),
            BreakEven::At { below, .. } => ("overtakes", below),
            BreakEven::Undecided(_) => return ("undecided", None),
        };
        (what, Some(self.both[who.min(1)].entry.point.label()))
    }
}

/// One of a pair.
fn one_of<'a>(place: usize, name: &str) -> Columns<'a, Pair<'a>> {
    let cost = move |row: &Pair<'a>| row.both[place];
    let traces = move |row: &Pair<'a>| cost(row).cost.traces.parts();
    vec![
        Column::csv(name, move |row| cost(row).entry.point.label()),
        Column::csv(format!("{name}_once_ms"), move |row| cost(row).cost.once.value),
        Column::csv(format!("{name}_trace_ms"), move |row| traces(row)[0].value),
        Column::csv(format!("{name}_per_ray_ms"), move |row| traces(row)[1].value),
        Column::csv(format!("{name}_refitted"), move |row| cost(row).refitted),
    ]
}

/// A row a scene, ray set, rule, level, motion and pair of points of different tracers.
pub(super) fn break_even_counts<'a>(fields: impl Iterator<Item = &'a Field<'a>>) -> Table {
    let all: Vec<Class<'_>> = asked(fields).flat_map(|(field, by, level)| classes(field, by, level)).collect();
    let rows = all.iter().flat_map(|class| {
        let pairs = class.costs.iter().tuple_combinations::<(_, _)>();
        let pairs = pairs.filter(|(one, other)| other.entry.point.tracer != one.entry.point.tracer);
        pairs.map(move |(one, other)| Pair { class, both: [one, other], found: break_even(&one.cost, &other.cost) })
    });
    let sheet = Sheet::<Pair<'_>>::new()
        .csv_column("scene", |row| row.class.field.scene.scene.name.clone())
        .csv_column("rays", |row| row.class.field.rays.to_owned())
        .csv_column("rule", |row| row.class.by.name())
        .csv_column("at_least_share", |row| row.class.level)
        .csv_column("geometry", |row| row.class.motion.name())
        .with(one_of(0, "one"))
        .with(one_of(1, "other"))
        .csv_column("verdict", |row| row.verdict().0)
        .csv_column("cheaper_below", |row| row.verdict().1)
        .csv_column("rays_a_frame", |row| {
            row.found.at().map(|(rays, interval, _)| Cell::Measured(rays, Some(interval), 4))
        })
        .csv_column("beyond_measured", |row| row.found.at().map(|(.., beyond_measured)| beyond_measured))
        .csv_column("why", |row| row.found.undecided().map(str::to_owned));
    sheet.table(&rows.collect_vec())
}
