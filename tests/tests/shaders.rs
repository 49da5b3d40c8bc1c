//! The WGSL as composed: layouts, constants and entry points against the Rust side, and the shared projection on the
//! device against f64.

use crate::layouts;

use std::collections::BTreeMap;
use std::mem::size_of;

use layouts::{Layout, shared};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Module, ShaderStage, TypeInner};
use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::wgpu::BufferUsages;
use tracebench_api::{NO_PRIMITIVE, Status, SurfaceStatus, View, Viewpoint};
use tracebench_bvh::{BINARY_STACK, WIDE_STACK};
use tracebench_kit::{ROW_BITS, bind_group, compute_pipeline, dispatch_linear, view_uniform};
use tracebench_shaders::test::VIEW_FUNCTIONS;
use tracebench_shaders::{ALL, Shader};
use tracebench_tests::{Numbers, gpu, viewpoint};

fn parse(source: &str) -> Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)))
}

/// naga_oil appends the module's name, encoded, to every imported name.
fn plain(name: &str) -> &str {
    name.split("X_naga_oil").next().unwrap_or(name)
}

/// The structs that a shader binds, by themselves, in arrays or in one another: others share nothing with Rust.
fn layouts(module: &Module) -> BTreeMap<String, Layout> {
    let mut structs = BTreeMap::new();
    let bound = module.global_variables.iter().filter(|(_, variable)| variable.binding.is_some());
    let mut left: Vec<_> = bound.map(|(_, variable)| variable.ty).collect();
    while let Some(found) = left.pop() {
        let found = &module.types[found];
        match &found.inner {
            TypeInner::Array { base, .. } => left.push(*base),
            TypeInner::Struct { members, span } => {
                left.extend(members.iter().map(|member| member.ty));
                let member = |member: &naga::StructMember| {
                    (plain(member.name.as_deref().unwrap_or_default()).to_owned(), member.offset)
                };
                let layout = (members.iter().map(member).collect(), *span);
                structs.insert(plain(found.name.as_deref().unwrap_or_default()).to_owned(), layout);
            }
            _ => {}
        }
    }
    structs
}

/// The shared structs that a shader lays out otherwise than Rust, and how many it has.
fn misfits(module: &Module) -> (Vec<String>, Vec<String>) {
    let shared = shared();
    let found = layouts(module);
    let present: Vec<String> = found.keys().filter(|name| shared.contains_key(name.as_str())).cloned().collect();
    let wrong = present.iter().filter(|name| !shared[name.as_str()].contains(&found[*name])).cloned().collect();
    (present, wrong)
}

/// Proves that every struct that Rust shares has the same member names at the same offsets in every shader and in Rust.
#[test]
fn layouts_are_those_of_rust() {
    let mut seen = BTreeMap::new();
    for shader in ALL {
        let (present, wrong) = misfits(&parse(shader.source));
        assert!(wrong.is_empty(), "{}: {wrong:?}", shader.name);
        for name in present {
            *seen.entry(name).or_insert(0) += 1;
        }
    }
    assert!(shared().keys().all(|name| seen.contains_key(*name)), "{seen:?}");
}

/// The structs of a shader's uniforms, also in arrays, that nobody shares: what host code writes must be compared with Rust.
fn unshared_uniforms(module: &Module) -> Vec<String> {
    let shared = shared();
    let of_uniform = |(_, variable): (_, &naga::GlobalVariable)| {
        let mut inner = &module.types[variable.ty];
        while let TypeInner::Array { base, .. } = inner.inner {
            inner = &module.types[base];
        }
        let is_struct =
            variable.space == naga::AddressSpace::Uniform && matches!(inner.inner, TypeInner::Struct { .. });
        is_struct.then(|| plain(inner.name.as_deref().unwrap_or_default()).to_owned())
    };
    let found = module.global_variables.iter().filter_map(of_uniform);
    found.filter(|name| !shared.contains_key(name.as_str())).collect()
}

