//! What the harness alone knows of the tracers, a registration each: which tables it is in, how it is made, what is expected of it on
//! the stability cases, which remedies tell why its rays are wrong, and what of it is worth sweeping or tuning. How it is made is in a
//! module, what is told of it in a JSON file of the same name.

pub(crate) mod bvh_cpu;
pub(crate) mod bvh_gpu;
pub(crate) mod dirt;
pub mod expectation;
pub(crate) mod fragment_abuffer;
pub(crate) mod height_field;
pub(crate) mod hybrid;
pub(crate) mod mesh_warp;
pub(crate) mod ploc_gpu;
pub(crate) mod quadtree;
pub(crate) mod ray_query;
pub(crate) mod screen_dda;
pub mod table;
pub(crate) mod voxel_abuffer;
pub(crate) mod voxel_octree;

use std::ops::Deref;
use std::sync::{Arc, LazyLock};

use serde::Deserialize;
use tracebench_api::{Gpu, Parameters, Preset, Residency, Tracer, TracerDescription, TracerError};

use crate::results::{ExpectationKind, RemedyRecord};
pub use expectation::{Expectation, Rasterized};
pub use table::{Rows, Switched, Table};

/// The device, or why there is none: what a tracer that needs one is skipped for.
pub type Device = Result<Arc<Gpu>, TracerError>;

/// How a tracer is created.
pub type Create = fn(Device) -> Result<Box<dyn Tracer>, TracerError>;

/// What kind of structure a tracer searches. Tracers of one family are peers: they are in one table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// A hierarchy of bounding volumes.
    Bvh,
    /// What views show of the scene.
    Image,
}

/// A way to make a structure smaller, for `need`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shrink {
    /// A parameter of the build, or `resolution`.
    pub axis: &'static str,
    /// Its values (of `resolution` multiples) from the largest structure to the smallest. Those that are no smaller than the tracer's own
    /// are left out, where that can be told.
    pub steps: Vec<&'static str>,
}

/// Parameters, or `resolution`, that only matter where another parameter has one of some values: elsewhere to change them changes nothing.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Matters {
    /// What matters.
    pub what: Vec<&'static str>,
    /// By which parameter that is told.
    pub by: &'static str,
    /// Where it has one of these values.
    pub values: Vec<&'static str>,
}

/// How many bytes of a structure a counter of what was touched stands for.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Touch {
    /// The counter.
    pub counter: &'static str,
    /// What the structure says of itself: how many of the same are stored.
    pub stored: &'static str,
    /// Where they are: the first of these parts that the structure has.
    pub parts: Vec<&'static str>,
}

/// A tracer that another one is made of.
#[derive(Clone, Copy)]
pub struct Part {
    /// Which.
    pub registration: &'static Registration,
    /// From which preset its parameters are where nothing is set.
    pub preset: Preset,
    /// The value of a parameter that names it.
    pub name: &'static str,
}

/// A tracer's registration.
#[derive(Clone, Copy)]
pub struct Registration {
    /// What it is and takes.
    pub description: fn() -> TracerDescription,
    /// Creates it; the device is there for tracers that live on one.
    pub create: Create,
    /// What it is made of, if of others.
    pub parts: Option<[Part; 2]>,
    /// What is told of it, read when it is first asked for.
    pub told: &'static LazyLock<Told>,
}

/// What is told of a tracer as data.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Told {
    /// Its peers.
    pub family: Family,
    /// Its name in older records.
    pub formerly: Option<&'static str>,
    /// Whether it serves only rays that all start in one point.
    #[serde(default)]
    one_origin: bool,
    /// What is expected of its published preset. An analytic method is expected to be exact on all cases that no other expectation names.
    #[serde(default)]
    expectations: Vec<Expectation>,
    /// Whether it stores depths at the pixel centres of one view: on cases that its own expectations do not name, the same is expected of
    /// all such methods.
    #[serde(default)]
    of_one_view: bool,
    /// What is expected of its improved preset, where that is more than of the published one or less: on other cases it is the same.
    pub improved: Option<Vec<Expectation>>,
    /// The switches of its improved form, as a table has them.
    pub ablation: Option<Table>,
    /// Its weaknesses in the order in which `explain` takes them away; each step keeps those before. None: it cannot be
    /// explained.
    #[serde(default)]
    pub remedies: Vec<RemedyRecord>,
    /// What `sweep` goes over where nothing is said; none: all that can be swept.
    #[serde(default)]
    pub sweep: Vec<&'static str>,
    /// The parameter of which `sweep --choose` chooses a value where nothing is said.
    pub tune: Option<&'static str>,
    /// Parameters that no front is about: aids of proofs, units, and what only matters to refits, surfaces or rays of one kind.
    #[serde(default)]
    pub excluded_from_fronts: Vec<&'static str>,
    /// What only matters with certain values of other parameters.
    #[serde(default)]
    pub matters: Vec<Matters>,
    /// Settings by which it stands once more where all tracers do.
    #[serde(default)]
    pub forms: Vec<Vec<(&'static str, &'static str)>>,
    /// How its structures are made smaller.
    #[serde(default)]
    pub shrinks: Vec<Shrink>,
    /// What its counters of what was touched stand for.
    #[serde(default)]
    pub touches: Vec<Touch>,
}

