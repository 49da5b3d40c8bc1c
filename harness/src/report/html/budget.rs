//! Bytes, times and a share of right answers that a reader may give: the page's script takes from these points whom they leave.

use serde_json::{Value, json};

use super::Place;
use crate::report::metrics;
use crate::report::pareto::page::right;
use crate::report::pareto::{as_read, cost_name};
use crate::studies::pareto::{Aim, Cost, Entry, Wrong};

/// The fields to fill in, of which one asks for so many right answers, the table that follows them, and what it is made of.
pub(super) fn section(places: &[Place<'_>], asked: f64) -> String {
    let [fastest, smallest, quickest] = Aim::ALL.map(Aim::name);
    let [bytes, build, speed] = [Cost::Bytes, Cost::Build, Cost::Trace].map(cost_name);
    let [mib, ms, mrays] = [metrics::STRUCTURE.unit, metrics::BUILD_TIME.unit, metrics::SPEED.unit];
    let limit = |name: &str, said: &str, verb: &str, unit: &str| {
        format!(
            "<label>{said} at {verb} <input type=\"number\" name=\"{name}\" data-said=\"{said}\" data-unit=\"{unit}\" min=\"0\" \
             step=\"any\"> {unit}</label>"
        )
    };
    let [bytes_at_most, build_at_most, frame_at_most, speed_at_least] = [
        limit("mib", "memory", "most", mib),
        limit("build", "build", "most", ms),
        limit("frame", "frame", "most", ms),
        limit("speed", "speed", "least", mrays),
    ];
    let is_shared = places.iter().any(|place| place.is_shared);
    let record = if is_shared { "<th scope=\"col\">record</th>" } else { "" };
    // Whole thousandths of a percent: binary fractions are not for reading.
    let right = (asked * 1e5).round() / 1e3;
    // A script ends at its end tag, wherever that stands.
    let points = json!(places.iter().map(|place| of_place(place, is_shared)).collect::<Vec<_>>())
        .to_string()
        .replace('<', "\\u003c");
    format!(
        r#"<h3>Within your budget</h3>
<p>An empty field asks for nothing. Where nobody meets every limit, the closest is named with what it lacks: of the points that are right so often the one that breaks a limit by the smallest factor; without such a point the most often right one. A frame is one build and so many rays a pixel of the ray image.</p>
<form id="budget" aria-label="Budget">
<label>right at least <input type="number" name="right" min="0" max="100" step="any" value="{right}"> %</label>
{bytes_at_most}
{build_at_most}
{frame_at_most}
<label>of <input type="number" name="pixel" min="0" step="any" value="1"> rays a pixel</label>
{speed_at_least}
<label>take the <select name="aim"><option value="trace">{fastest}</option><option value="mib">{smallest}</option><option value="build">{quickest}</option><option value="frame">quickest frame</option></select></label>
</form>
<div class="wide" tabindex="0"><table id="within"><thead><tr><th scope="col">rays</th><th scope="col">scene</th><th scope="col">machine</th>{record}<th scope="col">take</th><th scope="col">right</th><th scope="col">{bytes}</th><th scope="col">{build}</th><th scope="col">frame ({ms})</th><th scope="col">{speed}</th><th scope="col">why</th></tr></thead><tbody></tbody></table></div>
<script type="application/json" id="budget-points">{points}</script>
"#
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
