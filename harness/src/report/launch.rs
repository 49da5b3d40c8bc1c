//! What the table of equal launch settings says beside its rows.

use itertools::Itertools as _;

use super::document::Document;
use super::format::significant;
use super::group::{Group, RaySet};
use super::sheet::{Cell, Sheet};
use crate::results::{Answer, AtLaunchSettings, LaunchSettings, Paired, Record, Row, TraceRecord, at_launch_settings};

/// By how much speeds may differ and still be the same, a share.
const SAME: f64 = 0.05;

/// The row of the same tracer by the means that all take where nothing is set.
pub(super) fn by_default<'a>(record: &Record, group: &Group<'a>, of: &Row) -> Option<&'a Row> {
    let default = &record.provenance.launch.as_ref()?.launch;
    let is_default = |row: &&Row| row.tracer.name == of.tracer.name && row.tracer.launch().as_ref() == Some(default);
    group.configs.iter().copied().find(is_default)
}

/// What the table is of, and what is taken where nothing is set.
pub(super) fn default_launch(record: &Record) -> String {
    let text = "`memory_access` is what a search reads the structure from, `rays_per_lane` how many rays a lane answers one after the other; both are \
                the same choice for every tracer. × default is how many times as fast a row is as the same tracer by the means that are taken \
                here where nothing is set.";
    let Some(taken) = &record.provenance.launch else { return text.to_owned() };
    let told = taken.probe.as_ref().map(|probe| {
        let (texture, many) = (probe.texture_gain(), probe.many_rays_gain());
        let [texture, many] = [texture, many].map(|gain| significant(gain, 3));
        format!(
            ": in the probe textures were {texture} times as fast as buffers, {} rays a lane {many} times as one",
            probe.many_rays
        )
    });
    format!("{text} Default: {}{}.", taken.launch, told.unwrap_or_else(|| ", as given".to_owned()))
}

/// Whether a row answers as the first of its tracer does.
pub(super) fn same_hits(group: &Group<'_>, set: &RaySet<'_>, row: &Row, trace: &TraceRecord) -> Cell {
    let of_tracer = |other: &&&Row| other.tracer.name == row.tracer.name;
    let first = group.configs.iter().filter(of_tracer).find_map(|other| set.trace_of(other));
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

/// Every two methods at equal launch settings and at each one's best.
pub(super) fn between(record: &Record, group: &Group<'_>, set: &RaySet<'_>) -> Document {
    type Pair<'a> = (&'a str, &'a str, AtLaunchSettings<Paired>);
    let names = group.configs.iter().map(|row| row.tracer.name.as_str()).unique();
    let of =
        |name: &str| -> Vec<&Row> { group.configs.iter().copied().filter(|row| row.tracer.name == name).collect() };
    let time_ms = |row: &Row| {
        set.trace_of(row).filter(|trace| !trace.times.samples_ms.is_empty()).map(|trace| trace.times.median_ms)
    };
    let mut rows: Vec<Pair<'_>> = Vec::new();
    for (one, other) in names.tuple_combinations() {
        // The time of the other over that of the one is the speed of the one over that of the other.
        let paired = |one: &_, other: &_| set.paired(record, other, one).filter(|found| found.ratio.is_some());
        rows.push((one, other, at_launch_settings(&of(one), &of(other), time_ms, paired)));
    }
    let ratio = |found: &Paired| Cell::number(found.ratio.map(|ratio| ratio.value), 3).describe();
    let sheet = Sheet::<Pair<'_>>::new()
        .column("method", |(one, ..)| (*one).to_owned())
        .column("beside", |(_, other, _)| (*other).to_owned())
        .column("× as fast at equal launch settings", |(.., found)| {
            let equal = found.equal.iter().map(|(launch, found)| format!("{} ({launch})", ratio(found)));
            equal.collect::<Vec<_>>().join(", ")
        })
        .column("× as fast at each one's best", |(.., found)| {
            let (launch, found) = found.best.as_ref()?;
            let [one, other] =
                launch.each_ref().map(|launch| launch.as_ref().map_or_else(String::new, LaunchSettings::to_string));
            Some(format!("{} ({one} beside {other})", ratio(found)))
        })
        .column("so it is", |(.., found)| found.agreed(|found| said(&found.answer(SAME))).unwrap_or("undecided"));
    Document::default().below("", sheet.table(&rows))
}
