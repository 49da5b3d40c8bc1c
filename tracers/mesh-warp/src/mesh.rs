//! The mesh: its buffers, how it is made, and how it is checked.

use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::wgpu::{Buffer, CommandEncoder, ComputePipeline};
use tracebench_api::{Gpu, Ledger, TracerError, View};
use tracebench_kit::{
    EyeDepthTarget, GrowableBuffer, NO_SURFACE, ViewUniform, bind_group, dispatch_linear, uniform_buffer, view_uniform,
};
use tracebench_shaders::mesh_warp::MeshSettings;

use crate::description::{Discontinuity, WarpParameters};

/// As `WORKGROUP_SIZE` in shaders/mesh-warp/mesh.wgsl.
const WORKGROUP_SIZE: u32 = 64;

const HINT: &str = "--frame-size";

/// Relative difference of a depth from its share where f32 decides whether a triangle is cut out.
const CUT_SLACK: f64 = 1e-5;

/// How far a vertex in f32 may be off, share of its coordinates and of its distance from the eye.
const VERTEX_SLACK: f64 = 1e-6;

/// What a mesh is made by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeshShape {
    pub size: [u32; 2],
    /// By how much the vertices of a triangle may differ in depth that is not over a step, share of the least.
    pub most: f64,
    /// Whether triangles over a step are not there.
    pub cuts: bool,
}

impl MeshShape {
    pub fn new(view: &View, parameters: &WarpParameters) -> Self {
        let pixel_height = 2.0 * view.tan_half_height / f64::from(view.size[1]);
        let cuts = parameters.discontinuity == Discontinuity::Cut;
        Self { size: view.size, most: parameters.step_from * pixel_height, cuts }
    }

    pub fn vertices(&self) -> u32 {
        self.size[0] * self.size[1]
    }

    /// Triangles, those that are not there among them.
    pub fn triangles(&self) -> u32 {
        2 * self.size.map(|edge| edge.saturating_sub(1)).iter().product::<u32>()
    }

    fn settings(&self) -> MeshSettings {
        MeshSettings { size: self.size, cuts: u32::from(self.cuts), most: self.most as f32 }
    }
}

/// Its buffers.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub vertices: GrowableBuffer,
    pub triangles: GrowableBuffer,
}

impl Mesh {
    /// Room for one, that of before where it is large enough.
    pub fn new(gpu: &Gpu, shape: &MeshShape, before: Option<&Self>) -> Result<Self, TracerError> {
        // A buffer cannot be empty.
        let [vertices, triangles] = [shape.vertices(), shape.triangles().max(1)].map(|count| u64::from(count) * 12);
        let there = |of: fn(&Self) -> &GrowableBuffer| before.map(of);
        Ok(Self {
            vertices: GrowableBuffer::new(gpu, "mesh vertices", vertices, HINT, there(|mesh| &mesh.vertices))?,
            triangles: GrowableBuffer::new(gpu, "mesh triangles", triangles, HINT, there(|mesh| &mesh.triangles))?,
        })
    }

    pub fn enter(&self, ledger: &mut Ledger) {
        self.vertices.enter(ledger);
        self.triangles.enter(ledger);
    }

