//! `mesh-warp` against brute force in f64 over all triangles of its mesh, drawn both ways.

use super::*;
use tracebench_api::Status;
use tracebench_api::glam::DVec2;
use tracebench_harness::rays::primary_rays;
use tracebench_kit::NO_SURFACE;

/// The mesh of depths, in f64: corners of triangles.
struct Reference {
    view: View,
    triangles: Vec<[DVec3; 3]>,
}

impl Reference {
    /// Of depths that were drawn apart from the tracer; `most` is the greatest step in depth, share of the least.
    fn new(depths: &Depths, most: Option<f64>) -> Self {
        let (view, image) = (depths.view, &depths.images[0]);
        let [columns, rows] = view.size;
        let depth = |[column, row]: [u32; 2]| image[(row * columns + column) as usize];
        let along = |pixel: u32, edge: u32| match pixel {
            0 => 0.0,
            _ if pixel + 1 == edge => f64::from(edge),
            _ => f64::from(pixel) + 0.5,
        };
        let vertex = |pixel: [u32; 2]| {
            let direction = view.direction_through(along(pixel[0], columns), along(pixel[1], rows));
            view.eye + direction * f64::from(depth(pixel))
        };
        let mut triangles = Vec::new();
        for (row, column) in (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| (row, column))) {
            let at = |right: u32, down: u32| [column + right, row + down];
            for corners in [[at(0, 0), at(0, 1), at(1, 0)], [at(1, 1), at(0, 1), at(1, 0)]] {
                let depths = corners.map(depth);
                let (least, greatest) =
                    (depths.into_iter().fold(f32::MAX, f32::min), depths.into_iter().fold(0.0, f32::max));
                let step = f64::from(greatest - least) / f64::from(least);
                if greatest < NO_SURFACE && most.is_none_or(|most| step <= most) {
                    triangles.push(corners.map(vertex));
                }
            }
        }
        Self { view, triangles }
    }

    /// The same from an eye: of every pixel the triangles that may come near it on the image, all where one comes behind the near plane.
    fn seen_from(&self, eye: Vec3) -> Seen<'_> {
        let view = View { eye: eye.as_dvec3(), ..self.view };
        let mut near_pixel = vec![Vec::new(); (view.size[0] * view.size[1]) as usize];
        for triangle in &self.triangles {
            let corners = triangle.map(|corner| view.project(corner).filter(|at| at.depth > view.near));
            let places: Vec<DVec2> = corners.iter().flatten().map(|at| DVec2::new(at.x, at.y)).collect();
            let ends = match places.len() {
                3 => [places[0].min(places[1]).min(places[2]) - 1.0, places[0].max(places[1]).max(places[2]) + 1.0],
                _ => [DVec2::splat(f64::NEG_INFINITY), DVec2::splat(f64::INFINITY)],
            };
            let range = |axis: usize| {
                let [low, high] = ends.map(|end| end[axis].clamp(0.0, f64::from(view.size[axis])));
                low.floor() as usize..high.ceil() as usize
            };
            for (row, column) in range(1).flat_map(|row| range(0).map(move |column| (row, column))) {
                near_pixel[row * view.size[0] as usize + column].push(triangle);
            }
        }
        Seen { view, near_pixel }
    }
}

/// A mesh from the eye that rays start in.
struct Seen<'a> {
    view: View,
    near_pixel: Vec<Vec<&'a [DVec3; 3]>>,
}

impl Seen<'_> {
    /// Where a ray that goes near a pixel first crosses a triangle, whichever: Moeller and Trumbore, in f64.
    fn closest(&self, pixel: usize, direction: DVec3) -> Option<f64> {
        let crossing = |[a, b, c]: &[DVec3; 3]| {
            let (first, second) = (*b - *a, *c - *a);
            let across = direction.cross(second);
            let determinant = first.dot(across);
            let from = self.view.eye - *a;
            let u = from.dot(across) / determinant;
            let v = direction.dot(from.cross(first)) / determinant;
            let t = second.dot(from.cross(first)) / determinant;
            let is_seen =
                u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t * direction.dot(self.view.forward) >= self.view.near;
            is_seen.then_some(t)
        };
        self.near_pixel[pixel].iter().filter_map(|triangle| crossing(triangle)).min_by(f64::total_cmp)
    }

    /// The same as far as the ray's ends let it: what lies before the least of them hides the rest. Shifts are taken to the side, for as much of
    /// a pixel as two steps of the grid that corners are drawn on.
    fn answer(&self, ray: &Ray, shift: DVec3) -> Option<f64> {
        let direction = Vec3::from(ray.direction).as_dvec3();
        let at = self.view.project(self.view.eye + direction)?;
        let pixel = at.y as usize * self.view.size[0] as usize + at.x as usize;
        let width = 2.0 * self.view.tan_half_height / f64::from(self.view.size[1]);
        let t = self.closest(pixel, direction + shift.reject_from(direction) * (width / 128.0 / SHIFT))?;
        (f64::from(ray.t_min)..=f64::from(ray.t_max)).contains(&t).then_some(t)
    }
}

