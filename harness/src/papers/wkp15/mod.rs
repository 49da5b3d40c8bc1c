//! Widmer, Pająk, Schulz, Pulli, Kautz, Goesele, Luebke: *An Adaptive Acceleration Structure for Screen-space Ray Tracing*, HPG 2015.
//! It tells bytes of a node alone.

#[cfg(test)]
mod tests;

use super::{Paper, paper};

/// The paper.
pub(super) static PAPER: Paper = paper!("wkp15", &[], |_| None);