/// Proves that every struct that is a uniform of any shader is in the layouts of a crate; and, as negative controls, that
/// one that does not is noticed, by itself and in an array.
#[test]
fn every_uniform_is_shared() {
    for shader in ALL {
        assert_eq!(unshared_uniforms(&parse(shader.source)), Vec::<String>::new(), "{}", shader.name);
    }
    let uniform = |of: &str| {
        let source = format!("struct Other {{ size: vec4<u32> }} @group(0) @binding(0) var<uniform> given: {of};");
        unshared_uniforms(&parse(&source))
    };
    assert_eq!((uniform("Other"), uniform("array<Other, 4>")), (vec!["Other".to_owned()], vec!["Other".to_owned()]));
    assert_eq!(uniform("vec4<u32>"), Vec::<String>::new());
}

/// Negative control: swapped members, another type and a member that is missing are each noticed.
#[test]
fn another_layout_is_noticed() {
    for (name, members) in [
        ("Hit", "primitive: u32, t: f32, u: f32, v: f32, status: u32"),
        ("Hit", "t: f32, primitive: u32, u: f32, status: u32"),
        ("RayX_naga_oil_mod_ABCX", "origin: vec3<f32>, direction: vec3<f32>, t_min: f32, t_max: f32"),
        ("Ray", "origin: vec4<f32>, t_min: f32, direction: vec3<f32>, t_max: f32"),
    ] {
        let source = format!("struct {name} {{ {members} }} @group(0) @binding(0) var<storage> all: array<{name}>;");
        assert_eq!(misfits(&parse(&source)).1, [plain(name)], "{source}");
    }
}

/// Proves that every shader validates on its own: the one that asks the device for hits with ray queries, which it does
/// not without, and every other without any extension of WGSL (numbers in half precision in words are none).
#[test]
fn every_shader_validates() {
    for shader in ALL {
        let module = parse(shader.source);
        let validate =
            |capabilities| Validator::new(ValidationFlags::all(), capabilities).validate(&module).map_err(Box::new);
        let with_ray_queries = shader.file == "bvh/ray_query.wgsl";
        let wgsl = Capabilities::SHADER_FLOAT16_IN_FLOAT32;
        assert!(!with_ray_queries || validate(wgsl).is_err(), "{}", shader.name);
        if let Err(error) = validate(if with_ray_queries { wgsl | Capabilities::RAY_QUERY } else { wgsl }) {
            panic!("{}: {}", shader.name, error.emit_to_string(shader.source));
        }
        assert!(!module.entry_points.is_empty(), "{} has no entry point", shader.name);
    }
    // Negative control: the validator does refuse.
    let wrong = parse("@compute @workgroup_size(0) fn main() {}");
    assert!(Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&wrong).is_err());
}

