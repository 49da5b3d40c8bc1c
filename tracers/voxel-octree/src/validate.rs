//! The tree read back: its pointers followed, its leaves held against voxels that are found on the host in f64.

use std::collections::BTreeMap;

use tracebench_api::glam::DVec3;
use tracebench_api::{Geometry, TracerError};

use crate::counts::Taken;
use crate::reference::{CellPosition, MIN_LENGTH, Triangle, voxels_of};
use crate::structure::OctreeStructure;

/// Leaves that are held against triangles at most: those of every n-th part of the cube.
const MAX_COMPARED: u32 = 1 << 17;

/// Levels of such a part.
const PART_LEVELS: u32 = 3;

/// Length by which an average of normals may be off that are each rounded, over the average's own.
const NORMAL_SLACK: f64 = 1e-4;

fn fail<T>(what: String) -> Result<T, TracerError> {
    Err(TracerError::Failed(what))
}

/// A tree as it lies in memory.
#[derive(Clone, Debug)]
pub(crate) struct Stored {
    /// Numbers of nodes by depth, and of leaves at the end.
    pub counts: Vec<u32>,
    /// Where nodes of every depth begin.
    pub firsts: Vec<u32>,
    /// First child and parts.
    pub nodes: Vec<[u32; 2]>,
    /// Normal and material.
    pub leaves: Vec<[u32; 2]>,
}

impl Stored {
    /// The keys of all leaves, in order, as the nodes have them.
    pub(crate) fn keys(&self) -> Result<Vec<u32>, TracerError> {
        let levels = self.counts.len() - 1;
        let mut keys = vec![0_u32];
        for depth in 0..levels {
            let mut below = Vec::with_capacity(self.counts[depth + 1] as usize);
            let first_child = if depth + 1 == levels { 0 } else { self.firsts[depth + 1] };
            for (index, key) in keys.iter().enumerate() {
                let [child, parts] = self.nodes[self.firsts[depth] as usize + index];
                if (parts == 0 && self.counts[levels] > 0) || parts > 0xff {
                    return fail(format!("node {index} of depth {depth} has the parts {parts:#b}"));
                }
                if parts != 0 && child as usize != first_child as usize + below.len() {
                    return fail(format!("node {index} of depth {depth} has its children at {child}"));
                }
                below.extend((0..8).filter(|part| parts >> part & 1 == 1).map(|part| key << 3 | part));
            }
            if below.len() != self.counts[depth + 1] as usize {
                return fail(format!("{} of {} at depth {}", below.len(), self.counts[depth + 1], depth + 1));
            }
            keys = below;
        }
        Ok(keys)
    }
}

/// The normal of a leaf: `unpacked_normal` of shaders/voxel-octree/normal.wgsl.
pub(crate) fn unpacked_normal(word: u32) -> DVec3 {
    let [x, y] = [word, word >> 16].map(|half| (f64::from(half as i16) / 32_767.0).max(-1.0));
    let z = 1.0 - x.abs() - y.abs();
    let folded = |along: f64, other: f64| (1.0 - other.abs()).copysign(along);
    let normal = if z < 0.0 { DVec3::new(folded(x, y), folded(y, x), z) } else { DVec3::new(x, y, z) };
    normal.normalize_or_zero()
}

impl OctreeStructure {
    /// The tree as it lies on the device.
    pub(crate) fn read(&self) -> Result<Stored, TracerError> {
        let (gpu, levels, room) = (&self.kernels.gpu, self.layout.levels, &self.tree.room);
        let taken = Taken::read(gpu, &self.tree.taken)?;
        if !room.hold(&taken.counts(levels)?) {
            return fail(format!("{taken:?} with room for {room:?}"));
        }
        let [nodes, leaves] = [self.arrays[0].read(gpu)?, self.arrays[1].read(gpu)?];
        Ok(Stored {
            counts: (0..=levels).map(|depth| taken.of_depth(depth)).collect(),
            firsts: (0..levels).map(|depth| room.nodes_before(depth)).collect(),
            nodes: bytemuck::pod_collect_to_vec(&nodes),
            leaves: bytemuck::pod_collect_to_vec(&leaves),
        })
    }

