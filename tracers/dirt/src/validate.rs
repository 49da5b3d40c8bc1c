//! Reading the structure back: lists, pyramid, and what is stored against brute force in f64.
//!
//! What is stored must lie between what brute force finds for tiles shrunk and grown by the stated rounding: tiles are
//! grown by [`tile_margin`] when they are filled, and the device may be wrong by half of that, and by what f32 loses of
//! the triangle's coordinates. A triangle with an edge through a view's centre is left out there: its projection is noise.
//! Of large scenes every n-th triangle is looked at.

use tracebench_api::glam::{DVec2, DVec3};
use tracebench_api::{Geometry, TracerError, View};
use tracebench_kit::{TileBounds, clipped_depths, eye_space, touched_tiles};

use crate::layout::Layout;
use crate::statistics::TileStatistics;
use crate::structure::{DirtStructure, taken};

/// Parts of triangles that are compared with brute force, about.
const COMPARED_PARTS: u64 = 50_000;

/// As `DEPTH_SLACK` in shaders/dirt/fill.wgsl.
const DEPTH_SLACK: f64 = 9.536_743_164_062_5e-7;

/// By how much a border may be off in the rasterizer's sample rule, beside what the device snaps, tiles: positions of corners are f32.
const SAMPLE_SLACK_TILES: f64 = 1.0 / 64.0;

/// As `tile_margin` in shaders/shared/tile_clip.wgsl, in tiles.
pub fn tile_margin(tiles: [f64; 2]) -> f64 {
    9.765_625e-4 + tiles[0].max(tiles[1]) * 4.768_371_58e-7
}

/// A structure in host memory.
struct ReadBack {
    /// Depth bounds: codes, all views and levels.
    codes: Vec<[u32; 2]>,
    heads: Vec<u32>,
    nodes: Vec<[u32; 2]>,
}

/// A triangle in a tile, and the buckets whose lists hold it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Stored {
    primitive: u32,
    view: u32,
    tile: u32,
    bucket: u32,
}

fn wrong(what: String) -> TracerError {
    TracerError::Failed(what)
}

/// Near and far depth of a pair of codes; none for nothing.
fn depths(codes: [u32; 2]) -> Option<[f64; 2]> {
    let depth = |code: u32| f64::from(f32::from_bits(code));
    (codes != [0, 0]).then(|| [depth(!codes[0]), depth(codes[1])])
}

/// As `bucket_of` in shaders/dirt/grid.wgsl, of real depths: with the fraction, to tell how near a border it is.
fn bucket_position(depth: f64, [near, far]: [f64; 2], buckets: u32) -> f64 {
    if far <= near {
        return 0.0;
    }
    ((depth - near) / (far - near)).clamp(0.0, 1.0) * f64::from(buckets)
}