/// Proves that the entry points that host code asks for exist in every variant, with their stages and workgroup sizes, and
/// that there are no others.
#[test]
fn entry_points_exist() {
    let compute = |names: &[&'static str], size| -> Vec<_> {
        names.iter().map(|name| (*name, ShaderStage::Compute, size)).collect()
    };
    let raster = vec![("vertex", ShaderStage::Vertex, 0), ("fragment", ShaderStage::Fragment, 0)];
    let and_raster = |names: &[&'static str]| -> Vec<_> { [compute(names, 64), raster.clone()].concat() };
    let expected = |shader: &Shader| -> Vec<(&'static str, ShaderStage, u32)> {
        match (shader.file, shader.name) {
            ("shared/raster_setup.wgsl", _) => {
                vec![("find", ShaderStage::Compute, 64), ("deal", ShaderStage::Compute, 1)]
            }
            ("shared/nearest_compute.wgsl", _) => compute(&["draw"], 64),
            ("shared/nearest_resolve.wgsl", _) => compute(&["resolve"], 64),
            ("test/coverage_functions.wgsl", _) => compute(&["cover", "project"], 64),
            ("fragment-abuffer/boxes.wgsl", _) => and_raster(&["bound", "draw"]),
            ("dirt/fill.wgsl" | "fragment-abuffer/fill.wgsl" | "voxel-abuffer/fill.wgsl", _) => and_raster(&["draw"]),
            ("quadtree/layers.wgsl" | "voxel-abuffer/planes.wgsl", _) => and_raster(&["draw"]),
            (_, "bvh/refit") => vec![("fit", ShaderStage::Compute, 64), ("fit_last", ShaderStage::Compute, 256)],
            ("bvh/refit.wgsl", _) => compute(&["fit"], 64),
            ("bvh/cluster.wgsl", _) => {
                let passes = [("search", 64), ("tally", 64), ("add_up", 256), ("merge", 64), ("finish", 256)];
                passes.map(|(name, size)| (name, ShaderStage::Compute, size)).to_vec()
            }
            ("bvh/radix_tree.wgsl", _) => compute(&["raise", "link"], 64),
            ("bvh/leaves.wgsl", _) => compute(&["encode", "place", "fill"], 64),
            ("bvh/ray_query.wgsl", _) => compute(&["trace", "trace_counted", "find_own_triangle"], 64),
            ("hybrid/handover.wgsl", _) => compute(&["mark", "choose", "join"], 64),
            ("shared/prefix_sum.wgsl", _) => compute(&["reduce", "scan"], 256),
            ("shared/radix_sort.wgsl", _) => compute(&["count", "scatter"], 32),
            ("shared/depth_pyramid.wgsl", _) => compute(&["reduce"], 64),
            ("shared/fixed_work.wgsl", _) => compute(&["work"], 64),
            ("shared/launch_probe.wgsl", _) => compute(&["gather", "search"], 64),
            ("dirt/setup.wgsl", _) => compute(&["see", "list"], 64),
            ("dirt/part_lists.wgsl", _) => {
                let passes = [
                    ("measure", 64),
                    ("scale", 1),
                    ("count", 64),
                    ("count_several", 64),
                    ("count_large", 64),
                    ("store", 64),
                    ("store_several", 64),
                    ("store_large", 64),
                ];
                passes.map(|(name, size)| (name, ShaderStage::Compute, size)).to_vec()
            }
            ("dirt/part_trees.wgsl", _) => compute(&["bound", "size", "leaves", "join", "list", "join_masks"], 64),
            (
                "dirt/trace.wgsl"
                | "dirt/packed_trace.wgsl"
                | "fragment-abuffer/trace.wgsl"
                | "quadtree/trace.wgsl"
                | "voxel-abuffer/trace.wgsl",
                _,
            ) => compute(&["trace", "trace_unanswered"], 64),
            ("dirt/visibility.wgsl", _) => compute(&["resolve"], 64),
            ("dirt/shadow_map.wgsl", _) => compute(&["look_up"], 64),
            ("fragment-abuffer/reorder_long.wgsl", _) => compute(&["reorder_long"], 256),
            ("voxel-abuffer/voxels.wgsl", _) => compute(&["trace"], 64),
            ("voxel-octree/voxelize.wgsl", _) => compute(&["measure", "count", "emit", "pad"], 64),
            ("voxel-octree/leaves.wgsl", _) => compute(&["mark", "gather", "sum", "finish"], 64),
            ("voxel-octree/levels.wgsl", _) => compute(&["mark", "join"], 64),
            ("test/quadtree_functions.wgsl", _) => {
                compute(&["convert", "encode", "merge_children", "tell_levels", "find_slopes", "cross_cells"], 64)
            }
            ("test/triangle_functions.wgsl", _) => compute(&["cross_pairs"], 64),
            ("test/octree_functions.wgsl", _) => compute(&["pack_normals", "place_voxels"], 64),
            ("test/lanes_functions.wgsl", _) => compute(&["take_turns", "take_from_blocks"], 64),
            ("test/view_functions.wgsl", _) => compute(&["project"], 64),
            ("test/walk_functions.wgsl", _) => compute(&["enter", "walk", "follow", "choose"], 64),
            ("test/reads_functions.wgsl", _) => compute(&["look_up"], 64),
            ("test/pyramid_functions.wgsl", _) => compute(&["descend", "gather_below", "sort_depths"], 64),
            ("bvh/binary.wgsl" | "bvh/cwbvh.wgsl", _) => compute(&["trace"], 64),
            ("dirt/fetch.wgsl" | "dirt/mask.wgsl" | "shared/nearest_raster.wgsl" | "shared/raster_probe.wgsl", _) => {
                raster.clone()
            }
            // One that is called as its file is.
            (file, _) => {
                let name = file.rsplit('/').next().and_then(|name| name.strip_suffix(".wgsl")).unwrap();
                vec![(name, ShaderStage::Compute, 64)]
            }
        }
    };
    for shader in ALL {
        let module = parse(shader.source);
        let found = module.entry_points.iter().map(|point| (point.name.as_str(), point.stage, point.workgroup_size[0]));
        assert_eq!(found.collect::<Vec<_>>(), expected(shader), "{}", shader.name);
    }
}

fn constants(module: &Module) -> BTreeMap<String, u32> {
    let values = module.constants.iter().filter_map(|(_, constant)| {
        let value = match module.global_expressions[constant.init] {
            naga::Expression::Literal(naga::Literal::U32(value)) => value,
            _ => return None,
        };
        Some((plain(constant.name.as_deref()?).to_owned(), value))
    });
    values.collect()
}

/// Proves that every status constant in every shader is the code of the Rust status of that name, that no primitive is what
/// Rust says it is, and that searches take stacks and textures to be as Rust makes them.
#[test]
fn constants_are_those_of_rust() {
    let (mut statuses, mut surface_statuses, mut row_bits) = (0, 0, 0);
    for shader in ALL {
        for (name, value) in constants(&parse(shader.source)) {
            if let Some(status) = name.strip_prefix("STATUS_") {
                let code = Status::ALL.iter().find(|known| known.name().to_uppercase() == status);
                assert_eq!(code.map(|code| *code as u32), Some(value), "{}: {name}", shader.name);
                statuses += 1;
            } else if let Some(status) = name.strip_prefix("SURFACE_") {
                let code = SurfaceStatus::ALL.iter().find(|known| known.name().to_uppercase() == status);
                assert_eq!(code.map(|code| *code as u32), Some(value), "{}: {name}", shader.name);
                surface_statuses += 1;
            } else if name == "NO_PRIMITIVE" {
                assert_eq!(value, NO_PRIMITIVE);
            } else if let Some(record) = name.strip_suffix("_ROW_BITS") {
                // Rows are as long in bytes, whatever records they have.
                let record_bits = match record {
                    "QUAD" => 4,
                    "PAIR" => 3,
                    _ => 2,
                };
                assert_eq!(value + record_bits, ROW_BITS, "{}: {name}", shader.name);
                row_bits += 1;
            } else if name == "PRIVATE_STACK" {
                let wide = shader.file == "bvh/cwbvh.wgsl";
                assert_eq!(value as usize, if wide { WIDE_STACK } else { BINARY_STACK }, "{}", shader.name);
            } else if name == "MAX_LEVELS" {
                // Builds on the device rely on the stacks: a compressed level has room for three binary ones.
                assert_eq!(value as usize, BINARY_STACK, "{}", shader.name);
                assert!(value as usize <= 3 * WIDE_STACK);
            }
        }
    }
    assert!(statuses >= 5, "only {statuses} status constants were found");
    assert!(surface_statuses >= 3, "only {surface_statuses} statuses of surfaces were found");
    assert!(row_bits >= 8, "only {row_bits} searches tell their textures' width");
    // Negative control: a constant is read as what it is.
    assert_eq!(constants(&parse("const STATUS_MISSX_naga_oil_mod_QX: u32 = 3u;"))["STATUS_MISS"], 3);
}

/// `Projection` of shaders/test/view_functions.wgsl.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Projection {
    eye_point: [f32; 4],
    clip: [f32; 4],
    pixel: [f32; 4],
}

