//! A tuned parameter: a row of panels a ray set. Wrong rays by class over the parameter's values from either viewpoint, and the
//! share of right ones from both, with the values that would have been chosen.

use itertools::Itertools as _;
use plotters::style::RGBColor;

use super::curves::{Curve, Measured, Values, measured};
use super::frame::{Chart, Entry, Sample};
use super::palette::{INK, Shape, Style, Styles};
use super::panel::{Aside, Axis, Mark, Panel, Position, Scale, level};
use super::{LONGEST_NAME, LONGEST_SET, LONGEST_VALUE, cut, invalid, name_with_unit, untimed_caption};
use crate::report::format;
use crate::report::tune::{CLASSES, errors, score_name, trials};
use crate::report::verdict;
use crate::results::{Row, TraceRecord};
use crate::statistics::wilson;
use crate::studies::tune::{Choice, Judged, Label, SceneTuned, SetTuned, Tuning, ViewTuned, accuracy};

const PLOT_HEIGHT: f64 = 220.0;
/// The most characters of a viewpoint's name in a panel's title.
const LONGEST_VIEW: usize = 20;
/// Radius of the marks of chosen values, how far the first is from the top or from its curve, and the next from it.
const CHOSEN: f64 = 4.5;
const FROM_TOP: f64 = 9.0;
const FROM_CURVE: f64 = 12.0;
const CHOSEN_STEP: f64 = 13.0;
/// The share of the span of agreements that is left free above and below, for the marks of chosen values.
const AIR: f64 = 0.16;

/// The curves of the scores, by viewpoint.
const VIEWPOINTS: [&str; 2] = ["own viewpoint", "other viewpoint"];

fn shape(label: Label) -> Shape {
    match label {
        Label::Default => Shape::Polygon(4, 45),
        Label::TunedHere => Shape::Star(5, 0),
        Label::TunedElsewhere => Shape::Polygon(4, 0),
        Label::TunedOnOtherScenes => Shape::Polygon(3, 90),
    }
}

/// The chart of a scene.
pub(in crate::report) fn chart(tuning: &Tuning, scene: &SceneTuned) -> Chart {
    let names = CLASSES.into_iter().chain(VIEWPOINTS);
    let styles = Styles::of_labels(names.map(str::to_owned));
    let mut panels = Vec::new();
    for rays in scene.views.iter().flat_map(|view| &view.sets).map(|set| set.rays.as_str()).unique() {
        let of_views: Vec<OfView<'_>> =
            scene.views.iter().zip(VIEWPOINTS).map(|(view, whose)| (view, set_of(view, rays), whose)).collect();
        panels.extend(of_views.iter().map(|of_view| error_panel(tuning, rays, *of_view, &styles)));
        panels.push(score_panel(tuning, rays, &of_views, &styles));
    }
    let hollow = |label: Label| Sample::Hollow(Style { colour: INK, shape: shape(label) });
    let mut key: Vec<Entry> = Label::ALL.map(|label| Entry::new(hollow(label), label.name())).into();
    key.push(Entry::new(Sample::Dashes, "control; its name alone where beyond the axis"));
    key.push(Entry::new(Sample::Bars, "95 % interval"));
    let (titles, caption) = words(tuning, scene);
    let columns = scene.views.len().min(VIEWPOINTS.len()) + 1;
    Chart::new(panels, titles, caption, [styles.legend(Sample::Line), key]).in_columns(columns, PLOT_HEIGHT)
}

/// A viewpoint with its rays of a set, and whose it is.
type OfView<'a> = (&'a ViewTuned, Option<&'a SetTuned>, &'static str);

fn set_of<'a>(view: &'a ViewTuned, rays: &str) -> Option<&'a SetTuned> {
    view.sets.iter().find(|set| set.rays == rays)
}

