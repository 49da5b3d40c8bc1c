//! What a folder of shaders says of itself: `variants.txt` lists its shaders and how each may be composed, and every other
//! WGSL file in it is a module that others import.

use std::collections::BTreeSet;

/// A shader's file with the ways in which it is composed.
#[derive(Debug, PartialEq, Eq)]
pub struct Listed {
    /// The file's name without `.wgsl`.
    pub stem: String,
    /// One a line.
    pub cases: Vec<Case>,
}

/// A line: definitions that are always switched on, those that may be, and those that are chosen where a pipeline is made.
#[derive(Debug, PartialEq, Eq)]
pub struct Case {
    pub always: Vec<String>,
    pub optional: Vec<String>,
    /// A shader has an `override` of that name.
    pub late: Vec<String>,
}

impl Case {
    /// What may be switched on.
    pub fn free(&self) -> impl Iterator<Item = &String> {
        self.optional.iter().chain(&self.late)
    }

    /// Every choice of these: whether each is switched on, the last changing fastest.
    pub fn choices(&self) -> Vec<Vec<bool>> {
        let count = self.free().count();
        (0..1_usize << count).map(|bits| (0..count).rev().map(|place| bits >> place & 1 == 1).collect()).collect()
    }

    /// The definitions that a shader is composed with for a choice.
    pub fn definitions(&self, choice: &[bool]) -> Vec<String> {
        let chosen = self.optional.iter().zip(choice).filter(|(_, is)| **is).map(|(name, _)| name);
        self.always.iter().chain(chosen).cloned().collect()
    }
}

/// Reads lines `FILE: ALWAYS ... [OPTIONAL] ... <LATE> ...`. A file may have several lines; `#` begins a comment.
pub fn read_list(text: &str) -> Result<Vec<Listed>, String> {
    let mut all: Vec<Listed> = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let (stem, case) = read_line(line).map_err(|error| format!("line {number}: {error}"))?;
        match all.iter_mut().find(|listed| listed.stem == stem) {
            Some(listed) => listed.cases.push(case),
            None => all.push(Listed { stem, cases: vec![case] }),
        }
    }
    for Listed { stem, cases } in &all {
        let mut seen = BTreeSet::new();
        let ways = cases.iter().flat_map(|case| {
            let ways: BTreeSet<_> = case.choices().iter().map(|way| case.definitions(way)).collect();
            ways
        });
        for definitions in ways {
            let set: BTreeSet<String> = definitions.iter().cloned().collect();
            if !seen.insert(set) {
                return Err(format!("{stem} with {definitions:?} is listed twice"));
            }
        }
    }
    Ok(all)
}

fn read_line(line: &str) -> Result<(String, Case), String> {
    let (stem, words) = line.split_once(':').ok_or_else(|| format!("'{line}' has no 'FILE:'"))?;
    let mut case = Case { always: Vec::new(), optional: Vec::new(), late: Vec::new() };
    let mut seen = BTreeSet::new();
    for word in words.split_whitespace() {
        let within = |begin, end| word.strip_prefix(begin).and_then(|rest: &str| rest.strip_suffix(end));
        let (name, list) = match (within('[', ']'), within('<', '>')) {
            (Some(name), _) => (name, &mut case.optional),
            (_, Some(name)) => (name, &mut case.late),
            _ => (word, &mut case.always),
        };
        let is_name = name.starts_with(|first: char| first.is_ascii_uppercase())
            && name.chars().all(|each| each.is_ascii_uppercase() || each.is_ascii_digit() || each == '_');
        if !is_name {
            return Err(format!("'{word}' is neither NAME nor [NAME] nor <NAME>"));
        }
        if !seen.insert(name) {
            return Err(format!("{name} stands there twice"));
        }
        list.push(name.to_owned());
    }
    Ok((stem.trim().to_owned(), case))
}

/// A WGSL file.
#[derive(Debug)]
pub struct Source {
    /// Its path below the folder of all shaders.
    pub file: String,
    pub text: String,
}

