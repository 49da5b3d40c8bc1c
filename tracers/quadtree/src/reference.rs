//! The search as brute force in f64: every leaf of a tree that a ray crosses, one after the other, without boxes, levels or
//! successors.

mod joined;

use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::{Ray, Status, View};

use crate::description::{Dilated, InpaintedAt, NextLayer};
use crate::images::Images;
use crate::nodes::{Node, Plane};
use crate::structure::QuadtreeStructure;

use joined::Passed;

/// What a search does that is not in the structure.
#[derive(Clone, Copy)]
pub(crate) struct Asked {
    pub next_layer: NextLayer,
    pub inpaints: Option<InpaintedAt>,
    /// Pixel heights.
    pub occlusion_bias: f64,
    pub start_bias: f64,
    /// As a control: whether a walk ends with a hit beyond a node, whatever comes next.
    pub ends_beyond: bool,
}

/// An answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Answered {
    pub status: Status,
    /// Of a hit, and by how much rounding may move it.
    pub t: f64,
    pub slack: f64,
    /// The layer that was hit, from 0 on, and the plane with its node's middle; none of an inpainted hit.
    pub layer: u32,
    pub plane: Option<(Plane, DVec2)>,
    /// Whether no decision hung on what f32 may round otherwise.
    pub decided: bool,
}

/// A leaf: a plane over a square of pixels.
#[derive(Clone, Copy)]
struct Leaf {
    low: DVec2,
    high: DVec2,
    plane: Plane,
}

/// The leaves of all images of a structure of one view, read back.
pub(crate) struct Reference<'a> {
    structure: &'a QuadtreeStructure,
    view: View,
    leaves: Vec<Vec<Leaf>>,
    /// Planes of the pixels of every image that show something.
    planes: Vec<Vec<Option<Plane>>>,
}

/// A ray on the image: pixels, z and t / depth at both ends.
struct Track {
    begin: DVec2,
    end: DVec2,
    zs: [f64; 2],
    ts_over_depth: [f64; 2],
}

impl Track {
    fn at(&self, place: f64) -> DVec2 {
        self.begin + (self.end - self.begin) * place
    }

    fn z(&self, place: f64) -> f64 {
        self.zs[0] + (self.zs[1] - self.zs[0]) * place
    }

    /// Places at which the ray is within a square, of those between two; none where it is nowhere.
    fn part(&self, leaf: &Leaf, [first, last]: [f64; 2]) -> Option<[f64; 2]> {
        let way = self.end - self.begin;
        let (mut low, mut high) = (first, last);
        for axis in 0..2 {
            let [from, to] = [leaf.low[axis], leaf.high[axis]];
            if way[axis] == 0.0 {
                if self.begin[axis] < from || self.begin[axis] > to {
                    return None;
                }
                continue;
            }
            let ends = [(from - self.begin[axis]) / way[axis], (to - self.begin[axis]) / way[axis]];
            (low, high) = (low.max(ends[0].min(ends[1])), high.min(ends[0].max(ends[1])));
        }
        (low <= high).then_some([low, high])
    }

    /// A place so many pixels later along the axis on which the ray moves most.
    fn later(&self, place: f64, pixels: f64) -> f64 {
        let most = (self.end - self.begin).abs().max_element();
        if most == 0.0 { place } else { place + pixels / most }
    }
}

/// What a walk over one image found.
struct Found {
    /// Place, z, and by how much rounding may move the place.
    hit: Option<(f64, f64, f64)>,
    plane: Option<(Plane, DVec2)>,
    volume: f64,
    stopped: bool,
    inpainted: bool,
    decided: bool,
}

const NOWHERE: f64 = 2.0;

impl Found {
    /// A hit on a plane, whose place rounding may move by no more than the way that is given.
    fn take(&mut self, track: &Track, place: f64, plane: Plane, middle: DVec2, noise: f64, most: f64) {
        let behind = |place: f64| plane.z_at(track.at(place) - middle) - track.z(place);
        // How fast the ray passes the plane.
        let rate = (behind(place + 1e-3) - behind(place - 1e-3)).abs() / 2e-3;
        let slack = (noise / rate.max(1e-30)).min(most);
        self.hit = Some((place, plane.z_at(track.at(place) - middle).clamp(0.0, 1.0), slack));
        self.plane = Some((plane, middle));
    }
}

