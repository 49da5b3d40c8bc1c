//! Pages of planted records.

use tracebench_api::{ClockKind, Query};

use super::*;
use crate::report::fixture::{self, FrontQuality, Quality};
use crate::results::{CasesRecord, NeedRecord, PICTURES_FOLDER, PointPictures, SetPictures};

const SETS: [(&str, Query); 2] = [("diffuse", Query::Closest), ("ao", Query::Any)];
const COMMAND: &str = "tracebench report --html out.html 'a b'";
const MAKERS: Makers = (fixture::tables, |_| Vec::new());

fn point(name: &str, missed: f64, speed: f64, mib: u64, build: f64) -> FrontQuality<'_> {
    let quality = Quality { missed, blur: 1e-4 * missed, speed, clock: ClockKind::SubmitToDone };
    FrontQuality { name, quality, mib, build }
}

fn planted() -> Record {
    let points = [
        point("exact", 0.0, 1.0, 40, 4.0),
        point("exact:improved", 0.0, 2.0, 50, 5.0),
        point("rough", 0.2, 9.0, 8, 1.0),
        point("rough", 0.3, 5.0, 20, 3.0),
        point("fair", 0.0004, 4.0, 30, 0.5),
    ];
    fixture::fronts(&points, &SETS, 30.0)
}

fn page_of(records: &[(&str, Record)], most: usize) -> Page {
    let named: Vec<(String, Record)> =
        records.iter().map(|(path, record)| ((*path).to_owned(), record.clone())).collect();
    page(&named, &["later: not reached".to_owned()], MAKERS, COMMAND, most).unwrap()
}

/// What of a page a browser would fetch, or follow to elsewhere.
fn leads_out(html: &str) -> Vec<&str> {
    let namespace = "xmlns=\"http://www.w3.org/2000/svg\"";
    ["http:", "https:", " src=", "url(", "@import", "<link", "<iframe", "<img", "<object", "<base", "data:"]
        .into_iter()
        .filter(|what| html.replace(namespace, "").contains(what))
        .chain(html.match_indices("href=\"").map(|(at, _)| &html[at..at + 7]).filter(|link| *link != "href=\"#"))
        .collect()
}

fn part<'a>(html: &'a str, begin: &str, end: &str) -> &'a str {
    let from = html.find(begin).unwrap_or_else(|| panic!("no {begin}"));
    let behind = from + begin.len();
    &html[from..behind + html[behind..].find(end).unwrap_or_else(|| panic!("no {end} behind {begin}"))]
}

/// Proves that what a budget is compared with is every point that was timed, with what it costs in the units of the fields: without a
/// limit the cheapest of those that are right often enough is whom the program takes, for each aim.
#[test]
fn a_budget_has_every_point() {
    let record = planted();
    let Page { html, .. } = page_of(&[("fronts", record)], MAX_BYTES);
    let text = part(&html, "id=\"budget-points\">", "</script>").trim_start_matches("id=\"budget-points\">");
    let cases: Vec<serde_json::Value> = serde_json::from_str(text).unwrap();
    assert_eq!(cases.iter().map(|case| case["rays"].as_str().unwrap()).collect::<Vec<_>>(), ["diffuse", "ao"]);
    let needs = part(&html, "Which to take, and why", "</table>");
    let mut others = 0;
    for case in &cases {
        let points = case["points"].as_array().unwrap();
        assert_eq!(points.len(), 5);
        let mib: Vec<f64> = points.iter().map(|point| point[6].as_f64().unwrap()).collect();
        // Beside the structures there is the geometry, which is the same for all.
        let beyond: Vec<f64> = mib.iter().map(|each| (each - mib[2]).round()).collect();
        assert_eq!(beyond, [32.0, 42.0, 0.0, 12.0, 22.0]);
        for (cost, need) in [(4, "fastest"), (6, "smallest"), (5, "quickest to build")] {
            let of = |point: &&serde_json::Value| point[cost].as_f64().unwrap();
            let taken = |least: f64| {
                let enough = points.iter().filter(|point| point[2].as_f64().unwrap() >= least);
                enough.min_by(|one, other| of(one).total_cmp(&of(other))).unwrap()[1].as_str().unwrap()
            };
            let row = format!("<td>{need}</td><td>{}</td>", escape(taken(0.999)));
            assert!(needs.contains(&row), "no {row} in {needs}");
            others += usize::from(taken(0.999) != taken(0.5));
        }
    }
    // Negative control: where fewer answers must be right, others are fastest and smallest.
    assert_eq!(others, 4);
}

