//! Who overtakes whom within a class of points that are right as often.

use super::break_even::{Fit, FrameCost, Motion, Stretch, stretches};
use super::field::{Amount, By, Entry, Field, is_at, on_host};
use super::operating::{Aim, LEVELS, best};
use super::refit;
use crate::results::{Row, Timed, TraceRecord};
use itertools::Itertools as _;

/// What a point takes for a frame.
#[derive(Clone, Debug)]
pub struct ClassCost<'a> {
    /// The point.
    pub entry: Entry<'a>,
    /// What it takes.
    pub cost: FrameCost,
    /// Whether it was refitted; else it was built.
    pub refitted: bool,
}

/// Points that are right as often, and who is cheapest of them at how many rays a frame.
#[derive(Clone, Debug)]
pub struct Class<'a> {
    /// The ray set.
    pub field: &'a Field<'a>,
    /// What is right.
    pub by: By,
    /// How often.
    pub level: f64,
    /// What becomes of the geometry.
    pub motion: Motion,
    /// The tracers' fastest points and those that are quickest to build.
    pub costs: Vec<ClassCost<'a>>,
    /// Who is cheapest, from the fewest rays to the most.
    pub stretches: Vec<Stretch>,
}

impl<'a> Class<'a> {
    /// Names of the tracers, each once.
    pub fn tracers(&self) -> Vec<&'a str> {
        self.costs.iter().map(|cost| cost.entry.point.tracer.as_str()).unique().collect()
    }
}

/// The classes of one ray set under one rule, by level and motion; those in which nobody is have no costs.
pub fn classes<'a>(field: &'a Field<'a>, by: By, level: f64) -> Vec<Class<'a>> {
    let found = field.tracers().into_iter().flat_map(|tracer| {
        let own = field.of_tracer(tracer);
        [Aim::Fastest, Aim::QuickestBuilt].map(|aim| best(field, &own, by, level, aim))
    });
    let members: Vec<Entry<'a>> = found.flatten().unique_by(|entry| entry.index).collect();
    let class = |motion: Motion| {
        let cost = |entry: &Entry<'a>| class_cost(field, entry, motion);
        let costs: Vec<ClassCost<'a>> = members.iter().filter_map(cost).collect();
        let frames: Vec<FrameCost> = costs.iter().map(|cost| cost.cost.clone()).collect();
        let stretches = stretches(&frames);
        Class { field, by, level, motion, costs, stretches }
    };
    Motion::ALL.into_iter().map(class).collect()
}

/// The classes of all levels at which several tracers are, which charts show.
pub fn contested<'a>(field: &'a Field<'a>, by: By) -> Vec<Class<'a>> {
    let several = |class: &Class<'a>| class.tracers().len() > 1;
    LEVELS.into_iter().flat_map(|level| classes(field, by, level)).filter(several).collect()
}

/// What a point takes for a frame; `None` where its traces were not timed with several numbers of rays.
fn class_cost<'a>(field: &Field<'a>, entry: &Entry<'a>, motion: Motion) -> Option<ClassCost<'a>> {
    let Field { record, scene, .. } = *field;
    let mut traces: Vec<(&'a Row, &'a TraceRecord)> = vec![(entry.row, entry.trace)];
    for ray_image in &scene.ray_images {
        let mut viewpoint = scene.viewpoint.clone();
        viewpoint.ray_image = *ray_image;
        let here = |row: &&Row| row.update_mode.is_none() && entry.point.is_of(row) && is_at(row, scene, &viewpoint);
        let row = record.rows.iter().find(here);
        let found = row.and_then(|row| Some((row, row.traces.iter().find(|trace| trace.rays == field.rays)?)));
        traces.extend(found);
    }
    let sample = |(_, trace): &(&Row, &TraceRecord)| Some((trace.count as f64, on_host(&trace.times)?));
    let fit = Fit::new(traces.iter().map(sample).collect::<Option<_>>()?)?;
    let refitted = (motion == Motion::Refitted).then(|| refit(record, scene, entry)).flatten();
    let structure = refitted.unwrap_or(entry.row);
    let once = match motion {
        Motion::Static => Amount::exact(0.0),
        Motion::Refitted | Motion::Rebuilt => on_host(structure.build.steady())?,
    };
    // The clock of any, or a machine that was faster in one interleaved set.
    let doubt = |one: &Timed<'_>, other: &Timed<'_>| Some(record.paired_on_host(one, other).caveat?.to_string());
    let timed: Vec<Timed<'_>> = traces.iter().map(|(row, trace)| Timed::trace(row, trace)).collect();
    let mut caveat = timed.windows(2).find_map(|pair| doubt(&pair[0], &pair[1]));
    if motion != Motion::Static {
        let built = Timed::steady_build(structure);
        caveat = caveat.or_else(|| doubt(&built, &built));
    }
    let cost = FrameCost { once, traces: fit, caveat };
    Some(ClassCost { entry: *entry, cost, refitted: refitted.is_some() })
}
