//! Pictures of what points on fronts answer: truth, answer, class and error in one place, switched there. They are files beside the
//! record; where one is missing or is not what its name says, it is not shown.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use data_encoding::BASE64;
use tracebench_api::Query;

use super::Place;
use super::pieces::{Piece, Rank, Tags, escape};
use crate::render::painted::{ERROR_DECADES, class_legend};
use crate::report::format::significant;
use crate::report::kept::{self, Kept};
use crate::results::{PointPictures, Record, SetPictures};

/// Names of what can be shown of a point, beside truth.
const OF_A_POINT: [&str; 3] = ["answer", "class", "error"];

/// A part for each scene and ray set that has pictures.
pub(super) fn pictures(places: &[Place<'_>], machines: &[String]) -> Vec<Piece> {
    let piece = |(number, place): (usize, &Place<'_>)| {
        let set = place.shown.fronts.scene.pictures.iter().find(|set| set.rays == place.field.rays)?;
        Some(Piece::Heavy {
            rank: Rank::Picture,
            what: format!("pictures of {}", place.title()),
            html: figure(number, place, set, &machines[place.read.machine - 1])?,
            tags: place.tags().text(),
        })
    };
    places.iter().enumerate().filter_map(piece).chain(others(places)).collect()
}

/// A file beside a record as an address that holds it, if it is what its name says.
pub(super) fn address(record: &str, name: &str) -> Option<String> {
    match kept::picture(Path::new(record), name) {
        Kept::Picture(bytes) => Some(format!("data:image/png;base64,{}", BASE64.encode(&bytes))),
        _ => None,
    }
}

/// A word on files that are not the pictures after which they are named.
fn others(places: &[Place<'_>]) -> Option<Piece> {
    let records: BTreeMap<&str, &Record> = places.iter().map(|place| (place.read.path, &*place.read.record)).collect();
    let all: BTreeSet<String> =
        records.into_iter().flat_map(|(path, record)| kept::others(Path::new(path), record)).collect();
    let names: Vec<String> = all.iter().map(|name| format!("<code>{}</code>", escape(name))).collect();
    let text = format!(
        "<p>Left out, since these files are not the pictures that the record names: {}.</p>\n",
        names.join(", ")
    );
    (!names.is_empty()).then_some(Piece::Fixed(text))
}

fn figure(number: usize, place: &Place<'_>, set: &SetPictures, machine: &str) -> Option<String> {
    let address = |name: &str| address(place.read.path, name);
    let image = |what: &str, tags: &str, alt: &str, source: &str| {
        let [width, height] = set.size;
        let alt = escape(alt);
        format!(
            "<img data-what=\"{what}\"{tags} width=\"{width}\" height=\"{height}\" alt=\"{alt}\" src=\"{source}\">\n"
        )
    };
    let title = place.title();
    let mut images = image("truth", "", &format!("Truth: {title}"), &address(&set.truth)?);
    let mut options = String::new();
    for PointPictures { point, answer, class, error } in &set.points {
        let known = place.section.points.get(*point)?;
        let label = known.label();
        let files = [Some(answer), Some(class), error.as_ref()];
        let found: Vec<Option<String>> = files.iter().map(|name| name.and_then(|name| address(name))).collect();
        if found.iter().zip(files).any(|(found, name)| found.is_none() && name.is_some()) {
            continue;
        }
        let tracer = Tags { tracer: Some(&known.tracer), ..Tags::default() }.text();
        let _ = writeln!(options, "<option value=\"{point}\"{tracer}>{}</option>", escape(&label));
        for (what, source) in OF_A_POINT.iter().zip(found) {
            let tags = format!(" data-of=\"{point}\"{tracer}");
            images += &source
                .map_or_else(String::new, |source| image(what, &tags, &format!("{what} of {label}: {title}"), &source));
        }
    }
    if options.is_empty() {
        return None;
    }
    let whats =
        std::iter::once("truth").chain(OF_A_POINT.into_iter().take(if set.query == Query::Any { 2 } else { 3 }));
    let choice = |what: &str| {
        let held_out = if what == "class" { " checked" } else { "" };
        format!("<label><input type=\"radio\" name=\"picture-{number}\" value=\"{what}\"{held_out}> {what}</label>")
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
        escape(machine),
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
