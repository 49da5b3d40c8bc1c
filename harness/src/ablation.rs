//! Tables of ablations: a tracer's improved form, reached from the published one by one switch after the other, and with single switches
//! taken back.

use tracebench_api::{Preset, TracerError};

use crate::contenders::{Ablation, Switched};
use crate::plan::TracerRequest;
use crate::registry::{self, Family, Registration, TRACERS};

/// Every tracer that has one, with it.
pub fn all() -> impl Iterator<Item = (&'static Registration, &'static Ablation)> {
    TRACERS.iter().filter_map(|registration| Some((registration, registration.ablation?)))
}

/// Finds one by the name of its table.
pub fn find(name: &str) -> Option<&'static Ablation> {
    all().map(|(_, ablation)| ablation).find(|ablation| ablation.name == name)
}

/// The tracer that all rows stand beside: the first hierarchy on the device.
pub fn peer() -> Option<&'static Registration> {
    registry::first(|registration| registration.family == Family::Bvh && registration.needs_device())
}

impl Ablation {
    /// The tracer that it is of.
    fn registration(&self) -> Option<&'static Registration> {
        all().find(|(_, ablation)| ablation.name == self.name).map(|(registration, _)| registration)
    }

    /// Whether a tracer of this name belongs into the table.
    pub fn holds(&self, tracer: &str) -> bool {
        [self.registration(), peer()].into_iter().flatten().any(|registration| registration.name() == tracer)
    }

    /// The rows, and the peer as published.
    pub fn contenders(&self) -> Vec<TracerRequest> {
        let own = self
            .registration()
            .into_iter()
            .flat_map(|registration| self.rows.iter().filter_map(|row| row.request(registration).ok()));
        own.chain(peer().map(|peer| TracerRequest::of(peer, Preset::Published))).collect()
    }
}

impl Switched {
    /// The tracer with the row's values.
    ///
    /// # Errors
    /// [`TracerError::Parameter`] for a value that it cannot have.
    pub fn request(&self, registration: &Registration) -> Result<TracerRequest, TracerError> {
        let mut request = TracerRequest::of(registration, self.preset);
        for (name, value) in self.values {
            request.set(name, value)?;
        }
        Ok(request)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::RAY_SETS;

    /// Proves that every row of every ablation is one that its tracer can be told, that no two are the same, that the published and the
    /// improved form are among them, and that names and ray sets are sound.
    #[test]
    fn every_row_can_be_told() {
        for (registration, ablation) in all() {
            let requests: Vec<TracerRequest> =
                ablation.rows.iter().map(|row| row.request(registration).unwrap()).collect();
            for (index, request) in requests.iter().enumerate() {
                let same = requests[..index].iter().any(|other| other.parameters == request.parameters);
                assert!(!same, "{}: row {index} stands there twice", ablation.name);
            }
            for preset in Preset::ALL {
                let plain = TracerRequest::of(registration, preset);
                assert!(requests.iter().any(|row| row.parameters == plain.parameters), "{}: {preset:?}", ablation.name);
            }
            assert!(ablation.rays.split(',').all(|name| RAY_SETS.iter().any(|set| set.name == name)));
            assert_eq!(find(ablation.name), Some(ablation));
            assert_eq!(ablation.contenders().len(), requests.len() + 1);
            assert!(ablation.holds(registration.name()) && !ablation.holds("no-such"));
        }
        assert!(all().count() > 0 && find("no-such").is_none());
    }

    /// Negative control: a value that there is not is refused.
    #[test]
    fn what_cannot_be_told_is_refused() {
        let (registration, _) = all().next().unwrap();
        let row = Switched { preset: Preset::Improved, values: &[("no-such", "1")] };
        assert!(row.request(registration).is_err());
    }
}
