//! The structure read back: its lists followed and held against a rasterizer on the host, its grid against a voxelizer and against the
//! layers themselves.

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::wgpu::Buffer;
use tracebench_api::{Geometry, TracerError};

use crate::brute_force::{AllowedLayers, Layer, UNIT_SLACK, allowed_layers, normal_is_noise, touched_voxels};
use crate::buffers::{Lists, Summed, Taken};
use crate::description::{Averaged, Fed};
use crate::layout::{AXES, AXIS_NAMES, Layout, NORMAL_UNIT, across_and_down};
use crate::structure::{VoxelStructure, check};

/// Texels of an image that are held against the host's rasterizer at most: every n-th along both edges.
const MAX_COMPARED: u64 = 4096;

/// Voxels with something whose code is that.
const CANCELLED: u32 = 4;

/// The bit of a voxel's count that says that there is anything, fed or not.
const ANY_FRAGMENT: u32 = 1 << 31;

fn fail<T>(what: String) -> Result<T, TracerError> {
    Err(TracerError::Failed(what))
}

/// What following all lists tells.
#[derive(Default)]
struct Statistics {
    layers: u64,
    covered: u64,
    most: usize,
    compared: u64,
}

/// An axis' lists.
struct ReadBack {
    axis: usize,
    heads: Vec<u32>,
    nodes: Vec<[u32; 2]>,
    data: Vec<[u32; 4]>,
    /// Fragments stored.
    stored: u32,
    met: Vec<bool>,
    /// Whether layers of equal depth and facing stay.
    copies: bool,
}

impl ReadBack {
    /// The layers of a texel, in order; checks that they are, each of another depth or facing, and in no other list.
    fn follow(&mut self, texel: u32) -> Result<Vec<Layer>, TracerError> {
        let (mut layers, mut before) = (Vec::new(), 0);
        let mut link = self.heads[texel as usize];
        let name = AXIS_NAMES[self.axis];
        while link != 0 {
            let node = link - 1;
            if node >= self.stored || self.met[node as usize] {
                return fail(format!("axis {name}: node {node} of texel {texel} does not exist or lies in two lists"));
            }
            self.met[node as usize] = true;
            let [code, next] = self.nodes[node as usize];
            if code < before || (code == before && !self.copies) {
                return fail(format!("axis {name}: node {node} of texel {texel} is out of the order of depths"));
            }
            let [x, y, z, material] = self.data[node as usize];
            layers.push(Layer {
                depth: f32::from_bits(code),
                faces_along: code & 1 == 1,
                normal: Vec3::from([x, y, z].map(f32::from_bits)),
                material,
            });
            (before, link) = (code, next);
        }
        Ok(layers)
    }
}

/// Sums of normals as the stored layers give them, of voxels that none of their layers lies at the border of.
struct Expected {
    sums: Vec<DVec3>,
    fragments: Vec<u32>,
    fed: Vec<u32>,
    /// Layers at the border, which may lie in either.
    unsure: Vec<bool>,
    /// Touched by thin triangles, whose normals are noise.
    noise: Vec<bool>,
}

impl VoxelStructure {
    pub(crate) fn validate_against(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let layout = &self.layout;
        let texels = u64::from(layout.texels());
        let step = (1..).find(|step| texels / (step * step) <= MAX_COMPARED).unwrap_or(1) as u32;
        let codes = self.voxel_codes()?;
        let count = |is: &dyn Fn(u32) -> bool| codes.iter().filter(|code| is(**code)).count() as f64;
        let mut statistics = vec![
            ("voxels", codes.len() as f64),
            ("occupied_voxels", count(&|code| code != 0)),
            ("texels", (texels * AXES as u64) as f64),
        ];
        if let (true, Some(lists)) = (layout.planes, &self.buffers.lists) {
            statistics.extend(self.validate_planes(lists, geometry, step, &codes)?);
            return Ok(statistics);
        }
        let border = layout.raster_backend.undecided_border(&self.pipelines.gpu)?;
        let allowed = |axis| allowed_layers(layout.space, geometry, axis, step, border);
        let allowed: [AllowedLayers; AXES] = std::array::from_fn(allowed);
        self.check_voxels(geometry, &allowed, &codes)?;
        let Some(lists) = &self.buffers.lists else { return Ok(statistics) };
        let taken = self.buffers.taken(&self.pipelines.gpu)?;
        check(&taken)?;
        let thin = |corners| normal_is_noise(layout.space.scale, corners, 0.5 / NORMAL_UNIT);
        let noise = touched_voxels(layout.space, geometry, border, thin);
        let found = self.check_lists(lists, &taken, &allowed, noise, &codes)?;
        statistics.extend([
            ("cancelled_voxels", count(&|code| code == CANCELLED)),
            ("fragments", taken.fragments.iter().map(|count| f64::from(*count)).sum()),
            ("copies", f64::from(taken.copies)),
            ("covered_texels", found.covered as f64),
            ("average_layers", found.layers as f64 / (found.covered as f64).max(1.0)),
            ("maximum_layers", found.most as f64),
            ("compared_texels", found.compared as f64),
        ]);
        Ok(statistics)
    }

