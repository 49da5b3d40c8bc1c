use std::sync::Arc;

use glam::{DVec3, Vec3};
use tracebench_api::{Geometry, Hit, Query, Status, Surface, SurfaceStatus, TraceTo, Viewpoint};
use tracebench_scenes::Material;

use super::*;
use crate::results::ImageRow;
use crate::truth::Truth;

mod f64_renderer;

/// Triangles with materials.
#[derive(Clone, Default)]
pub(super) struct Model {
    pub(super) positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    triangle_materials: Vec<u32>,
}

impl Model {
    /// A parallelogram whose front is where its edges turn counter-clockwise.
    fn quad(mut self, material: u32, at: [f32; 3], along: [f32; 3], up: [f32; 3]) -> Self {
        let [at, along, up] = [at, along, up].map(Vec3::from);
        let first = self.positions.len() as u32;
        self.positions.extend([at, at + along, at + along + up, at + up].map(<[f32; 3]>::from));
        self.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|corner| first + corner)));
        self.triangle_materials.extend([material; 2]);
        self
    }

    fn cuboid(self, material: u32, [x0, y0, z0]: [f32; 3], [x, y, z]: [f32; 3]) -> Self {
        let (right, up, front) = ([x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]);
        self.quad(material, [x0, y0, z0 + z], right, up)
            .quad(material, [x0, y0, z0], up, right)
            .quad(material, [x0, y0, z0], front, up)
            .quad(material, [x0 + x, y0, z0], up, front)
            .quad(material, [x0, y0, z0], right, front)
            .quad(material, [x0, y0 + y, z0], front, right)
    }

    pub(super) fn geometry(&self) -> Geometry {
        let Self { positions, triangles, triangle_materials } = self.clone();
        Geometry::with_materials(positions, triangles, triangle_materials, None).unwrap()
    }

    fn truth(&self) -> Truth {
        Truth::new(&self.geometry(), "of a test")
    }
}

const WHITE: u32 = 0;
const RED: u32 = 1;
const MIRROR: u32 = 2;
const GLASS: u32 = 3;

fn materials() -> Vec<Material> {
    let material =
        |base_color, metallic, roughness| Material { base_color, metallic, roughness, refractive_index: None };
    vec![
        material([0.7; 3], 0.0, 1.0),
        material([0.8, 0.2, 0.1], 0.0, 1.0),
        material([0.9, 0.8, 0.7], 1.0, 0.0),
        Material { refractive_index: Some(1.5), ..material([0.95; 3], 0.0, 0.0) },
    ]
}

fn stage(model: &Model) -> Stage {
    Stage::new(&materials(), &model.geometry())
}

fn looking(eye: [f32; 3], forward: [f32; 3], up: [f32; 3]) -> Viewpoint {
    let forward = Vec3::from(forward).normalize();
    let right = forward.cross(up.into()).normalize();
    let up = right.cross(forward);
    let [near, far] = [0.01, 100.0];
    Viewpoint { eye: eye.into(), forward, up, vertical_fov: 0.9, near, far, frame: [64, 32], face: 1 }
}

const SIZE: [u32; 2] = [64, 32];
const SEED: u64 = 7;

/// The truth's answers to a wave.
fn answers_of_truth(wave: &Wave, truth: &Truth) -> Vec<Answer> {
    wave.answers_of_hits(truth, |ray| truth.closest(&Ray64::from(&wave.rays[ray])))
}

/// The image of what `answers` says of each wave.
fn traced(
    stage: &Stage,
    effect: Effect,
    viewpoint: &Viewpoint,
    spp: u32,
    mut answers: impl FnMut(&Wave) -> Vec<Answer>,
) -> Paths {
    let mut paths = Paths::new(Arc::new(stage.clone()), effect, viewpoint, SIZE, spp, SEED);
    while let Some(wave) = paths.next_wave() {
        let answers = answers(&wave);
        paths.answer(&wave, &answers);
    }
    paths
}

fn true_image(model: &Model, stage: &Stage, effect: Effect, viewpoint: &Viewpoint, spp: u32) -> LinearImage {
    let truth = model.truth();
    traced(stage, effect, viewpoint, spp, |wave| answers_of_truth(wave, &truth)).image()
}

