//! Pictures of what points on a front answer. They are traced once more, without times, and painted while their answers are there:
//! records keep none. The pictures are files beside the record, each named by its hash.

use itertools::Itertools as _;
use serde_json::Value;
use tracebench_api::Query;

use super::field::{By, Cost, Field};
use super::front::FrontStatus;
use crate::files::OutputFolder;
use crate::judge::Rule;
use crate::measure::session::{PreparedRays, Session};
use crate::measure::{self, MAX_RESIDENT, Observations, RunError};
use crate::render::painted::{Canvas, Painted};
use crate::results::{PointPictures, SetPictures};
use crate::studies::keep_picture;

/// Points that stand on a front by the rule that charts are drawn by, at any cost; no more than are there at a time.
pub(super) fn shown(fields: &[Field<'_>], costs: &[Cost]) -> Vec<usize> {
    let drawn = fields.iter().filter_map(|field| Some((field, *By::all(field.query).last()?)));
    let all = drawn.cartesian_product(costs);
    let all = all.flat_map(|((field, by), cost)| field.front_statuses(&field.entries, *cost, by));
    let on_front = all.filter(|(.., front_status)| *front_status == FrontStatus::OnFront);
    on_front.map(|(entry, ..)| entry.index).unique().take(MAX_RESIDENT).collect()
}

/// Paints what some points answered to a ray set, into a folder of results.
pub(super) fn paint(
    session: &Session,
    size: [u32; 2],
    rays: &PreparedRays,
    told: &[Option<Observations>],
    (points, names): (&[usize], &[&str]),
    results: &OutputFolder,
) -> Result<Value, RunError> {
    let canvas = Canvas { size, pixels: &rays.pixels };
    let keep = |painted: Painted| keep(&painted, results);
    let truth: Vec<Option<f64>> = rays.answers.iter().map(|answer| answer.hit.map(|hit| hit.t)).collect();
    let is_any = rays.set.query == Query::Any;
    let range = truth.iter().flatten().copied().minmax_by(f64::total_cmp).into_option();
    let range = range.map_or([0.0; 2], <[f64; 2]>::from);
    let seen = |t: &[Option<f64>]| match is_any {
        true => canvas.occlusion(&t.iter().map(Option::is_some).collect::<Vec<_>>()),
        false => canvas.distances(range, t),
    };
    let greatest = session.truth.diagonal();
    let mut pictures = SetPictures {
        rays: rays.set.name.to_owned(),
        query: rays.set.query,
        size,
        distances: (!is_any).then_some(range),
        max_error: (!is_any).then_some(greatest),
        truth: keep(seen(&truth))?,
        points: Vec::new(),
    };
    for ((point, name), told) in points.iter().zip(names).zip(told) {
        let Some(Observations { hits, .. }) = told else { continue };
        let t: Vec<Option<f64>> = hits.iter().map(|hit| hit.is_hit().then(|| f64::from(hit.t))).collect();
        let classes = session.classes(name, rays, Rule::Footprint, hits)?;
        pictures.points.push(PointPictures {
            point: *point,
            answer: keep(seen(&t))?,
            class: keep(canvas.classes(&classes))?,
            error: if is_any { None } else { Some(keep(canvas.errors(greatest, &truth, &t))?) },
        });
    }
    measure::told(&pictures)
}

/// Writes what was painted beside the record, and gives its name.
pub(in crate::studies) fn keep(painted: &Painted, results: &OutputFolder) -> Result<String, RunError> {
    keep_picture(&painted.png().map_err(|error| RunError::Picture(error.to_string()))?, results)
}
