//! `summary.md`: the run for people. No row tells a speed without the accuracy of the same trace.

use std::collections::BTreeMap;

use itertools::Itertools as _;
use tracebench_api::{AdapterInfo, Query, Rasterizer};

use super::beside::{self, Place};
use super::calibration;
use super::cells::{TableRow, coverage, touched};
use super::chart::{self, runs};
use super::document::Document;
use super::format::{self, mib, significant, size, statistic, thousands};
use super::group::{Group, Role};
use super::markdown::literal;
use super::metrics::{
    self, AMBIGUOUS, BUILD_PEAK, BUILD_TIME, FALSE_FREE, FALSE_OCCLUDED, GEOMETRY, IDENTITY, Metric, POSITION,
    SELF_REPORTED, SPEED, STRUCTURE, TRACE_TIME, TRUE_FREE, TRUE_OCCLUDED,
};
use super::sheet::{Cell, Sheet, Table};
use super::surfaces;
use super::verdict;
use crate::judge::REFERENCE_PIXELS;
use crate::results::{
    Classes, CounterRecord, InterleavedSetRecord, MARK, MIN_ROUNDS, Record, Row, Skipped, StopReason, TraceRecord,
    TracerRecord, ViewpointRecord,
};

/// How many causes a row names.
const TOP_CAUSES: usize = 5;

