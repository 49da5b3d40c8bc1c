//! Buffers that are kept from build to build.

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Gpu, Ledger, TracerError};

/// A storage buffer with a name, and how much of it is in use. Usable as source and target of copies.
#[derive(Debug)]
pub struct Room {
    /// What ledgers and messages call it.
    pub name: &'static str,
    /// The buffer.
    pub buffer: Buffer,
    /// Bytes in use, no more than the buffer has.
    pub used_bytes: u64,
}

impl Room {
    /// A buffer of at least `bytes`: that of `there` if it is large enough, with what is in it, else a zeroed one.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot create or bind it, with `turn_down` as the remedy.
    pub fn new(
        gpu: &Gpu,
        name: &'static str,
        bytes: u64,
        turn_down: &str,
        there: Option<&Room>,
    ) -> Result<Self, TracerError> {
        gpu.check_storage_binding(name, bytes, turn_down)?;
        if let Some(there) = there.filter(|there| there.buffer.size() >= bytes) {
            return Ok(Self { name, buffer: there.buffer.clone(), used_bytes: bytes });
        }
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        Ok(Self { name, buffer: gpu.buffer(name, bytes, usage, turn_down)?, used_bytes: bytes })
    }

    /// Enters the buffer as a part that stays.
    pub fn enter(&self, ledger: &mut Ledger) {
        ledger.keep(self.name, self.buffer.size(), self.used_bytes);
    }
}
