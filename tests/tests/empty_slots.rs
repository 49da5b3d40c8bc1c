//! What one clip of every part of `dirt:improved` would leave empty: the tiles of a part's rectangle that it does not touch.

use tracebench_api::Geometry;
use tracebench_api::glam::Vec3;
use tracebench_scenes::{catalogue, procedural};

#[path = "../../tracers/dirt/src/packed/parts.rs"]
#[expect(dead_code, reason = "the tracer's own tests use all of it")]
mod parts;

use parts::{MIN_DEPTH, TILE_MARGIN, bounds, in_face, part, size_of, to_face};

/// Triangles of a scene that are looked at, about.
const TRIANGLES: usize = 20_000;

/// Tiles along a face's edge, as the improved preset has them.
const EDGE: u32 = 32;

/// Tiles of the rectangles round parts of a scene, and those of them that the parts touch.
fn tiles_of(name: &str) -> [u64; 2] {
    let scene = procedural(name, 1.0).unwrap();
    let eye = Vec3::from(scene.cameras[0].eye).as_dvec3();
    let geometry = Geometry::new(scene.mesh.positions, scene.mesh.triangles, None).unwrap();
    let step = geometry.triangles.len().div_ceil(TRIANGLES);
    let (mut rectangles, mut touched) = (0, 0);
    for primitive in (0..geometry.triangles.len() as u32).step_by(step) {
        let corners = geometry.corners(primitive).map(|corner| corner.as_dvec3() - eye);
        for face in 0..6 {
            let seen = corners.map(|corner| to_face(face, corner));
            let inside = in_face(&seen, MIN_DEPTH * size_of(&corners), 2.0 / f64::from(EDGE));
            let Some(all) = bounds(&inside, EDGE) else { continue };
            let ends = |end: f64, by: f64| (end + by).floor().clamp(0.0, f64::from(EDGE) - 1.0) as u32;
            let across = ends(all.low.x, -TILE_MARGIN)..=ends(all.high.x, TILE_MARGIN);
            for y in ends(all.low.y, -TILE_MARGIN)..=ends(all.high.y, TILE_MARGIN) {
                for x in across.clone() {
                    rectangles += 1;
                    touched += u64::from(part(&inside, EDGE, [x, y], TILE_MARGIN).is_some());
                }
            }
        }
    }
    [rectangles, touched]
}

/// Proves that docs/dirt.md says how many slots a part one clip into the tiles of rectangles would leave empty, to be sorted.
#[test]
fn rectangles_leave_slots_empty() {
    let empty = catalogue().iter().map(|entry| {
        let [rectangles, touched] = tiles_of(entry.name);
        assert!(touched > 1000, "{}: {touched}", entry.name);
        (rectangles - touched) as f64 / touched as f64
    });
    let (least, most) = empty.fold((f64::INFINITY, 0.0_f64), |(least, most), each| (least.min(each), most.max(each)));
    let said = format!("{least:.2} to {most:.2} slots a part would be empty");
    assert!(include_str!("../../docs/dirt.md").contains(&said), "{said}");
}
