//! Quantities that decide claims: what a paper's data says is told of a run, by name.

use std::collections::BTreeMap;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use super::Paper;
use super::estimate::Estimate;
use super::evaluate::{Evaluation, Value};
use super::expression::Expression;
use super::rows::{Rows, SceneRows};

/// A quantity of one scene: the scene, and its value.
pub type OfScene = (String, Estimate);

/// Variables that hold what a function takes, and what it is.
pub(super) type Function = (Vec<String>, Expression);

/// What a paper's `quantities.json` tells.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Told {
    /// A paper whose functions it takes, too.
    pub takes_from: Option<String>,
    /// By name, from `share(row, rays)`.
    #[serde(deserialize_with = "functions")]
    pub functions: BTreeMap<String, Function>,
    pub quantities: Vec<Quantity>,
}

fn functions<'de, D: Deserializer<'de>>(told: D) -> Result<BTreeMap<String, Function>, D::Error> {
    let function = |(head, is): (String, Expression)| {
        let parts = head.split_once('(').and_then(|(name, rest)| Some((name, rest.strip_suffix(')')?)));
        let (name, rest) =
            parts.ok_or_else(|| D::Error::custom(format!("{head} is no function with what it takes")))?;
        let arguments = rest.split(',').map(|name| format!("${}", name.trim())).collect();
        Ok((name.to_owned(), (arguments, is)))
    };
    BTreeMap::<String, Expression>::deserialize(told)?.into_iter().map(function).collect()
}

/// A quantity.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// Stable name.
    pub name: String,
    /// What it is, in words.
    pub what: String,
    /// Its unit, empty for a ratio or share.
    #[serde(default)]
    pub unit: String,
    /// Whether it is of all scenes together.
    #[serde(default)]
    of_all_scenes: bool,
    is: Expression,
}

impl Quantity {
    /// Its values in a run, for the paper that it is of; none where the run lacks the rows. What is no number is none.
    pub fn values(&self, paper: &Paper, rows: &Rows<'_>) -> Vec<OfScene> {
        let of = |label: &str, scene: &SceneRows<'_>| {
            let found = Evaluation::new(paper, &rows.scenes, scene).value(&self.is)?;
            let found = if let Value::Number(found) = found { found } else { return None };
            found.value.is_finite().then(|| (label.to_owned(), found))
        };
        match rows.scenes.first() {
            Some(first) if self.of_all_scenes => of("all scenes", first).into_iter().collect(),
            _ => rows.scenes.iter().filter_map(|scene| of(&scene.label, scene)).collect(),
        }
    }
}

/// Kendall's rank correlation of numbers and what they rank, from -1 (one falls as the other rises) to 1; pairs that are equal in one
/// count as neither. `order` tells [`sign`] of what two differ by. None below three, which have no order to speak of.
pub(super) fn rank_correlation<T>(points: &[(f64, T)], order: impl Fn(&T, &T) -> Option<Estimate>) -> Option<Estimate> {
    let mut sum = Estimate::from(0.0);
    let mut compared = 0_u32;
    for (index, (one, ranked)) in points.iter().enumerate() {
        for (other, beside) in &points[..index] {
            sum = sum + order(ranked, beside)? * sign(one - other);
            compared += 1;
        }
    }
    (points.len() > 2).then(|| sum / f64::from(compared))
}

/// 1, -1, or 0 of 0.
pub(super) fn sign(difference: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference.signum() }
}

/// How often a rank correlation of so many pairs is as strong as this, either way, where the one says nothing of the other: exact, by
/// counting the orders with as many pairs out of order.
pub(super) fn rank_chance(count: usize, rank: f64) -> f64 {
    // Shares of the orders, by their pairs out of order: who is placed next may be so with none up to all before.
    let shares = (1..count).fold(vec![1.0], |shares, placed| {
        let share = |pairs: usize| shares.iter().take(pairs + 1).skip(pairs.saturating_sub(placed)).sum::<f64>();
        (0..shares.len() + placed).map(|pairs| share(pairs) / (placed + 1) as f64).collect()
    });
    let most = (shares.len() - 1) as f64;
    let strong = |pairs: usize| most * rank.abs() <= (most - 2.0 * pairs as f64).abs() + 1e-9;
    shares.iter().enumerate().filter(|(pairs, _)| strong(*pairs)).map(|(_, share)| share).sum()
}
