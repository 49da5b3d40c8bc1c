//! Images of answers in few colours: what truth says, what a tracer answered, each ray's class, and how far off hits are. Pixels
//! from which no ray started are transparent.

use tracebench_api::Query;

use super::{ImageError, Rgb, encoded};
use crate::judge::Class;
use crate::rays::Pixel;

/// Colours of the classes, and of ambiguous any-hit rays.
pub(crate) const CLASS_COLOURS: [(Class, Rgb); 6] = [
    (Class::TrueHit, [210, 210, 210]),
    (Class::TrueMiss, [245, 245, 245]),
    (Class::FalseHit, [230, 60, 180]),
    (Class::FalseMiss, [215, 40, 40]),
    (Class::Early, [240, 150, 30]),
    (Class::Late, [40, 100, 220]),
];
const AMBIGUOUS_COLOUR: Rgb = [120, 90, 40];

/// A pixel from which no ray started.
const NONE: u8 = 0;
/// A ray without a hit.
const MISS: u8 = 1;
/// The first of the steps of a scale.
const FIRST: u8 = 2;

/// Steps of the scale of errors to either side.
const ERROR_STEPS: u8 = 120;
/// Decades of the scale of errors, up to the scene's diagonal.
pub(crate) const ERROR_DECADES: f64 = 6.0;

/// An image whose pixels name colours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Painted {
    size: [u32; 2],
    /// Colours by their number; the first is transparent.
    palette: Vec<Rgb>,
    pixels: Vec<u8>,
}

/// From which pixels rays started.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Canvas<'a> {
    /// Width and height of the image.
    pub size: [u32; 2],
    /// By ray its pixel in scanline order. Of several rays of a pixel the first is shown.
    pub pixels: &'a [Pixel],
}

impl Canvas<'_> {
    fn paint(&self, palette: Vec<Rgb>, colour: impl Fn(usize) -> u8) -> Painted {
        let mut pixels = vec![NONE; self.size[0] as usize * self.size[1] as usize];
        for (ray, pixel) in self.pixels.iter().enumerate() {
            if let Some(place) = pixels.get_mut(*pixel as usize).filter(|place| **place == NONE) {
                *place = colour(ray);
            }
        }
        Painted { size: self.size, palette, pixels }
    }

    /// How far hits lie along their rays: near is bright, from the nearest to the farthest of a range.
    pub(crate) fn distances(&self, [nearest, farthest]: [f64; 2], t: &[Option<f64>]) -> Painted {
        let steps = u8::MAX - FIRST;
        let grey = |step: u8| [255 - (u32::from(step) * 215 / u32::from(steps)) as u8; 3];
        let palette = [[0; 3], MISS_COLOUR].into_iter().chain((0..=steps).map(grey)).collect();
        self.paint(palette, |ray| match t[ray] {
            None => MISS,
            Some(t) => {
                let share = (t - nearest) / (farthest - nearest).max(f64::MIN_POSITIVE);
                FIRST + (share.clamp(0.0, 1.0) * f64::from(steps)).round() as u8
            }
        })
    }

    /// Whether anything lies between a ray's ends: dark if so.
    pub(crate) fn occlusion(&self, occluded: &[bool]) -> Painted {
        self.paint(vec![[0; 3], [245; 3], [90; 3]], |ray| if occluded[ray] { FIRST } else { MISS })
    }

    /// Classes; `None` is an ambiguous any-hit ray.
    pub(crate) fn classes(&self, classes: &[Option<Class>]) -> Painted {
        let colours = CLASS_COLOURS.iter().map(|(_, colour)| *colour);
        let palette = [[0; 3], AMBIGUOUS_COLOUR].into_iter().chain(colours).collect();
        self.paint(palette, |ray| {
            let known = CLASS_COLOURS.iter().position(|(class, _)| Some(*class) == classes[ray]);
            known.map_or(MISS, |place| FIRST + place as u8)
        })
    }

    /// By how much hits are early (orange) or late (blue), on a scale of logarithms that ends at `greatest`; white is right or off by
    /// less than the scale shows. Where one of the two has no hit it is grey.
    pub(crate) fn errors(&self, greatest: f64, truth: &[Option<f64>], answer: &[Option<f64>]) -> Painted {
        let towards = |end: Rgb, step: u8| {
            let mix = |channel: u8| 255.0 + (f64::from(channel) - 255.0) * f64::from(step) / f64::from(ERROR_STEPS);
            end.map(|channel| mix(channel).round() as u8)
        };
        let early = (1..=ERROR_STEPS).map(|step| towards(EARLY_COLOUR, step));
        let late = (1..=ERROR_STEPS).map(|step| towards(LATE_COLOUR, step));
        let palette = [[0; 3], [150; 3], [255; 3]].into_iter().chain(early).chain(late).collect();
        self.paint(palette, |ray| {
            let Some((truth, answer)) = truth[ray].zip(answer[ray]) else { return MISS };
            let decades = ((answer - truth).abs() / greatest).log10() + ERROR_DECADES;
            let step =
                (decades / ERROR_DECADES * f64::from(ERROR_STEPS)).ceil().clamp(0.0, f64::from(ERROR_STEPS)) as u8;
            match step {
                0 => FIRST,
                _ if answer < truth => FIRST + step,
                _ => FIRST + ERROR_STEPS + step,
            }
        })
    }
}

