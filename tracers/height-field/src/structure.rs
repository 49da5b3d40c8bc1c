//! The tracer and its structure.

use std::cell::RefCell;
use std::sync::Arc;

use tracebench_api::{
    Counter, EndPoint, Geometry, Gpu, HitBuffer, ImageMarch, Layers, Ledger, MarchSteps, MemoryEntry, MemoryReport,
    Parameters, PhaseClock, Projection, Sampling, Structure, TraceJob, Tracer, TracerError, Update, View, Viewpoint,
};
use tracebench_kit::{
    CellDepths, DepthCopy, DepthPyramid, DrawnBy, EyeDepthTarget, LayerTarget, NO_SURFACE, NearestLayers, NearestOf,
    NearestScene, PipelinesOnDemand, PyramidBuilder, PyramidShape, Reads, SeenRaster, SurfaceGeometry,
};
use tracebench_shaders::height_field::Trace;

use crate::description::{HeightParameters, NO_REFIT, Pyramid};

/// The pipelines.
pub(crate) struct Pipelines {
    pub gpu: Arc<Gpu>,
    layers: NearestLayers,
    pyramids: PyramidBuilder,
    /// The triangles at the view's pixels, for surfaces.
    pub seen: SeenRaster,
    pub trace: PipelinesOnDemand<Trace>,
}

/// The tracer.
pub struct HeightField {
    pipelines: Arc<Pipelines>,
}

impl HeightField {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        let pipelines = Pipelines {
            layers: NearestLayers::of_depths(&gpu)?,
            pyramids: PyramidBuilder::new(&gpu)?,
            seen: SeenRaster::new(&gpu)?,
            trace: PipelinesOnDemand::new("trace"),
            gpu,
        };
        Ok(Self { pipelines: Arc::new(pipelines) })
    }
}

/// The depth buffer of one view with its pyramid.
pub(crate) struct Heights {
    pub target: EyeDepthTarget,
    /// The eye depths in a buffer, where searches read one.
    pub copy: Option<DepthCopy>,
    pub pyramid: DepthPyramid,
}

impl Heights {
    fn new(gpu: &Gpu, size: [u32; 2], depths: CellDepths, reads: Reads) -> Result<Self, TracerError> {
        let target = EyeDepthTarget::new(gpu, size)?;
        let copy = (reads == Reads::Buffer).then(|| DepthCopy::new(gpu, size, 1)).transpose()?;
        // A pixel without a surface bounds its cells: nothing in it is solid.
        let shape = PyramidShape { size, images: 1, covered_from: 1, depths };
        Ok(Self { target, copy, pyramid: DepthPyramid::new(gpu, shape, reads)? })
    }

    /// Enters all, with what drawing so many triangles takes.
    fn enter(&self, drawn_by: DrawnBy, triangle_count: u32, ledger: &mut Ledger) {
        self.target.enter(ledger);
        if let Some(copy) = &self.copy {
            copy.enter(ledger);
        }
        self.pyramid.enter(ledger);
        // While the depth buffer is drawn and the pyramid made.
        let size = self.pyramid.shape().size;
        let drawing = NearestLayers::memory(NearestOf::Depths, drawn_by, size, triangle_count, 1);
        let of_layer: u64 = drawing.iter().map(|entry| entry.allocated_bytes).sum();
        ledger.borrow_transient(of_layer + self.pyramid.shape().build_bytes());
    }
}

impl Pipelines {
    fn draw(
        &self,
        geometry: &Geometry,
        view: &View,
        drawn_by: DrawnBy,
        heights: &Heights,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let (device, triangle_count) = (geometry.on_device()?, geometry.triangles.len() as u32);
        let scene = NearestScene { drawn_by, view, geometry: device, triangle_count };
        let pass = self.layers.prepare(&self.gpu, scene, None)?;
        let EyeDepthTarget { eye_depth, test, .. } = &heights.target;
        clock.device_phase("rasterize depth buffer", |encoder| {
            self.layers.record(encoder, &pass, LayerTarget { image: eye_depth, layer: 0, test });
        })?;
        if let Some(copy) = &heights.copy {
            clock.device_phase("copy to a buffer", |encoder| copy.record(encoder, &heights.target))?;
        }
        self.pyramids.record(&self.gpu, &heights.target, &heights.pyramid, clock)
    }
}

/// What is built of one view.
pub(crate) struct HeightFieldStructure {
    pub pipelines: Arc<Pipelines>,
    pub view: View,
    pub heights: Heights,
    reads: Reads,
    pub drawn_by: DrawnBy,
    pub geometry: SurfaceGeometry,
    pub triangle_count: u32,
    /// What the last texture of triangles took.
    pub primitive_texture: RefCell<Option<MemoryEntry>>,
}

