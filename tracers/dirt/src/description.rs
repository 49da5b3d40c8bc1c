//! The parameters of `dirt`.

use tracebench_api::ParameterScope::{Build, Trace};
use tracebench_api::{Parameter, TracerDescription, choice, parameters};
use tracebench_kit::{MemoryAccess, RasterBackend, build_parameter, memory_access_parameter, rays_per_lane_parameter};

choice! {
    /// Pixels along a tile's edge.
    pub(crate) enum TileSize { One = "1", Two = "2", Four = "4", Eight = "8" }
    /// Which views there are.
    pub(crate) enum Views { Six = "six", Frame = "frame" }
    /// Where the faces' centres lie.
    pub(crate) enum Centre { PulledBack = "pulled_back", Eye = "eye" }
    /// Where the near plane is.
    pub(crate) enum Near { Viewpoint = "viewpoint", None = "none" }
    /// Which tiles keep a triangle.
    pub(crate) enum Coverage { Conservative = "conservative", Standard = "standard" }
    /// What gives a triangle's depths in a tile.
    pub(crate) enum Clip { Polygon = "polygon", Plane = "plane" }
    /// Whether the camera's frame is drawn, too.
    pub(crate) enum DirectVisibility { Off = "off", On = "on" }
    /// Whether rays to the light are looked up in a shadow map.
    pub(crate) enum ShadowMap { Off = "off", On = "on" }
    /// When a hit counts.
    pub(crate) enum Accept { Tile = "tile", Distance = "distance" }
    /// Which buckets of a tile are searched.
    pub(crate) enum Searched { UntilHit = "until_hit", All = "all" }
    /// How a ray goes over the tiles of a view.
    pub(crate) enum March { HiZ = "hi-z", Tiles = "tiles" }
    /// How rays are walked that pass near a view's centre.
    pub(crate) enum CentreRays { Whole = "whole", Split = "split" }
    /// How what lies in a tile is stored.
    pub(crate) enum Lists { Linked = "linked", Packed = "packed", Slices = "sliced", Trees = "trees" }
    /// What depths the slices of packed lists span.
    pub(crate) enum Spacing { DepthRange = "depth_range", NearFar = "near_far" }
    /// In which order a tile's tree is walked.
    pub(crate) enum Order { Nearest = "nearest", Stored = "stored" }
    /// How surfaces are fetched.
    pub(crate) enum Fetching { Raster = "raster", Gather = "gather" }
}

