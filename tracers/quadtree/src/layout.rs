//! What is built: views, images, levels, and the uniforms that tell shaders of them.

use bytemuck::Zeroable;
use tracebench_api::{TracerError, View, Viewpoint};
use tracebench_kit::{MAX_LEVELS, Pyramid, RasterBackend, ViewUniform, view_uniform, view_uniforms};

use crate::description::{
    BackFaces, Capture, Dilated, DistanceIn, MAX_TREE_LEVELS, Normals, Patches, QuadtreeParameters, Views,
};
pub(crate) use tracebench_shaders::quadtree::{Forest, TreeView};

/// Views at most: six faces.
pub(crate) const MAX_VIEWS: usize = 6;

/// What is drawn and built.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    /// The camera's view, or six faces; all of one size.
    pub views: Vec<View>,
    /// Whether they are faces.
    pub has_faces: bool,
    pub layers: u32,
    pub capture: Capture,
    pub culls: bool,
    /// Scene units.
    pub separation: f64,
    pub normals: Normals,
    pub discontinuity: f64,
    /// Levels above the pixels.
    pub top: u32,
    /// Degrees.
    pub gamma_norm: f64,
    pub gamma_dist: f64,
    pub gamma_dist_in: DistanceIn,
    pub growth: f64,
    /// Pixels.
    pub dilation: f64,
    pub dilated: Dilated,
    /// Whether planes end at those beside them.
    pub is_joined: bool,
    /// What draws.
    pub raster_backend: RasterBackend,
}

impl Shape {
    pub(crate) fn new(
        viewpoint: &Viewpoint,
        diagonal: f64,
        parameters: &QuadtreeParameters,
    ) -> Result<Self, TracerError> {
        let has_faces = parameters.views == Views::Six;
        let views = if has_faces { viewpoint.face_views(0.0).to_vec() } else { vec![viewpoint.frame_view()] };
        let size = views[0].size;
        if size.contains(&0) {
            return Err(TracerError::Failed(format!(
                "a view of {} x {} pixels shows nothing: turn up {}",
                size[0],
                size[1],
                if has_faces { "--face-size" } else { "--frame-size" }
            )));
        }
        let whole = (Pyramid { size }.levels() - 1) as u32;
        Ok(Self {
            views,
            has_faces,
            layers: parameters.layers,
            capture: parameters.capture,
            culls: parameters.back_faces == BackFaces::Culled,
            separation: parameters.minimum_separation * diagonal,
            normals: parameters.normals,
            discontinuity: parameters.discontinuity,
            top: whole.min(parameters.levels.min(MAX_TREE_LEVELS)),
            gamma_norm: parameters.gamma_norm,
            gamma_dist: parameters.gamma_dist,
            gamma_dist_in: parameters.gamma_dist_in,
            growth: parameters.gamma_growth,
            dilation: parameters.dilation,
            dilated: parameters.dilated,
            is_joined: parameters.patches == Patches::Joined,
            raster_backend: parameters.build,
        })
    }

