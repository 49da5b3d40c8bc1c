//! A drawing surface over plotters: lengths in points, text in the bundled font, SVG and PNG of the same shapes.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::error::Error;
use std::sync::Once;

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::prelude::{BitMapBackend, DrawingBackend, FontDesc, IntoDrawingArea, IntoFont, SVGBackend};
pub(super) use plotters::style::text_anchor::HPos as Align;
use plotters::style::text_anchor::{Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, RGBColor, TextStyle, WHITE, register_font};

use super::palette::{self, Style};
use crate::hash::sha256_of;
use crate::render::encoded;

/// Backend pixels a point: plotters takes whole pixels only, so small ones make positions exact and PNGs sharp.
pub(in crate::report) const SCALE: f64 = 2.0;

/// The bundled font first; where an SVG's viewer lacks it, fonts of much the same widths, then any.
const FAMILY: &str = "Roboto, Arial, Helvetica, sans-serif";

/// Attributes of a whole drawing: all but lines name the colour that fills them.
const OF_ALL: [&str; 2] = [" font-family=\"Roboto, Arial, Helvetica, sans-serif\"", " fill=\"none\""];

/// plotters measures fonts by line height: this many times the em in its SVG backend.
const LINE_HEIGHT: f64 = 1.24;

/// How far text of PNGs must be lowered to sit as it does in SVG, in line heights.
const PNG_DROP: f64 = 0.1;

/// Viewers that lack the bundled font may set text wider by this factor.
const SLACK: f64 = 1.12;

static FONT: &[u8] = include_bytes!("../../../assets/Roboto-Regular.ttf");

/// By both axes, points.
type Place = (f64, f64);

/// On the canvas of plotters, pixels.
type Pixel = (i32, i32);

/// What is drawn.
enum Shape {
    Path(PathElement<Pixel>),
    Rectangle(Rectangle<Pixel>),
    Circle(Circle<Pixel, i32>),
    Polygon(Polygon<Pixel>),
    /// Text of a size, in points; whether it reads upwards.
    Text(String, Place, Align, f64, RGBColor, bool),
}

/// The surface. Lengths are points, y points down, texts are centred on their line.
#[derive(Default)]
pub(super) struct Canvas {
    pub size: Place,
    shapes: Vec<Shape>,
}

impl Canvas {
    /// A line through points.
    pub(super) fn path(&mut self, points: &[Place], colour: RGBColor, width: f64) {
        if points.len() > 1 {
            let points: Vec<Pixel> = points.iter().map(|point| pixel(*point)).collect();
            let stroke = colour.stroke_width((width * SCALE).round() as u32);
            self.shapes.push(Shape::Path(PathElement::new(points, stroke)));
        }
    }

    /// A dashed line through points, each part of it beginning with a dash.
    pub(super) fn dashed(&mut self, points: &[Place], colour: RGBColor, width: f64) {
        const PERIOD: f64 = 8.0;
        const DASH: f64 = 5.0;
        for (from, to) in points.windows(2).map(|pair| (pair[0], pair[1])) {
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            let at = |run: f64| {
                let part = (run / length).min(1.0);
                (from.0 + (to.0 - from.0) * part, from.1 + (to.1 - from.1) * part)
            };
            let mut run = 0.0;
            while run < length {
                self.path(&[at(run), at(run + DASH)], colour, width);
                run += PERIOD;
            }
        }
    }

    /// A filled rectangle.
    pub(super) fn fill(&mut self, from: Place, to: Place, colour: RGBColor) {
        self.shapes.push(Shape::Rectangle(Rectangle::new([pixel(from), pixel(to)], colour.filled())));
    }

    /// A filled marker with a thin white rim, which keeps markers apart where they overlap.
    pub(super) fn filled_marker(&mut self, centre: Place, radius: f64, style: Style) {
        self.marker(centre, radius + 0.9, style, WHITE);
        self.marker(centre, radius, style, style.colour);
    }

    /// The outline of a marker over white.
    pub(super) fn hollow_marker(&mut self, centre: Place, radius: f64, style: Style) {
        // One shape on another: plotters joins the corners of thick lines badly.
        self.marker(centre, radius, style, style.colour);
        self.marker(centre, radius - style.shape.rim(1.4), style, WHITE);
    }

