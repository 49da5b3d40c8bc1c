//! How rays are answered: against brute force over the leaves, by every way to walk, in minimal cases, and by their work.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Counter, Geometry, Gpu, Hit, HitBuffer, Query, Ray, RayBuffer, Residency, Status, Structure, TraceJob, TraceTo,
};
use tracebench_kit::Built;
use tracebench_tests::{Numbers, gpu, ray, soup};

use super::description::{InpaintedAt, NextLayer};
use super::reference::{Answered, Asked, Reference};
use super::structure::{Quadtree, QuadtreeStructure};
use super::tests::{LOSSLESS, answer, built_by, hostile, parameters, rectangle, viewpoint};

/// Planes by the triangles' normals that end at each other.
pub(crate) const JOINED: [(&str, &str); 3] = [("patches", "joined"), ("normals", "geometry"), ("discontinuity", "0.5")];

pub(crate) const PUBLISHED: Asked =
    Asked { next_layer: NextLayer::Volumes, inpaints: None, occlusion_bias: 1.0, start_bias: 1.0, ends_beyond: false };

/// Rays from the eye, from beside it, from anywhere before and beside the view, in all directions; along axes, bounded.
pub(crate) fn rays(count: usize) -> Vec<Ray> {
    let mut numbers = Numbers::new(171);
    let eye = viewpoint().eye.as_dvec3();
    let view = viewpoint().frame_view();
    let mut rays = Vec::new();
    for index in 0..count {
        let (x, y) = (numbers.unit() * 63.0, numbers.unit() * 41.0);
        let ahead = view.direction_through(x, y);
        rays.push(match index % 5 {
            0 => ray(eye, ahead),
            1 => ray(eye + numbers.point() * 0.3, ahead + numbers.point() * 0.1),
            2 => ray(eye + ahead * (0.5 + 8.0 * numbers.unit()), numbers.direction()),
            3 => Ray { t_max: 3.0, ..ray(eye + ahead * (0.5 + 5.0 * numbers.unit()), numbers.direction()) },
            _ => ray(eye + numbers.point() * 6.0, numbers.direction()),
        });
    }
    rays
}

/// Whether a hit is what brute force has found.
fn is_answer(expected: &Answered, hit: &Hit) -> bool {
    let off = (f64::from(hit.t) - expected.t).abs();
    hit.status == expected.status as u32
        && (!expected.status.is_hit() || off <= 2e-4 * expected.t.max(0.1) + expected.slack)
}

fn count(hits: &[Hit], status: Status) -> usize {
    hits.iter().filter(|hit| hit.status == status as u32).count()
}

const VOLUME: Option<InpaintedAt> = Some(InpaintedAt::Volume);