parameters! {
    /// What `dirt` is told.
    pub(crate) struct DirtParameters {
        /// S, pixels of a view along a tile's edge: larger tiles store and build less and have longer lists
        tile_size: TileSize = Parameter::choice(Build, TileSize::Two).unit("pixels"),
        /// B, depth buckets of a tile: more have shorter lists, and more heads and copies
        buckets: u32 = Parameter::integer(Build, 1..=256, 24).sweep([1, 4, 8, 16, 24, 32, 40]),
        /// how what lies in a tile is stored: linked lists in buckets, by rasterization, as published; or exactly, in compute, six faces
        /// round the eye without near planes and masks of depth slices in the place of bounds and buckets, and parts of triangles in a row:
        /// packed, a tile's; sliced, those of each slice; trees, a tile's with a tree of boxes over them. Not linked, hits are accepted by
        /// distance and all else that is said of linked lists does not matter
        lists: Lists = Parameter::choice(Build, Lists::Linked).improved(Lists::Trees),
        /// tiles along a face's edge, of lists that are not linked (of linked ones it is tile_size): fewer have longer lists, more
        /// references, steps and bytes
        face_tiles: u32 = Parameter::integer(Build, 1..=256, 32).unit("tiles").sweep([16, 32, 64, 128]),
        /// depth slices of a tile's mask, of lists that are not linked: one tells only whether a tile is empty
        slices: u32 = Parameter::integer(Build, 1..=64, 64).sweep([1, 16, 64]),
        /// what the slices span, in steps of the logarithm: the depths that there are, or from near to far of the viewpoint
        spacing: Spacing = Parameter::choice(Build, Spacing::DepthRange),
        /// six cube faces, or the camera's view alone (Figure 9)
        views: Views = Parameter::choice(Build, Views::Six),
        /// where the faces' centres lie: pulled back by the near distance (VVP16, section 3.2), or in the eye, which loses what lies before
        /// near
        centre: Centre = Parameter::choice(Build, Centre::PulledBack).improved(Centre::Eye),
        /// the near plane: the viewpoint's, or as good as none (a proof's aid: 1e-15 of far)
        near: Near = Parameter::choice(Build, Near::Viewpoint).improved(Near::None),
        /// which tiles keep a triangle: all that it touches (section 4.1), or those whose centres it covers, which is meant for tile_size=1
        /// and loses what lies between centres
        coverage: Coverage = Parameter::choice(Build, Coverage::Conservative),
        /// a triangle's depths in a tile: those of the clipped polygon (section 4.1.1), or of its plane at the tile's corners, as in the
        /// released code: larger
        clip: Clip = Parameter::choice(Build, Clip::Polygon),
        /// whether the build also draws the surfaces that the camera's frame shows (section 4.1.3), where paths would begin; traces take
        /// rays from anywhere and do not use them
        direct_visibility: DirectVisibility = Parameter::choice(Build, DirectVisibility::Off),
        /// whether the build also draws a shadow map from the light outside of the scene; any-hit sets whose rays all end there are looked
        /// up in it in place of a trace (Figure 9), other sets are traced
        shadow_map: ShadowMap = Parameter::choice(Build, ShadowMap::Off),
        /// by how much a surface may lie behind what the shadow map shows and be lit all the same: small darkens lit surfaces that the map
        /// samples aslant, large lights what lies close behind others
        shadow_bias: f64 = Parameter::real(Trace, 0.0..=64.0, 2.0)
            .unit("texels of the map, where the surface is")
            .sweep([0.0, 0.5, 1.0, 2.0, 4.0, 8.0]),
        /// when a hit counts: where its tile is the one searched (Algorithm 1, line 14), which loses hits on borders, or by its distance
        /// alone (a proof's aid)
        accept: Accept = Parameter::choice(Trace, Accept::Tile).improved(Accept::Distance),
        /// buckets of a tile: up to the first with a hit (Algorithm 1, line 18), or all (a proof's aid)
        searched: Searched = Parameter::choice(Trace, Searched::UntilHit).improved(Searched::All),
        /// how a ray goes over the tiles of a view: up and down the pyramid of depth bounds (section 4.2.1), or from tile to tile by their
        /// own bounds, without the pyramid
        march: March = Parameter::choice(Trace, March::HiZ),
        /// rays that pass near a view's centre, where rounding hides their tile: walked like any other, or split there, with all that lies
        /// near the centre tested (a proof's aid)
        centre_rays: CentreRays = Parameter::choice(Trace, CentreRays::Whole).improved(CentreRays::Split),
        /// with lists=trees, nodes and parts of a tile from the ray's beginning to its end, or as they are stored, which is from the far
        /// end to the near one
        order: Order = Parameter::choice(Trace, Order::Nearest),
        /// how surfaces are fetched where a trace ends at them: by drawing the scene into every view once more and looking hits up at their
        /// pixels (sections 4.2.1, 4.2.2), which may lose some, or from the vertices by triangle
        fetch: Fetching = Parameter::choice(Trace, Fetching::Raster),
        /// cells of the pyramid, or tiles, after which a ray is given up with status step_cap, as one is that the driver's own limit of
        /// loops cuts off
        max_steps: u32 = Parameter::integer(Trace, 1..=1 << 20, 1 << 14)
            .unit("cells")
            .sweep([64, 256, 1024, 4096, 16_384]),
        build: RasterBackend = build_parameter(),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "dirt has no shape to keep: its lists are rebuilt or reused";

/// What `dirt` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "dirt",
        citation: "Vardis, Vasilakis, Papaioannou: DIRT: Deferred Image-based Ray Tracing, HPG 2016",
        summary: "lists of triangles in depth buckets of the tiles of six views, analytic hits",
        names_primitives: true,
        ..TracerDescription::of_views(NO_REFIT, DirtParameters::describe())
    }
}

impl TileSize {
    /// Pixels.
    pub(crate) fn pixels(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Four => 4,
            Self::Eight => 8,
        }
    }
}
