//! Fragments that are oriented planes read back: lists followed and held against what the host clips in f64, and the voxels' marks
//! against both.

use tracebench_api::{Geometry, TracerError};

use crate::brute_force::UNIT_SLACK;
use crate::brute_planes::{AllowedPlane, AllowedPlanes, PlaneFragment, allowed_planes, part_margin};
use crate::buffers::Lists;
use crate::layout::{AXES, AXIS_NAMES, Layout, across_and_down};
use crate::structure::{VoxelStructure, check};

/// What following all lists tells.
#[derive(Default)]
struct Statistics {
    fragments: u64,
    covered: u64,
    most: usize,
    compared: u64,
}

/// An axis' lists, and which of their nodes have been met.
struct Followed<'a> {
    axis: usize,
    heads: &'a [u32],
    nodes: Vec<[u32; 2]>,
    data: Vec<[u32; 4]>,
    stored: u32,
    met: Vec<bool>,
}

fn fail<T>(what: String) -> Result<T, TracerError> {
    Err(TracerError::Failed(what))
}

impl Followed<'_> {
    /// The fragments of a texel; checks that they are in order, and in no other list.
    fn follow(&mut self, texel: u32) -> Result<Vec<PlaneFragment>, TracerError> {
        let (mut fragments, mut before) = (Vec::new(), 0);
        let mut link = self.heads[texel as usize];
        let name = AXIS_NAMES[self.axis];
        while link != 0 {
            let node = link - 1;
            if node >= self.stored || self.met[node as usize] {
                return fail(format!("axis {name}: node {node} of texel {texel} does not exist or lies in two lists"));
            }
            self.met[node as usize] = true;
            let [code, next] = self.nodes[node as usize];
            if code < before {
                return fail(format!("axis {name}: node {node} of texel {texel} is out of the order of depths"));
            }
            fragments.push(PlaneFragment::of(code, self.data[node as usize]));
            (before, link) = (code, next);
        }
        Ok(fragments)
    }
}

impl VoxelStructure {
    /// As [`VoxelStructure::validate_against`], of planes.
    pub(crate) fn validate_planes(
        &self,
        lists: &Lists,
        geometry: &Geometry,
        step: u32,
        codes: &[u32],
    ) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let (layout, gpu) = (&self.layout, &*self.pipelines.gpu);
        let taken = self.buffers.taken(gpu)?;
        check(&taken)?;
        let heads: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&lists.heads, lists.heads.size())?);
        let mut found = Statistics::default();
        let mut may = vec![0; codes.len()];
        for (axis, stored) in taken.fragments.into_iter().enumerate() {
            let capacity = lists.nodes.capacities[axis];
            if stored > capacity {
                return fail(format!("{stored} fragments along {} and room for {capacity}", AXIS_NAMES[axis]));
            }
            let [nodes, data] = self.nodes_of(lists, axis)?;
            let first = axis * layout.head_stride() as usize;
            let mut followed = Followed {
                axis,
                heads: &heads[first..first + layout.texels() as usize],
                nodes: bytemuck::pod_collect_to_vec(&nodes),
                data: bytemuck::pod_collect_to_vec(&data),
                stored,
                met: vec![false; stored as usize],
            };
            let allowed = allowed_planes(layout.space, geometry, axis, step);
            self.check_planes_along(&mut followed, &allowed, codes, &mut may, &mut found)?;
        }
        let stored: u64 = taken.fragments.iter().map(|count| u64::from(*count)).sum();
        if found.fragments != stored {
            return fail(format!("{} of {stored} fragments lie in lists", found.fragments));
        }
        if let Some(voxel) = codes.iter().zip(&may).position(|(code, may)| code & !may != 0) {
            return fail(format!(
                "voxel {voxel} is marked with axes {:#b}, and {:#b} show it",
                codes[voxel], may[voxel]
            ));
        }
        Ok(vec![
            ("fragments", stored as f64),
            ("covered_texels", found.covered as f64),
            ("average_layers", found.fragments as f64 / (found.covered as f64).max(1.0)),
            ("maximum_layers", found.most as f64),
            ("compared_texels", found.compared as f64),
        ])
    }

    fn check_planes_along(
        &self,
        followed: &mut Followed<'_>,
        allowed: &AllowedPlanes,
        codes: &[u32],
        may: &mut [u32],
        found: &mut Statistics,
    ) -> Result<(), TracerError> {
        let (layout, axis) = (&self.layout, followed.axis);
        let (image, bit) = (layout.image(), 1 << axis);
        let reach = (part_margin(image) + 0.1) / f64::from(image);
        for y in 0..image {
            for x in 0..image {
                let fragments = followed.follow(y * image + x)?;
                found.fragments += fragments.len() as u64;
                found.covered += u64::from(!fragments.is_empty());
                found.most = found.most.max(fragments.len());
                for fragment in &fragments {
                    let off = fragment.slopes.abs().element_sum() * 0.5 / f64::from(image) + reach;
                    let depths = [fragment.depth - off, fragment.depth + off];
                    voxels_of(layout, axis, [x, y], depths).for_each(|voxel| may[voxel] |= bit);
                }
                if x % allowed.step != 0 || y % allowed.step != 0 {
                    continue;
                }
                found.compared += 1;
                let context = |what| format!("axis {}, texel {x}, {y}: {what}", AXIS_NAMES[axis]);
                let allowed = allowed.of([x, y]);
                compare(&fragments, allowed).map_err(|what| TracerError::Failed(context(what)))?;
                for [least, greatest] in allowed.iter().filter_map(|each| each.lies) {
                    let mut lies = voxels_of(layout, axis, [x, y], [least + UNIT_SLACK, greatest - UNIT_SLACK]);
                    if let Some(voxel) = lies.find(|voxel| codes[*voxel] & bit == 0) {
                        return fail(context(format!("voxel {voxel} is not marked from {least} to {greatest}")));
                    }
                }
            }
        }
        Ok(())
    }
}

