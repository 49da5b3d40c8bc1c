//! Pictures of what a tracer answers to primary rays.

pub(crate) mod painted;

use std::path::Path;

use clap::ValueEnum;
use glam::DVec3;
use tracebench_api::{Hit, NO_PRIMITIVE, Query};
use tracebench_scenes::Mesh;

use crate::files;
use crate::files::FileError;
use crate::judge::{Class, Rule};
use crate::measure::TracerCache;
use crate::measure::session::PreparedRays;
use crate::measure::{self, LoadedScene, RunError};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::registry::Device;
use crate::truth::{Cache, Ray64};

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PictureKind {
    /// Base colours lit from the eye, from the tracer's own hits.
    Shaded,
    /// Linear eye depth, near is bright.
    Depth,
    /// Each ray's class under the footprint rule, in false colours.
    Error,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// Scene, tracer or device failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] FileError),
    /// The picture could not be encoded.
    #[error("cannot encode the picture: {0}")]
    Encode(String),
}

type Rgb = [u8; 3];

/// Colours of the classes, and of ambiguous any-hit rays.
const CLASS_COLOURS: [(Class, Rgb); 6] = [
    (Class::TrueHit, [210, 210, 210]),
    (Class::TrueMiss, [245, 245, 245]),
    (Class::FalseHit, [230, 60, 180]),
    (Class::FalseMiss, [215, 40, 40]),
    (Class::Early, [240, 150, 30]),
    (Class::Late, [40, 100, 220]),
];
const AMBIGUOUS_COLOUR: Rgb = [120, 90, 40];
const BACKGROUND: Rgb = [32, 36, 48];

/// Draws a picture of the plan's one scene by its one tracer, and gives its legend, a line an entry.
///
/// # Errors
/// [`PictureError`] as its variants say; nothing is written then.
pub fn draw(
    plan: &Plan,
    what: PictureKind,
    device: &Device,
    path: &Path,
    progress: &Progress,
) -> Result<Vec<String>, PictureError> {
    // Said before the work is done, not after.
    files::check_writable(path)?;
    let request = &plan.tracers[0];
    let Some(scene) = measure::load(plan, progress)?.into_iter().next() else {
        return Err(RunError::Nothing("there is no scene".to_owned()).into());
    };
    let mesh = scene.mesh.clone();
    let loaded = measure::prepare(plan, scene, device, &Cache::of_user(), progress)?;
    let session = &loaded.session;
    let name = request.name().to_owned();
    let failed = |error| RunError::Tracer(name.clone(), error);
    let mut config = TracerCache::default().config(request, device).map_err(failed)?;
    session.sample_build(&mut config).map_err(failed)?;
    let [width, height] = plan.preset.ray_image;
    let Some(rays) = session.rays.first() else {
        return Err(RunError::Nothing("there are no primary rays".to_owned()).into());
    };
    let mut buffer = session.hit_buffer(&config, rays).map_err(failed)?;
    session.sample_trace(&config, rays, &mut buffer, 1).map_err(failed)?;
    let hits = buffer.read(session.gpu()).map_err(failed)?;
    // The judge refuses answers that are none; pictures must not show them either.
    session.judge(&config, rays, &hits).map_err(RunError::from)?;
    let (pixels, legend) = match what {
        PictureKind::Shaded => (shaded(&loaded, &mesh, rays, &hits, width as usize), Vec::new()),
        PictureKind::Depth => depth(&loaded, rays, &hits),
        PictureKind::Error => errors(&session.classes(&name, rays, Rule::Footprint, &hits).map_err(RunError::from)?),
    };
    write_png(path, width, height, &pixels)?;
    Ok(legend)
}

fn points(rays: &PreparedRays, hits: &[Hit]) -> Vec<Option<DVec3>> {
    let point = |(ray, hit): (&tracebench_api::Ray, &Hit)| hit.is_hit().then(|| Ray64::from(ray).at(f64::from(hit.t)));
    rays.buffer.host.iter().zip(hits).map(point).collect()
}

