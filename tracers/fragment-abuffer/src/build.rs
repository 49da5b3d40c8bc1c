//! The build's stages on the device (VVP16, section 3.3): depth bounds, store, reorder.

use std::collections::BTreeMap;
use std::sync::Arc;

use tracebench_api::wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, CommandEncoder, ComputePipeline};
use tracebench_api::{DeviceGeometry, Geometry, Gpu, PhaseClock, TracerError, View};
use tracebench_kit::{
    Canvas, ComputeRaster, DevicePipelines, EmptyTarget, PipelinesOnDemand, PrefixSum, RasterBackend, RasterWork,
    SearchPipelines, TrianglePass, TrianglePipelines, bind_group, bind_group_at, compute_pipeline, dispatch_indirect,
    dispatch_linear, every_variant, storage_buffer, uniform_buffer, view_uniform,
};
use tracebench_shaders::Variant;
use tracebench_shaders::fragment_abuffer::{BOXES, Fill, MIPMAP, Reorder, ReorderLong};

use crate::layout::{Layout, RasterizedView, Storage, TracedView};
use crate::objects::Objects;
use crate::parts::{Part, Parts, check_nodes, view_suffix};

/// As `WORKGROUP_SIZE` in the shaders of shaders/fragment-abuffer.
pub(crate) const WORKGROUP_SIZE: u32 = 64;

/// As `BAND` in shaders/fragment-abuffer/boxes.wgsl: rows of a box that a workgroup draws.
pub(crate) const BAND: u32 = 16;

/// As `MAX_ALONE` in shaders/fragment-abuffer/reorder.wgsl: nodes of a piece that an invocation orders alone.
pub(crate) const MAX_ALONE: u32 = 128;

/// Workgroups of a dispatch along a dimension, which WebGPU grants: so many long pieces are ordered.
const MAX_LONG_PIECES: u32 = 65_535;

/// Every pipeline; those of traces, and of builds without the rasterizer, are made when they are first asked for.
pub struct Pipelines {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) sums: PrefixSum,
    raster: ComputeRaster,
    boxes: TrianglePipelines,
    boxes_bound: ComputePipeline,
    computed_boxes: PipelinesOnDemand,
    fill: TrianglePipelines,
    reorder: BTreeMap<Reorder, ComputePipeline>,
    reorder_long: PipelinesOnDemand,
    mipmap: ComputePipeline,
    pub(crate) traces: SearchPipelines,
}

impl DevicePipelines for Pipelines {
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        let (boxes, fill) = (TrianglePipelines::new(), TrianglePipelines::new());
        boxes.raster(&gpu, BOXES)?;
        for variant in Fill::ALL.iter().filter(|variant| is_published(**variant)) {
            fill.raster(&gpu, *variant)?;
        }
        Ok(Self {
            sums: PrefixSum::new(&gpu)?,
            raster: ComputeRaster::new(&gpu),
            boxes,
            boxes_bound: compute_pipeline(&gpu, BOXES, "bound")?,
            computed_boxes: PipelinesOnDemand::new("draw"),
            fill,
            reorder: every_variant(|variant: Reorder| compute_pipeline(&gpu, variant, "reorder"))?,
            reorder_long: PipelinesOnDemand::new("reorder_long"),
            mipmap: compute_pipeline(&gpu, MIPMAP, "mipmap")?,
            traces: SearchPipelines::default(),
            gpu,
        })
    }
}

/// Whether the published form draws by a variant, so that it is made at once.
fn is_published(variant: Fill) -> bool {
    match variant {
        Fill::Bounds { clipped } | Fill::Count { clipped } | Fill::Tally { clipped } | Fill::Store { clipped, .. } => {
            !clipped
        }
    }
}

/// A pass that fills depth bounds.
enum Bounding<'a> {
    /// By triangles, or by boxes and the rasterizer.
    Drawn(TrianglePass<'a>),
    /// By boxes, by so many workgroups.
    Computed(ComputePipeline, BindGroup, u32),
}

impl Bounding<'_> {
    fn record(&self, encoder: &mut CommandEncoder) {
        match self {
            Self::Drawn(pass) => pass.record(encoder),
            Self::Computed(pipeline, bindings, workgroups) => {
                dispatch_linear(encoder, pipeline, bindings, *workgroups, 1);
            }
        }
    }
}

