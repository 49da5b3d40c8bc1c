//! The Rust source by which host code looks shaders up: a module a folder, and in it a static for a shader without
//! variants, a struct of flags for one whose flags are free, an enum for one with several lines. Every value of these types
//! is a variant that was composed, so that one that does not exist does not compile.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::list::{Case, Listed};
use crate::needs::EntryNeeds;
use crate::structs::{BoundStruct, module_of};

/// A variant as it was composed.
pub struct Composed {
    pub text: String,
    pub needs: Vec<EntryNeeds>,
    /// What is left to pipelines, by name and as the text calls it.
    pub overrides: Vec<(String, String)>,
    pub structs: Vec<BoundStruct>,
}

/// The table while it is written, with the files that it includes: their names and texts.
#[derive(Default)]
pub struct Table {
    pub files: Vec<(String, String)>,
    /// Entries of the list of all.
    all: String,
    /// Items of each module.
    modules: BTreeMap<String, String>,
    /// By module and name.
    structs: BTreeMap<[String; 2], BoundStruct>,
}

impl Table {
    /// Adds a folder with its shaders; `compose` makes the text of a file with some definitions.
    pub fn add_folder(
        &mut self,
        folder: &str,
        listed: &[Listed],
        mut compose: impl FnMut(&Listed, &[String]) -> Result<Composed, String>,
    ) -> Result<(), String> {
        let mut items = String::new();
        for each in listed {
            let file = format!("{folder}/{}.wgsl", each.stem);
            let mut arms = Vec::new();
            for case in &each.cases {
                let mut overrides = Vec::new();
                for choice in case.choices() {
                    let late = &choice[case.optional.len()..];
                    if late.contains(&true) {
                        let expression = shader(self.files.len() - 1, &switches(&overrides, late));
                        arms.push((pattern(each, case, &choice), expression));
                        continue;
                    }
                    let definitions = case.definitions(&choice);
                    let name = std::iter::once(format!("{folder}/{}", each.stem)).chain(definitions.iter().cloned());
                    let name = name.collect::<Vec<_>>().join(" ");
                    let composed = compose(each, &definitions).map_err(|error| format!("{name}: {error}"))?;
                    let Composed { text, needs, overrides: found, structs } = composed;
                    overrides = keys(case, &found).map_err(|error| format!("{name}: {error}"))?;
                    for each in structs {
                        let key = [module_of(&each.file), each.name.clone()];
                        let known = self.structs.entry(key).or_insert_with(|| each.clone());
                        if (&known.members, known.size) != (&each.members, each.size) {
                            return Err(format!("{name} lays {} out otherwise than {}", each.name, known.file));
                        }
                    }
                    let place = self.files.len();
                    let _ = writeln!(
                        self.all,
                        "Shader {{ name: {name:?}, file: {file:?}, source: include_str!(concat!(env!(\"OUT_DIR\"), \
                         \"/{place}.wgsl\")), entries: &[{}], switches: {} }},",
                        needs.iter().map(entry).collect::<String>(),
                        switches(&overrides, late)
                    );
                    self.files.push((format!("{place}.wgsl"), text));
                    arms.push((pattern(each, case, &choice), format!("super::ALL[{place}]")));
                }
            }
            items.push_str(&item(each, &file, &arms));
        }
        if !items.is_empty() {
            self.modules.insert(module_of(folder), items);
        }
        Ok(())
    }

    /// The source.
    pub fn source(&self) -> String {
        let mut modules = self.modules.clone();
        let mut structs = String::new();
        for ([module, _], each) in &self.structs {
            modules.entry(module.clone()).or_default().push_str(&each.item());
            structs.push_str(&each.listed());
        }
        let modules: String = modules
            .iter()
            .map(|(name, items)| {
                let allowed = "#[allow(unused_qualifications, reason = \"a struct's own module is named, too\")]";
                format!("/// Shaders of `{name}`, and what they bind.\n{allowed}\npub mod {name} {{\n{items}}}\n")
            })
            .collect();
        // A constant would put all texts into every part of the program that names one.
        format!(
            "/// Every variant.\npub static ALL: &[Shader] = &[\n{}];\n/// Every struct that shaders bind.\npub static STRUCTS: \
             &[BoundStruct] = &[\n{structs}];\n{modules}",
            self.all
        )
    }
}

