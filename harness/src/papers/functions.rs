//! Functions that a paper's data takes ([`super::expression`]), each a line.

use itertools::Itertools as _;
use serde_json::json;

use super::Scope;
use super::estimate::Estimate;
use super::evaluate::{Evaluation, Value};
use super::page::measured::{speed_with_accuracy, time_of};
use super::rows::{self, has, parameter, right, same_hits, statistic, trace};
use super::times::traced;
use crate::report::format::{edges, thousands};
use crate::report::metrics::closest;
use crate::report::sheet::Cell;
use crate::results::{Judgement, OCCLUSION, Row, Timed, TraceRecord};
use crate::statistics::wilson;

/// What a function is told.
#[derive(Clone, Copy)]
pub(super) struct Arguments<'v, 'a>(pub &'v [Value<'a>]);

impl<'a> Arguments<'_, 'a> {
    fn number(self, place: usize) -> Option<Estimate> {
        self.0.get(place)?.number()
    }

    fn row(self, place: usize) -> Option<&'a Row> {
        self.0.get(place)?.row()
    }

    fn list(self, place: usize) -> Option<Vec<Value<'a>>> {
        self.0.get(place).cloned().map(Value::items)
    }

    fn text(self, place: usize) -> Option<String> {
        self.0.get(place)?.text()
    }

    fn texts(self, place: usize) -> Option<Vec<String>> {
        self.list(place)?.iter().map(Value::text).collect()
    }

    /// Labels with their values, from a place on.
    fn labels(self, place: usize) -> Option<Vec<String>> {
        self.0.get(place..)?.iter().map(Value::text).collect()
    }

    /// The row that is told first, and its traces of the sets that are told in a place; of all where none is.
    fn traces(self, place: usize) -> Option<Vec<&'a TraceRecord>> {
        let row = self.row(0)?;
        match self.texts(place) {
            Some(sets) => sets.iter().map(|rays| trace(row, rays)).collect(),
            None => Some(row.traces.iter().collect()),
        }
    }

    /// Of a row its rays that count and those of the kinds that are told next, over closest-hit sets.
    fn of_kind(self) -> Option<[u64; 2]> {
        let kinds = self.texts(1)?;
        let all = self.traces(2)?.into_iter().filter_map(|trace| of_kinds(trace, &kinds));
        Some(all.fold([0, 0], |sum, one| [sum[0] + one[0], sum[1] + one[1]]))
    }
}

type Function = for<'a> fn(&Evaluation<'a>, Arguments<'_, 'a>) -> Option<Value<'a>>;