/// Resources of buffers by their bindings.
fn bound<'a>(buffers: &[(u32, &'a Buffer)]) -> Vec<(u32, BindingResource<'a>)> {
    buffers.iter().map(|(binding, buffer)| (*binding, buffer.as_entire_binding())).collect()
}

/// Pieces of the s-buffer that a workgroup orders each: as many as a buffer says, which are listed there.
struct LongPieces {
    list: Buffer,
    pipeline: ComputePipeline,
    bindings: BindGroup,
}

/// What a fill binds: made before the phases, which only record.
#[derive(Default)]
struct Prepared<'a> {
    boxes: Option<(BindGroup, u32)>,
    bounds: Vec<Bounding<'a>>,
    count: Vec<TrianglePass<'a>>,
    store: Vec<TrianglePass<'a>>,
    /// With the number of lists.
    reorder: Vec<(BindGroup, u32)>,
    reorder_long: Vec<LongPieces>,
    /// With the number of cells.
    mipmaps: Vec<(BindGroup, u32)>,
}

impl Pipelines {
    fn prepare<'a>(
        &self,
        layout: &Layout,
        parts: &'a Parts,
        geometry: &DeviceGeometry,
        objects: Option<&Objects>,
        work: &'a [RasterWork],
        triangles: u32,
    ) -> Result<Prepared<'a>, TracerError> {
        let gpu = &*self.gpu;
        let mut prepared = Prepared::default();
        if let Some(objects) = objects {
            let resources =
                [&geometry.positions, &geometry.indices, &objects.of_triangles.buffer, &objects.boxes.buffer];
            let resources = resources.map(Buffer::as_entire_binding);
            prepared.boxes = Some((bind_group(gpu, &self.boxes_bound.get_bind_group_layout(0), &resources), triangles));
        }
        let clipped = layout.is_clipped();
        for part in &parts.parts {
            let storage = layout.storage(part.pixel_count, part.capacity);
            let storage = uniform_buffer(gpu, "storage", &storage)?;
            for (view, first_pixel) in part.views.clone().zip(&part.first_pixels) {
                let shape = &layout.views[view];
                let drawn = RasterizedView {
                    view: view_uniform(shape),
                    first_pixel: *first_pixel,
                    width: shape.size[0],
                    padding: [0; 2],
                };
                let drawn = uniform_buffer(gpu, "drawn view", &drawn)?;
                let uniforms = [(0, &storage), (3, &drawn)];
                let scene = [(1, &geometry.positions), (2, &geometry.indices), (4, &part.pixels)];
                let canvas = |vertices: u32| Canvas::of(work.get(view), parts.target(view), vertices);
                let draw = |fill: Fill, more: &[(u32, &Buffer)]| {
                    let buffers = [&uniforms[..], &scene[..], more].concat();
                    self.fill.pass(gpu, fill, &bound(&buffers), canvas(layout.vertices(triangles))?)
                };
                if layout.has_bounds() {
                    prepared.bounds.push(match objects {
                        Some(objects) => {
                            let buffers = [&uniforms[..], &[(2, &objects.boxes.buffer), (4, &part.pixels)]].concat();
                            self.by_boxes(&bound(&buffers), canvas(objects.count * 6)?, objects, shape)?
                        }
                        None => Bounding::Drawn(draw(Fill::Bounds { clipped }, &[])?),
                    });
                }
                let taken = (5, &part.taken);
                if layout.kind.is_contiguous() {
                    prepared.count.push(draw(Fill::Count { clipped }, &[taken])?);
                }
                let mut stored = vec![taken, (6, &part.ids), (8, &geometry.materials)];
                stored.extend(part.payloads.as_ref().map(|payloads| (7, payloads)));
                let store = Fill::Store { decoupled: layout.decoupled, clipped };
                prepared.store.push(draw(store, &stored)?);
            }
            self.prepare_reorder(layout, part, &storage, &mut prepared)?;
            self.prepare_mipmaps(layout, parts, part, &storage, &mut prepared)?;
        }
        Ok(prepared)
    }

    /// A pass over the boxes of a view, with these resources.
    fn by_boxes<'a>(
        &self,
        resources: &[(u32, BindingResource<'_>)],
        canvas: Canvas<'a>,
        objects: &Objects,
        view: &View,
    ) -> Result<Bounding<'a>, TracerError> {
        let gpu = &*self.gpu;
        if matches!(canvas, Canvas::Attachment(..)) {
            return Ok(Bounding::Drawn(self.boxes.pass(gpu, BOXES, resources, canvas)?));
        }
        let pipeline = self.computed_boxes.of(gpu, BOXES)?;
        let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), resources);
        Ok(Bounding::Computed(pipeline, bindings, objects.count.saturating_mul(view.size[1].div_ceil(BAND))))
    }

    /// The number of fragments of every view, of all layers; drawn by no phase of the build. Stops at a view that no device buffer
    /// could be bound for.
    pub(crate) fn tally(&self, layout: &Layout, geometry: &Geometry) -> Result<Vec<u32>, TracerError> {
        let gpu = &*self.gpu;
        let (clipped, compute) = (layout.is_clipped(), layout.raster_backend == RasterBackend::Compute);
        let (device, triangles) = (geometry.on_device()?, geometry.triangles.len() as u32);
        let taken = storage_buffer(gpu, "fragments of a view", 4, "nothing")?;
        let storage = uniform_buffer(gpu, "storage", &layout.storage(0, 0))?;
        let mut counts = Vec::with_capacity(layout.views.len());
        for (view, shape) in layout.views.iter().enumerate() {
            let drawn =
                RasterizedView { view: view_uniform(shape), first_pixel: 0, width: shape.size[0], padding: [0; 2] };
            let drawn = uniform_buffer(gpu, "drawn view", &drawn)?;
            let image = [layout.image_of(shape)];
            let work = self.raster.prepare_all(gpu, layout.raster_backend, image, device, triangles)?;
            let target = (!compute).then(|| EmptyTarget::new(gpu, "attachment of a count", shape.size)).transpose()?;
            let canvas = Canvas::of(work.first(), target.as_ref(), layout.vertices(triangles))?;
            let mut buffers = vec![(1, &device.positions), (2, &device.indices), (3, &drawn), (5, &taken)];
            buffers.extend(clipped.then_some((0, &storage)));
            let pass = self.fill.pass(gpu, Fill::Tally { clipped }, &bound(&buffers), canvas)?;
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(&taken, 0, None);
            work.iter().for_each(|work| work.record(&mut encoder));
            pass.record(&mut encoder);
            gpu.queue.submit([encoder.finish()]);
            let count = bytemuck::pod_collect_to_vec::<u8, u32>(&gpu.read(&taken, 4)?)[0];
            check_nodes(gpu, layout, &view_suffix(view), count)?;
            counts.push(count);
        }
        Ok(counts)
    }

    fn prepare_reorder(
        &self,
        layout: &Layout,
        part: &Part,
        storage: &Buffer,
        prepared: &mut Prepared<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &*self.gpu;
        let mut buffers = vec![(0, storage), (1, &part.pixels), (2, &part.ids), (3, &part.taken)];
        buffers.extend(part.payloads.as_ref().map(|payloads| (4, payloads)));
        let mut long = None;
        if layout.kind.is_contiguous() {
            let usages = BufferUsages::STORAGE | BufferUsages::INDIRECT;
            let bytes = long_pieces_bytes(part.capacity);
            long = Some(gpu.buffer("long pieces of an s-buffer", bytes, usages, "nothing")?);
        }
        buffers.extend(long.as_ref().map(|list| (5, list)));
        let bindings_for =
            |pipeline: &ComputePipeline| bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &bound(&buffers));
        prepared.reorder.push((bindings_for(self.reorder(layout)), part.pixel_count * layout.buckets));
        if let Some(list) = &long {
            let pipeline = self.reorder_long.of(gpu, ReorderLong::Contiguous { decoupled: layout.decoupled })?;
            let bindings = bindings_for(&pipeline);
            prepared.reorder_long.push(LongPieces { list: list.clone(), pipeline, bindings });
        }
        Ok(())
    }

    fn reorder(&self, layout: &Layout) -> &ComputePipeline {
        &self.reorder[&Reorder { contiguous: layout.kind.is_contiguous(), decoupled: layout.decoupled }]
    }

    fn prepare_mipmaps(
        &self,
        layout: &Layout,
        parts: &Parts,
        part: &Part,
        storage: &Buffer,
        prepared: &mut Prepared<'_>,
    ) -> Result<(), TracerError> {
        let Some(pyramid) = &parts.pyramid else { return Ok(()) };
        let gpu = &*self.gpu;
        let traced = layout.traced(&parts.placed());
        for view in part.views.clone() {
            let made = uniform_buffer(gpu, "made view", &traced[view])?;
            for level in 1..layout.levels_of(view) {
                let number = uniform_buffer(gpu, "level", &[level as u32, 0, 0, 0])?;
                let resources = [storage, &made, &number, &part.pixels, pyramid].map(Buffer::as_entire_binding);
                let bindings = bind_group(gpu, &self.mipmap.get_bind_group_layout(0), &resources);
                let [across, down] = layout.pyramid_of(view).level_size(level);
                prepared.mipmaps.push((bindings, across * down));
            }
        }
        Ok(())
    }

    /// Records the whole build.
    pub(crate) fn fill(
        &self,
        layout: &Layout,
        parts: &Parts,
        geometry: &Geometry,
        objects: Option<&Objects>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let triangles = geometry.triangles.len() as u32;
        let device = geometry.on_device()?;
        let images = layout.views.iter().map(|view| layout.image_of(view));
        let work = self.raster.prepare_all(&self.gpu, layout.raster_backend, images, device, triangles)?;
        let prepared = self.prepare(layout, parts, device, objects, &work, triangles)?;
        RasterWork::record_all(&work, clock)?;
        let mut first = true;
        let mut phase = |clock: &mut PhaseClock<'_>, name: &str, record: &dyn Fn(&mut CommandEncoder)| {
            clock.device_phase(name, |encoder| {
                if std::mem::take(&mut first) {
                    for part in &parts.parts {
                        encoder.clear_buffer(&part.pixels, 0, None);
                        encoder.clear_buffer(&part.taken, 0, None);
                    }
                    if let (Some(objects), Some((bindings, count))) = (objects, &prepared.boxes) {
                        encoder.clear_buffer(&objects.boxes.buffer, 0, None);
                        dispatch_linear(encoder, &self.boxes_bound, bindings, *count, WORKGROUP_SIZE);
                    }
                }
                record(encoder);
            })
        };
        if layout.has_bounds() {
            phase(clock, "depth bounds", &|encoder| prepared.bounds.iter().for_each(|pass| pass.record(encoder)))?;
        }
        if layout.kind.is_contiguous() {
            phase(clock, "count fragments", &|encoder| prepared.count.iter().for_each(|pass| pass.record(encoder)))?;
            clock.device_phase("prefix sum", |encoder| {
                for plan in parts.parts.iter().filter_map(|part| part.begins.as_ref()) {
                    self.sums.record(encoder, plan);
                }
            })?;
        }
        phase(clock, "store", &|encoder| prepared.store.iter().for_each(|pass| pass.record(encoder)))?;
        clock.device_phase("reorder", |encoder| {
            for (bindings, count) in &prepared.reorder {
                dispatch_linear(encoder, self.reorder(layout), bindings, *count, WORKGROUP_SIZE);
            }
            for LongPieces { list, pipeline, bindings } in &prepared.reorder_long {
                dispatch_indirect(encoder, pipeline, &[bindings], list, 0);
            }
        })?;
        if parts.pyramid.is_some() {
            clock.device_phase("mipmap depth", |encoder| {
                for (bindings, count) in &prepared.mipmaps {
                    dispatch_linear(encoder, &self.mipmap, bindings, *count, WORKGROUP_SIZE);
                }
            })?;
        }
        Ok(())
    }
}

/// Bytes of the list of pieces that are too long for an invocation, which are no more than fit into so many nodes.
fn long_pieces_bytes(capacity: u32) -> u64 {
    4 * u64::from(3 + (capacity / MAX_ALONE).clamp(1, MAX_LONG_PIECES))
}

/// Bytes of the uniforms of a build, and of what deals triangles out, which are kept until it is done.
pub(crate) fn build_bytes(layout: &Layout, parts: &Parts, triangles: u32) -> u64 {
    let levels: usize = (0..layout.views.len()).map(|view| layout.levels_of(view) - 1).sum();
    let made = if layout.hi_z { layout.views.len() * size_of::<TracedView>() + levels * 16 } else { 0 };
    let uniforms = parts.parts.len() * size_of::<Storage>() + layout.views.len() * size_of::<RasterizedView>() + made;
    let of_view = if layout.raster_backend == RasterBackend::Compute { RasterWork::bytes(triangles, false) } else { 0 };
    let long_pieces: u64 = match layout.kind.is_contiguous() {
        true => parts.parts.iter().map(|part| long_pieces_bytes(part.capacity)).sum(),
        false => 0,
    };
    uniforms as u64 + long_pieces + layout.views.len() as u64 * of_view
}
