//! The stages of a build on the device: triangles to rows, rows to fragments, fragments sorted, leaves, levels.

use tracebench_api::wgpu::{BindGroup, Buffer, CommandEncoder, ComputePipeline};
use tracebench_api::{DeviceGeometry, Geometry, PhaseClock, TracerError};
use tracebench_kit::{bind_group_at, dispatch_linear, storage_buffer};

use crate::counts::{Counts, TAKEN_WORDS, Taken};
use crate::kernels::{Kernels, WORKGROUP_SIZE};
use crate::layout::{HINT, Layout};
use crate::scratch::Scratch;

/// Bytes of a node: its first child and which it has; and of a leaf: normal and material.
pub(crate) const NODE_BYTES: u64 = 8;
pub(crate) const LEAF_BYTES: u64 = 8;

/// What ledgers call the parts.
pub(crate) const NODES: &str = "nodes";
pub(crate) const LEAVES: &str = "leaves";
pub(crate) const TAKEN: &str = "counts";

/// The triangles that a tree is of, on the device.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    positions: Buffer,
    indices: Buffer,
    materials: Buffer,
    pub triangles: u32,
}

/// What a build fills.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    /// Of all depths, the root first; each depth has its room.
    pub nodes: Buffer,
    pub leaves: Buffer,
    /// What the last build counted.
    pub taken: Buffer,
    /// What there is room for.
    pub room: Counts,
}

impl Scene {
    /// Those of a scene.
    ///
    /// # Errors
    /// As [`Geometry::on_device`]; [`TracerError::TooLarge`] if the device cannot bind them.
    pub(crate) fn of(kernels: &Kernels, geometry: &Geometry) -> Result<Self, TracerError> {
        let DeviceGeometry { positions, indices, materials, .. } = geometry.on_device()?;
        for (name, buffer) in [("vertex positions", positions), ("vertex indices", indices), ("materials", materials)] {
            kernels.gpu.check_storage_binding(name, buffer.size(), "the scene's triangle count")?;
        }
        Ok(Self {
            positions: positions.clone(),
            indices: indices.clone(),
            materials: materials.clone(),
            triangles: geometry.triangles.len() as u32,
        })
    }
}

impl Tree {
    /// Room for so many.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits, which says what to turn down.
    pub(crate) fn new(kernels: &Kernels, layout: &Layout, room: Counts) -> Result<Self, TracerError> {
        let gpu = &*kernels.gpu;
        let buffer = |name: &str, count: u32, each: u64| storage_buffer(gpu, name, u64::from(count) * each, HINT);
        Ok(Self {
            nodes: buffer(NODES, room.nodes_before(layout.levels), NODE_BYTES)?,
            leaves: buffer(LEAVES, room.leaves(layout.levels), LEAF_BYTES)?,
            taken: storage_buffer(gpu, TAKEN, TAKEN_WORDS * 4, "nothing")?,
            room,
        })
    }
}

/// A pipeline with its bindings and lanes.
struct Step<'a> {
    pipeline: &'a ComputePipeline,
    bindings: BindGroup,
    lanes: u32,
}

impl Step<'_> {
    fn record(&self, encoder: &mut CommandEncoder) {
        dispatch_linear(encoder, self.pipeline, &self.bindings, self.lanes, WORKGROUP_SIZE);
    }
}

/// Everything that a build of some scene records, bound.
pub(crate) struct Stages<'a> {
    kernels: &'a Kernels,
    scratch: &'a Scratch,
    tree: &'a Tree,
    measure: Step<'a>,
    count: Step<'a>,
    emit: Step<'a>,
    pad: Step<'a>,
    mark: Step<'a>,
    gather: Step<'a>,
    sum: Step<'a>,
    finish: Step<'a>,
    /// Mark and join of every level, the root's first.
    levels: Vec<[Step<'a>; 2]>,
}

