//! Figures that README.md and docs/ quote of the committed records: `7.7<!--KEY-->`, where results/figures.json says what KEY stands for.
//!
//! `cargo run --release --example figures` lists the figures that are not what their records say; `-- --write` writes them. The tests
//! below look at the committed pages. CONTRIBUTING.md has the language of results/figures.json.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use serde_json::{Value, json};
use tracebench_harness::machine;
use tracebench_harness::report::unpacked;
use tracebench_harness::statistics::{median, median_interval};

/// Lists the figures that are not what their records say.
#[derive(Parser)]
struct Asked {
    /// Write them.
    #[arg(long)]
    write: bool,
}

fn main() -> ExitCode {
    let Asked { write } = Asked::parse();
    match check(&root(), write) {
        Ok(found) if found.is_empty() || write => return ExitCode::SUCCESS,
        Ok(found) => eprintln!("{}\nwrite them: cargo run --release --example figures -- --write", found.join("\n")),
        Err(reason) => eprintln!("error: {reason}"),
    }
    ExitCode::FAILURE
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The pages below a project's root that quote: its README and those in docs/.
fn pages(root: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = vec![root.join("README.md")];
    for entry in std::fs::read_dir(root.join("docs"))? {
        found.push(entry?.path());
    }
    found.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    found.sort();
    Ok(found)
}

/// Compares every figure of the pages with its record and gives those that differ; writes them where that is wanted.
fn check(root: &Path, write: bool) -> Result<Vec<String>, String> {
    let in_file = |path: &Path, reason: String| format!("{}: {reason}", path.display());
    let read = |path: &Path| std::fs::read_to_string(path).map_err(|error| in_file(path, error.to_string()));
    let path = root.join("results/figures.json");
    let stated: BTreeMap<String, String> =
        serde_json::from_str(&read(&path)?).map_err(|error| in_file(&path, error.to_string()))?;
    let mut records = Records { root, read: BTreeMap::new() };
    let mut figures = BTreeMap::new();
    for (key, stated) in &stated {
        figures.insert(key.as_str(), figure(stated, &mut records).map_err(|reason| format!("{key}: {reason}"))?);
    }
    let (mut differ, mut quoted) = (Vec::new(), BTreeSet::new());
    for path in pages(root).map_err(|error| in_file(root, error.to_string()))? {
        let text = read(&path)?;
        let page = page(&text, &figures, &mut quoted).map_err(|reason| in_file(&path, reason))?;
        differ.extend(page.differ.into_iter().map(|each| in_file(&path, each)));
        if write && page.text != text {
            std::fs::write(&path, page.text).map_err(|error| in_file(&path, error.to_string()))?;
        }
    }
    match figures.keys().find(|key| !quoted.contains(**key)) {
        Some(key) => Err(format!("no page quotes {key}: take it out of results/figures.json")),
        None => Ok(differ),
    }
}

/// A page as its records have it, and what differed.
struct Page {
    text: String,
    differ: Vec<String>,
}

fn page<'a>(text: &str, figures: &BTreeMap<&'a str, String>, quoted: &mut BTreeSet<&'a str>) -> Result<Page, String> {
    let mut pieces = text.split("<!--");
    let mut found = Page { text: pieces.next().unwrap_or_default().to_owned(), differ: Vec::new() };
    for piece in pieces {
        let line = found.text.matches('\n').count() + 1;
        let (key, after) = piece.split_once("-->").ok_or(format!("line {line}: a marker has no '-->'"))?;
        let (known, record) =
            figures.get_key_value(key).ok_or(format!("line {line}: results/figures.json has no '{key}'"))?;
        let begin =
            if record.starts_with('|') { Some(table_before(&found.text)) } else { beginning(&found.text, record) }
                .ok_or(format!("line {line}: no figure of the form of '{record}' stands before <!--{key}-->"))?;
        let says = &found.text[begin..];
        if says != record {
            found.differ.push(format!("line {line}: {key} is '{record}' by its record, not '{says}'"));
        }
        found.text.truncate(begin);
        found.text += &format!("{record}<!--{key}-->{after}");
        quoted.insert(known);
    }
    Ok(found)
}

