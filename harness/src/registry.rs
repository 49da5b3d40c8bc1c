//! Every tracer, and how one is found.

pub use crate::registrations::{Device, Family, Registration, TRACERS};

/// Finds a tracer by name.
pub fn find(name: &str) -> Option<&'static Registration> {
    TRACERS.iter().find(|registration| registration.name() == name)
}

/// The first tracer that has something: where nobody names one, it is meant.
pub fn first(has: impl Fn(&Registration) -> bool) -> Option<&'static Registration> {
    TRACERS.iter().find(|registration| has(registration))
}

#[cfg(test)]
mod tests {
    use tracebench_api::TracerDescription;

    use super::*;

    /// Names are unique, nothing that is to be filled in is empty, and every preset value lies within its own range.
    #[test]
    fn descriptions_are_consistent() {
        let mut names: Vec<_> = TRACERS.iter().map(Registration::name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), TRACERS.len());
        for registration in TRACERS {
            let TracerDescription { name, citation, summary, parameters, .. } = registration.describe();
            assert!([name, citation, summary].iter().all(|text| !text.is_empty()), "{name}");
            for parameter in parameters {
                let values = [&parameter.published, &parameter.improved].into_iter().chain(&parameter.sweep);
                for value in values {
                    assert_eq!(parameter.parse(&value.to_string()).as_ref(), Ok(value), "{}", parameter.name);
                }
            }
        }
    }
}
