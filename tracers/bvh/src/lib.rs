//! Bounding volume hierarchies built by the obvhs crate, by PLOC (Meister and Bittner, TVCG 2018) with parallel
//! reinsertion.
//!
//! `bvh-cpu` is an eight-wide compressed hierarchy (CWBVH; Ylitie, Karras and Laine, HPG 2017), traversed in f32 on all
//! cores. Its triangle test is obvhs's, which is not watertight, or one that is; its answers are judged like anyone's.
//!
//! `ploc-gpu` is built on the device by PLOC++ (Benthin et al., HPG 2022) and traversed as `bvh-gpu` is.
//!
//! `bvh-gpu` is the same hierarchy, or a binary one, uploaded and traversed in compute, with the watertight triangle test of
//! Woop, Benthin and Wald (JCGT 2013).
//!
//! `ray-query` leaves hierarchy and traversal to the device's driver, where it has ray queries.

mod binary;
mod cpu;
mod gpu;
mod hierarchy;
mod input;
mod ploc;
mod ray_query;
mod refit;
mod sah;
#[cfg(test)]
mod touched;
mod wide;

pub use cpu::{BvhCpu, description};
pub use gpu::{BINARY_STACK, BvhGpu, WIDE_STACK, description as gpu_description};
pub use ploc::{PlocGpu, description as ploc_description};
pub use ray_query::{RayQuery, description as ray_query_description};