/// Where the table at the end of a text begins.
fn table_before(text: &str) -> usize {
    let lines = text.split_inclusive('\n').rev().take_while(|line| line.starts_with('|'));
    text.len() - lines.map(str::len).sum::<usize>()
}

/// A table of a record's page: `PAGE#HEADING|COLUMN|... of TRACER,...` with the columns whose headings begin so and the rows of these
/// tracers. Names those that an older version measured. `brief PAGE#...` leaves out intervals and who was compared with.
fn table(stated: &str, records: &mut Records<'_>) -> Result<String, String> {
    let (stated, tracers) = stated.rsplit_once(" of ").ok_or("there is no ' of TRACER'")?;
    let (place, wanted) = stated.split_once('|').ok_or("there is no |COLUMN")?;
    let (is_brief, place) = place.strip_prefix("brief ").map_or((false, place), |place| (true, place));
    let (page, heading) = place.split_once('#').ok_or(format!("'{place}' is not PAGE#HEADING"))?;
    let text = std::fs::read_to_string(records.root.join(page)).map_err(|error| format!("{page}: {error}"))?;
    let mut lines = text.lines().skip_while(|line| line.trim_start_matches('#') != format!(" {heading}"));
    let lines = lines.by_ref().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    let cells = |line: &'_ str| line.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned()).collect();
    let rows: Vec<Vec<String>> = lines.map(cells).collect();
    let headings = rows.first().ok_or(format!("{page} has no table below '{heading}'"))?;
    let column = |wanted: &str| headings.iter().position(|heading| heading.starts_with(wanted));
    let columns: Option<Vec<usize>> = wanted.split('|').map(column).collect();
    let columns =
        columns.ok_or(format!("{page} has not all columns of '{wanted}' below '{heading}', but {headings:?}"))?;
    let run = |name: &str| Path::new(page).with_file_name(name).display().to_string();
    let run = [run("run.json.xz"), run("run.json")].into_iter().find(|name| records.root.join(name).exists());
    let record = records.get(&run.ok_or(format!("{page} has no record beside it"))?)?;
    let older: BTreeSet<String> = record["rows"].as_array().into_iter().flatten().filter_map(older).collect();
    let of = |name: &str| rows.iter().skip(2).find(|row| row[0] == name).ok_or(format!("{page} has no row of {name}"));
    let chosen = tracers.split(',').map(of).collect::<Result<Vec<_>, _>>()?;
    let mut text = String::new();
    for row in rows.iter().take(2).chain(chosen) {
        let is_older = older.contains(row[0].split(':').next().unwrap_or_default());
        let marked = if is_older { " (measured by an older version)" } else { "" };
        let cell = |column: &usize| row.get(*column).map_or("", String::as_str);
        let told = |column: &usize| if is_brief { brief(cell(column)) } else { cell(column).to_owned() };
        let cells: Vec<String> = columns.iter().map(told).collect();
        text += &format!("| {} |\n", cells.join(" | ").replacen(&row[0], &format!("{}{marked}", row[0]), 1));
    }
    Ok(text)
}

/// A cell without its intervals, `[a, b]`, and without those that were compared with, `× NAME`.
fn brief(cell: &str) -> String {
    let without = |text: String, begin: &str, ends: &[&str]| {
        let mut pieces = text.split(begin);
        let first = pieces.next().unwrap_or_default().to_owned();
        pieces.fold(first, |told, piece| {
            let end = ends.iter().filter_map(|end| piece.find(end)).min();
            told + end.map_or("", |end| &piece[end..]).trim_start_matches(']')
        })
    };
    let plain = without(cell.to_owned(), " [", &["]"]);
    without(plain, " × ", &[" (", " to "])
}

/// The tracer of a row that another version has measured.
fn older(row: &Value) -> Option<String> {
    let name = row["tracer"]["name"].as_str()?;
    (row["fingerprint"].as_str() != machine::fingerprint(name)).then(|| name.to_owned())
}

