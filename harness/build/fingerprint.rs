//! What made a row: a hash of the sources that its tracer, its rays, its truth and its judgement come from. Comments, documentation and
//! tests do not count. The build script makes them; a test changes sources and looks at which tracers' change.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use sha2::{Digest, Sha256};
use toml::{Table, Value};

/// Where rays, truth and judgements are made.
const JUDGING: [&str; 4] = ["rays", "truth", "judge", "viewpoint"];

/// Sources of a repository, by their paths below its root.
pub struct Sources<'a> {
    /// The text of a file, `None` where there is none.
    pub read: &'a dyn Fn(&str) -> Option<String>,
    /// The names in a folder, in any order; none where there is no such folder.
    pub list: &'a dyn Fn(&str) -> Vec<String>,
}

/// The fingerprint of every registered tracer: 16 hexadecimal digits, by the name of its registration.
///
/// # Errors
/// What cannot be read or understood.
pub fn fingerprints(sources: &Sources<'_>) -> Result<BTreeMap<String, String>, String> {
    let manifest = table(sources, "Cargo.toml")?;
    let lock = lock(&table(sources, "Cargo.lock")?);
    let house = House { sources, lock, manifest, known: RefCell::default() };
    let mut judging = Hashed::default();
    judging.0.insert("profile".to_owned(), house.manifest["profile"].to_string());
    JUDGING.iter().try_for_each(|module| house.add_module("harness/src", module, &mut judging))?;
    let code = judging.0.values().map(String::as_str).collect::<Vec<_>>().join(" ");
    house.add_named("harness", &code, &mut judging)?;
    let mut all = BTreeMap::from([("controls".to_owned(), judging.digest())]);
    // What a registration expects of a tracer does not change its rows; what it makes does.
    let folder = "harness/src/registrations";
    let text = house.code_of(&format!("{folder}/mod.rs"))?.text;
    let entries = text.split_once("registrations ! { ").and_then(|(_, entries)| entries.split_once('}'));
    let (entries, _) = entries.ok_or_else(|| format!("{folder}/mod.rs has no entries"))?;
    let mut add = |name: &str, text: &str| {
        let mut hashed = judging.clone();
        house.add_named("harness", text, &mut hashed)?;
        all.insert(name.to_owned(), hashed.digest());
        Ok::<_, String>(())
    };
    for entry in entries.split(';').map(str::trim).filter(|entry| !entry.is_empty()) {
        add(entry.split(' ').next().unwrap_or_default(), entry)?;
    }
    // One that is made of others has a file, and its rows are made by theirs, too.
    for file in (sources.list)(folder).iter().filter(|file| file.ends_with(".rs") && *file != "mod.rs") {
        let text = house.code_of(&format!("{folder}/{file}"))?.text;
        if text.contains("REGISTRATION : Registration") {
            add(file.trim_end_matches(".rs"), &format!("{text} {entries}"))?;
        }
    }
    Ok(all)
}

/// What a fingerprint is of: each source once, by its name.
#[derive(Clone, Default)]
struct Hashed(BTreeMap<String, String>);

impl Hashed {
    fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for (name, text) in &self.0 {
            hash.update(format!("{name}\0{text}\0"));
        }
        hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
    }
}

struct House<'a> {
    sources: &'a Sources<'a>,
    /// The workspace's manifest.
    manifest: Table,
    /// Packages of Cargo.lock: versions with checksums, and what they need, by name.
    lock: BTreeMap<String, (String, Vec<String>)>,
    /// Files that were read before.
    known: RefCell<BTreeMap<String, Code>>,
}

