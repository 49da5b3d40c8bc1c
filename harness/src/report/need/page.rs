//! `need.md`.

use std::fmt::Write as _;

use super::{Shown, contender, value_of};
use crate::report::format::{NONE, mib, optional, significant, thousands, with_interval};
use crate::report::markdown::{Table, inline};
use crate::report::summary;
use crate::results::{NeedRecord, Run};
use crate::studies::need::{Curve, Need, Step, transfers};

/// The whole page.
pub(super) fn page(run: &Run, record: &NeedRecord, curves: &[Curve<'_>], shown: &[Shown<'_>]) -> String {
    let mut text = summary::head(run, "What structures need");
    let _ = writeln!(
        text,
        "\nEvery structure answers the same rays as smaller ones of its tracer. A smaller one is enough while the upper end of the 95 % \
         interval of newly wrong less newly right rays is at most {} % of them, and enough in time while its traces take at most {} times \
         as long besides. Rays of analytic methods are right by `tight`, of methods that sample by `footprint`.",
        significant(record.most_lost_share * 100.0, 2),
        significant(record.most_times_as_long, 3)
    );
    for each in shown {
        let name = inline(&each.scene.name);
        let _ = writeln!(text, "\n## {name} ({} triangles), {}", thousands(each.scene.triangles), inline(each.rays));
        if each.curves.iter().any(|curve| !curve.axes.is_empty()) {
            let _ = writeln!(text, "\n![rays lost over steps]({}.svg)", each.chart);
        }
        let _ = write!(text, "\nBytes needed beside bytes stored and touched:\n\n{}", needs(each));
        text += &steps(each);
    }
    text += &elsewhere(curves);
    text + &summary::skipped(&run.skipped)
}

/// A row a tracer and viewpoint.
fn needs(shown: &Shown<'_>) -> String {
    let headings = [
        "tracer",
        "from",
        "rule",
        "stored (MiB)",
        "touched (MiB)",
        "needed (MiB) ↓",
        "by",
        "needed in time (MiB) ↓",
        "by",
        "how far each may shrink",
    ];
    let mut table = Table::new(&headings.map(str::to_owned));
    for curve in &shown.curves {
        let (needed, in_time) = (curve.needed(false), curve.needed(true));
        let bytes = |step: &Step<'_>| step.bytes().map_or_else(|| NONE.to_owned(), mib);
        let far = curve.axes.iter().map(|axis| format!("{}: {}", axis.name, until(&axis.need())));
        let far: Vec<String> = far.collect();
        table.row(&[
            contender(curve),
            curve.record.viewpoint.clone(),
            curve.record.rule.name().to_owned(),
            bytes(&curve.whole),
            optional(curve.whole.touched_bytes().map(|bytes| bytes / f64::from(1 << 20)), 4),
            bytes(needed),
            by(needed),
            bytes(in_time),
            by(in_time),
            if far.is_empty() { "nothing shrinks".to_owned() } else { far.join("; ") },
        ]);
    }
    table.text
}

/// What a structure has less of.
fn by(step: &Step<'_>) -> String {
    if step.point.shrunk.is_empty() { "the whole".to_owned() } else { step.point.label() }
}

/// A need in words.
fn until(need: &Need<'_>) -> String {
    match (need.smallest, need.too_small) {
        (Some(smallest), Some(too_small)) => format!("{smallest}, {too_small} is too small"),
        (Some(smallest), None) => format!("{smallest}, the smallest tried"),
        (None, Some(too_small)) => format!("not at all, {too_small} is too small"),
        (None, None) => "not measured".to_owned(),
    }
}

/// Every step.
fn steps(shown: &Shown<'_>) -> String {
    let headings =
        ["tracer", "from", "less of", "MiB ↓", "rays lost (%) ↓", "enough", "times as long ↓", "enough in time"];
    let mut table = Table::new(&headings.map(str::to_owned));
    let mut any = false;
    for curve in &shown.curves {
        let single = curve.axes.iter().flat_map(|axis| {
            axis.steps.iter().map(move |step| (format!("{}={}", axis.name, value_of(axis, step)), step))
        });
        for (label, step) in single.chain(curve.joint.iter().map(|step| (step.point.label(), step))) {
            any = true;
            let yes = |enough: bool| if enough { "yes" } else { "no" }.to_owned();
            let ratio = step.times_as_long.map(|ratio| with_interval(ratio.value, ratio.interval, 3));
            let measured = |text: String| if step.changed.is_some() { text } else { NONE.to_owned() };
            table.row(&[
                contender(curve),
                curve.record.viewpoint.clone(),
                label,
                step.bytes().map_or_else(|| NONE.to_owned(), mib),
                lost(step.lost()),
                measured(yes(step.is_enough())),
                ratio.unwrap_or_else(|| NONE.to_owned()),
                measured(yes(step.is_enough_in_time())),
            ]);
        }
    }
    if any { format!("\nEvery step:\n\n{}", table.text) } else { String::new() }
}

/// A share of rays lost, in percent.
fn lost(found: Option<(f64, [f64; 2])>) -> String {
    let percent = |(value, interval): (f64, [f64; 2])| with_interval(value * 100.0, interval.map(|end| end * 100.0), 3);
    found.map_or_else(|| NONE.to_owned(), percent)
}

/// Whether needs serve where they were not found.
fn elsewhere(curves: &[Curve<'_>]) -> String {
    let headings = ["tracer", "rays", "found in", "needs", "tried in", "rays lost there (%) ↓", "serves"];
    let mut table = Table::new(&headings.map(str::to_owned));
    let (mut tried, mut served) = (0, 0);
    for each in transfers(curves) {
        let place = |curve: &crate::results::NeedCurve| format!("{} from {}", curve.scene, curve.viewpoint);
        let serves = match each.serves {
            Some(true) => "yes",
            Some(false) => "**no**",
            None => "not measured",
        };
        tried += u32::from(each.serves.is_some());
        served += u32::from(each.serves == Some(true));
        table.row(&[
            each.from.tracer.clone(),
            each.rays.to_owned(),
            place(each.from),
            format!("{}={}", each.axis, each.value),
            place(each.to),
            lost(each.lost),
            serves.to_owned(),
        ]);
    }
    let head = "\n## Needs that are tried elsewhere\n\n";
    if tried == 0 {
        return format!("{head}None: there is no other viewpoint or scene, or nothing shrinks.\n");
    }
    format!("{head}{served} of {tried} serve where they were not found.\n\n{}", table.text)
}