/// What an entry point needs, as an expression.
fn entry(needs: &EntryNeeds) -> String {
    let EntryNeeds { name, storage_buffers, storage_textures, invocations } = needs;
    format!(
        "EntryPoint {{ name: {name:?}, storage_buffers: {storage_buffers}, storage_textures: {storage_textures}, invocations: \
         {invocations} }}, "
    )
}

/// What a text calls what a line leaves to pipelines, in the line's order.
fn keys(case: &Case, found: &[(String, String)]) -> Result<Vec<String>, String> {
    let key = |name: &String| found.iter().find(|(each, _)| each == name).map(|(_, key)| key.clone());
    let keys = case.late.iter().map(|name| key(name).ok_or_else(|| format!("it has no `override {name}: bool;`")));
    let unlisted = found.iter().find(|(name, _)| !case.late.contains(name));
    match unlisted {
        Some((name, _)) => Err(format!("<{name}> is not listed")),
        None => keys.collect(),
    }
}

/// What a pipeline is told of these, as an expression.
fn switches(keys: &[String], on: &[bool]) -> String {
    let each = keys.iter().zip(on).map(|(key, on)| format!("({key:?}, {}.0), ", u32::from(*on)));
    format!("&[{}]", each.collect::<String>())
}

/// A composed text with what pipelines are told, as an expression.
fn shader(place: usize, switches: &str) -> String {
    format!("super::Shader {{ switches: {switches}, ..super::ALL[{place}] }}")
}

/// The name of an item after a file, or of an enum's case after definitions.
fn camel(words: &str) -> String {
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..].to_lowercase();
    words.split('_').filter(|word| !word.is_empty()).map(capital).collect()
}

fn is_free(listed: &Listed) -> bool {
    matches!(listed.cases.as_slice(), [only] if only.always.is_empty())
}

/// What a line is called in its enum.
fn case_name(case: &Case) -> String {
    if case.always.is_empty() { "Plain".to_owned() } else { camel(&case.always.join("_")) }
}

/// A variant as a pattern and expression.
fn pattern(listed: &Listed, case: &Case, choice: &[bool]) -> String {
    let case_name = if is_free(listed) { String::new() } else { format!("::{}", case_name(case)) };
    let fields = case.free().zip(choice).map(|(name, is)| format!("{}: {is}", name.to_lowercase()));
    let fields = fields.collect::<Vec<_>>().join(", ");
    let fields = if fields.is_empty() { fields } else { format!(" {{ {fields} }}") };
    format!("{}{case_name}{fields}", camel(&listed.stem))
}

/// The item of a file; `arms` are its variants with the expressions that give them.
fn item(listed: &Listed, file: &str, arms: &[(String, String)]) -> String {
    if let [(_, shader)] = arms {
        let name = listed.stem.to_uppercase();
        return format!("/// `{file}`.\npub static {name}: super::Shader = {shader};\n");
    }
    let name = camel(&listed.stem);
    let fields = |case: &Case, public: &str| -> String {
        let field = |name: &String| format!("/// With `{name}`.\n{public}{}: bool,\n", name.to_lowercase());
        case.free().map(field).collect()
    };
    let body = if is_free(listed) {
        format!("pub struct {name} {{\n{}}}", fields(&listed.cases[0], "pub "))
    } else {
        let case = |case: &Case| {
            let fields = fields(case, "");
            let fields = if fields.is_empty() { fields } else { format!(" {{\n{fields}}}") };
            let with: Vec<String> = case.always.iter().map(|name| format!("`{name}`")).collect();
            let with = if with.is_empty() { "nothing always".to_owned() } else { with.join(" and ") };
            format!("/// With {with}.\n{}{fields},\n", case_name(case))
        };
        format!("pub enum {name} {{\n{}}}", listed.cases.iter().map(case).collect::<String>())
    };
    let all: String = arms.iter().map(|(pattern, _)| format!("{pattern}, ")).collect();
    let found: String = arms.iter().map(|(pattern, shader)| format!("{pattern} => {shader},\n")).collect();
    format!(
        "/// Variants of `{file}`.\n#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]\n{body}\nimpl \
         super::Variant for {name} {{\nconst ALL: &'static [Self] = &[{all}];\n}}\nimpl From<{name}> for super::Shader \
         {{\nfn from(variant: {name}) -> Self {{\nmatch variant {{\n{found}}}\n}}\n}}\n"
    )
}
