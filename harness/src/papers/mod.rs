//! What the papers measured: their published values and claims as data, experiments that measure the same here, and verdicts on
//! the claims.
//!
//! Every paper has a folder with all that is its own, which is data; what stands beside the folders knows none of them, nor any tracer. A
//! folder's `published.json` and `claims.json` hold facts and figures with their scopes, read out of the paper's text. A figure
//! that only a lost picture has is `null`. How a claim is decided stands with it: which table measures which quantity of every
//! scene, and the range that it must lie in. Experiments, quantities, tables and charts of pages are data too, in the words that
//! `expression.rs` tells.

mod claims;
mod duration;
mod estimate;
mod evaluate;
mod experiment;
mod expression;
#[cfg(test)]
mod fixture;
mod frames;
mod functions;
mod page;
mod part;
mod published;
mod quantity;
mod rows;
#[cfg(test)]
mod tests;
mod times;
mod verdict;

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
use tracebench_api::{MemoryEntry, TraceTo, named};

use crate::plan::RunPreset;
use crate::registrations::embedded;
use crate::results::Row;
use evaluate::{Evaluation, Value};

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
}

/// Declares papers by the names of their folders.
macro_rules! papers {
    ($($(#[$doc:meta])* $PAPER:ident = $name:literal;)+) => {
        $($(#[$doc])* static $PAPER: Paper = Paper {
            name: $name,
            claims_table: concat!($name, "-claims"),
            experiments: LazyLock::new(|| embedded(include_str!(concat!($name, "/experiments.json")))),
            published: LazyLock::new(|| embedded(include_str!(concat!($name, "/published.json")))),
            claims: LazyLock::new(|| embedded(include_str!(concat!($name, "/claims.json")))),
            told: LazyLock::new(|| embedded(include_str!(concat!($name, "/quantities.json")))),
            pages: LazyLock::new(|| embedded(include_str!(concat!($name, "/pages.json")))),
            own: LazyLock::new(|| embedded(include_str!(concat!($name, "/paper.json")))),
        };)+

        /// Every paper, in the order of lists.
        pub static PAPERS: &[&Paper] = &[$(&$PAPER),+];
    };
}

papers! {
    /// Vardis, Vasilakis, Papaioannou: *DIRT: Deferred Image-based Ray Tracing*, HPG 2016. Its Table 3 counts depth bounds and lists as they
    /// are; a ray starts from every pixel of the frame (R_h), and each has head and node of the hit buffer, three shading points and the
    /// mask. It leaves the vertex buffer out, which rasterization has, and knows neither triangle setup nor copies in textures.
    DIRT = "dirt";
    /// Vardis, Vasilakis, Papaioannou: *A Multiview and Multilayer Approach for Interactive Ray Tracing*, I3D 2016. Its Table 2 counts the
    /// words of pixels (m_p), the id buffer (m_f) and the data buffer, of which the ledger has a part a view where one binding is too small;
    /// of bytes where data is not apart it does not speak. Papers that measured themselves beside its A-buffer take its formula.
    VVP16 = "vvp16";
    /// Hu, Huang, Zhang, Yuan, Li: *Ray tracing via GPU rasterization*, The Visual Computer 30 (2014). It tells no bytes.
    HHZ14 = "hhz14";
    /// Widmer, Pająk, Schulz, Pulli, Kautz, Goesele, Luebke: *An Adaptive Acceleration Structure for Screen-space Ray Tracing*, HPG 2015. It
    /// tells bytes of a node alone.
    WKP15 = "wkp15";
}

/// What is particular of a paper.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Own {
    /// Ray sets that are traced within minutes where an experiment has them.
    #[serde(borrow)]
    few_rays: Vec<&'static str>,
    /// Edges of the ray image and the frame, and of a cube face, that it measured at, if the run preset `paper` takes them.
    at_paper: Option<([u32; 2], u32)>,
    /// Counts that structures say of themselves and its pages show, with their headings.
    counts: Vec<(&'static str, &'static str)>,
    /// Tracers with those buffers of a trace, by name, that it counts as their memory beside the structure.
    #[serde(default)]
    of_a_trace: Vec<(&'static str, Vec<&'static str>)>,
}

named! {
    /// What is counted as memory.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(crate) enum Scope {
        /// The structure alone, what it uses by its own ledger.
        Structure = "structure",
        /// With it those buffers of a trace that the paper counts, as the ledger has them.
        WithTrace = "with_trace",
        /// What the paper's formula counts of the structure, with the paper's own buffers, computed.
        OfPaper = "of_paper",
    }
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
            Some((image, face)) if preset.name == "paper" => {
                RunPreset { ray_image: image, frame: image, face, ..preset }
            }
            _ => preset,
        }
    }

    /// A function that its data tells, or that of the paper from which it takes some.
    fn function(&self, name: &str) -> Option<&quantity::Function> {
        let other = || PAPERS.iter().find(|paper| self.told.takes_from.as_deref() == Some(paper.name));
        self.told.functions.get(name).or_else(|| other()?.told.functions.get(name))
    }

    /// A quantity by name.
    pub fn quantity(&self, name: &str) -> Option<&Quantity> {
        self.told.quantities.iter().find(|quantity| quantity.name == name)
    }

    /// Bytes of what the formulas of papers count: those parts of the structure, and of a trace the buffers in the paper's own set-up,
    /// which are not allocated here. None of tracers that no formula is about.
    fn by_formula(&self, row: &Row) -> Option<f64> {
        let (names, is) = self.function("by_formula")?;
        let variables = names.iter().map(|name| (name.as_str(), Value::Row(row))).collect();
        Some(Evaluation { paper: self, scenes: &[], page: None, variables }.value(is)?.number()?.value)
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
            Scope::OfPaper => self.by_formula(row).unwrap_or(structure),
        })
    }
}
