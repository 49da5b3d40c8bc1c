//! `fragment-abuffer`: the multiview and multilayer fragment A-buffer.
//!
//! Vardis, Vasilakis, Papaioannou, *A Multiview and Multilayer Approach for Interactive Ray Tracing*, I3D 2016. The scene is
//! rasterized into the camera's view and six cube faces, and every fragment of every pixel is kept, in order of depth. A ray is
//! marched over these images and hits a fragment whose depth lies within the depths that the ray has in its pixel.

mod arrays;
mod build;
mod clipped;
mod description;
mod layout;
mod objects;
mod parts;
#[cfg(test)]
mod planes_tests;
mod structure;
#[cfg(test)]
mod tests;
mod trace;
#[cfg(test)]
mod trace_tests;
mod validate;

pub use description::description;
pub use structure::FragmentAbuffer;
