//! Reading a packed structure back: order, trees and pyramid against themselves, and what is stored against f64.
//!
//! What is stored must lie between what f64 finds for tiles grown by half of their margin, which is what a search relies on, and for
//! tiles grown by all of it and twice what rounding may do. Of large scenes every n-th triangle is looked at.

use std::collections::HashSet;

use tracebench_api::glam::DVec3;
use tracebench_api::{Geometry, TracerError};

use super::PackedStructure;
use super::layout::{FACES, FIRST_NEAR, first_leaf, node_count};
use super::parts::{
    BOX_MARGIN, BOX_STEP, Bounds, COUNT_MARGIN, MIN_DEPTH, TILE_MARGIN, bounds, in_face, part, place_loss, size_of,
    to_face,
};
use crate::description::Lists;

/// Parts of triangles that are compared with f64, about.
const COMPARED_PARTS: u64 = 50_000;

/// Words of a node, six pairs: bytes of eight children.
type Node = [u32; 12];

/// A structure in host memory.
pub(super) struct ReadBack {
    /// First reference, references, first node or list, scale of depths.
    tiles: Vec<[u32; 4]>,
    masks: Vec<u64>,
    words: Vec<u32>,
    nodes: Vec<Node>,
    lists: Vec<u32>,
    triangle_count: u32,
}

fn wrong(what: String) -> TracerError {
    TracerError::Failed(what)
}

/// The byte of a child in one of a node's pairs of words.
fn byte(node: &Node, pair: usize, child: usize) -> u32 {
    node[2 * pair + child / 4] >> (8 * (child % 4)) & 0xff
}

/// The box of a child: least and greatest along x, y, and the codes of w; nothing for a child that is none.
fn child_box(node: &Node, child: usize) -> Option<[[u32; 2]; 3]> {
    let axes = [0, 1, 2].map(|axis| [byte(node, 2 * axis, child), byte(node, 2 * axis + 1, child)]);
    axes.iter().all(|[low, high]| low <= high).then_some(axes)
}

impl ReadBack {
    /// The references of a tile.
    fn references(&self, tile: u32) -> &[u32] {
        let [first, count, ..] = self.tiles[tile as usize];
        let begin = (FIRST_NEAR + self.triangle_count + first) as usize;
        &self.words[begin..begin + count as usize]
    }

    /// The w of a code of a tile.
    fn depth(&self, tile: u32, code: u32) -> f64 {
        let scale = self.tiles[tile as usize][3];
        f64::from(f32::from_bits((scale & 0xffff_0000) + code * ((scale & 0xffff) << 7)))
    }

    /// The leaf box of a reference of a tile in (x, y, w), by its place.
    fn leaf_box(&self, tile: u32, edge: u32, place: usize) -> Option<Bounds> {
        let [_, count, first, _] = self.tiles[tile as usize];
        let node = &self.nodes[(first + first_leaf(count)) as usize + place / 8];
        let [x, y, w] = child_box(node, place % 8)?;
        let at = |tile: u32, code: u32| f64::from(tile) - BOX_MARGIN + f64::from(code) * BOX_STEP;
        let (across, up) = (tile % edge, tile / edge % edge);
        let corner = |end: usize| DVec3::new(at(across, x[end]), at(up, y[end]), self.depth(tile, w[end]));
        Some(Bounds { low: corner(0), high: corner(1) })
    }

    /// The depth slice of a w: as `slice_of` in shaders/dirt/packed_grid.wgsl.
    fn slice(&self, w: f64, slices: u32) -> u32 {
        let (base, rate) = (self.words[4], f32::from_bits(self.words[5]));
        let bits = (w as f32).to_bits().max(base) - base;
        ((bits as f32 * rate) as u32).min(slices - 1)
    }

    /// The references of a slice's list, of a tile with this mask.
    fn listed(&self, tile: u32, mask: u64, slice: u32) -> &[u32] {
        if mask >> slice & 1 == 0 {
            return &[];
        }
        let [first, count, list, _] = self.tiles[tile as usize];
        let rank = (mask & ((1 << slice) - 1)).count_ones();
        let begin = self.lists[(list + rank) as usize];
        let is_last = rank + 1 == mask.count_ones();
        let end = if is_last { first + count } else { self.lists[(list + rank) as usize + 1] };
        let head = FIRST_NEAR + self.triangle_count;
        self.words.get((head + begin) as usize..(head + end) as usize).unwrap_or_default()
    }
}