    pub(crate) fn validate_against(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let stored = self.read()?;
        let compared = self.check(&stored, geometry)?;
        let (levels, taken) = (self.layout.levels, Taken::read(&self.kernels.gpu, &self.tree.taken)?);
        Ok(vec![
            ("levels", f64::from(levels)),
            ("nodes", stored.counts[..levels as usize].iter().copied().map(f64::from).sum()),
            ("leaves", f64::from(stored.counts[levels as usize])),
            ("rows", f64::from(taken.rows()?)),
            ("fragments", f64::from(taken.fragments()?)),
            ("compared_leaves", compared as f64),
        ])
    }

    /// Holds a tree against a scene; gives how many of its leaves.
    pub(crate) fn check(&self, stored: &Stored, geometry: &Geometry) -> Result<usize, TracerError> {
        let levels = self.layout.levels;
        let keys = stored.keys()?;
        // Parts of the cube are taken by what is no pattern of theirs, so that other places of a scene are seen than every n-th along the
        // curve.
        let part_levels = levels.saturating_sub(PART_LEVELS);
        let every = (keys.len() as u32).div_ceil(MAX_COMPARED).max(1);
        let is_part = |key: u32| (key.wrapping_mul(0x9e37_79b1) >> 8).is_multiple_of(every);
        let wanted = |place: CellPosition| place.depth != part_levels || is_part(place.key);
        let mut met: BTreeMap<u32, Vec<(u32, bool)>> = BTreeMap::new();
        let triangles: Vec<Triangle> =
            (0..geometry.triangles.len() as u32).map(|index| Triangle::of(&self.layout, geometry, index)).collect();
        for (primitive, triangle) in (0..).zip(&triangles) {
            voxels_of(triangle, levels, &wanted, CellPosition::ROOT, &mut |key, must| {
                met.entry(key).or_default().push((primitive, must));
            });
        }
        let leaf_of = |key: u32| keys.binary_search(&key).ok();
        for (key, within) in &met {
            match (leaf_of(*key), within.iter().find(|(_, must)| *must)) {
                (None, Some((primitive, _))) => {
                    return fail(format!("voxel {key:o} is not stored, triangle {primitive} touches it"));
                }
                (None, None) => {}
                (Some(leaf), _) => self
                    .check_leaf(stored.leaves[leaf], within, &triangles, geometry)
                    .map_err(|what| TracerError::Failed(format!("leaf {leaf}, voxel {key:o}: {what}")))?,
            }
        }
        let compared = keys.iter().filter(|key| is_part(**key >> (3 * (levels - part_levels))));
        let mut count = 0;
        for key in compared {
            if !met.contains_key(key) {
                return fail(format!("voxel {key:o} is stored, and no triangle touches it"));
            }
            count += 1;
        }
        Ok(count)
    }

    /// Holds a leaf against the triangles that may be in it and those that must.
    fn check_leaf(
        &self,
        leaf: [u32; 2],
        within: &[(u32, bool)],
        triangles: &[Triangle],
        geometry: &Geometry,
    ) -> Result<(), String> {
        let [word, material] = leaf;
        let normal = unpacked_normal(word);
        // The lowest is one of those before the first that must be there, or that itself.
        let first_must = within.iter().position(|(_, must)| *must).unwrap_or(within.len() - 1);
        let is_of = |(primitive, _): &(u32, bool)| geometry.triangle_materials[*primitive as usize] == material;
        if !within[..=first_must].iter().any(is_of) {
            return Err(format!("material {material} is none of its lowest triangles'"));
        }
        if within.iter().any(|(_, must)| !must) {
            return Ok(());
        }
        let count = within.len() as f64;
        let average = within.iter().map(|(primitive, _)| triangles[*primitive as usize].normal).sum::<DVec3>() / count;
        let length = average.abs().max_element();
        if (length - MIN_LENGTH).abs() < NORMAL_SLACK {
            return Ok(());
        }
        let expected = if length > MIN_LENGTH { average } else { triangles[within[0].0 as usize].normal };
        let off = (normal - expected.normalize_or_zero()).length();
        match off > NORMAL_SLACK / expected.length() * 4.0 {
            true => Err(format!("the normal {normal} instead of {}", expected.normalize_or_zero())),
            false => Ok(()),
        }
    }
}
