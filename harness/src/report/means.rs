//! The table of equal means over one run: `table_means.md` and `table_means.csv`.

use super::Report;
use super::document::Document;
use super::format::significant;
use super::group::{Group, RaySet, TracedRow, groups, sections, traced, traced_rows};
use super::metrics::{COUNT, SPEED};
use super::sheet::{Cell, Sheet, Table};
use super::{cells, metrics, summary};
use crate::results::{Answer, AtMeans, Means, Paired, Ratio, Run, TracerRun, at_means};
use itertools::Itertools as _;

/// By how much speeds may differ and still be the same, a share.
const SAME: f64 = 0.05;

/// The table.
pub(crate) fn report(run: &Run) -> Report {
    let mut run = run.clone();
    run.runs.retain(|row| row.tracer.means().is_some());
    let groups = groups(&run);
    Report::of_table("table_means", page(&run, &groups), csv(&run, &groups))
}

/// The row of the same tracer by the means that all take where nothing is set.
fn by_default<'a>(run: &Run, group: &Group<'a>, of: &TracerRun) -> Option<&'a TracerRun> {
    let default = &run.provenance.means.as_ref()?.means;
    let is_default =
        |row: &&TracerRun| row.tracer.name == of.tracer.name && row.tracer.means().as_ref() == Some(default);
    group.contenders.iter().copied().find(is_default)
}

fn page(run: &Run, groups: &[Group<'_>]) -> Document {
    let title = "Table means: every tracer that searches on the device, by each way to read and to launch";
    let mut how = String::from(
        "`reads` is what a search reads the structure from, `rays_per_lane` how many rays a lane answers one after the other; both are \
         the same choice for every tracer. × default is how many times as fast a row is as the same tracer by the means that are taken \
         here where nothing is set.",
    );
    if let Some(taken) = &run.provenance.means {
        let told = taken.probe.as_ref().map(|probe| {
            let (texture, many) = (probe.texture_gain(), probe.many_rays_gain());
            let [texture, many] = [texture, many].map(|gain| significant(gain, 3));
            format!(
                ": in the probe textures were {texture} times as fast as buffers, {} rays a lane {many} times as one",
                probe.many_rays
            )
        });
        how += &format!(" Default: {}{}.", taken.means, told.unwrap_or_else(|| ", as given".to_owned()));
    }
    summary::head(run, title)
        .words(how)
        .and(sections(run, groups, structures, |group, set| traces(run, group, set).and(between(run, group, set))))
}

fn structures(group: &Group<'_>) -> Table {
    // The launch does not shape it.
    let built = group.contenders.iter().filter_map(|row| Some((*row, row.tracer.means()?.reads)));
    let rows = built.unique_by(|(row, reads)| (&row.tracer.name, reads.clone())).collect_vec();
    let sheet = Sheet::<(&TracerRun, String)>::new()
        .told("tracer", |(row, reads)| format!("{} reads={reads}", row.tracer.name))
        .build(|(row, _)| Some(row))
        .build_phases("phases of the build (ms)", ", ", |(row, _)| row);
    sheet.table(&rows)
}

fn traces(run: &Run, group: &Group<'_>, set: &RaySet<'_>) -> Document {
    let first = move |row: &TracerRun| {
        let of_tracer = |other: &&&TracerRun| other.tracer.name == row.tracer.name;
        group.contenders.iter().filter(of_tracer).find_map(|other| set.trace_of(other))
    };
    cells::traces(group, set, |sheet| {
        sheet
            // A ratio is a speed: never without its accuracy.
            .told("× default ↑", move |(_, row, trace)| {
                over_default(run, group, set, row).filter(|_| metrics::judged(trace))
            })
            .told("hits", move |(_, row, trace)| {
                let same = first(row).is_none_or(|first| first.hits_sha256 == trace.hits_sha256);
                if same { "the same" } else { "OTHERS" }
            })
    })
}

/// How many times as fast a row is as the same tracer by the means that all take where nothing is set.
fn over_default(run: &Run, group: &Group<'_>, set: &RaySet<'_>, row: &TracerRun) -> Option<Ratio> {
    set.paired(run, by_default(run, group, row)?, row)?.ratio
}

/// What is said of one where this is how long the other takes.
fn said(answer: &Answer) -> &'static str {
    match answer {
        Answer::Longer => "faster",
        Answer::Shorter => "slower",
        Answer::Same => "the same",
        Answer::Undecided(_) => "undecided",
    }
}

/// Every two methods at equal means and at each one's best.
fn between(run: &Run, group: &Group<'_>, set: &RaySet<'_>) -> Document {
    type Pair<'a> = (&'a str, &'a str, AtMeans<Paired>);
    let names = group.contenders.iter().map(|row| row.tracer.name.as_str()).unique();
    let of = |name: &str| -> Vec<&TracerRun> {
        group.contenders.iter().copied().filter(|row| row.tracer.name == name).collect()
    };
    let time_ms = |row: &TracerRun| {
        set.trace_of(row).filter(|trace| !trace.times.samples_ms.is_empty()).map(|trace| trace.times.median_ms)
    };
    let mut rows: Vec<Pair<'_>> = Vec::new();
    for (one, other) in names.tuple_combinations() {
        // The time of the other over that of the one is the speed of the one over that of the other.
        let paired = |one: &_, other: &_| set.paired(run, other, one).filter(|found| found.ratio.is_some());
        rows.push((one, other, at_means(&of(one), &of(other), time_ms, paired)));
    }
    let ratio = |found: &Paired| Cell::number(found.ratio.map(|ratio| ratio.value), 3).told();
    let sheet = Sheet::<Pair<'_>>::new()
        .told("method", |(one, ..)| (*one).to_owned())
        .told("beside", |(_, other, _)| (*other).to_owned())
        .told("× as fast at equal means", |(.., found)| {
            let equal = found.equal.iter().map(|(means, found)| format!("{} ({means})", ratio(found)));
            equal.collect::<Vec<_>>().join(", ")
        })
        .told("× as fast at each one's best", |(.., found)| {
            let (means, found) = found.best.as_ref()?;
            let [one, other] = means.each_ref().map(|means| means.as_ref().map_or_else(String::new, Means::to_string));
            Some(format!("{} ({one} beside {other})", ratio(found)))
        })
        .told("so it is", |(.., found)| found.agreed(|found| said(&found.answer(SAME))).unwrap_or("undecided"));
    Document::default().below("", sheet.table(&rows))
}

fn csv(run: &Run, groups: &[Group<'_>]) -> Table {
    let sheet = Sheet::<TracedRow<'_>>::new()
        .scene(|row| &row.row.scene)
        .column("viewpoint", |row| row.row.viewpoint.name.clone())
        .column("tracer", |row| row.row.tracer.name.clone())
        .column("reads", |row| row.row.tracer.means().map(|means| means.reads))
        .column("rays_per_lane", |row| row.row.tracer.means().map(|means| means.rays_per_lane))
        .build(|row| Some(row.row))
        .rays(|row| Some(row.trace))
        .trace(COUNT, |row| Some(row.trace))
        .clock("clock", |row| Some(&row.trace.times))
        .trace(SPEED, |row| Some(row.trace))
        .ends(["speed_over_default", "speed_over_default_low", "speed_over_default_high"], |row| {
            over_default(run, row.group, row.set, row.row)
        })
        .then(|sheet| traced(sheet, run));
    sheet.table(&traced_rows(groups))
}
