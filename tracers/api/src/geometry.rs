//! The triangles that a tracer builds from.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use wgpu::BufferUsages;

use crate::{Gpu, Hit, Surface, SurfaceStatus, TracerError};

/// Where [`Geometry::outer_light`] is, in diagonals from the middle of the bounds.
const OUTER_LIGHT: DVec3 = DVec3::new(0.35, 0.9, 0.25);

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
    pub fn with_positions(self, positions: Vec<[f32; 3]>, gpu: Option<&Gpu>) -> Result<Self, TracerError> {
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
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let [a, b, c] = self.triangles[triangle as usize];
        [self.positions[a as usize].into(), self.positions[b as usize].into(), self.positions[c as usize].into()]
    }

    /// The surface at barycentric weights of a triangle's second and third corner, as shaders/shared/surface.wgsl gives it;
    /// lost for a triangle that does not exist.
    pub fn surface(&self, triangle: u32, u: f32, v: f32) -> Surface {
        let Some(material) = self.triangle_materials.get(triangle as usize) else {
            return Surface::none(SurfaceStatus::Lost);
        };
        let [a, b, c] = self.corners(triangle);
        let (first, second) = (b - a, c - a);
        Surface {
            position: (a + first * u + second * v).into(),
            material: *material,
            normal: unit_normal(first, second).into(),
            status: SurfaceStatus::Written as u32,
        }
    }

    /// The surface of a hit: what every tracer on the host writes for it.
    pub fn surface_of(&self, hit: &Hit) -> Surface {
        if hit.is_hit() { self.surface(hit.primitive, hit.u, hit.v) } else { Surface::none(SurfaceStatus::NoHit) }
    }

    /// Length of the bounds' diagonal, scene units.
    pub fn diagonal(&self) -> f64 {
        (self.bounds_max.as_dvec3() - self.bounds_min.as_dvec3()).length()
    }

    /// The light outside of the bounds, where half of the `visibility` rays end: above, to the right, in front, as far from the middle
    /// of the bounds as they are wide. A tracer may prepare for it, as renderers draw shadow maps.
    pub fn outer_light(&self) -> DVec3 {
        (self.bounds_min.as_dvec3() + self.bounds_max.as_dvec3()) / 2.0 + OUTER_LIGHT * self.diagonal()
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

/// The unit normal of the plane that two edges span, 0 if they span none. Every vector is brought to a greatest component of
/// 1 first: squares of large scenes leave f32's range otherwise, and those of small ones vanish.
fn unit_normal(first: Vec3, second: Vec3) -> Vec3 {
    let scaled = |vector: Vec3| {
        let greatest = vector.abs().max_element();
        (greatest > 0.0).then(|| vector / greatest)
    };
    let normal = scaled(first).zip(scaled(second)).and_then(|(first, second)| scaled(first.cross(second)));
    normal.map_or(Vec3::ZERO, Vec3::normalize)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Surfaces lie where the weights say, have the normal of the winding at every scale, and the triangle's material; a
    /// triangle without an area has no normal, one that does not exist no surface.
    #[test]
    fn surfaces_are_those_of_the_triangle() {
        for scale in [1e-12_f32, 1.0, 1e12] {
            let at = |x: f32, y: f32, z: f32| [x * scale, y * scale, z * scale];
            let positions = vec![at(0.0, 0.0, 1.0), at(2.0, 0.0, 1.0), at(0.0, 4.0, 1.0), at(1.0, 0.0, 1.0)];
            let triangles = vec![[0, 1, 2], [2, 1, 0], [0, 1, 3]];
            let geometry = Geometry::with_materials(positions, triangles, vec![5, 6, 7], None).unwrap();
            let surface = geometry.surface(0, 0.25, 0.5);
            assert_eq!((surface.position, surface.material), (at(0.5, 2.0, 1.0), 5));
            assert_eq!((surface.normal, surface.status), ([0.0, 0.0, 1.0], SurfaceStatus::Written as u32));
            assert_eq!(
                (geometry.surface(1, 0.0, 0.0).normal, geometry.surface(1, 0.0, 0.0).material),
                ([0.0, 0.0, -1.0], 6)
            );
            assert_eq!(geometry.surface(2, 0.0, 0.0).normal, [0.0; 3]);
            assert_eq!(geometry.surface(3, 0.0, 0.0), Surface::none(SurfaceStatus::Lost));
        }
        assert!(Geometry::with_materials(vec![[0.0; 3]], vec![[0; 3]], Vec::new(), None).is_err());
    }
}