impl Source {
    /// The name by which others import a module; shaders have none.
    pub fn module_name(&self) -> Option<&str> {
        self.text.lines().find_map(|line| line.strip_prefix("#define_import_path ")).map(str::trim)
    }

    /// The modules that it imports from.
    fn imports(&self) -> impl Iterator<Item = &str> {
        self.text.lines().filter_map(|line| {
            let path = line.strip_prefix("#import ")?.trim();
            let end = path.find("::{").or_else(|| path.rfind("::"))?;
            Some(&path[..end])
        })
    }

    /// The definitions that it asks for, and those that it leaves to pipelines.
    pub fn asks_for(&self) -> impl Iterator<Item = &str> {
        let asked = |line: &str| line.starts_with("#if") || line.starts_with("#else if");
        self.text.lines().map(str::trim_start).filter_map(move |line| {
            let late = line.strip_prefix("override ").and_then(|rest| rest.strip_suffix(": bool;"));
            late.or_else(|| asked(line).then(|| line.split(' ').next_back())?)
        })
    }
}

/// The modules that a shader needs, each after those that it imports itself.
pub fn modules_of<'a>(shader: &Source, modules: &'a [Source]) -> Result<Vec<&'a Source>, String> {
    let mut ordered = Vec::new();
    add_imports(shader, modules, &mut Vec::new(), &mut ordered)?;
    Ok(ordered)
}

fn add_imports<'a>(
    source: &Source,
    modules: &'a [Source],
    path: &mut Vec<&'a str>,
    ordered: &mut Vec<&'a Source>,
) -> Result<(), String> {
    for name in source.imports() {
        let named = |module: &&Source| module.module_name() == Some(name);
        if ordered.iter().any(&named) {
            continue;
        }
        let Some(module) = modules.iter().find(named) else {
            let known: Vec<_> = modules.iter().filter_map(Source::module_name).collect();
            return Err(format!(
                "{} imports {name}, which no file defines; there are {}",
                source.file,
                known.join(", ")
            ));
        };
        if path.contains(&module.file.as_str()) {
            return Err(format!("{} imports itself by way of {}", module.file, path.join(", ")));
        }
        path.push(&module.file);
        add_imports(module, modules, path, ordered)?;
        path.pop();
        ordered.push(module);
    }
    Ok(())
}