impl DirtStructure {
    fn read_back(&self) -> Result<ReadBack, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let nodes = taken(gpu, &self.buffers)?;
        if nodes > self.buffers.node_capacity {
            return Err(wrong(format!("{nodes} nodes were needed, there is room for {}", self.buffers.node_capacity)));
        }
        Ok(ReadBack {
            codes: bytemuck::pod_collect_to_vec(&gpu.read(&self.buffers.bounds, self.buffers.bounds.size())?),
            heads: self.read_heads()?,
            nodes: self.read_nodes(nodes as usize)?,
        })
    }

    /// The heads of every view, without what lies between views.
    fn read_heads(&self) -> Result<Vec<u32>, TracerError> {
        let all: Vec<u32> =
            bytemuck::pod_collect_to_vec(&self.pipelines.gpu.read(&self.buffers.heads, self.buffers.heads.size())?);
        let parts = all.chunks(self.layout.heads_part_bytes() as usize / 4);
        Ok(parts.flat_map(|part| &part[..self.layout.heads_of_view() as usize]).copied().collect())
    }

    fn read_nodes(&self, count: usize) -> Result<Vec<[u32; 2]>, TracerError> {
        let mut nodes: Vec<[u32; 2]> = Vec::with_capacity(count);
        for part in &self.buffers.nodes {
            nodes.extend(bytemuck::pod_collect_to_vec::<u8, [u32; 2]>(&self.pipelines.gpu.read(part, part.size())?));
        }
        nodes.truncate(count);
        Ok(nodes)
    }

    pub(crate) fn check(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let read = self.read_back()?;
        check_pyramid(&self.layout, &read.codes)?;
        let (statistics, longest) = self.tiles(geometry, &read)?;
        let step = (statistics.parts / COMPARED_PARTS).max(1) as u32;
        self.compare(geometry, &read, &stored(&self.layout, &read, step)?, step)?;
        let stride = self.layout.grid(0, 1).bounds_stride as usize;
        let of_view = self.layout.tiles[0] as usize * self.layout.tiles[1] as usize;
        let level_zero = read.codes.chunks(stride).flat_map(|view| &view[..of_view]);
        let bounded = level_zero.filter(|codes| depths(**codes).is_some()).count() as u64;
        if bounded != statistics.occupied_tiles {
            return Err(wrong(format!("{bounded} tiles have depths, {} have lists", statistics.occupied_tiles)));
        }
        let lists = read.heads.iter().filter(|head| **head != 0).count();
        let references = read.nodes.len() as f64;
        let mut named = vec![
            ("references", references),
            ("lists", lists as f64),
            ("mean_list_length", references / lists.max(1) as f64),
            ("longest_list", longest as f64),
        ];
        named.extend(statistics.named(self.layout.buckets));
        Ok(named)
    }

    /// Follows every list; what tiles hold, and the longest list's length.
    fn tiles(&self, geometry: &Geometry, read: &ReadBack) -> Result<(TileStatistics, usize), TracerError> {
        let count = geometry.triangles.len() as u32;
        if let Some([_, unknown]) = read.nodes.iter().find(|[_, primitive]| *primitive >= count) {
            return Err(wrong(format!("a node is of triangle {unknown}, there are {count}")));
        }
        let buckets = self.layout.buckets;
        let (mut statistics, mut tile, mut held) = (TileStatistics::default(), 0, Vec::new());
        let longest = walk_lists(read, |list, primitive| {
            let of_list = list / buckets as usize;
            if of_list != tile {
                statistics.add_tile(&mut held, geometry, buckets);
                held.clear();
                tile = of_list;
            }
            held.push(primitive);
        })?;
        statistics.add_tile(&mut held, geometry, buckets);
        Ok((statistics, longest))
    }

    /// The stored parts of every `step`-th triangle against brute force.
    fn compare(&self, geometry: &Geometry, read: &ReadBack, stored: &[Stored], step: u32) -> Result<(), TracerError> {
        let layout = &self.layout;
        let stride = layout.grid(0, 1).bounds_stride as usize;
        let edge = f64::from(layout.tile_size);
        let sample_slack = SAMPLE_SLACK_TILES + layout.raster_backend.border_pixels(&self.pipelines.gpu)?;
        for primitive in (0..geometry.triangles.len() as u32).step_by(step as usize) {
            let begin = stored.partition_point(|each| each.primitive < primitive);
            let end = stored.partition_point(|each| each.primitive <= primitive);
            let mut rest = &stored[begin..end];
            let corners = geometry.corners(primitive).map(|corner| corner.as_dvec3());
            for (index, view) in layout.views.iter().enumerate() {
                let count = rest.partition_point(|each| each.view as usize <= index);
                let (of_view, after) = rest.split_at(count);
                rest = after;
                let triangle = corners.map(|corner| eye_space(view, corner));
                let checked = Checked { view, layout, triangle, standard: !self.filling.conservative, sample_slack };
                let codes = &read.codes[index * stride..];
                if checked.meets_centre() {
                    continue;
                }
                checked.view(primitive, of_view, codes, edge, self.filling.by_plane, step == 1)?;
            }
        }
        Ok(())
    }
}

/// One triangle in one view.
struct Checked<'a> {
    view: &'a View,
    layout: &'a Layout,
    triangle: [DVec3; 3],
    standard: bool,
    /// By how much a border may be off in the rasterizer's sample rule, tiles.
    sample_slack: f64,
}