/// Reads a file of the program's own, which tests hold whole.
fn embedded<T: Deserialize<'static>>(text: &'static str) -> T {
    serde_json::from_str(text).expect("tests read every registration")
}

/// What is told of a tracer reads as its registration's own.
impl Deref for Registration {
    type Target = Told;

    fn deref(&self) -> &Told {
        self.told
    }
}

impl Registration {
    /// Whether a parameter, or `resolution`, can change anything beside the values of the others.
    pub fn can_matter(&self, what: &str, parameters: &Parameters) -> bool {
        let of = |matters: &&Matters| matters.what.contains(&what);
        let told = |matters: &Matters| {
            parameters.value(matters.by).is_none_or(|value| matters.values.contains(&value.to_string().as_str()))
        };
        self.matters.iter().filter(of).all(told)
    }

    /// What is expected of one of its presets, list by list: of all of them the first expectation that is of a case counts.
    pub fn expectations_of(&self, preset: Preset) -> [&'static [Expectation]; 3] {
        let improved = self.told.improved.as_deref().filter(|_| preset == Preset::Improved);
        let shared = if self.of_one_view { expectation::of_one_view() } else { &[] };
        [improved.unwrap_or_default(), &self.told.expectations, shared]
    }

    /// What is expected of one of its presets on a case.
    pub fn expected_of(&self, preset: Preset, case: &str) -> Option<&'static Expectation> {
        self.expectations_of(preset).into_iter().flatten().find(|each| each.is_of(case))
    }

    /// The name under which the expected shares of a preset stand: `NAME`, or `NAME:improved` where that has its own.
    pub fn column(&self, preset: Preset) -> String {
        match preset {
            Preset::Improved if self.improved.is_some() => format!("{}:{}", self.name(), preset.name()),
            _ => self.name().to_owned(),
        }
    }

    /// Creates the tracer with its pipelines.
    ///
    /// # Errors
    /// Why there is no device, if it needs one; [`TracerError::Unavailable`] if this machine cannot run it.
    pub fn create(&self, device: &Device) -> Result<Box<dyn Tracer>, TracerError> {
        match self.parts {
            Some(parts) => hybrid::create(&parts, device.clone()),
            None => (self.create)(device.clone()),
        }
    }

    /// The same tracer where one of its parts is that of a value of the parameter that names it; none for other parameters and values.
    pub fn with_part(&self, parameter: &str, value: &str) -> Option<Self> {
        let mut parts = self.parts?;
        let place = hybrid::PARAMETERS.iter().position(|name| *name == parameter)?;
        parts[place] = hybrid::find(value)?;
        Some(Self { parts: Some(parts), ..*self })
    }

    /// Whether it, or a part of it, serves only rays that all start in one point: it refuses other ray sets, which are skipped with its
    /// reason.
    pub fn one_origin(&self) -> bool {
        self.told.one_origin || self.parts.iter().flatten().any(|part| part.registration.one_origin())
    }

    /// Whether its hits are those of the triangles themselves, rather than of samples.
    pub fn is_analytic(&self) -> bool {
        self.expectations.iter().any(|each| each.cases.is_empty() && each.kind == ExpectationKind::Exact)
    }

    /// What it is and takes.
    pub fn describe(&self) -> TracerDescription {
        match self.parts {
            Some(parts) => hybrid::describe(&parts),
            None => (self.description)(),
        }
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.describe().name
    }

    /// Whether it needs a device.
    pub fn needs_device(&self) -> bool {
        self.describe().residency == Residency::Device
    }
}
