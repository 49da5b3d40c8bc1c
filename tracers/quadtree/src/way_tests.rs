//! The ways of rays over cells on the device, against f64.

use tracebench_api::glam::{DVec2, DVec3};
use tracebench_tests::{Numbers, gpu};

use crate::function_tests::{Call, SIZE, SLACK, call, forest, view};

/// As `MAX_CELLS` in shaders/test/quadtree_functions.wgsl.
const MAX_CELLS: usize = 64;

/// A ray in eye space (z the depth) with the parameters at which it begins and ends.
struct EyeRay {
    origin: DVec3,
    direction: DVec3,
    span: [f64; 2],
}

impl EyeRay {
    /// Pixels and 1 / depth at a share of the way over the image.
    fn at(&self, place: f64) -> (DVec2, f64) {
        let view = view();
        let half = DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1])) / 2.0;
        let end = |t: f64| {
            let point = self.origin + self.direction * t;
            let at = DVec2::new(point.x / view.tan_half_width, -point.y / view.tan_half_height) / point.z;
            (half + half * at, 1.0 / point.z)
        };
        let (first, second) = (end(self.span[0]), end(self.span[1]));
        (first.0.lerp(second.0, place), first.1 + (second.1 - first.1) * place)
    }
}

fn eye_rays() -> Vec<EyeRay> {
    let mut numbers = Numbers::new(154);
    let view = view();
    let inside = |numbers: &mut Numbers| {
        let depth = view.near * (view.far / view.near).powf(0.05 + 0.9 * numbers.unit());
        let at = DVec2::new(numbers.signed() * view.tan_half_width, numbers.signed() * view.tan_half_height) * 0.98;
        (at * depth).extend(depth)
    };
    let mut rays: Vec<EyeRay> = (0..60)
        .map(|_| {
            let (from, to) = (inside(&mut numbers), inside(&mut numbers));
            EyeRay { origin: from, direction: (to - from).normalize(), span: [0.0, (to - from).length()] }
        })
        .collect();
    // Along a line of sight, along a row, along a column.
    let deep = inside(&mut numbers);
    let close = deep * (1.1 * view.near / deep.z);
    rays.push(EyeRay { origin: close, direction: deep.normalize(), span: [0.0, (deep - close).length()] });
    for direction in [DVec3::X, DVec3::NEG_Y] {
        rays.push(EyeRay { origin: DVec3::new(-0.01, 0.01, 1.0), direction, span: [0.0, 0.4] });
    }
    rays
}

/// Cells that are not those of a ray, or are off in what the ray has there; and the number of cells.
fn stray_cells(rays: &[EyeRay], levels: &[u32], reach: f64, found: &[[f32; 4]]) -> (usize, usize) {
    let (mut wrong, mut count) = (0, 0);
    for (index, ray) in rays.iter().enumerate() {
        let cells = found[2 * index * MAX_CELLS..2 * (index + 1) * MAX_CELLS].chunks(2);
        let cells: Vec<_> = cells.take_while(|cell| cell[1][3] == 1.0).collect();
        count += cells.len();
        let edge = f64::from(1_u32 << levels[index]);
        let length = (ray.at(1.0).0 - ray.at(0.0).0).abs();
        // Places are shares of a way of so many pixels, each rounded at the image's size.
        let slack = 1e-4 + 2e-5 / length.max_element().max(1e-3);
        let mut now = 0.0;
        for cell in &cells {
            let corner = DVec2::new(f64::from(cell[0][0]), f64::from(cell[0][1])) * edge;
            let [entry, exit, begin, end] = [cell[0][2], cell[0][3], cell[1][0], cell[1][1]].map(f64::from);
            let lies_in = |place: f64| {
                let at = ray.at(place).0 - corner;
                at.min_element() >= -2e-3 && at.max_element() <= edge + 2e-3
            };
            let beyond = reach / length.max_element().max(1e-6);
            let z = |place: f64| {
                let view = view();
                let shift = view.near / (view.far - view.near);
                (ray.at(place).1 * view.near * view.far / (view.far - view.near) - shift).clamp(0.0, 1.0)
            };
            let mut right = (entry - now).abs() <= slack && exit >= now && lies_in(now) && lies_in(exit);
            // As far as it may reach, but at the ends of the way.
            right &= (begin - (now - beyond).max(0.0)).abs() <= slack;
            right &= (end - (exit + beyond).min(1.0)).abs() <= slack;
            right &= (f64::from(cell[1][2]) - z(now)).abs() <= 4.0 * SLACK + (z(0.0) - z(1.0)).abs() * 1e-6;
            wrong += usize::from(!right);
            now = exit;
        }
        wrong += usize::from(cells.len() < MAX_CELLS && now < 1.0 - slack);
    }
    (wrong, count)
}

/// Proves that the way of a ray over cells of any level goes from its beginning to its end without a gap, lies in each cell where it
/// is said to, reaches as far beyond it as is asked, and has f64's z. Negative control: another reach, other rays and another level
/// are noticed.
#[test]
fn ways_over_cells_are_those_of_f64() {
    let gpu = gpu();
    let rays = eye_rays();
    let levels: Vec<u32> = (0..rays.len() as u32).map(|index| 1 + index % 5).collect();
    let reach = 0.5;
    let vector = |at: DVec3| [at.x as f32, at.y as f32, at.z as f32, 0.0];
    let given: Vec<[f32; 4]> = rays
        .iter()
        .zip(&levels)
        .flat_map(|(ray, level)| {
            let span = ray.span.map(|t| t as f32);
            [vector(ray.origin), vector(ray.direction), [span[0], span[1], *level as f32, reach]]
        })
        .collect();
    let asked = Call {
        entry_point: "cross_cells",
        forest: forest(),
        given: &given,
        words: &[],
        invocations: rays.len(),
        results: 2 * rays.len() * MAX_CELLS,
        nodes: 0,
    };
    let (found, _) = call(&gpu, &asked);
    let (wrong, count) = stray_cells(&rays, &levels, f64::from(reach), &found);
    assert_eq!(wrong, 0, "of {count}");
    assert!(count > 300, "{count}");
    assert!(stray_cells(&rays, &levels, 0.1, &found).0 > count / 4);
    assert!(stray_cells(&rays, &levels, 1.5, &found).0 > count / 4);
    let others: Vec<u32> = levels.iter().map(|level| level - 1).collect();
    assert!(stray_cells(&rays, &others, f64::from(reach), &found).0 > count / 4);
    let turned: Vec<EyeRay> =
        eye_rays().into_iter().map(|ray| EyeRay { origin: ray.origin + DVec3::X * 0.05, ..ray }).collect();
    assert!(stray_cells(&turned, &levels, f64::from(reach), &found).0 > count / 4);
}
