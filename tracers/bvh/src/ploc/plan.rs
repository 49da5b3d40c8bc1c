//! A build and a refit as they are recorded: bindings made beforehand, phases in order.

use tracebench_api::wgpu::{self, BindGroup, Buffer, BufferUsages, CommandEncoder, ComputePipeline};
use tracebench_api::{DeviceGeometry, Geometry, Gpu, PhaseClock, TracerError};
use tracebench_kit::{
    GrowableBuffer, RadixSortPlan, ReadSlot, Readable, bind_group_at, dispatch_linear, record_copies,
};

use super::buffers::{BuildBuffers, HINT};
use super::description::{PlocParameters, TreeKind};
use super::iterations::{Bound, bounds};
use super::kernels::{
    Blocks, BuildSettings, CODE_BITS, ClusterIteration, ConversionLevel, Kernels, RAISED, RUN, RefitStage, SEARCHED,
    WORKGROUP_SIZE, build_settings,
};
use crate::gpu::WIDE_STACK;
use crate::gpu::description::NodeKind;
use crate::gpu::resident::{NODES_SLOT, TRIANGLES, TRIANGLES_SLOT};

/// Most lanes of a level's dispatch: each takes several nodes where there are more.
const MAX_LEVEL_LANES: u64 = 1 << 13;

/// Iterations, those over the most clusters, that have a search radius of their own.
pub(super) const EARLY_ITERATIONS: usize = 2;

/// Levels that may be large. Those below have few nodes, if any, unless a scene is made for it, and get few lanes: on Mesa's
/// software driver every workgroup of the conversion costs about 10 microseconds, if it has no node, too.
const LARGE_LEVELS: usize = 11;

/// Most lanes of those below.
const DEEP_LEVEL_LANES: u64 = 256;

/// What is needed to record builds and refits over triangles that stay as many.
pub(super) struct Plan {
    pub(super) kind: NodeKind,
    pub(super) triangle_count: u32,
    pub(super) buffers: BuildBuffers,
    pub(super) sort: RadixSortPlan,
    /// What is searched: nodes of the kind, triangles in the order of the leaves.
    pub(super) arrays: [Readable; 2],
    tree: TreeKind,
    bounds: Vec<Bound>,
    search_radius: u32,
    early_radius: u32,
}

/// A pipeline with its bindings and lanes.
struct Step<'a> {
    pipeline: &'a ComputePipeline,
    bindings: BindGroup,
    lanes: u32,
    workgroup_size: u32,
}

impl Step<'_> {
    fn record(&self, encoder: &mut CommandEncoder) {
        dispatch_linear(encoder, self.pipeline, &self.bindings, self.lanes, self.workgroup_size);
    }
}

/// A step whose resources have the bindings of these numbers.
fn step<'a>(gpu: &Gpu, pipeline: &'a ComputePipeline, resources: &[(u32, &Buffer)], lanes: u32) -> Step<'a> {
    let resources: Vec<(u32, wgpu::BindingResource<'_>)> =
        resources.iter().map(|(binding, buffer)| (*binding, buffer.as_entire_binding())).collect();
    let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
    Step { pipeline, bindings, lanes, workgroup_size: WORKGROUP_SIZE }
}

fn uniform<T: bytemuck::Pod>(gpu: &Gpu, name: &str, contents: &T) -> Result<Buffer, TracerError> {
    gpu.buffer_with(name, bytemuck::bytes_of(contents), BufferUsages::UNIFORM, "nothing")
}

/// The scene's buffers, which the device must be able to bind.
fn scene<'a>(gpu: &Gpu, geometry: &'a Geometry) -> Result<&'a DeviceGeometry, TracerError> {
    let device = geometry.on_device()?;
    for (name, buffer) in [("vertex positions", &device.positions), ("vertex indices", &device.indices)] {
        gpu.check_storage_binding(name, buffer.size(), "the scene's triangle count")?;
    }
    Ok(device)
}

