//! What a variant that counts writes: numbers of every ray, and bits of what any of them touches.

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Counter, Gpu, TracerError};

use crate::{bits_on, storage_buffer};

/// Numbers of every ray on the device, all 0 at first. A shader sees them as an array of u32, or of vectors of as many as have names.
#[derive(Debug)]
pub struct RayCounts {
    counts: Buffer,
    rays: usize,
    names: &'static [&'static str],
}

impl RayCounts {
    /// Those of these names, in the order in which the shader has them, of so many rays.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold or bind them; rays are what to have fewer of.
    pub fn new(gpu: &Gpu, names: &'static [&'static str], rays: usize) -> Result<Self, TracerError> {
        let bytes = (rays.max(1) * names.len() * 4) as u64;
        gpu.check_storage_binding("counts", bytes, "--size")?;
        let counts = gpu.buffer("counts", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC, "--size")?;
        Ok(Self { counts, rays, names })
    }

    /// What is bound.
    pub fn buffer(&self) -> &Buffer {
        &self.counts
    }

    /// The counters.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn counters(&self, gpu: &Gpu) -> Result<Vec<Counter>, TracerError> {
        let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&self.counts, self.counts.size())?);
        Ok(counters_of(&counts[..self.rays * self.names.len()], self.names))
    }
}

/// The counters of these names of rays' counts, in the order in which the shader has them.
fn counters_of(counts: &[u32], names: &[&'static str]) -> Vec<Counter> {
    let of_rays = counts.chunks_exact(names.len());
    let of = |(place, name): (usize, &&'static str)| {
        Counter::of(name, of_rays.clone().map(|counts| u64::from(counts[place])))
    };
    names.iter().enumerate().map(of).collect()
}

/// Bits of two kinds of things that are stored, then numbers of every ray, all 0 at first: one buffer, since WebGPU grants eight in a
/// stage.
#[derive(Debug)]
pub struct TraceCounts {
    /// What is bound.
    pub buffer: Buffer,
    /// Words of the bits of either kind.
    pub bit_words: [u32; 2],
    rays: usize,
    names: &'static [&'static str],
}

impl TraceCounts {
    /// For so many things of either kind, and the numbers of these names of every ray, in the order in which the shader has them.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold or bind them; `hint` is the remedy named.
    pub fn new(
        gpu: &Gpu,
        things: [u64; 2],
        names: &'static [&'static str],
        rays: usize,
        hint: &str,
    ) -> Result<Self, TracerError> {
        let bit_words = things.map(|count| count.div_ceil(32).max(1) as u32);
        let words = bit_words.map(u64::from).iter().sum::<u64>() + (rays.max(1) * names.len()) as u64;
        Ok(Self { buffer: storage_buffer(gpu, "counts", words * 4, hint)?, bit_words, rays, names })
    }

    /// The counters of rays, then under these names how many things of either kind were touched.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn counters(&self, gpu: &Gpu, touched: [&'static str; 2]) -> Result<Vec<Counter>, TracerError> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&self.buffer, self.buffer.size())?);
        let (first, words) = words.split_at(self.bit_words[0] as usize);
        let (second, counts) = words.split_at(self.bit_words[1] as usize);
        let mut counters = counters_of(&counts[..self.rays * self.names.len()], self.names);
        counters
            .extend(touched.into_iter().zip([first, second]).map(|(name, bits)| Counter::of_set(name, bits_on(bits))));
        Ok(counters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracebench_api::AdapterChoice;

    /// Counters are read from their places, over all rays and no more; without rays there is nothing to count.
    #[test]
    fn counters_are_read_from_their_places() {
        let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
        // Written as a shader does it, in the order of rays, with room beyond the last.
        let written = bytemuck::cast_slice(&[1_u32, 10, 2, 20, 4, 40, 9, 9]);
        let counts =
            gpu.buffer_with("counts", written, BufferUsages::STORAGE | BufferUsages::COPY_SRC, "nothing").unwrap();
        let counts = RayCounts { counts, rays: 3, names: &["a", "b"] };
        let of = |name, values: [u64; 3]| Counter::of(name, values);
        assert_eq!(counts.counters(&gpu).unwrap(), [of("a", [1, 2, 4]), of("b", [10, 20, 40])]);
        let none = RayCounts::new(&gpu, &["a"], 0).unwrap();
        assert_eq!(none.counters(&gpu).unwrap(), [Counter::of("a", [])]);
    }

    /// Bits come before numbers, each kind of things in whole words, and of both no more is read than there is.
    #[test]
    fn bits_are_read_before_numbers() {
        let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
        let counts = TraceCounts::new(&gpu, [33, 0], &["a", "b"], 2, "nothing").unwrap();
        assert_eq!((counts.bit_words, counts.buffer.size()), ([2, 1], (2 + 1 + 2 * 2) * 4));
        gpu.queue.write_buffer(&counts.buffer, 0, bytemuck::cast_slice(&[0b101_u32, 1, 0b11, 1, 10, 2, 20]));
        let expected = [
            Counter::of("a", [1, 2]),
            Counter::of("b", [10, 20]),
            Counter::of_set("nodes", 3),
            Counter::of_set("leaves", 2),
        ];
        assert_eq!(counts.counters(&gpu, ["nodes", "leaves"]).unwrap(), expected);
    }
}
