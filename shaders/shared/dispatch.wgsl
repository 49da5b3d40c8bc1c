#define_import_path tracebench::dispatch

// Where an entry point runs.
struct Invocation {
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
}

// A dispatch has at most 65,535 workgroups along one dimension: larger ones are folded into two.
fn linear_invocation(invocation: Invocation, workgroup_size: u32) -> u32 {
    return (invocation.workgroup.y * invocation.workgroups.x + invocation.workgroup.x) * workgroup_size + invocation.local;
}

// The same for workgroups.
fn linear_workgroup(invocation: Invocation) -> u32 {
    return invocation.workgroup.y * invocation.workgroups.x + invocation.workgroup.x;
}
