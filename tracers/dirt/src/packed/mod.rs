//! The packed forms of DIRT (`lists` other than `linked`), which are exact: made in compute, without views' near planes.
//!
//! Deviations from the paper, each of which parameters tell from the others:
//! - Six faces lie round the eye itself, and hold all that is not nearer than 2^-13 of a triangle's own size; what is nearer is listed
//!   apart and tested for rays that pass that near.
//! - Triangles are clipped to tiles in compute. The bounds of what is stored contain all that rounding may do, as
//!   shaders/dirt/parts.wgsl argues; that is checked by `validate` in f64.
//! - In the place of depth bounds and buckets a tile has a mask of up to 64 depth slices, which follow the logarithm of the depths that
//!   there are, and a pyramid of such masks.
//! - Parts stand in a row: a tile's (`packed`), those of every slice (`slices`, the paper's buckets without empty ones), or as the leaves
//!   of a tree of eight children a node in every tile (`trees`).

mod buffers;
mod build;
pub(crate) mod kernels;
pub(crate) mod layout;
mod parts;
mod trace;
mod validate;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod trace_tests;

use std::sync::Arc;

use tracebench_api::{
    Geometry, Layers, Ledger, MemoryEntry, MemoryReport, Parameters, PhaseClock, Projection, SampledImage, TraceJob,
    TraceTo, TracerError, View,
};
use tracebench_kit::{BuildJob, DeviceStructure, Gather, MemoryAccess, Readable, record_copies, untimed};

use self::buffers::BuildBuffers;
use self::build::{Extent, Work};
use self::layout::PackedLayout;
use crate::description::{DirtParameters, NO_REFIT};
use crate::layout::NO_NEAR;
use crate::pipelines::Pipelines;
use crate::shadow_map::{ShadowMap, lookup_memory};
use crate::structure::Resident;
use crate::visibility::Frame;

/// Tiles with their parts.
pub(crate) struct PackedStructure {
    pub(crate) pipelines: Arc<Pipelines>,
    pub(crate) layout: PackedLayout,
    pub(crate) geometry: Resident,
    buffers: BuildBuffers,
    /// What searches read, in buffers or textures.
    arrays: Vec<Readable>,
    /// What the camera's frame shows, if that was asked for.
    frame: Option<Frame>,
    /// What the light sees, if that was asked for.
    shadow_map: Option<ShadowMap>,
}

impl Pipelines {
    /// Builds into rooms.
    fn build_packed(
        &self,
        layout: &PackedLayout,
        buffers: &BuildBuffers,
        scene: &Resident,
        extent: Extent,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &*self.gpu;
        let (kernels, sorts) = (self.packed.build(gpu, layout.lists)?, self.packed.sort(gpu)?);
        let work = Work { layout, buffers, scene: &scene.surfaces.device };
        build::record(gpu, work, &kernels, &sorts, extent, clock)
    }

    /// Rooms for a scene: counted by builds that are no phases of the first one, of parts alone, then of nodes.
    fn packed_rooms(&self, layout: &PackedLayout, scene: &Resident) -> Result<BuildBuffers, TracerError> {
        let gpu = &*self.gpu;
        let sorts = self.packed.sort(gpu)?;
        let sorting = sorts.sorting();
        let room = |capacities| BuildBuffers::new(gpu, &sorting, layout, scene.triangle_count, capacities, None);
        let built = |buffers: &BuildBuffers, extent| {
            untimed(gpu, |clock| self.build_packed(layout, buffers, scene, extent, clock))?;
            buffers.needed(gpu)
        };
        let [parts, _] = built(&room([1, 1])?, Extent::Counted)?;
        let [_, nodes] = built(&room([parts, 1])?, Extent::Whole)?;
        room([parts, nodes])
    }
}

impl PackedStructure {
    fn memory_access(&self) -> MemoryAccess {
        self.arrays[0].memory_access()
    }
}

impl DeviceStructure for PackedStructure {
    type Pipelines = Pipelines;

    const NO_REFIT: &'static str = NO_REFIT;

