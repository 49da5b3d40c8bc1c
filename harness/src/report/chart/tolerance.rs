//! Agreement over tolerance: how near hits must be asked to be before a tracer fails.

use tracebench_api::Query;

use super::axis::log_range;
use super::frame::{Entry, Frame, Sample};
use super::palette::{Style, Styles};
use super::panel::{Aside, Axis, Chart, Mark, Panel, Position, Scale};
use super::{caption, legend_label, panel_title, titles};
use crate::report::group::{Group, RaySet, Role};
use crate::report::metrics;
use crate::results::Record;

/// A curve: tolerance and agreement, by rising tolerance.
type Curve = Vec<Position>;

/// The configurations' curves over a ray set, and the controls'.
type Shown = (Vec<(Style, Curve)>, Vec<(String, Curve)>);

/// The chart of a group.
pub(in crate::report) fn chart(record: &Record, group: &Group<'_>) -> Chart {
    let styles = &Styles::of(record);
    let sets: Vec<&RaySet<'_>> = group.ray_sets.iter().filter(|set| set.query == Query::Closest).collect();
    let shown: Vec<Shown> = sets.iter().map(|set| shown(group, set, styles)).collect();
    let configs = shown.iter().flat_map(|(configs, _)| configs.iter().map(|(_, curve)| curve));
    let curves = configs.chain(shown.iter().flat_map(|(_, controls)| controls.iter().map(|(_, curve)| curve)));
    let tolerances = log_range(curves.flatten().map(|(tolerance, _)| *tolerance));
    let legend =
        group.configs.iter().map(|one| Entry::new(Sample::Line(styles.get(&one.label())), legend_label(one, &[])));
    let key = vec![Entry::new(Sample::Dashes, "control")];
    let titles = titles("Agreement over tolerance", record, group);
    let frame = Frame::new(shown.len(), titles, &caption(record, group), key, legend.collect());
    let panels = sets.iter().zip(shown).map(|(set, shown)| panel(set, shown, tolerances)).collect();
    Chart { frame, panels }
}

fn shown(group: &Group<'_>, set: &RaySet<'_>, styles: &Styles) -> Shown {
    let mut configs = Vec::new();
    let mut controls = Vec::new();
    for (role, row, trace) in group.traces(set) {
        let Some(judgement) = metrics::closest(trace) else { continue };
        let whole = |point: &&[f64; 2]| point[0] > 0.0 && point.iter().all(|each| each.is_finite());
        let mut curve: Curve =
            judgement.curve.iter().filter(whole).map(|[tolerance, share]| (*tolerance, *share)).collect();
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        let name = row.label();
        match role {
            _ if curve.is_empty() => {}
            Role::Control => controls.push((name, curve)),
            Role::Tracer => configs.push((styles.get(&name), curve)),
        }
    }
    (configs, controls)
}

fn panel(set: &RaySet<'_>, (configs, controls): Shown, tolerances: (f64, f64)) -> Panel {
    let line = |(style, curve): &(Style, Curve)| Mark::Line {
        places: curve.clone(),
        colour: style.colour,
        width: 2.0,
        dashed: false,
        aside: Aside::default(),
    };
    let markers = |(index, (style, curve)): (usize, &(Style, Curve))| Mark::Along {
        places: curve.clone(),
        radius: 4.0,
        style: *style,
        from: index as f64 / configs.len() as f64,
    };
    Panel {
        title: panel_title(set),
        x: Axis { name: "tolerance (scene diagonals)".to_owned(), scale: Scale::Log(tolerances, 6) },
        y: Axis { name: "agreement (%)".to_owned(), scale: Scale::Whole },
        controls,
        marks: configs.iter().map(line).chain(configs.iter().enumerate().map(markers)).collect(),
        note: configs.is_empty().then_some("no tracer traced these rays"),
    }
}
