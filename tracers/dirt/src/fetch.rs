//! Surfaces as published: hits into the hit buffer, the mask, and the fetch pass (sections 4.2.1 and 4.2.2).
//!
//! How it is here:
//! - The hit buffer has one image of heads for all views, as the paper's Table 3 counts it, and a node a ray, so that it
//!   cannot overflow. The mask is drawn from the heads in a pass of its own: compute shaders write no depth.
//! - Of the shading buffer's three points one is allocated, the point that was hit (G of k + 1): a trace of the suite is one
//!   event of a path.
//! - Surfaces are interpolated by the stored barycentric weights with both coverages. The paper leaves that to the
//!   rasterizer without conservative coverage (section 4.2.4), which gives the surface at the pixel's centre, not at the hit.
//! - The view of a hit is found again from where the hit lies, so that the search is the same for both end points: where two
//!   views overlap it may be the other one, which with conservative coverage fetches the same.
//! - The stored position is the paper's; no pass of the suite reads it.
//! - Hits that no triangle's coverage finds are left lost: with standard coverage those on pixels whose centres their
//!   triangle does not cover, with conservative coverage those that no view has, such as hits before near on triangles
//!   that reach beyond it.

use std::cell::RefCell;

use tracebench_api::wgpu::{
    self, BindGroup, Buffer, CompareFunction, ComputePipeline, RenderPipeline, TextureFormat, TextureUsages,
    TextureView,
};
use tracebench_api::{Gpu, HitBuffer, MemoryEntry, PhaseClock, Surface, SurfaceStatus, TraceJob, TraceTo, TracerError};
use tracebench_kit::{
    Gather, OnDemand, RasterTargets, ViewUniform, bind_group, compute_pipeline, create_texture, dispatch_linear,
    raster_pipeline, storage_buffer, uniform_buffer, view_uniform, view_uniforms,
};
use tracebench_shaders::{Shader, dirt};

use crate::description::Fetching;
use crate::layout::{Layout, MAX_VIEWS};
use crate::structure::DirtStructure;
pub(crate) use tracebench_shaders::dirt::{FetchPass, HitNode, MaskSettings, StoreSettings};

/// As `WORKGROUP_SIZE` in shaders/dirt/store.wgsl.
const WORKGROUP_SIZE: u32 = 64;

/// Two bytes a pixel, as in Table 3.
const MASK_FORMAT: TextureFormat = TextureFormat::Depth16Unorm;

// What ledgers call the parts, after Table 3; and the uniforms.
const HIT_HEADS: &str = "hit buffer: heads";
const HIT_NODES: &str = "hit buffer: nodes";
const MASK: &str = "mask texture";
const STORE: &str = "store settings";
const STORE_VIEWS: &str = "store views";
const MASK_SETTINGS: &str = "mask settings";
const FETCHED: &str = "fetched view";

/// The pipelines, each made when it is first needed.
#[derive(Default)]
pub(crate) struct Fetch {
    store: OnDemand<(), ComputePipeline>,
    mask: OnDemand<(), RenderPipeline>,
    fetch: OnDemand<dirt::Fetch, RenderPipeline>,
}

/// A pipeline that draws into the mask alone.
fn mask_pipeline(gpu: &Gpu, shader: Shader, writes: bool) -> Result<RenderPipeline, TracerError> {
    // A fragment stage that writes to buffers is run before its depth test, unless it is told otherwise.
    // No depth lies beyond 1, the mask's where there are hits.
    let passes = if writes { CompareFunction::Always } else { CompareFunction::LessEqual };
    let depth = Some((MASK_FORMAT, writes, passes));
    raster_pipeline(gpu, shader, &RasterTargets { depth, tests_early: !writes, ..Default::default() })
}

/// What a fetch takes while it runs: heads, nodes, mask, bindings.
struct Taken {
    heads: Buffer,
    store: BindGroup,
    mask_settings: BindGroup,
    mask: TextureView,
    /// Each with the vertices that it is drawn with.
    views: Vec<(BindGroup, u32)>,
}

/// What the last mask texture took; drivers pad textures as they like.
pub(crate) type MaskMemory = RefCell<Option<MemoryEntry>>;

