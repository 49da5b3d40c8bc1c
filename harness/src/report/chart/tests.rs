//! Charts of ordinary and of odd runs: they are drawn, show something, and no text meets another or the edge.

use std::collections::BTreeSet;

use tracebench_api::{ClockKind, Query};

use super::canvas::text_width;
use super::series::{Series, SeriesChart, SeriesPanel, series};
use super::*;
use crate::registry::TRACERS;
use crate::report::fixture::{self, FrontQuality, Quality};
use crate::report::group::groups;
use crate::report::summary::summary;
use crate::results::Judgement;

/// A text of an SVG that lies level: its box and what it says.
#[derive(Debug)]
struct Label {
    text: String,
    left: f64,
    right: f64,
    y: f64,
    size: f64,
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let start = tag.find(&format!(" {name}=\""))? + name.len() + 3;
    tag[start..].split('"').next()
}

fn labels(svg: &str) -> Vec<Label> {
    let mut labels = Vec::new();
    for part in svg.split("<text").skip(1) {
        let (tag, rest) = part.split_once('>').unwrap();
        let text = rest.split("</text>").next().unwrap().trim().replace("&apos;", "'").replace("&amp;", "&");
        if attribute(tag, "transform").is_some() || text.is_empty() {
            continue;
        }
        let number = |name: &str| attribute(tag, name).unwrap().parse::<f64>().unwrap();
        // Backend pixels throughout, as the coordinates are.
        let size = number("font-size");
        let width = text_width(&text, size);
        let left = number("x")
            - match attribute(tag, "text-anchor").unwrap_or("start") {
                "start" => 0.0,
                "middle" => width / 2.0,
                _ => width,
            };
        labels.push(Label { text, left, right: left + width, y: number("y"), size });
    }
    labels
}

/// Draws every chart of a run and looks at each.
fn check(record: &Record) -> Vec<String> {
    let summary = summary(record, &groups(record));
    check_charts(summary.charts());
    files(summary.charts()).unwrap().into_iter().map(|(name, _)| name).collect()
}

/// Draws charts, looks at each, and gives their SVGs.
pub(in crate::report) fn check_charts<'a>(charts: impl Iterator<Item = (&'a str, &'a Chart)>) -> Vec<String> {
    let check = |(stem, chart): (&str, &Chart)| {
        let svg = chart.svg();
        check_svg(stem, &svg);
        check_png(stem, &chart.drawn().png().unwrap());
        svg
    };
    charts.map(check).collect()
}

pub(in crate::report) fn check_svg(name: &str, svg: &str) {
    assert!(svg.trim_end().ends_with("</svg>") && !svg.contains("NaN") && !svg.contains("inf,"), "{name}");
    let page: Vec<f64> = attribute(svg, "viewBox").unwrap().split(' ').map(|number| number.parse().unwrap()).collect();
    let labels = labels(svg);
    assert!(labels.iter().any(|label| label.text.contains("triangles")), "{name}");
    for (index, one) in labels.iter().enumerate() {
        assert!(one.left >= 0.0 && one.right <= page[2], "{name}: {one:?} leaves the page");
        assert!(one.y >= one.size / 2.0 && one.y + one.size / 2.0 <= page[3], "{name}: {one:?} leaves the page");
        for other in &labels[..index] {
            let apart = one.right <= other.left || other.right <= one.left;
            let beside = (one.y - other.y).abs() >= 0.45 * (one.size + other.size);
            assert!(apart || beside, "{name}: {one:?} meets {other:?}");
        }
    }
}

pub(in crate::report) fn check_png(name: &str, png: &[u8]) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let colours: BTreeSet<[u8; 3]> = pixels.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    assert!(colours.len() > 30, "{name} has only {} colours", colours.len());
    let ink = pixels.chunks_exact(3).filter(|pixel| pixel.iter().any(|part| *part < 200)).count();
    assert!(ink > pixels.len() / 3 / 200, "{name} is all but empty");
}