/// Proves that a page of fronts needs nothing else, is under the limit, tells which to choose for each need and why, names the machine at
/// every chart, and has the command. A page with a picture of elsewhere is found out.
#[test]
fn a_page_needs_nothing_else() {
    let record = planted();
    let machine = escape(&record.provenance.machine.label());
    let Page { html, dropped } = page_of(&[("fronts", record)], MAX_BYTES);
    assert_eq!(leads_out(&html), Vec::<&str>::new());
    assert_eq!(leads_out(&html.replace("<main>", "<main><img src=x>")).len(), 2);
    assert!(html.len() < MAX_BYTES && dropped.is_empty() && html.contains("Nothing for want of room"));
    assert!(html.contains("<p>Not or not wholly measured:</p><ul><li>later: not reached</li></ul>"));
    let answer = part(&html, "<section id=\"answer\"", "<section id=\"fronts\"");
    for told in [
        "<li>for <span data-rays=\"diffuse\">diffuse</span>",
        "<span data-rays=\"ao\">ao</span>",
        "</span> in room, of 3 tracers: fastest <strong>fair</strong>; smallest <strong>",
        "no other tracer is right so often",
        "rough stride=3 is faster but right in",
        "<strong>from another viewpoint it misses by",
    ] {
        assert!(answer.contains(told), "no '{told}' in {answer}");
    }
    for need in ["fastest", "smallest", "quickest to build"] {
        assert!(answer.contains(&format!("<td>{need}</td>")), "{need}");
    }
    let captions: Vec<&str> =
        html.match_indices("<figcaption>").map(|(at, _)| part(&html[at..], "<figcaption>", "</fig")).collect();
    assert!(captions.len() >= 4);
    for caption in captions {
        assert!(
            caption.contains(&machine)
                && caption.contains("room")
                && caption.contains("(%)") | caption.contains("(ms)")
        );
    }
    assert!(html.contains("tracebench report --html out.html &#39;a b&#39;"));
    let again = part(&html, "<section id=\"again\"", "</section>");
    let measured =
        "tracebench pareto --tracer exact,exact:improved,rough,fair --scene room --rays diffuse,ao --preset ";
    assert!(again.contains(measured) && again.contains(" --out fronts # "), "{again}");
    assert_eq!(
        html.matches("<svg ").count(),
        html.matches("aria-label=\"Fronts of").count() + html.matches("aria-label=\"Time of a frame").count()
    );
}

/// Proves that the first screen has a sentence a need, one chart and three links that lead somewhere; that the chart is of the ray set that
/// the fewest tracers answer well enough; and that a record of a study which is no front is told of in its own sentences, but not where a
/// control fails.
#[test]
fn the_first_screen_answers() {
    let first = |records: &[(&str, Record)]| {
        let html = page_of(records, MAX_BYTES).html;
        let first = part(&html, "<section id=\"first\"", "</section>").to_owned();
        let links: Vec<&str> =
            first.match_indices("<a href=\"#").map(|(at, _)| part(&first[at + 10..], "", "\"")).collect();
        assert!(links.iter().all(|id| html.contains(&format!("id=\"{id}\""))), "{links:?}");
        let count = links.len();
        (first, count)
    };
    let (fronts, links) = first(&[("fronts", planted())]);
    assert!(fronts.contains("<li>Fastest is <strong>fair</strong> (in 2 of 2"), "{fronts}");
    assert_eq!((fronts.matches("<li>").count(), fronts.matches("<svg ").count(), links), (3, 1, 3), "{fronts}");
    // The front of where the fewest are right often enough.
    let with = |other| fixture::fronts(&[point("exact", 0.0, 1.0, 40, 4.0), other], &SETS, 30.0);
    let (easy, hard) = (with(point("fair", 0.0004, 4.0, 30, 0.5)), with(point("rough", 0.2, 9.0, 8, 1.0)));
    let (both, _) = first(&[("easy", easy), ("hard", hard)]);
    let chart = part(&both, "<figure", "</figure>");
    assert!(chart.contains(">rough</text>") && !chart.contains(">fair</text>"), "{chart}");
    let cases = || Record { cases: Some(CasesRecord { cases: Vec::new() }), ..fixture::typical() };
    let (matrix, _) = first(&[("cases", cases())]);
    assert!(matrix.contains("<li>0 of 0 cells fail more or less than expected"), "{matrix}");
    let (invalid, _) = first(&[("cases", Record { controls: Vec::new(), ..cases() })]);
    assert!(!invalid.contains("<li>"), "{invalid}");
}

