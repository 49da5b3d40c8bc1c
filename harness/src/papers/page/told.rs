//! Tables and charts of pages as a paper's data tells them: expressions over the rows that steps lead to.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::Page;
use crate::papers::evaluate::{Evaluation, Value};
use crate::papers::expression::{Expression, Steps};
use crate::registrations::embedded;
use crate::report::chart::series::{Series, SeriesChart, SeriesPanel};
use crate::report::document::Document;
use crate::report::format::file_stem;
use crate::report::markdown::literal;
use crate::report::sheet::{Cell, Sheet, Table};

/// What a paper's `pages.json` tells, by the names that experiments take.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::papers) struct Told {
    pub tables: BTreeMap<String, ToldTable>,
    pub charts: BTreeMap<String, ToldChart>,
}

/// A table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::papers) struct ToldTable {
    /// What stands above it.
    #[serde(default)]
    words: String,
    /// Whether it has times, whose words stand before.
    #[serde(default)]
    timed: bool,
    /// Whether it is left out where it has no rows.
    #[serde(default)]
    optional: bool,
    /// Of what there is a table each, and what stands above it: a name, and more words.
    each: Option<(Steps, Expression, Expression)>,
    rows: Steps,
    /// Headings with what stands below them.
    columns: Vec<(String, Expression)>,
    /// Further ones for each of what steps lead to.
    #[serde(default)]
    columns_of: (Steps, Vec<(Expression, Expression)>),
}

/// What experiments of any paper may take.
pub(in crate::papers) static COMMON: LazyLock<Told> = LazyLock::new(|| embedded(include_str!("../pages.json")));

/// A chart, or one for each of what steps lead to.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::papers) struct ToldChart {
    #[serde(default)]
    each: Steps,
    /// What its files are called beside the experiment's name.
    name: Option<Expression>,
    title: String,
    subtitle: Expression,
    /// What solid and dashed lines are, and where that is told.
    key: Option<[String; 2]>,
    key_if: Option<Expression>,
    /// Of what there are panels: title or a variable that holds it, quantity, the value `$step` of a line.
    #[serde(default)]
    panels_of: Steps,
    panels: Vec<(String, String, Expression)>,
    /// What changes from step to step, and the steps: lists begin with their names.
    setting: String,
    steps: Expression,
    lines: Steps,
    label: Expression,
    dashed: Option<Expression>,
}

/// What stands above tables of times.
const TIMES: &str = "Times are medians by the host's clock with the accuracy of the same rays: agreement under hit_miss and footprint, of \
                     any-hit sets balanced accuracy, the worst where several sets are added up.";

/// Its tables with what stands above them; `reference` is the tracer that they stand beside, if they do.
pub(super) fn section<'a>(page: &'a Page<'a>, told: &'a ToldTable, reference: &'a str) -> Document {
    let words = if told.timed { format!("{TIMES} {}", told.words) } else { told.words.clone() };
    let words = words.trim_end().replace("{}", reference);
    let mut at = Evaluation::of_page(page);
    let Some((steps, name, rest)) = &told.each else {
        let table = table(told, at.as_mut());
        return if told.optional { Document::default().below(words, table) } else { Document::of(words).table(table) };
    };
    let mut parts = Vec::new();
    if let Some(at) = &mut at {
        at.variables.push(("$reference", Value::Text(reference)));
        at.each(steps, &mut |at| {
            let title = format!("**{}**{}", literal(&at.cell(name).describe()), at.cell(rest).describe());
            parts.push(Document::of(title).table(table(told, Some(at))));
        });
    }
    Document::of(words).and(parts)
}

fn table<'a>(told: &'a ToldTable, at: Option<&mut Evaluation<'a>>) -> Table {
    let (steps, further) = &told.columns_of;
    let mut headings: Vec<String> = told.columns.iter().map(|(heading, _)| heading.clone()).collect();
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    if let Some(at) = at {
        at.each(steps, &mut |at| headings.extend(further.iter().map(|(heading, _)| at.cell(heading).describe())));
        at.each(&told.rows, &mut |at| {
            let mut row: Vec<Cell> = told.columns.iter().map(|(_, is)| at.cell(is)).collect();
            at.each(steps, &mut |at| row.extend(further.iter().map(|(_, is)| at.cell(is))));
            rows.push(row);
        });
    }
    let headings = headings.into_iter().enumerate();
    let sheet = headings.fold(Sheet::<Vec<Cell>>::new(), |sheet, (place, heading)| {
        sheet.column(heading, move |row: &Vec<Cell>| row[place].clone())
    });
    sheet.table(&rows)
}

/// Its charts, with what their files are called without their ends.
pub(super) fn charts<'a>(page: &'a Page<'a>, told: &'static ToldChart) -> Vec<(String, SeriesChart)> {
    let mut charts = Vec::new();
    if let Some(mut at) = Evaluation::of_page(page) {
        at.each(&told.each, &mut |at| charts.push(chart(page, told, at)));
    }
    charts
}

fn chart<'a>(page: &Page<'_>, told: &'static ToldChart, at: &mut Evaluation<'a>) -> (String, SeriesChart) {
    let words = |at: &mut Evaluation<'a>, what: &'a Expression| at.cell(what).describe();
    let rest = told.name.as_ref().map_or_else(String::new, |name| words(at, name));
    let has_key = told.key_if.as_ref().is_none_or(|key| at.holds(key) == Some(true));
    let subtitle = words(at, &told.subtitle);
    let mut panels = Vec::new();
    at.each(&told.panels_of, &mut |at| {
        for (title, quantity, value) in &told.panels {
            let title = at.variable(title).and_then(|title| title.text()).unwrap_or_else(|| title.clone());
            let steps = at.value(&told.steps).map_or_else(Vec::new, Value::items);
            let mut series = Vec::new();
            at.each(&told.lines, &mut |at| {
                let label = words(at, &told.label);
                let dashed = told.dashed.as_ref().is_some_and(|dashed| at.holds(dashed) == Some(true));
                let values = steps.iter().map(|step| {
                    at.variables.push(("$step", step.clone()));
                    let found = at.value(value).and_then(|value| value.number());
                    at.variables.pop();
                    found.map(|number| number.value)
                });
                series.push(Series { label, values: values.collect(), dashed });
            });
            let name = |step: &Value<'_>| step.clone().items().first().and_then(Value::text).unwrap_or_default();
            panels.push(SeriesPanel {
                title,
                setting: told.setting.clone(),
                steps: steps.iter().map(name).collect(),
                quantity: quantity.clone(),
                series,
            });
        }
    });
    let stem = file_stem(&format!("figure_{}{rest}", page.experiment.name.replace('-', "_")));
    let key = told.key.as_ref().filter(|_| has_key).map(|key| key.each_ref().map(String::as_str));
    (stem, SeriesChart { title: told.title.clone(), subtitle, key, panels })
}
