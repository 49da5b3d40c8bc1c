//! Rays that start at or near an eye.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use tracebench_api::{Ray, View, Viewpoint};

use super::sampling::Stream;
use super::{Pixel, RayScene, Starts, unbounded};
use crate::viewpoint::Pose;

/// How far `temporal` moves the eye forward in a scene without a camera path, in scene diagonals.
const TEMPORAL_STEP_DIAGONALS: f64 = 0.01;

/// The primary rays of an image: through pixel centres, row by row from the top.
pub fn primary_rays(viewpoint: &Viewpoint, image: [u32; 2]) -> Vec<Ray> {
    through_pixels(viewpoint, image).into_iter().map(|(_, ray)| ray).collect()
}

/// The view whose pixels are those of the image.
pub(crate) fn image_view(viewpoint: &Viewpoint, image: [u32; 2]) -> View {
    Viewpoint { frame: image, ..*viewpoint }.frame_view()
}

/// One ray for each pixel, given its centre.
fn each_pixel([width, height]: [u32; 2], ray: impl Fn(f64, f64) -> Ray + Sync) -> Vec<(Pixel, Ray)> {
    let of_pixel = |pixel: u32| {
        let (x, y) = (f64::from(pixel % width), f64::from(pixel / width));
        (pixel, ray(x + 0.5, y + 0.5))
    };
    (0..width * height).into_par_iter().map(of_pixel).collect()
}

fn through_pixels(viewpoint: &Viewpoint, image: [u32; 2]) -> Vec<(Pixel, Ray)> {
    let view = image_view(viewpoint, image);
    each_pixel(image, |x, y| ray_through(viewpoint, &view, [x, y]))
}

/// From the eye through a place of its image, in pixels.
pub(crate) fn ray_through(viewpoint: &Viewpoint, view: &View, [x, y]: [f64; 2]) -> Ray {
    // The eye itself, not its way through f64 and back.
    Ray { origin: viewpoint.eye.into(), ..unbounded(view.eye, view.direction_through(x, y).normalize()) }
}

pub(super) fn primary(scene: &RayScene<'_>) -> Vec<(Pixel, Ray)> {
    through_pixels(scene.viewpoint, scene.image)
}

/// From an eye to the side, looking the same way.
pub(super) fn stereo(scene: &RayScene<'_>) -> Vec<(Pixel, Ray)> {
    let right = scene.viewpoint.frame_view().right;
    let eye = scene.viewpoint.eye.as_dvec3() + right * scene.parameters.stereo_offset;
    through_pixels(&Viewpoint { eye: eye.as_vec3(), ..*scene.viewpoint }, scene.image)
}

/// From the camera a little later: eye and target move as those of the camera path do from its start, or, without a
/// path, a hundredth of the diagonal straight ahead.
pub(super) fn temporal(scene: &RayScene<'_>) -> Vec<(Pixel, Ray)> {
    let Viewpoint { eye, forward, up, vertical_fov, .. } = *scene.viewpoint;
    let (eye_moves, target_moves) = match scene.path {
        Some(path) => {
            let (start, later) = (path.at(0.0), path.at(scene.parameters.temporal_shift_s));
            (Vec3::from(later.eye) - Vec3::from(start.eye), Vec3::from(later.target) - Vec3::from(start.target))
        }
        None => {
            let step = forward * (TEMPORAL_STEP_DIAGONALS * scene.truth.diagonal()) as f32;
            (step, step)
        }
    };
    // A target at the distance of the path's own, so that it turns as far as the path does.
    let distance = scene.path.map_or(1.0, |path| {
        let start = path.at(0.0);
        Vec3::from(start.eye).distance(Vec3::from(start.target))
    });
    let target = eye + forward * distance + target_moves;
    let eye = eye + eye_moves;
    // Paths are upright.
    let up = if scene.path.is_some() { Vec3::Y } else { up };
    let later = Pose { name: String::new(), eye, target, up, vertical_fov };
    through_pixels(&later.viewpoint(scene.truth.geometry(), scene.image, 1), scene.image)
}

/// From all over a thin lens through the points of the plane in focus that the pixels' centres show, several a pixel.
pub(super) fn lens(scene: &RayScene<'_>, primary: &Starts) -> Vec<(Pixel, Ray)> {
    let view = image_view(scene.viewpoint, scene.image);
    let diagonal = scene.truth.diagonal();
    let radius = scene.parameters.lens_aperture / 2.0 * diagonal;
    let set = scene.parameters.lens_focus * diagonal;
    let focus = if set > 0.0 { set } else { centre_depth(scene, primary, &view).unwrap_or(0.5 * diagonal) };
    let count = scene.parameters.lens_count;
    let [width, height] = scene.image;
    let of_pixel = |pixel: u32| {
        let (x, y) = (f64::from(pixel % width) + 0.5, f64::from(pixel / width) + 0.5);
        let point = view.eye + view.direction_through(x, y) * focus;
        (0..count).map(move |copy| {
            let index = u64::from(pixel) * u64::from(count) + u64::from(copy);
            let (across, upward, _) = Stream::new(scene.seed, LENS_TAG, index).disk();
            let origin = view.eye + (view.right * across + view.up * upward) * radius;
            (pixel, unbounded(origin, (point - origin).normalize_or(view.forward)))
        })
    };
    (0..width * height).into_par_iter().flat_map_iter(of_pixel).collect()
}

/// Tag of the lens's streams.
const LENS_TAG: u64 = 10;

/// The eye depth of what the primary ray of the image's central pixel hits.
fn centre_depth(scene: &RayScene<'_>, primary: &Starts, view: &View) -> Option<f64> {
    let [width, height] = scene.image;
    let centre = (height / 2 * width + width / 2) as usize;
    let hit = primary.answers.get(centre)?.hit?;
    let ray = &primary.rays[centre];
    Some(hit.t * DVec3::from(ray.direction.map(f64::from)).dot(view.forward))
}

/// From a square of parallel cameras: the image is a square of smaller images, one for each.
pub(super) fn light_field(scene: &RayScene<'_>) -> Vec<(Pixel, Ray)> {
    let view = image_view(scene.viewpoint, scene.image);
    let cameras = f64::from(scene.parameters.light_field_cameras);
    let width = scene.parameters.light_field_width * scene.truth.diagonal();
    let size = scene.image.map(f64::from);
    // Which camera, from -1/2 to 1/2 over the square, and where in its image.
    let split = |at: f64, size: f64| {
        let camera = (at / size * cameras).floor();
        let place = if cameras > 1.0 { camera / (cameras - 1.0) - 0.5 } else { 0.0 };
        (place * width, at * cameras - camera * size)
    };
    each_pixel(scene.image, |x, y| {
        let ((across, x), (down, y)) = (split(x, size[0]), split(y, size[1]));
        let origin = view.eye + view.right * across - view.up * down;
        unbounded(origin, view.direction_through(x, y).normalize())
    })
}
