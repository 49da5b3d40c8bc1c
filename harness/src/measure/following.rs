//! The race of structures that follow an animation.

use tracebench_api::{Geometry, Update, Viewpoint};

use super::RunError;
use super::race::Race;
use crate::results::{RaceRecord, Sampling};

/// What the race is called.
pub(super) const UPDATES: &str = "updates";

impl Race<'_> {
    /// Lets those follow the film who do: one pass to warm up, then the counted ones; every pass begins with fresh builds over
    /// the first frame, outside of the times, but of what is reused. A round is a frame.
    pub(super) fn follow(&mut self, passes: u32) -> Result<Option<RaceRecord>, RunError> {
        let Some(film) = self.film else { return Ok(None) };
        let followers: Vec<usize> =
            (0..self.stalls.len()).filter(|stall| self.stalls[*stall].follows.is_some()).collect();
        let gpu = self.session.gpu();
        let (triangles, materials) = (film.triangles.clone(), film.materials.clone());
        let mut geometry = Geometry::with_materials(film.positions[0].clone(), triangles, materials, gpu)?;
        let steps = film.positions.len() as u64 * followers.len() as u64;
        let bar = self.progress.bar(UPDATES, steps * (u64::from(passes) + 1));
        let frames = film.positions.len().saturating_sub(1);
        let sampling = Sampling { least_rounds: passes * frames as u32, further: None };
        let seed = self.order_seed(UPDATES, 0);
        let sampling = (self.effort.timed && passes > 0).then_some(sampling);
        let mut rounds = self.rounds(seed, followers.len(), followers.iter().copied(), sampling);
        for pass in 0..=passes {
            for (frame, positions) in film.positions.iter().enumerate() {
                geometry = geometry.moved_to(positions.clone(), gpu)?;
                let counts = pass > 0 && frame > 0;
                // The first round warms up.
                let round = if counts || (pass, frame) == (0, 0) { rounds.next(gpu, || [Vec::new()])? } else { None };
                let order = round.map_or_else(|| (0..followers.len()).collect(), |round| round.order);
                for place in order {
                    let stall = followers[place];
                    let sample = self.attempt(stall, |one| match (frame, one.follows) {
                        // Nothing was done to it since.
                        (0, Some(Update::Reuse)) if pass > 0 => Ok(None),
                        (0, _) | (_, None) => {
                            let Viewpoint { frame, face, .. } = one.viewpoint;
                            let built_from =
                                film.built_from.map_or(one.viewpoint, |before| Viewpoint { frame, face, ..before });
                            one.contender.build(&geometry, &built_from, gpu).map(Some)
                        }
                        (_, Some(update)) => one.contender.update(update, &geometry, &one.viewpoint, gpu),
                    });
                    if let Some(sample) = sample.flatten().filter(|_| counts) {
                        self.stalls[stall].builds.push_update(sample);
                    }
                    bar.inc(1);
                }
            }
        }
        rounds.next(gpu, || [followers.iter().map(|stall| &self.stalls[*stall].builds.steady[..]).collect()])?;
        Ok(self.record(UPDATES, seed, &rounds, followers.iter().map(|stall| self.stall_label(*stall)).collect()))
    }
}