/// Proves that rays get what brute force over all leaves that they cross finds, in f64, with lossless and with merged trees, by all
/// readings of when the next layer is asked, inpainted or not; where f64 says that rounding decides nothing. Negative control: the
/// answers of other settings are noticed.
#[test]
fn rays_are_answered_as_by_brute_force() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let rays = rays(1500);
    let with = |more: &[(&'static str, &'static str)]| [&LOSSLESS[..], more].concat();
    let all: Vec<(Vec<(&str, &str)>, Asked)> = vec![
        (vec![], PUBLISHED),
        (with(&[]), PUBLISHED),
        (with(&[("layers", "3")]), PUBLISHED),
        (with(&[("next_layer", "misses")]), Asked { next_layer: NextLayer::Misses, ..PUBLISHED }),
        (with(&[("next_layer", "always"), ("layers", "3")]), Asked { next_layer: NextLayer::Always, ..PUBLISHED }),
        (with(&[("layers", "1")]), Asked { inpaints: VOLUME, ..PUBLISHED }),
        (
            with(&[("layers", "1"), ("inpainted_at", "plane")]),
            Asked { inpaints: Some(InpaintedAt::Plane), ..PUBLISHED },
        ),
        (with(&[("inpainting", "always")]), Asked { inpaints: VOLUME, ..PUBLISHED }),
        (with(&[("layers", "1"), ("inpainting", "never"), ("dilated", "none")]), PUBLISHED),
        (vec![("gamma_dist", "0.001"), ("gamma_norm", "25"), ("dilated", "all"), ("dilation", "1")], PUBLISHED),
        (with(&[("dilated", "all"), ("dilation", "1")]), PUBLISHED),
        (
            with(&[("occlusion_bias", "0"), ("start_bias", "4")]),
            Asked { occlusion_bias: 0.0, start_bias: 4.0, ..PUBLISHED },
        ),
        (with(&JOINED), PUBLISHED),
        (with(&[&JOINED[..], &[("layers", "1")]].concat()), Asked { inpaints: VOLUME, ..PUBLISHED }),
        (
            with(&[&JOINED[..], &[("layers", "4"), ("occlusion_bias", "0.25"), ("start_bias", "0.1")]].concat()),
            Asked { occlusion_bias: 0.25, start_bias: 0.1, ..PUBLISHED },
        ),
    ];
    for (settings, asked) in all {
        let structure = built_by(&tracer, &gpu, &geometry, &settings);
        let reference = Reference::new(&structure);
        let hits = answer(&gpu, &structure, &rays, &settings, TraceTo::Hit).0;
        let expected: Vec<Answered> = rays.iter().map(|ray| reference.answer(ray, &asked)).collect();
        let decided = expected.iter().filter(|each| each.decided).count();
        assert!(10 * decided > 8 * rays.len(), "{settings:?}: {decided} of {} decided", rays.len());
        let wrong = |hits: &[Hit]| {
            let pairs = expected.iter().zip(hits).enumerate();
            pairs
                .filter(|(_, (each, hit))| each.decided && !is_answer(each, hit))
                .map(|(index, _)| index)
                .collect::<Vec<_>>()
        };
        let found = wrong(&hits);
        if let Some(first) = found.first() {
            panic!(
                "{settings:?}: {} of {decided}: ray {first} {:?}: {:?}, not {:?}",
                found.len(),
                rays[*first],
                hits[*first],
                expected[*first]
            );
        }
        assert!(count(&hits, Status::Hit) > 300, "{settings:?}");
        // A walk that ends with a hit beyond a node, where what is nearer comes next, answers otherwise.
        if settings.contains(&("dilated", "all")) {
            let first = Asked { ends_beyond: true, ..asked };
            let off = rays.iter().zip(&expected).filter(|(ray, each)| {
                let other = reference.answer(ray, &first);
                each.decided && other.decided && (other.t - each.t).abs() > 1e-3 * each.t
            });
            assert!(off.count() > 2, "{settings:?}");
        }
        // Of the layers behind the first some are hit.
        let behind = expected.iter().filter(|each| each.decided && each.layer > 0).count();
        assert!(structure.shape.layers == 1 || behind > 5, "{settings:?}: {behind}");
        let other =
            [&settings[..], &[("inpainting", if asked.inpaints.is_some() { "never" } else { "always" })]].concat();
        assert!(wrong(&answer(&gpu, &structure, &rays, &other, TraceTo::Hit).0).len() > 20, "{settings:?}");
    }
}

/// Rays of an eye beside the view's, through corners of pixels: they run along borders between cells, now on this side and now on that
/// as their places are rounded.
fn along_borders() -> Vec<Ray> {
    let view = viewpoint().frame_view();
    let from = |beside: f64| {
        let corners = (1..10).flat_map(|row| (1..15).map(move |column| (f64::from(4 * column), f64::from(4 * row))));
        corners.map(move |(x, y)| ray(view.eye + view.right * beside, view.direction_through(x, y)))
    };
    [-0.3, 0.01, 0.1].into_iter().flat_map(from).collect()
}

/// Rays of a square of eyes beside the view's, through the pixels' centres as the view has them: many enter the image through its sides,
/// and run along them.
fn through_sides() -> Vec<Ray> {
    let view = viewpoint().frame_view();
    let steps = [-2.4, -1.2, -0.8, 0.0, 0.8, 1.2, 2.4];
    let eyes = steps.into_iter().flat_map(|across| steps.map(|up| view.right * across + view.up * up));
    eyes.flat_map(|beside| {
        let pixels = (0..41).step_by(3).flat_map(|row| (0..63).step_by(2).map(move |column| (column, row)));
        pixels.map(move |(x, y)| ray(view.eye + beside, view.direction_through(f64::from(x) + 0.5, f64::from(y) + 0.5)))
    })
    .collect()
}

