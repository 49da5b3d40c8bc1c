//! Traces: the mesh drawn from where the rays start, and looked up by them.

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::wgpu::{BindingResource, Buffer};
use tracebench_api::{Counter, DeviceGeometry, HitBuffer, MemoryEntry, Ray, TraceJob, TraceTo, TracerError, View};
use tracebench_kit::{
    LayerTarget, NearestLayers, NearestOf, NearestScene, PrimitiveTexture, RayCounts, Search, SearchJob, TouchedBits,
    ViewUniform, VisibilityBuffer, VisibilityPass, VisibilityView, bind_group_at, dispatch_rays, uniform_buffer,
    untimed, view_uniform,
};
use tracebench_shaders::mesh_warp::{Trace, WarpSettings};

use crate::mesh::is_there;
use crate::structure::WarpStructure;

/// What a search counts: numbers of every ray, and a bit a vertex.
type Counting = (RayCounts, TouchedBits);

const PIXELS_AND_TRIANGLES: &[&str] = &["pixels_read", "triangles_read"];
const TOUCHED: &str = "vertices_touched";
const DRAWN_FROM: &str = "view of the rays";
const SETTINGS: &str = "settings";
const FRAME: &str = "view of the mesh";

/// How much wider and higher than the view that the mesh was made from another one is at most.
const MAX_WIDER: f64 = 2.0;

/// Slack of what counts as in a view: directions are f32.
const IN_VIEW: f64 = 1.0 + 1e-6;

/// The view that a mesh is drawn into, from the point that all rays start in: that which it was made from where it shows all of them, else one
/// that does.
///
/// # Errors
/// [`TracerError::Unsupported`] if they start in several.
fn view_of(rays: &[Ray], built: &View) -> Result<View, TracerError> {
    let Some(first) = rays.first() else { return Ok(*built) };
    // What is no number is equal to none.
    if !rays.iter().all(|ray| ray.origin == first.origin) {
        let reason = "mesh-warp draws its mesh from the point that all rays start in, and these start in several";
        return Err(TracerError::Unsupported(reason.to_owned()));
    }
    let eye = Vec3::from(first.origin).as_dvec3();
    let moved = (eye - built.eye).length();
    let same = View { eye, far: built.far + moved, ..*built };
    let directions = || rays.iter().map(|ray| Vec3::from(ray.direction).as_dvec3());
    if directions().all(|direction| shows(&same, direction)) {
        return Ok(same);
    }
    Ok(view_round(directions, &same, built, moved).unwrap_or(same))
}

fn shows(view: &View, direction: DVec3) -> bool {
    let depth = direction.dot(view.forward) * IN_VIEW;
    direction.dot(view.right).abs() <= depth * view.tan_half_width
        && direction.dot(view.up).abs() <= depth * view.tan_half_height
}

