//! How a structure samples the scene: through which images, perspective or orthographic, and how much it keeps at a pixel.

use glam::{DVec2, DVec3};

use crate::{Projected, Ray, View};

/// One image that a structure sees the scene through.
#[derive(Clone, Copy, Debug)]
pub struct SampledImage {
    /// Where its pixels look.
    pub projection: Projection,
    /// What it keeps at a pixel.
    pub layers: Layers,
    /// How rays are traced over it; none where that is not declared.
    pub march: Option<ImageMarch>,
}

/// How a ray is traced over an image whose samples are the depths at its pixels' centres: at which pixels it looks, and how thick it
/// takes samples to be.
#[derive(Clone, Copy, Debug)]
pub struct ImageMarch {
    /// At which pixels it looks.
    pub steps: MarchSteps,
    /// Pixels along the major axis that a ray leaves out which starts in the image.
    pub start_bias: f64,
    /// How far behind its depth a sample still counts, or, below 0, how far before it, scene units.
    pub thickness: f64,
    /// The same in widths of a pixel at the ray's depth; added.
    pub thickness_in_pixels: f64,
    /// Whether a sample reaches to the next surface behind it that faces away, where there is one.
    pub to_back_faces: bool,
    /// Whether a sample counts only for rays that come to it from before.
    pub from_before: bool,
    /// Whether a hit may be told anywhere on the part of the ray that is looked at, not where the ray is as deep as the sample.
    pub anywhere: bool,
}

/// At which pixels a ray looks on its way over an image.
#[derive(Clone, Copy, Debug)]
pub enum MarchSteps {
    /// At every one that it crosses.
    EveryPixel,
    /// At one every so many pixels along the major axis, each for the way up to the middle between it and the next.
    Stride(f64),
    /// At one in each of so many equal steps, fewer where it crosses fewer pixels.
    Equal {
        /// How many at most.
        most: u32,
        /// Where in its steps a ray looks, a share.
        looks_at: fn(&Ray) -> f64,
        /// Whether a look is for the part of the ray within its pixel alone.
        within_pixel: bool,
    },
}

impl SampledImage {
    /// An image, without how rays are traced over it.
    pub fn new(projection: Projection, layers: Layers) -> Self {
        Self { projection, layers, march: None }
    }
}

/// Which of the surfaces along a pixel's line of sight are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layers {
    /// The nearest.
    Nearest,
    /// So many, from the nearest on.
    AtMost(u32),
    /// So many, from the nearest on, of those that are not left out.
    Chosen {
        /// How many at most.
        most: u32,
        /// What lies no farther than this behind the one before is left out, depth in scene units.
        separation: f64,
        /// Whether triangles that face away are kept.
        back_faces: bool,
    },
    /// Every one.
    All,
}

impl Layers {
    /// Of a method that keeps so many and may leave out some: what lies close behind another, and what faces away.
    pub fn of(most: u32, separation: f64, back_faces: bool) -> Self {
        match (most, separation > 0.0 || !back_faces) {
            (_, true) => Self::Chosen { most, separation, back_faces },
            (1, false) => Self::Nearest,
            (_, false) => Self::AtMost(most),
        }
    }

    /// How many that are at most.
    pub fn most(self) -> usize {
        match self {
            Self::Nearest => 1,
            Self::AtMost(most) | Self::Chosen { most, .. } => most as usize,
            Self::All => usize::MAX,
        }
    }
}

/// A grid of voxels by which a structure knows where the scene is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelGrid {
    /// The grid's least corner.
    pub low: DVec3,
    /// Edges of a voxel, scene units.
    pub voxel: DVec3,
    /// Voxels along each edge of the grid.
    pub size: u32,
    /// How a voxel is looked into; none by methods that know no more of it than that it has anything.
    pub images: Option<ImageChoice>,
}

