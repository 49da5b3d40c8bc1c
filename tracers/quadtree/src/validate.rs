//! The structure read back: layers held against a rasterizer on the host, every node against those below it.

use tracebench_api::glam::{DVec2, Vec3};
use tracebench_api::{Geometry, TracerError};
use tracebench_kit::{Allowed, Fragment, allowed_fragments};

use crate::description::{Dilated, DistanceIn};
use crate::images::Images;
use crate::layout::{Forest, Shape};
use crate::nodes::{Node, Plane, STEPS};
use crate::structure::QuadtreeStructure;

/// Pixels of a view that are held against the host's rasterizer at most: every n-th along both axes.
const MAX_COMPARED: u64 = 4096;

/// Share of z by which the device's f32 may be off.
const ROUNDING: f64 = 4e-6;

/// Share of a plane's change over a node by which the device's may be off: a stored normal's third component is the root of
/// what is left of 1, and devices round divisions and roots as they like within a few ulps.
const SLOPE_ROUNDING: f64 = 1e-6;

const BY_LEVEL: [[&str; 2]; 10] = [
    ["plane_leaves_level_0", "empty_leaves_level_0"],
    ["plane_leaves_level_1", "boxes_level_1"],
    ["plane_leaves_level_2", "boxes_level_2"],
    ["plane_leaves_level_3", "boxes_level_3"],
    ["plane_leaves_level_4", "boxes_level_4"],
    ["plane_leaves_level_5", "boxes_level_5"],
    ["plane_leaves_level_6", "boxes_level_6"],
    ["plane_leaves_level_7", "boxes_level_7"],
    ["plane_leaves_level_8", "boxes_level_8"],
    ["plane_leaves_level_9", "boxes_level_9"],
];

const COVERED: [&str; 4] =
    ["covered_pixels", "covered_pixels_layer_2", "covered_pixels_layer_3", "covered_pixels_layer_4"];

fn fail<T>(what: String) -> Result<T, TracerError> {
    Err(TracerError::Failed(what))
}

/// What was read back of a structure.
struct ReadBack<'a> {
    shape: &'a Shape,
    forest: Forest,
    codes: Vec<u32>,
    names: Vec<u32>,
    payloads: [Vec<u32>; 2],
    nodes: Vec<[u32; 2]>,
}

/// What following all trees tells.
#[derive(Default)]
struct Counts {
    covered: [u64; 4],
    /// Leaves that are planes, and boxes (of level 0 pixels that show nothing), that a walk can reach.
    by_level: [[u64; 2]; 10],
    empty: u64,
    flagged: u64,
    compared: u64,
    /// `gamma_dist` in pixel heights at the first layer's depths.
    gammas: Vec<f64>,
}

