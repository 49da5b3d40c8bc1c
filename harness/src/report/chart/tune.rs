//! A tuned parameter: a row of panels a ray set. Wrong rays by class over the parameter's values from either viewpoint, and the
//! share of right ones from both, with the values that would have been chosen.

use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;

use super::canvas::{Canvas, Drawn, Figure, register};
use super::frame::{Entry, Frame, Sample};
use super::palette::{GREY, INK, Shape, Style, Styles};
use super::plot::{Mark, Panel, Places, Scale, Series, Values, draw_panel, share_scale};
use super::{LONGEST_NAME, LONGEST_SET, LONGEST_VALUE, cut, name_with_unit, untimed_caption};
use crate::report::format;
use crate::report::tune::{Errors, score_name, trials};
use crate::report::verdict::{self, Verdict};
use crate::statistics::wilson;
use crate::studies::tune::{Choice, Judged, Label, SceneTuned, SetTuned, Tuning, ViewTuned, interval, score};

const PLOT_HEIGHT: f64 = 220.0;
/// The most characters of a viewpoint's name in a panel's title.
const LONGEST_VIEW: usize = 20;
/// Radius of the marks of chosen values, and the distance from one to the next.
const CHOSEN: f64 = 4.5;
const CHOSEN_STEP: f64 = 13.0;
/// The share of the span of agreements that is left free above and below, for the marks of chosen values.
const AIR: f64 = 0.16;

/// The classes of wrong rays, with how many there are.
type Class = (&'static str, fn(&Errors) -> Option<u64>);
const CLASSES: [Class; 4] = [
    ("false misses", |errors| Some(errors.false_misses)),
    ("false hits", |errors| Some(errors.false_hits)),
    ("early", |errors| errors.early),
    ("late", |errors| errors.late),
];
/// The curves of the scores, by viewpoint.
const VIEWPOINTS: [&str; 2] = ["own viewpoint", "other viewpoint"];

/// A chosen value in a panel.
#[derive(Debug)]
struct Chosen {
    label: Label,
    /// Its place along the axis.
    place: usize,
    /// Its height on a curve, and whether it stands above that or below; none in a panel that has them all at the top.
    on: Option<(f64, bool)>,
    colour: RGBColor,
}

/// The chart of a scene.
#[derive(Debug)]
pub(super) struct TuneFigure {
    frame: Frame,
    panels: Vec<(Panel, Values, Vec<Chosen>)>,
}

fn shape(label: Label) -> Shape {
    match label {
        Label::Default => Shape::Polygon(4, 45),
        Label::TunedHere => Shape::Star(5, 0),
        Label::TunedElsewhere => Shape::Polygon(4, 0),
        Label::TunedOnOtherScenes => Shape::Polygon(3, 90),
    }
}

impl TuneFigure {
    /// Takes what it shows from a scene of a tuning.
    pub(super) fn new(tuning: &Tuning, scene: &SceneTuned) -> Self {
        // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
        let _ = register();
        let names = CLASSES.iter().map(|(name, _)| *name).chain(VIEWPOINTS);
        let styles = Styles::of_labels(names.clone().map(str::to_owned));
        let mut sets: Vec<&str> = Vec::new();
        for set in scene.views.iter().flat_map(|view| &view.sets) {
            if !sets.contains(&set.rays.as_str()) {
                sets.push(&set.rays);
            }
        }
        let mut panels = Vec::new();
        for rays in sets {
            let of_views: Vec<_> =
                scene.views.iter().take(VIEWPOINTS.len()).map(|view| (view, set_of(view, rays))).collect();
            panels.extend(
                of_views
                    .iter()
                    .zip(VIEWPOINTS)
                    .map(|((view, set), whose)| error_panel(tuning, rays, (view, *set), whose, &styles)),
            );
            panels.push(score_panel(tuning, rays, &of_views, &styles));
        }
        let legend = names.map(|name| Entry { sample: Sample::Line(styles.get(name)), label: name.to_owned() });
        let columns = scene.views.len().min(VIEWPOINTS.len()) + 1;
        let frame = frame(tuning, scene, columns, panels.len(), legend.collect());
        Self { frame, panels }
    }
}

fn set_of<'a>(view: &'a ViewTuned, rays: &str) -> Option<&'a SetTuned> {
    view.sets.iter().find(|set| set.rays == rays)
}