/// Every function by its name, with what it takes.
pub(super) const FUNCTIONS: &[(&str, Function)] = &[
    // Of a number.
    ("abs", |_, of| number(of.number(0)?.rising(f64::abs))),
    ("ceil", |_, of| number(of.number(0)?.rising(f64::ceil))),
    ("ln", |_, of| number(of.number(0)?.rising(f64::ln))),
    ("round", |_, of| number(of.number(0)?.rising(f64::round))),
    ("sqrt", |_, of| number(of.number(0)?.rising(f64::sqrt))),
    // A number with an interval from where another's begins to where a third's ends.
    ("spanning", |_, of| {
        let [value, low, high] = [of.number(0)?, of.number(1)?, of.number(2)?];
        number(Estimate { value: value.value, interval: [low.interval[0], high.interval[1]], ..low })
    }),
    ("break_even", |_, of| number(break_even(of.number(0)?, of.number(1)?))),
    // A row, and a number that its label stands beside.
    ("named", |_, of| number(Estimate { note: Some(of.row(0)?.label()), ..of.number(1)? })),
    // Of a list.
    ("first", |_, of| of.list(0)?.into_iter().next()),
    ("last", |_, of| of.list(0)?.pop()),
    ("rest", |_, of| Some(Value::List(of.list(0)?.into_iter().skip(1).collect()))),
    ("steps", |_, of| {
        let pairs = of.list(0)?.into_iter().tuple_windows();
        Some(Value::List(pairs.map(|(one, next)| Value::List(vec![one, next])).collect()))
    }),
    ("numbered", |_, of| {
        let all = of.list(0)?.into_iter().enumerate();
        Some(Value::List(all.map(|(place, each)| Value::List(vec![(place as f64).into(), each])).collect()))
    }),
    // Lists by their first numbers, from the least; those without are left out.
    ("ascending", |_, of| {
        let first = |each: &Value<'_>| if let Value::List(parts) = each { parts.first()?.number() } else { None };
        let all = of.list(0)?.into_iter().filter_map(|each| Some((first(&each)?.value, each)));
        let sorted = all.sorted_by(|one, other| one.0.total_cmp(&other.0));
        Some(Value::List(sorted.map(|(_, each)| each).collect()))
    }),
    // The first of those that are written alike.
    ("unique", |_, of| Some(Value::List(of.list(0)?.into_iter().unique_by(Value::text).collect()))),
    // All scenes; the scene, its name, the rows of every resolution and rays, those of whose rays this was said, and its ray sets, or a row's.
    ("scenes", |at, _| Some(Value::List(at.scenes.iter().cloned().map(Value::Scene).collect()))),
    ("here", |at, _| Some(Value::Scene(at.scene().clone()))),
    ("scene", |at, _| Some(Value::Text(&at.scene().rows.first()?.scene.name))),
    ("places", |at, of| {
        let scene = if let Some(Value::Scene(scene)) = of.0.first() { scene } else { at.scene() };
        Some(Value::List(scene.by_resolution().into_iter().map(Value::Scene).collect()))
    }),
    ("said", |at, of| {
        let said = of.labels(0)?;
        Some(Value::Scene(at.scene().of_rays(&pairs(&said))))
    }),
    ("sets", |_, of| Some(Value::List(of.row(0)?.traces.iter().map(|trace| Value::Text(&trace.rays)).collect()))),
    ("ray_sets", |at, _| Some(Value::List(at.scene().ray_sets().into_iter().map(Value::Text).collect()))),
    ("rows", |at, _| Some(Value::List(at.scene().rows.iter().copied().map(Value::Row).collect()))),
    ("skipped", |at, of| {
        let tracer = of.text(0)?;
        let all = at.scene().skipped.iter().filter(|skipped| skipped.tracer.as_deref() == Some(&*tracer));
        count(all.count() as u64)
    }),
    // Of a row: whether a parameter has a value, its number, what its structure says, how much it says, its bytes in a scope, those of a
    // part, and where it is.
    ("has", |_, of| Some(has(of.row(0)?, &of.text(1)?, &of.text(2)?).into())),
    ("value", |_, of| parameter(of.row(0)?, &of.text(1)?).map(Value::from)),
    ("told", |_, of| statistic(of.row(0)?, &of.text(1)?).map(Value::from)),
    // Of a row by frames a figure of one of its works: pairs of the frame's number and the figure, of frames that have one.
    ("frames", |_, of| {
        let (row, wanted) = (of.row(0)?, of.labels(1)?.join(" "));
        let pair = |(name, figure): (&String, &f64)| {
            let number: f64 = name.strip_prefix(&*wanted)?.strip_prefix(' ')?.parse().ok()?;
            Some(Value::List(vec![number.into(), (*figure).into()]))
        };
        Some(Value::List(row.structure_statistics.iter().filter_map(pair).collect()))
    }),
    ("statistics", |_, of| count(of.row(0)?.structure_statistics.len() as u64)),
    ("bytes", |at, of| {
        let name = of.text(1).unwrap_or_else(|| Scope::Structure.name().to_owned());
        let scope = Scope::ALL.into_iter().find(|scope| scope.name() == name)?;
        at.paper.bytes(of.row(0)?, scope).map(Value::from)
    }),
    ("used", |_, of| {
        let wanted = of.texts(1)?;
        let parts =
            of.row(0)?.memory.structure.iter().filter(|part| wanted.iter().any(|each| is_named(&part.name, each)));
        parts.map(|part| part.used_bytes).reduce(|sum, next| sum + next).and_then(count)
    }),
    ("of", |_, of| {
        let row = of.row(0)?;
        Some(match of.text(1)?.as_str() {
            "triangles" => (row.scene.triangles as f64).into(),
            "diagonal" => row.scene.diagonal.into(),
            "face" => f64::from(row.viewpoint.face).into(),
            "frame_width" => f64::from(row.viewpoint.frame[0]).into(),
            "frame_height" => f64::from(row.viewpoint.frame[1]).into(),
            "image_width" => f64::from(row.viewpoint.ray_image[0]).into(),
            "image_height" => f64::from(row.viewpoint.ray_image[1]).into(),
            _ => return None,
        })
    }),
    // Whether two rows have the same parameters, frame, faces and rays' image.
    ("alike", |_, of| {
        let place = |row: &Row| (row.viewpoint.ray_image, row.viewpoint.frame, row.viewpoint.face);
        let (one, other) = (of.row(0)?, of.row(1)?);
        Some((one.tracer.parameters == other.tracer.parameters && place(one) == place(other)).into())
    }),
    // Of a row's ray sets, all or those that are said: rays, a counter, a status; of one a counter a ray, how often it is right by a rule, the
    // median error of t, and counts of any-hit rays.
    ("rays", |_, of| count(of.traces(1)?.iter().map(|trace| trace.count).sum())),
    ("total", |_, of| {
        let name = of.text(1)?;
        let all = of.traces(2)?.into_iter().map(|trace| Some(trace.counters.get(&name)?.total as f64));
        all.sum::<Option<f64>>().map(Value::from)
    }),
    ("status", |_, of| {
        let name = of.text(1)?;
        count(of.traces(2)?.iter().filter_map(|trace| trace.statuses.get(&name)).sum())
    }),
    ("a_ray", |_, of| Some(trace(of.row(0)?, &of.text(2)?)?.counters.get(&of.text(1)?)?.per_ray.into())),
    ("right", |_, of| right(trace(of.row(0)?, &of.text(2)?)?, &of.text(1)?).map(Value::from)),
    ("error", |_, of| closest(trace(of.row(0)?, &of.text(1)?)?)?.position_error.p50.map(Value::from)),
    ("occlusion", |_, of| count(occlusion(trace(of.row(0)?, &of.text(2)?)?, &of.text(1)?)?)),
    // Of a row's closest-hit sets rays of kinds: so many, their share, the share as that of a sample; and in a million in a row beyond another.
    ("wrong", |_, of| count(of.of_kind()?[1])),
    ("share", |_, of| {
        let [rays, found] = of.of_kind()?;
        (rays > 0).then(|| (found as f64 / rays as f64).into())
    }),
    ("sampled_share", |_, of| {
        let [rays, found] = of.of_kind()?;
        number(Estimate::timed(found as f64 / rays as f64, wilson(found, rays)?, []))
    }),
    ("beyond", |_, of| {
        let sets = of.texts(3);
        beyond(of.row(0)?, of.row(1)?, &of.texts(2)?, sets.as_deref()).map(Value::from)
    }),
    ("same_hits", |_, of| same_hits(of.row(0)?, of.row(1)?).map(Value::from)),
    ("answered_as_first", |_, of| rows::answered_as_first(of.row(0)?).map(Value::from)),
    // Times: of a steady build, of a build's phases, of a trace, of a trace's phases; how many times as long sets take in a row as in another,
    // by equal and best launch settings; milliseconds of a time by the host's clock.
    ("build", |_, of| {
        let row = of.row(0)?;
        let Some(wanted) = of.texts(1) else { return Some(Value::Time(Timed::steady_build(row))) };
        let names = row.build.times.phases.iter().map(|phase| phase.name.as_str());
        phases(names, &wanted, |name| Timed::build_phase(row, name))
    }),
    ("time", |_, of| {
        let (row, rays) = (of.row(0)?, of.text(1)?);
        let Some(wanted) = of.texts(2) else { return traced(row, &rays).map(Value::Time) };
        let whole = trace(row, &rays)?;
        let names = whole.times.phases.iter().map(|phase| phase.name.as_str());
        phases(names, &wanted, |name| Timed::trace(row, whole).phase(name))
    }),
    ("slower", |at, of| {
        let (one, other, sets) = (of.row(0)?, of.row(1)?, of.texts(2)?);
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        at.scene().traces_ratio(one, other, &sets).map(Value::Number)
    }),
    ("ms", |_, of| if let Value::Time(time) = of.0.first()? { time.host_ms().map(Value::from) } else { None }),
    // Medians by the record's own clock: of a trace or else the build, and of phases of the build.
    ("median_time", |_, of| {
        let row = of.row(0)?;
        let times = match of.text(1) {
            Some(rays) => &trace(row, &rays)?.times,
            None => row.build.steady(),
        };
        Some(times.median_ms.into())
    }),
    ("phase_ms", |_, of| {
        let (row, wanted) = (of.row(0)?, of.texts(1)?);
        let phases = row.build.times.phases.iter();
        let wanted = phases.filter(|phase| wanted.iter().any(|each| is_named(&phase.name, each)));
        Some(wanted.map(|phase| phase.median_ms).sum::<f64>().into())
    }),
    // How a number stands in a table, and what stands there of a scene, of its rays too, and of a row.
    ("digits", |_, of| shown(Cell::Number(of.number(0)?.value, of.number(1)?.value as usize))),
    ("whole", |_, of| shown(Cell::Count(of.number(0)?.value as u64))),
    ("mib", |_, of| shown(Cell::Bytes(of.number(0)?.value))),
    ("statistic", |_, of| shown(Cell::Statistic(of.number(0)?.value))),
    ("absent", |_, _| shown(Cell::Absent)),
    ("label", |at, _| shown(Cell::Name(at.scene().label.clone()))),
    ("subtitle", |at, _| {
        let triangles = thousands(at.scene().rows.first()?.scene.triangles);
        shown(format!("{} ({triangles} triangles)", at.scene().label).into())
    }),
    ("place", |at, _| {
        let said = at.scene().rows.first()?.viewpoint.ray_overrides();
        shown(format!("{}{said}", at.scene().label).into())
    }),
    ("stands_for", |at, of| at.page?.experiment.stands_for(&of.row(0)?.scene).map(Value::Text)),
    ("scene_of", |_, of| shown(Cell::Name(of.row(0)?.scene.name.clone()))),
    ("tracer", |_, of| shown(of.row(0)?.label().into())),
    ("tracer_name", |_, of| Some(Value::Text(&of.row(0)?.tracer.name))),
    ("seconds", |_, of| shown(of.row(0)?.viewpoint.time_s.to_string().into())),
    ("image", |_, of| shown(edges(of.row(0)?.viewpoint.ray_image).into())),
    // Times of ray sets and speeds, with the accuracy of the same rays.
    ("taken", |_, of| {
        let sets = of.texts(1)?;
        told(time_of(of.row(0)?, &sets.iter().map(String::as_str).collect::<Vec<_>>())?)
    }),
    ("speed", |_, of| told(speed_with_accuracy(trace(of.row(0)?, &of.text(1)?)?)?)),
    // What the paper printed in a column, of a row's scene, with further labels and their values; and in the first place.
    ("printed", |at, of| {
        let (row, column, labels) = (of.row(0)?, of.text(1)?, of.labels(2)?);
        at.page?.printed_of(row, &pairs(&labels), &column).map(Value::from)
    }),
    ("printed_at", |at, of| {
        let (column, labels) = (of.text(0)?, of.labels(1)?);
        at.page?.printed()?.value(&pairs(&labels), &column).map(Value::from)
    }),
    ("printed_first", |at, _| (*at.page?.printed()?.rows.as_ref()?.first()?.values.first()?).map(Value::from)),
];

