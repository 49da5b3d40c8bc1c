//! Tables whose rows are tracers at settings, as data.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use tracebench_api::Preset;

use super::Family;

/// A table.
#[derive(Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Stable name; files are named after it.
    pub name: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// Ray sets where nothing else is said, as `--rays` takes them.
    pub rays: &'static str,
    /// Its rows.
    pub rows: Rows,
}

/// Which tracers at which settings have a row each.
#[derive(Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rows {
    /// Tracers of a family side by side.
    Peers {
        /// Whose tracers.
        family: Family,
        /// A parameter of the first of them, each of whose values worth sweeping has a row.
        swept: &'static str,
    },
    /// Every tracer that searches on the device, by each way to read and to launch.
    LaunchSettings,
    /// The switches of the improved form of the tracer whose room has the table, beside the first hierarchy on the device.
    Switches(Vec<Switched>),
}

/// A row: a preset with other values.
#[derive(Debug, PartialEq, Eq)]
pub struct Switched {
    /// From which preset.
    pub preset: Preset,
    /// Parameters with their values.
    pub values: Vec<(&'static str, &'static str)>,
}

impl Deserialize<'static> for Switched {
    /// In one line: `published lists=packed slices=1`.
    fn deserialize<D: Deserializer<'static>>(deserializer: D) -> Result<Self, D::Error> {
        let line = <&'static str>::deserialize(deserializer)?;
        let (preset, rest) = line.split_once(' ').unwrap_or((line, ""));
        let preset = Preset::ALL.into_iter().find(|each| each.name() == preset);
        let values = rest.split_whitespace().map(|word| word.split_once('=')).collect::<Option<_>>();
        let found = preset.zip(values).map(|(preset, values)| Self { preset, values });
        found.ok_or_else(|| D::Error::custom(format!("`{line}` is not `PRESET PARAMETER=VALUE ...`")))
    }
}
