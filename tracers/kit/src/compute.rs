//! Pipelines and dispatches with the least ceremony.

use std::collections::BTreeMap;

use tracebench_api::wgpu::{self, BindGroupEntry, BindingResource};
use tracebench_api::{DeviceLimits, Gpu, PhaseClock, TracerError};
use tracebench_shaders::{Shader, ShaderKey, Variant};

use crate::OnDemand;

/// Most workgroups along one dimension of a dispatch (WebGPU's limit).
const MAX_WORKGROUPS: u32 = 65_535;

/// That the device's limits allow what entry points of a shader need; drivers and wgpu would say so in words of their own.
///
/// # Errors
/// [`TracerError::Unavailable`] with the limit.
pub fn check_limits(gpu: &Gpu, shader: Shader, entry_points: &[&str]) -> Result<(), TracerError> {
    let limits = &gpu.limits;
    for entry in shader.entries.iter().filter(|entry| entry_points.contains(&entry.name)) {
        let needs = [
            ("storage buffers in a stage", entry.storage_buffers, limits.max_storage_buffers_per_shader_stage),
            ("storage textures in a stage", entry.storage_textures, limits.max_storage_textures_per_shader_stage),
            ("invocations in a workgroup", entry.invocations, limits.max_compute_invocations_per_workgroup),
        ];
        if let Some((what, needed, limit)) = needs.into_iter().find(|(_, needed, limit)| needed > limit) {
            return Err(TracerError::Unavailable(format!(
                "{} ({}) needs {needed} {what}, {} allows {limit}{}",
                shader.name,
                entry.name,
                gpu.listing.name,
                match gpu.listing.limits {
                    DeviceLimits::Adapter => "",
                    DeviceLimits::Webgpu => " within WebGPU's default limits",
                }
            )));
        }
    }
    Ok(())
}

/// Compiles a shader for some of its entry points. With `tests_early` its fragment stage, which writes to buffers, runs for nothing that
/// its depth test rejects, where the device can be told so; elsewhere it may run for all, as WebGPU allows.
///
/// # Errors
/// [`TracerError::Unavailable`] if the device's limits forbid one, [`TracerError::Failed`] if the device refuses it.
pub(crate) fn shader_module(
    gpu: &Gpu,
    shader: Shader,
    entry_points: &[&str],
    tests_early: bool,
) -> Result<wgpu::ShaderModule, TracerError> {
    check_limits(gpu, shader, entry_points)?;
    let source = match tests_early && gpu.device.features().contains(wgpu::Features::SHADER_EARLY_DEPTH_TEST) {
        // Composed shaders are plain WGSL, which has no word for it.
        true => shader.source.replacen("@fragment", "@fragment @early_depth_test(force)", 1).into(),
        false => shader.source.into(),
    };
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(shader.name),
        source: wgpu::ShaderSource::Wgsl(source),
    });
    gpu.check()?;
    Ok(module)
}

/// What a pipeline is told of a shader.
pub(crate) fn options(shader: Shader) -> wgpu::PipelineCompilationOptions<'static> {
    wgpu::PipelineCompilationOptions { constants: shader.switches, ..Default::default() }
}

/// Creates a compute pipeline with a layout derived from the shader.
///
/// # Errors
/// [`TracerError::Failed`] if the device refuses it.
pub fn compute_pipeline(
    gpu: &Gpu,
    shader: impl Into<Shader>,
    entry_point: &str,
) -> Result<wgpu::ComputePipeline, TracerError> {
    let shader = shader.into();
    let module = shader_module(gpu, shader, &[entry_point], false)?;
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(shader.name),
        layout: None,
        module: &module,
        entry_point: Some(entry_point),
        compilation_options: options(shader),
        cache: None,
    });
    gpu.check()?;
    Ok(pipeline)
}

