//! The build's stages on the device: triangle setup, fill depth, mipmap depth, fill primitives.

use std::num::NonZeroU64;

use tracebench_api::wgpu::{BindGroup, BindingResource, Buffer, BufferBinding, BufferUsages};
use tracebench_api::{Gpu, PhaseClock, TracerError};
use tracebench_kit::{
    Canvas, EmptyTarget, MemoryAccess, ROW_BITS, RasterBackend, RasterImage, RasterWork, ReadSlot, Readable,
    TrianglePass, bind_group, dispatch_linear, uniform_buffer,
};
use tracebench_shaders::dirt::Fill;

use crate::layout::{FillPass, Layout, MAX_VIEWS, MipmapLevel, TileGrid};
use crate::pipelines::Pipelines;
use crate::setup::{self, TriangleSetup};
use crate::structure::Resident;

/// As `WORKGROUP_SIZE` in shaders/dirt/mipmap.wgsl.
const WORKGROUP_SIZE: u32 = 64;

/// How a structure is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Filling {
    /// Every tile that a triangle touches keeps it, not only tiles whose centres it covers.
    pub conservative: bool,
    /// Depths by the triangle's plane, not by the clipped polygon.
    pub by_plane: bool,
}

impl Filling {
    /// Vertices that a triangle is drawn with.
    pub(crate) fn vertices(self) -> u32 {
        if self.conservative { 6 } else { 3 }
    }
}

/// The structure's buffers.
#[derive(Clone)]
pub(crate) struct Buffers {
    /// Pairs of codes of the least and greatest depth, every view, every level.
    pub bounds: Buffer,
    /// Heads of the lists: one more than the first node, 0 for an empty list.
    pub heads: Buffer,
    /// Nodes, next and primitive: one buffer, or [`NODE_PARTS`] where one binding does not hold all.
    pub nodes: Vec<Buffer>,
    /// Nodes taken.
    pub taken: Buffer,
    /// The triangles that views are drawn with.
    pub setup: TriangleSetup,
    /// The colour attachment that nothing is written to; none where there is no rasterizer.
    pub attachment: Option<EmptyTarget>,
    /// Nodes that there is room for.
    pub node_capacity: u32,
    /// Nodes of each buffer but the last.
    pub nodes_per_part: u32,
    /// The views' parts of depth bounds and heads.
    parts: Parts,
    /// Whether one binding does not hold all depth bounds, or all heads.
    pub by_view: bool,
}

/// Bytes of a view's part of the buffers that have one of each view.
#[derive(Clone, Copy, Debug)]
struct Parts {
    views: usize,
    bounds: u64,
    heads: u64,
}

/// A part of a buffer, to be bound.
fn part_of(buffer: &Buffer, part: usize, bytes: u64) -> BindingResource<'_> {
    let binding = BufferBinding { buffer, offset: part as u64 * bytes, size: NonZeroU64::new(bytes) };
    BindingResource::Buffer(binding)
}

/// What ledgers call the parts, after Table 3.
pub(crate) const DEPTH_BOUNDS: &str = "depth bounds texture";
pub(crate) const HEADS: &str = "id buffer: heads";
pub(crate) const NODE_COUNT: &str = "node count";
pub(crate) const ATTACHMENT: &str = "attachment that nothing is written to";

// What they call the copies that searches read with memory_access=texture, which Table 3 has not.
const VERTICES_COPY: &str = "vertices (texture)";
const NODES_COPY: &str = "nodes (texture)";
const BOUNDS_COPY: &str = "depth bounds (texture)";
const HEADS_COPY: &str = "heads (texture)";

/// What is turned where they are too large.
const HINT: &str = "--face-size or dirt.buckets, or turn dirt.tile_size up";

/// What they call a part of the nodes.
pub(crate) fn nodes_name(part: usize) -> String {
    if part == 0 { "id buffer: nodes".to_owned() } else { format!("id buffer: nodes, part {}", part + 1) }
}

/// Bytes of a node.
pub(crate) const NODE_BYTES: u64 = 8;

/// A buffer of which `bound` bytes are bound at once.
fn storage(gpu: &Gpu, name: &str, bytes: u64, bound: u64, hint: &str) -> Result<Buffer, TracerError> {
    gpu.check_storage_binding(name, bound, hint)?;
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    gpu.buffer(name, bytes, usage, hint)
}

/// Buffers that nodes are split into where one binding does not hold all, as in shaders/dirt.
pub(crate) const NODE_PARTS: u64 = 8;

