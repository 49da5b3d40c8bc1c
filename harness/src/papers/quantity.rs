//! Quantities that decide claims: functions of a run, by name.

use super::estimate::Estimate;
use super::rows::{Rows, SceneRows};

/// Of what a quantity is a value.
#[derive(Clone, Copy, Debug)]
pub enum Measure {
    /// Of every scene that has the rows for it, counted.
    Scene(OfOne<f64>),
    /// The same with what it is of, where that is one of several rows.
    NamedScene(OfOne<(String, f64)>),
    /// Of all scenes together, counted.
    Scenes(OfAll<f64>),
    /// Of every scene that has the rows for it, timed.
    TimedScene(OfOne<Estimate>),
    /// Of all scenes together, timed.
    TimedScenes(OfAll<Estimate>),
}

type OfOne<T> = fn(&SceneRows<'_>) -> Option<T>;
type OfAll<T> = fn(&[SceneRows<'_>]) -> Option<T>;

/// A quantity of one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct OfScene {
    /// The scene.
    pub scene: String,
    /// Its value.
    pub found: Estimate,
}

/// A quantity.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Stable name.
    pub name: &'static str,
    /// Its unit, empty for a ratio or share.
    pub unit: &'static str,
    /// How it is measured.
    pub measure: Measure,
}

impl Quantity {
    /// Its values in a run; none where the run lacks the rows. What is no number is none.
    pub fn values(&self, rows: &Rows<'_>) -> Vec<OfScene> {
        let of = |scene: &str, found: Estimate| OfScene { scene: scene.to_owned(), found };
        let each = |value: &dyn Fn(&SceneRows<'_>) -> Option<Estimate>| -> Vec<OfScene> {
            rows.scenes.iter().filter_map(|scene| Some(of(&scene.label, value(scene)?))).collect()
        };
        let all = |found: Option<Estimate>| found.map(|found| of("all scenes", found)).into_iter().collect();
        let found: Vec<OfScene> = match self.measure {
            Measure::Scene(value) => each(&|scene| value(scene).map(Estimate::from)),
            Measure::NamedScene(value) => {
                let named = |scene: &SceneRows<'_>| {
                    value(scene).map(|(name, value)| of(&format!("{} ({name})", scene.label), value.into()))
                };
                rows.scenes.iter().filter_map(named).collect()
            }
            Measure::TimedScene(value) => each(&value),
            Measure::Scenes(value) => all(value(&rows.scenes).map(Estimate::from)),
            Measure::TimedScenes(value) => all(value(&rows.scenes)),
        };
        found.into_iter().filter(|each| each.found.value.is_finite()).collect()
    }
}

pub(super) const fn of_scene(name: &'static str, unit: &'static str, of: OfOne<f64>) -> Quantity {
    Quantity { name, unit, measure: Measure::Scene(of) }
}

pub(super) const fn of_named_scene(name: &'static str, unit: &'static str, of: OfOne<(String, f64)>) -> Quantity {
    Quantity { name, unit, measure: Measure::NamedScene(of) }
}

pub(super) const fn of_scenes(name: &'static str, unit: &'static str, of: OfAll<f64>) -> Quantity {
    Quantity { name, unit, measure: Measure::Scenes(of) }
}

pub(super) const fn timed_of_scene(name: &'static str, unit: &'static str, of: OfOne<Estimate>) -> Quantity {
    Quantity { name, unit, measure: Measure::TimedScene(of) }
}

pub(super) const fn timed_of_scenes(name: &'static str, unit: &'static str, of: OfAll<Estimate>) -> Quantity {
    Quantity { name, unit, measure: Measure::TimedScenes(of) }
}

pub(super) const PERCENT: &str = "%";
pub(super) const IN_A_MILLION: &str = "rays in a million";

/// The larger of values, none of none.
pub(super) fn greatest(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().reduce(f64::max)
}

/// The least of values, none of none.
pub(super) fn least(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().reduce(f64::min)
}

/// The mean of values, none of none.
pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Of ratios that which lies farthest from 1, none of none.
pub(super) fn farthest_from_one(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().max_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs()))
}

/// Kendall's rank correlation of pairs, from -1 (one falls as the other rises) to 1; pairs that are equal in one count as
/// neither. None below three pairs, which have no order to speak of.
pub(super) fn rank_correlation(pairs: &[[f64; 2]]) -> Option<f64> {
    let mut sum = 0.0;
    let mut compared = 0_u32;
    for (index, one) in pairs.iter().enumerate() {
        for other in &pairs[..index] {
            let product = (one[0] - other[0]) * (one[1] - other[1]);
            sum += if product == 0.0 { 0.0 } else { product.signum() };
            compared += 1;
        }
    }
    (pairs.len() > 2).then(|| sum / f64::from(compared))
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
