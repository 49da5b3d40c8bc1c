//! The optional shadow map of the build: with one view the paper looks light up in maps in place of visibility rays (section 5.2,
//! Figure 9), which it does not describe further.
//!
//! Here it is one square view from [`Geometry::outer_light`] that holds the whole scene, as wide as the frame is on its longer edge,
//! with eye depths by the rasterizer. A ray's start is in shadow where it lies behind the map's surface by more than a bias.

use tracebench_api::glam::DVec3;
use tracebench_api::wgpu::{BindingResource, ComputePipeline};
use tracebench_api::{
    Geometry, Gpu, HitBuffer, Ledger, MemoryEntry, PhaseClock, Query, Ray, TraceJob, TraceTo, TracerError, View,
    Viewpoint,
};
use tracebench_kit::{
    EyeDepthTarget, LayerTarget, NearestLayers, NearestOf, NearestScene, ViewUniform, bind_group, compute_pipeline,
    dispatch_linear, uniform_buffer, view_uniform,
};
use tracebench_shaders::dirt::SHADOW_MAP;

use crate::description::{DirtParameters, ShadowMap as Wanted};
use crate::pipelines::Pipelines;
use crate::structure::Resident;
pub(crate) use tracebench_shaders::dirt::ShadowLookup;

/// As `WORKGROUP_SIZE` in shaders/dirt/shadow_map.wgsl.
const WORKGROUP_SIZE: u32 = 64;
/// How far from the light rays may end, scene diagonals: they are f32.
const END_SLACK: f64 = 1e-5;
/// By how much the view is larger than the sphere around the scene's bounds.
const MARGIN: f64 = 1.01;

/// The pipelines.
pub(crate) struct ShadowMapPipelines {
    depths: NearestLayers,
    look_up: ComputePipeline,
}

/// Eye depths from the light.
pub(crate) struct ShadowMap {
    pub view: View,
    target: EyeDepthTarget,
    end_slack: f64,
    /// Bytes held while it is drawn.
    drawing_bytes: u64,
}

/// What a look-up takes while it runs, by name.
pub(crate) fn lookup_memory() -> Vec<MemoryEntry> {
    let uniforms = [("light", size_of::<ViewUniform>()), ("lookup", size_of::<ShadowLookup>())];
    uniforms.map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).to_vec()
}

/// The view from the light that holds the scene; `None` of a scene without extent.
pub(crate) fn light_view(geometry: &Geometry, edge: u32) -> Option<View> {
    let eye = geometry.outer_light();
    let middle = (geometry.bounds_min.as_dvec3() + geometry.bounds_max.as_dvec3()) / 2.0;
    let (radius, distance) = (geometry.diagonal() / 2.0 * MARGIN, (middle - eye).length());
    let forward = (middle - eye).try_normalize().filter(|_| radius > 0.0)?;
    let right = forward.cross(DVec3::Z).normalize();
    // The sphere's outline.
    let tangent = radius / (distance * distance - radius * radius).sqrt();
    Some(View {
        eye,
        right,
        up: right.cross(forward),
        forward,
        tan_half_width: tangent,
        tan_half_height: tangent,
        near: distance - radius,
        far: distance + radius,
        size: [edge; 2],
    })
}

impl ShadowMapPipelines {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        Ok(Self { depths: NearestLayers::of_depths(gpu)?, look_up: compute_pipeline(gpu, SHADOW_MAP, "look_up")? })
    }

    /// Records the phase "shadow map", into the textures that are there where their size serves.
    fn record(
        &self,
        gpu: &Gpu,
        scene: NearestScene<'_>,
        end_slack: f64,
        there: Option<&ShadowMap>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<ShadowMap, TracerError> {
        let NearestScene { raster_backend, view, triangle_count, .. } = scene;
        let target = match there.filter(|there| there.view.size == view.size) {
            Some(there) => there.target.clone(),
            None => EyeDepthTarget::new(gpu, view.size)?,
        };
        let pass = self.depths.prepare(gpu, scene, None)?;
        clock.device_phase("shadow map", |encoder| {
            let layer = LayerTarget { image: &target.eye_depth, layer: 0, test: &target.test };
            self.depths.record(encoder, &pass, layer);
        })?;
        let drawing = NearestLayers::memory(NearestOf::Depths, raster_backend, view.size, triangle_count, 1);
        let drawing_bytes = drawing.iter().map(|entry| entry.allocated_bytes).sum();
        Ok(ShadowMap { view: *view, target, end_slack, drawing_bytes })
    }
}

impl ShadowMap {
    /// Whether the map answers all of a set's rays: any hit will do, no surface is asked for, and each ends at the light.
    pub(crate) fn answers(&self, job: &TraceJob<'_>) -> bool {
        let ends_at_light = |ray: &Ray| {
            let [origin, direction] = [ray.origin, ray.direction].map(|each| DVec3::from(each.map(f64::from)));
            (origin + direction * f64::from(ray.t_max)).distance(self.view.eye) <= self.end_slack
        };
        job.rays.query == Query::Any && job.trace_to == TraceTo::Hit && job.rays.host.iter().all(ends_at_light)
    }

    /// Enters the map and what is held while it is drawn.
    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        self.target.enter(ledger);
        ledger.borrow_transient(self.drawing_bytes);
    }

    /// Eye depths, row by row from the top.
    #[cfg(test)]
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, TracerError> {
        self.target.read(gpu)
    }
}

impl Pipelines {
    /// Draws the shadow map, if the parameters ask for it and the scene has an extent.
    pub(crate) fn draw_shadow_map(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &DirtParameters,
        scene: &Resident,
        there: Option<&ShadowMap>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Option<ShadowMap>, TracerError> {
        let edge = viewpoint.frame.into_iter().max().unwrap_or(1);
        let view = light_view(geometry, edge).filter(|_| parameters.shadow_map == Wanted::On);
        let Some(view) = view else { return Ok(None) };
        let end_slack = geometry.diagonal() * END_SLACK;
        let (geometry, triangle_count) = (&scene.surfaces.device, scene.triangle_count);
        let drawn = NearestScene { raster_backend: parameters.build, view: &view, geometry, triangle_count };
        self.shadow_map()?.record(&self.gpu, drawn, end_slack, there, clock).map(Some)
    }

    /// Records the phase "shadow map lookup", which answers every ray.
    pub(crate) fn look_up(
        &self,
        map: &ShadowMap,
        job: &TraceJob<'_>,
        bias_texels: f64,
        hits: &HitBuffer,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &*self.gpu;
        let count = job.rays.host.len();
        let settings = ShadowLookup { ray_count: count as u32, bias: bias_texels as f32 };
        let [light, lookup] =
            [uniform_buffer(gpu, "light", &view_uniform(&map.view))?, uniform_buffer(gpu, "lookup", &settings)?];
        let resources = [
            light.as_entire_binding(),
            lookup.as_entire_binding(),
            BindingResource::TextureView(&map.target.eye_depth),
            job.rays.on_device()?.as_entire_binding(),
            hits.on_device(count)?.as_entire_binding(),
        ];
        let pipelines = self.shadow_map()?;
        let bindings = bind_group(gpu, &pipelines.look_up.get_bind_group_layout(0), &resources);
        clock.device_phase("shadow map lookup", |encoder| {
            dispatch_linear(encoder, &pipelines.look_up, &bindings, settings.ray_count, WORKGROUP_SIZE);
        })
    }
}
