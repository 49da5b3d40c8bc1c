//! Why a method's rays are wrong, shown by taking its known weaknesses away, one after the other, until none is left: what
//! is right from a rung of this ladder on was wrong for the weakness that the rung took away.

mod record;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use tracebench_api::{Hit, TracerError};

pub use record::{Explained, Explanation, RemedyRecord, SCHEMA, SceneExplained};

use crate::judge::{Class, Rule};
use crate::plan::{Plan, TracerRequest};
use crate::progress::Progress;
use crate::records;
use crate::registry::Device;
use crate::runner::{self, RunError};
use crate::session::{Contender, PreparedRays, Session};
use crate::truth::Cache;

/// A cause of wrong rays, and the parameter that takes it away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Remedy {
    /// The cause, as results name it.
    pub cause: &'static str,
    /// The tracer's parameter.
    pub parameter: &'static str,
    /// The value that takes the cause away.
    pub value: &'static str,
    /// Where the cause comes from.
    pub source: &'static str,
}

/// The weaknesses of a tracer in the order in which they are taken away; each rung keeps those before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ladder {
    /// The tracer.
    pub tracer: &'static str,
    /// Its rungs.
    pub remedies: &'static [Remedy],
}

/// Every ladder.
pub const LADDERS: &[Ladder] = &[Ladder {
    tracer: "dirt",
    remedies: &[
        Remedy {
            cause: "early_bucket_stop",
            parameter: "searched",
            value: "all",
            source: "DIRT, section 4.2.1, Algorithm 1, line 18: the search of a tile ends at the first bucket with a hit",
        },
        Remedy {
            cause: "pixel_acceptance",
            parameter: "accept",
            value: "distance",
            source: "DIRT, section 4.2.1, Algorithm 1, line 14: a hit counts only where its tile is the one searched",
        },
        Remedy {
            cause: "projection_noise_at_centre",
            parameter: "centre_rays",
            value: "split",
            source: "f32: near a view's centre the image of a ray is noise",
        },
        Remedy {
            cause: "near_plane",
            parameter: "near",
            value: "none",
            source: "DIRT, section 4.1: views are perspective, so nothing before their near planes is stored",
        },
    ],
}];

/// What no rung takes away.
pub const UNEXPLAINED: &str = "unexplained";

/// The ladder of a tracer.
pub fn ladder_of(tracer: &str) -> Option<&'static Ladder> {
    LADDERS.iter().find(|ladder| ladder.tracer == tracer)
}

/// The cause of a ray's error from whether it was wrong on each rung: the remedy after the last rung on which it was; none
/// for a ray that is right as the tracer was asked for and stays so.
fn cause(ladder: &Ladder, wrong: &[bool]) -> Option<&'static str> {
    let last = wrong.iter().rposition(|wrong| *wrong)?;
    Some(ladder.remedies.get(last).map_or(UNEXPLAINED, |remedy| remedy.cause))
}

/// Explains every wrong ray of the plan's tracer.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn execute(
    plan: &Plan,
    request: &TracerRequest,
    ladder: &Ladder,
    device: &Device,
    cache: &Cache,
    progress: &Progress,
) -> Result<Explanation, RunError> {
    let fail = |error: TracerError| RunError::Tracer { tracer: ladder.tracer.to_owned(), error };
    let rungs = rungs(request, ladder).map_err(fail)?;
    let description = (request.registration.describe)();
    let mut contender =
        Contender::create(description, request.parameters.clone(), || request.registration.create(device))
            .map_err(fail)?;
    let mut found = Explanation::begin(plan, request, ladder, device);
    for scene in runner::load(plan, progress)? {
        let loaded = runner::prepare(plan, scene, device, cache, progress)?;
        let session = &loaded.session;
        found.skipped.extend(session.skipped.iter().cloned());
        check_controls(session)?;
        // By ray set, then by rung: whether each ray is wrong, and of the first rung its class.
        let mut wrong: Vec<Vec<Vec<bool>>> = vec![Vec::new(); session.rays.len()];
        let mut classes: Vec<Vec<Class>> = Vec::new();
        let bar = progress.bar("rungs", (rungs.len() * session.rays.len()) as u64);
        for (rung, parameters) in rungs.iter().enumerate() {
            contender.parameters = parameters.clone();
            session.sample_build(&mut contender).map_err(fail)?;
            for (rays, wrong) in session.rays.iter().zip(&mut wrong) {
                let found = classes_of(session, &contender, rays)?;
                wrong.push(found.iter().map(|class| class.is_some_and(|class| !class.is_right())).collect());
                if rung == 0 {
                    classes.push(found.into_iter().map(|class| class.unwrap_or(Class::TrueMiss)).collect());
                }
                bar.inc(1);
            }
        }
        bar.finish_and_clear();
        let sets = session.rays.iter().zip(&wrong).zip(&classes);
        found.scenes.push(SceneExplained {
            scene: loaded.record.clone(),
            viewpoint: records::viewpoint_record(plan, &loaded.pose, session),
            sets: sets.map(|((rays, wrong), classes)| explained(ladder, rays, wrong, classes)).collect(),
        });
    }
    Ok(found)
}

