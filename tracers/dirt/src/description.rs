//! The parameters of `dirt`.

use tracebench_api::{Description, Domain, Invalidation, ParameterDescription, ParameterScope, Residency, Value};

const TILE_SIZES: &[&str] = &["1", "2", "4", "8"];
const VIEWS: &[&str] = &["six", "frame"];
const CENTRES: &[&str] = &["pulled_back", "eye"];
const NEARS: &[&str] = &["viewpoint", "none"];
const COVERAGES: &[&str] = &["conservative", "standard"];
const CLIPS: &[&str] = &["polygon", "plane"];
const ACCEPTS: &[&str] = &["tile", "distance"];
const CENTRE_RAYS: &[&str] = &["whole", "split"];
const FETCHES: &[&str] = &["raster", "gather"];
const SEARCHED: &[&str] = &["until_hit", "all"];

/// What `dirt` is and takes.
pub fn description() -> Description {
    use ParameterScope::{Build, Trace};
    let integers = |values: &[i64]| values.iter().copied().map(Value::Integer).collect::<Vec<_>>();
    let choice = |name, scope, names: &'static [&'static str], published: &str, effect| ParameterDescription {
        name,
        unit: "",
        scope,
        domain: Domain::Choice(names),
        published: Value::Choice(published.to_owned()),
        improved: Value::Choice(published.to_owned()),
        effect,
        sweep: names.iter().map(|name| Value::Choice((*name).to_owned())).collect(),
    };
    let integer = |name, unit, scope, least, greatest, published, effect, sweep: &[i64]| ParameterDescription {
        name,
        unit,
        scope,
        domain: Domain::Integer { least, greatest },
        published: Value::Integer(published),
        improved: Value::Integer(published),
        effect,
        sweep: integers(sweep),
    };
    let tile_size = ParameterDescription {
        unit: "pixels",
        ..choice(
            "tile_size",
            Build,
            TILE_SIZES,
            "2",
            "S, pixels of a view along a tile's edge: larger tiles store and build less and have longer lists",
        )
    };
    Description {
        name: "dirt",
        citation: "Vardis, Vasilakis, Papaioannou: DIRT: Deferred Image-based Ray Tracing, HPG 2016",
        summary: "lists of triangles in depth buckets of the tiles of six views, analytic hits",
        residency: Residency::Device,
        invalidated_by: &[Invalidation::Geometry, Invalidation::Viewpoint, Invalidation::Resolution],
        names_primitives: true,
        parameters: vec![
            tile_size,
            integer(
                "buckets",
                "",
                Build,
                1,
                256,
                24,
                "B, depth buckets of a tile: more have shorter lists, and more heads and copies",
                &[1, 4, 8, 16, 24, 32, 40],
            ),
            choice("views", Build, VIEWS, "six", "six cube faces, or the camera's view alone (Figure 9)"),
            choice(
                "centre",
                Build,
                CENTRES,
                "pulled_back",
                "where the faces' centres lie: pulled back by the near distance (VVP16, section 3.2), or in the eye, which \
                 loses what lies before near",
            ),
            choice(
                "near",
                Build,
                NEARS,
                "viewpoint",
                "the near plane: the viewpoint's, or as good as none (a proof's aid: 1e-15 of far)",
            ),
            choice(
                "coverage",
                Build,
                COVERAGES,
                "conservative",
                "which tiles keep a triangle: all that it touches (section 4.1), or those whose centres it covers, which \
                 is meant for tile_size=1 and loses what lies between centres",
            ),
            choice(
                "clip",
                Build,
                CLIPS,
                "polygon",
                "a triangle's depths in a tile: those of the clipped polygon (section 4.1.1), or of its plane at the \
                 tile's corners, as in the released code: larger",
            ),
            choice(
                "direct_visibility",
                Build,
                &["off", "on"],
                "off",
                "whether the build also draws the surfaces that the camera's frame shows (section 4.1.3), where paths would \
                 begin; traces take rays from anywhere and do not use them",
            ),
            choice(
                "accept",
                Trace,
                ACCEPTS,
                "tile",
                "when a hit counts: where its tile is the one searched (Algorithm 1, line 14), which loses hits on borders, \
                 or by its distance alone (a proof's aid)",
            ),
            choice(
                "searched",
                Trace,
                SEARCHED,
                "until_hit",
                "buckets of a tile: up to the first with a hit (Algorithm 1, line 18), or all (a proof's aid)",
            ),
            choice(
                "centre_rays",
                Trace,
                CENTRE_RAYS,
                "whole",
                "rays that pass near a view's centre, where rounding hides their tile: walked like any other, or split \
                 there, with all that lies near the centre tested (a proof's aid)",
            ),
            choice(
                "fetch",
                Trace,
                FETCHES,
                "raster",
                "how surfaces are fetched where a trace ends at them: by drawing the scene into every view once more and looking \
                 hits up at their pixels (sections 4.2.1, 4.2.2), which may lose some, or from the vertices by triangle",
            ),
            integer(
                "max_steps",
                "cells",
                Trace,
                1,
                1 << 20,
                1 << 14,
                "cells of the pyramid after which a ray is given up with status step_cap, as one is that the driver's own limit of \
                 loops cuts off",
                &[64, 256, 1024, 4096, 16_384],
            ),
        ],
    }
}

/// The value of `tile_size`, pixels.
pub(crate) fn tile_size(parameters: &tracebench_api::Parameters) -> u32 {
    parameters.choice("tile_size").parse().unwrap_or(1)
}
