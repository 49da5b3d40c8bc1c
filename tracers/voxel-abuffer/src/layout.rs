//! Where the scene lies in the unit cube, how fine its grid and images are, and the uniforms that tell shaders of it.

use bytemuck::{Pod, Zeroable};
use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::{Geometry, Layers, Orthographic, Projection, Sampling, SharedLayout, Viewpoint};

use crate::description::{Averaged, Fed, Fit, Held, VoxelParameters};
use crate::search::VoxelSearch;

/// Axes, and images.
pub(crate) const AXES: usize = 3;

/// Their names.
pub(crate) const AXIS_NAMES: [&str; AXES] = ["x", "y", "z"];

/// Texels between the scene and the borders of images, so that nothing lies on these.
const MARGIN: f64 = 1.0;

/// Least extent of an axis that is scaled by itself, as a share of the greatest: flat scenes have none.
const LEAST_EXTENT: f64 = 1e-6;

/// Words from the heads of an axis to those of the next are whole multiples of it, as devices ask of where a binding begins.
const HEAD_ALIGNMENT: u32 = 64;

/// `UnitSpace` of shaders/voxel-abuffer/space.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct UnitSpace {
    /// A point of the scene is at (point - low) * scale + begin.
    pub low: [f32; 3],
    /// Edge of an image, texels.
    pub image: u32,
    /// By axis.
    pub scale: [f32; 3],
    /// Edge of the grid, voxels.
    pub grid: u32,
    /// Where the least corner of the bounds lies.
    pub begin: [f32; 3],
    /// Nothing.
    pub padding: u32,
}

/// `DrawnAxis` of shaders/voxel-abuffer/space.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct DrawnAxis {
    /// The cube.
    pub space: UnitSpace,
    /// The axis along which it is drawn.
    pub axis: u32,
    /// Nodes that there is room for.
    pub capacity: u32,
    /// How many of them have their data in its first half.
    pub half_nodes: u32,
    /// 0: all fragments feed the averages, 1: those by a triangle's dominant axis.
    pub fed_by: u32,
    /// 1: normals are averaged as lines.
    pub as_lines: u32,
    /// Nothing.
    pub padding_a: u32,
    /// Nothing.
    pub padding_b: u32,
    /// Nothing.
    pub padding_c: u32,
}

/// `AveragedGrid` of shaders/voxel-abuffer/average.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct AveragedGrid {
    /// Voxels of the grid.
    pub voxels: u32,
    /// Length below which an average says nothing.
    pub least_length: f32,
    /// Fragments that sums of 32 bits are sure to hold.
    pub most_fragments: u32,
    /// Nothing.
    pub padding: u32,
}

/// Layouts of all that shaders share with this crate.
pub(crate) fn layouts() -> Vec<SharedLayout> {
    tracebench_api::layouts! {
        UnitSpace { low, image, scale, grid, begin, padding }
        DrawnAxis { space, axis, capacity, half_nodes, fed_by, as_lines, padding_a, padding_b, padding_c }
        AveragedGrid { voxels, least_length, most_fragments, padding }
        VoxelSearch {
            space, ray_count, rays_per_lane, points, binary_steps, nesting, by_change, start_bias, head_stride, touched_words, half_nodes,
            at_exits, padding, first_nodes, first_bits, first_data, first_further_data,
        }
    }
}

/// How much a normal of length 1 adds to its voxel's sums: as in shaders/voxel-abuffer/fill.wgsl.
pub(crate) const NORMAL_UNIT: f64 = 256.0;

/// Fragments whose normals sums of 32 bits are sure to hold.
pub(crate) const MOST_FRAGMENTS: u32 = (1 << 31) / NORMAL_UNIT as u32 - 1;

/// What is drawn and how it is stored.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    /// The cube, in which an image's texels and the grid's voxels are.
    pub space: UnitSpace,
    /// Whether there is nothing but a bit a voxel.
    pub voxels_only: bool,
    pub fed: Fed,
    pub averaged: Averaged,
    pub cancelled_below: f64,
}