/// The parameters of every rung, the first as asked for.
fn rungs(request: &TracerRequest, ladder: &Ladder) -> Result<Vec<tracebench_api::Parameters>, TracerError> {
    let mut request = request.clone();
    let mut rungs = vec![request.parameters.clone()];
    for remedy in ladder.remedies {
        request
            .set(remedy.parameter, remedy.value)
            .map_err(|error| TracerError::Failed(format!("{}: {error}", remedy.cause)))?;
        rungs.push(request.parameters.clone());
    }
    Ok(rungs)
}

/// The class of every answer under `tight`; none for ties.
fn classes_of(session: &Session, contender: &Contender, rays: &PreparedRays) -> Result<Vec<Option<Class>>, RunError> {
    let fail = |error: TracerError| RunError::Tracer { tracer: contender.description.name.to_owned(), error };
    let mut hits = session.hit_buffer(contender, rays).map_err(fail)?;
    session.sample_trace(contender, rays, &mut hits).map_err(fail)?;
    let hits: Vec<Hit> = hits.read(session.gpu()).map_err(fail)?;
    let classes = session.classes(contender, rays, Rule::Tight, &hits)?;
    Ok(classes)
}

/// The controls score what they must with these rays and this truth.
fn check_controls(session: &Session) -> Result<(), RunError> {
    for (control, mut contender) in session.controls() {
        session.sample_build(&mut contender)?;
        for rays in &session.rays {
            let mut hits = session.hit_buffer(&contender, rays)?;
            session.sample_trace(&contender, rays, &mut hits)?;
            let hits = hits.read(session.gpu())?;
            let judgement = session.judge(&contender, rays, &hits)?;
            let (occluded, free) = rays.hits_and_misses();
            control.check(&judgement, occluded, free).map_err(RunError::Control)?;
        }
    }
    Ok(())
}

fn explained(ladder: &Ladder, rays: &PreparedRays, wrong: &[Vec<bool>], classes: &[Class]) -> Explained {
    let mut causes: BTreeMap<String, BTreeMap<String, u64>> = BTreeMap::new();
    let (mut of_rung, mut on_the_way) = (vec![0_u64; wrong.len()], 0);
    for (ray, class) in classes.iter().enumerate() {
        let of_ray: Vec<bool> = wrong.iter().map(|rung| rung[ray]).collect();
        for (count, wrong) in of_rung.iter_mut().zip(&of_ray) {
            *count += u64::from(*wrong);
        }
        let Some(cause) = cause(ladder, &of_ray) else { continue };
        if of_ray[0] {
            let class = class.name(rays.set.query).to_owned();
            *causes.entry(class).or_default().entry(cause.to_owned()).or_default() += 1;
        } else {
            on_the_way += 1;
        }
    }
    Explained {
        rays: rays.set.name.to_owned(),
        rays_sha256: rays.sha256.clone(),
        query: rays.set.query,
        count: classes.len() as u64,
        ties: rays.answers.iter().filter(|answer| answer.tie).count() as u64,
        wrong_by_rung: of_rung,
        wrong_on_the_way: on_the_way,
        causes,
    }
}
