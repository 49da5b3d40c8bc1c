//! What charts of experiments share.

use crate::papers::{Experiment, SceneRows};
use crate::report::format::{file_stem, thousands};

/// What the files of a chart are called, without their ends.
pub(in crate::papers) fn stem(experiment: &Experiment, rest: &str) -> String {
    file_stem(&format!("figure_{}{rest}", experiment.name.replace('-', "_")))
}

/// A scene with its triangles.
pub(in crate::papers) fn subtitle(scene: &SceneRows<'_>) -> String {
    let triangles = scene.rows.first().map_or(0, |row| row.scene.triangles);
    format!("{} ({} triangles)", scene.label, thousands(triangles))
}
