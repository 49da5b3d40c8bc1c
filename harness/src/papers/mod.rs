//! What the papers measured: their published values and claims as data, experiments that measure the same here, and verdicts on
//! the claims.
//!
//! Every paper has a folder with all that is its own; what stands beside the folders knows none of them, nor any tracer. A
//! folder's `published.json` and `claims.json` hold facts and figures with their scopes, read out of the paper's text. A figure
//! that only a lost picture has is `null`. How a claim is decided stands with it: which table measures which quantity of every
//! scene, and the range that it must lie in. Experiments, quantities, tables and charts of pages are data too, in the words that
//! `expression.rs` tells.

mod claims;
mod dirt;
mod duration;
mod estimate;
mod evaluate;
mod experiment;
mod expression;
#[cfg(test)]
mod fixture;
mod frames;
mod functions;
mod hhz14;
mod page;
mod part;
mod published;
mod quantity;
mod rows;
#[cfg(test)]
mod tests;
mod times;
mod verdict;
mod vvp16;
mod wkp15;

pub use claims::{Claim, Over, Rule, Test};
pub use duration::Duration;
pub use estimate::Estimate;
pub use experiment::{Experiment, ExperimentRow, StandIn, Step, TooManyRays};
pub(crate) use frames::with_rows;
pub use page::claims_of;
pub(crate) use page::{claims_report, report};
pub(crate) use part::PART_SETTINGS;
pub use published::{Publication, Published, PublishedColumn, PublishedRow, PublishedTable};
pub use quantity::{OfScene, Quantity};
pub use rows::{Rows, SceneRows};
pub use verdict::{JudgedClaim, MeasuredBy, SceneValue, Verdict, judge, judge_all};

use std::sync::LazyLock;

use serde::Deserialize;
use tracebench_api::{MemoryEntry, TraceTo};

use crate::plan::RunPreset;
use crate::results::Row;

/// Every paper, in the order of lists.
pub static PAPERS: &[&Paper] = &[&dirt::PAPER, &vvp16::PAPER, &hhz14::PAPER, &wkp15::PAPER];

/// A figure of a row.
type Figure = fn(&Row) -> Option<f64>;

/// A paper: what its folder holds.
#[derive(Debug)]
pub struct Paper {
    /// Its short name, that of its folder; its experiments are named after it.
    pub name: &'static str,
    /// The table of all that it claims.
    pub claims_table: &'static str,
    /// Its tables and figures, measured here: `experiments.json`.
    pub experiments: LazyLock<Vec<Experiment>>,
    /// What it printed: `published.json`.
    pub published: LazyLock<Published>,
    /// What it claims: `claims.json`.
    pub claims: LazyLock<Vec<Claim>>,
    /// What decides its claims: `quantities.json`.
    told: LazyLock<quantity::Told>,
    /// Tables and charts of their pages: `pages.json`.
    pages: LazyLock<page::told::Told>,
    /// What is particular of it: `paper.json`.
    own: LazyLock<Own>,
    /// Figures of a row that have their own maths, by name, for what decides claims.
    figures: &'static [(&'static str, Figure)],
    /// Bytes of what the formulas of papers count: those parts of the structure, and of a trace the buffers in the paper's own set-up,
    /// which are not allocated here. None of tracers that no formula is about.
    by_formula: Figure,
}

/// The paper of the folder in which this stands: its name, figures and bytes by formula.
macro_rules! paper {
    ($name:literal, $figures:expr, $by_formula:expr) => {
        $crate::papers::Paper {
            name: $name,
            claims_table: concat!($name, "-claims"),
            experiments: std::sync::LazyLock::new(|| $crate::registrations::embedded(include_str!("experiments.json"))),
            published: std::sync::LazyLock::new(|| $crate::registrations::embedded(include_str!("published.json"))),
            claims: std::sync::LazyLock::new(|| $crate::registrations::embedded(include_str!("claims.json"))),
            told: std::sync::LazyLock::new(|| $crate::registrations::embedded(include_str!("quantities.json"))),
            pages: std::sync::LazyLock::new(|| $crate::registrations::embedded(include_str!("pages.json"))),
            own: std::sync::LazyLock::new(|| $crate::registrations::embedded(include_str!("paper.json"))),
            figures: $figures,
            by_formula: $by_formula,
        }
    };
}
use paper;

