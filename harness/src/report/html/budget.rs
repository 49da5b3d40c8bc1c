//! Bytes, times and a share of right answers that a reader may give: the page's script takes from these points whom they leave.

use serde_json::{Value, json};

use super::Place;
use crate::report::metrics;
use crate::report::pareto::page::right;
use crate::results::FrontPoint;
use crate::studies::pareto::{Cost, Entry, Wrong};

/// The fields to fill in, the table that follows them, and what it is made of.
pub(super) fn section(places: &[Place<'_>]) -> String {
    // A script ends at its end tag, wherever that stands.
    let points = json!(places.iter().map(of_place).collect::<Vec<_>>()).to_string().replace('<', "\\u003c");
    format!("{FORM}<script type=\"application/json\" id=\"budget-points\">{points}</script>\n")
}

const FORM: &str = r#"<h3>Within your budget</h3>
<p>An empty field asks for nothing. A frame is one build and so many rays a pixel of the ray image.</p>
<form id="budget" aria-label="Budget">
<label>right at least <input type="number" name="right" min="0" max="100" step="any" value="99.9"> %</label>
<label>memory at most <input type="number" name="mib" min="0" step="any"> MiB</label>
<label>build at most <input type="number" name="build" min="0" step="any"> ms</label>
<label>frame at most <input type="number" name="frame" min="0" step="any"> ms</label>
<label>of <input type="number" name="pixel" min="0" step="any" value="1"> rays a pixel</label>
<label>speed at least <input type="number" name="speed" min="0" step="any"> Mrays/s</label>
<label>take the <select name="aim"><option value="trace">fastest</option><option value="mib">smallest</option><option value="build">quickest to build</option><option value="frame">quickest frame</option></select></label>
</form>
<div class="wide" tabindex="0"><table id="within"><thead><tr><th scope="col">rays</th><th scope="col">scene</th><th scope="col">machine</th><th scope="col">take</th><th scope="col">right</th><th scope="col">memory (MiB)</th><th scope="col">build (ms)</th><th scope="col">frame (ms)</th><th scope="col">speed (Mrays/s)</th></tr></thead><tbody></tbody></table></div>
"#;

fn of_place(place: &Place<'_>) -> Value {
    let field = place.field;
    json!({
        "scene": field.scene.scene.name,
        "rays": field.rays,
        "machine": place.read.machine,
        "by": place.by.name(),
        "count": field.count,
        "pixels": field.rays_of_frame(1.0),
        "points": field.entries.iter().filter_map(|entry| of_entry(place, entry)).collect::<Vec<_>>(),
    })
}

/// What a point is, how often it is right as a number and in words, and what it costs; none where it was not judged or not timed.
fn of_entry(place: &Place<'_>, entry: &Entry<'_>) -> Option<Value> {
    let wrong = Wrong::of(entry.trace, place.by)?;
    let [trace, build, bytes] =
        [Cost::Trace, Cost::Build, Cost::Bytes].map(|cost| place.field.cost(entry, cost).map(|cost| cost.value));
    let point: &FrontPoint = entry.point;
    Some(json!([
        point.tracer,
        point.label(),
        1.0 - wrong.share.value,
        right(&wrong, metrics::trials(entry.trace)),
        trace?,
        build?,
        bytes? / f64::from(1 << 20),
    ]))
}
