//! What drivers are free to do when they rasterize.

use serde::{Deserialize, Serialize};

/// What a device's rasterizer was found to do where Vulkan leaves drivers a choice: what is held against exact coverage and depth
/// goes by it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rasterizer {
    /// By how much along an axis a border is drawn from where it is, at most: drivers snap corners to a grid below pixels, and
    /// Vulkan asks for one of a sixteenth. Pixels.
    pub snap_pixels: f64,
    /// By how much a depth that is interpolated in perspective is off beside what snapping explains, at most, of triangles that
    /// the view shows whole; share of the depth.
    pub depth_error: f64,
    /// The same of triangles that reach far out of the view.
    pub depth_error_beyond_view: f64,
    /// How far triangles may reach, in heights of the eye above their plane, without a pixel that they cover being left out: drivers
    /// clip in f32, and lose the largest ones whole.
    pub reach: f64,
}

impl Rasterizer {
    /// By how much a border between two corners that are snapped is off, at most, pixels.
    pub fn border_pixels(&self) -> f64 {
        std::f64::consts::SQRT_2 * self.snap_pixels
    }
}