/// How a voxel is looked into by methods that keep an image along each axis and tell on which side of the surfaces a point lies by
/// the number of layers before it. The image is that along which the average of the normals in the voxel is longest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageChoice {
    /// Whether a triangle feeds averages by its area along its dominant axis alone, and not by those along all three.
    pub by_dominant_axis: bool,
    /// Whether normals are averaged as lines, turned so that their longest component is positive.
    pub as_lines: bool,
    /// Length of an average below which it says nothing: the image is then that along which the ray goes most.
    pub cancelled_below: f64,
    /// At how many points of a ray's way through a voxel its side is asked; none: wherever it leaves a texel.
    pub points: Option<u32>,
    /// Whether, besides, the layers are seen that a ray passes within a texel.
    pub layers_passed: bool,
    /// Whether a ray ends where its side is not that of its start; if not, where it is not that on which it was a texel before the
    /// voxels that it goes through by one image, one after the other.
    pub from_start: bool,
    /// Texels of its way that a ray leaves out which starts within the scene's bounds; its side is told after them.
    pub start_texels: f64,
}

impl VoxelGrid {
    /// The voxel that a point lies in, if it is inside of the grid.
    pub fn voxel_of(&self, point: DVec3) -> Option<[u32; 3]> {
        let place = ((point - self.low) / self.voxel).floor();
        let inside = place.cmpge(DVec3::ZERO).all() && place.cmplt(DVec3::splat(f64::from(self.size))).all();
        inside.then(|| place.to_array().map(|along| along as u32))
    }

    /// Least and greatest corner of a voxel.
    pub fn bounds_of(&self, voxel: [u32; 3]) -> [DVec3; 2] {
        let place = DVec3::from(voxel.map(f64::from));
        [place, place + 1.0].map(|corner| self.low + corner * self.voxel)
    }
}

/// How an image's pixels look at the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// From one eye.
    Perspective(View),
    /// Along one axis: of methods that do not depend on a viewpoint.
    Orthographic(Orthographic),
}

/// An image whose pixels look along parallel lines, such as a side of a grid of voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orthographic {
    /// The image's upper left corner, where depth is 0.
    pub origin: DVec3,
    /// Unit vector to the right in the image.
    pub right: DVec3,
    /// Unit vector up in the image.
    pub up: DVec3,
    /// Unit vector along which pixels look.
    pub axis: DVec3,
    /// Width and height of a pixel, scene units.
    pub texel: DVec2,
    /// How deep the image reaches, scene units.
    pub far: f64,
    /// Width and height, pixels.
    pub size: [u32; 2],
}

/// A line along which an image looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineOfSight {
    /// Where it begins.
    pub origin: DVec3,
    /// Its direction.
    pub direction: DVec3,
    /// From where on surfaces are seen, in lengths of the direction.
    pub near: f64,
    /// Up to where.
    pub far: f64,
}

impl Orthographic {
    /// Projects a point.
    pub fn project(&self, point: DVec3) -> Projected {
        let offset = point - self.origin;
        let (x, y) = (offset.dot(self.right) / self.texel.x, -offset.dot(self.up) / self.texel.y);
        Projected { x, y, depth: offset.dot(self.axis) }
    }

    fn begin(&self, x: f64, y: f64) -> DVec3 {
        self.origin + self.right * (x * self.texel.x) - self.up * (y * self.texel.y)
    }
}

impl Projection {
    /// Projects a point; `None` behind an eye.
    pub fn project(&self, point: DVec3) -> Option<Projected> {
        match self {
            Self::Perspective(view) => view.project(point),
            Self::Orthographic(image) => Some(image.project(point)),
        }
    }

    /// Projects a point if it lies inside the image: on its pixels, between near and far.
    pub fn project_inside(&self, point: DVec3) -> Option<Projected> {
        match self {
            Self::Perspective(view) => view.project_inside(point),
            Self::Orthographic(image) => Some(image.project(point)).filter(|at| {
                (0.0..f64::from(image.size[0])).contains(&at.x)
                    && (0.0..f64::from(image.size[1])).contains(&at.y)
                    && (0.0..=image.far).contains(&at.depth)
            }),
        }
    }

