//! The shares of wrong rays that are expected where they are not none: a file with a line a tracer and case and a column a kind of adapter,
//! which is made of records. Why rays are wrong is in the tracers' registrations.

use std::collections::{BTreeMap, BTreeSet};

use itertools::Itertools as _;

use super::{Measured, Stability, Verdict};
use crate::cases::{CASES, Case};
use crate::machine::Machine;
use crate::registry::{Registration, TRACERS};
use crate::results::{Record, Rule, Wrong};
use tracebench_api::Preset;

/// The file, as the program was built with it.
const STATED: &str = include_str!("expected.csv");

/// The kind of adapter that stands for those without a column of their own, and for hosts without an adapter.
const SOFTWARE: &str = "software";

/// The kind of a machine's adapter.
pub(super) fn kind_of(machine: &Machine) -> &str {
    machine.adapter.as_ref().map_or(SOFTWARE, |adapter| &adapter.kind)
}

/// Why expected shares cannot be read, or not be made of a record.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExpectedError {
    /// The text is no such file.
    #[error("not a file of expected shares: {0}")]
    Text(String),
    /// The record has none.
    #[error("no expected shares can be made of this record: {0}")]
    Record(String),
}

/// Wrong rays in percent, rounded to three decimals, by value of the difficulty parameter; `None` where there were no answers.
type Cell = BTreeMap<String, Option<f64>>;

/// Shares of wrong rays by tracer and case, then by kind of adapter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExpectedShares(BTreeMap<(String, String), BTreeMap<String, Cell>>);

impl ExpectedShares {
    /// Those that the program was built with.
    ///
    /// # Errors
    /// [`ExpectedError::Text`] if they cannot be read.
    pub fn stated() -> Result<Self, ExpectedError> {
        Self::parse(STATED)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`ExpectedError::Text`] if it is none.
    pub fn parse(text: &str) -> Result<Self, ExpectedError> {
        let wrong = |what: &dyn std::fmt::Display| ExpectedError::Text(what.to_string());
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().map_err(|error| wrong(&error))?.clone();
        if header.iter().take(2).ne(["tracer", "case"]) {
            return Err(wrong(&"its first columns are not tracer and case"));
        }
        let mut shares = Self::default();
        for line in reader.records() {
            let line = line.map_err(|error| wrong(&error))?;
            let cells = header.iter().zip(&line).skip(2).filter(|(_, cell)| !cell.is_empty());
            let cell = |(kind, text): (&str, &str)| Some((kind.to_owned(), cell(text)?));
            let cells: Option<BTreeMap<String, Cell>> = cells.map(cell).collect();
            let cells =
                cells.ok_or_else(|| wrong(&format!("a cell of {}, {} has no such value", &line[0], &line[1])))?;
            if header.len() == 2 {
                return Err(wrong(&format!("its line {}, {} has no shares", &line[0], &line[1])));
            }
            shares.0.insert((line[0].to_owned(), line[1].to_owned()), cells);
        }
        Ok(shares)
    }

    /// The file's text: lines sorted by tracer and case, shares in percent after the difficulty parameter's values.
    pub fn text(&self) -> String {
        let kinds: BTreeSet<&String> = self.0.values().flat_map(BTreeMap::keys).collect();
        let line =
            |first: [&str; 2], cells: Vec<String>| [&first.map(str::to_owned)[..], &cells].concat().join(",") + "\n";
        let mut text = line(["tracer", "case"], kinds.iter().map(|kind| (*kind).clone()).collect());
        for ((tracer, case), cells) in &self.0 {
            let cells = kinds.iter().map(|kind| cells.get(*kind).map_or_else(String::new, in_words));
            text.push_str(&line([tracer, case], cells.collect()));
        }
        text
    }

    /// What is expected of a tracer on a case at each of the difficulty parameter's values, on a kind of adapter; empty if nothing is
    /// stated. Kinds without a column are expected to be as software is.
    pub fn of(&self, tracer: &str, case: &str, kind: &str, values: &[f64]) -> Vec<Option<f64>> {
        let cells = self.0.get(&(tracer.to_owned(), case.to_owned()));
        let cell = cells.and_then(|cells| cells.get(kind).or_else(|| cells.get(SOFTWARE)));
        let share =
            |cell: &Cell, value: &f64| cell.get(&value.to_string()).copied().flatten().map(|percent| percent / 100.0);
        let at = |cell: &Cell| values.iter().map(|value| share(cell, value)).collect();
        cell.map(at).unwrap_or_default()
    }

    /// Takes what a record of cases measured into the column of its adapter, and leaves out what no tracer is expected to be any more.
    ///
    /// # Errors
    /// [`ExpectedError::Record`] if it is of no cases, of changed parameters or of an invalid case.
    pub fn take(&mut self, record: &Record) -> Result<(), ExpectedError> {
        let refuse = |reason: String| Err(ExpectedError::Record(reason));
        let Some(found) = Stability::of(record) else { return refuse("it is not of stability cases".to_owned()) };
        if !found.counts {
            return refuse("parameters were changed by --set; measure without it".to_owned());
        }
        if let Some(case) = found.cases.iter().find(|case| case.case.invalid.is_some()) {
            return refuse(format!("the case {} is invalid; measure it again", case.case.name));
        }
        let rules = expected_rules();
        for case in &found.cases {
            for cell in case.cells.iter().filter(|cell| cell.verdict != Verdict::Unavailable) {
                let key = (cell.tracer.clone(), case.case.name.clone());
                let Some(rule) = rules.get(&key) else { continue };
                let percent = |wrong: Wrong| (wrong.under(*rule) * 1e5).round() / 1e3;
                let share = |each: &Measured| (each.difficulty_level.to_string(), each.wrong.map(percent));
                let cells = self.0.entry(key).or_default();
                cells.insert(kind_of(&record.provenance.machine).to_owned(), cell.measured.iter().map(share).collect());
            }
        }
        self.0.retain(|key, _| rules.contains_key(key));
        Ok(())
    }
}

/// By which rule rays of a tracer are wrong on a case, where some may be.
fn expected_rules() -> BTreeMap<(String, String), Rule> {
    let rule = |((tracer, preset), case): ((&Registration, Preset), &Case)| {
        let expected = tracer.expected_of(preset, case.name).filter(|expected| expected.kind.has_shares())?;
        Some(((tracer.column(preset), case.name.to_owned()), expected.rule))
    };
    TRACERS.iter().cartesian_product(Preset::ALL).cartesian_product(CASES.iter()).filter_map(rule).collect()
}

fn cell(text: &str) -> Option<Cell> {
    let share = |text: &str| match text {
        "-" => Some(None),
        _ => text.parse::<f64>().ok().filter(|percent| (0.0..=100.0).contains(percent)).map(Some),
    };
    let pair = |pair: &str| pair.split_once(':').and_then(|(value, text)| Some((value.to_owned(), share(text)?)));
    text.split(' ').map(pair).collect()
}

/// In the order of the difficulty parameter's values.
fn in_words(cell: &Cell) -> String {
    let mut pairs: Vec<_> = cell.iter().collect();
    let number = |value: &str| value.parse::<f64>().unwrap_or_default();
    pairs.sort_by(|(one, _), (other, _)| number(one).total_cmp(&number(other)));
    let percent = |share: &Option<f64>| share.map_or("-".to_owned(), |percent| percent.to_string());
    pairs.into_iter().map(|(value, share)| format!("{value}:{}", percent(share))).collect::<Vec<_>>().join(" ")
}
