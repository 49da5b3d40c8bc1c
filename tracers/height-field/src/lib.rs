//! `height-field`: the depth buffer of one view as a height field, searched through a pyramid.
//!
//! Tevs, Ihrke and Seidel, *Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic Height Field Rendering*, I3D 2008, as WKP15
//! (section 5.1) measured it: the iterative form, without bilinear patches, with a binary search in the end. Every pixel is a column
//! whose top lies at its stored eye depth. All behind a top is solid: there is no thickness, and nothing hidden can be passed. A ray
//! that starts in solid hits at its start, and so does one that enters the view in it. Pixels without a surface hold nothing.
//!
//! The pyramid has of every cell the nearest depth (`pyramid = max`: the greatest height, the paper's maximum mipmaps), or the
//! farthest one as well (`min-max`, which WKP15 names): then a ray that enters a cell behind all of its tops need not go down. The
//! hits are the same.
//!
//! Surfaces: hits name no triangle. A trace that ends at surfaces draws the view once more with the triangles' numbers, in the
//! trace's own time, and takes normal and material from the triangle at the pixel where a hit was found.
//!
//! What the sources leave open, each chosen so that the suite can compare methods:
//! - Neither source says how many halvings a hit gets. The default, 24, brings it as near to the stored depth as f32 tells. As a
//!   column's top is level, `search = closed` finds the same place at once.
//! - Rays are walked from pixel to pixel exactly, as all image-space methods here are; a ray goes up a level where it comes into
//!   another cell of that.
//! - `start_bias` lets a ray that starts in the view leave out the first pixels of its way; WKP15's rays start at eyes and need none,
//!   so it is 0.

mod description;
mod structure;

pub use description::description;
pub use structure::HeightField;
