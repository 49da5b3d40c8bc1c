//! What the papers measured: their published values and claims as data, experiments that measure the same here, and verdicts on
//! the claims.
//!
//! `data/published.json` and `data/claims.json` hold facts and figures with their scopes, read out of the papers' text. A
//! figure that only a lost picture has is `null`. How a claim is decided stands with it: which table measures which quantity of
//! every scene, and the range that it must lie in.

mod claims;
mod experiments;
mod published;
mod quantities;
mod rows;
#[cfg(test)]
mod tests;
mod verdict;

pub use claims::{Claim, Over, Rule, Test, claims};
pub use experiments::{EXPERIMENTS, Experiment, Row, Shown, StandIn, Step, TooManyRays, find};
pub use published::{Paper, PublishedColumn, PublishedRow, PublishedTable, Setting, paper, papers, tables};
pub(crate) use quantities::{
    ABUFFER, MIXES, abuffer_formula, abuffer_ledger, bounces, counted, efficiency, layers, rays, tiles, total_ms, views,
};
pub use quantities::{Measure, QUANTITIES, Quantity, quantity};
pub use rows::{Rows, SceneRows};
pub(crate) use rows::{agreement, footprint, host_ms, integer, statistic, stored_bytes, trace};
pub use verdict::{JudgedClaim, MeasuredBy, SceneValue, Verdict, judge, judge_all};

/// Why embedded data cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{file} is not as it should be: {source}")]
pub struct DataError {
    /// The file.
    file: &'static str,
    /// What is wrong.
    source: serde_json::Error,
}
