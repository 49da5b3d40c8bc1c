//! The parameters of `fragment-abuffer`.

use tracebench_api::{Description, Domain, Invalidation, ParameterDescription, ParameterScope, Residency, Value};

const ON_OFF: &[&str] = &["on", "off"];
const STORAGES: &[&str] = &["s-buffer", "ll", "dll", "llb", "dllb"];
const VIEWS: &[&str] = &["seven", "six", "frame"];
const LAYERS: &[&str] = &["all", "one"];
const BOUNDS: &[&str] = &["geometry", "boxes"];
const CENTRES: &[&str] = &["pulled_back", "eye"];
const MARCHES: &[&str] = &["steps", "pixels", "hi-z"];
const SPANS: &[&str] = &["step", "pixel"];
const THICK: &[&str] = &["behind", "before"];
const UNITS: &[&str] = &["diagonals", "pixels"];

fn choice(
    name: &'static str,
    scope: ParameterScope,
    names: &'static [&'static str],
    published: &str,
    effect: &'static str,
) -> ParameterDescription {
    ParameterDescription {
        name,
        unit: "",
        scope,
        domain: Domain::Choice(names),
        published: Value::Choice(published.to_owned()),
        improved: Value::Choice(published.to_owned()),
        effect,
        sweep: names.iter().map(|name| Value::Choice((*name).to_owned())).collect(),
    }
}

fn integer(
    name: &'static str,
    scope: ParameterScope,
    range: [i64; 2],
    published: i64,
    effect: &'static str,
    sweep: &[i64],
) -> ParameterDescription {
    ParameterDescription {
        name,
        unit: "",
        scope,
        domain: Domain::Integer { least: range[0], greatest: range[1] },
        published: Value::Integer(published),
        improved: Value::Integer(published),
        effect,
        sweep: sweep.iter().copied().map(Value::Integer).collect(),
    }
}

fn real(
    name: &'static str,
    unit: &'static str,
    greatest: f64,
    published: f64,
    effect: &'static str,
    sweep: &[f64],
) -> ParameterDescription {
    ParameterDescription {
        name,
        unit,
        scope: ParameterScope::Trace,
        domain: Domain::Real { least: 0.0, greatest },
        published: Value::Real(published),
        improved: Value::Real(published),
        effect,
        sweep: sweep.iter().copied().map(Value::Real).collect(),
    }
}

/// What shapes the structure.
fn of_builds() -> Vec<ParameterDescription> {
    use ParameterScope::Build;
    vec![
        choice(
            "storage",
            Build,
            STORAGES,
            "dllb",
            "how a pixel keeps its fragments (section 4.3): s-buffer, a contiguous piece by count and prefix sum; ll and dll, a \
             list linked one way or both; llb and dllb, such lists in depth buckets",
        ),
        integer(
            "buckets",
            Build,
            [1, 64],
            4,
            "B, depth buckets of a pixel, uniform in eye depth, of llb and dllb: more have shorter lists and more pointers",
            &[1, 2, 4, 8, 12, 16],
        ),
        choice(
            "decoupled",
            Build,
            ON_OFF,
            "on",
            "whether what shading needs lies in a buffer of its own (section 3.3), or in the nodes that searches read",
        ),
        choice(
            "views",
            Build,
            VIEWS,
            "seven",
            "the camera's view and six cube faces, the faces alone, or the camera's view alone (Figures 7 to 9)",
        ),
        choice("layers", Build, LAYERS, "all", "every fragment of a pixel, or the nearest alone (Figures 8 and 9)"),
        choice(
            "bounds",
            Build,
            BOUNDS,
            "geometry",
            "what draws the depth bounds that buckets divide (section 3.3): the scene, or the bounding boxes of its objects, \
             which are looser",
        ),
        choice(
            "centre",
            Build,
            CENTRES,
            "pulled_back",
            "where the faces' centres lie: pulled back by the near distance (section 3.2), or in the eye, which loses what \
             lies before near",
        ),
        choice(
            "march",
            Build,
            MARCHES,
            "steps",
            "how a ray goes over the pixels of a view: in a fixed number of steps, over each that it crosses, or up and down a \
             pyramid of depth bounds, which is built for it (section 3.4)",
        ),
    ]
}

/// What shapes the search.
fn of_traces() -> Vec<ParameterDescription> {
    use ParameterScope::Trace;
    vec![
        ParameterDescription {
            unit: "steps a view",
            ..integer(
                "view_steps",
                Trace,
                [1, 65_536],
                100,
                "steps of a ray in a view where march is steps, fewer where it crosses fewer pixels: fewer are faster and miss more",
                &[12, 25, 50, 100, 200, 400, 800],
            )
        },
        choice(
            "jitter",
            Trace,
            ON_OFF,
            "on",
            "where in its steps a ray looks at the image: at an offset that is fixed for the ray, or in their middles",
        ),
        choice(
            "span",
            Trace,
            SPANS,
            "step",
            "the depths that a step asks for: those that the ray has along the step, or within the pixel that is looked at, which \
             leaves out what lies between pixels looked at",
        ),
        choice(
            "skipping",
            Trace,
            ON_OFF,
            "on",
            "whether pixels, buckets and rest of lists that cannot hold a hit are skipped (section 3.4); the hits are the same",
        ),
        real(
            "thickness",
            "scene diagonals, or pixels",
            1e4,
            0.0,
            "depth beyond a ray's own within which a fragment still counts: 0 as section 3.4 has it, which lets rays through \
             between fragments; more closes gaps and invents hits",
            &[0.0, 0.0001, 0.0003, 0.001, 0.003, 0.01, 0.02, 0.05, 0.1],
        ),
        choice(
            "thickness_in",
            Trace,
            UNITS,
            "diagonals",
            "the unit of thickness: diagonals of the scene's bounds, or widths of a pixel where the ray is",
        ),
        choice(
            "thickness_side",
            Trace,
            THICK,
            "behind",
            "where fragments are thick: behind their depth, so that each is a voxel that begins at the surface, or before it, so \
             that a ray finds what lies ahead of it",
        ),
        real(
            "start_bias",
            "pixels",
            64.0,
            1.0,
            "pixels along the major axis skipped by rays that start in a view: small finds the surface that a ray starts on, \
             large misses what lies close to it",
            &[0.0, 0.5, 1.0, 2.0, 4.0],
        ),
        ParameterDescription {
            unit: "fragments",
            ..integer(
                "binary_search_above",
                Trace,
                [0, 1 << 20],
                16,
                "fragments of a pixel of the s-buffer beyond which they are searched by halving (section 4.3), up to which one by one",
                &[0, 4, 16, 64, 1 << 20],
            )
        },
        ParameterDescription {
            unit: "pixels",
            ..integer(
                "max_steps",
                Trace,
                [1, 1 << 20],
                1 << 14,
                "pixels, or cells of the pyramid, after which a ray is given up with status step_cap, as one is that the driver's \
                 own limit of loops cuts off",
                &[64, 256, 1024, 4096, 16_384],
            )
        },
    ]
}

/// What `fragment-abuffer` is and takes.
pub fn description() -> Description {
    let mut parameters = of_builds();
    parameters.extend(of_traces());
    Description {
        name: "fragment-abuffer",
        citation: "Vardis, Vasilakis, Papaioannou: A Multiview and Multilayer Approach for Interactive Ray Tracing, I3D 2016",
        summary: "every fragment of the pixels of seven views, in lists by depth, rays marched over the images",
        residency: Residency::Device,
        invalidated_by: &[Invalidation::Geometry, Invalidation::Viewpoint, Invalidation::Resolution],
        names_primitives: false,
        parameters,
    }
}
