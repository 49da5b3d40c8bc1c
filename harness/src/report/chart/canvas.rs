//! A drawing surface over plotters: lengths in points, text in the bundled font, SVG and PNG from the same calls.

use std::cell::Cell;
use std::fmt::Display;
use std::sync::OnceLock;

use plotters::coord::Shift;
use plotters::drawing::DrawingArea;
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::prelude::{BitMapBackend, DrawingBackend, IntoDrawingArea, IntoFont, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, RGBColor, ShapeStyle, TextStyle, WHITE, register_font};

use super::palette::{Shape, Style};
use crate::render::encoded;

/// Backend pixels a point: plotters takes whole pixels only, so small ones make positions exact and PNGs sharp.
pub(super) const SCALE: f64 = 2.0;

/// The bundled font first; where an SVG's viewer lacks it, fonts of much the same widths, then any.
const FAMILY: &str = "Roboto, Arial, Helvetica, sans-serif";
const FAMILY_ATTRIBUTE: &str = " font-family=\"Roboto, Arial, Helvetica, sans-serif\"";

/// plotters measures fonts by line height: this many times the em in its SVG backend.
const LINE_HEIGHT: f64 = 1.24;

/// Viewers that lack the bundled font may set text wider by this factor.
const SLACK: f64 = 1.12;

static FONT: &[u8] = include_bytes!("../../../assets/Roboto-Regular.ttf");

/// Why a chart could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(in crate::report) struct DrawError(String);

impl DrawError {
    fn new(error: impl Display) -> Self {
        Self(error.to_string())
    }
}

/// What drawing gives.
pub(super) type Drawn = Result<(), DrawError>;

/// Something that can be drawn on any backend.
pub(super) trait Figure {
    /// Width and height, points.
    fn size(&self) -> (f64, f64);
    /// Draws it.
    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn;
}

/// Where a text stands relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// The surface. Lengths are points, y points down, texts are centred on their line.
pub(super) struct Canvas<DB: DrawingBackend> {
    area: DrawingArea<DB, Shift>,
    /// How far text must be lowered to sit as it does in SVG, in line heights.
    text_drop: f64,
}

impl<DB: DrawingBackend> Canvas<DB> {
    /// A line through points.
    pub(super) fn path(&self, points: &[(f64, f64)], colour: RGBColor, width: f64) -> Drawn {
        if points.len() < 2 {
            return Ok(());
        }
        let points: Vec<_> = points.iter().map(|point| pixel(*point)).collect();
        self.area.draw(&PathElement::new(points, stroke(colour, width))).map_err(DrawError::new)
    }

    /// A dashed line between two points.
    pub(super) fn dashed(&self, from: (f64, f64), to: (f64, f64), colour: RGBColor, width: f64) -> Drawn {
        const PERIOD: f64 = 8.0;
        const DASH: f64 = 5.0;
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        let at = |run: f64| {
            let part = (run / length).min(1.0);
            (from.0 + (to.0 - from.0) * part, from.1 + (to.1 - from.1) * part)
        };
        let mut record = 0.0;
        while record < length {
            self.path(&[at(record), at(record + DASH)], colour, width)?;
            record += PERIOD;
        }
        Ok(())
    }

    /// A dashed line through points, the dashes running on around corners.
    pub(super) fn dashed_path(&self, points: &[(f64, f64)], colour: RGBColor, width: f64) -> Drawn {
        points.windows(2).try_for_each(|pair| self.dashed(pair[0], pair[1], colour, width))
    }

    /// A filled rectangle.
    pub(super) fn fill(&self, from: (f64, f64), to: (f64, f64), colour: RGBColor) -> Drawn {
        self.area.draw(&Rectangle::new([pixel(from), pixel(to)], colour.filled())).map_err(DrawError::new)
    }

    /// The outline of a rectangle.
    pub(super) fn outline(&self, from: (f64, f64), to: (f64, f64), colour: RGBColor, width: f64) -> Drawn {
        self.path(&[from, (to.0, from.1), to, (from.0, to.1), from], colour, width)
    }