/// The title with the line under it, and the caption.
fn words(tuning: &Tuning, scene: &SceneTuned) -> ([String; 2], String) {
    let axis = cut(&tuning.axis.name, LONGEST_VALUE);
    let name = cut(&scene.scene.name, LONGEST_NAME);
    // Settings are many words, which a caption wraps.
    let label = tuning.tracer.label();
    let (tracer, settings) = label.split_once(' ').unwrap_or((&label, ""));
    let tracer = cut(tracer, LONGEST_VALUE);
    let title = format!("Tuning {axis} of {tracer}: {name}");
    let invalid = invalid(&verdict::tuning_controls(tuning));
    let triangles = format::thousands(scene.scene.triangles);
    let place = |view: &ViewTuned| {
        let ([width, height], [across, down]) = (view.viewpoint.ray_image, view.viewpoint.frame);
        format!(
            "rays from the pixels of a {width} × {height} image; frame {across} × {down}, faces {}",
            view.viewpoint.face
        )
    };
    let subtitle = format!(
        "{invalid}{triangles} triangles; by the rule {}; {}",
        tuning.rule.name(),
        scene.views.first().map(place).unwrap_or_default()
    );
    let settings = if settings.is_empty() { String::new() } else { format!("{tracer} with {settings}. ") };
    ([title, subtitle], settings + &untimed_caption(&tuning.provenance, &tuning.preset))
}

fn values(tuning: &Tuning, sets: &[&SetTuned]) -> Values {
    let axis = &tuning.axis;
    let skipped = |value: &String| !sets.is_empty() && sets.iter().all(|set| set.judged(value).is_none());
    let values = Values::logarithmic(name_with_unit(&axis.name, &axis.unit), &axis.values);
    values.skipping(axis.values.iter().map(skipped))
}

/// A figure of a set in the order of the axis.
fn curve(
    tuning: &Tuning,
    set: Option<&SetTuned>,
    style: Style,
    aside: Aside,
    figure: impl Fn(&SetTuned, &Judged) -> Option<Measured>,
) -> Curve {
    let of = |value: &String| set.and_then(|set| figure(set, set.judged(value)?)).filter(Measured::is_finite);
    Curve { style, hollow: false, aside, at: tuning.axis.values.iter().map(of).collect() }
}

/// The marks of the values that would have been chosen on a set; `stands` tells of a value's place in the order where and how
/// far above it the first stands, others of the same value beyond it.
fn chosen(
    tuning: &Tuning,
    set: Option<&SetTuned>,
    colour: RGBColor,
    stands: impl Fn(usize) -> Option<(Position, f64)>,
) -> Vec<Mark> {
    let mut taken: Vec<usize> = Vec::new();
    let of = |choice: &Choice| {
        let value = choice.value.as_ref()?;
        let at = tuning.axis.values.iter().position(|each| each == value)?;
        let (place, first) = stands(at)?;
        let before = taken.iter().filter(|each| **each == at).count();
        taken.push(at);
        let by = first + CHOSEN_STEP.copysign(first) * before as f64;
        Some(Mark::Above { place, by, radius: CHOSEN, style: Style { colour, shape: shape(choice.label) } })
    };
    set.into_iter().flat_map(|set| &set.choices).filter_map(of).collect()
}

fn error_panel(tuning: &Tuning, rays: &str, (view, set, whose): OfView<'_>, styles: &Styles) -> Panel {
    let share = |class: usize| {
        move |set: &SetTuned, judged: &Judged| {
            let wrong = errors(&judged.judgement, tuning.rule)[class]?;
            let trials = trials(set, &judged.judgement);
            Some(Measured { value: wrong as f64 / trials as f64, interval: wilson(wrong, trials)? })
        }
    };
    let of_class =
        |(class, name): (usize, &&str)| curve(tuning, set, styles.get(name), Aside(class, CLASSES.len()), share(class));
    let curves: Vec<Curve> = CLASSES.iter().enumerate().map(of_class).collect();
    let count = set.map_or(0, |set| set.count);
    let one_ray = 1.0 / count.max(1) as f64;
    let scale = Scale::down_to(measured(&curves).map(|one| one.value).chain([one_ray]));
    let name = cut(&view.viewpoint.name, LONGEST_VIEW);
    let title = format!("{}: {whose} {name}, {} rays", cut(rays, LONGEST_SET), format::thousands(count));
    let values = values(tuning, set.as_slice());
    // From the top on, on lines of their own.
    let chosen = chosen(tuning, set, INK, |at| Some(((*values.places.get(at)?, f64::INFINITY), -FROM_TOP)));
    let mut panel = values.panel(title, Axis { name: "rays (%), log".to_owned(), scale }, &curves, Vec::new());
    let rule = |mark: &Mark| if let Mark::Above { place, .. } = mark { Some(Mark::Rule(place.0)) } else { None };
    panel.marks.splice(0..0, chosen.iter().filter_map(rule).collect::<Vec<_>>());
    panel.marks.extend(chosen);
    panel
}