/// Eyes to the side, ahead, above and behind, and that of the view.
fn eyes(viewpoint: &Viewpoint, step: f32) -> [Vec3; 5] {
    let right = viewpoint.forward.cross(viewpoint.up);
    let moves = [Vec3::ZERO, right, viewpoint.forward, viewpoint.up - 0.3 * right, -viewpoint.forward];
    moves.map(|moved| viewpoint.eye + moved * step)
}

/// Through the pixels' centres of the view that the mesh is drawn into; some with ends.
fn rays_from(viewpoint: &Viewpoint, eye: Vec3) -> Vec<Ray> {
    let rays = primary_rays(&Viewpoint { eye, ..*viewpoint }, viewpoint.frame);
    let ended = |(index, ray): (usize, Ray)| match index % 11 {
        3 => Ray { t_max: 2.5, ..ray },
        7 => Ray { t_min: 2.5, ..ray },
        _ => ray,
    };
    rays.into_iter().enumerate().map(ended).collect()
}

/// Proves that hits of rays through pixels' centres are those of brute force in f64 over all triangles of the mesh, in two scenes, from five
/// eyes, with stretched triangles and without, drawn by the rasterizer and in compute; that one who cuts finds less; and, as negative
/// controls, that hits moved to the next ray, one hit a hundredth farther, or a mesh a thousandth farther, are noticed.
#[test]
fn hits_are_those_of_brute_force() {
    let tracer = tracer("mesh-warp");
    let (room, view_of_room) = room();
    for (geometry, viewpoint, step) in [(scene(), camera(), 0.4), (room, view_of_room, 0.1)] {
        let view = viewpoint.frame_view();
        let pixel = 2.0 * view.tan_half_height / f64::from(view.size[1]);
        for (build, backend) in [("raster", RasterBackend::Raster), ("compute", RasterBackend::Compute)] {
            let depths = draw_by(backend, &geometry, &view, 1, 0.0, false);
            let mut found = [0, 0];
            for (place, (discontinuity, most)) in [("keep", None), ("cut", Some(4.0 * pixel))].into_iter().enumerate() {
                let mesh = Reference::new(&depths, most);
                let settings = [("discontinuity", discontinuity), ("step_from", "4"), ("build", build)];
                let built = Built::new(&*tracer, parameters("mesh-warp", &settings), &geometry, &viewpoint);
                for eye in eyes(&viewpoint, step) {
                    let (seen, rays) = (mesh.seen_from(eye), rays_from(&viewpoint, eye));
                    let hits = built.hits(&rays);
                    let wrong = |hits: &[Hit]| compare(&rays, hits, |ray, shift| seen.answer(ray, shift));
                    let (compared, none) = wrong(&hits);
                    let context = format!("{discontinuity} {build} {eye}");
                    assert!(compared > rays.len() * 2 / 3, "{context}: {compared} of {}", rays.len());
                    assert_eq!(none, Vec::<String>::new(), "{context}: {} of {compared}", none.len());
                    found[place] += hits.iter().filter(|hit| hit.is_hit()).count();
                    let mut moved = hits.clone();
                    moved.rotate_left(1);
                    assert!(wrong(&moved).1.len() > 100, "{context}");
                    let farther = |index: usize| {
                        let mut corrupted = hits.clone();
                        corrupted[index].t *= 1.01;
                        wrong(&corrupted).1.len()
                    };
                    let is_hit = |index: &usize| hits[*index].is_hit();
                    assert_eq!((0..hits.len()).filter(is_hit).take(20).map(farther).max(), Some(1), "{context}");
                }
            }
            assert!(found[0] > found[1] && found[1] > 1500, "{build}: {found:?}");
            let farther =
                Depths { images: vec![depths.images[0].iter().map(|depth| depth * 1.001).collect()], ..depths };
            let (farther, rays) = (Reference::new(&farther, None), rays_from(&viewpoint, viewpoint.eye));
            let seen = farther.seen_from(viewpoint.eye);
            let built = Built::new(&*tracer, parameters("mesh-warp", &[("build", build)]), &geometry, &viewpoint);
            assert!(compare(&rays, &built.hits(&rays), |ray, shift| seen.answer(ray, shift)).1.len() > 100);
        }
    }
}

