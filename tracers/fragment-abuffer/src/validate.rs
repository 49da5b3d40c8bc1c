//! The structure read back: its lists followed from both ends, and the fragments of pixels held against a rasterizer on the host.

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{Geometry, TracerError, View};
use tracebench_kit::{Allowed, AllowedFragments, Fragment, allowed_fragments};

use crate::clipped::{self, AllowedParts, Part as ClippedPart};
use crate::layout::{Layout, Storage};
use crate::parts::Part;
use crate::structure::{FragmentStructure, check_order};

/// Pixels of a view that are held against the host's rasterizer at most: every n-th along both axes.
const MAX_COMPARED: u64 = 4096;

/// Relative difference of a fragment's depth in two passes.
const PASS_SLACK: f32 = 4e-6;

/// A part's words, and how to read them.
struct ReadBack<'a> {
    layout: &'a Layout,
    storage: Storage,
    pixels: Vec<u32>,
    ids: Vec<u32>,
    data: Vec<u32>,
    /// Fragments stored.
    stored: u32,
    /// How often each node was met.
    met: Vec<u8>,
}

fn fail<T>(what: String) -> Result<T, TracerError> {
    Err(TracerError::Failed(what))
}

impl ReadBack<'_> {
    fn word(&self, pixel: u32, word: u32) -> u32 {
        self.pixels[(word * self.storage.pixel_count + pixel) as usize]
    }

    fn node_word(&self, node: u32, word: u32) -> u32 {
        self.ids[(node * self.storage.node_words + word) as usize]
    }

    fn depth(&self, node: u32) -> f32 {
        f32::from_bits(self.node_word(node, 0))
    }

    /// Near and far of a pixel's depth bounds; `None` where there are none.
    fn bounds(&self, pixel: u32) -> Option<[f32; 2]> {
        let word = self.storage.bounds_word;
        let codes = [self.word(pixel, word), self.word(pixel, word + 1)];
        (codes[1] != 0).then(|| [f32::from_bits(!codes[0]), f32::from_bits(codes[1])])
    }

    fn payload(&self, node: u32) -> [u32; 4] {
        let moved = self.layout.kind.is_contiguous() && self.layout.decoupled;
        let data = if moved { self.node_word(node, 1) } else { node };
        let at = (data * self.storage.data_words + self.storage.data_offset) as usize;
        std::array::from_fn(|word| self.data.get(at + word).copied().unwrap_or_default())
    }

    /// A node's greatest depth; its depth where it is a point.
    fn greatest(&self, node: u32) -> f32 {
        match self.storage.plane_word {
            0 => self.depth(node),
            word => f32::from_bits(self.node_word(node, word)),
        }
    }

    fn part(&self, node: u32) -> ClippedPart {
        let [x, y, z, material] = self.payload(node);
        let word = self.storage.plane_word;
        ClippedPart {
            depths: [self.depth(node), self.greatest(node)],
            normal: Vec3::from([x, y, z].map(f32::from_bits)),
            offset: (word > 0).then(|| f32::from_bits(self.node_word(node, word + 1))),
            outline: self.layout.masked.then(|| self.node_word(node, word + 2)),
            material,
        }
    }

    /// A node as a fragment at the pixel's centre, along this line of eye depth 1 from the eye: of a plane, where the line meets it within
    /// its depths.
    fn fragment(&self, node: u32, line: DVec3) -> Fragment {
        let ClippedPart { depths: [least, greatest], normal, offset, material, .. } = self.part(node);
        let depth = match offset.map(|offset| f64::from(offset) / normal.as_dvec3().dot(line)) {
            // A plane along the line, or beside it.
            Some(depth) if depth.is_nan() || depth <= 0.0 => greatest,
            Some(depth) => (depth as f32).clamp(least, greatest),
            None => least,
        };
        Fragment { depth, normal, material }
    }

    /// A plane's normal is the one that searches read.
    fn check_plane(&self, node: u32) -> Result<(), TracerError> {
        let (word, data) = (self.storage.plane_word, self.payload(node));
        let differs =
            || (0..3).any(|axis| self.node_word(node, self.storage.normal_word + axis) != data[axis as usize]);
        if word > 0 && (differs() || self.greatest(node) < self.depth(node)) {
            return fail(format!("node {node} has another plane than its data, or ends before it begins"));
        }
        Ok(())
    }

    /// The nodes of a list by its next links, each met once; checks the previous links and the tail against them.
    fn follow(&mut self, pixel: u32, bucket: u32) -> Result<Vec<u32>, TracerError> {
        let mut nodes = Vec::new();
        let mut link = self.word(pixel, bucket);
        while link != 0 {
            let node = link - 1;
            if node >= self.stored || self.met[node as usize] > 0 {
                return fail(format!("node {node} of pixel {pixel} does not exist or lies in two lists"));
            }
            self.met[node as usize] = 1;
            if self.storage.double == 1 {
                let previous = nodes.last().map_or(0, |node| node + 1);
                if self.node_word(node, 2) != previous {
                    return fail(format!("node {node} of pixel {pixel} is not linked back to the one before it"));
                }
            }
            nodes.push(node);
            link = self.node_word(node, 1);
        }
        let tail = nodes.last().map_or(0, |node| node + 1);
        if self.storage.double == 1 && self.word(pixel, self.storage.buckets + bucket) != tail {
            return fail(format!("the tail of pixel {pixel}, bucket {bucket}, is not the end of its list"));
        }
        Ok(nodes)
    }

    fn piece(&mut self, pixel: u32) -> Result<Vec<u32>, TracerError> {
        let (begin, count) = (self.word(pixel, 0), self.word(pixel, 1));
        for node in begin..begin + count {
            if node >= self.stored || self.met[node as usize] > 0 {
                return fail(format!("node {node} of pixel {pixel} does not exist or lies in two pieces"));
            }
            self.met[node as usize] = 1;
        }
        Ok((begin..begin + count).collect())
    }

    /// Whether a node may stand behind the first one of the same depth.
    fn may_follow(&self, first: u32, node: u32) -> bool {
        self.storage.plane_word > 0 || self.payload(node) >= self.payload(first)
    }

    /// The nodes of a pixel by depth; checks that they stand in that order, of points of equal depths the least payload first, in the
    /// buckets of their depths, within the bounds.
    fn nodes_of(&mut self, pixel: u32) -> Result<Vec<u32>, TracerError> {
        let mut nodes = Vec::new();
        if self.storage.contiguous == 1 {
            nodes = self.piece(pixel)?;
        } else {
            for bucket in 0..self.storage.buckets {
                let list = self.follow(pixel, bucket)?;
                if let (Some(bounds), true) = (self.bounds_of(pixel), self.storage.buckets > 1) {
                    for node in &list {
                        check_bucket(self.depth(*node), bounds, bucket, self.storage.buckets)?;
                    }
                }
                nodes.extend(list);
            }
        }
        let mut first = None;
        for node in &nodes {
            let depth = self.depth(*node).to_bits();
            match first {
                Some((leader, at)) if depth == at && self.may_follow(leader, *node) => {}
                Some((_, at)) if depth <= at => {
                    return fail(format!("node {node} of pixel {pixel} is out of the order of depths"));
                }
                _ => first = Some((*node, depth)),
            }
        }
        nodes.iter().try_for_each(|node| self.check_plane(*node))?;
        if self.storage.bounds_word > 0 {
            self.check_bounds(pixel, &nodes)?;
        }
        Ok(nodes)
    }

    fn bounds_of(&self, pixel: u32) -> Option<[f32; 2]> {
        if self.storage.bounds_word > 0 { self.bounds(pixel) } else { None }
    }

    fn check_bounds(&self, pixel: u32, nodes: &[u32]) -> Result<(), TracerError> {
        let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else { return Ok(()) };
        let Some([near, far]) = self.bounds(pixel) else {
            return fail(format!("pixel {pixel} has fragments and no depth bounds"));
        };
        let greatest = nodes.iter().map(|node| self.greatest(*node)).fold(self.depth(*last), f32::max);
        let least = self.depth(*first);
        let encloses = near <= least * (1.0 + PASS_SLACK) && far >= greatest * (1.0 - PASS_SLACK);
        // Boxes are looser, and a single layer leaves out what is far.
        let tight =
            near >= least * (1.0 - PASS_SLACK) && (self.layout.one_layer || far <= greatest * (1.0 + PASS_SLACK));
        if encloses && (tight || self.layout.by_boxes) {
            return Ok(());
        }
        fail(format!("pixel {pixel} has bounds from {near} to {far} and fragments from {least} to {greatest}"))
    }
}

