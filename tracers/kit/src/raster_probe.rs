//! What a device's rasterizer does where Vulkan leaves it to the driver, found by drawing.
//!
//! Snapping: borders are drawn at many places round a pixel's centre, and which of them cover it is held against where they are.
//! Interpolation: triangles at a slant, some of which reach far out of the view, are drawn with a depth at their corners, and
//! what comes between is held against their planes in f64.

use tracebench_api::glam::{DVec2, DVec3};
use tracebench_api::wgpu::{self, BufferUsages, RenderPipeline, TextureFormat, TextureUsages};
use tracebench_api::{Gpu, Rasterizer, TracerError};
use tracebench_shaders::shared::RASTER_PROBE;

use crate::{RasterTargets, create_texture, raster_pipeline};

const FORMAT: TextureFormat = TextureFormat::R32Float;

/// What stands where nothing is drawn.
const NOTHING: f32 = -1.0;

/// Borders drawn, evenly within [`REACH_PIXELS`] of a pixel's centre on both sides, one a line of the image.
const BORDERS: u32 = 512;

/// Coarser grids than twice of this are told as this.
const REACH_PIXELS: f64 = 0.125;

/// Pixels of a line.
const LINE_PIXELS: u32 = 64;

/// Edge of the square that every triangle with a depth is drawn into, pixels, and squares along either edge of the image.
const SQUARE_PIXELS: u32 = 32;
const SQUARES: u32 = 8;

/// How far triangles with a depth reach, in heights of the eye above their plane: the first are whole in the view.
const REACHES: [f64; 8] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7];

/// Nearer than this, in heights, triangles are cut.
const NEAR: f64 = 0.2;

/// What a device's rasterizer does; found once and kept.
///
/// # Errors
/// [`TracerError::Failed`] if the device fails, or draws nothing.
pub fn rasterizer(gpu: &Gpu) -> Result<Rasterizer, TracerError> {
    gpu.rasterizer(probe)
}

fn probe(gpu: &Gpu) -> Result<Rasterizer, TracerError> {
    let prober = Prober::new(gpu)?;
    let snap_pixels = f64::max(prober.snapping(Axis::Across)?, prober.snapping(Axis::Down)?);
    let [depth_error, depth_error_beyond_view, reach] = prober.interpolation(snap_pixels)?;
    Ok(Rasterizer { snap_pixels, depth_error, depth_error_beyond_view, reach })
}

/// x, y, z, w.
type Clip = [f32; 4];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Axis {
    Across,
    Down,
}

struct Prober<'a> {
    gpu: &'a Gpu,
    pipeline: RenderPipeline,
}

/// A drawing, read back row by row from the top.
struct Drawn {
    width: u32,
    depths: Vec<f32>,
}

impl Drawn {
    fn at(&self, x: u32, y: u32) -> f32 {
        self.depths[(y * self.width + x) as usize]
    }
}

/// The pixel of a line whose centre borders are drawn round: elsewhere on every line, left or upper border first.
fn probed(line: u32) -> [u32; 2] {
    [4 + line % 13, 36 + line % 11]
}

/// Where a line's borders are, off the centres of its probed pixels, pixels.
fn offset(line: u32) -> f64 {
    (f64::from(line) + 0.5) / f64::from(BORDERS) * 2.0 * REACH_PIXELS - REACH_PIXELS
}

/// By how much borders are off at most, by the lines' decisions whether a first and a second border's pixel is covered.
fn max_snap(covered: impl Fn(u32) -> [bool; 2]) -> f64 {
    let step = 2.0 * REACH_PIXELS / f64::from(BORDERS);
    let wrong = (0..BORDERS).filter(|line| {
        let off = offset(*line);
        covered(*line) != [off < 0.0, off > 0.0]
    });
    wrong.map(|line| offset(line).abs() + 0.5 * step).fold(step, f64::max)
}

