//! Charts of WKP15's figures, whose own curves are lost.

use super::quantities::thresholds::{ANGLES, DISTANCES, FIXED, GROWING, over, with};
use crate::papers::SceneRows;
use crate::papers::page::Page;
use crate::papers::page::charts::{stem, subtitle};
use crate::papers::rows::{footprint, trace};
use crate::report::chart::series::{Series, SeriesChart, SeriesPanel};
use crate::results::{Row, host_ms};

/// Time of a ray set; none where the rays could not be judged.
fn time(row: &Row, rays: &str) -> Option<f64> {
    let traced = trace(row, rays).filter(|trace| footprint(trace).is_some())?;
    host_ms(&traced.times)
}

/// Rays that are wrong under `footprint`, percent.
fn wrong(row: &Row, rays: &str) -> Option<f64> {
    Some(100.0 * (1.0 - footprint(trace(row, rays)?)?))
}

type Of = fn(&Row, &str) -> Option<f64>;
const PANELS: [(&str, &str, Of); 2] =
    [("Time", "time (ms, host clock)", time), ("Error", "wrong under footprint (%)", wrong)];

/// Time and error of stereo rays over either threshold, by steps of both, a chart a scene.
pub(super) fn thresholds(page: &Page<'_>) -> Vec<SeriesChart> {
    let steps: Vec<String> =
        ANGLES.iter().zip(DISTANCES).map(|(angle, distance)| format!("{angle}° / {distance}")).collect();
    let chart = |scene: &SceneRows<'_>| {
        let panel = |(title, quantity, of): &(&str, &str, Of)| {
            let line = |(label, rows): (&str, Vec<Option<&Row>>)| Series {
                label: label.to_owned(),
                values: rows.into_iter().map(|row| of(row?, "stereo")).collect(),
                dashed: false,
            };
            SeriesPanel {
                of: None,
                title: (*title).to_owned(),
                setting: "gamma_norm / gamma_dist".to_owned(),
                steps: steps.clone(),
                quantity: (*quantity).to_owned(),
                series: ["gamma_dist, at 3 degrees", "gamma_norm, at 1e-5", "gamma_norm, at any distance"]
                    .into_iter()
                    .zip(over(scene))
                    .map(line)
                    .collect(),
            }
        };
        SeriesChart {
            stem: stem(page.experiment, &format!("_{}", scene.label)),
            title: "Compression of the quadtree: time and error".to_owned(),
            subtitle: format!("{}, stereo rays", subtitle(scene)),
            key: None,
            panels: PANELS.iter().map(panel).collect(),
        }
    };
    page.rows.scenes.iter().map(chart).collect()
}

/// Time and error over both thresholds, fixed solid and growing with depth dashed, a line a ray set; a chart a scene.
pub(super) fn growing(page: &Page<'_>) -> Vec<SeriesChart> {
    let steps: Vec<String> =
        ANGLES.iter().zip(DISTANCES).map(|(angle, distance)| format!("{angle}°, {distance}")).collect();
    let chart = |scene: &SceneRows<'_>| {
        let sets = scene.ray_sets();
        let panel = |(title, quantity, of): &(&str, &str, Of)| {
            let lines = sets.iter().flat_map(|rays| [FIXED, GROWING].map(|grows| (*rays, grows)));
            let line = |(rays, grows): (&str, &str)| {
                let value = |(angle, distance): (&&str, &str)| of(with(scene, angle, distance, grows)?, rays);
                let values = ANGLES.iter().zip(DISTANCES).map(value).collect();
                Series { label: rays.to_owned(), values, dashed: grows == GROWING }
            };
            SeriesPanel {
                of: None,
                title: (*title).to_owned(),
                setting: "gamma_norm, gamma_dist".to_owned(),
                steps: steps.clone(),
                quantity: (*quantity).to_owned(),
                series: lines.map(line).collect(),
            }
        };
        SeriesChart {
            stem: stem(page.experiment, &format!("_{}", scene.label)),
            title: "Thresholds fixed and growing with depth: time and error".to_owned(),
            subtitle: subtitle(scene),
            key: Some(["fixed", "growing with depth"]),
            panels: PANELS.iter().map(panel).collect(),
        }
    };
    page.rows.scenes.iter().map(chart).collect()
}
