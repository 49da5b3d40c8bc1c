//! Rays in views that are hostile to walks, and what the device makes of them.

use bytemuck::{Pod, Zeroable};
use tracebench_api::Ray;
use tracebench_api::glam::DVec3;
use tracebench_api::wgpu::BufferUsages;
use tracebench_kit::{ViewUniform, bind_group_at, compute_pipeline, dispatch_linear};
use tracebench_shaders::test::WALK_FUNCTIONS;
use tracebench_tests::{Numbers, gpu};

use super::reference::{EyeRay, Span};

/// `MAX_PIECES` of shaders/test/walk_functions.wgsl.
pub const MAX_PIECES: usize = 96;

/// `Task` of shaders/test/walk_functions.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Task {
    pub view: ViewUniform,
    pub ray: Ray,
    pub slack: f32,
    pub levels: u32,
    pub seed: u32,
    pub pixels: f32,
}

/// `Piece` there.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Piece {
    pub pixel: [i32; 2],
    pub begin: f32,
    pub end: f32,
    pub level: u32,
    pub after: u32,
}

impl Task {
    /// The ray as it is: the views' eye space is the scene's, so that nothing is rounded on the way.
    pub fn eye_ray(&self) -> EyeRay {
        let of = |vector: [f32; 3]| DVec3::from(vector.map(f64::from));
        EyeRay { origin: of(self.ray.origin), direction: of(self.ray.direction) }
    }

    pub fn whole(&self) -> Span {
        Span { begin: f64::from(self.ray.t_min), end: f64::from(self.ray.t_max) }
    }
}

/// Runs an entry point over `count` invocations: inputs by their bindings, and the binding and bytes of the output.
pub fn run(entry_point: &str, count: usize, inputs: &[(u32, &[u8])], output: (u32, usize)) -> Vec<u8> {
    let gpu = gpu();
    let pipeline = compute_pipeline(&gpu, WALK_FUNCTIONS, entry_point).unwrap();
    let buffer = |contents: &[u8]| gpu.buffer_with("input", contents, BufferUsages::STORAGE, "nothing").unwrap();
    let mut buffers: Vec<_> = inputs.iter().map(|(binding, contents)| (*binding, buffer(contents))).collect();
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    buffers.push((output.0, gpu.buffer("output", output.1 as u64, usage, "nothing").unwrap()));
    let resources: Vec<_> = buffers.iter().map(|(binding, buffer)| (*binding, buffer.as_entire_binding())).collect();
    let bindings = bind_group_at(&gpu, &pipeline.get_bind_group_layout(0), &resources);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    dispatch_linear(&mut encoder, &pipeline, &bindings, count as u32, 64);
    gpu.queue.submit([encoder.finish()]);
    gpu.read(&buffers[inputs.len()].1, output.1 as u64).unwrap()
}

fn run_tasks<Found: Pod>(entry_point: &str, tasks: &[Task], binding: u32) -> Vec<Found> {
    let bytes = size_of_val(tasks) / size_of::<Task>() * size_of::<Found>();
    let found = run(entry_point, tasks.len(), &[(0, bytemuck::cast_slice(tasks))], (binding, bytes));
    bytemuck::pod_collect_to_vec(&found)
}

/// Begin and end of every ray's span in its view, and the side by which it leaves.
pub fn enter(tasks: &[Task]) -> Vec<[f32; 4]> {
    run_tasks("enter", tasks, 1)
}

/// The walk of every ray over its view's image.
pub fn walk(tasks: &[Task]) -> Vec<[Piece; MAX_PIECES]> {
    let pieces: Vec<Piece> = tasks.chunks(1000).flat_map(walk_some).collect();
    let (walks, _) = pieces.as_chunks::<MAX_PIECES>();
    walks.to_vec()
}

fn walk_some(tasks: &[Task]) -> Vec<Piece> {
    let bytes = tasks.len() * MAX_PIECES * size_of::<Piece>();
    bytemuck::pod_collect_to_vec(&run("walk", tasks.len(), &[(0, bytemuck::cast_slice(tasks))], (2, bytes)))
}

/// Of every ray's line pixel, t and depth at its place; that pixel and the part of the ray in it.
pub fn follow(tasks: &[Task]) -> Vec<[[f32; 4]; 2]> {
    run_tasks("follow", tasks, 3)
}

/// The number of the span that is chosen of each four.
pub fn choose(offered: &[[[f32; 2]; 4]]) -> Vec<u32> {
    let found = run("choose", offered.len(), &[(4, bytemuck::cast_slice(offered))], (5, offered.len() * 4));
    bytemuck::pod_collect_to_vec(&found)
}

