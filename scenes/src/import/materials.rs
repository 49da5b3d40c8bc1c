//! Material factors; textures are never looked at.

use gltf::json::Root;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;

use crate::scene::Material;

/// For primitives without a material: a light grey, rough dielectric. (The specification's own default is a white metal,
/// because its factors are there to be multiplied by textures.)
pub(super) const DEFAULT: Material =
    Material { base_color: [0.8, 0.8, 0.8], metallic: 0.0, roughness: 1.0, refractive_index: None };

/// Of a material that transmits more light than it scatters: its index, 1.5 where none is given.
fn refractive_index(extensions: Option<&gltf::json::extensions::material::Material>) -> Option<f32> {
    let extensions = extensions?;
    let transmits = extensions.transmission.as_ref()?.transmission_factor.0 > 0.5;
    let index = extensions.ior.as_ref().map_or(1.5, |given| given.ior.0);
    (transmits && index >= 1.0 && index.is_finite()).then_some(index)
}

/// The materials of the document in its order.
pub(super) fn collect(root: &Root, warnings: &mut Vec<String>) -> Vec<Material> {
    let mut clamped = 0;
    let mut masked = 0;
    let materials = root
        .materials
        .iter()
        .map(|material| {
            if matches!(material.alpha_mode, Checked::Valid(AlphaMode::Mask | AlphaMode::Blend)) {
                masked += 1;
            }
            let factors = &material.pbr_metallic_roughness;
            let [red, green, blue, _] = factors.base_color_factor.0;
            let given = [red, green, blue, factors.metallic_factor.0, factors.roughness_factor.0];
            let kept = given.map(|value| value.clamp(0.0, 1.0));
            if kept != given {
                clamped += 1;
            }
            let refractive_index = refractive_index(material.extensions.as_ref());
            Material {
                base_color: [kept[0], kept[1], kept[2]],
                metallic: kept[3],
                roughness: kept[4],
                refractive_index,
            }
        })
        .collect();
    if masked > 0 {
        warnings.push(format!("alpha masks are ignored: geometry is opaque (materials concerned: {masked})"));
    }
    if clamped > 0 {
        warnings.push(format!("factors outside [0, 1] are clamped (materials concerned: {clamped})"));
    }
    materials
}