impl ReadBack<'_> {
    fn pixels(&self) -> usize {
        self.shape.pixels() as usize
    }

    fn node(&self, image: usize, level: u32, [x, y]: [u32; 2]) -> Node {
        let [width, _] = self.shape.level_size(level);
        let first = self.forest.level_offsets[level as usize] as usize;
        let index = image * self.forest.image_nodes as usize + first + y as usize * width as usize + x as usize;
        Node::of(self.nodes[index], self.shape.size())
    }

    /// Eye depth of a pixel of an image; none where it shows nothing.
    fn depth(&self, image: usize, pixel: usize) -> Option<f32> {
        let code = self.codes[image * self.pixels() + pixel];
        (code != 0).then(|| f32::from_bits(!code))
    }

    fn z_of_depth(&self, depth: f32) -> f64 {
        let Forest { z_scale, z_shift, .. } = self.forest;
        (f64::from(z_scale) / f64::from(depth) - f64::from(z_shift)).clamp(0.0, 1.0)
    }

    /// By how much z may be off.
    fn rounding(&self, z: f64) -> f64 {
        ROUNDING * (z + f64::from(self.forest.z_shift))
    }

    fn fragment(&self, view: usize, layer: u32, pixel: usize) -> Option<Fragment> {
        let depth = self.depth(view * self.shape.layers as usize + layer as usize, pixel)?;
        let which = layer as usize % 2;
        let layers = (self.shape.layers as usize + 1 - which) / 2;
        let at = 4 * ((view * layers + layer as usize / 2) * self.pixels() + pixel);
        let word = |index: usize| self.payloads[which][at + index];
        Some(Fragment {
            depth,
            normal: Vec3::from([0, 1, 2].map(|axis| f32::from_bits(word(axis)))),
            material: word(3),
        })
    }

    /// The layers of a pixel of a view, the nearest first; checks that they follow each other and have triangles.
    fn layers(&self, view: usize, pixel: usize, triangles: u32) -> Result<Vec<Fragment>, TracerError> {
        let mut found: Vec<Fragment> = Vec::new();
        for layer in 0..self.shape.layers {
            let image = view * self.shape.layers as usize + layer as usize;
            let name = self.names[image * self.pixels() + pixel];
            let here = self.fragment(view, layer, pixel);
            if here.is_some() != (name != 0) || (name != 0 && !name >= triangles) {
                return fail(format!(
                    "layer {layer} of pixel {pixel}, view {view}, is of no triangle, or of one without it"
                ));
            }
            let Some(here) = here else { continue };
            if found.len() != layer as usize {
                return fail(format!("pixel {pixel} of view {view} has layer {layer} and lacks one before"));
            }
            let behind = |before: &Fragment| here.depth > before.depth + self.shape.separation as f32;
            if !found.last().is_none_or(behind) {
                return fail(format!("layer {layer} of pixel {pixel}, view {view}, lies too near to the one before"));
            }
            found.push(here);
        }
        Ok(found)
    }

    /// That a pixel's own node is what was drawn there.
    fn check_pixel(&self, image: usize, pixel: [u32; 2]) -> Result<Node, TracerError> {
        let index = pixel[1] as usize * self.shape.size()[0] as usize + pixel[0] as usize;
        let node = self.node(image, 0, pixel);
        let right = match (node, self.depth(image, index)) {
            (Node::Empty, None) => true,
            (Node::Plane(plane), Some(depth)) => {
                let z = self.z_of_depth(depth);
                (plane.z - z).abs() <= self.rounding(z) && self.ends_rightly(image, pixel, plane)
            }
            _ => false,
        };
        let depth = self.depth(image, index);
        if right { Ok(node) } else { fail(format!("image {image}, pixel {pixel:?}: {node:?} of depth {depth:?}")) }
    }

    fn is_dilated(&self, plane: &Plane) -> bool {
        let code = self.forest.dilated;
        code == Dilated::All as u32
            || (code == Dilated::Continuous as u32 && !plane.flagged)
            || (code == Dilated::Flagged as u32 && plane.flagged)
    }

    /// That a node stands for those below it: a plane within both thresholds of all of them, or the box round them.
    fn check_node(&self, image: usize, level: u32, cell: [u32; 2]) -> Result<Node, TracerError> {
        let node = self.node(image, level, cell);
        let [width, height] = self.shape.level_size(level - 1);
        let edge = f64::from(1_u32 << (level - 1));
        let children: Vec<(DVec2, Node)> = [[0, 0], [1, 0], [0, 1], [1, 1]]
            .into_iter()
            .map(|[x, y]| [2 * cell[0] + x, 2 * cell[1] + y])
            .filter(|[x, y]| *x < width && *y < height)
            .map(|[x, y]| {
                let from_middle = DVec2::new(f64::from(x % 2) - 0.5, f64::from(y % 2) - 0.5) * edge;
                (from_middle, self.node(image, level - 1, [x, y]))
            })
            .collect();
        let wrong = match node {
            Node::Plane(plane) => self.wrong_plane(&plane, &children, edge),
            Node::Empty => {
                children.iter().any(|(_, child)| *child != Node::Empty).then(|| "hides something".to_owned())
            }
            Node::Box { least, greatest, holes } => {
                let joined = if level == 1 { self.min_joined(image, cell) } else { f64::INFINITY };
                self.wrong_box([least, greatest], holes, &children, edge, joined)
            }
        };
        match wrong {
            None => Ok(node),
            Some(what) => {
                fail(format!("image {image}, level {level}, node {cell:?} {what}: {node:?} over {children:?}"))
            }
        }
    }

    /// Both thresholds at a z, in the cube: the length of the difference of normals, and a distance.
    fn thresholds(&self, z: f64) -> [f64; 2] {
        let Forest { z_scale, z_shift, growth, inverse_far, gamma_norm, gamma_dist, .. } = self.forest;
        let depth = f64::from(z_scale) / (z + f64::from(z_shift));
        let grown = 1.0 + f64::from(growth) * (depth * f64::from(inverse_far)).clamp(0.0, 1.0);
        let unit = match self.shape.gamma_dist_in {
            DistanceIn::Cube => 1.0,
            DistanceIn::Pixels => (z + f64::from(z_shift)) * f64::from(self.forest.pixel_angle),
        };
        [f64::from(gamma_norm) * grown, f64::from(gamma_dist) * grown * unit]
    }

    fn wrong_plane(&self, plane: &Plane, children: &[(DVec2, Node)], edge: f64) -> Option<String> {
        let [angle, distance] = self.thresholds(plane.z);
        let mut flagged = false;
        for (from_middle, child) in children {
            let Node::Plane(child) = child else { return Some("is a plane over what is none".to_owned()) };
            flagged |= child.flagged;
            if child.end.or(plane.end).is_some() {
                return Some("stands for a plane that ends at another".to_owned());
            }
            let turned = (child.normal - plane.normal).length();
            if turned > angle * (1.0 + 1e-3) + 1e-6 {
                return Some(format!("is turned from one below by {turned}, more than {angle}"));
            }
            let corners = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]].map(|corner| DVec2::from(corner) * edge);
            let off = |corner: DVec2| (child.z_at(corner) - plane.z_at(*from_middle + corner)).abs() * plane.normal.z;
            let farthest = corners.into_iter().map(off).fold(0.0, f64::max);
            let change = (child.slope.abs() + plane.slope.abs()).element_sum() * edge / plane.normal.z.powi(2);
            let slack = self.rounding(plane.z) + SLOPE_ROUNDING * change;
            if farthest > distance * (1.0 + 1e-3) + slack {
                return Some(format!("is off a corner below by {farthest}, more than {distance}"));
            }
        }
        (flagged != plane.flagged).then(|| "has another flag than those below".to_owned())
    }

    /// The planes beside a flagged pixel's by side: by how much both lie before each other's middle, how far the pixel's gets before at the
    /// side, what rounding may make of either, and the other's least z in the pixel.
    fn beside(&self, image: usize, [x, y]: [u32; 2], own: Plane) -> [Option<[f64; 4]>; 4] {
        STEPS.map(|[across, down]| {
            let [width, height] = self.shape.size();
            let at = [x.checked_add_signed(across)?, y.checked_add_signed(down)?];
            let node = (at[0] < width && at[1] < height).then(|| self.node(image, 0, at));
            let Some(Node::Plane(beside)) = node else { return None };
            let step = DVec2::new(f64::from(across), f64::from(down));
            let meet = (own.z_at(step) - beside.z).min(beside.z_at(-step) - own.z);
            let change = (own.slope.abs() + beside.slope.abs()).element_sum();
            let slack = self.rounding(own.z.max(beside.z)) + SLOPE_ROUNDING * change;
            let there = (beside.z_at(-step) - 0.5 * beside.slope.abs().element_sum()).clamp(0.0, 1.0);
            Some([meet, own.z_at(0.5 * step) - beside.z_at(-0.5 * step), slack, there])
        })
    }

    /// Whether a pixel's plane ends at that of the neighbour before which it gets most, as far as rounding lets it.
    fn ends_rightly(&self, image: usize, pixel: [u32; 2], own: Plane) -> bool {
        let all = self.beside(image, pixel, own);
        let surely = all.iter().flatten().filter(|[meet, before, slack, _]| meet > slack && before > slack);
        let most = surely.map(|[_, before, slack, _]| before - slack).fold(0.0, f64::max);
        match own.end {
            _ if !self.shape.is_joined || !own.flagged => own.end.is_none(),
            None => most == 0.0,
            Some(side) => all[side].is_some_and(|[meet, before, slack, _]| meet > -slack && before + slack >= most),
        }
    }

    /// The least z of the planes at which those of four pixels end.
    fn min_joined(&self, image: usize, [x, y]: [u32; 2]) -> f64 {
        let size = self.shape.size();
        let pixels = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| [2 * x + right, 2 * y + down]);
        let of = |pixel: [u32; 2]| {
            let node = (pixel[0] < size[0] && pixel[1] < size[1]).then(|| self.node(image, 0, pixel));
            let Some(Node::Plane(own)) = node else { return None };
            self.beside(image, pixel, own)[own.end?].map(|[.., there]| there)
        };
        pixels.into_iter().filter_map(of).fold(f64::INFINITY, f64::min)
    }

    fn wrong_box(
        &self,
        stored: [f64; 2],
        holes: bool,
        children: &[(DVec2, Node)],
        edge: f64,
        joined: f64,
    ) -> Option<String> {
        let (mut least, mut greatest, mut has_holes, mut slack) = (f64::INFINITY, f64::NEG_INFINITY, false, 0.0_f64);
        for (_, child) in children {
            let range = match child {
                Node::Empty => {
                    has_holes = true;
                    continue;
                }
                Node::Box { least, greatest, holes } => {
                    has_holes |= holes;
                    [*least, *greatest]
                }
                Node::Plane(plane) => {
                    let beyond = if self.is_dilated(plane) { f64::from(self.forest.dilation) } else { 0.0 };
                    let change = plane.slope.abs().element_sum() * (edge + beyond) / plane.normal.z.powi(2);
                    slack = slack.max(SLOPE_ROUNDING * change);
                    plane.range(0.5 * edge + beyond)
                }
            };
            (least, greatest) = (least.min(range[0]), greatest.max(range[1]));
        }
        least = least.min(joined);
        let fits = |stored: f64, told: f64| (stored - told).abs() <= self.rounding(told) + slack;
        if !fits(stored[0], least) || !fits(stored[1], greatest) {
            return Some(format!("does not go from {least} to {greatest}"));
        }
        (holes != has_holes).then(|| "says otherwise of holes than those below".to_owned())
    }

    /// Checks the tree of an image, and counts what a walk can reach.
    fn check_tree(&self, image: usize, counts: &mut Counts) -> Result<(), TracerError> {
        let mut reached = Vec::new();
        for level in (0..=self.shape.top).rev() {
            let [width, height] = self.shape.level_size(level);
            let above = self.shape.level_size(level + 1)[0];
            let mut here = Vec::with_capacity((width * height) as usize);
            for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                let node = match level {
                    0 => self.check_pixel(image, [x, y])?,
                    _ => self.check_node(image, level, [x, y])?,
                };
                let is_reached = level == self.shape.top || reached[(y / 2 * above + x / 2) as usize];
                if is_reached {
                    let of_level = &mut counts.by_level[level as usize];
                    match node {
                        Node::Plane(plane) => {
                            of_level[0] += 1;
                            counts.flagged += u64::from(plane.flagged);
                        }
                        Node::Box { .. } => of_level[1] += 1,
                        Node::Empty if level == 0 => of_level[1] += 1,
                        Node::Empty => counts.empty += 1,
                    }
                }
                here.push(is_reached && matches!(node, Node::Box { .. }));
            }
            reached = here;
        }
        Ok(())
    }
}