impl Fetch {
    fn store(&self, gpu: &Gpu) -> Result<ComputePipeline, TracerError> {
        self.store.of((), || compute_pipeline(gpu, dirt::STORE, "store"))
    }

    fn mask(&self, gpu: &Gpu) -> Result<RenderPipeline, TracerError> {
        self.mask.of((), || mask_pipeline(gpu, dirt::MASK, true))
    }

    fn fetch_of(&self, structure: &DirtStructure) -> Result<RenderPipeline, TracerError> {
        let variant = dirt::Fetch { conservative: structure.filling.conservative };
        self.fetch.of(variant, || mask_pipeline(&structure.pipelines.gpu, variant.into(), false))
    }

    /// Buffers and textures of a fetch of the surfaces of so many rays, by name.
    pub(crate) fn memory(layout: &Layout, rays: usize, last_mask: &MaskMemory) -> Vec<MemoryEntry> {
        let pixels = pixel_count(layout);
        let mask = last_mask.borrow().clone();
        let mut parts = vec![
            MemoryEntry::whole(HIT_HEADS, pixels * 4),
            MemoryEntry::whole(HIT_NODES, node_bytes(rays)),
            mask.unwrap_or_else(|| MemoryEntry::whole(MASK, pixels * 2)),
            MemoryEntry::whole(STORE, size_of::<StoreSettings>() as u64),
            MemoryEntry::whole(STORE_VIEWS, size_of::<[ViewUniform; MAX_VIEWS]>() as u64),
            MemoryEntry::whole(MASK_SETTINGS, size_of::<MaskSettings>() as u64),
        ];
        parts.extend(layout.views.iter().map(|_| MemoryEntry::whole(FETCHED, size_of::<FetchPass>() as u64)));
        parts
    }

