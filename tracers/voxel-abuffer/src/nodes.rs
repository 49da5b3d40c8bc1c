//! Nodes of the lists and their data: one buffer of a kind for all axes, or one an axis where one binding does not hold all, of data two.

use std::num::NonZeroU64;

use tracebench_api::wgpu::{BindingResource, Buffer, BufferBinding};
use tracebench_api::{Gpu, Ledger, TracerError};
use tracebench_kit::{RasterBackend, check_limits, storage_buffer};
use tracebench_shaders::voxel_abuffer::{Fill, Trace};

use crate::layout::{AXES, AXIS_NAMES};

/// What takes less room of everything that a build makes.
pub(crate) const HINT: &str = "voxel-abuffer.abuffer (or --face-size, where that is 0)";

/// Bytes of a node: depth and next link; and of its data: normal and material, of planes slopes, part of the texel and material.
pub(crate) const NODE_BYTES: u64 = 8;
pub(crate) const DATA_BYTES: u64 = 16;

/// Capacities are whole multiples of it, as devices ask of where a binding begins.
const CAPACITY_ALIGNMENT: u32 = 32;

/// What ledgers call the buffers.
const NODES: &str = "nodes";
const DATA: &str = "data";

/// The nodes of all axes.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// One buffer, or one an axis.
    nodes: Vec<(String, Buffer)>,
    /// One buffer, one an axis, or two an axis.
    data: Vec<(String, Buffer)>,
    /// Nodes that there is room for, by axis.
    pub capacities: [u32; AXES],
    /// Nodes of an axis that have their data in its first buffer; all of them where there is one.
    pub half_nodes: u32,
}

/// Where the nodes of an axis and their data begin, in units of themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Placed {
    pub first_node: u32,
    pub first_data: u32,
    pub first_further_data: u32,
}

fn bytes(count: u32, each: u64) -> u64 {
    u64::from(count) * each
}

fn of_axis(name: &str, axis: usize) -> String {
    format!("{name}, axis {}", AXIS_NAMES[axis])
}

impl Nodes {
    /// Room for so many nodes of every axis.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind them, not even each axis by itself.
    pub(crate) fn new(gpu: &Gpu, raster_backend: RasterBackend, needed: [u32; AXES]) -> Result<Self, TracerError> {
        let capacities = capacities(gpu, needed)?;
        match Self::whole(gpu, capacities) {
            Err(error @ TracerError::TooLarge { .. }) if !binds_every_axis(gpu, raster_backend) => Err(error),
            Err(TracerError::TooLarge { .. }) => Self::by_axis(gpu, capacities),
            made => made,
        }
    }

    fn whole(gpu: &Gpu, capacities: [u32; AXES]) -> Result<Self, TracerError> {
        let all: u64 = capacities.iter().copied().map(u64::from).sum();
        let buffer = |name: &str, each| {
            Ok::<_, TracerError>(vec![(name.to_owned(), storage_buffer(gpu, name, all * each, HINT)?)])
        };
        // Of both before either is made.
        gpu.check_storage_binding(DATA, all * DATA_BYTES, HINT)?;
        Ok(Self {
            nodes: buffer(NODES, NODE_BYTES)?,
            data: buffer(DATA, DATA_BYTES)?,
            capacities,
            half_nodes: u32::MAX,
        })
    }

    fn by_axis(gpu: &Gpu, capacities: [u32; AXES]) -> Result<Self, TracerError> {
        let most = capacities.iter().copied().max().unwrap_or_default();
        let limit = gpu.limits.max_storage_buffer_binding_size.min(gpu.limits.max_buffer_size);
        let half = u32::try_from(limit / DATA_BYTES).unwrap_or(u32::MAX);
        let half_nodes = if most > half { half } else { u32::MAX };
        let (mut nodes, mut data) = (Vec::new(), Vec::new());
        for (axis, capacity) in capacities.into_iter().enumerate() {
            let name = of_axis(NODES, axis);
            let buffer = storage_buffer(gpu, &name, bytes(capacity, NODE_BYTES), HINT)?;
            nodes.push((name, buffer));
            let halves = if half_nodes == u32::MAX { vec![capacity] } else { halves(capacity, half_nodes) };
            for (half, count) in halves.into_iter().enumerate() {
                let name = format!("{}{}", of_axis(DATA, axis), if half == 0 { "" } else { ", second half" });
                // Of an axis that needs no second half one is bound all the same.
                let buffer = storage_buffer(gpu, &name, bytes(count.max(1), DATA_BYTES), HINT)?;
                data.push((name, buffer));
            }
        }
        Ok(Self { nodes, data, capacities, half_nodes })
    }

    /// Whether axes have buffers of their own.
    pub(crate) fn is_by_axis(&self) -> bool {
        self.nodes.len() > 1
    }

    /// Whether the data of an axis lies in two of them.
    pub(crate) fn has_halves(&self) -> bool {
        self.half_nodes != u32::MAX
    }