    fn read<T: bytemuck::AnyBitPattern + bytemuck::NoUninit>(&self, buffer: &Buffer) -> Result<Vec<T>, TracerError> {
        Ok(bytemuck::pod_collect_to_vec(&self.pipelines.gpu.read(buffer, buffer.size())?))
    }

    /// What searches read of every voxel; of voxels alone 0 or 1.
    pub(crate) fn voxel_codes(&self) -> Result<Vec<u32>, TracerError> {
        let words: Vec<u32> = self.read(&self.buffers.cells)?;
        let bits = if self.layout.voxels_only { 1 } else { 4 };
        let in_word = 32 / bits;
        let code = |voxel: u32| words[(voxel / in_word) as usize] >> (voxel % in_word * bits) & ((1 << bits) - 1);
        Ok((0..self.layout.voxels()).map(code).collect())
    }

    /// Every voxel that has anything is touched by a triangle, and every one is marked that a sample lies clearly in.
    fn check_voxels(
        &self,
        geometry: &Geometry,
        allowed: &[AllowedLayers; AXES],
        codes: &[u32],
    ) -> Result<(), TracerError> {
        let space = self.layout.space;
        let border = self.layout.raster_backend.undecided_border(&self.pipelines.gpu)?;
        let touched = touched_voxels(space, geometry, border, |_| true);
        if let Some(voxel) = codes.iter().zip(&touched).position(|(code, touched)| *code != 0 && !touched) {
            return fail(format!("voxel {voxel} is marked, and no triangle touches it"));
        }
        for (axis, allowed) in allowed.iter().enumerate() {
            for (texel, layers) in allowed.each() {
                for layer in layers.iter().filter(|layer| layer.must) {
                    let ends = layer.depths.map(|depth| voxel_of(&self.layout, axis, texel, depth));
                    let [Some(near), Some(far)] = ends else { continue };
                    if near == far && codes[near] == 0 {
                        return fail(format!(
                            "voxel {near} has {layer:?} along {} and is not marked",
                            AXIS_NAMES[axis]
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    fn check_lists(
        &self,
        lists: &Lists,
        taken: &Taken,
        allowed: &[AllowedLayers; AXES],
        noise: Vec<bool>,
        codes: &[u32],
    ) -> Result<Statistics, TracerError> {
        let mut found = Statistics::default();
        let voxels = codes.len();
        let mut expected = Expected {
            sums: vec![DVec3::ZERO; voxels],
            fragments: vec![0; voxels],
            fed: vec![0; voxels],
            unsure: vec![false; voxels],
            noise,
        };
        let heads: Vec<u32> = self.read(&lists.heads)?;
        for (axis, allowed) in allowed.iter().enumerate() {
            let (stored, capacity) = (taken.fragments[axis], lists.nodes.capacities[axis]);
            if stored > capacity {
                return fail(format!("{stored} fragments along {} and room for {capacity}", AXIS_NAMES[axis]));
            }
            let [nodes, data] = self.nodes_of(lists, axis)?;
            let first = axis * self.layout.head_stride() as usize;
            let mut back = ReadBack {
                axis,
                heads: heads[first..first + self.layout.texels() as usize].to_vec(),
                nodes: bytemuck::pod_collect_to_vec(&nodes),
                data: bytemuck::pod_collect_to_vec(&data),
                stored,
                met: vec![false; stored as usize],
                copies: self.layout.nesting,
            };
            self.check_axis(&mut back, allowed, &mut expected, &mut found)?;
        }
        let stored: u64 = taken.fragments.iter().map(|count| u64::from(*count)).sum();
        if found.layers + u64::from(taken.copies) != stored {
            return fail(format!("{} layers and {} copies of {stored} fragments", found.layers, taken.copies));
        }
        self.check_sums(lists, taken, &expected, codes)?;
        Ok(found)
    }

    /// The words of an axis' nodes and of their data.
    pub(crate) fn nodes_of(&self, lists: &Lists, axis: usize) -> Result<[Vec<u8>; 2], TracerError> {
        let nodes = &lists.nodes;
        let [of_nodes, of_data] = nodes.buffers();
        let part = |buffers: &[&Buffer], each: usize| -> Result<Vec<u8>, TracerError> {
            let own: Vec<&Buffer> = match buffers.len() {
                1 => buffers.to_vec(),
                count => buffers[axis * (count / AXES)..(axis + 1) * (count / AXES)].to_vec(),
            };
            let mut bytes = Vec::new();
            for buffer in own {
                bytes.extend(self.pipelines.gpu.read(buffer, buffer.size())?);
            }
            let first = if buffers.len() == 1 { nodes.before(axis) as usize * each } else { 0 };
            Ok(bytes[first..first + nodes.capacities[axis] as usize * each].to_vec())
        };
        Ok([part(&of_nodes, 8)?, part(&of_data, 16)?])
    }

    fn check_axis(
        &self,
        back: &mut ReadBack,
        allowed: &AllowedLayers,
        expected: &mut Expected,
        found: &mut Statistics,
    ) -> Result<(), TracerError> {
        let image = self.layout.image();
        for y in 0..image {
            for x in 0..image {
                let layers = back.follow(y * image + x)?;
                found.layers += layers.len() as u64;
                found.covered += u64::from(!layers.is_empty());
                found.most = found.most.max(layers.len());
                for layer in &layers {
                    self.expect(back.axis, [x, y], layer, expected);
                }
                if x % allowed.step == 0 && y % allowed.step == 0 {
                    let context = |what| format!("axis {}, texel {x}, {y}: {what}", AXIS_NAMES[back.axis]);
                    compare(&layers, allowed.of([x, y])).map_err(|what| TracerError::Failed(context(what)))?;
                    found.compared += 1;
                }
            }
        }
        Ok(())
    }

    /// Adds what a layer gives its voxel.
    fn expect(&self, axis: usize, texel: [u32; 2], layer: &Layer, expected: &mut Expected) {
        let depth = f64::from(layer.depth);
        let [near, far] =
            [depth - UNIT_SLACK, depth + UNIT_SLACK].map(|depth| voxel_of(&self.layout, axis, texel, depth));
        let (Some(near), Some(far)) = (near, far) else {
            // At a border across or down, of whatever depth: its neighbours along are as unsure.
            for voxel in voxels_round(&self.layout, axis, texel, depth) {
                expected.unsure[voxel] = true;
            }
            return;
        };
        // The normal of the plane in the cube.
        let scaled = (layer.normal.as_dvec3() / Vec3::from(self.layout.space.scale).as_dvec3()).normalize_or_zero();
        let sizes = scaled.abs();
        let longest = (0..AXES).max_by(|a, b| sizes[*a].total_cmp(&sizes[*b])).unwrap_or_default();
        let second = sizes.element_sum() - sizes[longest] - sizes.min_element();
        // Thin triangles have normals of noise, and of two equal components either may be the longest.
        let chooses = self.layout.averaged == Averaged::Lines || self.layout.fed == Fed::Dominant;
        if near != far || scaled == DVec3::ZERO || (chooses && sizes[longest] - second < 1e-3) {
            expected.unsure[near] = true;
            expected.unsure[far] = true;
            return;
        }
        expected.fragments[near] += 1;
        if self.layout.fed == Fed::All || longest == axis {
            let turned = self.layout.averaged == Averaged::Lines && scaled[longest] < 0.0;
            expected.sums[near] += if turned { -scaled } else { scaled } * NORMAL_UNIT;
            expected.fed[near] += 1;
        }
    }

    /// The grid's sums are those of the layers, and its codes those of the sums.
    fn check_sums(&self, lists: &Lists, taken: &Taken, expected: &Expected, codes: &[u32]) -> Result<(), TracerError> {
        let Some(Summed { sums, fragments }) = &lists.summed else { return Ok(()) };
        let sums: [Vec<i32>; AXES] = [self.read(&sums[0])?, self.read(&sums[1])?, self.read(&sums[2])?];
        let fragments: Vec<u32> = self.read(fragments)?;
        for voxel in 0..codes.len() {
            let sum = DVec3::from(std::array::from_fn::<f64, AXES, _>(|axis| f64::from(sums[axis][voxel])));
            let fed = fragments[voxel] & !ANY_FRAGMENT;
            if !expected.unsure[voxel] {
                // Copies have no layers of their own.
                let fits = fed == expected.fed[voxel] || (taken.copies > 0 && fed >= expected.fed[voxel]);
                if !fits || (fragments[voxel] != 0) != (expected.fragments[voxel] != 0) {
                    let expected = expected.fed[voxel];
                    return fail(format!("voxel {voxel} counts {fed} fragments instead of {expected}"));
                }
                // Each is rounded, and comes of other edges than the stored normal.
                let off = (sum - expected.sums[voxel]).abs().max_element();
                if taken.copies == 0 && !expected.noise[voxel] && off > 1.0 * f64::from(fed) {
                    let expected = expected.sums[voxel];
                    return fail(format!("voxel {voxel} sums normals up to {sum} instead of {expected}"));
                }
            }
            if !code_fits(codes[voxel], fragments[voxel], sum / NORMAL_UNIT, self.layout.cancelled_below) {
                return fail(format!("voxel {voxel} of {fed} fragments and {sum} has the code {}", codes[voxel]));
            }
        }
        Ok(())
    }
}

/// Whether a voxel's code follows from its sums, but for rounding.
fn code_fits(code: u32, fragments: u32, sum: DVec3, min_length: f64) -> bool {
    if fragments == 0 || code == 0 {
        return (fragments == 0) == (code == 0);
    }
    let fed = f64::from(fragments & !ANY_FRAGMENT);
    let (length, limit) = (sum.length(), min_length * fed);
    if code == CANCELLED {
        return length <= limit * (1.0 + 1e-5);
    }
    let sizes = sum.abs();
    code <= AXES as u32
        && length >= limit * (1.0 - 1e-5)
        && sizes[code as usize - 1] >= sizes.max_element() * (1.0 - 1e-6)
}

/// The voxel of a place by texel and depth; none where it lies at a border.
fn voxel_of(layout: &Layout, axis: usize, texel: [u32; 2], depth: f64) -> Option<usize> {
    let [across, down] = across_and_down(axis);
    let (image, grid) = (f64::from(layout.image()), f64::from(layout.space.grid));
    let mut place = DVec3::ZERO;
    place[across] = (f64::from(texel[0]) + 0.5) / image;
    place[down] = (f64::from(texel[1]) + 0.5) / image;
    place[axis] = depth;
    let at = place * grid;
    let from_border = [across, down].map(|axis| (at[axis] - at[axis].round()).abs());
    if from_border.into_iter().any(|distance| distance < UNIT_SLACK * grid) {
        return None;
    }
    let [x, y, z] = at.floor().clamp(DVec3::ZERO, DVec3::splat(grid - 1.0)).to_array().map(|at| at as usize);
    let edge = layout.space.grid as usize;
    Some((z * edge + y) * edge + x)
}

/// The voxels that a place at a border may lie in.
fn voxels_round(layout: &Layout, axis: usize, texel: [u32; 2], depth: f64) -> Vec<usize> {
    let [across, down] = across_and_down(axis);
    let (image, grid) = (f64::from(layout.image()), f64::from(layout.space.grid));
    let mut place = DVec3::ZERO;
    place[across] = (f64::from(texel[0]) + 0.5) / image;
    place[down] = (f64::from(texel[1]) + 0.5) / image;
    place[axis] = depth;
    let slack = UNIT_SLACK * grid;
    let ends = |at: f64| [at - slack, at + slack].map(|at| at.floor().clamp(0.0, grid - 1.0) as usize);
    let [xs, ys, zs] = (place * grid).to_array().map(ends);
    let edge = layout.space.grid as usize;
    let mut voxels = Vec::new();
    for z in zs[0]..=zs[1] {
        for y in ys[0]..=ys[1] {
            voxels.extend((xs[0]..=xs[1]).map(|x| (z * edge + y) * edge + x));
        }
    }
    voxels
}

/// Holds the layers of a texel against those that may and those that must be there.
fn compare(stored: &[Layer], allowed: &[crate::brute_force::Allowed]) -> Result<(), String> {
    if let Some(layer) = stored.iter().find(|layer| !allowed.iter().any(|each| each.fits(layer))) {
        return Err(format!("no triangle gives {layer:?}"));
    }
    if stored.len() > allowed.len() {
        return Err(format!("{} layers, {} triangles may give one", stored.len(), allowed.len()));
    }
    let shown = |each: &&crate::brute_force::Allowed| stored.iter().any(|layer| each.is_shown_by(layer));
    match allowed.iter().filter(|each| each.must).find(|each| !shown(each)) {
        Some(missing) => Err(format!("{missing:?} is not stored")),
        None => Ok(()),
    }
}