fn project_on_device(view: &View, points: &[Vec3]) -> Vec<Projection> {
    let gpu = gpu();
    let pipeline = compute_pipeline(&gpu, VIEW_FUNCTIONS, "project").unwrap();
    let padded: Vec<[f32; 4]> = points.iter().map(|point| [point.x, point.y, point.z, 0.0]).collect();
    let buffer = |name: &str, contents: &[u8], usage| gpu.buffer_with(name, contents, usage, "nothing").unwrap();
    let uniform = buffer("view", bytemuck::bytes_of(&view_uniform(view)), BufferUsages::UNIFORM);
    let input = buffer("points", bytemuck::cast_slice(&padded), BufferUsages::STORAGE);
    let bytes = (points.len() * size_of::<Projection>()) as u64;
    let output = gpu.buffer("projections", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC, "nothing").unwrap();
    let bindings = bind_group(
        &gpu,
        &pipeline.get_bind_group_layout(0),
        &[uniform.as_entire_binding(), input.as_entire_binding(), output.as_entire_binding()],
    );
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    dispatch_linear(&mut encoder, &pipeline, &bindings, points.len() as u32, 64);
    gpu.queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&gpu.read(&output, bytes).unwrap())
}

/// Roundings of half an ulp that lie between a point and its projection, with room for a driver that contracts or
/// reorders: the difference to the eye, three products and two sums with axes that were themselves rounded.
const ROUNDINGS: f64 = 16.0;
const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;

