//! Ten million triangles in one file: time and memory of the import.
//!
//! ```text
//! cargo test --release -p tracebench-scenes --test scenes -- import_large --ignored --nocapture
//! ```
#![allow(missing_docs)]

use crate::support::watertight::is_watertight;

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::time::Instant;

use serde_json::json;
use tracebench_scenes::import;

/// Quads around the torus in either direction: two triangles each, 10,008,338 in all.
const SIDE: u32 = 2237;

/// Writes a rough torus, indexed by 32 bits, without holding it in memory.
fn write_torus(path: &Path) {
    let vertices = SIDE * SIDE;
    let (position_bytes, index_bytes) = (vertices * 12, SIDE * SIDE * 24);
    let mut json = json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": vertices},
            {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": SIDE * SIDE * 6},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": position_bytes},
            {"buffer": 0, "byteOffset": position_bytes, "byteLength": index_bytes},
        ],
        "buffers": [{"byteLength": position_bytes + index_bytes}],
    })
    .to_string();
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut out = BufWriter::new(File::create(path).unwrap());
    let mut word = |value: u32| out.write_all(&value.to_le_bytes()).unwrap();
    word(u32::from_le_bytes(*b"glTF"));
    word(2);
    word(28 + json.len() as u32 + position_bytes + index_bytes);
    word(json.len() as u32);
    word(u32::from_le_bytes(*b"JSON"));
    json.as_bytes().chunks(4).for_each(|chunk| word(u32::from_le_bytes(chunk.try_into().unwrap())));
    word(position_bytes + index_bytes);
    word(u32::from_le_bytes(*b"BIN\0"));
    let turn = |at: u32| (f64::from(at) / f64::from(SIDE) * std::f64::consts::TAU).sin_cos();
    for row in 0..SIDE {
        for column in 0..SIDE {
            let ((row_sine, row_cosine), (sine, cosine)) = (turn(row), turn(column));
            let radius = 1.0 + f64::from((row * 7919 + column * 104_729) % 1000) * 1e-7;
            let out = 2.0 + radius * cosine;
            for value in [out * row_cosine, radius * sine, out * row_sine] {
                word((value as f32).to_bits());
            }
        }
    }
    for row in 0..SIDE {
        for column in 0..SIDE {
            let vertex = |row: u32, column: u32| row % SIDE * SIDE + column % SIDE;
            let [at, right] = [vertex(row, column), vertex(row, column + 1)];
            let [above, across] = [vertex(row + 1, column), vertex(row + 1, column + 1)];
            [at, above, right, right, above, across].into_iter().for_each(&mut word);
        }
    }
    out.flush().unwrap();
}

/// Greatest resident memory of this process so far in MiB, where the system tells.
fn peak_mib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? / 1024)
}

/// Proves that ten million triangles are imported whole, within 10 s and 3 GiB on a machine of 2020, and prints what it
/// took.
#[test]
#[ignore = "wider set: writes a file of 180 MB and needs up to 3 GiB"]
fn ten_million_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("torus.glb");
    write_torus(&path);
    let before = peak_mib();
    let start = Instant::now();
    let scene = import(&path).unwrap();
    let import_s = start.elapsed().as_secs_f64();
    let after = peak_mib();
    println!("import: {import_s:.2} s, peak {before:?} -> {after:?} MiB");
    assert_eq!(scene.mesh.triangles.len() as u32, 2 * SIDE * SIDE);
    assert_eq!(scene.mesh.positions.len() as u32, SIDE * SIDE);
    assert_eq!((scene.notes.zero_area_triangles_dropped, scene.notes.duplicate_triangles_kept), (0, 0));
    let start = Instant::now();
    assert!(is_watertight(&scene.mesh));
    println!("is_watertight: {:.2} s, peak {:?} MiB", start.elapsed().as_secs_f64(), peak_mib());
    let mut open = scene;
    open.mesh.triangles.pop();
    assert!(!is_watertight(&open.mesh), "a missing triangle must be noticed");
    assert!(import_s < 10.0, "{import_s} s");
    assert!(after.is_none_or(|mib| mib < 3 * 1024), "{after:?} MiB");
}