/// A view round the mean of directions as wide and high as these, so that the outermost go through pixels' centres; `None` of directions
/// without a mean.
fn view_round<D: Iterator<Item = DVec3>>(
    directions: impl Fn() -> D,
    same: &View,
    built: &View,
    moved: f64,
) -> Option<View> {
    let forward = directions().sum::<DVec3>().try_normalize()?;
    let right = forward.cross(built.up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    let up = right.cross(forward);
    let tangents = directions().map(|direction| {
        let depth = direction.dot(forward);
        let tangent = |axis: DVec3| if depth > 0.0 { direction.dot(axis).abs() / depth } else { f64::INFINITY };
        [tangent(right), tangent(up)]
    });
    let [wide, high] = tangents.fold([0.0_f64; 2], |most, each| [most[0].max(each[0]), most[1].max(each[1])]);
    let reach = |tangent: f64, edge: u32, built: f64| {
        let (least, most) = (built / MAX_WIDER, built * MAX_WIDER);
        (tangent * f64::from(edge) / f64::from(edge.saturating_sub(1).max(1))).clamp(least, most)
    };
    let tan_half_width = reach(wide, built.size[0], built.tan_half_width);
    let tan_half_height = reach(high, built.size[1], built.tan_half_height);
    // As far as the farthest corner of the view that the mesh was made from may lie.
    let corner = DVec3::new(built.tan_half_width, built.tan_half_height, 1.0).length();
    Some(View { right, up, forward, tan_half_width, tan_half_height, far: built.far * corner + moved, ..*same })
}

impl WarpStructure {
    fn scene<'a>(&self, view: &'a View, geometry: &'a DeviceGeometry) -> NearestScene<'a> {
        let triangle_count = self.shape.triangles();
        NearestScene { raster_backend: self.raster_backend, view, geometry, triangle_count }
    }

    /// Records the search; `seen` is what rays see of the scene's triangles.
    fn search(
        &self,
        view: &View,
        drawn: &PrimitiveTexture,
        seen: Option<&VisibilityBuffer>,
        search: SearchJob<'_, '_, Counting>,
    ) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        let (gpu, count) = (&*self.pipelines.gpu, job.rays.host.len());
        let variant = Trace { surfaces: seen.is_some(), counters: counting.is_some() };
        let pipeline = self.pipelines.search.of(gpu, variant)?;
        let (columns, most) = (self.shape.size[0], self.shape.most as f32);
        let settings = WarpSettings { ray_count: count as u32, columns, most, padding: 0 };
        let view = uniform_buffer(gpu, DRAWN_FROM, &view_uniform(view))?;
        let settings = uniform_buffer(gpu, SETTINGS, &settings)?;
        let frame = seen.map(|_| uniform_buffer(gpu, FRAME, &view_uniform(&self.view))).transpose()?;
        let mut buffers: Vec<(u32, &Buffer)> = vec![
            (0, &view),
            (1, &settings),
            (3, job.rays.on_device()?),
            (4, hits.on_device(count)?),
            (9, &self.mesh.vertices.buffer),
        ];
        if let Some((counts, touched)) = counting {
            buffers.extend([(5, counts.buffer()), (6, touched.buffer())]);
        }
        buffers.extend(frame.as_ref().map(|frame| (10, frame)));
        let mut resources: Vec<_> = buffers.into_iter().map(|(at, buffer)| (at, buffer.as_entire_binding())).collect();
        resources.push((2, BindingResource::TextureView(&drawn.view)));
        if let Some(VisibilityBuffer { primitives, triangles }) = seen {
            resources.extend([(7, BindingResource::TextureView(&primitives.all)), (8, triangles.as_entire_binding())]);
        }
        let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
        clock.device_phase("search", |encoder| dispatch_rays(encoder, &pipeline, &[&bindings], job.rays, 1))
    }

    pub(crate) fn memory_of_trace(&self, job: &TraceJob<'_>) -> Vec<MemoryEntry> {
        let (size, backend) = (self.view.size, self.raster_backend);
        let view = size_of::<ViewUniform>() as u64;
        let [of_mesh, of_scene] = self.last_textures.borrow().clone();
        let mut parts = vec![
            MemoryEntry::whole(DRAWN_FROM, view),
            MemoryEntry::whole(SETTINGS, size_of::<WarpSettings>() as u64),
            of_mesh.unwrap_or_else(|| PrimitiveTexture::memory_of(size, 1)),
        ];
        parts.extend(NearestLayers::memory(NearestOf::Primitives, backend, size, self.shape.triangles(), 1));
        if job.trace_to == TraceTo::Surface {
            let (triangles, rays) = (self.triangle_count, job.rays.host.len());
            parts.push(MemoryEntry::whole(FRAME, view));
            parts.extend(VisibilityPass::memory(backend, size, triangles, 1, rays, of_scene));
        }
        parts
    }
}

impl Search for WarpStructure {
    type Counting = Counting;

