//! Rows beside hierarchies, by the comparators of RULES.md.

use std::ptr;

use itertools::Itertools as _;
use serde_json::json;
use tracebench_api::{ClockKind, Query};

use super::cells::TableRow;
use super::document::Document;
use super::format::{NONE, mib, percent, with_interval};
use super::group::{Group, RaySet, Role};
use super::markdown::literal;
use super::metrics::{self, BALANCED, STRUCTURE, Traced};
use super::sheet::{Cell, Column, Columns, Sheet};
use super::summary;
use crate::registry::{Family, TRACERS};
use crate::results::{
    Answer, Caveat, Paired, Record, Row, Timed, TraceRecord, TracerRecord, differ_in_launch, gathered,
};

/// What is compared, with its name.
const SPANS: [(&str, Span); 3] = [
    ("trace", |(row, trace)| Timed::trace(row, trace)),
    ("steady build", |(row, _)| Timed::steady_build(row)),
    ("frame", |(row, trace)| Timed::steady_build(row).and(Timed::trace(row, trace))),
];

type Span = for<'a> fn(Traced<'a>) -> Timed<'a>;

/// What a row stands beside, with its name for people and for programs.
const COMPARATORS: [(Comparator, &str, &str); 3] = [
    (Comparator::Fastest, "fastest hierarchy", "fastest_hierarchy"),
    (Comparator::OnDevice, "fastest hierarchy built on the device", "device_hierarchy"),
    (Comparator::AtBest, "fastest hierarchy, each at its best launch settings", "fastest_hierarchy_at_best"),
];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Comparator {
    /// All, at equal launch settings.
    Fastest,
    /// The same of those that are built and traced on the device, as the row is.
    OnDevice,
    /// All, each at the launch settings by which it is fastest; the row as well.
    AtBest,
}

/// Where rows stand side by side.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) record: &'a Record,
    pub(super) group: &'a Group<'a>,
    pub(super) set: &'a RaySet<'a>,
}

/// How many times as long a row takes as a hierarchy.
struct Beside<'a> {
    hierarchy: &'a Row,
    paired: Paired,
}

impl<'a> Place<'a> {
    fn rows(self) -> impl Iterator<Item = Traced<'a>> {
        self.group.configs.iter().filter_map(move |row| Some((*row, self.set.trace_of(row)?)))
    }

    /// None where no hierarchy is as often right, and at best launch settings where rows have no others.
    fn beside(self, row: &'a Row, span: Span, comparator: Comparator) -> Option<Beside<'a>> {
        let least = |rows: &mut dyn Iterator<Item = Traced<'a>>| {
            let timed = rows.filter_map(|traced| Some((span(traced).host_ms()?, traced)));
            timed.min_by(|(one, _), (other, _)| one.total_cmp(other)).map(|(_, traced)| traced)
        };
        let (own, _) = right_of(self.set.trace_of(row)?)?;
        let at_best = comparator == Comparator::AtBest;
        let as_equal = |other: &Row| row.tracer.launch().zip(other.tracer.launch()).is_none_or(|(own, its)| own == its);
        let stands = |(other, trace): &Traced<'a>| {
            let of_family = TRACERS.iter().any(|each| each.family == Family::Bvh && each.name() == other.tracer.name);
            let is_other = if at_best { !differ_in_launch(row, other) } else { as_equal(other) };
            of_family
                && !ptr::eq(*other, row)
                && is_other
                && (comparator != Comparator::OnDevice || on_device(row) && on_device(other))
                && other.update_mode == row.update_mode
                && right_of(trace).is_some_and(|(right, _)| right >= own)
        };
        let beside = least(&mut self.rows().filter(stands))?;
        let of_row = |(other, _): &Traced<'a>| differ_in_launch(row, other);
        if at_best && self.rows().filter(of_row).map(|(other, _)| other.tracer.launch()).all_equal() {
            return None;
        }
        let one = least(&mut self.rows().filter(|each| if at_best { of_row(each) } else { ptr::eq(each.0, row) }))?;
        Some(Beside { hierarchy: beside.0, paired: self.record.paired_on_host(&span(one), &span(beside)) })
    }
}

