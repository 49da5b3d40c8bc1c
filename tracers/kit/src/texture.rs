//! Textures that are drawn into, one image or several.

use tracebench_api::Gpu;
use tracebench_api::wgpu::{self, TextureFormat, TextureUsages, TextureView};

/// A texture of one level and one layer.
pub fn create_texture(
    gpu: &Gpu,
    name: &str,
    size: [u32; 2],
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::Texture {
    create_texture_array(gpu, name, size, 1, format, usage)
}

/// A texture of one level and several layers.
pub(crate) fn create_texture_array(
    gpu: &Gpu,
    name: &str,
    [width, height]: [u32; 2],
    layers: u32,
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// The layers of a texture, each as an image of its own, and all as an array.
pub(crate) fn views_of(texture: &wgpu::Texture) -> (Vec<TextureView>, TextureView) {
    let view = |dimension, first, count| {
        texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(dimension),
            base_array_layer: first,
            array_layer_count: Some(count),
            ..Default::default()
        })
    };
    let layers = texture.depth_or_array_layers();
    let each = (0..layers).map(|layer| view(wgpu::TextureViewDimension::D2, layer, 1)).collect();
    (each, view(wgpu::TextureViewDimension::D2Array, 0, layers))
}
