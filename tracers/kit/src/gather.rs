//! Surfaces of hits on the device, gathered from the scene's vertices.

use tracebench_api::wgpu::{Buffer, BufferUsages, ComputePipeline};
use tracebench_api::{DeviceGeometry, Geometry, Gpu, HitBuffer, MemoryEntry, PhaseClock, RayBuffer, TracerError};
use tracebench_shaders::shared;

use crate::{bind_group, compute_pipeline, dispatch_linear};
pub use tracebench_shaders::shared::GatherSettings;

/// As `WORKGROUP_SIZE` in shaders/shared/gather.wgsl.
const WORKGROUP_SIZE: u32 = 64;

const SETTINGS: &str = "gather settings";

/// What of the scene a structure on the device keeps for surfaces.
#[derive(Clone, Debug)]
pub struct SurfaceGeometry {
    /// The scene's buffers.
    pub device: DeviceGeometry,
    /// Their bytes.
    pub bytes: u64,
}

impl SurfaceGeometry {
    /// That of a scene on the device.
    ///
    /// # Errors
    /// As [`Geometry::on_device`].
    pub fn of(geometry: &Geometry) -> Result<Self, TracerError> {
        Ok(Self { device: geometry.on_device()?.clone(), bytes: geometry.surface_bytes() })
    }
}

/// The pipelines that gather surfaces.
#[derive(Debug)]
pub struct Gather {
    by_weights: ComputePipeline,
    by_ray: ComputePipeline,
}

impl Gather {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        let pipeline = |by_ray| compute_pipeline(gpu, shared::Gather { by_ray }, "gather");
        Ok(Self { by_weights: pipeline(false)?, by_ray: pipeline(true)? })
    }

    /// What a gather takes while it runs.
    pub fn memory() -> MemoryEntry {
        MemoryEntry::whole(SETTINGS, size_of::<GatherSettings>() as u64)
    }

    /// Records the phase "gather": the surface of every hit, by its triangle and barycentric weights. With `seen`, one u32
    /// a ray, the triangle is that one, and the position the ray's point at the hit's t: for methods whose hits name no
    /// triangle.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene, [`TracerError::Failed`] without room for surfaces.
    pub fn record(
        &self,
        gpu: &Gpu,
        geometry: &SurfaceGeometry,
        rays: &RayBuffer,
        hits: &HitBuffer,
        seen: Option<&Buffer>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let count = rays.host.len();
        let DeviceGeometry { positions, indices, materials } = &geometry.device;
        for (name, buffer) in
            [("vertex positions", positions), ("vertex indices", indices), ("triangle materials", materials)]
        {
            gpu.check_storage_binding(name, buffer.size(), "the scene's triangle count")?;
        }
        let settings = GatherSettings { ray_count: count as u32, padding_a: 0, padding_b: 0, padding_c: 0 };
        let settings = gpu.buffer_with(SETTINGS, bytemuck::bytes_of(&settings), BufferUsages::UNIFORM, "nothing")?;
        let mut buffers =
            vec![&settings, positions, indices, materials, hits.on_device(count)?, hits.surfaces_on_device(count)?];
        let pipeline = match seen {
            None => &self.by_weights,
            Some(seen) => {
                buffers.extend([rays.on_device()?, seen]);
                &self.by_ray
            }
        };
        let resources: Vec<_> = buffers.into_iter().map(Buffer::as_entire_binding).collect();
        let bindings = bind_group(gpu, &pipeline.get_bind_group_layout(0), &resources);
        clock.device_phase("gather", |encoder| {
            dispatch_linear(encoder, pipeline, &bindings, count as u32, WORKGROUP_SIZE);
        })
    }
}
