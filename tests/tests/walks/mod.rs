//! Shared functions of walks on the device against f64: rays over images, through views, down pyramids; depths in buckets.

mod pyramids;
mod reference;
mod seams;
mod tasks;

use reference::{Plane, Span, frustum, leaves_by, pixel_planes, stray_span};
use tasks::{MAX_PIECES, Piece, Task, choose, enter, follow, hostile, walk};
use tracebench_api::glam::DVec2;

/// Spans of rays in their views that are not f64's, and the number of rays that are surely in view.
fn stray_spans(tasks: &[Task], found: &[[f32; 4]]) -> (Vec<String>, usize) {
    let (mut strays, mut seen) = (Vec::new(), 0);
    for (task, &[begin, end, side, _]) in tasks.iter().zip(found) {
        let (ray, planes) = (task.eye_ray(), frustum(&task.view, f64::from(task.slack)));
        let span = Span { begin: f64::from(begin), end: f64::from(end) };
        strays.extend(stray_span(&ray, &planes, task.whole(), span));
        if let Some(inside) = ray.surely_inside(&planes, task.whole()) {
            seen += 1;
            let widened = frustum(&task.view, 1.000_002);
            if !leaves_by(&ray, &widened, side as usize, inside) {
                strays.push(format!("{task:?} does not leave by side {side}"));
            }
        }
    }
    (strays, seen)
}

/// Proves that the part of a ray in a view and the side by which the ray leaves it are f64's to within rounding: rays from
/// within, from the eye, from behind it and from beside, along sides and along near, through corners, from within views as
/// wide as anything and as narrow.
#[test]
fn spans_and_sides_are_those_of_f64() {
    let tasks = hostile();
    let (strays, seen) = stray_spans(&tasks, &enter(&tasks));
    assert!(strays.is_empty(), "{} of {}: {}", strays.len(), tasks.len(), strays[0]);
    assert!(seen > 2000, "{seen}");
}

/// Negative control: spans of other views and other rays are noticed, and another side.
#[test]
fn other_spans_are_noticed() {
    let tasks = hostile();
    let found = enter(&tasks);
    let notices = |change: &dyn Fn(&mut Task, &mut [f32; 4])| {
        let (mut tasks, mut found) = (tasks.clone(), found.clone());
        tasks.iter_mut().zip(&mut found).for_each(|(task, found)| change(task, found));
        stray_spans(&tasks, &found).0.len()
    };
    assert!(notices(&|task, _| task.view.tan_half_width *= 1.001) > 100);
    assert!(notices(&|task, _| task.view.near *= 1.001) > 100);
    assert!(notices(&|task, _| task.ray.t_max *= 0.1) > 100);
    assert!(notices(&|_, found| found[1] = found[0].midpoint(found[1])) > 1000);
    assert!(notices(&|_, found| found[2] = (found[2] + 1.0) % 6.0) > 1000);
}

/// Walks that are not f64's, and the number of steps: a walk's pieces must follow one upon the other from the beginning of the
/// span in the view to its end, and each must lie in its cell.
fn stray_walks(tasks: &[Task], spans: &[[f32; 4]], found: &[[Piece; MAX_PIECES]]) -> (Vec<String>, usize) {
    let (mut strays, mut steps) = (Vec::new(), 0);
    for ((task, span), pieces) in tasks.iter().zip(spans).zip(found) {
        let ray = task.eye_ray();
        let mut stray = |what: &str, piece: &Piece| strays.push(format!("{task:?}: {what} {piece:?}"));
        let taken = pieces.iter().take_while(|piece| piece.after != 0).count();
        steps += taken;
        let mut now = span[0];
        for piece in &pieces[..taken] {
            let planes = pixel_planes(&task.view, piece.pixel.map(|at| at >> piece.level), piece.level);
            if piece.begin != now || piece.end < piece.begin {
                stray("no step after the one before:", piece);
            }
            let lies_in = |t: f32| planes.iter().all(|plane| !ray.is_outside(plane, f64::from(t)));
            if !lies_in(piece.begin) || !lies_in(piece.end) {
                stray("not in its cell:", piece);
            }
            now = piece.end;
        }
        match pieces[..taken].last() {
            None if span[0] <= span[1] => strays.push(format!("{task:?} is not walked")),
            None => {}
            Some(piece) if piece.after == 2 && piece.end == span[1] => {}
            Some(piece) if piece.after == 2 => stray("not at the span's end:", piece),
            // Where the image ends, the span must, to within rounding: its end lies at the border.
            Some(piece) if piece.after == 3 => {
                let border = &frustum(&task.view, 1.0)[..4];
                if !border.iter().any(|side| ray.is_at(side, f64::from(span[1]))) {
                    stray("left before the image did:", piece);
                }
            }
            Some(piece) => stray("does not end:", piece),
        }
    }
    (strays, steps)
}

/// Proves that walks over the pixels of images, and up and down pyramids over them, cross the cells that f64 says, in order,
/// without a gap: through corners of cells, along their edges, across near, over images of one row.
#[test]
fn walks_are_those_of_f64() {
    let mut tasks = hostile();
    for pyramids in [false, true] {
        tasks.iter_mut().filter(|_| !pyramids).for_each(|task| task.levels = 1);
        let (strays, steps) = stray_walks(&tasks, &enter(&tasks), &walk(&tasks));
        assert!(strays.is_empty(), "{} of {}: {}", strays.len(), tasks.len(), strays[0]);
        assert!(steps > 10_000, "{steps}");
        tasks = hostile();
    }
}