/// Where the figure at the end of a text begins: it has the words of the one that the record has, and numbers where that has numbers.
fn beginning(text: &str, record: &str) -> Option<usize> {
    let of_number = |mark: char| mark.is_ascii_digit() || ['.', ',', '-'].contains(&mark);
    let (mut text, mut record) = (text, record);
    while let Some(last) = record.chars().next_back() {
        if of_number(last) {
            record = record.trim_end_matches(of_number);
            let before = text.trim_end_matches(of_number);
            text = (before.len() < text.len()).then_some(before)?;
        } else {
            record = &record[..record.len() - last.len_utf8()];
            text = text.strip_suffix(last)?;
        }
    }
    Some(text.len())
}

/// Records by their names from the root, each read once.
struct Records<'a> {
    root: &'a Path,
    read: BTreeMap<String, Value>,
}

impl Records<'_> {
    fn get(&mut self, name: &str) -> Result<&Value, String> {
        if !self.read.contains_key(name) {
            let value = record(&self.root.join(name)).map_err(|error| format!("{name}: {error}"))?;
            self.read.insert(name.to_owned(), value);
        }
        Ok(&self.read[name])
    }
}

/// A file as JSON: what is JSON as it is, packed or not, comma-separated values as rows by column.
fn record(path: &Path) -> Result<Value, Box<dyn std::error::Error>> {
    let bytes = unpacked(path)?;
    if path.extension().is_some_and(|ending| ending == "csv") {
        let rows: Result<Vec<BTreeMap<String, String>>, csv::Error> =
            csv::Reader::from_reader(&bytes[..]).deserialize().collect();
        return Ok(json!(rows?));
    }
    Ok(serde_json::from_slice(&bytes)?)
}

/// What is made of several numbers, by name; where it is several numbers, these stand as `{0} to {1}` or `{0} ({1} to {2})`.
type Reduction = fn(&[f64]) -> Vec<f64>;

/// The least and the greatest.
fn ends(all: &[f64]) -> [f64; 2] {
    all.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], each| [low.min(*each), high.max(*each)])
}

const REDUCTIONS: [(&str, Reduction); 10] = [
    ("min ", |all| vec![ends(all)[0]]),
    ("max ", |all| vec![ends(all)[1]]),
    ("median ", |all| vec![median(all)]),
    ("mean ", |all| vec![all.iter().sum::<f64>() / all.len() as f64]),
    ("sum ", |all| vec![all.iter().sum()]),
    ("count ", |all| vec![all.len() as f64]),
    ("count-below-1 ", |all| vec![all.iter().filter(|value| **value < 1.0).count() as f64]),
    ("range ", |all| ends(all).to_vec()),
    ("median-range ", |all| vec![median(all), ends(all)[0], ends(all)[1]]),
    ("interval ", |all| {
        let ([low, high], _) = median_interval(all);
        vec![median(all), low, high]
    }),
];

/// The text of a figure: `[REDUCTION] PATH [over PATH] as FORMAT`, or `table PAGE#HEADING|COLUMN|... of TRACER,...`.
fn figure(stated: &str, records: &mut Records<'_>) -> Result<String, String> {
    if let Some(stated) = stated.strip_prefix("table ") {
        return table(stated, records);
    }
    let (what, format) = stated.rsplit_once(" as ").ok_or("there is no ' as FORMAT'")?;
    let reduction = REDUCTIONS.iter().find_map(|(name, of)| Some((what.strip_prefix(name)?, of)));
    let (what, reduction) = reduction.map_or((what, None), |(what, of)| (what, Some(of)));
    let (path, over) = what.split_once(" over ").map_or((what, None), |(path, over)| (path, Some(over)));
    let found = at(path, records)?;
    let all: Vec<f64> = match over {
        None => found.iter().map(number).collect::<Result<_, _>>()?,
        Some(over) => {
            let over = at(over, records)?;
            if over.len() != found.len() && over.len() != 1 {
                return Err(format!("{} values over {}", found.len(), over.len()));
            }
            found.iter().zip(over.iter().cycle()).map(|(one, other)| ratio(one, other)).collect::<Result<_, _>>()?
        }
    };
    let numbers = match (reduction, all.len()) {
        (Some(reduce), _) => reduce(&all),
        (None, 1) => all,
        (None, several) => return Err(format!("{path} has {several} values, and nothing says what to make of them")),
    };
    let texts: Option<Vec<String>> = numbers.into_iter().map(|number| formatted(number, format)).collect();
    match texts.as_deref() {
        Some([one]) => Ok(one.clone()),
        Some([low, high]) => Ok(format!("{low} to {high}")),
        Some([middle, low, high]) => Ok(format!("{middle} ({low} to {high})")),
        _ => Err(format!("'{format}' is no format of it: DECIMALS, DECIMALS%, DECIMALSMiB or n")),
    }
}

