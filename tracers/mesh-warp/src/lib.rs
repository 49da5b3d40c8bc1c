//! `mesh-warp`: the depth buffer of one view as a mesh, drawn into the view of the one point that all rays start in.
//!
//! Bowles, Mitchell, Sumner, Moore and Gross, *Iterative Image Warping*, Computer Graphics Forum 31(2), 2012, and Didyk, Eisemann,
//! Ritschel, Myszkowski and Seidel, *Perceptually-motivated Real-time Temporal Upsampling of 3D Content for High-refresh-rate Displays*,
//! Computer Graphics Forum 29(2), 2010, as WKP15 (section 5.1) measured them: a regular grid with one vertex a pixel, at its stored eye
//! depth, without refinement. A build draws the depths and makes the mesh. A trace draws the mesh from where the rays start; every ray
//! takes the triangle at the centre of its pixel there, and hits the triangle's plane where the ray goes through it.
//!
//! - A triangle over a step in depth is stretched from the foreground to the background (WKP15, Figure 6b), or, with
//!   `discontinuity = cut`, not there. A triangle with a pixel that shows nothing is never there.
//! - Rays must all start in one point; others are refused ([`TracerError::Unsupported`](tracebench_api::TracerError::Unsupported)). Whether
//!   they do is looked up on the host before the trace's time.
//!
//! What the sources leave open:
//! - **The drawn view.** Nothing tells a trace which camera its rays are of. Where the view of the build, moved to the rays' origin, shows
//!   all of them, the mesh is drawn into that one: primary and stereo rays then are its pixels, or lie evenly in them. Else it is drawn into
//!   a view round the rays' mean direction, upright as the build's, as wide as the rays are, but no more than twice as wide as the build's;
//!   rays beyond it get the status `left_views`. The view is found on the host before the trace's time, as a renderer is given its
//!   camera; it has the resolution and the near plane of the build's.
//! - **Beside a pixel's centre** the plane of its triangle goes on by as much as the triangle's vertices differ in depth. That of a triangle
//!   over a step in depth (`step_from`) ends at its vertices' depths. A ray through a pixel's centre always hits the triangle itself.
//! - **The border.** Vertices lie at pixels' centres, but those of the outermost pixels on the image's border: else the mesh would end half
//!   a pixel within the view that it stands for.
//! - **The diagonal** of every square goes from its upper right corner to its lower left one. Of triangles at one depth the rasterizer
//!   keeps the first, which is the same on every run.
//!
//! Surfaces: hits name no triangle. A trace that ends at surfaces draws the view of the build once more with the triangles' numbers, in the
//! trace's own time, and takes normal and material of the triangle at the nearest of the three vertices.

mod description;
mod mesh;
mod structure;
mod trace;

pub use description::description;
pub use structure::MeshWarp;