/// Holds what a file is listed with against what it and its modules ask for.
pub fn check_definitions(listed: &Listed, shader: &Source, modules: &[&Source]) -> Result<(), String> {
    let asked: BTreeSet<&str> = std::iter::once(&shader).chain(modules).flat_map(|source| source.asks_for()).collect();
    let offered = listed.cases.iter().flat_map(|case| case.always.iter().chain(case.free()));
    let offered: BTreeSet<&str> = offered.map(String::as_str).collect();
    let (unasked, unlisted) = (offered.difference(&asked).next(), asked.difference(&offered).next());
    match (unasked, unlisted) {
        (Some(name), _) => Err(format!("{name} is listed, and the file asks for {asked:?} alone")),
        (None, Some(name)) => Err(format!("the file asks for {name}, and {offered:?} are listed alone")),
        (None, None) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(file: &str, text: &str) -> Source {
        Source { file: file.to_owned(), text: text.to_owned() }
    }

    /// A line gives every choice of what it brackets; lines of one file are joined.
    #[test]
    fn lines_give_their_choices() {
        let text = "# Of a tracer.\ntrace: [A] [B] # both\n\nstore:\ntrace: C D [B]\n";
        let listed = read_list(text).unwrap();
        assert_eq!(listed.iter().map(|each| each.stem.as_str()).collect::<Vec<_>>(), ["trace", "store"]);
        let ways = |listed: &Listed| -> Vec<String> {
            let cases = listed.cases.iter();
            cases
                .flat_map(|case| case.choices().iter().map(|way| case.definitions(way).concat()).collect::<Vec<_>>())
                .collect()
        };
        assert_eq!(ways(&listed[0]), ["", "B", "A", "AB", "CD", "CDB"]);
        assert_eq!(ways(&listed[1]), [""]);
        assert_eq!(read_list("").unwrap(), []);
        // What is chosen late takes no composing.
        let late = read_list("trace: [A] <B>").unwrap();
        assert_eq!(
            (ways(&late[0]), late[0].cases[0].choices().len()),
            (["", "", "A", "A"].map(str::to_owned).to_vec(), 4)
        );
    }

    /// What cannot be meant is refused, with its line.
    #[test]
    fn wrong_lists_are_refused() {
        for (text, error) in [
            ("store:\ntrace [A]", "line 2: 'trace [A]' has no 'FILE:'"),
            ("trace: [A", "line 1: '[A' is neither NAME nor [NAME] nor <NAME>"),
            ("trace: counted", "line 1: 'counted' is neither NAME nor [NAME] nor <NAME>"),
            ("trace: A [A]", "line 1: A stands there twice"),
            ("trace: [A] <A>", "line 1: A stands there twice"),
            ("trace: A <B>\ntrace: A", "trace with [\"A\"] is listed twice"),
            ("trace: [A] [B]\ntrace: B [C]", "trace with [\"B\"] is listed twice"),
        ] {
            assert_eq!(read_list(text).unwrap_err(), error);
        }
    }

    /// Modules come after those that they import, and only those that are needed; an unknown one and a circle are refused.
    #[test]
    fn modules_come_in_order_of_dependence() {
        let module = |name: &str, imports: &[&str]| {
            let imports: String = imports.iter().map(|name| format!("#import {name}::item\n")).collect();
            source(&format!("{name}.wgsl"), &format!("#define_import_path {name}\n{imports}"))
        };
        let modules = [module("a", &["b", "c"]), module("b", &["c"]), module("c", &[]), module("d", &["a"])];
        let of = |imports: &str, modules: &[Source]| {
            let found = modules_of(&source("shader.wgsl", imports), modules)?;
            Ok(found.iter().map(|each| each.file.clone()).collect::<Vec<_>>().join(" "))
        };
        assert_eq!(of("#import a::{x, y}", &modules).unwrap(), "c.wgsl b.wgsl a.wgsl");
        assert_eq!(of("#import b::x\n#import c::y", &modules).unwrap(), "c.wgsl b.wgsl");
        assert_eq!(of("", &modules).unwrap(), "");
        let unknown: String = of("#import e::x", &modules).unwrap_err();
        assert_eq!(unknown, "shader.wgsl imports e, which no file defines; there are a, b, c, d");
        let circle = [module("a", &["b"]), module("b", &["a"])];
        assert_eq!(of("#import a::x", &circle).unwrap_err(), "a.wgsl imports itself by way of a.wgsl, b.wgsl");
    }

    /// A definition that nothing asks for is noticed, and one that is asked for and not listed.
    #[test]
    fn definitions_are_those_that_are_asked_for() {
        let listed = &read_list("trace: A [B]").unwrap()[0];
        let module = source("m.wgsl", "#define_import_path m\n    #ifndef B");
        let check = |text: &str, modules: &[&Source]| check_definitions(listed, &source("trace.wgsl", text), modules);
        check("#ifdef A\n#else\n#ifdef B", &[]).unwrap();
        check("#ifdef A", &[&module]).unwrap();
        assert_eq!(check("#ifdef A", &[]).unwrap_err(), "B is listed, and the file asks for {\"A\"} alone");
        check("#ifdef A\noverride B: bool;", &[]).unwrap();
        let unlisted = check("#ifdef A\n#else ifdef B\n#ifdef AA", &[]).unwrap_err();
        assert_eq!(unlisted, "the file asks for AA, and {\"A\", \"B\"} are listed alone");
    }
}
