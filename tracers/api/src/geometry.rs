//! The triangles that a tracer builds from.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use wgpu::BufferUsages;

use crate::{Gpu, TracerError};

/// Triangles in host memory and, where a device is used, on the device. Opaque and two-sided for everyone.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Vertex positions, scene units.
    pub positions: Arc<Vec<[f32; 3]>>,
    /// Vertex indices of each triangle; the triangle's index is its identity.
    pub triangles: Arc<Vec<[u32; 3]>>,
    /// Index of each triangle's material in the scene.
    pub triangle_materials: Arc<Vec<u32>>,
    /// Least corner of the bounds; known before any build, for all.
    pub bounds_min: Vec3,
    /// Greatest corner of the bounds.
    pub bounds_max: Vec3,
    /// The same data on the device, or why it is not there.
    device: Result<DeviceGeometry, TracerError>,
}

/// Device buffers of a [`Geometry`], usable as vertex, index and storage buffers, and where the device has ray queries to
/// build acceleration structures from.
#[derive(Clone, Debug)]
pub struct DeviceGeometry {
    /// Three f32 per vertex, tightly packed.
    pub positions: wgpu::Buffer,
    /// Three u32 per triangle.
    pub indices: wgpu::Buffer,
    /// One u32 per triangle; a storage buffer.
    pub materials: wgpu::Buffer,
}

impl Geometry {
    /// Takes the triangles of a scene with one material; see [`Geometry::with_materials`].
    ///
    /// # Errors
    /// [`TracerError::Failed`] for an empty scene.
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, gpu: Option<&Gpu>) -> Result<Self, TracerError> {
        let materials = vec![0; triangles.len()];
        Self::with_materials(positions, triangles, materials, gpu)
    }

    /// Takes the triangles, which must not be empty, each with its material, and uploads them if there is a device. That a
    /// device cannot hold them is said to those who ask for them there.
    ///
    /// # Errors
    /// [`TracerError::Failed`] for an empty scene or another number of materials than triangles.
    pub fn with_materials(
        positions: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        triangle_materials: Vec<u32>,
        gpu: Option<&Gpu>,
    ) -> Result<Self, TracerError> {
        if triangle_materials.len() != triangles.len() {
            return Err(TracerError::Failed(format!(
                "{} materials for {} triangles",
                triangle_materials.len(),
                triangles.len()
            )));
        }
        if triangles.is_empty() || positions.is_empty() {
            return Err(TracerError::Failed("the scene has no triangles".to_owned()));
        }
        let (bounds_min, bounds_max) = bounds(&positions);
        let device = match gpu {
            None => Err(TracerError::Unavailable("the scene is not on a device".to_owned())),
            Some(gpu) => DeviceGeometry::upload(gpu, &positions, &triangles, &triangle_materials),
        };
        let (positions, triangles) = (Arc::new(positions), Arc::new(triangles));
        let triangle_materials = Arc::new(triangle_materials);
        Ok(Self { positions, triangles, triangle_materials, bounds_min, bounds_max, device })
    }

    /// The same triangles with their vertices moved, on the device in the buffers that are there. The device buffers of
    /// clones taken before are these, so such clones serve host tracers alone from now on.
    ///
    /// # Errors
    /// [`TracerError::Failed`] for another number of vertices.
    pub fn moved_to(self, positions: Vec<[f32; 3]>, gpu: Option<&Gpu>) -> Result<Self, TracerError> {
        if positions.len() != self.positions.len() {
            return Err(TracerError::Failed(format!(
                "a scene of {} vertices cannot move to {} positions",
                self.positions.len(),
                positions.len()
            )));
        }
        if let (Ok(device), Some(gpu)) = (&self.device, gpu) {
            gpu.queue.write_buffer(&device.positions, 0, bytemuck::cast_slice(&positions));
            gpu.check()?;
        }
        let (bounds_min, bounds_max) = bounds(&positions);
        Ok(Self { positions: Arc::new(positions), bounds_min, bounds_max, ..self })
    }

    /// The device copy.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] if the scene was loaded without a device, [`TracerError::TooLarge`] if the device
    /// cannot hold it.
    pub fn on_device(&self) -> Result<&DeviceGeometry, TracerError> {
        self.device.as_ref().map_err(Clone::clone)
    }

    /// The corners of one triangle.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| Vec3::from(self.positions[vertex as usize]))
    }

    /// Length of the bounds' diagonal, scene units.
    pub fn diagonal(&self) -> f64 {
        (self.bounds_max.as_dvec3() - self.bounds_min.as_dvec3()).length()
    }

    /// The farthest that any corner of the bounds lies from a point, scene units.
    pub fn farthest_corner(&self, point: Vec3) -> f64 {
        let low = (point.as_dvec3() - self.bounds_min.as_dvec3()).abs();
        let high = (self.bounds_max.as_dvec3() - point.as_dvec3()).abs();
        DVec3::max(low, high).length()
    }

    /// Bytes of positions and indices.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.positions.as_slice()) as u64 + size_of_val(self.triangles.as_slice()) as u64
    }

    /// Bytes of positions, indices and materials: what surfaces are made of.
    pub fn surface_bytes(&self) -> u64 {
        self.bytes() + size_of_val(self.triangle_materials.as_slice()) as u64
    }
}

fn bounds(positions: &[[f32; 3]]) -> (Vec3, Vec3) {
    let around = |(low, high): (Vec3, Vec3), position: &[f32; 3]| {
        (low.min(Vec3::from(*position)), high.max(Vec3::from(*position)))
    };
    positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), around)
}

impl DeviceGeometry {
    fn upload(
        gpu: &Gpu,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        triangle_materials: &[u32],
    ) -> Result<Self, TracerError> {
        let for_building = if gpu.has_ray_queries() { BufferUsages::BLAS_INPUT } else { BufferUsages::empty() };
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | for_building;
        let positions = gpu.buffer_with(
            "vertex positions",
            bytemuck::cast_slice(positions),
            usage | BufferUsages::VERTEX,
            "the scene's triangle count",
        )?;
        let indices = gpu.buffer_with(
            "vertex indices",
            bytemuck::cast_slice(triangles),
            usage | BufferUsages::INDEX,
            "the scene's triangle count",
        )?;
        let materials = gpu.buffer_with(
            "triangle materials",
            bytemuck::cast_slice(triangle_materials),
            BufferUsages::STORAGE,
            "the scene's triangle count",
        )?;
        Ok(Self { positions, indices, materials })
    }
}
