//! Which points a tracer is given, in which order.
//!
//! First the tracer as it was asked for, then half and double its resolution: how far a sampled method gets must not hang on the frame that
//! was asked for. Then in turn a point with one axis at another value, and one with two. Axes take turns, and every axis takes its values
//! from the nearest to its own outwards, so that whatever number of points there is, no axis but the resolution has many more of them
//! than another (`tests::every_prefix_is_fair`). A tracer's presets take turns as well: a tracer with two of them has no more points than
//! one whose presets are the same; its improved form begins with the double.

use std::collections::BTreeMap;

use itertools::Itertools as _;
use tracebench_api::{Domain, Invalidation, ParameterDescription, Preset, Value};

use crate::measure::records;
use crate::plan::{Resolution, RunPreset, TracerRequest};
use crate::results::{FrontPoint, MEMORY_ACCESS, RAYS_PER_LANE};
use crate::studies::sweep::{Multiple, RESOLUTION, SweepError, place, with_values};

/// Multiples of the resolution, from the nearest to the preset's outwards.
const RESOLUTIONS: [&str; 4] = ["1/2", "2", "1/4", "1/8"];

/// What may be changed, with the values that it takes in their order; its own is not among them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// A parameter, or `resolution`.
    pub name: String,
    /// Its values.
    pub steps: Vec<String>,
}

/// What may be changed of a tracer: the resolution where it matters, what its registration says is swept, then every other parameter that
/// has values worth sweeping, in the order of its description. Launch settings are equal for all, and what its registration excludes is
/// left out, as is what changes nothing beside the request's other values.
pub fn axes(request: &TracerRequest, preset: RunPreset) -> Vec<Axis> {
    let description = request.registration.describe();
    let taken = |name: &str| {
        ![MEMORY_ACCESS, RAYS_PER_LANE].contains(&name)
            && !request.registration.excluded_from_fronts.contains(&name)
            && request.registration.can_matter(name, &request.parameters)
    };
    let of_resolution = description.invalidated_by.contains(&Invalidation::Resolution);
    let swept = of_resolution.then_some(RESOLUTION).into_iter().chain(request.registration.sweep.iter().copied());
    let names = swept.chain(description.parameters.iter().map(|each| each.name)).filter(|name| taken(name)).unique();
    let axis = |name: &str| {
        let described = description.parameters.iter().find(|each| each.name == name);
        let steps = match described {
            Some(described) => parameter_steps(request, described),
            None if name == RESOLUTION => resolution_steps(preset, request.preset),
            None => Vec::new(),
        };
        Axis { name: name.to_owned(), steps }
    };
    names.map(axis).filter(|axis| !axis.steps.is_empty()).collect()
}

/// Multiples that leave whole edges; of improved forms the double first, so that few points of both forms have half and double.
fn resolution_steps(preset: RunPreset, form: Preset) -> Vec<String> {
    let sound = |text: &&str| Multiple::parse(text).is_some_and(|multiple| multiple.scale(preset).is_ok());
    let mut steps: Vec<String> = RESOLUTIONS.iter().filter(|text| sound(text)).map(|text| (*text).to_owned()).collect();
    if form == Preset::Improved && steps.len() > 1 {
        steps.swap(0, 1);
    }
    steps
}

/// Values from the nearest to the own one outwards, by their places in order: below and above in turn. Choices in their order.
fn parameter_steps(request: &TracerRequest, described: &ParameterDescription) -> Vec<String> {
    let own = request.parameters.value(described.name).unwrap_or(&described.published);
    let mut values: Vec<&Value> = described.sweep.iter().filter(|value| *value != own).collect();
    if let Domain::Integer { .. } | Domain::Real { .. } = described.domain {
        values.sort_by(|a, b| place(described, a).total_cmp(&place(described, b)));
        let (mut low, high): (Vec<_>, Vec<_>) =
            values.into_iter().partition(|value| place(described, value) < place(described, own));
        low.reverse();
        values = in_turn(vec![low, high]);
    }
    values.into_iter().map(ToString::to_string).collect()
}

/// All points over axes, in their order: what each changes. The first changes nothing.
pub fn order(axes: &[Axis]) -> Vec<BTreeMap<String, String>> {
    let change = |axis: &Axis, round: usize| axis.steps.get(round).map(|step| (axis.name.clone(), step.clone()));
    let rounds = axes.iter().map(|axis| axis.steps.len()).max().unwrap_or(0);
    let mut singles: Vec<BTreeMap<String, String>> = Vec::new();
    let mut pairs: Vec<BTreeMap<String, String>> = Vec::new();
    let resolution = axes.iter().filter(|axis| axis.name == RESOLUTION);
    let resolutions: Vec<_> =
        resolution.flat_map(|axis| (0..2).filter_map(|round| change(axis, round))).map(|one| [one].into()).collect();
    for round in 0..rounds {
        let step = |axis: &Axis| change(axis, if axis.name == RESOLUTION { round + 2 } else { round });
        singles.extend(axes.iter().filter_map(|axis| Some(BTreeMap::from([step(axis)?]))));
        // Every axis with the next, then with the next but one, and so on round the circle: each is in two pairs of a turn.
        for shift in 1..=axes.len() / 2 {
            let firsts = if 2 * shift == axes.len() { shift } else { axes.len() };
            for first in 0..firsts {
                let both = change(&axes[first], round).zip(change(&axes[(first + shift) % axes.len()], round));
                pairs.extend(both.map(|(one, other)| BTreeMap::from([one, other])));
            }
        }
    }
    std::iter::once(BTreeMap::new()).chain(resolutions).chain(in_turn(vec![singles, pairs])).collect()
}

