//! A sweep: memory, build, trace and error over the values of one parameter, in small panels.
//!
//! One curve has one error panel with every rule in it; the curves of a grid have a panel a rule.

mod panels;
#[cfg(test)]
mod tests;

use super::curves::Values;
use super::frame::{Entry, Frame, Sample};
use super::palette::{INK, PLAIN, Shape, Style, Styles};
use super::panel::Chart;
use super::{LONGEST_VALUE, caption, cut, name_with_unit, panel_title, titles};
use crate::report::sweep::{Curve, View};
use crate::results::{Record, said};
use crate::studies::sweep::RESOLUTION;
use panels::{Rule, build, errors, errors_by, memory, rules, speed};

const PLOT_HEIGHT: f64 = 190.0;

/// The chart of a view.
pub(in crate::report) fn chart(record: &Record, view: &View<'_>) -> Chart {
    let rules = rules(view.set.query);
    let curve_styles = Styles::of_labels(view.curves.iter().map(curve_label));
    let rule_styles = Styles::of_labels(rules.iter().map(|(name, _)| (*name).to_owned()));
    let skipped = |value: &String| {
        let cells = || view.curves.iter().flat_map(|curve| &curve.cells).filter(|cell| cell.value == value);
        cells().next().is_some() && cells().all(|cell| cell.measured.is_none())
    };
    let all = &view.axis.values;
    let own = all.iter().position(|value| *value == view.axis.own);
    let values = Values::even(name_with_unit(&view.axis.name, &view.axis.unit), all, own);
    let values = values.skipping(all.iter().map(skipped));
    let plain = Style { colour: INK, shape: Shape::Circle };
    let of_curve = |curve| if view.other.is_none() { plain } else { curve_styles.get(&curve_label(curve)) };
    let styles: Vec<Style> = view.curves.iter().map(of_curve).collect();
    let mut panels = vec![memory(view, &values, &styles), build(view, &values, &styles), speed(view, &values, &styles)];
    if view.other.is_none() {
        let styles: Vec<Style> = rules.iter().map(|(name, _)| rule_styles.get(name)).collect();
        panels.push(errors(view, &values, &rules, &styles));
    } else {
        panels.extend(rules.iter().map(|rule| errors_by(view, &values, rule, &styles)));
    }
    Chart { frame: frame(record, view, panels.len(), legend(view, &rules, &rule_styles, &curve_styles)), panels }
}

fn curve_label(curve: &Curve<'_>) -> String {
    curve.other.unwrap_or_default().to_owned()
}

fn legend(view: &View<'_>, rules: &[Rule], rule_styles: &Styles, curve_styles: &Styles) -> Vec<Entry> {
    match view.other {
        None => {
            let entry = |rule: &Rule| Entry::new(Sample::Line(rule_styles.get(rule.0)), rule.0);
            rules.iter().map(entry).collect()
        }
        Some(other) => {
            let label = |curve: &Curve<'_>| {
                let own = if curve.other == Some(&other.own) { " (own)" } else { "" };
                format!("{}={}{own}", other.name, cut(curve.other.unwrap_or_default(), LONGEST_VALUE))
            };
            let entry = |curve| Entry::new(Sample::Line(curve_styles.get(&curve_label(curve))), label(curve));
            view.curves.iter().map(entry).collect()
        }
    }
}

fn frame(record: &Record, view: &View<'_>, panels: usize, legend: Vec<Entry>) -> Frame {
    let what = match &record.sweep {
        Some(sweep) => format!("{} over {}", cut(&sweep.tracer, LONGEST_VALUE), cut(&view.axis.name, LONGEST_VALUE)),
        None => cut(&view.axis.name, LONGEST_VALUE),
    };
    let [title, subtitle] = titles(&what, record, view.group);
    let invalid = if subtitle.starts_with("VOID") { "VOID, CONTROLS FAIL: " } else { "" };
    let subtitle = format!(
        "{invalid}{}; viewpoint {}; shaded column: the tracer's own value",
        panel_title(view.set),
        cut(&view.group.viewpoint.name, LONGEST_VALUE)
    );
    let mut key = vec![Entry::new(Sample::Hollow(PLAIN), "memory: of it used")];
    key.push(Entry::new(Sample::Dashes, "control"));
    let bars = "95 % interval of the error, order-statistic intervals of the times";
    key.push(Entry::new(Sample::Bars, bars));
    let others = others(record, view);
    let caption = format!("{others}{}", caption(record, view.group));
    Frame::in_columns(if panels > 4 { 3 } else { 2 }, PLOT_HEIGHT, panels, [title, subtitle], &caption, key, legend)
}

/// The parameters that are not along the axes.
fn others(record: &Record, view: &View<'_>) -> String {
    let point = record.sweep.as_ref().and_then(|sweep| sweep.points.first());
    let along = |name: &str| name == view.axis.name || view.other.is_some_and(|other| other.name == name);
    let parameters = point.into_iter().flat_map(|point| &point.parameters).filter(|(name, _)| !along(name));
    let parts: Vec<_> = parameters.map(|(name, v)| format!("{name}={}", cut(&said(v), LONGEST_VALUE))).collect();
    let size = point.filter(|_| !along(RESOLUTION)).map(|point| {
        let [width, height] = point.frame;
        format!("frame {width}×{height}, faces {}", point.face)
    });
    match (parts.join(", "), size) {
        (parts, None) if parts.is_empty() => String::new(),
        (parts, None) => format!("Others: {parts}. "),
        (parts, Some(size)) if parts.is_empty() => format!("Others: {size}. "),
        (parts, Some(size)) => format!("Others: {parts}; {size}. "),
    }
}