const FAIR: Quality = Quality { missed: 0.1, blur: 1e-4, speed: 3.0, clock: ClockKind::Host };

#[test]
fn ordinary_and_crowded_runs() {
    let names = check(&fixture::typical());
    let wanted = ["error_vs_speed_room", "agreement_over_tolerance_room"];
    assert_eq!(
        names,
        wanted.iter().flat_map(|stem| [format!("{stem}.svg"), format!("{stem}.png")]).collect::<Vec<_>>()
    );
    check(&fixture::crowded());
}

#[test]
fn few_panels_and_few_tracers() {
    check(&fixture::run(&[("bvh-cpu", FAIR)], &[("primary", Query::Closest)]));
    assert_eq!(check(&fixture::run(&[("bvh-cpu", FAIR)], &[("ao", Query::Any)])).len(), 2);
    check(&fixture::run(&[], &fixture::SETS));
    assert_eq!(check(&fixture::run(&[("bvh-cpu", FAIR)], &[])).len(), 0);
    let mut alone = fixture::typical();
    alone.controls.clear();
    check(&alone);
}

#[test]
fn no_errors_and_nothing_but_errors() {
    let perfect = Quality { missed: 0.0, blur: 0.0, ..FAIR };
    check(&fixture::run(&[("a", perfect), ("b", perfect)], &fixture::SETS));
    let hopeless = Quality { missed: 1.0, blur: 1.0, ..FAIR };
    check(&fixture::run(&[("a", hopeless)], &fixture::SETS));
}

/// Four closest-hit sets take two rows of panels, and a second row of the legend.
#[test]
fn many_ray_sets() {
    let sets = ["primary", "diffuse", "mirror", "second bounce of a set with a long name"];
    let sets: Vec<_> = sets.iter().map(|name| (*name, Query::Closest)).chain([("ao", Query::Any)]).collect();
    check(&fixture::run(&[("a", FAIR), ("b", FAIR)], &sets));
}

/// Figures that no run should have, and texts longer than any page.
#[test]
fn odd_figures_and_long_texts() {
    let mut record = fixture::typical();
    record.provenance.machine.cpu = "a processor whose maker spared no word ".repeat(20);
    record.rows[0].scene.name = "scene & <name> ".repeat(30);
    record.rows[1].scene = record.rows[0].scene.clone();
    record.rows[1].tracer.name = "tracer".repeat(60);
    let oddities = [f64::NAN, f64::INFINITY, 0.0, -1.0];
    for (odd, trace) in oddities.into_iter().zip(record.rows.iter_mut().flat_map(|one| &mut one.traces)) {
        trace.mrays_per_s = odd;
        trace.times.interval_ms = [odd, odd];
        if let Judgement::Closest(judgement) = &mut trace.judgement {
            judgement.curve.push([odd, odd]);
            judgement.interval.tight = None;
        }
    }
    check(&record);
    let mut ambiguous_rays = fixture::typical();
    for trace in ambiguous_rays.rows.iter_mut().flat_map(|one| &mut one.traces) {
        match &mut trace.judgement {
            Judgement::Closest(judgement) => {
                (judgement.agreement, judgement.interval) = Default::default();
                judgement.curve.clear();
            }
            Judgement::Any(judgement) => {
                judgement.occlusion.balanced_accuracy = None;
                judgement.occlusion.balanced_accuracy_interval = None;
            }
        }
    }
    check(&ambiguous_rays);
}

/// Where clocks differ, the chart says whose is whose.
#[test]
fn clocks_are_named() {
    let record = fixture::typical();
    let svg = summary(&record, &groups(&record)).charts().next().unwrap().1.svg();
    for wanted in ["bvh-cpu [host clock]", "screen-dda [submit to done, host clock]", "do not compare"] {
        assert!(svg.contains(wanted), "{wanted}");
    }
}