const MISS_COLOUR: Rgb = [46, 58, 92];
/// Hues of the classes.
const EARLY_COLOUR: Rgb = [200, 80, 0];
const LATE_COLOUR: Rgb = [20, 70, 190];

impl Painted {
    /// As a PNG.
    ///
    /// # Errors
    /// [`ImageError::Encode`].
    pub(crate) fn png(&self) -> Result<Vec<u8>, ImageError> {
        encoded(self.size, &[&self.pixels], |encoder| {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(self.palette.as_flattened().to_vec());
            encoder.set_trns(vec![0]);
            encoder.set_compression(png::Compression::High);
            Ok(())
        })
    }
}

/// What colours say, for people: name and colour.
pub(crate) fn class_legend(query: Query) -> Vec<(&'static str, String)> {
    let colour = |[red, green, blue]: Rgb| format!("#{red:02x}{green:02x}{blue:02x}");
    // Without distances nothing is early or late.
    let told = |class: &Class| query == Query::Closest || !matches!(class, Class::Early | Class::Late);
    let classes = CLASS_COLOURS.iter().filter(|(class, _)| told(class));
    let mut all: Vec<_> = classes.map(|(class, rgb)| (class.name(query), colour(*rgb))).collect();
    all.extend((query == Query::Any).then(|| ("ambiguous", colour(AMBIGUOUS_COLOUR))));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(painted: &Painted) -> (Vec<u8>, Vec<u8>) {
        let bytes = painted.png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let palette = reader.info().palette.as_ref().unwrap().to_vec();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        (palette, pixels)
    }

    /// Proves that rays land on their pixels, the first of several is shown, pixels without one stay transparent, one that is out
    /// of the image is left out, and that an image reads back as it was painted.
    #[test]
    fn rays_land_on_their_pixels() {
        let canvas = Canvas { size: [3, 2], pixels: &[4, 0, 4, 9] };
        let painted = canvas.distances([1.0, 3.0], &[Some(1.0), None, Some(3.0), Some(2.0)]);
        assert_eq!(painted.pixels, [MISS, 0, 0, 0, FIRST, 0]);
        let (palette, pixels) = read(&painted);
        assert_eq!((pixels, palette.len()), (painted.pixels, 256 * 3));
    }

    /// Proves that nearer is brighter, that what is out of the range is held to its ends, and that a range without width is no fault.
    #[test]
    fn near_is_bright() {
        let canvas = Canvas { size: [4, 1], pixels: &[0, 1, 2, 3] };
        let painted = canvas.distances([1.0, 2.0], &[0.0, 1.0, 2.0, 9.0].map(Some));
        let bright: Vec<u8> = painted.pixels.iter().map(|colour| painted.palette[*colour as usize][0]).collect();
        assert_eq!(bright, [255, 255, 40, 40]);
        assert_eq!(canvas.distances([1.0; 2], &[1.0; 4].map(Some)).pixels, [FIRST; 4]);
    }

    /// Proves the signs and steps of errors: a factor of ten is a sixth of the scale, a millionth is nothing, and more than the scale
    /// is its end.
    #[test]
    fn errors_have_signs_and_steps() {
        let canvas = Canvas { size: [7, 1], pixels: &[0, 1, 2, 3, 4, 5, 6] };
        let truth = [Some(5.0), Some(5.0), Some(5.0), Some(5.0), Some(5.0), None, Some(5.0)];
        let answer = [Some(5.0), Some(5.0 - 1e-7), Some(5.1), Some(4.9), Some(99.0), Some(1.0), None];
        let step = |decades: f64| (decades * f64::from(ERROR_STEPS) / ERROR_DECADES).ceil() as u8;
        // 0.1 of 10 is two decades below the end.
        let off = step(4.0);
        let painted = canvas.errors(10.0, &truth, &answer);
        let late = FIRST + ERROR_STEPS;
        let near = |found: u8, wanted: u8| found.abs_diff(wanted) <= 1;
        assert_eq!(painted.pixels[..2], [FIRST; 2]);
        assert!(near(painted.pixels[2], late + off) && near(painted.pixels[3], FIRST + off), "{:?}", painted.pixels);
        assert_eq!(painted.pixels[4..], [late + ERROR_STEPS, MISS, MISS]);
        let [red, _, blue] = painted.palette[painted.pixels[3] as usize];
        assert!(red > blue);
        assert!(painted.palette.len() <= 256);
    }

    /// Proves that each class has its own colour in the image and the legend.
    #[test]
    fn classes_have_their_colours() {
        let canvas = Canvas { size: [7, 1], pixels: &[0, 1, 2, 3, 4, 5, 6] };
        let classes: Vec<Option<Class>> = CLASS_COLOURS.iter().map(|(class, _)| Some(*class)).chain([None]).collect();
        let painted = canvas.classes(&classes);
        for (place, (class, colour)) in CLASS_COLOURS.iter().enumerate() {
            assert_eq!(painted.palette[painted.pixels[place] as usize], *colour, "{class:?}");
        }
        assert_eq!(painted.palette[painted.pixels[6] as usize], AMBIGUOUS_COLOUR);
        let names =
            |query| class_legend(query).into_iter().map(|(name, _)| name).collect::<std::collections::BTreeSet<_>>();
        assert_eq!((names(Query::Closest).len(), names(Query::Any).len()), (6, 5));
    }
}
