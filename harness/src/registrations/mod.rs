//! What the harness alone knows of the tracers, a registration each: which tables it is in, how it is made, what is expected of it on
//! the stability cases, which remedies tell why its rays are wrong, and what of it is worth sweeping or tuning. How it is made is an entry
//! here, what is told of it in the JSON file of the same name.

pub mod expectation;
pub(crate) mod hybrid;

use std::ops::Deref;
use std::sync::{Arc, LazyLock};

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use tracebench_api::{Gpu, Parameters, Preset, Residency, Tracer, TracerDescription, TracerError};

use crate::results::{ExpectationKind, RemedyRecord};
pub use expectation::{Expectation, Rasterized};

/// A module a tracer, with its registration; and the list of all, that of others last.
macro_rules! registrations {
    ($($(#[$about:meta])* $name:ident: $description:path, $create:expr;)*) => {
        $($(#[$about])*
        mod $name {
            use super::*;

            static TOLD: LazyLock<Told> = LazyLock::new(|| embedded(include_str!(concat!(stringify!($name), ".json"))));

            pub(super) static REGISTRATION: Registration =
                Registration { description: $description, create: $create, parts: None, told: &TOLD };
        })*

        /// Every tracer, in the order of tables.
        pub static TRACERS: &[Registration] = &[$($name::REGISTRATION,)* hybrid::REGISTRATION];
    };
}

registrations! {
    /// An analytic method in f32 that sees every triangle and no view.
    bvh_cpu: tracebench_bvh::description, |_| Ok(Box::new(tracebench_bvh::BvhCpu));

    /// An analytic method with a watertight triangle test that sees every triangle and no view.
    bvh_gpu: tracebench_bvh::gpu_description, |gpu| Ok(Box::new(tracebench_bvh::BvhGpu::new(gpu?)?));

    /// The searches of `bvh-gpu` over hierarchies built on the device.
    /// Its ablation: fewer neighbours early, late and throughout, and none, of both kinds of nodes.
    ploc_gpu: tracebench_bvh::ploc_description, |gpu| Ok(Box::new(tracebench_bvh::PlocGpu::new(gpu?)?));

    /// A triangle test that is the driver's own: Vulkan asks drivers for a watertight one (VK_KHR_ray_query, "Watertightness"), and Mesa's
    /// software driver (25.0) has one. Another driver that does worse comes out as unexpected, which is what its column is for.
    ray_query: tracebench_bvh::ray_query_description, |gpu| Ok(Box::new(tracebench_bvh::RayQuery::new(gpu?)?));

    /// Analytic hits on every triangle that touches a tile of six views, found bucket by bucket; improved, by a tree in every tile.
    /// Its ablation: from row to row one thing more (hits by their distance, no near plane, rays split near the eye, drawn in compute); then
    /// the improved form, and single switches of it taken back or turned.
    dirt: tracebench_dirt::description, |gpu| Ok(Box::new(tracebench_dirt::Dirt::new(gpu?)?));

    /// Fragments at pixels' centres, every layer, seven views, no thickness; improved, fragments that are planes, in every pixel that a
    /// triangle touches.
    /// Its ablation: each of the two switches that change what is stored alone, and both; then the improved form, and its switches taken
    /// back one by one.
    fragment_abuffer: tracebench_fragment_abuffer::description,
        |gpu| Ok(Box::new(tracebench_fragment_abuffer::FragmentAbuffer::new(gpu?)?));

    /// Layers at texels' centres along three axes of the scene's bounds, inside told from outside; improved, planes that are clipped to
    /// texels, each a part of the surface itself.
    /// Its ablation: from row to row one thing more, up to the best that is known of points and the same with starts lifted off their
    /// surface; then the improved form, and single switches of it turned.
    voxel_abuffer: tracebench_voxel_abuffer::description,
        |gpu| Ok(Box::new(tracebench_voxel_abuffer::VoxelAbuffer::new(gpu?)?));

    /// Every voxel that a triangle touches, and hits as precise as one.
    /// Where a ray ends in a voxel is never right; what is expected is whether it ends at a surface. Its remedies take away a voxel's extent,
    /// from its entry to its centre and then all of it.
    voxel_octree: tracebench_voxel_octree::description,
        |gpu| Ok(Box::new(tracebench_voxel_octree::VoxelOctree::new(gpu?)?));

    /// Two depth layers of the frame, each pixel a small plane, merged by thresholds in the unit cube.
    /// Its ablation: from row to row one thing more (normals of triangles, thresholds in pixels, the flag from smaller steps, planes that end
    /// at each other); then the improved form, and single switches of it taken back or turned.
    quadtree: tracebench_quadtree::description, |gpu| Ok(Box::new(tracebench_quadtree::Quadtree::new(gpu?)?));

    /// One depth a pixel, sampled at pixel centres, from one view.
    /// Its ablation: each switch alone; then the improved form, and its switches taken back one by one.
    screen_dda: tracebench_screen_dda::description, |gpu| Ok(Box::new(tracebench_screen_dda::ScreenDda::new(gpu?)?));

    /// One depth a pixel from one view, all behind it solid.
    height_field: tracebench_height_field::description,
        |gpu| Ok(Box::new(tracebench_height_field::HeightField::new(gpu?)?));

    /// One depth a pixel from one view as a mesh, drawn from where rays start.
    mesh_warp: tracebench_mesh_warp::description, |gpu| Ok(Box::new(tracebench_mesh_warp::MeshWarp::new(gpu?)?));
}

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

/// A table whose rows are tracers at settings.
#[derive(Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Stable name; files are named after it.
    pub name: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// Ray sets where nothing else is said, as `--rays` takes them.
    pub rays: &'static str,
    /// Its rows.
    pub rows: Rows,
}

/// Which tracers at which settings have a row each.
#[derive(Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rows {
    /// Tracers of a family side by side.
    Peers {
        /// Whose tracers.
        family: Family,
        /// A parameter of the first of them, each of whose values worth sweeping has a row.
        swept: &'static str,
    },
    /// Every tracer that searches on the device, by each way to read and to launch.
    LaunchSettings,
    /// The switches of the improved form of the tracer whose room has the table, beside the first hierarchy on the device.
    Switches(Vec<Switched>),
}

/// A row: a preset with other values.
#[derive(Debug, PartialEq, Eq)]
pub struct Switched {
    /// From which preset.
    pub preset: Preset,
    /// Parameters with their values.
    pub values: Vec<(&'static str, &'static str)>,
}

impl Deserialize<'static> for Switched {
    /// In one line: `published lists=packed slices=1`.
    fn deserialize<D: Deserializer<'static>>(deserializer: D) -> Result<Self, D::Error> {
        let line = <&'static str>::deserialize(deserializer)?;
        let (preset, rest) = line.split_once(' ').unwrap_or((line, ""));
        let preset = Preset::ALL.into_iter().find(|each| each.name() == preset);
        let values = rest.split_whitespace().map(|word| word.split_once('=')).collect::<Option<_>>();
        let found = preset.zip(values).map(|(preset, values)| Self { preset, values });
        found.ok_or_else(|| D::Error::custom(format!("`{line}` is not `PRESET PARAMETER=VALUE ...`")))
    }
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
pub(crate) fn embedded<T: Deserialize<'static>>(text: &'static str) -> T {
    serde_json::from_str(text).expect("tests read all of them")
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