impl Plan {
    /// Makes room for a build, in the buffers of `there` where these are large enough.
    pub(super) fn new(
        kernels: &Kernels,
        parameters: &PlocParameters,
        triangle_count: u32,
        there: Option<&Plan>,
    ) -> Result<Self, TracerError> {
        let gpu = &*kernels.gpu;
        let &PlocParameters { node: kind, tree, memory_access, search_radius, early_search_radius, .. } = parameters;
        let buffers = BuildBuffers::new(gpu, kind, memory_access, triangle_count, there.map(|there| &there.buffers))?;
        let (codes, order) = (&buffers.codes.buffer, &buffers.order.buffer);
        let sort = kernels.sort.plan(gpu, codes, order, triangle_count, CODE_BITS, there.map(|there| &there.sort))?;
        let array = |slot: ReadSlot, room: &GrowableBuffer, name| {
            let there = there.map(|there| &there.arrays[slot as usize]);
            Readable::built(gpu, memory_access, slot, &room.buffer, room.used_bytes, name, there, HINT)
        };
        let nodes = array(NODES_SLOT, buffers.wide.as_ref().unwrap_or(&buffers.binary), kind.name())?;
        let arrays = [nodes, array(TRIANGLES_SLOT, &buffers.triangles, TRIANGLES)?];
        let bounds = bounds(triangle_count);
        let early_radius = early_search_radius;
        Ok(Self { kind, triangle_count, buffers, sort, arrays, tree, bounds, search_radius, early_radius })
    }

    /// Bytes of the uniforms of a build, which are kept until it is done.
    pub(super) fn uniform_bytes(&self) -> u64 {
        let tree = match self.tree {
            TreeKind::Clustered => (self.bounds.len() + 1) * size_of::<ClusterIteration>(),
            TreeKind::Radix => (self.raised().count() + 1) * size_of::<Blocks>(),
        };
        let levels = if self.kind == NodeKind::Wide { WIDE_STACK * size_of::<ConversionLevel>() } else { 0 };
        (size_of::<BuildSettings>() + tree + levels) as u64
    }

    /// Records a build.
    pub(super) fn build(
        &self,
        kernels: &Kernels,
        geometry: &Geometry,
        scale: f32,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &*kernels.gpu;
        let scene = scene(gpu, geometry)?;
        let settings = uniform(gpu, "build settings", &build_settings(geometry, scale))?;
        let BuildBuffers { triangles, progress, codes, order, .. } = &self.buffers;
        let count = self.triangle_count;
        let (positions, indices) = (&scene.positions, &scene.indices);
        let encode = [(0, &settings), (1, positions), (2, indices), (3, &codes.buffer), (4, &order.buffer)];
        let encode = step(gpu, &kernels.encode, &encode, count);
        let place = self.place(kernels, scene, &settings);
        let tree = self.tree(kernels)?;
        let levels = self.conversion(kernels)?;
        let fill = [(0, &settings), (1, positions), (2, indices), (7, &triangles.buffer)];
        let fill = step(gpu, &kernels.fill, &fill, count);

        clock.device_phase("Morton codes", |encoder| {
            encoder.clear_buffer(&progress.buffer, 0, None);
            encode.record(encoder);
        })?;
        clock.device_phase("radix sort", |encoder| kernels.sort.record(encoder, &self.sort))?;
        clock.device_phase("leaves", |encoder| place.record(encoder))?;
        let name = if self.tree == TreeKind::Radix { "radix tree" } else { "cluster" };
        clock.device_phase(name, |encoder| tree.iter().for_each(|step| step.record(encoder)))?;
        if self.kind == NodeKind::Wide {
            clock.device_phase("convert to CWBVH", |encoder| levels.iter().for_each(|step| step.record(encoder)))?;
        }
        clock.device_phase("order triangles", |encoder| fill.record(encoder))?;
        record_copies(&self.arrays, clock)
    }