    fn build(pipelines: &Arc<Pipelines>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, viewpoint, parameters, before, clock } = job;
        let parameters = &DirtParameters::try_from(parameters)?;
        let (layout, scene) = (PackedLayout::new(viewpoint, parameters), Resident::of(geometry)?);
        let gpu = &*pipelines.gpu;
        let buffers = match before.map(|before| (&before.buffers, &before.layout)) {
            None => pipelines.packed_rooms(&layout, &scene)?,
            Some((there, of)) if layout.is_shaped_like(of) && scene.triangle_count == there.triangle_count => {
                there.clone()
            }
            Some((there, of)) => {
                let (sorts, capacities) = (pipelines.packed.sort(gpu)?, there.capacities);
                let there = (layout.lists == of.lists).then_some(there);
                BuildBuffers::new(gpu, &sorts.sorting(), &layout, scene.triangle_count, capacities, there)?
            }
        };
        let there = before.map_or(&[][..], |before| &before.arrays);
        let arrays = buffers.arrays(gpu, &layout, parameters.memory_access, there)?;
        pipelines.build_packed(&layout, &buffers, &scene, Extent::Whole, clock)?;
        record_copies(&arrays, clock)?;
        let frame = before.and_then(|before| before.frame.as_ref());
        let frame = pipelines.show(viewpoint, parameters, &scene, frame, clock)?;
        let shadow_map = before.and_then(|before| before.shadow_map.as_ref());
        let shadow_map = pipelines.draw_shadow_map(geometry, viewpoint, parameters, &scene, shadow_map, clock)?;
        Ok(Self { pipelines: Arc::clone(pipelines), layout, geometry: scene, buffers, arrays, frame, shadow_map })
    }

    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        let pipelines = Arc::clone(&self.pipelines);
        let gpu = &*pipelines.gpu;
        let mut needed = self.buffers.needed(gpu)?;
        if self.buffers.capacities.iter().zip(&needed).all(|(room, needed)| room >= needed) {
            return Ok(false);
        }
        let sorts = pipelines.packed.sort(gpu)?;
        if needed[0] > self.buffers.capacities[0] {
            // Parts that were not stored have no nodes yet.
            let capacities = [needed[0], self.buffers.capacities[1]];
            let buffers = self.buffers.grown(gpu, &sorts.sorting(), &self.layout, capacities)?;
            let (layout, scene) = (&self.layout, &self.geometry);
            untimed(gpu, |clock| pipelines.build_packed(layout, &buffers, scene, Extent::Whole, clock))?;
            needed = buffers.needed(gpu)?;
            self.buffers = buffers;
        }
        self.buffers = self.buffers.grown(gpu, &sorts.sorting(), &self.layout, needed)?;
        self.arrays = self.buffers.arrays(gpu, &self.layout, self.memory_access(), &self.arrays)?;
        Ok(true)
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        let used = self.buffers.needed(&self.pipelines.gpu).unwrap_or(self.buffers.capacities);
        self.buffers.enter(&self.layout, used, &mut ledger);
        self.arrays.iter().for_each(|array| array.enter(&mut ledger));
        ledger.borrow_transient(build::uniform_bytes(&self.layout));
        if let Some(frame) = &self.frame {
            frame.enter(&mut ledger);
        }
        if let Some(map) = &self.shadow_map {
            map.enter(&mut ledger);
        }
        ledger.report(0).with_surface_geometry(self.geometry.surfaces.bytes)
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        DirtParameters::try_from(job.parameters)?;
        if self.shadow_map.as_ref().is_some_and(|map| map.answers(job)) {
            return Ok(lookup_memory());
        }
        let mut parts = trace::memory();
        if job.trace_to == TraceTo::Surface {
            parts.push(Gather::memory());
        }
        Ok(parts)
    }

    fn samplings(&self, _parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        let views = self.layout.viewpoint.face_views(0.0);
        let of = |view: View| {
            // All that is not in the eye is seen.
            let view = View { near: view.far * NO_NEAR, ..view };
            SampledImage::new(Projection::Perspective(view), Layers::All)
        };
        Ok(views.map(of).to_vec())
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.check(geometry)
    }
}
