//! Rays and hits where the tracer wants them: in host memory, or on the device.

use std::sync::Arc;

use wgpu::BufferUsages;

use crate::{Gpu, Hit, Query, Ray, Residency, TracerError};

/// One ray set; made once, uploaded once, the same for every tracer.
#[derive(Clone, Debug)]
pub struct RayBuffer {
    /// The rays.
    pub host: Arc<Vec<Ray>>,
    /// The rays in a storage buffer, or why they are in none.
    device: Result<wgpu::Buffer, TracerError>,
    /// What is asked of them.
    pub query: Query,
}

const TURN_DOWN: &str = "--size";

impl RayBuffer {
    /// Takes the rays and uploads them if there is a device. That a device cannot hold or bind them is said to those
    /// who ask for them there: host tracers need not mind.
    pub fn new(rays: Arc<Vec<Ray>>, query: Query, gpu: Option<&Gpu>) -> Self {
        let device = match gpu {
            None => Err(TracerError::Unavailable("the rays are not on a device".to_owned())),
            Some(gpu) => upload(gpu, bytemuck::cast_slice(&rays)),
        };
        Self { host: rays, device, query }
    }

    /// Whether a device can bind that many rays.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if not.
    pub fn check_fits(gpu: &Gpu, count: u64) -> Result<(), TracerError> {
        gpu.check_storage_binding("the ray buffer", count * size_of::<Ray>() as u64, TURN_DOWN)
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
    gpu.buffer_with("the ray buffer", contents, BufferUsages::STORAGE, TURN_DOWN)
}

/// Where a tracer writes its answers, one per ray.
#[derive(Debug)]
pub enum HitBuffer {
    /// In host memory.
    Host(Vec<Hit>),
    /// In a storage buffer, with the count.
    Device(wgpu::Buffer, usize),
}

impl HitBuffer {
    /// Room for `count` poisoned hits.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold or bind them, [`TracerError::Unavailable`] without one.
    pub fn new(count: usize, residency: Residency, gpu: Option<&Gpu>) -> Result<Self, TracerError> {
        match (residency, gpu) {
            (Residency::Host, _) => Ok(Self::Host(vec![bytemuck::Zeroable::zeroed(); count])),
            (Residency::Device, None) => Err(TracerError::Unavailable("no device".to_owned())),
            (Residency::Device, Some(gpu)) => {
                let bytes = (count.max(1) * size_of::<Hit>()) as u64;
                gpu.check_storage_binding("the hit buffer", bytes, TURN_DOWN)?;
                let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
                Ok(Self::Device(gpu.buffer("the hit buffer", bytes, usage, TURN_DOWN)?, count))
            }
        }
    }

    /// Overwrites every hit with the poison (all zeros, status "unwritten").
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn poison(&mut self, gpu: Option<&Gpu>) -> Result<(), TracerError> {
        match (self, gpu) {
            (Self::Host(hits), _) => hits.fill(bytemuck::Zeroable::zeroed()),
            (Self::Device(..), None) => return Err(TracerError::Unavailable("no device".to_owned())),
            (Self::Device(buffer, _), Some(gpu)) => {
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                encoder.clear_buffer(buffer, 0, None);
                gpu.queue.submit([encoder.finish()]);
                gpu.wait()?;
            }
        }
        Ok(())
    }

    /// The answers, in ray order.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn read(&self, gpu: Option<&Gpu>) -> Result<Vec<Hit>, TracerError> {
        match (self, gpu) {
            (Self::Host(hits), _) => Ok(hits.clone()),
            (Self::Device(..), None) => Err(TracerError::Unavailable("no device".to_owned())),
            (Self::Device(_, 0), Some(_)) => Ok(Vec::new()),
            (Self::Device(buffer, count), Some(gpu)) => {
                let bytes = gpu.read(buffer, (count * size_of::<Hit>()) as u64)?;
                Ok(bytemuck::pod_collect_to_vec(&bytes))
            }
        }
    }

    /// The host's slice, for the answers to that many rays.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the hits are on the device or of another number.
    pub fn host_mut(&mut self, rays: usize) -> Result<&mut [Hit], TracerError> {
        match self {
            Self::Host(hits) => check_count(hits.len(), rays).map(|()| hits.as_mut_slice()),
            Self::Device(..) => Err(TracerError::Failed("a host tracer was given device hits".to_owned())),
        }
    }

    /// The device's buffer, for the answers to that many rays.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the hits are in host memory or of another number.
    pub fn on_device(&self, rays: usize) -> Result<&wgpu::Buffer, TracerError> {
        match self {
            Self::Device(buffer, count) => check_count(*count, rays).map(|()| buffer),
            Self::Host(_) => Err(TracerError::Failed("a device tracer was given host hits".to_owned())),
        }
    }
}

fn check_count(hits: usize, rays: usize) -> Result<(), TracerError> {
    if hits == rays { Ok(()) } else { Err(TracerError::Failed(format!("room for {hits} hits, but {rays} rays"))) }
}