/// The whole summary.
pub(super) fn summary(record: &Record, groups: &[Group<'_>]) -> Document {
    let mut page = head(record, "tracebench: speed and accuracy of the same rays");
    if groups.is_empty() {
        page = page.paragraph("Nothing ran.");
    }
    for group in groups {
        let sets = group.ray_sets.iter().map(|set| ray_set(Place { record, group, set }));
        page = page.and(scene(record, group)).and(builds(group)).and(sets);
    }
    page.and(skipped(&record.skipped))
}

/// What holds of the whole run, below a title.
pub(crate) fn head(record: &Record, title: &str) -> Document {
    let Record { provenance: from, preset, seed, .. } = record;
    let mut items = vec![("Machine", from.machine.label())];
    if let Some(adapter) = &from.machine.adapter {
        let timestamps = if adapter.timestamps { "device timestamps" } else { "no device timestamps" };
        let AdapterInfo { name, kind, backend, driver, driver_version, .. } = adapter;
        items.push(("Adapter", format!("{name} ({kind}, {backend}, {driver} {driver_version}), {timestamps}")));
    }
    if let Some(found) = &from.machine.rasterizer {
        let Rasterizer { snap_pixels, depth_error, depth_error_beyond_view, reach } = found;
        items.push((
            "Rasterizer",
            format!(
                "borders drawn up to {snap_pixels:.4} pixels from where they are; interpolated depth off by {depth_error:.1e}, of \
                 triangles that reach far out of the view by {depth_error_beyond_view:.1e}; triangles drawn whole up to {reach:.0} heights of \
                 the eye above them"
            ),
        ));
    }
    let memory = from.machine.memory_bytes.map_or_else(|| "unknown".to_owned(), |bytes| format!("{} MiB", mib(bytes)));
    let tree = match from.dirty {
        Some(true) => " with uncommitted changes",
        Some(false) => "",
        None => " (unknown whether the tree was changed)",
    };
    let preset = match preset.as_str() {
        "smoke" => "smoke (smoke run: figures only show that things work)",
        other => other,
    };
    items.extend([
        ("System", format!("{}; memory {memory}; {}", from.machine.os, from.machine.rustc)),
        ("Commit", format!("{}{tree}", from.commit)),
        ("Rules", format!("version {}", from.rules_version)),
        ("Preset", preset.to_owned()),
        ("Seed", seed.to_string()),
        ("Started", from.started.clone()),
        ("Controls", verdict::sentence(&verdict::controls(record))),
    ]);
    let mut page = Document::titled(title).items(items.into_iter().map(|(name, value)| format!("{name}: {value}")));
    if !record.interleaved_sets.is_empty() {
        page = page.items([format!("Clock: {}", clock(record))]);
    }
    if record.provenance.machine.adapter.as_ref().is_some_and(|adapter| adapter.kind == "software") {
        page = page.paragraph(
            "**The adapter is software: accuracy, counters and bytes lead; device times are those of a software adapter and say \
             little of hardware.**",
        );
    }
    if record.rows.iter().any(|row| row.resident_batch > 0) {
        page = page.paragraph(format!(
            "Not all tracers fit one resident batch, in which they take turns. Rows with{MARK} were measured in a later one; their times \
             are set as the first tracer's of their scene, which every resident batch has, was slower or faster there."
        ));
    }
    let ambiguous = metrics::of_ambiguous(record);
    let marks = "↑ more is better, ↓ less is better. 1 MiB is 2^20 bytes.";
    page.and(notes(record)).paragraph(match record.frames {
        Some(_) => format!("{ambiguous} {marks}"),
        None => format!(
            "Times are medians with an order-statistic interval in brackets; shares have 95 % Wilson intervals. {ambiguous} Each time names \
             its clock; times of different clocks do not compare. {marks}"
        ),
    })
}

/// What is to be known before any figure: what the import of a scene warns of, and rays of which shares of right answers say nothing.
pub(super) fn notes(record: &Record) -> Document {
    let of_row = |row: &Row| {
        let scene = literal(&row.scene.name);
        let warning = |text: &String| format!("Import of {scene}: {}.", literal(text.trim_end_matches('.')));
        let one_sided = |trace: &TraceRecord| {
            let (why, view) = (trace.judgement.one_sided()?, literal(&row.viewpoint.name));
            let rays = &trace.rays;
            Some(format!("{scene}, viewpoint {view}, rays {rays}: {why}, so shares of right answers say nothing."))
        };
        let warnings = row.scene.warnings.iter().map(warning);
        warnings.chain(row.traces.iter().filter_map(one_sided)).collect::<Vec<_>>()
    };
    let frames = record.frames.iter().flat_map(|frames| &frames.rows).filter(|series| !series.is_control());
    let of_frames = frames.filter(|series| !series.is_of_this_version()).map(|series| &series.tracer);
    let of_rows = record.rows.iter().filter(|row| !row.is_of_this_version()).map(|row| &row.tracer);
    let stale = of_rows.chain(of_frames).map(TracerRecord::label).unique().join(", ");
    let stale = (!stale.is_empty()).then(|| {
        format!(
            "Measured by an older version of what makes a row ({}): {}.",
            record.provenance.started,
            literal(&stale)
        )
    });
    let notes = stale.into_iter().chain(footprint(record)).chain(record.rows.iter().flat_map(of_row).unique());
    Document::default().items(notes)
}

/// How a sentence on widths of pixels begins.
const FOOTPRINT: &str = "Footprint: one pixel of the reference camera";

/// How many times as wide a pixel of the frame is, and one of a face, as one of the camera that `footprint` is of; none of rays without an
/// eye, which have no viewpoint.
fn widths(row: &Row) -> Option<[f64; 2]> {
    let ViewpointRecord { vertical_fov_degrees, frame: [width, height], face, .. } = row.viewpoint;
    let of_frame = REFERENCE_PIXELS * f64::from(0.5 * vertical_fov_degrees).to_radians().tan() / f64::from(height);
    (width > 0).then(|| [of_frame, REFERENCE_PIXELS / f64::from(face)])
}

/// How wide pixels of frames and faces are, in those of the camera that `footprint` is of.
fn footprint(record: &Record) -> Option<String> {
    let of = |row: &Row| {
        let [of_frame, of_face] = widths(row)?.map(|times| significant(times, 2));
        let ViewpointRecord { frame: [width, height], face, .. } = row.viewpoint;
        let of_frame = format!("at {width}x{height} a frame's is {of_frame} times as wide");
        Some(format!("{of_frame}, at {face}x{face} a face's {of_face} times"))
    };
    let each = record.rows.iter().filter_map(of).unique().join("; ");
    (!each.is_empty()).then(|| format!("{FOOTPRINT}; {each}."))
}

/// The same from the least to the greatest, of rows at many resolutions.
pub(crate) fn footprint_of_many<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Option<String> {
    let all: Vec<[f64; 2]> = rows.into_iter().filter_map(widths).collect();
    let range = |place: usize| {
        let (least, most) = all.iter().map(|each| each[place]).minmax_by(f64::total_cmp).into_option()?;
        let [least, most] = [least, most].map(|times| significant(times, 2));
        Some(if least == most { least } else { format!("{least} to {most}") })
    };
    let (of_frame, of_face) = (range(0)?, range(1)?);
    Some(format!("{FOOTPRINT}; a frame's is {of_frame} times as wide, a face's {of_face} times."))
}

/// How long was sampled, and which interleaved sets decide nothing.
fn clock(record: &Record) -> String {
    let sets = &record.interleaved_sets;
    let (fewest, most) = sets.iter().map(|set| set.orders.len()).minmax().into_option().unwrap_or_default();
    let those = |what: &str, wanted: fn(&InterleavedSetRecord) -> bool| {
        let found = sets.iter().filter(|set| wanted(set));
        let found: Vec<String> = found.map(|set| format!("{} of {}", set.work, literal(&set.scene))).collect();
        if found.is_empty() { String::new() } else { format!("; {what} in {}: {}", found.len(), counted(&found)) }
    };
    let times =
        record.rows.iter().flat_map(|row| row.traces.iter().map(|trace| &trace.times).chain([&row.build.times]));
    let invalid: Vec<String> = times.filter_map(|times| times.invalid.clone()).collect();
    let invalid = match invalid.len() {
        0 => String::new(),
        count => format!("; **invalid times** of {count}: {}", counted(&invalid)),
    };
    let few = if fewest < MIN_ROUNDS as usize { "; fewer than 12 decide nothing" } else { "" };
    format!(
        "{} interleaved sets of {fewest} to {most} rounds{few}{}{}{invalid}",
        sets.len(),
        those("intervals wider than wanted when the time was up", |set| set.stop_reason == StopReason::TimeLimit),
        those("**drift**", |set| set.drift),
    )
}

/// Each of some names once, in the order in which they come first, with how often those come that come again.
fn counted(names: &[String]) -> String {
    let each = |name: &String| match names.iter().filter(|other| *other == name).count() {
        1 => name.clone(),
        times => format!("{name} ({times})"),
    };
    names.iter().unique().map(each).join(", ")
}

fn scene(record: &Record, group: &Group<'_>) -> Document {
    let (scene, viewpoint) = (group.scene, group.viewpoint);
    let scale = scene.scale.map_or_else(String::new, |scale| format!(", scale {scale}"));
    let [x, y, z] = viewpoint.eye.map(|each| significant(f64::from(each), 4));
    let mut page = Document::default().scene(2, scene, "").paragraph(format!(
        "Hash `{}`, diagonal {} scene units{scale}. Viewpoint {} at ({x}, {y}, {z}), {}° vertical field of view, time {} s; rays start from \
         the pixels of a {} image{}.",
        format::hash_prefix(&scene.sha256),
        significant(scene.diagonal, 4),
        literal(&viewpoint.name),
        significant(f64::from(viewpoint.vertical_fov_degrees), 4),
        viewpoint.time_s,
        size(viewpoint.ray_image),
        viewpoint.ray_overrides()
    ));
    if scene.zero_area_triangles_dropped + scene.duplicate_triangles_kept > 0 {
        page = page.paragraph(format!(
            "Import: {} triangles of zero area dropped, {} duplicate triangles kept.",
            thousands(scene.zero_area_triangles_dropped),
            thousands(scene.duplicate_triangles_kept)
        ));
    }
    let [speed, tolerance] = [chart::STEMS[0], chart::STEMS[1]].map(|begin| format!("{begin}{}", group.stem));
    if !group.ray_sets.is_empty() {
        page = page.chart(speed, "Error against speed", runs::speed(record, group));
    }
    if group.ray_sets.iter().any(|set| set.query == Query::Closest) {
        page = page.chart(tolerance, "Agreement over tolerance", runs::tolerance(record, group));
    }
    page
}

fn builds(group: &Group<'_>) -> Document {
    if group.configs.is_empty() {
        return Document::default();
    }
    let mut sheet = Sheet::<&Row>::new()
        .column("tracer", |row| row.label())
        .column("residency", |row| row.tracer.residency.clone())
        .column("frame, faces (px)", |row| format!("{}, {}", size(row.viewpoint.frame), row.viewpoint.face))
        .clock("clock", |row| Some(row.build.first()))
        .builds(BUILD_TIME.label, |row| Some(row))
        .build_phases("phases (ms)", "; ", |row| row)
        .structure(STRUCTURE, |row| Some(row))
        .structure(GEOMETRY, |row| Some(row))
        .structure(BUILD_PEAK, |row| Some(row));
    // Runs of before structures were asked have nothing to say here.
    if group.configs.iter().any(|row| !row.structure_statistics.is_empty()) {
        sheet = sheet.column("what the structure says of itself", |row| {
            row.structure_statistics.iter().map(|(name, value)| format!("{name} {}", statistic(*value))).join("; ")
        });
    }
    Document::default().heading(3, "Build").table(sheet.table(&group.configs))
}

fn ray_set(place: Place<'_>) -> Document {
    let Place { group, set, .. } = place;
    let rows = group.traces(set);
    let many_ambiguous = rows.iter().any(|(.., trace)| trace.judgement.has_many_ambiguous());
    let many_ambiguous = if many_ambiguous { "**More than one ray in a thousand is ambiguous.**" } else { "" };
    let page = set.headed(3, surfaces::heading(&rows)).paragraph(many_ambiguous).paragraph(coverage(&rows));
    let page = match set.query {
        Query::Closest => page.and(closest_tables(&rows)),
        Query::Any => {
            let counts = [TRUE_OCCLUDED, TRUE_FREE, FALSE_OCCLUDED, FALSE_FREE, AMBIGUOUS];
            page.table(traced(Query::Any).figures(told(&rows).into_iter().chain(counts)).table(&rows))
        }
    };
    page.and(beside::table(place))
        .and(surfaces::tables(&rows))
        .below("Causes of wrong answers:", causes(&rows))
        .below("Counters, from a variant that is not timed:", counters(&rows))
        .below("How rays ended:", statuses(&rows))
        .and(calibration::tables(set.query, &rows))
}

/// What every table of traces begins with.
fn traced<'a>(query: Query) -> Sheet<'a, TableRow<'a>> {
    let sheet = Sheet::<TableRow<'_>>::new().name().own_clock().column("rays", |(.., trace)| trace.count);
    sheet.taken(SPEED).taken(TRACE_TIME).right(query)
}

