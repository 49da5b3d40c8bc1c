//! Pyramids over images, as in shaders/shared/pyramid.wgsl.

/// Levels that a pyramid has at most: images up to 32,768 pixels along an edge.
pub const MAX_LEVELS: usize = 16;

/// The levels over an image, its pixels being the first: a cell stands for the four below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pyramid {
    /// Pixels along x and y.
    pub size: [u32; 2],
}

impl Pyramid {
    /// Levels, down from a single cell.
    pub fn levels(&self) -> usize {
        let edge = self.size[0].max(self.size[1]).max(1);
        (edge.next_power_of_two().trailing_zeros() as usize + 1).min(MAX_LEVELS)
    }

    /// Cells of a level along x and y.
    pub fn level_size(&self, level: usize) -> [u32; 2] {
        self.size.map(|edge| edge.div_ceil(1 << level))
    }

    /// Cells of a level.
    pub fn cells(&self, level: usize) -> u64 {
        self.level_size(level).map(u64::from).iter().product()
    }

    /// Where the levels from `first` on begin in a buffer that has them one after the other from `begin` on (0 for levels
    /// that there are not), and where the last ends.
    pub fn offsets(&self, first: usize, begin: u64) -> ([u32; MAX_LEVELS], u64) {
        let mut offsets = [0; MAX_LEVELS];
        let mut end = begin;
        for (level, offset) in offsets.iter_mut().enumerate().take(self.levels()).skip(first) {
            *offset = end as u32;
            end += self.cells(level);
        }
        (offsets, end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels halve, rounded up, down to one cell, and lie one after the other.
    #[test]
    fn levels_halve_down_to_one_cell() {
        let pyramid = Pyramid { size: [13, 5] };
        assert_eq!(pyramid.levels(), 5);
        let sizes: Vec<_> = (0..5).map(|level| pyramid.level_size(level)).collect();
        assert_eq!(sizes, [[13, 5], [7, 3], [4, 2], [2, 1], [1, 1]]);
        let (offsets, end) = pyramid.offsets(0, 0);
        assert_eq!((&offsets[..6], end), ([0, 65, 86, 94, 96, 0].as_slice(), 97));
        let (offsets, end) = pyramid.offsets(1, 100);
        assert_eq!((&offsets[..6], end), ([0, 100, 121, 129, 131, 0].as_slice(), 132));
        for (size, levels) in [([1, 1], 1), ([2, 1], 2), ([0, 0], 1), ([32_768, 3], 16), ([65_536, 1], 16)] {
            assert_eq!(Pyramid { size }.levels(), levels, "{size:?}");
        }
    }
}