    /// Pixels along x and y of every image.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.views[0].size
    }

    /// Pixels of an image.
    pub(crate) fn pixels(&self) -> u64 {
        self.size().map(u64::from).iter().product()
    }

    /// Layers of all views.
    pub(crate) fn images(&self) -> u64 {
        self.views.len() as u64 * u64::from(self.layers)
    }

    /// Nodes along x and y of a level of an image.
    pub(crate) fn level_size(&self, level: u32) -> [u32; 2] {
        Pyramid { size: self.size() }.level_size(level as usize)
    }

    /// The first node of every level of an image, and how many there are.
    pub(crate) fn level_offsets(&self) -> ([u32; MAX_LEVELS], u64) {
        let mut offsets = [0; MAX_LEVELS];
        let mut end = 0;
        for level in 0..=self.top {
            offsets[level as usize] = end as u32;
            end += Pyramid { size: self.size() }.cells(level as usize);
        }
        (offsets, end)
    }

    /// Depths of a pixel that a pass of the k-buffer catches.
    pub(crate) fn slots(&self) -> u32 {
        if self.thins() { 2 * self.layers } else { self.layers }
    }

    /// Whether layers are chosen from more depths that are caught.
    pub(crate) fn thins(&self) -> bool {
        self.capture == Capture::KBuffer && self.separation > 0.0
    }

    /// The option that makes views smaller.
    pub(crate) fn smaller_by(&self) -> &'static str {
        if self.has_faces { "--face-size" } else { "--frame-size" }
    }

    /// What makes views smaller, or fewer.
    pub(crate) fn hint(&self) -> &'static str {
        match self.has_faces {
            true => "--face-size or quadtree.layers",
            false => "--frame-size or quadtree.layers",
        }
    }

    pub(crate) fn forest(&self) -> Forest {
        let View { near, far, tan_half_height, size, .. } = self.views[0];
        let (level_offsets, image_nodes) = self.level_offsets();
        Forest {
            size,
            top: self.top,
            layers: self.layers,
            image_count: self.images() as u32,
            image_nodes: image_nodes as u32,
            z_scale: (near * (far / (far - near))) as f32,
            z_shift: (near / (far - near)) as f32,
            pixel_angle: (2.0 * tan_half_height / f64::from(size[1])) as f32,
            dilation: self.dilation as f32,
            dilated: if self.dilation > 0.0 { self.dilated as u32 } else { Dilated::None as u32 },
            discontinuity: self.discontinuity as f32,
            gamma_norm: (2.0 * (self.gamma_norm.to_radians() / 2.0).sin()) as f32,
            gamma_dist: self.gamma_dist as f32,
            gamma_in_pixels: self.gamma_dist_in as u32,
            growth: self.growth as f32,
            normals_of_geometry: self.normals as u32,
            inverse_far: (1.0 / far) as f32,
            is_joined: u32::from(self.is_joined),
            padding: 0,
            level_offsets,
        }
    }

    /// The views as a trace takes them, unused ones zero.
    pub(crate) fn tree_views(&self) -> [TreeView; MAX_VIEWS] {
        let mut all: [TreeView; MAX_VIEWS] = Zeroable::zeroed();
        for (slot, view) in all.iter_mut().zip(&self.views) {
            let beyond = [view.right, -view.right, view.up, -view.up].map(|side| {
                let is_beyond = |other: &View| other.forward.dot(side) > 0.99;
                let found = self.views.iter().position(is_beyond).filter(|_| self.has_faces);
                found.unwrap_or(self.views.len()) as u32
            });
            *slot = TreeView { view: view_uniform(view), beyond };
        }
        all
    }

    /// The views alone, unused ones zero.
    pub(crate) fn view_uniforms(&self) -> [ViewUniform; MAX_VIEWS] {
        view_uniforms(self.views.iter().map(view_uniform))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracebench_api::glam::Vec3;
    use tracebench_api::{Parameters, Preset};

    fn shape(frame: [u32; 2], settings: &[(&str, &str)]) -> Result<Shape, TracerError> {
        let descriptions = crate::description().parameters;
        let mut parameters = Parameters::preset(&descriptions, Preset::Published);
        for (name, value) in settings {
            parameters.set(&descriptions, name, value).unwrap();
        }
        let viewpoint = Viewpoint {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            vertical_fov: 1.0,
            near: 0.1,
            far: 100.0,
            frame,
            face: 1024,
        };
        Shape::new(&viewpoint, 10.0, &QuadtreeParameters::try_from(&parameters).unwrap())
    }

    /// At the paper's resolution nine levels end in a row of roots, 512 pixels wide each; smaller frames end in one root, and
    /// a single pixel is one. Faces of 1024 with two layers are what the software adapters' bindings hold.
    #[test]
    fn levels_are_those_of_the_paper() {
        let roots = |frame: [u32; 2]| {
            let shape = shape(frame, &[]).unwrap();
            (shape.top, shape.level_size(shape.top))
        };
        assert_eq!(roots([1600, 900]), (9, [4, 2]));
        assert_eq!(roots([1024, 512]), (9, [2, 1]));
        assert_eq!(roots([512, 512]), (9, [1, 1]));
        assert_eq!(roots([63, 41]), (6, [1, 1]));
        assert_eq!(roots([1, 1]), (0, [1, 1]));
        assert_eq!(roots([1, 3]), (2, [1, 1]));
        let faces = shape([1, 1], &[("views", "six")]).unwrap();
        assert!(faces.level_offsets().1 * faces.images() * 8 <= 128 << 20);
        assert!(shape([0, 4], &[]).unwrap_err().to_string().contains("--frame-size"));
    }

    /// Depth goes from 1 at near to 0 at far; every side of a face has the face there that continues the view, a frame has none.
    #[test]
    fn uniforms_say_what_views_are() {
        let frame = shape([20, 10], &[("layers", "3")]).unwrap();
        let forest = frame.forest();
        let z = |depth: f32| forest.z_scale / depth - forest.z_shift;
        assert!((z(0.1) - 1.0).abs() < 1e-6 && z(100.0).abs() < 1e-6, "{forest:?}");
        assert_eq!((forest.image_count, frame.tree_views()[0].beyond), (3, [1; 4]));
        let faces = shape([20, 10], &[("views", "six")]).unwrap();
        for (view, slot) in faces.views.iter().zip(faces.tree_views()) {
            for ((x, y), other) in [(1025.0, 3.3), (-1.0, 3.3), (3.3, -1.0), (3.3, 1025.0)].into_iter().zip(slot.beyond)
            {
                let point = view.eye + view.direction_through(x, y) * 20.0;
                assert!(faces.views[other as usize].project_inside(point).is_some(), "{x} {y}");
            }
        }
    }
}
