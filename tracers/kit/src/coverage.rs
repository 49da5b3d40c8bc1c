//! Coverage in integers, edge by edge: the reference for the rows and spans of shaders/shared/coverage.wgsl.

/// Steps of the grid that corners lie on, to a pixel.
pub const SUBPIXELS: i64 = 256;

/// Whether a triangle on the grid (x to the right, y downwards) covers a pixel's centre: inside of all three edges, or on one that is a
/// left or a level upper one (Vulkan, "Basic Polygon Rasterization"; Pineda, "A Parallel Algorithm for Polygon Rasterization", SIGGRAPH
/// 1988).
pub fn covers_centre(corners: [[i64; 2]; 3], pixel: [i64; 2]) -> bool {
    let [a, b, c] = corners;
    let cross = |from: [i64; 2], to: [i64; 2], at: [i64; 2]| {
        let (along, away) = ([to[0] - from[0], to[1] - from[1]], [at[0] - from[0], at[1] - from[1]]);
        along[0] * away[1] - along[1] * away[0]
    };
    let area = cross(a, b, c);
    if area == 0 {
        return false;
    }
    let [b, c] = if area > 0 { [b, c] } else { [c, b] };
    let centre = pixel.map(|at| at * SUBPIXELS + SUBPIXELS / 2);
    [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
        let (across, down) = (to[0] - from[0], to[1] - from[1]);
        let side = cross(from, to, centre);
        // Inside lies to the right of an edge that runs upwards, and below one that runs level to the right.
        side > 0 || (side == 0 && (down < 0 || (down == 0 && across > 0)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles covers the pixels whose centres lie on its left and upper border and none on the others, each once.
    #[test]
    fn centres_on_borders_are_covered_once() {
        // Borders through the centres of columns and rows 1 and 4.
        let at = |x: i64, y: i64| [x * SUBPIXELS + 128, y * SUBPIXELS + 128];
        let [a, b, c, d] = [at(1, 1), at(4, 1), at(4, 4), at(1, 4)];
        for triangles in [[[a, b, c], [a, c, d]], [[b, c, d], [d, a, b]], [[c, b, a], [d, c, a]]] {
            for (x, y) in (0..6).flat_map(|y| (0..6).map(move |x| (x, y))) {
                let times = triangles.iter().filter(|triangle| covers_centre(**triangle, [x, y])).count();
                let inside = (1..4).contains(&x) && (1..4).contains(&y);
                assert_eq!(times, usize::from(inside), "{x} {y}");
            }
        }
    }

    /// Triangles round a corner on a pixel's centre cover it once; without an area none covers anything.
    #[test]
    fn a_fan_covers_its_middle_once() {
        let middle = [128, 128];
        let round =
            [[900, 128], [700, 700], [128, 900], [-700, 400], [-900, 128], [-300, -800], [128, -700], [900, -500]];
        let fan = || (0..round.len()).map(|place| [middle, round[place], round[(place + 1) % round.len()]]);
        assert_eq!(fan().filter(|triangle| covers_centre(*triangle, [0, 0])).count(), 1);
        assert!(!covers_centre([middle, middle, [900, 128]], [0, 0]));
        assert!(!covers_centre([[-500, 128], middle, [900, 128]], [0, 0]));
    }
}
