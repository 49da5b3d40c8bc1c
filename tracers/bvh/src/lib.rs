//! Bounding volume hierarchies built by the obvhs crate.
//!
//! `bvh-cpu` is an eight-wide compressed hierarchy (CWBVH; Ylitie, Karras and Laine, HPG 2017) built by PLOC (Meister
//! and Bittner, TVCG 2018) with parallel reinsertion, traversed in f32 on all cores. Its triangle test is obvhs's, which
//! is not watertight; its answers are judged like anyone's.

mod cpu;
mod hierarchy;
mod refit;

pub use cpu::{BvhCpu, description};