/// Points whose projection on the device is farther from f64 than rounding explains, and the number compared in pixels.
///
/// A point at offset o has eye coordinates off by at most `ROUNDINGS` half ulps of |o|; a pixel position inherits that
/// over the depth, times half the frame over the tangent, and a few roundings of its own. Behind the eye, and where the
/// depth is lost in its own rounding, there is no pixel to compare.
fn strays(view: &View, points: &[Vec3], found: &[Projection]) -> (Vec<String>, usize) {
    let (mut strays, mut in_pixels) = (Vec::new(), 0);
    for (point, found) in points.iter().zip(found) {
        let offset = point.as_dvec3() - view.eye;
        let expected = DVec3::new(offset.dot(view.right), offset.dot(view.up), offset.dot(view.forward));
        let slack = ROUNDINGS * HALF_ULP * offset.length() + f64::from(f32::MIN_POSITIVE);
        let eye_point = DVec3::from_slice(&found.eye_point[..3].iter().copied().map(f64::from).collect::<Vec<_>>());
        let mut right = (eye_point - expected).abs().max_element() <= slack;
        let clip = [
            expected.x / view.tan_half_width,
            expected.y / view.tan_half_height,
            view.near * (view.far - expected.z) / (view.far - view.near),
            expected.z,
        ];
        let stretch = [1.0 / view.tan_half_width, 1.0 / view.tan_half_height, view.near / (view.far - view.near), 1.0];
        for axis in 0..4 {
            let own = ROUNDINGS * HALF_ULP * (clip[axis].abs() + if axis == 2 { view.near } else { 0.0 });
            right &= (f64::from(found.clip[axis]) - clip[axis]).abs() <= slack * stretch[axis] + own;
        }
        if let Some(at) = view.project(point.as_dvec3()).filter(|at| at.depth > 4.0 * slack) {
            let relative = slack / at.depth;
            for (axis, (position, tangent)) in
                [(at.x, view.tan_half_width), (at.y, view.tan_half_height)].into_iter().enumerate()
            {
                let half = f64::from(view.size[axis]) / 2.0;
                let across = (position / half - 1.0).abs();
                let limit = half * (2.0 * relative * (1.0 / tangent + across) + ROUNDINGS * HALF_ULP * (1.0 + across));
                right &= (f64::from(found.pixel[axis]) - position).abs() <= limit;
            }
            in_pixels += 1;
        }
        if !right {
            strays.push(format!("{point} of {view:?}: {found:?}, expected eye {expected} clip {clip:?}"));
        }
    }
    (strays, in_pixels)
}

