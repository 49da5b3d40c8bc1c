//! Which value would have been chosen, and what it is worth on rays that it was not chosen by.

use std::collections::BTreeMap;

use super::tuning::{Choice, Label, SceneTuned, SetTuned, ValueTuned};
use crate::judge::Rule;
use crate::results::{Accuracy, Judgement};

/// How often answers are right by a rule, of any-hit sets the balanced accuracy; `None` if nothing was judged or shares say nothing.
pub fn accuracy(judgement: &Judgement, rule: Rule) -> Option<Accuracy> {
    let all = judgement.accuracies(0);
    // Of any-hit sets there is one.
    let found = all.get(rule as usize).or(all.first()).copied();
    found.filter(|of| of.share.is_some_and(f64::is_finite) && of.one_sided.is_none())
}

/// The value with the greatest mean score over ray sets, of those that were judged in all of them; of equal ones that nearest
/// to 0 where values are numbers, else the first. `None` without a set.
fn best<'a>(sets: &[&'a SetTuned], rule: Rule) -> Option<&'a str> {
    let scored = sets.first()?.values.iter().filter_map(|ValueTuned { value, .. }| {
        let sum: f64 = sets.iter().map(|set| set.score(value, rule)).sum::<Option<f64>>()?;
        Some((sum / sets.len() as f64, value.as_str()))
    });
    // How far a value is from 0; infinitely where it is no number.
    let size = |value: &str| value.parse().map_or(f64::INFINITY, f64::abs);
    let is_better = |(one, value): (f64, &str), (other, than): (f64, &str)| {
        one > other || (one == other && size(value) < size(than))
    };
    scored.reduce(|best, each| if is_better(each, best) { each } else { best }).map(|(_, value)| value)
}

/// A viewpoint's ray set of a name.
fn set_of<'a>(scene: &'a SceneTuned, view: usize, rays: &str) -> Option<&'a SetTuned> {
    scene.views.get(view)?.sets.iter().find(|set| set.rays == rays)
}

/// Fills in the choices of every ray set.
pub fn choose(scenes: &mut [SceneTuned], default: &str, rule: Rule) {
    let mut chosen = Vec::new();
    for (place, scene) in scenes.iter().enumerate() {
        for (view, set) in
            scene.views.iter().enumerate().flat_map(|(view, each)| each.sets.iter().map(move |s| (view, s)))
        {
            let elsewhere: Vec<&SetTuned> = (0..scene.views.len())
                .filter(|other| *other != view)
                .filter_map(|other| set_of(scene, other, &set.rays))
                .collect();
            let others = scenes.iter().enumerate().filter(|(other, _)| *other != place);
            let others = others.filter_map(|(_, other)| set_of(other, 0, &set.rays));
            // One of nothing but ambiguous rays has no say.
            let has_scores = |of: &SetTuned| of.values.iter().any(|each| of.score(&each.value, rule).is_some());
            let others: Vec<&SetTuned> = others.filter(|other| other.query == set.query && has_scores(other)).collect();
            let value = |label| match label {
                Label::Default => Some(default),
                Label::TunedHere => best(&[set], rule),
                Label::TunedElsewhere => best(&elsewhere, rule),
                Label::TunedOnOtherScenes => best(&others, rule),
            };
            chosen.push(choices(set, rule, value));
        }
    }
    let sets = scenes.iter_mut().flat_map(|scene| &mut scene.views).flat_map(|view| &mut view.sets);
    for (set, choices) in sets.zip(chosen) {
        set.choices = choices;
    }
}

fn choices<'a>(set: &SetTuned, rule: Rule, value: impl Fn(Label) -> Option<&'a str>) -> Vec<Choice> {
    let scored = Label::ALL.map(|label| {
        let value = value(label);
        (label, value, value.and_then(|value| set.score(value, rule)))
    });
    let choice = |&(label, value, score): &(Label, Option<&str>, Option<f64>)| {
        let others = scored.iter().filter(|(other, ..)| *other != label);
        let lost: BTreeMap<Label, f64> =
            others.filter_map(|(other, _, theirs)| Some((*other, (*theirs)? - score?))).collect();
        Choice { label, value: value.map(str::to_owned), score, lost_to: lost }
    };
    scored.iter().map(choice).collect()
}