impl House<'_> {
    fn code_of(&self, file: &str) -> Result<Code, String> {
        if let Some(code) = self.known.borrow().get(file) {
            return Ok(code.clone());
        }
        let text = (self.sources.read)(file).ok_or_else(|| format!("{file} cannot be read"))?;
        let mut code = Code::default();
        add_tokens(text.parse().map_err(|error| format!("{file}: {error}"))?, &mut code);
        self.known.borrow_mut().insert(file.to_owned(), code.clone());
        Ok(code)
    }

    /// A Rust file and the modules below it, without those of tests.
    fn add_rust(&self, file: &str, hashed: &mut Hashed) -> Result<(), String> {
        let code = self.code_of(file)?;
        hashed.0.insert(file.to_owned(), code.text);
        let (folder, name) = file.rsplit_once('/').unwrap_or_default();
        let stem = name.trim_end_matches(".rs");
        let below = if ["lib", "main", "mod"].contains(&stem) { folder.to_owned() } else { format!("{folder}/{stem}") };
        code.modules.iter().try_for_each(|module| self.add_module(&below, module, hashed))
    }

    fn add_module(&self, folder: &str, module: &str, hashed: &mut Hashed) -> Result<(), String> {
        let file = [format!("{folder}/{module}.rs"), format!("{folder}/{module}/mod.rs")];
        let file = file.into_iter().find(|file| (self.sources.read)(file).is_some());
        self.add_rust(&file.ok_or_else(|| format!("{folder} has no module {module}"))?, hashed)
    }

    /// The dependencies of a package that a text names.
    fn add_named(&self, package: &str, text: &str, hashed: &mut Hashed) -> Result<(), String> {
        let manifest = table(self.sources, &format!("{package}/Cargo.toml"))?;
        let words: BTreeSet<&str> = text.split_whitespace().collect();
        let named = dependencies(&manifest).filter(|name| words.contains(name.replace('-', "_").as_str()));
        named.map(str::to_owned).try_for_each(|name| self.add_package(&name, hashed))
    }

    /// A package with all that it needs: sources of one of this workspace, entries of Cargo.lock of others.
    fn add_package(&self, name: &str, hashed: &mut Hashed) -> Result<(), String> {
        let Some((version, needed)) = self.lock.get(name) else { return Err(format!("Cargo.lock has no {name}")) };
        let listed = self.manifest["workspace"]["dependencies"].get(name);
        let Some(folder) = listed.and_then(|listed| listed.get("path")).and_then(Value::as_str) else {
            if hashed.0.insert(format!("package {name}"), version.clone()).is_none() {
                needed.iter().try_for_each(|name| self.add_package(name, hashed))?;
            }
            return Ok(());
        };
        let file = format!("{folder}/Cargo.toml");
        if hashed.0.contains_key(&file) {
            return Ok(());
        }
        let manifest = table(self.sources, &file)?;
        hashed.0.insert(file, dependencies(&manifest).collect::<Vec<_>>().join(" "));
        let mut own = Hashed::default();
        self.add_rust(&format!("{folder}/src/lib.rs"), &mut own)?;
        if let Some(build) = manifest["package"].get("build").and_then(Value::as_str) {
            self.add_rust(&format!("{folder}/{build}"), &mut own)?;
        }
        let code = own.0.values().map(String::as_str).collect::<Vec<_>>().join(" ");
        hashed.0.extend(own.0);
        self.add_shaders(&code, hashed);
        dependencies(&manifest).map(str::to_owned).try_for_each(|name| self.add_package(&name, hashed))
    }

    /// The folders of shaders that code names, and the modules that these import.
    fn add_shaders(&self, code: &str, hashed: &mut Hashed) {
        let used = code.split("tracebench_shaders :: ").skip(1).map(|rest| rest.split(';').next().unwrap_or_default());
        let used: BTreeSet<&str> = used.flat_map(str::split_whitespace).collect();
        let mut modules = BTreeMap::new();
        let mut waiting = Vec::new();
        for folder in (self.sources.list)("shaders") {
            let list = (self.sources.read)(&format!("shaders/{folder}/variants.txt"));
            let is_used = used.contains(folder.replace('-', "_").as_str());
            for file in (self.sources.list)(&format!("shaders/{folder}")) {
                let Some(stem) = file.strip_suffix(".wgsl") else { continue };
                let file = format!("shaders/{folder}/{file}");
                let code = wgsl_code(&(self.sources.read)(&file).unwrap_or_default());
                let module = code.split_once("#define_import_path ").and_then(|(_, rest)| rest.split(' ').next());
                if let Some(module) = module {
                    modules.insert(module.to_owned(), (file, code));
                } else if let Some(line) =
                    list.iter().flat_map(|list| list.lines()).find(|line| line.starts_with(&format!("{stem}:")))
                    && is_used
                {
                    waiting.push((file, format!("{line} {code}")));
                }
            }
        }
        while let Some((file, code)) = waiting.pop() {
            for (name, module) in &modules {
                if names(&code, name) && !hashed.0.contains_key(&module.0) {
                    waiting.push(module.clone());
                }
            }
            hashed.0.insert(file, code);
        }
    }
}