    /// Nodes before those of an axis, among all.
    pub(crate) fn before(&self, axis: usize) -> u32 {
        self.capacities[..axis].iter().sum()
    }

    /// Nodes that there is room for in all.
    pub(crate) fn capacity(&self) -> u32 {
        self.before(AXES)
    }

    /// An axis' own of the nodes, as builds bind them.
    pub(crate) fn nodes_of(&self, axis: usize) -> BindingResource<'_> {
        self.of(&self.nodes, NODE_BYTES, axis)
    }

    /// An axis' own of the data, one binding or two.
    pub(crate) fn data_of(&self, axis: usize) -> Vec<BindingResource<'_>> {
        match self.has_halves() {
            true => self.data[2 * axis..2 * axis + 2].iter().map(|(_, buffer)| buffer.as_entire_binding()).collect(),
            false => vec![self.of(&self.data, DATA_BYTES, axis)],
        }
    }

    fn of<'a>(&'a self, buffers: &'a [(String, Buffer)], each: u64, axis: usize) -> BindingResource<'a> {
        match buffers {
            [(_, buffer)] => {
                let offset = bytes(self.before(axis), each);
                let size = NonZeroU64::new(bytes(self.capacities[axis], each));
                BindingResource::Buffer(BufferBinding { buffer, offset, size })
            }
            own => own[axis].1.as_entire_binding(),
        }
    }

    /// The buffers of nodes and of data.
    pub(crate) fn buffers(&self) -> [Vec<&Buffer>; 2] {
        [&self.nodes, &self.data].map(|buffers| buffers.iter().map(|(_, buffer)| buffer).collect())
    }

    /// A buffer of an axis' data, its first or its second.
    pub(crate) fn data_buffer(&self, axis: usize, further: bool) -> &Buffer {
        let step = if self.has_halves() { 2 } else { 1 };
        &self.data[axis * step + usize::from(further && self.has_halves())].1
    }

    /// Where every axis begins, in one buffer or, by `first`, where each buffer does in what they were joined to.
    pub(crate) fn placed(&self, first: Option<[Vec<u32>; 2]>) -> [Placed; AXES] {
        std::array::from_fn(|axis| match &first {
            Some([nodes, data]) if self.is_by_axis() => {
                let step = if self.has_halves() { 2 } else { 1 };
                let first_data = data[axis * step];
                let first_further_data = if self.has_halves() { data[axis * 2 + 1] } else { first_data };
                Placed { first_node: nodes[axis], first_data, first_further_data }
            }
            _ if self.is_by_axis() => Placed::default(),
            _ => {
                let first = self.before(axis);
                Placed { first_node: first, first_data: first, first_further_data: first }
            }
        })
    }

    /// Enters every buffer; `stored` are the fragments of every axis.
    pub(crate) fn enter(&self, stored: [u32; AXES], ledger: &mut Ledger) {
        let stored: [u32; AXES] = std::array::from_fn(|axis| stored[axis].min(self.capacities[axis]));
        for (buffers, each) in [(&self.nodes, NODE_BYTES), (&self.data, DATA_BYTES)] {
            for (place, (name, buffer)) in buffers.iter().enumerate() {
                let used = match buffers.len() {
                    1 => stored.iter().sum(),
                    AXES => stored[place],
                    _ => halves(stored[place / 2], self.half_nodes)[place % 2],
                };
                ledger.keep(name, buffer.size(), bytes(used, each).min(buffer.size()));
            }
        }
    }
}

/// Nodes in the first and in the second half.
fn halves(count: u32, half: u32) -> Vec<u32> {
    vec![count.min(half), count.saturating_sub(half)]
}

/// What room there is for so many, whole multiples of what bindings begin at.
fn capacities(gpu: &Gpu, needed: [u32; AXES]) -> Result<[u32; AXES], TracerError> {
    let mut capacities = [0; AXES];
    for (axis, count) in needed.into_iter().enumerate() {
        // No binding holds what does not fit the number.
        gpu.check_storage_binding(&of_axis(NODES, axis), bytes(count, NODE_BYTES), HINT)?;
        capacities[axis] = count.max(1).checked_next_multiple_of(CAPACITY_ALIGNMENT).unwrap_or(count);
    }
    Ok(capacities)
}

/// Whether the device can bind buffers of their own for every axis at once.
fn binds_every_axis(gpu: &Gpu, raster_backend: RasterBackend) -> bool {
    let traced = Trace::Split { planes: true, lifted: true, surfaces: true, counters: true }.into();
    let entries = if raster_backend == RasterBackend::Compute { &["draw"][..] } else { &["vertex", "fragment"] };
    let fills = || check_limits(gpu, Fill::Store { halves: true }.into(), entries);
    check_limits(gpu, traced, &["trace"]).and_then(|()| fills()).is_ok()
}
