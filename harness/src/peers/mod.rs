//! Tables whose rows are tracers at settings: peers of one family, ways to read and to launch, switches of an improved form.

use itertools::Itertools as _;
use tracebench_api::{Domain, ParameterError, ParameterScope, Preset};

use crate::launch::combinations;
use crate::plan::TracerRequest;
use crate::registrations::Switched;
pub use crate::registrations::{Rows, Table};
use crate::registry::{self, Family, Registration, TRACERS};
use crate::results::MEMORY_ACCESS;

/// Every table that is no tracer's own.
const TABLES: &[Table] = &[
    Table {
        name: "bvh",
        summary: "bounding volume hierarchies: build rate, size, cost, speed with accuracy, counters, over every scene",
        rays: "primary,ao,specular,diffuse",
        rows: Rows::Peers { family: Family::Bvh, swept: "build" },
    },
    Table {
        name: "launch-settings",
        summary: "equal launch settings: every tracer that searches on the device, by each way to read and to launch",
        rays: "primary,diffuse",
        rows: Rows::LaunchSettings,
    },
];

/// Every table, those of a tracer's own switches last.
pub fn all() -> impl Iterator<Item = &'static Table> {
    TABLES.iter().chain(TRACERS.iter().filter_map(|registration| registration.ablation.as_ref()))
}

/// The tracer beside which switches stand: the first hierarchy on the device.
fn peer() -> Option<&'static Registration> {
    registry::first(|registration| registration.family == Family::Bvh && registration.needs_device())
}

impl Table {
    /// Whether a tracer's place in the registry is in the table.
    fn has(&self, registration: &Registration) -> bool {
        match self.rows {
            Rows::Peers { family, .. } => registration.family == family,
            Rows::LaunchSettings => TracerRequest::of(registration, Preset::Published).has_launch_settings(),
            Rows::Switches(_) => {
                registration.ablation.as_ref() == Some(self)
                    || peer().is_some_and(|peer| peer.name() == registration.name())
            }
        }
    }

    /// The tracer that others are set against: the first of a family in the registry, the hierarchy beside switches; none where each is set
    /// against itself.
    pub fn reference(&self) -> &'static str {
        match self.rows {
            Rows::Peers { .. } => TRACERS.iter().find(|each| self.has(each)),
            Rows::LaunchSettings => None,
            Rows::Switches(_) => peer(),
        }
        .map_or("", Registration::name)
    }

    /// Its rows.
    pub fn configs(&self) -> Vec<TracerRequest> {
        let of = |registration| TracerRequest::of(registration, Preset::Published);
        let published = || TRACERS.iter().filter(|each| self.has(each)).map(of);
        match &self.rows {
            Rows::Peers { swept, .. } => Self::peers(&published().collect::<Vec<_>>(), swept),
            Rows::LaunchSettings => {
                let at = |request: TracerRequest| {
                    combinations().into_iter().filter_map(move |launch| request.clone().with_launch_settings(&launch))
                };
                published().flat_map(at).collect()
            }
            Rows::Switches(rows) => {
                let own = TRACERS.iter().find(|each| each.ablation.as_ref() == Some(self));
                let rows = own.into_iter().flat_map(|own| rows.iter().filter_map(|row| row.request(own).ok()));
                rows.chain(peer().map(of)).collect()
            }
        }
    }

    /// Every peer as published, each followed by its variants: of the reference, the first, the values of the swept parameter, of others
    /// their own named kinds of structure, each with each, parameters that the reference has too left out. How they are read is the same
    /// for all, and no variant.
    fn peers(published: &[TracerRequest], swept: &str) -> Vec<TracerRequest> {
        let of = |request: &TracerRequest| request.registration.describe().parameters;
        let known = published.first().map(of).unwrap_or_default();
        let mut configs = Vec::new();
        for (place, request) in published.iter().enumerate() {
            let mut variants = vec![request.clone()];
            for parameter in of(request) {
                let shared =
                    || parameter.name == MEMORY_ACCESS || known.iter().any(|other| other.name == parameter.name);
                let is_kind =
                    || matches!(parameter.domain, Domain::Choice(_)) && parameter.scope == ParameterScope::Build;
                let wanted = if place == 0 { swept == parameter.name } else { is_kind() && !shared() };
                let values = parameter.sweep.iter().filter(|value| wanted && **value != parameter.published);
                // A value worth sweeping lies in its own range.
                let with = variants
                    .iter()
                    .cartesian_product(values)
                    .filter_map(|(variant, value)| variant.clone().with(&[(parameter.name, &value.to_string())]).ok());
                let more: Vec<TracerRequest> = with.collect();
                variants.extend(more);
            }
            configs.extend(variants);
        }
        configs
    }

    /// Whether a tracer of this name belongs into the table.
    pub fn holds(&self, tracer: &str) -> bool {
        registry::find(tracer).is_some_and(|registration| self.has(registration))
    }
}

