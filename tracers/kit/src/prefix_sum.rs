//! Exclusive prefix sums on the device.

use tracebench_api::wgpu::{self, Buffer, BufferUsages, CommandEncoder, ComputePipeline};
use tracebench_api::{Gpu, Ledger, MemoryEntry, TracerError};
use tracebench_shaders::shared::PREFIX_SUM;

use crate::{GrowableBuffer, bind_group, compute_pipeline, dispatch_linear};

/// `LANES` of shaders/shared/prefix_sum.wgsl.
const LANES: u32 = 256;

/// Elements that a workgroup takes: its `LANES` times its `RUN`.
const BLOCK: u32 = LANES * 16;

/// What the sums of blocks are called, by the plan's number and by level; a fourth level would be of more elements than 32 bits count.
const NAMES: [[&str; 3]; 3] = [
    ["sums of blocks", "sums of blocks of blocks", "sums of all blocks"],
    ["second sums of blocks", "second sums of blocks of blocks", "second sums of all blocks"],
    ["third sums of blocks", "third sums of blocks of blocks", "third sums of all blocks"],
];

/// The pipelines of prefix sums; see [`PrefixSum::plan`].
#[derive(Debug)]
pub struct PrefixSum {
    reduce: ComputePipeline,
    scan: ComputePipeline,
}

/// Prefix sums over one buffer, ready to be recorded any number of times.
#[derive(Clone, Debug)]
pub struct PrefixSumPlan {
    /// Which of a structure's plans it is: ledgers have no name twice.
    number: usize,
    /// The elements first, then the sums of blocks, of blocks of blocks, ..., up to a single block.
    levels: Vec<Level>,
    /// Sums of blocks, by level.
    buffers: Vec<GrowableBuffer>,
    counts: Vec<Buffer>,
}

#[derive(Clone, Debug)]
struct Level {
    count: u32,
    reduce: wgpu::BindGroup,
    scan: wgpu::BindGroup,
}

/// What ledgers call the uniform of a level.
fn count_name(number: usize, level: usize) -> String {
    let plan = ["prefix sum", "second prefix sum", "third prefix sum"][number];
    format!("{plan}: count of level {}", level + 1)
}

impl PrefixSum {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses them.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        let pipeline = |entry_point| compute_pipeline(gpu, PREFIX_SUM, entry_point);
        Ok(Self { reduce: pipeline("reduce")?, scan: pipeline("scan")? })
    }

    /// Plans to replace each of the first `count` u32 of `values` by the sum of those before it, modulo 2^32. The rest is
    /// left as it is. `there` is a plan that is no longer recorded, whose buffers serve where they are large enough.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the sums of blocks do not fit; that `values` can be bound is the caller's to check.
    pub fn plan(
        &self,
        gpu: &Gpu,
        values: &Buffer,
        count: u32,
        there: Option<&PrefixSumPlan>,
    ) -> Result<PrefixSumPlan, TracerError> {
        self.numbered_plan(gpu, 0, values, count, there)
    }

    /// The same for a structure with further plans: `number` tells its buffers from theirs, up to 2; a plan without one has 0, that of
    /// a sort too.
    ///
    /// # Errors
    /// As [`PrefixSum::plan`].
    pub fn numbered_plan(
        &self,
        gpu: &Gpu,
        number: usize,
        values: &Buffer,
        count: u32,
        there: Option<&PrefixSumPlan>,
    ) -> Result<PrefixSumPlan, TracerError> {
        let number = number.min(NAMES.len() - 1);
        let mut there = there.into_iter().flat_map(|there| &there.buffers);
        let (mut levels, mut buffers, mut counts): (Vec<Level>, Vec<GrowableBuffer>, Vec<Buffer>) = Default::default();
        let mut count = count;
        loop {
            let blocks = count.div_ceil(BLOCK).max(1);
            let room = GrowableBuffer::new(
                gpu,
                NAMES[number][buffers.len().min(2)],
                u64::from(blocks) * 4,
                "the number of elements",
                there.next(),
            )?;
            let elements = buffers.last().map_or(values, |room| &room.buffer);
            let uniform = gpu.buffer_with(
                &count_name(number, levels.len()),
                &count.to_le_bytes(),
                BufferUsages::UNIFORM,
                "nothing",
            )?;
            let bind = |pipeline: &ComputePipeline| {
                let resources = [&uniform, elements, &room.buffer].map(Buffer::as_entire_binding);
                bind_group(gpu, &pipeline.get_bind_group_layout(0), &resources)
            };
            levels.push(Level { count, reduce: bind(&self.reduce), scan: bind(&self.scan) });
            buffers.push(room);
            counts.push(uniform);
            if blocks == 1 {
                return Ok(PrefixSumPlan { number, levels, buffers, counts });
            }
            count = blocks;
        }
    }

    /// What a plan for so many elements takes beside them.
    pub fn memory(count: u32) -> Vec<MemoryEntry> {
        let (mut entries, mut count) = (Vec::new(), count);
        for level in 0.. {
            let blocks = count.div_ceil(BLOCK).max(1);
            entries.push(MemoryEntry::whole(NAMES[0][level.min(2)], u64::from(blocks) * 4));
            entries.push(MemoryEntry::whole(&count_name(0, level), size_of::<u32>() as u64));
            if blocks == 1 {
                break;
            }
            count = blocks;
        }
        entries
    }

    /// Records a plan.
    pub fn record(&self, encoder: &mut CommandEncoder, plan: &PrefixSumPlan) {
        let Some((top, below)) = plan.levels.split_last() else { return };
        // Before the first and only block of the top there is nothing.
        if let Some(room) = plan.buffers.last() {
            encoder.clear_buffer(&room.buffer, 0, None);
        }
        let lanes = |level: &Level| level.count.div_ceil(BLOCK) * LANES;
        for level in below {
            dispatch_linear(encoder, &self.reduce, &level.reduce, lanes(level), LANES);
        }
        for level in std::iter::once(top).chain(below.iter().rev()) {
            dispatch_linear(encoder, &self.scan, &level.scan, lanes(level), LANES);
        }
    }
}

impl PrefixSumPlan {
    /// Enters the buffers beside the elements.
    pub fn enter(&self, ledger: &mut Ledger) {
        self.buffers.iter().for_each(|room| room.enter(ledger));
        for (level, count) in self.counts.iter().enumerate() {
            ledger.keep(&count_name(self.number, level), count.size(), count.size());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sizes that the host knows are those of the shader.
    #[test]
    fn sizes_are_those_of_the_shader() {
        let has = |line: &str| PREFIX_SUM.source.lines().any(|found| found == line);
        assert!(has(&format!("const LANES: u32 = {LANES}u;")));
        assert!(has(&format!("const RUN: u32 = {}u;", BLOCK / LANES)));
        assert!(!has("const LANES: u32 = 255u;"));
    }
}