impl<'a> Prober<'a> {
    fn new(gpu: &'a Gpu) -> Result<Self, TracerError> {
        let corners = wgpu::VertexBufferLayout {
            array_stride: size_of::<Clip>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x4],
        };
        let targets =
            RasterTargets { vertex_buffers: &[Some(corners)], colours: &[Some(FORMAT.into())], ..Default::default() };
        Ok(Self { gpu, pipeline: raster_pipeline(gpu, RASTER_PROBE, &targets)? })
    }

    /// Draws triangles; each square of the image has three corners of its own, and where there is one square they have it all.
    fn draw(&self, size: [u32; 2], squares: u32, corners: &[Clip]) -> Result<Drawn, TracerError> {
        let gpu = self.gpu;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let texture = create_texture(gpu, "rasterizer probe", size, FORMAT, usage);
        let vertices =
            gpu.buffer_with("rasterizer probe", bytemuck::cast_slice(corners), BufferUsages::VERTEX, "nothing")?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let clear = wgpu::Color { r: f64::from(NOTHING), g: 0.0, b: 0.0, a: 0.0 };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("rasterizer probe"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &texture.create_view(&Default::default()),
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_vertex_buffer(0, vertices.slice(..));
            let [width, height] = size.map(|edge| edge / squares);
            let all = corners.len() as u32;
            for square in 0..squares * squares {
                let [left, top] = [square % squares * width, square / squares * height];
                pass.set_viewport(left as f32, top as f32, width as f32, height as f32, 0.0, 1.0);
                pass.set_scissor_rect(left, top, width, height);
                let first = square * 3;
                pass.draw(if squares == 1 { 0..all } else { first..first + 3 }, 0..1);
            }
        }
        let bytes = u64::from(size[0]) * 4 * u64::from(size[1]);
        let usage = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let staging = gpu.buffer("rasterizer probe", bytes, usage, "nothing")?;
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    // Every image here is a multiple of 64 pixels wide.
                    bytes_per_row: Some(size[0] * 4),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        Ok(Drawn { width: size[0], depths: bytemuck::pod_collect_to_vec(&gpu.read(&staging, bytes)?) })
    }

    /// By how much borders along an axis are off.
    fn snapping(&self, axis: Axis) -> Result<f64, TracerError> {
        let size = if axis == Axis::Across { [LINE_PIXELS, BORDERS] } else { [BORDERS, LINE_PIXELS] };
        let mut corners = Vec::new();
        for line in 0..BORDERS {
            let [first, second] = probed(line).map(|pixel| f64::from(pixel) + 0.5 + offset(line));
            let across_line = [f64::from(line), f64::from(line) + 1.0];
            // From the first border eight pixels on, and eight pixels up to the second.
            for along in [[first, first + 8.0], [second - 8.0, second]] {
                let (x, y) = if axis == Axis::Across { (along, across_line) } else { (across_line, along) };
                let corner = |right: usize, lower: usize| -> Clip {
                    let at = DVec2::new(x[right], y[lower]) * 2.0 / DVec2::from(size.map(f64::from)) - 1.0;
                    [at.x as f32, -at.y as f32, 0.5, 1.0]
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                corners.extend([a, b, c, a, c, d]);
            }
        }
        let drawn = self.draw(size, 1, &corners)?;
        if drawn.depths.iter().all(|depth| *depth == NOTHING) {
            return Err(TracerError::Failed(format!("{} draws nothing", self.gpu.listing.name)));
        }
        let covered = |line: u32| {
            probed(line).map(|pixel| {
                let [x, y] = if axis == Axis::Across { [pixel, line] } else { [line, pixel] };
                drawn.at(x, y) != NOTHING
            })
        };
        Ok(max_snap(covered))
    }

    /// By how much depths are off beside what snapping explains, of triangles in the view and of those that reach out of it; and how far
    /// they reach without losing pixels.
    fn interpolation(&self, snap_pixels: f64) -> Result<[f64; 3], TracerError> {
        let edge = SQUARE_PIXELS * SQUARES;
        let triangles: Vec<[Clip; 3]> = (0..SQUARES * SQUARES).map(slanted).collect();
        let drawn = self.draw([edge; 2], SQUARES, triangles.as_flattened())?;
        let (mut errors, mut lost_from) = ([0.0_f64; 2], f64::INFINITY);
        for (square, triangle) in (0..).zip(&triangles) {
            let beyond = usize::from(reach_of(square) > 1.0);
            let [left, top] = [square % SQUARES, square / SQUARES].map(|place| place * SQUARE_PIXELS);
            for (x, y) in (0..SQUARE_PIXELS).flat_map(|y| (0..SQUARE_PIXELS).map(move |x| (x, y))) {
                let depth = drawn.at(left + x, top + y);
                if depth != NOTHING {
                    let off = depth_off(triangle, [x, y], f64::from(depth), snap_pixels);
                    errors[beyond] = errors[beyond].max(off);
                } else if covers(triangle, [x, y], 2.0 * snap_pixels) {
                    lost_from = lost_from.min(reach_of(square));
                }
            }
        }
        let reach = REACHES.into_iter().take_while(|reach| *reach < lost_from).last().unwrap_or(0.0);
        Ok([errors[0], errors[1], reach])
    }
}

fn reach_of(square: u32) -> f64 {
    REACHES[square as usize % REACHES.len()]
}

/// A triangle on a ground that is seen at a slant, turned from square to square; it spans the view and reaches as far beyond it
/// as its square says.
fn slanted(square: u32) -> [Clip; 3] {
    let (turn, reach) = (f64::from(square / REACHES.len() as u32) * 0.41, reach_of(square));
    let (sine, cosine) = turn.sin_cos();
    // x right, y up, z eye depth; the ground lies a unit below the eye and falls away to a side.
    let corner = |x: f64, z: f64| -> Clip {
        let (across, upward, deep) = match reach > 1.0 {
            true => (x * reach, -1.0 + 0.01 * x, z * reach),
            // Whole in the view.
            false => (x * 1.5, -0.8 + 0.05 * x, 3.0 + 1.8 * z),
        };
        let at = DVec2::new(cosine * across - sine * upward, sine * across + cosine * upward);
        // From 0 to 1 over all that is deeper than near: what is nearer, or behind the eye, is cut away.
        [at.x as f32, at.y as f32, (0.5 * (deep + NEAR)) as f32, deep as f32]
    };
    [corner(-0.9, 1.0), corner(1.0, 0.9), corner(0.1, -1.0)]
}

