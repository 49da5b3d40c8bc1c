//! The rule by which triangles are rasterized in compute: on the device against integers and f64 on the host, and beside the device's own
//! rasterizer.

use std::sync::Arc;

use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Geometry, Parameters, PhaseClock, Preset, View};
use tracebench_harness::registry::find;
use tracebench_kit::{
    EyeDepthTarget, LayerTarget, NO_SURFACE, NearestLayers, NearestScene, RasterBackend, SUBPIXELS, TileBounds,
    allowed_fragments, bind_group_at, clipped_polygon, compute_pipeline, covers_centre, dispatch_linear, eye_space,
    view_uniform,
};
use tracebench_shaders::test::COVERAGE_FUNCTIONS;
use tracebench_tests::{Numbers, gpu, soup, viewpoint};

/// Pixels of an image's edge, in integers.
const EDGE: i64 = 16;

/// Corners of a triangle on the grid.
type OnGrid = [[i64; 2]; 3];

fn storage(name: &str, contents: &[u8]) -> Buffer {
    gpu().buffer_with(name, contents, BufferUsages::STORAGE | BufferUsages::COPY_SRC, "nothing").unwrap()
}

/// Records one entry point of the test's shader over so many triangles, and reads the buffer at a binding back.
fn run<Record: bytemuck::AnyBitPattern + bytemuck::NoUninit>(
    entry_point: &str,
    buffers: &[(u32, Buffer)],
    triangles: usize,
    read: usize,
) -> Vec<Record> {
    let gpu = gpu();
    let pipeline = compute_pipeline(&gpu, COVERAGE_FUNCTIONS, entry_point).unwrap();
    let resources: Vec<_> = buffers.iter().map(|(binding, buffer)| (*binding, buffer.as_entire_binding())).collect();
    let bindings = bind_group_at(&gpu, &pipeline.get_bind_group_layout(0), &resources);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    dispatch_linear(&mut encoder, &pipeline, &bindings, triangles as u32, 64);
    gpu.queue.submit([encoder.finish()]);
    let read = &buffers[read].1;
    bytemuck::pod_collect_to_vec(&gpu.read(read, read.size()).unwrap())
}

/// Of every triangle, of each of the first rows, the span of pixels that the device finds.
fn spans(triangles: &[OnGrid]) -> Vec<[[i32; 2]; EDGE as usize]> {
    let corners: Vec<[i32; 2]> = triangles.as_flattened().iter().map(|at| at.map(|at| at as i32)).collect();
    let rows = gpu().buffer_with("rows", bytemuck::bytes_of(&[EDGE as u32, 0, 0, 0]), BufferUsages::UNIFORM, "nothing");
    let nothing = vec![[0_i32; 2]; triangles.len() * EDGE as usize];
    let buffers = [
        (0, rows.unwrap()),
        (1, storage("corners", bytemuck::cast_slice(&corners))),
        (2, storage("spans", bytemuck::cast_slice(&nothing))),
    ];
    let found: Vec<[i32; 2]> = run("cover", &buffers, triangles.len(), 2);
    found.as_chunks().0.to_vec()
}

/// Triangles from a part of a pixel to thousands of images wide: with corners on pixels' centres and borders, with edges through centres,
/// needles and lines.
fn triangles_on_grid() -> Vec<OnGrid> {
    let mut numbers = Numbers::new(41);
    let mut whole = move |low: i64, high: i64| low + (numbers.unit() * (high - low + 1) as f64) as i64;
    let mut triangles = Vec::new();
    for index in 0..4000 {
        let any = match index % 6 {
            0 => [0; 3].map(|_| [whole(-200, 4300), whole(-200, 4300)]),
            1 => [0; 3].map(|_| [whole(-2, 18) * SUBPIXELS + 128, whole(-2, 18) * SUBPIXELS + 128]),
            2 => [0; 3].map(|_| [whole(-(1 << 23), 1 << 23), whole(-(1 << 23), 1 << 23)]),
            3 => [0; 3].map(|_| [whole(-4, 36) * 128, whole(-4, 36) * 128]),
            4 => [0; 3].map(|_| [whole(1000, 1800), whole(1000, 1800)]),
            _ => [0; 3].map(|_| [whole(0, 4096), whole(-(1 << 23), 1 << 23)]),
        };
        // An edge through a centre, of any length.
        let centre = [whole(0, 15), whole(0, 15)].map(|pixel| pixel * SUBPIXELS + 128);
        let (along, times) = ([whole(-3000, 3000), whole(-3000, 3000)], whole(1, 2000));
        let ends = [-times, times].map(|times| [centre[0] + along[0] * times, centre[1] + along[1] * times]);
        let on_line = [2 * any[1][0] - any[0][0], 2 * any[1][1] - any[0][1]];
        triangles.extend([any, [ends[0], ends[1], any[2]], [any[0], any[1], on_line]]);
    }
    triangles
}

