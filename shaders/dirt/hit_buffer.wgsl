#define_import_path tracebench::dirt_hit_buffer

// DIRT's hit buffer (section 4.2.1, "Final Storage"): a list of hits a pixel of a view at full resolution. One image of
// heads serves all views, as Table 3 counts it, so a list holds hits of any view at that pixel.

// 32 bytes. Node i is the hit of ray i, so there is room for all.
struct HitNode {
    // One more than the index of the next node, or 0 at the end.
    next: u32,
    primitive: u32,
    // Barycentric weights of the triangle's second and third corner.
    u: f32,
    v: f32,
    position: vec3<f32>,
    // Where the surface belongs in the shading buffer, and above it the view of the hit.
    shading_and_view: u32,
}

const SHADING_BITS: u32 = 29u;

fn shading_of(node: HitNode) -> u32 {
    return node.shading_and_view & ((1u << SHADING_BITS) - 1u);
}

fn view_of(node: HitNode) -> u32 {
    return node.shading_and_view >> SHADING_BITS;
}
