//! Triangle setup: the vertex buffer, and of every view the triangles that may be seen in it with their rectangles of tiles.
//!
//! The vertex buffer is the paper's (section 4.1.2), of positions alone: surfaces have no other attributes here. It is filled
//! before the geometry passes, which read it. The lists stand in for the paper's geometry shader, which emits a triangle into
//! the views that see it.

use bytemuck::Zeroable;
use tracebench_api::wgpu::{BindGroup, BindingResource, Buffer, ComputePipeline};
use tracebench_api::{DeviceGeometry, Gpu, Ledger, PhaseClock, TracerError};
use tracebench_kit::{
    GrowableBuffer, PrefixSum, PrefixSumPlan, bind_group_at, dispatch_linear, grow, uniform_buffer, view_uniforms,
};

use crate::layout::{Layout, MAX_VIEWS};
pub(crate) use tracebench_shaders::dirt::SetupPass;

/// As `BLOCK` in shaders/dirt/setup.wgsl: triangles of a block, and lanes of a workgroup.
pub(crate) const BLOCK: u32 = 64;

/// Bytes of a triangle's corners.
const VERTEX_BYTES: u64 = 36;
/// Bytes of the records that searches read them in: the buffer ends with a whole one.
const QUAD_BYTES: u64 = 16;
/// Bytes of the counts before the lists' entries.
const COUNT_BYTES: u64 = 4 * MAX_VIEWS as u64;
/// Bytes of a `RasterizedTriangle` of shaders/dirt/drawn.wgsl.
const ENTRY_BYTES: u64 = 12;

/// What ledgers call the corners, after section 3.
const VERTICES: &str = "vertex buffer";
const SEEN: &str = "triangle setup: views' bits";
const BLOCKS: &str = "triangle setup: counts of blocks";
const DRAWN: &str = "triangle setup: views' triangles";
/// What is turned down where there are too many triangles.
const TRIANGLES: &str = "the scene's triangle count";

/// The pipelines.
#[derive(Clone, Debug)]
pub(crate) struct SetupPipelines {
    pub see: ComputePipeline,
    pub list: ComputePipeline,
}

/// The capacities of one scene's triangles.
#[derive(Clone)]
pub(crate) struct TriangleSetup {
    triangle_count: u32,
    view_count: usize,
    vertices: GrowableBuffer,
    seen: GrowableBuffer,
    blocks: GrowableBuffer,
    sums: PrefixSumPlan,
    drawn: GrowableBuffer,
    /// Entries that each view has room for.
    capacities: [u32; MAX_VIEWS],
}

/// What setup binds: made before the phase, which only records.
pub(crate) struct Bound {
    see: BindGroup,
    list: BindGroup,
}

impl TriangleSetup {
    /// Room for so many triangles, with lists as long as those of `there`, whose capacities serve where they are large enough.
    pub(crate) fn new(
        gpu: &Gpu,
        sums: &PrefixSum,
        view_count: usize,
        triangle_count: u32,
        there: Option<&Self>,
    ) -> Result<Self, TracerError> {
        let blocks = u64::from(triangle_count.div_ceil(BLOCK)) * view_count as u64;
        let room = |name, bytes, there| GrowableBuffer::new(gpu, name, bytes, TRIANGLES, there);
        let vertex_bytes = (u64::from(triangle_count) * VERTEX_BYTES).next_multiple_of(QUAD_BYTES);
        let vertices = room(VERTICES, vertex_bytes, there.map(|there| &there.vertices))?;
        let seen = room(SEEN, blocks * 8, there.map(|there| &there.seen))?;
        let blocks_room = room(BLOCKS, blocks * 4 + 4, there.map(|there| &there.blocks))?;
        let sums = sums.plan(gpu, &blocks_room.buffer, blocks as u32 + 1, there.map(|there| &there.sums))?;
        let capacities = there.map_or([0; MAX_VIEWS], |there| there.capacities);
        let drawn = room(DRAWN, drawn_bytes(&capacities), there.map(|there| &there.drawn))?;
        Ok(Self { triangle_count, view_count, vertices, seen, blocks: blocks_room, sums, drawn, capacities })
    }

    /// Whether it is of so many triangles and views.
    pub(crate) fn serves(&self, view_count: usize, triangle_count: u32) -> bool {
        (self.view_count, self.triangle_count) == (view_count, triangle_count)
    }

