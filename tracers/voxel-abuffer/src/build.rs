//! The build's stages on the device (HHZ14, section 3.1): one pass over the geometry along every axis, averages, order.

use std::sync::Arc;

use tracebench_api::wgpu::{BindGroup, BindingResource, Buffer, ComputePipeline, RenderPipeline};
use tracebench_api::{DeviceGeometry, Geometry, Gpu, PhaseClock, TracerError};
use tracebench_kit::{
    EmptyTarget, OnDemand, PipelinesOnDemand, bind_group, bind_group_at, check_limits, compute_pipeline,
    dispatch_linear, storage_buffer, uniform_buffer,
};
use tracebench_shaders::voxel_abuffer::{AVERAGE, Fill, Order, Trace, Voxels};

use crate::buffers::{Buffers, Lists, check_sizes};
use crate::layout::{AXES, AveragedGrid, DrawnAxis, Layout};

/// As `WORKGROUP_SIZE` in the shaders of shaders/voxel-abuffer.
pub(crate) const WORKGROUP_SIZE: u32 = 64;

/// Entry points of shaders/voxel-abuffer/trace.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Entry {
    /// A ray a lane.
    OneRay,
    /// Several rays a lane. Drivers that count a lane's loops leave some unanswered.
    InTurns,
    /// Those that are, a ray a lane.
    Unanswered,
}

/// Every pipeline, each made when it is first needed.
pub(crate) struct Pipelines {
    pub gpu: Arc<Gpu>,
    fill: OnDemand<Fill, RenderPipeline>,
    average: OnDemand<(), ComputePipeline>,
    order: PipelinesOnDemand<Order>,
    trace: OnDemand<(Trace, Entry), ComputePipeline>,
    pub voxels: PipelinesOnDemand<Voxels>,
}