/// Whether WGSL names a module: another one's name may begin with its.
fn names(code: &str, module: &str) -> bool {
    code.split(module).skip(1).any(|rest| !rest.starts_with(|next: char| next == '_' || next.is_ascii_alphanumeric()))
}

fn table(sources: &Sources<'_>, file: &str) -> Result<Table, String> {
    let text = (sources.read)(file).ok_or_else(|| format!("{file} cannot be read"))?;
    text.parse().map_err(|error| format!("{file}: {error}"))
}

/// Packages by name, with what they need. Of a package that is there in several versions all count.
fn lock(lock: &Table) -> BTreeMap<String, (String, Vec<String>)> {
    let mut packages: BTreeMap<String, (String, Vec<String>)> = BTreeMap::new();
    for package in lock.get("package").and_then(Value::as_array).into_iter().flatten() {
        let text = |key: &str| package.get(key).and_then(Value::as_str).unwrap_or_default();
        let needed = package.get("dependencies").and_then(Value::as_array).into_iter().flatten();
        let needed = needed.filter_map(|each| each.as_str()?.split(' ').next().map(str::to_owned));
        let (versions, all) = packages.entry(text("name").to_owned()).or_default();
        versions.push_str(&format!("{} {};", text("version"), text("checksum")));
        all.extend(needed);
    }
    packages
}

/// What a package's library and its build need.
fn dependencies(manifest: &Table) -> impl Iterator<Item = &str> {
    let sections = ["dependencies", "build-dependencies"].into_iter();
    sections.filter_map(|section| manifest.get(section)?.as_table()).flat_map(|names| names.keys().map(String::as_str))
}

/// Rust without comments, documentation and tests; `modules` are those whose sources are files of their own.
#[derive(Clone, Default)]
struct Code {
    text: String,
    modules: Vec<String>,
}

fn is(token: &TokenTree, mark: char) -> bool {
    matches!(token, TokenTree::Punct(each) if each.as_char() == mark)
}

fn add_tokens(tokens: TokenStream, code: &mut Code) {
    let mut tokens = tokens.into_iter().peekable();
    let mut before = String::new();
    while let Some(token) = tokens.next() {
        // The `!` of what stands for the whole file.
        let inner = is(&token, '#') && tokens.next_if(|next| is(next, '!')).is_some();
        if let Some(TokenTree::Group(group)) = tokens.peek()
            && is(&token, '#')
            && group.delimiter() == Delimiter::Bracket
        {
            let attribute = group.stream().to_string();
            if attribute.starts_with("doc ") {
                tokens.next();
                continue;
            }
            if attribute == "cfg (test)" && !inner {
                // The item behind it: up to its braces or its semicolon.
                let is_body =
                    |token: &TokenTree| matches!(token, TokenTree::Group(each) if each.delimiter() == Delimiter::Brace);
                let _ = tokens.by_ref().find(|token| is(token, ';') || is_body(token));
                tokens.next_if(|next| is(next, ';'));
                continue;
            }
        }
        let last = match &token {
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::None => ("", ""),
                };
                code.text += &format!("{open} ");
                add_tokens(group.stream(), code);
                close.to_owned()
            }
            other => other.to_string(),
        };
        if before == "mod" && tokens.peek().is_some_and(|next| is(next, ';')) {
            code.modules.push(last.clone());
        }
        code.text += &last;
        // `::`, `->` and such stay what they are.
        let joined = matches!(&token, TokenTree::Punct(each) if each.spacing() == proc_macro2::Spacing::Joint);
        if !joined {
            code.text.push(' ');
        }
        before = last;
    }
}