fn closest_tables<'a>(rows: &[TableRow<'a>]) -> Document {
    let beside = metrics::with_ambiguous(rows.iter().map(|(.., trace)| *trace)).into_iter().chain(told(rows));
    let main = traced(Query::Closest).figures(beside.chain([POSITION, IDENTITY, AMBIGUOUS]));
    let by_rule = |row: &TableRow<'a>| {
        let classes = &metrics::closest(row.2)?.classes;
        Some([("tight", &classes.tight), ("footprint", &classes.footprint)].map(|of| (*row, of)))
    };
    let by_rule = rows.iter().filter_map(by_rule).flatten().collect_vec();
    let classes = Sheet::<(TableRow<'_>, (&'static str, &Classes))>::new()
        .name()
        .column("rule", |(_, (rule, _))| *rule)
        .column("true hit", |(_, (_, classes))| classes.true_hit)
        .column("true miss", |(_, (_, classes))| classes.true_miss)
        .column("false hit", |(_, (_, classes))| classes.false_hit)
        .column("false miss", |(_, (_, classes))| classes.false_miss)
        .column("early", |(_, (_, classes))| classes.early)
        .column("late", |(_, (_, classes))| classes.late);
    Document::default().table(main.table(rows)).paragraph("Classes, rays:").table(classes.table(&by_rule))
}

