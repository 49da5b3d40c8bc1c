//! Answers of any program to a set of rays, as a folder of arrays.

use std::path::Path;

use tracebench_api::{Hit, NO_PRIMITIVE, Query, Status};

use super::{ExchangeError, NO_TRIANGLE, SavedRays, npy, text};
use crate::results::SelfReported;

/// What a program answered.
#[derive(Clone, Debug)]
pub struct Answers {
    /// By ray of the set.
    pub hits: Vec<Hit>,
    /// Whether it names triangles.
    pub names_triangles: bool,
    /// Times, if it tells any.
    pub self_reported: Option<SelfReported>,
}

/// Reads the answers to a set of rays.
///
/// # Errors
/// [`ExchangeError`] with the field that is not as it must be: other rays, missing or repeated ones, a type or shape, no number, a t out of
/// its ray's span.
pub fn read(folder: &Path, set: &SavedRays) -> Result<Answers, ExchangeError> {
    let (count, path) = (set.rays.len(), |name: &str| folder.join(name));
    let invalid = |name: &str, problem: String| ExchangeError::invalid(&path(name), problem);
    let optional = |name: &str| Some(path(name)).filter(|path| path.symlink_metadata().is_ok());
    if text(&path("rays_sha256"))?.trim() != set.manifest.rays_sha256 {
        let problem = format!("is not the set's {}: these are answers to other rays", set.manifest.rays_sha256);
        return Err(invalid("rays_sha256", problem));
    }
    let index = optional("index.npy").map(|path| npy::read::<u32>(&path, None, count)).transpose()?;
    let triangles = optional("triangle.npy").map(|path| npy::read::<u32>(&path, None, count)).transpose()?;
    let is_any = set.manifest.query == Query::Any;
    let occluded = if is_any { npy::read::<bool>(&path("occluded.npy"), None, count)? } else { Vec::new() };
    let of_f32 = |_| -> Result<Vec<f64>, ExchangeError> {
        Ok(npy::read::<f32>(&path("t.npy"), None, count)?.into_iter().map(f64::from).collect())
    };
    let t = if is_any { Vec::new() } else { npy::read::<f64>(&path("t.npy"), None, count).or_else(of_f32)? };
    let mut hits = vec![Hit::miss(Status::Unwritten); count];
    for at in 0..count {
        let place = index.as_ref().map_or(at, |index| index[at] as usize);
        let (Some(ray), Some(slot)) = (set.rays.get(place), hits.get_mut(place)) else {
            return Err(invalid("index.npy", format!("answer {at} is to ray {place} of {count}")));
        };
        if slot.status != Status::Unwritten as u32 {
            return Err(invalid("index.npy", format!("ray {place} is answered twice, so another one is missing")));
        }
        let is_hit = if is_any { occluded[at] } else { t[at] != f64::INFINITY };
        if !is_hit {
            *slot = Hit::miss(Status::Miss);
            continue;
        }
        let (t, primitive) =
            (t.get(at).map_or(ray.t_min, |t| *t as f32), triangles.as_ref().map_or(NO_PRIMITIVE, |of| of[at]));
        // No number lies in no span.
        if !(ray.t_min..=ray.t_max).contains(&t) {
            let span = format!("from {} to {}, the span of its ray", ray.t_min, ray.t_max);
            return Err(invalid("t.npy", format!("answer {at} is {t}: neither inf, for a miss, nor {span}")));
        }
        if primitive != NO_TRIANGLE && u64::from(primitive) >= set.manifest.scene.triangles {
            let of = set.manifest.scene.triangles;
            return Err(invalid("triangle.npy", format!("answer {at} is triangle {primitive} of {of}")));
        }
        *slot = Hit { t, primitive, u: 0.0, v: 0.0, status: Status::Hit as u32 };
    }
    let told = optional("times.json").map(|path| text(&path)).transpose()?;
    let self_reported = told.map(|told| serde_json::from_str::<SelfReported>(&told)).transpose();
    let self_reported = self_reported.map_err(|error| invalid("times.json", error.to_string()))?;
    let mut times = self_reported.iter().flat_map(|told| [told.build_ms, told.trace_ms]).flatten();
    if times.any(|ms| !(0.0..1e15).contains(&ms)) {
        return Err(invalid("times.json", "must be of milliseconds, 0 or more".to_owned()));
    }
    Ok(Answers { hits, names_triangles: triangles.is_some(), self_reported })
}