/// Edge of the images where none is said: two and a half faces, 1280 texels at faces of 512.
fn auto_image(face: u32) -> u32 {
    (face * 5).div_ceil(2)
}

/// Edge of the grid where none is said (HHZ14, section 5): 64 voxels at 1280 texels.
fn auto_grid(image: u32) -> u32 {
    (f64::sqrt(3.0 * f64::from(image)).ceil() as u32).next_multiple_of(8)
}

impl Layout {
    pub(crate) fn new(geometry: &Geometry, viewpoint: &Viewpoint, parameters: &VoxelParameters) -> Self {
        let asked = |value: u32, auto: u32| if value == 0 { auto } else { value };
        let image = asked(parameters.abuffer, auto_image(viewpoint.face));
        let grid = asked(parameters.grid, auto_grid(image));
        let voxels_only = parameters.structure == Held::VoxelsOnly;
        // A bit a voxel is set where a sample of its own lies in it.
        let image = if voxels_only { grid } else { image };
        Self {
            space: UnitSpace::of(geometry, parameters.fit, image, grid),
            voxels_only,
            fed: parameters.average_from,
            averaged: parameters.average,
            cancelled_below: parameters.cancelled_below,
        }
    }

    /// Edge of an image, texels.
    pub(crate) fn image(&self) -> u32 {
        self.space.image
    }

    /// Texels of an image, which have a list each.
    pub(crate) fn texels(&self) -> u32 {
        self.space.image * self.space.image
    }

    /// Voxels of the grid.
    pub(crate) fn voxels(&self) -> u32 {
        self.space.grid.pow(3)
    }

    /// Words from the heads of an axis to those of the next.
    pub(crate) fn head_stride(&self) -> u32 {
        self.texels().next_multiple_of(HEAD_ALIGNMENT)
    }

    /// Words of what searches read of the grid.
    pub(crate) fn cell_words(&self) -> u32 {
        self.voxels().div_ceil(if self.voxels_only { 32 } else { 8 })
    }

    /// What a pass along an axis is told.
    pub(crate) fn drawn(&self, axis: usize, capacity: u32, half_nodes: u32) -> DrawnAxis {
        DrawnAxis {
            space: self.space,
            axis: axis as u32,
            capacity,
            half_nodes,
            fed_by: self.fed as u32,
            as_lines: self.averaged as u32,
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        }
    }

    pub(crate) fn averaged_grid(&self) -> AveragedGrid {
        AveragedGrid {
            voxels: self.voxels(),
            least_length: self.cancelled_below as f32,
            most_fragments: MOST_FRAGMENTS,
            padding: 0,
        }
    }

    /// The images that the scene is seen through.
    pub(crate) fn samplings(&self) -> Vec<Sampling> {
        let image = |axis| Projection::Orthographic(self.space.image_along(axis));
        (0..AXES).map(|axis| Sampling { projection: image(axis), layers: Layers::All }).collect()
    }
}

impl UnitSpace {
    fn of(geometry: &Geometry, fit: Fit, image: u32, grid: u32) -> Self {
        let (low, high) = (geometry.bounds_min.as_dvec3(), geometry.bounds_max.as_dvec3());
        let extent = high - low;
        // A scene in one point still has a cube about it.
        let reach = f64::max(low.abs().max_element(), high.abs().max_element());
        let least = (reach * f64::from(f32::EPSILON)).max(f64::from(f32::MIN_POSITIVE) * 1e6);
        let edge = extent.max_element().max(least);
        let inner = f64::max(1.0 - 2.0 * MARGIN / f64::from(image), 0.5);
        let scale = match fit {
            Fit::Cube => DVec3::splat(inner / edge),
            Fit::Box => inner / extent.max(DVec3::splat(least.max(edge * LEAST_EXTENT))),
        };
        let begin = DVec3::splat(0.5) - 0.5 * extent * scale;
        Self {
            low: geometry.bounds_min.into(),
            image,
            scale: scale.as_vec3().into(),
            grid,
            begin: begin.as_vec3().into(),
            padding: 0,
        }
    }

