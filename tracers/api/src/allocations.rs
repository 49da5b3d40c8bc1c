//! What the device's allocator says that it holds: the one source for sizes that drivers choose.

use std::collections::BTreeMap;

use crate::Gpu;

/// Bytes of the device's live allocations by name, at one moment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Allocations(Option<BTreeMap<String, u64>>);

impl Gpu {
    /// What is allocated now. Names are the labels of buffers, textures and acceleration structures.
    pub fn allocations(&self) -> Allocations {
        let by_name = |report: wgpu::AllocatorReport| {
            let mut bytes = BTreeMap::new();
            for allocation in report.allocations {
                *bytes.entry(allocation.name).or_insert(0) += allocation.size;
            }
            bytes
        };
        Allocations(self.device.generate_allocator_report().map(by_name))
    }
}

impl Allocations {
    /// Bytes by which the allocations of a name have grown since an earlier moment, with what the allocator puts before
    /// each to align it; none on a backend that does not tell (Metal).
    pub fn added_since(&self, before: &Self, name: &str) -> Option<u64> {
        let of = |allocations: &Option<BTreeMap<String, u64>>| {
            Some(allocations.as_ref()?.get(name).copied().unwrap_or_default())
        };
        Some(of(&self.0)?.saturating_sub(of(&before.0)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is new under a name is told, what was there before is not, and a backend that tells nothing tells nothing.
    #[test]
    fn only_what_is_new_is_told() {
        let held = |parts: &[(&str, u64)]| {
            Allocations(Some(parts.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes)).collect()))
        };
        let (before, after) = (held(&[("nodes", 64)]), held(&[("nodes", 96), ("lists", 5)]));
        let added = |name| after.added_since(&before, name);
        assert_eq!((added("nodes"), added("lists"), added("none")), (Some(32), Some(5), Some(0)));
        assert_eq!(before.added_since(&after, "lists"), Some(0));
        assert_eq!(after.added_since(&Allocations::default(), "lists"), None);
    }
}
