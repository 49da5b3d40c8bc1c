//! What of a triangle lies in a tile of a face, in f64: the reference for shaders/dirt/parts.wgsl.

use tracebench_api::glam::DVec3;

/// As `MIN_DEPTH` there: a triangle is stored from so many of its sizes on.
pub(super) const MIN_DEPTH: f64 = 1.220_703_125e-4;
/// As `TILE_MARGIN` in shaders/dirt/packed_grid.wgsl, tiles.
pub(super) const TILE_MARGIN: f64 = 0.031_25;
/// As `COUNT_MARGIN` in shaders/dirt/part_lists.wgsl, tiles.
pub(super) const COUNT_MARGIN: f64 = 0.003_906_25;
/// As `BOX_MARGIN` and `BOX_STEP` in shaders/dirt/packed_grid.wgsl, tiles.
pub(super) const BOX_MARGIN: f64 = 0.062_5;
pub(super) const BOX_STEP: f64 = 1.125 / 255.0;

/// A box in (x, y, w): places in tiles, and one over the depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

/// As `to_face` in shaders/dirt/packed_grid.wgsl.
pub(super) fn to_face(face: u32, vector: DVec3) -> DVec3 {
    let turned = match face / 2 {
        0 => DVec3::new(vector.y, vector.z, vector.x),
        1 => DVec3::new(vector.z, vector.x, vector.y),
        _ => vector,
    };
    if face.is_multiple_of(2) { turned } else { DVec3::new(turned.x, turned.y, -turned.z) }
}

/// A polygon's part where the product of its points with a normal is at least the offset (Sutherland, Hodgman, "Reentrant Polygon
/// Clipping", Communications of the ACM 17(1), 1974).
fn clipped(polygon: &[DVec3], normal: DVec3, offset: f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, &point) in polygon.iter().enumerate() {
        let next = polygon[(index + 1) % polygon.len()];
        let (here, there) = (normal.dot(point) - offset, normal.dot(next) - offset);
        if here >= 0.0 {
            kept.push(point);
        }
        if (here >= 0.0) != (there >= 0.0) {
            kept.push(point + (next - point) * (here / (here - there)));
        }
    }
    kept
}

/// A triangle's size: its corners' greatest coordinate.
pub(super) fn size_of(triangle: &[DVec3; 3]) -> f64 {
    triangle.iter().map(|corner| corner.abs().max_element()).fold(0.0, f64::max)
}

/// The part of a triangle, less the eye and as a face has it, that lies at a depth or deeper, in the face and `margin` of its half
/// beyond.
pub(super) fn in_face(triangle: &[DVec3; 3], least: f64, margin: f64) -> Vec<DVec3> {
    let wide = 1.0 + margin;
    let planes = [
        (DVec3::Z, least),
        (DVec3::new(-1.0, 0.0, wide), 0.0),
        (DVec3::new(1.0, 0.0, wide), 0.0),
        (DVec3::new(0.0, -1.0, wide), 0.0),
        (DVec3::new(0.0, 1.0, wide), 0.0),
    ];
    planes.into_iter().fold(triangle.to_vec(), |polygon, (normal, offset)| clipped(&polygon, normal, offset))
}

/// A point as tiles have it.
fn place(point: DVec3, tiles: u32) -> DVec3 {
    let half = f64::from(tiles) * 0.5;
    DVec3::new((point.x / point.z + 1.0) * half, (point.y / point.z + 1.0) * half, 1.0 / point.z)
}

/// The box round a polygon; none round nothing.
pub(super) fn bounds(polygon: &[DVec3], tiles: u32) -> Option<Bounds> {
    let mut places = polygon.iter().map(|point| place(*point, tiles));
    let first = places.next()?;
    let joined = |(low, high): (DVec3, DVec3), at: DVec3| (low.min(at), high.max(at));
    let (low, high) = places.fold((first, first), joined);
    Some(Bounds { low, high })
}

/// The box round the part of a polygon in a tile that is grown by `margin` tiles.
pub(super) fn part(polygon: &[DVec3], tiles: u32, tile: [u32; 2], margin: f64) -> Option<Bounds> {
    let line = |at: f64| at * 2.0 / f64::from(tiles) - 1.0;
    let [low_x, low_y] = tile.map(|at| line(f64::from(at) - margin));
    let [high_x, high_y] = tile.map(|at| line(f64::from(at) + 1.0 + margin));
    let planes = [
        DVec3::new(1.0, 0.0, -low_x),
        DVec3::new(-1.0, 0.0, high_x),
        DVec3::new(0.0, 1.0, -low_y),
        DVec3::new(0.0, -1.0, high_y),
    ];
    let inside = planes.into_iter().fold(polygon.to_vec(), |polygon, normal| clipped(&polygon, normal, 0.0));
    bounds(&inside, tiles)
}

/// By how much the device may be off of a polygon's places, tiles: as in `make_polygon`.
pub(super) fn place_loss(size: f64, min_depth: f64, tiles: u32) -> f64 {
    let unit = 2.0_f64.powi(-19);
    unit * (size / min_depth + 1.0) * 0.5 * f64::from(tiles) + 2.0_f64.powi(-14)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall square to a face fills every tile from border to border at one depth; nothing of it lies nearer, or in the face behind.
    #[test]
    fn a_wall_fills_its_tiles() {
        for face in 0..6 {
            // Round the face's axis, whichever that is.
            let corners = [DVec3::new(-90.0, -90.0, 4.0), DVec3::new(90.0, -90.0, 4.0), DVec3::new(0.0, 300.0, 4.0)];
            let back = |point: DVec3| {
                let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_face(face, axis));
                DVec3::from_array(axes.map(|axis| axis.dot(point)))
            };
            let world = corners.map(back);
            let seen = in_face(&world.map(|corner| to_face(face, corner)), 1.0, 0.0);
            let found = part(&seen, 8, [2, 5], 0.0).unwrap();
            let expected = [DVec3::new(2.0, 5.0, 0.25), DVec3::new(3.0, 6.0, 0.25)];
            assert!((found.low - expected[0]).length() < 1e-12 && (found.high - expected[1]).length() < 1e-12);
            assert!(in_face(&world.map(|corner| to_face(face, corner)), 5.0, 0.0).is_empty());
            assert!(in_face(&world.map(|corner| to_face(face ^ 1, corner)), 1.0, 0.0).is_empty());
        }
    }

    /// A floor reaches from behind the eye to the horizon: in a tile it has the depths of the tile's two borders.
    #[test]
    fn a_floor_has_the_depths_of_its_tile() {
        let floor = [DVec3::new(-1e5, -1.0, -50.0), DVec3::new(1e5, -1.0, -50.0), DVec3::new(0.0, -1.0, 1e5)];
        let seen = in_face(&floor, 1e-3, 0.0);
        // Rows 1 of 8 from below: 0.75 to 0.5 below the horizon at depth 1.
        let found = part(&seen, 8, [3, 1], 0.0).unwrap();
        assert!((found.low.z - 0.5).abs() < 1e-9 && (found.high.z - 0.75).abs() < 1e-9, "{found:?}");
        assert!(part(&seen, 8, [3, 5], 0.0).is_none());
    }
}