/// Nodes that one binding holds at most.
fn nodes_per_binding(gpu: &Gpu) -> u64 {
    (gpu.limits.max_storage_buffer_binding_size / NODE_BYTES).min(u64::from(u32::MAX))
}

/// Nodes of a part where one binding does not hold all: whole rows of the texture that searches may read.
fn nodes_per_part(gpu: &Gpu) -> u64 {
    let per_row = (1 << ROW_BITS) / NODE_BYTES;
    (nodes_per_binding(gpu) / per_row).max(1) * per_row
}

/// Buffers for nodes, one or several.
pub(crate) fn node_buffers(gpu: &Gpu, capacity: u32) -> Result<Vec<Buffer>, TracerError> {
    let hint = "dirt.buckets or --face-size, or turn dirt.tile_size up";
    let (name, nodes, per_binding) = (nodes_name(0), u64::from(capacity.max(1)), nodes_per_binding(gpu));
    if nodes <= per_binding {
        return Ok(vec![storage(gpu, &name, nodes * NODE_BYTES, nodes * NODE_BYTES, hint)?]);
    }
    let (parts, per_binding) =
        if Pipelines::can_split(gpu) { (NODE_PARTS, nodes_per_part(gpu)) } else { (1, per_binding) };
    if nodes > per_binding * parts {
        return Err(TracerError::TooLarge {
            name: if parts > 1 { format!("{name}, in {parts} parts,") } else { name },
            bytes: nodes * NODE_BYTES,
            limit: per_binding * parts * NODE_BYTES,
            hint: hint.to_owned(),
        });
    }
    let part = |index: u64| {
        let of_part = (nodes - (per_binding * index).min(nodes)).min(per_binding).max(1);
        storage(gpu, &nodes_name(index as usize), of_part * NODE_BYTES, of_part * NODE_BYTES, hint)
    };
    (0..NODE_PARTS).map(part).collect()
}

impl Buffers {
    /// Room for so many nodes, with the setup of `there` where it serves.
    pub(crate) fn new(
        pipelines: &Pipelines,
        layout: &Layout,
        triangle_count: u32,
        node_capacity: u32,
        there: Option<&TriangleSetup>,
    ) -> Result<Self, TracerError> {
        let gpu = &*pipelines.gpu;
        let ([bounds_bytes, _], [heads_bytes, _]) = (layout.bounds_bytes(), layout.heads_bytes());
        let by_view = bounds_bytes.max(heads_bytes) > gpu.limits.max_storage_buffer_binding_size;
        let bound = |whole, of_view| if by_view && Pipelines::can_split(gpu) { of_view } else { whole };
        let (views, sums) = (layout.views.len(), pipelines.prefix_sum()?);
        let drawn = layout.raster_backend == RasterBackend::Raster;
        Ok(Self {
            bounds: storage(gpu, DEPTH_BOUNDS, bounds_bytes, bound(bounds_bytes, layout.bounds_part_bytes()), HINT)?,
            heads: storage(gpu, HEADS, heads_bytes, bound(heads_bytes, layout.heads_part_bytes()), HINT)?,
            parts: Parts { views, bounds: layout.bounds_part_bytes(), heads: layout.heads_part_bytes() },
            by_view,
            nodes: node_buffers(gpu, node_capacity)?,
            taken: storage(gpu, NODE_COUNT, 4, 4, "nothing")?,
            setup: TriangleSetup::new(gpu, &sums, views, triangle_count, there)?,
            attachment: drawn.then(|| EmptyTarget::new(gpu, ATTACHMENT, layout.tiles)).transpose()?,
            node_capacity,
            nodes_per_part: nodes_per_part(gpu) as u32,
        })
    }

    /// Makes room for so many nodes.
    pub(crate) fn set_capacity(&mut self, gpu: &Gpu, nodes: u32) -> Result<(), TracerError> {
        self.nodes = node_buffers(gpu, nodes)?;
        self.node_capacity = nodes.max(1);
        Ok(())
    }

    /// Whether nodes lie in several buffers, or depth bounds and heads must be bound by view.
    pub(crate) fn is_split(&self) -> bool {
        self.by_view || self.nodes.len() > 1
    }

