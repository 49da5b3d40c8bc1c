//! `report --check`: what RULES.md asks of a record that is handed in.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::verdict;
use super::{PACKED, PAGE_FILE, RUN_FILE, ReportError, Study, Tables, contents, kept, read_run, record_file, unpacked};
use crate::files::LIST;
use crate::hash::sha256_of;
use crate::results::{PICTURES_FOLDER, Provenance, Record};
use crate::studies::attack;

/// The list of committed records with their commands.
const MANIFEST: &str = "manifest.json";

/// What speaks against handing in a folder, each with what to do; nothing where it is as RULES.md asks. `parse` says what is wrong with
/// the words of a command; `user` is a name that must not be in the record.
///
/// # Errors
/// If there is no record, or what derives from it cannot be made.
pub fn check(
    folder: &Path,
    tables: Tables,
    parse: impl Fn(&str) -> Result<(), String>,
    user: Option<&str>,
) -> Result<Vec<String>, ReportError> {
    let (record, file) = (read_run(folder)?, record_file(folder));
    let Provenance { commit, dirty, .. } = &record.provenance;
    let mut faults = Vec::new();
    if *dirty != Some(false) || commit.len() < 40 || !commit.bytes().all(|c| c.is_ascii_hexdigit()) {
        faults
            .push("its program is of no clean commit: commit all, build in a git clone, and measure again".to_owned());
    }
    if record.preset == "smoke" {
        faults.push("preset smoke only shows that things work: measure with quick or paper".to_owned());
    }
    let mut cases = record.cases.iter().flat_map(|section| &section.cases);
    let failed = verdict::controls(&record).into_iter().next().or_else(|| cases.find_map(|case| case.invalid.clone()));
    let remedy = "measure again, and open an issue if it comes back";
    faults.extend(failed.map(|failed| format!("a control fails: {failed}: {remedy}")));
    faults.extend(command(folder, &record, parse));
    let bytes = fs::read(&file).map_err(|source| ReportError::Read(file.clone(), source))?;
    let line = format!("{}  {}", sha256_of(&bytes), file.file_name().unwrap_or_default().display());
    // A folder without a list is told by what is made of its record alone.
    if fs::read_to_string(folder.join(LIST)).is_ok_and(|list| !list.lines().any(|one| one == line)) {
        faults.push(format!("{LIST} does not list the record as it is: hand in both as written, or measure again"));
    }
    faults.extend(files(folder, &record, tables)?);
    if let Some(part) = private_part(&String::from_utf8_lossy(&unpacked(&file)?), user) {
        faults.push(format!("it has {part:?}, a path or a user's name: measure again, with relative paths without it"));
    }
    Ok(faults)
}

/// What is wrong with the command that the manifest above the folder says.
fn command(folder: &Path, record: &Record, parse: impl Fn(&str) -> Result<(), String>) -> Option<String> {
    let path = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let Some(root) = path.ancestors().skip(1).find(|root| root.join(MANIFEST).is_file()) else {
        return Some(format!("no {MANIFEST} is in a folder above it: put it at results/MACHINE-WHAT"));
    };
    let entries = fs::read(root.join(MANIFEST)).ok().and_then(|text| serde_json::from_slice::<Vec<Value>>(&text).ok());
    let is_its = |entry: &Value| entry["folder"].as_str().is_some_and(|folder| root.join(folder) == path);
    let entry = entries.unwrap_or_default().into_iter().find(is_its).unwrap_or_default();
    let Some(command) = entry["command"].as_str() else {
        return Some(format!("{MANIFEST} does not tell its command: add its \"folder\", \"command\" and \"minutes\""));
    };
    let verb = Study::of(record).verb;
    let begin = record.table.as_ref().map_or(verb.to_owned(), |table| format!("table {table}"));
    let is_of_record = format!("{command} ").starts_with(&format!("{begin} "));
    let wrong = parse(command).err().or((!is_of_record).then(|| format!("the record is of `{begin}`")));
    wrong.map(|why| format!("{MANIFEST} says that `{command}` made it: {why}: write the command that did"))
}

/// What lies in the folder and is not what is made of the record.
fn files(folder: &Path, record: &Record, tables: Tables) -> Result<Vec<String>, ReportError> {
    let fail = |source| ReportError::Read(folder.to_owned(), source);
    let derived = contents(record, tables)?;
    let mut others = kept::others(folder, record);
    for entry in fs::read_dir(folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_its = match derived.iter().find(|(made, _)| *made == name) {
            Some((_, made)) => fs::read(&path).is_ok_and(|bytes| bytes == *made),
            // Another record's folder is checked by itself.
            None => {
                [RUN_FILE, PACKED, LIST, PICTURES_FOLDER, PAGE_FILE].contains(&&*name)
                    || record.attack.is_some() && name == attack::FOLDER
                    || path.is_dir() && record_file(&path).is_file()
            }
        };
        others.extend((!is_its).then_some(name));
    }
    others.sort();
    let remedy = "take it out, then `tracebench report` makes what belongs there";
    Ok(others.iter().map(|name| format!("{name} is not what is made of the record: {remedy}")).collect())
}

/// The first word of a text that is an absolute path, one from a home, or holds a user's name.
fn private_part<'t>(text: &'t str, user: Option<&str>) -> Option<&'t str> {
    let is_name = |c: char| c.is_alphanumeric() || "._-".contains(c);
    let is_path = |word: &str| {
        let (begin, rest) = word.trim_start_matches("file://").split_once(['/', '\\']).unwrap_or_default();
        let is_drive = begin.len() == 2 && begin.ends_with(':') && begin.starts_with(|c: char| c.is_ascii_alphabetic());
        is_drive || begin == "~" || begin.is_empty() && rest.starts_with(is_name) && rest.contains('/')
    };
    let is_user = |word: &str| user.is_some_and(|user| word.split(|c| !is_name(c)).any(|part| part == user));
    let mut words = text.split(|c: char| c.is_whitespace() || "\"'`()=,;<>".contains(c));
    words.find(|word| is_path(word) || is_user(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proves that paths of a machine and a user's name are found within texts, and that ratios, fractions, relative paths and links are no
    /// such paths.
    #[test]
    fn private_parts_are_found() {
        let part = |text| private_part(text, Some("ada"));
        for (text, found) in [
            ("/home/ada/x.glb", "/home/ada/x.glb"),
            ("cannot read '/srv/data/x.glb': gone", "/srv/data/x.glb"),
            ("C:\\scenes\\x.glb", "C:\\scenes\\x.glb"),
            ("(D:/scenes/x.glb)", "D:/scenes/x.glb"),
            ("--out=~/x", "~/x"),
            ("file:///Users/x/y", "file:///Users/x/y"),
            ("by ada@host", "ada@host"),
        ] {
            assert_eq!(part(text), Some(found), "{text}");
        }
        let harmless = [
            "",
            "hit_miss / tight / footprint",
            "1/8 further",
            "scenes/x.glb",
            "../x/y",
            "https://a.b/c/d",
            "adapter Canada",
        ];
        assert_eq!(harmless.map(part), [None; 7]);
        assert_eq!(private_part("by ada@host", None), None);
    }
}
