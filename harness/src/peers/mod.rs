//! Tables of peers: tracers of one family side by side, as data.

use tracebench_api::{Domain, ParameterScope, Preset};

use crate::plan::TracerRequest;
use crate::registry::{Family, Registration, TRACERS};
use crate::results::READS;

/// What a table is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// Builds and traces of scenes that stand still.
    Still,
    /// Structures that follow an animation.
    Moving,
    /// Structures that follow the camera's path, and the scene where it moves.
    Walked,
}

/// A table as data.
#[derive(Debug, PartialEq, Eq)]
pub struct Table {
    /// Stable name; files are named after it.
    pub name: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// Whose tracers stand in it; every tracer without one.
    pub family: Option<Family>,
    /// A parameter of the reference tracer, each of whose values worth sweeping has a row.
    pub swept: Option<&'static str>,
    /// Ray sets where nothing else is said, as `--rays` takes them.
    pub rays: &'static str,
    /// What is measured.
    pub subject: Subject,
}

/// Every table.
pub const TABLES: &[Table] = &[
    Table {
        name: "bvh",
        summary: "bounding volume hierarchies: build rate, size, cost, speed with accuracy, counters, over every scene",
        family: Some(Family::Bvh),
        swept: Some("build"),
        rays: "primary,ao,specular,diffuse",
        subject: Subject::Still,
    },
    Table {
        name: "bvh-updates",
        summary: "bounding volume hierarchies over animations: rebuild and refit, their times and what is left of quality",
        family: Some(Family::Bvh),
        swept: None,
        rays: "diffuse",
        subject: Subject::Moving,
    },
    Table {
        name: "view-updates",
        summary: "every tracer along the camera's path: structures reused, refitted or rebuilt at every frame; the time of all frames, \
                  and the accuracy at each",
        family: None,
        swept: None,
        rays: "primary,diffuse",
        subject: Subject::Walked,
    },
];

/// Finds a table by name.
pub fn find(name: &str) -> Option<&'static Table> {
    TABLES.iter().find(|table| table.name == name)
}

impl Table {
    /// Whether a tracer's place in the registry is in the table's family.
    fn has(&self, registration: &Registration) -> bool {
        self.family.is_none_or(|family| registration.family == family)
    }

    /// The tracer that others are set against: the first of the family in the registry.
    pub fn reference(&self) -> &'static str {
        let first = TRACERS.iter().find(|each| self.has(each));
        first.map_or("", |registration| (registration.describe)().name)
    }

    /// Every tracer of the family as published, each followed by its variants: of the reference the values of the swept
    /// parameter, of others their own named kinds of structure, parameters that the reference has too left out. How they are read is
    /// the same for all, and no variant. No variants where all families are side by side.
    pub fn contenders(&self) -> Vec<TracerRequest> {
        let peers: Vec<_> = TRACERS.iter().filter(|each| self.has(each)).collect();
        let is_reference = |request: &TracerRequest| request.name() == self.reference();
        let published: Vec<_> = peers.into_iter().map(|each| TracerRequest::of(each, Preset::Published)).collect();
        let reference = published.iter().find(|request| is_reference(request));
        let known = reference.map(|request| (request.registration.describe)().parameters).unwrap_or_default();
        let mut contenders = Vec::new();
        for request in &published {
            contenders.push(request.clone());
            for parameter in (request.registration.describe)().parameters {
                let wanted = if is_reference(request) {
                    self.swept == Some(parameter.name)
                } else {
                    let named = matches!(parameter.domain, Domain::Choice(_));
                    let shared = parameter.name == READS || known.iter().any(|other| other.name == parameter.name);
                    self.family.is_some() && named && parameter.scope == ParameterScope::Build && !shared
                };
                for value in parameter.sweep.iter().filter(|value| wanted && **value != parameter.published) {
                    let mut variant = request.clone();
                    // A value worth sweeping lies in its own range.
                    if variant.set(parameter.name, &value.to_string()).is_ok() {
                        contenders.push(variant);
                    }
                }
            }
        }
        contenders
    }

    /// Whether a tracer of this name belongs into the table.
    pub fn holds(&self, tracer: &str) -> bool {
        crate::registry::find(tracer).is_some_and(|registration| self.has(registration))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::RAY_SETS;
    use crate::registry;

    /// The reference of every table is a tracer of its family with the parameter that is swept, its ray sets exist, and
    /// names are unique.
    #[test]
    fn tables_name_what_exists() {
        for (index, table) in TABLES.iter().enumerate() {
            assert!(TABLES[..index].iter().all(|other| other.name != table.name));
            let reference = registry::find(table.reference()).unwrap();
            assert!(table.has(reference) && table.holds(table.reference()));
            let parameters = (reference.describe)().parameters;
            assert!(table.swept.is_none_or(|name| parameters.iter().any(|parameter| parameter.name == name)));
            assert!(table.rays.split(',').all(|name| RAY_SETS.iter().any(|set| set.name == name)));
        }
        assert!(find("no-such").is_none() && !TABLES[0].holds("no-such"));
    }

    /// Every tracer of the family stands in the table, no other does, every value of the swept parameter has a row, no two
    /// rows are the same, and parameters that the reference has are not swept again.
    #[test]
    fn every_peer_has_its_rows() {
        for table in TABLES {
            let rows = table.contenders();
            for registration in TRACERS {
                let name = (registration.describe)().name;
                let found = rows.iter().filter(|row| row.name() == name).count();
                assert_eq!(found > 0, table.has(registration), "{name} in {}", table.name);
                assert!(table.family.is_some() || found == 1, "{name} in {}", table.name);
            }
            let of_reference = rows.iter().filter(|row| row.name() == table.reference()).count();
            let parameters = (registry::find(table.reference()).unwrap().describe)().parameters;
            let swept =
                parameters.iter().find(|each| Some(each.name) == table.swept).map_or(1, |each| each.sweep.len());
            assert_eq!(of_reference, swept, "{}", table.name);
            for (index, row) in rows.iter().enumerate() {
                let same = |other: &&TracerRequest| other.name() == row.name() && other.parameters == row.parameters;
                assert_eq!(rows[..index].iter().find(same).map(TracerRequest::name), None);
                let shared = |name: &String| parameters.iter().any(|each| each.name == name);
                assert!(row.name() == table.reference() || !row.changed.iter().any(shared), "{:?}", row.changed);
                // The probe may choose the very value, and the row would be there twice.
                assert!(!row.changed.iter().any(|name| name == READS), "{:?}", row.changed);
            }
        }
    }
}
