//! Composes every shader variant from its modules, validates it and writes it out as plain WGSL. An error in a shader
//! fails the build.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};

/// Modules that others import, in order of dependence.
const MODULES: &[&str] = &[
    "shared/types.wgsl",
    "shared/view.wgsl",
    "shared/dispatch.wgsl",
    "shared/depth_bounds.wgsl",
    "shared/image_walk.wgsl",
    "shared/surface.wgsl",
    "shared/triangle.wgsl",
    "bvh/search.wgsl",
    "bvh/build.wgsl",
    "shared/tile_clip.wgsl",
    "dirt/grid.wgsl",
    "dirt/hit_buffer.wgsl",
    "fragment-abuffer/layout.wgsl",
];

/// Every variant: constant's name, file, definitions that are switched on.
const VARIANTS: &[(&str, &str, &[&str])] = &[
    ("EYE_DEPTH_RASTER", "shared/eye_depth_raster.wgsl", &[]),
    ("GATHER", "shared/gather.wgsl", &[]),
    ("GATHER_BY_RAY", "shared/gather.wgsl", &["BY_RAY"]),
    ("PREFIX_SUM", "shared/prefix_sum.wgsl", &[]),
    ("PRIMITIVE_RASTER", "shared/primitive_raster.wgsl", &[]),
    ("RADIX_SORT", "shared/radix_sort.wgsl", &[]),
    ("SCREEN_DDA_TRACE", "screen-dda/trace.wgsl", &[]),
    ("SCREEN_DDA_TRACE_COUNTED", "screen-dda/trace.wgsl", &["COUNTERS"]),
    ("SCREEN_DDA_TRACE_SURFACES", "screen-dda/trace.wgsl", &["SURFACES"]),
    ("SCREEN_DDA_TRACE_SURFACES_COUNTED", "screen-dda/trace.wgsl", &["SURFACES", "COUNTERS"]),
    ("BVH_WIDE", "bvh/cwbvh.wgsl", &[]),
    ("BVH_WIDE_COUNTED", "bvh/cwbvh.wgsl", &["COUNTERS"]),
    ("BVH_WIDE_DEEP", "bvh/cwbvh.wgsl", &["DEEP"]),
    ("BVH_WIDE_DEEP_COUNTED", "bvh/cwbvh.wgsl", &["DEEP", "COUNTERS"]),
    ("BVH_BINARY", "bvh/binary.wgsl", &[]),
    ("BVH_BINARY_COUNTED", "bvh/binary.wgsl", &["COUNTERS"]),
    ("BVH_BINARY_DEEP", "bvh/binary.wgsl", &["DEEP"]),
    ("BVH_BINARY_DEEP_COUNTED", "bvh/binary.wgsl", &["DEEP", "COUNTERS"]),
    ("BVH_BUILD_LEAVES", "bvh/leaves.wgsl", &[]),
    ("BVH_BUILD_CLUSTER", "bvh/cluster.wgsl", &[]),
    ("BVH_BUILD_CLUSTER_WIDE", "bvh/cluster.wgsl", &["WIDE"]),
    ("BVH_BUILD_CONVERT", "bvh/convert.wgsl", &[]),
    ("BVH_REFIT_BINARY", "bvh/refit.wgsl", &[]),
    ("BVH_REFIT_WIDE", "bvh/refit.wgsl", &["WIDE"]),
    ("DIRT_FILL_DEPTH", "dirt/fill.wgsl", &[]),
    ("DIRT_FILL_DEPTH_CONSERVATIVE", "dirt/fill.wgsl", &["CONSERVATIVE"]),
    ("DIRT_FILL_PRIMITIVES", "dirt/fill.wgsl", &["PRIMITIVES"]),
    ("DIRT_FILL_PRIMITIVES_CONSERVATIVE", "dirt/fill.wgsl", &["PRIMITIVES", "CONSERVATIVE"]),
    ("DIRT_FILL_PRIMITIVES_SPLIT", "dirt/fill.wgsl", &["PRIMITIVES", "SPLIT"]),
    ("DIRT_FILL_PRIMITIVES_CONSERVATIVE_SPLIT", "dirt/fill.wgsl", &["PRIMITIVES", "CONSERVATIVE", "SPLIT"]),
    ("DIRT_STORE", "dirt/store.wgsl", &[]),
    ("DIRT_MASK", "dirt/mask.wgsl", &[]),
    ("DIRT_FETCH", "dirt/fetch.wgsl", &[]),
    ("DIRT_FETCH_CONSERVATIVE", "dirt/fetch.wgsl", &["CONSERVATIVE"]),
    ("DIRT_VISIBILITY", "dirt/visibility.wgsl", &[]),
    ("DIRT_MIPMAP", "dirt/mipmap.wgsl", &[]),
    ("DIRT_TRACE", "dirt/trace.wgsl", &[]),
    ("DIRT_TRACE_COUNTED", "dirt/trace.wgsl", &["COUNTERS"]),
    ("DIRT_TRACE_SPLIT", "dirt/trace.wgsl", &["SPLIT"]),
    ("DIRT_TRACE_SPLIT_COUNTED", "dirt/trace.wgsl", &["SPLIT", "COUNTERS"]),
    ("DIRT_TRACE_CENTRES", "dirt/trace.wgsl", &["SPLIT", "CENTRES"]),
    ("DIRT_TRACE_CENTRES_COUNTED", "dirt/trace.wgsl", &["SPLIT", "CENTRES", "COUNTERS"]),
    ("FRAGMENT_BOUNDS", "fragment-abuffer/fill.wgsl", &["BOUNDS"]),
    ("FRAGMENT_COUNT", "fragment-abuffer/fill.wgsl", &["COUNT"]),
    ("FRAGMENT_TALLY", "fragment-abuffer/fill.wgsl", &["TALLY"]),
    ("FRAGMENT_STORE", "fragment-abuffer/fill.wgsl", &["STORE"]),
    ("FRAGMENT_STORE_DECOUPLED", "fragment-abuffer/fill.wgsl", &["STORE", "DECOUPLED"]),
    ("FRAGMENT_BOXES", "fragment-abuffer/boxes.wgsl", &[]),
    ("FRAGMENT_BOXES_BOUND", "fragment-abuffer/boxes.wgsl", &["BOUND"]),
    ("FRAGMENT_REORDER", "fragment-abuffer/reorder.wgsl", &[]),
    ("FRAGMENT_REORDER_DECOUPLED", "fragment-abuffer/reorder.wgsl", &["DECOUPLED"]),
    ("FRAGMENT_REORDER_CONTIGUOUS", "fragment-abuffer/reorder.wgsl", &["CONTIGUOUS"]),
    ("FRAGMENT_REORDER_CONTIGUOUS_DECOUPLED", "fragment-abuffer/reorder.wgsl", &["CONTIGUOUS", "DECOUPLED"]),
    ("FRAGMENT_MIPMAP", "fragment-abuffer/mipmap.wgsl", &[]),
    ("FRAGMENT_TRACE", "fragment-abuffer/trace.wgsl", &[]),
    ("FRAGMENT_TRACE_COUNTED", "fragment-abuffer/trace.wgsl", &["COUNTERS"]),
    ("FRAGMENT_TRACE_SURFACES", "fragment-abuffer/trace.wgsl", &["SURFACES"]),
    ("FRAGMENT_TRACE_SURFACES_COUNTED", "fragment-abuffer/trace.wgsl", &["SURFACES", "COUNTERS"]),
    ("FRAGMENT_TRACE_SPLIT", "fragment-abuffer/trace.wgsl", &["SPLIT"]),
    ("FRAGMENT_TRACE_SPLIT_COUNTED", "fragment-abuffer/trace.wgsl", &["SPLIT", "COUNTERS"]),
    ("FRAGMENT_TRACE_SPLIT_SURFACES", "fragment-abuffer/trace.wgsl", &["SPLIT", "SURFACES"]),
    ("FRAGMENT_TRACE_SPLIT_SURFACES_COUNTED", "fragment-abuffer/trace.wgsl", &["SPLIT", "SURFACES", "COUNTERS"]),
    ("FRAGMENT_TRACE_CONTIGUOUS", "fragment-abuffer/trace.wgsl", &["CONTIGUOUS"]),
    ("FRAGMENT_TRACE_CONTIGUOUS_COUNTED", "fragment-abuffer/trace.wgsl", &["CONTIGUOUS", "COUNTERS"]),
    ("FRAGMENT_TRACE_CONTIGUOUS_SURFACES", "fragment-abuffer/trace.wgsl", &["CONTIGUOUS", "SURFACES"]),
    (
        "FRAGMENT_TRACE_CONTIGUOUS_SURFACES_COUNTED",
        "fragment-abuffer/trace.wgsl",
        &["CONTIGUOUS", "SURFACES", "COUNTERS"],
    ),
    ("FRAGMENT_TRACE_CONTIGUOUS_SPLIT", "fragment-abuffer/trace.wgsl", &["CONTIGUOUS", "SPLIT"]),
    ("FRAGMENT_TRACE_CONTIGUOUS_SPLIT_COUNTED", "fragment-abuffer/trace.wgsl", &["CONTIGUOUS", "SPLIT", "COUNTERS"]),
    ("FRAGMENT_TRACE_CONTIGUOUS_SPLIT_SURFACES", "fragment-abuffer/trace.wgsl", &["CONTIGUOUS", "SPLIT", "SURFACES"]),
    (
        "FRAGMENT_TRACE_CONTIGUOUS_SPLIT_SURFACES_COUNTED",
        "fragment-abuffer/trace.wgsl",
        &["CONTIGUOUS", "SPLIT", "SURFACES", "COUNTERS"],
    ),
    ("TEST_TRIANGLE_FUNCTIONS", "test/triangle_functions.wgsl", &[]),
    ("TEST_VIEW_FUNCTIONS", "test/view_functions.wgsl", &[]),
];

