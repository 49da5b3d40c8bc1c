//! The connected pieces of a mesh: triangles that hang together by vertices at the same place.

use std::collections::HashMap;

use tracebench_api::Geometry;

use super::Hierarchy;

/// One connected piece.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Its lowest triangle.
    pub first_triangle: u32,
    /// Its triangles.
    pub triangles: u64,
    /// Whether it has an edge that belongs to an odd number of its triangles: it bounds no inside then.
    pub open: bool,
    /// Its area, squared scene units.
    pub area: f64,
    /// The volume that it encloses, by its normals' signs; of open pieces nothing.
    pub volume: f64,
}

impl Piece {
    /// Mean thickness of what a closed piece encloses, scene units: twice its volume over its area, which is the thickness of a
    /// wall and two thirds of the radius of a ball. `None` of open ones.
    pub fn mean_thickness(&self) -> Option<f64> {
        (!self.open && self.area > 0.0).then(|| 2.0 * self.volume.abs() / self.area)
    }
}

/// The pieces of a scene, in the order of their lowest triangles.
pub struct Pieces {
    pieces: Vec<Piece>,
    of_triangle: Vec<u32>,
    /// Of every node of the hierarchy the least and the greatest piece in it.
    node_ranges: Vec<[u32; 2]>,
}

impl Pieces {
    pub(super) fn new(geometry: &Geometry, hierarchy: &Hierarchy) -> Self {
        let welded = weld(geometry);
        let corners = |triangle: &[u32; 3]| triangle.map(|vertex| welded[vertex as usize]);
        let mut parents: Vec<u32> = (0..geometry.positions.len() as u32).collect();
        for triangle in geometry.triangles.iter() {
            let [a, b, c] = corners(triangle);
            join(&mut parents, a, b);
            join(&mut parents, b, c);
        }
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        let mut pieces: Vec<Piece> = Vec::new();
        let mut of_triangle = Vec::with_capacity(geometry.triangles.len());
        // Volumes are summed about the middle of the bounds, for the sake of rounding.
        let middle = (geometry.bounds_min.as_dvec3() + geometry.bounds_max.as_dvec3()) / 2.0;
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * geometry.triangles.len());
        let mut seen: std::collections::HashSet<[u32; 3]> = std::collections::HashSet::new();
        for (index, triangle) in geometry.triangles.iter().enumerate() {
            let welded_corners = corners(triangle);
            let number = *numbers.entry(root(&mut parents, welded_corners[0])).or_insert(pieces.len() as u32);
            if number as usize == pieces.len() {
                pieces.push(Piece { first_triangle: index as u32, ..Piece::default() });
            }
            of_triangle.push(number);
            let piece = &mut pieces[number as usize];
            piece.triangles += 1;
            let [a, b, c] = geometry.corners(index as u32).map(|corner| corner.as_dvec3() - middle);
            piece.area += (b - a).cross(c - a).length() / 2.0;
            piece.volume += a.dot(b.cross(c)) / 6.0;
            let [a, b, c] = welded_corners;
            // A triangle that is there twice, facing the same way, is one.
            let least = a.min(b).min(c);
            let turned = if least == a {
                [a, b, c]
            } else if least == b {
                [b, c, a]
            } else {
                [c, a, b]
            };
            if a != b && b != c && c != a && seen.insert(turned) {
                edges.extend([[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)]));
            }
        }
        edges.sort_unstable();
        for same in edges.chunk_by(|one, other| one == other) {
            if same.len() % 2 == 1 {
                let number = numbers[&root(&mut parents, same[0][0])];
                pieces[number as usize].open = true;
            }
        }
        for piece in pieces.iter_mut().filter(|piece| piece.open) {
            piece.volume = 0.0;
        }
        let node_ranges = hierarchy.piece_ranges(&of_triangle);
        Self { pieces, of_triangle, node_ranges }
    }

    /// Every piece.
    pub fn all(&self) -> &[Piece] {
        &self.pieces
    }

    /// The piece that a triangle is of.
    #[inline]
    pub fn of_triangle(&self, triangle: u32) -> u32 {
        self.of_triangle[triangle as usize]
    }

    /// Whether a node of the hierarchy may hold a part of a piece.
    #[inline]
    pub(super) fn node_may_hold(&self, node: usize, piece: u32) -> bool {
        let [low, high] = self.node_ranges[node];
        (low..=high).contains(&piece)
    }
}

/// For every vertex the first at the same place.
fn weld(geometry: &Geometry) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(geometry.positions.len());
    let place = |position: &[f32; 3]| position.map(|part| (part + 0.0).to_bits());
    let numbered = geometry.positions.iter().enumerate();
    numbered.map(|(index, position)| *first.entry(place(position)).or_insert(index as u32)).collect()
}

fn root(parents: &mut [u32], vertex: u32) -> u32 {
    let mut at = vertex;
    while parents[at as usize] != at {
        // Halve the way for those who come later.
        parents[at as usize] = parents[parents[at as usize] as usize];
        at = parents[at as usize];
    }
    at
}

fn join(parents: &mut [u32], one: u32, other: u32) {
    let (one, other) = (root(parents, one), root(parents, other));
    parents[one.max(other) as usize] = one.min(other);
}
