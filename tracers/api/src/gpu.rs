//! The device: choosing an adapter, creating checked buffers, reading back.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use serde::{Deserialize, Serialize};
use wgpu::{Backends, BufferUsages, DeviceType, Features};

use crate::TracerError;
use crate::clock::Stamps;

/// What a user may say about the adapter.
#[derive(Clone, Debug, Default)]
pub struct AdapterChoice {
    /// Part of an adapter's name (case does not matter) or its number in [`list_adapters`]. Without one the most capable
    /// kind of device is taken.
    pub wanted: Option<String>,
}

impl AdapterChoice {
    /// The adapter that is asked for, else the one that `WGPU_ADAPTER_NAME` names, if it does.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if `WGPU_BACKEND`, which limits the choice, is set and names no backend.
    pub fn from_environment(wanted: Option<&str>) -> Result<Self, TracerError> {
        let set = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
        if let Some(value) = set(BACKEND_VARIABLE).filter(|value| Backends::from_comma_list(value).is_empty()) {
            return Err(TracerError::Failed(format!(
                "{BACKEND_VARIABLE}={value} names no backend: use vulkan, metal or dx12, or unset it"
            )));
        }
        Ok(Self { wanted: wanted.map(str::to_owned).or_else(|| set("WGPU_ADAPTER_NAME")) })
    }
}

/// Which backends adapters are looked for in; read by wgpu's own rules.
const BACKEND_VARIABLE: &str = "WGPU_BACKEND";

/// An adapter as users see it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdapterListing {
    /// The adapter's name.
    pub name: String,
    /// `vulkan`, `metal`, `dx12`, ...
    pub backend: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: String,
    /// The driver's name.
    pub driver: String,
    /// The driver's version.
    pub driver_version: String,
    /// Largest storage binding, bytes.
    pub max_storage_binding_bytes: u64,
    /// Largest buffer, bytes.
    pub max_buffer_bytes: u64,
    /// Largest edge of a 2D texture, texels.
    pub max_texture_edge: u32,
    /// Whether times can be taken on the device between passes.
    pub timestamps: bool,
}

/// A device that is ready for use, with its limits raised to what the adapter has. One sample is timed at a time: two
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
    pub listing: AdapterListing,
    pub(crate) stamps: Option<Stamps>,
    errors: Arc<Mutex<Vec<String>>>,
    lost: Arc<AtomicBool>,
}

const TIMESTAMP_FEATURES: Features = Features::TIMESTAMP_QUERY.union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);

/// What tracers use where the adapter has it.
const WANTED_FEATURES: Features =
    TIMESTAMP_FEATURES.union(Features::EXPERIMENTAL_RAY_QUERY).union(Features::SHADER_EARLY_DEPTH_TEST);

/// wgpu's leave to use what it calls experimental, which ray queries are.
#[allow(unsafe_code, reason = "the leave can be had in no other way")]
fn experimental() -> wgpu::ExperimentalFeatures {
    // SAFETY: asked of the caller is to know that these parts of wgpu may have errors, undefined behaviour included. They
    // are reached through wgpu's checked interface alone, by a tracer that uses them as wgpu documents, on adapters that
    // offer them.
    unsafe { wgpu::ExperimentalFeatures::enabled() }
}

/// The adapters of this machine, in the driver's order; empty without a Vulkan loader, Metal or DirectX 12.
pub fn list_adapters() -> Vec<AdapterListing> {
    enumerate().iter().map(listing).collect()
}

fn enumerate() -> Vec<wgpu::Adapter> {
    let from_environment = Backends::from_env().filter(|backends| !backends.is_empty());
    let backends = from_environment.unwrap_or(Backends::VULKAN | Backends::METAL | Backends::DX12);
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    let instance = wgpu::Instance::new(descriptor);
    pollster::block_on(instance.enumerate_adapters(backends))
}

fn listing(adapter: &wgpu::Adapter) -> AdapterListing {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => "discrete",
        DeviceType::IntegratedGpu => "integrated",
        DeviceType::VirtualGpu => "virtual",
        DeviceType::Cpu => "software",
        DeviceType::Other => "other",
    };
    AdapterListing {
        name: info.name,
        backend: info.backend.to_string(),
        kind: kind.to_owned(),
        driver: info.driver,
        driver_version: info.driver_info,
        max_storage_binding_bytes: limits.max_storage_buffer_binding_size,
        max_buffer_bytes: limits.max_buffer_size,
        max_texture_edge: limits.max_texture_dimension_2d,
        timestamps: adapter.features().contains(TIMESTAMP_FEATURES),
    }
}

/// Lower is preferred.
fn preference(kind: &str) -> u32 {
    ["discrete", "integrated", "virtual", "other", "software"].iter().position(|known| *known == kind).unwrap_or(9)
        as u32
}