    /// Triangles of every view as the last build found them, also those that there was no room for.
    pub(crate) fn counts(&self, gpu: &Gpu) -> Result<[u32; MAX_VIEWS], TracerError> {
        let read = gpu.read(&self.drawn.buffer, COUNT_BYTES)?;
        let mut counts = bytemuck::pod_collect_to_vec::<u8, [u32; MAX_VIEWS]>(&read)[0];
        counts[self.view_count..].fill(0);
        Ok(counts)
    }

    /// Whether every view has room for so many triangles.
    pub(crate) fn holds(&self, counts: &[u32; MAX_VIEWS]) -> bool {
        self.capacities.iter().zip(counts).all(|(room, count)| room >= count)
    }

    /// Makes room for so many triangles of every view, and for a quarter more where it can: what views see changes with every
    /// step of the camera.
    pub(crate) fn grow_on_overflow(&mut self, gpu: &Gpu, counts: &[u32; MAX_VIEWS]) -> Result<(), TracerError> {
        grow(counts, |capacities| {
            self.drawn = GrowableBuffer::new(gpu, DRAWN, drawn_bytes(capacities), TRIANGLES, None)?;
            self.capacities.copy_from_slice(capacities);
            Ok(())
        })
    }

    /// The first entry of a view's list and the entries that there is room for.
    pub(crate) fn room_of(&self, view: usize) -> [u32; 2] {
        [self.capacities[..view].iter().sum(), self.capacities[view]]
    }

    /// The corners of triangles.
    pub(crate) fn vertices(&self) -> &Buffer {
        &self.vertices.buffer
    }

    /// The views' lists.
    pub(crate) fn drawn(&self) -> &Buffer {
        &self.drawn.buffer
    }

    pub(crate) fn bind(
        &self,
        gpu: &Gpu,
        pipelines: &SetupPipelines,
        layout: &Layout,
        scene: &DeviceGeometry,
    ) -> Result<Bound, TracerError> {
        let mut pass = SetupPass {
            tiles: layout.tiles,
            triangle_count: self.triangle_count,
            view_count: self.view_count as u32,
            block_count: self.triangle_count.div_ceil(BLOCK),
            ..Zeroable::zeroed()
        };
        for (view, room) in pass.capacities.chunks_exact_mut(4).enumerate() {
            room[..2].copy_from_slice(&self.room_of(view));
        }
        let pass = uniform_buffer(gpu, "triangle setup", &pass)?;
        let views = uniform_buffer(gpu, "views", &view_uniforms::<MAX_VIEWS>(layout.uniforms()))?;
        let Self { vertices, seen, blocks, drawn, .. } = self;
        let all = [&pass, &views, &scene.positions, &scene.indices, &vertices.buffer, &seen.buffer, &blocks.buffer];
        let all: Vec<(u32, BindingResource<'_>)> =
            (0..).zip(all.into_iter().chain([&drawn.buffer]).map(Buffer::as_entire_binding)).collect();
        let of = |bindings: &[u32]| -> Vec<_> {
            all.iter().filter(|(binding, _)| bindings.contains(binding)).cloned().collect()
        };
        let bind = |pipeline: &ComputePipeline, bindings: &[u32]| {
            bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &of(bindings))
        };
        Ok(Bound {
            see: bind(&pipelines.see, &[0, 1, 2, 3, 4, 5, 6]),
            list: bind(&pipelines.list, &[0, 1, 4, 5, 6, 7]),
        })
    }
}

impl TriangleSetup {
    /// Records the phase.
    pub(crate) fn record(
        &self,
        pipelines: &SetupPipelines,
        sums: &PrefixSum,
        bound: &Bound,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        clock.device_phase("triangle setup", |encoder| {
            dispatch_linear(encoder, &pipelines.see, &bound.see, self.triangle_count, BLOCK);
            sums.record(encoder, &self.sums);
            dispatch_linear(encoder, &pipelines.list, &bound.list, self.triangle_count, BLOCK);
        })
    }

    /// Enters the capacities; `drawn` triangles stand in the lists.
    pub(crate) fn enter(&self, ledger: &mut Ledger, drawn: &[u32; MAX_VIEWS]) {
        for room in [&self.vertices, &self.seen, &self.blocks] {
            room.enter(ledger);
        }
        self.sums.enter(ledger);
        let bytes = self.drawn.buffer.size();
        ledger.keep(DRAWN, bytes, drawn_bytes(drawn).min(bytes));
    }
}

/// Bytes of lists with so many entries of each view.
fn drawn_bytes(capacities: &[u32]) -> u64 {
    COUNT_BYTES + capacities.iter().map(|room| u64::from(*room)).sum::<u64>().max(1) * ENTRY_BYTES
}