/// Negative control: a step less, a step in the next cell, one that is too long and one in another image are noticed.
#[test]
fn other_walks_are_noticed() {
    let tasks = hostile();
    let (spans, found) = (enter(&tasks), walk(&tasks));
    let notices = |change: &dyn Fn(&mut Task, &mut [Piece; MAX_PIECES])| {
        let (mut tasks, mut found) = (tasks.clone(), found.clone());
        tasks.iter_mut().zip(&mut found).for_each(|(task, found)| change(task, found));
        stray_walks(&tasks, &spans, &found).0.len()
    };
    assert!(notices(&|_, pieces| pieces.rotate_left(1)) > 1000);
    assert!(notices(&|_, pieces| pieces[1].pixel[0] += 4 << pieces[1].level) > 1000);
    let later = |piece: &mut Piece| piece.end += 1e-3 * (piece.end - piece.begin);
    assert!(notices(&|_, pieces| later(&mut pieces[0])) > 1000);
    assert!(notices(&|task, _| task.view.size[0] += 1.0) > 1000);
}

/// Lines of the image that are not f64's, and the number compared. A line's ends are rounded where the ray is far from the eye
/// plane's parallel through them, and everything on it by as much.
fn stray_lines(tasks: &[Task], spans: &[[f32; 4]], found: &[[[f32; 4]; 2]]) -> (Vec<String>, usize) {
    let (mut strays, mut compared) = (Vec::new(), 0);
    for ((task, span), [on_line, in_pixel]) in tasks.iter().zip(spans).zip(found) {
        let (ray, view) = (task.eye_ray(), &task.view);
        let whole = Span { begin: f64::from(span[0]), end: f64::from(span[1]) };
        if whole.begin > whole.end {
            continue;
        }
        let tangents = DVec2::new(f64::from(view.tan_half_width), f64::from(view.tan_half_height));
        let relative = [whole.begin, whole.end].map(|t| ray.relative_rounding(t, tangents, f64::from(view.near)));
        let relative = relative[0] + relative[1];
        if relative > 1e-3 {
            continue;
        }
        compared += 1;
        let [x, y, t, depth] = on_line.map(f64::from);
        let point = ray.at(t);
        let size = view.size.map(f64::from);
        let across = DVec2::new(2.0 * x / size[0] - 1.0, 1.0 - 2.0 * y / size[1]) * tangents;
        let slack = relative * (depth + ray.direction.length() * t) * (1.0 + tangents.max_element());
        let off = (point.truncate() - across * point.z).abs().max_element();
        if off > slack || (point.z - depth).abs() > slack {
            strays.push(format!("{task:?}: {x} {y} at {t}, depth {depth}: off by {off} of {slack}"));
        }
        let place = [in_pixel[0] as i32, in_pixel[1] as i32];
        let part = Span { begin: f64::from(in_pixel[2]), end: f64::from(in_pixel[3]) };
        let planes: Vec<Plane> = pixel_planes(view, place, 0).to_vec();
        strays.extend(stray_span(&ray, &planes, whole, part).map(|stray| format!("{task:?}, {place:?}: {stray}")));
    }
    (strays, compared)
}

/// Proves that pixel, parameter and depth along a ray's line of the image are those of one point of the ray, and that what the
/// ray spends within that pixel is f64's.
#[test]
fn lines_are_those_of_f64() {
    let tasks = hostile();
    let (strays, compared) = stray_lines(&tasks, &enter(&tasks), &follow(&tasks));
    assert!(strays.is_empty(), "{} of {}: {}", strays.len(), tasks.len(), strays[0]);
    assert!(compared > 2000, "{compared}");
}

/// Negative control: lines of other images, parameters and depths that are a thousandth off, and parts of other pixels are
/// noticed.
#[test]
fn other_lines_are_noticed() {
    let tasks = hostile();
    let (spans, found) = (enter(&tasks), follow(&tasks));
    let notices = |change: &dyn Fn(&mut Task, &mut [[f32; 4]; 2])| {
        let (mut tasks, mut found) = (tasks.clone(), found.clone());
        tasks.iter_mut().zip(&mut found).for_each(|(task, found)| change(task, found));
        stray_lines(&tasks, &spans, &found).0.len()
    };
    assert!(notices(&|task, _| task.view.tan_half_height *= 1.01) > 300);
    assert!(notices(&|_, found| found[0][2] *= 1.01) > 1000);
    assert!(notices(&|_, found| found[0][3] *= 1.01) > 1000);
    assert!(notices(&|_, found| found[1][0] += 1.0) > 300);
}

/// Of several spans the first to begin is chosen, of equal beginnings the first offered; empty ones never are, also those that
/// begin nowhere.
#[test]
fn the_first_span_is_chosen() {
    let begins = [0.0_f32, -0.0, 1.0, 1e37, 1e38, 3.0];
    let mut offered = Vec::new();
    for index in 0..begins.len().pow(4) * 16 {
        let of = |place: u32| {
            let begin = begins[index / 16 / begins.len().pow(place) % begins.len()];
            [begin, if index >> place & 1 == 0 { begin + 2.0 } else { begin - 0.5 }]
        };
        offered.push([of(0), of(1), of(2), of(3)]);
    }
    let expected = |spans: &[[f32; 2]; 4]| -> u32 {
        let there = (0..4).filter(|place| spans[*place][0] <= spans[*place][1] && spans[*place][0] < 1e38);
        there.min_by(|a, b| spans[*a][0].partial_cmp(&spans[*b][0]).unwrap()).map_or(9, |place| place as u32)
    };
    let found = choose(&offered);
    let wrong = offered.iter().zip(&found).find(|(spans, found)| expected(spans) != **found);
    assert_eq!(wrong, None);
    assert!((0..4).chain([9]).all(|view| found.contains(&view)), "every choice is met");
}
