//! Hu, Huang, Zhang, Yuan, Li: *Ray tracing via GPU rasterization*, The Visual Computer 30 (2014). It tells no bytes.

#[cfg(test)]
mod tests;

use super::{Paper, paper};

/// The paper.
pub(super) static PAPER: Paper = paper!("hhz14", &[], |_| None);
