//! Vardis, Vasilakis, Papaioannou: *A Multiview and Multilayer Approach for Interactive Ray Tracing*, I3D 2016.
//!
//! Papers that measured themselves beside its A-buffer take rows and formula from here.

mod charts;
mod experiments;
mod quantities;
mod sections;
#[cfg(test)]
pub(super) mod tests;

use super::experiment::Values;
use super::{Experiment, ExperimentRow, Paper, Part, SceneRows, Step};
use crate::plan::TracerRequest;
use crate::results::Row;
pub(super) use quantities::memory::bytes_over_formula;

/// The paper.
pub(super) const PAPER: Paper = Paper {
    name: "vvp16",
    experiments: experiments::EXPERIMENTS,
    part: Part { rays: &["diffuse", "pixel-random"], step, row: in_part },
    at_paper: None,
    published: include_str!("published.json"),
    claims_table: "vvp16-claims",
    claims: include_str!("claims.json"),
    quantities: quantities::QUANTITIES,
    counts: &[
        ("references", "references"),
        ("fragments", "fragments"),
        ("covered_pixels", "covered pixels"),
        ("average_layers", "layers of a covered pixel"),
        ("maximum_layers", "most layers"),
    ],
    // Its data are in the structure.
    of_a_trace: &[],
    by_formula,
};

/// What Table 2 counts: the words of pixels, the id buffer and the data buffer.
pub(super) fn by_formula(row: &Row) -> Option<f64> {
    (row.tracer.name == ABUFFER).then(|| quantities::memory::ledger(row).iter().sum())
}

/// Its tracer.
pub(super) const ABUFFER: &str = "fragment-abuffer";

/// Its tracer with every combination of values.
pub(super) const fn abuffer(values: Values) -> ExperimentRow {
    ExperimentRow { tracer: ABUFFER, values }
}

/// The hierarchy that is built on the device, in place of TRBVH.
pub(super) const TRBVH: &str = "ploc-gpu";

/// It, by both trees.
pub(super) const BUILT_ON_DEVICE: ExperimentRow =
    ExperimentRow { tracer: TRBVH, values: &[("tree", &["ploc", "lbvh"])] };

/// Its tracer's row with these values, and else those of its first row.
pub(super) fn row<'a>(scene: &SceneRows<'a>, values: &[(&str, &str)]) -> Option<&'a Row> {
    scene.like_first(ABUFFER, values)
}

/// What the paper calls empty-space skipping, on or off: of depth bounds and of buckets (section 3.4, steps a and b).
pub(super) fn skipping(switch: &str) -> [(&'static str, &str); 2] {
    ["skip_bounds", "skip_buckets"].map(|name| (name, switch))
}

fn step(step: &Step) -> bool {
    (step.resolution, step.faces) == (1.0, 1.0)
}

/// The bench leaves out more than four buckets, of the storages in Figure 12 all but the plainest and the paper's own, a thickness,
/// of views and layers all but one view and one layer, and what the text states.
fn in_part(experiment: &Experiment, request: &TracerRequest) -> bool {
    if request.name() != ABUFFER {
        return true;
    }
    let value = |name: &str| request.parameters.value(name).map(ToString::to_string).unwrap_or_default();
    match experiment.name {
        "vvp16-figure11" => value("thickness") == "0",
        "vvp16-figure12" => ["ll", "dllb"].contains(&&*value("storage")),
        "vvp16-views" => {
            let of_figures = request.changed.iter().any(|name| name == "layers");
            of_figures
                && [["seven", "all"], ["seven", "one"], ["frame", "all"]]
                    .contains(&[&*value("views"), &*value("layers")])
        }
        _ => value("buckets") == "4",
    }
}