    /// Gives what makes it of a view's depths.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        pipeline: &ComputePipeline,
        view: &View,
        shape: &MeshShape,
        depths: &EyeDepthTarget,
    ) -> Result<impl Fn(&mut CommandEncoder), TracerError> {
        let view = uniform_buffer(gpu, "view", &view_uniform(view))?;
        let settings = uniform_buffer(gpu, "mesh settings", &shape.settings())?;
        let [view, settings, vertices, triangles] =
            [&view, &settings, &self.vertices.buffer, &self.triangles.buffer].map(Buffer::as_entire_binding);
        let depths = tracebench_api::wgpu::BindingResource::TextureView(&depths.eye_depth);
        let layout = pipeline.get_bind_group_layout(0);
        let bindings = bind_group(gpu, &layout, &[view, settings, depths, vertices, triangles]);
        let (pipeline, lanes) = (pipeline.clone(), shape.vertices());
        Ok(move |encoder: &mut CommandEncoder| dispatch_linear(encoder, &pipeline, &bindings, lanes, WORKGROUP_SIZE))
    }

    /// What making it takes while it runs.
    pub fn build_bytes() -> u64 {
        (size_of::<ViewUniform>() + size_of::<MeshSettings>()) as u64
    }

    /// The triangles of so many.
    pub fn read_triangles(&self, gpu: &Gpu, count: u32) -> Result<Vec<[u32; 3]>, TracerError> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let bytes = gpu.read(&self.triangles.buffer, u64::from(count) * 12)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Reads it back and holds it against the depths that it was made of; gives how many vertices and triangles there are.
    pub fn validate(
        &self,
        gpu: &Gpu,
        view: &View,
        shape: &MeshShape,
        depths: &[f32],
    ) -> Result<[usize; 2], TracerError> {
        let vertices = gpu.read(&self.vertices.buffer, u64::from(shape.vertices()) * 12)?;
        let vertices: Vec<[f32; 3]> = bytemuck::pod_collect_to_vec(&vertices);
        let triangles = self.read_triangles(gpu, shape.triangles())?;
        check(view, shape, depths, &vertices, &triangles)?;
        let there = depths.iter().filter(|depth| **depth != NO_SURFACE).count();
        Ok([there, triangles.iter().filter(|corners| is_there(corners)).count()])
    }
}

/// Whether a triangle is one: else it has one vertex three times.
pub(crate) fn is_there(corners: &[u32; 3]) -> bool {
    corners[0] != corners[1]
}

/// The vertex of a pixel with this depth.
fn vertex_of(view: &View, [column, row]: [u32; 2], depth: f64) -> DVec3 {
    let along = |pixel: u32, edge: u32| match pixel {
        _ if pixel + 1 == edge => f64::from(edge),
        0 => 0.0,
        _ => f64::from(pixel) + 0.5,
    };
    let at = DVec2::new(along(column, view.size[0]), along(row, view.size[1]));
    view.eye + view.direction_through(at.x, at.y) * depth
}

/// The vertices of every triangle of a mesh, square by square.
fn expected_triangles([columns, rows]: [u32; 2]) -> impl Iterator<Item = [u32; 3]> {
    let squares =
        (0..rows.saturating_sub(1)).flat_map(move |row| (0..columns.saturating_sub(1)).map(move |c| [c, row]));
    squares.flat_map(move |[column, row]| {
        let vertex = |right: u32, down: u32| (row + down) * columns + column + right;
        [[vertex(0, 0), vertex(0, 1), vertex(1, 0)], [vertex(1, 1), vertex(0, 1), vertex(1, 0)]]
    })
}