/// Views along z over seven decades of scale: such whose lines are exact in f32, as faces of a cube have them, odd ones, wide and
/// narrow ones, one of a single row.
fn views() -> Vec<ViewUniform> {
    let shapes: [(f32, f32, [f32; 2]); 5] = [
        (1.0, 1.0, [16.0, 16.0]),
        (1.0, 0.5, [32.0, 16.0]),
        (0.3, 0.7, [33.0, 17.0]),
        (12.0, 2.0, [41.0, 1.0]),
        (1e-3, 2e-3, [7.0, 29.0]),
    ];
    let of = |scale: f32, (tan_half_width, tan_half_height, size)| ViewUniform {
        eye: [0.0; 3],
        tan_half_width,
        right: [1.0, 0.0, 0.0],
        tan_half_height,
        up: [0.0, 1.0, 0.0],
        near: 0.125 * scale,
        forward: [0.0, 0.0, 1.0],
        far: 64.0 * scale,
        size,
        padding: [0.0; 2],
    };
    [1e-3, 1.0, 4096.0].into_iter().flat_map(|scale| shapes.map(|shape| of(scale, shape))).collect()
}

/// A point of the view's lines: pixels from the top left corner, at a depth.
fn point_at(view: &ViewUniform, x: f64, y: f64, depth: f64) -> DVec3 {
    let across = (2.0 * x / f64::from(view.size[0]) - 1.0) * f64::from(view.tan_half_width);
    let upward = (1.0 - 2.0 * y / f64::from(view.size[1])) * f64::from(view.tan_half_height);
    DVec3::new(across, upward, 1.0) * depth
}

/// Origin and target of rays that are hard to walk in a view.
fn hostile_pairs(view: &ViewUniform, numbers: &mut Numbers) -> Vec<(DVec3, DVec3)> {
    let [width, height] = view.size.map(f64::from);
    let (near, far) = (f64::from(view.near), f64::from(view.far));
    let mut pairs = Vec::new();
    let any =
        |numbers: &mut Numbers, depth: f64| point_at(view, numbers.unit() * width, numbers.unit() * height, depth);
    for index in 0..60 {
        let [depth, other_depth] = [(); 2].map(|()| near * (far / near).powf(numbers.unit()));
        let (inside, other) = (any(numbers, depth), any(numbers, other_depth));
        let corner = |numbers: &mut Numbers, depth: f64| {
            let (x, y) = ((numbers.unit() * width).floor(), (numbers.unit() * height).floor());
            point_at(view, x, y, depth)
        };
        let (one, two) = (corner(numbers, depth), corner(numbers, 2.0 * depth));
        pairs.extend([
            (inside, other),
            // From the eye; along lines through it; towards it and through.
            (DVec3::ZERO, inside),
            (inside, inside * 2.0),
            (inside, -inside),
            // Square to the view and along its image.
            (inside, inside + DVec3::Z * far),
            (inside, inside - DVec3::Z * far),
            (inside, inside + DVec3::new(numbers.signed(), numbers.signed(), 0.0) * depth),
            (inside, inside + DVec3::X * depth),
            (inside, inside - DVec3::Y * depth),
            // Through corners of pixels, along edges of them and along diagonals.
            (one, two),
            (inside, two),
            (one, point_at(view, width, 0.0, 1.5 * depth)),
            (one, DVec3::new(one.x * 3.0, two.y, one.z * 3.0)),
            // From before near, from behind the eye, from beside and beyond.
            (inside * (0.5 * near / inside.z), other),
            (-other, inside),
            (numbers.point() * far * 2.0, inside),
            (other * (1.5 * far / other.z), inside),
            // In near and in far.
            (any(numbers, near), any(numbers, near)),
            (any(numbers, far), any(numbers, far)),
            // Along the view's sides.
            (point_at(view, 0.0, 0.5 * height, depth), point_at(view, 0.0, 0.25 * height, 3.0 * depth)),
            (point_at(view, width, height, depth), point_at(view, width, height, 0.5 * depth)),
        ]);
        if index % 5 == 0 {
            pairs.push((inside, inside + numbers.direction() * 1e-3 * depth));
        }
    }
    pairs
}

/// Rays in views, each with numbers of its own.
pub fn hostile() -> Vec<Task> {
    let mut numbers = Numbers::new(61);
    let mut tasks = Vec::new();
    for view in views() {
        let levels = (view.size[0].max(view.size[1]) as u32).next_power_of_two().trailing_zeros() + 1;
        for (origin, target) in hostile_pairs(&view, &mut numbers) {
            // Not brought to a length of 1: what is exact stays so.
            let long = numbers.unit() < 0.5;
            let (origin, target) = (origin.as_vec3(), target.as_vec3());
            let direction = if long { target - origin } else { (target - origin).normalize() };
            if !direction.is_finite() || direction.length() == 0.0 {
                continue;
            }
            let reach = f64::from(view.far) / f64::from(direction.length());
            let t_min = if numbers.unit() < 0.7 { 0.0 } else { (numbers.unit() * 0.1 * reach) as f32 };
            let t_max = if numbers.unit() < 0.7 { Ray::UNBOUNDED } else { (numbers.unit() * reach) as f32 };
            tasks.push(Task {
                view,
                ray: Ray { origin: origin.into(), t_min, direction: direction.into(), t_max },
                slack: if numbers.unit() < 0.5 { 1.0 } else { 1.000_002 },
                levels,
                seed: (numbers.unit() * 4e9) as u32,
                pixels: (numbers.unit() * f64::from(view.size[0])) as f32,
            });
        }
    }
    tasks
}
