enable wgpu_ray_query;

// Traces by the device's own ray queries: the driver builds and traverses the hierarchy and tests the triangles. Of hits
// at equal t a query takes whichever it meets first; where the lower primitive is wanted, a second query looks closely
// round the hit.

#import tracebench::types::{Ray, Hit, miss, STATUS_HIT, STATUS_MISS}
#import tracebench::dispatch::{Invocation, linear_invocation}

struct QuerySettings {
    ray_count: u32,
    // 1: any hit ends a query.
    any_hit: u32,
    // 1: of hits at equal t the lower primitive is wanted.
    lowest_of_equal: u32,
    // From scene units to those of the acceleration structure, and back: powers of two.
    scale: f32,
    unscale: f32,
    // The largest t in scene units that the scale keeps finite.
    max_t: f32,
}

@group(0) @binding(0) var<uniform> settings: QuerySettings;
@group(0) @binding(1) var scene: acceleration_structure;
@group(0) @binding(2) var<storage, read> rays: array<Ray>;
@group(0) @binding(3) var<storage, read_write> hits: array<Hit>;
// Of every ray: how often the traversal was told to proceed.
@group(0) @binding(4) var<storage, read_write> counts: array<u32>;

// A bit a triangle: offered to any ray.
@group(0) @binding(5) var<storage, read_write> offered: array<atomic<u32>>;

const WORKGROUP_SIZE: u32 = 64u;
// Every instance counts.
const EVERY_INSTANCE: u32 = 0xffu;
// Half of the span of t that is looked over for equal hits, over t: more than a box's planes are rounded by.
const EQUAL_SPAN: f32 = 1e-5;

fn describe(ray: Ray, flags: u32) -> RayDesc {
    return RayDesc(
        flags,
        EVERY_INSTANCE,
        ray.t_min * settings.scale,
        min(ray.t_max, settings.max_t) * settings.scale,
        ray.origin * settings.scale,
        ray.direction,
    );
}

fn hit_of(found: RayIntersection) -> Hit {
    return Hit(found.t * settings.unscale, found.primitive_index, found.barycentrics.x, found.barycentrics.y, STATUS_HIT);
}

fn lowest_of_equal(ray: Ray, nearest: RayIntersection) -> RayIntersection {
    var best = nearest;
    var description = describe(ray, RAY_FLAG_FORCE_NO_OPAQUE);
    description.tmin = max(description.tmin, nearest.t - nearest.t * EQUAL_SPAN);
    description.tmax = min(description.tmax, nearest.t + nearest.t * EQUAL_SPAN);
    var query: ray_query;
    rayQueryInitialize(&query, scene, description);
    // Nothing is confirmed, so every triangle of the span is offered.
    while (rayQueryProceed(&query)) {
        let offered = rayQueryGetCandidateIntersection(&query);
        if (offered.t == nearest.t && offered.primitive_index < best.primitive_index) {
            best = offered;
        }
    }
    return best;
}

fn answer(ray: Ray) -> Hit {
    let any_hit = settings.any_hit == 1u;
    let flags = select(RAY_FLAG_FORCE_OPAQUE, RAY_FLAG_FORCE_OPAQUE | RAY_FLAG_TERMINATE_ON_FIRST_HIT, any_hit);
    var query: ray_query;
    rayQueryInitialize(&query, scene, describe(ray, flags));
    while (rayQueryProceed(&query)) {}
    let found = rayQueryGetCommittedIntersection(&query);
    if (found.kind == RAY_QUERY_INTERSECTION_NONE) {
        return miss(STATUS_MISS);
    }
    if (any_hit || settings.lowest_of_equal == 0u) {
        return hit_of(found);
    }
    return hit_of(lowest_of_equal(ray, found));
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index < settings.ray_count) {
        hits[index] = answer(rays[index]);
    }
}

// The driver tells of no node that it visits. What can be counted is how often a traversal hands control back when it is
// asked before every triangle that it would take: once a triangle nearer than the last, and once at its end; and which triangles were so
// offered. It offers none that it tests and a ray misses, so that what is touched is not told.
@compute @workgroup_size(WORKGROUP_SIZE)
fn trace_counted(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= settings.ray_count) {
        return;
    }
    hits[index] = answer(rays[index]);
    var proceeds = 1u;
    var query: ray_query;
    rayQueryInitialize(&query, scene, describe(rays[index], RAY_FLAG_FORCE_NO_OPAQUE));
    while (rayQueryProceed(&query)) {
        proceeds += 1u;
        let candidate = rayQueryGetCandidateIntersection(&query).primitive_index;
        atomicOr(&offered[candidate >> 5u], 1u << (candidate & 31u));
        rayQueryConfirmIntersection(&query);
        if (settings.any_hit == 1u) {
            break;
        }
    }
    counts[index] = proceeds;
}

// For validation: the hit of each ray on the triangle of its own number, whatever lies before it.
@compute @workgroup_size(WORKGROUP_SIZE)
fn find_own_triangle(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= settings.ray_count) {
        return;
    }
    var hit = miss(STATUS_MISS);
    var query: ray_query;
    rayQueryInitialize(&query, scene, describe(rays[index], RAY_FLAG_FORCE_NO_OPAQUE));
    while (rayQueryProceed(&query)) {
        let offered = rayQueryGetCandidateIntersection(&query);
        if (offered.primitive_index == index) {
            hit = hit_of(offered);
        }
    }
    hits[index] = hit;
}
