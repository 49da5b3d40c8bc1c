//! Device parts that several tracers share: views as uniforms, pipelines and dispatches, rasterized eye depth.

mod compute;
mod eye_depth;
mod view_uniform;

pub use compute::{bind_group, compute_pipeline, dispatch_linear, shader_module};
pub use eye_depth::{EyeDepthRaster, EyeDepthTarget, NO_SURFACE};
pub use view_uniform::ViewUniform;
