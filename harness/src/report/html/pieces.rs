//! What a page is put together from, and what is left out of it where it would grow too large.

use std::fmt::Write as _;

use itertools::Itertools as _;

pub(super) use crate::report::format::escape;

/// What is kept first where there is no room for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    Front,
    /// Pages and tables that answer what was asked.
    Page,
    /// Charts that go with them.
    Chart,
    /// Pictures of answers.
    Picture,
    /// Everything that was measured, in full.
    Full,
}

/// A part of a page.
#[derive(Debug)]
pub(super) struct Piece {
    /// Of those that may be left out, which goes first; none of one that is always there.
    pub rank: Option<Rank>,
    /// What it is, for people.
    pub what: String,
    /// What it belongs to, as attributes.
    tags: String,
    /// The part.
    pub html: String,
}

impl Piece {
    /// One that is always there.
    pub(super) fn fixed(html: impl Into<String>) -> Self {
        Self { rank: None, what: String::new(), tags: String::new(), html: html.into() }
    }

    /// One that may be left out.
    pub(super) fn heavy(rank: Rank, what: impl Into<String>, tags: Tags<'_>, html: String) -> Self {
        Self { rank: Some(rank), what: what.into(), tags: tags.text(), html }
    }
}

/// What a part belongs to, as attributes: who leaves it out leaves the part out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tags<'a> {
    pub scene: Option<&'a str>,
    pub rays: Option<&'a str>,
    pub tracer: Option<&'a str>,
}

impl<'a> Tags<'a> {
    /// Of a tracer alone.
    pub(super) fn of_tracer(tracer: &'a str) -> Self {
        Self { tracer: Some(tracer), ..Self::default() }
    }

    /// As attributes, each after a blank.
    pub(super) fn text(self) -> String {
        let tags = [("scene", self.scene), ("rays", self.rays), ("tracer", self.tracer)].into_iter();
        tags.filter_map(|(name, value)| Some(format!(" data-{name}=\"{}\"", escape(value?)))).collect()
    }
}

/// Bytes that the note on a part that was left out may take, besides what it names twice.
const NOTE: usize = 160;

/// Puts parts together in at most so many bytes, and tells what was left out: of the last rank first, and there what would be too much.
/// Fixed parts are always there.
pub(super) fn fit(pieces: &[Piece], most: usize) -> (String, Vec<String>) {
    let fixed = |Piece { rank, what, tags, html }: &Piece| match rank {
        None => html.len(),
        Some(_) => NOTE + tags.len() + 2 * escape(what).len(),
    };
    let mut room = most.saturating_sub(pieces.iter().map(fixed).sum());
    let mut kept = vec![true; pieces.len()];
    let heavy = pieces.iter().enumerate().filter(|(_, piece)| piece.rank.is_some());
    for (place, piece) in heavy.sorted_by_key(|(_, piece)| piece.rank) {
        kept[place] = piece.html.len() <= room;
        room -= if kept[place] { piece.html.len() } else { 0 };
    }
    let (mut page, mut dropped) = (String::new(), Vec::new());
    for (Piece { what, tags, html, .. }, kept) in pieces.iter().zip(kept) {
        if kept {
            page.push_str(html);
        } else {
            let _ = writeln!(page, "<p class=\"dropped\"{tags}>Left out for want of room: {}.</p>", escape(what));
            dropped.push(format!("{what} ({} kB)", html.len().div_ceil(1000)));
        }
    }
    (page, dropped)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proves that parts of the last rank go first, that the rest stays in its order, that what goes is told, and that the limit holds.
    #[test]
    fn what_matters_least_goes_first() {
        let heavy = |rank, what: &str| {
            let tags = Tags { scene: Some("a\"b"), ..Tags::default() };
            Piece::heavy(rank, what, tags, format!("<i>{}</i>", what.repeat(300)))
        };
        let pieces = [
            Piece::fixed("<p>head</p>"),
            heavy(Rank::Full, "f"),
            heavy(Rank::Front, "w"),
            heavy(Rank::Chart, "c"),
            Piece::fixed("<p>foot</p>"),
        ];
        let (whole, dropped) = fit(&pieces, 10_000);
        assert!(dropped.is_empty() && whole.len() < 1000 && whole.contains("www") && whole.ends_with("<p>foot</p>"));
        let (page, dropped) = fit(&pieces, 1400);
        assert!(page.len() <= 1400 && page.contains("www") && !page.contains("fff"), "{page}");
        assert_eq!(dropped, ["f (1 kB)"]);
        assert!(page.contains("data-scene=\"a&quot;b\">Left out"));
        let (page, dropped) = fit(&pieces, 0);
        assert!(dropped.len() == 3 && page.starts_with("<p>head</p>") && page.ends_with("<p>foot</p>"));
    }

    /// Nothing of a text is markup.
    #[test]
    fn text_is_text() {
        assert_eq!(escape("<a href='\u{1}\">&"), "&lt;a href=&#39;\u{fffd}&quot;&gt;&amp;");
    }
}
