//! The pages of records, which are Markdown, as HTML: without raw HTML and without links, with rows and sections that know what they
//! belong to.

use std::fmt::Write as _;

use pulldown_cmark::html::push_html;
use pulldown_cmark::{Event, HeadingLevel, Options, Parser, Tag, TagEnd};

use super::pieces::{Tags, escape};
use super::read::Names;

/// Makes of a picture what stands in its place, of where it lies, what it shows and what it belongs to.
pub(super) type Pictures<'a> = dyn Fn(&str, &str, Tags<'_>) -> String + 'a;

/// A page whose titles begin at a level.
pub(super) fn html(text: &str, level: usize, names: &Names, pictures: &Pictures<'_>) -> String {
    let parser = Parser::new_ext(text, Options::ENABLE_TABLES);
    let events: Vec<Event<'_>> = parser.map(plain).collect();
    let mut page = Page { level, names, pictures, html: String::new(), open: Vec::new() };
    page.take(&events);
    page.close(0);
    page.html
}

/// A page without pictures.
pub(super) fn plain_html(text: &str, level: usize, names: &Names) -> String {
    html(text, level, names, &|_, _, _| String::new())
}

/// Raw HTML is text: records may name a scene as they like.
fn plain(event: Event<'_>) -> Event<'_> {
    match event {
        Event::Html(text) | Event::InlineHtml(text) => Event::Text(text),
        Event::Start(Tag::HtmlBlock) => Event::Start(Tag::Paragraph),
        Event::End(TagEnd::HtmlBlock) => Event::End(TagEnd::Paragraph),
        other => other,
    }
}

struct Page<'a> {
    level: usize,
    names: &'a Names,
    pictures: &'a Pictures<'a>,
    html: String,
    /// Levels of the titles of open sections, with what these belong to.
    open: Vec<(usize, Tags<'a>)>,
}

impl Page<'_> {
    fn take(&mut self, events: &[Event<'_>]) {
        let mut place = 0;
        while place < events.len() {
            let rest = &events[place..];
            place += match &rest[0] {
                Event::Start(Tag::Table(_)) => self.table(rest),
                Event::Start(Tag::Heading { level, .. }) => self.title(*level, rest),
                Event::Start(Tag::Paragraph) if matches!(rest.get(1), Some(Event::Start(Tag::Image { .. }))) => {
                    self.picture(rest)
                }
                _ => {
                    let until = rest.iter().position(is_block).unwrap_or(rest.len()).max(1);
                    push_html(&mut self.html, inline(&rest[..until]));
                    until
                }
            };
        }
    }

    fn picture(&mut self, events: &[Event<'_>]) -> usize {
        let end = end_of(events, |end| matches!(end, TagEnd::Paragraph));
        if let Some(Event::Start(Tag::Image { dest_url, .. })) = events.get(1) {
            let tags = self.open.iter().fold(Tags::default(), |all, (_, own)| own.or(all));
            self.html += &(self.pictures)(dest_url, &text_of(&events[1..end]), tags);
        }
        end + 1
    }

    /// Closes sections of titles of this level and below.
    fn close(&mut self, level: usize) {
        while self.open.last().is_some_and(|(open, _)| *open >= level) {
            self.open.pop();
            self.html.push_str("</section>\n");
        }
    }

    fn title(&mut self, level: HeadingLevel, events: &[Event<'_>]) -> usize {
        let end = end_of(events, |end| matches!(end, TagEnd::Heading(_)));
        let level = level as usize;
        self.close(level);
        let own = self.names.of_title(&text_of(&events[1..end]));
        let tags = own.text();
        if !tags.is_empty() {
            self.open.push((level, own));
            let _ = write!(self.html, "<section{tags}>");
        }
        let level = (level + self.level - 1).min(6);
        let _ = write!(self.html, "<h{level}>");
        push_html(&mut self.html, inline(&events[1..end]));
        let _ = writeln!(self.html, "</h{level}>");
        end + 1
    }

    fn table(&mut self, events: &[Event<'_>]) -> usize {
        let end = end_of(events, |end| matches!(end, TagEnd::Table));
        let mut rows: Vec<Vec<&[Event<'_>]>> = Vec::new();
        let mut begin = 0;
        for (place, event) in events[..end].iter().enumerate() {
            match event {
                Event::Start(Tag::TableHead | Tag::TableRow) => rows.push(Vec::new()),
                Event::Start(Tag::TableCell) => begin = place + 1,
                Event::End(TagEnd::TableCell) => {
                    if let Some(row) = rows.last_mut() {
                        row.push(&events[begin..place]);
                    }
                }
                _ => {}
            }
        }
        let Some((head, body)) = rows.split_first() else { return end + 1 };
        let headings: Vec<String> = head.iter().map(|cell| text_of(cell)).collect();
        // A column of one tracer goes with it.
        let columns: Vec<String> = headings.iter().map(|heading| self.names.of_column(heading).text()).collect();
        self.html.push_str("<div class=\"wide\" tabindex=\"0\"><table>\n<thead><tr>");
        for (cell, column) in head.iter().zip(&columns) {
            let _ = write!(self.html, "<th scope=\"col\"{column}>");
            push_html(&mut self.html, inline(cell));
            self.html.push_str("</th>");
        }
        self.html.push_str("</tr></thead>\n<tbody>\n");
        for row in body {
            let cells: Vec<String> = row.iter().map(|cell| text_of(cell)).collect();
            let _ = write!(self.html, "<tr{}>", self.names.of_row(&headings, &cells).text());
            for (cell, column) in row.iter().zip(&columns) {
                let whole = if is_strong(cell) { " class=\"whole\"" } else { "" };
                let _ = write!(self.html, "<td{column}{whole}>");
                push_html(&mut self.html, inline(cell));
                self.html.push_str("</td>");
            }
            self.html.push_str("</tr>\n");
        }
        self.html.push_str("</tbody></table></div>\n");
        end + 1
    }
}

/// Whether all of a cell is strong: so stands what is best; words within a cell that are strong warn.
fn is_strong(cell: &[Event<'_>]) -> bool {
    let end = cell.iter().position(|event| matches!(event, Event::End(TagEnd::Strong)));
    matches!(cell.first(), Some(Event::Start(Tag::Strong))) && end == Some(cell.len() - 1)
}

fn is_block(event: &Event<'_>) -> bool {
    matches!(event, Event::Start(Tag::Table(_) | Tag::Heading { .. } | Tag::Paragraph))
}

/// The place of the end of what the first event begins.
fn end_of(events: &[Event<'_>], is_end: impl Fn(&TagEnd) -> bool) -> usize {
    let found = events.iter().position(|event| matches!(event, Event::End(end) if is_end(end)));
    found.unwrap_or(events.len() - 1)
}

/// Events without links and pictures, of which the words stay: nothing leads out of a page.
fn inline<'a>(events: &'a [Event<'a>]) -> impl Iterator<Item = Event<'a>> {
    let leads_out = |event: &&Event<'_>| {
        let start = matches!(event, Event::Start(Tag::Link { .. } | Tag::Image { .. }));
        !start && !matches!(event, Event::End(TagEnd::Link | TagEnd::Image))
    };
    events.iter().filter(leads_out).cloned()
}

/// The words of events.
fn text_of(events: &[Event<'_>]) -> String {
    let word = |event: &Event<'_>| match event {
        Event::Text(text) | Event::Code(text) => text.to_string(),
        Event::SoftBreak | Event::HardBreak => " ".to_owned(),
        _ => String::new(),
    };
    events.iter().map(word).collect()
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

    fn names() -> Names {
        Names {
            scenes: vec!["<b>hall".to_owned(), "room".to_owned()],
            rays: vec!["ao".to_owned(), "diffuse".to_owned()],
            tracers: vec!["bvh".to_owned(), "bvh-gpu".to_owned()],
        }
    }

    /// Rows and columns belong to tracers, sections to scenes and ray sets, each until the next title of its level.
    #[test]
    fn parts_know_what_they_belong_to() {
        let text = "## room (12 triangles)\n\n### diffuse: closest hit\n\n| tracer | 1 |\n| --- | --- |\n| bvh-gpu:improved a=1 | 2 |\n\
                    | other | 3 |\n\n## Skipped\n\n| case | bvh |\n| --- | --- |\n| x | y |\n";
        let html = plain_html(text, 3, &names());
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
        let text = "| a | b | c |\n| --- | --- | --- |\n| **1** | 2 (**few**) | **3** or **4** |\n";
        let html = plain_html(text, 3, &names());
        let cells =
            "<td class=\"whole\"><strong>1</strong></td><td>2 (<strong>few</strong>)</td><td><strong>3</strong>";
        assert!(html.contains(cells), "{html}");
    }

    /// Neither raw HTML nor links nor pictures of elsewhere come through.
    #[test]
    fn nothing_leads_out() {
        let text = "<script>alert(1)</script>\n\na <img src=x onerror=y> [b](https://c.d) ![e](https://f.g/h.png) **k**\n\n\
                    ![i](j.svg)\n\n| scene |\n| --- |\n| &lt;b>hall |\n";
        let html = html(text, 3, &names(), &|place, alt, _| format!("[{place} {alt}]"));
        assert!(
            !html.contains("<script") && !html.contains("<img") && !html.contains("href") && !html.contains("http")
        );
        assert!(html.contains("&lt;script&gt;") && html.contains("<strong>k</strong>") && html.contains("[j.svg i]"));
        assert!(html.contains("<tr data-scene=\"&lt;b&gt;hall\">"), "{html}");
    }
}
