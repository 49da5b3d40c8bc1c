//! Parameters as data: what a tracer can be told, within which range, and to what effect.

use crate::named;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A parameter's value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Whole number.
    Integer(i64),
    /// Real number.
    Real(f64),
    /// One of a parameter's named choices.
    Choice(String),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Integer(value) => write!(f, "{value}"),
            Self::Real(value) => write!(f, "{value}"),
            Self::Choice(value) => write!(f, "{value}"),
        }
    }
}

/// What values a parameter takes. Bounds are inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Domain {
    /// Whole numbers.
    Integer {
        /// Least.
        least: i64,
        /// Greatest.
        greatest: i64,
    },
    /// Real numbers.
    Real {
        /// Least.
        least: f64,
        /// Greatest.
        greatest: f64,
    },
    /// Names.
    Choice(&'static [&'static str]),
}

/// Whether a parameter shapes the structure or only the search in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ParameterScope {
    /// A change needs a new build.
    Build,
    /// One build serves every value.
    Trace,
}

/// A parameter of a tracer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterDescription {
    /// Name, as used in `--set tracer.name=value` and in results.
    pub name: &'static str,
    /// Unit; empty for names and pure numbers.
    pub unit: &'static str,
    /// Build or trace.
    pub scope: ParameterScope,
    /// What values it takes.
    pub domain: Domain,
    /// The value in the `published` preset.
    pub published: Value,
    /// The value in the `improved` preset.
    pub improved: Value,
    /// What it does, in one line.
    pub effect: &'static str,
    /// Values worth sweeping.
    pub sweep: Vec<Value>,
}

named! {
    /// Named sets of values.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Preset {
        /// As the paper says; what a tracer's plain name means, always.
        Published = "published",
        /// The best that this suite knows.
        Improved = "improved",
    }
}

/// What is wrong with a parameter's name or value.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
pub enum ParameterError {
    /// No such parameter.
    #[error("there is no parameter '{name}'; there are: {known}")]
    Unknown {
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// No value for a parameter that a tracer has.
    #[error("there is no value of the parameter '{name}'")]
    Missing {
        /// The parameter.
        name: &'static str,
    },
    /// A value that does not parse or lies out of range.
    #[error("{name} = '{given}' is not allowed: {expected}")]
    Value {
        /// The parameter.
        name: String,
        /// The value given.
        given: String,
        /// What is allowed.
        expected: String,
    },
}

/// A tracer's parameters with their values: complete and in range for the tracer whose descriptions they are made from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Parameters {
    values: BTreeMap<String, Value>,
}

impl Parameters {
    /// The values of a preset.
    pub fn preset(descriptions: &[ParameterDescription], preset: Preset) -> Self {
        let pick = |description: &ParameterDescription| match preset {
            Preset::Published => description.published.clone(),
            Preset::Improved => description.improved.clone(),
        };
        Self { values: descriptions.iter().map(|each| (each.name.to_owned(), pick(each))).collect() }
    }

    /// Sets one value from text.
    ///
    /// # Errors
    /// If the name is unknown, or the value does not parse or is out of range.
    pub fn set(&mut self, descriptions: &[ParameterDescription], name: &str, text: &str) -> Result<(), ParameterError> {
        let description = descriptions.iter().find(|each| each.name == name).ok_or_else(|| {
            let known: Vec<_> = descriptions.iter().map(|each| each.name).collect();
            ParameterError::Unknown { name: name.to_owned(), known: known.join(", ") }
        })?;
        let value = description.parse(text)?;
        self.values.insert(name.to_owned(), value);
        Ok(())
    }

    /// Every parameter with its value, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.values.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// One parameter's value; none of a name that is not among them.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.values.get(name)
    }

    /// That there are no others than those of these names.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] with the first that is.
    pub fn has_only(&self, names: &[&str]) -> Result<(), ParameterError> {
        let other = self.values.keys().find(|name| !names.contains(&name.as_str()));
        other.map_or(Ok(()), |name| Err(ParameterError::Unknown { name: name.clone(), known: names.join(", ") }))
    }
}

impl ParameterDescription {
    /// Reads a value and checks its range.
    ///
    /// # Errors
    /// [`ParameterError::Value`] with what is allowed.
    pub fn parse(&self, text: &str) -> Result<Value, ParameterError> {
        let value = match self.domain {
            Domain::Integer { .. } => text.parse().ok().map(Value::Integer),
            Domain::Real { .. } => text.parse().ok().map(Value::Real),
            Domain::Choice(_) => Some(Value::Choice(text.to_owned())),
        };
        value.filter(|value| self.allows(value)).ok_or_else(|| self.refusal(text))
    }

    /// Whether it may have a value.
    pub(crate) fn allows(&self, value: &Value) -> bool {
        match (self.domain, value) {
            (Domain::Integer { least, greatest }, Value::Integer(value)) => (least..=greatest).contains(value),
            (Domain::Real { least, greatest }, Value::Real(value)) => (least..=greatest).contains(value),
            (Domain::Choice(names), Value::Choice(value)) => names.contains(&value.as_str()),
            _ => false,
        }
    }

    /// That a value is not allowed, with what is.
    pub(crate) fn refusal(&self, given: &str) -> ParameterError {
        let expected = match self.domain {
            Domain::Integer { least, greatest } => format!("a whole number from {least} to {greatest}"),
            Domain::Real { least, greatest } => format!("a number from {least} to {greatest}"),
            Domain::Choice(names) => format!("one of {}", names.join(", ")),
        };
        ParameterError::Value { name: self.name.to_owned(), given: given.to_owned(), expected }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn descriptions() -> Vec<ParameterDescription> {
        vec![ParameterDescription {
            name: "stride",
            unit: "pixels",
            scope: ParameterScope::Trace,
            domain: Domain::Integer { least: 1, greatest: 64 },
            published: Value::Integer(1),
            improved: Value::Integer(2),
            effect: "",
            sweep: Vec::new(),
        }]
    }

    /// Presets differ, values in range are taken, everything else is refused with the range.
    #[test]
    fn values_are_checked() {
        let descriptions = descriptions();
        let mut parameters = Parameters::preset(&descriptions, Preset::Published);
        assert_eq!(parameters.value("stride"), Some(&Value::Integer(1)));
        let improved = Parameters::preset(&descriptions, Preset::Improved);
        assert_eq!(improved.value("stride"), Some(&Value::Integer(2)));
        parameters.set(&descriptions, "stride", "8").unwrap();
        assert_eq!(parameters.value("stride"), Some(&Value::Integer(8)));
        for bad in ["0", "65", "x", "1.5", "NaN", ""] {
            assert!(parameters.set(&descriptions, "stride", bad).unwrap_err().to_string().contains("1 to 64"));
        }
        assert!(parameters.set(&descriptions, "strife", "1").is_err());
    }
}
