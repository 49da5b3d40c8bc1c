//! The steps from triangles to a CWBVH or a binary hierarchy, each a timed phase: those of obvhs's `build_cwbvh_from_tris`
//! and `build_bvh2_from_tris`, taken one by one so that their times and what they hold can be told.

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;
use tracebench_api::{Ledger, PhaseClock};

/// Most triangles in a leaf that a CWBVH node can name.
const MAX_PER_WIDE_LEAF: u32 = 3;

/// Most triangles in a leaf of obvhs's binary hierarchy.
const MAX_PER_BINARY_LEAF: u32 = 255;

/// Builds a CWBVH and enters what the steps hold for a while into the ledger: boxes, the builder's buffers and the binary
/// hierarchy. What obvhs allocates inside reinsertion and conversion is not seen from here.
pub(crate) fn build_wide(
    triangles: &[Triangle],
    config: BvhBuildParams,
    ledger: &mut Ledger,
    clock: &mut PhaseClock<'_>,
) -> CwBvh {
    let mut binary = cluster(triangles, config, ledger, clock);
    let held = borrow_binary(&binary, ledger);
    clock.host_phase("reinsert subtrees", || {
        ReinsertionOptimizer::default().run(&mut binary, config.reinsertion_batch_ratio, None);
    });
    let wide = clock.host_phase("convert to CWBVH", || {
        bvh2_to_cwbvh(&binary, config.max_prims_per_leaf.clamp(1, MAX_PER_WIDE_LEAF), true, false)
    });
    ledger.return_transient(held);
    wide
}

/// Builds a binary hierarchy by the steps of obvhs's `build_bvh2_from_tris`; the ledger is told as by [`build_wide`].
pub(crate) fn build_binary(
    triangles: &[Triangle],
    config: BvhBuildParams,
    ledger: &mut Ledger,
    clock: &mut PhaseClock<'_>,
) -> Bvh2 {
    let mut binary = cluster(triangles, config, ledger, clock);
    let held = borrow_binary(&binary, ledger);
    let mut optimizer = ReinsertionOptimizer::default();
    clock.host_phase("reinsert subtrees", || optimizer.run(&mut binary, config.reinsertion_batch_ratio, None));
    clock.host_phase("collapse leaves", || {
        let most = config.max_prims_per_leaf.clamp(1, MAX_PER_BINARY_LEAF);
        collapse(&mut binary, most, config.collapse_traversal_cost);
    });
    clock.host_phase("reinsert subtrees again", || {
        let ratio = config.reinsertion_batch_ratio * config.post_collapse_reinsertion_batch_ratio_multiplier;
        optimizer.run(&mut binary, ratio, None);
    });
    ledger.return_transient(held);
    binary
}

/// The first binary hierarchy, over split triangles if the configuration says so.
fn cluster(triangles: &[Triangle], config: BvhBuildParams, ledger: &mut Ledger, clock: &mut PhaseClock<'_>) -> Bvh2 {
    let mut binary = if config.pre_split {
        let (boxes, indices) = clock.host_phase("split large triangles", || split(triangles));
        let bytes = bytes_of(boxes.capacity(), size_of::<Aabb>());
        ledger.borrow_transient(bytes);
        let binary = ploc(&boxes, indices, config, ledger, clock);
        ledger.return_transient(bytes);
        binary
    } else {
        let indices = (0..triangles.len() as u32).collect();
        ploc(triangles, indices, config, ledger, clock)
    };
    binary.uses_spatial_splits = config.pre_split;
    binary
}

/// Enters a binary hierarchy's bytes as transient and gives them.
fn borrow_binary(binary: &Bvh2, ledger: &mut Ledger) -> u64 {
    let held = bytes_of(binary.nodes.capacity(), size_of::<Bvh2Node>())
        + bytes_of(binary.primitive_indices.capacity(), size_of::<u32>())
        + bytes_of(binary.parents.capacity(), size_of::<u32>());
    ledger.borrow_transient(held);
    held
}

fn ploc<T: obvhs::Boundable>(
    primitives: &[T],
    indices: Vec<u32>,
    config: BvhBuildParams,
    ledger: &mut Ledger,
    clock: &mut PhaseClock<'_>,
) -> Bvh2 {
    let (builder, binary) = clock.host_phase("build binary hierarchy (PLOC)", || {
        let mut builder = PlocBuilder::with_capacity(primitives.len());
        let binary = builder.build(
            config.ploc_search_distance,
            primitives,
            indices,
            config.sort_precision,
            config.search_depth_threshold,
        );
        (builder, binary)
    });
    let held = bytes_of(builder.current_nodes.capacity(), size_of::<Bvh2Node>())
        + bytes_of(builder.next_nodes.capacity(), size_of::<Bvh2Node>())
        + bytes_of(builder.mortons.capacity(), size_of::<[u128; 2]>())
        + bytes_of(builder.local_aabbs.capacity(), size_of::<Aabb>())
        + bytes_of(binary.nodes.capacity(), size_of::<Bvh2Node>());
    ledger.borrow_transient(held);
    ledger.return_transient(held);
    binary
}

/// Boxes of all triangles, several for the large ones, with the triangle that each belongs to.
fn split(triangles: &[Triangle]) -> (Vec<Aabb>, Vec<u32>) {
    let mut boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
    let mut indices: Vec<u32> = (0..triangles.len() as u32).collect();
    let areas = boxes.iter().map(Aabb::half_area);
    let (sum, largest) = areas.fold((0.0, 0.0), |(sum, largest): (f32, f32), area| (sum + area, largest.max(area)));
    split_aabbs_preset(&mut boxes, &mut indices, triangles, sum / triangles.len() as f32, largest);
    (boxes, indices)
}

fn bytes_of(count: usize, element: usize) -> u64 {
    (count * element) as u64
}