/// The column of times that programs tell of themselves, where one does.
fn told(rows: &[TableRow<'_>]) -> Option<Metric> {
    rows.iter().any(|(.., trace)| trace.self_reported.is_some()).then_some(SELF_REPORTED)
}

/// The rows of tracers that are no controls, each with everything of a kind that its trace tells.
fn each<'a, T>(rows: &[TableRow<'a>], of: impl Fn(&TableRow<'a>) -> Vec<T>) -> Vec<(TableRow<'a>, T)> {
    let configs = rows.iter().filter(|(role, ..)| *role == Role::Tracer);
    configs.flat_map(|row| of(row).into_iter().map(move |each| (*row, each))).collect()
}

fn causes(rows: &[TableRow<'_>]) -> Table {
    type Caused<'a> = (TableRow<'a>, (&'a String, u64, Vec<String>));
    let listed = |causes: &BTreeMap<String, u64>| {
        let all: u64 = causes.values().sum();
        let mut sorted: Vec<_> = causes.iter().filter(|(_, rays)| **rays > 0).collect();
        sorted.sort_by_key(|(name, rays)| (std::cmp::Reverse(**rays), (*name).clone()));
        let share = |rays: u64| rays as f64 / all.max(1) as f64 * 100.0;
        let named = |name: &str, rays: u64| format!("{name} {} ({:.1} %)", thousands(rays), share(rays));
        let mut listed: Vec<_> = sorted.iter().take(TOP_CAUSES).map(|(name, rays)| named(name, **rays)).collect();
        if sorted.len() > TOP_CAUSES {
            listed.push(named("others", sorted[TOP_CAUSES..].iter().map(|(_, rays)| **rays).sum()));
        }
        (all, listed)
    };
    let rows = each(rows, |(.., trace)| {
        let causes = trace.judgement.causes().iter().map(|(rule, causes)| (rule, listed(causes)));
        causes.filter(|(_, (_, listed))| !listed.is_empty()).map(|(rule, (all, listed))| (rule, all, listed)).collect()
    });
    let sheet = Sheet::<Caused<'_>>::new()
        .name()
        .column("rule", |(_, (rule, ..))| (*rule).clone())
        .column("wrong rays", |(_, (_, all, _))| *all)
        .column("causes, most frequent first", |(_, (.., listed))| listed.join(", "));
    sheet.table(&rows)
}

fn counters(rows: &[TableRow<'_>]) -> Table {
    type Counted<'a> = (TableRow<'a>, (&'a String, &'a CounterRecord));
    let whole = |((_, row, _), (name, counter)): &Counted<'_>| touched(row, name, counter);
    let sheet = Sheet::<Counted<'_>>::new()
        .name()
        .column("counter", |(_, (name, _))| (*name).clone())
        .column("mean per ray", |row| whole(row).is_none().then_some(row.1.1.per_ray))
        .column("greatest per ray", |(_, (_, counter))| counter.max_per_ray)
        .column("over the whole set", whole);
    let rows = each(rows, |(.., trace)| trace.counters.iter().collect());
    sheet.table(&rows)
}

fn statuses(rows: &[TableRow<'_>]) -> Table {
    let sheet = Sheet::<(TableRow<'_>, String)>::new()
        .name()
        .column("rays by the status that the tracer gave", |(_, listed)| listed.clone());
    let rows = each(rows, |(.., trace)| {
        let named = trace.statuses.iter().filter(|(_, rays)| **rays > 0);
        let listed = named.map(|(name, rays)| format!("{name} {}", thousands(*rays))).join(", ");
        Some(listed).filter(|listed| !listed.is_empty()).into_iter().collect()
    });
    sheet.table(&rows)
}

/// What did not run, each once: studies ask again from every viewpoint.
pub(crate) fn skipped(skipped: &[Skipped]) -> Document {
    let once: Vec<Skipped> = skipped.iter().unique().cloned().collect();
    let or_all = |name: &Option<String>| name.clone().unwrap_or_else(|| "all".to_owned());
    let sheet = Sheet::<Skipped>::new()
        .column("tracer", |each| or_all(&each.tracer))
        .column("scene", |each| Cell::Name(each.scene.clone()))
        .column("rays", |each| or_all(&each.rays))
        .column("reason", |each| each.reason.clone());
    let page = Document::default().heading(2, "Skipped");
    if once.is_empty() { page.paragraph("Nothing.") } else { page.table(sheet.table(&once)) }
}

#[cfg(test)]
mod tests {
    use super::counted;

    /// Names that come again stand once, where they came first, with how often.
    #[test]
    fn names_that_come_again_are_counted() {
        let names = ["builds of room", "diffuse of room", "builds of room", "ao of hall"].map(str::to_owned);
        assert_eq!(counted(&names), "builds of room (2), diffuse of room, ao of hall");
        assert_eq!(counted(&[]), "");
    }
}