    /// Any hit is the same search: what is drawn is the nearest.
    fn record(&self, search: SearchJob<'_, '_, Counting>) -> Result<(), TracerError> {
        let pipelines = &*self.pipelines;
        let SearchJob { job, hits, counting, clock } = search;
        let (gpu, rays) = (&*pipelines.gpu, job.rays);
        let view = view_of(&rays.host, &self.view)?;
        let drawn = PrimitiveTexture::new(gpu, view.size)?;
        let device = DeviceGeometry {
            positions: self.mesh.vertices.buffer.clone(),
            indices: self.mesh.triangles.buffer.clone(),
            // Nothing that is drawn has any.
            materials: self.geometry.device.materials.clone(),
        };
        let pass = pipelines.warp.prepare(gpu, self.scene(&view, &device), None)?;
        if job.trace_to == TraceTo::Surface {
            hits.surfaces_on_device(rays.host.len())?;
        }
        clock.device_phase("rasterize mesh", |encoder| {
            let target = LayerTarget { image: &drawn.view, layer: 0, test: &self.depths.test };
            pipelines.warp.record(encoder, &pass, target);
        })?;
        let seen = match job.trace_to {
            TraceTo::Hit => None,
            TraceTo::Surface => {
                let seen = VisibilityView {
                    raster_backend: self.raster_backend,
                    view: &self.view,
                    geometry: &self.geometry,
                    triangle_count: self.triangle_count,
                    target: &self.depths,
                    layers: 1,
                    separation: 0.0,
                };
                Some(pipelines.seen.draw(gpu, seen, rays.host.len(), clock)?)
            }
        };
        let of_scene = seen.as_ref().map(|seen| seen.primitives.memory.clone());
        self.last_textures.replace([Some(drawn.memory.clone()), of_scene]);
        self.search(&view, &drawn, seen.as_ref(), SearchJob { job, hits, counting, clock: &mut *clock })?;
        match &seen {
            Some(seen) => pipelines.seen.gather(gpu, &self.geometry, rays, hits, seen, clock),
            None => Ok(()),
        }
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &self.pipelines.gpu;
        let counts = RayCounts::new(gpu, PIXELS_AND_TRIANGLES, job.rays.host.len())?;
        let counting = (counts, TouchedBits::new(gpu, TOUCHED, u64::from(self.shape.vertices()), "--frame-size")?);
        untimed(gpu, |clock| self.record(SearchJob { job, hits, counting: Some(&counting), clock }))?;
        let mut counters = counting.0.counters(gpu)?;
        counters.push(Counter::of_set(TOUCHED, counting.1.count(gpu)?));
        let triangles = self.mesh.read_triangles(gpu, self.shape.triangles())?;
        let drawn = triangles.iter().filter(|corners| is_there(corners)).count();
        counters.push(Counter::of_set("triangles_drawn", drawn as u64));
        Ok(counters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUILT: View = View {
        eye: DVec3::new(1.0, 2.0, 3.0),
        right: DVec3::X,
        up: DVec3::Y,
        forward: DVec3::NEG_Z,
        tan_half_width: 1.0,
        tan_half_height: 0.5,
        near: 0.1,
        far: 100.0,
        size: [64, 32],
    };

    fn rays(view: &View, [columns, rows]: [u32; 2]) -> Vec<Ray> {
        let through = |x: u32, y: u32| {
            let part = |at: u32, count: u32, edge: u32| (f64::from(at) + 0.5) / f64::from(count) * f64::from(edge);
            view.direction_through(part(x, columns, view.size[0]), part(y, rows, view.size[1])).normalize()
        };
        let ray = |direction: DVec3| Ray {
            origin: view.eye.as_vec3().into(),
            t_min: 0.0,
            direction: direction.as_vec3().into(),
            t_max: Ray::UNBOUNDED,
        };
        (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).map(|(x, y)| ray(through(x, y))).collect()
    }

    /// Rays of the view itself, or of a part of it, from any eye are drawn into that view; those of one that turned into theirs.
    #[test]
    fn views_are_those_of_the_rays() {
        let eye = DVec3::new(2.0, 2.0, 3.0);
        for size in [[64, 32], [32, 16], [7, 5], [1, 1]] {
            let found = view_of(&rays(&View { eye, ..BUILT }, size), &BUILT).unwrap();
            assert_eq!(found, View { eye, far: 101.0, ..BUILT });
        }
        assert_eq!(view_of(&[], &BUILT).unwrap(), BUILT);
        let (sine, cosine) = 0.2_f64.sin_cos();
        let (right, forward) = (DVec3::new(cosine, 0.0, sine), DVec3::new(sine, 0.0, -cosine));
        let turned = View { eye, right, forward, ..BUILT };
        let found = view_of(&rays(&turned, BUILT.size), &BUILT).unwrap();
        assert!((found.forward - forward).length() < 1e-6 && (found.right - right).length() < 1e-6, "{found:?}");
        assert!((found.tan_half_width - 1.0).abs() < 1e-6 && (found.tan_half_height - 0.5).abs() < 1e-6, "{found:?}");
        assert!(found.far > 101.0 && found.near == BUILT.near && found.size == BUILT.size);
        // Rays all round, and straight up and down, have some view, of no more than twice the width.
        for directions in [[DVec3::X, DVec3::Z], [DVec3::Y, DVec3::Y], [DVec3::Y, DVec3::NEG_Y]] {
            let all = directions.map(|each| Ray { direction: each.as_vec3().into(), ..rays(&BUILT, [1, 1])[0] });
            let found = view_of(&all, &BUILT).unwrap();
            let square = found.right.cross(found.up) + found.forward;
            assert!(square.length() < 1e-9 && found.tan_half_width <= 2.0 && found.tan_half_height <= 1.0, "{found:?}");
        }
    }

    /// Rays from several points are refused, and those from none that is a number.
    #[test]
    fn several_origins_are_refused() {
        let mut several = rays(&BUILT, [4, 4]);
        several[9].origin[1] = several[9].origin[1].next_up();
        let mut none = rays(&BUILT, [4, 4]);
        none.iter_mut().for_each(|ray| ray.origin[0] = f32::NAN);
        for rays in [several, none] {
            assert!(matches!(view_of(&rays, &BUILT), Err(TracerError::Unsupported(_))));
        }
    }
}
