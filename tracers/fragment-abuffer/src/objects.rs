//! Objects, whose bounding boxes stand for them in the depth bounds stage (VVP16, section 3.3).

use std::sync::{Arc, Weak};

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Geometry, Gpu, Ledger, TracerError};
use tracebench_kit::LastCount;

const OBJECTS: &str = "objects of triangles";
const BOXES: &str = "object boxes";

/// Bytes of a box: six floats as ordered numbers.
const BOX_BYTES: u64 = 24;

/// A scene's triangles by object: those that are joined by vertices are one. The paper's objects are the application's, of which
/// triangles alone tell nothing else.
pub(crate) fn objects_of(vertices: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, u32) {
    let mut parent: Vec<u32> = (0..vertices as u32).collect();
    fn root(parent: &mut [u32], vertex: u32) -> u32 {
        let mut at = vertex;
        while parent[at as usize] != at {
            parent[at as usize] = parent[parent[at as usize] as usize];
            at = parent[at as usize];
        }
        at
    }
    for [a, b, c] in triangles {
        let first = root(&mut parent, *a);
        for other in [*b, *c] {
            let other = root(&mut parent, other);
            parent[other as usize] = first;
        }
    }
    let mut number_of = vec![u32::MAX; vertices];
    let mut count = 0;
    let mut number = |corner: u32| {
        let root = root(&mut parent, corner) as usize;
        if number_of[root] == u32::MAX {
            number_of[root] = count;
            count += 1;
        }
        number_of[root]
    };
    let numbers = triangles.iter().map(|triangle| number(triangle[0])).collect();
    (numbers, count)
}

/// The last scene's objects, for builds that follow.
pub(crate) type LastObjects = LastCount<(), Arc<(Vec<u32>, u32)>>;

/// Objects on the device.
#[derive(Debug)]
pub(crate) struct Objects {
    /// The object of every triangle.
    pub of_triangles: Buffer,
    /// The boxes, made by every build.
    pub boxes: Buffer,
    pub count: u32,
    /// The triangles that they are of, while these are there.
    triangles: Weak<Vec<[u32; 3]>>,
}

impl Objects {
    pub(crate) fn new(gpu: &Gpu, geometry: &Geometry, last: &LastObjects) -> Result<Self, TracerError> {
        let found =
            last.of(geometry, (), || Ok(Arc::new(objects_of(geometry.positions.len(), &geometry.triangles))))?;
        let (numbers, count) = &*found;
        let turn_down = "the scene's triangle count";
        let (numbers, bytes) = (bytemuck::cast_slice(numbers), u64::from(*count).max(1) * BOX_BYTES);
        gpu.check_storage_binding(OBJECTS, size_of_val(numbers) as u64, turn_down)?;
        gpu.check_storage_binding(BOXES, bytes, turn_down)?;
        Ok(Self {
            of_triangles: gpu.buffer_with(OBJECTS, numbers, BufferUsages::STORAGE, turn_down)?,
            boxes: gpu.buffer(BOXES, bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST, turn_down)?,
            count: *count,
            triangles: Arc::downgrade(&geometry.triangles),
        })
    }

    /// Whether they are those of a scene's triangles.
    pub(crate) fn are_of(&self, geometry: &Geometry) -> bool {
        self.triangles.upgrade().is_some_and(|triangles| Arc::ptr_eq(&triangles, &geometry.triangles))
    }

    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        for (name, buffer) in [(OBJECTS, &self.of_triangles), (BOXES, &self.boxes)] {
            ledger.keep(name, buffer.size(), buffer.size());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles with common vertices are one object, over any number of steps and in any order; others are not.
    #[test]
    fn objects_are_what_vertices_join() {
        let triangles = [[0, 1, 2], [6, 7, 8], [4, 3, 5], [2, 3, 9], [8, 10, 11], [12, 12, 12]];
        let (objects, count) = objects_of(13, &triangles);
        assert_eq!((objects.as_slice(), count), ([0, 1, 0, 0, 1, 2].as_slice(), 3));
        assert_eq!(objects_of(0, &[]), (Vec::new(), 0));
    }
}
