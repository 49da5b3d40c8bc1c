//! The build of a packed structure on the device.

use tracebench_api::wgpu::{BindGroup, Buffer, ComputePipeline};
use tracebench_api::{DeviceGeometry, Gpu, PhaseClock, TracerError};
use tracebench_kit::{bind_group_at, dispatch_linear, uniform_buffer};

use super::buffers::BuildBuffers;
use super::kernels::{BuildKernels, SortKernels};
use super::layout::{FACES, FIRST_NEAR, MISPLACED, PackedGrid, PackedLayout};
use crate::description::Lists;
use crate::layout::MipmapLevel;

/// As `WORKGROUP_SIZE` in shaders/dirt/part_lists.wgsl and part_trees.wgsl.
pub(super) const WORKGROUP_SIZE: u32 = 64;
/// As `LARGE_WORKGROUPS` in shaders/dirt/part_lists.wgsl.
pub(super) const LARGE_WORKGROUPS: u32 = 256;

/// How far a build goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    /// Until parts are counted.
    Counted,
    /// Until rays can be traced.
    Whole,
}

/// What a build binds: made before the phases, which only record.
struct Bound {
    measure: BindGroup,
    scale: BindGroup,
    count: BindGroup,
    count_several: BindGroup,
    count_large: BindGroup,
    store: BindGroup,
    store_several: BindGroup,
    store_large: BindGroup,
    bound: BindGroup,
    size: BindGroup,
    /// Of trees, their last nodes; of slices, where lists begin.
    leaves: BindGroup,
    join: BindGroup,
    /// Each with the cells of its level.
    masks: Vec<(BindGroup, u32)>,
}

/// Bytes of the uniforms of a build, which are kept until it is done.
pub(super) fn uniform_bytes(layout: &PackedLayout) -> u64 {
    (size_of::<PackedGrid>() + (layout.levels() - 1) * size_of::<MipmapLevel>()) as u64
}

/// What is built, of what, and into what.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    pub layout: &'a PackedLayout,
    pub buffers: &'a BuildBuffers,
    pub scene: &'a DeviceGeometry,
}

fn bind(gpu: &Gpu, work: Work<'_>, kernels: &BuildKernels) -> Result<Bound, TracerError> {
    let Work { layout, buffers, scene } = work;
    let grid = uniform_buffer(gpu, "packed grid", &buffers.grid(layout))?;
    let of = |pipeline: &ComputePipeline, bindings: &[(u32, &Buffer)]| {
        let resources: Vec<_> =
            bindings.iter().map(|(binding, buffer)| (*binding, buffer.as_entire_binding())).collect();
        bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources)
    };
    let BuildBuffers { quads, masks, counts, plans, node_counts, words, keys, parts, places, nodes, .. } = buffers;
    let [quads, masks, counts, plans] = [quads, masks, counts, plans].map(|room| &room.buffer);
    let [node_counts, words, keys, parts] = [node_counts, words, keys, parts].map(|room| &room.buffer);
    let [places, nodes] = [places, nodes].map(|room| &room.buffer);
    // In part_lists.
    let counted = [(0, &grid), (3, quads), (4, words), (5, counts), (6, plans)];
    let stored = [&counted[..], &[(7, keys), (8, parts), (9, places), (10, masks)]].concat();
    // In part_trees, which has numbers of its own.
    let sorted = [(0, &grid), (2, keys), (3, places), (4, parts), (5, quads)];
    let mask = |level: usize| -> Result<(BindGroup, u32), TracerError> {
        let made = MipmapLevel { level: level as u32, views: FACES, padding: [0; 2] };
        let made = uniform_buffer(gpu, "level of masks", &made)?;
        Ok((of(&kernels.join_masks, &[(0, &grid), (1, &made), (7, masks)]), FACES * layout.cells_of_level(level)))
    };
    let by_slices = layout.lists == Lists::Slices;
    // Of lists nothing is joined, only where they begin is noted.
    let joined = [(0, &grid), (5, quads), (8, node_counts), (9, nodes)];
    Ok(Bound {
        measure: of(
            &kernels.measure,
            &[(0, &grid), (1, &scene.positions), (2, &scene.indices), (3, quads), (4, words)],
        ),
        scale: of(&kernels.scale, &[(0, &grid), (4, words)]),
        count: of(&kernels.count, &counted),
        count_several: of(&kernels.count_several, &counted),
        count_large: of(&kernels.count_large, &counted),
        store: of(&kernels.store, &stored),
        store_several: of(&kernels.store_several, &stored),
        store_large: of(&kernels.store_large, &stored),
        bound: of(&kernels.bound, &[&sorted[..], &[(6, words)]].concat()),
        size: of(&kernels.size, &[(0, &grid), (5, quads), (6, words), (7, masks), (8, node_counts)]),
        leaves: match by_slices {
            true => of(&kernels.list, &[(0, &grid), (2, keys), (7, masks), (8, node_counts), (10, nodes)]),
            false => of(&kernels.leaves, &[&sorted[..], &[(8, node_counts), (9, nodes)]].concat()),
        },
        join: of(&kernels.join, if by_slices { &joined[..3] } else { &joined }),
        masks: (1..layout.levels()).map(mask).collect::<Result<_, _>>()?,
    })
}

