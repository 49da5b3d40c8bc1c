//! Pyramids over images of eye depth: of every cell the nearest depth below it, and the farthest one too where a search asks for it.

use tracebench_api::wgpu::{BindGroup, BindingResource, ComputePipeline};
use tracebench_api::{Gpu, Ledger, PhaseClock, TracerError};
use tracebench_shaders::shared::DepthPyramid as Variant;

use crate::eye_depth::hint;
use crate::{
    EyeDepthTarget, GrowableBuffer, MemoryAccess, NO_SURFACE, Pyramid, ReadSlot, Readable, bind_group,
    compute_pipeline, dispatch_linear, record_copies, uniform_buffer,
};
pub use tracebench_shaders::shared::PyramidLayout;
pub(crate) use tracebench_shaders::shared::PyramidLevel;

/// As `WORKGROUP_SIZE` in shaders/shared/depth_pyramid.wgsl.
const WORKGROUP_SIZE: u32 = 64;

const CELLS: &str = "depth pyramid";
const COPY: &str = "depth pyramid in a texture";
const LEVEL: &str = "pyramid level";

/// What is kept of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellDepths {
    /// The nearest depth: a word.
    Near,
    /// The nearest and the farthest one: a pair of words.
    NearFar,
    /// The same, with the pixels as the first cells: for searches that look at all levels alike.
    WithPixels,
}

/// Which images a pyramid is over, of how many pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PyramidShape {
    /// Pixels along x and y.
    pub size: [u32; 2],
    /// Images.
    pub images: u32,
    /// From this image on a pixel without a surface has no farthest depth; before it its depth is [`NO_SURFACE`].
    pub covered_from: u32,
    /// What is kept.
    pub depths: CellDepths,
}

impl PyramidShape {
    fn pyramid(&self) -> Pyramid {
        Pyramid { size: self.size }
    }

    /// Where its cells lie.
    pub fn layout(&self) -> PyramidLayout {
        let (level_offsets, cells) = self.pyramid().offsets(self.first_level(), 0);
        let levels = self.pyramid().levels() as u32;
        PyramidLayout { size: self.size, levels, cells: cells as u32, level_offsets }
    }

    /// The level that its cells begin with.
    fn first_level(&self) -> usize {
        usize::from(self.depths != CellDepths::WithPixels)
    }

    /// Cells of all images.
    pub fn cells(&self) -> u64 {
        u64::from(self.layout().cells) * u64::from(self.images)
    }

    fn words(&self) -> u64 {
        match self.depths {
            CellDepths::Near => 1,
            CellDepths::NearFar | CellDepths::WithPixels => 2,
        }
    }

    fn slot(&self) -> ReadSlot {
        match self.depths {
            CellDepths::Near => ReadSlot::Words1,
            CellDepths::NearFar | CellDepths::WithPixels => ReadSlot::Pairs0,
        }
    }

    /// The bytes of a build's uniforms, which are kept until it is done.
    pub fn build_bytes(&self) -> u64 {
        let levels = (self.pyramid().levels() - self.first_level()) as u64;
        levels * u64::from(self.images) * size_of::<PyramidLevel>() as u64
    }

    fn levels(&self) -> impl Iterator<Item = (PyramidLevel, u32)> {
        let (shape, layout) = (*self, self.layout());
        let offset = move |level: u32| layout.level_offsets[level as usize];
        (0..shape.images).flat_map(move |image| {
            (shape.first_level() as u32..layout.levels).map(move |level| {
                let first = image * layout.cells;
                let made = PyramidLevel {
                    size: shape.size,
                    level,
                    image,
                    begin: first + offset(level),
                    begin_below: first + offset(level.saturating_sub(1)),
                    covered_only: u32::from(image >= shape.covered_from),
                    padding: 0,
                };
                (made, shape.pyramid().cells(level as usize) as u32)
            })
        })
    }