/// Pixels of which device and host do not say the same, and pixels covered.
fn misfits(triangles: &[OnGrid], spans: &[[[i32; 2]; EDGE as usize]]) -> (Vec<String>, usize) {
    let (mut misfits, mut covered) = (Vec::new(), 0);
    for (triangle, spans) in triangles.iter().zip(spans) {
        for (row, [first, last]) in (0..).zip(spans) {
            for column in 0..EDGE {
                let expected = covers_centre(*triangle, [column, row]);
                covered += usize::from(expected);
                if (i64::from(*first)..i64::from(*last)).contains(&column) != expected {
                    misfits.push(format!("{triangle:?} at {column}, {row}: {first}..{last}"));
                }
            }
        }
    }
    (misfits, covered)
}

/// Proves that rows and spans on the device are what edge functions in integers cover, ties and all, over hostile triangles; and, as
/// negative controls, that triangles a step of the grid aside are noticed.
#[test]
fn spans_are_what_edges_cover() {
    let triangles = triangles_on_grid();
    let found = spans(&triangles);
    let (wrong, covered) = misfits(&triangles, &found);
    assert!(wrong.is_empty(), "{} of {covered}: {}", wrong.len(), wrong[0]);
    assert!(covered > 100_000, "{covered}");
    for aside in [[1, 0], [0, 1]] {
        let moved = triangles.iter().map(|triangle| triangle.map(|[x, y]| [x + aside[0], y + aside[1]]));
        assert!(misfits(&moved.collect::<Vec<_>>(), &found).0.len() > 1000);
    }
}

fn view() -> View {
    let target = Vec3::new(0.3, -0.2, -4.0);
    viewpoint(Vec3::new(0.3, -0.2, 0.1), target, 0.1, 2e3, [63, 41]).frame_view()
}

/// Triangles of many sizes round the eye, through it and behind it, huge ones, needles and points.
fn triangles() -> Vec<[[f32; 3]; 3]> {
    let mut numbers = Numbers::new(42);
    let eye = view().eye;
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for size in [0.02, 0.3, 5.0, 1e3, 1e5] {
        for _ in 0..120 {
            let centre = eye + numbers.point() * 6.0;
            triangles.push([0; 3].map(|_| centre + numbers.point() * size));
        }
    }
    for _ in 0..60 {
        let (at, along, other) = (eye + numbers.point() * 3.0, numbers.direction(), numbers.direction());
        triangles.push([at, at + along * 4.0, at + along * 2.0 + other * 1e-3]);
        triangles.push([eye - along, eye + along * 3.0, eye + along + other * 0.3]);
        triangles.push([at, at + along, at + along * 2.0]);
        triangles.push([0; 3].map(|_| eye + numbers.point() * 0.15));
    }
    triangles.into_iter().map(|corners| corners.map(|corner| corner.as_vec3().into())).collect()
}

