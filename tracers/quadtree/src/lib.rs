//! `quadtree`: the adaptive quad-tree over depth layers.
//!
//! Widmer, Pająk, Schulz, Pulli, Kautz, Goesele, Luebke, *An Adaptive Acceleration Structure for Screen-space Ray Tracing*, HPG
//! 2015 (WKP15). The nearest surfaces of every pixel are drawn into a few depth layers; over each stands a quad-tree whose nodes are
//! boxes or, where one plane approximates all below it, planes. Rays are traced through the trees in the unit cube of the view, without a
//! stack; the next layer is asked where a ray passes behind what the one before shows.

mod build;
mod description;
mod images;
mod layers;
mod layout;
mod nodes;
mod structure;
mod trace;
mod validate;

#[cfg(test)]
mod function_tests;
#[cfg(test)]
mod layer_tests;
#[cfg(test)]
mod merge_tests;
#[cfg(test)]
mod patch_tests;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod secondary_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trace_tests;
#[cfg(test)]
mod way_tests;

pub use description::description;
pub use structure::Quadtree;