/// Holds a mesh against depths: vertices lie at their pixels and depths, and just those triangles are there that are not cut out.
fn check(
    view: &View,
    shape: &MeshShape,
    depths: &[f32],
    vertices: &[[f32; 3]],
    triangles: &[[u32; 3]],
) -> Result<(), TracerError> {
    let refuse = |what: String| Err(TracerError::Failed(what));
    for (index, (depth, vertex)) in (0..).zip(depths.iter().zip(vertices)) {
        if *depth == NO_SURFACE {
            continue;
        }
        let depth = f64::from(*depth);
        if !(view.near * (1.0 - 1e-4)..=view.far * (1.0 + 1e-4)).contains(&depth) {
            return refuse(format!("an eye depth of {depth} lies outside of {} to {}", view.near, view.far));
        }
        let pixel = [index % shape.size[0], index / shape.size[0]];
        let (expected, found) = (vertex_of(view, pixel, depth), Vec3::from(*vertex).as_dvec3());
        let reach = expected.abs().max_element() + (expected - view.eye).length() + view.eye.abs().max_element();
        let off = (found - expected).length();
        if off.is_nan() || off > VERTEX_SLACK * reach {
            return refuse(format!("the vertex of pixel {pixel:?} lies at {found}, not at {expected}"));
        }
    }
    let expected: Vec<[u32; 3]> = expected_triangles(shape.size).collect();
    if triangles.len() != expected.len() {
        return refuse(format!("{} triangles, not {}", triangles.len(), expected.len()));
    }
    for (expected, found) in expected.iter().zip(triangles) {
        let depths = expected.map(|vertex| f64::from(depths[vertex as usize]));
        let least = depths.into_iter().fold(f64::MAX, f64::min);
        let greatest = depths.into_iter().fold(0.0, f64::max);
        let step = (greatest - least) / least;
        let kept = |slack: f64| greatest < f64::from(NO_SURFACE) && (!shape.cuts || step <= shape.most + slack);
        let right = if is_there(found) { found == expected && kept(CUT_SLACK) } else { !kept(-CUT_SLACK) };
        if !right {
            return refuse(format!("the triangle {found:?} over depths {depths:?} should be {expected:?}, or none"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(size: [u32; 2]) -> View {
        View {
            eye: DVec3::new(1.0, 2.0, 3.0),
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::NEG_Z,
            tan_half_width: 1.0,
            tan_half_height: 1.0,
            near: 0.1,
            far: 100.0,
            size,
        }
    }

    /// Negative control: of a mesh that is right, a vertex that was moved, a depth before near, a triangle that is missing, turned, kept over
    /// a pixel without a surface or over a step in depth, and one too few are each noticed.
    #[test]
    fn wrong_meshes_are_noticed() {
        let view = view([3, 2]);
        let depths = [2.0, 2.1, 8.0, 2.0, NO_SURFACE, 2.1];
        let places = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]];
        let place = |(pixel, depth): (&[u32; 2], &f32)| vertex_of(&view, *pixel, f64::from(*depth)).as_vec3().into();
        let vertices: Vec<[f32; 3]> = places.iter().zip(&depths).map(place).collect();
        let keeps = MeshShape { size: [3, 2], most: 0.1, cuts: false };
        let cuts = MeshShape { cuts: true, ..keeps };
        // The upper left triangle alone has no step and no hole; with the hole filled there are three more, two of them over a step.
        let right = [[0, 3, 1], [4; 3], [1; 3], [5; 3]];
        assert!(check(&view, &keeps, &depths, &vertices, &right).is_ok());
        assert!(check(&view, &cuts, &depths, &vertices, &right).is_ok());
        let wrong = |triangles: &[[u32; 3]]| check(&view, &keeps, &depths, &vertices, triangles).is_err();
        assert!(wrong(&right[..3]) && wrong(&[[0; 3], [4; 3], [1; 3], [5; 3]]));
        assert!(wrong(&[[0, 1, 3], [4; 3], [1; 3], [5; 3]]) && wrong(&[[0, 3, 1], [4, 3, 1], [1; 3], [5; 3]]));
        let filled = [2.0, 2.1, 8.0, 2.0, 2.0, 2.1];
        let all: Vec<[u32; 3]> = expected_triangles([3, 2]).collect();
        let mut with_filled = vertices.clone();
        with_filled[4] = vertex_of(&view, [1, 1], 2.0).as_vec3().into();
        assert!(check(&view, &keeps, &filled, &with_filled, &all).is_ok());
        assert!(check(&view, &cuts, &filled, &with_filled, &all).is_err());
        assert!(check(&view, &cuts, &filled, &with_filled, &[all[0], all[1], [1; 3], [5; 3]]).is_ok());
        for vertex in [0, 1, 2, 3, 5] {
            let mut moved = vertices.clone();
            moved[vertex][1] += 1e-3;
            assert!(check(&view, &keeps, &depths, &moved, &right).is_err(), "{vertex}");
        }
        let mut before_near = depths;
        before_near[0] = 0.05;
        assert!(check(&view, &keeps, &before_near, &vertices, &right).is_err());
    }

    /// Images of one column or row have vertices and no triangles.
    #[test]
    fn lines_have_no_triangles() {
        for size in [[1, 1], [1, 9], [9, 1]] {
            let shape = MeshShape { size, most: 0.1, cuts: false };
            assert_eq!((shape.triangles(), expected_triangles(size).count()), (0, 0), "{size:?}");
        }
        assert_eq!(
            (MeshShape { size: [3, 4], most: 0.1, cuts: false }.triangles(), expected_triangles([3, 4]).count()),
            (12, 12)
        );
    }
}
