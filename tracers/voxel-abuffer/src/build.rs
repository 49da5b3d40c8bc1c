//! The build's stages on the device (HHZ14, section 3.1): one pass over the geometry along every axis, averages, order.

use std::sync::Arc;

use tracebench_api::wgpu::{BindGroup, BindingResource, Buffer, ComputePipeline};
use tracebench_api::{DeviceGeometry, Geometry, Gpu, PhaseClock, TracerError};
use tracebench_kit::{
    Canvas, ComputeRaster, DevicePipelines, EmptyTarget, OnDemand, PipelinesOnDemand, RasterBackend, RasterImage,
    RasterWork, SearchPipelines, TrianglePass, TrianglePipelines, bind_group, check_limits, compute_pipeline,
    dispatch_linear, storage_buffer, uniform_buffer,
};
use tracebench_shaders::Shader;
use tracebench_shaders::voxel_abuffer::{AVERAGE, Fill, Order, Planes, Trace};

use crate::buffers::{Buffers, Lists, Summed, check_sizes};
use crate::layout::{AXES, AveragedGrid, Layout, RasterizedAxis};

/// As `WORKGROUP_SIZE` in the shaders of shaders/voxel-abuffer.
pub(crate) const WORKGROUP_SIZE: u32 = 64;

/// Pixels of a rectangle up to which a lane draws the planes of a triangle by itself: a texel takes more of them than of points, and Mesa's
/// software driver ends the loops of eight lanes together after 65,535 rounds in all.
const SMALL_OF_PLANES: u32 = 128;

/// Every pipeline, each made when it is first needed.
pub struct Pipelines {
    pub(crate) gpu: Arc<Gpu>,
    raster: ComputeRaster,
    raster_of_planes: ComputeRaster,
    fill: TrianglePipelines,
    planes: TrianglePipelines,
    average: OnDemand<(), ComputePipeline>,
    order: PipelinesOnDemand,
    pub(crate) trace: SearchPipelines,
    pub(crate) voxels: PipelinesOnDemand,
}

impl DevicePipelines for Pipelines {
    // None yet. What every build and trace needs is asked of the device's limits.
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        let traced = Trace::Plain { textures: false, planes: true, lifted: true, surfaces: true, counters: true };
        check_limits(&gpu, Fill::Store { halves: false }.into(), &["vertex", "fragment"])?;
        check_limits(&gpu, traced.into(), &["trace"])?;
        Ok(Self {
            raster: ComputeRaster::new(&gpu),
            raster_of_planes: ComputeRaster::of_small(SMALL_OF_PLANES),
            gpu,
            fill: TrianglePipelines::new(),
            planes: TrianglePipelines::new(),
            average: OnDemand::default(),
            order: PipelinesOnDemand::new("order"),
            trace: SearchPipelines::default(),
            voxels: PipelinesOnDemand::new("trace"),
        })
    }
}

impl Pipelines {
    /// The triangles of every image dealt out, where there is no rasterizer.
    fn deal_out(&self, layout: &Layout, geometry: &Geometry) -> Result<Vec<RasterWork>, TracerError> {
        let image = |axis: usize| RasterImage::Axis { space: layout.space, axis: axis as u32, touched: layout.planes };
        let (device, triangles) = (geometry.on_device()?, geometry.triangles.len() as u32);
        let raster = if layout.planes { &self.raster_of_planes } else { &self.raster };
        raster.prepare_all(&self.gpu, layout.raster_backend, (0..AXES).map(image), device, triangles)
    }