impl<'a> Reference<'a> {
    /// That of a structure of the frame's view.
    pub(crate) fn new(structure: &'a QuadtreeStructure) -> Self {
        let shape = &structure.shape;
        let forest = shape.forest();
        let nodes: Vec<[u32; 2]> =
            bytemuck::cast_slice(&Images::read(structure.gpu(), &structure.images.nodes).unwrap()).to_vec();
        let size = shape.size();
        let (mut leaves, mut planes) = (Vec::new(), Vec::new());
        for image in 0..shape.images() as usize {
            let node = |level: u32, x: u32, y: u32| {
                let first = image * forest.image_nodes as usize + forest.level_offsets[level as usize] as usize;
                Node::of(nodes[first + (y * shape.level_size(level)[0] + x) as usize], size)
            };
            let [width, height] = shape.level_size(shape.top);
            let mut open: Vec<[u32; 3]> =
                (0..height).flat_map(|y| (0..width).map(move |x| [shape.top, x, y])).collect();
            let mut of_image = Vec::new();
            while let Some([level, x, y]) = open.pop() {
                match node(level, x, y) {
                    Node::Plane(plane) => {
                        let low = DVec2::new(f64::from(x << level), f64::from(y << level));
                        of_image.push(Leaf { low, high: low + f64::from(1_u32 << level), plane });
                    }
                    Node::Box { .. } if level > 0 => {
                        let [width, height] = shape.level_size(level - 1);
                        let below = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[a, b]| [level - 1, 2 * x + a, 2 * y + b]);
                        open.extend(below.into_iter().filter(|[_, x, y]| *x < width && *y < height));
                    }
                    _ => {}
                }
            }
            leaves.push(of_image);
            let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
            let plane = |(x, y)| if let Node::Plane(plane) = node(0, x, y) { Some(plane) } else { None };
            planes.push(pixels.map(plane).collect());
        }
        Self { structure, view: shape.views[0], leaves, planes }
    }

    /// z of so many pixel heights of depth.
    fn z_of_pixels(&self, z: f64, pixels: f64) -> f64 {
        let forest = self.structure.shape.forest();
        (z.max(0.0) + f64::from(forest.z_shift)) * pixels * f64::from(forest.pixel_angle)
    }

    /// What rounding may make of z.
    fn noise(&self, z: f64, plane: &Plane) -> f64 {
        let forest = self.structure.shape.forest();
        4e-6 * (z.abs() + f64::from(forest.z_shift)) + 2e-3 * plane.slope.abs().element_sum()
    }

    fn track(&self, origin: DVec3, direction: DVec3, span: [f64; 2]) -> Track {
        let view = &self.view;
        let shift = view.near / (view.far - view.near);
        let end = |t: f64| {
            let point = view.eye + origin + direction * t;
            let at = view.project(point).unwrap();
            (DVec2::new(at.x, at.y), view.near * view.far / (view.far - view.near) / at.depth - shift, t / at.depth)
        };
        let (first, second) = (end(span[0]), end(span[1]));
        Track {
            begin: first.0,
            end: second.0,
            zs: [first.1.clamp(0.0, 1.0), second.1.clamp(0.0, 1.0)],
            ts_over_depth: [first.2, second.2],
        }
    }

    /// Where on a ray, from its origin on, it lies in the view.
    fn span(&self, origin: DVec3, direction: DVec3, [first, last]: [f64; 2]) -> Option<[f64; 2]> {
        let view = &self.view;
        let eye = |at: DVec3| DVec3::new(at.dot(view.right), at.dot(view.up), at.dot(view.forward));
        let (o, d) = (eye(origin), eye(direction));
        let (mut low, mut high) = (first, last);
        let planes = [
            (o.z - view.near, d.z),
            (view.far - o.z, -d.z),
            (o.z * view.tan_half_width - o.x, d.z * view.tan_half_width - d.x),
            (o.z * view.tan_half_width + o.x, d.z * view.tan_half_width + d.x),
            (o.z * view.tan_half_height - o.y, d.z * view.tan_half_height - d.y),
            (o.z * view.tan_half_height + o.y, d.z * view.tan_half_height + d.y),
        ];
        for (value, slope) in planes {
            if slope == 0.0 {
                if value < 0.0 {
                    return None;
                }
            } else if slope > 0.0 {
                low = low.max(-value / slope);
            } else {
                high = high.min(-value / slope);
            }
        }
        (low < high).then_some([low, high])
    }

    fn walk(&self, image: usize, track: &Track, asked: &Asked, [first, last]: [f64; 2]) -> Found {
        let forest = self.structure.shape.forest();
        let mut last = last;
        let mut crossed: Vec<([f64; 2], &Leaf)> = self.leaves[image]
            .iter()
            .filter_map(|leaf| track.part(leaf, [first, last]).map(|part| (part, leaf)))
            .collect();
        crossed.sort_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let mut found =
            Found { hit: None, plane: None, volume: NOWHERE, stopped: false, inpainted: false, decided: true };
        let pixels = (track.end - track.begin).abs().max_element();
        // Where the ray left the leaf before, close before its plane, and whether that is decided.
        let mut before_until = (-1.0, true);
        for ([entry, exit], leaf) in crossed {
            if entry > last {
                break;
            }
            let exit = exit.min(last);
            let middle = (leaf.low + leaf.high) / 2.0;
            let behind = |place: f64| leaf.plane.z_at(track.at(place) - middle) - track.z(place);
            let (at_entry, at_exit) = (behind(entry), behind(exit));
            let tolerance = self.z_of_pixels(track.z(entry), asked.occlusion_bias);
            let dilated = forest.dilated == Dilated::All as u32
                || (forest.dilated == Dilated::Continuous as u32 && !leaf.plane.flagged)
                || (forest.dilated == Dilated::Flagged as u32 && leaf.plane.flagged);
            let reach = if dilated { f64::from(forest.dilation) } else { 0.0 };
            let part = [track.later(entry, -reach).max(first), track.later(exit, reach).min(last)];
            let noise = self.noise(track.z(entry).max(track.z(exit)), &leaf.plane);
            let (at_first, at_last) = (behind(part[0]), behind(part[1]));
            // A corner that is just touched rounding may leave out.
            let touched = (exit - entry) * pixels < 1e-2 && pixels > 1e-2;
            let patches = self.joined(image, leaf);
            found.decided &= patches.1;
            if patches.0.len() > 1 {
                let patches = &patches.0;
                let passed = Passed { entry, exit, touched, out_of_volume: found.volume < entry, before: before_until };
                let told = self.pass_joined(patches, track, asked, &passed);
                before_until = told.before_until;
                found.decided &= told.decided;
                if told.is_behind {
                    found.decided &= !touched;
                    if found.volume == NOWHERE {
                        found.volume = entry;
                    }
                    if let Some(at) = asked.inpaints {
                        found.stopped = true;
                        self.inpaint(image, track, [first, entry], at, &mut found);
                        return found;
                    }
                }
                if let Some((place, plane, middle)) = told.hit {
                    found.decided &= !touched && place < last + 1e-12;
                    found.take(track, place, plane, middle, noise, exit - entry);
                    return found;
                }
                continue;
            }
            let close = |values: &[f64]| values.iter().any(|value| value.abs() < noise);
            let crossing = |a: f64, b: f64, at_a: f64, at_b: f64| a + (b - a) * (at_a / (at_a - at_b)).clamp(0.0, 1.0);
            let before = before_until;
            let was_before = entry <= track.later(before.0, 0.01);
            let kept = self.z_of_pixels(track.z(exit), asked.occlusion_bias);
            let is_before = (-kept..=0.0).contains(&at_exit);
            before_until = (if is_before { exit } else { -1.0 }, !touched && !close(&[at_exit, at_exit + kept]));
            let out_of_volume = found.volume < entry;
            let mut outcome = None;
            if at_entry <= 0.0 {
                if close(&[at_entry, at_last]) {
                    found.decided = false;
                }
                if at_last > 0.0 {
                    outcome = Some(crossing(entry, part[1], at_entry, at_last));
                } else if out_of_volume && at_entry >= -tolerance && at_first > 0.0 {
                    outcome = Some(crossing(part[0], entry, at_first, at_entry));
                }
                found.decided &= !(out_of_volume && close(&[at_entry + tolerance, at_first]));
            } else if at_entry <= tolerance {
                if close(&[at_entry, at_entry - tolerance, at_first]) {
                    found.decided = false;
                }
                let deeper = at_exit > at_entry;
                if at_first <= 0.0 {
                    outcome = Some(crossing(part[0], entry, at_first, at_entry));
                } else if was_before && deeper {
                    outcome = Some(entry);
                } else if out_of_volume && at_exit < 0.0 {
                    outcome = Some(crossing(entry, exit, at_entry, at_exit));
                }
                found.decided &= !(out_of_volume && close(&[at_exit]));
                found.decided &= before.1 && !(was_before && close(&[at_exit - at_entry]));
            } else {
                if close(&[at_entry - tolerance, at_last]) {
                    found.decided = false;
                }
                if found.volume == NOWHERE {
                    found.volume = entry;
                }
                found.decided &= !touched;
                if let Some(at) = asked.inpaints {
                    found.stopped = true;
                    self.inpaint(image, track, [first, entry], at, &mut found);
                    return found;
                }
                if at_last < 0.0 {
                    outcome = Some(crossing(entry, part[1], at_entry, at_last));
                }
            }
            if let Some(place) = outcome {
                found.decided &= !touched && place < last + 1e-12;
                found.take(track, place, leaf.plane, middle, noise, part[1] - part[0]);
                // Beyond its leaf something nearer may lie, near a discontinuity.
                if place <= exit || !leaf.plane.flagged || asked.ends_beyond {
                    return found;
                }
                found.decided &= (place - exit) * pixels > 1e-3;
                last = place;
            }
        }
        found
    }

    /// A hit half a pixel before a volume, where the image shows something, or where the ray gets behind the plane of what it shows.
    fn inpaint(&self, image: usize, track: &Track, [first, entry]: [f64; 2], at_what: InpaintedAt, found: &mut Found) {
        let before = track.later(entry, -0.5).max(first);
        let size = self.structure.shape.size();
        let at = track.at(before);
        found.decided &= (at - at.round()).abs().min_element() > 2e-3;
        // Where the ray begins the place hangs on rounding.
        found.decided &= entry <= first || entry - first > 1e-6;
        if entry <= first || before >= entry {
            return;
        }
        let last = DVec2::new(f64::from(size[0]), f64::from(size[1])) - 1.0;
        let pixel = at.floor().clamp(DVec2::ZERO, last);
        let Some(plane) = self.planes[image][pixel.y as usize * size[0] as usize + pixel.x as usize] else { return };
        found.inpainted = true;
        found.hit = Some((before, track.z(before), 1e-5));
        if at_what == InpaintedAt::Plane {
            let middle = pixel + 0.5;
            let [here, there] = [before, 1.0].map(|place| plane.z_at(track.at(place) - middle) - track.z(place));
            let noise = self.noise(track.z(before).max(track.z(1.0)), &plane);
            found.decided &= here.abs() > noise && there.abs() > noise;
            if (here > 0.0) != (there > 0.0) {
                found.take(track, before + (1.0 - before) * (here / (here - there)), plane, middle, noise, 1.0);
            }
        }
    }

    /// The answer to a ray.
    pub(crate) fn answer(&self, ray: &Ray, asked: &Asked) -> Answered {
        let shape = &self.structure.shape;
        let view = &self.view;
        let origin = Vec3::from(ray.origin).as_dvec3() - view.eye;
        let direction = Vec3::from(ray.direction).as_dvec3();
        let ends = [f64::from(ray.t_min), f64::from(ray.t_max)];
        let miss =
            |status: Status, decided: bool| Answered { status, t: 0.0, slack: 0.0, layer: 0, plane: None, decided };
        let Some(mut span) = self.span(origin, direction, ends) else { return miss(Status::LeftViews, true) };
        let starts = span[0] <= ends[0];
        let seen_whole = starts && span[1] >= ends[1];
        if starts {
            let depth = (origin + direction * span[0]).dot(view.forward);
            let pixel = 2.0 * view.tan_half_height / f64::from(view.size[1]);
            span[0] += asked.start_bias * pixel * depth.max(view.near);
        }
        let missed = if seen_whole { Status::Miss } else { Status::LeftViews };
        if span[0] >= span[1] {
            return miss(missed, (span[0] - span[1]) > 1e-6);
        }
        let track = self.track(origin, direction, span);
        let (mut best, mut first, mut limit): (Option<Answered>, f64, f64) = (None, 0.0, 1.0);
        let (mut decided, mut occluded) = (true, false);
        for layer in 0..shape.layers {
            let inpaints = asked.inpaints.filter(|_| layer + 1 == shape.layers);
            let found = self.walk(layer as usize, &track, &Asked { inpaints, ..*asked }, [first, limit]);
            decided &= found.decided;
            if let Some((place, z, slack)) = found.hit {
                let forest = shape.forest();
                let t_of = |place: f64, z: f64| {
                    let depth = f64::from(forest.z_scale) / (z + f64::from(forest.z_shift));
                    let over = track.ts_over_depth[0] + (track.ts_over_depth[1] - track.ts_over_depth[0]) * place;
                    (over * depth).clamp(ends[0], ends[1])
                };
                let moved = t_of(place + slack, track.z(place + slack)) - t_of(place - slack, track.z(place - slack));
                let status = if found.inpainted { Status::Inpainted } else { Status::Hit };
                best = Some(Answered {
                    status,
                    t: t_of(place, z),
                    slack: moved.abs(),
                    layer,
                    plane: found.plane,
                    decided,
                });
                limit = place;
            }
            let passed = found.volume < limit;
            let last = layer + 1 == shape.layers;
            let done = found.stopped
                || match asked.next_layer {
                    NextLayer::Volumes => !passed,
                    NextLayer::Misses => found.hit.is_some(),
                    NextLayer::Always => false,
                };
            if asked.next_layer == NextLayer::Volumes {
                first = found.volume.min(limit);
            }
            if done || last {
                occluded |= (passed && last) || (found.stopped && found.hit.is_none());
                break;
            }
        }
        match best {
            Some(best) => Answered { decided, ..best },
            None => miss(if occluded { Status::BehindLastLayer } else { missed }, decided),
        }
    }

    /// The weights of the samples beside a ray that was answered so, and whether rounding decides nothing of them.
    pub(crate) fn weight(&self, ray: &Ray, answered: &Answered, samples: Samples) -> (f64, bool) {
        let Some((plane, middle)) = answered.plane else { return (0.0, true) };
        let (view, forest) = (&self.view, self.structure.shape.forest());
        let eye = |at: DVec3| DVec3::new(at.dot(view.right), at.dot(view.up), at.dot(view.forward));
        let origin = eye(Vec3::from(ray.origin).as_dvec3() - view.eye);
        let direction = eye(Vec3::from(ray.direction).as_dvec3());
        let [scale, shift, angle] = [forest.z_scale, forest.z_shift, forest.pixel_angle].map(f64::from);
        // z of the plane along a line of sight is that of where the line meets it.
        let z_of = |point: DVec3| scale / point.z - shift;
        let pixels_of = |point: DVec3| {
            let half = DVec2::new(f64::from(view.size[0]), f64::from(view.size[1])) / 2.0;
            half + half * DVec2::new(point.x / view.tan_half_width, -point.y / view.tan_half_height) / point.z
        };
        let off = |t: f64, beside: DVec3| {
            let point = origin + beside * t;
            // Of the right sign on either side of the plane, and linear in t.
            (plane.z_at(pixels_of(point) - middle) - z_of(point)) * point.z
        };
        let axis = if direction.x.abs() > 0.5 { DVec3::Y } else { DVec3::X };
        let first = direction.cross(axis).normalize();
        let second = direction.cross(first);
        let (mut sum, mut decided) = (0.0, (direction.x.abs() - 0.5).abs() > 1e-6);
        for sample in 0..samples.count {
            let radius = ((f64::from(sample) + 0.5) / f64::from(samples.count)).sqrt() * samples.jitter * angle;
            let turn = f64::from(sample) * 2.399_963_2;
            let beside = direction + (first * turn.cos() + second * turn.sin()) * radius;
            // From two parameters at which the depth is not 0 the root of what is linear between them.
            let ends = [0.011, 0.739].map(|share| (share - origin.z) / beside.z.abs().max(1e-9) * beside.z.signum());
            let [a, b] = ends.map(|t| off(t, beside));
            let t = ends[0] + (ends[1] - ends[0]) * a / (a - b);
            let point = origin + beside * t;
            let at = pixels_of(point);
            decided &= (a - b).abs() > 1e-3 * (a.abs() + b.abs()) && t.abs() > 1e-3;
            decided &= (point.z / view.near - 1.0).abs() > 1e-3 && (point.z / view.far - 1.0).abs() > 1e-3;
            if t.is_nan() || t <= 0.0 || point.z < view.near || point.z > view.far {
                continue;
            }
            decided &= (at - at.round()).abs().min_element() > 5e-3;
            let place = at.floor();
            if place.min_element() < 0.0 || place.x >= f64::from(view.size[0]) || place.y >= f64::from(view.size[1]) {
                continue;
            }
            let Some(z) = self.z_at(answered.layer, [place.x as u32, place.y as u32]) else { continue };
            sum += (-((z_of(point) - z) / samples.sigma).powi(2)).exp();
        }
        (sum, decided)
    }

    /// z of a pixel of a layer.
    fn z_at(&self, layer: u32, [x, y]: [u32; 2]) -> Option<f64> {
        self.planes[layer as usize][(y * self.structure.shape.size()[0] + x) as usize].map(|plane| plane.z)
    }
}

/// How many samples lie beside a ray, within how many pixels, and how fast their weight falls.
#[derive(Clone, Copy)]
pub(crate) struct Samples {
    pub count: u32,
    pub jitter: f64,
    pub sigma: f64,
}
