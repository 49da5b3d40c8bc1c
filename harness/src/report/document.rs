//! A document as data: what is said of a record, for every writer.
//!
//! Words may hold `**strong**`, `*emphasis*` and `` `code` ``. Names that were not written here go through [`literal`]; all else that is
//! markup in a format its writer escapes.

use tracebench_api::Query;

use super::chart::Chart;
use super::format::{self, thousands};
use super::markdown::literal;
use super::sheet::Table;
use crate::results::SceneRecord;

/// A part of a document.
#[derive(Debug)]
pub(crate) enum Block {
    /// A heading with its level, 1 for the title, and what is below it.
    Heading(usize, String, Of),
    Words(String),
    Item(String),
    Table(Table),
    /// A chart: its file without the end, what it shows, and itself.
    Chart(String, String, Chart),
}

/// What a part belongs to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Of {
    pub scene: Option<String>,
    pub rays: Option<String>,
}

/// A document.
#[derive(Debug, Default)]
pub struct Document {
    pub(crate) blocks: Vec<Block>,
}

impl Document {
    /// One that begins with a title.
    pub(crate) fn titled(title: &str) -> Self {
        Self::default().heading(1, title)
    }

    /// One of a paragraph.
    pub(crate) fn of(words: impl Into<String>) -> Self {
        Self::default().paragraph(words)
    }

    /// Its title.
    pub(crate) fn title(&self) -> Option<&str> {
        self.blocks
            .iter()
            .find_map(|block| if let Block::Heading(1, title, _) = block { Some(title.as_str()) } else { None })
    }

    /// With a further block.
    fn block(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    /// With a heading of what it belongs to.
    pub(crate) fn headed(self, level: usize, words: impl Into<String>, of: Of) -> Self {
        self.block(Block::Heading(level, words.into(), of))
    }

    /// With a heading.
    pub(crate) fn heading(self, level: usize, words: impl Into<String>) -> Self {
        self.headed(level, words, Of::default())
    }

    /// With the heading of a scene.
    pub(crate) fn scene(self, level: usize, scene: &SceneRecord, more: &str) -> Self {
        let words = format!("{} ({} triangles){more}", literal(&scene.name), thousands(scene.triangles));
        self.headed(level, words, Of { scene: Some(scene.name.clone()), rays: None })
    }

    /// With the heading of rays.
    pub(crate) fn rays(self, level: usize, rays: &str, words: impl Into<String>) -> Self {
        self.headed(level, words, Of { scene: None, rays: Some(rays.to_owned()) })
    }

    /// With a paragraph, where there are any words.
    pub(crate) fn paragraph(self, words: impl Into<String>) -> Self {
        let words = words.into();
        if words.is_empty() { self } else { self.block(Block::Words(words)) }
    }

    /// With paragraphs.
    pub(crate) fn paragraphs(self, all: impl IntoIterator<Item = String>) -> Self {
        all.into_iter().fold(self, Self::paragraph)
    }

    /// With items of a list.
    pub(crate) fn items(self, all: impl IntoIterator<Item = String>) -> Self {
        all.into_iter().fold(self, |page, item| page.block(Block::Item(item)))
    }

    /// With a table.
    pub(crate) fn table(self, table: Table) -> Self {
        self.block(Block::Table(table))
    }

    /// With a table below some words, where it has rows.
    pub(crate) fn below(self, words: impl Into<String>, table: Table) -> Self {
        if table.is_empty() { self } else { self.paragraph(words).table(table) }
    }

    /// With a chart.
    pub(crate) fn chart(self, stem: impl Into<String>, alt: impl Into<String>, chart: Chart) -> Self {
        self.block(Block::Chart(stem.into(), alt.into(), chart))
    }

    /// Its charts.
    pub(crate) fn charts(&self) -> impl Iterator<Item = (&str, &Chart)> {
        self.blocks
            .iter()
            .filter_map(|block| if let Block::Chart(stem, _, chart) = block { Some((&**stem, chart)) } else { None })
    }

    /// With what others have.
    pub(crate) fn and(mut self, others: impl IntoIterator<Item = Self>) -> Self {
        self.blocks.extend(others.into_iter().flat_map(|other| other.blocks));
        self
    }
}

/// So that one may be given where several may be.
impl IntoIterator for Document {
    type Item = Self;
    type IntoIter = std::iter::Once<Self>;

    fn into_iter(self) -> Self::IntoIter {
        std::iter::once(self)
    }
}

/// What pages call rays.
pub(crate) fn set_heading(name: &str, query: Query, count: u64) -> String {
    format!("{name}: {}, {} rays", format::query(query), thousands(count))
}
