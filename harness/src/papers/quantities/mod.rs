//! Quantities that decide claims: functions of a run, by name.

mod abuffer;
mod accuracy;
mod memory;
mod time;

use super::rows::{Rows, SceneRows};
use super::verdict::SceneValue;
pub(crate) use abuffer::memory::{formula as abuffer_formula, ledger as abuffer_ledger};
pub(crate) use abuffer::search::{bounces, efficiency, layers, views};
pub(crate) use abuffer::{ABUFFER, counted, rays};
pub(crate) use memory::tiles;
pub(crate) use time::{MIXES, total_ms};

use abuffer::{beside_dirt, peers, search, variants};

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
    of_scene("memory_below_abuffer", PERCENT, beside_dirt::memory_below),
    of_scene("references_beyond_fragments", PERCENT, beside_dirt::references_beyond_fragments),
    of_scene("build_below_abuffer", PERCENT, beside_dirt::build_below),
    of_scene("trace_below_abuffer", PERCENT, beside_dirt::trace_below),
    of_scene("dirt_trace_over_abuffer", "", beside_dirt::trace_over),
    of_scenes("rank_of_saving_by_fragments", "", beside_dirt::rank_of_saving_by_fragments),
    of_scenes("dirt_bytes_over_abuffer_where_fewest", "", beside_dirt::bytes_over_abuffer_where_fewest),
    of_scene("fragments_false_misses_beyond_dirt", IN_A_MILLION, beside_dirt::false_misses_beyond_dirt),
    of_scene("thickness_closes_and_invents", IN_A_MILLION, beside_dirt::thickness_closes_and_invents),
    of_scene("froxels_gain_and_leave", IN_A_MILLION, beside_dirt::froxels_gain_and_leave),
    of_scene("skipping_gain", "", search::skipping_gain),
    of_scene("same_hits_without_skipping", "", search::same_hits_without_skipping),
    of_scenes("rank_of_time_by_efficiency", "", search::rank_of_time_by_efficiency),
    of_scenes("rank_of_build_by_fragments", "", search::rank_of_build_by_fragments),
    of_scene("layers_of_two_bounces_over_one", "", search::layers_of_two_bounces_over_one),
    of_scene("views_of_two_bounces_over_one", "", search::views_of_two_bounces_over_one),
    of_scene("two_bounces_over_one", "", search::two_bounces_over_one),
    of_scene("more_buckets_trace_where_deep", "", search::more_buckets_trace_where_deep),
    of_scene("more_buckets_cost", "", search::more_buckets_cost),
    of_scene("data_nodes_read", "", search::data_nodes_read),
    of_scene("abuffer_bytes_over_formula", "", abuffer::memory::bytes_over_formula),
    of_scene("largest_without_buckets_over_least_with", "", abuffer::memory::largest_without_buckets_over_least_with),
    of_scene("dllb_beyond_llb_over_links", "", abuffer::memory::dllb_beyond_llb_over_links),
    of_scene("dllb_pixel_bytes_over_textures", "", abuffer::memory::dllb_pixel_bytes_over_textures),
    of_scene("dllb_id_node_bytes", "bytes", abuffer::memory::dllb_id_node_bytes),
    of_scene("lbvh_build_over_abuffer", "", peers::lbvh_build_over_abuffer),
    of_scene("bvh_build_over_abuffer", "", peers::bvh_build_over_abuffer),
    of_scene("abuffer_trace_over_lbvh", "", peers::trace_over_lbvh),
    of_scene("abuffer_trace_over_bvh", "", peers::trace_over_bvh),
    of_scene("least_bvh_total_over_abuffer", "", peers::least_bvh_total_over_abuffer),
    of_scene("break_even_samples", "samples", peers::break_even_samples),
    of_scene("abuffer_footprint_agreement", "", peers::footprint_agreement),
    of_scene("decoupling_gain", PERCENT, variants::decoupling_gain),
    of_scene("skipping_gain_of_variants", PERCENT, variants::skipping_gain),
    of_scenes("skipping_speedup_evenness", "", variants::skipping_speedup_evenness),
    of_scene("decoupling_build_gain", PERCENT, variants::decoupling_build_gain),
    of_scene("slowest_build_over_fastest", "", variants::slowest_build_over_fastest),
    of_scene("bucketed_over_others", "", variants::bucketed_over_others),
    of_scene("dllb_over_fastest_other", "", variants::dllb_over_fastest_other),
    of_scene("covered_pixels_share", "", variants::covered_pixels_share),
    of_scene("seven_views_over_one", "", abuffer::views::seven_views_over_one),
    of_scene("all_layers_over_one", "", abuffer::views::all_layers_over_one),
    of_scene("one_view_false_misses_beyond", IN_A_MILLION, abuffer::views::one_view_false_misses_beyond),
    of_scene("one_layer_false_misses_beyond", IN_A_MILLION, abuffer::views::one_layer_false_misses_beyond),
    of_scene("steps_over_hi_z", "", abuffer::views::steps_over_hi_z),
    of_scene("sparse_steps_agreement_change", "", abuffer::views::sparse_steps_agreement_change),
    of_scene("half_resolution_agreement_change", "", abuffer::views::half_resolution_agreement_change),
    of_scene("resolution_exponent", "", abuffer::views::resolution_exponent),
    of_scene("off_view_rays_of_six_faces", IN_A_MILLION, abuffer::views::off_view_rays_of_six_faces),
    of_scene("fragments_beyond_centres_in_eye", PERCENT, abuffer::views::fragments_beyond_centres_in_eye),
    of_scene("bounds_of_boxes_over_geometry", "", abuffer::views::bounds_of_boxes_over_geometry),
    of_scene("camera_view_agreement_change", "", abuffer::views::camera_view_agreement_change),
    of_scene("camera_view_agreement_change_fine", "", abuffer::views::camera_view_agreement_change_fine),
    of_scene("views_asked_for_at_a_switch", "views", abuffer::views::views_asked_for_at_a_switch),
    of_scene("halving_above_16_over_best", "", abuffer::views::halving_above_16_over_best),
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

/// Of ratios that which lies farthest from 1, none of none.
fn farthest_from_one(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values.into_iter().max_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs()))
}

/// Kendall's rank correlation of pairs, from -1 (one falls as the other rises) to 1; pairs that are equal in one count as
/// neither. None below three pairs, which have no order to speak of.
fn rank_correlation(pairs: &[[f64; 2]]) -> Option<f64> {
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
