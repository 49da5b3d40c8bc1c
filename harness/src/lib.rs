//! The harness of tracebench: rays, ground truth, judge, measurer, studies, results, reports.

pub mod cases;
pub mod cli;
pub mod compare;
pub mod exchange;
pub mod files;
pub mod hash;
pub mod judge;
pub mod launch;
pub mod machine;
pub mod measure;
pub mod papers;
pub mod peers;
pub mod plan;
pub mod progress;
pub mod rays;
pub mod registrations;
pub mod registry;
pub mod render;
pub mod report;
pub mod results;
pub mod statistics;
pub mod studies;
pub mod tables;
pub mod truth;
pub mod viewpoint;

#[cfg(test)]
#[path = "../build/fingerprint.rs"]
mod fingerprint;
#[cfg(test)]
mod house_tests;
