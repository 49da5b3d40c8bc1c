//! The harness of tracebench: rays, ground truth, judge, controls, runner, results, reports.

pub mod cases;
pub mod cli;
pub mod compare;
pub mod controls;
pub mod explain;
pub mod hash;
pub mod judge;
pub mod machine;
pub mod peers;
pub mod picture;
pub mod plan;
pub mod progress;
pub mod rays;
mod records;
pub mod registry;
pub mod report;
pub mod results;
pub mod runner;
pub mod session;
pub mod stability;
pub mod statistics;
pub mod truth;
pub mod updates;
pub mod viewpoint;
