//! How searches on the device read and are launched where nothing is set: one rule for all tracers, by a short probe of the adapter.

use tracebench_api::{Choice, TracerError};
use tracebench_kit::{MANY_RAYS, ProbeTimes, Reads, probe_means};

use crate::plan::TracerRequest;
use crate::registry::Device;
use crate::results::{Means, MeansRecord, ProbeRecord, RAYS_PER_LANE, READS};

/// Every combination that tables show: what searches read from, with a ray a lane and with as many as the probe tries.
pub fn combinations() -> Vec<Means> {
    let of = |rays| Reads::ALL.iter().map(move |reads| Means::new(reads.name(), rays));
    [1, u64::from(MANY_RAYS)].into_iter().flat_map(of).collect()
}

/// Reads means as `--means` takes them: `buffer,1`.
///
/// # Errors
/// What is allowed.
pub fn parse(text: &str) -> Result<Means, String> {
    let parts = text.split_once(',').and_then(|(reads, rays)| Some((reads, rays.parse::<u64>().ok()?)));
    let known = |(reads, rays): &(&str, u64)| Reads::NAMES.contains(reads) && (1..=256).contains(rays);
    let Some((reads, rays)) = parts.filter(known) else {
        return Err(format!(
            "READS,RAYS with READS one of {} and RAYS from 1 to 256, like buffer,1",
            Reads::NAMES.join(", ")
        ));
    };
    Ok(Means::new(reads, rays))
}

/// The environment's variable in which means are given to every run.
pub const VARIABLE: &str = "TRACEBENCH_MEANS";

/// Probes a device.
///
/// # Errors
/// [`TracerError`] if the device refuses or fails; without one there is nothing to probe.
pub fn probe(device: &Device) -> Result<Option<MeansRecord>, TracerError> {
    let Ok(gpu) = device else { return Ok(None) };
    let ProbeTimes { gather_buffer_ms, gather_texture_ms, one_ray_ms, many_rays_ms } = probe_means(gpu)?;
    let probe = ProbeRecord {
        gather_buffer_ms,
        gather_texture_ms,
        one_ray_per_lane_ms: one_ray_ms,
        many_rays_per_lane_ms: many_rays_ms,
        many_rays: u64::from(MANY_RAYS),
    };
    Ok(Some(MeansRecord { means: probe.means(), probe: Some(probe) }))
}

impl TracerRequest {
    /// Whether its search can read and be launched in several ways.
    pub fn has_means(&self) -> bool {
        [READS, RAYS_PER_LANE].iter().any(|name| self.parameters.value(name).is_some())
    }

    /// With means of its own; `None` for a tracer that cannot have them.
    pub(crate) fn with_means(mut self, means: &Means) -> Option<Self> {
        let settings = [(READS, means.reads.clone()), (RAYS_PER_LANE, means.rays_per_lane.to_string())];
        settings.iter().all(|(name, value)| self.set(name, value).is_ok()).then_some(self)
    }

    /// Takes means where none are set; they do not count as changed.
    pub fn take_means(&mut self, means: &Means) {
        let described = (self.registration.describe)().parameters;
        for (name, value) in [(READS, means.reads.clone()), (RAYS_PER_LANE, means.rays_per_lane.to_string())] {
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
    fn means_are_taken_where_none_are_set() {
        let means = Means::new("texture", 32);
        let value = |request: &TracerRequest, name: &str| request.parameters.value(name).map(ToString::to_string);
        let mut with_means = 0;
        for registration in TRACERS {
            let plain = TracerRequest::of(registration, Preset::Published);
            let mut taken = plain.clone();
            taken.take_means(&means);
            assert!(taken.changed.is_empty());
            for (name, before) in plain.parameters.iter() {
                let expected = match name {
                    READS => "texture".to_owned(),
                    RAYS_PER_LANE => "32".to_owned(),
                    _ => before.to_string(),
                };
                assert_eq!(value(&taken, name), Some(expected), "{}", plain.name());
            }
            with_means += usize::from(plain.has_means());
            let mut own = plain.clone();
            if own.set(READS, "buffer").is_ok() {
                own.take_means(&means);
                assert_eq!(
                    (value(&own, READS).unwrap(), value(&own, RAYS_PER_LANE).unwrap()),
                    ("buffer".to_owned(), "32".to_owned())
                );
            }
        }
        assert!(with_means >= 2 && with_means < TRACERS.len());
    }

    /// What is given as means is read, and what is none is refused with what is.
    #[test]
    fn means_are_read() {
        for means in combinations() {
            assert_eq!(parse(&format!("{},{}", means.reads, means.rays_per_lane)), Ok(means));
        }
        for wrong in ["", "buffer", "buffer,0", "buffer,257", "buffers,1", "texture,32,1", "1,buffer"] {
            assert!(parse(wrong).unwrap_err().contains("buffer, texture"), "{wrong}");
        }
    }
}
