//! What `hybrid` is and takes: its own parameters, and those of its parts.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use tracebench_api::ParameterScope::{Build, Trace};
use tracebench_api::{
    Domain, Invalidation, Parameter, ParameterDescription, ParameterError, Parameters, Preset, Query, Status, TraceTo,
    TracerDescription, Value, choice, parameters,
};
use tracebench_kit::{MemoryAccess, memory_access_parameter, rays_per_lane_parameter};

choice! {
    /// Which answers of the first are kept.
    pub(crate) enum Trust { None = "none", Hit = "hit", HitMiss = "hit+miss", All = "all" }
    /// How the second is launched.
    pub(crate) enum Dispatch { Indirect = "indirect", Full = "full" }
}

impl Trust {
    /// A bit a status that is trusted.
    pub(crate) fn statuses(self) -> u32 {
        match self {
            Self::None => 0,
            Self::Hit => 1 << Status::Hit as u32,
            Self::HitMiss => 1 << Status::Hit as u32 | 1 << Status::Miss as u32,
            Self::All => u32::MAX,
        }
    }
}

parameters! {
    /// What `hybrid` is told beside what its parts are.
    pub(crate) struct HybridParameters {
        /// which answers of the first are kept, by their status: none, hits, hits and misses, or all; only `all` keeps inpainted hits. The
        /// other rays are handed over to the second
        trust: Trust = Parameter::choice(Trace, Trust::Hit),
        /// hits that project nearer than this to the border of the viewpoint's frame are handed over, too
        border_pixels: f64 = Parameter::real(Trace, 0.0..=1024.0, 0.0).unit("pixels").sweep([0.0, 1.0, 4.0, 16.0]),
        /// how the second is launched: with as many workgroups as the rays handed over take, which the device tells, or with as many as
        /// all rays take, of which the others end at once; the hits are the same
        dispatch: Dispatch = Parameter::choice(Trace, Dispatch::Indirect),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// Parameters of parts that both take from the hybrid, where they have them.
const SHARED: [&str; 2] = ["memory_access", "rays_per_lane"];

/// What stands before the names of the parts' parameters, counters, phases and buffers: the parameters that name them.
pub(crate) const PARTS: [&str; 2] = ["first", "then"];

const EFFECTS: [&str; 2] =
    ["the tracer that all rays are asked of first", "the tracer that the rays are asked of that are handed over"];

/// A tracer that a hybrid is made of.
#[derive(Clone, Debug)]
pub struct Part {
    /// What it is and takes.
    pub description: TracerDescription,
    /// From which preset its parameters are where nothing is set.
    pub preset: Preset,
    /// How it is named: `NAME`, or `NAME:PRESET`.
    pub name: &'static str,
}

impl Part {
    /// Its own parameters of a hybrid's, of which it is the first or second.
    pub(crate) fn parameters(&self, place: usize, all: &Parameters) -> Result<Parameters, ParameterError> {
        let own =
            |name: &str| if SHARED.contains(&name) { name.to_owned() } else { format!("{}.{name}", PARTS[place]) };
        chosen(&self.description.parameters, all, own)
    }
}

impl HybridParameters {
    /// Those of all of a hybrid's.
    pub(crate) fn of(all: &Parameters) -> Result<Self, ParameterError> {
        (&chosen(&Self::describe(), all, str::to_owned)?).try_into()
    }
}

/// The values of some parameters among others, where `named` tells their names there.
fn chosen(
    described: &[ParameterDescription],
    all: &Parameters,
    named: impl Fn(&str) -> String,
) -> Result<Parameters, ParameterError> {
    let mut parameters = Parameters::preset(described, Preset::Published);
    for each in described {
        let name = named(each.name);
        let value = all.value(&name).ok_or_else(|| ParameterError::Missing { name: interned(name) })?;
        parameters.set(described, each.name, &value.to_string())?;
    }
    Ok(parameters)
}

/// A name that lasts, made once: there are as many as parameters and counters of tracers.
pub(crate) fn interned(name: String) -> &'static str {
    static NAMES: Mutex<BTreeSet<&str>> = Mutex::new(BTreeSet::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    let known = names.get(name.as_str()).copied();
    let lasting = known.unwrap_or_else(|| name.leak());
    names.insert(lasting);
    lasting
}

/// What a hybrid of two parts is and takes; `names` are those that parts can have.
pub fn description(parts: &[Part; 2], names: &'static [&'static str]) -> TracerDescription {
    let mut parameters = HybridParameters::describe();
    for ((part, prefix), effect) in parts.iter().zip(PARTS).zip(EFFECTS) {
        let name = Value::Choice(part.name.to_owned());
        parameters.push(ParameterDescription {
            name: prefix,
            unit: "",
            scope: Build,
            domain: Domain::Choice(names),
            published: name.clone(),
            improved: name,
            effect,
            sweep: Vec::new(),
        });
        let own = part.description.parameters.iter().filter(|each| !SHARED.contains(&each.name));
        parameters.extend(own.map(|each| {
            let value = match part.preset {
                Preset::Published => &each.published,
                Preset::Improved => &each.improved,
            };
            let name = interned(format!("{prefix}.{}", each.name));
            ParameterDescription { name, published: value.clone(), improved: value.clone(), ..each.clone() }
        }));
    }
    let all = |has: fn(&TracerDescription) -> bool| parts.iter().all(|part| has(&part.description));
    TracerDescription {
        name: "hybrid",
        citation: "AMD: Hybrid Reflections sample, GPUOpen (https://gpuopen.com/learn/hybrid-reflections/)",
        summary: "one tracer first, and another one for the rays whose answers are not trusted",
        // By `border_pixels` also where the parts do not hang on the view.
        invalidated_by: &[Invalidation::Geometry, Invalidation::Viewpoint, Invalidation::Resolution],
        names_primitives: all(|part| part.names_primitives),
        ends: if all(|part| part.ends.contains(&TraceTo::Surface)) { &TraceTo::ALL } else { &[TraceTo::Hit] },
        queries: if all(|part| part.queries.contains(&Query::Any)) { &Query::ALL } else { &[Query::Closest] },
        no_refit: parts[1].description.no_refit,
        ..TracerDescription::on_device(parameters)
    }
}
