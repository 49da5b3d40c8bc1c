//! `screen-dda`: screen-space ray tracing by perspective-correct DDA over a rasterized depth buffer of one view.
//!
//! McGuire and Mara, *Efficient GPU Screen-Space Ray Tracing*, Journal of Computer Graphics Techniques 3(4), 2014. A ray
//! is clipped to the view and its projection walked pixel by pixel along its major axis; it hits where its depth
//! interval in a pixel meets the stored surface, which is taken to be `thickness` thick. It sees what the view shows and
//! nothing else.
//!
//! Surfaces: hits name no triangle. A trace that ends at surfaces draws the view once more with the triangles' numbers, in
//! the trace's own time, and takes normal and material from the triangle at the pixel where a hit was found; its position is
//! the ray's point at the hit's t, as the method answers it. Hits and the structure are the same for both ends.
//!
//! Deviations from the paper, each chosen so that the suite can compare methods:
//! - Rays are clipped to the whole frustum, not only to the near plane, and depth intervals are held within the ray, so
//!   that rays that fall on one pixel (every primary ray does) are answered too.
//! - Such a ray has no position along its walk: its hit is placed at the ray's parameter at the stored eye depth. Every
//!   other hit is placed at its step's position, as in listing 1, or with `hit_point = depth` at the stored depth too,
//!   held within the ray's span in the step.
//! - The paper leaves thickness, step limit and jitter to the user. The defaults here are written in the parameters'
//!   descriptions; thickness is told in scene diagonals, so that it means the same in every scene.

mod description;
mod structure;

pub use description::description;
pub use structure::ScreenDda;