fn shown<'a>(cell: Cell) -> Option<Value<'a>> {
    let number = cell.value().unwrap_or(f64::NAN);
    Some(Value::Shown(cell, number))
}

fn told<'a>((value, cell): (f64, Cell)) -> Option<Value<'a>> {
    Some(Value::Shown(cell, value))
}

fn pairs(labels: &[String]) -> Vec<(&str, &str)> {
    labels.iter().map(String::as_str).tuples().collect()
}

fn number<'a>(number: Estimate) -> Option<Value<'a>> {
    Some(Value::Number(number))
}

fn count<'a>(count: u64) -> Option<Value<'a>> {
    Some((count as f64).into())
}

/// Rays that are wrong for their start under a rule: they leave out what is near it, or take the wrong side of the surface that they start on.
fn starts(trace: &TraceRecord, rule: &str) -> u64 {
    let causes = trace.judgement.causes().get(rule);
    ["near_start", "wrong_side_at_start"].iter().filter_map(|cause| causes?.get(*cause)).sum()
}

/// Rays of an any-hit set of a kind.
fn occlusion(trace: &TraceRecord, kind: &str) -> Option<u64> {
    let Judgement::Any(any) = &trace.judgement else { return None };
    match kind {
        "false_free_but_starts" => Some(any.occlusion.false_free.saturating_sub(starts(trace, OCCLUSION))),
        kind => json!(any.occlusion)[kind].as_u64(),
    }
}