    /// The number of fragments along every axis; drawn in the first build, by no phase of it.
    pub(crate) fn tally(&self, layout: &Layout, geometry: &Geometry) -> Result<[u32; AXES], TracerError> {
        let gpu = &*self.gpu;
        check_sizes(gpu, layout)?;
        let taken = storage_buffer(gpu, "fragments of the axes", 4 * AXES as u64, "nothing")?;
        let compute = layout.raster_backend == RasterBackend::Compute;
        let name = "attachment of a count";
        let target = (!compute).then(|| EmptyTarget::new(gpu, name, [layout.image(); 2])).transpose()?;
        let work = self.deal_out(layout, geometry)?;
        let device = geometry.on_device()?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        work.iter().for_each(|work| work.record(&mut encoder));
        for axis in 0..AXES {
            let drawn = uniform_buffer(gpu, "drawn axis", &layout.drawn(axis, 0, 0))?;
            let canvas = Canvas::of(work.get(axis), target.as_ref(), vertices(layout, geometry))?;
            let own = vec![(5, taken.as_entire_binding())];
            let pass = match layout.planes {
                true => draw(gpu, &self.planes, Planes::Tally, &drawn, device, own, canvas)?,
                false => draw(gpu, &self.fill, Fill::Tally, &drawn, device, own, canvas)?,
            };
            pass.record(&mut encoder);
        }
        gpu.queue.submit([encoder.finish()]);
        let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&taken, 4 * AXES as u64)?);
        counts.try_into().map_err(|_| TracerError::Failed("the counts were not read whole".to_owned()))
    }

    /// Records the whole build.
    pub(crate) fn build(
        &self,
        layout: &Layout,
        buffers: &Buffers,
        geometry: &Geometry,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let (gpu, device) = (&*self.gpu, geometry.on_device()?);
        let vertices = vertices(layout, geometry);
        let uniform = |axis: usize| {
            let nodes = buffers.lists.as_ref().map(|lists| &lists.nodes);
            let (capacity, half) = nodes.map_or((0, 0), |nodes| (nodes.capacities[axis], nodes.half_nodes));
            uniform_buffer(gpu, "drawn axis", &layout.drawn(axis, capacity, half))
        };
        let drawn = [uniform(0)?, uniform(1)?, uniform(2)?];
        let work = self.deal_out(layout, geometry)?;
        let canvas = |axis: usize| Canvas::of(work.get(axis), buffers.target.as_ref(), vertices);
        let Some(lists) = &buffers.lists else {
            let cells = || vec![(9, buffers.cells.as_entire_binding())];
            let variant = Fill::Voxels;
            let pass = |axis: usize| draw(gpu, &self.fill, variant, &drawn[axis], device, cells(), canvas(axis)?);
            let passes = [pass(0)?, pass(1)?, pass(2)?];
            RasterWork::record_all(&work, clock)?;
            return clock.device_phase("fill", |encoder| {
                encoder.clear_buffer(&buffers.cells, 0, None);
                passes.iter().for_each(|pass| pass.record(encoder));
            });
        };
        let halves = lists.nodes.has_halves();
        let pass = |axis: usize| {
            let mut own = vec![(3, device.materials.as_entire_binding()), (4, lists.heads_of(axis))];
            own.extend([(5, lists.taken.as_entire_binding()), (6, lists.nodes.nodes_of(axis))]);
            own.extend((7..).zip(lists.nodes.data_of(axis)));
            let Some(summed) = &lists.summed else {
                own.push((9, buffers.cells.as_entire_binding()));
                let variant = Planes::Store { halves };
                return draw(gpu, &self.planes, variant, &drawn[axis], device, own, canvas(axis)?);
            };
            own.extend((9..).zip(summed.sums.iter().map(Buffer::as_entire_binding)));
            own.push((12, summed.fragments.as_entire_binding()));
            draw(gpu, &self.fill, Fill::Store { halves }, &drawn[axis], device, own, canvas(axis)?)
        };
        let passes = [pass(0)?, pass(1)?, pass(2)?];
        let averaged = match &lists.summed {
            Some(summed) => Some(self.averaging(layout, buffers, lists, summed)?),
            None => None,
        };
        let order = self.order.of(gpu, if layout.planes { Order::Oriented } else { Order::Plain { halves } })?;
        let ordered: [BindGroup; AXES] = std::array::from_fn(|axis| {
            let mut own = vec![drawn[axis].as_entire_binding(), lists.heads_of(axis), lists.nodes.nodes_of(axis)];
            own.push(lists.taken.as_entire_binding());
            if !layout.planes {
                own.extend(lists.nodes.data_of(axis));
            }
            bind_group(gpu, &order.get_bind_group_layout(0), &own)
        });
        RasterWork::record_all(&work, clock)?;
        clock.device_phase("fill", |encoder| {
            let summed = lists.summed.iter().flat_map(|summed| summed.sums.iter().chain([&summed.fragments]));
            // Where nothing is summed up fragments mark the voxels themselves.
            let marked = lists.summed.is_none().then_some(&buffers.cells);
            for cleared in summed.chain([&lists.heads, &lists.taken]).chain(marked) {
                encoder.clear_buffer(cleared, 0, None);
            }
            passes.iter().for_each(|pass| pass.record(encoder));
        })?;
        if let Some((average, bindings)) = &averaged {
            clock.device_phase("average normals", |encoder| {
                dispatch_linear(encoder, average, bindings, layout.cell_words(), WORKGROUP_SIZE);
            })?;
        }
        clock.device_phase("order", |encoder| {
            for bindings in &ordered {
                dispatch_linear(encoder, &order, bindings, layout.texels(), WORKGROUP_SIZE);
            }
        })
    }

    /// The pass that averages, and what it binds.
    fn averaging(
        &self,
        layout: &Layout,
        buffers: &Buffers,
        lists: &Lists,
        summed: &Summed,
    ) -> Result<(ComputePipeline, BindGroup), TracerError> {
        let pipeline = self.average.of((), || compute_pipeline(&self.gpu, AVERAGE, "average"))?;
        let averaged = uniform_buffer(&self.gpu, "averaged grid", &layout.averaged_grid())?;
        let [x, y, z] = &summed.sums;
        let bound = [&averaged, x, y, z, &summed.fragments, &buffers.cells, &lists.taken];
        let bound = bound.map(Buffer::as_entire_binding);
        let bindings = bind_group(&self.gpu, &pipeline.get_bind_group_layout(0), &bound);
        Ok((pipeline, bindings))
    }
}

