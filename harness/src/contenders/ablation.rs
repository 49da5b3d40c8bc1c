//! The switches of a tracer's improved form.

use tracebench_api::Preset;

/// A tracer's switches, as its room lists them for a table.
#[derive(Debug, PartialEq, Eq)]
pub struct Ablation {
    /// Stable name of its table; files are named after it.
    pub name: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// Ray sets where nothing else is said, as `--rays` takes them.
    pub rays: &'static str,
    /// One row each.
    pub rows: &'static [Switched],
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

/// A row of the published preset with other values.
pub(super) const fn published(values: Values) -> Switched {
    Switched { preset: Preset::Published, values }
}

/// A row of the improved preset with other values.
pub(super) const fn improved(values: Values) -> Switched {
    Switched { preset: Preset::Improved, values }
}
