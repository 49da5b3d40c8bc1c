//! How searches on the device read and are launched where nothing is set: one rule for all tracers, by a short probe of the adapter.

use tracebench_api::{Choice, TracerError};
use tracebench_kit::{MANY_RAYS, MemoryAccess, ProbeTimes, probe_launch};

use crate::plan::TracerRequest;
use crate::registry::Device;
use crate::results::{LaunchRecord, LaunchSettings, MEMORY_ACCESS, ProbeRecord, RAYS_PER_LANE};

/// Every combination that tables show: what searches read from, with a ray a lane and with as many as the probe tries.
pub fn combinations() -> Vec<LaunchSettings> {
    let of = |rays| MemoryAccess::ALL.iter().map(move |memory_access| LaunchSettings::new(memory_access.name(), rays));
    [1, u64::from(MANY_RAYS)].into_iter().flat_map(of).collect()
}

/// Reads means as `--launch` takes them: `buffer,1`.
///
/// # Errors
/// What is allowed.
pub fn parse(text: &str) -> Result<LaunchSettings, String> {
    let parts = text.split_once(',').and_then(|(memory_access, rays)| Some((memory_access, rays.parse::<u64>().ok()?)));
    let known =
        |(memory_access, rays): &(&str, u64)| MemoryAccess::NAMES.contains(memory_access) && (1..=256).contains(rays);
    let Some((memory_access, rays)) = parts.filter(known) else {
        return Err(format!(
            "MEMORY_ACCESS,RAYS with MEMORY_ACCESS one of {} and RAYS from 1 to 256, like buffer,1",
            MemoryAccess::NAMES.join(", ")
        ));
    };
    Ok(LaunchSettings::new(memory_access, rays))
}

/// The environment's variable in which means are given to every run.
pub const VARIABLE: &str = "TRACEBENCH_LAUNCH";

/// Probes a device.
///
/// # Errors
/// [`TracerError`] if the device refuses or fails; without one there is nothing to probe.
pub fn probe(device: &Device) -> Result<Option<LaunchRecord>, TracerError> {
    let Ok(gpu) = device else { return Ok(None) };
    let ProbeTimes { gather_buffer_ms, gather_texture_ms, one_ray_ms, many_rays_ms } = probe_launch(gpu)?;
    let probe = ProbeRecord {
        gather_buffer_ms,
        gather_texture_ms,
        one_ray_per_lane_ms: one_ray_ms,
        many_rays_per_lane_ms: many_rays_ms,
        many_rays: u64::from(MANY_RAYS),
    };
    Ok(Some(LaunchRecord { launch: probe.launch(), probe: Some(probe) }))
}

impl TracerRequest {
    /// Whether its search can read and be launched in several ways.
    pub fn has_launch_settings(&self) -> bool {
        [MEMORY_ACCESS, RAYS_PER_LANE].iter().any(|name| self.parameters.value(name).is_some())
    }

    /// With means of its own; `None` for a tracer that cannot have them.
    pub(crate) fn with_launch_settings(mut self, launch: &LaunchSettings) -> Option<Self> {
        launch.values().iter().all(|(name, value)| self.set(name, value).is_ok()).then_some(self)
    }

    /// Takes means where none are set; they do not count as changed.
    pub fn use_launch_settings(&mut self, launch: &LaunchSettings) {
        let described = self.registration.describe().parameters;
        for (name, value) in launch.values() {
            let own = self.changed.iter().any(|changed| changed == name);
            if !own && self.parameters.value(name).is_some() {
                // A tracer that cannot have the value keeps its own.
                let _ = self.parameters.set(&described, name, &value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use tracebench_api::Preset;

    use super::*;
    use crate::registry::TRACERS;

    /// Proves that means are taken by every tracer that has the choice where nothing is set, that what is set stays, that they do not
    /// count as changed, and that other parameters stay.
    #[test]
    fn launch_settings_are_used_where_none_are_set() {
        let launch = LaunchSettings::new("texture", 32);
        let value = |request: &TracerRequest, name: &str| request.parameters.value(name).map(ToString::to_string);
        let mut with_launch_settings = 0;
        for registration in TRACERS {
            let plain = TracerRequest::of(registration, Preset::Published);
            let mut taken = plain.clone();
            taken.use_launch_settings(&launch);
            assert!(taken.changed.is_empty());
            for (name, before) in plain.parameters.iter() {
                let expected = match name {
                    MEMORY_ACCESS => "texture".to_owned(),
                    RAYS_PER_LANE => "32".to_owned(),
                    _ => before.to_string(),
                };
                assert_eq!(value(&taken, name), Some(expected), "{}", plain.name());
            }
            with_launch_settings += usize::from(plain.has_launch_settings());
            let mut own = plain.clone();
            if own.set(MEMORY_ACCESS, "buffer").is_ok() {
                own.use_launch_settings(&launch);
                assert_eq!(
                    (value(&own, MEMORY_ACCESS).unwrap(), value(&own, RAYS_PER_LANE).unwrap()),
                    ("buffer".to_owned(), "32".to_owned())
                );
            }
        }
        assert!(with_launch_settings >= 2 && with_launch_settings < TRACERS.len());
    }

    /// What is given as means is read, and what is none is refused with what is.
    #[test]
    fn launch_settings_are_read() {
        for launch in combinations() {
            assert_eq!(parse(&format!("{},{}", launch.memory_access, launch.rays_per_lane)), Ok(launch));
        }
        for wrong in ["", "buffer", "buffer,0", "buffer,257", "buffers,1", "texture,32,1", "1,buffer"] {
            assert!(parse(wrong).unwrap_err().contains("buffer, texture"), "{wrong}");
        }
    }
}