/// Each pixel's centre with the point of a plane that it shows, if the plane lies before the eye.
fn on_plane(viewpoint: &Viewpoint, at: DVec3, normal: DVec3) -> Vec<Option<(DVec3, DVec3)>> {
    let view = Viewpoint { frame: SIZE, ..*viewpoint }.frame_view();
    let pixel = |pixel: u32| {
        let direction =
            view.direction_through(f64::from(pixel % SIZE[0]) + 0.5, f64::from(pixel / SIZE[0]) + 0.5).normalize();
        let t = (at - view.eye).dot(normal) / direction.dot(normal);
        (t > 0.0).then(|| (view.eye + direction * t, direction))
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

fn close(found: [f32; 3], expected: DVec3) -> bool {
    DVec3::from(found.map(f64::from)).distance(expected) <= 1e-3 * expected.length() + 1e-6
}

/// Proves that under a sky alone a convex body of any colour shows exactly its colour times the sky (a white furnace), and that a lost
/// hit and a colour that is another are noticed.
#[test]
fn a_convex_body_in_a_furnace_shows_its_colour() {
    let model = Model::default().cuboid(RED, [-1.0; 3], [2.0; 3]);
    let viewpoint = looking([0.5, 1.8, 5.0], [-0.1, -0.3, -1.0], [0.0, 1.0, 0.0]);
    let stage = Stage { intensity: 0.0, sky: Vec3::ONE, ..stage(&model) };
    let red = DVec3::new(0.8, 0.2, 0.1);
    for effect in [Effect::Path, Effect::Diffuse] {
        let image = true_image(&model, &stage, effect, &viewpoint, 2);
        let centre = image.pixels[16 * 64 + 32];
        assert!(close(centre, red), "{centre:?}");
        let known = |pixel: &&[f32; 3]| close(**pixel, red) || close(**pixel, DVec3::ONE);
        // Of two samples at an edge one may see the sky.
        let mixed = |pixel: &&[f32; 3]| close(**pixel, (red + 1.0) / 2.0);
        assert!(image.pixels.iter().all(|pixel| known(&pixel) || mixed(&pixel)));
        assert!(!close(centre, DVec3::new(0.8, 0.2, 0.2)));
        let truth = model.truth();
        let lost = traced(&stage, effect, &viewpoint, 2, |wave| {
            let mut answers = answers_of_truth(wave, &truth);
            answers.iter_mut().filter(|answer| **answer != Answer::Miss).for_each(|answer| *answer = Answer::Miss);
            answers
        });
        assert!(close(lost.image().pixels[16 * 64 + 32], DVec3::ONE), "a lost hit is sky");
    }
}

/// Proves that a plane under a point light has the radiance of the inverse square and the cosine, in the effects that show direct light,
/// that the depth is what it is, and that open ground is lit by all rays of ao.
#[test]
fn a_lit_plane_is_lit_by_the_inverse_square_and_the_cosine() {
    let model = Model::default().quad(WHITE, [-50.0, 0.0, 50.0], [100.0, 0.0, 0.0], [0.0, 0.0, -100.0]);
    let viewpoint = looking([0.3, 3.0, 4.0], [0.0, -1.0, -0.4], [0.0, 1.0, 0.0]);
    let light = DVec3::new(0.5, 2.0, -0.5);
    let stage = Stage { light, intensity: 5.0, ..stage(&model) };
    let points = on_plane(&viewpoint, DVec3::ZERO, DVec3::Y);
    let expected = |point: DVec3| {
        let way = light - point;
        DVec3::splat(0.7 / std::f64::consts::PI * 5.0 * way.y / way.length().powi(3))
    };
    for effect in [Effect::Primary, Effect::Mirror, Effect::Path, Effect::Diffuse] {
        let stage = Stage { mirror_first: false, sky: Vec3::ZERO, ..stage.clone() };
        let image = true_image(&model, &stage, effect, &viewpoint, 1);
        for (pixel, point) in image.pixels.iter().zip(&points) {
            assert!(close(*pixel, expected(point.unwrap().0)), "{effect:?} {pixel:?}");
        }
    }
    let depths = true_image(&model, &stage, Effect::Depth, &viewpoint, 1);
    for (pixel, point) in depths.pixels.iter().zip(&points) {
        let depth = (point.unwrap().0 - viewpoint.eye.as_dvec3()).dot(viewpoint.forward.as_dvec3());
        assert!(close(*pixel, DVec3::splat(1.0 / (1.0 + depth / (0.5 * stage.diagonal)))));
    }
    let normals = true_image(&model, &stage, Effect::Normals, &viewpoint, 1);
    assert!(normals.pixels.iter().all(|pixel| close(*pixel, DVec3::new(0.5, 1.0, 0.5))));
    let open = true_image(&model, &stage, Effect::Ao, &viewpoint, 2);
    assert!(open.pixels.iter().all(|pixel| *pixel == [1.0; 3]));
}

/// Proves that a mirror shows the lit plane of the mirrored eye, times its colour, and the sky beside it; and that a normal that is off
/// by a degree is noticed.
#[test]
fn a_mirror_shows_what_its_image_sees() {
    let model = Model::default().quad(MIRROR, [-50.0, 0.0, 50.0], [100.0, 0.0, 0.0], [0.0, 0.0, -100.0]).quad(
        WHITE,
        [-50.0, 0.0, -10.0],
        [100.0, 0.0, 0.0],
        [0.0, 6.0, 0.0],
    );
    let viewpoint = looking([0.3, 2.0, 4.0], [0.0, -0.5, -1.0], [0.0, 1.0, 0.0]);
    let light = DVec3::new(0.5, 3.0, -5.0);
    let stage = Stage { light, intensity: 20.0, ..stage(&model) };
    let colour = DVec3::new(0.9, 0.8, 0.7);
    let truth = model.truth();
    let image = |turned: f64| {
        let turn = glam::DQuat::from_rotation_x(turned.to_radians());
        let paths = traced(&stage, Effect::Mirror, &viewpoint, 1, |wave| {
            let mut answers = answers_of_truth(wave, &truth);
            for answer in &mut answers {
                if let Answer::Hit { normal, material: MIRROR, .. } = answer {
                    *normal = turn * *normal;
                }
            }
            answers
        });
        paths.image()
    };
    let mut counts = [0; 3];
    let wrong = |image: &LinearImage, counts: &mut [u32; 3]| {
        let mut wrong = 0;
        for (pixel, seen) in image.pixels.iter().zip(on_plane(&viewpoint, DVec3::ZERO, DVec3::Y)) {
            let Some((point, direction)) = seen else { continue };
            let mirrored = direction * DVec3::new(1.0, -1.0, 1.0);
            let t = (-10.0 - point.z) / mirrored.z;
            let at = point + mirrored * t;
            let expected = if point.z < -10.0 {
                continue;
            } else if at.y < 5.99 {
                counts[0] += 1;
                let way = light - at;
                colour * (0.7 / std::f64::consts::PI * 20.0 * way.z / way.length().powi(3))
            } else if at.y > 6.01 {
                counts[1] += 1;
                colour * stage.sky.as_dvec3()
            } else {
                continue;
            };
            wrong += u32::from(!close(*pixel, expected));
        }
        wrong
    };
    assert_eq!(wrong(&image(0.0), &mut counts), 0);
    assert!(counts[0] > 100 && counts[1] > 100, "{counts:?}");
    assert!(wrong(&image(1.0), &mut counts) > 100);
}

/// Proves that a pane shows what is behind it where it is, dimmed by its colour at either side.
#[test]
fn a_pane_shows_what_is_behind() {
    let wall = Model::default().quad(WHITE, [-25.0, -15.0, -10.0], [55.0, 0.0, 0.0], [0.0, 30.0, 0.0]);
    let pane = wall.clone().cuboid(GLASS, [-7.0, -6.0, -1.0], [19.0, 13.0, 4e-3]);
    let viewpoint = looking([0.3, 0.2, 4.0], [0.3, 0.1, -1.0], [0.0, 1.0, 0.0]);
    let light = DVec3::new(0.5, 3.0, -5.0);
    let stage = Stage { light, intensity: 20.0, mirror_first: false, ..stage(&pane) };
    let through = true_image(&pane, &stage, Effect::Mirror, &viewpoint, 1);
    let behind = true_image(&wall, &stage, Effect::Mirror, &viewpoint, 1);
    for (through, behind) in through.pixels.iter().zip(&behind.pixels) {
        assert!(close(*through, DVec3::from(behind.map(f64::from)) * 0.95 * 0.95), "{through:?} {behind:?}");
    }
}

/// A room without a roof, with a mirror, a glass block and a box that throws a shadow.
fn room() -> Model {
    Model::default()
        .quad(WHITE, [-2.0, 0.0, 2.0], [4.0, 0.0, 0.0], [0.0, 0.0, -4.0])
        .quad(RED, [-2.0, 0.0, 2.0], [0.0, 0.0, -4.0], [0.0, 2.5, 0.0])
        .quad(MIRROR, [2.0, 0.0, -2.0], [0.0, 0.0, 3.7], [0.0, 1.9, 0.0])
        .quad(WHITE, [-2.0, 0.0, -2.0], [4.0, 0.0, 0.0], [0.0, 2.1, 0.0])
        .cuboid(RED, [-0.9, 0.02, -0.8], [0.6, 0.7, 0.5])
        .cuboid(GLASS, [0.3, 0.05, -0.3], [0.5, 0.9, 0.5])
}

fn room_view() -> Viewpoint {
    looking([0.1, 1.3, 3.1], [0.03, -0.21, -1.0], [0.0, 1.0, 0.0])
}

/// Proves that every effect gives the pictures of a renderer that is written alone, recursively and in f64, within 1/255 at every pixel;
/// and that a wrong normal, a lost hit and a wrong shadow are noticed.
#[test]
fn every_effect_is_that_of_a_recursive_renderer() {
    let (model, viewpoint) = (room(), room_view());
    let (stage, truth) = (stage(&model), model.truth());
    for effect in Effect::ALL {
        let expected = f64_renderer::image(&model, &stage, effect, &viewpoint);
        let exposure = Exposure::of(effect, &expected);
        let beside = |image: &LinearImage| {
            beyond(&expected.developed(exposure), &image.developed(exposure))
                .unwrap()
                .iter()
                .filter(|far| **far)
                .count()
        };
        let true_answers = |wave: &Wave| answers_of_truth(wave, &truth);
        let image = traced(&stage, effect, &viewpoint, f64_renderer::SPP, true_answers).image();
        assert_eq!(beside(&image), 0, "{effect:?}");
        let corrupted = |corrupt: &dyn Fn(&Wave, &mut Answer)| {
            let paths = traced(&stage, effect, &viewpoint, f64_renderer::SPP, |wave| {
                let mut answers = true_answers(wave);
                answers.iter_mut().for_each(|answer| corrupt(wave, answer));
                answers
            });
            beside(&paths.image())
        };
        let missed = corrupted(&|wave, answer| {
            if wave.number == 0 && matches!(answer, Answer::Hit { material: RED, .. }) {
                *answer = Answer::Miss;
            }
        });
        assert!(missed > 20, "{effect:?} {missed}");
        if effect != Effect::Depth {
            let turned = corrupted(&|_, answer| {
                if let Answer::Hit { normal, .. } = answer {
                    *normal = (*normal + DVec3::new(0.1, 0.12, 0.07)).normalize();
                }
            });
            assert!(turned > 20, "{effect:?} {turned}");
        }
        if effect.asks_any() {
            let lit = corrupted(&|wave, answer| {
                if wave.query == Query::Any {
                    *answer = Answer::Miss;
                }
            });
            assert!(lit > 20, "{effect:?} {lit}");
        }
    }
}

/// Proves that the first rays are those of the ray set `primary`, whose first samples they are, and that pictures do not depend on which
/// rays came before.
#[test]
fn the_first_rays_are_primary_rays() {
    let (model, viewpoint) = (room(), room_view());
    let first =
        |spp| Paths::new(Arc::new(stage(&model)), Effect::Path, &viewpoint, SIZE, spp, SEED).next_wave().unwrap();
    let primary = crate::rays::primary_rays(&viewpoint, SIZE);
    assert_eq!(*first(1).rays, primary);
    let several = first(3);
    assert!(several.rays.chunks(3).zip(&primary).all(|(three, centre)| three[0] == *centre && three[1] != *centre));
    assert_eq!(
        (Wave::name_of(several.number), Wave::name_of(1), Wave::name_of(4)),
        ("eye".into(), "shadow 0".into(), "bounce 2".into())
    );
}

/// Proves that a pixel names the first wave that was answered differently, and no other pixel does.
#[test]
fn a_difference_names_its_wave() {
    let (model, viewpoint) = (room(), room_view());
    let (stage, truth) = (stage(&model), model.truth());
    let right = traced(&stage, Effect::Path, &viewpoint, 2, |wave| answers_of_truth(wave, &truth));
    for number in [0, 1, 2, 3, 5] {
        let mut pixel = 0;
        let wrong = traced(&stage, Effect::Path, &viewpoint, 2, |wave| {
            let mut answers = answers_of_truth(wave, &truth);
            if wave.number == number {
                let ray = answers.len() / 2;
                pixel = wave.paths[ray] / 2;
                answers[ray] = match (answers[ray], wave.query) {
                    (Answer::Miss, Query::Any) => Answer::Occluded,
                    (Answer::Miss, Query::Closest) => Answer::Lost { t: 1.0 },
                    _ => Answer::Miss,
                };
            }
            answers
        });
        let first = wrong.first_difference(&right);
        assert_eq!(first.iter().filter(|found| found.is_some()).count(), 1);
        assert_eq!(first[pixel as usize], Some(number));
    }
    let again = traced(&stage, Effect::Path, &viewpoint, 2, |wave| answers_of_truth(wave, &truth));
    assert!(again.first_difference(&right).iter().all(Option::is_none));
}

/// Proves that paths that follow others trace their rays whatever they answer, and show the same picture where they answer the same.
#[test]
fn followers_trace_their_leader_s_rays() {
    let (model, viewpoint) = (room(), room_view());
    let (stage, truth) = (Arc::new(stage(&model)), model.truth());
    for misses in [false, true] {
        let make = || Paths::new(Arc::clone(&stage), Effect::Path, &viewpoint, SIZE, 1, SEED);
        let (mut leader, mut follower) = (make(), make());
        while let Some((wave, own)) = leader.next_wave().zip(follower.next_wave()) {
            assert_eq!((wave.number, &wave.rays, &wave.paths), (own.number, &own.rays, &own.paths));
            let answers = answers_of_truth(&wave, &truth);
            leader.answer(&wave, &answers);
            let answers = if misses { vec![Answer::Miss; answers.len()] } else { answers };
            follower.answer(&own, &answers);
            follower.follow(&leader);
        }
        let sky = LinearImage { size: SIZE, pixels: vec![stage.sky.into(); 64 * 32] };
        assert_eq!(follower.image(), if misses { sky } else { leader.image() });
    }
}

/// Proves that a tracer's answers are read as they are: every status without a hit is a miss, a surface that is not written is lost, and
/// too few answers are none.
#[test]
fn a_tracer_s_answers_are_read_as_they_are() {
    let viewpoint = room_view();
    let mut paths = Paths::new(Arc::new(stage(&room())), Effect::Path, &viewpoint, [3, 1], 1, SEED);
    let wave = paths.next_wave().unwrap();
    assert_eq!((wave.query, wave.end), (Query::Closest, TraceTo::Surface));
    let hit = Hit { t: 2.0, primitive: 1, u: 0.0, v: 0.0, status: Status::Hit as u32 };
    let hits = [Hit::miss(Status::LeftViews), hit, hit];
    let written = SurfaceStatus::Written as u32;
    let surface = Surface { position: [1.0, 2.0, 3.0], material: 1, normal: [0.0, 0.0, 1.0], status: written };
    let surfaces = [Surface::none(SurfaceStatus::NoHit), surface, Surface::none(SurfaceStatus::Lost)];
    let position = DVec3::new(1.0, 2.0, 3.0);
    let found = Answer::Hit { t: 2.0, position, normal: DVec3::Z, material: 1 };
    let answers = wave.answers_of_tracer(&hits, Some(&surfaces)).unwrap();
    assert_eq!(answers, [Answer::Miss, found, Answer::Lost { t: 2.0 }]);
    let lost = Answer::Lost { t: 2.0 };
    assert_eq!(wave.answers_of_tracer(&hits, None).unwrap(), [Answer::Miss, lost, lost]);
    assert_eq!(wave.answers_of_tracer(&hits[1..], None), None);
    paths.answer(&wave, &answers);
    assert_eq!(paths.image().pixels[2], [0.0; 3], "what is lost is black");
}

fn constant(value: u8) -> Image8 {
    Image8 { size: [64, 32], pixels: vec![[value; 3]; 64 * 32] }
}

/// FLIP of two constant greys by its paper's equations (Andersson and others, *FLIP: A Difference Evaluator for Alternating Images*, 2020,
/// section 4.1): filters change nothing and there are no edges.
fn flip_of_greys(one: u8, other: u8) -> f64 {
    let lightness = |value: u8| {
        let value = f64::from(value) / 255.0;
        let linear = if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
        let cut: f64 = 6.0 / 29.0;
        let root = if linear > cut.powi(3) { linear.cbrt() } else { linear / (3.0 * cut * cut) + 4.0 / 29.0 };
        116.0 * root - 16.0
    };
    // CIELAB of sRGB's green and blue, with the Hunt effect: a and b times a hundredth of L.
    let hunt = |[l, a, b]: [f64; 3]| [l, 0.01 * l * a, 0.01 * l * b];
    let (green, blue) = (hunt([87.735, -86.183, 83.180]), hunt([32.301, 79.197, -107.857]));
    let hyab = (green[0] - blue[0]).abs() + (green[1] - blue[1]).hypot(green[2] - blue[2]);
    let most = hyab.powf(0.7);
    let difference = (lightness(one) - lightness(other)).abs().powf(0.7);
    let bend = 0.4 * most;
    if difference < bend { 0.95 / bend * difference } else { 0.95 + (difference - bend) / (most - bend) * 0.05 }
}

/// Proves MSE, PSNR, SSIM and FLIP of constant images against their formulas, that equal images are equal, and that one pixel shows.
#[test]
fn constant_images_have_the_likeness_of_the_formulas() {
    let equal = likeness(Effect::Path, &constant(90), &constant(90)).unwrap();
    assert_eq!(equal, ImageRow { ssim: 1.0, flip: Some(0.0), ..ImageRow::default() });
    for [one, other] in [[0, 255], [100, 140], [200, 190], [30, 31]] {
        let found = likeness(Effect::Path, &constant(one), &constant(other)).unwrap();
        let (x, y) = (f64::from(one), f64::from(other));
        let mse = ((x - y) / 255.0).powi(2);
        assert!((found.mse - mse).abs() < 1e-6 && (found.psnr_db.unwrap() + 10.0 * mse.log10()).abs() < 1e-4);
        let c1 = (0.01_f64 * 255.0).powi(2);
        let ssim = (2.0 * x * y + c1) / (x * x + y * y + c1);
        assert!((found.ssim - ssim).abs() < 1e-9, "{found:?} {ssim}");
        let flip = flip_of_greys(one, other);
        assert!((found.flip.unwrap() - flip).abs() < 2e-3, "{found:?} {flip}");
        assert_eq!(found.beyond, if one.abs_diff(other) > 1 { 64 * 32 } else { 0 });
    }
    let mut spotted = constant(90);
    spotted.pixels[70] = [90, 92, 90];
    let found = likeness(Effect::Path, &constant(90), &spotted).unwrap();
    assert!(found.mse > 0.0 && found.ssim < 1.0 && found.flip.unwrap() > 0.0 && found.beyond == 1);
    assert_eq!(likeness(Effect::Normals, &constant(90), &spotted).unwrap().flip, None);
}

/// Proves that images of other sizes and empty ones are errors, not ends of the program.
#[test]
fn images_of_other_sizes_are_errors() {
    let wide = Image8 { size: [32, 64], ..constant(1) };
    let empty = Image8 { size: [0, 0], pixels: Vec::new() };
    assert_eq!(likeness(Effect::Path, &constant(1), &wide), Err(ImageError::Size([64, 32], [32, 64])));
    assert_eq!(likeness(Effect::Path, &empty, &empty), Err(ImageError::Empty));
    assert!(error_picture(Effect::Path, &constant(1), &wide).is_err() && animation(&[], 1.0).is_err());
    assert!(strip(&[vec![constant(1)], vec![wide]]).is_err() && strip(&[]).is_err());
}

/// Proves that exposure puts nine of ten lit pixels at most at 0.6, and that errors are black where there are none.
#[test]
fn exposure_and_errors_are_as_stated() {
    let pixels = (0..200).map(|step| [(step as f32 - 100.0).max(0.0); 3]).collect();
    let ramp = LinearImage { size: [20, 10], pixels };
    let Exposure(scale) = Exposure::of(Effect::Path, &ramp);
    assert!((scale * 90.0 - 0.6).abs() < 0.01, "{scale}");
    assert_eq!(Exposure::of(Effect::Ao, &ramp), Exposure(1.0));
    let shown =
        LinearImage { size: [4, 1], pixels: vec![[0.0; 3], [0.5; 3], [1.0; 3], [9.0; 3]] }.developed(Exposure(1.0));
    assert_eq!(shown.pixels, [[0; 3], [188; 3], [255; 3], [255; 3]]);
    for effect in [Effect::Path, Effect::Normals] {
        let errors = error_picture(effect, &constant(9), &constant(9)).unwrap();
        let dark = errors.pixels[0];
        assert!(errors.pixels.iter().all(|pixel| *pixel == dark && dark.iter().all(|channel| *channel < 10)));
        let bright = error_picture(effect, &constant(9), &constant(250)).unwrap();
        assert!(
            bright.pixels[9].iter().map(|channel| u32::from(*channel)).sum::<u32>() > 400,
            "{:?}",
            bright.pixels[9]
        );
    }
}

/// A wall and a panel before it, moved to the right.
fn panel(moved: f32) -> Model {
    Model::default().quad(WHITE, [-50.0, -50.0, -10.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0]).quad(
        RED,
        [-1.0 + moved, -1.0, -5.0],
        [2.0, 0.0, 0.0],
        [0.0, 2.0, 0.0],
    )
}

/// Proves that motion is where points are seen next: nowhere else where nothing moves, a few pixels on where a panel moves, behind it
/// where it covers the wall, and out of the picture where the camera turns away.
#[test]
fn motion_is_where_points_are_seen_next() {
    let viewpoint = looking([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
    let still = motion((&panel(0.0).truth(), &viewpoint), (&panel(0.0).truth(), &viewpoint), SIZE);
    assert!(still.iter().enumerate().all(|(pixel, to)| *to == Some(pixel as u32)));
    // A pixel at the panel's depth.
    let pixel = 5.0 * 2.0 * (0.45_f32).tan() / 32.0;
    let moved = motion((&panel(0.0).truth(), &viewpoint), (&panel(3.0 * pixel).truth(), &viewpoint), SIZE);
    let half = (1.0 / pixel) as u32;
    for (from, to) in moved.iter().enumerate() {
        let from = from as u32;
        let (x, y) = ((from % 64).abs_diff(32), (from / 64).abs_diff(16));
        let is_panel = x + 1 < half && y + 1 < half;
        let is_beside = (36 + half..64).contains(&(from % 64)) || y > half + 1;
        if is_panel || is_beside {
            assert_eq!(*to, Some(if is_panel { from + 3 } else { from }), "{from}");
        }
    }
    let covered = |to: &Vec<Option<u32>>| to.iter().filter(|to| to.is_none()).count();
    let rows = (2.0 / pixel) as usize;
    assert!((2 * rows..=4 * rows + 4).contains(&covered(&moved)), "{} of {rows} rows", covered(&moved));
    let turned = looking([0.0; 3], [0.3, 0.0, -1.0], [0.0, 1.0, 0.0]);
    let turned = motion((&panel(0.0).truth(), &viewpoint), (&panel(0.0).truth(), &turned), SIZE);
    assert!(covered(&turned) > 100 && turned[16 * 64 + 32].is_some_and(|to| to % 64 < 31));
    // The sky moves with the camera's turns alone.
    let small = Model::default().quad(WHITE, [0.0, 0.0, -5.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]).truth();
    let aside = looking([1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
    let sky = motion((&small, &viewpoint), (&small, &aside), SIZE);
    assert_eq!(sky[5], Some(5));
}

/// Proves that an error that stays on its moving surface does not flicker, that one that stays in its pixel or comes and goes does, by
/// how much it changes, and that without motion there is no figure.
#[test]
fn errors_flicker_where_they_leave_their_surface() {
    let to_the_right: Vec<Option<u32>> = (0..9).map(|pixel| (pixel < 8).then_some(pixel + 1)).collect();
    let stays: Vec<Option<u32>> = (0..9).map(Some).collect();
    let error = |at: usize| -> Vec<[f32; 3]> { (0..9).map(|pixel| [f32::from(u8::from(pixel == at)); 3]).collect() };
    assert_eq!(image_flicker(&error(3), &error(4), &to_the_right), Some(0.0));
    assert_eq!(image_flicker(&error(3), &error(3), &to_the_right), Some(0.25));
    assert_eq!(image_flicker(&error(3), &error(3), &stays), Some(0.0));
    assert_eq!(image_flicker(&error(3), &error(9), &stays), Some(1.0 / 9.0));
    assert_eq!(image_flicker(&error(3), &error(4), &[None; 9]), None);
}

/// Proves that frames come back from an animated PNG as they were, with their delay, and that stills of a strip are where they belong.
#[test]
fn frames_are_read_back_as_they_were() {
    let frames: Vec<Image8> = [10, 200, 90].map(constant).into();
    let bytes = animation(&frames, 8.0).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
    for frame in &frames {
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, frame.pixels.as_flattened());
        let control = reader.info().frame_control().unwrap();
        assert_eq!((control.delay_num, control.delay_den), (125, 1000));
    }
    let still = animation(&frames[..1], 8.0).unwrap();
    assert!(png::Decoder::new(std::io::Cursor::new(&still)).read_info().unwrap().info().animation_control().is_none());
    let strip = strip(&[vec![constant(1), constant(2)], vec![constant(3)]]).unwrap();
    assert_eq!(strip.size, [132, 68]);
    let at = |x: usize, y: usize| strip.pixels[y * 132 + x][0];
    assert_eq!([at(0, 0), at(63, 31), at(65, 0), at(68, 0), at(0, 36), at(70, 40)], [1, 1, 255, 2, 3, 255]);
    // What is cut out of a strip is what was put in.
    let of = |rows: &[Vec<Image8>]| animation(&[super::strip(rows).unwrap()], 1.0).unwrap();
    let sheet = of(&[vec![constant(1), constant(2)], vec![constant(3), constant(4)], vec![constant(5)]]);
    for (place, rows, colours) in [([1, 0], 2, &[2, 4][..]), ([0, 1], 2, &[3, 5]), ([0, 2], 1, &[5])] {
        let column: Vec<_> = colours.iter().map(|colour| vec![constant(*colour)]).collect();
        assert_eq!(cut(&sheet, [64, 32], place, rows).unwrap(), of(&column));
    }
    assert!(cut(&sheet, [64, 32], [2, 0], 1).is_err() && cut(&sheet, [64, 32], [0, 2], 2).is_err());
    assert!(cut(b"no picture", [64, 32], [0, 0], 1).is_err());
}

/// Proves that the brute force of the renderer in f64 and the truth's test are not the same code that agrees with itself: they give the
/// same distances.
#[test]
fn the_recursive_renderer_finds_what_truth_finds() {
    let model = room();
    let truth = model.truth();
    let rays = crate::rays::primary_rays(&room_view(), SIZE);
    for ray in rays.iter().map(Ray64::from) {
        let by_renderer = f64_renderer::closest(&model, ray.origin, ray.direction, f64::INFINITY);
        let by_truth = truth.closest(&ray);
        assert_eq!(by_renderer.is_some(), by_truth.is_some());
        if let (Some(one), Some(other)) = (by_renderer, by_truth) {
            assert!((one.t - other.t).abs() < 1e-9);
        }
    }
}
