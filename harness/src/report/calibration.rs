//! What a summary says of whether a tracer knows when it is wrong: how often answers of each status are right, what a tracer would hand over to
//! another one that trusts some statuses, and what that costs where it is done.

use std::collections::BTreeMap;

use tracebench_api::{Query, Status};

use super::cells::TableRow;
use super::document::Document;
use super::group::Role;
use super::metrics::TRACE_TIME;
use super::sheet::{Cell, Sheet, Table};
use crate::results::{OCCLUSION, Row, Rule, StatusCounts, Times, TraceRecord};
use crate::statistics::wilson;

/// Sets of statuses that are trusted, as `trust` names them, without those of no status and of all.
const TRUSTED: [(&str, &[Status]); 2] = [("hit", &[Status::Hit]), ("hit+miss", &[Status::Hit, Status::Miss])];

/// The parameter that names a tracer's second part, and what stands before its phases and parameters.
const SECOND: &str = "then";

/// Answers by status.
type ByStatus<'a> = &'a BTreeMap<String, StatusCounts>;

fn share(part: u64, of: u64) -> Cell {
    if of == 0 { Cell::None } else { Cell::Share(part as f64 / of as f64, wilson(part, of), of) }
}

/// Every table; nothing of records from before answers were counted by status.
pub(super) fn tables(query: Query, rows: &[TableRow<'_>]) -> Document {
    let says = |trace: &TraceRecord| trace.judgement.one_sided().is_none();
    let told: Vec<_> = rows.iter().filter(|(role, _, trace)| *role == Role::Tracer && says(trace)).collect();
    let counted = || told.iter().map(|row| (**row, row.2.judgement.by_status())).filter(|(_, of)| !of.is_empty());
    let rules = if query == Query::Any { vec![OCCLUSION] } else { Rule::ALL.map(Rule::name).to_vec() };
    let statuses: Vec<_> = counted().flat_map(|(row, of)| of.iter().map(move |each| (row, each))).collect();
    let mut sheet = Sheet::<(TableRow<'_>, (&String, &StatusCounts))>::new()
        .name()
        .column("status", |(_, (status, _))| (*status).clone())
        .column("rays", |(_, (_, of))| of.rays);
    for rule in rules.iter().copied() {
        sheet = sheet.column(format!("right by {rule} ↑"), move |(_, (_, of))| share(right(of, rule), of.rays));
    }
    let of_rules = |(row, of)| rules.iter().map(move |rule| (row, (*rule, of)));
    let handed: Vec<_> = counted().flat_map(of_rules).collect();
    Document::default()
        .below("Right answers by the status that the tracer gave:", sheet.table(&statuses))
        .below(
            "What a `trust` in statuses would hand over to another tracer: of wrong rays, and of right ones for nothing. `none` hands over \
             all rays, `all` none:",
            trusts(&handed),
        )
        .below("What was handed over, and what that took:", parts(query, rows))
}

fn right(of: &StatusCounts, rule: &str) -> u64 {
    of.right.get(rule).copied().unwrap_or(0)
}

fn trusts(rows: &[(TableRow<'_>, (&str, ByStatus<'_>))]) -> Table {
    // Wrong and right rays; of a trust those that it hands over.
    let split = |rule: &str, of: ByStatus<'_>, trusted: &[Status]| {
        let handed = of.iter().filter(|(name, _)| !trusted.iter().any(|status| status.name() == *name));
        handed.fold([0, 0], |[wrong, fine], (_, of)| [wrong + of.rays - right(of, rule), fine + right(of, rule)])
    };
    let mut sheet =
        Sheet::<(TableRow<'_>, (&str, ByStatus<'_>))>::new().name().column("rule", |(_, (rule, _))| (*rule).to_owned());
    for (place, kind) in ["wrong rays", "right rays"].into_iter().enumerate() {
        sheet = sheet.column(kind, move |(_, (rule, of))| split(rule, of, &[])[place]);
        for (trust, trusted) in TRUSTED {
            sheet = sheet.column(format!("of {kind} handed over by {trust}"), move |(_, (rule, of))| {
                share(split(rule, of, trusted)[place], split(rule, of, &[])[place])
            });
        }
    }
    sheet.table(rows)
}

/// Of tracers that hand rays over: what each part took, and what a ray takes that is handed over, beside one of the rays that the second
/// part alone was asked.
fn parts(query: Query, rows: &[TableRow<'_>]) -> Table {
    let handed = |(.., trace): &TableRow<'_>| trace.counters.get("rays_handed_over").map(|counter| counter.total);
    let of_second = |times: &Times| {
        let phases = times.phases.iter().filter(|phase| phase.name.split(": ").next() == Some(SECOND));
        let taken: Vec<f64> = phases.map(|phase| phase.median_ms).collect();
        (!taken.is_empty()).then(|| taken.iter().sum::<f64>())
    };
    let ns = |ms: Option<f64>, rays: u64| Cell::number(ms.filter(|_| rays > 0).map(|ms| ms * 1e6 / rays as f64), 4);
    let alone = |(_, row, trace): &TableRow<'_>| {
        let (.., other) = rows.iter().find(|(_, other, _)| is_second(row, other))?;
        (other.times.clock == trace.times.clock && other.times.invalid.is_none())
            .then(|| other.times.median_ms * 1e6 / other.count.max(1) as f64)
    };
    let own: Vec<TableRow<'_>> = rows.iter().filter(|row| handed(row).is_some()).copied().collect();
    Sheet::<TableRow<'_>>::new()
        .name()
        .own_clock()
        .taken(TRACE_TIME)
        .right(query)
        .column("rays handed over", move |row| share(handed(row).unwrap_or(0), row.2.count))
        .phases("phases (ms)", "; ", |(.., trace)| Some(&trace.times))
        .column("a ray handed over (ns) ↓", move |row| ns(of_second(&row.2.times), handed(row).unwrap_or(0)))
        .column("a ray asked of it alone (ns) ↓", move |row| Cell::number(alone(row), 4))
        .table(&own)
}

/// Whether a row is of the second part of another one's tracer, with the same parameters.
fn is_second(row: &Row, other: &Row) -> bool {
    let of = |name: &str| row.tracer.parameters.get(&format!("{SECOND}.{name}")).or(row.tracer.parameters.get(name));
    let named = row.tracer.parameters.get(SECOND).and_then(|name| name.as_str()?.split(':').next());
    named == Some(&other.tracer.name) && other.tracer.parameters.iter().all(|(name, value)| of(name) == Some(value))
}