/// Lambert's cosine with a light at the eye. Where the tracer names no triangle the normal comes from neighbouring hits.
fn shaded(loaded: &LoadedScene, mesh: &Mesh, rays: &PreparedRays, hits: &[Hit], width: usize) -> Vec<Rgb> {
    let points = points(rays, hits);
    let truth = loaded.session.truth();
    let shade = |index: usize| {
        let Some(point) = points[index] else { return BACKGROUND };
        let hit = &hits[index];
        let named = hit.primitive != NO_PRIMITIVE;
        let normal = if named { truth.normal(hit.primitive) } else { normal_from_neighbours(&points, index, width) };
        let material = mesh
            .triangle_materials
            .get(hit.primitive as usize)
            .and_then(|material| mesh.materials.get(*material as usize));
        let colour = material.map_or([0.75; 3], |material| material.base_color);
        let direction = DVec3::from(rays.buffer.host[index].direction.map(f64::from));
        let cosine = normal.dot(direction).abs();
        // A little of the distance, so that parallel surfaces one behind the other can be distinguished.
        let nearness = 1.0 / (1.0 + 0.5 * point.distance(loaded.session.viewpoint().eye.as_dvec3()) / truth.diagonal());
        colour.map(|channel| to_srgb(f64::from(channel) * (0.15 + 0.85 * cosine) * nearness))
    };
    (0..hits.len()).map(shade).collect()
}

fn normal_from_neighbours(points: &[Option<DVec3>], index: usize, width: usize) -> DVec3 {
    let here = points[index];
    let step = |neighbour: Option<usize>| Some(points.get(neighbour?).copied().flatten()? - here?);
    // Of the two neighbours on an axis the one that is closer, so that edges stay sharp.
    let closer = |before: Option<DVec3>, after: Option<DVec3>| match (before, after) {
        (Some(before), Some(after)) if before.length() < after.length() => -before,
        (_, Some(after)) => after,
        (before, None) => -before.unwrap_or(DVec3::ZERO),
    };
    let column = index % width;
    let left = (column > 0).then(|| index - 1);
    let right = (column + 1 < width).then_some(index + 1);
    let across = closer(step(left), step(right));
    let down = closer(step(index.checked_sub(width)), step(Some(index + width)));
    across.cross(down).normalize_or_zero()
}

fn to_srgb(linear: f64) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

fn depth(loaded: &LoadedScene, rays: &PreparedRays, hits: &[Hit]) -> (Vec<Rgb>, Vec<String>) {
    let viewpoint = loaded.session.viewpoint();
    let (eye, forward) = (viewpoint.eye.as_dvec3(), viewpoint.forward.as_dvec3());
    let depths: Vec<Option<f64>> =
        points(rays, hits).into_iter().map(|point| point.map(|point| (point - eye).dot(forward))).collect();
    let nearest = depths.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    let farthest = depths.iter().flatten().copied().fold(0.0, f64::max);
    let range = (farthest - nearest).max(f64::MIN_POSITIVE);
    let shade = |depth: &Option<f64>| match depth {
        None => BACKGROUND,
        Some(depth) => [(255.0 - 215.0 * (depth - nearest) / range).round() as u8; 3],
    };
    let legend = if nearest <= farthest {
        vec![format!("eye depth, scene units: white {nearest:.4}, darkest grey {farthest:.4}; no hit: dark blue")]
    } else {
        vec!["no ray hits anything: all dark blue".to_owned()]
    };
    (depths.iter().map(shade).collect(), legend)
}

fn errors(classes: &[Option<Class>]) -> (Vec<Rgb>, Vec<String>) {
    let colour_of = |class: &Option<Class>| {
        CLASS_COLOURS.iter().find(|(known, _)| Some(*known) == *class).map_or([0; 3], |(_, colour)| *colour)
    };
    let line = |(class, [red, green, blue]): &(Class, Rgb)| {
        let count = classes.iter().filter(|each| **each == Some(*class)).count();
        format!("#{red:02x}{green:02x}{blue:02x} {}: {count} rays", class.name(Query::Closest))
    };
    (classes.iter().map(colour_of).collect(), CLASS_COLOURS.iter().map(line).collect())
}

fn write_png(path: &Path, width: u32, height: u32, pixels: &[Rgb]) -> Result<(), PictureError> {
    let bytes = encoded([width, height], pixels.as_flattened(), |encoder| encoder.set_color(png::ColorType::Rgb))?;
    Ok(files::write(path, &bytes)?)
}

/// Pixels of eight bits a channel, of the kind that `set` says, as a PNG.
pub(crate) fn encoded(
    [width, height]: [u32; 2],
    pixels: &[u8],
    set: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>),
) -> Result<Vec<u8>, PictureError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_depth(png::BitDepth::Eight);
    set(&mut encoder);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(pixels)?;
        writer.finish()
    });
    written.map_err(|error| PictureError::Encode(error.to_string()))?;
    Ok(bytes)
}