fn on_device(row: &Row) -> bool {
    let times = row.traces.iter().map(|trace| &trace.times).chain([&row.build.times]);
    times.into_iter().all(|times| times.clock != ClockKind::Host)
}

impl Beside<'_> {
    /// The ratio with its interval, and whether it is undecided.
    fn said(&self) -> String {
        let Some(ratio) = self.paired.ratio else { return NONE.to_owned() };
        let doubt = match self.paired.answer(0.0) {
            Answer::Undecided(Caveat::Interval) => " undecided".to_owned(),
            Answer::Undecided(why) => format!(" undecided ({why})"),
            Answer::Longer | Answer::Shorter | Answer::Same => String::new(),
        };
        with_interval(ratio.value, ratio.interval, 3) + &doubt
    }

    fn of(&self) -> String {
        format!(" × {}", self.hierarchy.label())
    }
}

/// Columns for programs: every ratio with its interval, and the hierarchy that it is to.
pub(super) fn columns<'a, R: 'a>(of: impl Fn(&R) -> Option<(Place<'a>, TableRow<'a>)> + Copy + 'a) -> Columns<'a, R> {
    let column = |((what, span), (comparator, _, whose)): ((&str, Span), (Comparator, _, &str))| {
        let found = move |row: &R| {
            let (place, (role, row, _)) = of(row)?;
            if role == Role::Tracer { place.beside(row, span, comparator) } else { None }
        };
        let ratio = move |row: &R| found(row).and_then(|found| found.paired.ratio).map_or(Cell::Absent, Cell::from);
        let name = move |row: &R| found(row).map_or(Cell::Absent, |found| found.hierarchy.label().into());
        let title = format!("{}_over_{whose}", what.replace(' ', "_"));
        [Column::csv(&*title, ratio), Column::csv(format!("{title}_name"), name)]
    };
    SPANS.into_iter().cartesian_product(COMPARATORS).flat_map(column).collect()
}

/// What the tables below are of.
const WORDS: &str = "Beside hierarchies of this run that are at least as often right (within the footprint; of any hit by balanced accuracy), \
                     at equal launch settings: how many times as long it takes, by the host's clock, in paired rounds. Intervals cover 99.9 %. A \
                     frame is a steady build and a trace.";

/// How often a trace is right by the rule that comparators go by, and as people read it.
fn right_of(trace: &TraceRecord) -> Option<(f64, String)> {
    let right = *metrics::right_of(trace).last()?;
    Some((right.share?, format!("{} %", percent(right.share?, right.trials))))
}

fn right_heading(query: Query) -> String {
    match query {
        Query::Closest => "right within the footprint ↑".to_owned(),
        Query::Any => BALANCED.heading(),
    }
}

/// The rows of a ray set beside hierarchies.
pub(super) fn table(place: Place<'_>) -> Document {
    let right = |row: &&Row| place.set.trace_of(row).and_then(right_of).map(|(_, said)| said);
    let mut sheet =
        Sheet::<&Row>::new().column("tracer", |row| row.label()).column(right_heading(place.set.query), right);
    for ((what, span), (comparator, whose, _)) in SPANS.into_iter().cartesian_product(COMPARATORS) {
        sheet = sheet.column(format!("{what} over {whose} ↓"), move |row| {
            place.beside(row, span, comparator).map_or(Cell::Absent, |beside| (beside.said() + &beside.of()).into())
        });
    }
    let table = sheet.table(&place.rows().map(|(row, _)| row).collect::<Vec<_>>());
    if table.headings().count() > 2 { Document::default().below(WORDS, table) } else { Document::default() }
}

/// Every tracer over the scenes of a run, if there are several, by ray set: least and most of what it has there.
pub(super) fn over_scenes(record: &Record, groups: &[Group<'_>]) -> Option<Document> {
    let mut page = Document::default();
    let all = groups.iter().flat_map(|group| group.ray_sets.iter().map(move |set| Place { record, group, set }));
    for (rays, places) in gathered(all.map(|place| (place.set.name, place))) {
        let places = &places;
        let scenes = places.iter().map(|place| &place.group.scene.name).unique().count();
        if scenes < 2 {
            continue;
        }
        // A form that differs in nothing from the one before is that one.
        let all = places.iter().flat_map(|place| place.rows()).map(|(row, _)| &row.tracer);
        let labels =
            all.unique_by(|tracer| (&tracer.name, json!(tracer.parameters).to_string())).map(TracerRecord::label);
        let mut sheet = Sheet::<String>::new()
            .column("tracer", String::clone)
            .column(right_heading(places[0].set.query), |label| {
                range(places, label, |_, (_, trace)| right_of(trace).map(|(share, said)| (share, said, String::new())))
            })
            .column(STRUCTURE.heading(), |label| {
                let bytes = |(row, _): (&Row, _)| row.memory.structure_bytes;
                range(places, label, |_, traced| Some((bytes(traced) as f64, mib(bytes(traced)), String::new())))
            });
        for ((what, span), (comparator, whose, _)) in SPANS.into_iter().cartesian_product(COMPARATORS) {
            sheet = sheet.column(format!("{what} over {whose} ↓"), move |label| {
                let beside = |place: Place<'_>, (row, _)| {
                    let found = place.beside(row, span, comparator)?;
                    Some((found.paired.ratio?.value, found.said(), found.of()))
                };
                range(places, label, beside).map_or(Cell::Absent, Cell::from)
            });
        }
        page = page.heading(2, format!("{rays}, over {scenes} scenes")).table(sheet.table(&labels.collect::<Vec<_>>()));
    }
    let head =
        || summary::head(record, "Every tracer over all scenes: where it is best, and where worst").paragraph(WORDS);
    (!page.blocks.is_empty()).then(|| head().and(page))
}

/// What a tracer has in the scenes where it has least and most of it, and beside what, which is told once where it is the same.
fn range<'a>(
    places: &[Place<'a>],
    label: &str,
    of: impl Fn(Place<'a>, Traced<'a>) -> Option<(f64, String, String)>,
) -> Option<String> {
    let of_place = |place: &Place<'a>| {
        let found = of(*place, place.rows().find(|(row, _)| row.tracer.label() == label)?)?;
        Some((found, literal(&place.group.scene.name)))
    };
    from_to(places.iter().filter_map(of_place))
}

