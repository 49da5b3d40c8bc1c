//! What a build makes of each thing, or has room for.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Gpu, TracerError};

use crate::layout::{HINT, MAX_LEVELS};

/// Depths of nodes, and that of leaves below them.
const DEPTHS: usize = MAX_LEVELS as usize + 1;

/// Words of what shaders count: as in shaders/voxel-octree/settings.wgsl.
pub(crate) const TAKEN_WORDS: u64 = 16;
const ROWS: usize = 0;
const FRAGMENTS: usize = 2;
const BROKEN: usize = 4;
const OPENED: usize = 5;

/// Numbers of rows, fragments, and of nodes by depth; those of the last depth are leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    /// Rows of triangles.
    pub rows: u32,
    /// Voxels of triangles.
    pub fragments: u32,
    /// Nodes of every depth.
    pub levels: [u32; DEPTHS],
}

/// What a build has counted, whatever there was room for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Taken {
    words: Vec<u32>,
}

impl Counts {
    /// One of each: for stages that only count what comes before.
    pub(crate) fn least() -> Self {
        Self { rows: 1, fragments: 1, levels: [1; DEPTHS] }
    }

    /// Leaves of a tree.
    pub(crate) fn leaves(&self, levels: u32) -> u32 {
        self.levels[levels as usize]
    }

    /// Nodes above a depth.
    pub(crate) fn nodes_before(&self, depth: u32) -> u32 {
        self.levels[..depth as usize].iter().sum()
    }

    /// Whether there is room for others.
    pub(crate) fn hold(&self, others: &Self) -> bool {
        let levels = self.levels.iter().zip(&others.levels);
        self.rows >= others.rows
            && self.fragments >= others.fragments
            && levels.into_iter().all(|(own, other)| own >= other)
    }

    /// As a list, in which they may grow.
    pub(crate) fn list(&self) -> Vec<u32> {
        [self.rows, self.fragments].into_iter().chain(self.levels).collect()
    }

    /// From such a list: no depth of more nodes than its grid has.
    pub(crate) fn from_list(list: &[u32]) -> Self {
        let of = |place: usize| list.get(place).copied().unwrap_or_default().max(1);
        let most = |depth: usize| 1_u32.checked_shl(3 * depth as u32).filter(|_| depth < DEPTHS).unwrap_or(u32::MAX);
        Self { rows: of(0), fragments: of(1), levels: std::array::from_fn(|depth| of(2 + depth).min(most(depth))) }
    }
}

/// A count of 64 bits as one that shaders index by.
fn indexed(name: &str, words: &[u32], first: usize) -> Result<u32, TracerError> {
    let count = u64::from(words[first]) | u64::from(words[first + 1]) << 32;
    // One more is asked for the end of all.
    u32::try_from(count).ok().filter(|count| *count < u32::MAX).ok_or_else(|| TracerError::TooLarge {
        name: name.to_owned(),
        bytes: count.saturating_mul(4),
        limit: u64::from(u32::MAX) * 4,
        hint: HINT.to_owned(),
    })
}

impl Taken {
    /// What the last build left.
    pub(crate) fn read(gpu: &Gpu, taken: &Buffer) -> Result<Self, TracerError> {
        Ok(Self { words: bytemuck::pod_collect_to_vec(&gpu.read(taken, TAKEN_WORDS * 4)?) })
    }

    /// The rows of all triangles.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if there are more than can be told apart, [`TracerError::Failed`] if triangles have no place.
    pub(crate) fn rows(&self) -> Result<u32, TracerError> {
        if self.words[BROKEN] > 0 {
            return Err(TracerError::Failed(format!(
                "{} triangles have coordinates that are not finite numbers: voxel-octree cannot place them; mend or leave out these triangles",
                self.words[BROKEN]
            )));
        }
        indexed("rows of triangles", &self.words, ROWS)
    }

    /// The voxels of all triangles; right where there is room for all rows.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if there are more than can be told apart.
    pub(crate) fn fragments(&self) -> Result<u32, TracerError> {
        indexed("fragments", &self.words, FRAGMENTS)
    }

    /// Nodes of a depth, of leaves at that of the tree's levels; right where there is room for all fragments.
    pub(crate) fn of_depth(&self, depth: u32) -> u32 {
        if depth == 0 { 1 } else { self.words[OPENED..OPENED + depth as usize].iter().sum() }
    }

    /// All of it; right where there is room for all before each.
    pub(crate) fn counts(&self, levels: u32) -> Result<Counts, TracerError> {
        let depths = std::array::from_fn(|depth| if depth as u32 <= levels { self.of_depth(depth as u32) } else { 0 });
        Ok(Counts { rows: self.rows()?, fragments: self.fragments()?, levels: depths })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(words: [u32; 8]) -> Taken {
        Taken { words: words.into_iter().chain([0; 8]).collect() }
    }

    /// Depths have those of all before and their own; counts beyond 32 bits and places that are no numbers are errors that say what to do.
    #[test]
    fn counts_are_read_from_their_places() {
        let sound = taken([7, 0, 9, 0, 0, 1, 2, 4]);
        assert_eq!([0, 1, 2, 3].map(|depth| sound.of_depth(depth)), [1, 1, 3, 7]);
        let counts = sound.counts(2).unwrap();
        assert_eq!((counts.rows, counts.fragments, counts.leaves(2), counts.nodes_before(2)), (7, 9, 3, 2));
        assert_eq!(counts.levels[3..], [0; 8]);
        for (words, said) in [
            ([7, 1, 9, 0, 0, 1, 2, 4], "levels"),
            ([7, 0, u32::MAX, 0, 0, 1, 2, 4], "levels"),
            ([7, 0, 9, 0, 3, 1, 2, 4], "3 triangles"),
        ] {
            let error = taken(words).counts(2).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }

    /// Room is for all or for none, and grows to no more nodes than a depth has places.
    #[test]
    fn room_holds_or_not() {
        let counts = Counts { rows: 4, fragments: 5, levels: [1, 8, 3, 0, 0, 0, 0, 0, 0, 0, 0] };
        assert!(counts.hold(&counts) && Counts::from_list(&counts.list()).hold(&counts));
        assert!(!counts.hold(&Counts { rows: 5, ..counts }) && !counts.hold(&Counts { fragments: 6, ..counts }));
        let mut more = counts;
        more.levels[2] = 4;
        assert!(!counts.hold(&more) && more.hold(&counts));
        assert_eq!(Counts::from_list(&[9, 9, 9, 10, 99]).levels[..3], [1, 8, 64]);
    }
}
