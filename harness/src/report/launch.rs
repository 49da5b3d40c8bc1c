//! What the table of equal launch settings says beside its rows.

use super::format::significant;
use super::group::{Group, RaySet};
use super::sheet::Cell;
use crate::results::{Record, Row, TraceRecord};

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
