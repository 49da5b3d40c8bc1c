//! The end of a run in a terminal: by ray set a row a tracer, speed with the accuracy of the same rays beside it.

use std::fmt::Write as _;

use super::format::{self, NONE, optional, percent, thousands};
use super::group::{Group, RaySet, Role, groups};
use super::metrics;
use crate::results::{Accuracy, Record, TraceRecord};

/// Columns that names may take; longer ones go on in the next line. With the other columns a line has 100 at most.
const LONGEST_NAME: usize = 30;
const SPEED: usize = 11;
const SHARE: usize = 12;
/// What stands beside a clock because the device's own could not be true.
const REFUSED: &str = " *";

/// Every configuration's traces, no speed without its accuracy.
pub fn run_table(record: &Record) -> String {
    let groups = groups(record);
    let titles = groups.iter().flat_map(|group| group.ray_sets.iter().map(title));
    let names = record.rows.iter().map(|one| one.label()).chain(titles);
    let width = names.map(|name| name.chars().count()).max().unwrap_or(0).min(LONGEST_NAME);
    let mut text = String::new();
    for group in &groups {
        let _ = writeln!(text, "{}, viewpoint {}", group.scene.name, group.viewpoint.name);
        for set in &group.ray_sets {
            ray_set(&mut text, group, set, width);
        }
    }
    if text.lines().any(|line| line.ends_with(REFUSED)) {
        // Below the first line: what does not fit is cut off behind.
        let first = text.find('\n').map_or(0, |end| end + 1);
        text.insert_str(first, &format!("{REFUSED}: the device's timestamps were not believed\n"));
    }
    text
}

fn title(set: &RaySet<'_>) -> String {
    format!("{}, {} rays", set.title, thousands(set.count))
}

fn ray_set(text: &mut String, group: &Group<'_>, set: &RaySet<'_>, width: usize) {
    line(text, width, &title(set), metrics::SPEED.unit, metrics::rules(set.query), "clock");
    let mut one_sided = None;
    for (role, one, trace) in group.traces(set) {
        one_sided = one_sided.or(trace.judgement.one_sided());
        if role == Role::Tracer {
            let speed = optional(metrics::speed(trace).filter(|_| metrics::judged(trace)), 4);
            // None of a set whose rays are all ambiguous rays.
            let share = |Accuracy { share, trials, one_sided, .. }: &Accuracy| match (share, one_sided) {
                (Some(share), None) => format!("{} %", percent(*share, *trials)),
                _ => NONE.to_owned(),
            };
            let cells: Vec<String> = metrics::right_of(trace).iter().map(share).collect();
            line(text, width, &one.label(), &speed, &cells, &clock(trace));
        }
    }
    if let Some(why) = one_sided {
        let _ = writeln!(text, "  {why}: shares of right answers say nothing here");
    }
}

fn clock(trace: &TraceRecord) -> String {
    let name = format::clock(trace.times.clock).trim_end_matches(", host clock");
    let invalid = if trace.times.invalid.is_some() { ", times invalid" } else { "" };
    format!("{name}{invalid}{}", if trace.times.timestamps_refused { REFUSED } else { "" })
}

/// A line of a table; a name that is too long for its column begins in lines of its own.
fn line(text: &mut String, width: usize, name: &str, speed: &str, shares: &[impl AsRef<str>], clock: &str) {
    let name: Vec<char> = name.chars().collect();
    let mut parts = name.chunks(width.max(1)).map(|part| part.iter().collect::<String>()).peekable();
    while let Some(part) = parts.next() {
        if parts.peek().is_some() {
            let _ = writeln!(text, "  {part}");
            continue;
        }
        // One accuracy takes the place of three.
        let each = 3 * SHARE / shares.len().max(1);
        let shares: String = shares.iter().map(|share| format!("{:>each$}", share.as_ref())).collect();
        let _ = writeln!(text, "  {part:<width$}{speed:>SPEED$}{shares}  {clock}");
    }
}

#[cfg(test)]
mod tests {
    use tracebench_api::ClockKind;

    use super::*;
    use crate::report::fixture::{self, Quality};
    use crate::report::format::significant;
    use crate::results::Judgement;

    const FAIR: Quality = Quality { missed: 0.25, blur: 1e-9, speed: 3.1, clock: ClockKind::SubmitToDone };