    /// A view's depth bounds.
    pub(crate) fn bounds_of(&self, view: usize) -> BindingResource<'_> {
        part_of(&self.bounds, view.min(self.parts.views - 1), self.parts.bounds)
    }

    /// A view's heads.
    pub(crate) fn heads_of(&self, view: usize) -> BindingResource<'_> {
        part_of(&self.heads, view.min(self.parts.views - 1), self.parts.heads)
    }

    /// What a search reads at unrelated places, in buffers or in textures that serve if `there` are those of the last build. Of
    /// buffers that are split it reads corners alone like that.
    pub(crate) fn arrays(
        &self,
        gpu: &Gpu,
        memory_access: MemoryAccess,
        there: &[Readable],
    ) -> Result<Vec<Readable>, TracerError> {
        let built = |index, slot, buffer: &Buffer, copy_name| {
            Readable::built(gpu, memory_access, slot, buffer, buffer.size(), copy_name, there.get(index), HINT)
        };
        let mut arrays = vec![built(0, ReadSlot::Quads0, self.setup.vertices(), VERTICES_COPY)?];
        if memory_access == MemoryAccess::Texture || !self.is_split() {
            arrays.push(match &self.nodes[..] {
                [nodes] => built(1, ReadSlot::Pairs0, nodes, NODES_COPY)?,
                _ => Readable::joined(gpu, ReadSlot::Pairs0, &self.filled(), NODES_COPY, there.get(1), HINT)?,
            });
            arrays.push(built(2, ReadSlot::Pairs1, &self.bounds, BOUNDS_COPY)?);
            arrays.push(built(3, ReadSlot::Words0, &self.heads, HEADS_COPY)?);
        }
        Ok(arrays)
    }

    /// The parts that nodes go to, with the bytes that there is room for in each.
    fn filled(&self) -> Vec<(&Buffer, u64)> {
        let mut left = u64::from(self.node_capacity) * NODE_BYTES;
        let filled = |buffer| {
            let bytes = left.min(Buffer::size(buffer));
            left -= bytes;
            (buffer, bytes)
        };
        self.nodes.iter().map(filled).filter(|(_, bytes)| *bytes > 0).collect()
    }

    /// What variants of shaders for split buffers bind beside the first parts: all places are taken, those of parts that do
    /// not exist by one that does.
    pub(crate) fn further_parts(&self) -> Vec<BindingResource<'_>> {
        let bounds = (1..MAX_VIEWS).map(|view| self.bounds_of(view));
        let heads = (1..MAX_VIEWS).map(|view| self.heads_of(view));
        let nodes =
            (1..NODE_PARTS as usize).map(|part| self.nodes.get(part).unwrap_or(&self.nodes[0]).as_entire_binding());
        bounds.chain(heads).chain(nodes).collect()
    }

    /// The uniform of the shaders.
    pub(crate) fn grid(&self, layout: &Layout) -> TileGrid {
        layout.grid(self.node_capacity, self.nodes_per_part)
    }
}

/// What a fill binds: made before the phases, which only record.
struct Prepared<'a> {
    setup: setup::Bound,
    depth: Vec<TrianglePass<'a>>,
    mipmaps: Vec<(BindGroup, u32)>,
    primitives: Vec<TrianglePass<'a>>,
}

