//! Building and tracing on the device.

use std::cell::RefCell;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use tracebench_api::wgpu::{
    BindingResource, Buffer, BufferUsages, COPY_BYTES_PER_ROW_ALIGNMENT, CommandEncoder, TexelCopyBufferInfo,
    TexelCopyBufferLayout, TextureView,
};
use tracebench_api::{
    Counter, EndPoint, Geometry, Gpu, HitBuffer, Layers, Ledger, MemoryEntry, MemoryReport, Parameters, PhaseClock,
    Projection, Sampling, SharedLayout, Structure, TraceJob, Tracer, TracerError, Update, View, Viewpoint,
};
use tracebench_kit::{
    EyeDepthRaster, EyeDepthTarget, Gather, NO_SURFACE, PipelinesOnDemand, PrimitiveRaster, PrimitiveTexture,
    RayCounts, ReadSlot, Readable, Reads, Room, SurfaceGeometry, TouchedBits, ViewUniform, bind_arrays, bind_group_at,
    dispatch_rays, rays_within_rounds, uniform_buffer,
};
use tracebench_shaders::screen_dda::Trace;

use crate::description::{DdaParameters, NO_REFIT};

/// `Settings` of shaders/screen-dda/trace.wgsl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Settings {
    ray_count: u32,
    max_steps: u32,
    hit_point: u32,
    stride: f32,
    thickness: f32,
    start_bias: f32,
    rays_per_lane: u32,
    row_words: u32,
}

/// Layouts of all that shaders share with this crate.
pub(crate) fn layouts() -> Vec<SharedLayout> {
    tracebench_api::layouts! {
        Settings { ray_count, max_steps, hit_point, stride, thickness, start_bias, rays_per_lane, row_words }
    }
}

/// The pipelines.
struct Pipelines {
    gpu: Arc<Gpu>,
    raster: EyeDepthRaster,
    /// The triangles at the view's pixels, for surfaces.
    primitives: PrimitiveRaster,
    gather: Gather,
    trace: PipelinesOnDemand<Trace>,
}

/// The tracer.
pub struct ScreenDda {
    pipelines: Arc<Pipelines>,
}

impl ScreenDda {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        let pipelines = Pipelines {
            raster: EyeDepthRaster::new(&gpu)?,
            primitives: PrimitiveRaster::new(&gpu)?,
            gather: Gather::new(&gpu)?,
            trace: PipelinesOnDemand::new("trace"),
            gpu,
        };
        Ok(Self { pipelines: Arc::new(pipelines) })
    }
}

/// The depth buffer of one view.
struct ScreenDdaStructure {
    pipelines: Arc<Pipelines>,
    view: View,
    target: EyeDepthTarget,
    /// The eye depths in a buffer, where the march reads one.
    copy: Option<DepthCopy>,
    diagonal: f64,
    geometry: SurfaceGeometry,
    triangle_count: u32,
    /// What the last texture of triangles took.
    primitive_texture: RefCell<Option<MemoryEntry>>,
}

impl Tracer for ScreenDda {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        let DdaParameters { reads, .. } = DdaParameters::try_from(parameters)?;
        let view = viewpoint.frame_view();
        let target = EyeDepthTarget::new(&self.pipelines.gpu, view.size)?;
        let copy = (reads == Reads::Buffer).then(|| DepthCopy::new(&self.pipelines.gpu, view.size)).transpose()?;
        self.pipelines.rasterize(geometry, &view, &target, copy.as_ref(), clock)?;
        let pipelines = Arc::clone(&self.pipelines);
        Ok(Box::new(ScreenDdaStructure {
            pipelines,
            view,
            target,
            copy,
            diagonal: geometry.diagonal(),
            geometry: SurfaceGeometry::of(geometry)?,
            triangle_count: geometry.triangles.len() as u32,
            primitive_texture: RefCell::new(None),
        }))
    }
}

impl Pipelines {
    fn rasterize(
        &self,
        geometry: &Geometry,
        view: &View,
        target: &EyeDepthTarget,
        copy: Option<&DepthCopy>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let bindings = self.raster.bind(&self.gpu, view, geometry.on_device()?)?;
        let triangle_count = geometry.triangles.len() as u32;
        clock.device_phase("rasterize depth buffer", |encoder| {
            self.raster.record(encoder, &bindings, triangle_count, target);
        })?;
        match copy {
            Some(copy) => clock.device_phase("copy to a buffer", |encoder| copy.record(encoder, target)),
            None => Ok(()),
        }
    }
}

/// A copy of the eye depths in a buffer, row by row: reading the image itself is what `reads=texture` means here.
struct DepthCopy {
    room: Room,
    array: Readable,
    row_bytes: u32,
}