/// Proves that a ray off its pixel's centre hits the plane of the triangle there, exactly where it goes through: over a slanted plate, of
/// which every triangle has the same plane, hits are the plate's own to f32, at any place in a pixel; and that the rasterizer and compute
/// draw the same.
#[test]
fn hits_lie_on_the_mesh_and_not_on_its_pixels() {
    let plate = tracebench_tests::rectangle([-30.0, -20.0, -3.0], [60.0, 0.0, -6.0], [0.0, 40.0, -4.0]);
    let (geometry, viewpoint, tracer) = (soup(&plate, Some(&gpu())), camera(), tracer("mesh-warp"));
    let [corner, along, up] = [[-30.0, -20.0, -3.0], [60.0, 0.0, -6.0], [0.0, 40.0, -4.0]].map(DVec3::from);
    let normal = along.cross(up);
    let built = ["raster", "compute"]
        .map(|build| Built::new(&*tracer, parameters("mesh-warp", &[("build", build)]), &geometry, &viewpoint));
    let mut numbers = Numbers::new(83);
    for eye in eyes(&viewpoint, 0.2) {
        let view = View { eye: eye.as_dvec3(), ..viewpoint.frame_view() };
        let [width, height] = view.size.map(f64::from);
        // Well within the view, where the mesh is under every pixel.
        let mut seen =
            || view.direction_through(width * (0.2 + 0.6 * numbers.unit()), height * (0.2 + 0.6 * numbers.unit()));
        let rays: Vec<Ray> = (0..700).map(|_| Ray { origin: eye.into(), ..ray(view.eye, seen()) }).collect();
        let [drawn, computed] = built.each_ref().map(|built| built.hits(&rays));
        // The border's vertices have their pixels' depths, which lie a little beside the plate.
        for (ray, (hit, other)) in rays.iter().zip(drawn.iter().zip(&computed)) {
            let t = normal.dot(corner - eye.as_dvec3()) / normal.dot(Vec3::from(ray.direction).as_dvec3());
            assert!(hit.is_hit() && (f64::from(hit.t) / t - 1.0).abs() < 2e-5, "{ray:?}: {hit:?} instead of {t}");
            assert!(other.is_hit() && (f64::from(other.t) / t - 1.0).abs() < 2e-5, "{ray:?}: {other:?} instead of {t}");
        }
    }
}

/// Proves what statuses say: beside the drawn view and behind the eye rays have left it, where nothing is drawn they miss, also where they
/// end before the mesh, and what begins behind the nearest triangle is not known.
#[test]
fn statuses_say_why_rays_end() {
    let plate = tracebench_tests::rectangle([-1.0, -1.0, -4.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let viewpoint = Viewpoint { vertical_fov: std::f32::consts::FRAC_PI_2, frame: [64, 64], ..camera() };
    let built =
        Built::new(&*tracer("mesh-warp"), parameters("mesh-warp", &[]), &soup(&plate, Some(&gpu())), &viewpoint);
    let to = |x: f64, y: f64, z: f64| ray(DVec3::new(0.1, 0.0, 0.0), DVec3::new(x, y, z));
    for (ray, expected) in [
        (to(0.0, 0.0, -1.0), Status::Hit),
        (Ray { t_max: 4.001, ..to(0.0, 0.0, -1.0) }, Status::Hit),
        (Ray { t_max: 3.9, ..to(0.0, 0.0, -1.0) }, Status::Miss),
        (Ray { t_min: 4.1, ..to(0.0, 0.0, -1.0) }, Status::BehindLastLayer),
        (to(0.8, 0.0, -1.0), Status::Miss),
        (to(3.0, 0.0, -1.0), Status::LeftViews),
        (to(0.0, 0.0, 1.0), Status::LeftViews),
        (to(1.0, 0.0, 0.0), Status::LeftViews),
    ] {
        // Beside many others, round whose mean the view is that is drawn.
        let hit = built.hits(&[vec![ray], vec![to(0.0, 0.0, -1.0); 99]].concat())[0];
        assert_eq!(Status::from_code(hit.status), Some(expected), "{ray:?}");
        assert!(!hit.is_hit() || (hit.t - 4.0).abs() < 1e-4, "{hit:?}");
    }
}