/// The voxels that a texel's square and a range of depths lie in; none of an empty range.
fn voxels_of(layout: &Layout, axis: usize, texel: [u32; 2], depths: [f64; 2]) -> impl Iterator<Item = usize> {
    let (image, grid) = (layout.image(), layout.space.grid);
    let aside = texel.map(|at| at * grid / image..=((at + 1) * grid - 1) / image);
    let layer = |depth: f64| (depth * f64::from(grid)).floor().clamp(0.0, f64::from(grid) - 1.0) as u32;
    let last = if depths[0] <= depths[1] { layer(depths[1]) + 1 } else { 0 };
    let [across, down] = across_and_down(axis);
    let [columns, rows] = aside;
    (layer(depths[0])..last).flat_map(move |along| {
        let columns = columns.clone();
        rows.clone().flat_map(move |row| {
            columns.clone().map(move |column| {
                let mut voxel = [0; AXES];
                (voxel[axis], voxel[across], voxel[down]) = (along as usize, column as usize, row as usize);
                (voxel[2] * grid as usize + voxel[1]) * grid as usize + voxel[0]
            })
        })
    })
}

/// Holds the fragments of a texel against those that may and those that must be there.
fn compare(stored: &[PlaneFragment], allowed: &[AllowedPlane]) -> Result<(), String> {
    if let Some(fragment) = stored.iter().find(|fragment| !allowed.iter().any(|each| each.fits(fragment))) {
        let off = |each: &AllowedPlane| each.slopes.distance(fragment.slopes);
        let nearest = allowed.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        return Err(format!("no triangle gives {fragment:?}, the one that it comes nearest to {nearest:?}"));
    }
    let must = allowed.iter().filter(|each| each.must).count();
    if stored.len() > allowed.len() || stored.len() < must {
        return Err(format!("{} fragments, {must} triangles must give one and {} may", stored.len(), allowed.len()));
    }
    match allowed.iter().filter(|each| each.must).find(|each| !stored.iter().any(|fragment| each.fits(fragment))) {
        Some(missing) => Err(format!("{missing:?} is not stored")),
        None => Ok(()),
    }
}