/// Proves that every point is there once with its parameters, that every front of every chart has its points, as its page says, and that
/// nothing points at a row that is not there.
#[test]
fn every_point_is_there_once() {
    let record = planted();
    let section = record.pareto.clone().unwrap();
    let html = page_of(&[("fronts", record)], MAX_BYTES).html;
    for (index, point) in section.points.iter().enumerate() {
        let row = format!("<tr id=\"r0p{index}\"");
        assert_eq!(html.matches(&row).count(), 1, "{row}");
        let row = part(&html, &row, "</tr>");
        assert!(row.contains(&format!("<td>{}</td>", point.label())), "{row}");
        for name in point.parameters.keys() {
            assert_eq!(
                row.matches(&format!("{name}=")).count(),
                1 + point.label().matches(&format!("{name}=")).count()
            );
        }
        // A mark in each of five panels of two ray sets.
        assert_eq!(html.matches(&format!("data-point=\"r0p{index}\"")).count(), 10, "{index}");
    }
    let figure = part(&html, "<figure data-scene=\"room\" data-rays=\"diffuse\"", "</figure>");
    let panel = part(figure, "<g class=\"panel\" role=\"group\" aria-label=\"speed", "</svg>");
    assert!(!panel[1..].contains("<g class=\"panel\""));
    let begin = "class=\"mark front";
    let index =
        |at: usize| part(&panel[at..], "data-index=\"", "\" data-cost")["data-index=\"".len()..].parse().unwrap();
    let mut on_front: Vec<usize> = panel.match_indices(begin).map(|(at, _)| index(at)).collect();
    on_front.sort_unstable();
    assert_eq!(on_front, fastest(&planted()));
    assert!(panel.contains("<text data-tracer=\"fair\""));
}

/// Places of the points on the front of speed over diffuse rays by footprint.
fn fastest(record: &Record) -> Vec<usize> {
    let section = record.pareto.as_ref().unwrap();
    let field = &crate::studies::pareto::fields(record, section, &section.scenes[0])[0];
    let by = *By::all(field.query).last().unwrap();
    let all = field.front_statuses(&field.entries, crate::studies::pareto::Cost::Trace, by);
    let front = all.iter().filter(|(.., status)| *status == crate::studies::pareto::FrontStatus::OnFront);
    let mut places: Vec<usize> = front.map(|(entry, ..)| entry.index).collect();
    places.sort_unstable();
    places
}

/// Proves that names of scenes and tracers, reasons and paths are text, whatever they say.
#[test]
fn hostile_names_are_text() {
    let hostile = "<script>alert('x')</script>\"><img src=q onerror=z>";
    let mut record = planted();
    let rename = |name: &mut String| *name = hostile.to_owned();
    record.rows.iter_mut().chain(&mut record.controls).for_each(|row| rename(&mut row.scene.name));
    let section = record.pareto.as_mut().unwrap();
    section.scenes.iter_mut().for_each(|scene| rename(&mut scene.scene.name));
    for name in record
        .rows
        .iter_mut()
        .map(|row| &mut row.tracer.name)
        .chain(section.points.iter_mut().map(|point| &mut point.tracer))
    {
        *name = name.replace("rough", "<b onclick=u>rough</b>");
    }
    record.skipped.push(crate::results::Skipped {
        tracer: None,
        scene: hostile.to_owned(),
        rays: None,
        reason: hostile.to_owned(),
    });
    let mut plain = fixture::typical();
    plain.rows.iter_mut().chain(&mut plain.controls).for_each(|row| rename(&mut row.scene.name));
    let html = page_of(&[(hostile, record), ("plain", plain)], MAX_BYTES).html;
    assert_eq!(html.matches("<script").count(), 2, "only the page's own and its points");
    assert!(!html.contains("<img") && !html.contains("<b onclick"));
    assert!(html.contains("data-scene=\"&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;"));
    assert!(html.contains("data-tracer=\"&lt;b onclick=u&gt;rough&lt;/b&gt;\""));
    // Its rows know the scene by its name, too.
    assert!(html.contains("<tr data-scene=\"&lt;script"));
}

