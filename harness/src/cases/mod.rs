//! Minimal scenes with one difficulty each and a difficulty parameter for its strength.
//!
//! What is told of a case is data, `cases.json`; how it is drawn, and what of its rays shows the difficulty, is in a module of its kind.

mod eye;
mod frames;
mod grids;
mod many;
mod probe;
mod reported;
mod screen;
mod sketch;
mod small;
mod surfaces;

use std::sync::LazyLock;

use serde::Deserialize;
use tracebench_api::{Geometry, Query, Ray, Viewpoint};

pub use probe::Probe;
use sketch::Sketch;

use crate::registrations::embedded;
use crate::results::DifficultyParameterRecord;

/// A difficulty parameter's name with its unit, if it has one.
pub(crate) fn label(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
}

/// A case at one strength.
pub struct Setup {
    /// Its triangles, in host memory.
    pub geometry: Geometry,
    /// Where it is seen from, with resolutions.
    pub viewpoint: Viewpoint,
    /// Its rays, the same on every run.
    pub rays: Vec<Ray>,
    /// What is asked of them.
    pub query: Query,
}

/// A minimal scene with one difficulty: an entry of `cases.json`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Stable name.
    pub name: &'static str,
    /// What it is, in one line.
    pub summary: &'static str,
    /// What makes it harder.
    pub difficulty_parameter: DifficultyParameterRecord,
    /// What tells its random numbers from those of other cases.
    seed: u64,
    /// What rays must have to show the difficulty, in words.
    pub feature: &'static str,
    /// Least share of all rays that must have it at the hardest strength: else the case would measure nothing.
    pub min_featured: f64,
}

/// A case by name: how it is drawn at a value of its difficulty parameter, and whether a ray has its feature.
type Drawn = (&'static str, fn(&mut Sketch, f64), fn(&Probe<'_>, usize) -> bool);

static DRAWN: [&[Drawn]; 8] = [
    eye::DRAWN,
    frames::DRAWN,
    grids::DRAWN,
    many::DRAWN,
    reported::DRAWN,
    screen::DRAWN,
    small::DRAWN,
    surfaces::DRAWN,
];

impl Case {
    fn drawn(&self) -> &'static Drawn {
        DRAWN.into_iter().flatten().find(|(name, ..)| *name == self.name).expect("tests draw every case")
    }

    /// The scene at a value of the difficulty parameter.
    pub fn setup(&self, value: f64) -> Setup {
        let mut sketch = Sketch::new(self.seed);
        self.drawn().1(&mut sketch, value);
        sketch.setup()
    }

    /// Whether a ray has the feature.
    pub fn shows(&self, probe: &Probe<'_>, ray: usize) -> bool {
        self.drawn().2(probe, ray)
    }
}

/// Every case, in the order of tables.
pub static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| embedded(include_str!("cases.json")));

/// Finds a case by name.
pub fn find(name: &str) -> Option<&'static Case> {
    CASES.iter().find(|case| case.name == name)
}
