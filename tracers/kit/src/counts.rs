//! What a variant that counts writes of every ray.

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Counter, Gpu, TracerError};

/// `N` counts a ray on the device, all 0 at first. A shader sees them as an array of u32, or of vectors of `N`.
#[derive(Debug)]
pub struct RayCounts<const N: usize> {
    counts: Buffer,
    rays: usize,
}

impl<const N: usize> RayCounts<N> {
    /// Counts of so many rays.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold or bind them; rays are what to have fewer of.
    pub fn new(gpu: &Gpu, name: &str, rays: usize) -> Result<Self, TracerError> {
        let bytes = (rays.max(1) * N * 4) as u64;
        gpu.check_storage_binding(name, bytes, "--size")?;
        let counts = gpu.buffer(name, bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC, "--size")?;
        Ok(Self { counts, rays })
    }

    /// What is bound.
    pub fn buffer(&self) -> &Buffer {
        &self.counts
    }

    /// The counters of these names, in the order in which the shader has them.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn counters(&self, gpu: &Gpu, names: [&'static str; N]) -> Result<Vec<Counter>, TracerError> {
        let counts: Vec<[u32; N]> = bytemuck::pod_collect_to_vec(&gpu.read(&self.counts, self.counts.size())?);
        Ok(counters_of(&counts[..self.rays], names))
    }
}

/// The counters of these names of rays' counts, in the order in which the shader has them.
pub fn counters_of<const N: usize>(counts: &[[u32; N]], names: [&'static str; N]) -> Vec<Counter> {
    let of = |(place, name)| Counter::of(name, counts.iter().map(|counts| u64::from(counts[place])));
    names.into_iter().enumerate().map(of).collect()
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
        let counts = RayCounts::<2> { counts, rays: 3 };
        let of = |name, values: [u64; 3]| Counter::of(name, values);
        assert_eq!(counts.counters(&gpu, ["a", "b"]).unwrap(), [of("a", [1, 2, 4]), of("b", [10, 20, 40])]);
        let none = RayCounts::<1>::new(&gpu, "counts", 0).unwrap();
        assert_eq!(none.counters(&gpu, ["a"]).unwrap(), [Counter::of("a", [])]);
    }
}