    /// Leaves along the curve.
    fn place<'a>(&self, kernels: &'a Kernels, scene: &DeviceGeometry, settings: &Buffer) -> Step<'a> {
        let BuildBuffers { triangles, binary, progress, codes, order, clusters, .. } = &self.buffers;
        let place = [
            (0, settings),
            (1, &scene.positions),
            (2, &scene.indices),
            (3, &codes.buffer),
            (4, &order.buffer),
            (5, &clusters[0].buffer),
            (6, &binary.buffer),
            (7, &triangles.buffer),
            (8, &progress.buffer),
        ];
        step(&kernels.gpu, &kernels.place, &place, self.triangle_count)
    }

    /// From leaves to pairs of siblings.
    fn tree<'a>(&self, kernels: &'a Kernels) -> Result<Vec<Step<'a>>, TracerError> {
        match self.tree {
            TreeKind::Clustered => self.iterations(kernels),
            TreeKind::Radix => self.radix_tree(kernels),
        }
    }

    /// Levels of blocks from which others are raised: those that have two blocks.
    fn raised(&self) -> impl Iterator<Item = u32> {
        let count = self.triangle_count;
        (0..u32::BITS - 1).step_by(RAISED as usize).take_while(move |level| count >> (level + 1) > 0)
    }

    /// Boxes of blocks, level by level, then all pairs at once.
    fn radix_tree<'a>(&self, kernels: &'a Kernels) -> Result<Vec<Step<'a>>, TracerError> {
        let gpu = &*kernels.gpu;
        let BuildBuffers { binary, codes, clusters, .. } = &self.buffers;
        let triangle_count = self.triangle_count;
        let settings = |level| uniform(gpu, "blocks", &Blocks { triangle_count, level });
        let [leaves, blocks] = [(2, &clusters[0].buffer), (3, &clusters[1].buffer)];
        let raise = |level: u32| {
            let lanes = (triangle_count >> (level + 1)).div_ceil(1 << (RAISED - 1));
            Ok(step(gpu, &kernels.raise, &[(0, &settings(level)?), leaves, blocks], lanes))
        };
        let mut steps = self.raised().map(raise).collect::<Result<Vec<_>, TracerError>>()?;
        let link = if self.kind == NodeKind::Wide { &kernels.link_wide } else { &kernels.link_binary };
        let all = [(0, &settings(0)?), (1, &codes.buffer), leaves, blocks, (4, &binary.buffer)];
        steps.push(step(gpu, link, &all, triangle_count - 1));
        Ok(steps)
    }

    /// The kernels of every iteration; what they start with has a bound on the host, and lanes beyond what there is end at
    /// once.
    fn iterations<'a>(&self, kernels: &'a Kernels) -> Result<Vec<Step<'a>>, TracerError> {
        let gpu = &*kernels.gpu;
        let BuildBuffers { binary, progress, codes: nearest, clusters, tallies, .. } = &self.buffers;
        let cluster = match self.kind {
            NodeKind::Wide => &kernels.cluster_wide,
            NodeKind::Binary => &kernels.cluster_binary,
        };
        let settings = |index: usize, allowed, search_radius| {
            uniform(gpu, "iteration", &ClusterIteration { index: index as u32, allowed, search_radius })
        };
        let [even, odd] = [&clusters[0].buffer, &clusters[1].buffer];
        let (progress, nearest, tallies) = ((1, &progress.buffer), (3, &nearest.buffer), (4, &tallies.buffer));
        let nodes = (6, &binary.buffer);
        let mut steps = Vec::new();
        for (index, bound) in self.bounds.iter().enumerate() {
            let radius = if index < EARLY_ITERATIONS { self.early_radius } else { self.search_radius };
            let settings = settings(index, bound.allowed, radius)?;
            let settings = (0, &settings);
            let (from, to) = if index % 2 == 0 { (even, odd) } else { (odd, even) };
            let runs = bound.most.div_ceil(RUN);
            let merge = [settings, progress, (2, from), nearest, tallies, (5, to), nodes];
            steps.push(step(
                gpu,
                &cluster.search,
                &[settings, progress, (2, from), nearest],
                bound.most.div_ceil(SEARCHED),
            ));
            steps.push(step(gpu, &cluster.tally, &[settings, progress, nearest, tallies], runs));
            steps.push(step(gpu, &cluster.add_up, &[settings, progress, tallies], 1));
            steps.push(step(gpu, &cluster.merge, &merge, runs));
        }
        let settings = settings(self.bounds.len(), 0, self.search_radius)?;
        let finish = [(0, &settings), progress, (2, even), nearest, (5, odd), nodes];
        steps.push(step(gpu, &cluster.finish, &finish, 1));
        Ok(steps)
    }

    /// Most lanes for one level of compressed nodes.
    fn level_lanes(&self, level: usize) -> u32 {
        let nodes = (u64::from(self.triangle_count) / 4).max(1);
        let most = if level < LARGE_LEVELS { MAX_LEVEL_LANES } else { DEEP_LEVEL_LANES };
        nodes.min(1 << (3 * level).min(62)).min(most) as u32
    }

    /// The conversion, level by level from the root.
    fn conversion<'a>(&self, kernels: &'a Kernels) -> Result<Vec<Step<'a>>, TracerError> {
        let gpu = &*kernels.gpu;
        let BuildBuffers { triangles, binary, progress, order, wide, .. } = &self.buffers;
        let Some(wide) = wide else { return Ok(Vec::new()) };
        let level = |index: usize| {
            let left = WIDE_STACK - 1 - index;
            let settings = ConversionLevel { index: index as u32, tallest: 3 * left as u32 };
            let settings = uniform(gpu, "level", &settings)?;
            let resources = [
                (0, &settings),
                (1, &progress.buffer),
                (2, &binary.buffer),
                (3, &order.buffer),
                (4, &wide.buffer),
                (5, &triangles.buffer),
            ];
            Ok(step(gpu, &kernels.convert, &resources, self.level_lanes(index)))
        };
        (0..WIDE_STACK).map(level).collect()
    }

    /// Records a refit: triangles, then boxes from the leaves up. Pairs of a radix tree are made again, of the codes that are there.
    pub(super) fn refit(
        &self,
        kernels: &Kernels,
        geometry: &Geometry,
        scale: f32,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &*kernels.gpu;
        let scene = scene(gpu, geometry)?;
        let settings = uniform(gpu, "build settings", &build_settings(geometry, scale))?;
        let BuildBuffers { triangles, binary, progress, clusters, wide, .. } = &self.buffers;
        let triangle_count = self.triangle_count;
        let fill = [(0, &settings), (1, &scene.positions), (2, &scene.indices), (7, &triangles.buffer)];
        let fill = step(gpu, &kernels.fill, &fill, triangle_count);
        let stage = |index: usize| uniform(gpu, "stage", &RefitStage { index: index as u32, triangle_count });
        let mut steps = Vec::new();
        if let Some(wide) = wide {
            for level in (0..WIDE_STACK).rev() {
                let stage = stage(level)?;
                let resources = [
                    (0, &stage),
                    (1, &progress.buffer),
                    (2, &triangles.buffer),
                    (3, &wide.buffer),
                    (4, &clusters[0].buffer),
                ];
                steps.push(step(gpu, &kernels.refit_wide, &resources, self.level_lanes(level)));
            }
        } else if self.tree == TreeKind::Radix {
            steps.push(self.place(kernels, scene, &settings));
            steps.extend(self.tree(kernels)?);
        } else {
            let shared = [(1, &progress.buffer), (2, &triangles.buffer), (3, &binary.buffer)];
            for (index, bound) in self.bounds.iter().enumerate() {
                let stage = stage(index)?;
                let resources = [(0, &stage), shared[0], shared[1], shared[2]];
                steps.push(step(gpu, &kernels.refit_binary, &resources, bound.most / 2));
            }
            let stage = stage(0)?;
            let resources = [(0, &stage), shared[0], shared[1], shared[2]];
            steps.push(step(gpu, &kernels.refit_binary_last, &resources, 1));
        }
        clock.device_phase("order triangles", |encoder| fill.record(encoder))?;
        clock.device_phase("refit boxes", |encoder| steps.iter().for_each(|step| step.record(encoder)))?;
        record_copies(&self.arrays, clock)
    }
}