impl DepthCopy {
    fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<Self, TracerError> {
        let row_bytes = (width * 4).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(row_bytes) * u64::from(height);
        let room = Room::new(gpu, DEPTH_COPY, bytes, "--frame", None)?;
        let array =
            Readable::built(gpu, Reads::Buffer, ReadSlot::Words0, &room.buffer, bytes, DEPTH_COPY, None, "--frame")?;
        Ok(Self { room, array, row_bytes })
    }

    fn record(&self, encoder: &mut CommandEncoder, target: &EyeDepthTarget) {
        let texture = target.eye_depth.texture();
        let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(self.row_bytes), rows_per_image: None };
        let copy = TexelCopyBufferInfo { buffer: &self.room.buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), copy, texture.size());
    }
}

const DEPTH_COPY: &str = "eye depths in a buffer";

impl ScreenDdaStructure {
    fn settings(&self, job: &TraceJob<'_>) -> Result<Settings, TracerError> {
        let parameters = DdaParameters::try_from(job.parameters)?;
        // A walk along the major axis, and the turn itself.
        let longest = self.view.size.into_iter().max().unwrap_or(1).div_ceil(parameters.stride) + 3;
        let most_rounds = u64::from(longest.min(parameters.max_steps) + 1);
        Ok(Settings {
            ray_count: job.rays.host.len() as u32,
            max_steps: parameters.max_steps,
            hit_point: parameters.hit_point as u32,
            stride: parameters.stride as f32,
            thickness: (parameters.thickness * self.diagonal) as f32,
            start_bias: parameters.start_bias as f32,
            rays_per_lane: rays_within_rounds(parameters.rays_per_lane, most_rounds),
            row_words: self.copy.as_ref().map_or(0, |copy| copy.row_bytes / 4),
        })
    }

    /// Records the trace, by the counting variant where there is something to count into.
    fn record(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<[&Buffer; 2]>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        match job.end {
            EndPoint::Hit => self.march(job, hits, counting, None, clock),
            EndPoint::Surface => {
                let count = job.rays.host.len();
                hits.surfaces_on_device(count)?;
                let primitives = self.draw_primitives(clock)?;
                let seen = seen_buffer(&self.pipelines.gpu, count)?;
                self.march(job, hits, counting, Some((&primitives.view, &seen)), clock)?;
                let Pipelines { gpu, gather, .. } = &*self.pipelines;
                gather.record(gpu, &self.geometry, job.rays, hits, Some(&seen), clock)
            }
        }
    }

    /// Draws the view once more, for the triangles at its pixels.
    fn draw_primitives(&self, clock: &mut PhaseClock<'_>) -> Result<PrimitiveTexture, TracerError> {
        let Pipelines { gpu, primitives: raster, .. } = &*self.pipelines;
        let texture = PrimitiveTexture::new(gpu, self.view.size)?;
        self.primitive_texture.replace(Some(texture.memory.clone()));
        let bindings = raster.bind(gpu, &self.view, &self.geometry.device)?;
        clock.device_phase("rasterize primitives", |encoder| {
            raster.record(encoder, &bindings, self.triangle_count, &texture.view, &self.target.test);
        })?;
        Ok(texture)
    }

    /// Records the march; `surfaces` are the triangles at the view's pixels and what the rays saw of them.
    fn march(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<[&Buffer; 2]>,
        surfaces: Option<(&TextureView, &Buffer)>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &self.pipelines.gpu;
        let (textures, surfaces_wanted) = (self.copy.is_none(), surfaces.is_some());
        let variant = Trace { textures, surfaces: surfaces_wanted, counters: counting.is_some() };
        let pipeline = self.pipelines.trace.of(gpu, variant)?;
        let view = uniform_buffer(gpu, "view", &ViewUniform::from(&self.view))?;
        let settings = self.settings(job)?;
        let settings_buffer = uniform_buffer(gpu, "settings", &settings)?;
        let mut resources = vec![
            (0, view.as_entire_binding()),
            (1, settings_buffer.as_entire_binding()),
            (3, job.rays.on_device()?.as_entire_binding()),
            (4, hits.on_device(job.rays.host.len())?.as_entire_binding()),
        ];
        if textures {
            resources.push((2, BindingResource::TextureView(&self.target.eye_depth)));
        }
        if let Some([counts, touched]) = counting {
            resources.extend([(5, counts.as_entire_binding()), (6, touched.as_entire_binding())]);
        }
        if let Some((primitives, seen)) = surfaces {
            resources.extend([(7, BindingResource::TextureView(primitives)), (8, seen.as_entire_binding())]);
        }
        let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
        let arrays = self.copy.as_ref().map(|copy| bind_arrays(gpu, &pipeline, std::slice::from_ref(&copy.array)));
        let bindings: Vec<_> = std::iter::once(&bindings).chain(&arrays).collect();
        clock.device_phase("march", |encoder| {
            dispatch_rays(encoder, &pipeline, &bindings, settings.ray_count, settings.rays_per_lane);
        })
    }
}