/// Views over seven decades of scale, wide and narrow, near their eye's origin and far from it.
fn views() -> Vec<View> {
    let mut numbers = Numbers::new(21);
    let mut views = Vec::new();
    for scale in [1e-3_f32, 1.0, 37.0, 1e4] {
        for (fov, frame) in [(1.0, [512, 256]), (0.02, [64, 64]), (2.9, [1920, 1]), (1.5, [1, 777])] {
            let eye = numbers.point().as_vec3() * scale;
            let target = eye + numbers.direction().as_vec3() * scale;
            let pose = viewpoint(eye, target, 1e-3 * scale, 50.0 * scale, frame);
            views.push(Viewpoint { vertical_fov: fov, ..pose }.frame_view());
        }
    }
    views
}

/// Points on the frame's edges and corners, at near and far, just before and beyond, behind the eye, in the eye, close to
/// it and far away.
fn hostile_points(view: &View) -> Vec<Vec3> {
    let mut numbers = Numbers::new(22);
    let [width, height] = view.size.map(f64::from);
    let mut points = vec![view.eye.as_vec3()];
    for depth in [view.near, view.near * 0.999, view.near * 1.001, view.far, view.far * 1.01, 0.1 * view.far] {
        for (x, y) in [
            (0.0, 0.0),
            (width, 0.0),
            (0.0, height),
            (width, height),
            (width / 2.0, height / 2.0),
            (0.5, 0.5),
            (-0.25, height + 3.0),
            (width - 1e-4, 1e-4),
        ] {
            let direction = view.direction_through(x, y);
            points.push((view.eye + direction * depth).as_vec3());
            points.push((view.eye - direction * depth).as_vec3());
        }
    }
    for exponent in -6..=6 {
        for _ in 0..12 {
            let distance = view.far * 10_f64.powi(exponent);
            points.push((view.eye + numbers.direction() * distance).as_vec3());
        }
    }
    points
}

/// Proves that the projection that every shader shares is f64's to within f32 rounding over hostile points and views.
#[test]
fn projection_is_that_of_f64() {
    let mut in_pixels = 0;
    for view in views() {
        let points = hostile_points(&view);
        let (strays, compared) = strays(&view, &points, &project_on_device(&view, &points));
        assert!(strays.is_empty(), "{} of {}: {}", strays.len(), points.len(), strays[0]);
        in_pixels += compared;
    }
    assert!(in_pixels > 1000, "{in_pixels}");
}

/// Negative control: an eye moved by a ten-thousandth of the view's depth, a field of view a ten-thousandth wider, and a
/// frame one pixel larger are each noticed.
#[test]
fn another_projection_is_noticed() {
    let view = views()[4];
    let points = hostile_points(&view);
    let found = project_on_device(&view, &points);
    assert!(strays(&view, &points, &found).0.is_empty());
    let moved = View { eye: view.eye + view.forward * (1e-4 * view.far), ..view };
    let wider = View { tan_half_width: view.tan_half_width * 1.0001, ..view };
    let larger = View { size: [view.size[0] + 1, view.size[1]], ..view };
    let upside_down = View { up: -view.up, ..view };
    for other in [moved, wider, larger, upside_down] {
        assert!(!strays(&other, &points, &found).0.is_empty(), "{other:?}");
    }
}
