//! Composes every shader variant from its modules, validates it and writes it out as plain WGSL. An error in a shader
//! fails the build. Folders are found here and say themselves what is in them: a tracer's needs no line in this file.

mod list;
mod needs;
mod structs;
mod table;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use list::{Listed, Source, check_definitions, modules_of, read_list};
use naga::Module;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};
use needs::needs_of;
use structs::{bound_structs, plain};
use table::{Composed, Table};

/// What a folder's list is called.
const LIST: &str = "variants.txt";

/// What a shader that asks the device for hits begins with. naga_oil resolves imports in naga's own form, and naga's WGSL
/// writer has no ray queries, so what it composes could not be written out. Such files have their modules put before them as
/// text instead: modules import one another by plain names that no two of them share, and none of those has conditions.
const WITH_RAY_QUERIES: &str = "enable wgpu_ray_query;";

/// What WGSL has that naga counts as an extension: numbers in half precision in words (`pack2x16float`), which every device of WebGPU
/// has.
const WGSL: Capabilities = Capabilities::SHADER_FLOAT16_IN_FLOAT32;

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo::rerun-if-changed=.");
    if let Err(error) = make(&root, &out) {
        panic!("{error}");
    }
}

/// A folder of shaders: its name, its list, its files.
struct Folder {
    name: String,
    listed: Vec<Listed>,
    shaders: Vec<Source>,
}

fn make(root: &Path, out: &Path) -> Result<(), String> {
    let mut modules = Vec::new();
    let folders = names_in(root)?.into_iter().map(|name| read_folder(root, name, &mut modules));
    let folders = folders.collect::<Result<Vec<_>, _>>()?;
    for (place, module) in modules.iter().enumerate() {
        if let Some(other) = modules[..place].iter().find(|other| other.module_name() == module.module_name()) {
            return Err(format!("{} and {} define the same import path", other.file, module.file));
        }
    }
    // One for all, since it keeps every module that it has composed.
    let mut composer = Composer::default().with_capabilities(WGSL);
    let mut table = Table::default();
    for Folder { name, listed, shaders } in &folders {
        table.add_folder(name, listed, |each, definitions| {
            let file = format!("{name}/{}.wgsl", each.stem);
            let Some(shader) = shaders.iter().find(|shader| shader.file == file) else {
                return Err(format!("{name}/{LIST} lists a file that is not there"));
            };
            let modules = modules_of(shader, &modules)?;
            check_definitions(each, shader, &modules)?;
            let (module, info, text) = match shader.text.starts_with(WITH_RAY_QUERIES) {
                true => join(shader, &modules)?,
                false => compose(&mut composer, shader, &modules, definitions)?,
            };
            let file_of = |name: &str| {
                let begin = format!("struct {name} {{");
                let declares = |source: &&Source| source.text.lines().any(|line| line == begin);
                let mut sources = std::iter::once(shader).chain(modules.iter().copied());
                sources.find(declares).map(|source| source.file.clone()).unwrap_or_default()
            };
            let structs = bound_structs(&module, file_of)?;
            let overrides =
                module.overrides.iter().map(|(_, each)| (plain(&each.name), each.name.clone().unwrap_or_default()));
            Ok(Composed { text, needs: needs_of(&module, &info), overrides: overrides.collect(), structs })
        })?;
    }
    let source = ("table.rs".to_owned(), table.source());
    for (name, text) in table.files.iter().chain([&source]) {
        let path = out.join(name);
        std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

/// Names in a folder, in order.
fn names_in(folder: &Path) -> Result<Vec<String>, String> {
    let fail = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(fail)?.collect::<Result<Vec<_>, _>>().map_err(fail)?;
    let names = entries.iter().filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<_> = names.collect();
    names.sort();
    Ok(names)
}

/// Reads a folder, if it is one with shaders; its modules go to `modules`.
fn read_folder(root: &Path, name: String, modules: &mut Vec<Source>) -> Result<Folder, String> {
    let mut folder = Folder { listed: Vec::new(), shaders: Vec::new(), name };
    let path = root.join(&folder.name);
    if !path.is_dir() {
        return Ok(folder);
    }
    let read = |file: &str| std::fs::read_to_string(path.join(file)).map_err(|error| format!("{file}: {error}"));
    let files = names_in(&path)?;
    if files.iter().any(|file| file == LIST) {
        folder.listed = read_list(&read(LIST)?).map_err(|error| format!("{}/{LIST}: {error}", folder.name))?;
    }
    for file in files.iter().filter(|file| file.ends_with(".wgsl")) {
        let source = Source { file: format!("{}/{file}", folder.name), text: read(file)? };
        let is_listed = folder.listed.iter().any(|each| file.strip_suffix(".wgsl") == Some(&each.stem));
        match (source.module_name().is_some(), is_listed) {
            (true, false) => modules.push(source),
            (false, true) => folder.shaders.push(source),
            (true, true) => return Err(format!("{} is a module, and {LIST} lists it as a shader", source.file)),
            (false, false) => return Err(format!("{} is no module, and {LIST} does not list it", source.file)),
        }
    }
    Ok(folder)
}

/// A shader with what validation finds of it, and its text.
type Validated = (Module, ModuleInfo, String);

fn compose(
    composer: &mut Composer,
    shader: &Source,
    modules: &[&Source],
    definitions: &[String],
) -> Result<Validated, String> {
    let is_new =
        |composer: &Composer, module: &Source| module.module_name().is_some_and(|name| !composer.contains_module(name));
    for module in modules {
        if !is_new(composer, module) {
            continue;
        }
        let descriptor =
            ComposableModuleDescriptor { source: &module.text, file_path: &module.file, ..Default::default() };
        if let Err(error) = composer.add_composable_module(descriptor) {
            return Err(error.emit_to_string(composer));
        }
    }
    let shader_defs: HashMap<_, _> =
        definitions.iter().map(|name| (name.clone(), ShaderDefValue::Bool(true))).collect();
    let descriptor =
        NagaModuleDescriptor { source: &shader.text, file_path: &shader.file, shader_defs, ..Default::default() };
    let module = match composer.make_naga_module(descriptor) {
        Ok(module) => module,
        Err(error) => return Err(error.emit_to_string(composer)),
    };
    let mut validator = Validator::new(ValidationFlags::all(), WGSL);
    let info = validator.validate(&module).map_err(|error| error.emit_to_string(&shader.text))?;
    let text = naga::back::wgsl::write_string(&module, &info, naga::back::wgsl::WriterFlags::empty())
        .map_err(|error| error.to_string())?;
    Ok((module, info, text))
}

/// The file as text, after its modules and behind its `enable` lines, validated.
fn join(shader: &Source, modules: &[&Source]) -> Result<Validated, String> {
    let (enabled, own): (Vec<&str>, Vec<&str>) = shader.text.lines().partition(|line| line.starts_with("enable "));
    let mut joined = enabled.join("\n");
    for line in modules.iter().flat_map(|module| module.text.lines()).chain(own) {
        if line.starts_with("#import") || line.starts_with("#define_import_path") {
            continue;
        }
        if line.starts_with('#') {
            return Err(format!("'{line}' cannot be resolved in a shader with ray queries"));
        }
        joined.push('\n');
        joined.push_str(line);
    }
    joined.push('\n');
    let module = naga::front::wgsl::parse_str(&joined).map_err(|error| error.emit_to_string(&joined))?;
    let mut validator = Validator::new(ValidationFlags::all(), WGSL | Capabilities::RAY_QUERY);
    let info = validator.validate(&module).map_err(|error| error.emit_to_string(&joined))?;
    Ok((module, info, joined))
}