/// A number, also one in the text of a cell.
fn number(value: &Value) -> Result<f64, String> {
    let found = value.as_f64().or_else(|| value.as_str()?.parse().ok()).filter(|number| number.is_finite());
    found.ok_or(format!("{value} is no number"))
}

/// One value over another; of two lists, which are samples of the same rounds, the median of the ratios of their elements.
fn ratio(one: &Value, other: &Value) -> Result<f64, String> {
    let (Value::Array(one), Value::Array(other)) = (one, other) else { return Ok(number(one)? / number(other)?) };
    if one.len() != other.len() {
        return Err(format!("{} samples over {}: they are of different rounds", one.len(), other.len()));
    }
    let ratios: Result<Vec<f64>, String> = one.iter().zip(other).map(|(one, other)| ratio(one, other)).collect();
    Ok(median(&ratios?))
}

/// `2`: decimals; `1%`: of a share in percent; `0MiB`: of bytes; `n`: a whole number, its thousands set apart.
fn formatted(number: f64, format: &str) -> Option<String> {
    // The text of a small negative number has no -0.
    let plain = |number: f64, decimals: &str| {
        let text = format!("{number:.0$}", decimals.parse().ok()?);
        let zero = text.chars().all(|mark| ['-', '0', '.'].contains(&mark));
        Some(if zero { text.replace('-', "") } else { text })
    };
    if format == "n" {
        let digits = plain(number, "0").filter(|_| number >= 0.0)?;
        let groups: Vec<&str> =
            digits.as_bytes().rchunks(3).rev().filter_map(|each| str::from_utf8(each).ok()).collect();
        Some(groups.join(","))
    } else if let Some(decimals) = format.strip_suffix('%') {
        Some(plain(100.0 * number, decimals)? + " %")
    } else if let Some(decimals) = format.strip_suffix("MiB") {
        Some(plain(number / f64::from(1 << 20), decimals)? + " MiB")
    } else {
        plain(number, format)
    }
}

/// What stands at `FILE#SEGMENT/SEGMENT/...`; slashes in brackets are no borders.
fn at(path: &str, records: &mut Records<'_>) -> Result<Vec<Value>, String> {
    let (file, fields) = path.split_once('#').ok_or(format!("'{path}' is not FILE#FIELD/FIELD"))?;
    let mut found = vec![records.get(file)?];
    let mut depth = 0;
    let border = |mark: char| {
        depth += i32::from(mark == '[') - i32::from(mark == ']');
        mark == '/' && depth == 0
    };
    for segment in fields.split(border) {
        found = found.into_iter().flat_map(|value| step(value, segment)).collect();
        if found.is_empty() {
            return Err(format!("{file} has no '{segment}' of '{fields}'"));
        }
    }
    Ok(found.into_iter().cloned().collect())
}