impl Tracer for HeightField {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        let HeightParameters { pyramid, reads, build: drawn_by, .. } = HeightParameters::try_from(parameters)?;
        let depths = match pyramid {
            Pyramid::MinMax => CellDepths::NearFar,
            Pyramid::Max => CellDepths::Near,
        };
        let view = viewpoint.frame_view();
        let heights = Heights::new(&self.pipelines.gpu, view.size, depths, reads)?;
        self.pipelines.draw(geometry, &view, drawn_by, &heights, clock)?;
        Ok(Box::new(HeightFieldStructure {
            pipelines: Arc::clone(&self.pipelines),
            view,
            heights,
            reads,
            drawn_by,
            geometry: SurfaceGeometry::of(geometry)?,
            triangle_count: geometry.triangles.len() as u32,
            primitive_texture: RefCell::new(None),
        }))
    }
}

impl Structure for HeightFieldStructure {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        _parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        match update {
            Update::Rebuild => {
                let view = viewpoint.frame_view();
                let surfaces = SurfaceGeometry::of(geometry)?;
                let pipelines = Arc::clone(&self.pipelines);
                // A frame of the same size is drawn into the textures that are there.
                if view.size == self.view.size {
                    pipelines.draw(geometry, &view, self.drawn_by, &self.heights, clock)?;
                } else {
                    let depths = self.heights.pyramid.shape().depths;
                    let heights = Heights::new(&pipelines.gpu, view.size, depths, self.reads)?;
                    pipelines.draw(geometry, &view, self.drawn_by, &heights, clock)?;
                    self.heights = heights;
                }
                self.view = view;
                (self.geometry, self.triangle_count) = (surfaces, geometry.triangles.len() as u32);
                Ok(())
            }
            Update::Refit => Err(TracerError::Unsupported(NO_REFIT.to_owned())),
            Update::Reuse => Ok(()),
        }
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        // Any hit is the same search: its first hit is its nearest.
        self.record(&job, hits, None, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.count(&job, hits)
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        self.heights.enter(self.drawn_by, self.triangle_count, &mut ledger);
        ledger.report(0).with_surface_geometry(self.geometry.bytes)
    }

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let mut parts = Self::uniforms();
        if job.end == EndPoint::Surface {
            let last = self.primitive_texture.borrow().clone();
            let (triangles, rays) = (self.triangle_count, job.rays.host.len());
            parts.extend(SeenRaster::memory(self.drawn_by, self.view.size, triangles, 1, rays, last));
        }
        Ok(parts)
    }

    fn samplings(&self, parameters: &Parameters) -> Result<Vec<Sampling>, TracerError> {
        let HeightParameters { start_bias, refinement, .. } = HeightParameters::try_from(parameters)?;
        let march = Some(ImageMarch {
            steps: MarchSteps::EveryPixel,
            start_bias,
            // All behind a sample is solid.
            thickness: f64::INFINITY,
            thickness_in_pixels: 0.0,
            to_back_faces: false,
            // Few halvings leave it open where in its pixel a hit is.
            anywhere: refinement < 16,
        });
        Ok(vec![Sampling { march, ..Sampling::new(Projection::Perspective(self.view), Layers::Nearest) }])
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let gpu = &self.pipelines.gpu;
        let depths = self.heights.target.read(gpu)?;
        check_depths(&depths, &self.view)?;
        let covered = depths.iter().filter(|depth| **depth != NO_SURFACE).count();
        let pixels = depths.len();
        self.heights.pyramid.validate(gpu, &[depths])?;
        let cells = self.heights.pyramid.shape().cells() as f64 + pixels as f64;
        Ok(vec![("pixels", pixels as f64), ("covered_pixels", covered as f64), ("cells", cells)])
    }
}

/// Holds eye depths against near and far.
fn check_depths(depths: &[f32], view: &View) -> Result<(), TracerError> {
    // Depth is computed in f32, so a surface at near or far may be stored a little beyond it.
    let (near, far) = (view.near * (1.0 - 1e-4), view.far * (1.0 + 1e-4));
    let outside = |depth: &&f32| **depth != NO_SURFACE && !(near..=far).contains(&f64::from(**depth));
    match depths.iter().find(outside) {
        Some(depth) => Err(TracerError::Failed(format!("an eye depth of {depth} lies outside of {near} to {far}"))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracebench_api::glam::DVec3;

    /// Negative control: a depth before near, one beyond far and one that is no number are noticed; those at near and far, and
    /// pixels without a surface, are right.
    #[test]
    fn wrong_depths_are_noticed() {
        let view = View {
            eye: DVec3::ZERO,
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::NEG_Z,
            tan_half_width: 1.0,
            tan_half_height: 1.0,
            near: 0.1,
            far: 100.0,
            size: [2, 1],
        };
        let wrong = |depth: f32| check_depths(&[1.0, depth], &view).is_err();
        assert_eq!([0.1, 7.0, 100.0, NO_SURFACE].map(wrong), [false; 4]);
        assert_eq!([0.09, 101.0, -1.0, 0.0, f32::NAN].map(wrong), [true; 5]);
    }
}