impl Switched {
    /// The tracer with the row's values.
    ///
    /// # Errors
    /// [`ParameterError`] for a value that it cannot have.
    pub fn request(&self, registration: &Registration) -> Result<TracerRequest, ParameterError> {
        TracerRequest::of(registration, self.preset).with(&self.values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::RAY_SETS;

    fn find(name: &str) -> Option<&'static Table> {
        all().find(|table| table.name == name)
    }

    /// The tables of peers, with the parameter that each sweeps.
    fn of_peers() -> impl Iterator<Item = (&'static Table, &'static str)> {
        all().filter_map(|table| match table.rows {
            Rows::Peers { swept, .. } => Some((table, swept)),
            _ => None,
        })
    }

    /// Names are unique, ray sets exist, and the reference of every table of peers is a tracer of its family with the parameter that is
    /// swept.
    #[test]
    fn tables_name_what_exists() {
        let names: Vec<&str> = all().map(|table| table.name).collect();
        for (index, table) in all().enumerate() {
            assert!(!names[..index].contains(&table.name) && find(table.name) == Some(table));
            assert!(table.rays.split(',').all(|name| RAY_SETS.iter().any(|set| set.name == name)));
            assert!(!table.holds("no-such") && table.configs().iter().all(|row| table.holds(row.name())));
        }
        for (table, swept) in of_peers() {
            let reference = registry::find(table.reference()).unwrap();
            assert!(table.has(reference));
            let parameters = reference.describe().parameters;
            assert!(parameters.iter().any(|parameter| parameter.name == swept));
        }
        assert!(find("no-such").is_none() && names.contains(&"launch-settings"));
    }

    /// Every tracer of the family is in the table and no other, every value of the swept parameter has a row, no two
    /// rows are the same, and parameters that the reference has are not swept again.
    #[test]
    fn every_peer_has_its_rows() {
        for (table, swept) in of_peers() {
            let rows = table.configs();
            for registration in TRACERS {
                let name = registration.describe().name;
                let found = rows.iter().filter(|row| row.name() == name).count();
                assert_eq!(found > 0, table.has(registration), "{name} in {}", table.name);
            }
            let of_reference = rows.iter().filter(|row| row.name() == table.reference()).count();
            let parameters = registry::find(table.reference()).unwrap().describe().parameters;
            let swept = parameters.iter().find(|each| each.name == swept).map_or(1, |each| each.sweep.len());
            assert_eq!(of_reference, swept, "{}", table.name);
            for (index, row) in rows.iter().enumerate() {
                let same = |other: &&TracerRequest| other.name() == row.name() && other.parameters == row.parameters;
                assert_eq!(rows[..index].iter().find(same).map(TracerRequest::name), None);
                let shared = |name: &String| parameters.iter().any(|each| each.name == name);
                assert!(row.name() == table.reference() || !row.changed.iter().any(shared), "{:?}", row.changed);
                // The probe may choose the very value, and the row would be there twice.
                assert!(!row.changed.iter().any(|name| name == MEMORY_ACCESS), "{:?}", row.changed);
            }
        }
    }

    /// Proves that every row of every ablation is one that its tracer can be told, that no two are the same, that the published and the
    /// improved form are among them, and that the peer stands last.
    #[test]
    fn every_switch_can_be_told() {
        let mut ablations = 0;
        for (registration, table) in TRACERS.iter().filter_map(|each| Some((each, each.ablation.as_ref()?))) {
            let Rows::Switches(rows) = &table.rows else { panic!("{} is of no switches", table.name) };
            let requests: Vec<TracerRequest> = rows.iter().map(|row| row.request(registration).unwrap()).collect();
            for (index, request) in requests.iter().enumerate() {
                let same = requests[..index].iter().any(|other| other.parameters == request.parameters);
                assert!(!same, "{}: row {index} stands there twice", table.name);
            }
            for preset in Preset::ALL {
                let plain = TracerRequest::of(registration, preset);
                assert!(requests.iter().any(|row| row.parameters == plain.parameters), "{}: {preset:?}", table.name);
            }
            assert!(find(table.name) == Some(table) && table.holds(registration.name()));
            let all = table.configs();
            assert_eq!((all.len(), all.last().unwrap().name()), (requests.len() + 1, table.reference()));
            ablations += 1;
        }
        assert!(ablations > 0);
    }

    /// Negative control: a value that there is not is refused.
    #[test]
    fn what_cannot_be_told_is_refused() {
        let registration = TRACERS.iter().find(|each| each.ablation.is_some()).unwrap();
        let row = Switched { preset: Preset::Improved, values: vec![("no-such", "1")] };
        assert!(row.request(registration).is_err());
    }
}
