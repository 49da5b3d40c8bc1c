//! Quantities that decide claims: functions of a run, by name.

mod accuracy;
mod memory;
mod time;

use super::rows::{Rows, SceneRows};
use super::verdict::SceneValue;
pub(crate) use memory::tiles;
pub(crate) use time::{MIXES, total_ms};

/// Of what a quantity is a value.
#[derive(Clone, Copy)]
pub enum Measure {
    /// Of every scene that has the rows for it.
    Scene(fn(&SceneRows<'_>) -> Option<f64>),
    /// Of all scenes together.
    Scenes(fn(&[SceneRows<'_>]) -> Option<f64>),
}

/// A quantity.
#[derive(Clone, Copy)]
pub struct Quantity {
    /// Stable name.
    pub name: &'static str,
    /// Its unit, empty for a ratio or share.
    pub unit: &'static str,
    /// How it is had.
    pub measure: Measure,
}

impl Quantity {
    /// Its values in a run; none where the run lacks the rows. What is no number is none.
    pub fn values(&self, rows: &Rows<'_>) -> Vec<SceneValue> {
        let value = |scene: &str, value: f64| SceneValue { scene: scene.to_owned(), value };
        let found: Vec<SceneValue> = match self.measure {
            Measure::Scene(of) => {
                rows.scenes.iter().filter_map(|scene| Some(value(&scene.label, of(scene)?))).collect()
            }
            Measure::Scenes(of) => of(&rows.scenes).map(|found| value("all scenes", found)).into_iter().collect(),
        };
        found.into_iter().filter(|found| found.value.is_finite()).collect()
    }
}

const fn of_scene(name: &'static str, unit: &'static str, of: fn(&SceneRows<'_>) -> Option<f64>) -> Quantity {
    Quantity { name, unit, measure: Measure::Scene(of) }
}

const fn of_scenes(name: &'static str, unit: &'static str, of: fn(&[SceneRows<'_>]) -> Option<f64>) -> Quantity {
    Quantity { name, unit, measure: Measure::Scenes(of) }
}

const PERCENT: &str = "%";
const IN_A_MILLION: &str = "rays in a million";

/// Every quantity.
pub const QUANTITIES: &[Quantity] = &[
    of_scene("greatest_step_to_less_coherent", "", time::greatest_step_to_less_coherent),
    of_scene("visibility_over_fastest_other", "", time::visibility_over_fastest_other),
    of_scene("conservative_over_standard_trace", "", time::conservative_over_standard_trace),
    of_scene("build_growth_per_8_buckets", PERCENT, time::build_growth_per_8_buckets),
    of_scene("greatest_trace_ratio_of_8_buckets", "", time::greatest_trace_ratio_of_8_buckets),
    of_scene("coarse_tile_trace_ratio_where_low", "", time::coarse_tile_trace_ratio_where_low),
    of_scene("coarse_tile_gain_over_resolution_where_fine", "", time::coarse_tile_gain_over_resolution_where_fine),
    of_scene("trace_at_8_over_24_to_40", "", time::trace_at_8_over_24_to_40),
    of_scene("good_setting_over_best", "", time::good_setting_over_best),
    of_scene("second_event_over_first_closed", "", time::second_event_over_first_closed),
    of_scene("second_event_over_first_open", "", time::second_event_over_first_open),
    of_scene("least_bvh_build_over_dirt", "", time::least_bvh_build_over_dirt),
    of_scene("diffuse_slope_over_bvh", "", time::diffuse_slope_over_bvh),
    of_scene("total_gain_last_over_first", "", time::total_gain_last_over_first),
    of_scene("least_diffuse_time_over_bvh", "", time::least_diffuse_time_over_bvh),
    of_scene("one_view_time_over_six", "", time::one_view_time_over_six),
    of_scene("samples_saved_1_to_2", PERCENT, |scene| memory::saved(scene, ["1", "2"], memory::parts)),
    of_scene("samples_saved_2_to_4", PERCENT, |scene| memory::saved(scene, ["2", "4"], memory::parts)),
    of_scene("references_saved_1_to_2", PERCENT, |scene| memory::saved(scene, ["1", "2"], memory::references)),
    of_scene("references_saved_2_to_4", PERCENT, |scene| memory::saved(scene, ["2", "4"], memory::references)),
    of_scene("memory_saved_1_to_2", PERCENT, |scene| memory::saved(scene, ["1", "2"], memory::bytes)),
    of_scene("memory_saved_2_to_4", PERCENT, |scene| memory::saved(scene, ["2", "4"], memory::bytes)),
    of_scene("memory_growth_per_8_buckets_1", PERCENT, |scene| memory::growth_per_8_buckets(scene, "1")),
    of_scene("memory_growth_per_8_buckets_2", PERCENT, |scene| memory::growth_per_8_buckets(scene, "2")),
    of_scene("memory_growth_per_8_buckets_4", PERCENT, |scene| memory::growth_per_8_buckets(scene, "4")),
    of_scenes("memory_saving_spread", PERCENT, memory::saving_spread),
    of_scenes("memory_exponent_over_references", "", memory::exponent_over_references),
    of_scenes("bytes_a_reference", "bytes", memory::bytes_a_reference),
    of_scene("mipmap_factor", "", memory::mipmap_factor),
    of_scene("greatest_references_ratio_of_tiles", "", memory::greatest_references_ratio_of_tiles),
    of_scene("copies_at_40_over_8", "", memory::copies_at_40_over_8),
    of_scene("pyramid_steps_4_over_1", "", memory::pyramid_steps_4_over_1),
    of_scene("equation_1b_beyond_last_bucket", "buckets", memory::equation_1b_beyond_last_bucket),
    of_scene("validated_share", "", memory::validated_share),
    of_scene("least_tight_agreement", "", accuracy::least_tight_agreement),
    of_scene("standard_false_misses_beyond", IN_A_MILLION, accuracy::standard_false_misses_beyond),
    of_scene("coarse_tiles_agreement_change", IN_A_MILLION, accuracy::coarse_tiles_agreement_change),
    of_scene("early_stop_wrong_rays", IN_A_MILLION, accuracy::early_stop_wrong_rays),
    of_scene("tile_acceptance_false_misses", IN_A_MILLION, accuracy::tile_acceptance_false_misses),
    of_scene("one_view_agreement_change", "", accuracy::one_view_agreement_change),
    of_scene("one_layer_agreement_less_dirt", "", accuracy::one_layer_agreement_less_dirt),
];

/// Finds a quantity by name.
pub fn quantity(name: &str) -> Option<&'static Quantity> {
    QUANTITIES.iter().find(|quantity| quantity.name == name)
}

/// The larger of values, none of none.
fn greatest(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().reduce(f64::max)
}

/// The least of values, none of none.
fn least(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().reduce(f64::min)
}

/// The mean of values, none of none.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