/// WGSL without comments, a space between words.
fn wgsl_code(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text;
    while let Some(at) = rest.find('/') {
        let (before, from) = rest.split_at(at);
        code += before;
        let end = match from.as_bytes().get(1) {
            Some(b'/') => from.find('\n'),
            Some(b'*') => from.find("*/").map(|end| end + 2),
            _ => {
                code.push('/');
                Some(1)
            }
        };
        rest = &from[end.unwrap_or(from.len())..];
    }
    (code + rest).split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The fingerprints of this repository where `from` is `to` in one file.
    fn changed(file: &str, from: &str, to: &str) -> BTreeMap<String, String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let read = |asked: &str| {
            let text = std::fs::read_to_string(root.join(asked)).ok()?;
            assert!(asked != file || text.contains(from), "{file} has no {from}");
            Some(if asked == file { text.replacen(from, to, 1) } else { text })
        };
        let list = |folder: &str| {
            let entries = std::fs::read_dir(root.join(folder)).into_iter().flatten();
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
        };
        fingerprints(&Sources { read: &read, list: &list }).unwrap()
    }

    /// Proves that a character of code changes the fingerprints of exactly those that are made by it, that comments, documentation, tests
    /// and reports change none, and that the program has the same ones.
    #[test]
    fn fingerprints_are_of_what_makes_rows() {
        let now = changed("Cargo.toml", "", "");
        assert_eq!(now.len(), crate::registry::TRACERS.len() + 1);
        for (name, hash) in &now {
            assert_eq!(crate::machine::fingerprint(name), Some(hash.as_str()), "{name}");
        }
        let hierarchies = "bvh_cpu bvh_gpu hybrid ploc_gpu ray_query";
        let all: Vec<&str> = now.keys().map(String::as_str).collect();
        let tracers = all.iter().copied().filter(|name| *name != "controls").collect::<Vec<_>>().join(" ");
        for (file, from, to, stale) in [
            ("shaders/dirt/trace.wgsl", "open += 1u", "open += 2u", "dirt hybrid"),
            ("shaders/dirt/trace.wgsl", "\n//", "\n// More.\n//", ""),
            ("shaders/quadtree/walk.wgsl", "1u", "2u", "hybrid quadtree"),
            ("shaders/shared/voxel_walk.wgsl", "1.0 - origin.x", "2.0 - origin.x", "hybrid voxel_abuffer voxel_octree"),
            ("shaders/shared/lanes.wgsl", "= 64u", "= 32u", &tracers),
            ("shaders/bvh/variants.txt", "<WIDE>", "[WIDE]", hierarchies),
            ("shaders/test/view_functions.wgsl", "clip: vec4", "clip: vec3", ""),
            ("tracers/bvh/src/cpu.rs", "let ", "let mut ", hierarchies),
            ("tracers/bvh/src/cpu.rs", "//!", "//! More.\n//!", ""),
            ("tracers/dirt/src/fetch_tests.rs", "let ", "let mut ", ""),
            ("tracers/kit/src/lanes.rs", "65_535", "65_534", &tracers),
            ("tracers/kit/src/lanes.rs", "[32, 32, 32", "[32, 32, 31", ""),
            ("harness/src/truth/triangle.rs", "shear.x", "shear.y", &all.join(" ")),
            ("harness/src/report/mod.rs", "let ", "let mut ", ""),
            ("Cargo.lock", "name = \"naga_oil\"\nversion = \"", "name = \"naga_oil\"\nversion = \"9", &tracers),
            ("Cargo.lock", "name = \"pulldown-cmark\"\nversion = \"", "name = \"pulldown-cmark\"\nversion = \"9", ""),
        ] {
            let then = changed(file, from, to);
            let found: Vec<&str> = all.iter().copied().filter(|name| now[*name] != then[*name]).collect();
            assert_eq!(found.join(" "), stale, "{file}: {from}");
        }
    }
}
