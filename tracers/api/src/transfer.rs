//! Rays, hits and surfaces where the tracer wants them: in host memory, or on the device.

use std::sync::Arc;

use bytemuck::Pod;
use wgpu::BufferUsages;

use crate::{Gpu, Hit, MemoryEntry, Query, Ray, Residency, Surface, TraceTo, TracerError};

/// One ray set; made once, uploaded once, the same for every tracer.
#[derive(Clone, Debug)]
pub struct RayBuffer {
    /// The rays; of rays chosen on the device all that they were chosen from.
    pub host: Arc<Vec<Ray>>,
    /// The rays in a storage buffer, or why they are in none.
    device: Result<wgpu::Buffer, TracerError>,
    /// What is asked of them.
    pub query: Query,
    /// Workgroups of a search, where only the device knows how many rays are asked.
    workgroups: Option<wgpu::Buffer>,
}

const HINT: &str = "--size";

impl RayBuffer {
    /// Takes the rays and uploads them if there is a device. That a device cannot hold or bind them is said to those
    /// who ask for them there: host tracers need not mind.
    pub fn new(rays: Arc<Vec<Ray>>, query: Query, gpu: Option<&Gpu>) -> Self {
        let device = match gpu {
            None => Err(TracerError::Unavailable("the rays are not on a device".to_owned())),
            Some(gpu) => upload(gpu, bytemuck::cast_slice(&rays)),
        };
        Self { host: rays, device, query, workgroups: None }
    }

    /// Some of these rays, chosen on the device: a storage buffer of as many records, the chosen rays first, and behind them rays that end
    /// before they begin (`t_min` > `t_max`) and hit nothing. Hits have room for all. `workgroups` tells searches how many are to be
    /// asked, by three words for every number of rays a lane (`dispatch_rays` of kit); without it all are.
    #[must_use]
    pub fn chosen(&self, rays: wgpu::Buffer, workgroups: Option<wgpu::Buffer>) -> Self {
        Self { host: Arc::clone(&self.host), device: Ok(rays), query: self.query, workgroups }
    }

    /// The workgroups of searches, where only the device knows how many rays are asked.
    pub fn workgroups(&self) -> Option<&wgpu::Buffer> {
        self.workgroups.as_ref()
    }

    /// Whether a device can bind that many rays.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if not.
    pub fn check_fits(gpu: &Gpu, count: u64) -> Result<(), TracerError> {
        gpu.check_storage_binding("the ray buffer", count * size_of::<Ray>() as u64, HINT)
    }

    /// The device copy.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] without a device, [`TracerError::TooLarge`] if it cannot hold or bind them.
    pub fn on_device(&self) -> Result<&wgpu::Buffer, TracerError> {
        self.device.as_ref().map_err(Clone::clone)
    }
}

fn upload(gpu: &Gpu, contents: &[u8]) -> Result<wgpu::Buffer, TracerError> {
    RayBuffer::check_fits(gpu, (contents.len() / size_of::<Ray>()) as u64)?;
    // No rays at all still need a buffer that can be bound.
    let none = [0; size_of::<Ray>()];
    let contents = if contents.is_empty() { &none } else { contents };
    gpu.buffer_with("the ray buffer", contents, BufferUsages::STORAGE, HINT)
}

/// Where a tracer writes its answers, one per ray: hits, and surfaces where the job ends there.
#[derive(Debug)]
pub struct HitBuffer {
    count: usize,
    hits: Records<Hit>,
    surfaces: Option<Records<Surface>>,
}

/// Records of one kind, one per ray.
#[derive(Debug)]
enum Records<T> {
    /// In host memory.
    Host(Vec<T>),
    /// In a storage buffer.
    Device(wgpu::Buffer),
}

impl<T: Pod> Records<T> {
    fn new(name: &str, count: usize, residency: Residency, gpu: Option<&Gpu>) -> Result<Self, TracerError> {
        match (residency, gpu) {
            (Residency::Host, _) => Ok(Self::Host(vec![T::zeroed(); count])),
            (Residency::Device, None) => Err(TracerError::Unavailable("no device".to_owned())),
            (Residency::Device, Some(gpu)) => {
                let bytes = (count.max(1) * size_of::<T>()) as u64;
                gpu.check_storage_binding(name, bytes, HINT)?;
                let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
                Ok(Self::Device(gpu.buffer(name, bytes, usage, HINT)?))
            }
        }
    }

    fn poison(&mut self, gpu: Option<&Gpu>) -> Result<(), TracerError> {
        match (self, gpu) {
            (Self::Host(records), _) => records.fill(T::zeroed()),
            (Self::Device(..), None) => return Err(TracerError::Unavailable("no device".to_owned())),
            (Self::Device(buffer), Some(gpu)) => {
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                encoder.clear_buffer(buffer, 0, None);
                gpu.queue.submit([encoder.finish()]);
                gpu.wait()?;
            }
        }
        Ok(())
    }

