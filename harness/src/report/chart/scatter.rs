//! Errors against time, a panel an error: what is lower and further left is better.

use super::axis::log_range;
use super::frame::{Entry, Frame, Sample};
use super::palette::Styles;
use super::panel::{Aside, Axis, Chart, Mark, Panel, Scale};
use super::{LONGEST_TRACER, cut, untimed_caption};
use crate::results::Record;

const RADIUS: f64 = 4.5;

/// A panel: the error's name, and by label time and error.
pub(in crate::report) type Errors<'a> = (&'a str, Vec<(String, f64, f64)>);

/// The chart of some errors over a time with a name.
pub(in crate::report) fn chart(record: &Record, titles: [String; 2], time: &str, errors: &[Errors<'_>]) -> Chart {
    let labels = || errors.iter().flat_map(|(_, points)| points.iter().map(|(label, ..)| label.clone()));
    let styles = Styles::of_labels(labels());
    let mut names: Vec<String> = Vec::new();
    for label in labels() {
        if !names.contains(&label) {
            names.push(label);
        }
    }
    let entry = |name: &String| Entry::new(Sample::Filled(styles.get(name)), cut(name, LONGEST_TRACER));
    let caption = untimed_caption(&record.provenance, &record.preset);
    let frame = Frame::new(errors.len(), titles, &caption, Vec::new(), names.iter().map(entry).collect());
    let panel = |(name, points): &Errors<'_>| {
        let positive = points.iter().map(|(.., error)| *error).filter(|error| *error > 0.0);
        let marker = |(label, ms, error): &(String, f64, f64)| Mark::Marker {
            place: (*ms, *error),
            radius: RADIUS,
            style: styles.get(label),
            hollow: false,
            aside: Aside::default(),
        };
        Panel {
            title: (*name).to_owned(),
            x: Axis { name: time.to_owned(), scale: Scale::Log(log_range(points.iter().map(|(_, ms, _)| *ms)), 6) },
            y: Axis { name: (*name).to_owned(), scale: Scale::LogAndZero(log_range(positive), 6) },
            controls: Vec::new(),
            marks: points.iter().map(marker).collect(),
            note: points.is_empty().then_some("no tracer was timed"),
        }
    };
    Chart { frame, panels: errors.iter().map(panel).collect() }
}
