//! Converts records of schema 2 to schema 3, which has the same values under other names, and times to whole nanoseconds, as they are written
//! now: `cargo run --release --example convert_record -- FILE...` (`run.json`, `run.json.gz`, `clock.json` or the folder that holds one; each is
//! written anew in its place). docs/renames.md lists the names.

use std::error::Error;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use serde_json::{Map, Value, json};
use tracebench_harness::hash::sha256_of;
use tracebench_harness::results::{Record, SCHEMA, whole_ns};
use tracebench_harness::statistics::median;

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

/// Every time of a record to whole nanoseconds, and medians of what they are of then.
fn round_times(value: &mut Value, below: &str) {
    match value {
        Value::Object(fields) => {
            fields.iter_mut().for_each(|(key, value)| round_times(value, key));
            for (samples, middle) in
                [("samples_ms", "median_ms"), ("submit_to_done_samples_ms", "submit_to_done_median_ms")]
            {
                let of = fields.get(samples).and_then(Value::as_array);
                let of: Vec<f64> = of.into_iter().flatten().filter_map(Value::as_f64).collect();
                if fields.contains_key(middle) && !of.is_empty() {
                    fields[middle] = json!(median(&of));
                }
            }
            if fields.contains_key("mrays_per_s") {
                let [count, ms] = ["count", "median_ms"].map(|key| fields[key].as_f64().unwrap_or_default());
                fields["mrays_per_s"] = json!(if ms > 0.0 { count / ms / 1e3 } else { 0.0 });
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| round_times(item, below)),
        Value::Number(number) if below.ends_with("_ms") => {
            if let Some(ms) = number.as_f64() {
                *value = json!(whole_ns(ms));
            }
        }
        _ => {}
    }
}

/// The record in a folder, or the file itself.
fn file(path: &Path) -> PathBuf {
    let inside = ["run.json", "run.json.gz", "clock.json", "clock.json.gz"].map(|name| path.join(name));
    inside.into_iter().find(|file| file.is_file()).unwrap_or_else(|| path.to_owned())
}

fn convert(path: &Path) -> Result<(), Box<dyn Error>> {
    let before = std::fs::read(path)?;
    let is_packed = before.starts_with(&[0x1f, 0x8b]);
    let mut text = Vec::new();
    if is_packed {
        GzDecoder::new(&before[..]).read_to_end(&mut text)?
    } else {
        (&before[..]).read_to_end(&mut text)?
    };
    let record: Value = serde_json::from_slice(&text)?;
    let is_clock = record.get("races").or(record.get("fresh")).is_some() && record.get("rules_version").is_some();
    let text = match record.get("schema").map(Value::as_u64) {
        None if is_clock => serde_json::to_vec(&converted(record, ""))?,
        Some(Some(schema @ (2 | 3))) => {
            let mut record = if schema == 2 { converted(record, "") } else { record };
            record["schema"] = json!(SCHEMA);
            round_times(&mut record, "");
            // In the order of the record's fields, and only if it can be one.
            serde_json::to_vec(&Record::read(&serde_json::to_vec(&record)?)?)?
        }
        _ => return Err("it is no record of schema 2 or 3".into()),
    };
    let after = if is_packed {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(&text)?;
        packed.finish()?
    } else {
        text
    };
    write(path, &after)?;
    // The folder's list vouches for the file as it is now, if it did before.
    let list = path.with_file_name("tracebench.sha256");
    if let Ok(lines) = std::fs::read_to_string(&list) {
        let [was, is] = [&before, &after].map(|bytes| sha256_of(bytes));
        write(&list, lines.replace(&was, &is).as_bytes())?;
    }
    Ok(())
}

/// Whole or not at all.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().set_permissions(std::fs::metadata(path)?.permissions())?;
    file.persist(path)?;
    Ok(())
}

fn main() -> ExitCode {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    if paths.is_empty() {
        eprintln!("error: name records of schema 2 or 3: cargo run --release --example convert_record -- FILE...");
        return ExitCode::from(2);
    }
    for path in paths.iter().map(|path| file(path)) {
        if let Err(reason) = convert(&path) {
            eprintln!("error: {}: {reason}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proves that what was named otherwise is named anew wherever it stands, and that what a user named is left as it is.
    #[test]
    fn keys_have_new_names() {
        let before = json!({ "runs": [{ "way": { "frame": 2 }, "viewpoint": { "name": "window", "frame": [1, 1] },
            "tracer": { "parameters": { "reads": "texture" }, "changed": ["reads"] } }], "races": [{ "lanes": ["dirt reads=texture"] }] });
        let after = json!({ "rows": [{ "update_mode": { "frame_index": 2 }, "viewpoint": { "name": "window", "frame": [1, 1] },
            "tracer": { "parameters": { "memory_access": "texture" }, "changed": ["memory_access"] } }],
            "interleaved_sets": [{ "participants": ["dirt memory_access=texture"] }] });
        assert_eq!(converted(before, ""), after);
    }

    /// Proves that times are rounded wherever they stand, and nothing else.
    #[test]
    fn times_are_rounded() {
        let mut record =
            json!({ "samples_ms": [1.234_567_891_2, 2], "phases": [{ "median_ms": 0.1 + 0.2 }], "eye": [0.1 + 0.2] });
        round_times(&mut record, "");
        assert_eq!(
            record,
            json!({ "samples_ms": [1.234_568, 2.0], "phases": [{ "median_ms": 0.3 }], "eye": [0.1 + 0.2] })
        );
    }

    /// Proves that what is no record of schema 2 or 3 is refused and stays, a folder's too.
    #[test]
    fn others_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for text in ["{\"a\": 1, \"window\": 2}", "[1]", "{\"schema\": 3}", "{\"schema\": 2}", "{"] {
            std::fs::write(folder.path().join("run.json"), text).unwrap();
            assert!(convert(&file(folder.path())).is_err(), "{text}");
            assert_eq!(std::fs::read_to_string(folder.path().join("run.json")).unwrap(), text);
        }
    }
}
