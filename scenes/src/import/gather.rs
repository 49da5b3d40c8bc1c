//! From placed primitives to one mesh in world space.

use super::degenerate::has_zero_area;
use super::form::Form;
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
    /// Vertices of a skin without any weight.
    pub(super) weightless: u64,
    /// For each position the vertex of its primitive that it was computed from, if that is asked for.
    pub(super) sources: Option<Vec<u32>>,
    /// Whether all parts have the vertices of one accessor, which are kept as they stand ([`super::SHARED_VERTICES`]), and how many at most.
    shared: Option<usize>,
    /// For each vertex of the part at hand: the pass in which it was last kept (high half) and its new index.
    kept: Vec<u64>,
    pass: u32,
}

impl Gathered {
    /// Room for `triangles` triangles.
    pub(super) fn new(triangles: usize, keep_sources: bool, shared: bool) -> Self {
        Self {
            shared: (shared && !keep_sources).then(|| triangles.saturating_mul(3)),
            sources: keep_sources.then(Vec::new),
            triangles: Vec::with_capacity(triangles),
            triangle_materials: Vec::with_capacity(triangles),
            triangle_objects: Vec::with_capacity(triangles),
            ..Self::default()
        }
    }

    /// Adds `part` in the pose of `form`, with `material` and `object` (indices into the scene's). Only vertices of kept
    /// triangles are kept.
    pub(super) fn add(&mut self, part: &Part, form: &Form<'_>, material: u32, object: u32) -> Result<(), String> {
        if self.shared.is_none() && self.kept.len() < part.vertices {
            // Fresh zeroed memory instead of growth: pages that no index touches are never mapped.
            self.kept = vec![0; part.vertices];
            self.pass = 0;
        }
        // No scene has 2^32 primitives in its nodes, so the pass number does not wrap.
        self.pass += 1;
        if let Some(most) = self.shared {
            let all = part.positions.count();
            if self.positions.is_empty() && all <= most {
                self.positions = (0..all as u32).map(|vertex| form.stored(vertex)).collect::<Result<_, _>>()?;
            }
            if all != self.positions.len() {
                let (label, name) = (&part.label, super::SHARED_VERTICES);
                return Err(format!("{label}: with {name} all primitives have one POSITION, of vertices in triangles"));
            }
        }
        let mirrored = form.is_mirrored();
        for at in 0..part.triangles {
            let mut corners = part.corners(at);
            if mirrored && self.shared.is_none() {
                corners.swap(1, 2);
            }
            let mut points = [[0.0f32; 3]; 3];
            for (point, corner) in points.iter_mut().zip(corners) {
                *point = match self.known(corner) {
                    Some(index) => self.positions[index as usize],
                    None => form.point(corner)?,
                };
            }
            // What moves may have an area at another time.
            if self.sources.is_none() && has_zero_area(&points) {
                self.zero_area += 1;
                continue;
            }
            let triangle = [0, 1, 2].map(|slot| self.vertex(form, corners[slot], points[slot]));
            self.triangles.push(triangle);
            self.triangle_materials.push(material);
            self.triangle_objects.push(object);
        }
        Ok(())
    }

    /// The index of a vertex of the part at hand that was kept before.
    fn known(&self, corner: u32) -> Option<u32> {
        if self.shared.is_some() {
            return Some(corner);
        }
        let slot = self.kept[corner as usize];
        ((slot >> 32) as u32 == self.pass).then_some(slot as u32)
    }

    fn vertex(&mut self, form: &Form<'_>, corner: u32, point: [f32; 3]) -> u32 {
        if let Some(index) = self.known(corner) {
            return index;
        }
        // At most three vertices a triangle, and the number of triangles is bounded far below 2^30.
        let index = self.positions.len() as u32;
        self.kept[corner as usize] = (u64::from(self.pass) << 32) | u64::from(index);
        self.positions.push(point);
        self.weightless += u64::from(form.is_weightless(corner));
        if let Some(sources) = &mut self.sources {
            sources.push(corner);
        }
        index
    }
}
