//! What the table of equal means says beside its rows.

use itertools::Itertools as _;

use super::document::Document;
use super::format::significant;
use super::group::{Group, RaySet};
use super::sheet::{Cell, Sheet};
use crate::results::{Answer, AtMeans, Means, Paired, Run, TraceRecord, TracerRun, at_means};

/// By how much speeds may differ and still be the same, a share.
const SAME: f64 = 0.05;

/// The row of the same tracer by the means that all take where nothing is set.
pub(super) fn by_default<'a>(run: &Run, group: &Group<'a>, of: &TracerRun) -> Option<&'a TracerRun> {
    let default = &run.provenance.means.as_ref()?.means;
    let is_default =
        |row: &&TracerRun| row.tracer.name == of.tracer.name && row.tracer.means().as_ref() == Some(default);
    group.contenders.iter().copied().find(is_default)
}

/// What the table is of, and what is taken where nothing is set.
pub(super) fn default_means(run: &Run) -> String {
    let text = "`reads` is what a search reads the structure from, `rays_per_lane` how many rays a lane answers one after the other; both are \
                the same choice for every tracer. × default is how many times as fast a row is as the same tracer by the means that are taken \
                here where nothing is set.";
    let Some(taken) = &run.provenance.means else { return text.to_owned() };
    let told = taken.probe.as_ref().map(|probe| {
        let (texture, many) = (probe.texture_gain(), probe.many_rays_gain());
        let [texture, many] = [texture, many].map(|gain| significant(gain, 3));
        format!(
            ": in the probe textures were {texture} times as fast as buffers, {} rays a lane {many} times as one",
            probe.many_rays
        )
    });
    format!("{text} Default: {}{}.", taken.means, told.unwrap_or_else(|| ", as given".to_owned()))
}

/// Whether a row answers as the first of its tracer does.
pub(super) fn same_hits(group: &Group<'_>, set: &RaySet<'_>, row: &TracerRun, trace: &TraceRecord) -> Cell {
    let of_tracer = |other: &&&TracerRun| other.tracer.name == row.tracer.name;
    let first = group.contenders.iter().filter(of_tracer).find_map(|other| set.trace_of(other));
    if first.is_none_or(|first| first.hits_sha256 == trace.hits_sha256) { "the same" } else { "OTHERS" }.into()
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
pub(super) fn between(run: &Run, group: &Group<'_>, set: &RaySet<'_>) -> Document {
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