/// Rays of a closest-hit set that count, and of them those of kinds, each a rule with a class or a cause.
fn of_kinds(trace: &TraceRecord, kinds: &[String]) -> Option<[u64; 2]> {
    let closest = closest(trace)?;
    let of_kind = |kind: &String| {
        let (rule, kind) = kind.split_once('.')?;
        let classes = match rule {
            "tight" => &closest.classes.tight,
            "footprint" => &closest.classes.footprint,
            _ => return None,
        };
        Some(match kind {
            "wrong" => classes.wrong(),
            "starts" => starts(trace, rule),
            "wrong_but_starts" => classes.wrong().saturating_sub(starts(trace, rule)),
            kind => match json!(classes)[kind].as_u64() {
                Some(of_class) => of_class,
                None => closest.causes.get(rule)?.get(kind).copied().unwrap_or(0),
            },
        })
    };
    let found = kinds.iter().map(of_kind).sum::<Option<u64>>()?;
    Some([trace.count.saturating_sub(closest.left_out()), found])
}

/// Rays of kinds in a million over the closest-hit sets that two rows have, or some of them, in one beyond the other.
fn beyond(one: &Row, other: &Row, kinds: &[String], sets: Option<&[String]>) -> Option<f64> {
    let mut sums = [0_u64; 3];
    for own in one.traces.iter().filter(|trace| sets.is_none_or(|sets| sets.contains(&trace.rays))) {
        let same = trace(other, &own.rays).filter(|each| each.rays_sha256 == own.rays_sha256);
        let counted = of_kinds(own, kinds).zip(same.and_then(|same| of_kinds(same, kinds)));
        let Some((here, there)) = counted else { continue };
        sums = [sums[0] + here[0], sums[1] + here[1], sums[2] + there[1]];
    }
    let [rays, here, there] = sums.map(|sum| sum as f64);
    (rays > 0.0).then(|| (here - there) / rays * 1e6)
}

