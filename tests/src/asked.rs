//! A structure asked for answers, and its tracer's parameters and device, as the tracers' own tests set them.

use std::sync::Arc;

use tracebench_api::{
    AdapterChoice, Counter, Gpu, Hit, HitBuffer, ParameterDescription, Parameters, PhaseClock, Preset, Query, Ray,
    RayBuffer, Residency, Structure, Surface, TraceJob, TraceTo, TracerError,
};

/// The published parameters with some set.
///
/// # Panics
/// If one is not there or refuses its value.
pub fn parameters(described: &[ParameterDescription], settings: &[(&str, &str)]) -> Parameters {
    let mut parameters = Parameters::preset(described, Preset::Published);
    for (name, value) in settings {
        if let Err(error) = parameters.set(described, name, value) {
            panic!("{name}={value}: {error}");
        }
    }
    parameters
}

/// A device of its own that binds no more bytes at once.
///
/// # Panics
/// Without an adapter.
pub fn gpu_that_binds(bytes: u64) -> Arc<Gpu> {
    let mut gpu = Gpu::open(&AdapterChoice::default()).unwrap_or_else(|error| panic!("{error}"));
    gpu.limits.max_storage_buffer_binding_size = bytes;
    Arc::new(gpu)
}

/// Hits and, where they are asked for, surfaces, of a structure on a device.
///
/// # Panics
/// If it refuses.
pub fn answers(
    gpu: &Gpu,
    structure: &dyn Structure,
    rays: &[Ray],
    query: Query,
    parameters: &Parameters,
    trace_to: TraceTo,
) -> (Vec<Hit>, Vec<Surface>) {
    let trace = |job: TraceJob<'_>, hits: &mut HitBuffer| {
        let mut clock = PhaseClock::new(Some(gpu));
        structure.trace(job, hits, &mut clock)?;
        clock.finish().map(drop)
    };
    let (hits, surfaces, ()) = asked(gpu, rays, query, parameters, trace_to, trace);
    (hits, surfaces)
}

fn asked<T>(
    gpu: &Gpu,
    rays: &[Ray],
    query: Query,
    parameters: &Parameters,
    trace_to: TraceTo,
    trace: impl FnOnce(TraceJob<'_>, &mut HitBuffer) -> Result<T, TracerError>,
) -> (Vec<Hit>, Vec<Surface>, T) {
    let asked = || {
        let rays = RayBuffer::new(Arc::new(rays.to_vec()), query, Some(gpu));
        let mut hits = HitBuffer::tracing_to(trace_to, rays.host.len(), Residency::Device, Some(gpu))?;
        hits.poison(Some(gpu))?;
        let told = trace(TraceJob { rays: &rays, trace_to, parameters }, &mut hits)?;
        let surfaces = if trace_to == TraceTo::Surface { hits.read_surfaces(Some(gpu))? } else { Vec::new() };
        Ok((hits.read(Some(gpu))?, surfaces, told))
    };
    asked().unwrap_or_else(|error: TracerError| panic!("{error}"))
}

/// The same and counters, by the variant that counts.
///
/// # Panics
/// If it refuses.
pub fn counted(
    gpu: &Gpu,
    structure: &dyn Structure,
    rays: &[Ray],
    query: Query,
    parameters: &Parameters,
    trace_to: TraceTo,
) -> (Vec<Hit>, Vec<Surface>, Vec<Counter>) {
    asked(gpu, rays, query, parameters, trace_to, |job, hits| structure.trace_counted(job, hits))
}

/// What a counter counted of all rays.
///
/// # Panics
/// If there is no such counter.
pub fn total(counters: &[Counter], name: &str) -> u64 {
    counters.iter().find(|counter| counter.name == name).unwrap_or_else(|| panic!("{name} is not counted")).total
}