impl Checked<'_> {
    /// What f32 may lose of the triangle's coordinates, scene units.
    fn coordinate_loss(&self) -> f64 {
        let size = |point: &DVec3| (*point + self.view.eye.abs()).abs().max_element().max(point.abs().max_element());
        self.triangle.iter().map(size).fold(self.view.eye.abs().max_element(), f64::max) * 2.0_f64.powi(-21)
    }

    /// Whether an edge passes the view's centre within what f32 may be wrong by: what tiles it covers is noise then.
    fn meets_centre(&self) -> bool {
        let [a, b, c] = self.triangle;
        let distance = |from: DVec3, to: DVec3| {
            let along = to - from;
            let share = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
            (from + along * if share.is_nan() { 0.0 } else { share }).length()
        };
        [distance(a, b), distance(b, c), distance(c, a)].into_iter().any(|near| near < 64.0 * self.coordinate_loss())
    }

    /// How far a border may be off, tiles, for what lies at least `depth` deep.
    fn border_loss(&self, depth: f64, edge: f64) -> f64 {
        let tangent = self.view.tan_half_width.min(self.view.tan_half_height);
        let tiles = f64::from(self.view.size[0].max(self.view.size[1])) / edge;
        self.coordinate_loss() / depth.max(self.view.near) * tiles / (2.0 * tangent)
    }

    fn view(
        &self,
        primitive: u32,
        of_view: &[Stored],
        codes: &[[u32; 2]],
        edge: f64,
        by_plane: bool,
        complete: bool,
    ) -> Result<(), TracerError> {
        let tiles = self.layout.tiles;
        let size = self.view.size.map(|pixels| f64::from(pixels) / edge);
        let margin = tile_margin(size);
        let touched = touched_tiles(self.view, tiles, edge, 2.0, self.triangle);
        let mut seen = 0;
        for [x, y] in touched
            .into_iter()
            .flat_map(|[low, high]| (low[1]..=high[1]).flat_map(move |y| (low[0]..=high[0]).map(move |x| [x, y])))
        {
            let number = y * tiles[0] + x;
            let begin = of_view.partition_point(|each| each.tile < number);
            let end = of_view.partition_point(|each| each.tile <= number);
            let entries = &of_view[begin..end];
            seen += entries.len();
            let grown_by = |loss: f64| {
                clipped_depths(self.view, TileBounds::of_tile([x, y], edge, 1.5 * margin + loss), self.triangle)
            };
            let loss = grown_by(0.0)
                .map_or(self.border_loss(self.view.near, edge), |[least, _]| self.border_loss(least, edge));
            let grown = grown_by(loss);
            let shrunk_tile = TileBounds::of_tile([x, y], edge, 0.5 * margin - loss);
            let shrunk = if loss < 0.25 { clipped_depths(self.view, shrunk_tile, self.triangle) } else { None };
            let place = || format!("triangle {primitive} in tile {x}, {y} of a view along {}", self.view.forward);
            let (must, may) = if self.standard {
                (self.covers_centre([x, y], edge, loss), self.touches_centre([x, y], edge, loss))
            } else {
                (shrunk.is_some(), grown.is_some())
            };
            if must && entries.is_empty() {
                return Err(wrong(format!("{} is not stored", place())));
            }
            if !may && !entries.is_empty() {
                return Err(wrong(format!("{} is stored and does not touch it", place())));
            }
            let Some(bounds) = depths(codes[number as usize]) else {
                if entries.is_empty() {
                    continue;
                }
                return Err(wrong(format!("{} is stored, but the tile's depth bounds are empty", place())));
            };
            if entries.is_empty() {
                continue;
            }
            let contiguous = entries.windows(2).all(|pair| pair[1].bucket == pair[0].bucket + 1);
            if !contiguous {
                return Err(wrong(format!("{} has gaps between its buckets, or stands in one twice", place())));
            }
            let slack = |depth: f64| depth * 2.0 * DEPTH_SLACK + self.coordinate_loss();
            if let Some([least, greatest]) = shrunk {
                if bounds[0] > least + slack(least) || bounds[1] < greatest - slack(greatest) {
                    return Err(wrong(format!(
                        "{} lies outside of the tile's depth bounds: {least} to {greatest}, they are {bounds:?}",
                        place()
                    )));
                }
                let first = bucket_position(least + slack(least), bounds, self.layout.buckets).floor();
                let last = bucket_position(greatest - slack(greatest), bounds, self.layout.buckets).ceil() - 1.0;
                let held = [entries[0].bucket, entries[entries.len() - 1].bucket].map(f64::from);
                if held[0] > first || held[1] < last.min(f64::from(self.layout.buckets) - 1.0) {
                    return Err(wrong(format!(
                        "{} is missing from a bucket that it overlaps: in {held:?}, must be in {first} to {last}",
                        place()
                    )));
                }
            }
            if let (Some([least, greatest]), true) = (grown, complete && !by_plane) {
                let range = (bounds[1] - bounds[0]).max(f64::MIN_POSITIVE);
                let room =
                    1e-6 * f64::from(self.layout.buckets) + slack(greatest) / range * f64::from(self.layout.buckets);
                let first = (bucket_position(least - slack(least), bounds, self.layout.buckets) - room).floor();
                let last = (bucket_position(greatest + slack(greatest), bounds, self.layout.buckets) + room).floor();
                let held = [entries[0].bucket, entries[entries.len() - 1].bucket].map(f64::from);
                if held[0] < first || held[1] > last {
                    return Err(wrong(format!(
                        "{} is in a bucket that it does not overlap: in {held:?}, may be in {first} to {last}",
                        place()
                    )));
                }
            }
        }
        if seen < of_view.len() {
            return Err(wrong(format!("triangle {primitive} is stored in tiles that it does not come near")));
        }
        Ok(())
    }

    /// The corners of a box round a tile's centre, as directions in eye space of depth 1.
    fn centre_box(&self, [x, y]: [u32; 2], edge: f64, loss: f64) -> TileBounds {
        let half = DVec2::splat(self.sample_slack + loss);
        let centre = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        TileBounds { low: (centre - half) * edge, high: (centre + half) * edge }
    }

    fn touches_centre(&self, tile: [u32; 2], edge: f64, loss: f64) -> bool {
        clipped_depths(self.view, self.centre_box(tile, edge, loss), self.triangle).is_some()
    }

    /// Whether the whole box is covered between near and far.
    fn covers_centre(&self, tile: [u32; 2], edge: f64, loss: f64) -> bool {
        let bounds = self.centre_box(tile, edge, loss);
        let [a, b, c] = self.triangle;
        let normal = (b - a).cross(c - a);
        let sides = [b.cross(c), c.cross(a), a.cross(b)];
        let size = DVec2::new(f64::from(self.view.size[0]), f64::from(self.view.size[1]));
        let tangents = DVec2::new(self.view.tan_half_width, -self.view.tan_half_height);
        [[0, 0], [0, 1], [1, 0], [1, 1]].into_iter().all(|[right, lower]: [usize; 2]| {
            let ends = [bounds.low, bounds.high];
            let at = (DVec2::new(ends[right].x, ends[lower].y) * 2.0 / size - 1.0) * tangents;
            let line = at.extend(1.0);
            let products = sides.map(|side| side.dot(line));
            let depth = normal.dot(a) / normal.dot(line);
            let pierced = products.iter().all(|each| *each > 0.0) || products.iter().all(|each| *each < 0.0);
            let slack = self.coordinate_loss() + depth.abs() * 1e-5;
            pierced && depth > self.view.near + slack && depth < self.view.far - slack
        })
    }
}