/// Shaders with ray queries: constant's name, file. naga_oil resolves imports in naga's own form, and naga's WGSL writer has
/// no ray queries, so what it composes could not be written out. These files have their modules put before them as text
/// instead: modules import one another by plain names that no two of them share, and none has conditions.
const WITH_RAY_QUERIES: &[(&str, &str)] = &[("RAY_QUERY", "bvh/ray_query.wgsl")];

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo::rerun-if-changed=build.rs");
    let mut table = String::new();
    let mut names = String::new();
    let composed =
        VARIANTS.iter().map(|(name, file, definitions)| (name, file, *definitions, compose(&root, file, definitions)));
    let joined = WITH_RAY_QUERIES.iter().map(|(name, file)| (name, file, &[][..], join(&root, file)));
    for (name, file, definitions, wgsl) in composed.chain(joined) {
        let wgsl = wgsl.unwrap_or_else(|error| panic!("{file} ({name}): {error}"));
        let path = out.join(format!("{name}.wgsl"));
        std::fs::write(&path, wgsl).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let _ = writeln!(
            table,
            "/// `{file}` with {definitions:?} switched on.\npub const {name}: Shader = Shader {{ name: {name:?}, \
             source: include_str!(concat!(env!(\"OUT_DIR\"), \"/{name}.wgsl\")) }};"
        );
        let _ = write!(names, "{name}, ");
    }
    let _ = writeln!(table, "/// Every variant.\npub const ALL: &[Shader] = &[{names}];");
    std::fs::write(out.join("table.rs"), table).expect("OUT_DIR is writable");
}

