//! One value: `[least|greatest|median|mean|sum|count|interval] PATH [over PATH] as FORMAT`.

use serde_json::Value;

use super::source::Sources;
use crate::report::format::{significant, thousands};
use crate::statistics::{median, median_interval};

/// Makes one number of several.
type Reduction = fn(&[f64]) -> f64;

/// Reductions by name.
const REDUCTIONS: [(&str, Reduction); 5] = [
    ("least", |all| all.iter().copied().fold(f64::INFINITY, f64::min)),
    ("greatest", |all| all.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
    ("median", median),
    ("mean", |all| all.iter().sum::<f64>() / all.len() as f64),
    ("sum", |all| all.iter().sum()),
];

/// The text of a marker's words.
pub(super) fn value(words: &str, sources: &mut Sources) -> Result<String, String> {
    let (what, format) = words.rsplit_once(" as ").ok_or("the marker has no 'as FORMAT'")?;
    let no_format = || format!("'{format}' is no format: DECIMALS, DECIMALS%, DIGITSs, n or text");
    if let Some(path) = what.strip_prefix("count ") {
        return formatted(at(path, sources)?.len() as f64, format).ok_or_else(no_format);
    }
    let with_interval = what.strip_prefix("interval ");
    let what = with_interval.unwrap_or(what);
    let reduction = REDUCTIONS.iter().find_map(|(name, of)| Some((what.strip_prefix(name)?.strip_prefix(' ')?, of)));
    let (what, reduce) = reduction.map_or((what, None), |(what, of)| (what, Some(of)));
    let (path, over) = what.split_once(" over ").map_or((what, None), |(path, over)| (path, Some(over)));
    let found = at(path, sources)?;
    if format == "text" {
        return match (found.as_slice(), reduce, over) {
            ([one], None, None) => Ok(one.as_str().map_or_else(|| one.to_string(), str::to_owned)),
            _ => Err(format!("{path}: text is of one value, without 'over'")),
        };
    }
    let numbers = match over {
        None => numbers(path, &found)?,
        Some(over) => {
            let others = at(over, sources)?;
            if others.len() != found.len() && others.len() != 1 {
                return Err(format!("{} values over {}", found.len(), others.len()));
            }
            let pairs = found.iter().zip(others.iter().cycle());
            pairs.map(|(one, other)| ratio((path, one), (over, other))).collect::<Result<_, _>>()?
        }
    };
    if with_interval.is_some() {
        let ([low, high], _) = median_interval(&numbers);
        let [median, low, high] = [median(&numbers), low, high].map(|number| formatted(number, format));
        let text = median.zip(low).zip(high).map(|((median, low), high)| format!("{median} ({low} to {high})"));
        return text.ok_or_else(no_format);
    }
    let number = match (reduce, numbers.as_slice()) {
        (Some(reduce), _) => reduce(&numbers),
        (None, [number]) => *number,
        (None, all) => return Err(format!("{path} has {} values: say which, or least, greatest, median", all.len())),
    };
    if !number.is_finite() {
        return Err(format!("{path} is {number}"));
    }
    formatted(number, format).ok_or_else(no_format)
}

/// One value over another; of two lists, which are samples of the same rounds, the median of the ratios of their elements.
fn ratio((path, one): (&str, &Value), (over, other): (&str, &Value)) -> Result<f64, String> {
    let (Value::Array(one), Value::Array(other)) = (one, other) else {
        return Ok(numbers(path, std::slice::from_ref(one))?[0] / numbers(over, std::slice::from_ref(other))?[0]);
    };
    if one.len() != other.len() {
        return Err(format!("{path} has {} samples, {over} {}: they are of different rounds", one.len(), other.len()));
    }
    let (one, other) = (numbers(path, one)?, numbers(over, other)?);
    Ok(median(&one.iter().zip(other).map(|(one, other)| one / other).collect::<Vec<_>>()))
}

/// `2`: decimals; `1%`: decimals of a share in percent; `3s`: significant digits; `n`: a whole number with its thousands set apart.
fn formatted(number: f64, format: &str) -> Option<String> {
    // No -0.
    let number = number + 0.0;
    let plain = |number: f64, decimals: usize| {
        let text = format!("{number:.decimals$}");
        if text.trim_start_matches('-').chars().all(|digit| ['0', '.'].contains(&digit)) {
            text.replace('-', "")
        } else {
            text
        }
    };
    match format {
        "n" => (number >= 0.0).then(|| thousands(number.round() as u64)),
        _ => match format.strip_suffix('%') {
            Some(decimals) => Some(format!("{} %", plain(100.0 * number, decimals.parse().ok()?))),
            None => match format.strip_suffix('s') {
                Some(digits) => Some(significant(number, digits.parse().ok()?)),
                None => Some(plain(number, format.parse().ok()?)),
            },
        },
    }
}

/// Numbers, of cells of pages their first one: shares of what has a percent sign behind it.
fn numbers(path: &str, found: &[Value]) -> Result<Vec<f64>, String> {
    let number = |value: &Value| match value {
        Value::Number(number) => number.as_f64(),
        Value::String(text) => of_cell(text),
        _ => None,
    };
    found.iter().map(|value| number(value).ok_or_else(|| format!("{path}: {value} is no number"))).collect()
}

fn of_cell(text: &str) -> Option<f64> {
    let text = text.trim_start_matches('*');
    let end = text.find(|mark: char| !(mark.is_ascii_digit() || ".,-+".contains(mark))).unwrap_or(text.len());
    let number: f64 = text[..end].replace(',', "").parse().ok()?;
    Some(if text[end..].trim_start().starts_with('%') { number / 100.0 } else { number })
}

/// What stands at `FILE#SEGMENT/SEGMENT/...`.
fn at(path: &str, sources: &mut Sources) -> Result<Vec<Value>, String> {
    let (file, fields) = path.split_once('#').ok_or_else(|| format!("'{path}' is not FILE#FIELD/FIELD"))?;
    let mut found = vec![sources.file(file)?];
    for segment in segments(fields) {
        let next: Vec<&Value> = found.into_iter().flat_map(|value| step(value, segment)).collect();
        if next.is_empty() {
            return Err(format!("{file} has no '{segment}' of '{fields}'"));
        }
        found = next;
    }
    Ok(found.into_iter().cloned().collect())
}

/// Segments between slashes that stand in no brackets.
fn segments(fields: &str) -> Vec<&str> {
    let (mut segments, mut begin, mut depth) = (Vec::new(), 0, 0_u32);
    for (at, mark) in fields.char_indices() {
        match mark {
            '[' => depth += 1,
            ']' => depth = depth.saturating_sub(1),
            '/' if depth == 0 => {
                segments.push(&fields[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    segments.push(&fields[begin..]);
    segments
}

/// One step down: a key, a place, `*` for all, `[KEY.KEY=VALUE,...]` for all that have these values.
fn step<'a>(value: &'a Value, segment: &str) -> Vec<&'a Value> {
    let all = || -> Vec<&'a Value> {
        match value {
            Value::Array(values) => values.iter().collect(),
            Value::Object(values) => values.values().collect(),
            _ => Vec::new(),
        }
    };
    if segment == "*" {
        return all();
    }
    if let Some(conditions) = segment.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
        let holds = |of: &Value, condition: &str| {
            let Some((key, wanted)) = condition.split_once('=') else { return false };
            // A key of its own may have dots in it, as a column of a page.
            let found = of.get(key).or_else(|| key.split('.').try_fold(of, |of, key| step(of, key).pop()));
            found.is_some_and(|found| match found {
                Value::String(text) => text == wanted,
                Value::Number(number) => wanted.parse().is_ok_and(|wanted: f64| number.as_f64() == Some(wanted)),
                Value::Bool(is) => wanted.parse() == Ok(*is),
                _ => false,
            })
        };
        return all().into_iter().filter(|of| conditions.split(',').all(|condition| holds(of, condition))).collect();
    }
    match value {
        Value::Array(values) => segment.parse::<usize>().ok().and_then(|place| values.get(place)).into_iter().collect(),
        _ => value.get(segment).into_iter().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sources() -> (tempfile::TempDir, Sources) {
        let folder = tempfile::TempDir::new().unwrap();
        let record = r#"{ "rows": [
            { "tracer": { "name": "a", "buckets": 4 }, "ms": 10.0, "of": [3, 7], "label": "first" },
            { "tracer": { "name": "a", "buckets": 8 }, "ms": 30.0, "label": "second" },
            { "tracer": { "name": "b" }, "ms": 5.0, "label": "x/y" } ],
            "of_rounds": [2, 4, 6, 8, 10, 12, 14], "other_rounds": [1, 2, 3, 4, 5, 6, 70], "big": 1234567.4, "least": -0.0001 }"#;
        std::fs::write(folder.path().join("r.json"), record).unwrap();
        let page = "# P\n\n| rays | share |\n| --- | --- |\n| diffuse | **33.25 % [30, 40]** |\n| ao | 1,234 (2 %) |\n";
        std::fs::write(folder.path().join("p.md"), page).unwrap();
        let sources = Sources::new(folder.path());
        (folder, sources)
    }

    /// Fields are found by key, place and value; several are made one by what is said, elementwise over others; formats round.
    #[test]
    fn values_are_found_and_formatted() {
        let (_folder, mut sources) = sources();
        for (words, expected) in [
            ("r.json#rows/1/ms as 0", "30"),
            ("r.json#rows/[tracer.name=a,tracer.buckets=8]/ms as 1", "30.0"),
            ("r.json#rows/[label=x/y]/label as text", "x/y"),
            ("r.json#rows/[of.1=7]/label as text", "first"),
            ("least r.json#rows/*/ms as 0", "5"),
            ("greatest r.json#rows/[tracer.name=a]/ms over r.json#rows/[tracer.name=b]/ms as 2", "6.00"),
            ("sum r.json#rows/*/ms as 0", "45"),
            ("count r.json#rows/* as 0", "3"),
            ("mean r.json#rows/[tracer.name=a]/ms as 0", "20"),
            // Of seven, the least and the greatest cover the median with 98 %.
            ("interval r.json#of_rounds/* as 1", "8.0 (2.0 to 14.0)"),
            ("r.json#of_rounds over r.json#other_rounds as 1", "2.0"),
            ("interval r.json#of_rounds/* over r.json#other_rounds/* as 1", "2.0 (0.2 to 2.0)"),
            ("r.json#rows/2/ms over r.json#rows/0/ms as 0%", "50 %"),
            ("r.json#big as n", "1,234,567"),
            ("r.json#rows/0/ms as 3s", "10.0"),
            ("r.json#least as 2", "0.00"),
            ("p.md#[heading=P]/rows/[rays=diffuse]/share as 1%", "33.2 %"),
            ("p.md#0/rows/[rays=ao]/share as 0", "1234"),
        ] {
            assert_eq!(value(words, &mut sources).as_deref(), Ok(expected), "{words}");
        }
        for words in [
            "r.json#rows/*/ms over r.json#rows/[tracer.name=a]/ms as 0",
            "r.json#rows/*/label as text",
            "r.json#rows as 0",
            "r.json#of_rounds over r.json#rows as 0",
        ] {
            assert!(value(words, &mut sources).is_err(), "{words}");
        }
    }
}