/// What is particular of a paper.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Own {
    /// Ray sets that are traced within minutes where an experiment has them.
    #[serde(borrow)]
    few_rays: Vec<&'static str>,
    /// Its own resolutions, if the run preset `paper` takes them.
    at_paper: Option<Resolutions>,
    /// Counts that structures say of themselves and its pages show, with their headings.
    counts: Vec<(&'static str, &'static str)>,
    /// Tracers with those buffers of a trace, by name, that it counts as their memory beside the structure.
    #[serde(default)]
    of_a_trace: Vec<(&'static str, Vec<&'static str>)>,
}

/// Resolutions that a paper measured at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Resolutions {
    /// Width and height of the ray image and of the frame.
    image: [u32; 2],
    /// Edge of a cube face.
    face: u32,
}

/// What is counted as memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scope {
    /// The structure alone, what it uses by its own ledger.
    Structure,
    /// With it those buffers of a trace that the paper counts, as the ledger has them.
    WithTrace,
    /// What the paper's formula counts of the structure, with the paper's own buffers, computed.
    OfPaper,
}

impl Scope {
    /// Every scope, with what it is called on pages.
    pub(crate) const ALL: [(Self, &'static str); 3] = [
        (Self::Structure, "structure alone, used (MiB) ↓"),
        (Self::WithTrace, "with the buffers of a trace, by the ledger (MiB) ↓"),
        (Self::OfPaper, "with the paper's own buffers, computed, not allocated (MiB) ↓"),
    ];
}

/// Finds an experiment by name, with its paper.
pub fn find(name: &str) -> Option<(&'static Paper, &'static Experiment)> {
    PAPERS.iter().find_map(|paper| Some((*paper, paper.experiment(name)?)))
}

impl Paper {
    /// An experiment by name.
    pub fn experiment(&self, name: &str) -> Option<&Experiment> {
        self.experiments.iter().find(|experiment| experiment.name == name)
    }

    /// A run preset at the resolutions that this paper's tables have there.
    pub fn resolved(&self, preset: RunPreset) -> RunPreset {
        match self.own.at_paper {
            Some(Resolutions { image, face }) if preset.name == "paper" => {
                RunPreset { ray_image: image, frame: image, face, ..preset }
            }
            _ => preset,
        }
    }

    /// A quantity by name.
    pub fn quantity(&self, name: &str) -> Option<&Quantity> {
        self.told.quantities.iter().find(|quantity| quantity.name == name)
    }

    /// Bytes in a scope; none of a trace where none goes to surfaces.
    pub(crate) fn bytes(&self, row: &Row, scope: Scope) -> Option<f64> {
        let used = |parts: &[MemoryEntry], counted: &dyn Fn(&str) -> bool| -> f64 {
            parts.iter().filter(|part| counted(&part.name)).map(|part| part.used_bytes as f64).sum()
        };
        let structure = used(&row.memory.structure, &|_| true);
        Some(match scope {
            Scope::Structure => structure,
            Scope::WithTrace => {
                let to_surfaces = row.traces.iter().find(|trace| trace.trace_to == TraceTo::Surface)?;
                let of = self.own.of_a_trace.iter().find(|(tracer, _)| *tracer == row.tracer.name);
                structure + used(&to_surfaces.per_trace, &|name| of.is_some_and(|(_, names)| names.contains(&name)))
            }
            Scope::OfPaper => (self.by_formula)(row).unwrap_or(structure),
        })
    }
}
