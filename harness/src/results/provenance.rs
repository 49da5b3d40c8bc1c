//! Where results come from: the head of every record.

use serde::{Deserialize, Serialize};
use tracebench_api::AdapterListing;

use crate::machine;

/// Where something was measured, by which program, and when; flattened into the record of what was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Where it ran.
    pub machine: Machine,
    /// Commit of the program, or "unknown".
    pub commit: String,
    /// Whether the program was built from a changed tree; `None` if unknown.
    pub dirty: Option<bool>,
    /// When it began, UTC, ISO 8601.
    pub started: String,
}

impl Provenance {
    /// Here, by this program, now; with the adapter that is used, if one is.
    pub fn now(adapter: Option<AdapterListing>) -> Self {
        Self {
            machine: machine::this_machine(adapter),
            commit: machine::COMMIT.to_owned(),
            dirty: machine::dirty(),
            started: machine::utc_now(),
        }
    }
}

/// The machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Processor.
    pub cpu: String,
    /// Hardware threads that the program may use.
    pub threads: usize,
    /// Main memory, bytes; `None` if unknown.
    pub memory_bytes: Option<u64>,
    /// Operating system.
    pub os: String,
    /// Compiler that built the program.
    pub rustc: String,
    /// The adapter used; `None` if no tracer needed one.
    pub adapter: Option<AdapterListing>,
}

impl Machine {
    /// The machine in one line, for captions.
    pub fn label(&self) -> String {
        let adapter = match &self.adapter {
            None => "no adapter".to_owned(),
            Some(adapter) if adapter.kind == "software" => {
                format!("{} (software adapter: times say little of hardware)", adapter.name)
            }
            Some(adapter) => adapter.name.clone(),
        };
        format!("{}, {} threads; {adapter}", self.cpu, self.threads)
    }
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::*;
    use crate::report;

    /// The committed results: every file of a name, in order.
    fn committed(name: &str, folder: &Path) -> Vec<PathBuf> {
        let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        let below = |path: PathBuf| match path.is_dir() {
            true => committed(name, &path),
            false if path.file_name().is_some_and(|found| found == name) => vec![path],
            false => Vec::new(),
        };
        paths.into_iter().flat_map(below).collect()
    }

    fn results() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../results")
    }

    /// Proves that committed runs still load, and are written again with the head that they have: the same fields at the
    /// top, in the same order, none of them within another.
    #[test]
    fn committed_runs_keep_their_head() {
        let paths = committed(report::RUN_FILE, &results());
        assert!(paths.len() > 5, "{paths:?}");
        for path in paths {
            let run = report::read_run(&path).unwrap();
            // Older files are indented.
            let head = |text: &str| {
                let text: String = text.split_whitespace().collect();
                text.split_once(",\"seed\":").map(|(head, _)| head.to_owned())
            };
            let text = std::fs::read_to_string(&path).unwrap();
            let again = serde_json::to_string(&run).unwrap();
            assert!(head(&text).is_some_and(|head| head.contains("\"started\":")), "{}", path.display());
            assert_eq!(head(&text), head(&again), "{}", path.display());
        }
    }

    /// Proves that other committed records have the same head, and that one without a commit is none.
    #[test]
    fn other_records_have_the_same_head() {
        for name in ["stability.json", "explain.json"] {
            let paths = committed(name, &results());
            assert!(!paths.is_empty(), "{name}");
            for path in paths {
                let mut value: serde_json::Value =
                    serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
                let found: Provenance = serde_json::from_value(value.clone()).unwrap();
                assert!(!found.commit.is_empty() && found.started.ends_with('Z'), "{found:?}");
                value.as_object_mut().unwrap().remove("commit");
                assert!(serde_json::from_value::<Provenance>(value).is_err());
            }
        }
    }
}
