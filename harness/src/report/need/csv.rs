//! `need.csv`: a row a scene, viewpoint, tracer, ray set and structure.

use crate::report::ReportError;
use crate::report::tables::{number, to_csv};
use crate::results::{ChangedRays, Run};
use crate::studies::need::{Curve, Step};

/// Its name.
pub(super) const NAME: &str = "need.csv";

/// The whole table.
pub(super) fn table(run: &Run, curves: &[Curve<'_>]) -> Result<Vec<u8>, ReportError> {
    let header = [
        "scene",
        "scene_sha256",
        "viewpoint",
        "is_own_viewpoint",
        "tracer",
        "preset",
        "rule",
        "rays",
        "shrunk_json",
        "parameters_json",
        "frame_px",
        "face_px",
        "skipped",
        "structure_bytes",
        "touched_bytes",
        "compared_rays",
        "newly_wrong_rays",
        "newly_right_rays",
        "lost_share",
        "lost_low_share",
        "lost_high_share",
        "is_enough",
        "times_as_long",
        "times_as_long_low",
        "times_as_long_high",
        "is_enough_in_time",
        "commit",
        "run_preset",
        "machine",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for curve in curves {
        let steps = curve.axes.iter().flat_map(|axis| &axis.steps);
        for step in std::iter::once(&curve.whole).chain(steps).chain(&curve.joint) {
            rows.push(row(run, curve, step));
        }
    }
    to_csv(NAME, rows)
}

fn row(run: &Run, curve: &Curve<'_>, step: &Step<'_>) -> Vec<String> {
    let (record, point) = (curve.record, step.point);
    let [width, height] = point.frame;
    let count = |of: fn(ChangedRays) -> u64| step.changed.map_or_else(String::new, |changed| of(changed).to_string());
    let lost = step.lost();
    let ratio = step.times_as_long.as_ref();
    let told = |enough: bool| step.changed.map_or_else(String::new, |_| enough.to_string());
    vec![
        record.scene.clone(),
        record.scene_sha256.clone(),
        record.viewpoint.clone(),
        (record.view == 0).to_string(),
        record.tracer.clone(),
        record.preset.clone(),
        record.rule.name().to_owned(),
        curve.rays.to_owned(),
        serde_json::to_string(&point.shrunk).unwrap_or_default(),
        serde_json::to_string(&point.parameters).unwrap_or_default(),
        format!("{width}x{height}"),
        point.face.to_string(),
        point.skipped.clone().unwrap_or_default(),
        step.bytes().map_or_else(String::new, |bytes| bytes.to_string()),
        number(step.touched_bytes()),
        count(|changed| changed.rays),
        count(|changed| changed.newly_wrong),
        count(|changed| changed.newly_right),
        number(lost.map(|(value, _)| value)),
        number(lost.map(|(_, [low, _])| low)),
        number(lost.map(|(_, [_, high])| high)),
        told(step.is_enough()),
        number(ratio.map(|ratio| ratio.value)),
        number(ratio.map(|ratio| ratio.interval[0])),
        number(ratio.map(|ratio| ratio.interval[1])),
        told(step.is_enough_in_time()),
        run.provenance.commit.clone(),
        run.preset.clone(),
        run.provenance.machine.label(),
    ]
}