/// The line through a place in a square, as the depth of 1 has it.
fn direction(x: f64, y: f64) -> DVec3 {
    let pixel = 2.0 / f64::from(SQUARE_PIXELS);
    DVec3::new(x * pixel - 1.0, 1.0 - y * pixel, 1.0)
}

/// Corners in clip space without depth, in f64.
fn exact(triangle: &[Clip; 3]) -> [DVec3; 3] {
    triangle.map(|[x, y, _, w]| DVec3::new(x.into(), y.into(), w.into()))
}

/// Whether a triangle covers a pixel's centre, and all that is so near to it, beyond near.
fn covers(triangle: &[Clip; 3], [x, y]: [u32; 2], within: f64) -> bool {
    let [a, b, c] = exact(triangle);
    let normal = (b - a).cross(c - a);
    [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].into_iter().all(|(right, lower)| {
        let at = direction(f64::from(x) + 0.5 + right * within, f64::from(y) + 0.5 + lower * within);
        let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|side| side.dot(at));
        let depth = normal.dot(a) / normal.dot(at);
        depth > 1.1 * NEAR && (sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0))
    })
}

/// By how much a depth at a pixel's centre is off its triangle's plane, beside what a border that is so far off explains: share of
/// the depth. None counts where the plane is seen so edge-on that snapping explains any depth.
fn depth_off(triangle: &[Clip; 3], [x, y]: [u32; 2], depth: f64, snap_pixels: f64) -> f64 {
    let [a, b, c] = exact(triangle);
    let normal = (b - a).cross(c - a);
    let plane = normal / normal.dot(a);
    let inverse = plane.dot(direction(f64::from(x) + 0.5, f64::from(y) + 0.5));
    let off = (plane.x.abs() + plane.y.abs()) * (2.0 / f64::from(SQUARE_PIXELS)) * snap_pixels;
    if inverse <= 2.0 * off {
        return 0.0;
    }
    let [least, greatest] = [1.0 / (inverse + off), 1.0 / (inverse - off)];
    f64::max(least / depth - 1.0, depth / greatest - 1.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use tracebench_api::AdapterChoice;

    use super::*;

    /// The device's own figures lie within what Vulkan asks for, are the same when asked again, and are found where they are
    /// put: of grids that round to a sixteenth and to a 256th, and of one that cuts off.
    #[test]
    fn snapping_is_found() {
        let snapped = |grid: f64, round: fn(f64) -> f64| {
            max_snap(|line| {
                let off = round(offset(line) / grid) * grid;
                [off <= 0.0, off > 0.0]
            })
        };
        for (grid, round, most) in [
            (1.0 / 16.0, f64::round as fn(f64) -> f64, 1.0 / 32.0),
            (1.0 / 256.0, f64::round, 1.0 / 512.0),
            (1.0 / 64.0, f64::floor, 1.0 / 64.0),
        ] {
            let found = snapped(grid, round);
            assert!((most - 1e-3..most + 1e-3).contains(&found), "{grid}: {found}");
        }
        let gpu = Gpu::open(&AdapterChoice::from_environment(None, None).unwrap()).unwrap();
        let found = rasterizer(&gpu).unwrap();
        assert!(found.snap_pixels > 0.0 && found.snap_pixels <= 1.0 / 16.0, "{found:?}");
        assert!(found.depth_error < 1e-3 && REACHES.contains(&found.reach), "{found:?}");
        assert_eq!(probe(&gpu).unwrap(), found);
    }

    /// A depth on the plane is not off, nor is one that a border a little aside explains; one that is off is told by its share.
    #[test]
    fn depths_are_held_against_the_plane() {
        let triangle = slanted(0);
        let exact = |snap: f64| {
            (0..200)
                .map(|step| 1.0 + 0.05 * f64::from(step))
                .find(|depth| depth_off(&triangle, [16, 28], *depth, snap) < 0.03)
        };
        let depth = exact(0.0).unwrap();
        let off = depth_off(&triangle, [16, 28], depth * 1.5, 0.0);
        assert!((0.4..0.6).contains(&off), "{depth} {off}");
        assert!(depth_off(&triangle, [16, 28], depth * 1.5, 8.0) < off);
    }

    /// Triangles cover a part of the view, those that reach beyond it much; a border within reach is no sure cover.
    #[test]
    fn cover_is_sure_inside_alone() {
        for square in 0..SQUARES * SQUARES {
            let triangle = slanted(square);
            let pixels = || (0..SQUARE_PIXELS).flat_map(|y| (0..SQUARE_PIXELS).map(move |x| [x, y]));
            let [exactly, surely] =
                [0.0, 2.0].map(|within| pixels().filter(|at| covers(&triangle, *at, within)).count());
            assert!(exactly < 1000 && surely < exactly, "{square}: {exactly} {surely}");
            assert!(reach_of(square) <= 1.0 || exactly > 100, "{square}: {exactly}");
        }
    }
}
