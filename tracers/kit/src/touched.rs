//! Which of the things that are stored any ray of a set touched, a bit each: for variants that count.

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Gpu, TracerError};

/// Bits on the device, all off at first. A shader sees them as `array<atomic<u32>>`, from the least bit of a word on.
#[derive(Debug)]
pub struct TouchedBits {
    bits: Buffer,
    bytes: u64,
}

impl TouchedBits {
    /// A bit for each of `count` things.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold or bind them; `hint` is the remedy named.
    pub fn new(gpu: &Gpu, name: &'static str, count: u64, hint: &str) -> Result<Self, TracerError> {
        let bytes = count.div_ceil(32).max(1) * 4;
        gpu.check_storage_binding(name, bytes, hint)?;
        let bits = gpu.buffer(name, bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC, hint)?;
        Ok(Self { bits, bytes })
    }

    /// What is bound.
    pub fn buffer(&self) -> &Buffer {
        &self.bits
    }

    /// The number of bits that are on.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn count(&self, gpu: &Gpu) -> Result<u64, TracerError> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&self.bits, self.bytes)?);
        Ok(bits_on(&words))
    }
}

/// The number of bits that are on in some words.
pub fn bits_on(words: &[u32]) -> u64 {
    words.iter().map(|word| u64::from(word.count_ones())).sum()
}
