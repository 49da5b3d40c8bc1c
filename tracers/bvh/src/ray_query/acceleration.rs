//! Acceleration structures in the device's memory: one bottom level over all triangles, and a top level of one instance.

use std::cell::Cell;

use tracebench_api::wgpu::{
    AccelerationStructureFlags, AccelerationStructureGeometryFlags, AccelerationStructureUpdateMode, Blas,
    BlasBuildEntry, BlasGeometries, BlasGeometrySizeDescriptors, BlasTriangleGeometry,
    BlasTriangleGeometrySizeDescriptor, Buffer, BufferUsages, CreateBlasDescriptor, CreateTlasDescriptor, IndexFormat,
    Tlas, TlasInstance, VertexFormat,
};
use tracebench_api::{Geometry, Gpu, Ledger, MemoryReport, PhaseClock, TracerError};

use super::description::Preference;
use crate::input::scale_for;

const BOTTOM: &str = "bottom-level acceleration structure";
const TOP: &str = "top-level acceleration structure";
/// wgpu's own name for what it keeps of a top level's instances.
const INSTANCES: &str = "(wgpu-core) instances_buffer";
const TRANSFORM: &str = "scale of the triangles";

/// Added to a part's name where the backend does not tell its size; its bytes are given as 0.
const NOT_TOLD: &str = " (size not told by the backend)";

/// A row-major 3x4 matrix.
type Transform = [f32; 12];

fn scaling(factor: f32) -> Transform {
    [factor, 0.0, 0.0, 0.0, 0.0, factor, 0.0, 0.0, 0.0, 0.0, factor, 0.0]
}

/// Both levels over the triangles of one scene.
pub(super) struct Acceleration {
    /// From scene units to those of the structure, a power of two; set when a build is recorded.
    pub(super) scale: Cell<f32>,
    pub(super) top: Tlas,
    bottom: Blas,
    size: BlasTriangleGeometrySizeDescriptor,
    flags: AccelerationStructureFlags,
    /// The scale as the driver applies it to the vertices while it builds.
    transform: Buffer,
    memory: MemoryReport,
}

/// What a preference asks of the driver.
fn flags_of(prefer: Preference) -> AccelerationStructureFlags {
    let preference = match prefer {
        Preference::FastBuild => AccelerationStructureFlags::PREFER_FAST_BUILD,
        Preference::FastTrace => AccelerationStructureFlags::PREFER_FAST_TRACE,
    };
    preference | AccelerationStructureFlags::USE_TRANSFORM
}

fn size_of_scene(gpu: &Gpu, geometry: &Geometry) -> Result<BlasTriangleGeometrySizeDescriptor, TracerError> {
    let (vertices, triangles) = (geometry.positions.len() as u64, geometry.triangles.len() as u64);
    // Three indices a triangle are counted in 32 bits.
    let limit = u64::from(gpu.limits.max_blas_primitive_count.min(u32::MAX / 3));
    for (count, what) in [(vertices, "vertices"), (triangles, "triangles")] {
        if count > limit {
            return Err(TracerError::Unavailable(format!(
                "{} takes {limit} {what} in an acceleration structure, the scene has {count}: turn down its size",
                gpu.listing.name
            )));
        }
    }
    Ok(BlasTriangleGeometrySizeDescriptor {
        vertex_format: VertexFormat::Float32x3,
        vertex_count: vertices as u32,
        index_format: Some(IndexFormat::Uint32),
        index_count: Some(triangles as u32 * 3),
        flags: AccelerationStructureGeometryFlags::OPAQUE,
    })
}

impl Acceleration {
    /// Creates both levels, not yet built.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] for more triangles than the device takes, [`TracerError::Failed`] if its memory does
    /// not hold them.
    pub(super) fn new(gpu: &Gpu, geometry: &Geometry, prefer: Preference) -> Result<Self, TracerError> {
        let (size, flags) = (size_of_scene(gpu, geometry)?, flags_of(prefer));
        let before = gpu.allocations();
        let update_mode = AccelerationStructureUpdateMode::Build;
        let bottom = gpu.device.create_blas(
            &CreateBlasDescriptor { label: Some(BOTTOM), flags, update_mode },
            BlasGeometrySizeDescriptors::Triangles { descriptors: vec![size.clone()] },
        );
        // The transform is the bottom level's.
        let top_flags = flags - AccelerationStructureFlags::USE_TRANSFORM;
        let mut top = gpu.device.create_tlas(&CreateTlasDescriptor {
            label: Some(TOP),
            max_instances: 1,
            flags: top_flags,
            update_mode,
        });
        gpu.check()?;
        let after = gpu.allocations();
        top[0] = Some(TlasInstance::new(&bottom, scaling(1.0), 0, 0xff));
        let bytes = size_of::<Transform>() as u64;
        let transform = gpu.buffer(TRANSFORM, bytes, BufferUsages::BLAS_INPUT | BufferUsages::COPY_DST, "nothing")?;
        let mut ledger = Ledger::new();
        for name in [BOTTOM, TOP, INSTANCES] {
            match after.added_since(&before, name) {
                Some(bytes) => ledger.keep(name, bytes, bytes),
                None => ledger.keep(&format!("{name}{NOT_TOLD}"), 0, 0),
            }
        }
        ledger.keep(TRANSFORM, transform.size(), bytes);
        Ok(Self { scale: Cell::new(1.0), top, bottom, size, flags, transform, memory: ledger.report(0) })
    }

    /// Whether a build over a scene fits into what is there.
    pub(super) fn fits(&self, gpu: &Gpu, geometry: &Geometry, prefer: Preference) -> Result<bool, TracerError> {
        Ok(size_of_scene(gpu, geometry)? == self.size && flags_of(prefer) == self.flags)
    }

    /// Records the build, both levels, as one phase.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] if the scene is not on the device.
    pub(super) fn record_build(
        &self,
        gpu: &Gpu,
        geometry: &Geometry,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let on_device = geometry.on_device()?;
        let triangles = BlasTriangleGeometry {
            size: &self.size,
            vertex_buffer: &on_device.positions,
            first_vertex: 0,
            vertex_stride: 12,
            index_buffer: Some(&on_device.indices),
            first_index: Some(0),
            transform_buffer: Some(&self.transform),
            transform_buffer_offset: Some(0),
        };
        let entry =
            BlasBuildEntry { blas: &self.bottom, geometry: BlasGeometries::TriangleGeometries(vec![triangles]) };
        let top = &self.top;
        clock.device_phase("build acceleration structures", |encoder| {
            encoder.build_acceleration_structures([&entry], [top]);
        })?;
        self.scale.set(scale_for(geometry.diagonal()));
        gpu.queue.write_buffer(&self.transform, 0, bytemuck::cast_slice(&scaling(self.scale.get())));
        gpu.check()
    }

    pub(super) fn memory(&self) -> MemoryReport {
        self.memory.clone()
    }
}