fn read(root: &Path, file: &str) -> Result<String, String> {
    println!("cargo::rerun-if-changed={file}");
    std::fs::read_to_string(root.join(file)).map_err(|error| error.to_string())
}

fn compose(root: &Path, file: &str, definitions: &[&str]) -> Result<String, String> {
    let mut composer = Composer::default();
    for module in MODULES {
        let source = read(root, module)?;
        let descriptor = ComposableModuleDescriptor { source: &source, file_path: module, ..Default::default() };
        if let Err(error) = composer.add_composable_module(descriptor) {
            return Err(error.emit_to_string(&composer));
        }
    }
    let source = read(root, file)?;
    let shader_defs: HashMap<_, _> =
        definitions.iter().map(|name| ((*name).to_owned(), ShaderDefValue::Bool(true))).collect();
    let descriptor = NagaModuleDescriptor { source: &source, file_path: file, shader_defs, ..Default::default() };
    let module = match composer.make_naga_module(descriptor) {
        Ok(module) => module,
        Err(error) => return Err(error.emit_to_string(&composer)),
    };
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    let info = validator.validate(&module).map_err(|error| error.emit_to_string(&source))?;
    naga::back::wgsl::write_string(&module, &info, naga::back::wgsl::WriterFlags::empty())
        .map_err(|error| error.to_string())
}

/// The file as text, after the modules that it imports and behind its `enable` lines, validated.
fn join(root: &Path, file: &str) -> Result<String, String> {
    let source = read(root, file)?;
    let (enabled, own): (Vec<&str>, Vec<&str>) = source.lines().partition(|line| line.starts_with("enable "));
    let mut joined = enabled.join("\n");
    let mut imported: Vec<&str> = own.iter().filter_map(|line| imported_module(line)).collect();
    let modules = MODULES.iter().map(|module| read(root, module)).collect::<Result<Vec<_>, _>>()?;
    // Those that others import come first; the latter are known when the list is read from its end.
    for module in modules.iter().rev() {
        if defined_module(module).is_some_and(|name| imported.contains(&name)) {
            imported.extend(module.lines().filter_map(imported_module));
        }
    }
    let chosen = modules.iter().filter(|module| defined_module(module).is_some_and(|name| imported.contains(&name)));
    for text in chosen.map(String::as_str).chain([own.join("\n").as_str()]) {
        for line in text.lines().filter(|line| !line.starts_with("#import") && !line.starts_with("#define_import_path"))
        {
            if line.starts_with('#') {
                return Err(format!("'{line}' cannot be resolved in a shader with ray queries"));
            }
            joined.push('\n');
            joined.push_str(line);
        }
    }
    joined.push('\n');
    let module = naga::front::wgsl::parse_str(&joined).map_err(|error| error.emit_to_string(&joined))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::RAY_QUERY);
    validator.validate(&module).map_err(|error| error.emit_to_string(&joined))?;
    Ok(joined)
}

/// The name by which others import a module.
fn defined_module(source: &str) -> Option<&str> {
    source.lines().find_map(|line| line.strip_prefix("#define_import_path ")).map(str::trim)
}

/// The module that a line imports from.
fn imported_module(line: &str) -> Option<&str> {
    let path = line.strip_prefix("#import ")?.trim();
    let end = path.find("::{").or_else(|| path.rfind("::"))?;
    Some(&path[..end])
}
