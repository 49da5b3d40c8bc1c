//! Pictures as PNGs, still and moving.

use std::io::Cursor;

use super::{Image, Image8, ImageError, Rgb};

/// Frames of eight bits a channel, of the kind that `set` says, as a PNG.
pub(crate) fn encoded(
    [width, height]: [u32; 2],
    frames: &[&[u8]],
    set: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>) -> Result<(), png::EncodingError>,
) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_depth(png::BitDepth::Eight);
    let done = set(&mut encoder).and_then(|()| encoder.write_header()).and_then(|mut writer| {
        frames.iter().try_for_each(|frame| writer.write_image_data(frame))?;
        writer.finish()
    });
    done.map_err(|error| ImageError::Failed(error.to_string()))?;
    Ok(bytes)
}

/// Frames as one PNG: moving over and over at `fps` where there are several, else a still picture.
///
/// # Errors
/// [`ImageError`] for frames of different sizes, and where there is none.
pub fn animation(frames: &[Image8], fps: f64) -> Result<Vec<u8>, ImageError> {
    let size = same_size(frames)?;
    // Browsers show what is faster than 50 Hz slowly, and a delay has 16 bits.
    let delay_ms = (1000.0 / fps).round().clamp(20.0, f64::from(u16::MAX)) as u16;
    let pixels: Vec<&[u8]> = frames.iter().map(|frame| frame.pixels.as_flattened()).collect();
    encoded(size, &pixels, |encoder| {
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        if frames.len() > 1 {
            encoder.set_animated(frames.len() as u32, 0)?;
            encoder.set_frame_delay(delay_ms, 1000)?;
        }
        Ok(())
    })
}

fn same_size(images: &[Image8]) -> Result<[u32; 2], ImageError> {
    let Some(first) = images.first().filter(|first| !first.pixels.is_empty()) else { return Err(ImageError::Empty) };
    match images.iter().find(|image| image.size != first.size) {
        Some(other) => Err(ImageError::Size(first.size, other.size)),
        None => Ok(first.size),
    }
}

/// Pixels between the stills of a strip.
const GAP: u32 = 4;
const GAP_COLOUR: Rgb = [255; 3];

/// Stills of one size side by side, row below row; a row may be shorter.
///
/// # Errors
/// [`ImageError`] for stills of different sizes, and where there is none.
pub fn strip(rows: &[Vec<Image8>]) -> Result<Image8, ImageError> {
    let [width, height] = same_size(&rows.concat())?;
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let size = [columns * (width + GAP) - GAP, rows.len() as u32 * (height + GAP) - GAP];
    let mut pixels = vec![GAP_COLOUR; size[0] as usize * size[1] as usize];
    for (row, stills) in rows.iter().enumerate() {
        for (column, still) in stills.iter().enumerate() {
            let left = column * (width + GAP) as usize;
            let top = row * (height + GAP) as usize;
            for (line, from) in still.pixels.chunks(width as usize).enumerate() {
                let start = (top + line) * size[0] as usize + left;
                pixels[start..start + from.len()].copy_from_slice(from);
            }
        }
    }
    Ok(Image8 { size, pixels })
}

/// Stills of a [`strip`]'s PNG that stand below one another, as a PNG of their own: their size, the column and row of the first, how many.
///
/// # Errors
/// [`ImageError`] for what is no PNG, or has no such stills.
pub fn cut(strip: &[u8], [width, height]: [u32; 2], [column, row]: [u32; 2], rows: u32) -> Result<Vec<u8>, ImageError> {
    let failed = |error: png::DecodingError| ImageError::Failed(error.to_string());
    let mut reader = png::Decoder::new(Cursor::new(strip)).read_info().map_err(failed)?;
    let mut pixels = vec![0; reader.output_buffer_size().ok_or(ImageError::Empty)?];
    let whole = reader.next_frame(&mut pixels).map_err(failed)?;
    let (left, top, tall) = (column * (width + GAP), row * (height + GAP), rows * (height + GAP) - GAP);
    if left + width > whole.width || top + tall > whole.height {
        return Err(ImageError::Size([left + width, top + tall], [whole.width, whole.height]));
    }
    let (pixels, _): (&[Rgb], _) = pixels.as_chunks();
    let lines = pixels.chunks_exact(whole.width as usize).skip(top as usize).take(tall as usize);
    let pixels = lines.flat_map(|line| &line[left as usize..][..width as usize]).copied().collect();
    animation(&[Image { size: [width, tall], pixels }], 1.0)
}