/// Proves that the way a tree is walked changes no bit: with a stack or without, over as many levels as there are or none, read from
/// textures, with several rays a lane; of one layer, too, where holes are inpainted, and of planes that end at each other. Negative
/// control: merged planes do change some.
#[test]
fn ways_to_walk_change_no_hit() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let rays = [rays(1500), along_borders(), through_sides()].concat();
    let joined_layers = [&JOINED[..], &[("layers", "1")]].concat();
    for base in [&[("views", "frame")][..], &[("views", "six")], &[("layers", "1")], &JOINED, &joined_layers] {
        let by = |more: &[(&'static str, &'static str)]| {
            let settings = [&LOSSLESS[..], base, more].concat();
            let structure = built_by(&tracer, &gpu, &geometry, &settings);
            answer(&gpu, &structure, &rays, &settings, TraceTo::Surface)
        };
        let expected = by(&[]);
        assert!(count(&expected.0, Status::Hit) > 300);
        for more in [
            [("traversal", "stack"), ("rays_per_lane", "1")],
            [("levels", "0"), ("max_steps", "65536")],
            [("levels", "3"), ("traversal", "stack")],
            [("walk_from", "ancestor"), ("traversal", "stack")],
            [("walk_from", "ancestor"), ("levels", "3")],
            [("memory_access", "texture"), ("rays_per_lane", "7")],
        ] {
            let found = by(&more);
            let off: Vec<_> = rays.iter().zip(found.0.iter().zip(&expected.0)).filter(|(_, (a, b))| a != b).collect();
            assert!(off.is_empty(), "{base:?} {more:?}: {} rays, {:?}", off.len(), &off[..off.len().min(4)]);
            assert!(found.1 == expected.1, "{base:?} {more:?}");
        }
        assert!(by(&[("gamma_dist", "0.01"), ("gamma_norm", "25")]).0 != expected.0);
    }
}

/// Proves that rays through the pixels' centres get the depth buffer back: lossless to rounding, with the paper's thresholds within
/// what these allow over all levels.
#[test]
fn rays_from_the_eye_get_the_depth_buffer() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let view = viewpoint().frame_view();
    let centres = (0..41).flat_map(|y| (0..63).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
    let rays: Vec<Ray> = centres.map(|(x, y)| ray(view.eye, view.direction_through(x, y))).collect();
    for (settings, normals) in
        [(LOSSLESS.to_vec(), "depth"), (LOSSLESS.to_vec(), "geometry"), (vec![], "depth"), (vec![], "geometry")]
    {
        let is_lossless = !settings.is_empty();
        let settings = [&settings[..], &[("normals", normals)]].concat();
        let structure = built_by(&tracer, &gpu, &geometry, &settings);
        let codes = super::images::Images::read(&gpu, &structure.images.codes).unwrap();
        let hits = answer(&gpu, &structure, &rays, &settings, TraceTo::Hit).0;
        let mut greatest = 0.0_f64;
        for ((hit, code), ray) in hits.iter().zip(&codes).zip(&rays) {
            assert_eq!(hit.is_hit(), *code != 0, "{settings:?}");
            if !hit.is_hit() {
                continue;
            }
            let depth = f64::from(hit.t) * Vec3::from(ray.direction).as_dvec3().dot(view.forward);
            let stored = f64::from(f32::from_bits(!code));
            let z = |depth: f64| view.near / depth;
            greatest = greatest.max((z(depth) - z(stored)).abs());
            assert!(!is_lossless || (depth / stored - 1.0).abs() < 2e-5, "{settings:?}: {depth} {stored}");
        }
        // Six levels above the pixels, each within 1e-5 of the corners below it, square to planes of some slope.
        assert!(is_lossless || (greatest > 1e-7 && greatest < 6e-4), "{settings:?}: {greatest}");
    }
}

/// A plate before a wall, seen from the front: what lies between them only further layers know.
pub(crate) struct Stage {
    pub gpu: Arc<Gpu>,
    tracer: Quadtree,
    geometry: Geometry,
    eye: DVec3,
}

