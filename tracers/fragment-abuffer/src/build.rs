//! The build's stages on the device (VVP16, section 3.3): depth bounds, store, reorder.

use std::collections::BTreeMap;
use std::sync::Arc;

use tracebench_api::wgpu::{BindGroup, BindingResource, Buffer, ComputePipeline, RenderPipeline};
use tracebench_api::{DeviceGeometry, Geometry, Gpu, PhaseClock, TracerError};
use tracebench_kit::{
    EmptyTarget, PipelinesOnDemand, PrefixSum, ViewUniform, bind_group, bind_group_at, compute_pipeline,
    dispatch_linear, every_variant, storage_buffer, uniform_buffer,
};
use tracebench_shaders::fragment_abuffer::{Boxes, Fill, MIPMAP, Reorder, Trace};

use crate::layout::{DrawnView, Layout, Storage, TracedView};
use crate::objects::Objects;
use crate::parts::{Part, Parts, check_nodes, view_suffix};

/// As `WORKGROUP_SIZE` in the shaders of shaders/fragment-abuffer.
pub(crate) const WORKGROUP_SIZE: u32 = 64;

/// Every pipeline; those of traces are made when they are first asked for.
pub(crate) struct Pipelines {
    pub gpu: Arc<Gpu>,
    pub sums: PrefixSum,
    boxes: RenderPipeline,
    boxes_bound: ComputePipeline,
    fill: BTreeMap<Fill, RenderPipeline>,
    reorder: BTreeMap<Reorder, ComputePipeline>,
    mipmap: ComputePipeline,
    pub(crate) traces: PipelinesOnDemand<Trace>,
}

impl Pipelines {
    pub(crate) fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self {
            sums: PrefixSum::new(&gpu)?,
            boxes: EmptyTarget::pipeline(&gpu, Boxes { bound: false })?,
            boxes_bound: compute_pipeline(&gpu, Boxes { bound: true }, "bound")?,
            fill: every_variant(|variant: Fill| EmptyTarget::pipeline(&gpu, variant))?,
            reorder: every_variant(|variant: Reorder| compute_pipeline(&gpu, variant, "reorder"))?,
            mipmap: compute_pipeline(&gpu, MIPMAP, "mipmap")?,
            traces: PipelinesOnDemand::new("trace"),
            gpu,
        })
    }
}

/// A pass over all triangles, or over all boxes, of a view.
struct Drawing<'a> {
    view: usize,
    pipeline: &'a RenderPipeline,
    bindings: BindGroup,
    vertices: u32,
}

/// What a fill binds: made before the phases, which only record.
#[derive(Default)]
struct Prepared<'a> {
    boxes: Option<(BindGroup, u32)>,
    bounds: Vec<Drawing<'a>>,
    count: Vec<Drawing<'a>>,
    store: Vec<Drawing<'a>>,
    /// With the number of lists.
    reorder: Vec<(BindGroup, u32)>,
    /// With the number of cells.
    mipmaps: Vec<(BindGroup, u32)>,
}

