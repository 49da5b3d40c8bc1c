//! Adapters: what this machine has, which one is meant, and within which of its limits a device is opened.

use serde::{Deserialize, Serialize};
use wgpu::{Backends, DeviceType, Features};

use crate::TracerError;

/// What a user may say about the adapter.
#[derive(Clone, Debug, Default)]
pub struct AdapterChoice {
    /// Part of an adapter's name (case does not matter) or its number in [`list_adapters`]. Without one the most capable
    /// kind of device is taken.
    pub wanted: Option<String>,
    /// Within which limits the device is opened.
    pub limits: DeviceLimits,
}

/// Which limits and features a device is opened with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeviceLimits {
    /// All that the adapter has.
    #[default]
    Adapter,
    /// WebGPU's default limits, which every browser grants, and no feature beyond its core.
    Webgpu,
}

impl DeviceLimits {
    /// Their names, for the command line and the environment.
    pub const NAMES: [&'static str; 2] = ["adapter", "webgpu"];

    /// Those of a name.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "adapter" => Some(Self::Adapter),
            "webgpu" => Some(Self::Webgpu),
            _ => None,
        }
    }

    /// Whether they are all that the adapter has.
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
    fn are_the_adapters(&self) -> bool {
        *self == Self::Adapter
    }

    /// The limits and features of a device on an adapter.
    pub(crate) fn of(self, adapter: &wgpu::Adapter) -> (wgpu::Limits, Features) {
        match self {
            // Limits of acceleration structures too, which are 0 where the adapter has none.
            Self::Adapter => (adapter.limits(), adapter.features() & WANTED_FEATURES),
            Self::Webgpu => (wgpu::Limits::defaults(), Features::empty()),
        }
    }
}

impl AdapterChoice {
    /// The adapter that is asked for, else the one that `WGPU_ADAPTER_NAME` names, if it does; limits likewise, by
    /// `TRACEBENCH_LIMITS`.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if `WGPU_BACKEND`, which limits the choice, is set and names no backend, or
    /// `TRACEBENCH_LIMITS` no limits.
    pub fn from_environment(wanted: Option<&str>, limits: Option<DeviceLimits>) -> Result<Self, TracerError> {
        let set = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
        if let Some(value) = set(BACKEND_VARIABLE).filter(|value| Backends::from_comma_list(value).is_empty()) {
            return Err(TracerError::Failed(format!(
                "{BACKEND_VARIABLE}={value} names no backend: use vulkan, metal or dx12, or unset it"
            )));
        }
        let named = |name: String| {
            let known = DeviceLimits::NAMES.join(" or ");
            let unknown = || TracerError::Failed(format!("{LIMITS_VARIABLE}={name}: it is {known}, or not set"));
            DeviceLimits::named(&name).ok_or_else(unknown)
        };
        let from_environment = || set(LIMITS_VARIABLE).map(named).transpose();
        let limits = limits.map_or_else(from_environment, |limits| Ok(Some(limits)))?.unwrap_or_default();
        Ok(Self { wanted: wanted.map(str::to_owned).or_else(|| set("WGPU_ADAPTER_NAME")), limits })
    }
}

/// Which backends adapters are looked for in; read by wgpu's own rules.
const BACKEND_VARIABLE: &str = "WGPU_BACKEND";

/// Within which limits devices are opened where nothing is said.
const LIMITS_VARIABLE: &str = "TRACEBENCH_LIMITS";

/// An adapter as users see it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdapterInfo {
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
    /// Storage buffers that one stage of a shader can bind; 0 in records that are older than this.
    #[serde(default, skip_serializing_if = "is_untold")]
    pub max_storage_buffers_per_stage: u32,
    /// Whether times can be taken on the device between passes.
    pub timestamps: bool,
    /// Within which limits the device was opened: the figures above are of these.
    #[serde(default, skip_serializing_if = "DeviceLimits::are_the_adapters")]
    pub limits: DeviceLimits,
}

const TIMESTAMP_FEATURES: Features = Features::TIMESTAMP_QUERY.union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);

/// What tracers use where the adapter has it.
const WANTED_FEATURES: Features =
    TIMESTAMP_FEATURES.union(Features::EXPERIMENTAL_RAY_QUERY).union(Features::SHADER_EARLY_DEPTH_TEST);

/// The adapters of this machine, in the driver's order; empty without a Vulkan loader, Metal or DirectX 12.
pub fn list_adapters() -> Vec<AdapterInfo> {
    enumerate().iter().map(|adapter| listing(adapter, DeviceLimits::Adapter)).collect()
}

pub(crate) fn enumerate() -> Vec<wgpu::Adapter> {
    let from_environment = Backends::from_env().filter(|backends| !backends.is_empty());
    let backends = from_environment.unwrap_or(Backends::VULKAN | Backends::METAL | Backends::DX12);
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    let instance = wgpu::Instance::new(descriptor);
    pollster::block_on(instance.enumerate_adapters(backends))
}

/// Whether a count is that of a record from before it was told.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_untold(count: &u32) -> bool {
    *count == 0
}

pub(crate) fn listing(adapter: &wgpu::Adapter, within: DeviceLimits) -> AdapterInfo {
    let (info, (limits, features)) = (adapter.get_info(), within.of(adapter));
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => "discrete",
        DeviceType::IntegratedGpu => "integrated",
        DeviceType::VirtualGpu => "virtual",
        DeviceType::Cpu => "software",
        DeviceType::Other => "other",
    };
    AdapterInfo {
        name: info.name,
        backend: info.backend.to_string(),
        kind: kind.to_owned(),
        driver: info.driver,
        driver_version: info.driver_info,
        max_storage_binding_bytes: limits.max_storage_buffer_binding_size,
        max_buffer_bytes: limits.max_buffer_size,
        max_texture_edge: limits.max_texture_dimension_2d,
        max_storage_buffers_per_stage: limits.max_storage_buffers_per_shader_stage,
        timestamps: features.contains(TIMESTAMP_FEATURES),
        limits: within,
    }
}

/// Lower is preferred.
fn preference(kind: &str) -> u32 {
    ["discrete", "integrated", "virtual", "other", "software"].iter().position(|known| *known == kind).unwrap_or(9)
        as u32
}

pub(crate) fn choose(listings: &[AdapterInfo], wanted: Option<&str>) -> Result<usize, TracerError> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(name: &str, kind: &str) -> AdapterInfo {
        AdapterInfo {
            name: name.to_owned(),
            backend: "vulkan".to_owned(),
            kind: kind.to_owned(),
            driver: String::new(),
            driver_version: String::new(),
            max_storage_binding_bytes: 0,
            max_buffer_bytes: 0,
            max_texture_edge: 0,
            max_storage_buffers_per_stage: 0,
            timestamps: false,
            limits: DeviceLimits::Adapter,
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

    /// Limits have the names that they are listed with.
    #[test]
    fn limits_go_by_their_names() {
        let named = DeviceLimits::NAMES.map(DeviceLimits::named);
        assert_eq!(named, [Some(DeviceLimits::Adapter), Some(DeviceLimits::Webgpu)]);
        assert_eq!(DeviceLimits::named("none"), None);
    }
}
