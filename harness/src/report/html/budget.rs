//! Bytes, times and a share of right answers that a reader may give: the page's script takes from these points whom they leave.

use serde_json::{Value, json};

use super::Place;
use crate::report::metrics;
use crate::report::pareto::page::right;
use crate::report::pareto::{as_read, cost_name};
use crate::studies::pareto::{Aim, Cost, Entry, Wrong};

/// The fields to fill in, of which one asks for so many right answers, the table that follows them, and what it is made of.
pub(super) fn section(places: &[Place<'_>], asked: f64) -> String {
    let is_shared = places.iter().any(|place| place.is_shared);
    let points = json!(places.iter().map(|place| of_place(place, is_shared)).collect::<Vec<_>>());
    format!(
        include_str!("budget.html"),
        // Whole thousandths of a percent: binary fractions are not for reading.
        right = (asked * 1e5).round() / 1e3,
        mib = metrics::STRUCTURE.unit,
        ms = metrics::BUILD_TIME.unit,
        mrays = metrics::SPEED.unit,
        record = if is_shared { "<th scope=\"col\">record</th>" } else { "" },
        // A script ends at its end tag, wherever that stands.
        points = points.to_string().replace('<', "\\u003c"),
        fastest = Aim::Fastest.name(),
        smallest = Aim::Smallest.name(),
        quickest = Aim::QuickestBuilt.name(),
        bytes = cost_name(Cost::Bytes),
        build = cost_name(Cost::Build),
        speed = cost_name(Cost::Trace),
    )
}

fn of_place(place: &Place<'_>, is_shared: bool) -> Value {
    let field = place.field;
    json!({
        "scene": field.scene.scene.name,
        "rays": field.rays,
        "machine": place.read.machine,
        "record": is_shared.then_some(&place.read.name),
        "by": place.by.name(),
        "count": field.count,
        "pixels": field.rays_of_frame(1.0),
        "points": field.entries.iter().filter_map(|entry| of_entry(place, entry)).collect::<Vec<_>>(),
    })
}

/// What a point is, how often it is right as a number and in words, and what it costs; none where it was not judged or not timed.
fn of_entry(place: &Place<'_>, entry: &Entry<'_>) -> Option<Value> {
    let wrong = Wrong::of(entry.trace, place.by)?;
    let [trace, build] = [Cost::Trace, Cost::Build].map(|cost| place.field.cost(entry, cost));
    let bytes = place.field.cost(entry, Cost::Bytes)?;
    Some(json!([
        entry.point.tracer,
        entry.point.label(),
        1.0 - wrong.share.value,
        right(&wrong, metrics::trials(entry.trace)),
        trace?.value,
        build?.value,
        as_read(place.field, Cost::Bytes, bytes).value,
    ]))
}