impl PackedStructure {
    pub(super) fn read_back(&self) -> Result<ReadBack, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let needed = self.buffers.needed(gpu)?;
        if let Some((need, room)) = needed.iter().zip(&self.buffers.capacities).find(|(need, room)| need > room) {
            return Err(wrong(format!("{need} parts or nodes were needed, there is room for {room}")));
        }
        let words = |room: &tracebench_kit::GrowableBuffer| -> Result<Vec<u32>, TracerError> {
            Ok(bytemuck::pod_collect_to_vec(&gpu.read(&room.buffer, room.used_bytes)?))
        };
        let quads = words(&self.buffers.quads)?;
        let masks = words(&self.buffers.masks)?;
        let tile_words = &quads[..self.layout.tile_count() as usize * 4];
        let cells = (FACES * self.layout.cells()) as usize;
        let nodes = words(&self.buffers.nodes)?;
        let trees = self.layout.lists == Lists::Trees;
        Ok(ReadBack {
            tiles: tile_words.chunks_exact(4).map(|tile| [tile[0], tile[1], tile[2], tile[3]]).collect(),
            masks: masks[..2 * cells]
                .chunks_exact(2)
                .map(|pair| u64::from(pair[0]) | u64::from(pair[1]) << 32)
                .collect(),
            words: words(&self.buffers.words)?,
            nodes: if trees { bytemuck::pod_collect_to_vec::<u32, Node>(&nodes) } else { Vec::new() },
            lists: if trees { Vec::new() } else { nodes },
            triangle_count: self.buffers.triangle_count,
        })
    }

    pub(super) fn check(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let read = self.read_back()?;
        self.check_order(&read)?;
        self.check_masks(&read)?;
        match self.layout.lists {
            Lists::Trees => self.check_trees(&read)?,
            Lists::Slices => self.check_lists(&read)?,
            Lists::Packed | Lists::Linked => {}
        }
        let references: u64 = read.tiles.iter().map(|tile| u64::from(tile[1])).sum();
        self.compare(geometry, &read, (references / COMPARED_PARTS).max(1) as u32)?;
        let occupied = read.tiles.iter().filter(|tile| tile[1] > 0);
        let nodes: u64 = match self.layout.lists {
            Lists::Trees => read.tiles.iter().map(|tile| u64::from(node_count(tile[1]))).sum(),
            Lists::Slices | Lists::Packed | Lists::Linked => 0,
        };
        Ok(vec![
            ("references", references as f64),
            ("nodes", nodes as f64),
            ("occupied_tiles", occupied.clone().count() as f64),
            ("longest_list", occupied.map(|tile| tile[1]).max().unwrap_or(0).into()),
            ("triangles_near_the_eye", read.words[2].into()),
        ])
    }

    /// References of tiles lie one behind the other, are of triangles that there are, and none twice in a tile without slices.
    fn check_order(&self, read: &ReadBack) -> Result<(), TracerError> {
        let mut end = None;
        for (number, [first, count, ..]) in read.tiles.iter().enumerate().filter(|(_, tile)| tile[1] > 0) {
            if end.is_some_and(|end| end != *first) {
                return Err(wrong(format!(
                    "the references of tile {number} begin at {first}, those before end elsewhere"
                )));
            }
            end = Some(first + count);
            let references = read.references(number as u32);
            if let Some(unknown) = references.iter().find(|triangle| **triangle >= read.triangle_count) {
                return Err(wrong(format!("tile {number} has triangle {unknown}, there are {}", read.triangle_count)));
            }
            let different: HashSet<u32> = references.iter().copied().collect();
            if self.layout.lists != Lists::Slices && different.len() < references.len() {
                return Err(wrong(format!("tile {number} has a triangle twice")));
            }
        }
        Ok(())
    }

    /// A cell of the pyramid has what the four below it have, a tile something where it has references.
    fn check_masks(&self, read: &ReadBack) -> Result<(), TracerError> {
        let (layout, cells) = (&self.layout, self.layout.cells() as usize);
        for face in 0..FACES as usize {
            let of_face = &read.masks[face * cells..(face + 1) * cells];
            for level in 1..layout.levels() {
                let (edge, below_edge) = (layout.level_edge(level), layout.level_edge(level - 1));
                let below = &of_face[layout.level_offset(level - 1) as usize..];
                for (x, y) in (0..edge).flat_map(|y| (0..edge).map(move |x| (x, y))) {
                    let mut expected = 0;
                    for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| (2 * x + i, 2 * y + j)) {
                        if i < below_edge && j < below_edge {
                            expected |= below[(j * below_edge + i) as usize];
                        }
                    }
                    if of_face[(layout.level_offset(level) + y * edge + x) as usize] != expected {
                        return Err(wrong(format!(
                            "the pyramid of masks is wrong: face {face}, level {level}, {x}, {y}"
                        )));
                    }
                }
            }
            let tiles = (layout.tiles * layout.tiles) as usize;
            for (within, mask) in of_face[..tiles].iter().enumerate() {
                let count = read.tiles[face * tiles + within][1];
                if (count == 0) != (*mask == 0) {
                    return Err(wrong(format!(
                        "tile {within} of face {face} has {count} references and mask {mask:x}"
                    )));
                }
            }
        }
        Ok(())
    }

    /// The lists of a tile's slices begin one behind the other within its references, the first with these.
    fn check_lists(&self, read: &ReadBack) -> Result<(), TracerError> {
        for (number, [first, count, list, _]) in read.tiles.iter().enumerate().filter(|(_, tile)| tile[1] > 0) {
            let lists = self.mask_of(read, number as u32).count_ones() as usize;
            let begins = &read.lists[*list as usize..][..lists];
            let ascend = begins.windows(2).all(|pair| pair[0] < pair[1]);
            if begins[0] != *first || !ascend || begins[lists - 1] >= first + count {
                return Err(wrong(format!("the lists of tile {number} begin at {begins:?}")));
            }
        }
        Ok(())
    }

    /// A node's box of a child holds all boxes of that child; the last nodes have a box for each part.
    fn check_trees(&self, read: &ReadBack) -> Result<(), TracerError> {
        let mut next = 0;
        for (number, [_, count, first, _]) in read.tiles.iter().enumerate() {
            let (leaf, nodes) = (first_leaf(*count), node_count(*count));
            if *count > 0 && *first != next {
                return Err(wrong(format!("the nodes of tile {number} begin at {first}, not at {next}")));
            }
            next += nodes;
            let of_tile = &read.nodes[*first as usize..(*first + nodes) as usize];
            for (index, node) in of_tile.iter().enumerate() {
                for child in 0..8 {
                    let held = child_box(node, child);
                    if index as u32 >= leaf {
                        let place = 8 * (index as u32 - leaf) + child as u32;
                        if held.is_some() != (place < *count) {
                            return Err(wrong(format!(
                                "part {place} of {count} of tile {number} has the box {held:?}"
                            )));
                        }
                        continue;
                    }
                    let below = of_tile.get(8 * index + 1 + child);
                    for inner in below.iter().flat_map(|below| (0..8).filter_map(move |child| child_box(below, child)))
                    {
                        let inside = |held: [[u32; 2]; 3]| {
                            held.iter().zip(inner).all(|(held, inner)| held[0] <= inner[0] && inner[1] <= held[1])
                        };
                        if !held.is_some_and(inside) {
                            return Err(wrong(format!(
                                "node {index} of tile {number} does not hold its child {child}"
                            )));
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Where every `step`-th triangle is stored: triangle, tile, place among the tile's references; in order, each tile once.
    fn stored(&self, read: &ReadBack, step: u32) -> Vec<(u32, u32, usize)> {
        let mut stored = Vec::new();
        for tile in 0..self.layout.tile_count() {
            let references = read.references(tile).iter().enumerate();
            stored.extend(references.filter(|(_, at)| *at % step == 0).map(|(place, at)| (*at, tile, place)));
        }
        stored.sort_unstable();
        stored.dedup_by_key(|(primitive, tile, _)| (*primitive, *tile));
        stored
    }

    /// The stored parts of every `step`-th triangle against f64.
    fn compare(&self, geometry: &Geometry, read: &ReadBack, step: u32) -> Result<(), TracerError> {
        let eye = self.layout.viewpoint.eye.as_dvec3();
        let listed: HashSet<u32> =
            read.words[FIRST_NEAR as usize..][..read.words[2] as usize].iter().copied().collect();
        let cube = f64::from(f32::from_bits(read.words[3]));
        let stored = self.stored(read, step);
        let of_face = self.layout.tiles * self.layout.tiles;
        for primitive in (0..geometry.triangles.len() as u32).step_by(step as usize) {
            let corners = geometry.corners(primitive).map(|corner| corner.as_dvec3() - eye);
            let size = size_of(&corners);
            if size == 0.0 {
                continue;
            }
            for face in 0..FACES {
                let seen = corners.map(|corner| to_face(face, corner));
                let nearest = in_face(&seen, 0.0, 0.0).iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
                if nearest < MIN_DEPTH * size && !(listed.contains(&primitive) && cube >= MIN_DEPTH * size) {
                    return Err(wrong(format!("triangle {primitive} comes as near as {nearest} and is not listed")));
                }
                let begin = stored.partition_point(|each| (each.0, each.1) < (primitive, face * of_face));
                let end = stored.partition_point(|each| (each.0, each.1) < (primitive, (face + 1) * of_face));
                self.compare_in_face(read, primitive, face, &seen, &stored[begin..end])?;
            }
        }
        Ok(())
    }

    /// Those of a triangle in a face.
    fn compare_in_face(
        &self,
        read: &ReadBack,
        primitive: u32,
        face: u32,
        seen: &[DVec3; 3],
        stored: &[(u32, u32, usize)],
    ) -> Result<(), TracerError> {
        let (edge, size) = (self.layout.tiles, size_of(seen));
        // What is stored, at least; and at most.
        let least = in_face(seen, MIN_DEPTH * size * (1.0 + 1.0 / 128.0), 0.0);
        let most = in_face(seen, MIN_DEPTH * size * (1.0 - 1.0 / 64.0), 1.0);
        let depth = most.iter().map(|point| point.z).fold(size, f64::min);
        let margin = TILE_MARGIN + 2.0 * (place_loss(size, depth, edge) + COUNT_MARGIN);
        let place = |tile: u32| format!("triangle {primitive} in tile {tile} of {edge} by {edge} by 6");
        let at = |tile: u32| [tile % edge, tile / edge % edge];
        for (_, tile, _) in stored {
            if part(&most, edge, at(*tile), margin).is_none() {
                return Err(wrong(format!("{} is stored and does not touch it", place(*tile))));
            }
        }
        let Some(all) = bounds(&least, edge) else { return Ok(()) };
        let last = f64::from(edge) - 1.0;
        let [low, high] = [all.low - TILE_MARGIN, all.high + TILE_MARGIN]
            .map(|end| [end.x, end.y].map(|end| end.floor().clamp(0.0, last) as u32));
        for (x, y) in (low[1]..=high[1]).flat_map(|y| (low[0]..=high[0]).map(move |x| (x, y))) {
            let tile = (face * edge + y) * edge + x;
            let Some(must) = part(&least, edge, [x, y], 0.5 * TILE_MARGIN) else { continue };
            let Ok(found) = stored.binary_search_by_key(&tile, |(_, tile, _)| *tile) else {
                return Err(wrong(format!("{} is not stored", place(tile))));
            };
            let mask = self.mask_of(read, tile);
            let [first, last] = [must.low.z, must.high.z].map(|w| read.slice(w, self.layout.slices));
            if (first..=last).any(|slice| mask >> slice & 1 == 0) {
                return Err(wrong(format!("{} lies in slices {first} to {last}, the mask is {mask:x}", place(tile))));
            }
            let missing = |slice| !read.listed(tile, mask, slice).contains(&primitive);
            match self.layout.lists {
                Lists::Trees if !is_held(read.leaf_box(tile, edge, stored[found].2), must, [x, y]) => {
                    return Err(wrong(format!("{} reaches beyond its box: {must:?}", place(tile))));
                }
                Lists::Slices if (first..=last).any(missing) => {
                    return Err(wrong(format!("{} is missing from one of slices {first} to {last}", place(tile))));
                }
                Lists::Trees | Lists::Slices | Lists::Packed | Lists::Linked => {}
            }
        }
        Ok(())
    }

    /// The mask of a tile.
    fn mask_of(&self, read: &ReadBack, tile: u32) -> u64 {
        let of_face = self.layout.tiles * self.layout.tiles;
        read.masks[(tile / of_face * self.layout.cells() + tile % of_face) as usize]
    }
}

/// Whether a box holds what it must in a tile. Beyond the grid of the tile's boxes no ray of the tile goes.
fn is_held(held: Option<Bounds>, must: Bounds, tile: [u32; 2]) -> bool {
    let Some(held) = held else { return false };
    let across = [0, 1].into_iter().all(|axis| {
        let begin = f64::from(tile[axis]) - BOX_MARGIN;
        let low = must.low[axis].max(begin);
        let high = must.high[axis].min(begin + 255.0 * BOX_STEP);
        held.low[axis] <= low + 1e-6 && held.high[axis] >= high - 1e-6
    });
    across && held.low.z <= must.low.z * (1.0 + 1e-9) && held.high.z >= must.high.z * (1.0 - 1e-9)
}