/// Every level's tile bounds exactly the four below it.
fn check_pyramid(layout: &Layout, codes: &[[u32; 2]]) -> Result<(), TracerError> {
    let grid = layout.grid(0, 1);
    for (index, view) in codes.chunks(grid.bounds_stride as usize).enumerate() {
        for level in 1..layout.levels() {
            let ([across, down], [below_across, below_down]) =
                (layout.level_tiles(level), layout.level_tiles(level - 1));
            let below = &view[grid.level_offsets[level - 1] as usize..];
            for (x, y) in (0..down).flat_map(|y| (0..across).map(move |x| (x, y))) {
                let mut expected = [0; 2];
                for (child_x, child_y) in [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| (2 * x + i, 2 * y + j)) {
                    if child_x < below_across && child_y < below_down {
                        let child = below[(child_y * below_across + child_x) as usize];
                        expected = [expected[0].max(child[0]), expected[1].max(child[1])];
                    }
                }
                if view[(grid.level_offsets[level] + y * across + x) as usize] != expected {
                    return Err(wrong(format!(
                        "the mipmap of depth bounds is wrong: view {index}, level {level}, {x}, {y}"
                    )));
                }
            }
        }
    }
    Ok(())
}

/// Follows every list, one after the other, to tell its number and the primitives in it; gives the longest list's length.
fn walk_lists(read: &ReadBack, mut visit: impl FnMut(usize, u32)) -> Result<usize, TracerError> {
    let mut reached = vec![false; read.nodes.len()];
    let mut longest = 0;
    for (list, &head) in read.heads.iter().enumerate() {
        let (mut link, mut length) = (head, 0);
        while link != 0 {
            let seen = reached.get_mut(link as usize - 1);
            let seen = seen.ok_or_else(|| wrong(format!("list {list} leads to node {link}, which does not exist")))?;
            if std::mem::replace(seen, true) {
                return Err(wrong(format!("node {link} is reached twice")));
            }
            let [next, primitive] = read.nodes[link as usize - 1];
            visit(list, primitive);
            (link, length) = (next, length + 1);
        }
        longest = longest.max(length);
    }
    match reached.iter().position(|seen| !seen) {
        Some(lost) => Err(wrong(format!("node {} is in no list", lost + 1))),
        None => Ok(longest),
    }
}

/// What is stored of every `step`-th triangle, in order.
fn stored(layout: &Layout, read: &ReadBack, step: u32) -> Result<Vec<Stored>, TracerError> {
    let lists_of_view = read.heads.len() / layout.views.len();
    let mut stored = Vec::new();
    walk_lists(read, |list, primitive| {
        if primitive % step == 0 {
            let within = (list % lists_of_view) as u32;
            stored.push(Stored {
                primitive,
                view: (list / lists_of_view) as u32,
                tile: within / layout.buckets,
                bucket: within % layout.buckets,
            });
        }
    })?;
    stored.sort_unstable();
    Ok(stored)
}