impl<'a> Stages<'a> {
    pub(crate) fn new(
        kernels: &'a Kernels,
        layout: &Layout,
        scene: &Scene,
        scratch: &'a Scratch,
        tree: &'a Tree,
    ) -> Self {
        let room = &tree.room;
        let step = |pipeline: &'a ComputePipeline, bound: &[(u32, &Buffer)], lanes: u32| {
            let bound: Vec<_> = bound.iter().map(|(at, buffer)| (*at, buffer.as_entire_binding())).collect();
            Step { pipeline, bindings: bind_group_at(&kernels.gpu, &pipeline.get_bind_group_layout(0), &bound), lanes }
        };
        let Scratch { settings, row_starts, fragment_starts, keys, primitives, ranks, leaf_keys, leaf_firsts, .. } =
            scratch;
        let (settings, positions, indices) = ((0, settings), (1, &scene.positions), (2, &scene.indices));
        let materials = (3, &scene.materials);
        let taken = (7, &tree.taken);
        let (row_starts, fragment_starts) = ((3, row_starts), (4, fragment_starts));
        let measured = [settings, positions, indices, row_starts, taken];
        let counted = [settings, positions, indices, row_starts, fragment_starts, taken];
        let emitted = [settings, positions, indices, row_starts, fragment_starts, (5, keys), (6, primitives)];
        let (of_keys, of_primitives, of_ranks) = ((4, keys), (5, primitives), (6, ranks));
        let (leaf_keys, firsts, leaves) = ((8, leaf_keys), (9, leaf_firsts), (10, &tree.leaves));
        let sums_z = (11, &scratch.sums_z);
        let summed = [settings, positions, indices, of_keys, of_primitives, of_ranks, firsts, leaves, sums_z];
        let finished = [settings, positions, indices, materials, of_primitives, of_ranks, firsts, leaves, sums_z];
        let level = |depth: usize| {
            // Leaves' keys are in the one, those of the nodes above them in the other, and so on in turn.
            let above = layout.levels as usize - 1 - depth;
            let (from, to) = match above.is_multiple_of(2) {
                true => (&scratch.leaf_keys, &scratch.node_keys),
                false => (&scratch.node_keys, &scratch.leaf_keys),
            };
            let shared = [(0, &scratch.levels[depth]), (1, &tree.taken), (2, from), (3, ranks)];
            let joined = [&shared[..], &[(4, to), (5, &tree.nodes)]].concat();
            let children = room.levels[depth + 1];
            [step(&kernels.mark_nodes, &shared, children + 1), step(&kernels.join, &joined, children)]
        };
        Self {
            kernels,
            scratch,
            tree,
            measure: step(&kernels.measure, &measured, scene.triangles + 1),
            count: step(&kernels.count, &counted, room.rows + 1),
            emit: step(&kernels.emit, &emitted, room.rows),
            pad: step(&kernels.pad, &[settings, fragment_starts, (5, keys), (6, primitives)], room.fragments),
            mark: step(&kernels.mark_leaves, &[settings, of_keys, of_ranks, taken], room.fragments + 1),
            gather: step(&kernels.gather, &[settings, of_keys, of_ranks, leaf_keys, firsts], room.fragments + 1),
            sum: step(&kernels.sum, &summed, room.fragments),
            finish: step(&kernels.finish, &finished, room.leaves(layout.levels)),
            levels: (0..layout.levels as usize).map(level).collect(),
        }
    }

    fn rows(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.tree.taken, 0, None);
        self.measure.record(encoder);
        self.kernels.prefix_sum.record(encoder, &self.scratch.row_sums);
        self.count.record(encoder);
        self.kernels.prefix_sum.record(encoder, &self.scratch.fragment_sums);
    }

    fn fragments(&self, encoder: &mut CommandEncoder) {
        self.emit.record(encoder);
        self.pad.record(encoder);
    }

    fn sort(&self, encoder: &mut CommandEncoder) {
        self.kernels.sort.record(encoder, &self.scratch.sort);
    }

    fn leaves(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.tree.leaves, 0, None);
        encoder.clear_buffer(&self.scratch.sums_z, 0, None);
        self.mark.record(encoder);
        self.kernels.prefix_sum.record(encoder, &self.scratch.leaf_sums);
        for step in [&self.gather, &self.sum, &self.finish] {
            step.record(encoder);
        }
    }

    fn levels(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.tree.nodes, 0, None);
        for ([mark, join], sums) in self.levels.iter().zip(&self.scratch.node_sums).rev() {
            mark.record(encoder);
            self.kernels.prefix_sum.record(encoder, sums);
            join.record(encoder);
        }
    }

    /// Records the whole build, a phase a stage.
    pub(crate) fn record(&self, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        clock.device_phase("rows", |encoder| self.rows(encoder))?;
        clock.device_phase("fragments", |encoder| self.fragments(encoder))?;
        clock.device_phase("sort", |encoder| self.sort(encoder))?;
        clock.device_phase("leaves", |encoder| self.leaves(encoder))?;
        clock.device_phase("levels", |encoder| self.levels(encoder))
    }
}

impl Kernels {
    /// Counts what a build will make of each thing: three times as far as it can with room for what was counted before. By no
    /// phase of the build.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold what a build needs, [`TracerError::Failed`] if triangles have no place.
    pub(crate) fn tally(&self, layout: &Layout, scene: &Scene) -> Result<Counts, TracerError> {
        let count = |room: Counts, record: &dyn Fn(&Stages<'_>, &mut CommandEncoder)| -> Result<Taken, TracerError> {
            let scratch = Scratch::new(self, layout, scene.triangles, &room)?;
            let tree = Tree::new(self, layout, room)?;
            let stages = Stages::new(self, layout, scene, &scratch, &tree);
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            record(&stages, &mut encoder);
            self.gpu.queue.submit([encoder.finish()]);
            Taken::read(&self.gpu, &tree.taken)
        };
        let mut room = Counts::least();
        room.rows = count(room, &|stages, encoder| stages.rows(encoder))?.rows()?.max(1);
        room.fragments = count(room, &|stages, encoder| stages.rows(encoder))?.fragments()?.max(1);
        let whole = count(room, &|stages, encoder| {
            stages.rows(encoder);
            stages.fragments(encoder);
            stages.sort(encoder);
            stages.mark.record(encoder);
        })?;
        Ok(Counts::from_list(&whole.counts(layout.levels)?.list()))
    }

    /// Records a build into a tree; gives the bytes that it needs beside, which are given back when it is done.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold them.
    pub(crate) fn build(
        &self,
        layout: &Layout,
        scene: &Scene,
        tree: &Tree,
        clock: &mut PhaseClock<'_>,
    ) -> Result<u64, TracerError> {
        let scratch = Scratch::new(self, layout, scene.triangles, &tree.room)?;
        Stages::new(self, layout, scene, &scratch, tree).record(clock)?;
        Ok(scratch.bytes())
    }
}
