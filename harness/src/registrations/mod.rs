//! What the harness alone knows of the tracers, a registration each: which tables it is in, how it is made, what is expected of it on
//! the stability cases, which remedies tell why its rays are wrong, and what of it is worth sweeping or tuning.

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

use std::sync::Arc;

use tracebench_api::{Gpu, Parameters, Preset, Residency, Tracer, TracerDescription, TracerError};

use expectation::expected;
pub use expectation::{Column, Expectation, Rule};
pub use table::{Rows, Switched, Table};

/// The device, or why there is none: what a tracer that needs one is skipped for.
pub type Device = Result<Arc<Gpu>, TracerError>;

/// How a tracer is created.
pub type Create = fn(Device) -> Result<Box<dyn Tracer>, TracerError>;

/// What kind of structure a tracer searches. Tracers of one family are peers: they are in one table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// A hierarchy of bounding volumes.
    Bvh,
    /// What views show of the scene.
    Image,
}

/// A cause of wrong rays, and the parameter that takes it away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Remedy {
    /// The cause, as results name it.
    pub cause: &'static str,
    /// The tracer's parameter.
    pub parameter: &'static str,
    /// The value that takes the cause away.
    pub value: &'static str,
    /// Where the cause comes from.
    pub source: &'static str,
}

/// A way to make a structure smaller, for `need`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shrink {
    /// A parameter of the build, or `resolution`.
    pub axis: &'static str,
    /// Its values (of `resolution` multiples) from the largest structure to the smallest. Those that are no smaller than the tracer's own
    /// are left out, where that can be told.
    pub steps: &'static [&'static str],
}

/// Parameters, or `resolution`, that only matter where another parameter has one of some values: elsewhere to change them changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Matters {
    /// What matters.
    pub what: &'static [&'static str],
    /// By which parameter that is told.
    pub by: &'static str,
    /// Where it has one of these values.
    pub values: &'static [&'static str],
}

/// How many bytes of a structure a counter of what was touched stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touch {
    /// The counter.
    pub counter: &'static str,
    /// What the structure says of itself: how many of the same are stored.
    pub stored: &'static str,
    /// Where they are: the first of these parts that the structure has.
    pub parts: &'static [&'static str],
}

/// What counters of hierarchies stand for.
const OF_HIERARCHIES: &[Touch] = &[
    Touch { counter: "nodes_touched", stored: "nodes", parts: &["CWBVH nodes", "BVH2 nodes"] },
    Touch { counter: "references_touched", stored: "references", parts: &["triangles in leaf order"] },
];

/// What is expected of a tracer's improved preset.
#[derive(Clone, Copy, Debug)]
pub struct Improved {
    /// What is expected on cases that `expectations` does not name.
    pub otherwise: Option<Expectation>,
    /// What is expected, by stability case; of columns the first that names the case counts.
    pub expectations: &'static [Column],
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

/// What a tracer is made of, and how it follows from that.
#[derive(Clone, Copy)]
pub struct Parts {
    pub(crate) of: [Part; 2],
    /// The parameters that name them; before a full stop they stand in the names of the parts' own.
    pub(crate) names: &'static [&'static str; 2],
    /// The part of a value of theirs.
    pub(crate) find: fn(&str) -> Option<Part>,
    pub(crate) describe: fn(&[Part; 2]) -> TracerDescription,
    pub(crate) create: CreateOfParts,
}

/// Makes a tracer of two parts.
pub(crate) type CreateOfParts = fn(&[Part; 2], Device) -> Result<Box<dyn Tracer>, TracerError>;

