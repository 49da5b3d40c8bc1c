//! Documents as parts of a page: rows and sections know what they belong to, and nothing leads out of the page.

use std::fmt::Write as _;

use pulldown_cmark::html::push_html;
use pulldown_cmark::{Event, HeadingLevel, Options, Parser, Tag, TagEnd};

use super::pieces::{Tags, escape};
use super::read::Names;
use crate::report::chart::Chart;
use crate::report::document::{Block, Document};
use crate::report::sheet::{Cell, Table};

/// Makes of a chart what is in its place: of its name, what it shows, itself and what it belongs to.
pub(super) type Charts<'a> = dyn Fn(&str, &str, &Chart, Tags<'_>) -> String + 'a;

/// A document whose titles begin at a level.
pub(super) fn html(document: &Document, level: usize, names: &Names, charts: &Charts<'_>) -> String {
    let mut html = String::new();
    // Levels of the titles of open sections, with what these belong to.
    let mut open: Vec<(usize, Tags<'_>)> = Vec::new();
    let mut blocks = document.blocks.iter().peekable();
    let mut is_listed = false;
    while let Some(block) = blocks.next() {
        let _ = match block {
            Block::Heading(own, words, of) => {
                close(&mut html, &mut open, *own);
                let tags = Tags { scene: of.scene.as_deref(), rays: of.rays.as_deref(), tracer: None };
                let attributes = tags.text();
                if !attributes.is_empty() {
                    open.push((*own, tags));
                    let _ = write!(html, "<section{attributes}>");
                }
                let level = (own + level - 1).min(6);
                writeln!(html, "<h{level}>{}</h{level}>", inline(words))
            }
            Block::Words(words) => writeln!(html, "<p>{}</p>", inline(words)),
            Block::Item(words) => {
                let begin = if is_listed { "" } else { "<ul>\n" };
                is_listed = matches!(blocks.peek(), Some(Block::Item(_)));
                writeln!(html, "{begin}<li>{}</li>{}", inline(words), if is_listed { "" } else { "\n</ul>" })
            }
            Block::Table(all) => write!(html, "{}", table(all, names)),
            Block::Chart(stem, alt, chart) => {
                let scene = open.iter().rev().find_map(|(_, own)| own.scene);
                let rays = open.iter().rev().find_map(|(_, own)| own.rays);
                write!(html, "{}", charts(stem, alt, chart, Tags { scene, rays, tracer: None }))
            }
        };
    }
    close(&mut html, &mut open, 0);
    html
}

/// A document without charts.
pub(super) fn plain_html(document: &Document, level: usize, names: &Names) -> String {
    html(document, level, names, &|_, _, _, _| String::new())
}

/// Closes sections of titles of this level and below.
fn close(html: &mut String, open: &mut Vec<(usize, Tags<'_>)>, level: usize) {
    while open.pop_if(|(own, _)| *own >= level).is_some() {
        html.push_str("</section>\n");
    }
}

fn table(table: &Table, names: &Names) -> String {
    let headings: Vec<&str> = table.headings().collect();
    // A column of one tracer goes with it.
    let column = |heading: &&str| Tags { tracer: names.tracer(heading), ..Tags::default() }.text();
    let columns: Vec<String> = headings.iter().map(column).collect();
    let mut html = "<div class=\"wide\" tabindex=\"0\"><table>\n<thead><tr>".to_owned();
    for (heading, column) in headings.iter().zip(&columns) {
        let _ = write!(html, "<th scope=\"col\"{column}>{}</th>", inline(heading));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in table.rows() {
        let cells: Vec<(String, &Cell)> = row.map(|cell| (cell.describe(), cell)).collect();
        let _ = write!(
            html,
            "<tr{}>",
            names.of_row(&headings, &cells.iter().map(|(told, _)| told.as_str()).collect::<Vec<_>>()).text()
        );
        for ((told, cell), column) in cells.iter().zip(&columns) {
            let whole = if is_strong(told) { " class=\"whole\"" } else { "" };
            let told = match cell {
                Cell::Name(_) => escape(told),
                Cell::Parts(parts) => bar(told, parts),
                _ => inline(told),
            };
            let _ = write!(html, "<td{column}{whole}>{told}</td>");
        }
        html.push_str("</tr>\n");
    }
    html + "</tbody></table></div>\n"
}

/// Parts of a whole as a bar, the largest beside it in words.
fn bar(told: &str, parts: &[(String, f64, String)]) -> String {
    let words: Vec<String> = told.split(", ").map(escape).collect();
    let part = |((_, share, colour), words): (&(String, f64, String), &String)| {
        format!("<i style=\"width:{:.2}%;background:{colour}\" title=\"{words}\"></i>", share * 100.0)
    };
    let bar: String = parts.iter().zip(&words).map(part).collect();
    let more = if words.len() > 2 { format!("; {} more", words.len() - 2) } else { String::new() };
    let most = words[..words.len().min(2)].join("; ");
    format!("<span class=\"bar\" role=\"img\" aria-label=\"{}\">{bar}</span><small>{most}{more}</small>", escape(told))
}

/// Whether all of a cell is strong: so stands what is best; words within a cell that are strong warn.
fn is_strong(cell: &str) -> bool {
    let inner = cell.strip_prefix("**").and_then(|rest| rest.strip_suffix("**"));
    inner.is_some_and(|inner| !inner.contains("**"))
}

/// Words with what is strong, emphasised or code in them; all else is text.
pub(super) fn inline(words: &str) -> String {
    let mut html = String::new();
    let mut rest = words;
    while let Some(at) = rest.find(['*', '`', '\\', '&']) {
        let (text, mark) = rest.split_at(at);
        html += &escape(text);
        rest = mark;
        // What a mark encloses, where it ends again behind at least a letter.
        let enclosed = |mark: &str| {
            let inner = rest.strip_prefix(mark)?;
            let end = inner.find(mark).filter(|_| !inner.starts_with(char::is_whitespace))?;
            (end > 0).then(|| (&inner[..end], &inner[end + mark.len()..]))
        };
        let escaped = rest.strip_prefix('\\').filter(|next| next.starts_with(|c: char| c.is_ascii_punctuation()));
        let entity = ["&lt;", "&amp;"].into_iter().find(|entity| rest.starts_with(entity));
        if let Some((inner, behind)) = enclosed("**") {
            let _ = write!(html, "<strong>{}</strong>", inline(inner));
            rest = behind;
        } else if let Some((inner, behind)) = enclosed("*") {
            let _ = write!(html, "<em>{}</em>", inline(inner));
            rest = behind;
        } else if let Some((inner, behind)) = enclosed("`") {
            let _ = write!(html, "<code>{}</code>", escape(inner));
            rest = behind;
        } else {
            // A name's own signs stand for themselves.
            let length = entity.map_or(1, str::len);
            let from = usize::from(escaped.is_some());
            html += &entity.map_or_else(|| escape(&rest[from..from + 1]), str::to_owned);
            rest = &rest[from + length..];
        }
    }
    html + &escape(rest)
}

/// The rules, which are Markdown, with titles from the third level on: without links, of which the words stay.
pub(super) fn rules(text: &str) -> String {
    let lower = |level: HeadingLevel| HeadingLevel::try_from((level as usize + 2).min(6)).unwrap_or(HeadingLevel::H6);
    let events = Parser::new_ext(text, Options::ENABLE_TABLES).filter_map(|event| match event {
        Event::Html(_) | Event::InlineHtml(_) | Event::Start(Tag::Link { .. }) | Event::End(TagEnd::Link) => None,
        Event::Start(Tag::Heading { level, id, classes, attrs }) => {
            Some(Event::Start(Tag::Heading { level: lower(level), id, classes, attrs }))
        }
        Event::End(TagEnd::Heading(level)) => Some(Event::End(TagEnd::Heading(lower(level)))),
        other => Some(other),
    });
    let mut html = String::new();
    push_html(&mut html, events);
    html
}

/// What a chart shows, and of what.
pub(super) fn caption(what: &str, tags: Tags<'_>, machine: &str) -> String {
    let of: Vec<&str> = [tags.scene, tags.rays].into_iter().flatten().collect();
    let of = if of.is_empty() { String::new() } else { format!("{}: ", of.join(", ")) };
    format!("{of}{what}. {machine}.")
}

/// A chart with what it shows in words, for those who do not see it.
pub(super) fn figure(svg: &str, alt: &str, caption: &str, tags: Tags<'_>) -> String {
    let said = format!("<svg role=\"img\" aria-label=\"{}\" ", escape(alt));
    let svg = svg.replacen("<svg ", &said, 1);
    let tags = tags.text();
    format!("<figure{tags}><div class=\"chart\">{svg}</div><figcaption>{}</figcaption></figure>\n", escape(caption))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::chart::series::{SeriesChart, series};
    use crate::report::document::Of;
    use crate::report::fixture;
    use crate::report::sheet::Sheet;

    fn names() -> Names {
        Names {
            scenes: vec!["<b>hall".to_owned(), "room".to_owned()],
            rays: vec!["ao".to_owned(), "diffuse".to_owned()],
            tracers: vec!["bvh".to_owned(), "bvh-gpu".to_owned()],
        }
    }

    fn cells(headings: &[&str], rows: &[&[&str]]) -> Table {
        let column = |sheet: Sheet<'static, Vec<String>>, (place, heading): (usize, &&str)| {
            sheet.column(*heading, move |row: &Vec<String>| row[place].clone())
        };
        let rows: Vec<Vec<String>> =
            rows.iter().map(|row| row.iter().map(|cell| (*cell).to_owned()).collect()).collect();
        headings.iter().enumerate().fold(Sheet::new(), column).table(&rows)
    }

    /// Rows and columns belong to tracers, sections to scenes and ray sets, each until the next title of its level.
    #[test]
    fn parts_know_what_they_belong_to() {
        let page = Document::default()
            .headed(2, "room (12 triangles)", Of { scene: Some("room".to_owned()), rays: None })
            .rays(3, "diffuse", "diffuse: closest hit")
            .table(cells(&["tracer", "1"], &[&["bvh-gpu:improved a=1", "2"], &["other", "3"]]))
            .heading(2, "Skipped")
            .table(cells(&["case", "bvh"], &[&["x", "y"]]));
        let html = plain_html(&page, 3, &names());
        assert!(html.contains("<section data-scene=\"room\"><h4>room (12 triangles)</h4>"), "{html}");
        assert!(html.contains("<section data-rays=\"diffuse\"><h5>"), "{html}");
        assert!(html.contains("<tr data-tracer=\"bvh-gpu\"><td>bvh-gpu:improved a=1</td>"), "{html}");
        assert!(html.contains("<tr><td>other</td>") && html.contains("<td data-tracer=\"bvh\">y</td>"), "{html}");
        assert!(html.find("</section>\n</section>\n<h4>Skipped").is_some(), "{html}");
        assert_eq!(html.matches("<section").count(), html.matches("</section>").count());
    }

    /// Cells that are strong as a whole are told from those with strong words in them.
    #[test]
    fn warnings_are_not_what_is_best() {
        let html = table(&cells(&["a", "b", "c"], &[&["**1**", "2 (**few**)", "**3** or **4**"]]), &names());
        let cells =
            "<td class=\"whole\"><strong>1</strong></td><td>2 (<strong>few</strong>)</td><td><strong>3</strong>";
        assert!(html.contains(cells), "{html}");
    }

    /// Neither raw HTML nor links nor pictures of elsewhere come through, whatever a name or a reason says; marks that enclose nothing
    /// are text, and so is what is escaped. Of the rules links keep their words alone.
    #[test]
    fn nothing_leads_out() {
        let hostile = "<script>alert(1)</script> <img src=x onerror=y> [b](https://c.d) ![e](https://f.g/h.png) **k**";
        let [title, subtitle] = [const { String::new() }; 2];
        let chart = SeriesChart { title, subtitle, key: None, panels: Vec::new() };
        let page = Document::of(hostile)
            .chart("j", "i", series(&fixture::typical(), chart))
            .items([hostile.to_owned()])
            .table(cells(&["scene"], &[&["<b>hall"]]));
        let html = html(&page, 3, &names(), &|stem, alt, _, _| format!("[{stem} {alt}]"));
        assert!(!html.contains("<script") && !html.contains("<img") && !html.contains("<a "), "{html}");
        assert!(html.contains("&lt;script&gt;") && html.contains("<strong>k</strong>") && html.contains("[j i]"));
        assert!(html.contains("<tr data-scene=\"&lt;b&gt;hall\">"), "{html}");
        let literal = crate::report::markdown::literal("a*b*_c & <d>");
        for (words, wanted) in [
            (literal.as_str(), "a*b*_c &amp; &lt;d&gt;"),
            ("24 * and 2 ** 3", "24 * and 2 ** 3"),
            ("`a*b*` *c* \\", "<code>a*b*</code> <em>c</em> \\"),
        ] {
            assert_eq!(inline(words), wanted);
        }
        let rules = rules("# A\n\n[b](https://c.d) <!--e--> **f**\n");
        assert_eq!(rules.trim(), "<h3>A</h3>\n<p>b  <strong>f</strong></p>");
    }
}
