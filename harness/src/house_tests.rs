//! The shape of the house: imports between its folders run one way, and generic code names no tracer.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::registry::TRACERS;

/// Sources below a folder, those of tests left out.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name.contains("test") || name == "fixture.rs" {
            continue;
        }
        if path.is_dir() { found.extend(sources(&path)) } else { found.push(path) }
    }
    found
}

/// What comes before a file's own tests.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    text.split("#[cfg(test)]\nmod tests {").next().unwrap().to_owned()
}

/// The folder or file right below the crate's root that a source is in.
fn folder(path: &Path) -> String {
    let below = path.strip_prefix(root()).unwrap();
    below.iter().next().unwrap().to_string_lossy().trim_end_matches(".rs").to_owned()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

type Imports = BTreeMap<String, BTreeSet<String>>;

/// Which modules each module imports.
fn imports() -> Imports {
    let mut imports = Imports::new();
    for path in sources(&root()) {
        let own = folder(&path);
        for part in code(&path).split("crate::").skip(1) {
            let names = match part.strip_prefix('{') {
                Some(list) => list.split('}').next().unwrap_or_default().split(',').map(str::trim).collect(),
                None => vec![part],
            };
            for name in names {
                let name: String = name.chars().take_while(|c| c.is_ascii_lowercase() || *c == '_').collect();
                if !name.is_empty() && name != own {
                    imports.entry(own.clone()).or_default().insert(name);
                }
            }
        }
    }
    imports
}

/// A module that is imported, by however many steps, by what it imports.
fn circle(imports: &Imports) -> Option<&String> {
    let reached = |from: &String| {
        let mut seen = BTreeSet::new();
        let mut left: Vec<&String> = imports.get(from).into_iter().flatten().collect();
        while let Some(room) = left.pop() {
            if seen.insert(room) {
                left.extend(imports.get(room).into_iter().flatten());
            }
        }
        seen
    };
    imports.keys().find(|room| reached(room).contains(room))
}

/// Proves that no folder of the harness is imported by what it imports, that the record knows the ground alone, and that the check
/// of controls has one caller that measures; a circle is noticed.
#[test]
fn imports_run_one_way() {
    let mut imports = imports();
    assert_eq!(circle(&imports), None);
    let ground: Vec<&str> = imports["results"].iter().map(String::as_str).collect();
    assert_eq!(ground, ["machine", "statistics"]);
    let calls = |path: &PathBuf| code(path).matches("control.check(").count();
    let measuring = sources(&root()).into_iter().filter(|path| ["measure", "studies"].contains(&&*folder(path)));
    assert_eq!(measuring.map(|path| calls(&path)).sum::<usize>(), 1);
    imports.entry("results".to_owned()).or_default().insert("studies".to_owned());
    assert!(circle(&imports).is_some());
}

/// Proves that the names of tracers are in their registrations and in papers alone.
#[test]
fn generic_code_names_no_tracer() {
    let names: Vec<String> = TRACERS.iter().map(|each| format!("\"{}\"", each.name())).collect();
    let named = |text: &str| names.iter().any(|name| text.contains(name.as_str()));
    let generic = sources(&root()).into_iter().filter(|path| folder(path) != "papers");
    let found: Vec<PathBuf> = generic.filter(|path| named(&code(path))).collect();
    assert_eq!(found, Vec::<PathBuf>::new());
    assert!(named("find(\"bvh-cpu\")"));
}