/// Records a build.
pub(super) fn record(
    gpu: &Gpu,
    work: Work<'_>,
    kernels: &BuildKernels,
    sorts: &SortKernels,
    extent: Extent,
    clock: &mut PhaseClock<'_>,
) -> Result<(), TracerError> {
    let Work { layout, buffers, scene } = work;
    for (name, buffer) in [("vertex positions", &scene.positions), ("vertex indices", &scene.indices)] {
        gpu.check_storage_binding(name, buffer.size(), "the scene's triangle count")?;
    }
    let bound = bind(gpu, work, kernels)?;
    let sorting = sorts.sorting();
    let triangles = buffers.triangle_count;
    let (tiles, [parts, _]) = (layout.tile_count(), buffers.capacities);
    let large = LARGE_WORKGROUPS * WORKGROUP_SIZE;
    clock.device_phase("triangle setup", |encoder| {
        encoder.clear_buffer(&buffers.words.buffer, 0, Some(u64::from(FIRST_NEAR) * 4));
        dispatch_linear(encoder, &kernels.measure, &bound.measure, triangles, WORKGROUP_SIZE);
        dispatch_linear(encoder, &kernels.scale, &bound.scale, 1, 1);
    })?;
    clock.device_phase("count parts", |encoder| {
        encoder.clear_buffer(&buffers.counts.buffer, 0, None);
        encoder.clear_buffer(&buffers.plans.buffer, 0, Some(u64::from(triangles) * 8));
        dispatch_linear(encoder, &kernels.count, &bound.count, triangles, WORKGROUP_SIZE);
        dispatch_linear(encoder, &kernels.count_several, &bound.count_several, triangles, WORKGROUP_SIZE);
        dispatch_linear(encoder, &kernels.count_large, &bound.count_large, large, WORKGROUP_SIZE);
        sorting.sums.record(encoder, &buffers.count_sums);
        encoder.copy_buffer_to_buffer(&buffers.counts.buffer, u64::from(triangles) * 4, &buffers.totals.buffer, 0, 4);
    })?;
    if extent == Extent::Counted {
        return Ok(());
    }
    clock.device_phase("store parts", |encoder| {
        encoder.clear_buffer(&buffers.keys.buffer, 0, None);
        encoder.clear_buffer(&buffers.masks.buffer, 0, None);
        dispatch_linear(encoder, &kernels.store, &bound.store, triangles, WORKGROUP_SIZE);
        dispatch_linear(encoder, &kernels.store_several, &bound.store_several, triangles, WORKGROUP_SIZE);
        dispatch_linear(encoder, &kernels.store_large, &bound.store_large, large, WORKGROUP_SIZE);
    })?;
    clock.device_phase("sort parts", |encoder| sorting.sort.record(encoder, &buffers.sort))?;
    clock.device_phase("build tiles", |encoder| {
        encoder.clear_buffer(&buffers.quads.buffer, 0, Some(u64::from(tiles) * 16));
        encoder.clear_buffer(&buffers.node_counts.buffer, 0, None);
        dispatch_linear(encoder, &kernels.bound, &bound.bound, parts, WORKGROUP_SIZE);
        for (bindings, cells) in &bound.masks {
            dispatch_linear(encoder, &kernels.join_masks, bindings, *cells, WORKGROUP_SIZE);
        }
        dispatch_linear(encoder, &kernels.size, &bound.size, tiles, WORKGROUP_SIZE);
        if layout.lists != Lists::Packed {
            sorting.sums.record(encoder, &buffers.node_sums);
            let end = u64::from(tiles) * 4;
            encoder.copy_buffer_to_buffer(&buffers.node_counts.buffer, end, &buffers.totals.buffer, 4, 4);
            let leaves = if layout.lists == Lists::Slices { &kernels.list } else { &kernels.leaves };
            dispatch_linear(encoder, leaves, &bound.leaves, parts, WORKGROUP_SIZE);
            dispatch_linear(encoder, &kernels.join, &bound.join, tiles, WORKGROUP_SIZE);
        }
        let misplaced = u64::from(MISPLACED) * 4;
        encoder.copy_buffer_to_buffer(&buffers.words.buffer, misplaced, &buffers.totals.buffer, 8, 4);
    })
}