/// Proves that a page that would be too large is not, that fronts stay longest, and that everything that was left out is told, once in its
/// place and once in the list.
#[test]
fn what_has_no_room_is_told() {
    let records = [("fronts", planted()), ("plain", fixture::typical())];
    let whole = page_of(&records, MAX_BYTES).html;
    let most = whole.len() * 6 / 10;
    let Page { html, dropped } = page_of(&records, most);
    assert!(html.len() <= most && !dropped.is_empty(), "{} of {most}", html.len());
    let list = part(&html, "<section id=\"left-out\"", "</section>");
    for what in &dropped {
        assert!(list.contains(&format!("<li>{}</li>", escape(what))), "{what}");
        let name = what.rsplit_once(" (").unwrap().0;
        assert!(html.contains(&format!("Left out for want of room: {}.", escape(name))), "{name}");
    }
    assert!(html.contains("aria-label=\"Fronts of room, diffuse"));
}

/// Proves that what records of several kinds come to is in their sections, each with its path; a kind that is not there has none; and that
/// a record whose controls fail answers nothing and is named.
#[test]
fn kinds_have_their_sections() {
    let table = Record { table: Some("bvh".to_owned()), ..fixture::typical() };
    let need = Record {
        need: Some(NeedRecord { max_lost_share: 0.001, max_slowdown: 1.25, curves: Vec::new() }),
        ..fixture::typical()
    };
    let cases = Record { cases: Some(CasesRecord { cases: Vec::new() }), ..fixture::typical() };
    let records =
        [("fronts", planted()), ("a-table", table), ("a-need", need), ("cases", cases), ("plain", fixture::typical())];
    let html = page_of(&records, MAX_BYTES).html;
    for (id, told) in [
        ("fronts", "Points of fronts with all parameters"),
        ("operating-points", "Operating points; what they do"),
        ("break-even", "Break-even, between"),
        ("need", "(a-need)"),
        ("tables", "(a-table)"),
        ("matrix", "(cases)"),
        ("causes", "class=\"bar\""),
        ("runs", "(plain)"),
        ("machine", "a-need (machine 1)"),
        ("rules", "What is timed"),
    ] {
        let section = part(&html, &format!("<section id=\"{id}\">"), "<section id=");
        assert!(section.contains(told), "no '{told}' in {id}");
    }
    let mut invalid = fixture::typical();
    invalid.controls.clear();
    let html = page_of(&[("spoilt", invalid)], MAX_BYTES).html;
    let answer = part(&html, "<section id=\"answer\"", "<section id=");
    assert!(answer.contains("Invalid, since a control fails, and part of no answer:</strong> spoilt"), "{answer}");
    assert!(!html.contains("<section id=\"fronts\"") && !html.contains("<section id=\"matrix\""));
}

/// Proves that smoke runs are no cases of the sentence that says which to choose, but where there is nothing else.
#[test]
fn smoke_runs_are_no_cases_beside_others() {
    let smoke = || {
        let mut record = planted();
        record.preset = "smoke".to_owned();
        record
    };
    let answer = |records: &[(&str, Record)]| {
        let html = page_of(records, MAX_BYTES).html;
        part(&html, "<section id=\"answer\"", "<section id=").to_owned()
    };
    let both = answer(&[("whole", planted()), ("smoke", smoke())]);
    assert!(both.contains("</span> in room, of 3 tracers: fastest <strong>fair</strong>;"), "{both}");
    assert!(answer(&[("smoke", smoke())]).contains("</span> in room, of 3 tracers: fastest <strong>fair</strong>;"));
}

/// Proves that of records of the same scene and ray set every row says whose it is, and that each is a case; and that one which is given
/// again, or lies elsewhere as the same, is none, and is named.
#[test]
fn records_of_the_same_are_told_apart() {
    let other = || Record { seed: planted().seed + 1, ..planted() };
    let html = page_of(&[("/home/x/a/fronts", planted()), ("b/fronts/run.json", other())], MAX_BYTES).html;
    assert!(!html.contains("home/x"));
    let answer = part(&html, "<section id=\"answer\"", "<section id=");
    assert!(
        answer.contains("</span> in room (2 records), of 3 tracers: fastest <strong>fair</strong> (in 2 of 2)"),
        "{answer}"
    );
    for name in ["a/fronts", "b/fronts"] {
        let cell = format!("<td>{name}</td>");
        // Three aims in three tables of needs, and three tracers, of two ray sets.
        assert_eq!(answer.matches(&cell).count(), 2 * (3 * 3 + 3), "{name}: {answer}");
        assert!(answer.contains(&format!("\"record\":\"{name}\"")));
        assert!(html.contains(&format!("diffuse, machine 1, record {name}")));
    }
    assert_eq!(html.matches("<th scope=\"col\">record</th>").count(), 5);
    let html = page_of(&[("fronts", planted()), ("copy", planted()), ("fronts", planted())], MAX_BYTES).html;
    let answer = part(&html, "<section id=\"answer\"", "<section id=");
    assert!(answer.contains("</span> in room, of 3 tracers: fastest <strong>fair</strong>;"), "{answer}");
    assert!(answer.contains("the same record is there:</strong> copy (as fronts), fronts (as fronts)."), "{answer}");
    assert!(!html.contains("<th scope=\"col\">record</th>"));
    let left_out = part(&html, "<section id=\"left-out\"", "</section>");
    assert!(left_out.contains("<li>copy: the same as fronts</li><li>fronts: the same as fronts</li>"), "{left_out}");
}