    fn marker(&mut self, centre: Place, radius: f64, style: Style, colour: RGBColor) {
        let corner = |(x, y): Place| pixel((centre.0 + x, centre.1 + y));
        let (centre, look) = (pixel(centre), colour.filled());
        self.shapes.push(match style.shape {
            // Smoother than a polygon with its corners on whole pixels.
            palette::Shape::Circle => Shape::Circle(Circle::new(centre, (radius * SCALE).round() as i32, look)),
            shape => {
                let corners: Vec<Pixel> = shape.corners(radius).into_iter().map(corner).collect();
                Shape::Polygon(Polygon::new(corners, look))
            }
        });
    }

    /// A line of text, level.
    pub(super) fn text(&mut self, text: &str, at: Place, align: Align, size: f64, colour: RGBColor) {
        self.shapes.push(Shape::Text(text.to_owned(), at, align, size, colour, false));
    }

    /// A line of text that reads upwards, its middle at the point.
    pub(super) fn text_upwards(&mut self, text: &str, at: Place, size: f64, colour: RGBColor) {
        self.shapes.push(Shape::Text(text.to_owned(), at, Align::Center, size, colour, true));
    }

    /// As SVG, in points as large as meant while coordinates are pixels.
    pub(super) fn svg(&self) -> String {
        let (mut svg, (wide, high), (width, height)) = (String::new(), self.size, self.pixels());
        // A string takes all that is written.
        let _ = self.paint(SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area(), 0.0);
        let page = format!("width=\"{width}\" height=\"{height}\"");
        let in_points = format!("width=\"{wide}\" height=\"{high}\"{}", OF_ALL.concat());
        named(&compact(&svg)).replacen(&page, &in_points, 1)
    }

    /// As PNG.
    ///
    /// # Errors
    /// Why plotters cannot draw it.
    pub(super) fn png(&self) -> Result<Vec<u8>, Box<dyn Error>> {
        if !IMAGES.get() {
            return Ok(Vec::new());
        }
        let (width, height) = self.pixels();
        let mut pixels = vec![0; width as usize * height as usize * 3];
        let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
        self.paint(area, PNG_DROP)?;
        let png = encoded([width, height], &[&pixels], |encoder| {
            encoder.set_color(png::ColorType::Rgb);
            Ok(())
        });
        Ok(png?)
    }

    /// Width and height, pixels.
    fn pixels(&self) -> (u32, u32) {
        let (width, height) = self.size;
        ((width * SCALE).ceil() as u32, (height * SCALE).ceil() as u32)
    }

    /// Draws all shapes, text lowered by so many line heights.
    fn paint<DB: DrawingBackend>(
        &self,
        area: DrawingArea<DB, Shift>,
        drop: f64,
    ) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
        area.fill(&WHITE)?;
        for shape in &self.shapes {
            match shape {
                Shape::Path(path) => area.draw(path)?,
                Shape::Rectangle(rectangle) => area.draw(rectangle)?,
                Shape::Circle(circle) => area.draw(circle)?,
                Shape::Polygon(polygon) => area.draw(polygon)?,
                Shape::Text(text, (x, y), align, size, colour, upwards) => {
                    let drop = drop * size * LINE_HEIGHT;
                    let (at, turned) = match *upwards {
                        true => ((x + drop, *y), FontTransform::Rotate270),
                        false => ((*x, y + drop), FontTransform::None),
                    };
                    let style = TextStyle::from(font(*size).transform(turned)).color(colour);
                    area.draw(&Text::new(text.as_str(), pixel(at), style.pos(Pos::new(*align, VPos::Center))))?;
                }
            }
        }
        area.present()
    }
}

fn pixel((x, y): Place) -> Pixel {
    ((x * SCALE).round() as i32, (y * SCALE).round() as i32)
}

/// An SVG of plotters in less than half the bytes, the same to the eye: without attributes that say what holds anyway, those of all named once,
/// lines of one look that follow each other, such as dashes, as one path, and corners of lines and polygons as steps from one to the next.
pub(super) fn compact(svg: &str) -> String {
    const USUAL: [&str; 4] =
        [" opacity=\"1\"", " stroke=\"none\" stroke-width=\"1\"", " stroke=\"none\"", " text-anchor=\"start\""];
    let plain = USUAL.iter().chain(&OF_ALL).fold(svg.to_owned(), |svg, usual| svg.replace(usual, ""));
    let mut compact = String::with_capacity(plain.len());
    let (mut open, mut at) = (None, (0, 0));
    for line in plain.lines() {
        let is_filled = line.starts_with("<polygon ");
        let shape = line.strip_prefix("<polyline ").or_else(|| line.strip_prefix("<polygon "));
        let (look, points) = shape.and_then(|shape| shape.strip_suffix(" \"/>")?.split_once(" points=\"")).unzip();
        let goes_on = look == open && !is_filled;
        if !goes_on && open.is_some() {
            compact.push_str("\"/>\n");
        }
        if let (Some(look), Some(points)) = (look, points) {
            if !goes_on {
                at = (0, 0);
                compact.extend(["<path ", look, " d=\""]);
            }
            compact += &steps(points, &mut at);
        } else {
            compact.extend([line, "\n"]);
        }
        open = look;
    }
    compact
}

