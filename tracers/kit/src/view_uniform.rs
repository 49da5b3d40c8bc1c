//! A view in the layout of the shaders.

use bytemuck::{Pod, Zeroable};
use tracebench_api::View;

/// `View` of shaders/shared/view.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
#[allow(missing_docs, reason = "the fields are those of tracebench_api::View, which documents them")]
pub struct ViewUniform {
    pub eye: [f32; 3],
    pub tan_half_width: f32,
    pub right: [f32; 3],
    pub tan_half_height: f32,
    pub up: [f32; 3],
    pub near: f32,
    pub forward: [f32; 3],
    pub far: f32,
    pub size: [f32; 2],
    pub padding: [f32; 2],
}

impl ViewUniform {
    /// An array of a shader that has room for so many views, zero where there are none.
    pub fn array<const N: usize>(views: impl IntoIterator<Item = Self>) -> [Self; N] {
        let mut all = [Self::zeroed(); N];
        all.iter_mut().zip(views).for_each(|(slot, view)| *slot = view);
        all
    }
}

impl From<&View> for ViewUniform {
    fn from(view: &View) -> Self {
        Self {
            eye: view.eye.as_vec3().into(),
            tan_half_width: view.tan_half_width as f32,
            right: view.right.as_vec3().into(),
            tan_half_height: view.tan_half_height as f32,
            up: view.up.as_vec3().into(),
            near: view.near as f32,
            forward: view.forward.as_vec3().into(),
            far: view.far as f32,
            size: view.size.map(|edge| edge as f32),
            padding: [0.0; 2],
        }
    }
}
