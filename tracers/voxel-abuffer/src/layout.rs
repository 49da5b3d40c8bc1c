//! Where the scene lies in the unit cube, how fine its grid and images are, and the uniforms that tell shaders of it.

use tracebench_api::{Geometry, ImageChoice, SampledImage, Viewpoint, VoxelGrid};
use tracebench_kit::RasterBackend;
pub(crate) use tracebench_kit::{UnitSpace, across_and_down, samplings_along_axes, unit_space, voxel_grid};

use crate::description::{Averaged, Crossing, Fed, Fragments, Held, InTexel, Inside, StartAlong, VoxelParameters};
pub(crate) use tracebench_shaders::voxel_abuffer::{AveragedGrid, RasterizedAxis};

/// Axes, and images.
pub(crate) const AXES: usize = 3;

/// Their names.
pub(crate) const AXIS_NAMES: [&str; AXES] = ["x", "y", "z"];

/// Words from the heads of an axis to those of the next are whole multiples of it, as devices ask of where a binding begins.
const HEAD_ALIGNMENT: u32 = 64;

/// How much a normal of length 1 adds to its voxel's sums: as in shaders/voxel-abuffer/fill.wgsl.
pub(crate) const NORMAL_UNIT: f64 = 256.0;

/// Fragments whose normals sums of 32 bits are sure to hold.
pub(crate) const MAX_FRAGMENTS: u32 = (1 << 31) / NORMAL_UNIT as u32 - 1;

/// What is drawn and how it is stored.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    /// The cube, in which an image's texels and the grid's voxels are.
    pub space: UnitSpace,
    /// Whether there is nothing but a bit a voxel.
    pub voxels_only: bool,
    /// Whether fragments are oriented planes.
    pub planes: bool,
    /// Whether inside is told by nesting.
    pub nesting: bool,
    pub fed: Fed,
    pub averaged: Averaged,
    pub cancelled_below: f64,
    /// What draws.
    pub raster_backend: RasterBackend,
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
        let voxels_only = parameters.structure == Held::VoxelsOnly;
        let planes = !voxels_only && parameters.fragments == Fragments::Planes;
        let grid = asked(parameters.grid, auto_grid(image));
        // A fragment marks the voxels that it lies in, of which there are few where these are no smaller than texels.
        let grid = if planes { grid.min(image) } else { grid };
        // A bit a voxel is set where a sample of its own lies in it.
        let image = if voxels_only { grid } else { image };
        Self {
            space: unit_space(geometry, parameters.fit, image, grid),
            voxels_only,
            planes,
            nesting: parameters.inside == Inside::Nesting,
            fed: parameters.average_from,
            averaged: parameters.average,
            cancelled_below: parameters.cancelled_below,
            raster_backend: parameters.build,
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
    pub(crate) fn drawn(&self, axis: usize, capacity: u32, half_nodes: u32) -> RasterizedAxis {
        RasterizedAxis {
            space: self.space,
            axis: axis as u32,
            capacity,
            half_nodes,
            fed_by: self.fed as u32,
            as_lines: self.averaged as u32,
            nesting: u32::from(self.nesting),
            padding_b: 0,
            padding_c: 0,
        }
    }

    pub(crate) fn averaged_grid(&self) -> AveragedGrid {
        AveragedGrid {
            voxels: self.voxels(),
            min_length: self.cancelled_below as f32,
            max_fragments: MAX_FRAGMENTS,
            padding: 0,
        }
    }

    /// The images that the scene is seen through.
    pub(crate) fn samplings(&self) -> Vec<SampledImage> {
        samplings_along_axes(&self.space)
    }

    /// The grid, and how a trace by these parameters looks into its voxels.
    pub(crate) fn voxel_grid(&self, parameters: &VoxelParameters) -> VoxelGrid {
        let images = ImageChoice {
            by_dominant_axis: self.fed == Fed::Dominant,
            as_lines: self.averaged == Averaged::Lines,
            cancelled_below: self.cancelled_below,
            points: Some(parameters.search.points()).filter(|points| *points > 0),
            layers_passed: parameters.search.points() == 0 && parameters.in_texel == InTexel::Layers,
            from_start: parameters.crossing == Crossing::State,
            start_texels: if parameters.start_along == StartAlong::Ray { parameters.start_bias } else { 0.0 },
        };
        voxel_grid(&self.space, (!self.voxels_only).then_some(images))
    }
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
}
