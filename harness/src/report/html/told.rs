//! What studies come to that are no fronts: sentences of the first screen, `**` round names.

use itertools::Itertools as _;

use crate::report::format::{mib, significant};
use crate::report::frames;
use crate::results::{AttackRecord, FramesRecord, NeedRecord, Record, SearchRecord, config, gathered};
use crate::statistics::median;
use crate::studies::need;
use crate::studies::stability::{Stability, Verdict};

/// So many cases have a sentence of their own.
const MAX_CASES: usize = 4;

/// Below this FLIP an image hardly looks different from its reference; of ray sets the same share may be wrong.
const SMALL_ERROR: f64 = 0.01;

/// Sentences on a record; none of one whose tables answer.
pub(super) fn sentences(record: &Record) -> Vec<String> {
    let of_cases = record.cases.as_ref().and_then(|_| Stability::of(record)).map(|stability| vec![cases(&stability)]);
    let of_need = || record.need.as_ref().map(|section| needs(record, section));
    let of_frames = || record.frames.as_ref().map(frames_of);
    let of_attack = || record.attack.as_ref().map(|section| vec![attacks(record, section)]);
    of_cases.or_else(of_need).or_else(of_frames).or_else(of_attack).unwrap_or_default()
}

/// How many cells are as they are expected.
fn cases(stability: &Stability) -> String {
    let cells = || stability.cases.iter().flat_map(|case| &case.cells);
    let count = |of: &[Verdict]| cells().filter(|cell| of.contains(&cell.verdict)).count();
    format!(
        "{} of {} cells fail more or less than expected; in {} nothing is wrong, in {} what a method is known for.",
        count(&[Verdict::UnexpectedFailure, Verdict::UnexpectedSuccess]),
        cells().count(),
        count(&[Verdict::Exact]),
        count(&[Verdict::Bounded, Verdict::KnownFailure])
    )
}

/// What part of each structure is needed.
fn needs(record: &Record, section: &NeedRecord) -> Vec<String> {
    let curves = need::curves(record, section);
    // Of what has nothing to shrink nothing is told.
    let own = curves.iter().filter(|curve| curve.section.view == 0 && curve.steps().next().is_some());
    let sentence = |((scene, rays), here): ((&String, &str), Vec<&need::Curve<'_>>)| {
        let part = |curve: &&need::Curve<'_>| {
            let (whole, needed) = (curve.whole.bytes()?, curve.needed(false).bytes()?);
            let name = config(&curve.section.tracer, &curve.section.preset);
            (needed < whole).then(|| format!("**{name}** needs {} of {} MiB", mib(needed), mib(whole)))
        };
        let all: Vec<Option<String>> = here.iter().map(part).collect();
        let whole = all.iter().filter(|told| told.is_none()).count();
        let shrinks = all.into_iter().flatten().join(", ");
        let whole = match whole {
            0 => None,
            1 => Some("1 needs all that it stores".to_owned()),
            count => Some(format!("{count} need all that they store")),
        };
        let parts = Some(shrinks).filter(|shrinks| !shrinks.is_empty()).into_iter().chain(whole);
        format!("{scene}, {rays}: {}.", parts.into_iter().join("; "))
    };
    let by_place = gathered(own.map(|curve| ((&curve.section.scene, curve.rays), curve)));
    by_place.into_iter().take(MAX_CASES).map(sentence).collect()
}

/// Who is fastest in a frame, and who of those whose image hardly differs, or whose rays are all right.
fn frames_of(section: &FramesRecord) -> Vec<String> {
    let sentence = |(scene, work): (usize, &String)| {
        let shown = frames::shown(section, scene, work);
        let timed = shown.iter().filter(|shown| !shown.series.is_control() && !shown.ms().is_empty());
        let timed: Vec<_> = timed.sorted_by(|a, b| median(&a.ms()).total_cmp(&median(&b.ms()))).collect();
        let error =
            |shown: &frames::Shown<'_>| match (shown.of_images(|image| image.flip).as_slice(), shown.right(2, false)) {
                ([], right) => (right.map(|share| 1.0 - share), "the share of wrong rays"),
                (flip, _) => (Some(median(flip)), "FLIP"),
            };
        let told = |shown: &&frames::Shown<'_>| {
            let (value, what) = error(shown);
            let value = value.map_or_else(|| "unknown".to_owned(), |value| significant(value, 2));
            format!("**{}** ({} ms, {what} {value})", shown.series.tracer.label(), significant(median(&shown.ms()), 3))
        };
        let good = timed.iter().find(|shown| error(shown).0.is_some_and(|error| error < SMALL_ERROR));
        let good = good.map_or_else(|| "nobody".to_owned(), told);
        let (name, fastest) = (&section.scenes[scene].scene.name, timed.first()?);
        let (_, what) = error(fastest);
        Some(format!(
            "{name}, {work}: the fastest frame is that of {}; where {what} is under {SMALL_ERROR}, that of {good}.",
            told(fastest)
        ))
    };
    frames::works(section).filter_map(sentence).take(MAX_CASES).collect()
}

/// How much more often every tracer is wrong at its worst pose.
fn attacks(record: &Record, attack: &AttackRecord) -> String {
    let share = |search: &SearchRecord, viewpoint: &str| {
        search.trace(record, viewpoint).and_then(|trace| attack.accuracy(trace)?.share)
    };
    let told = |search: &SearchRecord| {
        let worst = share(search, &search.found.first()?.viewpoint)?;
        let usual = share(search, attack.viewpoint_of(&search.scene))?;
        let [usual, worst] = [usual, worst].map(|share| significant(100.0 * share, 4));
        Some(format!("**{}** ({}) {worst} instead of {usual} %", search.tracer.label(), search.rays))
    };
    format!("Right at the worst pose found: {}.", attack.searches.iter().filter_map(told).join(", "))
}
