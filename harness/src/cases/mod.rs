//! Minimal scenes with one difficulty each and a difficulty parameter for its strength.
//!
//! A case is data: [`CASES`] has all of them.

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

use tracebench_api::{Geometry, Query, Ray, Viewpoint};

pub use probe::Probe;
use sketch::Sketch;

/// What makes a case harder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DifficultyParameter {
    /// What is turned.
    pub name: &'static str,
    /// Unit; empty for counts and ratios.
    pub unit: &'static str,
    /// Its values from harmless to hard, rising or falling.
    pub values: &'static [f64],
}

const fn turned(name: &'static str, unit: &'static str, values: &'static [f64]) -> DifficultyParameter {
    DifficultyParameter { name, unit, values }
}

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

/// What a share of the rays must have at the hardest strength: else the case would measure nothing.
#[derive(Clone, Copy)]
pub struct Feature {
    /// What, in words.
    pub what: &'static str,
    /// Least share of all rays.
    pub least: f64,
    /// Whether a ray has it.
    pub has: fn(&Probe<'_>, usize) -> bool,
}

impl Feature {
    const fn of(what: &'static str, least: f64, has: fn(&Probe<'_>, usize) -> bool) -> Self {
        Self { what, least, has }
    }
}

/// A minimal scene with one difficulty.
#[derive(Clone, Copy)]
pub struct Case {
    /// Stable name.
    pub name: &'static str,
    /// What it is, in one line.
    pub summary: &'static str,
    /// What makes it harder.
    pub difficulty_parameter: DifficultyParameter,
    /// What tells its random numbers from those of other cases.
    seed: u64,
    /// Draws it at a value of the difficulty parameter.
    make: fn(&mut Sketch, f64),
    /// What shows the difficulty.
    pub feature: Feature,
}

impl Case {
    /// The scene at a value of the difficulty parameter.
    pub fn setup(&self, value: f64) -> Setup {
        let mut sketch = Sketch::new(self.seed);
        (self.make)(&mut sketch, value);
        sketch.setup()
    }
}

/// Every case, in the order of tables.
pub const CASES: &[Case] = &[
    surfaces::EDGE_ON,
    small::WIRES,
    small::LEAVES,
    surfaces::SHEETS,
    many::VOXEL,
    surfaces::OPEN_MESH,
    surfaces::HUGE,
    surfaces::NEEDLES,
    surfaces::COPLANAR,
    eye::INSIDE,
    eye::ON_SURFACE,
    eye::PLANE_THROUGH_EYE,
    eye::AT_VERTEX,
    eye::BEFORE_NEAR,
    frames::CUBE_BORDERS,
    eye::DEPTH_RANGE,
    eye::SECONDARY_DEPTH_RATIO,
    frames::COARSE_FRAME,
    frames::WIDE_FRAME,
    frames::SURFACE_STARTS,
    frames::CELL_BORDERS,
    frames::FACE_CELL_BORDERS,
    frames::VIEW_CENTRE,
    surfaces::FLAT_TILE,
    many::EQUAL_TRIANGLES,
    many::LAYERS,
    many::CROWD,
    grids::THIN_WALLS,
    grids::LONG_SCENE,
    screen::BEHIND_FOREGROUND,
    screen::TOWARDS_CAMERA,
    screen::FOREGROUND_IN_CELL,
    screen::LONG_RAYS,
    screen::AWAY_FROM_CAMERA,
    reported::HALF_RESOLUTION,
    reported::FIELD_OF_VIEW,
    reported::OFF_ORIGIN,
];

/// Finds a case by name.
pub fn find(name: &str) -> Option<&'static Case> {
    CASES.iter().find(|case| case.name == name)
}