impl Stage {
    /// The wall at 6, the plate from x -1 to 1 at 2; with `between` another plate as wide at 4, where a second layer lies.
    pub(crate) fn new(between: bool) -> Self {
        let gpu = gpu();
        let eye = viewpoint().eye.as_dvec3();
        let plate = |depth: f64, half: f64| {
            rectangle(eye + DVec3::new(-half, -30.0, -depth), DVec3::X * (2.0 * half), DVec3::Y * 60.0)
        };
        let mut triangles = [plate(2.0, 1.0), plate(6.0, 60.0)].concat();
        if between {
            triangles.extend(plate(4.0, 1.0));
        }
        let geometry = soup(&triangles, Some(&gpu));
        Self { tracer: Quadtree::new(Arc::clone(&gpu)).unwrap(), gpu, geometry, eye }
    }

    pub(crate) fn built(&self, settings: &[(&str, &str)]) -> Built<QuadtreeStructure> {
        built_by(&self.tracer, &self.gpu, &self.geometry, settings)
    }

    /// From a place relative to the eye, depths counted ahead.
    pub(crate) fn ray(&self, [x, y, depth]: [f64; 3], [across, up, ahead]: [f64; 3]) -> Ray {
        ray(self.eye + DVec3::new(x, y, -depth), DVec3::new(across, up, -ahead))
    }

    fn one(&self, ray: Ray, settings: &[(&str, &str)]) -> Hit {
        answer(&self.gpu, &self.built(settings), &[ray], settings, TraceTo::Hit).0[0]
    }
}

fn status(hit: &Hit) -> Status {
    Status::from_code(hit.status).unwrap()
}

/// Proves what occlusion volumes do, by the statuses: a ray that passes behind the plate asks the next layer and finds the wall or the
/// plate between; without a deeper layer it ends occluded, or hits the wall once it has come out; section 2.3's reading asks after
/// misses alone; and what starts behind a surface lies in its volume from the start.
#[test]
fn occlusion_volumes_ask_the_next_layer() {
    let stage = Stage::new(true);
    let never = ("inpainting", "never");
    // Behind the plate, in front of the one at 4, out on the other side onto the wall.
    let past = stage.ray([-1.5, 0.1, 2.2], [1.0, 0.0, 0.5]);
    let near = |hit: &Hit, t: f32| status(hit) == Status::Hit && (hit.t - t).abs() < 0.05;
    let bounded = Ray { t_max: (2.0 * 1.25_f64.sqrt()) as f32, ..past };
    assert_eq!(status(&stage.one(bounded, &[("layers", "1"), never])), Status::BehindLastLayer);
    assert_eq!(status(&stage.one(bounded, &[("layers", "2")])), Status::Miss);
    // From before to behind the second plate, which only the second layer has, and out onto the wall.
    let through = stage.ray([-1.5, 0.1, 2.2], [1.0, 0.0, 0.78]);
    let [on_plate, on_wall] = [4.0, 6.0].map(|depth: f64| ((depth - 2.2) / 0.78 * 1.6084_f64.sqrt()) as f32);
    assert!(near(&stage.one(through, &[("layers", "2")]), on_plate));
    assert!(near(&stage.one(through, &[("layers", "2"), ("next_layer", "always")]), on_plate));
    assert!(near(&stage.one(through, &[("layers", "1"), never]), on_wall));
    // The first layer is hit, on the wall: by section 2.3 no other is asked.
    assert!(near(&stage.one(through, &[("layers", "2"), ("next_layer", "misses")]), on_wall));
    // A start behind the first plate, towards the second and away from it.
    let behind = stage.ray([0.2, 0.1, 3.0], [0.1, 0.0, 1.0]);
    assert!(near(&stage.one(behind, &[("layers", "2")]), 1.005));
    let ahead = stage.ray([0.2, 0.1, 3.0], [0.1, 0.0, -1.0]);
    assert!(near(&stage.one(ahead, &[("layers", "1"), never]), 1.005), "from behind a surface is hit, too");
    // In front of everything nothing is asked but the first layer.
    let structure = stage.built(&[]);
    let front = stage.ray([-1.5, 0.1, 1.0], [1.0, 0.0, 0.05]);
    let asked = |ray: Ray| of(&counted(&stage.gpu, &structure, &[ray], &[]), "layers_asked");
    assert_eq!((asked(front), asked(bounded), asked(through)), (1, 2, 2));
}