    /// A filled marker with a thin white rim, which keeps markers apart where they overlap.
    pub(super) fn filled_marker(&self, centre: (f64, f64), radius: f64, style: Style) -> Drawn {
        self.shape(centre, radius + 0.9, style, WHITE)?;
        self.shape(centre, radius, style, style.colour)
    }

    /// The outline of a marker over white.
    pub(super) fn hollow_marker(&self, centre: (f64, f64), radius: f64, style: Style) -> Drawn {
        // One shape on another: plotters joins the corners of thick lines badly.
        self.shape(centre, radius, style, style.colour)?;
        self.shape(centre, radius - style.shape.rim(1.4), style, WHITE)
    }

    fn shape(&self, centre: (f64, f64), radius: f64, style: Style, colour: RGBColor) -> Drawn {
        if style.shape == Shape::Circle {
            // Smoother than a polygon with its corners on whole pixels.
            let circle = Circle::new(pixel(centre), (radius * SCALE).round() as i32, colour.filled());
            return self.area.draw(&circle).map_err(DrawError::new);
        }
        let corners = style.shape.corners(radius).into_iter().map(|(x, y)| pixel((centre.0 + x, centre.1 + y)));
        self.area.draw(&Polygon::new(corners.collect::<Vec<_>>(), colour.filled())).map_err(DrawError::new)
    }

    /// A line of text, level.
    pub(super) fn text(&self, text: &str, at: (f64, f64), align: Align, size: f64, colour: RGBColor) -> Drawn {
        let drop = self.text_drop * size * LINE_HEIGHT;
        self.any_text(text, (at.0, at.1 + drop), align, size, colour, FontTransform::None)
    }

    /// A line of text that reads upwards, its middle at the point.
    pub(super) fn text_upwards(&self, text: &str, at: (f64, f64), size: f64, colour: RGBColor) -> Drawn {
        let drop = self.text_drop * size * LINE_HEIGHT;
        self.any_text(text, (at.0 + drop, at.1), Align::Middle, size, colour, FontTransform::Rotate270)
    }

    fn any_text(
        &self,
        text: &str,
        at: (f64, f64),
        align: Align,
        size: f64,
        colour: RGBColor,
        transform: FontTransform,
    ) -> Drawn {
        let horizontal = match align {
            Align::Start => HPos::Left,
            Align::Middle => HPos::Center,
            Align::End => HPos::Right,
        };
        let font = (FAMILY, size * LINE_HEIGHT * SCALE).into_font().transform(transform);
        let style = TextStyle::from(font).color(&colour).pos(Pos::new(horizontal, VPos::Center));
        self.area.draw(&Text::new(text.to_owned(), pixel(at), style)).map_err(DrawError::new)
    }
}

/// The width of a text of a size (its em), points; rather too much than too little.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    let font = (FAMILY, size * LINE_HEIGHT * SCALE).into_font();
    // Only a font that was not registered has no layout; then nothing can be drawn, and that is reported there.
    font.layout_box(text).map_or(0.0, |((left, _), (right, _))| f64::from(right - left) / SCALE * SLACK)
}

/// A text cut to a width, with an ellipsis where something is missing.
pub(super) fn shorten(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let mut short: Vec<char> = text.chars().collect();
    while let Some(_last) = short.pop() {
        let candidate = format!("{}…", short.iter().collect::<String>().trim_end());
        if text_width(&candidate, size) <= width {
            return candidate;
        }
    }
    String::new()
}

/// A text in lines no wider than a width; at most so many, the last one cut.
pub(super) fn wrap(text: &str, size: f64, width: f64, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let full = lines.len() == most;
        if let Some(line) = lines.last_mut() {
            let longer = format!("{line} {word}");
            if full || text_width(&longer, size) <= width {
                *line = longer;
                continue;
            }
        }
        lines.push(word.to_owned());
    }
    lines.iter().map(|line| shorten(line, size, width)).collect()
}