    fn read(&self, count: usize, gpu: Option<&Gpu>) -> Result<Vec<T>, TracerError> {
        match (self, gpu) {
            (Self::Host(records), _) => Ok(records.clone()),
            (Self::Device(..), None) => Err(TracerError::Unavailable("no device".to_owned())),
            (Self::Device(..), Some(_)) if count == 0 => Ok(Vec::new()),
            (Self::Device(buffer), Some(gpu)) => {
                Ok(bytemuck::pod_collect_to_vec(&gpu.read(buffer, (count * size_of::<T>()) as u64)?))
            }
        }
    }

    fn on_host(&mut self) -> Result<&mut [T], TracerError> {
        match self {
            Self::Host(records) => Ok(records),
            Self::Device(..) => Err(TracerError::Failed("a host tracer was given device hits".to_owned())),
        }
    }

    fn on_device(&self) -> Result<&wgpu::Buffer, TracerError> {
        match self {
            Self::Device(buffer) => Ok(buffer),
            Self::Host(_) => Err(TracerError::Failed("a device tracer was given host hits".to_owned())),
        }
    }
}

/// Name of the device's buffer of surfaces.
const SHADING_BUFFER: &str = "shading buffer";

fn without_surfaces() -> TracerError {
    TracerError::Failed(
        "surfaces are asked for, and there is no room for them: make the hit buffer for that end".into(),
    )
}

impl HitBuffer {
    /// Room for `count` poisoned hits.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold or bind them, [`TracerError::Unavailable`] without one.
    pub fn new(count: usize, residency: Residency, gpu: Option<&Gpu>) -> Result<Self, TracerError> {
        Self::tracing_to(TraceTo::Hit, count, residency, gpu)
    }

    /// Room for what `count` rays traced to an end leave, poisoned.
    ///
    /// # Errors
    /// As [`HitBuffer::new`].
    pub fn tracing_to(
        trace_to: TraceTo,
        count: usize,
        residency: Residency,
        gpu: Option<&Gpu>,
    ) -> Result<Self, TracerError> {
        let hits = Records::new("the hit buffer", count, residency, gpu)?;
        let surfaces = match trace_to {
            TraceTo::Hit => None,
            TraceTo::Surface => Some(Records::new(SHADING_BUFFER, count, residency, gpu)?),
        };
        Ok(Self { count, hits, surfaces })
    }

    /// Names and bytes of what `count` rays take that are traced to an end: the rays themselves, hits, surfaces.
    pub fn memory(trace_to: TraceTo, count: usize) -> Vec<MemoryEntry> {
        let of = |name, bytes: usize| MemoryEntry::whole(name, (count * bytes) as u64);
        let mut parts = vec![of("rays", size_of::<Ray>()), of("hits", size_of::<Hit>())];
        if trace_to == TraceTo::Surface {
            parts.push(of(SHADING_BUFFER, size_of::<Surface>()));
        }
        parts
    }

    /// Overwrites everything with the poison (all zeros, status "unwritten").
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn poison(&mut self, gpu: Option<&Gpu>) -> Result<(), TracerError> {
        self.hits.poison(gpu)?;
        self.surfaces.as_mut().map_or(Ok(()), |surfaces| surfaces.poison(gpu))
    }

    /// The hits, in ray order.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn read(&self, gpu: Option<&Gpu>) -> Result<Vec<Hit>, TracerError> {
        self.hits.read(self.count, gpu)
    }

    /// The surfaces, in ray order; none where there is no room for any.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn read_surfaces(&self, gpu: Option<&Gpu>) -> Result<Vec<Surface>, TracerError> {
        self.surfaces.as_ref().map_or(Ok(Vec::new()), |surfaces| surfaces.read(self.count, gpu))
    }

    /// The host's hits, for the answers to that many rays.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the hits are on the device or of another number.
    pub fn host_mut(&mut self, rays: usize) -> Result<&mut [Hit], TracerError> {
        check_count(self.count, rays)?;
        self.hits.on_host()
    }

    /// The host's hits and surfaces, for the answers to that many rays.
    ///
    /// # Errors
    /// As [`HitBuffer::host_mut`]; [`TracerError::Failed`] without room for surfaces.
    pub fn host_surfaces_mut(&mut self, rays: usize) -> Result<(&mut [Hit], &mut [Surface]), TracerError> {
        check_count(self.count, rays)?;
        let surfaces = self.surfaces.as_mut().ok_or_else(without_surfaces)?;
        Ok((self.hits.on_host()?, surfaces.on_host()?))
    }

    /// The device's buffer of hits, for the answers to that many rays.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the hits are in host memory or of another number.
    pub fn on_device(&self, rays: usize) -> Result<&wgpu::Buffer, TracerError> {
        check_count(self.count, rays)?;
        self.hits.on_device()
    }

    /// The device's buffer of surfaces, for the answers to that many rays.
    ///
    /// # Errors
    /// As [`HitBuffer::on_device`]; [`TracerError::Failed`] without room for surfaces.
    pub fn surfaces_on_device(&self, rays: usize) -> Result<&wgpu::Buffer, TracerError> {
        check_count(self.count, rays)?;
        self.surfaces.as_ref().ok_or_else(without_surfaces)?.on_device()
    }
}

fn check_count(hits: usize, rays: usize) -> Result<(), TracerError> {
    if hits == rays { Ok(()) } else { Err(TracerError::Failed(format!("room for {hits} hits, but {rays} rays"))) }
}
