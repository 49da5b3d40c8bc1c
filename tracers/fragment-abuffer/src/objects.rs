//! Objects, whose bounding boxes stand for them in the depth bounds stage (VVP16, section 3.3).

use tracebench_api::{Geometry, Gpu, Ledger, TracerError};
use tracebench_kit::GrowableBuffer;

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

/// Objects on the device.
#[derive(Debug)]
pub(crate) struct Objects {
    /// The object of every triangle.
    pub of_triangles: GrowableBuffer,
    /// The boxes, made by every build.
    pub boxes: GrowableBuffer,
    pub count: u32,
}

impl Objects {
    /// Found anew by every build, in the buffers of `there` where these are as large: shaders take the whole of them.
    pub(crate) fn new(gpu: &Gpu, geometry: &Geometry, there: Option<&Self>) -> Result<Self, TracerError> {
        let (numbers, count) = objects_of(geometry.positions.len(), &geometry.triangles);
        let numbers: &[u8] = bytemuck::cast_slice(&numbers);
        let room = |name, bytes, there: Option<&GrowableBuffer>| {
            let there = there.filter(|there| there.buffer.size() == bytes);
            GrowableBuffer::new(gpu, name, bytes, "the scene's triangle count", there)
        };
        let of_triangles = room(OBJECTS, numbers.len() as u64, there.map(|there| &there.of_triangles))?;
        let boxes = room(BOXES, u64::from(count).max(1) * BOX_BYTES, there.map(|there| &there.boxes))?;
        gpu.queue.write_buffer(&of_triangles.buffer, 0, numbers);
        Ok(Self { of_triangles, boxes, count })
    }

    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        [&self.of_triangles, &self.boxes].into_iter().for_each(|room| room.enter(ledger));
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