/// A figure as SVG.
pub(super) fn to_svg(figure: &impl Figure) -> Result<String, DrawError> {
    register()?;
    let mut svg = String::new();
    let (width, height) = pixels(figure);
    let area = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
    paint(figure, area, 0.0)?;
    // plotters gives the page the size of its pixels; in points it is as large as meant, the coordinates stay.
    let (points_wide, points_high) = figure.size();
    let page = format!("width=\"{width}\" height=\"{height}\"");
    let in_points = format!("width=\"{points_wide}\" height=\"{points_high}\"{FAMILY_ATTRIBUTE}");
    Ok(compact(&svg).replacen(&page, &in_points, 1))
}

/// An SVG of plotters in less than half the bytes, the same to the eye: without attributes that say what holds anyway, the font named once,
/// and lines of one look that follow each other, such as dashes, as one path.
fn compact(svg: &str) -> String {
    const USUAL: [&str; 4] =
        [" opacity=\"1\"", " stroke=\"none\" stroke-width=\"1\"", " stroke=\"none\"", FAMILY_ATTRIBUTE];
    let plain = USUAL.iter().fold(svg.to_owned(), |svg, usual| svg.replace(usual, ""));
    let mut compact = String::with_capacity(plain.len());
    let mut look = None;
    for line in plain.lines() {
        let of_line = line.strip_prefix("<polyline ").and_then(|line| line.strip_suffix(" \"/>"));
        let (next, points) = of_line.and_then(|line| line.split_once(" points=\"")).unzip();
        if next != look && look.is_some() {
            compact.push_str("\"/>\n");
        }
        match (next, points) {
            (Some(_), Some(points)) if next == look => compact.extend(["M", points]),
            (Some(look), Some(points)) => compact.extend(["<path ", look, " d=\"M", points]),
            _ => compact.extend([line, "\n"]),
        }
        look = next;
    }
    compact
}

thread_local! {
    static IMAGES: Cell<bool> = const { Cell::new(true) };
}

/// Does something by which PNGs come out empty: they take most of the time of a report.
pub fn without_images<R>(work: impl FnOnce() -> R) -> R {
    IMAGES.set(false);
    let done = work();
    IMAGES.set(true);
    done
}

/// A figure as PNG.
pub(super) fn to_png(figure: &impl Figure) -> Result<Vec<u8>, DrawError> {
    if !IMAGES.get() {
        return Ok(Vec::new());
    }
    register()?;
    let (width, height) = pixels(figure);
    let mut pixels = vec![0; width as usize * height as usize * 3];
    let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
    paint(figure, area, 0.1)?;
    let png = encoded([width, height], &[&pixels], |encoder| {
        encoder.set_color(png::ColorType::Rgb);
        Ok(())
    });
    png.map_err(DrawError::new)
}

fn paint<DB: DrawingBackend>(figure: &impl Figure, area: DrawingArea<DB, Shift>, text_drop: f64) -> Drawn {
    area.fill(&WHITE).map_err(DrawError::new)?;
    let canvas = Canvas { area, text_drop };
    figure.draw(&canvas)?;
    canvas.area.present().map_err(DrawError::new)
}

/// Makes the bundled font known to plotters, once.
pub(super) fn register() -> Drawn {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    match REGISTERED.get_or_init(|| register_font(FAMILY, FontStyle::Normal, FONT).is_ok()) {
        true => Ok(()),
        false => Err(DrawError("the bundled font cannot be read".to_owned())),
    }
}

fn pixels(figure: &impl Figure) -> (u32, u32) {
    let (width, height) = figure.size();
    ((width * SCALE).ceil() as u32, (height * SCALE).ceil() as u32)
}

fn pixel((x, y): (f64, f64)) -> (i32, i32) {
    ((x * SCALE).round() as i32, (y * SCALE).round() as i32)
}

fn stroke(colour: RGBColor, width: f64) -> ShapeStyle {
    colour.stroke_width((width * SCALE).round() as u32)
}