/// Proves that with one layer a ray that passes behind the plate ends with a hit at its silhouette, half a pixel before it, on the
/// wall that the image shows there: a hit for everyone, with a status of its own; where the image shows nothing there, or the ray
/// starts behind the plate, it ends occluded; with two layers there is none, but where it is asked for.
#[test]
fn holes_are_inpainted_with_the_background() {
    let stage = Stage::new(false);
    let past = stage.ray([-1.5, 0.1, 2.2], [1.0, 0.0, 0.5]);
    let hit = stage.one(past, &[("layers", "1")]);
    assert!(hit.is_hit() && status(&hit) == Status::Inpainted, "{hit:?}");
    let view = viewpoint().frame_view();
    let at = view
        .project(Vec3::from(past.origin).as_dvec3() + Vec3::from(past.direction).as_dvec3() * f64::from(hit.t))
        .unwrap();
    // The plate's left side, from the first pixel whose centre it covers.
    let side = view.project(stage.eye + DVec3::new(-1.0, 0.1, -2.0)).unwrap();
    let first = (side.x + 0.5).floor();
    assert!((at.x - (first - 0.5)).abs() < 0.02, "{at:?} {side:?}");
    let (_, surfaces) =
        answer(&stage.gpu, &stage.built(&[("layers", "1")]), &[past], &[("layers", "1")], TraceTo::Surface);
    assert_eq!((surfaces[0].status, surfaces[0].normal[2].abs()), (1, 1.0));
    assert_eq!(status(&stage.one(past, &[])), Status::Hit);
    assert_eq!(status(&stage.one(past, &[("layers", "1"), ("inpainting", "never")])), Status::Hit);
    assert_eq!(
        status(&stage.one(stage.ray([0.0, 0.1, 3.0], [1.0, 0.0, 0.1]), &[("layers", "1")])),
        Status::BehindLastLayer
    );
    // Without the wall nothing is behind.
    let plate = rectangle(stage.eye + DVec3::new(-1.0, -30.0, -2.0), DVec3::X * 2.0, DVec3::Y * 60.0);
    let alone = soup(&plate, Some(&stage.gpu));
    let structure = built_by(&stage.tracer, &stage.gpu, &alone, &[("layers", "1")]);
    let hit = answer(&stage.gpu, &structure, &[past], &[("layers", "1")], TraceTo::Hit).0[0];
    assert_eq!(status(&hit), Status::BehindLastLayer);
}

/// Proves that rays in all directions from the eye get what the faces show, across their borders too, and that with the frame alone
/// they leave the view.
#[test]
fn faces_answer_every_direction() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    // A closed box round the eye.
    let corner = eye - DVec3::new(3.0, 2.0, 4.0);
    let [x, y, z] = [DVec3::X * 6.5, DVec3::Y * 4.5, DVec3::Z * 8.5];
    let walls =
        [(corner, x, y), (corner + z, x, y), (corner, y, z), (corner + x, y, z), (corner, x, z), (corner + y, x, z)];
    let triangles: Vec<_> = walls.into_iter().flat_map(|(at, first, second)| rectangle(at, first, second)).collect();
    let geometry = soup(&triangles, Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let mut numbers = Numbers::new(172);
    let outward: Vec<Ray> = (0..600).map(|_| ray(eye, numbers.direction())).collect();
    // Through several faces, from side to side of the box.
    let across: Vec<Ray> =
        (0..600).map(|_| ray(corner + (x + y + z) * 0.5 + numbers.point() * 1.5, numbers.direction())).collect();
    let wall = |ray: &Ray| {
        let (o, d) = (Vec3::from(ray.origin).as_dvec3() - corner, Vec3::from(ray.direction).as_dvec3());
        let far = DVec3::new(6.5, 4.5, 8.5);
        (0..3)
            .map(|axis| if d[axis] > 0.0 { (far[axis] - o[axis]) / d[axis] } else { -o[axis] / d[axis] })
            .fold(1e9, f64::min)
    };
    let settings = [&LOSSLESS[..], &[("views", "six"), ("normals", "geometry")]].concat();
    let structure = built_by(&tracer, &gpu, &geometry, &settings);
    for rays in [&outward, &across] {
        let hits = answer(&gpu, &structure, rays, &settings, TraceTo::Hit).0;
        let right = |(ray, hit): &(&Ray, &Hit)| hit.is_hit() && (f64::from(hit.t) / wall(ray) - 1.0).abs() < 1e-3;
        let found = rays.iter().zip(&hits).filter(right).count();
        // Near the box's edges a pixel shows the other wall.
        assert!(found > 570, "{found} of {}", rays.len());
        assert_eq!(count(&hits, Status::StepCap), 0);
    }
    let structure = built_by(&tracer, &gpu, &geometry, &[]);
    let hits = answer(&gpu, &structure, &outward, &[], TraceTo::Hit).0;
    assert!(count(&hits, Status::LeftViews) > 400, "{}", count(&hits, Status::LeftViews));
}