impl QuadtreeStructure {
    pub(crate) fn check(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let gpu = self.gpu();
        let (shape, images) = (&self.shape, &self.images);
        let back = ReadBack {
            shape,
            forest: shape.forest(),
            codes: Images::read(gpu, &images.codes)?,
            names: Images::read(gpu, &images.names)?,
            payloads: [Images::read(gpu, &images.payloads[0])?, Images::read(gpu, &images.payloads[1])?],
            nodes: bytemuck::cast_slice(&Images::read(gpu, &images.nodes)?).to_vec(),
        };
        let mut counts = Counts::default();
        let step = (1..).find(|step| shape.pixels() / (step * step) <= MAX_COMPARED).unwrap_or(1) as u32;
        let border = shape.raster_backend.undecided_border(gpu)?;
        let [width, height] = shape.size();
        for (number, view) in shape.views.iter().enumerate() {
            let allowed = allowed_fragments(view, geometry, step, border);
            for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                let stored = back.layers(number, (y * width + x) as usize, geometry.triangles.len() as u32)?;
                counts.covered.iter_mut().zip(&stored).for_each(|(covered, _)| *covered += 1);
                if x % step == 0 && y % step == 0 {
                    counts.compared += 1;
                    if let Some(first) = stored.first() {
                        let depth = f64::from(first.depth);
                        let [_, distance] = back.thresholds(back.z_of_depth(first.depth));
                        let pixel = f64::from(back.forest.z_scale) / depth * f64::from(back.forest.pixel_angle);
                        counts.gammas.push(distance / pixel);
                    }
                    compare(&stored, allowed.of([x, y]), shape)
                        .or_else(|what| fail(format!("view {number}, pixel {x}, {y}: {what}")))?;
                }
            }
        }
        for image in 0..shape.images() as usize {
            back.check_tree(image, &mut counts)?;
        }
        Ok(self.statistics(&mut counts))
    }

    fn statistics(&self, counts: &mut Counts) -> Vec<(&'static str, f64)> {
        let nodes = self.shape.level_offsets().1 * self.shape.images();
        let planes: u64 = counts.by_level.iter().map(|[planes, _]| planes).sum();
        let boxes: u64 = counts.by_level[1..].iter().map(|[_, boxes]| boxes).sum();
        counts.gammas.sort_by(f64::total_cmp);
        let gamma = counts.gammas.get(counts.gammas.len() / 2).copied().unwrap_or(0.0);
        let mut statistics = vec![
            ("nodes", nodes as f64),
            ("plane_leaves", planes as f64),
            ("boxes", boxes as f64),
            ("empty_nodes", (counts.empty + counts.by_level[0][1]) as f64),
            ("flagged_leaves", counts.flagged as f64),
            ("levels", f64::from(self.shape.top)),
            ("pixels", (self.shape.pixels() * self.shape.views.len() as u64) as f64),
            ("compared_pixels", counts.compared as f64),
            ("median_gamma_dist_in_pixels", gamma),
        ];
        let layers = self.shape.layers as usize;
        statistics
            .extend(COVERED.into_iter().zip(counts.covered).take(layers).map(|(name, count)| (name, count as f64)));
        let levels = self.shape.top as usize + 1;
        for (names, of_level) in BY_LEVEL.into_iter().zip(counts.by_level).take(levels) {
            statistics.extend(names.into_iter().zip(of_level.map(|count| count as f64)));
        }
        statistics
    }
}