fn frame(tuning: &Tuning, scene: &SceneTuned, columns: usize, panels: usize, legend: Vec<Entry>) -> Frame {
    let hollow = |label: Label| Sample::Hollow(Style { colour: INK, shape: shape(label) });
    let mut key: Vec<Entry> =
        Label::ALL.map(|label| Entry { sample: hollow(label), label: label.name().to_owned() }).into();
    key.push(Entry { sample: Sample::Dashes, label: "control; its name alone where beyond the axis".to_owned() });
    key.push(Entry { sample: Sample::Bars, label: "95 % interval".to_owned() });
    let axis = cut(&tuning.axis.name, LONGEST_VALUE);
    let name = cut(&scene.scene.name, LONGEST_NAME);
    // Settings are many words, which a caption wraps.
    let label = tuning.tracer.label();
    let (tracer, settings) = label.split_once(' ').unwrap_or((&label, ""));
    let tracer = cut(tracer, LONGEST_VALUE);
    let title = format!("Tuning {axis} of {tracer}: {name}");
    let void = if verdict::tuning_controls(tuning) == Verdict::Sound { "" } else { "VOID, CONTROLS FAIL: " };
    let triangles = format::thousands(scene.scene.triangles);
    let place = |view: &ViewTuned| {
        let ([width, height], [across, down]) = (view.viewpoint.ray_image, view.viewpoint.frame);
        format!(
            "rays from the pixels of a {width} × {height} image; frame {across} × {down}, faces {}",
            view.viewpoint.face
        )
    };
    let subtitle = format!(
        "{void}{triangles} triangles; by the rule {}; {}",
        tuning.rule.name(),
        scene.views.first().map(place).unwrap_or_default()
    );
    let settings = if settings.is_empty() { String::new() } else { format!("{tracer} with {settings}. ") };
    let caption = settings + &untimed_caption(&tuning.provenance, &tuning.preset);
    Frame::in_columns(columns, PLOT_HEIGHT, panels, [title, subtitle], &caption, key, legend)
}

fn values(tuning: &Tuning, sets: &[&SetTuned]) -> Values {
    let axis = &tuning.axis;
    let labels = axis.values.iter().map(|value| cut(value, LONGEST_VALUE)).collect();
    let skipped = |value: &String| !sets.is_empty() && sets.iter().all(|set| set.judged(value).is_none());
    let skipped = axis.values.iter().map(skipped).collect();
    Values::logarithmic(name_with_unit(&axis.name, &axis.unit), &axis.values, labels, skipped)
}

/// Marks in the order of the axis.
fn marks(
    tuning: &Tuning,
    set: Option<&SetTuned>,
    mark: impl Fn(&SetTuned, &Judged) -> Option<Mark>,
) -> Vec<Option<Mark>> {
    let of = |value: &String| set.and_then(|set| mark(set, set.judged(value)?));
    let whole = |mark: &Mark| mark.value.is_finite() && mark.interval.iter().all(|end| end.is_finite());
    tuning.axis.values.iter().map(|value| of(value).filter(whole)).collect()
}

/// The chosen values of a set; `height` tells where each stands.
fn chosen(
    tuning: &Tuning,
    set: Option<&SetTuned>,
    colour: RGBColor,
    height: impl Fn(usize) -> Option<(f64, bool)>,
) -> Vec<Chosen> {
    let of = |choice: &Choice| {
        let value = choice.value.as_ref()?;
        let place = tuning.axis.values.iter().position(|each| each == value)?;
        Some(Chosen { label: choice.label, place, on: height(place), colour })
    };
    set.into_iter().flat_map(|set| set.choices.iter().filter_map(of)).collect()
}

