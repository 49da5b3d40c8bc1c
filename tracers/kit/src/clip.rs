//! Clipping in f64, the reference for what shaders clip: triangles against the frusta of a view's tiles.

use tracebench_api::View;
use tracebench_api::glam::{DVec2, DVec3};

/// A rectangle of a view, pixels from its top left corner, between near and far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileBounds {
    /// Left and top.
    pub low: DVec2,
    /// Right and bottom.
    pub high: DVec2,
}

impl TileBounds {
    /// Tile `(x, y)` of tiles `edge` pixels wide, grown by `margin` tiles on every side (shrunk by a negative one).
    pub fn of_tile(tile: [u32; 2], edge: f64, margin: f64) -> Self {
        let at = DVec2::new(f64::from(tile[0]), f64::from(tile[1]));
        Self { low: (at - margin) * edge, high: (at + 1.0 + margin) * edge }
    }
}

/// A point in a view's eye space: x right, y up, z the eye depth.
pub fn eye_space(view: &View, point: DVec3) -> DVec3 {
    let offset = point - view.eye;
    DVec3::new(offset.dot(view.right), offset.dot(view.up), offset.dot(view.forward))
}

/// The part of a triangle (eye space) inside the bounds and between near and far, as a convex polygon; empty for nothing.
/// Sutherland, Hodgman, "Reentrant Polygon Clipping", Communications of the ACM 17(1), 1974.
pub fn clipped_polygon(view: &View, bounds: TileBounds, triangle: [DVec3; 3]) -> Vec<DVec3> {
    let size = DVec2::new(f64::from(view.size[0]), f64::from(view.size[1]));
    let tangents = DVec2::new(view.tan_half_width, view.tan_half_height);
    let left_top = (bounds.low * 2.0 / size - 1.0) * tangents;
    let right_bottom = (bounds.high * 2.0 / size - 1.0) * tangents;
    // Inside where the product with a point is at least the offset. Rows count downwards, eye space upwards.
    let planes = [
        (DVec3::new(1.0, 0.0, -left_top.x), 0.0),
        (DVec3::new(-1.0, 0.0, right_bottom.x), 0.0),
        (DVec3::new(0.0, -1.0, -left_top.y), 0.0),
        (DVec3::new(0.0, 1.0, right_bottom.y), 0.0),
        (DVec3::Z, view.near),
        (DVec3::NEG_Z, -view.far),
    ];
    // A plane adds a corner at most.
    let mut polygon = Vec::with_capacity(triangle.len() + planes.len());
    let mut kept = Vec::with_capacity(polygon.capacity());
    polygon.extend(triangle);
    for (normal, offset) in planes {
        let inside = |point: &DVec3| normal.dot(*point) - offset;
        if polygon.iter().all(|point| inside(point) >= 0.0) {
            continue;
        }
        kept.clear();
        let mut here = inside(&polygon[0]);
        for (index, &point) in polygon.iter().enumerate() {
            let next = polygon[(index + 1) % polygon.len()];
            let there = inside(&next);
            if here >= 0.0 {
                kept.push(point);
            }
            if (here >= 0.0) != (there >= 0.0) {
                kept.push(point + (next - point) * (here / (here - there)));
            }
            here = there;
        }
        std::mem::swap(&mut polygon, &mut kept);
    }
    polygon
}

/// The eye depths of a clipped triangle, least and greatest; none where nothing of it lies inside.
pub fn clipped_depths(view: &View, bounds: TileBounds, triangle: [DVec3; 3]) -> Option<[f64; 2]> {
    let polygon = clipped_polygon(view, bounds, triangle);
    let depths = polygon.iter().map(|point| point.z);
    (!polygon.is_empty()).then(|| {
        depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, greatest], depth| {
            [least.min(depth), greatest.max(depth)]
        })
    })
}