    /// A point of the scene in the cube.
    pub(crate) fn to_unit(self, point: DVec3) -> DVec3 {
        let [low, scale, begin] = self.parts();
        (point - low) * scale + begin
    }

    /// A point of the cube in the scene.
    pub(crate) fn to_scene(self, point: DVec3) -> DVec3 {
        let [low, scale, begin] = self.parts();
        (point - begin) / scale + low
    }

    fn parts(self) -> [DVec3; 3] {
        [self.low, self.scale, self.begin].map(|part| Vec3::from(part).as_dvec3())
    }

    fn image_along(self, axis: usize) -> Orthographic {
        let [across, down] = across_and_down(axis);
        let edge = f64::from(self.image);
        let texels = 1.0 / self.parts()[1];
        let unit = |axis: usize| DVec3::AXES[axis];
        Orthographic {
            origin: self.to_scene(DVec3::ZERO),
            right: unit(across),
            // Rows count downwards.
            up: -unit(down),
            axis: unit(axis),
            texel: DVec2::new(texels[across], texels[down]) / edge,
            far: texels[axis],
            size: [self.image; 2],
        }
    }
}

/// The axes along which the columns and rows of the image along an axis are counted.
pub(crate) fn across_and_down(axis: usize) -> [usize; 2] {
    [(axis + 1) % AXES, (axis + 2) % AXES]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's sizes follow from faces of 512 texels, and others by its rule.
    #[test]
    fn sizes_are_the_papers() {
        assert_eq!((auto_image(512), auto_grid(1280)), (1280, 64));
        assert_eq!((auto_image(1), auto_grid(3)), (3, 8));
        assert_eq!([1024, 2560, 5120].map(auto_grid), [56, 88, 128]);
    }

    /// The bounds lie within the cube, a texel from its borders, centred, by one scale or by one an axis; flat and single-point scenes do, too;
    /// and points come back from where they are mapped to.
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
                let space = UnitSpace::of(&geometry, fit, image, 8);
                let ends = [geometry.bounds_min, geometry.bounds_max].map(|end| space.to_unit(end.as_dvec3()));
                let margin = f64::min(1.0 / f64::from(image), 0.25) - 1e-5;
                assert!(ends[0].min_element() >= margin && ends[1].max_element() <= 1.0 - margin, "{ends:?} {space:?}");
                assert!((ends[0] + ends[1] - DVec3::ONE).abs().max_element() < 1e-5, "{ends:?}");
                let scale = Vec3::from(space.scale);
                assert!(scale.is_finite() && (fit == Fit::Box || scale == Vec3::splat(scale.x)));
                let there = space.to_scene(DVec3::new(0.25, 0.5, 0.75));
                assert!((space.to_unit(there) - DVec3::new(0.25, 0.5, 0.75)).length() < 1e-6);
            }
            if extent.min_element() > 1e-8 {
                let wide = UnitSpace::of(&geometry, Fit::Box, 1280, 8).to_unit(geometry.bounds_max.as_dvec3());
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
            let space = UnitSpace::of(&geometry, fit, 100, 8);
            for axis in 0..AXES {
                let image = space.image_along(axis);
                let point = DVec3::new(-0.3, 2.7, 7.6);
                let (at, unit) = (image.project(point), space.to_unit(point));
                let [across, down] = across_and_down(axis);
                assert!((at.x - unit[across] * 100.0).abs() < 1e-4 && (at.y - unit[down] * 100.0).abs() < 1e-4);
                assert!((at.depth / image.far - unit[axis]).abs() < 1e-6);
                // A right-handed image that looks along its axis has right x up against it; this one shows the scene mirrored.
                assert_eq!(image.right.cross(-image.up), image.axis);
            }
        }
    }
}
