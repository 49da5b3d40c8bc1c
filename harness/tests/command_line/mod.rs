//! The program as scripts use it: exit statuses, messages, files.

mod attacks;
mod clock;
mod compare;
mod exchange;
mod far;
mod faults;
mod frames;
mod fronts;
mod handing_in;
mod inputs;
mod ownership;
mod pages;
mod papers;
mod refusals;
mod reproductions;
mod resume;
mod runs;
mod stability;
mod stops;
mod surfaces;
mod sweeps;
mod tables;
mod tunings;

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};
use tempfile::TempDir;

/// What a run of the program left.
#[derive(Debug)]
struct Outcome {
    status: i32,
    stdout: String,
    stderr: String,
    /// The page that standard output ends with; empty where it ends with none.
    page: String,
}

/// The most lines that a verb ends with, but for lists, JSON and texts that are in no page.
const MAX_LINES: usize = 25;

/// A folder to work in, with a cache of its own.
struct Bench {
    folder: TempDir,
}

/// A run that takes a second: few rays, the small room.
const SMOKE: [&str; 5] = ["run", "--preset", "smoke", "--size", "16x8"];

impl Bench {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    fn command<A: AsRef<OsStr>>(&self, arguments: &[A]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tracebench"));
        command.args(arguments).current_dir(self.folder.path()).env("TRACEBENCH_CACHE", self.path("cache"));
        // Tests run beside one another and time nothing that counts.
        command.env("TRACEBENCH_LOCK", "");
        // No probe, whose answer may differ from call to call on a busy machine.
        command.env("TRACEBENCH_LAUNCH", "buffer,1");
        command
    }

    fn finish(command: &mut Command) -> Outcome {
        let output = command.output().unwrap();
        let stdout = String::from_utf8(output.stdout).unwrap();
        let last = stdout.lines().last().filter(|line| line.ends_with(".md")).map(PathBuf::from);
        let page = last.map(|path| command.get_current_dir().unwrap_or(Path::new(".")).join(path));
        let page = page.and_then(|path| std::fs::read_to_string(path).ok()).unwrap_or_default();
        let whole = ["list", "compare", "docs", "--json", "--help"];
        let is_short = stdout.lines().count() <= MAX_LINES
            || command.get_args().any(|word| whole.iter().any(|name| word == *name));
        assert!(is_short, "{command:?}: {stdout}");
        let stderr = String::from_utf8(output.stderr).unwrap();
        let outcome = Outcome { status: output.status.code().unwrap_or(-1), stdout, stderr, page };
        assert!(!outcome.stderr.contains("panicked"), "{outcome:?}");
        outcome
    }

    fn call<A: AsRef<OsStr>>(&self, arguments: &[A]) -> Outcome {
        Self::finish(&mut self.command(arguments))
    }

    /// As on a machine where no driver is installed.
    fn call_without_adapter<A: AsRef<OsStr>>(&self, arguments: &[A]) -> Outcome {
        let nowhere = self.path("no-such-driver.json");
        let mut command = self.command(arguments);
        command.env("VK_DRIVER_FILES", &nowhere).env("VK_ICD_FILENAMES", &nowhere).env("WGPU_BACKEND", "vulkan");
        Self::finish(&mut command)
    }

    /// A failure: its status, nothing on stdout, and every part of the message on stderr.
    fn fails<A: AsRef<OsStr> + std::fmt::Debug>(&self, arguments: &[A], status: i32, parts: &[&str]) {
        let outcome = self.call(arguments);
        assert_eq!(outcome.status, status, "{arguments:?}: {outcome:?}");
        assert!(outcome.stdout.is_empty(), "{arguments:?}: {outcome:?}");
        assert!(outcome.stderr.contains("error"), "{arguments:?}: {outcome:?}");
        for part in parts {
            assert!(outcome.stderr.contains(part), "{arguments:?}: no '{part}' in {}", outcome.stderr);
        }
    }

    /// A run that must succeed, into a folder of the bench.
    fn run(&self, arguments: &[&str], out: &str) -> Value {
        let folder = self.text(out);
        let outcome = self.call(&[&SMOKE, arguments, &["--out", &folder]].concat());
        assert_eq!(outcome.status, 0, "{arguments:?}: {outcome:?}");
        self.result(out)
    }

    fn result(&self, out: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(out).join("run.json")).unwrap()).unwrap()
    }
}

/// The names in a folder, but for the list of what was written there.
fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).map(|entries| entries.map(|entry| entry.unwrap().file_name()));
    let names = entries.map(|names| names.map(|name| name.into_string().unwrap()));
    names.map(|names| names.filter(|name| name != "tracebench.sha256").collect()).unwrap_or_default()
}

/// Writes a file of a folder of results and puts it on the list, as the program does.
fn write_as_the_program(folder: &Path, name: &str, text: &str) {
    use std::io::Write as _;
    let mut list = std::fs::File::options().append(true).open(folder.join("tracebench.sha256")).unwrap();
    writeln!(list, "{}  {name}", tracebench_harness::hash::sha256_of(text.as_bytes())).unwrap();
    std::fs::write(folder.join(name), text).unwrap();
}

/// A .glb with these positions as triangles, three vertices each.
fn glb(positions: &[[f32; 3]]) -> Vec<u8> {
    let bin: Vec<u8> = positions.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    packed(&gltf(positions.len(), bin.len(), None), &bin)
}

/// A .glb of a document and its bytes.
fn packed(document: &Value, bin: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let body = [chunk(b"JSON", &json), chunk(b"BIN\0", bin)].concat();
    [b"glTF", &2_u32.to_le_bytes()[..], &(body.len() as u32 + 12).to_le_bytes(), &body].concat()
}

fn gltf(count: usize, bytes: usize, uri: Option<&str>) -> Value {
    let mut buffer = json!({"byteLength": bytes});
    if let Some(uri) = uri {
        buffer["uri"] = json!(uri);
    }
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": count}],
        "bufferViews": [{"buffer": 0, "byteLength": bytes}],
        "buffers": [buffer],
    })
}

const TRIANGLE: [[f32; 3]; 3] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