/// Counters of a trace to hits.
pub(crate) fn counted(
    gpu: &Arc<Gpu>,
    structure: &Built<QuadtreeStructure>,
    rays: &[Ray],
    settings: &[(&str, &str)],
) -> Vec<Counter> {
    let rays = RayBuffer::new(Arc::new(rays.to_vec()), Query::Closest, Some(gpu));
    let mut hits = HitBuffer::new(rays.host.len(), Residency::Device, Some(gpu)).unwrap();
    let parameters = parameters(settings);
    structure
        .trace_counted(TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters: &parameters }, &mut hits)
        .unwrap()
}

pub(crate) fn of(counters: &[Counter], name: &str) -> u64 {
    counters.iter().find(|counter| counter.name == name).unwrap().total
}

/// Proves what the counters say: tests are the nodes visited, levels save visits over a walk from pixel to pixel, merged planes save
/// more, a stack changes none; asking every layer visits more than asking behind volumes, and any hit no more than the closest.
#[test]
fn counters_say_what_is_saved() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let wall = rectangle(eye + DVec3::new(-40.0, -40.0, -8.0), DVec3::X * 80.0, DVec3::new(0.0, 80.0, -6.0));
    let plate = rectangle(eye + DVec3::new(0.2, -1.0, -4.0), DVec3::X, DVec3::Y * 2.0);
    let geometry = soup(&[wall, plate].concat(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    // From before the wall onto it, most of them behind the plate.
    let across: Vec<Ray> = (0..64)
        .map(|row| ray(eye + DVec3::new(-2.0, 0.1 * f64::from(row) - 3.2, -4.5), DVec3::new(1.0, 0.0, -1.5)))
        .collect();
    let counts = |settings: &[(&str, &str)]| {
        let counters = counted(&gpu, &built_by(&tracer, &gpu, &geometry, settings), &across, settings);
        ["nodes_visited", "plane_tests", "box_tests", "layers_asked", "nodes_touched"].map(|name| of(&counters, name))
    };
    let published = counts(&[]);
    let lossless = counts(&LOSSLESS);
    let pixels = counts(&[&LOSSLESS[..], &[("levels", "0")]].concat());
    for [nodes, planes, boxes, layers, touched] in [published, lossless, pixels] {
        assert!(
            nodes == planes + boxes && touched <= nodes && layers >= 64,
            "{nodes} {planes} {boxes} {layers} {touched}"
        );
    }
    assert!(published[0] < lossless[0] && lossless[0] < pixels[0], "{published:?} {lossless:?} {pixels:?}");
    assert_eq!(counts(&[("traversal", "stack")]), published);
    let always = counts(&[("next_layer", "always")]);
    assert!(always[3] == 128 && always[0] > published[0] && published[3] < 128, "{always:?} {published:?}");
}

/// Proves that a ray whose nodes run out is given up with that status, and that a cap that suffices changes nothing.
#[test]
fn long_searches_are_given_up() {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let tracer = Quadtree::new(Arc::clone(&gpu)).unwrap();
    let structure = built_by(&tracer, &gpu, &geometry, &[]);
    let rays = rays(400);
    let by = |cap: &str| answer(&gpu, &structure, &rays, &[("max_steps", cap)], TraceTo::Hit).0;
    let (few, enough) = (by("5"), by("1000"));
    assert!(count(&few, Status::StepCap) > 50 && count(&enough, Status::StepCap) == 0);
    assert_eq!(enough, by("16384"));
}