fn error_panel(
    tuning: &Tuning,
    rays: &str,
    (view, set): (&ViewTuned, Option<&SetTuned>),
    whose: &str,
    styles: &Styles,
) -> (Panel, Values, Vec<Chosen>) {
    let mark = |of: fn(&Errors) -> Option<u64>| {
        move |set: &SetTuned, judged: &Judged| {
            let wrong = of(&Errors::of(&judged.judgement, tuning.rule))?;
            let trials = trials(set, &judged.judgement);
            Some(Mark { value: wrong as f64 / trials as f64, interval: wilson(wrong, trials)? })
        }
    };
    let series: Vec<Series> = CLASSES
        .iter()
        .map(|(name, of)| Series { style: styles.get(name), hollow: false, marks: marks(tuning, set, mark(*of)) })
        .collect();
    let shares = series.iter().flat_map(|series| series.marks.iter().flatten()).map(|mark| mark.value);
    let count = set.map_or(0, |set| set.count);
    let scale = share_scale(count, shares);
    let name = cut(&view.viewpoint.name, LONGEST_VIEW);
    let title = format!("{}: {whose} {name}, {} rays", cut(rays, LONGEST_SET), format::thousands(count));
    let panel = Panel { title, y_name: "rays (%), log".to_owned(), scale, series, controls: Vec::new() };
    (panel, values(tuning, &set.into_iter().collect::<Vec<_>>()), chosen(tuning, set, INK, |_| None))
}

fn score_panel(
    tuning: &Tuning,
    rays: &str,
    views: &[(&ViewTuned, Option<&SetTuned>)],
    styles: &Styles,
) -> (Panel, Values, Vec<Chosen>) {
    let mark = |_: &SetTuned, judged: &Judged| {
        let share = score(&judged.judgement, tuning.rule)?;
        let interval = interval(&judged.judgement, tuning.rule).unwrap_or([share; 2]);
        Some(Mark { value: share * 100.0, interval: interval.map(|end| end * 100.0) })
    };
    let of = |((_, set), name): (&(&ViewTuned, Option<&SetTuned>), &str)| Series {
        style: styles.get(name),
        hollow: false,
        marks: marks(tuning, *set, mark),
    };
    let series: Vec<Series> = views.iter().zip(VIEWPOINTS).map(of).collect();
    let found = series.iter().flat_map(|series| series.marks.iter().flatten()).map(|mark| mark.value);
    let least = found.fold(100.0, f64::min);
    // Up to the oracle; room below it, for marks.
    let air = AIR * (100.0 - least).max(0.01);
    let scale = Scale::Span([(least - air).max(-5.0), 100.0 + air]);
    let mut controls: Vec<(String, f64)> = Vec::new();
    for (view, _) in views {
        for control in &view.controls {
            for trace in control.traces.iter().filter(|trace| trace.rays == rays) {
                let Some(share) = score(&trace.judgement, tuning.rule) else { continue };
                let named = (control.tracer.label(), share * 100.0);
                if !controls.contains(&named) {
                    controls.push(named);
                }
            }
        }
    }
    let sets: Vec<&SetTuned> = views.iter().filter_map(|(_, set)| *set).collect();
    let name = sets.first().map_or_else(|| tuning.rule.name().to_owned(), |set| score_name(set, tuning.rule));
    let title = format!("{}: {name}", cut(rays, LONGEST_SET));
    let at = |curve: usize, place: usize| series.get(curve)?.marks.get(place)?.map(|mark| mark.value);
    let mut all = Vec::new();
    for (curve, ((_, set), name)) in views.iter().zip(VIEWPOINTS).enumerate() {
        // Marks of the higher curve above it, of the lower one below.
        let height = |place: usize| {
            let (own, other) = (at(curve, place)?, at(1 - curve, place));
            Some((own, other.map_or(curve == 0, |other| own > other || (own == other && curve == 0))))
        };
        let found = chosen(tuning, *set, styles.get(name).colour, height);
        all.extend(found.into_iter().filter(|one| one.on.is_some()));
    }
    let panel = Panel { title, y_name: format!("{name} (%)"), scale, series, controls };
    (panel, values(tuning, &sets), all)
}

