//! When two rows are of the same thing: the one answer for every table, chart, verdict and comparison.

use super::{Row, TraceRecord, ViewpointRecord};

/// The same scene seen from the same eye at the same time, whatever the resolutions.
pub fn same_pose(a: &Row, b: &Row) -> bool {
    a.scene.name == b.scene.name
        && a.scene.sha256 == b.scene.sha256
        && (a.viewpoint.eye, a.viewpoint.forward) == (b.viewpoint.eye, b.viewpoint.forward)
        && a.viewpoint.time_s == b.viewpoint.time_s
        && a.difficulty_level == b.difficulty_level
}

/// The same rays for the same names: [`same_pose`] with the same camera, ray image and words about the sets. Frame and faces shape
/// structures, not rays.
pub fn same_place(a: &Row, b: &Row) -> bool {
    same_pose(a, b)
        && a.viewpoint.name == b.viewpoint.name
        && a.viewpoint.up == b.viewpoint.up
        && a.viewpoint.vertical_fov_degrees == b.viewpoint.vertical_fov_degrees
        && a.viewpoint.ray_image == b.viewpoint.ray_image
        && a.viewpoint.ray_parameters == b.viewpoint.ray_parameters
}

/// The same work in two records: the same tracer with the same parameters over the same triangles from the same viewpoint,
/// brought there in the same way. Names of scenes and viewpoints, presets and labels are names and do not count.
pub fn same_work(a: &Row, b: &Row) -> bool {
    let unnamed = |viewpoint: &ViewpointRecord| ViewpointRecord { name: String::new(), ..viewpoint.clone() };
    a.scene.sha256 == b.scene.sha256
        && a.tracer.name == b.tracer.name
        && a.tracer.parameters == b.tracer.parameters
        && unnamed(&a.viewpoint) == unnamed(&b.viewpoint)
        && a.update_mode == b.update_mode
        && a.difficulty_level == b.difficulty_level
}

/// The same question: the same rays by name and content, asked for the same, to the same end.
pub fn same_rays(a: &TraceRecord, b: &TraceRecord) -> bool {
    a.rays == b.rays
        && a.rays_sha256 == b.rays_sha256
        && a.query == b.query
        && a.trace_to == b.trace_to
        && a.count == b.count
}
