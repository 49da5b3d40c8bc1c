//! How fragments are stored: views, words of a pixel, words of a node, and the uniforms that tell shaders of them.

use bytemuck::Zeroable;
use tracebench_api::{View, Viewpoint};
use tracebench_kit::{MAX_LEVELS, Pyramid, RasterBackend, RasterImage, view_uniform};

use crate::description::{
    Bounds, Centre, Coverage, FragmentParameters, Fragments, Kind, Layers, March, Outline, Switch, Views,
};
pub(crate) use tracebench_shaders::fragment_abuffer::{RasterizedView, Storage, TracedView};

/// Views at most: the camera's and six faces.
pub(crate) const MAX_VIEWS: usize = 7;

/// Words of what shading needs of a fragment: normal and material.
pub(crate) const PAYLOAD_WORDS: u32 = 4;

/// Words of a plane before its normal, and before the mask of its outline: greatest depth, distance from the eye; and those of the normal,
/// which data begins with.
const PLANE_WORDS: u32 = 2;
const NORMAL_WORDS: u32 = 3;

/// Where a view lies in the buffers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Placed {
    /// Its first pixel among those of its buffer, and its first node among all.
    pub first_pixel: u32,
    pub first_node: u32,
    /// Of its buffer.
    pub pixel_count: u32,
    pub node_capacity: u32,
    /// Words before those of its buffers, where textures hold several.
    pub begins: [u32; 4],
}

impl Kind {
    pub(crate) fn is_contiguous(self) -> bool {
        self == Self::SBuffer
    }

    /// Linked both ways.
    pub(crate) fn is_double(self) -> bool {
        matches!(self, Self::Dll | Self::Dllb)
    }

    pub(crate) fn is_bucketed(self) -> bool {
        matches!(self, Self::Llb | Self::Dllb)
    }
}

/// What is drawn and how it is stored.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    /// The views: the camera's first, if it is among them.
    pub views: Vec<View>,
    /// Whether the first view is the camera's.
    pub has_camera: bool,
    pub kind: Kind,
    /// Depth buckets of a pixel; 1 for a storage without.
    pub buckets: u32,
    /// Whether what shading needs lies in a buffer of its own.
    pub decoupled: bool,
    /// Whether fragments are planes.
    pub planes: bool,
    /// Whether planes have masks of their outlines.
    pub masked: bool,
    /// Whether all pixels have a fragment of a triangle that it touches.
    pub conservative: bool,
    /// Whether only the nearest fragment of a pixel is kept.
    pub one_layer: bool,
    /// Whether depth bounds are drawn by the bounding boxes of objects.
    pub by_boxes: bool,
    /// Whether there is a pyramid of depth bounds.
    pub hi_z: bool,
    /// What draws.
    pub raster_backend: RasterBackend,
}

impl Layout {
    pub(crate) fn new(viewpoint: &Viewpoint, parameters: &FragmentParameters) -> Self {
        let pulled_back = match parameters.centre {
            Centre::PulledBack => f64::from(viewpoint.near),
            Centre::Eye => 0.0,
        };
        let has_camera = parameters.views != Views::Six;
        let mut views = Vec::with_capacity(MAX_VIEWS);
        if has_camera {
            views.push(viewpoint.frame_view());
        }
        if parameters.views != Views::Frame {
            views.extend(viewpoint.face_views(pulled_back));
        }
        let (kind, one_layer) = (parameters.storage, parameters.layers == Layers::One);
        Self {
            views,
            has_camera,
            kind,
            buckets: if kind.is_bucketed() { parameters.buckets } else { 1 },
            decoupled: parameters.decoupled == Switch::On,
            planes: parameters.fragments == Fragments::Planes,
            masked: parameters.fragments == Fragments::Planes && parameters.outline == Outline::Masked,
            conservative: parameters.coverage == Coverage::Conservative,
            one_layer,
            // Which fragment is the nearest the boxes do not tell.
            by_boxes: parameters.bounds == Bounds::Boxes && !one_layer,
            hi_z: parameters.march == March::HiZ,
            raster_backend: parameters.build,
        }
    }

    /// Whether pixels have depth bounds.
    pub(crate) fn has_bounds(&self) -> bool {
        self.kind.is_bucketed() || self.one_layer || self.hi_z
    }