/// The outlines that the device finds of triangles in a view, on the grid.
fn outlines(view: &View, triangles: &[[[f32; 3]; 3]]) -> Vec<Vec<[i32; 2]>> {
    let points: Vec<[f32; 4]> = triangles.as_flattened().iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
    let uniform = bytemuck::bytes_of(&view_uniform(view)).to_vec();
    let buffers = [
        (3, gpu().buffer_with("view", &uniform, BufferUsages::UNIFORM, "nothing").unwrap()),
        (4, storage("points", bytemuck::cast_slice(&points))),
        (5, storage("outlines", &vec![0; triangles.len() * 80])),
    ];
    let found: Vec<[[i32; 2]; 10]> = run("project", &buffers, triangles.len(), 2);
    found.iter().map(|[[count, _], corners @ ..]| corners[..*count as usize].to_vec()).collect()
}

/// By how much a corner may be off its place, pixels: what it is rounded, and f32.
const CORNER_PIXELS: f64 = 1.0 / 512.0 + 1e-3;

fn edges(polygon: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    (0..polygon.len()).map(|place| (polygon[place], polygon[(place + 1) % polygon.len()]))
}

/// Whether a polygon goes round a point.
fn contains(polygon: &[DVec2], at: DVec2) -> bool {
    let crossed = edges(polygon)
        .filter(|(a, b)| (a.y <= at.y) != (b.y <= at.y) && a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x) <= at.x);
    crossed.count() % 2 == 1
}

