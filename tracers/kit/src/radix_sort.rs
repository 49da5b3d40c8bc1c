//! A stable radix sort of 32-bit keys with 32-bit payloads on the device.

use tracebench_api::wgpu::{self, Buffer, BufferUsages, CommandEncoder, ComputePipeline};
use tracebench_api::{Gpu, Ledger, TracerError};
use tracebench_shaders::shared::RADIX_SORT;

use crate::{GrowableBuffer, PrefixSum, PrefixSumPlan, bind_group, compute_pipeline, dispatch_linear};
pub use tracebench_shaders::shared::SortPass;

/// `LANES` of shaders/shared/radix_sort.wgsl.
const LANES: u32 = 32;

/// Keys that a workgroup takes: its `LANES` times its `RUN`. Measured on Mesa's software driver (a sort of 30 bits of 100,000
/// keys): runs of 32, 64, 128 and 256 keys take 20, 17, 14 and 12 ms, digits of 6 bits in runs of 64 take 17. A run of 128 is
/// taken, so that a GPU has lanes enough.
const BLOCK: u32 = LANES * 128;

/// `DIGIT_BITS` there.
const DIGIT_BITS: u32 = 8;

/// The pipelines of the sort; see [`RadixSort::plan`].
#[derive(Debug)]
pub struct RadixSort {
    count: ComputePipeline,
    scatter: ComputePipeline,
    prefix_sum: PrefixSum,
}

/// A sort of one pair of buffers, ready to be recorded any number of times.
#[derive(Clone, Debug)]
pub struct RadixSortPlan {
    blocks: u32,
    passes: Vec<Pass>,
    sums: PrefixSumPlan,
    /// Keys and payloads after an odd number of passes, and the table of digits.
    buffers: [GrowableBuffer; 3],
}

#[derive(Clone, Debug)]
struct Pass {
    uniform_bytes: u64,
    count: wgpu::BindGroup,
    scatter: wgpu::BindGroup,
}

/// What ledgers call the uniform of a pass.
fn pass_name(index: usize) -> String {
    format!("sort: pass {}", index + 1)
}

impl RadixSort {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses them.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        let pipeline = |entry_point| compute_pipeline(gpu, RADIX_SORT, entry_point);
        Ok(Self { count: pipeline("count")?, scatter: pipeline("scatter")?, prefix_sum: PrefixSum::new(gpu)? })
    }

    /// Plans to sort the first `count` keys and their payloads, in place, by the keys' lowest `key_bits` (at most 32); keys
    /// must have no bits above them. Equal keys stay in their order. `there` is a plan that is no longer recorded, whose buffers
    /// serve where they are large enough.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if what the sort needs beside does not fit, [`TracerError::Failed`] for more bits.
    pub fn plan(
        &self,
        gpu: &Gpu,
        keys: &Buffer,
        payloads: &Buffer,
        count: u32,
        key_bits: u32,
        there: Option<&RadixSortPlan>,
    ) -> Result<RadixSortPlan, TracerError> {
        if key_bits > 32 {
            return Err(TracerError::Failed(format!("keys of {key_bits} bits: a key has 32")));
        }
        let [there_keys, there_payloads, there_table] =
            there.map_or([None; 3], |there| there.buffers.each_ref().map(Some));
        let blocks = count.div_ceil(BLOCK);
        let hint = "the number of keys";
        let bytes = u64::from(count) * 4;
        let table_count = blocks << DIGIT_BITS;
        let buffers = [
            GrowableBuffer::new(gpu, "sort: other keys", bytes, hint, there_keys)?,
            GrowableBuffer::new(gpu, "sort: other payloads", bytes, hint, there_payloads)?,
            GrowableBuffer::new(gpu, "sort: table of digits", u64::from(table_count) * 4, hint, there_table)?,
        ];
        let [other_keys, other_payloads, table] = buffers.each_ref().map(|room| &room.buffer);
        // An even number of passes ends where it began.
        let needed = key_bits.div_ceil(DIGIT_BITS);
        let pass = |index: u32| -> Result<Pass, TracerError> {
            let settings = SortPass { count, blocks, shift: index * DIGIT_BITS };
            let uniform = gpu.buffer_with(
                &pass_name(index as usize),
                bytemuck::bytes_of(&settings),
                BufferUsages::UNIFORM,
                "nothing",
            )?;
            let (from, to) = match index % 2 {
                0 => ([keys, payloads], [other_keys, other_payloads]),
                _ => ([other_keys, other_payloads], [keys, payloads]),
            };
            let all = [&uniform, from[0], table, from[1], to[0], to[1]].map(Buffer::as_entire_binding);
            Ok(Pass {
                uniform_bytes: uniform.size(),
                count: bind_group(gpu, &self.count.get_bind_group_layout(0), &all[..3]),
                scatter: bind_group(gpu, &self.scatter.get_bind_group_layout(0), &all),
            })
        };
        let passes = (0..needed.next_multiple_of(2)).map(pass).collect::<Result<_, _>>()?;
        let sums = self.prefix_sum.plan(gpu, table, table_count, there.map(|there| &there.sums))?;
        Ok(RadixSortPlan { blocks, passes, sums, buffers })
    }

    /// Records a plan.
    pub fn record(&self, encoder: &mut CommandEncoder, plan: &RadixSortPlan) {
        let lanes = plan.blocks * LANES;
        for pass in &plan.passes {
            dispatch_linear(encoder, &self.count, &pass.count, lanes, LANES);
            self.prefix_sum.record(encoder, &plan.sums);
            dispatch_linear(encoder, &self.scatter, &pass.scatter, lanes, LANES);
        }
    }
}

impl RadixSortPlan {
    /// Enters the buffers beside keys and payloads.
    pub fn enter(&self, ledger: &mut Ledger) {
        self.buffers.iter().for_each(|room| room.enter(ledger));
        for (index, pass) in self.passes.iter().enumerate() {
            ledger.keep(&pass_name(index), pass.uniform_bytes, pass.uniform_bytes);
        }
        self.sums.enter(ledger);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sizes that the host knows are those of the shader.
    #[test]
    fn sizes_are_those_of_the_shader() {
        let has = |line: &str| RADIX_SORT.source.lines().any(|found| found == line);
        assert!(has(&format!("const LANES: u32 = {LANES}u;")));
        assert!(has(&format!("const RUN: u32 = {}u;", BLOCK / LANES)));
        assert!(has(&format!("const DIGIT_BITS: u32 = {DIGIT_BITS}u;")));
        assert!(!has("const LANES: u32 = 31u;"));
    }
}
