//! The device: opening it, creating checked buffers, reading back.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use wgpu::{BufferUsages, DownlevelFlags, Features};

use crate::adapter::{choose, enumerate, listing};
use crate::clock::Stamps;
use crate::{AdapterChoice, AdapterInfo, Rasterizer, TracerError};

/// A device that is ready for use, within the limits that were chosen. One sample is timed at a time: two
/// threads that time on one device get errors.
#[derive(Debug)]
pub struct Gpu {
    /// The logical device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The device's limits.
    pub limits: wgpu::Limits,
    /// What to tell users about it.
    pub listing: AdapterInfo,
    pub(crate) stamps: Option<Stamps>,
    rasterizer: OnceLock<Rasterizer>,
    errors: Arc<Mutex<Vec<String>>>,
    lost: Arc<AtomicBool>,
}

/// wgpu's leave to use what it calls experimental, which ray queries are.
#[allow(unsafe_code, reason = "the leave can be had in no other way")]
fn experimental() -> wgpu::ExperimentalFeatures {
    // SAFETY: asked of the caller is to know that these parts of wgpu may have errors, undefined behaviour included. They
    // are reached through wgpu's checked interface alone, by a tracer that uses them as wgpu documents, on adapters that
    // offer them.
    unsafe { wgpu::ExperimentalFeatures::enabled() }
}

impl Gpu {
    /// Opens the chosen adapter.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] without an adapter (or one of the wanted name), [`TracerError::Failed`] if the
    /// driver refuses a device.
    pub fn open(choice: &AdapterChoice) -> Result<Self, TracerError> {
        let adapters = enumerate();
        let listings: Vec<_> = adapters.iter().map(|adapter| listing(adapter, choice.limits)).collect();
        let chosen = choose(&listings, choice.wanted.as_deref())?;
        let (adapter, listing) = (&adapters[chosen], listings[chosen].clone());
        // What the driver would say where a tracer first needs more, if it said anything.
        if !adapter.get_downlevel_capabilities().flags.contains(DownlevelFlags::WEBGPU_TEXTURE_FORMAT_SUPPORT) {
            return Err(TracerError::Unavailable(format!(
                "{} by the {} backend has not all that WebGPU guarantees (textures of every format): unset WGPU_BACKEND or set it to \
                 vulkan, metal or dx12, or use a tracer that runs on the host",
                listing.name, listing.backend
            )));
        }
        let (limits, features) = choice.limits.of(adapter);
        let with_ray_queries = features.contains(Features::EXPERIMENTAL_RAY_QUERY);
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("tracebench"),
            required_features: features,
            required_limits: limits.clone(),
            experimental_features: if with_ray_queries { experimental() } else { Default::default() },
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(request)
            .map_err(|error| TracerError::Failed(format!("{} refuses a device: {error}", listing.name)))?;
        let errors = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&errors);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            if let Ok(mut list) = sink.lock() {
                // In one line: what is told of it stands in tables.
                list.push(error.to_string().split_whitespace().collect::<Vec<_>>().join(" "));
            }
        }));
        let lost = Arc::new(AtomicBool::new(false));
        let sink = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, _| sink.store(true, Ordering::Relaxed));
        let stamps = listing.timestamps.then(|| Stamps::new(&device, &queue));
        let rasterizer = OnceLock::new();
        Ok(Self { device, queue, limits, listing, stamps, rasterizer, errors, lost })
    }

    /// What its rasterizer was found to do; `probe` finds it where nobody has asked before.
    ///
    /// # Errors
    /// Those of `probe`.
    pub fn rasterizer(
        &self,
        probe: impl FnOnce(&Self) -> Result<Rasterizer, TracerError>,
    ) -> Result<Rasterizer, TracerError> {
        match self.rasterizer.get() {
            Some(known) => Ok(*known),
            None => probe(self).map(|found| *self.rasterizer.get_or_init(|| found)),
        }
    }

    /// Whether shaders can ask the device itself for a ray's hits, and the device builds acceleration structures.
    pub fn has_ray_queries(&self) -> bool {
        self.device.features().contains(Features::EXPERIMENTAL_RAY_QUERY)
    }

    /// Whether the device was lost: nothing that it is asked from then on says anything of tracers.
    pub fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Relaxed)
    }

    /// Whether the adapter is a software one, whose times say little of hardware.
    pub fn is_software(&self) -> bool {
        self.listing.kind == "software"
    }

    /// Errors that the device has reported since the last call, as one failure.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if there were any.
    pub fn check(&self) -> Result<(), TracerError> {
        let mut errors = self.errors.lock().map_err(|_| TracerError::Failed("the error log is poisoned".to_owned()))?;
        match errors.drain(..).next() {
            None => Ok(()),
            Some(first) => Err(TracerError::Failed(format!("the device reported an error: {first}"))),
        }
    }

    /// Creates a zeroed buffer of at least 4 bytes (sizes are rounded up to 4).
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits, naming `hint` as the remedy.
    pub fn buffer(&self, name: &str, bytes: u64, usage: BufferUsages, hint: &str) -> Result<wgpu::Buffer, TracerError> {
        let size = bytes.max(4).next_multiple_of(4);
        let limit = self.limits.max_buffer_size;
        if size > limit {
            return Err(TracerError::TooLarge { name: name.to_owned(), bytes: size, limit, hint: hint.to_owned() });
        }
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(name),
            size,
            usage,
            mapped_at_creation: false,
        });
        self.check()?;
        Ok(buffer)
    }

    /// Creates a buffer with contents; see [`Gpu::buffer`].
    ///
    /// # Errors
    /// As [`Gpu::buffer`].
    pub fn buffer_with(
        &self,
        name: &str,
        contents: &[u8],
        usage: BufferUsages,
        hint: &str,
    ) -> Result<wgpu::Buffer, TracerError> {
        let buffer = self.buffer(name, contents.len() as u64, usage | BufferUsages::COPY_DST, hint)?;
        self.queue.write_buffer(&buffer, 0, contents);
        Ok(buffer)
    }

    /// Checks that a buffer can be bound as one storage binding.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if not.
    pub fn check_storage_binding(&self, name: &str, bytes: u64, hint: &str) -> Result<(), TracerError> {
        let limit = self.limits.max_storage_buffer_binding_size;
        if bytes <= limit {
            return Ok(());
        }
        Err(TracerError::TooLarge { name: name.to_owned(), bytes, limit, hint: hint.to_owned() })
    }

    /// Copies the first `bytes` (a multiple of 4) of a buffer with usage `COPY_SRC` to the host.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device reports an error.
    pub fn read(&self, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, TracerError> {
        let staging =
            self.buffer("readback", bytes, BufferUsages::COPY_DST | BufferUsages::MAP_READ, "the size of the run")?;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        self.read_mapped(&staging, bytes)
    }

    /// Reads a buffer with usage `MAP_READ` once everything submitted is done.
    pub(crate) fn read_mapped(&self, staging: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, TracerError> {
        staging.map_async(wgpu::MapMode::Read, 0..bytes, |_| {});
        let waited = self.wait();
        let view = staging.get_mapped_range(0..bytes);
        let copied = view.map(|view| view.to_vec());
        staging.unmap();
        waited?;
        copied.map_err(|error| TracerError::Failed(format!("reading from the device failed: {error}")))
    }

    /// Waits until everything submitted is done.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device was lost or reported an error.
    pub fn wait(&self) -> Result<(), TracerError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| TracerError::Failed(format!("the device stopped: {error}")))?;
        self.check()
    }
}