/// A tracer's registration.
#[derive(Clone, Copy)]
pub struct Registration {
    /// What it is and takes.
    description: fn() -> TracerDescription,
    /// Its name in older records.
    pub formerly: Option<&'static str>,
    /// Its peers.
    pub family: Family,
    /// Whether it serves only rays that all start in one point: it refuses other ray sets, which are skipped with its reason.
    pub one_origin: bool,
    /// Creates it; the device is there for tracers that live on one.
    pub(crate) create: Create,
    /// What is expected on cases that `expectations` does not name: [`Expectation::Exact`] of an analytic method, nothing of
    /// one that samples.
    pub otherwise: Option<Expectation>,
    /// What is expected of its published preset, by stability case; of columns the first that names the case counts.
    pub expectations: &'static [Column],
    /// What is expected of its improved preset, where that is more than of the published one or less.
    pub improved: Option<Improved>,
    /// The switches of its improved form, as a table has them.
    pub ablation: Option<&'static Table>,
    /// Its weaknesses in the order in which `explain` takes them away; each step keeps those before. None: it cannot be
    /// explained.
    pub remedies: &'static [Remedy],
    /// What `sweep` goes over where nothing is said; none: all that can be swept.
    pub sweep: &'static [&'static str],
    /// The parameter of which `sweep --choose` chooses a value where nothing is said.
    pub tune: Option<&'static str>,
    /// Parameters that no front is about: aids of proofs, units, and what only matters to refits, surfaces or rays of one kind.
    pub excluded_from_fronts: &'static [&'static str],
    /// What only matters with certain values of other parameters.
    pub matters: &'static [Matters],
    /// What it is made of, if of others.
    pub parts: Option<Parts>,
    /// Settings by which it stands once more where all tracers do.
    pub forms: &'static [&'static [(&'static str, &'static str)]],
    /// How its structures are made smaller.
    pub shrinks: &'static [Shrink],
    /// What its counters of what was touched stand for.
    pub touches: &'static [Touch],
}

impl Registration {
    /// The registration of a method that samples, with nothing more said of it.
    pub const fn sampled(description: fn() -> TracerDescription, family: Family, create: Create) -> Self {
        Self {
            description,
            family,
            one_origin: false,
            create,
            otherwise: None,
            expectations: &[],
            improved: None,
            ablation: None,
            remedies: &[],
            sweep: &[],
            tune: None,
            excluded_from_fronts: &[],
            formerly: None,
            matters: &[],
            parts: None,
            forms: &[],
            shrinks: &[],
            touches: &[],
        }
    }

    /// The registration of a method with analytic hits, which is expected to have no wrong ray where nothing else is said.
    pub const fn analytic(description: fn() -> TracerDescription, family: Family, create: Create) -> Self {
        Self { otherwise: Some(Expectation::Exact), ..Self::sampled(description, family, create) }
    }

    /// Whether a parameter, or `resolution`, can change anything beside the values of the others.
    pub fn can_matter(&self, what: &str, parameters: &Parameters) -> bool {
        let of = |matters: &&Matters| matters.what.contains(&what);
        let told = |matters: &Matters| {
            parameters.value(matters.by).is_none_or(|value| matters.values.contains(&value.to_string().as_str()))
        };
        self.matters.iter().filter(of).all(told)
    }

    /// What is expected of its published preset on a case.
    pub fn expected_on(&self, case: &str) -> Option<Expectation> {
        expected(self.expectations, case).or(self.otherwise)
    }

    /// What is expected of one of its presets on a case: of an improved one without expectations of its own, the same as of the published
    /// one.
    pub fn expected_of(&self, preset: Preset, case: &str) -> Option<Expectation> {
        match self.improved.filter(|_| preset == Preset::Improved) {
            None => self.expected_on(case),
            Some(improved) => expected(improved.expectations, case).or(improved.otherwise),
        }
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
            Some(Parts { of, create, .. }) => create(&of, device.clone()),
            None => (self.create)(device.clone()),
        }
    }

    /// The same tracer where one of its parts is that of a value of the parameter that names it; none for other parameters and values.
    pub fn with_part(&self, parameter: &str, value: &str) -> Option<Self> {
        let mut parts = self.parts?;
        let place = parts.names.iter().position(|name| *name == parameter)?;
        parts.of[place] = (parts.find)(value)?;
        let one_origin = parts.of.iter().any(|part| part.registration.one_origin);
        Some(Self { parts: Some(parts), one_origin, ..*self })
    }

    /// Whether its hits are those of the triangles themselves, rather than of samples.
    pub fn is_analytic(&self) -> bool {
        self.otherwise == Some(Expectation::Exact)
    }

    /// What it is and takes.
    pub fn describe(&self) -> TracerDescription {
        match self.parts {
            Some(Parts { of, describe, .. }) => describe(&of),
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