impl Pipelines {
    fn prepare<'a>(
        &'a self,
        layout: &Layout,
        parts: &Parts,
        geometry: &DeviceGeometry,
        objects: Option<&Objects>,
        triangles: u32,
    ) -> Result<Prepared<'a>, TracerError> {
        let gpu = &*self.gpu;
        let mut prepared = Prepared::default();
        if let Some(objects) = objects {
            let resources = [&geometry.positions, &geometry.indices, &objects.of_triangles, &objects.boxes];
            let resources = resources.map(Buffer::as_entire_binding);
            prepared.boxes = Some((bind_group(gpu, &self.boxes_bound.get_bind_group_layout(0), &resources), triangles));
        }
        let store = &self.fill[&Fill::Store { decoupled: layout.decoupled }];
        for part in &parts.parts {
            let storage = layout.storage(part.pixel_count, part.capacity);
            let storage = uniform_buffer(gpu, "storage", &storage)?;
            for (view, first_pixel) in part.views.clone().zip(&part.first_pixels) {
                let shape = &layout.views[view];
                let drawn = DrawnView {
                    view: ViewUniform::from(shape),
                    first_pixel: *first_pixel,
                    width: shape.size[0],
                    padding: [0; 2],
                };
                let drawn = uniform_buffer(gpu, "drawn view", &drawn)?;
                let draw = |pipeline: &'a RenderPipeline, more: &[(u32, &Buffer)], vertices: u32| {
                    let mut resources = vec![(0, storage.as_entire_binding()), (1, drawn.as_entire_binding())];
                    resources.extend(more.iter().map(|(binding, buffer)| (*binding, buffer.as_entire_binding())));
                    let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
                    Drawing { view, pipeline, bindings, vertices }
                };
                let scene = [(2, &geometry.positions), (3, &geometry.indices), (4, &part.pixels)];
                if layout.has_bounds() {
                    prepared.bounds.push(match objects {
                        Some(objects) => {
                            draw(&self.boxes, &[(2, &objects.boxes), (3, &part.pixels)], objects.count * 6)
                        }
                        None => draw(&self.fill[&Fill::Bounds], &scene, triangles * 3),
                    });
                }
                let taken = (5, &part.taken);
                if layout.kind.is_contiguous() {
                    prepared.count.push(draw(
                        &self.fill[&Fill::Count],
                        &[&scene[..], &[taken]].concat(),
                        triangles * 3,
                    ));
                }
                let mut bound = scene.to_vec();
                bound.push(taken);
                bound.extend([(6, &part.ids), (8, &geometry.materials)]);
                bound.extend(part.payloads.as_ref().map(|payloads| (7, payloads)));
                prepared.store.push(draw(store, &bound, triangles * 3));
            }
            prepared.reorder.push(self.bind_reorder(layout, part, &storage));
            self.prepare_mipmaps(layout, parts, part, &storage, &mut prepared)?;
        }
        Ok(prepared)
    }

    /// The number of fragments of every view, of all layers; drawn outside of any time. Stops at a view that no device buffer
    /// could be bound for.
    pub(crate) fn tally(&self, layout: &Layout, geometry: &Geometry) -> Result<Vec<u32>, TracerError> {
        let gpu = &*self.gpu;
        let tally = &self.fill[&Fill::Tally];
        let device = geometry.on_device()?;
        let taken = storage_buffer(gpu, "fragments of a view", 4, "nothing")?;
        let mut counts = Vec::with_capacity(layout.views.len());
        for (view, shape) in layout.views.iter().enumerate() {
            let target = EmptyTarget::new(gpu, "attachment of a count", shape.size)?;
            let drawn =
                DrawnView { view: ViewUniform::from(shape), first_pixel: 0, width: shape.size[0], padding: [0; 2] };
            let drawn = uniform_buffer(gpu, "drawn view", &drawn)?;
            let bound = [(1, &drawn), (2, &device.positions), (3, &device.indices), (5, &taken)];
            let bound = bound.map(|(binding, buffer)| (binding, buffer.as_entire_binding()));
            let bindings = bind_group_at(gpu, &tally.get_bind_group_layout(0), &bound);
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(&taken, 0, None);
            target.draw(&mut encoder, tally, &bindings, geometry.triangles.len() as u32 * 3);
            gpu.queue.submit([encoder.finish()]);
            let count = bytemuck::pod_collect_to_vec::<u8, u32>(&gpu.read(&taken, 4)?)[0];
            check_nodes(gpu, layout, &view_suffix(view), count)?;
            counts.push(count);
        }
        Ok(counts)
    }

    fn bind_reorder(&self, layout: &Layout, part: &Part, storage: &Buffer) -> (BindGroup, u32) {
        let pipeline = self.reorder(layout);
        let buffers = [storage, &part.pixels, &part.ids, &part.taken].into_iter().chain(&part.payloads);
        let resources: Vec<BindingResource<'_>> = buffers.map(Buffer::as_entire_binding).collect();
        let bindings = bind_group(&self.gpu, &pipeline.get_bind_group_layout(0), &resources);
        (bindings, part.pixel_count * layout.buckets)
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
        let prepared = self.prepare(layout, parts, geometry.on_device()?, objects, triangles)?;
        let mut first = true;
        let mut phase = |clock: &mut PhaseClock<'_>, name: &str, drawings: &[Drawing<'_>]| {
            clock.device_phase(name, |encoder| {
                if std::mem::take(&mut first) {
                    for part in &parts.parts {
                        encoder.clear_buffer(&part.pixels, 0, None);
                        encoder.clear_buffer(&part.taken, 0, None);
                    }
                    if let (Some(objects), Some((bindings, count))) = (objects, &prepared.boxes) {
                        encoder.clear_buffer(&objects.boxes, 0, None);
                        dispatch_linear(encoder, &self.boxes_bound, bindings, *count, WORKGROUP_SIZE);
                    }
                }
                for drawing in drawings {
                    let target = parts.target(drawing.view);
                    target.draw(encoder, drawing.pipeline, &drawing.bindings, drawing.vertices);
                }
            })
        };
        if layout.has_bounds() {
            phase(clock, "depth bounds", &prepared.bounds)?;
        }
        if layout.kind.is_contiguous() {
            phase(clock, "count fragments", &prepared.count)?;
            clock.device_phase("prefix sum", |encoder| {
                for plan in parts.parts.iter().filter_map(|part| part.begins.as_ref()) {
                    self.sums.record(encoder, plan);
                }
            })?;
        }
        phase(clock, "store", &prepared.store)?;
        let dispatch =
            |clock: &mut PhaseClock<'_>, name: &str, pipeline: &ComputePipeline, work: &[(BindGroup, u32)]| {
                clock.device_phase(name, |encoder| {
                    for (bindings, count) in work {
                        dispatch_linear(encoder, pipeline, bindings, *count, WORKGROUP_SIZE);
                    }
                })
            };
        dispatch(clock, "reorder", self.reorder(layout), &prepared.reorder)?;
        if parts.pyramid.is_some() {
            dispatch(clock, "mipmap depth", &self.mipmap, &prepared.mipmaps)?;
        }
        Ok(())
    }
}

/// Bytes of the uniforms of a build, which are kept until it is done.
pub(crate) fn build_uniform_bytes(layout: &Layout, parts: &Parts) -> u64 {
    let levels: usize = (0..layout.views.len()).map(|view| layout.levels_of(view) - 1).sum();
    let made = if layout.hi_z { layout.views.len() * size_of::<TracedView>() + levels * 16 } else { 0 };
    (parts.parts.len() * size_of::<Storage>() + layout.views.len() * size_of::<DrawnView>() + made) as u64
}
