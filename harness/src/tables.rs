//! Every table that `tracebench table` makes: of peers, and of the papers' tables and figures.

use crate::papers::{self, EXPERIMENTS, Experiment};
use crate::peers::{self, Subject, TABLES};

/// A table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Table {
    /// Tracers of one family side by side.
    Peers(&'static peers::Table),
    /// A paper's table or figure.
    Paper(&'static Experiment),
}

impl Table {
    /// Every table, those of peers first.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLES.iter().map(Self::Peers).chain(EXPERIMENTS.iter().map(Self::Paper))
    }

    /// Finds a table by name.
    pub fn find(name: &str) -> Option<Self> {
        peers::find(name).map(Self::Peers).or_else(|| papers::find(name).map(Self::Paper))
    }

    /// Its stable name; files are named after it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Peers(table) => table.name,
            Self::Paper(experiment) => experiment.name,
        }
    }

    /// What it shows, in one line.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Peers(table) => table.summary,
            Self::Paper(experiment) => experiment.summary,
        }
    }

    /// Ray sets where nothing else is said, as `--rays` takes them.
    pub fn rays(self) -> &'static str {
        match self {
            Self::Peers(table) => table.rays,
            Self::Paper(experiment) => experiment.rays,
        }
    }

    /// Whether it is over animations.
    pub fn is_moving(self) -> bool {
        matches!(self, Self::Peers(peers::Table { subject: Subject::Moving, .. }))
    }

    /// Whether a tracer of this name belongs into it.
    pub fn holds(self, tracer: &str) -> bool {
        match self {
            Self::Peers(table) => table.holds(tracer),
            Self::Paper(experiment) => experiment.holds(tracer),
        }
    }
}
