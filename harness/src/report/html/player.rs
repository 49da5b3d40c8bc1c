//! Frames as they were rendered: one frame of truth, answer or error at a time. The sheets of all frames are files beside the record; where
//! one is missing or is not what its name says, it is not shown.

use std::fmt::Write as _;

use super::pictures::address;
use super::pieces::{Piece, Rank, Tags, escape};
use super::read::Read;
use crate::results::{FramePictures, FramesRecord};

/// A player for each scene and effect that has pictures.
pub(super) fn players(all: &[Read<'_>]) -> Vec<Piece> {
    let of_record = |read: &Read<'_>| {
        let section = read.record.frames.as_ref()?;
        let each = (0..section.scenes.len()).flat_map(|scene| section.works.iter().map(move |work| (scene, work)));
        Some(each.filter_map(|(scene, work)| player(read.path, section, scene, work)).collect::<Vec<_>>())
    };
    all.iter().filter_map(of_record).flatten().collect()
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
        let label = row.tracer.label();
        let tracer = Tags { tracer: Some(&row.tracer.name), ..Tags::default() }.text();
        let alt = format!("{label}: {title}, all frames, each above its error");
        if let Some(image) = sheet(record, pictures, &format!(" data-of=\"{place}\"{tracer}"), 2, &alt) {
            images += &image;
            let _ = write!(options, "<option value=\"{place}\"{tracer}>{}</option>", escape(&label));
        }
    }
    let tags = Tags { scene: Some(&moving.scene.name), rays: Some(work), tracer: None }.text();
    let ([width, height], last) = (section.size, section.frames.saturating_sub(1));
    let html = format!(
        "<figure class=\"player\"{tags} data-width=\"{width}\" data-height=\"{height}\" data-fps=\"{}\"><figcaption>{}</figcaption>\n\
         <div class=\"switches\"><label>Tracer <select>{options}</select></label>\
         <label><input type=\"checkbox\"> error</label><label>Frame <input type=\"range\" min=\"0\" max=\"{last}\" value=\"0\"> \
         <output>0</output></label><button type=\"button\">Play</button></div>\n<div class=\"screen\">{images}</div></figure>\n",
        section.fps,
        escape(&title),
    );
    Some(Piece::Heavy { rank: Rank::Picture, what: format!("frames of {title}"), html, tags })
}
