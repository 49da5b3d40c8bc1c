//! Images: linear and as they are shown, and what one is like beside its reference.

use image_compare::prelude::GrayImage;
use image_compare::{Algorithm, gray_similarity_structure};
use nv_flip::{FlipImageFloat, FlipImageRgb8};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Effect, Rgb};
use crate::results::ImageRow;

/// How finely FLIP's observer sees: pixels a degree of view, as of a 4K screen of 0.7 m at 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = 67.0;

/// Why an image is not compared or written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImageError {
    /// Images of different sizes.
    #[error("an image of {} x {} pixels cannot stand beside one of {} x {}", .0[0], .0[1], .1[0], .1[1])]
    Size([u32; 2], [u32; 2]),
    /// No image, or one without pixels.
    #[error("there is no image")]
    Empty,
    /// The encoder or the comparison failed.
    #[error("cannot make or compare the image: {0}")]
    Failed(String),
}

/// An image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image<P> {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Row by row from the top.
    pub pixels: Vec<P>,
}

/// Radiances: linear red, green and blue.
pub type LinearImage = Image<[f32; 3]>;

/// An image as it is shown: sRGB, 8 bits a channel.
pub type Image8 = Image<Rgb>;

/// What radiances are multiplied by before they are shown; one for all frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exposure(pub f64);

/// The share of lit pixels that are no brighter than [`EXPOSED_AT`].
const EXPOSED_SHARE: f64 = 0.9;
/// The linear luminance that they get at most.
const EXPOSED_AT: f64 = 0.6;

impl Exposure {
    /// By the reference of the first frame: nine of ten lit pixels get at most a luminance of 0.6. What is a share already is shown as
    /// it is.
    pub fn of(effect: Effect, reference: &LinearImage) -> Self {
        if matches!(effect, Effect::Depth | Effect::Normals | Effect::Ao) {
            return Self(1.0);
        }
        let luminance = |pixel: &[f32; 3]| luma(pixel.map(f64::from));
        let mut lit: Vec<f64> = reference.pixels.iter().map(luminance).filter(|value| *value > 0.0).collect();
        lit.sort_by(f64::total_cmp);
        let place = (lit.len() as f64 * EXPOSED_SHARE) as usize;
        Self(lit.get(place).map_or(1.0, |value| EXPOSED_AT / value))
    }
}

/// Luminance of linear, luma of encoded channels (Rec. 709).
fn luma([red, green, blue]: [f64; 3]) -> f64 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// A linear value in [0, 1], held to it, as 8-bit sRGB (IEC 61966-2-1).
pub(crate) fn to_srgb(linear: f64) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

impl LinearImage {
    /// The image as it is shown: times the exposure, held to [0, 1], as sRGB.
    pub fn developed(&self, Exposure(exposure): Exposure) -> Image8 {
        let pixel = |pixel: &[f32; 3]| pixel.map(|channel| to_srgb(f64::from(channel) * exposure));
        Image8 { size: self.size, pixels: self.pixels.par_iter().map(pixel).collect() }
    }
}

fn check(reference: &Image8, answer: &Image8) -> Result<(), ImageError> {
    if reference.size != answer.size || reference.pixels.len() != answer.pixels.len() {
        return Err(ImageError::Size(reference.size, answer.size));
    }
    if reference.pixels.is_empty() { Err(ImageError::Empty) } else { Ok(()) }
}

/// What an answer is like beside the reference; nothing of waves and of other frames.
///
/// # Errors
/// [`ImageError`] for images of different sizes, and without pixels.
pub fn likeness(effect: Effect, reference: &Image8, answer: &Image8) -> Result<ImageRow, ImageError> {
    let squares = errors(reference, answer)?.into_iter().flatten().map(|error| f64::from(error).powi(2));
    let mse = squares.sum::<f64>() / (3 * reference.pixels.len()) as f64;
    let failed = |error: image_compare::CompareError| ImageError::Failed(error.to_string());
    let ssim = gray_similarity_structure(&Algorithm::MSSIMSimple, &gray(reference)?, &gray(answer)?).map_err(failed)?;
    let flip = effect.asks_any().then(|| {
        let map = flip(reference, answer).to_vec();
        map.iter().map(|value| f64::from(*value)).sum::<f64>() / map.len() as f64
    });
    let beyond = beyond(reference, answer)?.into_iter().filter(|beyond| *beyond).count() as u64;
    let psnr_db = (mse > 0.0).then(|| -10.0 * mse.log10());
    Ok(ImageRow { mse, psnr_db, ssim: ssim.score, flip, beyond, ..ImageRow::default() })
}

fn gray(image: &Image8) -> Result<GrayImage, ImageError> {
    let luma = image.pixels.iter().map(|pixel| luma(pixel.map(f64::from)).round() as u8).collect();
    let [width, height] = image.size;
    GrayImage::from_raw(width, height, luma).ok_or(ImageError::Empty)
}

/// Images of equal size, checked before: else FLIP ends the program.
fn flip(reference: &Image8, answer: &Image8) -> FlipImageFloat {
    let image = |image: &Image8| FlipImageRgb8::with_data(image.size[0], image.size[1], image.pixels.as_flattened());
    nv_flip::flip(image(reference), image(answer), PIXELS_PER_DEGREE)
}

/// By pixel whether a channel is off by more than 1/255.
///
/// # Errors
/// [`ImageError`] for images of different sizes, and without pixels.
pub fn beyond(reference: &Image8, answer: &Image8) -> Result<Vec<bool>, ImageError> {
    check(reference, answer)?;
    let pairs = reference.pixels.iter().zip(&answer.pixels);
    Ok(pairs.map(|(right, found)| right.iter().zip(found).any(|(right, found)| right.abs_diff(*found) > 1)).collect())
}

/// By pixel and channel how much the answer is above the reference, -1 to 1: what flickers.
///
/// # Errors
/// [`ImageError`] for images of different sizes, and without pixels.
pub fn errors(reference: &Image8, answer: &Image8) -> Result<Vec<[f32; 3]>, ImageError> {
    check(reference, answer)?;
    let above = |right: u8, found: u8| (f32::from(found) - f32::from(right)) / 255.0;
    let pairs = reference.pixels.iter().zip(&answer.pixels);
    Ok(pairs.map(|(right, found)| std::array::from_fn(|channel| above(right[channel], found[channel]))).collect())
}

/// A picture of the errors, black where there are none: FLIP, or where it is not taken the largest difference of a channel.
///
/// # Errors
/// [`ImageError`] for images of different sizes, and without pixels.
pub fn error_picture(effect: Effect, reference: &Image8, answer: &Image8) -> Result<Image8, ImageError> {
    let map = match errors(reference, answer)? {
        _ if effect.asks_any() => flip(reference, answer).to_vec(),
        errors => errors.iter().map(|error| error.iter().fold(0.0, |most: f32, each| most.max(each.abs()))).collect(),
    };
    let colours = nv_flip::magma_lut().to_vec();
    let colours: &[Rgb] = colours.as_chunks().0;
    let colour = |value: &f32| {
        let place = (value.clamp(0.0, 1.0) * 255.0).round() as usize;
        colours.get(place).copied().unwrap_or_default()
    };
    Ok(Image8 { size: reference.size, pixels: map.iter().map(colour).collect() })
}