    /// Proves that every trace of every configuration has its line below its scene and ray set, with speed, every accuracy and clock
    /// in aligned columns; that no line is wider than a terminal, whatever tracers are called; and that controls stay out.
    #[test]
    fn every_trace_has_a_line() {
        for record in [fixture::typical(), fixture::crowded()] {
            let text = run_table(&record);
            assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
            assert!(!text.contains("oracle") && !text.contains(REFUSED), "{text}");
            let heads: Vec<&str> =
                text.lines().filter(|line| line.ends_with("clock") && line.contains("Mrays/s")).collect();
            assert_eq!(heads.len(), fixture::SETS.len());
            let (speed, clock) = (heads[0].find("Mrays/s").unwrap() + "Mrays/s".len(), heads[0].find("clock").unwrap());
            let rows = text.lines().filter(|line| line.starts_with("  ") && line.contains(" %"));
            let rows: Vec<Vec<char>> = rows.map(|line| line.chars().collect()).collect();
            assert_eq!(rows.len(), record.rows.iter().map(|one| one.traces.len()).sum::<usize>());
            for row in rows {
                assert!(row[speed - 1].is_ascii_digit() && row[speed] == ' ', "{row:?}");
                assert!(row[clock - 1] == ' ' && row[clock].is_ascii_lowercase(), "{row:?}");
            }
        }
        let typical = run_table(&fixture::typical());
        assert!(typical.contains("balanced accuracy") && typical.contains("footprint"), "{typical}");
        for name in ["bvh-cpu", "screen-dda"] {
            assert_eq!(typical.lines().filter(|line| line.trim_start().starts_with(name)).count(), 3, "{typical}");
        }
    }

    /// Proves that several scenes stand below headings of their own, in the order of the run.
    #[test]
    fn scenes_are_headings() {
        let mut record = fixture::typical();
        let mut other = record.clone();
        other.rows.iter_mut().chain(&mut other.controls).for_each(|one| "drone".clone_into(&mut one.scene.name));
        record.rows.append(&mut other.rows);
        record.controls.append(&mut other.controls);
        let text = run_table(&record);
        let heads: Vec<&str> = text.lines().filter(|line| !line.starts_with(' ')).collect();
        assert!(heads.len() == 2 && heads[1].starts_with("drone, viewpoint"), "{heads:?}");
        assert_eq!(text.matches("bvh-cpu").count(), 6);
    }

    /// Proves that invalid times are told as such, with no speed but with the accuracy, on the page of a run too.
    #[test]
    fn invalid_times_are_reported() {
        let mut record = fixture::run(&[("bvh-cpu", FAIR)], &fixture::SETS[..1]);
        let speed = significant(record.rows[0].traces[0].mrays_per_s, 4);
        assert!(run_table(&record).contains(&speed));
        record.rows[0].traces[0].times.invalid = Some("why".to_owned());
        let text = run_table(&record);
        assert!(
            !text.contains(&speed) && text.contains("submit to done, times invalid") && text.contains(" % "),
            "{text}"
        );
        let folder = tempfile::TempDir::new().unwrap();
        fixture::write_run(&record, folder.path(), fixture::tables).unwrap();
        let page = std::fs::read_to_string(folder.path().join("summary.md")).unwrap();
        assert!(page.contains("; **invalid times** of 1: why"), "{page}");
        assert!(page.contains("**times invalid**") && !page.contains(&speed), "{page}");
    }

    /// Proves that a speed without an accuracy is not shown, and that timestamps which were not believed are told.
    #[test]
    fn no_speed_without_its_accuracy() {
        let mut record = fixture::run(&[("bvh-cpu", FAIR)], &fixture::SETS);
        let speeds: Vec<String> = record.rows[0].traces.iter().map(|trace| significant(trace.mrays_per_s, 4)).collect();
        let shown = |text: &str| speeds.iter().filter(|speed| text.contains(&format!(" {speed} "))).count();
        assert_eq!(shown(&run_table(&record)), 3);
        for trace in &mut record.rows[0].traces {
            trace.times.timestamps_refused = true;
            match &mut trace.judgement {
                Judgement::Closest(closest) => closest.agreement.tight = None,
                Judgement::Any(any) => any.occlusion.balanced_accuracy = None,
            }
        }
        let text = run_table(&record);
        assert!(shown(&text) == 0 && text.contains(NONE), "{text}");
        assert!(text.contains("submit to done *") && text.lines().nth(1).unwrap().ends_with("not believed"), "{text}");
    }
}
