// One iteration of parallel locally-ordered clustering (PLOC: Meister, Bittner, TVCG 2018; PLOC++: Benthin, Drabinski,
// Tessari, Dittebrandt, HPG 2022): every cluster finds the neighbour along the Morton curve with which its box is least,
// pairs that find each other are merged, and what is left moves together, in order. Clusters are moved by run and not by
// workgroup, so nothing waits for anything within a kernel.
//
// Deviations: of equal boxes the neighbour whose place differs in lower bits is the nearest, so that equal clusters merge
// as a balanced tree, not as a list. An iteration that starts with more clusters than it may pairs places 2k and 2k + 1
// without asking, so that the number of iterations has a bound, and clusters that are too tall to be searched for wait for
// that, so that the depth has one. The last clusters are merged by one workgroup (`finish`).

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::bvh_build::{BinaryNode, Box, FINISHED, height, is_inner, parent_of}
#import tracebench::bvh_nearest::{four_of, compare}

struct Iteration {
    // Its number; of `finish` the number of iterations before.
    index: u32,
    // Of more clusters than these places pair up without asking.
    allowed: u32,
    // Neighbours on each side.
    search_radius: u32,
}

@group(0) @binding(0) var<uniform> iteration: Iteration;
@group(0) @binding(1) var<storage, read_write> progress: array<u32>;
@group(0) @binding(2) var<storage, read_write> clusters: array<BinaryNode>;
// Of each cluster the place of its nearest neighbour; its own for none.
@group(0) @binding(3) var<storage, read_write> nearest: array<u32>;
// Of each run: clusters that it leaves and pairs that it merges, then those of all runs before.
@group(0) @binding(4) var<storage, read_write> tallies: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> next_clusters: array<BinaryNode>;
// Pairs of siblings, the root's children first: a pair that is merged later stands before it.
@group(0) @binding(6) var<storage, read_write> nodes: array<BinaryNode>;

const WORKGROUP_SIZE: u32 = 64u;
// Clusters of a run, which one lane moves.
const RUN: u32 = 16u;
// Clusters for which one lane searches, two times four.
const SEARCHED: u32 = 8u;

// So many clusters or fewer are left to `finish`.
const LAST_CLUSTERS: u32 = 2048u;
// Levels that a search's private stack serves.
const MAX_LEVELS: u32 = 64u;

// Pairing alone merges count clusters in so many iterations. As long as no cluster is taller than what is left to
// MAX_LEVELS then, none will ever be: a pairing makes every cluster taller by one, and halves their number.
fn pairings_of(count: u32) -> u32 {
    return 32u - countLeadingZeros(count - 1u);
}

fn box_of(place: u32) -> Box {
    return Box(clusters[place].low, clusters[place].high);
}

// The nearest neighbours of the clusters from `first` on, as many as a lane searches for; of `paired` clusters their
// siblings; their own places for none.
fn seek(first: u32, count: u32, paired: bool) {
    let end = min(first + SEARCHED, count);
    if (paired) {
        for (var place = first; place < end; place++) {
            let sibling = place ^ 1u;
            nearest[place] = select(place, sibling, (sibling < count));
        }
        return;
    }
    // Beyond the last cluster that one stands in, for which nothing is kept.
    let last = count - 1u;
    var near = four_of(
        first,
        box_of(first),
        box_of(min(first + 1u, last)),
        box_of(min(first + 2u, last)),
        box_of(min(first + 3u, last)),
    );
    var far = four_of(
        first + 4u,
        box_of(min(first + 4u, last)),
        box_of(min(first + 5u, last)),
        box_of(min(first + 6u, last)),
        box_of(min(first + 7u, last)),
    );
    let radius = iteration.search_radius;
    let start = first - min(first, radius);
    let stop = min(first + SEARCHED - 1u + radius, last);
    for (var place = start; place <= stop; place++) {
        let other = box_of(place);
        compare(&near, radius, place, other);
        compare(&far, radius, place, other);
    }
    for (var place = first; place < end; place++) {
        let four = select(far.nearest, near.nearest, (place < first + 4u));
        let tall = height(clusters[place].count) + pairings_of(count) >= MAX_LEVELS;
        nearest[place] = select(four[(place - first) & 3u], place, tall);
    }
}