impl Figure for TuneFigure {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        for (index, (panel, values, chosen)) in self.panels.iter().enumerate() {
            let places = Places::new(self.frame.panel(index), values, &panel.scale);
            draw_panel(canvas, panel, values, &places)?;
            draw_chosen(canvas, &places, chosen)?;
        }
        Ok(())
    }
}

/// The chosen values: above or below their curves, else from the top on lines of their own.
fn draw_chosen<DB: DrawingBackend>(canvas: &Canvas<DB>, places: &Places, all: &[Chosen]) -> Drawn {
    let rect = places.rect;
    for (index, one) in all.iter().enumerate() {
        let same = |other: &&Chosen| other.place == one.place && other.on == one.on;
        let away = CHOSEN_STEP * all[..index].iter().filter(same).count() as f64;
        let x = places.x(one.place);
        let y = match one.on {
            None => {
                canvas.dashed((x, rect.top), (x, rect.bottom), GREY, 0.5)?;
                rect.top + 9.0 + away
            }
            Some((value, true)) => places.y(value) - 12.0 - away,
            Some((value, false)) => places.y(value) + 12.0 + away,
        };
        let y = y.clamp(rect.top + CHOSEN, rect.bottom - CHOSEN);
        canvas.hollow_marker((x, y), CHOSEN, Style { colour: one.colour, shape: shape(one.label) })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use tracebench_api::Query;

    use super::super::tests::{check_png, check_svg};
    use super::super::tune_charts;
    use super::*;
    use crate::report::tune::tests::{SETS, VALUES, tuning};
    use crate::studies::tune::choose;

    /// Draws every chart, looks at each, and gives the SVGs.
    fn check(tuning: &Tuning) -> Vec<String> {
        let stems: Vec<String> = (0..tuning.scenes.len()).map(|index| format!("tune_{index}")).collect();
        let mut drawn = Vec::new();
        for file in tune_charts(tuning, &stems).unwrap() {
            if file.name.ends_with(".svg") {
                let svg = String::from_utf8(file.contents).unwrap();
                check_svg(&file.name, &svg);
                drawn.push(svg);
            } else {
                check_png(&file.name, &file.contents);
            }
        }
        drawn
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
        let mut void = made;
        void.scenes[0].views[0].controls.clear();
        assert!(check(&void)[0].contains("VOID"));
    }

    /// Every choice stands at its value: on lines from the top where errors are shown, where agreement is shown at the score of
    /// its own viewpoint, the higher one's above.
    #[test]
    fn choices_stand_at_their_values() {
        let made = tuning(&VALUES, &["room", "hall"], 2, &[("diffuse", Query::Closest)]);
        let figure = TuneFigure::new(&made, &made.scenes[0]);
        assert_eq!(figure.panels.len(), 3);
        let places = |panel: usize| figure.panels[panel].2.iter().map(|one| one.place).collect::<Vec<_>>();
        // Default, here, elsewhere, on the other scene: see the fixture.
        assert_eq!((places(0), places(1)), (vec![1, 2, 3, 3], vec![1, 3, 2, 3]));
        assert_eq!(places(2), [places(0), places(1)].concat());
        for (index, one) in figure.panels[2].2.iter().enumerate() {
            let (view, choice) = (index / 4, index % 4);
            let set = &made.scenes[0].views[view].sets[0];
            let (height, above) = one.on.unwrap();
            assert_eq!(height, set.choices[choice].score.unwrap() * 100.0);
            let other = set_of(&made.scenes[0].views[1 - view], "diffuse").unwrap();
            let theirs =
                score(&other.judged(&made.axis.values[one.place]).unwrap().judgement, made.rule).unwrap() * 100.0;
            assert_eq!(above, height > theirs);
        }
        assert!(figure.panels[..2].iter().all(|(_, _, chosen)| chosen.iter().all(|one| one.on.is_none())));
    }

    /// What was skipped is said, names and long names find room, and nothing but ties is drawn all the same.
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
        let settings = [("reads", "texture"), ("rays_per_lane", "32"), ("buckets", "16")];
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
