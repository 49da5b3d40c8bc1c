//! Records which commit and compiler the program is built from.

use std::process::Command;

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
    // A commit moves HEAD's log; a change of any source may make the tree dirty or clean.
    let mut watched = vec!["../Cargo.toml", "../Cargo.lock", "../harness", "../scenes", "../shaders", "../tracers"];
    let git = output("git", &["rev-parse", "--absolute-git-dir"]);
    let logs = git.map(|git| format!("{git}/logs/HEAD")).filter(|path| std::path::Path::new(path).exists());
    watched.extend(logs.as_deref());
    for path in watched {
        println!("cargo::rerun-if-changed={path}");
    }
}
