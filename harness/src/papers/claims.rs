//! What a paper claims, and how each claim is decided here.

use serde::{Deserialize, Serialize};

use super::estimate::Estimate;
use super::verdict::Verdict;

/// A claim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Stable name.
    pub id: String,
    /// The paper's short name.
    pub paper: String,
    /// Where it stands.
    pub section: String,
    /// `text`: stated; `table`: follows from a table; `derived`: a reading of the figures that the paper does not state.
    pub source: String,
    /// What is claimed.
    pub statement: String,
    /// Under what conditions, and how it is measured where the paper leaves that open.
    pub conditions: String,
    /// The value, or the ends of a range; `None` where no number is given.
    pub published: Option<Vec<f64>>,
    /// Its unit.
    pub unit: String,
    /// What the paper's own figures say.
    pub own_figures: Option<String>,
    /// Whether they agree; `None` where none can tell.
    pub agrees_with_own_figures: Option<bool>,
    /// Whether times must be those of hardware rasterization.
    pub needs_hardware_raster: bool,
    /// How it is decided.
    pub test: Test,
}

/// How a claim is decided.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Test {
    /// By a quantity of a table.
    Measured {
        /// The table.
        table: String,
        /// The quantity, one of the paper's.
        quantity: String,
        /// The same by other readings of what the paper leaves open, such as where a ray starts or a cap: where they do not all lead to
        /// the same decision the claim is undecided.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        either: Vec<String>,
        /// The paper's scenes that it is about, of whose stand-ins alone the quantity is taken; none for all of the table's.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        scenes: Vec<String>,
        /// What it must be.
        rule: Rule,
    },
    /// Not by anything here.
    NotMeasurable {
        /// Why.
        not_measurable: String,
    },
}

/// The range that values must lie in, ends included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rule {
    /// Which values.
    pub over: Over,
    /// The lower end.
    pub least: Option<f64>,
    /// The upper end.
    pub most: Option<f64>,
}

/// Which of the scenes' values must lie in the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Over {
    /// Their median.
    Median,
    /// Every one.
    Every,
    /// More than half.
    Most,
}

impl Claim {
    /// The table that measures it, if one does.
    pub fn table(&self) -> Option<&str> {
        match &self.test {
            Test::Measured { table, .. } => Some(table),
            Test::NotMeasurable { .. } => None,
        }
    }

    /// The quantities by other readings.
    pub fn either(&self) -> &[String] {
        match &self.test {
            Test::Measured { either, .. } => either,
            Test::NotMeasurable { .. } => &[],
        }
    }
}

impl Rule {
    /// Where an interval lies: within the range, outside of it, or over one of its ends.
    pub(super) fn place(&self, found: &Estimate) -> Verdict {
        let [low, high] = found.interval;
        let above = |end: f64| self.most.is_some_and(|most| end > most);
        let below = |end: f64| self.least.is_some_and(|least| end < least);
        match () {
            () if !found.doubts.is_empty() => Verdict::Undecided,
            () if above(low) || below(high) => Verdict::DoesNotHold,
            () if above(high) || below(low) => Verdict::Undecided,
            () => Verdict::Holds,
        }
    }

    /// Whether what was found, at least one, is as it must be; open where that hangs on intervals that reach over an end of the range
    /// or on what is doubted.
    pub fn decide(&self, found: &[Estimate]) -> Verdict {
        let count = |wanted: Verdict| found.iter().filter(|each| self.place(each) == wanted).count();
        let (held, failed) = (count(Verdict::Holds), count(Verdict::DoesNotHold));
        match self.over {
            // What is doubted may lie anywhere.
            Over::Median => {
                let interval = [(0, f64::NEG_INFINITY), (1, f64::INFINITY)].map(|(end, open)| {
                    let ends = found.iter().map(|each| if each.doubts.is_empty() { each.interval[end] } else { open });
                    crate::statistics::median(&ends.collect::<Vec<_>>())
                });
                self.place(&Estimate::timed(0.0, interval, []))
            }
            Over::Every if failed > 0 => Verdict::DoesNotHold,
            Over::Every if held == found.len() => Verdict::Holds,
            Over::Most if 2 * held > found.len() => Verdict::Holds,
            Over::Most if 2 * (found.len() - failed) <= found.len() => Verdict::DoesNotHold,
            Over::Every | Over::Most => Verdict::Undecided,
        }
    }

    /// The rule in words.
    pub fn describe(&self) -> String {
        let over = match self.over {
            Over::Median => "median over the scenes",
            Over::Every => "every scene",
            Over::Most => "more than half of the scenes",
        };
        let range = match (self.least, self.most) {
            (Some(least), Some(most)) if least == most => format!("{least}"),
            (Some(least), Some(most)) => format!("from {least} to {most}"),
            (Some(least), None) => format!("at least {least}"),
            (None, Some(most)) => format!("at most {most}"),
            (None, None) => "any".to_owned(),
        };
        format!("{over} {range}")
    }
}
