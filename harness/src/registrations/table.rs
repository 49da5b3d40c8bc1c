//! Tables whose rows are tracers at settings, as data.

use tracebench_api::Preset;

use super::Family;

/// A table.
#[derive(Debug, PartialEq, Eq)]
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
#[derive(Debug, PartialEq, Eq)]
pub enum Rows {
    /// Tracers side by side.
    Peers {
        /// Whose tracers; every tracer without one.
        family: Option<Family>,
        /// A parameter of the first of them, each of whose values worth sweeping has a row.
        swept: Option<&'static str>,
    },
    /// Every tracer that searches on the device, by each way to read and to launch.
    LaunchSettings,
    /// The switches of the improved form of the tracer whose room has the table, beside the first hierarchy on the device.
    Switches(&'static [Switched]),
}

/// A row: a preset with other values.
#[derive(Debug, PartialEq, Eq)]
pub struct Switched {
    /// From which preset.
    pub preset: Preset,
    /// Parameters with their values.
    pub values: Values,
}

/// Parameters with their values.
pub type Values = &'static [(&'static str, &'static str)];

/// The table of a tracer's switches, as its room lists them.
pub(super) const fn switches(
    name: &'static str,
    summary: &'static str,
    rays: &'static str,
    rows: &'static [Switched],
) -> Table {
    Table { name, summary, rays, rows: Rows::Switches(rows) }
}

/// A row of the published preset with other values.
pub(super) const fn published(values: Values) -> Switched {
    Switched { preset: Preset::Published, values }
}

/// A row of the improved preset with other values.
pub(super) const fn improved(values: Values) -> Switched {
    Switched { preset: Preset::Improved, values }
}
