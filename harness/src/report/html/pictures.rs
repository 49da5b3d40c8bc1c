//! Pictures of what points on fronts answer: truth, answer, class and error in one place, switched there; and frames as they were rendered,
//! one of truth, answer or error at a time. They are files beside the record; where one is missing or is not what its name says, it is not
//! shown.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use data_encoding::BASE64;
use itertools::Itertools as _;
use tracebench_api::Query;

use super::Place;
use super::pieces::{Piece, Rank, Tags, escape};
use super::read::Read;
use crate::render::painted::{ERROR_DECADES, class_legend};
use crate::report::format::significant;
use crate::report::frames::works;
use crate::report::kept;
use crate::results::{FramePictures, FramesRecord, PointPictures, Record, SetPictures};

/// A part for each scene and ray set that has pictures.
pub(super) fn pictures(places: &[Place<'_>]) -> Vec<Piece> {
    let piece = |(number, place): (usize, &Place<'_>)| {
        let set = place.field.scene.pictures.iter().find(|set| set.rays == place.field.rays)?;
        Some(place.piece(Rank::Picture, "pictures", figure(number, place, set)?))
    };
    places.iter().enumerate().filter_map(piece).chain(others(places)).collect()
}

/// A file beside a record as an address that holds it, if it is what its name says.
fn address(record: &str, name: &str) -> Option<String> {
    let bytes = kept::picture(Path::new(record), name)?;
    Some(format!("data:image/png;base64,{}", BASE64.encode(&bytes)))
}

/// A word on files that are not the pictures after which they are named.
fn others(places: &[Place<'_>]) -> Option<Piece> {
    let records: BTreeMap<&str, &Record> = places.iter().map(|place| (place.read.path, &*place.read.record)).collect();
    let of_record = |(path, record): (&str, &Record)| kept::others(Path::new(path), record);
    let all: BTreeSet<String> = records.into_iter().flat_map(of_record).collect();
    let names = all.iter().map(|name| format!("<code>{}</code>", escape(name))).join(", ");
    let what = "Left out, since these files are not the pictures that the record names";
    (!names.is_empty()).then(|| Piece::fixed(format!("<p>{what}: {names}.</p>\n")))
}

/// What can be chosen, of a tracer.
fn option(value: usize, tracer: &str, label: &str) -> String {
    format!("<option value=\"{value}\"{}>{}</option>\n", Tags::of_tracer(tracer).text(), escape(label))
}

fn figure(number: usize, place: &Place<'_>, set: &SetPictures) -> Option<String> {
    let [width, height] = set.size;
    let title = place.title();
    let image = |what: &str, tags: &str, of: &str, name: &str| {
        let (source, alt) = (address(place.read.path, name)?, escape(&format!("{of}: {title}")));
        let size = format!("width=\"{width}\" height=\"{height}\"");
        Some(format!("<img data-what=\"{what}\"{tags} {size} alt=\"{alt}\" src=\"{source}\">\n"))
    };
    let mut images = image("truth", "", "Truth", &set.truth)?;
    let mut options = String::new();
    for PointPictures { point, answer, class, error } in &set.points {
        let known = place.field.section.points.get(*point)?;
        let label = known.label();
        let tags = format!(" data-of=\"{point}\"{}", Tags::of_tracer(&known.tracer).text());
        let files = [("answer", Some(answer)), ("class", Some(class)), ("error", error.as_ref())].into_iter();
        let own = files.filter_map(|(what, name)| Some(image(what, &tags, &format!("{what} of {label}"), name?)));
        // A point is shown with all of its pictures.
        let Some(own) = own.collect::<Option<String>>() else { continue };
        images += &own;
        options += &option(*point, &known.tracer, &label);
    }
    if options.is_empty() {
        return None;
    }
    let whats = ["truth", "answer", "class", "error"].into_iter().take(if set.query == Query::Any { 3 } else { 4 });
    let choice = |what: &str| {
        let checked = if what == "class" { " checked" } else { "" };
        format!("<label><input type=\"radio\" name=\"picture-{number}\" value=\"{what}\"{checked}> {what}</label>")
    };
    let choices: String = whats.map(choice).collect();
    let key = |(name, colour): (&str, String)| format!("<li><i style=\"background:{colour}\"></i>{name}</li>");
    let legend: String = class_legend(set.query).into_iter().map(key).collect();
    Some(format!(
        "<figure class=\"pictures\"{}><figcaption>{}. {} Transparent: no ray. {}</figcaption>\n\
         <div class=\"switches\"><label>Point <select>{options}</select></label><fieldset><legend>Shown</legend>{choices}</fieldset></div>\n\
         <div class=\"stack\">{images}</div>\n<ul class=\"key\">{legend}</ul></figure>\n",
        place.tags().text(),
        escape(&title),
        scales(set),
        escape(&place.read.label()),
    ))
}

/// What brightness and colours of distances and errors say.
fn scales(set: &SetPictures) -> String {
    match (set.distances, set.max_error) {
        (Some([nearest, farthest]), Some(greatest)) => {
            let [nearest, farthest] = [nearest, farthest].map(|t| significant(t, 3));
            let [most, least] = [greatest, greatest / 10_f64.powf(ERROR_DECADES)].map(|error| significant(error, 2));
            format!(
                "Truth and answer: distance along the ray, white {nearest}, darkest {farthest} scene units, blue no hit. Error of t: orange \
                 too small, blue too large, in steps of its logarithm from {least} (white) to {most} scene units; grey where not both hit."
            )
        }
        _ => "Truth and answer: dark is occluded, light is free.".to_owned(),
    }
}

/// A player for each scene and effect that has pictures.
pub(super) fn players(all: &[Read<'_>]) -> Vec<Piece> {
    let sections = all.iter().filter_map(|read| Some((read.path, read.record.frames.as_ref()?)));
    let works = sections.flat_map(|(path, section)| works(section).map(move |work| (path, section, work)));
    works.filter_map(|(path, section, (scene, work))| player(path, section, scene, work)).collect()
}

/// The sheet of all frames as an image of which a frame is shown; `rows` are those of a frame: the answer, and its error where there is one.
fn sheet(record: &str, pictures: &FramePictures, tags: &str, rows: u32, alt: &str) -> Option<String> {
    let source = address(record, &pictures.sheet)?;
    let (alt, columns) = (escape(alt), pictures.columns);
    Some(format!("<img{tags} data-rows=\"{rows}\" data-columns=\"{columns}\" alt=\"{alt}\" src=\"{source}\">\n"))
}

fn player(record: &str, section: &FramesRecord, scene: usize, work: &str) -> Option<Piece> {
    let moving = &section.scenes[scene];
    let title = format!("{work} in {}", moving.scene.name);
    let mut images =
        sheet(record, moving.pictures.get(work)?, " data-of=\"truth\"", 1, &format!("Truth of {title}, all frames"))?;
    let mut options = "<option value=\"truth\">truth</option>".to_owned();
    let rows = section.rows.iter().enumerate().filter(|(_, row)| row.scene as usize == scene);
    for (place, row) in rows {
        let Some(pictures) = row.pictures.get(work) else { continue };
        let (label, tracer) = (row.tracer.label(), &row.tracer.name);
        let alt = format!("{label}: {title}, all frames, each above its error");
        let tags = format!(" data-of=\"{place}\"{}", Tags::of_tracer(tracer).text());
        if let Some(image) = sheet(record, pictures, &tags, 2, &alt) {
            images += &image;
            options += &option(place, tracer, &label);
        }
    }
    let tags = Tags { scene: Some(&moving.scene.name), rays: Some(work), tracer: None };
    let ([width, height], last) = (section.size, section.frames.saturating_sub(1));
    let html = format!(
        "<figure class=\"player\"{} data-width=\"{width}\" data-height=\"{height}\" data-fps=\"{}\"><figcaption>{}</figcaption>\n\
         <div class=\"switches\"><label>Tracer <select>{options}</select></label>\
         <label><input type=\"checkbox\"> error</label><label>Frame <input type=\"range\" min=\"0\" max=\"{last}\" value=\"0\"> \
         <output>0</output></label><button type=\"button\">Play</button></div>\n<div class=\"screen\">{images}</div></figure>\n",
        tags.text(),
        section.fps,
        escape(&title),
    );
    Some(Piece::heavy(Rank::Picture, format!("frames of {title}"), tags, html))
}
