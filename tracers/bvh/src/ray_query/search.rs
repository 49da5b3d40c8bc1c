//! Pipelines of ray queries and their dispatch.

use std::sync::Arc;

use tracebench_api::wgpu::{Buffer, ComputePipeline};
use tracebench_api::{Gpu, HitBuffer, PhaseClock, Query, RayBuffer, TracerError};
use tracebench_kit::{DevicePipelines, Gather, bind_group, compute_pipeline, dispatch_linear, uniform_buffer};
use tracebench_shaders::bvh::RAY_QUERY;

use super::acceleration::Acceleration;
pub(crate) use tracebench_shaders::bvh::QuerySettings;

/// As `WORKGROUP_SIZE` in shaders/bvh/ray_query.wgsl.
const WORKGROUP_SIZE: u32 = 64;

/// What is asked of the acceleration structure.
#[derive(Clone, Copy)]
pub(super) enum Question<'a> {
    /// The hit of every ray.
    Trace {
        /// Whether of hits at equal t the lower primitive is wanted.
        lowest_of_equal: bool,
    },
    /// The same, and what can be counted.
    TraceCounted {
        /// As above.
        lowest_of_equal: bool,
        /// A u32 a ray.
        counts: &'a Buffer,
        /// A bit a triangle.
        offered: &'a Buffer,
    },
    /// Of every ray its hit on the triangle of its own number.
    FindOwnTriangle,
}

/// The device with every pipeline.
pub struct Queries {
    pub(super) gpu: Arc<Gpu>,
    trace: ComputePipeline,
    trace_counted: ComputePipeline,
    find_own_triangle: ComputePipeline,
    pub(super) gather: Gather,
}

impl DevicePipelines for Queries {
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        if !gpu.has_ray_queries() {
            let listing = &gpu.listing;
            return Err(TracerError::Unavailable(format!(
                "{}, driver {}, has no ray queries (wgpu feature EXPERIMENTAL_RAY_QUERY)",
                listing.name, listing.driver_version
            )));
        }
        let pipeline = |entry_point| compute_pipeline(&gpu, RAY_QUERY, entry_point);
        Ok(Self {
            trace: pipeline("trace")?,
            trace_counted: pipeline("trace_counted")?,
            find_own_triangle: pipeline("find_own_triangle")?,
            gather: Gather::new(&gpu)?,
            gpu,
        })
    }
}

impl Queries {
    /// Records one question about every ray.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails, others as rays and hits say.
    pub(super) fn record(
        &self,
        question: Question<'_>,
        acceleration: &Acceleration,
        rays: &RayBuffer,
        hits: &HitBuffer,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let (pipeline, counts, lowest_of_equal) = match question {
            Question::Trace { lowest_of_equal } => (&self.trace, [None; 2], lowest_of_equal),
            Question::TraceCounted { lowest_of_equal, counts, offered } => {
                (&self.trace_counted, [Some(counts), Some(offered)], lowest_of_equal)
            }
            Question::FindOwnTriangle => (&self.find_own_triangle, [None; 2], false),
        };
        let scale = acceleration.scale.get();
        let settings = QuerySettings {
            ray_count: rays.host.len() as u32,
            any_hit: u32::from(rays.query == Query::Any),
            lowest_of_equal: u32::from(lowest_of_equal),
            scale,
            unscale: 1.0 / scale,
            max_t: (f64::from(f32::MAX) / 2.0 / f64::from(scale)).min(f64::from(f32::MAX)) as f32,
        };
        let gpu = &*self.gpu;
        let uniform = uniform_buffer(gpu, "settings", &settings)?;
        let mut resources = vec![
            uniform.as_entire_binding(),
            acceleration.top.as_binding(),
            rays.on_device()?.as_entire_binding(),
            hits.on_device(rays.host.len())?.as_entire_binding(),
        ];
        resources.extend(counts.into_iter().flatten().map(Buffer::as_entire_binding));
        let bindings = bind_group(gpu, &pipeline.get_bind_group_layout(0), &resources);
        clock.device_phase("query", |encoder| {
            dispatch_linear(encoder, pipeline, &bindings, settings.ray_count, WORKGROUP_SIZE);
        })
    }
}