/// One step down: a key, a place, `*` for all, `[KEY.KEY=VALUE,...]` for all that have these values.
fn step<'a>(value: &'a Value, segment: &str) -> Vec<&'a Value> {
    let all = || -> Vec<&'a Value> {
        match value {
            Value::Array(values) => values.iter().collect(),
            Value::Object(values) => values.values().collect(),
            _ => Vec::new(),
        }
    };
    if segment == "*" {
        return all();
    }
    if let Some(conditions) = segment.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
        let holds = |of: &Value, condition: &str| {
            let Some((key, wanted)) = condition.split_once('=') else { return false };
            let found = key.split('.').try_fold(of, |of, key| step(of, key).pop());
            found.is_some_and(|found| match found {
                Value::String(text) => text == wanted,
                Value::Number(number) => wanted.parse().is_ok_and(|wanted: f64| number.as_f64() == Some(wanted)),
                Value::Bool(is) => wanted.parse() == Ok(*is),
                _ => false,
            })
        };
        return all().into_iter().filter(|of| conditions.split(',').all(|condition| holds(of, condition))).collect();
    }
    match value {
        Value::Array(values) => segment.parse::<usize>().ok().and_then(|place| values.get(place)).into_iter().collect(),
        _ => value.get(segment).into_iter().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A project whose README has one figure, with what two keys stand for.
    fn project(figures: &Value, readme: &str) -> tempfile::TempDir {
        let folder = tempfile::TempDir::new().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        std::fs::create_dir(folder.path().join("docs")).unwrap();
        std::fs::create_dir(folder.path().join("results")).unwrap();
        let rows = json!({
            "rows": [
                { "tracer": { "name": "a", "buckets": 4 }, "ms": 10.0, "of": [3, 7], "file": "first" },
                { "tracer": { "name": "a", "buckets": 8 }, "ms": 30.0, "file": "second" },
                { "tracer": { "name": "b" }, "ms": 5.0, "file": "x/y" },
            ],
            "rounds": [2, 4, 6, 8, 10, 12, 14], "other_rounds": [1, 2, 3, 4, 5, 6, 70],
            "big": 1_234_567.4, "bytes": 3_145_728, "small": -0.0001, "share": 0.3712,
        });
        write("r.json", &rows.to_string());
        write("r.csv", "scene,rays\nroom,7\ncandy,9\n");
        write("results/figures.json", &figures.to_string());
        write("README.md", readme);
        write("docs/a.txt", "<!--no page-->");
        folder
    }

    /// Proves that figures are found by key, place and value, made one, set over others and rounded as is said, and that what is not
    /// one figure is refused.
    #[test]
    fn figures_are_found_and_formatted() {
        let folder = project(&json!({}), "");
        let mut records = Records { root: folder.path(), read: BTreeMap::new() };
        for (stated, expected) in [
            ("r.json#rows/1/ms as 0", "30"),
            ("r.json#rows/[tracer.name=a,tracer.buckets=8]/ms as 1", "30.0"),
            ("r.json#rows/[file=x/y]/ms as 0", "5"),
            ("r.json#rows/[of.1=7]/ms as 0", "10"),
            ("r.csv#[scene=candy]/rays as n", "9"),
            ("min r.json#rows/*/ms as 0", "5"),
            ("max r.json#rows/[tracer.name=a]/ms over r.json#rows/[tracer.name=b]/ms as 2", "6.00"),
            ("sum r.csv#*/rays as 0", "16"),
            ("count r.json#rows/*/ms as n", "3"),
            ("count-below-1 r.json#rows/*/ms over r.json#rows/1/ms as n", "2"),
            ("mean r.json#rows/[tracer.name=a]/ms as 0", "20"),
            ("range r.json#rows/*/ms as 0", "5 to 30"),
            ("median-range r.json#rows/*/ms as 1", "10.0 (5.0 to 30.0)"),
            // Of seven, the least and the greatest cover the median with 98 %.
            ("interval r.json#rounds/* as 1", "8.0 (2.0 to 14.0)"),
            ("r.json#rounds over r.json#other_rounds as 1", "2.0"),
            ("interval r.json#rounds/* over r.json#other_rounds/* as 1", "2.0 (0.2 to 2.0)"),
            ("r.json#rows/2/ms over r.json#rows/0/ms as 0%", "50 %"),
            ("r.json#big as n", "1,234,567"),
            ("r.json#bytes as 1MiB", "3.0 MiB"),
            ("r.json#small as 2", "0.00"),
        ] {
            assert_eq!(figure(stated, &mut records).as_deref(), Ok(expected), "{stated}");
        }
        for (stated, reason) in [
            ("r.json#share", "as FORMAT"),
            ("r.json#share as much", "no format"),
            ("r.json#part as 0", "part"),
            ("gone.json#part as 0", "gone.json"),
            ("r.json#rows/[tracer.name=c]/ms as 0", "name=c"),
            ("r.json#rows/*/ms as 0", "3 values"),
            ("r.json#rows/*/ms over r.json#rows/[tracer.name=a]/ms as 0", "3 values over 2"),
            ("r.json#rounds over r.json#rows as 0", "different rounds"),
            ("r.json#rows/0/file as 0", "no number"),
        ] {
            let error = figure(stated, &mut records).unwrap_err();
            assert!(error.contains(reason), "{stated}: {error}");
        }
    }

    /// Proves that a changed figure is noticed, with its line, and written, and that the rest of the page stays as it is.
    #[test]
    fn a_changed_figure_is_noticed() {
        let figures = json!({ "share": "r.json#share as 0%", "all": "median-range r.json#rows/*/ms as 1" });
        let readme = "Of 2 it is\n10.0 (5.0 to 30.0)<!--all-->, at **36 %<!--share-->**.\n";
        let folder = project(&figures, readme);
        let found = check(folder.path(), false).unwrap();
        assert!(
            found.len() == 1 && found[0].ends_with("line 2: share is '37 %' by its record, not '36 %'"),
            "{found:?}"
        );
        let text = || std::fs::read_to_string(folder.path().join("README.md")).unwrap();
        assert_eq!(text(), readme);
        assert_eq!(check(folder.path(), true).unwrap(), found);
        assert_eq!(text(), readme.replace("36 %", "37 %"));
        assert_eq!(check(folder.path(), false).unwrap(), Vec::<String>::new());
    }

    /// Proves that a page has the columns of its record's table that are asked for and the rows of tracers at their own parameters, that
    /// such as an older version measured are marked, and that a changed cell is noticed and written.
    #[test]
    fn a_table_is_that_of_its_record() {
        let table = "| tracer | right | trace over fastest ↓ |\n| --- | --- | --- |\n| bvh-cpu | 99 % | 1 (room) to 2 (hall) |\n\
                     | bvh-cpu a=b | 1 % | – |\n| dirt:improved | 98 % | – |\n";
        let page = format!("## Over all\n| no |\n### diffuse\n\nwords\n\n{table}\n| other |\n");
        let figures = json!({ "a": "table page.md#diffuse|tracer|trace over fastest of dirt:improved,bvh-cpu" });
        let folder = project(&figures, "words\n\n| tracer |\n<!--a-->\n");
        std::fs::write(folder.path().join("page.md"), page).unwrap();
        let row = |name: &str, version: Option<&str>| json!({ "tracer": { "name": name }, "fingerprint": version });
        let rows = json!({ "rows": [row("bvh-cpu", machine::fingerprint("bvh-cpu")), row("dirt", Some("0"))] });
        std::fs::write(folder.path().join("run.json"), rows.to_string()).unwrap();
        assert_eq!(check(folder.path(), true).unwrap().len(), 1);
        let expected = "words\n\n| tracer | trace over fastest ↓ |\n| --- | --- |\n\
                        | dirt:improved (measured by an older version) | – |\n| bvh-cpu | 1 (room) to 2 (hall) |\n<!--a-->\n";
        assert_eq!(std::fs::read_to_string(folder.path().join("README.md")).unwrap(), expected);
        assert_eq!(check(folder.path(), false).unwrap(), Vec::<String>::new());
        for (stated, reason) in [
            ("table page.md#diffuse|tracer", "of TRACER"),
            ("table page.md#diffuse of dirt", "|COLUMN"),
            ("table page.md#specular|tracer of dirt", "no table below 'specular'"),
            ("table page.md#diffuse|speed of dirt", "not all columns"),
            ("table page.md#diffuse|tracer of dirt", "no row of dirt"),
        ] {
            let error = figure(stated, &mut Records { root: folder.path(), read: BTreeMap::new() }).unwrap_err();
            assert!(error.contains(reason), "{error}");
        }
    }

    /// Proves that brief cells have numbers and places alone.
    #[test]
    fn brief_cells_have_numbers_and_places() {
        for (cell, told) in [
            ("–", "–"),
            ("13.07 (cloth) to 70.81 (foliage)", "13.07 (cloth) to 70.81 (foliage)"),
            ("0.9 [0.7, 0.9] × a:b (cloth) to 1.2 [1.0, 1.3] (room) × c d=e f=g", "0.9 (cloth) to 1.2 (room)"),
            ("1 [0.9, 1.1] undecided (hall) to 2 [1, 3] × a b=c", "1 undecided (hall) to 2"),
        ] {
            assert_eq!(brief(cell), told);
        }
    }

    /// Proves that markers that are not closed, stand for nothing or behind no figure are refused by their line, and a key that no page
    /// quotes by its name.
    #[test]
    fn broken_markers_are_refused() {
        let figures = json!({ "share": "r.json#share as 0%" });
        for (readme, reason) in [
            ("\n37 %<!--share", "line 2: a marker has no '-->'"),
            ("\n37 %<!--part-->", "line 2: results/figures.json has no 'part'"),
            ("\nsome<!--share-->", "line 2: no figure of the form of '37 %'"),
            ("\n37<!--share-->", "line 2: no figure of the form of '37 %'"),
            ("37 %", "no page quotes share"),
        ] {
            let error = check(project(&figures, readme).path(), true).unwrap_err();
            assert!(error.contains(reason), "{readme}: {error}");
        }
    }

    /// Proves that README.md and docs/ say what the committed records say.
    #[test]
    fn the_committed_pages_say_what_their_records_say() {
        assert_eq!(check(&root(), false).unwrap(), Vec::<String>::new());
    }

    /// The anchors of a page's headings, as GitHub makes them.
    fn anchors(text: &str) -> BTreeSet<String> {
        let headings =
            text.lines().filter_map(|line| line.strip_prefix('#')?.trim_start_matches('#').strip_prefix(' '));
        let kept = |mark: char| mark.is_alphanumeric() || ['-', '_', ' '].contains(&mark);
        headings.map(|heading| heading.to_lowercase().replace(|mark| !kept(mark), "").replace(' ', "-")).collect()
    }

    /// Targets of links, `](TARGET)`, that lead to no file below the root or to no heading of its page.
    fn dead_links(path: &Path, text: &str) -> Vec<String> {
        let targets = text.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0));
        let dead = |target: &&str| {
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            let page = if file.is_empty() { path.to_owned() } else { path.with_file_name(file) };
            let has = |page: &Path| std::fs::read_to_string(page).is_ok_and(|text| anchors(&text).contains(anchor));
            !target.starts_with("https://") && (!page.exists() || (!anchor.is_empty() && !has(&page)))
        };
        targets.filter(dead).map(|target| format!("{}: {target}", path.display())).collect()
    }

    /// Proves that links of pages lead somewhere, and that one that leads nowhere is found.
    #[test]
    fn links_lead_somewhere() {
        let root = root();
        let others = ["ARCHITECTURE.md", "CONTRIBUTING.md", "RULES.md"].map(|name| root.join(name));
        for path in pages(&root).unwrap().into_iter().chain(others) {
            let text = std::fs::read_to_string(&path).unwrap();
            assert_eq!(dead_links(&path, &text), Vec::<String>::new());
        }
        let text = "# A `b`, c\n[1](#a-b-c) [2](#b) [3](README.md) [4](none.md) [5](README.md#none) [6](https://x.y)";
        let found = dead_links(&root.join("docs.md"), &text.replace("(#", "(README.md#"));
        assert_eq!(found.len(), 4, "{found:?}");
        assert_eq!(anchors(text), BTreeSet::from(["a-b-c".to_owned()]));
    }
}
