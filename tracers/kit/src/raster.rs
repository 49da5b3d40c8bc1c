//! Pipelines that draw triangles.

use tracebench_api::wgpu::{
    ColorTargetState, CompareFunction, DepthStencilState, FragmentState, RenderPipeline, RenderPipelineDescriptor,
    TextureFormat, VertexBufferLayout, VertexState,
};
use tracebench_api::{Gpu, TracerError};
use tracebench_shaders::Shader;

use crate::compute::{options, shader_module};

/// What a pipeline draws from and into, beside what its shader binds.
#[derive(Clone, Debug, Default)]
pub struct RasterTargets<'a> {
    /// Vertex buffers; none where the vertex stage reads storage buffers.
    pub vertex_buffers: &'a [Option<VertexBufferLayout<'a>>],
    /// Colour attachments.
    pub colours: &'a [Option<ColorTargetState>],
    /// The depth attachment: its format, whether it is written, and which depths pass.
    pub depth: Option<(TextureFormat, bool, CompareFunction)>,
    /// Whether the fragment stage, which writes to buffers, is to run for nothing that its depth test rejects.
    pub tests_early: bool,
}

/// A pipeline with the entry points `vertex` and `fragment` of a shader. Two-sided: nothing is culled.
///
/// # Errors
/// [`TracerError::Unavailable`] if the device's limits forbid it, [`TracerError::Failed`] if the device refuses it.
pub fn raster_pipeline(
    gpu: &Gpu,
    shader: impl Into<Shader>,
    targets: &RasterTargets<'_>,
) -> Result<RenderPipeline, TracerError> {
    let shader = shader.into();
    let module = &shader_module(gpu, shader, &["vertex", "fragment"], targets.tests_early)?;
    let depth = |(format, writes, passes)| DepthStencilState {
        format,
        depth_write_enabled: Some(writes),
        depth_compare: Some(passes),
        stencil: Default::default(),
        bias: Default::default(),
    };
    let pipeline = gpu.device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some(shader.name),
        layout: None,
        vertex: VertexState {
            module,
            entry_point: Some("vertex"),
            compilation_options: options(shader),
            buffers: targets.vertex_buffers,
        },
        primitive: Default::default(),
        depth_stencil: targets.depth.map(depth),
        multisample: Default::default(),
        fragment: Some(FragmentState {
            module,
            entry_point: Some("fragment"),
            compilation_options: options(shader),
            targets: targets.colours,
        }),
        multiview_mask: None,
        cache: None,
    });
    gpu.check()?;
    Ok(pipeline)
}