/// An SVG with every marker, a shape on its rim, once: it is named after its look, so that in a page of many drawings one name is one look.
pub(super) fn named(svg: &str) -> String {
    const WHITE: &str = "fill=\"#FFFFFF\"";
    const MAX_RIM: i32 = 16;
    let (mut looks, mut all) = (BTreeMap::new(), String::with_capacity(svg.len()));
    let mut lines = svg.lines().peekable();
    while let Some(line) = lines.next() {
        let next = lines.peek().filter(|next| next.contains(WHITE) != line.contains(WHITE));
        let pair = filled(line).zip(next.and_then(|next| filled(next)));
        let near = |((x, y), (left, top)): (Pixel, Pixel)| (x - left).abs() + (y - top).abs() < MAX_RIM;
        let Some((rim, shape)) = pair.filter(|(rim, shape)| near((rim.0, shape.0))) else {
            all.extend([line, "\n"]);
            continue;
        };
        lines.next();
        let (x, y) = rim.0;
        let part = |((left, top), [before, between, behind]): (Pixel, [&str; 3])| {
            format!("{before}{}{between}{}{behind}", left - x, top - y)
        };
        let look = part(rim) + &part(shape);
        let name = format!("m{}", &sha256_of(look.as_bytes())[..8]);
        all += &format!("<use href=\"#{name}\" x=\"{x}\" y=\"{y}\"/>\n");
        looks.entry(name).or_insert(look);
    }
    let looks: String = looks.iter().map(|(name, look)| format!("<g id=\"{name}\">{look}</g>\n")).collect();
    let (head, drawn) = all.split_once('\n').unwrap_or_default();
    if looks.is_empty() { all } else { format!("{head}\n<defs>\n{looks}</defs>\n{drawn}") }
}

/// The place of a filled circle or polygon, and what is before, between and behind its coordinates.
fn filled(line: &str) -> Option<(Pixel, [&str; 3])> {
    let is_circle = line.starts_with("<circle ");
    let (begin, between) = if is_circle { (" cx=\"", "\" cy=\"") } else { (" d=\"m", ",") };
    let (before, rest) = line.split_once(begin).filter(|_| is_circle || line.starts_with("<path fill="))?;
    let (x, rest) = rest.split_once(between)?;
    let (y, behind) = rest.split_at(rest.find(|c: char| !c.is_ascii_digit())?);
    Some(((x.parse().ok()?, y.parse().ok()?), [&line[..before.len() + begin.len()], between, behind]))
}

/// Points such as `4,6 9,2` as a part of a path: the first as a step from where the last part ended, each other as one from that before it.
fn steps(points: &str, at: &mut Pixel) -> String {
    let mut path = "m".to_owned();
    // A sign parts numbers as well.
    let after = |between: &str, step: i32| if step < 0 { step.to_string() } else { format!("{between}{step}") };
    let pairs = points.split(' ').filter_map(|point| point.split_once(','));
    for (x, y) in pairs.filter_map(|(x, y)| Some((x.parse::<i32>().ok()?, y.parse::<i32>().ok()?))) {
        path += &format!("{}{}", after(if path == "m" { "" } else { " " }, x - at.0), after(",", y - at.1));
        *at = (x, y);
    }
    path
}

/// The bundled font in a size, made known to plotters once. One that cannot be read fails where text is drawn.
fn font(size: f64) -> FontDesc<'static> {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| {
        let _ = register_font(FAMILY, FontStyle::Normal, FONT);
    });
    (FAMILY, size * LINE_HEIGHT * SCALE).into_font()
}

/// The width of a text of a size (its em), points; rather too much than too little.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    font(size).layout_box(text).map_or(0.0, |((left, _), (right, _))| f64::from(right - left) / SCALE * SLACK)
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
