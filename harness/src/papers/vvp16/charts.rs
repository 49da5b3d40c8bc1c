//! Charts of VVP16's figures.

use super::quantities::variants::{STORAGES, UPDATE_MODES, with};
use crate::papers::page::Page;
use crate::papers::page::charts::{stem, subtitle};
use crate::papers::rows::{footprint, trace};
use crate::report::chart::series::{Series, SeriesChart, SeriesPanel};
use crate::results::Row;
use crate::results::host_ms;

/// Traces of every storage over Figure 12's ways, a panel a scene; none where the rays could not be judged.
pub(super) fn variants(page: &Page<'_>) -> Vec<SeriesChart> {
    let experiment = page.experiment;
    let panels = page.rows.scenes.iter().map(|scene| {
        let time = |row: &Row| {
            let traced = trace(row, experiment.rays).filter(|trace| footprint(trace).is_some())?;
            host_ms(&traced.times)
        };
        let line = |storage: &&str| Series {
            label: (*storage).to_owned(),
            values: UPDATE_MODES.iter().map(|(_, way)| with(scene, storage, *way).and_then(time)).collect(),
            dashed: false,
        };
        SeriesPanel {
            of: None,
            title: subtitle(scene),
            setting: "data and skipping".to_owned(),
            steps: UPDATE_MODES.map(|(name, _)| name.to_owned()).to_vec(),
            quantity: "time (ms, host clock)".to_owned(),
            series: STORAGES.iter().map(line).collect(),
        }
    });
    vec![SeriesChart {
        stem: stem(experiment, ""),
        title: "Storages of the A-buffer: plain, decoupled, with skipping".to_owned(),
        subtitle: format!("{} rays in one view", experiment.rays),
        key: None,
        panels: panels.collect(),
    }]
}
