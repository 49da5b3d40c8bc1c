//! Direct visibility against primary rays through pixels' centres, by brute force in f64.

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{Geometry, Structure, Surface, SurfaceStatus, View};
use tracebench_tests::{Numbers, gpu};

use super::tests::{built, hostile, viewpoint};

/// By how far rays are moved aside to see what lies next to a pixel's centre, pixels: silhouettes that near are decided by
/// rounding and by what the device snaps.
pub(super) fn aside() -> f64 {
    0.01 + tracebench_kit::rasterizer(&gpu()).unwrap().border_pixels()
}

/// Hits within this of the nearest, relative to their depth, may be in front of it for a depth test in f32.
const DEPTH_SLACK: f64 = 1e-4;

/// Where a line from the eye meets a triangle: its depth.
pub(super) fn depth_of(eye: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (first, second) = (b - a, c - a);
    let across = direction.cross(second);
    let determinant = first.dot(across);
    let from = eye - a;
    let u = from.dot(across) / determinant;
    let v = direction.dot(from.cross(first)) / determinant;
    let inside = determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    // The direction's own depth is 1.
    inside.then(|| second.dot(from.cross(first)) / determinant)
}

/// What a pixel may show: triangles, and whether nothing.
fn may_show(view: &View, triangles: &[[DVec3; 3]], x: f64, y: f64) -> (Vec<usize>, bool) {
    let (mut shown, mut nothing) = (Vec::new(), false);
    let by = aside();
    for (right, above) in [(0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, 0.0), (-1.0, 0.0)] {
        let direction = view.direction_through(x + right * by, y + above * by);
        let hits: Vec<(usize, f64)> = triangles
            .iter()
            .enumerate()
            .filter_map(|(index, corners)| Some((index, depth_of(view.eye, direction, *corners)?)))
            .filter(|(_, depth)| (view.near * (1.0 - DEPTH_SLACK)..=view.far).contains(depth))
            .collect();
        let beyond_near = |depth: f64| depth > view.near * (1.0 + DEPTH_SLACK);
        let nearest = hits.iter().map(|(_, depth)| *depth).filter(|depth| beyond_near(*depth)).fold(f64::MAX, f64::min);
        nothing |= nearest == f64::MAX;
        shown.extend(hits.iter().filter(|(_, depth)| *depth <= nearest * (1.0 + DEPTH_SLACK)).map(|(index, _)| *index));
    }
    (shown, nothing)
}

/// What is wrong with a pixel's surface; triangles have their own numbers as materials.
fn wrong(view: &View, triangles: &[[DVec3; 3]], surface: &Surface, pixel: usize) -> Option<String> {
    let width = view.size[0] as usize;
    let (x, y) = ((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
    let (shown, nothing) = may_show(view, triangles, x, y);
    match SurfaceStatus::from_code(surface.status) {
        Some(SurfaceStatus::NoHit) => return (!nothing).then(|| format!("nothing, but {shown:?} are there")),
        Some(SurfaceStatus::Written) => {}
        status => return Some(format!("{status:?}")),
    }
    if !shown.contains(&(surface.material as usize)) {
        return Some(format!("triangle {}, but {shown:?} are there", surface.material));
    }
    let position = Vec3::from(surface.position).as_dvec3();
    // On the line through the pixel's centre, to a hundredth of a pixel; positions are f32.
    let pixel_edge = 2.0 * view.tan_half_height / f64::from(view.size[1]);
    let off = view.project(position).map(|at| (at.x - x).hypot(at.y - y));
    let depth = (position - view.eye).dot(view.forward);
    let slack = 4.0 * aside() + position.abs().max_element() * 1e-5 / (depth * pixel_edge);
    let [a, b, c] = triangles[surface.material as usize];
    let grazing = {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        normal.dot((position - view.eye).normalize_or_zero()).abs() < 1e-2
    };
    (!grazing && off.is_none_or(|off| off > slack)).then(|| format!("{off:?} pixels off the centre"))
}

/// Every pixel of the frame has the surface that a primary ray through its centre meets, but where rays a little
/// aside meet another one, over hostile triangles, most of them hidden, and over scattered ones; and the check
/// notices a surface of another pixel, and none where one is.
#[test]
fn the_frame_shows_what_primary_rays_meet() {
    let mut numbers = Numbers::new(17);
    let mut small = || {
        let centre = viewpoint().eye.as_dvec3() + DVec3::NEG_Z * 6.0 + numbers.point() * 3.0;
        [0; 3].map(|_| (centre + numbers.point() * 0.6).as_vec3().to_array())
    };
    let scattered: Vec<_> = (0..300).map(|_| small()).collect();
    for (corners, min_shown) in [(hostile(), 10), (scattered, 100)] {
        let gpu = gpu();
        let positions: Vec<[f32; 3]> = corners.iter().flatten().copied().collect();
        let count = corners.len() as u32;
        let indices = (0..count).map(|index| [0, 1, 2].map(|corner| 3 * index + corner)).collect();
        let geometry = Geometry::with_materials(positions, indices, (0..count).collect(), Some(&gpu)).unwrap();
        let structure = built(&gpu, &geometry, &[("direct_visibility", "on")]);
        let surfaces = structure.frame.as_ref().unwrap().read(&gpu).unwrap();
        let view = viewpoint().frame_view();
        let exact = |triangle: &[[f32; 3]; 3]| triangle.map(|at| Vec3::from(at).as_dvec3());
        let triangles: Vec<[DVec3; 3]> = corners.iter().map(exact).collect();
        assert_eq!(surfaces.len(), (view.size[0] * view.size[1]) as usize);
        for (pixel, surface) in surfaces.iter().enumerate() {
            assert_eq!(wrong(&view, &triangles, surface, pixel), None, "pixel {pixel}: {surface:?}");
        }
        let covered = |surface: &&Surface| surface.status == SurfaceStatus::Written as u32;
        let mut shown: Vec<u32> = surfaces.iter().filter(covered).map(|surface| surface.material).collect();
        shown.sort_unstable();
        shown.dedup();
        assert!(shown.len() > min_shown, "{}", shown.len());
        // Negative control.
        let is_wrong = |surface: &Surface, pixel: usize| wrong(&view, &triangles, surface, pixel).is_some();
        let (mut all, mut elsewhere, mut none) = (0, 0, 0);
        for (pixel, surface) in surfaces.iter().enumerate().filter(|(_, surface)| covered(surface)) {
            all += 1;
            elsewhere += usize::from(is_wrong(surface, (pixel + 70) % surfaces.len()));
            none += usize::from(is_wrong(&Surface::none(SurfaceStatus::NoHit), pixel));
        }
        assert!(all > 500 && elsewhere * 10 > all * 9 && none * 10 > all * 7, "{all} {elsewhere} {none}");
        let without = built(&gpu, &geometry, &[]);
        assert!(structure.memory().structure_bytes() > without.memory().structure_bytes() && without.frame.is_none());
    }
}
