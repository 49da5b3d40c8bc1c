//! What the choice of a parameter's value costs: over the rows of a sweep from a scene's own viewpoint and from another one, the value
//! that is best on the judged rays beside the tracer's default and the values that are best elsewhere.

#[cfg(test)]
mod tests;

use tracebench_api::named;

use crate::judge::Rule;
use crate::results::{
    Accuracy, AxisRecord, Judgement, Record, Row, SceneRecord, TraceRecord, TracerRecord, TuningRecord, ViewpointRecord,
};

named! {
    /// How a value was come by: which rays have seen it beforehand.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Label {
        /// The value of the tracer's preset: no rays.
        Default = "default",
        /// The best on the judged rays themselves: what no user has.
        TunedHere = "tuned here",
        /// The best from the scene's other viewpoint.
        TunedElsewhere = "tuned elsewhere",
        /// The best on average over the other scenes' own viewpoints.
        TunedOnOtherScenes = "tuned on the other scenes",
    }
}

/// A parameter of a tracer with the values that would have been chosen.
#[derive(Clone, Debug)]
pub struct Tuning<'a> {
    /// The tracer with its default values.
    pub tracer: &'a TracerRecord,
    /// The parameter; `own` is its default, the value of the tracer's preset.
    pub axis: &'a AxisRecord,
    /// The rule by which values are chosen; of any-hit sets it is balanced accuracy, whatever stands here.
    pub rule: Rule,
    /// Every ray set, scene by scene, from the own viewpoint first.
    pub sets: Vec<SetTuned<'a>>,
}

/// One ray set from one viewpoint: every value traced the same rays.
#[derive(Clone, Debug)]
pub struct SetTuned<'a> {
    /// The scene.
    pub scene: &'a SceneRecord,
    /// The viewpoint.
    pub viewpoint: &'a ViewpointRecord,
    /// Whether it is the scene's own one.
    pub is_own: bool,
    /// A trace of the rays, whoever's, which tells what they are.
    pub rays: &'a TraceRecord,
    /// The rule by which values are chosen.
    pub rule: Rule,
    /// The parameter's values in order, each with its trace; without one where it could not be measured.
    pub values: Vec<(&'a str, Option<&'a TraceRecord>)>,
    /// The values that would have been chosen, in the order of [`Label::ALL`].
    chosen: [Option<&'a str>; Label::ALL.len()],
}

impl<'a> Tuning<'a> {
    /// What a record says of a tuning, with the values that would have been chosen; `None` if it is of none.
    pub fn of(record: &'a Record) -> Option<Self> {
        let (TuningRecord { tracer, rule, scenes }, sweep) = (record.tuning.as_ref()?, record.sweep.as_ref()?);
        let (axis, rule) = (sweep.axes.first()?, *rule);
        let mut sets = Vec::new();
        for (scene, viewpoints) in scenes.iter().map(|of| (&of.scene, &of.viewpoints)) {
            for (view, viewpoint) in viewpoints.iter().enumerate() {
                let here = |one: &&Row| one.scene == *scene && one.viewpoint == *viewpoint;
                let rows: Vec<&Row> = record.rows.iter().filter(here).collect();
                let first = record.controls.iter().find(here).or(rows.first().copied());
                for rays in first.map_or(&[][..], |first| &first.traces) {
                    let trace = |value: &String| {
                        let point = sweep.point(&axis.name, value, &[])?;
                        let row = rows.iter().find(|row| point.is_of(row))?;
                        row.traces.iter().find(|trace| trace.rays_sha256 == rays.rays_sha256)
                    };
                    let values = axis.values.iter().map(|value| (value.as_str(), trace(value))).collect();
                    let chosen = [None; Label::ALL.len()];
                    sets.push(SetTuned { scene, viewpoint, is_own: view == 0, rays, rule, values, chosen });
                }
            }
        }
        choose(&mut sets, &axis.own);
        Some(Self { tracer, axis, rule, sets })
    }