impl Pipelines {
    /// None yet. What every build and trace needs is asked of the device's limits.
    pub(crate) fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        for shader in [
            Fill::Store { halves: false }.into(),
            Trace::Plain { textures: false, planes: true, surfaces: true, counters: true }.into(),
        ] {
            check_limits(&gpu, shader)?;
        }
        Ok(Self {
            gpu,
            fill: OnDemand::default(),
            average: OnDemand::default(),
            order: PipelinesOnDemand::new("order"),
            trace: OnDemand::default(),
            voxels: PipelinesOnDemand::new("trace"),
        })
    }

    fn fill_by(&self, variant: Fill) -> Result<RenderPipeline, TracerError> {
        self.fill.of(variant, || EmptyTarget::pipeline(&self.gpu, variant))
    }

    pub(crate) fn trace(&self, variant: Trace, entry: Entry) -> Result<ComputePipeline, TracerError> {
        let entry_point = match entry {
            Entry::OneRay => "trace",
            Entry::InTurns => "trace_in_turns",
            Entry::Unanswered => "trace_unanswered",
        };
        self.trace.of((variant, entry), || compute_pipeline(&self.gpu, variant, entry_point))
    }

    /// The number of fragments along every axis; drawn outside of any time.
    pub(crate) fn tally(&self, layout: &Layout, geometry: &Geometry) -> Result<[u32; AXES], TracerError> {
        let gpu = &*self.gpu;
        check_sizes(gpu, layout)?;
        let taken = storage_buffer(gpu, "fragments of the axes", 4 * AXES as u64, "nothing")?;
        let target = EmptyTarget::new(gpu, "attachment of a count", [layout.image(); 2])?;
        let pipeline = self.fill_by(Fill::Tally)?;
        let device = geometry.on_device()?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for axis in 0..AXES {
            let drawn = uniform_buffer(gpu, "drawn axis", &layout.drawn(axis, 0, 0))?;
            let bound = [(0, &drawn), (1, &device.positions), (2, &device.indices), (5, &taken)];
            let bound = bound.map(|(binding, buffer)| (binding, buffer.as_entire_binding()));
            let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &bound);
            target.draw(&mut encoder, &pipeline, &bindings, geometry.triangles.len() as u32 * 3);
        }
        gpu.queue.submit([encoder.finish()]);
        let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&taken, 4 * AXES as u64)?);
        counts.try_into().map_err(|_| TracerError::Failed("the counts were not read whole".to_owned()))
    }

    /// What a pass along an axis draws with.
    fn draw(
        &self,
        pipeline: &RenderPipeline,
        drawn: &Buffer,
        device: &DeviceGeometry,
        own: Vec<(u32, BindingResource<'_>)>,
    ) -> BindGroup {
        let shared = [(0, drawn), (1, &device.positions), (2, &device.indices)];
        let shared = shared.map(|(binding, buffer)| (binding, buffer.as_entire_binding()));
        let all: Vec<_> = shared.into_iter().chain(own).collect();
        bind_group_at(&self.gpu, &pipeline.get_bind_group_layout(0), &all)
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
        let vertices = geometry.triangles.len() as u32 * 3;
        let uniform = |axis: usize| {
            let nodes = buffers.lists.as_ref().map(|lists| &lists.nodes);
            let (capacity, half) = nodes.map_or((0, 0), |nodes| (nodes.capacities[axis], nodes.half_nodes));
            uniform_buffer(gpu, "drawn axis", &layout.drawn(axis, capacity, half))
        };
        let drawn = [uniform(0)?, uniform(1)?, uniform(2)?];
        let Some(lists) = &buffers.lists else {
            let pipeline = self.fill_by(Fill::Voxels)?;
            let cells = || vec![(9, buffers.cells.as_entire_binding())];
            let passes = drawn.each_ref().map(|drawn| self.draw(&pipeline, drawn, device, cells()));
            return clock.device_phase("fill", |encoder| {
                encoder.clear_buffer(&buffers.cells, 0, None);
                passes.iter().for_each(|pass| buffers.target.draw(encoder, &pipeline, pass, vertices));
            });
        };
        let halves = lists.nodes.has_halves();
        let fill = self.fill_by(Fill::Store { halves })?;
        let passes: [BindGroup; AXES] = std::array::from_fn(|axis| {
            let mut own = vec![(3, device.materials.as_entire_binding()), (4, lists.heads_of(axis))];
            own.extend([(5, lists.taken.as_entire_binding()), (6, lists.nodes.nodes_of(axis))]);
            own.extend((7..).zip(lists.nodes.data_of(axis)));
            own.extend((9..).zip(lists.sums.iter().map(Buffer::as_entire_binding)));
            own.push((12, lists.fragments.as_entire_binding()));
            self.draw(&fill, &drawn[axis], device, own)
        });
        let average = self.average.of((), || compute_pipeline(gpu, AVERAGE, "average"))?;
        let averaged = self.bind_average(layout, buffers, lists, &average)?;
        let order = self.order.of(gpu, Order { halves })?;
        let ordered: [BindGroup; AXES] = std::array::from_fn(|axis| {
            let mut own = vec![drawn[axis].as_entire_binding(), lists.heads_of(axis), lists.nodes.nodes_of(axis)];
            own.push(lists.taken.as_entire_binding());
            own.extend(lists.nodes.data_of(axis));
            bind_group(gpu, &order.get_bind_group_layout(0), &own)
        });
        clock.device_phase("fill", |encoder| {
            for cleared in lists.sums.iter().chain([&lists.heads, &lists.taken, &lists.fragments]) {
                encoder.clear_buffer(cleared, 0, None);
            }
            passes.iter().for_each(|pass| buffers.target.draw(encoder, &fill, pass, vertices));
        })?;
        clock.device_phase("average normals", |encoder| {
            dispatch_linear(encoder, &average, &averaged, layout.cell_words(), WORKGROUP_SIZE);
        })?;
        clock.device_phase("order", |encoder| {
            for bindings in &ordered {
                dispatch_linear(encoder, &order, bindings, layout.texels(), WORKGROUP_SIZE);
            }
        })
    }

    fn bind_average(
        &self,
        layout: &Layout,
        buffers: &Buffers,
        lists: &Lists,
        pipeline: &ComputePipeline,
    ) -> Result<BindGroup, TracerError> {
        let averaged = uniform_buffer(&self.gpu, "averaged grid", &layout.averaged_grid())?;
        let [x, y, z] = &lists.sums;
        let bound = [&averaged, x, y, z, &lists.fragments, &buffers.cells, &lists.taken];
        let bound = bound.map(Buffer::as_entire_binding);
        Ok(bind_group(&self.gpu, &pipeline.get_bind_group_layout(0), &bound))
    }
}

/// Bytes of the uniforms of a build, which are kept until it is done.
pub(crate) fn build_uniform_bytes(layout: &Layout) -> u64 {
    let averaged = if layout.voxels_only { 0 } else { size_of::<AveragedGrid>() };
    (AXES * size_of::<DrawnAxis>() + averaged) as u64
}