fn choose(listings: &[AdapterListing], wanted: Option<&str>) -> Result<usize, TracerError> {
    if listings.is_empty() {
        return Err(TracerError::Unavailable(
            "no graphics adapter was found: install a Vulkan loader and driver (setup.sh does this on Debian and \
             Ubuntu), or use a tracer that runs on the host"
                .to_owned(),
        ));
    }
    let Some(wanted) = wanted else {
        return Ok((0..listings.len()).min_by_key(|index| preference(&listings[*index].kind)).unwrap_or(0));
    };
    if let Some(index) = wanted.parse::<usize>().ok().filter(|index| *index < listings.len()) {
        return Ok(index);
    }
    let lowered = wanted.to_lowercase();
    let found = listings.iter().position(|listing| listing.name.to_lowercase().contains(&lowered));
    found.ok_or_else(|| {
        let names: Vec<_> = listings.iter().map(|listing| listing.name.as_str()).collect();
        TracerError::Unavailable(format!("no adapter is called '{wanted}'; there are: {}", names.join(", ")))
    })
}

impl Gpu {
    /// Opens the chosen adapter.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] without an adapter (or one of the wanted name), [`TracerError::Failed`] if the
    /// driver refuses a device.
    pub fn open(choice: &AdapterChoice) -> Result<Self, TracerError> {
        let adapters = enumerate();
        let listings: Vec<_> = adapters.iter().map(listing).collect();
        let chosen = choose(&listings, choice.wanted.as_deref())?;
        let (adapter, listing) = (&adapters[chosen], listings[chosen].clone());
        let (features, limits) = (adapter.features() & WANTED_FEATURES, adapter.limits());
        let with_ray_queries = features.contains(Features::EXPERIMENTAL_RAY_QUERY);
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("tracebench"),
            required_features: features,
            // Those of acceleration structures too, which are 0 where the adapter has none.
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
                list.push(error.to_string());
            }
        }));
        let lost = Arc::new(AtomicBool::new(false));
        let sink = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, _| sink.store(true, Ordering::Relaxed));
        let stamps = listing.timestamps.then(|| Stamps::new(&device, &queue));
        Ok(Self { device, queue, limits, listing, stamps, errors, lost })
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
    /// [`TracerError::TooLarge`] beyond the device's limits, naming `turn_down` as the remedy.
    pub fn buffer(
        &self,
        name: &str,
        bytes: u64,
        usage: BufferUsages,
        turn_down: &str,
    ) -> Result<wgpu::Buffer, TracerError> {
        let size = bytes.max(4).next_multiple_of(4);
        let limit = self.limits.max_buffer_size;
        if size > limit {
            return Err(TracerError::TooLarge {
                name: name.to_owned(),
                bytes: size,
                limit,
                turn_down: turn_down.to_owned(),
            });
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
        turn_down: &str,
    ) -> Result<wgpu::Buffer, TracerError> {
        let buffer = self.buffer(name, contents.len() as u64, usage | BufferUsages::COPY_DST, turn_down)?;
        self.queue.write_buffer(&buffer, 0, contents);
        Ok(buffer)
    }

    /// Checks that a buffer can be bound as one storage binding.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if not.
    pub fn check_storage_binding(&self, name: &str, bytes: u64, turn_down: &str) -> Result<(), TracerError> {
        let limit = self.limits.max_storage_buffer_binding_size;
        if bytes <= limit {
            return Ok(());
        }
        Err(TracerError::TooLarge { name: name.to_owned(), bytes, limit, turn_down: turn_down.to_owned() })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(name: &str, kind: &str) -> AdapterListing {
        AdapterListing {
            name: name.to_owned(),
            backend: "vulkan".to_owned(),
            kind: kind.to_owned(),
            driver: String::new(),
            driver_version: String::new(),
            max_storage_binding_bytes: 0,
            max_buffer_bytes: 0,
            max_texture_edge: 0,
            timestamps: false,
        }
    }

    /// Hardware is preferred, a name or number overrides, and what is not there is an error that lists what is.
    #[test]
    fn choice_prefers_hardware_and_obeys_names() {
        let adapters = [adapter("llvmpipe", "software"), adapter("Big GPU", "discrete")];
        assert_eq!(choose(&adapters, None).unwrap(), 1);
        assert_eq!(choose(&adapters, Some("LLVM")).unwrap(), 0);
        assert_eq!(choose(&adapters, Some("0")).unwrap(), 0);
        assert!(choose(&adapters, Some("nothing")).unwrap_err().to_string().contains("Big GPU"));
        assert!(choose(&[], None).unwrap_err().to_string().contains("setup.sh"));
    }
}
