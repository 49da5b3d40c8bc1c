//! `attack.md`: where tracers are wrong the most, beside their scene's own viewpoint and random poses.

use itertools::Itertools as _;

use super::document::Document;
use super::sheet::{Cell, Sheet};
use super::{Report, group, rows, summary};
use crate::results::{Accuracy, AttackRecord, PICTURES_FOLDER, PoseRecord, Record, SearchRecord, TraceRecord};
use crate::studies::attack::FINER;

/// What is made of searches.
pub(super) fn report(record: &Record) -> Option<Report> {
    let of_rows = rows(record, &group::groups(record), Sheet::new(), |_| None::<()>);
    Some(Report::of_page("attack.md", page(record, record.attack.as_ref()?)).and(of_rows))
}

fn page(record: &Record, attack: &AttackRecord) -> Document {
    let trace = |search: &SearchRecord, viewpoint: &str| search.trace(record, viewpoint);
    let accuracy = |trace: Option<&TraceRecord>| trace.and_then(|trace| attack.accuracy(trace));
    let right = |trace: Option<&TraceRecord>| accuracy(trace).map_or(Cell::None, Cell::Accuracy);
    let causes = |trace: Option<&TraceRecord>| {
        let causes = trace.map(|trace| attack.causes(trace)).unwrap_or_default().into_iter();
        causes.map(|(cause, rays)| format!("{cause} {rays}")).join(", ")
    };
    let worst = |search: &SearchRecord| trace(search, &search.found[0].viewpoint);
    let sheet = Sheet::<SearchRecord>::new()
        .column("scene", |search| Cell::Name(search.scene.clone()))
        .column("tracer", |search| search.tracer.label())
        .column("trials", |search| search.trials)
        .column("right at the scene's viewpoint", |search| right(trace(search, attack.viewpoint_of(&search.scene))))
        .column("at the worst of as many random poses", |search| right(trace(search, &search.random.viewpoint)))
        .column("at the worst pose found", |search| right(worst(search)))
        .column("worse than random", |search| {
            let interval = |trace| accuracy(trace).and_then(|Accuracy { interval, .. }| interval);
            let (found, random) = (interval(worst(search))?, interval(trace(search, &search.random.viewpoint))?);
            Some(match () {
                () if found[1] < random[0] => "yes",
                () if random[1] < found[0] => "no",
                () => "undecided",
            })
        })
        .column("causes there", |search| causes(worst(search)));
    let words = format!(
        "Every trial traces rays from {0}x{1} pixels of an admissible pose. Shares are of fresh rays, of another seed and an image {FINER} times as \
         fine along each edge, under `{2}` (of any-hit rays the balanced accuracy).",
        attack.trial_image[0],
        attack.trial_image[1],
        attack.rule.name()
    );
    let poses = |search: &SearchRecord| {
        let fresh = |pose: &PoseRecord| trace(search, &pose.viewpoint);
        let sheet = Sheet::<PoseRecord>::new()
            .column("pose", |pose| pose.viewpoint.clone())
            .column("--view", |pose| format!("`{}`", pose.view))
            .column("time (s)", |pose| Cell::number(pose.time_s, 4))
            .column("scale", |pose| Cell::number(pose.scale, 4))
            .column("trial", |pose| pose.trial)
            .column("wrong in the trial", |pose| format!("{} of {}", pose.wrong, pose.judged))
            .column("right of fresh rays", |pose| right(fresh(pose)))
            .column("causes", |pose| causes(fresh(pose)))
            .column("classes", |pose| pose.picture.as_ref().map(|name| format!("`{PICTURES_FOLDER}/{name}`")));
        let all: Vec<PoseRecord> = search.found.iter().chain([&search.random]).cloned().collect();
        let small = search.found.iter().filter_map(|pose| {
            let (viewpoint, small) = (&pose.viewpoint, pose.shrunk.as_ref()?);
            Some(format!(
                "The {viewpoint} made small, with the cause `{}`: rays {}, triangles {} and {} that keep the bounds. \
                 From the folder of the record: `{}`",
                small.cause, small.rays, small.triangles, small.markers, small.command
            ))
        });
        let title = format!("{}, {}, {}", search.scene, search.tracer.label(), search.rays);
        Document::default().heading(2, title).table(sheet.table(&all)).paragraphs(small)
    };
    let of_rays = |rays: &String| {
        let all: Vec<SearchRecord> = attack.searches.iter().filter(|search| search.rays == *rays).cloned().collect();
        Document::default().rays(2, rays, rays).table(sheet.table(&all))
    };
    let head = summary::head(record, "Where tracers are wrong the most").paragraph(words);
    head.and(attack.searches.iter().map(|search| &search.rays).unique().map(of_rays))
        .and(attack.searches.iter().map(poses))
        .and(summary::skipped(&record.skipped))
}
