#define_import_path tracebench::types

// The layouts of tracebench-api's Ray, Hit and Surface; a test holds the offsets against the Rust structs.

struct Ray {
    origin: vec3<f32>,
    t_min: f32,
    direction: vec3<f32>,
    t_max: f32,
}

struct Hit {
    t: f32,
    primitive: u32,
    u: f32,
    v: f32,
    status: u32,
}

const NO_PRIMITIVE: u32 = 0xffffffffu;

// The codes of tracebench-api's Status.
const STATUS_UNWRITTEN: u32 = 0u;
const STATUS_HIT: u32 = 1u;
const STATUS_MISS: u32 = 2u;
const STATUS_LEFT_VIEWS: u32 = 3u;
const STATUS_STEP_CAP: u32 = 4u;
const STATUS_THICKNESS_REJECTED: u32 = 5u;
const STATUS_BEHIND_LAST_LAYER: u32 = 6u;
const STATUS_INPAINTED: u32 = 7u;

struct Surface {
    position: vec3<f32>,
    material: u32,
    normal: vec3<f32>,
    status: u32,
}

// The codes of tracebench-api's SurfaceStatus.
const SURFACE_WRITTEN: u32 = 1u;
const SURFACE_NO_HIT: u32 = 2u;
const SURFACE_LOST: u32 = 3u;

fn no_surface(status: u32) -> Surface {
    return Surface(vec3<f32>(0.0), 0u, vec3<f32>(0.0), status);
}

// Whether a status is that of a hit.
fn is_hit(status: u32) -> bool {
    return status == STATUS_HIT || status == STATUS_INPAINTED;
}

fn miss(status: u32) -> Hit {
    return Hit(0.0, NO_PRIMITIVE, 0.0, 0.0, status);
}