impl Pipelines {
    fn prepare<'a>(
        &self,
        layout: &Layout,
        buffers: &'a Buffers,
        scene: &Resident,
        filling: Filling,
        counted: Option<&Buffer>,
        work: &'a [RasterWork],
    ) -> Result<Prepared<'a>, TracerError> {
        let gpu = &*self.gpu;
        let grid = uniform_buffer(gpu, "grid", &buffers.grid(layout))?;
        let setup = buffers.setup.bind(gpu, &self.setup()?, layout, &scene.surfaces.device)?;
        let mut prepared = Prepared { setup, depth: Vec::new(), mipmaps: Vec::new(), primitives: Vec::new() };
        let [of_depth, of_primitives] = fills(buffers, filling, counted.is_some());
        for (index, view) in layout.uniforms().into_iter().enumerate() {
            let by_plane = u32::from(filling.by_plane);
            let [first_entry, entries] = buffers.setup.room_of(index);
            let drawn = FillPass { view, by_plane, view_index: index as u32, first_entry, padding: 0 };
            let drawn = uniform_buffer(gpu, "drawn view", &drawn)?;
            let pass = |variant: Fill, more: Vec<BindingResource<'_>>| {
                let mut shared = vec![(0, &grid), (1, &drawn), (2, buffers.setup.vertices())];
                if layout.raster_backend == RasterBackend::Raster {
                    shared.push((3, buffers.setup.drawn()));
                }
                let shared = shared.into_iter().map(|(binding, buffer)| (binding, buffer.as_entire_binding()));
                let resources: Vec<_> = shared.chain((4..).zip(more)).collect();
                let canvas = Canvas::of(work.get(index), buffers.attachment.as_ref(), entries * filling.vertices())?;
                self.fill.pass(gpu, variant, &resources, canvas)
            };
            prepared.depth.push(pass(of_depth, vec![buffers.bounds_of(index)])?);
            let lists = [&buffers.nodes[0], &buffers.taken].into_iter().chain(counted).chain(&buffers.nodes[1..]);
            let lists = lists.map(Buffer::as_entire_binding);
            let lists = [buffers.bounds_of(index), buffers.heads_of(index)].into_iter().chain(lists).collect();
            prepared.primitives.push(pass(of_primitives, lists)?);
        }
        let views = layout.views.len();
        // By view where one binding does not hold all, else all at once.
        let bound: Vec<_> = match buffers.by_view {
            true => (0..views).map(|view| (buffers.bounds_of(view), 1)).collect(),
            false => vec![(buffers.bounds.as_entire_binding(), views as u32)],
        };
        let mipmap = self.mipmap()?;
        for level in 1..layout.levels() {
            let [across, down] = layout.level_tiles(level);
            let made = MipmapLevel { level: level as u32, views: bound[0].1, padding: [0; 2] };
            let made = uniform_buffer(gpu, "level", &made)?;
            for (bounds, views) in &bound {
                let resources = [grid.as_entire_binding(), made.as_entire_binding(), bounds.clone()];
                let bindings = bind_group(gpu, &mipmap.get_bind_group_layout(0), &resources);
                prepared.mipmaps.push((bindings, across * down * views));
            }
        }
        Ok(prepared)
    }

    /// Records triangle setup alone, which tells how many triangles every view has.
    pub(crate) fn set_up(
        &self,
        layout: &Layout,
        buffers: &Buffers,
        scene: &Resident,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let pipelines = self.setup()?;
        let bound = buffers.setup.bind(&self.gpu, &pipelines, layout, &scene.surfaces.device)?;
        let sums = self.prefix_sum()?;
        buffers.setup.record(&pipelines, &sums, &bound, clock)
    }

    /// Records the whole build.
    pub(crate) fn build(
        &self,
        layout: &Layout,
        buffers: &Buffers,
        scene: &Resident,
        filling: Filling,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        self.build_counting(layout, buffers, scene, filling, None, clock)
    }

    /// The same, which counts parts stored and additions to the node count where there is something to count into.
    pub(crate) fn build_counting(
        &self,
        layout: &Layout,
        buffers: &Buffers,
        scene: &Resident,
        filling: Filling,
        counted: Option<&Buffer>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let image = |view| RasterImage::View { view, size: layout.tiles, touched: filling.conservative };
        let images = layout.uniforms().into_iter().map(image);
        let (device, triangles) = (&scene.surfaces.device, scene.triangle_count);
        let work = self.raster.prepare_all(&self.gpu, layout.raster_backend, images, device, triangles)?;
        let prepared = self.prepare(layout, buffers, scene, filling, counted, &work)?;
        let (setup, sums) = (self.setup()?, self.prefix_sum()?);
        buffers.setup.record(&setup, &sums, &prepared.setup, clock)?;
        RasterWork::record_all(&work, clock)?;
        clock.device_phase("fill depth", |encoder| {
            encoder.clear_buffer(&buffers.bounds, 0, None);
            prepared.depth.iter().for_each(|pass| pass.record(encoder));
        })?;
        let mipmap = self.mipmap()?;
        clock.device_phase("mipmap depth", |encoder| {
            for (bindings, tiles) in &prepared.mipmaps {
                dispatch_linear(encoder, &mipmap, bindings, *tiles, WORKGROUP_SIZE);
            }
        })?;
        clock.device_phase("fill primitives", |encoder| {
            encoder.clear_buffer(&buffers.heads, 0, None);
            encoder.clear_buffer(&buffers.taken, 0, None);
            prepared.primitives.iter().for_each(|pass| pass.record(encoder));
        })
    }
}

/// The variants of the two passes over all triangles.
fn fills(buffers: &Buffers, filling: Filling, counters: bool) -> [Fill; 2] {
    let conservative = filling.conservative;
    let primitives = match counters {
        true => Fill::PrimitivesCounters { conservative },
        false => Fill::Primitives { conservative, split: buffers.nodes.len() > 1 },
    };
    [Fill::Plain { conservative }, primitives]
}
