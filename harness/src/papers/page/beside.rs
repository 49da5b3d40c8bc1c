//! A tracer beside every other one of a table.

use super::Page;
use super::measured::{TIMES, bytes, strings, time_with_accuracy};
use crate::papers::Scope;
use crate::papers::rows::trace;
use crate::report::format::{NONE, optional};
use crate::report::markdown::{Table, inline};
use crate::results::TracerRun;
use crate::results::host_ms;

/// Build and traces of every row, with ratios to the first of a tracer.
pub(in crate::papers) fn beside(page: &Page<'_>, reference: &str) -> String {
    let mut text = format!("\n{TIMES} Ratios are to the first row of {reference} in a scene.\n");
    for scene in &page.rows.scenes {
        let Some(first) = scene.like_first(reference, &[]) else { continue };
        let sets = scene.ray_sets();
        let mut headings = strings(&["tracer"]);
        headings.extend(Scope::ALL.iter().flat_map(|(_, heading)| [(*heading).to_owned(), "ratio".to_owned()]));
        headings.extend(strings(&["build (ms) ↓", "ratio"]));
        for set in &sets {
            headings.extend([format!("{set} (ms) ↓"), "ratio".to_owned(), "build and trace: ratio".to_owned()]);
        }
        let mut table = Table::new(&headings);
        for run in &scene.runs {
            let build = |run: &TracerRun| host_ms(&run.build.times);
            let over =
                |own: Option<f64>, first: Option<f64>| optional(own.zip(first).map(|(own, first)| own / first), 3);
            let own_build = build(run);
            let mut cells = vec![run.label()];
            for (scope, _) in Scope::ALL {
                let [own, base] = [run, first].map(|run| page.paper.bytes(run, scope));
                cells.extend([bytes(page, run, scope), over(own, base)]);
            }
            cells.extend([optional(own_build, 4), over(own_build, build(first))]);
            for set in &sets {
                let [own, base] = [run, first].map(|run| time_with_accuracy(&[trace(run, set)?]));
                cells.push(own.as_ref().map_or_else(|| NONE.to_owned(), |(_, text)| text.clone()));
                let [own, base] = [own, base].map(|time| time.map(|(ms, _)| ms));
                cells.push(over(own, base));
                let total = |trace: Option<f64>, build: Option<f64>| Some(trace? + build?);
                cells.push(over(total(own, own_build), total(base, build(first))));
            }
            table.row(&cells);
        }
        text += &format!("\n**{}**\n\n{}", inline(&scene.label), table.text);
    }
    text
}