/// Every tracer has a colour of its own, and a hundred and more have a look of their own.
#[test]
fn looks_differ() {
    let mut record = fixture::run(&[("t", FAIR)], &[]);
    let template = record.rows[0].clone();
    record.rows = (0..144)
        .map(|index| {
            let mut one = template.clone();
            one.tracer.name = format!("t{index}");
            one
        })
        .collect();
    let colours: BTreeSet<_> = (0..TRACERS.len()).map(colour).collect();
    assert_eq!(colours.len(), TRACERS.len());
    let styles = palette::Styles::of(&record);
    let look = |index: usize| format!("{:?}", styles.get(&format!("t{index}")));
    let looks: BTreeSet<_> = (0..144).map(look).collect();
    assert_eq!(looks.len(), 144);
}

/// Charts of whole, of missing and of odd values are drawn, with every label and setting in them.
#[test]
fn series_are_drawn_whatever_they_hold() {
    let record = fixture::typical();
    let panel = |values: Vec<Option<f64>>| SeriesPanel {
        title: "Bytes".to_owned(),
        setting: "B".to_owned(),
        steps: ["8", "16", "24"].map(str::to_owned).to_vec(),
        quantity: "bytes (MiB)".to_owned(),
        series: [false, true]
            .map(|dashed| Series { label: "tiles".to_owned(), values: values.clone(), dashed })
            .to_vec(),
    };
    let (nothing, zero) = ("nothing was measured", "0 throughout");
    for (values, notes) in [
        (vec![Some(1.0), Some(2.0), Some(30.0)], [false, false]),
        (vec![Some(1.0), None, Some(2.0)], [false, false]),
        (vec![Some(0.0), Some(2.0), Some(0.0)], [false, false]),
        (vec![Some(0.0), None, Some(0.0)], [false, true]),
        (vec![Some(f64::NAN), None, Some(-1.0)], [true, false]),
        (vec![], [true, false]),
    ] {
        let chart = SeriesChart {
            title: "Title".to_owned(),
            subtitle: "subtitle".to_owned(),
            key: Some(["solid", "broken"]),
            panels: vec![panel(values.clone()), panel(values)],
        };
        let drawn = files([("figure_x", &series(&record, chart))].into_iter()).unwrap();
        assert_eq!(drawn.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["figure_x.svg", "figure_x.png"]);
        let svg = std::str::from_utf8(&drawn[0].1).unwrap();
        assert!(["tiles", "solid", "broken (dashed)", "24", "bytes (MiB)"].iter().all(|text| svg.contains(text)));
        assert!(!svg.contains("NaN") && [nothing, zero].map(|note| svg.contains(note)) == notes, "{svg}");
    }
}

/// Proves that points of one tracer are distinguished where it is told who overtakes whom: each has a number, once in the legend with its
/// parameters and beside its line in every panel, and who is cheapest has a strong line.
#[test]
fn break_even_names_every_point() {
    let point = |name, speed, build| FrontQuality {
        name,
        quality: Quality { missed: 0.0, blur: 0.0, speed, ..FAIR },
        mib: 10,
        build,
    };
    let points =
        [point("quick", 1.0, 1.0), point("fast", 9.0, 900.0), point("fast", 3.0, 300.0), point("other", 2.0, 500.0)];
    let record = fixture::fronts(&points, &[("diffuse", Query::Closest)], 30.0);
    let section = record.pareto.as_ref().unwrap();
    let page = crate::report::pareto::page::page(&record, section, &crate::report::pareto::shown(&record, section));
    let svg = page.charts().find(|(stem, _)| stem.ends_with("room_diffuse_break_even")).unwrap().1.svg();
    let lines: Vec<&str> = svg.lines().collect();
    // Labels of ticks do not begin at their place.
    let begins = |line: &str| line.starts_with("<text ") && !line.contains("text-anchor");
    let times = |text: &str| lines.windows(2).filter(|pair| begins(pair[0]) && pair[1] == text).count();
    let panels = svg.lines().filter(|line| line.ends_with("% right")).count();
    let entries: Vec<&str> = svg
        .lines()
        .filter(|line| section.points.iter().any(|point| line.ends_with(&format!(": {}", point.label()))))
        .collect();
    assert!(panels > 1 && entries.len() == 4, "{panels}: {entries:?}");
    for (number, entry) in (1..).zip(&entries) {
        assert!(entry.starts_with(&format!("{number}: ")), "{entry}");
        assert_eq!(times(&number.to_string()), panels, "{entry}");
    }
    // One of the legend, and in a panel at least one.
    assert!(svg.lines().filter(|line| line.contains("stroke-width=\"8\"")).count() > panels);
}