/// A pass along an axis.
fn draw<'a>(
    gpu: &Gpu,
    pipelines: &TrianglePipelines,
    variant: impl Into<Shader>,
    drawn: &Buffer,
    device: &DeviceGeometry,
    own: Vec<(u32, BindingResource<'_>)>,
    canvas: Canvas<'a>,
) -> Result<TrianglePass<'a>, TracerError> {
    let shared = [(0, drawn), (1, &device.positions), (2, &device.indices)];
    let shared = shared.map(|(binding, buffer)| (binding, buffer.as_entire_binding()));
    let all: Vec<_> = shared.into_iter().chain(own).collect();
    pipelines.pass(gpu, variant, &all, canvas)
}

/// Vertices of a pass by the rasterizer: of planes two triangles a triangle, the rectangle of texels that it may touch.
fn vertices(layout: &Layout, geometry: &Geometry) -> u32 {
    (geometry.triangles.len() as u32).saturating_mul(if layout.planes { 6 } else { 3 })
}

/// Bytes of the uniforms of a build, and of what deals triangles out, which are kept until it is done.
pub(crate) fn build_bytes(layout: &Layout, triangles: u32) -> u64 {
    let dealt = if layout.raster_backend == RasterBackend::Compute {
        AXES as u64 * RasterWork::bytes(triangles, true)
    } else {
        0
    };
    let averaged = if layout.voxels_only || layout.planes { 0 } else { size_of::<AveragedGrid>() };
    (AXES * size_of::<RasterizedAxis>() + averaged) as u64 + dealt
}
