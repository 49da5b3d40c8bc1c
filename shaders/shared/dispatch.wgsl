#define_import_path tracebench::dispatch

// A dispatch has at most 65,535 workgroups along one dimension: larger ones are folded into two.
fn linear_invocation(workgroup: vec3<u32>, workgroups: vec3<u32>, local: u32, workgroup_size: u32) -> u32 {
    return (workgroup.y * workgroups.x + workgroup.x) * workgroup_size + local;
}

// The same for workgroups.
fn linear_workgroup(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    return workgroup.y * workgroups.x + workgroup.x;
}
