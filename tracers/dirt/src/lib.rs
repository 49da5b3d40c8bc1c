//! `dirt`: deferred image-based ray tracing.
//!
//! Vardis, Vasilakis, Papaioannou, *DIRT: Deferred Image-based Ray Tracing*, High Performance Graphics 2016. The scene is
//! rasterized into tiles of six views round the eye; a tile keeps lists of the triangles in it, in buckets of depth. A ray
//! walks the tiles that it passes and tests these triangles analytically.
//!
//! What the paper leaves open, and how it is here:
//! - The views are those of VVP16 (section 3.2), whose multiview setup the paper uses: along the world's axes, centres
//!   pulled back by the near distance (`centre`).
//! - Where the rasterizer has no conservative coverage, the vertex stage draws the rectangle of tiles that a triangle may
//!   touch, and the fragment stage decides by clipping. Tiles are grown by a thousandth for that, so that rounding loses
//!   no border.
//! - Views are searched in the order in which the ray meets them, each at most once; the released code finds the next view
//!   by leaving each with a small fixed offset.
//!
//! Preset `published` is the paper's. `improved` is the form of `packed` with a tree in every tile, which is exact.

mod build;
mod description;
mod fetch;
#[cfg(test)]
mod fetch_tests;
mod layout;
mod packed;
mod pipelines;
mod setup;
mod shadow_map;
#[cfg(test)]
mod shadow_map_tests;
mod statistics;
mod structure;
#[cfg(test)]
mod tests;
mod trace;
#[cfg(test)]
mod trace_tests;
mod validate;
mod visibility;
#[cfg(test)]
mod visibility_tests;

pub use description::description;
pub use structure::Dirt;
