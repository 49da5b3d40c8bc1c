//! Composes every shader variant from its modules, validates it and writes it out as plain WGSL. An error in a shader
//! fails the build.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};

/// Modules that others import, in order of dependence.
const MODULES: &[&str] =
    &["shared/types.wgsl", "shared/view.wgsl", "shared/dispatch.wgsl", "shared/triangle.wgsl", "bvh/search.wgsl"];

/// Every variant: constant's name, file, definitions that are switched on.
const VARIANTS: &[(&str, &str, &[&str])] = &[
    ("EYE_DEPTH_RASTER", "shared/eye_depth_raster.wgsl", &[]),
    ("SCREEN_DDA_TRACE", "screen-dda/trace.wgsl", &[]),
    ("SCREEN_DDA_TRACE_COUNTED", "screen-dda/trace.wgsl", &["COUNTERS"]),
    ("BVH_WIDE", "bvh/cwbvh.wgsl", &[]),
    ("BVH_WIDE_COUNTED", "bvh/cwbvh.wgsl", &["COUNTERS"]),
    ("BVH_WIDE_DEEP", "bvh/cwbvh.wgsl", &["DEEP"]),
    ("BVH_WIDE_DEEP_COUNTED", "bvh/cwbvh.wgsl", &["DEEP", "COUNTERS"]),
    ("BVH_BINARY", "bvh/binary.wgsl", &[]),
    ("BVH_BINARY_COUNTED", "bvh/binary.wgsl", &["COUNTERS"]),
    ("BVH_BINARY_DEEP", "bvh/binary.wgsl", &["DEEP"]),
    ("BVH_BINARY_DEEP_COUNTED", "bvh/binary.wgsl", &["DEEP", "COUNTERS"]),
    ("TEST_TRIANGLE_FUNCTIONS", "test/triangle_functions.wgsl", &[]),
    ("TEST_VIEW_FUNCTIONS", "test/view_functions.wgsl", &[]),
];

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo::rerun-if-changed=build.rs");
    let mut table = String::new();
    let mut names = String::new();
    for (name, file, definitions) in VARIANTS {
        let wgsl = compose(&root, file, definitions).unwrap_or_else(|error| panic!("{file} ({name}): {error}"));
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