/// Proves that lines of one look become one path of steps and each polygon one of its own, whose corners are where they were.
#[test]
fn compact_paths_keep_their_corners() {
    let svg = "<svg>\n<polyline fill=\"none\" opacity=\"1\" stroke=\"#000000\" stroke-width=\"2\" points=\"1,2 30,4 30,-4 \"/>\n\
        <polyline fill=\"none\" opacity=\"1\" stroke=\"#000000\" stroke-width=\"2\" points=\"40,5 7,5 \"/>\n\
        <polygon opacity=\"1\" fill=\"#FFFFFF\" points=\"5,5 5,9 2,9 \"/>\n<polygon opacity=\"1\" fill=\"#FFFFFF\" points=\"9,9 8,1 \"/>\n</svg>\n";
    let wanted = "<svg>\n<path stroke=\"#000000\" stroke-width=\"2\" d=\"m1,2 29,2 0-8m10,9-33,0\"/>\n\
        <path fill=\"#FFFFFF\" d=\"m5,5 0,4-3,0\"/>\n<path fill=\"#FFFFFF\" d=\"m9,9-1-8\"/>\n</svg>\n";
    assert_eq!(canvas::compact(svg), wanted);
}

/// Proves that markers, a shape on its rim, of one look are there once and used where they were, in their order, and that what is no marker stays.
#[test]
fn markers_of_one_look_are_drawn_once() {
    let circles = |x: u32| {
        format!(
            "<circle cx=\"{x}\" cy=\"7\" r=\"4\" fill=\"#FFFFFF\"/>\n<circle cx=\"{x}\" cy=\"7\" r=\"3\" fill=\"#000000\"/>\n"
        )
    };
    let kites = "<path fill=\"#FF0000\" d=\"m1,2 3,4-1-1\"/>\n<path fill=\"#FFFFFF\" d=\"m2,3 2,2-1-1\"/>\n";
    let alone = "<path fill=\"#00FF00\" d=\"m9,9 1,1 0-1\"/>\n<path fill=\"#0000FF\" d=\"m9,9 1,1 0-1\"/>\n";
    let made = canvas::named(&format!("<svg>\n{}{kites}{alone}{}</svg>\n", circles(5), circles(50)));
    let (looks, drawn) = made.strip_prefix("<svg>\n<defs>\n").unwrap().split_once("</defs>\n").unwrap();
    let look = |parts: &str| {
        let line =
            looks.lines().find(|line| line.ends_with(&format!(">{parts}</g>"))).unwrap_or_else(|| panic!("{looks}"));
        line.split('"').nth(1).unwrap().to_owned()
    };
    let circle = look(
        "<circle cx=\"0\" cy=\"0\" r=\"4\" fill=\"#FFFFFF\"/><circle cx=\"0\" cy=\"0\" r=\"3\" fill=\"#000000\"/>",
    );
    let kite = look("<path fill=\"#FF0000\" d=\"m0,0 3,4-1-1\"/><path fill=\"#FFFFFF\" d=\"m1,1 2,2-1-1\"/>");
    let used = |name: &str, x: u32, y: u32| format!("<use href=\"#{name}\" x=\"{x}\" y=\"{y}\"/>\n");
    let wanted =
        [used(&circle, 5, 7), used(&kite, 1, 2), alone.to_owned(), used(&circle, 50, 7), "</svg>\n".to_owned()];
    assert_eq!((looks.lines().count(), drawn), (2, &*wanted.concat()));
    assert_eq!(canvas::named("<svg>\n</svg>\n"), "<svg>\n</svg>\n");
}