    fn take(&self, structure: &DirtStructure, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Taken, TracerError> {
        let DirtStructure { layout, geometry: scene, .. } = structure;
        let gpu = &*structure.pipelines.gpu;
        let rays = job.rays.host.len();
        let size = layout.views[0].size;
        let view_edges = "--face-size, or --frame-size with dirt.views=frame";
        let heads = storage_buffer(gpu, HIT_HEADS, pixel_count(layout) * 4, view_edges)?;
        let nodes = storage_buffer(gpu, HIT_NODES, node_bytes(rays), "--size")?;
        let surfaces = hits.surfaces_on_device(rays)?;
        let views = view_uniforms::<MAX_VIEWS>(layout.views.iter().map(view_uniform));
        let settings = StoreSettings { ray_count: rays as u32, view_count: layout.views.len() as u32, pixels: size };
        let bind = |layout: &wgpu::BindGroupLayout, buffers: &[&Buffer]| {
            let resources: Vec<_> = buffers.iter().map(|buffer| buffer.as_entire_binding()).collect();
            bind_group(gpu, layout, &resources)
        };
        let store = bind(
            &self.store(gpu)?.get_bind_group_layout(0),
            &[
                &uniform_buffer(gpu, STORE, &settings)?,
                &uniform_buffer(gpu, STORE_VIEWS, &views)?,
                job.rays.on_device()?,
                hits.on_device(rays)?,
                &heads,
                &nodes,
                surfaces,
            ],
        );
        let mask_settings = MaskSettings { pixels: size, padding: [0; 2] };
        let mask_settings = uniform_buffer(gpu, MASK_SETTINGS, &mask_settings)?;
        let mask_settings = bind(&self.mask(gpu)?.get_bind_group_layout(0), &[&mask_settings, &heads]);
        let device = &scene.surfaces.device;
        let fetch = self.fetch_of(structure)?.get_bind_group_layout(0);
        let setup = &structure.buffers.setup;
        let of_view = |(index, view): (usize, &tracebench_api::View)| {
            let [first_entry, entries] = setup.room_of(index);
            let drawn = FetchPass { view: view_uniform(view), view_index: index as u32, first_entry, pixels: size };
            let drawn = uniform_buffer(gpu, FETCHED, &drawn)?;
            let scene = [&device.materials, setup.vertices(), setup.drawn()];
            let bindings = bind(&fetch, &[&[&drawn], &scene[..], &[&heads, &nodes, surfaces]].concat());
            Ok((bindings, entries * structure.filling.vertices()))
        };
        let views = layout.views.iter().enumerate().map(of_view).collect::<Result<_, TracerError>>()?;
        let before = gpu.allocations();
        let mask = create_texture(gpu, MASK, size, MASK_FORMAT, TextureUsages::RENDER_ATTACHMENT);
        gpu.check()?;
        let used_bytes = pixel_count(layout) * 2;
        let allocated_bytes = gpu.allocations().added_since(&before, MASK).unwrap_or(used_bytes);
        structure.mask_memory.replace(Some(MemoryEntry { name: MASK.to_owned(), allocated_bytes, used_bytes }));
        Ok(Taken { heads, store, mask_settings, mask: mask.create_view(&Default::default()), views })
    }

    /// Records the phases after the search: hits into their lists, the mask, the fetch.
    fn record(
        &self,
        structure: &DirtStructure,
        job: &TraceJob<'_>,
        taken: &Taken,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &*structure.pipelines.gpu;
        let (store, mask, fetch) = (self.store(gpu)?, self.mask(gpu)?, self.fetch_of(structure)?);
        let ray_count = job.rays.host.len() as u32;
        clock.device_phase("final storage", |encoder| {
            encoder.clear_buffer(&taken.heads, 0, None);
            dispatch_linear(encoder, &store, &taken.store, ray_count, WORKGROUP_SIZE);
        })?;
        clock.device_phase("mask", |encoder| {
            let cleared = wgpu::LoadOp::Clear(0.0);
            draw(encoder, "mask", &taken.mask, cleared, &mask, &taken.mask_settings, 3);
        })?;
        clock.device_phase("fetch", |encoder| {
            for (bindings, vertices) in &taken.views {
                draw(encoder, "fetch", &taken.mask, wgpu::LoadOp::Load, &fetch, bindings, *vertices);
            }
        })
    }
}

fn draw(
    encoder: &mut wgpu::CommandEncoder,
    label: &str,
    mask: &TextureView,
    load: wgpu::LoadOp<f32>,
    pipeline: &RenderPipeline,
    bindings: &BindGroup,
    vertices: u32,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: mask,
            depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, bindings, &[]);
    pass.draw(0..vertices, 0..1);
}

fn pixel_count(layout: &Layout) -> u64 {
    layout.views[0].size.map(u64::from).iter().product()
}

fn node_bytes(rays: usize) -> u64 {
    (rays.max(1) * size_of::<HitNode>()) as u64
}

impl DirtStructure {
    /// Records the fetch of surfaces, if the job ends there.
    pub(crate) fn record_surfaces(
        &self,
        job: &TraceJob<'_>,
        fetching: Fetching,
        hits: &HitBuffer,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &*self.pipelines.gpu;
        match (job.trace_to, fetching) {
            (TraceTo::Hit, _) => Ok(()),
            (TraceTo::Surface, Fetching::Gather) => {
                self.pipelines.gather()?.record(gpu, &self.geometry.surfaces, job.rays, hits, None, clock)
            }
            (TraceTo::Surface, Fetching::Raster) => {
                let fetch = &self.pipelines.fetch;
                let taken = fetch.take(self, job, hits)?;
                fetch.record(self, job, &taken, clock)
            }
        }
    }

    /// What that takes while it runs, by name.
    pub(crate) fn surface_memory(&self, job: &TraceJob<'_>, fetching: Fetching) -> Vec<MemoryEntry> {
        match (job.trace_to, fetching) {
            (TraceTo::Hit, _) => Vec::new(),
            (TraceTo::Surface, Fetching::Gather) => vec![Gather::memory()],
            (TraceTo::Surface, Fetching::Raster) => Fetch::memory(&self.layout, job.rays.host.len(), &self.mask_memory),
        }
    }
}

/// Surfaces that were lost.
pub(crate) fn lost(surfaces: &[Surface]) -> u64 {
    surfaces.iter().filter(|surface| surface.status == SurfaceStatus::Lost as u32).count() as u64
}
