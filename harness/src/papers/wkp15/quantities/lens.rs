//! Table 4 and Figure 8: depth of field.

use super::peers::dda_time;
use super::{OTHER_LAYERS, UNCAPPED, share_behind_first};
use crate::papers::estimate::Estimate;
use crate::papers::quantity::{PERCENT, Quantity, greatest, of_scene, timed_of_scene};
use crate::papers::rows::{SceneRows, trace};
use crate::papers::times::{ratio, traced};
use crate::papers::wkp15::{DDA, QUADTREE, SAMPLES_A_RAY, one_and_two};
use crate::results::Row;

pub(super) const QUANTITIES: &[Quantity] = &[
    timed_of_scene("dda_lead_with_build_over_without", "", |scene| lead_with_build_over_without(scene, &[])),
    timed_of_scene("uncapped_dda_lead_with_build_over_without", "", |scene| {
        lead_with_build_over_without(scene, UNCAPPED)
    }),
    timed_of_scene("dda_lead_in_lens_over_stereo", "", |scene| lead_in_lens_over_stereo(scene, &[])),
    timed_of_scene("uncapped_dda_lead_in_lens_over_stereo", "", |scene| lead_in_lens_over_stereo(scene, UNCAPPED)),
    timed_of_scene("inpainted_lens_time_over_holes", "", inpainted_over_holes),
    timed_of_scene("three_more_samples_cost", PERCENT, three_more_samples_cost),
    timed_of_scene("rays_32_over_8", "", rays_32_over_8),
    timed_of_scene("half_the_rays_with_samples_save", PERCENT, half_the_rays_with_samples_save),
    of_scene("lens_rays_behind_first_layer", "", |scene| rays_behind_first_layer(scene, &[])),
    of_scene("lens_rays_behind_first_layer_separated", "", |scene| rays_behind_first_layer(scene, &[OTHER_LAYERS[0]])),
    of_scene("lens_rays_behind_first_layer_of_front_faces", "", |scene| {
        rays_behind_first_layer(scene, &[OTHER_LAYERS[1]])
    }),
];

const RAYS: &str = "lens";

/// The rows of so many rays a pixel: at the paper's own resolution, or at that of Figure 8's many.
fn of_count<'a>(scene: &SceneRows<'a>, count: &str, whole: bool) -> Option<SceneRows<'a>> {
    let mut found = scene.of_rays(&[("lens_count", count)]).by_resolution();
    // The last has the highest resolution.
    if whole { found.pop() } else { found.into_iter().next() }
}

/// Its tracer of so many layers and samples beside a ray.
fn with<'a>(scene: &SceneRows<'a>, layers: &str, samples: &str) -> Option<&'a Row> {
    scene.like_first(QUADTREE, &[("layers", layers), (SAMPLES_A_RAY, samples)])
}

/// Something of one layer and of two, the mean.
fn of_both(of: impl Fn(&str) -> Option<Estimate>) -> Option<Estimate> {
    Estimate::mean(["1", "2"].iter().map(|layers| of(layers)).collect::<Option<Vec<_>>>()?)
}

/// What DDA takes over what the trees take, with the build over the same without it; mean over rays a pixel and layers.
fn lead_with_build_over_without(scene: &SceneRows<'_>, steps: &[(&str, &str)]) -> Option<Estimate> {
    let mut leads = Vec::new();
    for count in ["4", "8"] {
        let scene = of_count(scene, count, true)?;
        for (own, peer) in one_and_two(&scene, QUADTREE, &[])?.into_iter().zip(one_and_two(&scene, DDA, steps)?) {
            leads.push(scene.total_ratio(peer, own, &[(RAYS, 1.0)])? / scene.trace_ratio(peer, own, RAYS)?);
        }
    }
    Estimate::mean(leads)
}

/// What DDA takes over what the trees take, of rays through the lens over the same of stereo rays; mean over rays a pixel and layers.
fn lead_in_lens_over_stereo(scene: &SceneRows<'_>, steps: &[(&str, &str)]) -> Option<Estimate> {
    let lead = |count: &str| {
        let scene = of_count(scene, count, true)?;
        Some(dda_time(&scene, RAYS, steps)? / dda_time(&scene, "stereo", steps)?)
    };
    Estimate::mean(["4", "8"].into_iter().map(lead).collect::<Option<Vec<_>>>()?)
}

/// Time in one layer that is inpainted over that in one whose holes stay, of eight rays a pixel.
fn inpainted_over_holes(scene: &SceneRows<'_>) -> Option<Estimate> {
    let scene = of_count(scene, "8", true)?;
    let holes = scene.like_first(QUADTREE, &[("layers", "1"), ("inpainting", "never")])?;
    scene.trace_ratio(with(&scene, "1", "0")?, holes, RAYS)
}

/// What three more samples a ray take beside eight rays a pixel alone, percent.
fn three_more_samples_cost(scene: &SceneRows<'_>) -> Option<Estimate> {
    let scene = of_count(scene, "8", true)?;
    of_both(|layers| scene.trace_ratio(with(&scene, layers, "3")?, with(&scene, layers, "0")?, RAYS))
        .map(Estimate::percent_beyond)
}

/// Time of 32 rays a pixel over that of 8.
fn rays_32_over_8(scene: &SceneRows<'_>) -> Option<Estimate> {
    let (many, few) = (of_count(scene, "32", false)?, of_count(scene, "8", false)?);
    let same_size = |one: &Row, other: &Row| one.viewpoint.ray_image == other.viewpoint.ray_image;
    of_both(|layers| {
        let (many, few) = (with(&many, layers, "0")?, with(&few, layers, "0")?);
        same_size(many, few).then(|| ratio(scene.record, &traced(many, RAYS)?, &traced(few, RAYS)?))?
    })
}

/// By how much less time four rays with seven samples each take than eight alone, percent.
fn half_the_rays_with_samples_save(scene: &SceneRows<'_>) -> Option<Estimate> {
    let (four, eight) = (of_count(scene, "4", true)?, of_count(scene, "8", true)?);
    of_both(|layers| {
        let (four, eight) = (with(&four, layers, "7")?, with(&eight, layers, "0")?);
        ratio(scene.record, &traced(four, RAYS)?, &traced(eight, RAYS)?)
    })
    .map(Estimate::percent_below)
}

/// The share of rays through the lens that end in the second layer, of other surfaces if that is said, the most over rays a pixel.
fn rays_behind_first_layer(scene: &SceneRows<'_>, other: &[(&str, &str)]) -> Option<f64> {
    let share = |count: &str| {
        let two = of_count(scene, count, true)?.like_first(QUADTREE, &[&[("layers", "2")], other].concat())?;
        share_behind_first(trace(two, RAYS)?)
    };
    greatest(["4", "8"].into_iter().filter_map(share))
}