fn score_panel(tuning: &Tuning, rays: &str, views: &[OfView<'_>], styles: &Styles) -> Panel {
    let percent = |_: &SetTuned, judged: &Judged| {
        let right = accuracy(&judged.judgement, tuning.rule)?;
        let share = right.share?;
        let interval = right.interval.unwrap_or([share; 2]);
        Some(Measured { value: share * 100.0, interval: interval.map(|end| end * 100.0) })
    };
    let of = |(order, (_, set, whose)): (usize, &OfView<'_>)| {
        curve(tuning, *set, styles.get(whose), Aside(order, views.len()), percent)
    };
    let curves: Vec<Curve> = views.iter().enumerate().map(of).collect();
    let least = measured(&curves).map(|one| one.value).fold(100.0, f64::min);
    // Up to the oracle; room below it, for marks.
    let air = AIR * (100.0 - least).max(0.01);
    let scale = Scale::Span([(least - air).max(-5.0), 100.0 + air]);
    let controls = views.iter().flat_map(|(view, ..)| &view.controls);
    let traces = controls.flat_map(|row| row.traces.iter().map(move |trace| (row, trace)));
    let control = |(row, trace): (&Row, &TraceRecord)| {
        Some(level(row.tracer.label(), accuracy(&trace.judgement, tuning.rule)?.share? * 100.0))
    };
    let controls = traces.filter(|(_, trace)| trace.rays == rays).filter_map(control).collect();
    let sets: Vec<&SetTuned> = views.iter().filter_map(|(_, set, _)| *set).collect();
    let name = sets.first().map_or_else(|| tuning.rule.name().to_owned(), |set| score_name(set, tuning.rule));
    let values = values(tuning, &sets);
    let score_at = |order: usize, at: usize| Some((*curves.get(order)?.at.get(at)?)?.value);
    let mut all = Vec::new();
    for (order, (_, set, whose)) in views.iter().enumerate() {
        // Marks of the higher curve above it, of the lower one below.
        let stands = |at: usize| {
            let (own, other) = (score_at(order, at)?, score_at(1 - order, at));
            let above = if let Some(other) = other.filter(|other| own != *other) { own > other } else { order == 0 };
            Some(((*values.places.get(at)?, own), if above { FROM_CURVE } else { -FROM_CURVE }))
        };
        all.extend(chosen(tuning, *set, styles.get(whose).colour, stands));
    }
    let title = format!("{}: {name}", cut(rays, LONGEST_SET));
    let mut panel = values.panel(title, Axis { name: format!("{name} (%)"), scale }, &curves, controls);
    panel.marks.extend(all);
    panel
}

#[cfg(test)]
mod tests {
    use tracebench_api::Query;

    use super::super::tests::check_charts;
    use super::*;
    use crate::report::tune::tests::{SETS, VALUES, tuning};
    use crate::studies::tune::choose;

    /// Draws every chart, looks at each, and gives the SVGs.
    fn check(tuning: &Tuning) -> Vec<String> {
        check_charts(crate::report::tune::of_tuning(tuning).pages[0].1.charts())
    }

    /// Panels of both viewpoints and of the agreement, every class, every label, the parameter with its unit, the machine; a
    /// single viewpoint has no panel of another.
    #[test]
    fn charts_show_both_viewpoints() {
        let made = tuning(&VALUES, &["room", "hall"], 2, &SETS);
        let drawn = check(&made);
        assert_eq!(drawn.len(), 2);
        for wanted in [
            "diffuse: own viewpoint door, 131,072 rays",
            "ao: other viewpoint window",
            "diffuse: agreement footprint",
            "ao: balanced accuracy",
            "false misses",
            "late",
            "tuned here",
            "tuned elsewhere",
            "thickness (scene diagonals)",
            "oracle",
            "Example Processor",
            "Tuning thickness of screen-dda: room",
        ] {
            assert!(drawn[0].contains(wanted), "{wanted}");
        }
        let alone = check(&tuning(&VALUES, &["room"], 1, &SETS[..1]));
        assert!(!alone[0].contains("window") && alone[0].contains("own viewpoint door"));
        assert!(!drawn[0].contains("VOID"));
        let mut invalid = made;
        invalid.scenes[0].views[0].controls.clear();
        assert!(check(&invalid)[0].contains("VOID"));
    }

    /// Every choice stands at its value: on lines from the top where errors are shown, where agreement is shown at the score of
    /// its own viewpoint, the higher one's above.
    #[test]
    fn choices_stand_at_their_values() {
        let made = tuning(&VALUES, &["room", "hall"], 2, &[("diffuse", Query::Closest)]);
        let chart = chart(&made, &made.scenes[0]);
        assert_eq!(chart.panels.len(), 3);
        let marks = |panel: usize| -> Vec<(Position, f64)> {
            let above = |mark: &Mark| if let Mark::Above { place, by, .. } = mark { Some((*place, *by)) } else { None };
            chart.panels[panel].marks.iter().filter_map(above).collect()
        };
        let places = |panel: usize| -> Vec<usize> {
            let number = |value: f64| VALUES.iter().position(|each| each.parse() == Ok(value)).unwrap();
            marks(panel).into_iter().map(|((value, _), _)| number(value)).collect()
        };
        // Default, here, elsewhere, on the other scene: see the fixture.
        assert_eq!((places(0), places(1)), (vec![1, 2, 3, 3], vec![1, 3, 2, 3]));
        assert_eq!(places(2), [places(0), places(1)].concat());
        for (index, (((_, height), by), place)) in marks(2).into_iter().zip(places(2)).enumerate() {
            let (view, choice) = (index / 4, index % 4);
            let set = &made.scenes[0].views[view].sets[0];
            assert_eq!(height, set.choices[choice].score.unwrap() * 100.0);
            let other = set_of(&made.scenes[0].views[1 - view], "diffuse").unwrap();
            let theirs = other.score(&made.axis.values[place], made.rule).unwrap() * 100.0;
            assert_eq!(by > 0.0, height > theirs);
        }
        // Two of one value stand one beyond the other, and a line leads to each.
        for panel in [0, 1] {
            let of_third = marks(panel).into_iter().filter(|((value, _), _)| *value == 0.02).map(|(_, by)| by);
            let beyond = (0..of_third.clone().count()).map(|before| -FROM_TOP - CHOSEN_STEP * before as f64);
            assert!(of_third.eq(beyond) && marks(panel).iter().all(|((_, height), _)| *height == f64::INFINITY));
            let rules = chart.panels[panel].marks.iter().filter(|mark| matches!(mark, Mark::Rule(_)));
            assert_eq!(rules.count(), 4);
        }
    }

    /// What was skipped is said, names and long names find room, and nothing but ambiguous rays is drawn all the same.
    #[test]
    fn odd_tunings() {
        let mut made = tuning(&VALUES, &["room"], 2, &SETS);
        for set in made.scenes[0].views.iter_mut().flat_map(|view| &mut view.sets) {
            set.values[3].judged = None;
        }
        choose(&mut made.scenes, "0.001", made.rule);
        assert!(check(&made)[0].matches("skipped").count() == 6);
        for set in made.scenes[0].views.iter_mut().flat_map(|view| &mut view.sets) {
            set.values.iter_mut().for_each(|value| value.judged = None);
        }
        choose(&mut made.scenes, "0.001", made.rule);
        assert!(check(&made)[0].contains("nothing was measured"));
        let long = "a most particular and very long value of it ".repeat(4);
        let longer = long.clone() + "again";
        let mut names =
            tuning(&[&long, &longer, "b"], &["scene & <name> of some length ".repeat(9).as_str()], 2, &SETS);
        names.axis.name = "a parameter with a very long name ".repeat(5);
        names.scenes[0].views[0].viewpoint.name = "a viewpoint with a very long name ".repeat(5);
        names.tracer.name = "tracer".repeat(60);
        check(&names);
        // Settings are told whole, below.
        let mut set = tuning(&VALUES, &["room"], 2, &SETS);
        let settings = [("memory_access", "texture"), ("rays_per_lane", "32"), ("buckets", "16")];
        for (name, value) in settings {
            set.tracer.changed.push(name.to_owned());
            set.tracer.parameters.insert(name.to_owned(), value.into());
        }
        let told = check(&set)[0].replace('\n', " ");
        assert!(settings.iter().all(|(name, value)| told.contains(&format!("{name}={value}"))), "{told}");
        // A set that only one viewpoint has.
        let mut half = tuning(&VALUES, &["room"], 2, &SETS);
        half.scenes[0].views[1].sets.remove(0);
        choose(&mut half.scenes, "0.001", half.rule);
        check(&half);
    }
}
