//! Numbers and names as text.

use itertools::Itertools as _;
use serde::Serialize;
use tracebench_api::{ClockKind, Query};

use crate::results::Times;

/// What stands where there is no figure.
pub(crate) const NONE: &str = "–";

/// A number with about `digits` significant digits: plain where that is short, else with a power of ten.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor();
    if !(-3.0..6.0).contains(&magnitude) {
        return format!("{value:.0$e}", digits.saturating_sub(1));
    }
    let decimals = (digits as f64 - 1.0 - magnitude).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// A number or the sign for none.
pub(crate) fn optional(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| NONE.to_owned(), |value| significant(value, digits))
}

/// A value with its interval.
pub(crate) fn with_interval(value: f64, [low, high]: [f64; 2], digits: usize) -> String {
    format!("{} [{}, {}]", significant(value, digits), significant(low, digits), significant(high, digits))
}

/// A share in percent, with so many decimals that one ray of `trials` shows: nothing but 1 itself reads "100".
pub(crate) fn percent(share: f64, trials: u64) -> String {
    if !share.is_finite() {
        return NONE.to_owned();
    }
    if share == 1.0 || share == 0.0 {
        return format!("{:.0}", share * 100.0);
    }
    format!("{:.*}", percent_decimals(trials), share * 100.0)
}

fn percent_decimals(trials: u64) -> usize {
    ((trials.max(1) as f64).log10().ceil() - 2.0).max(2.0) as usize
}

/// A difference of shares in percentage points, with so many decimals that one ray of `trials` shows; the sign always.
pub(super) fn points(difference: f64, trials: u64) -> String {
    if !difference.is_finite() {
        return NONE.to_owned();
    }
    if difference == 0.0 {
        return "0".to_owned();
    }
    format!("{:+.*}", percent_decimals(trials), difference * 100.0)
}

/// A share with its interval, in percent.
pub(super) fn percent_with_interval(share: f64, interval: Option<[f64; 2]>, trials: u64) -> String {
    match interval {
        Some([low, high]) => {
            // One decimal more: the ends of an interval fall between whole rays.
            let decimals = percent_decimals(trials) + 1;
            let end = |share: f64| match share {
                0.0 | 1.0 => format!("{:.0}", share * 100.0),
                _ => format!("{:.decimals$}", share * 100.0),
            };
            format!("{} % [{}, {}]", percent(share, trials), end(low), end(high))
        }
        None => format!("{} %", percent(share, trials)),
    }
}

/// A count with commas between thousands.
pub(crate) fn thousands(count: u64) -> String {
    let digits = count.to_string();
    digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).join(",")
}

/// What a structure says of itself: a count with commas, or a number.
pub(crate) fn statistic(value: f64) -> String {
    if value.fract() == 0.0 && (0.0..1e15).contains(&value) { thousands(value as u64) } else { significant(value, 4) }
}

/// Bytes as MiB (2^20 bytes).
pub(crate) fn mib(bytes: u64) -> String {
    significant(bytes as f64 / f64::from(1 << 20), 4)
}

/// Edges of an image.
pub(super) fn size([width, height]: [u32; 2]) -> String {
    format!("{width}×{height}")
}

/// The same for programs, and where they are typed.
pub(crate) fn edges([width, height]: [u32; 2]) -> String {
    format!("{width}x{height}")
}

/// A clock's name.
pub(super) fn clock(clock: ClockKind) -> &'static str {
    match clock {
        ClockKind::Host => "host clock",
        ClockKind::DeviceTimestamps => "device timestamps",
        ClockKind::SubmitToDone => "submit to done, host clock",
    }
}

/// The clock of times, whether another was refused, and whether they are invalid.
pub(crate) fn clock_of(times: &Times) -> String {
    let refused = if times.timestamps_refused { " (timestamps not believed)" } else { "" };
    let invalid = if times.invalid.is_some() { " (**times invalid**)" } else { "" };
    format!("{}{refused}{invalid}", clock(times.clock))
}

/// What a name is called in `run.json`, and so in tables for programs.
pub(super) fn code(name: impl Serialize) -> String {
    serde_json::to_value(name).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// A query's name.
pub(crate) fn query(query: Query) -> &'static str {
    match query {
        Query::Closest => "closest hit",
        Query::Any => "any hit",
    }
}

/// The first digits of a hash, enough to tell hashes apart by eye.
pub(super) fn hash_prefix(hash: &str) -> String {
    hash.chars().take(8).collect()
}

/// A commit, short, with a mark if the tree had changes.
pub(super) fn commit(commit: &str, dirty: Option<bool>) -> String {
    let short: String = commit.chars().take(10).collect();
    match dirty {
        Some(true) => format!("{short} + changes"),
        _ => short,
    }
}

/// Text that is nothing but text, in elements and in attributes of HTML and SVG.
pub(super) fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c if c.is_control() && c != '\n' => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// Text made safe for a file's name: letters, digits, `_` and `-`; everything else becomes `_`.
pub(crate) fn file_stem(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '_' || c == '-' { c } else { '_' };
    let stem: String = name.chars().map(safe).take(80).collect();
    if stem.is_empty() { "scene".to_owned() } else { stem }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A single wrong ray always shows, and only perfection is written as 100.
    #[test]
    fn percentages_show_every_ray() {
        for trials in [3, 10, 99, 100, 101, 2048, 131_072, 10_000_000] {
            let share = (trials - 1) as f64 / trials as f64;
            let text = percent(share, trials);
            assert!(text.parse::<f64>().unwrap() < 100.0, "{text} of {trials}");
            assert_eq!(percent(1.0, trials), "100");
        }
        assert_eq!(percent(131_069.0 / 131_072.0, 131_072), "99.9977");
    }

    /// Plain and with powers of ten, never with a flood of digits.
    #[test]
    fn numbers_are_short() {
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(12.3456, 4), "12.35");
        assert_eq!(significant(123_456.0, 3), "123456");
        assert_eq!(significant(1.234e-7, 3), "1.23e-7");
        assert_eq!(significant(f64::NAN, 3), NONE);
        assert_eq!(thousands(1_234_567), "1,234,567");
        assert_eq!(thousands(12), "12");
        assert_eq!(mib(3 << 20), "3.000");
        assert_eq!(file_stem("a b/../c"), "a_b____c");
    }
}
