//! The tracer and its structure.

use std::cell::RefCell;
use std::sync::Arc;

use tracebench_api::{
    Counter, EndPoint, Geometry, Gpu, HitBuffer, ImageMarch, Layers, Ledger, MarchSteps, MemoryEntry, MemoryReport,
    Parameters, PhaseClock, Projection, Sampling, Structure, TraceJob, Tracer, TracerError, Update, View, Viewpoint,
};
use tracebench_kit::{PipelinesOnDemand, SeenRaster, SurfaceGeometry};
use tracebench_shaders::screen_dda::Trace;

use crate::description::{DdaParameters, HitPoint, NO_REFIT};
use crate::images::{ImagePipelines, ImageShape, Images};

/// The pipelines.
pub(crate) struct Pipelines {
    pub gpu: Arc<Gpu>,
    images: ImagePipelines,
    /// The triangles at the view's pixels, for surfaces.
    pub seen: SeenRaster,
    pub trace: PipelinesOnDemand<Trace>,
}

/// The tracer.
pub struct ScreenDda {
    pipelines: Arc<Pipelines>,
}

impl ScreenDda {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        let pipelines = Pipelines {
            images: ImagePipelines::new(&gpu)?,
            seen: SeenRaster::new(&gpu)?,
            trace: PipelinesOnDemand::new("trace"),
            gpu,
        };
        Ok(Self { pipelines: Arc::new(pipelines) })
    }
}

/// The depth layers of one view.
pub(crate) struct ScreenDdaStructure {
    pub pipelines: Arc<Pipelines>,
    pub view: View,
    pub images: Images,
    pub diagonal: f64,
    pub geometry: SurfaceGeometry,
    pub triangle_count: u32,
    /// What the last texture of triangles took.
    pub primitive_texture: RefCell<Option<MemoryEntry>>,
}

impl Tracer for ScreenDda {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        let view = viewpoint.frame_view();
        let images = Images::new(&self.pipelines.gpu, ImageShape::of(&view, parameters)?)?;
        self.pipelines.images.draw(geometry, &view, &images, clock)?;
        Ok(Box::new(ScreenDdaStructure {
            pipelines: Arc::clone(&self.pipelines),
            view,
            images,
            diagonal: geometry.diagonal(),
            geometry: SurfaceGeometry::of(geometry)?,
            triangle_count: geometry.triangles.len() as u32,
            primitive_texture: RefCell::new(None),
        }))
    }
}

impl Structure for ScreenDdaStructure {
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
                    pipelines.images.draw(geometry, &view, &self.images, clock)?;
                } else {
                    let shape = ImageShape { size: view.size, ..self.images.shape };
                    let images = Images::new(&pipelines.gpu, shape)?;
                    pipelines.images.draw(geometry, &view, &images, clock)?;
                    self.images = images;
                }
                (self.view, self.diagonal) = (view, geometry.diagonal());
                (self.geometry, self.triangle_count) = (surfaces, geometry.triangles.len() as u32);
                Ok(())
            }
            Update::Refit => Err(TracerError::Unsupported(NO_REFIT.to_owned())),
            Update::Reuse => Ok(()),
        }
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        // Any hit is the same walk: its first hit is its nearest.
        self.record(&job, hits, None, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.count(&job, hits)
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        self.images.enter(self.triangle_count, &mut ledger);
        ledger.report(0).with_surface_geometry(self.geometry.bytes)
    }

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let mut parts = self.uniforms();
        if job.end == EndPoint::Surface {
            let last = self.primitive_texture.borrow().clone();
            let ImageShape { drawn_by, layers, .. } = self.images.shape;
            let (triangles, rays) = (self.triangle_count, job.rays.host.len());
            parts.extend(SeenRaster::memory(drawn_by, self.view.size, triangles, layers, rays, last));
        }
        Ok(parts)
    }

    fn samplings(&self, parameters: &Parameters) -> Result<Vec<Sampling>, TracerError> {
        let DdaParameters { stride, thickness, start_bias, hit_point, .. } = DdaParameters::try_from(parameters)?;
        let shape = &self.images.shape;
        let march = Some(ImageMarch {
            steps: MarchSteps::Stride(f64::from(stride)),
            start_bias,
            thickness: thickness * self.diagonal,
            thickness_in_pixels: 0.0,
            to_back_faces: shape.backs,
            anywhere: hit_point == HitPoint::Step,
        });
        let layers = Layers::of(shape.layers, shape.separation * self.diagonal, true);
        Ok(vec![Sampling { march, ..Sampling::new(Projection::Perspective(self.view), layers) }])
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let covered = self.images.validate(&self.pipelines.gpu, &self.view, self.diagonal)?;
        let layers = self.images.shape.layers as usize;
        let pixels: u64 = self.view.size.map(u64::from).iter().product();
        let mut told = vec![("pixels", pixels as f64), ("covered_pixels", covered[0] as f64)];
        let deeper = ["covered_pixels_of_layer_2", "covered_pixels_of_layer_3", "covered_pixels_of_layer_4"];
        told.extend(deeper.into_iter().zip(&covered[1..layers]).map(|(name, count)| (name, *count as f64)));
        if self.images.shape.backs {
            told.push(("pixels_with_back_faces", covered[layers] as f64));
        }
        if let Some(pyramid) = &self.images.pyramid {
            told.push(("pyramid_cells", pyramid.shape().cells() as f64));
        }
        Ok(told)
    }
}