/// How far a point lies from a polygon's border.
fn from_border(polygon: &[DVec2], at: DVec2) -> f64 {
    let distance = |(a, b): (DVec2, DVec2)| {
        let along = b - a;
        let share = (at - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        (a + along * share.clamp(0.0, 1.0)).distance(at)
    };
    edges(polygon).map(distance).fold(f64::INFINITY, f64::min)
}

/// Of the middle of every pixel, whether the device's outlines have it where f64 is sure; and how many are surely covered.
fn outlines_misfit(view: &View, triangles: &[[[f32; 3]; 3]], found: &[Vec<[i32; 2]>]) -> (Vec<String>, usize) {
    let size = DVec2::new(f64::from(view.size[0]), f64::from(view.size[1]));
    let whole = TileBounds { low: DVec2::splat(-1.0), high: size + 1.0 };
    let scale = DVec2::new(0.5 * size.x / view.tan_half_width, -0.5 * size.y / view.tan_half_height);
    let (mut misfits, mut sure) = (Vec::new(), 0);
    for (triangle, outline) in triangles.iter().zip(found) {
        let corners = triangle.map(|corner| eye_space(view, Vec3::from(corner).as_dvec3()));
        let exact: Vec<DVec2> = clipped_polygon(view, whole, corners)
            .iter()
            .map(|point| 0.5 * size + DVec2::new(point.x, point.y) / point.z * scale)
            .collect();
        let outline: Vec<DVec2> =
            outline.iter().map(|[x, y]| DVec2::new(f64::from(*x), f64::from(*y)) / SUBPIXELS as f64).collect();
        // What f32 loses of an edge that reaches so far, where it is cut at near.
        let reach = corners.iter().fold(0.0, |reach, corner| f64::max(reach, corner.abs().max_element()));
        let slack = 2.0 * CORNER_PIXELS + reach * 4.0 * f64::from(f32::EPSILON) / view.near * scale.abs().max_element();
        for (column, row) in (0..view.size[1]).flat_map(|row| (0..view.size[0]).map(move |column| (column, row))) {
            let at = DVec2::new(f64::from(column), f64::from(row)) + 0.5;
            let (expected, drawn) = (contains(&exact, at), contains(&outline, at));
            if from_border(&exact, at) > slack {
                sure += usize::from(expected);
                if expected != drawn {
                    misfits.push(format!("{triangle:?} at {at}: {drawn}, {outline:?}"));
                }
            }
        }
    }
    (misfits, sure)
}

/// Proves that the outlines that the device cuts and rounds have the pixels that f64 clipping has, but where a centre lies so near to a
/// border that rounding decides; and, as a negative control, that those of another view are noticed.
#[test]
fn outlines_are_those_of_clipping_in_f64() {
    let (view, triangles) = (view(), triangles());
    let found = outlines(&view, &triangles);
    let (wrong, sure) = outlines_misfit(&view, &triangles, &found);
    assert!(wrong.is_empty(), "{}: {}", wrong.len(), wrong[0]);
    let cut = found.iter().filter(|outline| outline.len() > 3).count();
    assert!(sure > 40_000 && cut > 50, "{sure} {cut}");
    let wider = View { tan_half_width: view.tan_half_width * 1.01, ..view };
    assert!(outlines_misfit(&wider, &triangles, &found).0.len() > 100);
}

/// The nearest depths of a view and those behind them, row by row from the top.
fn drawn(geometry: &Geometry, view: &View, raster_backend: RasterBackend) -> [Vec<f32>; 2] {
    let gpu = gpu();
    let layers = NearestLayers::of_depths(&gpu).unwrap();
    let target = EyeDepthTarget::of_images(&gpu, view.size, 2).unwrap();
    let (device, triangle_count) = (geometry.on_device().unwrap(), geometry.triangles.len() as u32);
    let scene = NearestScene { raster_backend, view, geometry: device, triangle_count };
    let passed = [None, Some((&target.images[0], tracebench_kit::behind(0.0)))];
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    for ((layer, image), passed) in (0..).zip(&target.images).zip(passed) {
        let pass = layers.prepare(&gpu, scene, passed).unwrap();
        layers.record(&mut encoder, &pass, LayerTarget { image, layer, test: &target.test });
    }
    gpu.queue.submit([encoder.finish()]);
    [0, 1].map(|image| target.read_image(&gpu, image).unwrap())
}

/// Ulps by which depths of one triangle may differ: a depth test tells no nearer ones apart.
const DEPTH_ULPS: u32 = 8;

/// What differs between two drawings of a view: pixels at which some triangle's border lies so near that either may decide, and
/// those without such a reason.
fn differing(geometry: &Geometry, view: &View, [one, other]: [&[Vec<f32>; 2]; 2]) -> [usize; 2] {
    let border = |raster_backend: RasterBackend| raster_backend.undecided_border(&gpu()).unwrap();
    let allowed =
        allowed_fragments(view, geometry, 1, f64::max(border(RasterBackend::Raster), border(RasterBackend::Compute)));
    let mut counts = [0; 2];
    for (column, row) in (0..view.size[1]).flat_map(|row| (0..view.size[0]).map(move |column| (column, row))) {
        let at = (row * view.size[0] + column) as usize;
        let same = |layer: usize| one[layer][at].to_bits().abs_diff(other[layer][at].to_bits()) <= DEPTH_ULPS;
        if !(same(0) && same(1)) {
            let undecided = allowed.of([column, row]).iter().any(|each| !each.must);
            counts[usize::from(!undecided)] += 1;
        }
    }
    counts
}

/// Proves that what is nearest and what lies behind it are the same by the device's rasterizer and in compute, to within ulps, at every
/// pixel at which no border lies within what either rounds; and, as a negative control, that a view half a pixel aside is noticed.
#[test]
fn both_draw_the_same() {
    let view = view();
    // The largest ones rasterizers may lose.
    let kept: Vec<_> =
        triangles().into_iter().filter(|corners| corners.iter().flatten().all(|x| x.abs() < 1e4)).collect();
    let geometry = soup(&kept, Some(&gpu()));
    let [raster, compute] =
        [RasterBackend::Raster, RasterBackend::Compute].map(|raster_backend| drawn(&geometry, &view, raster_backend));
    let [undecided, wrong] = differing(&geometry, &view, [&raster, &compute]);
    let pixels = raster[0].len();
    assert_eq!(wrong, 0, "and {undecided} undecided of {pixels}");
    assert!(undecided * 50 < pixels, "{undecided} of {pixels}");
    println!("{undecided} of {pixels} pixels differ, each with a border beside its centre");
    let covered = compute.each_ref().map(|image| image.iter().filter(|depth| **depth != NO_SURFACE).count());
    assert!(covered[0] > pixels / 2 && covered[1] > pixels / 4, "{covered:?} of {pixels}");
    let aside = View { forward: (view.forward + view.right * (view.tan_half_width / 63.0)).normalize(), ..view };
    let moved = drawn(&geometry, &aside, RasterBackend::Compute);
    assert!(differing(&geometry, &view, [&raster, &moved])[1] > 10);
}

/// A wall of so many cells along either edge, two triangles each, whose inner vertices lie anywhere about their places: beyond the whole
/// view.
fn wall(cells: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut numbers = Numbers::new(43);
    let mut place = |at: u32| {
        let off = if at == 0 || at == cells { 0.0 } else { 0.1 * numbers.signed() };
        ((f64::from(at) + off) / f64::from(cells) * 24.0 - 12.0) as f32
    };
    let mut positions = Vec::new();
    for (x, y) in (0..=cells).flat_map(|y| (0..=cells).map(move |x| (x, y))) {
        positions.push([place(x), place(y), -5.0]);
    }
    let row = cells + 1;
    let firsts = (0..cells).flat_map(|y| (0..cells).map(move |x| y * row + x));
    let triangles = firsts.flat_map(|a| [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]).collect();
    (positions, triangles)
}

/// Fragments that are drawn in compute of a scene, in one view of so many pixels.
fn fragments(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> (usize, usize) {
    let (gpu, frame) = (gpu(), [320, 200]);
    let geometry = Geometry::new(positions.to_vec(), triangles.to_vec(), Some(&gpu)).unwrap();
    let registration = find("fragment-abuffer").unwrap();
    let described = registration.describe().parameters;
    let mut parameters = Parameters::preset(&described, Preset::Published);
    for (name, value) in [("build", "compute"), ("views", "frame"), ("storage", "ll")] {
        parameters.set(&described, name, value).unwrap();
    }
    let eye = Vec3::new(0.3, -0.2, 0.1);
    let viewpoint = viewpoint(eye, eye - Vec3::Z, 0.1, 2e3, frame);
    let mut clock = PhaseClock::new(Some(&gpu));
    let tracer = registration.create(&Ok(Arc::clone(&gpu))).unwrap();
    let structure = tracer.build(&geometry, &viewpoint, &parameters, &mut clock).unwrap();
    clock.finish().unwrap();
    let statistics = structure.validate(&geometry).unwrap();
    let found = statistics.iter().find(|(name, _)| *name == "fragments").unwrap().1;
    (found as usize, frame.map(|edge| edge as usize).iter().product())
}

/// Proves that triangles with common edges leave no pixel out and share none, where a lane draws them whole, where they are divided into
/// blocks, and where both kinds meet; and, as negative controls, that one too few and one too many are noticed.
#[test]
fn neighbours_leave_no_gap_and_share_no_pixel() {
    for cells in [1, 6, 60] {
        let (positions, triangles) = wall(cells);
        let (found, pixels) = fragments(&positions, &triangles);
        assert_eq!(found, pixels, "{cells}");
        // In the middle of the view.
        let seen = ((cells / 2) * (cells + 1) * 2) as usize;
        let fewer: Vec<_> =
            triangles.iter().enumerate().filter(|(place, _)| *place != seen).map(|(_, all)| *all).collect();
        assert!(fragments(&positions, &fewer).0 < pixels, "{cells}");
        let more = [&triangles[..], &[triangles[seen]]].concat();
        assert!(fragments(&positions, &more).0 > pixels, "{cells}");
    }
    // A fan of slivers round a corner in the middle, from small ones to some that cross the view.
    let mut numbers = Numbers::new(44);
    let mut turns: Vec<f64> = (0..300).map(|_| numbers.unit().powi(3) * std::f64::consts::TAU).collect();
    turns.sort_by(f64::total_cmp);
    let rim = turns.iter().map(|turn| [40.0 * turn.cos() as f32, 40.0 * turn.sin() as f32, -5.0]);
    let positions: Vec<[f32; 3]> = std::iter::once([0.1, 0.2, -5.0]).chain(rim).collect();
    let triangles: Vec<[u32; 3]> = (1..=300).map(|at| [0, at, at % 300 + 1]).collect();
    let (found, pixels) = fragments(&positions, &triangles);
    assert_eq!(found, pixels);
}
