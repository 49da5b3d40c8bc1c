//! What indices, counts and enumerations must be. What breaks a rule is told with its JSON path, its value and the rule.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use gltf::json::Value;

use super::strip::{is_influence, items};

/// What a value must be.
#[derive(Clone, Copy)]
pub(super) enum Rule {
    /// The index of an element of a list of the document.
    Index(&'static str),
    /// A whole number in a range.
    Within(u64, u64),
    /// One of some numbers.
    OneOf(&'static [u64]),
    /// One of some words.
    Word(&'static [&'static str]),
}

/// The rules by the key that values stand at. Keys that mean nothing to this import are stripped before.
const RULES: &[(&str, Rule)] = &[
    ("POSITION", Rule::Index("accessors")),
    ("buffer", Rule::Index("buffers")),
    ("bufferView", Rule::Index("bufferViews")),
    ("byteLength", Rule::Within(0, u64::MAX)),
    ("byteOffset", Rule::Within(0, u64::MAX)),
    ("byteStride", Rule::Within(4, 252)),
    ("camera", Rule::Index("cameras")),
    ("children", Rule::Index("nodes")),
    ("componentType", Rule::OneOf(&[5120, 5121, 5122, 5123, 5125, 5126])),
    ("count", Rule::Within(0, u64::MAX)),
    ("indices", Rule::Index("accessors")),
    ("input", Rule::Index("accessors")),
    ("interpolation", Rule::Word(&["LINEAR", "STEP", "CUBICSPLINE"])),
    ("inverseBindMatrices", Rule::Index("accessors")),
    ("joints", Rule::Index("nodes")),
    ("material", Rule::Index("materials")),
    ("mesh", Rule::Index("meshes")),
    ("mode", Rule::OneOf(&[0, 1, 2, 3, 4, 5, 6])),
    ("node", Rule::Index("nodes")),
    ("nodes", Rule::Index("nodes")),
    ("output", Rule::Index("accessors")),
    ("sampler", Rule::Index(SAMPLERS)),
    ("scene", Rule::Index("scenes")),
    ("skin", Rule::Index("skins")),
    ("type", Rule::Word(&["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"])),
];

/// The samplers of the animation that plays.
const SAMPLERS: &str = "animations[0].samplers";

/// The rule for values at `key`.
pub(super) fn rule(key: &str) -> Option<Rule> {
    let found = RULES.binary_search_by_key(&key, |(key, _)| key).ok().map(|at| RULES[at].1);
    found.or_else(|| is_influence(key).then_some(Rule::Index("accessors")))
}

/// A whole number, however it is written: some exporters write 3 as 3.0.
pub(super) fn whole(value: &Value) -> Option<u64> {
    let exact = |number: f64| number.fract() == 0.0 && (0.0..9e15).contains(&number);
    value.as_u64().or_else(|| value.as_f64().filter(|number| exact(*number)).map(|number| number as u64))
}

/// Checks every value that has a rule, and writes whole numbers as such. The JSON parser bounds the depth.
pub(super) fn check(document: &mut Value) -> Result<(), String> {
    let mut lengths = BTreeMap::from([(SAMPLERS.to_owned(), 0)]);
    for animation in items(document, "animations") {
        lengths.insert(SAMPLERS.to_owned(), items(animation, "samplers").count());
    }
    for (name, list) in document.as_object().into_iter().flatten() {
        lengths.insert(name.clone(), list.as_array().map_or(0, Vec::len));
    }
    check_value(document, "", &mut String::new(), &lengths)
}

fn check_value(
    value: &mut Value,
    key: &str,
    path: &mut String,
    lengths: &BTreeMap<String, usize>,
) -> Result<(), String> {
    let end = path.len();
    match value {
        Value::Array(values) => {
            for (index, value) in values.iter_mut().enumerate() {
                let _ = write!(path, "[{index}]");
                check_value(value, key, path, lengths)?;
                path.truncate(end);
            }
        }
        Value::Object(object) => {
            for (key, value) in object.iter_mut() {
                let _ = write!(path, "{}{key}", if end > 0 { "." } else { "" });
                check_value(value, key, path, lengths)?;
                path.truncate(end);
            }
        }
        Value::Number(_) | Value::String(_) => {
            if let Some(rule) = rule(key) {
                rule.check(value, lengths)
                    .map_err(|rule| format!("{path} is {}, and {rule}; export the file again", shown(value)))?;
            }
        }
        // The schema tells whether these are allowed.
        Value::Null | Value::Bool(_) => {}
    }
    Ok(())
}

impl Rule {
    fn check(self, value: &mut Value, lengths: &BTreeMap<String, usize>) -> Result<(), String> {
        let number = whole(value);
        let (fits, words) = match self {
            Self::Index(list) => {
                let count = lengths.get(list).copied().unwrap_or(0);
                let words = format!("must be an index into {list}, of which there are {count}");
                (number.is_some_and(|number| number < count as u64), words)
            }
            Self::Within(low, high) => (
                number.is_some_and(|it| (low..=high).contains(&it)),
                format!("must be a whole number from {low} to {high}"),
            ),
            Self::OneOf(known) => (number.is_some_and(|it| known.contains(&it)), format!("must be one of {known:?}")),
            Self::Word(known) => {
                (value.as_str().is_some_and(|it| known.contains(&it)), format!("must be one of {known:?}"))
            }
        };
        if let (true, Some(number)) = (fits, number) {
            *value = number.into();
        }
        fits.then_some(()).ok_or(words)
    }
}

/// A value as JSON, cut off where it is long.
pub(super) fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table is searched by halves.
    #[test]
    fn rules_are_sorted() {
        assert!(RULES.is_sorted_by_key(|(key, _)| key));
        assert!(rule("mode").is_some() && rule("WEIGHTS_1").is_some() && rule("weights").is_none());
    }
}