/// The tiles that a triangle (eye space) may touch: first and last, both included, of `tiles` tiles `edge` pixels wide;
/// none where it touches none. Contains every tile for which [`clipped_depths`] finds something with a margin up to
/// `margin` tiles.
pub fn touched_tiles(
    view: &View,
    tiles: [u32; 2],
    edge: f64,
    margin: f64,
    triangle: [DVec3; 3],
) -> Option<[[u32; 2]; 2]> {
    let size = DVec2::new(f64::from(view.size[0]), f64::from(view.size[1]));
    let whole = TileBounds { low: DVec2::splat(-margin * edge), high: size + (margin + 1.0) * edge };
    let polygon = clipped_polygon(view, whole, triangle);
    let tangents = DVec2::new(view.tan_half_width, view.tan_half_height);
    let pixel = |point: &DVec3| {
        let at = DVec2::new(point.x, -point.y) / (tangents * point.z);
        (at + 1.0) * 0.5 * size / edge
    };
    let mut points = polygon.iter().map(pixel);
    let first = points.next()?;
    let (low, high) = points.fold((first, first), |(low, high), at| (low.min(at), high.max(at)));
    let last = DVec2::new(f64::from(tiles[0]), f64::from(tiles[1])) - 1.0;
    let (low, high) = ((low - margin).floor().max(DVec2::ZERO), (high + margin).floor().min(last));
    (low.cmple(high).all()).then(|| [low, high].map(|at| [at.x as u32, at.y as u32]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        View {
            eye: DVec3::ZERO,
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::Z,
            tan_half_width: 1.0,
            tan_half_height: 1.0,
            near: 1.0,
            far: 100.0,
            size: [8, 8],
        }
    }

    /// A wall square to the view fills every tile at its depth; behind far or before near there is nothing of it.
    #[test]
    fn a_wall_has_one_depth() {
        for (depth, inside) in [(5.0, true), (0.5, false), (200.0, false)] {
            let wall = [DVec3::new(-1e4, -1e4, depth), DVec3::new(1e4, -1e4, depth), DVec3::new(0.0, 3e4, depth)];
            for tile in [[0, 0], [3, 4], [7, 7]] {
                let found = clipped_depths(&view(), TileBounds::of_tile(tile, 1.0, 0.0), wall);
                assert_eq!(found, inside.then_some([depth, depth]), "{tile:?}");
            }
        }
    }

    /// A floor that runs from behind the eye to the horizon begins at near in the bottom tiles, has the depths at which
    /// the tile's lower and upper border see it, and leaves the upper half alone.
    #[test]
    fn a_floor_has_the_depths_of_the_tile_s_borders() {
        let floor = [DVec3::new(-1e5, -1.0, -50.0), DVec3::new(1e5, -1.0, -50.0), DVec3::new(0.0, -1.0, 1e5)];
        // Row 6 of 8 spans tangents -0.5 to -0.75 below the horizon: depths 1 / 0.75 to 1 / 0.5.
        let [least, greatest] = clipped_depths(&view(), TileBounds::of_tile([3, 6], 1.0, 0.0), floor).unwrap();
        assert!((least - 1.0 / 0.75).abs() < 1e-12 && (greatest - 2.0).abs() < 1e-12);
        assert_eq!(clipped_depths(&view(), TileBounds::of_tile([3, 3], 1.0, -1e-9), floor), None);
        let [first, last] = touched_tiles(&view(), [8, 8], 1.0, 0.0, floor).unwrap();
        assert!(first[1] >= 3 && last == [7, 7], "{first:?} {last:?}");
    }

    /// Of a triangle without a corner in it, a tile shrunk holds less and a tile grown more.
    #[test]
    fn margins_nest() {
        let triangle = [DVec3::new(-0.6, -0.9, 2.0), DVec3::new(-0.5, 0.9, 7.0), DVec3::new(0.9, -0.4, 3.0)];
        let depths = |margin| clipped_depths(&view(), TileBounds::of_tile([4, 3], 1.0, margin), triangle).unwrap();
        let ([a, b], [c, d], [e, f]) = (depths(-0.1), depths(0.0), depths(0.1));
        assert!(e < c && c < a && a < b && b < d && d < f, "{e} {c} {a} {b} {d} {f}");
    }
}