    /// Words of a pixel that are pointers into the nodes, or begin and count.
    fn pointer_words(&self) -> u32 {
        match self.kind {
            Kind::SBuffer => 2,
            Kind::Ll | Kind::Llb => self.buckets,
            Kind::Dll | Kind::Dllb => 2 * self.buckets,
        }
    }

    /// Words of a pixel: m_p of VVP16's Table 2 in words, and two more where a storage that needs no depth bounds has them.
    pub(crate) fn pixel_words(&self) -> u32 {
        self.pointer_words() + if self.has_bounds() { 2 } else { 0 }
    }

    /// What a ledger calls the words of pixels, by section 3.3.
    pub(crate) fn pixels_name(&self) -> String {
        let pointers = match self.kind {
            Kind::SBuffer => "begins and counts",
            Kind::Ll | Kind::Llb => "heads",
            Kind::Dll | Kind::Dllb => "heads and tails",
        };
        match (self.has_bounds(), pointers.contains(' ')) {
            (false, _) => pointers.to_owned(),
            (true, false) => format!("depth bounds and {pointers}"),
            (true, true) => format!("depth bounds, {pointers}"),
        }
    }

    /// Words of a node without what shading needs: m_f of VVP16's Table 2 in words. The s-buffer's is its depth alone where
    /// data lies beside it.
    fn search_words(&self) -> u32 {
        self.link_words() + if self.planes { PLANE_WORDS + u32::from(self.masked) } else { 0 }
    }

    /// Words of a node before those of a plane.
    fn link_words(&self) -> u32 {
        match self.kind {
            Kind::SBuffer if !self.decoupled => 1,
            Kind::SBuffer | Kind::Ll | Kind::Llb => 2,
            Kind::Dll | Kind::Dllb => 3,
        }
    }

    /// Words of a node.
    pub(crate) fn node_words(&self) -> u32 {
        let behind = match (self.decoupled, self.planes) {
            (true, false) => 0,
            (true, true) => NORMAL_WORDS,
            (false, _) => PAYLOAD_WORDS,
        };
        self.search_words() + behind
    }

    /// Pixels of a view.
    pub(crate) fn pixels_of(&self, view: usize) -> u64 {
        self.views[view].size.map(u64::from).iter().product()
    }

    /// The pyramid over a view's pixels, if there is one.
    pub(crate) fn pyramid_of(&self, view: usize) -> Pyramid {
        Pyramid { size: self.views[view].size }
    }

    /// Levels of a view's pyramid, down from one cell a view; 1 without a pyramid.
    pub(crate) fn levels_of(&self, view: usize) -> usize {
        if self.hi_z { self.pyramid_of(view).levels() } else { 1 }
    }

    /// Where the pyramid has the levels of each view, pairs of depth bounds, and how many there are.
    fn level_offsets(&self) -> (Vec<[u32; MAX_LEVELS]>, u64) {
        let mut total = 0;
        let of_view = |view: usize| {
            let mut offsets = [0; MAX_LEVELS];
            if self.hi_z {
                (offsets, total) = self.pyramid_of(view).offsets(1, total);
            }
            offsets
        };
        let offsets = (0..self.views.len()).map(of_view).collect();
        (offsets, total)
    }

    /// Bytes of the pyramid; 0 without one.
    pub(crate) fn pyramid_bytes(&self) -> u64 {
        self.level_offsets().1 * 8
    }

    /// The uniform for so many pixels and nodes.
    pub(crate) fn storage(&self, pixel_count: u32, node_capacity: u32) -> Storage {
        Storage {
            buckets: self.buckets,
            double: u32::from(self.kind.is_double()),
            bounds_word: if self.has_bounds() { self.pointer_words() } else { 0 },
            node_words: self.node_words(),
            data_words: if self.decoupled { PAYLOAD_WORDS } else { self.node_words() },
            data_offset: if self.decoupled { 0 } else { self.search_words() },
            node_capacity,
            one_layer: u32::from(self.one_layer),
            pixel_count,
            contiguous: u32::from(self.kind.is_contiguous()),
            plane_word: if self.planes { self.link_words() } else { 0 },
            conservative: u32::from(self.conservative),
            normal_word: if self.planes { self.search_words() } else { 0 },
        }
    }