    /// Width and height of a pixel at a depth, scene units.
    pub fn pixel_at(&self, depth: f64) -> DVec2 {
        match self {
            Self::Perspective(view) => {
                let [width, height] = view.size.map(f64::from);
                2.0 * depth * DVec2::new(view.tan_half_width / width, view.tan_half_height / height)
            }
            Self::Orthographic(image) => image.texel,
        }
    }

    /// The line through a position in pixels; its lengths are depths.
    pub fn line_through(&self, x: f64, y: f64) -> LineOfSight {
        match self {
            Self::Perspective(view) => LineOfSight {
                origin: view.eye,
                direction: view.direction_through(x, y),
                near: view.near,
                far: view.far,
            },
            Self::Orthographic(image) => {
                LineOfSight { origin: image.begin(x, y), direction: image.axis, near: 0.0, far: image.far }
            }
        }
    }

    /// The line to a point, which ends there; its lengths are scene units.
    pub fn line_to(&self, point: DVec3) -> LineOfSight {
        match self {
            Self::Perspective(view) => {
                let offset = point - view.eye;
                let distance = offset.length();
                // Near is an eye depth; along this line of sight it lies farther.
                let near = (view.near * distance / offset.dot(view.forward)).min(distance);
                LineOfSight { origin: view.eye, direction: offset / distance, near, far: distance }
            }
            Self::Orthographic(image) => {
                let depth = image.project(point).depth;
                let origin = point - image.axis * depth;
                LineOfSight { origin, direction: image.axis, near: 0.0, far: depth.max(0.0) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks along +y from y = -3 at 10 x 6 pixels of half a unit, x to the right and z up.
    fn image() -> Orthographic {
        Orthographic {
            origin: DVec3::new(1.0, -3.0, 2.0),
            right: DVec3::X,
            up: DVec3::Z,
            axis: DVec3::Y,
            texel: DVec2::splat(0.5),
            far: 8.0,
            size: [10, 6],
        }
    }

    /// Positions count from the upper left corner in pixels, depths along the axis; lines through positions and lines to
    /// points lead where projection says.
    #[test]
    fn orthographic_lines_invert_projection() {
        let projection = Projection::Orthographic(image());
        let at = projection.project(DVec3::new(2.25, 1.0, 0.5)).unwrap();
        assert_eq!((at.x, at.y, at.depth), (2.5, 3.0, 4.0));
        let flat = Projection::Orthographic(Orthographic { texel: DVec2::new(0.5, 0.25), ..image() });
        assert_eq!(flat.project(DVec3::new(2.25, 1.0, 0.5)).map(|at| (at.x, at.y)), Some((2.5, 6.0)));
        for (projection, (x, y, depth)) in [
            (projection, (0.5, 0.5, 1.0)),
            (projection, (9.75, 5.25, 7.5)),
            (projection, (3.0, 2.0, 0.25)),
            (flat, (3.0, 2.0, 0.25)),
        ] {
            let line = projection.line_through(x, y);
            let point = line.origin + line.direction * depth;
            let at = projection.project_inside(point).unwrap();
            assert!((at.x - x).abs() < 1e-12 && (at.y - y).abs() < 1e-12 && (at.depth - depth).abs() < 1e-12);
            let to = projection.line_to(point);
            assert!((to.origin + to.direction * to.far - point).length() < 1e-12 && to.far == at.depth);
        }
    }

    /// What lies aside, before the image or deeper than it reaches is outside of it; what lies before it is projected.
    #[test]
    fn orthographic_images_end() {
        let projection = Projection::Orthographic(image());
        let inside = |x, y, z| projection.project_inside(DVec3::new(x, y, z)).is_some();
        assert!(inside(1.0, -3.0, 1.9) && inside(5.9, 5.0, -0.9));
        assert!(!inside(0.9, 0.0, 0.0) && !inside(6.0, 0.0, 0.0) && !inside(2.0, 0.0, 2.1) && !inside(2.0, 0.0, -1.1));
        assert!(!inside(2.0, -3.1, 0.0) && !inside(2.0, 5.1, 0.0));
        assert!(projection.project(DVec3::new(2.0, -4.0, 0.0)).is_some());
    }
}
