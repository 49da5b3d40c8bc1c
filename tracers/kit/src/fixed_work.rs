//! Arithmetic that is the same every time: how long it takes tells how fast a device, or the host, runs.

use tracebench_api::wgpu::{BindGroup, Buffer, BufferUsages, CommandEncoder, ComputePipeline};
use tracebench_api::{Gpu, TracerError};
use tracebench_shaders::shared::FIXED_WORK;

use crate::{bind_group, compute_pipeline, dispatch_linear, storage_buffer};

/// `LANES`, `RESULTS` and `STEPS` of shaders/shared/fixed_work.wgsl.
const LANES: u32 = 64;
const RESULTS: u32 = 64;
const STEPS: u32 = 1024;

/// The pipeline.
#[derive(Debug)]
pub struct FixedWork(ComputePipeline);

/// A number of tasks, ready to be recorded any number of times.
#[derive(Debug)]
pub struct FixedWorkPlan {
    tasks: u32,
    bindings: BindGroup,
    results: Buffer,
}

impl FixedWork {
    /// Creates the pipeline.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        Ok(Self(compute_pipeline(gpu, FIXED_WORK, "work")?))
    }

    /// Plans so many tasks.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn plan(&self, gpu: &Gpu, tasks: u32) -> Result<FixedWorkPlan, TracerError> {
        let count = gpu.buffer_with("fixed work: tasks", &tasks.to_le_bytes(), BufferUsages::UNIFORM, "nothing")?;
        let results = storage_buffer(gpu, "fixed work: results", u64::from(RESULTS) * 4, "nothing")?;
        let resources = [&count, &results].map(Buffer::as_entire_binding);
        Ok(FixedWorkPlan { tasks, bindings: bind_group(gpu, &self.0.get_bind_group_layout(0), &resources), results })
    }

    /// Records a plan.
    pub fn record(&self, encoder: &mut CommandEncoder, plan: &FixedWorkPlan) {
        dispatch_linear(encoder, &self.0, &plan.bindings, plan.tasks, LANES);
    }
}

impl FixedWorkPlan {
    /// What the tasks come to; each time that they are recorded undoes the last.
    pub fn results(&self) -> &Buffer {
        &self.results
    }
}

/// One task, on the host.
pub fn fixed_task(task: u32) -> u32 {
    let mut state = task;
    for _ in 0..STEPS {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        state = (word >> 22) ^ word;
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sizes that the host knows are those of the shader.
    #[test]
    fn sizes_are_those_of_the_shader() {
        let has = |line: &str| FIXED_WORK.source.lines().any(|found| found == line);
        for (name, value) in [("LANES", LANES), ("RESULTS", RESULTS), ("STEPS", STEPS)] {
            assert!(has(&format!("const {name}: u32 = {value}u;")) && !has(&format!("const {name}: u32 = 7u;")));
        }
        assert_ne!(fixed_task(1), fixed_task(2));
    }
}
