//! Views, tiles and buffers' sizes, and the uniforms that tell shaders of them.

use tracebench_api::{View, Viewpoint};
use tracebench_kit::{Pyramid, RasterBackend, RasterWork, ViewUniform, view_uniform};

use crate::description::{Centre, DirtParameters, Near, Views};
use crate::setup::SetupPass;
pub(crate) use tracebench_shaders::dirt::{FillPass, MipmapLevel, TileGrid, TraceSettings};

/// Views at most.
pub(crate) const MAX_VIEWS: usize = 6;

/// A view's part of a buffer may be bound on its own: parts begin at multiples of this, which every adapter allows.
const PART_ALIGNMENT: u64 = 256;

/// Near without a near plane, in far distances.
pub(crate) const NO_NEAR: f64 = 1e-15;

/// What is drawn and how it is stored.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    /// The views, sizes in pixels.
    pub views: Vec<View>,
    /// Pixels along a tile's edge.
    pub tile_size: u32,
    pub tiles: [u32; 2],
    pub buckets: u32,
    /// What draws the two geometry passes.
    pub raster_backend: RasterBackend,
}

impl Layout {
    pub(crate) fn new(viewpoint: &Viewpoint, parameters: &DirtParameters) -> Self {
        let tile_size = parameters.tile_size.pixels();
        let mut views = match (parameters.views, parameters.centre) {
            (Views::Frame, _) => vec![viewpoint.frame_view()],
            (Views::Six, Centre::PulledBack) => viewpoint.face_views(f64::from(viewpoint.near)).to_vec(),
            (Views::Six, Centre::Eye) => viewpoint.face_views(0.0).to_vec(),
        };
        if parameters.near == Near::None {
            for view in &mut views {
                view.near = view.far * NO_NEAR;
            }
        }
        let tiles = views[0].size.map(|edge| edge.div_ceil(tile_size));
        Self { views, tile_size, tiles, buckets: parameters.buckets, raster_backend: parameters.build }
    }

    fn pyramid(&self) -> Pyramid {
        Pyramid { size: self.tiles }
    }

    /// Tiles of a level along x and y.
    pub(crate) fn level_tiles(&self, level: usize) -> [u32; 2] {
        self.pyramid().level_size(level)
    }

    /// Levels of the pyramid, down from one tile a view.
    pub(crate) fn levels(&self) -> usize {
        self.pyramid().levels()
    }

    /// The uniform for a capacity of nodes.
    pub(crate) fn grid(&self, node_capacity: u32, nodes_per_part: u32) -> TileGrid {
        let (level_offsets, _) = self.pyramid().offsets(0, 0);
        TileGrid {
            tiles: self.tiles,
            levels: self.levels() as u32,
            buckets: self.buckets,
            bounds_stride: (self.bounds_part_bytes() / 8) as u32,
            heads_stride: (self.heads_part_bytes() / 4) as u32,
            node_capacity,
            nodes_per_part,
            level_offsets,
        }
    }

    /// The views as shaders take them: their size counts tiles.
    pub(crate) fn uniforms(&self) -> Vec<ViewUniform> {
        let uniform = |view: &View| {
            let size = view.size.map(|edge| edge as f32 / self.tile_size as f32);
            ViewUniform { size, ..view_uniform(view) }
        };
        self.views.iter().map(uniform).collect()
    }

    /// Pairs of depth bounds of a view, all levels.
    fn bounds_of_view(&self) -> u64 {
        self.pyramid().offsets(0, 0).1
    }

    /// Heads of a view.
    pub(crate) fn heads_of_view(&self) -> u64 {
        let [across, down] = self.tiles.map(u64::from);
        across * down * u64::from(self.buckets)
    }

    /// Bytes of a view's part of the depth bounds, from its beginning to the next one's.
    pub(crate) fn bounds_part_bytes(&self) -> u64 {
        (self.bounds_of_view() * 8).next_multiple_of(PART_ALIGNMENT)
    }

    /// Bytes of a view's part of the heads, from its beginning to the next one's.
    pub(crate) fn heads_part_bytes(&self) -> u64 {
        (self.heads_of_view() * 4).next_multiple_of(PART_ALIGNMENT)
    }

    /// Bytes of the depth bounds with their mipmaps, allocated and used.
    pub(crate) fn bounds_bytes(&self) -> [u64; 2] {
        [self.bounds_part_bytes(), self.bounds_of_view() * 8].map(|bytes| bytes * self.views.len() as u64)
    }

    /// Bytes of the lists' heads, allocated and used.
    pub(crate) fn heads_bytes(&self) -> [u64; 2] {
        [self.heads_part_bytes(), self.heads_of_view() * 4].map(|bytes| bytes * self.views.len() as u64)
    }

    /// Bytes of the uniforms of a build, and of what deals triangles out, which are kept until it is done.
    pub(crate) fn build_bytes(&self, triangles: u32) -> u64 {
        let dealt = if self.raster_backend == RasterBackend::Compute { RasterWork::bytes(triangles, false) } else { 0 };
        let levels = (self.levels() - 1) * size_of::<MipmapLevel>();
        let setup = size_of::<SetupPass>() + MAX_VIEWS * size_of::<ViewUniform>();
        let uniforms = size_of::<TileGrid>() + setup + self.views.len() * size_of::<FillPass>() + levels;
        uniforms as u64 + self.views.len() as u64 * dealt
    }
}