/// Name of the triangles that rays saw.
const SEEN: &str = "hit primitives";

/// Room for the triangle that each ray saw.
fn seen_buffer(gpu: &Gpu, rays: usize) -> Result<Buffer, TracerError> {
    let bytes = rays.max(1) as u64 * 4;
    gpu.check_storage_binding(SEEN, bytes, "--size")?;
    gpu.buffer(SEEN, bytes, BufferUsages::STORAGE, "--size")
}

impl Structure for ScreenDdaStructure {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        _parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        match update {
            Update::Rebuild => {
                let view = viewpoint.frame_view();
                let surfaces = SurfaceGeometry::of(geometry)?;
                // A frame of the same size is drawn into the textures that are there.
                if view.size == self.view.size {
                    self.pipelines.rasterize(geometry, &view, &self.target, self.copy.as_ref(), clock)?;
                } else {
                    let gpu = &self.pipelines.gpu;
                    let target = EyeDepthTarget::new(gpu, view.size)?;
                    let copy = self.copy.as_ref().map(|_| DepthCopy::new(gpu, view.size)).transpose()?;
                    self.pipelines.rasterize(geometry, &view, &target, copy.as_ref(), clock)?;
                    (self.target, self.copy) = (target, copy);
                }
                (self.view, self.diagonal) = (view, geometry.diagonal());
                (self.geometry, self.triangle_count) = (surfaces, geometry.triangles.len() as u32);
                Ok(())
            }
            Update::Refit => Err(TracerError::Unsupported(NO_REFIT.to_owned())),
            Update::Reuse => Ok(()),
        }
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        // Any hit is the same walk: its first hit is its nearest.
        self.record(&job, hits, None, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &self.pipelines.gpu;
        let counts = RayCounts::new(gpu, "depth sample counts", job.rays.host.len())?;
        let [width, height] = self.view.size.map(u64::from);
        let touched = TouchedBits::new(gpu, "pixels touched", width * height, "--frame")?;
        let mut clock = PhaseClock::new(Some(gpu));
        self.record(&job, hits, Some([counts.buffer(), touched.buffer()]), &mut clock)?;
        clock.finish()?;
        let mut counters = counts.counters(gpu, ["depth_samples"])?;
        counters.push(Counter::of_set("pixels_touched", touched.count(gpu)?));
        Ok(counters)
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        self.target.enter(&mut ledger);
        if let Some(copy) = &self.copy {
            copy.room.enter(&mut ledger);
        }
        // The view's uniforms, while the depth buffer is drawn.
        ledger.borrow_transient(size_of::<ViewUniform>() as u64);
        ledger.report(0).with_surface_geometry(self.geometry.bytes)
    }

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let uniforms = [("view", size_of::<ViewUniform>()), ("settings", size_of::<Settings>())];
        let mut parts = uniforms.map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).to_vec();
        if job.end == EndPoint::Surface {
            let texture = self.primitive_texture.borrow().clone();
            parts.push(texture.unwrap_or_else(|| PrimitiveTexture::memory_of(self.view.size)));
            parts.push(MemoryEntry::whole(SEEN, job.rays.host.len().max(1) as u64 * 4));
            parts.extend([PrimitiveRaster::memory(), Gather::memory()]);
        }
        Ok(parts)
    }

    fn samplings(&self) -> Vec<Sampling> {
        vec![Sampling { projection: Projection::Perspective(self.view), layers: Layers::Nearest }]
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let depths = self.target.read(&self.pipelines.gpu)?;
        // Depth is interpolated in f32, so a surface at near or far may be stored a little beyond it.
        let (near, far) = (self.view.near * (1.0 - 1e-4), self.view.far * (1.0 + 1e-4));
        let outside = |depth: &&f32| **depth != NO_SURFACE && !(near..=far).contains(&f64::from(**depth));
        if let Some(depth) = depths.iter().find(outside) {
            return Err(TracerError::Failed(format!("an eye depth of {depth} lies outside of {near} to {far}")));
        }
        let covered = depths.iter().filter(|depth| **depth != NO_SURFACE).count();
        Ok(vec![("pixels", depths.len() as f64), ("covered_pixels", covered as f64)])
    }
}