/// Holds the layers of a pixel against the fragments that may and those that must be there.
pub(crate) fn compare(stored: &[Fragment], allowed: &[Allowed], shape: &Shape) -> Result<(), String> {
    let counts = |each: &&Allowed| !shape.culls || !each.faces_away;
    let allowed: Vec<&Allowed> = allowed.iter().filter(counts).collect();
    if let Some(fragment) = stored.iter().find(|fragment| !allowed.iter().any(|each| each.fits(fragment))) {
        return Err(format!("no triangle gives {fragment:?}"));
    }
    // Of a k-buffer that is thinned only the first layer is sure; behind the last that there is room for all may be missing.
    let sure = if shape.thins() { 1 } else { shape.layers as usize };
    let behind = stored.get(sure - 1).map_or(f64::INFINITY, |last| f64::from(last.depth));
    let is_there = |each: &Allowed, fragment: &Fragment| {
        let depth = f64::from(fragment.depth);
        // What lies as far as another, or behind it by less than the separation, it stands for.
        each.depths[1] >= depth && each.depths[0] <= depth + shape.separation * (1.0 + 1e-6)
    };
    let missing = allowed
        .iter()
        .find(|each| each.must && each.depths[1] < behind && !stored.iter().any(|fragment| is_there(each, fragment)));
    match missing {
        Some(missing) if !shape.thins() || stored.is_empty() || missing.depths[1] < f64::from(stored[0].depth) => {
            Err(format!("{missing:?} is in no layer of {stored:?}"))
        }
        _ => Ok(()),
    }
}