/// What `make` makes of every variant of a shader.
///
/// # Errors
/// Those of `make`.
pub fn every_variant<V: Variant, Made>(
    make: impl Fn(V) -> Result<Made, TracerError>,
) -> Result<BTreeMap<V, Made>, TracerError> {
    V::ALL.iter().map(|variant| Ok((*variant, make(*variant)?))).collect()
}

/// Pipelines of a shader of many variants: each is made when it is first asked for.
#[derive(Debug)]
pub struct PipelinesOnDemand {
    entry_point: &'static str,
    made: OnDemand<ShaderKey, wgpu::ComputePipeline>,
}

impl PipelinesOnDemand {
    /// None yet.
    pub fn new(entry_point: &'static str) -> Self {
        Self { entry_point, made: OnDemand::default() }
    }

    /// That of a variant.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] if the device's limits forbid it, [`TracerError::Failed`] if it refuses it.
    pub fn of(&self, gpu: &Gpu, variant: impl Into<Shader>) -> Result<wgpu::ComputePipeline, TracerError> {
        let shader = variant.into();
        self.made.of(shader.key(), || compute_pipeline(gpu, shader, self.entry_point))
    }
}

/// Does work of whose time nobody is told: what is recorded is complete afterwards.
///
/// # Errors
/// Those of `record`, or [`TracerError::Failed`] if the device fails.
pub fn untimed<Made>(
    gpu: &Gpu,
    record: impl FnOnce(&mut PhaseClock<'_>) -> Result<Made, TracerError>,
) -> Result<Made, TracerError> {
    let mut clock = PhaseClock::new(Some(gpu));
    let made = record(&mut clock)?;
    clock.finish()?;
    Ok(made)
}

/// Binds resources to bindings 0, 1, 2, ... of group 0.
pub fn bind_group(gpu: &Gpu, layout: &wgpu::BindGroupLayout, resources: &[BindingResource<'_>]) -> wgpu::BindGroup {
    let numbered: Vec<_> = (0..).zip(resources.iter().cloned()).collect();
    bind_group_at(gpu, layout, &numbered)
}

/// Binds resources to the bindings of those numbers, for an entry point that does not use every binding of its shader.
pub fn bind_group_at(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    resources: &[(u32, BindingResource<'_>)],
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .iter()
        .map(|(binding, resource)| BindGroupEntry { binding: *binding, resource: resource.clone() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// Records a dispatch of at least `invocations`, folded into two dimensions where one does not hold it
/// (`linear_invocation` of shaders/shared/dispatch.wgsl unfolds it).
pub fn dispatch_linear(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    bindings: &wgpu::BindGroup,
    invocations: u32,
    workgroup_size: u32,
) {
    dispatch_linear_groups(encoder, pipeline, &[bindings], invocations, workgroup_size);
}

/// The same with several bind groups, from group 0 on.
pub fn dispatch_linear_groups(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    bindings: &[&wgpu::BindGroup],
    invocations: u32,
    workgroup_size: u32,
) {
    let [across, down] = fold(invocations.div_ceil(workgroup_size));
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(pipeline);
    for (group, bindings) in (0..).zip(bindings) {
        pass.set_bind_group(group, *bindings, &[]);
    }
    pass.dispatch_workgroups(across, down, 1);
}

fn fold(workgroups: u32) -> [u32; 2] {
    let down = workgroups.div_ceil(MAX_WORKGROUPS).max(1);
    [workgroups.div_ceil(down), down]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every count is covered, within the limit, with less than one row to spare.
    #[test]
    fn folds_cover_and_stay_within_limits() {
        for workgroups in [0, 1, 65_534, 65_535, 65_536, 131_071, 1_000_003, u32::MAX / 64] {
            let [across, down] = fold(workgroups);
            let covered = u64::from(across) * u64::from(down);
            assert!(across <= MAX_WORKGROUPS && down <= MAX_WORKGROUPS);
            assert!(covered >= u64::from(workgroups) && covered - u64::from(workgroups) < u64::from(down));
        }
    }
}