/// A fragment lies in the bucket of its depth, or where rounding may decide in the next one.
fn check_bucket(depth: f32, [near, far]: [f32; 2], bucket: u32, buckets: u32) -> Result<(), TracerError> {
    let (near, far, depth) = (f64::from(near), f64::from(far), f64::from(depth));
    let share = if far > near { ((depth - near) / (far - near)).clamp(0.0, 1.0) } else { 0.0 };
    let at = share * f64::from(buckets);
    let slack = 1e-4 + f64::from(buckets) * 1e-6 * depth / (far - near).max(1e-30);
    let [low, high] = [at - slack, at + slack].map(|at| at.floor().clamp(0.0, f64::from(buckets - 1)) as u32);
    if (low..=high).contains(&bucket) {
        return Ok(());
    }
    fail(format!("a fragment of depth {depth} lies in bucket {bucket} of {buckets} from {near} to {far}"))
}

/// What following all lists tells.
#[derive(Default)]
struct Layers {
    pixels: u64,
    covered: u64,
    fragments: u64,
    most: usize,
    compared: u64,
}

impl FragmentStructure {
    pub(crate) fn check(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let taken = self.parts.taken(gpu)?;
        check_order(&taken)?;
        let mut layers = Layers::default();
        for (part, taken) in self.parts.parts.iter().zip(&taken) {
            if taken.fragments > part.capacity {
                return fail(format!("{} fragments and room for {}", taken.fragments, part.capacity));
            }
            let read = |buffer: &tracebench_api::wgpu::Buffer| -> Result<Vec<u32>, TracerError> {
                Ok(bytemuck::pod_collect_to_vec(&gpu.read(buffer, buffer.size())?))
            };
            let ids = read(&part.ids)?;
            let mut back = ReadBack {
                layout: &self.layout,
                storage: self.layout.storage(part.pixel_count, part.capacity),
                pixels: read(&part.pixels)?,
                data: part.payloads.as_ref().map_or_else(|| Ok(ids.clone()), read)?,
                ids,
                stored: taken.fragments,
                met: vec![0; taken.fragments as usize],
            };
            self.check_part(geometry, part, &mut back, &mut layers)?;
            if let Some(node) = back.met.iter().position(|met| *met == 0) {
                return fail(format!("node {node} lies in no list"));
            }
        }
        let average = layers.fragments as f64 / (layers.covered as f64).max(1.0);
        Ok(vec![
            ("fragments", layers.fragments as f64),
            ("pixels", layers.pixels as f64),
            ("covered_pixels", layers.covered as f64),
            ("average_layers", average),
            ("maximum_layers", layers.most as f64),
            ("compared_pixels", layers.compared as f64),
        ])
    }