/// Lists as one, an element of each in turn.
fn in_turn<T>(lists: Vec<Vec<T>>) -> Vec<T> {
    let placed = lists.into_iter().flat_map(|list| list.into_iter().enumerate());
    placed.sorted_by_key(|(place, _)| *place).map(|(_, each)| each).collect()
}

/// At most so many points for every tracer of some requests, each once; requests of one tracer share them. With each the tracer with the
/// point's values and resolution.
///
/// # Errors
/// [`SweepError`] for a value that a parameter does not take, or edges that would be no whole pixels.
pub fn points(
    requests: &[TracerRequest],
    preset: RunPreset,
    most: usize,
) -> Result<(Vec<FrontPoint>, Vec<TracerRequest>), SweepError> {
    let (mut points, mut designed): (Vec<FrontPoint>, Vec<TracerRequest>) = Default::default();
    for name in requests.iter().map(TracerRequest::name).unique() {
        let own = requests.iter().filter(|request| request.name() == name);
        let lists = own.map(|request| {
            order(&axes(request, preset)).into_iter().map(|values| (request, values)).collect::<Vec<_>>()
        });
        let first = points.len();
        for (request, values) in in_turn(lists.collect()) {
            if points.len() == first + most {
                break;
            }
            let (changed, Resolution { frame, face }) = with_values(request, preset, &values)?;
            let parameters = records::json_values(&changed.parameters);
            let same = |of: &FrontPoint| (&of.parameters, of.frame, of.face) == (&parameters, frame, face);
            if points[first..].iter().any(same) {
                continue;
            }
            let (tracer, preset) = (name.to_owned(), request.preset.name().to_owned());
            let (order, skipped) = ((points.len() - first) as u32, BTreeMap::new());
            points.push(FrontPoint { tracer, preset, order, values, parameters, frame, face, skipped });
            designed.push(changed);
        }
    }
    Ok((points, designed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::{self, TRACERS};

    fn preset() -> RunPreset {
        RunPreset::named("quick").unwrap()
    }

    fn made_up(steps: &[usize]) -> Vec<Axis> {
        let axis = |(place, count): (usize, &usize)| Axis {
            name: format!("axis {place}"),
            steps: (0..*count).map(|step| step.to_string()).collect(),
        };
        steps.iter().enumerate().map(axis).collect()
    }

    /// How many points of a design change each axis.
    fn uses(design: &[BTreeMap<String, String>], axes: &[Axis]) -> Vec<usize> {
        let of = |axis: &Axis| design.iter().filter(|point| point.contains_key(&axis.name)).count();
        axes.iter().map(of).collect()
    }

    /// Proves that in every prefix axes with as many values are changed about as often, and that points are all different; an
    /// order that exhausts one axis after the other (the negative control) is not so.
    #[test]
    fn every_prefix_is_fair() {
        for steps in [vec![4; 2], vec![3; 5], vec![5; 6], vec![4; 11]] {
            let axes = made_up(&steps);
            let design = order(&axes);
            assert!(design[0].is_empty() && design[1].len() == 1 && design[2].len() == 2);
            assert!(design.iter().enumerate().all(|(place, point)| !design[..place].contains(point)));
            let apart = |design: &[BTreeMap<String, String>]| {
                let apart = |length: usize| {
                    let uses = uses(&design[..length], &axes);
                    uses.iter().max().unwrap() - uses.iter().min().unwrap()
                };
                (1..=design.len()).map(apart).max().unwrap()
            };
            // As long as both kinds last, one single and two pairs at most stand between two axes.
            let whole = 2 * axes.len() * steps[0];
            assert!(apart(&design[..whole.min(design.len())]) <= 3, "{steps:?}");
            let mut sorted = design.clone();
            sorted.sort();
            assert!(apart(&sorted) > 3, "{steps:?}");
        }
        // Axes of different lengths: none is forgotten.
        let axes = made_up(&[1, 6, 2]);
        assert!(uses(&order(&axes)[..8], &axes).iter().all(|count| *count > 0));
        assert_eq!(order(&[]), vec![BTreeMap::new()]);
    }

    /// Proves that values go outwards from the own one, that means, what registrations exclude and what cannot matter are no axes, and that
    /// only tracers whose structures hang on the resolution have one.
    #[test]
    fn axes_are_those_of_descriptions() {
        let dirt = TracerRequest::of(registry::find("dirt").unwrap(), Preset::Published);
        let axes = axes(&dirt, preset());
        let steps = |name: &str| axes.iter().find(|axis| axis.name == name).map(|axis| axis.steps.join(" "));
        assert_eq!(axes[0].name, RESOLUTION);
        assert_eq!(axes[1].name, "tile_size");
        assert_eq!(steps("buckets").as_deref(), Some("16 32 8 40 4 1"));
        assert_eq!(steps(RESOLUTION).as_deref(), Some("1/2 2 1/4 1/8"));
        for excluded_from_fronts in ["near", "memory_access", "rays_per_lane"] {
            assert_eq!(steps(excluded_from_fronts), None, "{excluded_from_fronts}");
        }
        for registration in TRACERS {
            let described = registration.describe();
            let known = |name: &str| described.parameters.iter().any(|each| each.name == name);
            assert!(registration.excluded_from_fronts.iter().all(|name| known(name)), "{}", described.name);
            let request = TracerRequest::of(registration, Preset::Published);
            let names = registration.matters.iter().flat_map(|each| each.what.iter().chain([&each.by]));
            assert!(names.into_iter().all(|name| *name == RESOLUTION || known(name)), "{}", described.name);
            for each in &registration.matters {
                let by = described.parameters.iter().find(|other| other.name == each.by).unwrap();
                assert!(each.values.iter().all(|value| by.parse(value).is_ok()), "{} {}", described.name, each.by);
            }
            let sized = super::axes(&request, preset()).iter().any(|axis| axis.name == RESOLUTION);
            assert_eq!(sized, described.invalidated_by.contains(&Invalidation::Resolution), "{}", described.name);
        }
        // What the improved form does not read is no axis of it, nor its own parameters one of the published form.
        let improved = TracerRequest::of(registry::find("dirt").unwrap(), Preset::Improved);
        let has =
            |request: &TracerRequest, name: &str| super::axes(request, preset()).iter().any(|axis| axis.name == name);
        for (name, published) in
            [("tile_size", true), (RESOLUTION, true), ("buckets", true), ("face_tiles", false), ("slices", false)]
        {
            assert_eq!((has(&dirt, name), has(&improved, name)), (published, !published), "{name}");
        }
        let narrow = RunPreset { frame: [6, 6], face: 6, ..preset() };
        assert_eq!(resolution_steps(narrow, Preset::Published), ["1/2", "2"]);
        assert_eq!(resolution_steps(narrow, Preset::Improved), ["2", "1/2"]);
    }

    /// Proves that every tracer gets as many points or all that it has, both presets together, each once and in the order of its
    /// design, and that a longer design begins with the shorter one.
    #[test]
    fn tracers_get_as_many() {
        let requests: Vec<TracerRequest> = Preset::ALL
            .into_iter()
            .flat_map(|preset| TRACERS.iter().map(move |each| TracerRequest::of(each, preset)))
            .collect();
        let (few, _) = points(&requests, preset(), 3).unwrap();
        let (many, designed) = points(&requests, preset(), 9).unwrap();
        let shown = |request: &TracerRequest| (request.name(), records::json_values(&request.parameters));
        assert!(designed.iter().map(shown).eq(many.iter().map(|of| (of.tracer.as_str(), of.parameters.clone()))));
        for registration in TRACERS {
            let of = |points: &[FrontPoint]| -> Vec<FrontPoint> {
                points.iter().filter(|point| point.tracer == registration.name()).cloned().collect()
            };
            let (few, many) = (of(&few), of(&many));
            assert!((1..=3).contains(&few.len()) && many.len() <= 9 && many.starts_with(&few), "{}", many.len());
            assert!(many.iter().enumerate().all(|(place, point)| point.order as usize == place));
            assert!(few[0].values.is_empty() && few[0].preset == "published");
            let [published, improved] =
                [Preset::Published, Preset::Improved].map(|form| TracerRequest::of(registration, form));
            let both_forms = published.parameters != improved.parameters;
            if both_forms {
                assert!(few[1].values.is_empty() && few[1].preset == "improved", "{}", registration.name());
            }
            let sized = |form| axes(form, preset()).iter().any(|axis| axis.name == RESOLUTION);
            if sized(&published) && (sized(&improved) || !both_forms) {
                let first = if both_forms { &many[2..6] } else { &many[1..3] };
                let found: Vec<&str> = first.iter().map(|point| point.values[RESOLUTION].as_str()).collect();
                let each: &[&str] = if both_forms { &["1/2", "2", "2", "1/2"] } else { &["1/2", "2"] };
                assert_eq!(found, each, "{}", registration.name());
                assert!(first.iter().all(|point| point.values.len() == 1), "{}", registration.name());
            }
        }
        assert!(many.iter().any(|point| point.face != preset().face));
    }
}
