//! The unit cube that a scene is mapped into by methods that sample it along its axes.

use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::{Geometry, ImageChoice, Layers, Orthographic, Projection, SampledImage, VoxelGrid, choice};
pub use tracebench_shaders::shared::UnitSpace;

/// Axes, and images.
const AXES: usize = 3;

/// Texels between the scene and the borders of images, so that nothing lies on these.
const MARGIN: f64 = 1.0;

/// Least extent of an axis that is scaled by itself, as a share of the greatest: flat scenes have none.
const MIN_EXTENT: f64 = 1e-6;

choice! {
    /// What the scene's bounds are mapped to.
    pub enum Fit { Cube = "cube", Box = "box" }
}

/// The space of a scene's bounds, with images and a grid of such edges.
pub fn unit_space(geometry: &Geometry, fit: Fit, image: u32, grid: u32) -> UnitSpace {
    let (low, high) = (geometry.bounds_min.as_dvec3(), geometry.bounds_max.as_dvec3());
    let extent = high - low;
    // A scene in one point still has a cube about it.
    let reach = f64::max(low.abs().max_element(), high.abs().max_element());
    let least = (reach * f64::from(f32::EPSILON)).max(f64::from(f32::MIN_POSITIVE) * 1e6);
    let edge = extent.max_element().max(least);
    let inner = f64::max(1.0 - 2.0 * MARGIN / f64::from(image), 0.5);
    let scale = match fit {
        Fit::Cube => DVec3::splat(inner / edge),
        Fit::Box => inner / extent.max(DVec3::splat(least.max(edge * MIN_EXTENT))),
    };
    let begin = DVec3::splat(0.5) - 0.5 * extent * scale;
    UnitSpace {
        low: geometry.bounds_min.into(),
        image,
        scale: scale.as_vec3().into(),
        grid,
        begin: begin.as_vec3().into(),
        padding: 0,
    }
}

/// A point of the scene in the cube.
pub fn to_unit(space: &UnitSpace, point: DVec3) -> DVec3 {
    let [low, scale, begin] = parts(space);
    (point - low) * scale + begin
}

/// A point of the cube in the scene.
pub fn to_scene(space: &UnitSpace, point: DVec3) -> DVec3 {
    let [low, scale, begin] = parts(space);
    (point - begin) / scale + low
}

fn parts(space: &UnitSpace) -> [DVec3; 3] {
    [space.low, space.scale, space.begin].map(|part| Vec3::from(part).as_dvec3())
}

/// The images along its axes, which keep every layer.
pub fn samplings_along_axes(space: &UnitSpace) -> Vec<SampledImage> {
    let image = |axis| Projection::Orthographic(image_along(space, axis));
    (0..AXES).map(|axis| SampledImage::new(image(axis), Layers::All)).collect()
}

/// Its grid, and how a trace looks into its voxels, which may be not at all.
pub fn voxel_grid(space: &UnitSpace, images: Option<ImageChoice>) -> VoxelGrid {
    let edge = f64::from(space.grid);
    VoxelGrid { low: to_scene(space, DVec3::ZERO), voxel: 1.0 / (parts(space)[1] * edge), size: space.grid, images }
}

fn image_along(space: &UnitSpace, axis: usize) -> Orthographic {
    let [across, down] = across_and_down(axis);
    let edge = f64::from(space.image);
    let texels = 1.0 / parts(space)[1];
    let unit = |axis: usize| DVec3::AXES[axis];
    Orthographic {
        origin: to_scene(space, DVec3::ZERO),
        right: unit(across),
        // Rows count downwards.
        up: -unit(down),
        axis: unit(axis),
        texel: DVec2::new(texels[across], texels[down]) / edge,
        far: texels[axis],
        size: [space.image; 2],
    }
}

/// The axes along which the columns and rows of the image along an axis are counted.
pub fn across_and_down(axis: usize) -> [usize; 2] {
    [(axis + 1) % AXES, (axis + 2) % AXES]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bounds lie within the cube, a texel from its borders, centred, by one scale or by one an axis; flat and single-point scenes do,
    /// too; and points come back from where they are mapped to.
    #[test]
    fn bounds_are_mapped_into_the_cube() {
        for (corner, extent) in [
            (DVec3::new(-3.0, 2.0, 7.0), DVec3::new(4.0, 2.0, 1.0)),
            (DVec3::new(-3.0, 2.0, 7.0), DVec3::new(4.0, 2.0, 0.0)),
            (DVec3::new(1e6, -2e6, 3e6), DVec3::ZERO),
            (DVec3::ZERO, DVec3::ZERO),
            (DVec3::splat(-1e12), DVec3::new(2e12, 1e12, 1e9)),
            (DVec3::splat(1e-7), DVec3::new(1e-9, 1e-8, 1e-8)),
        ] {
            let positions = [corner, corner + extent, corner].map(|corner| corner.as_vec3().into());
            let geometry = Geometry::new(positions.to_vec(), vec![[0, 1, 2]], None).unwrap();
            for (fit, image) in [(Fit::Cube, 1280), (Fit::Box, 1280), (Fit::Cube, 3)] {
                let space = unit_space(&geometry, fit, image, 8);
                let ends = [geometry.bounds_min, geometry.bounds_max].map(|end| to_unit(&space, end.as_dvec3()));
                let margin = f64::min(1.0 / f64::from(image), 0.25) - 1e-5;
                assert!(ends[0].min_element() >= margin && ends[1].max_element() <= 1.0 - margin, "{ends:?} {space:?}");
                assert!((ends[0] + ends[1] - DVec3::ONE).abs().max_element() < 1e-5, "{ends:?}");
                let scale = Vec3::from(space.scale);
                assert!(scale.is_finite() && (fit == Fit::Box || scale == Vec3::splat(scale.x)));
                let there = to_scene(&space, DVec3::new(0.25, 0.5, 0.75));
                assert!((to_unit(&space, there) - DVec3::new(0.25, 0.5, 0.75)).length() < 1e-6);
            }
            if extent.min_element() > 1e-8 {
                let wide = to_unit(&unit_space(&geometry, Fit::Box, 1280, 8), geometry.bounds_max.as_dvec3());
                assert!(wide.min_element() > 0.99, "{wide}");
            }
        }
    }

    /// The images' pixels and depths are those of the cube, along every axis, of oblong texels, too.
    #[test]
    fn samplings_are_the_images() {
        let positions = vec![[-3.0, 2.0, 7.0], [1.0, 4.0, 8.0], [0.0, 3.0, 7.5]];
        let geometry = Geometry::new(positions, vec![[0, 1, 2]], None).unwrap();
        for fit in [Fit::Cube, Fit::Box] {
            let space = unit_space(&geometry, fit, 100, 8);
            for axis in 0..AXES {
                let image = image_along(&space, axis);
                let point = DVec3::new(-0.3, 2.7, 7.6);
                let (at, unit) = (image.project(point), to_unit(&space, point));
                let [across, down] = across_and_down(axis);
                assert!((at.x - unit[across] * 100.0).abs() < 1e-4 && (at.y - unit[down] * 100.0).abs() < 1e-4);
                assert!((at.depth / image.far - unit[axis]).abs() < 1e-6);
                // A right-handed image that looks along its axis has right x up against it; this one shows the scene mirrored.
                assert_eq!(image.right.cross(-image.up), image.axis);
            }
        }
    }
}