    /// Near and far of every cell, straight from the pixels below it: what the device, which goes level by level, is held against.
    fn expected(&self, images: &[Vec<f32>]) -> Vec<[f32; 2]> {
        let mut cells = Vec::new();
        for (number, image) in (0..).zip(images) {
            let covered_only = number >= self.covered_from;
            for level in self.first_level()..self.pyramid().levels() {
                let [width, height] = self.pyramid().level_size(level);
                let edge = 1_usize << level;
                let [columns, rows] = self.size.map(|pixels| pixels as usize);
                for (y, x) in (0..height as usize).flat_map(|y| (0..width as usize).map(move |x| (y, x))) {
                    let mut bounds = [NO_SURFACE, 0.0];
                    for row in y * edge..((y + 1) * edge).min(rows) {
                        for depth in &image[row * columns + x * edge..row * columns + ((x + 1) * edge).min(columns)] {
                            bounds[0] = bounds[0].min(*depth);
                            if !(covered_only && *depth >= NO_SURFACE) {
                                bounds[1] = bounds[1].max(*depth);
                            }
                        }
                    }
                    cells.push(bounds);
                }
            }
        }
        cells
    }

    /// Holds cells, as the device has them, against the images.
    ///
    /// # Errors
    /// [`TracerError::Failed`] with the first that is wrong.
    fn check(&self, images: &[Vec<f32>], cells: &[f32]) -> Result<(), TracerError> {
        let expected = self.expected(images);
        let words = self.words() as usize;
        if cells.len() < expected.len() * words {
            return Err(TracerError::Failed(format!("{} words of {} cells", cells.len(), expected.len())));
        }
        let wrong = |(index, bounds): (usize, &[f32; 2])| cells[index * words..][..words] != bounds[..words];
        match expected.iter().enumerate().position(wrong) {
            None => Ok(()),
            Some(index) => Err(TracerError::Failed(format!(
                "cell {index} of the depth pyramid bounds {:?}, the pixels below it {:?}",
                &cells[index * words..][..words],
                expected[index]
            ))),
        }
    }
}

/// The pipelines that make pyramids.
#[derive(Debug)]
pub struct PyramidBuilder {
    near: ComputePipeline,
    near_far: ComputePipeline,
}

impl PyramidBuilder {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        let pipeline = |far| compute_pipeline(gpu, Variant { far }, "reduce");
        Ok(Self { near: pipeline(false)?, near_far: pipeline(true)? })
    }

    /// Records the phase "depth pyramid", and that of copying it where searches read textures.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn record(
        &self,
        gpu: &Gpu,
        target: &EyeDepthTarget,
        pyramid: &DepthPyramid,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let pipeline = match pyramid.shape.depths {
            CellDepths::Near => &self.near,
            CellDepths::NearFar | CellDepths::WithPixels => &self.near_far,
        };
        let bind = |(level, cells): (PyramidLevel, u32)| -> Result<(BindGroup, u32), TracerError> {
            let uniform = uniform_buffer(gpu, LEVEL, &level)?;
            let resources = [
                uniform.as_entire_binding(),
                BindingResource::TextureView(&target.all),
                pyramid.room.buffer.as_entire_binding(),
            ];
            Ok((bind_group(gpu, &pipeline.get_bind_group_layout(0), &resources), cells))
        };
        let levels = pyramid.shape.levels().map(bind).collect::<Result<Vec<_>, _>>()?;
        clock.device_phase(CELLS, |encoder| {
            for (bindings, cells) in &levels {
                dispatch_linear(encoder, pipeline, bindings, *cells, WORKGROUP_SIZE);
            }
        })?;
        record_copies(std::slice::from_ref(&pyramid.array), clock)
    }
}

/// The cells of a pyramid.
#[derive(Clone, Debug)]
pub struct DepthPyramid {
    shape: PyramidShape,
    room: GrowableBuffer,
    array: Readable,
}