/// Whether something has a name, with `*` at its end by how it begins.
fn is_named(name: &str, wanted: &str) -> bool {
    wanted.strip_suffix('*').map_or_else(|| name == wanted, |begin| name.starts_with(begin))
}

/// Phases that have these names, one after the other.
fn phases<'a>(
    names: impl Iterator<Item = &'a str> + Clone,
    wanted: &[String],
    timed: impl Fn(&'a str) -> Timed<'a>,
) -> Option<Value<'a>> {
    let lacks = |wanted: &&String| !wanted.ends_with('*') && !names.clone().any(|name| is_named(name, wanted));
    let all = names.clone().filter(|name| wanted.iter().any(|wanted| is_named(name, wanted)));
    all.map(&timed).reduce(Timed::and).filter(|_| !wanted.iter().any(|each| lacks(&each))).map(Value::Time)
}

/// How often something is done until what is owed is repaid; 0 where nothing is owed, or nothing repaid.
fn break_even(owed: Estimate, repaid: Estimate) -> Estimate {
    let nothing = owed.value <= 0.0 || repaid.value <= 0.0;
    let sure = [&owed, &repaid].iter().all(|each| each.interval[0] > 0.0);
    let surely_nothing = owed.interval[1] <= 0.0 || repaid.interval[1] <= 0.0;
    let found = owed / repaid;
    match nothing {
        true if surely_nothing => Estimate { value: 0.0, interval: [0.0; 2], ..found },
        true => Estimate { value: 0.0, interval: [0.0, f64::INFINITY], ..found },
        false if sure => found,
        false => Estimate { interval: [0.0, f64::INFINITY], ..found },
    }
}