/// Of values, what is told of them, what stands behind them, and their places: the least and the greatest, in a word where all are equal. What
/// stands behind is told once where it is the same.
pub(super) fn from_to(found: impl Iterator<Item = ((f64, String, String), String)>) -> Option<String> {
    let found = found.minmax_by(|(one, _), (other, _)| one.0.total_cmp(&other.0));
    let (((_, least, beside), least_in), ((_, most, most_beside), most_in)) = found.into_option()?;
    let between = if beside == most_beside { "" } else { &*beside };
    Some(match least == most {
        true => least + &beside,
        false => format!("{least}{between} ({least_in}) to {most} ({most_in}){most_beside}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::fixture::{self, Quality};
    use crate::report::group::groups;
    use crate::results::{MEMORY_ACCESS, RAYS_PER_LANE};

    const SETS: [(&str, Query); 1] = [("diffuse", Query::Closest)];

    /// Hierarchies and a tracer, by label, share missed, speed and clock, at launch settings of their own where they have any.
    fn record(tracers: &[(&str, f64, f64, ClockKind, Option<u64>)]) -> Record {
        let quality = |missed, speed, clock| Quality { missed, blur: 1e-9, speed, clock };
        let configs: Vec<_> =
            tracers.iter().map(|(name, missed, speed, clock, _)| (*name, quality(*missed, *speed, *clock))).collect();
        let mut record = fixture::with_whole_builds(fixture::run(&configs, &SETS));
        for (row, (.., rays)) in record.rows.iter_mut().zip(tracers) {
            if let Some(rays) = rays {
                row.tracer.parameters.insert(MEMORY_ACCESS.to_owned(), json!("buffer"));
                row.tracer.parameters.insert(RAYS_PER_LANE.to_owned(), json!(rays));
            }
        }
        record
    }

    /// What the first tracer stands beside, by its name, and how many times as long it takes.
    fn beside(record: &Record, comparator: Comparator) -> Option<(String, f64)> {
        let groups = groups(record);
        let place = Place { record, group: &groups[0], set: &groups[0].ray_sets[0] };
        let found = place.beside(&record.rows[0], SPANS[0].1, comparator)?;
        Some((found.hierarchy.tracer.name.clone(), found.paired.ratio?.value))
    }

    /// Proves that a row stands beside the fastest hierarchy that is at least as often right, that none which is wrong more often, is no
    /// hierarchy or has other launch settings takes its place however fast it is (the negative controls), and that of those built on the
    /// device the fastest stands beside it.
    #[test]
    fn a_row_stands_beside_the_fastest_that_is_as_often_right() {
        let (host, device) = (ClockKind::Host, ClockKind::SubmitToDone);
        let own = ("dirt", 0.01, 1.0, device, Some(32));
        let all = [
            own,
            ("bvh-cpu", 0.0, 3.0, host, None),
            ("bvh-gpu", 0.01, 4.0, host, Some(32)),
            ("ploc-gpu", 0.0, 2.0, device, Some(32)),
            ("ray-query", 0.02, 9.0, device, None),
            ("screen-dda", 0.0, 9.0, device, Some(32)),
            ("bvh-gpu", 0.0, 9.0, device, Some(1)),
        ];
        let (name, ratio) = beside(&record(&all), Comparator::Fastest).unwrap();
        assert_eq!(name, "bvh-gpu");
        assert!((3.5..4.5).contains(&ratio), "{ratio}");
        assert_eq!(beside(&record(&all), Comparator::OnDevice).unwrap().0, "ploc-gpu");
        assert!(beside(&record(&[own, all[4]]), Comparator::Fastest).is_none());
        // At best launch settings both are free, where the row has others.
        assert!(beside(&record(&all), Comparator::AtBest).is_none());
        let several = [&[own, ("dirt", 0.01, 2.0, device, Some(1))], &all[1..]].concat();
        let (_, ratio) = beside(&record(&several), Comparator::AtBest).unwrap();
        assert!((4.0..5.0).contains(&ratio), "{ratio}");
    }

    /// Proves that a page over several scenes tells where a tracer is best and worst, that rows for programs have the same ratios, and
    /// that a run of one scene has no such chapter.
    #[test]
    fn scenes_are_told_from_best_to_worst() {
        let host = ClockKind::Host;
        let one = record(&[("dirt", 0.0, 1.0, host, None), ("bvh-cpu", 0.0, 2.0, host, None)]);
        let mut both = one.clone();
        let mut other = record(&[("dirt", 0.0, 1.0, host, None), ("bvh-cpu", 0.0, 8.0, host, None)]);
        other.rows.iter_mut().chain(&mut other.controls).for_each(|row| "hall".clone_into(&mut row.scene.name));
        both.rows.append(&mut other.rows);
        let page = |record: &Record| {
            let folder = tempfile::TempDir::new().unwrap();
            fixture::write_run(record, folder.path(), fixture::tables).unwrap();
            (std::fs::read_to_string(folder.path().join("scenes.md")).ok(), fixture::configs(folder.path()))
        };
        let (text, rows) = page(&both);
        let text = text.unwrap();
        let line = text.lines().find(|line| line.starts_with("| dirt | 100 %")).unwrap();
        let [best, worst] = ["(room) to ", "(hall) × bvh-cpu"].map(|part| line.find(part).unwrap());
        assert!(best < worst, "{line}");
        let name = "trace_over_fastest_hierarchy";
        let ratios: Vec<f64> = rows.iter().filter_map(|row| row[name].parse().ok()).collect();
        assert!(ratios.len() == 2 && ratios[0] < 3.0 && ratios[1] > 6.0, "{ratios:?}");
        assert_eq!(rows[0][&format!("{name}_name")], "bvh-cpu");
        assert_eq!(page(&one).0, None);
    }
}
