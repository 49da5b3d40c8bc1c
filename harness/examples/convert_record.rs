//! Converts records of schema 2 to schema 3, which has the same values under other names: `cargo run --release --example convert_record
//! -- FILE...` (`run.json`, `run.json.gz` or `clock.json`; each is written anew in its place). docs/renames.md lists the names.

use std::io::{Read, Write};
use std::path::Path;
use std::process::ExitCode;

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use serde_json::{Map, Value, json};
use tracebench_harness::results::{Record, SCHEMA};

/// What keys were, and are.
const KEYS: &[(&str, &str)] = &[
    ("aside", "excluded"),
    ("checked", "held_out"),
    ("end", "trace_to"),
    ("ended_by", "stop_reason"),
    ("further", "adaptive"),
    ("greatest_error", "max_error"),
    ("greatest_per_ray", "max_per_ray"),
    ("interval_share", "ratio_precision"),
    ("knob", "difficulty_parameter"),
    ("ladder", "remedies"),
    ("lanes", "participants"),
    ("least_featured", "min_featured"),
    ("least_rounds", "min_rounds"),
    ("many_ties", "many_ambiguous_rays"),
    ("means", "launch"),
    ("most_lost_share", "max_lost_share"),
    ("most_points", "max_points"),
    ("most_times_as_long", "max_slowdown"),
    ("not_checked", "held_out_skipped"),
    ("occluded", "behind_last_layer"),
    ("race", "interleaved_set"),
    ("races", "interleaved_sets"),
    ("rasterizer_room", "rasterizer_tolerance"),
    ("reads", "memory_access"),
    ("runs", "rows"),
    ("strength", "difficulty_level"),
    ("strengths", "difficulty_levels"),
    ("ties", "ambiguous_rays"),
    ("twice", "doubled_work"),
    ("void", "invalid"),
    ("walked", "frame_scene_sha256"),
    ("way", "update_mode"),
    ("window", "resident_batch"),
    ("wrong_by_rung", "wrong_by_remedy"),
];

/// What values were, and are, wherever they stand alone.
const VALUES: &[(&str, &str)] = &[
    ("reads", "memory_access"),
    ("most_rounds", "max_rounds"),
    ("occluded", "behind_last_layer"),
    ("means", "launch-settings"),
];

fn of<'a>(names: &[(&str, &'a str)], was: &'a str) -> &'a str {
    names.iter().find(|(name, _)| *name == was).map_or(was, |(_, is)| is)
}

/// A value under the names of schema 3, which stands below a key.
fn converted(value: Value, below: &str) -> Value {
    match value {
        Value::Object(fields) => fields
            .into_iter()
            .map(|(was, value)| {
                let is = if (below, &*was) == ("way", "frame") { "frame_index" } else { of(KEYS, &was) }.to_owned();
                (is, converted(value, &was))
            })
            .collect::<Map<_, _>>()
            .into(),
        Value::Array(items) => items.into_iter().map(|item| converted(item, below)).collect(),
        Value::String(text) => of(VALUES, &text).replace(" reads=", " memory_access=").into(),
        other => other,
    }
}

fn convert(path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let bytes = std::fs::read(path)?;
    let is_packed = bytes.starts_with(&[0x1f, 0x8b]);
    let mut text = Vec::new();
    if is_packed {
        GzDecoder::new(&bytes[..]).read_to_end(&mut text)?
    } else {
        (&bytes[..]).read_to_end(&mut text)?
    };
    let mut record: Value = serde_json::from_slice(&text)?;
    match record.get("schema").and_then(Value::as_u64) {
        None | Some(2) => {}
        Some(schema) => return Err(format!("schema {schema}, and this converts schema 2").into()),
    }
    record = converted(record, "");
    let text = match record.get_mut("schema") {
        None => serde_json::to_vec(&record)?,
        Some(schema) => {
            *schema = json!(SCHEMA);
            // In the order of the record's fields, and only if it can be one.
            serde_json::to_vec(&Record::read(&serde_json::to_vec(&record)?)?)?
        }
    };
    let bytes = if is_packed {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(&text)?;
        packed.finish()?
    } else {
        text
    };
    Ok(std::fs::write(path, bytes)?)
}

fn main() -> ExitCode {
    for path in std::env::args_os().skip(1) {
        if let Err(reason) = convert(Path::new(&path)) {
            eprintln!("error: {}: {reason}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