    fn check_part(
        &self,
        geometry: &Geometry,
        part: &Part,
        back: &mut ReadBack<'_>,
        layers: &mut Layers,
    ) -> Result<(), TracerError> {
        for (view, first_pixel) in part.views.clone().zip(&part.first_pixels) {
            let [width, height] = self.layout.views[view].size;
            let step = (1..).find(|step| self.layout.pixels_of(view) / (step * step) <= MAX_COMPARED).unwrap_or(1);
            let step = step as u32;
            let expected = Expected::new(self, &self.layout.views[view], geometry, step)?;
            for y in 0..height {
                for x in 0..width {
                    let nodes = back.nodes_of(first_pixel + y * width + x)?;
                    layers.pixels += 1;
                    layers.covered += u64::from(!nodes.is_empty());
                    layers.fragments += nodes.len() as u64;
                    layers.most = layers.most.max(nodes.len());
                    if x % step == 0 && y % step == 0 {
                        let context = |what| format!("view {view}, pixel {x}, {y}: {what}");
                        expected
                            .check(back, &nodes, [x, y], self.layout.one_layer)
                            .map_err(|what| TracerError::Failed(context(what)))?;
                        layers.compared += 1;
                    }
                }
            }
        }
        Ok(())
    }
}

/// What the pixels of a view are held against.
enum Expected<'a> {
    /// By samples, with the view.
    Sampled(AllowedFragments, &'a View),
    Clipped(AllowedParts),
}

impl<'a> Expected<'a> {
    fn new(of: &FragmentStructure, view: &'a View, geometry: &Geometry, step: u32) -> Result<Self, TracerError> {
        if of.layout.conservative {
            return Ok(Self::Clipped(AllowedParts::new(view, geometry, step, of.layout.masked)));
        }
        let border = of.layout.raster_backend.undecided_border(&of.pipelines.gpu)?;
        Ok(Self::Sampled(allowed_fragments(view, geometry, step, border), view))
    }

    fn check(&self, back: &ReadBack<'_>, nodes: &[u32], [x, y]: [u32; 2], one_layer: bool) -> Result<(), String> {
        match self {
            Self::Sampled(allowed, view) => {
                let line = view.direction_through(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let stored: Vec<Fragment> = nodes.iter().map(|node| back.fragment(*node, line)).collect();
                compare(&stored, allowed.of([x, y]), one_layer)
            }
            Self::Clipped(allowed) => {
                let stored: Vec<ClippedPart> = nodes.iter().map(|node| back.part(*node)).collect();
                clipped::compare(&stored, allowed.of([x, y]), one_layer)
            }
        }
    }
}

/// Holds the fragments of a pixel against those that may and those that must be there.
pub(crate) fn compare(stored: &[Fragment], allowed: &[Allowed], one_layer: bool) -> Result<(), String> {
    if let Some(fragment) = stored.iter().find(|fragment| !allowed.iter().any(|each| each.fits(fragment))) {
        return Err(format!("no triangle gives {fragment:?}"));
    }
    if stored.len() > allowed.len() {
        return Err(format!("{} fragments, {} triangles may give one", stored.len(), allowed.len()));
    }
    if one_layer {
        // What lies surely before the nearest fragment is missing.
        let nearest = stored.first().map_or(f64::INFINITY, |fragment| f64::from(fragment.depth));
        let nearer = allowed.iter().find(|each| each.must && each.depths[1] < nearest);
        return nearer.map_or(Ok(()), |each| Err(format!("{each:?} is nearer than {nearest}")));
    }
    let mut required = allowed.iter().filter(|each| each.must);
    if let Some(missing) = required.clone().find(|each| !stored.iter().any(|fragment| each.fits(fragment))) {
        return Err(format!("{missing:?} is not stored"));
    }
    let least = required.by_ref().count();
    if stored.len() < least { Err(format!("{} fragments instead of {least}", stored.len())) } else { Ok(()) }
}
