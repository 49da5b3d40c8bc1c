//! Frames of moving scenes as rows, so that quantities read them as they read runs: the function `frames` tells their figures.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::measure::records;
use crate::results::{BuildRecord, FrameSeries, FramesRecord, MemoryRecord, Record, Row};

/// A record of frames with a row for each tracer in a scene; any other as it is. What its frames come to stands as what its structure says
/// of itself.
pub(crate) fn with_rows(record: &Record) -> Cow<'_, Record> {
    let Some(section) = &record.frames else { return Cow::Borrowed(record) };
    let mut rows: Vec<Row> = Vec::new();
    for own in section.rows.iter().filter(|series| !series.is_control()).map(|series| row(section, series)) {
        match rows.iter_mut().find(|row| (&row.scene, &row.tracer) == (&own.scene, &own.tracer)) {
            Some(row) => row.structure_statistics.extend(own.structure_statistics),
            None => rows.push(own),
        }
    }
    Cow::Owned(Record { rows, ..record.clone() })
}

fn row(section: &FramesRecord, series: &FrameSeries) -> Row {
    let mut figures = BTreeMap::new();
    for (number, frame) in series.frames.iter().enumerate() {
        for (work, row) in &frame.works {
            // Of a set's rays the share that is right under `footprint`.
            let right = row.waves.first().map(|wave| wave.right[2] as f64 / wave.judged as f64);
            let psnr_db = row.image.as_ref().and_then(|image| image.psnr_db);
            let told = [("psnr_db", psnr_db), ("footprint", right)].into_iter();
            figures.extend(told.filter_map(|(name, figure)| Some((format!("{work} {name} {number}"), figure?))));
        }
    }
    let moving = &section.scenes[series.scene as usize];
    Row {
        scene: moving.scene.clone(),
        viewpoint: moving.viewpoints.first().cloned().unwrap_or_default(),
        tracer: series.tracer.clone(),
        fingerprint: series.fingerprint.clone(),
        update_mode: None,
        difficulty_level: None,
        resident_batch: 0,
        machine: series.machine,
        memory: MemoryRecord { structure: Vec::new(), structure_bytes: 0, geometry_bytes: 0, build_peak_bytes: 0 },
        structure_statistics: figures,
        build: BuildRecord { times: records::times(&[], true), first: None, steady: None, setup_ms: 0.0 },
        traces: Vec::new(),
    }
}