// Clusters that this iteration has to move; none once few are left.
fn clusters_to_move() -> u32 {
    let count = progress[iteration.index];
    return select(0u, count, (count > LAST_CLUSTERS));
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn search(invocation: Invocation) {
    let first = SEARCHED * linear_invocation(invocation, WORKGROUP_SIZE);
    let count = clusters_to_move();
    if (first < count) {
        seek(first, count, count > iteration.allowed);
    }
}

// A cluster that is merged into one before it, one that takes another in, one that stays.
const GOES: u32 = 0u;
const TAKES: u32 = 1u;
const STAYS: u32 = 2u;

fn role_of(place: u32) -> u32 {
    let other = nearest[place];
    if (other == place || nearest[other] != place) {
        return STAYS;
    }
    return select(GOES, TAKES, (place < other));
}

fn run_of(lane: u32, count: u32) -> vec2<u32> {
    return vec2<u32>(min(lane * RUN, count), min((lane + 1u) * RUN, count));
}

// Clusters that a run leaves, and pairs that it merges.
fn tally_of(run: vec2<u32>) -> vec2<u32> {
    var sum = vec2<u32>(0u);
    for (var place = run.x; place < run.y; place++) {
        let role = role_of(place);
        sum += select(vec2<u32>(0u), vec2<u32>(1u, 0u), (role != GOES));
        sum += select(vec2<u32>(0u), vec2<u32>(0u, 1u), (role == TAKES));
    }
    return sum;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn tally(invocation: Invocation) {
    let lane = linear_invocation(invocation, WORKGROUP_SIZE);
    let run = run_of(lane, clusters_to_move());
    if (run.x < run.y) {
        tallies[lane] = tally_of(run);
    }
}

const SUM_LANES: u32 = 256u;
const GROUP: u32 = 16u;

var<workgroup> lane_sums: array<vec2<u32>, SUM_LANES>;
var<workgroup> group_sums: array<vec2<u32>, SUM_LANES / GROUP>;

// What the lanes before one have.
fn before_lane(local: u32, own: vec2<u32>) -> vec2<u32> {
    lane_sums[local] = own;
    workgroupBarrier();
    if (local < SUM_LANES / GROUP) {
        var before = vec2<u32>(0u);
        for (var lane = local * GROUP; lane < (local + 1u) * GROUP; lane++) {
            let next = before + lane_sums[lane];
            lane_sums[lane] = before;
            before = next;
        }
        group_sums[local] = before;
    }
    workgroupBarrier();
    var before = lane_sums[local];
    for (var group = 0u; group < local / GROUP; group++) {
        before += group_sums[group];
    }
    return before;
}

// One workgroup: what lies before every run, and how many clusters the next iteration starts with.
@compute @workgroup_size(SUM_LANES)
fn add_up(@builtin(local_invocation_index) local: u32) {
    let count = clusters_to_move();
    let runs = (count + RUN - 1u) / RUN;
    let each = (runs + SUM_LANES - 1u) / SUM_LANES;
    let first = min(local * each, runs);
    let end = min(first + each, runs);
    var own = vec2<u32>(0u);
    for (var run = first; run < end; run++) {
        own += tallies[run];
    }
    var before = before_lane(local, own);
    for (var run = first; run < end; run++) {
        let next = before + tallies[run];
        tallies[run] = before;
        before = next;
    }
    if (local == SUM_LANES - 1u) {
        progress[iteration.index + 1u] = select(before.x, progress[iteration.index], (count == 0u));
    }
}

// Whether wide nodes are made of these.
override WIDE: bool;

fn stored(cluster: BinaryNode) -> BinaryNode {
    let count = select(cluster.count, 0xffffffffu, !WIDE && is_inner(cluster.count));
    return BinaryNode(cluster.low, cluster.first, cluster.high, count);
}

// Of n triangles n - count pairs were merged before an iteration that starts with count clusters; the last one of all is
// pair 0.
fn merge_pair(cluster: BinaryNode, other: BinaryNode, count: u32, rank: u32) -> BinaryNode {
    let pair = 2u * (count - 2u - rank);
    nodes[pair] = stored(cluster);
    nodes[pair + 1u] = stored(other);
    let low = min(cluster.low, other.low);
    return BinaryNode(low, pair, max(cluster.high, other.high), parent_of(cluster.count, other.count));
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn merge(invocation: Invocation) {
    let lane = linear_invocation(invocation, WORKGROUP_SIZE);
    let count = clusters_to_move();
    let run = run_of(lane, count);
    if (run.x >= run.y) {
        return;
    }
    var before = tallies[lane];
    for (var place = run.x; place < run.y; place++) {
        let role = role_of(place);
        if (role != GOES) {
            var cluster = clusters[place];
            if (role == TAKES) {
                cluster = merge_pair(cluster, clusters[nearest[place]], count, before.y);
                before.y += 1u;
            }
            next_clusters[before.x] = cluster;
            before.x += 1u;
        }
    }
}

// Clusters that a lane keeps at most.
const MAX_KEPT: u32 = LAST_CLUSTERS / SUM_LANES;
// Iterations that search. Those that follow pair what is left.
const MAX_SEARCHES: u32 = 116u;

var<workgroup> left: u32;

// One workgroup: iterations until one cluster is left.
@compute @workgroup_size(SUM_LANES)
fn finish(@builtin(local_invocation_index) local: u32) {
    var started = 0u;
    while (started < iteration.index && progress[started] > LAST_CLUSTERS) {
        started += 1u;
    }
    let all = progress[started];
    if ((started & 1u) == 1u) {
        for (var place = local; place < all; place += SUM_LANES) {
            clusters[place] = next_clusters[place];
        }
    }
    if (local == 0u) {
        left = all;
    }
    storageBarrier();
    var done = 0u;
    var previous = 0u;
    loop {
        let count = workgroupUniformLoad(&left);
        if (local == 0u) {
            progress[FINISHED + done] = count;
        }
        if (count < 2u) {
            break;
        }
        let each = (count + SUM_LANES - 1u) / SUM_LANES;
        let run = vec2<u32>(min(local * each, count), min((local + 1u) * each, count));
        // Where all are too tall to be searched for, nothing was merged.
        let paired = done >= MAX_SEARCHES || count == previous;
        if (SEARCHED * local < count) {
            seek(SEARCHED * local, count, paired);
        }
        storageBarrier();
        var before = before_lane(local, tally_of(run));
        let first = before.x;
        var kept: array<BinaryNode, MAX_KEPT>;
        for (var place = run.x; place < run.y; place++) {
            let role = role_of(place);
            if (role != GOES) {
                var cluster = clusters[place];
                if (role == TAKES) {
                    cluster = merge_pair(cluster, clusters[nearest[place]], count, before.y);
                    before.y += 1u;
                }
                kept[before.x - first] = cluster;
                before.x += 1u;
            }
        }
        storageBarrier();
        for (var place = first; place < before.x; place++) {
            clusters[place] = kept[place - first];
        }
        if (local == SUM_LANES - 1u) {
            left = before.x;
        }
        previous = count;
        done += 1u;
        storageBarrier();
    }
}
