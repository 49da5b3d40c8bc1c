//! `sweep.csv`: a row a scene, axis, value and ray set, also of what was skipped.

use super::View;
use crate::report::ReportError;
use crate::report::format::clock_code;
use crate::report::metrics;
use crate::report::tables::{code, number, to_csv};
use crate::results::Run;
use crate::results::SweepRecord;

/// Its name.
pub(super) const NAME: &str = "sweep.csv";

/// The whole table.
pub(super) fn table(run: &Run, sweep: &SweepRecord, views: &[View<'_>]) -> Result<Vec<u8>, ReportError> {
    let fixed = [
        "scene",
        "scene_sha256",
        "triangles",
        "viewpoint",
        "tracer",
        "parameter",
        "unit",
        "value",
        "is_own",
        "values_json",
        "parameters_json",
        "frame_px",
        "face_px",
        "rays",
        "query",
        "skipped",
        "rays_sha256",
        "hits_sha256",
        "clock",
        "build_clock",
        "structure_used_bytes",
        "commit",
        "run_preset",
        "machine",
    ];
    let header = fixed.iter().map(|&name| name.to_owned());
    let mut rows = vec![header.chain(metrics::COLUMNS.iter().map(|column| column.name.to_owned())).collect::<Vec<_>>()];
    for view in views {
        let scene = view.group.scene;
        for cell in view.curves.iter().flat_map(|curve| &curve.cells) {
            let point = cell.point;
            let [width, height] = point.frame;
            let mut row = vec![
                scene.name.clone(),
                scene.sha256.clone(),
                scene.triangles.to_string(),
                view.group.viewpoint.name.clone(),
                sweep.tracer.clone(),
                view.axis.name.clone(),
                view.axis.unit.clone(),
                cell.value.to_owned(),
                (cell.value == view.axis.own).to_string(),
                serde_json::to_string(&point.values).unwrap_or_default(),
                serde_json::to_string(&point.parameters).unwrap_or_default(),
                format!("{width}x{height}"),
                point.face.to_string(),
                view.set.title.clone(),
                code(view.set.query),
                point.skipped.get(&scene.name).cloned().unwrap_or_default(),
            ];
            match cell.measured {
                Some((one, trace)) => {
                    let used: u64 = one.memory.structure.iter().map(|entry| entry.used_bytes).sum();
                    row.extend([trace.rays_sha256.clone(), trace.hits_sha256.clone()]);
                    row.extend([clock_code(trace.times.clock), clock_code(one.build.times.clock)].map(str::to_owned));
                    row.push(used.to_string());
                }
                None => row.extend(vec![String::new(); 5]),
            }
            row.extend([run.provenance.commit.clone(), run.preset.clone(), run.provenance.machine.label()]);
            row.extend(metrics::COLUMNS.iter().map(|column| {
                cell.measured.map_or_else(String::new, |(one, trace)| number((column.value)(one, trace)))
            }));
            rows.push(row);
        }
    }
    to_csv(NAME, rows)
}
