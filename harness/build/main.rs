//! Records which commit, compiler and sources the program is built from.

mod fingerprint;

use std::path::Path;
use std::process::Command;

use fingerprint::{Sources, fingerprints};

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned())
}

fn main() {
    let commit = output("git", &["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".to_owned());
    let dirty = output("git", &["status", "--porcelain"])
        .map_or("unknown", |changes| if changes.is_empty() { "false" } else { "true" });
    let compiler = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let rustc = output(&compiler, &["--version"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=TRACEBENCH_COMMIT={commit}");
    println!("cargo::rustc-env=TRACEBENCH_DIRTY={dirty}");
    println!("cargo::rustc-env=TRACEBENCH_RUSTC={rustc}");
    let root = Path::new("..");
    let list = |folder: &str| {
        let entries = std::fs::read_dir(root.join(folder)).into_iter().flatten();
        entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect()
    };
    let sources = Sources { read: &|file| std::fs::read_to_string(root.join(file)).ok(), list: &list };
    let all = fingerprints(&sources).unwrap_or_else(|error| panic!("{error}"));
    let all: Vec<String> = all.into_iter().map(|(name, hash)| format!("{name}={hash}")).collect();
    println!("cargo::rustc-env=TRACEBENCH_FINGERPRINTS={}", all.join(" "));
    // A commit moves HEAD's log; a change of any source may make the tree dirty or clean.
    let mut watched = vec!["../Cargo.toml", "../Cargo.lock", "../harness", "../scenes", "../shaders", "../tracers"];
    let git = output("git", &["rev-parse", "--absolute-git-dir"]);
    let logs = git.map(|git| format!("{git}/logs/HEAD")).filter(|path| Path::new(path).exists());
    watched.extend(logs.as_deref());
    for path in watched {
        println!("cargo::rerun-if-changed={path}");
    }
}