impl DepthPyramid {
    /// Room for one. Searches read it as pairs 0 or, of near depths alone, words 1.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits.
    pub fn new(gpu: &Gpu, shape: PyramidShape, memory_access: MemoryAccess) -> Result<Self, TracerError> {
        // A frame of one pixel has no cells above it, and a buffer cannot be empty.
        let bytes = shape.cells().max(1) * shape.words() * 4;
        let hint = hint(shape.images);
        let room = GrowableBuffer::new(gpu, CELLS, bytes, hint, None)?;
        let array = Readable::built(gpu, memory_access, shape.slot(), &room.buffer, bytes, COPY, None, hint)?;
        Ok(Self { shape, room, array })
    }

    /// What it is over.
    pub fn shape(&self) -> PyramidShape {
        self.shape
    }

    /// What searches read.
    pub fn array(&self) -> &Readable {
        &self.array
    }

    /// Enters what it takes.
    pub fn enter(&self, ledger: &mut Ledger) {
        self.room.enter(ledger);
        self.array.enter(ledger);
    }

    /// Reads what searches read back and holds it against the images.
    ///
    /// # Errors
    /// [`TracerError::Failed`] with the first cell that is wrong, or if the device fails.
    pub fn validate(&self, gpu: &Gpu, images: &[Vec<f32>]) -> Result<(), TracerError> {
        self.shape.check(images, &bytemuck::pod_collect_to_vec(&self.array.read(gpu)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LayerTarget, NearestLayers, NearestScene, RasterBackend};
    use tracebench_api::glam::DVec3;
    use tracebench_api::{AdapterChoice, Geometry, View};

    fn numbers(count: usize) -> Vec<f32> {
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let share = (state >> 40) as f32 / (1_u64 << 24) as f32;
            if share < 0.2 { NO_SURFACE } else { 0.5 + 20.0 * share }
        };
        (0..count).map(|_| next()).collect()
    }

    fn shape(size: [u32; 2], depths: CellDepths) -> PyramidShape {
        PyramidShape { size, images: 2, covered_from: 1, depths }
    }

    fn words(shape: &PyramidShape, bounds: &[[f32; 2]]) -> Vec<f32> {
        bounds.iter().flat_map(|bounds| bounds[..shape.words() as usize].to_vec()).collect()
    }

    /// Cells bound the pixels below them and nothing else: by hand on three by two pixels, once with pixels that have no surface and
    /// once without; places follow one another, image after image.
    #[test]
    fn cells_bound_their_pixels() {
        let shape = shape([3, 2], CellDepths::NearFar);
        let image = vec![4.0, 2.0, NO_SURFACE, 3.0, 5.0, 7.0];
        let found = shape.expected(&[image.clone(), image]);
        assert_eq!(found[..3], [[2.0, 5.0], [7.0, NO_SURFACE], [2.0, NO_SURFACE]]);
        assert_eq!(found[3..], [[2.0, 5.0], [7.0, 7.0], [2.0, 7.0]]);
        let layout = shape.layout();
        assert_eq!((layout.levels, layout.cells, &layout.level_offsets[..4]), (3, 3, &[0, 0, 2, 0][..]));
        assert_eq!((shape.cells(), shape.build_bytes()), (6, 4 * 32));
        let levels: Vec<_> = shape.levels().map(|(made, cells)| (made.image, made.level, made.begin, cells)).collect();
        assert_eq!(levels, [(0, 1, 0, 2), (0, 2, 2, 1), (1, 1, 3, 2), (1, 2, 5, 1)]);
    }

    /// Negative control: a cell that is nearer, farther or another's is noticed wherever it lies, of both kinds, and so is one that is
    /// missing.
    #[test]
    fn wrong_cells_are_noticed() {
        for depths in [CellDepths::Near, CellDepths::NearFar] {
            let shape = shape([13, 5], depths);
            let images = [numbers(65), numbers(65).into_iter().rev().collect()];
            let right = words(&shape, &shape.expected(&images));
            shape.check(&images, &right).unwrap();
            for index in 0..right.len() {
                for change in [0.999, 1.001] {
                    let mut wrong = right.clone();
                    wrong[index] *= change;
                    assert!(shape.check(&images, &wrong).is_err() || right[index] == 0.0, "{index}");
                }
            }
            assert!(shape.check(&images, &right[1..]).is_err());
            let mut swapped = right.clone();
            swapped.rotate_left(1);
            assert!(shape.check(&images, &swapped).is_err());
        }
    }

    /// Proves that the device makes the cells of odd frames, of a row and of a single pixel, read from buffers and textures, over
    /// what is nearest of some triangles and what lies behind it; and that other depths are noticed.
    #[test]
    fn the_device_makes_the_same_cells() {
        let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
        let layers = NearestLayers::of_depths(&gpu).unwrap();
        let builder = PyramidBuilder::new(&gpu).unwrap();
        let places = numbers(360);
        let corner = |three: &[f32]| [three[0] % 1.0 * 8.0 - 4.0, three[1] % 1.0 * 8.0 - 4.0, -2.0 - three[2] % 7.0];
        let positions: Vec<[f32; 3]> = places.chunks_exact(3).map(corner).collect();
        let triangles: Vec<[u32; 3]> = (0..40).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect();
        let geometry = Geometry::new(positions, triangles, Some(&gpu)).unwrap();
        let images = [
            ([13, 5], RasterBackend::Raster),
            ([64, 64], RasterBackend::Compute),
            ([37, 1], RasterBackend::Compute),
            ([1, 1], RasterBackend::Raster),
        ];
        for (size, raster_backend) in images {
            let view = View {
                eye: DVec3::ZERO,
                right: DVec3::X,
                up: DVec3::Y,
                forward: DVec3::NEG_Z,
                tan_half_width: 1.0,
                tan_half_height: 1.0,
                near: 0.1,
                far: 100.0,
                size,
            };
            let target = EyeDepthTarget::of_images(&gpu, size, 2).unwrap();
            let geometry = geometry.on_device().unwrap();
            let scene = NearestScene { raster_backend, view: &view, geometry, triangle_count: 40 };
            let passed = [None, Some((&target.images[0], crate::behind(0.0)))];
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            for ((layer, image), passed) in (0..).zip(&target.images).zip(passed) {
                let pass = layers.prepare(&gpu, scene, passed).unwrap();
                layers.record(&mut encoder, &pass, LayerTarget { image, layer, test: &target.test });
            }
            gpu.queue.submit([encoder.finish()]);
            let images = [0, 1].map(|image| target.read_image(&gpu, image).unwrap());
            assert!(images[0].iter().zip(&images[1]).all(|(first, second)| first < second || *second == NO_SURFACE));
            let covered = images.each_ref().map(|image| image.iter().filter(|depth| **depth < NO_SURFACE).count());
            assert!(covered[0] > 0 && (covered[1] > 100 || size != [64, 64]), "{covered:?}");
            let all = [CellDepths::Near, CellDepths::NearFar, CellDepths::WithPixels];
            for (depths, memory_access) in all.into_iter().flat_map(|depths| {
                [MemoryAccess::Buffer, MemoryAccess::Texture].map(|memory_access| (depths, memory_access))
            }) {
                let pyramid = DepthPyramid::new(&gpu, shape(size, depths), memory_access).unwrap();
                let mut clock = PhaseClock::new(Some(&gpu));
                builder.record(&gpu, &target, &pyramid, &mut clock).unwrap();
                clock.finish().unwrap();
                pyramid.validate(&gpu, &images).unwrap();
                let farther: Vec<Vec<f32>> =
                    images.iter().map(|image| image.iter().map(|depth| depth * 1.5).collect()).collect();
                assert_eq!(pyramid.validate(&gpu, &farther).is_err(), pyramid.shape().cells() > 0);
            }
        }
    }
}
