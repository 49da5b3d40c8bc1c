//! What a paper claims, and how each claim is decided here.

use serde::{Deserialize, Serialize};

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
        /// The paper's scenes that it is about, of whose stand-ins alone the quantity is taken; none for all scenes.
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
}

impl Rule {
    /// Whether a value lies in the range.
    pub fn takes(&self, value: f64) -> bool {
        self.least.is_none_or(|least| value >= least) && self.most.is_none_or(|most| value <= most)
    }

    /// Whether values, at least one, are as they must be.
    pub fn holds(&self, values: &[f64]) -> bool {
        let taken = values.iter().filter(|value| self.takes(**value)).count();
        match self.over {
            Over::Median => self.takes(crate::statistics::median(values)),
            Over::Every => taken == values.len(),
            Over::Most => 2 * taken > values.len(),
        }
    }

    /// The rule in words.
    pub fn words(&self) -> String {
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
