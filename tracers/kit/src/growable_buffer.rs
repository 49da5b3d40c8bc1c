//! Buffers: uniforms, storage, and such as are kept from build to build.

use bytemuck::NoUninit;
use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Gpu, Ledger, TracerError};

/// A zeroed storage buffer that can be bound, usable as source and target of copies.
///
/// # Errors
/// [`TracerError::TooLarge`] if the device cannot create or bind it, with `hint` as the remedy.
pub fn storage_buffer(gpu: &Gpu, name: &str, bytes: u64, hint: &str) -> Result<Buffer, TracerError> {
    gpu.check_storage_binding(name, bytes, hint)?;
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    gpu.buffer(name, bytes, usage, hint)
}

/// A uniform of this content.
///
/// # Errors
/// [`TracerError::Failed`] if the device fails.
pub fn uniform_buffer(gpu: &Gpu, name: &str, contents: &impl NoUninit) -> Result<Buffer, TracerError> {
    gpu.buffer_with(name, bytemuck::bytes_of(contents), BufferUsages::UNIFORM, "nothing")
}

/// Makes room for what a build turned out to need, by `set`: a quarter more, so that a scene that keeps growing does not stop
/// every frame, and no more than that where so much is refused.
///
/// # Errors
/// Those of `set` for what is needed.
pub fn grow(needed: &[u32], mut set: impl FnMut(&[u32]) -> Result<(), TracerError>) -> Result<(), TracerError> {
    let more: Vec<u32> = needed.iter().map(|count| count.saturating_add(count / 4)).collect();
    set(&more).or_else(|_| set(needed))
}

/// A storage buffer with a name, and how much of it is in use. Usable as source and target of copies.
#[derive(Clone, Debug)]
pub struct GrowableBuffer {
    /// What ledgers and messages call it.
    pub name: &'static str,
    /// The buffer.
    pub buffer: Buffer,
    /// Bytes in use, no more than the buffer has.
    pub used_bytes: u64,
}

impl GrowableBuffer {
    /// A buffer of at least `bytes`: that of `there` if it is large enough, with what is in it, else a zeroed one.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot create or bind it, with `hint` as the remedy.
    pub fn new(
        gpu: &Gpu,
        name: &'static str,
        bytes: u64,
        hint: &str,
        there: Option<&GrowableBuffer>,
    ) -> Result<Self, TracerError> {
        gpu.check_storage_binding(name, bytes, hint)?;
        if let Some(there) = there.filter(|there| there.buffer.size() >= bytes) {
            return Ok(Self { name, buffer: there.buffer.clone(), used_bytes: bytes });
        }
        Ok(Self { name, buffer: storage_buffer(gpu, name, bytes, hint)?, used_bytes: bytes })
    }

    /// Enters the buffer as a part that stays.
    pub fn enter(&self, ledger: &mut Ledger) {
        ledger.keep(self.name, self.buffer.size(), self.used_bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter more is made where that is possible, else what is needed; where not even that is, its error comes back.
    #[test]
    fn growth_leaves_a_quarter_where_it_can() {
        let mut asked = Vec::new();
        let mut grown = |needed: &[u32], most: u32| {
            asked.clear();
            let made = grow(needed, |counts| {
                asked.push(counts.to_vec());
                let fits = counts.iter().all(|count| *count <= most);
                if fits { Ok(()) } else { Err(TracerError::Failed(format!("{counts:?}"))) }
            });
            (made.map_err(|error| error.to_string()), asked.clone())
        };
        assert_eq!(grown(&[100, 7], 1000), (Ok(()), vec![vec![125, 8]]));
        assert_eq!(grown(&[100, 7], 110), (Ok(()), vec![vec![125, 8], vec![100, 7]]));
        assert_eq!(grown(&[u32::MAX], u32::MAX), (Ok(()), vec![vec![u32::MAX]]));
        let (refused, _) = grown(&[100], 50);
        assert!(refused.unwrap_err().contains("[100]"));
    }
}
