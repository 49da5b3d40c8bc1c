//! A view in the layout of the shaders.

use bytemuck::Zeroable;
use tracebench_api::View;
pub use tracebench_shaders::shared::View as ViewUniform;

/// An array of a shader that has room for so many views, zero where there are none.
pub fn view_uniforms<const N: usize>(views: impl IntoIterator<Item = ViewUniform>) -> [ViewUniform; N] {
    let mut all = [ViewUniform::zeroed(); N];
    all.iter_mut().zip(views).for_each(|(slot, view)| *slot = view);
    all
}

/// A view as shaders have it.
pub fn view_uniform(view: &View) -> ViewUniform {
    ViewUniform {
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