/// Proves that a record is called as its folder is, with as much of the way there as tells it from others, and never by the whole way.
#[test]
fn records_are_called_as_their_folders() {
    let called = |paths: &[&str]| called(paths);
    assert_eq!(called(&["/home/x/fronts", "./need/run.json.xz", "run.json"]), ["fronts", "need", "run.json"]);
    assert_eq!(called(&["/r/a/table1/", "/r/b/table1", "/r/b/table2"]), ["a/table1", "b/table1", "table2"]);
    assert_eq!(called(&["/r/a", "/r/a", "."]), ["a", "a", "."]);
}

/// Proves that the first screen names few of many doubtful records, and that each still says below what speaks against it.
#[test]
fn many_doubtful_records_do_not_fill_the_first_screen() {
    let smoke = |seed| Record { preset: "smoke".to_owned(), seed, ..fixture::typical() };
    let records = [("one", smoke(1)), ("two", smoke(2)), ("three", smoke(3)), ("four", smoke(4))];
    let html = page_of(&records, MAX_BYTES).html;
    let notes = part(&html, "<div class=\"notes\"", "</div>");
    let told = "only show that things work:</strong> one, two and 2 more, told below";
    assert!(notes.contains(told) && !notes.contains("three"), "{notes}");
    let records = part(&html, "<section id=\"machine\"", "<section id=");
    assert!(records.contains("four (machine 1, smoke run)"), "{records}");
}

/// Proves that the pictures of a point are shown, each once and named, where they lie beside the record; that one which is not what its
/// name says takes its point with it; and that without that of the truth, or with a name that leads elsewhere, none is shown.
#[test]
fn pictures_are_those_beside_the_record() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = folder.path().join(PICTURES_FOLDER);
    std::fs::create_dir(&pictures).unwrap();
    let keep = |text: &str| {
        let name = format!("{}.png", &crate::hash::sha256_of(text.as_bytes())[..32]);
        std::fs::write(pictures.join(&name), text).unwrap();
        name
    };
    let mut record = planted();
    let of_point = |point: usize| PointPictures {
        point,
        answer: keep(&format!("answer {point}")),
        class: keep(&format!("class {point}")),
        error: Some(keep(&format!("error {point}"))),
    };
    record.pareto.as_mut().unwrap().scenes[0].pictures = vec![SetPictures {
        rays: "diffuse".to_owned(),
        query: Query::Closest,
        size: [4, 2],
        distances: Some([0.5, 8.0]),
        max_error: Some(10.0),
        truth: keep("truth"),
        points: vec![of_point(0), of_point(2)],
    }];
    let path = folder.path().to_str().unwrap();
    let shown = |record: &Record| {
        let html = page_of(&[(path, record.clone())], MAX_BYTES).html;
        if !html.contains("<section id=\"pictures\"") {
            return None;
        }
        let section = part(&html, "<section id=\"pictures\"", "</section>").to_owned();
        Some((section.matches("<img ").count(), section.matches("<option ").count(), section))
    };
    let (images, options, section) = shown(&record).unwrap();
    assert_eq!((images, options, section.matches("<figure ").count()), (7, 2, 1));
    for wanted in ["alt=\"error of rough", "data-what=\"truth\"", "white 0.500, darkest 8.00", "1.0e-5 (white) to 10"] {
        assert!(section.contains(wanted), "no '{wanted}' in {section}");
    }
    std::fs::write(pictures.join(keep("class 2")), "another").unwrap();
    assert_eq!(shown(&record).map(|(images, options, _)| (images, options)), Some((4, 1)));
    let mut elsewhere = record.clone();
    elsewhere.pareto.as_mut().unwrap().scenes[0].pictures[0].truth = "../truth.png".to_owned();
    assert_eq!(shown(&elsewhere).map(|(images, options, _)| (images, options)), Some((0, 0)));
    std::fs::remove_dir_all(&pictures).unwrap();
    assert!(shown(&record).is_none());
}