    /// The ray set of a row's trace.
    pub fn set_of(&self, row: &Row, trace: &TraceRecord) -> Option<&SetTuned<'a>> {
        let is_here = |set: &&SetTuned<'_>| *set.scene == row.scene && *set.viewpoint == row.viewpoint;
        self.sets.iter().filter(is_here).find(|set| set.rays.rays_sha256 == trace.rays_sha256)
    }

    /// The value that a label has for a ray set from a scene's own viewpoint; `None` where there is no such scene or set, or nothing
    /// to choose by.
    pub fn value_from_own_viewpoint(&self, scene: &str, rays: &str, label: Label) -> Option<&'a str> {
        let is_it = |set: &&SetTuned<'_>| set.is_own && set.scene.name == scene && set.rays.rays == rays;
        self.sets.iter().find(is_it)?.chosen(label)
    }
}

impl<'a> SetTuned<'a> {
    /// What a value answered.
    pub fn trace(&self, value: &str) -> Option<&'a TraceRecord> {
        self.values.iter().find(|(each, _)| *each == value)?.1
    }

    /// How often a value is right by the rule, if that says anything.
    pub fn right(&self, value: &str) -> Option<Accuracy> {
        accuracy(&self.trace(value)?.judgement, self.rule)
    }

    /// The same as a share.
    pub fn score(&self, value: &str) -> Option<f64> {
        self.right(value)?.share
    }

    /// The value that would have been chosen; `None` where there was nothing to choose by.
    pub fn chosen(&self, label: Label) -> Option<&'a str> {
        self.chosen[label as usize]
    }

    /// How a value would have been come by.
    pub fn labels(&self, value: &str) -> impl Iterator<Item = Label> {
        Label::ALL.into_iter().filter(move |label| self.chosen(*label) == Some(value))
    }

    /// What a value loses on these rays to the one of a label: that one's score less its own.
    pub fn lost(&self, value: &str, to: Label) -> Option<f64> {
        Some(self.score(self.chosen(to)?)? - self.score(value)?)
    }

    /// Whether these rays have a say in a label's value for others: they ask the same, stand where the label says, and were judged.
    fn has_say(&self, label: Label, on: &Self) -> bool {
        let [same_scene, same_view] = [self.scene == on.scene, self.viewpoint == on.viewpoint];
        let is_there = match label {
            Label::Default => false,
            Label::TunedHere => same_scene && same_view && self.rays.rays_sha256 == on.rays.rays_sha256,
            Label::TunedElsewhere => same_scene && !same_view,
            Label::TunedOnOtherScenes => !same_scene && self.is_own,
        };
        let asks_the_same = (&self.rays.rays, self.rays.query) == (&on.rays.rays, on.rays.query);
        is_there && asks_the_same && self.values.iter().any(|(value, _)| self.score(value).is_some())
    }
}

/// How often answers are right by a rule, of any-hit sets the balanced accuracy; `None` if nothing was judged or shares say nothing.
pub fn accuracy(judgement: &Judgement, rule: Rule) -> Option<Accuracy> {
    let all = judgement.accuracies(0);
    // Of any-hit sets there is one.
    let found = all.get(rule as usize).or(all.first()).copied();
    found.filter(|of| of.share.is_some_and(f64::is_finite) && of.one_sided.is_none())
}

/// Fills in the choices of every ray set.
fn choose<'a>(sets: &mut [SetTuned<'a>], default: &'a str) {
    let value = |set: &SetTuned<'a>, label: Label| match label {
        Label::Default => Some(default),
        _ => best(&sets.iter().filter(|other| other.has_say(label, set)).collect::<Vec<_>>()),
    };
    let chosen: Vec<_> = sets.iter().map(|set| Label::ALL.map(|label| value(set, label))).collect();
    for (set, chosen) in sets.iter_mut().zip(chosen) {
        set.chosen = chosen;
    }
}

/// The value with the greatest mean score over ray sets, of those that were judged in all of them; of equal ones that nearest
/// to 0 where values are numbers, else the first. `None` without a set.
fn best<'a>(sets: &[&SetTuned<'a>]) -> Option<&'a str> {
    let scored = sets.first()?.values.iter().filter_map(|(value, _)| {
        let sum: f64 = sets.iter().map(|set| set.score(value)).sum::<Option<f64>>()?;
        Some((sum / sets.len() as f64, *value))
    });
    // How far a value is from 0; infinitely where it is no number.
    let size = |value: &str| value.parse().map_or(f64::INFINITY, f64::abs);
    let is_better = |(one, value): (f64, &str), (other, than): (f64, &str)| {
        one > other || (one == other && size(value) < size(than))
    };
    scored.reduce(|best, each| if is_better(each, best) { each } else { best }).map(|(_, value)| value)
}
