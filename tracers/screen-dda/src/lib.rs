//! `screen-dda`: screen-space ray tracing by perspective-correct DDA over a rasterized depth buffer of one view.
//!
//! McGuire and Mara, *Efficient GPU Screen-Space Ray Tracing*, Journal of Computer Graphics Techniques 3(4), 2014. A ray
//! is clipped to the view and its projection walked pixel by pixel along its major axis; it hits where its depth
//! interval in a pixel meets the stored surface, which is taken to be `thickness` thick. It sees what the view shows and
//! nothing else.
//!
//! Beside what the paper has, each off in the preset `published`:
//! - `layers`: up to four depths a pixel, drawn one behind the other (depth peeling), as the authors' released code
//!   (G3D, `screenSpaceRayTrace.glsl`) searches them: every sample asks each layer. With `layer_separation` surfaces that lie
//!   close behind one another count as one (Mara, McGuire, Luebke, *Lighting Deep G-Buffers*, NVIDIA 2013).
//! - `thickness_from = back_faces`: a surface is as thick as the nearest back face behind it lies; where there is none, as
//!   `thickness` says.
//! - `march = hi-z`: samples that cannot hit are skipped by a pyramid of depth bounds (Uludag, *Hi-Z Screen-Space Cone-Traced
//!   Reflections*, GPU Pro 5, 2014). The samples are those of the walk, not cells of the pyramid, so hits, statuses and the step
//!   limit are the same bit for bit. With several layers each has a pyramid, and samples are skipped where none can hit: layers
//!   with pyramids are what Hofmann, Bogendoerfer, Stamminger and Selgrad, *Hierarchical Multi-Layer Screen-Space Ray Tracing*,
//!   HPG 2017, combine; of that paper no more than the abstract was at hand, so how it is done here is this suite's own.
//! - `march = cells`: Uludag's own march, over cells of the pyramid down to every pixel that the ray crosses. With it there are
//!   `from_behind = pass`, by which a ray only hits what it was before a pixel ago (engines reject such hits by normals: AMD, FidelityFX
//!   SSSR), and `depth_clip`. The preset `improved` has all of it, hits at the stored depth and thickness as a share of depth.
//!
//! Surfaces: hits name no triangle. A trace that ends at surfaces draws the view once more with the triangles' numbers, in
//! the trace's own time (each layer), and takes normal and material from the triangle at the pixel where a hit was found; its position is
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
