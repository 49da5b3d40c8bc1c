//! The memory ledger: every buffer and texture by the name its paper gives it.

use serde::{Deserialize, Serialize};

use crate::TraceTo;

/// One buffer, texture or host allocation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryEntry {
    /// Name, as the method's paper calls it.
    pub name: String,
    /// Bytes allocated.
    pub allocated_bytes: u64,
    /// Bytes in use, <= allocated.
    pub used_bytes: u64,
}

impl MemoryEntry {
    /// A part that is in use whole.
    pub fn whole(name: &str, bytes: u64) -> Self {
        Self { name: name.to_owned(), allocated_bytes: bytes, used_bytes: bytes }
    }
}

/// What a structure holds and needs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryReport {
    /// The structure's own parts.
    pub structure: Vec<MemoryEntry>,
    /// Bytes of scene geometry (positions, indices) that must stay resident to trace to hits.
    pub geometry_bytes: u64,
    /// Bytes of scene geometry (positions, indices, materials) that must stay resident to trace to surfaces.
    pub surface_geometry_bytes: u64,
    /// The most that the build held at once: the structure and what it needed only while building; without the
    /// scene's geometry.
    pub build_peak_bytes: u64,
}

impl MemoryReport {
    /// The same report of a structure that needs so much of the scene's geometry to trace to surfaces.
    #[must_use]
    pub fn with_surface_geometry(self, surface_geometry_bytes: u64) -> Self {
        Self { surface_geometry_bytes, ..self }
    }

    /// Bytes of scene geometry that must stay resident to trace to an end.
    pub fn geometry_bytes_to(&self, trace_to: TraceTo) -> u64 {
        match trace_to {
            TraceTo::Hit => self.geometry_bytes,
            TraceTo::Surface => self.surface_geometry_bytes,
        }
    }

    /// Allocated bytes of all parts.
    pub fn structure_bytes(&self) -> u64 {
        self.structure.iter().map(|entry| entry.allocated_bytes).sum()
    }
}

/// Keeps account while a structure is built.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    entries: Vec<MemoryEntry>,
    transient_bytes: u64,
    peak_bytes: u64,
}

impl Ledger {
    /// An empty ledger.
    pub fn new() -> Self {
        Self::default()
    }

    /// Enters a part that stays.
    pub fn keep(&mut self, name: &str, allocated_bytes: u64, used_bytes: u64) {
        self.entries.push(MemoryEntry { name: name.to_owned(), allocated_bytes, used_bytes });
        self.note_peak();
    }

    /// Enters bytes that are needed only while building.
    pub fn borrow_transient(&mut self, bytes: u64) {
        self.transient_bytes += bytes;
        self.note_peak();
    }

    /// Takes bytes entered by [`Ledger::borrow_transient`] back.
    pub fn return_transient(&mut self, bytes: u64) {
        self.transient_bytes = self.transient_bytes.saturating_sub(bytes);
    }

    /// Closes the ledger. `geometry_bytes` is what of the scene must stay resident to trace, to hits and, unless
    /// [`MemoryReport::with_surface_geometry`] says otherwise, to surfaces.
    pub fn report(self, geometry_bytes: u64) -> MemoryReport {
        MemoryReport {
            structure: self.entries,
            geometry_bytes,
            surface_geometry_bytes: geometry_bytes,
            build_peak_bytes: self.peak_bytes,
        }
    }

    fn note_peak(&mut self) {
        let kept: u64 = self.entries.iter().map(|entry| entry.allocated_bytes).sum();
        self.peak_bytes = self.peak_bytes.max(kept + self.transient_bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The peak remembers transient bytes that were given back; the sum counts what stays.
    #[test]
    fn peak_counts_transients_and_sum_does_not() {
        let mut ledger = Ledger::new();
        ledger.keep("depth buffer", 100, 80);
        ledger.borrow_transient(50);
        ledger.return_transient(50);
        ledger.keep("lists", 20, 20);
        let report = ledger.report(7);
        assert_eq!(report.structure_bytes(), 120);
        assert_eq!(report.build_peak_bytes, 150);
        assert_eq!(report.geometry_bytes, 7);
        assert_eq!(TraceTo::ALL.map(|end| report.geometry_bytes_to(end)), [7, 7]);
        let with_surfaces = report.with_surface_geometry(9);
        assert_eq!(TraceTo::ALL.map(|end| with_surfaces.geometry_bytes_to(end)), [7, 9]);
    }
}
