//! Wrong rays over the difficulty level of cases, a panel a case.

use super::curves::{Curve, Measured, Values};
use super::frame::{Chart, Entry, Sample};
use super::palette::{PLAIN, Styles};
use super::panel::{Aside, Axis, Panel, Scale};
use super::scale::ZERO_ROW;
use super::{LONGEST_TRACER, cut};
use crate::cases;
use crate::report::format;
use crate::report::stability::difficulty_value;
use crate::results::Wrong;
use crate::studies::stability::{CaseMatrix, Cell, Stability};

/// Decimal logarithm of the least share shown: a case has a thousand rays or so.
const FLOOR: f64 = -3.5;

/// The chart of a run of cases.
pub(in crate::report) fn chart(stability: &Stability) -> Chart {
    let tracers = stability.tracers();
    let styles = Styles::of_labels(tracers.iter().cloned());
    let panels = stability.cases.iter().map(|case| panel(case, &styles)).collect();
    // A tracer that this machine cannot run keeps its colour for others, and is not shown.
    let shown = |label: &&String| {
        let cells = stability.cases.iter().flat_map(|case| &case.cells);
        cells.filter(|cell| cell.tracer == **label).any(|cell| !cell.measured.is_empty())
    };
    let entry = |label: &String| Entry::new(Sample::Line(styles.get(label)), cut(label, LONGEST_TRACER));
    let legend = tracers.iter().filter(shown).map(entry).collect();
    let key = vec![
        Entry::new(Sample::Line(PLAIN), "footprint rule; any hit: occlusion"),
        Entry::new(Sample::Hollow(PLAIN), "tight rule (dashed)"),
    ];
    let titles = [
        "Wrong rays over the level of one difficulty".to_owned(),
        "From left to right harder; ambiguous any-hit rays are left out".to_owned(),
    ];
    let commit = format::commit(&stability.provenance.commit, stability.provenance.dirty);
    let caption = format!("Commit {commit}. Machine: {}.", stability.provenance.machine.label());
    Chart::new(panels, titles, caption, [legend, key])
}

fn panel(CaseMatrix { case, cells }: &CaseMatrix, styles: &Styles) -> Panel {
    let shown: Vec<&Cell> = cells.iter().filter(|cell| !cell.measured.is_empty()).collect();
    let mut curves = Vec::new();
    for (order, cell) in shown.iter().enumerate() {
        let mut add = |hollow: bool, share: fn(&Wrong) -> f64| {
            let at = cell.measured.iter().map(|one| one.wrong.as_ref().map(|wrong| Measured::exact(share(wrong))));
            // Tracers that coincide stand side by side.
            let (style, aside) = (styles.get(&cell.tracer), Aside(order, shown.len()));
            curves.push(Curve { style, hollow, aside, at: at.collect() });
        };
        add(true, |wrong| wrong.tight);
        add(false, |wrong| wrong.footprint);
    }
    let rays = case.difficulty_levels.first().map_or(0, |difficulty_level| difficulty_level.rays);
    let steps = case.difficulty_parameter.values.iter().map(|value| difficulty_value(*value)).collect();
    let setting = cases::label(&case.difficulty_parameter.name, &case.difficulty_parameter.unit);
    let values = Values::steps(setting, steps, None);
    // A little above 100 %, so that markers there are whole.
    let y = Axis { name: "wrong rays (%)".to_owned(), scale: Scale::Shares((FLOOR, 0.15), ZERO_ROW) };
    values.panel(format!("{}: {} rays", case.name, format::thousands(rays)), y, &curves, Vec::new())
}
