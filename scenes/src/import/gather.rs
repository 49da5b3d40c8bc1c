//! From placed primitives to one mesh in world space.

use glam::{DMat4, DVec3};

use super::degenerate::has_zero_area;
use super::parts::Part;

/// Triangles as they are collected.
#[derive(Default)]
pub(super) struct Gathered {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) triangle_materials: Vec<u32>,
    pub(super) triangle_objects: Vec<u32>,
    /// Triangles of exactly zero area, which are not among `triangles`.
    pub(super) zero_area: u64,
    /// For each vertex of the part at hand: the pass in which it was last kept (high half) and its new index.
    kept: Vec<u64>,
    pass: u32,
}

impl Gathered {
    /// Room for `triangles` triangles.
    pub(super) fn with_capacity(triangles: usize) -> Self {
        Self {
            triangles: Vec::with_capacity(triangles),
            triangle_materials: Vec::with_capacity(triangles),
            triangle_objects: Vec::with_capacity(triangles),
            ..Self::default()
        }
    }

    /// Adds `part` under `world` with `material` and `object` (indices into the scene's).
    ///
    /// Positions are transformed in f64 and rounded to f32 once. Only vertices of kept triangles are kept.
    pub(super) fn add(&mut self, part: &Part<'_>, world: &DMat4, material: u32, object: u32) -> Result<(), String> {
        if self.kept.len() < part.vertices {
            // Fresh zeroed memory instead of growth: pages that no index touches are never mapped.
            self.kept = vec![0; part.vertices];
            self.pass = 0;
        }
        // No scene has 2^32 primitives in its nodes, so the pass number does not wrap.
        self.pass += 1;
        let mirrored = world.determinant() < 0.0;
        for at in 0..part.triangles {
            let mut corners = part.corners(at);
            if mirrored {
                corners.swap(1, 2);
            }
            let mut points = [[0.0f32; 3]; 3];
            for (point, corner) in points.iter_mut().zip(corners) {
                *point = place(part, world, corner)?;
            }
            if has_zero_area(&points) {
                self.zero_area += 1;
                continue;
            }
            let triangle = [0, 1, 2].map(|slot| self.vertex(corners[slot], points[slot]));
            self.triangles.push(triangle);
            self.triangle_materials.push(material);
            self.triangle_objects.push(object);
        }
        Ok(())
    }

    fn vertex(&mut self, corner: u32, point: [f32; 3]) -> u32 {
        let slot = &mut self.kept[corner as usize];
        if (*slot >> 32) as u32 == self.pass {
            return *slot as u32;
        }
        // At most three vertices a triangle, and the number of triangles is bounded far below 2^30.
        let index = self.positions.len() as u32;
        *slot = (u64::from(self.pass) << 32) | u64::from(index);
        self.positions.push(point);
        index
    }
}

fn place(part: &Part<'_>, world: &DMat4, corner: u32) -> Result<[f32; 3], String> {
    let own = DVec3::from_array(part.positions.position(corner as usize));
    let point = world.transform_point3(own);
    let largest = point.abs().max_element();
    if point.is_finite() && largest <= super::MAX_COORDINATE {
        return Ok(point.as_vec3().to_array());
    }
    let label = &part.label;
    Err(if !own.is_finite() {
        format!("{label} vertex {corner} is at {own}, which is not finite: repair the mesh and export it again")
    } else if !point.is_finite() {
        format!(
            "{label} vertex {corner} is at {point} after its node's transform, which is not finite: repair the transform"
        )
    } else {
        format!(
            "{label} vertex {corner} is at {point}, and coordinates beyond {:e} are refused because products of lengths overflow f32: scale the scene down",
            super::MAX_COORDINATE
        )
    })
}
