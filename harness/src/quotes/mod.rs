//! Numbers that documents quote of records, between markers that say which record and which field:
//!
//! ```text
//! <!-- value: results/F/run.json.gz#runs/[tracer.name=T]/build/median_ms as 0 -->12<!-- /value -->
//! <!-- table: results/F scene=S tracer=A,B rays=R -->
//! <!-- /table -->
//! ```
//!
//! One pass writes what stands between the markers; a test holds the committed documents against the committed records. docs/quotes.md
//! is the language's page.

mod source;
mod value;

use std::path::{Path, PathBuf};

use crate::files::{self, FileError};
use crate::report;
use source::Sources;

/// Why a document cannot be brought to what records say.
#[derive(Debug, thiserror::Error)]
pub enum QuoteError {
    /// The document cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The document.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A marker says nothing that can be done.
    #[error("{}, line {line}: {reason}", path.display())]
    Marker {
        /// The document.
        path: PathBuf,
        /// Its line.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// The document cannot be written.
    #[error(transparent)]
    Write(#[from] FileError),
}

/// A quote that is not what its record says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The document.
    pub path: PathBuf,
    /// The marker's line.
    pub line: usize,
    /// What it says.
    pub says: String,
    /// What the record says.
    pub record: String,
}

/// The documents below a project's root that quote: its README and the pages in docs/.
///
/// # Errors
/// If the folder cannot be listed.
pub fn documents(root: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = vec![root.join("README.md")];
    for entry in std::fs::read_dir(root.join("docs"))? {
        found.push(entry?.path());
    }
    found.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    found.sort();
    Ok(found)
}

/// Holds documents against the records that they quote, files named from the root; writes them where that is wanted.
///
/// # Errors
/// If a document, a marker or a record cannot be read, or a document cannot be written.
pub fn bring(root: &Path, documents: &[PathBuf], write: bool) -> Result<Vec<Difference>, QuoteError> {
    let mut sources = Sources::new(root);
    let mut differences = Vec::new();
    for path in documents {
        let text = std::fs::read_to_string(path).map_err(|source| QuoteError::Read { path: path.clone(), source })?;
        let found = quoted(&text, &mut sources).map_err(|(line, reason)| {
            let path = path.clone();
            QuoteError::Marker { path, line, reason }
        })?;
        differences.extend(found.differences.into_iter().map(|(line, says, record)| {
            let path = path.clone();
            Difference { path, line, says, record }
        }));
        if write && found.text != text {
            files::edit(path, found.text.as_bytes())?;
        }
    }
    Ok(differences)
}

/// A document as records have it: its text, and by line what differed.
struct Quoted {
    text: String,
    differences: Vec<(usize, String, String)>,
}

/// How a marker begins and how what it quotes ends, and whether that stands on lines of its own.
const KINDS: [(&str, &str, bool); 2] =
    [("<!-- value: ", "<!-- /value -->", false), ("<!-- table: ", "<!-- /table -->", true)];
/// How a marker ends.
const END: &str = " -->";

fn quoted(text: &str, sources: &mut Sources) -> Result<Quoted, (usize, String)> {
    let mut found = Quoted { text: String::with_capacity(text.len()), differences: Vec::new() };
    let mut rest = text;
    loop {
        let next = KINDS.iter().filter_map(|kind| Some((rest.find(kind.0)?, kind))).min_by_key(|(at, _)| *at);
        let Some((at, (begin, end, block))) = next else { break };
        let line = 1 + text[..text.len() - rest.len() + at].matches('\n').count();
        let wrong = |reason: &str| (line, reason.to_owned());
        let (head, inner) = rest.split_at(at + begin.len());
        let (words, inner) = inner.split_once(END).ok_or_else(|| wrong("a marker has no ' -->'"))?;
        let (says, after) = inner.split_once(end).ok_or_else(|| wrong(&format!("a marker has no {end}")))?;
        if KINDS.iter().any(|kind| says.contains(kind.0)) {
            return Err(wrong(&format!("a marker begins before the last one's {end}")));
        }
        let record = if *block { table(words, sources) } else { value::value(words, sources) };
        let record = record.map_err(|reason| (line, reason))?;
        if says != record {
            found.differences.push((line, says.to_owned(), record.clone()));
        }
        found.text += &format!("{head}{words}{END}{record}{end}");
        rest = after;
    }
    found.text += rest;
    Ok(found)
}

/// The end of a run in a terminal, of some of its rows: `FOLDER scene=A,B tracer=A,B rays=A,B`.
fn table(words: &str, sources: &Sources) -> Result<String, String> {
    let mut words = words.split_whitespace();
    let folder = words.next().ok_or("the marker names no record")?;
    let mut run = report::read_run(&sources.root.join(folder)).map_err(|error| error.to_string())?;
    for word in words {
        let (what, names) = word.split_once('=').ok_or_else(|| format!("'{word}' is not NAME=A,B"))?;
        let wanted = |name: &str| names.split(',').any(|each| each == name);
        match what {
            "scene" => run.runs.retain(|one| wanted(&one.scene.name)),
            "tracer" => run.runs.retain(|one| wanted(&one.tracer.name)),
            "rays" => run.runs.iter_mut().for_each(|one| one.traces.retain(|trace| wanted(&trace.rays))),
            _ => return Err(format!("'{what}' is none of scene, tracer, rays")),
        }
    }
    run.controls.clear();
    if run.runs.iter().all(|one| one.traces.is_empty()) {
        return Err(format!("{folder} has no such rows"));
    }
    Ok(format!("\n```\n{}```\n", report::run_table(&run.aligned())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::TempDir::new().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        std::fs::create_dir(folder.path().join("docs")).unwrap();
        write(
            "a.json",
            r#"{ "rows": [{ "name": "x", "of": { "ms": 4.0 } }, { "name": "y", "of": { "ms": 6.0 } }], "share": 0.3712 }"#,
        );
        write("docs/no-marker.md", "nothing 1\n");
        write("docs/not-a-page.txt", "<!-- value: none#x as 0 -->1<!-- /value -->");
        folder
    }

    /// What differs is told with its line and written, the rest of the page stays as it is; written pages differ no more.
    #[test]
    fn pages_are_brought_to_what_records_say() {
        let folder = folder();
        let page = "First\n<!-- value: a.json#share as 0% -->36 %<!-- /value --> here,\n<!-- value: a.json#rows/[name=y]/of/ms as 1 -->6.0<!-- /value --> there.\n";
        std::fs::write(folder.path().join("README.md"), page).unwrap();
        let pages = documents(folder.path()).unwrap();
        assert_eq!(pages.len(), 2);
        let found = bring(folder.path(), &pages, false).unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].line, &*found[0].says, &*found[0].record), (2, "36 %", "37 %"));
        assert_eq!(std::fs::read_to_string(&found[0].path).unwrap(), page);
        assert_eq!(bring(folder.path(), &pages, true).unwrap(), found);
        assert_eq!(std::fs::read_to_string(&found[0].path).unwrap(), page.replace("36 %", "37 %"));
        assert!(bring(folder.path(), &pages, false).unwrap().is_empty());
    }

    /// Markers that are not closed, that name no record, no field or no format are errors that name page and line.
    #[test]
    fn broken_markers_are_refused() {
        let folder = folder();
        let page = folder.path().join("README.md");
        for (marker, wanted) in [
            ("<!-- value: a.json#share as 0%", "-->"),
            ("<!-- value: a.json#share as 0% -->3", "/value"),
            ("<!-- value: a.json#share as 0% --><!-- value: a.json#share as 0% -->3<!-- /value -->", "before"),
            ("<!-- value: b.json#share as 0% -->3<!-- /value -->", "b.json"),
            ("<!-- value: a.json#part as 0% -->3<!-- /value -->", "part"),
            ("<!-- value: a.json#share as much -->3<!-- /value -->", "much"),
            ("<!-- value: a.json#share -->3<!-- /value -->", "as"),
            ("<!-- value: a.json#rows/*/of/ms as 0 -->3<!-- /value -->", "2 values"),
            ("<!-- value: a.json#rows/[name=z]/of/ms as 0 -->3<!-- /value -->", "name=z"),
            ("<!-- table: nowhere scene=room -->3<!-- /table -->", "nowhere"),
        ] {
            std::fs::write(&page, format!("\n\n{marker}\n")).unwrap();
            let error = bring(folder.path(), std::slice::from_ref(&page), false).unwrap_err().to_string();
            assert!(error.contains("README.md, line 3") && error.contains(wanted), "{marker}: {error}");
        }
    }

    /// The documents of this project quote what its committed records say: `tracebench docs --write` mends what differs.
    #[test]
    fn the_projects_documents_quote_its_records() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let differences = bring(root, &documents(root).unwrap(), false).unwrap();
        assert!(differences.is_empty(), "run `tracebench docs --write`: {differences:#?}");
    }
}
