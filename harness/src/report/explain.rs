//! `explain.md`: wrong rays by class and cause, from an explanation.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::format::{self, thousands};
use super::markdown::{Table as Markdown, inline};
use crate::results::{Explained, ExplanationRecord, MOST_UNEXPLAINED, Run, SceneExplained};

/// The page's file.
pub const EXPLAIN_PAGE: &str = "explain.md";

/// The page.
pub fn explanation_page(run: &Run, found: &ExplanationRecord) -> String {
    let dirty = if run.provenance.dirty == Some(true) { ", changed tree" } else { "" };
    let mut page = format!(
        "# Why rays of {} are wrong\n\n{}\n\nCommit {}{dirty}, {}, run preset {}, seed {}.\n\n",
        inline(&found.tracer.label()),
        inline(&run.provenance.machine.label()),
        run.provenance.commit,
        run.provenance.started,
        run.preset,
        run.seed
    );
    page.push_str(
        "Every ray is traced on every rung of the ladder below, each of which takes one weakness away and keeps what the rungs \
         before have taken. A wrong ray (under `tight`; ties left out) has the cause that is taken away by the rung from which \
         on it is right; what is wrong on the last rung was given up there (`step_cap`) or is unexplained",
    );
    if found.judged {
        let _ = write!(
            page,
            ", but for what the judge finds the cause of: the method samples, and no samples are fine enough for `tight`. Of no set may \
             more than {} % be unexplained",
            100.0 * MOST_UNEXPLAINED
        );
    }
    page.push_str(".\n\n");
    let mut ladder = Markdown::new(&["rung", "cause", "taken away by", "source"].map(str::to_owned));
    for (rung, remedy) in found.ladder.iter().enumerate() {
        let setting = format!("`{}={}`", remedy.parameter, remedy.value);
        ladder.row(&[(rung + 1).to_string(), remedy.cause.clone(), setting, remedy.source.clone()]);
    }
    page.push_str(&ladder.text);
    page.push_str("\n## By scene\n\n");
    page.push_str(&scenes(found));
    page.push_str("\n## By class\n\n");
    page.push_str(&classes(found));
    for scene in &found.scenes {
        page.push_str(&one_scene(found, scene));
    }
    page
}

fn sum<'a>(sets: impl Iterator<Item = &'a Explained>, of: impl Fn(&Explained) -> u64) -> u64 {
    sets.map(of).sum()
}

fn scenes(found: &ExplanationRecord) -> String {
    let mut headings = vec!["scene".to_owned(), "rays".to_owned(), "ties".to_owned(), "wrong".to_owned()];
    headings.extend(found.causes().into_iter().map(str::to_owned));
    headings.push("wrong on the last rung".to_owned());
    let mut table = Markdown::new(&headings);
    let mut row = |name: &str, sets: &[&Explained]| {
        let all = || sets.iter().copied();
        let mut cells = vec![name.to_owned(), thousands(sum(all(), |set| set.count))];
        cells.push(thousands(sum(all(), |set| set.ties)));
        cells.push(thousands(sum(all(), |set| set.wrong_by_rung[0])));
        cells.extend(found.causes().iter().map(|cause| thousands(sum(all(), |set| set.of_cause(cause)))));
        cells.push(thousands(sum(all(), Explained::left)));
        table.row(&cells);
    };
    for scene in &found.scenes {
        row(&scene.scene.name, &scene.sets.iter().collect::<Vec<_>>());
    }
    row("all", &found.scenes.iter().flat_map(|scene| &scene.sets).collect::<Vec<_>>());
    table.text
}

fn classes(found: &ExplanationRecord) -> String {
    let sets = || found.scenes.iter().flat_map(|scene| &scene.sets);
    let known: BTreeSet<&String> = sets().flat_map(|set| set.causes.keys()).collect();
    if known.is_empty() {
        return "No ray is wrong.\n".to_owned();
    }
    let mut headings = vec!["class".to_owned()];
    headings.extend(found.causes().into_iter().map(str::to_owned));
    let mut table = Markdown::new(&headings);
    for class in known {
        let of = |cause: &str| {
            sum(sets(), |set| set.causes.get(class).and_then(|causes| causes.get(cause)).copied().unwrap_or(0))
        };
        let mut cells = vec![class.clone()];
        cells.extend(found.causes().iter().map(|cause| thousands(of(cause))));
        table.row(&cells);
    }
    table.text
}

fn one_scene(found: &ExplanationRecord, scene: &SceneExplained) -> String {
    let view = &scene.viewpoint;
    let mut text = format!(
        "\n## {}: {} triangles\n\nFrame {}x{}, faces {}, rays from {}x{} pixels. Wrong rays on each rung:\n\n",
        inline(&scene.scene.name),
        thousands(scene.scene.triangles),
        view.frame[0],
        view.frame[1],
        view.face,
        view.ray_image[0],
        view.ray_image[1]
    );
    let mut headings = vec!["rays".to_owned(), "query".to_owned(), "count".to_owned(), "ties".to_owned()];
    headings.push("as asked for".to_owned());
    headings.extend(found.ladder.iter().map(|rung| format!("+ {}={}", rung.parameter, rung.value)));
    headings.push("right at first, wrong on a later rung".to_owned());
    let mut table = Markdown::new(&headings);
    for set in &scene.sets {
        let mut cells = vec![set.rays.clone(), format::query(set.query).to_owned(), thousands(set.count)];
        cells.push(thousands(set.ties));
        cells.extend(set.wrong_by_rung.iter().map(|wrong| thousands(*wrong)));
        cells.push(thousands(set.wrong_on_the_way));
        table.row(&cells);
    }
    let _ = write!(text, "{}", table.text);
    for (rung, reason) in &scene.left_out {
        let _ = write!(text, "\n`{rung}` took nothing away here: {}\n", inline(reason));
    }
    text
}
