//! The registration of `mesh-warp`: one depth a pixel from one view as a mesh, drawn from where rays start.

use super::expectation::{OF_ONE_VIEW, fails, few, of_huge_triangles, of_plates_along_rows};
use super::{Column, Expectation, Family, Registration, Rule, Shrink, Touch};

pub(crate) const REGISTRATION: Registration = Registration {
    one_origin: true,
    expectations: &[EXPECTATIONS, OF_ONE_VIEW],
    tune: Some("step_from"),
    shrinks: &[Shrink { axis: "resolution", steps: &["1/2", "1/4", "1/8", "1/16"] }],
    touches: &[Touch { counter: "vertices_touched", stored: "vertices", parts: &["mesh vertices"] }],
    ..Registration::sampled(tracebench_mesh_warp::description, Family::Image, |gpu| {
        Ok(Box::new(tracebench_mesh_warp::MeshWarp::new(gpu?)?))
    })
};

const SEVERAL: Expectation = Expectation::Unserved { reason: "its rays start in several points" };

const NARROW: &str =
    "a triangle needs three pixels beside each other that show something: what is a pixel wide before nothing has none";
const NARROW_SOURCE: &str = "WKP15, section 5.1: a regular grid mesh with one vertex a pixel, without refinement";
const BORDERS: &str = "eye rays through pixel centres meet the vertices there; wrong are rays at borders of what is seen before nothing, where the \
                       mesh ends, and of the frame, to which its outermost vertices are moved";
const AT_BORDERS: &str = "at a border the mesh ends or spans from one surface to another, within a pixel, which is as large as the frame is coarse";
const AT_VERTICES: Expectation = few(Rule::Footprint, BORDERS);
const THIN_PLATES: Expectation = fails(Rule::Footprint, NARROW, NARROW_SOURCE);

const EXPECTATIONS: Column = &[
    (
        "edge-on close-sheets voxel-stack eye-inside-object plane-through-eye secondary-depth-ratio surface-starts",
        SEVERAL,
    ),
    (
        "cube-borders cell-borders face-cell-borders through-view-centre stacked-layers crowded-pixel thin-walls",
        SEVERAL,
    ),
    ("behind-foreground towards-camera foreground-in-cell long-rays away-from-camera", SEVERAL),
    ("field-of-view off-origin", SEVERAL),
    ("half-resolution", fails(Rule::Footprint, AT_BORDERS, NARROW_SOURCE)),
    ("wires leaves", fails(Rule::HitMiss, NARROW, NARROW_SOURCE)),
    ("coarse-frame", THIN_PLATES),
    ("wide-frame", of_plates_along_rows(&THIN_PLATES)),
    ("open-mesh needles coplanar-copies depth-range flat-tile equal-triangles long-scene", AT_VERTICES),
    ("huge-triangle", of_huge_triangles(&AT_VERTICES)),
];
