//! Wrong rays over the strength of cases, a panel a case.

use super::canvas::register;
use super::frame::{Entry, Frame, Sample};
use super::palette::{GREY, Shape, Style, Styles};
use super::panel::{Aside, Axis, Chart, Mark, Panel, Place, Scale, ZERO_ROW, between};
use super::{LONGEST_TRACER, cut};
use crate::cases;
use crate::report::format;
use crate::report::stability::knob_value;
use crate::results::Wrong;
use crate::studies::stability::{CaseMatrix, Cell, Stability};

/// Decimal logarithm of the least share shown: a case has a thousand rays or so.
const FLOOR: f64 = -3.5;
const FILLED: f64 = 4.0;
const HOLLOW: f64 = 6.0;

/// The chart of a run of cases.
pub(super) fn chart(stability: &Stability) -> Chart {
    // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
    let _ = register();
    let tracers = stability.tracers();
    let styles = Styles::of_labels(tracers.iter().cloned());
    let panels: Vec<Panel> = stability.cases.iter().map(|case| panel(case, &styles)).collect();
    // A tracer that this machine cannot run keeps its colour for others, and is not shown.
    let measured = |label: &&String| {
        stability
            .cases
            .iter()
            .flat_map(|case| &case.cells)
            .any(|cell| cell.tracer == **label && !cell.measured.is_empty())
    };
    let legend = tracers
        .iter()
        .filter(measured)
        .map(|label| Entry { sample: Sample::Line(styles.get(label)), label: cut(label, LONGEST_TRACER) });
    let grey = Style { colour: GREY, shape: Shape::Circle };
    let entry = |sample, label: &str| Entry { sample, label: label.to_owned() };
    let key = vec![
        entry(Sample::Line(grey), "footprint rule; any hit: occlusion"),
        entry(Sample::Hollow(grey), "tight rule (dashed)"),
    ];
    let titles = [
        "Wrong rays over the strength of one difficulty".to_owned(),
        "From left to right harder; ties are left out".to_owned(),
    ];
    let commit = format::commit(&stability.provenance.commit, stability.provenance.dirty);
    let caption = format!("Commit {commit}. Machine: {}.", stability.provenance.machine.label());
    let frame = Frame::new(panels.len(), titles, &caption, key, legend.collect());
    Chart { frame, panels }
}

fn panel(CaseMatrix { case, cells }: &CaseMatrix, styles: &Styles) -> Panel {
    let curves: Vec<&Cell> = cells.iter().filter(|cell| !cell.measured.is_empty()).collect();
    let of = |cell: &Cell, share: fn(&Wrong) -> f64| -> Vec<Option<Place>> {
        let shares = cell.measured.iter().map(|measured| measured.wrong.as_ref().map(share)).enumerate();
        shares.map(|(step, share)| Some((step as f64, share?))).collect()
    };
    let mut lines = Vec::new();
    let mut markers = Vec::new();
    for (order, cell) in curves.iter().enumerate() {
        // Tracers that coincide stand side by side.
        let (style, aside) = (styles.get(&cell.tracer), Aside(order, curves.len()));
        let (tight, footprint) = (of(cell, |wrong| wrong.tight), of(cell, |wrong| wrong.footprint));
        lines.extend(between(&tight, style.colour, 1.0, true, aside));
        lines.extend(between(&footprint, style.colour, 2.0, false, aside));
        let marker = |place, radius, hollow| Mark::Marker { place, radius, style, hollow, aside };
        // Hollow ones first: they are larger, and where both rules agree the filled one sits inside.
        markers.extend(tight.into_iter().flatten().map(|place| marker(place, HOLLOW, true)));
        markers.extend(footprint.into_iter().flatten().map(|place| marker(place, FILLED, false)));
    }
    let rays = case.strengths.first().map_or(0, |strength| strength.rays);
    let values = case.knob.values.iter().map(|value| knob_value(*value)).collect();
    Panel {
        title: format!("{}: {} rays", case.name, format::thousands(rays)),
        x: Axis { name: cases::label(&case.knob.name, &case.knob.unit), scale: Scale::Steps(values) },
        // A little above 100 %, so that markers there are whole.
        y: Axis { name: "wrong rays (%)".to_owned(), scale: Scale::Shares((FLOOR, 0.15), ZERO_ROW) },
        controls: Vec::new(),
        // All lines before all markers: a line over a marker would hide which kind it is.
        marks: lines.into_iter().chain(markers).collect(),
        note: None,
    }
}
