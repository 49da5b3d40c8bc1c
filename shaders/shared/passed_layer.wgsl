#define_import_path tracebench::passed_layer

// What lies behind a layer that was drawn before (depth peeling; Everitt, "Interactive Order-Independent Transparency", NVIDIA, 2001).

struct Passing {
    // Scene units: what is nearer to the layer before counts as that (Mara, McGuire, Luebke, "Lighting Deep G-Buffers", NVIDIA, 2013).
    separation: f32,
    // 1: faces that turn their back to the eye alone.
    backs_only: u32,
    padding: vec2<u32>,
}

@group(0) @binding(3) var<uniform> passing: Passing;
@group(0) @binding(4) var passed: texture_2d<f32>;

// What the same surface's depth may differ by between two passes, share: their pipelines are two, which a driver may round in two ways.
const PASS_SLACK: f32 = 4e-6;

// Whether a depth at a pixel, of a triangle that shows its back there or not, lies behind the layer.
fn lies_behind(depth: f32, at: vec2<i32>, shows_back: bool) -> bool {
    let before = textureLoad(passed, at, 0).x;
    return depth > before * (1.0 + PASS_SLACK) + passing.separation && (passing.backs_only == 0u || shows_back);
}
