//! The contract of tracebench: what a ray tracer is given, what it must answer, and how it is timed and weighed.
//!
//! A contender implements [`Tracer`] (pipelines, parameters) and [`Structure`] (what it built for one scene and one
//! [`Viewpoint`]). It gets triangles as [`Geometry`], rays as a [`RayBuffer`], and writes a [`HitBuffer`]. Times are
//! taken by a [`PhaseClock`] that the harness hands in; memory is told by a [`MemoryReport`].
//!
//! Space: right-handed, y up by custom; `t` and all lengths in scene units; eye depth is linear and positive in front
//! of the eye.

mod adapter;
mod allocations;
mod clock;
mod declared;
mod error;
mod geometry;
mod gpu;
mod memory;
mod parameters;
mod rasterizer;
mod ray;
mod sampling;
mod tracer;
mod transfer;
mod viewpoint;

pub use adapter::{AdapterChoice, AdapterInfo, DeviceLimits, list_adapters};
pub use allocations::Allocations;
pub use clock::{ClockKind, PhaseClock, PhaseSample, Timing, tick_ms};
pub use declared::{Choice, Parameter, ParameterType};
pub use error::TracerError;
pub use geometry::{DeviceGeometry, Geometry};
pub use gpu::Gpu;
pub use memory::{Ledger, MemoryEntry, MemoryReport};
pub use parameters::{Domain, ParameterDescription, ParameterError, ParameterScope, Parameters, Preset, Value};
pub use rasterizer::Rasterizer;
pub use ray::{Hit, NO_PRIMITIVE, Query, Ray, Status, Surface, SurfaceStatus, TraceTo};
pub use sampling::{
    ImageChoice, ImageMarch, Layers, LineOfSight, MarchSteps, Orthographic, Projection, SampledImage, VoxelGrid,
};
pub use tracer::{Counter, Invalidation, Residency, Structure, TraceJob, Tracer, TracerDescription, Update};
pub use transfer::{HitBuffer, RayBuffer};
pub use viewpoint::{Projected, View, Viewpoint};

// Re-exported so that every tracer and the harness speak of the same version.
pub use glam;
pub use wgpu;