    /// Whether triangles are clipped to pixels.
    pub(crate) fn is_clipped(&self) -> bool {
        self.planes || self.conservative
    }

    /// A view as its triangles are dealt out.
    pub(crate) fn image_of(&self, view: &View) -> RasterImage {
        RasterImage::View { view: view_uniform(view), size: view.size, touched: self.conservative }
    }

    /// Vertices of a pass over so many triangles: conservative coverage draws a rectangle of each.
    pub(crate) fn vertices(&self, triangles: u32) -> u32 {
        triangles.saturating_mul(if self.conservative { 6 } else { 3 })
    }

    /// The views as the trace takes them, unused ones zero; `placed` is where each lies.
    pub(crate) fn traced(&self, placed: &[Placed]) -> [TracedView; MAX_VIEWS] {
        let mut all: [TracedView; MAX_VIEWS] = Zeroable::zeroed();
        let (offsets, _) = self.level_offsets();
        for (index, (slot, view)) in all.iter_mut().zip(&self.views).enumerate() {
            let beyond = [view.right, -view.right, view.up, -view.up].map(|side| {
                let is_beyond = |other: &View| other.forward.dot(side) > 0.99;
                let faces = self.views.iter().enumerate().skip(usize::from(self.has_camera));
                // The camera's sides are no faces' borders: who leaves it is looked for.
                let found = faces.filter(|_| self.is_face(index)).find(|(_, other)| is_beyond(other));
                found.map_or(self.views.len(), |(number, _)| number) as u32
            });
            let Placed { first_pixel, first_node, pixel_count, node_capacity, begins } = placed[index];
            *slot = TracedView {
                view: view_uniform(view),
                first_pixel,
                first_node,
                pixel_count,
                node_capacity,
                padding: [0; 2],
                begins,
                levels: self.levels_of(index) as u32,
                is_face: u32::from(self.is_face(index)),
                beyond,
                level_offsets: offsets[index],
            };
        }
        all
    }

    pub(crate) fn is_face(&self, view: usize) -> bool {
        view > 0 || !self.has_camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracebench_api::glam::Vec3;
    use tracebench_api::{Parameters, Preset};

    fn layout(settings: &[(&str, &str)]) -> Layout {
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
            frame: [20, 10],
            face: 8,
        };
        Layout::new(&viewpoint, &FragmentParameters::try_from(&parameters).unwrap())
    }

    /// Bytes a pixel and a fragment are those of Table 2 for all five storages, at B = 4 and at B = 12.
    #[test]
    fn sizes_are_those_of_table_2() {
        for buckets in [4_u32, 12] {
            let of = |storage: &str| {
                let layout = layout(&[("storage", storage), ("buckets", &buckets.to_string())]);
                [4 * layout.pixel_words(), 4 * layout.node_words()]
            };
            assert_eq!(of("s-buffer"), [8, 8]);
            assert_eq!(of("ll"), [4, 8]);
            assert_eq!(of("dll"), [8, 12]);
            assert_eq!(of("llb"), [8 + 4 * buckets, 8]);
            assert_eq!(of("dllb"), [8 + 8 * buckets, 12]);
        }
    }

    /// Every side of a face has the face there that continues the view: a point just beyond the side, far from the centre, lies in
    /// it. The camera's sides have none.
    #[test]
    fn faces_are_connected_by_their_sides() {
        let layout = layout(&[]);
        let traced = layout.traced(&[Placed::default(); 7]);
        assert_eq!(traced[0].beyond, [7; 4]);
        for (view, slot) in layout.views.iter().zip(&traced).skip(1) {
            let [width, height] = view.size.map(f64::from);
            let beyond = [(width + 0.01, 3.3), (-0.01, 3.3), (3.3, -0.01), (3.3, height + 0.01)];
            for ((x, y), other) in beyond.into_iter().zip(slot.beyond) {
                let point = view.eye + view.direction_through(x, y) * 20.0;
                assert!(view.project_inside(point).is_none());
                assert!(layout.views[other as usize].project_inside(point).is_some(), "{x} {y}");
            }
        }
    }
}
