//! The order in which a set's rays are handed to tracers: coherent or not, the rays are the same.

use super::parameters::Order;
use super::sampling::Stream;

/// Edge of a tile, pixels.
pub const TILE: u32 = 8;

/// Brings rays with the pixels that they started from, given in scanline order, into another order. Several rays of one
/// pixel stay together but when shuffled.
pub(super) fn arrange<R>(order: Order, [width, _]: [u32; 2], seed: u64, mut rays: Vec<(u32, R)>) -> (Vec<u32>, Vec<R>) {
    match order {
        Order::Tile => rays.sort_by_key(|(pixel, _)| {
            let (x, y) = (pixel % width, pixel / width);
            (y / TILE, x / TILE, y % TILE, x % TILE)
        }),
        Order::Shuffled => {
            // Fisher and Yates.
            let mut stream = Stream::new(seed, SHUFFLE_TAG, 0);
            for last in (1..rays.len()).rev() {
                let other = (stream.unit() * (last + 1) as f64) as usize;
                rays.swap(last, other);
            }
        }
        Order::Scanline => {}
    }
    rays.into_iter().unzip()
}

/// Not a tag of any set.
const SHUFFLE_TAG: u64 = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(width: u32, height: u32, twice: bool) -> Vec<(u32, u32)> {
        let copies = if twice { 2 } else { 1 };
        (0..width * height).flat_map(|pixel| (0..copies).map(move |copy| (pixel, pixel * copies + copy))).collect()
    }

    /// Every order holds every ray once; scanline changes nothing; a shuffle is another for another seed, and evenly
    /// spread: the mean distance that a ray moves is a third of the set's length.
    #[test]
    fn orders_are_permutations() {
        let (width, height) = (37, 19);
        let rays = pixels(width, height, true);
        let of = |order: Order, seed: u64| arrange(order, [width, height], seed, rays.clone()).1;
        let scanline: Vec<u32> = (0..2 * width * height).collect();
        assert_eq!(of(Order::Scanline, 1), scanline);
        for order in [Order::Tile, Order::Shuffled] {
            let mut arranged = of(order, 1);
            assert_ne!(arranged, scanline, "{order:?}");
            arranged.sort_unstable();
            assert_eq!(arranged, scanline, "{order:?}");
        }
        assert_ne!(of(Order::Shuffled, 1), of(Order::Shuffled, 2));
        assert_eq!(of(Order::Shuffled, 1), of(Order::Shuffled, 1));
        let moved =
            of(Order::Shuffled, 1).iter().enumerate().map(|(at, ray)| (at as f64 - f64::from(*ray)).abs()).sum::<f64>();
        let count = f64::from(2 * width * height);
        assert!((moved / count / count - 1.0 / 3.0).abs() < 0.02);
    }

    /// Sixty-four rays in a row cover one tile, whole.
    #[test]
    fn tiles_are_whole() {
        let (started_from, arranged) = arrange(Order::Tile, [32, 16], 1, pixels(32, 16, false));
        assert_eq!(started_from, arranged);
        for (tile, rays) in arranged.chunks(64).enumerate() {
            let (left, top) = (tile as u32 % 4 * TILE, tile as u32 / 4 * TILE);
            assert!(rays.iter().all(|ray| (left..left + TILE).contains(&(ray % 32))), "{tile}");
            assert!(rays.iter().all(|ray| (top..top + TILE).contains(&(ray / 32))), "{tile}");
        }
    }
}
